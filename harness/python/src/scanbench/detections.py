"""What a detector found in a scan."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

MAX_SIZE_M = 1000.0
"""No side of a box is longer."""
MAX_CENTER_M = 10_000.0
"""No centre of a box is farther from the sensor."""
MAX_BOXES = 100_000
"""No scan has more boxes."""
MAX_PRODUCTS = 32
"""No scan has more products."""
MAX_NAME_BYTES = 60
"""No name of a stage or product is longer."""


@dataclass
class Boxes:
    """Upright boxes in the sensor frame; any array of m × 7 numbers is turned into f32.

    The columns are the centre x, y, z, the length (along the heading), width and height in metres, and the yaw in radians,
    counter-clockwise about z. A detector may return such an array itself, as `Boxes(array)`.
    """

    rows: ArrayLike
    """m × 7."""
    scores: ArrayLike | None = None
    """A number for each box; more is surer."""
    classes: Sequence[str | None] | None = None
    """A class for each box, or None where the detector predicts none."""
    velocities: ArrayLike | None = None
    """m × 2: over ground along x and y, in metres per second; NaN where it is not known."""
    tracks: ArrayLike | None = None
    """An integer for each box, the same in all scans of a drive for the same object; below 0 for none."""

    def __post_init__(self) -> None:
        rows = np.asarray(self.rows, dtype="<f4")
        if rows.size == 0:
            rows = rows.reshape(0, 7)
        if rows.ndim != 2 or rows.shape[1] != 7:
            raise ValueError(f"boxes are an array of m x 7 (x, y, z, length, width, height, yaw), not of {rows.shape}")
        self.rows = rows

    @classmethod
    def of(
        cls,
        centers_m: ArrayLike,
        sizes_m: ArrayLike,
        yaws_rad: ArrayLike = 0.0,
        scores: ArrayLike | None = None,
        classes: Sequence[str | None] | None = None,
        velocities: ArrayLike | None = None,
        tracks: ArrayLike | None = None,
    ) -> Boxes:
        """Boxes of centres (m × 3), lengths, widths and heights (m × 3), and yaws (m, or one for all)."""
        centers = np.asarray(centers_m, dtype=np.float32).reshape(-1, 3)
        sizes = np.broadcast_to(np.asarray(sizes_m, dtype=np.float32), centers.shape)
        yaws = np.broadcast_to(np.asarray(yaws_rad, dtype=np.float32), len(centers))
        return cls(np.column_stack([centers, sizes, yaws]), scores, classes, velocities, tracks)

    def __len__(self) -> int:
        return len(self.array)

    @property
    def array(self) -> NDArray[np.float32]:
        """The m × 7 numbers."""
        return np.asarray(self.rows, dtype="<f4")

    def check(self) -> None:
        """Raises ValueError if a box is none, or there are too many."""
        if len(self) > MAX_BOXES:
            raise ValueError(f"{len(self)} boxes, more than {MAX_BOXES}")
        _refuse(~np.isfinite(self.array).all(axis=1), "has NaN or infinity")
        sizes_m = self.array[:, 3:6]
        _refuse(
            ((sizes_m <= 0) | (sizes_m > MAX_SIZE_M)).any(axis=1),
            f"has a side not above 0 and at most {MAX_SIZE_M:g} m",
        )
        farthest_m = np.linalg.norm(self.array[:, :3].astype(np.float64), axis=1)
        _refuse(farthest_m > MAX_CENTER_M, f"is more than {MAX_CENTER_M:g} m from the sensor")


def check_name(name: str) -> str:
    """`name`, if a stage or a product may be called so; raises ValueError otherwise."""
    if not 0 < len(name.encode()) <= MAX_NAME_BYTES or any(unicodedata.category(sign) == "Cc" for sign in name):
        raise ValueError(
            f"{name!r} is no name of a stage or product: 1 to {MAX_NAME_BYTES} bytes, no control characters"
        )
    return name


def _refuse(wrong: ArrayLike, what: str) -> None:
    if np.any(wrong):
        raise ValueError(f"box {int(np.argmax(wrong))} {what}")


@dataclass
class Detections:
    """Everything that a detector can answer; labels and boxes alone can be returned without it."""

    labels: ArrayLike | None = None
    """An integer for each point: the number of its cluster from 0, below 0 for none (see `noise` of `detector`)."""
    boxes: Boxes | None = None
    """Boxes; with labels, box k is that of cluster k."""
    scores: ArrayLike | None = None
    """A number for each cluster in the order of their labels; scores of boxes belong into `boxes`."""
    classes: Sequence[str | None] | None = None
    """A class for each cluster; classes of boxes belong into `boxes`."""
    velocities: ArrayLike | None = None
    """As of `Boxes`, for each cluster."""
    tracks: ArrayLike | None = None
    """As of `Boxes`, for each cluster."""
    products: Mapping[str, ArrayLike] = field(default_factory=dict)
    """By name, an integer of 0 to 255 for each point, which the viewer draws as a colour."""

    @classmethod
    def of(cls, answer: Any) -> Detections:
        """What a detector function has returned: labels, boxes, both as a pair, or everything."""
        if isinstance(answer, Detections):
            return answer
        if isinstance(answer, Boxes):
            return cls(boxes=answer)
        if isinstance(answer, tuple) and len(answer) == 2 and isinstance(answer[1], Boxes):
            return cls(labels=answer[0], boxes=answer[1])
        if answer is None:
            raise TypeError("the detector returned None; labels, Boxes, both or Detections are expected")
        return cls(labels=answer)
