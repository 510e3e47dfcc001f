//! Sums over objects. Every ratio of a report is made of them, for any choice of scans.

use crate::rows::scan_row::ScanNumbers;
use crate::vocabulary::formula::{Formula, Term};
use crate::vocabulary::metric::Metric;

/// A sum for each [`Term`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sums([f64; Term::N]);

/// A power of two, far below the measured metres, nats and logarithms of times.
const STEP: f64 = 1.0 / (1_u64 << 32) as f64;

/// Whether every false detection is known to be one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FalseObjects {
    /// All are known.
    Known,
    /// Not every class is annotated, so an unmatched detection may be right.
    Unknown,
}

impl Sums {
    /// The sums over the objects of a scan, without its times; no false detections if they are unknown.
    pub(super) fn of_scan(numbers: &ScanNumbers) -> Self {
        let mut sums = Self::default();
        let ScanNumbers { counts, segmentation, .. } = numbers;
        for (term, value) in [
            (Term::Annotations, counts.no() as f64),
            (Term::Matched, counts.tp() as f64),
            (Term::False, counts.fo().unwrap_or(0) as f64),
            (Term::IgnoredAnnotations, numbers.n_ignored_annotations as f64),
            (Term::IgnoredDetections, numbers.n_ignored_detections as f64),
            (Term::Unknowable, numbers.n_unknowable_detections as f64),
            (Term::Split, segmentation.n_split as f64),
            (Term::Holding, segmentation.n_holding as f64),
            (Term::Joining, segmentation.n_joining as f64),
            (Term::Touching, segmentation.n_touching as f64),
            (Term::OverEntropy, segmentation.over_entropy_nats),
            (Term::UnderEntropy, segmentation.under_entropy_nats),
        ] {
            sums.add(term, value);
        }
        sums
    }

    /// The sum of `term`.
    pub fn of(&self, term: Term) -> f64 {
        self.0[term as usize]
    }

    /// Adds `value`, rounded to a multiple of `STEP`, to the sum of `term`. So the order of additions changes nothing: sums
    /// of up to two million have no other rounding.
    pub fn add(&mut self, term: Term, value: f64) {
        self.0[term as usize] += (value / STEP).round() * STEP;
    }

    /// Adds `other` multiplied by `times`.
    pub fn add_times(&mut self, other: &Self, times: f64) {
        for (sum, value) in self.0.iter_mut().zip(other.0) {
            *sum += times * value;
        }
    }

    /// Whether all sums are zero.
    pub fn is_zero(&self) -> bool {
        self.0.iter().all(|it| *it == 0.0)
    }

    /// Numerator and denominator of `metric`; `None` if it is no ratio of sums, or needs false detections that are unknown.
    pub fn ratio(&self, metric: &Metric, false_objects: FalseObjects) -> Option<[f64; 2]> {
        let formula = metric.formula();
        let Formula::Ratio(part, whole) = formula else { return None };
        false_objects.suffice_for(formula).then(|| [part, whole].map(|it| self.of_all(it)))
    }

    fn of_all(&self, terms: &[Term]) -> f64 {
        terms.iter().map(|it| self.of(*it)).sum()
    }

    /// The value of `formula`; `None` if it is not made of sums, needs unknown false detections, or is a ratio over zero.
    pub fn value(&self, formula: Formula, false_objects: FalseObjects) -> Option<f64> {
        if !false_objects.suffice_for(formula) {
            return None;
        }
        match formula {
            Formula::Sum(term) => Some(self.of(term)),
            Formula::Difference(left, right) => Some(self.of(left) - self.of(right)),
            Formula::Ratio(part, whole) => {
                let [part, whole] = [part, whole].map(|it| self.of_all(it));
                (whole > 0.0).then(|| part / whole)
            }
            Formula::GeometricMean(logarithms, n) => {
                let n = self.of(n);
                (n > 0.0).then(|| (self.of(logarithms) / n).exp())
            }
            Formula::NotOfSums => None,
        }
    }
}

impl FalseObjects {
    /// Whether the value of `formula` can be known.
    fn suffice_for(self, formula: Formula) -> bool {
        self == Self::Known || !formula.needs_false_detections()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::counts::Counts;

    fn four_annotations() -> Sums {
        let mut sums = Sums::default();
        let terms = [Term::Annotations, Term::Matched, Term::False, Term::BoxPairs, Term::LengthError];
        for (term, value) in terms.into_iter().zip([4.0, 3.0, 2.0, 2.0, 0.5]) {
            sums.add(term, value);
        }
        sums
    }

    #[test]
    fn the_order_of_additions_changes_nothing() {
        let values: Vec<f64> = (1..200).map(|it| f64::from(it).ln() / 7.0).collect();
        let sum = |values: &mut dyn Iterator<Item = &f64>| {
            let mut sums = Sums::default();
            values.for_each(|it| sums.add(Term::LengthError, *it));
            sums
        };
        let (first, second) = values.split_at(77);
        let mut of_halves = sum(&mut second.iter());
        of_halves.add_times(&sum(&mut first.iter()), 1.0);
        assert_eq!([sum(&mut values.iter()), of_halves], [sum(&mut values.iter().rev()); 2]);
    }

    #[test]
    fn ratios_are_those_of_the_counts() {
        let sums = four_annotations();
        let value = |metric: Metric| sums.value(metric.formula(), FalseObjects::Known);
        assert_eq!(value(Metric::Precision), Some(0.6));
        assert_eq!(value(Metric::Recall), Some(0.75));
        assert_eq!(value(Metric::FRate), Some(6.0 / 9.0));
        assert_eq!(value(Metric::Mo), Some(1.0));
        assert_eq!(value(Metric::BoxLengthError), Some(0.25));
        assert_eq!(value(Metric::UnderSegmentation), None);
        assert_eq!(value(Metric::FpsMean), None);
    }

    #[test]
    fn sums_of_counts_have_their_rates() {
        let counts = Counts::new(4, 3, Some(2)).unwrap();
        let sums = Sums::of_scan(&ScanNumbers::of_counts(counts));
        assert_eq!(sums.value(Metric::FRate.formula(), FalseObjects::Known), counts.f_rate());
        assert_eq!(sums.value(Metric::Recall.formula(), FalseObjects::Known), counts.recall());
        let unknown = ScanNumbers::of_counts(Counts::new(4, 3, None).unwrap());
        assert_eq!(Sums::of_scan(&unknown).of(Term::False), 0.0);
    }

    #[test]
    fn what_hangs_on_unknown_false_objects_is_unknown() {
        let value = |metric: Metric| four_annotations().value(metric.formula(), FalseObjects::Unknown);
        assert_eq!([Metric::Precision, Metric::FRate, Metric::Fo].map(value), [None; 3]);
        assert_eq!(value(Metric::Recall), Some(0.75));
    }

    #[test]
    fn twice_the_sums_are_the_same_ratio() {
        let mut twice = Sums::default();
        twice.add_times(&four_annotations(), 2.0);
        assert_eq!(twice.value(Metric::No.formula(), FalseObjects::Known), Some(8.0));
        assert_eq!(twice.value(Metric::FRate.formula(), FalseObjects::Known), Some(6.0 / 9.0));
    }
}
