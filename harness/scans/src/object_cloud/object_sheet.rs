//! Facts about a folder of objects beyond their points: whether they are simulated, and how each was seen.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::growing_cloud::Moment;
use crate::dataset::DatasetError;
use crate::dataset::on_disk::is_there;
use crate::dataset::simulation::Simulation;
use crate::dataset::text_file::read_text_file;

/// The name of the file, beside the folders of the classes.
pub const OBJECT_SHEET: &str = "objects.json";

/// Facts about a folder of objects beyond its files.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectSheet {
    /// The request to the simulator, if it made the objects.
    pub simulation: Option<Simulation>,
    /// How an object was seen, by folder and file, such as `car/car-0001.npy`; unknown for objects that are not listed.
    pub seen: BTreeMap<String, SeenObject>,
}

/// How an object was seen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeenObject {
    /// Its length, width and height in metres, seen and unseen parts, where they are known.
    pub extents_m: Option<[f32; 3]>,
    /// The moments at which it can be judged: number of points, seconds, and the distance in metres where it is known.
    pub moments: Vec<(usize, f64, Option<f32>)>,
}

impl SeenObject {
    /// The entry for an object with these extents and moments.
    pub fn of(extents_m: Option<[f32; 3]>, moments: &[Moment]) -> Self {
        let moments = moments.iter().map(|it| (it.n_points, it.time_s, it.distance_m)).collect();
        Self { extents_m, moments }
    }

    /// The moments, which must fit an object of `n_points` points. Errors are the rest of a sentence about the file.
    pub fn moments(&self, n_points: usize) -> Result<Vec<Moment>, String> {
        let moment = |&(n_points, time_s, distance_m): &_| Moment { n_points, time_s, distance_m };
        let moments: Vec<Moment> = self.moments.iter().map(moment).collect();
        let ascends = moments.is_sorted_by(|a, b| a.n_points <= b.n_points && a.time_s <= b.time_s);
        let n_last = moments.last().map(|it| it.n_points);
        if ascends && n_last == Some(n_points) {
            return Ok(moments);
        }
        Err(format!(
            "has moments that end with {n_last:?} points or do not ascend, of an object of {n_points}"
        ))
    }
}

impl ObjectSheet {
    /// The sheet in `folder`; an empty one if there is none.
    pub fn in_folder(folder: &Path) -> Result<Self, DatasetError> {
        let path = folder.join(OBJECT_SHEET);
        if !is_there(&path) {
            return Ok(Self::default());
        }
        let text = read_text_file(&path)?;
        serde_json::from_str(&text).map_err(|error| {
            let problem = format!("does not describe objects: {error}");
            DatasetError::Damaged { path, problem }
        })
    }

    /// The text of the file.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("fields with names are JSON")
    }
}
