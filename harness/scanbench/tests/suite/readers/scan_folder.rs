//! Folders of scans in PCD, PLY, `.npy` and `.bin`.

use reports::vocabulary::class::AnnotationClass;
use scans::annotation::PointRegion;

use super::{check_damaged, open};
use crate::program::Workplace;

/// Two points as text, and the same in the other formats.
const PCD: &str = "VERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n\
                   POINTS 2\nDATA ascii\n5 1 -1 0.5\n20 0 0 0.25\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
                   property float intensity\nend_header\n5 1 -1 0.5\n20 0 0 0.25\n";
const BOXES: &str = r#"[{"class": "Car", "center_m": [5, 1, -1], "length_width_height_m": [4, 2, 1.5], "yaw_rad": 0.1, "track": 7}]"#;

/// A folder with a scan of each kind.
pub fn drawn() -> Workplace {
    let workplace = Workplace::new();
    let rows: Vec<u8> =
        [5.0_f32, 1.0, -1.0, 0.5, 20.0, 0.0, 0.0, 0.25].iter().flat_map(|it| it.to_le_bytes()).collect();
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 4), }";
    let npy =
        [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), &rows].concat();
    for (name, content) in
        [("a.bin", &rows[..]), ("b.npy", &npy), ("c.pcd", PCD.as_bytes()), ("d.ply", PLY.as_bytes())]
    {
        workplace.write(&format!("drive/{name}"), content);
        workplace.write(&format!("drive/labels/{}.json", &name[..1]), BOXES);
    }
    workplace.write("drive/readme.txt", "not a scan");
    workplace
}

#[test]
fn scans_of_all_kinds_are_read_with_their_boxes() {
    let workplace = drawn();
    let dataset = open(&workplace.path("drive"));
    assert_eq!((dataset.description().format.as_str(), dataset.scan_ids().len()), ("scan-folder", 4));
    for scan_idx in 0..4 {
        let scan = dataset.read_scan(scan_idx).unwrap();
        assert!(scan.cloud.positions_m().eq([[5.0, 1.0, -1.0], [20.0, 0.0, 0.0]]), "{}", scan.id);
        assert_eq!(scan.cloud.intensity(), [0.5, 0.25]);
        let [car] = &scan.annotations[..] else { panic!("{:?}", scan.annotations) };
        assert_eq!((car.class, car.track, &car.point_indices[..]), (AnnotationClass::Car, Some(7), &[0][..]));
        assert_eq!(scan.point_regions, [PointRegion::Labeled; 2]);
    }
    std::fs::remove_dir_all(workplace.path("drive/labels")).unwrap();
    let scan = open(&workplace.path("drive")).read_scan(3).unwrap();
    assert_eq!((scan.annotations.len(), scan.point_regions), (0, vec![PointRegion::Outside; 2]));
    // A scan of its own, and one that nobody labelled.
    workplace.succeed("detect drive/d.ply -o clusters.csv");
    workplace.succeed("run drive -d pca --no-rrd").check_stderr(&["\"drive\" has no labels"]);
}

#[test]
fn scans_and_labels_that_do_not_go_together_are_listed_at_once() {
    let workplace = drawn();
    let rename = |from: &str, to: &str| std::fs::rename(workplace.path(from), workplace.path(to)).unwrap();
    rename("drive/labels/b.json", "drive/labels/x.json");
    rename("drive/labels/d.json", "drive/labels/y.json");
    check_damaged(
        &workplace.path("drive"),
        &["2 scans have no labels: b.npy, d.ply; 2 label files have no scan: x.json, y.json"],
    );
}

#[test]
fn what_is_missing_or_damaged_is_named() {
    let check = |name: &str, content: Option<&str>, parts: &[&str]| {
        let workplace = drawn();
        let path = workplace.path("drive").join(name);
        match content {
            Some(content) => std::fs::write(path, content).unwrap(),
            None => std::fs::remove_file(path).unwrap(),
        }
        check_damaged(&workplace.path("drive"), parts);
    };
    check("labels/b.json", None, &["labels\" does not go with the scans: 1 scan has no labels: b.npy"]);
    check("labels/b.json", Some("[{}]"), &["b.json", "is not a list of boxes"]);
    check(
        "labels/b.json",
        Some(&BOXES.replace("1.5", "0")),
        &["b.json\" has object 0 (\"Car\") whose height is 0 m: it must be above 0 and below 10000"],
    );
    let far = BOXES.replace("[5, 1, -1]", "[5, 1e12, -1]");
    check(
        "labels/b.json",
        Some(&far),
        &["b.json\" has object 0 (\"Car\") whose y is 1000000000000: it must be between"],
    );
    check("b.npy", Some(""), &["b.npy", "is not an .npy file"]);
    check("c.pcd", Some(&PCD.replace("POINTS 2", "POINTS 3")), &["c.pcd", "announces 3 points but has 2"]);
    check("d.ply", Some(&PLY[..40]), &["d.ply", "header without end"]);
    check(
        "d.ply",
        Some(&PLY.replace("vertex 2", "vertex 0")),
        &["d.ply", "announces no vertices, but has lines"],
    );
    check(
        "c.pcd",
        Some(&PCD.replace("POINTS 2", "POINTS 0")),
        &["c.pcd", "announces no points, but has lines"],
    );
}

#[test]
fn a_file_that_says_that_it_has_no_points_is_an_empty_scan() {
    let workplace = Workplace::new();
    let none = PCD.replace("WIDTH 2", "WIDTH 0").replace("POINTS 2", "POINTS 0");
    let header = &none[..none.find("ascii").unwrap()];
    let npy = "{'descr': '<f4', 'fortran_order': False, 'shape': (0, 4), }";
    let npy = [b"\x93NUMPY\x01\x00", &(npy.len() as u16).to_le_bytes()[..], npy.as_bytes()].concat();
    let ply = PLY.replace("vertex 2", "vertex 0");
    let ply = &ply[..ply.find("5 1").unwrap()];
    for (name, content) in [
        ("a.npy", npy),
        ("b.pcd", format!("{header}ascii\n").into_bytes()),
        ("c.pcd", format!("{header}binary\n").into_bytes()),
        ("d.pcd", format!("{header}binary_compressed\n").into_bytes()),
        ("e.ply", ply.as_bytes().to_vec()),
        ("f.ply", ply.replace("ascii", "binary_little_endian").into_bytes()),
        ("g.pcd", PCD.as_bytes().to_vec()),
    ] {
        workplace.write(&format!("drive/{name}"), &content);
        workplace.write(&format!("drive/labels/{}.json", &name[..1]), BOXES);
    }
    let dataset = open(&workplace.path("drive"));
    let n_points: Vec<usize> = (0..7).map(|it| dataset.read_scan(it).unwrap().cloud.len()).collect();
    assert_eq!(n_points, [0, 0, 0, 0, 0, 0, 2]);
    let checked = workplace.succeed("data check drive");
    checked.check_stdout(&["6 of 7 scans without a point that has a position, first drive/000000"]);
    assert!(!checked.stdout.contains("contain no point"), "{checked:#?}");
    // What says nothing of itself is half a file.
    workplace.write("drive/a.bin", "");
    workplace.write("drive/labels/a.json", BOXES);
    std::fs::remove_file(workplace.path("drive/a.npy")).unwrap();
    check_damaged(&workplace.path("drive"), &["a.bin", "has no points"]);
}
