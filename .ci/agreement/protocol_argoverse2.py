"""Holds the numbers of `--protocol argoverse2` against av2.

    protocol_argoverse2.py SCANBENCH FOLDER [LOGS]

On a made-up data set of logs and, if there is one, a recorded one: tables of detections with distinct scores, with scores alike, of one
class, of nothing, and the labels themselves; one of them shuffled. Of boxes with scores alike av2 takes those of the first sweep first, and
within a sweep those that come first in the table as long as there are few; so it is given tables in the order that scanbench makes.
"""

import json
import subprocess
import sys
from pathlib import Path

import av2.evaluation.detection.eval as av2_eval
import numpy as np
import pandas as pd
from av2.evaluation.detection.utils import DetectionCfg

LARGEST_DIFFERENCE = 1e-6
CATEGORIES = ["REGULAR_VEHICLE", "PEDESTRIAN", "BOLLARD", "BICYCLIST", "STOP_SIGN", "LARGE_VEHICLE", "ANIMAL"]
POSE = ["tx_m", "ty_m", "tz_m", "qw", "qx", "qy", "qz"]
SIDES = ["length_m", "width_m", "height_m"]
METRICS = {"AP": "ap", "ATE": "ate_m", "ASE": "ase", "AOE": "aoe_rad", "CDS": "cds"}


def boxes(random: np.random.Generator, n: int, reach: float = 170.0) -> pd.DataFrame:
    yaw = random.uniform(-np.pi, np.pi, n)
    table = pd.DataFrame({name: random.uniform(-reach, reach, n) for name in ("tx_m", "ty_m")})
    table["tz_m"] = random.uniform(-1, 2, n)
    table["qw"], table["qx"], table["qy"], table["qz"] = np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)
    for name in SIDES:
        table[name] = random.uniform(0.5, 5, n)
    return table


def make(root: Path) -> pd.DataFrame:
    """Logs with labels and clouds; returns the labels."""
    random = np.random.default_rng(11)
    logs = []
    for log in ("log-a", "log-b"):
        folder = root / log
        (folder / "sensors/lidar").mkdir(parents=True)
        sweeps = []
        for number in range(6):
            time_ns = 315_000_000_000_000_000 + number * 100_000_000
            # One sweep has more pedestrians than are evaluated.
            categories = random.choice(CATEGORIES, 80).tolist() + ["PEDESTRIAN"] * (120 if number == 2 else 0)
            table = boxes(random, len(categories))
            table.insert(0, "category", categories)
            table.insert(0, "track_uuid", [f"{log}-{place}" for place in range(len(table))])
            table.insert(0, "timestamp_ns", time_ns)
            table["num_interior_pts"] = random.integers(0, 40, len(table)) * (random.random(len(table)) < 0.9)
            sweeps.append(table)
            cloud = np.repeat(table[POSE[:3]].to_numpy(), 30, axis=0) + random.uniform(-0.2, 0.2, (30 * len(table), 3))
            points = pd.DataFrame(cloud.astype(np.float16), columns=["x", "y", "z"])
            points["intensity"], points["laser_number"], points["offset_ns"] = np.uint8(9), np.uint8(0), np.int32(0)
            points.to_feather(folder / f"sensors/lidar/{time_ns}.feather")
        labels = pd.concat(sweeps, ignore_index=True)
        labels.to_feather(folder / "annotations.feather")
        logs.append(labels.assign(log_id=log))
    return pd.concat(logs, ignore_index=True)


def labels_of(root: Path) -> pd.DataFrame:
    """The labels of the sweeps that are there."""
    tables = []
    for path in sorted(root.glob("*/annotations.feather")):
        sweeps = {int(it.stem) for it in path.parent.glob("sensors/lidar/*.feather")}
        table = pd.read_feather(path)
        tables.append(table[table["timestamp_ns"].isin(sweeps)].assign(log_id=path.parent.name))
    return pd.concat(tables, ignore_index=True)


def noisy(labels: pd.DataFrame, seed: int) -> pd.DataFrame:
    """Some of the labels, moved and turned, and others that are not there."""
    random = np.random.default_rng(seed)
    found = labels.sample(frac=1.6, replace=True, random_state=seed).reset_index(drop=True)
    n = len(found)
    for name in POSE[:3]:
        found[name] += random.normal(0, 0.8, n) + (random.random(n) < 0.2) * random.uniform(-15, 15, n)
    for name in SIDES:
        found[name] *= random.uniform(0.7, 1.4, n)
    yaw = 2 * np.arctan2(found["qz"], found["qw"]) + random.choice([0.0, np.pi, 0.3], n)
    found["qw"], found["qx"], found["qy"], found["qz"] = np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)
    return found.assign(score=random.uniform(0, 1, n))


def in_order(found: pd.DataFrame) -> pd.DataFrame:
    """As scanbench ranks the boxes of a sweep."""
    yaw = 2 * np.arctan2(found["qz"], found["qw"])
    keyed = found.assign(minus=-found["score"], yaw=(yaw + np.pi) % (2 * np.pi) - np.pi)
    return keyed.sort_values(["minus", *POSE[:3], *SIDES, "yaw"], kind="stable")[found.columns]


def av2_numbers(found: pd.DataFrame, labels: pd.DataFrame) -> dict[tuple[str, str], float]:
    # The table would be rounded to three decimals.
    av2_eval.NUM_DECIMALS = 15
    config = DetectionCfg(eval_only_roi_instances=False)
    columns = ["log_id", "timestamp_ns", "category", *POSE, *SIDES]
    _, _, metrics = av2_eval.evaluate(found[[*columns, "score"]], labels[[*columns, "num_interior_pts"]], config, n_jobs=1)
    numbers = {}
    for category, row in metrics.iterrows():
        for theirs, ours in METRICS.items():
            numbers["all" if category == "AVERAGE_METRICS" else str(category), ours] = float(row[theirs])
    return numbers


def check(scanbench: str, root: Path, labels: pd.DataFrame, folder: Path) -> tuple[int, float]:
    distinct, alike = noisy(labels, 1), noisy(labels, 2)
    alike["score"] = (alike["score"] * 10).round() / 10
    truth = labels[labels["num_interior_pts"] > 0].assign(score=1.0)
    cases = {
        "distinct": distinct,
        "distinct-shuffled": distinct.sample(frac=1, random_state=3),
        "alike": in_order(alike),
        "alike-shuffled": alike.sample(frac=1, random_state=3),
        "cars": distinct[distinct["category"] == "REGULAR_VEHICLE"],
        "truth": in_order(truth),
    }
    folder.mkdir()
    columns = ["log_id", "timestamp_ns", "category", "score", *POSE, *SIDES]
    for name, found in cases.items():
        found[columns].reset_index(drop=True).to_feather(folder / f"{name}.feather")
    results = [word for name in cases for word in ("--detections", f"{name}={folder / name}.feather")]
    # What one of ours finds, as others read it: without what is less likely a vehicle than not.
    own = ["ours"]
    command = [scanbench, "run", str(root), "-d", "simple-grid", "--no-rrd"]
    command += ["--detections-out", str(folder / "found"), "--as", "argoverse2", "-o", str(folder / "own")]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    results += ["--detections", f"{own[0]}={next((folder / 'found/simple-grid').rglob('*.feather'))}"]
    command = [scanbench, "run", str(root), *results, "-d", ",".join([*cases, *own]), "--protocol", "argoverse2", "--no-rrd"]
    command += ["--missing-detections", "empty", "-o", str(folder / "run")]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    rows = json.loads((folder / "run/protocols.json").read_text())["rows"]
    worst, n = 0.0, 0
    for name in [*cases, *own]:
        if name.endswith("-shuffled") and name != "distinct-shuffled":
            continue
        found = cases[name] if name in cases else pd.read_feather(next((folder / "found/simple-grid").rglob("*.feather")))
        theirs = av2_numbers(found, labels)
        for row in rows:
            key = row["class"], row["metric"]
            if row["detector"] == name and key in theirs:
                difference = abs(row["value"] - theirs[key])
                if not difference <= LARGEST_DIFFERENCE:
                    sys.exit(f"{name}: {key} is {row['value']}, av2 says {theirs[key]}")
                worst, n = max(worst, difference), n + 1
    ours = {(row["detector"], row["class"], row["metric"]): row["value"] for row in rows}
    for name in ("distinct", "alike"):
        same = [ours[name, *key] == value for (detector, *key), value in ours.items() if detector == f"{name}-shuffled"]
        if not same or not all(same):
            sys.exit(f"{name}: another order gives other numbers")
    print(f"  argoverse2: {n} numbers of {len(cases) + len(own)} detectors on {root.name} as av2 has them, largest difference {worst:.1e}")
    return n, worst


def main(scanbench: str, folder: Path, recorded: list[str]) -> None:
    made = folder / "argoverse2"
    n, _ = check(scanbench, made, make(made), folder / "made")
    if n < 100:
        sys.exit(f"only {n} numbers were compared")
    for root in map(Path, recorded):
        check(scanbench, root, labels_of(root), folder / "recorded")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), sys.argv[3:])
