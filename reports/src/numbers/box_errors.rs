//! How far fitted boxes are from annotated ones, by slice of the matched vehicles.

use crate::numbers::blocks::Interval;

/// A median with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MedianWithin {
    /// The median.
    pub median: f64,
    /// The interval; `None` of a single drive or object.
    pub within: Option<Interval>,
}

/// One error over one slice of the pairs, for each way to fit a box to the same points.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxErrorLine {
    /// The data that were looked at.
    pub data: String,
    /// Whether they are simulated.
    pub is_simulated: bool,
    /// What the pairs are sliced by: `all`, `occlusion` or `range`.
    pub by: String,
    /// The slice.
    pub slice: String,
    /// The error.
    pub error: BoxError,
    /// Matched vehicles.
    pub n_pairs: u64,
    /// Tracks that these belong to.
    pub n_tracks: u64,
    /// Names of the fits with the median of the absolute error; `None` without pairs.
    pub fits: Vec<(String, Option<MedianWithin>)>,
}

/// What is wrong with a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoxError {
    /// Distance of the centres on the ground plan.
    Centre,
    /// Difference of the lengths.
    Length,
    /// Difference of the widths.
    Width,
    /// Angle between the long sides, at most a right one.
    Yaw,
}

impl BoxError {
    /// All, in the order of tables.
    pub const ALL: [Self; 4] = [Self::Centre, Self::Length, Self::Width, Self::Yaw];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Centre => "centre",
            Self::Length => "length",
            Self::Width => "width",
            Self::Yaw => "yaw",
        }
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        if self == Self::Yaw { "deg" } else { "m" }
    }

    /// Decimals that say something.
    pub(crate) fn decimals(self) -> usize {
        if self == Self::Yaw { 1 } else { 2 }
    }
}

/// Lines of the same data, one after the other.
pub(crate) fn by_data(lines: &[BoxErrorLine]) -> impl Iterator<Item = &[BoxErrorLine]> {
    lines.chunk_by(|a, b| a.data == b.data)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::numbers::blocks::{BlockCount, BlockKind};

    /// All four errors of a slice, the second fit twice as far off.
    pub(crate) fn lines(data: &str, by: &str, slice: &str, n_pairs: u64) -> Vec<BoxErrorLine> {
        let fit = |name: &str, median: f64| {
            let blocks = BlockCount::of_dataset(n_pairs / 4, BlockKind::Tracks);
            let within = Some(Interval { ends: [0.9 * median, 1.2 * median], blocks });
            (name.to_owned(), (n_pairs > 0).then_some(MedianWithin { median, within }))
        };
        BoxError::ALL
            .map(|error| BoxErrorLine {
                data: data.to_owned(),
                is_simulated: data == "street",
                by: by.to_owned(),
                slice: slice.to_owned(),
                error,
                n_pairs,
                n_tracks: n_pairs / 4,
                fits: vec![fit("hull box", 0.5), fit("PCA box", 1.0)],
            })
            .to_vec()
    }
}
