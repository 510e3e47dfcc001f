//! A sweep made of the results of its shards.

use evaluation::sweep::scan_at_point::{JournalEntry, ScanAtPoint, TimedScan};
use evaluation::sweep::sweep_tally::SweepTally;
use reports::files::csv_rows::CsvRowWriter;
use reports::numbers::sweep_score::SweepScores;
use reports::pages::sweep_page::SweepPage;
use reports::rows::scan_row::ScanRow;
use reports::run_folder::manifest::{DetectorEntry, Manifest};
use reports::run_folder::run_directory::{REPORT_JSON, RunDirectory, SCANS_CSV, SHARD_LOG};
use reports::run_folder::run_target::MANIFEST_JSON;
use reports::run_folder::sweep_entry::SweepEntry;
use reports::vocabulary::study::Study;
use reports::vocabulary::task::Task;

use crate::plumbing::failure::Failure;
use crate::plumbing::progress::progress_over_results;
use crate::plumbing::shards::executor::WholeResult;
use crate::plumbing::shards::shard_log::ShardLog;
use crate::plumbing::shards::whole_manifest::{Pieces, merged_manifest};
use crate::plumbing::standard_streams::terminal;
use crate::verbs::sweep::files::{
    refuse_nothing, write_best, write_sweep, write_swept_protocols, write_times_of_unlike,
};

/// A sweep that is completely counted, and written.
pub struct WholeSweep {
    pub scores: SweepScores,
    pub printed: String,
}

impl WholeResult for WholeSweep {
    fn of_shards(
        _: Study,
        shards: &[ShardLog<'_>],
        manifests: &[&Manifest],
        directory: &RunDirectory,
    ) -> Result<Self, Failure> {
        let pieces = shards[0].pieces();
        let mut manifest = merged_manifest(manifests, directory.target(), pieces);
        let no_sweep = || shards[0].damaged("its manifest does not say what was swept".to_owned());
        let mut tally = SweepTally::of(&manifest).ok_or_else(no_sweep)?;
        let mut rows = CsvRowWriter::new(directory.begin_file(SCANS_CSV)?)?;
        let progress = progress_over_results(shards.len(), 0, "shards");
        for shard in shards {
            add_shard(&mut tally, &mut rows, shard, &manifest)?;
            progress.inc(1);
        }
        progress.finish_and_clear();
        rows.finish()?;
        let drawn = tally.draw();
        directory.write_file(REPORT_JSON, drawn.report(manifest.scoring_version)?.to_json().as_bytes())?;
        let scores = drawn.summary();
        refuse_nothing(&scores)?;
        let mut printed = write_sweep(directory, &scores)?;
        if !manifest.protocols.is_empty() {
            printed.push_str(&write_swept_protocols(directory, &manifest, &tally)?);
        }
        // The answer last.
        let best = write_best(directory, &manifest, &drawn, &scores)?;
        printed = format!("{}\n\n{}", printed.trim_end(), terminal().sentences(best).trim_end());
        let unlike = tally.times_of_processors();
        write_times_of_unlike(directory, &scores, &unlike)?;
        if pieces == Pieces::One && unlike.is_empty() {
            manifest.shards.clear();
        }
        directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
        SweepPage::of(directory.folder())?.write(directory.folder())?;
        Ok(Self { scores, printed })
    }
}

fn add_shard(
    tally: &mut SweepTally<'_>,
    rows: &mut CsvRowWriter<ScanRow>,
    shard: &ShardLog<'_>,
    manifest: &Manifest,
) -> Result<(), Failure> {
    let Some(entry) = &manifest.sweep else { return Ok(()) };
    let expected = Expected { shard, entry, detectors: &manifest.detectors };
    let (mut scans, mut timed): (Vec<ScanAtPoint>, Vec<TimedScan>) = Default::default();
    shard.each_event(|entry| {
        match entry {
            JournalEntry::Quality(mut scan) => {
                expected.check(&scan).map_err(|problem| shard.damaged(problem))?;
                // All rows of a sweep take more memory than there may be.
                tally.add_official(scan.point_idx, &std::mem::take(&mut scan.official));
                scans.push(scan);
            }
            JournalEntry::Times(scan) => {
                expected.check_times(&scan, timed.last()).map_err(|problem| shard.damaged(problem))?;
                timed.push(scan);
            }
        }
        Ok(())
    })?;
    tally.check_official().map_err(|problem| shard.damaged(problem))?;
    // Threads leave them in any order.
    scans.sort_unstable_by_key(ScanAtPoint::key);
    if let Some(difference) = expected.first_difference(scans.iter().map(ScanAtPoint::key)) {
        return Err(shard.damaged(format!("{SHARD_LOG} has {difference}")));
    }
    for scan in &scans {
        scan.scans.iter().try_for_each(|row| rows.write(row))?;
        tally.add(scan);
    }
    for scan in timed {
        tally.add_times(scan);
    }
    Ok(())
}

/// Results that a shard has to have.
struct Expected<'a> {
    shard: &'a ShardLog<'a>,
    entry: &'a SweepEntry,
    detectors: &'a [DetectorEntry],
}

impl Expected<'_> {
    /// Keys of the results, in order.
    fn keys(&self) -> impl Iterator<Item = [usize; 3]> + use<'_> {
        let parts = self.shard.record.parts.iter().enumerate();
        parts.flat_map(move |(dataset_idx, part)| {
            let indices = (part.first..part.end).map(|it| it as usize);
            indices.flat_map(move |scan_idx| {
                (0..self.entry.points.len()).map(move |point_idx| [dataset_idx, scan_idx, point_idx])
            })
        })
    }

    /// In words, the first result that is expected and not there, or there and not expected.
    fn first_difference(&self, mut found: impl Iterator<Item = [usize; 3]>) -> Option<String> {
        let in_words = |it: Option<[usize; 3]>| match it {
            Some([dataset_idx, scan_idx, point_idx]) => {
                format!("data set {dataset_idx}, scan {scan_idx}, point {point_idx}")
            }
            None => "nothing".to_owned(),
        };
        // One more than there are, so that results after the last are found, too.
        let mut expected = self.keys().map(Some).chain([None]);
        expected.find_map(|key| {
            let found = found.next();
            (found != key).then(|| format!("{} where {} is expected", in_words(found), in_words(key)))
        })
    }

    fn check(&self, scan: &ScanAtPoint) -> Result<(), String> {
        if scan.point_idx >= self.entry.points.len() {
            return Err(format!("there is no point {}", scan.point_idx));
        }
        let entrants = self.detectors.iter().map(|it| self.entry.entrant(&it.name, scan.point_idx));
        let expected = entrants.flat_map(|it| Task::ALL.map(|task| (it.clone(), task)));
        let has_all = expected.eq(scan.scans.iter().map(|row| (row.detector.clone(), row.task)));
        if has_all && scan.cells.len() == self.detectors.len() {
            Ok(())
        } else {
            Err("it has other rows than one for each detector and task".to_owned())
        }
    }

    fn check_times(&self, scan: &TimedScan, last: Option<&TimedScan>) -> Result<(), String> {
        let (dataset_idx, scan_idx) = scan.key();
        let part = self.shard.record.parts.get(dataset_idx);
        let is_ours = part.is_some_and(|it| (it.first..it.end).contains(&(scan_idx as u64)));
        if !is_ours || last.is_some_and(|it| it.key() >= scan.key()) {
            return Err(format!(
                "data set {dataset_idx}, scan {scan_idx} is not in order, or of another shard"
            ));
        }
        let has_all = scan.times_ns.len() == self.entry.points.len()
            && scan.times_ns.iter().all(|it| it.len() == self.detectors.len());
        if has_all { Ok(()) } else { Err("not all detectors were timed at all points".to_owned()) }
    }
}
