"""What the detectors here have in common: clusters of what is not ground."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scanbench
from ground import Ground
from numpy.typing import NDArray
from scanbench import Detections

Labels = NDArray[np.integer]


def cluster_above_ground(
    points: NDArray[np.float32], ground: Ground, cluster: Callable[[NDArray[np.float32]], Labels]
) -> Detections:
    """`cluster` takes the m × 4 points that are not ground and returns a label for each, below 0 for none."""
    is_ground = ground.is_ground(points)
    labels = np.full(len(points), -1, np.int64)
    others = points[~is_ground]
    if len(others):
        with scanbench.stage("clusters"):
            labels[~is_ground] = cluster(others)
    products = {"ground": is_ground} if ground.method != "none" else {}
    return Detections(labels=labels, products=products)
