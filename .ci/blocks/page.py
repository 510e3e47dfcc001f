"""Pages with generated blocks.

A block begins with a comment that names commands and what is shown of their results, and ends with a comment that holds
checksums:

    <!-- made by:
    scanbench gaps
    shows: gap-shares
    -->
    (made by the script)
    <!-- end: command 1f0c…, content 77ab…, detector 0d31…, … -->

A block that was never made ends with `<!-- end -->`.
"""

import hashlib
import re
import shlex
from dataclasses import dataclass, field
from pathlib import Path

BEGIN = "<!-- made by:"
END = re.compile(r"<!-- end(?:: (?P<sums>[^>]*?))? -->")


class PageError(Exception):
    """A page whose blocks cannot be read."""


def checksum(*parts: bytes) -> str:
    """Eight hexadecimal digits, enough to see a change."""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(hashlib.sha256(part).digest())
    return digest.hexdigest()[:8]


@dataclass
class Block:
    """A generated part of a page."""

    page: Path
    line: int  # of the first comment, from 1
    commands: list[str]
    shows: list[str]  # the name of what is shown, then its arguments
    body: str
    made_of: dict[str, str] = field(default_factory=dict)  # checksums by name

    @property
    def name(self) -> str:
        return f"{self.page}:{self.line}"

    @property
    def pictures(self) -> list[str]:
        """Pictures that the body shows, as paths from the folder of the page."""
        return re.findall(r"!\[[^\]]*\]\(([^)]+)\)", self.body)

    def content(self, root: Path) -> str:
        """Checksum of what the block shows, pictures included."""
        files = [root / self.page.parent / it for it in self.pictures]
        pictures = [it.read_bytes() if it.is_file() else b"" for it in files]
        return checksum(self.body.strip().encode(), *pictures)

    def text(self) -> str:
        """The block as it stands in its page."""
        sums = ", ".join(f"{name} {value}" for name, value in self.made_of.items())
        end = f"<!-- end: {sums} -->" if sums else "<!-- end -->"
        commands = "\n".join(self.commands)
        body = f"\n\n{self.body.strip()}\n\n" if self.body.strip() else "\n"
        return f"{BEGIN}\n{commands}\nshows: {shlex.join(self.shows)}\n-->{body}{end}"


def split(page: Path, text: str) -> list[str | Block]:
    """The page as prose and blocks, in order."""
    parts: list[str | Block] = []
    rest, line = text, 1
    while BEGIN in rest:
        prose, _, after = rest.partition(BEGIN)
        line += prose.count("\n")
        head, closed, after = after.partition("-->")
        end = END.search(after)
        if not closed or not end or BEGIN in after[: end.start()]:
            raise PageError(f"{page}:{line}: the block has no end")
        *commands, shows = [it.strip() for it in head.strip().splitlines()] or [""]
        if not shows.startswith("shows: ") or not commands:
            raise PageError(f"{page}:{line}: the block needs commands, then a line `shows: …`")
        pairs = [it.split(" ", 1) for it in (end["sums"] or "").split(", ") if it]
        if any(len(it) != 2 for it in pairs):
            raise PageError(f"{page}:{line}: cannot read the checksums {end[0]!r}")
        body = after[: end.start()].strip()
        shown = shlex.split(shows.removeprefix("shows: "))
        parts += [prose, Block(page, line, commands, shown, body, dict(pairs))]
        line += (BEGIN + head + "-->" + after[: end.end()]).count("\n")
        rest = after[end.end() :]
    if END.search(rest):
        raise PageError(f"{page}: an end without a block")
    return parts + [rest]


def join(parts: list[str | Block]) -> str:
    return "".join(it if isinstance(it, str) else it.text() for it in parts)


def not_shown(parts: list[str | Block]) -> list[tuple[Block, str]]:
    """Commands of blocks that the reader of the page is not shown, neither in a fence nor as inline code."""
    prose = "\n".join(it for it in parts if isinstance(it, str))
    code = re.findall(r"^```.*?^```|`[^`]+`", prose, re.MULTILINE | re.DOTALL)
    shown = set()
    for it in code:
        for line in it.replace("\\\n", " ").splitlines():
            shown.add(plain(line.strip("`")))
    blocks = [it for it in parts if isinstance(it, Block)]
    return [(block, it) for block in blocks for it in block.commands if plain(it) not in shown]


def plain(command: str) -> str:
    """The command without its comment, and with single spaces; `cargo run --release --` is the program."""
    command = re.sub(r"\s#.*$", "", command)
    return " ".join(command.split()).replace("cargo run --release --", "scanbench")
