"""Pages with generated blocks.

A block begins with a comment that names commands and what is shown of their results, and ends with one that holds the
checksums of what decided its content, and of the content:

    <!-- made by:
    scanbench gaps
    shows: gap-shares
    -->
    (made by the script)
    <!-- end: sources 1f0c…, content 77ab… -->

A block that was never made ends with `<!-- end -->`.
"""

import re
import shlex
import subprocess
from dataclasses import dataclass
from pathlib import Path

from stamp import checksum, words_of

BEGIN = "<!-- made by:"
BLOCK = re.compile(
    rf"{BEGIN}\n(?P<commands>(?:(?!<!--|-->).)*?\n)shows: (?P<shows>[^\n]*)\n-->"
    r"(?P<body>(?:(?!<!-- (?:made by|end)).)*)<!-- end(?:: sources (?P<sources>\w+), content (?P<content>\w+))? -->",
    re.DOTALL,
)


class PageError(Exception):
    """A page whose blocks cannot be read."""


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

    def text(self) -> str:
        """The block as it stands in its page."""
        sums = f": sources {self.sources}, content {self.content}" if self.sources else ""
        body = f"\n\n{self.body.strip()}\n\n" if self.body.strip() else "\n"
        head = "\n".join([BEGIN, *self.commands, f"shows: {shlex.join(self.shows)}", "-->"])
        return f"{head}{body}<!-- end{sums} -->"


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


def called(code: str) -> set[tuple[str, ...]]:
    """The words of each call of the program by a piece of shell; `cargo run --release --` is the program."""
    environment = {"PATH": "", "HOME": "~"}
    shell = ["/bin/bash", "--restricted", "-c", SAID + code]
    ended = subprocess.run(shell, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
    return {tuple(it.split("\x1f")[:-1]) for it in ended.stdout.splitlines()}


def not_shown(parts: list[str | Block]) -> list[tuple[Block, str]]:
    """Commands of blocks that the reader of the page is not shown, neither in a fence of shell nor as inline code."""
    prose = "\n".join(it for it in parts if isinstance(it, str))
    code = re.findall(r"^```sh\n(.*?)^```|`(scanbench [^`]+)`", prose, re.MULTILINE | re.DOTALL)
    shown = {it for fence, inline in code for it in called(fence or inline)}
    return [(block, it) for block in parts[1::2] for it in block.commands if tuple(words_of(it)) not in shown]
