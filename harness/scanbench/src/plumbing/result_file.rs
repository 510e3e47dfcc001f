//! Results for other programs: files that are written whole or not at all, or stdout.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use reports::files::archive::ArchiveError;
use reports::files::whole_file::WholeFile;

use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::standard_streams::print_bytes;

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Destination {
    /// Stdout; `-` on the command line.
    Stdout,
    File(PathBuf),
}

impl Destination {
    /// The destination that the command line calls `written`: `-`, or a path with one of `extensions`.
    pub fn new(written: &Path, extensions: &[&str]) -> Result<Self, Usage> {
        if written == Path::new("-") {
            return Ok(Self::Stdout);
        }
        let extension = written.extension().unwrap_or_default();
        if extensions.iter().any(|it| extension == *it) {
            return Ok(Self::File(written.to_owned()));
        }
        let endings: Vec<String> = extensions.iter().map(|it| format!(".{it}")).collect();
        let name = written.to_string_lossy();
        Err(Usage(format!("{name:?} must end in {}, or be -", endings.join(" or "))))
    }

    /// Fails before the work, and not after it, if nothing can be written there.
    pub fn check(&self) -> Result<(), ArchiveError> {
        let Self::File(path) = self else { return Ok(()) };
        if path.is_dir() {
            let source = std::io::ErrorKind::IsADirectory.into();
            return Err(ArchiveError::Write { path: path.clone(), source });
        }
        drop(WholeFile::create(path)?);
        Ok(())
    }
}

/// Writes all of `results`, the files first and all of these before the first one takes its name.
pub fn write_results(results: &[(Destination, Vec<u8>)]) -> Result<(), Failure> {
    let mut files = Vec::new();
    for (destination, content) in results {
        if let Destination::File(path) = destination {
            let mut file = WholeFile::create(path)?;
            let written = file.write_all(content).and_then(|()| file.flush());
            written.map_err(|source| ArchiveError::Write { path: path.clone(), source })?;
            files.push(file);
        }
    }
    files.into_iter().try_for_each(WholeFile::finish)?;
    let for_stdout = results.iter().filter(|(destination, _)| *destination == Destination::Stdout);
    for (_, content) in for_stdout {
        print_bytes(content)?;
    }
    Ok(())
}
