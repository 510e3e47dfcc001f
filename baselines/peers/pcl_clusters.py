"""PCL's EuclideanClusterExtraction and ConditionalEuclideanClustering, of the library that `pcl/` builds."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
import scanbench
from above_ground import cluster_above_ground
from ground import Ground
from numpy.typing import NDArray
from scanbench import Configuration, Detections

PATH = Path(__file__).parent / "pcl/build/libpcl_clusters.so"
if not PATH.exists():
    raise FileNotFoundError(f"{PATH} is not built: cmake -S pcl -B pcl/build && cmake --build pcl/build")
LIBRARY = ctypes.CDLL(str(PATH))
LIBRARY.pcl_version.restype = ctypes.c_char_p
VERSION: str = LIBRARY.pcl_version().decode()

POINTS = np.ctypeslib.ndpointer(np.float32, ndim=2, flags="C_CONTIGUOUS")
LABELS = np.ctypeslib.ndpointer(np.int32, ndim=1, flags="C_CONTIGUOUS")
NUMBER, COUNT = ctypes.c_double, ctypes.c_int32
LIBRARY.euclidean.argtypes = [POINTS, ctypes.c_int64, NUMBER, COUNT, COUNT, LABELS]
LIBRARY.conditional_euclidean.argtypes = [POINTS, ctypes.c_int64, NUMBER, NUMBER, NUMBER, NUMBER, COUNT, COUNT, LABELS]
for function in (LIBRARY.euclidean, LIBRARY.conditional_euclidean):
    function.restype = None


@scanbench.detector(name="pcl-euclidean", version=VERSION)
class PclEuclidean:
    """`pcl::EuclideanClusterExtraction`."""

    def __init__(
        self,
        configuration: Configuration,
        tolerance_m: float = 0.5,
        min_points: int = 10,
        max_points: int = 25000,
        ground: str = "patchworkpp",
        adapt_ground: bool = False,
    ) -> None:
        self.parameters = (tolerance_m, min_points, max_points)
        self.ground = Ground(ground, adapt_ground, configuration)

    def __call__(self, points: NDArray[np.float32]) -> Detections:
        return cluster_above_ground(points, self.ground, self.cluster)

    def cluster(self, points: NDArray[np.float32]) -> NDArray[np.integer]:
        labels = np.empty(len(points), np.int32)
        LIBRARY.euclidean(np.ascontiguousarray(points), len(points), *self.parameters, labels)
        return labels


@scanbench.detector(name="pcl-conditional", version=VERSION)
class PclConditional:
    """`pcl::ConditionalEuclideanClustering` with a tolerance that grows with range, and a limit of the difference of intensities."""

    def __init__(
        self,
        configuration: Configuration,
        tolerance_m: float = 0.3,
        tolerance_per_m: float = 0.01,
        max_tolerance_m: float = 1.0,
        max_intensity_difference: float = 5.0,
        min_points: int = 10,
        max_points: int = 25000,
        ground: str = "patchworkpp",
        adapt_ground: bool = False,
    ) -> None:
        tolerances = (tolerance_m, tolerance_per_m, max_tolerance_m)
        self.parameters = (*tolerances, max_intensity_difference, min_points, max_points)
        self.ground = Ground(ground, adapt_ground, configuration)

    def __call__(self, points: NDArray[np.float32]) -> Detections:
        return cluster_above_ground(points, self.ground, self.cluster)

    def cluster(self, points: NDArray[np.float32]) -> NDArray[np.integer]:
        labels = np.empty(len(points), np.int32)
        LIBRARY.conditional_euclidean(np.ascontiguousarray(points), len(points), *self.parameters, labels)
        return labels
