"""What decides the results of a block, as one checksum, and so whether it is stale.

The accepted run stands for what detectors find and how it is judged: `.ci/run` fails where the sources do anything else, so
a change that leaves results alone makes no page stale. docs/decisions/program.md says why, and what no stamp sees.
"""

import hashlib
import json
import shlex
import tomllib
from pathlib import Path

ACCEPTED = Path("reports/golden/run")
TIME_UNITS = ("ms", "scans/s", "times")
# What the manifest says of scans, detectors and rules; the rest of it is about the day, the machine and the program.
OF_MANIFEST = ("scoring_version", "config", "seeds", "matching_criterion", "ignored", "datasets", "detectors")


def checksum(*parts: bytes) -> str:
    """Eight hexadecimal digits, enough to see a change."""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(hashlib.sha256(part).digest())
    return digest.hexdigest()[:8]


def words_of(command: str) -> list[str]:
    """The words of a command after the name of the program."""
    program, *words = shlex.split(command)
    if program != "scanbench":
        raise ValueError(f"not a command of scanbench: {command}")
    return words


def is_recorded(word: str) -> bool:
    return word.startswith("~/data/")


def said(file: Path) -> bytes:
    """What a file says: TOML without its comments and its layout, and without where data sets come from."""
    if file.suffix != ".toml":
        return file.read_bytes()
    content = tomllib.loads(file.read_text())
    for entry in content.get("recorded", {}).values():
        for name in ("licence", "licence_url", "url", "download"):
            entry.pop(name, None)
    return json.dumps(content, sort_keys=True, default=str).encode()


def golden(root: Path) -> bytes:
    """Of the accepted run the scoring version, rows, numbers but times, and what it was a run of."""
    run = root / ACCEPTED
    manifest, report = (json.loads((run / it).read_text()) for it in ("manifest.json", "report.json"))
    numbers = [it for part in ("rows", "overall") for it in report.get(part, []) if it["unit"] not in TIME_UNITS]
    results = json.dumps([{it: manifest.get(it) for it in OF_MANIFEST}, numbers], sort_keys=True).encode()
    return results + (run / "matches.csv").read_bytes()


def sources(root: Path, commands: list[str], shows: list[str]) -> str:
    """The checksum of all that decides what a block would show now."""
    named = [root / it for command in commands for it in words_of(command) if it.startswith("docs/")]
    files = [it for path in named for it in (path.rglob("*") if path.is_dir() else [path]) if it.is_file()]
    # The study of partly seen objects has parameters and a model that no block shows.
    files += [it for it in root.glob("*/src/params/**/*.*") if not it.name.startswith("partial")]
    files += [root / "datasets.toml", *root.glob("harness/simulator/src/sensors/*.toml")]
    return checksum("\n".join([*commands, *shows]).encode(), golden(root), *sorted(map(said, files)))
