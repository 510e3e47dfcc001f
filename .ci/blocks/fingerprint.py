"""Checksums of what makes numbers, by group.

What detectors find and how it is judged is told by the accepted run (behaviour.py), so no rename makes a page stale. What that run
does not show is told by the text of its sources, without comments, blank lines, tests and the names of files.
docs/decisions/program.md says which is which, and why.
"""

import re
import shlex
import subprocess
from functools import cache
from pathlib import Path

from behaviour import golden, scoring_version, settings
from page import checksum

# Paths that begin like this belong to the group, unless they begin like one after the `-`.
GROUPS = {
    # Data: what the accepted run uses, and other blocks more of.
    # The rows of the accepted run have the boxes of whole vehicles. How sure of them a model is ranks them in protocols alone, which no block shows.
    "models": (["detector/src/", "baselines/src/"], ["detector/src/params/boxes.model"]),
    "parameters": (["detector/src/params/hierarchical.toml", "detector/src/params/paper.toml", "baselines/src/params/params.toml"], []),
    "datasets": (["datasets.toml", "harness/simulator/src/sensors/"], []),
    # Sources of what the accepted run does not do.
    "ablation": (["harness/evaluation/src/run/ablation.rs", "reports/src/tables/studies/ablation_score.rs"], []),
    "boxes": (
        [
            "detector/src/fit/",
            "detector/src/whole/",
            "detector/src/params/boxes.model",
            "harness/evaluation/src/run/box_study.rs",
            "harness/evaluation/src/object_box.rs",
            "harness/evaluation/src/metrics/",
            "reports/src/numbers/box_",
            "reports/src/plots/box_",
        ],
        [],
    ),
    "compare": (["reports/src/verdicts/paired_difference.rs", "reports/src/tables/verdict/comparison.rs"], []),
    "gaps": (
        [
            "harness/evaluation/src/run/gap_",
            "harness/evaluation/src/metrics/pair_separation.rs",
            "harness/simulator/src/object_pair.rs",
            "harness/simulator/src/staged_scene.rs",
            "reports/src/numbers/gap_curve.rs",
        ],
        [],
    ),
    "robustness": (
        [
            "harness/evaluation/src/run/robustness.rs",
            "harness/simulator/src/rain.rs",
            "harness/simulator/src/street_conditions.rs",
            "reports/src/numbers/condition_scores.rs",
            "docs/models/",
        ],
        [],
    ),
    "reproduction": (
        ["harness/evaluation/src/reproduction/", "harness/scanbench/src/commands/reproduce/", "reports/src/reproduction/"],
        [],
    ),
    "sweep": (
        ["harness/evaluation/src/sweep/", "reports/src/numbers/sweep_", "reports/src/numbers/rank_correlation.rs"],
        [],
    ),
    # Here, and of the page, one file serves tests alone.
    "realism": (["harness/evaluation/src/realism", "reports/src/numbers/curve_pair.rs"], ["harness/evaluation/src/realism/drawn_scan.rs"]),
    "training": (["harness/evaluation/src/training", "harness/scanbench/src/commands/train"], []),
    # Scans of which a part is labelled.
    "regions": (["harness/evaluation/src/matching/labeled_places.rs"], []),
    # Recorded scans.
    "readers": (
        [
            "harness/scans/src/dataset/kitti/",
            "harness/scans/src/dataset/points_of_boxes.rs",
            "harness/scans/src/dataset/positioned_points.rs",
            "harness/scans/src/dataset/semantic_kitti/",
            "harness/scans/src/dataset/velodyne_bin.rs",
        ],
        [],
    ),
    # As the terminal shows them.
    "tables": (
        [
            "reports/src/tables/formats/terminal.rs",
            "reports/src/tables/grid.rs",
            "reports/src/tables/notes.rs",
            "reports/src/tables/sheet.rs",
            "reports/src/tables/task_",
            "reports/src/tables/times_table.rs",
        ],
        [],
    ),
    # All but those of boxes alone, and the list of them.
    "plots": (["reports/src/plots"], ["reports/src/plots/box_", "reports/src/plots/mod.rs"]),
    "page": (
        ["reports/src/pages", "reports/src/plots"],
        ["reports/src/pages/sample_run.rs", "reports/src/plots/box_", "reports/src/plots/mod.rs"],
    ),
    "recording": (["harness/viewer/src", "reports/src/plots/palette.rs"], []),
}

# All that is compiled: results of commands are kept for the very same program only.
PROGRAM = (["Cargo.", "baselines/", "datasets.toml", "detector/", "harness/", "reports/"], ["reports/golden/", "reports/slow/"])

JUDGED = ["golden", "models", "parameters", "datasets"]
OF_VERB = {
    "run": JUDGED,
    "compare": [*JUDGED, "compare"],
    "ablation": [*JUDGED, "ablation"],
    "sweep": [*JUDGED, "sweep"],
    "gaps": [*JUDGED, "gaps"],
    "robustness": [*JUDGED, "robustness"],
    "reproduce": [*JUDGED, "reproduction"],
    "boxes": ["golden", "models", "parameters", "datasets", "boxes"],
    "train": ["golden", "parameters", "datasets", "training"],
    "data realism": ["golden", "parameters", "datasets", "realism"],
}
OF_SHOWN = {"picture": ["plots"], "report-page": ["page"], "viewer": ["recording"], "printed-table": ["tables"]}


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
            found |= {"readers", "regions"}
            # Its data sets are all recorded ones.
            if verb not in ("data realism", "train") and is_real(words[0]) and not named_sets(words):
                found.discard("datasets")
        # Labelled ahead only, as recorded scans are.
        if "streets-ahead" in words:
            found.add("regions")
    return [it for it in ("golden", *GROUPS) if it in found]


def named_sets(words: list[str]) -> list[str]:
    """Data sets of the catalogue among the words of a command: those before the first option that are no paths."""
    first_option = next((n for n, it in enumerate(words) if it.startswith("-")), len(words))
    return [it for it in words[:first_option] if not is_real(it)]


def compiled(path: str, content: bytes) -> bytes:
    """What of a file makes a difference to the program."""
    if path.endswith(".toml") and not path.endswith("Cargo.toml"):
        return settings(content)
    if not path.endswith(".rs"):
        return content
    code = re.split(rb"^#\[cfg\(test\)\]\n(?:pub\(crate\) )?mod tests", content, maxsplit=1, flags=re.MULTILINE)[0]
    lines = (it.strip() for it in code.splitlines())
    return b"\n".join(it for it in lines if it and not it.startswith(b"//"))


def is_of(group: str, path: str) -> bool:
    within, without = GROUPS.get(group, PROGRAM)
    if not path.startswith(tuple(within)) or path.startswith(tuple(without)) or re.search(r"/tests(/|\.rs$)", path):
        return False
    # Trained or fitted.
    return group != "models" or not (path.endswith(".rs") or is_of("parameters", path))


def compiled_files(root: Path, group: str) -> list[bytes]:
    """What counts of the files of a group as they lie in the checkout, committed or not."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=root,
        check=True,
        capture_output=True,
    ).stdout
    paths = {it for it in listed.decode().split("\0") if it and is_of(group, it) and (root / it).is_file()}
    if not paths:
        raise ValueError(f"no file belongs to the group {group!r}")
    return sorted(compiled(it, (root / it).read_bytes()) for it in paths)


@cache
def fingerprint(root: Path, group: str) -> str:
    """Checksum of a group, or of the program."""
    if group == "golden":
        return golden(root)
    return checksum(*compiled_files(root, group))


def made_of(root: Path, commands: list[str], shows: list[str]) -> dict[str, str]:
    """What a block would be made of now, but for its content."""
    files = [root / it for command in commands for it in words_of(command) if it.endswith(".toml")]
    named = [it.read_bytes() for it in files if it.is_file()]
    sums = {"command": checksum("\n".join([*commands, *shows]).encode(), *named)}
    groups = groups_of(commands, shows[0])
    if "golden" in groups:
        sums["scoring"] = scoring_version(root)
    return sums | {it: fingerprint(root, it) for it in groups}
