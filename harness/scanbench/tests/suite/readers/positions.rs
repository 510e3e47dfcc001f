//! Points without a position and points too far off, in every format.

use std::path::{Path, PathBuf};

use mcap::WriteOptions;

use super::recordings::{SECOND, cloud_at};
use super::{check_damaged, made, open};
use crate::drawn_dataset::DrawnDataset;
use crate::program::Workplace;

/// Where coordinates of a scan lie in a file: the file, the x of its first point, and bytes of a point.
struct CoordinateOffsets {
    path: PathBuf,
    first_x: usize,
    stride: usize,
}

impl CoordinateOffsets {
    /// Gives the x of a point another value.
    fn set(&self, point_idx: usize, x_m: f32) {
        let mut bytes = std::fs::read(&self.path).unwrap();
        let at = self.first_x + point_idx * self.stride;
        bytes[at..at + 4].copy_from_slice(&x_m.to_le_bytes());
        std::fs::write(&self.path, bytes).unwrap();
    }
}

fn offsets(path: PathBuf, first_x: usize, stride: usize) -> CoordinateOffsets {
    CoordinateOffsets { path, first_x, stride }
}

/// A `.pcd`, `.ply` and `.npy` of four points each, in a folder of its own.
fn scan_file(folder: &Path, extension: &str) -> CoordinateOffsets {
    let header = match extension {
        "pcd" => "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 4\nDATA binary\n".to_owned(),
        "ply" => {
            "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                  property float z\nend_header\n"
                .to_owned()
        }
        _ => {
            let description = "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 3)}";
            let length = char::from(description.len() as u8);
            format!("NUMPY\u{1}\u{0}{length}\u{0}{description}")
        }
    };
    let mut bytes = if extension == "npy" { vec![0x93] } else { Vec::new() };
    bytes.extend(header.bytes());
    let first_x = bytes.len();
    for x in [1.0_f32, 2.0, 3.0, 4.0] {
        bytes.extend([x, 0.5, -1.0].into_iter().flat_map(f32::to_le_bytes));
    }
    let path = folder.join(format!("scan.{extension}"));
    made::write(&path, bytes);
    offsets(path, first_x, 12)
}

/// Data sets of every format that can hold such points, whose first scan lies there.
fn data_sets(workplace: &Workplace) -> Vec<(PathBuf, CoordinateOffsets)> {
    let street = made::street(2);
    let root = |name: &str| workplace.path(name);
    let mut data_sets = Vec::new();
    let tracking = DrawnDataset::tracking(&root("tracking-of"), 2);
    data_sets
        .push((tracking.root.clone(), offsets(tracking.path("training/velodyne/0000/000000.bin"), 0, 16)));
    let objects = DrawnDataset::objects(&root("objects-of"), 2);
    data_sets.push((objects.root.clone(), offsets(objects.path("training/velodyne/000000.bin"), 0, 16)));
    workplace.succeed("data convert tracking-of/street --to semantic-kitti -o semantic");
    let semantic = root("semantic").join("sequences/0000/velodyne/000000.bin");
    data_sets.push((root("semantic"), offsets(semantic, 0, 16)));
    made::kitti_raw(&root("raw"), &*street);
    let raw = root("raw").join(format!("{}/velodyne_points/data/0000000000.bin", made::DRIVE));
    data_sets.push((root("raw"), offsets(raw, 0, 16)));
    made::nuscenes(&root("nuscenes"), &*street);
    // Its second coordinate points forward.
    data_sets.push((root("nuscenes"), offsets(root("nuscenes").join("samples/LIDAR_TOP/0.pcd.bin"), 4, 20)));
    for extension in ["pcd", "ply", "npy"] {
        let folder = root(extension);
        data_sets.push((folder.clone(), scan_file(&folder, extension)));
    }
    workplace.succeed("data convert tracking-of/street -o drive.mcap --compression none");
    let bytes = std::fs::read(root("drive.mcap")).unwrap();
    let first = std::fs::read(&data_sets[0].1.path).unwrap();
    let at = bytes.windows(16).position(|it| it == &first[..16]).unwrap();
    // A byte says of each point what its labels say.
    data_sets.push((root("drive.mcap"), offsets(root("drive.mcap"), at, 17)));
    data_sets
}

/// Chunks are written with a checksum, which is none where it is 0.
fn forget_checksums(path: &Path) {
    if path.extension().is_none_or(|it| it != "mcap") {
        return;
    }
    let mut bytes = std::fs::read(path).unwrap();
    let mut at = 8;
    while at + 9 < bytes.len() {
        let n = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        // Opcode and length, two times and a size come before it.
        if bytes[at] == 6 {
            bytes[at + 33..at + 37].fill(0);
        }
        at += 9 + n;
    }
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn one_rule_holds_in_every_format() {
    let workplace = Workplace::new();
    std::fs::create_dir_all(workplace.path("tracking-of")).unwrap();
    std::fs::create_dir_all(workplace.path("objects-of")).unwrap();
    for (root, offsets) in data_sets(&workplace) {
        let name = root.display();
        forget_checksums(&root);
        let sound = open(&root).read_scan(0).unwrap();
        assert!(sound.points_left_out.is_empty(), "{name}");
        offsets.set(1, f32::NAN);
        offsets.set(3, f32::NEG_INFINITY);
        let scan = open(&root).read_scan(0).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(scan.points_left_out, [1, 3], "{name}");
        assert_eq!(scan.cloud.len() + 2, sound.cloud.len(), "{name}");
        assert_eq!(scan.point_regions.len(), scan.cloud.len(), "{name}");
        // What was point 4 is point 2 now, whatever is said about it.
        let kept: Vec<usize> = (0..sound.cloud.len()).filter(|it| ![1, 3].contains(it)).collect();
        assert!(kept.iter().map(|it| sound.cloud.position_m(*it)).eq(scan.cloud.positions_m()), "{name}");
        assert!(
            kept.iter().map(|it| sound.point_regions[*it]).eq(scan.point_regions.iter().copied()),
            "{name}"
        );
        assert_eq!(scan.annotations.len(), sound.annotations.len(), "{name}");
        for (found, expected) in scan.annotations.iter().zip(&sound.annotations) {
            let found: Vec<usize> = found.point_indices.iter().map(|it| kept[*it as usize]).collect();
            let expected = expected.point_indices.iter().map(|it| *it as usize);
            assert!(expected.filter(|it| ![1, 3].contains(it)).eq(found), "{name}");
        }
        offsets.set(0, 12_000.0);
        let file = offsets.path.file_name().unwrap().to_str().unwrap().to_owned();
        // As the file has it: of nuScenes the second coordinate points forward.
        let axis = if root.ends_with("nuscenes") { "y" } else { "x" };
        let problem = format!("has point 0 at {axis} = 12000.000 m, beyond 10000 m from the origin");
        check_damaged(&root, &[&file, &problem]);
    }
}

#[test]
fn regions_and_objects_of_a_recording_stay_with_their_points() {
    let workplace = Workplace::new();
    let path = super::recordings::write(&workplace, WriteOptions::new(), &[cloud_at(SECOND)]);
    let scan = open(&path).read_scan(0).unwrap();
    assert_eq!((scan.cloud.len(), &scan.points_left_out[..]), (3, &[2][..]));
    workplace.succeed("data convert drive.mcap -o again.mcap");
    let again = open(&workplace.path("again.mcap")).read_scan(0).unwrap();
    assert_eq!((&again.cloud, &again.point_regions), (&scan.cloud, &scan.point_regions));
    assert!(again.points_left_out.is_empty());
}

/// A drive of which the first scan lacks three points.
fn drive() -> Workplace {
    let workplace = Workplace::new();
    let drawn = DrawnDataset::tracking(workplace.folder(), 3);
    let first = offsets(drawn.path("training/velodyne/0000/000000.bin"), 0, 16);
    for point_idx in [5, 6, 900] {
        first.set(point_idx, f32::NAN);
    }
    workplace
}

const SAID: &str =
    "warning: skipped 3 points without a position in 1 scans of \"street\", first in 0000/000000\n";

#[test]
fn every_verb_says_what_it_left_out() {
    let workplace = drive();
    for arguments in [
        "run street -d pca --no-rrd -o run",
        "ablation street -o ablation",
        "sweep street -d kd-tree -P kd_tree.tolerance_m=0.5:0.6:0.1 --no-rrd -o sweep",
        "selftest street",
        "boxes street -o boxes",
        "fit-density street -o curve.toml",
        "data convert street -o street.mcap",
        "data prelabel street --to kitti -o prelabel",
        "data realism street --against street -o realism",
    ] {
        let ended = workplace.run(arguments);
        // Some find too little to do in three drawn scans; what they read is said all the same.
        assert!(![Some(2), Some(101)].contains(&ended.exit_code), "{arguments:?}: {ended:#?}");
        ended.check_stderr(&[SAID]);
    }
    let manifest = workplace.json("run/manifest.json");
    assert_eq!(manifest["datasets"][0]["n_points_left_out"], 3);
    let ended = workplace.succeed("data check street");
    let line = ended.stdout.lines().find(|it| it.starts_with("no position")).unwrap();
    assert!(line.contains(" 3 of "), "{ended:#?}");
    // Nothing is said where nothing is left out.
    let sound = workplace.run("selftest prelabel --format kitti-object");
    assert!(!sound.stderr.contains("left out"), "{sound:#?}");
}

#[test]
fn clusters_have_an_entry_for_every_point_of_the_file() {
    let workplace = drive();
    let file = "street/training/velodyne/0000/000000.bin";
    let n_points = std::fs::metadata(workplace.path(file)).unwrap().len() as usize / 16;
    let whole = Workplace::new();
    DrawnDataset::tracking(whole.folder(), 3);
    for input in [&[file][..], &["street", "--scan", "0"]] {
        let arguments = [&["detect", "-o", "clusters.u32"], input].concat();
        workplace.succeed(&arguments).check_stdout(&["points and 3 without a position, which are skipped"]);
        let clusters = std::fs::read(workplace.path("clusters.u32")).unwrap();
        let (clusters, rest) = clusters.as_chunks::<4>();
        assert_eq!((clusters.len(), rest.len()), (n_points, 0));
        assert!([5, 6, 900].iter().all(|it| clusters[*it] == [0; 4]));
        workplace.succeed(&("detect -o clusters.csv", input));
        let csv = workplace.read("clusters.csv");
        assert_eq!((csv.lines().count(), csv.lines().nth(901)), (n_points + 1, Some("900,0")));
        // All others are of the cluster that they are of where nothing is left out.
        whole.succeed(&("detect -o clusters.u32", input));
        let of_whole = std::fs::read(whole.path("clusters.u32")).unwrap();
        let (of_whole, _) = of_whole.as_chunks::<4>();
        let pairs = clusters.iter().zip(of_whole).enumerate().filter(|(it, _)| ![5, 6, 900].contains(it));
        assert_eq!(pairs.filter(|(_, (found, expected))| found != expected).count(), 0);
    }
}
