"""Runs the commands of blocks, each once, and keeps what they leave behind."""

import json
import os
import re
import shlex
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from stamp import checksum, is_recorded, words_of

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
    "data": {"--simulated-scans": "4", "--against-scans": "0..4"},
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


class Runner:
    """Runs commands of a checkout with its program, or finds what they left behind the last time."""

    def __init__(self, root: Path, *, tiny: bool):
        self.root, self.tiny = root, tiny
        target = Path(os.environ["CARGO_TARGET_DIR"])
        self.program, self.kept = target / "release" / "scanbench", target / "docs"
        self.data = os.environ.get("SCANBENCH_TEST_DATA")

    def has_data_for(self, commands: list[str]) -> bool:
        return bool(self.data) or not any(is_recorded(it) for command in commands for it in words_of(command))

    @cached_property
    def of_program(self) -> str:
        return checksum(self.program.read_bytes())

    def check_accepted(self):
        """Refuses to go on if the program does anything else than the accepted run, by which blocks are stamped."""
        tolerances = (self.root / "reports/golden/tolerances.toml").read_text()
        with tempfile.TemporaryDirectory() as scratch:
            # Whatever the load of the machine.
            quality, run = Path(scratch, "quality.toml"), Path(scratch, "run")
            quality.write_text(re.sub(r"^\[speed\].*", "", tolerances, flags=re.MULTILINE | re.DOTALL))
            golden = ["bash", "-c", 'source .ci/preamble && GOLDEN_REPEATS=1 accepted_run "$1"', "golden", run]
            subprocess.run(golden, cwd=self.root, check=True, capture_output=True)
            accepted, verdict = self.root / "reports/golden", Path(scratch, "verdict")
            arguments = [self.program, "gate", run, "-b", accepted, "-t", quality, "-o", verdict]
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
        directory = self.kept / checksum(json.dumps([words, files, self.of_program]).encode())
        if output:
            outputs[output] = directory / "out"
        # Written last, so that what was interrupted is run again.
        if not (directory / "command.txt").is_file():
            self.start(command, words, directory)
        return Result(command, directory / "out", (directory / "printed.txt").read_text())

    def located(self, word: str, outputs: dict[str, Path]) -> str:
        """A word with the directory of an earlier command, or the folder of recorded data, instead of its name."""
        if is_recorded(word):
            return str(Path(self.data or "") / word.removeprefix("~/"))
        name, equals, value = word.rpartition("=")
        if value not in outputs:
            return word
        # The value of a parameter is TOML.
        return f'{name}="{outputs[value]}"' if equals else str(outputs[value])

    def start(self, command: str, words: list[str], directory: Path):
        print(f"  $ {command}", flush=True)
        shutil.rmtree(directory, ignore_errors=True)
        directory.mkdir(parents=True)
        output = [] if words[0] == "compare" else ["-o", directory / "out"]
        with (directory / "printed.txt").open("w") as printed, (directory / "said.txt").open("w") as said:
            environment = os.environ | {"COLUMNS": COLUMNS}
            arguments = [self.program, *words, *output]
            ended = subprocess.run(arguments, cwd=self.root, env=environment, stdout=printed, stderr=said, check=False)
        if ended.returncode != 0:
            last = (directory / "said.txt").read_text().strip().splitlines()[-3:]
            raise CommandError(f"{command}: exit code {ended.returncode}: {' '.join(last)}")
        (directory / "command.txt").write_text(shlex.join(words) + "\n")


def taken_out(words: list[str], option: str) -> tuple[list[str], str | None]:
    """The words without an option and its value, and the value."""
    if option not in words:
        return words, None
    index = words.index(option)
    return words[:index] + words[index + 2 :], words[index + 1]


def tiny(words: list[str]) -> list[str]:
    for option, value in TINY[words[0]].items():
        words = [*taken_out(words, option)[0], option, value]
    if words[0] != "data" and "--simulated-scans" in words:
        words = [*taken_out(words, "--simulated-scans")[0], "--simulated-scans", "4"]
    # Every fourth value of a sweep.
    return [re.sub(r"^(\w+=0\.2:2\.0):0\.1$", r"\1:0.4", it) for it in words]
