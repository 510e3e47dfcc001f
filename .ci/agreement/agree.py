"""Scores runs again from their matches.csv, with other people's programs, and fails where they disagree: agree.py RUN...

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
from collections.abc import Callable
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval
from shapely import affinity
from sklearn.metrics import precision_recall_curve

from judgement import assign
from labelled_scans import Floats
from run_directory import Failures, Row, Run, box_of

ROUNDING = 2e-3  # of an intersection over union or of metres, from four decimals of centres, sizes and headings
NEAR_GATE = 1e-3


def of_outcomes(rows: list[Row], *outcomes: str) -> list[Row]:
    return [it for it in rows if it["outcome"] in outcomes]


def footprint(box: Floats) -> shapely.Polygon:
    x, y, _, length_m, width_m, _, yaw_rad = box
    upright = shapely.box(-length_m / 2, -width_m / 2, length_m / 2, width_m / 2)
    return affinity.translate(affinity.rotate(upright, yaw_rad, origin=(0, 0), use_radians=True), x, y)


def measured(criterion: str, annotated: list[Row], found: list[Row]) -> Floats:
    """Distance of centres or intersection over union of the box of each annotation (row) and of each detection (column)."""
    if not annotated or not found:
        return np.zeros((len(annotated), len(found)))
    a, b = ([box_of(it, side) for it in rows] for side, rows in (("annotation_", annotated), ("detection_", found)))
    if any(it is None for it in a + b):
        sys.exit(f"a box is missing in {annotated[0]['sequence']}/{annotated[0]['scan']}, but boxes are compared")
    if criterion == "centre":
        return np.linalg.norm(np.array(a)[:, None, :2] - np.array(b)[:, :2], axis=2)
    plans = [np.array([footprint(it) for it in boxes]) for boxes in (a, b)]
    common, sizes = shapely.area(shapely.intersection(plans[0][:, None], plans[1])), [shapely.area(it) for it in plans]
    if criterion == "iou-3d":
        sizes = [np.prod(np.array(it)[:, 3:6], axis=1) for it in (a, b)]
        bottoms, tops = ([[box[2] + half * box[5] for box in it] for it in (a, b)] for half in (-0.5, 0.5))
        common *= np.maximum(np.minimum.outer(*tops) - np.maximum.outer(*bottoms), 0.0)
    return common / (np.add.outer(*sizes) - common)


def criterion_of(run: Run) -> tuple[str, float]:
    """The criterion and its gate."""
    matching = run.manifest["config"]["matching"]
    criterion = matching["criterion"]
    return criterion, matching["max_centre_distance_m" if criterion == "centre" else "min_iou"]


def check_assignments(run: Run, failures: Failures) -> None:
    criterion, gate = criterion_of(run)
    if criterion not in ("centre", "bev-iou", "iou-3d"):
        print(f"  {run.name}: points are not in matches.csv; pairs of the criterion {criterion} are made by judge_again.py")
        return
    n_pairs, n_near, worst = 0, 0, 0.0
    for key, rows in run.matches.items():
        annotated, matched = of_outcomes(rows, "matched", "missed"), of_outcomes(rows, "matched")
        found = [it for it in rows if it["detection_id"] != ""]
        values = measured(criterion, annotated, found)
        costs = values if criterion == "centre" else 1 - values
        ours = [float(it["cost"]) for it in matched]
        theirs = [costs[annotated.index(it), found.index(it)] for it in matched]
        worst = max([worst, *np.abs(np.subtract(ours, theirs))])
        pairs = assign(np.where(values < gate if criterion == "centre" else values >= gate, costs, np.nan))
        n_pairs += len(pairs)
        if np.abs(values - gate).min(initial=math.inf) < NEAR_GATE and len(pairs) != len(matched):
            n_near += 1
            continue
        failures.check(len(pairs) == len(matched), f"{run.name} {key}: {len(matched)} pairs, scipy makes {len(pairs)}")
        total = sum(costs[pair] for pair in pairs)
        is_near = abs(total - sum(ours)) < ROUNDING * (1 + len(pairs))
        failures.check(is_near, f"{run.name} {key}: cost {sum(ours)}, scipy {total}")
    failures.check(worst < ROUNDING, f"{run.name}: a cost is {worst} off that of shapely")
    failures.check(n_pairs > 0, f"{run.name}: no pairs at all")
    print(f"  {run.name}: {criterion}, {len(run.matches)} scans, {n_pairs} pairs, largest difference of a cost {worst:.1e}, "
          f"{n_near} scans left out with a pair at the gate")


def coco_ap(of_scans: list[list[Row]], overlaps: Callable[[list[Row], list[Row]], Floats]) -> float:
    """AP over 101 points at one threshold by COCOeval; `overlaps` are of annotations (row) and detections of an image."""
    gts: list[dict[str, Any]] = []
    dts: list[dict[str, Any]] = []
    for image_id, rows in enumerate(of_scans, start=1):
        of_all = {"image_id": image_id, "category_id": 1, "bbox": [0, 0, 1, 1]}
        for row in of_outcomes(rows, "matched", "missed"):
            gts.append({"id": len(gts) + 1, "area": 1, "iscrowd": 0, "ignore": 0, "row": row} | of_all)
        for row in of_outcomes(rows, "matched", "false"):
            dts.append({"score": float(row["detection_score"]), "row": row} | of_all)
    if not dts:
        return 0.0

    class Eval(COCOeval):
        def computeIoU(self, image_id: int, category_id: int) -> Floats | list[float]:
            gt, dt = self._gts[image_id, category_id], self._dts[image_id, category_id]
            order = np.argsort([-it["score"] for it in dt], kind="mergesort")
            return overlaps([it["row"] for it in gt], [dt[i]["row"] for i in order]).T if gt and dt else []

    with redirect_stdout(StringIO()):
        truth = COCO()
        images = [{"id": i + 1} for i in range(len(of_scans))]
        truth.dataset = {"images": images, "annotations": gts, "categories": [{"id": 1}], "info": {}}
        truth.createIndex()
        evaluation = Eval(truth, truth.loadRes(dts), "bbox")
        evaluation.params.iouThrs = np.array([0.5])
        evaluation.params.maxDets = [100000]
        evaluation.params.areaRng, evaluation.params.areaRngLbl = [[0, 1e10]], ["all"]
        evaluation.evaluate()
        evaluation.accumulate()
    return float(np.mean(evaluation.eval["precision"][0, :, 0, 0, 0]))


def sklearn_ap(rows: list[Row], positions: Floats) -> float:
    """The average precision at these recalls, interpolated on the curve of sklearn."""
    judged, tp = of_outcomes(rows, "matched", "false"), len(of_outcomes(rows, "matched"))
    if tp == 0:
        return 0.0
    scores = np.array([float(it["detection_score"]) for it in judged])
    precisions, recalls, _ = precision_recall_curve([it["outcome"] == "matched" for it in judged], scores)
    # sklearn ends the curve at precision 1 and recall 0, where nothing is detected; its recall is of what was matched.
    precisions, recalls = precisions[:-1], recalls[:-1] * tp / len(of_outcomes(rows, "matched", "missed"))
    return float(np.mean([max(precisions[recalls >= at - 1e-9], default=0.0) for at in positions]))


def check_scores(run: Run, failures: Failures) -> None:
    values: dict[str, dict[str, Any]] = defaultdict(dict)
    for it in run.report["rows"] + run.report["overall"]:
        if it["slice"] == "all":
            values["/".join((it["dataset"], it["task"], it["detector"]))][it["metric"]] = it["value"]
    grouped: dict[str, list[list[Row]]] = defaultdict(list)
    for (dataset, _, _, detector, task), of_scan in run.matches.items():
        grouped["/".join((dataset, task, detector))].append(of_scan)
    for name, of_scans in grouped.items():
        of_report, rows = values[name], [row for of_scan in of_scans for row in of_scan]
        tp, mo, fo = (len(of_outcomes(rows, it)) for it in ("matched", "missed", "false"))
        no = tp + mo
        failures.check((of_report["no"], of_report["tp"]) == (no, tp), f"{run.name} {name}: NO or TP differ")
        if of_report["fo"] is not None:
            failures.check(of_report["fo"] == fo, f"{run.name} {name}: FO differs")
            f_rate = 2 * tp / (2 * tp + mo + fo) if no + fo else None
            failures.check(of_report["f_rate"] == f_rate, f"{run.name} {name}: F-rate {of_report['f_rate']}, {f_rate}")
        if None not in (ours := (of_report.get("ap_101_points"), of_report.get("ap_r40"))):
            check_average_precision(run, name, ours, of_scans, failures)


def check_average_precision(
    run: Run, name: str, ours: tuple[float, float], of_scans: list[list[Row]], failures: Failures
) -> None:
    rows = [row for of_scan in of_scans for row in of_scan]
    for metric, a, positions in zip(("101", "R40"), ours, (np.linspace(0, 1, 101), np.arange(1, 41) / 40)):
        b = sklearn_ap(rows, positions)
        failures.check(abs(a - b) < 1e-9, f"{run.name} {name}: AP {metric} {a}, from sklearn's curve {b}")
    given = coco_ap(of_scans, lambda gts, dts: np.array([[float(gt is dt) for dt in dts] for gt in gts]))
    failures.check(abs(given - ours[0]) < 0.005, f"{run.name} {name}: AP {ours[0]}, pycocotools given our pairs {given}")
    line = f"  {run.name} {name}: AP 101 {100 * ours[0]:.2f} (pycocotools given our pairs {100 * given:.2f}"
    criterion, gate = criterion_of(run)
    if criterion in ("bev-iou", "iou-3d"):
        # Half of COCO's threshold stands for our gate.
        own = coco_ap(of_scans, lambda gts, dts: 0.5 / gate * measured(criterion, gts, dts))
        failures.check(abs(own - ours[0]) < 0.03, f"{run.name} {name}: AP {ours[0]}, pycocotools {own}")
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
