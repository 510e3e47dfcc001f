//! Found, missed and false objects, and the rates made of them.

/// The objects of one or more scans.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    // Invariant: tp <= no.
    no: u64,
    tp: u64,
    fo: Option<u64>,
}

impl Counts {
    /// NO annotations that count, TP of them matched, FO detections that match nothing.
    ///
    /// `fo` is `None` where the data set does not annotate every class of object, so that detections beyond the annotations
    /// may be right or false. The result is `None` if more are matched than there are.
    pub fn new(no: u64, tp: u64, fo: Option<u64>) -> Option<Self> {
        (tp <= no).then_some(Self { no, tp, fo })
    }

    /// NO, the annotations that count.
    pub fn no(self) -> u64 {
        self.no
    }

    /// TP, the annotations found.
    pub fn tp(self) -> u64 {
        self.tp
    }

    /// MO = NO − TP, the annotations missed.
    pub fn mo(self) -> u64 {
        self.no - self.tp
    }

    /// FO, the false detections; `None` where they cannot be known.
    pub fn fo(self) -> Option<u64> {
        self.fo
    }

    /// ND = TP + FO, the detections that count; `None` where FO cannot be known.
    pub fn nd(self) -> Option<u64> {
        Some(self.tp + self.fo?)
    }

    /// TP / ND; `None` where that is undefined.
    pub fn precision(self) -> Option<f64> {
        ratio(self.tp, self.nd()?)
    }

    /// TP / NO; `None` where that is undefined.
    pub fn recall(self) -> Option<f64> {
        ratio(self.tp, self.no)
    }

    /// 2 TP / (2 TP + MO + FO) = 2 TP / (NO + ND), the harmonic mean of precision and recall; `None` where that is
    /// undefined.
    ///
    /// Paper: HG section 5, VM section 6.
    pub fn f_rate(self) -> Option<f64> {
        ratio(2 * self.tp, self.no + self.nd()?)
    }

    /// A rate as a point of a curve: `None` where nothing is annotated, since one false detection would draw it to 0.
    pub fn drawn(self, rate: fn(Self) -> Option<f64>) -> Option<f64> {
        rate(self).filter(|_| self.no > 0)
    }
}

impl std::ops::AddAssign for Counts {
    /// Adds the objects of both; FO of the sum is known only where both are.
    fn add_assign(&mut self, other: Self) {
        self.no += other.no;
        self.tp += other.tp;
        self.fo = self.fo.zip(other.fo).map(|(ours, theirs)| ours + theirs);
    }
}

fn ratio(numerator: u64, denominator: u64) -> Option<f64> {
    (denominator > 0).then(|| numerator as f64 / denominator as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(no: u64, tp: u64, fo: Option<u64>) -> Counts {
        Counts::new(no, tp, fo).unwrap()
    }

    #[track_caller]
    fn check(of: Counts, precision: Option<f64>, recall: Option<f64>, f_rate: Option<f64>) {
        assert_eq!((of.precision(), of.recall(), of.f_rate()), (precision, recall, f_rate));
    }

    #[test]
    fn rates_are_ratios_of_counts() {
        check(counts(4, 3, Some(2)), Some(0.6), Some(0.75), Some(6.0 / 9.0));
    }

    #[test]
    fn unknown_false_objects_leave_recall_only() {
        check(counts(4, 3, None), None, Some(0.75), None);
    }

    #[test]
    fn curves_have_no_point_where_nothing_is_annotated() {
        let only_false = counts(0, 0, Some(1));
        check(only_false, Some(0.0), None, Some(0.0));
        assert_eq!([Counts::precision, Counts::f_rate].map(|it| only_false.drawn(it)), [None, None]);
        assert_eq!(counts(4, 0, Some(1)).drawn(Counts::f_rate), Some(0.0));
    }

    #[test]
    fn nothing_to_find_and_nothing_found_is_undefined() {
        check(counts(0, 0, Some(0)), None, None, None);
    }

    #[test]
    fn nothing_to_find_but_something_found_is_zero() {
        check(counts(0, 0, Some(1)), Some(0.0), None, Some(0.0));
    }

    #[test]
    fn more_matches_than_annotations_are_refused() {
        assert_eq!(Counts::new(3, 4, Some(0)), None);
    }

    #[test]
    fn a_sum_with_unknown_false_objects_does_not_know_them() {
        let mut sum = counts(4, 3, Some(2));
        sum += counts(6, 2, None);
        assert_eq!(sum, counts(10, 5, None));
    }
}
