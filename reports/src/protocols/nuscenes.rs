//! nuScenes' detection task: average precision over centre distances, five errors, and NDS.
//!
//! Caesar et al.: nuScenes: A multimodal dataset for autonomous driving, CVPR 2020, section 3.1; nuscenes-devkit 1.2.0 where both differ.

use std::collections::BTreeMap;

use super::protocol_number::{ALL_CLASSES, PRESENT_CLASSES, ProtocolMetric};
use super::ranked_classes::{RankedClass, RankedScan};
use super::recall_grid::{N_RECALLS, on_line, recall_at};
use super::under_protocol::UnderProtocol;
use crate::rows::ranked_box_row::PairErrors;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::metric::Direction;
use crate::vocabulary::ranked_protocol::{ERROR_DISTANCE, PAIR_DISTANCES_M, RankedProtocol};

/// Precision below this counts as none, and so does recall up to it.
const LEAST_PRECISION: f64 = 0.1;
/// The first recall that counts: 0.11.
const FIRST_RECALL: usize = 11;
/// How much mAP weighs beside one error in NDS.
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

/// The places of these numbers that classes are summed up by.
const SUMMED_UP: [usize; 6] = [0, 5, 6, 7, 8, 9];

const N_ERRORS: usize = 5;

/// What one detector made of scans.
pub(super) struct Nuscenes {
    classes: Vec<RankedClass>,
}

/// The numbers of a class.
#[derive(Debug, Clone, Copy)]
struct ClassScores {
    n_annotations: u64,
    average_precisions: [f64; PAIR_DISTANCES_M.len()],
    // NaN where the class has no such error.
    errors: [f64; N_ERRORS],
}

impl Nuscenes {
    /// Of the rows of the scans named, which ascend.
    pub(super) fn new(scans: &[ScanName], rows: &BTreeMap<ScanName, RankedScan>) -> Self {
        Self { classes: RankedClass::all(RankedProtocol::Nuscenes, scans, rows) }
    }

    fn scores(&self, times: &[u16]) -> Vec<ClassScores> {
        let names = RankedProtocol::Nuscenes.classes();
        self.classes.iter().zip(names).map(|(class, name)| ClassScores::of(class, name, times)).collect()
    }

    /// Which errors are known: velocities and attributes only where an annotation has one.
    fn known_errors(class: &RankedClass, name: &str) -> [bool; N_ERRORS] {
        let [orientation, motion] = [name != "traffic_cone", !matches!(name, "traffic_cone" | "barrier")];
        [true, true, orientation, motion && class.has_velocity, motion && class.has_attribute]
    }

    /// The classes that the scans have annotations of, each with its name and its place.
    fn present(&self) -> impl Iterator<Item = (usize, &'static str, &RankedClass)> {
        let named = RankedProtocol::Nuscenes.classes().iter().zip(&self.classes).enumerate();
        named.filter(|(_, (_, class))| class.n() > 0).map(|(place, (name, class))| (place, *name, class))
    }

    /// mAP, the mean errors and NDS of the makers: over all ten classes, also those that there are no annotations of.
    fn of_all(scores: &[ClassScores]) -> Vec<Option<f64>> {
        let precision = mean(scores.iter().map(ClassScores::average_precision)).unwrap_or(0.0);
        let errors: [f64; N_ERRORS] = std::array::from_fn(|kind| {
            mean(scores.iter().map(|it| it.errors[kind]).filter(|it| !it.is_nan())).unwrap_or(1.0)
        });
        let values = [precision].into_iter().chain(errors).chain([detection_score(precision, &errors)]);
        values.map(Some).collect()
    }

    /// The same over what there are annotations of, with the errors that are known.
    fn of_present(&self, scores: &[ClassScores]) -> Vec<Option<f64>> {
        let drawn: Vec<_> = self.present().filter(|(place, ..)| scores[*place].n_annotations > 0).collect();
        let precision = mean(drawn.iter().map(|(place, ..)| scores[*place].average_precision()));
        let errors: [Option<f64>; N_ERRORS] = std::array::from_fn(|kind| {
            let known = drawn.iter().filter(|(_, name, class)| Self::known_errors(class, name)[kind]);
            mean(known.map(|(place, ..)| scores[*place].errors[kind]))
        });
        let known: Vec<f64> = errors.into_iter().flatten().collect();
        let score = precision.map(|it| detection_score(it, &known));
        [precision].into_iter().chain(errors).chain([score]).collect()
    }
}

impl UnderProtocol for Nuscenes {
    fn metrics(&self) -> Vec<ProtocolMetric> {
        let metric = |class: &str, n: u64, (id, unit, direction): (&str, &'static str, Direction)| {
            ProtocolMetric { class: class.to_owned(), id: id.to_owned(), unit, direction, n }
        };
        let of_classes =
            self.present().flat_map(|(_, name, class)| OF_CLASS.map(|it| metric(name, class.n(), it)));
        let n = self.classes.iter().map(RankedClass::n).sum();
        let of_several = [ALL_CLASSES, PRESENT_CLASSES].into_iter().flat_map(|class| {
            let summed_up = SUMMED_UP.into_iter().map(|it| OF_CLASS[it]);
            summed_up.chain([("nds", "ratio", Direction::HigherIsBetter)]).map(move |it| metric(class, n, it))
        });
        of_several.chain(of_classes).collect()
    }

    fn values(&self, times: &[u16]) -> Vec<Option<f64>> {
        let scores = self.scores(times);
        let mut values = Self::of_all(&scores);
        values.extend(self.of_present(&scores));
        for (place, name, class) in self.present() {
            let it = &scores[place];
            let is_there = it.n_annotations > 0;
            let precisions = [it.average_precision()].into_iter().chain(it.average_precisions);
            values.extend(precisions.map(|value| is_there.then_some(value)));
            let errors = it.errors.into_iter().zip(Self::known_errors(class, name));
            values.extend(errors.map(|(error, is_known)| (is_there && is_known).then_some(error)));
        }
        values
    }
}

impl ClassScores {
    fn of(class: &RankedClass, name: &str, times: &[u16]) -> Self {
        let n_annotations = class.n_annotations(times);
        let curves: [Option<RecallCurve>; PAIR_DISTANCES_M.len()] =
            std::array::from_fn(|distance| RecallCurve::of(class, distance, times, n_annotations));
        let average_precisions =
            curves.each_ref().map(|it| it.as_ref().map_or(0.0, RecallCurve::average_precision));
        let errors = curves[ERROR_DISTANCE].as_ref().map_or([1.0; N_ERRORS], |it| it.errors(class, times));
        let is_left_out = match name {
            "traffic_cone" => [false, false, true, true, true],
            "barrier" => [false, false, false, true, true],
            _ => [false; N_ERRORS],
        };
        let errors = std::array::from_fn(|kind| if is_left_out[kind] { f64::NAN } else { errors[kind] });
        Self { n_annotations, average_precisions, errors }
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

/// Precision and score at each of the recalls, and 0 where they are not reached.
struct RecallCurve {
    precisions: [f64; N_RECALLS],
    scores: [f64; N_RECALLS],
}

impl RecallCurve {
    /// `None` if nothing is found. A scan that is there several times finds all at once what it finds.
    fn of(class: &RankedClass, distance: usize, times: &[u16], n_annotations: u64) -> Option<Self> {
        let n_annotations = n_annotations as f64;
        let mut curve = Self { precisions: [0.0; N_RECALLS], scores: [0.0; N_RECALLS] };
        let (mut n_found, mut n_all, mut score, mut next) = (0_u64, 0_u64, 0.0, 0);
        for detection in &class.detections {
            let n_times = u64::from(times[detection.scan as usize]);
            if n_times == 0 {
                continue;
            }
            if detection.finds_at(distance) {
                let from = (n_all > 0).then(|| point(n_found, n_all, n_annotations, score));
                (n_found, n_all) = (n_found + n_times, n_all + n_times);
                let to = point(n_found, n_all, n_annotations, detection.score);
                while next < N_RECALLS && recall_at(next) < to[0] {
                    curve.take(next, from.unwrap_or(to), to);
                    next += 1;
                }
            } else {
                n_all += n_times;
            }
            score = detection.score;
        }
        let last = point(n_found, n_all, n_annotations, score);
        if next < N_RECALLS && recall_at(next) == last[0] {
            curve.take(next, last, last);
        }
        (n_found > 0).then_some(curve)
    }

    /// Takes the values at one recall from the line between two points, or from the second where there is none before.
    fn take(&mut self, place: usize, from: [f64; 3], to: [f64; 3]) {
        let at = |axis: usize| {
            if from == to {
                to[axis]
            } else {
                on_line(recall_at(place), [from[0], from[axis]], [to[0], to[axis]])
            }
        };
        (self.precisions[place], self.scores[place]) = (at(1), at(2));
    }

    fn average_precision(&self) -> f64 {
        let counted = &self.precisions[FIRST_RECALL..];
        let sum: f64 =
            counted.iter().map(|it| (it - LEAST_PRECISION).max(0.0) / (1.0 - LEAST_PRECISION)).sum();
        sum / counted.len() as f64
    }

    /// The errors: of each the mean over what is found up to a recall, and of these the mean over recalls from 0.11 to the highest.
    fn errors(&self, class: &RankedClass, times: &[u16]) -> [f64; N_ERRORS] {
        let last = self.scores.iter().rposition(|it| *it != 0.0).unwrap_or(0);
        if last < FIRST_RECALL {
            return [1.0; N_ERRORS];
        }
        let (scores, means) = running_means(class, times);
        let mut sums = [0.0; N_ERRORS];
        let mut place = 0;
        for &score in &self.scores[FIRST_RECALL..=last] {
            while place + 1 < scores.len() && scores[place] > score {
                place += 1;
            }
            for (kind, sum) in sums.iter_mut().enumerate() {
                let to = [scores[place], means[place][kind]];
                *sum += if place == 0 || score <= scores[place] {
                    to[1]
                } else {
                    on_line(score, to, [scores[place - 1], means[place - 1][kind]])
                };
            }
        }
        sums.map(|it| it / (last + 1 - FIRST_RECALL) as f64)
    }
}

/// Recall, precision and score once these were found.
fn point(n_found: u64, n_all: u64, n_annotations: f64, score: f64) -> [f64; 3] {
    [n_found as f64 / n_annotations, n_found as f64 / n_all as f64, score]
}

/// The scores of what is found at 2 m, best first, and the means of errors up to each. A mean of nothing is 0; where an error is never
/// known it is 1 throughout.
fn running_means(class: &RankedClass, times: &[u16]) -> (Vec<f64>, Vec<[f64; N_ERRORS]>) {
    let (mut scores, mut means) = (Vec::new(), Vec::new());
    let (mut sums, mut counts) = ([0.0; N_ERRORS], [0.0; N_ERRORS]);
    for detection in class.detections.iter().filter(|it| it.finds_at(ERROR_DISTANCE)) {
        let n_times = f64::from(times[detection.scan as usize]);
        if n_times == 0.0 {
            continue;
        }
        let PairErrors { translation_m, scale, orientation_rad, velocity_m_per_s, attribute } =
            *class.errors_of(detection);
        let errors = [Some(translation_m), Some(scale), Some(orientation_rad), velocity_m_per_s, attribute];
        for (kind, error) in errors.into_iter().enumerate() {
            if let Some(error) = error {
                sums[kind] += n_times * error;
                counts[kind] += n_times;
            }
        }
        scores.push(detection.score);
        means.push(std::array::from_fn(
            |kind| if counts[kind] > 0.0 { sums[kind] / counts[kind] } else { 0.0 },
        ));
    }
    for kind in (0..N_ERRORS).filter(|kind| counts[*kind] == 0.0) {
        for mean in &mut means {
            mean[kind] = 1.0;
        }
    }
    (scores, means)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocols::made_rows::{found, labelled, number, right_false_right};
    use crate::rows::ranked_box_row::RankedBoxRow;
    use proptest::prelude::*;

    const HERE: RankedProtocol = RankedProtocol::Nuscenes;

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
        // Precision is 1 below a recall of 0.5, 1/2 at it, and from there rises to 2/3. Of 90 recalls each counts less a tenth.
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
        rows.push(found(HERE, (0, 0), "bus", 0.5, Some(0)));
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
                found(HERE, (*scan, id), class, f64::from(*score) / 4.0, is_right.then_some(0))
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
            rows.extend(numbered.map(|(score, scan)| found(HERE, (scan, 0), "car", f64::from(*score), Some(0))));
            prop_assert_eq!(number(&rows, &[1; 4], "present", "ap"), Some(1.0));
        }
    }
}
