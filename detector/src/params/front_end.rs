//! The parameters of the stages up to the foreground.

use super::HierarchicalParams;
use super::paper::{PaperParams, PaperWallParams};
use crate::grid::density_weighting::DensityWeightingParams;
use crate::grid::hierarchical_grid::GridParams;
use crate::segment::foreground::ForegroundParams;
use crate::segment::ground_segmentation::GroundSegmentationParams;
use crate::segment::terrain::TerrainParams;
use crate::segment::wall_params::WallRefinementParams;

/// Parameters of the stages from the grid to the foreground, which all detectors over a grid have.
///
/// ```
/// use detector::params::HierarchicalParams;
/// use detector::params::paper::PaperParams;
///
/// let of_sensor = HierarchicalParams::shipped();
/// assert!(!of_sensor.front_end().walls.as_printed);
/// assert!(PaperParams::shipped().front_end(&of_sensor).walls.as_printed);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FrontEndParams {
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
}

impl HierarchicalParams {
    /// Those of the stages up to the foreground.
    pub fn front_end(&self) -> FrontEndParams {
        let Self { grid, terrain, ground, walls, foreground, density_weighting, .. } = self.clone();
        FrontEndParams { grid, terrain, ground, walls, foreground, density_weighting }
    }
}

impl PaperParams {
    /// Those of the stages up to the foreground. The density curve, and the parameters of walls that are not found as
    /// printed, are those of `of_sensor`.
    pub fn front_end(&self, of_sensor: &HierarchicalParams) -> FrontEndParams {
        let HierarchicalParams { walls, foreground, density_weighting, .. } = of_sensor.clone();
        let Self { grid, terrain, ground, .. } = self.clone();
        let PaperWallParams { enabled, as_printed, beside, min_support, hough } = self.walls.clone();
        FrontEndParams {
            grid,
            terrain,
            ground,
            walls: WallRefinementParams { enabled, as_printed, beside, min_support, hough, ..walls },
            foreground: ForegroundParams { clearance_m: self.foreground.clearance_m, ..foreground },
            density_weighting: DensityWeightingParams {
                enabled: self.density_weighting.enabled,
                ..density_weighting
            },
        }
    }
}
