//! Things at chosen positions on a level road with nothing else around, and scans of them.

use parry3d::math::{Pose, Vector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use scans::annotation::{LabeledScan, ScanId};

use super::ground::{Banks, CrossSection, Ground, Road};
use super::labeling::{VisibleObject, annotation};
use super::object_shape::ObjectShape;
use super::pulse_path::Surroundings;
use super::road_axis::{RoadAxis, RoadAxisShape};
use super::scan::{beam_errors, turn};
use super::scene::{Leaf, Scene};
use super::sensor::SensorModel;

/// A thing and where it stands: world from object, the sensor above the world's origin, which lies on the road.
#[derive(Debug, Clone, PartialEq)]
pub struct StagedObject {
    /// Its form.
    pub shape: ObjectShape,
    /// Its position.
    pub world_from_object: Pose,
}

/// How far the level road reaches, in metres: farther than a sensor sees.
const REACH_M: f32 = 200.0;

/// Takes one scan of `objects`, with the noise that `seed` draws. Their tracks are their indices in the list; those
/// without a point are not annotated.
pub fn staged_scan(objects: &[StagedObject], sensor: &SensorModel, seed: u64) -> LabeledScan {
    let leaves =
        objects.iter().zip(0..).flat_map(|(it, idx)| Leaf::of_object(&it.shape, &it.world_from_object, idx));
    let surroundings = Surroundings {
        ground: &level_road(),
        standing: &Scene::new(leaves.collect()),
        moving: &Scene::new(Vec::new()),
        world_from_sensor: Pose::translation(0.0, 0.0, sensor.height_above_road_m),
        rain: None,
    };
    let errors = beam_errors(sensor, &mut ChaCha8Rng::seed_from_u64(seed));
    let turn = turn(sensor, &errors, &[surroundings], |beam| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        // Stream 0 has drawn the errors of the beams.
        rng.set_stream(1 + u64::from(beam));
        rng
    });
    let sensor_from_world = Pose::translation(0.0, 0.0, -sensor.height_above_road_m);
    let annotations = objects.iter().zip(0_u32..).filter_map(|(object, object_idx)| {
        let on_it = turn.objects.iter().zip(0..).filter(|(it, _)| **it == Some(object_idx));
        let point_indices: Vec<u32> = on_it.map(|(_, point_idx)| point_idx).collect();
        let sensor_from_object = sensor_from_world * object.world_from_object;
        let visible = VisibleObject { object_idx, shape: &object.shape, sensor_from_object, point_indices };
        (!visible.point_indices.is_empty()).then(|| annotation(visible, &turn, sensor))
    });
    let annotations = annotations.collect();
    LabeledScan::everywhere(ScanId { sequence: format!("staged-{seed}"), index: 0 }, turn.cloud, annotations)
}

/// A pose on the road: `plan_m` in front of and to the left of the sensor, turned counter-clockwise by sine and cosine.
pub fn on_the_road(plan_m: [f32; 2], [sine, cosine]: [f32; 2]) -> Pose {
    let ahead = Vector::new(cosine, sine, 0.0);
    let left = Vector::new(-sine, cosine, 0.0);
    let rotation = super::world::rotation_from_axes(ahead, left, Vector::Z);
    Pose::from_parts(Vector::new(plan_m[0], plan_m[1], 0.0), rotation)
}

/// A level plain as far as any sensor sees.
pub fn level_road() -> Ground {
    let axis = RoadAxis::new(&RoadAxisShape::straight([-REACH_M, REACH_M]));
    let section =
        CrossSection { left_kerb_m: REACH_M, right_kerb_m: REACH_M, crown: 0.0, kerb_height_m: 0.0 };
    Ground {
        roads: vec![Road { axis, section, banks: Banks::LEVEL }],
        pavement_width_m: 1.0,
        corner_radius_m: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::furniture_shape::bin;

    #[test]
    fn a_thing_is_seen_where_it_was_put_and_nothing_else_is_there() {
        let sensor = SensorModel { carrier_roof: None, ..SensorModel::hdl_64e_s2() };
        let shape = bin(&mut ChaCha8Rng::seed_from_u64(1));
        let at = |plan_m| StagedObject {
            shape: shape.clone(),
            world_from_object: on_the_road(plan_m, [0.0, 1.0]),
        };
        let objects = [at([8.0, 3.0]), at([-5.0, 0.0])];
        let scan = staged_scan(&objects, &sensor, 4);
        let positions_m: Vec<[f32; 2]> = scan
            .annotations
            .iter()
            .map(|it| [0, 1].map(|axis| it.bounding_box.unwrap().center_m[axis]))
            .collect();
        assert_eq!(scan.annotations.iter().map(|it| it.track).collect::<Vec<_>>(), [Some(0), Some(1)]);
        for (found, expected) in positions_m.iter().zip([[8.0, 3.0], [-5.0, 0.0]]) {
            assert!(
                (found[0] - expected[0]).abs() < 1e-3 && (found[1] - expected[1]).abs() < 1e-3,
                "{positions_m:?}"
            );
        }
        let mut is_on_object = vec![false; scan.cloud.len()];
        for &point_idx in scan.annotations.iter().flat_map(|it| &it.point_indices) {
            is_on_object[point_idx as usize] = true;
        }
        for (position_m, _) in
            scan.cloud.positions_m().zip(is_on_object).filter(|(_, is_on_object)| !is_on_object)
        {
            assert!((position_m[2] + sensor.height_above_road_m).abs() < 0.3, "{position_m:?} is no road");
        }
    }

    #[test]
    fn the_seed_draws_the_noise_and_nothing_else_does() {
        let sensor = SensorModel { n_firings_per_turn: 100, ..SensorModel::hdl_64e_s2() };
        let scan = |seed| staged_scan(&[], &sensor, seed);
        assert_eq!(scan(1), scan(1));
        assert_ne!(scan(1).cloud, scan(2).cloud);
        assert!(scan(1).annotations.is_empty());
    }
}
