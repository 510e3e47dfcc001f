"""What a release is packed into, the same bytes each time: pack.py licences|sbom|archive|sums ARGUMENT…

    licences TARGET FEATURES           licences and their texts, of every crate that is compiled in
    sbom TARGET FEATURES               these crates as CycloneDX
    archive FOLDER ARCHIVE             FOLDER as a .tar.gz, its files of the time SOURCE_DATE_EPOCH
    sums FOLDER                        SHA-256 of its files, as sha256sum -c reads it
"""

import gzip
import hashlib
import json
import os
import re
import subprocess
import sys
import tarfile
from pathlib import Path

TEXTS = re.compile(r"(licen[cs]e|copying|notice|unlicense|copyright)", re.IGNORECASE)


def crates(target, features):
    """What is linked into the program, by cargo: each package once, by name and version; and what is ours."""
    command = ["cargo", "metadata", "--locked", "--format-version=1", "--filter-platform", target, *features.split()]
    metadata = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    packages = {it["id"]: it for it in metadata["packages"]}
    nodes = {it["id"]: it for it in metadata["resolve"]["nodes"]}
    [root] = [it for it in packages if packages[it]["name"] == "scanbench"]
    reached, to_visit = set(), [root]
    while to_visit:
        package = to_visit.pop()
        if package not in reached:
            reached.add(package)
            normal = (it["pkg"] for it in nodes[package]["deps"] if any(kind["kind"] is None for kind in it["dep_kinds"]))
            to_visit.extend(normal)
    found = sorted((packages[it] for it in reached), key=lambda it: (it["name"], it["version"]))
    return packages[root], [it for it in found if it["source"]]


def licences(target, features):
    _, others = crates(target, features)
    texts = {}
    print(f"scanbench is under the MIT licence. The program contains {len(others)} crates of others.\n")
    for crate in others:
        files = sorted(it for it in Path(crate["manifest_path"]).parent.iterdir() if TEXTS.search(it.name) and it.is_file())
        for file in files:
            texts.setdefault(file.read_text(errors="replace").strip(), []).append(f"{crate['name']} {crate['version']}")
        note = "" if files else ", without a text of its own"
        print(f"{crate['name']} {crate['version']}: {crate['license'] or crate['license_file']}{note}")
    for text, of in texts.items():
        print(f"\n{'=' * 80}\n{', '.join(of)}\n\n{text}")


def sbom(target, features):
    own, others = crates(target, features)
    lock = Path(own["manifest_path"]).parents[2].joinpath("Cargo.lock").read_text()
    found = re.findall(r'name = "(\S+)"\nversion = "(\S+)"\nsource = .*\nchecksum = "(\w+)"', lock)
    checksums = {(name, version): checksum for name, version, checksum in found}

    def component(crate, kind="library"):
        name, version = crate["name"], crate["version"]
        purl = f"pkg:cargo/{name}@{version}"
        known = {"type": kind, "bom-ref": purl, "name": name, "version": version, "purl": purl}
        if crate["license"]:
            # SPDX has no slash.
            known["licenses"] = [{"expression": re.sub(r" ?/ ?", " OR ", crate["license"])}]
        if (name, version) in checksums:
            known["hashes"] = [{"alg": "SHA-256", "content": checksums[name, version]}]
        return known

    bom = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": component(own, "application")},
        "components": [component(it) for it in others],
    }
    print(json.dumps(bom, indent=1))


def archive(folder, name):
    folder, time = Path(folder), int(os.environ["SOURCE_DATE_EPOCH"])

    def plain(entry):
        entry.mtime, entry.uid, entry.gid, entry.uname, entry.gname = time, 0, 0, "", ""
        entry.mode = 0o755 if entry.isdir() or entry.mode & 0o100 else 0o644
        return entry

    with open(name, "wb") as file, gzip.GzipFile("", "wb", 9, file, time) as packed:
        with tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as tar:
            for path in sorted([folder, *folder.rglob("*")]):
                tar.add(path, path.relative_to(folder.parent).as_posix(), recursive=False, filter=plain)


def sums(folder):
    for file in sorted(Path(folder).iterdir()):
        if file.is_file() and not file.name.startswith("SHA256SUMS"):
            print(f"{hashlib.sha256(file.read_bytes()).hexdigest()}  {file.name}")


if __name__ == "__main__":
    {it.__name__: it for it in (licences, sbom, archive, sums)}[sys.argv[1]](*sys.argv[2:])
