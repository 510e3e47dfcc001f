"""Holds the numbers of `--protocol nuscenes` against nuscenes-devkit, whole and through its own reading of files.

    protocol_nuscenes.py SCANBENCH FOLDER

On a made-up data set: submissions with distinct scores, with scores alike, of one class, of one box, and the labels themselves; two of them
shuffled. The devkit cannot read one without any box. Where scores are alike the devkit takes the last of its list first, and so it is given lists in the order that scanbench makes.
"""

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from nuscenes import NuScenes
from nuscenes.eval.detection.config import config_factory
from nuscenes.eval.detection.evaluate import DetectionEval

from made_nuscenes import MadeNuScenes, Record, make, noisy, write_submission, yaw_of

LARGEST_DIFFERENCE = 1e-6
ERRORS = {"ate_m": "trans_err", "ase": "scale_err", "aoe_rad": "orient_err", "ave_m_per_s": "vel_err", "aae": "attr_err"}
Found = dict[str, list[Record]]


def last_first(made: MadeNuScenes, found: Found) -> Found:
    """In the order in which the devkit takes ties as scanbench does: the last scan and the last box first."""

    def key(it: Record) -> Any:
        center = [float(a - b) for a, b in zip(it["translation"], made.egos[it["sample_token"]])]
        width, length, height = it["size"]
        return -it["detection_score"], *center, length, width, height, yaw_of(it["rotation"]), *it["velocity"]

    return {sample: sorted(found[sample], key=key)[::-1] for sample in sorted(found, reverse=True)}


def shuffled(found: Found) -> Found:
    random = np.random.default_rng(3)
    return {sample: [found[sample][it] for it in random.permutation(len(found[sample]))] for sample in random.permutation(sorted(found))}


def devkit_numbers(tables: NuScenes, path: Path, scratch: Path) -> dict[tuple[str, str], float]:
    config = config_factory("detection_cvpr_2019")
    metrics, _ = DetectionEval(tables, config, str(path), "mini_val", str(scratch), verbose=False).evaluate()
    numbers: dict[tuple[str, str], float] = {("all", "ap"): metrics.mean_ap, ("all", "nds"): metrics.nd_score}
    for ours, theirs in ERRORS.items():
        numbers["all", ours] = metrics.tp_errors[theirs]
    for name in config.class_names:
        numbers[name, "ap"] = metrics.mean_dist_aps[name]
        for distance in config.dist_ths:
            numbers[name, f"ap_{distance:g}m"] = metrics.get_label_ap(name, distance)
        for ours, theirs in ERRORS.items():
            numbers[name, ours] = metrics.get_label_tp(name, theirs)
    return numbers


def main(scanbench: str, folder: Path) -> None:
    made = make(folder / "nuscenes")
    distinct, alike = noisy(made, 1), noisy(made, 2, score_step=0.1)
    cases = {
        "distinct": distinct,
        "distinct-shuffled": shuffled(distinct),
        "alike": alike,
        "alike-shuffled": shuffled(alike),
        "cars": noisy(made, 3, {"car"}),
        "one-box": {sample: distinct[sample][:1] if place == 0 else [] for place, sample in enumerate(made.labels)},
        "truth": made.labels,
    }
    for name, found in cases.items():
        write_submission(folder / f"{name}.json", found)
        write_submission(folder / f"{name}.last-first.json", last_first(made, found))
    results = [word for name in cases for word in ("--detections", f"{name}={folder / name}.json")]
    # What one of ours finds, as others read it: without what is less likely a vehicle than not.
    own = ["ours"]
    command = [scanbench, "run", str(made.folder), "-d", "simple-grid", "--no-rrd"]
    command += ["--detections-out", str(folder / "found"), "--as", "nuscenes", "-o", str(folder / "own")]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    results += ["--detections", f"{own[0]}={folder}/found/simple-grid/results_nusc.json"]
    command = [scanbench, "run", str(made.folder), *results, "-d", ",".join([*cases, *own]), "--protocol", "nuscenes", "--no-rrd"]
    command += ["-o", str(folder / "run")]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    rows = json.loads((folder / "run/protocols.json").read_text())["rows"]
    tables = NuScenes("v1.0-mini", str(made.folder), verbose=False)
    worst, n = 0.0, 0
    for name in [*cases, *own]:
        path = folder / f"{name}.last-first.json" if name in cases else folder / "found/simple-grid/results_nusc.json"
        theirs = devkit_numbers(tables, path, folder / "devkit")
        for row in rows:
            key = row["class"], row["metric"]
            if row["detector"] != name or key not in theirs:
                continue
            number = math.nan if row["value"] is None else row["value"]
            if math.isnan(number) and math.isnan(theirs[key]):
                continue
            difference = abs(number - theirs[key])
            if not difference <= LARGEST_DIFFERENCE:
                sys.exit(f"{name}: {key} is {row['value']}, nuscenes-devkit says {theirs[key]}")
            worst, n = max(worst, difference), n + 1
    ours = {(row["detector"], row["class"], row["metric"]): row["value"] for row in rows}
    for name in ("distinct", "alike"):
        same = [ours[name, *key] == value for (detector, *key), value in ours.items() if detector == f"{name}-shuffled"]
        if not same or not all(same):
            sys.exit(f"{name}: another order gives other numbers")
    if ours["truth", "present", "ap"] != 1.0:
        sys.exit(f"the labels themselves have an AP of {ours['truth', 'present', 'ap']}")
    if n < 500:
        sys.exit(f"only {n} numbers were compared")
    print(f"  nuscenes: {n} numbers of {len(cases) + len(own)} detectors as nuscenes-devkit has them, largest difference {worst:.1e}")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
