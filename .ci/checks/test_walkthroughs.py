"""Tests of what the check of walk-throughs sees: `python3 -m unittest discover .ci/checks`."""

import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from walkthroughs import run


class Walkthroughs(unittest.TestCase):
    def problems(self, commands, lines):
        with tempfile.TemporaryDirectory() as folder:
            text = f"```sh\ntrue\n```\n\n```sh\n{commands}\n```\n\n```text\n{lines}\n```\n"
            return run("page", text, folder, Path("/bin/true"))

    def test_what_is_printed_may_have_other_spaces_and_more(self):
        self.assertEqual(self.problems("printf 'a  row 1 2\\nof 3'", "a row 1 … of 3\nrow"), [])

    def test_what_is_not_printed_by_this_block_is_told(self):
        [told] = self.problems("echo a row", "a row\nanother")
        self.assertIn("not printed: another\n", told)

    def test_a_command_that_fails_is_told(self):
        [told] = self.problems("false | cat\necho never", "never")
        self.assertIn("exit code 1", told)
