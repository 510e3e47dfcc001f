//! `scanbench view BEFORE AFTER`: what changed between two runs, listed and side by side.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use detector::{DetectedClass, Detection, DetectorOutput, GivenClass, OrientedBox};
use evaluation::matching::outcome::{AnnotationOutcome, Assignment, DetectionOutcome, FoundTall};
use evaluation::run::scan_recorder::{ChangedScan, Mark, ScanRecorder as _, SideOfScan};
use reports::rows::match_outcome::{DetectionFacts, MatchOutcome};
use reports::rows::match_row::MatchRow;
use reports::run_folder::command_line::shell_word;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_archive::RunArchive;
use reports::verdicts::accept::run_of_baseline;
use reports::verdicts::change::{Change, ChangeKind, in_words, n_of_kinds};
use reports::verdicts::classes_of_both::with_classes_of_both;
use reports::verdicts::comparability::check_comparable;
use reports::verdicts::drift::{ScanDrift, ScanSubject, drift};
use reports::vocabulary::class::DetectionClass;
use reports::vocabulary::class_traits::ClassGroup;
use reports::vocabulary::criterion::CriterionKind;
use reports::vocabulary::reason::{IgnoredAnnotation, IgnoredDetection};
use reports::vocabulary::task::Task;
use reports::worst::mistakes::scan_address;

use crate::cli::{StreamArgs, ViewArgs};
use crate::plumbing::failure::Failure;
use crate::plumbing::open_run::open_run;
use crate::plumbing::progress::progress_over_scans;
use crate::plumbing::recorder::{self, RecordingPlace, RecordingPlan, finish_and_serve, is_wanted};
use crate::plumbing::standard_streams::{print_diagnostic, print_text};
use crate::verbs::worst_scans::{chosen_task, datasets_of, place_of};

/// The sides, as the recording names them.
const SIDES: [&str; 2] = ["before", "after"];

/// A change with the scan that it is in.
struct ListedChange {
    subject: ScanSubject,
    change: Change,
}

/// Lists what changed from the run of `arguments` to the one in `after`, and records the scans where it did.
pub fn view_changes(arguments: &ViewArgs, after: &Path) -> Result<(), Failure> {
    let sides = [open_run(&run_of_baseline(&arguments.run))?, open_run(after)?];
    check_comparable(&sides[0], &sides[1]).map_err(|error| Failure::NotComparable(error.into()))?;
    let sides = with_classes_of_both(sides);
    let (detector, task) = chosen_task(arguments, &sides[0])?;
    let all = drift(&sides[0], &sides[1]);
    let of_others = of_others(&all, (detector, task));
    let of_both = all.into_iter().filter(|it| {
        let address = scan_address(&it.subject.dataset, &it.subject.sequence, it.subject.scan);
        let is_asked = it.subject.detector == detector && it.subject.task == task.name();
        // Of an object, its scan: outcomes change, and with them the names of mistakes.
        let is_there =
            |at: &String| at.strip_prefix(&address).is_some_and(|it| it.is_empty() || it.starts_with('/'));
        is_asked && arguments.at.as_ref().is_none_or(is_there)
    });
    let listed = of_both.flat_map(|it| {
        let seen = it.changes.into_iter().filter(|it| ChangeKind::SEEN.contains(&it.kind));
        seen.map(|change| ListedChange { subject: it.subject.clone(), change }).collect::<Vec<_>>()
    });
    let mut listed: Vec<ListedChange> = listed.collect();
    if listed.is_empty() {
        let at = arguments.at.as_ref().map(|it| format!(" at {it}")).unwrap_or_default();
        print_text(&format!("{detector}, {task}: no object has another outcome{at}\n"))?;
        say_of_others(&of_others);
        return Ok(());
    }
    let counted = in_words(&n_of_kinds(listed.iter().map(|it| &it.change)));
    listed.sort_by_key(|it| (it.change.kind, std::cmp::Reverse(it.change.n_points)));
    listed.truncate(arguments.worst as usize);
    print_text(&format!("{detector}, {task}: {counted}\n\n{}", lines(&listed)))?;
    say_of_others(&of_others);
    record(arguments, after, &sides, (detector, task), &listed)
}

/// Most detectors and tasks whose changes are counted beside those that are listed.
const MOST_OTHERS: usize = 3;

/// Numbers of changes of other detectors and tasks than the `listed` ones, most first.
fn of_others(all: &[ScanDrift], listed: (&str, Task)) -> Vec<((String, String), usize)> {
    let mut others: BTreeMap<(String, String), usize> = BTreeMap::new();
    for ScanDrift { subject, changes } in all {
        let n_seen = changes.iter().filter(|it| ChangeKind::SEEN.contains(&it.kind)).count();
        let is_listed = (subject.detector.as_str(), subject.task.as_str()) == (listed.0, listed.1.name());
        if n_seen > 0 && !is_listed {
            *others.entry((subject.detector.clone(), subject.task.clone())).or_default() += n_seen;
        }
    }
    let mut most: Vec<_> = others.into_iter().collect();
    most.sort_by_key(|it| std::cmp::Reverse(it.1));
    most
}

/// Says how to list the changes of others.
fn say_of_others(others: &[((String, String), usize)]) {
    for ((detector, task), n_changes) in others.iter().take(MOST_OTHERS) {
        let detector_word = shell_word(detector);
        print_diagnostic(format_args!(
            "{detector}, {task}: {n_changes} objects have another outcome; -d {detector_word} --task {task} lists them"
        ));
    }
}

/// The changes as lines of text with a head.
fn lines(listed: &[ListedChange]) -> String {
    let address =
        |it: &ListedChange| scan_address(&it.subject.dataset, &it.subject.sequence, it.subject.scan);
    let width = |head: &str, of: &dyn Fn(&ListedChange) -> String| {
        listed.iter().map(|it| of(it).chars().count()).max().unwrap_or(0).max(head.len())
    };
    let addresses = width("data set/drive/scan", &address);
    let kinds = width("change", &|it| it.change.kind.name().to_owned());
    let mut text =
        format!("{:>4}  {:<kinds$}  {:<addresses$}  object\n", "", "change", "data set/drive/scan");
    for (rank, it) in (1..).zip(listed) {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{rank:>4}  {:<kinds$}  {:<addresses$}  {}",
            it.change.kind.name(),
            address(it),
            it.change.text
        );
    }
    text
}

/// Records the scans of `listed`, that of the first change first.
fn record(
    arguments: &ViewArgs,
    after: &Path,
    sides: &[RunArchive; 2],
    (detector, task): (&str, Task),
    listed: &[ListedChange],
) -> Result<(), Failure> {
    let mut scans: Vec<PointedScan<'_>> = Vec::new();
    for (rank, ListedChange { subject, change }) in (1..).zip(listed) {
        let name = (subject.dataset.as_str(), subject.sequence.as_str(), subject.scan);
        // The list has the rest.
        let object =
            change.text.split(" at (").next().and_then(|it| it.split(',').next()).unwrap_or_default();
        let kind = change.kind;
        let mark = change.position_m.map(|position_m| Mark {
            position_m,
            text: format!("{rank} {}: {object}", kind.name()),
            change: Some(kind),
        });
        let line = (Some(kind), format!("{rank} {}: {}", kind.name(), change.text));
        PointedScan::of(&mut scans, name).add(mark, line);
    }
    record_sides(
        &TwoSides {
            stream: &arguments.stream,
            file: after.join("changes.rrd"),
            name: &format!("{detector} before and after, {task}"),
            manifest: &sides[1].manifest,
            is_trusted: arguments.trust,
            names: SIDES,
            rows: sides.each_ref().map(|it| rows_by_scan(&it.matches, detector, task)),
            task,
        },
        &scans,
    )
}

/// A scan with what is pointed at in it.
pub struct PointedScan<'a> {
    name: (&'a str, &'a str, u32),
    marks: Vec<Mark>,
    lines: Vec<(Option<ChangeKind>, String)>,
}

impl<'a> PointedScan<'a> {
    /// The one of this name among `scans`, which gets it if it is new.
    pub fn of<'s>(scans: &'s mut Vec<Self>, name: (&'a str, &'a str, u32)) -> &'s mut Self {
        let place = scans.iter().position(|it| it.name == name).unwrap_or_else(|| {
            scans.push(Self { name, marks: Vec::new(), lines: Vec::new() });
            scans.len() - 1
        });
        &mut scans[place]
    }

    /// Adds something that is pointed at, if its place is known, and its line.
    pub fn add(&mut self, mark: Option<Mark>, line: (Option<ChangeKind>, String)) {
        self.marks.extend(mark);
        self.lines.push(line);
    }
}

/// Two results over the same scans that are recorded side by side.
pub struct TwoSides<'a> {
    pub stream: &'a StreamArgs,
    /// Where the recording goes unless the user names another file.
    pub file: PathBuf,
    /// Name of the recording.
    pub name: &'a str,
    /// The run whose scans they are.
    pub manifest: &'a Manifest,
    /// Whether the user trusts that run.
    pub is_trusted: bool,
    /// Their names.
    pub names: [&'static str; 2],
    pub rows: [RowsByScan<'a>; 2],
    pub task: Task,
}

/// Records `scans`, in this order.
pub fn record_sides(sides: &TwoSides<'_>, scans: &[PointedScan<'_>]) -> Result<(), Failure> {
    if !is_wanted(sides.stream)? {
        return Ok(());
    }
    let datasets = datasets_of(sides.manifest, sides.is_trusted)?;
    let written = sides.stream.save_rrd.clone().flatten().unwrap_or(sides.file.clone());
    let Some(mut recording) = recorder::begin(&RecordingPlan {
        arguments: sides.stream,
        place: RecordingPlace::File(sides.file.clone()),
        name: sides.name,
        shown_task: sides.task,
        detectors: &sides.names,
        n_scans: scans.len(),
        has_poses: false,
        follows: false,
        shows_changes: true,
        figures: &[],
    })?
    else {
        return Ok(());
    };
    let progress = progress_over_scans(scans.len(), "scans");
    for (number, PointedScan { name, marks, lines }) in scans.iter().enumerate() {
        let [dataset_idx, scan_idx] = place_of(&datasets, *name)?;
        let scan = datasets[dataset_idx].dataset.read_scan(scan_idx)?;
        let side = |side_idx: usize| {
            let of_scan = sides.rows[side_idx].get(name).map_or(&[][..], Vec::as_slice);
            let (output, assignment) = outcomes(of_scan, scan.annotations.len(), sides.task);
            SideOfScan { name: sides.names[side_idx], output, assignment }
        };
        let both = [side(0), side(1)];
        recording.record_change(&ChangedScan { scan: &scan, number, marks, lines, sides: both })?;
        progress.inc(1);
    }
    progress.finish_and_clear();
    finish_and_serve(recording, &written)
}

/// Rows of one detector and task by data set, drive and number of the scan.
pub type RowsByScan<'a> = BTreeMap<(&'a str, &'a str, u32), Vec<&'a MatchRow>>;

/// The rows of `detector` in `task`, by their scans.
pub fn rows_by_scan<'a>(rows: &'a [MatchRow], detector: &str, task: Task) -> RowsByScan<'a> {
    let mut by_scan: RowsByScan<'a> = BTreeMap::new();
    for row in rows.iter().filter(|it| it.detector == detector && it.task == task) {
        by_scan.entry((&row.dataset, &row.sequence, row.scan)).or_default().push(row);
    }
    by_scan
}

/// The detections of `rows`, and the outcomes of these and of `n_annotations`, all of one scan.
fn outcomes(rows: &[&MatchRow], n_annotations: usize, task: Task) -> (DetectorOutput, Assignment) {
    let mut output = DetectorOutput::default();
    let mut annotations = vec![AnnotationOutcome::NotAsked; n_annotations];
    let (mut detections, mut found_tall) = (Vec::new(), Vec::new());
    let mut criterion = None;
    for row in rows {
        criterion = Some(row.criterion);
        let mut push = |facts: &DetectionFacts, outcome| {
            output.detections.push(detection(facts));
            detections.push(outcome);
            detections.len() - 1
        };
        let (annotation, outcome) = match &row.outcome {
            MatchOutcome::Matched { annotation, detection, cost } => {
                let annotation_idx = annotation.id as usize;
                let detection_idx =
                    push(detection, DetectionOutcome::Matched { annotation_idx, cost: *cost });
                (annotation, AnnotationOutcome::Matched { detection_idx, cost: *cost })
            }
            MatchOutcome::Missed { annotation, reason } => (annotation, AnnotationOutcome::Missed(*reason)),
            MatchOutcome::IgnoredAnnotation { annotation, reason } => {
                (annotation, AnnotationOutcome::Ignored(*reason))
            }
            MatchOutcome::Tall { annotation, found_by } => {
                if let Some(found_by) = found_by {
                    let why = IgnoredDetection::OnIgnoredAnnotation;
                    let detection_idx = push(&found_by.detection, DetectionOutcome::Ignored(why));
                    let annotation_idx = annotation.id as usize;
                    found_tall.push(FoundTall { annotation_idx, detection_idx, cost: found_by.cost });
                }
                (annotation, AnnotationOutcome::Ignored(IgnoredAnnotation::Tall))
            }
            MatchOutcome::False { detection, reason } => {
                push(detection, DetectionOutcome::False(*reason));
                continue;
            }
            MatchOutcome::IgnoredDetection { detection, reason } => {
                push(detection, DetectionOutcome::Ignored(*reason));
                continue;
            }
            MatchOutcome::Unknowable { detection, agreement } => {
                push(detection, DetectionOutcome::Unknowable(*agreement));
                continue;
            }
        };
        if let Some(it) = annotations.get_mut(annotation.id as usize) {
            *it = outcome;
        }
    }
    let criterion = criterion.unwrap_or(CriterionKind::Points);
    (output, Assignment { task, criterion, annotations, detections, found_tall })
}

fn detection(facts: &DetectionFacts) -> Detection<'static> {
    let given = facts.class.given();
    let is_vehicle = facts.class == DetectionClass::Vehicle
        || given.is_some_and(|it| it.group() == Some(ClassGroup::Vehicle));
    let kind = if is_vehicle { DetectedClass::Vehicle } else { DetectedClass::Object };
    let bounding_box = OrientedBox {
        center_m: facts.bounding_box.center_m,
        length_width_height_m: facts.bounding_box.length_width_height_m,
        yaw_rad: facts.bounding_box.yaw_rad,
    };
    let given = given.map(|it| GivenClass::new(it.name(), it.name()));
    Detection { given, ..Detection::new(&[], bounding_box, kind, facts.score) }
}
