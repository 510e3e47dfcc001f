//! A drive as a scene of nuScenes.

use std::path::Path;

use detector::PointCloud;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use scans::dataset::Dataset;
use serde_json::{Value, json};

use super::{boxed, scans, write};

fn token(kind: u32, number: usize) -> String {
    format!("{kind:08x}{number:024x}")
}

/// Where the car of [`nuscenes`] was at a scan, or between two.
fn world_from_car(number: f64) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, 0.7 + 0.1 * number);
    Isometry3::from_parts(Translation3::new(1000.0 + 5.0 * number, 600.0, 2.0), turn)
}

/// Where its lidar is, with x to the right and y forward.
fn car_from_lidar() -> Isometry3<f64> {
    let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, -std::f64::consts::FRAC_PI_2);
    Isometry3::from_parts(Translation3::new(0.94, 0.0, 1.84), turn)
}

fn pose(isometry: &Isometry3<f64>) -> (Value, Value) {
    let turn = isometry.rotation;
    let at = isometry.translation.vector;
    (json!([at.x, at.y, at.z]), json!([turn.w, turn.i, turn.j, turn.k]))
}

const CATEGORIES: [&str; 5] =
    ["vehicle.car", "vehicle.truck", "human.pedestrian.adult", "vehicle.bicycle", "animal"];

/// The tables that are the same for all scans, with a camera as well.
fn fixed_tables(table: &impl Fn(&str, Vec<Value>)) {
    let (translation, rotation) = pose(&car_from_lidar());
    let numbered = |names: &[&str], row: &dyn Fn(usize, &str) -> Value| -> Vec<Value> {
        names.iter().enumerate().map(|(number, name)| row(number, name)).collect()
    };
    let channels = ["CAM_FRONT", "LIDAR_TOP"];
    let modality = ["camera", "lidar"];
    table(
        "sensor",
        numbered(
            &channels,
            &|it, name| json!({"token": token(1, it), "channel": name, "modality": modality[it]}),
        ),
    );
    table(
        "calibrated_sensor",
        numbered(&channels, &|it, _| {
            json!({"token": token(2, it), "sensor_token": token(1, it), "translation": translation,
                "rotation": rotation, "camera_intrinsic": []})
        }),
    );
    table("log", vec![json!({"token": token(3, 0), "vehicle": "n015", "location": "street"})]);
    let scene =
        json!({"token": token(4, 0), "log_token": token(3, 0), "name": "scene-0061", "nbr_samples": 3});
    table("scene", vec![scene]);
    let levels = ["v0-40", "v40-60", "v60-80", "v80-100"];
    let visibility = |it: usize, level: &str| json!({"token": (it + 1).to_string(), "level": level});
    table("visibility", numbered(&levels, &visibility));
    let named = |kind| move |it, name: &str| json!({"token": token(kind, it), "name": name});
    table("attribute", numbered(&["cycle.with_rider", "vehicle.parked"], &named(5)));
    table("category", numbered(&CATEGORIES, &named(6)));
}

/// Where the lidar was, with x forward and y left.
fn world_from_sensor_at(number: f64) -> Isometry3<f64> {
    world_from_car(number)
        * car_from_lidar()
        * Isometry3::rotation(Vector3::z() * std::f64::consts::FRAC_PI_2)
}

/// The file of points that are moved, if at all.
fn lidar_bytes(cloud: &PointCloud, moved: Option<Isometry3<f64>>) -> Vec<u8> {
    let at = |position_m: [f32; 3]| match &moved {
        None => position_m,
        Some(moved) => {
            let at_m = moved * nalgebra::Point3::from(position_m.map(f64::from));
            [at_m.x, at_m.y, at_m.z].map(|it| it as f32)
        }
    };
    let points = cloud.positions_m().map(at).zip(cloud.intensity());
    points.flat_map(|([x, y, z], i)| [-y, x, z, i * 255.0, 7.0]).flat_map(f32::to_le_bytes).collect()
}

/// The drive as a scene of nuScenes, with tables that name other sensors and scans between keyframes as well.
pub fn nuscenes(folder: &Path, dataset: &dyn Dataset) {
    let tables = folder.join("v1.0-mini");
    let table = |name: &str, rows: Vec<Value>| {
        write(&tables.join(format!("{name}.json")), serde_json::to_string_pretty(&rows).unwrap());
    };
    fixed_tables(&table);
    let (mut samples, mut sample_data, mut ego_poses) = (Vec::new(), Vec::new(), Vec::new());
    let (mut instances, mut annotations) = (Vec::new(), Vec::new());
    for (number, scan) in scans(dataset).iter().enumerate() {
        let time_us = 1_532_402_927_647_951_u64 + 500_000 * number as u64;
        samples.push(json!({"token": token(7, number), "scene_token": token(4, 0), "timestamp": time_us}));
        let world_from_sensor = world_from_sensor_at(number as f64);
        // Each keyframe is followed by what a sweep a fifth of a second later sees of the same points.
        for (sensor, is_key_frame) in [(0, true), (1, true), (1, false)] {
            let later = if is_key_frame { 0.0 } else { 0.4 };
            let time_us = time_us + (500_000.0 * later) as u64;
            let ego_pose = token(8, ego_poses.len());
            let (translation, rotation) = pose(&world_from_car(number as f64 + later));
            ego_poses.push(json!({"token": ego_pose, "timestamp": time_us, "translation": translation,
                "rotation": rotation}));
            let kind = ["CAM_FRONT/a.jpg", "LIDAR_TOP"][sensor];
            let filename =
                format!("{}/{kind}/{number}.pcd.bin", if is_key_frame { "samples" } else { "sweeps" });
            sample_data.push(json!({"token": token(9, sample_data.len()), "sample_token": token(7, number),
                "ego_pose_token": ego_pose, "calibrated_sensor_token": token(2, sensor), "timestamp": time_us,
                "fileformat": "pcd", "is_key_frame": is_key_frame, "filename": filename}));
            if sensor == 1 {
                let there = world_from_sensor_at(number as f64 + later).inverse() * world_from_sensor;
                let from = (!is_key_frame).then_some(there);
                write(&folder.join(filename), lidar_bytes(&scan.cloud, from));
            }
        }
        for (index, annotation) in boxed(scan).annotations.iter().enumerate() {
            let bounding_box = annotation.bounding_box.unwrap();
            let [x, y, z] = bounding_box.center_m.map(f64::from);
            let [length, width, height] = bounding_box.length_width_height_m;
            let in_sensor = Isometry3::from_parts(
                Translation3::new(x, y, z),
                UnitQuaternion::from_euler_angles(0.0, 0.0, f64::from(bounding_box.yaw_rad)),
            );
            let (translation, rotation) = pose(&(world_from_sensor * in_sensor));
            let category = index % CATEGORIES.len();
            instances
                .push(json!({"token": token(10, instances.len()), "category_token": token(6, category)}));
            annotations.push(json!({"token": token(11, annotations.len()), "sample_token": token(7, number),
                "instance_token": token(10, instances.len() - 1), "visibility_token": (index % 4 + 1).to_string(),
                "attribute_tokens": if category == 3 { vec![token(5, 0)] } else { vec![] },
                "translation": translation, "size": [width, length, height], "rotation": rotation,
                "num_lidar_pts": annotation.point_indices.len(), "num_radar_pts": 0, "prev": "", "next": ""}));
        }
    }
    table("sample", samples);
    table("sample_data", sample_data);
    table("ego_pose", ego_poses);
    table("instance", instances);
    table("sample_annotation", annotations);
}
