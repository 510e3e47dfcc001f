"""A drawn scene of nuScenes, with boxes carried from frame to frame by NumPy, against what scanbench does."""

import json
from pathlib import Path

import numpy

from made_labels import assert_same, boxes, points

CATEGORIES = {"vehicle.car": "Car", "vehicle.bus.rigid": "Bus", "human.pedestrian.adult": "Pedestrian", "animal": "Misc"}


def quaternion(random, upright):
    """Of a turn about z, or any small one beside it."""
    yaw = random.uniform(-numpy.pi, numpy.pi)
    axis = numpy.array([0.0, 0.0, 1.0]) + (0 if upright else random.normal(0, 0.02, 3))
    axis /= numpy.linalg.norm(axis)
    return numpy.array([numpy.cos(yaw / 2), *numpy.sin(yaw / 2) * axis])


def matrix(translation, rotation):
    w, x, y, z = rotation
    pose = numpy.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = translation
    return pose


def check_read(scanbench, scratch: Path):
    random = numpy.random.default_rng(13)
    tables = {name: [] for name in "attribute log ego_pose instance sample sample_annotation sample_data".split()}
    calibration = {"token": "cs", "sensor_token": "top", "translation": [0.94, 0.01, 1.84], "rotation": [0.7077, 0.0047, -0.009, -0.7064]}
    calibration["rotation"] = list(numpy.array(calibration["rotation"]) / numpy.linalg.norm(calibration["rotation"]))
    tables["sensor"] = [{"token": "top", "channel": "LIDAR_TOP", "modality": "lidar"}]
    tables["calibrated_sensor"] = [calibration]
    tables["scene"] = [{"token": "scene", "name": "scene-0001"}]
    tables["visibility"] = [{"token": "4", "level": "v80-100"}]
    tables["category"] = [{"token": name, "name": name} for name in CATEGORIES]
    (scratch / "data/samples/LIDAR_TOP").mkdir(parents=True)
    expected, clouds = [], []
    for number in range(5):
        pose = {"token": f"pose{number}", "translation": list(random.normal(0, 1000, 3)), "rotation": list(quaternion(random, False))}
        tables["ego_pose"].append(pose)
        tables["sample"].append({"token": f"sample{number}", "scene_token": "scene"})
        name = f"samples/LIDAR_TOP/{number}.pcd.bin"
        frame = {"sample_token": f"sample{number}", "ego_pose_token": pose["token"], "calibrated_sensor_token": "cs"}
        tables["sample_data"].append(frame | {"timestamp": 10**15 + number, "is_key_frame": True, "filename": name})
        cloud = random.normal(0, 20, (1000, 5)).astype("<f4")
        cloud.tofile(scratch / "data" / name)
        clouds.append(cloud)
        world_from_lidar = matrix(pose["translation"], pose["rotation"]) @ matrix(calibration["translation"], calibration["rotation"])
        expected.append([])
        for index in range(20):
            category = random.choice(list(CATEGORIES))
            tables["instance"].append({"token": f"{number}-{index}", "category_token": category})
            near = matrix(random.uniform(-40, 40, 3), quaternion(random, True))
            world_from_box = world_from_lidar @ near
            # Upright in the world, as all are that people have labelled.
            rotation = quaternion(random, True)
            size = random.uniform(0.5, 5, 3)
            tables["sample_annotation"].append(
                {"sample_token": f"sample{number}", "instance_token": f"{number}-{index}", "visibility_token": "4"}
                | {"translation": list(world_from_box[:3, 3]), "size": list(size), "rotation": list(rotation), "num_lidar_pts": 1}
            )
            lidar_from_box = numpy.linalg.inv(world_from_lidar) @ matrix(world_from_box[:3, 3], rotation)
            (right, forward, up), heading = lidar_from_box[:3, 3], lidar_from_box[:3, 0]
            width, length, height = size
            yaw = numpy.arctan2(-heading[0], heading[1])
            expected[-1].append((CATEGORIES[category], numpy.array([forward, -right, up, length, width, height, yaw])))
    for name, rows in tables.items():
        (scratch / "data/v1.0-mini").mkdir(exist_ok=True)
        (scratch / f"data/v1.0-mini/{name}.json").write_text(json.dumps(rows))
    scanbench("data", "convert", scratch / "data", "-o", scratch / "out", "--to", "kitti-object")
    for number, (cloud, of_scan) in enumerate(zip(clouds, expected, strict=True)):
        found = points(scratch / "out", number)
        assert numpy.array_equal(found[:, :3], numpy.column_stack([cloud[:, 1], -cloud[:, 0], cloud[:, 2]]))
        assert numpy.allclose(found[:, 3], cloud[:, 3] / 255)
        assert_same(boxes(scratch / f"out/training/label_2/{number:06}.txt"), of_scan)
    return f"{sum(map(len, expected))} boxes of a drawn scene carried by NumPy"
