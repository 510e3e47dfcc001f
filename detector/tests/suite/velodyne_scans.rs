//! Real scans, which may not be copied into this project.

use std::path::{Path, PathBuf};

use detector::PointCloud;

/// The paths of the scans in `folder` of the shared data, in order; none where the folder is missing, which is said
/// together with the name of the test that skips it.
pub fn velodyne_paths(folder: &str, test: &str) -> Vec<PathBuf> {
    let data = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data"));
    let Ok(entries) = std::fs::read_dir(data.join(folder)) else {
        eprintln!("skipped {test}: no {folder}");
        return Vec::new();
    };
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
