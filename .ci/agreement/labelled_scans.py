"""Scans with their ground truth, read from the layouts of KITTI and SemanticKITTI, as published and as scanbench writes
them.

Everything is in the frame of the sensor, x forward, y left, z up, in metres. A box is a row of seven numbers: its centre,
its length along the heading, its width and height, and the yaw.

Programs round differently. So a scan is read as a function of the slack, by which every edge that decides something (face
of a box, rim of the image, cell, range) is moved out, in metres or pixels: what is the same however edges move does not
depend on rounding.
"""

import json
import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Most drives of KITTI have images of this size; nothing but the images themselves says it.
USUAL_IMAGE_SIZE_PX = (1242, 375)
# Words of KITTI that are not those of the program; the last two are of converted data sets.
KITTI_CLASSES = {
    "person_sitting": "sitting-person",
    "person": "sitting-person",
    "parkedcycle": "parked-cycle",
    "streetfurniture": "street-furniture",
}
# In the tracking benchmark: "2 = ignored (contains ignored region)".
IGNORED_TRUNCATION = 2.0

# Names of the format's label map (semantic-kitti.yaml) beside ours. Instances of all of these are objects.
OBJECTS = {
    10: "car", 252: "car",
    11: "parked-cycle", 15: "parked-cycle",  # bicycle, motorcycle
    13: "bus", 257: "bus",
    16: "tram", 256: "tram",  # on-rails
    18: "truck", 258: "truck",
    20: "misc", 259: "misc",  # other-vehicle
    30: "pedestrian", 254: "pedestrian",
    31: "cyclist", 32: "cyclist", 253: "cyclist", 255: "cyclist",  # bicyclist, motorcyclist
    80: "pole", 81: "pole",  # pole, traffic-sign
    # Whether these are objects of their own is open, but for converted data sets, where they have instances.
    51: "fence",
    70: "hedge",  # vegetation
    71: "tree",  # trunk
    99: "street-furniture",  # other-object
}  # fmt: skip
UPRIGHTS = (80, 81)
# Unlabelled, outlier, other-structure.
NOT_JUDGED = (0, 1, 52)
# Road, parking, sidewalk, other-ground, building, lane-marking, terrain.
BACKGROUND = (40, 44, 48, 49, 50, 60, 72)
CELL_M = 0.3


class Region(IntEnum):
    """Whether the labels say anything about a point."""

    LABELLED = 0
    UNSCORABLE = 1
    OUTSIDE = 2


@dataclass(frozen=True)
class Annotation:
    """A labelled object, with the indices of its points."""

    class_name: str
    track: int | None
    box: Floats | None
    points: Indices


@dataclass(frozen=True)
class Scan:
    points_m: Floats
    annotations: list[Annotation]
    regions: NDArray[np.uint8]
    slack: float

    @cached_property
    def range_m(self) -> Floats:
        """Distance of every point from the sensor on the ground plan."""
        return np.hypot(self.points_m[:, 0], self.points_m[:, 1])

    def center_m(self, annotation: Annotation) -> Floats:
        """Where an object stands: the centre of its box, else of its points; the sensor if it has neither."""
        if annotation.box is not None:
            return annotation.box[:3]
        return self.points_m[annotation.points].mean(axis=0) if len(annotation.points) else np.zeros(3)

    def n_points_in(self, annotation: Annotation, *regions: Region) -> int:
        return int(np.isin(self.regions[annotation.points], regions).sum())


@dataclass(frozen=True)
class Dataset:
    """What a data set says of itself, and how to read its scans by drive and number."""

    root: str
    annotates_everything: bool
    annotates_vehicles: bool
    read: Callable[[str, int], Callable[[float], Scan]]


def read_bin(path: Path) -> Floats:
    """The positions in a Velodyne `.bin` file, column by column, as they are asked for."""
    return np.asfortranarray(np.fromfile(path, "<f4").reshape(-1, 4)[:, :3].astype(np.float64))


def along_across_m(box: Floats, points_m: Floats) -> tuple[Floats, Floats]:
    """Where points are on the ground plan, from the centre along the length and along the width."""
    dx, dy = points_m[:, 0] - box[0], points_m[:, 1] - box[1]
    cos, sin = np.cos(box[6]), np.sin(box[6])
    return cos * dx + sin * dy, cos * dy - sin * dx


def indices_around(points_m: Floats, box: Floats, margin_m: float) -> Indices:
    """All points on the ground plan within `margin_m` of the box, and some more."""
    reach_m = 0.5 * np.hypot(box[3], box[4]) + margin_m
    return np.flatnonzero((np.abs(points_m[:, 0] - box[0]) <= reach_m) & (np.abs(points_m[:, 1] - box[1]) <= reach_m))


def points_of_boxes(points_m: Floats, boxes: list[Floats]) -> Callable[[float], list[Indices]]:
    """The points of each box by the slack; one in several is of that of least volume, of equal ones of the first."""
    near = []
    for box in boxes:
        indices = indices_around(points_m, box, 1.0)
        from_center = [*along_across_m(box, points_m[indices]), points_m[indices, 2] - box[2]]
        near.append((indices, np.max([np.abs(it) - size / 2 for it, size in zip(from_center, box[3:6])], axis=0)))
    volumes_m3 = [np.prod(it[3:6]) for it in boxes]

    def inside(slack_m: float) -> list[Indices]:
        owner = np.full(len(points_m), -1)
        for idx in sorted(range(len(boxes)), key=lambda it: (volumes_m3[it], it), reverse=True):
            indices, beyond_m = near[idx]
            owner[indices[beyond_m <= slack_m]] = idx
        return [indices[owner[indices] == idx] for idx, (indices, _) in enumerate(near)]

    return inside


def image_size_px(images: list[Path]) -> tuple[int, int]:
    """Width and height of the first image, which follow the name of its first chunk, IHDR."""
    return struct.unpack(">II", images[0].read_bytes()[16:24]) if images else USUAL_IMAGE_SIZE_PX


def write_png(path: Path, size_px: tuple[int, int]) -> None:
    """A black image."""
    header = b"IHDR" + struct.pack(">IIBBBBB", *size_px, 8, 0, 0, 0, 0)
    rows = b"IDAT" + zlib.compress(bytes((size_px[0] + 1) * size_px[1]))
    chunks = [struct.pack(">I", len(it) - 4) + it + struct.pack(">I", zlib.crc32(it)) for it in (header, rows, b"IEND")]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))


def calibration(path: Path) -> tuple[Floats, Floats]:
    """From the sensor into the rectified camera frame (x right, y down, z forward), 4 × 4, and the 3 × 4 projection."""
    lines = filter(None, map(str.split, path.read_text().splitlines()))
    words = {name.rstrip(":"): numbers for name, *numbers in lines}
    matrix = lambda names, shape: np.array([words[it] for it in names if it in words][0], float).reshape(shape)
    camera_from_velodyne, shift = np.eye(4), np.eye(4)
    camera_from_velodyne[:3, :3] = matrix(("R0_rect", "R_rect"), (3, 3))
    shift[:3] = matrix(("Tr_velo_to_cam", "Tr_velo_cam"), (3, 4))
    return camera_from_velodyne @ shift, matrix(("P2",), (3, 4))


def box_of_label(numbers: list[float], camera_from_velodyne: Floats) -> Floats:
    """Heading and centre of the bottom are carried over, and the box stands upright in the frame of the sensor."""
    velodyne_from_camera = np.linalg.inv(camera_from_velodyne)
    height_m, width_m, length_m, *bottom_center_m, rotation_y_rad = numbers[7:14]
    x, y, z, _ = velodyne_from_camera @ (*bottom_center_m, 1.0)
    # Turned by the angle about the axis that points down, x of the camera goes to (cos, 0, -sin).
    ahead = velodyne_from_camera[:3, :3] @ (np.cos(rotation_y_rad), 0.0, -np.sin(rotation_y_rad))
    return np.array([x, y, z + height_m / 2, length_m, width_m, height_m, np.arctan2(ahead[1], ahead[0])])


def kitti(folder: Path) -> Dataset:
    """The split `training` of whichever benchmark, tracking or object."""
    root = folder / "training"
    is_tracking = (root / "label_02").is_dir()
    sheet = json.loads((root / "scanbench.json").read_text()) if (root / "scanbench.json").exists() else {}
    # KITTI labels vehicles, people, cyclists and trams, and not all that stands on a street.
    annotated, labelled = sheet.get("annotated_classes", ["car"]), sheet.get("labeled_region", "camera")

    def read(drive: str, number: int) -> Callable[[float], Scan]:
        if is_tracking:
            of_drive, name, images = drive, f"{drive}/{number:06}", sorted((root / f"image_02/{drive}").glob("*.png"))
            lines = map(str.split, (root / f"label_02/{drive}.txt").read_text().splitlines())
            lines = [it[1:] for it in lines if it and int(it[0]) == number]
        else:
            of_drive, name, images = f"{number:06}", f"{number:06}", sorted((root / "image_2").glob(f"{number:06}.png"))
            lines = [["-1", *it.split()] for it in (root / f"label_2/{name}.txt").read_text().splitlines() if it.strip()]
        camera_from_velodyne, image_from_camera = calibration(root / f"calib/{of_drive}.txt")
        points_m = read_bin(root / f"velodyne/{name}.bin")
        numbers = [[float(it) for it in line[2:16]] for line in lines]
        ignored = [of_line[3:7] for line, of_line in zip(lines, numbers) if line[1] == "DontCare"]
        objects = [(line, of_line) for line, of_line in zip(lines, numbers) if line[1] != "DontCare"]
        boxes = [box_of_label(of_line, camera_from_velodyne) for _, of_line in objects]
        inside = points_of_boxes(points_m, boxes)
        in_camera = np.column_stack([points_m, np.ones(len(points_m))]) @ camera_from_velodyne.T @ image_from_camera.T
        depth = in_camera[:, 2]
        pixels, size_px = in_camera[:, :2] / np.where(depth == 0, np.nan, depth)[:, None], np.array(image_size_px(images))

        def regions(points: list[Indices], slack: float) -> NDArray[np.uint8]:
            """Outside is what is behind the camera or beside the image; unscorable what is in a DontCare, in no object."""
            if labelled == "per-point" and (file := root / f"point_region/{name}.u8").exists():
                return np.fromfile(file, np.uint8)
            found = np.full(len(points_m), Region.LABELLED, np.uint8)
            if labelled == "camera":
                # The first pixel begins at 0, and the last ends before the width.
                is_seen = (depth > 0) & (pixels >= -slack).all(axis=1) & (pixels < size_px + slack).all(axis=1)
                found[~is_seen] = Region.OUTSIDE
                is_free = ~np.isin(np.arange(len(points_m)), np.concatenate([np.empty(0, int), *points]))
                for left, top, right, bottom in ignored:
                    is_in = (pixels >= (left - slack, top - slack)) & (pixels <= (right + slack, bottom + slack))
                    found[is_seen & is_free & is_in.all(axis=1)] = Region.UNSCORABLE
            for (_, of_line), indices in zip(objects, points):
                # Labels of the object benchmark give a share of truncation, and no level that means ignored.
                if is_tracking and of_line[0] == IGNORED_TRUNCATION:
                    found[indices] = Region.UNSCORABLE
            return found

        def with_slack(slack: float) -> Scan:
            points, annotations = inside(slack), []
            for ((track, word, *_), _), box, indices in zip(objects, boxes, points):
                class_name = KITTI_CLASSES.get(word.lower(), word.lower())
                annotations.append(Annotation(class_name, None if track == "-1" else int(track), box, indices))
            return Scan(points_m, annotations, regions(points, slack), slack)

        return with_slack

    return Dataset(str(root), annotated == "every-object", annotated == "every-object" or "car" in annotated, read)


def touching_cells(points_m: Floats, slack_m: float) -> list[Indices]:
    """Groups points by cells of the ground plan that share an edge or a corner, in the order of their first points."""
    if len(points_m) == 0:
        return []
    cells = np.floor((points_m[:, :2] + slack_m) / CELL_M).astype(int)
    cells -= cells.min(axis=0)
    is_occupied = np.zeros(cells.max(axis=0) + 1, bool)
    is_occupied[tuple(cells.T)] = True
    group_of_cell, n_groups = ndimage.label(is_occupied, structure=np.ones((3, 3)))
    group_of_point = group_of_cell[tuple(cells.T)]
    groups = [np.flatnonzero(group_of_point == group) for group in range(1, n_groups + 1)]
    return sorted(groups, key=lambda group: int(group[0]))


def semantic_kitti(root: Path) -> Dataset:
    """The folder that has `sequences`. Every point has a label, so that false objects are known."""

    def read(drive: str, number: int) -> Callable[[float], Scan]:
        folder = root / "sequences" / drive
        points_m = read_bin(folder / f"velodyne/{number:06}.bin")
        labels = np.fromfile(folder / f"labels/{number:06}.label", "<u4").astype(np.int64)
        classes, instances = labels & 0xFFFF, labels >> 16
        if unknown := set(np.unique(classes)) - {*OBJECTS, *NOT_JUDGED, *BACKGROUND}:
            raise ValueError(f"labels {sorted(unknown)} are not SemanticKITTI's")
        is_object = np.isin(classes, list(OBJECTS)) & (instances > 0)
        is_upright = np.isin(classes, UPRIGHTS) & (instances == 0)
        is_judged = is_object | is_upright | np.isin(classes, BACKGROUND)
        regions = np.where(is_judged, Region.LABELLED, Region.UNSCORABLE).astype(np.uint8)
        of_instances = [
            Annotation(OBJECTS[int(label) & 0xFFFF], int(label), None, np.flatnonzero(labels == label))
            for label in np.unique(labels[is_object])
        ]
        uprights = np.flatnonzero(is_upright)

        def with_slack(slack: float) -> Scan:
            """One annotation for each instance, by label, then one for each pole or sign."""
            groups = touching_cells(points_m[uprights], slack)
            poles = [Annotation("pole", None, None, uprights[group]) for group in groups]
            return Scan(points_m, of_instances + poles, regions, slack)

        return with_slack

    return Dataset(str(root), annotates_everything=True, annotates_vehicles=True, read=read)
