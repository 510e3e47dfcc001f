//! Errors of fitted boxes against annotated boxes, by slice of the matched vehicles.

use crate::numbers::blocks::Interval;
use crate::vocabulary::named::named;

/// A number with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NumberWithin {
    /// The number.
    pub value: f64,
    /// The interval; `None` for a single drive or object.
    pub within: Option<Interval>,
}

/// One error over one slice of the pairs, for each way to fit a box to the same points.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxErrorLine {
    /// Name of the data.
    pub data: String,
    /// Whether the data are simulated.
    pub is_simulated: bool,
    /// Property that the pairs are sliced by: `all`, `class`, `occlusion`, `range` or `points`.
    pub by: String,
    /// The slice.
    pub slice: String,
    /// The error.
    pub error: BoxError,
    /// Matched vehicles.
    pub n_pairs: u64,
    /// Tracks that these belong to.
    pub n_tracks: u64,
    /// Names of the fits with the median of the absolute error, or with the share; `None` without pairs, and for boxes
    /// without this error.
    pub fits: Vec<(&'static str, Option<NumberWithin>)>,
}

named! {
    /// What is measured of boxes.
    pub enum BoxError {
        /// Distance of the centres on the ground plan.
        Centre = "centre",
        /// Difference of the lengths.
        Length = "length",
        /// Difference of the widths.
        Width = "width",
        /// Angle between the long sides, at most a right one.
        Yaw = "yaw",
        /// The share that is turned by at most 5 degrees.
        Yaw5 = "yaw within 5 deg",
        /// The share that is turned by at most 10 degrees.
        Yaw10 = "yaw within 10 deg",
        /// The share with an intersection over union of at least 0.5, seen from above.
        Bev50 = "BEV IoU >= 0.5",
        /// The same of 0.7.
        Bev70 = "BEV IoU >= 0.7",
        /// The share with an intersection over union of at least 0.5 in space.
        Space50 = "3D IoU >= 0.5",
        /// The same of 0.7.
        Space70 = "3D IoU >= 0.7",
        /// The share with the front on the right side.
        Front = "front right",
        /// The share of which it is sure which end is the front.
        FrontSure = "front sure",
        /// Of these the share with the front on the right side.
        SureFront = "front right if sure",
    }
}

impl BoxError {
    /// Errors that are reported for every slice; for all vehicles together all errors are.
    pub const OF_SLICES: [Self; 4] = [Self::Centre, Self::Yaw, Self::Yaw10, Self::Bev70];

    /// Whether it is a share, reported as a mean in %; otherwise it is an error, reported as a median.
    pub fn is_share(self) -> bool {
        !matches!(self, Self::Centre | Self::Length | Self::Width | Self::Yaw)
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Centre | Self::Length | Self::Width => "m",
            Self::Yaw => "deg",
            _ => "%",
        }
    }

    /// Number of decimals that are worth showing.
    pub(crate) fn decimals(self) -> usize {
        if self.unit() == "m" { 2 } else { 1 }
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

    /// Lines of the errors of a slice; those of the second fit are twice those of the first.
    pub(crate) fn lines(data: &str, by: &str, slice: &str, n_pairs: u64) -> Vec<BoxErrorLine> {
        let fit = |name: &'static str, value: f64| {
            let blocks = BlockCount::of_dataset(n_pairs / 4, BlockKind::Tracks);
            let within = Some(Interval { ends: [0.9 * value, 1.2 * value], blocks });
            (name, (n_pairs > 0).then_some(NumberWithin { value, within }))
        };
        let shown = if by == "all" { &BoxError::ALL[..] } else { &BoxError::OF_SLICES };
        shown
            .iter()
            .map(|&error| BoxErrorLine {
                data: data.to_owned(),
                is_simulated: data == "street",
                by: by.to_owned(),
                slice: slice.to_owned(),
                error,
                n_pairs,
                n_tracks: n_pairs / 4,
                fits: vec![fit("hull box", 0.5), fit("PCA box", 1.0)],
            })
            .collect()
    }
}
