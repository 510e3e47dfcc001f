//! `recordings.json`: where the scans of the worst mistakes are recorded, of a run that was made in parts.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::files::archive::{ArchiveError, SCHEMA, pretty_json, read_json};
use crate::worst::objects::ObjectName;

/// The recordings of a run that was put together.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Recordings {
    schema: u32,
    /// One for every object whose scan is recorded.
    pub places: Vec<RecordedObject>,
}

/// An object whose scan is recorded.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedObject {
    /// Which object.
    pub object: ObjectName,
    /// The folder of the recording: one beside this file, or a path from there.
    pub recording: String,
    /// The position on its timeline.
    pub step: u64,
}

impl Recordings {
    /// The recordings of these objects.
    pub fn new(places: Vec<RecordedObject>) -> Self {
        Self { schema: SCHEMA, places }
    }

    /// The content of the file.
    pub fn to_json(&self) -> String {
        pretty_json(self)
    }

    /// Reads the file; `None` if there is none.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if it cannot be read or is damaged.
    pub fn read(path: &Path) -> Result<Option<Self>, ArchiveError> {
        if path.exists() { read_json(path).map(Some) } else { Ok(None) }
    }

    /// Where the scan of `object` is recorded.
    pub fn of(&self, object: &ObjectName) -> Option<&RecordedObject> {
        self.places.iter().find(|it| it.object == *object)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_read_back_as_they_were() {
        let [dataset, sequence] = ["street", "drive"].map(str::to_owned);
        let object = ObjectName { dataset, sequence, scan: 3, detector: None, id: 4 };
        let recorded =
            RecordedObject { object: object.clone(), recording: "../a/recording".to_owned(), step: 17 };
        let recordings = Recordings::new(vec![recorded.clone()]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("recordings.json");
        assert_eq!(Recordings::read(&path).unwrap(), None);
        std::fs::write(&path, recordings.to_json()).unwrap();
        let read = Recordings::read(&path).unwrap().unwrap();
        assert_eq!(read.of(&object), Some(&recorded));
        assert_eq!(read.of(&ObjectName { id: 5, ..object }), None);
    }
}
