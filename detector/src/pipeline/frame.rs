//! The frame that the stages of a detector hand on to each other.

use crate::drawn::surfaces::class_by_cell;
use crate::fit::fitted_objects::FittedObjects;
use crate::grid::density_weighting::DensityWeighting;
use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::group::candidates::Candidates;
use crate::group::dense_cells::DenseCells;
use crate::group::dense_gaps::DenseGaps;
use crate::group::grouping_tree::GroupingTree;
use crate::group::linkage::Linkage;
use crate::group::low_iou_groups::LowIouGroups;
use crate::group::node_points::NodePoints;
use crate::group::node_values::NodeDescriber;
use crate::oriented_box::OrientedBox;
use crate::params::HierarchicalParams;
use crate::params::front_end::FrontEndParams;
use crate::point_cloud::PointCloud;
use crate::segment::clusters::Clusters;
use crate::segment::dense_level::DenseLevel;
use crate::segment::foreground::{Foreground, ForegroundParams};
use crate::segment::ground_points::ground_points;
use crate::segment::object_points::ObjectPoints;
use crate::segment::terrain::Terrain;
use crate::segment::wall_refinement::WallRefinement;
use crate::surface_class::SurfaceClass;

/// The results of stages on one scan after another, in the order in which they are found, in reusable buffers. `C` is what a
/// kind of detector finds between the ground and objects.
///
/// Results that a detector has no stage for stay as they were made.
pub struct Frame<C> {
    /// The points in cells.
    pub grid: HierarchicalGrid,
    /// The ground below them.
    pub terrain: Terrain,
    /// The class of every cell of the grid; empty cells are unseen. There is none if no stage looks for the ground.
    pub classes: Vec<SurfaceClass>,
    /// The walls.
    pub walls: WallRefinement,
    /// How the points over the ground are told from it.
    pub foreground_params: ForegroundParams,
    /// The points that may belong to objects, and how they belong together.
    pub clustering: C,
    /// Objects with their boxes, the values that models look at, and the decisions of models.
    pub fitted: FittedObjects,
}

/// Objects made of cells, of the foreground.
pub struct Blobs {
    /// The points that may belong to objects.
    pub foreground: Foreground,
    /// The dense cells below them.
    pub dense: DenseLevel,
    /// Neighbouring blocks of dense cells that belong to the same blob, each pair once, ascending.
    pub links: Vec<[u32; 2]>,
    /// The object of every dense cell.
    pub object_of_dense: Vec<u32>,
    /// The points of these objects.
    pub object_points: ObjectPoints,
}

impl Blobs {
    /// None yet.
    pub fn new(params: &FrontEndParams) -> Self {
        Self {
            foreground: Foreground::new(params.foreground.clone()),
            dense: DenseLevel::default(),
            links: Vec::new(),
            object_of_dense: Vec::new(),
            object_points: ObjectPoints::default(),
        }
    }
}

/// Objects made of points, of the foreground.
pub struct PointClusters {
    /// The points that may belong to objects.
    pub foreground: Foreground,
    /// The indices of foreground points in their list, cluster by cluster.
    pub clusters: Clusters,
}

impl PointClusters {
    /// None yet.
    pub fn new(params: &FrontEndParams) -> Self {
        Self { foreground: Foreground::new(params.foreground.clone()), clusters: Clusters::default() }
    }
}

impl AsRef<Foreground> for Blobs {
    fn as_ref(&self) -> &Foreground {
        &self.foreground
    }
}

impl AsMut<Foreground> for Blobs {
    fn as_mut(&mut self) -> &mut Foreground {
        &mut self.foreground
    }
}

impl AsRef<Foreground> for PointClusters {
    fn as_ref(&self) -> &Foreground {
        &self.foreground
    }
}

impl AsMut<Foreground> for PointClusters {
    fn as_mut(&mut self) -> &mut Foreground {
        &mut self.foreground
    }
}

/// Where nothing is clustered.
impl AsRef<Self> for Foreground {
    fn as_ref(&self) -> &Self {
        self
    }
}

impl AsMut<Self> for Foreground {
    fn as_mut(&mut self) -> &mut Self {
        self
    }
}

/// Groups within groups.
pub struct Groups {
    /// The points that are grouped, instead of a foreground.
    pub candidates: Candidates,
    /// Their dense cells.
    pub dense: DenseCells,
    /// The linkage that joins these.
    pub linkage: Box<dyn Linkage>,
    /// All groupings.
    pub tree: GroupingTree,
    /// The groups that may be objects by their size.
    pub describer: NodeDescriber,
    /// Those that are taken for objects, or for vehicles if a model says so: nodes of the tree, ascending, of which none
    /// holds another.
    pub taken: Vec<u32>,
    /// Which of them are taken only if a model classifies them as vehicles.
    pub low_iou: LowIouGroups,
    /// The points of the taken groups.
    pub points: NodePoints,
}

impl Groups {
    /// None yet; gaps between cells will separate them.
    pub fn by_gaps(params: &HierarchicalParams) -> Self {
        let weighting = DensityWeighting::new(&params.density_weighting);
        Self::over(Box::new(DenseGaps::new(params.grouping.gaps.clone(), &params.grid, &weighting)), params)
    }

    /// None yet; `linkage` will join them.
    pub fn over(linkage: Box<dyn Linkage>, params: &HierarchicalParams) -> Self {
        let candidates = params.grouping.candidates.clone();
        let tall_height_m = params.ground.tall_height_m;
        Self {
            candidates: Candidates::new(candidates, params.foreground.clone(), tall_height_m),
            dense: DenseCells::default(),
            linkage,
            tree: GroupingTree::default(),
            describer: NodeDescriber::default(),
            taken: Vec::new(),
            low_iou: LowIouGroups::default(),
            points: NodePoints::default(),
        }
    }
}

impl<C> Frame<C> {
    /// A frame for a sensor `sensor_height_m` above the road.
    pub fn new(clustering: C, params: &FrontEndParams, sensor_height_m: f32) -> Self {
        let grid = HierarchicalGrid::new(params.grid.clone());
        Self {
            terrain: Terrain::new(params.terrain.clone(), &grid, sensor_height_m),
            classes: Vec::new(),
            walls: WallRefinement::new(params.walls.clone(), &grid),
            foreground_params: params.foreground.clone(),
            clustering,
            fitted: FittedObjects::default(),
            grid,
        }
    }

    /// Elevation of the ground below the middle of a box, in metres.
    pub fn ground_below_m(&self, bounding_box: &OrientedBox) -> f32 {
        let [x_m, y_m, _] = bounding_box.center_m;
        self.terrain.elevation_m(self.grid.nearest_column_and_row([x_m, y_m]))
    }

    /// The class of every cell: [`SurfaceClass::Wall`] for tall cells that a wall has taken.
    pub fn cell_classes(&self) -> Vec<SurfaceClass> {
        let mut classes = self.classes.clone();
        for &cell_idx in self.walls.taken() {
            classes[cell_idx as usize] = SurfaceClass::Wall;
        }
        classes
    }

    /// Whether each point of `cloud`, the latest scan, is ground; `None` if no stage looks for the ground.
    pub fn ground_points(&self, cloud: &PointCloud) -> Option<Vec<bool>> {
        let Self { grid, classes, terrain, foreground_params, .. } = self;
        (!classes.is_empty()).then(|| ground_points(cloud, grid, classes, terrain, foreground_params))
    }
}

impl<C: AsRef<Foreground>> Frame<C> {
    /// The class of every point: that of its cell, except that points of short cells that lie below the foreground are
    /// ground.
    pub fn point_classes(&self) -> Vec<SurfaceClass> {
        let of_cells = self.cell_classes();
        let mut classes = class_by_cell(&self.grid, |cell_idx| match of_cells[cell_idx as usize] {
            SurfaceClass::Short => SurfaceClass::Ground,
            class => class,
        });
        for &point_idx in self.clustering.as_ref().point_indices() {
            classes[point_idx as usize] = SurfaceClass::Short;
        }
        classes
    }
}
