"""Scans written by NumPy, plyfile, pypcd4, laspy and lazrs: scanbench finds the same points."""

from pathlib import Path

import laspy
import numpy as np
from plyfile import PlyData, PlyElement
from pypcd4 import Encoding, PointCloud

from converted import points

LAS_VERSIONS = [("1.2", 0), ("1.2", 1), ("1.2", 3), ("1.4", 6), ("1.4", 7), ("1.4", 8)]


def converted(scanbench, folder: Path, n_scans):
    scanbench("data", "convert", folder, "-o", folder / "out", "--to", "kitti-object")
    return [points(folder / "out", number) for number in range(n_scans)]


def check_folder(scanbench, scratch: Path):
    clouds = np.random.default_rng(7).normal(0, 20, (9, 1000, 4)).astype("<f4")
    # An array does not name its columns; what has negative numbers is no intensity.
    clouds[..., 3] = np.abs(clouds[..., 3])
    to_write = ((cloud, scratch / f"{number:02}") for number, cloud in enumerate(clouds))
    for encoding, (cloud, path) in zip([Encoding.ASCII, Encoding.BINARY, Encoding.BINARY_COMPRESSED], to_write):
        PointCloud.from_xyzi_points(cloud).save(path.with_suffix(".pcd"), encoding)
    for (text, byte_order), (cloud, path) in zip([(True, "="), (False, "<"), (False, ">")], to_write):
        rows = np.empty(len(cloud), [("x", "f8"), ("intensity", "f4"), ("y", "f4"), ("z", "f4")])
        rows["x"], rows["y"], rows["z"], rows["intensity"] = cloud.T
        PlyData([PlyElement.describe(rows, "vertex")], text=text, byte_order=byte_order).write(path.with_suffix(".ply"))
    for change, (cloud, path) in zip([np.asarray, np.asfortranarray, lambda it: it.astype(">f8")], to_write):
        np.save(path.with_suffix(".npy"), change(cloud))
    assert np.allclose(converted(scanbench, scratch, len(clouds)), clouds, rtol=1e-6)
    return f"{len(clouds)} scans written by pypcd4, plyfile and NumPy"


def las_of(version, point_format, offsets, positions):
    header = laspy.LasHeader(version=version, point_format=point_format)
    header.scales, header.offsets = [0.001] * 3, offsets
    las = laspy.LasData(header)
    las.x, las.y, las.z = positions
    return las


def check_las(scanbench, scratch: Path):
    random = np.random.default_rng(11)
    expected = []
    for version, point_format in LAS_VERSIONS:
        for extension in ["las", "laz"]:
            # More than one chunk of 50,000.
            las = las_of(version, point_format, random.normal(0, 5, 3).round(3), random.normal(0, 20, (3, 60_000)))
            las.intensity = random.integers(0, 65536, 60_000)
            if "gps_time" in las.point_format.dimension_names:
                las.gps_time = np.sort(random.uniform(0, 100, 60_000))
            las.write(scratch / f"{len(expected):02}.{extension}")
            expected.append(np.column_stack([las.xyz, las.intensity / 65535]))
    assert np.abs(np.subtract(converted(scanbench, scratch, len(expected)), expected)).max() < 1e-4
    return f"{sum(map(len, expected))} points written by laspy and lazrs, in {len(expected)} kinds of files"


def check_map(scanbench, scratch: Path):
    """The origin of a map moves by whole metres."""
    corner = np.array([691_000, 5_336_000, 500])
    around = np.random.default_rng(11).normal(0, 20, (3, 1000)) + [[0.0], [0.0], [20.0]]
    las = las_of("1.4", 6, corner, around + corner[:, None])
    las.write(scratch / "0.laz")
    [found] = converted(scanbench, scratch, 1)
    moved = las.xyz - found[:, :3]
    origin = moved.round().mean(0)
    assert np.abs(moved - origin).max() < 1e-4 and np.abs(origin - corner).max() < 100, origin
    return f"{len(found)} points of a map, from an origin in whole metres"
