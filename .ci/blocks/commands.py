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


class CommandError(Exception):
    """A command that did not end well, or that left nothing of what is to be shown."""


@dataclass
class Result:
    """What a command left behind."""

    command: str
    directory: Path
    printed: str


class Runner:
    """Runs commands of a checkout with its program, or finds what they left behind the last time."""

    def __init__(self, root: Path):
        self.root, target = root, Path(os.environ["CARGO_TARGET_DIR"])
        self.program, self.kept = target / "release" / "scanbench", target / "docs"
        self.data = os.environ.get("SCANBENCH_TEST_DATA")

    def has_data_for(self, commands: list[str]) -> bool:
        return bool(self.data) or not any(is_recorded(it) for command in commands for it in words_of(command))

    @cached_property
    def of_program(self) -> str:
        return checksum(self.program.read_bytes())

    def check_accepted(self):
        """Refuses to go on if the program does anything else than the accepted run, by which blocks are stamped."""
        accepted = self.root / "reports/golden"
        with tempfile.TemporaryDirectory() as scratch:
            # Whatever the load of the machine.
            quality, run = Path(scratch, "quality.toml"), Path(scratch, "run")
            quality.write_text(re.sub(r"^\[speed\].*", "", (accepted / "tolerances.toml").read_text(), flags=re.M | re.S))
            golden = ["bash", "-c", 'source .ci/preamble && GOLDEN_REPEATS=1 accepted_run "$1"', "golden", run]
            subprocess.run(golden, cwd=self.root, check=True, capture_output=True)
            arguments = [self.program, "gate", run, "-b", accepted, "-t", quality, "-o", Path(scratch, "verdict")]
            ended = subprocess.run(arguments, cwd=self.root, capture_output=True, text=True, check=False)
        if ended.returncode != 0:
            said = (ended.stdout.splitlines() or ended.stderr.splitlines() or [""])[0]
            raise CommandError(f"the program is not as it was accepted: {said}; accept it first: .ci/accept 'why'")

    def run(self, commands: list[str]) -> list[Result]:
        """The results of commands, of which later ones may take the directories of earlier ones (`-o NAME`)."""
        outputs: dict[str, Path] = {}
        return [self.run_one(it, outputs) for it in commands]

    def run_one(self, command: str, outputs: dict[str, Path]) -> Result:
        words, output = words_of(command), None
        if "-o" in words:
            index = words.index("-o")
            _, output = words[index : index + 2]
            del words[index : index + 2]
        words = [self.located(it, outputs) for it in words]
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
        arguments = [self.program, *words, *([] if words[0] == "compare" else ["-o", directory / "out"])]
        with (directory / "printed.txt").open("w") as printed, (directory / "said.txt").open("w") as said:
            # Wide enough that no table is folded.
            environment = os.environ | {"COLUMNS": "200"}
            ended = subprocess.run(arguments, cwd=self.root, env=environment, stdout=printed, stderr=said, check=False)
        if ended.returncode != 0:
            last = (directory / "said.txt").read_text().strip().splitlines()[-3:]
            raise CommandError(f"{command}: exit code {ended.returncode}: {' '.join(last)}")
        (directory / "command.txt").write_text(shlex.join(words) + "\n")
