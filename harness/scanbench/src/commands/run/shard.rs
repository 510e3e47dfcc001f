//! `scanbench run --shard`: a part of a run.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use jiff::Timestamp;
use reports::run_folder::manifest::Manifest;
use reports::vocabulary::shard::Shard;
use reports::vocabulary::study::Study;
use serde_json::Value;

use crate::cli::RunArgs;
use crate::commands::failure::{Failure, Usage};
use crate::commands::open_datasets::OpenedDataset;
use crate::commands::progress::RunProgress;
use crate::commands::recorder::Recorder;
use crate::commands::run::setup::{ChosenRun, OpenedRun};
use crate::commands::shards::unfinished_shard::ShardPlan;
use crate::commands::shards::watched_shard::{ShardedRun, make_watched_shard};
use crate::commands::watched_run::{WatchedRun, WithoutLabels};

/// Runs `shard`, and leaves its rows in a directory of its own for `merge`.
pub fn run_shard(arguments: &RunArgs, shard: Shard) -> Result<(), Failure> {
    refuse_what_is_for_whole_runs(arguments)?;
    let chosen = ChosenRun::of(arguments)?;
    let plan = ShardPlan::claim(Study::Run, shard, &arguments.output)?;
    let (opened, started) = (chosen.open(arguments)?, plan.started);
    make_watched_shard(plan, &mut RunInShards { arguments, opened, started })
}

/// Options that shards would have to share, or that have no end.
fn refuse_what_is_for_whole_runs(arguments: &RunArgs) -> Result<(), Usage> {
    let stream = &arguments.stream;
    if matches!(stream.save_rrd, Some(Some(_))) {
        return Err(Usage(
            "all shards would write the same file of --save-rrd; leave out its name".to_owned(),
        ));
    }
    if stream.serve.is_some() {
        return Err(Usage("a shard ends, and nobody is served by it: leave out --serve".to_owned()));
    }
    Ok(())
}

struct RunInShards<'a> {
    arguments: &'a RunArgs,
    opened: OpenedRun,
    started: Timestamp,
}

impl ShardedRun for RunInShards<'_> {
    fn datasets(&self) -> &[OpenedDataset] {
        &self.opened.datasets
    }

    fn datasets_mut(&mut self) -> &mut [OpenedDataset] {
        &mut self.opened.datasets
    }

    fn manifest(&self) -> Manifest {
        self.opened.manifest(self.arguments, self.started)
    }

    fn rules(&self) -> Value {
        serde_json::json!({
            "on_detector_failure": format!("{:?}", self.arguments.on_detector_failure),
            "skip_damaged": self.arguments.damage.skip_damaged,
            "rerun_every": self.arguments.stream.rerun_every,
        })
    }

    fn watched<'a>(
        &'a self,
        without_labels: WithoutLabels,
        watching: (&'a AtomicBool, &'a RunProgress),
    ) -> WatchedRun<'a> {
        self.opened.watched(self.arguments, without_labels, watching)
    }

    fn begin_recording(&self, name: &str, file: PathBuf) -> Result<Option<(Recorder, u64)>, Failure> {
        let n_left = self.opened.datasets.iter().map(|it| it.part.len()).sum();
        let every = u64::from(self.arguments.stream.every(n_left));
        let recorder = self.opened.begin_recording(self.arguments, name, file)?;
        Ok(recorder.map(|it| (it, every)))
    }
}
