//! The parameters of the baselines, from one file.

use detector::params::ParamsError;
use detector::params::bounds::{Bounds, check_bounds};
use serde::Deserialize;

use crate::occupancy_grid_components::OccupancyParams;

/// Parameters of every baseline. `params.toml` explains the values.
///
/// ```
/// use baselines::params::{BaselineParams, PARAMS_TOML};
///
/// let wider = PARAMS_TOML.replace("tolerance_m = 0.5", "tolerance_m = 0.8");
/// assert_eq!(BaselineParams::from_toml(&wider)?.kd_tree.tolerance_m, 0.8);
/// # Ok::<(), detector::params::ParamsError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaselineParams {
    /// Euclidean components over a kd-tree.
    pub kd_tree: KdTreeParams,
    /// Principal axes of components of an occupancy grid.
    pub pca: PcaParams,
}

/// Tuning of [`kd_tree`](crate::kd_tree_detector::kd_tree).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KdTreeParams {
    /// Points nearer to each other than this are neighbours, in metres.
    pub tolerance_m: f32,
    /// Fewest points of an object.
    pub min_points: usize,
    /// Most points of an object.
    pub max_points: usize,
    /// How neighbours are found.
    pub neighbors: NeighborSearch,
    /// Which points are clustered.
    pub foreground: ForegroundChoice,
}

/// How the neighbours of points are found. The components are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NeighborSearch {
    /// In cells: [`NestedComponents`](crate::nested_components::NestedComponents), where they are exact, else in a kd-tree.
    Cells,
    /// In a kd-tree, around every point: [`kd_tree_components`](crate::kd_tree_components::kd_tree_components).
    Tree,
}

/// Which points of a scan are clustered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ForegroundChoice {
    /// Those of short objects, as the hierarchical detector finds them before it looks for walls.
    Short,
    /// Those of short objects that are not on walls, the foreground of the hierarchical detector.
    Refined,
    /// Points of everything that is no ground, façades, poles and trees included.
    Standing,
    /// All points, road and façades included.
    All,
}

/// Tuning of [`pca`](crate::pca_detector::pca).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PcaParams {
    /// The occupancy grid.
    pub grid: OccupancyGridParams,
    /// Which of its cells are occupied.
    pub occupancy: OccupancyParams,
    /// Which clusters are objects.
    pub cluster: ClusterExtentParams,
}

/// Geometry of the occupancy grid.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OccupancyGridParams {
    /// Side of a cell in metres.
    pub cell_size_m: f32,
    /// Half the side of the gridded square in metres; the sensor is at its centre.
    pub extent_m: f32,
}

/// Which clusters are objects.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClusterExtentParams {
    /// Fewest points of an object.
    pub min_points: usize,
    /// Longest side of an object's box on the ground plan, in metres. Longer clusters are façade, fence or wall.
    pub max_extent_m: f32,
}

/// The text of `params.toml`.
pub const PARAMS_TOML: &str = include_str!("params.toml");

impl BaselineParams {
    /// The parameters that ship with the program.
    pub fn shipped() -> Self {
        Self::from_toml(PARAMS_TOML).expect("the embedded file is tested")
    }

    /// Parameters from a complete TOML document.
    ///
    /// # Errors
    ///
    /// [`ParamsError`] if a parameter is missing, unknown or out of range.
    pub fn from_toml(text: &str) -> Result<Self, ParamsError> {
        let params: Self = toml::from_str(text)?;
        check_bounds(&toml::from_str(text)?, BASELINE_BOUNDS)?;
        let KdTreeParams { min_points, max_points, .. } = params.kd_tree;
        if max_points < min_points {
            let least = format!("kd_tree.min_points = {min_points}");
            let (name, value) = ("kd_tree.max_points", max_points as f64);
            return Err(ParamsError::TooLow { name, value, least });
        }
        Ok(params)
    }
}

/// Bounds of the values.
pub const BASELINE_BOUNDS: &[Bounds] = &[
    Bounds::new("kd_tree.tolerance_m", 0.01, 100.0),
    Bounds::new("kd_tree.min_points", 1.0, f64::INFINITY),
    Bounds::new("kd_tree.max_points", 1.0, f64::INFINITY),
    Bounds::new("pca.grid.cell_size_m", 0.05, 10.0),
    Bounds::new("pca.grid.extent_m", 1.0, 300.0),
    Bounds::new("pca.occupancy.min_height_difference_m", 0.0, 10.0),
    Bounds::new("pca.occupancy.min_points", 1.0, f64::INFINITY),
    Bounds::new("pca.cluster.min_points", 1.0, f64::INFINITY),
    Bounds::new("pca.cluster.max_extent_m", 0.1, 1000.0),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kd_tree_starts_from_the_short_objects_before_walls_are_refined() {
        assert_eq!(BaselineParams::shipped().kd_tree.foreground, ForegroundChoice::Short);
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, message: &str) {
        assert!(PARAMS_TOML.contains(from), "{from}");
        let error = BaselineParams::from_toml(&PARAMS_TOML.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }

    #[test]
    fn misspelled_and_missing_parameters_are_refused() {
        check_refused("tolerance_m =", "tolerence_m =", "unknown field `tolerence_m`");
        check_refused("max_extent_m = 20.0", "", "missing field `max_extent_m`");
        check_refused(
            "\"short\"",
            "\"tall\"",
            "unknown variant `tall`, expected one of `short`, `refined`, `standing`, `all`",
        );
    }

    #[test]
    fn senseless_parameters_are_refused() {
        check_refused("tolerance_m = 0.5", "tolerance_m = nan", "kd_tree.tolerance_m = NaN");
        check_refused("tolerance_m = 0.5", "tolerance_m = -0.5", "not within 0.01 to 100 m");
        check_refused(
            "max_points = 25000",
            "max_points = 9",
            "kd_tree.max_points = 9 is less than kd_tree.min_points = 15",
        );
        check_refused(
            "min_height_difference_m = 0.2",
            "min_height_difference_m = 10.1",
            "_m = 10.1 is not within",
        );
        check_refused("min_points = 2", "min_points = 0", "pca.occupancy.min_points = 0 is less than 1");
        check_refused("cell_size_m = 0.4", "cell_size_m = 0.0", "pca.grid.cell_size_m = 0 is not within");
        check_refused("max_extent_m = 20.0", "max_extent_m = inf", "pca.cluster.max_extent_m = inf");
    }
}
