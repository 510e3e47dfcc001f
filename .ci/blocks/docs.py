"""Makes generated blocks of pages again. Called by `.ci/docs`, which says how."""

import argparse
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

from commands import CommandError, Runner
from fingerprint import made_of
from page import Block, PageError, join, not_shown, split
from shows import SHOWS, ShowError, Shown

ROOT = Path(__file__).resolve().parents[2]


def pages(root: Path, names: list[str]) -> dict[Path, list[str | Block]]:
    """The pages that have generated blocks, or those of these names, in parts."""
    paths = [Path("README.md"), *sorted(it.relative_to(root) for it in (root / "docs").glob("*.md"))]
    known = {it: split(it, (root / it).read_text()) for it in paths}
    known = {it: parts for it, parts in known.items() if len(parts) > 1}
    by_name = {it.stem.lower(): it for it in known}
    wanted = [Path(it).stem.lower() for it in names]
    if unknown := [it for it in wanted if it not in by_name]:
        raise PageError(f"no page with generated blocks: {', '.join(unknown)}; there are {', '.join(by_name)}")
    return {it: known[it] for it in (map(by_name.get, wanted) if wanted else known)}


def blocks_of(parts: list[str | Block]) -> list[Block]:
    return [it for it in parts if isinstance(it, Block)]


def check_form(parted: dict[Path, list[str | Block]]):
    problems = []
    for parts in parted.values():
        problems += [f"{block.name}: the page does not show its reader {it!r}" for block, it in not_shown(parts)]
        problems += [f"{it.name}: cannot show {it.shows[0]!r}" for it in blocks_of(parts) if it.shows[0] not in SHOWS]
    if problems:
        raise PageError("\n".join(problems))


def why_stale(root: Path, block: Block) -> list[str]:
    """What has changed since the block was made: names of checksums, with both values where they tell something."""
    if not block.made_of:
        return ["never made"]
    now = made_of(root, block.commands, block.shows)
    changed = []
    for name in [it for it in now if block.made_of.get(it) != now[it]]:
        before = block.made_of.get(name, "none")
        changed.append(f"{name} {before} → {now[name]}" if name == "scoring" else name)
    if block.made_of.get("content") != block.content(root):
        changed.append("edited by hand")
    return changed


def list_stale(root: Path, parted: dict[Path, list[str | Block]]) -> int:
    """Prints what is stale, in a frame, and returns the number of such blocks."""
    lines, n_blocks = [], 0
    for parts in parted.values():
        for block in blocks_of(parts):
            n_blocks += 1
            if changed := why_stale(root, block):
                what = " ".join(block.pictures) or f"{block.shows[0]}: {block.commands[0]}"
                lines.append(f"{block.name}  {what[:90]}\n#     {', '.join(changed)}")
    if lines:
        print("#" * 100)
        print(f"# STALE: {len(lines)} of {n_blocks} generated blocks are not of what the program does now. `.ci/docs` makes them again.")
        for line in lines:
            print(f"#   {line}")
        print("#" * 100)
    else:
        print(f"All {n_blocks} generated blocks are of what the program does now.")
    return len(lines)


def make(root: Path, into: Path, runner: Runner, block: Block):
    """Runs the commands of a block and puts what they gave into it; writes its pictures below `into`."""
    results = runner.run(block.commands)
    name, *arguments = block.shows
    shown: Shown = SHOWS[name](results, *arguments)
    folder = into / block.page.parent
    for file, content in shown.files.items():
        folder.mkdir(parents=True, exist_ok=True)
        (folder / file).write_bytes(content)
    block.body = shown.text.strip()
    sums = made_of(root, block.commands, block.shows)
    block.made_of = {"command": sums.pop("command"), "content": block.content(into), **sums}


def make_all(root: Path, into: Path, parted: dict[Path, list[str | Block]], runner: Runner, *, everything: bool) -> int:
    """Makes stale blocks, or all; returns the exit code."""
    made, skipped, failed = [], [], []
    for page, parts in parted.items():
        for block in blocks_of(parts):
            if not everything and not why_stale(root, block):
                continue
            if not runner.has_data_for(block.commands):
                skipped.append(block.name)
                continue
            print(f"{block.name}: {block.shows[0]}", flush=True)
            try:
                make(root, into, runner, block)
            except (CommandError, ShowError) as error:
                failed.append(f"{block.name}: {error}")
                print(f"  failed: {error}", flush=True)
                continue
            made.append(block.name)
            (into / page).write_text(join(parts))
    print(f"{len(made)} blocks made, {len(skipped)} skipped, {len(failed)} failed")
    for it in skipped:
        print(f"  skipped, SCANBENCH_TEST_DATA names no folder of recorded data: {it}")
    for it in failed:
        print(f"  failed: {it}")
    return 1 if failed else 0


def copied(root: Path, folder: Path, pages: list[Path]) -> Path:
    """A folder with the same pages and pictures, to try things on."""
    (folder / "docs").mkdir(parents=True, exist_ok=True)
    for it in [*pages, *[it.relative_to(root) for it in (root / "docs").glob("*.[ps][nv]g")]]:
        shutil.copyfile(root / it, folder / it)
    return folder


def main() -> int:
    parser = argparse.ArgumentParser(prog=".ci/docs", description="Makes generated blocks of pages again.")
    parser.add_argument("pages", nargs="*", metavar="PAGE", help="pages by name, as `robustness`; all if left out")
    parser.add_argument("--check", action="store_true", help="list what is stale, end with 1 if anything is, and change nothing")
    parser.add_argument("--all", action="store_true", help="make every block, stale or not")
    parser.add_argument("--fresh", action="store_true", help="run all commands again, whatever was kept of them")
    parser.add_argument("--try", dest="folder", type=Path, help="make every block with tiny runs, in a copy in FOLDER")
    arguments = parser.parse_args()
    try:
        parted = pages(ROOT, arguments.pages)
        check_form(parted)
        if arguments.check:
            return 1 if list_stale(ROOT, parted) else 0
        kept = Path(os.environ["CARGO_TARGET_DIR"]) / "docs"
        runner = Runner(ROOT, kept, tiny=bool(arguments.folder), fresh=arguments.fresh)
        runner.build()
        if not runner.tiny:
            runner.check_accepted()
        into = copied(ROOT, arguments.folder, list(parted)) if arguments.folder else ROOT
        return make_all(ROOT, into, parted, runner, everything=arguments.all or bool(arguments.folder))
    except (CommandError, PageError, ValueError, subprocess.CalledProcessError) as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    # What is piped into `head` ends without a word.
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    sys.exit(main())
