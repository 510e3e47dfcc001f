//! The parameters of the hierarchical detector, from one file; those of the papers' from another.

pub mod bounds;
pub mod paper;
pub mod front_end;

use serde::Deserialize;

use self::bounds::{HIERARCHICAL_BOUNDS, check_bounds};
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
use crate::portable_math::ln;
use crate::road_user::{RoadUserOdds, RoadUserRule};
use crate::segment::foreground::ForegroundParams;
use crate::segment::ground_segmentation::GroundSegmentationParams;
use crate::segment::terrain::TerrainParams;
use crate::segment::wall_params::WallRefinementParams;
use crate::whole::reported_boxes::BoxParams;

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
    /// Which clusters are objects.
    pub cluster: ClusterParams,
    /// Which objects are vehicles.
    pub vehicle_size: SizeGateParams,
    /// Which objects the vehicle model is asked about.
    pub vehicle_bounds: VehicleBoundsParams,
    /// The tree of groupings and its best cut.
    pub grouping: GroupingParams,
    /// Points of objects that are no foreground.
    pub completion: CompletionParams,
    /// The boxes that are reported.
    pub boxes: BoxParams,
}

/// The tree of groupings and its best cut.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroupingParams {
    /// Cost of an object: a group with a smaller expected IoU is no object.
    pub object_cost: f32,
    /// Cost of a vehicle: a group with at least this expected IoU, but too small a one for an object, is taken if it is
    /// classified as a vehicle.
    pub vehicle_cost: f32,
    /// The least probability of a vehicle with which an object is ranked as one, by protocols that rank detections.
    pub ranked_probability: f32,
    /// Rounds of IoU prediction for all groups, 1 to 3: from the second on with the predictions for the groups around.
    pub rounds: u8,
    /// Whether the surroundings of a group are among its values.
    pub surroundings: bool,
    /// The points that are grouped.
    pub candidates: CandidatesParams,
    /// The gaps between them.
    pub gaps: DenseGapsParams,
    /// Cuts where there is no gap.
    pub cuts: LeafCutsParams,
    /// Which groups are described.
    pub bounds: NodeBoundsParams,
}

/// The logarithm of the odds of `probability`.
pub fn log_odds(probability: f32) -> f32 {
    let probability = f64::from(probability);
    ln(probability / (1.0 - probability)) as f32
}

impl HierarchicalParams {
    /// Checks that there is room for all dense cells, of which the tree of groupings keeps a plan.
    fn check_dense_cells(&self) -> Result<(), ParamsError> {
        let GridParams { cell_size_m, xi, extent_m } = self.grid;
        let least_m = 2.0 * f64::from(extent_m) * f64::from(xi) / f64::from(MOST_DENSE_CELLS);
        if f64::from(cell_size_m) < least_m {
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

/// Most dense cells along a side of the grid.
const MOST_DENSE_CELLS: u32 = 12_000;

/// Which clusters are objects.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClusterParams {
    /// Fewest points of a cluster that a model may classify as a vehicle. Clusters of fewer than `min_points` are dropped
    /// unless it does.
    pub min_vehicle_points: usize,
    /// A model classifies an object as a vehicle if it is one with more than this probability.
    pub min_vehicle_probability: f32,
    /// And as a pedestrian with more than this.
    pub min_pedestrian_probability: f32,
    /// And as a cyclist with more than this.
    pub min_cyclist_probability: f32,
    /// Fewest points of an object.
    pub min_points: usize,
}

impl ClusterParams {
    /// Fewest points of a cluster that a model may classify as a vehicle: no more than those of an object.
    pub fn least_vehicle_points(&self) -> usize {
        self.min_vehicle_points.min(self.min_points)
    }

    /// Thresholds by which an object that a model judged is a road user.
    pub fn road_user_rule(&self) -> RoadUserRule {
        let least =
            [self.min_vehicle_probability, self.min_pedestrian_probability, self.min_cyclist_probability];
        RoadUserRule {
            least_points: self.least_vehicle_points(),
            least_odds: RoadUserOdds(least.map(log_odds)),
        }
    }
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
        allowed: String,
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

    /// The shipped parameters as a document: `params/hierarchical.toml` with the density curve of [`PAPER_SENSOR`].
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
        check_bounds(&toml::from_str(text)?, HIERARCHICAL_BOUNDS)?;
        params.check_dense_cells()?;
        let implausible = |ImplausibleCurve { field, value, allowed }| ParamsError::OutOfRange {
            name: field,
            value,
            allowed: allowed.to_owned(),
        };
        params.density_weighting.curve.check().map_err(implausible)?;
        Ok(params)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::group::node_context::OBJECT_COST;

    #[test]
    fn the_paper_has_cells_of_60_cm_and_three_dense_cells_a_side() {
        let grid = HierarchicalParams::shipped().grid;
        assert_eq!((grid.cell_size_m, grid.xi), (0.6, 3));
    }

    #[test]
    fn groups_are_taken_at_the_expected_iou_that_forests_have_learned_with() {
        assert_eq!(HierarchicalParams::shipped().grouping.object_cost, OBJECT_COST);
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
            "min_end_m = 0.4",
            "min_end_m = -0.1",
            "grouping.cuts.min_end_m = -0.1 is not within 0 to 100 m",
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
        table["grid"]["extent_m"] = 80.0.into();
        assert!(HierarchicalParams::from_toml(&table.to_string()).is_ok());
    }
}
