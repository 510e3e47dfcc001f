#!/usr/bin/env python3
"""The texts of the repository.

Every link leads to a file, and every anchor to a heading. Every page is reachable from README.md by links. Paths of the
repository that stand in backticks exist. README.md and ARCHITECTURE.md keep to their lengths. Before it looks at the
repository, the check is tried on small texts that are wrong in one way each.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

MOST_LINES = {"README.md": 130, "ARCHITECTURE.md": 150}
FENCE = re.compile(r"^(```|~~~).*?^\1[ \t]*$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[(?:[^\[\]]|\[[^\[\]]*\]\([^()]*\))*\]\(([^()\s]+)(?:\s+\"[^\"]*\")?\)")
IMAGE = re.compile(r"!\[[^\[\]]*\]\(([^()\s]+)\)")
CODE = re.compile(r"`([^`\n]+)`")
RIGHT = {
    "README.md": "# Top\n\n[page](docs/page.md#a-heading-1), ![picture](docs/picture.png), `docs/page.md`, [it](#top)\n"
    "\n[![within](docs/picture.png)](docs/page.md)\n\n```sh\n[no](link) `docs/none`\n```\n",
    "docs/page.md": "# A heading\n\n## A heading\n\n[up](../README.md) [net](https://example.org/x)\n",
    "docs/picture.png": "",
}
# What is found if a text is changed so.
WRONG = {
    "leads nowhere": ("README.md", "docs/page.md#", "docs/pag.md#"),
    "leads out of": ("docs/page.md", "../README.md", "../../README.md"),
    "has no heading": ("README.md", "#a-heading-1", "#a-heading-2"),
    "there is no `docs/pages.md`": ("README.md", "`docs/page.md`", "`docs/pages.md`"),
    "the link docs/pictur.png": ("README.md", "[![within](docs/picture.png)]", "[![within](docs/pictur.png)]"),
    "no page leads here": ("docs/left.md", "", "# Left alone\n"),
    "lines, 130 at most": ("README.md", "# Top\n", "# Top\n" + 130 * "\n"),
}


def anchors(prose):
    """The anchors that GitHub gives to the headings of a page."""
    found = []
    for heading in re.findall(r"^#{1,6}\s+(.*?)\s*#*$", prose, re.MULTILINE):
        plain = re.sub(r"\[([^\[\]]*)\]\([^()]*\)", r"\1", heading).replace("`", "").replace("*", "")
        slug = re.sub(r"[^\w\- ]", "", plain.lower()).replace(" ", "-")
        n_before = found.count(slug)
        found += [slug, f"{slug}-{n_before}"] if n_before else [slug]
    return found


def problems(texts):
    """What is wrong with the texts of a repository: what its pages say by path, and nothing of its other files."""
    found = []
    known = {*texts, *(str(folder) for file in texts for folder in Path(file).parents)}
    top = {Path(file).parts[0] for file in texts if len(Path(file).parts) > 1}
    pages = {file: FENCE.sub("", text) for file, text in texts.items() if file.endswith(".md")}
    links = {file: [] for file in pages}
    for file, prose in pages.items():
        for target in LINK.findall(prose) + IMAGE.findall(prose):
            path, _, anchor = target.partition("#")
            to = os.path.normpath(Path(file).parent / path) if path else file
            if re.match(r"[a-z+]+:", target):
                continue
            if to not in known:
                where = "out of the repository" if to.startswith("../") else "nowhere"
                found.append(f"{file}: the link {target} leads {where}")
                continue
            # A folder shows its pages.
            links[file] += [to, *(page for page in pages if str(Path(page).parent) == to)]
            if anchor and to in pages and anchor not in anchors(pages[to]):
                found.append(f"{file}: {to} has no heading #{anchor}")
        for code in CODE.findall(prose):
            path = code.rstrip("/")
            is_path = "/" in path and not re.search(r"[\s*{}<>…:$]", path) and path.split("/")[0] in top
            if is_path and path not in known:
                found.append(f"{file}: there is no `{code}`")

    reached, to_visit = set(), ["README.md"]
    while to_visit:
        page = to_visit.pop()
        if page in pages and page not in reached:
            reached.add(page)
            to_visit.extend(links[page])
    found += [f"{page}: no page leads here from README.md" for page in sorted(set(pages) - reached)]
    for file, most in MOST_LINES.items():
        n_lines = texts.get(file, "").count("\n")
        if n_lines > most:
            found.append(f"{file}: {n_lines} lines, {most} at most")
    return found


def prove():
    """Ends the program unless right texts pass, and texts that are wrong in one way each fail."""
    if found := problems(RIGHT):
        sys.exit(f"right texts are not recognised: {found}")
    for expected, (file, before, after) in WRONG.items():
        found = problems(RIGHT | {file: RIGHT.get(file, "").replace(before, after)})
        if not any(expected in it for it in found):
            sys.exit(f"the check does not recognise {expected}: {found}")


def main():
    prove()
    root = Path(__file__).resolve().parents[2]
    command = ["git", "-C", str(root), "ls-files", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    files = [file for file in listed if (root / file).is_file()]
    texts = {file: (root / file).read_text(encoding="utf-8") if file.endswith(".md") else "" for file in files}
    found = problems(texts)
    print("\n".join(found))
    print(f"{sum(file.endswith('.md') for file in files)} pages, {len(found)} problems")
    sys.exit(1 if found else 0)


main()
