//! Feather files: columns in Arrow's file format, plain or compressed by LZ4 or Zstandard.
//!
//! Arrow's own crate reads the descriptions, but not the columns: its reader trusts the sizes that a file claims.

use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::Path;

use arrow_ipc::{CompressionType, Field, Footer, Precision, RecordBatch, Type};
use half::f16;

use super::DatasetError;
use super::on_disk::bytes_of;

const MAGIC: &[u8; 6] = b"ARROW1";

/// All columns together may grow to this many bytes, or to this many times the size of the file, whichever is more.
const MAX_PLAIN_BYTES: usize = 64 << 20;
const MAX_GROWTH: usize = 64;

/// A file has fewer columns than this.
const MAX_COLUMNS: usize = 1024;

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// Whole numbers of any width.
    Integers(Vec<i64>),
    /// Numbers with a fraction, of any width.
    Numbers(Vec<f64>),
    /// Texts.
    Texts(Vec<String>),
}

/// The columns of a file by their names.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatherTable {
    columns: BTreeMap<String, Column>,
}

impl FeatherTable {
    /// Reads the columns called `names` of the file at `path`; others are ignored.
    pub fn read(path: &Path, names: &[&str]) -> Result<Self, DatasetError> {
        Self::read_some(path, names, &[])
    }

    /// Reads the columns called `names`, and those of `optional` that exist.
    pub fn read_some(path: &Path, names: &[&str], optional: &[&str]) -> Result<Self, DatasetError> {
        Self::parse(&bytes_of(path)?, names, optional).map_err(|problem| DatasetError::damaged(path, problem))
    }

    /// The columns called `names` in `bytes`, and those of `optional` that exist. Errors are the rest of a sentence about
    /// the file.
    pub fn parse(bytes: &[u8], names: &[&str], optional: &[&str]) -> Result<Self, String> {
        let footer = footer_of(bytes)?;
        let fields: Vec<Field<'_>> =
            footer.schema().and_then(|it| it.fields()).map(|it| it.iter().collect()).unwrap_or_default();
        if fields.len() > MAX_COLUMNS {
            return Err(format!("has {} columns, more than {MAX_COLUMNS}", fields.len()));
        }
        let mut columns: BTreeMap<String, Column> = BTreeMap::new();
        for name in names {
            let field = fields.iter().find(|it| it.name() == Some(name));
            let field = field.ok_or_else(|| format!("has no column {name:?}"))?;
            columns.insert((*name).to_owned(), empty_column(field)?);
        }
        let is_optional = |it: &Field<'_>| it.name().is_some_and(|it| optional.contains(&it));
        for field in fields.iter().filter(|it| is_optional(it)) {
            if let (Some(name), Ok(column)) = (field.name(), empty_column(field)) {
                columns.insert(name.to_owned(), column);
            }
        }
        let mut budget = ByteBudget::of_file(bytes.len());
        let mut n_batch_bytes = 0_usize;
        for block in footer.recordBatches().into_iter().flatten() {
            let offset = usize::try_from(block.offset()).unwrap_or(usize::MAX);
            let n_metadata_bytes = usize::try_from(block.metaDataLength()).unwrap_or(usize::MAX);
            let body_begin = offset.checked_add(n_metadata_bytes);
            let body_end = body_begin.and_then(|begin| {
                begin.checked_add(usize::try_from(block.bodyLength()).unwrap_or(usize::MAX))
            });
            let parts = body_begin.zip(body_end);
            let parts =
                parts.and_then(|(begin, end)| Some((bytes.get(offset..begin)?, bytes.get(begin..end)?)));
            let (metadata, body) = parts.ok_or("is cut off within a batch of rows")?;
            // Batches lie one behind the other: if they share bytes, they are larger than the file together.
            n_batch_bytes = n_batch_bytes.saturating_add(metadata.len() + body.len());
            if metadata.is_empty() || n_batch_bytes > bytes.len() {
                return Err("has batches of rows that are larger than the file".to_owned());
            }
            // The length of the description comes before it, in newer files after four bytes of ones.
            let skipped = if metadata.starts_with(&[0xff; 4]) { 8 } else { 4 };
            let message = arrow_ipc::root_as_message(metadata.get(skipped..).unwrap_or_default())
                .map_err(|error| format!("has a batch of rows without a description: {error}"))?;
            let batch = message.header_as_record_batch().ok_or("has a batch without rows")?;
            append_batch(&batch, body, &fields, &mut budget, &mut columns)?;
        }
        Ok(Self { columns })
    }

    /// Takes the column called `name`, as numbers.
    pub fn take_numbers(&mut self, name: &str) -> Result<Vec<f64>, String> {
        match self.columns.remove(name) {
            Some(Column::Numbers(numbers)) => Ok(numbers),
            Some(Column::Integers(numbers)) => Ok(numbers.into_iter().map(|it| it as f64).collect()),
            _ => Err(format!("has no numbers in the column {name:?}")),
        }
    }

    /// Takes the column called `name`, as whole numbers.
    pub fn take_integers(&mut self, name: &str) -> Result<Vec<i64>, String> {
        match self.columns.remove(name) {
            Some(Column::Integers(numbers)) => Ok(numbers),
            _ => Err(format!("has no whole numbers in the column {name:?}")),
        }
    }

    /// Takes the column called `name`, as texts.
    pub fn take_texts(&mut self, name: &str) -> Result<Vec<String>, String> {
        match self.columns.remove(name) {
            Some(Column::Texts(texts)) => Ok(texts),
            _ => Err(format!("has no texts in the column {name:?}")),
        }
    }
}

fn footer_of(bytes: &[u8]) -> Result<Footer<'_>, String> {
    let not_feather = "is not a Feather file, or is cut off: it does not begin and end with ARROW1";
    let inner = bytes.strip_prefix(MAGIC).and_then(|it| it.strip_suffix(MAGIC)).ok_or(not_feather)?;
    let (inner, length) = inner.split_last_chunk::<4>().ok_or(not_feather)?;
    let n_footer_bytes = usize::try_from(i32::from_le_bytes(*length)).unwrap_or(usize::MAX);
    let begin = inner.len().checked_sub(n_footer_bytes).ok_or("has a footer that is longer than the file")?;
    arrow_ipc::root_as_footer(&inner[begin..])
        .map_err(|error| format!("has a footer that cannot be read: {error}"))
}

fn empty_column(field: &Field<'_>) -> Result<Column, String> {
    match field.type_type() {
        Type::Int => Ok(Column::Integers(Vec::new())),
        Type::FloatingPoint => Ok(Column::Numbers(Vec::new())),
        Type::Utf8 | Type::LargeUtf8 => Ok(Column::Texts(Vec::new())),
        other => Err(format!("has a column {:?} of the type {other:?}", field.name().unwrap_or_default())),
    }
}

/// Appends the rows of a batch to `columns`.
fn append_batch(
    batch: &RecordBatch<'_>,
    body: &[u8],
    fields: &[Field<'_>],
    budget: &mut ByteBudget,
    columns: &mut BTreeMap<String, Column>,
) -> Result<(), String> {
    let n_rows = usize::try_from(batch.length()).map_err(|_| "has a batch with a negative number of rows")?;
    let codec = batch.compression().map(|it| it.codec());
    let mut buffers = batch.buffers().map(|it| it.iter()).into_iter().flatten();
    let mut next = || -> Result<&[u8], String> {
        let buffer = buffers.next().ok_or("has a batch that lacks a column")?;
        let begin = usize::try_from(buffer.offset()).unwrap_or(usize::MAX);
        let end = begin.checked_add(usize::try_from(buffer.length()).unwrap_or(usize::MAX));
        Ok(end.and_then(|end| body.get(begin..end)).ok_or("has a column that ends beyond its batch")?)
    };
    for field in fields {
        let column = field.name().and_then(|name| columns.get_mut(name));
        match field.type_type() {
            Type::Null => {}
            kind @ (Type::Utf8 | Type::LargeUtf8 | Type::Binary | Type::LargeBinary) => {
                let (_validity, offsets, data) = (next()?, next()?, next()?);
                if let Some(Column::Texts(texts)) = column {
                    let (offsets, data) = (plain(offsets, codec, budget)?, plain(data, codec, budget)?);
                    let offsets = if kind == Type::LargeUtf8 {
                        large_offsets(&offsets)
                    } else {
                        small_offsets(&offsets)
                    };
                    append_texts(&offsets, &data, n_rows, texts)?;
                }
            }
            Type::Int | Type::FloatingPoint | Type::Bool | Type::Date | Type::Time | Type::Timestamp => {
                let (_validity, values) = (next()?, next()?);
                if let Some(column) = column {
                    append_numbers(field, &plain(values, codec, budget)?, n_rows, column)?;
                }
            }
            other => return Err(format!("has a column of the type {other:?}, which is not read")),
        }
    }
    Ok(())
}

/// The bytes that decompressed columns may still take.
struct ByteBudget {
    n_left: usize,
}

impl ByteBudget {
    fn of_file(n_bytes: usize) -> Self {
        Self { n_left: MAX_PLAIN_BYTES.max(n_bytes.saturating_mul(MAX_GROWTH)) }
    }

    fn spend(&mut self, n_bytes: usize) -> Option<usize> {
        self.n_left = self.n_left.checked_sub(n_bytes)?;
        Some(n_bytes)
    }
}

/// The decompressed bytes of a buffer. If there is a codec, the size comes first, -1 if the buffer is not compressed.
fn plain(buffer: &[u8], codec: Option<CompressionType>, budget: &mut ByteBudget) -> Result<Vec<u8>, String> {
    let too_much = |n_bytes: usize| format!("has columns that are {n_bytes} bytes too large");
    let Some(codec) = codec.filter(|_| !buffer.is_empty()) else {
        budget.spend(buffer.len()).ok_or_else(|| too_much(buffer.len()))?;
        return Ok(buffer.to_vec());
    };
    let (size, compressed) = buffer.split_first_chunk::<8>().ok_or("has a column without its size")?;
    let size = i64::from_le_bytes(*size);
    if size == -1 {
        budget.spend(compressed.len()).ok_or_else(|| too_much(compressed.len()))?;
        return Ok(compressed.to_vec());
    }
    let size = usize::try_from(size).ok().and_then(|size| budget.spend(size)).ok_or_else(|| {
        format!("has a column of {} bytes that claims to be {size} uncompressed", compressed.len())
    })?;
    let mut plain = Vec::new();
    let read = match codec {
        CompressionType::LZ4_FRAME => {
            lz4::Decoder::new(compressed).and_then(|it| it.take(size as u64 + 1).read_to_end(&mut plain))
        }
        CompressionType::ZSTD => {
            zstd::Decoder::new(compressed).and_then(|it| it.take(size as u64 + 1).read_to_end(&mut plain))
        }
        other => return Err(format!("has a column compressed by {other:?}")),
    };
    read.map_err(|error| format!("has a column that does not decompress: {error}"))?;
    if plain.len() == size {
        Ok(plain)
    } else {
        Err(format!("has a column of {} bytes, not {size}", plain.len()))
    }
}

fn append_numbers(
    field: &Field<'_>,
    values: &[u8],
    n_rows: usize,
    column: &mut Column,
) -> Result<(), String> {
    match column {
        Column::Integers(to) => {
            let int = field.type_as_int().ok_or("has a column without a width")?;
            match (int.bitWidth(), int.is_signed()) {
                (8, true) => append_rows(to, values, n_rows, |it| i64::from(i8::from_le_bytes(it))),
                (8, false) => append_rows(to, values, n_rows, |it| i64::from(u8::from_le_bytes(it))),
                (16, true) => append_rows(to, values, n_rows, |it| i64::from(i16::from_le_bytes(it))),
                (16, false) => append_rows(to, values, n_rows, |it| i64::from(u16::from_le_bytes(it))),
                (32, true) => append_rows(to, values, n_rows, |it| i64::from(i32::from_le_bytes(it))),
                (32, false) => append_rows(to, values, n_rows, |it| i64::from(u32::from_le_bytes(it))),
                (64, _) => append_rows(to, values, n_rows, i64::from_le_bytes),
                (width, _) => Err(format!("has a column of whole numbers of {width} bits")),
            }
        }
        Column::Numbers(to) => {
            let float = field.type_as_floating_point().ok_or("has a column without a width")?;
            match float.precision() {
                Precision::HALF => append_rows(to, values, n_rows, |it| f16::from_le_bytes(it).to_f64()),
                Precision::SINGLE => append_rows(to, values, n_rows, |it| f64::from(f32::from_le_bytes(it))),
                Precision::DOUBLE => append_rows(to, values, n_rows, f64::from_le_bytes),
                other => Err(format!("has a column of numbers of the precision {other:?}")),
            }
        }
        Column::Texts(_) => Ok(()),
    }
}

/// Appends the first `n_rows` of `values`, of `N` bytes each.
fn append_rows<T, const N: usize>(
    to: &mut Vec<T>,
    values: &[u8],
    n_rows: usize,
    number_of: impl Fn([u8; N]) -> T,
) -> Result<(), String> {
    let (rows, _) = values.as_chunks::<N>();
    let wanted = rows.get(..n_rows);
    let wanted = wanted.ok_or_else(|| format!("has a column of {} rows, not {n_rows}", rows.len()))?;
    to.extend(wanted.iter().map(|it| number_of(*it)));
    Ok(())
}

/// Starts and ends of texts, in four bytes each; negative ones become the greatest offset, beyond everything.
fn small_offsets(bytes: &[u8]) -> Vec<usize> {
    let (offsets, _) = bytes.as_chunks::<4>();
    offsets.iter().map(|it| usize::try_from(i32::from_le_bytes(*it)).unwrap_or(usize::MAX)).collect()
}

/// Starts and ends of texts in eight bytes each, as pandas and Polars write them.
fn large_offsets(bytes: &[u8]) -> Vec<usize> {
    let (offsets, _) = bytes.as_chunks::<8>();
    offsets.iter().map(|it| usize::try_from(i64::from_le_bytes(*it)).unwrap_or(usize::MAX)).collect()
}

fn append_texts(
    offsets: &[usize],
    data: &[u8],
    n_rows: usize,
    texts: &mut Vec<String>,
) -> Result<(), String> {
    if n_rows == 0 {
        return Ok(());
    }
    let bounds = n_rows.checked_add(1).and_then(|n| offsets.get(..n));
    let bounds = bounds.ok_or_else(|| format!("has a column of fewer than {n_rows} texts"))?;
    for pair in bounds.windows(2) {
        let text = data.get(pair[0]..pair[1]).and_then(|it| std::str::from_utf8(it).ok());
        texts.push(text.ok_or("has a text that is not UTF-8 or lies beyond its column")?.to_owned());
    }
    Ok(())
}
