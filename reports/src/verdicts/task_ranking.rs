//! The best detector, its lead and how sure it is, and the fastest detectors: a run in a few sentences.

use crate::files::fixed_decimals::{fixed_decimals, three_digits};
use crate::numbers::blocks::Interval;
use crate::numbers::pools::Pool;
use crate::numbers::run_report::{MetricRow, RunReport, Subject};
use crate::numbers::tally::Tally;
use crate::run_folder::manifest::{DatasetEntry, Manifest};
use crate::uncertainty::sample::{Draw, Question};
use crate::verdicts::paired_difference::{PairedDifference, paired_difference};
use crate::verdicts::times_doubt::share_on_busy_machine;
use crate::vocabulary::metric::Metric;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// The ranking of the detectors of a run in one task, over all its data sets of one origin together.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskRanking {
    /// The task.
    pub task: Task,
    /// The data sets.
    pub pool: Pool,
    /// Whether there are data sets of another origin, too, with a ranking of their own.
    pub has_others: bool,
    /// The metric that they are ordered by: the F-rate or, where false objects cannot be known, recall.
    pub metric: Metric,
    /// The detectors, best first; those of which the metric is undefined are last.
    pub detectors: Vec<RankedDetector>,
    /// The difference between the first and the second.
    pub lead: Option<PairedDifference>,
    /// Data sets whose frame or labels are suspect.
    pub suspect: Vec<String>,
    /// Data sets whose labels are suspect, but right as the user says.
    pub overruled: Vec<String>,
}

/// The score of one detector.
#[derive(Debug, Clone, PartialEq)]
pub struct RankedDetector {
    /// Its name.
    pub detector: String,
    /// The metric; `None` where it is undefined.
    pub value: Option<f64>,
    /// How sure it is.
    pub interval: Option<Interval>,
    /// Its false detections; `None` where these cannot be known.
    pub n_false: Option<u64>,
    /// Scans that it gave no answer to, and all its scans; `None` if it answered all.
    pub failed_scans: Option<[u64; 2]>,
}

/// How long detectors take for a scan of data sets of one origin.
#[derive(Debug, Clone, PartialEq)]
pub struct Speeds {
    /// The data sets, where there are others.
    pub on: Option<String>,
    /// Name and mean time in milliseconds, the fastest first.
    pub means_ms: Vec<(String, f64)>,
    /// Whether the machine was busy, so that they are unreliable.
    pub is_doubted: bool,
}

/// Where the scans of a run come from.
pub fn origin_of_run(manifest: &Manifest) -> Origin {
    manifest.datasets.iter().map(DatasetEntry::origin).reduce(Origin::with).unwrap_or(Origin::Recorded)
}

/// The rankings in all tasks of a run: one for the recorded data sets, and one for the simulated ones.
pub fn rankings(tally: &Tally, draws: &[Draw], manifest: &Manifest, report: &RunReport) -> Vec<TaskRanking> {
    let pools = tally.pools();
    let ranking = |task: Task, pool: &Pool| {
        let dataset = pool.extent.name();
        let row =
            |detector: &str, metric: &Metric| report.row(&Subject::of_all(dataset, task, detector), metric);
        let has_f_rate =
            tally.detectors().iter().all(|it| row(it, &Metric::FRate).is_some_and(|it| it.value().is_some()));
        let value = |detector: &str, metric: &Metric| row(detector, metric).and_then(MetricRow::value);
        // Where nothing is annotated, a rate tells no detector from another.
        let has_f_rate =
            has_f_rate && tally.detectors().iter().any(|it| value(it, &Metric::Recall).is_some());
        let metric = if has_f_rate { Metric::FRate } else { Metric::Recall };
        let mut detectors: Vec<RankedDetector> = tally
            .detectors()
            .iter()
            .map(|detector| {
                let n_false = value(detector, &Metric::Fo).map(|it| it as u64);
                let row = row(detector, &metric);
                let (value, interval) = (row.and_then(MetricRow::value), row.and_then(MetricRow::interval));
                let is_here = |it: &str| pool.datasets.iter().any(|id| id == it);
                let failed_scans = report.failed_scans(is_here, task, detector);
                RankedDetector { detector: detector.clone(), value, interval, n_false, failed_scans }
            })
            .collect();
        detectors.sort_by(|a, b| {
            let rank = |it: &RankedDetector| it.value.unwrap_or(f64::NEG_INFINITY);
            rank(b).total_cmp(&rank(a))
        });
        let lead = detectors.get(1).and_then(|second| {
            let sample =
                |detector| tally.sample(&Question { dataset, task, detector, slice: Slice::All }, draws);
            paired_difference(&sample(&second.detector)?, &sample(&detectors[0].detector)?, &metric)
        });
        let suspect = those_with(manifest, pool, |it| &it.doubts);
        let overruled = those_with(manifest, pool, |it| &it.overruled_doubts);
        let (pool, has_others) = (pool.clone(), pools.len() > 1);
        TaskRanking { task, pool, has_others, metric, detectors, lead, suspect, overruled }
    };
    let of_task = |task: &Task| pools.iter().map(|it| ranking(*task, it)).collect::<Vec<_>>();
    tally.tasks().iter().filter(|it| it.class().is_none()).flat_map(of_task).collect()
}

/// The data sets of `pool` that have any of these `doubts`.
fn those_with(manifest: &Manifest, pool: &Pool, doubts: fn(&DatasetEntry) -> &Vec<String>) -> Vec<String> {
    let datasets = manifest.datasets.iter().filter(|it| pool.datasets.contains(&it.id));
    datasets.filter(|it| !doubts(it).is_empty()).map(|it| it.id.clone()).collect()
}

/// How long the detectors of a run take: on the recorded data sets, and on the simulated ones.
pub fn speeds(manifest: &Manifest, report: &RunReport) -> Vec<Speeds> {
    let pools = manifest.pools();
    let speeds = pools.iter().map(|pool| {
        // That of the column `fps` of tables.
        let mean = |detector: &str| {
            let subject = Subject::of_all(pool.extent.name(), report.first_task()?, detector);
            Some(1e3 / report.row(&subject, &Metric::FpsMean)?.value()?)
        };
        let names = manifest.detectors.iter().map(|it| &it.name);
        let mut means_ms: Vec<(String, f64)> = names
            .filter_map(|name| Some((name.clone(), mean(name).filter(|it| it.is_finite() && *it > 0.0)?)))
            .collect();
        means_ms.sort_by(|a, b| a.1.total_cmp(&b.1));
        let is_busy =
            |id: &String| manifest.detectors.iter().any(|it| share_on_busy_machine(report, id, it).is_some());
        let is_doubted = pool.datasets.iter().any(is_busy);
        Speeds { on: (pools.len() > 1).then(|| pool.in_words()), means_ms, is_doubted }
    });
    speeds.collect()
}

impl TaskRanking {
    /// The leading detector, in a sentence. A second sentence is about the detectors that the first does not name, and one
    /// more about each detector that gave no answer to some scans.
    pub fn sentence(&self) -> String {
        let of_rates = self.sentence_of_rates() + &self.sentence_of_others();
        of_rates + &self.sentence_of_failures() + &self.sentence_of_overruled()
    }

    /// The text of [`Self::sentence`] without its second sentence, where a table is above it.
    pub fn short_sentence(&self) -> String {
        self.sentence_of_rates() + &self.sentence_of_failures() + &self.sentence_of_overruled()
    }

    fn sentence_of_overruled(&self) -> String {
        if self.overruled.is_empty() || !self.suspect.is_empty() {
            return String::new();
        }
        format!(" Doubts about the labels of {} were overruled.", self.overruled.join(", "))
    }

    fn sentence_of_failures(&self) -> String {
        let failed = self.detectors.iter().filter_map(|it| {
            let [n_failed, n_scans] = it.failed_scans?;
            let name = &it.detector;
            Some(format!(
                " But {name} failed at {n_failed} of {n_scans} scans, which count as nothing found."
            ))
        });
        failed.collect()
    }

    /// The values of the detectors after the first two, and the detectors without a value; empty where no detector has one.
    fn sentence_of_others(&self) -> String {
        let is_defined = |it: &&RankedDetector| it.value.is_some();
        if !self.suspect.is_empty() || !self.detectors.iter().any(|it| is_defined(&it)) {
            return String::new();
        }
        let defined = self.detectors.iter().filter(is_defined).skip(2);
        let others: Vec<String> = defined.map(|it| format!("{} {}", it.detector, it.text())).collect();
        let undefined = self.detectors.iter().filter(|it| it.value.is_none());
        let undefined: Vec<&str> = undefined.map(|it| it.detector.as_str()).collect();
        let sentence = |head: &str, list: String| {
            if list.is_empty() { list } else { format!(" {head}: {list}.") }
        };
        sentence("Then", others.join(", ")) + &sentence("Undefined", undefined.join(", "))
    }

    /// The task, and the data sets.
    fn about(&self) -> String {
        let on = match self.pool.origin {
            _ if self.has_others => format!(" on {}", self.pool.in_words()),
            origin => origin.in_brackets(),
        };
        format!("Task {}{on}: ", self.task)
    }

    /// The number of false detections of each detector; `None` where these cannot be known.
    fn false_detections(&self) -> Option<String> {
        let counts = self.detectors.iter().map(|it| Some(format!("{} {}", it.detector, it.n_false?)));
        Some(counts.collect::<Option<Vec<_>>>()?.join(", "))
    }

    fn sentence_without_rates(&self, metric: &str) -> String {
        let about = self.about();
        match self.false_detections() {
            Some(counts) => format!("{about}nothing is annotated that counts; false detections: {counts}."),
            None => format!("{about}{metric} is undefined."),
        }
    }

    fn sentence_of_rates(&self) -> String {
        let about = self.about();
        let metric = match self.metric {
            Metric::FRate => "F-rate",
            _ => "recall",
        };
        let defined: Vec<&RankedDetector> = self.detectors.iter().filter(|it| it.value.is_some()).collect();
        match (&defined[..], &self.lead) {
            ([], _) => self.sentence_without_rates(metric),
            _ if !self.suspect.is_empty() => {
                format!(
                    "{about}no verdict, since frame or labels of {} are suspect.",
                    self.suspect.join(", ")
                )
            }
            ([only], _) => format!(
                "{about}{} has {} {}{}.",
                only.detector,
                indefinite(metric),
                only.text(),
                only.interval
                    .and_then(|it| it.blocks.shortfall())
                    .map_or_else(String::new, |it| format!("; {it} for the interval to be reliable")),
            ),
            ([first, second, ..], lead) if lead.as_ref().is_none_or(PairedDifference::decides_nothing) => {
                format!(
                    "{about}{} has {} {}, {} has {}; {} to show which one leads.",
                    first.detector,
                    indefinite(metric),
                    first.text(),
                    second.detector,
                    second.text(),
                    lead.as_ref()
                        .and_then(|it| it.interval?.blocks.shortfall())
                        .unwrap_or_else(|| "these scans are too few".to_owned()),
                )
            }
            ([first, second, ..], Some(lead)) if lead.is_surely_larger() => format!(
                "{about}{} leads with {} {}, {} points above {}{}.",
                first.detector,
                indefinite(metric),
                first.text(),
                points(lead.difference()),
                second.detector,
                lead.interval_text(),
            ),
            ([first, second, ..], lead) => format!(
                "{about}no significant difference between {} and {}: {metric} {} and {}{}.",
                first.detector,
                second.detector,
                first.text(),
                second.text(),
                lead.as_ref().map_or_else(String::new, |it| format!(
                    ", a difference of {} points{}",
                    points(it.difference()),
                    it.interval_text()
                )),
            ),
        }
    }
}

fn indefinite(metric: &str) -> String {
    let article = if metric.starts_with('F') { "an" } else { "a" };
    format!("{article} {metric} of")
}

/// A difference of rates in hundredths.
pub(super) fn points(difference: f64) -> String {
    fixed_decimals(100.0 * difference, 1).replace('-', "−")
}

/// The ends of the interval of a difference in hundredths, with the digits that tell them from 0.
pub(super) fn end_points(ends: [f64; 2]) -> [String; 2] {
    ends.map(|it| {
        if it == 0.0 || (100.0 * it).abs() >= 0.05 {
            points(it)
        } else {
            fixed_decimals(100.0 * it, 2).replace('-', "−")
        }
    })
}

impl PairedDifference {
    /// Whether nothing can rest on its interval.
    pub(super) fn decides_nothing(&self) -> bool {
        self.interval.is_none_or(|it| it.blocks.decide_nothing())
    }

    fn interval_text(&self) -> String {
        self.interval.map_or_else(String::new, |it| {
            let [low, high] = end_points(it.ends);
            format!(" (95 % interval {low} to {high})")
        })
    }
}

impl RankedDetector {
    /// The value in percent with its interval.
    fn text(&self) -> String {
        let percent = |it: f64| fixed_decimals(100.0 * it, 1);
        let value = self.value.map_or_else(|| "–".to_owned(), |it| format!("{} %", percent(it)));
        self.interval.map_or(value.clone(), |it| {
            let [low, high] = it.ends.map(percent);
            format!("{value} ({low} to {high})")
        })
    }
}

/// A smaller factor would be rounded to 1.0 with one decimal.
const ABOUT_AS_FAST: f64 = 1.05;

impl Speeds {
    /// How many times faster the fastest detectors are, in a sentence, or why it is not said; `None` if nothing was timed.
    pub fn sentence(&self) -> Option<String> {
        let ((name, fastest_ms), others) = self.means_ms.split_first()?;
        let on = self.on.as_ref().map_or_else(String::new, |it| format!("On {it}: "));
        if self.is_doubted {
            return Some(format!(
                "{on}No statement on speed: the machine was busy, so times are unreliable."
            ));
        }
        let others: Vec<String> = others
            .iter()
            .map(|(other, ms)| {
                let ms_text = three_digits(*ms);
                let times = ms / fastest_ms;
                if times < ABOUT_AS_FAST {
                    format!("about as fast as {other} ({ms_text} ms)")
                } else {
                    format!("{} × faster than {other} ({ms_text} ms)", three_digits_short(times))
                }
            })
            .collect();
        let time = format!("{on}{name} takes {} ms for a scan (mean)", three_digits(*fastest_ms));
        Some(match others.split_last() {
            None => format!("{time}."),
            Some((only, [])) => format!("{time}, {only}."),
            Some((last, rest)) => format!("{time}, {} and {last}.", rest.join(", ")),
        })
    }
}

/// A factor with two digits that count, or all those before the point.
fn three_digits_short(factor: f64) -> String {
    if factor < 9.95 { fixed_decimals(factor, 1) } else { fixed_decimals(factor, 0) }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::numbers::blocks::{BlockCount, BlockKind};
    use crate::numbers::pools::pools;

    fn drives(n: u64) -> BlockCount {
        BlockCount::of_dataset(n, BlockKind::Drives)
    }

    fn ranked(detector: &str, value: Option<f64>) -> RankedDetector {
        let interval = value.map(|it| Interval { ends: [it - 0.02, it + 0.01], blocks: drives(12) });
        RankedDetector {
            detector: detector.to_owned(),
            value,
            interval,
            n_false: Some(3),
            failed_scans: None,
        }
    }

    pub(in crate::verdicts) fn ranking(values: &[Option<f64>], lead: Option<[f64; 3]>) -> TaskRanking {
        let names = ["grid", "tree", "pca"];
        let detectors = names.iter().zip(values).map(|(name, value)| ranked(name, *value)).collect();
        let lead = lead.map(|[after, low, high]| PairedDifference {
            metric: Metric::FRate,
            before: 0.0,
            after,
            interval: Some(Interval { ends: [low, high], blocks: drives(12) }),
            least_effect: None,
        });
        let pool = pools([("street", Origin::Simulated)]).remove(0);
        let (task, metric) = (Task::Objects, Metric::FRate);
        TaskRanking {
            task,
            pool,
            has_others: false,
            metric,
            detectors,
            lead,
            suspect: Vec::new(),
            overruled: Vec::new(),
        }
    }

    #[test]
    fn beside_data_sets_of_another_origin_it_is_said_which_are_meant() {
        let (recorded, simulated) = (Origin::Recorded, Origin::Simulated);
        let pools = pools([("north", simulated), ("kitti", recorded), ("south", simulated)]);
        let said = pools.into_iter().map(|pool| {
            let alone = ranking(&[Some(0.7)], None);
            TaskRanking { pool, has_others: true, ..alone }.sentence()
        });
        assert_eq!(
            said.collect::<Vec<_>>(),
            [
                "Task objects on 2 simulated data sets: grid has an F-rate of 70.0 % (68.0 to 71.0).",
                "Task objects on kitti (recorded): grid has an F-rate of 70.0 % (68.0 to 71.0)."
            ]
        );
    }

    #[test]
    fn where_nothing_is_annotated_false_detections_are_counted() {
        let mut empty = ranking(&[None, None], None);
        assert_eq!(
            empty.sentence(),
            "Task objects (simulated): nothing is annotated that counts; false detections: grid 3, tree 3."
        );
        empty.detectors[0].n_false = None;
        empty.metric = Metric::Recall;
        assert_eq!(empty.sentence(), "Task objects (simulated): recall is undefined.");
    }

    #[test]
    fn everybody_is_named() {
        let said = ranking(&[Some(0.7), Some(0.6), Some(0.5)], Some([0.1, 0.05, 0.12])).sentence();
        assert!(said.ends_with(" (95 % interval 5.0 to 12.0). Then: pca 50.0 % (48.0 to 51.0)."), "{said}");
        let said = ranking(&[Some(0.7), Some(0.6), None], Some([0.1, 0.05, 0.12])).sentence();
        assert!(said.ends_with(" (95 % interval 5.0 to 12.0). Undefined: pca."), "{said}");
    }

    #[test]
    fn a_clear_lead_is_called_one() {
        assert_eq!(
            ranking(&[Some(0.7), Some(0.6)], Some([0.1, 0.05, 0.12])).sentence(),
            "Task objects (simulated): grid leads with an F-rate of 70.0 % (68.0 to 71.0), 10.0 points above tree \
             (95 % interval 5.0 to 12.0)."
        );
    }

    #[test]
    fn a_lead_that_may_be_chance_is_none() {
        assert_eq!(
            ranking(&[Some(0.7), Some(0.69)], Some([0.01, -0.005, 0.02])).sentence(),
            "Task objects (simulated): no significant difference between grid and tree: F-rate 70.0 % (68.0 to 71.0) and 69.0 % \
             (67.0 to 70.0), a difference of 1.0 points (95 % interval −0.5 to 2.0)."
        );
    }

    #[test]
    fn a_verdict_about_failed_scans_says_so() {
        let mut failed = ranking(&[Some(0.7), Some(0.6), Some(0.1)], Some([0.1, 0.05, 0.12]));
        assert!(!failed.sentence().contains("failed"), "{}", failed.sentence());
        failed.detectors[1].failed_scans = Some([3, 11]);
        let said = failed.sentence();
        assert!(
            said.contains("grid leads")
                && said.ends_with(" But tree failed at 3 of 11 scans, which count as nothing found.")
        );
    }

    #[test]
    fn of_few_blocks_nobody_leads() {
        let mut few = ranking(&[Some(0.7), Some(0.6)], Some([0.1, 0.05, 0.12]));
        few.lead.as_mut().unwrap().interval.as_mut().unwrap().blocks = drives(9);
        assert_eq!(
            few.sentence(),
            "Task objects (simulated): grid has an F-rate of 70.0 % (68.0 to 71.0), tree has 60.0 % (58.0 to 61.0); 9 \
             blocks of scans are too few to show which one leads."
        );
        few.lead.as_mut().unwrap().interval = None;
        assert!(
            few.sentence().ends_with("; these scans are too few to show which one leads."),
            "{}",
            few.sentence()
        );
        let mut alone = ranking(&[Some(0.7)], None);
        alone.detectors[0].interval.as_mut().unwrap().blocks = drives(4);
        assert!(
            alone.sentence().ends_with("; 4 blocks of scans are too few for the interval to be reliable."),
            "{}",
            alone.sentence()
        );
    }

    #[test]
    fn of_a_suspect_frame_nobody_leads() {
        let mut suspect = ranking(&[Some(0.7), Some(0.6)], Some([0.1, 0.05, 0.12]));
        suspect.suspect = vec!["mine".to_owned()];
        let expected = "Task objects (simulated): no verdict, since frame or labels of mine are suspect.";
        assert_eq!(suspect.sentence(), expected);
        suspect.detectors.truncate(1);
        assert_eq!(suspect.sentence(), expected);
        (suspect.suspect, suspect.overruled) = (Vec::new(), vec!["mine".to_owned()]);
        let said = suspect.sentence();
        assert!(said.contains("grid has an F-rate"), "{said}");
        assert!(said.ends_with(" Doubts about the labels of mine were overruled."), "{said}");
    }

    #[test]
    fn undefined_rates_lead_nothing() {
        let mut undefined = ranking(&[None, None], None);
        undefined.detectors[1].n_false = None;
        assert_eq!(undefined.sentence(), "Task objects (simulated): F-rate is undefined.");
        assert_eq!(
            ranking(&[Some(0.7), None], None).sentence(),
            "Task objects (simulated): grid has an F-rate of 70.0 % (68.0 to 71.0). Undefined: tree."
        );
    }

    #[test]
    fn speeds_are_compared_with_the_fastest() {
        let speeds = |means: &[(&str, f64)]| {
            let means_ms = means.iter().map(|(name, ms)| ((*name).to_owned(), *ms)).collect();
            Speeds { on: None, means_ms, is_doubted: false }.sentence()
        };
        assert_eq!(speeds(&[]), None);
        assert_eq!(
            speeds(&[("grid", 3.06), ("pca", 9.04), ("tree", 356.4)]).unwrap(),
            "grid takes 3.06 ms for a scan (mean), 3.0 × faster than pca (9.04 ms) and 116 × faster than tree (356 ms)."
        );
        assert_eq!(
            speeds(&[("grid", 3.06), ("pca", 3.15), ("tree", 3.37)]).unwrap(),
            "grid takes 3.06 ms for a scan (mean), about as fast as pca (3.15 ms) and 1.1 × faster than tree (3.37 ms)."
        );
    }
}
