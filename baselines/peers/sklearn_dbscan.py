"""scikit-learn's DBSCAN."""

from __future__ import annotations

import numpy as np
import scanbench
import sklearn
from above_ground import cluster_above_ground
from ground import Ground
from numpy.typing import NDArray
from scanbench import Configuration, Detections
from sklearn.cluster import DBSCAN


@scanbench.detector(name="sklearn-dbscan", version=sklearn.__version__)
class SklearnDbscan:
    """`sklearn.cluster.DBSCAN`; the defaults are the library's."""

    def __init__(
        self,
        configuration: Configuration,
        eps: float = 0.5,
        min_samples: int = 5,
        ground: str = "patchworkpp",
        adapt_ground: bool = False,
    ) -> None:
        self.model = DBSCAN(eps=eps, min_samples=min_samples, n_jobs=configuration.threads)
        self.ground = Ground(ground, adapt_ground, configuration)

    def __call__(self, points: NDArray[np.float32]) -> Detections:
        return cluster_above_ground(points, self.ground, lambda others: self.model.fit(others[:, :3]).labels_)
