//! Linkages that join dense cells to groups within groups.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::group::candidates::Candidates;
use crate::group::dense_cells::DenseCells;
use crate::point_cloud::PointCloud;
use crate::segment::terrain::Terrain;

/// Levels at which groups are joined are below this; groups joined at level 0 are never parted.
pub const N_LEVELS: usize = 10;

/// A scan with the results of all stages before its dense cells are filled.
#[derive(Debug, Clone, Copy)]
pub struct LinkedScan<'a> {
    /// All points.
    pub cloud: &'a PointCloud,
    /// Their grid.
    pub grid: &'a HierarchicalGrid,
    /// The ground below them.
    pub terrain: &'a Terrain,
    /// The points that may belong to objects.
    pub candidates: &'a Candidates,
}

/// Which dense cells are one group, and at which level groups are joined.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Links {
    /// For every dense cell the representative of its smallest group.
    pub group_of_dense: Vec<u32>,
    /// By level, representatives of groups that are joined, some pairs more than once.
    pub between: [Vec<[u32; 2]>; N_LEVELS],
}

/// Decides which dense cells are joined.
pub trait Linkage: Send {
    /// The names of the stages [`Self::fill`] and [`Self::link`].
    fn stages(&self) -> [&'static str; 2];

    /// Replaces the content of `dense` by the candidates of `scan`.
    fn fill(&mut self, scan: &LinkedScan<'_>, dense: &mut DenseCells);

    /// Finds the links between the cells of `dense`, which [`Self::fill`] filled.
    fn link(&mut self, scan: &LinkedScan<'_>, dense: &DenseCells);

    /// The links that [`Self::link`] found.
    fn links(&self) -> &Links;

    /// Whether there are groups within groups.
    fn is_nested(&self) -> bool;
}
