"""What the program does, as the accepted run says it: `.ci/run` fails where the sources at hand do anything else."""

import csv
import json
import re
import tomllib
from io import StringIO
from pathlib import Path

from page import checksum

ACCEPTED = Path("reports/golden/run")

TIME_UNITS = ("ms", "scans/s", "times")
TIME_COLUMNS = ("latency_ms", "least_latency_ms", "reference_ms", "cpu_ms", "door_ms")
# What the manifest says of scans, detectors and rules; the rest of it is about the day, the machine and the program.
OF_MANIFEST = ("config", "seeds", "matching_criterion", "ignored", "datasets", "detectors")


def results(run: Path) -> bytes:
    """The results of a run: all of its rows and numbers but the times, and what it was a run of."""
    manifest = json.loads((run / "manifest.json").read_text())
    report = json.loads((run / "report.json").read_text())
    numbers = [it for part in ("rows", "overall") for it in report.get(part, []) if it["unit"] not in TIME_UNITS]
    rows = list(csv.DictReader(StringIO((run / "scans.csv").read_text())))
    said = {
        "manifest": {it: manifest.get(it) for it in OF_MANIFEST},
        "numbers": numbers,
        "scans": [{name: it for name, it in row.items() if name not in TIME_COLUMNS} for row in rows],
    }
    return json.dumps(said, sort_keys=True).encode() + (run / "matches.csv").read_bytes()


def golden(root: Path) -> str:
    """Checksum of the accepted results."""
    return checksum(results(root / ACCEPTED))


def settings(content: bytes) -> bytes:
    """What a TOML file says, without its comments and its layout."""
    return json.dumps(tomllib.loads(content.decode()), sort_keys=True, default=str).encode()


def scoring_version(root: Path) -> str:
    for path in sorted((root / "harness").rglob("*.rs")):
        if found := re.search(r"\bconst SCORING_VERSION: u32 = (\d+);", path.read_text()):
            return found[1]
    raise ValueError("SCORING_VERSION is nowhere below harness")
