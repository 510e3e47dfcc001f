"""Fails unless two run directories have the same bytes but for times: same_run.py WHOLE MERGED"""

import csv
import json
import re
import sys
from pathlib import Path

# Files in which times are not separated from the rest, and how a run came about.
LEFT_OUT = re.compile(
    r"manifest\.json|report\.html|table_(times|stages)\.md|table_(objects|vehicles)\.(md|tex)"
    r"|figures/(times|stages)\..*|figures/.*\.pdf"
)
# What a merged run has beside the files of a run, recordings, and hidden files of others, such as Snakemake.
OF_MERGE = re.compile(r"times_of_processors\.csv|recordings\.json|.*\.rrd|(.*/)?\.[^/]*")
WITH_TIMES = re.compile(r"(scans|stages|table_\w+)\.csv")
TIME_COLUMN = re.compile(r".*_ms|fps_mean")
TIME_METRIC = re.compile(r"(latency|cpu|fps|overhead|reference|stage)_.*|time_over_reference")


def without_times(name, content):
    """The content of a file without its times; None for one that is about nothing else."""
    if LEFT_OUT.fullmatch(name):
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
    files = {str(it.relative_to(folder)): it for it in sorted(Path(folder).rglob("*")) if it.is_file()}
    return {name: without_times(name, it.read_bytes()) for name, it in files.items() if not OF_MERGE.fullmatch(name)}


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
