//! The files of `scanbench detect` for every scan: `DRIVE/NNNNNN.u32` with the cluster of each point, `DRIVE/NNNNNN.csv`
//! with the boxes, behind them those of unlikely vehicles.

use detector::DetectorOutput;
use reports::files::archive::ArchiveError;
use reports::files::csv_rows::to_csv_bytes;
use reports::rows::cluster_of_point;

use super::detection_rows::{box_rows, clusters_of_points};
use super::{CompleteFiles, ResultFile, ResultWriter, ranked};
use crate::annotation::LabeledScan;
use crate::dataset::folder_name::folder_name;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::positioned_points::values_of_file;

/// Files for each scan.
pub struct OwnResults;

impl ResultWriter for OwnResults {
    fn add(&mut self, scan: &LabeledScan, _frame: &ForeignFrame, output: &DetectorOutput) -> CompleteFiles {
        let detections = &output.detections;
        let name = |ending: &str| format!("{}/{:06}.{ending}", folder_name(&scan.id.sequence), scan.id.index);
        // A value for every point of the file; points without a position belong to no cluster.
        let clusters = clusters_of_points(detections, scan.cloud.len());
        let clusters = values_of_file(&clusters, &scan.points_left_out).into_iter().map(Option::flatten);
        let clusters: Vec<Option<u32>> = clusters.collect();
        let boxes = to_csv_bytes(&box_rows(ranked(output)))
            .map_err(|source| ArchiveError::Csv { path: name("csv").into(), source })?;
        let mut files = vec![ResultFile { name: name("csv"), content: boxes }];
        // A point has one number: detections that share points are written as boxes alone.
        let n_points: usize = detections.iter().map(|it| it.point_indices.len()).sum();
        if n_points == clusters.iter().flatten().count() {
            files.push(ResultFile { name: name("u32"), content: cluster_of_point::to_u32_le(&clusters) });
        }
        Ok(files)
    }

    fn finish(self: Box<Self>) -> CompleteFiles {
        Ok(Vec::new())
    }
}
