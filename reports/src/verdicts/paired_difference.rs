//! Differences between two numbers that were measured on the same scans, and how sure they are.

use crate::numbers::blocks::{BlockCount, Interval};
use crate::uncertainty::bootstrap::Distribution;
use crate::uncertainty::sample::Sample;
use crate::vocabulary::metric::{Direction, Metric};

/// A number before and after, or of one detector and of another.
#[derive(Debug, Clone, PartialEq)]
pub struct PairedDifference {
    /// The metric.
    pub metric: Metric,
    /// The number that is compared with.
    pub before: f64,
    /// The number that is compared.
    pub after: f64,
    /// How sure [`Self::difference`] is: both are of the same resamples. `None` where a data set has one block of scans
    /// only.
    pub interval: Option<Interval>,
    /// The least difference that scans like these would show, see [`Distribution::least_effect`].
    pub least_effect: Option<f64>,
}

/// The difference between `before` and `after`, samples of the same draws of the same scans.
///
/// `None` if the metric is undefined in one of them.
pub fn paired_difference(before: &Sample, after: &Sample, metric: &Metric) -> Option<PairedDifference> {
    let values = [before.value(metric)?, after.value(metric)?];
    let of_resamples = before.resampled_values(metric).zip(after.resampled_values(metric));
    Some(PairedDifference::new(metric, values, of_resamples, Some(before.blocks)))
}

/// `after` - `before`; of times over those of the reference, the share by which they are longer.
fn between(metric: &Metric, before: f64, after: f64) -> f64 {
    if *metric == Metric::TimeRatio { after / before - 1.0 } else { after - before }
}

impl PairedDifference {
    /// The difference between two values, with its interval from those of the same draws from `blocks`.
    pub(crate) fn new(
        metric: &Metric,
        [before, after]: [f64; 2],
        of_draws: impl Iterator<Item = (Option<f64>, Option<f64>)>,
        blocks: Option<BlockCount>,
    ) -> Self {
        let differences = of_draws.map(|(before, after)| Some(between(metric, before?, after?)));
        let distribution = blocks.and_then(|it| Distribution::new(differences, it));
        Self {
            metric: metric.clone(),
            before,
            after,
            interval: distribution.as_ref().map(Distribution::interval),
            least_effect: distribution.as_ref().map(Distribution::least_effect),
        }
    }

    /// `after` - `before`. Of times over those of the reference it is a share: 0.1 is a tenth slower.
    pub fn difference(&self) -> f64 {
        between(&self.metric, self.before, self.after)
    }

    /// How much worse it has become: positive is worse, whichever way is better. A metric that has no better way is never
    /// worse.
    pub fn worsening(&self) -> f64 {
        self.sign() * self.difference()
    }

    /// How much worse it has become at least: the lower end of the 95 % interval of [`Self::worsening`]. `None` where there
    /// is no interval, or nothing may rest on the blocks of scans that it is of.
    pub fn sure_worsening(&self) -> Option<f64> {
        let interval = self.interval.filter(|it| !it.blocks.decide_nothing())?;
        interval.ends.map(|it| self.sign() * it).into_iter().reduce(f64::min)
    }

    /// Whether it has surely become better, by however little.
    pub fn is_surely_better(&self) -> bool {
        let surely = self.interval.filter(|it| !it.blocks.decide_nothing());
        surely.is_some_and(|it| it.ends.iter().all(|end| self.sign() * end < 0.0))
    }

    /// Whether `after` is surely larger than `before`.
    pub fn is_surely_larger(&self) -> bool {
        self.interval.is_some_and(|it| !it.blocks.decide_nothing() && it.ends[0] > 0.0)
    }

    fn sign(&self) -> f64 {
        match self.metric.direction() {
            Direction::HigherIsBetter => -1.0,
            Direction::LowerIsBetter => 1.0,
            Direction::Neither => 0.0,
        }
    }
}
