"""A first detector: what stands on the ground, in square cells that touch. Change it, and see what becomes of its row."""

import numpy as np
import scanbench

ROW = 1 << 16  # from the number of a cell to the number of the one in front of it
NEIGHBOURS = [x * ROW + y for x in (-1, 0, 1) for y in (-1, 0, 1)]


def cell_numbers(points: np.ndarray, side_m: float) -> np.ndarray:
    return np.floor(points[:, :2] / side_m).astype(int) @ [ROW, 1]


@scanbench.detector
def cells(
    points: np.ndarray, cell_m: float = 0.3, ground_m: float = 0.3, top_m: float = 3.0, min_points: int = 20
) -> np.ndarray:
    """The number of a cluster for each of n points (x, y, z, intensity), in metres; -1 is none."""
    # The ground is at the lowest point of each square of 5 m.
    _, square = np.unique(cell_numbers(points, 5.0), return_inverse=True)
    lowest_m = np.full(len(points), np.inf)
    np.minimum.at(lowest_m, square, points[:, 2])
    height_m = points[:, 2] - lowest_m[square]
    above = height_m > ground_m

    # Cells that reach high are walls and trees; they and the cells beside them are left out.
    occupied, cell_of_point = np.unique(cell_numbers(points[above], cell_m), return_inverse=True)
    highest_m = np.zeros(len(occupied))
    np.maximum.at(highest_m, cell_of_point, height_m[above])
    walls = np.add.outer(occupied[highest_m >= top_m], NEIGHBOURS)
    free = set(occupied.tolist()) - set(walls.ravel().tolist())

    cluster_of_cell = np.full(len(occupied), -1)
    for number, first in enumerate(occupied.tolist()):
        if first not in free:
            continue
        free.remove(first)
        cluster = [first]
        for cell in cluster:  # The list grows meanwhile.
            found = [cell + step for step in NEIGHBOURS if cell + step in free]
            free.difference_update(found)
            cluster += found
        cluster_of_cell[np.searchsorted(occupied, cluster)] = number

    labels = np.full(len(points), -1)
    labels[above] = cluster_of_cell[cell_of_point]
    _, label_of_point, n_points = np.unique(labels, return_inverse=True, return_counts=True)
    return np.where(n_points[label_of_point] < min_points, -1, labels)
