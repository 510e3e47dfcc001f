"""The package and the program together: what a real run leaves behind, and a folder of `scanbench init`."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import detectors
import numpy as np
import pytest

import scanbench
from scanbench import Run, ScanbenchError, find_program
from scanbench.program import call

TINY: dict[str, Any] = {"simulated_scans": 2, "sensor": "vlp-16", "quiet": True}
PACKAGE = str(Path(scanbench.__file__).parents[1])


def knows(verb: str) -> bool:
    try:
        program = find_program()
    except ScanbenchError:
        return False
    return subprocess.run([program, verb, "--help"], capture_output=True, check=False).returncode == 0


needs_program = pytest.mark.skipif(not knows("run"), reason="there is no program")
needs_processes = pytest.mark.skipif(not knows("serve"), reason="there is no program that starts detectors")


@pytest.fixture(autouse=True)
def package(monkeypatch: pytest.MonkeyPatch) -> None:
    """The detectors' processes find the package where this one does, installed or not."""
    monkeypatch.setenv("PYTHONPATH", PACKAGE)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    output = tmp_path_factory.mktemp("real") / "run"
    return scanbench.run("street-narrow", ["hierarchical", "pca"], output=output, **TINY)


@needs_program
@pytest.mark.parametrize("backend", ["numpy", "pandas", "polars"])
def test_every_table_of_a_real_run_is_a_frame(run: Run, backend: Any) -> None:
    if backend != "numpy":
        pytest.importorskip(backend)
    for path in [*run.path.glob("*.csv"), run.path / "report.json"]:
        frame = run.frame(path.stem, backend)
        names = frame.keys() if backend == "numpy" else frame.columns
        # Only what takes what for what is a narrow table.
        assert len(set(names)) == len(names) > (4 if path.stem == "confusion" else 5), path
        assert len(frame[list(names)[0]]) > 0, path


@needs_program
def test_tables_of_a_real_run_say_the_same(run: Run) -> None:
    scans, matches, report = (run.frame(name, "numpy") for name in ["scans", "matches", "report"])
    # Two scans; two tasks of both detectors, and two classes that only one of them gives.
    assert len(scans["scan"]) == 12 and set(scans["detector"]) == {"hierarchical", "pca"}
    for name, kind in {"scan": "i", "n_points": "i", "tp": "i", "latency_ms": "f", "sequence": "O"}.items():
        assert scans[name].dtype.kind == kind, name
    for detector in ["hierarchical", "pca"]:
        of_scans = (scans["detector"] == detector) & (scans["task"] == "objects")
        tp, fo, no = (int(scans[name][of_scans].sum()) for name in ["tp", "fo", "no"])
        of_matches = (matches["detector"] == detector) & (matches["task"] == "objects")
        assert np.count_nonzero(of_matches & (matches["outcome"] == "matched")) == tp > 0
        row = (report["detector"] == detector) & (report["task"] == "objects") & (report["slice"] == "all")
        row &= (report["metric"] == "f_rate") & (report["dataset"] == "street-narrow")
        assert report["value"][row] == pytest.approx([2 * tp / (no + tp + fo)])
    assert np.isfinite(matches["annotation_length_m"][matches["outcome"] == "missed"]).all()
    assert np.isfinite(report["interval_95_low"]).any() and report["value"].dtype.kind == "f"
    assert run.manifest["detectors"] and run.manifest["schema"] == 1


@needs_program
def test_a_real_run_is_a_page_in_a_notebook(run: Run) -> None:
    html = run._repr_html_()
    assert html.count("<table>") >= 2 and html.count("data:image/svg+xml") >= 4
    # Nothing of Markdown is left.
    text = re.sub("<[^>]*>", "", html)
    assert "|" not in text and "**" not in text and "\\" not in text


@needs_program
def test_what_the_program_refuses_is_an_error() -> None:
    with pytest.raises(ScanbenchError, match="exit code [23].*\n.*nowhere") as failure:
        scanbench.run("nowhere", ["pca"], quiet=True)
    assert failure.value.exit_code in (2, 3)


@needs_processes
def test_functions_are_rows_beside_a_detector_of_the_program(tmp_path: Path) -> None:
    wide = detectors.squares.using(name="squares-4", side_m=4)
    run = scanbench.run("street-narrow", [detectors.squares, wide, "pca"], output=tmp_path / "run", **TINY)
    scans = run.frame("scans", "numpy")
    assert set(scans["detector"]) == {"squares", "squares-4", "pca"} and set(scans["status"]) == {"evaluated"}
    again = scanbench.run("street-narrow", [detectors.squares], parameters={"side_m": 4}, output=tmp_path / "4", **TINY)
    counts = again.frame("scans", "numpy")
    assert counts["tp"].tolist() == scans["tp"][scans["detector"] == "squares-4"].tolist()


@needs_processes
def test_a_project_may_name_models_that_no_function_reads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shipped = str(Path(__file__).parents[3] / "detector/src/params")
    (tmp_path / "scanbench.toml").write_text(f'[vehicle_model]\ngroupings_directory = "{shipped}"\n')
    monkeypatch.chdir(tmp_path)
    run = scanbench.run("street-narrow", [detectors.squares], output="run", **TINY)
    assert run.manifest["config"]["vehicle_model"]["groupings_directory"] == shipped
    # The file of a run alone may not, as on the command line.
    with pytest.raises(ScanbenchError, match="no chosen detector reads it") as failure:
        scanbench.run("street-narrow", [detectors.squares], config="scanbench.toml", output="refused", **TINY)
    assert failure.value.exit_code == 2


@needs_processes
def test_a_function_that_fails_ends_the_run_or_is_skipped(tmp_path: Path) -> None:
    wrong = detectors.wrong.using(how="short")
    with pytest.raises(ScanbenchError, match=r"labels are of shape") as failure:
        scanbench.run("street-narrow", [wrong], output=tmp_path / "stopped", **TINY)
    assert failure.value.exit_code == 6 and not (tmp_path / "stopped").exists()
    run = scanbench.run("street-narrow", [wrong, "pca"], output=tmp_path / "run", on_detector_failure="skip", **TINY)
    scans = run.frame("scans", "numpy")
    of_wrong = scans["detector"] == "wrong"
    assert scans["tp"][of_wrong].sum() == 0 and scans["tp"][~of_wrong].sum() > 0


@needs_program
@pytest.mark.skipif(not knows("init"), reason="the program has no init")
def test_a_folder_of_init_runs_and_is_gated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # The commands of the folder call the Python that has the package.
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    call(["init", "mine"], quiet=True)
    monkeypatch.chdir(tmp_path / "mine")
    if not knows("serve"):
        pytest.skip("there is no program that starts detectors")
    call(["run", "data/street", "-d", "cells", "-o", "runs/first"], quiet=True)
    report = Run.open("runs/first").frame("report", "numpy")
    (f_rate,) = report["value"][
        (report["metric"] == "f_rate") & (report["slice"] == "all") & (report["task"] == "objects")
    ]
    assert f_rate > 0.4
