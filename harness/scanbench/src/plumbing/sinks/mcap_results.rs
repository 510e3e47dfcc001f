//! `run.mcap` for Foxglove.

use std::path::Path;

use evaluation::results_mcap::writer::ResultsMcap;
use evaluation::run::sink::{JudgedScan, RunSink, WatchedDataset};
use scans::dataset::folder_name::folder_name;

use crate::plumbing::failure::Failure;

/// Records each data set by itself, as each has times and a sensor of its own.
pub struct McapResults<'a> {
    folder: &'a Path,
    n_datasets: usize,
    // Of the data set at hand.
    recording: Option<ResultsMcap>,
}

impl<'a> McapResults<'a> {
    /// Begins without a recording; those of `n_datasets` data sets will be in `folder`.
    pub fn new(folder: &'a Path, n_datasets: usize) -> Self {
        Self { folder, n_datasets, recording: None }
    }
}

impl RunSink<Failure> for McapResults<'_> {
    fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), Failure> {
        let name = match self.n_datasets {
            1 => "run.mcap".to_owned(),
            _ => format!("run-{}.mcap", folder_name(&watched.dataset.description().id)),
        };
        let path = self.folder.join(&name);
        self.recording = Some(ResultsMcap::create(&path, watched.dataset, watched.scan_indices)?);
        Ok(())
    }

    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        Ok(self.recording.as_mut().map_or(Ok(()), |it| it.add(judged))?)
    }

    fn end_dataset(&mut self) -> Result<(), Failure> {
        Ok(self.recording.take().map_or(Ok(()), ResultsMcap::finish)?)
    }
}
