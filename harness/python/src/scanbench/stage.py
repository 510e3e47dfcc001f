"""Times of the stages of a detector."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter

from scanbench.detections import check_name

_TIMES_MS: dict[str, float] = {}


@contextmanager
def stage(name: str) -> Iterator[None]:
    """Takes the time of what is done inside, and reports it as a stage of the scan; entered twice, times are added.

    Raises ValueError if `name` is empty, longer than 60 bytes, or has control characters.
    """
    check_name(name)
    start_s = perf_counter()
    try:
        yield
    finally:
        _TIMES_MS[name] = _TIMES_MS.get(name, 0.0) + 1000.0 * (perf_counter() - start_s)


def take_times_ms() -> dict[str, float]:
    """Stages since the last call and their times in milliseconds, in the order in which they were first entered."""
    times_ms = dict(_TIMES_MS)
    _TIMES_MS.clear()
    return times_ms
