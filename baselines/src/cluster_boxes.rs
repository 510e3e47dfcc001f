//! Objects with boxes made of clusters of foreground points.

use detector::detector::{DetectorOutput, DropReason, DroppedCluster};
use detector::drawn::fitted_boxes::fitted_boxes;
use detector::drawn::point_clusters::point_clusters;
use detector::pipeline::frame::{Frame, PointClusters};
use detector::pipeline::stage_list::Stage;
use detector::{OrientedBox, PointCloud, StageProduct};

use crate::COMPONENTS;

/// How the box around a cluster is fitted, and which clusters are objects.
pub trait ClusterFit: Send {
    /// The box around the points of a cluster, in the sensor frame.
    ///
    /// # Errors
    ///
    /// The reason why the cluster is no object.
    fn fit(&mut self, positions_m: &[[f32; 3]]) -> Result<OrientedBox, DropReason>;

    /// The hull on the ground plan that the latest box was fitted to, in metres; `None` if boxes are not fitted to hulls.
    fn hull_m(&self) -> Option<&[[f32; 2]]>;
}

/// Fits boxes to the clusters of a frame, and drops those that are no objects.
pub struct ClusterBoxes<F> {
    fit: F,
    kept: Vec<usize>,
    dropped: Vec<usize>,
    positions_m: Vec<[f32; 3]>,
}

impl<F> ClusterBoxes<F> {
    /// Fits boxes by `fit`.
    pub fn new(fit: F) -> Self {
        Self { fit, kept: Vec::new(), dropped: Vec::new(), positions_m: Vec::new() }
    }
}

impl<F: ClusterFit> Stage<PointClusters> for ClusterBoxes<F> {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<PointClusters>, output: &mut DetectorOutput) {
        let Self { fit, kept, dropped, positions_m } = self;
        let Frame { clustering: PointClusters { foreground, clusters }, fitted, .. } = frame;
        kept.clear();
        dropped.clear();
        fitted.clear();
        for (cluster_idx, members) in clusters.iter().enumerate() {
            let point_indices = members.iter().map(|&index| foreground.point_indices()[index as usize]);
            positions_m.clear();
            positions_m.extend(point_indices.clone().map(|point_idx| cloud.position_m(point_idx as usize)));
            match fit.fit(positions_m) {
                Ok(bounding_box) => {
                    let points = point_indices.zip(positions_m.iter().copied());
                    fitted.add(points, bounding_box, fit.hull_m().unwrap_or_default());
                    kept.push(cluster_idx);
                }
                Err(reason) => {
                    output.dropped_clusters.push(DroppedCluster { n_points: members.len(), reason });
                    dropped.push(cluster_idx);
                }
            }
        }
    }

    fn products(&self, cloud: &PointCloud, frame: &Frame<PointClusters>) -> Vec<StageProduct> {
        let PointClusters { foreground, clusters } = &frame.clustering;
        let point_indices = foreground.point_indices();
        let product = |name, asked: &[usize]| {
            let members = asked.iter().map(|&cluster_idx| clusters.members(cluster_idx));
            let points = members.map(|it| it.iter().map(|&index| point_indices[index as usize]));
            StageProduct { stage: COMPONENTS, name, shape: point_clusters(cloud.len(), points) }
        };
        let mut products = vec![product("dropped_clusters", &self.dropped), product("clusters", &self.kept)];
        let has_hulls = self.fit.hull_m().is_some();
        products.extend(fitted_boxes(&frame.fitted).into_iter().filter(|it| has_hulls || it.name != "hulls"));
        products
    }
}
