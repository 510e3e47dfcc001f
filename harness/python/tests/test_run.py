"""`run`, and reading what a run leaves behind."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import detectors
import numpy as np
import pytest
import tomllib

import scanbench
from scanbench import Run, ScanbenchError
from scanbench.configuration_file import command, toml
from scanbench.frame import columns_of_csv, columns_of_rows, frame
from scanbench.notebook import html_of_markdown

HERE = Path(__file__).parent

SCANS = """dataset,sequence,scan,time_s,detector,task,status,reason,n_points,latency_ms,tp
kitti,0000,0,0.000,squares,objects,evaluated,,127261,3.018,38
kitti,0000,1,0.100,squares,objects,failed,"silent, for 10 s",127261,,0
"""
MATCHES = """dataset,scan,outcome,cost,annotation_id
kitti,0,matched,0.25,0
kitti,0,false,,
"""
REPORT: dict[str, Any] = {
    "schema": 1,
    "rows": [
        {
            "dataset": "kitti",
            "metric": "recall",
            "value": 0.5,
            "n": 4,
            "higher_is_better": True,
            "interval_95": [0.4, 0.6],
        },
        {"dataset": "kitti", "metric": "precision", "value": None, "n": 0, "higher_is_better": True},
    ],
    "overall": [{"dataset": "overall", "metric": "no", "value": 4.0, "n": 4, "higher_is_better": None}],
}
TABLE = """**Task objects. Rates in %.**

| data set | squares: F-rate | time \\[ms] |
| :-- | --: | --: |
| kitti \\| <b> | *50.0* | 3 |
| **overall** |  | 4§ |

- ND: detections that count.
- § few.
"""


@pytest.fixture
def run_directory(tmp_path: Path) -> Path:
    directory = tmp_path / "made"
    (directory / "figures").mkdir(parents=True)
    (directory / "figures/ranking.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    (directory / "scans.csv").write_text(SCANS)
    (directory / "matches.csv").write_text(MATCHES)
    (directory / "report.json").write_text(json.dumps(REPORT))
    (directory / "manifest.json").write_text('{"schema": 1}')
    (directory / "table_objects.md").write_text(TABLE)
    return directory


@pytest.fixture
def program(tmp_path: Path, run_directory: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    script = tmp_path / "scanbench"
    script.write_text(
        f'#!/bin/sh\necho started >> "{tmp_path}/starts"\nexec "{sys.executable}" "{HERE}/fake_program.py" "$@"\n'
    )
    script.chmod(0o755)
    monkeypatch.setenv("SCANBENCH", str(script))
    monkeypatch.setenv("FAKE_RUN", str(run_directory))
    monkeypatch.setenv("PYTHONPATH", str(Path(scanbench.__file__).parents[1]))
    monkeypatch.chdir(tmp_path)
    return script


def call_of(run: Run) -> dict[str, Any]:
    call: dict[str, Any] = json.loads((run.path / "call.json").read_text())
    return call


def test_a_function_is_judged(program: Path) -> None:
    run = scanbench.run(
        "street-narrow",
        [detectors.squares, detectors.squares.using(name="squares-4", side_m=4), "hierarchical"],
        scans="0..4",
        simulated_scans=4,
        skip_damaged=True,
        mcap=False,
        topic=None,
        class_=None,
        parameters={"kd_tree.tolerance_m": 0.7, "terrain.enabled": False},
        start_limit_s=90,
        time_limit_s=20,
        vehicles="model",
        threads=2,
        quiet=True,
    )
    call = call_of(run)
    assert call["found"]["squares"] == 50 and call["found"]["squares-4"] == 25
    assert call["argv"][:4] == ["run", "street-narrow", "-d", "squares,squares-4,hierarchical"]
    assert call["others"] == ["--scans=0..4", "--simulated-scans=4", "--skip-damaged"]
    assert "kd_tree.tolerance_m=0.7" in call["argv"] and "terrain.enabled=false" in call["argv"]
    section = call["config"]["detector"]["squares-4"]
    assert section.pop("command")
    assert section == {
        "parameters": {"side_m": 4.0, "min_z_m": -1.4},
        "start_limit_s": 90,
        "time_limit_s": 20,
        "threads": 2,
        "vehicles": "model",
    }
    assert run.path.parent == Path("runs") and run.frame("scans", "numpy")["scan"].tolist() == [0, 1]


def test_output_several_data_sets_and_a_configuration_of_ones_own(program: Path, tmp_path: Path) -> None:
    own = tmp_path / "mine/scanbench.toml"
    own.parent.mkdir()
    own.write_text('[detector.mine]\ncommand = ["true"]\n')
    run = scanbench.run(["a", Path("b")], [detectors.squares], output=tmp_path / "out", config=own)
    call = call_of(run)
    assert run.path == tmp_path / "out" and call["argv"][1:3] == ["a", "b"]
    assert set(call["config"]["detector"]) == {"mine", "squares"}
    assert "-c" in call["argv"] and call["project"] is None
    assert [path.name for path in own.parent.iterdir()] == ["scanbench.toml"]


def test_the_configuration_of_the_folder_is_found(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "scanbench.toml").write_text('[detector.mine]\ncommand = ["true"]\n')
    (tmp_path / "below").mkdir()
    monkeypatch.chdir(tmp_path / "below")
    call = call_of(scanbench.run("a", [detectors.squares]))
    assert set(call["config"]["detector"]) == {"mine", "squares"}
    # As the file that the program finds, which may name models that no detector of the run reads; `-c` may not.
    assert "-c" not in call["argv"] and Path(call["project"]).parent == tmp_path
    assert [path.name for path in tmp_path.glob("*.toml")] == ["scanbench.toml"]


def test_without_functions_the_configuration_is_passed_on(program: Path) -> None:
    assert "-c" not in call_of(scanbench.run("a", ["pca"]))["argv"]


def test_results_made_elsewhere_are_judged(program: Path) -> None:
    run = scanbench.run(
        "a", ["pca"], detections={"net": Path("results/net"), "other": "b.json"}, missing_detections="empty"
    )
    words = ["--detections", "net=results/net", "--detections", "other=b.json"]
    assert call_of(run)["argv"][:8] == ["run", "a", "-d", "pca", *words]
    # Without detectors, the program takes its own ones beside them.
    alone = scanbench.run("a", detections={"net": "results/net"})
    assert "-d" not in call_of(alone)["argv"] and alone.path.name.endswith("-net")
    with pytest.raises(ValueError, match="need a name each"):
        scanbench.run("a", ["net"], detections={"net": "results/net"})


def test_a_plain_function_and_one_that_cannot_be_imported(program: Path) -> None:
    pytest.importorskip("cloudpickle")
    shift = 3

    @scanbench.detector(noise=0)
    def inner(points: Any, n: int = 2) -> Any:
        return np.arange(len(points)) % n + shift

    call = call_of(scanbench.run("a", [detectors.plain, inner.using(n=5)]))
    assert call["found"] == {"plain": 1, "inner": 5}


def test_every_parameter_is_written_that_toml_can_say(program: Path) -> None:
    def odd(points: Any, limit: float | None = None, side_m: float = 2, names: tuple[str, ...] = ("a",)) -> Any:
        return np.zeros(len(points), int)

    pytest.importorskip("cloudpickle")
    call = call_of(scanbench.run("a", [odd]))
    assert call["config"]["detector"]["odd"]["parameters"] == {"side_m": 2.0, "names": ["a"]}
    with pytest.raises(TypeError, match="cannot be a parameter"):
        scanbench.run("a", [scanbench.detector(odd).using(limit=float("nan"))])


def test_how_another_process_gets_at_it(tmp_path: Path) -> None:
    assert command(detectors.squares, tmp_path)[-1] == "detectors:squares"
    # Under another noise than the name in the module says, it is not that detector.
    other = scanbench.Detector(detectors.squares.target, "other", None, 0)
    if sys.modules.get("cloudpickle"):
        assert command(other, tmp_path)[-1].endswith("other.pickle")


def test_a_detector_that_fails_says_why(program: Path) -> None:
    wrong = detectors.wrong.using(how="short")
    with pytest.raises(ScanbenchError, match=r"a detector failed .exit code 6.*\n.*labels are of shape") as failure:
        scanbench.run("a", [wrong], quiet=True)
    assert failure.value.exit_code == 6


def test_names(program: Path) -> None:
    refused: list[list[Any]] = [[], [detectors.squares, detectors.squares], ["a", "a"]]
    for wrong in refused:
        with pytest.raises(ValueError, match="need a name each"):
            scanbench.run("a", wrong)
    with pytest.raises(ValueError, match="is no name for a detector"):
        scanbench.run("a", [detectors.squares.using(name="a b")])
    with pytest.raises(ValueError, match="unknown parameter 'side'"):
        detectors.squares.using(side=1)


def test_the_program_is_looked_for(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("SCANBENCH", str(tmp_path / "nothing"))
    with pytest.raises(ScanbenchError, match="which is no program"):
        scanbench.find_program()
    monkeypatch.delenv("SCANBENCH")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("sysconfig.get_path", lambda _: str(tmp_path / "bin"))
    monkeypatch.setattr("site.getuserbase", lambda: str(tmp_path / "user"))
    with pytest.raises(ScanbenchError, match="install the wheel"):
        scanbench.find_program()
    for folder in [tmp_path, tmp_path / "bin"]:
        folder.mkdir(exist_ok=True)
        (folder / "scanbench").touch(0o755)
        assert scanbench.find_program() == folder / "scanbench"


def test_frames(run_directory: Path) -> None:
    run = Run.open(run_directory)
    for backend in ["pandas", "polars"]:
        pytest.importorskip(backend)
        for name, shape in [("scans", (2, 11)), ("matches", (2, 5)), ("report", (3, 7))]:
            assert run.frame(name, backend).shape == shape  # type: ignore[arg-type]
    scans = run.frame("scans", "numpy")
    assert scans["sequence"].tolist() == ["0000", "0000"] and scans["scan"].tolist() == [0, 1]
    assert scans["latency_ms"][0] == 3.018 and np.isnan(scans["latency_ms"][1])
    assert scans["reason"].tolist() == ["", "silent, for 10 s"]
    assert columns_of_csv("reason,sequence\n,7\n")["reason"].tolist() == [""]
    assert columns_of_csv("reason,sequence\n,7\n")["sequence"].tolist() == ["7"]
    report = run.frame("report", "numpy")
    assert report["value"][0] == 0.5 and np.isnan(report["value"][1]) and report["dataset"][2] == "overall"
    assert report["interval_95_low"][0] == 0.4 and np.isnan(report["interval_95_high"][1])
    assert report["n"].dtype.kind == "i" and report["higher_is_better"].tolist() == [True, True, None]
    assert run.scans is run.scans and run.manifest == {"schema": 1}
    assert eval(repr(run), {"Run": Run}).path == run.path


def test_protocols_are_a_frame_and_a_missing_table_is_an_error(run_directory: Path) -> None:
    run = Run.open(run_directory)
    with pytest.raises(ScanbenchError, match="has no table 'protocols'; it has matches, report, scans"):
        run.frame("protocols")
    rows = [
        {
            "protocol": "kitti-object",
            "class": "car",
            "metric": "ap",
            "value": 0.729,
            "n": 7,
            "interval_95": [0.7, 0.75],
        },
        {"protocol": "kitti-object", "class": "van", "metric": "ap", "value": None, "n": 0},
    ]
    (run_directory / "protocols.json").write_text(json.dumps({"schema": 1, "rows": rows}))
    protocols = run.frame("protocols", "numpy")
    assert protocols["class"].tolist() == ["car", "van"] and protocols["value"][0] == 0.729
    assert np.isnan(protocols["value"][1]) and protocols["interval_95_low"][0] == 0.7


def test_no_run_and_an_empty_table(tmp_path: Path) -> None:
    with pytest.raises(ScanbenchError, match="is no run"):
        Run.open(tmp_path)
    assert list(columns_of_csv("a,b\n")) == ["a", "b"] and columns_of_csv("") == {} and columns_of_rows([]) == {}
    assert len(frame(columns_of_csv("a,b\n"), "numpy")["a"]) == 0


def test_html(run_directory: Path) -> None:
    html = Run.open(run_directory)._repr_html_()
    assert html.count("<table") == 1 and html.count("<tr>") == 3 and html.count("data:image/svg+xml") == 1
    assert "kitti &#124; &lt;b&gt;" in html and "<i>50.0</i>" in html and "<b>overall</b>" in html
    assert re.search('<th style="text-align:right[^>]*>time &#91;ms]</th>', html) and html.count("<li>") == 2
    assert html_of_markdown("a & b") == "<p>a &amp; b</p>"


@pytest.mark.parametrize(
    "value",
    [
        1,
        -2.5,
        3.0,
        1e-7,
        1e300,
        True,
        'a"b\\c\n\x7f\u00e9',
        [1, 2],
        {"a b": 0.5, "c": ["x"]},
        np.float64(0.5),
        np.int32(3),
    ],
)
def test_toml_is_read_as_it_was_written(value: Any) -> None:
    assert tomllib.loads(f"x = {toml(value)}")["x"] == value


def test_what_toml_cannot_say() -> None:
    for value in [None, float("nan"), object()]:
        with pytest.raises(TypeError):
            toml(value)


def test_a_detector_can_be_called_and_tried_without_the_program() -> None:
    points = np.zeros((3, 4), np.float32)
    assert detectors.squares(points).tolist() == [0, 0, 0]
    cloud = scanbench.Cloud(0, "a", 0.0, points[:, 0], points[:, 1], points[:, 2])
    assert detectors.squares.detect(cloud).labels is not None


def test_what_is_no_detector() -> None:
    with pytest.raises(TypeError, match="takes no scan"):
        scanbench.detector(lambda: None)
    with pytest.raises(ValueError, match="noise is -1 or 0"):
        scanbench.detector(noise=1)(lambda points: points)  # type: ignore[call-overload]
