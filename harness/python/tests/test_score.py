"""`score`: boxes in memory are judged as the program judges them on disk."""

from __future__ import annotations

import json
import math
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scanbench
from scanbench import Annotations, Boxes, ScanbenchError

CLASSES = ("car", "pedestrian", "cyclist", "truck")


def has_program() -> bool:
    try:
        scanbench.find_program()
    except ScanbenchError:
        return False
    return True


needs_program = pytest.mark.skipif(not has_program(), reason="there is no program scanbench")


def drawn(n_scans: int, n_boxes: int, seed: int = 7) -> tuple[list[Annotations], list[Boxes], list[Any]]:
    """Labels, boxes that are a little off or of nothing, and points in the labelled boxes and on the road."""
    rng = np.random.default_rng(seed)
    labels, found, clouds = [], [], []
    for _ in range(n_scans):
        centers = np.column_stack([rng.uniform(-55, 55, (n_boxes, 2)), rng.uniform(-1.2, -0.8, n_boxes)])
        sizes = np.column_stack([rng.uniform(1, 5, n_boxes), rng.uniform(0.6, 2, n_boxes), np.full(n_boxes, 1.6)])
        yaws = rng.uniform(-math.pi, math.pi, n_boxes)
        names = [CLASSES[it] for it in rng.integers(0, len(CLASSES), n_boxes)]
        rows = np.column_stack([centers, sizes, yaws]).astype(np.float32)
        labels.append(Annotations(rows, names))
        moved = rows.copy()
        moved[:, :2] += rng.normal(0, 0.8, (n_boxes, 2)).astype(np.float32)
        moved[: n_boxes // 5, 0] += 30
        scores = rng.uniform(0, 1, n_boxes).astype(np.float32)
        found.append(Boxes(moved, scores, names[::-1] if n_boxes % 2 else names))
        inside = np.repeat(centers, 40, axis=0) + rng.normal(0, 0.15, (40 * n_boxes, 3))
        road = np.column_stack([rng.uniform(-70, 70, (3000, 2)), rng.normal(-1.73, 0.01, 3000)])
        clouds.append(np.vstack([inside, road]).astype(np.float32))
    return labels, found, clouds


@needs_program
@pytest.mark.parametrize("criterion", ["centre", "bev-iou", "iou-3d", "points"])
def test_numbers_are_those_of_a_run_to_the_last_digit(tmp_path: Path, criterion: Any) -> None:
    labels, found, clouds = drawn(4, 12)
    for folder in ("scans", "scans/lidar", "scans/labels", "found"):
        (tmp_path / folder).mkdir()
    columns = "center_x_m,center_y_m,center_z_m,length_m,width_m,height_m,yaw_rad"
    for idx, (label, boxes, cloud) in enumerate(zip(labels, found, clouds, strict=True)):
        np.save(
            tmp_path / f"scans/lidar/{idx:06}.npy", np.column_stack([cloud, np.zeros(len(cloud), "<f4")]).astype("<f4")
        )
        listed = [
            {"class": name, "center_m": row[:3], "length_width_height_m": row[3:6], "yaw_rad": row[6]}
            for row, name in zip(label.array.tolist(), label.classes, strict=True)
        ]
        (tmp_path / f"scans/labels/{idx:06}.json").write_text(json.dumps(listed))
        assert boxes.classes is not None and boxes.scores is not None
        rows = zip(boxes.array.tolist(), boxes.classes, np.asarray(boxes.scores).tolist(), strict=True)
        lines = [",".join([str(name), repr(value), *map(repr, row)]) for row, name, value in rows]
        (tmp_path / f"found/{idx:06}.csv").write_text("\n".join([f"class,score,{columns}", *lines]) + "\n")
    run = scanbench.run(
        tmp_path / "scans",
        detections={"net": tmp_path / "found"},
        output=tmp_path / "run",
        quiet=True,
        criterion=criterion,
        columns="x,y,z,intensity",
        sensor="hdl-64e-s2",
        sensor_height=1.73,
        no_rrd=True,
        labels_are_right=True,
    )
    entry = run.manifest["datasets"][0]
    names = run.frame("scans", "numpy")
    scans = list(dict.fromkeys(zip(names["sequence"].tolist(), names["scan"].tolist(), strict=True)))
    covered = entry["annotated"]
    scored = scanbench.score(
        labels,
        found,
        clouds=clouds,
        scans=scans,
        criterion=criterion,
        labelled=covered["only"] if isinstance(covered, dict) else [],
        dataset=entry["id"],
        detector="net",
    )

    def numbers(report: Any) -> dict[tuple[str, ...], Any]:
        keys = zip(*(report[it].tolist() for it in ("dataset", "task", "detector", "slice", "metric")), strict=True)
        values = zip(*(report[it].tolist() for it in ("value", "n")), strict=True)
        return {key: str(value) for key, value in zip(keys, values, strict=True) if key[2] == "net"}

    expected, got = numbers(run.frame("report", "numpy")), numbers(scored.frame("report", "numpy"))
    assert got == expected
    assert len(got) > 100


@needs_program
def test_an_epoch_takes_no_time_and_objects_with_few_points_do_not_count() -> None:
    labels, found, _ = drawn(40, 30)
    scanbench.score(labels[:1], found[:1])
    begun = time.perf_counter()
    scored = scanbench.score(labels, found, times_s=[0.1 * it for it in range(40)])
    # 0.2 s on two quiet cores.
    assert time.perf_counter() - begun < 5
    rate = scored.value("recall", "car")
    assert rate is not None and 0.3 < rate < 1.0
    assert scored.value("no", "objects") == 40 * 30
    few = [Annotations(it.rows, it.classes, n_points=[5] * 10 + [50] * 20) for it in labels]
    assert scanbench.score(few, found).value("no", "objects") == 40 * 20
    with pytest.raises(KeyError, match="there are the tasks objects, vehicles"):
        scored.value("f_rate", "tram")
    assert repr(scored).startswith("Score(f_rate of objects: None")


@needs_program
def test_exact_boxes_score_one_and_what_is_wrong_is_said() -> None:
    labels, _, _ = drawn(2, 5)
    exact = [Boxes(it.rows, [1.0] * 5, list(it.classes)) for it in labels]
    for criterion in ("centre", "bev-iou", "iou-3d"):
        assert scanbench.score(labels, exact, criterion=criterion).value("f_rate", "vehicles") == 1.0
    strange = [Annotations(it.rows, ["forklift"] * 5) for it in labels]
    with pytest.raises(ScanbenchError, match='scan 0/000000: annotation 1: "forklift" is not a class') as refused:
        scanbench.score(strange, exact)
    assert refused.value.exit_code == 2
    assert scanbench.score(strange, exact, classes={"forklift": "misc"}).value("no", "objects") == 10
    with pytest.raises(ScanbenchError, match="the criterion points needs the points"):
        scanbench.score(labels, exact, criterion="points")
    with pytest.raises(ValueError, match="1 detections for annotations of 2 scans"):
        scanbench.score(labels, exact[:1])
    with pytest.raises(TypeError, match="annotations are a list of Annotations, one for each scan, and one is ndarray"):
        scanbench.score([it.array for it in labels], exact)  # type: ignore[misc]
    with pytest.raises(ValueError, match="1 scores for 5 boxes"):
        scanbench.score(labels, [Boxes(it.rows, [0.5]) for it in labels])
    with pytest.raises(ValueError, match="box 1 has NaN"):
        Annotations(np.array([[0, 0, 0, 1, 1, 1, 0], [0, math.nan, 0, 1, 1, 1, 0]]), ["car", "car"])
    with pytest.raises(ValueError, match="4 classes for 5 boxes"):
        Annotations(labels[0].rows, ["car"] * 4)
