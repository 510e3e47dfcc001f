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
import shows
from commands import CommandError, Result, Runner, tiny
from page import PageError, join, not_shown, split
from stamp import sources

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
CHECKOUT = {
    "detector/src/cells.rs": "pub fn cells() {}\n",
    "detector/src/params/trees.model": "1",
    "detector/src/params/partial.model": "1",
    "baselines/src/params/params.toml": "tolerance_m = 0.5\n",
    "datasets.toml": "seed = 1\n",
    "harness/simulator/src/sensors/vlp-16.toml": "beams = 16\n",
    "reports/golden/run/manifest.json": json.dumps(MANIFEST),
    "reports/golden/run/report.json": json.dumps({"rows": [NUMBER, NUMBER | {"metric": "latency_p50_ms", "unit": "ms"}]}),
    "reports/golden/run/matches.csv": "scan,outcome\n0,matched\n",
    "docs/sweep.toml": "cells = 3\n",
    "docs/page.md": PAGE,
    "README.md": "# No blocks\n",
}


def blocks(text=PAGE):
    return split(Path("docs/page.md"), text)[1::2]


def scratch(test):
    return Path(test.enterContext(tempfile.TemporaryDirectory()))


def checkout(test):
    root = scratch(test)
    for path, text in CHECKOUT.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text)
    return root


class Pages(unittest.TestCase):
    def test_blocks_are_read_and_written_back(self):
        first, second = blocks()
        self.assertEqual(first.commands, ["scanbench gaps --pairs 3"])
        self.assertEqual(first.shows, ["picture", "gaps.svg", "gaps.svg", "who is separated"])
        self.assertEqual((first.line, first.sources, first.content), (8, "00000000", "11111111"))
        self.assertEqual((second.line, second.sources, second.content), (19, None, None))
        self.assertEqual(join(split(Path("docs/page.md"), PAGE)), PAGE)

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
                blocks(text)

    def test_readers_are_shown_the_commands(self):
        self.assertEqual(not_shown(split(Path("a.md"), PAGE)), [])
        hidden = [it for _, it in not_shown(split(Path("a.md"), PAGE.replace("--pairs 3  ", "--pairs 4  ")))]
        self.assertEqual(hidden, ["scanbench gaps --pairs 3"])
        loop = "cargo run --release -- gaps \\\n  --pairs 3    # few"
        for shell, is_shown in [
            ("for n in 2 3; do\n    scanbench gaps --pairs $n\ndone", True),
            ("gaps() { scanbench gaps \"$@\"; }\ngaps --pairs 3", True),
            ("scanbench gaps --pairs '3 3'", False),
            ("touch hidden > hidden\nscanbench gaps", False),
        ]:
            page = PAGE.replace(loop, shell)
            self.assertNotEqual(page, PAGE)
            self.assertEqual(not_shown(split(Path("a.md"), page)) == [], is_shown, shell)


class Stamps(unittest.TestCase):
    def test_only_what_decides_results_changes_the_stamp(self):
        root, golden = checkout(self), "reports/golden/run"
        stamp = lambda command="scanbench run --plan docs/sweep.toml", shown="file": sources(root, [command], [shown])
        before = stamp()
        for path, text, is_changed in [
            ("detector/src/cells.rs", "pub fn squares() {}\n", False),
            (f"{golden}/manifest.json", json.dumps(MANIFEST | {"created": "now"}), False),
            (f"{golden}/report.json", json.dumps({"rows": [NUMBER]}), False),
            (f"{golden}/manifest.json", json.dumps(MANIFEST | {"seeds": {"street": 2}}), True),
            (f"{golden}/manifest.json", json.dumps(MANIFEST | {"scoring_version": 8}), True),
            (f"{golden}/report.json", json.dumps({"rows": [NUMBER | {"value": 0.6}]}), True),
            (f"{golden}/matches.csv", "scan,outcome\n0,missed\n", True),
            ("detector/src/params/trees.model", "2", True),
            ("detector/src/params/partial.model", "2", False),
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
    """Blocks made by a program that leaves what it was asked for."""

    PROGRAM = """#!/bin/sh
while [ $# -gt 0 ]; do [ "$1" = -o ] && out=$2; said="$said $1"; shift; done
mkdir -p "$out"; echo "made with$said" > "$out/robustness.md"; echo '<svg/>' > "$out/gaps.svg"
echo run >> "$COUNTED"
"""

    def setUp(self):
        self.root = checkout(self)
        target = scratch(self)
        self.program = target / "release" / "scanbench"
        self.program.parent.mkdir()
        self.program.write_text(self.PROGRAM)
        self.program.chmod(0o755)
        self.counted = target / "counted"
        patched = mock.patch.dict(os.environ, {"CARGO_TARGET_DIR": str(target), "COUNTED": str(self.counted)})
        patched.start()
        self.addCleanup(patched.stop)
        os.environ.pop("SCANBENCH_TEST_DATA", None)

    def make(self, tiny=False):
        with redirect_stdout(StringIO()) as printed:
            pages, runner = docs.pages(self.root, []), Runner(self.root, tiny=tiny)
            code = docs.make_all(self.root, self.root, pages, runner, everything=True)
        return code, printed.getvalue()

    def check(self):
        with redirect_stdout(StringIO()) as printed, redirect_stderr(printed):
            code = docs.main(["--check"], self.root)
        return code, printed.getvalue()

    def n_runs(self):
        return len(self.counted.read_text().splitlines())

    def test_the_check_fails_until_blocks_are_made_and_once_something_changes(self):
        code, printed = self.check()
        self.assertEqual(code, 1)
        self.assertIn("docs/page.md:19  file: scanbench robustness\n    never made\nSTALE: 2 of 2", printed)
        self.make()
        self.assertEqual(self.check(), (0, "All 2 generated blocks are of the accepted results.\n"))
        for path, before, after, why in [
            ("docs/page.md", "made with robustness", "made by hand", "edited by hand"),
            ("docs/gaps.svg", "<svg/>", "<svg></svg>", "edited by hand"),
            ("reports/golden/run/matches.csv", "matched", "missed", "of other results"),
        ]:
            text = (self.root / path).read_text()
            (self.root / path).write_text(text.replace(before, after))
            code, printed = self.check()
            self.assertEqual((code, why in printed), (1, True), f"{path}: {printed}")
            (self.root / path).write_text(text)
        self.assertEqual(self.check()[0], 0)
        (self.root / "docs/page.md").write_text(PAGE.replace("shows: file", "shows: a-file"))
        self.assertEqual(self.check(), (2, "docs/page.md:19: cannot show 'a-file'\n"))

    def test_pages_are_written_and_results_kept_for_the_same_program(self):
        self.assertEqual(self.make()[0], 0)
        self.assertIn("made with robustness", (self.root / "docs/page.md").read_text())
        self.assertEqual((self.root / "docs/gaps.svg").read_text(), "<svg/>\n")
        self.make()
        self.assertEqual(self.n_runs(), 2)
        self.program.write_text(self.PROGRAM + "# Another one.\n")
        self.make()
        self.assertEqual(self.n_runs(), 4)

    def test_without_recorded_data_a_block_stays_as_it_is(self):
        (self.root / "docs/page.md").write_text(PAGE.replace("scanbench robustness", "scanbench boxes ~/data/kitti"))
        code, printed = self.make()
        self.assertEqual(code, 0)
        self.assertIn("skipped, SCANBENCH_TEST_DATA names no folder of recorded data: docs/page.md:19", printed)
        self.assertNotIn("made with", (self.root / "docs/page.md").read_text())
        os.environ["SCANBENCH_TEST_DATA"] = "/elsewhere"
        self.make()
        self.assertIn("made with boxes /elsewhere/data/kitti", (self.root / "docs/page.md").read_text())

    def test_nothing_is_made_by_a_program_that_is_not_as_accepted(self):
        (self.root / ".ci").mkdir()
        (self.root / ".ci/preamble").write_text("accepted_run() { mkdir -p $1; }\n")
        (self.root / "reports/golden/tolerances.toml").write_text("[[quality]]\n\n[speed]\nrelative = 0.1\n")
        runner = Runner(self.root, tiny=False)
        runner.check_accepted()
        gate = '#!/bin/sh\ngrep -q speed "$6" && exit 2\n[ -d "$2" ] && echo "FAILED: results changed."; exit 101\n'
        self.program.write_text(gate)
        with self.assertRaisesRegex(CommandError, "not as it was accepted: FAILED: results changed"):
            runner.check_accepted()

    def test_a_command_that_fails_leaves_its_block_and_the_others_are_made(self):
        failing = '#!/bin/sh\n[ $1 = robustness ] && { echo "no such sensor" >&2; exit 2; }\n'
        self.program.write_text(failing + self.PROGRAM)
        code, printed = self.make()
        self.assertEqual(code, 1)
        self.assertIn("exit code 2: no such sensor", printed)
        made = [bool(it.sources) for it in blocks((self.root / "docs/page.md").read_text())]
        self.assertEqual(made, [True, False])

    def test_a_later_command_takes_what_an_earlier_one_left(self):
        commands = ["scanbench run streets -o model", "scanbench run streets -P vehicle_model.rivals_directory=model"]
        with redirect_stdout(StringIO()):
            results = Runner(self.root, tiny=False).run(commands)
        said = (results[1].directory / "robustness.md").read_text()
        self.assertIn(f'vehicle_model.rivals_directory="{results[0].directory}"', said)

    def test_tiny_runs_are_not_taken_for_real_ones(self):
        self.make(tiny=True)
        self.make()
        self.assertEqual(self.n_runs(), 4)
        self.assertEqual(tiny(["gaps", "--pairs", "10"]), ["gaps", "--pairs", "1"])


class Shown(unittest.TestCase):
    def text(self, name, *arguments, printed="", command="scanbench run", **files):
        """What a block shows of files, whose names have _ for a dot."""
        folder = scratch(self)
        for it, text in files.items():
            (folder / ".".join(it.rsplit("_", 1))).write_text(text)
        return shows.SHOWS[name]([Result(command, folder, printed)], *arguments).text

    def test_gaps_are_summed_over_kinds_and_layouts(self):
        rows = "detector,pair,layout,range_from_m,range_to_m,gap_m,n_seen,n_separated\n"
        rows += "grid,cars,beside,5.0,10.0,0.20,4,1\ngrid,bins,behind,5.0,10.0,0.20,4,3\n"
        rows += "tree,cars,beside,5.0,10.0,0.20,4,0\ntree,bins,behind,5.0,10.0,0.20,4,4\n"
        rows += "grid,cars,beside,5.0,10.0,0.30,4,4\n"
        self.assertEqual(self.text("gap-shares", gaps_csv=rows).splitlines()[2:], ["| 5 to 10 | 0.2 | 8 | 50 | 50 |"])

    def test_the_head_of_a_file_keeps_its_notes(self):
        written = "**Rates.**\n\n| a |\n| :-- |\n| 1 |\n| 2 |\n\n- a: all\n"
        expected = "| a |\n| :-- |\n| 1 |\n\n- a: all"
        self.assertEqual(self.text("file-head", "robustness.md", "1", robustness_md=written), expected)

    def test_columns_are_left_out_of_a_file(self):
        written = "**Values.**\n\n| a | b | c |\n| :-- | --: | --: |\n| 1 | 2 | 3 |\n\n- a: all"
        expected = "**Values.**\n\n| a | c |\n| :-- | --: |\n| 1 | 3 |\n\n- a: all"
        self.assertEqual(self.text("file", "open_values.md", "b", open_values_md=written), expected)

    def test_a_claim_has_its_first_reading_and_others_under_which_it_holds(self):
        claim = {"paper": "HG", "place": "5", "printed": "83", "says": "It leads."}
        readings = [
            {"difference": difference, "holds": numbers == "2", "numbers": numbers, "reading": name}
            for name, numbers, difference in [("good faith", "1", "-1"), ("by centre", "2", ""), ("by bev-iou", "3", "")]
        ]
        found = {"claim": claim, "readings": readings, "settings": [1, 9], "verdict": "holds_under_some_readings"}
        of_another = {**found, "claim": {**claim, "paper": "VM"}}
        text = self.text("claims", "HG", reproduction_json=json.dumps({"claims": [found, of_another]}))
        expected = "| It leads. | 83 | 1; -1 | holds under some readings (by centre); 1 of 9 settings |"
        first, *_, last = text.splitlines()
        self.assertEqual((first, last), ("1 claims (holds under some readings: 1).", expected))

    def test_changes_are_against_the_first_condition(self):
        rows = "group,condition,task,detector,f_rate\n"
        rows += "standard,dry,objects,grid,0.7000\nweather,rain,objects,grid,0.6000\nweather,hail,objects,grid,\n"
        rows += "standard,dry,objects,pca,0.7000\n"
        text = self.text("condition-changes", "grid", robustness_csv=rows)
        self.assertEqual(text.splitlines()[2:], ["| weather | rain | −10.0 |", "| weather | hail | – |"])

    def test_counts_are_summed_before_a_ratio_is_taken(self):
        ablation = "dataset,origin,variant,no,tp,fo\na,simulated,whole,10,8,2\nb,simulated,whole,30,12,18\n"
        ablation += "kitti,recorded,whole,4,3,\noverall,simulated,whole,44,23,20\n"
        text = self.text("ablation-rates", ablation_csv=ablation)
        self.assertIn("| whole | 50.0 | 75.0 |", text)
        self.assertIn("40 simulated annotations, 4 recorded ones.", text)

    def test_what_changed_nowhere_is_zero(self):
        head = "| task | detector | slice | metric | before | after | difference | 95 % | detectable |\n| :-- |\n"
        row = "| objects | {} | all | f_rate \\[%] | 1 | 2 | {} | {} | 1.12 |\n"
        printed = head + row.format("grid", "+0.47", "−0.24 to +1.17") + row.format("pca", "+0.00", "+0.00 to +0.00")
        compared = {"printed": printed, "command": "scanbench compare a b"}
        found = self.text("compared-runs", "completion", **compared)
        self.assertIn("| completion | objects | +0.47 (−0.24 to +1.17) | 0 |", found)
        with self.assertRaises(shows.ShowError):
            self.text("compared-runs", "completion", "regrouping", **compared)

    def test_intervals_of_few_blocks_are_flagged(self):
        head = "source,dataset,detector,no,precision,recall,f_rate,f_rate_low,f_rate_high,fps_mean,few_blocks\n"
        row = head + "measured,overall,grid,9,0.5,0.5,0.5,0.4,0.6,12.3,true\n"
        text = self.text("overall-rates", table_objects_csv=row, table_vehicles_csv=row)
        rates = "50.0 | 40.0 to 60.0§ | 50.0 | 50.0"
        self.assertIn(f"| grid | {rates} | {rates} | 12 |", text)
        self.assertIn("of 9 annotated objects and 9 vehicles.", text)
        self.assertIn("§ from fewer than ten blocks", text)
        many = row.replace("true", "false")
        self.assertNotIn("§", self.text("overall-rates", table_objects_csv=many, table_vehicles_csv=many))

    def test_where_nothing_can_be_false_a_rate_is_recall(self):
        head = "source,dataset,origin,detector,no,recall,f_rate\n"
        objects = head + "measured,kitti,recorded,grid,9,0.5,\nmeasured,kitti,recorded,tree,9,0.6,\n"
        vehicles = head + "measured,kitti,recorded,grid,8,0.5,0.7\nmeasured,kitti,recorded,tree,8,0.6,0.8\n"
        text = self.text("rates-by-dataset", "objects", "vehicles", table_objects_csv=objects, table_vehicles_csv=vehicles)
        expected = ["| kitti, recall of 9 objects | 50.0 | 60.0 |", "| kitti, 8 vehicles | 70.0 | 80.0 |"]
        self.assertEqual(text.splitlines()[2:], expected)

    def test_a_pair_of_detectors_has_both_tasks_in_a_row(self):
        head = "| task | detector | slice | metric | difference | 95 % |\n| :-- |\n"
        row = "| {} | tree − grid | all | f_rate \\[%] | {} | {} |\n"
        printed = head + row.format("objects", "+1.00", "+0.50 to +1.50") + row.format("vehicles", "−2.00", "−3.00 to −1.00")
        results = [Result("scanbench run", Path(), ""), Result("scanbench compare a -d grid,tree", Path(), printed)]
        text = shows.SHOWS["compared-detectors"](results).text
        self.assertIn("| tree − grid | +1.00 | +0.50 to +1.50 | −2.00 | −3.00 to −1.00 |", text)

    def test_slices_have_the_right_box_of_two_kinds(self):
        rows = "by,slice,fit,error,n_pairs,value\n"
        rows += "all,,hull box,BEV IoU >= 0.7,9,46.04\nall,,hull box,yaw within 10 deg,9,70\n"
        rows += "all,,reported box,BEV IoU >= 0.7,9,85.4\nclass,bus,reported box,BEV IoU >= 0.7,0,\n"
        self.assertEqual(self.text("box-slices", box_errors_csv=rows).splitlines()[2:], ["| all | 9 | 46.0 | 85.4 |"])

    def test_data_sets_of_a_sensor_share_a_row(self):
        head = "dataset,origin,sensor,task,no,rate,best_cell_size_m,best_rate,reading,recommended_cell_size_m,loss\n"
        rows = [
            f"{dataset},simulated,vlp-16,objects,{no},F-rate,0.4,{rate},{reading},{size},{loss}"
            for dataset, no, rate in [("street", 3, 0.5), ("narrow", 4, 0.625)]
            for reading, size, loss in [("knuth", 2 * rate, 0.25), ("printed", "", ""), ("as configured", 0.6, rate / 10)]
        ]
        text = self.text("fitness-by-sensor", "objects", cell_fitness_csv=head + "\n".join(rows))
        expected = "| vlp-16 | 7 | 0.4 | 50.0 to 62.5 | 1.0 to 1.2 | 25.0 | 5.0 to 6.2 |"
        self.assertEqual(text.splitlines()[2:], [expected])

    def test_alike_is_within_a_factor_either_way(self):
        head = "statistic,bin,bin_from_m,bin_to_m,left,ratio\n"
        rows = [("5-6 m", 5, 6, 1.4), ("6-7 m", 6, 7, 0.5), ("60-61 m", 60, 61, 9.0), ("7-8 m", 7, 8, "")]
        text = head + "".join(f"ring_density,{name},{a},{b},street,{ratio}\n" for name, a, b, ratio in rows)
        self.assertIn("| 50 %, 0.50 |", self.text("realism-agreement", realism_csv=text))

    def test_a_missing_file_is_named(self):
        with self.assertRaisesRegex(shows.ShowError, "scanbench run left no gaps.csv"):
            self.text("gap-shares")


if __name__ == "__main__":
    unittest.main()
