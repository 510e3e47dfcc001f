"""Makes generated blocks of pages again. Called by `.ci/docs`, which says how."""

import argparse
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
from functools import cached_property
from pathlib import Path

from blocks import Block, PageError, checksum, join, not_shown, split, words_of
from shows import SHOWS, CommandError, Result

ROOT = Path(__file__).resolve().parents[2]
# Where commands have the folder of recorded data.
RECORDED = "~/data/"
Pages = dict[Path, list[str | Block]]


class Runner:
    """Runs commands of a checkout with its program, or finds what they left behind the last time."""

    def __init__(self, root: Path):
        self.root, target = root, Path(os.environ["CARGO_TARGET_DIR"])
        self.program, self.kept = target / "release" / "scanbench", target / "docs"
        self.data = os.environ.get("SCANBENCH_TEST_DATA")

    def has_data_for(self, commands: list[str]) -> bool:
        return bool(self.data) or not any(it.startswith(RECORDED) for command in commands for it in words_of(command))

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
        if word.startswith(RECORDED):
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


def pages(root: Path, names: list[str]) -> Pages:
    """The pages that have generated blocks, or those of these names, in parts."""
    paths = [Path("README.md"), *sorted(it.relative_to(root) for it in (root / "docs").glob("*.md"))]
    known = {it: split(it, (root / it).read_text()) for it in paths}
    by_name = {it.stem.lower(): it for it, parts in known.items() if len(parts) > 1}
    wanted = [Path(it).stem.lower() for it in names] or list(by_name)
    if unknown := [it for it in wanted if it not in by_name]:
        raise PageError(f"no page with generated blocks: {', '.join(unknown)}; there are {', '.join(by_name)}")
    problems = []
    for parts in (known[by_name[it]] for it in wanted):
        problems += [f"{block.name}: the page does not show its reader {it!r}" for block, it in not_shown(parts)]
        problems += [f"{it.name}: cannot show {it.shows[0]!r}" for it in parts[1::2] if it.shows[0] not in SHOWS]
    if problems:
        raise PageError("\n".join(problems))
    return {by_name[it]: known[by_name[it]] for it in wanted}


def list_stale(root: Path, parted: Pages) -> int:
    """Prints what is stale and why; returns the exit code."""
    blocks = [it for parts in parted.values() for it in parts[1::2]]
    stale = [(block, changed) for block in blocks if (changed := block.why_stale(root))]
    for block, changed in stale:
        what = " ".join(block.pictures) or f"{block.shows[0]}: {block.commands[0]}"
        print(f"{block.name}  {what[:90]}\n    {', '.join(changed)}")
    if stale:
        print(f"STALE: {len(stale)} of {len(blocks)} generated blocks. `.ci/docs` makes them again.")
    else:
        print(f"All {len(blocks)} generated blocks are of the accepted results.")
    return 1 if stale else 0


def make(root: Path, runner: Runner, block: Block):
    """Runs the commands of a block and puts what they gave into it; writes its pictures."""
    name, *arguments = block.shows
    shown = SHOWS[name](runner.run(block.commands), *arguments)
    text, files = shown if isinstance(shown, tuple) else (shown, {})
    for file, content in files.items():
        (root / block.page.parent / file).write_bytes(content)
    block.body = text.strip()
    block.sources, block.content = block.sources_now(root), block.content_now(root)


def make_all(root: Path, parted: Pages, runner: Runner, *, everything: bool) -> int:
    """Makes stale blocks, or all; returns the exit code."""
    n_made, left = 0, []
    for page, parts in parted.items():
        for block in parts[1::2]:
            if not everything and not block.why_stale(root):
                continue
            if not runner.has_data_for(block.commands):
                left.append(f"skipped, SCANBENCH_TEST_DATA names no folder of recorded data: {block.name}")
                continue
            print(f"{block.name}: {block.shows[0]}", flush=True)
            try:
                make(root, runner, block)
            except CommandError as error:
                left.append(f"failed: {block.name}: {error}")
                continue
            n_made += 1
            (root / page).write_text(join(parts))
    print("\n  ".join([f"{n_made} blocks made, {len(left)} skipped or failed", *left]))
    return 1 if any(it.startswith("failed") for it in left) else 0


def main(words: list[str], root: Path = ROOT) -> int:
    parser = argparse.ArgumentParser(prog=".ci/docs", description="Makes generated blocks of pages again.")
    parser.add_argument("pages", nargs="*", metavar="PAGE", help="pages by name, as `robustness`; all if left out")
    parser.add_argument("--check", action="store_true", help="list what is stale, and fail if anything is")
    parser.add_argument("--all", action="store_true", help="make every block, stale or not")
    arguments = parser.parse_args(words)
    try:
        parted = pages(root, arguments.pages)
        if arguments.check:
            return list_stale(root, parted)
        subprocess.run(["cargo", "build", "--release", "--quiet", "--bin", "scanbench"], cwd=root, check=True)
        runner = Runner(root)
        runner.check_accepted()
        return make_all(root, parted, runner, everything=arguments.all)
    except (CommandError, PageError, subprocess.CalledProcessError) as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    # What is piped into `head` ends without a word.
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    sys.exit(main(sys.argv[1:]))
