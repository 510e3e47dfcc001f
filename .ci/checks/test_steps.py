"""Tests of how steps are chosen and run: `python3 -m unittest discover .ci/checks`."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

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


if __name__ == "__main__":
    unittest.main()
