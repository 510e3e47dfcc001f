"""Holds the rows of a run against judgements made by ourselves."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from failures import Failures
from judgement import Judgement, Outcome
from labelled_scan import Annotation, LabelledScan
from program import BOX_ROUNDING, Row, row_box

# Costs have six decimals.
COST_ROUNDING = 1e-6

# What scans.csv counts, by side and outcome.
COUNTED = {
    "tp": ("annotations", "matched"),
    "mo": ("annotations", "missed"),
    "fo": ("detections", "false"),
    "ignored_annotations": ("annotations", "ignored"),
    "ignored_detections": ("detections", "ignored"),
    "unknowable_detections": ("detections", "unknowable"),
}


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

    def n_points(self, annotation_idx: int) -> tuple[int, int]:
        """The least and the most points of an annotation."""
        numbers = [it.annotations[annotation_idx].n_points for it in self.scans if annotation_idx < len(it.annotations)]
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
        n_left_out = self.compare_side("annotations", "annotation_id", "detection_id", matches)
        n_left_out += self.compare_side("detections", "detection_id", "annotation_id", matches)
        self.tally["scans"] += 1
        self.tally["left out"] += n_left_out
        self.compare_counts(scan_row, n_left_out)

    def compare_side(self, side: str, column: str, partner: str, matches: list[Row]) -> int:
        """Compares all annotations or all detections; gives the number of those that are left out."""
        rows = {int(row[column]): row for row in matches if row[column]}
        outcomes, n_left_out = self.judged.outcomes(side), 0
        n_rows = sum(row[column] != "" for row in matches)
        self.fail_unless(n_rows == len(rows) and set(rows) <= set(range(len(outcomes))), "", f"{len(outcomes)} {side}", n_rows)
        for idx, outcome in enumerate(outcomes):
            name, row = f", {column} {idx}", rows.get(idx)
            if not self.judged.is_alike(side, idx):
                n_left_out += 1
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
        return n_left_out

    def compare_outcome(self, name: str, outcome: Outcome, row: Row, partner: str) -> None:
        theirs = row["outcome"], int(row[partner]) if row[partner] else None
        self.fail_unless((outcome.kind, outcome.partner) == theirs, name, outcome, (*theirs, row["reason"]))
        if outcome.kind == "ignored":
            self.fail_unless(row["reason"] in outcome.reasons, name, outcome, row["reason"])

    def compare_annotation(self, name: str, idx: int, row: Row) -> None:
        """Compares what the row says of the object itself, and the cost of its pair."""
        annotation: Annotation = self.judged.scans[0].annotations[idx]
        least, most = self.judged.n_points(idx)
        self.fail_unless(least <= int(row["annotation_n_points"]) <= most, name, (least, most), row["annotation_n_points"])
        facts = annotation.class_name, "" if annotation.track is None else str(annotation.track)
        theirs = row["annotation_class"], row["annotation_track"]
        self.fail_unless(facts == theirs, name, facts, theirs)
        box = row_box(row, "annotation")
        is_same_box = box is None if annotation.box is None else box is not None and box.is_near(annotation.box, BOX_ROUNDING)
        self.fail_unless(is_same_box, name, annotation.box, box)
        outcome = self.judged.outcomes("annotations")[idx]
        if outcome is not None and outcome.cost is not None and row["cost"]:
            # Points on the faces of its box may or may not be its own.
            tolerance = COST_ROUNDING + (most - least) / most
            self.fail_unless(abs(outcome.cost - float(row["cost"])) <= tolerance, name, outcome, row["cost"])

    def compare_counts(self, scan_row: Row, n_left_out: int) -> None:
        n_points = len(self.judged.scans[0].points_m)
        self.fail_unless(scan_row["n_points"] == str(n_points), "", f"{n_points} points", scan_row["n_points"])
        for column, (side, kind) in COUNTED.items():
            ours = sum(it is not None and it.kind == kind for it in self.judged.outcomes(side))
            if column == "fo" and not self.judged.knows_false:
                self.fail_unless(scan_row[column] == "", f", {column}", "undefined", scan_row[column])
            else:
                is_near = scan_row[column] != "" and abs(int(scan_row[column]) - ours) <= n_left_out
                self.fail_unless(is_near, f", {column}", ours, scan_row[column])
