//! How many points to expect (HG section 4).

use detector::params::front_end::FrontEndParams;

use super::cells::{Cell, center_m};

/// What all points together put into a cell of `size_m` at the range of a coarse cell.
pub fn points_per_cell(coarse: Cell, size_m: f32, params: &FrontEndParams) -> f32 {
    let [x_m, y_m] = center_m(coarse, &params.grid);
    let metre = (x_m * x_m + y_m * y_m).sqrt().trunc().min(79.0);
    let weighting = &params.density_weighting;
    let weight = if weighting.enabled { weighting.curve.weight(f64::from(metre) + 0.5) as f32 } else { 1.0 };
    weighting.curve.peak_points_per_m2 as f32 * size_m * size_m * weight
}
