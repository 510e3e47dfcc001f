//! The labelled region of a converted data set, point by point: a byte for every point of the scan.
//!
//! KITTI's own layouts can only state which camera looked at the street.

use std::path::Path;

use crate::annotation::{LabeledScan, PointRegion};
use crate::dataset::on_disk::{bytes_of, is_there};
use crate::dataset::positioned_points::values_of_kept;
use crate::dataset::{DatasetDescription, DatasetError};

/// The file for the scan `name`, relative to the split.
pub fn point_region_file(name: &str) -> String {
    format!("point_region/{name}.u8")
}

/// The content of a file with these regions.
pub fn region_bytes(regions: &[PointRegion]) -> Vec<u8> {
    regions.iter().map(|it| it.number()).collect()
}

/// The scan `name` with the regions in the file beside it.
pub fn with_regions_of_file(
    mut scan: LabeledScan,
    dataset: &DatasetDescription,
    name: &str,
) -> Result<LabeledScan, DatasetError> {
    let root = dataset.root.as_deref().expect("it was recorded");
    scan.point_regions = read_point_regions(&root.join(point_region_file(name)), &scan)?;
    Ok(scan)
}

/// The regions of the points of `scan`, from a file with one for each point of the scan's file; all is labelled if there is
/// no file.
fn read_point_regions(path: &Path, scan: &LabeledScan) -> Result<Vec<PointRegion>, DatasetError> {
    if !is_there(path) {
        return Ok(vec![PointRegion::Labeled; scan.cloud.len()]);
    }
    let bytes = bytes_of(path)?;
    let n_points = scan.cloud.len() + scan.points_left_out.len();
    if bytes.len() != n_points {
        return Err(DatasetError::label_count(path, bytes.len(), n_points));
    }
    let region = |byte: &u8| {
        let problem = || DatasetError::damaged(path, format!("has the byte {byte}; allowed are 0, 1 and 2"));
        PointRegion::of_number(*byte).ok_or_else(problem)
    };
    let regions: Vec<PointRegion> = bytes.iter().map(region).collect::<Result<_, _>>()?;
    Ok(values_of_kept(&regions, &scan.points_left_out))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::annotation::ScanId;

    #[test]
    fn regions_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("000000.u8");
        // The second point of the file has no position.
        let scan = |n_points: usize| LabeledScan {
            id: ScanId { sequence: "0".to_owned(), index: 0 },
            cloud: vec![[1.0, 2.0, 3.0]; n_points].into_iter().collect(),
            annotations: Vec::new(),
            point_regions: Vec::new(),
            labeled_area: crate::annotation::LabeledArea::AsPoints,
            points_left_out: vec![1],
        };
        assert_eq!(read_point_regions(&path, &scan(2)).unwrap(), [PointRegion::Labeled; 2]);
        let regions = [PointRegion::Outside, PointRegion::Labeled, PointRegion::Unscorable];
        std::fs::write(&path, region_bytes(&regions)).unwrap();
        assert_eq!(read_point_regions(&path, &scan(2)).unwrap(), [regions[0], regions[2]]);
        assert!(matches!(read_point_regions(&path, &scan(3)), Err(DatasetError::Damaged { .. })));
        std::fs::write(&path, [0, 3]).unwrap();
        assert!(matches!(read_point_regions(&path, &scan(1)), Err(DatasetError::Damaged { .. })));
    }
}
