//! `realism.csv`: one row for every bin of every statistic of two collections of scans.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::numbers::curve_pair::{CurvePair, Sides};

row! {
    /// One bin of one statistic, with both values.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct CurveRow {
        statistic: String,
        bin: String,
        bin_from_m: Option<Fixed<3>>,
        bin_to_m: Option<Fixed<3>>,
        unit: String,
        left: String,
        left_value: Option<Fixed<6>>,
        right: String,
        right_value: Option<Fixed<6>>,
        ratio: Option<Fixed<4>>,
        counted: String,
        n_left: u64,
        n_right: u64,
    }
}

impl CurveRow {
    /// The rows of `curves`, one a bin; `names` are the scans of each side, and whether they are simulated.
    pub fn of_curves(curves: &CurvePair, names: Sides<&str>) -> Vec<Self> {
        let row = |bin_idx: usize| {
            let bin = &curves.bins[bin_idx];
            Self {
                statistic: curves.statistic.to_owned(),
                bin: bin.name.clone(),
                bin_from_m: bin.ends_m.map(|[from_m, _]| Fixed(from_m)),
                bin_to_m: bin.ends_m.map(|[_, to_m]| Fixed(to_m)),
                unit: curves.unit.to_owned(),
                left: names.left.to_owned(),
                left_value: bin.measured.left.value.map(Fixed),
                right: names.right.to_owned(),
                right_value: bin.measured.right.value.map(Fixed),
                ratio: curves.ratio(bin_idx).map(Fixed),
                counted: curves.counted.to_owned(),
                n_left: bin.measured.left.n,
                n_right: bin.measured.right.n,
            }
        };
        (0..curves.bins.len()).map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::{csv_text, rows_of};
    use crate::numbers::curve_pair::tests::pair;

    #[test]
    fn rows_name_both_sides_and_leave_undefined_ratios_empty() {
        let mut curves = pair(&[(1.0, 2.0), (0.5, 0.0)]);
        curves.bins[1].name = "kind".to_owned();
        curves.bins[1].ends_m = None;
        let rows = CurveRow::of_curves(&curves, Sides { left: "street (simulated)", right: "kitti" });
        let text = csv_text(&rows);
        insta::assert_snapshot!(text, @r"
        statistic,bin,bin_from_m,bin_to_m,unit,left,left_value,right,right_value,ratio,counted,n_left,n_right
        ring_density,1-2,1.000,2.000,points/m²,street (simulated),1.000000,kitti,2.000000,0.5000,points,10,10
        ring_density,kind,,,points/m²,street (simulated),0.500000,kitti,0.000000,,points,10,10
        ");
        assert_eq!(rows_of::<CurveRow>(&text).unwrap(), rows);
    }
}
