//! Work that is not finished: what it has done so far is kept beside the directory that it will have.

use std::ffi::{OsStr, OsString};
use std::fs::DirEntry;
use std::path::{Path, PathBuf};
use std::time::Duration;

use evaluation::journal::{Journal, JournalIdentity, OtherJournal};
use evaluation::run::config::DETECTOR_TABLE;
use reports::files::archive::ArchiveError;
use reports::files::hidden_folder::HiddenFolder;
use reports::files::new_file::make_folder;
use reports::files::whole_file::is_unfinished_file;
use reports::run_folder::run_directory::RECORDING;
use reports::run_folder::run_target::ClaimedTarget;
use reports::vocabulary::shard::Shard;
use reports::vocabulary::study::Study;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::work_output::WorkOutput;
use crate::plumbing::failure::Failure;
use crate::plumbing::interruption::{set_grace, set_last_words};
use crate::plumbing::standard_streams::print_diagnostic;

/// A scheduler that ends a program waits this long for it, or longer: half a minute is usual.
const GRACE: Duration = Duration::from_secs(25);

/// The journal, in the folder of unfinished work.
const JOURNAL: &str = "journal";

/// Endings of the other files that are left there.
const ENDINGS: [&str; 4] = ["csv", "json", "rrd", "mcap"];

/// Facts that decide the rows of a result: its `manifest`, without what may differ when it is continued, and `rules` that
/// the manifest lacks.
pub fn identity_of(manifest: &impl Serialize, rules: Value) -> JournalIdentity {
    let mut value = serde_json::to_value(manifest).expect("a manifest has text keys only");
    let identity = value.as_object_mut().expect("a manifest is an object");
    // Peers are left out, too: their results are read when all is done.
    for passing in ["created", "argv", "machine"] {
        identity.remove(passing);
    }
    for (part, passing) in [("shard", "created"), ("partial", "peers")] {
        if let Some(part) = identity.get_mut(part).and_then(Value::as_object_mut) {
            part.remove(passing);
        }
    }
    leave_out_idle_detectors(identity);
    identity.insert("rules".to_owned(), rules);
    std::mem::take(identity)
}

/// Removes the parameters of foreign detectors that do not take part from `manifest`.
fn leave_out_idle_detectors(manifest: &mut JournalIdentity) {
    let names = |it: &Value| it["name"].as_str().map(str::to_owned);
    let taking_part: Vec<String> =
        manifest.get("detectors").and_then(Value::as_array).into_iter().flatten().filter_map(names).collect();
    let Some(config) = manifest.get_mut("config").and_then(Value::as_object_mut) else { return };
    if let Some(of_others) = config.get_mut(DETECTOR_TABLE).and_then(Value::as_object_mut) {
        of_others.retain(|name, _| taking_part.contains(name));
        if of_others.is_empty() {
            config.remove(DETECTOR_TABLE);
        }
    }
}

/// A result in the making: a shard, or all in one piece.
pub struct UnfinishedWork {
    // Removes the folder of work that is not kept. Invariant: before the folders around it, which `claimed` removes.
    passing: Option<HiddenFolder>,
    /// Folder of its files until there is a result.
    pub folder: PathBuf,
    /// Events of the work that is done so far.
    pub journal: Journal,
    /// Where the result will be.
    pub claimed: ClaimedTarget,
    // Extent, such as `60 scans`, and part, such as `shard 3/8`.
    extent: String,
    shard: Option<Shard>,
    is_named: bool,
}

impl UnfinishedWork {
    /// Opens the unfinished work in `output`, called after the data sets `ids` unless it is named, or begins it; `extent` is
    /// what it has, such as `60 scans`. Events that were done before go to `on_event`, which returns whether they can be of
    /// this work.
    ///
    /// From now on, a shard that is asked to end has `GRACE` for it.
    pub fn open<Event: DeserializeOwned>(
        mut output: WorkOutput,
        ids: &str,
        identity: &JournalIdentity,
        extent: String,
        on_event: impl FnMut(Event) -> bool,
    ) -> Result<Self, Failure> {
        let claimed = output.target(ids)?;
        let kept = kept_beside(&claimed);
        let refused = |source| ArchiveError::Write { path: kept.clone(), source };
        let passing = if output.is_kept {
            make_beside(&claimed, &kept)?;
            None
        } else {
            Some(HiddenFolder::beside(claimed.target(), "unfinished").map_err(refused)?)
        };
        let folder = passing.as_ref().map_or(&*kept, HiddenFolder::path).to_owned();
        let other = if output.overwrites { OtherJournal::Discard } else { OtherJournal::Refuse };
        let kind = match (output.shard, output.study) {
            (Some(_), _) => "shard",
            (None, Study::Sweep) => "sweep",
            (None, _) => "run",
        };
        let had_journal = folder.join(JOURNAL).is_file();
        let journal = Journal::open(&folder.join(JOURNAL), kind, identity, other, on_event);
        if journal.is_err() && !had_journal {
            // Work cannot be continued from a journal that the disk does not take.
            let _ = std::fs::remove_file(folder.join(JOURNAL)).and_then(|()| std::fs::remove_dir(&folder));
        }
        let journal = journal?;
        remove_leftovers(&folder);
        if let Some(line) = journal.damaged_line() {
            let path = folder.join(JOURNAL);
            print_diagnostic(format_args!(
                "warning: line {line} of {path:?} is damaged; that and what follows is done again"
            ));
        }
        let WorkOutput { shard, is_named, .. } = output;
        let unfinished = Self { passing, folder, journal, claimed, extent, shard, is_named };
        if output.is_kept {
            set_last_words(unfinished.how_to_go_on());
        }
        if output.shard.is_some() {
            set_grace(GRACE);
        }
        Ok(unfinished)
    }

    /// Says how much was done before, such as `7 of 60 scans`.
    pub fn report_continuing(&self, done: &str) {
        print_diagnostic(format_args!("Continuing with {done} from {}", self.folder.display()));
    }

    /// Returns `failure`, after printing how the work can be continued. Work that is not kept leaves nothing.
    pub fn ended_by(self, failure: Failure) -> Failure {
        if self.passing.is_none() {
            print_diagnostic(self.how_to_go_on());
        }
        failure
    }

    fn how_to_go_on(&self) -> String {
        let of_shard = self.shard.map_or_else(String::new, |it| format!(" of shard {it}"));
        let again = if self.is_named {
            "again".to_owned()
        } else {
            format!("with -o {}", self.claimed.target().display())
        };
        format!(
            "What is finished of the {}{of_shard} is kept in {}; to continue, give the same command {again}",
            self.extent,
            self.folder.display()
        )
    }

    /// Whether it is all in one piece, and no shard.
    pub fn is_in_one_piece(&self) -> bool {
        self.shard.is_none()
    }

    /// The journal of a shard, and of work that can be continued; `None` for other work.
    pub fn kept_journal(&self) -> Option<&Journal> {
        (self.passing.is_none() || self.shard.is_some()).then_some(&self.journal)
    }

    /// Which part it is and what that has, such as `Shard 3/8: 60 scans`.
    pub fn part_in_words(&self) -> String {
        format!("Shard {}: {}", self.shard.unwrap_or(Shard::ONLY), self.extent)
    }

    /// Whether there is anything to continue from.
    pub fn is_begun(&self) -> bool {
        self.journal.n_entries() > 0
    }

    /// The path of the result, and the files that are to be removed once that is there.
    pub fn into_parts(self) -> (ClaimedTarget, KeptFiles) {
        let Self { folder, journal, claimed, passing, .. } = self;
        (claimed, KeptFiles { folder, journal, passing })
    }

    /// Returns `failure`, after removing all of the work: there is nothing to continue from.
    pub fn discarded_by(self, failure: Failure) -> Failure {
        let (claimed, kept) = self.into_parts();
        kept.clear();
        // Removes the folders that were made for it.
        drop(claimed);
        failure
    }

    /// Leaves its files beside the directory, but no journal to continue from, and returns their folder.
    pub fn leave_files(self) -> Result<PathBuf, Failure> {
        let kept = kept_beside(&self.claimed);
        let (claimed, KeptFiles { folder, journal, passing }) = self.into_parts();
        set_last_words(String::new());
        drop(journal);
        if passing.is_none() {
            remove(std::fs::remove_file(folder.join(JOURNAL)), &folder);
            return Ok(folder);
        }
        let refused = |source| ArchiveError::Write { path: kept.clone(), source };
        make_beside(&claimed, &kept)?;
        for name in names_of_results(&folder) {
            let to = kept.join(&name);
            if std::fs::symlink_metadata(&to).is_ok_and(|it| it.is_dir()) {
                remove_result(&to);
            }
            std::fs::rename(folder.join(&name), to).map_err(refused)?;
        }
        Ok(kept)
    }
}

/// The folder of unfinished work, beside the directory of its result.
fn kept_beside(claimed: &ClaimedTarget) -> PathBuf {
    claimed.target().with_added_extension("unfinished")
}

/// Makes the folder `kept` unless it is there. A link is refused: it may lead to a folder that is none of ours.
fn make_beside(claimed: &ClaimedTarget, kept: &Path) -> Result<(), ArchiveError> {
    let beside = claimed.target().parent().unwrap_or(Path::new(""));
    let made = make_folder(beside, kept.file_name().unwrap_or_default());
    made.map(|_| ()).map_err(|source| ArchiveError::Write { path: kept.to_owned(), source })
}

/// Removes files that killed programs did not complete. Only the program that has the journal writes to `folder`.
fn remove_leftovers(folder: &Path) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for path in entries.filter(|it| is_unfinished_file(&it.file_name())).map(|it| it.path()) {
        remove(std::fs::remove_file(&path), &path);
    }
}

/// The files of results, and the folders of recordings, in `folder`.
fn names_of_results(folder: &Path) -> Vec<OsString> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_of_results = |it: &DirEntry| {
        let name = it.file_name();
        let ending = Path::new(&name).extension().and_then(OsStr::to_str);
        ending.is_some_and(|it| ENDINGS.contains(&it)) || is_recording(&name.to_string_lossy())
    };
    entries.filter(is_of_results).map(|it| it.file_name()).collect()
}

/// Whether it is the name of the folder of a recording: of the first part of a run, or of a later one, such as `recording-2`.
fn is_recording(name: &str) -> bool {
    let Some(number) = name.strip_prefix(RECORDING) else { return false };
    number.is_empty() || number.strip_prefix('-').is_some_and(|it| it.parse::<u32>().is_ok())
}

/// Removes the file of a result, or the folder of a recording unless there is something else in it.
fn remove_result(path: &Path) {
    if !std::fs::symlink_metadata(path).is_ok_and(|it| it.is_dir()) {
        return remove(std::fs::remove_file(path), path);
    }
    for name in names_of_results(path) {
        remove_result(&path.join(name));
    }
    remove(std::fs::remove_dir(path), path);
}

/// Files that work has left beside its result.
pub struct KeptFiles {
    pub folder: PathBuf,
    /// Events of the work that was done.
    pub journal: Journal,
    passing: Option<HiddenFolder>,
}

impl KeptFiles {
    /// Whether its folder is that of this program alone, and is removed with it.
    pub fn is_passing(&self) -> bool {
        self.passing.is_some()
    }

    /// Removes the journal and files with the endings of results. Other files in the folder stay, and the folder with them.
    pub fn clear(self) {
        let Self { folder, journal, passing } = self;
        set_last_words(String::new());
        // Some file systems keep a file that is open under another name.
        drop(journal);
        if passing.is_some() {
            return;
        }
        for name in names_of_results(&folder).into_iter().chain([JOURNAL.into()]) {
            remove_result(&folder.join(name));
        }
        let is_empty = std::fs::read_dir(&folder).is_ok_and(|mut it| it.next().is_none());
        if is_empty {
            remove(std::fs::remove_dir(&folder), &folder);
        }
    }
}

/// Warns if `path` could not be removed. The result is there: the file is only in the way.
fn remove(removed: std::io::Result<()>, path: &Path) {
    if let Err(error) = removed {
        print_diagnostic(format_args!("warning: cannot remove {}: {error}", path.display()));
    }
}
