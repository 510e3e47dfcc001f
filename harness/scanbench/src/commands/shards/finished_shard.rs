//! Whether a directory is a shard.

use std::path::Path;

use reports::run_folder::manifest::Manifest;
use reports::run_folder::partial_manifest::PartialManifest;
use reports::run_folder::run_target::MANIFEST_JSON;
use reports::run_folder::shard_record::ShardRecord;

/// What the shard in `directory` says of itself; `None` if there is none that can be read.
pub fn finished_shard(directory: &Path) -> Option<ShardRecord> {
    let path = directory.join(MANIFEST_JSON);
    let of_run = Manifest::read(&path).ok().and_then(|it| it.shard);
    of_run.or_else(|| PartialManifest::read(&path).ok()?.shard)
}
