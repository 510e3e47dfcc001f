//! The manifest of a run or a study that was put together.

use std::path::{Component, Path, PathBuf};

use reports::run_folder::command_line::command_of_whole_run;
use reports::run_folder::manifest::{Manifest, SkippedScan};
use reports::run_folder::shard_record::processors_of;

/// Whether something was made in one piece, or in several.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pieces {
    /// By one program, though it may have been interrupted.
    One,
    /// In shards, which are kept.
    Shards,
}

/// The manifest of the whole, which is left in `target`, with the list of shards. `shards` are their manifests in order.
pub fn merged_manifest(shards: &[&Manifest], target: &Path, pieces: Pieces) -> Manifest {
    let manifests = || shards.iter().copied();
    let mut whole = shards[0].clone();
    whole.shard = None;
    whole.shards = manifests().filter_map(|it| it.shard.clone()).collect();
    whole.created = manifests().map(|it| it.created.clone()).min().unwrap_or_default();
    if pieces == Pieces::Shards {
        whole.argv = command_of_whole_run(&whole.argv, &target.display().to_string());
    }
    let processors = processors_of(&whole.shards);
    if !processors.is_empty() {
        whole.machine.cpu_model = processors.join("; ");
    }
    for (dataset_idx, entry) in whole.datasets.iter_mut().enumerate() {
        let entries = || manifests().map(|it| &it.datasets[dataset_idx]);
        entry.n_points_left_out = entries().map(|it| it.n_points_left_out).sum();
        let mut skipped: Vec<SkippedScan> = Vec::new();
        for scan in entries().flat_map(|it| &it.skipped_scans) {
            // Every shard that opens a data set leaves out the same end of it.
            if !skipped.contains(scan) {
                skipped.push(scan.clone());
            }
        }
        entry.skipped_scans = skipped;
    }
    for (detector_idx, entry) in whole.detectors.iter_mut().enumerate() {
        // A program that had no scan to look at did not introduce itself.
        let introduced = manifests().map(|it| &it.detectors[detector_idx]);
        let introduced =
            { introduced }.find(|it| it.foreign.as_ref().is_some_and(|it| it.reported_name.is_some()));
        if let Some(introduced) = introduced {
            entry.clone_from(introduced);
        }
        let mut doubts: Vec<String> = Vec::new();
        for doubt in manifests().flat_map(|it| &it.detectors[detector_idx].doubts) {
            if !doubts.contains(doubt) {
                doubts.push(doubt.clone());
            }
        }
        entry.doubts = doubts;
    }
    whole
}

/// The path from within `folder`, which need not be there yet, to `file`.
pub fn path_from(folder: &Path, file: &Path) -> String {
    let absolute = |it: &Path| std::path::absolute(it).unwrap_or_else(|_| it.to_owned());
    let (folder, file) = (absolute(folder), absolute(file));
    let n_common = folder.components().zip(file.components()).take_while(|(one, other)| one == other).count();
    let up = folder.components().skip(n_common).map(|_| Component::ParentDir);
    let path: PathBuf = up.chain(file.components().skip(n_common)).collect();
    path.to_string_lossy().into_owned()
}
