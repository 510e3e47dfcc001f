//! Facts about a converted data set that its format has no place for: the file `scanbench.json` beside the scans, or the
//! same text in the metadata of a recording.

use std::path::Path;

use reports::files::archive::pretty_json;
use serde::{Deserialize, Serialize};

use super::on_disk::is_there;
use super::shown_name::is_printable;
use super::simulation::Simulation;
use super::text_file::read_text_file;
use super::{AnnotatedClasses, DatasetError};

/// The name of the file.
pub const DATA_SHEET: &str = "scanbench.json";

/// Facts about a data set beyond its files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataSheet {
    /// The classes that its annotations cover.
    pub annotated_classes: AnnotatedClasses,
    /// Height of the sensor above the road, in metres.
    pub sensor_height_m: f32,
    /// The sensor: an id, or the file that describes it.
    pub sensor: String,
    /// Its licence, where known.
    pub licence: Option<String>,
    /// The part of a scan that is labelled, in KITTI's layouts.
    #[serde(default)]
    pub labeled_region: LabeledRegion,
    /// The request to the simulator, if it made the scans.
    pub simulation: Option<Simulation>,
    /// Id and checksum of the data set that it was made from.
    pub made_from: Option<String>,
}

/// The part of a scan that is labelled in KITTI's layouts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LabeledRegion {
    /// Inside the camera image.
    #[default]
    Camera,
    /// All round.
    Everywhere,
    /// Given for each point by a file beside each scan.
    PerPoint,
}

impl DataSheet {
    /// The sheet in the folder of a data set, if there is one.
    pub fn in_folder(folder: &Path) -> Result<Option<Self>, DatasetError> {
        let path = folder.join(DATA_SHEET);
        if !is_there(&path) {
            return Ok(None);
        }
        let sheet = Self::from_json(&read_text_file(&path)?);
        let damaged =
            |problem| DatasetError::Damaged { path, problem: format!("is not a data sheet: {problem}") };
        sheet.map(Some).map_err(damaged)
    }

    /// Parses the sheet in `text`. Errors say what is wrong with it.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let sheet: Self = serde_json::from_str(text).map_err(|error| error.to_string())?;
        if let Some(text) = sheet.texts().find(|it| !it.chars().all(is_printable)) {
            return Err(format!("{text:?} has a control character"));
        }
        let height_m = sheet.sensor_height_m;
        if height_m > 0.0 && height_m.is_finite() {
            Ok(sheet)
        } else {
            Err(format!("sensor_height_m is {height_m}, but must be greater than 0"))
        }
    }

    fn texts(&self) -> impl Iterator<Item = &str> {
        let of_simulation = self.simulation.as_ref().map(Simulation::texts).unwrap_or_default();
        let own = [Some(&self.sensor), self.licence.as_ref(), self.made_from.as_ref()];
        own.into_iter().flatten().map(String::as_str).chain(of_simulation)
    }

    /// The sheet as a file.
    pub fn to_json(&self) -> String {
        pretty_json(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reports::vocabulary::class::AnnotationClass;

    fn sheet() -> DataSheet {
        DataSheet {
            annotated_classes: AnnotatedClasses::Only(vec![
                AnnotationClass::Car,
                AnnotationClass::ParkedCycle,
            ]),
            sensor_height_m: 1.8,
            sensor: "vlp-16".to_owned(),
            licence: None,
            labeled_region: LabeledRegion::Everywhere,
            simulation: None,
            made_from: Some("street 12ab".to_owned()),
        }
    }

    #[test]
    fn a_sheet_is_read_as_it_was_written() {
        for sheet in [sheet(), DataSheet { annotated_classes: AnnotatedClasses::EveryObject, ..sheet() }] {
            assert_eq!(DataSheet::from_json(&sheet.to_json()).unwrap(), sheet);
        }
    }

    #[test]
    fn mistakes_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(DataSheet::in_folder(folder.path()).unwrap(), None);
        for (from, to, problem) in [
            ("1.8", "-1.8", "sensor_height_m is -1.8, but must be greater than 0"),
            ("1.8", "\"high\"", "invalid type"),
            ("\"sensor\"", "\"sensors\"", "unknown field `sensors`"),
            ("vlp-16", "vlp\\u001b[31m", "\"vlp\\u{1b}[31m\" has a control character"),
            ("parked-cycle", "unicycle", "\"unicycle\" is not a class; classes are car"),
        ] {
            std::fs::write(folder.path().join(DATA_SHEET), sheet().to_json().replace(from, to)).unwrap();
            let message = DataSheet::in_folder(folder.path()).expect_err("a mistake").to_string();
            assert!(message.contains(DATA_SHEET) && message.contains(problem), "{message}");
        }
    }
}
