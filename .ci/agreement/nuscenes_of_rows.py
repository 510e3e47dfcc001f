"""Brings what a run evaluated under nuScenes' protocol into the layout of nuScenes, for the devkit to read."""

from pathlib import Path

from made_nuscenes import CATEGORIES, SCENES
from nuscenes_tables import NuScenesTables, Record, pose, upright
from program import read_csv

CATEGORY_OF = {name: category for category, (name, _) in CATEGORIES.items() if name is not None}


def of_rows(folder: Path, rows: Path) -> dict[str, dict[str, list[Record]]]:
    """Writes the labels of `protocol_boxes.csv` as tables below `folder`; returns the detections of each detector by sample.

    Centres are from where ranges are measured, so that every sample has its car at the origin. Detections come in the
    opposite order of the rows, since the devkit takes the last of those with like scores first. It refuses scores below 0:
    all are moved alike, the least to 1.
    """
    boxes = [it for it in read_csv(rows) if it["protocol"] == "nuscenes"]
    samples = sorted({sample_of(it) for it in boxes})
    labelled = next(it["detector"] for it in boxes)
    tables = NuScenesTables(CATEGORIES, [], pose([0.0, 0.0, 0.0], upright(0.0)))
    # One scene; the split has a second one, which is empty.
    times_us = {sample: 10**15 + index * 500_000 for index, sample in enumerate(samples)}
    tables.add_scene(SCENES[0], times_us, [pose([0.0, 0.0, 0.0], upright(0.0))] * len(samples))
    for index, it in enumerate(boxes):
        if it["kind"] == "annotation" and it["detector"] == labelled:
            tables.add_thing(f"thing{index}", CATEGORY_OF[it["class"]])
            tables.add_annotation(f"label{index}", f"thing{index}", num_lidar_pts=int(it["n_points"]), **box_of(it))
    tables.write(folder)
    least = min(float(it["score"]) for it in boxes if it["kind"] == "detection")
    found: dict[str, dict[str, list[Record]]] = {}
    for detector in sorted({it["detector"] for it in boxes}):
        found[detector] = {sample: [] for sample in reversed(samples)}
    for it in reversed(boxes):
        if it["kind"] == "detection":
            score = float(it["score"]) - least + 1.0
            record = {"velocity": [0.0, 0.0], "detection_name": it["class"], "detection_score": score, "attribute_name": ""}
            found[it["detector"]][sample_of(it)].append(box_of(it) | record)
    return found


def sample_of(row: Record) -> str:
    return f"{row['dataset']}/{row['sequence']}/{int(row['scan']):06}"


def box_of(row: Record) -> Record:
    return {
        "sample_token": sample_of(row),
        "translation": [float(row[f"center_{axis}_m"]) for axis in "xyz"],
        "size": [float(row[f"{side}_m"]) for side in ("width", "length", "height")],
        "rotation": upright(float(row["yaw_rad"])),
    }
