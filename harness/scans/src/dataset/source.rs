//! What a reader knows about the data set that it opens.

use std::collections::BTreeSet;
use std::path::PathBuf;

use super::class_table::ClassRules;
use super::data_sheet::{DataSheet, LabeledRegion};
use super::dataset_format::DatasetFormat;
use super::point_columns::PointColumns;
use super::simulation::Simulation;
use super::{AnnotatedClasses, DatasetDescription};

/// Where a data set lies, and what its files do not say.
#[derive(Debug, Clone, PartialEq)]
pub struct DatasetSource {
    /// The name used in tables and files.
    pub id: String,
    /// The file, or the folder that holds the scans and labels in the layout of the format.
    pub path: PathBuf,
    /// Which part of it is opened.
    pub parts: ChosenParts,
    /// Who says what follows.
    pub stated_by: StatedBy,
    /// What its annotations cover.
    pub annotated: AnnotatedClasses,
    /// Height of the sensor above the road, in metres.
    pub sensor_height_m: f32,
    /// The sensor, see [`DatasetDescription::sensor`].
    pub sensor: String,
    /// Its licence, where known.
    pub licence: Option<String>,
    /// Where labels in KITTI's layouts say something.
    pub labeled_region: LabeledRegion,
    /// What a simulation was asked for, if it made the scans.
    pub simulation: Option<Simulation>,
    /// What becomes of damaged parts that others do not depend on.
    pub damage: DamagePolicy,
    /// What the names of classes in its labels stand for.
    pub classes: ClassRules,
    /// The columns of points in files that do not name them, as the user says.
    pub columns: Option<PointColumns>,
}

/// Which part of a data set is opened, as far as its format has such parts. What is left out is all there is.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ChosenParts {
    /// Drives, logs or scenes of these names, such as `2011_09_26_drive_0001_sync` or `scene-0061`.
    pub sequences: Option<BTreeSet<String>>,
    /// Scans of these numbers.
    pub scans: Option<BTreeSet<u32>>,
    /// Topics of a recording.
    pub topics: TopicChoice,
}

/// Which topics of a recording were asked for.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TopicChoice {
    /// That of the clouds, or the address of the sensor in a capture of packets; the only one if this is left out.
    pub cloud: Option<String>,
    /// That of the annotations; `/annotations` or the only one if this is left out.
    pub annotations: Option<String>,
}

impl TopicChoice {
    /// These and, where one is left out, that of `other`.
    pub fn or(&self, other: &Self) -> Self {
        let either = |one: &Option<String>, other: &Option<String>| one.clone().or_else(|| other.clone());
        Self {
            cloud: either(&self.cloud, &other.cloud),
            annotations: either(&self.annotations, &other.annotations),
        }
    }
}

/// Who says what the files of a data set do not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StatedBy {
    /// Its entry in the catalogue, which has the last word.
    Catalogue,
    /// Nobody: it is taken to be as the benchmark of its format, unless it says otherwise itself.
    Nobody,
}

/// What becomes of damaged parts that others do not depend on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum DamagePolicy {
    /// They are errors.
    #[default]
    Refuse,
    /// They are left out.
    Skip,
}

impl DatasetSource {
    /// Takes over what the data set says about itself.
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
