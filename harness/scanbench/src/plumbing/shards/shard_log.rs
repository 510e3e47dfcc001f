//! Logs of shards: each shard leaves one, and `merge` reads them.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use evaluation::journal::Journal;
use reports::files::archive::ArchiveError;
use reports::files::new_file::add_name;
use reports::files::regular_file::RegularFile;
use reports::run_folder::run_directory::{RunDirectory, SHARD_LOG};
use reports::run_folder::shard_check::NamedShard;
use reports::run_folder::shard_record::{ShardFile, ShardRecord};
use scans::dataset::checksum::ContentChecksum;
use serde::de::DeserializeOwned;

use super::whole_manifest::Pieces;
use crate::plumbing::failure::Failure;

/// Leaves the events of `journal` as the log of the shard in `directory`.
pub fn leave_log(journal: &Journal, directory: &RunDirectory) -> Result<ShardFile, Failure> {
    let path = directory.path_of(SHARD_LOG);
    add_name(journal.path(), &path).map_err(|source| ArchiveError::Write { path: path.clone(), source })?;
    Ok(checksum_of(&path)?)
}

fn checksum_of(path: &Path) -> Result<ShardFile, ArchiveError> {
    let refused = |source| ArchiveError::Read { path: path.to_owned(), source };
    let mut file = RegularFile::open(path).map_err(refused)?;
    let (mut checksum, mut n_bytes, mut buffer) = (ContentChecksum::default(), 0, vec![0; 1 << 16]);
    loop {
        let n_read = file.read(&mut buffer).map_err(refused)?;
        if n_read == 0 {
            return Ok(ShardFile { name: SHARD_LOG.to_owned(), n_bytes, sha256: checksum.finish() });
        }
        checksum.add(&buffer[..n_read]);
        n_bytes += n_read as u64;
    }
}

/// Events of a shard, or of work in one piece, which is the only shard.
pub struct ShardLog<'a> {
    pub folder: PathBuf,
    /// The record of the shard in its manifest.
    pub record: &'a ShardRecord,
    // `None` for the log of a finished shard, which has a checksum.
    journal: Option<&'a Journal>,
}

impl<'a> ShardLog<'a> {
    /// The log of work that was just done, and whose `journal` is in `folder`.
    pub fn of_journal(folder: &Path, record: &'a ShardRecord, journal: &'a Journal) -> Self {
        Self { folder: folder.to_owned(), record, journal: Some(journal) }
    }

    /// The logs of `shards`, whose names are their paths, in this `order` of indices.
    pub fn in_order(shards: &'a [NamedShard], order: &[usize]) -> Vec<Self> {
        let log = |idx: &usize| {
            let NamedShard { name, manifest } = &shards[*idx];
            Some(Self { folder: name.into(), record: manifest.shard.as_ref()?, journal: None })
        };
        order.iter().filter_map(log).collect()
    }

    /// Whether it is of work in one piece, or of a shard.
    pub fn pieces(&self) -> Pieces {
        if self.journal.is_some() { Pieces::One } else { Pieces::Shards }
    }

    /// The failure that the shard is not as it was left.
    pub fn damaged(&self, problem: impl Into<String>) -> Failure {
        Failure::damaged_run(&self.folder, problem.into())
    }

    /// Hands all events to `on_event`, up to one that it fails on.
    pub fn each_event<Event: DeserializeOwned>(
        &self,
        mut on_event: impl FnMut(Event) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let path = match self.journal {
            Some(journal) => journal.path().to_owned(),
            None => self.checked_path()?,
        };
        let mut failure = None;
        let read = Journal::read(&path, |event| {
            failure = on_event(event).err();
            failure.is_none()
        });
        if let Some(failure) = failure {
            return Err(failure);
        }
        match read.map_err(|error| Failure::damaged_run(&self.folder, error))? {
            Some(line) => Err(self.damaged(format!("line {line} of {path:?} is damaged"))),
            None => Ok(()),
        }
    }

    /// The path of the log, after a check that it is as the shard left it.
    fn checked_path(&self) -> Result<PathBuf, Failure> {
        let Some(written) = &self.record.log else {
            return Err(self.damaged(format!(
                "its manifest says nothing of {SHARD_LOG}; if another version of scanbench made it, make the shard again"
            )));
        };
        let path = self.folder.join(SHARD_LOG);
        let found = checksum_of(&path).map_err(|error| Failure::damaged_run(&self.folder, error))?;
        if found == *written {
            return Ok(path);
        }
        let [found, written] =
            [&found, written].map(|it| format!("{} bytes with SHA-256 {}", it.n_bytes, it.sha256));
        Err(self.damaged(format!(
            "{SHARD_LOG} is not what the shard wrote: {found}, where {written} are expected"
        )))
    }
}
