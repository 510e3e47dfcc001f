//! Tables in JSON, each a list of records, that are read record by record and never as a whole.

use std::fmt;
use std::marker::PhantomData;
use std::path::Path;

use reports::files::regular_file::RegularFile;
use serde::Deserializer as _;
use serde::de::{DeserializeOwned, SeqAccess, Visitor};

use crate::dataset::DatasetError;
use crate::dataset::python_json::python_json;

/// Passes every record of the table at `path` to `take`, in order; errors of `take` are the rest of a sentence about the
/// file.
pub fn read_table<Record: DeserializeOwned>(
    path: &Path,
    take: impl FnMut(Record) -> Result<(), String>,
) -> Result<(), DatasetError> {
    let file = RegularFile::open(path).map_err(DatasetError::io(path))?;
    let mut deserializer = serde_json::Deserializer::from_reader(python_json(file));
    let read = deserializer.deserialize_seq(RecordVisitor { take, record: PhantomData });
    read.and_then(|()| deserializer.end()).map_err(|error| DatasetError::Damaged {
        path: path.to_path_buf(),
        problem: format!("is not a table: {error}"),
    })
}

struct RecordVisitor<Record, Take> {
    take: Take,
    record: PhantomData<Record>,
}

impl<'de, Record, Take> Visitor<'de> for RecordVisitor<Record, Take>
where
    Record: DeserializeOwned,
    Take: FnMut(Record) -> Result<(), String>,
{
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a list of records")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut records: A) -> Result<(), A::Error> {
        while let Some(record) = records.next_element()? {
            (self.take)(record).map_err(serde::de::Error::custom)?;
        }
        Ok(())
    }
}
