"""What a release is packed into, the same bytes each time: pack.py licences|sbom|archive|wheel|sums|formula ARGUMENT…

    licences TARGET FEATURES           licences and their texts, of every crate that is compiled in
    sbom TARGET FEATURES               these crates as CycloneDX
    archive FOLDER ARCHIVE             FOLDER as a .tar.gz, its files of the time SOURCE_DATE_EPOCH
    wheel FOLDER SBOM OUT              the Python package with the program of FOLDER, as a wheel in OUT, whose path it prints
    sums FOLDER                        SHA-256 of its files, as sha256sum -c reads it
    formula SUMS ADDRESS               a formula for Homebrew: the archives of SUMS, which lie at ADDRESS
"""

import base64
import gzip
import hashlib
import json
import os
import re
import subprocess
import sys
import tarfile
import time
import tomllib
import zipfile
from pathlib import Path

PYTHON = Path(__file__).resolve().parents[2] / "harness/python"
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


def tag(program):
    """What the program runs on: the machine, and the newest version of GNU's C library that it asks for, at least 2.17."""
    machine = {62: "x86_64", 183: "aarch64"}[int.from_bytes(program[18:20], "little")]
    minor = max([17, *(int(it) for it in re.findall(rb"\0GLIBC_2\.(\d+)", program))])
    return f"py3-none-manylinux_2_{minor}_{machine}"


def metadata(version):
    project = tomllib.loads((PYTHON / "pyproject.toml").read_text())["project"]
    fields = [
        ("Metadata-Version", "2.4"),
        ("Name", project["name"]),
        ("Version", version),
        ("Summary", project["description"]),
        ("License-Expression", project["license"]["text"]),
        *(("License-File", it) for it in ("LICENSE", "LICENCES.txt")),
        *(("Classifier", it) for it in project["classifiers"]),
        ("Requires-Python", project["requires-python"]),
        *(("Requires-Dist", it) for it in project["dependencies"]),
    ]
    for extra, packages in project["optional-dependencies"].items():
        fields += [("Provides-Extra", extra), *(("Requires-Dist", f"{it} ; extra == '{extra}'") for it in packages)]
    head = "".join(f"{name}: {value}\n" for name, value in fields)
    return f"{head}Description-Content-Type: text/markdown\n\n{(PYTHON / project['readme']).read_text()}"


def wheel(folder, sbom, out):
    # Maturin, which makes the wheel from the source, would compile the program once more.
    folder = Path(folder)
    version, program = folder.name.split("-")[1], (folder / "scanbench").read_bytes()
    name, info, of = f"scanbench-{version}", f"scanbench-{version}.dist-info", tag(program)
    written = {f"scanbench/{it.name}": it.read_bytes() for it in PYTHON.glob("src/scanbench/*") if it.is_file()}
    written |= {
        f"{name}.data/scripts/scanbench": program,
        f"{info}/METADATA": metadata(version).encode(),
        f"{info}/WHEEL": f"Wheel-Version: 1.0\nGenerator: pack.py\nRoot-Is-Purelib: false\nTag: {of}\n".encode(),
        f"{info}/sboms/scanbench.cdx.json": Path(sbom).read_bytes(),
        **{f"{info}/licenses/{it}": (folder / it).read_bytes() for it in ("LICENSE", "LICENCES.txt")},
    }

    def line(path, content):
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        return f"{path},sha256={digest},{len(content)}\n"

    # Installers look at the end of the archive for what the wheel says of itself.
    order = sorted(written, key=lambda it: (it.startswith(info), it))
    record = "".join(line(it, written[it]) for it in order) + f"{info}/RECORD,,\n"
    path = Path(out, f"{name}-{of}.whl")
    made_at = time.gmtime(int(os.environ["SOURCE_DATE_EPOCH"]))[:6]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for it in [*order, f"{info}/RECORD"]:
            entry = zipfile.ZipInfo(it, made_at)
            entry.compress_type, entry.create_system = zipfile.ZIP_DEFLATED, 3
            entry.external_attr = (0o100755 if "/scripts/" in it else 0o100644) << 16
            archive.writestr(entry, written.get(it, record.encode()))
    print(path)


def sums(folder):
    for file in sorted(Path(folder).iterdir()):
        if file.is_file() and not file.name.startswith("SHA256SUMS"):
            print(f"{hashlib.sha256(file.read_bytes()).hexdigest()}  {file.name}")


def formula(listed, address):
    own = tomllib.loads((PYTHON.parents[1] / "Cargo.toml").read_text())["workspace"]["package"]
    project = tomllib.loads((PYTHON / "pyproject.toml").read_text())["project"]
    found = dict(reversed(line.split()) for line in Path(listed).read_text().splitlines())
    print(f'''class Scanbench < Formula
  desc "{project["description"].rstrip(".")}"
  homepage "{address.partition("/releases/")[0]}"
  version "{own["version"]}"
  license "{own["license"]}"
  depends_on :linux''')
    for branch, machine in (("intel", "x86_64"), ("arm", "aarch64")):
        name = f"scanbench-{own['version']}-{machine}-unknown-linux-gnu.tar.gz"
        print(f'''
  on_{branch} do
    url "{address}/{name}"
    sha256 "{found[name]}"
  end''')
    print('''
  def install
    bin.install "scanbench"
    man1.install Dir["man/*.1"]
    bash_completion.install "completions/scanbench.bash" => "scanbench"
    fish_completion.install "completions/scanbench.fish"
    zsh_completion.install "completions/scanbench.zsh" => "_scanbench"
  end

  test do
    system bin/"scanbench", "run", "--scans", "0", "--no-rrd", "-o", "run"
  end
end''')


if __name__ == "__main__":
    {it.__name__: it for it in (licences, sbom, archive, wheel, sums, formula)}[sys.argv[1]](*sys.argv[2:])
