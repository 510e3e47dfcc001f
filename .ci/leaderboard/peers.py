"""Other people's detectors: sweeps of their parameters, the runs beside ours, and docs/leaderboard.md. Called by `.ci/slow peers`."""

import argparse
import csv
import json
import os
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from pathlib import Path

from tables import lines_of

ROOT = Path(__file__).resolve().parents[2]
CONFIG = ROOT / "baselines/peers/scanbench.toml"
SWEEPS = tomllib.loads((Path(__file__).parent / "sweeps.toml").read_text())
# What distinguishes rows of one detector.
SUFFIX = re.compile(r"(-swept|-swept-model|-as-documented)$")
PAGE = ROOT / "docs/leaderboard.md"
# What is written between these lines is not to be written by hand.
SWEPT = re.compile(r"(# Swept: [^\n]*\n).*\Z", re.DOTALL)
OURS = ["hierarchical", "kd-tree-trained", "kd-tree-tree", "kd-tree", "simple-grid", "paper", "pca"]
# The name of a run whose times are reported for those of the run without it.
TIMED_APART = "-times"
RUNS = {"streets": ["streets"], "kitti": ["{data}/data/kitti_tracking"]}


def scanbench(arguments, folder):
    """Runs the program in `folder`, where no path of this machine gets into a manifest by accident."""
    folder.mkdir(parents=True, exist_ok=True)
    command = [os.environ["SCANBENCH"], *arguments, "-c", str(CONFIG)]
    print("+ scanbench", *arguments, flush=True)
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)


def sweep(folder, names):
    """A sweep for each detector. One that is there is not made again, one that was interrupted goes on."""
    for name, values in SWEEPS["detector"].items():
        if names and name not in names or (folder / "sweeps" / name / "sweep.csv").is_file():
            continue
        lists = [word for key, those in values.items() for word in ("-L", f"{name}.{key}={','.join(map(str, those))}")]
        scanbench(["sweep", *SWEEPS["scans"], "-d", name, *lists, "--timed-scans", "0", "--no-rrd", "-o", name], folder / "sweeps")
    write_swept(folder)


def best_point(path):
    """The parameters with the best F-rate of objects over all scans of a sweep, the first of several, and that rate."""
    sums, parameters = defaultdict(lambda: [0, 0]), {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            if row["task"] != "objects":
                continue
            names = list(row)
            swept = names[names.index("point") + 1 : names.index("dataset")]
            parameters[row["point"]] = {name.rsplit(".", 1)[-1]: json.loads(row[name]) for name in swept}
            sums[row["point"]][0] += 2 * int(row["tp"])
            sums[row["point"]][1] += int(row["no"]) + int(row["nd"])
    point, (twice_tp, n) = max(sums.items(), key=lambda it: it[1][0] / it[1][1])
    return parameters[point], twice_tp / n


def write_swept(folder):
    """The best parameters of the sweeps that are there, as detectors of scanbench.toml."""
    text = CONFIG.read_text()
    known = tomllib.loads(text)["detector"]
    sections = []
    for name in SWEEPS["detector"]:
        path = folder / "sweeps" / name / "sweep.csv"
        parameters = known.get(f"{name}-swept", {}).get("parameters")
        if path.is_file():
            best, rate = best_point(path)
            print(f"{name}: {best}, F-rate of objects {100 * rate:.1f} %")
            parameters = {**known[name]["parameters"], **best}
        if parameters is None:
            continue
        limit = [f"time_limit_s = {known[name]['time_limit_s']}"] if "time_limit_s" in known[name] else []
        same = [f"command = {json.dumps(known[name]['command'])}", f"parameters = {inline(parameters)}", *limit]
        # The second has the same clusters, and our model classifies the vehicles among them.
        for suffix, vehicles in (("swept", "size"), ("swept-model", "model")):
            sections.append("\n".join([f"[detector.{name}-{suffix}]", *same, f'vehicles = "{vehicles}"']) + "\n")
    CONFIG.write_text(SWEPT.sub(lambda match: match[1] + "\n" + "\n".join(sections), text))


def inline(parameters):
    return "{ " + ", ".join(f"{name} = {json.dumps(value)}" for name, value in parameters.items()) + " }"


def run(folder, names, extra, are_timed_apart=False):
    """The runs that are reported: all detectors of ours and of scanbench.toml on the same scans. Those that are timed apart are
    without the rows that differ by their vehicles alone."""
    theirs = list(tomllib.loads(CONFIG.read_text())["detector"])
    chosen = OURS + [name for name in theirs if not names or SUFFIX.sub("", name) in names]
    if are_timed_apart:
        chosen = [name for name in chosen if not name.endswith("-model")]
    for name, datasets in RUNS.items():
        target = name + TIMED_APART if are_timed_apart else name
        if (folder / "runs" / target / "report.json").is_file():
            continue
        data = os.environ.get("SCANBENCH_TEST_DATA")
        if any("{data}" in it for it in datasets) and not data:
            print(f"left out, because SCANBENCH_TEST_DATA is not set: {name}", file=sys.stderr)
            continue
        datasets = [it.format(data=data) for it in datasets]
        rest = ["-d", ",".join(chosen), "--on-detector-failure", "skip", "--no-rrd", "-o", target]
        scanbench(["run", *datasets, *extra, *rest], folder / "runs")


def write_tables(folder):
    """The tables of docs/leaderboard.md from the runs that are there. Times of one machine are those of the streets."""
    there = {name: folder / "runs" / name for name in [*RUNS, "streets" + TIMED_APART]}
    there = {name: directory for name, directory in there.items() if (directory / "report.json").is_file()}
    if "streets" not in there:
        raise SystemExit(f"there is no run of the streets in {folder}: .ci/slow peers run makes it")
    text = PAGE.read_text()
    tables = lines_of(there["streets"], there.get("streets" + TIMED_APART), there.get("kitti"))
    for table, lines in tables.items():
        block = re.compile(rf"(<!-- made by \.ci/slow peers: {table} -->\n).*?(\n<!-- end of what \.ci/slow peers made -->)", re.DOTALL)
        if not block.search(text):
            raise SystemExit(f"{PAGE} has no place for the table {table}")
        text = block.sub(lambda match, lines=lines: match[1] + "\n" + "\n".join(lines) + "\n" + match[2], text)
    PAGE.write_text(text)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("step", choices=["sweep", "run", "times", "tables"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("-d", dest="names", type=lambda it: it.split(","), default=[])
    given, extra = parser.parse_known_args()
    if given.step == "sweep":
        sweep(given.folder, given.names)
    elif given.step in ("run", "times"):
        run(given.folder, given.names, extra, are_timed_apart=given.step == "times")
    else:
        write_tables(given.folder)


if __name__ == "__main__":
    main()
