"""Tests of the generated blocks: `python3 -m unittest discover .ci/blocks`."""

import json
import os
import subprocess
import tempfile
import unittest
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from unittest import mock

import behaviour
import docs
import fingerprint
import shows
from commands import CommandError, Result, Runner, tiny
from page import Block, PageError, join, not_shown, split

PAGE = """# A page

```sh
cargo run --release -- gaps \\
  --pairs 3    # few
```

<!-- made by:
scanbench gaps --pairs 3
shows: picture gaps.svg gaps.svg 'who is told apart'
-->

![who is told apart](gaps.svg)

<!-- end: command 00000000, content 11111111 -->

After `scanbench robustness` it ends.

<!-- made by:
scanbench robustness
shows: file robustness.md
-->
<!-- end -->
"""


NUMBER = {"metric": "recall", "value": 0.5, "unit": "ratio"}


def blocks(text=PAGE):
    return [it for it in split(Path("docs/page.md"), text) if isinstance(it, Block)]


def scratch(test):
    folder = tempfile.TemporaryDirectory()
    test.addCleanup(folder.cleanup)
    return Path(folder.name)


def checkout(test):
    """A git repository with a file of every group, and the page."""
    root = scratch(test)
    files = {
        "detector/src/cells.rs": "// Cells.\npub fn cells() {}\n",
        "baselines/src/params/params.toml": "tolerance_m = 0.5\n",
        "detector/src/params/model.toml": "x = 1\n",
        "detector/src/params/hierarchical.toml": "cell_size_m = 0.6\n",
        "datasets.toml": "seed = 1\n",
        "harness/evaluation/src/metrics/counts.rs": "pub const SCORING_VERSION: u32 = 7;\n",
        "harness/evaluation/src/realism/survey.rs": "fn survey() {}\n",
        "harness/evaluation/src/training/select.rs": "fn select() {}\n",
        "harness/evaluation/src/run/box_study.rs": "fn boxes() {}\n",
        "harness/evaluation/src/run/gap_experiment.rs": "fn gaps() {}\n",
        "harness/evaluation/src/run/robustness.rs": "fn robustness() {}\n",
        "harness/evaluation/src/matching/labeled_places.rs": "fn places() {}\n",
        "harness/scans/src/dataset/kitti/label.rs": "fn kitti() {}\n",
        "harness/viewer/src/log.rs": "fn log() {}\n",
        "reports/src/plots/gap_plot.rs": "fn plot() {}\n",
        "reports/src/pages/page.rs": "fn page() {}\n",
        "reports/golden/run/manifest.json": json.dumps({"created": "today", "seeds": {"street": 1}}),
        "reports/golden/run/report.json": json.dumps({"rows": [NUMBER, NUMBER | {"metric": "latency_p50_ms", "unit": "ms"}]}),
        "reports/golden/run/scans.csv": "scan,latency_ms,tp\n0,2.5,7\n",
        "reports/golden/run/matches.csv": "scan,outcome\n0,matched\n",
        "docs/page.md": PAGE,
        "README.md": "# No blocks\n",
    }
    for path, text in files.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text)
    subprocess.run(["git", "init", "--quiet", root], check=True)
    fingerprint.fingerprint.cache_clear()
    return root


def changed(root, path, text):
    (root / path).write_text(text)
    fingerprint.fingerprint.cache_clear()


class Pages(unittest.TestCase):
    def test_blocks_are_read_and_written_back(self):
        first, second = blocks()
        self.assertEqual(first.commands, ["scanbench gaps --pairs 3"])
        self.assertEqual(first.shows, ["picture", "gaps.svg", "gaps.svg", "who is told apart"])
        self.assertEqual(first.made_of, {"command": "00000000", "content": "11111111"})
        self.assertEqual((first.line, second.line), (8, 19))
        self.assertEqual(second.made_of, {})
        self.assertEqual(join(split(Path("docs/page.md"), PAGE)), PAGE)

    def test_what_is_no_block_is_refused(self):
        for text in (
            PAGE.replace("<!-- end -->", ""),
            PAGE.replace("shows: file robustness.md\n", ""),
            PAGE + "<!-- end -->",
            PAGE.replace("content 11111111", "content"),
        ):
            with self.assertRaises(PageError):
                blocks(text)

    def test_readers_are_shown_the_commands(self):
        self.assertEqual(not_shown(split(Path("a.md"), PAGE)), [])
        hidden = [it for _, it in not_shown(split(Path("a.md"), PAGE.replace("--pairs 3  ", "--pairs 4  ")))]
        self.assertEqual(hidden, ["scanbench gaps --pairs 3"])


class Fingerprints(unittest.TestCase):
    def test_comments_tests_and_names_of_files_change_nothing_and_code_does(self):
        root = checkout(self)
        gaps = "harness/evaluation/src/run/gap_experiment.rs"
        before = fingerprint.fingerprint(root, "gaps")
        changed(root, gaps, "/// All gaps.\n\nfn gaps() {}\n\n#[cfg(test)]\npub(crate) mod tests {}\n")
        self.assertEqual(fingerprint.fingerprint(root, "gaps"), before)
        (root / gaps).rename(root / gaps.replace("experiment", "study"))
        fingerprint.fingerprint.cache_clear()
        self.assertEqual(fingerprint.fingerprint(root, "gaps"), before)
        (root / "harness/evaluation/src/run/gap_experiment").mkdir()
        changed(root, "harness/evaluation/src/run/gap_experiment/tests.rs", "fn test() {}\n")
        self.assertEqual(fingerprint.fingerprint(root, "gaps"), before)
        changed(root, gaps, "fn gaps() { loop {} }\n")
        self.assertNotEqual(fingerprint.fingerprint(root, "gaps"), before)

    def test_models_and_parameters_are_told_apart_and_comments_are_neither(self):
        root = checkout(self)
        parameters, models = (fingerprint.fingerprint(root, it) for it in ("parameters", "models"))
        changed(root, "detector/src/params/model.toml", "x = 2\n")
        self.assertEqual(fingerprint.fingerprint(root, "parameters"), parameters)
        self.assertNotEqual(fingerprint.fingerprint(root, "models"), models)
        changed(root, "detector/src/params/hierarchical.toml", "# In metres.\ncell_size_m  = 0.6\n")
        self.assertEqual(fingerprint.fingerprint(root, "parameters"), parameters)
        changed(root, "detector/src/params/hierarchical.toml", "cell_size_m = 0.7\n")
        self.assertNotEqual(fingerprint.fingerprint(root, "parameters"), parameters)

    def test_a_command_knows_what_decides_its_numbers(self):
        of = fingerprint.groups_of
        self.assertEqual(of(["scanbench gaps"], "gap-shares"), ["golden", "models", "parameters", "datasets", "gaps"])
        self.assertEqual(of(["scanbench boxes ~/data/kitti"], "box-fits"), ["golden", "models", "parameters", "boxes", "regions", "readers"])
        realism = of(["scanbench data realism street --against ~/data/kitti"], "realism-worst")
        self.assertEqual(realism, ["golden", "parameters", "datasets", "realism", "regions", "readers"])
        self.assertIn("plots", of(["scanbench gaps"], "picture"))
        self.assertIn("tables", of(["scanbench run"], "printed-table"))
        self.assertEqual(of(["scanbench run streets-ahead"], "rates-by-dataset")[-2:], ["datasets", "regions"])
        with self.assertRaises(ValueError):
            of(["scanbench selftest"], "file")

    def test_every_group_has_files_in_this_repository(self):
        for group in ["golden", "program", *fingerprint.GROUPS]:
            self.assertRegex(fingerprint.fingerprint(docs.ROOT, group), "^[0-9a-f]{8}$")
        listed = subprocess.run(["git", "ls-files"], cwd=docs.ROOT, check=True, capture_output=True, text=True).stdout.split()
        for group, (within, without) in fingerprint.GROUPS.items():
            for start in [*within, *without]:
                self.assertTrue(any(it.startswith(start) for it in listed), f"{group}: {start}")
        self.assertRegex(behaviour.scoring_version(docs.ROOT), r"^\d+$")


class Staleness(unittest.TestCase):
    def made(self, root):
        parts = split(Path("docs/page.md"), (root / "docs/page.md").read_text())
        block = docs.blocks_of(parts)[1]
        block.body = "| 1 |"
        block.made_of = fingerprint.made_of(root, block.commands, block.shows)
        block.made_of["content"] = block.content(root)
        return block

    def test_a_block_is_stale_once_its_sources_or_its_text_change(self):
        root = checkout(self)
        block = self.made(root)
        self.assertEqual(docs.why_stale(root, block), [])
        changed(root, "harness/viewer/src/log.rs", "fn other() {}\n")
        self.assertEqual(docs.why_stale(root, block), [])
        changed(root, "harness/evaluation/src/run/robustness.rs", "fn other() {}\n")
        self.assertEqual(docs.why_stale(root, block), ["robustness"])
        changed(root, "harness/evaluation/src/metrics/counts.rs", "pub const SCORING_VERSION: u32 = 8;\n")
        self.assertEqual(docs.why_stale(root, block), ["scoring 7 → 8", "robustness"])
        block.body = "| 2 |"
        self.assertIn("edited by hand", docs.why_stale(root, block))
        block.commands = ["scanbench robustness --seed 2"]
        self.assertIn("command", docs.why_stale(root, block))

    def test_a_rename_in_the_detector_makes_nothing_stale_and_another_result_does(self):
        root = checkout(self)
        block = self.made(root)
        changed(root, "detector/src/cells.rs", "// Cells by another name.\npub fn squares() {}\n")
        (root / "detector/src/cells.rs").rename(root / "detector/src/squares.rs")
        self.assertEqual(docs.why_stale(root, block), [])
        for file, other_times, other_result in (
            ("manifest.json", '{"created": "now", "seeds": {"street": 1}}', '{"created": "today", "seeds": {"street": 2}}'),
            ("scans.csv", "scan,latency_ms,tp\n0,3.5,7\n", "scan,latency_ms,tp\n0,2.5,8\n"),
            ("matches.csv", None, "scan,outcome\n0,missed\n"),
            ("report.json", json.dumps({"rows": [NUMBER]}), json.dumps({"rows": [NUMBER | {"value": 0.6}]})),
        ):
            path = f"reports/golden/run/{file}"
            before = (root / path).read_text()
            changed(root, path, other_times or before)
            self.assertEqual(docs.why_stale(root, block), [], file)
            changed(root, path, other_result)
            self.assertEqual(docs.why_stale(root, block), ["golden"], file)
            changed(root, path, before)

    def test_a_picture_belongs_to_its_block(self):
        root = checkout(self)
        block = docs.blocks_of(split(Path("docs/page.md"), PAGE))[0]
        before = block.content(root)
        (root / "docs/gaps.svg").write_text("<svg/>")
        self.assertNotEqual(block.content(root), before)

    def test_the_list_names_what_is_stale(self):
        root = checkout(self)
        printed = StringIO()
        with redirect_stdout(printed):
            n_stale = docs.list_stale(root, docs.pages(root, []))
        self.assertEqual(n_stale, 2)
        self.assertIn("STALE: 2 of 2", printed.getvalue())
        self.assertIn("docs/page.md:19", printed.getvalue())


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
        program = target / "release" / "scanbench"
        program.parent.mkdir()
        program.write_text(self.PROGRAM)
        program.chmod(0o755)
        self.counted = target / "counted"
        environment = {"CARGO_TARGET_DIR": str(target), "COUNTED": str(self.counted)}
        patched = mock.patch.dict(os.environ, environment)
        patched.start()
        self.addCleanup(patched.stop)
        os.environ.pop("SCANBENCH_TEST_DATA", None)
        self.runner = lambda **options: Runner(self.root, target / "docs", **{"tiny": False, "fresh": False, **options})

    def make(self, **options):
        with redirect_stdout(StringIO()) as printed:
            code = docs.make_all(self.root, self.root, docs.pages(self.root, []), self.runner(**options), everything=True)
        return code, printed.getvalue()

    def n_runs(self):
        return len(self.counted.read_text().splitlines())

    def test_pages_are_written_and_results_kept(self):
        code, _ = self.make()
        self.assertEqual(code, 0)
        text = (self.root / "docs/page.md").read_text()
        self.assertIn("made with robustness", text)
        self.assertEqual((self.root / "docs/gaps.svg").read_text(), "<svg/>\n")
        self.assertEqual([docs.why_stale(self.root, it) for it in blocks(text)], [[], []])
        self.assertEqual(self.n_runs(), 2)
        self.make()
        self.assertEqual(self.n_runs(), 2)
        self.make(fresh=True)
        self.assertEqual(self.n_runs(), 4)
        changed(self.root, "detector/src/cells.rs", "fn other() {}\n")
        self.make()
        self.assertEqual(self.n_runs(), 6)

    def test_without_recorded_data_a_block_stays_as_it_is(self):
        page = PAGE.replace("scanbench robustness", "scanbench boxes ~/data/kitti")
        (self.root / "docs/page.md").write_text(page)
        code, printed = self.make()
        self.assertEqual(code, 0)
        self.assertIn("skipped, SCANBENCH_TEST_DATA names no folder of recorded data: docs/page.md:19", printed)
        self.assertNotIn("made with", (self.root / "docs/page.md").read_text())
        os.environ["SCANBENCH_TEST_DATA"] = "/elsewhere"
        self.make()
        self.assertIn("made with boxes /elsewhere/data/kitti", (self.root / "docs/page.md").read_text())

    def test_nothing_is_made_by_a_program_that_is_not_as_accepted(self):
        golden = self.root / ".ci/golden"
        golden.parent.mkdir()
        golden.write_text("#!/bin/sh\n")
        golden.chmod(0o755)
        (self.root / "reports/golden/tolerances.toml").write_text("[[quality]]\n\n[speed]\nrelative = 0.1\n")
        runner = self.runner()
        runner.check_accepted()
        gate = '#!/bin/sh\ngrep -q speed "$6" && exit 2\necho "FAILED: results changed."; exit 101\n'
        runner.program.write_text(gate)
        with self.assertRaisesRegex(CommandError, "not as it was accepted: FAILED: results changed"):
            runner.check_accepted()

    def test_a_command_that_fails_leaves_its_block_and_the_others_are_made(self):
        program = Path(os.environ["CARGO_TARGET_DIR"]) / "release" / "scanbench"
        program.write_text('#!/bin/sh\n[ $1 = robustness ] && { echo "no such sensor" >&2; exit 2; }\n' + self.PROGRAM)
        code, printed = self.make()
        self.assertEqual(code, 1)
        self.assertIn("exit code 2: no such sensor", printed)
        self.assertEqual([bool(it.made_of.get("scoring")) for it in blocks((self.root / "docs/page.md").read_text())], [True, False])

    def test_a_later_command_takes_what_an_earlier_one_left(self):
        commands = ["scanbench train rivals streets -o model", "scanbench run streets -P vehicle_model.rivals_directory=model"]
        with redirect_stdout(StringIO()):
            results = self.runner().run(commands)
        said = (results[1].directory / "robustness.md").read_text()
        self.assertIn(f'vehicle_model.rivals_directory="{results[0].directory}"', said)

    def test_tiny_runs_are_not_taken_for_real_ones(self):
        self.make(tiny=True)
        self.make()
        self.assertEqual(self.n_runs(), 4)
        self.assertEqual(tiny(["gaps", "--pairs", "10"]), ["gaps", "--pairs", "1"])


class Shown(unittest.TestCase):
    def result(self, files, printed="", command="scanbench run"):
        folder = scratch(self)
        for name, text in files.items():
            (folder / name).write_text(text)
        return Result(command, folder, printed, 1.0)

    def test_gaps_are_summed_over_kinds_and_layouts(self):
        rows = "detector,pair,layout,range_from_m,range_to_m,gap_m,n_seen,n_separated\n"
        rows += "grid,cars,beside,5.0,10.0,0.20,4,1\ngrid,bins,behind,5.0,10.0,0.20,4,3\n"
        rows += "tree,cars,beside,5.0,10.0,0.20,4,0\ntree,bins,behind,5.0,10.0,0.20,4,4\n"
        rows += "grid,cars,beside,5.0,10.0,0.30,4,4\n"
        text = shows.gap_shares([self.result({"gaps.csv": rows})]).text
        self.assertEqual(text.splitlines()[2:], ["| 5 to 10 | 0.2 | 8 | 50 | 50 |"])

    def test_changes_are_against_the_first_condition(self):
        head = "group,condition,task,detector,f_rate\n"
        rows = head + "standard,dry,objects,grid,0.7000\nweather,rain,objects,grid,0.6000\nweather,hail,objects,grid,\n"
        text = shows.condition_changes([self.result({"robustness.csv": rows})]).text
        self.assertEqual(text.splitlines()[2:], ["| weather | rain | −10.0 |", "| weather | hail | – |"])

    def test_counts_are_summed_before_a_ratio_is_taken(self):
        ablation = "dataset,origin,variant,no,tp,fo\na,simulated,whole,10,8,2\nb,simulated,whole,30,12,18\n"
        ablation += "kitti,recorded,whole,4,3,\noverall,simulated,whole,44,23,20\n"
        text = shows.ablation_rates([self.result({"ablation.csv": ablation}, command="scanbench ablation")]).text
        self.assertIn("| whole | 50.0 | 50.0 | 50.0 | 75.0 |", text)
        self.assertIn("40 simulated annotations, 4 recorded ones.", text)

    def test_what_changed_nowhere_is_zero(self):
        head = "| task | detector | slice | metric | before | after | difference | 95 % | least |\n| :-- |\n"
        row = "| objects | {} | all | f_rate \\[%] | 1 | 2 | {} | {} | 1.12 |\n"
        text = head + row.format("grid", "+0.47", "−0.24 to +1.17") + row.format("pca", "+0.00", "+0.00 to +0.00")
        compared = self.result({}, text, "scanbench compare a b")
        found = shows.compared_runs([compared], "completion").text
        self.assertIn("| completion | objects | +0.47 (−0.24 to +1.17) | 0 |", found)
        with self.assertRaises(shows.ShowError):
            shows.compared_runs([compared], "completion", "regrouping")

    def test_intervals_of_few_blocks_are_flagged(self):
        head = "source,dataset,detector,no,precision,recall,f_rate,f_rate_low,f_rate_high,fps_mean,few_blocks\n"
        row = "measured,overall,{},9,0.5,0.5,0.5,0.4,0.6,12.3,{}\n"
        few = {f"table_{it}.csv": head + row.format("grid", "true") for it in ("objects", "vehicles")}
        text = shows.overall_rates([self.result(few)]).text
        self.assertIn("| objects | grid | 9 | 50.0 | 40.0 to 60.0§ | 50.0 | 50.0 | 12 |", text)
        self.assertIn("§ from fewer than ten blocks", text)
        many = {name: it.replace("true", "false") for name, it in few.items()}
        self.assertNotIn("§", shows.overall_rates([self.result(many)]).text)

    def test_rules_are_those_of_the_manifest(self):
        manifest = '{"detectors": [{"name": "grid", "rules": ["walls", "bounds"]}, {"name": "tree", "rules": ["bounds"]}]}'
        text = shows.detector_rules([self.result({"manifest.json": manifest})]).text
        self.assertEqual(text.splitlines()[2:], ["| walls | yes | no |", "| bounds | yes | yes |"])

    def test_alike_is_within_a_factor_either_way(self):
        head = "statistic,bin,bin_from_m,bin_to_m,left,ratio\n"
        rows = [("5-6 m", 5, 6, 1.4), ("6-7 m", 6, 7, 0.5), ("60-61 m", 60, 61, 9.0), ("7-8 m", 7, 8, "")]
        text = head + "".join(f"ring_density,{name},{a},{b},street,{ratio}\n" for name, a, b, ratio in rows)
        result = self.result({"realism.csv": text})
        self.assertIn("| 50 %, 0.50 |", shows.realism_agreement([result]).text)
        self.assertIn("| 6-7 m: 0.50 |", shows.realism_worst([result]).text)

    def test_a_missing_file_is_named(self):
        with self.assertRaisesRegex(shows.ShowError, "scanbench run left no gaps.csv"):
            shows.gap_shares([self.result({})])


if __name__ == "__main__":
    unittest.main()
