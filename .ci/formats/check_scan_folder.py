"""Scans written by NumPy, plyfile and pypcd4: scanbench finds the same points."""

from pathlib import Path

import numpy
from plyfile import PlyData, PlyElement
from pypcd4 import Encoding, PointCloud


def check_read(scanbench, scratch: Path):
    random = numpy.random.default_rng(7)
    (scratch / "drive").mkdir()
    expected = []

    def scan():
        expected.append(random.normal(0, 20, (1000, 4)).astype("<f4"))
        return expected[-1], scratch / f"drive/{len(expected):02}"

    for encoding in [Encoding.ASCII, Encoding.BINARY, Encoding.BINARY_COMPRESSED]:
        points, path = scan()
        PointCloud.from_xyzi_points(points).save(path.with_suffix(".pcd"), encoding)
    for text, byte_order in [(True, "="), (False, "<"), (False, ">")]:
        points, path = scan()
        rows = numpy.empty(len(points), [("x", "f8"), ("intensity", "f4"), ("y", "f4"), ("z", "f4")])
        for column, name in enumerate(["x", "y", "z", "intensity"]):
            rows[name] = points[:, column]
        PlyData([PlyElement.describe(rows, "vertex")], text=text, byte_order=byte_order).write(path.with_suffix(".ply"))
    for change in [numpy.asarray, numpy.asfortranarray, lambda it: it.astype(">f8")]:
        points, path = scan()
        numpy.save(path.with_suffix(".npy"), change(points))
    scanbench("data", "convert", scratch / "drive", "-o", scratch / "out", "--to", "kitti-object")
    for number, points in enumerate(expected):
        found = numpy.fromfile(scratch / f"out/training/velodyne/{number:06}.bin", "<f4").reshape(-1, 4)
        assert numpy.allclose(found, points, rtol=1e-6), number
    return f"{len(expected)} scans written by pypcd4, plyfile and NumPy"
