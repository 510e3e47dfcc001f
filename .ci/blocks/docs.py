"""Makes generated blocks of pages again. Called by `.ci/docs`, which says how."""

import argparse
import signal
import subprocess
import sys
from pathlib import Path

from commands import CommandError, Runner
from page import Block, PageError, join, not_shown, split
from shows import SHOWS
from stamp import sources

ROOT = Path(__file__).resolve().parents[2]
Pages = dict[Path, list[str | Block]]


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


def why_stale(root: Path, block: Block) -> list[str]:
    """What has changed since the block was made."""
    if not block.sources:
        return ["never made"]
    is_other = block.sources != sources(root, block.commands, block.shows)
    return ["of other results"] * is_other + ["edited by hand"] * (block.content != block.content_now(root))


def list_stale(root: Path, parted: Pages) -> int:
    """Prints what is stale and why; returns the exit code."""
    blocks = [it for parts in parted.values() for it in parts[1::2]]
    stale = [(block, changed) for block in blocks if (changed := why_stale(root, block))]
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
    block.sources, block.content = sources(root, block.commands, block.shows), block.content_now(root)


def make_all(root: Path, parted: Pages, runner: Runner, *, everything: bool) -> int:
    """Makes stale blocks, or all; returns the exit code."""
    n_made, left = 0, []
    for page, parts in parted.items():
        for block in parts[1::2]:
            if not everything and not why_stale(root, block):
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
    except (CommandError, PageError, ValueError, subprocess.CalledProcessError) as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    # What is piped into `head` ends without a word.
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    sys.exit(main(sys.argv[1:]))
