//! Opens the data set that the user names, simulated or on disk.

use nalgebra::Isometry3;
use scans::dataset::class_table::ClassRules;
use scans::dataset::dataset_format::DatasetFormat;
use scans::dataset::labeled_ahead::LabeledAhead;
use scans::dataset::mounting::Mounting;
use scans::dataset::open::{ReadOptions, open_recorded};
use scans::dataset::point_columns::PointColumns;
use scans::dataset::source::{DamagePolicy, TopicChoice};
use scans::dataset::{Dataset, DatasetError};

use super::catalogue::Catalogue;
use super::simulated_street::{StreetDrive, open_simulated_street};

/// How a data set is opened other than the catalogue says.
#[derive(Debug, Clone, Default)]
pub struct OpenOptions {
    /// The format of a data set at a path; without it, the format is recognised by the files.
    pub format: Option<DatasetFormat>,
    /// The seed of a simulation.
    pub seed: Option<u64>,
    /// The number of scans of a simulation.
    pub n_simulated_scans: Option<u32>,
    /// The sensor: an id, or the path of a description.
    pub sensor: Option<String>,
    /// Height of the sensor above the road, in metres.
    pub sensor_height_m: Option<f32>,
    /// From the frame of the files to that of the sensor; nothing for a simulation.
    pub sensor_from_file: Option<Isometry3<f64>>,
    /// How far to either side of forward the labels reach, in degrees.
    pub labels_ahead_deg: Option<f32>,
    /// The columns of points in files that do not name them.
    pub columns: Option<PointColumns>,
    /// The topics of a recording; without them, those of the catalogue, or the only ones.
    pub topics: TopicChoice,
    /// How damage of parts that others do not depend on is treated.
    pub damage: DamagePolicy,
    /// Meanings of the names of classes in labels, as the user gives them; they override the catalogue.
    pub classes: ClassRules,
}

impl OpenOptions {
    /// The options for data sets on disk.
    pub fn of_files(&self) -> ReadOptions {
        let Self {
            format, topics, damage, classes, sensor, sensor_height_m, sensor_from_file, columns, ..
        } = self.clone();
        let mounting = Mounting { sensor, sensor_height_m, sensor_from_file };
        ReadOptions { format, topics, damage, classes, columns, mounting }
    }
}

/// Opens the data set of the catalogue that is called `id_or_path`, or else the one at that path, as
/// [`open_recorded`] does.
pub fn open_dataset(
    id_or_path: &str,
    options: &OpenOptions,
    catalogue: &Catalogue,
) -> Result<Box<dyn Dataset>, DatasetError> {
    if let Some(drive) = catalogue.simulated.get(id_or_path) {
        return open_drive(id_or_path, options, drive);
    }
    let dataset = open_recorded(id_or_path, &options.of_files(), catalogue)?;
    let description = dataset.description();
    if let Some(simulation) = &description.simulation
        && let Err(error) = simulation.read::<StreetDrive>()
    {
        let path = description.root.clone().unwrap_or_default();
        let problem = format!("has a description of its simulation that cannot be read: {error}");
        return Err(DatasetError::damaged(path, problem));
    }
    Ok(match options.labels_ahead_deg {
        Some(limit_deg) => Box::new(LabeledAhead::new(dataset, limit_deg)),
        None => dataset,
    })
}

fn open_drive(
    id: &str,
    options: &OpenOptions,
    drive: &StreetDrive,
) -> Result<Box<dyn Dataset>, DatasetError> {
    if let Some(asked_for) = options.format {
        return Err(DatasetError::other_format(id, "simulated", asked_for.name()));
    }
    let drive = StreetDrive {
        seed: options.seed.unwrap_or(drive.seed),
        n_scans: options.n_simulated_scans.unwrap_or(drive.n_scans),
        sensor: options.sensor.clone().unwrap_or_else(|| drive.sensor.clone()),
        sensor_height_m: options.sensor_height_m.or(drive.sensor_height_m),
        labeled_to_either_side_deg: options.labels_ahead_deg.or(drive.labeled_to_either_side_deg),
        ..drive.clone()
    };
    open_simulated_street(id, &drive)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::catalogue::built_in_catalogue;
    use scans::dataset::AnnotatedClasses;
    use scans::dataset::data_sheet::{DATA_SHEET, DataSheet, LabeledRegion};
    use scans::dataset::simulation::Simulation;

    /// A folder with one scan, which says that it was made by `simulation`.
    fn open(simulation: Simulation) -> Result<Box<dyn Dataset>, DatasetError> {
        let folder = tempfile::tempdir().unwrap();
        let sheet = DataSheet {
            annotated_classes: AnnotatedClasses::EveryObject,
            sensor_height_m: 1.8,
            sensor: "vlp-16".to_owned(),
            licence: None,
            labeled_region: LabeledRegion::Everywhere,
            simulation: Some(simulation),
            made_from: None,
        };
        std::fs::write(folder.path().join("0.bin"), [0; 16]).unwrap();
        std::fs::write(folder.path().join(DATA_SHEET), sheet.to_json()).unwrap();
        let path = folder.path().to_str().unwrap();
        open_dataset(path, &OpenOptions::default(), &built_in_catalogue().unwrap())
    }

    #[test]
    fn what_was_simulated_and_written_is_still_simulated() {
        let drive = built_in_catalogue().unwrap().simulated["street-narrow"].clone();
        let dataset = open(Simulation::of(&drive)).unwrap();
        assert!(dataset.description().is_simulated());
        assert_eq!(StreetDrive::of(dataset.description()), Some(drive));
    }

    #[test]
    fn a_simulation_of_something_else_is_refused() {
        let error = open(Simulation::of(&BTreeMap::from([("town", 5)]))).err().expect("no street");
        assert!(!error.is_usage_error() && error.to_string().contains("unknown field `town`"), "{error}");
    }
}
