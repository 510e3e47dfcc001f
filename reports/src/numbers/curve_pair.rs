//! One statistic measured on two collections of scans, bin by bin, and how well the two agree.

/// Largest ratio of two values that count as alike, either way.
pub const ALIKE_FACTOR: f64 = 1.5;

/// One value for each side of a comparison: the judged side on the left, its reference on the right.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sides<T> {
    /// Value of the judged side.
    pub left: T,
    /// Value of the reference.
    pub right: T,
}

impl<T> Sides<T> {
    /// Applies `change` to both sides.
    pub fn map<U>(self, mut change: impl FnMut(T) -> U) -> Sides<U> {
        Sides { left: change(self.left), right: change(self.right) }
    }

    /// Both sides by reference.
    pub fn as_ref(&self) -> Sides<&T> {
        Sides { left: &self.left, right: &self.right }
    }
}

/// One statistic of both sides over the same bins.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePair {
    /// Its name in files: lower case, words joined by `_`.
    pub statistic: &'static str,
    /// The statistic for people, such as `points per square metre`.
    pub title: &'static str,
    /// The length that the bins divide, such as `range`; `None` if they are kinds of something, not stretches in metres.
    pub bins_of: Option<&'static str>,
    /// A stretch in metres whose agreement is also reported separately; it begins and ends where bins do.
    pub focus_m: Option<[f64; 2]>,
    /// Unit of the values.
    pub unit: &'static str,
    /// Things that the counts `n` of the bins are of, such as `scans`.
    pub counted: &'static str,
    /// Least `n` of a bin on each side for its ratio to be defined.
    pub least_n: Sides<u64>,
    /// The bins, in order.
    pub bins: Vec<CurveBin>,
}

/// One bin of both curves.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveBin {
    /// Its name within the statistic.
    pub name: String,
    /// Its ends in metres; `None` if it is a kind of something.
    pub ends_m: Option<[f64; 2]>,
    /// The values of both sides.
    pub measured: Sides<Measured>,
}

/// A value and the number of things it is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// The value, finite; `None` if it is undefined, such as the median of nothing.
    pub value: Option<f64>,
    /// Number of things it is made of.
    pub n: u64,
}

/// How well the two curves of a pair agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    /// Number of bins, with or without a ratio.
    pub n_bins: usize,
    /// Number of bins whose ratio is defined.
    pub n_compared: usize,
    /// Of these, those whose ratio is within [`ALIKE_FACTOR`].
    pub n_alike: usize,
    /// Median of the ratios; the smaller of the two in the middle if their number is even.
    pub median_ratio: f64,
    /// The bin whose ratio is farthest from 1, as an index into [`CurvePair::bins`].
    pub worst_bin_idx: usize,
}

impl CurvePair {
    /// Left over right in bin `bin_idx`; `None` if either side has too small an `n` or no value, or the right one is 0.
    pub fn ratio(&self, bin_idx: usize) -> Option<f64> {
        let Sides { left, right } = self.bins[bin_idx].measured;
        let is_enough = left.n >= self.least_n.left && right.n >= self.least_n.right;
        let right_value = right.value.filter(|&value| is_enough && value > 0.0)?;
        Some(left.value? / right_value)
    }

    /// How well the curves agree; `None` if no bin has a ratio.
    pub fn agreement(&self) -> Option<Agreement> {
        self.agreement_of(|_| true)
    }

    /// How well the curves agree in the bins of [`Self::focus_m`]; `None` without such bins, or if none has a ratio.
    pub fn agreement_in_focus(&self) -> Option<Agreement> {
        let [from_m, to_m] = self.focus_m?;
        self.agreement_of(|bin| bin.ends_m.is_some_and(|ends_m| ends_m[0] >= from_m && ends_m[1] <= to_m))
    }

    fn agreement_of(&self, takes: impl Fn(&CurveBin) -> bool) -> Option<Agreement> {
        let taken: Vec<usize> = (0..self.bins.len()).filter(|&bin_idx| takes(&self.bins[bin_idx])).collect();
        let mut ratios: Vec<(f64, usize)> =
            taken.iter().filter_map(|&bin_idx| Some((self.ratio(bin_idx)?, bin_idx))).collect();
        // The first of several bins that are equally far off.
        let farther = |a: &&(f64, usize), b: &&(f64, usize)| {
            distance_from_one(a.0).total_cmp(&distance_from_one(b.0)).then(b.1.cmp(&a.1))
        };
        let &(_, worst_bin_idx) = ratios.iter().max_by(farther)?;
        ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some(Agreement {
            n_bins: taken.len(),
            n_compared: ratios.len(),
            n_alike: ratios.iter().filter(|(ratio, _)| is_alike(*ratio)).count(),
            median_ratio: ratios[(ratios.len() - 1) / 2].0,
            worst_bin_idx,
        })
    }
}

/// Whether a ratio is within [`ALIKE_FACTOR`] of 1, either way.
pub fn is_alike(ratio: f64) -> bool {
    (1.0 / ALIKE_FACTOR..=ALIKE_FACTOR).contains(&ratio)
}

/// Distance of a ratio from 1, equal to that of its reciprocal; infinite for 0.
fn distance_from_one(ratio: f64) -> f64 {
    ratio.ln().abs()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A pair of curves over stretches of a metre, each value made of ten points, of which five are needed on the right.
    pub(crate) fn pair(values: &[(f64, f64)]) -> CurvePair {
        let measured = |value| Measured { value: Some(value), n: 10 };
        let bin = |(start, &(left, right)): (u32, &(f64, f64))| CurveBin {
            name: format!("{}-{}", start, start + 1),
            ends_m: Some([f64::from(start), f64::from(start + 1)]),
            measured: Sides { left: measured(left), right: measured(right) },
        };
        CurvePair {
            statistic: "ring_density",
            title: "points per square metre",
            bins_of: Some("range"),
            focus_m: None,
            unit: "points/m²",
            counted: "points",
            least_n: Sides { left: 0, right: 5 },
            bins: (1..).zip(values).map(bin).collect(),
        }
    }

    #[test]
    fn equal_curves_agree_in_every_bin() {
        let agreement = pair(&[(2.0, 2.0), (7.0, 7.0)]).agreement();
        let expected =
            Agreement { n_bins: 2, n_compared: 2, n_alike: 2, median_ratio: 1.0, worst_bin_idx: 0 };
        assert_eq!(agreement, Some(expected));
    }

    #[test]
    fn twice_as_much_is_as_bad_as_half_and_the_first_of_them_is_the_worst() {
        let agreement = pair(&[(1.4, 1.0), (1.0, 2.0), (2.0, 1.0)]).agreement();
        let expected =
            Agreement { n_bins: 3, n_compared: 3, n_alike: 1, median_ratio: 1.4, worst_bin_idx: 1 };
        assert_eq!(agreement, Some(expected));
    }

    #[test]
    fn nothing_where_there_is_something_is_the_worst() {
        let agreement = pair(&[(1.0, 9.0), (0.0, 3.0), (1.0, 1.0)]).agreement().unwrap();
        assert_eq!((agreement.n_compared, agreement.worst_bin_idx), (3, 1));
    }

    #[test]
    fn a_bin_with_nothing_or_too_little_on_the_right_has_no_ratio() {
        let mut curves = pair(&[(1.0, 0.0), (1.0, 1.0), (3.0, 1.0)]);
        curves.bins[1].measured.right.n = 4;
        assert_eq!([0, 1, 2].map(|bin_idx| curves.ratio(bin_idx)), [None, None, Some(3.0)]);
        assert_eq!(curves.agreement().unwrap().n_compared, 1);
        curves.bins[2].measured.left.value = None;
        assert_eq!(curves.agreement(), None);
    }

    #[test]
    fn in_focus_are_the_bins_between_its_ends() {
        let mut curves = pair(&[(9.0, 1.0), (1.0, 1.0), (2.0, 1.0), (9.0, 1.0)]);
        assert_eq!(curves.agreement_in_focus(), None);
        curves.focus_m = Some([2.0, 4.0]);
        let expected =
            Agreement { n_bins: 2, n_compared: 2, n_alike: 1, median_ratio: 1.0, worst_bin_idx: 2 };
        assert_eq!(curves.agreement_in_focus(), Some(expected));
    }

    #[test]
    fn too_little_on_the_left_counts_only_where_that_is_asked_for() {
        let mut curves = pair(&[(1.0, 2.0)]);
        curves.bins[0].measured.left.n = 0;
        assert_eq!(curves.ratio(0), Some(0.5));
        curves.least_n.left = 1;
        assert_eq!(curves.ratio(0), None);
    }

    #[test]
    fn the_factor_itself_is_alike() {
        assert!(is_alike(1.5) && is_alike(1.0 / 1.5));
        assert!(!is_alike(1.501) && !is_alike(0.666));
    }
}
