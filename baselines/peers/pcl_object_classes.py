"""PCL's ESF and VFH with the nearest neighbour: what is an object of which a part has been seen?

    python3 pcl_object_classes.py --descriptor esf --train FOLDER --judge FOLDER -o predicted.csv

Both folders have a folder for each class with `.npy` files of x, y, z in metres, as scanbench writes them. Each object that is judged is
uncovered in ten steps, from below and from above, as scanbench does it: a level strip more at each, as high as a tenth of the largest extent.
The table has a row for each object, direction and step, with the predicted class; it is empty where fewer than `--least-points` points are
seen.
"""

from __future__ import annotations

import argparse
import csv
import ctypes
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

PATH = Path(__file__).parent / "pcl/build/libpcl_shapes.so"
N_STEPS = 10
SIZES = {"esf": 640, "vfh": 308}
POINTS = np.ctypeslib.ndpointer(np.float32, ndim=2, flags="C_CONTIGUOUS")
HISTOGRAM = np.ctypeslib.ndpointer(np.float32, ndim=1, flags="C_CONTIGUOUS")

Points = NDArray[np.float32]


class Object(NamedTuple):
    """An object of a folder."""

    name: str
    class_name: str
    points: Points


class Part(NamedTuple):
    """What is seen of an object at a step."""

    object: Object
    uncovered_from: str
    step: int
    points: Points


def load_library() -> ctypes.CDLL:
    if not PATH.exists():
        raise FileNotFoundError(f"{PATH} is not built: cmake -S pcl -B pcl/build && cmake --build pcl/build")
    library = ctypes.CDLL(str(PATH))
    library.esf.argtypes = [POINTS, ctypes.c_int64, HISTOGRAM]
    library.vfh.argtypes = [POINTS, ctypes.c_int64, ctypes.c_int32, HISTOGRAM]
    for function in (library.esf, library.vfh):
        function.restype = None
    return library


def objects_in(folder: Path, most_per_class: int) -> list[Object]:
    """The first objects of each class, in the order of names."""
    found = []
    for class_folder in sorted(it for it in folder.iterdir() if it.is_dir()):
        files = sorted(class_folder.glob("*.npy"))[:most_per_class]
        if not files:
            raise ValueError(f"{class_folder} has no .npy files")
        for file in files:
            points = np.load(file, allow_pickle=False)[:, :3].astype(np.float32)
            points = points[np.isfinite(points).all(axis=1)]
            found.append(Object(f"{class_folder.name}/{file.name}", class_folder.name, points))
    if not found:
        raise ValueError(f"{folder} has no folders of classes")
    return found


def uncovered(points: Points, uncovered_from: str, step: int) -> Points:
    """The part of an object that is seen at `step`, 1 to 10."""
    if len(points) == 0:
        return points
    exact = points.astype(np.float64)
    least, greatest = exact.min(axis=0), exact.max(axis=0)
    z = exact[:, 2]
    from_end_m = z - least[2] if uncovered_from == "below" else greatest[2] - z
    seen: Points = points[from_end_m * N_STEPS <= (greatest - least).max() * step]
    return seen


def parts_of(found: Object) -> Iterator[Part]:
    for uncovered_from in ("below", "above"):
        for step in range(1, N_STEPS + 1):
            yield Part(found, uncovered_from, step, uncovered(found.points, uncovered_from, step))


class Describer:
    """A descriptor of PCL, of the points about their middle, as if seen from there."""

    def __init__(self, name: str, n_neighbors: int) -> None:
        self.library, self.name, self.n_neighbors = load_library(), name, n_neighbors

    def __call__(self, points: Points) -> NDArray[np.float32]:
        middle = np.append(points[:, :2].mean(axis=0), 0)
        centered = np.ascontiguousarray(points - middle, np.float32)
        histogram = np.empty(SIZES[self.name], np.float32)
        if self.name == "esf":
            self.library.esf(centered, len(centered), histogram)
        else:
            self.library.vfh(centered, len(centered), self.n_neighbors, histogram)
        finite: NDArray[np.float32] = np.nan_to_num(histogram)
        return finite

    def distances(self, known: NDArray[np.float32], histogram: NDArray[np.float32]) -> NDArray[np.float32]:
        """ESF is compared by L1, VFH by chi-squared, each as its authors do."""
        difference = known - histogram
        if self.name == "esf":
            return np.asarray(np.abs(difference).sum(axis=1))
        sums = known + histogram
        return np.asarray(np.divide(difference**2, sums, out=np.zeros_like(sums), where=sums > 0).sum(axis=1))


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--descriptor", choices=sorted(SIZES), required=True)
    parser.add_argument("--train", type=Path, required=True, help="folder of the objects that are known")
    parser.add_argument("--judge", type=Path, required=True, help="folder of the objects that are judged")
    parser.add_argument("--train-on", choices=["whole", "partial"], default="whole")
    parser.add_argument("--most-per-class", type=int, default=300)
    parser.add_argument("--least-points", type=int, default=10)
    parser.add_argument("--most-points", type=int, default=2000, help="of larger clouds every n-th point is taken")
    parser.add_argument("--normal-neighbors", type=int, default=20, help="points that a normal of VFH is fitted to")
    parser.add_argument("-o", "--output", type=Path, required=True)
    return parser.parse_args()


def thinned(points: Points, most_points: int) -> Points:
    return points[:: max(1, -(-len(points) // most_points))]


def main() -> None:
    asked = arguments()
    describe = Describer(asked.descriptor, asked.normal_neighbors)

    def histogram_of(points: Points) -> NDArray[np.float32] | None:
        return describe(thinned(points, asked.most_points)) if len(points) >= asked.least_points else None

    known, classes = [], []
    for it in objects_in(asked.train, asked.most_per_class):
        pieces = [it.points] if asked.train_on == "whole" else [part.points for part in parts_of(it)]
        for histogram in filter(lambda it: it is not None, map(histogram_of, pieces)):
            known.append(histogram)
            classes.append(it.class_name)
    table = np.array(known)
    with asked.output.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["object", "class", "from", "step", "n_points", "predicted"])
        for judged in objects_in(asked.judge, asked.most_per_class):
            for part in parts_of(judged):
                histogram = histogram_of(part.points)
                predicted = "" if histogram is None else classes[int(describe.distances(table, histogram).argmin())]
                n_points = len(part.points)
                writer.writerow([judged.name, judged.class_name, part.uncovered_from, part.step, n_points, predicted])


if __name__ == "__main__":
    main()
