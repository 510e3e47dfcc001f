"""Holds the numbers of `--protocol argoverse2` against av2.

    protocol_argoverse2.py SCANBENCH FOLDER [LOGS]

On simulated streets, brought into the layout of Argoverse 2 box by box: what detectors of ours found there. On a made-up data set of logs
and, if there is one, a recorded one: tables of detections with distinct scores, with scores alike, of one
class, of nothing, and the labels themselves; one of them shuffled. Of boxes with scores alike av2 takes those of the first sweep first, and
within a sweep those that come first in the table as long as there are few; so it is given tables in the order that scanbench makes.
"""

import sys
from pathlib import Path

import av2.evaluation.detection.eval as av2_eval
import numpy as np
import pandas as pd
from av2.evaluation.detection.utils import DetectionCfg

from program import Program
from protocol_numbers import check_order, compare, found_by_ours, numbers_of_tables, numbers_on_streets

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
            table.insert(0, "track_uuid", [f"{log}-{index}" for index in range(len(table))])
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


def check(program: Program, root: Path, labels: pd.DataFrame, folder: Path) -> None:
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
    results = {name: folder / f"{name}.feather" for name in cases}
    results["ours"] = found_by_ours(program, root, "argoverse2", folder)
    ours = numbers_of_tables(program, root, "argoverse2", results, folder)
    cases["ours"] = pd.read_feather(results["ours"])
    theirs = {name: av2_numbers(found, labels) for name, found in cases.items() if name != "alike-shuffled"}
    compare("argoverse2", root.name, "av2", ours, theirs, 100)
    check_order(ours, ("distinct", "alike"))


def check_streets(program: Program, folder: Path) -> None:
    """Detectors of ours on simulated streets, whose boxes are written as the tables of Argoverse 2."""
    ours = numbers_on_streets(program, "argoverse2", "REGULAR_VEHICLE", folder)
    # Its rows are in the order in which scanbench ranks boxes.
    rows = pd.read_csv(folder / "streets/protocol_boxes.csv")
    rows = rows.assign(log_id=rows["dataset"] + "/" + rows["sequence"].astype(str), timestamp_ns=rows["scan"], category=rows["class"])
    rows = rows.assign(num_interior_pts=rows["n_points"], qw=np.cos(rows["yaw_rad"] / 2), qx=0.0, qy=0.0, qz=np.sin(rows["yaw_rad"] / 2))
    rows = rows.rename(columns={f"center_{axis}_m": f"t{axis}_m" for axis in "xyz"})
    theirs = {}
    for name, of_detector in rows.groupby("detector"):
        kinds = {kind: it.reset_index(drop=True) for kind, it in of_detector.groupby("kind")}
        theirs[name] = av2_numbers(kinds["detection"], kinds["annotation"].astype({"num_interior_pts": int}))
    compare("argoverse2", "simulated streets", "av2", ours, theirs, 50)


def main(program: Program, folder: Path, recorded: list[str]) -> None:
    made = folder / "argoverse2"
    check(program, made, make(made), folder / "made")
    check_streets(program, folder)
    for root in map(Path, recorded):
        check(program, root, labels_of(root), folder / "recorded")


if __name__ == "__main__":
    main(Program(Path(sys.argv[1])), Path(sys.argv[2]), sys.argv[3:])
