//! The dense cells along the edge of each object, and their points.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::segment::dense_level::{DenseLevel, NO_BLOCK};
use crate::segment::dense_separation::NO_OBJECT;
use crate::segment::object_points::ObjectPoint;

/// The outlines of the objects of one scan after another.
///
/// A dense cell is on the outline of its object if it holds enough points, and not all of its eight neighbours belong to the
/// same object. The corners of an object's convex hull lie in such cells.
///
/// Paper: VM section 4, boundary cells.
#[derive(Debug, Clone)]
pub struct Outline {
    xi: usize,
    min_points: u32,
    // For each of the nine blocks around a block: its dense cells that touch that block, and their indices in `around`.
    touching: [Vec<[usize; 2]>; 9],
    // Objects of the dense cells of a block and of those that touch it, row by row.
    around: Vec<u32>,
    is_edge: Vec<bool>,
    // With room for all points of a cluster, so that writing needs no branch.
    points_m: Vec<[f32; 2]>,
    n_points: usize,
}

impl Outline {
    /// No outlines yet; `xi` are the dense cells along the side of a block, of which those with fewer than `min_points`
    /// count as empty.
    pub fn new(xi: u32, min_points: u32) -> Self {
        let side = xi as i32 + 2;
        let mut touching = [const { Vec::new() }; 9];
        for index in 0..side * side {
            let (column, row) = (index % side - 1, index / side - 1);
            let [across, along] = [column, row].map(|step| step.div_euclid(xi as i32) + 1);
            let within = row.rem_euclid(xi as i32) * xi as i32 + column.rem_euclid(xi as i32);
            touching[(3 * along + across) as usize].push([within as usize, index as usize]);
        }
        Self {
            xi: xi as usize,
            min_points,
            touching,
            around: vec![NO_OBJECT; (side * side) as usize],
            is_edge: Vec::new(),
            points_m: Vec::new(),
            n_points: 0,
        }
    }

    /// Finds the outlines of the objects `object_of_dense`, one entry for every dense cell of `dense`.
    pub fn mark(&mut self, grid: &HierarchicalGrid, dense: &DenseLevel, object_of_dense: &[u32]) {
        let n_dense = dense.n_dense_per_block();
        let side = self.xi + 2;
        self.is_edge.clear();
        for &cell_idx in dense.cell_of_block() {
            self.around.fill(NO_OBJECT);
            for (neighbor_idx, touching) in grid.neighborhood(cell_idx).into_iter().zip(&self.touching) {
                let block_idx = dense.block_of_cell(neighbor_idx);
                if block_idx != NO_BLOCK {
                    let objects = &object_of_dense[block_idx as usize * n_dense..][..n_dense];
                    let n_points = dense.n_points_of_block(block_idx);
                    for &[within, index] in touching {
                        let is_empty = n_points[within] < self.min_points;
                        self.around[index] = if is_empty { NO_OBJECT } else { objects[within] };
                    }
                }
            }
            for rows in self.around.windows(3 * side).step_by(side) {
                for column in 0..self.xi {
                    let three = |row: usize| [0, 1, 2].map(|step| rows[row * side + column + step]);
                    let [before, [left, object, right], behind] = [three(0), three(1), three(2)];
                    let is_same = |neighbors: [u32; 3]| neighbors.map(|it| it == object) == [true; 3];
                    let is_inner = is_same(before) & is_same([left, object, right]) & is_same(behind);
                    self.is_edge.push(object != NO_OBJECT && !is_inner);
                }
            }
        }
    }

    /// Gathers the points of an object that lie on its outline, see [`Self::points_m`], and returns the elevations of
    /// its lowest and highest point in metres. `object` are all its points; they are its outline if no cell has enough.
    pub fn gather(&mut self, object: &[ObjectPoint]) -> [f32; 2] {
        self.points_m.resize(self.points_m.len().max(object.len()), [0.0; 2]);
        let (is_edge, points_m) = (&self.is_edge[..], &mut self.points_m[..]);
        let mut n_points = 0;
        let [mut low_m, mut high_m] = [f32::INFINITY, f32::NEG_INFINITY];
        for &ObjectPoint { position_m: [x_m, y_m, z_m], dense_idx } in object {
            low_m = if z_m < low_m { z_m } else { low_m };
            high_m = if z_m > high_m { z_m } else { high_m };
            points_m[n_points] = [x_m, y_m];
            n_points += usize::from(is_edge[dense_idx as usize]);
        }
        if n_points == 0 {
            for (at, &ObjectPoint { position_m: [x_m, y_m, _], .. }) in points_m.iter_mut().zip(object) {
                *at = [x_m, y_m];
            }
            n_points = object.len();
        }
        self.n_points = n_points;
        [low_m, high_m]
    }

    /// The points gathered last, on the ground plan in metres.
    pub fn points_m(&self) -> &[[f32; 2]] {
        &self.points_m[..self.n_points]
    }
}
