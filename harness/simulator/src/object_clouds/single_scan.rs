//! Objects in one scan of a rotating sensor.

use std::f64::consts::TAU;

use detector::PointCloud;
use rand::RngExt;
use scans::object_cloud::growing_cloud::Moment;

use super::drawn_object::{ObjectNumber, StreamUse};
use super::lone_object::{LoneObject, Look, level_pose};
use crate::scan::beam_errors;
use crate::sensor::SensorModel;

/// How far the nearest part of an object is from the sensor, in metres; object n stands at the distance n modulo their
/// number.
pub const RANGES_M: [f32; 5] = [5.0, 8.0, 12.0, 18.0, 25.0];

/// The points of `object`, number `number`, in a scan of `sensor` that is about `range_m` away from its outline.
pub fn scanned_once(
    object: &LoneObject,
    number: ObjectNumber,
    sensor: &SensorModel,
    range_m: f32,
) -> (PointCloud, Moment) {
    let errors = beam_errors(sensor, &mut number.random_stream(StreamUse::Beams));
    let mut rng = number.random_stream(StreamUse::Viewpoint);
    let bearing_rad = rng.random_range(0.0..TAU);
    let distance_m = object.reach_m() + range_m;
    let world_from_sensor = level_pose(bearing_rad, distance_m, sensor, &mut rng);
    let sensor = SensorModel { carrier_roof: None, ..sensor.clone() };
    let pulses = |beam| number.random_stream(StreamUse::Pulses { scan: 0, beam });
    let mut cloud = PointCloud::default();
    object.append_points(&Look::from(world_from_sensor, &sensor, &errors), |_| true, pulses, &mut cloud);
    let moment = Moment { n_points: cloud.len(), time_s: 0.0, distance_m: Some(distance_m) };
    (cloud, moment)
}

#[cfg(test)]
mod tests {
    use super::*;
    use reports::vocabulary::partial_class::PartialClass;

    #[test]
    fn a_farther_object_has_fewer_points() {
        for class in PartialClass::LEARNT {
            let number = ObjectNumber { seed: 1, class, number: 3 };
            let object = LoneObject::new(&number.draw());
            for sensor in ["hdl-64e-s2", "os1-128"] {
                let sensor = SensorModel::embedded(sensor).unwrap();
                let n_points =
                    RANGES_M.map(|range_m| scanned_once(&object, number, &sensor, range_m).0.len());
                assert!(n_points[2] > n_points[4], "{class} {n_points:?}");
                // A tall object stands out of the field of view when it is near.
                let is_low = object.top_m() < sensor.height_above_road_m + 0.3;
                assert!(!is_low || n_points[0] > 2 * n_points[2], "{class} {n_points:?}");
            }
        }
    }

    #[test]
    fn points_lie_as_far_off_the_surface_as_the_noise_says() {
        use crate::material::Material;
        use crate::object_clouds::drawn_object::DrawnObject;
        use crate::object_shape::ObjectShape;
        use crate::solid::Solid;
        use reports::vocabulary::class::AnnotationClass;

        // A ball in the origin's axis: the way to its surface is the same from everywhere.
        let ball = Solid::spheroid([0.0, 0.0, 2.0], 1.5, 1.5);
        let shape = ObjectShape::new(AnnotationClass::Misc, [(ball, Material::MASONRY)]);
        let object = LoneObject::new(&DrawnObject { shape, yaw_rad: 0.0 });
        let number = ObjectNumber { seed: 1, class: PartialClass::Other, number: 0 };
        let sensor = SensorModel {
            range_noise_sigma_m: 0.03,
            beam_range_error_sigma_m: 0.0,
            beam_elevation_error_sigma_deg: 0.0,
            beam_azimuth_error_sigma_deg: 0.0,
            ..SensorModel::embedded("os1-128").unwrap()
        };
        let (cloud, moment) = scanned_once(&object, number, &sensor, 6.0);
        // Points that face the sensor: there the noise is along the normal.
        let distance_m = f64::from(moment.distance_m.unwrap());
        let toward_m: Vec<f64> = cloud
            .positions_m()
            .map(|it| it.map(f64::from))
            .filter_map(|[x, y, z]| {
                let radius = (x * x + y * y + (z - 2.0) * (z - 2.0)).sqrt();
                let bearing = number.random_stream(StreamUse::Viewpoint).random_range(0.0..TAU);
                let [sensor_x, sensor_y] = [bearing.cos() * distance_m, bearing.sin() * distance_m];
                let toward = (x * sensor_x + y * sensor_y) / (radius * distance_m);
                (toward > 0.98).then_some(radius - 1.5)
            })
            .collect();
        let n = toward_m.len() as f64;
        let mean = toward_m.iter().sum::<f64>() / n;
        let sigma = (toward_m.iter().map(|it| (it - mean) * (it - mean)).sum::<f64>() / n).sqrt();
        assert!(n > 150.0 && mean.abs() < 0.01, "{n} {mean}");
        assert!((sigma - 0.03).abs() < 0.005, "{sigma} of {n} points");
    }
}
