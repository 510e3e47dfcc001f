"""Sweeps, and results of detectors, as pyarrow writes and reads them, against what scanbench does."""

import csv
import shutil
from pathlib import Path

import numpy
import pyarrow
from pyarrow import feather

from made_labels import points

SAMPLES = Path(__file__).parents[2] / "harness/scans/tests/data/argoverse2"
COMPRESSIONS = ["uncompressed", "lz4", "zstd"]
SENSOR_M = numpy.array([1.0, 0.0, 1.5])
NUMBERS = ["tx_m", "ty_m", "tz_m", "length_m", "width_m", "height_m", "qw", "qx", "qy", "qz", "score"]
BOX = ["center_x_m", "center_y_m", "center_z_m", "length_m", "width_m", "height_m", "yaw_rad"]


def check_sweeps(scanbench, scratch: Path):
    """The drawn log of the tests, with each way to compress a sweep."""
    n_points = 0
    for compression in COMPRESSIONS:
        root, out = scratch / compression, scratch / f"{compression}-out"
        shutil.copytree(SAMPLES, root)
        sweeps = sorted(root.rglob("sensors/lidar/*.feather"))
        for sweep in sweeps:
            feather.write_feather(feather.read_table(sweep), sweep, compression=compression, chunksize=50)
        scanbench("data", "convert", root, "-o", out, "--to", "kitti-object")
        for number, sweep in enumerate(sweeps):
            table, found = feather.read_table(sweep), points(out, number)
            expected = numpy.stack([table[name].to_numpy().astype("f8") for name in "xyz"], 1) - SENSOR_M
            assert numpy.array_equal(found[:, :3], expected.astype("<f4")), sweep
            assert numpy.allclose(found[:, 3] * 255, table["intensity"].to_numpy(), atol=1e-4)
            n_points += len(found)
    return f"{n_points} points written by pyarrow, plain and compressed"


def made(times_ns, random):
    """A table of vehicles all round, with texts as pandas writes them."""
    n = 20 * len(times_ns)
    yaw = random.uniform(-numpy.pi, numpy.pi, n)
    numbers = numpy.zeros((n, len(NUMBERS)))
    numbers[:, :3] = random.uniform(-30, 30, (n, 3))
    numbers[:, 3:6] = random.uniform(0.5, 9, (n, 3))
    numbers[:, 6], numbers[:, 9] = numpy.cos(yaw / 2), numpy.sin(yaw / 2)
    numbers[:, 10] = random.uniform(-3, 3, n)
    columns = {name: numbers[:, index] for index, name in enumerate(NUMBERS)}
    columns["log_id"] = pyarrow.array(["drawn-log"] * n, pyarrow.large_string())
    columns["category"] = pyarrow.array(["REGULAR_VEHICLE"] * n, pyarrow.large_string())
    columns["timestamp_ns"] = numpy.repeat(times_ns, 20)
    return pyarrow.table(columns), yaw


def check_tables(scanbench, scratch: Path):
    """Tables of pyarrow in the frame of the car, through scanbench, to CSV in that of the sensor and to a table again."""
    random = numpy.random.default_rng(17)
    root = scratch / "log"
    shutil.copytree(SAMPLES, root)
    times_ns = sorted(int(it.stem) for it in root.rglob("sensors/lidar/*.feather"))
    n_boxes = 0
    for compression in COMPRESSIONS:
        table, yaw = made(times_ns, random)
        feather.write_feather(table, scratch / f"{compression}.feather", compression=compression)
        run = ["run", root, "-d", "found", "--detections", f"found={scratch / compression}.feather", "-P", "matching.min_points=1"]
        for output in ["csv", "argoverse2"]:
            written = ["--detections-out", scratch / f"{compression}-{output}", "--as", output]
            scanbench(*run, "--no-rrd", "-o", scratch / f"{compression}-run-{output}", *written)
        again = feather.read_table(scratch / f"{compression}-argoverse2/found/detections.feather")
        assert again["timestamp_ns"].to_pylist() == table["timestamp_ns"].to_pylist()
        assert again["log_id"].to_pylist() == table["log_id"].to_pylist()
        given, carried = ({name: it[name].to_numpy() for name in NUMBERS} for it in (table, again))
        for name in NUMBERS:
            # Both quaternions of a turn will do.
            sign = numpy.sign(given["qw"] * carried["qw"]) if name.startswith("q") else 1
            assert numpy.allclose(carried[name] * sign, given[name], atol=1e-5), name
        for number in range(len(times_ns)):
            path = scratch / f"{compression}-csv/found/drawn-log/{number:06}.csv"
            with path.open(newline="") as file:
                found = numpy.array([[float(row[it]) for it in BOX] for row in csv.DictReader(file)])
            own = slice(20 * number, 20 * number + 20)
            expected = numpy.column_stack([given[it][own] for it in NUMBERS[:6]])
            expected[:, :3] -= SENSOR_M
            assert numpy.allclose(found[:, :6], expected, atol=1e-4)
            assert numpy.allclose(numpy.exp(1j * found[:, 6]), numpy.exp(1j * yaw[own]), atol=1e-3)
            n_boxes += len(found)
    return f"{n_boxes} boxes of pyarrow's tables, in the frame of the sensor and back"
