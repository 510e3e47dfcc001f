//! Rows to and from the CSV files of a run.

use std::io::Read;
use std::marker::PhantomData;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::files::archive::ArchiveError;
use crate::files::regular_file::{BoundedLines, RegularFile};
use crate::files::whole_file::WholeFile;

/// The longest line of a CSV file that is read, in bytes.
pub const MOST_OF_LINE: u64 = 1 << 20;

/// Columns that files of earlier programs lack; their values are empty there.
const ADDED_LATER: [&str; 5] = [
    "instructions",
    "peak_bytes",
    "detection_velocity_x_m_per_s",
    "detection_velocity_y_m_per_s",
    "detection_track",
];

/// A row of a CSV file.
pub trait CsvRow: Serialize + DeserializeOwned {
    /// The columns, in order; units are in the names.
    const COLUMNS: &'static [&'static str];
    /// The columns by field, with type and documentation.
    const FIELDS: &'static [CsvField] = &[];
}

/// Documentation of a field of a row, for readers of the file.
#[derive(Debug, Clone, Copy)]
pub struct CsvField {
    /// Its columns.
    pub columns: &'static [&'static str],
    /// The type in Rust of a value, or of all of them.
    pub kind: &'static str,
    /// Its meaning, if the name does not suffice; a string for each line.
    pub doc: &'static [&'static str],
}

/// Declares a struct whose fields are the columns of a row, in order. After `for Row:` they are the columns of the type
/// `Row`, which is written as the struct. A field of several columns, such as an array, has their names behind it.
macro_rules! row {
    ($(#[$of_struct:meta])* $visible:vis struct $name:ident { $($fields:tt)* }) => {
        row! { for $name: $(#[$of_struct])* $visible struct $name { $($fields)* } }
    };
    (for $row:ty: $(#[$of_struct:meta])* $visible:vis struct $name:ident {
        $(
            $(#[doc = $doc:literal])* $(#[serde $serde:tt])*
            $seen:vis $field:ident: $kind:ty $(= [$($column:literal),+ $(,)?])?,
        )*
    }) => {
        $(#[$of_struct])*
        $visible struct $name {
            $($(#[doc = $doc])* $(#[serde $serde])* $seen $field: $kind,)*
        }

        impl $crate::files::csv_rows::CsvRow for $row {
            const COLUMNS: &'static [&'static str] = row!(columns [] $($field $([$($column,)+])?,)*);
            const FIELDS: &'static [$crate::files::csv_rows::CsvField] = &[
                $($crate::files::csv_rows::CsvField {
                    columns: row!(columns [] $field $([$($column,)+])?,),
                    kind: stringify!($kind),
                    doc: &[$($doc),*],
                },)*
            ];
        }
    };
    (columns [$($before:expr,)*]) => { &[$($before),*] };
    (columns [$($before:expr,)*] $field:ident, $($rest:tt)*) => {
        row!(columns [$($before,)* stringify!($field),] $($rest)*)
    };
    (columns [$($before:expr,)*] $field:ident [$($column:expr,)+], $($rest:tt)*) => {
        row!(columns [$($before,)* $($column,)+] $($rest)*)
    };
}
pub(crate) use row;

/// Writes rows to a file that appears once it is complete.
#[derive(Debug)]
#[must_use = "rows that are not finished are thrown away"]
pub struct CsvRowWriter<Row> {
    writer: csv::Writer<WholeFile>,
    path: std::path::PathBuf,
    rows: PhantomData<Row>,
}

impl<Row: CsvRow> CsvRowWriter<Row> {
    /// Begins with the names of the columns.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if the file cannot be written.
    pub fn new(file: WholeFile) -> Result<Self, ArchiveError> {
        let path = file.path().to_path_buf();
        // The names are written here, so that a file without rows has them too.
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(file);
        writer.write_record(Row::COLUMNS).map_err(|error| not_written(&path, error))?;
        Ok(Self { writer, path, rows: PhantomData })
    }

    /// Appends a row.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if the file cannot be written, or if a number of the row is not finite.
    pub fn write(&mut self, row: &Row) -> Result<(), ArchiveError> {
        self.writer.serialize(row).map_err(|error| not_written(&self.path, error))
    }

    /// Completes the file.
    ///
    /// # Errors
    ///
    /// [`ArchiveError`] if the file cannot be written.
    pub fn finish(self) -> Result<(), ArchiveError> {
        let Self { writer, path, .. } = self;
        let file = writer.into_inner().map_err(|it| ArchiveError::Write { path, source: it.into_error() })?;
        file.finish()
    }
}

/// Rows as the content of a CSV file, without writing a file.
///
/// # Errors
///
/// If a number of a row is not finite.
pub fn to_csv_bytes<Row: CsvRow>(rows: &[Row]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(Row::COLUMNS)?;
    for row in rows {
        writer.serialize(row)?;
    }
    Ok(writer.into_inner().expect("memory takes all that is written"))
}

/// Rows as they stand in a CSV file, without the names of the columns.
///
/// # Errors
///
/// If a number of a row is not finite.
pub fn to_csv_lines<'a, Row: CsvRow + 'a>(
    rows: impl IntoIterator<Item = &'a Row>,
) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    Ok(writer.into_inner().expect("memory takes all that is written"))
}

/// Rows within other data, as the text of their lines: `#[serde(with = "csv_text")]`.
pub mod csv_text {
    use serde::de::Error as _;
    use serde::ser::Error as _;
    use serde::{Deserialize, Deserializer, Serializer};

    use super::{CsvRow, csv_head, each_row_of, to_csv_lines};
    use crate::files::causes::with_causes;

    /// Writes `rows`.
    ///
    /// # Errors
    ///
    /// If a number of a row is not finite.
    pub fn serialize<Row: CsvRow, S: Serializer>(rows: &[Row], serializer: S) -> Result<S::Ok, S::Error> {
        let lines = to_csv_lines(rows).map_err(S::Error::custom)?;
        serializer.serialize_str(&String::from_utf8(lines).map_err(S::Error::custom)?)
    }

    /// Reads rows.
    ///
    /// # Errors
    ///
    /// If a line is damaged.
    pub fn deserialize<'de, Row: CsvRow, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<Row>, D::Error> {
        let lines = String::deserialize(deserializer)?;
        let (mut rows, mut text) = (Vec::new(), csv_head::<Row>());
        text.extend(lines.into_bytes());
        let read = each_row_of(&*text, "rows".as_ref(), |row| rows.push(row));
        read.map_err(|error| D::Error::custom(with_causes(&error)))?;
        Ok(rows)
    }
}

/// The content of a CSV file whose columns are known when it is written, with the cells of every row.
pub fn csv_of_cells(columns: Vec<String>, rows: impl Iterator<Item = Vec<String>>) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in std::iter::once(columns).chain(rows) {
        writer.write_record(row).expect("memory takes all that is written");
    }
    writer.into_inner().expect("memory takes all that is written")
}

/// The line with the names of the columns.
pub fn csv_head<Row: CsvRow>() -> Vec<u8> {
    let mut line = Row::COLUMNS.join(",").into_bytes();
    line.push(b'\n');
    line
}

/// The error of writing to `path`: a full disk is not the fault of the row.
fn not_written(path: &Path, error: csv::Error) -> ArchiveError {
    let path = path.to_path_buf();
    if !error.is_io_error() {
        return ArchiveError::Csv { path, source: error };
    }
    match error.into_kind() {
        csv::ErrorKind::Io(source) => ArchiveError::Write { path, source },
        kind => unreachable!("{kind:?} is what the check above excludes"),
    }
}

/// Reads all rows of a CSV file.
///
/// # Errors
///
/// [`ArchiveError`] if the file cannot be read, has other columns, or a row (the source says at which line) does not
/// fit them or contradicts itself.
pub fn read_rows<Row: CsvRow>(path: &Path) -> Result<Vec<Row>, ArchiveError> {
    let mut rows = Vec::new();
    each_row(path, |row| rows.push(row))?;
    Ok(rows)
}

/// Hands the rows of a CSV file to `on_row`, one after the other.
///
/// # Errors
///
/// As [`read_rows`].
pub fn each_row<Row: CsvRow>(path: &Path, on_row: impl FnMut(Row)) -> Result<(), ArchiveError> {
    let file =
        RegularFile::open(path).map_err(|source| ArchiveError::Read { path: path.to_path_buf(), source })?;
    each_row_of(file, path, on_row)
}

/// Hands the rows of a CSV file from `reader` to `on_row`, one after the other. Errors call it `path`.
///
/// # Errors
///
/// As [`read_rows`].
pub fn each_row_of<Row: CsvRow>(
    reader: impl Read,
    path: &Path,
    mut on_row: impl FnMut(Row),
) -> Result<(), ArchiveError> {
    let bad_row = |source| ArchiveError::Csv { path: path.to_path_buf(), source };
    let mut reader = csv::Reader::from_reader(BoundedLines::new(reader, MOST_OF_LINE));
    let columns = reader.headers().map_err(bad_row)?;
    let is_early = |it: &&str| !ADDED_LATER.contains(it);
    let has_all = columns.iter().eq(Row::COLUMNS.iter().copied());
    if !has_all && !columns.iter().eq(Row::COLUMNS.iter().copied().filter(is_early)) {
        return Err(ArchiveError::Columns {
            path: path.to_path_buf(),
            expected: Row::COLUMNS.join(","),
            found: columns.iter().collect::<Vec<_>>().join(","),
        });
    }
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(bad_row)? {
        if !has_all {
            let mut early = record.iter();
            let values = Row::COLUMNS.iter().map(|it| if is_early(it) { early.next() } else { Some("") });
            record = values.map(Option::unwrap_or_default).collect();
        }
        // Fields are read by index: the check above has made sure of the columns.
        on_row(record.deserialize(None).map_err(bad_row)?);
    }
    Ok(())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Rows as the text of their file.
    pub(crate) fn csv_text<Row: CsvRow>(rows: &[Row]) -> String {
        String::from_utf8(to_csv_bytes(rows).unwrap()).unwrap()
    }

    /// The rows of such a text, or its error.
    pub(crate) fn rows_of<Row: CsvRow>(text: &str) -> Result<Vec<Row>, String> {
        let mut rows = Vec::new();
        let read = each_row_of(text.as_bytes(), Path::new("rows.csv"), |row| rows.push(row));
        read.map(|()| rows).map_err(|error| crate::files::causes::with_causes(&error))
    }
}
