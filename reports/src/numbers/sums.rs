//! Sums over objects, of which every ratio of a report is made: those of any choice of scans give its ratios.

use crate::rows::counts::Counts;
use crate::rows::scan_row::ScanNumbers;
use crate::vocabulary::metric::{BoxDimension, Metric};

/// What is summed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Term {
    /// NO, the annotations that count.
    Annotations,
    /// TP, those found.
    Matched,
    /// FO, the false detections.
    False,
    /// Annotations that are neither found nor missed.
    IgnoredAnnotations,
    /// Detections that are neither right nor false.
    IgnoredDetections,
    /// Detections of which it cannot be known whether they are false.
    Unknowable,
    /// Annotations that are torn apart.
    Split,
    /// Detections that hold an annotation.
    Holding,
    /// Of these, those that hold several.
    Joining,
    /// Entropy of the annotations over the detections, in nats.
    OverEntropy,
    /// Entropy of the detections over the annotations, in nats.
    UnderEntropy,
    /// Detections with a point of an annotation.
    Touching,
    /// Matched pairs both of which have a box.
    BoxPairs,
    /// Distances of the centres of these, in metres.
    CenterError,
    /// Differences of their lengths, in metres.
    LengthError,
    /// Differences of their widths, in metres.
    WidthError,
    /// Angles between their headings, in degrees.
    YawError,
    /// Scans whose time counts and was measured beside that of the reference.
    TimedScans,
    /// Logarithms of the times of these over those of the reference.
    LogTimeRatio,
    /// Logarithms of the times of the reference in milliseconds.
    LogReference,
}

const N_TERMS: usize = 20;

/// A sum for each [`Term`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sums([f64; N_TERMS]);

/// Whether every false detection is known to be one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FalseObjects {
    /// All are known.
    Known,
    /// Not every class is annotated, so what matches nothing may be right.
    Unknown,
}

/// What a metric is a ratio of.
pub const RATIOS: [Metric; 11] = [
    Metric::Precision,
    Metric::Recall,
    Metric::FRate,
    Metric::OverSegmentation,
    Metric::UnderSegmentation,
    Metric::OverSegmentationEntropyPerObject,
    Metric::UnderSegmentationEntropyPerObject,
    Metric::BoxError(BoxDimension::Center),
    Metric::BoxError(BoxDimension::Length),
    Metric::BoxError(BoxDimension::Width),
    Metric::BoxError(BoxDimension::Yaw),
];

impl Sums {
    /// What was found, missed and false; nothing false where that is not known.
    pub fn of_counts(counts: Counts) -> Self {
        let mut sums = Self::default();
        sums.add(Term::Annotations, counts.no() as f64);
        sums.add(Term::Matched, counts.tp() as f64);
        sums.add(Term::False, counts.fo().unwrap_or(0) as f64);
        sums
    }

    /// The objects of a scan; its times are not in it.
    pub(super) fn of_scan(numbers: &ScanNumbers) -> Self {
        let mut sums = Self::of_counts(numbers.counts);
        let segmentation = &numbers.segmentation;
        for (term, value) in [
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

    /// Adds `value` to the sum of `term`.
    pub fn add(&mut self, term: Term, value: f64) {
        self.0[term as usize] += value;
    }

    /// Adds `other` as often as `times` says.
    pub fn add_times(&mut self, other: &Self, times: f64) {
        for (sum, value) in self.0.iter_mut().zip(other.0) {
            *sum += times * value;
        }
    }

    /// Whether there is nothing in any sum.
    pub fn is_zero(&self) -> bool {
        self.0.iter().all(|it| *it == 0.0)
    }

    /// Numerator and denominator of `metric`; `None` if it is no ratio of sums, or cannot be known.
    pub fn ratio(&self, metric: &Metric, false_objects: FalseObjects) -> Option<[f64; 2]> {
        let [no, tp, fo] = [Term::Annotations, Term::Matched, Term::False].map(|it| self.of(it));
        let pairs = self.of(Term::BoxPairs);
        let known = |ratio| (false_objects == FalseObjects::Known).then_some(ratio);
        match metric {
            Metric::Precision => known([tp, tp + fo]),
            Metric::FRate => known([2.0 * tp, no + tp + fo]),
            Metric::Recall => Some([tp, no]),
            Metric::OverSegmentation => Some([self.of(Term::Split), no]),
            Metric::UnderSegmentation => Some([self.of(Term::Joining), self.of(Term::Holding)]),
            Metric::OverSegmentationEntropyPerObject => Some([self.of(Term::OverEntropy), no]),
            Metric::UnderSegmentationEntropyPerObject => {
                Some([self.of(Term::UnderEntropy), self.of(Term::Touching)])
            }
            Metric::BoxError(dimension) => Some([self.of(error_term(*dimension)), pairs]),
            _ => None,
        }
    }

    /// The geometric mean over scans of the time of detection over that of the reference; `None` if none was timed beside
    /// it.
    pub fn time_ratio(&self) -> Option<f64> {
        let n = self.of(Term::TimedScans);
        (n > 0.0).then(|| (self.of(Term::LogTimeRatio) / n).exp())
    }

    /// The geometric mean over scans of the time of the reference in milliseconds; `None` if it was not timed.
    pub fn reference_ms(&self) -> Option<f64> {
        let n = self.of(Term::TimedScans);
        (n > 0.0).then(|| (self.of(Term::LogReference) / n).exp())
    }

    /// The value of `metric`, a ratio or a sum; `None` if it is neither, cannot be known, or its denominator is zero.
    pub fn value(&self, metric: &Metric, false_objects: FalseObjects) -> Option<f64> {
        if let Some([numerator, denominator]) = self.ratio(metric, false_objects) {
            return (denominator > 0.0).then(|| numerator / denominator);
        }
        Some(match (metric, false_objects) {
            (Metric::No, _) => self.of(Term::Annotations),
            (Metric::Tp, _) => self.of(Term::Matched),
            (Metric::Mo, _) => self.of(Term::Annotations) - self.of(Term::Matched),
            (Metric::Fo, FalseObjects::Known) => self.of(Term::False),
            (Metric::IgnoredAnnotations, _) => self.of(Term::IgnoredAnnotations),
            (Metric::IgnoredDetections, _) => self.of(Term::IgnoredDetections),
            (Metric::UnknowableDetections, _) => self.of(Term::Unknowable),
            (Metric::OverSegmentationEntropy, _) => self.of(Term::OverEntropy),
            (Metric::UnderSegmentationEntropy, _) => self.of(Term::UnderEntropy),
            (Metric::TimeRatio, _) => return self.time_ratio(),
            (Metric::ReferenceTime, _) => return self.reference_ms(),
            _ => return None,
        })
    }
}

fn error_term(dimension: BoxDimension) -> Term {
    match dimension {
        BoxDimension::Center => Term::CenterError,
        BoxDimension::Length => Term::LengthError,
        BoxDimension::Width => Term::WidthError,
        BoxDimension::Yaw => Term::YawError,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn four_annotations() -> Sums {
        let mut sums = Sums::default();
        let terms = [Term::Annotations, Term::Matched, Term::False, Term::BoxPairs, Term::LengthError];
        for (term, value) in terms.into_iter().zip([4.0, 3.0, 2.0, 2.0, 0.5]) {
            sums.add(term, value);
        }
        sums
    }

    #[test]
    fn ratios_are_those_of_the_counts() {
        let sums = four_annotations();
        let value = |metric| sums.value(&metric, FalseObjects::Known);
        assert_eq!(value(Metric::Precision), Some(0.6));
        assert_eq!(value(Metric::Recall), Some(0.75));
        assert_eq!(value(Metric::FRate), Some(6.0 / 9.0));
        assert_eq!(value(Metric::Mo), Some(1.0));
        assert_eq!(value(Metric::BoxError(BoxDimension::Length)), Some(0.25));
        assert_eq!(value(Metric::UnderSegmentation), None);
        assert_eq!(value(Metric::FpsMean), None);
    }

    #[test]
    fn sums_of_counts_have_their_rates() {
        let counts = Counts::new(4, 3, Some(2)).unwrap();
        let sums = Sums::of_counts(counts);
        assert_eq!(sums.value(&Metric::FRate, FalseObjects::Known), counts.f_rate());
        assert_eq!(sums.value(&Metric::Recall, FalseObjects::Known), counts.recall());
        assert_eq!(Sums::of_counts(Counts::new(4, 3, None).unwrap()).of(Term::False), 0.0);
    }

    #[test]
    fn what_hangs_on_unknown_false_objects_is_unknown() {
        let value = |metric| four_annotations().value(&metric, FalseObjects::Unknown);
        assert_eq!([Metric::Precision, Metric::FRate, Metric::Fo].map(value), [None; 3]);
        assert_eq!(value(Metric::Recall), Some(0.75));
    }

    #[test]
    fn every_ratio_has_two_sums() {
        assert!(RATIOS.iter().all(|it| Sums::default().ratio(it, FalseObjects::Known).is_some()));
        assert_eq!(Term::LogReference as usize + 1, N_TERMS);
    }

    #[test]
    fn twice_the_sums_are_the_same_ratio() {
        let mut twice = Sums::default();
        twice.add_times(&four_annotations(), 2.0);
        assert_eq!(twice.value(&Metric::No, FalseObjects::Known), Some(8.0));
        assert_eq!(twice.value(&Metric::FRate, FalseObjects::Known), Some(6.0 / 9.0));
    }
}
