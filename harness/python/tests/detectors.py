"""Detectors that the tests start."""

from __future__ import annotations

import os
import sys
import time

import numpy as np
from numpy.typing import NDArray

import scanbench
from scanbench import Boxes, Cloud, Configuration, Detections

Points = NDArray[np.float32]
Labels = NDArray[np.int64]


@scanbench.detector(version="1.0")
def squares(points: Points, side_m: float = 2.0, min_z_m: float = -1.4) -> Labels:
    _, labels = np.unique(np.floor(points[:, :2] / side_m), axis=0, return_inverse=True)
    return np.where(points[:, 2] < min_z_m, -1, labels.ravel()).astype(np.int64)


@scanbench.detector
def by_ring(cloud: Cloud) -> Labels:
    assert cloud.ring is not None and cloud.time_offset_s is not None and cloud.intensity is None
    return cloud.ring.astype(np.int64)


@scanbench.detector(noise=0)
def labels_from_one(points: Points) -> Labels:
    return np.arange(len(points)) % 3


@scanbench.detector
def one_box(points: Points) -> Boxes:
    return Boxes.of([[10, 0, -1]], [[4, 2, 1.5]], 0.5, scores=[0.9], classes=["car"])


@scanbench.detector
def both(points: Points) -> tuple[Labels, Boxes]:
    labels = np.where(points[:, 0] > 0, 0, 1)
    return labels, Boxes.of([[5, 0, 0], [-5, 0, 0]], [1, 2, 3], classes=["car", None])


@scanbench.detector
def everything(points: Points) -> Detections:
    with scanbench.stage("ground"):
        ground = points[:, 2] < -1
    with scanbench.stage("clusters"):
        # Gaps in the labels, one point of no cluster.
        labels = np.where(points[:, 0] > 0, 3, 7)
        labels[0] = -5
    return Detections(labels=labels, scores=[0.5, -1.0], classes=[None, "tram"], products={"ground": ground})


@scanbench.detector
class Counting:
    """Keeps a state, and knows the sensor."""

    def __init__(self, configuration: Configuration, offset: int = 0) -> None:
        self.n_scans = offset + round(100 * (configuration.sensor_height_m or 0))

    def __call__(self, cloud: Cloud) -> Labels:
        self.n_scans += 1
        return np.full(len(cloud), self.n_scans)


@scanbench.detector
def takes(points: Points, how_many: int = 1, what: str = "x", really: bool = False, ratio: float = 1.0) -> Labels:
    return np.full(len(points), how_many)


def plain(points: Points) -> Labels:
    """Without a decorator."""
    return np.zeros(len(points), int)


@scanbench.detector
def wrong(points: Points, how: str) -> object:
    """What detectors do wrong."""
    n = len(points)
    match how:
        case "raises":
            raise RuntimeError("no more\nmemory")
        case "exits":
            sys.exit(3)
        case "none":
            return None
        case "floats":
            return np.zeros(n)
        case "short":
            return np.zeros(n - 1, int)
        case "rows":
            return np.zeros((n, 1), int)
        case "huge label":
            return np.full(n, 2**32 - 1)
        case "nan box":
            return Boxes([[np.nan, 0, 0, 1, 1, 1, 0]])
        case "flat box":
            return Boxes([[0, 0, 0, 1, 0, 1, 0]])
        case "long box":
            return Boxes([[0, 0, 0, 2000, 1, 1, 0]])
        case "far box":
            return Boxes([[20_000, 0, 0, 1, 1, 1, 0]])
        case "six numbers":
            return Boxes(np.zeros((2, 6)))
        case "nan score":
            return Boxes([[0, 0, 0, 1, 1, 1, 0]], scores=[np.nan])
        case "two scores":
            return Boxes([[0, 0, 0, 1, 1, 1, 0]], scores=[1, 2])
        case "class":
            return Boxes([[0, 0, 0, 1, 1, 1, 0]], classes=[7])  # type: ignore[list-item]
        case "too few boxes":
            return np.arange(n), Boxes([[0, 0, 0, 1, 1, 1, 0]])
        case "product":
            return Detections(products={"x": np.full(n, 300)})
        case "many boxes":
            return Boxes(np.tile([0, 0, 0, 1, 1, 1, 0], (100_001, 1)))
        case "many products":
            return Detections(products={str(number): np.zeros(n, int) for number in range(33)})
        case "name of a stage":
            with scanbench.stage("a\nb"):
                pass
        case "name of a product":
            return Detections(products={"": np.zeros(n, int)})
        case "long line":
            classes = ["street-furniture"] * 100_000
            return Boxes(np.tile([0, 0, 0, 1, 1, 1, 0], (100_000, 1)), classes=classes)
        case "silent":
            time.sleep(60)
        case "crashes":
            print("about to crash", flush=True)
            os.abort()
        case "closes":
            os.close(int(os.environ["SCANBENCH_WRITE_FD"]))
        case "prints":
            print('{"message":"result","number":0}')
            os.write(2, b"and to stderr\n")
            return np.zeros(n, int)
        case _:
            raise ValueError(how)
    return np.zeros(n, int)


@scanbench.detector(noise=0)
def below_zero(points: Points) -> Labels:
    return np.full(len(points), -1)


@scanbench.detector(earlier_scans="n_back", in_order=True)
class LookingBack:
    """Its boxes stand where the first points of this scan and of those before it are; they move as these do."""

    def __init__(self, n_back: int = 2) -> None:
        self.n_scans = 0

    def __call__(self, cloud: Cloud) -> Boxes:
        self.n_scans = 1 if cloud.begins_drive else self.n_scans + 1
        clouds = [cloud, *cloud.earlier]
        moved = np.array([[it.x_m[0] - cloud.x_m[0], 0] for it in clouds])
        moved /= np.array([[it.time_s - cloud.time_s or np.nan] for it in clouds])
        pose = np.eye(4) if cloud.world_from_sensor is None else cloud.world_from_sensor
        centers = [[it.x_m[0], self.n_scans, pose[0, 3]] for it in clouds]
        tracks = np.arange(len(clouds)) - 1
        return Boxes.of(
            centers, [1, 1, 1], velocities=np.where(np.isnan(moved).any(axis=1)[:, None], np.nan, moved), tracks=tracks
        )


if __name__ == "__main__":
    squares.serve()
