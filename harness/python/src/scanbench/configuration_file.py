"""scanbench.toml, written for detectors that are Python objects."""

from __future__ import annotations

import importlib
import json
import math
import os
import pickle
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scanbench.detector import Detector

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")


def section(detector: Detector, scratch: Path, settings: Mapping[str, Any]) -> str:
    """The section of `detector`, with those `settings` that are not None; what cannot be imported by its name is pickled into `scratch`."""
    if not NAME.fullmatch(detector.name):
        raise ValueError(f"{detector.name!r} is no name for a detector: letters, digits, - and _, at most 40")
    lines = [f"[detector.{detector.name}]", f"command = {toml(command(detector, scratch))}"]
    # All of them: the program knows those that are written.
    if parameters := {name: value for name, value in detector.parameters.items() if _is_written(detector, name, value)}:
        lines.append(f"parameters = {toml(parameters)}")
    lines += [f"{name} = {toml(value)}" for name, value in settings.items() if value is not None]
    return "\n".join(lines) + "\n"


def _is_written(detector: Detector, name: str, value: Any) -> bool:
    try:
        toml(value)
    except TypeError:
        # A default that only Python can say stays what it is.
        if name in detector.overrides:
            raise
        return False
    return True


def command(detector: Detector, scratch: Path) -> list[str]:
    """How another process of this Python gets at `detector`."""
    start = [sys.executable, "-m", "scanbench.serve"]
    # What belongs to this Python the other process finds by itself.
    own = (sys.prefix, sys.base_prefix, sys.exec_prefix)
    paths = [path for path in sys.path if os.path.isdir(path) and not os.path.abspath(path).startswith(own)]
    where = ["--directory", os.getcwd(), *(word for path in paths for word in ("--path", path))]
    return [*start, *where, _target(detector, scratch)]


def _target(detector: Detector, scratch: Path) -> str:
    module, name = sys.modules.get(detector.target.__module__), detector.target.__qualname__
    found: Any = module
    for part in name.split("."):
        found = getattr(found, part, None)
    same = isinstance(found, Detector) and (found.target, found.noise) == (detector.target, detector.noise)
    plain = found is detector.target and detector.noise == -1
    if same or plain:
        if detector.target.__module__ != "__main__":
            return f"{detector.target.__module__}:{name}"
        file = getattr(module, "__file__", None)
        if file and file.endswith(".py") and os.path.exists(file):
            return f"{os.path.abspath(file)}:{name}"
    return str(_pickled(detector, scratch))


def _pickled(detector: Detector, scratch: Path) -> Path:
    pickler = _pickler()
    if pickler is None:
        raise ValueError(
            f"{detector.name} is defined in a notebook or inside a function, where another process cannot import it: "
            "put it into a file, or install cloudpickle"
        )
    path = scratch / f"{detector.name}.pickle"
    plain = Detector(detector.target, detector.name, detector.version, detector.noise)
    path.write_bytes(pickler.dumps(plain, protocol=pickle.DEFAULT_PROTOCOL))
    return path


def _pickler() -> Any:
    # joblib, which comes with scikit-learn, carries a copy.
    for name in ("cloudpickle", "joblib.externals.cloudpickle"):
        try:
            return importlib.import_module(name)
        except ImportError:
            continue
    return None


def toml(value: Any) -> str:
    """`value` as TOML writes it."""
    if hasattr(value, "item") and getattr(value, "shape", None) == ():
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float) and math.isfinite(value):
        text = repr(value)
        return text if any(sign in text for sign in ".e") else text + ".0"
    if isinstance(value, str | Path):
        # JSON's strings are TOML's, but for DEL, and for halves of surrogate pairs, which ensure_ascii would write.
        return json.dumps(str(value), ensure_ascii=False).replace("\x7f", "\\u007F")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{toml(str(key))} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(toml, value)) + "]"
    raise TypeError(f"{value!r} cannot be a parameter in scanbench.toml")
