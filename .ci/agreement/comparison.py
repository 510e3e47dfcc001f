"""Holds the rows of a run against judgements made by ourselves."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from judgement import TALL, Judgement, Outcome
from labelled_scan import LabelledScan, Region
from program import BOX_ROUNDING, Row, ScanKey, row_box

# Costs have six decimals.
COST_ROUNDING = 1e-6

N_SHOWN = 20
SIDES = ("annotations", "detections")
SLICES = ("tall", "truncated")
SLICE_KEYS = ("dataset", "task", "detector", "slice", "metric")

# What scans.csv counts, by side and outcome.
COUNTED = {
    "tp": ("annotations", "matched"),
    "mo": ("annotations", "missed"),
    "fo": ("detections", "false"),
    "ignored_annotations": ("annotations", "ignored"),
    "ignored_detections": ("detections", "ignored"),
    "unknowable_detections": ("detections", "unknowable"),
}


class Failures(list[str]):
    """Messages, one for each disagreement."""

    def check(self, is_good: bool, message: str) -> None:
        if not is_good:
            self.append(message)

    def print(self) -> None:
        for failure in self[:N_SHOWN]:
            print(f"DISAGREES {failure}")
        print(f"{len(self)} disagreements")


class Tally(Counter[str]):
    """How much was compared, and how much left out because it depends on where an edge lies."""

    @property
    def share_left_out(self) -> float:
        return self["left out"] / max(self["annotations"] + self["detections"] + self["left out"], 1)


@dataclass(frozen=True)
class Judged:
    """One scan, detector and task: judged with edges as they are, and with all of them moved in and out a little."""

    name: str
    scans: Sequence[LabelledScan]
    judgements: Sequence[Judgement]
    n_detection_points: Sequence[int]
    knows_false: bool

    def outcomes(self, side: str) -> list[Outcome | None]:
        return getattr(self.judgements[0], side)

    def is_alike(self, side: str, idx: int) -> bool:
        """Whether the outcome of an annotation or detection is the same however the edges lie."""
        first, *others = [getattr(it, side) for it in self.judgements]
        return all(len(it) == len(first) and it[idx] == first[idx] for it in others)

    @property
    def n_left_out(self) -> int:
        return sum(not self.is_alike(side, idx) for side in SIDES for idx in range(len(self.outcomes(side))))

    def n_points(self, annotation_idx: int, *regions: Region) -> tuple[int, int]:
        """The least and the most points of an annotation in these regions."""
        scans = [it for it in self.scans if annotation_idx < len(it.annotations)]
        numbers = [sum(it.n_points_in(it.annotations[annotation_idx], region) for region in regions) for it in scans]
        return min(numbers), max(numbers)


@dataclass(frozen=True)
class Comparison:
    """What is compared, and what comes of it."""

    judged: Judged
    tally: Tally
    failures: Failures

    def fail_unless(self, is_good: bool, name: str, ours: object, theirs: object) -> None:
        self.failures.check(is_good, f"{self.judged.name}{name}: {ours}, the program has {theirs}")

    def compare(self, matches: list[Row], scan_row: Row) -> None:
        """Compares the rows of matches.csv and the one of scans.csv."""
        self.compare_side("annotations", "annotation_id", "detection_id", matches)
        self.compare_side("detections", "detection_id", "annotation_id", matches)
        self.tally["left out"] += self.judged.n_left_out
        self.compare_counts(scan_row)

    def compare_side(self, side: str, column: str, partner: str, matches: list[Row]) -> None:
        """Compares all annotations or all detections."""
        rows = {int(row[column]): row for row in matches if row[column]}
        outcomes = self.judged.outcomes(side)
        n_rows = sum(row[column] != "" for row in matches)
        self.fail_unless(n_rows == len(rows) and set(rows) <= set(range(len(outcomes))), "", f"{len(outcomes)} {side}", n_rows)
        for idx, outcome in enumerate(outcomes):
            name, row = f", {column} {idx}", rows.get(idx)
            if not self.judged.is_alike(side, idx):
                pass
            elif row is None or outcome is None:
                self.fail_unless(row is None and outcome is None, name, outcome, row and row["outcome"])
            else:
                self.tally[side] += 1
                self.tally[outcome.kind] += 1
                self.compare_outcome(name, outcome, row, partner)
            if row is not None and side == "annotations":
                self.compare_annotation(name, idx, row)
            if row is not None and side == "detections":
                n_points = self.judged.n_detection_points[idx]
                self.fail_unless(n_points == int(row["detection_n_points"]), name, n_points, row["detection_n_points"])

    def compare_outcome(self, name: str, outcome: Outcome, row: Row, partner: str) -> None:
        theirs = row["outcome"], int(row[partner]) if row[partner] else None
        self.fail_unless((outcome.kind, outcome.partner) == theirs, name, outcome, (*theirs, row["reason"]))
        if outcome.kind == "ignored":
            self.fail_unless(row["reason"] in outcome.reasons, name, outcome, row["reason"])

    def compare_annotation(self, name: str, idx: int, row: Row) -> None:
        """Compares what the row says of the object itself, and the cost of its pair."""
        scan = self.judged.scans[0]
        annotation = scan.annotations[idx]
        for column, regions in (("n_points", Region), ("n_points_outside", [Region.OUTSIDE])):
            theirs = row[f"annotation_{column}"]
            least, most = self.judged.n_points(idx, *regions)
            self.fail_unless(least <= int(theirs) <= most, f"{name}, {column}", (least, most), theirs)
        facts = annotation.class_name, "" if annotation.track is None else str(annotation.track)
        of_row = row["annotation_class"], row["annotation_track"]
        self.fail_unless(facts == of_row, name, facts, of_row)
        box = row_box(row, "annotation")
        is_same_box = box is None if annotation.box is None else box is not None and box.is_near(annotation.box, BOX_ROUNDING)
        self.fail_unless(is_same_box, name, annotation.box, box)
        position = [float(row[f"annotation_center_{it}_m"]) for it in "xyz"]
        is_there = np.allclose(scan.center_m(annotation), position, rtol=0, atol=BOX_ROUNDING)
        self.fail_unless(is_there, name, scan.center_m(annotation), position)
        outcome = self.judged.outcomes("annotations")[idx]
        if outcome is not None and outcome.cost is not None and row["cost"]:
            # Points on the faces of its box may or may not be its own.
            least, most = self.judged.n_points(idx, *Region)
            tolerance = COST_ROUNDING + (most - least) / most
            self.fail_unless(abs(outcome.cost - float(row["cost"])) <= tolerance, name, outcome, row["cost"])

    def compare_counts(self, scan_row: Row) -> None:
        n_points = len(self.judged.scans[0].points_m)
        self.fail_unless(scan_row["n_points"] == str(n_points), "", f"{n_points} points", scan_row["n_points"])
        for column, (side, kind) in COUNTED.items():
            ours = sum(it is not None and it.kind == kind for it in self.judged.outcomes(side))
            if column == "fo" and not self.judged.knows_false:
                self.fail_unless(scan_row[column] == "", f", {column}", "undefined", scan_row[column])
            else:
                is_near = scan_row[column] != "" and abs(int(scan_row[column]) - ours) <= self.judged.n_left_out
                self.fail_unless(is_near, f", {column}", ours, scan_row[column])


def compare_slices(judged: dict[ScanKey, Judged], report: dict[str, Any], failures: Failures) -> Counter[str]:
    """Compares the slices `tall` and `truncated` of report.json; gives what they add up to."""
    ours: Counter[tuple[str, ...]] = Counter()
    n_left_out: Counter[tuple[str, ...]] = Counter()
    for (dataset, _, _, detector, task), it in judged.items():
        n_left_out[dataset, task, detector] += it.n_left_out
        for idx, outcome in enumerate(it.outcomes("annotations")):
            for slice_name in slices_of(it.scans[0], idx, outcome):
                ours[dataset, task, detector, slice_name, "no"] += 1
                ours[dataset, task, detector, slice_name, "tp"] += outcome is not None and outcome.partner is not None
    theirs = {tuple(row[it] for it in SLICE_KEYS): row["value"] for row in report["rows"]}
    total: Counter[str] = Counter()
    for key in ours.keys() | {it for it in theirs if it[3] in SLICES and it[4] in ("no", "tp")}:
        value = theirs.get(key, 0)
        is_near = abs(ours[key] - value) <= n_left_out[key[:3]]
        failures.check(is_near, f"{' '.join(key)}: {ours[key]}, report.json has {value}")
        total[f"{key[3]} {key[4]}"] += ours[key]
    return total


def slices_of(scan: LabelledScan, idx: int, outcome: Outcome | None) -> list[str]:
    if outcome is None:
        return []
    annotation = scan.annotations[idx]
    is_cut = 2 * scan.n_points_in(annotation, Region.OUTSIDE) >= annotation.n_points
    return ["tall"] * (outcome.reasons == TALL) + ["truncated"] * (outcome.kind in ("matched", "missed") and is_cut)
