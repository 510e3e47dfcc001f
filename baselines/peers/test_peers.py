"""Each detector of scanbench.toml against the reference host, on a drawn street; those whose libraries are not there are skipped.

PYTHONPATH=../../harness/python/src:../../harness/python/tests pytest
"""

from __future__ import annotations

import csv
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from reference_host import Host, Limits, ReportedFailure, columns_of

HERE = Path(__file__).parent
DETECTORS = tomllib.loads((HERE / "scanbench.toml").read_text())["detector"]
CAR_POSITIONS_M = [(8.0, 3.0), (12.0, -4.0), (20.0, 2.0)]


def street() -> np.ndarray:
    """A level road with three boxes on it, as points x, y, z, intensity."""
    random = np.random.default_rng(1)
    # About as many points at each range, as a sensor that turns sees them.
    range_m, turn = 3 + 37 * random.random(30_000), 2 * np.pi * random.random(30_000)
    road = np.column_stack([range_m * np.cos(turn), range_m * np.sin(turn), np.full(30_000, -1.73)])
    cars = [random.random((800, 3)) * [1.0, 1.8, 1.0] + [x, y, -1.2] for x, y in CAR_POSITIONS_M]
    positions = np.concatenate([road, *cars])
    return np.column_stack([positions, np.full(len(positions), 0.3)]).astype(np.float32)


@pytest.mark.parametrize("name", [name for name in DETECTORS if not name.endswith(("-as-documented", "-swept", "-swept-model"))])
def test_three_cars_are_three_clusters(name: str) -> None:
    section = DETECTORS[name]
    limits = Limits(start_s=120, first_scan_s=120, scan_s=120)
    command = [sys.executable, *section["command"][1:]]
    points = street()
    with Host(command, section["parameters"], limits, directory=HERE) as host:
        try:
            assert host.hello()["name"] == name
        except ReportedFailure as failure:
            if "No module named" in str(failure) or "is not built" in str(failure):
                pytest.skip(str(failure))
            raise
        host.configure()
        first, again = host.scan(columns_of(points), 0), host.scan(columns_of(points), 1)
        ids = first.ids
        assert ids is not None and again.ids is not None and np.array_equal(ids, again.ids)
        cars = [ids[30_000 + 800 * car : 30_800 + 800 * car] for car in range(3)]
        largest = [np.bincount(car).argmax() for car in cars]
        # HDBSCAN takes a box apart, where it is denser by chance.
        if name != "sklearn-hdbscan":
            assert len(set(largest)) == 3 and 0 not in largest
            assert all((car == id_).mean() > 0.7 for car, id_ in zip(cars, largest, strict=True))
        assert (ids[:30_000] > 0).mean() < 0.1
        assert host.scan(columns_of(points[:0]), 2).n_detections == 0


def test_a_ground_that_does_not_exist_is_refused() -> None:
    with Host([sys.executable, "-m", "scanbench.serve", "scipy_components.py:ScipyComponents"], directory=HERE) as host:
        try:
            host.hello()
        except ReportedFailure as failure:
            pytest.skip(str(failure))
        host.parameters = {"ground": "plane"}
        with pytest.raises(ReportedFailure, match="ground is patchworkpp or none, not 'plane'"):
            host.configure()


def write_objects(folder: Path) -> None:
    """Two poles and two walls, a little different."""
    random = np.random.default_rng(1)
    for number in range(2):
        pole = random.random((300, 3)) * [0.1, 0.1, 4.0 + number]
        wall = random.random((300, 3)) * [5.0 + number, 0.1, 1.5]
        for class_name, points in (("pole", pole), ("other", wall)):
            (folder / class_name).mkdir(parents=True, exist_ok=True)
            np.save(folder / class_name / f"{number}.npy", points.astype(np.float32))


@pytest.mark.parametrize("descriptor", ["esf", "vfh"])
def test_whole_objects_are_classified_and_steps_are_those_of_the_largest_extent(descriptor: str, tmp_path: Path) -> None:
    write_objects(tmp_path / "objects")
    folder, table = str(tmp_path / "objects"), tmp_path / "predicted.csv"
    command = [
        sys.executable,
        "pcl_object_classes.py",
        "--descriptor",
        descriptor,
        "--train",
        folder,
        "--judge",
        folder,
    ]
    done = subprocess.run([*command, "-o", str(table)], cwd=HERE, capture_output=True, text=True, check=False)
    if "is not built" in done.stderr:
        pytest.skip(done.stderr.splitlines()[-1])
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(table.open()))
    assert len(rows) == 4 * 2 * 10
    assert all(row["predicted"] == row["class"] and row["n_points"] == "300" for row in rows if row["step"] == "10")
    # A tenth of 5 m at each step: a wall of 1.5 m is whole from step 3 on, a pole of 4 m a tenth more each time.
    seen = {(row["object"], row["from"], int(row["step"])): int(row["n_points"]) for row in rows}
    assert seen["other/0.npy", "below", 2] < 300 == seen["other/0.npy", "below", 3] == seen["other/0.npy", "above", 3]
    assert 100 < seen["pole/0.npy", "below", 5] < 200
