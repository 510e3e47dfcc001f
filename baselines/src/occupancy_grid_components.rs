//! Occupied cells of an occupancy grid, and which of them belong together.

use detector::grid::hierarchical_grid::{HierarchicalGrid, NO_CELL};
use detector::segment::disjoint_sets::DisjointSets;
use serde::Deserialize;

/// Which cells are occupied.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OccupancyParams {
    /// Height difference between the points of an occupied cell above which something stands there, in metres.
    pub min_height_difference_m: f32,
    /// Fewest points of an occupied cell.
    pub min_points: u32,
}

/// The occupied cells of `grid`, ascending: those with enough points and a height difference between them.
///
/// Occupancy by height difference is that of Himmelsbach et al. 2008, the paper's reference 5; the paper states
/// neither cell size nor thresholds, and the minimum of points is ours. Without a terrain it needs no sensor height
/// and follows any slope, but what hangs over the road counts as standing on it, a flat bonnet at the right height
/// does not count at all, and the road at an object's feet goes with the object.
///
/// Paper: VM section 6, "a simple occupancy grid representation for foreground separation".
pub fn occupied_cells(grid: &HierarchicalGrid, params: &OccupancyParams) -> impl Iterator<Item = u32> {
    grid.occupied().iter().copied().filter(|&cell_idx| {
        let cell = &grid.cells()[cell_idx as usize];
        cell.n_points >= params.min_points && cell.z_extent_m() > params.min_height_difference_m
    })
}

/// The components of the occupied cells of one scan after another.
#[derive(Debug, Clone, Default)]
pub struct OccupancyGridComponents {
    occupied: Vec<u32>,
    // Index in `occupied` of every cell of the grid.
    index_of_cell: Vec<u32>,
    components: DisjointSets,
    // Ascending; the second has one entry for each of the first.
    point_indices: Vec<u32>,
    component_of_point: Vec<u32>,
}

/// Marks cells that are not occupied.
const NO_INDEX: u32 = u32::MAX;

impl OccupancyGridComponents {
    /// Connects `occupied` cells of `grid`, ascending, that share a side or a corner, and hands the points above them to
    /// their components.
    pub fn connect(&mut self, grid: &HierarchicalGrid, occupied: &[u32]) {
        for &cell_idx in &self.occupied {
            self.index_of_cell[cell_idx as usize] = NO_INDEX;
        }
        self.index_of_cell.resize(grid.cells().len(), NO_INDEX);
        self.occupied.clear();
        self.occupied.extend_from_slice(occupied);
        for (index, &cell_idx) in (0..).zip(occupied) {
            self.index_of_cell[cell_idx as usize] = index;
        }
        self.components.reset(occupied.len());
        let n = grid.n_columns();
        for (index, &cell_idx) in (0..).zip(occupied) {
            // The other four neighbours see this pair from their side.
            for neighbor_idx in [cell_idx + 1, cell_idx + n - 1, cell_idx + n, cell_idx + n + 1] {
                let neighbor = self.index_of_cell[neighbor_idx as usize];
                if neighbor != NO_INDEX {
                    self.components.join(index, neighbor);
                }
            }
        }
        self.point_indices.clear();
        self.component_of_point.clear();
        for (point_idx, &cell_idx) in (0..).zip(grid.cell_of_point()) {
            let index = if cell_idx == NO_CELL { NO_INDEX } else { self.index_of_cell[cell_idx as usize] };
            if index != NO_INDEX {
                self.point_indices.push(point_idx);
                self.component_of_point.push(self.components.representative(index));
            }
        }
    }

    /// Indices of the points above occupied cells, ascending.
    pub fn point_indices(&self) -> &[u32] {
        &self.point_indices
    }

    /// For each of [`Self::point_indices`] a number below the number of occupied cells, equal for points of the same
    /// component.
    pub fn component_of_point(&self) -> &[u32] {
        &self.component_of_point
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use detector::grid::hierarchical_grid::GridParams;

    const CELL_SIZE_M: f32 = 0.3;

    fn params() -> OccupancyParams {
        OccupancyParams { min_height_difference_m: 0.25, min_points: 2 }
    }

    fn grid() -> HierarchicalGrid {
        HierarchicalGrid::new(GridParams { cell_size_m: CELL_SIZE_M, xi: 1, extent_m: 3.0 })
    }

    /// The points of a drawing: `#` stands 1 m high, `.` is flat road, `,` a single point, `-` is a kerb of 0.1 m.
    fn positions_m(drawing: &str) -> Vec<[f32; 3]> {
        let rows = (0_u16..).zip(drawing.lines());
        let cells = rows.flat_map(|(row, line)| {
            (0_u16..).zip(line.chars()).map(move |(column, drawn)| ([column, row], drawn))
        });
        let points = cells.flat_map(|([column, row], drawn)| {
            let [x_m, y_m] = [column, row].map(|step| (f32::from(step) + 0.5) * CELL_SIZE_M - 3.0);
            let heights_m: &[f32] = match drawn {
                '#' => &[0.0, 0.5, 1.0],
                '.' => &[0.0, 0.02],
                ',' => &[0.8],
                '-' => &[0.0, 0.1],
                _ => &[],
            };
            heights_m.iter().map(move |&height_m| [x_m, y_m, height_m - 1.73])
        });
        points.collect()
    }

    /// Numbers of points of the components, in the order of their first points.
    fn sizes_after(components: &mut OccupancyGridComponents, drawing: &str) -> Vec<usize> {
        let mut grid = grid();
        grid.fill(&positions_m(drawing).into_iter().collect());
        let occupied: Vec<u32> = occupied_cells(&grid, &params()).collect();
        components.connect(&grid, &occupied);
        let mut found: Vec<(u32, usize)> = Vec::new();
        for &component in components.component_of_point() {
            match found.iter_mut().find(|(it, _)| *it == component) {
                Some((_, n_points)) => *n_points += 1,
                None => found.push((component, 1)),
            }
        }
        found.into_iter().map(|(_, n_points)| n_points).collect()
    }

    #[track_caller]
    fn check(drawing: &str, expected_sizes: &[usize]) {
        let sizes = sizes_after(&mut OccupancyGridComponents::default(), drawing);
        assert_eq!(sizes, expected_sizes, "\n{drawing}");
    }

    #[test]
    fn nothing_stands_in_an_empty_scan() {
        check("", &[]);
    }

    #[test]
    fn roads_kerbs_and_single_points_are_not_occupied() {
        check("..-,\n.--.\n,...", &[]);
    }

    #[test]
    fn cells_that_touch_at_a_corner_are_one_component() {
        check("#...\n.#..\n..#.", &[9]);
        check("..#.\n.#..\n#...", &[9]);
    }

    #[test]
    fn one_empty_column_separates() {
        check("##.#\n##.#", &[12, 6]);
    }

    #[test]
    fn arms_that_meet_below_are_one_component() {
        check("#.#.#\n#.#.#\n#####", &[33]);
    }

    #[test]
    fn the_first_and_the_last_cell_of_neighboring_rows_do_not_touch() {
        check("...................#\n#...................", &[3, 3]);
    }

    #[test]
    fn a_second_scan_forgets_the_first() {
        let mut components = OccupancyGridComponents::default();
        sizes_after(&mut components, "###\n###");
        assert_eq!(sizes_after(&mut components, "#..\n..#"), [3, 3]);
    }

    #[test]
    fn points_that_are_not_finite_or_outside_belong_to_no_component() {
        let mut grid = grid();
        let outside = [[9.0, 0.0, 0.0], [9.0, 0.0, 1.0], [f32::NAN, 0.0, 0.0], [0.0, 0.0, f32::INFINITY]];
        grid.fill(&[positions_m("#").as_slice(), &outside].concat().into_iter().collect());
        let mut components = OccupancyGridComponents::default();
        let occupied: Vec<u32> = occupied_cells(&grid, &params()).collect();
        components.connect(&grid, &occupied);
        assert_eq!(components.point_indices(), [0, 1, 2]);
    }
}
