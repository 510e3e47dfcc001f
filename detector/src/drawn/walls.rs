//! The walls that were taken out of the foreground.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::segment::hough_lines::Segment;
use crate::segment::terrain::Terrain;
use crate::stage_product::Shape;

/// `walls`, whose ends are columns and rows of `grid`, from end to end and `above_ground_m` above `terrain`.
pub fn wall_segments(
    grid: &HierarchicalGrid,
    terrain: &Terrain,
    walls: &[Segment],
    above_ground_m: f32,
) -> Shape {
    let position_m = |[column, row]: [i32; 2]| {
        let cell_idx = row as u32 * grid.n_columns() + column as u32;
        let [x_m, y_m] = grid.center_m(cell_idx);
        [x_m, y_m, terrain.elevation_m(grid.column_and_row(cell_idx)) + above_ground_m]
    };
    Shape::Segments(walls.iter().map(|it| [it.start, it.end].map(position_m)).collect())
}
