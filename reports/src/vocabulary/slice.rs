//! Parts of the objects that are looked at alone: by class, range, number of points, occlusion, and what a limit cuts.

use std::cmp::Ordering;
use std::fmt::{Display, Formatter};

use serde::{Deserialize, Serialize};

use crate::vocabulary::class::{AnnotationClass, Occlusion};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::own_slice::OwnSlice;

/// A part of the objects.
///
/// The order is that in which a report lists them: classes, and what is hidden, by their names.
///
/// ```
/// use reports::vocabulary::slice::Slice;
///
/// let near = Slice::of_range(12.0).expect("12 m is a number");
/// assert_eq!(near.name(), "range/0-15");
/// assert_eq!(Slice::from_name("range/0-15"), Some(near));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(into = "String", try_from = "String")]
pub enum Slice {
    /// Everything.
    All,
    /// Annotations of this class. Detections have no class of the kind, so that false ones belong to none.
    Class(AnnotationClass),
    /// What is this far from the sensor on the ground plan; index among the bins of range.
    Range(usize),
    /// What has this many points; index among the bins of the number of points.
    Points(usize),
    /// Annotations of which other things hide this much. False detections belong to none.
    Occlusion(Occlusion),
    /// Annotations that move at this speed over ground; index among the bins of speed. False detections belong to none, and
    /// only [streaming](crate::streaming) knows speeds.
    Speed(usize),
    /// Annotations at least half of whose points lie outside the labelled region, such as what the border of a camera image
    /// cuts. Counted by points, not by what labels say of their image. False detections belong to none.
    Truncated,
    /// Annotations that are too tall for the task and so count nowhere else, with those of them that were found all the
    /// same.
    Tall,
    /// What is within the bounds that the user gives a name.
    Own(OwnSlice),
}

/// There is no slice of this name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown slice {0:?}")]
pub struct UnknownSlice(String);

/// Names and upper ends, exclusive, of the bins of range.
const RANGES_M: [(&str, f64); 5] =
    [("0-15", 15.0), ("15-30", 30.0), ("30-50", 50.0), ("50-80", 80.0), ("80+", f64::INFINITY)];

/// Names and upper ends, exclusive, of the bins of the number of points.
const POINTS: [(&str, u64); 4] = [("0-49", 50), ("50-199", 200), ("200-999", 1000), ("1000+", u64::MAX)];

/// Names and upper ends, exclusive, of the bins of speed over ground. What stands still is labelled with a jitter.
const SPEEDS_M_PER_S: [(&str, f64); 4] =
    [("0-0.5", 0.5), ("0.5-3", 3.0), ("3-10", 10.0), ("10+", f64::INFINITY)];

impl Slice {
    /// The name used in files, such as `range/15-30`.
    pub fn name(&self) -> String {
        match self {
            Self::All => "all".to_owned(),
            Self::Class(class) => format!("class/{}", class.name()),
            Self::Range(bin) => format!("range/{}", RANGES_M[*bin].0),
            Self::Points(bin) => format!("points/{}", POINTS[*bin].0),
            Self::Occlusion(occlusion) => format!("occlusion/{}", occlusion.name()),
            Self::Speed(bin) => format!("speed/{}", SPEEDS_M_PER_S[*bin].0),
            Self::Truncated => "truncated".to_owned(),
            Self::Tall => "tall".to_owned(),
            Self::Own(own) => format!("own/{own}"),
        }
    }

    /// The slice of this name; `None` if there is none. A class or a slice that is unknown may be one of a user.
    pub fn from_name(name: &str) -> Option<Self> {
        if let Some(class) = name.strip_prefix("class/") {
            return AnnotationClass::written(class).ok().map(Self::Class);
        }
        if let Some(own) = name.strip_prefix("own/") {
            return OwnSlice::named(own).map(Self::Own);
        }
        let ranges = (0..RANGES_M.len()).map(Self::Range);
        let points = (0..POINTS.len()).map(Self::Points);
        let occlusions = Occlusion::ALL.into_iter().map(Self::Occlusion);
        let speeds = (0..SPEEDS_M_PER_S.len()).map(Self::Speed);
        let others = [Self::All, Self::Truncated, Self::Tall];
        others
            .into_iter()
            .chain(ranges)
            .chain(points)
            .chain(speeds)
            .chain(occlusions)
            .find(|it| it.name() == name)
    }

    /// The slice of objects that are `range_m` away; `None` if that is not a number.
    pub fn of_range(range_m: f64) -> Option<Self> {
        RANGES_M.iter().position(|&(_, end_m)| range_m < end_m).map(Self::Range)
    }

    /// The slice of objects that move at this speed over ground; `None` if that is not a number.
    pub fn of_speed(speed_m_per_s: f64) -> Option<Self> {
        SPEEDS_M_PER_S.iter().position(|&(_, end)| speed_m_per_s < end).map(Self::Speed)
    }

    /// The slice of objects with `n_points` points.
    pub fn of_points(n_points: u64) -> Self {
        let bin = POINTS.iter().position(|&(_, end)| n_points < end);
        Self::Points(bin.unwrap_or(POINTS.len() - 1))
    }

    /// Whether `metric` is measured of it.
    pub fn measures(&self, metric: &Metric) -> bool {
        let formula = metric.formula();
        let is_of_slice = || self.has_false_detections() || !formula.needs_false_detections();
        *self == Self::All || formula.is_of_slices() && is_of_slice()
    }

    /// Whether average precision is computed of it.
    pub fn ranks_detections(&self) -> bool {
        matches!(self, Self::All | Self::Range(_) | Self::Own(_))
    }

    /// Whether it is known which false detections belong here, so that precision and F-rate mean something.
    pub fn has_false_detections(&self) -> bool {
        matches!(self, Self::All | Self::Range(_) | Self::Points(_) | Self::Own(_))
    }
}

impl Ord for Slice {
    fn cmp(&self, other: &Self) -> Ordering {
        // Index of the kind, index of the bin, name.
        let key = |it: &Self| match *it {
            Self::All => (0, 0, ""),
            Self::Class(class) => (1, 0, class.name()),
            Self::Range(bin) => (2, bin, ""),
            Self::Points(bin) => (3, bin, ""),
            Self::Occlusion(occlusion) => (4, 0, occlusion.name()),
            Self::Speed(bin) => (5, bin, ""),
            Self::Truncated => (6, 0, ""),
            Self::Tall => (7, 0, ""),
            Self::Own(own) => (8, 0, own.name()),
        };
        key(self).cmp(&key(other))
    }
}

impl PartialOrd for Slice {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Display for Slice {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(&self.name())
    }
}

impl From<Slice> for String {
    fn from(slice: Slice) -> Self {
        slice.name()
    }
}

impl TryFrom<String> for Slice {
    type Error = UnknownSlice;

    fn try_from(name: String) -> Result<Self, UnknownSlice> {
        Self::from_name(&name).ok_or(UnknownSlice(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_are_read_by_the_names_they_are_written_with() {
        for name in [
            "all",
            "class/parked-cycle",
            "range/80+",
            "points/1000+",
            "speed/0.5-3",
            "occlusion/partly",
            "tall",
            "own/corridor",
        ] {
            let slice: Slice = serde_json::from_str(&format!("{name:?}")).unwrap();
            assert_eq!(serde_json::to_string(&slice).unwrap(), format!("{name:?}"));
        }
        let unknown = serde_json::from_str::<Slice>("\"range/0-20\"").unwrap_err();
        assert_eq!(unknown.to_string(), "unknown slice \"range/0-20\"");
    }

    #[test]
    fn slices_of_a_kind_are_listed_by_bin_or_by_name() {
        let mut slices = [
            "tall",
            "occlusion/none",
            "occlusion/largely",
            "range/15-30",
            "range/0-15",
            "class/van",
            "class/bus",
            "all",
        ]
        .map(|it| Slice::from_name(it).unwrap());
        slices.sort();
        let names = slices.map(|it| it.name());
        assert_eq!(
            names.join(" "),
            "all class/bus class/van range/0-15 range/15-30 occlusion/largely occlusion/none tall"
        );
    }

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
