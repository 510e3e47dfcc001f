"""The detector's side of the protocol."""

from __future__ import annotations

import atexit
import contextlib
import mmap
import os
import sys
import traceback
from collections.abc import Callable
from typing import Any, NoReturn

import numpy as np

from scanbench.cloud import Cloud
from scanbench.detections import Detections
from scanbench.detector import Configuration, Detector
from scanbench.pipe import Pipe, ProtocolError
from scanbench.result import encode_result
from scanbench.stage import take_times_ms

PROTOCOLS = (1, 2)
COLUMN_TYPES = {"x_m": "<f4", "y_m": "<f4", "z_m": "<f4", "intensity": "<f4", "ring": "<u2", "time_offset_s": "<f4"}

WRONGLY_STARTED = """This is a detector: scanbench starts it. Name it in scanbench.toml,

    [detector.{name}]
    command = ["python3", …]

and run: scanbench run -d {name}"""


def pipe_of_environment() -> Pipe | None:
    """The pipe to the program, or None if it did not start this process."""
    try:
        return Pipe(int(os.environ["SCANBENCH_READ_FD"]), int(os.environ["SCANBENCH_WRITE_FD"]))
    except (KeyError, ValueError, OSError):
        return None


def serve(detector: Detector) -> int:
    """Answers until the program says *quit* or is gone; returns the exit code."""
    pipe = pipe_of_environment()
    if pipe is None:
        print(WRONGLY_STARTED.format(name=detector.name), file=sys.stderr)
        return 2
    return serve_pipe(detector, pipe)


def serve_pipe(detector: Detector, pipe: Pipe) -> int:
    """As `serve`, over this pipe."""
    session = Session(detector)
    try:
        while (message := pipe.read()) is not None and message["message"] != "quit":
            fields, payload = session.answer(message)
            _send(pipe, fields, payload)
            if session.ended:
                return 1
    except BrokenPipeError:
        return 0
    except KeyboardInterrupt:
        return 130
    except ProtocolError as error:
        _send(pipe, {"message": "error", "text": str(error)}, [])
        return 1
    return 0


def leave(exit_code: int) -> NoReturn:
    """Ends the process without taking apart what is loaded, which may take longer than the two seconds that are allowed."""
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
    os._exit(exit_code)


def refuse(pipe: Pipe, text: str) -> int:
    """Answers the first message by an error; returns the exit code."""
    if pipe.read() is not None:
        _send(pipe, {"message": "error", "text": text}, [])
    return 1


def last_line(error: BaseException) -> str:
    """What a traceback ends with."""
    return traceback.format_exception_only(error)[-1].strip()


def _send(pipe: Pipe, fields: dict[str, Any], payload: list[bytes]) -> None:
    try:
        pipe.write(fields, payload)
    except (ProtocolError, ValueError) as error:
        pipe.write({"message": "error", "text": last_line(error)})


def _mapped(path: str) -> mmap.mmap | None:
    with open(path, "rb") as file:
        size = os.fstat(file.fileno()).st_size
        return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) if size else None


class Session:
    """What outlives a message."""

    def __init__(self, detector: Detector) -> None:
        self.detector = detector
        self.detect: Callable[[Cloud], Detections] | None = None
        self.configuration: Configuration | None = None
        self.memory: mmap.mmap | None = None
        self.protocol = PROTOCOLS[0]
        self.ended = False

    def answer(self, message: dict[str, Any]) -> tuple[dict[str, Any], list[bytes]]:
        """The answer to a message, which is an error if anything failed."""
        try:
            match message["message"]:
                case "hello":
                    return self._hello(message), []
                case "configure":
                    return self._configure(message), []
                case "scan":
                    return self._scan(message)
                case unknown:
                    raise ProtocolError(f"unknown message {unknown!r}")
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # Whatever the detector raises, SystemExit too, is reported and not fatal.
            traceback.print_exc()
            return {"message": "error", "text": last_line(error)}, []

    def _hello(self, message: dict[str, Any]) -> dict[str, Any]:
        spoken = set(message.get("protocols", [message.get("protocol")])) & set(PROTOCOLS)
        if not spoken:
            self.ended = True
            raise ProtocolError(f"protocol {message.get('protocol')} is not known, only {PROTOCOLS}")
        self.protocol = max(spoken)
        answer = {"message": "hello", "protocol": self.protocol, "name": self.detector.name}
        return {**answer, "version": self.detector.version} if self.detector.version else answer

    def _configure(self, message: dict[str, Any]) -> dict[str, Any]:
        # Nothing that was configured before counts: if anything fails now, nothing is configured.
        detect, last = self.detect, self.configuration
        self.detect = self.configuration = None
        # The old map goes when the last array of it does.
        self.memory = _mapped(message["shared_memory"])
        configuration = Configuration(
            dataset=message["dataset"],
            sensor=message.get("sensor"),
            sensor_height_m=message.get("sensor_height_m"),
            threads=message.get("threads", 1),
            parameters=message.get("parameters", {}),
        )
        wishes = self.detector.wishes(configuration)
        if wishes and self.protocol < 2:
            raise ProtocolError(f"{self.detector.name} wants {', '.join(wishes)}, which this scanbench does not know")
        if detect is None or configuration != last:
            # What the last one holds, a model say, is free before the next one is made.
            detect = None
            detect = self.detector.configured(configuration)
        # Else it is for larger memory alone: the detector keeps its state.
        self.detect, self.configuration = detect, configuration
        return {"message": "configured", **wishes}

    def _scan(self, message: dict[str, Any]) -> tuple[dict[str, Any], list[bytes]]:
        if self.detect is None:
            raise ProtocolError("a scan before `configure`")
        cloud = self._cloud(message)
        take_times_ms()
        fields, payload = encode_result(self.detect(cloud), len(cloud), self.detector.noise, self.protocol)
        fields["stages"] = [{"name": name, "ms": round(ms, 4)} for name, ms in take_times_ms().items()]
        return {"message": "result", "number": cloud.number, **fields}, payload

    def _cloud(self, message: dict[str, Any]) -> Cloud:
        number, pose = message["number"], message.get("world_from_sensor")
        others: dict[str, Any] = {}
        if self.protocol > 1:
            others["begins_drive"] = message.get("begins_drive", False)
            others["world_from_sensor"] = None if pose is None else np.vstack([np.reshape(pose, (3, 4)), [0, 0, 0, 1]])
            earlier = (
                Cloud(number, it["name"], it["time_s"], **self._columns(it)) for it in message.get("earlier", [])
            )
            others["earlier"] = tuple(earlier)
        return Cloud(number, message.get("name", ""), message.get("time_s", 0.0), **self._columns(message), **others)

    def _columns(self, message: dict[str, Any]) -> dict[str, Any]:
        n_points = message["n_points"]
        columns: dict[str, Any] = {}
        for column in message["columns"]:
            if (dtype := COLUMN_TYPES.get(column["name"])) is not None:
                if n_points == 0 or self.memory is None:
                    columns[column["name"]] = np.empty(n_points, dtype)
                else:
                    columns[column["name"]] = np.frombuffer(self.memory, dtype, n_points, column["offset"])
        return columns
