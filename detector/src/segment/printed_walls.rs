//! Walls as the paper prints them.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::segment::hough_lines::{HoughLines, HoughParams};
use crate::segment::wall_segments::{cell_at, corridor, support_share};
use crate::segment::walls::{WallFinder, WallScene, Walls};
use crate::surface_class::SurfaceClass;

/// Finds segments among all tall and short cells. The paper takes each for a wall, a row of parked cars, too; here enough of
/// its cells have to be tall.
///
/// Paper: HG section 3.1, refinement by a probabilistic Hough transform, and Fig. 3.
#[derive(Debug)]
pub struct PrintedWalls {
    min_support: f32,
    beside: bool,
    lines: HoughLines,
    standing: Vec<u32>,
    // For every cell; those of an earlier scan are among `standing`.
    is_tall: Vec<bool>,
}

impl PrintedWalls {
    /// Walls along `min_support` of which cells are tall. With `beside` the cells beside a wall become tall, too.
    pub fn new(hough: HoughParams, min_support: f32, beside: bool, grid: &HierarchicalGrid) -> Self {
        let lines = HoughLines::new(hough, grid.n_columns());
        Self { min_support, beside, lines, standing: Vec::new(), is_tall: vec![false; grid.cells().len()] }
    }
}

impl WallFinder for PrintedWalls {
    fn find(&mut self, scene: &WallScene<'_>, classes: &mut [SurfaceClass], walls: &mut Walls) {
        let grid = scene.grid;
        for cell_idx in self.standing.drain(..) {
            self.is_tall[cell_idx as usize] = false;
        }
        for &cell_idx in grid.occupied() {
            let class = classes[cell_idx as usize];
            if matches!(class, SurfaceClass::Tall | SurfaceClass::Short) {
                self.standing.push(cell_idx);
                self.is_tall[cell_idx as usize] = class == SurfaceClass::Tall;
            }
        }
        // All are judged first, so that their order does not matter.
        for &segment in self.lines.find(&self.standing) {
            if support_share(segment, grid, |it| self.is_tall[it as usize]) >= self.min_support {
                walls.add(segment);
            }
        }
        let n_across = if self.beside { 3 } else { 1 };
        for number in 0..walls.segments().len() {
            let cells = corridor(walls.segments()[number]).flat_map(|it| it.into_iter().take(n_across));
            for cell_idx in cells.filter_map(|it| cell_at(grid, it)) {
                walls.turn_tall(classes, cell_idx);
            }
        }
        walls.measure(grid);
    }
}
