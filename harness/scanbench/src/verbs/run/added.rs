//! `scanbench run --add-to`: a detector that joins a finished run, which is made again of the rows of both.

use std::collections::BTreeMap;
use std::path::Path;

use evaluation::run::detector_list::{DEFAULT_DETECTORS, DETECTORS};
use reports::files::archive::ArchiveError;
use reports::files::csv_rows::{CsvRow, read_rows};
use reports::files::hidden_folder::HiddenFolder;
use reports::rows::kitti_object_row::KittiObjectRow;
use reports::rows::label_score_row::LabelScoreRow;
use reports::rows::match_row::MatchRow;
use reports::rows::official_rows::OfficialRows;
use reports::rows::pose_row::PoseRow;
use reports::rows::ranked_box_row::RankedBoxRow;
use reports::rows::scan_row::ScanRow;
use reports::rows::stage_row::StageRow;
use reports::run_folder::command_line::joined_command;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_archive::RunArchive;
use reports::run_folder::run_directory::{
    AGREEMENT_CSV, KITTI_OBJECT_CSV, MATCHES_CSV, POSES_CSV, PROTOCOL_BOXES_CSV, PROTOCOL_LABELS_CSV,
    RECORDING, RECORDINGS_JSON, RunDirectory, SCANS_CSV, STAGES_CSV, VIEWER, VIEWER_PLACES_JSON,
    WORST_POINTS_JSON,
};
use reports::run_folder::run_target::{ClaimedTarget, ExistingTarget, LatestPointer};
use reports::verdicts::comparability::check_joinable;
use reports::vocabulary::study::Study;
use reports::worst::points::{Patch, WorstPoints};

use crate::cli::{OutputArgs, RunArgs};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::open_run::open_run;
use crate::plumbing::scans_in_order::{ScanKey, scans_in_order};
use crate::plumbing::second_names::keep;
use crate::plumbing::shards::run_event::{RunEvent, ScanEvent};
use crate::plumbing::shards::run_rows::RunRows;
use crate::plumbing::shards::whole_run::WholeRun;
use crate::plumbing::standard_streams::print_diagnostic;
use crate::verbs::run::ending::print_ending;
use crate::verbs::run::made::made_run;
use crate::verbs::run::setup::{arguments_of, sandbox_for_none};

/// Runs the detectors of `arguments` as those of the run in `base` were run, and adds them to it.
pub fn add_to(base: &Path, arguments: &RunArgs) -> Result<(), Failure> {
    let before = open_run(base)?;
    // `runs/latest` is a link.
    let base = &base.canonicalize().map_err(|error| Failure::damaged_run(base, error))?;
    refuse_unlike(base, &before.manifest)?;
    let mut again = arguments_of(&before.manifest)?;
    let target = ClaimedTarget::claim(base, ExistingTarget::Replace, LatestPointer::Leave)?;
    let folder = HiddenFolder::beside(base, "added")
        .map_err(|error| Failure::internal("cannot make a folder beside the run", error))?;
    again.detectors = named(arguments, &before.manifest)?;
    again.foreign.detections.clone_from(&arguments.foreign.detections);
    again.output = OutputArgs { output: Some(folder.path().join("run")), overwrite: false };
    again.foreign.missing_detections = arguments.foreign.missing_detections;
    again.foreign.sandbox |= arguments.foreign.sandbox;
    let stream = &mut again.stream;
    stream.no_rrd = arguments.stream.no_rrd || !can_join(base);
    (stream.save_rrd, stream.connect, stream.serve, stream.spawn) = (None, None, None, false);
    // Its recording joins that one. It also marks a run that nobody can continue.
    again.add_to = Some(base.clone());
    again.mcap = false;
    again.result_files.detections_out = None;
    let Some(made) = made_run(&again)? else { return Ok(()) };
    let (path, ..) = made;
    let after = RunArchive::read(&path).map_err(|error| Failure::damaged_run(&path, error))?;
    check_joinable(&before, &after).map_err(|error| Failure::NotComparable(error.into()))?;
    let manifest = joined(before.manifest, after.manifest);
    let directory = RunDirectory::begin(target)?;
    // Its layers, and the layout that shows all detectors.
    let recording = path.join(RECORDING);
    if recording.is_dir() {
        keep(&recording, &directory.path_of(RECORDING))?;
    }
    let mut rows = RunRows::begin(&manifest, directory.folder())?;
    let damaged = |error| Failure::damaged_run(base, error);
    for event in events([base, &path], &manifest).map_err(damaged)? {
        rows.add(&event, 0)?;
    }
    let whole = WholeRun::in_one_piece(Study::Run, rows, &manifest, &directory)?;
    // Recordings, and files of the user.
    keep(base, directory.folder())?;
    forget_old_mistakes(&directory)?;
    let finished = directory.finish()?;
    print_ending(&whole, &finished)
}

/// Refuses a run that no detector can be added to.
fn refuse_unlike(base: &Path, manifest: &Manifest) -> Result<(), Failure> {
    let name = base.display();
    let problem = if !manifest.shards.is_empty() {
        Some("it was put together of shards")
    } else if manifest.datasets.iter().any(|it| !it.skipped_scans.is_empty()) {
        Some("damaged scans were left out")
    } else if base.join(AGREEMENT_CSV).is_file() {
        Some(
            "some of its data sets have no labels, and agreement is counted while all detectors look at a scan",
        )
    } else {
        None
    };
    problem
        .map_or(Ok(()), |it| Err(Usage(format!("--add-to {name}: {it}; run all detectors together")).into()))
}

/// Whether the run in `base` has a recording that a detector can join; says if it has not.
fn can_join(base: &Path) -> bool {
    let problem = if base.join(RECORDINGS_JSON).is_file() {
        "its recording has several parts"
    } else if base.join(RECORDING).is_dir() {
        return true;
    } else {
        "it has no recording in layers"
    };
    print_diagnostic(format_args!("Nothing that is added to {} is recorded: {problem}", base.display()));
    false
}

/// Removes from the new directory what shows the worst mistakes of the old one in the viewer.
fn forget_old_mistakes(directory: &RunDirectory) -> Result<(), ArchiveError> {
    let [marks, places] =
        [Path::new(RECORDING).join("marks.rrd"), Path::new(VIEWER).join(VIEWER_PLACES_JSON)];
    for path in [marks, places].map(|it| directory.folder().join(it)).into_iter().filter(|it| it.exists()) {
        std::fs::remove_file(&path).map_err(|source| ArchiveError::Write { path, source })?;
    }
    Ok(())
}

/// The detectors to add: those that were named. The default ones are no wish.
fn named(arguments: &RunArgs, manifest: &Manifest) -> Result<Vec<String>, Failure> {
    let names =
        if arguments.detectors == DEFAULT_DETECTORS { Vec::new() } else { arguments.detectors.clone() };
    if names.is_empty() && arguments.foreign.detections.is_empty() {
        let problem = "--add-to: name the detectors that join the run, with -d or --detections";
        return Err(Usage(problem.to_owned()).into());
    }
    let results = arguments.foreign.detections.iter().map(|it| &it.name);
    if let Some(known) =
        names.iter().chain(results).find(|it| manifest.detectors.iter().any(|of| of.name == **it))
    {
        return Err(Usage(format!(
            "--add-to: the run has the detector {known} already; name others with -d"
        ))
        .into());
    }
    let is_built_in = |name: &String| DETECTORS.iter().any(|it| it.name == name);
    if arguments.foreign.sandbox && names.iter().all(is_built_in) {
        return Err(sandbox_for_none().into());
    }
    Ok(names)
}

/// The manifest of both: everything is said by the first, the second has more detectors.
fn joined(mut before: Manifest, after: Manifest) -> Manifest {
    let names: Vec<&str> = before.detectors.iter().map(|it| it.name.as_str()).collect();
    let added: Vec<&str> = after.detectors.iter().map(|it| it.name.as_str()).collect();
    before.argv = joined_command(&before.argv, &[names, added].concat(), &after.argv);
    before.created = after.created;
    if let (Some(tables), Some(more)) = (before.config.as_object_mut(), after.config.as_object()) {
        for (table, values) in more {
            match (tables.get_mut(table).and_then(|it| it.as_object_mut()), values.as_object()) {
                (Some(known), Some(values)) => {
                    values.iter().for_each(|(name, value)| {
                        known.entry(name.clone()).or_insert_with(|| value.clone());
                    });
                }
                _ => {
                    tables.entry(table.clone()).or_insert_with(|| values.clone());
                }
            }
        }
    }
    before.scoring_version = before.scoring_version.max(after.scoring_version);
    before.detectors.extend(after.detectors);
    before
}

/// Rows of a file by the scan that they are of, in order.
type ByScan<Row> = BTreeMap<ScanKey, Vec<Row>>;

/// The scans of both runs, each with the rows of the first and then those of the second.
fn events(runs: [&Path; 2], manifest: &Manifest) -> Result<Vec<RunEvent>, ArchiveError> {
    let scans: Vec<ScanRow> = read_rows(&runs[0].join(SCANS_CSV))?;
    let order = scans_in_order(&scans);
    let mut scans = by_scan::<ScanRow>(&runs, SCANS_CSV, |it| (&it.dataset, &it.sequence, it.scan))?;
    let mut matches = by_scan(&runs, MATCHES_CSV, |it: &MatchRow| (&it.dataset, &it.sequence, it.scan))?;
    let mut stages = by_scan(&runs, STAGES_CSV, |it: &StageRow| (&it.dataset, &it.sequence, it.scan))?;
    let mut poses = by_scan(&runs[..1], POSES_CSV, |it: &PoseRow| (&it.dataset, &it.sequence, it.scan))?;
    let mut boxes = by_scan(&runs, PROTOCOL_BOXES_CSV, |it: &RankedBoxRow| {
        (&it.scan.dataset, &it.scan.sequence, it.scan.scan)
    })?;
    let mut kitti = by_scan(&runs, KITTI_OBJECT_CSV, |it: &KittiObjectRow| {
        (&it.scan.dataset, &it.scan.sequence, it.scan.scan)
    })?;
    let mut labels = by_scan(&runs, PROTOCOL_LABELS_CSV, |it: &LabelScoreRow| {
        (&it.scan.dataset, &it.scan.sequence, it.scan.scan)
    })?;
    let mut patches = Vec::new();
    for run in runs {
        let points = WorstPoints::read(&run.join(WORST_POINTS_JSON))?;
        patches.extend(points.into_iter().flat_map(|it| it.patches));
    }
    let event = |(number, key): (u64, ScanKey)| {
        let is_of_scan = |it: &&Patch| {
            (&it.object.dataset, &it.object.sequence, it.object.scan) == (&key.0, &key.1, key.2)
        };
        RunEvent::Scan(Box::new(ScanEvent {
            dataset_idx: manifest.datasets.iter().position(|it| it.id == key.0).unwrap_or_default(),
            place: number as usize,
            number,
            is_labeled: true,
            n_labels: 0,
            n_points_left_out: 0,
            patches: patches.iter().filter(is_of_scan).cloned().collect(),
            scans: scans.remove(&key).unwrap_or_default(),
            matches: matches.remove(&key).unwrap_or_default(),
            stages: stages.remove(&key).unwrap_or_default(),
            pose: poses.remove(&key).unwrap_or_default(),
            official: OfficialRows {
                boxes: boxes.remove(&key).unwrap_or_default(),
                kitti: kitti.remove(&key).unwrap_or_default(),
                labels: labels.remove(&key).unwrap_or_default(),
            },
            agreement: Vec::new(),
        }))
    };
    Ok((0..).zip(order).map(event).collect())
}

/// The rows of the file `name` of these runs, those of the first before those of the second; none where there is no file.
fn by_scan<Row: CsvRow>(
    runs: &[&Path],
    name: &str,
    key: impl Fn(&Row) -> (&String, &String, u32),
) -> Result<ByScan<Row>, ArchiveError> {
    let mut rows: ByScan<Row> = BTreeMap::new();
    for path in runs.iter().map(|it| it.join(name)).filter(|it| it.is_file()) {
        for row in read_rows::<Row>(&path)? {
            let (dataset, sequence, scan) = key(&row);
            rows.entry((dataset.clone(), sequence.clone(), scan)).or_default().push(row);
        }
    }
    Ok(rows)
}
