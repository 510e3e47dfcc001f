//! The parameters of the detector of the papers.

use serde::Deserialize;

use super::ParamsError;
use super::bounds::{HIERARCHICAL_BOUNDS, check_bounds};
use crate::grid::hierarchical_grid::GridParams;
use crate::segment::connected_components::ConnectedComponentsParams;
use crate::segment::dense_separation::DenseSeparationParams;
use crate::segment::ground_segmentation::GroundSegmentationParams;
use crate::segment::hough_lines::HoughParams;
use crate::segment::terrain::TerrainParams;

/// Parameters of the papers' stages, and of readings that the papers do not have, which are off. `params/paper.toml`
/// explains the values.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperParams {
    /// The two-level grid.
    pub grid: GridParams,
    /// The terrain.
    pub terrain: TerrainParams,
    /// Cell classes.
    pub ground: GroundSegmentationParams,
    /// Refinement of walls.
    pub walls: PaperWallParams,
    /// Foreground points.
    pub foreground: PaperForegroundParams,
    /// Weights of cell counts.
    pub density_weighting: PaperWeightingParams,
    /// Merging of coarse cells.
    pub merge: ConnectedComponentsParams,
    /// Separation by dense cells.
    pub separation: DenseSeparationParams,
    /// Outlines of objects.
    pub outline: PaperOutlineParams,
    /// Which clusters are objects.
    pub cluster: PaperClusterParams,
}

/// Walls.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperWallParams {
    /// Whether walls are looked for at all.
    pub enabled: bool,
    /// Whether they are found as the paper prints it.
    pub as_printed: bool,
    /// Whether the cells beside a line become tall, too, where walls are found as printed.
    pub beside: bool,
    /// Least share of a segment's length along which cells are tall.
    pub min_support: f32,
    /// How the segments are found.
    pub hough: HoughParams,
}

/// Which points are foreground.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperForegroundParams {
    /// Points of a foreground cell that are no higher than this above the lowest ground of the cell are road, in metres.
    pub clearance_m: f32,
}

/// Whether cell counts are weighted. The curve is that of the sensor.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperWeightingParams {
    /// If not, all ranges count as equally dense.
    pub enabled: bool,
}

/// Outlines of objects.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperOutlineParams {
    /// Fewest points of a dense cell on the outline.
    pub min_points: u32,
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

    /// The parameters that come with the program, as a document.
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::segment::ground_segmentation::HeightOver;

    #[test]
    fn printed_values_are_in_the_file() {
        let PaperParams { grid, ground, .. } = PaperParams::shipped();
        assert_eq!((grid.cell_size_m, grid.xi, grid.extent_m), (0.6, 3, 80.0));
        assert!((4..=8).contains(&ground.min_points));
        assert_eq!((ground.max_ground_extent_m, ground.tall_height_m), (0.25, 3.10));
    }

    #[test]
    fn what_is_in_no_paper_is_off_or_has_no_parameter() {
        let table = PaperParams::shipped_table();
        for absent in ["vehicle_size", "vehicle_bounds", "grouping", "completion"] {
            assert!(!table.contains_key(absent), "{absent}");
        }
        let params = PaperParams::shipped();
        assert!(params.walls.as_printed && params.foreground.clearance_m == f32::NEG_INFINITY);
        assert!(params.ground.fewer_far_away && !params.ground.low_itself);
        assert_eq!(params.ground.tall_over, HeightOver::Terrain);
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
