//! `scanbench merge` of the shards of a sweep.

use evaluation::sweep::scan_at_point::ScanAtPoint;
use evaluation::sweep::sweep_tally::SweepTally;
use evaluation::sweep::timed_scan::TimedScan;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{RunDirectory, SWEPT_SCANS_JSONL, TIMED_SCANS_JSONL};
use reports::run_folder::run_target::{ClaimedTarget, MANIFEST_JSON};
use reports::run_folder::sweep_entry::SweepEntry;
use reports::vocabulary::task::Task;

use crate::commands::failure::Failure;
use crate::commands::progress::progress_over_results;
use crate::commands::shards::shard_directory::ShardDirectory;
use crate::commands::shards::whole_manifest::{Pieces, merged_manifest};
use crate::commands::standard_streams::{print_diagnostic, print_result};
use crate::commands::sweep::files::{refuse_nothing, write_sweep, write_times_of_unlike};

/// Makes the sweep of `shards`, whose manifests are `manifests`, both in order.
pub fn merge_sweep(
    shards: &[ShardDirectory<'_>],
    manifests: &[&Manifest],
    claimed: ClaimedTarget,
) -> Result<(), Failure> {
    let directory = RunDirectory::begin(claimed)?;
    let manifest = merged_manifest(manifests, (directory.target(), Pieces::Shards));
    let no_sweep = || shards[0].damaged("its manifest does not say what was swept".to_owned());
    let mut tally = SweepTally::of(&manifest).ok_or_else(no_sweep)?;
    let entry = manifest.sweep.as_ref().ok_or_else(no_sweep)?;
    let progress = progress_over_results(shards.len(), 0, "shards");
    for shard in shards {
        let expected = Expected { shard, entry, n_detectors: manifest.detectors.len() };
        let mut keys = expected.keys();
        shard.each_line(SWEPT_SCANS_JSONL, |scan: ScanAtPoint| {
            expected.check(&scan, keys.next())?;
            tally.add(&scan);
            Ok(())
        })?;
        if let Some([dataset_idx, scan_idx, point_idx]) = keys.next() {
            let place = format!("scan {scan_idx} of data set {dataset_idx} at point {point_idx}");
            return Err(shard.damaged(format!("{SWEPT_SCANS_JSONL} ends before {place}")));
        }
        let mut last = None;
        shard.each_line(TIMED_SCANS_JSONL, |scan: TimedScan| {
            expected.check_times(&scan, last)?;
            last = Some((scan.dataset_idx, scan.scan_idx));
            tally.add_times(scan);
            Ok(())
        })?;
        progress.inc(1);
    }
    progress.finish_and_clear();
    let scores = tally.summary();
    refuse_nothing(&scores)?;
    directory.write_file(MANIFEST_JSON, manifest.to_json().as_bytes())?;
    let printed = write_sweep(&directory, &scores)?;
    write_times_of_unlike(&directory, &scores, &tally.times_of_processors())?;
    let finished = directory.finish()?;
    let printed = print_result(printed);
    print_diagnostic(format_args!("Sweep: {}", finished.display()));
    printed
}

/// What a shard has to have.
struct Expected<'a> {
    shard: &'a ShardDirectory<'a>,
    entry: &'a SweepEntry,
    n_detectors: usize,
}

impl Expected<'_> {
    /// Its results, in order.
    fn keys(&self) -> impl Iterator<Item = [usize; 3]> + use<'_> {
        let parts = self.shard.record.parts.iter().enumerate();
        parts.flat_map(move |(dataset_idx, part)| {
            let places = (part.first..part.end).map(|it| it as usize);
            places.flat_map(move |scan_idx| {
                (0..self.entry.points.len()).map(move |point_idx| [dataset_idx, scan_idx, point_idx])
            })
        })
    }

    fn check(&self, scan: &ScanAtPoint, key: Option<[usize; 3]>) -> Result<(), String> {
        if key != Some(scan.key()) {
            let in_words = |it: [usize; 3]| format!("data set {}, scan {}, point {}", it[0], it[1], it[2]);
            let expected = key.map_or_else(|| "nothing".to_owned(), in_words);
            return Err(format!("{} stands where {expected} is expected", in_words(scan.key())));
        }
        let n_tasks = scan.detectors.iter().find(|it| it.counts.len() != Task::ALL.len());
        if scan.detectors.len() != self.n_detectors || n_tasks.is_some() {
            return Err(format!(
                "it has other than {} detectors or {} tasks",
                self.n_detectors,
                Task::ALL.len()
            ));
        }
        let is_sound = |it: &evaluation::metrics::counts::Counts| it.n_matched <= it.n_annotations;
        if scan.detectors.iter().all(|it| it.counts.iter().all(is_sound)) {
            Ok(())
        } else {
            Err("more annotations are matched than there are".to_owned())
        }
    }

    fn check_times(&self, scan: &TimedScan, last: Option<(usize, usize)>) -> Result<(), String> {
        let place = (scan.dataset_idx, scan.scan_idx);
        let part = self.shard.record.parts.get(scan.dataset_idx);
        let is_ours = part.is_some_and(|it| (it.first..it.end).contains(&(scan.scan_idx as u64)));
        if !is_ours || last.is_some_and(|it| it >= place) {
            return Err(format!(
                "data set {}, scan {} is not in order, or of another shard",
                place.0, place.1
            ));
        }
        let has_all = scan.times_ns.len() == self.entry.points.len()
            && scan.times_ns.iter().all(|it| it.len() == self.n_detectors);
        if has_all { Ok(()) } else { Err("not all detectors were timed at all points".to_owned()) }
    }
}
