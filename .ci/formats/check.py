"""Holds what scanbench reads and writes against other libraries: check.py SCANBENCH

Every function check_… of the files check_….py takes a function that runs scanbench, and an empty folder. It returns what it
has seen.
"""

import sys
import tempfile
from functools import partial
from importlib import import_module
from pathlib import Path

from program import run

for path in sorted(Path(__file__).parent.glob("check_*.py")):
    for name, check in [*vars(import_module(path.stem)).items()]:
        if name.startswith("check_"):
            with tempfile.TemporaryDirectory() as scratch:
                print(f"ok  {path.stem}.{name}: {check(partial(run, Path(sys.argv[1]).absolute()), Path(scratch))}")
