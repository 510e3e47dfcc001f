//! What is written and read again is what it was.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use detector::PointCloud;
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::{Annotation, LabeledScan, ScanId};
use scans::conversion::ConversionError;
use scans::conversion::convert::{Output, convert};
use scans::conversion::mcap_writer::ChunkCompression;
use scans::conversion::output_format::OutputFormat;
use scans::dataset::{Dataset, DatasetError, Listing};
use test_data::test_data;

use super::made::scans;
use super::open;
use crate::program::Workplace;

/// Three scans of a simulated street.
fn street() -> Box<dyn Dataset> {
    super::made::street(3)
}

fn write(dataset: &dyn Dataset, format: OutputFormat, compression: ChunkCompression, path: &Path) {
    let all: Vec<usize> = (0..dataset.scan_ids().len()).collect();
    let output = Output { path, format, compression };
    convert(dataset, &all, output, |_, error| Err(error), || Ok::<(), ConversionError>(())).unwrap();
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
        // Of vertical angles there are sixteen; nothing moved meanwhile.
        let cloud = recording.read_scan(0).unwrap().cloud;
        assert_eq!((cloud.ring().unwrap().iter().max(), cloud.time_offset_s()), (Some(&15), None));
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

#[test]
#[ignore = "needs data/kitti_object in SCANBENCH_TEST_DATA"]
fn a_recording_of_kitti_object_is_the_same() {
    check_recording_is_the_same(&test_data("data/kitti_object"));
}

#[test]
#[ignore = "needs data/semantic_kitti in SCANBENCH_TEST_DATA"]
fn a_recording_of_semantic_kitti_is_the_same() {
    let folder = test_data("data/semantic_kitti");
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
fn a_recording_that_is_made_again_has_the_same_bytes() {
    let workplace = Workplace::new();
    let street = street();
    let bytes = |name: &str| {
        let path = workplace.path(name);
        write(&*street, OutputFormat::Mcap, ChunkCompression::Zstd, &path);
        std::fs::read(path).unwrap()
    };
    let first = bytes("0.mcap");
    // Three topics are in the same order by chance every sixth time.
    assert!((1..6).all(|it| bytes(&format!("{it}.mcap")) == first));
    let summary = mcap::Summary::read(&first).unwrap().unwrap();
    assert_eq!((summary.channels.len(), summary.chunk_indexes.is_empty()), (3, false));
}

/// The layouts of KITTI have no room for more than these.
#[track_caller]
pub fn check_same_points(found: &PointCloud, expected: &PointCloud) {
    assert!(found.positions_m().eq(expected.positions_m()));
    assert_eq!(found.intensity(), expected.intensity());
    assert_eq!((found.ring(), found.time_offset_s()), (None, None));
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
            check_same_points(&found.cloud, &expected.cloud);
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

#[test]
#[ignore = "needs data/kitti_object in SCANBENCH_TEST_DATA"]
fn what_is_not_labelled_in_kitti_stays_so_in_kitti() {
    let folder = test_data("data/kitti_object");
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
        check_same_points(&found.cloud, &expected.cloud);
        assert_eq!(found.point_regions, expected.point_regions);
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

/// Class, points and the number of an object.
type NumberedObject = (AnnotationClass, Vec<u32>, Option<usize>);

/// Tracks of scans, each given the number of the first object that has it.
fn renumbered(scans: &[LabeledScan]) -> Vec<Vec<NumberedObject>> {
    let mut first_of: BTreeMap<u32, usize> = BTreeMap::new();
    let mut in_order = Vec::new();
    for scan in scans {
        // By their points, since tracks say nothing about the order.
        let mut annotations: Vec<&Annotation> = scan.annotations.iter().collect();
        annotations.sort_by_key(|it| it.point_indices.clone());
        let number = |track: u32, first_of: &mut BTreeMap<u32, usize>| {
            let next = first_of.len();
            *first_of.entry(track).or_insert(next)
        };
        let annotation = |it: &Annotation, first_of: &mut BTreeMap<u32, usize>| {
            (it.class, it.point_indices.clone(), it.track.map(|track| number(track, first_of)))
        };
        in_order.push(annotations.into_iter().map(|it| annotation(it, &mut first_of)).collect());
    }
    in_order
}

#[test]
#[ignore = "needs data/semantic_kitti in SCANBENCH_TEST_DATA"]
fn semantic_kitti_written_again_has_the_same_annotations() {
    let folder = test_data("data/semantic_kitti");
    let workplace = Workplace::new();
    let dataset = open(&folder);
    let again = open(&converted(&*dataset, &workplace, OutputFormat::SemanticKitti));
    let (expected, found) = (scans(&*dataset), scans(&*again));
    // The same objects keep the same track through all scans, whatever its number.
    assert_eq!(renumbered(&found), renumbered(&expected));
    let n_cars = |scans: &[LabeledScan]| {
        let annotations = scans.iter().flat_map(|it| &it.annotations);
        annotations.filter(|it| it.class == AnnotationClass::Car).count()
    };
    assert_eq!((n_cars(&expected), n_cars(&found)), (39, 39));
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!((&found.cloud, &found.point_regions), (&expected.cloud, &expected.point_regions));
    }
    let third = workplace.path("third");
    write(&*again, OutputFormat::SemanticKitti, ChunkCompression::Lz4, &third);
    assert_eq!(scans(&*open(&third)), found);
}

/// Scans in which every point is an object of its own class and track.
struct Drawn {
    listing: Listing,
    objects: Vec<Vec<(AnnotationClass, Option<u32>)>>,
}

impl Drawn {
    fn new(objects: Vec<Vec<(AnnotationClass, Option<u32>)>>) -> Self {
        let description = street().description().clone();
        let ids = (0..objects.len() as u32).map(|index| ScanId { sequence: "drawn".to_owned(), index });
        Self { listing: Listing { description, scan_ids: ids.collect() }, objects }
    }
}

impl Dataset for Drawn {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let objects = &self.objects[scan_idx];
        // Two metres apart, so that poles do not hang together; whole numbers would look like lasers.
        let at_m = |step: usize| 2.0 * step as f32 + 0.25;
        let cloud: PointCloud = (0..objects.len()).map(|it| [at_m(it % 500), at_m(it / 500), 0.0]).collect();
        let annotation = |(index, &(class, track)): (usize, &(AnnotationClass, Option<u32>))| Annotation {
            point_indices: vec![index as u32],
            track,
            ..Annotation::of(class)
        };
        let annotations = objects.iter().enumerate().map(annotation).collect();
        Ok(LabeledScan::everywhere(self.listing.scan_ids[scan_idx].clone(), cloud, annotations))
    }
}

#[test]
fn two_objects_never_become_one_in_semantic_kitti() {
    use AnnotationClass::{Car, Pole, Truck, Van};
    let workplace = Workplace::new();
    // Tracks that are the same in their lower 16 bits, one track in two classes, none, and one twice in a scan.
    let drawn = Drawn::new(vec![
        vec![
            (Car, Some(0xa | 1 << 16)),
            (Car, Some(0xa | 2 << 16)),
            (Truck, Some(7)),
            (Car, Some(7)),
            (Van, Some(7)),
        ],
        vec![
            (Car, None),
            (Car, Some(7)),
            (Car, Some(0xa | 2 << 16)),
            (Car, None),
            (Pole, None),
            (Pole, Some(0)),
        ],
        vec![(Car, Some(7)), (Car, Some(7)), (Car, None), (Car, Some(0)), (Pole, None)],
    ]);
    let written = scans(&*open(&converted(&drawn, &workplace, OutputFormat::SemanticKitti)));
    let tracks: Vec<Vec<Option<u32>>> = written
        .iter()
        .map(|scan| {
            let mut by_point: Vec<_> =
                scan.annotations.iter().map(|it| (it.point_indices[0], it.track)).collect();
            by_point.sort_unstable();
            by_point.into_iter().map(|(_, track)| track.map(|it| it >> 16)).collect()
        })
        .collect();
    let expected: [&[Option<u32>]; 3] = [
        &[Some(1), Some(2), Some(3), Some(4), Some(5)],
        // Objects without a track are others in each scan; poles are separated without one.
        &[Some(6), Some(4), Some(2), Some(7), None, Some(8)],
        &[Some(4), Some(9), Some(10), Some(11), None],
    ];
    assert_eq!(tracks, expected);
}

#[test]
fn more_objects_than_semantic_kitti_has_numbers_for_are_refused() {
    let workplace = Workplace::new();
    let path = workplace.path("drive");
    let output =
        Output { path: &path, format: OutputFormat::SemanticKitti, compression: ChunkCompression::Lz4 };
    let convert = |n_objects: [usize; 2]| {
        let objects = n_objects.map(|n| vec![(AnnotationClass::Car, None); n]);
        convert(
            &Drawn::new(objects.to_vec()),
            &[0, 1],
            output,
            |_, error| Err(error),
            || Ok::<(), ConversionError>(()),
        )
    };
    let error = convert([65_000, 536]).expect_err("one too many").to_string();
    assert!(
        error.contains("drive \"drawn\" has at least 65536 objects") && error.contains("65535"),
        "{error}"
    );
    assert_eq!(workplace.top_names(), [""; 0]);
    convert([65_000, 535]).unwrap();
    assert_eq!(scans(&*open(&path)).iter().map(|it| it.annotations.len()).sum::<usize>(), 65_535);
}
