"""What became of every annotation and detection under the criterion *points*, from points alone.

Written from docs/scores.md and the documentation of `harness/evaluation/src/matching/`, not from its code.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linear_sum_assignment

from labelled_scans import Floats, Indices, Region, Scan, along_across_m, indices_around

MIN_IOU = 0.5
MIN_POINTS = 20
MAX_RANGE_M = 80.0
TASKS = ("objects", "vehicles")
VEHICLES = ("car", "van", "truck", "bus")
# Neither right nor wrong among vehicles.
AMBIGUOUS = ("tram", "trailer", "construction-vehicle", "misc")

# Objects are tall if they reach so far above the ground around them.
TALL_M = 3.10
# Vehicles, persons and cycles never are.
MAY_BE_TALL = ("pole", "tree", "hedge", "fence", "street-furniture", "misc")
# Without a box these may go on above the field of view.
MAY_BE_CUT_OFF = ("pole", "tree")
GROUND_WITHIN_M = 2.0
MIN_POINTS_OF_SIDE = 4
EDGE_BEYOND_M = 20.0
EDGE_IS_REACHED_BY = 20
EDGE_MARGIN_RAD = math.radians(0.8)


@dataclass(frozen=True)
class Outcome:
    """What became of one annotation or detection; it is ignored for any of the reasons."""

    kind: str
    partner: int | None = None
    cost: float | None = field(default=None, compare=False)
    reasons: frozenset[str] = field(default=frozenset(), compare=False)


def assign(costs: Floats) -> list[tuple[int, int]]:
    """As many pairs of a row and a column as can be, then the least sum of costs, then the first rows. NaN is no pair."""
    if 0 in costs.shape:
        return []
    # One pair more outweighs all costs there can be.
    reward = 1.0 + np.nansum(costs)
    # Far less than two different costs differ.
    ties = 1e-11 * np.arange(len(costs))[:, None]
    rows, columns = linear_sum_assignment(np.where(np.isnan(costs), 0.0, costs + ties - reward))
    return [(int(row), int(column)) for row, column in zip(rows, columns) if not np.isnan(costs[row, column])]


def tall_objects(scan: Scan) -> set[int]:
    """The annotations that reach more than 3.10 m above the ground around them, or that end where the field of view does.

    Written from the documentation of `harness/evaluation/src/matching/height_above_ground.rs`.
    """
    is_free = ~np.isin(np.arange(len(scan.points_m)), np.concatenate([[-1], *(it.points for it in scan.annotations)]))
    free_m = np.asfortranarray(scan.points_m[is_free])
    # The elevation that a few points far away reach.
    is_far = scan.range_m >= EDGE_BEYOND_M + scan.slack
    elevations_rad = np.sort(np.arctan2(scan.points_m[is_far, 2], scan.range_m[is_far]))
    edge_rad = elevations_rad[-EDGE_IS_REACHED_BY] if len(elevations_rad) >= EDGE_IS_REACHED_BY else math.inf
    tall = set()
    for idx, it in enumerate(scan.annotations):
        if it.class_name not in MAY_BE_TALL or (it.box is None and len(it.points) == 0):
            continue
        extent = it.box
        if extent is None:
            of_object_m = scan.points_m[it.points]
            low, high = of_object_m.min(axis=0), of_object_m.max(axis=0)
            extent = np.array([*(low + high) / 2, *(high - low), 0.0])
            highest = it.points[np.argmax(of_object_m[:, 2])]
            elevation_rad = math.atan2(scan.points_m[highest, 2], scan.range_m[highest])
            is_cut_off = elevation_rad >= edge_rad - EDGE_MARGIN_RAD + scan.slack / EDGE_BEYOND_M
            if it.class_name in MAY_BE_CUT_OFF and is_cut_off:
                tall.add(idx)
        bottom_m, top_m = extent[2] - extent[5] / 2, extent[2] + extent[5] / 2
        if top_m - min(bottom_m, ground_around_m(extent, free_m, scan.slack)) > TALL_M + scan.slack:
            tall.add(idx)
    return tall


def ground_around_m(extent: Floats, free_m: Floats, slack_m: float) -> float:
    """The median, of the four sides of an object, of the lower quartile of the points there; infinite if they are few."""
    near_m = free_m[indices_around(free_m, extent, GROUND_WITHIN_M + 1.0)]
    along, across = along_across_m(extent, near_m)
    beyond = [np.maximum(np.abs(it) - size / 2, 0) for it, size in ((along, extent[3]), (across, extent[4]))]
    is_near = np.hypot(*beyond) <= GROUND_WITHIN_M + slack_m
    of_sides = []
    for is_ahead in (along >= slack_m, along < slack_m):
        for is_left in (across >= slack_m, across < slack_m):
            heights_m = np.sort(near_m[is_near & is_ahead & is_left, 2])
            if len(heights_m) >= MIN_POINTS_OF_SIDE:
                of_sides.append(heights_m[len(heights_m) // 4])
    return float(np.median(of_sides)) if of_sides else math.inf


def exclusion(scan: Scan, idx: int, task: str, is_tall: bool) -> str | None:
    """Why an annotation is ignored; "" if it is to be found, `None` if it is background."""
    it = scan.annotations[idx]
    if task == "vehicles" and it.class_name not in (*VEHICLES, *AMBIGUOUS):
        return None
    # Of several the first counts, so that what is tall would count but for its height.
    reasons = {
        "ambiguous class": task == "vehicles" and it.class_name in AMBIGUOUS,
        "too few points": len(it.points) < MIN_POINTS,
        "beyond range": math.hypot(*scan.center_m(it)[:2]) > MAX_RANGE_M + scan.slack,
        "unscorable": 2 * scan.n_points_in(it, Region.UNSCORABLE) >= len(it.points),
        "tall": task == "objects" and is_tall,
    }
    return next((reason for reason, holds in reasons.items() if holds), "")


def judge(
    scan: Scan, tall: set[int], of_point: Indices, classes: list[str], task: str, unmatched: str
) -> dict[tuple[str, int], Outcome]:
    """What became of every annotation and detection that the task asks for, by side and index.

    `of_point` is the detection of every point, -1 for none, `classes` those of the detections, and `unmatched` what a
    detection is that matches nothing: "false", or "unknowable".
    """
    n_points_of_each = lambda mask: np.bincount(of_point[mask & (of_point >= 0)], minlength=len(classes))
    n_points, is_on_ignored = n_points_of_each(True), np.zeros(len(scan.points_m), bool)
    outcomes = {}
    exclusions = [exclusion(scan, idx, task, idx in tall) for idx in range(len(scan.annotations))]
    for idx, reason in enumerate(exclusions):
        if reason is not None:
            outcomes["annotation", idx] = Outcome("ignored", reasons=frozenset([reason])) if reason else Outcome("missed")
        if reason:
            is_on_ignored[scan.annotations[idx].points] = True

    # A detection that matches nothing is neither right nor false if half of its points are not judged.
    of_reason = {
        "on ignored annotation": is_on_ignored,
        "outside labelled region": scan.regions == Region.OUTSIDE,
        "beyond range": scan.range_m > MAX_RANGE_M + scan.slack,
    }
    is_half = {reason: 2 * n_points_of_each(mask) >= n_points for reason, mask in of_reason.items()}
    of_any = np.any([*of_reason.values(), scan.regions == Region.UNSCORABLE], axis=0)
    is_half_of_any = 2 * n_points_of_each(of_any) >= n_points
    is_left = np.array([task == "objects" or it == "vehicle" for it in classes], bool)
    for idx in np.flatnonzero(is_left):
        reasons = frozenset(it for it in of_reason if is_half[it][idx]) or frozenset(["on ignored points"])
        outcomes["detection", int(idx)] = Outcome("ignored", reasons=reasons) if is_half_of_any[idx] else Outcome(unmatched)

    found = [of_point[it.points] for it in scan.annotations]
    shared = np.array([np.bincount(it[it >= 0], minlength=len(classes)) for it in found]).reshape(-1, len(classes))
    union = np.array([len(it) for it in found])[:, None] + n_points - shared
    iou = shared / np.maximum(union, 1)
    costs = np.where(iou >= MIN_IOU, 1.0 - iou, np.nan)
    # Detections that are left over may find tall annotations; both are ignored all the same.
    for reason, kind, reasons in (("", "matched", frozenset()), ("tall", "ignored", frozenset(["tall"]))):
        may_pair = np.array([it == reason for it in exclusions], bool)[:, None] & is_left
        for annotation_idx, detection_idx in assign(np.where(may_pair, costs, np.nan)):
            cost = float(costs[annotation_idx, detection_idx])
            outcomes["annotation", annotation_idx] = Outcome(kind, detection_idx, cost, reasons)
            outcomes["detection", detection_idx] = Outcome(kind, annotation_idx, cost, reasons)
            is_left[detection_idx] = False
    return outcomes
