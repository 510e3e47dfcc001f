"""What scanbench writes as KITTI object: points, and boxes with x forward, y left, z up."""

import numpy as np


def points(folder, number):
    return np.fromfile(folder / f"training/velodyne/{number:06}.bin", "<f4").reshape(-1, 4)


def boxes(folder, number):
    """Class, and centre x, y, z, length, width, height, yaw of every label of a scan."""
    found = []
    for line in (folder / f"training/label_2/{number:06}.txt").read_text().splitlines():
        fields = line.split()
        height, width, length, right, down, forward, turn = map(float, fields[8:15])
        box = np.array([forward, -right, -down + height / 2, length, width, height, -turn - np.pi / 2])
        found.append((fields[0], box))
    return found


def assert_same(found, expected, tolerance=1e-3):
    """Boxes are equal, but for whole turns of the yaw."""
    for (class_found, box_found), (class_expected, box_expected) in zip(found, expected, strict=True):
        difference = box_found - box_expected
        difference[6] = np.sin(difference[6] / 2) * 2
        assert class_found == class_expected and np.abs(difference).max() < tolerance, (box_found, box_expected)
