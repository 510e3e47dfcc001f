//! What joins dense cells to groups within groups.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::group::candidates::Candidates;
use crate::group::dense_cells::DenseCells;
use crate::point_cloud::PointCloud;
use crate::segment::terrain::Terrain;

/// Levels at which groups are joined are below this; what is joined at level 0 is never parted.
pub const N_LEVELS: usize = 10;

/// What a scan is made of before its dense cells are filled.
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

/// Tells which dense cells are one group, and at which level groups are joined.
pub trait Linkage: Send {
    /// The names of the stages [`Self::fill`] and [`Self::link`].
    fn stages(&self) -> [&'static str; 2];

    /// Replaces the content of `dense` by the candidates of `scan`.
    fn fill(&mut self, scan: &LinkedScan<'_>, dense: &mut DenseCells);

    /// Finds what joins the cells of `dense`, which [`Self::fill`] filled.
    fn link(&mut self, scan: &LinkedScan<'_>, dense: &DenseCells);

    /// For every dense cell the representative of its smallest group.
    fn group_of_dense(&self) -> &[u32];

    /// Representatives of groups that are joined at `level`, some pairs more than once.
    fn between(&self, level: u8) -> &[[u32; 2]];

    /// Whether there are groups within groups.
    fn is_nested(&self) -> bool;
}
