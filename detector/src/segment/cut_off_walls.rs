//! Façades that the sensor sees only the lower part of, found as long straight lines of cells.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::portable_math::single;
use crate::segment::hough_lines::{HoughLines, Segment};
use crate::segment::terrain::Terrain;
use crate::segment::wall_params::WallRefinementParams;
use crate::segment::wall_segments::{cell_at, corridor, ground_behind_share, support_share};
use crate::segment::walls::{WallFinder, WallScene, Walls};
use crate::surface_class::SurfaceClass;

/// Finds segments among cells that are tall or cut off.
///
/// Near the sensor no beam reaches the height at which a cell is tall: 3.1 m with the topmost beam at +2° and 1.73 m
/// above the road is 39 m away. A near façade is only known to go on up to the topmost beam: a cell that is tall, or higher
/// than cars and *cut off* by the upper end of the field of view, supports a wall. Segments are found among the supporting
/// cells, so a row of parked cars makes none however straight it is; the short cells on a segment become tall whether they
/// support it or not.
#[derive(Debug)]
pub struct CutOffWalls {
    params: WallRefinementParams,
    lines: HoughLines,
    rises: Vec<f32>,
    // Rise over range from which on the upper end of the field of view cuts a cell off.
    least_cut_off: f32,
    supports: Vec<u32>,
    // For every cell; those of an earlier scan are among `supports`.
    is_support: Vec<bool>,
    // Cells that became tall and whose neighbours are not processed yet.
    front: Vec<u32>,
}

/// Cells nearer than this, in metres, say little about the top of the field of view: their size is too large an angle.
const MIN_RANGE_OF_CEILING_M: f32 = 8.0;

/// The rise of the field of view's upper end is this quantile of the rises of the cells' highest points.
const CEILING_QUANTILE: f32 = 0.99;

/// The upper end of the field of view is known if it cuts off this share of the standing cells beyond
/// [`MIN_RANGE_OF_CEILING_M`], counting only cells higher than cars as cut off.
const LEAST_CUT_OFF_SHARE: f32 = 0.1;

impl CutOffWalls {
    /// Finds walls by `params` over `grid`.
    pub fn new(params: WallRefinementParams, grid: &HierarchicalGrid) -> Self {
        Self {
            lines: HoughLines::new(params.hough.clone(), grid.n_columns()),
            params,
            rises: Vec::new(),
            least_cut_off: f32::INFINITY,
            supports: Vec::new(),
            is_support: vec![false; grid.cells().len()],
            front: Vec::new(),
        }
    }

    /// Turns the cells on a wall, and cells beside it that support it or are seen through its windows, into tall ones.
    fn take(
        &mut self,
        segment: Segment,
        grid: &HierarchicalGrid,
        classes: &mut [SurfaceClass],
        walls: &mut Walls,
    ) {
        for cells in corridor(segment) {
            let [on, sides @ ..] = cells.map(|it| cell_at(grid, it));
            let Some(on) = on else { continue };
            walls.turn_tall(classes, on);
            self.front.push(on);
            for beside in sides.into_iter().flatten() {
                if self.is_support[beside as usize] || range_m(grid, beside) > range_m(grid, on) {
                    self.front.extend(walls.turn_tall(classes, beside));
                }
            }
        }
    }

    /// Extends walls to bays, reliefs and side walls: a cell that supports a wall and touches one is wall.
    fn spread(&mut self, grid: &HierarchicalGrid, classes: &mut [SurfaceClass], walls: &mut Walls) {
        while let Some(cell_idx) = self.front.pop() {
            for neighbor_idx in grid.neighborhood(cell_idx) {
                if self.is_support[neighbor_idx as usize] {
                    self.front.extend(walls.turn_tall(classes, neighbor_idx));
                }
            }
        }
    }

    fn find_supports(&mut self, grid: &HierarchicalGrid, terrain: &Terrain, classes: &[SurfaceClass]) {
        for &cell_idx in &self.supports {
            self.is_support[cell_idx as usize] = false;
        }
        self.supports.clear();
        let standing =
            |cell_idx: u32| matches!(classes[cell_idx as usize], SurfaceClass::Tall | SurfaceClass::Short);
        self.rises.clear();
        for &cell_idx in grid.occupied().iter().filter(|&&it| standing(it)) {
            let range_m = range_m(grid, cell_idx);
            if range_m >= MIN_RANGE_OF_CEILING_M {
                self.rises.push(grid.cells()[cell_idx as usize].z_max_m / range_m);
            }
        }
        if self.rises.is_empty() {
            return;
        }
        let rank = (CEILING_QUANTILE * self.rises.len() as f32) as usize;
        let (_, &mut ceiling, _) = self.rises.select_nth_unstable_by(rank, f32::total_cmp);
        let mut n_cut_off = 0;
        self.least_cut_off =
            single::tan(single::atan2(ceiling, 1.0) - self.params.ceiling_margin_deg.to_radians());
        for &cell_idx in grid.occupied().iter().filter(|&&it| standing(it)) {
            let cell = &grid.cells()[cell_idx as usize];
            let height_m = cell.z_max_m - terrain.elevation_m(grid.column_and_row(cell_idx));
            let tall = classes[cell_idx as usize] == SurfaceClass::Tall;
            let is_cut_off = height_m >= self.params.min_height_m
                && self.is_cut_off(range_m(grid, cell_idx), cell.z_max_m);
            n_cut_off += usize::from(is_cut_off && range_m(grid, cell_idx) >= MIN_RANGE_OF_CEILING_M);
            if tall || is_cut_off {
                self.supports.push(cell_idx);
                self.is_support[cell_idx as usize] = true;
            }
        }
        if (n_cut_off as f32) < LEAST_CUT_OFF_SHARE * self.rises.len() as f32 {
            // Too little is seen up there: the cells that are highest for their range may well end there.
            self.least_cut_off = f32::INFINITY;
        }
    }
}

impl WallFinder for CutOffWalls {
    fn find(&mut self, scene: &WallScene<'_>, classes: &mut [SurfaceClass], walls: &mut Walls) {
        let WallScene { grid, terrain, .. } = *scene;
        self.least_cut_off = f32::INFINITY;
        self.find_supports(grid, terrain, classes);
        let Self { params, lines, supports, is_support, .. } = self;
        for &segment in lines.find(supports) {
            let stands = |it: u32| is_support[it as usize] && !(scene.hangs)(it);
            if support_share(segment, grid, |it| is_support[it as usize]) >= params.min_support
                && support_share(segment, grid, stands) >= params.min_standing
                && ground_behind_share(segment, grid, classes) <= params.max_ground_behind
            {
                walls.add_with_shadow(segment, grid, is_support);
            }
        }
        self.front.clear();
        for number in 0..walls.segments().len() {
            self.take(walls.segments()[number], grid, classes, walls);
        }
        self.spread(grid, classes, walls);
        walls.measure(grid);
    }

    fn is_cut_off(&self, range_m: f32, top_m: f32) -> bool {
        top_m >= self.least_cut_off * range_m
    }
}

fn range_m(grid: &HierarchicalGrid, cell_idx: u32) -> f32 {
    let [x, y] = grid.center_m(cell_idx);
    single::hypot(x, y)
}
