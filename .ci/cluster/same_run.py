"""Fails unless two run directories have the same bytes but for times: same_run.py WHOLE MERGED

Also shows that it would see a digit that is another one.
"""

import csv
import json
import re
import sys
from pathlib import Path

# Where times are, besides how a run came about.
TIMES = {"manifest.json", "report.html", "table_times.md", "table_stages.md"}
TIME_COLUMN = re.compile(r".*_ms$")
TIME_METRIC = re.compile(r"(latency|cpu|fps|door|reference)_.*|time_over_reference")
TIME_FIGURE = re.compile(r"figures/.*(time|latency|speed|stage).*")


def without_times(name, content):
    """The content of a file without its times; None for one that is about nothing else."""
    if name in TIMES or TIME_FIGURE.fullmatch(name):
        return None
    if name in ("scans.csv", "stages.csv"):
        header, *rows = csv.reader(content.decode().splitlines())
        kept = [place for place, column in enumerate(header) if not TIME_COLUMN.fullmatch(column)]
        return [[row[place] for place in kept] for row in [header, *rows]]
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
    if whole.keys() != merged.keys():
        sys.exit(f"other files: {sorted(whole.keys() ^ merged.keys())}")
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
            place = last_digit.start()
            changed = whole[name][:place] + (b"1" if last_digit[0] != b"1" else b"2") + whole[name][place + 1 :]
            if without_times(name, changed) == expected:
                sys.exit(f"a changed digit in {name} is not seen")
    for name in ("matches.csv", "scans.csv", "report.json"):
        if name not in compared:
            sys.exit(f"{name} was not compared")
    n_rows = whole["matches.csv"].count(b"\n") - 1
    print(f"the same but for times: {n_rows} rows of matches.csv, {', '.join(compared)}")


main()
