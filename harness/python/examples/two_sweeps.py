"""A detector that looks back: connected cells of a grid, and how fast they have moved since an earlier scan of the drive.

    [detector.two-sweeps]
    command = ["python3", "-m", "scanbench.serve", "two_sweeps.py:two_sweeps"]
    parameters = { n_back = 3 }

scanbench gives it the earlier scans in the frame of the newest one, so what has moved there has moved over ground.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import scanbench
from scanbench import Cloud, Configuration, Detections

Labels = NDArray[np.int64]


@scanbench.detector(earlier_scans="n_back")
def two_sweeps(
    cloud: Cloud,
    configuration: Configuration,
    n_back: int = 3,
    cell_m: float = 0.4,
    min_points: int = 15,
    fastest_m_per_s: float = 20.0,
) -> Detections:
    """Clusters of this scan, with velocities by the scan `n_back` before it."""
    road_m = -(configuration.sensor_height_m or 1.73)
    with scanbench.stage("clusters"):
        labels = connected_cells(cloud, road_m, cell_m, min_points)
    centers_m = centers(cloud, labels)
    velocities = np.full(centers_m.shape, np.nan)
    if len(cloud.earlier) == n_back > 0:
        with scanbench.stage("velocities"):
            then = cloud.earlier[-1]
            seconds = cloud.time_s - then.time_s
            then_m = centers(then, connected_cells(then, road_m, cell_m, min_points))
            velocities = displacements(then_m, centers_m, fastest_m_per_s * seconds) / seconds
    return Detections(labels=labels, velocities=velocities)


def connected_cells(cloud: Cloud, road_m: float, cell_m: float, min_points: int) -> Labels:
    """For each point the number of its cluster, -1 for none: cells with points from 0.3 to 2.5 m above the road that touch."""
    above_m = cloud.z_m - road_m
    (kept,) = np.nonzero((above_m > 0.3) & (above_m < 2.5))
    cells = np.floor(cloud.xyz_m[kept, :2] / cell_m).astype(np.int64)
    row = 1 << 20
    keys, cell_of_point = np.unique(cells[:, 0] * row + cells[:, 1], return_inverse=True)
    labels = np.full(len(cloud), -1, np.int64)
    if len(keys) == 0:
        return labels
    # Every cell takes the smallest number of its neighbours until none changes.
    number = np.arange(len(keys))
    pairs = [neighbours(keys, step) for step in (1, row - 1, row, row + 1)]
    first, second = np.concatenate(pairs, axis=1)
    while True:
        before = number.copy()
        np.minimum.at(number, first, before[second])
        np.minimum.at(number, second, before[first])
        number = number[number]
        if np.array_equal(number, before):
            break
    of_point = number[cell_of_point]
    _, of_point, n_points = np.unique(of_point, return_inverse=True, return_counts=True)
    renumbered = np.cumsum(n_points >= min_points) - 1
    labels[kept] = np.where(n_points[of_point] >= min_points, renumbered[of_point], -1)
    return labels


def neighbours(keys: NDArray[np.int64], step: int) -> NDArray[np.intp]:
    """Pairs of cells that are `step` apart, as 2 × m indices."""
    found = np.minimum(np.searchsorted(keys, keys + step), len(keys) - 1)
    (there,) = np.nonzero(keys[found] == keys + step)
    return np.stack([there, found[there]])


def centers(cloud: Cloud, labels: Labels) -> NDArray[np.float64]:
    """The middle of each cluster's extent along x and y."""
    n_clusters = int(labels.max(initial=-1)) + 1
    low, high = np.full((n_clusters, 2), np.inf), np.full((n_clusters, 2), -np.inf)
    (kept,) = np.nonzero(labels >= 0)
    np.minimum.at(low, labels[kept], cloud.xyz_m[kept, :2])
    np.maximum.at(high, labels[kept], cloud.xyz_m[kept, :2])
    middle: NDArray[np.float64] = (low + high) / 2.0
    return middle


def displacements(then_m: NDArray[np.float64], now_m: NDArray[np.float64], farthest_m: float) -> NDArray[np.float64]:
    """From the nearest cluster then to each cluster now, if each is the nearest of the other; NaN otherwise."""
    moved_m = np.full(now_m.shape, np.nan)
    if len(then_m) == 0 or len(now_m) == 0:
        return moved_m
    apart_m = np.linalg.norm(now_m[:, None] - then_m[None], axis=2)
    nearest = apart_m.argmin(axis=1)
    now = np.arange(len(now_m))
    is_pair = (apart_m.argmin(axis=0)[nearest] == now) & (apart_m[now, nearest] <= farthest_m)
    moved_m[is_pair] = (now_m - then_m[nearest])[is_pair]
    return moved_m
