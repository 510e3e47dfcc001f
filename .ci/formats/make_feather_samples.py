"""Makes the small log in harness/scans/tests/data/argoverse2, of drawn points, with pyarrow.

    python .ci/formats/make_feather_samples.py harness/scans/tests/data/argoverse2
"""

import sys
from pathlib import Path

import numpy
import pyarrow
from pyarrow import feather

log = Path(sys.argv[1]) / "sensor/val/drawn-log"


def write(name, columns, compression):
    path = log / name
    path.parent.mkdir(parents=True, exist_ok=True)
    feather.write_feather(pyarrow.table(columns), path, compression=compression)


def poses(at, **others):
    at = numpy.asarray(at, float)
    turn = {name: numpy.full(len(at), value) for name, value in [("qw", 1.0), ("qx", 0.0), ("qy", 0.0), ("qz", 0.0)]}
    return {**others, **turn, "tx_m": at[:, 0], "ty_m": at[:, 1], "tz_m": at[:, 2]}


TIMES = [1000, 2000]
for time, compression in zip(TIMES, ["lz4", "zstd"]):
    # Four points on a car ten metres ahead of the sensor, whose lidars are at (1, 0, 1.5), and 200 on the road.
    road = numpy.stack([numpy.linspace(3, 13, 200), numpy.tile([-2.0, 2.0], 100), numpy.full(200, -0.5)], 1)
    car = numpy.array([[10.5, 0.5, 0.5], [11.5, 0.5, 1.0], [10.5, -0.5, 0.5], [11.0, 0.0, 1.0]])
    points = numpy.concatenate([car, road]).astype(numpy.float16)
    columns = {name: points[:, axis] for axis, name in enumerate("xyz")}
    n = len(points)
    columns["intensity"] = numpy.full(n, 51, numpy.uint8)
    columns["laser_number"] = numpy.arange(n, dtype=numpy.uint8)
    columns["offset_ns"] = numpy.arange(n, dtype=numpy.int32)
    write(f"sensors/lidar/{time}.feather", columns, compression)

write(
    "annotations.feather",
    poses(
        [[11.0, 0.0, 0.4], [12.0, 0.0, 0.4], [6.0, 2.0, 0.0]],
        timestamp_ns=numpy.array([1000, 2000, 2000]),
        track_uuid=["b", "b", "a"],
        category=["REGULAR_VEHICLE", "REGULAR_VEHICLE", "PEDESTRIAN"],
        length_m=numpy.array([4.0, 4.0, 0.5]),
        width_m=numpy.array([2.0, 2.0, 0.5]),
        height_m=numpy.array([1.5, 1.5, 1.8]),
    ),
    "uncompressed",
)
write("city_SE3_egovehicle.feather", poses([[100.0, 0, 0], [110.0, 0, 0]], timestamp_ns=numpy.array(TIMES)), "lz4")
write(
    "calibration/egovehicle_SE3_sensor.feather",
    poses([[1.0, 0, 1.6], [1.0, 0, 1.4], [0.0, 0, 2.0]], sensor_name=["up_lidar", "down_lidar", "ring_front_center"]),
    "zstd",
)
