//! Data sets in the layouts of others, made of simulated scans and of drawn packets.

use std::fmt::Write as _;
use std::path::Path;

use harness::annotation::{LabeledScan, Occlusion};
use harness::conversion::convert::sheet_of;
use harness::dataset::Dataset;
use harness::dataset::catalogue::built_in_catalogue;
use harness::dataset::open::{OpenOptions, open_dataset};
use laz::laszip::LazVlrBuilder;
use laz::{LasZipCompressor, LazItemRecordBuilder, LazItemType};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use serde_json::{Value, json};

/// Scans of a simulated street, with few beams.
pub fn street(n_scans: u32) -> Box<dyn Dataset> {
    let options = OpenOptions {
        n_simulated_scans: Some(n_scans),
        sensor: Some("vlp-16".to_owned()),
        ..OpenOptions::default()
    };
    open_dataset("street-intersection", &options, &built_in_catalogue().unwrap()).unwrap()
}

pub fn scans(dataset: &dyn Dataset) -> Vec<LabeledScan> {
    (0..dataset.scan_ids().len()).map(|scan_idx| dataset.read_scan(scan_idx).unwrap()).collect()
}

pub fn write(path: &Path, content: impl AsRef<[u8]>) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, content).unwrap();
}

/// Only objects that have a box, with the points in it.
pub fn boxed(scan: &LabeledScan) -> LabeledScan {
    let mut scan = scan.clone();
    scan.annotations.retain(|it| it.bounding_box.is_some());
    scan
}

pub const DRIVE: &str = "2011_09_26/2011_09_26_drive_0001_sync";

/// The drive as KITTI's raw recordings have it: a tracklet for each box of each scan, and a car that drives north.
pub fn kitti_raw(folder: &Path, dataset: &dyn Dataset) {
    let scans = scans(dataset);
    let mut items = String::new();
    let mut n_items = 0;
    let mut times = String::new();
    for (number, scan) in scans.iter().enumerate() {
        let bytes: Vec<u8> = scan
            .cloud
            .positions_m()
            .zip(scan.cloud.intensity())
            .flat_map(|([x, y, z], i)| [x, y, z, *i])
            .flat_map(f32::to_le_bytes)
            .collect();
        write(&folder.join(format!("{DRIVE}/velodyne_points/data/{number:010}.bin")), bytes);
        let oxts = format!("{} 8.43 112.5 0.01 -0.02 1.5 {}", 49.0 + number as f64 * 1e-5, "0 ".repeat(24));
        write(&folder.join(format!("{DRIVE}/oxts/data/{number:010}.txt")), oxts);
        writeln!(times, "2011-09-26 13:02:25.{:09}", number * 100_000_000).unwrap();
        for annotation in &boxed(scan).annotations {
            let bounding_box = annotation.bounding_box.unwrap();
            let [x, y, z] = bounding_box.center_m.map(f64::from);
            let [length, width, height] = bounding_box.length_width_height_m.map(f64::from);
            let occlusion = match annotation.occlusion {
                None => "-1",
                Some(Occlusion::None) => "0",
                Some(Occlusion::Partly) => "1",
                Some(Occlusion::Largely) => "2",
            };
            let class = annotation.class.name();
            write!(
                items,
                "<item><objectType>{class}</objectType><h>{height}</h><w>{width}</w><l>{length}</l>\
                 <first_frame>{number}</first_frame><poses><count>1</count><item_version>2</item_version><item>\
                 <tx>{x}</tx><ty>{y}</ty><tz>{}</tz><rx>0</rx><ry>0</ry><rz>{}</rz><state>2</state>\
                 <occlusion>{occlusion}</occlusion><occlusion_kf>0</occlusion_kf><truncation>-1</truncation>\
                 </item></poses><finished>1</finished></item>\n",
                z - height / 2.0,
                bounding_box.yaw_rad
            )
            .unwrap();
            n_items += 1;
        }
    }
    let tracklets = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\" ?>\n<!DOCTYPE boost_serialization>\n\
         <boost_serialization signature=\"serialization::archive\" version=\"9\"><tracklets class_id=\"0\">\n\
         <count>{n_items}</count><item_version>1</item_version>{items}</tracklets></boost_serialization>\n"
    );
    write(&folder.join(format!("{DRIVE}/tracklet_labels.xml")), tracklets);
    write(&folder.join(format!("{DRIVE}/velodyne_points/timestamps.txt")), times);
    let day = folder.join("2011_09_26");
    write(&day.join("calib_velo_to_cam.txt"), "calib_time: x\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0 0 0\n");
    write(&day.join("calib_imu_to_velo.txt"), "calib_time: x\nR: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n");
    write(
        &day.join("calib_cam_to_cam.txt"),
        "corner_dist: 9.95e-02\nS_rect_02: 1242 375\nR_rect_00: 1 0 0 0 1 0 0 0 1\n\
         P_rect_02: 700 0 621 0 0 700 187 0 0 0 1 0\n",
    );
}

/// Lets the labels of a data set in one of KITTI's layouts hold all round.
pub fn write_sheet(folder: &Path, dataset: &dyn Dataset) {
    write(&folder.join("scanbench.json"), sheet_of(dataset.description()).to_json());
}

fn token(kind: u32, number: usize) -> String {
    format!("{kind:08x}{number:024x}")
}

/// Where the car of [`nuscenes`] was at a scan.
pub fn world_from_car(number: usize) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, 0.7 + 0.1 * number as f64);
    Isometry3::from_parts(Translation3::new(1000.0 + 5.0 * number as f64, 600.0, 2.0), turn)
}

/// Where its lidar is, with x to the right and y forward.
pub fn car_from_lidar() -> Isometry3<f64> {
    let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, -std::f64::consts::FRAC_PI_2);
    Isometry3::from_parts(Translation3::new(0.94, 0.0, 1.84), turn)
}

fn pose(isometry: &Isometry3<f64>) -> (Value, Value) {
    let turn = isometry.rotation;
    let at = isometry.translation.vector;
    (json!([at.x, at.y, at.z]), json!([turn.w, turn.i, turn.j, turn.k]))
}

/// The drive as a scene of nuScenes, with tables that name other sensors and scans between keyframes as well.
pub fn nuscenes(folder: &Path, dataset: &dyn Dataset) {
    let tables = folder.join("v1.0-mini");
    let table = |name: &str, rows: Vec<Value>| {
        write(&tables.join(format!("{name}.json")), serde_json::to_string_pretty(&rows).unwrap());
    };
    let (translation, rotation) = pose(&car_from_lidar());
    table(
        "sensor",
        vec![
            json!({"token": token(1, 0), "channel": "CAM_FRONT", "modality": "camera"}),
            json!({"token": token(1, 1), "channel": "LIDAR_TOP", "modality": "lidar"}),
        ],
    );
    table(
        "calibrated_sensor",
        (0..2)
            .map(|it| {
                json!({"token": token(2, it), "sensor_token": token(1, it),
        "translation": translation, "rotation": rotation, "camera_intrinsic": []})
            })
            .collect(),
    );
    table("log", vec![json!({"token": token(3, 0), "vehicle": "n015", "location": "street"})]);
    table(
        "scene",
        vec![json!({"token": token(4, 0), "log_token": token(3, 0), "name": "scene-0061", "nbr_samples": 3})],
    );
    let visibility = ["v0-40", "v40-60", "v60-80", "v80-100"];
    table(
        "visibility",
        visibility
            .iter()
            .enumerate()
            .map(|(it, level)| {
                json!({"token": (it + 1).to_string(),
        "level": level})
            })
            .collect(),
    );
    table(
        "attribute",
        vec![
            json!({"token": token(5, 0), "name": "cycle.with_rider"}),
            json!({"token": token(5, 1), "name": "vehicle.parked"}),
        ],
    );
    let categories = ["vehicle.car", "vehicle.truck", "human.pedestrian.adult", "vehicle.bicycle", "animal"];
    table(
        "category",
        categories
            .iter()
            .enumerate()
            .map(|(it, name)| json!({"token": token(6, it), "name": name}))
            .collect(),
    );
    let (mut samples, mut sample_data, mut ego_poses) = (Vec::new(), Vec::new(), Vec::new());
    let (mut instances, mut annotations) = (Vec::new(), Vec::new());
    for (number, scan) in scans(dataset).iter().enumerate() {
        let time_us = 1_532_402_927_647_951_u64 + 500_000 * number as u64;
        samples.push(json!({"token": token(7, number), "scene_token": token(4, 0), "timestamp": time_us}));
        let (translation, rotation) = pose(&world_from_car(number));
        ego_poses.push(json!({"token": token(8, number), "timestamp": time_us, "translation": translation,
            "rotation": rotation}));
        for (sensor, is_key_frame) in [(0, true), (1, true), (1, false)] {
            let kind = ["CAM_FRONT/a.jpg", "LIDAR_TOP"][sensor];
            let filename = format!("samples/{kind}/{number}.pcd.bin");
            sample_data.push(json!({"token": token(9, sample_data.len()), "sample_token": token(7, number),
                "ego_pose_token": token(8, number), "calibrated_sensor_token": token(2, sensor), "timestamp": time_us,
                "fileformat": "pcd", "is_key_frame": is_key_frame, "filename": filename}));
        }
        let bytes: Vec<u8> = scan
            .cloud
            .positions_m()
            .zip(scan.cloud.intensity())
            .flat_map(|([x, y, z], i)| [-y, x, z, i * 255.0, 7.0])
            .flat_map(f32::to_le_bytes)
            .collect();
        write(&folder.join(format!("samples/LIDAR_TOP/{number}.pcd.bin")), bytes);
        let ours = Isometry3::rotation(Vector3::z() * std::f64::consts::FRAC_PI_2);
        let world_from_sensor = world_from_car(number) * car_from_lidar() * ours;
        for (place, annotation) in boxed(scan).annotations.iter().enumerate() {
            let bounding_box = annotation.bounding_box.unwrap();
            let [x, y, z] = bounding_box.center_m.map(f64::from);
            let [length, width, height] = bounding_box.length_width_height_m;
            let in_sensor = Isometry3::from_parts(
                Translation3::new(x, y, z),
                UnitQuaternion::from_euler_angles(0.0, 0.0, f64::from(bounding_box.yaw_rad)),
            );
            let (translation, rotation) = pose(&(world_from_sensor * in_sensor));
            let category = place % categories.len();
            instances
                .push(json!({"token": token(10, instances.len()), "category_token": token(6, category)}));
            annotations.push(json!({"token": token(11, annotations.len()), "sample_token": token(7, number),
                "instance_token": token(10, instances.len() - 1), "visibility_token": (place % 4 + 1).to_string(),
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

/// How far a laser of [`packets`] sees, in steps of 2 mm.
pub fn steps_of(laser: usize, azimuth: usize) -> u16 {
    if (laser + azimuth / 100).is_multiple_of(11) { 0 } else { (2000 + 37 * laser + azimuth % 5000) as u16 }
}

/// Packets of so many columns in a row from this azimuth on, in hundredths of a degree: with the bytes at their ends, and so many
/// blocks of a column.
pub fn packets(first: usize, n_columns: usize, step: usize, n_banks: usize, last: [u8; 2]) -> Vec<Vec<u8>> {
    let columns: Vec<usize> = (0..n_columns).map(|it| (first + it * step) % 36_000).collect();
    let packet = |columns: &[usize]| {
        let mut bytes = Vec::with_capacity(1206);
        for &azimuth in columns {
            for bank in 0..n_banks {
                bytes.extend([0xeeff_u16, 0xddff][bank].to_le_bytes());
                bytes.extend((azimuth as u16).to_le_bytes());
                for place in 0..32 {
                    bytes.extend(steps_of(place + 32 * bank, azimuth).to_le_bytes());
                    bytes.push((azimuth % 256) as u8);
                }
            }
        }
        bytes.extend([0, 0, 0, 0]);
        bytes.extend(last);
        bytes
    };
    columns.chunks_exact(12 / n_banks).map(packet).collect()
}

/// The packet on the wire: to port 2368 of everybody.
pub fn datagram(payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0xff; 12];
    bytes.extend([8, 0, 0x45, 0]);
    bytes.extend((28 + payload.len() as u16).to_be_bytes());
    bytes.extend([0, 0, 0x40, 0, 64, 17, 0, 0, 192, 168, 1, 201, 255, 255, 255, 255]);
    bytes.extend(2368_u16.to_be_bytes());
    bytes.extend(2368_u16.to_be_bytes());
    bytes.extend((8 + payload.len() as u16).to_be_bytes());
    bytes.extend([0, 0]);
    bytes.extend(payload);
    bytes
}

/// A capture of packets that are 1.327 ms apart.
pub fn pcap(packets: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = vec![0xd4, 0xc3, 0xb2, 0xa1, 2, 0, 4, 0];
    bytes.extend([0; 8]);
    bytes.extend(65_535_u32.to_le_bytes());
    bytes.extend(1_u32.to_le_bytes());
    for (number, packet) in packets.iter().enumerate() {
        let frame = datagram(packet);
        let micros = 1327 * number as u32;
        for word in
            [1_600_000_000 + micros / 1_000_000, micros % 1_000_000, frame.len() as u32, frame.len() as u32]
        {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(frame);
    }
    bytes
}

/// The same as pcapng, with times in nanoseconds.
pub fn pcapng(packets: &[Vec<u8>]) -> Vec<u8> {
    let block = |kind: u32, body: &[u8]| {
        let length = (12 + body.len()) as u32;
        [&kind.to_le_bytes()[..], &length.to_le_bytes(), body, &length.to_le_bytes()].concat()
    };
    let mut bytes =
        block(0x0a0d_0d0a, &[0x4d, 0x3c, 0x2b, 0x1a, 1, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255]);
    bytes.extend(block(1, &[1, 0, 0, 0, 0, 0, 0, 0, 9, 0, 1, 0, 9, 0, 0, 0, 0, 0, 0, 0]));
    for (number, packet) in packets.iter().enumerate() {
        let frame = datagram(packet);
        let time_ns = 1_600_000_000_000_000_000_u64 + 1_327_000 * number as u64;
        let mut body = vec![0; 4];
        for word in [(time_ns >> 32) as u32, time_ns as u32, frame.len() as u32, frame.len() as u32] {
            body.extend(word.to_le_bytes());
        }
        body.extend(&frame);
        body.resize(body.len().next_multiple_of(4), 0);
        bytes.extend(block(6, &body));
    }
    bytes
}

/// A calibration of 64 lasers, drawn, in YAML.
pub fn calibration_of_64() -> String {
    let mut text = "distance_resolution: 0.002\nlasers:\n".to_owned();
    for id in 0..64 {
        writeln!(
            text,
            "- {{laser_id: {id}, vert_correction: {}, rot_correction: {}, dist_correction: {}, dist_correction_x: {}, \
             dist_correction_y: {}, vert_offset_correction: {}, horiz_offset_correction: {}, focal_distance: 10.0, \
             focal_slope: 1.0, min_intensity: 0, max_intensity: 255}}",
            0.035 - 0.0073 * f64::from(id),
            0.02 * f64::from(id % 5) - 0.04,
            1.0 + 0.01 * f64::from(id % 7),
            1.1 + 0.01 * f64::from(id % 3),
            1.05 + 0.01 * f64::from(id % 4),
            0.1 + 0.001 * f64::from(id),
            if id % 2 == 0 { 0.026 } else { -0.026 },
        )
        .unwrap();
    }
    text + "num_lasers: 64\n"
}

/// A file of version 1.4 with points of format 0, or 6 in layers, compressed or not.
pub fn las_file(points: &[[i32; 3]], offset_m: [f64; 3], format: u8, is_compressed: bool) -> Vec<u8> {
    let record_length = if format == 6 { 30 } else { 20 };
    let mut records = Vec::new();
    for point in points {
        let begin = records.len();
        records.extend(point.iter().flat_map(|it| it.to_le_bytes()));
        records.extend(1000_u16.to_le_bytes());
        records.push(if format == 6 { 0x11 } else { 9 });
        records.resize(begin + record_length, 0);
    }
    let (mut compression, mut data) = (Vec::new(), records.clone());
    if is_compressed {
        let mut items = LazItemRecordBuilder::new();
        items.add_item(if format == 6 { LazItemType::Point14 } else { LazItemType::Point10 });
        let vlr = LazVlrBuilder::new(items.build()).with_fixed_chunk_size(700).build();
        vlr.write_to(&mut compression).unwrap();
        // The table says where chunks begin from the beginning of the file on.
        let mut out = std::io::Cursor::new(vec![0; 375 + 54 + compression.len()]);
        out.set_position(out.get_ref().len() as u64);
        let mut compressor = LasZipCompressor::new(out, vlr).unwrap();
        compressor.compress_many(&records).unwrap();
        compressor.done().unwrap();
        data = compressor.into_inner().into_inner().split_off(375 + 54 + compression.len());
    }
    let mut bytes = vec![0; 375];
    bytes[..4].copy_from_slice(b"LASF");
    bytes[24..26].copy_from_slice(&[1, 4]);
    bytes[94..96].copy_from_slice(&375_u16.to_le_bytes());
    let n_before = 375 + if is_compressed { 54 + compression.len() } else { 0 };
    bytes[96..100].copy_from_slice(&(n_before as u32).to_le_bytes());
    bytes[100] = u8::from(is_compressed);
    bytes[104] = format | if is_compressed { 0x80 } else { 0 };
    bytes[105..107].copy_from_slice(&(record_length as u16).to_le_bytes());
    bytes[247..255].copy_from_slice(&(points.len() as u64).to_le_bytes());
    for axis in 0..3 {
        bytes[131 + 8 * axis..139 + 8 * axis].copy_from_slice(&0.01_f64.to_le_bytes());
        bytes[155 + 8 * axis..163 + 8 * axis].copy_from_slice(&offset_m[axis].to_le_bytes());
        let values = || points.iter().map(|it| f64::from(it[axis]) * 0.01 + offset_m[axis]);
        let (most, least) = (values().fold(f64::MIN, f64::max), values().fold(f64::MAX, f64::min));
        bytes[179 + 16 * axis..187 + 16 * axis].copy_from_slice(&most.to_le_bytes());
        bytes[187 + 16 * axis..195 + 16 * axis].copy_from_slice(&least.to_le_bytes());
    }
    if is_compressed {
        let mut head = vec![0; 54];
        head[2..16].copy_from_slice(b"laszip encoded");
        head[18..20].copy_from_slice(&22_204_u16.to_le_bytes());
        head[20..22].copy_from_slice(&(compression.len() as u16).to_le_bytes());
        bytes.extend(head);
        bytes.extend(compression);
    }
    bytes.extend(data);
    bytes
}
