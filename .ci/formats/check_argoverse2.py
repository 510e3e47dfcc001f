"""Sweeps as pyarrow reads them, against what scanbench does."""

import shutil
from pathlib import Path

import numpy
from pyarrow import feather

SAMPLES = Path(__file__).parents[2] / "harness/scans/tests/data/argoverse2"


def check_read(scanbench, scratch: Path):
    """The drawn log of the tests, with each way to compress a sweep."""
    n_points = 0
    for compression in ["uncompressed", "lz4", "zstd"]:
        root = scratch / compression
        shutil.copytree(SAMPLES, root)
        sweeps = sorted(root.rglob("sensors/lidar/*.feather"))
        for sweep in sweeps:
            feather.write_feather(feather.read_table(sweep), sweep, compression=compression, chunksize=50)
        scanbench("data", "convert", root, "-o", scratch / f"{compression}-out", "--to", "kitti-object")
        for number, sweep in enumerate(sweeps):
            table = feather.read_table(sweep)
            expected = numpy.stack([table[name].to_numpy().astype("f8") for name in "xyz"], 1) - [1.0, 0.0, 1.5]
            found = scratch / f"{compression}-out/training/velodyne/{number:06}.bin"
            found = numpy.fromfile(found, "<f4").reshape(-1, 4)
            assert numpy.array_equal(found[:, :3], expected.astype("<f4")), sweep
            assert numpy.allclose(found[:, 3] * 255, table["intensity"].to_numpy(), atol=1e-4)
            n_points += len(found)
    return f"{n_points} points written by pyarrow, plain and compressed"
