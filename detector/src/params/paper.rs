//! The parameters of the detector of the papers.

use serde::Deserialize;

use super::bounds::{HIERARCHICAL_BOUNDS, check_bounds};
use super::{HierarchicalParams, ParamsError};
use crate::grid::hierarchical_grid::GridParams;
use crate::segment::connected_components::ConnectedComponentsParams;
use crate::segment::ground_segmentation::{GroundSegmentationParams, HeightOver};
use crate::segment::hough_lines::HoughParams;
use crate::segment::separation_params::DenseSeparationParams;
use crate::segment::terrain::TerrainParams;
use crate::segment::wall_refinement::WallRefinementParams;

/// Parameters of what the papers have, and of nothing else. `params/paper.toml` explains the values.
///
/// ```
/// use detector::params::HierarchicalParams;
/// use detector::params::paper::PaperParams;
///
/// let of_sensor = HierarchicalParams::shipped();
/// let params = PaperParams::shipped().stages(&of_sensor);
/// assert!(of_sensor.regrouping.enabled && !params.regrouping.enabled);
/// ```
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperParams {
    /// The two-level grid.
    pub grid: GridParams,
    /// The terrain.
    pub terrain: TerrainParams,
    /// Cell classes.
    pub ground: PaperGroundParams,
    /// Refinement of walls.
    pub walls: PaperWallParams,
    /// Weights of cell counts.
    pub density_weighting: PaperWeightingParams,
    /// Merging of coarse cells.
    pub merge: ConnectedComponentsParams,
    /// Separation by dense cells.
    pub separation: DenseSeparationParams,
    /// Which clusters are objects.
    pub cluster: PaperClusterParams,
}

/// Cell classes as printed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperGroundParams {
    /// Cells with fewer points are clutter.
    pub min_points: u32,
    /// Highest minus lowest point of a ground cell stays below this, in metres.
    pub max_ground_extent_m: f32,
    /// The mean elevation around a ground cell is within this of the terrain, in metres.
    pub ground_band_m: f32,
    /// A cell that reaches higher above a level road, or spans more, is tall; in metres.
    pub tall_height_m: f32,
}

/// Walls as printed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperWallParams {
    /// Whether walls are looked for at all.
    pub enabled: bool,
    /// Least share of a segment's length along which cells are tall.
    pub min_support: f32,
    /// How the segments are found.
    pub hough: HoughParams,
}

/// Whether cell counts are weighted. The curve is that of the sensor.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperWeightingParams {
    /// Otherwise all ranges count as equally dense.
    pub enabled: bool,
}

/// Which clusters are objects.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperClusterParams {
    /// Fewest points of an object.
    pub min_points: usize,
}

/// The text of `params/paper.toml`.
pub const PAPER_TOML: &str = include_str!("paper.toml");

impl PaperParams {
    /// The parameters that come with the program.
    pub fn shipped() -> Self {
        Self::from_toml(PAPER_TOML).expect("the embedded file is tested")
    }

    /// The same as a document.
    pub fn shipped_table() -> toml::Table {
        PAPER_TOML.parse().expect("the embedded file is tested")
    }

    /// Parameters from a complete TOML document.
    ///
    /// # Errors
    ///
    /// [`ParamsError`] if a parameter is missing, unknown or out of range.
    pub fn from_toml(text: &str) -> Result<Self, ParamsError> {
        let params: Self = toml::from_str(text)?;
        check_bounds(&toml::from_str(text)?, HIERARCHICAL_BOUNDS)?;
        Ok(params)
    }

    /// What the stages of `hierarchical` make of these parameters: everything that is in no paper is off. The density curve,
    /// and the sizes of vehicles for runs without models, are those of `hierarchical`.
    pub fn stages(&self, hierarchical: &HierarchicalParams) -> HierarchicalParams {
        let mut params = hierarchical.clone();
        params.grid = self.grid.clone();
        params.terrain = self.terrain.clone();
        let PaperGroundParams { min_points, max_ground_extent_m, ground_band_m, tall_height_m } = self.ground;
        params.ground = GroundSegmentationParams {
            min_points,
            fewer_far_away: false,
            max_ground_extent_m,
            ground_band_m,
            low_itself: false,
            tall_height_m,
            tall_over: HeightOver::LevelRoad,
        };
        let PaperWallParams { enabled, min_support, hough } = self.walls.clone();
        params.walls = WallRefinementParams { enabled, as_printed: true, min_support, hough, ..params.walls };
        params.foreground.clearance_m = f32::NEG_INFINITY;
        params.density_weighting.enabled = self.density_weighting.enabled;
        params.merge = self.merge.clone();
        params.separation = self.separation.clone();
        params.cluster.min_points = self.cluster.min_points;
        params.cluster.min_vehicle_points = self.cluster.min_points;
        params.vehicle_bounds.enabled = false;
        params.regrouping.enabled = false;
        params.grouping.enabled = false;
        params.completion.enabled = false;
        params
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_values_are_in_the_file() {
        let PaperParams { grid, ground, .. } = PaperParams::shipped();
        assert_eq!((grid.cell_size_m, grid.xi, grid.extent_m), (0.6, 3, 80.0));
        assert!((4..=8).contains(&ground.min_points));
        assert_eq!((ground.max_ground_extent_m, ground.tall_height_m), (0.25, 3.10));
    }

    #[test]
    fn nothing_that_is_in_no_paper_has_a_parameter() {
        let table = PaperParams::shipped_table();
        for absent in ["foreground", "vehicle_size", "vehicle_bounds", "regrouping", "grouping", "completion"]
        {
            assert!(!table.contains_key(absent), "{absent}");
        }
        let stages = PaperParams::shipped().stages(&HierarchicalParams::shipped());
        assert!(!stages.vehicle_bounds.enabled && !stages.regrouping.enabled && !stages.completion.enabled);
        assert_eq!(stages.cluster.min_vehicle_points, stages.cluster.min_points);
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, message: &str) {
        let error = PaperParams::from_toml(&PAPER_TOML.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }

    #[test]
    fn misspelled_missing_and_senseless_parameters_are_refused() {
        check_refused("xi = 3", "ksi = 3", "unknown field `ksi`");
        check_refused("xi = 3", "", "missing field `xi`");
        check_refused("xi = 3", "xi = 9", "grid.xi = 9 is not within 1 to 8");
        check_refused("[cluster]", "[completion]\nenabled = true\n[cluster]", "unknown field `completion`");
    }
}
