"""Pages with generated blocks, and whether a block is stale.

A block begins with a comment that names commands and what is shown of their results, and ends with one that holds the
checksums of what decided its content, and of the content. One that was never made ends with `<!-- end -->`.

    <!-- made by:
    scanbench gaps
    shows: gap-shares
    -->
    (made by the script)
    <!-- end: sources 1f0c…, content 77ab… -->

The accepted run stands for what detectors find and how it is judged: `.ci/run` fails where the sources do anything else, so
a change that leaves results alone makes no page stale. docs/decisions/program.md says why, and what no stamp sees.
"""

import hashlib
import json
import re
import shlex
import subprocess
import tomllib
from dataclasses import dataclass
from pathlib import Path

BEGIN = "<!-- made by:"
BLOCK = re.compile(
    rf"{BEGIN}\n(?P<commands>(?:(?!<!--|-->).)*?\n)shows: (?P<shows>[^\n]*)\n-->"
    r"(?P<body>(?:(?!<!-- (?:made by|end)).)*)<!-- end(?:: sources (?P<sources>\w+), content (?P<content>\w+))? -->",
    re.DOTALL,
)
TIME_UNITS = ("ms", "scans/s", "times")
# What the manifest says of scans, detectors and rules; the rest of it is about the day, the machine and the program.
OF_MANIFEST = ("scoring_version", "config", "seeds", "matching_criterion", "ignored", "datasets", "detectors")


class PageError(Exception):
    """A page whose blocks cannot be read."""


def checksum(*parts: bytes) -> str:
    """Eight hexadecimal digits, enough to see a change."""
    return hashlib.sha256(b"".join(hashlib.sha256(it).digest() for it in parts)).hexdigest()[:8]


def words_of(command: str) -> list[str]:
    """The words of a command after the name of the program."""
    program, *words = shlex.split(command)
    if program != "scanbench":
        raise PageError(f"not a command of scanbench: {command}")
    return words


@dataclass
class Block:
    """A generated part of a page."""

    page: Path
    line: int  # of the first comment, from 1
    commands: list[str]
    shows: list[str]  # the name of what is shown, then its arguments
    body: str
    sources: str | None = None
    content: str | None = None

    @property
    def name(self) -> str:
        return f"{self.page}:{self.line}"

    @property
    def pictures(self) -> list[str]:
        """Pictures that the body shows, as paths from the folder of the page."""
        return re.findall(r"!\[[^\]]*\]\(([^)]+)\)", self.body)

    def content_now(self, root: Path) -> str:
        """Checksum of what the block shows, pictures included."""
        files = [root / self.page.parent / it for it in self.pictures]
        return checksum(self.body.strip().encode(), *(it.read_bytes() if it.is_file() else b"" for it in files))

    def sources_now(self, root: Path) -> str:
        """Checksum of all that decides what the block would show now."""
        named = [root / it for command in self.commands for it in words_of(command) if it.startswith("docs/")]
        files = [it for path in named for it in (path.rglob("*") if path.is_dir() else [path]) if it.is_file()]
        # The study of partly seen objects has parameters and a model that no block shows; what sources do the run shows.
        params = root.glob("*/src/params/**/*.*")
        files += [it for it in params if it.suffix != ".rs" and not it.name.startswith("partial")]
        files += [root / "datasets.toml", *root.glob("harness/simulator/src/sensors/*.toml")]
        return checksum("\n".join([*self.commands, *self.shows]).encode(), golden(root), *sorted(said(it, self.commands) for it in files))

    def why_stale(self, root: Path) -> list[str]:
        """What has changed since the block was made."""
        if not self.sources:
            return ["never made"]
        is_edited = self.content != self.content_now(root)
        return ["of other results"] * (self.sources != self.sources_now(root)) + ["edited by hand"] * is_edited

    def text(self) -> str:
        """The block as it stands in its page."""
        sums = f": sources {self.sources}, content {self.content}" if self.sources else ""
        body = f"\n\n{self.body.strip()}\n\n" if self.body.strip() else "\n"
        head = "\n".join([BEGIN, *self.commands, f"shows: {shlex.join(self.shows)}", "-->"])
        return f"{head}{body}<!-- end{sums} -->"


def said(file: Path, commands: list[str]) -> bytes:
    """What a file says: TOML without its comments and its layout, and of data sets neither where they come from nor those
    to train on, which no block shows; those to stream only if a command names one."""
    if file.suffix != ".toml":
        return file.read_bytes()
    content = tomllib.loads(file.read_text())
    for part in ("simulated", "groups"):
        if part in content:
            is_streamed = any("streaming-" in it for it in commands)
            hidden = ("training-",) if is_streamed else ("training-", "streaming-")
            content[part] = {name: it for name, it in content[part].items() if not name.startswith(hidden)}
    for entry in content.get("recorded", {}).values():
        for name in ("licence", "licence_url", "url", "download"):
            entry.pop(name, None)
    return json.dumps(content, sort_keys=True, default=str).encode()


def golden(root: Path) -> bytes:
    """Of the accepted run the scoring version, rows, numbers but times, and what it was a run of."""
    run = root / "reports/golden/run"
    manifest, report = (json.loads((run / it).read_text()) for it in ("manifest.json", "report.json"))
    numbers = [it for part in ("rows", "overall") for it in report.get(part, []) if it["unit"] not in TIME_UNITS]
    for it in manifest.get("detectors", []):
        # The version of the run is the highest of them.
        it.pop("scoring_version", None)
    results = json.dumps([{it: manifest.get(it) for it in OF_MANIFEST}, numbers], sort_keys=True).encode()
    return results + (run / "matches.csv").read_bytes()


def split(page: Path, text: str) -> list[str | Block]:
    """The page as prose and blocks, in order."""
    parts: list[str | Block] = []
    end = 0
    for it in BLOCK.finditer(text):
        line, commands = text.count("\n", 0, it.start()) + 1, it["commands"].strip().splitlines()
        block = Block(page, line, commands, shlex.split(it["shows"]), it["body"].strip(), it["sources"], it["content"])
        parts += [text[end : it.start()], block]
        end = it.end()
    parts.append(text[end:])
    for prose in parts[::2]:
        if found := re.search(rf"^({BEGIN}\n|<!-- end(:.*)? -->)", prose, re.MULTILINE):
            raise PageError(f"{page}: no block with commands, `shows: …` and an end: {found[0].strip()}")
    return parts


def join(parts: list[str | Block]) -> str:
    return "".join(it if isinstance(it, str) else it.text() for it in parts)


# In a restricted shell without any program: what the lines of a page would call, loops and functions worked out.
SAID = "scanbench() { printf '%s\\x1f' \"$@\"; printf '\\n'; }\ncargo() { shift 3; scanbench \"$@\"; }\n"


def not_shown(parts: list[str | Block]) -> list[tuple[Block, str]]:
    """Commands of blocks that the reader of the page is not shown, neither in a fence of shell nor as inline code.

    `cargo run --release --` is the program.
    """
    prose, shown = "\n".join(it for it in parts if isinstance(it, str)), set()
    for code in re.findall(r"^```sh\n(.*?)^```|`(scanbench [^`]+)`", prose, re.MULTILINE | re.DOTALL):
        shell = ["/bin/bash", "--restricted", "-c", SAID + "".join(code)]
        quiet = {"env": {"PATH": "", "HOME": "~"}, "stdin": subprocess.DEVNULL, "capture_output": True, "text": True}
        said = subprocess.run(shell, timeout=60, **quiet).stdout.splitlines()
        shown |= {tuple(it.split("\x1f")[:-1]) for it in said}
    return [(block, it) for block in parts[1::2] for it in block.commands if tuple(words_of(it)) not in shown]
