//! Solid things at their positions, and the first of them that a pulse meets.

use parry3d::math::{Pose, Vector};
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::Ray;

use super::facade::PlacedFacade;
use super::material::{Material, PaneFate, Passage, pane_fate};
use super::object_shape::ObjectShape;
use super::portable_math;
use super::solid::PlacedSolid;

/// One thing a pulse may meet.
#[derive(Debug, Clone)]
pub struct Leaf {
    /// Its form and position.
    pub form: LeafForm,
    /// Its material.
    pub material: Material,
    /// The object it is part of; `None` for walls.
    pub object_idx: Option<u32>,
}

/// The form of a [`Leaf`].
#[derive(Debug, Clone)]
pub enum LeafForm {
    /// A convex solid.
    Solid(PlacedSolid),
    /// The street side of a house.
    Facade(PlacedFacade),
}

impl Leaf {
    /// The leaves of the parts of `shape`, object number `object_idx`, at its position.
    pub fn of_object(
        shape: &ObjectShape,
        world_from_object: &Pose,
        object_idx: u32,
    ) -> impl Iterator<Item = Self> {
        shape.parts.iter().map(move |part| Self {
            form: LeafForm::Solid(part.solid.placed(world_from_object)),
            material: part.material,
            object_idx: Some(object_idx),
        })
    }
}

/// Side of the cubes within which a pane does the same to all pulses, in metres.
const SPOT_M: f32 = 0.35;

/// Many leaves, arranged for casting rays.
#[derive(Debug, Clone)]
pub struct Scene {
    leaves: Vec<Leaf>,
    hierarchy: Bvh,
}

/// Where a pulse ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance in metres.
    pub range_m: f32,
    /// Cosine of the angle between the pulse and the surface normal, 0 to 1.
    pub cos_incidence: f32,
    /// Share of light that comes back, 0 to 1; 0 if the pulse was sent elsewhere.
    pub reflectivity: f32,
    /// The object that was hit; `None` for walls and ground.
    pub object_idx: Option<u32>,
    /// How the surface mirrors the pulse, if it does.
    pub mirror: Option<Mirror>,
}

/// A surface that mirrors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mirror {
    /// Its unit normal.
    pub normal: Vector,
    /// Share of light that it mirrors, there and back.
    pub share: f32,
}

/// Share of light that a pane mirrors, there and back.
const MIRRORED_BY_PANE: f32 = 0.1;

/// A pulse and the random stream for what it meets by chance.
#[derive(Debug, Clone, Copy)]
pub struct Pulse {
    /// Its way in the world; the direction is a unit vector, so that distances are metres.
    pub ray: Ray,
    /// Decides, together with the number of the leaf, whether panes and leaves are passed. Not drawn while casting,
    /// so that the order in which leaves are visited does not matter.
    pub rng: u32,
}

impl Hit {
    /// Signal that comes back to the sensor: reflectivity times cosine of incidence over squared range.
    pub fn signal_per_m2(&self) -> f32 {
        self.reflectivity * self.cos_incidence / (self.range_m * self.range_m)
    }
}

impl Scene {
    /// Arranges `leaves`.
    pub fn new(leaves: Vec<Leaf>) -> Self {
        let bounds: Vec<_> = leaves
            .iter()
            .map(|leaf| match &leaf.form {
                LeafForm::Solid(solid) => solid.bounds(),
                LeafForm::Facade(facade) => facade.bounds(),
            })
            .collect();
        let hierarchy = Bvh::from_leaves(BvhBuildStrategy::Binned, &bounds);
        Self { leaves, hierarchy }
    }

    /// The leaves, in the order given.
    pub fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }

    /// The first thing `pulse` meets within `max_range_m`.
    pub fn cast(&self, pulse: &Pulse, max_range_m: f32) -> Option<Hit> {
        let (leaf_idx, _) = self.hierarchy.cast_ray(&pulse.ray, max_range_m, |leaf_idx, nearest_m| {
            self.hit(leaf_idx, pulse).map(|hit| hit.range_m).filter(|range_m| *range_m < nearest_m)
        })?;
        self.hit(leaf_idx, pulse)
    }

    fn hit(&self, leaf_idx: u32, pulse: &Pulse) -> Option<Hit> {
        let leaf = &self.leaves[leaf_idx as usize];
        let (range_m, normal, material) = match &leaf.form {
            LeafForm::Facade(facade) => {
                let surface = facade.surface_hit(&pulse.ray)?;
                let material = if surface.is_pane { Material::GLASS } else { leaf.material };
                (surface.range_m, surface.normal, material)
            }
            LeafForm::Solid(solid) => {
                let crossing = solid.crossing(&pulse.ray)?;
                if let Passage::FreePath(mean_free_path_m) = leaf.material.passage {
                    return hit_inside(
                        leaf,
                        chance(pulse.rng, leaf_idx),
                        mean_free_path_m,
                        [crossing.enter, crossing.exit],
                    );
                }
                (crossing.enter, crossing.enter_normal, leaf.material)
            }
        };
        let hit = hit_on(range_m, cos_incidence(&pulse.ray, normal), material, leaf.object_idx)?;
        if material.passage != Passage::Pane {
            return Some(hit);
        }
        // The spot on a pane decides, not the pulse: reflections and blinds are larger than a beam.
        let spot = spot_number(pulse.ray.point_at(range_m));
        match pane_fate(chance(spot, leaf_idx), hit.cos_incidence) {
            PaneFate::Passed => None,
            PaneFate::Returned => Some(hit),
            PaneFate::Lost => Some(Hit { reflectivity: 0.0, ..hit }),
            PaneFate::Mirrored => {
                let mirror = Mirror { normal, share: MIRRORED_BY_PANE };
                Some(Hit { reflectivity: 0.0, mirror: Some(mirror), ..hit })
            }
        }
    }
}

fn cos_incidence(ray: &Ray, normal: Vector) -> f32 {
    (-ray.dir.dot(normal)).clamp(0.0, 1.0)
}

fn hit_on(range_m: f32, cos_incidence: f32, material: Material, object_idx: Option<u32>) -> Option<Hit> {
    let hit = Hit { range_m, cos_incidence, reflectivity: material.reflectivity, object_idx, mirror: None };
    (range_m > 0.0).then_some(hit)
}

fn hit_inside(leaf: &Leaf, chance: f32, mean_free_path_m: f32, [enter, exit]: [f32; 2]) -> Option<Hit> {
    let flown_m = (-portable_math::ln(f64::from(chance))) as f32 * mean_free_path_m;
    let range_m = enter.max(0.0) + flown_m;
    // Leaves stand at all angles: this is their mean cosine.
    let leaf_cosine = 0.5;
    hit_on(range_m, leaf_cosine, leaf.material, leaf.object_idx).filter(|_| range_m < exit)
}

/// A number that is equal for all positions within a cube of a few decimetres.
pub fn spot_number(position: Vector) -> u32 {
    let cell = (position * (1.0 / SPOT_M)).floor();
    let [x, y, z] = [cell.x, cell.y, cell.z].map(|it| it as i32 as u32);
    x.wrapping_mul(0x8da6_b343) ^ y.wrapping_mul(0xd816_3841) ^ z.wrapping_mul(0xcb1a_b31f)
}

/// Stands for the ground where [`chance`] asks for the number of a leaf.
pub const GROUND_LEAF: u32 = u32::MAX;

/// A number in (0, 1) that depends on both arguments and nothing else.
pub fn chance(rng: u32, leaf_idx: u32) -> f32 {
    let mut mixed = rng ^ leaf_idx.wrapping_mul(0x9e37_79b9);
    mixed = (mixed ^ (mixed >> 16)).wrapping_mul(0x7feb_352d);
    mixed = (mixed ^ (mixed >> 15)).wrapping_mul(0x846c_a68b);
    mixed ^= mixed >> 16;
    ((mixed >> 9) as f32 + 0.5) / (1 << 23) as f32
}

#[cfg(test)]
mod tests {
    use super::super::solid::Solid;
    use super::*;

    fn leaf(least_m: [f32; 3], greatest_m: [f32; 3], material: Material, object_idx: u32) -> Leaf {
        let solid = Solid::cuboid(least_m, greatest_m).placed(&Pose::IDENTITY);
        Leaf { form: LeafForm::Solid(solid), material, object_idx: Some(object_idx) }
    }

    /// Shares of 1,000 pulses along x that end at objects 0 and 1.
    fn shares(first: Material) -> [f32; 2] {
        let scene = Scene::new(vec![
            leaf([5.0, -1.0, -1.0], [6.0, 1000.0, 1.0], first, 0),
            leaf([8.0, -1.0, -1.0], [9.0, 1000.0, 1.0], Material::METAL, 1),
        ]);
        let mut n_hits = [0.0; 2];
        for rng in 0..1000 {
            let pulse = Pulse { ray: Ray::new(Vector::Y * rng as f32, Vector::X), rng };
            let hit = scene.cast(&pulse, 100.0).unwrap();
            n_hits[hit.object_idx.unwrap() as usize] += 0.001;
        }
        n_hits
    }

    #[test]
    fn a_solid_hides_what_is_behind_it() {
        assert!(shares(Material::METAL)[0] > 0.999);
    }

    #[test]
    fn a_pane_lets_some_pulses_through() {
        let [pane, behind] = shares(Material::GLASS);
        assert!((0.3..0.7).contains(&pane) && (0.3..0.7).contains(&behind), "{pane} {behind}");
    }

    #[test]
    fn a_pulse_ends_within_a_mean_free_path_of_leaves_with_probability_0_63() {
        let [leaves, _] = shares(Material::foliage(1.0));
        assert!((leaves - 0.632).abs() < 0.05, "{leaves}");
    }

    #[test]
    fn nothing_is_met_beyond_the_maximum() {
        let scene = Scene::new(vec![leaf([5.0, -1.0, -1.0], [6.0, 1.0, 1.0], Material::METAL, 0)]);
        let pulse = Pulse { ray: Ray::new(Vector::ZERO, Vector::X), rng: 0 };
        assert_eq!(scene.cast(&pulse, 4.9), None);
        assert_eq!(scene.cast(&pulse, 5.1).map(|hit| hit.range_m), Some(5.0));
    }
}
