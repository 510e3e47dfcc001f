"""Holds converted scans, as we read them, against what the program says of the originals."""

from collections import Counter
from collections.abc import Callable

from comparison import Failures
from labelled_scan import Annotation, Dataset
from program import BOX_ROUNDING, Row, Run, row_box

# SemanticKITTI has no words of its own for these.
SEMANTIC_CLASSES = {"van": "car", "trailer": "misc", "sitting-person": "pedestrian"}

Check = Callable[[str, list[Annotation], list[Row], Failures], None]


def check_boxes(name: str, annotations: list[Annotation], rows: list[Row], failures: Failures) -> None:
    """KITTI tracking keeps classes, tracks and boxes, in order."""
    failures.check(len(annotations) == len(rows), f"{name}: {len(annotations)} annotations, the original has {len(rows)}")
    for idx, (annotation, row) in enumerate(zip(annotations, rows)):
        original = row_box(row, "annotation")
        is_same = annotation.box is not None and original is not None and annotation.box.is_near(original, BOX_ROUNDING)
        is_same &= (annotation.class_name, str(annotation.track)) == (row["annotation_class"], row["annotation_track"])
        failures.check(is_same, f"{name}, annotation {idx}: {annotation}, the original has {row}")


def check_points(name: str, annotations: list[Annotation], rows: list[Row], failures: Failures) -> None:
    """SemanticKITTI keeps which points are an object."""
    classes = [SEMANTIC_CLASSES.get(row["annotation_class"], row["annotation_class"]) for row in rows]
    theirs = Counter(zip(classes, (int(row["annotation_n_points"]) for row in rows)))
    ours = Counter((it.class_name, it.n_points) for it in annotations)
    failures.check(ours == theirs, f"{name}: {ours - theirs}, where the original has {theirs - ours}")


def check_conversion(originals: Run, name: str, converted: Dataset, check: Check, failures: Failures) -> int:
    """Checks all scans of data set `name`; gives the number of annotations."""
    n_annotations = 0
    n_of_drive: Counter[str] = Counter()
    of_dataset = {key: rows for key, rows in originals.matches.items() if (key[0], key[4]) == (name, "objects")}
    for (_, drive, number, _, _), rows in sorted(of_dataset.items(), key=lambda it: int(it[0][2])):
        of_annotations = sorted((row for row in rows if row["annotation_id"]), key=lambda row: int(row["annotation_id"]))
        # The layout whose points are checked numbers the scans of a drive anew.
        converted_number = n_of_drive[drive] if check is check_points else int(number)
        n_of_drive[drive] += 1
        scan = converted.read(drive, converted_number)(0.0)
        check(f"{converted.root} {drive}/{number}", scan.annotations, of_annotations, failures)
        n_annotations += len(of_annotations)
    return n_annotations
