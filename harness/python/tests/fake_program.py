"""Stands for the program in tests: starts the detectors of scanbench.toml, asks each for a scan, and copies a run directory.

What it was given is left in `call.json`.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
from pathlib import Path

import numpy as np
import tomllib

sys.path.insert(0, str(Path(__file__).parent))
from reference_host import DetectorFailure, Host, columns_of


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("verb")
    parser.add_argument("dataset", nargs="*")
    parser.add_argument("-d", dest="detectors")
    parser.add_argument("-o", dest="output", type=Path)
    parser.add_argument("-c", dest="config", type=Path)
    parser.add_argument("-P", dest="parameters", action="append", default=[])
    given, others = parser.parse_known_args()
    project = os.environ.get("SCANBENCH_PROJECT")
    given.config = given.config or project and Path(project)
    config = tomllib.loads(given.config.read_text()) if given.config else {}
    found = {}
    points = np.repeat(np.arange(100, dtype=np.float32)[:, None], 4, axis=1)
    for name, section in config.get("detector", {}).items():
        if name not in given.detectors.split(","):
            continue
        try:
            with Host(section["command"], section.get("parameters", {}), directory=given.config.parent) as host:
                host.hello()
                host.configure()
                found[name] = host.scan(columns_of(points)).n_detections
                host.quit()
        except DetectorFailure as failure:
            print(f"error: detector {name}: {failure}", file=sys.stderr)
            return 6
    shutil.copytree(os.environ["FAKE_RUN"], given.output)
    call = {
        "argv": sys.argv[1:],
        "others": others,
        "config": config,
        "found": found,
        "cwd": os.getcwd(),
        "project": project,
    }
    (given.output / "call.json").write_text(json.dumps(call, default=str))
    print("printed")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
