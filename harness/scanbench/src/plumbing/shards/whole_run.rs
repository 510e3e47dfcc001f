//! A run, or a study that is one, made of its rows: in one piece, or of the events of its shards.

use reports::facts::gathered_run::Surroundings;
use reports::facts::run_facts::{BesideRows, RunFacts};
use reports::numbers::tally::Tally;
use reports::protocols::protocol_report::ProtocolReport;
use reports::rows::scan_row::ScanRow;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{
    RECORDING, RECORDINGS_JSON, RunDirectory, WORST_POINTS_JSON, recordings_in,
};
use reports::run_folder::shard_check::ShardMismatch;
use reports::run_folder::shard_record::{ShardPart, ShardRecord};
use reports::vocabulary::study::Study;
use reports::vocabulary::task::Task;
use reports::worst::objects::{WorstObject, WorstObjects};
use reports::worst::points::{Patch, WorstPoints};
use reports::worst::recorded::{RecordedObject, Recordings};

use super::executor::WholeResult;
use super::run_event::RunEvent;
use super::run_rows::{RowSums, RunRows};
use super::shard_log::ShardLog;
use super::whole_manifest::{Pieces, merged_manifest, path_from};
use crate::plumbing::failure::Failure;
use crate::plumbing::progress::progress_over_results;
use crate::plumbing::run_numbers::{
    write_agreement, write_facts, write_protocols, write_times_of_processors,
};
use crate::plumbing::watched_run::{Labels, report_nothing_to_find};

/// A run in which all scans are judged, and which is written.
pub struct WholeRun {
    pub facts: RunFacts,
    /// Tables that are printed beside those of tasks.
    pub more: Vec<String>,
}

impl WholeResult for WholeRun {
    fn of_shards(
        study: Study,
        shards: &[ShardLog<'_>],
        manifests: &[&Manifest],
        directory: &RunDirectory,
    ) -> Result<Self, Failure> {
        let manifest = merged_manifest(manifests, directory.target(), Pieces::Shards);
        let mut rows = RunRows::begin(&manifest, directory.folder())?;
        let progress = progress_over_results(shards.len(), 0, "shards");
        for (shard_idx, shard) in shards.iter().enumerate() {
            shard.each_event(|event: RunEvent| {
                refuse_twice(&event, &rows, shard)?;
                Ok(rows.add(&event, shard_idx)?)
            })?;
            rows.sums.protocols.check().map_err(|problem| shard.damaged(problem))?;
            progress.inc(1);
        }
        progress.finish_and_clear();
        Self::of_rows(study, rows, manifest, directory, shards)
    }
}

impl WholeRun {
    /// The run of `manifest` in one piece.
    pub fn in_one_piece(
        study: Study,
        rows: RunRows,
        manifest: &Manifest,
        directory: &RunDirectory,
    ) -> Result<Self, Failure> {
        let manifest = merged_manifest(&[manifest], directory.target(), Pieces::One);
        Self::of_rows(study, rows, manifest, directory, &[])
    }

    /// Writes `rows` of these `shards`, none if it is in one piece, and all numbers that are made of them.
    fn of_rows(
        study: Study,
        rows: RunRows,
        mut manifest: Manifest,
        directory: &RunDirectory,
        shards: &[ShardLog<'_>],
    ) -> Result<Self, Failure> {
        let RunRows { files, sums, .. } = rows;
        files.finish_in(directory)?;
        let RowSums { gathered, protocols, of_processors, mut agreement } = sums;
        let points = points_of(&gathered.worst);
        directory.write_file(WORST_POINTS_JSON, points.to_json().as_bytes())?;
        let path_of = |shard_idx: usize, file: &str| match shards.get(shard_idx) {
            Some(shard) => path_from(directory.target(), &shard.folder.join(file)),
            None => file.to_owned(),
        };
        let recordings = recordings_of(&gathered.worst, &manifest.shards, path_of);
        if let Some(recordings) = &recordings {
            directory.write_file(RECORDINGS_JSON, recordings.to_json().as_bytes())?;
        }
        agreement.retain(|it| study == Study::Run && labels_of(&manifest, &it.dataset) == Labels::None);
        refuse_nothing(study, &manifest, &gathered.tally)?;
        if shards.is_empty() && of_processors.is_empty() {
            manifest.shards.clear();
        }
        let is_evaluated = !manifest.protocols.is_empty();
        let protocols = is_evaluated.then(|| ProtocolReport::new(protocols.numbers(&gathered.tally)));
        let mut more = match &protocols {
            Some(report) => write_protocols(directory, &manifest, report)?,
            None => Vec::new(),
        };
        more.extend(write_agreement(directory, &agreement)?);
        let draws = gathered.tally.draw();
        let report = gathered.tally.report(manifest.scoring_version, &draws)?;
        let recording_folders = recordings_in(directory.folder());
        let beside = BesideRows {
            points: Some(points),
            recordings,
            protocols,
            agreement,
            recording_folders,
            in_viewer: None,
        };
        let facts = RunFacts::of(gathered, beside, manifest, report, &draws)?;
        write_facts(directory, &facts)?;
        write_times_of_processors(directory, &facts.manifest, &of_processors)?;
        Ok(Self { facts, more })
    }
}

/// Refuses a scan that an earlier shard has, too.
fn refuse_twice(event: &RunEvent, rows: &RunRows, shard: &ShardLog<'_>) -> Result<(), Failure> {
    let RunEvent::Scan(scan) = event else { return Ok(()) };
    let Some(ScanRow { dataset, sequence, scan, .. }) = scan.scans.first() else { return Ok(()) };
    if !rows.sums.gathered.tally.has_scan(dataset, sequence, *scan) {
        return Ok(());
    }
    let (name, scan) = (shard.folder.display().to_string(), format!("{dataset} {sequence} {scan}"));
    Err(ShardMismatch::same_scan(&name, &scan).into())
}

/// Points around the worst mistakes.
fn points_of(worst: &WorstObjects<Surroundings>) -> WorstPoints {
    let objects = worst.lists().flat_map(|(_, objects)| objects);
    let patch =
        |it: &WorstObject<Surroundings>| Patch { object: it.object.clone(), cells: it.kept.cells.clone() };
    WorstPoints::of_patches(objects.map(patch).collect())
}

/// Recordings of the worst mistakes; `None` if one recording in [`RECORDING`] has all, where the number of the scan says enough,
/// or if none are recorded.
fn recordings_of(
    worst: &WorstObjects<Surroundings>,
    shards: &[ShardRecord],
    path_of: impl Fn(usize, &str) -> String,
) -> Option<Recordings> {
    let is_beside = |(shard_idx, shard): (usize, &ShardRecord)| {
        shard.recordings.iter().all(|it| it.file == RECORDING && path_of(shard_idx, RECORDING) == RECORDING)
    };
    if shards.iter().enumerate().all(is_beside) {
        return None;
    }
    let mut recorded: Vec<RecordedObject> = Vec::new();
    for WorstObject { object, kept, .. } in worst.lists().flat_map(|(_, objects)| objects) {
        let recording = shards[kept.shard_idx].recordings.iter().find(|it| it.holds(kept.scan_number));
        if let Some(recording) = recording.filter(|_| recorded.iter().all(|it| it.object != *object)) {
            recorded.push(RecordedObject {
                object: object.clone(),
                recording: path_of(kept.shard_idx, &recording.file),
                step: kept.scan_number,
            });
        }
    }
    (!recorded.is_empty()).then(|| Recordings::new(recorded))
}

/// Labels in the scans of the data set called `id`.
fn labels_of(manifest: &Manifest, id: &str) -> Labels {
    let index = manifest.datasets.iter().position(|it| it.id == id);
    let sum = |count: fn(&ShardPart) -> u64| -> u64 {
        let of_shards = manifest.shards.iter().filter_map(|it| Some(count(it.parts.get(index?)?)));
        of_shards.sum()
    };
    match (sum(|it| it.n_labels), sum(|it| it.n_labeled_scans)) {
        (0, 0) => Labels::None,
        (0, n_labeled_scans) => Labels::OfNothing { n_labeled_scans },
        _ => Labels::OfObjects,
    }
}

/// Reports data sets in which nothing is to be found, as a run in one piece does.
fn refuse_nothing(study: Study, manifest: &Manifest, tally: &Tally) -> Result<(), Failure> {
    for entry in &manifest.datasets {
        let counts = |task: &Task, detector: &String| tally.counts(&entry.id, *task, detector);
        let n_annotations = tally
            .tasks()
            .iter()
            .flat_map(|task| tally.detectors().iter().filter_map(move |it| Some(counts(task, it)?.no())))
            .max();
        if n_annotations.is_none_or(|it| it == 0) {
            // A study is about objects.
            let labels = if study == Study::Run { labels_of(manifest, &entry.id) } else { Labels::OfObjects };
            let n_scans = entry.n_scans - entry.skipped_scans.len() as u64;
            report_nothing_to_find(&entry.id, labels, n_scans, &entry.doubts)?;
        }
    }
    Ok(())
}
