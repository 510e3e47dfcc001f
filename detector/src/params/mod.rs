//! The parameters of the hierarchical detector, from one file; those of the papers' from another.

pub mod paper;

use serde::Deserialize;

use crate::classify::size_gate::SizeGateParams;
use crate::complete::completion::CompletionParams;
use crate::describe::seen_size::VehicleBoundsParams;
use crate::grid::density_curve::{DensityCurve, ImplausibleCurve};
use crate::grid::density_weighting::DensityWeightingParams;
use crate::grid::hierarchical_grid::GridParams;
use crate::group::candidates::CandidatesParams;
use crate::group::dense_gaps::DenseGapsParams;
use crate::group::leaf_cuts::LeafCutsParams;
use crate::group::node_values::NodeBoundsParams;
use crate::regroup::regrouping_params::RegroupingParams;
use crate::segment::connected_components::ConnectedComponentsParams;
use crate::segment::foreground::ForegroundParams;
use crate::segment::ground_segmentation::GroundSegmentationParams;
use crate::segment::separation_params::DenseSeparationParams;
use crate::segment::terrain::TerrainParams;
use crate::segment::wall_refinement::WallRefinementParams;

/// Parameters of every stage. `params/hierarchical.toml` explains the values.
///
/// ```
/// use detector::params::HierarchicalParams;
///
/// let mut document = HierarchicalParams::shipped_table();
/// document["grid"]["cell_size_m"] = 0.4.into();
/// assert_eq!(HierarchicalParams::from_toml(&document.to_string())?.grid.cell_size_m, 0.4);
///
/// document["grid"]["cell_size_m"] = 40.0.into();
/// let refused = HierarchicalParams::from_toml(&document.to_string());
/// assert!(refused.is_err_and(|it| it.to_string() == "grid.cell_size_m = 40 is not within 0.05 to 10 m"));
/// # Ok::<(), detector::params::ParamsError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HierarchicalParams {
    /// The two-level grid.
    pub grid: GridParams,
    /// The terrain.
    pub terrain: TerrainParams,
    /// Cell classes.
    pub ground: GroundSegmentationParams,
    /// Refinement of walls.
    pub walls: WallRefinementParams,
    /// Foreground points.
    pub foreground: ForegroundParams,
    /// Weights of cell counts.
    pub density_weighting: DensityWeightingParams,
    /// Merging of coarse cells.
    pub merge: ConnectedComponentsParams,
    /// Separation by dense cells.
    pub separation: DenseSeparationParams,
    /// Which clusters are objects.
    pub cluster: ClusterParams,
    /// Which objects are vehicles.
    pub vehicle_size: SizeGateParams,
    /// Which objects the vehicle model is asked about.
    pub vehicle_bounds: VehicleBoundsParams,
    /// Cutting and joining objects by the vehicle model.
    pub regrouping: RegroupingParams,
    /// The tree of groupings and its best cut.
    pub grouping: GroupingParams,
    /// Points of objects that are no foreground.
    pub completion: CompletionParams,
}

/// The tree of groupings and its best cut.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroupingParams {
    /// Whether objects are the best cut of a tree of groupings; if not, cells are merged and separated as in the paper.
    pub enabled: bool,
    /// What an object costs: one that is expected to have a smaller intersection over union is none.
    pub object_cost: f32,
    /// The points that are grouped.
    pub candidates: CandidatesParams,
    /// The gaps between them.
    pub gaps: DenseGapsParams,
    /// Cuts where there is no gap.
    pub cuts: LeafCutsParams,
    /// Which groups are looked at.
    pub bounds: NodeBoundsParams,
}

impl HierarchicalParams {
    /// Checks that there is room for all dense cells, of which the tree of groupings keeps a plan.
    fn check_dense_cells(&self) -> Result<(), ParamsError> {
        let GridParams { cell_size_m, xi, extent_m } = self.grid;
        let least_m = 2.0 * f64::from(extent_m) * f64::from(xi) / f64::from(MOST_DENSE_CELLS);
        if self.grouping.enabled && f64::from(cell_size_m) < least_m {
            return Err(ParamsError::TooLow {
                name: "grid.cell_size_m",
                value: as_written(cell_size_m.into()),
                least: format!(
                    "{least_m:.3}, as grouping needs it with grid.xi = {xi} and grid.extent_m = {extent_m}"
                ),
            });
        }
        Ok(())
    }
}

/// Dense cells along a side of the grid.
const MOST_DENSE_CELLS: u32 = 12_000;

impl GroupingParams {
    fn validate(&self) -> Result<(), ParamsError> {
        let GroupingParams { object_cost, candidates, gaps, cuts, bounds, .. } = self;
        for (name, value, most, allowed) in [
            ("grouping.object_cost", *object_cost, 1.0_f32, "0 to 1"),
            ("grouping.candidates.least_free_m", candidates.least_free_m, 100.0, "0 to 100 m"),
            ("grouping.candidates.free_per_range", candidates.free_per_range, 1.0, "0 to 1"),
            ("grouping.candidates.highest_foot_m", candidates.highest_foot_m, 100.0, "0 to 100 m"),
            ("grouping.candidates.highest_top_m", candidates.highest_top_m, 100.0, "0 to 100 m"),
            ("grouping.gaps.n_rounds", gaps.n_rounds as f32, 20.0, "0 to 20"),
            ("grouping.gaps.height_steps", gaps.height_steps as f32, 20.0, "0 to 20"),
            ("grouping.gaps.wall_steps", gaps.wall_steps as f32, 20.0, "0 to 20"),
            ("grouping.bounds.min_top_m", bounds.min_top_m, 100.0, "0 to 100 m"),
            ("grouping.gaps.low_density_share", gaps.low_density_share, 1.0, "0 to 1"),
            ("grouping.cuts.min_length_m", cuts.min_length_m, 100.0, "0 to 100 m"),
            ("grouping.cuts.min_width_m", cuts.min_width_m, 100.0, "0 to 100 m"),
            ("grouping.cuts.max_length_m", cuts.max_length_m, 1000.0, "0 to 1000 m"),
            ("grouping.cuts.min_end_m", cuts.min_end_m, 100.0, "0 to 100 m"),
            ("grouping.cuts.max_depth", f32::from(cuts.max_depth), 10.0, "0 to 10"),
            ("grouping.bounds.max_length_m", bounds.max_length_m, 100.0, "0 to 100 m"),
            ("grouping.bounds.max_width_m", bounds.max_width_m, 100.0, "0 to 100 m"),
        ] {
            check_range(name, value.into(), [0.0, most.into()], allowed)?;
        }
        Ok(())
    }
}

/// Which clusters are objects.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClusterParams {
    /// Fewest points of what a vehicle model may take for a vehicle. Smaller clusters than `min_points` are dropped unless it
    /// does.
    pub min_vehicle_points: usize,
    /// Fewest points of an object.
    pub min_points: usize,
}

/// The text of `params/hierarchical.toml`, which lacks the density curve: that is the sensor's.
pub const HIERARCHICAL_TOML: &str = include_str!("hierarchical.toml");
/// The sensor of the paper, whose density curve stands in where that of the sensor is not known.
pub const PAPER_SENSOR: &str = "hdl-64e-s2";

/// Why parameters cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ParamsError {
    /// Not TOML, or not these parameters.
    #[error(transparent)]
    Syntax(#[from] toml::de::Error),
    /// A value no detector can work with.
    #[error("{name} = {value} is not within {allowed}")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The values that make sense.
        allowed: &'static str,
    },
    /// A value below the least that makes sense.
    #[error("{name} = {value} is less than {least}")]
    TooLow {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The least, with the name of the parameter that says so if one does.
        least: String,
    },
}

/// Checks that parameter `name` lies between `low` and `high`, which NaN does not; `allowed` says so in words.
///
/// # Errors
///
/// [`ParamsError::OutOfRange`].
pub fn check_range(
    name: &'static str,
    value: f64,
    [low, high]: [f64; 2],
    allowed: &'static str,
) -> Result<(), ParamsError> {
    let value = as_written(value);
    if (low..=high).contains(&value) { Ok(()) } else { Err(ParamsError::OutOfRange { name, value, allowed }) }
}

/// A single-precision number as the decimal it was written as: 0.6, not the 0.6000000238 that it stands for. Numbers of
/// double precision stay as they are.
fn as_written(value: f64) -> f64 {
    let single = value as f32;
    if f64::from(single) != value {
        return value;
    }
    single.to_string().parse().expect("a number was printed")
}

impl HierarchicalParams {
    /// The parameters that come with the program.
    pub fn shipped() -> Self {
        Self::from_toml(&Self::shipped_table().to_string()).expect("the embedded files are tested")
    }

    /// The same as a document: `params/hierarchical.toml` with the density curve of [`PAPER_SENSOR`].
    pub fn shipped_table() -> toml::Table {
        let mut table: toml::Table = HIERARCHICAL_TOML.parse().expect("the embedded file is tested");
        let curve = DensityCurve::shipped_table(PAPER_SENSOR).expect("it is shipped");
        let weighting = table.get_mut("density_weighting").and_then(toml::Value::as_table_mut);
        weighting.expect("it is in the file").insert("curve".to_owned(), toml::Value::Table(curve));
        table
    }

    /// Parameters from a complete TOML document.
    ///
    /// # Errors
    ///
    /// [`ParamsError`] if a parameter is missing, unknown or out of range.
    pub fn from_toml(text: &str) -> Result<Self, ParamsError> {
        let params: Self = toml::from_str(text)?;
        params.validate()?;
        Ok(params)
    }

    fn validate(&self) -> Result<(), ParamsError> {
        let within = |name, value, low, high, allowed| check_range(name, value, [low, high], allowed);
        let grid = &self.grid;
        within("grid.cell_size_m", grid.cell_size_m.into(), 0.05, 10.0, "0.05 to 10 m")?;
        within("grid.xi", grid.xi.into(), 1.0, 8.0, "1 to 8")?;
        within("grid.extent_m", grid.extent_m.into(), 1.0, 300.0, "1 to 300 m")?;
        within("terrain.block_cells", self.terrain.block_cells.into(), 1.0, 100.0, "1 to 100")?;
        within("terrain.low_quantile", self.terrain.low_quantile.into(), 0.0, 1.0, "0 to 1")?;
        let walls = &self.walls;
        within("walls.min_height_m", walls.min_height_m.into(), 0.0, 100.0, "0 to 100 m")?;
        within("walls.ceiling_margin_deg", walls.ceiling_margin_deg.into(), 0.0, 90.0, "0 to 90 degrees")?;
        within("walls.min_support", walls.min_support.into(), 0.0, 1.0, "0 to 1")?;
        within("walls.max_ground_behind", walls.max_ground_behind.into(), 0.0, 1.0, "0 to 1")?;
        let hough = &walls.hough;
        within("walls.hough.n_directions", hough.n_directions.into(), 4.0, 720.0, "4 to 720")?;
        within("walls.hough.min_votes", hough.min_votes.into(), 2.0, 1000.0, "2 to 1000")?;
        within("walls.hough.min_length_cells", hough.min_length_cells.into(), 2.0, 10_000.0, "2 to 10000")?;
        within("walls.hough.max_gap_cells", hough.max_gap_cells.into(), 0.0, 10_000.0, "0 to 10000")?;
        let ground_band_m = self.foreground.ground_band_m.into();
        within("foreground.ground_band_m", ground_band_m, 0.0, 10.0, "0 to 10 m")?;
        let separation = &self.separation;
        within("separation.low_density_share", separation.low_density_share.into(), 0.0, 1.0, "0 to 1")?;
        let ratio = separation.object_density_ratio.into();
        within("separation.object_density_ratio", ratio, 0.0, 1e6, "0 to 10^6")?;
        let gap_points = separation.single_gap_points.into();
        within("separation.single_gap_points", gap_points, 0.0, 1e6, "0 to 10^6 points")?;
        let regrouping = &self.regrouping;
        for (name, value) in [
            ("regrouping.min_length_m", regrouping.min_length_m),
            ("regrouping.min_width_m", regrouping.min_width_m),
            ("regrouping.min_end_m", regrouping.min_end_m),
            ("regrouping.lone_part_margin", regrouping.lone_part_margin),
            ("regrouping.max_gap_m", regrouping.max_gap_m),
            ("regrouping.max_joined_length_m", regrouping.max_joined_length_m),
        ] {
            within(name, value.into(), 0.0, 100.0, "0 to 100")?;
        }
        self.grouping.validate()?;
        self.check_dense_cells()?;
        let completion = &self.completion;
        within("completion.growth_m", completion.growth_m.into(), 0.0, 10.0, "0 to 10 m")?;
        within("completion.clearance_m", completion.clearance_m.into(), -10.0, 10.0, "-10 to 10 m")?;
        let implausible = |ImplausibleCurve { field, value, allowed }| ParamsError::OutOfRange {
            name: field,
            value,
            allowed,
        };
        self.density_weighting.curve.check().map_err(implausible)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paper_has_cells_of_60_cm_and_three_dense_cells_a_side() {
        let grid = HierarchicalParams::shipped().grid;
        assert_eq!((grid.cell_size_m, grid.xi), (0.6, 3));
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, message: &str) {
        let complete = HierarchicalParams::shipped_table().to_string();
        assert!(complete.contains(from), "{complete}");
        let error = HierarchicalParams::from_toml(&complete.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }

    #[test]
    fn misspelled_missing_and_senseless_parameters_are_refused() {
        check_refused("xi = 3", "ksi = 3", "unknown field `ksi`");
        check_refused("xi = 3", "", "missing field `xi`");
        check_refused("xi = 3", "xi = 9", "grid.xi = 9 is not within 1 to 8");
        check_refused(
            "ground_band_m = 0.25",
            "ground_band_m = -1.0",
            "foreground.ground_band_m = -1 is not within",
        );
        check_refused("growth_m = 0.1", "growth_m = nan", "completion.growth_m = NaN");
        check_refused(
            "max_gap_m = 0.3",
            "max_gap_m = -0.1",
            "regrouping.max_gap_m = -0.1 is not within 0 to 100",
        );
        check_refused(
            "low_quantile = 0.25",
            "low_quantile = 1.1",
            "terrain.low_quantile = 1.1 is not within",
        );
        check_refused("cell_size_m = 0.6", "cell_size_m = nan", "grid.cell_size_m = NaN");
    }

    #[test]
    fn there_has_to_be_room_for_all_dense_cells() {
        let mut table = HierarchicalParams::shipped_table();
        table["grid"]["extent_m"] = 300.0.into();
        table["grid"]["cell_size_m"] = 0.1.into();
        let error = HierarchicalParams::from_toml(&table.to_string()).unwrap_err().to_string();
        let expected = "grid.cell_size_m = 0.1 is less than 0.150, as grouping needs it with grid.xi = 3";
        assert!(error.starts_with(expected), "{error}");
        table["grouping"]["enabled"] = false.into();
        assert!(HierarchicalParams::from_toml(&table.to_string()).is_ok());
    }
}
