"""Scores a run again from its matches.csv, with other people's programs, and fails where they disagree.

    agree.py RUN...

For every scan, detector and task of a run under a box or centre criterion:
  costs       rotated intersection over union by shapely, distances by numpy
  assignment  scipy.optimize.linear_sum_assignment on gated costs: as many pairs, and the same sum of costs
For every run, detector and task:
  counts      NO, TP, FO and F-rate of report.json, counted again
  precision   sklearn.metrics.precision_recall_curve, of which average precision is interpolated again (101 points, R40)
  AP          pycocotools: COCOeval over 101 points, given our pairs; and with pairs of its own, which differ: COCO gives
              detections their annotation one by one, best score first, and we all at once, as many pairs as can be. So its
              own figure is printed and only has to be near.

matches.csv has four decimals: a pair within a thousandth of the gate may fall on either side of it.
"""

import math
import sys
from collections import defaultdict
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval
from shapely import Polygon
from sklearn.metrics import precision_recall_curve

from assignment import assign
from failures import Failures
from labelled_scan import Box, Floats
from program import Row, Run, row_box

ROUNDING = 2e-3  # of an intersection over union or of metres, from four decimals of centres, sizes and headings
NEAR_GATE = 1e-3

Measure = Callable[[Box, Box], float]


def box(row: Row, side: str) -> Box:
    found = row_box(row, side)
    if found is None:
        sys.exit(f"{side} {row[f'{side}_id']} of {row['sequence']}/{row['scan']} has no box, but boxes are compared")
    return found


def footprint(it: Box) -> Polygon:
    x, y, _ = it.center_m
    c, s = math.cos(it.yaw_rad), math.sin(it.yaw_rad)
    corners = ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
    halves = [(a * it.length_m, b * it.width_m) for a, b in corners]
    return Polygon([(x + c * along - s * across, y + s * along + c * across) for along, across in halves])


def bev_iou(first: Box, second: Box) -> float:
    a, b = footprint(first), footprint(second)
    common = a.intersection(b).area
    union = a.area + b.area - common
    return common / union if union > 0 else 0.0


def iou_3d(first: Box, second: Box) -> float:
    common = footprint(first).intersection(footprint(second)).area
    common *= max(min(first.top_m, second.top_m) - max(first.bottom_m, second.bottom_m), 0.0)
    union = first.volume_m3 + second.volume_m3 - common
    return common / union if union > 0 else 0.0


def distance(first: Box, second: Box) -> float:
    return math.dist(first.center_m[:2], second.center_m[:2])


def gate_of(run: Run) -> tuple[str, Measure | None, float]:
    matching = run.manifest["config"]["matching"]
    criterion = matching["criterion"]
    if criterion == "centre":
        return criterion, distance, matching["max_centre_distance_m"]
    return criterion, {"bev-iou": bev_iou, "iou-3d": iou_3d}.get(criterion), matching["min_iou"]


def pairs_and_cost(
    annotations: list[Box], detections: list[Box], measure: Measure, criterion: str, gate: float
) -> tuple[int, float, float]:
    """Number of pairs, sum of costs, and the least distance of any pair from the gate."""
    centers = np.array([it.center_m[:2] for it in detections]).reshape(-1, 2)
    costs = np.full((len(annotations), len(detections)), np.nan)
    least = math.inf
    for row, annotation in enumerate(annotations):
        half_diagonals = np.array([0.5 * math.hypot(it.length_m, it.width_m) for it in detections])
        reach = half_diagonals + 0.5 * math.hypot(annotation.length_m, annotation.width_m)
        apart = np.hypot(*(centers - annotation.center_m[:2]).T)
        for column in np.flatnonzero(apart <= (gate + 1 if criterion == "centre" else reach)):
            value = measure(annotation, detections[column])
            least = min(least, abs(value - gate))
            if criterion == "centre" and value < gate:
                costs[row, column] = value
            elif criterion != "centre" and value >= gate:
                costs[row, column] = 1 - value
    pairs = assign(costs)
    return len(pairs), float(sum(costs[pair] for pair in pairs)), least


def check_assignments(run: Run, failures: Failures) -> None:
    criterion, measure, gate = gate_of(run)
    if measure is None:
        print(f"  {run.name}: points are not in matches.csv; pairs of the criterion {criterion} are made by judge_again.py")
        return
    n_pairs, n_near, worst = 0, 0, 0.0
    for key, rows in run.matches.items():
        matched = [it for it in rows if it["outcome"] == "matched"]
        annotations = [box(it, "annotation") for it in rows if it["outcome"] in ("matched", "missed")]
        detections = [box(it, "detection") for it in rows if it["detection_id"] != ""]
        for it in matched:
            value = measure(box(it, "annotation"), box(it, "detection"))
            cost = value if criterion == "centre" else 1 - value
            worst = max(worst, abs(cost - float(it["cost"])))
        n, total, least = pairs_and_cost(annotations, detections, measure, criterion, gate)
        ours = sum(float(it["cost"]) for it in matched)
        n_pairs += n
        if least < NEAR_GATE and n != len(matched):
            n_near += 1
            continue
        failures.check(n == len(matched), f"{run.name} {key}: {len(matched)} pairs, scipy makes {n}")
        failures.check(abs(total - ours) < ROUNDING * (1 + n), f"{run.name} {key}: cost {ours}, scipy {total}")
    failures.check(worst < ROUNDING, f"{run.name}: a cost is {worst} off that of shapely")
    failures.check(n_pairs > 0, f"{run.name}: no pairs at all")
    print(f"  {run.name}: {criterion}, {len(run.matches)} scans, {n_pairs} pairs, largest difference of a cost {worst:.1e}, "
          f"{n_near} scans left out with a pair at the gate")


def report_values(run: Run) -> dict[tuple[str, ...], Any]:
    rows = run.report["rows"] + run.report["overall"]
    of_all = (it for it in rows if it["slice"] == "all")
    return {(it["dataset"], it["task"], it["detector"], it["metric"]): it["value"] for it in of_all}


def interpolated(recalls: Floats, precisions: Floats, positions: Floats) -> float:
    best = [max((p for r, p in zip(recalls, precisions) if r >= at - 1e-9), default=0.0) for at in positions]
    return float(np.mean(best))


def coco_ap(images: Sequence[tuple[list[Row], list[Row]]], iou_of: Callable[[Row, Row], float]) -> float:
    """AP over 101 points at one threshold by COCOeval, where `iou_of` gives the overlaps of an image."""
    gts: list[dict[str, Any]] = []
    dts: list[dict[str, Any]] = []
    for image_id, (annotations, detections) in enumerate(images, start=1):
        for annotation in annotations:
            gts.append({"id": len(gts) + 1, "image_id": image_id, "category_id": 1, "bbox": [0, 0, 1, 1], "area": 1,
                        "iscrowd": 0, "ignore": 0, "row": annotation})
        for detection in detections:
            dts.append({"image_id": image_id, "category_id": 1, "bbox": [0, 0, 1, 1], "row": detection,
                        "score": float(detection["detection_score"])})

    if not dts:
        return 0.0

    class Eval(COCOeval):
        def computeIoU(self, image_id: int, category_id: int) -> Floats | list[float]:
            gt, dt = self._gts[image_id, category_id], self._dts[image_id, category_id]
            order = np.argsort([-it["score"] for it in dt], kind="mergesort")
            return np.array([[iou_of(it["row"], dt[i]["row"]) for it in gt] for i in order]) if gt and dt else []

    with redirect_stdout(StringIO()):
        truth = COCO()
        truth.dataset = {"images": [{"id": i + 1} for i in range(len(images))], "annotations": gts,
                         "categories": [{"id": 1}], "info": {}}
        truth.createIndex()
        found = truth.loadRes(dts)
        evaluation = Eval(truth, found, "bbox")
        evaluation.params.iouThrs = np.array([0.5])
        evaluation.params.maxDets = [100000]
        evaluation.params.areaRng, evaluation.params.areaRngLbl = [[0, 1e10]], ["all"]
        evaluation.evaluate()
        evaluation.accumulate()
    return float(np.mean(evaluation.eval["precision"][0, :, 0, 0, 0]))


def check_scores(run: Run, failures: Failures) -> None:
    values = report_values(run)
    grouped: dict[tuple[str, ...], list[list[Row]]] = defaultdict(list)
    for (dataset, _, _, detector, task), of_scan in run.matches.items():
        grouped[dataset, task, detector].append(of_scan)
    for key, of_scans in grouped.items():
        check_counts(run, key, values, of_scans, failures)
        ours = [values[*key, it] for it in ("ap_101_points", "ap_r40") if values.get((*key, it)) is not None]
        if len(ours) == 2:
            check_average_precision(run, key, ours, of_scans, failures)


def n_of(outcome: str, of_scans: list[list[Row]]) -> int:
    return sum(row["outcome"] == outcome for rows in of_scans for row in rows)


def check_counts(
    run: Run, key: tuple[str, ...], values: dict[tuple[str, ...], Any], of_scans: list[list[Row]], failures: Failures
) -> None:
    tp, mo, fo = (n_of(it, of_scans) for it in ("matched", "missed", "false"))
    no = tp + mo
    failures.check((values[*key, "no"], values[*key, "tp"]) == (no, tp), f"{run.name} {key}: NO or TP differ")
    if values[*key, "fo"] is not None:
        failures.check(values[*key, "fo"] == fo, f"{run.name} {key}: FO differs")
        f_rate = 2 * tp / (2 * tp + mo + fo) if no + fo else None
        failures.check(values[*key, "f_rate"] == f_rate, f"{run.name} {key}: F-rate {values[*key, 'f_rate']}, {f_rate}")


def curve_precisions(of_scans: list[list[Row]]) -> list[float]:
    """AP over 101 points and R40, interpolated on the curve of sklearn."""
    judged = [it for rows in of_scans for it in rows if it["outcome"] in ("matched", "false")]
    tp, mo = n_of("matched", of_scans), n_of("missed", of_scans)
    if tp == 0:
        return [0.0, 0.0]
    scores = np.array([float(it["detection_score"]) for it in judged])
    precisions, recalls, _ = precision_recall_curve([it["outcome"] == "matched" for it in judged], scores)
    # sklearn ends the curve at precision 1 and recall 0, where nothing is detected; its recall is of what was matched.
    curve = recalls[:-1] * tp / (tp + mo), precisions[:-1]
    return [interpolated(*curve, np.linspace(0, 1, 101)), interpolated(*curve, np.arange(1, 41) / 40)]


def check_average_precision(
    run: Run, key: tuple[str, ...], ours: list[float], of_scans: list[list[Row]], failures: Failures
) -> None:
    _, measure, gate = gate_of(run)
    for name, a, b in zip(("101", "R40"), ours, curve_precisions(of_scans)):
        failures.check(abs(a - b) < 1e-9, f"{run.name} {key}: AP {name} {a}, from sklearn's curve {b}")
    images = [([it for it in rows if it["outcome"] in ("matched", "missed")],
               [it for it in rows if it["outcome"] in ("matched", "false")]) for rows in of_scans]
    given = coco_ap(images, lambda gt, dt: float(gt is dt))
    failures.check(abs(given - ours[0]) < 0.005, f"{run.name} {key}: AP {ours[0]}, pycocotools given our pairs {given}")
    line = f"  {run.name} {'/'.join(key)}: AP 101 {100 * ours[0]:.2f} (pycocotools given our pairs {100 * given:.2f}"
    if measure in (bev_iou, iou_3d):
        # Half of COCO's threshold stands for our gate.
        def scaled(gt: Row, dt: Row) -> float:
            return 0.5 * measure(box(gt, "annotation"), box(dt, "detection")) / gate if gt and dt else 0.0
        own = coco_ap(images, scaled)
        failures.check(abs(own - ours[0]) < 0.03, f"{run.name} {key}: AP {ours[0]}, pycocotools {own}")
        line += f", with pairs of its own {100 * own:.2f}"
    print(f"{line}), R40 {100 * ours[1]:.2f}")


def main() -> None:
    failures = Failures()
    for run in map(Run, map(Path, sys.argv[1:])):
        check_assignments(run, failures)
        check_scores(run, failures)
    failures.print()
    sys.exit(bool(failures))


if __name__ == "__main__":
    main()
