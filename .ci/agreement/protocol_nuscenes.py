"""Holds the numbers of `--protocol nuscenes` against nuscenes-devkit, whole and through its own reading of files.

    protocol_nuscenes.py SCANBENCH FOLDER

The scenes that `nuscenes-val` has are those of the devkit. On simulated streets, brought into the layout of nuScenes box by box: what
detectors of ours found there. On a made-up data set: submissions with distinct scores, with scores alike, of one class, of one box, and the labels themselves; two of them
shuffled. The devkit cannot read one without any box. Where scores are alike the devkit takes the last of its list first, and so it is given lists in the order that scanbench makes.
"""

import math
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from nuscenes import NuScenes
from nuscenes.eval.detection.config import config_factory
from nuscenes.eval.detection.evaluate import DetectionEval
from nuscenes.utils import splits

from made_nuscenes import MadeNuScenes, make, noisy, write_submission, yaw_of
from nuscenes_of_rows import of_rows
from nuscenes_tables import Record
from program import Program
from protocol_numbers import check_order, compare, found_by_ours, numbers_of_tables, numbers_on_streets

MAKER = "nuscenes-devkit"
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


def check_made_up(program: Program, folder: Path) -> None:
    made = make(folder / "nuscenes")
    distinct, alike = noisy(made, 1), noisy(made, 2, score_step=0.1)
    cases = {
        "distinct": distinct,
        "distinct-shuffled": shuffled(distinct),
        "alike": alike,
        "alike-shuffled": shuffled(alike),
        "cars": noisy(made, 3, {"car"}),
        "one-box": {sample: distinct[sample][:1] if index == 0 else [] for index, sample in enumerate(made.labels)},
        "truth": made.labels,
    }
    for name, found in cases.items():
        write_submission(folder / f"{name}.json", found)
        write_submission(folder / f"{name}.last-first.json", last_first(made, found))
    own = {"ours": found_by_ours(program, made.folder, "nuscenes", folder)}
    results = {name: folder / f"{name}.json" for name in cases} | own
    ours = numbers_of_tables(program, made.folder, "nuscenes", results, folder)
    tables = NuScenes("v1.0-mini", str(made.folder), verbose=False)
    in_order = {name: folder / f"{name}.last-first.json" for name in cases} | own
    theirs = {name: devkit_numbers(tables, path, folder / "devkit") for name, path in in_order.items()}
    compare("nuscenes", "made-up scenes", MAKER, ours, theirs, 500)
    check_order(ours, ("distinct", "alike"))
    if ours["truth"]["present", "ap"] != 1.0:
        sys.exit(f"the labels themselves have an AP of {ours['truth']['present', 'ap']}")


def check_streets(program: Program, folder: Path) -> None:
    """Detectors of ours on simulated streets, whose boxes are written as the tables and submissions of nuScenes."""
    ours = numbers_on_streets(program, "nuscenes", "car", folder)
    converted = of_rows(folder / "converted", folder / "streets/protocol_boxes.csv")
    tables = NuScenes("v1.0-mini", str(folder / "converted"), verbose=False)
    theirs = {}
    for name, found in converted.items():
        write_submission(folder / f"{name}.json", found)
        of_devkit = devkit_numbers(tables, folder / f"{name}.json", folder / "devkit")
        # What is not labelled has no number with us, and the worst one with the devkit.
        unknown = {key for key, it in ours[name].items() if math.isnan(it) and of_devkit.get(key) in (0.0, 1.0)}
        theirs[name] = {key: it for key, it in of_devkit.items() if key not in unknown}
    compare("nuscenes", "simulated streets", MAKER, ours, theirs, 60)


def check_scenes() -> None:
    """The scenes of the data set `nuscenes-val`."""
    catalogue = tomllib.loads((Path(__file__).parents[2] / "datasets.toml").read_text())
    ours = catalogue["recorded"]["nuscenes-val"]["sequences"]
    if sorted(ours) != sorted(splits.val):
        sys.exit(f"nuscenes-val has {len(ours)} scenes, which are not the {len(splits.val)} of the devkit")
    print(f"  nuscenes: the {len(ours)} scenes of nuscenes-val are those of {MAKER}")


if __name__ == "__main__":
    check_scenes()
    program, folder = Program(Path(sys.argv[1])), Path(sys.argv[2])
    check_made_up(program, folder)
    check_streets(program, folder)
