"""A run directory, and what disagrees with it."""

from collections import defaultdict
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from program import read_json, rows

Row = dict[str, str]
# Data set, drive, number of the scan, detector, task.
KEY = ("dataset", "sequence", "scan", "detector", "task")
BOX = ("center_x_m", "center_y_m", "center_z_m", "length_m", "width_m", "height_m", "yaw_rad")
N_SHOWN = 20


def key_of(row: Row) -> tuple[str, ...]:
    return tuple(row[it] for it in KEY)


def box_of(row: Row, side: str = "") -> np.ndarray | None:
    """The box of a row, or of its annotation or detection, if it has one."""
    box = [row[f"{side}{it}"] for it in BOX]
    return np.array(box, float) if all(box) else None


class Run:
    def __init__(self, path: Path) -> None:
        self.path, self.name = path, path.name
        self.manifest: dict[str, Any] = read_json(path / "manifest.json")
        self.scans = {key_of(row): row for row in rows(path / "scans.csv")}
        self.matches: dict[tuple[str, ...], list[Row]] = defaultdict(list)
        for row in rows(path / "matches.csv"):
            self.matches[key_of(row)].append(row)

    @cached_property
    def report(self) -> dict[str, Any]:
        return read_json(self.path / "report.json")


class Failures(list[str]):
    """Messages, one for each disagreement."""

    def check(self, is_good: bool, message: str) -> None:
        if not is_good:
            self.append(message)

    def print(self) -> None:
        for failure in self[:N_SHOWN]:
            print(f"DISAGREES {failure}")
        print(f"{len(self)} disagreements")
