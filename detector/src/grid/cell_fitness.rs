//! How well a cell size suits a scan, judged without knowing what stands in it.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::grid::hierarchical_grid::{CoarseCell, HierarchicalGrid};
use crate::portable_math::ln;

/// A cell with more points than this is dense.
///
/// Paper: HG section 4, t(min).
pub const DENSE_ABOVE: u32 = 20;

/// Numbers that the readings of the fitness of a cell size are computed from. The cells are those of the smallest rectangle
/// of cells that holds all points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellTally {
    /// Side of a cell in metres.
    pub cell_size_m: f32,
    /// Points in cells.
    pub n_points: u64,
    /// d: cells with more than [`DENSE_ABOVE`] points.
    pub n_dense: u64,
    /// s: other cells with points.
    pub n_sparse: u64,
    /// e: cells without points.
    pub n_empty: u64,
    /// Cells whose points reach over more than the height of ground.
    pub n_standing: u64,
    /// Over dense standing cells the sum of n (8 − n), where n of the eight neighbours are standing.
    pub n_parting_pairs: u64,
    /// Sum of the squares of the numbers of points.
    pub n_squares: u64,
    /// Sum of ln Γ(n + ½) − ln Γ(½) over the numbers n of points of all cells.
    pub ln_gamma_sum: f64,
}

/// A way to read the fitness of a cell size; the fittest cell size is the one with the greatest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FitnessReading {
    /// d / ((d + s) − e), to the letter of HG section 4, which says that it lies in 0 to 1. It has a pole where as many
    /// cells are empty as are not, and lies outside of 0 to 1 where more are.
    Printed,
    /// d / (d + s): of the cells with points, the share that is dense.
    DenseShare,
    /// The share of the standing cells that is dense, each weighted by n (8 − n) / 16, where n of its eight neighbours are
    /// standing: 1 where half of them are; 0 where all are, and objects have merged, or where none is, and objects have
    /// fallen apart into single cells.
    PartedShare,
    /// Logarithm of the posterior probability of the cell size, per point, for a density that is constant within cells,
    /// with Jeffreys' prior for the shares of the cells and a flat one for their number.
    ///
    /// K. H. Knuth, Optimal Data-Based Binning for Histograms, arXiv:physics/0605197, 2006; here in two dimensions.
    Knuth,
    /// The integrated squared error of the histogram as density, by leaving one point out, without the term that is the
    /// same for all histograms, and negative so that the greatest is best; in points per point and m².
    ///
    /// M. Rudemo, Empirical choice of histograms and kernel density estimators, Scandinavian Journal of Statistics 9, 1982.
    CrossValidation,
}

impl CellTally {
    /// Counts the cells of `grid`; those whose points reach over more than `ground_extent_m` stand.
    pub fn of(grid: &HierarchicalGrid, ground_extent_m: f32) -> Self {
        let mut tally = Self {
            cell_size_m: grid.params().cell_size_m,
            n_points: 0,
            n_dense: 0,
            n_sparse: 0,
            n_empty: n_cells_of_rectangle(grid) - grid.occupied().len() as u64,
            n_standing: 0,
            n_parting_pairs: 0,
            n_squares: 0,
            ln_gamma_sum: 0.0,
        };
        let stands = |cell: &CoarseCell| cell.z_extent_m() > ground_extent_m;
        for &cell_idx in grid.occupied() {
            let cell = &grid.cells()[cell_idx as usize];
            let n_points = u64::from(cell.n_points);
            tally.n_points += n_points;
            tally.n_squares += n_points * n_points;
            tally.ln_gamma_sum += ln_gamma(n_points as f64 + 0.5) - 0.5 * ln(PI);
            let is_dense = cell.n_points > DENSE_ABOVE;
            if is_dense {
                tally.n_dense += 1;
            } else {
                tally.n_sparse += 1;
            }
            if stands(cell) {
                tally.n_standing += 1;
                let around = grid.neighborhood(cell_idx);
                let n_standing =
                    around.iter().filter(|&&it| stands(&grid.cells()[it as usize])).count() as u64;
                // The cell itself is among the nine.
                let n_neighbors = n_standing - 1;
                tally.n_parting_pairs += if is_dense { n_neighbors * (8 - n_neighbors) } else { 0 };
            }
        }
        tally
    }

    /// d + s + e.
    fn n_cells(&self) -> f64 {
        (self.n_dense + self.n_sparse + self.n_empty) as f64
    }
}

/// Cells of the smallest rectangle around the occupied ones.
fn n_cells_of_rectangle(grid: &HierarchicalGrid) -> u64 {
    let positions = grid.occupied().iter().map(|&cell_idx| grid.column_and_row(cell_idx));
    let ends = positions.fold([[u32::MAX, 0]; 2], |ends, position| {
        [0, 1].map(|axis| [ends[axis][0].min(position[axis]), ends[axis][1].max(position[axis])])
    });
    if grid.occupied().is_empty() {
        return 0;
    }
    ends.iter().map(|[first, last]| u64::from(last - first + 1)).product()
}

impl FitnessReading {
    /// All readings, in the order in which tables list them.
    pub const ALL: [Self; 5] =
        [Self::Printed, Self::DenseShare, Self::PartedShare, Self::Knuth, Self::CrossValidation];

    /// The name used in files and on screens.
    pub fn name(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::DenseShare => "dense-share",
            Self::PartedShare => "parted-share",
            Self::Knuth => "knuth",
            Self::CrossValidation => "cross-validation",
        }
    }

    /// Numerator and denominator of the reading of one scan. Of several scans, the reading is the sum of the numerators
    /// over that of the denominators; where that is 0, there is none.
    pub fn ratio(self, tally: &CellTally) -> [f64; 2] {
        let (n_dense, n_occupied) = (tally.n_dense as f64, (tally.n_dense + tally.n_sparse) as f64);
        match self {
            Self::Printed => [n_dense, n_occupied - tally.n_empty as f64],
            Self::DenseShare => [n_dense, n_occupied],
            Self::PartedShare => [tally.n_parting_pairs as f64 / 16.0, tally.n_standing as f64],
            Self::Knuth => [knuth(tally), tally.n_points as f64],
            Self::CrossValidation => match rudemo(tally) {
                Some(risk) => [-risk, 1.0],
                None => [0.0, 0.0],
            },
        }
    }

    /// The range that the reading is said, or defined, to lie within; `None` for readings without bounds.
    pub fn range(self) -> Option<[f64; 2]> {
        match self {
            Self::Printed | Self::DenseShare | Self::PartedShare => Some([0.0, 1.0]),
            Self::Knuth | Self::CrossValidation => None,
        }
    }
}

/// Knuth 2006 with the volume of a cell instead of that of all M cells over M.
fn knuth(tally: &CellTally) -> f64 {
    if tally.n_points == 0 {
        return 0.0;
    }
    let (n_points, n_cells) = (tally.n_points as f64, tally.n_cells());
    let area_m2 = f64::from(tally.cell_size_m).powi(2);
    // Of empty cells, and of the prior, M ln Γ(½) cancels.
    -n_points * ln(area_m2) + ln_gamma(0.5 * n_cells) - ln_gamma(n_points + 0.5 * n_cells)
        + tally.ln_gamma_sum
}

/// Rudemo 1982 with the area of a cell instead of its width; `None` for fewer than two points.
fn rudemo(tally: &CellTally) -> Option<f64> {
    let n = tally.n_points as f64;
    let area_m2 = f64::from(tally.cell_size_m).powi(2);
    let mean_square = tally.n_squares as f64 / (n * n);
    (tally.n_points >= 2).then(|| (2.0 - (n + 1.0) * mean_square) / ((n - 1.0) * area_m2))
}

/// The logarithm of the gamma function of `x` above 0, to about 1e-12 of itself.
fn ln_gamma(x: f64) -> f64 {
    // Γ(x) = Γ(x + 1) / x brings x to where Stirling's series is good.
    let (mut shifted, mut product) = (x, 1.0);
    while shifted < 10.0 {
        product *= shifted;
        shifted += 1.0;
    }
    let inverse = 1.0 / shifted;
    let square = inverse * inverse;
    let series = inverse
        * (1.0 / 12.0
            - square * (1.0 / 360.0 - square * (1.0 / 1260.0 - square * (1.0 / 1680.0 - square / 1188.0))));
    (shifted - 0.5) * ln(shifted) - shifted + 0.5 * ln(2.0 * PI) + series - ln(product)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::hierarchical_grid::GridParams;
    use crate::point_cloud::PointCloud;

    /// Cells of 1 m: a digit is a cell with so many points on the ground, `#` one of 21 on the ground, `T` one of 21 and `t`
    /// one of 2 that stand; the first line is the farthest to the left.
    fn tally(drawing: &str) -> CellTally {
        let mut positions_m = Vec::new();
        for (row, line) in drawing.lines().rev().enumerate() {
            for (column, cell) in line.chars().enumerate() {
                let (n_points, height_m) = match cell {
                    '#' => (21, 0.0),
                    'T' => (21, 1.0),
                    't' => (2, 1.0),
                    digit => (digit.to_digit(10).unwrap_or(0), 0.0),
                };
                let of_cell =
                    |it: u32| [column as f32 + 0.5, row as f32 + 0.5, if it == 0 { height_m } else { 0.0 }];
                positions_m.extend((0..n_points).map(of_cell));
            }
        }
        let mut grid = HierarchicalGrid::new(GridParams { cell_size_m: 1.0, xi: 1, extent_m: 20.0 });
        grid.fill(&positions_m.into_iter().collect::<PointCloud>());
        CellTally::of(&grid, 0.25)
    }

    #[track_caller]
    fn check(reading: FitnessReading, drawing: &str, numerator: f64, denominator: f64) {
        assert_eq!(reading.ratio(&tally(drawing)), [numerator, denominator], "{reading:?}\n{drawing}");
    }

    #[test]
    fn more_than_twenty_points_are_dense_and_the_rectangle_around_them_counts() {
        let found = tally("#.1\n...\n9..");
        assert_eq!((found.n_dense, found.n_sparse, found.n_empty, found.n_points), (1, 2, 6, 31));
        assert_eq!(found.n_squares, 21 * 21 + 1 + 81);
        assert_eq!(tally(".").n_empty, 0);
    }

    #[test]
    fn the_printed_formula_has_a_pole_and_leaves_its_range() {
        use FitnessReading::Printed;
        check(Printed, "##\n#1", 3.0, 4.0);
        check(Printed, "##.\n#11", 3.0, 4.0);
        // As many empty cells as others: 1 / 0.
        check(Printed, "#.\n.1", 1.0, 0.0);
        // 1 / (2 - 4).
        check(Printed, "#..\n..1", 1.0, -2.0);
        // 3 / (5 - 4): within the fraction's own terms, and above 1.
        check(Printed, "##.\n..#\n1.1", 3.0, 1.0);
    }

    #[test]
    fn the_dense_share_knows_no_empty_cells() {
        check(FitnessReading::DenseShare, "#.\n.1", 1.0, 2.0);
        check(FitnessReading::DenseShare, ".", 0.0, 0.0);
    }

    #[test]
    fn what_has_merged_or_fallen_apart_does_not_count() {
        use FitnessReading::PartedShare;
        // Ground does not stand, and its cells are no neighbours.
        check(PartedShare, "###\n###\n###", 0.0, 0.0);
        // Alone: no neighbour of eight.
        check(PartedShare, "#11\n#T1\n1.1", 0.0, 1.0);
        // Two side by side: 1 x 7 / 16 each.
        check(PartedShare, "TT", 0.875, 2.0);
        // Two side by side, one of them sparse.
        check(PartedShare, "Tt", 0.4375, 2.0);
        // A wall: 2 x 6 / 16 within, 1 x 7 / 16 at the ends.
        check(PartedShare, "TTT", 0.75 + 0.875, 3.0);
        // A block: the middle has all eight, edges five (15 / 16), corners three (15 / 16).
        check(PartedShare, "TTT\nTTT\nTTT", 7.5, 9.0);
    }

    #[test]
    fn knuths_posterior_of_three_points_in_two_cells() {
        // A = 1, M = 2, counts 2 and 1: Γ(1) / Γ(4) · Γ(5/2) Γ(3/2) / Γ(1/2)² = (1/6) · (3/4) · (1/2) = 1/16.
        let [numerator, denominator] = FitnessReading::Knuth.ratio(&tally("21"));
        assert!((numerator.exp() - 1.0 / 16.0).abs() < 1e-12, "{numerator}");
        assert_eq!(denominator, 3.0);
        assert_eq!(FitnessReading::Knuth.ratio(&tally(".")), [0.0, 0.0]);
    }

    #[test]
    fn the_cross_validated_risk_of_three_points_in_two_cells() {
        // n = 3, A = 1: (2 - 4 · (4 + 1) / 9) / 2 = -1/9.
        let [numerator, denominator] = FitnessReading::CrossValidation.ratio(&tally("21"));
        assert!((numerator - 1.0 / 9.0).abs() < 1e-12, "{numerator}");
        assert_eq!(denominator, 1.0);
        check(FitnessReading::CrossValidation, "1", 0.0, 0.0);
    }

    #[test]
    fn literature_rules_find_the_blocks_that_a_density_is_made_of() {
        // Half of the squares of 2 m hold sixteen points each, evenly spread.
        let mut positions_m = Vec::new();
        for (column, row) in (0..10).flat_map(|column| (0..10).map(move |row| (column, row))) {
            let fills = (column * 7 + row * 3 + column * row) % 4 < 2;
            let corner_m = [column, row].map(|it| 2.0 * it as f32 - 10.0);
            let within = (0..16).map(|it| {
                [corner_m[0] + 0.25 + 0.5 * (it % 4) as f32, corner_m[1] + 0.25 + 0.5 * (it / 4) as f32, 0.0]
            });
            positions_m.extend(within.filter(|_| fills));
        }
        let cloud: PointCloud = positions_m.into_iter().collect();
        for reading in [FitnessReading::Knuth, FitnessReading::CrossValidation] {
            let value = |cell_size_m: f32| {
                let mut grid = HierarchicalGrid::new(GridParams { cell_size_m, xi: 1, extent_m: 12.0 });
                grid.fill(&cloud);
                let [numerator, denominator] = reading.ratio(&CellTally::of(&grid, 0.25));
                numerator / denominator
            };
            let fittest =
                [0.5_f32, 1.0, 2.0, 3.0, 4.0, 6.0].into_iter().max_by(|a, b| value(*a).total_cmp(&value(*b)));
            assert_eq!(fittest, Some(2.0), "{reading:?}");
        }
    }

    #[test]
    fn the_gamma_function_of_halves_and_wholes() {
        let expected =
            [(0.5, PI.sqrt()), (1.0, 1.0), (4.0, 6.0), (2.5, 0.75 * PI.sqrt()), (11.0, 3_628_800.0)];
        for (x, gamma) in expected {
            assert!((ln_gamma(x) - f64::ln(gamma)).abs() < 1e-12, "{x}");
        }
        // Γ(x + 1) = x Γ(x).
        for x in [1e3, 1e5, 3e6] {
            assert!((ln_gamma(x + 1.0) - ln_gamma(x) - x.ln()).abs() < 1e-8, "{x}");
        }
    }
}
