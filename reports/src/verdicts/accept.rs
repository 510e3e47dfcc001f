//! Results that were accepted, and the history of how they came to be.

use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

use crate::files::archive::ArchiveError;
use crate::files::csv_rows::to_csv_bytes;
use crate::files::fixed_decimals::fixed_decimals;
use crate::files::regular_file::{read_bytes, read_text};
use crate::files::whole_set::WholeSet;
use crate::numbers::run_report::Subject;
use crate::partial_study::partial_curves::{PartialCurve, PartialStep};
use crate::rows::match_outcome::MatchOutcome;
use crate::rows::partial_row::PartialRow;
use crate::run_folder::manifest::GitState;
use crate::run_folder::run_archive::RunArchive;
use crate::run_folder::run_directory::{MATCHES_CSV, PARTIAL_CSV, POSES_CSV, REPORT_JSON, SCANS_CSV};
use crate::run_folder::run_target::{
    ClaimedTarget, ExistingTarget, LatestPointer, MANIFEST_JSON, RunDirectoryError,
};
use crate::streaming::closeness::is_stream;
use crate::verdicts::comparability::{NotComparable, check_comparable};
use crate::vocabulary::metric::Metric;
use crate::vocabulary::task::Task;

/// The largest file that is copied into a baseline or added to, in bytes.
const MOST_OF_FILE: u64 = 1 << 32;

/// The folder of the accepted run within a baseline.
pub const ACCEPTED_RUN: &str = "run";
/// The history of a baseline: each accepted run, when and why.
pub const SCORES_MD: &str = "SCORES.md";
/// The tolerances of a baseline: how much worse a run may be.
pub const TOLERANCES_TOML: &str = "tolerances.toml";

const SCORES_HEAD: &str = "# Accepted scores\n\nF-rates in % of the accepted run, before → after, and why. Written by \
    `scanbench baseline accept`.\n\n";

const SCORES_HEAD_OF_OBJECTS: &str = "# Accepted scores\n\nMeans of recalls in % of the accepted result at its middle and \
    last step, before → after, and why. Written by `scanbench baseline accept`.\n\n";

/// How a run becomes the accepted one.
#[derive(Debug, Clone, Copy)]
pub struct Acceptance<'a> {
    /// The day.
    pub date: &'a str,
    /// Why the scores are what they are.
    pub why: &'a str,
    /// The relation that it needs to the run that was accepted before.
    pub succession: Succession,
}

/// The relation that a run needs to the run that was accepted before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Succession {
    /// Equal scans, and equal rules of judging.
    Comparable,
    /// None: the history goes on, but its numbers do not.
    Anew,
}

/// Why results cannot be accepted.
#[derive(Debug, thiserror::Error)]
pub enum AcceptError {
    /// The program that made them was built from uncommitted changes, which cannot be found again.
    #[error(
        "the run was made by a program with uncommitted changes after commit {0}; commit them and run again"
    )]
    Dirty(String),
    /// There is an accepted run that these results say nothing about.
    #[error("{0}; to accept it all the same, give --new-baseline")]
    NoSuccessor(String),
    /// A file cannot be read or written.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// The directory of the accepted run cannot be written.
    #[error(transparent)]
    Directory(#[from] RunDirectoryError),
    /// The history cannot be read.
    #[error("cannot read {path:?}")]
    History {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
}

/// Where the run of the baseline `directory` is: in its folder for it, or in `directory` itself if that is a run.
pub fn run_of_baseline(directory: &Path) -> PathBuf {
    let accepted = directory.join(ACCEPTED_RUN);
    if accepted.join(MANIFEST_JSON).is_file() { accepted } else { directory.to_path_buf() }
}

/// Makes `run` the accepted run of the baseline `directory`, with the files of `beside` by their names, and adds a line to its
/// history, which is returned.
///
/// Ignored objects are left out of the matches: they are half of them, count for nothing, and their numbers are in the rows
/// of the scans. Those of a stream stay: they count between its scans.
///
/// # Errors
///
/// [`AcceptError`] if the run cannot be made again, or says nothing about the one accepted before although it is meant to,
/// or something cannot be written; the earlier baseline is there still.
pub fn accept(
    run: &RunArchive,
    directory: &Path,
    acceptance: Acceptance<'_>,
    beside: &[(&str, String)],
) -> Result<String, AcceptError> {
    refuse_uncommitted(run.manifest.git.as_ref())?;
    let target = directory.join(ACCEPTED_RUN);
    let before = predecessor(&target, |before| check_comparable(before, run));
    let line = line_after(before, acceptance.succession, |before| {
        let git = run.manifest.versioned_by();
        let objects = scores_of_objects(before.map_or(&[], |it| &it.objects[..]), &run.objects);
        history_line(acceptance, git, &(scores(before, run) + &objects))
    })?;
    let is_partial = run.manifest.partial.is_some();
    let is_stream = is_stream(&run.scans, run.manifest.drive_of());
    let head = if is_partial { SCORES_HEAD_OF_OBJECTS } else { SCORES_HEAD };
    let history = history_with(&directory.join(SCORES_MD), head, &line)?;

    let claimed = ClaimedTarget::claim(&target, ExistingTarget::Replace, LatestPointer::Leave)?;
    // All of it takes its names together.
    let baseline = WholeSet::within(directory)?;
    let write = |name: &str, content: &[u8]| baseline.write(&format!("{ACCEPTED_RUN}/{name}"), content);
    let mut manifest = run.manifest.clone();
    forget_program_path(&mut manifest.argv);
    write(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    let csv = |bytes: Result<Vec<u8>, csv::Error>| {
        bytes.map_err(|source| ArchiveError::Csv { path: target.clone(), source })
    };
    if is_partial {
        write(PARTIAL_CSV, &csv(to_csv_bytes(&run.objects))?)?;
    } else {
        write(REPORT_JSON, run.report.to_json().as_bytes())?;
        write(SCANS_CSV, &csv(to_csv_bytes(&run.scans))?)?;
        let counting: Vec<_> =
            run.matches.iter().filter(|it| is_stream || counts(&it.outcome)).cloned().collect();
        write(MATCHES_CSV, &csv(to_csv_bytes(&counting))?)?;
    }
    let is_kept = |it: &&PathBuf| is_stream || !it.ends_with(POSES_CSV);
    for path in run.more_files.iter().filter(is_kept) {
        let read = read_bytes(path, MOST_OF_FILE);
        let content = read.map_err(|source| ArchiveError::Read { path: path.clone(), source })?;
        write(&path.file_name().unwrap_or_default().to_string_lossy(), &content)?;
    }
    baseline.write(SCORES_MD, history.as_bytes())?;
    beside.iter().try_for_each(|(name, content)| baseline.write(name, content.as_bytes()))?;
    claimed.check()?;
    baseline.finish()?;
    Ok(line)
}

/// Refuses a program that was built from uncommitted changes: it cannot be found again.
///
/// # Errors
///
/// [`AcceptError::Dirty`] if there were such changes.
pub fn refuse_uncommitted(git: Option<&GitState>) -> Result<(), AcceptError> {
    match git {
        Some(git) if git.dirty => Err(AcceptError::Dirty(git.commit.clone())),
        _ => Ok(()),
    }
}

/// The place of the program does not belong in a baseline.
fn forget_program_path(argv: &mut [String]) {
    if let Some(program) = argv.first_mut() {
        "scanbench".clone_into(program);
    }
}

/// The line that `line` makes of the run accepted before, if there is one; a new baseline says why that is no predecessor.
///
/// # Errors
///
/// [`AcceptError::NoSuccessor`] if it is no predecessor and should be.
fn line_after(
    before: Option<Result<RunArchive, String>>,
    succession: Succession,
    line: impl Fn(Option<&RunArchive>) -> String,
) -> Result<String, AcceptError> {
    match before {
        None => Ok(line(None)),
        Some(Ok(before)) => Ok(line(Some(&before))),
        Some(Err(reason)) if succession == Succession::Anew => {
            Ok(format!("{} New baseline: {reason}.", line(None)))
        }
        Some(Err(reason)) => Err(AcceptError::NoSuccessor(reason)),
    }
}

/// The accepted run in `target`, if there is any: one that `check` lets another follow, or why none can.
fn predecessor(
    target: &Path,
    check: impl FnOnce(&RunArchive) -> Result<(), NotComparable>,
) -> Option<Result<RunArchive, String>> {
    if !target.exists() {
        return None;
    }
    let unread = |error| format!("cannot read the accepted run {}: {error}", target.display());
    Some(RunArchive::read(target).map_err(unread).and_then(|before| match check(&before) {
        Ok(()) => Ok(before),
        Err(NotComparable { reasons }) => {
            Err(format!("the run cannot be compared with the accepted one: {}", reasons.join(", ")))
        }
    }))
}

/// Whether a number of the report is made of it: tall annotations have a slice of their own.
fn counts(outcome: &MatchOutcome) -> bool {
    !matches!(outcome, MatchOutcome::IgnoredAnnotation { .. } | MatchOutcome::IgnoredDetection { .. })
}

/// The history in `path` with one line more; `head` begins it.
///
/// # Errors
///
/// [`AcceptError::History`] if it cannot be read.
fn history_with(path: &Path, head: &str, line: &str) -> Result<String, AcceptError> {
    let mut history = match read_text(path, MOST_OF_FILE) {
        Ok(history) => history,
        Err(error) if error.kind() == io::ErrorKind::NotFound => head.to_owned(),
        Err(source) => return Err(AcceptError::History { path: path.to_path_buf(), source }),
    };
    if !history.ends_with('\n') {
        history.push('\n');
    }
    history.push_str(line);
    history.push('\n');
    Ok(history)
}

/// A line of a history: when, what commit, which scores, and why.
fn history_line(acceptance: Acceptance<'_>, git: Option<&GitState>, scores: &str) -> String {
    let commit = git.map_or_else(String::new, |it| format!(", {}", it.in_short()));
    // One line, whatever the reason.
    let why = acceptance.why.split_whitespace().collect::<Vec<_>>().join(" ");
    format!("- {}{commit}{scores}. {}.", acceptance.date, why.trim_end_matches('.'))
}

/// The F-rates of each task, and their values before.
fn scores(before: Option<&RunArchive>, run: &RunArchive) -> String {
    let mut line = String::new();
    let tally = run.tally();
    for &task in tally.tasks() {
        let of_detectors = tally.detectors().iter().filter_map(|detector| {
            let now = percent(run, task, detector)?;
            Some(match before.and_then(|it| percent(it, task, detector)) {
                Some(old) if old != now => format!("{detector} {old} → {now}"),
                _ => format!("{detector} {now}"),
            })
        });
        let of_detectors: Vec<String> = of_detectors.collect();
        if !of_detectors.is_empty() {
            write!(line, "; {task}: {}", of_detectors.join(", "))
                .expect("a string takes all that is written");
        }
    }
    line
}

/// The F-rate over all data sets; of recorded and of simulated ones where there are both.
fn percent(run: &RunArchive, task: Task, detector: &str) -> Option<String> {
    let of_pools = run.manifest.pools().into_iter().filter_map(|pool| {
        let row = run.report.row(&Subject::of_all(pool.extent.name(), task, detector), &Metric::FRate)?;
        Some(fixed_decimals(100.0 * row.value()?, 1))
    });
    let of_pools: Vec<String> = of_pools.collect();
    (!of_pools.is_empty()).then(|| of_pools.join(" and "))
}

/// The numbers of every curve of partly seen objects at its middle and last step, and their values before.
fn scores_of_objects(before: &[PartialRow], rows: &[PartialRow]) -> String {
    let before = PartialCurve::all(before);
    let of_curve = |curve: &PartialCurve| {
        let PartialCurve { data, direction, method, trained_on, .. } = curve;
        let is_same = |it: &&PartialCurve| {
            (&it.data, &it.direction, &it.method, &it.trained_on) == (data, direction, method, trained_on)
        };
        let earlier = before.iter().find(is_same);
        let of_step = |step: &PartialStep| {
            let now = percent_at(step)?;
            let old = earlier.and_then(|it| percent_at(it.steps.iter().find(|it| it.step == step.step)?));
            let old = old.filter(|it| *it != now).map_or_else(String::new, |it| format!("{it} → "));
            Some(format!("{old}{now}"))
        };
        let steps = [curve.steps.len().div_ceil(2), curve.steps.len()];
        let steps = steps.into_iter().filter_map(|it| of_step(curve.steps.get(it.checked_sub(1)?)?));
        let steps: Vec<String> = steps.collect();
        format!("; {data} from {direction}: {method} trained on {trained_on} {}", steps.join(", "))
    };
    PartialCurve::all(rows).iter().map(of_curve).collect()
}

fn percent_at(step: &PartialStep) -> Option<String> {
    step.mean_recall.map(|it| fixed_decimals(100.0 * it, 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run_folder::manifest::tests::partial_manifest;
    use crate::verdicts::partial_differences::tests::rows;

    fn accepted(run: &RunArchive, folder: &Path, succession: Succession) -> Result<String, AcceptError> {
        accept(run, folder, Acceptance { date: "2026-01-01", why: "better\ntrees.", succession }, &[])
    }

    #[test]
    fn partly_seen_objects_are_read_back_and_have_a_history() {
        let folder = tempfile::tempdir().unwrap();
        let result = |n_right| RunArchive::of_partial(partial_manifest(), rows(n_right));
        let first = accepted(&result(40), folder.path(), Succession::Comparable).unwrap();
        // One step is the middle one and the last one.
        assert!(first.starts_with("- 2026-01-01; street from "), "{first}");
        assert!(first.contains(" 100.0, 100.0. better trees."), "{first}");
        let later = accepted(&result(30), folder.path(), Succession::Comparable).unwrap();
        assert!(later.contains("100.0 → 75.0, 100.0 → 75.0. better trees."), "{later}");
        let kept = RunArchive::read(&folder.path().join(ACCEPTED_RUN)).unwrap();
        assert_eq!((kept.objects, &*kept.manifest.argv[0]), (rows(30), "scanbench"));
        let history = std::fs::read_to_string(folder.path().join(SCORES_MD)).unwrap();
        assert!(history.starts_with("# Accepted scores"), "{history}");
        assert!(history.ends_with(&format!("{first}\n{later}\n")), "{history}");
        let mut other = result(40);
        other.manifest.partial.as_mut().unwrap().sets[0].judged.id = "another".to_owned();
        let error = accepted(&other, folder.path(), Succession::Comparable).unwrap_err().to_string();
        assert!(error.contains("judged are not the same; to accept it all the same"), "{error}");
        let line = accepted(&other, folder.path(), Succession::Anew).unwrap();
        assert!(line.contains("New baseline: the run cannot be compared"), "{line}");
        other.manifest.git = Some(GitState { commit: "abc".to_owned(), dirty: true });
        assert!(matches!(accepted(&other, folder.path(), Succession::Anew), Err(AcceptError::Dirty(_))));
    }
}
