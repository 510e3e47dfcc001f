"""Reads KITTI's layouts, tracking and object, as published and as `scanbench data convert` writes them."""

import json
import struct
import zlib
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from labelled_scan import (
    Annotation,
    Box,
    Dataset,
    Floats,
    Indices,
    LabelledScan,
    PointsNearBoxes,
    Region,
    ScanWithSlack,
    read_bin,
)

# Most drives have images of this size; nothing but the images themselves says it.
USUAL_IMAGE_SIZE_PX = (1242, 375)

# Words that are not those of the program; the last two are of converted data sets.
CLASSES = {
    "person_sitting": "sitting-person",
    "person": "sitting-person",
    "parkedcycle": "parked-cycle",
    "streetfurniture": "street-furniture",
}

# In the tracking benchmark: "2 = ignored (contains ignored region)".
IGNORED_LEVEL = 2.0


class Label(NamedTuple):
    """A line of a label file: the class, what follows it up to the rotation, and the track."""

    word: str
    numbers: list[float]
    track: int | None

    @classmethod
    def parse(cls, fields: Sequence[str], track: int | None) -> "Label":
        return cls(fields[0], [float(it) for it in fields[1:15]], track)

    @property
    def truncated(self) -> float:
        return self.numbers[0]

    @property
    def class_name(self) -> str:
        return CLASSES.get(self.word.lower(), self.word.lower())


@dataclass(frozen=True)
class Calibration:
    """Homogeneous 4 × 4 transform into the rectified camera frame (x right, y down, z forward), and the 3 × 4 projection."""

    camera_from_velodyne: Floats
    image_from_camera: Floats

    @classmethod
    def read(cls, path: Path) -> "Calibration":
        rows: dict[str, Floats] = {}
        for line in path.read_text().splitlines():
            name, *numbers = line.split() or [""]
            if name.rstrip(":") in ("P2", "R0_rect", "R_rect", "Tr_velo_to_cam", "Tr_velo_cam"):
                rows[name.rstrip(":")] = np.array([float(it) for it in numbers])
        rectification, shift = np.eye(4), np.eye(4)
        rectification[:3, :3] = rows.get("R0_rect", rows.get("R_rect", np.empty(0))).reshape(3, 3)
        shift[:3] = rows.get("Tr_velo_to_cam", rows.get("Tr_velo_cam", np.empty(0))).reshape(3, 4)
        return cls(rectification @ shift, rows["P2"].reshape(3, 4))

    def box_of(self, label: Label) -> Box:
        """Heading and centre of the bottom are carried over, and the box stands upright in the frame of the sensor."""
        velodyne_from_camera = np.linalg.inv(self.camera_from_velodyne)
        height_m, width_m, length_m, *bottom_center_m, rotation_y_rad = label.numbers[7:14]
        x, y, z, _ = velodyne_from_camera @ (*bottom_center_m, 1.0)
        # Turned by the angle about the axis that points down, x of the camera goes to (cos, 0, -sin).
        ahead = velodyne_from_camera[:3, :3] @ (np.cos(rotation_y_rad), 0.0, -np.sin(rotation_y_rad))
        yaw_rad = float(np.arctan2(ahead[1], ahead[0]))
        return Box((x, y, z + height_m / 2), length_m, width_m, height_m, yaw_rad)

    def pixels(self, points_m: Floats) -> tuple[Floats, Floats]:
        """Column and row of every point in the image, and its depth before the camera in metres."""
        in_camera = np.column_stack([points_m, np.ones(len(points_m))]) @ self.camera_from_velodyne.T
        projected = in_camera @ self.image_from_camera.T
        depth = projected[:, 2]
        return projected[:, :2] / np.where(depth == 0, np.nan, depth)[:, None], depth


def png_size_px(path: Path) -> tuple[int, int]:
    """Width and height, which follow the name of the first chunk, IHDR."""
    width, height = struct.unpack(">II", path.read_bytes()[16:24])
    return width, height


def write_png(path: Path, size_px: tuple[int, int]) -> None:
    """A black image."""
    header = b"IHDR" + struct.pack(">IIBBBBB", *size_px, 8, 0, 0, 0, 0)
    rows = b"IDAT" + zlib.compress(bytes((size_px[0] + 1) * size_px[1]))
    chunks = [struct.pack(">I", len(it) - 4) + it + struct.pack(">I", zlib.crc32(it)) for it in (header, rows, b"IEND")]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))


def image_size_px(images: Path) -> tuple[int, int]:
    """Of an image, or of the first in a folder; where there is none, that of most drives."""
    found = sorted(images.glob("*.png")) if images.is_dir() else [images]
    return png_size_px(found[0]) if found and found[0].exists() else USUAL_IMAGE_SIZE_PX


@dataclass(frozen=True)
class ScanFiles:
    """What belongs to one scan."""

    labels: list[Label]
    calibration: Calibration
    image_size_px: tuple[int, int]
    points: Path
    regions: Path
    ignored_level: float | None

    @property
    def objects(self) -> list[Label]:
        return [it for it in self.labels if it.word != "DontCare"]


def camera_regions(points_m: Floats, files: ScanFiles, is_annotated: NDArray[np.bool_], slack: float) -> NDArray[np.uint8]:
    """Outside is what is behind the camera or beside the image; unscorable what is in a DontCare and in no object."""
    pixels, depth = files.calibration.pixels(points_m)
    size_px = np.array(files.image_size_px)
    # The first pixel begins at 0, and the last ends before the width.
    is_seen = (depth > 0) & (pixels >= -slack).all(axis=1) & (pixels < size_px + slack).all(axis=1)
    regions = np.where(is_seen, Region.LABELLED, Region.OUTSIDE).astype(np.uint8)
    for label in files.labels:
        if label.word == "DontCare":
            low, high = np.array(label.numbers[3:5]), np.array(label.numbers[5:7])
            is_in = (pixels >= low - slack).all(axis=1) & (pixels <= high + slack).all(axis=1)
            regions[is_seen & is_in & ~is_annotated] = Region.UNSCORABLE
    return regions


@dataclass(frozen=True)
class KittiScan:
    """A scan whose labels are read, before it is said where exactly edges lie."""

    points_m: Floats
    files: ScanFiles
    labelled_region: str
    near_boxes: PointsNearBoxes

    @classmethod
    def read(cls, files: ScanFiles, labelled_region: str) -> "KittiScan":
        points_m = read_bin(files.points)
        boxes = [files.calibration.box_of(it) for it in files.objects]
        return cls(points_m, files, labelled_region, PointsNearBoxes.of(points_m, boxes))

    def labelled(self, slack: float) -> LabelledScan:
        points = self.near_boxes.inside(slack)
        of_objects = zip(self.files.objects, self.near_boxes.boxes, points)
        annotations = [Annotation(it.class_name, box, indices, it.track) for it, box, indices in of_objects]
        return LabelledScan(self.points_m, annotations, self.regions(points, slack), slack)

    def regions(self, points_of_objects: list[Indices], slack: float) -> NDArray[np.uint8]:
        if self.labelled_region == "per-point" and self.files.regions.exists():
            return np.fromfile(self.files.regions, np.uint8)
        regions = np.full(len(self.points_m), Region.LABELLED, np.uint8)
        if self.labelled_region == "camera":
            is_annotated = np.zeros(len(self.points_m), bool)
            for indices in points_of_objects:
                is_annotated[indices] = True
            regions = camera_regions(self.points_m, self.files, is_annotated, slack)
        for label, indices in zip(self.files.objects, points_of_objects):
            if label.truncated == self.files.ignored_level:
                regions[indices] = Region.UNSCORABLE
        return regions


@cache
def tracking_labels(path: Path) -> dict[int, list[Label]]:
    """The labels of a drive by number of the scan; track -1 is none."""
    by_scan: dict[int, list[Label]] = defaultdict(list)
    for line in filter(str.strip, path.read_text().splitlines()):
        scan, track, *fields = line.split()
        by_scan[int(scan)].append(Label.parse(fields, None if track == "-1" else int(track)))
    return by_scan


def tracking_files(root: Path, drive: str, number: int) -> ScanFiles:
    return ScanFiles(
        labels=tracking_labels(root / f"label_02/{drive}.txt").get(number, []),
        calibration=Calibration.read(root / f"calib/{drive}.txt"),
        image_size_px=image_size_px(root / f"image_02/{drive}"),
        points=root / f"velodyne/{drive}/{number:06}.bin",
        regions=root / f"point_region/{drive}/{number:06}.u8",
        ignored_level=IGNORED_LEVEL,
    )


def object_files(root: Path, _drive: str, number: int) -> ScanFiles:
    lines = filter(str.strip, (root / f"label_2/{number:06}.txt").read_text().splitlines())
    return ScanFiles(
        labels=[Label.parse(line.split(), None) for line in lines],
        calibration=Calibration.read(root / f"calib/{number:06}.txt"),
        image_size_px=image_size_px(root / f"image_2/{number:06}.png"),
        points=root / f"velodyne/{number:06}.bin",
        regions=root / f"point_region/{number:06}.u8",
        # Its labels give a share of truncation, and no level that means ignored.
        ignored_level=None,
    )


def kitti(folder: Path) -> Dataset:
    """The split `training` of whichever benchmark."""
    root = folder / "training"
    files_of = tracking_files if (root / "label_02").is_dir() else object_files
    sheet_file = root / "scanbench.json"
    sheet = json.loads(sheet_file.read_text()) if sheet_file.exists() else {}
    # KITTI labels vehicles, people, cyclists and trams, and not all that stands on a street.
    annotated = sheet.get("annotated_classes", ["car"])
    labelled_region = sheet.get("labeled_region", "camera")

    def read(drive: str, number: int) -> ScanWithSlack:
        return KittiScan.read(files_of(root, drive, number), labelled_region).labelled

    return Dataset(str(root), annotated == "every-object", annotated == "every-object" or "car" in annotated, read)
