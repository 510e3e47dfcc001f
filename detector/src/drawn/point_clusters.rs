//! Which cluster every point belongs to.

use crate::stage_product::Shape;

/// The cluster of every point of a scan of `n_points`: `clusters` are the indices of the points of each, in order.
///
/// A point of several clusters belongs to the last of them.
pub fn point_clusters<C: IntoIterator<Item = u32>>(
    n_points: usize,
    clusters: impl Iterator<Item = C>,
) -> Shape {
    let mut cluster_of_point = vec![None; n_points];
    for (cluster_idx, point_indices) in (0..).zip(clusters) {
        for point_idx in point_indices {
            cluster_of_point[point_idx as usize] = Some(cluster_idx);
        }
    }
    Shape::Clusters(cluster_of_point)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clusters_are_numbered_in_order_and_what_is_in_none_has_no_number() {
        let clusters = [vec![3, 1], Vec::new(), vec![0]];
        assert_eq!(
            point_clusters(5, clusters.into_iter()),
            Shape::Clusters(vec![Some(2), Some(0), None, Some(0), None])
        );
    }
}
