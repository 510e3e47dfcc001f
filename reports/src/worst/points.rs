//! `worst_points.json`: what the sensor saw around the worst mistakes, as cells of a ground plan.
//!
//! Cells and not points: a page shows a few hundred pixels, and the file stays small.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::files::archive::{ArchiveError, SCHEMA, read_json};
use crate::worst::objects::ObjectName;

/// Side of a cell in metres.
pub const PLAN_CELL_M: f32 = 0.1;
/// Points higher than this above the road under the sensor stand on it, in metres.
pub const RAISED_M: f32 = 0.4;

/// Cells around the worst mistakes of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorstPoints {
    schema: u32,
    cell_m: f32,
    /// One for every object.
    pub patches: Vec<Patch>,
}

/// Cells around one object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Patch {
    /// The object.
    pub object: ObjectName,
    /// The cells.
    pub cells: PlanCells,
}

/// Cells with points, as steps of [`PLAN_CELL_M`] from the middle of the object: forward and left. Ascending.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanCells {
    /// With points near the level of the road alone.
    pub low: Vec<[i32; 2]>,
    /// With points that are [`RAISED_M`] above it or higher.
    pub high: Vec<[i32; 2]>,
}

impl WorstPoints {
    /// These cells, each object once.
    pub fn of_patches(mut patches: Vec<Patch>) -> Self {
        patches.sort_by(|a, b| a.object.cmp(&b.object));
        patches.dedup_by(|a, b| a.object == b.object);
        Self { schema: SCHEMA, cell_m: PLAN_CELL_M, patches }
    }

    /// The content of the file: one object a line.
    pub fn to_json(&self) -> String {
        let json = |it| serde_json::to_string(it).expect("a patch has text keys and whole numbers");
        let patches: Vec<String> = self.patches.iter().map(json).collect();
        format!(
            "{{\n\"schema\": {SCHEMA},\n\"cell_m\": {PLAN_CELL_M},\n\"patches\": [\n{}\n]\n}}\n",
            patches.join(",\n")
        )
    }

    /// Reads the file; `None` if there is none, as in runs of earlier versions.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if it cannot be read or is damaged.
    pub fn read(path: &Path) -> Result<Option<Self>, ArchiveError> {
        if path.exists() { read_json(path).map(Some) } else { Ok(None) }
    }

    /// The cells around `object`.
    pub fn around(&self, object: &ObjectName) -> Option<&PlanCells> {
        self.patches.iter().find(|it| it.object == *object).map(|it| &it.cells)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_read_back_as_they_were() {
        let [dataset, sequence] = ["street", "drive"].map(str::to_owned);
        let object = ObjectName { dataset, sequence, scan: 3, detector: None, id: 4 };
        let cells = PlanCells { low: vec![[-3, 2], [0, 1]], high: vec![[4, -5]] };
        let patches = vec![Patch { object: object.clone(), cells: cells.clone() }];
        let points = WorstPoints { schema: SCHEMA, cell_m: PLAN_CELL_M, patches };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("worst_points.json");
        assert_eq!(WorstPoints::read(&path).unwrap(), None);
        std::fs::write(&path, points.to_json()).unwrap();
        let read = WorstPoints::read(&path).unwrap().unwrap();
        assert_eq!(read, points);
        assert_eq!(read.around(&object), Some(&cells));
        assert_eq!(read.around(&ObjectName { id: 5, ..object }), None);
    }
}
