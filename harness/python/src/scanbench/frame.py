"""Tables of a run as data frames of whatever is installed."""

from __future__ import annotations

import csv
import importlib
import importlib.util
import io
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

# Text in every run, whatever is in their cells: drives may be called 0000, and reasons may all be empty.
TEXT = frozenset(
    "dataset sequence detector task status reason source origin blocks criterion kind outcome slice metric unit "
    "annotation_class annotation_occlusion detection_class stage few_blocks".split()
)

Backend = Literal["pandas", "polars", "numpy"]


def installed() -> Backend:
    """The first of pandas and polars that can be imported, or NumPy."""
    if importlib.util.find_spec("pandas"):
        return "pandas"
    return "polars" if importlib.util.find_spec("polars") else "numpy"


def frame(columns: Mapping[str, NDArray[Any]], backend: Backend) -> Any:
    """A data frame; with NumPy a dictionary of columns."""
    if backend == "numpy":
        return dict(columns)
    library = importlib.import_module(backend)
    if backend == "polars":
        return library.DataFrame({name: _polars_values(values) for name, values in columns.items()}, strict=False)
    return library.DataFrame(dict(columns))


def _polars_values(values: NDArray[Any]) -> list[Any]:
    floats = values.dtype.kind == "f"
    return [None if floats and value != value else value for value in values.tolist()]


def columns_of_csv(text: str) -> dict[str, NDArray[Any]]:
    """Columns by name: integers, numbers (NaN where a cell is empty), or text."""
    rows = list(csv.reader(io.StringIO(text)))
    if not rows:
        return {}
    header, body = rows[0], rows[1:]
    cells = list(zip(*body, strict=True)) if body else [()] * len(header)
    return {name: _column(name, values) for name, values in zip(header, cells, strict=True)}


def columns_of_rows(rows: Sequence[Mapping[str, Any]]) -> dict[str, NDArray[Any]]:
    """Columns of objects, in the order in which names occur first; intervals become two columns, `_low` and `_high`."""
    flat = [_flat(row) for row in rows]
    names = list(dict.fromkeys(name for row in flat for name in row))
    return {name: _objects([row.get(name) for row in flat]) for name in names}


def _flat(row: Mapping[str, Any]) -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in row.items():
        if isinstance(value, list) and len(value) == 2:
            flat[f"{name}_low"], flat[f"{name}_high"] = value
        else:
            flat[name] = value
    return flat


def _column(name: str, cells: Sequence[str]) -> NDArray[Any]:
    if name not in TEXT:
        if not any(cells):
            return np.full(len(cells), np.nan)
        try:
            return np.array([int(cell) for cell in cells])
        except ValueError:
            pass
        try:
            return np.array([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            pass
        if set(cells) <= {"true", "false"}:
            return np.array([cell == "true" for cell in cells])
    return np.array(cells, dtype=object)


def _objects(values: Sequence[Any]) -> NDArray[Any]:
    there = [value for value in values if value is not None]
    if there and all(isinstance(value, bool) for value in values):
        return np.array(values)
    if there and all(isinstance(value, int | float) and not isinstance(value, bool) for value in there):
        if len(there) == len(values) and all(isinstance(value, int) for value in values):
            return np.array(values)
        return np.array([np.nan if value is None else float(value) for value in values])
    return np.array([*values, None], dtype=object)[:-1]


class Tables:
    """Tables with names. Each is read once it is asked for, and kept."""

    def __init__(self) -> None:
        self.backend: Backend = installed()
        self._frames: dict[tuple[str, Backend], Any] = {}

    @property
    def scans(self) -> Any:
        """Counts and latency, a row for each scan, detector and task."""
        return self.frame("scans")

    @property
    def matches(self) -> Any:
        """A row for each pair, and for each missed, false, ignored or unknowable object, with boxes and the reason."""
        return self.frame("matches")

    @property
    def report(self) -> Any:
        """Every number, a row for each data set, task, detector, slice and metric; those of all data sets are of `overall`."""
        return self.frame("report")

    def frame(self, name: str, backend: Backend | None = None) -> Any:
        """A table as a data frame, by its name.

        `backend` is pandas or polars, whichever is installed first, or NumPy: a dictionary of columns. Raises ScanbenchError if there
        is no such table.
        """
        key = (name, backend or self.backend)
        if key not in self._frames:
            self._frames[key] = frame(self._columns(name), key[1])
        return self._frames[key]

    def _columns(self, name: str) -> dict[str, NDArray[Any]]:
        raise NotImplementedError
