"""The C++ header against a host that checks every byte; what it is compiled with finds undefined behaviour and leaks."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from reference_host import Host, ReportedFailure, columns_of
from test_protocol import look_back

CPP = Path(__file__).parents[2] / "cpp"
COMPILER = shutil.which(os.environ.get("CXX", "c++"))
FLAGS = "-std=c++17 -O1 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror -fsanitize=address,undefined".split()

pytestmark = pytest.mark.skipif(COMPILER is None, reason="there is no C++ compiler")


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> str:
    program = str(tmp_path_factory.mktemp("cpp") / "drawn")
    assert COMPILER
    subprocess.run([COMPILER, *FLAGS, f"-I{CPP}", str(CPP / "tests/drawn.cpp"), "-o", program], check=True)
    return program


@contextmanager
def begun(program: str, **parameters: Any) -> Iterator[Host]:
    with Host([program], parameters, max_points=500) as it:
        assert it.hello()["name"] == "drawn"
        it.configure()
        yield it


def points(n: int = 1000) -> Any:
    return (np.random.default_rng(1).random((n, 4)) * 40 - 20).astype(np.float32)


def test_clusters_of_scans_that_grow(drawn: str) -> None:
    with begun(drawn) as it:
        for n in [10, 500, 0, 2000, 3]:
            cloud = points(n)
            answer = it.scan(columns_of(cloud), n)
            assert answer.ids is not None and np.array_equal(answer.ids, np.where(cloud[:, 0] > 0, 4, 9))
        assert it.quit() == 0


def test_columns_by_name(drawn: str) -> None:
    columns = columns_of(points(100))
    del columns["intensity"]
    with begun(drawn) as it:
        answer = it.scan(columns)
        assert answer.ids is not None and set(answer.ids.tolist()) == {0, 4} and answer.n_detections == 1
        answer = it.scan({**columns, "ring": np.arange(100, dtype=np.uint16)})
        assert answer.ids is not None and np.array_equal(answer.ids, np.arange(100)) and answer.n_detections == 99


def test_boxes_and_state(drawn: str) -> None:
    with begun(drawn, how="boxes", shift_m=2, n_scans=40) as it:
        for number, n in enumerate([10, 2000]):
            answer = it.scan(columns_of(points(n)))
            assert np.allclose(answer.boxes, [[41 + number, 3.73, -1, 4, 2, 1.5, 0.5]] * 2) and answer.ids is None
            assert (
                answer.scores is not None and answer.scores.tolist() == [0.25, -1] and answer.classes == ["car", None]
            )


def test_what_changes_the_state_and_what_does_not(drawn: str) -> None:
    def n_scans(n: int = 10) -> tuple[float, ...]:
        return tuple(round(value, 2) for value in it.scan(columns_of(points(n))).boxes[0, :2].tolist())

    others: list[dict[str, Any]] = [{"dataset": "another"}, {"sensor": None}, {"threads": 2}]

    with begun(drawn, how="boxes", n_scans=40) as it:
        assert [n_scans(), n_scans(2000)] == [(41, 1.73), (42, 1.73)]
        it.configure()
        it.configure(parameters={"n_scans": 40, "how": "boxes"})
        assert n_scans() == (43, 1.73)
        it.configure(parameters={"how": "boxes", "shift_m": 1})
        assert [n_scans(), n_scans(5000)] == [(1, 2.73), (2, 2.73)]
        for other in others:
            it.configure(**other)
            assert [n_scans(), n_scans()] == [(1, 2.73), (2, 2.73)]
        it.configure(sensor_height_m=None)
        assert [n_scans(), n_scans()] == [(1, 1), (2, 1)]


def test_after_an_error_to_a_later_configure_another_is_waited_for(drawn: str) -> None:
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"shared_memory": "/nowhere"}, "cannot open /nowhere"),
        ({"parameters": {"shift": 1}}, "unknown parameter `shift`"),
    ]
    with begun(drawn) as it:
        for other, text in wrong:
            with pytest.raises(ReportedFailure, match=text):
                it.configure(**other)
            with pytest.raises(ReportedFailure, match="a scan before `configure`"):
                it.scan(columns_of(points(5)))
            it.fields.clear()
            it.configure()
            assert it.scan(columns_of(points(5))).n_detections >= 1
        with pytest.raises(ReportedFailure):
            it.configure(parameters={"shift": 1})
        assert it.quit() == 0


def test_it_looks_back(drawn: str) -> None:
    with Host([drawn], {"how": "back", "n_back": 2}, max_points=100) as it:
        look_back(it)
    with Host([drawn], {"how": "back"}) as it:
        assert it.hello()["protocol"] == 1
        with pytest.raises(ReportedFailure, match="looks back at its drive, which this scanbench does not know"):
            it.configure()


def test_both_and_everything(drawn: str) -> None:
    with begun(drawn, how="both") as it:
        assert it.scan(columns_of(points())).n_detections == 9
    with begun(drawn, how="everything") as it:
        answer = it.scan(columns_of(points()))
        assert answer.n_detections == 2 and answer.classes == [None, "tram"]
        assert answer.stages == [('a "stage" é', 1.25), ("late", 999999999.0)]
        assert set(answer.products["ground"].tolist()) == {7}


@pytest.mark.parametrize(
    ("how", "text"),
    [
        ("short", "999 cluster ids for 1000 points"),
        ("nan", "box 3 is not finite"),
        ("scores", "1 scores for 2 detections"),
        ("speed", "a velocity is known along one axis alone, or above 1000 m/s"),
        ("tracks", "1 tracks for 2 detections"),
        ("product", "product `ground` has another length"),
        ("products", "33 products, more than 32"),
        ("name", "`a\n` is no name of a stage or product"),
        ("throws", 'out of "tea"\n\tand müsli'),
    ],
)
def test_what_is_wrong_is_reported_and_the_next_scan_is_answered(drawn: str, how: str, text: str) -> None:
    with begun(drawn, how=how) as it:
        for _ in range(2):
            with pytest.raises(ReportedFailure, match=re.escape(text)):
                it.scan(columns_of(points()))
        assert it.quit() == 0


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({"shift": 1}, "unknown parameter `shift`; there are how n_back n_scans really shift_m"),
        ({"n_scans": 1.5}, "parameter `n_scans` is not an integer"),
        ({"shift_m": "1"}, "parameter `shift_m` is not a number"),
        ({"really": 1}, "parameter `really` is not true or false"),
        ({"how": ["a"]}, "parameter `how` is not text"),
    ],
)
def test_wrong_parameters_are_refused(drawn: str, parameters: dict[str, Any], text: str) -> None:
    with Host([drawn], parameters) as it:
        it.hello()
        with pytest.raises(ReportedFailure, match=re.escape(text)):
            it.configure()


def test_text_comes_through_as_it_is(drawn: str) -> None:
    # What Python writes has \u escapes; none of these is a way that there is, so that clusters alone are answered.
    with begun(drawn, how='"\\\n\x01é€𝄞') as it:
        assert it.scan(columns_of(points())).n_detections == 2


@pytest.mark.parametrize(
    "line",
    [
        b"hello\n",
        b"[1]\n",
        b"{}\n",
        b'{"message":1}\n',
        b'{"message":"hello",}\n',
        b'{"message":"hello"\n',
        b'{"message":"hel\n',
        b'{"message":"\\ud800"}\n',
        b'{"message":"hello","a":+-1e}\n',
        b'{"a":' + b"[" * 5000 + b"\n",
        b'{"message":"hello"} x\n',
        b'{"message":"hello","payload_bytes":-1}\n',
    ],
)
def test_a_line_that_is_no_message_is_an_error_and_the_end(drawn: str, line: bytes) -> None:
    with Host([drawn]) as it:
        it.send_bytes(line)
        with pytest.raises(ReportedFailure):
            it._line("hello", time.monotonic() + 10)
        assert it._wait() == 1


def test_another_protocol_an_unknown_message_and_a_column_beyond_the_memory(drawn: str) -> None:
    with Host([drawn]) as it:
        with pytest.raises(ReportedFailure, match="protocol 3 is not known"):
            it.hello(protocol=3)
        assert it._wait() == 1
    with begun(drawn) as it:
        it.send({"message": "dance"})
        with pytest.raises(ReportedFailure, match='unknown message "dance"'):
            it._line("result", time.monotonic() + 10)
        for offset in [2**40, 3]:
            column = {"name": "x_m", "type": "f32", "offset": offset}
            it.send({"message": "scan", "number": 1, "n_points": 1, "columns": [column]})
            with pytest.raises(ReportedFailure, match="a column lies beyond the shared memory"):
                it._line("result", time.monotonic() + 10)


def test_the_end_of_the_pipe_and_a_host_that_is_gone(drawn: str) -> None:
    with begun(drawn) as it:
        assert it.close_pipe() == 0
    with begun(drawn) as it:
        os.close(it.read_fd)
        it.read_fd, other = os.pipe()
        os.close(other)
        os.write(it.write_fd, b'{"message":"dance"}\n')
        assert it._wait() == 0


def test_started_by_hand_it_says_what_to_do(drawn: str) -> None:
    found = subprocess.run([drawn], capture_output=True, text=True, check=False)
    assert found.returncode == 2 and "scanbench starts it" in found.stderr
