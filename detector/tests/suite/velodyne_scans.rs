//! Real scans.

use std::path::{Path, PathBuf};

use detector::PointCloud;

/// The paths of the scans in `folder`, in order.
pub fn velodyne_paths(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder of scans");
    let mut paths: Vec<_> = entries.map(|it| it.expect("an entry").path()).collect();
    paths.sort();
    paths
}

/// The points of a KITTI scan.
pub fn read_velodyne_bin(path: &Path) -> PointCloud {
    let bytes = std::fs::read(path).expect("a scan");
    let mut cloud = PointCloud::default();
    for point in bytes.as_chunks::<16>().0 {
        let (values, _) = point.as_chunks::<4>();
        let [x_m, y_m, z_m, intensity] = std::array::from_fn(|column| f32::from_le_bytes(values[column]));
        cloud.push([x_m, y_m, z_m], intensity);
    }
    cloud
}
