//! Labelled scans from all sources.

use std::path::PathBuf;

use nalgebra::Isometry3;
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::task::Task;

use self::earlier_scans::Sweep;
use self::foreign_frame::ForeignFrame;
use self::kitti::label::KittiLabel;
use self::official::OfficialScan;
use self::simulation::Simulation;
use self::unpaired_files::{LeftOut, few_of};
use crate::annotation::{LabeledScan, ScanId};

pub mod shown_name;
pub mod error;
pub mod on_disk;

// Parts that several formats have in common.
pub mod text_file;
pub mod python_json;
pub mod numbered_files;
pub mod positioned_points;
pub mod packed_points;
pub mod point_columns;
pub mod point_array;
pub mod npy;
mod column_evidence;
mod column_meaning;
pub mod scan_columns;
pub mod feather;
pub mod png_size;
pub mod points_of_boxes;
pub mod upright_box;
pub mod pose;
pub mod time_pairs;
pub mod checksum;
pub mod class_table;
mod written_classes;
pub mod simulation;
pub mod data_sheet;
pub mod proposal_list;
pub mod dataset_format;
pub mod source;
pub mod unpaired_files;
pub mod scan_sizes;
pub mod foreign_frame;
pub mod official;
pub mod scan_times;
pub mod earlier_scans;
pub mod folder_name;

// The formats, a folder each.
pub mod kitti;
pub mod semantic_kitti;
pub mod mcap;
pub mod argoverse2;
pub mod kitti_raw;
pub mod nuscenes;
pub mod velodyne_capture;
pub mod scan_folder;
pub mod mounting;
pub mod labeled_ahead;
pub mod formats;

// From the user's name for a data set to the open data set, and to its scans that are run.
pub mod detect_format;
pub mod root_template;
pub mod download;
pub mod catalogue;
pub mod open;
pub mod scan_selection;

pub use error::DatasetError;

/// A series of labelled scans that are read one at a time.
pub trait Dataset: Send + Sync {
    /// Its description and its scans.
    fn listing(&self) -> &Listing;

    /// The data set that this one wraps, scan by scan; its answers are used where this one has none of its own.
    fn inner(&self) -> Option<&dyn Dataset> {
        None
    }

    /// Its description, known without reading a scan.
    fn description(&self) -> &DatasetDescription {
        &self.listing().description
    }

    /// The scans, in the order of their drives and times.
    fn scan_ids(&self) -> &[ScanId] {
        &self.listing().scan_ids
    }

    /// Reads scan `scan_idx` of [`Self::scan_ids`].
    fn read_scan(&self, scan_idx: usize) -> Result<LabeledScan, DatasetError>;

    /// When scan `scan_idx` was taken, in nanoseconds since some start of time, if the files state it.
    fn scan_time_ns(&self, scan_idx: usize) -> Option<u64> {
        self.inner()?.scan_time_ns(scan_idx)
    }

    /// How to find scans that are near one another.
    fn nearness(&self) -> Nearness {
        self.inner().map_or(Nearness::Times, Dataset::nearness)
    }

    /// The drive, or the block named by the user, that scan `scan_idx` counts to when intervals are estimated; `None` if it
    /// is its sequence.
    fn scan_block(&self, scan_idx: usize) -> Option<&str> {
        self.inner()?.scan_block(scan_idx)
    }

    /// Size of the file that holds scan `scan_idx` alone, in bytes: a measure of the work, without reading it. `None` where
    /// scans share a file, or have none.
    fn scan_n_bytes(&self, scan_idx: usize) -> Option<u64> {
        self.inner()?.scan_n_bytes(scan_idx)
    }

    /// Damaged parts that were left out when it was opened, since the user wants to skip damage.
    fn left_out(&self) -> Option<&str> {
        self.inner()?.left_out()
    }

    /// Scans without labels and labels without a scan that were left out for this reason.
    fn files_left_out(&self) -> &[LeftOut] {
        self.inner().map_or(&[], Dataset::files_left_out)
    }

    /// The name of the file of scan `scan_idx` without its ending, which may differ from its number; `None` where the format
    /// numbers its files.
    fn file_name(&self, scan_idx: usize) -> Option<&str> {
        self.inner()?.file_name(scan_idx)
    }

    /// Possible errors of labels and names as a whole, a line each: labels of missing scans, names that were not taken over.
    ///
    /// This may read through files.
    fn oddities(&self) -> Result<Vec<String>, DatasetError> {
        self.inner().map_or_else(|| Ok(Vec::new()), Dataset::oddities)
    }

    /// How labels were paired with scans, if the format has time stamps and they were not used: one line for the user, who
    /// may know better.
    fn note_of_labels(&self) -> Option<String> {
        self.inner()?.note_of_labels()
    }

    /// Pose of the sensor at scan `scan_idx`, in a frame that rests, if the files state it.
    fn world_from_sensor(&self, scan_idx: usize) -> Result<Option<Isometry3<f64>>, DatasetError> {
        self.inner().map_or(Ok(None), |it| it.world_from_sensor(scan_idx))
    }

    /// The last `n` scans that were taken before scan `scan_idx` in its drive, the latest first, annotated or not; `None` if
    /// all scans of the drive are in [`Self::scan_ids`].
    fn sweeps_before(&self, scan_idx: usize, n: usize) -> Result<Option<Vec<Sweep>>, DatasetError> {
        self.inner().map_or(Ok(None), |it| it.sweeps_before(scan_idx, n))
    }

    /// The labels of the points of scan `scan_idx`, which is `scan`, in SemanticKITTI's format; `None` in other formats.
    fn point_labels(&self, scan_idx: usize, scan: &LabeledScan) -> Result<Option<Vec<u32>>, DatasetError> {
        self.inner().map_or(Ok(None), |it| it.point_labels(scan_idx, scan))
    }

    /// The name of scan `scan_idx` in results of other programs, and the frame of their boxes.
    ///
    /// This may read the scan.
    fn foreign_frame(&self, scan_idx: usize) -> Result<ForeignFrame, DatasetError> {
        self.inner().map_or(Ok(ForeignFrame::Sensor), |it| it.foreign_frame(scan_idx))
    }

    /// The columns of points in files that do not name them, and how they are known; `None` if all files name them.
    ///
    /// # Errors
    ///
    /// If only the user can know them.
    fn columns(&self) -> Result<Option<String>, DatasetError> {
        self.inner().map_or(Ok(None), Dataset::columns)
    }

    /// The labels of scan `scan_idx` in KITTI's files, in their own frame and order; `None` in other formats.
    fn kitti_labels(&self, scan_idx: usize) -> Option<&[KittiLabel]> {
        self.inner()?.kitti_labels(scan_idx)
    }

    /// The labels of scan `scan_idx` as its makers evaluate them; `None` where the files have no more than the annotations.
    fn official_scan(&self, scan_idx: usize) -> Result<Option<OfficialScan>, DatasetError> {
        self.inner().map_or(Ok(None), |it| it.official_scan(scan_idx))
    }
}

/// How to find scans of a data set that are near one another, and so show the same objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nearness {
    /// By time stamps; without them by numbers, which count a tenth of a second each.
    Times,
    /// Not possible: scans were picked out of drives, and their numbers are no times.
    Unknown,
    /// By the blocks that the user has named for them.
    Named,
}

/// The line of [`Dataset::oddities`] about labels of missing scans; none if `names` is empty.
fn labels_without_scan(names: &[String]) -> Vec<String> {
    let line = || format!("labels of {} missing scans: {}", names.len(), few_of(names));
    (!names.is_empty()).then(line).into_iter().collect()
}

/// The description of a data set, and its scans in the order of their drives and times.
#[derive(Debug, Clone, PartialEq)]
pub struct Listing {
    /// The description, known without reading a scan.
    pub description: DatasetDescription,
    /// The scans.
    pub scan_ids: Vec<ScanId>,
}

/// Facts about a data set that are known without reading a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct DatasetDescription {
    /// The name used in tables and files.
    pub id: String,
    /// The format's name, such as `kitti-tracking`.
    pub format: String,
    /// Its folder or file; `None` if it is simulated on the fly.
    pub root: Option<PathBuf>,
    /// The classes that its annotations cover.
    pub annotated: AnnotatedClasses,
    /// Height of the sensor above the road, in metres.
    pub sensor_height_m: f32,
    /// The sensor: an id such as `hdl-64e-s2`, or the file that describes it.
    pub sensor: String,
    /// Its licence, where known.
    pub licence: Option<String>,
    /// SHA-256 that changes with the data set: of the files as [`checksum`] describes, or of the parameters and seed of a
    /// simulation.
    pub checksum: Option<String>,
    /// The request to the simulator; `None` for recorded scans.
    pub simulation: Option<Simulation>,
}

impl DatasetDescription {
    /// Whether a simulator made it. Results on it are always labelled as simulated.
    pub fn is_simulated(&self) -> bool {
        self.simulation.is_some()
    }
}

/// The objects of the street that a data set labels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum AnnotatedClasses {
    /// Every free-standing object: detections beyond the annotations are false.
    EveryObject,
    /// These classes only: whether other detections are false cannot be known.
    Only(Vec<AnnotationClass>),
}

impl AnnotatedClasses {
    /// Whether all objects of `task` are annotated, so that detections beyond them are known to be false.
    ///
    /// A data set with cars among its classes is taken to label all vehicles, under its own names for them.
    pub fn covers(&self, task: Task) -> bool {
        match (self, task) {
            (Self::EveryObject, _) => true,
            (Self::Only(_), Task::Objects) => false,
            (Self::Only(classes), Task::Vehicles) => classes.contains(&AnnotationClass::Car),
            (Self::Only(classes), Task::Class(class)) => {
                let of_it = AnnotationClass::ALL.into_iter().filter(|it| class.includes(*it));
                let mut of_it = of_it.peekable();
                classes.contains(&class) || of_it.peek().is_some() && of_it.all(|it| classes.contains(&it))
            }
        }
    }
}
