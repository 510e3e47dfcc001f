"""The host's side of the protocol (docs/protocol.md), which checks every byte of the answers.

    python reference_host.py --scan 000000.bin [--repeats 3] [-P eps=0.7] [--table] -- command …

prints what the detector answers, and in how many milliseconds; exit code 6 if it fails.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAX_LINE_BYTES = 2**20
MAX_BOXES = 100_000
MAX_PRODUCTS = 32
MAX_NAME_BYTES = 60
MAX_STAGE_MS = 1e9
MAX_SIZE_M = 1000.0
MAX_CENTER_M = 10_000.0
CONTROL = re.compile("[\x00-\x1f\x7f-\x9f]")
COLUMN_TYPES = {"x_m": "f32", "y_m": "f32", "z_m": "f32", "intensity": "f32", "ring": "u16", "time_offset_s": "f32"}
BYTES_OF_TYPE = {"f32": 4, "u16": 2}
BYTES_OF_EACH = {"scores": 4, "velocities": 8, "tracks": 4}


class DetectorFailure(Exception):
    """What the detector did wrong."""


class ReportedFailure(DetectorFailure):
    """It answered `error`, and can go on."""


class Silence(DetectorFailure):
    """A time limit has passed."""


@dataclass
class Limits:
    start_s: float = 30.0
    first_scan_s: float = 60.0
    scan_s: float = 10.0
    quit_s: float = 2.0


@dataclass
class Answer:
    number: int
    n_detections: int
    ids: NDArray[np.uint32] | None
    boxes: NDArray[np.float32]
    scores: NDArray[np.float32] | None
    classes: list[str | None]
    stages: list[tuple[str, float]]
    products: dict[str, NDArray[np.uint8]]
    velocities: NDArray[np.float32] | None = None
    tracks: NDArray[np.uint32] | None = None
    ms: float = 0.0
    cpu_ms: float = 0.0


Columns = dict[str, NDArray[Any]]


@dataclass
class Host:
    command: Sequence[str]
    parameters: dict[str, Any] = field(default_factory=dict)
    limits: Limits = field(default_factory=Limits)
    max_points: int = 200_000
    threads: int = 1
    directory: Path | None = None
    environment: dict[str, str] = field(default_factory=dict)
    fields: dict[str, Any] = field(default_factory=dict)

    def __enter__(self) -> Host:
        self._start()
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def _start(self) -> None:
        self.n_answers = 0
        self.buffered = bytearray()
        self.memory_path: Path | None = None
        self.output = tempfile.TemporaryFile()
        their_read, self.write_fd = os.pipe()
        self.read_fd, their_write = os.pipe()
        threads = {name: str(self.threads) for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
        fds = {"SCANBENCH_PROTOCOL": "1", "SCANBENCH_READ_FD": str(their_read), "SCANBENCH_WRITE_FD": str(their_write)}
        self.start_s = time.monotonic()
        try:
            self.process = subprocess.Popen(
                list(self.command),
                stdin=subprocess.DEVNULL,
                stdout=self.output,
                stderr=self.output,
                pass_fds=(their_read, their_write),
                env={**threads, **os.environ, **self.environment, **fds},
                cwd=self.directory,
                start_new_session=True,
            )
        except OSError as error:
            for descriptor in (self.write_fd, self.read_fd):
                os.close(descriptor)
            raise DetectorFailure(f"cannot be started: {error}") from error
        finally:
            os.close(their_read)
            os.close(their_write)
        os.set_blocking(self.read_fd, False)

    # What is sent.

    def send(self, fields: dict[str, Any]) -> None:
        self.send_bytes(json.dumps(fields, allow_nan=False).encode() + b"\n")

    def send_bytes(self, data: bytes) -> None:
        unasked = self._available()
        if unasked:
            raise DetectorFailure(f"{len(unasked)} bytes that nobody asked for: {unasked[:80]!r}")
        try:
            os.write(self.write_fd, data)
        except BrokenPipeError as error:
            raise DetectorFailure(f"it has ended: {self.last_words()}") from error

    def hello(self, protocol: int = 1, protocols: Sequence[int] = ()) -> dict[str, Any]:
        deadline_s = self.start_s + self.limits.start_s
        both = {"protocols": list(protocols)} if protocols else {}
        self.send({"message": "hello", "protocol": protocol, **both, "program": "reference host"})
        answer = self._line("hello", deadline_s)
        self._no_payload(answer)
        if answer.get("protocol") not in (protocols or [1]):
            raise DetectorFailure(f"protocol {answer.get('protocol')!r}")
        if not isinstance(answer.get("name"), str) or not isinstance(answer.get("version", ""), str):
            raise DetectorFailure("`name` or `version` of hello is not a string")
        return answer

    def configure(self, **others: Any) -> None:
        """Sends `configure`, the first or another one. `others` are fields that differ from now on; memory is new each time."""
        self.fields.update(others)
        self._map()
        fields: dict[str, Any] = {
            "message": "configure",
            "dataset": "reference",
            "sensor": "hdl-64e-s2",
            "sensor_height_m": 1.73,
            "parameters": self.parameters,
            "threads": self.threads,
            "max_points": self.max_points,
            "shared_memory": str(self.memory_path),
        }
        self.send({**fields, **self.fields})
        answer = self._line("configured", time.monotonic() + self.limits.start_s)
        self._no_payload(answer)
        self.wishes = (_count(answer, "earlier_scans"), _flag(answer, "in_order"))

    def scan(
        self,
        columns: Columns,
        number: int = 0,
        name: str = "0000/000000",
        earlier: Sequence[Columns] = (),
        **others: Any,
    ) -> Answer:
        """Asks for a scan, with those before it in its frame (version 2), each a tenth of a second before the other."""
        n_points = len(columns["x_m"])
        room = n_points + sum(len(it["x_m"]) + 16 for it in earlier)
        if room > self.max_points:
            self.max_points = room
            self.configure()
        message = {"message": "scan", "number": number, "name": name, "time_s": 0.1 * number, "n_points": n_points}
        message["columns"], *before = self._write([columns, *earlier])
        if earlier:
            message["earlier"] = [
                {"name": f"{name} - {n}", "time_s": 0.1 * (number - n), "n_points": len(it["x_m"]), "columns": written}
                for n, (it, written) in enumerate(zip(earlier, before, strict=True), 1)
            ]
        message.update(others)
        limit_s = self.limits.scan_s if self.n_answers else max(self.limits.first_scan_s, self.limits.scan_s)
        cpu_s = self.cpu_s()
        start_s = time.monotonic()
        self.send(message)
        answer = self._result(number, n_points, start_s + limit_s)
        answer.ms = 1000.0 * (time.monotonic() - start_s)
        answer.cpu_ms = 1000.0 * (self.cpu_s() - cpu_s)
        self.n_answers += 1
        return answer

    def quit(self) -> int:
        self.send({"message": "quit"})
        return self._wait()

    def close_pipe(self) -> int:
        os.close(self.write_fd)
        self.write_fd = -1
        return self._wait()

    def cpu_s(self) -> float:
        """CPU time of all threads of the process, by Linux' clock of it; 0 on other systems."""
        try:
            return time.clock_gettime((~self.process.pid << 3) | 2)
        except OSError:
            return 0.0

    # The shared memory.

    def _map(self) -> None:
        if self.memory_path:
            self.memory_path.unlink()
        folder = "/dev/shm" if os.path.isdir("/dev/shm") else None
        descriptor, path = tempfile.mkstemp(prefix="scanbench-", dir=folder)
        size = sum(-(-self.max_points * BYTES_OF_TYPE[kind] // 64) * 64 for kind in COLUMN_TYPES.values())
        os.ftruncate(descriptor, max(size, 64))
        os.close(descriptor)
        self.memory_path = Path(path)

    def _write(self, scans: Sequence[Columns]) -> list[list[dict[str, Any]]]:
        all_described, offset = [], 0
        assert self.memory_path
        with open(self.memory_path, "r+b") as file:
            for columns in scans:
                described = []
                for name, values in columns.items():
                    kind = COLUMN_TYPES[name]
                    data = np.ascontiguousarray(values, dtype="<f4" if kind == "f32" else "<u2").tobytes()
                    file.seek(offset)
                    file.write(data)
                    described.append({"name": name, "type": kind, "offset": offset})
                    offset += -(-len(data) // 64) * 64
                all_described.append(described)
        return all_described

    # What is answered.

    def _available(self) -> bytes:
        try:
            return bytes(self.buffered) + os.read(self.read_fd, 65536)
        except BlockingIOError:
            return bytes(self.buffered)

    def _read(self, deadline_s: float, what: str) -> None:
        """Adds to `buffered` what comes next."""
        left_s = deadline_s - time.monotonic()
        ready, _, _ = select.select([self.read_fd], [], [], max(left_s, 0.0))
        if not ready:
            raise Silence(f"{what}: nothing within the time limit; {self.last_words()}")
        data = os.read(self.read_fd, MAX_LINE_BYTES)
        if not data:
            raise DetectorFailure(f"{what}: it closed the pipe; {self.last_words()}")
        self.buffered += data

    def _take(self, n_bytes: int) -> bytes:
        data = bytes(self.buffered[:n_bytes])
        del self.buffered[:n_bytes]
        return data

    def _line(self, expected: str, deadline_s: float) -> dict[str, Any]:
        while (end := self.buffered.find(b"\n", 0, MAX_LINE_BYTES)) < 0:
            if len(self.buffered) >= MAX_LINE_BYTES:
                raise DetectorFailure("a line longer than 1 MiB")
            n_bytes = len(self.buffered)
            self._read(deadline_s, f"half a line ({n_bytes} bytes)" if n_bytes else "no answer")
        line = self._take(end + 1)
        try:
            answer = json.loads(line.decode("utf-8"), parse_constant=_refuse_constant)
        except ValueError as error:
            raise DetectorFailure(f"not a line of JSON: {line[:80]!r} ({error})") from error
        if not isinstance(answer, dict) or not isinstance(answer.get("message"), str):
            raise DetectorFailure(f"not an object with `message`: {line[:80]!r}")
        if answer["message"] == "error":
            self._no_payload(answer)
            raise ReportedFailure(answer.get("text", ""))
        if answer["message"] != expected:
            raise DetectorFailure(f"answered {answer['message']!r} instead of {expected!r}")
        return answer

    def _no_payload(self, answer: dict[str, Any]) -> None:
        if _count(answer, "payload_bytes"):
            raise DetectorFailure(f"{answer['message']} with a payload")

    def _result(self, number: int, n_points: int, deadline_s: float) -> Answer:
        line = self._line("result", deadline_s)
        if line.get("number") != number or isinstance(line.get("number"), bool):
            raise DetectorFailure(f"answers scan {line.get('number')!r} instead of {number}")
        clusters = _flag(line, "clusters")
        of_each = [name for name in ("scores", "velocities", "tracks") if _flag(line, name)]
        n_boxes, n_bytes = _count(line, "n_boxes"), _count(line, "payload_bytes")
        if n_boxes > MAX_BOXES:
            raise DetectorFailure(f"{n_boxes} boxes")
        products = [_product_name(product) for product in _list(line, "products")]
        if len(products) > MAX_PRODUCTS:
            raise DetectorFailure(f"{len(products)} products")
        fixed = (4 * n_points if clusters else 0) + 28 * n_boxes + n_points * len(products)
        counted_later = clusters and of_each and not n_boxes
        most = fixed + sum(BYTES_OF_EACH[name] for name in of_each) * (n_points if counted_later else n_boxes)
        if not fixed <= n_bytes <= most or (not counted_later and n_bytes != most):
            raise DetectorFailure(f"payload_bytes is {n_bytes}, has to be {most}")
        payload = self._payload(n_bytes, deadline_s)
        return _decode(line, payload, n_points, clusters, n_boxes, of_each, products)

    def _payload(self, n_bytes: int, deadline_s: float) -> bytes:
        while len(self.buffered) < n_bytes:
            self._read(deadline_s, f"{len(self.buffered)} of {n_bytes} bytes of payload")
        return self._take(n_bytes)

    # How it ends.

    def last_words(self) -> str:
        self.output.seek(0)
        lines = self.output.read().decode(errors="replace").splitlines()
        return "its last lines: " + " | ".join(lines[-5:]) if lines else "it printed nothing"

    def _wait(self) -> int:
        try:
            return self.process.wait(self.limits.quit_s)
        except subprocess.TimeoutExpired:
            raise Silence(f"still runs {self.limits.quit_s} s after quit") from None

    def end(self) -> None:
        """Ends the process and all that it started, and removes the shared memory."""
        try:
            os.killpg(self.process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.process.wait()
        for descriptor in (self.write_fd, self.read_fd):
            if descriptor >= 0:
                os.close(descriptor)
        self.output.close()
        if self.memory_path:
            self.memory_path.unlink()


def _decode(
    line: dict[str, Any],
    payload: bytes,
    n_points: int,
    clusters: bool,
    n_boxes: int,
    of_each: list[str],
    products: list[str],
) -> Answer:
    at = 4 * n_points if clusters else 0
    ids = np.frombuffer(payload, "<u4", n_points) if clusters else None
    boxes = np.frombuffer(payload, "<f4", 7 * n_boxes, at).reshape(n_boxes, 7)
    at += boxes.nbytes
    n_detections = n_boxes
    if ids is not None and n_boxes and int(ids.max(initial=0)) != n_boxes:
        raise DetectorFailure(f"{n_boxes} boxes, the largest id is {int(ids.max(initial=0))}")
    if ids is not None and not n_boxes:
        n_detections = int(np.count_nonzero(np.unique(ids)))
    n_bytes_of_each = sum(BYTES_OF_EACH[name] for name in of_each)
    if len(payload) != at + n_bytes_of_each * n_detections + n_points * len(products):
        raise DetectorFailure(f"payload_bytes is {len(payload)} for {n_detections} detections")
    values: dict[str, Any] = {}
    for name in of_each:
        n_numbers = n_detections * BYTES_OF_EACH[name] // 4
        values[name] = np.frombuffer(payload, "<u4" if name == "tracks" else "<f4", n_numbers, at)
        at += values[name].nbytes
    if not np.isfinite(values.get("scores", [])).all():
        raise DetectorFailure("a score is NaN or infinite")
    velocities = values["velocities"].reshape(-1, 2) if "velocities" in values else None
    _check_boxes(boxes)
    drawn = {}
    for name in products:
        drawn[name] = np.frombuffer(payload, np.uint8, n_points, at)
        at += n_points
    scores, classes = values.get("scores"), _classes(line, n_detections)
    motion = (velocities, values.get("tracks"))
    return Answer(line["number"], n_detections, ids, boxes, scores, classes, _stages(line), drawn, *motion)


def _check_boxes(boxes: NDArray[np.float32]) -> None:
    if not np.isfinite(boxes).all():
        raise DetectorFailure("a box has NaN or infinity")
    if boxes.size and (boxes[:, 3:6].min() <= 0 or boxes[:, 3:6].max() > MAX_SIZE_M):
        raise DetectorFailure("a box has an absurd size")
    if boxes.size and np.linalg.norm(boxes[:, :3].astype(np.float64), axis=1).max() > MAX_CENTER_M:
        raise DetectorFailure("a box is absurdly far off")


def _classes(line: dict[str, Any], n_detections: int) -> list[str | None]:
    classes = line.get("classes")
    if classes is None:
        return [None] * n_detections
    if not isinstance(classes, list) or len(classes) != n_detections:
        raise DetectorFailure(f"`classes` is not a list of {n_detections}")
    for name in classes:
        if name is not None and not isinstance(name, str):
            raise DetectorFailure(f"the class {name!r} is no name")
    return classes


def _stages(line: dict[str, Any]) -> list[tuple[str, float]]:
    stages = []
    for stage in _list(line, "stages"):
        name, ms = (stage.get("name"), stage.get("ms")) if isinstance(stage, dict) else (None, None)
        if not _is_name(name) or isinstance(ms, bool) or not isinstance(ms, int | float) or not 0 <= ms < MAX_STAGE_MS:
            raise DetectorFailure(f"not a stage: {stage!r}")
        stages.append((str(name), float(ms)))
    return stages


def _is_name(name: Any) -> bool:
    """Whether stages and products may be called so."""
    return isinstance(name, str) and 0 < len(name.encode()) <= MAX_NAME_BYTES and not CONTROL.search(name)


def _product_name(product: Any) -> str:
    if not isinstance(product, dict) or product.get("kind") != "point-labels" or product.get("type") != "u8":
        raise DetectorFailure(f"unknown product {product!r}")
    if not _is_name(product.get("name")):
        raise DetectorFailure("a product without a name")
    return str(product["name"])


def _flag(line: dict[str, Any], name: str) -> bool:
    value = line.get(name, False)
    if not isinstance(value, bool):
        raise DetectorFailure(f"`{name}` is {value!r}")
    return value


def _count(line: dict[str, Any], name: str) -> int:
    value = line.get(name, 0)
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise DetectorFailure(f"`{name}` is {value!r}")
    return value


def _list(line: dict[str, Any], name: str) -> list[Any]:
    value = line.get(name, [])
    if not isinstance(value, list):
        raise DetectorFailure(f"`{name}` is {value!r}")
    return value


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is not JSON")


def columns_of(points: NDArray[np.float32]) -> Columns:
    """The columns of n × 4 points."""
    return {name: points[:, index] for index, name in enumerate(["x_m", "y_m", "z_m", "intensity"])}


def read_velodyne(path: Path) -> Columns:
    return columns_of(np.fromfile(path, "<f4").reshape(-1, 4))


def _parameter(text: str) -> tuple[str, Any]:
    name, _, value = text.partition("=")
    try:
        return name, json.loads(value)
    except ValueError:
        return name, value


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scan", type=Path, required=True, action="append", help="a Velodyne .bin file")
    parser.add_argument(
        "--repeats", type=int, default=3, help="how often it is asked for each scan; the shortest time counts"
    )
    parser.add_argument("--limit", type=float, default=120.0, help="seconds allowed for the start and for each scan")
    parser.add_argument("-P", dest="parameters", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--table", metavar="NAME", help="print rows of a Markdown table for the detector NAME")
    parser.add_argument("command", nargs="+")
    given = parser.parse_args()
    limits = Limits(max(30.0, given.limit), given.limit, given.limit)
    try:
        with Host(given.command, dict(map(_parameter, given.parameters)), limits) as host:
            hello = host.hello()
            host.configure()
            for path in given.scan:
                columns = read_velodyne(path)
                answers = [host.scan(columns, number, path.stem) for number in range(given.repeats)]
                _print(hello["name"], path.stem, len(columns["x_m"]), answers, given.table)
            try:
                host.quit()
            except Silence as late:
                print(f"warning: {late}", file=sys.stderr)
    except DetectorFailure as failure:
        print(f"FAILED: {failure}", file=sys.stderr)
        return 6
    return 0


def _print(name: str, scan: str, n_points: int, answers: list[Answer], row_of: str | None) -> None:
    answer = min(answers, key=lambda answer: answer.ms)
    large = 0
    n_in = 0
    if answer.ids is not None:
        counts = np.bincount(np.unique(answer.ids, return_inverse=True)[1].ravel()) if n_points else np.zeros(0, int)
        first = 1 if (answer.ids == 0).any() else 0
        large, n_in = int((counts[first:] >= 20).sum()), int(np.count_nonzero(answer.ids))
    stages = ", ".join(f"{stage} {ms:.1f}" for stage, ms in answer.stages if math.isfinite(ms))
    same = all(_same(answer, other) for other in answers)
    cpu_ms = min(answer.cpu_ms for answer in answers)
    if row_of:
        cells = [row_of, scan, n_points, answer.n_detections, large, n_in, f"{answer.ms:.0f}", f"{cpu_ms:.0f}", stages]
        print("| " + " | ".join(map(str, cells)) + " |")
        return
    print(
        f"{name}, scan {scan}: {n_points} points, {answer.n_detections} detections, {large} of at least 20 points, ",
        end="",
    )
    print(f"{n_in} points in clusters, {answer.ms:.1f} ms ({stages}), {cpu_ms:.0f} ms of CPU", end="")
    print("" if same else ", NOT THE SAME EACH TIME")


def _same(one: Answer, other: Answer) -> bool:
    return np.array_equal(one.boxes, other.boxes) and (
        one.ids is other.ids is None
        or (one.ids is not None and other.ids is not None and np.array_equal(one.ids, other.ids))
    )


if __name__ == "__main__":
    raise SystemExit(main())
