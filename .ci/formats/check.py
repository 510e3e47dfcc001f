"""Holds what scanbench reads and writes against other libraries; the step `formats` of .ci/run.

Every function check_… of the files check_….py takes a function that runs scanbench, and an empty folder. It returns what it
has seen.
"""

import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path


def main():
    program = Path(sys.argv[1]).absolute()

    def scanbench(*arguments):
        ended = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
        assert ended.returncode == 0, f"{arguments}: {ended.stderr}"

    for path in sorted(Path(__file__).parent.glob("check_*.py")):
        for name, check in [*vars(import_module(path.stem)).items()]:
            if name.startswith("check_"):
                with tempfile.TemporaryDirectory() as scratch:
                    print(f"ok  {path.stem}.{name}: {check(scanbench, Path(scratch))}")


if __name__ == "__main__":
    main()
