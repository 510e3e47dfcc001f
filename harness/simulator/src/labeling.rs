//! Annotations of the objects that the pulses met.

use parry3d::math::{Pose, Vector};
use reports::vocabulary::class::Occlusion;

use super::angular_window::AngularWindow;
use super::object_shape::ObjectShape;
use super::portable_math;
use super::scan::{PulseEnd, Turn};
use super::sensor::SensorModel;
use super::solid::PlacedSolid;
use detector::OrientedBox;
use scans::annotation::Annotation;

/// An object that has at least one point.
#[derive(Debug, Clone)]
pub struct VisibleObject<'a> {
    /// Its number, which is also its track.
    pub object_idx: u32,
    /// Its form during the turn.
    pub shape: &'a ObjectShape,
    /// Its pose in the frame of the sensor.
    pub sensor_from_object: Pose,
    /// Its points, ascending.
    pub point_indices: Vec<u32>,
}

/// Labels one object.
pub fn annotation(object: VisibleObject<'_>, turn: &Turn, sensor: &SensorModel) -> Annotation {
    Annotation {
        class: object.shape.class,
        bounding_box: Some(bounding_box(object.shape, &object.sensor_from_object)),
        occlusion: occlusion(&object, turn, sensor),
        point_indices: object.point_indices,
        track: Some(object.object_idx),
        truncation: None,
    }
}

/// The least upright box with the object's heading around all of its parts.
fn bounding_box(shape: &ObjectShape, sensor_from_object: &Pose) -> OrientedBox {
    let ahead = sensor_from_object.rotation * Vector::X;
    let yaw_rad = portable_math::atan2(f64::from(ahead.y), f64::from(ahead.x));
    let (sine, cosine) = portable_math::sin_cos(yaw_rad);
    let axes = [
        Vector::new(cosine as f32, sine as f32, 0.0),
        Vector::new(-sine as f32, cosine as f32, 0.0),
        Vector::Z,
    ];
    let bounds = shape.bounds();
    let center = *sensor_from_object * bounds.center();
    let half_edges = [Vector::X, Vector::Y, Vector::Z]
        .map(|axis| sensor_from_object.rotation * (axis * bounds.half_extents().dot(axis)));
    let extent_m = |axis: Vector| 2.0 * half_edges.iter().map(|edge| edge.dot(axis).abs()).sum::<f32>();
    OrientedBox {
        center_m: center.into(),
        length_width_height_m: axes.map(extent_m),
        yaw_rad: yaw_rad as f32,
    }
}

/// About the largest number of firings of a beam that are looked at to estimate an occlusion.
const MOST_FIRINGS: usize = 60;

/// The share of pulses through the object that ended on other things before they reached it.
fn occlusion(object: &VisibleObject<'_>, turn: &Turn, sensor: &SensorModel) -> Option<Occlusion> {
    let solids: Vec<PlacedSolid> =
        object.shape.parts.iter().map(|part| part.solid.placed(&object.sensor_from_object)).collect();
    let window = AngularWindow::of(&solids);
    let n_firings = sensor.n_firings_per_turn as usize;
    let mut n_through = 0_u32;
    let mut n_hidden = 0_u32;
    for beam in turn.ends.chunks(n_firings) {
        if !window.may_meet(beam[0].ray.dir.z) {
            continue;
        }
        let firings = window.firings(n_firings);
        let stride = firings.len().div_ceil(MOST_FIRINGS).max(1);
        for firing in firings.step_by(stride) {
            let end = &beam[firing];
            let Some(enter_m) = enter_m(&solids, end) else { continue };
            n_through += 1;
            n_hidden += u32::from(end.range_m < enter_m && end.object_idx != Some(object.object_idx));
        }
    }
    // Points may all lie at the very rim, where the calibration of a beam decides.
    (n_through > 0).then(|| match n_hidden as f32 / n_through as f32 {
        share if share < 0.1 => Occlusion::None,
        share if share <= 0.5 => Occlusion::Partly,
        _ => Occlusion::Largely,
    })
}

/// Range at which a pulse would reach the object if nothing else were there.
fn enter_m(solids: &[PlacedSolid], end: &PulseEnd) -> Option<f32> {
    let enters_m = solids.iter().filter_map(|solid| solid.crossing(&end.ray)).map(|crossing| crossing.enter);
    enters_m.reduce(f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Material;
    use crate::solid::Solid;
    use parry3d::math::Rotation;
    use reports::vocabulary::class::AnnotationClass;

    #[test]
    fn the_box_of_a_turned_object_has_its_heading_and_size() {
        let body = Solid::cuboid([-2.0, -0.9, 0.0], [2.0, 0.9, 1.5]);
        let shape = ObjectShape::new(AnnotationClass::Car, [(body, Material::METAL)]);
        let pose = Pose::from_parts(Vector::new(10.0, 2.0, -1.7), Rotation::from_rotation_z(2.5));
        let found = bounding_box(&shape, &pose);
        assert!((found.yaw_rad - 2.5).abs() < 1e-5);
        let expected = [(found.center_m, [10.0, 2.0, -0.95]), (found.length_width_height_m, [4.0, 1.8, 1.5])];
        for (found, expected) in expected {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?}");
        }
    }
}
