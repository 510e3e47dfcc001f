//! Journal of the results so far, in a file that grows with them and survives the end of the program, however it ends.
//!
//! The first line identifies the work; every other line is a result. Each line is written at once, so that a program that is
//! interrupted loses only the result it was working on. Each line begins with a checksum of all contents up to its end: a
//! line that is changed, doubled, lost or out of place is detected, and neither it nor any line after it is used.

use std::collections::BTreeSet;
use std::fs::{File, TryLockError};
use std::io::{self, BufRead as _, BufReader, Read, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use reports::files::new_file::{has_no_locks, open_to_add};
use reports::files::regular_file::{BoundedLines, RegularFile};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// Everything that decides the results, by name.
pub type JournalIdentity = Map<String, Value>;

/// Kind of work that a journal belongs to, such as `sweep`.
pub type JournalKind = &'static str;

/// The longest line that is read, in bytes.
const MOST_OF_LINE: u64 = 1 << 30;

/// An open journal, which no other program can open.
#[derive(Debug)]
pub struct Journal {
    end: Mutex<JournalEnd>,
    path: PathBuf,
    n_entries: AtomicUsize,
    damaged_line: Option<usize>,
}

/// Where the next line goes.
#[derive(Debug)]
struct JournalEnd {
    file: File,
    checksum: LineChecksum,
}

/// Why a journal cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// It belongs to another sweep, or to another run.
    #[error("{path:?} belongs to another {kind}: {} differ; continue that {kind} with its own options, choose another directory, or start again with --overwrite", differences.join(", "))]
    Another {
        /// Kind of the journal.
        kind: JournalKind,
        /// The file.
        path: PathBuf,
        /// Full names of the entries that differ.
        differences: Vec<String>,
    },
    /// Its first line is damaged, or identifies nothing.
    #[error("{path:?} is not the journal of a {kind}, or is damaged; start again with --overwrite")]
    NoJournal {
        /// Kind that was expected.
        kind: JournalKind,
        /// The file.
        path: PathBuf,
    },
    /// Another program has it open.
    #[error("another {kind} is writing to {path:?}")]
    Locked {
        /// Kind of the journal.
        kind: JournalKind,
        /// The file.
        path: PathBuf,
    },
    /// The operating system refused.
    #[error("cannot write {path:?}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Its error.
        source: io::Error,
    },
}

/// How to treat a journal of other work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OtherJournal {
    /// Leave it and fail.
    Refuse,
    /// Empty it.
    Discard,
}

impl Journal {
    /// Opens the journal at `path`, or begins it, and hands its results to `on_entry`.
    ///
    /// The first line that is damaged, or that `on_entry` rejects as not of this work, is cut off with all lines after it;
    /// their results have to be computed again.
    ///
    /// # Errors
    ///
    /// [`JournalError`] if the file belongs to other work than `identity`, is in use, or cannot be written.
    pub fn open<Entry: DeserializeOwned>(
        path: &Path,
        kind: JournalKind,
        identity: &JournalIdentity,
        other: OtherJournal,
        mut on_entry: impl FnMut(Entry) -> bool,
    ) -> Result<Self, JournalError> {
        let refused = |source| JournalError::Io { path: path.to_owned(), source };
        let file = open_to_add(path).map_err(refused)?;
        match file.try_lock() {
            Ok(()) => {}
            // Not every file system knows locks.
            Err(TryLockError::Error(error)) if has_no_locks(&error) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(JournalError::Locked { kind, path: path.to_owned() });
            }
            Err(TryLockError::Error(source)) => return Err(refused(source)),
        }
        let mut lines = SoundLines::of(&file);
        let head = lines.next_line().map_err(refused)?;
        let has_head = head.is_some() || lines.damaged_line().is_some();
        let differences = head.as_deref().map(|it| differences(it, identity));
        let is_ours = match (differences, other) {
            (Some(Some(differences)), _) if differences.is_empty() => true,
            (Some(Some(differences)), OtherJournal::Refuse) => {
                return Err(JournalError::Another { kind, path: path.to_owned(), differences });
            }
            // So that no file of others is destroyed.
            _ if has_head && other == OtherJournal::Refuse => {
                return Err(JournalError::NoJournal { kind, path: path.to_owned() });
            }
            _ => false,
        };
        if !is_ours {
            let end = JournalEnd { file, checksum: LineChecksum::default() }.into();
            let journal = Self { end, path: path.to_owned(), n_entries: 0.into(), damaged_line: None };
            journal.restart(identity)?;
            return Ok(journal);
        }
        let mut n_entries = 0;
        lines
            .each_entry(|entry| {
                let is_sound = on_entry(entry);
                n_entries += usize::from(is_sound);
                is_sound
            })
            .map_err(refused)?;
        let (n_bytes, damaged_line, checksum) = (lines.n_bytes, lines.damaged_line(), lines.checksum);
        file.set_len(n_bytes).map_err(refused)?;
        let end = JournalEnd { file, checksum }.into();
        Ok(Self { end, path: path.to_owned(), n_entries: n_entries.into(), damaged_line })
    }

    /// Hands the results in the file at `path` to `on_entry`, as long as that returns true. Returns the number of the first
    /// line that is damaged, or that `on_entry` did not take.
    ///
    /// # Errors
    ///
    /// If the file cannot be read.
    pub fn read<Entry: DeserializeOwned>(
        path: &Path,
        on_entry: impl FnMut(Entry) -> bool,
    ) -> io::Result<Option<usize>> {
        let mut lines = SoundLines::of(RegularFile::open(path)?);
        lines.next_line()?;
        lines.each_entry(on_entry)?;
        Ok(lines.damaged_line())
    }

    /// Path of its file.
    pub fn path(&self) -> &Path {
        &self.path
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

    /// Number of the first line that was rejected when the journal was opened; `None` if there was none, or if only the
    /// last line was not written to its end.
    pub fn damaged_line(&self) -> Option<usize> {
        self.damaged_line
    }

    fn restart(&self, identity: &JournalIdentity) -> Result<(), JournalError> {
        {
            let mut end = self.end.lock().unwrap_or_else(PoisonError::into_inner);
            end.file.set_len(0).and_then(|()| end.file.rewind()).map_err(|source| self.refused(source))?;
        }
        self.add_line(identity)
    }

    fn add_line(&self, value: &impl Serialize) -> Result<(), JournalError> {
        let mut end = self.end.lock().unwrap_or_else(PoisonError::into_inner);
        let content = serde_json::to_vec(value).expect("a journal holds numbers and text alone");
        let mut line = format!("{:08x} ", end.checksum.add(&content)).into_bytes();
        line.extend(content);
        line.push(b'\n');
        end.file.write_all(&line).map_err(|source| self.refused(source))
    }

    fn refused(&self, source: io::Error) -> JournalError {
        JournalError::Io { path: self.path.clone(), source }
    }
}

/// Names of the entries that differ between `head` and `identity`, with dots between the names of nested tables; `None` if
/// `head` is no table.
fn differences(head: &[u8], identity: &JournalIdentity) -> Option<Vec<String>> {
    /// A longer list would not help the user.
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

/// A checksum of the contents of all lines so far.
#[derive(Debug, Clone, Default)]
struct LineChecksum(crc32fast::Hasher);

impl LineChecksum {
    /// Adds `content`. Returns the checksum of all contents up to it.
    fn add(&mut self, content: &[u8]) -> u32 {
        self.0.update(content);
        self.0.clone().finalize()
    }
}

/// The lines of a journal up to the first one that is damaged.
struct SoundLines<R> {
    reader: BufReader<BoundedLines<R>>,
    checksum: LineChecksum,
    n_lines: usize,
    // Bytes of the sound lines.
    n_bytes: u64,
    state: LineState,
}

/// State of the line after the sound ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LineState {
    /// Not read yet, or there is none.
    Unread,
    /// The last line, of which only the beginning was written.
    Half,
    /// Not as it was written.
    Damaged,
}

impl<R: Read> SoundLines<R> {
    fn of(reader: R) -> Self {
        let reader = BufReader::new(BoundedLines::new(reader, MOST_OF_LINE));
        let state = LineState::Unread;
        Self { reader, checksum: LineChecksum::default(), n_lines: 0, n_bytes: 0, state }
    }

    /// The content of the next line; `None` if it is damaged or there is none.
    fn next_line(&mut self) -> io::Result<Option<Vec<u8>>> {
        let mut line = Vec::new();
        match self.reader.read_until(b'\n', &mut line) {
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::FileTooLarge => {
                self.state = LineState::Damaged;
                return Ok(None);
            }
            Err(error) => return Err(error),
        }
        let Some(whole) = line.strip_suffix(b"\n") else {
            self.state = if line.is_empty() { LineState::Unread } else { LineState::Half };
            return Ok(None);
        };
        let mut checksum = self.checksum.clone();
        let sound = whole
            .split_at_checked(9)
            .filter(|(before, content)| *before == format!("{:08x} ", checksum.add(content)).as_bytes());
        let Some((_, content)) = sound else {
            self.state = LineState::Damaged;
            return Ok(None);
        };
        self.checksum = checksum;
        self.n_lines += 1;
        self.n_bytes += line.len() as u64;
        Ok(Some(content.to_vec()))
    }

    /// Hands the results of the remaining lines to `on_entry`, until it rejects one.
    fn each_entry<Entry: DeserializeOwned>(
        &mut self,
        mut on_entry: impl FnMut(Entry) -> bool,
    ) -> io::Result<()> {
        loop {
            let before = (self.checksum.clone(), self.n_lines, self.n_bytes);
            let Some(content) = self.next_line()? else { return Ok(()) };
            if !serde_json::from_slice(&content).is_ok_and(&mut on_entry) {
                (self.checksum, self.n_lines, self.n_bytes) = before;
                self.state = LineState::Damaged;
                return Ok(());
            }
        }
    }

    /// The number of the line that is damaged, from 1; `None` if none is.
    fn damaged_line(&self) -> Option<usize> {
        (self.state == LineState::Damaged).then_some(self.n_lines + 1)
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
        let journal = Journal::open(path, "sweep", &identity(seed), other, |it| {
            entries.push(it);
            true
        })?;
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
        let damaged_line = Journal::read(journal.path(), |it| {
            again.push(it);
            true
        });
        assert_eq!(damaged_line.unwrap(), None);
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
            assert!(entries.is_empty() && journal.damaged_line().is_none(), "{n_bytes}");
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
    fn a_line_that_is_not_as_it_was_written_is_not_believed_nor_what_follows() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.unfinished");
        let (journal, _) = open(&path, 1).unwrap();
        (0..4).for_each(|it| journal.add(&entry(it)).unwrap());
        drop(journal);
        let whole = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = whole.lines().collect();
        let check = |changed: &[&str], expected: &[usize], damaged_line: usize| {
            std::fs::write(&path, changed.join("\n") + "\n").unwrap();
            let (journal, entries) = open(&path, 1).unwrap();
            assert_eq!(entries, expected.iter().map(|it| entry(*it)).collect::<Vec<_>>(), "{changed:#?}");
            assert_eq!(journal.damaged_line(), Some(damaged_line), "{changed:#?}");
            // New results continue the lines that were kept.
            journal.add(&entry(9)).unwrap();
            drop(journal);
            let (journal, entries) = open(&path, 1).unwrap();
            assert_eq!(entries.len(), expected.len() + 1);
            assert_eq!(journal.damaged_line(), None);
        };
        let flipped = lines[2].replace("point 1", "point 7");
        check(&[lines[0], lines[1], &flipped, lines[3], lines[4]], &[0], 3);
        check(&[lines[0], lines[1], lines[2], lines[2], lines[3], lines[4]], &[0, 1], 4);
        check(&[lines[0], lines[1], lines[3], lines[4]], &[0], 3);
        check(&[lines[0], lines[2], lines[1], lines[3], lines[4]], &[], 2);
        check(&[lines[0], lines[1], "", lines[2]], &[0], 3);
        // The checksum itself, every bit of every byte of a line.
        for byte_idx in 0..lines[2].len() {
            let mut bytes = lines[2].as_bytes().to_vec();
            bytes[byte_idx] ^= 1;
            let Ok(changed) = String::from_utf8(bytes) else { continue };
            check(&[lines[0], lines[1], &changed, lines[3]], &[0], 3);
        }
    }

    #[test]
    fn a_result_that_is_none_of_the_work_is_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.unfinished");
        let (journal, _) = open(&path, 1).unwrap();
        (0..4).for_each(|it| journal.add(&entry(it)).unwrap());
        drop(journal);
        let before_the_third = |it: String| it < entry(2);
        let journal =
            Journal::open(&path, "sweep", &identity(1), OtherJournal::Refuse, before_the_third).unwrap();
        assert_eq!((journal.n_entries(), journal.damaged_line()), (2, Some(4)));
        drop(journal);
        assert_eq!(open(&path, 1).unwrap().1, [entry(0), entry(1)]);
    }

    #[test]
    fn a_damaged_head_is_refused_and_can_be_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.unfinished");
        drop(open(&path, 1).unwrap());
        let head = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, head.replacen("[1]", "[2]", 1)).unwrap();
        assert!(matches!(open(&path, 1), Err(JournalError::NoJournal { .. })));
        assert!(open_or(&path, 1, OtherJournal::Discard).is_ok());
        assert!(open(&path, 1).is_ok());
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
