"""A drawn scene of nuScenes, with boxes carried from frame to frame by NumPy, against what scanbench does."""

import sys
from pathlib import Path

import numpy

from made_labels import assert_same, boxes, points

sys.path.append(str(Path(__file__).parents[1] / "agreement"))
from nuscenes_tables import NuScenesTables, cloud_of, pose

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
    rotation = numpy.array([0.7077, 0.0047, -0.009, -0.7064])
    lidar = pose([0.94, 0.01, 1.84], rotation / numpy.linalg.norm(rotation))
    tables = NuScenesTables(CATEGORIES, [], lidar)
    samples = {f"sample{number}": 10**15 + number for number in range(5)}
    (scratch / "data/samples/LIDAR_TOP").mkdir(parents=True)
    egos, expected, clouds = [], [], []
    for sample in samples:
        egos.append(pose(random.normal(0, 1000, 3), quaternion(random, False)))
        clouds.append(random.normal(0, 20, (1000, 5)).astype("<f4"))
        clouds[-1].tofile(scratch / "data" / cloud_of(sample))
        world_from_lidar = matrix(**egos[-1]) @ matrix(**lidar)
        expected.append([])
        for index in range(20):
            category = random.choice(list(CATEGORIES))
            world_from_box = world_from_lidar @ matrix(random.uniform(-40, 40, 3), quaternion(random, True))
            # Upright in the world, as all are that people have labelled.
            rotation = quaternion(random, True)
            size = random.uniform(0.5, 5, 3)
            thing = f"{sample}-{index}"
            tables.add_thing(thing, category)
            found = {"sample_token": sample, "size": list(size), "num_lidar_pts": 1} | pose(world_from_box[:3, 3], rotation)
            tables.add_annotation(thing, thing, **found)
            lidar_from_box = numpy.linalg.inv(world_from_lidar) @ matrix(world_from_box[:3, 3], rotation)
            (right, forward, up), heading = lidar_from_box[:3, 3], lidar_from_box[:3, 0]
            width, length, height = size
            yaw = numpy.arctan2(-heading[0], heading[1])
            expected[-1].append((CATEGORIES[category], numpy.array([forward, -right, up, length, width, height, yaw])))
    tables.add_scene("scene-0001", samples, egos)
    tables.write(scratch / "data")
    scanbench("data", "convert", scratch / "data", "-o", scratch / "out", "--to", "kitti-object")
    for number, (cloud, of_scan) in enumerate(zip(clouds, expected, strict=True)):
        found = points(scratch / "out", number)
        assert numpy.array_equal(found[:, :3], numpy.column_stack([cloud[:, 1], -cloud[:, 0], cloud[:, 2]]))
        assert numpy.allclose(found[:, 3], cloud[:, 3] / 255)
        assert_same(boxes(scratch / f"out/training/label_2/{number:06}.txt"), of_scan)
    return f"{sum(map(len, expected))} boxes of a drawn scene carried by NumPy"
