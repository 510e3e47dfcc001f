//! Folders of scans in PCD, PLY, `.npy` and `.bin`.

use reports::vocabulary::class::AnnotationClass;
use scans::annotation::PointRegion;
use scans::dataset::Dataset;

use super::{check_damaged, open, try_open};
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

#[test]
fn scans_that_links_lead_nowhere_to_are_refused_by_name_or_skipped() {
    let workplace = drawn();
    for name in ["b.npy", "e.bin", "f.pcd"] {
        let path = workplace.path("drive").join(name);
        let _ = std::fs::remove_file(&path);
        std::os::unix::fs::symlink("/nowhere/annexed", &path).unwrap();
    }
    workplace.write("drive/labels/e.json", "[]");
    workplace.write("drive/labels/f.json", "[]");
    let parts =
        ["has 3 files that cannot be read: b.npy (a link to what is not there), e.bin (", "f.pcd (a link"];
    check_damaged(&workplace.path("drive"), &parts);
    workplace.refuse("run drive -d pca --no-rrd -o out", 3, &parts);
    let ended = workplace.succeed("run drive -d pca --no-rrd -o out -P matching.min_points=1 --skip-damaged");
    ended.check_stderr(&[
        "skipped scan drive/000001: cannot read \"drive/b.npy\"",
        "skipped scan drive/000005",
    ]);
    assert_eq!(
        workplace.json("out/manifest.json")["datasets"][0]["skipped_scans"].as_array().map(Vec::len),
        Some(3)
    );
    // A folder in which nothing is there is still one of scans.
    for name in ["a.bin", "c.pcd", "d.ply"] {
        std::fs::remove_file(workplace.path("drive").join(name)).unwrap();
    }
    for name in ["a", "c", "d"] {
        std::fs::remove_file(workplace.path(&format!("drive/labels/{name}.json"))).unwrap();
    }
    check_damaged(&workplace.path("drive"), &parts);
    // Nor are labels passed over that are not there.
    std::fs::remove_dir_all(workplace.path("drive/labels")).unwrap();
    std::os::unix::fs::symlink("/nowhere/labels", workplace.path("drive/labels")).unwrap();
    check_damaged(&workplace.path("drive"), &["drive/labels"]);
}

#[test]
fn labels_without_a_scan_are_refused_by_name_or_skipped() {
    let workplace = drawn();
    std::fs::remove_file(workplace.path("drive/d.ply")).unwrap();
    workplace.write("drive/labels/x.json", BOXES);
    // What is no labels may lie beside them.
    workplace.write("drive/labels/readme.txt", "Drawn by hand.\n");
    workplace.write("drive/labels/classes.json", "{\"car\": 1}");
    let parts = ["labels\" does not go with the scans: 2 label files have no scan: d.json, x.json; a scan"];
    check_damaged(&workplace.path("drive"), &parts);
    workplace.refuse("data check drive", 3, &parts);
    let ended = workplace.succeed("run drive -d pca --no-rrd -o out -P matching.min_points=1 --skip-damaged");
    ended.check_stderr(&["skipped \"x.json\" of \"drive\": it is the labels of a scan that is not there"]);
    assert_eq!(
        workplace.json("out/manifest.json")["datasets"][0]["skipped_scans"].as_array().map(Vec::len),
        Some(2)
    );
}

/// Copies of the scan `c.pcd` under these names.
fn named(names: &[&str]) -> (Workplace, Box<dyn Dataset>) {
    let workplace = Workplace::new();
    for name in names {
        workplace.write(&format!("own/{name}.pcd"), PCD);
    }
    let dataset = open(&workplace.path("own"));
    (workplace, dataset)
}

#[test]
fn scans_have_the_numbers_of_their_files() {
    let ids = |names: &[&str]| named(names).1.scan_ids().iter().map(ToString::to_string).collect::<Vec<_>>();
    assert_eq!(ids(&["000110", "000112"]), ["own/000110", "own/000112"]);
    assert_eq!(ids(&["1", "10", "2"]), ["own/000001", "own/000002", "own/000010"]);
    // Where a name is no number, or two are the same one, they are counted.
    assert_eq!(ids(&["000110", "b"]), ["own/000000", "own/000001"]);
    assert_eq!(ids(&["1", "01"]), ["own/000000", "own/000001"]);
    assert_eq!(ids(&["99999999999", "99999999998"]), ["own/000000", "own/000001"]);
    let (workplace, _) = named(&["000110", "000112"]);
    workplace.succeed("detect own --scan 110");
    workplace.refuse("detect own --scan 0", 2, &["it has 2 scans from own/000110 to own/000112"]);
}

#[test]
fn results_are_found_by_numbers_and_by_names_of_files() {
    let boxes = "center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad\n";
    let check = |scans: &[&str], results: &[&str], is_found: bool| {
        let (workplace, _) = named(scans);
        for name in results {
            workplace.write(&format!("found/{name}.csv"), boxes);
        }
        let run = "run own -d pca --detections deep=found --no-rrd -o out";
        let ended = workplace.run(run);
        assert_eq!(ended.exit_code == Some(0), is_found, "{scans:?} {results:?} {ended:#?}");
    };
    check(&["000110", "000112"], &["000110", "000112"], true);
    check(&["0000000110", "0000000112"], &["000110", "000112"], true);
    check(&["7", "8"], &["7", "8"], true);
    check(&["left", "right"], &["left", "right"], true);
    // Those of earlier versions have positions.
    check(&["left", "right"], &["000000", "000001"], true);
    check(&["000110", "000112"], &["000000", "000001"], true);
    check(&["000001", "000002"], &["000000", "000001"], false);
    check(&["000110", "000112"], &["000110"], false);
}

/// A street of a simulator as `.bin` with five columns, which nobody has to describe.
#[test]
fn a_fifth_column_changes_nothing() {
    let workplace = Workplace::new();
    let street = ["data", "simulate", "street-narrow", "--sensor", "vlp-16", "--simulated-scans", "2"];
    workplace.succeed(&(&street, "--to kitti-tracking -o four"));
    let scans = workplace.names();
    let scans = scans.iter().filter(|it| it.extension().is_some_and(|it| it == "bin"));
    crate::program::copy_folder(&workplace.path("four"), &workplace.path("five"));
    for scan in scans {
        let path = workplace.folder().join(scan);
        let bytes = std::fs::read(&path).unwrap();
        let (rows, _) = bytes.as_chunks::<16>();
        // So many that four columns divide them, too, and three do not.
        let rows = &rows[..rows.len() / 12 * 12 - 8];
        let five: Vec<u8> = rows
            .iter()
            .zip(0..)
            .flat_map(|(row, it): (_, u16)| [&row[..], &f32::from(it % 16).to_le_bytes()].concat())
            .collect();
        std::fs::write(&path, rows.as_flattened()).unwrap();
        workplace.write(&format!("five/{}", scan.strip_prefix("four").unwrap().display()), &five);
        for folder in ["four", "five"] {
            let name = scan.file_stem().unwrap().to_str().unwrap();
            let _ = std::fs::remove_file(
                workplace.path(&format!("{folder}/training/point_region/0000/{name}.u8")),
            );
        }
    }
    let (four, five) = (open(&workplace.path("four")), open(&workplace.path("five")));
    for scan_idx in 0..2 {
        let (four, five) = (four.read_scan(scan_idx).unwrap(), five.read_scan(scan_idx).unwrap());
        assert!(four.cloud.len() > 5000 && four.cloud.positions_m().eq(five.cloud.positions_m()));
        assert_eq!(four.cloud.intensity(), five.cloud.intensity());
        assert_eq!(four.annotations, five.annotations);
    }
    workplace.succeed("data check four").check_stdout(&["columns", "x,y,z,intensity, as the numbers look"]);
    workplace.succeed("data check five").check_stdout(&["x,y,z,intensity,_, as the numbers look"]);
    let said = "data check five --columns x,y,z,intensity,ring";
    workplace.succeed(said).check_stdout(&["x,y,z,intensity,ring, as you say"]);
    workplace.refuse(
        "run five --columns x,y,z,i",
        2,
        &["\"i\" is no column; columns are x, y, z, intensity"],
    );
    workplace.end_with("data check five --columns x,y,z", 3, &["are not a multiple of the 12 of a point"]);
    workplace.write("pcd/a.pcd", PCD);
    workplace.refuse("data check pcd --columns x,y,z", 2, &["--columns is for .bin and .npy files"]);
    workplace.refuse("detect pcd/a.pcd --columns x,y,z", 2, &["--columns is for .bin and .npy files"]);
    workplace.refuse("run street-narrow --columns x,y,z", 2, &["--columns is for .bin and .npy files"]);
    assert!(try_open(&workplace.path("pcd")).is_ok());
}
