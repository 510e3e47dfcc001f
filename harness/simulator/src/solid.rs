//! Convex solids and where a ray enters and leaves them.

use parry3d::bounding_volume::Aabb;
use parry3d::math::{Pose, Vector};
use parry3d::query::Ray;

/// A convex solid in the frame of the object it belongs to.
#[derive(Debug, Clone, PartialEq)]
pub enum Solid {
    /// A side profile drawn out to both sides, such as a car's body.
    Prism(Prism),
    /// A straight rod or a disc.
    Cylinder(Cylinder),
    /// An ellipsoid of revolution about the vertical, such as a crown or a head.
    Spheroid(Spheroid),
}

/// A convex profile in the x-z plane, drawn out along y; the width changes evenly from the bottom to the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Prism {
    /// Corners x, z of the profile in metres, counter-clockwise when x points right and z up.
    pub profile_m: Vec<[f32; 2]>,
    /// Middle of the width in metres.
    pub center_y_m: f32,
    /// Half of the width at the lowest corner, in metres.
    pub bottom_half_width_m: f32,
    /// Half of the width at the highest corner, in metres.
    pub top_half_width_m: f32,
}

/// A straight cylinder with flat ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// Middle of one end in metres.
    pub from_m: [f32; 3],
    /// Middle of the other end in metres.
    pub to_m: [f32; 3],
    /// Radius in metres.
    pub radius_m: f32,
}

/// An ellipsoid of revolution about the vertical.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spheroid {
    /// Centre in metres.
    pub center_m: [f32; 3],
    /// Horizontal radius in metres.
    pub horizontal_radius_m: f32,
    /// Vertical radius in metres.
    pub vertical_radius_m: f32,
}

impl Prism {
    /// Whether every corner of the profile turns left, as it must: of a hollow profile only the part that all edges
    /// can see would be solid.
    pub fn is_convex(&self) -> bool {
        let n = self.profile_m.len();
        (0..n).all(|corner| {
            let [a, b, c] = [0, 1, 2].map(|step| self.profile_m[(corner + step) % n]);
            (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) > 0.0
        })
    }
}

impl Solid {
    /// A box from `least` to `greatest` (x, y, z in metres).
    pub fn cuboid(least_m: [f32; 3], greatest_m: [f32; 3]) -> Self {
        let [x0, y0, z0] = least_m;
        let [x1, y1, z1] = greatest_m;
        let half_width_m = (y1 - y0) / 2.0;
        Self::Prism(Prism {
            profile_m: vec![[x0, z0], [x1, z0], [x1, z1], [x0, z1]],
            center_y_m: f32::midpoint(y0, y1),
            bottom_half_width_m: half_width_m,
            top_half_width_m: half_width_m,
        })
    }

    /// A cylinder.
    pub fn cylinder(from_m: [f32; 3], to_m: [f32; 3], radius_m: f32) -> Self {
        Self::Cylinder(Cylinder { from_m, to_m, radius_m })
    }

    /// An upright spheroid.
    pub fn spheroid(center_m: [f32; 3], horizontal_radius_m: f32, vertical_radius_m: f32) -> Self {
        Self::Spheroid(Spheroid { center_m, horizontal_radius_m, vertical_radius_m })
    }

    /// The solid at `world_from_object`. Spheroids stay upright whatever the pose.
    pub fn placed(&self, world_from_object: &Pose) -> PlacedSolid {
        match self {
            Self::Prism(prism) => placed_prism(prism, world_from_object),
            Self::Cylinder(cylinder) => {
                let from = *world_from_object * Vector::from(cylinder.from_m);
                let to = *world_from_object * Vector::from(cylinder.to_m);
                placed_cylinder(from, to, cylinder.radius_m)
            }
            Self::Spheroid(it) => {
                let center = *world_from_object * Vector::from(it.center_m);
                let radii = Vector::new(it.horizontal_radius_m, it.horizontal_radius_m, it.vertical_radius_m);
                let bounds = Aabb::new(center - radii, center + radii);
                PlacedSolid { form: Form::Spheroid { center, radii }, bounds }
            }
        }
    }
}

/// A solid at its position in the world.
#[derive(Debug, Clone)]
pub struct PlacedSolid {
    form: Form,
    bounds: Aabb,
}

#[derive(Debug, Clone)]
enum Form {
    /// The inside of all these planes.
    Planes(Box<[Plane]>),
    /// `axis` is a unit vector.
    Cylinder {
        center: Vector,
        axis: Vector,
        half_length: f32,
        radius: f32,
    },
    Spheroid {
        center: Vector,
        radii: Vector,
    },
}

/// Points p with `normal`·p ≤ `offset` are inside.
#[derive(Debug, Clone, Copy)]
struct Plane {
    normal: Vector,
    offset: f32,
}

/// The part of a ray inside a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Distance to where the ray enters, in lengths of its direction; negative if it starts inside.
    pub enter: f32,
    /// Distance to where it leaves.
    pub exit: f32,
    /// Outward unit normal where it enters.
    pub enter_normal: Vector,
}

impl PlacedSolid {
    /// The upright box around it.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Where `ray` passes through, if it does so ahead of its origin.
    pub fn crossing(&self, ray: &Ray) -> Option<Crossing> {
        let crossing = match &self.form {
            Form::Planes(planes) => planes_crossing(planes, ray),
            Form::Cylinder { center, axis, half_length, radius } => {
                cylinder_crossing(ray.origin - *center, ray.dir, *axis, [*half_length, *radius])
            }
            Form::Spheroid { center, radii } => spheroid_crossing(ray.origin - *center, ray.dir, *radii),
        };
        crossing.filter(|it| it.exit > 0.0)
    }
}

fn placed_prism(prism: &Prism, world_from_object: &Pose) -> PlacedSolid {
    let heights = || prism.profile_m.iter().map(|corner| corner[1]);
    let bottom = heights().fold(f32::INFINITY, f32::min);
    let top = heights().fold(f32::NEG_INFINITY, f32::max);
    let widening = (prism.top_half_width_m - prism.bottom_half_width_m) / (top - bottom).max(1e-6);
    let half_width_at = |z: f32| prism.bottom_half_width_m + (z - bottom) * widening;

    let mut bounds = Aabb::new_invalid();
    for &[x, z] in &prism.profile_m {
        for side in [-1.0, 1.0] {
            let corner = Vector::new(x, prism.center_y_m + side * half_width_at(z), z);
            bounds.take_point(*world_from_object * corner);
        }
    }
    let placed = |inward: Vector, outward_normal: Vector| {
        let normal = world_from_object.rotation * outward_normal.normalize();
        Plane { normal, offset: normal.dot(*world_from_object * inward) }
    };
    let next_corners = prism.profile_m.iter().cycle().skip(1);
    let mut planes: Vec<Plane> = prism
        .profile_m
        .iter()
        .zip(next_corners)
        .map(|(&[x, z], &[next_x, next_z])| {
            placed(Vector::new(x, prism.center_y_m, z), Vector::new(next_z - z, 0.0, x - next_x))
        })
        .collect();
    for side in [-1.0, 1.0] {
        let on_side = Vector::new(0.0, prism.center_y_m + side * prism.bottom_half_width_m, bottom);
        planes.push(placed(on_side, Vector::new(0.0, side, -widening)));
    }
    PlacedSolid { form: Form::Planes(planes.into()), bounds }
}

fn placed_cylinder(from: Vector, to: Vector, radius: f32) -> PlacedSolid {
    let length = (to - from).length();
    let axis = (to - from) / length;
    // A disc reaches radius * sqrt(1 - a²) along an axis of the world that makes the cosine a with its own.
    let reach = (Vector::ONE - axis * axis).max(Vector::ZERO).map(f32::sqrt) * radius;
    let bounds = Aabb::new(from.min(to) - reach, from.max(to) + reach);
    let form = Form::Cylinder { center: (from + to) / 2.0, axis, half_length: length / 2.0, radius };
    PlacedSolid { form, bounds }
}

fn planes_crossing(planes: &[Plane], ray: &Ray) -> Option<Crossing> {
    let mut crossing = Crossing { enter: f32::NEG_INFINITY, exit: f32::INFINITY, enter_normal: Vector::Z };
    for plane in planes {
        let outside_by = plane.normal.dot(ray.origin) - plane.offset;
        let approach = plane.normal.dot(ray.dir);
        if approach < 0.0 {
            let enter = -outside_by / approach;
            if enter > crossing.enter {
                crossing.enter = enter;
                crossing.enter_normal = plane.normal;
            }
        } else if approach > 0.0 {
            crossing.exit = crossing.exit.min(-outside_by / approach);
        } else if outside_by > 0.0 {
            return None;
        }
        if crossing.enter > crossing.exit {
            return None;
        }
    }
    Some(crossing)
}

fn cylinder_crossing(
    origin: Vector,
    direction: Vector,
    axis: Vector,
    [half_length, radius]: [f32; 2],
) -> Option<Crossing> {
    let (origin_along, direction_along) = (origin.dot(axis), direction.dot(axis));
    let origin_across = origin - axis * origin_along;
    let direction_across = direction - axis * direction_along;
    let mantle = roots(
        direction_across.length_squared(),
        origin_across.dot(direction_across),
        origin_across.length_squared() - radius * radius,
    )?;
    let ends = if direction_along == 0.0 {
        if origin_along.abs() > half_length {
            return None;
        }
        [f32::NEG_INFINITY, f32::INFINITY]
    } else {
        let one = (-half_length - origin_along) / direction_along;
        let other = (half_length - origin_along) / direction_along;
        [one.min(other), one.max(other)]
    };
    let exit = mantle[1].min(ends[1]);
    let (enter, enter_normal) = if mantle[0] > ends[0] {
        (mantle[0], (origin_across + direction_across * mantle[0]) / radius)
    } else {
        (ends[0], axis * -direction_along.signum())
    };
    (enter <= exit).then_some(Crossing { enter, exit, enter_normal })
}

fn spheroid_crossing(origin: Vector, direction: Vector, radii: Vector) -> Option<Crossing> {
    let (unit_origin, unit_direction) = (origin / radii, direction / radii);
    let [enter, exit] = roots(
        unit_direction.length_squared(),
        unit_origin.dot(unit_direction),
        unit_origin.length_squared() - 1.0,
    )?;
    let enter_normal = ((unit_origin + unit_direction * enter) / radii).normalize_or_zero();
    Some(Crossing { enter, exit, enter_normal })
}

/// Both solutions of a·t² + 2·b·t + c = 0 in ascending order; all of time if there is no motion and c is negative.
fn roots(a: f32, half_b: f32, c: f32) -> Option<[f32; 2]> {
    if a <= 1e-12 {
        return (c <= 0.0).then_some([f32::NEG_INFINITY, f32::INFINITY]);
    }
    // f64 because b² and a·c nearly cancel for thin things far away.
    let (a, half_b, c) = (f64::from(a), f64::from(half_b), f64::from(c));
    let discriminant = half_b * half_b - a * c;
    (discriminant >= 0.0).then(|| {
        let root = discriminant.sqrt();
        [((-half_b - root) / a) as f32, ((-half_b + root) / a) as f32]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ray along −x from x = 10 at `y`, `z`.
    #[track_caller]
    fn check(solid: &Solid, [y, z]: [f32; 2], expected_enter_and_exit_x: Option<[f32; 2]>) {
        let ray = Ray::new(Vector::new(10.0, y, z), Vector::new(-1.0, 0.0, 0.0));
        let crossing = solid.placed(&Pose::IDENTITY).crossing(&ray);
        let found = crossing.map(|it| [10.0 - it.enter, 10.0 - it.exit]);
        match (found, expected_enter_and_exit_x) {
            (None, None) => {}
            (Some(found), Some(expected)) => {
                assert!(
                    found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4),
                    "{found:?} {expected:?}"
                );
                let outward = crossing.unwrap().enter_normal.dot(ray.dir);
                assert!(outward < 0.0, "the normal looks along the ray");
            }
            _ => panic!("found {found:?}, expected {expected_enter_and_exit_x:?}"),
        }
    }

    #[test]
    fn a_box_is_entered_at_its_near_face() {
        let solid = Solid::cuboid([-1.0, -2.0, 0.0], [3.0, 2.0, 1.0]);
        check(&solid, [0.0, 0.5], Some([3.0, -1.0]));
        check(&solid, [2.1, 0.5], None);
        check(&solid, [0.0, 1.1], None);
    }

    #[test]
    fn a_prism_narrows_toward_the_top() {
        let solid = Solid::Prism(Prism {
            profile_m: vec![[-1.0, 0.0], [1.0, 0.0], [0.5, 1.0], [-0.5, 1.0]],
            center_y_m: 0.0,
            bottom_half_width_m: 1.0,
            top_half_width_m: 0.5,
        });
        check(&solid, [0.0, 0.5], Some([0.75, -0.75]));
        check(&solid, [0.74, 0.5], Some([0.75, -0.75]));
        check(&solid, [0.76, 0.5], None);
    }

    #[test]
    fn an_upright_cylinder_is_round() {
        let solid = Solid::cylinder([0.0, 0.0, 0.0], [0.0, 0.0, 2.0], 0.5);
        check(&solid, [0.3, 1.0], Some([0.4, -0.4]));
        check(&solid, [0.0, 2.1], None);
        check(&solid, [0.6, 1.0], None);
    }

    #[test]
    fn a_lying_cylinder_is_entered_at_its_end() {
        let solid = Solid::cylinder([-1.0, 0.0, 0.0], [2.0, 0.0, 0.0], 0.5);
        check(&solid, [0.3, 0.3], Some([2.0, -1.0]));
        check(&solid, [0.4, 0.4], None);
    }

    #[test]
    fn a_spheroid_has_two_radii() {
        let solid = Solid::spheroid([1.0, 0.0, 0.0], 2.0, 4.0);
        check(&solid, [0.0, 0.0], Some([3.0, -1.0]));
        check(&solid, [0.0, 3.9], Some([1.0 + 0.4444, 1.0 - 0.4444]));
        check(&solid, [0.0, 4.1], None);
    }

    #[test]
    fn what_lies_behind_the_origin_is_not_crossed() {
        let behind = Solid::cuboid([11.0, -1.0, -1.0], [12.0, 1.0, 1.0]);
        check(&behind, [0.0, 0.0], None);
    }

    #[test]
    fn bounds_hold_every_solid() {
        let solid = Solid::cylinder([0.0, 0.0, 0.0], [3.0, 4.0, 0.0], 1.0);
        let bounds = solid.placed(&Pose::IDENTITY).bounds();
        assert!((bounds.mins - Vector::new(-0.8, -0.6, -1.0)).length() < 1e-5);
        assert!((bounds.maxs - Vector::new(3.8, 4.6, 1.0)).length() < 1e-5);
    }
}
