"""What a release is packed into, the same bytes each time: pack.py licences|sbom|archive|wheel|sums|formula ARGUMENT…

    licences TARGET FEATURES           licences and their texts, of every crate that is compiled in
    sbom TARGET FEATURES               these crates as CycloneDX
    archive FOLDER ARCHIVE             FOLDER as a .tar.gz, its files of the time SOURCE_DATE_EPOCH
    wheel FOLDER SBOM OUT              the Python package with the program of FOLDER, as a wheel in OUT, whose path it prints
    sums FOLDER                        SHA-256 of its files, as sha256sum -c reads it
    formula SUMS ADDRESS               a formula for Homebrew: the archives of SUMS, which lie at ADDRESS
"""

import base64
import hashlib
import json
import os
import re
import subprocess
import sys
import time
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PYTHON = ROOT / "harness/python"
PROJECT = tomllib.loads((PYTHON / "pyproject.toml").read_text())["project"]
TEXTS = re.compile(r"(licen[cs]e|copying|notice|unlicense|copyright)", re.IGNORECASE)
FORMULA = """class Scanbench < Formula
  desc "{description}"
  homepage "{homepage}"
  version "{version}"
  license "{license}"
  depends_on :linux

  on_intel do
    url "{x86_64[0]}"
    sha256 "{x86_64[1]}"
  end

  on_arm do
    url "{aarch64[0]}"
    sha256 "{aarch64[1]}"
  end

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
end"""


def crates(target, features):
    """What is linked into the program, by cargo: our crate, and each package of others once, by name and version."""
    command = ["cargo", "metadata", "--locked", "--format-version=1", "--filter-platform", target, *features.split()]
    metadata = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    packages = {it["id"]: it for it in metadata["packages"]}
    nodes = {it["id"]: it["deps"] for it in metadata["resolve"]["nodes"]}
    [root] = [it for it in packages if packages[it]["name"] == "scanbench"]
    reached, to_visit = set(), [root]
    while to_visit:
        package = to_visit.pop()
        if package not in reached:
            reached.add(package)
            to_visit += [it["pkg"] for it in nodes[package] if any(kind["kind"] is None for kind in it["dep_kinds"])]
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
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text())["package"]
    checksums = {(it["name"], it["version"]): it["checksum"] for it in lock if "checksum" in it}

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

    head = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1}
    parts = {"metadata": {"component": component(own, "application")}, "components": [component(it) for it in others]}
    print(json.dumps(head | parts, indent=1))


def archive(folder, name):
    folder, time = Path(folder), os.environ["SOURCE_DATE_EPOCH"]
    same = ["--sort=name", f"--mtime=@{time}", "--owner=0", "--group=0", "--numeric-owner", "--mode=u=rwX,go=rX"]
    gzip = "--use-compress-program=gzip -9n"
    subprocess.run(["tar", *same, "--format=ustar", gzip, "-C", folder.parent, "-cf", name, folder.name], check=True)


def metadata(version):
    fields = [
        ("Metadata-Version", "2.4"),
        ("Name", PROJECT["name"]),
        ("Version", version),
        ("Summary", PROJECT["description"]),
        ("License-Expression", PROJECT["license"]["text"]),
        *(("License-File", it) for it in ("LICENSE", "LICENCES.txt")),
        *(("Classifier", it) for it in PROJECT["classifiers"]),
        ("Requires-Python", PROJECT["requires-python"]),
        *(("Requires-Dist", it) for it in PROJECT["dependencies"]),
    ]
    for extra, packages in PROJECT["optional-dependencies"].items():
        fields += [("Provides-Extra", extra), *(("Requires-Dist", f"{it} ; extra == '{extra}'") for it in packages)]
    head = "".join(f"{name}: {value}\n" for name, value in fields)
    return f"{head}Description-Content-Type: text/markdown\n\n{(PYTHON / PROJECT['readme']).read_text()}"


def wheel(folder, sbom, out):
    # Maturin, which makes the wheel from the source, would compile the program once more.
    folder = Path(folder)
    version, program = folder.name.split("-")[1], (folder / "scanbench").read_bytes()
    # What it runs on: the machine, and the newest version of GNU's C library that it asks for, at least 2.17.
    machine = {62: "x86_64", 183: "aarch64"}[int.from_bytes(program[18:20], "little")]
    minor = max([17, *(int(it) for it in re.findall(rb"\0GLIBC_2\.(\d+)", program))])
    name, info, tag = f"scanbench-{version}", f"scanbench-{version}.dist-info", f"py3-none-manylinux_2_{minor}_{machine}"
    written = {f"scanbench/{it.name}": it.read_bytes() for it in PYTHON.glob("src/scanbench/*") if it.is_file()}
    written |= {
        f"{name}.data/scripts/scanbench": program,
        f"{info}/METADATA": metadata(version).encode(),
        f"{info}/WHEEL": f"Wheel-Version: 1.0\nGenerator: pack.py\nRoot-Is-Purelib: false\nTag: {tag}\n".encode(),
        f"{info}/sboms/scanbench.cdx.json": Path(sbom).read_bytes(),
        **{f"{info}/licenses/{it}": (folder / it).read_bytes() for it in ("LICENSE", "LICENCES.txt")},
    }
    # Installers look at the end of the archive for what the wheel says of itself.
    written, record = dict(sorted(written.items(), key=lambda it: (it[0].startswith(info), it[0]))), ""
    for it, content in written.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{it},sha256={digest},{len(content)}\n"
    written[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    path, made_at = Path(out, f"{name}-{tag}.whl"), time.gmtime(int(os.environ["SOURCE_DATE_EPOCH"]))[:6]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as packed:
        for it, content in written.items():
            entry = zipfile.ZipInfo(it, made_at)
            entry.compress_type, entry.create_system = zipfile.ZIP_DEFLATED, 3
            entry.external_attr = (0o100755 if "/scripts/" in it else 0o100644) << 16
            packed.writestr(entry, content)
    print(path)


def sums(folder):
    for file in sorted(Path(folder).iterdir()):
        if file.is_file() and not file.name.startswith("SHA256SUMS"):
            print(f"{hashlib.sha256(file.read_bytes()).hexdigest()}  {file.name}")


def formula(listed, address):
    own = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]
    found = dict(reversed(line.split()) for line in Path(listed).read_text().splitlines())
    names = {it: f"scanbench-{own['version']}-{it}-unknown-linux-gnu.tar.gz" for it in ("x86_64", "aarch64")}
    archives = {machine: (f"{address}/{name}", found[name]) for machine, name in names.items()}
    words = {"description": PROJECT["description"].rstrip("."), "homepage": address.partition("/releases/")[0]}
    print(FORMULA.format(**words, **archives, version=own["version"], license=own["license"]))


if __name__ == "__main__":
    {it.__name__: it for it in (licences, sbom, archive, wheel, sums, formula)}[sys.argv[1]](*sys.argv[2:])
