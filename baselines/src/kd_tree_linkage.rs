//! Components over a kd-tree, as the groups that trained trees judge.

use detector::group::dense_cells::DenseCells;
use detector::group::linkage::{Linkage, LinkedScan, Links, N_LEVELS};

use crate::COMPONENTS;
use crate::nested_components::NestedComponents;

/// The stage that finds which components merge at greater tolerances.
pub const NESTING: &str = "nesting";

/// The tolerances of components within components, in metres.
pub const NESTED_TOLERANCES_M: [f32; N_LEVELS] = [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2];

/// Joins candidates that chains of neighbours over a kd-tree connect: at one tolerance, or at several, the smallest first.
/// The components are exactly those of a kd-tree, but found in cells, so that these rivals are no slower than need be.
///
/// Dense cells only describe the components: over a position where there are several, each has a cell of its own.
#[derive(Debug, Clone)]
pub struct KdTreeLinkage {
    // Ascending, and at most [`N_LEVELS`].
    tolerances_m: Vec<f32>,
    positions_m: Vec<[f32; 3]>,
    components: NestedComponents,
    // The components at the first tolerance, by the smallest index of their points.
    labels: Vec<u32>,
    // For every label, the first cell of its component.
    dense_of_label: Vec<u32>,
    links: Links,
}

impl KdTreeLinkage {
    /// Components at one tolerance.
    pub fn at(tolerance_m: f32) -> Self {
        Self::of(vec![tolerance_m])
    }

    /// Components within components, at [`NESTED_TOLERANCES_M`].
    pub fn nested() -> Self {
        Self::of(NESTED_TOLERANCES_M.to_vec())
    }

    fn of(tolerances_m: Vec<f32>) -> Self {
        Self {
            tolerances_m,
            positions_m: Vec::new(),
            components: NestedComponents::default(),
            labels: Vec::new(),
            dense_of_label: Vec::new(),
            links: Links::default(),
        }
    }
}

const NO_CELL: u32 = u32::MAX;

impl Linkage for KdTreeLinkage {
    fn stages(&self) -> [&'static str; 2] {
        [COMPONENTS, NESTING]
    }

    fn fill(&mut self, scan: &LinkedScan<'_>, dense: &mut DenseCells) {
        let point_indices = scan.candidates.point_indices().iter();
        self.positions_m.clear();
        self.positions_m.extend(point_indices.map(|&it| scan.cloud.position_m(it as usize)));
        let Self { positions_m, components, labels, .. } = self;
        components.reset(positions_m.len());
        components.join(positions_m, self.tolerances_m[0], |_, _| ());
        components.write_labels(positions_m.len(), labels);
        dense.fill_apart(scan.cloud, scan.grid, scan.terrain, scan.candidates, &self.labels);
    }

    fn link(&mut self, _: &LinkedScan<'_>, dense: &DenseCells) {
        let Self { positions_m, components, labels, dense_of_label, links, .. } = self;
        let Links { group_of_dense, between } = links;
        dense_of_label.clear();
        dense_of_label.resize(labels.len(), NO_CELL);
        group_of_dense.clear();
        group_of_dense.extend(0..dense.statistics().len() as u32);
        for (&label, &dense_idx) in labels.iter().zip(dense.dense_of_point()) {
            let first = &mut dense_of_label[label as usize];
            if *first == NO_CELL {
                *first = dense_idx;
            }
            group_of_dense[dense_idx as usize] = *first;
        }
        between.iter_mut().for_each(Vec::clear);
        for (&tolerance_m, between) in self.tolerances_m.iter().zip(between).skip(1) {
            components.join(positions_m, tolerance_m, |a, b| {
                between.push([a, b].map(|label| dense_of_label[label as usize]));
            });
        }
    }

    fn links(&self) -> &Links {
        &self.links
    }

    fn is_nested(&self) -> bool {
        self.tolerances_m.len() > 1
    }
}
