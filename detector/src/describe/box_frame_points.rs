//! The points of one object in the frame of its box.

use crate::oriented_box::OrientedBox;
use crate::portable_math::single;
use crate::vector_instructions::{greater, lesser};

/// Columns of coordinates in metres relative to the centre of a box: along its length, across to the left, and up.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BoxFramePoints {
    // Invariant: the three have the same length.
    columns_m: [Vec<f32>; 3],
}

impl BoxFramePoints {
    /// Takes `positions_m` of the sensor frame over into the frame of `bounding_box`.
    #[inline(always)]
    pub fn fill(&mut self, bounding_box: &OrientedBox, positions_m: impl ExactSizeIterator<Item = [f32; 3]>) {
        let (sin, cos) = single::sin_cos(bounding_box.yaw_rad);
        let [center_x, center_y, center_z] = bounding_box.center_m;
        for column_m in &mut self.columns_m {
            column_m.resize(positions_m.len(), 0.0);
        }
        let [along_m, across_m, up_m] = &mut self.columns_m;
        let columns = along_m.iter_mut().zip(across_m).zip(up_m);
        for (((along_m, across_m), up_m), [x, y, z]) in columns.zip(positions_m) {
            let (dx, dy) = (x - center_x, y - center_y);
            *along_m = cos * dx + sin * dy;
            *across_m = cos * dy - sin * dx;
            *up_m = z - center_z;
        }
    }

    /// Coordinates along the length.
    pub fn along_m(&self) -> &[f32] {
        &self.columns_m[0]
    }

    /// Coordinates across, to the left.
    pub fn across_m(&self) -> &[f32] {
        &self.columns_m[1]
    }

    /// Coordinates upward.
    pub fn up_m(&self) -> &[f32] {
        &self.columns_m[2]
    }
}

/// Points that are processed side by side.
pub(super) const LANES: usize = 8;

/// Sum of `value` over a column, in the same order on every machine.
#[inline(always)]
pub(super) fn sum(column: &[f32], value: impl Fn(f32) -> f32) -> f32 {
    let (chunks, rest) = column.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for chunk in chunks {
        for lane in 0..LANES {
            sums[lane] += value(chunk[lane]);
        }
    }
    sums.iter().sum::<f32>() + rest.iter().map(|&it| value(it)).sum::<f32>()
}

/// Least and greatest of a column. `None` without points.
#[inline(always)]
pub(crate) fn extent_m(column: &[f32]) -> Option<[f32; 2]> {
    let mut low = [*column.first()?; LANES];
    let mut high = low;
    let (chunks, rest) = column.as_chunks::<LANES>();
    for chunk in chunks {
        low = std::array::from_fn(|lane| lesser(chunk[lane], low[lane]));
        high = std::array::from_fn(|lane| greater(chunk[lane], high[lane]));
    }
    let low = rest.iter().copied().fold(reduced(low, lesser), lesser);
    let high = rest.iter().copied().fold(reduced(high, greater), greater);
    Some([low, high])
}

/// Reduces several numbers to one, by halves.
#[inline(always)]
pub(super) fn reduced(mut lanes: [f32; LANES], of_two: impl Fn(f32, f32) -> f32) -> f32 {
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] = of_two(lanes[lane], lanes[lane + half]);
        }
        half /= 2;
    }
    lanes[0]
}
