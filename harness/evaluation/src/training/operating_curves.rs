//! True and false vehicles of a classifier as its threshold falls.

/// Counts of objects classified as vehicles at one threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatingPoint {
    /// The least decision value that makes a vehicle.
    pub threshold: f32,
    /// Vehicles among the objects classified as vehicles.
    pub n_true: usize,
    /// Others among the objects classified as vehicles.
    pub n_false: usize,
}

/// All operating points of a classifier on judged objects, the highest threshold first.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatingCurves {
    // Invariant: thresholds fall, both counts never do, and the last point holds all objects.
    points: Vec<OperatingPoint>,
}

impl OperatingCurves {
    /// The curves of `judged`: decision values, none of them NaN, and whether the object is a vehicle. Equal values give one
    /// point.
    pub fn of(judged: impl Iterator<Item = (f32, bool)>) -> Self {
        let mut judged: Vec<(f32, bool)> = judged.collect();
        judged.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut points: Vec<OperatingPoint> = Vec::new();
        let (mut n_true, mut n_false) = (0, 0);
        for equal in judged.chunk_by(|a, b| a.0 == b.0) {
            let n_vehicles = equal.iter().filter(|it| it.1).count();
            n_true += n_vehicles;
            n_false += equal.len() - n_vehicles;
            points.push(OperatingPoint { threshold: equal[0].0, n_true, n_false });
        }
        Self { points }
    }

    /// The points, the highest threshold first.
    pub fn points(&self) -> &[OperatingPoint] {
        &self.points
    }

    /// Number of vehicles, and of others.
    pub fn totals(&self) -> [usize; 2] {
        self.points.last().map_or([0, 0], |it| [it.n_true, it.n_false])
    }

    /// Area under the receiver operating characteristic: how often a vehicle has a higher value than another object; equal
    /// values count half. `None` without vehicles or without others.
    pub fn roc_area(&self) -> Option<f64> {
        let [n_vehicles, n_others] = self.totals();
        let mut before = [0, 0];
        let mut twice = 0;
        for it in &self.points {
            twice += (it.n_false - before[1]) * (it.n_true + before[0]);
            before = [it.n_true, it.n_false];
        }
        let pairs = 2 * n_vehicles * n_others;
        (pairs > 0).then(|| twice as f64 / pairs as f64)
    }

    /// Area under precision over recall, as a step function: the mean precision at which a vehicle is found. `None` without
    /// vehicles.
    pub fn precision_recall_area(&self) -> Option<f64> {
        let [n_vehicles, _] = self.totals();
        let mut n_before = 0;
        let mut sum = 0.0;
        for it in &self.points {
            sum += (it.n_true - n_before) as f64 * it.n_true as f64 / (it.n_true + it.n_false) as f64;
            n_before = it.n_true;
        }
        (n_vehicles > 0).then(|| sum / n_vehicles as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(judged: &[(f32, bool)], roc: Option<f64>, precision_recall: Option<f64>) {
        let curves = OperatingCurves::of(judged.iter().copied());
        let same = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => (a - b).abs() < 1e-12,
            (a, b) => a == b,
        };
        assert!(same(curves.roc_area(), roc), "{:?}", curves.roc_area());
        let area = curves.precision_recall_area();
        assert!(same(area, precision_recall), "{area:?}");
    }

    #[test]
    fn areas_are_those_worked_out_by_hand() {
        check(&[(2.0, true), (1.0, true), (-1.0, false)], Some(1.0), Some(1.0));
        check(&[(2.0, false), (1.0, true)], Some(0.0), Some(0.5));
        check(&[(1.0, false), (1.0, true)], Some(0.5), Some(0.5));
        // Of four pairs three are in order; precision 1 at the first vehicle, 2/3 at the second.
        check(&[(4.0, true), (3.0, false), (2.0, true), (1.0, false)], Some(0.75), Some(5.0 / 6.0));
    }

    #[test]
    fn areas_over_nothing_are_undefined() {
        check(&[], None, None);
        check(&[(1.0, false)], None, None);
        check(&[(1.0, true)], None, Some(1.0));
    }
}
