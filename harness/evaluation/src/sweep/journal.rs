//! What a sweep has done so far, in a file that grows with it and outlives whatever ends the program.
//!
//! The first line says which sweep it is; every other one is a result. A line is written at once, so that a program that
//! is ended in the middle loses what it was doing and nothing else.

use std::collections::BTreeSet;
use std::fs::{File, TryLockError};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::sweep::scan_at_point::ScanAtPoint;
use crate::sweep::timed_scan::TimedScan;

/// A result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JournalEntry {
    /// Of the detections.
    Quality(ScanAtPoint),
    /// Of the clock.
    Times(TimedScan),
}

/// Everything that decides the results of a sweep, by name.
pub type SweepIdentity = Map<String, Value>;

/// An open journal, which no other program can open.
#[derive(Debug)]
pub struct Journal {
    file: Mutex<File>,
    path: PathBuf,
}

/// Why a journal cannot be worked with.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// It is that of another sweep.
    #[error("{path:?} belongs to another sweep: {} differ; continue that sweep with its own options, choose another directory, or start again with --overwrite", differences.join(", "))]
    Another {
        /// The file.
        path: PathBuf,
        /// What is not the same.
        differences: Vec<String>,
    },
    /// Its first line says nothing.
    #[error("{path:?} is not the journal of a sweep; remove it")]
    NoJournal {
        /// The file.
        path: PathBuf,
    },
    /// Another program has it open.
    #[error("another sweep is writing to {path:?}")]
    Locked {
        /// The file.
        path: PathBuf,
    },
    /// The operating system refused.
    #[error("cannot write {path:?}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
}

/// What to do with the journal of another sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OtherJournal {
    /// Leave it and fail.
    Refuse,
    /// Empty it.
    Discard,
}

impl Journal {
    /// Opens the journal at `path`, or begins it, and returns it with the results that are in it.
    ///
    /// Whatever stands from the first damaged line on, as a program that is ended in the middle of a line leaves it, is cut
    /// off, and is to be done again.
    ///
    /// # Errors
    ///
    /// [`JournalError`] if the file is of another sweep than `identity`, in use, or cannot be written.
    pub fn open(
        path: &Path,
        identity: &SweepIdentity,
        other: OtherJournal,
    ) -> Result<(Self, Vec<JournalEntry>), JournalError> {
        let refused = |source| JournalError::Io { path: path.to_owned(), source };
        let mut options = File::options();
        let mut file = options.read(true).append(true).create(true).open(path).map_err(refused)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(JournalError::Locked { path: path.to_owned() }),
            Err(TryLockError::Error(source)) => return Err(refused(source)),
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(refused)?;
        let mut lines = bytes.split_inclusive(|&byte| byte == b'\n');
        let head = lines.next().filter(|it| it.ends_with(b"\n"));
        let entries = match (head.map(|head| differences(head, identity)), other) {
            (Some(Some(differences)), _) if differences.is_empty() => {
                let (entries, n_bytes) = sound_entries(lines);
                let n_kept = head.map_or(0, <[u8]>::len) + n_bytes;
                file.set_len(n_kept as u64).map_err(refused)?;
                Some(entries)
            }
            (Some(Some(differences)), OtherJournal::Refuse) => {
                return Err(JournalError::Another { path: path.to_owned(), differences });
            }
            // Not to destroy what was never ours.
            (Some(None), OtherJournal::Refuse) => {
                return Err(JournalError::NoJournal { path: path.to_owned() });
            }
            _ => None,
        };
        let journal = Self { file: Mutex::new(file), path: path.to_owned() };
        let Some(entries) = entries else {
            journal.restart(identity)?;
            return Ok((journal, Vec::new()));
        };
        Ok((journal, entries))
    }

    /// Adds a result.
    ///
    /// # Errors
    ///
    /// [`JournalError::Io`] if the disk does not take it.
    pub fn add(&self, entry: &JournalEntry) -> Result<(), JournalError> {
        self.add_line(entry)
    }

    /// Removes the file: the results are elsewhere.
    ///
    /// # Errors
    ///
    /// [`JournalError::Io`] if the operating system refuses.
    pub fn remove(self) -> Result<(), JournalError> {
        std::fs::remove_file(&self.path).map_err(|source| self.refused(source))
    }

    fn restart(&self, identity: &SweepIdentity) -> Result<(), JournalError> {
        {
            let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
            file.set_len(0).and_then(|()| file.rewind()).map_err(|source| self.refused(source))?;
        }
        self.add_line(identity)
    }

    fn add_line(&self, value: &impl Serialize) -> Result<(), JournalError> {
        let mut line = serde_json::to_vec(value).expect("a journal holds numbers and text alone");
        line.push(b'\n');
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(&line).map_err(|source| self.refused(source))
    }

    fn refused(&self, source: io::Error) -> JournalError {
        JournalError::Io { path: self.path.clone(), source }
    }
}

/// The names under which `head` and `identity` do not say the same; `None` if `head` says nothing.
fn differences(head: &[u8], identity: &SweepIdentity) -> Option<Vec<String>> {
    let found: SweepIdentity = serde_json::from_slice(head).ok()?;
    let names: BTreeSet<&String> = found.keys().chain(identity.keys()).collect();
    let differ = names.into_iter().filter(|name| found.get(*name) != identity.get(*name));
    Some(differ.map(|name| name.replace('_', " ")).collect())
}

/// The results up to the first damaged line, and how many bytes they take.
fn sound_entries<'a>(lines: impl Iterator<Item = &'a [u8]>) -> (Vec<JournalEntry>, usize) {
    let (mut entries, mut n_bytes) = (Vec::new(), 0);
    for line in lines {
        match serde_json::from_slice(line) {
            Ok(entry) if line.ends_with(b"\n") => entries.push(entry),
            _ => break,
        }
        n_bytes += line.len();
    }
    (entries, n_bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::scan_at_point::DetectorAtPoint;

    fn identity(seed: u64) -> SweepIdentity {
        let Value::Object(identity) = serde_json::json!({ "data_sets": [seed], "points": ["0.1"] }) else {
            unreachable!("it is written so")
        };
        identity
    }

    fn entry(point_idx: usize) -> JournalEntry {
        let detectors = vec![DetectorAtPoint { counts: Vec::new(), cells: None }];
        JournalEntry::Quality(ScanAtPoint { dataset_idx: 0, scan_idx: 1, point_idx, detectors })
    }

    fn open(path: &Path, seed: u64) -> Result<(Journal, Vec<JournalEntry>), JournalError> {
        Journal::open(path, &identity(seed), OtherJournal::Refuse)
    }

    #[test]
    fn results_are_there_when_it_is_opened_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.unfinished");
        let (journal, entries) = open(&path, 1).unwrap();
        assert!(entries.is_empty());
        journal.add(&entry(0)).unwrap();
        journal.add(&entry(1)).unwrap();
        drop(journal);
        let (journal, entries) = open(&path, 1).unwrap();
        assert_eq!(entries, [entry(0), entry(1)]);
        journal.remove().unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn half_a_line_is_cut_off_and_what_follows_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.unfinished");
        let (journal, _) = open(&path, 1).unwrap();
        journal.add(&entry(0)).unwrap();
        drop(journal);
        let whole = std::fs::read(&path).unwrap();
        for n_bytes in [whole.len() - 1, whole.len() - 20] {
            std::fs::write(&path, &whole[..n_bytes]).unwrap();
            let (journal, entries) = open(&path, 1).unwrap();
            assert!(entries.is_empty(), "{n_bytes}");
            journal.add(&entry(7)).unwrap();
            drop(journal);
            assert_eq!(open(&path, 1).unwrap().1, [entry(7)]);
        }
        // Not even the head was written whole.
        std::fs::write(&path, &whole[..10]).unwrap();
        assert!(open(&path, 1).unwrap().1.is_empty());
        assert!(open(&path, 1).unwrap().1.is_empty());
    }

    #[test]
    fn the_journal_of_another_sweep_is_refused_and_says_why() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.unfinished");
        let (journal, _) = open(&path, 1).unwrap();
        journal.add(&entry(0)).unwrap();
        let locked = open(&path, 1).unwrap_err();
        assert!(matches!(locked, JournalError::Locked { .. }), "{locked}");
        drop(journal);
        let error = open(&path, 2).unwrap_err().to_string();
        assert!(error.contains("another sweep: data sets differ;"), "{error}");
        assert_eq!(open(&path, 1).unwrap().1, [entry(0)]);
        let (_, entries) = Journal::open(&path, &identity(2), OtherJournal::Discard).unwrap();
        assert!(entries.is_empty());
        assert!(open(&path, 2).is_ok());
    }

    #[test]
    fn what_is_no_journal_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.unfinished");
        std::fs::write(&path, "my diary\n").unwrap();
        assert!(matches!(open(&path, 1), Err(JournalError::NoJournal { .. })));
        assert_eq!(std::fs::read(&path).unwrap(), b"my diary\n");
    }
}
