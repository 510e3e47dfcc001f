//! Files of shards, written with their checksums.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use reports::files::archive::ArchiveError;
use reports::files::whole_file::{WholeFile, write_whole};
use reports::run_folder::shard_record::ShardFile;
use scans::dataset::checksum::{ContentChecksum, sha256};
use serde::Serialize;

/// Writes `content` to the file `name` in `folder`.
pub fn write_checksummed(folder: &Path, name: &str, content: &[u8]) -> Result<ShardFile, ArchiveError> {
    write_whole(&folder.join(name), content)?;
    Ok(ShardFile { name: name.to_owned(), n_bytes: content.len() as u64, sha256: sha256(content) })
}

/// A file that grows, and its checksum with it.
pub struct ChecksummedFile {
    /// Where it will be.
    pub path: PathBuf,
    name: &'static str,
    file: WholeFile,
    checksum: ContentChecksum,
    n_bytes: u64,
}

impl ChecksummedFile {
    /// An empty one called `name` in `folder`.
    pub fn begin(folder: &Path, name: &'static str) -> Result<Self, ArchiveError> {
        let path = folder.join(name);
        let file = WholeFile::create(&path)?;
        Ok(Self { path, name, file, checksum: ContentChecksum::default(), n_bytes: 0 })
    }

    /// Adds `bytes`.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), ArchiveError> {
        self.checksum.add(bytes);
        self.n_bytes += bytes.len() as u64;
        let path = || self.path.clone();
        self.file.write_all(bytes).map_err(|source| ArchiveError::Write { path: path(), source })
    }

    /// Adds `value` as a line of JSON.
    pub fn write_json(&mut self, value: &impl Serialize) -> Result<(), ArchiveError> {
        let mut line = serde_json::to_vec(value).expect("it holds numbers and text alone");
        line.push(b'\n');
        self.write(&line)
    }

    /// Completes it, and says what it is.
    pub fn finish(self) -> Result<ShardFile, ArchiveError> {
        self.file.finish()?;
        Ok(ShardFile { name: self.name.to_owned(), n_bytes: self.n_bytes, sha256: self.checksum.finish() })
    }
}
