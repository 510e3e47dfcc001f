"""Tests of versions, of what a release is packed into, and of what runs in other people's CI."""

import json
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import unittest
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACK = [sys.executable, ROOT / ".ci/supply/pack.py"]
RELEASE = ROOT / ".ci/release"
COMMANDS = "harness/scanbench/src/commands"
INSTALLERS = (
    ".github/action/gate.sh",
    ".gitlab/gate.yml",
    f"{COMMANDS}/gate_workflow.yml",
    f"{COMMANDS}/init_template/.github/workflows/gate.yml",
)
SUM = "0123456789abcdef" * 4
PINNED = (
    "dist/scanbench-0.2.0-py3-none-linux_x86_64.whl",
    f"https://example.org/a/scanbench.whl#sha256={SUM}",
    "git+https://example.org/owner/scanbench@v0.2.0#subdirectory=harness/python",
)
LOOSE = (
    "scanbench",
    "scanbench==0.2.0",
    "--index-url=https://example.org/a.whl",
    "https://example.org/a/scanbench.whl",
    f"https://example.org/a/scanbench.whl#sha256={SUM[1:]}",
    f"http://example.org/a/scanbench.whl#sha256={SUM}",
    "git+https://example.org/owner/scanbench#subdirectory=harness/python",
    "git+https://me@example.org/owner/scanbench#subdirectory=harness/python",
)


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

    def test_a_formula_has_the_sum_of_each_archive(self):
        version = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
        archives = [f"scanbench-{version}-{it}-unknown-linux-gnu.tar.gz" for it in ("x86_64", "aarch64")]
        with tempfile.TemporaryDirectory() as scratch:
            lines = [f"{SUM}  {archives[0]}", f"{SUM[::-1]}  {archives[1]}", "0  scanbench.whl"]
            Path(scratch, "SHA256SUMS").write_text("\n".join(lines))
            address = "https://example.org/owner/scanbench/releases/download/v1"
            made = packed("formula", Path(scratch, "SHA256SUMS"), address)
        found = re.findall(r'url "(\S+)"\n    sha256 "(\w+)"', made)
        sums = (SUM, SUM[::-1])
        self.assertEqual(found, [(f"{address}/{name}", of) for name, of in zip(archives, sums, strict=True)])
        self.assertIn('homepage "https://example.org/owner/scanbench"\n', made)

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


def files(*patterns):
    listed = subprocess.run(["git", "ls-files", *patterns], cwd=ROOT, check=True, capture_output=True, text=True)
    return {name: (ROOT / name).read_text() for name in listed.stdout.splitlines()}


class Supply(unittest.TestCase):
    def test_what_is_installed_is_a_file_or_a_version_that_nobody_can_change(self):
        rules = {re.search(r"pinned='(.*)'", (ROOT / it).read_text())[1] for it in INSTALLERS}
        self.assertEqual(len(rules), 1, rules)
        for words, code in ((PINNED, 0), (LOOSE, 1)):
            for word in words:
                ended = subprocess.run(["bash", "-c", '[[ $2 =~ $1 ]]', "bash", *rules, word], check=False)
                self.assertEqual(ended.returncode, code, word)

    def test_pip_compares_the_checksum_of_an_address(self):
        with tempfile.TemporaryDirectory() as folder:
            wheel = Path(folder) / "a-1-py3-none-any.whl"
            with zipfile.ZipFile(wheel, "w") as archive:
                archive.writestr("a-1.dist-info/METADATA", "Metadata-Version: 2.1\nName: a\nVersion: 1\n")
                archive.writestr("a-1.dist-info/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
                archive.writestr("a-1.dist-info/RECORD", "")
            subprocess.run([sys.executable, "-m", "venv", f"{folder}/venv"], check=True)
            command = [f"{folder}/venv/bin/pip", "install", "--no-index", f"{wheel.as_uri()}#sha256={SUM}"]
            ended = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, 1)
        self.assertIn("DO NOT MATCH THE HASHES", ended.stderr)

    def test_actions_of_others_are_commits(self):
        used = {it for text in files("*.yml").values() for it in re.findall(r"uses: (\S+@.*)", text)}
        self.assertGreater(len(used), 3)
        for action in used:
            self.assertRegex(action, r"^[\w-]+/[\w./-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+$")
        self.assertEqual(len(used), len({it.split("@")[0] for it in used}), "one version of each")

    def test_the_image_is_built_from_a_list(self):
        first, *rest = [it for it in (ROOT / ".dockerignore").read_text().splitlines() if it[:1] not in ("#", "")]
        goes_in = {it[1:] for it in rest if it.startswith("!")}
        self.assertEqual(first, "*")
        self.assertEqual([it for it in goes_in if not (ROOT / it).exists()], [])
        members = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["members"]
        embedded = {
            (ROOT / name).parent.joinpath(path).resolve().relative_to(ROOT).parts[0]
            for name, text in files("*.rs").items()
            for path in re.findall(r'include_(?:str|bytes)!\("([^"]+)"\)', text)
        }
        self.assertLessEqual({it.split("/")[0] for it in members} | embedded, goes_in)


if __name__ == "__main__":
    unittest.main()
