//! From the journal of a shard to its files.

use std::collections::BTreeSet;
use std::path::Path;

use evaluation::journal::Journal;
use reports::files::archive::ArchiveError;
use reports::files::csv_rows::{CsvRow, csv_head, each_row_of, to_csv_bytes};
use reports::rows::agreement_row::{AgreementRow, add_agreement};
use reports::rows::kitti_object_row::KittiObjectRow;
use reports::rows::label_score_row::LabelScoreRow;
use reports::rows::match_row::MatchRow;
use reports::rows::official_rows::OfficialLines;
use reports::rows::ranked_box_row::RankedBoxRow;
use reports::rows::scan_row::ScanRow;
use reports::rows::stage_row::StageRow;
use reports::run_folder::manifest::{Manifest, SkippedScan};
use reports::run_folder::run_directory::{
    AGREEMENT_CSV, KITTI_OBJECT_CSV, MATCHES_CSV, PROTOCOL_BOXES_CSV, PROTOCOL_LABELS_CSV, SCANS_CSV,
    STAGES_CSV, WORST_POINTS_JSON, protocol_file,
};
use reports::run_folder::shard_record::{ProcessorRows, ShardRecord, ShardRecording};
use reports::vocabulary::protocol::Protocol;
use reports::worst::objects::{ObjectName, WorstObject, WorstObjects};
use reports::worst::points::{Patch, PlanCells, WorstPoints};
use reports::worst::recorded::RecordedObject;

use super::checksummed_file::{ChecksummedFile, write_checksummed};
use super::shard_entry::{ShardEntry, ShardScan};
use crate::commands::failure::Failure;

/// Writes the rows of `journal` into `folder`, and what they are into `manifest` and `record`.
pub fn write_shard_files(
    journal: &Journal,
    folder: &Path,
    manifest: &mut Manifest,
    record: &mut ShardRecord,
) -> Result<(), Failure> {
    let mut files = ShardFiles::begin(folder, record.parts.len(), &manifest.protocols)?;
    let mut failure = None;
    journal.each_entry(|entry: ShardEntry| {
        if failure.is_none() {
            failure = files.add(entry).err();
        }
    })?;
    if let Some(failure) = failure {
        return Err(failure);
    }
    files.finish(folder, manifest, record)
}

/// What is known of a data set after some scans.
#[derive(Default)]
struct DatasetSoFar {
    n_labels: u64,
    n_labeled_scans: u64,
    n_points_left_out: u64,
    skipped: Vec<SkippedScan>,
    skipped_names: BTreeSet<String>,
    agreement: Vec<AgreementRow>,
}

/// A mistake with what was seen around it, and the number of its scan.
type SeenMistake = (PlanCells, u64);

struct ShardFiles {
    scans: ChecksummedFile,
    matches: ChecksummedFile,
    stages: ChecksummedFile,
    // Of protocols of others, those that were asked for.
    boxes: Option<ChecksummedFile>,
    kitti: Option<ChecksummedFile>,
    labels: Option<ChecksummedFile>,
    datasets: Vec<DatasetSoFar>,
    worst: WorstObjects<SeenMistake>,
    processors: Vec<ProcessorRows>,
    recordings: Vec<ShardRecording>,
    // Names of detectors, and why their boxes are suspect.
    doubts: Vec<(String, String)>,
}

impl ShardFiles {
    fn begin(folder: &Path, n_datasets: usize, protocols: &[Protocol]) -> Result<Self, Failure> {
        let is_asked = |name: &str| protocols.iter().any(|it| protocol_file(*it) == name);
        Ok(Self {
            scans: begin_rows::<ScanRow>(folder, SCANS_CSV)?,
            matches: begin_rows::<MatchRow>(folder, MATCHES_CSV)?,
            stages: begin_rows::<StageRow>(folder, STAGES_CSV)?,
            boxes: is_asked(PROTOCOL_BOXES_CSV)
                .then(|| begin_rows::<RankedBoxRow>(folder, PROTOCOL_BOXES_CSV))
                .transpose()?,
            kitti: is_asked(KITTI_OBJECT_CSV)
                .then(|| begin_rows::<KittiObjectRow>(folder, KITTI_OBJECT_CSV))
                .transpose()?,
            labels: is_asked(PROTOCOL_LABELS_CSV)
                .then(|| begin_rows::<LabelScoreRow>(folder, PROTOCOL_LABELS_CSV))
                .transpose()?,
            datasets: (0..n_datasets).map(|_| DatasetSoFar::default()).collect(),
            worst: WorstObjects::default(),
            processors: Vec::new(),
            recordings: Vec::new(),
            doubts: Vec::new(),
        })
    }

    fn add(&mut self, entry: ShardEntry) -> Result<(), Failure> {
        match entry {
            ShardEntry::Began { cpu_model } => {
                if self.processors.last().is_none_or(|it| it.cpu_model != cpu_model) {
                    self.processors.push(ProcessorRows { cpu_model, n_scan_rows: 0 });
                }
            }
            ShardEntry::Scan(scan) => self.add_scan(*scan)?,
            ShardEntry::Skipped { dataset_idx, scan, reason } => {
                let dataset = &mut self.datasets[dataset_idx];
                // Whoever was interrupted behind it has met it twice.
                if dataset.skipped_names.insert(scan.clone()) {
                    dataset.skipped.push(SkippedScan { scan, reason });
                }
            }
            ShardEntry::Doubt { detector, doubt } => self.doubts.push((detector, doubt)),
            ShardEntry::Recorded(recording) => self.recordings.push(recording),
        }
        Ok(())
    }

    fn add_scan(&mut self, scan: ShardScan) -> Result<(), Failure> {
        let dataset = &mut self.datasets[scan.dataset_idx];
        dataset.n_labels += scan.n_labels;
        dataset.n_labeled_scans += u64::from(scan.is_labeled);
        dataset.n_points_left_out += scan.n_points_left_out;
        add_agreement(&mut dataset.agreement, scan.agreement);
        if let Some(processor) = self.processors.last_mut() {
            processor.n_scan_rows += scan.n_scan_rows;
        }
        self.scans.write(scan.scans.as_bytes())?;
        self.matches.write(scan.matches.as_bytes())?;
        self.stages.write(scan.stages.as_bytes())?;
        let OfficialLines { boxes, kitti, labels } = &scan.official;
        let official = [(&mut self.boxes, boxes), (&mut self.kitti, kitti), (&mut self.labels, labels)];
        for (file, lines) in official {
            if let Some(file) = file {
                file.write(lines.as_bytes())?;
            }
        }
        let worst = &mut self.worst;
        let lines = [csv_head::<MatchRow>(), scan.matches.into_bytes()].concat();
        each_row_of(&lines[..], &self.matches.path, |row: MatchRow| {
            let of = |it: &&Patch| ObjectName::shown_of(&row).as_ref() == Some(&it.object);
            let cells = || scan.patches.iter().find(of).map(|it| it.cells.clone()).unwrap_or_default();
            worst.add(&row, |_| (cells(), scan.number));
        })?;
        Ok(())
    }

    fn finish(self, folder: &Path, manifest: &mut Manifest, record: &mut ShardRecord) -> Result<(), Failure> {
        record.files = vec![self.scans.finish()?, self.matches.finish()?, self.stages.finish()?];
        for file in [self.boxes, self.kitti, self.labels].into_iter().flatten() {
            record.files.push(file.finish()?);
        }
        let objects = || self.worst.lists().flat_map(|(_, objects)| objects);
        let patch =
            |it: &WorstObject<SeenMistake>| Patch { object: it.object.clone(), cells: it.kept.0.clone() };
        let points = WorstPoints::of_patches(objects().map(patch).collect()).to_json();
        record.files.push(write_checksummed(folder, WORST_POINTS_JSON, points.as_bytes())?);
        record.worst_recorded =
            recorded_objects(objects().map(|it| (&it.object, it.kept.1)), &self.recordings);
        let mut agreement = Vec::new();
        for (dataset_idx, dataset) in self.datasets.into_iter().enumerate() {
            record.parts[dataset_idx].n_labels = dataset.n_labels;
            record.parts[dataset_idx].n_labeled_scans = dataset.n_labeled_scans;
            let entry = &mut manifest.datasets[dataset_idx];
            entry.n_points_left_out = dataset.n_points_left_out;
            entry.skipped_scans.extend(dataset.skipped);
            if dataset.n_labeled_scans == 0 {
                agreement.extend(dataset.agreement);
            }
        }
        if !agreement.is_empty() {
            record.files.push(write_checksummed(folder, AGREEMENT_CSV, &to_csv_bytes(&agreement)?)?);
        }
        for (detector, doubt) in self.doubts {
            let entry = manifest.detectors.iter_mut().find(|it| it.name == detector);
            // Whoever was interrupted may have looked twice.
            if let Some(entry) = entry.filter(|it| !it.doubts.contains(&doubt)) {
                entry.doubts.push(doubt);
            }
        }
        record.processors = self.processors;
        record.recordings = self.recordings;
        Ok(())
    }
}

/// Begins a file of rows with the names of the columns.
fn begin_rows<Row: CsvRow>(folder: &Path, name: &'static str) -> Result<ChecksummedFile, ArchiveError> {
    let mut begun = ChecksummedFile::begin(folder, name)?;
    begun.write(&csv_head::<Row>())?;
    Ok(begun)
}

/// Those of `seen`, objects with the numbers of their scans, that are in one of `recordings`; each once.
fn recorded_objects<'a>(
    seen: impl Iterator<Item = (&'a ObjectName, u64)>,
    recordings: &[ShardRecording],
) -> Vec<RecordedObject> {
    let mut recorded: Vec<RecordedObject> = Vec::new();
    for (object, step) in seen {
        let holds =
            |it: &&ShardRecording| (it.first..it.end).contains(&step) && step.is_multiple_of(it.every);
        let Some(recording) = recordings.iter().find(holds) else { continue };
        if recorded.iter().all(|it| it.object != *object) {
            recorded.push(RecordedObject { object: object.clone(), recording: recording.file.clone(), step });
        }
    }
    recorded
}
