//! Cuts a sweep into shards.

use evaluation::journal::Journal;
use evaluation::sweep::scan_at_point::{JournalEntry, TimedScan};
use reports::files::archive::ArchiveError;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::shard_record::{ProcessorRows, ShardRecord};
use reports::vocabulary::shard::Shard;

use crate::plumbing::failure::Failure;
use crate::plumbing::open_datasets::{OpenedDataset, ids_of};
use crate::plumbing::shards::executor::SharedWork;
use crate::plumbing::shards::share_of_work::{ShareOfWork, claim_share};
use crate::plumbing::shards::unfinished_work::UnfinishedWork;
use crate::verbs::sweep::setup::Sweep;
use crate::verbs::sweep::whole_sweep::WholeSweep;

impl SharedWork for Sweep<'_> {
    type Event = JournalEntry;
    type Whole = WholeSweep;

    fn claim_share(&mut self, shard: Shard) -> ShareOfWork {
        claim_share(&mut self.datasets, shard)
    }

    fn manifest(&self, shard: Option<ShardRecord>) -> Manifest {
        Manifest { shard, ..self.manifest() }
    }

    fn ids(&self) -> String {
        ids_of(&self.datasets)
    }

    fn extent(&self) -> String {
        format!("{} scans", self.datasets.iter().map(|it| it.part.len()).sum::<usize>())
    }

    fn add_done(&mut self, entry: JournalEntry) -> bool {
        match entry {
            JournalEntry::Quality(it) => self.counted.insert(it.key()),
            JournalEntry::Times(it) => self.timed.insert(it.key()),
        }
    }

    fn done(&self) -> Option<String> {
        let n_done = self.counted.len();
        (n_done > 0).then(|| format!("{n_done} of {} results", self.n_results()))
    }

    fn resume(&mut self, unfinished: &UnfinishedWork, _: &ShardRecord) -> Result<(), Failure> {
        self.run(&unfinished.journal)?;
        self.datasets.iter().for_each(OpenedDataset::warn_of_points_left_out);
        Ok(())
    }

    fn finished_manifest(&mut self, journal: &Journal, mut record: ShardRecord) -> Result<Manifest, Failure> {
        record.processors = processors_in(journal)?;
        // Programs of others have introduced themselves by now.
        Ok(SharedWork::manifest(self, Some(record)))
    }
}

/// The processors that scans were timed on, in the order of the journal.
fn processors_in(journal: &Journal) -> Result<Vec<ProcessorRows>, ArchiveError> {
    let mut processors: Vec<ProcessorRows> = Vec::new();
    let read = Journal::read(journal.path(), |entry| {
        let JournalEntry::Times(TimedScan { processor, .. }) = entry else { return true };
        match processors.last_mut().filter(|it| it.cpu_model == processor) {
            Some(last) => last.n_scan_rows += 1,
            None => processors.push(ProcessorRows { cpu_model: processor, n_scan_rows: 1 }),
        }
        true
    });
    read.map_err(|source| ArchiveError::Read { path: journal.path().to_owned(), source })?;
    Ok(processors)
}
