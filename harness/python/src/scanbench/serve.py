"""`python -m scanbench.serve module:function`, or `file.py:function`: the command of a detector that is a Python function."""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import os
import pickle
import sys
import traceback
from pathlib import Path
from typing import Any

from scanbench.client import WRONGLY_STARTED, last_line, leave, pipe_of_environment, refuse, serve_pipe
from scanbench.detector import Detector
from scanbench.nesting import importing


def load(target: str) -> Detector:
    """The detector that `module:function` or `file.py:function` names, or that `FILE.pickle` holds."""
    if target.endswith(".pickle"):
        return as_detector(pickle.loads(Path(target).read_bytes()), target)
    source, separator, name = target.rpartition(":")
    if not separator:
        raise ValueError(f"{target!r} is not of the form module:function or file.py:function")
    found: Any = _file(Path(source)) if source.endswith(".py") else importlib.import_module(source)
    for part in name.split("."):
        found = getattr(found, part)
    return as_detector(found, target)


def as_detector(found: Any, target: str) -> Detector:
    """A function that has no `@detector` above it is one by its name."""
    if isinstance(found, Detector):
        return found
    if callable(found):
        return Detector(found, None, None, -1)
    raise TypeError(f"{target} is neither a function nor a detector, but {type(found).__name__}")


def _file(path: Path) -> Any:
    specification = importlib.util.spec_from_file_location(path.stem, path)
    if specification is None or specification.loader is None:
        raise ImportError(f"cannot load {path}")
    module = importlib.util.module_from_spec(specification)
    # Neighbours of the file are found as if it were run; classes of it can be pickled.
    sys.path.insert(0, str(path.absolute().parent))
    sys.modules[path.stem] = module
    specification.loader.exec_module(module)
    return module


def main(arguments: list[str] | None = None) -> int:
    """Serves until the program ends; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m scanbench.serve", description=__doc__)
    parser.add_argument("target", help="module:function or file.py:function")
    parser.add_argument("--directory", help="folder to work in, instead of that of scanbench.toml")
    parser.add_argument("--path", action="append", default=[], help="folder to find modules in; may be repeated")
    parsed = parser.parse_args(arguments)
    pipe = pipe_of_environment()
    if pipe is None:
        print(WRONGLY_STARTED.format(name=parsed.target.rpartition(":")[2]), file=sys.stderr)
        return 2
    try:
        if parsed.directory:
            os.chdir(parsed.directory)
        sys.path[:0] = [os.getcwd(), *parsed.path]
        with importing(parsed.target):
            detector = load(parsed.target)
    except KeyboardInterrupt:
        return 130
    except BaseException as error:  # SystemExit of a module, too: the program gets the reason.
        traceback.print_exc()
        return refuse(pipe, last_line(error))
    return serve_pipe(detector, pipe)


if __name__ == "__main__":
    leave(main())
