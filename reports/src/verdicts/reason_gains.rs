//! Reasons why a detector is wrong: how often, and what repairing each alone would gain.

use std::collections::BTreeMap;

use crate::files::fixed_decimals::Fixed;
use crate::numbers::gathered::{slices_of_annotation, slices_of_detection};
use crate::numbers::sums::FalseObjects;
use crate::numbers::tally::Tally;
use crate::rows::counts::Counts;
use crate::rows::error_row::ErrorRow;
use crate::rows::match_outcome::MatchOutcome;
use crate::rows::match_row::MatchRow;
use crate::uncertainty::sample::{Question, Sample};
use crate::vocabulary::formula::Term;
use crate::vocabulary::reason::{FalseReason, MissReason, MistakeKind};
use crate::vocabulary::slice::Slice;
use crate::vocabulary::task::Task;

/// Data set, task, detector and slice.
type About = (String, Task, String, Slice);

/// Mistakes, counted by reason.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReasonTally {
    missed: BTreeMap<(About, MissReason), u64>,
    false_ones: BTreeMap<(About, FalseReason), u64>,
}

impl ReasonTally {
    /// Adds the mistake of a row, if it has one.
    pub fn add_match(&mut self, row: &MatchRow) {
        let about = |slice| (row.dataset.clone(), row.task, row.detector.clone(), slice);
        match &row.outcome {
            MatchOutcome::Missed { annotation, reason } => {
                for slice in with_all(slices_of_annotation(annotation)) {
                    *self.missed.entry((about(slice), *reason)).or_default() += 1;
                }
            }
            MatchOutcome::False { detection, reason } => {
                for slice in with_all(slices_of_detection(detection)) {
                    *self.false_ones.entry((about(slice), *reason)).or_default() += 1;
                }
            }
            _ => {}
        }
    }

    /// The rows of `errors.csv`: of each data set and of those of one origin together, task by task, detector by detector,
    /// slice by slice. `tally` has the same matches. Reasons without a mistake have no row.
    pub fn rows(&self, tally: &Tally) -> Vec<ErrorRow> {
        let (pools, draws) = (tally.pools(), tally.undrawn());
        let several = pools.iter().filter(|it| it.is_of_several()).map(|it| it.extent.name());
        let mut rows = Vec::new();
        for dataset in tally.datasets().iter().map(String::as_str).chain(several) {
            for &task in tally.tasks().iter().filter(|it| it.class().is_none()) {
                for detector in tally.detectors() {
                    let slices = tally.slices(task, detector).into_iter().filter(is_shown);
                    for slice in slices {
                        let question = Question { dataset, task, detector, slice };
                        if let Some(sample) = tally.sample(&question, &draws) {
                            rows.extend(self.rows_of(tally, &question, &sample));
                        }
                    }
                }
            }
        }
        rows
    }

    fn rows_of(&self, tally: &Tally, question: &Question<'_>, sample: &Sample) -> Vec<ErrorRow> {
        let &Question { dataset, task, detector, slice } = question;
        let Some(counts) = counts_of(sample) else { return Vec::new() };
        let datasets = tally.datasets_in(dataset).into_iter().map(|it| &tally.datasets()[it]);
        let abouts: Vec<About> = datasets.map(|it| (it.clone(), task, detector.to_owned(), slice)).collect();
        let row = |mistake, reason: &str, n, of, repaired: Option<Counts>| {
            let gain = repaired.and_then(|it| Some(it.f_rate()? - counts.f_rate()?));
            let (dataset, detector, reason) = (dataset.to_owned(), detector.to_owned(), reason.to_owned());
            (n > 0).then(|| {
                let f_rate_gain = gain.map(Fixed);
                ErrorRow { dataset, task, detector, slice, mistake, reason, n, of, f_rate_gain }
            })
        };
        let missed = MissReason::ALL.into_iter().filter_map(|reason| {
            let n = abouts.iter().filter_map(|it| self.missed.get(&(it.clone(), reason))).sum();
            let repaired = Counts::new(counts.no(), counts.tp() + n, counts.fo());
            row(MistakeKind::Missed, reason.name(), n, counts.no(), repaired)
        });
        let false_ones = FalseReason::ALL.into_iter().filter_map(|reason| {
            let n = abouts.iter().filter_map(|it| self.false_ones.get(&(it.clone(), reason))).sum();
            let (nd, fo) = (counts.nd()?, counts.fo()?.checked_sub(n)?);
            row(MistakeKind::False, reason.name(), n, nd, Counts::new(counts.no(), counts.tp(), Some(fo)))
        });
        missed.chain(false_ones).collect()
    }
}

fn with_all(slices: Vec<Slice>) -> impl Iterator<Item = Slice> {
    [Slice::All].into_iter().chain(slices).filter(is_shown)
}

fn is_shown(slice: &Slice) -> bool {
    matches!(slice, Slice::All | Slice::Class(_) | Slice::Range(_))
}

/// Found, missed and false objects; false ones are unknown in a slice that no false detection belongs to.
fn counts_of(sample: &Sample) -> Option<Counts> {
    let count = |term| sample.total.of(term) as u64;
    let has_false = sample.false_objects == FalseObjects::Known && sample.slice.has_false_detections();
    let fo = has_false.then(|| count(Term::False));
    Counts::new(count(Term::Annotations), count(Term::Matched), fo)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::match_outcome::{AnnotationFacts, BoxFacts, DetectionFacts, MotionFacts};
    use crate::rows::scan_row::{ScanNumbers, ScanOutcome, ScanRow};
    use crate::vocabulary::class::{AnnotationClass, DetectionClass};
    use crate::vocabulary::criterion::CriterionKind;

    const NEAR: [f32; 3] = [3.0, 4.0, 0.0];
    const FAR: [f32; 3] = [60.0, 0.0, 0.0];

    fn annotation(class: AnnotationClass, center_m: [f32; 3]) -> AnnotationFacts {
        AnnotationFacts { centroid_m: Some(center_m), ..AnnotationFacts::without_position(class, 100) }
    }

    fn detection(center_m: [f32; 3]) -> DetectionFacts {
        let bounding_box = BoxFacts { center_m, length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };
        DetectionFacts {
            id: 0,
            class: DetectionClass::Object,
            score: None,
            n_points: 50,
            bounding_box,
            motion: MotionFacts::default(),
        }
    }

    /// Ten objects, of which six are found. Two far cars are merged, a near tree is split, and nothing finds a near car. Of
    /// three false detections one joins the two cars far away, and two near ones lie on nothing.
    fn scene() -> Vec<MatchOutcome> {
        let found = || MatchOutcome::Matched {
            annotation: annotation(AnnotationClass::Car, NEAR),
            detection: detection(NEAR),
            cost: 0.1,
        };
        let missed = |class, center_m, reason| MatchOutcome::Missed {
            annotation: annotation(class, center_m),
            reason,
        };
        let wrong = |center_m, reason| MatchOutcome::False { detection: detection(center_m), reason };
        let mut scene: Vec<MatchOutcome> = (0..6).map(|_| found()).collect();
        scene.extend([
            missed(AnnotationClass::Car, FAR, MissReason::MergedWithOthers),
            missed(AnnotationClass::Car, FAR, MissReason::MergedWithOthers),
            missed(AnnotationClass::Tree, NEAR, MissReason::Split),
            missed(AnnotationClass::Car, NEAR, MissReason::NothingThere),
            wrong(FAR, FalseReason::JoinsSeveral),
            wrong(NEAR, FalseReason::NothingThere),
            wrong(NEAR, FalseReason::NothingThere),
        ]);
        scene
    }

    fn rows(fo: Option<u64>) -> Vec<ErrorRow> {
        let (mut tally, mut reasons) = (Tally::default(), ReasonTally::default());
        let [dataset, sequence, detector] = ["street", "drive", "grid"].map(str::to_owned);
        let counts = Counts::new(10, 6, fo).expect("no more is found than there is");
        tally.add_scan(&ScanRow {
            dataset: dataset.clone(),
            sequence: sequence.clone(),
            scan: 0,
            time_s: Some(0.0),
            detector: detector.clone(),
            task: Task::Objects,
            outcome: ScanOutcome::Evaluated(ScanNumbers::of_counts(counts)),
        });
        for outcome in
            scene().into_iter().filter(|it| fo.is_some() || !matches!(it, MatchOutcome::False { .. }))
        {
            let row = MatchRow {
                dataset: dataset.clone(),
                sequence: sequence.clone(),
                scan: 0,
                detector: detector.clone(),
                task: Task::Objects,
                criterion: CriterionKind::Points,
                outcome,
            };
            tally.add_match(&row);
            reasons.add_match(&row);
        }
        reasons.rows(&tally)
    }

    fn gains(rows: &[ErrorRow], slice: &str) -> Vec<(String, u64, u64, Option<f64>)> {
        let of_slice = rows.iter().filter(|it| it.slice.name() == slice);
        let gain = |it: &ErrorRow| it.f_rate_gain.map(|it| (it.0 * 1e6).round() / 1e6);
        of_slice.map(|it| (format!("{}: {}", it.mistake, it.reason), it.n, it.of, gain(it))).collect()
    }

    #[test]
    fn a_repaired_reason_gains_what_its_objects_are_worth() {
        // F = 2 · 6 / (10 + 9); with the two merged ones found 2 · 8 / (10 + 11); without the two on nothing 2 · 6 / (10 +
        // 7).
        let gain = |numerator: f64, denominator: f64| {
            Some(((numerator / denominator - 12.0 / 19.0) * 1e6).round() / 1e6)
        };
        let expected = [
            ("missed: nothing there", 1, 10, gain(14.0, 20.0)),
            ("missed: merged with others", 2, 10, gain(16.0, 21.0)),
            ("missed: split", 1, 10, gain(14.0, 20.0)),
            ("false: nothing there", 2, 9, gain(12.0, 17.0)),
            ("false: joins several", 1, 9, gain(12.0, 18.0)),
        ];
        let expected = expected.map(|(reason, n, of, gain)| (reason.to_owned(), n, of, gain));
        assert_eq!(gains(&rows(Some(3)), "all"), expected);
    }

    #[test]
    fn reasons_are_counted_by_class_and_range() {
        let rows = rows(Some(3));
        let counted = |slice: &str| -> Vec<(String, u64, u64)> {
            gains(&rows, slice).into_iter().map(|(reason, n, of, _)| (reason, n, of)).collect()
        };
        let missed = |reason: &str, n, of| (format!("missed: {reason}"), n, of);
        assert_eq!(counted("class/car"), [missed("nothing there", 1, 9), missed("merged with others", 2, 9)]);
        assert_eq!(counted("class/tree"), [missed("split", 1, 1)]);
        let far = [missed("merged with others", 2, 2), ("false: joins several".to_owned(), 1, 1)];
        assert_eq!(counted("range/50-80"), far);
        // No detection has the class of an annotation, so there is no F-rate of a class.
        assert!(gains(&rows, "class/car").iter().all(|it| it.3.is_none()));
    }

    #[test]
    fn where_false_objects_are_unknown_nothing_is_gained() {
        let rows = rows(None);
        assert!(rows.iter().all(|it| it.mistake == MistakeKind::Missed && it.f_rate_gain.is_none()));
        assert_eq!(gains(&rows, "all").len(), 3);
    }
}
