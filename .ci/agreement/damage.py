"""Damages rows of a run, one at a time, to see that each damage is found."""

from collections.abc import Callable, Iterator
from copy import copy

from program import Row, Run, key_of


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


def damaged_copies(run: Run, may_be_damaged: Callable[[Row], bool]) -> Iterator[tuple[str, Run]]:
    """For every kind of damage that the rows of `run` allow, what it is and a run that has it."""
    for outcome, becomes, damage in DAMAGES:
        rows = [row for rows in run.matches.values() for row in rows if row["outcome"] == outcome and may_be_damaged(row)]
        if not rows:
            continue
        row = rows[len(rows) // 2]
        damaged, of_scan = copy(run), run.matches[key_of(row)]
        changed = [it if it is not row else damage(row) for it in of_scan]
        damaged.matches = {**run.matches, key_of(row): [it for it in changed if it is not None]}
        yield f"{outcome} is {becomes}", damaged
