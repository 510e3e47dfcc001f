"""Tests of the generated blocks: `python3 -m unittest discover .ci/blocks`."""

import json
import os
import tempfile
import unittest
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from unittest import mock

import docs
from blocks import Block, PageError, join, not_shown, split
from docs import Runner
from shows import SHOWS, CommandError, Result

PAGE = """# A page

```sh
cargo run --release -- gaps \\
  --pairs 3    # few
```

<!-- made by:
scanbench gaps --pairs 3
shows: picture gaps.svg gaps.svg 'who is separated'
-->

![who is separated](gaps.svg)

<!-- end: sources 00000000, content 11111111 -->

After `scanbench robustness` it ends.

<!-- made by:
scanbench robustness
shows: file robustness.md
-->
<!-- end -->
"""

NUMBER = {"metric": "recall", "value": 0.5, "unit": "ratio"}
MANIFEST = {"created": "today", "scoring_version": 7, "seeds": {"street": 1}}
GOLDEN = "reports/golden/run"
CHECKOUT = {
    "detector/src/cells.rs": "pub fn cells() {}\n",
    "detector/src/params/trees.model": "1",
    "detector/src/params/partial.model": "1",
    "detector/src/params/mod.rs": "pub mod bounds;\n",
    "baselines/src/params/params.toml": "tolerance_m = 0.5\n",
    "datasets.toml": "seed = 1\n",
    "harness/simulator/src/sensors/vlp-16.toml": "beams = 16\n",
    f"{GOLDEN}/manifest.json": json.dumps(MANIFEST),
    f"{GOLDEN}/report.json": json.dumps({"rows": [NUMBER, NUMBER | {"metric": "latency_p50_ms", "unit": "ms"}]}),
    f"{GOLDEN}/matches.csv": "scan,outcome\n0,matched\n",
    "docs/sweep.toml": "cells = 3\n",
    "docs/page.md": PAGE,
    "README.md": "# No blocks\n",
}
# Leaves what it was asked for.
PROGRAM = """#!/bin/sh
while [ $# -gt 0 ]; do [ "$1" = -o ] && out=$2; said="$said $1"; shift; done
mkdir -p "$out"; echo "made with$said" > "$out/robustness.md"; echo '<svg/>' > "$out/gaps.svg"
echo run >> "$COUNTED"
"""


def parts(text=PAGE):
    return split(Path("docs/page.md"), text)


def checkout(test):
    root = Path(test.enterContext(tempfile.TemporaryDirectory()))
    for path, text in CHECKOUT.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text)
    return root


class Pages(unittest.TestCase):
    def test_blocks_are_read_and_written_back(self):
        first, second = parts()[1::2]
        self.assertEqual(first.commands, ["scanbench gaps --pairs 3"])
        self.assertEqual(first.shows, ["picture", "gaps.svg", "gaps.svg", "who is separated"])
        self.assertEqual((first.line, first.sources, first.content), (8, "00000000", "11111111"))
        self.assertEqual((second.line, second.sources, second.content), (19, None, None))
        self.assertEqual(join(parts()), PAGE)

    def test_what_is_no_block_is_refused(self):
        for text in (
            PAGE.replace("<!-- end -->", ""),
            PAGE.replace("<!-- end: sources 00000000, content 11111111 -->", ""),
            PAGE.replace("shows: file robustness.md\n", ""),
            PAGE.replace("scanbench robustness\nshows", "shows"),
            PAGE + "<!-- end -->",
            PAGE.replace("content 11111111", "content"),
        ):
            with self.assertRaises(PageError):
                parts(text)

    def test_readers_are_shown_the_commands(self):
        loop = "cargo run --release -- gaps \\\n  --pairs 3    # few"
        for shell, hidden in [
            (loop, []),
            (loop.replace("3", "4"), ["scanbench gaps --pairs 3"]),
            ("for n in 2 3; do\n    scanbench gaps --pairs $n\ndone", []),
            ("gaps() { scanbench gaps \"$@\"; }\ngaps --pairs 3", []),
            ("scanbench gaps --pairs '3 3'", ["scanbench gaps --pairs 3"]),
            ("touch hidden > hidden\nscanbench gaps", ["scanbench gaps --pairs 3"]),
        ]:
            self.assertIn(loop, PAGE)
            self.assertEqual([it for _, it in not_shown(parts(PAGE.replace(loop, shell)))], hidden, shell)

    def test_only_what_decides_results_changes_the_stamp(self):
        root = checkout(self)
        plan = "scanbench run --plan docs/sweep.toml"
        stamp = lambda command=plan, shown="file": Block(Path(), 1, [command], [shown], "").sources_now(root)
        before = stamp()
        for path, text, is_changed in [
            ("detector/src/cells.rs", "pub fn squares() {}\n", False),
            (f"{GOLDEN}/manifest.json", json.dumps(MANIFEST | {"created": "now"}), False),
            (f"{GOLDEN}/report.json", json.dumps({"rows": [NUMBER]}), False),
            (f"{GOLDEN}/manifest.json", json.dumps(MANIFEST | {"seeds": {"street": 2}}), True),
            (f"{GOLDEN}/manifest.json", json.dumps(MANIFEST | {"scoring_version": 8}), True),
            (f"{GOLDEN}/report.json", json.dumps({"rows": [NUMBER | {"value": 0.6}]}), True),
            (f"{GOLDEN}/matches.csv", "scan,outcome\n0,missed\n", True),
            ("detector/src/params/trees.model", "2", True),
            ("detector/src/params/partial.model", "2", False),
            ("detector/src/params/mod.rs", "pub mod partial;\n", False),
            ("baselines/src/params/params.toml", "# In metres.\ntolerance_m  = 0.5\n", False),
            ("baselines/src/params/params.toml", "tolerance_m = 0.6\n", True),
            ("datasets.toml", "seed = 2\n", True),
            ("harness/simulator/src/sensors/vlp-16.toml", "beams = 32\n", True),
            ("docs/sweep.toml", "cells = 4\n", True),
        ]:
            (root / path).write_text(text)
            self.assertEqual(stamp() != before, is_changed, f"{path}: {text}")
            (root / path).write_text(CHECKOUT[path])
        self.assertEqual(len({before, stamp("scanbench run"), stamp(shown="picture")}), 3)


class Made(unittest.TestCase):
    def setUp(self):
        self.root, self.page = (root := checkout(self)), root / "docs/page.md"
        self.program, self.counted = root / "target/release/scanbench", root / "counted"
        self.program.parent.mkdir(parents=True)
        self.program.write_text(PROGRAM)
        self.program.chmod(0o755)
        environment = {"CARGO_TARGET_DIR": str(root / "target"), "COUNTED": str(self.counted)}
        self.enterContext(mock.patch.dict(os.environ, environment))
        os.environ.pop("SCANBENCH_TEST_DATA", None)

    def make(self):
        with redirect_stdout(StringIO()) as printed:
            code = docs.make_all(self.root, docs.pages(self.root, []), Runner(self.root), everything=True)
        return code, printed.getvalue()

    def check(self):
        with redirect_stdout(StringIO()) as printed, redirect_stderr(printed):
            code = docs.main(["--check"], self.root)
        return code, printed.getvalue()

    def test_the_check_fails_until_blocks_are_made_and_once_something_changes(self):
        code, printed = self.check()
        self.assertEqual(code, 1)
        self.assertIn("docs/page.md:19  file: scanbench robustness\n    never made\nSTALE: 2 of 2", printed)
        self.make()
        self.assertEqual(self.check(), (0, "All 2 generated blocks are of the accepted results.\n"))
        for path, before, after, why in [
            ("docs/page.md", "made with robustness", "made by hand", "edited by hand"),
            ("docs/gaps.svg", "<svg/>", "<svg></svg>", "edited by hand"),
            (f"{GOLDEN}/matches.csv", "matched", "missed", "of other results"),
        ]:
            text = (self.root / path).read_text()
            (self.root / path).write_text(text.replace(before, after))
            code, printed = self.check()
            self.assertEqual((code, why in printed), (1, True), f"{path}: {printed}")
            (self.root / path).write_text(text)
        self.assertEqual(self.check()[0], 0)
        self.page.write_text(PAGE.replace("shows: file", "shows: a-file"))
        self.assertEqual(self.check(), (2, "docs/page.md:19: cannot show 'a-file'\n"))

    def test_pages_are_written_and_results_kept_for_the_same_program(self):
        for program, n_runs in [(PROGRAM, 2), (PROGRAM, 2), (PROGRAM + "# Another one.\n", 4)]:
            self.program.write_text(program)
            self.assertEqual(self.make()[0], 0)
            self.assertEqual(len(self.counted.read_text().splitlines()), n_runs)
        self.assertIn("made with robustness", self.page.read_text())
        self.assertEqual((self.root / "docs/gaps.svg").read_text(), "<svg/>\n")

    def test_without_recorded_data_a_block_stays_as_it_is(self):
        self.page.write_text(PAGE.replace("scanbench robustness", "scanbench boxes ~/data/kitti"))
        code, printed = self.make()
        self.assertEqual(code, 0)
        self.assertIn("skipped, SCANBENCH_TEST_DATA names no folder of recorded data: docs/page.md:19", printed)
        self.assertNotIn("made with", self.page.read_text())
        os.environ["SCANBENCH_TEST_DATA"] = "/elsewhere"
        self.make()
        self.assertIn("made with boxes /elsewhere/data/kitti", self.page.read_text())

    def test_nothing_is_made_by_a_program_that_is_not_as_accepted(self):
        (self.root / ".ci").mkdir()
        (self.root / ".ci/preamble").write_text("accepted_run() { mkdir -p $1; }\n")
        (self.root / "reports/golden/tolerances.toml").write_text("[[quality]]\n\n[speed]\nrelative = 0.1\n")
        Runner(self.root).check_accepted()
        gate = '#!/bin/sh\ngrep -q speed "$6" && exit 2\n[ -d "$2" ] && echo "FAILED: results changed."; exit 101\n'
        self.program.write_text(gate)
        with self.assertRaisesRegex(CommandError, "not as it was accepted: FAILED: results changed"):
            Runner(self.root).check_accepted()

    def test_a_command_that_fails_leaves_its_block_and_the_others_are_made(self):
        failing = '#!/bin/sh\n[ $1 = robustness ] && { echo "no such sensor" >&2; exit 2; }\n'
        self.program.write_text(failing + PROGRAM)
        code, printed = self.make()
        self.assertEqual((code, "exit code 2: no such sensor" in printed), (1, True), printed)
        self.assertEqual([bool(it.sources) for it in parts(self.page.read_text())[1::2]], [True, False])

    def test_a_later_command_takes_what_an_earlier_one_left(self):
        commands = ["scanbench run streets -o model", "scanbench run streets -P vehicle_model.rivals_directory=model"]
        with redirect_stdout(StringIO()):
            results = Runner(self.root).run(commands)
        said = (results[1].directory / "robustness.md").read_text()
        self.assertIn(f'vehicle_model.rivals_directory="{results[0].directory}"', said)


READINGS = [
    {"basis": basis, "difference": difference, "holds": numbers != "1", "numbers": numbers, "reading": name}
    for name, basis, numbers, difference in [
        ("good faith", "text", "1", "-1"), ("with walls", "ours", "2", ""), ("by centre", "open", "3", "")]
]
CLAIM = {"readings": READINGS, "settings": [1, 9], "verdict": "holds_with_readings"}
CLAIMS = [CLAIM | {"claim": {"paper": paper, "printed": "83", "says": "It leads.", "test": {"kind": kind}}}
          for paper, kind in (("HG", "lead"), ("VM", "faster"))]
RATES = """source,dataset,detector,no,precision,recall,f_rate,f_rate_low,f_rate_high,fps_mean,few_blocks
measured,overall,grid,9,0.5,0.5,0.5,0.4,0.6,12.3,true
"""
RATES_SHOWN = "| grid | 50.0 | 40.0 to 60.0§ | 50.0 | 50.0 | 50.0 | 40.0 to 60.0§ | 50.0 | 50.0 | 12 |\n\n"
RATES_SHOWN += "Rates in %, of 9 annotated objects and 9 vehicles."
BY_DATASET = """source,dataset,origin,detector,no,recall,f_rate
measured,kitti,recorded,grid,{}\nmeasured,kitti,recorded,tree,{}
"""
COMPARED = """| task | detector | slice | metric | before | after | difference | 95 % | detectable |
| :-- |
| objects | grid | all | f_rate \\[%] | 1 | 2 | +0.47 | −0.24 to +1.17 | 1.12 |
| objects | pca | all | f_rate \\[%] | 1 | 2 | +0.00 | +0.00 to +0.00 | 1.12 |
"""
PAIRS = """| task | detector | slice | metric | difference | 95 % |
| :-- |
| objects | tree − grid | all | f_rate \\[%] | +1.00 | +0.50 to +1.50 |
| vehicles | tree − grid | all | f_rate \\[%] | −2.00 | −3.00 to −1.00 |
"""
FITNESS = "dataset,origin,sensor,task,no,rate,best_cell_size_m,best_rate,reading,recommended_cell_size_m,loss\n" + "".join(
    f"{dataset},simulated,vlp-16,objects,{no},F-rate,0.4,{rate},{reading},{size},{loss}\n"
    for dataset, no, rate in [("street", 3, 0.5), ("narrow", 4, 0.625)]
    for reading, size, loss in [("knuth", 2 * rate, 0.25), ("printed", "", ""), ("as configured", 0.6, rate / 10)]
)
GAPS = """detector,pair,layout,range_from_m,range_to_m,gap_m,n_seen,n_separated
grid,cars,beside,5.0,10.0,0.20,4,1\ngrid,bins,behind,5.0,10.0,0.20,4,3\ntree,cars,beside,5.0,10.0,0.20,4,0
tree,bins,behind,5.0,10.0,0.20,4,4\ngrid,cars,beside,5.0,10.0,0.30,4,4
"""
CONDITIONS = """group,condition,task,detector,f_rate
standard,dry,objects,grid,0.7000\nweather,rain,objects,grid,0.6000\nweather,hail,objects,grid,
standard,dry,objects,pca,0.7000
"""
ABLATION = """dataset,origin,variant,no,tp,fo
a,simulated,whole,10,8,2\nb,simulated,whole,30,12,18\nkitti,recorded,whole,4,3,\noverall,simulated,whole,44,23,20
"""
BOX_ERRORS = """by,slice,fit,error,n_pairs,value
all,,hull box,BEV IoU >= 0.7,9,46.04\nall,,hull box,yaw within 10 deg,9,70
all,,reported box,BEV IoU >= 0.7,9,85.4\nclass,bus,reported box,BEV IoU >= 0.7,0,
"""
REALISM = """statistic,bin,bin_from_m,bin_to_m,left,right,ratio
ring_density,5-6 m,5,6,street,kitti,1.4\nring_density,6-7 m,6,7,street,kitti,0.5
ring_density,60-61 m,60,61,street,kitti,9.0\nring_density,7-8 m,7,8,street,kitti,
"""
# What is shown: the words of `shows: …`, files that a command left, the lines that are shown at the end, or what is refused.
SHOWN = {
    "gaps are summed over kinds and layouts": ("gap-shares", {"gaps.csv": GAPS}, "| --: |\n| 5 to 10 | 0.2 | 8 | 50 | 50 |"),
    "the head of a file keeps its notes": (
        "file-head robustness.md 1", {"robustness.md": "**Rates.**\n\n| a |\n| :-- |\n| 1 |\n| 2 |\n\n- a: all\n"},
        "| a |\n| :-- |\n| 1 |\n\n- a: all"),
    "columns are left out of a file": (
        "file values.md b", {"values.md": "**V.**\n\n| a | b | c |\n| :-- | --: | --: |\n| 1 | 2 | 3 |\n\n- a: all"},
        "**V.**\n\n| a | c |\n| :-- | --: |\n| 1 | 3 |\n\n- a: all"),
    "a claim has its first reading, and the one that it rests on": (
        "claims HG", {"reproduction.json": json.dumps({"claims": CLAIMS})},
        "1 claims (holds with readings: 1).\n\n| claim | printed | here | verdict |\n| :-- | :-- | :-- | :-- |\n"
        "| It leads. | 83 | 1; -1 | holds with readings (by centre); 1 of 9 settings |"),
    "a claim about speed has all its readings": (
        "claims VM", {"reproduction.json": json.dumps({"claims": CLAIMS})},
        "| It leads. | 83 | 1; -1; with walls: ; by centre:  | holds with readings (by centre); 1 of 9 settings |"),
    "changes are against the first condition": (
        "condition-changes grid", {"robustness.csv": CONDITIONS},
        "| --: |\n| weather | rain | −10.0 |\n| weather | hail | – |"),
    "counts are summed before a ratio is taken": (
        "ablation-rates", {"ablation.csv": ABLATION},
        "| whole | 50.0 | 75.0 |\n\n40 simulated annotations, 4 recorded ones."),
    "what changed nowhere is zero": (
        "compared-runs completion", {"printed": COMPARED}, "| completion | objects | +0.47 (−0.24 to +1.17) | 0 |"),
    "each comparison has a name": (
        "compared-runs completion regrouping", {"printed": COMPARED}, CommandError("2 names for 1 comparisons")),
    "intervals of few blocks are flagged": (
        "overall-rates", {"table_objects.csv": RATES, "table_vehicles.csv": RATES},
        f"{RATES_SHOWN}\n\n§ from fewer than ten blocks of scans: too few for a reliable interval."),
    "intervals of many blocks are not": (
        "overall-rates", {f"table_{it}.csv": RATES.replace("true", "false") for it in ("objects", "vehicles")},
        RATES_SHOWN.replace("§", "")),
    "where nothing can be false a rate is recall": (
        "rates-by-dataset objects vehicles",
        {"table_objects.csv": BY_DATASET.format("9,0.5,", "9,0.6,"),
         "table_vehicles.csv": BY_DATASET.format("8,0.5,0.7", "8,0.6,0.8")},
        "| --: |\n| kitti, recall of 9 objects | 50.0 | 60.0 |\n| kitti, 8 vehicles | 70.0 | 80.0 |"),
    "an interval is that of the rate that is shown": (
        "rates-with-intervals objects",
        {"table_objects.csv": "source,dataset,detector,n_scans,no,recall,f_rate,recall_low,recall_high,f_rate_low,f_rate_high,few_blocks\n"
         "measured,kitti,grid,3,9,0.5,,0.4,0.6,,,true\nmeasured,overall,grid,3,9,0.5,0.7,0.4,0.6,0.65,0.75,false\n"},
        "| --: |\n| kitti, recall | 3 | 9 | 50.0 (40.0 to 60.0)§ |\n| all | 3 | 9 | 70.0 (65.0 to 75.0) |"
        "\n\n§ from fewer than ten blocks of scans: too few for a reliable interval."),
    "a pair of detectors has both tasks in a row": (
        "compared-detectors", {"printed": PAIRS}, "| tree − grid | +1.00 | +0.50 to +1.50 | −2.00 | −3.00 to −1.00 |"),
    "slices have the right box of two kinds": (
        "box-slices", {"box_errors.csv": BOX_ERRORS}, "| --: |\n| all | 9 | 46.0 | 85.4 |"),
    "data sets of a sensor share a row": (
        "fitness-by-sensor objects", {"cell_fitness.csv": FITNESS},
        "| --: |\n| vlp-16 | 7 | 0.4 | 50.0 to 62.5 | 1.0 to 1.2 | 25.0 | 5.0 to 6.2 |"),
    "alike is within a factor either way": (
        "realism-agreement", {"realism.csv": REALISM}, "| street | kitti | – | – | 50 %, 0.50 | – | – | – | – | – | – | – |"),
    "a missing file is named": ("gap-shares", {}, CommandError("scanbench compare a b left no gaps.csv")),
}  # fmt: skip


class Shown(unittest.TestCase):
    def test_what_blocks_show(self):
        for name, (words, files, expected) in SHOWN.items():
            show, *arguments = words.split()
            folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
            for file, text in files.items():
                (folder / file).write_text(text)
            of_pairs = [Result("scanbench run", folder, "")] * (show == "compared-detectors")
            results = [*of_pairs, Result("scanbench compare a b", folder, files.get("printed", ""))]
            with self.subTest(name):
                if isinstance(expected, CommandError):
                    self.assertRaisesRegex(CommandError, str(expected), SHOWS[show], results, *arguments)
                else:
                    self.assertEqual(SHOWS[show](results, *arguments)[-len(expected) :], expected)


if __name__ == "__main__":
    unittest.main()
