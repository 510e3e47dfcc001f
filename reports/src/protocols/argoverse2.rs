//! Argoverse 2's detection challenge: average precision over centre distances, three errors, and CDS.
//!
//! Wilson et al.: Argoverse 2: Next Generation Datasets for Self-Driving Perception and Forecasting, `NeurIPS` 2021, section 4.1; av2 0.3.6
//! where both differ.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::protocol_number::{ALL_CLASSES, PRESENT_CLASSES, ProtocolMetric};
use super::ranked_classes::{RankedClass, RankedScan};
use super::recall_grid::{N_RECALLS, on_line, recall_at};
use super::under_protocol::UnderProtocol;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::metric::Direction;
use crate::vocabulary::ranked_protocol::{ERROR_DISTANCE, PAIR_DISTANCES_M, RankedProtocol};

/// The largest errors, which a class has where nothing of it is found; what an error is divided by for CDS.
const LARGEST_ERRORS: [f64; 3] = [PAIR_DISTANCES_M[ERROR_DISTANCE], 1.0, PI];

/// The numbers of a class, in the order of their values.
const OF_CLASS: [(&str, &str, Direction); 9] = [
    ("ap", "ratio", Direction::HigherIsBetter),
    ("ate_m", "m", Direction::LowerIsBetter),
    ("ase", "ratio", Direction::LowerIsBetter),
    ("aoe_rad", "rad", Direction::LowerIsBetter),
    ("cds", "ratio", Direction::HigherIsBetter),
    ("ap_0.5m", "ratio", Direction::HigherIsBetter),
    ("ap_1m", "ratio", Direction::HigherIsBetter),
    ("ap_2m", "ratio", Direction::HigherIsBetter),
    ("ap_4m", "ratio", Direction::HigherIsBetter),
];

/// How many of them, from the first on, classes are summed up by.
const N_SUMMED_UP: usize = 5;

/// What one detector made of scans.
pub(super) struct Argoverse2 {
    classes: Vec<RankedClass>,
}

impl Argoverse2 {
    /// Of the rows of the scans named, which ascend.
    pub(super) fn new(scans: &[ScanName], rows: &BTreeMap<ScanName, RankedScan>) -> Self {
        Self { classes: RankedClass::all(RankedProtocol::Argoverse2, scans, rows) }
    }

    /// The classes that the scans have annotations of, each with its place.
    fn present(&self) -> impl Iterator<Item = (usize, &RankedClass)> {
        self.classes.iter().enumerate().filter(|(_, class)| class.n() > 0)
    }
}

impl UnderProtocol for Argoverse2 {
    fn metrics(&self) -> Vec<ProtocolMetric> {
        let metric = |class: &str, n: u64, (id, unit, direction): (&str, &'static str, Direction)| {
            ProtocolMetric { class: class.to_owned(), id: id.to_owned(), unit, direction, n }
        };
        let names = RankedProtocol::Argoverse2.classes();
        let n = self.classes.iter().map(RankedClass::n).sum();
        let of_several = [ALL_CLASSES, PRESENT_CLASSES]
            .into_iter()
            .flat_map(|class| OF_CLASS[..N_SUMMED_UP].iter().map(move |it| metric(class, n, *it)));
        let of_classes =
            self.present().flat_map(|(place, class)| OF_CLASS.map(|it| metric(names[place], class.n(), it)));
        of_several.chain(of_classes).collect()
    }

    fn values(&self, times: &[u16]) -> Vec<Option<f64>> {
        let scores: Vec<Option<ClassScores>> =
            self.classes.iter().map(|class| ClassScores::of(class, times)).collect();
        let nothing = ClassScores { numbers: ClassScores::of_nothing(), average_precisions: [0.0; 4] };
        let mean = |of: &[&ClassScores]| -> [Option<f64>; N_SUMMED_UP] {
            std::array::from_fn(|number| {
                let sum: f64 = of.iter().map(|it| it.numbers[number]).sum();
                (!of.is_empty()).then(|| sum / of.len() as f64)
            })
        };
        let all: Vec<&ClassScores> = scores.iter().map(|it| it.as_ref().unwrap_or(&nothing)).collect();
        let present: Vec<&ClassScores> = scores.iter().flatten().collect();
        let mut values: Vec<Option<f64>> = mean(&all).into_iter().chain(mean(&present)).collect();
        for (place, _) in self.present() {
            let numbers: [Option<f64>; OF_CLASS.len()] = match &scores[place] {
                None => [None; OF_CLASS.len()],
                Some(it) => std::array::from_fn(|number| {
                    let numbers = it.numbers.iter().chain(&it.average_precisions);
                    numbers.copied().nth(number)
                }),
            };
            values.extend(numbers);
        }
        values
    }
}

/// The numbers of a class.
struct ClassScores {
    // AP, ATE, ASE, AOE, CDS.
    numbers: [f64; N_SUMMED_UP],
    average_precisions: [f64; PAIR_DISTANCES_M.len()],
}

impl ClassScores {
    /// Where there are no annotations, or nothing is found.
    fn of_nothing() -> [f64; N_SUMMED_UP] {
        let [translation_m, scale, orientation_rad] = LARGEST_ERRORS;
        [0.0, translation_m, scale, orientation_rad, 0.0]
    }

    /// `None` without annotations.
    fn of(class: &RankedClass, times: &[u16]) -> Option<Self> {
        let n_annotations = class.n_annotations(times);
        if n_annotations == 0 {
            return None;
        }
        let average_precisions: [f64; PAIR_DISTANCES_M.len()] =
            std::array::from_fn(|distance| average_precision(class, distance, times, n_annotations));
        let precision = average_precisions.iter().sum::<f64>() / average_precisions.len() as f64;
        let errors = mean_errors(class, times);
        let complements: f64 =
            errors.iter().zip(LARGEST_ERRORS).map(|(error, largest)| 1.0 - error / largest).sum();
        let composite = precision * (complements / errors.len() as f64);
        let numbers = [precision, errors[0], errors[1], errors[2], composite];
        Some(Self { numbers, average_precisions })
    }
}

/// A detection that finds an annotation, in the order of the ranking.
struct Found {
    recall: f64,
    precision: f64,
    /// Whether a false detection stands between it and the one before.
    follows_false: bool,
}

/// The mean over recalls of the best precision at that recall or a higher one.
fn average_precision(class: &RankedClass, distance: usize, times: &[u16], n_annotations: u64) -> f64 {
    let mut found: Vec<Found> = Vec::new();
    let (mut n_found, mut n_all, mut follows_false) = (0_u64, 0_u64, false);
    for detection in &class.detections {
        let n_times = u64::from(times[detection.scan as usize]);
        if n_times == 0 {
            continue;
        }
        n_all += n_times;
        if detection.finds_at(distance) {
            n_found += n_times;
            let [recall, precision] = [n_annotations, n_all].map(|it| n_found as f64 / it as f64);
            found.push(Found { recall, precision, follows_false });
            follows_false = false;
        } else {
            follows_false = true;
        }
    }
    let last_precision = if n_all == 0 { 0.0 } else { n_found as f64 / n_all as f64 };
    let mut best = 0.0_f64;
    for it in found.iter_mut().rev() {
        best = best.max(it.precision);
        it.precision = best;
    }
    mean_over_recalls(&found, last_precision)
}

/// `found` has the best precisions from each on; `last_precision` is that of all detections.
fn mean_over_recalls(found: &[Found], last_precision: f64) -> f64 {
    let (mut sum, mut next) = (0.0, 0);
    for (place, to) in found.iter().enumerate() {
        while next < N_RECALLS && recall_at(next) < to.recall {
            // Behind a false detection the best precision is that of what comes next.
            let from = match place.checked_sub(1).map(|it| &found[it]) {
                Some(before) if !to.follows_false => [before.recall, before.precision],
                Some(before) => [before.recall, to.precision],
                None if to.follows_false => [0.0, to.precision],
                None => [to.recall, to.precision],
            };
            sum += if from[1] == to.precision {
                to.precision
            } else {
                on_line(recall_at(next), from, [to.recall, to.precision])
            };
            next += 1;
        }
    }
    let reached = found.last().map_or(0.0, |it| it.recall);
    if next < N_RECALLS && recall_at(next) == reached {
        sum += last_precision;
    }
    sum / N_RECALLS as f64
}

/// The means over what is found at 2 m.
fn mean_errors(class: &RankedClass, times: &[u16]) -> [f64; 3] {
    let (mut n, mut sums) = (0.0, [0.0; 3]);
    for detection in class.detections.iter().filter(|it| it.finds_at(ERROR_DISTANCE)) {
        let n_times = f64::from(times[detection.scan as usize]);
        let errors = class.errors_of(detection);
        n += n_times;
        sums[0] += n_times * errors.translation_m;
        sums[1] += n_times * errors.scale;
        sums[2] += n_times * errors.orientation_rad;
    }
    if n > 0.0 { sums.map(|it| it / n) } else { LARGEST_ERRORS }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocols::made_rows::{found, labelled, number, right_false_right};
    use crate::rows::ranked_box_row::RankedBoxRow;
    use proptest::prelude::*;

    const HERE: RankedProtocol = RankedProtocol::Argoverse2;

    #[track_caller]
    fn check(rows: &[RankedBoxRow], class: &str, metric: &str, expected: f64) {
        let value = number(rows, &[1, 1], class, metric).unwrap_or_else(|| panic!("{metric} of {class}"));
        assert!((value - expected).abs() < 1e-12, "{metric} of {class} is {value}, not {expected}");
    }

    #[test]
    fn one_class_can_be_done_in_the_head() {
        let rows = right_false_right(HERE, "BUS");
        // The best precision at a recall or higher: 1 at fifty of 101, 2/3 from 0.5 on.
        let average = (50.0 + 51.0 * 2.0 / 3.0) / 101.0;
        let composite = average * (1.0 - 0.25 + 1.0 - 0.2 + 1.0 - 0.3 / PI) / 3.0;
        for class in ["BUS", "present"] {
            check(&rows, class, "ap", average);
            check(&rows, class, "ate_m", 0.5);
            check(&rows, class, "cds", composite);
        }
        check(&rows, "BUS", "ap_4m", average);
        // 25 classes have nothing, and the largest errors.
        check(&rows, "all", "cds", composite / 26.0);
        check(&rows, "all", "ate_m", (0.5 + 25.0 * 2.0) / 26.0);
        check(&rows, "all", "aoe_rad", (0.3 + 25.0 * PI) / 26.0);
    }

    #[test]
    fn what_is_never_found_has_the_largest_errors() {
        let rows =
            [labelled(HERE, 0, "SIGN"), labelled(HERE, 1, "SIGN"), found(HERE, (0, 0), "SIGN", 0.5, None)];
        check(&rows, "SIGN", "ap", 0.0);
        check(&rows, "SIGN", "aoe_rad", PI);
        check(&rows, "SIGN", "cds", 0.0);
    }

    /// Mean over recalls as the definition reads: of each recall the best precision of all points from there on, on the straight line
    /// between points.
    fn slow_average(is_right: &[bool], n: usize) -> f64 {
        let mut points = Vec::new();
        let mut n_found = 0;
        for (place, it) in is_right.iter().enumerate() {
            n_found += usize::from(*it);
            points.push([n_found as f64 / n as f64, n_found as f64 / (place + 1) as f64]);
        }
        for place in (1..points.len()).rev() {
            points[place - 1][1] = points[place - 1][1].max(points[place][1]);
        }
        let at = |recall: f64| {
            let Some(first) = points.first() else { return 0.0 };
            let Some(last) = points.iter().rposition(|it| it[0] <= recall) else { return first[1] };
            match points.get(last + 1) {
                Some(next) => on_line(recall, points[last], *next),
                None if points[last][0] == recall => points[last][1],
                None => 0.0,
            }
        };
        (0..N_RECALLS).map(|it| at(recall_at(it))).sum::<f64>() / N_RECALLS as f64
    }

    proptest! {
        #[test]
        fn precision_is_as_the_definition_reads(is_right in prop::collection::vec(any::<bool>(), 0..40)) {
            let n = is_right.iter().filter(|it| **it).count() + 2;
            let mut rows: Vec<RankedBoxRow> = (0..n as u32).map(|it| labelled(HERE, it, "DOG")).collect();
            let numbered = is_right.iter().zip(0..);
            rows.extend(numbered.map(|(right, id)| {
                found(HERE, (0, id), "DOG", 1.0 - f64::from(id) / 64.0, right.then_some(0))
            }));
            let value = number(&rows, &vec![1; n], "DOG", "ap").unwrap();
            prop_assert!((value - slow_average(&is_right, n)).abs() < 1e-12);
        }
    }
}
