"""Other people's detectors: sweeps, the runs beside ours, and docs/leaderboard.md. Called by `.ci/slow peers`."""

import argparse
import json
import os
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from pathlib import Path

from program import read_json, rows
from shows import DASH, table

ROOT = Path(__file__).resolve().parents[2]
CONFIG = ROOT / "baselines/peers/scanbench.toml"
# Which values are tried, on streets that no table reports: those of seeds 8001 and up, a scan of each of five drives of each
# kind. Every combination is; the best F-rate of objects over all scans wins.
SWEPT_STREETS = ["streets", "--seed", "8001", "--simulated-scans", "10", "--scans", "0..10:2"]
SWEEPS = {
    "open3d-dbscan": {"eps": [0.3, 0.4, 0.5, 0.6, 0.7, 0.9], "min_points": [5, 10, 20, 40]},
    "sklearn-dbscan": {"eps": [0.3, 0.4, 0.5, 0.6, 0.7, 0.9], "min_samples": [5, 10, 20, 40]},
    "sklearn-hdbscan": {"min_cluster_size": [10, 20, 40], "cluster_selection_epsilon": [0.0, 0.5, 0.8]},
    "scipy-components": {"voxel_m": [0.2, 0.3, 0.4, 0.5, 0.6, 0.8], "min_points": [10, 20, 40]},
    "pcl-euclidean": {"tolerance_m": [0.3, 0.4, 0.5, 0.6, 0.7, 0.9], "min_points": [10, 20, 40]},
    "pcl-conditional": {"tolerance_m": [0.2, 0.3, 0.4, 0.5], "tolerance_per_m": [0.0, 0.005, 0.01, 0.02]},
}
# What distinguishes rows of one detector.
SUFFIX = re.compile(r"(-swept|-swept-model|-as-documented)$")
PAGE = ROOT / "docs/leaderboard.md"
# What is written between these lines is not to be written by hand.
SWEPT = re.compile(r"(# Swept: [^\n]*\n).*\Z", re.DOTALL)
OURS = ["hierarchical", "kd-tree-trained", "kd-tree-tree", "kd-tree", "simple-grid", "paper", "pca"]
RUNS = {"streets": "streets", "kitti": "{data}/data/kitti_tracking"}


def scanbench(arguments, folder):
    """Runs the program in `folder`, where no path of this machine gets into a manifest by accident."""
    folder.mkdir(parents=True, exist_ok=True)
    print("+ scanbench", *arguments, flush=True)
    command = [os.environ["SCANBENCH"], *arguments, "--no-rrd", "-c", str(CONFIG)]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)


def sweep(folder, names):
    """A sweep for each detector. One that is there is not made again, one that was interrupted goes on."""
    for name, values in SWEEPS.items():
        if names and name not in names or (folder / "sweeps" / name / "sweep.csv").is_file():
            continue
        lists = [word for key, those in values.items() for word in ("-L", f"{name}.{key}={','.join(map(str, those))}")]
        scanbench(["sweep", *SWEPT_STREETS, "-d", name, *lists, "--timed-scans", "0", "-o", name], folder / "sweeps")
    write_swept(folder)


def best_point(path):
    """The parameters with the best F-rate of objects over all scans of a sweep, the first of several, and that rate."""
    sums, parameters = defaultdict(lambda: [0, 0]), {}
    for row in (it for it in rows(path) if it["task"] == "objects"):
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
    for name in SWEEPS:
        path = folder / "sweeps" / name / "sweep.csv"
        parameters = known.get(f"{name}-swept", {}).get("parameters")
        if path.is_file():
            best, rate = best_point(path)
            print(f"{name}: {best}, F-rate of objects {100 * rate:.1f} %")
            parameters = {**known[name]["parameters"], **best}
        if parameters is None:
            continue
        inline = ", ".join(f"{key} = {json.dumps(value)}" for key, value in parameters.items())
        same = [f"command = {json.dumps(known[name]['command'])}", f"parameters = {{ {inline} }}"]
        same += [f"time_limit_s = {it}" for it in [known[name].get("time_limit_s")] if it is not None]
        # The second has the same clusters, and our model classifies the vehicles among them.
        for suffix, vehicles in (("swept", "size"), ("swept-model", "model")):
            sections.append("\n".join([f"[detector.{name}-{suffix}]", *same, f'vehicles = "{vehicles}"']) + "\n")
    CONFIG.write_text(SWEPT.sub(lambda match: match[1] + "\n" + "\n".join(sections), text))


def run(folder, names, extra):
    """The runs that are reported: all detectors of ours and of scanbench.toml on the same scans."""
    theirs = tomllib.loads(CONFIG.read_text())["detector"]
    chosen = OURS + [name for name in theirs if not names or SUFFIX.sub("", name) in names]
    data = os.environ.get("SCANBENCH_TEST_DATA")
    for name, dataset in RUNS.items():
        if (folder / "runs" / name / "report.json").is_file():
            continue
        if "{data}" in dataset and not data:
            print(f"left out, because SCANBENCH_TEST_DATA is not set: {name}", file=sys.stderr)
            continue
        rest = ["-d", ",".join(chosen), "--on-detector-failure", "skip", "-o", name]
        scanbench(["run", dataset.format(data=data), *extra, *rest], folder / "runs")


def numbers_of(directory):
    """The numbers of a run by detector, task and metric; of several data sets those of their sum."""
    report = read_json(directory / "report.json")
    found = report.get("overall") or report["rows"]
    return {(it["detector"], it["task"], it["metric"]): it for it in found if it["slice"] == "all"}


def value(numbers, *key):
    it = numbers.get(key, {}).get("value")
    return float("nan") if it is None else it


def three_digits(it):
    return DASH if it != it else f"{it:.{1 if it < 100 else 0}f}"


def percent(numbers, *key):
    return three_digits(100 * value(numbers, *key))


def f_rate(numbers, detector, task):
    """The F-rate, and its interval."""
    key = detector, task, "f_rate"
    ends = numbers.get(key, {}).get("interval_95")
    return percent(numbers, *key) + (f" ({'–'.join(three_digits(100 * it) for it in ends)})" if ends else "")


def annotations(numbers, detector):
    n_objects, n_vehicles = (value(numbers, detector, task, "no") for task in ("objects", "vehicles"))
    return f"{n_objects:.0f} objects and {n_vehicles:.0f} vehicles"


def rates(numbers, detectors, recorded):
    """The best F-rate first. Of recorded scans the recall of objects alone: none can be false."""
    found = [it for it in detectors if value(numbers, it, "objects", "tp") > 0]
    lines = {}
    for it in sorted(found, key=lambda it: (-value(numbers, it, "objects", "f_rate"), it)):
        with_model = f"{it}-model", "vehicles"
        lines[it,] = [
            f_rate(numbers, it, "objects"),
            *(percent(numbers, it, "objects", metric) for metric in ("precision", "recall")),
            f_rate(numbers, it, "vehicles"),
            f_rate(numbers, *with_model) if (*with_model, "f_rate") in numbers else "",
            percent(recorded, it, "objects", "recall"),
            percent(recorded, it, "vehicles", "f_rate"),
            *(three_digits(value(numbers, it, "objects", metric)) for metric in ("latency_p50_ms", "cpu_mean_ms")),
        ]
    heads = ["detector", "objects: F-rate", "precision", "recall", "vehicles: F-rate", "with our model"]
    heads += ["KITTI: recall of objects", "F-rate of vehicles", "ms", "CPU ms"]
    kitti = f"; KITTI: {annotations(recorded, detectors[0])}" * bool(recorded)
    notes = [f"Rates in %, of {annotations(numbers, detectors[0])}{kitti}."]
    if nothing := sorted(it for it in detectors if value(numbers, it, "objects", "tp") == 0):
        notes.append(f"Without any match: {', '.join(nothing)}.")
    failed = {it: n for it in detectors if (n := value(numbers, it, "objects", "failed_scans")) > 0}
    notes += [f"Failed scans: {n:.0f} of {it}." for it, n in failed.items()]
    return "\n".join([table(heads, lines), "", *notes])


def versions(manifest):
    """What the detectors of others call, and what measured them."""
    foreign = [it["foreign"] for it in manifest["detectors"] if it.get("foreign")]
    texts = dict.fromkeys(f"{it['reported_name']} {it.get('version', DASH)}" for it in foreign)
    machine, commit = manifest["machine"], (manifest.get("git") or {}).get("commit", "")[:10]
    program = f"scanbench {manifest['scanbench_version']}, commit {commit}"
    return f"{', '.join(texts)}.\n{machine['cpu_model']}, {machine['n_cores']} cores; {program}."


def write_tables(folder):
    """The tables of docs/leaderboard.md from the runs that are there. Times of one machine are those of the streets."""
    streets, kitti = (folder / "runs" / name for name in RUNS)
    if not (streets / "report.json").is_file():
        raise SystemExit(f"there is no run of the streets in {folder}: .ci/slow peers run makes it")
    manifest = read_json(streets / "manifest.json")
    # A detector of others with our vehicle model has the same clusters: it is a column.
    detectors = [it["name"] for it in manifest["detectors"] if not it["name"].endswith("-model")]
    recorded = numbers_of(kitti) if (kitti / "report.json").is_file() else {}
    text = PAGE.read_text()
    for name, made in {"rates": rates(numbers_of(streets), detectors, recorded), "versions": versions(manifest)}.items():
        ends = rf"(<!-- made by \.ci/slow peers: {name} -->\n).*?(\n<!-- end of what \.ci/slow peers made -->)"
        text, n = re.subn(ends, lambda match: f"{match[1]}\n{made}\n{match[2]}", text, flags=re.DOTALL)
        if n != 1:
            raise SystemExit(f"{PAGE} has no place for the table {name}")
    PAGE.write_text(text)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("step", choices=["sweep", "run", "tables"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("-d", dest="names", type=lambda it: it.split(","), default=[])
    given, extra = parser.parse_known_args()
    if given.step == "sweep":
        sweep(given.folder, given.names)
    elif given.step == "run":
        run(given.folder, given.names, extra)
    else:
        write_tables(given.folder)


if __name__ == "__main__":
    main()
