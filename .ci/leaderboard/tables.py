"""The tables of docs/leaderboard.md from a run directory."""

import json


def lines_of(directory, timed=None):
    """Lines of Markdown by the name of the table. Times are those of the run directory `timed`, if there is one."""
    numbers = numbers_of(directory)
    manifest = manifest_of(directory)
    detectors = [it["name"] for it in manifest["detectors"]]
    # Those that differ from others by their vehicles alone.
    clusterings = [it for it in detectors if not it.endswith("-model")]
    return {
        "objects": objects(numbers, by_rate(numbers, clusterings, "objects"), numbers_of(timed) if timed else numbers),
        "vehicles": vehicles(numbers, by_rate(numbers, detectors, "vehicles")),
        "recall": recall_and_vehicles(numbers, by_rate(numbers, detectors, "vehicles"), clusterings),
        "versions": versions(manifest),
    }


def numbers_of(directory):
    """The numbers of a run by detector, task and metric."""
    report = json.loads((directory / "report.json").read_text())
    # Of several data sets their sum is reported, of one alone its own numbers.
    rows = report.get("overall") or report["rows"]
    return {(it["detector"], it["task"], it["metric"]): it for it in rows if it["slice"] == "all"}


def manifest_of(directory):
    return json.loads((directory / "manifest.json").read_text())


def by_rate(numbers, detectors, task):
    """The best F-rate first, and of several the name that comes first."""
    return sorted(detectors, key=lambda it: (-value(numbers, it, task, "f_rate"), it))


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


def f_rate(numbers, detector, task):
    """The F-rate, and its interval."""
    low_high = numbers.get((detector, task, "f_rate"), {}).get("interval_95")
    return [percent(numbers, detector, task, "f_rate"), " to ".join(number(100 * it) for it in low_high) if low_high else "–"]


def objects(numbers, detectors, timed):
    lines = table("detector", "F-rate", "95 % interval", "precision", "recall", "ms (median)", "CPU ms (mean)")
    for it in detectors:
        rates = [percent(numbers, it, "objects", metric) for metric in ["precision", "recall"]]
        ms = [number(value(timed, it, "objects", metric)) for metric in ["latency_p50_ms", "cpu_mean_ms"]]
        lines.append(row(it, *f_rate(numbers, it, "objects"), *rates, *ms))
    overheads = [ms for it in detectors if (ms := value(timed, it, "objects", "overhead_p50_ms")) == ms]
    notes = [annotations(numbers, detectors, "objects")]
    if overheads:
        notes.append(f"Process overhead: {min(overheads):.2f} to {max(overheads):.2f} ms.")
    failed = {it: n for it in detectors if (n := value(numbers, it, "objects", "failed_scans")) > 0}
    notes += [f"Failed scans: {n:.0f} of {it}." for it, n in failed.items()]
    return [*lines, "", " ".join(notes)]


def vehicles(numbers, detectors):
    found = found_by(numbers, detectors, "vehicles")
    lines = table("detector", "F-rate", "95 % interval")
    lines += [row(it, *f_rate(numbers, it, "vehicles")) for it in found]
    return [*lines, "", annotations(numbers, detectors, "vehicles")]


def recall_and_vehicles(numbers, detectors, clusterings):
    """Where no object can be false, of objects the recall alone."""
    found = found_by(numbers, detectors, "vehicles")
    lines = table("detector", "objects: recall", "vehicles: F-rate")
    for it in found:
        recall = percent(numbers, it, "objects", "recall") if it in clusterings else "–"
        lines.append(row(it, recall, percent(numbers, it, "vehicles", "f_rate")))
    n_objects, n_vehicles = (value(numbers, detectors[0], task, "no") for task in ["objects", "vehicles"])
    return [*lines, "", f"Rates in %, of {n_objects:.0f} annotated objects and {n_vehicles:.0f} vehicles."]


def found_by(numbers, detectors, task):
    """The detectors that find anything."""
    return [it for it in detectors if value(numbers, it, task, "f_rate") > 0]


def annotations(numbers, detectors, task):
    return f"Rates in %, of {value(numbers, detectors[0], task, 'no'):.0f} annotations."


def versions(manifest):
    """What the detectors of others call, and what measured them."""
    foreign = {it["name"]: it["foreign"] for it in manifest["detectors"] if it.get("foreign")}
    texts = [f"{it['reported_name']} {it.get('version', '–')}" for it in foreign.values()]
    machine = manifest["machine"]
    commit = (manifest.get("git") or {}).get("commit", "")[:10]
    return [
        f"{', '.join(dict.fromkeys(texts))}.",
        f"{machine['cpu_model']}, {machine['n_cores']} cores; scanbench {manifest['scanbench_version']}, commit {commit}.",
    ]


def table(*titles):
    return [row(*titles), "| :-- |" + " --: |" * (len(titles) - 1)]


def row(*cells):
    return "| " + " | ".join(map(str, cells)) + " |"
