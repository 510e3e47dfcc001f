"""Scripts that judge a detector that they define: what another process imports of them, and what not."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from test_run import program, run_directory

__all__ = ["program", "run_directory"]

DETECTOR = """
import numpy as np
import scanbench

def halves(points):
    return np.arange(len(points)) % 2
"""
RUN = "print(scanbench.run('a', detectors=[halves]).path)\n"
GUARD = 'if __name__ == "__main__":\n    '
HINT = 'Write `if __name__ == "__main__":` above the call'


def python(folder: Path, *arguments: str, stdin: str | None = None) -> subprocess.CompletedProcess[str]:
    """What this Python does with `arguments`; forty runs, one within the other, would take longer than it may."""
    return subprocess.run(
        [sys.executable, *arguments], cwd=folder, input=stdin, capture_output=True, text=True, timeout=60, check=False
    )


def check(ended: subprocess.CompletedProcess[str], folder: Path, said: str | None = None) -> None:
    """It fails and says so, or succeeds; the program was started once."""
    assert (ended.returncode != 0) == (said is not None) and (said or "") in ended.stderr, ended
    assert (folder / "starts").read_text().count("started") == 1, ended


def test_a_script_that_judges_itself_at_its_top_level_is_refused(program: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(DETECTOR + RUN)
    check(python(tmp_path, "mine.py"), tmp_path, HINT)


def test_under_a_guard_it_works(program: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(DETECTOR + GUARD + RUN)
    check(python(tmp_path, "mine.py"), tmp_path)


def test_a_module_that_does_so_is_refused(program: Path, tmp_path: Path) -> None:
    (tmp_path / "package").mkdir()
    (tmp_path / "package/__init__.py").touch()
    (tmp_path / "package/mine.py").write_text(DETECTOR + RUN)
    check(python(tmp_path, "-m", "package.mine"), tmp_path, HINT)
    (tmp_path / "starts").unlink()
    (tmp_path / "main.py").write_text("import package.mine\n")
    check(python(tmp_path, "main.py"), tmp_path, HINT)


def test_whoever_catches_the_error_at_an_import_has_a_detector(program: Path, tmp_path: Path) -> None:
    caught = "try:\n    " + RUN + "except scanbench.ScanbenchError as error:\n    print(error)\n"
    (tmp_path / "mine.py").write_text(DETECTOR + caught)
    ended = python(tmp_path, "mine.py")
    check(ended, tmp_path)
    assert "runs" in ended.stdout, ended


@pytest.mark.parametrize("way", ["-c", "stdin", "interactive", "exec"])
def test_what_has_no_file_is_pickled(program: Path, tmp_path: Path, way: str) -> None:
    pytest.importorskip("cloudpickle")
    script = DETECTOR + "\n" + RUN
    (tmp_path / "no_ending").write_text(script)
    arguments = {"-c": ["-c", script], "stdin": ["-"], "interactive": ["-i", "-q"], "exec": ["no_ending"]}[way]
    ended = python(tmp_path, *arguments, stdin=script if way in ("stdin", "interactive") else None)
    check(ended, tmp_path)
    assert "runs" in ended.stdout, ended


def test_processes_of_multiprocessing_do_not_run_all_of_it_again(program: Path, tmp_path: Path) -> None:
    spawned = """
import multiprocessing
from package import detectors

scanbench.run("a", detectors=[detectors.halves])
process = multiprocessing.get_context("spawn").Process(target=print)
process.start()
process.join()
raise SystemExit(process.exitcode)
"""
    (tmp_path / "package").mkdir()
    (tmp_path / "package/detectors.py").write_text(DETECTOR)
    (tmp_path / "mine.py").write_text("import scanbench\n" + spawned)
    check(python(tmp_path, "mine.py"), tmp_path, "a process of multiprocessing imported the main script")
    # As a worker it may judge what it likes.
    worker = """
import multiprocessing
import scanbench
from package import detectors

def judge():
    scanbench.run("a", detectors=[detectors.halves])

if __name__ == "__main__":
    process = multiprocessing.get_context("spawn").Process(target=judge)
    process.start()
    process.join()
    raise SystemExit(process.exitcode)
"""
    (tmp_path / "starts").unlink()
    (tmp_path / "worker.py").write_text(worker)
    check(python(tmp_path, "worker.py"), tmp_path)


def test_a_detector_judges_nothing(program: Path, tmp_path: Path) -> None:
    within = (
        DETECTOR
        + """
def nested(points):
    scanbench.run('b', detectors=[halves])
    return halves(points)

if __name__ == "__main__":
    scanbench.run('a', detectors=[nested])
"""
    )
    (tmp_path / "mine.py").write_text(within)
    check(python(tmp_path, "mine.py"), tmp_path, "scanbench.run was called by a detector")


def test_what_a_detector_starts_judges_nothing_either(program: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(DETECTOR + GUARD + RUN)
    variables = {"SCANBENCH_READ_FD": "3", "SCANBENCH_WRITE_FD": "4"}
    ended = subprocess.run(
        [sys.executable, "mine.py"],
        cwd=tmp_path,
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode != 0 and "was called by a detector" in ended.stderr, ended
    assert not (tmp_path / "starts").exists()
