"""The tables of docs/leaderboard.md from a run directory."""

import json
import math


def lines_of(directory):
    """Lines of Markdown by the name of the table."""
    report = json.loads((directory / "report.json").read_text())
    manifest = json.loads((directory / "manifest.json").read_text())
    # Of several data sets their sum is reported, of one alone its own numbers.
    rows = [it for it in report.get("overall") or report["rows"] if it["slice"] == "all" and it["value"] is not None]
    values = {(it["detector"], it["task"], it["metric"]): it["value"] for it in rows}
    value = lambda *key: values.get(key, math.nan)
    intervals = {(it["detector"], it["task"]): it.get("interval_95") or [] for it in rows if it["metric"] == "f_rate"}
    detectors = [it["name"] for it in manifest["detectors"]]
    # Those that differ from others by their vehicles alone.
    clusterings = [it for it in detectors if not it.endswith("-model")]
    return {
        "objects": quality(value, intervals, clusterings, "objects"),
        "vehicles": quality(value, intervals, detectors, "vehicles"),
        "times": times(value, clusterings),
        "detectors": entries(manifest),
    }


def number(it, digits=None):
    """Three digits that count, or as many after the point as given."""
    if math.isnan(it):
        return "–"
    if digits is None:
        digits = 1 if it < 100 else 0
    return f"{it:.{digits}f}"


def quality(value, intervals, detectors, task):
    """The best F-rate first; where nothing can be false, the best recall, and of several the name that comes first."""
    by = "recall" if math.isnan(value(detectors[0], task, "f_rate")) else "f_rate"
    lines = table("detector", "F-rate", "95 % interval", "precision", "recall", "over-segmentation", "under-segmentation")
    for it in sorted(detectors, key=lambda it: (-value(it, task, by), it)):
        metrics = ["f_rate", "precision", "recall", "over_segmentation", "under_segmentation"]
        rate, *others = [number(100 * value(it, task, metric)) for metric in metrics]
        interval = " to ".join(number(100 * it) for it in intervals.get((it, task), [])) or "–"
        lines.append(row(it, rate, interval, *others))
    return [*lines, "", f"Rates in %, of {value(detectors[0], task, 'no'):.0f} annotations."]


def times(value, detectors):
    lines = table("detector", "ms (median)", "× hierarchical", "CPU ms (mean)", "× hierarchical", "process overhead, ms", "failed scans")
    for it in sorted(detectors, key=lambda it: value(it, "objects", "latency_p50_ms")):
        cells = []
        for metric in ["latency_p50_ms", "cpu_mean_ms"]:
            ms, of_ours = (value(name, "objects", metric) for name in (it, "hierarchical"))
            cells += [number(ms), number(ms / of_ours)]
        others = number(value(it, "objects", "overhead_p50_ms"), 2), number(value(it, "objects", "failed_scans"), 0)
        lines.append(row(it, *cells, *others))
    return lines


def entries(manifest):
    lines = ["| detector | version | threads | parameters |", "| :-- | :-- | --: | :-- |"]
    for it in manifest["detectors"]:
        foreign = it.get("foreign")
        if foreign is None or it["name"].endswith("-model"):
            continue
        parameters = ", ".join(f"{name} {json.dumps(those).strip(chr(34))}" for name, those in it["parameters"].items())
        lines.append(row(it["name"], foreign.get("version", "–"), foreign.get("threads", "–"), parameters))
    machine = manifest["machine"]
    commit = (manifest.get("git") or {}).get("commit", "")[:10]
    return [*lines, "", f"{machine['cpu_model']}, {machine['n_cores']} cores; scanbench {manifest['scanbench_version']}, commit {commit}."]


def table(*titles):
    return [row(*titles), "| :-- |" + " --: |" * (len(titles) - 1)]


def row(*cells):
    return "| " + " | ".join(map(str, cells)) + " |"
