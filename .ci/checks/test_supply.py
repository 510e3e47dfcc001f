"""Tests of what runs in other people's CI, and of where it comes from: `python3 -m unittest discover .ci/checks`."""

import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
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
