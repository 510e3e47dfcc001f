"""Messages between the program and a detector: a line of JSON and a payload."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any

MAX_LINE_BYTES = 2**20


class ProtocolError(Exception):
    """The other side does not keep to the protocol."""


class Pipe:
    """The pair of pipes whose numbers are in the environment."""

    def __init__(self, read_fd: int, write_fd: int) -> None:
        for descriptor in (read_fd, write_fd):
            os.set_inheritable(descriptor, False)
        self._reading = os.fdopen(read_fd, "rb")
        self._write_fd = write_fd

    def read(self) -> dict[str, Any] | None:
        """The next message, or None at the end of the file; payloads of messages to a detector have no meaning yet."""
        line = self._reading.readline(MAX_LINE_BYTES)
        if not line:
            return None
        if not line.endswith(b"\n"):
            raise ProtocolError("a line is longer than 1 MiB, or cut off")
        try:
            message = json.loads(line)
        except ValueError as error:
            raise ProtocolError(f"a line is not JSON: {error}") from error
        if not isinstance(message, dict) or not isinstance(message.get("message"), str):
            raise ProtocolError("a line is not a JSON object with `message`")
        self._reading.read(message.get("payload_bytes", 0))
        return message

    def write(self, fields: dict[str, Any], payload: Sequence[bytes] = ()) -> None:
        """Sends a message; raises ProtocolError, with nothing sent, if its line is too long."""
        n_bytes = sum(map(len, payload))
        if n_bytes:
            fields = {**fields, "payload_bytes": n_bytes}
        line = json.dumps(fields, allow_nan=False, separators=(",", ":")).encode() + b"\n"
        if len(line) > MAX_LINE_BYTES:
            raise ProtocolError(f"the line of `{fields['message']}` is {len(line)} bytes long, more than 1 MiB")
        rest = memoryview(b"".join([line, *payload]))
        while rest:
            rest = rest[os.write(self._write_fd, rest) :]
