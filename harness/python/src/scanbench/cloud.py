"""The points of a scan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Cloud:
    """The points of one scan as columns of length n, in the sensor frame: x forward, y left, z up, in metres.

    The columns are views of shared memory: read-only, and the next scan's once the detector has returned.
    """

    number: int
    """Number of the scan."""
    name: str
    """Drive and scan, as `0001/000017`."""
    time_s: float
    """Time of the scan within its drive, in seconds."""
    x_m: NDArray[np.float32]
    """Forward."""
    y_m: NDArray[np.float32]
    """To the left."""
    z_m: NDArray[np.float32]
    """Up."""
    intensity: NDArray[np.float32] | None = None
    """Reflected intensity, the sensor's own; None where the data have none."""
    ring: NDArray[np.uint16] | None = None
    """Number of the laser; None where the data have none."""
    time_offset_s: NDArray[np.float32] | None = None
    """Seconds from `time_s` to the measurement; None where the data have none."""
    world_from_sensor: NDArray[np.float64] | None = None
    """Pose of the sensor in a frame that rests, 4 × 4; None where it is not known."""
    earlier: tuple[Cloud, ...] = ()
    """The scans before this one, the latest first, in the frame of this one; as many as `earlier_scans` of `detector` asks for,
    fewer at the beginning of a drive."""
    begins_drive: bool = False
    """Whether a detector with `in_order` has to forget what it knows."""

    def __len__(self) -> int:
        return len(self.x_m)

    @property
    def xyz_m(self) -> NDArray[np.float32]:
        """Positions as a new n × 3 array."""
        return np.column_stack([self.x_m, self.y_m, self.z_m])

    @property
    def points(self) -> NDArray[np.float32]:
        """Positions and intensity as a new n × 4 array; intensity is 0 where the data have none."""
        points = np.zeros((len(self), 4), np.float32)
        for index, column in enumerate([self.x_m, self.y_m, self.z_m, self.intensity]):
            if column is not None:
                points[:, index] = column
        return points
