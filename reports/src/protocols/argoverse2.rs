//! Argoverse 2's detection challenge: average precision over centre distances, three errors, and CDS.
//!
//! Wilson et al.: Argoverse 2: Next Generation Datasets for Self-Driving Perception and Forecasting, `NeurIPS` 2021, section
//! 4.1; av2 0.3.6 where both differ.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::argoverse2_precisions::average_precisions;
use super::drawn_scans::{Times, add};
use super::protocol_number::{ALL_CLASSES, PRESENT_CLASSES, ProtocolMetric};
use super::ranked_classes::{RankedClass, RankedScan};
use super::under_protocol::Ranking;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::metric::Direction;
use crate::vocabulary::protocol::{ERROR_DISTANCE, PAIR_DISTANCES_M, Protocol};

/// Largest errors: those of a class of which nothing is found. For CDS each error is divided by its largest.
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

/// Number of these, from the first on, that are averaged over classes.
const N_SUMMED_UP: usize = 5;

/// Boxes of one detector, class by class.
pub(super) struct Argoverse2 {
    classes: Vec<RankedClass>,
}

impl Argoverse2 {
    /// Takes the rows of `scans`, which ascend.
    pub(super) fn new(scans: &[ScanName], rows: &BTreeMap<ScanName, RankedScan>) -> Self {
        Self { classes: RankedClass::all(Protocol::Argoverse2, scans, rows) }
    }

    /// Classes with annotations in the scans, each with its index.
    fn present(&self) -> impl Iterator<Item = (usize, &RankedClass)> {
        self.classes.iter().enumerate().filter(|(_, class)| class.n() > 0)
    }

    fn values_of(&self, scores: &[Option<ClassScores>]) -> Vec<Option<f64>> {
        let nothing = ClassScores { numbers: ClassScores::of_nothing(), average_precisions: [0.0; 4] };
        let mean = |of: &[&ClassScores]| -> [Option<f64>; N_SUMMED_UP] {
            std::array::from_fn(|number| {
                let sum: f64 = of.iter().map(|it| it.numbers[number]).sum();
                (!of.is_empty()).then(|| sum / of.len() as f64)
            })
        };
        let all: Vec<&ClassScores> = scores.iter().map(|it| it.as_ref().unwrap_or(&nothing)).collect();
        let present: Vec<&ClassScores> = scores.iter().flatten().collect();
        // Without annotations of evaluated classes the protocol says nothing about a detector.
        let all = if self.present().next().is_some() { all } else { Vec::new() };
        let mut values: Vec<Option<f64>> = mean(&all).into_iter().chain(mean(&present)).collect();
        for (index, _) in self.present() {
            let numbers: [Option<f64>; OF_CLASS.len()] = match &scores[index] {
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

impl Ranking for Argoverse2 {
    fn metrics(&self) -> Vec<ProtocolMetric> {
        let names = Protocol::Argoverse2.ranked_classes();
        let n = self.classes.iter().map(RankedClass::n).sum();
        let of_several = [ALL_CLASSES, PRESENT_CLASSES].into_iter().flat_map(|class| {
            OF_CLASS[..N_SUMMED_UP].iter().map(move |it| ProtocolMetric::new(class, *it, n))
        });
        let of_classes = self
            .present()
            .flat_map(|(index, class)| OF_CLASS.map(|it| ProtocolMetric::new(names[index], it, class.n())));
        of_several.chain(of_classes).collect()
    }

    fn of_draws<const N: usize>(&self, times: &[Times<N>]) -> [Vec<Option<f64>>; N] {
        let scores: Vec<[Option<ClassScores>; N]> =
            self.classes.iter().map(|class| ClassScores::of(class, times)).collect();
        std::array::from_fn(|draw| self.values_of(&scores.iter().map(|it| it[draw]).collect::<Vec<_>>()))
    }
}

/// The numbers of a class.
#[derive(Debug, Clone, Copy)]
struct ClassScores {
    // AP, ATE, ASE, AOE, CDS.
    numbers: [f64; N_SUMMED_UP],
    average_precisions: [f64; PAIR_DISTANCES_M.len()],
}

impl ClassScores {
    /// Numbers of a class without annotations, or of which nothing is found.
    fn of_nothing() -> [f64; N_SUMMED_UP] {
        let [translation_m, scale, orientation_rad] = LARGEST_ERRORS;
        [0.0, translation_m, scale, orientation_rad, 0.0]
    }

    /// Scores in each draw; `None` for a draw without annotations.
    fn of<const N: usize>(class: &RankedClass, times: &[Times<N>]) -> [Option<Self>; N] {
        let n_annotations = class.n_annotations(times);
        let of_distances = average_precisions(class, times, &n_annotations);
        let errors = mean_errors(class, times);
        std::array::from_fn(|draw| {
            let average_precisions = of_distances.map(|it| it[draw]);
            (n_annotations[draw] > 0.0).then(|| Self::made_of(average_precisions, errors[draw]))
        })
    }

    fn made_of(average_precisions: [f64; PAIR_DISTANCES_M.len()], errors: [f64; 3]) -> Self {
        let precision = average_precisions.iter().sum::<f64>() / average_precisions.len() as f64;
        let complements: f64 =
            errors.iter().zip(LARGEST_ERRORS).map(|(error, largest)| 1.0 - error / largest).sum();
        let composite = precision * (complements / errors.len() as f64);
        let numbers = [precision, errors[0], errors[1], errors[2], composite];
        Self { numbers, average_precisions }
    }
}

/// Mean errors of the detections that find an annotation at 2 m, in each draw.
fn mean_errors<const N: usize>(class: &RankedClass, times: &[Times<N>]) -> [[f64; 3]; N] {
    let (mut n, mut sums) = ([0.0; N], [[0.0; N]; 3]);
    for (index, errors) in class.errors() {
        let n_times = class.times_of(index, times);
        add(&mut n, n_times);
        let errors = [errors.translation_m, errors.scale, errors.orientation_rad];
        for (sums, error) in sums.iter_mut().zip(errors) {
            add(sums, &n_times.map(|it| it * error));
        }
    }
    std::array::from_fn(|draw| if n[draw] > 0.0 { sums.map(|it| it[draw] / n[draw]) } else { LARGEST_ERRORS })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocols::made_rows::{any_times, check_draws, found, labelled, number, right_false_right};
    use crate::protocols::recall_grid::{N_RECALLS, on_line, recall_at};
    use crate::rows::ranked_box_row::RankedBoxRow;
    use proptest::prelude::*;

    const HERE: Protocol = Protocol::Argoverse2;

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
        // 25 classes have no annotations, and so the largest errors.
        check(&rows, "all", "cds", composite / 26.0);
        check(&rows, "all", "ate_m", (0.5 + 25.0 * 2.0) / 26.0);
        check(&rows, "all", "aoe_rad", (0.3 + 25.0 * PI) / 26.0);
    }

    #[test]
    fn what_is_never_found_has_the_largest_errors() {
        let rows =
            [labelled(HERE, 0, "SIGN"), labelled(HERE, 1, "SIGN"), found(HERE, 0, 0, "SIGN", 0.5, None)];
        check(&rows, "SIGN", "ap", 0.0);
        check(&rows, "SIGN", "aoe_rad", PI);
        check(&rows, "SIGN", "cds", 0.0);
    }

    /// Mean over recalls by the definition: at each recall the best precision there or beyond, interpolated linearly between
    /// points.
    fn slow_average(is_right: &[bool], n: usize) -> f64 {
        let mut points = Vec::new();
        let mut n_found = 0;
        for (index, it) in is_right.iter().enumerate() {
            n_found += usize::from(*it);
            points.push([n_found as f64 / n as f64, n_found as f64 / (index + 1) as f64]);
        }
        for index in (1..points.len()).rev() {
            points[index - 1][1] = points[index - 1][1].max(points[index][1]);
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
                found(HERE, 0, id, "DOG", 1.0 - f64::from(id) / 64.0, right.then_some(0))
            }));
            let value = number(&rows, &vec![1; n], "DOG", "ap").unwrap();
            prop_assert!((value - slow_average(&is_right, n)).abs() < 1e-12);
        }

        #[test]
        fn several_draws_at_once_have_the_values_of_each(
            drawn in prop::collection::vec((0..4_u32, 0..5_u8, any::<bool>()), 0..30), times in any_times(4)
        ) {
            let mut rows: Vec<RankedBoxRow> = (0..8).map(|it| labelled(HERE, it % 4, "DOG")).collect();
            let numbered = drawn.iter().zip(0..);
            rows.extend(numbered.map(|((scan, score, right), id)| {
                found(HERE, *scan, id, "DOG", f64::from(*score), right.then_some(0))
            }));
            check_draws(&rows, &times);
        }
    }
}
