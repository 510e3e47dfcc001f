//! Turns cells of façades into tall ones.

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::segment::cut_off_walls::CutOffWalls;
use crate::segment::hough_lines::Segment;
use crate::segment::printed_walls::PrintedWalls;
use crate::segment::terrain::Terrain;
use crate::segment::wall_params::WallRefinementParams;
use crate::segment::walls::{WallFinder, WallScene, Walls};
use crate::surface_class::SurfaceClass;

/// Turns the short cells of walls into tall ones, by [`CutOffWalls`] or, as printed, by [`PrintedWalls`].
///
/// Paper: HG section 3.1, refinement by a probabilistic Hough transform, and Fig. 3.
#[derive(Debug)]
pub struct WallRefinement {
    params: WallRefinementParams,
    walls: Walls,
    // None if walls are not looked for.
    finder: Option<Box<dyn WallFinder>>,
}

impl WallRefinement {
    /// A refinement of the classes of grids of the geometry of `grid`.
    pub fn new(params: WallRefinementParams, grid: &HierarchicalGrid) -> Self {
        let finder = params.enabled.then(|| -> Box<dyn WallFinder> {
            if params.as_printed {
                let WallRefinementParams { hough, min_support, beside, .. } = params.clone();
                Box::new(PrintedWalls::new(hough, min_support, beside, grid))
            } else {
                Box::new(CutOffWalls::new(params.clone(), grid))
            }
        });
        Self { params, walls: Walls::new(grid.cells().len()), finder }
    }

    /// The parameters.
    pub fn params(&self) -> &WallRefinementParams {
        &self.params
    }

    /// Turns the short cells among `classes` that lie on walls, or behind one, into tall ones.
    pub fn refine(&mut self, grid: &HierarchicalGrid, terrain: &Terrain, classes: &mut [SurfaceClass]) {
        self.refine_on_walls(grid, terrain, &|_| false, classes);
        // What is seen through windows and doors stands in no street.
        for &cell_idx in grid.occupied() {
            let is_short = classes[cell_idx as usize] == SurfaceClass::Short;
            if is_short && self.walls.hide(grid.center_m(cell_idx)) {
                self.walls.turn_tall(classes, cell_idx);
            }
        }
    }

    /// Turns the short cells among `classes` that lie on walls into tall ones. Cells that hang over the street, such as
    /// crowns and signs, are a wall only in line with enough that stand: see `min_standing`.
    pub fn refine_on_walls(
        &mut self,
        grid: &HierarchicalGrid,
        terrain: &Terrain,
        hangs: &dyn Fn(u32) -> bool,
        classes: &mut [SurfaceClass],
    ) {
        self.walls.clear();
        if let Some(finder) = &mut self.finder {
            finder.find(&WallScene { grid, terrain, hangs }, classes, &mut self.walls);
        }
    }

    /// Whether a wall of the latest scan hides this position of the ground plan from the sensor.
    pub fn is_behind_wall(&self, position_m: [f32; 2]) -> bool {
        self.walls.hide(position_m)
    }

    /// Whether the upper end of the field of view of the latest scan cuts off things that reach this height over the sensor
    /// at this range, both in metres. `false` if that end is not known, or walls are not looked for.
    pub fn is_cut_off(&self, range_m: f32, top_m: f32) -> bool {
        self.finder.as_ref().is_some_and(|it| it.is_cut_off(range_m, top_m))
    }

    /// The length of the longest wall of the latest scan on which a cell lies, or beside which, in metres; 0 for other
    /// cells.
    pub fn length_of_wall_m(&self, cell_idx: u32) -> f32 {
        self.walls.length_m(cell_idx)
    }

    /// The cells of the latest scan that were short and became tall.
    pub fn taken(&self) -> &[u32] {
        self.walls.taken()
    }

    /// The walls of the latest scan.
    pub fn walls(&self) -> &[Segment] {
        self.walls.segments()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PointCloud;
    use crate::params::HierarchicalParams;
    use crate::params::front_end::FrontEndParams;
    use crate::params::paper::PaperParams;
    use crate::portable_math::single;
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
                    walls.refine_on_walls(grid, terrain, &|it| grid.center_m(it)[0] > from_x_m, classes);
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
