"""The client against a host that checks every byte."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from reference_host import DetectorFailure, Host, Limits, ReportedFailure, Silence, columns_of

import scanbench

HERE = Path(__file__).parent
PROTOCOL = HERE.parents[2] / "docs/protocol.md"
SOURCES = {"PYTHONPATH": str(Path(scanbench.__file__).parents[1])}
SHORT = Limits(start_s=20, first_scan_s=1, scan_s=1, quit_s=2)


def points(n: int = 1000, seed: int = 1) -> NDArray[np.float32]:
    random = np.random.default_rng(seed)
    return (random.random((n, 4)) * [40, 40, 3, 1] - [20, 20, 2, 0]).astype(np.float32)


def command(name: str) -> list[str]:
    return [sys.executable, "-m", "scanbench.serve", f"detectors:{name}"]


def host(name: str, **others: Any) -> Host:
    others.setdefault("limits", Limits(start_s=20))
    return Host(command(name), directory=HERE, environment=SOURCES, **others)


@contextmanager
def begun(it: Host) -> Iterator[Host]:
    with it:
        it.hello()
        it.configure()
        yield it


def test_squares_are_those_of_the_function() -> None:
    from detectors import squares

    with host("squares", parameters={"side_m": 3}) as it:
        assert it.hello() == {"message": "hello", "protocol": 1, "name": "squares", "version": "1.0"}
        it.configure()
        for number in range(3):
            cloud = points(seed=number)
            answer = it.scan(columns_of(cloud), number)
            expected = squares(cloud, side_m=3.0)
            assert answer.ids is not None and np.array_equal(answer.ids.astype(int) - 1, expected)
            assert answer.n_detections == len(set(expected.tolist()) - {-1})
        assert it.quit() == 0


def test_a_file_serves_itself_and_is_named_by_its_path() -> None:
    for arguments in [["detectors.py"], ["-m", "scanbench.serve", "detectors.py:squares"]]:
        with begun(Host([sys.executable, *arguments], directory=HERE, environment=SOURCES)) as it:
            assert it.scan(columns_of(points())).n_detections > 10
            assert it.quit() == 0


def look_back(it: Host) -> None:
    """A detector that looks back: what it gets in version 2, and what it answers."""
    assert it.hello(protocols=[1, 2])["protocol"] == 2
    it.configure()
    assert it.wishes == (2, True)
    scans = [columns_of(points(n)) for n in (50, 3000, 70)]
    for columns, first_m in zip(scans, (10, 9, 7), strict=True):
        columns["x_m"][0] = first_m
    pose = [1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7]
    answer = it.scan(scans[0], 7, begins_drive=True, earlier=scans[1:], world_from_sensor=pose)
    assert answer.boxes[:, :3].tolist() == [[10, 1, 5], [9, 1, 5], [7, 1, 5]]
    assert answer.velocities is not None and answer.tracks is not None
    assert np.allclose(answer.velocities, [[np.nan] * 2, [10.0, 0.0], [15.0, 0.0]], equal_nan=True)
    assert answer.tracks.tolist() == [2**32 - 1, 0, 1]
    # At the beginning of a drive there are fewer, and the state outlives larger memory.
    assert it.scan(scans[1], 8).boxes[:, :3].tolist() == [[9, 2, 0]]
    it.configure(parameters={**it.parameters, "n_back": 0})
    assert it.wishes == (0, True)
    assert it.quit() == 0


def test_a_detector_that_looks_back() -> None:
    with host("LookingBack", max_points=100) as it:
        look_back(it)
    # An older program has no scans before a scan.
    with host("LookingBack") as it:
        assert it.hello()["protocol"] == 1
        with pytest.raises(ReportedFailure, match="earlier_scans, in_order, which this scanbench does not know"):
            it.configure()


@pytest.mark.parametrize("n_back", [-1, True, 1.5])
def test_wrong_numbers_of_scans_are_refused(n_back: Any) -> None:
    with host("LookingBack", parameters={"n_back": n_back}) as it:
        it.hello(protocols=[1, 2])
        with pytest.raises(ReportedFailure, match="n_back|looks back at"):
            it.configure()


def test_who_looks_back_wants_clouds() -> None:
    with pytest.raises(TypeError, match="annotated Cloud"):
        scanbench.detector(earlier_scans=1)(lambda points: points)


def test_a_cloud_has_the_columns_that_there_are() -> None:
    columns: dict[str, NDArray[Any]] = dict(columns_of(points(101)))
    del columns["intensity"]
    columns["ring"] = np.arange(101, dtype=np.uint16)
    columns["time_offset_s"] = np.zeros(101, np.float32)
    with begun(host("by_ring")) as it:
        answer = it.scan(columns)
        assert answer.ids is not None and np.array_equal(answer.ids, np.arange(1, 102))


def test_intensity_is_zero_where_there_is_none() -> None:
    columns = columns_of(points())
    del columns["intensity"]
    with begun(host("squares")) as it:
        assert it.scan(columns).n_detections > 10


def test_labels_from_one() -> None:
    with begun(host("labels_from_one")) as it:
        answer = it.scan(columns_of(points(6)))
        assert answer.ids is not None and answer.ids.tolist() == [0, 1, 2, 0, 1, 2]


def test_boxes_scores_and_classes() -> None:
    with begun(host("one_box")) as it:
        answer = it.scan(columns_of(points()))
        assert answer.ids is None and answer.classes == ["car"]
        assert np.allclose(answer.boxes, [[10, 0, -1, 4, 2, 1.5, 0.5]])
        assert answer.scores is not None and np.allclose(answer.scores, [0.9])


def test_boxes_of_clusters() -> None:
    with begun(host("both")) as it:
        answer = it.scan(columns_of(points()))
        assert answer.ids is not None and set(answer.ids.tolist()) == {1, 2}
        assert answer.classes == ["car", None] and answer.n_detections == 2


def test_everything_with_gaps_stages_and_a_product() -> None:
    cloud = points()
    with begun(host("everything")) as it:
        for _ in range(2):
            answer = it.scan(columns_of(cloud))
            assert answer.ids is not None and set(answer.ids.tolist()) == {0, 4, 8}
            assert answer.n_detections == 2 and answer.classes == [None, "tram"]
            assert answer.scores is not None and answer.scores.tolist() == [0.5, -1.0]
            assert [name for name, _ in answer.stages] == ["ground", "clusters"]
            assert np.array_equal(answer.products["ground"], cloud[:, 2] < -1)


def test_an_empty_scan() -> None:
    for name in ["squares", "one_box", "labels_from_one"]:
        with begun(host(name)) as it:
            assert it.scan(columns_of(points(0))).n_detections == (name == "one_box")


def test_state_stays_when_more_memory_is_given() -> None:
    with begun(host("Counting", max_points=100, parameters={"offset": 20})) as it:
        found = []
        for n in [100, 150, 5000, 7]:
            answer = it.scan(columns_of(points(n)))
            assert answer.ids is not None
            found.append(int(answer.ids[0]))
        assert found == [195, 196, 197, 198]


def first_label(it: Host, n: int = 100) -> int:
    answer = it.scan(columns_of(points(n)))
    assert answer.ids is not None
    return int(answer.ids[0])


@pytest.mark.parametrize(
    "other",
    [
        {"parameters": {"offset": 20}, "threads": 2},
        {"parameters": {"offset": 20}, "dataset": "another"},
        {"parameters": {"offset": 20}, "sensor": None},
    ],
)
def test_state_is_dropped_when_anything_else_changes(other: dict[str, Any]) -> None:
    with begun(host("Counting", parameters={"offset": 20})) as it:
        assert [first_label(it), first_label(it)] == [195, 196]
        it.configure(**other)
        assert [first_label(it), first_label(it)] == [195, 196]
        it.configure()
        assert first_label(it) == 197
        # Larger memory after other parameters: these stay.
        it.configure(parameters={}, sensor_height_m=2.0)
        assert [first_label(it), first_label(it, 300_000)] == [202, 203]
        assert it.quit() == 0


def test_parameters_that_are_absent_have_their_defaults_again() -> None:
    with begun(host("squares", parameters={"side_m": 20.0, "min_z_m": -5.0})) as it:
        coarse = it.scan(columns_of(points())).n_detections
        it.configure(parameters={"min_z_m": -5.0})
        assert coarse == 4 and it.scan(columns_of(points())).n_detections > 200


@pytest.mark.parametrize(
    ("other", "text"),
    [
        ({"parameters": {"side": 3}}, "unknown parameter 'side'"),
        ({"parameters": {"side_m": "3"}}, "parameter 'side_m' is float"),
        ({"shared_memory": "/nowhere"}, "FileNotFoundError"),
    ],
)
def test_after_an_error_to_a_later_configure_another_is_waited_for(other: dict[str, Any], text: str) -> None:
    with begun(host("squares")) as it:
        n_detections = it.scan(columns_of(points())).n_detections
        with pytest.raises(ReportedFailure, match=re.escape(text)):
            it.configure(**other)
        with pytest.raises(ReportedFailure, match="a scan before `configure`"):
            it.scan(columns_of(points()))
        it.fields.clear()
        it.configure()
        assert it.scan(columns_of(points())).n_detections == n_detections
        with pytest.raises(ReportedFailure):
            it.configure(**other)
        assert it.quit() == 0


def test_a_function_without_a_decorator_is_a_detector() -> None:
    with host("plain") as it:
        assert it.hello()["name"] == "plain"
        it.configure()
        assert it.scan(columns_of(points())).n_detections == 1


def test_unknown_fields_are_ignored() -> None:
    with host("squares") as it:
        it.hello()
        it.configure(colour="green")
        assert it.scan(columns_of(points())).n_detections > 10


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({"side": 1}, "unknown parameter 'side'; takes has how_many, what, really, ratio"),
        ({"how_many": 1.5}, "parameter 'how_many' is int, not 1.5"),
        ({"how_many": True}, "parameter 'how_many' is int, not True"),
        ({"really": 1}, "parameter 'really' is bool, not 1"),
        ({"what": 3}, "parameter 'what' is str, not 3"),
        ({"ratio": "1"}, "parameter 'ratio' is float, not '1'"),
    ],
)
def test_wrong_parameters_are_refused(parameters: dict[str, Any], text: str) -> None:
    with host("takes", parameters=parameters) as it:
        it.hello()
        with pytest.raises(ReportedFailure, match=re.escape(text)):
            it.configure()


def test_numbers_are_taken_as_the_annotation_says() -> None:
    with begun(host("takes", parameters={"how_many": 2.0, "ratio": 3})) as it:
        answer = it.scan(columns_of(points(5)))
        assert answer.ids is not None and answer.ids.tolist() == [3] * 5


@pytest.mark.parametrize(
    ("how", "text"),
    [
        ("raises", "RuntimeError: no more\nmemory"),
        ("exits", "SystemExit: 3"),
        ("none", "the detector returned None"),
        ("floats", "labels are float64, not integers"),
        ("short", "labels are of shape (999,) for 1000 points"),
        ("rows", "labels are of shape (1000, 1) for 1000 points"),
        ("huge label", "label 4294967295 is too large"),
        ("nan box", "box 0 has NaN or infinity"),
        ("flat box", "box 0 has a side not above 0"),
        ("long box", "box 0 has a side not above 0 and at most 1000 m"),
        ("far box", "box 0 is more than 10000 m from the sensor"),
        ("six numbers", "boxes are an array of m x 7"),
        ("nan score", "score 0 is not a finite number"),
        ("two scores", "scores are of shape (2,) for 1 detections"),
        ("class", "TypeError: the class 7 is no name"),
        ("too few boxes", "1 boxes for clusters up to number 1000"),
        ("product", "product 'x' has values beyond 0 to 255"),
        ("many boxes", "100001 boxes, more than 100000"),
        ("many products", "33 products, more than 32"),
        ("name of a stage", "'a\\nb' is no name of a stage or product"),
        ("name of a product", "'' is no name of a stage or product"),
        ("long line", "bytes long, more than 1 MiB"),
    ],
)
def test_what_is_wrong_is_reported_and_the_next_scan_is_answered(how: str, text: str) -> None:
    with begun(host("wrong", parameters={"how": how})) as it:
        for _ in range(2):
            with pytest.raises(ReportedFailure, match=re.escape(text)):
                it.scan(columns_of(points()))
        assert it.quit() == 0


def test_labels_below_zero_where_zero_is_none() -> None:
    with begun(host("below_zero")) as it, pytest.raises(ReportedFailure, match="label -1 is below 0"):
        it.scan(columns_of(points()))


def test_a_traceback_is_printed_beside() -> None:
    with begun(host("wrong", parameters={"how": "raises"})) as it:
        with pytest.raises(ReportedFailure):
            it.scan(columns_of(points()))
        assert "memory" in it.last_words()


def test_what_a_detector_prints_disturbs_nothing() -> None:
    with begun(host("wrong", parameters={"how": "prints"})) as it:
        for _ in range(3):
            assert it.scan(columns_of(points())).n_detections == 1
        assert it.quit() == 0
        assert '{"message":"result"' in it.last_words() and "and to stderr" in it.last_words()


def test_silence_is_noticed() -> None:
    with begun(host("wrong", parameters={"how": "silent"}, limits=SHORT)) as it:
        with pytest.raises(Silence, match="nothing within the time limit"):
            it.scan(columns_of(points()))
        with pytest.raises(Silence, match="still runs"):
            it.quit()


def test_a_crash_is_noticed_with_the_last_words() -> None:
    with begun(host("wrong", parameters={"how": "crashes"})) as it:
        with pytest.raises(DetectorFailure, match="closed the pipe; its last lines: about to crash"):
            it.scan(columns_of(points()))


def test_a_closed_pipe_is_noticed() -> None:
    with begun(host("wrong", parameters={"how": "closes"})) as it:
        with pytest.raises(DetectorFailure, match="closed the pipe"):
            it.scan(columns_of(points()))


@pytest.mark.parametrize(
    ("target", "text"),
    [
        ("nowhere:detect", "ModuleNotFoundError: No module named 'nowhere'"),
        ("detectors:nothing", "has no attribute 'nothing'"),
        ("detectors", "is not of the form module:function"),
        ("detectors:SHORT_OF_A_FUNCTION", "has no attribute"),
        ("detectors:np.pi", "is neither a function nor a detector, but float"),
        ("detectors:time.time", "no signature found"),
        ("missing.py:detect", "FileNotFoundError"),
    ],
)
def test_a_detector_that_cannot_be_loaded_says_so(target: str, text: str) -> None:
    start = [sys.executable, "-m", "scanbench.serve", target]
    with Host(start, directory=HERE, environment=SOURCES) as it:
        with pytest.raises(ReportedFailure, match=re.escape(text)):
            it.hello()
        assert it._wait() == 1


def test_it_ends_at_once_although_something_clings(tmp_path: Path) -> None:
    (tmp_path / "clings.py").write_text(
        "import atexit, time, numpy as np\n"
        "class Clings:\n"
        "    def __del__(self): time.sleep(60)\n"
        "clings = Clings()\n"
        "atexit.register(lambda: open('left', 'w').close())\n"
        "def detect(points): return np.zeros(len(points), int)\n"
    )
    start = [sys.executable, "-m", "scanbench.serve", "clings.py:detect"]
    with begun(Host(start, directory=tmp_path, environment=SOURCES)) as it:
        assert it.quit() == 0
    assert (tmp_path / "left").exists()


def test_another_protocol_is_refused() -> None:
    with host("squares") as it:
        with pytest.raises(ReportedFailure, match="protocol 3 is not known"):
            it.hello(protocol=3)
        assert it._wait() == 1


def test_a_scan_before_configure_and_an_unknown_message_are_errors() -> None:
    with host("squares") as it:
        it.hello()
        with pytest.raises(ReportedFailure, match="a scan before `configure`"):
            it.memory_path = None
            it.send({"message": "scan", "number": 1, "n_points": 0, "columns": []})
            it._line("result", time.monotonic() + 10)
        it.send({"message": "dance"})
        with pytest.raises(ReportedFailure, match="unknown message 'dance'"):
            it._line("result", time.monotonic() + 10)


@pytest.mark.parametrize("line", [b"hello\n", b"[1]\n", b'{"massage":"hello"}\n', b'{"message":1}\n', b"\xff\n"])
def test_a_line_that_is_no_message_is_an_error_and_the_end(line: bytes) -> None:
    with host("squares") as it:
        it.send_bytes(line)
        with pytest.raises(ReportedFailure, match="a line is not"):
            it._line("hello", time.monotonic() + 10)
        assert it._wait() == 1


def test_the_end_of_the_pipe_is_the_end() -> None:
    with begun(host("squares")) as it:
        it.scan(columns_of(points()))
        assert it.close_pipe() == 0
    with host("squares") as it:
        it.hello()
        os.write(it.write_fd, b'{"message":"con')
        assert it.close_pipe() == 1


def test_a_host_that_is_gone_is_the_end() -> None:
    with begun(host("wrong", parameters={"how": "prints"})) as it:
        os.close(it.read_fd)
        it.read_fd, other = os.pipe()
        os.set_blocking(it.read_fd, False)
        os.close(other)
        os.write(it.write_fd, b'{"message":"dance"}\n')
        assert it._wait() == 0


def test_a_detector_that_is_started_by_hand_says_what_to_do() -> None:
    environment = {name: value for name, value in os.environ.items() if not name.startswith("SCANBENCH")}
    for arguments in [command("squares"), [sys.executable, "detectors.py"]]:
        found = subprocess.run(
            arguments, cwd=HERE, env={**environment, **SOURCES}, capture_output=True, text=True, timeout=30, check=False
        )
        assert found.returncode == 2 and "scanbench starts it" in found.stderr


def test_one_that_cannot_be_started() -> None:
    with pytest.raises(DetectorFailure, match="cannot be started"):
        Host(["/no/such/program"]).__enter__()


def test_the_client_of_the_documentation_works(tmp_path: Path) -> None:
    block = PROTOCOL.read_text().split("<!-- a test runs this block -->\n```python\n")[1].split("```")[0]
    assert len(block.splitlines()) <= 40
    (tmp_path / "squares.py").write_text(block)
    with begun(Host([sys.executable, "squares.py"], {"side_m": 4.0}, directory=tmp_path)) as it:
        for number in range(2):
            answer = it.scan(columns_of(points()), number)
            assert answer.ids is not None and 50 < answer.n_detections <= 100 and (answer.ids == 0).any()
        it.configure(parameters={"side_m": 8.0})
        assert 16 < it.scan(columns_of(points())).n_detections <= 36
        assert it.quit() == 0


FRAMES = [
    (r'{"message":"result","number":0}\n', None),
    (
        r'{"message":"result","number":0,"n_boxes":1,"payload_bytes":28}\n'
        + "\0" * 12
        + r"\x00\x00\x80\x3f" * 3
        + "\0" * 4,
        None,
    ),
    (r'{"message":"result","number":1}\n', "answers scan 1 instead of 0"),
    (r'{"message":"result"}\n', "answers scan None"),
    (r'{"message":"configured"}\n', "answered 'configured' instead of 'result'"),
    (r'{"message":"surprise"}\n', "answered 'surprise'"),
    (r'{"message":"result","number":0,"clusters":true,"payload_bytes":36}\n', "payload_bytes is 36, has to be 40"),
    (r'{"message":"result","number":0,"clusters":true,"payload_bytes":4000000000}\n', "has to be 40"),
    (r'{"message":"result","number":0,"clusters":1,"payload_bytes":40}\n', "`clusters` is 1"),
    (r'{"message":"result","number":0,"n_boxes":-1}\n', "`n_boxes` is -1"),
    (r'{"message":"result","number":0,"n_boxes":NaN}\n', "not a line of JSON"),
    (r'{"message":"result","number":0,"n_boxes":9000000000}\n', "9000000000 boxes"),
    (r'{"message":"result","number":0,"n_boxes":1,"payload_bytes":28}\n' + "\0" * 28, "absurd size"),
    (r'{"message":"result","number":0,"n_boxes":1,"payload_bytes":28}\n' + r"\x00\x00\xc0\x7f" * 7, "NaN"),
    (r'{"message":"result","number":0,"clusters":true,"payload_bytes":40}\nhalf', "4 of 40 bytes of payload"),
    (
        r'{"message":"result","number":0,"clusters":true,"n_boxes":2,"payload_bytes":96}\n' + "\0" * 96,
        "the largest id is 0",
    ),
    (r'{"message":"result","number":0,"classes":["car"]}\n', "`classes` is not a list of 0"),
    (r'{"message":"result","number":0,"products":[{"name":"a","kind":"mesh","type":"u8"}]}\n', "unknown product"),
    (r'{"message":"result","number":0,"stages":[{"name":"a","ms":"1"}]}\n', "not a stage"),
    (r'{"message":"res', "half a line"),
    ("A" * 2**20 + r"\n", "a line longer than 1 MiB"),
    (r"\xff\n", "not a line of JSON"),
]


@pytest.mark.parametrize(("frame", "text"), FRAMES, ids=range(len(FRAMES)))
def test_the_host_refuses_what_is_not_the_protocol(frame: str, text: str | None, tmp_path: Path) -> None:
    (tmp_path / "frame").write_bytes(frame.encode("latin1").decode("unicode_escape").encode("latin1"))
    (tmp_path / "client.py").write_text(
        "import os\nread, write = int(os.environ['SCANBENCH_READ_FD']), int(os.environ['SCANBENCH_WRITE_FD'])\n"
        """for answer in [b'{"message":"hello","protocol":1,"name":"x"}\\n', b'{"message":"configured"}\\n']:\n"""
        "    os.read(read, 10000)\n    os.write(write, answer)\n"
        "os.read(read, 10000)\nos.write(write, open('frame', 'rb').read())\nos.read(read, 10000)\n"
    )
    with begun(Host([sys.executable, "client.py"], limits=SHORT, directory=tmp_path)) as it:
        if text is None:
            it.scan(columns_of(points(10)))
            return
        with pytest.raises(DetectorFailure, match=re.escape(text)):
            it.scan(columns_of(points(10)))


def test_too_much_is_noticed_before_the_next_scan(tmp_path: Path) -> None:
    (tmp_path / "client.py").write_text(
        "import os\nread, write = int(os.environ['SCANBENCH_READ_FD']), int(os.environ['SCANBENCH_WRITE_FD'])\n"
        "os.read(read, 10000)\n"
        """os.write(write, b'{"message":"hello","protocol":1,"name":"x"}\\nand more')\nos.read(read, 10000)\n"""
    )
    with Host([sys.executable, "client.py"], directory=tmp_path) as it:
        it.hello()
        with pytest.raises(DetectorFailure, match="8 bytes that nobody asked for"):
            it.configure()


def test_the_function_of_the_readme_works(tmp_path: Path) -> None:
    block = (HERE.parent / "README.md").read_text().split("```python\n")[1].split("\nrun = ")[0]
    (tmp_path / "readme.py").write_text(block)
    start = [sys.executable, "-m", "scanbench.serve", "readme.py:squares"]
    with begun(Host(start, {"side_m": 4}, directory=tmp_path, environment=SOURCES)) as it:
        answer = it.scan(columns_of(points()))
        assert answer.ids is not None and 50 < answer.n_detections <= 100 and (answer.ids == 0).any()
