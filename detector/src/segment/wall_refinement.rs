//! Façades that the sensor sees only the lower part of, found as long straight lines of cells.

use serde::Deserialize;

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::portable_math::single;
use crate::segment::hough_lines::{HoughLines, HoughParams, Segment};
use crate::segment::terrain::Terrain;
use crate::segment::wall_segments::{
    Shadow, cell_at, center_m, corridor, ground_behind_share, support_share,
};
use crate::surface_class::SurfaceClass;

/// Tuning of [`WallRefinement::refine`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallRefinementParams {
    /// Whether walls are looked for at all.
    pub enabled: bool,
    /// Whether walls are found as the paper prints it. `min_height_m`, `ceiling_margin_deg`, `min_standing` and
    /// `max_ground_behind` are not used then.
    pub as_printed: bool,
    /// Whether the cells beside a segment become tall, too, where walls are found as printed.
    pub beside: bool,
    /// Least height above the terrain of a cell that may support a wall, in metres: above the roofs of cars.
    pub min_height_m: f32,
    /// How far below the top of the field of view, in degrees, a cell still counts as cut off by it.
    pub ceiling_margin_deg: f32,
    /// Least share of a segment's length along which cells support a wall.
    pub min_support: f32,
    /// Least share of a segment's length along which cells support a wall and do not hang over the street. Hanging cells are
    /// known only where cells are looked into, for the tree of groupings.
    pub min_standing: f32,
    /// Greatest share of a segment's length behind which ground is seen: a wall hides it, rain and rows of trunks do not.
    pub max_ground_behind: f32,
    /// How the segments are found.
    pub hough: HoughParams,
}

/// Turns the short cells of walls into tall ones.
///
/// Near the sensor no beam reaches the height at which a cell is tall: 3.1 m with the topmost beam at +2° and 1.73 m
/// above the road is 39 m away. A near façade is only known to go on up to the topmost beam: a cell that is tall, or higher
/// than cars and *cut off* by the upper end of the field of view, supports a wall. Segments are found among the supporting
/// cells, so a row of parked cars makes none however straight it is; the short cells on a segment become tall whether they
/// support it or not.
///
/// With [`WallRefinementParams::as_printed`] segments are found among all tall and short cells. The paper takes each for a
/// wall, a row of parked cars, too; here enough of its cells have to be tall.
///
/// Paper: HG section 3.1, refinement by a probabilistic Hough transform, and Fig. 3.
#[derive(Debug, Clone)]
pub struct WallRefinement {
    params: WallRefinementParams,
    lines: HoughLines,
    rises: Vec<f32>,
    // Rise over range from which on the upper end of the field of view cuts a cell off.
    least_cut_off: f32,
    // For every cell: 1 where it supports a wall.
    supports: Vec<u32>,
    is_support: Vec<bool>,
    walls: Vec<Segment>,
    shadows: Vec<Shadow>,
    // For every step along every wall, one behind the other, whether a cell there or beside it bears the wall.
    borne: Vec<bool>,
    // Cells that became tall and whose neighbours are not processed yet.
    front: Vec<u32>,
    // For every cell the length of the longest wall that it lies on, in metres; those of an earlier scan are in the list.
    wall_length_m: Vec<f32>,
    on_walls: Vec<u32>,
    taken: Vec<u32>,
}

/// Cells nearer than this, in metres, say little about the top of the field of view: their size is too large an angle.
const MIN_RANGE_OF_CEILING_M: f32 = 8.0;

/// The rise of the field of view's upper end is this quantile of the rises of the cells' highest points.
const CEILING_QUANTILE: f32 = 0.99;

/// The upper end of the field of view is known if it cuts off this share of the standing cells beyond
/// [`MIN_RANGE_OF_CEILING_M`], counting only cells higher than cars as cut off.
const LEAST_CUT_OFF_SHARE: f32 = 0.1;

impl WallRefinement {
    /// A refinement of the classes of grids of the geometry of `grid`.
    pub fn new(params: WallRefinementParams, grid: &HierarchicalGrid) -> Self {
        let lines = HoughLines::new(params.hough.clone(), grid.n_columns());
        let is_support = vec![false; grid.cells().len()];
        Self {
            params,
            lines,
            rises: Vec::new(),
            least_cut_off: f32::INFINITY,
            supports: Vec::new(),
            is_support,
            walls: Vec::new(),
            shadows: Vec::new(),
            borne: Vec::new(),
            front: Vec::new(),
            wall_length_m: vec![0.0; grid.cells().len()],
            on_walls: Vec::new(),
            taken: Vec::new(),
        }
    }

    /// The parameters.
    pub fn params(&self) -> &WallRefinementParams {
        &self.params
    }

    /// Turns the short cells among `classes` that lie on walls, or behind one, into tall ones.
    pub fn refine(&mut self, grid: &HierarchicalGrid, terrain: &Terrain, classes: &mut [SurfaceClass]) {
        self.refine_on_walls(grid, terrain, |_| false, classes);
        self.clear_behind(grid, classes);
    }

    /// Turns the short cells among `classes` that lie on walls into tall ones. Cells that hang over the street, such as
    /// crowns and signs, are a wall only in line with enough that stand: see `min_standing`.
    pub fn refine_on_walls(
        &mut self,
        grid: &HierarchicalGrid,
        terrain: &Terrain,
        hangs: impl Fn(u32) -> bool,
        classes: &mut [SurfaceClass],
    ) {
        self.walls.clear();
        self.shadows.clear();
        self.borne.clear();
        self.taken.clear();
        for cell_idx in self.on_walls.drain(..) {
            self.wall_length_m[cell_idx as usize] = 0.0;
        }
        self.least_cut_off = f32::INFINITY;
        if !self.params.enabled {
            return;
        }
        if self.params.as_printed {
            self.refine_as_printed(grid, classes);
            return;
        }
        self.find_supports(grid, terrain, classes);
        let segments = self.lines.find(&self.supports);
        for &segment in segments {
            if support_share(segment, grid, |it| self.is_support[it as usize]) >= self.params.min_support
                && support_share(segment, grid, |it| self.is_support[it as usize] && !hangs(it))
                    >= self.params.min_standing
                && ground_behind_share(segment, grid, classes) <= self.params.max_ground_behind
            {
                self.walls.push(segment);
                self.shadows.push(Shadow::of(segment, grid, &self.is_support, &mut self.borne));
            }
        }
        self.front.clear();
        let walls = std::mem::take(&mut self.walls);
        for &segment in &walls {
            for cells in corridor(segment) {
                let [on, sides @ ..] = cells.map(|it| cell_at(grid, it));
                let Some(on) = on else { continue };
                self.turn_tall(classes, on);
                self.front.push(on);
                for beside in sides.into_iter().flatten() {
                    // Cells right behind a wall are seen through its windows.
                    if self.is_support[beside as usize] || range_m(grid, beside) > range_m(grid, on) {
                        let turned = self.turn_tall(classes, beside);
                        self.front.extend(turned);
                    }
                }
            }
        }
        self.walls = walls;
        self.spread(grid, classes);
        self.measure(grid);
    }

    /// Segments among all tall and short cells are walls if enough of their cells are tall; their short cells become tall.
    fn refine_as_printed(&mut self, grid: &HierarchicalGrid, classes: &mut [SurfaceClass]) {
        for &cell_idx in &self.supports {
            self.is_support[cell_idx as usize] = false;
        }
        self.supports.clear();
        for &cell_idx in grid.occupied() {
            let class = classes[cell_idx as usize];
            if matches!(class, SurfaceClass::Tall | SurfaceClass::Short) {
                self.supports.push(cell_idx);
                self.is_support[cell_idx as usize] = class == SurfaceClass::Tall;
            }
        }
        for &segment in self.lines.find(&self.supports) {
            if support_share(segment, grid, |it| self.is_support[it as usize]) >= self.params.min_support {
                self.walls.push(segment);
            }
        }
        // After all were judged, so that the order of the segments does not matter.
        let walls = std::mem::take(&mut self.walls);
        for &segment in &walls {
            let n_across = if self.params.beside { 3 } else { 1 };
            let cells = corridor(segment).flat_map(|across| across.into_iter().take(n_across));
            for cell_idx in cells.filter_map(|it| cell_at(grid, it)) {
                self.turn_tall(classes, cell_idx);
            }
        }
        self.walls = walls;
        self.measure(grid);
    }

    /// Records for every cell on a wall the length of the wall.
    fn measure(&mut self, grid: &HierarchicalGrid) {
        for &segment in &self.walls {
            let [start_m, end_m] = [segment.start, segment.end].map(|position| center_m(grid, position));
            let length_m = single::hypot(end_m[0] - start_m[0], end_m[1] - start_m[1]);
            for cell_idx in corridor(segment).flatten().filter_map(|it| cell_at(grid, it)) {
                let longest_m = &mut self.wall_length_m[cell_idx as usize];
                *longest_m = longest_m.max(length_m);
                self.on_walls.push(cell_idx);
            }
        }
    }

    /// Turns short cells behind a wall into tall ones: they are seen through windows and doors, and stand in no street.
    fn clear_behind(&mut self, grid: &HierarchicalGrid, classes: &mut [SurfaceClass]) {
        for &cell_idx in grid.occupied() {
            let is_short = classes[cell_idx as usize] == SurfaceClass::Short;
            if is_short && self.is_behind_wall(grid.center_m(cell_idx)) {
                self.turn_tall(classes, cell_idx);
            }
        }
    }

    /// Whether a wall of the latest scan hides this position of the ground plan from the sensor. The gaps of a wall, where
    /// no cell bears it, hide nothing.
    pub fn is_behind_wall(&self, position_m: [f32; 2]) -> bool {
        self.shadows.iter().any(|it| it.covers(position_m, &self.borne))
    }

    /// Whether the upper end of the field of view of the latest scan cuts off things that reach this height over the sensor
    /// at this range, both in metres. `false` if that end is not known, or walls are not looked for.
    pub fn is_cut_off(&self, range_m: f32, top_m: f32) -> bool {
        top_m >= self.least_cut_off * range_m
    }

    /// Extends walls to bays, reliefs and side walls: a cell that supports a wall and touches one is wall.
    fn spread(&mut self, grid: &HierarchicalGrid, classes: &mut [SurfaceClass]) {
        while let Some(cell_idx) = self.front.pop() {
            for neighbor_idx in grid.neighborhood(cell_idx) {
                if self.is_support[neighbor_idx as usize] {
                    let turned = self.turn_tall(classes, neighbor_idx);
                    self.front.extend(turned);
                }
            }
        }
    }

    /// The length of the longest wall of the latest scan on which a cell lies, or beside which, in metres; 0 for other
    /// cells.
    pub fn length_of_wall_m(&self, cell_idx: u32) -> f32 {
        self.wall_length_m[cell_idx as usize]
    }

    /// Turns a short cell into a tall one; `None` if it is not short.
    fn turn_tall(&mut self, classes: &mut [SurfaceClass], cell_idx: u32) -> Option<u32> {
        let class = &mut classes[cell_idx as usize];
        (*class == SurfaceClass::Short).then(|| {
            *class = SurfaceClass::Tall;
            self.taken.push(cell_idx);
            cell_idx
        })
    }

    /// The cells of the latest scan that were short and became tall.
    pub fn taken(&self) -> &[u32] {
        &self.taken
    }

    /// The walls of the latest scan.
    pub fn walls(&self) -> &[Segment] {
        &self.walls
    }

    fn find_supports(&mut self, grid: &HierarchicalGrid, terrain: &Terrain, classes: &[SurfaceClass]) {
        for &cell_idx in &self.supports {
            self.is_support[cell_idx as usize] = false;
        }
        self.supports.clear();
        let standing =
            |cell_idx: u32| matches!(classes[cell_idx as usize], SurfaceClass::Tall | SurfaceClass::Short);
        self.rises.clear();
        for &cell_idx in grid.occupied().iter().filter(|&&it| standing(it)) {
            let range_m = range_m(grid, cell_idx);
            if range_m >= MIN_RANGE_OF_CEILING_M {
                self.rises.push(grid.cells()[cell_idx as usize].z_max_m / range_m);
            }
        }
        if self.rises.is_empty() {
            return;
        }
        let rank = (CEILING_QUANTILE * self.rises.len() as f32) as usize;
        let (_, &mut ceiling, _) = self.rises.select_nth_unstable_by(rank, f32::total_cmp);
        let mut n_cut_off = 0;
        self.least_cut_off =
            single::tan(single::atan2(ceiling, 1.0) - self.params.ceiling_margin_deg.to_radians());
        for &cell_idx in grid.occupied().iter().filter(|&&it| standing(it)) {
            let cell = &grid.cells()[cell_idx as usize];
            let height_m = cell.z_max_m - terrain.elevation_m(grid.column_and_row(cell_idx));
            let tall = classes[cell_idx as usize] == SurfaceClass::Tall;
            let is_cut_off = height_m >= self.params.min_height_m
                && self.is_cut_off(range_m(grid, cell_idx), cell.z_max_m);
            n_cut_off += usize::from(is_cut_off && range_m(grid, cell_idx) >= MIN_RANGE_OF_CEILING_M);
            if tall || is_cut_off {
                self.supports.push(cell_idx);
                self.is_support[cell_idx as usize] = true;
            }
        }
        if (n_cut_off as f32) < LEAST_CUT_OFF_SHARE * self.rises.len() as f32 {
            // Too little is seen up there: the cells that are highest for their range may well end there.
            self.least_cut_off = f32::INFINITY;
        }
    }
}

fn range_m(grid: &HierarchicalGrid, cell_idx: u32) -> f32 {
    let [x, y] = grid.center_m(cell_idx);
    single::hypot(x, y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PointCloud;
    use crate::params::HierarchicalParams;
    use crate::params::front_end::FrontEndParams;
    use crate::params::paper::PaperParams;
    use crate::segment::drawn_ground::{SENSOR_HEIGHT_M, class_around, road, segmented};

    /// The rise of the topmost beam, as tangent.
    const TOP_RISE: f32 = 0.035;

    /// A level road with surfaces of which a sensor with a topmost beam sees the lower part.
    #[derive(Clone)]
    struct Drawing(PointCloud);

    impl Drawing {
        /// A road that ends where façades stand, 9 m to the left.
        fn road() -> Self {
            Self::open_ground(9.0)
        }

        /// Ground as far as `left_m` to the left.
        fn open_ground(left_m: f32) -> Self {
            Self(road(150).filter(|[_, y, _]| *y < left_m).collect())
        }

        /// A surface `height_m` high over the line from one point of the ground plan to another.
        fn surface(self, from_m: [f32; 2], to_m: [f32; 2], height_m: f32) -> Self {
            self.seen_up_to(from_m, to_m, height_m, TOP_RISE)
        }

        /// A surface as a sensor sees it whose topmost beam rises by `top_rise`.
        fn seen_up_to(mut self, from_m: [f32; 2], to_m: [f32; 2], height_m: f32, top_rise: f32) -> Self {
            for step in 0..=400 {
                let share = step as f32 / 400.0;
                let [x, y] = [0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]));
                let top_m = (height_m - SENSOR_HEIGHT_M).min(top_rise * single::hypot(x, y));
                for level in 0..=8 {
                    let z = -SENSOR_HEIGHT_M + (top_m + SENSOR_HEIGHT_M) * level as f32 / 8.0;
                    self.0.push([x, y, z], 0.0);
                }
            }
            self
        }

        /// The class of the cell around `position_m` with walls refined.
        fn class_at(&self, position_m: [f32; 2], enabled: bool) -> SurfaceClass {
            let mut params = HierarchicalParams::shipped().front_end();
            params.walls.enabled = enabled;
            self.class_by(&params, position_m)
        }

        /// The class of the cell around `position_m` with walls as the paper prints them.
        fn printed_class_at(&self, position_m: [f32; 2]) -> SurfaceClass {
            self.class_by(&PaperParams::shipped().front_end(&HierarchicalParams::shipped()), position_m)
        }

        fn class_by(&self, params: &FrontEndParams, position_m: [f32; 2]) -> SurfaceClass {
            self.class_refined(params, position_m, |walls, (grid, terrain), classes| {
                walls.refine(grid, terrain, classes);
            })
        }

        /// The class of the cell around `position_m` if all cells in front of `from_x_m` hang over the street.
        fn class_if_hanging(&self, position_m: [f32; 2], from_x_m: f32) -> SurfaceClass {
            self.class_refined(
                &HierarchicalParams::shipped().front_end(),
                position_m,
                |walls, (grid, terrain), classes| {
                    walls.refine_on_walls(grid, terrain, |it| grid.center_m(it)[0] > from_x_m, classes);
                },
            )
        }

        fn class_refined(
            &self,
            params: &FrontEndParams,
            position_m: [f32; 2],
            refine: impl Fn(&mut WallRefinement, (&HierarchicalGrid, &Terrain), &mut [SurfaceClass]),
        ) -> SurfaceClass {
            let mut frame = segmented(params, &self.0);
            refine(&mut frame.walls, (&frame.grid, &frame.terrain), &mut frame.classes);
            class_around(&frame, position_m)
        }
    }

    #[test]
    fn a_near_facade_is_short_before_and_tall_after() {
        let street = Drawing::road().surface([-12.0, 9.1], [12.0, 9.1], 12.0);
        assert_eq!(street.class_at([3.1, 9.1], false), SurfaceClass::Short);
        assert_eq!(street.class_at([3.1, 9.1], true), SurfaceClass::Tall);
    }

    #[test]
    fn its_lower_parts_and_side_walls_go_with_it() {
        // A gate of a metre's height in the line, and a wall that leads away from the street.
        let street = Drawing::road()
            .surface([-12.0, 9.1], [2.0, 9.1], 12.0)
            .surface([2.0, 9.1], [3.6, 9.1], 1.0)
            .surface([3.6, 9.1], [12.0, 9.1], 12.0)
            .surface([12.0, 9.1], [12.0, 12.1], 12.0);
        assert_eq!(street.class_at([2.8, 9.1], true), SurfaceClass::Tall);
        assert_eq!(street.class_at([12.0, 11.2], true), SurfaceClass::Tall);
    }

    #[test]
    fn a_row_of_parked_cars_is_no_wall_with_or_without_a_facade_behind() {
        let cars = Drawing::road().surface([-12.0, 4.1], [12.0, 4.1], 1.5);
        assert_eq!(cars.class_at([3.1, 4.1], true), SurfaceClass::Short);
        let street = cars.surface([-12.0, 9.1], [12.0, 9.1], 12.0);
        assert_eq!(street.class_at([3.1, 4.1], true), SurfaceClass::Short);
        assert_eq!(street.class_at([3.1, 9.1], true), SurfaceClass::Tall);
    }

    #[test]
    fn what_is_seen_through_a_window_is_not_on_the_street() {
        let street = Drawing::road().surface([-12.0, 9.1], [12.0, 9.1], 12.0);
        let shop = street.surface([1.5, 12.1], [2.5, 12.1], 1.0).surface([18.5, 12.1], [19.5, 12.1], 1.0);
        assert_eq!(shop.class_at([2.1, 12.1], true), SurfaceClass::Tall);
        // Past the end of the wall.
        assert_eq!(shop.class_at([19.0, 12.1], true), SurfaceClass::Short);
    }

    #[test]
    fn what_is_seen_through_a_gap_of_a_wall_may_stand_on_the_street() {
        let street = Drawing::road()
            .surface([-12.0, 9.1], [1.5, 9.1], 12.0)
            .surface([3.7, 9.1], [12.0, 9.1], 12.0)
            .surface([2.9, 12.1], [3.3, 12.1], 1.0)
            .surface([-3.9, 12.1], [-3.3, 12.1], 1.0);
        assert_eq!(street.class_at([3.1, 12.1], true), SurfaceClass::Short);
        assert_eq!(street.class_at([-3.6, 12.1], true), SurfaceClass::Tall);
    }

    #[test]
    fn a_wall_stands_along_three_tenths_of_its_length() {
        let street = Drawing::road().surface([-12.0, 9.1], [12.0, 9.1], 12.0);
        assert_eq!(street.class_if_hanging([3.1, 9.1], 12.0), SurfaceClass::Tall);
        // A third of it stands.
        assert_eq!(street.class_if_hanging([3.1, 9.1], -3.5), SurfaceClass::Tall);
        assert_eq!(street.class_if_hanging([3.1, 9.1], -8.0), SurfaceClass::Short);
    }

    #[test]
    fn what_reaches_the_upper_end_of_the_view_is_cut_off() {
        let street = Drawing::road().surface([-12.0, 9.1], [12.0, 9.1], 12.0);
        let params = HierarchicalParams::shipped().front_end();
        street.class_refined(&params, [3.1, 9.1], |walls, (grid, terrain), classes| {
            assert!(!walls.is_cut_off(10.0, 5.0), "nothing was seen yet");
            walls.refine(grid, terrain, classes);
            // Less than two degrees below the topmost beam, and more.
            assert!(walls.is_cut_off(10.0, 10.0 * TOP_RISE - 0.2));
            assert!(!walls.is_cut_off(10.0, 10.0 * TOP_RISE - 0.5));
        });
        // The roofs of cars are highest where there is nothing else, and a pole beside them says no more.
        let cars = Drawing::road().surface([-12.0, 7.1], [12.0, 7.1], 1.5);
        for street in [&cars.clone(), &cars.surface([9.1, -4.1], [9.2, -4.1], 3.0)] {
            street.class_refined(
                &HierarchicalParams::shipped().front_end(),
                [3.1, 7.1],
                |walls, (grid, terrain), classes| {
                    walls.refine(grid, terrain, classes);
                    assert!(!walls.is_cut_off(10.0, 5.0));
                },
            );
        }
    }

    #[test]
    fn a_cell_knows_how_long_its_wall_is() {
        let street = Drawing::road().surface([-12.0, 9.1], [12.0, 9.1], 12.0);
        street.class_refined(
            &HierarchicalParams::shipped().front_end(),
            [3.1, 9.1],
            |walls, (grid, terrain), classes| {
                let cell_at = |position_m| {
                    let [column, row] = grid.nearest_column_and_row(position_m);
                    row * grid.n_columns() + column
                };
                walls.refine(grid, terrain, classes);
                let length_m = walls.length_of_wall_m(cell_at([3.1, 9.1]));
                assert!((length_m - 24.0).abs() <= 0.6, "{length_m}");
                assert_eq!(walls.length_of_wall_m(cell_at([3.1, 4.1])), 0.0);
                // A scan without a wall.
                walls.refine(grid, terrain, &mut vec![SurfaceClass::Unseen; classes.len()]);
                assert_eq!(walls.length_of_wall_m(cell_at([3.1, 9.1])), 0.0);
            },
        );
    }

    #[test]
    fn what_hides_no_ground_is_no_wall() {
        let rain = Drawing::open_ground(20.0).surface([-12.0, 9.1], [12.0, 9.1], 12.0);
        assert_eq!(rain.class_at([3.1, 9.1], true), SurfaceClass::Short);
    }

    #[test]
    fn as_printed_a_line_is_a_wall_if_a_third_of_it_is_tall() {
        let cars = Drawing::road().surface([-12.0, 4.1], [12.0, 4.1], 1.5);
        assert_eq!(cars.printed_class_at([3.1, 4.1]), SurfaceClass::Short);
        // No beam is as high as that this near.
        let facade = || Drawing::road().surface([-12.0, 9.1], [12.0, 9.1], 12.0);
        assert_eq!(facade().printed_class_at([3.1, 9.1]), SurfaceClass::Short);
        // A sign over it is, and is too little; a bay of 10 m of 24 is not.
        let sign = facade().seen_up_to([-5.4, 9.1], [-4.8, 9.1], 3.5, 1.0);
        assert_eq!(sign.printed_class_at([3.1, 9.1]), SurfaceClass::Short);
        let bay = facade().seen_up_to([-12.0, 9.1], [-2.0, 9.1], 3.5, 1.0);
        assert_eq!(bay.printed_class_at([3.1, 9.1]), SurfaceClass::Tall);
    }

    #[test]
    fn as_printed_nothing_becomes_tall_that_is_not_on_the_line() {
        let street = Drawing::road().seen_up_to([-12.0, 9.1], [12.0, 9.1], 12.0, 1.0);
        let shop = street.surface([1.5, 12.1], [2.5, 12.1], 1.0).surface([1.5, 10.9], [2.5, 10.9], 1.0);
        assert_eq!(shop.printed_class_at([2.1, 12.1]), SurfaceClass::Short);
        assert_eq!(shop.printed_class_at([2.1, 10.9]), SurfaceClass::Short);
        assert_eq!(shop.class_at([2.1, 12.1], true), SurfaceClass::Tall);
    }

    #[test]
    fn a_van_is_no_wall() {
        let street =
            Drawing::road().surface([-12.0, 9.1], [12.0, 9.1], 12.0).surface([5.0, -4.1], [10.2, -4.1], 2.4);
        assert_eq!(street.class_at([7.1, -4.1], true), SurfaceClass::Short);
    }
}
