"""Data sets in the layout of nuScenes with all that its devkit wants to find in them, and submissions."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

Record = dict[str, Any]
# The class and the attribute of a category.
CATEGORIES = {
    "vehicle.car": ("car", "vehicle.parked"),
    "vehicle.truck": ("truck", "vehicle.moving"),
    "vehicle.bus.rigid": ("bus", "vehicle.stopped"),
    "vehicle.construction": ("construction_vehicle", "vehicle.parked"),
    "human.pedestrian.adult": ("pedestrian", "pedestrian.moving"),
    "vehicle.motorcycle": ("motorcycle", "cycle.with_rider"),
    "vehicle.bicycle": ("bicycle", "cycle.without_rider"),
    "movable_object.trafficcone": ("traffic_cone", ""),
    "movable_object.barrier": ("barrier", ""),
    "static_object.bicycle_rack": (None, ""),
    "animal": (None, ""),
}
CATEGORY_OF = {name: category for category, (name, _) in CATEGORIES.items() if name}
ATTRIBUTES = sorted({attribute for _, attribute in CATEGORIES.values() if attribute})


def upright(yaw: float) -> list[float]:
    """A turn about z as a quaternion: w, x, y, z."""
    return [float(np.cos(yaw / 2)), 0.0, 0.0, float(np.sin(yaw / 2))]


def pose(translation: Iterable[float], rotation: Iterable[float]) -> Record:
    return {"translation": [float(it) for it in translation], "rotation": [float(it) for it in rotation]}


def cloud_of(sample: str) -> str:
    return f"samples/LIDAR_TOP/{sample}.pcd.bin"


def records_of(boxes: pd.DataFrame, egos: dict[str, np.ndarray]) -> list[Record]:
    """Boxes of a table of protocol_numbers.py, as annotations and detections have them. `egos` are where the car was."""
    return [
        {"sample_token": it["scan"], "size": [it["width"], it["length"], it["height"]]}
        | pose(egos[it["scan"]] + [it["x"], it["y"], it["z"]], upright(it["yaw"]))
        for it in boxes.to_dict("records")
    ]


def write_tables(
    folder: Path, scenes: dict[str, dict[str, tuple[int, Record]]], annotations: list[Record], lidar_on_car: Record
) -> None:
    """Scenes by name, with the time in microseconds and the pose of the car at each sample.

    An annotation has at least its sample, pose and size, and the name and category of its `thing`.
    """
    tables: dict[str, list[Record]] = {
        "log": [{"token": "log", "logfile": "", "vehicle": "n008", "date_captured": "2018-08-01",
                 "location": "boston-seaport"}],
        "map": [{"token": "map", "log_tokens": ["log"], "category": "semantic_prior", "filename": "map.png"}],
        "sensor": [{"token": "top", "channel": "LIDAR_TOP", "modality": "lidar"}],
        "calibrated_sensor": [{"token": "cs", "sensor_token": "top", "camera_intrinsic": []} | lidar_on_car],
        "visibility": [{"token": "4", "level": "v80-100", "description": ""}],
        "category": [{"token": it, "name": it, "description": ""} for it in CATEGORIES],
        "attribute": [{"token": it, "name": it, "description": ""} for it in ATTRIBUTES],
    }  # fmt: skip
    tables |= {it: [] for it in ("ego_pose", "scene", "sample", "sample_data", "sample_annotation", "instance")}
    for name, samples in scenes.items():
        tokens = list(samples)
        scene = {"token": name, "name": name, "description": "", "log_token": "log", "nbr_samples": len(tokens)}
        tables["scene"].append(scene | {"first_sample_token": tokens[0], "last_sample_token": tokens[-1]})
        for before, (sample, (time_us, ego)), after in zip(["", *tokens], samples.items(), [*tokens[1:], ""]):
            at, around = {"timestamp": time_us}, {"prev": before, "next": after}
            tables["ego_pose"].append({"token": f"pose{sample}"} | at | ego)
            tables["sample"].append({"token": sample, "scene_token": name} | at | around)
            of_sample = {"sample_token": sample, "ego_pose_token": f"pose{sample}", "calibrated_sensor_token": "cs"}
            file = {"filename": cloud_of(sample), "fileformat": "pcd", "width": 0, "height": 0, "prev": "", "next": ""}
            tables["sample_data"].append({"token": f"data{sample}", "is_key_frame": True} | at | of_sample | file)
    last: dict[str, Record] = {}
    for index, given in enumerate(annotations):
        known = {"attribute_tokens": [], "num_lidar_pts": 0, "num_radar_pts": 0, "prev": "", "next": ""}
        record = known | given | {"token": f"label{index}", "instance_token": given["thing"], "visibility_token": "4"}
        if given["thing"] in last:
            record["prev"], last[given["thing"]]["next"] = last[given["thing"]]["token"], record["token"]
        else:
            thing = {"token": given["thing"], "category_token": given["category"], "nbr_annotations": 0}
            tables["instance"].append(thing | {"first_annotation_token": "", "last_annotation_token": ""})
        last[given["thing"]] = record
        tables["sample_annotation"].append(record)
    (folder / "v1.0-mini").mkdir(parents=True)
    (folder / "map.png").write_bytes(b"")
    for name, records in tables.items():
        (folder / f"v1.0-mini/{name}.json").write_text(json.dumps(records))


def write_submission(path: Path, found: pd.DataFrame, egos: dict[str, np.ndarray]) -> None:
    """Samples and their boxes in the order of the table, then those without any."""
    results: dict[str, list[Record]] = {}
    for record, it in zip(records_of(found, egos), found.to_dict("records")):
        record |= {"velocity": [it["vx"], it["vy"]], "detection_name": it["class"], "detection_score": it["score"]}
        results.setdefault(it["scan"], []).append(record | {"attribute_name": it["attribute"]})
    meta = {f"use_{it}": it == "lidar" for it in ("camera", "lidar", "radar", "map", "external")}
    path.write_text(json.dumps({"meta": meta, "results": results | {it: [] for it in egos if it not in results}}))
