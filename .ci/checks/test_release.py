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
RELEASE = ROOT / ".ci/release"
COMMANDS = "harness/scanbench/src/verbs"
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
WORKSPACE = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]
VERSION, RUST = WORKSPACE["package"]["version"], WORKSPACE["package"]["rust-version"]
# How often each file states the version.
STATED = {
    "CITATION.cff": (rf"^version: {VERSION}$", 1),
    "CHANGELOG.md": (rf"^## {VERSION} \(\d{{4}}-\d\d-\d\d\)$", 1),
    "docs/citing.md": (rf"scanbench {VERSION},|version = \{{{VERSION}\}},", 2),
    "Cargo.lock": (rf'^name = "scanbench"\nversion = "{VERSION}"$', 1),
    # The compiler that all checks are made with is the oldest one.
    "rust-toolchain.toml": (rf'^channel = "{RUST}\.0"$', 1),
    "Dockerfile": (rf"^FROM rust:{RUST}-", 1),
    "README.md": (rf"\bRust\]\(\S+\) {RUST}\b", 1),
}


def run(*command, **environment):
    return subprocess.run(command, cwd=ROOT, env=os.environ | environment, capture_output=True, text=True, check=False)


def packed(*arguments, **environment):
    ended = run(sys.executable, ROOT / ".ci/supply/pack.py", *arguments, **environment)
    assert ended.returncode == 0, ended
    return ended.stdout


def files(*patterns):
    return {name: (ROOT / name).read_text() for name in run("git", "ls-files", *patterns).stdout.splitlines()}


class Release(unittest.TestCase):
    def setUp(self):
        self.scratch = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def test_versions_agree(self):
        for member in WORKSPACE["members"]:
            package = tomllib.loads((ROOT / member / "Cargo.toml").read_text())["package"]
            self.assertTrue(package["version"]["workspace"] and package["rust-version"]["workspace"], member)
        self.assertIn("version", tomllib.loads((ROOT / "harness/python/pyproject.toml").read_text())["project"]["dynamic"])
        for file, (pattern, n) in STATED.items():
            self.assertEqual(len(re.findall(pattern, (ROOT / file).read_text(), re.MULTILINE)), n, f"{file}: {pattern}")

    def test_an_archive_has_the_same_bytes_whatever_the_folder(self):
        archives = []
        for index, mode in enumerate((0o600, 0o664)):
            folder = self.scratch / str(index) / "scanbench-1"
            (folder / "man").mkdir(parents=True)
            for name, of_file in [("man/b", mode), ("man/a", mode), ("scanbench", 0o700)][:: 1 - 2 * index]:
                (folder / name).write_text(name)
                (folder / name).chmod(of_file)
            archives.append(self.scratch / f"{index}.tar.gz")
            packed("archive", folder, archives[-1], SOURCE_DATE_EPOCH="1000")
        self.assertEqual(*(it.read_bytes() for it in archives))
        with tarfile.open(archives[0]) as tar:
            entries = [(it.name.removeprefix("scanbench-1"), it.mode, it.mtime) for it in tar]
        modes = {"": 0o755, "/man": 0o755, "/man/a": 0o644, "/man/b": 0o644, "/scanbench": 0o755}
        self.assertEqual(entries, [(name, mode, 1000) for name, mode in modes.items()])
        (self.scratch / "SHA256SUMS").touch()
        (self.scratch / "SHA256SUMS").write_text(packed("sums", self.scratch))
        subprocess.run(["sha256sum", "--check", "--strict", "--quiet", "SHA256SUMS"], cwd=self.scratch, check=True)

    def test_a_formula_has_the_sum_of_each_archive(self):
        archives = [f"scanbench-{VERSION}-{it}-unknown-linux-gnu.tar.gz" for it in ("x86_64", "aarch64")]
        (self.scratch / "sums").write_text(f"{SUM}  {archives[0]}\n{SUM[::-1]}  {archives[1]}\n0  scanbench.whl\n")
        address = "https://example.org/owner/scanbench/releases/download/v1"
        made = packed("formula", self.scratch / "sums", address)
        found = re.findall(r'url "(\S+)"\n    sha256 "(\w+)"', made)
        self.assertEqual(found, [(f"{address}/{archives[0]}", SUM), (f"{address}/{archives[1]}", SUM[::-1])])
        self.assertIn('homepage "https://example.org/owner/scanbench"\n', made)

    def test_a_wheel_has_program_and_package_and_says_which_c_library_it_needs(self):
        elf = b"\x7fELF" + 14 * b"\0" + (62).to_bytes(2, "little")
        elf += b"\0GLIBC_2.2.5\0GLIBC_2.28\0libc.so.6\0GLIBC_2.9\0"
        wheels = []
        for index in range(2):
            folder = self.scratch / str(index) / "scanbench-1.2-any"
            folder.mkdir(parents=True)
            for name in ("LICENSE", "LICENCES.txt", "sbom"):
                (folder / name).write_text(name)
            (folder / "scanbench").write_bytes(elf)
            place = packed("wheel", folder, folder / "sbom", folder.parent, SOURCE_DATE_EPOCH="1000000000")
            wheels.append(Path(place.strip()))
            self.assertEqual(wheels[-1].name, "scanbench-1.2-py3-none-manylinux_2_28_x86_64.whl")
        self.assertEqual(*(it.read_bytes() for it in wheels))
        pip = [sys.executable, "-m", "pip", "install", "--quiet", "--root-user-action=ignore"]
        subprocess.run([*pip, "--no-index", "--no-deps", "--target", self.scratch, wheels[0]], check=True)
        installed = self.scratch / "bin/scanbench"
        self.assertEqual((installed.read_bytes(), os.access(installed, os.X_OK)), (elf, True))
        sources = {it.name for it in (ROOT / "harness/python/src/scanbench").iterdir() if it.is_file()}
        self.assertLessEqual(sources, {it.name for it in (self.scratch / "scanbench").iterdir()})
        stated = (self.scratch / "scanbench-1.2.dist-info/METADATA").read_text()
        self.assertIn("\nRequires-Dist: numpy>=1.24\n", stated)

    def test_what_is_compiled_in_is_listed_with_licences_and_checksums(self):
        target = "x86_64-unknown-linux-gnu"
        components = {it["name"]: it for it in json.loads(packed("sbom", target, ""))["components"]}
        self.assertIn("re_sdk", components)
        # Tests alone use it, and it is ours.
        self.assertTrue(components.keys().isdisjoint({"proptest", "detector", "insta"}))
        self.assertTrue(all(it["hashes"] for it in components.values()))
        self.assertEqual([name for name, it in components.items() if "licenses" not in it], ["forust-ml"])
        without = {it["name"] for it in json.loads(packed("sbom", target, "--no-default-features"))["components"]}
        self.assertNotIn("re_sdk", without)
        self.assertIn("clap", without)
        listed = packed("licences", target, "--no-default-features")
        for name in without:
            self.assertRegex(listed, rf"(?m)^{name} \d\S*: \S")
        self.assertIn("Apache License", listed)

    def test_two_builds_are_compared_byte_by_byte(self):
        compiler = self.scratch / "compiler"
        for written, code in (("$RUSTFLAGS", 1), ("${RUSTFLAGS##*=}", 0)):
            compiler.write_text(
                "#!/bin/bash\n[[ \"$*\" == '--release --locked --target some-linux' ]] || exit 3\n"
                f'made=$CARGO_TARGET_DIR/some-linux/release\nmkdir -p "$made"\necho "{written}" > "$made/scanbench"\n'
            )
            compiler.chmod(0o755)
            environment = {"CARGO_TARGET_DIR": str(self.scratch), "TARGET": "some-linux", "BUILD": str(compiler)}
            ended = run(RELEASE, "--rehearse", "program", "again", **environment)
            self.assertEqual((ended.returncode, "differ" in ended.stdout), (code, code == 1), ended)

    def test_a_tag_of_another_version_is_no_release(self):
        is_tagged = run("git", "tag", "--points-at", "HEAD").stdout
        for words, code, said in (
            (["v0.0.1", "version"], 1, "not a release: Cargo.toml has version "),
            (["--rehearse", "version"], 0, "not a release: no tag v" if not is_tagged else ""),
            (["0.2.0"], 2, ""),
            ([], 2, ""),
        ):
            ended = run(RELEASE, *words)
            self.assertEqual((ended.returncode, said in ended.stdout), (code, True), ended)

    def test_what_is_installed_is_a_file_or_a_version_that_nobody_can_change(self):
        rules = {re.search(r"pinned='(.*)'", (ROOT / it).read_text())[1] for it in INSTALLERS}
        self.assertEqual(len(rules), 1, rules)
        for word in PINNED + LOOSE:
            code = run("bash", "-c", "[[ $2 =~ $1 ]]", "bash", *rules, word).returncode
            self.assertEqual(code, int(word in LOOSE), word)

    def test_pip_compares_the_checksum_of_an_address(self):
        wheel = self.scratch / "a-1-py3-none-any.whl"
        with zipfile.ZipFile(wheel, "w") as archive:
            archive.writestr("a-1.dist-info/METADATA", "Metadata-Version: 2.1\nName: a\nVersion: 1\n")
            archive.writestr("a-1.dist-info/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
            archive.writestr("a-1.dist-info/RECORD", "")
        subprocess.run([sys.executable, "-m", "venv", self.scratch / "venv"], check=True)
        ended = run(self.scratch / "venv/bin/pip", "install", "--no-index", f"{wheel.as_uri()}#sha256={SUM}")
        self.assertEqual((ended.returncode, "DO NOT MATCH THE HASHES" in ended.stderr), (1, True), ended)

    def test_actions_of_others_are_commits(self):
        used = {it for text in files("*.yml").values() for it in re.findall(r"uses: (\S+@.*)", text)}
        self.assertGreater(len(used), 3)
        for action in used:
            self.assertRegex(action, r"^[\w-]+/[\w./-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+$")
        self.assertEqual(len(used), len({it.split("@")[0] for it in used}), "one version of each")

    def test_the_image_is_built_from_a_list(self):
        first, *rest = [it for it in (ROOT / ".dockerignore").read_text().splitlines() if it[:1] not in ("#", "")]
        goes_in = {it[1:] for it in rest if it.startswith("!")}
        self.assertEqual((first, [it for it in goes_in if not (ROOT / it).exists()]), ("*", []))
        embedded = {
            (ROOT / name).parent.joinpath(path).resolve().relative_to(ROOT).parts[0]
            for name, text in files("*.rs").items()
            for path in re.findall(r'include_(?:str|bytes)!\("([^"]+)"\)', text)
        }
        self.assertLessEqual({it.split("/")[0] for it in WORKSPACE["members"]} | embedded, goes_in)


if __name__ == "__main__":
    unittest.main()
