"""How high objects reach above the ground around them.

Written from the documentation of `harness/evaluation/src/matching/height_above_ground.rs`.
"""

import math

import numpy as np

from labelled_scan import Annotation, Box, Floats, LabelledScan, indices_around

TALL_M = 3.10
# Vehicles, persons and cycles never are.
MAY_BE_TALL = ("pole", "tree", "hedge", "fence", "street-furniture", "misc")
# Without a box these may go on above the field of view.
MAY_BE_CUT_OFF = ("pole", "tree")

REACH_M = 2.0
MIN_POINTS_OF_SIDE = 4
EDGE_BEYOND_M = 20.0
EDGE_IS_REACHED_BY = 20
EDGE_MARGIN_RAD = math.radians(0.8)


def tall_objects(scan: LabelledScan) -> frozenset[int]:
    """The annotations that reach more than 3.10 m above the ground around them."""
    free_m = points_of_no_annotation(scan)
    edge_rad = upper_edge_rad(scan)
    tall = []
    for idx, annotation in enumerate(scan.annotations):
        if annotation.class_name not in MAY_BE_TALL or (annotation.box is None and annotation.n_points == 0):
            continue
        extent = annotation.box or box_around(scan.points_m[annotation.point_indices])
        ground_m = min(extent.bottom_m, ground_around_m(extent, free_m, scan.slack))
        if extent.top_m - ground_m > TALL_M + scan.slack or is_cut_off(scan, annotation, edge_rad):
            tall.append(idx)
    return frozenset(tall)


def points_of_no_annotation(scan: LabelledScan) -> Floats:
    is_free = np.ones(len(scan.points_m), bool)
    for annotation in scan.annotations:
        is_free[annotation.point_indices] = False
    return np.asfortranarray(scan.points_m[is_free])


def box_around(points_m: Floats) -> Box:
    """Along the axes of the sensor."""
    low, high = points_m.min(axis=0), points_m.max(axis=0)
    length_m, width_m, height_m = (float(it) for it in high - low)
    x, y, z = (float(it) for it in (low + high) / 2)
    return Box((x, y, z), length_m, width_m, height_m, yaw_rad=0.0)


def ground_around_m(extent: Box, free_m: Floats, slack_m: float) -> float:
    """The median, of the four sides of an object, of the lower quartile of the points there; infinite if there are too few."""
    near_m = free_m[indices_around(free_m, extent, REACH_M + 1.0)]
    along, across = extent.along_across_m(near_m)
    beyond = [np.maximum(np.abs(along) - extent.length_m / 2, 0), np.maximum(np.abs(across) - extent.width_m / 2, 0)]
    is_near = np.hypot(*beyond) <= REACH_M + slack_m
    of_sides = []
    for is_ahead in (along >= slack_m, along < slack_m):
        for is_left in (across >= slack_m, across < slack_m):
            heights_m = np.sort(near_m[is_near & is_ahead & is_left, 2])
            if len(heights_m) >= MIN_POINTS_OF_SIDE:
                of_sides.append(heights_m[len(heights_m) // 4])
    return float(np.median(of_sides)) if of_sides else math.inf


def upper_edge_rad(scan: LabelledScan) -> float:
    """The elevation that a few points far away reach; infinite if there are fewer."""
    is_far = scan.range_m >= EDGE_BEYOND_M + scan.slack
    elevations_rad = np.sort(np.arctan2(scan.points_m[is_far, 2], scan.range_m[is_far]))
    return float(elevations_rad[-EDGE_IS_REACHED_BY]) if len(elevations_rad) >= EDGE_IS_REACHED_BY else math.inf


def is_cut_off(scan: LabelledScan, annotation: Annotation, edge_rad: float) -> bool:
    """Whether a pole or tree without a box ends where the field of view does."""
    if annotation.box is not None or annotation.class_name not in MAY_BE_CUT_OFF:
        return False
    highest = annotation.point_indices[np.argmax(scan.points_m[annotation.point_indices, 2])]
    elevation_rad = math.atan2(scan.points_m[highest, 2], scan.range_m[highest])
    return elevation_rad >= edge_rad - EDGE_MARGIN_RAD + scan.slack / EDGE_BEYOND_M
