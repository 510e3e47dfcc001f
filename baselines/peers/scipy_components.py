"""Connected components of occupied voxels, by SciPy."""

from __future__ import annotations

from itertools import product

import numpy as np
import scanbench
import scipy
from above_ground import cluster_above_ground
from ground import Ground
from numpy.typing import NDArray
from scanbench import Configuration, Detections
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


@scanbench.detector(name="scipy-components", version=scipy.__version__)
class ScipyComponents:
    """`scipy.sparse.csgraph.connected_components` of voxels that share a face, an edge or a corner; those of fewer than `min_points` points are
    no clusters."""

    def __init__(
        self,
        configuration: Configuration,
        voxel_m: float = 0.3,
        min_points: int = 10,
        ground: str = "patchworkpp",
        adapt_ground: bool = False,
    ) -> None:
        self.voxel_m = voxel_m
        self.min_points = min_points
        self.ground = Ground(ground, adapt_ground, configuration)

    def __call__(self, points: NDArray[np.float32]) -> Detections:
        return cluster_above_ground(points, self.ground, self.cluster)

    def cluster(self, points: NDArray[np.float32]) -> NDArray[np.integer]:
        indices = np.floor(points[:, :3].astype(np.float64) / self.voxel_m).astype(np.int64)
        # One empty voxel on each side: no neighbour is one of the next row.
        indices -= indices.min(axis=0) - 1
        _, n_rows, n_levels = indices.max(axis=0) + 2
        steps = np.array([n_rows * n_levels, n_levels, 1])
        voxels, voxel_of_point = np.unique(indices @ steps, return_inverse=True)
        ends = [self._neighbours(voxels, int(np.dot(step, steps))) for step in product((-1, 0, 1), repeat=3) if step > (0, 0, 0)]
        rows, columns = np.concatenate(ends, axis=1)
        graph = coo_array((np.ones(len(rows), np.bool_), (rows, columns)), shape=(len(voxels), len(voxels)))
        _, component_of_voxel = connected_components(graph, directed=False)
        labels = component_of_voxel[voxel_of_point]
        return np.where(np.bincount(labels)[labels] < self.min_points, -1, labels)

    @staticmethod
    def _neighbours(voxels: NDArray[np.int64], step: int) -> NDArray[np.intp]:
        found = np.minimum(np.searchsorted(voxels, voxels + step), len(voxels) - 1)
        (first,) = np.nonzero(voxels[found] == voxels + step)
        return np.stack([first, found[first]])
