//! The boxes, cells and walls of the nodes of a tree.

use std::ops::Range;

use crate::describe::surroundings::ObjectRaster;
use crate::fit::convex_hull_box::ConvexHullBox;
use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::group::candidates::{Candidates, Evidence, N_EVIDENCE};
use crate::group::dense_cells::{CellStatistics, DenseCells};
use crate::group::grouping_tree::{GroupingTree, Node};
use crate::oriented_box::OrientedBox;
use crate::portable_math::single;
use crate::segment::terrain::Terrain;
use crate::segment::wall_refinement::WallRefinement;
use crate::surface_class::SurfaceClass;

/// Wholes larger than this are large, in metres.
pub(super) const LARGEST_WHOLE_M: f32 = 30.0;

/// The scan that the nodes lie in.
#[derive(Debug, Clone, Copy)]
pub struct NodeScene<'a> {
    /// The grid.
    pub grid: &'a HierarchicalGrid,
    /// The ground.
    pub terrain: &'a Terrain,
    /// The points.
    pub candidates: &'a Candidates,
    /// Their cells.
    pub dense: &'a DenseCells,
    /// Raster of the points around groups; `None` if groups are described without them.
    pub raster: Option<&'a ObjectRaster>,
    /// The class of each cell of the grid.
    pub classes: &'a [SurfaceClass],
    /// The walls.
    pub walls: &'a WallRefinement,
    /// Number of points of the scan.
    pub n_points: usize,
}

/// Shape of a node, found before the node is described.
#[derive(Debug, Clone, Default)]
pub(super) struct Shape {
    // Empty if the node is too large.
    pub(super) hull: Range<usize>,
    pub(super) bounding_box: Option<OrientedBox>,
    // Number of cells, and numbers of points of cells with each [`Evidence`].
    pub(super) n_cells: u32,
    pub(super) n_with_evidence: [u32; N_EVIDENCE],
    // The length of the longest wall that one of its cells lies on.
    pub(super) wall_length_m: f32,
}

/// Shapes of all nodes of a tree, found before the nodes are described.
#[derive(Debug, Clone, Default)]
pub(super) struct NodeShapes {
    box_fit: ConvexHullBox,
    order: Vec<u32>,
    outline_m: Vec<[f32; 2]>,
    hulls_m: Vec<[f32; 2]>,
    shapes: Vec<Shape>,
}

impl NodeShapes {
    /// The shape of one node.
    pub(super) fn of_node(&self, node_idx: u32) -> &Shape {
        &self.shapes[node_idx as usize]
    }

    /// Finds the shapes of all nodes of `tree`. Nodes longer across than `most_m` get no outline, and nodes of fewer than
    /// `min_points` get no box.
    pub(super) fn find(
        &mut self,
        tree: &GroupingTree,
        scene: &NodeScene<'_>,
        most_m: f32,
        min_points: usize,
    ) {
        self.shapes.clear();
        self.shapes.resize(tree.nodes().len(), Shape::default());
        self.hulls_m.clear();
        tree.upward(&mut self.order);
        for &node_idx in &self.order {
            let node = &tree.nodes()[node_idx as usize];
            let mut shape = self.sums(tree, node, scene);
            let [across_m, along_m] =
                [0, 1].map(|axis| node.statistics.high_m[axis] - node.statistics.low_m[axis]);
            if single::hypot(across_m, along_m) <= most_m {
                self.outline_m.clear();
                match node.first_child {
                    None => {
                        let statistics =
                            tree.cells(node).iter().map(|&it| &scene.dense.statistics()[it as usize]);
                        self.outline_m.extend(statistics.flat_map(CellStatistics::corners_m));
                    }
                    Some(_) => {
                        for part in tree.parts_of(node) {
                            self.outline_m
                                .extend_from_slice(&self.hulls_m[self.shapes[part as usize].hull.clone()]);
                        }
                    }
                }
                let start = self.hulls_m.len();
                if node.statistics.n_points as usize >= min_points {
                    let outline_m = self.outline_m.iter().copied();
                    shape.bounding_box = self.box_fit.fit(outline_m, node.statistics.z_range_m);
                    self.hulls_m.extend_from_slice(self.box_fit.hull_m());
                } else {
                    // It has no box. Its whole takes all of its outline over.
                    self.hulls_m.extend_from_slice(&self.outline_m);
                }
                shape.hull = start..self.hulls_m.len();
            }
            self.shapes[node_idx as usize] = shape;
        }
    }

    fn sums(&self, tree: &GroupingTree, node: &Node, scene: &NodeScene<'_>) -> Shape {
        let mut shape = Shape::default();
        if node.first_child.is_some() {
            for part in tree.parts_of(node) {
                let part = &self.shapes[part as usize];
                shape.n_cells += part.n_cells;
                shape.wall_length_m = shape.wall_length_m.max(part.wall_length_m);
                for (sum, n) in shape.n_with_evidence.iter_mut().zip(part.n_with_evidence) {
                    *sum += n;
                }
            }
            return shape;
        }
        for &dense_idx in tree.cells(node) {
            let cell_idx = scene.dense.cell_of_block()[scene.dense.block_of_dense(dense_idx)];
            let against = scene.candidates.evidence_against(cell_idx);
            let n_points = scene.dense.statistics()[dense_idx as usize].n_points;
            shape.n_cells += 1;
            shape.wall_length_m = shape.wall_length_m.max(scene.walls.length_of_wall_m(cell_idx));
            for (sum, evidence) in shape.n_with_evidence.iter_mut().zip(Evidence::ALL) {
                *sum += if against.has(evidence) { n_points } else { 0 };
            }
        }
        shape
    }
}
