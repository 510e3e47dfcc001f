//! A run, or a study that is one, made of the rows of its shards: all in one piece is the only shard.

use evaluation::metrics::counts::SCORING_VERSION;
use reports::facts::run_facts::{BesideRows, RunFacts};
use reports::files::csv_rows::read_rows;
use reports::numbers::tally::Tally;
use reports::protocols::protocol_report::ProtocolReport;
use reports::rows::agreement_row::{AgreementRow, add_agreement};
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{
    AGREEMENT_CSV, RECORDINGS_JSON, RUN_RRD, RunDirectory, WORST_POINTS_JSON,
};
use reports::run_folder::shard_record::ShardPart;
use reports::vocabulary::study::Study;
use reports::vocabulary::task::Task;
use reports::worst::objects::{ObjectName, WorstObjects};
use reports::worst::points::{Patch, WorstPoints};
use reports::worst::recorded::{RecordedObject, Recordings};

use super::executor::WholeResult;
use super::rows_of_shards::{MergedRows, merge_rows};
use super::shard_directory::ShardDirectory;
use super::whole_manifest::{Pieces, merged_manifest, path_from};
use crate::commands::failure::Failure;
use crate::commands::run_numbers::{
    write_agreement, write_facts, write_protocols, write_times_of_processors,
};
use crate::commands::watched_run::{Labels, report_nothing_to_find};

/// A run in which all scans are judged, and which is written.
pub struct WholeRun {
    /// All that is said about it.
    pub facts: RunFacts,
    /// Tables that are printed beside those of tasks.
    pub more: Vec<String>,
}

impl WholeResult for WholeRun {
    /// Puts the rows of `shards` one after the other, and writes these and all numbers that are made of them.
    fn write(
        study: Study,
        shards: &[ShardDirectory<'_>],
        manifests: &[&Manifest],
        directory: &RunDirectory,
        pieces: Pieces,
    ) -> Result<Self, Failure> {
        let mut manifest = merged_manifest(manifests, directory.target(), pieces);
        let MergedRows { gathered, protocols, of_processors } = merge_rows(shards, &manifest, directory)?;
        let (points, recordings) = write_worst(shards, &gathered.worst, directory, pieces)?;
        let agreement = if study == Study::Run { agreement_of(shards, &manifest)? } else { Vec::new() };
        refuse_nothing(study, &manifest, &gathered.tally)?;
        if pieces == Pieces::One && of_processors.is_empty() {
            manifest.shards.clear();
        }
        let is_evaluated = !manifest.protocols.is_empty();
        let protocols = is_evaluated.then(|| ProtocolReport::new(protocols.numbers(&gathered.tally)));
        let mut more = match &protocols {
            Some(report) => write_protocols(directory, &manifest, report)?,
            None => Vec::new(),
        };
        more.extend(write_agreement(directory, &agreement)?);
        let report = gathered.tally.report(SCORING_VERSION)?;
        let has_recording = directory.path_of(RUN_RRD).is_file();
        let beside = BesideRows { points: Some(points), recordings, protocols, agreement, has_recording };
        let facts = RunFacts::of(gathered, beside, manifest, report)?;
        write_facts(directory, &facts)?;
        write_times_of_processors(directory, &facts.manifest, &of_processors)?;
        Ok(Self { facts, more })
    }
}

/// Writes the points around the worst mistakes, and where these are recorded if one recording does not have all.
fn write_worst(
    shards: &[ShardDirectory<'_>],
    worst: &WorstObjects<usize>,
    directory: &RunDirectory,
    pieces: Pieces,
) -> Result<(WorstPoints, Option<Recordings>), Failure> {
    let seen = shards.iter().map(ShardDirectory::worst_points).collect::<Result<Vec<WorstPoints>, _>>()?;
    let objects: Vec<(&ObjectName, usize)> =
        worst.lists().flat_map(|(_, objects)| objects).map(|it| (&it.object, it.kept)).collect();
    let mut patches = Vec::new();
    for (object, shard_idx) in &objects {
        let cells = seen[*shard_idx].around(object).ok_or_else(|| shards[*shard_idx].lacks(object))?;
        patches.push(Patch { object: (*object).clone(), cells: cells.clone() });
    }
    let points = WorstPoints::of_patches(patches);
    directory.write_file(WORST_POINTS_JSON, points.to_json().as_bytes())?;
    let mut recorded: Vec<RecordedObject> = Vec::new();
    for (object, shard_idx) in objects {
        let shard = &shards[shard_idx];
        let source = shard.record.worst_recorded.iter().find(|it| it.object == *object);
        if let Some(source) = source.filter(|_| recorded.iter().all(|it| it.object != *object)) {
            let recording = match pieces {
                Pieces::One => source.recording.clone(),
                Pieces::Shards => path_from(directory.target(), &shard.folder.join(&source.recording)),
            };
            recorded.push(RecordedObject { recording, ..source.clone() });
        }
    }
    // Of one recording the number of the scan says enough.
    let is_one = |it: &ShardDirectory<'_>| it.record.recordings.iter().all(|it| it.file == RUN_RRD);
    if recorded.is_empty() || pieces == Pieces::One && shards.iter().all(is_one) {
        return Ok((points, None));
    }
    let recordings = Recordings::new(recorded);
    directory.write_file(RECORDINGS_JSON, recordings.to_json().as_bytes())?;
    Ok((points, Some(recordings)))
}

/// How far detectors agree in the data sets of which no shard has found a labelled scan.
fn agreement_of(shards: &[ShardDirectory<'_>], manifest: &Manifest) -> Result<Vec<AgreementRow>, Failure> {
    let mut sums = Vec::new();
    for shard in shards {
        let path = shard.folder.join(AGREEMENT_CSV);
        if path.is_file() {
            let rows = read_rows(&path).map_err(|error| Failure::damaged_run(&shard.folder, error))?;
            add_agreement(&mut sums, rows);
        }
    }
    sums.retain(|it: &AgreementRow| labels_of(manifest, &it.dataset) == Labels::None);
    Ok(sums)
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

/// What a run in one piece says of data sets in which nothing is to be found.
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
