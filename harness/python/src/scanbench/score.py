"""Scores of annotations and detections that are in memory, as at the end of an epoch."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scanbench.detections import Boxes
from scanbench.frame import Tables, columns_of_csv, columns_of_rows
from scanbench.program import ScanbenchError, call

Criterion = Literal["centre", "bev-iou", "iou-3d", "points"]


@dataclass
class Annotations:
    """Upright boxes that are labelled in one scan, in the sensor frame; the columns are those of `Boxes`."""

    rows: ArrayLike
    """m × 7."""
    classes: Sequence[str]
    """A class for each box."""
    n_points: ArrayLike | None = None
    """Number of points of each, where `score` is given no clouds; those with fewer than 20 do not count."""
    tracks: ArrayLike | None = None
    """Number of each object within its drive."""

    def __post_init__(self) -> None:
        boxes = Boxes(self.rows)
        boxes.check()
        self.rows = boxes.array
        for name in ("classes", "n_points", "tracks"):
            values = getattr(self, name)
            if values is not None and len(values) != len(self.array):
                raise ValueError(f"{len(values)} {name} for {len(self.array)} boxes")
        if strange := [it for it in self.classes if not isinstance(it, str)]:
            raise TypeError(f"the class {strange[0]!r} is no name")
        if self.n_points is not None and np.min(self.n_points, initial=0) < 0:
            raise ValueError("an annotation has fewer than 0 points")

    @property
    def array(self) -> NDArray[np.float32]:
        """The m × 7 numbers."""
        return np.asarray(self.rows, dtype="<f4")


class Score(Tables):
    """Numbers of one detector, and the rows that they are made of: the tables `report`, `scans` and `matches`."""

    def __init__(self, answer: Mapping[str, Any]) -> None:
        super().__init__()
        self._answer = answer

    def _columns(self, name: str) -> dict[str, NDArray[Any]]:
        if name == "report":
            return columns_of_rows(self._answer["report"]["rows"])
        if name not in ("scans", "matches"):
            raise ScanbenchError(f"a score has no table {name!r}; it has matches, report, scans")
        return columns_of_csv(self._answer[name])

    def value(self, metric: str, task: str = "vehicles", part: str = "all") -> float | None:
        """A number of the report, such as `f_rate`, `recall` or `ap_101_points`; None where it is undefined.

        `task` is `objects`, `vehicles` or a class, `part` a slice such as `range/0-15`. The F-rate and precision are undefined where
        not all objects are labelled (`labelled`), average precision is missing where detections have no scores, and a class where it
        is neither labelled nor detected. Raises KeyError, with what there is, if there is no such number.
        """
        rows = self._answer["report"]["rows"]
        for row in rows:
            if (row["metric"], row["task"], row["slice"]) == (metric, task, part):
                value = row["value"]
                return None if value is None else float(value)
        tasks = dict.fromkeys(row["task"] for row in rows)
        metrics = dict.fromkeys(row["metric"] for row in rows if (row["task"], row["slice"]) == (task, part))
        there = f"metrics {', '.join(metrics)}" if metrics else f"tasks {', '.join(tasks) or 'none'}"
        raise KeyError(f"there is no {metric} of {task}, {part}: there are the {there}")

    def __repr__(self) -> str:
        rates = [(task, self.value("f_rate", task)) for task in ("objects", "vehicles")]
        return "Score(" + ", ".join(f"f_rate of {task}: {rate}" for task, rate in rates) + ")"


def score(
    annotations: Sequence[Annotations],
    detections: Sequence[Boxes],
    *,
    clouds: Sequence[ArrayLike] | None = None,
    scans: Sequence[tuple[str, int]] | None = None,
    times_s: Sequence[float] | None = None,
    criterion: Criterion = "centre",
    labelled: Sequence[str] | None = None,
    classes: Mapping[str, str] | None = None,
    dataset: str = "scans",
    detector: str = "detector",
    sensor_height_m: float = 1.73,
    parameters: Mapping[str, Any] | None = None,
) -> Score:
    """Judges detections of some scans by their annotations, an entry of both for each scan; nothing is written.

    The numbers are those of `scanbench run --detections` on the same scans, with the same points. `clouds` (n × 3 or more) decide how
    many points an object has, and are needed by the criterion `points`. A box without a class is taken for a vehicle or not by its size,
    or with clouds by a trained model. `scans` names each scan by drive and number; without, all are of one drive.
    `times_s` is when each was taken in its drive: intervals are drawn over drives, or seconds. `labelled` are the classes that are
    labelled, by default those of the annotations; an empty list says that nothing which stands on the street is left out. `classes`
    says what other names stand for, such as `{"forklift": "misc"}`; `parameters` are those of matching (`-P`).

    Raises ScanbenchError, with `exit_code`, if something is wrong.
    """
    n_scans = len(annotations)
    if n_scans == 0:
        raise ValueError("there are no scans to score")
    for name, of_scans, kind in (("annotations", annotations, Annotations), ("detections", detections, Boxes)):
        if strange := [type(it).__name__ for it in of_scans if not isinstance(it, kind)]:
            raise TypeError(f"{name} are a list of {kind.__name__}, one for each scan, and one is {strange[0]}")
    for name, given in (("detections", detections), ("clouds", clouds), ("scans", scans), ("times_s", times_s)):
        if given is not None and len(given) != n_scans:
            raise ValueError(f"{len(given)} {name} for annotations of {n_scans} scans")
    points = None if clouds is None else [_points(cloud) for cloud in clouds]
    request = {
        "dataset": dataset,
        "detector": detector,
        "criterion": criterion,
        "labelled": None if labelled is None else list(labelled),
        "classes": dict(classes or {}),
        "sensor_height_m": sensor_height_m,
        "scans": [
            {
                "sequence": scans[idx][0] if scans is not None else "0",
                "scan": int(scans[idx][1]) if scans is not None else idx,
                "time_s": float(times_s[idx]) if times_s is not None else None,
                "n_points": len(points[idx]) if points is not None else None,
                "annotations": _annotations(annotations[idx]),
                "detections": _detections(detections[idx]),
            }
            for idx in range(n_scans)
        ],
    }
    words = [word for name, value in (parameters or {}).items() for word in ("-P", f"{name}={json.dumps(value)}")]
    payload = b"".join(cloud.tobytes() for cloud in points or [])
    answer = call(["score", *words], quiet=True, given=json.dumps(request, allow_nan=False).encode() + b"\n" + payload)
    return Score(json.loads(answer))


def _points(cloud: ArrayLike) -> NDArray[np.float32]:
    array = np.asarray(cloud, dtype="<f4")
    if array.ndim != 2 or array.shape[1] < 3:
        raise ValueError(f"a cloud is an array of n x 3 or more, not of {array.shape}")
    return np.ascontiguousarray(array[:, :3])


def _annotations(of_scan: Annotations) -> list[dict[str, Any]]:
    def numbers(values: ArrayLike | None) -> list[int | None]:
        return [None] * len(of_scan.array) if values is None else [int(it) for it in np.asarray(values)]

    rows, names = of_scan.array.tolist(), list(of_scan.classes)
    columns = zip(rows, names, numbers(of_scan.n_points), numbers(of_scan.tracks), strict=True)
    return [
        {
            "class": name,
            "values": row,
            "n_points": n_points,
            "track": track,
        }
        for row, name, n_points, track in columns
    ]


def _detections(of_scan: Boxes) -> list[dict[str, Any]]:
    of_scan.check()
    n_boxes = len(of_scan)
    classes = [None] * n_boxes if of_scan.classes is None else list(of_scan.classes)
    scores = [None] * n_boxes if of_scan.scores is None else np.asarray(of_scan.scores, dtype="<f4").tolist()
    for name, values in (("classes", classes), ("scores", scores)):
        if len(values) != n_boxes:
            raise ValueError(f"{len(values)} {name} for {n_boxes} boxes")
    columns = zip(of_scan.array.tolist(), classes, scores, strict=True)
    return [{"class": name, "score": value, "values": row} for row, name, value in columns]
