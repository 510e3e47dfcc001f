//! Every kind of broken data set is refused with a message that names file and position, and as the right kind of error.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::{Path, PathBuf};

use scans::annotation::PointRegion;
use scans::dataset::catalogue::parse_catalogue;
use scans::dataset::{AnnotatedClasses, Dataset, DatasetError};
use simulator::catalogue::Catalogue;
use simulator::open::{OpenOptions, open_dataset};
use tempfile::TempDir;

/// A camera at the sensor that looks along x.
const CALIBRATION: &str = "\
P2: 700 0 621 0 0 700 187 0 0 0 1 0
R0_rect: 1 0 0 0 1 0 0 0 1
Tr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0
";

/// A car ten metres ahead that heads along x.
const CAR: &str = "Car 0 0 0 500 150 700 300 1.5 1.6 4 0 1.7 10 -1.5707963";

/// One point in the car, one far ahead of it, one behind the sensor.
const POINTS: [[f32; 4]; 3] = [[10.0, 0.5, -1.0, 0.3], [30.0, 0.5, -1.0, 0.3], [-10.0, 0.5, -1.0, 0.3]];

fn bytes_of(points: &[[f32; 4]]) -> Vec<u8> {
    points.iter().flatten().flat_map(|value| value.to_le_bytes()).collect()
}

/// A folder of files that goes away with the test.
struct Disk {
    folder: TempDir,
}

impl Disk {
    /// Two scans in the object layout.
    fn with_objects() -> Self {
        let disk = Self { folder: tempfile::tempdir().unwrap() };
        for number in ["000007", "000009"] {
            disk.write(&format!("training/velodyne/{number}.bin"), bytes_of(&POINTS));
            disk.write(&format!("training/label_2/{number}.txt"), CAR);
            disk.write(&format!("training/calib/{number}.txt"), CALIBRATION);
        }
        disk
    }

    /// Two drives with a scan each in the tracking layout, with labels of scans that were not downloaded.
    fn with_drives() -> Self {
        let disk = Self { folder: tempfile::tempdir().unwrap() };
        for sequence in ["0001", "0004"] {
            disk.write(&format!("training/velodyne/{sequence}/000007.bin"), bytes_of(&POINTS));
            disk.write(&format!("training/label_02/{sequence}.txt"), format!("7 2 {CAR}\n8 2 {CAR}"));
            disk.write(&format!("training/calib/{sequence}.txt"), CALIBRATION);
        }
        disk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }

    fn remove(&self, name: &str) {
        let path = self.path(name);
        let removed = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
        removed.unwrap();
    }

    fn open(&self) -> Result<Box<dyn Dataset>, DatasetError> {
        open_dataset(self.folder.path().to_str().unwrap(), &OpenOptions::default(), &no_catalogue())
    }

    /// A catalogue with the data set `street` on this disk, and `lines` in its entry.
    fn catalogue(&self, format: &str, lines: &str) -> Catalogue {
        self.catalogue_of("street", format, lines)
    }

    /// The same where the data set is called `id`.
    fn catalogue_of(&self, id: &str, format: &str, lines: &str) -> Catalogue {
        let root = self.folder.path().display();
        let text = format!(
            "[recorded.{id}]\nformat = \"{format}\"\nroot = '{root}'\nannotated_classes = \"every-object\"\n\
             sensor_height_m = 2.1\nlicence = \"ours\"\nurl = \"https://example.org/street\"\n{lines}\n"
        );
        parse_catalogue("datasets.toml", &text).unwrap()
    }

    fn open_catalogued(&self, format: &str, lines: &str) -> Result<Box<dyn Dataset>, DatasetError> {
        open_dataset("street", &OpenOptions::default(), &self.catalogue(format, lines))
    }
}

fn no_catalogue() -> Catalogue {
    parse_catalogue("datasets.toml", "").unwrap()
}

fn read_all(dataset: &dyn Dataset) -> Result<(), DatasetError> {
    (0..dataset.scan_ids().len()).try_for_each(|scan_idx| dataset.read_scan(scan_idx).map(drop))
}

/// Opening and reading fails as damaged data, with a message that holds all of `parts`.
#[track_caller]
fn check_damaged(disk: &Disk, parts: &[&str]) {
    let error = disk.open().and_then(|dataset| read_all(dataset.as_ref())).expect_err("damaged");
    check_message(&error, parts);
    assert!(!error.is_usage_error(), "{error}");
}

#[track_caller]
fn check_usage(result: Result<Box<dyn Dataset>, DatasetError>, parts: &[&str]) {
    let error = result.err().expect("no such thing");
    check_message(&error, parts);
    assert!(error.is_usage_error(), "{error}");
}

#[track_caller]
fn check_message(error: &DatasetError, parts: &[&str]) {
    for part in parts {
        assert!(error.to_string().contains(part), "{part:?} is not in: {error}");
    }
}

#[track_caller]
fn check_sound(dataset: &dyn Dataset, expected_ids: &[&str]) {
    let ids: Vec<String> = dataset.scan_ids().iter().map(ToString::to_string).collect();
    assert_eq!(ids, expected_ids);
    for scan_idx in 0..ids.len() {
        let scan = dataset.read_scan(scan_idx).unwrap();
        assert_eq!(&scan.id, &dataset.scan_ids()[scan_idx]);
        assert_eq!(scan.annotations.len(), 1);
        assert_eq!(scan.annotations[0].point_indices, [0]);
        assert_eq!(scan.point_regions, [PointRegion::Labeled, PointRegion::Labeled, PointRegion::Outside]);
    }
}

#[test]
fn sound_data_sets_are_read_in_both_layouts() {
    check_sound(Disk::with_objects().open().unwrap().as_ref(), &["training/000007", "training/000009"]);
    check_sound(Disk::with_drives().open().unwrap().as_ref(), &["0001/000007", "0004/000007"]);
}

#[test]
fn a_scan_without_labelled_objects_has_none() {
    let disk = Disk::with_drives();
    disk.write("training/velodyne/0001/000100.bin", bytes_of(&POINTS));
    assert_eq!(disk.open().unwrap().read_scan(1).unwrap().annotations, []);
}

/// What is broken in sound data, below `training`: a file with this content, or none; and what is said of it.
type Broken = (&'static str, Option<Vec<u8>>, &'static [&'static str]);

fn check_broken(sound: fn() -> Disk, cases: impl IntoIterator<Item = Broken>) {
    for (name, content, parts) in cases {
        let disk = sound();
        match content {
            Some(content) => disk.write(&format!("training/{name}"), content),
            None => disk.remove(&format!("training/{name}")),
        }
        check_damaged(&disk, parts);
    }
}

#[test]
fn what_is_broken_in_single_scans_is_named() {
    let cut = bytes_of(&POINTS)[..40].to_vec();
    let far = bytes_of(&[POINTS[0], [1.0, -10_001.0, 0.0, 0.0]]);
    let no_matrix = CALIBRATION.replace("P2", "P0").into_bytes();
    let malformed = format!("{CAR}\nCar 0 0 zero").into_bytes();
    let cases: [Broken; 10] = [
        ("image_2/000009.png", Some(b"GIF89a".to_vec()), &["image_2/000009.png", "PNG"]),
        ("velodyne/000009.bin", Some(cut), &["velodyne/000009.bin", "40 bytes", "multiple of the 16"]),
        (
            "velodyne/000009.bin",
            Some(far),
            &["velodyne/000009.bin", "has point 1 at y = -10001.000 m, beyond 10000 m"],
        ),
        ("velodyne/000007.bin", None, &["label_2", "1 label file has no scan: 000007.txt"]),
        ("velodyne/7.bin", Some(bytes_of(&POINTS)), &["velodyne/7.bin", "six digits"]),
        ("label_2/000007.txt", None, &["label_2", "1 scan has no labels: 000007.bin"]),
        ("label_2/000009.txt", Some(malformed), &["label_2/000009.txt", "line 2", "alpha \"zero\""]),
        ("label_2/000009.txt", Some(b"Car \xfe".to_vec()), &["label_2/000009.txt", "byte 4"]),
        ("calib/000007.txt", None, &["velodyne/000007.bin", "calib/000007.txt", "does not exist"]),
        ("calib/000009.txt", Some(no_matrix), &["calib/000009.txt", "has no line P2"]),
    ];
    check_broken(Disk::with_objects, cases);
}

#[test]
fn what_is_broken_in_drives_is_named() {
    let cases: [Broken; 4] = [
        ("velodyne/0004/000007.bin", Some(Vec::new()), &["velodyne/0004/000007.bin", "has no points"]),
        ("velodyne/0001/000007.bin", None, &["velodyne/0001", "has no scans"]),
        ("label_02/0004.txt", None, &["velodyne/0004", "label_02/0004.txt", "do not exist"]),
        ("calib", None, &["velodyne/0001", "calib/0001.txt", "does not exist"]),
    ];
    check_broken(Disk::with_drives, cases);
}

#[test]
fn points_without_a_position_are_left_out_and_a_scan_without_others_is_damaged() {
    for value in [f32::NAN, f32::INFINITY] {
        let disk = Disk::with_objects();
        disk.write("training/velodyne/000009.bin", bytes_of(&[[1.0, 1.0, value, 0.0], POINTS[0]]));
        let scan = disk.open().unwrap().read_scan(1).unwrap();
        assert_eq!((scan.cloud.len(), &scan.points_left_out[..]), (1, &[0][..]));
        assert_eq!(scan.annotations[0].point_indices, [0]);
        disk.write("training/velodyne/000009.bin", bytes_of(&[[1.0, 1.0, value, 0.0]]));
        check_damaged(&disk, &["velodyne/000009.bin", "has 1 points, but none with a position"]);
    }
}

#[test]
fn a_test_split_cannot_be_scored() {
    let disk = Disk::with_objects();
    std::fs::rename(disk.path("training"), disk.path("testing")).unwrap();
    disk.remove("testing/label_2");
    check_damaged(&disk, &["testing/label_2", "a test split cannot be scored"]);
}

#[test]
fn the_image_decides_what_is_outside() {
    let disk = Disk::with_objects();
    let before = disk.open().unwrap();
    // 600 pixels wide: the car in the middle, at column 586, is inside; cut at 500 it is not.
    for (width_px, region) in [(600_u32, PointRegion::Labeled), (500, PointRegion::Outside)] {
        let png =
            [&b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"[..], &width_px.to_be_bytes(), &375_u32.to_be_bytes()].concat();
        disk.write("training/image_2/000007.png", png);
        let dataset = disk.open().unwrap();
        assert_eq!(dataset.read_scan(0).unwrap().point_regions[0], region);
        assert_ne!(dataset.description().checksum, before.description().checksum);
    }
}

#[test]
fn an_unknown_format_is_a_usage_error() {
    let disk = Disk { folder: tempfile::tempdir().unwrap() };
    disk.write("points.csv", "x,y,z\n");
    check_usage(disk.open(), &["no data set in a known format", "kitti-tracking, kitti-object"]);
}

#[test]
fn a_format_asked_for_must_be_there() {
    let disk = Disk::with_objects();
    let path = disk.folder.path().to_str().unwrap();
    let open = |format: &str| {
        open_dataset(
            path,
            &OpenOptions { format: Some(format.parse().unwrap()), ..OpenOptions::default() },
            &no_catalogue(),
        )
    };
    assert!(open("kitti-object").is_ok());
    check_usage(open("kitti-tracking"), &["no data set in a known format (kitti-tracking)"]);
}

#[test]
fn an_unknown_id_is_a_usage_error_that_lists_the_known_ones() {
    let disk = Disk::with_objects();
    let catalogue = disk.catalogue("kitti-object", "");
    check_usage(open_dataset("strete", &OpenOptions::default(), &catalogue), &["\"strete\"", "(street)"]);
    let missing = open_dataset("./strete", &OpenOptions::default(), &catalogue).err().expect("no such path");
    check_message(&missing, &["cannot read \"./strete\""]);
    assert!(!missing.is_usage_error());
}

#[test]
fn a_catalogued_data_set_is_described_by_its_entry() {
    let disk = Disk::with_objects();
    let dataset = disk.open_catalogued("kitti-object", "scans = [9]").unwrap();
    check_sound(dataset.as_ref(), &["training/000009"]);
    let description = dataset.description();
    assert_eq!(description.id, "street");
    assert_eq!(description.format, "kitti-object");
    assert_eq!(description.root.as_deref(), Some(disk.path("training").as_path()));
    assert_eq!(description.annotated, AnnotatedClasses::EveryObject);
    assert_eq!(description.sensor_height_m.to_bits(), 2.1_f32.to_bits());
    assert_eq!(description.licence.as_deref(), Some("ours"));
}

#[test]
fn a_catalogued_part_of_a_data_set_is_all_that_is_opened() {
    let disk = Disk::with_drives();
    let dataset = disk.open_catalogued("kitti-tracking", "sequences = [\"0004\"]").unwrap();
    check_sound(dataset.as_ref(), &["0004/000007"]);
}

#[test]
fn a_catalogued_part_that_is_missing_is_named() {
    let disk = Disk::with_drives();
    let error = disk.open_catalogued("kitti-tracking", "sequences = [\"0005\"]").err().expect("missing");
    check_message(&error, &["velodyne/0005", "does not exist"]);
    assert!(!error.is_usage_error());

    let disk = Disk::with_objects();
    let error = disk.open_catalogued("kitti-object", "scans = [7, 8]").err().expect("missing");
    check_message(&error, &["velodyne/000008.bin", "does not exist"]);
}

#[test]
fn a_catalogued_format_is_not_overridden() {
    let disk = Disk::with_objects();
    let catalogue = disk.catalogue("kitti-object", "");
    let format = Some("kitti-tracking".parse().unwrap());
    check_usage(
        open_dataset("street", &OpenOptions { format, ..OpenOptions::default() }, &catalogue),
        &["street", "kitti-object", "kitti-tracking"],
    );
}

#[test]
fn a_name_of_the_catalogue_and_of_a_folder_here_is_neither() {
    let disk = Disk::with_objects();
    // There is such a folder where tests run.
    let catalogue = disk.catalogue_of("src", "kitti-object", "");
    let words = ["\"src\" is a data set of the catalogue", "write ./src for the folder here"];
    check_usage(open_dataset("src", &OpenOptions::default(), &catalogue), &words);
}

#[test]
fn a_missing_root_says_what_to_set_and_where_the_data_are() {
    let disk = Disk::with_objects();
    let text = |root: &str| {
        format!(
            "[recorded.street]\nformat = \"kitti-object\"\nroot = {root:?}\nannotated_classes = [\"car\"]\n\
             sensor_height_m = 1.7\nlicence = \"ours\"\nurl = \"https://example.org/street\"\n"
        )
    };
    let nowhere = disk.path("nowhere").display().to_string();
    for (root, parts) in [
        ("${SCANBENCH_TEST_UNSET}".to_owned(), ["\"street\"", "set SCANBENCH_TEST_UNSET"]),
        (format!("${{SCANBENCH_TEST_UNSET:-{nowhere}}}"), [nowhere.as_str(), "set SCANBENCH_TEST_UNSET"]),
        (nowhere.clone(), [nowhere.as_str(), "correct its root"]),
    ] {
        let catalogue = parse_catalogue("datasets.toml", &text(&root)).unwrap();
        let error = open_dataset("street", &OpenOptions::default(), &catalogue).err().expect("missing");
        check_message(&error, &parts);
        check_message(&error, &["https://example.org/street"]);
        assert!(!error.is_usage_error());
    }
}

#[test]
fn a_checksum_changes_with_the_data() {
    let disk = Disk::with_objects();
    let checksum = disk.open().unwrap().description().checksum.clone().unwrap();
    let line = format!("checksum = {checksum:?}");
    assert!(disk.open_catalogued("kitti-object", &line).is_ok());

    disk.write("training/label_2/000009.txt", format!("{CAR}\n"));
    let error = disk.open_catalogued("kitti-object", &line).err().expect("changed");
    let found = disk.open().unwrap().description().checksum.clone().unwrap();
    check_message(&error, &["street", &checksum, &found]);
    assert!(!error.is_usage_error());
}

#[test]
fn the_checksum_does_not_depend_on_where_the_data_lie() {
    let checksum = |disk: &Disk| disk.open().unwrap().description().checksum.clone();
    assert_eq!(checksum(&Disk::with_drives()), checksum(&Disk::with_drives()));
}

#[test]
fn a_data_set_is_called_after_its_folder() {
    let disk = Disk::with_objects();
    disk.write("readme.txt", "");
    let name = disk.folder.path().file_name().unwrap().to_str().unwrap();
    for path in [disk.folder.path().to_path_buf(), disk.path("training"), disk.path("training/velodyne/..")] {
        let dataset = open_dataset(path.to_str().unwrap(), &OpenOptions::default(), &no_catalogue()).unwrap();
        assert_eq!(dataset.description().id, name, "{}", Path::new(&path).display());
    }
}
