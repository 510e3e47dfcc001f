"""Numbers of `--protocol` as a run leaves them, held against what a maker's program says; and the boxes that they are made of."""

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np

LARGEST_DIFFERENCE = 1e-6
Numbers = dict[tuple[str, str], float]


def run(scanbench: str, *arguments: str | Path) -> None:
    subprocess.run([scanbench, "run", *map(str, arguments), "--no-rrd"], check=True, stdout=subprocess.DEVNULL)


def numbers_of(folder: Path, protocol: str) -> dict[str, Numbers]:
    """Those of each detector by class and metric; NaN where one is undefined."""
    numbers: dict[str, Numbers] = {}
    for row in json.loads((folder / "protocols.json").read_text())["rows"]:
        if row["protocol"] == protocol:
            value = math.nan if row["value"] is None else row["value"]
            numbers.setdefault(row["detector"], {})[row["class"], row["metric"]] = value
    return numbers


def compare(name: str, ours: Numbers, theirs: Numbers, maker: str) -> tuple[int, float]:
    """How many numbers both have, and how far they are apart at most; ends the program if that is too far."""
    n, worst = 0, 0.0
    for key in ours.keys() & theirs.keys():
        if math.isnan(ours[key]) and math.isnan(theirs[key]):
            continue
        difference = abs(ours[key] - theirs[key])
        if not difference <= LARGEST_DIFFERENCE:
            sys.exit(f"{name}: {key} is {ours[key]}, {maker} says {theirs[key]}")
        n, worst = n + 1, max(worst, difference)
    return n, worst


def check_order(ours: dict[str, Numbers], names: tuple[str, ...]) -> None:
    """Makes sure that each of `names` has the numbers of what is the same in another order."""
    for name in names:
        if not ours[name] or not np.array_equal(list(ours[name].values()), list(ours[f"{name}-shuffled"].values()), equal_nan=True):
            sys.exit(f"{name}: another order gives other numbers")
