//! The cluster of every point of a scan as a file, for other programs: 0 is no cluster, the first cluster is 1, as in the
//! protocol for detectors.

use std::fmt::Write as _;

/// Number in files for points of no cluster.
pub const NO_CLUSTER: u32 = 0;

/// Number in files of the cluster at this index, from 0, among those of its scan.
pub fn number_in_files(cluster: Option<u32>) -> u32 {
    cluster.map_or(NO_CLUSTER, |index| index + 1)
}

/// One row a point, in the order of the scan: its index, from 0, and its [`number_in_files`].
pub fn to_csv(cluster_of_point: &[Option<u32>]) -> String {
    let mut text = "point,cluster\n".to_owned();
    for (point_idx, cluster) in cluster_of_point.iter().enumerate() {
        writeln!(text, "{point_idx},{}", number_in_files(*cluster))
            .expect("a string takes all that is written");
    }
    text
}

/// Four bytes a point, little endian, in the order of the scan: its [`number_in_files`].
pub fn to_u32_le(cluster_of_point: &[Option<u32>]) -> Vec<u8> {
    cluster_of_point.iter().flat_map(|cluster| number_in_files(*cluster).to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLUSTERS: [Option<u32>; 3] = [Some(257), None, Some(0)];

    #[test]
    fn rows_are_numbered_and_zero_where_there_is_no_cluster() {
        assert_eq!(to_csv(&CLUSTERS), "point,cluster\n0,258\n1,0\n2,1\n");
    }

    #[test]
    fn bytes_are_little_endian_and_zero_where_there_is_no_cluster() {
        assert_eq!(to_u32_le(&CLUSTERS), [2, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
    }
}
