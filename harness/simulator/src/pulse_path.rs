//! The way of a single pulse: roof of the own car, street, mirrors.

use parry3d::math::Pose;
use parry3d::query::Ray;

use super::ground::Ground;
use super::rain::Rain;
use super::scene::{GROUND_LEAF, Hit, Mirror, Pulse, Scene, chance};
use super::sensor::{CarrierRoof, SensorModel};

/// Surroundings of the sensor during a turn.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'a> {
    /// Roads and pavement.
    pub ground: &'a Ground,
    /// Things that never move.
    pub standing: &'a Scene,
    /// Moving things, at their present positions.
    pub moving: &'a Scene,
    /// Pose of the sensor.
    pub world_from_sensor: Pose,
    /// The rain, if any.
    pub rain: Option<Rain>,
}

/// Where a pulse sent along `ray` (sensor frame, unit direction) ends within the sensor's range.
///
/// `rng` decides chance events on the way. A pulse that a pane or wet ground mirrors ends on the next thing that it meets,
/// which appears to be behind the mirror: such a ghost belongs to no object.
pub fn first_hit(sensor: &SensorModel, surroundings: &Surroundings<'_>, ray: &Ray, rng: u32) -> Option<Hit> {
    if sensor.carrier_roof.is_some_and(|roof| is_shaded(&roof, ray)) {
        return None;
    }
    let pose = &surroundings.world_from_sensor;
    let pulse = Pulse { ray: Ray::new(*pose * ray.origin, pose.rotation * ray.dir), rng };
    let hit = street_hit(surroundings, &pulse, sensor.max_range_m)?;
    let ghost = hit.mirror.and_then(|mirror| ghost(surroundings, &pulse, &hit, mirror, sensor.max_range_m));
    // Of two echoes the stronger is reported. A pane that mirrors gives none of its own.
    let seen = ghost.filter(|ghost| ghost.signal_per_m2() >= hit.signal_per_m2()).unwrap_or(hit);
    Some(surroundings.rain.map_or(seen, |rain| rain.dimmed(seen)))
}

/// The first of ground and things that `pulse` meets.
fn street_hit(surroundings: &Surroundings<'_>, pulse: &Pulse, max_range_m: f32) -> Option<Hit> {
    let ground = surroundings.ground.cast(&pulse.ray, max_range_m).map(|it| {
        let hit = Hit {
            range_m: it.range_m - before_blades_m(pulse, it.grass_height_m),
            cos_incidence: (-pulse.ray.dir.dot(it.normal)).clamp(0.0, 1.0),
            reflectivity: it.reflectivity,
            object_idx: None,
            mirror: None,
        };
        let wet = |rain: Rain| rain.wet_ground(hit, pulse.ray.point_at(it.range_m), it.normal);
        surroundings.rain.map_or(hit, wet)
    });
    [surroundings.standing, surroundings.moving].into_iter().fold(ground, |nearest, scene| {
        let within_m = nearest.map_or(max_range_m, |hit| hit.range_m);
        scene.cast(pulse, within_m).or(nearest)
    })
}

/// How far before the ground a pulse ends on a blade of grass: any height up to that of the grass is as likely, and
/// a flat pulse passes it long before it would reach the ground.
fn before_blades_m(pulse: &Pulse, grass_height_m: f32) -> f32 {
    let least_fall = 0.03;
    grass_height_m * chance(pulse.rng, GROUND_LEAF) / (-pulse.ray.dir.z).max(least_fall)
}

fn ghost(
    surroundings: &Surroundings<'_>,
    pulse: &Pulse,
    mirrored_at: &Hit,
    mirror: Mirror,
    max_range_m: f32,
) -> Option<Hit> {
    let direction = pulse.ray.dir - mirror.normal * (2.0 * pulse.ray.dir.dot(mirror.normal));
    // A little off the mirror, so that it is not met again.
    let origin = pulse.ray.point_at(mirrored_at.range_m) + direction * 0.01;
    let reflected = Pulse { ray: Ray::new(origin, direction), rng: pulse.rng };
    let seen = street_hit(surroundings, &reflected, max_range_m - mirrored_at.range_m)?;
    Some(Hit {
        range_m: mirrored_at.range_m + seen.range_m,
        reflectivity: seen.reflectivity * mirror.share,
        object_idx: None,
        mirror: None,
        ..seen
    })
}

/// Whether a pulse (sensor frame) meets the roof of the car that carries the sensor.
fn is_shaded(roof: &CarrierRoof, ray: &Ray) -> bool {
    if ray.dir.z >= 0.0 {
        return false;
    }
    let at_roof = ray.point_at((roof.depth_below_sensor_m + ray.origin.z) / -ray.dir.z);
    (-roof.rear_m..roof.front_m).contains(&at_roof.x) && at_roof.y.abs() < roof.half_width_m
}

#[cfg(test)]
mod tests {
    use super::super::material::Material;
    use super::super::scene::{Leaf, LeafForm};
    use super::super::solid::Solid;
    use super::*;
    use parry3d::math::Vector;

    #[test]
    fn steep_beams_ahead_meet_the_own_roof() {
        let roof = SensorModel::hdl_64e_s2().carrier_roof.unwrap();
        let is_shaded = |toward| is_shaded(&roof, &Ray::new(Vector::ZERO, toward));
        assert!(is_shaded(Vector::new(0.9, 0.0, -0.43)));
        assert!(!is_shaded(Vector::new(0.0, 0.9, -0.43)));
        assert!(!is_shaded(Vector::new(1.0, 0.0, 0.1)));
    }

    #[test]
    fn pulses_end_on_blades_of_grass_at_any_height() {
        let down = Vector::new(0.8, 0.0, -0.6);
        let before_m = |rng| before_blades_m(&Pulse { ray: Ray::new(Vector::Z, down), rng }, 0.06);
        let heights_m: Vec<f32> = (0..200).map(|rng| before_m(rng) * 0.6).collect();
        let mean_m = heights_m.iter().sum::<f32>() / 200.0;
        assert!(heights_m.iter().all(|it| (0.0..0.0601).contains(it)), "{heights_m:?}");
        assert!((mean_m - 0.03).abs() < 0.004, "{mean_m}");
    }

    #[test]
    fn a_mirrored_pulse_appears_to_come_from_behind_the_pane() {
        let wall = Solid::cuboid([-9.0, 19.0, -50.0], [30.0, 20.0, 50.0]).placed(&Pose::IDENTITY);
        let leaf = Leaf { form: LeafForm::Solid(wall), material: Material::MASONRY, object_idx: Some(3) };
        let (standing, moving) = (Scene::new(vec![leaf]), Scene::new(Vec::new()));
        let ground = Ground { roads: Vec::new(), pavement_width_m: 0.0, corner_radius_m: 0.0 };
        let surroundings = Surroundings {
            ground: &ground,
            standing: &standing,
            moving: &moving,
            world_from_sensor: Pose::IDENTITY,
            rain: None,
        };
        let direction = Vector::new(1.0, 0.0, 0.0);
        let pulse = Pulse { ray: Ray::new(Vector::Z * 5.0, direction), rng: 0 };
        let mirror =
            Hit { range_m: 10.0, cos_incidence: 0.7, reflectivity: 0.0, object_idx: None, mirror: None };
        let diagonal = Mirror { normal: Vector::new(-1.0, 1.0, 0.0).normalize(), share: 0.1 };
        let seen = ghost(&surroundings, &pulse, &mirror, diagonal, 120.0).unwrap();
        assert!((seen.range_m - 29.0).abs() < 0.02, "{seen:?}");
        assert_eq!(seen.object_idx, None);
    }
}
