//! How long detectors take beside the reference, held to a tolerance.

use crate::numbers::blocks::Interval;
use crate::run_folder::manifest::Machine;
use crate::uncertainty::bootstrap::Distribution;
use crate::uncertainty::sample::{Question, Sample};
use crate::verdicts::finding::Finding;
use crate::verdicts::gated_metrics::{Missing, Sides, about};
use crate::verdicts::tolerances::SpeedRule;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;

/// How long a detector takes, divided by how long the reference takes on the same scans: the geometric mean over scans.
#[derive(Debug, Clone, PartialEq)]
pub struct GatedSpeed {
    /// Name of the data sets that it is about, where recorded and simulated ones are judged apart.
    pub on: Option<String>,
    /// Name of the detector.
    pub detector: String,
    /// Name of the reference.
    pub reference: String,
    /// Before and after, or where there is no number.
    pub slowdown: Result<Slowdown, Missing>,
    /// How much slower it may become, as a share.
    pub tolerance: f64,
    /// What that means.
    pub finding: Finding,
}

impl GatedSpeed {
    /// What it is about: the detector, and the data sets if there are others.
    pub fn about(&self) -> String {
        about(&self.detector, self.on.as_deref())
    }
}

/// Two ratios of times, and what lies between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Slowdown {
    /// The ratio in the baseline.
    pub before: f64,
    /// The ratio in the run.
    pub after: f64,
    /// How sure [`Self::share`] is.
    pub interval: Option<Interval>,
}

impl Slowdown {
    /// How much slower it has become, as a share: 0.1 is a tenth slower.
    pub fn share(&self) -> f64 {
        self.after / self.before - 1.0
    }
}

/// Whether times were compared.
#[derive(Debug, Clone, PartialEq)]
pub enum SpeedComparison {
    /// No rule is about them.
    NotAsked,
    /// They mean nothing beside each other.
    NotCompared {
        /// Why.
        reason: String,
    },
    /// They were, detector by detector.
    Compared(Vec<GatedSpeed>),
}

impl SpeedComparison {
    /// What was compared.
    pub fn speeds(&self) -> &[GatedSpeed] {
        match self {
            Self::NotAsked | Self::NotCompared { .. } => &[],
            Self::Compared(speeds) => speeds,
        }
    }
}

impl Sides<'_> {
    /// Every detector of the baseline that `rule` is about, held to it. Ratios of times are those of a processor: `machines` are those of the
    /// baseline and of the run.
    pub(super) fn gated_speeds(&self, rule: Option<&SpeedRule>, machines: [&Machine; 2]) -> SpeedComparison {
        let Some(rule) = rule else { return SpeedComparison::NotAsked };
        let [before, after] = machines.map(|it| &it.cpu_model);
        if before != after {
            let reason = format!("the processor changed from {before:?} to {after:?}");
            return SpeedComparison::NotCompared { reason };
        }
        // Every task has the same times.
        let task = self.before.tasks().first();
        let speeds = self.judged().into_iter().flat_map(|(dataset, on)| {
            let detectors = self.before.detectors().iter().filter(|it| rule.is_about(it));
            let speeds = detectors.filter_map(|detector| {
                let question = Question { dataset: &dataset, task: *task?, detector, slice: Slice::All };
                Some(GatedSpeed { on: on.clone(), ..self.gated_speed(&question, rule) })
            });
            speeds.collect::<Vec<_>>()
        });
        SpeedComparison::Compared(speeds.collect())
    }

    fn gated_speed(&self, question: &Question<'_>, rule: &SpeedRule) -> GatedSpeed {
        let [before, after] = [self.before, self.after].map(|it| {
            let sample = it.sample(question, self.draws)?;
            Some((sample.value(&Metric::TimeRatio)?, sample))
        });
        let slowdown = match (before, after) {
            (Some(before), Some(after)) => Ok(slowdown(&before, &after)),
            (Some(_), None) => Err(Missing::InRun),
            (None, Some(_)) => Err(Missing::InBaseline),
            (None, None) => Err(Missing::InBoth),
        };
        let finding = slowdown.as_ref().map_or(Finding::Incomparable, |it| {
            let sure = it.interval.filter(|it| !it.blocks.decide_nothing()).map(|it| it.ends[0]);
            Finding::of(it.share(), sure, rule.relative)
        });
        let [detector, reference] = [question.detector, &rule.reference].map(str::to_owned);
        GatedSpeed { on: None, detector, reference, slowdown, tolerance: rule.relative, finding }
    }
}

fn slowdown(before: &(f64, Sample), after: &(f64, Sample)) -> Slowdown {
    let metric = Metric::TimeRatio;
    let of_resamples = before.1.resampled_values(&metric).zip(after.1.resampled_values(&metric));
    let shares = of_resamples.map(|(before, after)| Some(after? / before? - 1.0));
    let interval = Distribution::new(shares, before.1.blocks).map(|it| it.interval());
    Slowdown { before: before.0, after: after.0, interval }
}
