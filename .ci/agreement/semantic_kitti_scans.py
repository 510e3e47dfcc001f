"""Reads SemanticKITTI, as published and as `scanbench data convert` writes it."""

from pathlib import Path

import numpy as np
from scipy import ndimage

from labelled_scan import Annotation, Dataset, Floats, Indices, LabelledScan, Region, ScanWithSlack, read_bin

# Names of the format's label map (semantic-kitti.yaml) beside ours. Instances of all of these are objects.
OBJECTS = {
    10: "car", 252: "car",
    11: "parked-cycle", 15: "parked-cycle",  # bicycle, motorcycle
    13: "bus", 257: "bus",
    16: "tram", 256: "tram",  # on-rails
    18: "truck", 258: "truck",
    20: "misc", 259: "misc",  # other-vehicle
    30: "pedestrian", 254: "pedestrian",
    31: "cyclist", 32: "cyclist", 253: "cyclist", 255: "cyclist",  # bicyclist, motorcyclist
    80: "pole", 81: "pole",  # pole, traffic-sign
    # Whether these are objects of their own is open, but for converted data sets, where they have instances.
    51: "fence",
    70: "hedge",  # vegetation
    71: "tree",  # trunk
    99: "street-furniture",  # other-object
}  # fmt: skip
UPRIGHTS = (80, 81)
# Unlabelled, outlier, other-structure.
NOT_JUDGED = (0, 1, 52)
# Road, parking, sidewalk, other-ground, building, lane-marking, terrain.
BACKGROUND = (40, 44, 48, 49, 50, 60, 72)

CELL_M = 0.3


def touching_cells(points_m: Floats, slack_m: float) -> list[Indices]:
    """Groups points by cells of the ground plan that share an edge or a corner, in the order of their first points."""
    if len(points_m) == 0:
        return []
    cells = np.floor((points_m[:, :2] + slack_m) / CELL_M).astype(int)
    cells -= cells.min(axis=0)
    is_occupied = np.zeros(cells.max(axis=0) + 1, bool)
    is_occupied[tuple(cells.T)] = True
    group_of_cell, n_groups = ndimage.label(is_occupied, structure=np.ones((3, 3)))
    group_of_point = group_of_cell[tuple(cells.T)]
    groups = [np.flatnonzero(group_of_point == group) for group in range(1, n_groups + 1)]
    return sorted(groups, key=lambda group: int(group[0]))


def label_scan(points_m: Floats, labels: Indices, slack_m: float) -> LabelledScan:
    """One annotation for each instance, by label, then one for each pole or sign; what has no instance is not judged."""
    classes, instances = labels & 0xFFFF, labels >> 16
    unknown = set(np.unique(classes)) - {*OBJECTS, *NOT_JUDGED, *BACKGROUND}
    if unknown:
        raise ValueError(f"labels {sorted(unknown)} are not SemanticKITTI's")
    is_object = np.isin(classes, list(OBJECTS)) & (instances > 0)
    is_upright = np.isin(classes, UPRIGHTS) & (instances == 0)
    is_background = np.isin(classes, BACKGROUND)
    annotations = [
        Annotation(OBJECTS[int(label) & 0xFFFF], None, np.flatnonzero(labels == label), int(label))
        for label in np.unique(labels[is_object])
    ]
    uprights = np.flatnonzero(is_upright)
    for group in touching_cells(points_m[uprights], slack_m):
        annotations.append(Annotation("pole", None, uprights[group], None))
    is_judged = is_object | is_upright | is_background
    regions = np.where(is_judged, Region.LABELLED, Region.UNSCORABLE).astype(np.uint8)
    return LabelledScan(points_m, annotations, regions, slack_m)


def semantic_kitti(root: Path) -> Dataset:
    """The folder that has `sequences`. Every point has a label, so that false objects are known."""

    def read(drive: str, number: int) -> ScanWithSlack:
        folder = root / "sequences" / drive
        points_m = read_bin(folder / f"velodyne/{number:06}.bin")
        labels = np.fromfile(folder / f"labels/{number:06}.label", "<u4").astype(np.int64)
        return lambda slack_m: label_scan(points_m, labels, slack_m)

    return Dataset(str(root), annotates_everything=True, annotates_vehicles=True, read=read)
