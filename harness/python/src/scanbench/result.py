"""Detections as the protocol's `result`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scanbench.detections import MAX_PRODUCTS, Boxes, Detections, check_name

MAX_ID = 2**32 - 1
NO_TRACK = 2**32 - 1
MAX_SPEED_M_PER_S = 1000.0


def encode_result(
    detections: Detections, n_points: int, noise: int, protocol: int = 2
) -> tuple[dict[str, Any], list[bytes]]:
    """Fields and payload of the answer; raises ValueError or TypeError where it would be refused.

    Version 1 of the protocol has no place for velocities and tracks.
    """
    fields: dict[str, Any] = {}
    parts: list[bytes] = []
    boxes = detections.boxes
    n_detections = 0
    if detections.labels is not None:
        ids = cluster_ids(detections.labels, n_points, noise)
        fields["clusters"] = True
        parts.append(ids.tobytes())
        n_detections = _n_different(ids) if boxes is None else len(boxes)
        if boxes is not None and (largest := int(ids.max(initial=0))) != len(boxes):
            raise ValueError(
                f"{len(boxes)} boxes for clusters up to number {largest}: box k has to be that of cluster k"
            )
    elif boxes is not None:
        n_detections = len(boxes)
    if boxes is not None:
        boxes.check()
        fields["n_boxes"] = len(boxes)
        parts.append(boxes.array.astype("<f4").tobytes())
    scores = _either("scores", detections.scores, boxes)
    if scores is not None:
        fields["scores"] = True
        parts.append(_scores(scores, n_detections).tobytes())
    for name, encode in [("velocities", _velocities), ("tracks", _tracks)]:
        values = _either(name, getattr(detections, name), boxes)
        if values is not None and protocol > 1:
            fields[name] = True
            parts.append(encode(values, n_detections).tobytes())
    classes = _either("classes", detections.classes, boxes)
    if classes is not None:
        fields["classes"] = _classes(list(classes), n_detections)
    if len(detections.products) > MAX_PRODUCTS:
        raise ValueError(f"{len(detections.products)} products, more than {MAX_PRODUCTS}")
    if detections.products:
        fields["products"] = [
            {"name": check_name(name), "kind": "point-labels", "type": "u8"} for name in detections.products
        ]
        parts += [_product(name, values, n_points) for name, values in detections.products.items()]
    return fields, parts


def cluster_ids(labels: ArrayLike, n_points: int, noise: int) -> NDArray[np.uint32]:
    """The protocol's ids: 0 is no cluster, clusters begin at 1."""
    array = np.asarray(labels)
    if array.size == 0 and n_points == 0:
        return np.empty(0, "<u4")
    if array.shape != (n_points,):
        raise ValueError(f"labels are of shape {array.shape} for {n_points} points")
    if not np.issubdtype(array.dtype, np.integer):
        raise TypeError(f"labels are {array.dtype}, not integers: use labels.astype(int)")
    largest = int(array.max()) + (1 if noise == -1 else 0)
    if largest > MAX_ID:
        raise ValueError(f"label {int(array.max())} is too large")
    if noise == -1:
        return np.where(array < 0, 0, array.astype(np.int64) + 1).astype("<u4")
    if int(array.min()) < 0:
        raise ValueError(f"label {int(array.min())} is below 0, which is the label of no cluster")
    return array.astype("<u4")


def _n_different(ids: NDArray[np.uint32]) -> int:
    largest = int(ids.max(initial=0))
    if largest <= 4 * len(ids):
        seen = np.zeros(largest + 1, np.bool_)
        seen[ids] = True
        return int(seen[1:].sum())
    return int(np.count_nonzero(np.unique(ids)))


def _either(name: str, of_clusters: Any, boxes: Boxes | None) -> Any:
    of_boxes = getattr(boxes, name, None)
    if of_boxes is not None and of_clusters is not None:
        raise ValueError(f"{name} are given twice, of the boxes and of the detections")
    return of_boxes if of_boxes is not None else of_clusters


def _scores(scores: ArrayLike, n_detections: int) -> NDArray[np.float32]:
    array = np.asarray(scores, dtype="<f4")
    if array.shape != (n_detections,):
        raise ValueError(f"scores are of shape {array.shape} for {n_detections} detections")
    if not np.isfinite(array).all():
        raise ValueError(f"score {int((~np.isfinite(array)).argmax())} is not a finite number")
    return array


def _velocities(velocities: ArrayLike, n_detections: int) -> NDArray[np.float32]:
    array = np.asarray(velocities, dtype="<f4")
    if array.size == 0 and n_detections == 0:
        return array
    if array.shape != (n_detections, 2):
        raise ValueError(
            f"velocities are of shape {array.shape} for {n_detections} detections, not ({n_detections}, 2)"
        )
    unknown = np.isnan(array).all(axis=1)
    wrong = ~unknown & ~(np.abs(array) <= MAX_SPEED_M_PER_S).all(axis=1)
    if wrong.any():
        raise ValueError(
            f"velocity {int(wrong.argmax())} is known along one axis alone, or above {MAX_SPEED_M_PER_S:g} m/s"
        )
    return array


def _tracks(tracks: ArrayLike, n_detections: int) -> NDArray[np.uint32]:
    array = np.asarray(tracks)
    if array.size == 0 and n_detections == 0:
        return np.empty(0, "<u4")
    if array.shape != (n_detections,) or not np.issubdtype(array.dtype, np.integer):
        raise ValueError(f"tracks are {array.dtype} of shape {array.shape}, not {n_detections} integers")
    if int(array.max()) >= NO_TRACK:
        raise ValueError(f"track {int(array.max())} is too large")
    return np.where(array < 0, NO_TRACK, array.astype(np.int64)).astype("<u4")


def _classes(classes: list[str | None], n_detections: int) -> list[str | None]:
    if len(classes) != n_detections:
        raise ValueError(f"{len(classes)} classes for {n_detections} detections")
    for name in classes:
        if name is not None and not isinstance(name, str):
            raise TypeError(f"the class {name!r} is no name")
    return classes


def _product(name: str, values: ArrayLike, n_points: int) -> bytes:
    array = np.asarray(values)
    if array.shape != (n_points,):
        raise ValueError(f"product {name!r} is of shape {array.shape} for {n_points} points")
    if array.size and not (0 <= int(array.min()) and int(array.max()) <= 255):
        raise ValueError(f"product {name!r} has values beyond 0 to 255")
    return array.astype(np.uint8).tobytes()
