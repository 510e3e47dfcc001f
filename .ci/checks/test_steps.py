"""Tests of how steps are chosen and run, and of the check of walk-throughs: `python3 -m unittest discover .ci/checks`."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from walkthroughs import run

PREAMBLE = Path(__file__).resolve().parents[1] / "preamble"
ENTRY = f"""source {PREAMBLE}
steps=("one   the first" "two-a   the second" "three   the third")
one() {{ touch "$scratch/one"; }}
two_a() {{
    false | cat
    echo never
}}
three() {{ ls "$scratch"; }}
run_steps "$@"
"""


class Steps(unittest.TestCase):
    def run_entry(self, *words, **environment):
        command = ["bash", "-c", ENTRY, "entry", *words]
        ended = subprocess.run(command, env=os.environ | environment, capture_output=True, text=True, check=False)
        return ended.returncode, ended.stdout, ended.stderr

    def test_the_first_step_that_fails_ends_the_run_and_is_named(self):
        code, printed, said = self.run_entry()
        self.assertEqual((code, said), (1, "== two-a: FAILED, exit code 1\n"))
        self.assertRegex(printed, r"\A\n== one   the first\n== one: \d+ s\n\n== two-a   the second\n\Z")

    def test_only_chosen_steps_are_run_and_others_are_refused(self):
        code, printed, _ = self.run_entry("three", "one")
        self.assertEqual((code, "== three: 0 s\n\n== one" in printed), (0, True))
        self.assertEqual(self.run_entry("three", "four"), (2, "", "there is no step four; there are one two-a three\n"))
        self.assertEqual(self.run_entry("--list"), (0, "one   the first\ntwo-a   the second\nthree   the third\n", ""))

    def test_what_steps_make_is_kept_on_demand_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(self.run_entry("one", KEEP=f"{folder}/kept", TMPDIR=folder)[0], 0)
            self.assertEqual(os.listdir(f"{folder}/kept"), ["one"])
            self.assertIn("\none\n", self.run_entry("one", "three", TMPDIR=folder)[1])
            self.assertEqual(os.listdir(folder), ["kept"])


class Walkthroughs(unittest.TestCase):
    def test_what_is_not_printed_and_what_fails_is_reported(self):
        for commands, lines, expected in (
            # Other spaces, and more, may be printed.
            ("printf 'a  row 1 2\\nof 3'", "a row 1 … of 3\nrow", []),
            ("echo a row", "a row\nanother", ["not printed: another\n"]),
            ("false | cat\necho never", "never", ["exit code 1"]),
        ):
            text = f"```sh\ntrue\n```\n\n```sh\n{commands}\n```\n\n```text\n{lines}\n```\n"
            with tempfile.TemporaryDirectory() as folder:
                found = run("page", text, folder, Path("/bin/true"))
            self.assertEqual([says in it for says, it in zip(expected, found, strict=True)], [True] * len(expected), found)


if __name__ == "__main__":
    unittest.main()
