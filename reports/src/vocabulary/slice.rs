//! Parts of the objects that are looked at alone: by class, range, number of points, occlusion, and what a limit cuts.

use crate::vocabulary::metric::Metric;

/// The name of the slice of everything.
pub const SLICE_ALL: &str = "all";

/// A part of the objects.
///
/// The order is that in which a report lists them.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Slice {
    /// Everything.
    All,
    /// Annotations of this class. Detections have no class of the kind, so that false ones belong to none.
    Class(String),
    /// What is this far from the sensor on the ground plan; place among the bins of range.
    Range(usize),
    /// What has this many points; place among the bins of the number of points.
    Points(usize),
    /// Annotations of which other things hide this much. False detections belong to none.
    Occlusion(String),
    /// Annotations at least half of whose points lie outside the labelled region, such as what the border of a camera image
    /// cuts. Counted by points, not by what labels say of their image. False detections belong to none.
    Truncated,
    /// Annotations that are too tall for the task and so count nowhere else, with those of them that were found all the same.
    Tall,
}

/// Names and upper ends, exclusive, of the bins of range.
const RANGES_M: [(&str, f64); 5] =
    [("0-15", 15.0), ("15-30", 30.0), ("30-50", 50.0), ("50-80", 80.0), ("80+", f64::INFINITY)];

/// Names and upper ends, exclusive, of the bins of the number of points.
const POINTS: [(&str, u64); 4] = [("0-49", 50), ("50-199", 200), ("200-999", 1000), ("1000+", u64::MAX)];

impl Slice {
    /// The name used in files, such as `range/15-30`.
    pub fn name(&self) -> String {
        match self {
            Self::All => SLICE_ALL.to_owned(),
            Self::Class(class) => format!("class/{class}"),
            Self::Range(bin) => format!("range/{}", RANGES_M[*bin].0),
            Self::Points(bin) => format!("points/{}", POINTS[*bin].0),
            Self::Occlusion(occlusion) => format!("occlusion/{occlusion}"),
            Self::Truncated => "truncated".to_owned(),
            Self::Tall => "tall".to_owned(),
        }
    }

    /// The slice of what is `range_m` away; `None` if that is not a number.
    pub fn of_range(range_m: f64) -> Option<Self> {
        RANGES_M.iter().position(|&(_, end_m)| range_m < end_m).map(Self::Range)
    }

    /// The slice of what has `n_points` points.
    pub fn of_points(n_points: u64) -> Self {
        let bin = POINTS.iter().position(|&(_, end)| n_points < end);
        Self::Points(bin.unwrap_or(POINTS.len() - 1))
    }

    /// Whether `metric` is measured of it. What is torn apart or run together, and boxes, are of everything alone.
    pub fn measures(&self, metric: &Metric) -> bool {
        match metric {
            _ if *self == Self::All => true,
            Metric::No | Metric::Tp | Metric::Mo | Metric::Recall => true,
            Metric::Fo | Metric::Precision | Metric::FRate => self.has_false_detections(),
            _ => false,
        }
    }

    /// Whether it can be told of a false detection if it belongs here, so that precision and F-rate mean something.
    pub fn has_false_detections(&self) -> bool {
        matches!(self, Self::All | Self::Range(_) | Self::Points(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_begin_where_the_one_before_ends() {
        let range = |range_m: f64| Slice::of_range(range_m).unwrap().name();
        assert_eq!(
            [0.0, 14.9, 15.0, 79.9, 80.0].map(range).as_slice(),
            ["range/0-15", "range/0-15", "range/15-30", "range/50-80", "range/80+"]
        );
        assert_eq!(Slice::of_range(f64::NAN), None);
        let points = |n_points: u64| Slice::of_points(n_points).name();
        assert_eq!(
            [49, 50, 999, 1000, u64::MAX].map(points).as_slice(),
            ["points/0-49", "points/50-199", "points/200-999", "points/1000+", "points/1000+"]
        );
    }
}
