"""Holds the numbers of `--protocol argoverse2` against av2: protocol_argoverse2.py SCANBENCH FOLDER [LOGS]

On simulated streets: what detectors of ours found there. On made-up logs and, if there are any, on recorded ones: made-up
detections, and those of a detector of ours. Of boxes with scores alike av2 takes those of the first sweep first, and within
a sweep those that come first in the table as long as there are few; so it is given tables in the order that scanbench
makes.
"""

import sys
from pathlib import Path

import av2.evaluation.detection.eval as av2_eval
import numpy as np
import pandas as pd
from av2.evaluation.detection.utils import DetectionCfg

from protocol_numbers import CENTER, Numbers, cases, compare, found_by_ours, made_things, numbers_of_tables, on_streets

CATEGORIES = ["REGULAR_VEHICLE", "PEDESTRIAN", "BOLLARD", "BICYCLIST", "STOP_SIGN", "LARGE_VEHICLE", "ANIMAL"]
METRICS = {"AP": "ap", "ATE": "ate_m", "ASE": "ase", "AOE": "aoe_rad", "CDS": "cds"}
# Columns of av2 beside ours.
COLUMNS = {"category": "class", "num_interior_pts": "n_points", "score": "score"}
COLUMNS |= {f"t{it}_m": it for it in CENTER} | {f"{it}_m": it for it in ("length", "width", "height")}


def as_av2(boxes: pd.DataFrame) -> pd.DataFrame:
    table = pd.DataFrame({theirs: boxes[ours] for theirs, ours in COLUMNS.items() if ours in boxes}).reset_index(drop=True)
    scan, yaw = boxes["scan"].str.split("/", expand=True).reset_index(drop=True), boxes["yaw"].to_numpy()
    table["log_id"], table["timestamp_ns"] = scan[0], scan[1].astype(int)
    table["qw"], table["qx"], table["qy"], table["qz"] = np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)
    return table.astype({it: int for it in ("num_interior_pts",) if it in table and table[it].notna().all()})


def labels_of(root: Path) -> pd.DataFrame:
    """The labels of the sweeps that are there."""
    tables = []
    for path in sorted(root.glob("*/annotations.feather")):
        sweeps = {int(it.stem) for it in path.parent.glob("sensors/lidar/*.feather")}
        table = pd.read_feather(path).rename(columns={theirs: ours for theirs, ours in COLUMNS.items()})
        table["scan"] = path.parent.name + "/" + table["timestamp_ns"].astype(str)
        table["yaw"] = 2 * np.arctan2(table["qz"], table["qw"])
        tables.append(table[table["timestamp_ns"].isin(sweeps)])
    return pd.concat(tables, ignore_index=True).assign(vx=0.0, vy=0.0, attribute="")


def make(root: Path) -> None:
    """Two logs with labels and clouds; one sweep of each has more pedestrians than are evaluated."""
    random = np.random.default_rng(11)
    labels = made_things(["log-a", "log-b"], CATEGORIES, [0.1 * it for it in range(6)], 170.0, 11)
    labels["scan"] = labels["drive"] + "/" + (315 * 10**15 + labels["number"] * 10**8).astype(str)
    crowd = labels[labels["number"] == 2].sample(n=2 * 240, replace=True, random_state=11)
    crowd[CENTER] += random.uniform(-20, 20, (len(crowd), 3))
    labels = pd.concat([labels, crowd.assign(**{"class": "PEDESTRIAN"})], ignore_index=True)
    for log, of_log in as_av2(labels).groupby("log_id"):
        (root / log / "sensors/lidar").mkdir(parents=True)
        of_log = of_log.drop(columns="log_id").reset_index(drop=True)
        of_log["track_uuid"] = [f"{log}-{index}" for index in of_log.index]
        of_log.to_feather(root / log / "annotations.feather")
        for time_ns, sweep in of_log.groupby("timestamp_ns"):
            cloud = np.repeat(sweep[["tx_m", "ty_m", "tz_m"]].to_numpy(), 30, axis=0)
            cloud = (cloud + random.uniform(-0.2, 0.2, cloud.shape)).astype(np.float16)
            points = pd.DataFrame(cloud, columns=["x", "y", "z"])
            points["intensity"], points["laser_number"], points["offset_ns"] = np.uint8(9), np.uint8(0), np.int32(0)
            points.to_feather(root / log / f"sensors/lidar/{time_ns}.feather")


def av2_numbers(found: pd.DataFrame, labels: pd.DataFrame) -> Numbers:
    # The table would be rounded to three decimals.
    av2_eval.NUM_DECIMALS = 15
    config = DetectionCfg(eval_only_roi_instances=False)
    _, _, metrics = av2_eval.evaluate(found, labels, config, n_jobs=1)
    return {
        ("all" if category == "AVERAGE_METRICS" else str(category), ours): float(row[theirs])
        for category, row in metrics.iterrows()
        for theirs, ours in METRICS.items()
    }


def check(scanbench: str, root: Path, folder: Path) -> None:
    folder.mkdir(parents=True)
    labels = labels_of(root)
    found = {name: as_av2(it.drop(columns="n_points")) for name, it in cases(labels, "REGULAR_VEHICLE").items()}
    tables = {name: folder / f"{name}.feather" for name in found}
    for name, it in found.items():
        it.to_feather(tables[name])
    tables["ours"] = found_by_ours(scanbench, root, "argoverse2", folder)
    ours = numbers_of_tables(scanbench, root, "argoverse2", tables, folder)
    found["ours"] = pd.read_feather(tables["ours"])
    theirs = {name: av2_numbers(it, as_av2(labels)) for name, it in found.items() if name != "alike-shuffled"}
    compare("argoverse2", root.name, "av2", ours, theirs, 100)


def check_streets(scanbench: str, folder: Path) -> None:
    """Detectors of ours on simulated streets, whose boxes are written as the tables of Argoverse 2."""
    ours, boxes = on_streets(scanbench, "argoverse2", "REGULAR_VEHICLE", folder)
    theirs = {}
    for name, of_detector in boxes.groupby("detector"):
        kinds = {kind: as_av2(it) for kind, it in of_detector.groupby("kind")}
        theirs[name] = av2_numbers(kinds["detection"], kinds["annotation"])
    compare("argoverse2", "simulated streets", "av2", ours, theirs, 50)


if __name__ == "__main__":
    scanbench, folder = sys.argv[1], Path(sys.argv[2])
    make(folder / "argoverse2")
    check(scanbench, folder / "argoverse2", folder / "made")
    check_streets(scanbench, folder)
    for root in sys.argv[3:]:
        check(scanbench, Path(root), folder / "recorded")
