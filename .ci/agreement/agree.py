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
from collections.abc import Callable, Iterable, Sequence
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

from comparison import Failures
from judgement import assign
from labelled_scan import Box, Floats
from program import Row, Run, row_box

ROUNDING = 2e-3  # of an intersection over union or of metres, from four decimals of centres, sizes and headings
NEAR_GATE = 1e-3

def boxes(rows: Iterable[Row], side: str) -> list[Box]:
    found = []
    for row in rows:
        box = row_box(row, side)
        if box is None:
            sys.exit(f"{side} {row[f'{side}_id']} of {row['sequence']}/{row['scan']} has no box, but boxes are compared")
        found.append(box)
    return found


def footprint(it: Box) -> shapely.Polygon:
    upright = shapely.box(-it.length_m / 2, -it.width_m / 2, it.length_m / 2, it.width_m / 2)
    turned = affinity.rotate(upright, it.yaw_rad, origin=(0, 0), use_radians=True)
    return affinity.translate(turned, *it.center_m[:2])


def measured(criterion: str, first: list[Box], second: list[Box]) -> Floats:
    """Distance of centres or intersection over union of each of the first boxes (row) and of the second (column)."""
    if not first or not second:
        return np.zeros((len(first), len(second)))
    if criterion == "centre":
        a, b = (np.array([it.center_m[:2] for it in of_side]) for of_side in (first, second))
        return np.linalg.norm(a[:, None] - b, axis=2)
    a, b = (np.array([footprint(it) for it in of_side]) for of_side in (first, second))
    common, sizes = shapely.area(shapely.intersection(a[:, None], b)), [shapely.area(a), shapely.area(b)]
    if criterion == "iou-3d":
        sizes = [np.array([it.volume_m3 for it in of_side]) for of_side in (first, second)]
        tops = np.minimum.outer([it.top_m for it in first], [it.top_m for it in second])
        common *= np.maximum(tops - np.maximum.outer([it.bottom_m for it in first], [it.bottom_m for it in second]), 0.0)
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
        annotated = [it for it in rows if it["outcome"] in ("matched", "missed")]
        found = [it for it in rows if it["detection_id"] != ""]
        matched = [it for it in annotated if it["outcome"] == "matched"]
        values = measured(criterion, boxes(annotated, "annotation"), boxes(found, "detection"))
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


def report_values(run: Run) -> dict[tuple[str, ...], Any]:
    rows = run.report["rows"] + run.report["overall"]
    of_all = (it for it in rows if it["slice"] == "all")
    return {(it["dataset"], it["task"], it["detector"], it["metric"]): it["value"] for it in of_all}


def interpolated(recalls: Floats, precisions: Floats, positions: Floats) -> float:
    best = [max((p for r, p in zip(recalls, precisions) if r >= at - 1e-9), default=0.0) for at in positions]
    return float(np.mean(best))


Overlaps = Callable[[list[Row], list[Row]], Floats]


def coco_ap(images: Sequence[tuple[list[Row], list[Row]]], overlaps: Overlaps) -> float:
    """AP over 101 points at one threshold by COCOeval; `overlaps` are of annotations (row) and detections of an image."""
    of_all = {"category_id": 1, "bbox": [0, 0, 1, 1]}
    gts: list[dict[str, Any]] = []
    dts: list[dict[str, Any]] = []
    for image_id, (annotations, detections) in enumerate(images, start=1):
        for row in annotations:
            gt = {"id": len(gts) + 1, "image_id": image_id, "area": 1, "iscrowd": 0, "ignore": 0, "row": row}
            gts.append(gt | of_all)
        for row in detections:
            dts.append({"image_id": image_id, "score": float(row["detection_score"]), "row": row, **of_all})
    if not dts:
        return 0.0

    class Eval(COCOeval):
        def computeIoU(self, image_id: int, category_id: int) -> Floats | list[float]:
            gt, dt = self._gts[image_id, category_id], self._dts[image_id, category_id]
            order = np.argsort([-it["score"] for it in dt], kind="mergesort")
            return overlaps([it["row"] for it in gt], [dt[i]["row"] for i in order]).T if gt and dt else []

    with redirect_stdout(StringIO()):
        truth = COCO()
        truth.dataset = {"images": [{"id": i + 1} for i in range(len(images))], "annotations": gts,
                         "categories": [{"id": 1}], "info": {}}
        truth.createIndex()
        evaluation = Eval(truth, truth.loadRes(dts), "bbox")
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
    for name, a, b in zip(("101", "R40"), ours, curve_precisions(of_scans)):
        failures.check(abs(a - b) < 1e-9, f"{run.name} {key}: AP {name} {a}, from sklearn's curve {b}")
    images = [([it for it in rows if it["outcome"] in ("matched", "missed")],
               [it for it in rows if it["outcome"] in ("matched", "false")]) for rows in of_scans]
    given = coco_ap(images, lambda gts, dts: np.array([[float(gt is dt) for dt in dts] for gt in gts]))
    failures.check(abs(given - ours[0]) < 0.005, f"{run.name} {key}: AP {ours[0]}, pycocotools given our pairs {given}")
    line = f"  {run.name} {'/'.join(key)}: AP 101 {100 * ours[0]:.2f} (pycocotools given our pairs {100 * given:.2f}"
    criterion, gate = criterion_of(run)
    if criterion in ("bev-iou", "iou-3d"):
        # Half of COCO's threshold stands for our gate.
        own = coco_ap(
            images, lambda gts, dts: 0.5 / gate * measured(criterion, boxes(gts, "annotation"), boxes(dts, "detection"))
        )
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
