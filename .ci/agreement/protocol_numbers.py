"""Numbers of `--protocol` as a run leaves them, held against what a maker's program says."""

import json
import math
import sys
from pathlib import Path

import numpy as np

from program import Program

LARGEST_DIFFERENCE = 1e-6
STREETS = ("street-main-road", "street-narrow", "--simulated-scans", "10")
DETECTORS = ("hierarchical", "pca")
Numbers = dict[tuple[str, str], float]


def numbers_of(folder: Path, protocol: str) -> dict[str, Numbers]:
    """Those of each detector by class and metric; NaN where one is undefined."""
    numbers: dict[str, Numbers] = {}
    for row in json.loads((folder / "protocols.json").read_text())["rows"]:
        if row["protocol"] == protocol:
            value = math.nan if row["value"] is None else row["value"]
            numbers.setdefault(row["detector"], {})[row["class"], row["metric"]] = value
    return numbers


def numbers_of_tables(
    program: Program, data: Path, protocol: str, tables: dict[str, Path], folder: Path
) -> dict[str, Numbers]:
    """Those of tables of detections, by name."""
    given = [word for name, path in tables.items() for word in ("--detections", f"{name}={path}")]
    options = ["-d", ",".join(tables), "--protocol", protocol, "--missing-detections", "empty", "-o", folder / "run"]
    program.call("run", data, *given, *options, "--no-rrd")
    return numbers_of(folder / "run", protocol)


def found_by_ours(program: Program, data: Path, protocol: str, folder: Path) -> Path:
    """What a detector of ours finds, as others read it: without what is less likely a vehicle than not."""
    options = ["--detections-out", folder / "found", "--as", protocol, "-o", folder / "own", "--no-rrd"]
    program.call("run", data, "-d", "simple-grid", *options)
    return next(it for it in (folder / "found/simple-grid").rglob("*") if it.suffix in (".json", ".feather"))


def numbers_on_streets(program: Program, protocol: str, car: str, folder: Path) -> dict[str, Numbers]:
    """Those of detectors of ours on simulated streets, of which each finds cars."""
    program.call("run", *STREETS, "-d", ",".join(DETECTORS), "--protocol", protocol, "-o", folder / "streets", "--no-rrd")
    numbers = numbers_of(folder / "streets", protocol)
    for name in DETECTORS:
        if not numbers[name][car, "ap"] > 0.0:
            sys.exit(f"{name} found no car on simulated streets")
    return numbers


def compare(protocol: str, data: str, maker: str, ours: dict[str, Numbers], theirs: dict[str, Numbers], least: int) -> None:
    """Prints how many numbers both have and how far they are apart; ends the program if too far, or if they are too few."""
    n, worst = 0, 0.0
    for name, of_maker in theirs.items():
        for key in ours[name].keys() & of_maker.keys():
            a, b = ours[name][key], of_maker[key]
            if math.isnan(a) and math.isnan(b):
                continue
            if not abs(a - b) <= LARGEST_DIFFERENCE:
                sys.exit(f"{name}: {key} is {a}, {maker} says {b}")
            n, worst = n + 1, max(worst, abs(a - b))
    if n < least:
        sys.exit(f"only {n} numbers were compared on {data}")
    of = f"{n} numbers of {len(theirs)} detectors on {data}"
    print(f"  {protocol}: {of} as {maker} has them, largest difference {worst:.1e}")


def check_order(ours: dict[str, Numbers], names: tuple[str, ...]) -> None:
    """Makes sure that each of `names` has the numbers of what is the same in another order."""
    for name in names:
        first, second = (list(ours[it].values()) for it in (name, f"{name}-shuffled"))
        if not first or not np.array_equal(first, second, equal_nan=True):
            sys.exit(f"{name}: another order gives other numbers")
