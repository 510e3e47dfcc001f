"""Runs the commands of blocks, each once, and keeps what they leave behind."""

import json
import os
import re
import shlex
import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from fingerprint import fingerprint, is_real, words_of
from page import checksum

# Wide enough that no table is folded.
COLUMNS = "200"

# What makes a run tiny: the options of each verb, which replace those that the command has.
TINY = {
    "run": {"--scans": "0..2"},
    "ablation": {"--scans": "0..2"},
    "boxes": {"--scans": "0..4"},
    "sweep": {"--scans": "0..1", "--timed-scans": "0"},
    "gaps": {"--pairs": "1"},
    "robustness": {"--scans": "1"},
    "reproduce": {"--scans": "0..2", "--settings": "2"},
    "train": {"--simulated-scans": "36", "--scans": "0..36:2", "--vehicles": "60"},
    "realism": {"--simulated-scans": "4", "--against-scans": "0..4"},
    "compare": {},
}


class CommandError(Exception):
    """A command that did not end well."""


@dataclass
class Result:
    """What a command left behind."""

    command: str
    directory: Path
    printed: str
    seconds: float


class Runner:
    """Runs commands of a checkout with its program, or finds what they left behind the last time."""

    def __init__(self, root: Path, kept: Path, *, tiny: bool, fresh: bool):
        self.root, self.kept, self.tiny = root, kept, tiny
        self.program = Path(os.environ["CARGO_TARGET_DIR"]) / "release" / "scanbench"
        self.data = os.environ.get("SCANBENCH_TEST_DATA")
        self.done: set[Path] = set()
        self.fresh = fresh

    def has_data_for(self, commands: list[str]) -> bool:
        return bool(self.data) or not any(is_real(it) for command in commands for it in words_of(command))

    def build(self):
        subprocess.run(["cargo", "build", "--release", "--quiet", "--bin", "scanbench"], cwd=self.root, check=True)

    def check_accepted(self):
        """Refuses to go on if the program does anything else than the accepted run, by which blocks are stamped."""
        tolerances = (self.root / "reports/golden/tolerances.toml").read_text()
        with tempfile.TemporaryDirectory() as scratch:
            # Whatever the load of the machine.
            quality = Path(scratch, "quality.toml")
            quality.write_text(re.sub(r"^\[speed\].*", "", tolerances, flags=re.MULTILINE | re.DOTALL))
            environment = os.environ | {"GOLDEN_REPEATS": "1"}
            run, verdict = Path(scratch, "run"), Path(scratch, "verdict")
            subprocess.run([self.root / ".ci/golden", run], check=True, env=environment, capture_output=True)
            arguments = [self.program, "gate", run, "-b", self.root / "reports/golden", "-t", quality, "-o", verdict]
            ended = subprocess.run(arguments, cwd=self.root, capture_output=True, text=True, check=False)
        if ended.returncode != 0:
            said = (ended.stdout.splitlines() or ended.stderr.splitlines() or [""])[0]
            raise CommandError(f"the program is not as it was accepted: {said}; accept it first: .ci/accept 'why'")

    def run(self, commands: list[str]) -> list[Result]:
        """The results of commands, of which later ones may take the directories of earlier ones (`-o NAME`)."""
        outputs: dict[str, Path] = {}
        return [self.run_one(it, outputs) for it in commands]

    def run_one(self, command: str, outputs: dict[str, Path]) -> Result:
        words, output = taken_out(words_of(command), "-o")
        words = [self.located(it, outputs) for it in words]
        if self.tiny:
            words = tiny(words)
        # Of this very program, whatever is shown of it, now or in another block.
        files = [(self.root / it).read_text() for it in words if it.endswith(".toml") and (self.root / it).is_file()]
        place = self.kept / checksum(json.dumps([words, files, fingerprint(self.root, "program"), self.tiny]).encode())
        if output:
            outputs[output] = place / "out"
        if self.fresh and place not in self.done:
            shutil.rmtree(place, ignore_errors=True)
        if not (place / "seconds").is_file():
            self.start(command, words, place)
        self.done.add(place)
        seconds = float((place / "seconds").read_text())
        return Result(command, place / "out", (place / "printed.txt").read_text(), seconds)

    def located(self, word: str, outputs: dict[str, Path]) -> str:
        """A word with the directory of an earlier command, or the folder of recorded data, in the place of its name."""
        if is_real(word):
            return str(Path(self.data or "") / word.removeprefix("~/"))
        name, equals, value = word.rpartition("=")
        if value not in outputs:
            return word
        # The value of a parameter is TOML.
        return f'{name}="{outputs[value]}"' if equals else str(outputs[value])

    def start(self, command: str, words: list[str], place: Path):
        print(f"  $ {command}", flush=True)
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        arguments = [str(self.program), *words]
        if words[0] != "compare":
            arguments += ["-o", str(place / "out")]
        environment = os.environ | {"COLUMNS": COLUMNS}
        begun = time.monotonic()
        with (place / "printed.txt").open("w") as printed, (place / "said.txt").open("w") as said:
            ended = subprocess.run(arguments, cwd=self.root, env=environment, stdout=printed, stderr=said, check=False)
        seconds = time.monotonic() - begun
        if ended.returncode != 0:
            last = (place / "said.txt").read_text().strip().splitlines()[-3:]
            raise CommandError(f"{command}: exit code {ended.returncode}: {' '.join(last)}")
        (place / "command.txt").write_text(shlex.join(words) + "\n")
        # Last, so that what was interrupted is run again.
        (place / "seconds").write_text(f"{seconds:.1f}\n")
        print(f"    {seconds:.0f} s", flush=True)


def taken_out(words: list[str], option: str) -> tuple[list[str], str | None]:
    """The words without an option and its value, and the value."""
    if option not in words:
        return words, None
    place = words.index(option)
    return words[:place] + words[place + 2 :], words[place + 1]


def tiny(words: list[str]) -> list[str]:
    verb = words[1] if words[0] == "data" else words[0]
    options = dict(TINY[verb])
    if words[0] in ("run", "ablation", "boxes", "sweep") and "--simulated-scans" in words:
        options["--simulated-scans"] = "4"
    for option, value in options.items():
        words, _ = taken_out(words, option)
        words = [*words, option, value]
    if verb == "sweep":
        # Every fourth value.
        words = [re.sub(r"^(\w+=0\.2:2\.0):0\.1$", r"\1:0.4", it) for it in words]
    return words
