//! Whether one detector of a run leads another, and on which scenes.

use super::judged_claim::Seen;
use crate::files::fixed_decimals::fixed_decimals;
use crate::numbers::tally::Tally;
use crate::uncertainty::sample::{Draw, Question};
use crate::verdicts::paired_difference::{PairedDifference, paired_difference};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// Two detectors of a run in one task.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// The task.
    pub task: Task,
    /// Who is to lead.
    pub method: &'a str,
    /// Whom.
    pub rival: &'a str,
}

/// A run whose detectors are compared.
pub struct LeadsOf<'a> {
    tally: &'a Tally,
    draws: Vec<Draw>,
}

/// What lies between two detectors on one data set, or on several together.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneLead {
    /// The data set.
    pub scene: String,
    /// The rate of the rival, and that of the method.
    pub difference: PairedDifference,
}

impl<'a> LeadsOf<'a> {
    /// Those of the run of this tally.
    pub fn new(tally: &'a Tally) -> Self {
        Self { draws: tally.draw(), tally }
    }

    /// What lies between `pair`, by `metric`, on each data set whose name has `part` in it.
    pub fn on_scenes(&self, pair: Pair<'_>, metric: &Metric, part: &str) -> Vec<SceneLead> {
        let scenes = self.tally.datasets().iter().filter(|it| it.contains(part));
        scenes.filter_map(|it| self.on(pair, metric, it)).collect()
    }

    /// The same on all data sets of one origin together.
    pub fn overall(&self, pair: Pair<'_>, metric: &Metric) -> Vec<SceneLead> {
        self.tally.pools().iter().filter_map(|it| self.on(pair, metric, it.extent.name())).collect()
    }

    fn on(&self, pair: Pair<'_>, metric: &Metric, dataset: &str) -> Option<SceneLead> {
        let Pair { task, method, rival } = pair;
        let sample = |detector| {
            self.tally.sample(&Question { dataset, task, detector, slice: Slice::All }, &self.draws)
        };
        let difference = paired_difference(&sample(rival)?, &sample(method)?, metric)?;
        Some(SceneLead { scene: dataset.to_owned(), difference })
    }
}

/// What is seen of a lead that is to be there on each of `leads`.
pub fn seen(reading: &str, leads: &[SceneLead]) -> Seen {
    let percent = |it: f64| fixed_decimals(100.0 * it, 1);
    let name = |it: &SceneLead| if leads.len() > 1 { format!("{}: ", it.scene) } else { String::new() };
    let numbers = leads.iter().map(|it| {
        format!("{}{} against {}", name(it), percent(it.difference.after), percent(it.difference.before))
    });
    let differences = leads.iter().map(|it| {
        let ends = it
            .difference
            .interval
            .map_or_else(String::new, |it| format!(" ({} to {})", percent(it.ends[0]), percent(it.ends[1])));
        let sign = if it.difference.difference() > 0.0 { "+" } else { "" };
        format!("{sign}{}{ends}", percent(it.difference.difference()))
    });
    // Nothing rests on blocks of scans that are too few.
    let is_known = |it: &SceneLead| it.difference.interval.is_some_and(|it| !it.blocks.decide_nothing());
    let is_known = !leads.is_empty() && leads.iter().all(is_known);
    let holds = is_known.then(|| leads.iter().all(|it| it.difference.is_surely_larger()));
    Seen {
        reading: reading.to_owned(),
        numbers: numbers.collect::<Vec<_>>().join("; "),
        difference: differences.collect::<Vec<_>>().join("; "),
        holds,
    }
}
