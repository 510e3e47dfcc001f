"""Runs that would start themselves: a script that is imported as a detector must not judge itself while that happens."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from scanbench.program import ScanbenchError

ADVICE = 'Write `if __name__ == "__main__":` above the call, as above all that is not to happen at an import.'

_IMPORTED: list[str] = []


@contextmanager
def importing(target: str) -> Iterator[None]:
    """While `target` is imported to be served."""
    _IMPORTED.append(target)
    try:
        yield
    finally:
        _IMPORTED.pop()


def refuse_nesting() -> None:
    """Raises ScanbenchError in a process whose run would start it again, before anything is started."""
    if _IMPORTED:
        raise ScanbenchError(
            f"scanbench.run was called while {_IMPORTED[-1]} was imported for its detector: it would start itself again, "
            f"without end. {ADVICE}"
        )
    if _is_child_importing_main():
        raise ScanbenchError(
            "scanbench.run was called while a process of multiprocessing imported the main script: each of them would run all "
            f"of it again. {ADVICE}"
        )
    # The program sets these for the processes of detectors, and whatever they start inherits them.
    if {"SCANBENCH_READ_FD", "SCANBENCH_WRITE_FD"} <= os.environ.keys():
        raise ScanbenchError(
            "scanbench.run was called by a detector, whose run would start the detector again, without end"
        )


def _is_child_importing_main() -> bool:
    """As multiprocessing itself finds out, before it refuses to start a process then."""
    process = sys.modules.get("multiprocessing.process")
    return process is not None and bool(getattr(process.current_process(), "_inheriting", False))
