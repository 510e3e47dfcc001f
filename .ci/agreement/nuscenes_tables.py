"""The tables of a data set of nuScenes, with all that its devkit wants to find in them."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

Record = dict[str, Any]
TABLES = """log map sensor calibrated_sensor ego_pose scene sample sample_data sample_annotation instance category attribute
visibility"""


def upright(yaw: float) -> list[float]:
    """A turn about z as a quaternion: w, x, y, z."""
    return [float(np.cos(yaw / 2)), 0.0, 0.0, float(np.sin(yaw / 2))]


def pose(translation: Iterable[float], rotation: Iterable[float]) -> Record:
    return {"translation": [float(it) for it in translation], "rotation": [float(it) for it in rotation]}


class NuScenesTables:
    """Scenes of one lidar, whose pose on the car is given."""

    def __init__(self, categories: Iterable[str], attributes: Iterable[str], lidar_on_car: Record) -> None:
        self.records: dict[str, list[Record]] = {name: [] for name in TABLES.split()}
        self.add("log", "log", logfile="", vehicle="n008", date_captured="2018-08-01", location="boston-seaport")
        self.add("map", "map", log_tokens=["log"], category="semantic_prior", filename="map.png")
        self.add("sensor", "top", channel="LIDAR_TOP", modality="lidar")
        self.add("calibrated_sensor", "cs", sensor_token="top", camera_intrinsic=[], **lidar_on_car)
        self.add("visibility", "4", level="v80-100", description="")
        for table, names in (("category", categories), ("attribute", attributes)):
            for name in names:
                self.add(table, name, name=name, description="")

    def add(self, table: str, token: str, **others: Any) -> Record:
        self.records[table].append({"token": token, **others})
        return self.records[table][-1]

    def add_scene(self, name: str, times_us: dict[str, int], ego_poses: list[Record]) -> None:
        """A scene of samples one after the other, whose clouds are in `cloud_of`."""
        samples = list(times_us)
        ends = {"first_sample_token": samples[0], "last_sample_token": samples[-1]}
        self.add("scene", name, name=name, description="", log_token="log", nbr_samples=len(samples), **ends)
        for before, (sample, time_us), after, ego in zip(["", *samples], times_us.items(), [*samples[1:], ""], ego_poses):
            self.add("ego_pose", f"pose{sample}", timestamp=time_us, **ego)
            self.add("sample", sample, scene_token=name, timestamp=time_us, prev=before, next=after)
            of_sample = {"sample_token": sample, "ego_pose_token": f"pose{sample}", "calibrated_sensor_token": "cs"}
            file = {"filename": cloud_of(sample), "fileformat": "pcd", "width": 0, "height": 0, "prev": "", "next": ""}
            self.add("sample_data", f"data{sample}", timestamp=time_us, is_key_frame=True, **of_sample, **file)

    def add_thing(self, token: str, category: str) -> None:
        ends = {"first_annotation_token": "", "last_annotation_token": ""}
        self.add("instance", token, category_token=category, nbr_annotations=0, **ends)

    def add_annotation(self, token: str, thing: str, **others: Any) -> Record:
        """An annotation of a sample with a pose and a size, without attributes and points unless `others` say so."""
        known = {"attribute_tokens": [], "num_lidar_pts": 0, "num_radar_pts": 0, "prev": "", "next": ""}
        return self.add("sample_annotation", token, instance_token=thing, visibility_token="4", **(known | others))

    def write(self, folder: Path) -> None:
        (folder / "v1.0-mini").mkdir(parents=True)
        (folder / "map.png").write_bytes(b"")
        for name, records in self.records.items():
            (folder / f"v1.0-mini/{name}.json").write_text(json.dumps(records))


def cloud_of(sample: str) -> str:
    return f"samples/LIDAR_TOP/{sample}.pcd.bin"
