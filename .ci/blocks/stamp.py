"""What decides the results of a block, as checksums by name, and so whether it is stale.

The accepted run stands for what detectors find and how it is judged: `.ci/run` fails where the sources do anything else, so
a change that leaves results alone makes no page stale. docs/decisions/program.md says why, and what no stamp sees.
"""

import hashlib
import json
import shlex
import tomllib
from collections.abc import Iterable
from pathlib import Path

ACCEPTED = Path("reports/golden/run")
TIME_UNITS = ("ms", "scans/s", "times")
# What the manifest says of scans, detectors and rules; the rest of it is about the day, the machine and the program.
OF_MANIFEST = ("config", "seeds", "matching_criterion", "ignored", "datasets", "detectors")


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


def takes_catalogue(command: str) -> bool:
    """Whether a command uses data sets of the catalogue: unless all that it names before its options are recorded ones."""
    verb, *words = words_of(command)
    n_named = next((n for n, it in enumerate(words) if it.startswith("-")), len(words))
    named = words[verb == "data" : n_named]
    return verb != "compare" and not (named and all(map(is_recorded, named)))


def said(file: Path) -> bytes:
    """What a file says: TOML without its comments and its layout."""
    if file.suffix != ".toml":
        return file.read_bytes()
    return json.dumps(tomllib.loads(file.read_text()), sort_keys=True, default=str).encode()


def sum_of(files: Iterable[Path]) -> str:
    """Of what files say, whatever they are called."""
    return checksum(*sorted(map(said, files)))


def golden(root: Path) -> dict[str, str]:
    """The scoring version, and of the accepted run rows, numbers but times, and what it was a run of."""
    run = root / ACCEPTED
    manifest, report = (json.loads((run / it).read_text()) for it in ("manifest.json", "report.json"))
    numbers = [it for part in ("rows", "overall") for it in report.get(part, []) if it["unit"] not in TIME_UNITS]
    results = json.dumps([{it: manifest.get(it) for it in OF_MANIFEST}, numbers], sort_keys=True).encode()
    return {"scoring": str(manifest["scoring_version"]), "golden": checksum(results, (run / "matches.csv").read_bytes())}


def stamp(root: Path, commands: list[str], shows: list[str]) -> dict[str, str]:
    """What a block would be made of now, but for its content."""
    words = [it for command in commands for it in words_of(command)]
    named = [root / it for it in words if it.startswith("docs/")]
    files = [it for path in named for it in (path.rglob("*") if path.is_dir() else [path]) if it.is_file()]
    # The study of partly seen objects has parameters and a model that nothing else reads.
    shipped = [it for it in root.glob("*/src/params/**/*.*") if "partial" in words or not it.name.startswith("partial")]
    sums = {"command": checksum("\n".join([*commands, *shows]).encode(), sum_of(files).encode()), **golden(root)}
    sums["models"] = sum_of(it for it in shipped if it.suffix == ".model")
    sums["parameters"] = sum_of(it for it in shipped if it.suffix == ".toml")
    if any(map(takes_catalogue, commands)):
        sums["datasets"] = sum_of([root / "datasets.toml", *root.glob("harness/simulator/src/sensors/*.toml")])
    return sums
