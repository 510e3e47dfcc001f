"""Fails unless two run directories have the same bytes but for times: same_run.py WHOLE MERGED

Also shows that it would see a digit that is another one.
"""

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


def files(folder):
    # Hidden ones are of others, such as Snakemake.
    paths = (path for path in Path(folder).rglob("*") if path.is_file() and not path.name.startswith("."))
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths if path.suffix != ".rrd"}


def main():
    whole, merged = map(files, sys.argv[1:3])
    other = (whole.keys() ^ merged.keys()) - OF_MERGE
    if other:
        sys.exit(f"other files: {sorted(other)}")
    compared = []
    for name in sorted(whole):
        expected = without_times(name, whole[name])
        if expected is None:
            continue
        if without_times(name, merged[name]) != expected:
            sys.exit(f"{name} differs")
        compared.append(name)
        last_digit = re.search(rb"[0-9](?=[^0-9]*$)", whole[name])
        if name == "matches.csv":
            index = last_digit.start()
            changed = whole[name][:index] + (b"1" if last_digit[0] != b"1" else b"2") + whole[name][index + 1 :]
            if without_times(name, changed) == expected:
                sys.exit(f"a changed digit in {name} is not seen")
    for name in ("matches.csv", "scans.csv", "report.json"):
        if name not in compared:
            sys.exit(f"{name} was not compared")
    n_rows = whole["matches.csv"].count(b"\n") - 1
    print(f"the same but for times: {n_rows} rows of matches.csv, {', '.join(compared)}")


main()
