//! A shard on the disk, and its files with their checksums.

use std::io::{self, BufRead as _, BufReader, Read};
use std::path::PathBuf;

use reports::files::archive::ArchiveError;
use reports::files::regular_file::{BoundedLines, RegularFile};
use reports::run_folder::run_directory::WORST_POINTS_JSON;
use reports::run_folder::shard_check::NamedShard;
use reports::run_folder::shard_record::{ShardFile, ShardRecord};
use reports::worst::objects::ObjectName;
use reports::worst::points::WorstPoints;
use scans::dataset::checksum::ContentChecksum;
use serde::de::DeserializeOwned;

use crate::commands::failure::Failure;

/// The longest line of JSON that is read, in bytes.
const MOST_OF_LINE: u64 = 1 << 28;

/// A shard on the disk.
pub struct ShardDirectory<'a> {
    /// Where it is.
    pub folder: PathBuf,
    /// What its manifest says of it.
    pub record: &'a ShardRecord,
}

impl<'a> ShardDirectory<'a> {
    /// The shards at the paths that are their names, in this order of their indices.
    pub fn in_order(shards: &'a [NamedShard], order: &[usize]) -> Vec<Self> {
        let directory = |idx: &usize| {
            let NamedShard { name, manifest } = &shards[*idx];
            Some(Self { folder: PathBuf::from(name), record: manifest.shard.as_ref()? })
        };
        order.iter().filter_map(directory).collect()
    }

    /// What was seen around its worst mistakes.
    pub fn worst_points(&self) -> Result<WorstPoints, Failure> {
        let read = WorstPoints::read(&self.folder.join(WORST_POINTS_JSON));
        let read = read.map_err(|error| Failure::damaged_run(&self.folder, error))?;
        read.ok_or_else(|| self.damaged(format!("it has no {WORST_POINTS_JSON}")))
    }

    /// It does not say what was seen around one of its worst mistakes.
    pub fn lacks(&self, object: &ObjectName) -> Failure {
        let ObjectName { dataset, sequence, scan, id, .. } = object;
        self.damaged(format!("{WORST_POINTS_JSON} lacks object {id} of scan {dataset} {sequence} {scan}"))
    }

    /// It is not as it was written.
    pub fn damaged(&self, problem: String) -> Failure {
        Failure::damaged_run(&self.folder, problem)
    }

    /// Opens the file `name`, of which all is to be read and then [checked](FileOfShard::check).
    pub fn open(&self, name: &str) -> Result<FileOfShard<'_>, Failure> {
        let written = self.record.files.iter().find(|it| it.name == name);
        let written = written.ok_or_else(|| self.damaged(format!("its manifest says nothing of {name}")))?;
        let path = self.folder.join(name);
        let source =
            RegularFile::open(&path).map_err(|source| ArchiveError::Read { path: path.clone(), source });
        let source = source.map_err(|error| Failure::damaged_run(&self.folder, error))?;
        Ok(FileOfShard { path, source, checksum: ContentChecksum::default(), n_bytes: 0, written })
    }

    /// Hands the values in the file `name`, each a line of JSON, to `on_value`, which may say what is wrong with one.
    pub fn each_line<Value: DeserializeOwned>(
        &self,
        name: &str,
        mut on_value: impl FnMut(Value) -> Result<(), String>,
    ) -> Result<(), Failure> {
        let mut reader = BufReader::new(BoundedLines::new(self.open(name)?, MOST_OF_LINE));
        let mut line = Vec::new();
        for number in 1_u64.. {
            line.clear();
            let path = || self.folder.join(name);
            let read = reader.read_until(b'\n', &mut line);
            let read = read.map_err(|source| ArchiveError::Read { path: path(), source });
            if read.map_err(|error| Failure::damaged_run(&self.folder, error))? == 0 {
                break;
            }
            let value = serde_json::from_slice(&line).map_err(|error| error.to_string());
            let problem = |it: String| self.damaged(format!("{name}, line {number}: {it}"));
            value.and_then(&mut on_value).map_err(problem)?;
        }
        reader.into_inner().into_inner().check(self)
    }
}

/// A file of a shard that is being read.
pub struct FileOfShard<'a> {
    /// Where it is.
    pub path: PathBuf,
    source: RegularFile,
    checksum: ContentChecksum,
    n_bytes: u64,
    written: &'a ShardFile,
}

impl FileOfShard<'_> {
    /// Compares what was read with what the shard wrote.
    pub fn check(self, shard: &ShardDirectory<'_>) -> Result<(), Failure> {
        let (n_bytes, sha256) = (self.n_bytes, self.checksum.finish());
        let ShardFile { name, n_bytes: expected_n_bytes, sha256: expected } = self.written;
        if (n_bytes, &sha256) == (*expected_n_bytes, expected) {
            return Ok(());
        }
        Err(shard.damaged(format!(
            "{name} is not what the shard wrote: {n_bytes} bytes with SHA-256 {sha256}, where {expected_n_bytes} bytes with SHA-256 {expected} are expected"
        )))
    }
}

impl Read for FileOfShard<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n_read = self.source.read(buffer)?;
        self.checksum.add(&buffer[..n_read]);
        self.n_bytes += n_read as u64;
        Ok(n_read)
    }
}
