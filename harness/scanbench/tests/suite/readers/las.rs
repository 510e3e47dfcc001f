//! LAS and LAZ in folders of scans, with labels on a map.

use reports::vocabulary::class::AnnotationClass;

use super::made::las_file;
use super::{check_damaged, open};
use crate::program::Workplace;

/// Points of a drawn hill, in centimetres from the offset.
fn hill(n_points: i32) -> Vec<[i32; 3]> {
    (0..n_points).map(|it| [it * 7 % 4000 - 2000, it * 13 % 3000 - 1500, it % 200]).collect()
}

/// A folder with each kind of file.
pub fn drawn() -> Workplace {
    let workplace = Workplace::new();
    for (number, (format, is_compressed)) in
        [(0, false), (0, true), (6, false), (6, true)].into_iter().enumerate()
    {
        let name = format!("drive/{number}.{}", if is_compressed { "laz" } else { "las" });
        workplace.write(&name, &las_file(&hill(2000), [0.0; 3], format, is_compressed));
    }
    workplace
}

#[test]
fn compressed_and_plain_points_are_the_same() {
    let workplace = drawn();
    let dataset = open(&workplace.path("drive"));
    assert_eq!(dataset.description().format, "scan-folder");
    for scan_idx in 0..4 {
        let scan = dataset.read_scan(scan_idx).unwrap();
        assert_eq!(scan.cloud.len(), 2000);
        for (found, expected) in scan.cloud.positions_m().zip(hill(2000)) {
            assert!(
                (0..3).all(|axis| (found[axis] - expected[axis] as f32 * 0.01).abs() < 1e-4),
                "{found:?}"
            );
        }
        assert!((scan.cloud.intensity()[7] - 1000.0 / 65535.0).abs() < 1e-6);
    }
    workplace.succeed("detect drive/1.laz --sensor-height 0");
}

#[test]
fn points_and_labels_on_a_map_move_together() {
    let workplace = Workplace::new();
    let offset_m = [691_000.0, 5_336_000.0, 520.0];
    workplace.write(
        "map/labels/0.json",
        r#"[{"class": "car", "center_m": [691010.0, 5336005.0, 521.0],
        "length_width_height_m": [8.0, 8.0, 4.0], "yaw_rad": 0.0}]"#,
    );
    workplace.write("map/0.laz", &las_file(&hill(2000), offset_m, 6, true));
    let dataset = open(&workplace.path("map"));
    let pose = dataset.world_from_sensor(0).unwrap().unwrap();
    let origin = pose.translation.vector;
    assert_eq!([origin.x, origin.y, origin.z], [691_000.0, 5_336_000.0, 520.0]);
    let scan = dataset.read_scan(0).unwrap();
    let car = &scan.annotations[0];
    assert_eq!(car.class, AnnotationClass::Car);
    assert_eq!(car.bounding_box.unwrap().center_m, [10.0, 5.0, 1.0]);
    let inside =
        hill(2000).into_iter().filter(|[x, y, _]| (x - 1000).abs() <= 400 && (y - 500).abs() <= 400).count();
    assert!(
        inside > 50 && car.point_indices.len().abs_diff(inside) < 5,
        "{} {inside}",
        car.point_indices.len()
    );
}

#[test]
fn what_is_cut_off_is_named() {
    for (format, is_compressed) in [(0, true), (6, true), (0, false)] {
        let workplace = Workplace::new();
        let mut bytes = las_file(&hill(2000), [0.0; 3], format, is_compressed);
        bytes.truncate(bytes.len() - 100);
        workplace.write("drive/0.las", &bytes);
        check_damaged(&workplace.path("drive"), &["0.las"]);
        bytes.truncate(1000);
        workplace.write("drive/0.las", &bytes);
        check_damaged(&workplace.path("drive"), &["0.las"]);
    }
}
