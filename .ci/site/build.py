"""The pages of the repository as a book: build.py MDBOOK PROGRAM SCHEMAS RUSTDOC FOLDER

Every page and file that links lead to from README.md is copied to FOLDER/src, at its place in the repository. The order is
that of docs/README.md. The program adds the reference of its command line, and the gallery its report pages. SCHEMAS has
what the example `schemas` of the crate `reports` wrote, RUSTDOC the documentation of the code. Fails if a link or an anchor
of the book in FOLDER/book leads nowhere, or if a file of the gallery's run, or a scanbench.toml, does not fit its schema.
"""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import jsonschema

from program import read_json, run

ROOT = Path(__file__).resolve().parents[2]
# A fence, or else a link to a file.
LINK = re.compile(r"^(?P<fence>```|~~~).*?^(?P=fence)[ \t]*$|\]\((?P<target>[^()\s:#]+)(?=[#)])", re.MULTILINE | re.DOTALL)
BOOK = """[book]
title = "scanbench"
[output.html]
default-theme = "light"
preferred-dark-theme = "navy"
additional-css = ["site.css"]
additional-js = ["site.js"]
[output.html.playground]
runnable = false
"""
# Links differ from text by more than a pale colour.
CSS = """main { overflow-wrap: anywhere }
:root { --content-max-width: 960px }
main table { overflow-wrap: normal }
main :is(td, th) { padding: 3px 10px }
main a:not(.header) { text-decoration: underline }
.navy { --links: #8ab4ff }
.navy :is(.hljs-variable, .hljs-attr, .hljs-attribute, .hljs-name, .hljs-deletion) { color: #ee9999 }
"""
# What scrolls is reached by Tab.
JS = 'for (const it of document.querySelectorAll("pre code, .table-wrapper")) it.tabIndex = 0;\n'
# A page of each kind, of simulated streets.
GALLERY = {
    "run": "run street-narrow --scans 0..20:2 -d hierarchical,paper,pca --no-rrd",
    "sweep": "sweep street-narrow --seed 9001 --sensor vlp-16 --scans 0..20:2 -d paper -P cell_size_m=0.4:1.2:0.2 --no-rrd",
}
ADDED = {"Command line": "command-line", "Gallery": "gallery", "Columns of CSV files": "columns"}
ADDED |= {"JSON schemas": "json-schemas"}
SCHEMAS = """# JSON schemas

JSON Schema 2020-12. Schemas of results are generated from the types that write these files.
`scanbench.schema.json` is for `scanbench.toml`, from the parameters that ship: `scanbench params --schema`."""
CONFIGURATION = "scanbench.schema.json"
WRONG_CONFIGURATIONS = (
    "kd_tree.tolerence_m = 1.0",
    'kd_tree.tolerance_m = "far"',
    "paper.grid.cell_size_m = 40.0",
    'matching.criterion = "center"',
    "classes.forklift = 3",
    "detector.pca.command = ['x']",
    "detector.mine.threads = 2",
    "detector.mine = { command = ['x'], threads = 0 }",
    "detector.mine = { command = ['x'], results = 'y' }",
    "detector.mine = { results = 'y', threads = 2 }",
)


def staged(src):
    """Copies what links lead to from README.md; the text of each page by its path, README.md first."""
    pages, waiting = {}, [Path("README.md")]

    def led_on(link, page):
        target = Path(os.path.normpath(page.parent / (link["target"] or "")))
        if link["fence"] or not (ROOT / target).exists():
            return link[0]
        page_or_file = target / "README.md" if (ROOT / target).is_dir() else target
        if page_or_file.suffix == ".md":
            waiting.append(page_or_file)
        else:
            # The book has no hidden folders.
            page_or_file = Path(*(it.lstrip(".") for it in target.parts))
            (src / page_or_file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / target, src / page_or_file)
        # The book calls a README.md so.
        called = page_or_file.with_name("index.md") if page_or_file.name == "README.md" else page_or_file
        return f"]({os.path.relpath(called, page.parent)}"

    while waiting:
        page = waiting.pop(0)
        if page in pages:
            continue
        if (ROOT / page).is_file():
            text = (ROOT / page).read_text(encoding="utf-8")
        else:
            # A folder without a page of its own: the list of its files.
            files = sorted(it.name for it in (ROOT / page).parent.iterdir() if it.is_file())
            text = f"# {page.parent}\n\n" + "".join(f"- [{it}]({it})\n" for it in files)
        pages[page] = LINK.sub(lambda link, page=page: led_on(link, page), text)
    return pages


def command_line(program, src):
    """The help of every verb, which clap has made."""
    says = lambda *words: run(program, *words, environment=os.environ | {"COLUMNS": "80"})
    says("completions", "--man", src / "man")
    names = sorted(it.stem for it in (src / "man").iterdir())
    shutil.rmtree(src / "man")
    text = "# Command line\n"
    for name in names:
        # scanbench-data-list is a verb of `data`, but there is no verb `fit`.
        parent = name.rpartition("-")[0]
        words = [*parent.split("-"), name[len(parent) + 1 :]] if parent in names[1:] else name.split("-", 1)
        text += f"\n## {' '.join(words)}\n\n```text\n{says(*words[1:], '--help').strip()}\n```\n"
    return text


def gallery(program, src):
    text = "# Gallery\n\nPages that the program writes, each by one command, on simulated streets.\n"
    (src / "gallery").mkdir()
    for name, command in GALLERY.items():
        run(program, *command.split(), "-o", name, cwd=src.parent)
        shutil.copyfile(src.parent / name / "report.html", src / "gallery" / f"{name}.html")
        text += f"\n- [The page of this command](gallery/{name}.html): `scanbench {command}`\n"
    return text + "\n![The page of a run, in light and dark](docs/report.png)\n"


def unfit(schemas, folder):
    """What in files of a run does not fit: JSON its schema, the head of a CSV file its columns."""
    page = (schemas / "columns.md").read_text(encoding="utf-8")
    heads = dict.fromkeys(("table_objects.csv", "table_vehicles.csv"), "table_<task>.csv")
    for file in sorted(folder.glob("*.csv")):
        _, _, section = page.partition(f"\n## `{heads.get(file.name, file.name)}` ")
        rows = [line.split(" | ")[0] for line in section.partition("\n## ")[0].splitlines() if line.startswith("| `")]
        columns = [column for row in rows for column in re.findall(r"`(\w+)`", row)]
        head = file.read_text(encoding="utf-8").partition("\n")[0].split(",")
        if head != columns:
            yield f"{file.name} has the columns {head}, and the page {columns}"
    for schema in sorted(schemas.glob("*.json")):
        file = folder / f"{schema.name.partition('.')[0]}.json"
        if file.exists():
            for error in jsonschema.Draft202012Validator(read_json(schema)).iter_errors(read_json(file)):
                yield f"{file.name}: {error.json_path}: {error.message}"[:300]


def unfit_configurations(program, schema):
    """Files of this repository that the schema of scanbench.toml refuses, and wrong ones that it takes."""
    validator = jsonschema.Draft202012Validator(read_json(schema))
    good = {"what `params` prints": run(program, "params")}
    for file in run("git", "ls-files", "*scanbench.toml", cwd=ROOT).split():
        good[file] = (ROOT / file).read_text(encoding="utf-8")
    for name, text in good.items():
        for error in validator.iter_errors(tomllib.loads(text)):
            yield f"{name}: {error.json_path}: {error.message}"[:300]
    for text in WRONG_CONFIGURATIONS:
        if validator.is_valid(tomllib.loads(text)):
            yield f"the schema of scanbench.toml takes {text}"
        # The program refuses it before it looks for the scan.
        words = [program, "detect", "gone.bin", "-c", "/dev/stdin"]
        said = subprocess.run(words, input=text, capture_output=True, text=True, check=False).stderr
        if "line 1: " not in said:
            yield f"{text} is not refused: {said}"


def summary(pages):
    """The order of docs/README.md, and then what it does not name, below the page of its folder or at the end."""
    lines = ["# Summary", "", "[scanbench](README.md)", "[Pages](docs/README.md)", ""]
    seen = {Path("README.md"), Path("docs/README.md")}

    def chapter(page, depth):
        if page in seen:
            return
        seen.add(page)
        title = re.search(r"^# (.*)$", pages[page], re.MULTILINE)[1].replace("`", "")
        lines.append(f"{'    ' * depth}- [{title}]({page})")
        if page.name == "README.md" and page.parts[0] == "docs":
            for it in sorted(pages):
                if it.parent == page.parent:
                    chapter(it, depth + 1)

    for line in pages[Path("docs/README.md")].splitlines():
        if heading := re.match(r"\*\*(.*?)\*\*", line):
            lines += ["", f"# {heading[1]}", ""]
            if heading[1] == "Use it":
                lines += [f"- [{name}]({page}.md)" for name, page in ADDED.items()]
        for link in LINK.finditer(line):
            chapter(Path(os.path.normpath(Path("docs") / link["target"].replace("index.md", "README.md"))), 0)
    lines += ["", "# Read the code", "", "- [Documentation of the code](rustdoc.md)"]
    for page in sorted(pages):
        chapter(page, 0)
    return "\n".join(lines) + "\n"


class Places(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.ids, self.links = set(), set()
        self.feed(text)

    def handle_starttag(self, _, attrs):
        attrs = dict(attrs)
        self.ids.add(attrs.get("id"))
        self.links |= {attrs[it] for it in ("href", "src") if attrs.get(it)}


def broken(pages):
    """Links of the pages of the book that lead nowhere."""
    # The contents stand in every page once more, and 404.html is for servers.
    for page, places in pages.items():
        for link in sorted(places.links) if page.name not in ("404.html", "print.html") else []:
            url = urlsplit(link)
            if url.scheme or url.netloc:
                continue
            to = (page.parent / unquote(url.path)).resolve() if url.path else page
            to = to / "index.html" if to.is_dir() else to
            if not to.exists():
                yield f"{page}: {link} leads nowhere"
            elif url.fragment and to in pages and unquote(url.fragment) not in pages[to].ids:
                yield f"{page}: {link}: no such heading"


def main(mdbook, program, schemas, rustdoc, folder):
    schemas, rustdoc, folder = Path(schemas), Path(rustdoc), Path(folder).resolve()
    shutil.rmtree(folder, ignore_errors=True)
    src, book = folder / "src", folder / "book"
    src.mkdir(parents=True)
    pages = staged(src)
    shutil.copytree(schemas, src / "schemas", ignore=shutil.ignore_patterns("*.md"))
    (src / "schemas" / CONFIGURATION).write_text(run(program, "params", "--schema"), encoding="utf-8")
    listed = "".join(f"- [{it.name}](schemas/{it.name})\n" for it in sorted((src / "schemas").iterdir()))
    crates = sorted(it.parent.name for it in rustdoc.glob("*/index.html") if it.parent.name not in ("src", "static.files"))
    of_crates = "".join(f"- [{it}](rustdoc/{it}/index.html)\n" for it in crates)
    written = {f"src/{page}": text for page, text in pages.items()} | {
        "src/command-line.md": command_line(program, src),
        "src/gallery.md": gallery(program, src),
        "src/columns.md": (schemas / "columns.md").read_text(encoding="utf-8"),
        "src/json-schemas.md": f"{SCHEMAS}\n\n{listed}",
        "src/rustdoc.md": f"# Documentation of the code\n\n{of_crates}",
        "src/SUMMARY.md": summary(pages),
        "book.toml": BOOK,
        "site.css": CSS,
        "site.js": JS,
    }
    for name, text in written.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    run(mdbook, "build", folder)
    shutil.copytree(rustdoc, book / "rustdoc")
    files = [it for it in sorted(book.rglob("*.html")) if it.parent == book or it.relative_to(book).parts[0] != "rustdoc"]
    built = {it: Places(it.read_text(encoding="utf-8")) for it in files}
    found = [*broken(built), *unfit(schemas, folder / "run")]
    found += unfit_configurations(program, src / "schemas" / CONFIGURATION)
    n_bytes = sum(it.stat().st_size for it in book.rglob("*") if it.is_file())
    print("\n".join(found))
    print(f"{len(built)} pages, {n_bytes / 1e6:.1f} MB, {len(found)} problems: {book}/index.html")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main(*sys.argv[1:])
