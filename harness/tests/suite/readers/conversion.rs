//! What is written and read again is what it was.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use harness::annotation::{Annotation, AnnotationClass, LabeledScan, PointRegion, ScanId};
use harness::conversion::ConversionError;
use harness::conversion::convert::{Output, convert};
use harness::conversion::mcap_writer::ChunkCompression;
use harness::conversion::output_format::OutputFormat;
use harness::dataset::catalogue::built_in_catalogue;
use harness::dataset::open::{OpenOptions, open_dataset};
use harness::dataset::{Dataset, DatasetDescription, DatasetError};
use test_data::{needs_test_data, test_data};

use super::open;
use crate::program::Workplace;

/// Three scans of a simulated street.
fn street() -> Box<dyn Dataset> {
    let options = OpenOptions {
        n_simulated_scans: Some(3),
        sensor: Some("vlp-16".to_owned()),
        ..OpenOptions::default()
    };
    open_dataset("street-intersection", &options, &built_in_catalogue().unwrap()).unwrap()
}

fn write(dataset: &dyn Dataset, format: OutputFormat, compression: ChunkCompression, path: &Path) {
    let all: Vec<usize> = (0..dataset.scan_ids().len()).collect();
    let output = Output { path, format, compression };
    convert(dataset, &all, output, |_, error| Err(error), || Ok::<(), ConversionError>(())).unwrap();
}

fn scans(dataset: &dyn Dataset) -> Vec<LabeledScan> {
    (0..dataset.scan_ids().len()).map(|scan_idx| dataset.read_scan(scan_idx).unwrap()).collect()
}

/// Boxes differ at most by the rounding of a turn.
#[track_caller]
fn check_same(found: &[LabeledScan], expected: &[LabeledScan]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!(found.id, expected.id);
        assert_eq!(found.cloud, expected.cloud);
        assert_eq!(found.point_regions, expected.point_regions);
        assert_eq!(found.annotations.len(), expected.annotations.len());
        for (found, expected) in found.annotations.iter().zip(&expected.annotations) {
            if let (Some(a), Some(b)) = (&found.bounding_box, &expected.bounding_box) {
                assert_eq!((a.center_m, a.length_width_height_m), (b.center_m, b.length_width_height_m));
                assert!((a.yaw_rad - b.yaw_rad).sin().abs() < 1e-6, "{a:?} {b:?}");
            }
            let bounding_box = expected.bounding_box.and(found.bounding_box);
            assert_eq!(*found, Annotation { bounding_box, ..expected.clone() });
        }
    }
}

#[test]
fn a_recording_of_a_simulated_street_is_the_street() {
    let workplace = Workplace::new();
    for (name, compression) in
        [("zstd", ChunkCompression::Zstd), ("lz4", ChunkCompression::Lz4), ("none", ChunkCompression::None)]
    {
        let path = workplace.path(&format!("{name}.mcap"));
        let street = street();
        write(&*street, OutputFormat::Mcap, compression, &path);
        let recording = open(&path);
        let (found, expected) = (recording.description(), street.description());
        assert_eq!((found.format.as_str(), &found.id), ("mcap", &name.to_owned()));
        assert_eq!((&found.annotated, &found.sensor), (&expected.annotated, &expected.sensor));
        assert_eq!(found.simulation, expected.simulation);
        assert!(found.is_simulated());
        check_same(&scans(&*recording), &scans(&*street));
        let times: Vec<_> = (0..3).map(|scan_idx| recording.scan_time_ns(scan_idx)).collect();
        assert_eq!(times, [Some(0), Some(100_000_000), Some(200_000_000)]);
    }
}

/// The data set in each of the formats.
fn converted(dataset: &dyn Dataset, workplace: &Workplace, format: OutputFormat) -> PathBuf {
    let path = workplace.path(&format!("{format}.mcap"));
    write(dataset, format, ChunkCompression::Lz4, &path);
    path
}

#[track_caller]
fn check_recording_is_the_same(folder: &Path) {
    let workplace = Workplace::new();
    let dataset = open(folder);
    let recording = open(&converted(&*dataset, &workplace, OutputFormat::Mcap));
    assert_eq!(recording.description().annotated, dataset.description().annotated);
    check_same(&scans(&*recording), &scans(&*dataset));
}

#[needs_test_data("data/kitti_object")]
fn a_recording_of_kitti_object_is_the_same() {
    check_recording_is_the_same(&test_data!("data/kitti_object"));
}

#[needs_test_data("data/semantic_kitti")]
fn a_recording_of_semantic_kitti_is_the_same() {
    let folder = test_data!("data/semantic_kitti");
    check_recording_is_the_same(&folder);
    let workplace = Workplace::new();
    let dataset = open(&folder);
    let recording = open(&converted(&*dataset, &workplace, OutputFormat::Mcap));
    for scan_idx in 0..3 {
        assert_eq!(recording.scan_time_ns(scan_idx), dataset.scan_time_ns(scan_idx));
        let pose = |dataset: &dyn Dataset| dataset.world_from_sensor(scan_idx).unwrap().unwrap();
        let (found, expected) = (pose(&*recording), pose(&*dataset));
        assert!((found.inverse() * expected).translation.vector.norm() < 1e-9);
        assert!(found.rotation.angle_to(&expected.rotation) < 1e-7);
    }
}

#[test]
fn kitti_layouts_keep_points_and_boxes() {
    let workplace = Workplace::new();
    let street = street();
    for format in [OutputFormat::KittiTracking, OutputFormat::KittiObject] {
        let written = open(&converted(&*street, &workplace, format));
        assert_eq!(written.description().format, format.name());
        assert!(written.description().is_simulated());
        assert_eq!(written.description().annotated, street.description().annotated);
        for (found, expected) in scans(&*written).iter().zip(&scans(&*street)) {
            assert_eq!(found.cloud, expected.cloud);
            assert_eq!(found.point_regions, expected.point_regions);
            let boxed: Vec<_> = expected.annotations.iter().filter(|it| it.bounding_box.is_some()).collect();
            assert!(boxed.len() <= found.annotations.len() && !boxed.is_empty());
            for (found, expected) in found.annotations.iter().zip(&expected.annotations) {
                assert_eq!((found.class, found.occlusion), (expected.class, expected.occlusion));
                let (Some(a), Some(b)) = (found.bounding_box, expected.bounding_box) else { continue };
                assert!((0..3).all(|axis| (a.center_m[axis] - b.center_m[axis]).abs() < 1e-4), "{a:?} {b:?}");
                assert_eq!(a.length_width_height_m, b.length_width_height_m);
                assert!((a.yaw_rad - b.yaw_rad).sin().abs() < 1e-5);
            }
        }
    }
}

#[needs_test_data("data/kitti_object")]
fn what_is_not_labelled_in_kitti_stays_so_in_kitti() {
    let folder = test_data!("data/kitti_object");
    let workplace = Workplace::new();
    let dataset = open(&folder);
    let written = open(&converted(&*dataset, &workplace, OutputFormat::KittiObject));
    for (found, expected) in scans(&*written).iter().zip(&scans(&*dataset)) {
        assert_eq!(found.cloud, expected.cloud);
        assert_eq!(found.point_regions, expected.point_regions);
        let classes = |scan: &LabeledScan| scan.annotations.iter().map(|it| it.class).collect::<Vec<_>>();
        assert_eq!(classes(found), classes(expected));
    }
}

#[test]
fn semantic_kitti_keeps_which_point_is_of_which_object() {
    let workplace = Workplace::new();
    let street = street();
    let written = open(&converted(&*street, &workplace, OutputFormat::SemanticKitti));
    assert!(written.description().is_simulated());
    for (found, expected) in scans(&*written).iter().zip(&scans(&*street)) {
        assert_eq!((&found.cloud, &found.point_regions), (&expected.cloud, &expected.point_regions));
        let points = |scan: &LabeledScan| {
            let mut points: Vec<Vec<u32>> =
                scan.annotations.iter().map(|it| it.point_indices.clone()).collect();
            points.retain(|it| !it.is_empty());
            points.sort();
            points
        };
        assert_eq!(points(found), points(expected));
    }
}

/// Class and points of every annotation, and a number that tells its object from the others of its drive.
fn objects(scans: &[LabeledScan]) -> Vec<Vec<(AnnotationClass, Vec<u32>, Option<usize>)>> {
    let mut first_seen = BTreeMap::new();
    let of_scan = |scan: &LabeledScan| {
        let mut annotations: Vec<&Annotation> = scan.annotations.iter().collect();
        annotations.sort_by_key(|it| &it.point_indices);
        let object = |it: &&Annotation| {
            let n_seen = first_seen.len();
            let object = it.track.map(|track| *first_seen.entry((it.class, track)).or_insert(n_seen));
            (it.class, it.point_indices.clone(), object)
        };
        annotations.iter().map(object).collect()
    };
    scans.iter().map(of_scan).collect()
}

#[needs_test_data("data/semantic_kitti")]
fn semantic_kitti_in_semantic_kitti_is_the_same() {
    let folder = test_data!("data/semantic_kitti");
    let workplace = Workplace::new();
    let dataset = open(&folder);
    let written = open(&converted(&*dataset, &workplace, OutputFormat::SemanticKitti));
    let (found, expected) = (scans(&*written), scans(&*dataset));
    let cars = |scans: &[LabeledScan]| {
        let annotations = scans.iter().flat_map(|it| &it.annotations);
        annotations.filter(|it| it.class == AnnotationClass::Car).count()
    };
    assert_eq!((cars(&found), cars(&expected)), (39, 39));
    assert_eq!(objects(&found), objects(&expected));
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!((&found.cloud, &found.point_regions), (&expected.cloud, &expected.point_regions));
    }
}

/// A drive of one scan of two points, of which the first is a car.
struct TwoDrives(DatasetDescription, [ScanId; 2]);

impl Dataset for TwoDrives {
    fn description(&self) -> &DatasetDescription {
        &self.0
    }

    fn scan_ids(&self) -> &[ScanId] {
        &self.1
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let cloud = [[5.0 + scan_idx as f32, 0.0, 0.0], [9.0, 0.0, 0.0]].into_iter().collect();
        let mut scan = street().read_scan(0)?;
        let car = scan.annotations.swap_remove(0);
        let car = Annotation { point_indices: vec![0], track: Some(70_000 + scan_idx as u32), ..car };
        let id = self.1[scan_idx].clone();
        Ok(LabeledScan { id, cloud, annotations: vec![car], point_regions: vec![PointRegion::Labeled; 2] })
    }
}

#[test]
fn drives_whose_names_are_alike_stay_apart() {
    let ids = ["a/b", "a_b"].map(|name| ScanId { sequence: name.to_owned(), index: 0 });
    let drives = TwoDrives(street().description().clone(), ids);
    for format in [OutputFormat::SemanticKitti, OutputFormat::KittiTracking] {
        let workplace = Workplace::new();
        let written = open(&converted(&drives, &workplace, format));
        let names: Vec<&str> = written.scan_ids().iter().map(|it| it.sequence.as_str()).collect();
        assert_eq!(names, ["a%2Fb", "a_b"]);
        for scan_idx in 0..2 {
            let scan = written.read_scan(scan_idx).unwrap();
            assert_eq!(scan.cloud.position_m(0), [5.0 + scan_idx as f32, 0.0, 0.0]);
            assert_eq!(scan.annotations.len(), 1);
        }
    }
}
