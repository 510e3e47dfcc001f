"""LAS and LAZ written by laspy and lazrs: scanbench finds the same points."""

from pathlib import Path

import laspy
import numpy

from made_labels import points

VERSIONS = [("1.2", 0), ("1.2", 1), ("1.2", 3), ("1.4", 6), ("1.4", 7), ("1.4", 8)]


def check_read(scanbench, scratch: Path):
    random = numpy.random.default_rng(11)
    (scratch / "drive").mkdir()
    expected = []
    for version, point_format in VERSIONS:
        for extension in ["las", "laz"]:
            header = laspy.LasHeader(version=version, point_format=point_format)
            header.scales, header.offsets = [0.001] * 3, random.normal(0, 5, 3).round(3)
            las = laspy.LasData(header)
            # More than one chunk of 50,000.
            las.x, las.y, las.z = random.normal(0, 20, (3, 60_000))
            las.intensity = random.integers(0, 65536, 60_000)
            if "gps_time" in las.point_format.dimension_names:
                las.gps_time = numpy.sort(random.uniform(0, 100, 60_000))
            las.write(scratch / f"drive/{len(expected):02}.{extension}")
            expected.append(numpy.column_stack([las.xyz, las.intensity / 65535]))
    scanbench("data", "convert", scratch / "drive", "-o", scratch / "out", "--to", "kitti-object")
    for number, rows in enumerate(expected):
        found = points(scratch / "out", number)
        assert found.shape == rows.shape and numpy.abs(found - rows).max() < 1e-4, number
    # On a map: the origin moves by whole metres.
    (scratch / "map").mkdir()
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.scales, header.offsets = [0.001] * 3, [691_000, 5_336_000, 500]
    las = laspy.LasData(header)
    las.x, las.y, las.z = random.normal(0, 20, (3, 1000)) + [[691_000.0], [5_336_000.0], [520.0]]
    las.write(scratch / "map/0.laz")
    scanbench("data", "convert", scratch / "map", "-o", scratch / "map-out", "--to", "kitti-object")
    moved = las.xyz - points(scratch / "map-out", 0)[:, :3]
    origin = moved.round().mean(0)
    assert numpy.abs(moved - origin).max() < 1e-4 and numpy.abs(origin - [691_000, 5_336_000, 500]).max() < 100, origin
    return f"{sum(map(len, expected))} points written by laspy and lazrs, in {len(expected)} kinds of files"
