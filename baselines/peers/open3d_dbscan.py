"""Open3D's DBSCAN."""

from __future__ import annotations

import numpy as np
import open3d
import scanbench
from above_ground import cluster_above_ground
from ground import Ground
from numpy.typing import NDArray
from scanbench import Configuration, Detections


@scanbench.detector(name="open3d-dbscan", version=open3d.__version__)
class Open3dDbscan:
    """`PointCloud.cluster_dbscan`."""

    def __init__(
        self,
        configuration: Configuration,
        eps: float = 0.5,
        min_points: int = 10,
        ground: str = "patchworkpp",
        adapt_ground: bool = False,
    ) -> None:
        self.eps = eps
        self.min_points = min_points
        self.ground = Ground(ground, adapt_ground, configuration)

    def __call__(self, points: NDArray[np.float32]) -> Detections:
        return cluster_above_ground(points, self.ground, self.cluster)

    def cluster(self, points: NDArray[np.float32]) -> NDArray[np.integer]:
        cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points[:, :3].astype(np.float64)))
        return np.asarray(cloud.cluster_dbscan(self.eps, self.min_points))
