"""Sweeps, and results of detectors, as pandas and pyarrow write and read them, against what scanbench does."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd

from converted import points

SAMPLES = Path(__file__).parents[2] / "harness/scans/tests/data/argoverse2"
COMPRESSIONS = ["uncompressed", "lz4", "zstd"]
SENSOR_M = np.array([1.0, 0.0, 1.5])
PLACE = ["tx_m", "ty_m", "tz_m", "length_m", "width_m", "height_m"]
TURN = ["qw", "qx", "qy", "qz"]
PLACE_IN_CSV = ["center_x_m", "center_y_m", "center_z_m", *PLACE[3:]]


def check_sweeps(scanbench, scratch: Path):
    """The drawn log of the tests, with each way to compress a sweep."""
    n_points = 0
    for compression in COMPRESSIONS:
        root, out = scratch / compression, scratch / f"{compression}-out"
        shutil.copytree(SAMPLES, root)
        sweeps = sorted(root.rglob("sensors/lidar/*.feather"))
        for sweep in sweeps:
            pd.read_feather(sweep).to_feather(sweep, compression=compression, chunksize=50)
        scanbench("data", "convert", root, "-o", out, "--to", "kitti-object")
        for number, sweep in enumerate(sweeps):
            table, found = pd.read_feather(sweep), points(out, number)
            expected = table[["x", "y", "z"]].to_numpy("f8") - SENSOR_M
            assert np.array_equal(found[:, :3], expected.astype("<f4")), sweep
            assert np.allclose(found[:, 3] * 255, table["intensity"], atol=1e-4)
            n_points += len(found)
    return f"{n_points} points written by pyarrow, plain and compressed"


def check_tables(scanbench, scratch: Path):
    """Tables of pandas in the frame of the car, through scanbench, to CSV in that of the sensor and to a table again."""
    random, root = np.random.default_rng(17), scratch / "log"
    shutil.copytree(SAMPLES, root)
    times_ns = sorted(int(it.stem) for it in root.rglob("sensors/lidar/*.feather"))
    n, n_boxes = 20 * len(times_ns), 0
    for compression in COMPRESSIONS:
        given = pd.DataFrame({"log_id": "drawn-log", "category": "REGULAR_VEHICLE", "timestamp_ns": np.repeat(times_ns, 20)})
        yaw = random.uniform(-np.pi, np.pi, n)
        given[PLACE] = np.hstack([random.uniform(-30, 30, (n, 3)), random.uniform(0.5, 9, (n, 3))])
        given[TURN] = np.column_stack([np.cos(yaw / 2), np.zeros((n, 2)), np.sin(yaw / 2)])
        given["score"] = random.uniform(-3, 3, n)
        given.to_feather(scratch / f"{compression}.feather", compression=compression)
        run = ["run", root, "-d", "found", "-P", "matching.min_points=1"]
        run += ["--detections", f"found={scratch / compression}.feather"]
        for output in ["csv", "argoverse2"]:
            written = ["--detections-out", scratch / f"{compression}-{output}", "--as", output]
            scanbench(*run, "--no-rrd", "-o", scratch / f"{compression}-run-{output}", *written)
        again = pd.read_feather(scratch / f"{compression}-argoverse2/found/detections.feather")
        assert again[["log_id", "timestamp_ns"]].equals(given[["log_id", "timestamp_ns"]])
        # Both quaternions of a turn will do.
        again[TURN] *= np.sign(given[["qw"]].to_numpy() * again[["qw"]].to_numpy())
        assert np.allclose(again[[*PLACE, *TURN, "score"]], given[[*PLACE, *TURN, "score"]], atol=1e-5)
        folder = scratch / f"{compression}-csv/found/drawn-log"
        found = pd.concat([pd.read_csv(folder / f"{number:06}.csv") for number in range(len(times_ns))])
        assert np.allclose(found[PLACE_IN_CSV], given[PLACE] - [*SENSOR_M, 0, 0, 0], atol=1e-4)
        assert np.allclose(np.exp(1j * found["yaw_rad"]), np.exp(1j * yaw), atol=1e-3)
        n_boxes += len(found)
    return f"{n_boxes} boxes of pyarrow's tables, in the frame of the sensor and back"
