//! Parts that only some runs have: numbers under protocols of others, and scans without labels.

use std::path::Path;

use super::gathered_run::GatheredRun;
use crate::files::archive::ArchiveError;
use crate::files::csv_rows::{each_row, read_rows};
use crate::protocols::protocol_report::ProtocolReport;
use crate::rows::agreement_row::AgreementRow;
use crate::rows::kitti_object_row::KittiObjectRow;
use crate::rows::ranked_box_row::RankedBoxRow;
use crate::run_folder::manifest::Manifest;
use crate::run_folder::run_directory::{AGREEMENT_CSV, KITTI_OBJECT_CSV, PROTOCOL_BOXES_CSV, PROTOCOLS_JSON};
use crate::verdicts::task_ranking::TaskRanking;
use crate::vocabulary::protocol::ProtocolFamily;

/// Numbers under protocols of others; `None` where there are none.
pub(super) fn protocols_of(
    directory: &Path,
    manifest: &Manifest,
) -> Result<Option<ProtocolReport>, ArchiveError> {
    let is_evaluated = !manifest.protocols.is_empty();
    is_evaluated.then(|| ProtocolReport::read(&directory.join(PROTOCOLS_JSON))).transpose()
}

/// Adds the rows of protocols that have classes to `gathered`.
pub(super) fn read_given_classes(
    directory: &Path,
    manifest: &Manifest,
    gathered: &mut GatheredRun,
) -> Result<(), ArchiveError> {
    let has = |family| manifest.protocols.iter().any(|it| it.family() == family);
    if has(ProtocolFamily::RankedBoxes) {
        each_row(&directory.join(PROTOCOL_BOXES_CSV), |row: RankedBoxRow| gathered.add_ranked_box(&row))?;
    }
    if has(ProtocolFamily::KittiObjects) {
        each_row(&directory.join(KITTI_OBJECT_CSV), |row: KittiObjectRow| gathered.add_kitti_object(&row))?;
    }
    Ok(())
}

/// How far detectors agree on data sets without labels; empty if all have labels.
pub(super) fn agreement_of(directory: &Path) -> Result<Vec<AgreementRow>, ArchiveError> {
    let path = directory.join(AGREEMENT_CSV);
    if path.exists() { read_rows(&path) } else { Ok(Vec::new()) }
}

/// The rankings on data sets that have labels.
pub(super) fn scored(mut rankings: Vec<TaskRanking>, agreement: &[AgreementRow]) -> Vec<TaskRanking> {
    let is_compared = |it: &String| agreement.iter().any(|row| row.dataset == *it);
    rankings.retain(|it| !it.pool.datasets.iter().all(is_compared));
    rankings
}
