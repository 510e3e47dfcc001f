"""Numbers of `--protocol` as a run leaves them, held against what a maker's program says of the same boxes.

A table of boxes has a row for each, in the frame of the car of its scan: scan, class, x, y, z, length, width, height, yaw,
vx, vy, attribute; annotations have n_points, detections a score.
"""

import math
import sys
from pathlib import Path

import numpy as np
import pandas as pd

from program import read_json, run

LARGEST_DIFFERENCE = 1e-6
STREETS = ("street-main-road", "street-narrow", "--simulated-scans", "10")
DETECTORS = ("hierarchical", "pca")
CENTER, SIZE, VELOCITY = ["x", "y", "z"], ["length", "width", "height"], ["vx", "vy"]
Numbers = dict[tuple[str, str], float]


def made_things(drives: list[str], classes: list[str], times_s: list[float], reach_m: float, seed: int) -> pd.DataFrame:
    """Annotations of made-up drives, with sixty things that move or stand, each missing in a tenth of the scans."""
    random, n = np.random.default_rng(seed), 60 * len(drives)
    things = pd.DataFrame({"drive": np.repeat(drives, 60), "thing": np.arange(n), "class": random.choice(classes, n)})
    things[CENTER] = random.uniform((-reach_m, -reach_m, -1), (reach_m, reach_m, 2), (n, 3))
    things[SIZE], things["yaw"] = random.uniform(0.5, 5, (n, 3)), random.uniform(-np.pi, np.pi, n)
    things[VELOCITY] = random.normal(0, 3, (n, 2)) * (random.random((n, 1)) < 0.5)
    labels = things.merge(pd.DataFrame({"number": range(len(times_s)), "time_s": times_s}), how="cross")
    labels[["x", "y"]] += labels[VELOCITY].to_numpy() * labels[["time_s"]].to_numpy()
    labels["scan"] = labels["drive"] + "/" + labels["number"].astype(str).str.zfill(6)
    labels["n_points"] = random.integers(0, 3, len(labels)) * random.integers(0, 60, len(labels))
    return labels[random.random(len(labels)) > 0.1].reset_index(drop=True)


def noisy(labels: pd.DataFrame, seed: int) -> pd.DataFrame:
    """Some of the labels, moved and turned, and others that are not there."""
    random = np.random.default_rng(seed)
    found = labels.sample(frac=1.6, replace=True, random_state=seed).reset_index(drop=True)
    n, is_elsewhere = len(found), random.random((len(found), 1)) < 0.2
    found[CENTER] += random.normal(0, 0.8, (n, 3)) + is_elsewhere * random.uniform(-15, 15, (n, 3))
    found[SIZE] *= random.uniform(0.7, 1.4, (n, 3))
    found[VELOCITY] += random.normal(0, 1, (n, 2))
    turned = found["yaw"] + random.choice([0.0, np.pi, 0.3], n) + random.normal(0, 0.01, n)
    found["attribute"] = found["attribute"].where(random.random(n) < 0.7, "")
    return found.assign(yaw=(turned + np.pi) % (2 * np.pi) - np.pi, score=random.uniform(0.01, 1, n))


def in_order(found: pd.DataFrame) -> pd.DataFrame:
    """As scanbench ranks the boxes of a scan, for makers that take ties in the order of the table."""
    keyed = found.assign(minus=-found["score"])
    return keyed.sort_values(["scan", "minus", *CENTER, *SIZE, "yaw", *VELOCITY], kind="stable")[found.columns]


def cases(labels: pd.DataFrame, car: str) -> dict[str, pd.DataFrame]:
    """Detections with distinct scores, with scores alike, both in another order as well; of one class; the labels."""
    distinct, alike = noisy(labels, 1), noisy(labels, 2)
    alike["score"] = (alike["score"] * 10).round().clip(lower=1) / 10
    found = {"distinct": distinct, "alike": alike, "cars": distinct[distinct["class"] == car]}
    found["truth"] = labels[labels["n_points"] > 0].assign(score=1.0)
    found = {name: in_order(it) for name, it in found.items()}
    return found | {f"{it}-shuffled": found[it].sample(frac=1, random_state=3) for it in ("distinct", "alike")}


def numbers_of(folder: Path, protocol: str) -> dict[str, Numbers]:
    """Those of each detector by class and metric; NaN where one is undefined."""
    numbers: dict[str, Numbers] = {}
    for row in read_json(folder / "protocols.json")["rows"]:
        if row["protocol"] == protocol:
            value = math.nan if row["value"] is None else row["value"]
            numbers.setdefault(row["detector"], {})[row["class"], row["metric"]] = value
    return numbers


def numbers_of_tables(
    scanbench: str, data: Path, protocol: str, tables: dict[str, Path], folder: Path
) -> dict[str, Numbers]:
    """Those of files of detections, by name; each of a pair that differs in its order alone has the same."""
    given = [word for name, path in tables.items() for word in ("--detections", f"{name}={path}")]
    options = ["-d", ",".join(tables), "--protocol", protocol, "--missing-detections", "empty", "-o", folder / "run"]
    run(scanbench, "run", data, *given, *options, "--no-rrd")
    numbers = numbers_of(folder / "run", protocol)
    for name in (it.removesuffix("-shuffled") for it in numbers if it.endswith("-shuffled")):
        first, second = (list(numbers[it].values()) for it in (name, f"{name}-shuffled"))
        if not first or not np.array_equal(first, second, equal_nan=True):
            sys.exit(f"{name}: another order gives other numbers")
    return numbers


def found_by_ours(scanbench: str, data: Path, protocol: str, folder: Path) -> Path:
    """What a detector of ours finds, as others read it: without what is less likely a vehicle than not."""
    options = ["--detections-out", folder / "found", "--as", protocol, "-o", folder / "own", "--no-rrd"]
    run(scanbench, "run", data, "-d", "simple-grid", *options)
    return next(it for it in (folder / "found/simple-grid").rglob("*") if it.suffix in (".json", ".feather"))


def on_streets(scanbench: str, protocol: str, car: str, folder: Path) -> tuple[dict[str, Numbers], pd.DataFrame]:
    """Numbers of detectors of ours on simulated streets, of which each finds cars, and what boxes they are of.

    The boxes are in the order in which scanbench ranks them, centres from where ranges are measured.
    """
    options = ["-d", ",".join(DETECTORS), "--protocol", protocol, "-o", folder / "streets", "--no-rrd"]
    run(scanbench, "run", *STREETS, *options)
    numbers = numbers_of(folder / "streets", protocol)
    for name in DETECTORS:
        if not numbers[name][car, "ap"] > 0.0:
            sys.exit(f"{name} found no car on simulated streets")
    boxes = pd.read_csv(folder / "streets/protocol_boxes.csv").query("protocol == @protocol").rename(columns=of_columns)
    boxes["scan"] = boxes["dataset"] + "-" + boxes["sequence"].astype(str) + "/" + boxes["scan"].astype(str).str.zfill(6)
    return numbers, boxes.assign(vx=0.0, vy=0.0, attribute="")


def of_columns(name: str) -> str:
    return name.removeprefix("center_").removesuffix("_m").removesuffix("_rad")


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
