"""Recordings whose layers are files of a folder."""

import subprocess
from pathlib import Path


def one_file(path, folder):
    """The recording at this path; its layers are put together in `folder`."""
    layers = sorted(map(str, Path(path).glob("*.rrd")))
    if not layers:
        return path
    one = folder / "run.rrd"
    subprocess.run(["rerun", "rrd", "merge", *layers, "-o", one], check=True, capture_output=True)
    return one
