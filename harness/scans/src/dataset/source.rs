//! Facts for the reader that opens a data set.

use std::collections::BTreeSet;
use std::path::PathBuf;

use super::class_table::ClassRules;
use super::data_sheet::{DataSheet, LabeledRegion};
use super::dataset_format::DatasetFormat;
use super::point_columns::PointColumns;
use super::simulation::Simulation;
use super::{AnnotatedClasses, DatasetDescription};

/// The path of a data set, and properties that its files do not state.
#[derive(Debug, Clone, PartialEq)]
pub struct DatasetSource {
    /// The name used in tables and files.
    pub id: String,
    /// The file, or the folder that holds the scans and labels in the layout of the format.
    pub path: PathBuf,
    /// The part of it that is opened.
    pub parts: ChosenParts,
    /// The source of the properties below.
    pub stated_by: StatedBy,
    /// The classes that its annotations cover.
    pub annotated: AnnotatedClasses,
    /// Height of the sensor above the road, in metres.
    pub sensor_height_m: f32,
    /// The sensor, see [`DatasetDescription::sensor`].
    pub sensor: String,
    /// Its licence, where known.
    pub licence: Option<String>,
    /// The part of a scan that is labelled, in KITTI's layouts.
    pub labeled_region: LabeledRegion,
    /// The request to the simulator, if it made the scans.
    pub simulation: Option<Simulation>,
    /// Handling of damaged parts that others do not depend on.
    pub damage: DamagePolicy,
    /// Rules for the names of classes in its labels.
    pub classes: ClassRules,
    /// The columns of points in files that do not name them, from the user.
    pub columns: Option<PointColumns>,
}

/// The part of a data set to open, if its format has such parts. `None` stands for all.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ChosenParts {
    /// Drives, logs or scenes of these names, such as `2011_09_26_drive_0001_sync` or `scene-0061`.
    pub sequences: Option<BTreeSet<String>>,
    /// Scans of these numbers.
    pub scans: Option<BTreeSet<u32>>,
    /// Topics of a recording.
    pub topics: TopicChoice,
}

/// The topics of a recording that were asked for.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TopicChoice {
    /// The topic of the clouds, or the address of the sensor in a capture of packets; the only one if `None`.
    pub cloud: Option<String>,
    /// The topic of the annotations; `/annotations` or the only one if `None`.
    pub annotations: Option<String>,
}

impl TopicChoice {
    /// These topics; that of `other` where one is missing.
    pub fn or(&self, other: &Self) -> Self {
        let either = |one: &Option<String>, other: &Option<String>| one.clone().or_else(|| other.clone());
        Self {
            cloud: either(&self.cloud, &other.cloud),
            annotations: either(&self.annotations, &other.annotations),
        }
    }
}

/// The source of properties that the files of a data set do not state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StatedBy {
    /// Its entry in the catalogue, which overrides all others.
    Catalogue,
    /// It is taken to be as the benchmark of its format, unless its data sheet states otherwise.
    Nobody,
}

/// Handling of damaged parts that others do not depend on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum DamagePolicy {
    /// They are errors.
    #[default]
    Refuse,
    /// They are left out.
    Skip,
}

impl DatasetSource {
    /// Takes over the data sheet of the data set.
    pub fn take_sheet(&mut self, sheet: DataSheet) {
        self.simulation = sheet.simulation;
        self.labeled_region = sheet.labeled_region;
        if self.stated_by == StatedBy::Nobody {
            self.annotated = sheet.annotated_classes;
            self.sensor_height_m = sheet.sensor_height_m;
            self.sensor = sheet.sensor;
            self.licence = sheet.licence;
        }
    }

    /// The description of the recorded data set, once its files are known.
    pub fn describe(self, format: DatasetFormat, checksum: String) -> DatasetDescription {
        DatasetDescription {
            id: self.id,
            format: format.name().to_owned(),
            root: Some(self.path),
            annotated: self.annotated,
            sensor_height_m: self.sensor_height_m,
            sensor: self.sensor,
            licence: self.licence,
            checksum: Some(checksum),
            simulation: self.simulation,
        }
    }
}
