"""Runs scanbench, and reads what it leaves."""

import csv
import json
import subprocess
from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from judgement import Detections
from labelled_scan import Box, Indices

Row = dict[str, str]
# Data set, drive, number of the scan, detector, task.
ScanKey = tuple[str, str, str, str, str]

BOX_COLUMNS = ("center_x_m", "center_y_m", "center_z_m", "length_m", "width_m", "height_m", "yaw_rad")
# Of metres and radians in the files, which have four decimals.
BOX_ROUNDING = 2e-4


@dataclass(frozen=True)
class Program:
    """The executable."""

    path: Path

    def call(self, *arguments: object) -> None:
        """Runs a verb, and raises with its last words if that fails."""
        command = [str(self.path), *map(str, arguments)]
        done = subprocess.run(command, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)} ended with {done.returncode}: {done.stderr[-2000:]}")

    def detect(self, root: str, drive: str, number: int, detector: str, scratch: Path) -> tuple[Detections, list[Row]]:
        """What a detector finds in a scan, by points and by rows of boxes."""
        name = scratch / f"{Path(root).parent.name}-{Path(root).name}-{drive}-{number}-{detector}"
        clusters, boxes = name.with_suffix(".u32"), name.with_suffix(".csv")
        self.call("detect", root, "--scan", f"{drive}/{number:06}", "-d", detector, "-o", clusters, "--boxes", boxes)
        # Clusters are numbered from 1 in files, and 0 is none.
        of_point: Indices = np.fromfile(clusters, "<u4").astype(np.int64) - 1
        rows = read_csv(boxes)
        return Detections(of_point, [row["class"] for row in rows]), rows


def read_csv(path: Path) -> list[Row]:
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def key_of(row: Row) -> ScanKey:
    return row["dataset"], row["sequence"], row["scan"], row["detector"], row["task"]


def row_box(row: Row, side: str) -> Box | None:
    """The box of the annotation or detection of a row, if it has one."""
    if row[f"{side}_length_m"] == "":
        return None
    x, y, z, length_m, width_m, height_m, yaw_rad = (float(row[f"{side}_{it}"]) for it in BOX_COLUMNS)
    return Box((x, y, z), length_m, width_m, height_m, yaw_rad)


class Run:
    """A run directory."""

    def __init__(self, path: Path) -> None:
        self.path, self.name = path, path.name
        self.manifest: dict[str, Any] = json.loads((path / "manifest.json").read_text())
        self.scans: dict[ScanKey, Row] = {key_of(row): row for row in read_csv(path / "scans.csv")}
        self.matches: dict[ScanKey, list[Row]] = defaultdict(list)
        for row in read_csv(path / "matches.csv"):
            self.matches[key_of(row)].append(row)

    @cached_property
    def report(self) -> dict[str, Any]:
        return json.loads((self.path / "report.json").read_text())

    def id_of(self, root: str) -> str:
        """What the data set in this folder is called."""
        (name,) = [it["id"] for it in self.manifest["datasets"] if Path(it["root"]).resolve() == Path(root).resolve()]
        return name
