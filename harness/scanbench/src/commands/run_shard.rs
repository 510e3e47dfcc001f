//! `scanbench run --shard`: a part of a run, which goes on where it was if it was interrupted.

use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::time::Duration;

use evaluation::journal::{Journal, JournalIdentity, JournalKind, OtherJournal};
use jiff::Timestamp;
use reports::files::archive::ArchiveError;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{ClaimedTarget, MANIFEST_JSON};
use reports::run_folder::shard_record::{ShardRecord, ShardRecording};
use reports::vocabulary::shard::Shard;

use crate::cli::{OutputArgs, RunArgs};
use crate::commands::failure::{Failure, Usage};
use crate::commands::interruption::{interruption_flag, set_grace, set_last_words};
use crate::commands::progress::RunProgress;
use crate::commands::provenance::{machine, program_checksum, rfc3339_utc};
use crate::commands::run_directory::claim_named;
use crate::commands::run_setup::{ChosenRun, OpenedRun};
use crate::commands::shards::shard_entry::{ShardEntry, ShardProgress};
use crate::commands::shards::shard_files::write_shard_files;
use crate::commands::shards::shard_journal::ShardJournal;
use crate::commands::shards::share_of_work::{ShareOfWork, take_share};
use crate::commands::sinks::rerun_recording::RerunRecording;
use crate::commands::sinks::terminal::Terminal;
use crate::commands::standard_streams::print_diagnostic;
use crate::commands::watched_run::WithoutLabels;

/// A scheduler that ends a program waits this long for it, or longer: half a minute is usual.
const GRACE: Duration = Duration::from_secs(25);

/// The journal, in the folder of what is unfinished.
const JOURNAL: &str = "journal";

/// Runs `shard`, and leaves its rows in a directory of its own for `merge`.
///
/// Every scan is kept as soon as it is judged, beside that directory; so a shard that was ended goes on when it is asked for again.
///
/// # Errors
///
/// If anything asked for is not there, data are damaged, what is there is of another run, or the output cannot be written.
pub fn run_shard(arguments: &RunArgs, shard: Shard) -> Result<(), Failure> {
    let (interrupted, started) = (interruption_flag(), Timestamp::now());
    refuse_what_is_for_whole_runs(arguments)?;
    let chosen = ChosenRun::of(arguments)?;
    let claimed = claim(&arguments.output, shard)?;
    let mut opened = chosen.open(arguments)?;
    let share = take_share(&mut opened.datasets, shard);
    let record = record(shard, share, started);
    let manifest = Manifest { shard: Some(record), ..opened.manifest(arguments, started) };
    let unfinished = Unfinished::open(arguments, &claimed, &manifest)?;
    let how_to_go_on = unfinished.how_to_go_on(shard);
    set_last_words(how_to_go_on.clone());
    set_grace(GRACE);
    let n_scans = opened.datasets.iter().map(|it| it.part.len()).sum::<usize>();
    unfinished.leave_out_what_is_done(&mut opened);
    let progress = RunProgress::new();
    if let Err(failure) = unfinished.run(arguments, &opened, (interrupted, &progress)) {
        print_diagnostic(how_to_go_on);
        return Err(failure);
    }
    // Programs of others have introduced themselves by now.
    let manifest = Manifest { shard: manifest.shard, ..opened.manifest(arguments, started) };
    let finished = unfinished.finish(claimed, manifest)?;
    set_last_words(String::new());
    print_diagnostic(format_args!("Shard {shard}: {n_scans} scans, {}", finished.display()));
    Ok(())
}

/// Options that shards would have to share, or that have no end.
fn refuse_what_is_for_whole_runs(arguments: &RunArgs) -> Result<(), Usage> {
    let stream = &arguments.stream;
    if matches!(stream.save_rrd, Some(Some(_))) {
        return Err(Usage(
            "all shards would write the same file of --save-rrd; leave out its name".to_owned(),
        ));
    }
    if stream.serve.is_some() {
        return Err(Usage("a shard ends, and nobody is served by it: leave out --serve".to_owned()));
    }
    Ok(())
}

/// Takes the directory of `shard`, in the folder that `output` names.
fn claim(output: &OutputArgs, shard: Shard) -> Result<ClaimedTarget, Failure> {
    let of_shard = OutputArgs {
        output: output.output.as_ref().map(|it| it.join(shard.folder_name())),
        overwrite: output.overwrite,
    };
    claim_named(&of_shard)?
        .ok_or_else(|| Usage("--shard needs -o, the folder of all shards".to_owned()).into())
}

fn record(shard: Shard, share: ShareOfWork, started: Timestamp) -> ShardRecord {
    ShardRecord {
        index: shard.index(),
        count: shard.count(),
        created: rfc3339_utc(started),
        program: program_checksum(),
        cut_by: share.cut_by,
        parts: share.parts,
        processors: Vec::new(),
        files: Vec::new(),
        recordings: Vec::new(),
        worst_recorded: Vec::new(),
    }
}

/// What decides the rows of a shard: its manifest, without what may differ when it is continued.
fn identity(arguments: &RunArgs, manifest: &Manifest) -> JournalIdentity {
    let mut value = serde_json::to_value(manifest).expect("a manifest has text keys only");
    let identity = value.as_object_mut().expect("a manifest is an object");
    for passing in ["created", "argv", "machine"] {
        identity.remove(passing);
    }
    if let Some(shard) = identity.get_mut("shard").and_then(|it| it.as_object_mut()) {
        shard.remove("created");
    }
    let rules = serde_json::json!({
        "on_detector_failure": format!("{:?}", arguments.on_detector_failure),
        "skip_damaged": arguments.damage.skip_damaged,
        "rerun_every": arguments.stream.rerun_every,
    });
    identity.insert("rules".to_owned(), rules);
    std::mem::take(identity)
}

/// A shard that is being made.
struct Unfinished {
    folder: PathBuf,
    journal: Journal,
    progress: ShardProgress,
    n_scans: usize,
}

impl Unfinished {
    fn open(arguments: &RunArgs, claimed: &ClaimedTarget, manifest: &Manifest) -> Result<Self, Failure> {
        let mut folder = claimed.target().as_os_str().to_owned();
        folder.push(".unfinished");
        let folder = PathBuf::from(folder);
        std::fs::create_dir_all(&folder)
            .map_err(|source| ArchiveError::Write { path: folder.clone(), source })?;
        let other = if arguments.output.overwrite { OtherJournal::Discard } else { OtherJournal::Refuse };
        let identity = identity(arguments, manifest);
        let mut progress = ShardProgress::default();
        let kind = (JournalKind::Shard, &identity);
        let journal = Journal::open(&folder.join(JOURNAL), kind, other, |it| progress.add(&it))?;
        let n_scans = manifest.shard.as_ref().map_or(0, ShardRecord::n_scans) as usize;
        if progress.n_starts > 0 {
            print_diagnostic(format_args!(
                "Continuing with {} of {n_scans} scans from {}",
                progress.n_scans,
                folder.display()
            ));
        }
        journal.add(&ShardEntry::Began { cpu_model: machine().cpu_model })?;
        Ok(Self { folder, journal, progress, n_scans })
    }

    fn how_to_go_on(&self, shard: Shard) -> String {
        format!(
            "What is done of the {} scans of shard {shard} is kept in {}: to go on with the others, give the same command again",
            self.n_scans,
            self.folder.display()
        )
    }

    /// Begins each data set behind the last scan that was judged.
    fn leave_out_what_is_done(&self, opened: &mut OpenedRun) {
        for (dataset_idx, place) in &self.progress.next_places {
            let part = &mut opened.datasets[*dataset_idx].part;
            part.start = (*place).clamp(part.start, part.end);
        }
    }

    fn run(
        &self,
        arguments: &RunArgs,
        opened: &OpenedRun,
        (interrupted, progress): (&std::sync::atomic::AtomicBool, &RunProgress),
    ) -> Result<(), Failure> {
        let mut n_before = 0;
        let first = opened.datasets.iter().find_map(|it| {
            let first = (!it.part.is_empty()).then_some(n_before + it.part.start);
            n_before += it.scan_indices.len();
            first
        });
        let Some(first) = first else { return Ok(()) };
        let n_left = opened.datasets.iter().map(|it| it.part.len()).sum();
        let file = match self.progress.n_starts {
            0 => "run.rrd".to_owned(),
            n => format!("run-{}.rrd", n + 1),
        };
        let name = self.folder.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let recorder = opened.begin_recording(arguments, &name, self.folder.join(&file))?;
        let is_recorded = recorder.is_some();
        let (end, mut served) = (Cell::new(None), None);
        let protocols = &arguments.protocol.protocols;
        let watched = opened.watched(arguments, WithoutLabels::AskLater, (interrupted, progress));
        let ended = watched.run(vec![
            Box::new(recorder.map(|it| RerunRecording::new(it, progress, &mut served))),
            Box::new(ShardJournal::new(&self.journal, (&opened.datasets, protocols), &end)),
            Box::new(Terminal::new(progress)),
        ]);
        let is_complete = matches!(ended, Ok(()) | Err(Failure::Interrupted(_) | Failure::Detector(_)));
        if let Some(end) = end.get().filter(|_| is_recorded && is_complete) {
            let (first, every) = (first as u64, u64::from(arguments.stream.every(n_left)));
            self.journal.add(&ShardEntry::Recorded(ShardRecording { file, first, end, every }))?;
        }
        ended
    }

    /// Makes the directory of what is in the journal, which is not needed any more then.
    fn finish(self, claimed: ClaimedTarget, mut manifest: Manifest) -> Result<PathBuf, Failure> {
        let directory = RunDirectory::begin(claimed)?;
        if let Some(mut record) = manifest.shard.take() {
            write_shard_files(&self.journal, &directory, (&mut manifest, &mut record))?;
            for recording in &record.recordings {
                keep(&self.folder.join(&recording.file), &directory.path_of(&recording.file))?;
            }
            manifest.shard = Some(record);
        }
        directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
        let finished = directory.finish()?;
        let removed = std::fs::remove_dir_all(&self.folder);
        removed.map_err(|source| ArchiveError::Write { path: self.folder.clone(), source })?;
        Ok(finished)
    }
}

/// Gives a file a second name; where there are none, a second file.
fn keep(file: &Path, name: &Path) -> Result<(), ArchiveError> {
    let copied = std::fs::hard_link(file, name).or_else(|_| std::fs::copy(file, name).map(|_| ()));
    copied.map_err(|source| ArchiveError::Write { path: name.to_owned(), source })
}
