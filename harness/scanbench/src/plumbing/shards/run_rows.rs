//! Rows of a run, as its events come: written to its files, and gathered for its numbers.

use std::path::{Path, PathBuf};

use reports::facts::gathered_run::{GatheredRun, Surroundings};
use reports::files::archive::ArchiveError;
use reports::files::csv_rows::{CsvRow, CsvRowWriter};
use reports::files::new_file::add_name;
use reports::files::whole_file::WholeFile;
use reports::numbers::tally::Tally;
use reports::protocols::protocol_tally::ProtocolTally;
use reports::rows::agreement_row::{AgreementRow, add_agreement};
use reports::rows::kitti_object_row::KittiObjectRow;
use reports::rows::label_score_row::LabelScoreRow;
use reports::rows::match_row::MatchRow;
use reports::rows::pose_row::PoseRow;
use reports::rows::ranked_box_row::RankedBoxRow;
use reports::rows::scan_row::ScanRow;
use reports::rows::stage_row::StageRow;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{
    KITTI_OBJECT_CSV, MATCHES_CSV, POSES_CSV, PROTOCOL_BOXES_CSV, PROTOCOL_FILES, PROTOCOL_LABELS_CSV,
    RunDirectory, SCANS_CSV, STAGES_CSV, protocol_file,
};
use reports::run_folder::shard_record::processors_of;
use reports::worst::objects::ObjectName;
use reports::worst::points::Patch;

use super::run_event::{RunEvent, ScanEvent};

/// Rows of a run: in files, and in sums.
pub struct RunRows {
    pub files: RowFiles,
    pub sums: RowSums,
    // Index of the present processor in `of_processors`, if that has it.
    processor_idx: Option<usize>,
}

/// Files of rows that grow.
pub struct RowFiles {
    folder: PathBuf,
    scans: CsvRowWriter<ScanRow>,
    matches: CsvRowWriter<MatchRow>,
    stages: CsvRowWriter<StageRow>,
    poses: CsvRowWriter<PoseRow>,
    // For those protocols of others that were asked for.
    boxes: Option<CsvRowWriter<RankedBoxRow>>,
    kitti: Option<CsvRowWriter<KittiObjectRow>>,
    labels: Option<CsvRowWriter<LabelScoreRow>>,
}

pub struct RowSums {
    /// Sums and worst mistakes.
    pub gathered: GatheredRun,
    /// Sums of rows under protocols of others.
    pub protocols: ProtocolTally,
    /// Times by kind of processor, if there are several.
    pub of_processors: Vec<(String, Tally)>,
    /// How far detectors agree where nothing is labelled.
    pub agreement: Vec<AgreementRow>,
}

impl RunRows {
    /// Begins without rows for the run of `manifest`, with files in `folder`.
    pub fn begin(manifest: &Manifest, folder: &Path) -> Result<Self, ArchiveError> {
        let processors = processors_of(&manifest.shards);
        let unlike = processors.iter().filter(|_| processors.len() > 1);
        let is_asked = |name: &str| manifest.protocols.iter().any(|it| protocol_file(*it) == name);
        Ok(Self {
            files: RowFiles {
                folder: folder.to_owned(),
                scans: begin(folder, SCANS_CSV)?,
                matches: begin(folder, MATCHES_CSV)?,
                stages: begin(folder, STAGES_CSV)?,
                poses: begin(folder, POSES_CSV)?,
                boxes: begin_if(is_asked(PROTOCOL_BOXES_CSV), folder, PROTOCOL_BOXES_CSV)?,
                kitti: begin_if(is_asked(KITTI_OBJECT_CSV), folder, KITTI_OBJECT_CSV)?,
                labels: begin_if(is_asked(PROTOCOL_LABELS_CSV), folder, PROTOCOL_LABELS_CSV)?,
            },
            sums: RowSums {
                gathered: GatheredRun::of(manifest),
                protocols: ProtocolTally::default(),
                of_processors: unlike.map(|it| ((*it).to_owned(), Tally::default())).collect(),
                agreement: Vec::new(),
            },
            processor_idx: None,
        })
    }

    /// Adds `event` of the shard at `shard_idx`.
    pub fn add(&mut self, event: &RunEvent, shard_idx: usize) -> Result<(), ArchiveError> {
        match event {
            RunEvent::Began { cpu_model } => {
                self.processor_idx = self.sums.of_processors.iter().position(|(name, _)| name == cpu_model);
            }
            RunEvent::Scan(scan) => self.add_scan(scan, shard_idx)?,
            RunEvent::Skipped { .. } | RunEvent::Doubt { .. } | RunEvent::Recorded(_) => {}
        }
        Ok(())
    }

    fn add_scan(&mut self, scan: &ScanEvent, shard_idx: usize) -> Result<(), ArchiveError> {
        self.files.add(scan)?;
        let RowSums { gathered, protocols, of_processors, agreement } = &mut self.sums;
        for row in &scan.scans {
            gathered.add_scan(row);
            if let Some(processor_idx) = self.processor_idx {
                of_processors[processor_idx].1.add_scan(row);
            }
        }
        scan.matches.iter().for_each(|row| gathered.add_match(row, || surroundings(row, scan, shard_idx)));
        scan.stages.iter().for_each(|row| gathered.add_stage(row));
        scan.official.boxes.iter().for_each(|row| gathered.add_ranked_box(row));
        scan.official.kitti.iter().for_each(|row| gathered.add_kitti_object(row));
        protocols.add(&scan.official);
        add_agreement(agreement, scan.agreement.iter().cloned());
        Ok(())
    }
}

impl RowFiles {
    fn add(&mut self, scan: &ScanEvent) -> Result<(), ArchiveError> {
        scan.scans.iter().try_for_each(|row| self.scans.write(row))?;
        scan.matches.iter().try_for_each(|row| self.matches.write(row))?;
        scan.stages.iter().try_for_each(|row| self.stages.write(row))?;
        scan.pose.iter().try_for_each(|row| self.poses.write(row))?;
        write_all(&mut self.boxes, &scan.official.boxes)?;
        write_all(&mut self.kitti, &scan.official.kitti)?;
        write_all(&mut self.labels, &scan.official.labels)
    }

    pub fn finish(self) -> Result<(), ArchiveError> {
        self.scans.finish()?;
        self.matches.finish()?;
        self.stages.finish()?;
        self.poses.finish()?;
        self.boxes.map_or(Ok(()), CsvRowWriter::finish)?;
        self.kitti.map_or(Ok(()), CsvRowWriter::finish)?;
        self.labels.map_or(Ok(()), CsvRowWriter::finish)
    }

    /// Completes the files, and gives them to `directory`.
    pub fn finish_in(self, directory: &RunDirectory) -> Result<(), ArchiveError> {
        let folder = self.folder.clone();
        self.finish()?;
        if folder == directory.folder() {
            return Ok(());
        }
        for name in [SCANS_CSV, MATCHES_CSV, STAGES_CSV, POSES_CSV].into_iter().chain(PROTOCOL_FILES) {
            let (from, path) = (folder.join(name), directory.path_of(name));
            if from.is_file() {
                add_name(&from, &path).map_err(|source| ArchiveError::Write { path, source })?;
            }
        }
        Ok(())
    }
}

fn begin<Row: CsvRow>(folder: &Path, name: &str) -> Result<CsvRowWriter<Row>, ArchiveError> {
    CsvRowWriter::new(WholeFile::create(&folder.join(name))?)
}

fn begin_if<Row: CsvRow>(
    is_asked: bool,
    folder: &Path,
    name: &str,
) -> Result<Option<CsvRowWriter<Row>>, ArchiveError> {
    is_asked.then(|| begin(folder, name)).transpose()
}

fn write_all<Row: CsvRow>(file: &mut Option<CsvRowWriter<Row>>, rows: &[Row]) -> Result<(), ArchiveError> {
    file.as_mut().map_or(Ok(()), |file| rows.iter().try_for_each(|row| file.write(row)))
}

fn surroundings(row: &MatchRow, scan: &ScanEvent, shard_idx: usize) -> Surroundings {
    let object = ObjectName::shown_of(row);
    let patch = scan.patches.iter().find(|it: &&Patch| object.as_ref() == Some(&it.object));
    let cells = patch.map(|it| it.cells.clone()).unwrap_or_default();
    Surroundings { cells, scan_number: scan.number, shard_idx }
}
