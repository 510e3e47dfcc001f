"""scikit-learn's HDBSCAN."""

from __future__ import annotations

import numpy as np
import scanbench
import sklearn
from above_ground import cluster_above_ground
from ground import Ground
from numpy.typing import NDArray
from scanbench import Configuration, Detections
from sklearn.cluster import HDBSCAN


@scanbench.detector(name="sklearn-hdbscan", version=sklearn.__version__)
class SklearnHdbscan:
    """`sklearn.cluster.HDBSCAN`; the defaults are the library's. Fewer than `min_cluster_size` points are no cluster."""

    def __init__(
        self,
        configuration: Configuration,
        min_cluster_size: int = 5,
        cluster_selection_epsilon: float = 0.0,
        ground: str = "patchworkpp",
        adapt_ground: bool = False,
    ) -> None:
        self.model = HDBSCAN(
            min_cluster_size=min_cluster_size,
            cluster_selection_epsilon=cluster_selection_epsilon,
            n_jobs=configuration.threads,
            copy=True,
        )
        self.ground = Ground(ground, adapt_ground, configuration)

    def __call__(self, points: NDArray[np.float32]) -> Detections:
        return cluster_above_ground(points, self.ground, self.cluster)

    def cluster(self, points: NDArray[np.float32]) -> NDArray[np.integer]:
        if len(points) < self.model.min_cluster_size:
            return np.full(len(points), -1)
        return self.model.fit(points[:, :3]).labels_
