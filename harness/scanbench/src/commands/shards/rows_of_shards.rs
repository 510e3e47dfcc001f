//! The rows of shards, one after the other: copied as they are, and read for the numbers that are made of them.

use std::collections::BTreeSet;
use std::io::{self, Read, Write as _};
use std::path::PathBuf;

use reports::facts::gathered_run::GatheredRun;
use reports::files::archive::ArchiveError;
use reports::files::csv_rows::{CsvRow, csv_head, each_row_of};
use reports::files::whole_file::WholeFile;
use reports::numbers::tally::Tally;
use reports::protocols::protocol_tally::ProtocolTally;
use reports::rows::kitti_object_row::KittiObjectRow;
use reports::rows::label_score_row::LabelScoreRow;
use reports::rows::match_row::MatchRow;
use reports::rows::ranked_box_row::RankedBoxRow;
use reports::rows::scan_row::ScanRow;
use reports::rows::stage_row::StageRow;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{
    KITTI_OBJECT_CSV, MATCHES_CSV, PROTOCOL_BOXES_CSV, PROTOCOL_FILES, RunDirectory, SCANS_CSV, STAGES_CSV,
    protocol_file,
};
use reports::run_folder::shard_check::ShardMismatch;
use reports::run_folder::shard_record::processors_of;

use super::shard_directory::{FileOfShard, ShardDirectory};
use crate::commands::failure::Failure;
use crate::commands::progress::progress_over_results;

/// What rows of shards come to.
pub struct MergedRows {
    /// Their sums and their worst mistakes.
    pub gathered: GatheredRun,
    /// The sums of rows under protocols of others.
    pub protocols: ProtocolTally,
    /// The times of each kind of processor by themselves, where these are unlike.
    pub of_processors: Vec<(String, Tally)>,
}

/// Writes the rows of `shards`, which are in the order of the run, into `directory`.
pub fn merge_rows(
    shards: &[ShardDirectory<'_>],
    manifest: &Manifest,
    directory: &RunDirectory,
) -> Result<MergedRows, Failure> {
    let processors = processors_of(&manifest.shards);
    let unlike = processors.iter().filter(|_| processors.len() > 1);
    let mut merged = MergedRows {
        gathered: GatheredRun::of(manifest),
        protocols: ProtocolTally::default(),
        of_processors: unlike.map(|it| ((*it).to_owned(), Tally::default())).collect(),
    };
    let progress = progress_over_results(3 * shards.len(), 0, "files");
    let mut output = Output::begin::<ScanRow>(directory, SCANS_CSV)?;
    for shard in shards {
        merged.add_scans(shard, &mut output)?;
        progress.inc(1);
    }
    output.finish()?;
    let mut output = Output::begin::<MatchRow>(directory, MATCHES_CSV)?;
    for (shard_idx, shard) in shards.iter().enumerate() {
        copy_rows(shard, &mut output, |row: MatchRow| merged.gathered.add_match(&row, shard_idx))?;
        progress.inc(1);
    }
    output.finish()?;
    let mut output = Output::begin::<StageRow>(directory, STAGES_CSV)?;
    for shard in shards {
        copy_rows(shard, &mut output, |row: StageRow| merged.gathered.add_stage(&row))?;
        progress.inc(1);
    }
    output.finish()?;
    merged.add_official(shards, manifest, directory)?;
    progress.finish_and_clear();
    Ok(merged)
}

impl MergedRows {
    /// Copies the rows under protocols of others.
    fn add_official(
        &mut self,
        shards: &[ShardDirectory<'_>],
        manifest: &Manifest,
        directory: &RunDirectory,
    ) -> Result<(), Failure> {
        let Self { gathered, protocols: tally, .. } = self;
        let names: BTreeSet<&str> = manifest.protocols.iter().map(|it| protocol_file(*it)).collect();
        for name in PROTOCOL_FILES.into_iter().filter(|it| names.contains(it)) {
            let mut output = match name {
                PROTOCOL_BOXES_CSV => Output::begin::<RankedBoxRow>(directory, name)?,
                KITTI_OBJECT_CSV => Output::begin::<KittiObjectRow>(directory, name)?,
                _ => Output::begin::<LabelScoreRow>(directory, name)?,
            };
            for shard in shards {
                match name {
                    PROTOCOL_BOXES_CSV => copy_rows(shard, &mut output, |row| {
                        gathered.add_ranked_box(&row);
                        tally.add_ranked_box(&row);
                    })?,
                    KITTI_OBJECT_CSV => copy_rows(shard, &mut output, |row| {
                        gathered.add_kitti_object(&row);
                        tally.add_kitti_object(&row);
                    })?,
                    _ => copy_rows(shard, &mut output, |row| tally.add_label_score(&row))?,
                }
                tally.check().map_err(|problem| shard.damaged(problem))?;
            }
            output.finish()?;
        }
        Ok(())
    }

    fn add_scans(&mut self, shard: &ShardDirectory<'_>, output: &mut Output) -> Result<(), Failure> {
        let stretches = &shard.record.processors[..];
        let (mut stretch_idx, mut n_left) = (0, stretches.first().map_or(0, |it| it.n_scan_rows));
        let (mut last, mut twice, mut n_surplus) = (None, None, 0_u64);
        copy_rows(shard, output, |row: ScanRow| {
            let scan = (row.dataset.clone(), row.sequence.clone(), row.scan);
            if last.as_ref() != Some(&scan) {
                if twice.is_none() && self.gathered.tally.has_scan(&row.dataset, &row.sequence, row.scan) {
                    twice = Some(scan.clone());
                }
                last = Some(scan);
            }
            self.gathered.add_scan(&row);
            while n_left == 0 && stretch_idx + 1 < stretches.len() {
                stretch_idx += 1;
                n_left = stretches[stretch_idx].n_scan_rows;
            }
            match n_left.checked_sub(1) {
                Some(n) => n_left = n,
                None => n_surplus += 1,
            }
            let model = stretches.get(stretch_idx).map(|it| &it.cpu_model);
            let of_processor = self.of_processors.iter_mut().find(|(name, _)| Some(name) == model);
            if let Some((_, tally)) = of_processor {
                tally.add_scan(&row);
            }
        })?;
        if let Some((dataset, sequence, scan)) = twice {
            let (name, scan) = (shard.folder.display().to_string(), format!("{dataset} {sequence} {scan}"));
            return Err(ShardMismatch::same_scan(&name, &scan).into());
        }
        if n_left > 0 || n_surplus > 0 || stretch_idx + 1 < stretches.len() {
            return Err(
                shard.damaged(format!("{SCANS_CSV} has another number of rows than its manifest says"))
            );
        }
        Ok(())
    }
}

/// A file of the run that rows are copied to.
struct Output {
    name: &'static str,
    path: PathBuf,
    file: WholeFile,
}

impl Output {
    fn begin<Row: CsvRow>(directory: &RunDirectory, name: &'static str) -> Result<Self, ArchiveError> {
        let path = directory.path_of(name);
        let mut file = directory.begin_file(name)?;
        let written = file.write_all(&csv_head::<Row>());
        written.map_err(|source| ArchiveError::Write { path: path.clone(), source })?;
        Ok(Self { name, path, file })
    }

    fn finish(self) -> Result<(), ArchiveError> {
        self.file.finish()
    }
}

/// Copies the rows of a file of `shard`, and hands each to `on_row`. What was copied is compared with the checksum of the
/// shard.
fn copy_rows<Row: CsvRow>(
    shard: &ShardDirectory<'_>,
    output: &mut Output,
    on_row: impl FnMut(Row),
) -> Result<(), Failure> {
    let file = shard.open(output.name)?;
    let path = file.path.clone();
    let n_head_left = csv_head::<Row>().len();
    let mut reader = CopyingReader { file, n_head_left, copy: &mut output.file, refused: None };
    let read = each_row_of(&mut reader, &path, on_row);
    if let Some(source) = reader.refused {
        return Err(ArchiveError::Write { path: output.path.clone(), source }.into());
    }
    read.map_err(|error| Failure::damaged_run(&shard.folder, error))?;
    reader.file.check(shard)
}

/// Copies what is read, but for the names of the columns.
struct CopyingReader<'a> {
    file: FileOfShard<'a>,
    n_head_left: usize,
    copy: &'a mut WholeFile,
    // Why the copy cannot be written.
    refused: Option<io::Error>,
}

impl Read for CopyingReader<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n_read = self.file.read(buffer)?;
        let bytes = &buffer[..n_read];
        let n_head = self.n_head_left.min(n_read);
        self.n_head_left -= n_head;
        if let Err(error) = self.copy.write_all(&bytes[n_head..]) {
            let kind = error.kind();
            self.refused = Some(error);
            return Err(kind.into());
        }
        Ok(n_read)
    }
}
