//! The cell size that a reading of the fitness recommends, and its cost.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::numbers::rank_correlation::rank_correlation;
use crate::numbers::sweep_curve::{SweepCurve, highest};
use crate::numbers::sweep_score::SweepScores;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::task::Task;

/// Stands instead of a reading for the cell size that the detector has where it is not swept.
pub const CONFIGURED: &str = "as configured";

row! {
    /// One reading on one curve: a row of `cell_fitness.csv`.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct FitnessVerdict {
        /// The data set.
        pub(crate) dataset: String,
        /// Where the scans come from.
        pub(crate) origin: Origin,
        /// The sensor.
        pub(crate) sensor: String,
        /// The detector.
        pub(crate) detector: String,
        /// What else is swept, as `name = value`.
        pub(crate) others: String,
        /// The task.
        pub(crate) task: Task,
        /// Annotations that count.
        pub(crate) no: u64,
        /// Which rate is meant by the following.
        pub(crate) rate: String,
        /// Cell sizes that were tried.
        pub(crate) n_points: u64,
        /// The best of them, in metres.
        pub(crate) best_cell_size_m: Option<Fixed<3>>,
        /// The rate there.
        pub(crate) best_rate: Option<Fixed<6>>,
        /// The reading.
        pub(crate) reading: String,
        /// Cell sizes at which it has a value, within its range if it has one.
        pub(crate) n_defined: u64,
        /// Cell sizes at which it is undefined, and pairs of neighbouring ones with a pole between them.
        pub(crate) n_poles: u64,
        /// The cell size it recommends, in metres.
        pub(crate) recommended_cell_size_m: Option<Fixed<3>>,
        /// Whether that is the smallest or the greatest that was tried, so that it may recommend any other beyond.
        pub(crate) recommends_an_end: Option<bool>,
        /// The rate there.
        pub(crate) rate_there: Option<Fixed<6>>,
        /// What is lost against the best cell size.
        pub(crate) loss: Option<Fixed<6>>,
        /// Spearman's rank correlation of reading and rate over the cell sizes.
        pub(crate) rank_correlation: Option<Fixed<4>>,
    }
}

/// The verdicts on every reading on every curve over cell sizes.
pub fn fitness_verdicts(sweep: &SweepScores) -> Vec<FitnessVerdict> {
    let curves = sweep.curves();
    let over_cells = curves.iter().filter(|it| it.sweeps_cells());
    let configured = sweep.configured.as_deref().and_then(|it| it.parse::<f64>().ok());
    over_cells.flat_map(|curve| of_curve(curve, configured)).collect()
}

/// The verdicts on the readings, and for comparison on the cell size that the detector has anyway.
fn of_curve(curve: &SweepCurve<'_>, configured: Option<f64>) -> Vec<FitnessVerdict> {
    let mut verdicts: Vec<_> = (0..n_readings(curve)).map(|it| verdict(curve, it)).collect();
    let index =
        configured.and_then(|configured| curve.points.iter().position(|it| (it.x - configured).abs() < 1e-6));
    if let (Some(index), Some(first)) = (index, verdicts.first().cloned()) {
        let point = curve.points[index].reached;
        let size_m = point.cells.as_ref().map(|it| Fixed(it.cell_size_m));
        verdicts.push(FitnessVerdict {
            reading: CONFIGURED.to_owned(),
            n_defined: 1,
            n_poles: 0,
            recommended_cell_size_m: size_m,
            recommends_an_end: None,
            rate_there: point.rate().map(Fixed),
            loss: first.best_rate.zip(point.rate()).map(|(best, there)| Fixed(best.0 - there)),
            rank_correlation: None,
            ..first
        });
    }
    verdicts
}

fn n_readings(curve: &SweepCurve<'_>) -> usize {
    curve.first().cells.as_ref().map_or(0, |it| it.readings.len())
}

fn verdict(curve: &SweepCurve<'_>, reading_idx: usize) -> FitnessVerdict {
    let first = curve.first();
    let cells = curve.points.iter().filter_map(|it| it.reached.cells.as_ref());
    let readings: Vec<_> = cells.clone().map(|it| &it.readings[reading_idx]).collect();
    let sizes_m: Vec<f64> = cells.map(|it| it.cell_size_m).collect();
    let rate = |index: usize| curve.points[index].reached.rate();
    let best = curve.best();
    let recommended = highest(readings.iter().map(|it| it.in_range()));
    let ends = sizes_m.iter().fold([f64::INFINITY, 0.0_f64], |[low, high], it| [low.min(*it), high.max(*it)]);
    let pairs = readings.iter().enumerate().filter_map(|(index, it)| Some((it.in_range()?, rate(index)?)));
    let best_rate = best.and_then(|it| it.reached.rate());
    let best_cells = best.and_then(|it| it.reached.cells.as_ref());
    let rate_there = recommended.and_then(rate);
    FitnessVerdict {
        dataset: first.subject.extent.name().to_owned(),
        origin: first.subject.origin,
        sensor: first.subject.sensor.clone(),
        detector: first.subject.detector.clone(),
        others: curve.others.join(", "),
        task: first.task,
        no: first.counts.no(),
        rate: first.rate_name().to_owned(),
        n_points: curve.points.len() as u64,
        best_cell_size_m: best_cells.map(|it| Fixed(it.cell_size_m)),
        best_rate: best_rate.map(Fixed),
        reading: readings[0].name.to_owned(),
        n_defined: readings.iter().filter(|it| it.in_range().is_some()).count() as u64,
        n_poles: n_poles(&readings.iter().map(|it| it.value).collect::<Vec<_>>(), readings[0].range),
        recommended_cell_size_m: recommended.map(|it| Fixed(sizes_m[it])),
        recommends_an_end: recommended.map(|it| ends.contains(&sizes_m[it])),
        rate_there: rate_there.map(Fixed),
        loss: best_rate.zip(rate_there).map(|(best, there)| Fixed(best - there)),
        rank_correlation: rank_correlation(&pairs.collect::<Vec<_>>()).map(Fixed),
    }
}

/// Number of places where a reading whose numerator never falls below 0 has no value, or changes its sign to the next.
fn n_poles(values: &[Option<f64>], range: Option<[f64; 2]>) -> u64 {
    if range.is_none() {
        return 0;
    }
    let n_undefined = values.iter().filter(|it| it.is_none()).count();
    let changes = |pair: &&[Option<f64>]| matches!(pair, [Some(a), Some(b)] if a * b < 0.0);
    (n_undefined + values.windows(2).filter(changes).count()) as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::sweep_score::tests::{cell_sizes, four_cell_sizes};

    #[test]
    fn a_reading_loses_what_lies_between_its_choice_and_the_best() {
        let sweep = four_cell_sizes();
        let verdicts = fitness_verdicts(&sweep);
        let [printed, share, configured] = &verdicts[..] else { panic!("{verdicts:?}") };
        assert_eq!((printed.best_cell_size_m, printed.best_rate), (Some(Fixed(0.4)), Some(Fixed(0.8))));
        // Only the last point is where the formula is said to be; there is a pole before 0.6 m.
        assert_eq!((printed.n_defined, printed.n_poles), (1, 1));
        assert_eq!(
            (printed.recommended_cell_size_m, printed.recommends_an_end),
            (Some(Fixed(0.8)), Some(true))
        );
        assert_eq!(printed.rank_correlation, None);
        assert_eq!(
            (configured.recommended_cell_size_m, configured.loss),
            (Some(Fixed(0.4)), Some(Fixed(0.0)))
        );
        assert_eq!((share.recommended_cell_size_m, share.recommends_an_end), (Some(Fixed(0.6)), Some(false)));
        assert!((share.loss.unwrap().0 - 0.2).abs() < 1e-12);
        // Ranks 1 3 4 2 against 1 4 3 2: 1 - 6 · 2 / 60.
        assert!((share.rank_correlation.unwrap().0 - 0.8).abs() < 1e-12);
    }

    #[test]
    fn where_false_objects_are_unknown_recall_is_what_counts() {
        let verdicts = fitness_verdicts(&cell_sizes(&[(4, None, None, 0.1), (8, None, None, 0.3)]));
        assert_eq!((verdicts[0].rate.as_str(), verdicts[0].n_poles), ("recall", 2));
        assert_eq!((verdicts[0].best_rate, verdicts[0].rate_there), (Some(Fixed(0.8)), None));
        assert_eq!(verdicts[1].loss, Some(Fixed(0.0)));
    }

    #[test]
    fn other_parameters_have_no_fitness() {
        let mut sweep = cell_sizes(&[(4, None, None, 0.1), (8, None, None, 0.3)]);
        sweep.scores[1].cells.as_mut().unwrap().cell_size_m = 0.2;
        assert!(fitness_verdicts(&sweep).is_empty());
    }
}
