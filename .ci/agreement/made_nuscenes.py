"""A made-up data set of nuScenes, complete enough for nuscenes-devkit, and submissions on it."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from pyquaternion import Quaternion

from nuscenes_tables import NuScenesTables, Record, cloud_of, pose, upright

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
LIDAR_ON_CAR = pose([0.94, 0.0, 1.84], upright(-np.pi / 2))


@dataclass
class MadeNuScenes:
    """Where it lies, and its labels as a submission would have them, by sample."""

    folder: Path
    labels: dict[str, list[Record]] = field(default_factory=dict)
    egos: dict[str, np.ndarray] = field(default_factory=dict)


def yaw_of(quaternion: list[float]) -> float:
    return float(Quaternion(quaternion).yaw_pitch_roll[0])


def make(folder: Path, seed: int = 5) -> MadeNuScenes:
    random = np.random.default_rng(seed)
    made, tables = MadeNuScenes(folder), NuScenesTables(CATEGORIES, ATTRIBUTES, LIDAR_ON_CAR)
    (folder / "samples/LIDAR_TOP").mkdir(parents=True)
    for number, scene in enumerate(SCENES):
        make_scene(made, tables, scene, number, random)
    tables.write(folder)
    return made


def make_scene(made: MadeNuScenes, tables: NuScenesTables, scene: str, number: int, random: np.random.Generator) -> None:
    start, heading = random.normal(0, 1000, 2), random.uniform(-np.pi, np.pi)
    things = [make_thing(f"{scene}-{index}", start, random) for index in range(60)]
    for thing in things:
        tables.add_thing(thing["token"], thing["category"])
    # The fifth sample comes late, so that velocities over it are not known.
    times_us = {
        f"sample{number}{index:02}": 10**15 + number * 10**9 + index * 500_000 + (2_000_000 if index >= 5 else 0)
        for index in range(N_SAMPLES)
    }
    ahead = np.array([np.cos(heading), np.sin(heading)])
    egos = [np.array([*(start + 2.0 * index * ahead), 0.0]) for index in range(N_SAMPLES)]
    tables.add_scene(scene, times_us, [pose(it, upright(heading)) for it in egos])
    before: dict[str, Record] = {}
    for (sample, time_us), ego in zip(times_us.items(), egos):
        made.egos[sample], made.labels[sample] = ego, []
        clouds = []
        for thing in things:
            if random.random() < 0.1:
                continue
            record = add_annotation(tables, thing, sample, time_us, random)
            if thing["token"] in before:
                before[thing["token"]]["next"], record["prev"] = record["token"], before[thing["token"]]["token"]
            before[thing["token"]] = record
            clouds.append(points_of(record, ego, heading, random))
            label(made, thing, record, sample)
        np.concatenate(clouds).astype("<f4").tofile(made.folder / cloud_of(sample))


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


def add_annotation(
    tables: NuScenesTables, thing: Record, sample: str, time_us: int, random: np.random.Generator
) -> Record:
    at = np.array(thing["center"])
    at[:2] += (time_us % 10**9) * 1e-6 * thing["velocity"]
    attribute = CATEGORIES[thing["category"]][1]
    return tables.add_annotation(
        f"{thing['token']}-{sample}", thing["token"],
        sample_token=sample,
        attribute_tokens=[attribute] if attribute and random.random() < 0.9 else [],
        size=thing["size"],
        **pose(at, upright(thing["yaw"])),
        num_lidar_pts=int(random.integers(0, 3) * random.integers(0, 60)),
        num_radar_pts=int(random.integers(0, 2)),
    )  # fmt: skip


def points_of(record: Record, ego: np.ndarray, heading: float, random: np.random.Generator) -> np.ndarray:
    """Thirty points in the box, in the frame of the lidar: x right, y forward."""
    width, length, height = record["size"]
    inside = random.uniform(-0.5, 0.5, (30, 3)) * [length, width, height]
    turn = Quaternion(record["rotation"]).rotation_matrix
    world = inside @ turn.T + record["translation"] - ego
    car = world @ Quaternion(upright(heading)).rotation_matrix
    lidar = (car - LIDAR_ON_CAR["translation"]) @ Quaternion(LIDAR_ON_CAR["rotation"]).rotation_matrix
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
