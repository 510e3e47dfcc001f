//! Slices of the user's own: a region, or bounds.

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::fmt;
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

/// Longest name of a slice of the user, in characters.
const LONGEST_NAME: usize = 40;

/// Name of a slice of the user, without its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OwnSlice(&'static str);

impl OwnSlice {
    /// The slice of this name; `None` if it is no name of a slice.
    pub fn named(name: &str) -> Option<Self> {
        static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
        let is_plain = |it: char| it.is_ascii_lowercase() || it.is_ascii_digit() || it == '-';
        if name.is_empty() || name.len() > LONGEST_NAME || !name.chars().all(is_plain) {
            return None;
        }
        let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = names.get(name) {
            return Some(Self(known));
        }
        let name: &'static str = Box::leak(name.to_owned().into_boxed_str());
        names.insert(name);
        Some(Self(name))
    }

    /// The name.
    pub fn name(self) -> &'static str {
        self.0
    }
}

impl fmt::Display for OwnSlice {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.0)
    }
}

/// Bounds of a slice: the table `[slice.NAME]`. What holds all of them is in the slice. Lower bounds are inclusive, upper ones
/// are not.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SliceBounds {
    /// Corners of a region on the ground plan that holds the centre: x (forward) and y (left) of each, in the sensor frame, in
    /// metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub polygon_m: Option<Vec<[f64; 2]>>,
    /// Distance of the centre from the sensor on the ground plan, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_m: Option<[f64; 2]>,
    /// Height of the centre above the sensor, in metres; below it is negative.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z_m: Option<[f64; 2]>,
    /// Length of the box, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_m: Option<[f64; 2]>,
    /// Width of the box, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width_m: Option<[f64; 2]>,
    /// Height of the box, in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_m: Option<[f64; 2]>,
    /// Number of points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<[f64; 2]>,
}

/// An annotation or a detection, as far as bounds of slices ask.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extents {
    /// Centre in the sensor frame, in metres; `None` if it is nowhere.
    pub center_m: Option<[f32; 3]>,
    /// Length, width and height of its box, in metres; `None` without one.
    pub length_width_height_m: Option<[f32; 3]>,
    /// Number of its points.
    pub n_points: u64,
}

impl SliceBounds {
    /// What is wrong with them; `None` if nothing is.
    pub fn problem(&self) -> Option<String> {
        let bounds = self.bounds();
        let wrong = bounds.iter().find(|(_, [least, end])| least.partial_cmp(end) != Some(Ordering::Less));
        if let Some((name, [least, end])) = wrong {
            return Some(format!("{name} = [{least}, {end}] holds nothing: write the lower bound first"));
        }
        match &self.polygon_m {
            Some(corners) if corners.len() < 3 => {
                Some(format!("polygon_m has {} corners; a region has at least 3", corners.len()))
            }
            Some(corners) if !corners.iter().flatten().all(|it| it.is_finite()) => {
                Some("polygon_m has a corner that is not finite".to_owned())
            }
            None if bounds.is_empty() => Some(
                "bounds nothing: give polygon_m, range_m, z_m, length_m, width_m, height_m or points"
                    .to_owned(),
            ),
            _ => None,
        }
    }

    fn bounds(&self) -> Vec<(&'static str, [f64; 2])> {
        let all = [
            ("range_m", self.range_m),
            ("z_m", self.z_m),
            ("length_m", self.length_m),
            ("width_m", self.width_m),
            ("height_m", self.height_m),
            ("points", self.points),
        ];
        all.into_iter().filter_map(|(name, bounds)| Some((name, bounds?))).collect()
    }

    /// Whether something of this extent is in the slice. What has no box has no size, and is in no slice that asks for one.
    pub fn holds(&self, thing: &Extents) -> bool {
        let center_m = thing.center_m.map(|it| it.map(f64::from));
        let size_m = thing.length_width_height_m.map(|it| it.map(f64::from));
        let is_within = |(name, [least, end]): (&str, [f64; 2])| {
            let value = match name {
                "range_m" => center_m.map(|it| it[0].hypot(it[1])),
                "z_m" => center_m.map(|it| it[2]),
                "length_m" => size_m.map(|it| it[0]),
                "width_m" => size_m.map(|it| it[1]),
                "height_m" => size_m.map(|it| it[2]),
                _ => Some(thing.n_points as f64),
            };
            value.is_some_and(|it| (least..end).contains(&it))
        };
        let is_in_region =
            |corners: &Vec<[f64; 2]>| center_m.is_some_and(|[x, y, _]| is_inside(corners, [x, y]));
        self.polygon_m.as_ref().is_none_or(is_in_region) && self.bounds().into_iter().all(is_within)
    }
}

/// Whether a position is inside the polygon: a ray from it crosses its sides an odd number of times.
fn is_inside(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let crosses = |([from_x, from_y], [to_x, to_y]): &(&[f64; 2], &[f64; 2])| {
        (from_y > &y) != (to_y > &y) && x < from_x + (to_x - from_x) * (y - from_y) / (to_y - from_y)
    };
    sides.filter(crosses).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(text: &str) -> SliceBounds {
        toml::from_str(text).unwrap()
    }

    fn at(x: f32, y: f32) -> Extents {
        Extents { center_m: Some([x, y, -1.0]), length_width_height_m: Some([4.0, 2.0, 1.5]), n_points: 50 }
    }

    #[test]
    fn a_region_holds_what_stands_in_it() {
        // A corridor of eight metres, and a room to its left.
        let corridor =
            bounds("polygon_m = [[0, -4], [60, -4], [60, 4], [20, 4], [20, 10], [10, 10], [10, 4], [0, 4]]");
        assert_eq!(corridor.problem(), None);
        for (x, y, is_inside) in [(5.0, 0.0, true), (15.0, 8.0, true), (25.0, 8.0, false), (-1.0, 0.0, false)]
        {
            assert_eq!(corridor.holds(&at(x, y)), is_inside, "{x}, {y}");
        }
        assert!(!corridor.holds(&Extents { center_m: None, ..at(5.0, 0.0) }));
    }

    #[test]
    fn every_bound_counts_and_begins_with_its_lower_end() {
        for (text, is_held) in [
            ("range_m = [5, 6]", true),
            ("range_m = [4, 5]", false),
            ("z_m = [-2, 0]", true),
            ("length_m = [4, 5]\nwidth_m = [0, 2]", false),
            ("height_m = [1, 2]", true),
            ("points = [50, 100]\nrange_m = [0, 9]", true),
            ("points = [51, 100]", false),
        ] {
            assert_eq!(bounds(text).holds(&at(3.0, 4.0)), is_held, "{text}");
        }
        assert!(!bounds("width_m = [0, 9]").holds(&Extents { length_width_height_m: None, ..at(3.0, 4.0) }));
    }

    #[test]
    fn bounds_that_hold_nothing_are_refused() {
        for (text, problem) in [
            ("", "bounds nothing"),
            ("range_m = [5, 5]", "range_m = [5, 5] holds nothing"),
            ("points = [nan, 5]", "points = [NaN, 5]"),
            ("polygon_m = [[0, 0], [1, 1]]", "2 corners"),
            ("polygon_m = [[0, 0], [1, 1], [0, inf]]", "not finite"),
        ] {
            assert!(bounds(text).problem().unwrap().contains(problem), "{text}");
        }
        assert_eq!(OwnSlice::named("Corridor"), None);
        assert_eq!(OwnSlice::named("corridor").map(OwnSlice::name), Some("corridor"));
    }
}
