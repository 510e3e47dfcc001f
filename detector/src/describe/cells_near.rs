//! The cells of a plan near a box.

use crate::oriented_box::OrientedBox;
use crate::portable_math::single;
use crate::vector_instructions::HotLoop;

/// Columns are rounded up to a multiple of this where there are as many, so that a vectorised loop leaves none over. Cells out
/// of reach do not count.
pub(super) const N_ABREAST: usize = 16;

/// A box from above.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoxPlan {
    /// Its centre, in metres.
    pub(super) center_m: [f32; 2],
    half_m: [f32; 2],
    sin: f32,
    cos: f32,
}

impl BoxPlan {
    pub(super) fn of(bounding_box: &OrientedBox) -> Self {
        let [center_x_m, center_y_m, _] = bounding_box.center_m;
        let [half_length_m, half_width_m, _] = bounding_box.length_width_height_m.map(|it| 0.5 * it);
        let (sin, cos) = single::sin_cos(bounding_box.yaw_rad);
        Self { center_m: [center_x_m, center_y_m], half_m: [half_length_m, half_width_m], sin, cos }
    }

    /// How far the box reaches from its centre along x and y if its sides move outwards by `outside_m`, in metres.
    pub(super) fn reach_m(&self, outside_m: f32) -> [f32; 2] {
        let Self { half_m: [half_length_m, half_width_m], sin, cos, .. } = *self;
        let [long_m, wide_m] = [half_length_m + outside_m, half_width_m + outside_m];
        [cos.abs() * long_m + sin.abs() * wide_m, sin.abs() * long_m + cos.abs() * wide_m]
    }

    /// How far a position lies beyond the ends of the box, and beside its sides, in metres; `dx` and `dy` lead there from its
    /// centre.
    #[inline(always)]
    fn outside_m(&self, [dx, dy]: [f32; 2]) -> [f32; 2] {
        let Self { half_m, sin, cos, .. } = *self;
        [(cos * dx + sin * dy).abs() - half_m[0], (cos * dy - sin * dx).abs() - half_m[1]]
    }
}

/// Counts cells around a box.
pub(super) trait CellCount<T> {
    /// Takes a cell into account whose centre lies beyond the ends of the box and beside its sides by `outside_m`, and `from_m`
    /// its centre, in metres. Which cells are near cannot be foreseen: without branches it is vectorised.
    fn add(&mut self, cell: T, outside_m: [f32; 2], from_m: [f32; 2]);
}

/// The cells of some rows and columns of a plan.
pub(super) struct CellsNear<Rows, Dx, C> {
    pub(super) plan: BoxPlan,
    /// Along y from the centre of the box to that of a row, in metres, and the cells of the row.
    pub(super) rows: Rows,
    /// The same along x for a column, counted from the first.
    pub(super) dx: Dx,
    /// Counts them.
    pub(super) count: C,
}

impl<'a, T, Rows, Dx, C> HotLoop for CellsNear<Rows, Dx, C>
where
    T: Copy + 'a,
    Rows: Iterator<Item = (f32, &'a [T])>,
    Dx: Fn(i32) -> f32,
    C: CellCount<T>,
{
    type Output = C;

    #[inline(always)]
    fn run(self) -> C {
        let Self { plan, rows, dx, mut count } = self;
        for (dy, cells) in rows {
            for (&cell, column) in cells.iter().zip(0_i32..) {
                let from_m = [dx(column), dy];
                count.add(cell, plan.outside_m(from_m), from_m);
            }
        }
        count
    }
}
