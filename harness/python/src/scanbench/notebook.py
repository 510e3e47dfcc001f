"""A run as HTML, for notebooks."""

from __future__ import annotations

import base64
import re
from html import escape
from pathlib import Path

TABLES = ["table_objects.md", "table_vehicles.md"]
FIGURES = ["ranking.svg", "precision_recall.svg", "range_objects.svg", "range_vehicles.svg", "times.svg", "stages.svg"]


def page_of(run: Path) -> str:
    """Tables and figures of the run directory; what it does not have is left out."""
    parts = [f"<p><code>{escape(str(run))}</code></p>"]
    parts += [html_of_markdown((run / name).read_text()) for name in TABLES if (run / name).is_file()]
    figures = run / "figures"
    there = [figures / name for name in FIGURES if (figures / name).is_file()]
    there += sorted(path for path in figures.glob("*.svg") if path not in there)
    return "\n".join(parts + [_figure(path) for path in there])


def _figure(path: Path) -> str:
    # As a picture: styles and ids of one drawing do not reach another.
    data = base64.b64encode(path.read_bytes()).decode()
    style = "max-width:100%;height:auto;background:white;display:block;margin:0.5em 0"
    return f'<img alt="{escape(path.stem)}" style="{style}" src="data:image/svg+xml;base64,{data}">'


def html_of_markdown(text: str) -> str:
    """The Markdown of our tables: tables, lists, bold and italic; everything else is a paragraph."""
    return "\n".join(_block(block.splitlines()) for block in re.split(r"\n\s*\n", text.strip()) if block.strip())


def _block(lines: list[str]) -> str:
    if len(lines) > 1 and lines[0].startswith("|") and set(lines[1]) <= set("|:- "):
        return _table(lines)
    if all(line.startswith("- ") for line in lines):
        items = "".join(f"<li>{_inline(line[2:])}</li>" for line in lines)
        return f'<ul style="font-size:smaller">{items}</ul>'
    return f"<p>{_inline(' '.join(lines))}</p>"


def _table(lines: list[str]) -> str:
    right = [cell.endswith(":") and not cell.startswith(":") for cell in _cells(lines[1])]
    rows = [_row(_cells(lines[0]), right, "th"), *(_row(_cells(line), right, "td") for line in lines[2:])]
    return f"<table>{''.join(rows)}</table>"


def _row(cells: list[str], right: list[bool], tag: str) -> str:
    aligned = [
        f'<{tag} style="text-align:{"right" if at else "left"};white-space:nowrap;padding:0 0.4em">' for at in right
    ]
    return "<tr>" + "".join(f"{start}{_inline(c)}</{tag}>" for start, c in zip(aligned, cells, strict=False)) + "</tr>"


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip().strip("|"))]


def _inline(text: str) -> str:
    text = escape(re.sub(r"\\([\\|\[\]*_<>`])", lambda match: f"&#{ord(match[1])};", text), quote=False).replace(
        "&amp;#", "&#"
    )
    text = re.sub(r"\*\*(.+?)\*\*", r"<b>\1</b>", text)
    return re.sub(r"\*(.+?)\*", r"<i>\1</i>", text)
