"""Fails unless two run directories have the same bytes but for times: same_run.py WHOLE MERGED"""

import csv
import json
import re
import sys
from pathlib import Path

# Files in which times are not separated from the rest, and how a run came about. The tables are compared as CSV, figures as SVG.
TIMES = {"manifest.json", "report.html", "table_times.md", "table_stages.md"}
TIMES |= {f"table_{task}.{kind}" for task in ("objects", "vehicles") for kind in ("md", "tex")}
# What a merged run has beside the files of a run.
OF_MERGE = {"times_of_processors.csv", "recordings.json"}
WITH_TIMES = re.compile(r"(scans|stages|table_\w+)\.csv")
TIME_COLUMN = re.compile(r".*_ms|fps_mean")
TIME_METRIC = re.compile(r"(latency|cpu|fps|overhead|reference|stage)_.*|time_over_reference")
FIGURE_OF_TIMES = re.compile(r"figures/(times|stages)\..*|figures/.*\.pdf")


def without_times(name, content):
    """The content of a file without its times; None for one that is about nothing else."""
    if name in TIMES or FIGURE_OF_TIMES.fullmatch(name):
        return None
    if WITH_TIMES.fullmatch(name):
        header, *rows = csv.reader(content.decode().splitlines())
        kept = [index for index, column in enumerate(header) if not TIME_COLUMN.fullmatch(column)]
        return [[row[index] for index in kept] for row in [header, *rows]]
    if name == "report.json":
        report = json.loads(content)
        for part in ("rows", "overall"):
            report[part] = [row for row in report[part] if not TIME_METRIC.fullmatch(row["metric"])]
        return report
    return content


def contents(folder):
    # Hidden ones are of others, such as Snakemake.
    paths = [path for path in Path(folder).rglob("*") if path.is_file() and not path.name.startswith(".")]
    names = {str(path.relative_to(folder)): path for path in paths if path.suffix != ".rrd"}
    return {name: without_times(name, names[name].read_bytes()) for name in sorted(names.keys() - OF_MERGE)}


def main():
    whole, merged = map(contents, sys.argv[1:3])
    if other := sorted(whole.keys() ^ merged.keys()):
        sys.exit(f"other files: {other}")
    if differing := [name for name in whole if whole[name] != merged[name]]:
        sys.exit(f"differing: {differing}")
    compared = [name for name in whole if whole[name] is not None]
    if missing := {"matches.csv", "scans.csv", "report.json"} - {*compared}:
        sys.exit(f"not compared: {sorted(missing)}")
    n_rows = whole["matches.csv"].count(b"\n") - 1
    print(f"the same but for times: {n_rows} rows of matches.csv, {', '.join(compared)}")


main()
