//! Where the result of a verb goes, and which part of it is made.

use std::path::Path;

use jiff::Timestamp;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::run_target::{ClaimedTarget, LatestPointer, MANIFEST_JSON};
use reports::run_folder::shard_record::ShardRecord;
use reports::vocabulary::shard::Shard;
use reports::vocabulary::study::Study;

use super::share_of_work::ShareOfWork;
use crate::cli::{OutputArgs, StreamArgs};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::provenance::{compact_utc, program_checksum, program_stamp, rfc3339_utc};
use crate::plumbing::run_directory::{claim_named, claim_unnamed};

/// Where the result of a verb goes, and which part of it is made.
pub struct WorkOutput {
    /// The verb.
    pub study: Study,
    /// Shard that is made; `None` for all in one piece.
    pub shard: Option<Shard>,
    /// Whether earlier work there is thrown away.
    pub overwrites: bool,
    pub started: Timestamp,
    /// Whether finished work is kept until there is a result: if the directory is named, and for sweeps, which take long.
    pub is_kept: bool,
    /// Whether the directory was named.
    pub is_named: bool,
    // The directory that was named; for a shard, its folder within that of all shards.
    named: Option<ClaimedTarget>,
}

impl WorkOutput {
    /// Takes the directory that `output` names: of a shard its own, in the folder of all shards.
    pub fn claim(study: Study, shard: Option<Shard>, output: &OutputArgs) -> Result<Self, Failure> {
        let named = match shard {
            Some(shard) => Some(claim_for_shard(shard, output)?),
            None => claim_named(output)?,
        };
        let (overwrites, is_named) = (output.overwrite, named.is_some());
        let is_kept = is_named || study == Study::Sweep;
        Ok(Self { study, shard, overwrites, started: Timestamp::now(), is_kept, is_named, named })
    }

    /// The directory: the one that was named, or else a new one that is called after the data sets `ids`.
    pub fn target(&mut self, ids: &str) -> Result<ClaimedTarget, Failure> {
        let (name, latest) = unnamed(self.study, ids, self.started);
        Ok(claim_unnamed(self.named.take(), &name, latest)?)
    }

    /// Record of a shard in the manifest before it has done anything; all in one piece is the only shard.
    pub fn record(&self, share: ShareOfWork) -> ShardRecord {
        let shard = self.shard.unwrap_or(Shard::ONLY);
        ShardRecord {
            index: shard.index(),
            count: shard.count(),
            created: rfc3339_utc(self.started),
            study: self.study,
            // Copies of the program make shards; work in one piece is continued by the same file.
            program: if self.shard.is_some() { program_checksum() } else { program_stamp() },
            cut_by: share.cut_by,
            parts: share.parts,
            processors: Vec::new(),
            log: None,
            recordings: Vec::new(),
        }
    }
}

/// Refuses options that shards would have to share, or that have no end. Without `shard`, nothing is refused.
pub fn refuse_what_is_for_whole_runs(shard: Option<Shard>, stream: &StreamArgs) -> Result<(), Usage> {
    let problem = match (shard, stream) {
        (Some(_), StreamArgs { save_rrd: Some(Some(_)), .. }) => {
            "all shards would write the same file of --save-rrd; leave out its name"
        }
        (Some(_), StreamArgs { serve: Some(_), .. }) => {
            "a shard ends, and nobody is served by it: leave out --serve"
        }
        _ => return Ok(()),
    };
    Err(Usage(problem.to_owned()))
}

fn claim_for_shard(shard: Shard, output: &OutputArgs) -> Result<ClaimedTarget, Failure> {
    let of_shard = OutputArgs {
        output: output.output.as_ref().map(|it| it.join(shard.folder_name())),
        overwrite: output.overwrite,
    };
    let finished = of_shard.output.as_deref().filter(|_| !output.overwrite);
    if let Some((folder, record)) = finished.and_then(|it| Some((it, finished_shard(it)?))) {
        return Err(Usage(format!(
            "{} is there: shard {shard} of `{}`, finished, begun at {}; merge it, or make it again with --overwrite",
            folder.display(),
            record.study.name(),
            record.created
        ))
        .into());
    }
    let no_folder = || Usage("--shard needs -o, the folder of all shards".to_owned());
    Ok(claim_named(&of_shard)?.ok_or_else(no_folder)?)
}

/// The name of a directory if the user gave none, and whether `latest` points at it.
pub fn unnamed(study: Study, ids: &str, started: Timestamp) -> (String, LatestPointer) {
    let (verb, now) = (study.name(), compact_utc(started));
    match study {
        Study::Run => (format!("{now}-{ids}"), LatestPointer::Update),
        _ if study.is_called_after_data() => (format!("{now}-{verb}-{ids}"), LatestPointer::Leave),
        _ => (format!("{now}-{verb}"), LatestPointer::Leave),
    }
}

/// The record of the shard in `directory`; `None` if there is none that can be read.
pub fn finished_shard(directory: &Path) -> Option<ShardRecord> {
    Manifest::read(&directory.join(MANIFEST_JSON)).ok()?.shard
}
