"""What scanbench writes as KITTI object labels, as boxes with x forward, y left, z up."""

import numpy


def boxes(path):
    """Class, and centre x, y, z, length, width, height, yaw of every line."""
    found = []
    for line in path.read_text().splitlines():
        fields = line.split()
        height, width, length, right, down, forward, turn = map(float, fields[8:15])
        yaw = -turn - numpy.pi / 2
        found.append((fields[0], numpy.array([forward, -right, -down + height / 2, length, width, height, yaw])))
    return found


def assert_same(found, expected, tolerance=1e-3):
    """Boxes are equal, but for whole turns of the yaw."""
    assert len(found) == len(expected), (len(found), len(expected))
    for (class_found, box_found), (class_expected, box_expected) in zip(found, expected, strict=True):
        difference = box_found - box_expected
        difference[6] = numpy.sin(difference[6] / 2) * 2
        assert class_found == class_expected and numpy.abs(difference).max() < tolerance, (box_found, box_expected)


def points(folder, number):
    return numpy.fromfile(folder / f"training/velodyne/{number:06}.bin", "<f4").reshape(-1, 4)
