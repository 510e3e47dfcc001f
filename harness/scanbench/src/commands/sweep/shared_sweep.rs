//! How a sweep is shared out.

use std::path::Path;

use evaluation::journal::{Journal, JournalError};
use evaluation::sweep::scan_at_point::JournalEntry;
use reports::files::archive::ArchiveError;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_directory::{SWEPT_SCANS_JSONL, TIMED_SCANS_JSONL};
use reports::run_folder::shard_record::{ProcessorRows, ShardRecord};
use reports::vocabulary::shard::Shard;

use crate::commands::failure::Failure;
use crate::commands::open_datasets::{OpenedDataset, ids_of};
use crate::commands::shards::checksummed_file::ChecksummedFile;
use crate::commands::shards::executor::SharedWork;
use crate::commands::shards::share_of_work::{ShareOfWork, take_share};
use crate::commands::shards::unfinished_work::UnfinishedWork;
use crate::commands::sweep::setup::Sweep;
use crate::commands::sweep::whole_sweep::WholeSweep;

impl SharedWork for Sweep<'_> {
    type Entry = JournalEntry;
    type Whole = WholeSweep;

    fn take_share(&mut self, shard: Shard) -> ShareOfWork {
        take_share(&mut self.datasets, shard)
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

    fn go_on(&mut self, unfinished: &UnfinishedWork, _: Option<Shard>) -> Result<(), Failure> {
        self.run(&unfinished.journal)?;
        self.datasets.iter().for_each(OpenedDataset::warn_of_points_left_out);
        Ok(())
    }

    fn write_files(
        &mut self,
        journal: &Journal,
        folder: &Path,
        mut record: ShardRecord,
    ) -> Result<Manifest, Failure> {
        let mut files = SweepFiles {
            swept: ChecksummedFile::begin(folder, SWEPT_SCANS_JSONL)?,
            timed: ChecksummedFile::begin(folder, TIMED_SCANS_JSONL)?,
            processors: Vec::new(),
        };
        let mut written = Ok(());
        let each = journal.each_entry(|it| {
            if written.is_ok() {
                written = files.add(it);
            }
        });
        each.map_err(|it: JournalError| Failure::from(it))?;
        written?;
        record.files = vec![files.swept.finish()?, files.timed.finish()?];
        record.processors = files.processors;
        // Programs of others have introduced themselves by now.
        Ok(SharedWork::manifest(self, Some(record)))
    }
}

/// The files of a shard of a sweep: what is in its journal, each kind by itself.
struct SweepFiles {
    swept: ChecksummedFile,
    timed: ChecksummedFile,
    processors: Vec<ProcessorRows>,
}

impl SweepFiles {
    fn add(&mut self, entry: JournalEntry) -> Result<(), ArchiveError> {
        match entry {
            JournalEntry::Quality(scan) => self.swept.write_json(&scan),
            JournalEntry::Times(scan) => {
                if self.processors.last().is_none_or(|it| it.cpu_model != scan.processor) {
                    let cpu_model = scan.processor.clone();
                    self.processors.push(ProcessorRows { cpu_model, n_scan_rows: 0 });
                }
                if let Some(last) = self.processors.last_mut() {
                    last.n_scan_rows += 1;
                }
                self.timed.write_json(&scan)
            }
        }
    }
}
