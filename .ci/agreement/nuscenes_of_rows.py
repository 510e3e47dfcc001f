"""Brings what a run evaluated under nuScenes' protocol into the layout of nuScenes, for the devkit to read."""

import csv
import json
from pathlib import Path

from made_nuscenes import CATEGORIES, SCENES, Record, upright

CATEGORY_OF = {name: category for category, (name, _) in CATEGORIES.items() if name is not None}


def of_rows(folder: Path, rows: Path) -> dict[str, dict[str, list[Record]]]:
    """Writes the labels of `protocol_boxes.csv` as tables below `folder`; returns the detections of each detector by sample.

    Centres are from where ranges are measured, so that every sample has its car at the origin. Detections come in the opposite order of
    the rows, since the devkit takes the last of those with like scores first. It refuses scores below 0: all are moved alike, the least to 1.
    """
    with rows.open() as file:
        boxes = [it for it in csv.DictReader(file) if it["protocol"] == "nuscenes"]
    samples = sorted({sample_of(it) for it in boxes})
    labelled = next(it["detector"] for it in boxes)
    labels = [it for it in boxes if it["kind"] == "annotation" and it["detector"] == labelled]
    tables = tables_of(samples)
    tables["instance"] = [
        {"token": f"thing{index}", "category_token": CATEGORY_OF[it["class"]], "nbr_annotations": 1}
        | {"first_annotation_token": f"label{index}", "last_annotation_token": f"label{index}"}
        for index, it in enumerate(labels)
    ]
    tables["sample_annotation"] = [
        box_of(it)
        | {"token": f"label{index}", "instance_token": f"thing{index}", "attribute_tokens": [], "visibility_token": "4"}
        | {"num_lidar_pts": int(it["n_points"]), "num_radar_pts": 0, "prev": "", "next": ""}
        for index, it in enumerate(labels)
    ]
    (folder / "v1.0-mini").mkdir(parents=True)
    (folder / "map.png").write_bytes(b"")
    for name, records in tables.items():
        (folder / f"v1.0-mini/{name}.json").write_text(json.dumps(records))
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


def tables_of(samples: list[str]) -> dict[str, list[Record]]:
    """Everything but labels: one scene, in which nothing follows anything, and a second that is empty."""
    names = [it for it in CATEGORIES]
    tables: dict[str, list[Record]] = {
        "log": [{"token": "log", "logfile": "", "vehicle": "n008", "date_captured": "2018-08-01", "location": "boston-seaport"}],
        "map": [{"token": "map", "log_tokens": ["log"], "category": "semantic_prior", "filename": "map.png"}],
        "sensor": [{"token": "top", "channel": "LIDAR_TOP", "modality": "lidar"}],
        "category": [{"token": it, "name": it, "description": ""} for it in names],
        "attribute": [],
        "visibility": [{"token": "4", "level": "v80-100", "description": ""}],
    }
    calibration = {"token": "cs", "sensor_token": "top", "camera_intrinsic": []}
    tables["calibrated_sensor"] = [calibration | {"translation": [0.0, 0.0, 0.0], "rotation": upright(0.0)}]
    tables["scene"] = [
        {"token": SCENES[0], "name": SCENES[0], "description": "", "log_token": "log", "nbr_samples": len(samples)}
        | {"first_sample_token": samples[0], "last_sample_token": samples[-1]}
    ]
    times = {sample: 10**15 + index * 500_000 for index, sample in enumerate(samples)}
    tables["sample"] = [{"token": it, "scene_token": SCENES[0], "timestamp": times[it], "prev": "", "next": ""} for it in samples]
    tables["ego_pose"] = [
        {"token": f"pose{it}", "timestamp": times[it], "translation": [0.0, 0.0, 0.0], "rotation": upright(0.0)} for it in samples
    ]
    tables["sample_data"] = [
        {"token": f"data{it}", "sample_token": it, "ego_pose_token": f"pose{it}", "calibrated_sensor_token": "cs", "filename": ""}
        | {"timestamp": times[it], "is_key_frame": True, "fileformat": "pcd", "width": 0, "height": 0, "prev": "", "next": ""}
        for it in samples
    ]
    return tables
