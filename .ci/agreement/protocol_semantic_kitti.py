"""Holds panoptic and unknown quality of `--protocol semantic-kitti` against semantic-kitti-api, on a simulated drive.

    PYTHONPATH=.ci protocol_semantic_kitti.py SCANBENCH API FOLDER

It needs what requirements-argoverse2.txt has. API is a checkout of PRBonn/semantic-kitti-api, of which auxiliary/eval_np.py
and config/semantic-kitti.yaml are read. Evaluated are the labels themselves after instances were cut, left out and called
something else, once and twice.
"""

import re
import sys
from pathlib import Path

import numpy as np

from program import run
from protocol_numbers import Numbers, compare, numbers_of_tables

THINGS = ["car", "bicycle", "motorcycle", "truck", "other-vehicle", "person", "bicyclist", "motorcyclist"]
N_CLASSES = 20
Scan = tuple[np.ndarray, np.ndarray]


def spoilt(labels: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Of every instance some points less, some the halves of two, some another class; and some that are not there."""
    found = labels.copy()
    for label in np.unique(labels[labels >> 16 > 0]):
        points = np.flatnonzero(labels == label)
        match random.integers(0, 5):
            case 0:
                found[points] = 50
            case 1:
                found[points[: len(points) // 2]] = (label & 0xFFFF) | (60_000 << 16)
            case 2:
                found[points] = 18 | (label & 0xFFFF0000)
            case 3:
                found[random.choice(points, len(points) // 3)] = 40
    walls = np.flatnonzero(labels & 0xFFFF == 50)
    found[walls[:200]] = 10 | (61_000 << 16)
    return found


def api_numbers(api: Path, scans: list[Scan]) -> Numbers:
    sys.path.insert(0, str(api / "auxiliary"))
    from eval_np import PanopticEval

    table = (api / "config/semantic-kitti.yaml").read_text().split("learning_map:")[1].split("learning_map_inv:")[0]
    classes = np.zeros(1 << 16, dtype=np.int64)
    for label, number in re.findall(r"^\s+(\d+)\s*:\s*(\d+)", table, re.MULTILINE):
        classes[int(label)] = int(number)
    panoptic, unknown = PanopticEval(N_CLASSES, ignore=[0], min_points=50), PanopticEval(3, ignore=[0], min_points=1)
    for labels, found in scans:
        # Points of things without an instance are segments of their own for the api, as for us.
        panoptic.addBatch(*(it[None] for it in (classes[found & 0xFFFF], found, classes[labels & 0xFFFF], labels)))
        of_labels = np.where(classes[labels & 0xFFFF] == 0, 0, np.where(labels >> 16 > 0, 1, 2))
        of_found = np.where(found >> 16 > 0, 1, 2)
        things = np.where(of_found == 1, found, 0), np.where(of_labels == 1, labels, 0)
        unknown.addBatch(*(it[None] for it in (of_found, things[0], of_labels, things[1])))
    _, _, _, *by_class = panoptic.getPQ()
    numbers: Numbers = {}
    for number, name in enumerate(THINGS, start=1):
        if panoptic.pan_tp[number] + panoptic.pan_fp[number] + panoptic.pan_fn[number] > 0:
            numbers |= {(name, metric): float(it[number]) for metric, it in zip(("pq", "sq", "rq"), by_class, strict=True)}
    numbers["all", "pq"] = float(np.mean(by_class[0][1:9]))
    n = unknown.pan_tp[1] + unknown.pan_fn[1]
    numbers["all", "unknown_recall"] = float(unknown.pan_tp[1] / n)
    numbers["all", "unknown_quality"] = float(unknown.pan_iou[1] / n)
    return numbers


def main(scanbench: str, api: Path, folder: Path) -> None:
    street = ["street-main-road", "--simulated-scans", "6", "--sensor", "vlp-16", "--to", "semantic-kitti"]
    run(scanbench, "data", "simulate", *street, "-o", folder / "drive")
    random = np.random.default_rng(7)
    scans: dict[str, list[Scan]] = {"spoilt": [], "more-spoilt": []}
    for path in sorted((folder / "drive").rglob("labels/*.label")):
        labels = np.fromfile(path, dtype=np.uint32).astype(np.int64)
        found = labels
        for name, of_detector in scans.items():
            found = spoilt(found, random)
            of_detector.append((labels, found))
            written = folder / name / "sequences" / path.parent.parent.name / "predictions" / path.name
            written.parent.mkdir(parents=True, exist_ok=True)
            found.astype(np.uint32).tofile(written)
    ours = numbers_of_tables(scanbench, folder / "drive", "semantic-kitti", {name: folder / name for name in scans}, folder)
    theirs = {name: api_numbers(api, of_detector) for name, of_detector in scans.items()}
    compare("semantic-kitti", "a simulated drive", "semantic-kitti-api", ours, theirs, 20)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
