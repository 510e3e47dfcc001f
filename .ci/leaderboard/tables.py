"""The tables of docs/leaderboard.md from a run directory."""

import json


def lines_of(directory):
    """Lines of Markdown by the name of the table."""
    report = json.loads((directory / "report.json").read_text())
    manifest = json.loads((directory / "manifest.json").read_text())
    # Of several data sets their sum is reported, of one alone its own numbers.
    rows = report.get("overall") or report["rows"]
    numbers = {(it["detector"], it["task"], it["metric"]): it for it in rows if it["slice"] == "all"}
    detectors = [it["name"] for it in manifest["detectors"]]
    # Those that differ from others by their vehicles alone.
    clusterings = [it for it in detectors if not it.endswith("-model")]
    return {
        "objects": quality(numbers, by_rate(numbers, clusterings, "objects"), "objects"),
        "vehicles": quality(numbers, by_rate(numbers, detectors, "vehicles"), "vehicles"),
        "times": times(numbers, sorted(clusterings, key=lambda it: value(numbers, it, "objects", "latency_p50_ms"))),
        "detectors": entries(manifest),
    }


def by_rate(numbers, detectors, task):
    """The best F-rate first; where nothing can be false, the best recall, and of several the name that comes first."""
    metric = "recall" if numbers.get((detectors[0], task, "f_rate"), {}).get("value") is None else "f_rate"
    return sorted(detectors, key=lambda it: (-value(numbers, it, task, metric), it))


def value(numbers, detector, task, metric):
    number = numbers.get((detector, task, metric), {}).get("value")
    return float("nan") if number is None else number


def percent(numbers, detector, task, metric):
    return number(100 * value(numbers, detector, task, metric))


def number(it, digits=None):
    """Three digits that count, or as many after the point as given."""
    if it != it:
        return "–"
    if digits is None:
        digits = 1 if it < 100 else 0
    return f"{it:.{digits}f}"


def interval(numbers, detector, task, metric):
    low_high = numbers.get((detector, task, metric), {}).get("interval_95")
    return " to ".join(number(100 * it) for it in low_high) if low_high else "–"


def quality(numbers, detectors, task):
    lines = table("detector", "F-rate", "95 % interval", "precision", "recall", "over-segmentation", "under-segmentation")
    for it in detectors:
        rates = [percent(numbers, it, task, metric) for metric in ["precision", "recall", "over_segmentation", "under_segmentation"]]
        lines.append(row(it, percent(numbers, it, task, "f_rate"), interval(numbers, it, task, "f_rate"), *rates))
    no = value(numbers, detectors[0], task, "no")
    return [*lines, "", f"Rates in %, of {no:.0f} annotations."]


def times(numbers, detectors):
    lines = table("detector", "ms (median)", "× hierarchical", "CPU ms (mean)", "× hierarchical", "process overhead, ms", "failed scans")
    of = {name: {it: value(numbers, it, "objects", name) for it in detectors} for name in ["latency_p50_ms", "cpu_mean_ms", "overhead_p50_ms", "failed_scans"]}
    for it in detectors:
        cells = []
        for metric in ["latency_p50_ms", "cpu_mean_ms"]:
            ms = of[metric][it]
            cells += [number(ms), number(ms / of[metric].get("hierarchical", float("nan")))]
        lines.append(row(it, *cells, number(of["overhead_p50_ms"][it], 2), number(of["failed_scans"][it], 0)))
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
