//! Number of pairs of objects that are separated, by the gap between the two.

use std::ops::AddAssign;

/// Pairs of one kind at one gap, as one detector saw them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PairCounts {
    /// Pairs that were put up.
    pub n_pairs: u64,
    /// Pairs whose objects both have enough points to be judged.
    pub n_seen: u64,
    /// Seen pairs that were separated.
    pub n_separated: u64,
    /// Seen pairs that one detection joins.
    pub n_joined: u64,
}

/// The pairs of one bin.
#[derive(Debug, Clone, PartialEq)]
pub struct GapBin {
    /// The detector.
    pub detector: String,
    /// Kind of the pairs.
    pub pair: String,
    /// Layout of the pairs as the sensor sees them.
    pub layout: String,
    /// Ends of the range of the nearer object, in metres from the sensor.
    pub range_m: [f64; 2],
    /// The gap in metres.
    pub gap_m: f64,
    /// Counts of the pairs.
    pub counts: PairCounts,
}

/// Counts of one detector over growing gaps at one range.
#[derive(Debug, Clone, PartialEq)]
pub struct GapCurve {
    /// The detector.
    pub detector: String,
    /// Ends of the range, in metres from the sensor.
    pub range_m: [f64; 2],
    /// Gaps in metres, ascending, with the counts of their pairs.
    pub points: Vec<(f64, PairCounts)>,
}

impl PairCounts {
    /// Share of the seen pairs that were separated; `None` if none was seen.
    pub fn separated(&self) -> Option<f64> {
        (self.n_seen > 0).then(|| self.n_separated as f64 / self.n_seen as f64)
    }
}

impl AddAssign for PairCounts {
    fn add_assign(&mut self, other: Self) {
        self.n_pairs += other.n_pairs;
        self.n_seen += other.n_seen;
        self.n_separated += other.n_separated;
        self.n_joined += other.n_joined;
    }
}

/// The curves of `bins`: one for each detector and range, detectors in the order of their first bin, all kinds of pairs
/// and layouts added up.
pub fn gap_curves<'a>(bins: impl IntoIterator<Item = &'a GapBin>) -> Vec<GapCurve> {
    let mut curves: Vec<GapCurve> = Vec::new();
    for bin in bins {
        let is_of = |it: &GapCurve| it.detector == bin.detector && it.range_m == bin.range_m;
        let curve_idx = curves.iter().position(is_of).unwrap_or_else(|| {
            let (detector, range_m) = (bin.detector.clone(), bin.range_m);
            curves.push(GapCurve { detector, range_m, points: Vec::new() });
            curves.len() - 1
        });
        let points = &mut curves[curve_idx].points;
        match points.iter_mut().find(|(gap_m, _)| *gap_m == bin.gap_m) {
            Some((_, counts)) => *counts += bin.counts,
            None => points.push((bin.gap_m, bin.counts)),
        }
    }
    for curve in &mut curves {
        curve.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    curves
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn bin(detector: &str, pair: &str, far: bool, gap_m: f64, n_separated: u64) -> GapBin {
        GapBin {
            detector: detector.to_owned(),
            pair: pair.to_owned(),
            layout: "beside".to_owned(),
            range_m: if far { [10.0, 20.0] } else { [5.0, 10.0] },
            gap_m,
            counts: PairCounts { n_pairs: 12, n_seen: 10, n_separated, n_joined: 10 - n_separated },
        }
    }

    #[test]
    fn kinds_are_added_up_and_gaps_ascend() {
        let bins = [
            bin("grid", "cars", false, 0.4, 3),
            bin("grid", "cars", false, 0.2, 1),
            bin("grid", "people", false, 0.4, 5),
            bin("tree", "cars", false, 0.4, 9),
        ];
        let curves = gap_curves(&bins);
        assert_eq!(curves.len(), 2);
        let shares: Vec<_> =
            curves[0].points.iter().map(|(gap_m, it)| (*gap_m, it.separated(), it.n_seen)).collect();
        assert_eq!(shares, [(0.2, Some(0.1), 10), (0.4, Some(0.4), 20)]);
        assert_eq!(PairCounts::default().separated(), None);
    }
}
