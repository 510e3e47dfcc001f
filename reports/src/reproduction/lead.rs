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

/// Name and basis of a reading of a paper.
pub type Reading<'a> = (&'a str, Basis);

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

    /// Differences of `pair` in `metric` on `scenes`: `every` data set, `overall`, or those whose name has it as a part.
    pub fn on_all(&self, pair: Pair<'_>, metric: &Metric, scenes: &str) -> Vec<SceneLead> {
        match scenes {
            "every" => self.on_scenes(pair, metric, ""),
            "overall" => self.overall(pair, metric),
            part => self.on_scenes(pair, metric, part),
        }
    }

    /// By how much `pair` leads by more in F-rate on each data set whose name has one of `parts` in it than on each other of
    /// its origin. Where the method is behind, its lead is 0.
    pub fn most(&self, pair: Pair<'_>, parts: &[String]) -> Vec<SceneLead> {
        let mut all = Vec::new();
        for pool in self.tally.pools() {
            let is_named = |it: &&String| parts.iter().any(|part| it.contains(part.as_str()));
            let (named, others): (Vec<_>, Vec<_>) = pool.datasets.iter().partition(is_named);
            let pairs =
                named.iter().flat_map(|named| others.iter().map(|other| [other.as_str(), named.as_str()]));
            all.extend(pairs.filter_map(|scenes| self.more(pair, scenes)));
        }
        all
    }

    /// The lead on the second of `scenes` over that on the first, each with draws of its own.
    fn more(&self, pair: Pair<'_>, scenes: [&str; 2]) -> Option<SceneLead> {
        let Pair { task, method, rival } = pair;
        let samples =
            |dataset, detector| self.sample(&Question { dataset, task, detector, slice: Slice::All });
        let [[rival_0, method_0], [rival_1, method_1]] =
            scenes.map(|scene| [rival, method].map(|it| samples(scene, it)));
        let of_scenes = [[rival_0?, method_0?], [rival_1?, method_1?]];
        let metric = &Metric::FRate;
        let [less, more] = &of_scenes;
        let lead = |[rival, method]: &[Sample; 2]| Some(method.value(metric)? - rival.value(metric)?);
        let drawn = |[rival, method]: &[Sample; 2]| -> Vec<Option<f64>> {
            let both = rival.resampled_values(metric).zip(method.resampled_values(metric));
            both.map(|(rival, method)| Some(method? - rival?)).collect()
        };
        let least = |lead: f64| lead.max(0.0);
        let draws = drawn(less).into_iter().map(|it| it.map(least)).zip(drawn(more));
        let blocks = of_scenes.iter().map(|it| it[0].blocks).min_by_key(|it| it.degrees_of_freedom);
        let leads = [least(lead(less)?), lead(more)?];
        let difference = PairedDifference::new(metric, leads, draws, blocks);
        Some(SceneLead { scene: format!("{} over {}", scenes[1], scenes[0]), difference })
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

    fn difference_in_words(&self) -> String {
        let ends = self
            .difference
            .interval
            .map_or_else(String::new, |it| format!(" ({} to {})", percent(it.ends[0]), percent(it.ends[1])));
        format!("{}{ends}", signed_percent(self.difference.difference()))
    }
}

/// Result under `reading` for a lead that is claimed on each of `leads`.
pub fn seen((reading, basis): Reading<'_>, leads: &[SceneLead]) -> Seen {
    let name = |it: &SceneLead| if leads.len() > 1 { format!("{}: ", it.scene) } else { String::new() };
    let numbers = leads.iter().map(|it| {
        format!("{}{} against {}", name(it), percent(it.difference.after), percent(it.difference.before))
    });
    let differences = leads.iter().map(SceneLead::difference_in_words);
    Seen {
        reading: reading.to_owned(),
        basis,
        numbers: numbers.collect::<Vec<_>>().join("; "),
        difference: differences.collect::<Vec<_>>().join("; "),
        holds: holds_on_all(leads, PairedDifference::is_surely_larger),
    }
}

/// Result under `reading` for a lead that is claimed to be greater on some scenes: `leads` on all, and `most`, by how much.
pub fn seen_most((reading, basis): Reading<'_>, leads: &[SceneLead], most: &[SceneLead]) -> Seen {
    let numbers =
        leads.iter().map(|it| format!("{}: {}", it.scene, signed_percent(it.difference.difference())));
    let differences = most.iter().map(|it| format!("{} {}", it.scene, it.difference_in_words()));
    Seen {
        reading: reading.to_owned(),
        basis,
        numbers: numbers.collect::<Vec<_>>().join("; "),
        difference: differences.collect::<Vec<_>>().join("; "),
        holds: holds_on_all(most, PairedDifference::is_surely_larger),
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
    use crate::rows::counts::Counts;
    use crate::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow};

    fn lead(scene: &str, after: f64, low: f64, n_blocks: u64) -> SceneLead {
        let blocks = BlockCount { n_blocks, degrees_of_freedom: n_blocks - 1, kind: BlockKind::Drives };
        let interval = Some(Interval { ends: [low, 0.5], blocks });
        let difference =
            PairedDifference { metric: Metric::FRate, before: 0.5, after, interval, least_effect: None };
        SceneLead { scene: scene.to_owned(), difference }
    }

    #[test]
    fn a_lead_holds_if_it_is_sure_on_every_scene_and_few_blocks_say_nothing() {
        let holds = |leads: &[SceneLead]| seen(("good faith", Basis::Text), leads).holds;
        assert_eq!(holds(&[lead("a", 0.75, 0.1, 30), lead("b", 0.6, 0.01, 30)]), Some(true));
        assert_eq!(holds(&[lead("a", 0.75, 0.1, 30), lead("b", 0.6, -0.01, 30)]), Some(false));
        assert_eq!(holds(&[lead("a", 0.75, 0.1, 2)]), None);
        assert_eq!(holds(&[lead("a", 0.75, 0.1, 30), lead("b", 0.75, 0.1, 2)]), None);
        // The known scene refutes it.
        assert_eq!(holds(&[lead("a", 0.75, -0.1, 30), lead("b", 0.75, 0.1, 2)]), Some(false));
        assert_eq!(holds(&[]), None);
        let both =
            seen(("good faith", Basis::Text), &[lead("a", 0.75, 0.125, 30), lead("b", 0.25, -0.5, 30)]);
        assert_eq!(both.numbers, "a: 75.0 against 50.0; b: 25.0 against 50.0");
        assert_eq!(both.difference, "+25.0 (12.5 to 50.0); -25.0 (-50.0 to 50.0)");
    }
    /// Whether method and rival find all objects of a drive.
    type FindAll = fn(u32) -> [bool; 2];

    /// Twelve drives of each data set, in each of which a detector finds all of ten objects, or five and five false ones: an
    /// F-rate of 1, or of 0.5.
    fn tally_of(scenes: &[(&str, FindAll)]) -> Tally {
        let mut tally = Tally::default();
        for (scene, finds_all) in scenes {
            for drive in 0..12 {
                for (detector, finds_all) in ["method", "rival"].into_iter().zip(finds_all(drive)) {
                    let (tp, fo) = if finds_all { (10, 0) } else { (5, 5) };
                    let numbers = ScanNumbers::of_counts(Counts::new(10, tp, Some(fo)).unwrap());
                    tally.add_scan(&ScanRow {
                        dataset: (*scene).to_owned(),
                        sequence: format!("{drive:04}"),
                        scan: 0,
                        time_s: Some(0.0),
                        detector: detector.to_owned(),
                        task: Task::Vehicles,
                        outcome: ScanOutcome::Evaluated(numbers),
                    });
                }
            }
        }
        tally
    }

    #[test]
    fn a_lead_is_greater_where_it_surely_is_and_who_is_behind_has_none() {
        let pair = Pair { task: Task::Vehicles, method: "method", rival: "rival" };
        let most = |tally: &Tally, part: &str| {
            let leads = LeadsOf::new(tally);
            let most = leads.most(pair, &[part.to_owned()]);
            seen_most(("good faith", Basis::Text), &leads.on_scenes(pair, &Metric::FRate, ""), &most)
        };
        let tally = tally_of(&[
            ("narrow", |_| [true, false]),
            ("main", |_| [false, false]),
            ("open", |_| [false, true]),
        ]);
        let narrow = most(&tally, "narrow");
        assert_eq!(narrow.numbers, "narrow: +50.0; main: 0.0; open: -50.0");
        let expected = "narrow over main +50.0 (50.0 to 50.0); narrow over open +50.0 (50.0 to 50.0)";
        assert_eq!((narrow.difference.as_str(), narrow.holds), (expected, Some(true)));
        assert_eq!(most(&tally, "main").holds, Some(false));
        // It leads on two of twelve drives: on average, but not surely.
        let seldom = tally_of(&[("narrow", |drive| [drive < 2, false]), ("main", |_| [false, false])]);
        let narrow = most(&seldom, "narrow");
        assert!(narrow.difference.starts_with("narrow over main +8.3 (0.0 to "), "{}", narrow.difference);
        assert_eq!(narrow.holds, Some(false));
        // Nothing is said of what is not there.
        assert_eq!(most(&seldom, "intersection").holds, None);
    }
}
