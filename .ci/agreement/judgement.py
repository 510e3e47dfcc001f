"""What became of every annotation and detection under the criterion *points*, from points alone.

Written from docs/scores.md and the documentation of `harness/evaluation/src/matching/`, not from its code.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from labelled_scan import Annotation, Floats, Indices, LabelledScan, Region

MIN_IOU = 0.5
MIN_POINTS = 20
MAX_RANGE_M = 80.0

TASKS = ("objects", "vehicles")
VEHICLES = ("car", "van", "truck", "bus")
# Neither right nor wrong among vehicles.
AMBIGUOUS = ("tram", "trailer", "misc")


@dataclass(frozen=True)
class Detections:
    """What a detector found in a scan: the detection of every point (-1 for none), and the class of every detection."""

    of_point: Indices
    classes: list[str]


@dataclass(frozen=True)
class Outcome:
    """What became of one annotation or detection."""

    kind: str
    partner: int | None = None
    cost: float | None = field(default=None, compare=False)
    # Why it is ignored: any of these.
    reasons: frozenset[str] = field(default=frozenset(), compare=False)


@dataclass(frozen=True)
class Judgement:
    """Of every annotation and every detection; `None` is not asked for by the task."""

    annotations: list[Outcome | None]
    detections: list[Outcome | None]


COUNTS = Outcome("counts")
TALL = frozenset(["tall"])


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


def exclusion(scan: LabelledScan, annotation: Annotation, task: str, is_tall: bool) -> Outcome | None:
    """Why an annotation is ignored; `COUNTS` if it is to be found, `None` if it is background."""
    if task == "vehicles" and annotation.class_name not in (*VEHICLES, *AMBIGUOUS):
        return None
    # Of several the first counts, so that what is tall would count but for its height.
    reasons = {
        "ambiguous class": task == "vehicles" and annotation.class_name in AMBIGUOUS,
        "too few points": annotation.n_points < MIN_POINTS,
        "beyond range": math.hypot(*scan.center_m(annotation)[:2]) > MAX_RANGE_M + scan.slack,
        "unscorable": 2 * scan.n_points_in(annotation, Region.UNSCORABLE) >= annotation.n_points,
        "tall": task == "objects" and is_tall,
    }
    first = [reason for reason, holds in reasons.items() if holds][:1]
    return Outcome("ignored", reasons=frozenset(first)) if first else COUNTS


def shared_points(scan: LabelledScan, detections: Detections) -> Indices:
    """How many points each annotation (row) and detection (column) share."""
    n_detections = len(detections.classes)
    shared = np.zeros((len(scan.annotations), n_detections), np.int64)
    for row, annotation in enumerate(scan.annotations):
        found = detections.of_point[annotation.point_indices]
        shared[row] = np.bincount(found[found >= 0], minlength=n_detections)
    return shared


def admissible_costs(scan: LabelledScan, detections: Detections) -> Floats:
    """1 - IoU of each annotation (row) and detection (column), NaN for what is no pair."""
    shared = shared_points(scan, detections)
    n_of_annotation = np.array([it.n_points for it in scan.annotations])
    union = n_of_annotation[:, None] + points_of_each(detections)[None, :] - shared
    iou: Floats = shared / np.maximum(union, 1)
    return np.where(iou >= MIN_IOU, 1.0 - iou, np.nan)


def points_of_each(detections: Detections, among: NDArray[np.bool_] | None = None) -> Indices:
    """How many points each detection has, of all or of those `among` which to count."""
    is_counted = detections.of_point >= 0
    if among is not None:
        is_counted = is_counted & among
    return np.bincount(detections.of_point[is_counted], minlength=len(detections.classes))


def ignored_detections(scan: LabelledScan, detections: Detections, ignored: list[Annotation]) -> list[Outcome | None]:
    """For every detection why it is neither right nor false if it matches nothing: half of its points are not judged."""
    is_on_ignored = np.zeros(len(scan.points_m), bool)
    for annotation in ignored:
        is_on_ignored[annotation.point_indices] = True
    of_reason = {
        "on ignored annotation": is_on_ignored,
        "outside labelled region": scan.regions == Region.OUTSIDE,
        "beyond range": scan.range_m > MAX_RANGE_M + scan.slack,
    }
    of_any = np.any([*of_reason.values(), scan.regions == Region.UNSCORABLE], axis=0)
    n_points = points_of_each(detections)
    is_half = {reason: 2 * points_of_each(detections, mask) >= n_points for reason, mask in of_reason.items()}
    is_half_of_any = 2 * points_of_each(detections, of_any) >= n_points
    outcomes: list[Outcome | None] = []
    for idx in range(len(n_points)):
        reasons = frozenset(reason for reason in of_reason if is_half[reason][idx]) or frozenset(["on ignored points"])
        outcomes.append(Outcome("ignored", reasons=reasons) if is_half_of_any[idx] else None)
    return outcomes


def judge(scan: LabelledScan, tall: frozenset[int], detections: Detections, task: str, unmatched: str) -> Judgement:
    """Judges one scan; `unmatched` says what a detection is that matches nothing: "false", or "unknowable".

    Detections that are left over may find tall annotations; both are ignored all the same.
    """
    exclusions = [exclusion(scan, it, task, idx in tall) for idx, it in enumerate(scan.annotations)]
    is_asked = np.array([task == "objects" or it == "vehicle" for it in detections.classes], bool)
    costs = admissible_costs(scan, detections)
    counts = np.array([it is COUNTS for it in exclusions], bool)
    pairs = assign(np.where(counts[:, None] & is_asked, costs, np.nan))
    annotations = [Outcome("missed") if it is COUNTS else it for it in exclusions]
    ignored = [it for it, excluded in zip(scan.annotations, exclusions) if excluded is not None and excluded.kind == "ignored"]
    found: list[Outcome | None] = [
        (ignored_outcome or Outcome(unmatched)) if asked else None
        for asked, ignored_outcome in zip(is_asked, ignored_detections(scan, detections, ignored))
    ]
    is_left_over = is_asked.copy()
    for annotation_idx, detection_idx in pairs:
        cost = float(costs[annotation_idx, detection_idx])
        annotations[annotation_idx] = Outcome("matched", detection_idx, cost)
        found[detection_idx] = Outcome("matched", annotation_idx, cost)
        is_left_over[detection_idx] = False
    is_tall = np.array([it is not None and it.reasons == TALL for it in exclusions], bool)
    for annotation_idx, detection_idx in assign(np.where(is_tall[:, None] & is_left_over, costs, np.nan)):
        cost = float(costs[annotation_idx, detection_idx])
        annotations[annotation_idx] = Outcome("ignored", detection_idx, cost, TALL)
        found[detection_idx] = Outcome("ignored", annotation_idx, cost, TALL)
    return Judgement(annotations, found)
