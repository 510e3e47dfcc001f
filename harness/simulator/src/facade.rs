//! The street side of a house: a wall with plinth, windows and doors set back into it.

use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::query::Ray;

/// The pattern of a façade. Bays repeat along it, storeys upward; each bay of each storey has one opening.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacadePattern {
    /// Width of a bay in metres.
    pub bay_m: f32,
    /// Height of a storey in metres.
    pub storey_m: f32,
    /// Width of a window in metres.
    pub window_width_m: f32,
    /// Height of a window in metres.
    pub window_height_m: f32,
    /// Height of a window's lower edge above its floor, in metres.
    pub sill_m: f32,
    /// How far panes and doors stand back, in metres.
    pub recess_m: f32,
    /// Every bay of this number, counted along the ground floor, has a door instead of a window.
    pub door_every_n_bays: u32,
}

/// A façade at its position in the world.
#[derive(Debug, Clone)]
pub struct PlacedFacade {
    /// Lower corner on the left as seen from the street.
    corner: Vector,
    /// Level unit vector from the left to the right.
    along: Vector,
    /// Level unit vector toward the street.
    outward: Vector,
    length_m: f32,
    height_m: f32,
    pattern: FacadePattern,
}

/// Where a ray meets a façade.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacadeHit {
    /// Distance in lengths of the ray's direction.
    pub range_m: f32,
    /// Unit normal of the surface.
    pub normal: Vector,
    /// Whether it is a window pane.
    pub is_pane: bool,
}

/// An opening: left, right, bottom, top in metres from the façade's corner.
#[derive(Debug, Clone, Copy)]
struct Opening {
    left: f32,
    right: f32,
    bottom: f32,
    top: f32,
    is_window: bool,
}

impl PlacedFacade {
    /// A façade of this height from `left` to `right` as seen from the street, both at its foot.
    pub fn new(left: Vector, right: Vector, height_m: f32, pattern: FacadePattern) -> Self {
        let level = Vector::new(right.x - left.x, right.y - left.y, 0.0);
        let length_m = level.length();
        let along = level / length_m;
        let corner = Vector::new(left.x, left.y, left.z.min(right.z));
        let outward = Vector::new(along.y, -along.x, 0.0);
        Self { corner, along, outward, length_m, height_m, pattern }
    }

    /// The upright box around it.
    pub fn bounds(&self) -> Aabb {
        let back = self.outward * -(self.pattern.recess_m + 0.01);
        let far = self.corner + self.along * self.length_m + Vector::Z * self.height_m;
        let mut bounds = Aabb::new(self.corner.min(far), self.corner.max(far));
        bounds.take_point(self.corner + back);
        bounds.take_point(far + back);
        bounds
    }

    /// Where `ray` meets wall, reveal, door or pane, coming from the street.
    pub fn surface_hit(&self, ray: &Ray) -> Option<FacadeHit> {
        let approach = -self.outward.dot(ray.dir);
        if approach <= 1e-6 {
            return None;
        }
        let range_m = self.outward.dot(ray.origin - self.corner) / approach;
        if range_m < 0.0 {
            return None;
        }
        let [u, v] = self.on_wall(ray, range_m);
        if !(0.0..=self.length_m).contains(&u) || !(0.0..=self.height_m).contains(&v) {
            return None;
        }
        let Some(opening) = self.opening_at(u, v) else {
            return Some(FacadeHit { range_m, normal: self.outward, is_pane: false });
        };
        let back_m = range_m + self.pattern.recess_m / approach;
        let behind = self.on_wall(ray, back_m);
        let reveal = self.reveal_hit(&opening, [[u, v], behind], [range_m, back_m]);
        reveal.or(Some(FacadeHit { range_m: back_m, normal: self.outward, is_pane: opening.is_window }))
    }

    /// Metres to the right of and above the corner.
    fn on_wall(&self, ray: &Ray, range_m: f32) -> [f32; 2] {
        let from_corner = ray.origin + ray.dir * range_m - self.corner;
        [self.along.dot(from_corner), from_corner.z]
    }

    fn opening_at(&self, u: f32, v: f32) -> Option<Opening> {
        let pattern = &self.pattern;
        let n_bays = (self.length_m / pattern.bay_m).floor().max(1.0);
        let bay_m = self.length_m / n_bays;
        let (bay, storey) = ((u / bay_m).floor(), (v / pattern.storey_m).floor());
        let middle = (bay + 0.5) * bay_m;
        let floor = storey * pattern.storey_m;
        let is_door = storey == 0.0 && (bay as u32) % pattern.door_every_n_bays == 1;
        let (width, bottom, height) = if is_door {
            (1.1, 0.15, 2.1)
        } else {
            (pattern.window_width_m, pattern.sill_m, pattern.window_height_m)
        };
        let width = width.min(bay_m - 0.3);
        let opening = Opening {
            left: middle - width / 2.0,
            right: middle + width / 2.0,
            bottom: floor + bottom,
            top: floor + bottom + height,
            is_window: !is_door,
        };
        let inside = (opening.left..opening.right).contains(&u) && (opening.bottom..opening.top).contains(&v);
        inside.then_some(opening)
    }

    /// The side of the opening that a ray reaches before the pane, if any.
    ///
    /// The ray is at `[front, behind]` on wall and pane, at `[front_m, behind_m]` from its origin.
    fn reveal_hit(
        &self,
        opening: &Opening,
        [front, behind]: [[f32; 2]; 2],
        [front_m, behind_m]: [f32; 2],
    ) -> Option<FacadeHit> {
        let sides = [
            (opening.right - front[0], behind[0] - front[0], -self.along),
            (front[0] - opening.left, front[0] - behind[0], self.along),
            (opening.top - front[1], behind[1] - front[1], -Vector::Z),
            (front[1] - opening.bottom, front[1] - behind[1], Vector::Z),
        ];
        let reached = sides.into_iter().filter(|(distance, way, _)| *way > *distance);
        let first = reached
            .map(|(distance, way, normal)| (distance / way, normal))
            .min_by(|one, other| one.0.total_cmp(&other.0))?;
        let range_m = front_m + first.0 * (behind_m - front_m);
        Some(FacadeHit { range_m, normal: first.1, is_pane: false })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall along x that faces −y, seen from 5 m in front of it.
    #[track_caller]
    fn check(from_x: f32, toward: [f32; 3], expected_depth_m: f32, expected_pane: bool) {
        let pattern = FacadePattern {
            bay_m: 3.0,
            storey_m: 3.0,
            window_width_m: 1.0,
            window_height_m: 1.4,
            sill_m: 0.9,
            recess_m: 0.2,
            door_every_n_bays: 4,
        };
        let wall = PlacedFacade::new(Vector::ZERO, Vector::new(12.0, 0.0, 0.0), 9.0, pattern);
        let ray = Ray::new(Vector::new(from_x, -5.0, 1.5), Vector::from(toward));
        let hit = wall.surface_hit(&ray).unwrap();
        let depth_m = -5.0 + hit.range_m * toward[1];
        assert!((depth_m - expected_depth_m).abs() < 1e-4, "{depth_m}");
        assert_eq!(hit.is_pane, expected_pane);
        assert!(hit.normal.dot(ray.dir) < 0.0);
        let hit_position = ray.origin + ray.dir * hit.range_m;
        assert!(wall.bounds().distance_to_point(hit_position) < 1e-4);
    }

    trait DistanceToPoint {
        fn distance_to_point(&self, point: Vector) -> f32;
    }

    impl DistanceToPoint for Aabb {
        fn distance_to_point(&self, point: Vector) -> f32 {
            (self.mins - point).max(point - self.maxs).max(Vector::ZERO).length()
        }
    }

    #[test]
    fn between_windows_there_is_wall() {
        check(0.5, [0.0, 1.0, 0.0], 0.0, false);
    }

    #[test]
    fn panes_stand_back() {
        check(1.5, [0.0, 1.0, 0.0], 0.2, true);
    }

    #[test]
    fn doors_are_no_panes() {
        check(4.5, [0.0, 1.0, 0.0], 0.2, false);
    }

    #[test]
    fn a_slanting_ray_meets_the_reveal() {
        // It passes the wall at x = 1.9 and reaches the side of the window at x = 2.0 halfway to the pane.
        check(-3.1, [1.0, 1.0, 0.0], 0.1, false);
    }
}
