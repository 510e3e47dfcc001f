//! The points that may belong to objects, with the evidence against it.

use serde::Deserialize;

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::point_cloud::PointCloud;
use crate::portable_math::single;
use crate::segment::foreground::ForegroundParams;
use crate::segment::terrain::Terrain;
use crate::segment::wall_refinement::WallRefinement;
use crate::surface_class::SurfaceClass;

/// Tuning of [`Candidates::find`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CandidatesParams {
    /// Least clearance between things that stand on the ground and things that hang over them, in metres.
    pub min_clearance_m: f32,
    /// Clearance that is added for each metre of range, in metres.
    pub clearance_per_m: f32,
    /// Things whose foot is higher than this above the terrain hang, in metres.
    pub highest_foot_m: f32,
    /// Things whose top is higher than this above the terrain are no candidates, in metres: higher than trucks.
    pub highest_top_m: f32,
}

/// Evidence that the points of a cell are not those of an object of the street.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Evidence {
    /// It lies on a wall.
    OnWall,
    /// A wall hides it: it is seen through a window, or the wall is none.
    BehindWall,
    /// It reaches higher than short objects.
    Tall,
    /// Something hangs over it.
    Covered,
    /// A cell beside it is no candidate since it is too tall.
    BesideTall,
    /// The upper end of the field of view cuts it off.
    CutOff,
}

/// Number of kinds of evidence.
pub const N_EVIDENCE: usize = 6;

/// All evidence against the points of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EvidenceAgainst(u8);

impl Evidence {
    /// All kinds, in the order of the values of groups.
    pub const ALL: [Self; N_EVIDENCE] =
        [Self::OnWall, Self::BehindWall, Self::Tall, Self::Covered, Self::BesideTall, Self::CutOff];
}

impl EvidenceAgainst {
    /// No evidence.
    pub const NONE: Self = Self(0);

    /// Whether `evidence` is among it.
    pub fn has(self, evidence: Evidence) -> bool {
        self.0 & (1 << evidence as u8) != 0
    }

    fn add(&mut self, evidence: Evidence, holds: bool) {
        self.0 |= u8::from(holds) << evidence as u8;
    }
}

/// The points of things that stand on the ground.
///
/// Walls exclude no point here: their points are candidates, and [`Self::evidence_against`] says where they lie.
#[derive(Debug, Clone)]
pub struct Candidates {
    params: CandidatesParams,
    foreground: ForegroundParams,
    tall_height_m: f32,
    // For every cell, of an earlier scan for those that are not occupied.
    band_m: Vec<[f32; 2]>,
    evidence_against: Vec<EvidenceAgainst>,
    // Whether all of a cell hangs over the street, but for its ground.
    hangs: Vec<bool>,
    // For every cell, the index of its column of heights.
    column_of_cell: Vec<u32>,
    // Where in steps of [`STEP_M`] above the terrain there are points, for every cell that is looked into.
    heights: Vec<u64>,
    looked_into: Vec<u32>,
    // The terrain below each of these cells, in metres.
    terrain_m: Vec<f32>,
    cells: Vec<u32>,
    tops_m: Vec<f32>,
    point_indices: Vec<u32>,
    n_points: usize,
}

const STEP_M: f32 = 0.1;
const NOT_LOOKED_INTO: u32 = u32::MAX;
const NOWHERE_M: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

impl Candidates {
    /// No points yet; cells are tall that reach higher above the ground than `tall_height_m`.
    pub fn new(params: CandidatesParams, foreground: ForegroundParams, tall_height_m: f32) -> Self {
        Self {
            params,
            foreground,
            tall_height_m,
            band_m: Vec::new(),
            evidence_against: Vec::new(),
            hangs: Vec::new(),
            column_of_cell: Vec::new(),
            heights: Vec::new(),
            looked_into: Vec::new(),
            terrain_m: Vec::new(),
            cells: Vec::new(),
            tops_m: Vec::new(),
            point_indices: Vec::new(),
            n_points: 0,
        }
    }

    /// Looks into the tall cells. `classes` are those before walls were found; a tall cell becomes a short one if its
    /// standing part is no taller than short objects, or hangs over the ground.
    pub fn find_hanging(
        &mut self,
        cloud: &PointCloud,
        grid: &HierarchicalGrid,
        terrain: &Terrain,
        classes: &mut [SurfaceClass],
    ) {
        self.band_m.resize(classes.len(), NOWHERE_M);
        self.evidence_against.resize(classes.len(), EvidenceAgainst::NONE);
        self.hangs.resize(classes.len(), false);
        self.column_of_cell.resize(classes.len(), NOT_LOOKED_INTO);
        self.heights.clear();
        self.looked_into.clear();
        self.terrain_m.clear();
        for &cell_idx in grid.occupied() {
            self.evidence_against[cell_idx as usize] = EvidenceAgainst::NONE;
            self.hangs[cell_idx as usize] = false;
            self.band_m[cell_idx as usize] = NOWHERE_M;
            match classes[cell_idx as usize] {
                SurfaceClass::Tall => {
                    self.column_of_cell[cell_idx as usize] = self.looked_into.len() as u32;
                    self.looked_into.push(cell_idx);
                    self.terrain_m.push(terrain.elevation_m(grid.column_and_row(cell_idx)));
                }
                SurfaceClass::Short => {
                    let low_m = self.foreground.ground_top_m(grid, terrain, cell_idx);
                    self.band_m[cell_idx as usize] = [low_m, f32::INFINITY];
                }
                _ => {}
            }
        }
        self.heights.resize(self.looked_into.len(), 0);
        for (&cell_idx, &z_m) in grid.cell_of_point().iter().zip(cloud.z_m()) {
            let Some(&column) = self.column_of_cell.get(cell_idx as usize) else { continue };
            if column != NOT_LOOKED_INTO {
                let step = ((z_m - self.terrain_m[column as usize]) / STEP_M).clamp(0.0, 63.0) as u32;
                self.heights[column as usize] |= 1 << step;
            }
        }
        self.part_columns(grid, terrain, classes);
    }

    /// Separates standing things from hanging ones in every cell that was looked into.
    fn part_columns(&mut self, grid: &HierarchicalGrid, terrain: &Terrain, classes: &mut [SurfaceClass]) {
        for (column, &cell_idx) in self.looked_into.iter().enumerate() {
            self.column_of_cell[cell_idx as usize] = NOT_LOOKED_INTO;
            let terrain_m = self.terrain_m[column];
            let [x_m, y_m] = grid.center_m(cell_idx);
            let clearance_m =
                self.params.min_clearance_m + self.params.clearance_per_m * single::hypot(x_m, y_m);
            let low_m = self.foreground.ground_top_m(grid, terrain, cell_idx);
            let part = StandingPart::of(self.heights[column], clearance_m, low_m - terrain_m);
            let StandingPart { foot_m, top_m, highest_m, .. } = part;
            let against = &mut self.evidence_against[cell_idx as usize];
            if foot_m > self.params.highest_foot_m {
                against.add(Evidence::Covered, true);
                self.hangs[cell_idx as usize] = true;
                // The road is seen below it: only a cell that the field of view cuts off may still bear a wall.
                if part.is_over_ground {
                    classes[cell_idx as usize] = SurfaceClass::Short;
                }
                continue;
            }
            if top_m < highest_m {
                against.add(Evidence::Covered, true);
            }
            if top_m <= self.tall_height_m {
                classes[cell_idx as usize] = SurfaceClass::Short;
            } else {
                against.add(Evidence::Tall, true);
                if top_m > self.params.highest_top_m {
                    continue;
                }
            }
            self.band_m[cell_idx as usize] = [low_m, terrain_m + top_m];
        }
    }

    /// Replaces the content by the points of the cells that [`Self::find_hanging`] found; `classes` are those after `walls`
    /// were found.
    pub fn find(
        &mut self,
        cloud: &PointCloud,
        grid: &HierarchicalGrid,
        classes: &[SurfaceClass],
        walls: &WallRefinement,
    ) {
        self.cells.clear();
        self.tops_m.clear();
        for &cell_idx in grid.occupied() {
            let [low_m, high_m] = self.band_m[cell_idx as usize];
            let z_max_m = grid.cells()[cell_idx as usize].z_max_m;
            if low_m < high_m && z_max_m > low_m {
                let against = &mut self.evidence_against[cell_idx as usize];
                let is_on_wall =
                    classes[cell_idx as usize] == SurfaceClass::Tall && !against.has(Evidence::Tall);
                against.add(Evidence::OnWall, is_on_wall);
                against.add(Evidence::BehindWall, walls.is_behind_wall(grid.center_m(cell_idx)));
                for neighbor_idx in grid.neighborhood(cell_idx) {
                    let is_too_tall = classes[neighbor_idx as usize] == SurfaceClass::Tall
                        && self.band_m[neighbor_idx as usize] == NOWHERE_M
                        && !self.hangs[neighbor_idx as usize];
                    against.add(Evidence::BesideTall, is_too_tall);
                }
                let top_m = if z_max_m < high_m { z_max_m } else { high_m };
                let [x_m, y_m] = grid.center_m(cell_idx);
                against.add(Evidence::CutOff, walls.is_cut_off(single::hypot(x_m, y_m), top_m));
                self.cells.push(cell_idx);
                self.tops_m.push(top_m);
            }
        }
        self.point_indices.resize(self.point_indices.len().max(cloud.len()), 0);
        let mut n_points = 0;
        for ((&cell_idx, &z_m), point_idx) in grid.cell_of_point().iter().zip(cloud.z_m()).zip(0..) {
            let [low_m, high_m] = self.band_m.get(cell_idx as usize).copied().unwrap_or(NOWHERE_M);
            self.point_indices[n_points] = point_idx;
            n_points += usize::from(z_m > low_m && z_m <= high_m);
        }
        self.n_points = n_points;
    }

    /// The coarse cells that may hold candidates, ascending.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// Elevations up to which candidates reach in each of [`Self::cells`], in metres.
    pub fn tops_m(&self) -> &[f32] {
        &self.tops_m
    }

    /// Whether everything in a cell of the latest scan hangs over the street, but for its ground.
    pub fn hangs(&self, cell_idx: u32) -> bool {
        self.hangs[cell_idx as usize]
    }

    /// The evidence against a cell of the latest scan.
    pub fn evidence_against(&self, cell_idx: u32) -> EvidenceAgainst {
        self.evidence_against[cell_idx as usize]
    }

    /// Indices of the points in the scan, ascending.
    pub fn point_indices(&self) -> &[u32] {
        &self.point_indices[..self.n_points]
    }
}

/// The lowest thing that stands in a column of heights. Ground that has free height above it is no part of it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StandingPart {
    // In metres above the terrain.
    foot_m: f32,
    top_m: f32,
    // The top of everything in the column.
    highest_m: f32,
    // Whether ground is seen below it, and free height between.
    is_over_ground: bool,
}

impl StandingPart {
    /// The standing part of `heights`, in steps above the terrain. Free height of `clearance_m` separates hanging things
    /// from those below them; the ground reaches up to `ground_top_m`.
    fn of(heights: u64, clearance_m: f32, ground_top_m: f32) -> Self {
        let n_free = (clearance_m / STEP_M).round().max(1.0) as u32;
        let highest = 63 - heights.leading_zeros().min(63);
        let mut foot = heights.trailing_zeros().min(63);
        let mut top = foot;
        let mut is_over_ground = false;
        loop {
            let above = if top >= 63 { 0 } else { heights >> (top + 1) };
            if above == 0 {
                break;
            }
            let n_between = above.trailing_zeros();
            if n_between >= n_free {
                let is_ground = (top as f32 + 0.5) * STEP_M <= ground_top_m;
                if !is_ground {
                    break;
                }
                foot = top + 1 + n_between;
                is_over_ground = true;
            }
            top += 1 + n_between;
        }
        let [foot_m, top_m, highest_m] = [foot, top + 1, highest + 1].map(|step| step as f32 * STEP_M);
        Self { foot_m, top_m, highest_m, is_over_ground }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::HierarchicalParams;
    use crate::pipeline::frame::Frame;
    use crate::segment::drawn_ground::{SENSOR_HEIGHT_M, road, segmented};

    /// A position, and heights above the road in decimetres.
    type Column = ([f32; 2], std::ops::Range<i8>);

    /// Far from everything else, and so high that the field of view ends far above everything else.
    const MAST: Column = ([-15.3, -15.3], 0..120);

    /// A level road with columns of points, each at a position and at heights above the road.
    fn candidates_of(columns: &[Column]) -> (PointCloud, HierarchicalGrid, Candidates) {
        let params = HierarchicalParams::shipped();
        let mut cloud: PointCloud = road(100).collect();
        for ([x_m, y_m], decimetres) in columns {
            for height in decimetres.clone() {
                cloud.push([*x_m, *y_m, 0.1 * f32::from(height) + 0.05 - SENSOR_HEIGHT_M], 0.0);
            }
        }
        let Frame { grid, terrain, mut classes, mut walls, .. } = segmented(&params.front_end(), &cloud);
        let mut candidates = Candidates::new(
            params.grouping.candidates.clone(),
            params.foreground.clone(),
            params.ground.tall_height_m,
        );
        candidates.find_hanging(&cloud, &grid, &terrain, &mut classes);
        walls.refine_on_walls(&grid, &terrain, &|it| candidates.hangs(it), &mut classes);
        candidates.find(&cloud, &grid, &classes, &walls);
        (cloud, grid, candidates)
    }

    /// The heights of the candidates above the road in whole decimetres, and the evidence against the first one's cell.
    fn found(columns: &[Column]) -> (Vec<i32>, Option<EvidenceAgainst>) {
        let (cloud, grid, candidates) = candidates_of(&[columns, &[MAST]].concat());
        let height = |&it: &u32| ((cloud.z_m()[it as usize] + SENSOR_HEIGHT_M) * 10.0) as i32;
        let first = candidates.point_indices().first();
        let against = first.map(|&it| candidates.evidence_against(grid.cell_of_point()[it as usize]));
        (candidates.point_indices().iter().map(height).collect(), against)
    }

    fn only(evidence: Evidence) -> EvidenceAgainst {
        let mut against = EvidenceAgainst::NONE;
        against.add(evidence, true);
        against
    }

    const HERE: [f32; 2] = [9.0, 3.0];

    #[test]
    fn what_stands_on_the_road_is_a_candidate_and_the_road_is_not() {
        assert_eq!(found(&[(HERE, 0..15)]), ((2..15).collect(), Some(EvidenceAgainst::NONE)));
        assert_eq!(found(&[]).0, []);
    }

    #[test]
    fn the_road_over_a_mirror_image_is_no_candidate() {
        let expected = ((2..15).collect(), Some(EvidenceAgainst::NONE));
        assert_eq!(found(&[(HERE, 0..15), ([9.6, 3.0], -20..-12)]), expected);
    }

    #[test]
    fn a_crown_over_a_car_is_no_part_of_it() {
        let covered = only(Evidence::Covered);
        assert_eq!(found(&[(HERE, 0..15), (HERE, 24..50)]), ((2..15).collect(), Some(covered)));
        // Branches that touch the roof do not hang.
        assert_eq!(found(&[(HERE, 0..15), (HERE, 18..70)]).0, []);
    }

    #[test]
    fn a_bonnet_over_the_road_stands_though_a_crown_is_above_it() {
        let covered = only(Evidence::Covered);
        assert_eq!(found(&[(HERE, 9..13), (HERE, 24..50)]), ((9..13).collect(), Some(covered)));
    }

    #[test]
    fn what_only_hangs_is_no_candidate() {
        assert_eq!(found(&[(HERE, 32..50)]).0, []);
        let hangs = |columns: &[Column]| {
            let (_, grid, candidates) = candidates_of(columns);
            let at = |&&it: &&u32| {
                let [x_m, y_m] = grid.center_m(it);
                (x_m - HERE[0]).abs() < 0.31 && (y_m - HERE[1]).abs() < 0.31
            };
            candidates.hangs(*grid.occupied().iter().find(at).expect("a column stands there"))
        };
        assert!(hangs(&[(HERE, 32..50)]));
        assert!(!hangs(&[(HERE, 0..15), (HERE, 32..50)]) && !hangs(&[(HERE, 0..60)]));
    }

    #[test]
    fn a_truck_is_a_candidate_and_tall_and_a_house_is_none() {
        let tall = only(Evidence::Tall);
        assert_eq!(found(&[(HERE, 0..38)]), ((2..38).collect(), Some(tall)));
        assert_eq!(found(&[(HERE, 0..60)]).0, []);
    }

    #[test]
    fn a_crown_beside_something_is_no_house() {
        // The drawn road ends before the crown, so that nothing is seen below it.
        let [at_the_end, beyond] = [[19.9, 3.0], [20.5, 3.0]];
        let (heights, against) = found(&[(at_the_end, 0..10), (beyond, 40..60)]);
        assert_eq!((heights, against), ((2..10).collect(), Some(EvidenceAgainst::NONE)));
        let (_, against) = found(&[(at_the_end, 0..10), (beyond, 0..60)]);
        assert_eq!(against, Some(only(Evidence::BesideTall)));
    }

    #[test]
    fn what_the_field_of_view_cuts_off_knows_it() {
        let cut_off = |columns: &[Column]| {
            let (_, grid, candidates) = candidates_of(columns);
            let at = |&&it: &&u32| grid.center_m(it)[0] > 8.0;
            let cell_idx = *candidates.cells().iter().find(at).expect("it is a candidate");
            candidates.evidence_against(cell_idx).has(Evidence::CutOff)
        };
        // Nothing in the scan is higher for its range; a car would be no reason to think that the view ends there.
        assert!(cut_off(&[(HERE, 0..30)]) && !cut_off(&[(HERE, 0..15)]));
        assert!(!cut_off(&[(HERE, 0..30), MAST]));
    }

    #[test]
    fn what_stands_at_a_house_knows_it() {
        let beside = only(Evidence::BesideTall);
        let (heights, against) = found(&[(HERE, 0..10), ([9.6, 3.0], 0..60)]);
        assert_eq!((heights, against), ((2..10).collect(), Some(beside)));
    }

    #[test]
    fn the_standing_part_ends_where_it_is_free_above() {
        let bits = |range: std::ops::Range<u32>| range.fold(0_u64, |bits, step| bits | 1 << step);
        let check = |heights: u64, expected: ([u32; 3], bool)| {
            let it = StandingPart::of(heights, 0.5, 0.15);
            let steps = [it.foot_m, it.top_m, it.highest_m].map(|it| (it / STEP_M).round() as u32);
            assert_eq!((steps, it.is_over_ground), expected, "{heights:b}");
        };
        check(bits(0..14), ([0, 14, 14], false));
        check(bits(0..14) | bits(19..40), ([0, 14, 40], false));
        check(bits(0..14) | bits(18..40), ([0, 40, 40], false));
        check(bits(20..64), ([20, 64, 64], false));
        // The ground does not stand on itself: a bonnet over it does, or a crown hangs.
        check(bits(0..1) | bits(63..64), ([63, 64, 64], true));
        check(bits(0..1) | bits(8..12) | bits(30..40), ([8, 12, 40], true));
        check(bits(0..1), ([0, 1, 1], false));
        // Points higher than the ground are no ground.
        check(bits(0..3) | bits(8..12), ([0, 3, 12], false));
    }
}
