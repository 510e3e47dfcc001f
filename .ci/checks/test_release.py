"""Tests of versions and of what a release is packed into: `python3 -m unittest discover .ci/checks`."""

import json
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACK = [sys.executable, ROOT / ".ci/supply/pack.py"]
RELEASE = ROOT / ".ci/release"


def packed(*arguments, **environment):
    command = [*PACK, *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, env=os.environ | environment, check=True, capture_output=True, text=True).stdout


def tagged():
    return subprocess.run(["git", "tag", "--points-at", "HEAD"], cwd=ROOT, check=True, capture_output=True).stdout


class Release(unittest.TestCase):
    def test_versions_agree(self):
        workspace = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]
        version, rust = workspace["package"]["version"], workspace["package"]["rust-version"]
        for member in workspace["members"]:
            package = tomllib.loads((ROOT / member / "Cargo.toml").read_text())["package"]
            self.assertTrue(package["version"]["workspace"] and package["rust-version"]["workspace"], member)
        self.assertIn("version", tomllib.loads((ROOT / "harness/python/pyproject.toml").read_text())["project"]["dynamic"])
        stated = {
            "CITATION.cff": (rf"^version: {version}$", 1),
            "CHANGELOG.md": (rf"^## {version} \(\d{{4}}-\d\d-\d\d\)$", 1),
            "docs/citing.md": (rf"scanbench {version},|version = \{{{version}\}},", 2),
            "Cargo.lock": (rf'^name = "scanbench"\nversion = "{version}"$', 1),
            # The compiler that all checks are made with is the oldest one.
            "rust-toolchain.toml": (rf'^channel = "{rust}\.0"$', 1),
            "Dockerfile": (rf"^FROM rust:{rust}-", 1),
            "README.md": (rf"\bRust\]\(\S+\) {rust}\b", 1),
        }
        for file, (pattern, n) in stated.items():
            self.assertEqual(len(re.findall(pattern, (ROOT / file).read_text(), re.MULTILINE)), n, f"{file}: {pattern}")

    def test_an_archive_has_the_same_bytes_whatever_the_folder(self):
        with tempfile.TemporaryDirectory() as scratch:
            archives = []
            for index, mode in enumerate((0o600, 0o664)):
                folder = Path(scratch, str(index), "scanbench-1")
                (folder / "man").mkdir(parents=True)
                for name in ("b", "a")[:: 1 - 2 * index]:
                    (folder / "man" / name).write_text(name)
                    (folder / "man" / name).chmod(mode)
                (folder / "scanbench").write_text("#!")
                (folder / "scanbench").chmod(0o700)
                archives.append(Path(scratch, f"{index}.tar.gz"))
                packed("archive", folder, archives[-1], SOURCE_DATE_EPOCH="1000")
            self.assertEqual(*(it.read_bytes() for it in archives))
            with tarfile.open(archives[0]) as tar:
                entries = [(it.name, it.mode, it.mtime) for it in tar]
            names = ["", "/man", "/man/a", "/man/b", "/scanbench"]
            modes = [0o755, 0o755, 0o644, 0o644, 0o755]
            self.assertEqual(entries, [(f"scanbench-1{it}", mode, 1000) for it, mode in zip(names, modes, strict=True)])
            Path(scratch, "SHA256SUMS").touch()
            Path(scratch, "SHA256SUMS").write_text(packed("sums", scratch))
            subprocess.run(["sha256sum", "--check", "--strict", "--quiet", "SHA256SUMS"], cwd=scratch, check=True)

    def test_a_wheel_has_program_and_package_and_says_which_c_library_it_needs(self):
        with tempfile.TemporaryDirectory() as scratch:
            wheels = []
            for index in range(2):
                folder = Path(scratch, str(index), "scanbench-1.2-any")
                folder.mkdir(parents=True)
                for name in ("LICENSE", "LICENCES.txt", "sbom"):
                    (folder / name).write_text(name)
                elf = b"\x7fELF" + 14 * b"\0" + (62).to_bytes(2, "little")
                elf += b"\0GLIBC_2.2.5\0GLIBC_2.28\0libc.so.6\0GLIBC_2.9\0"
                (folder / "scanbench").write_bytes(elf)
                place = packed("wheel", folder, folder / "sbom", folder.parent, SOURCE_DATE_EPOCH="1000000000")
                wheels.append(Path(place.strip()))
                self.assertEqual(wheels[-1].name, "scanbench-1.2-py3-none-manylinux_2_28_x86_64.whl")
            self.assertEqual(*(it.read_bytes() for it in wheels))
            pip = [sys.executable, "-m", "pip", "install", "--quiet", "--root-user-action=ignore"]
            subprocess.run([*pip, "--no-index", "--no-deps", "--target", scratch, wheels[0]], check=True)
            self.assertEqual(Path(scratch, "bin/scanbench").read_bytes(), elf)
            self.assertTrue(os.access(Path(scratch, "bin/scanbench"), os.X_OK))
            sources = {it.name for it in (ROOT / "harness/python/src/scanbench").iterdir() if it.is_file()}
            self.assertLessEqual(sources, {it.name for it in Path(scratch, "scanbench").iterdir()})
            stated = Path(scratch, "scanbench-1.2.dist-info/METADATA").read_text()
            self.assertIn("\nRequires-Dist: numpy>=1.24\n", stated)

    def test_what_is_compiled_in_is_listed_with_licences_and_checksums(self):
        target = "x86_64-unknown-linux-gnu"
        bom = json.loads(packed("sbom", target, ""))
        components = {it["name"]: it for it in bom["components"]}
        self.assertIn("re_sdk", components)
        # Tests alone use it, and it is ours.
        self.assertTrue(components.keys().isdisjoint({"proptest", "detector", "insta"}))
        self.assertTrue(all(it["hashes"] for it in bom["components"]))
        self.assertEqual([it["name"] for it in bom["components"] if "licenses" not in it], ["forust-ml"])
        without = {it["name"] for it in json.loads(packed("sbom", target, "--no-default-features"))["components"]}
        self.assertNotIn("re_sdk", without)
        self.assertIn("clap", without)
        listed = packed("licences", target, "--no-default-features")
        for name in without:
            self.assertRegex(listed, rf"(?m)^{name} \d\S*: \S")
        self.assertIn("Apache License", listed)

    def test_two_builds_are_compared_byte_by_byte(self):
        with tempfile.TemporaryDirectory() as scratch:
            compiler = Path(scratch, "compiler")
            for written, code in (("$RUSTFLAGS", 1), ("${RUSTFLAGS##*=}", 0)):
                compiler.write_text(
                    "#!/bin/bash\n[[ \"$*\" == '--release --locked --target some-linux' ]] || exit 3\n"
                    f'mkdir -p $CARGO_TARGET_DIR/some-linux/release\necho "{written}" > $CARGO_TARGET_DIR/some-linux/release/scanbench\n'
                )
                compiler.chmod(0o755)
                environment = os.environ | {"CARGO_TARGET_DIR": scratch, "TARGET": "some-linux", "BUILD": str(compiler)}
                command = [RELEASE, "--rehearse", "program", "again"]
                ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
                self.assertEqual((ended.returncode, "differ" in ended.stdout), (code, code == 1), ended)

    def test_a_tag_of_another_version_is_no_release(self):
        for words, code, said in (
            (["v0.0.1", "version"], 1, "not a release: Cargo.toml has version "),
            (["--rehearse", "version"], 0, "not a release: no tag v" if not tagged() else ""),
            (["0.2.0"], 2, ""),
            ([], 2, ""),
        ):
            ended = subprocess.run([RELEASE, *words], capture_output=True, text=True, check=False)
            self.assertEqual((ended.returncode, said in ended.stdout), (code, True), ended)


if __name__ == "__main__":
    unittest.main()
