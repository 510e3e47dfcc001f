#!/usr/bin/env python3
"""Runs the commands of docs/walkthroughs/: walkthroughs.py PROGRAM [--write]

All ```sh blocks of a page are one script for bash, in an empty folder, with the folder of PROGRAM first on PATH. Its first
failure ends the check. What a block prints has every line of the ```text block below it, where `…` stands for anything and
spaces do not count. A picture below `<!-- picture: FILE -->` has the bytes of this FILE; --write takes it from there.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "walkthroughs"
BLOCK = re.compile(r"^```(sh|text)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PICTURE = re.compile(r"^<!-- picture: (\S+) -->\n\n!\[[^\]]+\]\((\S+)\)$", re.MULTILINE)
# Printed before each block, so that what it prints can be distinguished from what others print.
MARK = "=== block {} ==="
# Whoever changes the program runs this before there is a commit of it; `baseline init` refuses its runs.
COMMITTED = """sed -i 's/"dirty": true/"dirty": false/' "$PWD"/runs/*/manifest.json 2> /dev/null || true\n"""


def in_one_line(text):
    return " ".join(text.split())


def missing_lines(expected, printed):
    """The expected lines that were not printed."""
    printed = in_one_line(printed)
    patterns = {it: r".*?".join(re.escape(in_one_line(part)) for part in it.split("…")) for it in expected.splitlines()}
    return [line for line, pattern in patterns.items() if not re.search(pattern, printed)]


def run(page, text, folder, program):
    """Problems of a page, whose commands are run in `folder`."""
    blocks = BLOCK.findall(text)
    scripts = [f"echo '{MARK.format(k)}'\n{body}{COMMITTED}" for k, (kind, body) in enumerate(blocks) if kind == "sh"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("SCANBENCH_")}
    environment.pop("COLUMNS", None)
    environment["PATH"] = f"{program.parent}:{environment['PATH']}"
    ended = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", "".join(scripts)], cwd=folder, env=environment, text=True, check=False,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )
    if ended.returncode:
        return [f"{page}: exit code {ended.returncode}\n{ended.stdout}"]
    problems = []
    for k, (kind, body) in enumerate(blocks):
        if kind == "text":
            printed = ended.stdout.split(MARK.format(k - 1) + "\n")[1].split("=== block ")[0]
            problems += [f"{page}: not printed: {it}\n{printed}" for it in missing_lines(body, printed)]
    return problems


def main(program, *words):
    started, problems, pages = time.monotonic(), [], sorted(FOLDER.glob("*.md"))
    for page in pages:
        text, begun = page.read_text(encoding="utf-8"), time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            found = run(page.name, text, folder, Path(program).resolve())
            for file, picture in PICTURE.findall(text) if not found else []:
                made = Path(folder, file).read_bytes()
                if "--write" in words:
                    (FOLDER / picture).write_bytes(made)
                elif (FOLDER / picture).read_bytes() != made:
                    found.append(f"{page.name}: {picture} is not what the commands made; --write takes it")
        if not PICTURE.search(text) and "](../" not in text.rpartition("![")[2]:
            found.append(f"{page.name}: no picture")
        problems += found
        print(f"{page.name}: {text.count(chr(10))} lines, {time.monotonic() - begun:.0f} s", flush=True)
    took = f"{len(pages)} walk-throughs, {len(problems)} problems, {time.monotonic() - started:.0f} s"
    print("\n".join([*problems, took]))
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main(*sys.argv[1:])
