//! nuScenes' detection task: average precision over centre distances, five errors, and NDS.
//!
//! Caesar et al.: nuScenes: A multimodal dataset for autonomous driving, CVPR 2020, section 3.1; nuscenes-devkit 1.2.0 where
//! both differ.

use std::collections::BTreeMap;

use super::drawn_scans::Times;
use super::nuscenes_curves::{N_ERRORS, RecallCurve, mean_errors, recall_curves};
use super::protocol_number::{ALL_CLASSES, PRESENT_CLASSES, ProtocolMetric};
use super::ranked_classes::{RankedClass, RankedScan};
use super::under_protocol::Ranking;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::metric::Direction;
use crate::vocabulary::protocol::{ERROR_DISTANCE, MOBILE, PAIR_DISTANCES_M, Protocol};

/// Weight of mAP in NDS; an error has weight 1.
const AP_WEIGHT: f64 = 5.0;

/// The numbers of a class, in the order of their values.
const OF_CLASS: [(&str, &str, Direction); 10] = [
    ("ap", "ratio", Direction::HigherIsBetter),
    ("ap_0.5m", "ratio", Direction::HigherIsBetter),
    ("ap_1m", "ratio", Direction::HigherIsBetter),
    ("ap_2m", "ratio", Direction::HigherIsBetter),
    ("ap_4m", "ratio", Direction::HigherIsBetter),
    ("ate_m", "m", Direction::LowerIsBetter),
    ("ase", "ratio", Direction::LowerIsBetter),
    ("aoe_rad", "rad", Direction::LowerIsBetter),
    ("ave_m_per_s", "m/s", Direction::LowerIsBetter),
    ("aae", "ratio", Direction::LowerIsBetter),
];

/// Indices of those numbers that are averaged over classes.
const SUMMED_UP: [usize; 6] = [0, 5, 6, 7, 8, 9];

/// Boxes of one detector, class by class.
pub(super) struct Nuscenes {
    protocol: Protocol,
    classes: Vec<RankedClass>,
}

/// The numbers of a class.
#[derive(Debug, Clone, Copy)]
struct ClassScores {
    n_annotations: f64,
    average_precisions: [f64; PAIR_DISTANCES_M.len()],
    // NaN where the class has no such error.
    errors: [f64; N_ERRORS],
}

impl Nuscenes {
    /// Takes the rows of `scans`, which ascend.
    pub(super) fn new(protocol: Protocol, scans: &[ScanName], rows: &BTreeMap<ScanName, RankedScan>) -> Self {
        Self { protocol, classes: RankedClass::all(protocol, scans, rows) }
    }

    fn values_of(&self, scores: &[ClassScores]) -> Vec<Option<f64>> {
        let mut values = Self::of_all(scores);
        // Without annotations of evaluated classes the protocol says nothing about a detector.
        if self.present().next().is_none() {
            values.fill(None);
        }
        values.extend(self.of_present(scores));
        for (index, name, class) in self.present() {
            let it = &scores[index];
            let is_there = it.n_annotations > 0.0;
            let precisions = [it.average_precision()].into_iter().chain(it.average_precisions);
            values.extend(precisions.map(|value| is_there.then_some(value)));
            let errors = it.errors.into_iter().zip(Self::known_errors(class, name));
            values.extend(errors.map(|(error, is_known)| (is_there && is_known).then_some(error)));
        }
        values
    }

    /// Whether each error is known: velocities and attributes only where an annotation has one.
    fn known_errors(class: &RankedClass, name: &str) -> [bool; N_ERRORS] {
        let [orientation, motion] = [name != "traffic_cone", !matches!(name, "traffic_cone" | "barrier")];
        let attribute = motion && name != MOBILE && class.has_attribute;
        [true, true, orientation, motion && class.has_velocity, attribute]
    }

    /// Classes with annotations in the scans, each with its index and its name.
    fn present(&self) -> impl Iterator<Item = (usize, &'static str, &RankedClass)> {
        let named = self.protocol.ranked_classes().iter().zip(&self.classes).enumerate();
        named.filter(|(_, (_, class))| class.n() > 0).map(|(index, (name, class))| (index, *name, class))
    }

    /// mAP, mean errors and NDS of the makers: over all ten classes, with or without annotations.
    fn of_all(scores: &[ClassScores]) -> Vec<Option<f64>> {
        let precision = mean(scores.iter().map(ClassScores::average_precision)).unwrap_or(0.0);
        let errors: [f64; N_ERRORS] = std::array::from_fn(|kind| {
            mean(scores.iter().map(|it| it.errors[kind]).filter(|it| !it.is_nan())).unwrap_or(1.0)
        });
        let values = [precision].into_iter().chain(errors).chain([detection_score(precision, &errors)]);
        values.map(Some).collect()
    }

    /// mAP, mean errors and NDS over the classes with annotations in the draw, from the errors that are known.
    fn of_present(&self, scores: &[ClassScores]) -> Vec<Option<f64>> {
        let drawn: Vec<_> = self.present().filter(|(index, ..)| scores[*index].n_annotations > 0.0).collect();
        let precision = mean(drawn.iter().map(|(index, ..)| scores[*index].average_precision()));
        let errors: [Option<f64>; N_ERRORS] = std::array::from_fn(|kind| {
            let known = drawn.iter().filter(|(_, name, class)| Self::known_errors(class, name)[kind]);
            mean(known.map(|(index, ..)| scores[*index].errors[kind]))
        });
        let known: Vec<f64> = errors.into_iter().flatten().collect();
        let score = precision.map(|it| detection_score(it, &known));
        [precision].into_iter().chain(errors).chain([score]).collect()
    }
}

impl Ranking for Nuscenes {
    fn metrics(&self) -> Vec<ProtocolMetric> {
        let of_classes = self
            .present()
            .flat_map(|(_, name, class)| OF_CLASS.map(|it| ProtocolMetric::new(name, it, class.n())));
        let n = self.classes.iter().map(RankedClass::n).sum();
        let of_several = [ALL_CLASSES, PRESENT_CLASSES].into_iter().flat_map(|class| {
            let summed_up = SUMMED_UP.into_iter().map(|it| OF_CLASS[it]);
            let all = summed_up.chain([("nds", "ratio", Direction::HigherIsBetter)]);
            all.map(move |it| ProtocolMetric::new(class, it, n))
        });
        of_several.chain(of_classes).collect()
    }

    fn of_draws<const N: usize>(&self, times: &[Times<N>]) -> [Vec<Option<f64>>; N] {
        let named = self.classes.iter().zip(self.protocol.ranked_classes());
        let scores: Vec<[ClassScores; N]> =
            named.map(|(class, name)| ClassScores::of(class, name, times)).collect();
        std::array::from_fn(|draw| self.values_of(&scores.iter().map(|it| it[draw]).collect::<Vec<_>>()))
    }
}

impl ClassScores {
    /// Scores in each draw.
    fn of<const N: usize>(class: &RankedClass, name: &str, times: &[Times<N>]) -> [Self; N] {
        let n_annotations = class.n_annotations(times);
        let curves = recall_curves(class, times, &n_annotations);
        let errors = mean_errors(class, times, &curves[ERROR_DISTANCE]);
        let is_left_out = match name {
            "traffic_cone" => [false, false, true, true, true],
            "barrier" => [false, false, false, true, true],
            // What has no class has no attribute: its error is 1 in the mean of all.
            MOBILE => [false, false, false, false, true],
            _ => [false; N_ERRORS],
        };
        std::array::from_fn(|draw| Self {
            n_annotations: n_annotations[draw],
            average_precisions: curves
                .each_ref()
                .map(|it| it[draw].as_ref().map_or(0.0, RecallCurve::average_precision)),
            errors: std::array::from_fn(|kind| if is_left_out[kind] { f64::NAN } else { errors[draw][kind] }),
        })
    }

    fn average_precision(&self) -> f64 {
        self.average_precisions.iter().sum::<f64>() / self.average_precisions.len() as f64
    }
}

/// NDS: the mean of the errors' complements and of mAP, which weighs as much as five of them.
fn detection_score(average_precision: f64, errors: &[f64]) -> f64 {
    let complements: f64 = errors.iter().map(|it| (1.0 - it).max(0.0)).sum();
    (AP_WEIGHT * average_precision + complements) / (AP_WEIGHT + errors.len() as f64)
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (n, sum) = values.fold((0_u32, 0.0), |(n, sum), it| (n + 1, sum + it));
    (n > 0).then(|| sum / f64::from(n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocols::made_rows::{any_times, check_draws, found, labelled, number, right_false_right};
    use crate::rows::ranked_box_row::RankedBoxRow;
    use proptest::prelude::*;

    const HERE: Protocol = Protocol::Nuscenes;

    #[track_caller]
    fn check(rows: &[RankedBoxRow], class: &str, metric: &str, expected: Option<f64>) {
        let value = number(rows, &[1, 1], class, metric);
        let is_near = match (value, expected) {
            (Some(value), Some(expected)) => (value - expected).abs() < 1e-12,
            (value, expected) => value == expected,
        };
        assert!(is_near, "{metric} of {class} is {value:?}, not {expected:?}");
    }

    #[test]
    fn one_class_can_be_done_in_the_head() {
        let rows = right_false_right(HERE, "car");
        // Precision is 1 below a recall of 0.5, 1/2 at it, and from there rises to 2/3. Of 90 recalls each counts less a
        // tenth.
        let at_half_and_above: f64 = (0..=50_i32).map(|it| 0.5 + f64::from(it) / 300.0).sum();
        let average = (39.0 + at_half_and_above - 9.0) / (0.9 * 90.0);
        check(&rows, "car", "ap", Some(average));
        check(&rows, "car", "ap_0.5m", Some(average));
        for (metric, error) in [("ate_m", 0.5), ("ase", 0.2), ("aoe_rad", 0.3), ("ave_m_per_s", 2.0)] {
            check(&rows, "car", metric, Some(error));
            check(&rows, "present", metric, Some(error));
        }
        check(&rows, "car", "aae", None);
        // Four errors are known; a velocity of 2 m/s too much counts as 1.
        check(&rows, "present", "nds", Some((5.0 * average + 0.5 + 0.8 + 0.7) / 9.0));
        // Nine classes have nothing: no precision, and errors of 1.
        check(&rows, "all", "ap", Some(average / 10.0));
        check(&rows, "all", "ate_m", Some(9.5 / 10.0));
        check(&rows, "all", "aoe_rad", Some(8.3 / 9.0));
        check(&rows, "all", "aae", Some(1.0));
    }

    #[test]
    fn without_classes_the_attribute_is_wrong_and_all_counts_as_one_class() {
        let rows = right_false_right(Protocol::NuscenesAgnostic, MOBILE);
        let average = number(&rows, &[1, 1], MOBILE, "ap").unwrap();
        for (metric, error) in [("ate_m", 0.5), ("aoe_rad", 0.3), ("ave_m_per_s", 2.0), ("aae", 1.0)] {
            check(&rows, "all", metric, Some(error));
        }
        check(&rows, "all", "ap", Some(average));
        check(&rows, "all", "nds", Some((5.0 * average + 0.5 + 0.8 + 0.7) / 10.0));
        check(&rows, MOBILE, "aae", None);
    }

    #[test]
    fn a_scan_that_is_drawn_twice_counts_twice() {
        let rows = right_false_right(HERE, "car");
        let [once, twice] = [[1, 0], [2, 0]].map(|times| number(&rows, &times, "car", "ap"));
        // One annotation, which is found first of all: precision is 1 up to any recall but 1, where it is 1/2.
        let expected = (89.0 + (0.5 - 0.1) / 0.9) / 90.0;
        assert!([once, twice].iter().all(|it| (it.unwrap() - expected).abs() < 1e-12), "{once:?} {twice:?}");
        assert_eq!(number(&rows, &[0, 0], "car", "ap"), None);
    }

    #[test]
    fn errors_are_means_up_to_a_recall_and_cones_have_no_heading() {
        let rows = right_false_right(HERE, "traffic_cone");
        check(&rows, "traffic_cone", "aoe_rad", None);
        check(&rows, "present", "aoe_rad", None);
        check(&rows, "traffic_cone", "ate_m", Some(0.5));
    }

    #[test]
    fn too_low_a_recall_has_the_largest_errors() {
        let mut rows: Vec<RankedBoxRow> = (0..20).map(|scan| labelled(HERE, scan, "bus")).collect();
        rows.push(found(HERE, 0, 0, "bus", 0.5, Some(0)));
        assert_eq!(number(&rows, &[1; 20], "bus", "ate_m"), Some(1.0));
        assert_eq!(number(&rows, &[1; 20], "bus", "ap"), Some(0.0));
    }

    fn drawn_rows() -> impl Strategy<Value = Vec<RankedBoxRow>> {
        let detection = (0..4_u32, 0..5_u8, any::<bool>());
        prop::collection::vec(detection, 0..30).prop_map(|detections| {
            let mut rows: Vec<RankedBoxRow> =
                (0..8).map(|it| labelled(HERE, it % 4, ["car", "bus"][it as usize % 2])).collect();
            let numbered = detections.iter().zip(0..);
            rows.extend(numbered.map(|((scan, score, is_right), id)| {
                let class = ["car", "bus"][id as usize % 2];
                found(HERE, *scan, id, class, f64::from(*score) / 4.0, is_right.then_some(0))
            }));
            rows
        })
    }

    proptest! {
        #[test]
        fn the_order_of_rows_changes_nothing(rows in drawn_rows(), seed in any::<u64>()) {
            let mut shuffled = rows.clone();
            shuffled.sort_by_key(|it| (u64::from(it.ranked_box.id) + 3 * u64::from(it.scan.scan)).wrapping_mul(seed | 1));
            for metric in ["ap", "nds", "ate_m"] {
                let [a, b] = [&rows, &shuffled].map(|it| number(it, &[1, 2, 0, 1], "present", metric));
                prop_assert_eq!(a, b);
            }
        }

        #[test]
        fn what_finds_all_and_nothing_else_has_a_precision_of_one(scores in prop::collection::vec(1..9_u8, 4)) {
            let mut rows: Vec<RankedBoxRow> = (0..4).map(|it| labelled(HERE, it, "car")).collect();
            let numbered = scores.iter().zip(0..);
            rows.extend(numbered.map(|(score, scan)| found(HERE, scan, 0, "car", f64::from(*score), Some(0))));
            prop_assert_eq!(number(&rows, &[1; 4], "present", "ap"), Some(1.0));
        }

        #[test]
        fn several_draws_at_once_have_the_values_of_each(rows in drawn_rows(), times in any_times(4)) {
            check_draws(&rows, &times);
        }
    }
}
