"""A scan with its ground truth, as everything here sees it: sensor frame, x forward, y left, z up, metres."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class Region(IntEnum):
    """Whether the labels say anything about a point."""

    LABELLED = 0
    UNSCORABLE = 1
    OUTSIDE = 2


@dataclass(frozen=True)
class Box:
    """An upright box; length lies along the heading."""

    center_m: tuple[float, float, float]
    length_m: float
    width_m: float
    height_m: float
    yaw_rad: float

    @property
    def volume_m3(self) -> float:
        return self.length_m * self.width_m * self.height_m

    @property
    def top_m(self) -> float:
        return self.center_m[2] + self.height_m / 2

    @property
    def bottom_m(self) -> float:
        return self.center_m[2] - self.height_m / 2

    def is_near(self, other: "Box", tolerance: float) -> bool:
        """Whether two boxes are the same but for so many metres or radians of each value."""
        ours = (*self.center_m, self.length_m, self.width_m, self.height_m)
        theirs = (*other.center_m, other.length_m, other.width_m, other.height_m)
        turned_rad = math.remainder(self.yaw_rad - other.yaw_rad, 2 * math.pi)
        return abs(turned_rad) < tolerance and all(abs(a - b) < tolerance for a, b in zip(ours, theirs))

    def along_across_m(self, points_m: Floats) -> tuple[Floats, Floats]:
        """Where points are on the ground plan, from the centre along the length and along the width."""
        dx, dy = points_m[:, 0] - self.center_m[0], points_m[:, 1] - self.center_m[1]
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return cos * dx + sin * dy, cos * dy - sin * dx

    def outside_m(self, points_m: Floats) -> Floats:
        """How far each point is beyond the nearest face; below 0 inside."""
        along, across = self.along_across_m(points_m)
        up = points_m[:, 2] - self.center_m[2]
        beyond = [np.abs(along) - self.length_m / 2, np.abs(across) - self.width_m / 2, np.abs(up) - self.height_m / 2]
        return np.max(beyond, axis=0)


@dataclass(frozen=True)
class Annotation:
    """A labelled object."""

    class_name: str
    box: Box | None
    point_indices: Indices
    track: int | None

    @property
    def n_points(self) -> int:
        return len(self.point_indices)


@dataclass(frozen=True)
class LabelledScan:
    """Points, objects, and for every point its region."""

    points_m: Floats
    annotations: list[Annotation]
    regions: NDArray[np.uint8]
    slack: float

    @cached_property
    def range_m(self) -> Floats:
        """Distance of every point from the sensor on the ground plan."""
        return np.hypot(self.points_m[:, 0], self.points_m[:, 1])

    def center_m(self, annotation: Annotation) -> Floats:
        """Where an object stands: the centre of its box, else of its points; the sensor if it has neither."""
        if annotation.box is not None:
            return np.array(annotation.box.center_m)
        return self.points_m[annotation.point_indices].mean(axis=0) if annotation.n_points > 0 else np.zeros(3)

    def n_points_in(self, annotation: Annotation, region: Region) -> int:
        return int(np.count_nonzero(self.regions[annotation.point_indices] == region))


# A scan as it is if every edge that decides something (face of a box, rim of the image, cell, range) is moved out by so many
# metres or pixels. Programs round differently; what comes out alike if all edges move a little cannot depend on that.
ScanWithSlack = Callable[[float], LabelledScan]


@dataclass(frozen=True)
class Dataset:
    """What a data set says of itself, and how to read its scans by drive and number."""

    root: str
    annotates_everything: bool
    annotates_vehicles: bool
    read: Callable[[str, int], ScanWithSlack]


def read_bin(path: Path) -> Floats:
    """The positions in a Velodyne `.bin` file: x, y, z and intensity, little-endian f32."""
    # Column by column, as they are asked for.
    return np.asfortranarray(np.fromfile(path, "<f4").reshape(-1, 4)[:, :3].astype(np.float64))


def indices_around(points_m: Floats, box: Box, margin_m: float) -> Indices:
    """All points on the ground plan within `margin_m` of the box, and some more."""
    reach_m = 0.5 * math.hypot(box.length_m, box.width_m) + margin_m
    x, y, _ = box.center_m
    return np.flatnonzero((np.abs(points_m[:, 0] - x) <= reach_m) & (np.abs(points_m[:, 1] - y) <= reach_m))


@dataclass(frozen=True)
class PointsNearBoxes:
    """For every box the points around it, and how far each is beyond the nearest face."""

    n_points: int
    boxes: list[Box]
    near: list[tuple[Indices, Floats]]

    @classmethod
    def of(cls, points_m: Floats, boxes: list[Box]) -> "PointsNearBoxes":
        near = []
        for box in boxes:
            indices = indices_around(points_m, box, 1.0)
            near.append((indices, box.outside_m(points_m[indices])))
        return cls(len(points_m), boxes, near)

    def inside(self, slack_m: float) -> list[Indices]:
        """The points of each box; a point in several belongs to the one of least volume, of equal ones to the first."""
        owner = np.full(self.n_points, -1)
        largest_first = sorted(range(len(self.boxes)), key=lambda idx: (self.boxes[idx].volume_m3, idx), reverse=True)
        for idx in largest_first:
            indices, outside_m = self.near[idx]
            owner[indices[outside_m <= slack_m]] = idx
        return [indices[owner[indices] == idx] for idx, (indices, _) in enumerate(self.near)]
