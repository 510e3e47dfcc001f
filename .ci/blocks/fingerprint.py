"""Checksums of what makes numbers, by group.

Comments, blank lines and tests of Rust files do not count, and neither do the names of files, so that only what is compiled
makes a page stale.
"""

import re
import shlex
import subprocess
from functools import cache
from pathlib import Path

from page import checksum

# Paths that begin like this belong to the group, unless they begin like one after the `-`.
GROUPS = {
    "detector": (["detector/src/", "baselines/src/"], []),
    "models": (["detector/src/", "baselines/src/"], []),
    "simulator": (
        ["harness/simulator/src/", "datasets.toml"],
        [],
    ),
    "judging": (
        [
            "harness/scans/src/annotation.rs",
            "harness/scans/src/task.rs",
            "harness/evaluation/src/object_box.rs",
            "harness/evaluation/src/matching",
            "harness/evaluation/src/metrics",
            "harness/evaluation/src/run",
            "harness/evaluation/src/sweep",
            "reports/src/",
        ],
        ["reports/src/plot", "reports/src/html", "reports/src/gate", "reports/src/palette.rs"],
    ),
    "realism": (["harness/evaluation/src/realism", "reports/src/curve_pair.rs"], []),
    "training": (["harness/evaluation/src/training", "harness/scanbench/src/commands/train"], []),
    "readers": (["harness/scans/src/dataset/"], []),
    "plots": (["reports/src/plot", "reports/src/palette.rs"], []),
    "page": (["reports/src/html", "reports/src/plot", "reports/src/palette.rs"], []),
    "recording": (["harness/viewer/src", "reports/src/palette.rs"], []),
}

# Parameters that people choose; what else is no program below detector/ and baselines/ was trained or fitted.
PARAMETERS = {"detector/src/params/paper.toml", "baselines/src/params/params.toml"}

JUDGED = ["detector", "models", "simulator", "judging"]
OF_VERB = {
    "run": JUDGED,
    "compare": JUDGED,
    "ablation": JUDGED,
    "sweep": JUDGED,
    "gaps": JUDGED,
    "robustness": JUDGED,
    "boxes": ["detector", "simulator", "judging"],
    "train": ["detector", "simulator", "training"],
    "data realism": ["detector", "simulator", "realism"],
}
OF_SHOWN = {"picture": ["plots"], "report-page": ["page"], "viewer": ["recording"]}


def words_of(command: str) -> list[str]:
    """The words of a command after the name of the program."""
    program, *words = shlex.split(command)
    if program != "scanbench":
        raise ValueError(f"not a command of scanbench: {command}")
    return words


def is_real(word: str) -> bool:
    return word.startswith("~/data/")


def groups_of(commands: list[str], shown: str) -> list[str]:
    """The groups that decide what a block shows."""
    found = set(OF_SHOWN.get(shown, []))
    for command in commands:
        verb, *words = words_of(command)
        verb = f"{verb} {words.pop(0)}" if verb == "data" else verb
        if verb not in OF_VERB:
            raise ValueError(f"no groups are known for the verb {verb!r}")
        found |= set(OF_VERB[verb])
        if any(is_real(it) for it in words):
            found.add("readers")
            # Its data sets are all recorded ones.
            if verb not in ("data realism", "train") and is_real(words[0]) and not named_sets(words):
                found.discard("simulator")
    return [it for it in GROUPS if it in found]


def named_sets(words: list[str]) -> list[str]:
    """Data sets of the catalogue among the words of a command: those before the first option that are no paths."""
    first_option = next((n for n, it in enumerate(words) if it.startswith("-")), len(words))
    return [it for it in words[:first_option] if not is_real(it)]


def compiled(path: str, content: bytes) -> bytes:
    """What of a file makes a difference to the program."""
    if not path.endswith(".rs"):
        return content
    code = re.split(rb"^#\[cfg\(test\)\]\nmod tests", content, maxsplit=1, flags=re.MULTILINE)[0]
    lines = (it.strip() for it in code.splitlines())
    return b"\n".join(it for it in lines if it and not it.startswith(b"//"))


def is_of(group: str, path: str) -> bool:
    within, without = GROUPS[group]
    if not path.startswith(tuple(within)) or path.startswith(tuple(without)):
        return False
    is_chosen = path.endswith(".rs") or path in PARAMETERS
    return {"detector": is_chosen, "models": not is_chosen}.get(group, True)


@cache
def fingerprint(root: Path, group: str) -> str:
    """Checksum of a group, of the files as they lie in the checkout, committed or not."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=root,
        check=True,
        capture_output=True,
    ).stdout
    paths = {it for it in listed.decode().split("\0") if it and is_of(group, it) and (root / it).is_file()}
    if not paths:
        raise ValueError(f"no file belongs to the group {group!r}")
    return checksum(*sorted(compiled(it, (root / it).read_bytes()) for it in paths))


def scoring_version(root: Path) -> str:
    for path in sorted((root / "harness").rglob("*.rs")):
        if found := re.search(r"\bconst SCORING_VERSION: u32 = (\d+);", path.read_text()):
            return found[1]
    raise ValueError("SCORING_VERSION is nowhere below harness")


def made_of(root: Path, commands: list[str], shows: list[str]) -> dict[str, str]:
    """What a block would be made of now, but for its content."""
    files = [root / it for command in commands for it in words_of(command) if it.endswith(".toml")]
    named = [it.read_bytes() for it in files if it.is_file()]
    sums = {"command": checksum("\n".join([*commands, *shows]).encode(), *named)}
    groups = groups_of(commands, shows[0])
    if "judging" in groups:
        sums["scoring"] = scoring_version(root)
    return sums | {it: fingerprint(root, it) for it in groups}
