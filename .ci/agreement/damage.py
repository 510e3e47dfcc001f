"""Damages copies of a run, one row at a time, to see that each damage is found."""

import shutil
from collections.abc import Callable
from pathlib import Path

from program import Row, Run, read_csv, write_csv


def flipped(outcome: str) -> Callable[[Row], Row | None]:
    return lambda row: {**row, "outcome": outcome}


# The outcome of the row that is damaged, and what becomes of the row; `None` is lost.
DAMAGES: list[tuple[str, str, Callable[[Row], Row | None]]] = [
    ("matched", "missed", flipped("missed")),
    ("missed", "ignored", flipped("ignored")),
    ("ignored", "missed", flipped("missed")),
    ("false", "ignored", flipped("ignored")),
    ("unknowable", "false", flipped("false")),
    ("matched", "of another detection", lambda row: {**row, "detection_id": str(int(row["detection_id"]) + 1)}),
    ("matched", "of another cost", lambda row: {**row, "cost": str(float(row["cost"]) + 0.01)}),
    ("ignored", "for another reason", lambda row: {**row, "reason": "too dark"}),
    ("missed", "lost", lambda _: None),
]


def damaged_copies(run: Run, may_be_damaged: Callable[[Row], bool], scratch: Path) -> list[tuple[str, Run]]:
    """For every kind of damage that the rows of `run` allow, what it is and a copy that has it."""
    rows = read_csv(run.path / "matches.csv")
    copies: list[tuple[str, Run]] = []
    for outcome, becomes, damage in DAMAGES:
        candidates = [idx for idx, row in enumerate(rows) if row["outcome"] == outcome and may_be_damaged(row)]
        if not candidates:
            continue
        idx = candidates[len(candidates) // 2]
        damaged = damage(rows[idx])
        path = scratch / f"damaged-{len(copies)}"
        path.mkdir(parents=True)
        for name in ("manifest.json", "scans.csv"):
            shutil.copy(run.path / name, path)
        write_csv(path / "matches.csv", [*rows[:idx], *([damaged] if damaged else []), *rows[idx + 1 :]])
        copies.append((f"{outcome} is {becomes}", Run(path)))
    return copies
