"""Judges detections again under the default criterion, from points, boxes and clusters, and fails where scanbench disagrees.

    judge_again.py SCANBENCH SCRATCH

Simulated streets are converted to KITTI tracking and to SemanticKITTI; real scans lie in $SCANBENCH_TEST_DATA/data. Of each
scan we read points and labels ourselves, take clusters and classes of detections from `scanbench detect`, judge both tasks,
and hold the outcome of every annotation and detection against the `matches.csv` and `scans.csv` of a `scanbench run`.

Everything is judged three times: as it is, and with all edges moved in and out by SLACK. What then comes out differently is
left out and counted, at most MAX_SHARE_LEFT_OUT. At last rows of the runs are damaged, one at a time, and each damage has to
be found.
"""

import math
import os
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from judgement import TASKS, Outcome, judge, tall_objects
from labelled_scans import Dataset, Region, Scan, kitti, semantic_kitti, write_png
from program import rows, run
from run_directory import Failures, Row, Run, box_of, key_of

SLACK = 1e-4
MAX_SHARE_LEFT_OUT = 0.01
# Of metres and radians in the files, which have four decimals, and of costs, which have six.
BOX_ROUNDING, COST_ROUNDING = 2e-4, 1e-6
DETECTORS = ("hierarchical", "kd-tree", "pca")
SIMULATED = ("streets", "streets-ahead", "--scans", "0..20:10")
ALL_SCANS = "0..1000"
OBJECT_IMAGE_SIZES_PX = ((1000, 300), (1224, 370))
# SemanticKITTI has no words of its own for these.
SEMANTIC_CLASSES = {"van": "car", "trailer": "misc", "sitting-person": "pedestrian"}
# What scans.csv counts, by side and outcome.
COUNTED = {
    "tp": ("annotation", "matched"),
    "mo": ("annotation", "missed"),
    "fo": ("detection", "false"),
    "ignored_annotations": ("annotation", "ignored"),
    "ignored_detections": ("detection", "ignored"),
    "unknowable_detections": ("detection", "unknowable"),
}
SLICES = ("tall", "truncated")
# Data set, drive, number of the scan, detector, task.
ScanKey = tuple[str, ...]
# The outcome of the row that is damaged, what it is then, and the columns that say so; no row is lost.
DAMAGES = [
    ("matched", "missed", lambda row: {"outcome": "missed"}),
    ("missed", "ignored", lambda row: {"outcome": "ignored"}),
    ("ignored", "missed", lambda row: {"outcome": "missed"}),
    ("false", "ignored", lambda row: {"outcome": "ignored"}),
    ("unknowable", "false", lambda row: {"outcome": "false"}),
    ("matched", "of another detection", lambda row: {"detection_id": str(int(row["detection_id"]) + 1)}),
    ("matched", "of another cost", lambda row: {"cost": str(float(row["cost"]) + 0.01)}),
    ("ignored", "for another reason", lambda row: {"reason": "too dark"}),
    ("missed", "lost", None),
]


def is_near(a: np.ndarray | None, b: np.ndarray | None) -> bool:
    """Whether two boxes are the same but for rounding, or neither is there."""
    if a is None or b is None:
        return a is b
    turned_rad = math.remainder(a[6] - b[6], 2 * math.pi)
    return max(abs(turned_rad), np.abs(a - b)[:6].max()) < BOX_ROUNDING


@dataclass(frozen=True)
class Judged:
    """One scan, detector and task: read and judged with edges as they are, and with all moved in and out a little."""

    name: str
    scans: list[Scan]
    outcomes: list[dict[tuple[str, int], Outcome]]
    n_points: list[int]
    knows_false: bool

    @property
    def keys(self) -> list[tuple[str, int]]:
        sides = ("annotation", len(self.scans[0].annotations)), ("detection", len(self.n_points))
        return [(side, idx) for side, n in sides for idx in range(n)]

    def is_alike(self, key: tuple[str, int]) -> bool:
        """Whether the outcome of an annotation or detection is the same however the edges lie."""
        first, *others = (it.get(key) for it in self.outcomes)
        as_many = key[0] == "detection" or len({len(it.annotations) for it in self.scans}) == 1
        return as_many and all(it == first for it in others)

    @property
    def n_left_out(self) -> int:
        return sum(not self.is_alike(it) for it in self.keys)

    def n_points_of(self, annotation_idx: int, *regions: Region) -> tuple[int, int]:
        """The least and the most points of an annotation in these regions."""
        scans = [it for it in self.scans if annotation_idx < len(it.annotations)]
        numbers = [it.n_points_in(it.annotations[annotation_idx], *regions) for it in scans]
        return min(numbers), max(numbers)

    def compare(self, matches: list[Row], scan_row: Row, failures: Failures) -> Counter[str]:
        """Holds it against rows of matches.csv and the one of scans.csv; how much was compared, and left out."""
        tally, by_key, n_left_out = Counter(), {}, self.n_left_out

        def check(is_good: bool, what: object, ours: object, theirs: object) -> None:
            failures.check(is_good, f"{self.name}, {what}: {ours}, the program has {theirs}")

        def same(what: object, ours: object, theirs: object) -> None:
            check(ours == theirs, what, ours, theirs)

        for row, side in product(matches, ("annotation", "detection")):
            if row[f"{side}_id"]:
                key = side, int(row[f"{side}_id"])
                check(key in self.keys and key not in by_key, key, "once", "twice, or one that is not there")
                by_key[key] = row
        for key in self.keys:
            (side, idx), row, outcome = key, by_key.get(key), self.outcomes[0].get(key)
            if self.is_alike(key):
                check((row is None) == (outcome is None), key, outcome, row and row["outcome"])
                if row is not None and outcome is not None:
                    tally += Counter([side, outcome.kind])
                    partner = row["detection_id" if side == "annotation" else "annotation_id"]
                    same(key, (outcome.kind, outcome.partner), (row["outcome"], int(partner) if partner else None))
                    check(outcome.kind != "ignored" or row["reason"] in outcome.reasons, key, outcome, row["reason"])
            if row is not None and side == "detection":
                same(key, str(self.n_points[idx]), row["detection_n_points"])
            if row is not None and side == "annotation":
                self.compare_annotation(idx, row, outcome, check)

        # What scans.csv counts.
        same("points", str(len(self.scans[0].points_m)), scan_row["n_points"])
        for column, (side, kind) in COUNTED.items():
            ours, theirs = sum(key[0] == side and it.kind == kind for key, it in self.outcomes[0].items()), scan_row[column]
            if column == "fo" and not self.knows_false:
                same(column, "", theirs)
            else:
                check(theirs != "" and abs(int(theirs) - ours) <= n_left_out, column, ours, theirs)
        return tally + Counter({"left out": n_left_out})

    def compare_annotation(self, idx: int, row: Row, outcome: Outcome | None, check) -> None:
        """What the row says of the object itself, and the cost of its pair."""
        scan, what = self.scans[0], f"annotation {idx}"
        annotation, box = scan.annotations[idx], box_of(row, "annotation_")
        for column, regions in (("annotation_n_points", Region), ("annotation_n_points_outside", [Region.OUTSIDE])):
            least, most = self.n_points_of(idx, *regions)
            check(least <= int(row[column]) <= most, f"{what}, {column}", (least, most), row[column])
        facts = annotation.class_name, "" if annotation.track is None else str(annotation.track)
        check(facts == (row["annotation_class"], row["annotation_track"]), what, facts, row)
        check(is_near(annotation.box, box), what, annotation.box, box)
        center_m, position = scan.center_m(annotation), [float(row[f"annotation_center_{it}_m"]) for it in "xyz"]
        check(np.allclose(center_m, position, rtol=0, atol=BOX_ROUNDING), what, center_m, position)
        if outcome is not None and outcome.cost is not None and row["cost"]:
            # Points on the faces of its box may or may not be its own.
            least, most = self.n_points_of(idx, *Region)
            tolerance = COST_ROUNDING + (most - least) / most
            check(abs(outcome.cost - float(row["cost"])) <= tolerance, what, outcome, row["cost"])

    def slices(self) -> Counter[tuple[str, str]]:
        """NO and TP of the slices of its annotations."""
        found, scan = Counter(), self.scans[0]
        for idx, annotation in enumerate(scan.annotations):
            outcome = self.outcomes[0].get(("annotation", idx), Outcome("not asked for"))
            is_cut = 2 * scan.n_points_in(annotation, Region.OUTSIDE) >= len(annotation.points)
            is_in = ("tall" in outcome.reasons, outcome.kind in ("matched", "missed") and is_cut)
            for name in (name for name, holds in zip(SLICES, is_in) if holds):
                found += Counter({(name, "no"): 1, (name, "tp"): int(outcome.partner is not None)})
        return found


def compare_slices(judged: dict[ScanKey, Judged], report: dict, failures: Failures) -> Counter[tuple[str, str]]:
    """Compares the slices of report.json; gives what they add up to."""
    ours, n_left_out, total = Counter(), Counter(), Counter()
    for (dataset, _, _, detector, task), it in judged.items():
        n_left_out[dataset, task, detector] += it.n_left_out
        total += (of_scan := it.slices())
        ours += Counter({(dataset, task, detector, *key): n for key, n in of_scan.items()})
    columns = ("dataset", "task", "detector", "slice", "metric")
    of_tasks = (row for row in report["rows"] if row["task"] in TASKS)
    theirs = {tuple(row[it] for it in columns): row["value"] for row in of_tasks}
    for key in ours.keys() | {it for it in theirs if it[3] in SLICES and it[4] in ("no", "tp")}:
        is_same = abs(ours[key] - theirs.get(key, 0)) <= n_left_out[key[:3]]
        failures.check(is_same, f"{' '.join(key)}: {ours[key]}, report.json has {theirs.get(key, 0)}")
    return total


def judge_scan(scanbench: str, of: Run, name: str, dataset: Dataset, drive: str, number: int) -> dict[ScanKey, Judged]:
    """Judges one scan for all detectors and tasks."""
    read = dataset.read(drive, number)
    scans = [read(slack) for slack in (0.0, -SLACK, SLACK)]
    tall, judged = [tall_objects(it) for it in scans], {}
    for detector in DETECTORS:
        clusters, boxes = (of.path / f"{name}-{drive}-{number}-{detector}.{it}" for it in ("u32", "csv"))
        found = ["--scan", f"{drive}/{number:06}", "-d", detector, "-o", clusters, "--boxes", boxes]
        run(scanbench, "detect", dataset.root, *found)
        # Clusters are numbered from 1 in files, and 0 is none.
        of_point, boxes = np.fromfile(clusters, "<u4").astype(np.int64) - 1, rows(boxes)
        n_points = np.bincount(of_point[of_point >= 0], minlength=len(boxes)).tolist()
        if n_points != [int(row["n_points"]) for row in boxes]:
            raise ValueError(f"{dataset.root} {drive}/{number} {detector}: boxes and clusters have other numbers of points")
        for task in TASKS:
            knows_false = dataset.annotates_everything or (task == "vehicles" and dataset.annotates_vehicles)
            of_task = [row["class"] for row in boxes], task, "false" if knows_false else "unknowable"
            outcomes = [judge(*it, of_point, *of_task) for it in zip(scans, tall)]
            key = name, drive, str(number), detector, task
            judged[key] = Judged(" ".join(key), scans, outcomes, n_points, knows_false)
    return judged


def compare_run(of: Run, judged: dict[ScanKey, Judged], failures: Failures) -> Counter[str]:
    failures.check(of.scans.keys() == judged.keys(), f"{of.path}: scans.csv has other rows than were judged again")
    common = of.scans.keys() & judged.keys()
    return sum((judged[key].compare(of.matches.get(key, []), of.scans[key], failures) for key in common), Counter())


def check_source(
    scanbench: str, name: str, datasets: list[Dataset], selection: str, scratch: Path, failures: Failures
) -> None:
    """Judges these scans of data sets of one kind."""
    path = scratch / name.replace(" ", "-").replace(",", "")
    options = ["--scans", selection, "-d", ",".join(DETECTORS), "--no-rrd", "-o", path]
    run(scanbench, "run", *(it.root for it in datasets), *options)
    of, by_root = Run(path), {Path(it.root).resolve(): it for it in datasets}
    # The classes that a detector gives are tasks, too; agree.py judges those.
    of.scans, of.matches = ({key: it for key, it in of_run.items() if key[4] in TASKS} for of_run in (of.scans, of.matches))
    by_id = {it["id"]: by_root[Path(it["root"]).resolve()] for it in of.manifest["datasets"]}
    wanted = sorted({key[:3] for key in of.scans})
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        of_scans = pool.map(lambda it: judge_scan(scanbench, of, it[0], by_id[it[0]], it[1], int(it[2])), wanted)
        judged = {key: value for of_scan in of_scans for key, value in of_scan.items()}
    undamaged = Failures()
    tally = compare_run(of, judged, undamaged)
    failures += undamaged
    slices = compare_slices(judged, of.report, failures)
    print(f"  {name}: {len(wanted)} scans, {tally['annotation']} annotations and {tally['detection']} detections")
    outcomes = ", ".join(f"{tally[it]} {it}" for it in ("matched", "missed", "false", "unknowable", "ignored"))
    print(f"    {outcomes}, {tally['left out']} left out at an edge")
    print("    slices: " + ", ".join(f"{slices[it, 'no']} {it} of which {slices[it, 'tp']} found" for it in SLICES))
    failures.check(tally["matched"] > 0, f"{name}: no pairs at all")
    share = tally["left out"] / max(tally["annotation"] + tally["detection"] + tally["left out"], 1)
    failures.check(share <= MAX_SHARE_LEFT_OUT, f"{name}: {share:.1%} left out, at most {MAX_SHARE_LEFT_OUT:.0%} may be")
    check_damage(of, judged, len(undamaged), failures)


def check_damage(of: Run, judged: dict[ScanKey, Judged], n_undamaged: int, failures: Failures) -> None:
    """Every kind of damage that the rows allow has to be found."""

    def is_judged(row: Row) -> bool:
        keys = [(side, int(row[f"{side}_id"])) for side in ("annotation", "detection") if row[f"{side}_id"]]
        return all(judged[key_of(row)].is_alike(it) for it in keys)

    n_found, n_damages, all_rows = 0, 0, [row for rows in of.matches.values() for row in rows]
    for outcome, becomes, damage in DAMAGES:
        may_be_damaged = [row for row in all_rows if row["outcome"] == outcome and is_judged(row)]
        if not may_be_damaged:
            continue
        row, damaged, found = may_be_damaged[len(may_be_damaged) // 2], copy(of), Failures()
        others = [it for it in of.matches[key_of(row)] if it is not row]
        damaged.matches = {**of.matches, key_of(row): others + ([row | damage(row)] if damage else [])}
        compare_run(damaged, judged, found)
        n_damages, n_found = n_damages + 1, n_found + (len(found) > n_undamaged)
        failures.check(len(found) > n_undamaged, f"{of.path}: nobody sees that what was {outcome} is {becomes}")
    print(f"    {n_found} of {n_damages} kinds of damage found")


def check_conversion(originals: Run, name: str, converted: Dataset, failures: Failures) -> int:
    """Holds the scans of data set `name`, as we read them, against rows of the originals; gives the number of annotations.

    KITTI tracking keeps classes, tracks and boxes, in order, and SemanticKITTI, which numbers the scans of a drive anew,
    which points are an object.
    """
    keeps_points = (Path(converted.root) / "sequences").is_dir()
    n_annotations, n_of_drive = 0, Counter()
    of_dataset = [(key, it) for key, it in originals.matches.items() if (key[0], key[4]) == (name, "objects")]
    for (_, drive, number, _, _), matches in sorted(of_dataset, key=lambda it: int(it[0][2])):
        theirs = sorted((row for row in matches if row["annotation_id"]), key=lambda row: int(row["annotation_id"]))
        scan = converted.read(drive, n_of_drive[drive] if keeps_points else int(number))(0.0)
        where, n_of_drive[drive] = f"{converted.root} {drive}/{number}", n_of_drive[drive] + 1
        if keeps_points:
            classes = (SEMANTIC_CLASSES.get(row["annotation_class"], row["annotation_class"]) for row in theirs)
            original = Counter(zip(classes, (int(row["annotation_n_points"]) for row in theirs)))
            ours = Counter((it.class_name, len(it.points)) for it in scan.annotations)
            failures.check(ours == original, f"{where}: {ours - original}, where the original has {original - ours}")
        else:
            n_ours = len(scan.annotations)
            failures.check(n_ours == len(theirs), f"{where}: {n_ours} annotations, the original has {len(theirs)}")
            for ours, row in zip(scan.annotations, theirs):
                is_same = ours.box is not None and is_near(ours.box, box_of(row, "annotation_"))
                is_same &= (ours.class_name, str(ours.track)) == (row["annotation_class"], row["annotation_track"])
                failures.check(is_same, f"{where}: {ours}, the original has {row}")
        n_annotations += len(theirs)
    return n_annotations


def simulated_sources(scanbench: str, scratch: Path, failures: Failures) -> dict[str, tuple[list[Dataset], str]]:
    """The same streets in both layouts, all round and labelled ahead of the sensor alone."""
    run(scanbench, "run", *SIMULATED, "-d", DETECTORS[0], "--no-rrd", "-o", scratch / "originals")
    originals, sources = Run(scratch / "originals"), {}
    for layout, open_folder in (("kitti-tracking", kitti), ("semantic-kitti", semantic_kitti)):
        run(scanbench, "data", "simulate", *SIMULATED, "--to", layout, "-o", scratch / layout)
        datasets = {it.name: open_folder(it) for it in sorted((scratch / layout).iterdir())}
        n_same = sum(check_conversion(originals, name, it, failures) for name, it in datasets.items())
        print(f"  {layout}: {n_same} annotations of {len(datasets)} converted data sets held against the originals")
        sources[f"simulated, as {layout}"] = list(datasets.values()), ALL_SCANS
    return sources


def real_sources(scratch: Path, failures: Failures) -> dict[str, tuple[list[Dataset], str]]:
    """Those of real data; none if the variable is not set, and a failure if it names a folder that has none."""
    root = os.environ.get("SCANBENCH_TEST_DATA")
    data = Path(root or "") / "data"
    if not root or not data.is_dir():
        message = f"3 checks skipped: no real data (SCANBENCH_TEST_DATA is {root or 'not set'})"
        failures.check(root is None, message)
        print(message)
        return {}
    # Scans of objects with images of made sizes, on which the labelled region depends.
    original, objects = (data / "kitti_object/training").resolve(), scratch / "kitti_object/training"
    (objects / "image_2").mkdir(parents=True)
    for name in ("velodyne", "label_2", "calib"):
        (objects / name).symlink_to(original / name)
    for idx, labels in enumerate(sorted((original / "label_2").iterdir())):
        write_png(objects / f"image_2/{labels.stem}.png", OBJECT_IMAGE_SIZES_PX[idx // 2 % 2])
    return {
        "KITTI tracking": ([kitti(data / "kitti_tracking")], "2..40:5"),
        "KITTI object": ([kitti(objects.parent)], "0..8:2"),
        "SemanticKITTI": ([semantic_kitti(data / "semantic_kitti")], ALL_SCANS),
    }


def main(scanbench: str, scratch: Path) -> None:
    scratch.mkdir(parents=True, exist_ok=True)
    failures = Failures()
    sources = simulated_sources(scanbench, scratch, failures) | real_sources(scratch, failures)
    for name, (datasets, selection) in sources.items():
        check_source(scanbench, name, datasets, selection, scratch, failures)
    failures.print()
    sys.exit(bool(failures))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
