//! Whether one detector of a run leads another, and on which scenes.

use super::judged_claim::Seen;
use super::steps::Basis;
use crate::files::fixed_decimals::{percent, signed_percent};
use crate::numbers::tally::Tally;
use crate::uncertainty::sample::{Draw, Question, Sample};
use crate::verdicts::paired_difference::{PairedDifference, paired_difference};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// Two detectors of a run in one task.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// The task.
    pub task: Task,
    /// The detector that is to lead.
    pub method: &'a str,
    /// Its rival.
    pub rival: &'a str,
}

/// A run whose detectors are compared.
pub struct LeadsOf<'a> {
    tally: &'a Tally,
    draws: Vec<Draw>,
}

/// Difference between two detectors on one data set, or on several together.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneLead {
    /// The data set.
    pub scene: String,
    /// The rate of the rival, and that of the method.
    pub difference: PairedDifference,
}

impl<'a> LeadsOf<'a> {
    /// The leads in the run of this tally.
    pub fn new(tally: &'a Tally) -> Self {
        Self { draws: tally.draw(), tally }
    }

    /// Differences of `pair` in `metric` on each data set whose name has `part` in it.
    pub fn on_scenes(&self, pair: Pair<'_>, metric: &Metric, part: &str) -> Vec<SceneLead> {
        let scenes = self.tally.datasets().iter().filter(|it| it.contains(part));
        scenes.filter_map(|it| self.on(pair, metric, it)).collect()
    }

    /// Differences of `pair` in `metric` on all data sets of one origin together.
    pub fn overall(&self, pair: Pair<'_>, metric: &Metric) -> Vec<SceneLead> {
        self.tally.pools().iter().filter_map(|it| self.on(pair, metric, it.extent.name())).collect()
    }

    /// Sums for `question`, with the draws that leads are judged by; `None` if there are no rows of the kind.
    pub fn sample(&self, question: &Question<'_>) -> Option<Sample> {
        self.tally.sample(question, &self.draws)
    }

    fn on(&self, pair: Pair<'_>, metric: &Metric, dataset: &str) -> Option<SceneLead> {
        let Pair { task, method, rival } = pair;
        let sample = |detector| self.sample(&Question { dataset, task, detector, slice: Slice::All });
        let difference = paired_difference(&sample(rival)?, &sample(method)?, metric)?;
        Some(SceneLead { scene: dataset.to_owned(), difference })
    }
}

impl SceneLead {
    /// Whether there are enough blocks of scans for anything to rest on the interval.
    pub fn is_known(&self) -> bool {
        self.difference.interval.is_some_and(|it| !it.blocks.decide_nothing())
    }
}

/// Result under `reading` for a lead that is claimed on each of `leads`.
pub fn seen(reading: &str, basis: Basis, leads: &[SceneLead]) -> Seen {
    let name = |it: &SceneLead| if leads.len() > 1 { format!("{}: ", it.scene) } else { String::new() };
    let numbers = leads.iter().map(|it| {
        format!("{}{} against {}", name(it), percent(it.difference.after), percent(it.difference.before))
    });
    let differences = leads.iter().map(|it| {
        let ends = it
            .difference
            .interval
            .map_or_else(String::new, |it| format!(" ({} to {})", percent(it.ends[0]), percent(it.ends[1])));
        format!("{}{ends}", signed_percent(it.difference.difference()))
    });
    Seen {
        reading: reading.to_owned(),
        basis,
        numbers: numbers.collect::<Vec<_>>().join("; "),
        difference: differences.collect::<Vec<_>>().join("; "),
        holds: holds_on_all(leads, PairedDifference::is_surely_larger),
    }
}

/// Whether the claim `is_so` on every scene: a known scene where it is not refutes it. Nothing rests on too few blocks of
/// scans, so without a refutation the result is unknown if a scene has too few of them, or if there is no scene.
pub fn holds_on_all(leads: &[SceneLead], is_so: impl Fn(&PairedDifference) -> bool) -> Option<bool> {
    if leads.iter().any(|it| it.is_known() && !is_so(&it.difference)) {
        return Some(false);
    }
    (!leads.is_empty() && leads.iter().all(SceneLead::is_known)).then_some(true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::blocks::{BlockCount, BlockKind, Interval};

    fn lead(scene: &str, after: f64, low: f64, n_blocks: u64) -> SceneLead {
        let blocks = BlockCount { n_blocks, degrees_of_freedom: n_blocks - 1, kind: BlockKind::Drives };
        let interval = Some(Interval { ends: [low, 0.5], blocks });
        let difference =
            PairedDifference { metric: Metric::FRate, before: 0.5, after, interval, least_effect: None };
        SceneLead { scene: scene.to_owned(), difference }
    }

    #[test]
    fn a_lead_holds_if_it_is_sure_on_every_scene_and_few_blocks_say_nothing() {
        let holds = |leads: &[SceneLead]| seen("good faith", Basis::Text, leads).holds;
        assert_eq!(holds(&[lead("a", 0.75, 0.1, 30), lead("b", 0.6, 0.01, 30)]), Some(true));
        assert_eq!(holds(&[lead("a", 0.75, 0.1, 30), lead("b", 0.6, -0.01, 30)]), Some(false));
        assert_eq!(holds(&[lead("a", 0.75, 0.1, 2)]), None);
        assert_eq!(holds(&[lead("a", 0.75, 0.1, 30), lead("b", 0.75, 0.1, 2)]), None);
        // The known scene refutes it.
        assert_eq!(holds(&[lead("a", 0.75, -0.1, 30), lead("b", 0.75, 0.1, 2)]), Some(false));
        assert_eq!(holds(&[]), None);
        let both = seen("good faith", Basis::Text, &[lead("a", 0.75, 0.125, 30), lead("b", 0.25, -0.5, 30)]);
        assert_eq!(both.numbers, "a: 75.0 against 50.0; b: 25.0 against 50.0");
        assert_eq!(both.difference, "+25.0 (12.5 to 50.0); -25.0 (-50.0 to 50.0)");
    }
}
