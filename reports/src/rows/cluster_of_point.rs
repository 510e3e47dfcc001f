//! The cluster of every point of a scan as a file, for other programs.

use std::fmt::Write as _;

/// Stands in binary files for points of no cluster.
pub const NO_CLUSTER: u32 = u32::MAX;

/// One row a point, in the order of the scan; the cluster is empty for points of none.
///
/// The number of the point is written as well, because a row with nothing but an empty cell is an empty line, which
/// readers of CSV skip.
pub fn to_csv(cluster_of_point: &[Option<u32>]) -> String {
    let mut text = "point,cluster\n".to_owned();
    for (point_idx, cluster) in cluster_of_point.iter().enumerate() {
        let cluster = cluster.map_or_else(String::new, |it| it.to_string());
        writeln!(text, "{point_idx},{cluster}").expect("a string takes all that is written");
    }
    text
}

/// Four bytes a point, little endian, in the order of the scan; [`NO_CLUSTER`] for points of none.
pub fn to_u32_le(cluster_of_point: &[Option<u32>]) -> Vec<u8> {
    cluster_of_point.iter().flat_map(|cluster| cluster.unwrap_or(NO_CLUSTER).to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLUSTERS: [Option<u32>; 3] = [Some(258), None, Some(0)];

    #[test]
    fn rows_are_numbered_and_empty_where_there_is_no_cluster() {
        assert_eq!(to_csv(&CLUSTERS), "point,cluster\n0,258\n1,\n2,0\n");
    }

    #[test]
    fn bytes_are_little_endian_and_ones_where_there_is_no_cluster() {
        assert_eq!(to_u32_le(&CLUSTERS), [2, 1, 0, 0, 255, 255, 255, 255, 0, 0, 0, 0]);
    }
}
