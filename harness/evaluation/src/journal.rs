//! What work has done so far, in a file that grows with it and outlives whatever ends the program.
//!
//! The first line says what it belongs to; every other one is a result. A line is written at once, so that a program that
//! is ended in the middle loses what it was doing and nothing else.

use std::collections::BTreeSet;
use std::fs::{File, TryLockError};
use std::io::{self, BufRead as _, BufReader, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// Everything that decides the results, by name.
pub type JournalIdentity = Map<String, Value>;

/// What a journal is of, such as `sweep`.
pub type JournalKind = &'static str;

/// An open journal, which no other program can open.
#[derive(Debug)]
pub struct Journal {
    file: Mutex<File>,
    path: PathBuf,
    n_entries: AtomicUsize,
}

/// Why a journal cannot be worked with.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// It is that of another sweep, or of another run.
    #[error("{path:?} belongs to another {kind}: {} differ; continue that {kind} with its own options, choose another directory, or start again with --overwrite", differences.join(", "))]
    Another {
        /// What it is of.
        kind: JournalKind,
        /// The file.
        path: PathBuf,
        /// What is not the same.
        differences: Vec<String>,
    },
    /// Its first line says nothing.
    #[error("{path:?} is not the journal of a {kind}; remove it")]
    NoJournal {
        /// What it should be of.
        kind: JournalKind,
        /// The file.
        path: PathBuf,
    },
    /// Another program has it open.
    #[error("another {kind} is writing to {path:?}")]
    Locked {
        /// What it is of.
        kind: JournalKind,
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

/// What to do with a journal of something else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OtherJournal {
    /// Leave it and fail.
    Refuse,
    /// Empty it.
    Discard,
}

impl Journal {
    /// Opens the journal at `path`, or begins it, and hands the results that are in it to `on_entry`.
    ///
    /// Whatever stands from the first damaged line on, as a program that is ended in the middle of a line leaves it, is cut
    /// off, and is to be done again.
    ///
    /// # Errors
    ///
    /// [`JournalError`] if the file is of something else than `identity`, in use, or cannot be written.
    pub fn open<Entry: DeserializeOwned>(
        path: &Path,
        kind: JournalKind,
        identity: &JournalIdentity,
        other: OtherJournal,
        on_entry: impl FnMut(Entry),
    ) -> Result<Self, JournalError> {
        let refused = |source| JournalError::Io { path: path.to_owned(), source };
        let mut options = File::options();
        let file = options.read(true).append(true).create(true).open(path).map_err(refused)?;
        match file.try_lock() {
            Ok(()) => {}
            // Not every file system knows locks.
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {}
            Err(TryLockError::WouldBlock) => {
                return Err(JournalError::Locked { kind, path: path.to_owned() });
            }
            Err(TryLockError::Error(source)) => return Err(refused(source)),
        }
        let mut reader = BufReader::new(&file);
        let mut head = Vec::new();
        reader.read_until(b'\n', &mut head).map_err(refused)?;
        let differences = head.ends_with(b"\n").then(|| differences(&head, identity));
        let is_ours = match (differences, other) {
            (Some(Some(differences)), _) if differences.is_empty() => true,
            (Some(Some(differences)), OtherJournal::Refuse) => {
                return Err(JournalError::Another { kind, path: path.to_owned(), differences });
            }
            // Not to destroy what was never ours.
            (Some(None), OtherJournal::Refuse) => {
                return Err(JournalError::NoJournal { kind, path: path.to_owned() });
            }
            _ => false,
        };
        if is_ours {
            let mut n_entries = 0;
            let mut on_entry = on_entry;
            let counted = |entry| {
                n_entries += 1;
                on_entry(entry);
            };
            let n_bytes = each_sound_entry(&mut reader, counted).map_err(refused)?;
            file.set_len(head.len() as u64 + n_bytes).map_err(refused)?;
            let n_entries = n_entries.into();
            return Ok(Self { file: Mutex::new(file), path: path.to_owned(), n_entries });
        }
        let journal = Self { file: Mutex::new(file), path: path.to_owned(), n_entries: 0.into() };
        journal.restart(identity)?;
        Ok(journal)
    }

    /// Hands all results to `on_entry` once more.
    ///
    /// # Errors
    ///
    /// [`JournalError::Io`] if the file cannot be read.
    pub fn each_entry<Entry: DeserializeOwned>(
        &self,
        on_entry: impl FnMut(Entry),
    ) -> Result<(), JournalError> {
        let file = File::open(&self.path).map_err(|source| self.refused(source))?;
        let mut reader = BufReader::new(file);
        let head = reader.read_until(b'\n', &mut Vec::new());
        head.and_then(|_| each_sound_entry(&mut reader, on_entry)).map_err(|source| self.refused(source))?;
        Ok(())
    }

    /// Adds a result.
    ///
    /// # Errors
    ///
    /// [`JournalError::Io`] if the disk does not take it.
    pub fn add(&self, entry: &impl Serialize) -> Result<(), JournalError> {
        self.add_line(entry)?;
        self.n_entries.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }

    /// How many results it holds.
    pub fn n_entries(&self) -> usize {
        self.n_entries.load(Ordering::Relaxed)
    }

    fn restart(&self, identity: &JournalIdentity) -> Result<(), JournalError> {
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

/// The names under which `head` and `identity` do not say the same, with dots between those of tables within tables; `None`
/// if `head` says nothing.
fn differences(head: &[u8], identity: &JournalIdentity) -> Option<Vec<String>> {
    /// More of them say no more.
    const MOST: usize = 6;
    let found: JournalIdentity = serde_json::from_slice(head).ok()?;
    let mut names = Vec::new();
    add_differences("", &found, identity, &mut names);
    if names.len() > MOST {
        names.truncate(MOST);
        names.push("…".to_owned());
    }
    Some(names)
}

fn add_differences(table: &str, one: &JournalIdentity, other: &JournalIdentity, names: &mut Vec<String>) {
    let keys: BTreeSet<&String> = one.keys().chain(other.keys()).collect();
    for key in keys {
        match (one.get(key), other.get(key)) {
            (Some(Value::Object(one)), Some(Value::Object(other))) => {
                add_differences(&format!("{table}{key}."), one, other, names);
            }
            (one, other) if one != other => names.push(format!("{table}{key}")),
            _ => {}
        }
    }
}

/// Hands the results up to the first damaged line to `on_entry`, and returns how many bytes they take.
fn each_sound_entry<Entry: DeserializeOwned>(
    reader: &mut impl io::BufRead,
    mut on_entry: impl FnMut(Entry),
) -> io::Result<u64> {
    let (mut line, mut n_bytes) = (Vec::new(), 0);
    loop {
        line.clear();
        reader.read_until(b'\n', &mut line)?;
        match serde_json::from_slice(&line) {
            Ok(entry) if line.ends_with(b"\n") => on_entry(entry),
            _ => return Ok(n_bytes),
        }
        n_bytes += line.len() as u64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity(seed: u64) -> JournalIdentity {
        let walls = serde_json::json!({ "min_support": seed, "enabled": true });
        let identity =
            serde_json::json!({ "data_sets": [seed], "points": ["0.1"], "other": { "walls": walls } });
        let Value::Object(identity) = identity else { unreachable!("it is written so") };
        identity
    }

    /// A result as long as those of real sweeps.
    fn entry(point_idx: usize) -> String {
        format!("point {point_idx} of a sweep over cell sizes")
    }

    fn open(path: &Path, seed: u64) -> Result<(Journal, Vec<String>), JournalError> {
        open_or(path, seed, OtherJournal::Refuse)
    }

    fn open_or(path: &Path, seed: u64, other: OtherJournal) -> Result<(Journal, Vec<String>), JournalError> {
        let mut entries = Vec::new();
        let journal = Journal::open(path, "sweep", &identity(seed), other, |it| entries.push(it))?;
        Ok((journal, entries))
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
        let mut again: Vec<String> = Vec::new();
        journal.each_entry(|it| again.push(it)).unwrap();
        assert_eq!(again, entries);
        journal.add(&entry(2)).unwrap();
        assert_eq!(journal.n_entries(), 3);
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
        assert!(error.contains("another sweep: data_sets, other.walls.min_support differ;"), "{error}");
        assert_eq!(open(&path, 1).unwrap().1, [entry(0)]);
        let (_, entries) = open_or(&path, 2, OtherJournal::Discard).unwrap();
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
