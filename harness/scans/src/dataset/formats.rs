//! The formats that can be read, as a table: how to recognise and open each, and the properties of its benchmark.

use std::path::Path;

use reports::vocabulary::class::AnnotationClass;

use super::argoverse2::sensor_logs::{
    ARGOVERSE2_CLASSES, ARGOVERSE2_SENSOR, ARGOVERSE2_SENSOR_HEIGHT_M, is_argoverse2, open_argoverse2,
};
use super::dataset_format::DatasetFormat;
use super::kitti::benchmarks::{is_kitti_object, is_kitti_tracking, open_kitti_object, open_kitti_tracking};
use super::kitti::label::KITTI_CLASSES;
use super::kitti::split_folder::{KITTI_SENSOR, KITTI_SENSOR_HEIGHT_M};
use super::kitti_raw::drives::{is_kitti_raw, open_kitti_raw};
use super::mcap::mcap_dataset::{is_mcap, open_mcap};
use super::nuscenes::keyframes::{
    NUSCENES_CLASSES, NUSCENES_SENSOR, NUSCENES_SENSOR_HEIGHT_M, is_nuscenes, open_nuscenes,
};
use super::scan_folder::folder::open_scan_folder;
use super::semantic_kitti::sequence::{is_semantic_kitti, open_semantic_kitti};
use super::source::DatasetSource;
use super::velodyne_capture::capture_file::is_capture;
use super::velodyne_capture::revolutions::open_velodyne_capture;
use super::{AnnotatedClasses, Dataset, DatasetError};

type Recognises = fn(&Path) -> bool;
type Opens = fn(DatasetSource) -> Result<Box<dyn Dataset>, DatasetError>;

/// How to recognise and open a format.
pub struct FormatEntry {
    /// Whether data in this format lie at a path.
    pub is_at: Recognises,
    /// Properties that its files do not state, as in its benchmark.
    pub benchmark: Benchmark,
    /// Opens the data set of a source.
    pub open: Opens,
}

/// Properties that data in a format are taken to have, unless they or the catalogue state others.
#[derive(Clone, Copy)]
pub struct Benchmark {
    /// The classes that are annotated; `None` for every object.
    classes: Option<&'static [AnnotationClass]>,
    /// The sensor.
    pub sensor: &'static str,
    /// Its height above the road, in metres.
    pub sensor_height_m: f32,
}

impl Benchmark {
    /// The classes that are annotated.
    pub fn annotated(&self) -> AnnotatedClasses {
        self.classes.map_or(AnnotatedClasses::EveryObject, |it| AnnotatedClasses::Only(it.to_vec()))
    }
}

const KITTI: Benchmark =
    Benchmark { classes: Some(&KITTI_CLASSES), sensor: KITTI_SENSOR, sensor_height_m: KITTI_SENSOR_HEIGHT_M };

/// Every point has a label; points whose label leaves open whether they are an object are not judged.
const SEMANTIC_KITTI: Benchmark = Benchmark { classes: None, ..KITTI };

const ARGOVERSE2: Benchmark = Benchmark {
    classes: Some(&ARGOVERSE2_CLASSES),
    sensor: ARGOVERSE2_SENSOR,
    sensor_height_m: ARGOVERSE2_SENSOR_HEIGHT_M,
};

const NUSCENES: Benchmark = Benchmark {
    classes: Some(&NUSCENES_CLASSES),
    sensor: NUSCENES_SENSOR,
    sensor_height_m: NUSCENES_SENSOR_HEIGHT_M,
};

/// Labels of a recording include its vehicles; whether they include everything else is not known.
const RECORDING: Benchmark = Benchmark { classes: Some(&AnnotationClass::ALL), ..KITTI };

/// The entry of `format`.
pub fn entry_of(format: DatasetFormat) -> FormatEntry {
    let (is_at, benchmark, open): (Recognises, _, Opens) = match format {
        DatasetFormat::KittiTracking => (is_kitti_tracking, KITTI, open_kitti_tracking),
        DatasetFormat::KittiObject => (is_kitti_object, KITTI, open_kitti_object),
        DatasetFormat::SemanticKitti => (is_semantic_kitti, SEMANTIC_KITTI, open_semantic_kitti),
        DatasetFormat::Mcap => (is_mcap, RECORDING, open_mcap),
        DatasetFormat::Argoverse2 => (is_argoverse2, ARGOVERSE2, open_argoverse2),
        DatasetFormat::KittiRaw => (is_kitti_raw, KITTI, open_kitti_raw),
        DatasetFormat::NuScenes => (is_nuscenes, NUSCENES, open_nuscenes),
        DatasetFormat::VelodynePcap => (is_capture, RECORDING, open_velodyne_capture),
        // Parts of other layouts are folders of scans as well, so this format counts only where the user names it.
        DatasetFormat::ScanFolder => (|_| false, RECORDING, open_scan_folder),
    };
    FormatEntry { is_at, benchmark, open }
}
