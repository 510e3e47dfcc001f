//! Which cells are ground, which are tall, and which are the street's objects.

use serde::Deserialize;

use crate::grid::density_weighting::DensityWeighting;
use crate::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use crate::segment::terrain::Terrain;
use crate::surface_class::SurfaceClass;

/// Tuning of [`GroundSegmentation::segment`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroundSegmentationParams {
    /// Cells with fewer points are clutter; the paper has 4 to 8.
    pub min_points: u32,
    /// Whether fewer points are enough where the road itself puts fewer into a cell. In the paper they are not.
    pub fewer_far_away: bool,
    /// Highest minus lowest point of a ground cell stays below this, in metres.
    pub max_ground_extent_m: f32,
    /// The mean elevation around a ground cell is within this of the terrain, in metres.
    pub ground_band_m: f32,
    /// Whether the highest point of a ground cell is within it, too. In the paper its neighbourhood is enough.
    pub low_itself: bool,
    /// A cell whose highest point is higher than this, or that spans more, is tall; in metres.
    pub tall_height_m: f32,
    /// Level that its height is measured from.
    pub tall_over: HeightOver,
}

/// Level that a height is measured from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeightOver {
    /// The ground below the position.
    Terrain,
    /// A level road below the sensor, everywhere: as the paper measures heights from the sensor.
    LevelRoad,
}

/// The classes of cells.
///
/// The paper calls a cell tall above 1.40 m over the sensor or when it spans 3.10 m. With its sensor at 1.73 m both are 3.1
/// m over a level road, which is [`HeightOver::LevelRoad`]; over the *terrain* a climbing road does not turn its cars into
/// walls.
///
/// A fixed number of points, as in the paper, makes clutter of objects far away: at 40 m the road puts a point into every
/// third cell. With [`GroundSegmentationParams::fewer_far_away`] the number follows the weight of the range down to a single
/// point, as all counts do in section 4.
///
/// Paper: HG sections 3.1 and 4.
#[derive(Debug, Clone)]
pub struct GroundSegmentation {
    params: GroundSegmentationParams,
    // Fewest points of a cell that is no clutter.
    least_points_by_metre: Vec<u32>,
}

impl GroundSegmentation {
    /// Classes for grids of the geometry `grid`.
    pub fn new(params: GroundSegmentationParams, grid: &GridParams, weighting: &DensityWeighting) -> Self {
        let points_at_weight_1 = weighting.peak_points_per_m2() * grid.cell_size_m * grid.cell_size_m;
        let least_points = |weight: &f32| {
            let expected = (points_at_weight_1 * weight).ceil() as u32;
            if params.fewer_far_away { expected.max(1).min(params.min_points) } else { params.min_points }
        };
        let least_points_by_metre = weighting.weight_by_metre().iter().map(least_points).collect();
        Self { params, least_points_by_metre }
    }

    /// Writes the class of every cell of `grid` to `classes`, which has one entry a cell; empty cells are unseen.
    pub fn segment(&self, grid: &HierarchicalGrid, terrain: &Terrain, classes: &mut Vec<SurfaceClass>) {
        classes.clear();
        classes.resize(grid.cells().len(), SurfaceClass::Unseen);
        for &cell_idx in grid.occupied() {
            classes[cell_idx as usize] = self.class_of(grid, terrain, cell_idx);
        }
    }

    fn class_of(&self, grid: &HierarchicalGrid, terrain: &Terrain, cell_idx: u32) -> SurfaceClass {
        let params = &self.params;
        let cell = &grid.cells()[cell_idx as usize];
        if cell.n_points < params.min_points && cell.n_points < self.least_points(grid, cell_idx) {
            return SurfaceClass::Clutter;
        }
        let terrain_m = terrain.elevation_m(grid.column_and_row(cell_idx));
        let flat = cell.z_extent_m() < params.max_ground_extent_m;
        // A ring across the boot of a car far away is flat, and the mean of its neighbourhood is that of the road.
        let low = !params.low_itself || cell.z_max_m - terrain_m <= params.ground_band_m;
        if flat && low && (neighborhood_mean_m(grid, cell_idx) - terrain_m).abs() <= params.ground_band_m {
            return SurfaceClass::Ground;
        }
        let bottom_m = match params.tall_over {
            HeightOver::Terrain => terrain_m,
            HeightOver::LevelRoad => terrain.level_road_m(),
        };
        if cell.z_max_m - bottom_m > params.tall_height_m || cell.z_extent_m() > params.tall_height_m {
            SurfaceClass::Tall
        } else {
            SurfaceClass::Short
        }
    }

    fn least_points(&self, grid: &HierarchicalGrid, cell_idx: u32) -> u32 {
        let [x_m, y_m] = grid.center_m(cell_idx);
        let metre = (x_m * x_m + y_m * y_m).sqrt() as usize;
        self.least_points_by_metre[metre.min(self.least_points_by_metre.len() - 1)]
    }
}

/// Mean over the occupied cells of the neighbourhood of their mean elevations.
fn neighborhood_mean_m(grid: &HierarchicalGrid, cell_idx: u32) -> f32 {
    let mut sum_m = 0.0;
    let mut n_occupied = 0.0;
    for neighbor_idx in grid.neighborhood(cell_idx) {
        let cell = &grid.cells()[neighbor_idx as usize];
        // Chosen, not branched on: which neighbours are occupied cannot be foreseen.
        let is_occupied = cell.n_points > 0;
        sum_m += if is_occupied { cell.z_mean_m() } else { 0.0 };
        n_occupied += f32::from(is_occupied);
    }
    sum_m / n_occupied
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::HierarchicalParams;
    use crate::params::front_end::FrontEndParams;
    use crate::params::paper::PaperParams;
    use crate::pipeline::foreground_stages::ground;
    use crate::segment::drawn_ground::{class_around, road, segmented};

    /// The parameters of the papers to the letter.
    fn printed() -> FrontEndParams {
        let mut params = PaperParams::shipped();
        params.ground.fewer_far_away = false;
        params.ground.tall_over = HeightOver::LevelRoad;
        params.front_end(&HierarchicalParams::shipped())
    }

    /// Level road with `extra` points over the cell around (9.0, 3.0); returns that cell's class.
    fn class_with(extra: &[[f32; 3]]) -> SurfaceClass {
        class_by(&HierarchicalParams::shipped().front_end(), 0.0, extra)
    }

    /// The class of that cell on a road that rises by `rise` over run to the front, with other parameters.
    fn class_by(params: &FrontEndParams, rise: f32, extra: &[[f32; 3]]) -> SurfaceClass {
        let road = road(100).map(|[x, y, z]| [x, y, z + rise * x]);
        class_around(&segmented(params, &road.chain(extra.iter().copied()).collect()), [9.0, 3.0])
    }

    fn column(from_m: f32, to_m: f32) -> Vec<[f32; 3]> {
        (0..=20).map(|step| [9.0, 3.0, from_m + (to_m - from_m) * step as f32 / 20.0]).collect()
    }

    #[test]
    fn a_level_cell_at_the_height_of_the_road_is_ground() {
        assert_eq!(class_with(&[]), SurfaceClass::Ground);
        assert_eq!(class_with(&column(-1.73, -1.50)), SurfaceClass::Ground);
    }

    #[test]
    fn what_rises_more_than_25_cm_is_a_short_object() {
        assert_eq!(class_with(&column(-1.73, -1.45)), SurfaceClass::Short);
        assert_eq!(class_with(&column(-1.73, 0.2)), SurfaceClass::Short);
    }

    #[test]
    fn what_reaches_more_than_310_cm_above_the_road_is_tall() {
        assert_eq!(class_with(&column(-1.73, 1.36)), SurfaceClass::Short);
        assert_eq!(class_with(&column(-1.73, 1.38)), SurfaceClass::Tall);
        // A crown without its trunk.
        assert_eq!(class_with(&column(1.2, 1.6)), SurfaceClass::Tall);
    }

    #[test]
    fn as_printed_a_climbing_road_makes_its_cars_tall() {
        // 0.9 m up, a van of 2.4 m.
        let van = column(0.1 * 9.0 - 1.73, 0.1 * 9.0 - 1.73 + 2.4);
        assert_eq!(class_by(&HierarchicalParams::shipped().front_end(), 0.1, &van), SurfaceClass::Short);
        assert_eq!(class_by(&printed(), 0.1, &van), SurfaceClass::Tall);
        assert_eq!(class_by(&printed(), 0.0, &column(-1.73, 0.67)), SurfaceClass::Short);
    }

    #[test]
    fn as_printed_a_flat_cell_is_ground_if_those_around_it_are() {
        let mut params = HierarchicalParams::shipped().front_end();
        // The boot of a car, and no road below it.
        let boot: Vec<[f32; 3]> = (0..9).map(|it| [8.8 + 0.05 * it as f32, 3.0, -0.9]).collect();
        let hole = |params: &FrontEndParams| class_over_hole(params, &boot);
        assert_eq!(hole(&params), SurfaceClass::Short);
        params.ground.low_itself = false;
        assert_eq!(hole(&params), SurfaceClass::Ground);
        assert_eq!(hole(&printed()), SurfaceClass::Ground);
    }

    #[test]
    fn as_printed_few_points_are_clutter_at_every_range() {
        let far = |params: &FrontEndParams, n_points: usize| class_of_lone_cell(params, n_points, 50.0);
        assert_eq!(far(&printed(), 4), SurfaceClass::Clutter);
        assert_eq!(far(&printed(), 5), SurfaceClass::Short);
    }

    /// The class of the only occupied cell, `x_m` in front of the sensor, with `n_points` one above the other.
    fn class_alone(n_points: usize, x_m: f32, weighted: bool) -> SurfaceClass {
        let mut params = HierarchicalParams::shipped().front_end();
        params.density_weighting.enabled = weighted;
        class_of_lone_cell(&params, n_points, x_m)
    }

    fn class_of_lone_cell(params: &FrontEndParams, n_points: usize, x_m: f32) -> SurfaceClass {
        let mut grid = HierarchicalGrid::new(params.grid.clone());
        grid.fill(&(0..n_points).map(|it| [x_m, 0.1, it as f32 * 0.1 - 1.0]).collect());
        let terrain = Terrain::new(params.terrain.clone(), &grid, 1.73);
        let mut classes = Vec::new();
        ground(params).segment(&grid, &terrain, &mut classes);
        classes[grid.occupied()[0] as usize]
    }

    /// The class of the cell around (9.0, 3.0) of a level road that has these points there and no others.
    fn class_over_hole(params: &FrontEndParams, points_m: &[[f32; 3]]) -> SurfaceClass {
        let column_and_row = |[x, y, _]: [f32; 3]| {
            [x, y].map(|it| ((it + params.grid.extent_m) / params.grid.cell_size_m) as i32)
        };
        let around = road(100).filter(|&it| column_and_row(it) != column_and_row(points_m[0]));
        class_around(&segmented(params, &around.chain(points_m.iter().copied()).collect()), [9.0, 3.0])
    }

    #[test]
    fn few_points_are_clutter_near_the_sensor() {
        assert_eq!(class_alone(3, 5.0, true), SurfaceClass::Clutter);
        assert_eq!(class_alone(4, 5.0, true), SurfaceClass::Short);
    }

    #[test]
    fn far_away_fewer_points_are_enough() {
        assert_eq!(class_alone(1, 50.0, true), SurfaceClass::Short);
        assert_eq!(class_alone(3, 50.0, false), SurfaceClass::Clutter);
        assert_eq!(class_alone(4, 50.0, false), SurfaceClass::Short);
    }
}
