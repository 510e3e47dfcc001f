"""Judges detections again under the default criterion, from points, boxes and clusters, and fails where scanbench disagrees.

    judge_again.py SCANBENCH SCRATCH

Simulated streets are converted to KITTI tracking and to SemanticKITTI; real scans lie in $SCANBENCH_TEST_DATA/data. Of each scan
we read points and labels ourselves, take clusters and classes of detections from `scanbench detect`, judge both tasks, and hold
the outcome of every annotation and detection against the `matches.csv` and `scans.csv` of a `scanbench run`.

Programs round differently, so everything is judged three times: as it is, and with all edges (faces of boxes, rims of images,
cells, ranges) moved in and out by SLACK. What then comes out differently is left out and counted, at most MAX_SHARE_LEFT_OUT.

At last rows of the runs are damaged, one at a time, and each damage has to be found.
"""

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from comparison import SLICES, Comparison, Failures, Judged, Tally, compare_slices
from conversions import check_boxes, check_conversion, check_points
from damage import damaged_copies
from judgement import TASKS, judge, points_of_each
from kitti_scans import kitti, write_png
from labelled_scan import Dataset
from local_ground import tall_objects
from program import Program, Row, Run, ScanKey, key_of
from semantic_kitti_scans import semantic_kitti

SLACK = 1e-4
MAX_SHARE_LEFT_OUT = 0.01
DETECTORS = ("hierarchical", "kd-tree", "pca")
LAYOUTS = (("kitti-tracking", kitti, check_boxes), ("semantic-kitti", semantic_kitti, check_points))
ALL_SCANS = "0..1000"
SIMULATED = ("streets", "streets-ahead", "--scans", "0..20:10")
OBJECT_IMAGE_SIZES_PX = ((1000, 300), (1224, 370))
DATA_VARIABLE = "SCANBENCH_TEST_DATA"


@dataclass(frozen=True)
class Source:
    """Data sets of one kind, and which of their scans are judged."""

    name: str
    datasets: list[Dataset]
    selection: str


def simulated_sources(program: Program, scratch: Path, failures: Failures) -> list[Source]:
    """The same streets in both layouts, all round and labelled ahead of the sensor alone."""
    program.call("run", *SIMULATED, "-d", DETECTORS[0], "--no-rrd", "-o", scratch / "originals")
    originals, sources = Run(scratch / "originals"), []
    for layout, open_folder, check in LAYOUTS:
        program.call("data", "simulate", *SIMULATED, "--to", layout, "-o", scratch / layout)
        datasets = {it.name: open_folder(it) for it in sorted((scratch / layout).iterdir())}
        n_same = sum(check_conversion(originals, name, it, check, failures) for name, it in datasets.items())
        print(f"  {layout}: {n_same} annotations of {len(datasets)} converted data sets held against the originals")
        sources.append(Source(f"simulated, as {layout}", list(datasets.values()), ALL_SCANS))
    return sources


def objects_with_images(original: Path, scratch: Path) -> Path:
    """The same scans with images of made sizes, on which the labelled region depends."""
    folder = scratch / "kitti_object/training"
    (folder / "image_2").mkdir(parents=True)
    for name in ("velodyne", "label_2", "calib"):
        (folder / name).symlink_to(original / name)
    for idx, labels in enumerate(sorted((original / "label_2").iterdir())):
        write_png(folder / f"image_2/{labels.stem}.png", OBJECT_IMAGE_SIZES_PX[idx // 2 % 2])
    return folder.parent


def real_sources(data: Path, scratch: Path) -> list[Source]:
    objects = objects_with_images((data / "kitti_object/training").resolve(), scratch)
    return [
        Source("KITTI tracking", [kitti(data / "kitti_tracking")], "2..40:5"),
        Source("KITTI object", [kitti(objects)], "0..8:2"),
        Source("SemanticKITTI", [semantic_kitti(data / "semantic_kitti")], ALL_SCANS),
    ]


def judge_scan(program: Program, run: Run, dataset: Dataset, drive: str, number: int) -> dict[ScanKey, Judged]:
    """Judges one scan for all detectors and tasks."""
    read = dataset.read(drive, number)
    scans = [read(slack) for slack in (0.0, -SLACK, SLACK)]
    tall = [tall_objects(it) for it in scans]
    judged = {}
    for detector in DETECTORS:
        detections, boxes = program.detect(dataset.root, drive, number, detector, run.path)
        n_points = [int(it) for it in points_of_each(detections)]
        if n_points != [int(row["n_points"]) for row in boxes]:
            raise ValueError(f"{dataset.root} {drive}/{number} {detector}: boxes and clusters have other numbers of points")
        for task in TASKS:
            knows_false = dataset.annotates_everything or (task == "vehicles" and dataset.annotates_vehicles)
            unmatched = "false" if knows_false else "unknowable"
            judgements = [judge(*it, detections, task, unmatched) for it in zip(scans, tall)]
            key = run.id_of(dataset.root), drive, str(number), detector, task
            judged[key] = Judged(" ".join(key), scans, judgements, n_points, knows_false)
    return judged


def compare_run(run: Run, judged: dict[ScanKey, Judged], failures: Failures) -> Tally:
    tally = Tally()
    failures.check(set(run.scans) == set(judged), f"{run.path}: rows of scans.csv that were not judged again, or the other way")
    for key in set(run.scans) & set(judged):
        Comparison(judged[key], tally, failures).compare(run.matches.get(key, []), run.scans[key])
    return tally


def check_source(program: Program, source: Source, scratch: Path, failures: Failures) -> None:
    path = scratch / source.name.replace(" ", "-").replace(",", "")
    roots = [it.root for it in source.datasets]
    program.call("run", *roots, "--scans", source.selection, "-d", ",".join(DETECTORS), "--no-rrd", "-o", path)
    run = Run(path)
    by_id = {run.id_of(it.root): it for it in source.datasets}
    wanted = sorted({key[:3] for key in run.scans})
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        of_scans = pool.map(lambda it: judge_scan(program, run, by_id[it[0]], it[1], int(it[2])), wanted)
        judged = {key: value for of_scan in of_scans for key, value in of_scan.items()}
    tally = compare_run(run, judged, failures)
    slices = compare_slices(judged, run.report, failures)
    of_outcomes = ", ".join(f"{tally[it]} {it}" for it in ("matched", "missed", "false", "unknowable", "ignored"))
    print(f"  {source.name}: {len(wanted)} scans, {tally['annotations']} annotations and {tally['detections']} detections")
    print(f"    {of_outcomes}, {tally['left out']} left out at an edge")
    of_slices = ", ".join(f"{slices[f'{it} no']} {it} of which {slices[f'{it} tp']} found" for it in SLICES)
    print(f"    slices: {of_slices}")
    failures.check(tally["matched"] > 0, f"{source.name}: no pairs at all")
    is_bounded = tally.share_left_out <= MAX_SHARE_LEFT_OUT
    failures.check(is_bounded, f"{source.name}: {tally.share_left_out:.1%} left out, at most {MAX_SHARE_LEFT_OUT:.0%} may be")
    check_damage(run, judged, failures)


def check_damage(run: Run, judged: dict[ScanKey, Judged], failures: Failures) -> None:
    """Every damage has to be found."""

    def is_judged(row: Row) -> bool:
        it, annotation, detection = judged[key_of(row)], row["annotation_id"], row["detection_id"]
        is_alike = not annotation or it.is_alike("annotations", int(annotation))
        return is_alike and (not detection or it.is_alike("detections", int(detection)))

    copies = list(damaged_copies(run, is_judged))
    undamaged = Failures()
    compare_run(run, judged, undamaged)
    n_found = 0
    for damage, copy in copies:
        found = Failures()
        compare_run(copy, judged, found)
        n_found += len(found) > len(undamaged)
        failures.check(len(found) > len(undamaged), f"{run.path}: nobody sees that what was {damage}")
    print(f"    {n_found} of {len(copies)} kinds of damage found")


def real_data(failures: Failures) -> Path | None:
    """The folder of real data; a failure if the variable names one that has none, and a line if it is not set."""
    root = os.environ.get(DATA_VARIABLE)
    data = Path(root) / "data" if root else None
    if data is not None and data.is_dir():
        return data
    message = f"3 checks skipped: no real data ({DATA_VARIABLE} is {root or 'not set'})"
    failures.check(root is None, message)
    print(message)
    return None


def main() -> None:
    program, scratch = Program(Path(sys.argv[1])), Path(sys.argv[2])
    scratch.mkdir(parents=True, exist_ok=True)
    failures = Failures()
    sources = simulated_sources(program, scratch, failures)
    data = real_data(failures)
    for source in sources + (real_sources(data, scratch) if data else []):
        check_source(program, source, scratch, failures)
    failures.print()
    sys.exit(bool(failures))


if __name__ == "__main__":
    main()
