"""What is taken away before clustering."""

from __future__ import annotations

import numpy as np
import scanbench
from numpy.typing import NDArray
from scanbench import Configuration


class Ground:
    """Finds the ground of scans: `patchworkpp`, Patchwork++ with its authors' parameters, or `none`.

    Patchwork++ adapts to the scans it has seen. With `adapt` it does; without it begins anew with each scan, so that a scan gives the
    same answer however often and in whichever order it is asked for.
    """

    def __init__(self, method: str, adapt: bool, configuration: Configuration) -> None:
        if method not in ("patchworkpp", "none"):
            raise ValueError(f"ground is patchworkpp or none, not {method!r}")
        self.method = method
        self.adapt = adapt
        if method == "patchworkpp":
            # Only whoever wants it needs it.
            import pypatchworkpp

            parameters = pypatchworkpp.Parameters()
            parameters.verbose = False
            if configuration.sensor_height_m is not None:
                parameters.sensor_height = configuration.sensor_height_m
            self.make = lambda: pypatchworkpp.patchworkpp(parameters)
            self.patchwork = self.make()

    def is_ground(self, points: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Whether each of n × 4 points is ground."""
        mask = np.zeros(len(points), np.bool_)
        if self.method == "none" or not len(points):
            return mask
        with scanbench.stage("ground"):
            if not self.adapt:
                self.patchwork = self.make()
            self.patchwork.estimateGround(points)
            mask[np.asarray(self.patchwork.getGroundIndices(), dtype=np.intp)] = True
        return mask
