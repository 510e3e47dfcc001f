"""The pages of the repository as a book: build.py MDBOOK PROGRAM SCHEMAS RUSTDOC FOLDER

Every page and file that links lead to from README.md is copied to FOLDER/src, at its place in the repository. The order is
that of docs/README.md. The program adds the reference of its command line, and the gallery its report pages. SCHEMAS has
what the example `schemas` of the crate `reports` wrote, RUSTDOC the documentation of the code. Fails if a link or an anchor
of the book in FOLDER/book leads nowhere, or if a file of the gallery's run, or a scanbench.toml, does not fit its schema.
"""

import json
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

ROOT = Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^(```|~~~).*?^\1[ \t]*$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(\]\()([^()\s:#]+)(?=[#)])")
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
# Pictures of the program have black text. Links differ from text by more than a pale colour.
CSS = """main { overflow-wrap: anywhere }
main img[src$=".svg"] { background: #fff }
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


def title(text):
    return re.search(r"^# (.*)$", text, re.MULTILINE)[1].replace("`", "")


def staged(src):
    """Copies what links lead to from README.md; the text of each page by its path, README.md first."""
    pages, waiting = {}, [Path("README.md")]
    while waiting:
        page = waiting.pop(0)
        if page in pages:
            continue
        here = ROOT / page
        if here.is_file():
            text = here.read_text(encoding="utf-8")
        else:
            # A folder without a page of its own: the list of its files.
            files = sorted(it.name for it in here.parent.iterdir() if it.is_file())
            text = f"# {page.parent}\n\n" + "".join(f"- [{it}]({it})\n" for it in files)
        parts, end = [], 0
        for link in LINK.finditer(text):
            target = (here.parent / link[2]).resolve().relative_to(ROOT)
            is_code = any(it.start() < link.start() < it.end() for it in FENCE.finditer(text))
            if is_code or not (ROOT / target).exists():
                continue
            target = target / "README.md" if (ROOT / target).is_dir() else target
            if target.suffix == ".md":
                waiting.append(target)
            else:
                # The book has no hidden folders.
                target = Path(*(it.lstrip(".") for it in target.parts))
                (src / target).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile((here.parent / link[2]).resolve(), src / target)
            # The book calls a README.md so.
            called = target.with_name("index.md") if target.name == "README.md" else target
            parts += [text[end : link.start()], link[1], os.path.relpath(called, page.parent)]
            end = link.end()
        pages[page] = "".join([*parts, text[end:]])
    return pages


def command_line(program, src):
    """The help of every verb, which clap has made."""
    program_says = lambda *words: subprocess.run(
        [program, *words], check=True, capture_output=True, text=True, env=os.environ | {"COLUMNS": "80"}
    ).stdout
    program_says("completions", "--man", src / "man")
    names = sorted(it.stem for it in (src / "man").iterdir())
    shutil.rmtree(src / "man")
    text = "# Command line\n"
    for name in names:
        # scanbench-data-list is a verb of `data`, but there is no verb `fit`.
        parent = name.rpartition("-")[0]
        words = [*parent.split("-"), name[len(parent) + 1 :]] if parent in names[1:] else name.split("-", 1)
        text += f"\n## {' '.join(words)}\n\n```text\n{program_says(*words[1:], '--help').strip()}\n```\n"
    return text


def gallery(program, src):
    text = "# Gallery\n\nPages that the program writes, each by one command, on simulated streets.\n"
    for name, command in GALLERY.items():
        words = [program, *command.split(), "-o", name]
        subprocess.run(words, cwd=src.parent, check=True, stdout=subprocess.DEVNULL)
        (src / "gallery").mkdir(exist_ok=True)
        shutil.copyfile(src.parent / name / "report.html", src / "gallery" / f"{name}.html")
        text += f"\n- [The page of this command](gallery/{name}.html): `scanbench {command}`\n"
    return text + "\n![The page of a run, in light and dark](docs/report.png)\n"


def files_of_runs(program, schemas, src):
    """Columns and schemas as two pages; the schemas themselves beside them."""
    shutil.copytree(schemas, src / "schemas", ignore=shutil.ignore_patterns("*.md"))
    with (src / "schemas" / CONFIGURATION).open("wb") as file:
        subprocess.run([program, "params", "--schema"], check=True, stdout=file)
    text = "# JSON schemas\n\nJSON Schema 2020-12. Schemas of results are generated from the types that write these files.\n"
    text += f"`{CONFIGURATION}` is for `scanbench.toml`, from the parameters that ship: `scanbench params --schema`.\n\n"
    text += "".join(f"- [{it.name}](schemas/{it.name})\n" for it in sorted((src / "schemas").iterdir()))
    (src / "json-schemas.md").write_text(text, encoding="utf-8")
    shutil.copyfile(schemas / "columns.md", src / "columns.md")


def unfit(schemas, run):
    """What in files of the folder `run` does not fit: JSON its schema, the head of a CSV file its columns."""
    page = (schemas / "columns.md").read_text(encoding="utf-8")
    heads = dict.fromkeys(("table_objects.csv", "table_vehicles.csv"), "table_<task>.csv")
    for file in sorted(run.glob("*.csv")):
        _, _, section = page.partition(f"\n## `{heads.get(file.name, file.name)}` ")
        rows = [line.split(" | ")[0] for line in section.partition("\n## ")[0].splitlines() if line.startswith("| `")]
        columns = [column for row in rows for column in re.findall(r"`(\w+)`", row)]
        with file.open(encoding="utf-8") as lines:
            if (head := next(lines).strip().split(",")) != columns:
                yield f"{file.name} has the columns {head}, and the page {columns}"
    for schema in sorted(schemas.glob("*.json")):
        file = run / f"{schema.name.partition('.')[0]}.json"
        if file.exists():
            validator = jsonschema.Draft202012Validator(json.loads(schema.read_text(encoding="utf-8")))
            for error in validator.iter_errors(json.loads(file.read_text(encoding="utf-8"))):
                yield f"{file.name}: {error.json_path}: {error.message}"[:300]


def unfit_configurations(program, schema):
    """Files of this repository that the schema of scanbench.toml refuses, and wrong ones that it takes."""
    validator = jsonschema.Draft202012Validator(json.loads(schema.read_text(encoding="utf-8")))
    shipped = subprocess.run([program, "params"], check=True, capture_output=True, text=True).stdout
    files = subprocess.run(["git", "ls-files", "*scanbench.toml"], cwd=ROOT, check=True, capture_output=True, text=True)
    good = {"what `params` prints": shipped} | {it: (ROOT / it).read_text(encoding="utf-8") for it in files.stdout.split()}
    for name, text in good.items():
        for error in validator.iter_errors(tomllib.loads(text)):
            yield f"{name}: {error.json_path}: {error.message}"[:300]
    for text in WRONG_CONFIGURATIONS:
        if validator.is_valid(tomllib.loads(text)):
            yield f"the schema of scanbench.toml takes {text}"
        # The program refuses it before it looks for the scan.
        words = [program, "detect", "gone.bin", "-c", "/dev/stdin"]
        said = subprocess.run(words, input=text, capture_output=True, text=True).stderr
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
        lines.append(f"{'    ' * depth}- [{title(pages[page])}]({page})")
        if page.name == "README.md" and page.parts[0] == "docs":
            for it in sorted(pages):
                if it.parent == page.parent:
                    chapter(it, depth + 1)

    for line in pages[Path("docs/README.md")].splitlines():
        if heading := re.match(r"\*\*(.*?)\*\*", line):
            lines += ["", f"# {heading[1]}", ""]
            if heading[1] == "Use it":
                added = {"Command line": "command-line", "Gallery": "gallery"}
                added |= {"Columns of CSV files": "columns", "JSON schemas": "json-schemas"}
                lines += [f"- [{name}]({page}.md)" for name, page in added.items()]
        for _, link in LINK.findall(line):
            chapter(Path(os.path.normpath(Path("docs") / link.replace("index.md", "README.md"))), 0)
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


def broken(book):
    """Links of the book that lead nowhere, and all of its pages."""
    files = [it for it in sorted(book.rglob("*.html")) if it.parent == book or it.relative_to(book).parts[0] != "rustdoc"]
    pages = {it: Places(it.read_text(encoding="utf-8")) for it in files}
    found = []
    # The contents stand in every page once more, and 404.html is for servers.
    for page, places in pages.items():
        for link in sorted(places.links) if page.name not in ("404.html", "print.html") else []:
            url = urlsplit(link)
            if url.scheme or url.netloc:
                continue
            to = (page.parent / unquote(url.path)).resolve() if url.path else page
            to = to / "index.html" if to.is_dir() else to
            if not to.exists():
                found.append(f"{page.relative_to(book)}: {link} leads nowhere")
            elif url.fragment and to in pages and unquote(url.fragment) not in pages[to].ids:
                found.append(f"{page.relative_to(book)}: {link}: no such heading")
    return found, pages


def crates_of(rustdoc):
    return sorted(it.parent for it in Path(rustdoc).glob("*/index.html") if it.parent.name not in ("src", "static.files"))


def main(mdbook, program, schemas, rustdoc, folder):
    schemas, folder = Path(schemas), Path(folder).resolve()
    shutil.rmtree(folder, ignore_errors=True)
    src = folder / "src"
    src.mkdir(parents=True)
    pages = staged(src)
    for page, text in pages.items():
        (src / page).parent.mkdir(parents=True, exist_ok=True)
        (src / page).write_text(text, encoding="utf-8")
    (src / "command-line.md").write_text(command_line(program, src), encoding="utf-8")
    (src / "gallery.md").write_text(gallery(program, src), encoding="utf-8")
    files_of_runs(program, schemas, src)
    crates = "".join(f"- [{it.name}](rustdoc/{it.name}/index.html)\n" for it in crates_of(rustdoc))
    (src / "rustdoc.md").write_text(f"# Documentation of the code\n\n{crates}", encoding="utf-8")
    (src / "SUMMARY.md").write_text(summary(pages), encoding="utf-8")
    for name, text in {"book.toml": BOOK, "site.css": CSS, "site.js": JS}.items():
        (folder / name).write_text(text, encoding="utf-8")
    subprocess.run([mdbook, "build", folder], check=True)
    shutil.copytree(rustdoc, folder / "book" / "rustdoc")
    found, built = broken(folder / "book")
    found += [*unfit(schemas, folder / "run"), *unfit_configurations(program, src / "schemas" / CONFIGURATION)]
    n_bytes = sum(it.stat().st_size for it in (folder / "book").rglob("*") if it.is_file())
    print("\n".join(found))
    print(f"{len(built)} pages, {n_bytes / 1e6:.1f} MB, {len(found)} problems: {folder}/book/index.html")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main(*sys.argv[1:])
