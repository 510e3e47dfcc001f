//! The folders of nuScenes.
//!
//! ```text
//! v1.0-NAME/*.json                     the tables; of several versions one is named
//! samples/LIDAR_TOP/NAME.pcd.bin       the scans that are annotated: x, y, z, intensity, ring as f32
//! sweeps/LIDAR_TOP/NAME.pcd.bin        the scans between them, for detectors that look back
//! ```

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use nalgebra::Isometry3;
use reports::vocabulary::class::AnnotationClass;

use super::lidar_tables::{Keyframe, LidarTables, ScansOfScenes, read_all_scans, read_keyframes};
use super::world_objects::WorldObject;
use crate::annotation::{Annotation, LabeledScan, ScanId};
use crate::dataset::checksum::DatasetChecksum;
use crate::dataset::class_table::ClassReader;
use crate::dataset::dataset_format::DatasetFormat;
use crate::dataset::earlier_scans::Sweep;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::official::OfficialScan;
use crate::dataset::point_columns::PointColumns;
use crate::dataset::points_of_boxes::assign_points_in_boxes;
use crate::dataset::positioned_points::PositionedPoints;
use crate::dataset::scan_columns::ScanColumns;
use crate::dataset::source::DatasetSource;
use crate::dataset::{Dataset, DatasetError, Listing, labels_without_scan};

/// The lidar, 32 beams on the roof.
pub const NUSCENES_SENSOR: &str = "hdl-32e";

/// Its height above the road, in metres.
pub const NUSCENES_SENSOR_HEIGHT_M: f32 = 1.84;

/// The labelled classes: objects that move by themselves, and objects that are moved about.
pub const NUSCENES_CLASSES: [AnnotationClass; 12] = [
    AnnotationClass::Car,
    AnnotationClass::Van,
    AnnotationClass::Truck,
    AnnotationClass::Bus,
    AnnotationClass::Pedestrian,
    AnnotationClass::SittingPerson,
    AnnotationClass::Cyclist,
    AnnotationClass::ParkedCycle,
    AnnotationClass::Trailer,
    AnnotationClass::ConstructionVehicle,
    AnnotationClass::Animal,
    AnnotationClass::StreetFurniture,
];

/// The tables that distinguish a version from other folders, and count for the checksum.
const TABLES: [&str; 11] = [
    "sample_data",
    "attribute",
    "calibrated_sensor",
    "category",
    "ego_pose",
    "instance",
    "sample",
    "sample_annotation",
    "scene",
    "sensor",
    "visibility",
];

/// An open data set: annotations are in memory, scans are read one at a time.
#[derive(Debug)]
struct NuScenes {
    // Invariant: `scan_ids` and `keyframes` have the same length and order.
    listing: Listing,
    tables: PathBuf,
    scans: PathBuf,
    columns: ScanColumns,
    keyframes: Vec<Keyframe>,
    samples_without_scan: BTreeSet<String>,
    // Read when somebody asks for scans between keyframes: the tables have five times as many of them.
    all_scans: OnceLock<ScansOfScenes>,
}

/// Whether `folder` is that of nuScenes, or of one of its versions.
pub fn is_nuscenes(folder: &Path) -> bool {
    !versions_in(folder).is_empty()
}

/// Opens the folder of `source`: all scenes, or only those of `sequences`, such as `scene-0061`.
///
/// No scan is read.
pub fn open_nuscenes(mut source: DatasetSource) -> Result<Box<dyn Dataset>, DatasetError> {
    let sequences = source.parts.sequences.take();
    let (version, scans) = match &versions_in(&source.path)[..] {
        // The folder of a version may be a link to elsewhere, so that its `..` is another folder.
        [only] if *only == source.path => (only.clone(), parent_of(&source.path)),
        [only] => (only.clone(), source.path.clone()),
        [] => return Err(DatasetError::no_scans(source.path)),
        several => {
            let found: Vec<String> = several.iter().map(|it| it.display().to_string()).collect();
            return Err(DatasetError::several_datasets(&source.path, &found));
        }
    };
    let mut classes = ClassReader::new(&source.classes, &[]);
    let LidarTables { keyframes, samples_without_scan } =
        read_keyframes(&version, sequences.as_ref(), &mut classes)?;
    classes.unknown().refuse(&source.id)?;
    let scenes: BTreeSet<&str> = keyframes.iter().map(|it| it.scene.as_str()).collect();
    if let Some(missing) = sequences.iter().flatten().find(|name| !scenes.contains(name.as_str())) {
        return Err(DatasetError::missing_selected(&source.path.join(missing)));
    }
    if keyframes.is_empty() {
        return Err(DatasetError::no_scans(version));
    }
    let mut checksum = DatasetChecksum::default();
    for table in TABLES {
        // Larger than all other labels: they count by their size, as scans do.
        let name = format!("{table}.json");
        checksum.add_file(&name, &version.join(&name))?;
    }
    let mut scan_ids: Vec<ScanId> = Vec::with_capacity(keyframes.len());
    for keyframe in &keyframes {
        let index = match scan_ids.last() {
            Some(last) if last.sequence == keyframe.scene => last.index + 1,
            _ => 0,
        };
        scan_ids.push(ScanId { sequence: keyframe.scene.clone(), index });
    }
    let paths: Vec<PathBuf> = keyframes.iter().map(|it| scans.join(&it.file)).collect();
    let columns = ScanColumns::new(source.columns.clone(), PointColumns::of_nuscenes(), &paths);
    let description = source.describe(DatasetFormat::NuScenes, checksum.finish());
    let listing = Listing { description, scan_ids };
    Ok(Box::new(NuScenes {
        listing,
        tables: version,
        scans,
        columns,
        keyframes,
        samples_without_scan,
        all_scans: OnceLock::new(),
    }))
}

impl NuScenes {
    fn read_points(&self, file: &Path) -> Result<PositionedPoints, DatasetError> {
        // To the right, ahead and up; the intensity is a byte, scaled to the range of other sensors.
        let points = self.columns.read(&self.scans.join(file))?;
        Ok(points.converted(|[right_m, forward_m, up_m], intensity| {
            ([forward_m, -right_m, up_m], intensity / 255.0)
        }))
    }

    fn all_scans(&self) -> Result<&ScansOfScenes, DatasetError> {
        if let Some(read) = self.all_scans.get() {
            return Ok(read);
        }
        let scenes = self.keyframes.iter().map(|it| it.scene.clone()).collect();
        let read = read_all_scans(&self.tables, &scenes)?;
        Ok(self.all_scans.get_or_init(|| read))
    }
}

impl Dataset for NuScenes {
    fn listing(&self) -> &Listing {
        &self.listing
    }

    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError> {
        let keyframe = &self.keyframes[scan_idx];
        let points = self.read_points(&keyframe.file)?;
        let mut annotations: Vec<Annotation> =
            keyframe.objects.iter().filter_map(|it| it.annotation(&keyframe.world_from_sensor)).collect();
        assign_points_in_boxes(points.cloud(), &mut annotations);
        Ok(points.labeled_everywhere(self.listing.scan_ids[scan_idx].clone(), annotations))
    }

    fn columns(&self) -> Result<Option<String>, DatasetError> {
        self.columns.described()
    }

    fn oddities(&self) -> Result<Vec<String>, DatasetError> {
        let samples = &self.samples_without_scan;
        let names: Vec<String> = samples.iter().map(|it| format!("the sample {it:?}")).collect();
        Ok(labels_without_scan(&names))
    }

    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        Some(self.keyframes[scan_idx].time_ns)
    }

    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        Ok(Some(self.keyframes[scan_idx].world_from_sensor))
    }

    fn sweeps_before(&self, scan_idx: usize, n: usize) -> Result<Option<Vec<Sweep>>, DatasetError> {
        if n == 0 {
            return Ok(Some(Vec::new()));
        }
        let Keyframe { scene, time_ns, .. } = &self.keyframes[scan_idx];
        let of_scene = self.all_scans()?.get(scene).map_or(&[][..], Vec::as_slice);
        let before = of_scene.iter().rev().filter(|(at_ns, ..)| at_ns < time_ns).take(n);
        let sweep = |(time_ns, file, world_from_sensor): &(u64, PathBuf, Isometry3<f64>)| {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let name = name.split('.').next().unwrap_or_default().to_owned();
            let (cloud, _) = self.read_points(file)?.into_parts();
            Ok(Sweep { name, time_ns: *time_ns, world_from_sensor: *world_from_sensor, cloud })
        };
        before.map(sweep).collect::<Result<_, _>>().map(Some)
    }

    fn foreign_frame(&self, scan_idx: usize) -> Result<ForeignFrame, DatasetError> {
        let Keyframe { sample_token, world_from_sensor, .. } = &self.keyframes[scan_idx];
        Ok(ForeignFrame::World { sample_token: sample_token.clone(), world_from_sensor: *world_from_sensor })
    }

    fn official_scan(&self, scan_idx: usize) -> Result<Option<OfficialScan>, DatasetError> {
        let Keyframe { objects, ego_m, .. } = &self.keyframes[scan_idx];
        let objects = objects.iter().map(WorldObject::official).collect();
        Ok(Some(OfficialScan { objects, origin_m: *ego_m }))
    }
}

fn parent_of(folder: &Path) -> PathBuf {
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    absolute.parent().map(Path::to_path_buf).unwrap_or(absolute)
}

/// The folders of tables: `folder` itself, or those in it that are named after a version.
fn versions_in(folder: &Path) -> Vec<PathBuf> {
    let has_tables = |path: &Path| TABLES[..5].iter().all(|it| path.join(format!("{it}.json")).is_file());
    if has_tables(folder) {
        return vec![folder.to_path_buf()];
    }
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_version = |it: &std::fs::DirEntry| it.file_name().to_string_lossy().starts_with("v1.");
    let mut versions: Vec<PathBuf> =
        entries.filter(is_version).map(|it| it.path()).filter(|it| has_tables(it)).collect();
    versions.sort();
    versions
}
