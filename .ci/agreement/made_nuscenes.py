"""A made-up data set of nuScenes, complete enough for nuscenes-devkit, and submissions on it."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pyquaternion import Quaternion

# Scenes that the devkit takes for the split mini_val.
SCENES = ("scene-0103", "scene-0916")
N_SAMPLES = 12
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
ATTRIBUTES = sorted({attribute for _, attribute in CATEGORIES.values() if attribute})
Record = dict[str, Any]


@dataclass
class MadeNuScenes:
    """Where it lies, and its labels as a submission would have them, by sample."""

    folder: Path
    labels: dict[str, list[Record]] = field(default_factory=dict)
    egos: dict[str, np.ndarray] = field(default_factory=dict)
    tables: dict[str, list[Record]] = field(default_factory=dict)


def yaw_of(quaternion: list[float]) -> float:
    return float(Quaternion(quaternion).yaw_pitch_roll[0])


def upright(yaw: float) -> list[float]:
    return [float(np.cos(yaw / 2)), 0.0, 0.0, float(np.sin(yaw / 2))]


def make(folder: Path, seed: int = 5) -> MadeNuScenes:
    random = np.random.default_rng(seed)
    made = MadeNuScenes(folder)
    names = "log map sensor calibrated_sensor ego_pose sample sample_data sample_annotation instance category attribute visibility scene"
    made.tables = tables = {name: [] for name in names.split()}
    tables["log"] = [{"token": "log", "logfile": "", "vehicle": "n008", "date_captured": "2018-08-01", "location": "boston-seaport"}]
    tables["map"] = [{"token": "map", "log_tokens": ["log"], "category": "semantic_prior", "filename": "map.png"}]
    tables["sensor"] = [{"token": "top", "channel": "LIDAR_TOP", "modality": "lidar"}]
    calibration = {"token": "cs", "sensor_token": "top", "camera_intrinsic": []}
    tables["calibrated_sensor"] = [calibration | {"translation": [0.94, 0.0, 1.84], "rotation": upright(-np.pi / 2)}]
    tables["category"] = [{"token": name, "name": name, "description": ""} for name in CATEGORIES]
    tables["attribute"] = [{"token": name, "name": name, "description": ""} for name in ATTRIBUTES]
    tables["visibility"] = [{"token": "4", "level": "v80-100", "description": ""}]
    (folder / "samples/LIDAR_TOP").mkdir(parents=True)
    (folder / "map.png").write_bytes(b"")
    for number, scene in enumerate(SCENES):
        make_scene(made, scene, number, random)
    (folder / "v1.0-mini").mkdir()
    for name, rows in tables.items():
        (folder / f"v1.0-mini/{name}.json").write_text(json.dumps(rows))
    return made


def make_scene(made: MadeNuScenes, scene: str, number: int, random: np.random.Generator) -> None:
    tables = made.tables
    samples = [f"sample{number}{index:02}" for index in range(N_SAMPLES)]
    tables["scene"].append(
        {"token": scene, "name": scene, "description": "", "log_token": "log", "nbr_samples": N_SAMPLES}
        | {"first_sample_token": samples[0], "last_sample_token": samples[-1]}
    )
    start, heading = random.normal(0, 1000, 2), random.uniform(-np.pi, np.pi)
    things = [make_thing(f"{scene}-{index}", start, random) for index in range(60)]
    for thing in things:
        tables["instance"].append({"token": thing["token"], "category_token": thing["category"], "nbr_annotations": 0}
                                  | {"first_annotation_token": "", "last_annotation_token": ""})
    before: dict[str, Record] = {}
    for index, sample in enumerate(samples):
        # The fifth comes late, so that velocities over it are not known.
        time_us = 10**15 + number * 10**9 + index * 500_000 + (2_000_000 if index >= 5 else 0)
        ego = np.array([*(start + 2.0 * index * np.array([np.cos(heading), np.sin(heading)])), 0.0])
        made.egos[sample], made.labels[sample] = ego, []
        tables["ego_pose"].append({"token": f"pose{sample}", "timestamp": time_us, "translation": ego.tolist(), "rotation": upright(heading)})
        neighbours = {"prev": samples[index - 1] if index else "", "next": samples[index + 1] if index + 1 < N_SAMPLES else ""}
        tables["sample"].append({"token": sample, "scene_token": scene, "timestamp": time_us} | neighbours)
        file = f"samples/LIDAR_TOP/{sample}.pcd.bin"
        tables["sample_data"].append(
            {"token": f"data{sample}", "sample_token": sample, "ego_pose_token": f"pose{sample}", "calibrated_sensor_token": "cs"}
            | {"timestamp": time_us, "is_key_frame": True, "filename": file, "fileformat": "pcd", "width": 0, "height": 0, "prev": "", "next": ""}
        )
        clouds = []
        for thing in things:
            if random.random() < 0.1:
                continue
            record = annotation_of(thing, sample, time_us, random)
            if thing["token"] in before:
                before[thing["token"]]["next"], record["prev"] = record["token"], before[thing["token"]]["token"]
            before[thing["token"]] = record
            tables["sample_annotation"].append(record)
            clouds.append(points_of(record, ego, heading, random))
            label(made, thing, record, sample)
        np.concatenate(clouds).astype("<f4").tofile(made.folder / file)


def make_thing(token: str, start: np.ndarray, random: np.random.Generator) -> Record:
    category = str(random.choice(list(CATEGORIES)))
    return {
        "token": token,
        "category": category,
        "center": [*(start + random.uniform(-55, 65, 2)), random.uniform(0.5, 1.0)],
        "size": (random.uniform(2, 12, 3) if category == "static_object.bicycle_rack" else random.uniform(0.5, 5, 3)).tolist(),
        "yaw": random.uniform(-np.pi, np.pi),
        "velocity": random.normal(0, 3, 2) * (random.random() < 0.5),
    }


def annotation_of(thing: Record, sample: str, time_us: int, random: np.random.Generator) -> Record:
    seconds = (time_us % 10**9) * 1e-6
    x, y, z = thing["center"]
    attribute = CATEGORIES[thing["category"]][1]
    has_attribute = attribute and random.random() < 0.9
    return {
        "token": f"{thing['token']}-{sample}",
        "sample_token": sample,
        "instance_token": thing["token"],
        "attribute_tokens": [attribute] if has_attribute else [],
        "visibility_token": "4",
        "translation": [float(x + seconds * thing["velocity"][0]), float(y + seconds * thing["velocity"][1]), float(z)],
        "size": thing["size"],
        "rotation": upright(thing["yaw"]),
        "num_lidar_pts": int(random.integers(0, 3) * random.integers(0, 60)),
        "num_radar_pts": int(random.integers(0, 2)),
        "prev": "",
        "next": "",
    }


def points_of(record: Record, ego: np.ndarray, heading: float, random: np.random.Generator) -> np.ndarray:
    """Thirty points in the box, in the frame of the lidar: x right, y forward."""
    width, length, height = record["size"]
    inside = random.uniform(-0.5, 0.5, (30, 3)) * [length, width, height]
    turn = Quaternion(record["rotation"]).rotation_matrix
    world = inside @ turn.T + record["translation"] - ego
    car = world @ Quaternion(upright(heading)).rotation_matrix
    lidar = (car - [0.94, 0.0, 1.84]) @ Quaternion(upright(-np.pi / 2)).rotation_matrix
    return np.column_stack([lidar, np.full((30, 2), 7.0)])


def label(made: MadeNuScenes, thing: Record, record: Record, sample: str) -> None:
    name, _ = CATEGORIES[thing["category"]]
    # What holds no point is not evaluated.
    if name is not None and record["num_lidar_pts"] + record["num_radar_pts"] > 0:
        made.labels[sample].append(
            {key: record[key] for key in ("sample_token", "translation", "size", "rotation")}
            | {"velocity": [float(it) for it in thing["velocity"]], "detection_name": name, "detection_score": 1.0}
            | {"attribute_name": record["attribute_tokens"][0] if record["attribute_tokens"] else ""}
        )


def noisy(made: MadeNuScenes, seed: int, classes: set[str] | None = None, score_step: float | None = None) -> dict[str, list[Record]]:
    """Some of the labels, moved and turned, and others that are not there."""
    random = np.random.default_rng(seed)
    found: dict[str, list[Record]] = {}
    for sample, labels in made.labels.items():
        boxes = []
        for it in labels:
            for _ in range(int(random.choice([0, 1, 1, 2]))):
                boxes.append(moved(it, random))
            if random.random() < 0.5:
                elsewhere = [float(at) for at in np.array(it["translation"]) + random.uniform(-20, 20, 3)]
                boxes.append(moved(it, random) | {"translation": elsewhere})
        boxes = [it for it in boxes if classes is None or it["detection_name"] in classes]
        for it in boxes:
            score = float(random.uniform(0.01, 1.0))
            it["detection_score"] = score if score_step is None else max(round(score / score_step) * score_step, score_step)
        found[sample] = boxes
    return found


def moved(label: Record, random: np.random.Generator) -> Record:
    yaw = yaw_of(label["rotation"]) + random.choice([0.0, np.pi, random.normal(0, 0.5)])
    return label | {
        "translation": [float(it) for it in np.array(label["translation"]) + random.normal(0, 1, 3)],
        "size": [float(it) for it in np.array(label["size"]) * random.uniform(0.7, 1.4, 3)],
        "rotation": upright(float(yaw)),
        "velocity": [float(it) for it in np.array(label["velocity"]) + random.normal(0, 1, 2)],
        "attribute_name": label["attribute_name"] if random.random() < 0.7 else "",
    }


def write_submission(path: Path, found: dict[str, list[Record]]) -> None:
    meta = {f"use_{it}": it == "lidar" for it in ("camera", "lidar", "radar", "map", "external")}
    path.write_text(json.dumps({"meta": meta, "results": found}))
