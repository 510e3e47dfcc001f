"""Holds what scanbench reads and writes against other libraries; see check-formats beside this folder."""

import subprocess
import sys
import tempfile
from pathlib import Path

import check_mcap

CHECKS = [
    ("MCAP, written", check_mcap.check_written),
    ("MCAP, read", check_mcap.check_read),
]


def main():
    program = Path(sys.argv[1]).absolute()

    def scanbench(*arguments):
        ended = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
        assert ended.returncode == 0, f"{arguments}: {ended.stderr}"
        return ended.stdout

    for name, check in CHECKS:
        with tempfile.TemporaryDirectory() as scratch:
            print(f"ok  {name}: {check(scanbench, Path(scratch))}")


if __name__ == "__main__":
    main()
