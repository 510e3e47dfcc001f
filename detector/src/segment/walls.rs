//! The walls of a scan, and what finds them.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::portable_math::single;
use crate::segment::hough_lines::Segment;
use crate::segment::terrain::Terrain;
use crate::segment::wall_segments::{Shadow, cell_at, center_m, corridor};
use crate::surface_class::SurfaceClass;

/// Walls, and the cells on them.
#[derive(Debug, Clone)]
pub struct Walls {
    segments: Vec<Segment>,
    shadows: Vec<Shadow>,
    // For every step along every wall with a shadow, one behind the other, whether a cell there or beside it bears the wall.
    borne: Vec<bool>,
    // For every cell the length of the longest wall that it lies on, in metres; those of an earlier scan are in the list.
    length_m: Vec<f32>,
    measured: Vec<u32>,
    taken: Vec<u32>,
}

impl Walls {
    /// None yet, over a grid of so many cells.
    pub fn new(n_cells: usize) -> Self {
        Self {
            segments: Vec::new(),
            shadows: Vec::new(),
            borne: Vec::new(),
            length_m: vec![0.0; n_cells],
            measured: Vec::new(),
            taken: Vec::new(),
        }
    }

    /// Removes all.
    pub fn clear(&mut self) {
        self.segments.clear();
        self.shadows.clear();
        self.borne.clear();
        self.taken.clear();
        for cell_idx in self.measured.drain(..) {
            self.length_m[cell_idx as usize] = 0.0;
        }
    }

    /// Adds a wall that hides nothing.
    pub fn add(&mut self, segment: Segment) {
        self.segments.push(segment);
    }

    /// Adds a wall that hides what is behind the cells of `is_support`.
    pub fn add_with_shadow(&mut self, segment: Segment, grid: &HierarchicalGrid, is_support: &[bool]) {
        self.segments.push(segment);
        self.shadows.push(Shadow::of(segment, grid, is_support, &mut self.borne));
    }

    /// Turns a short cell into a tall one; `None` if it is not short.
    pub fn turn_tall(&mut self, classes: &mut [SurfaceClass], cell_idx: u32) -> Option<u32> {
        let class = &mut classes[cell_idx as usize];
        (*class == SurfaceClass::Short).then(|| {
            *class = SurfaceClass::Tall;
            self.taken.push(cell_idx);
            cell_idx
        })
    }

    /// Records for every cell on a wall the length of the wall.
    pub fn measure(&mut self, grid: &HierarchicalGrid) {
        for &segment in &self.segments {
            let [start_m, end_m] = [segment.start, segment.end].map(|position| center_m(grid, position));
            let length_m = single::hypot(end_m[0] - start_m[0], end_m[1] - start_m[1]);
            for cell_idx in corridor(segment).flatten().filter_map(|it| cell_at(grid, it)) {
                let longest_m = &mut self.length_m[cell_idx as usize];
                *longest_m = longest_m.max(length_m);
                self.measured.push(cell_idx);
            }
        }
    }

    /// The walls.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The cells that were short and became tall.
    pub fn taken(&self) -> &[u32] {
        &self.taken
    }

    /// Whether a wall hides this position of the ground plan from the sensor. The gaps of a wall, where no cell bears it,
    /// hide nothing.
    pub fn hide(&self, position_m: [f32; 2]) -> bool {
        self.shadows.iter().any(|it| it.covers(position_m, &self.borne))
    }

    /// The length of the longest wall on which a cell lies, or beside which, in metres; 0 for other cells.
    pub fn length_m(&self, cell_idx: u32) -> f32 {
        self.length_m[cell_idx as usize]
    }
}

/// The ground of a scan, on which walls stand.
pub struct WallScene<'a> {
    /// The points in cells.
    pub grid: &'a HierarchicalGrid,
    /// The ground below them.
    pub terrain: &'a Terrain,
    /// Whether a cell hangs over the street, as crowns and signs do.
    pub hangs: &'a dyn Fn(u32) -> bool,
}

/// A way to find walls.
pub trait WallFinder: std::fmt::Debug + Send {
    /// Adds the walls of a scan to `walls`, and turns their short cells among `classes` into tall ones.
    fn find(&mut self, scene: &WallScene<'_>, classes: &mut [SurfaceClass], walls: &mut Walls);

    /// Whether the upper end of the field of view of the latest scan cuts off things that reach this height over the sensor
    /// at this range, both in metres. `false` if that end is not known.
    fn is_cut_off(&self, _range_m: f32, _top_m: f32) -> bool {
        false
    }
}
