"""The tables of docs/leaderboard.md from a run directory."""

import json


def lines_of(directory, timed=None, recorded=None):
    """Lines of Markdown by the name of the table. Times are those of the run directory `timed`, and the columns of recorded scans
    those of `recorded`, if there are any."""
    numbers = numbers_of(directory)
    manifest = manifest_of(directory)
    # A detector of others with our vehicle model has the same clusters: it is a column.
    detectors = [it["name"] for it in manifest["detectors"] if not it["name"].endswith("-model")]
    times, of_recorded = numbers_of(timed) if timed else numbers, numbers_of(recorded) if recorded else {}
    return {"rates": rates(numbers, detectors, times, of_recorded), "versions": versions(manifest)}


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
    rate = percent(numbers, detector, task, "f_rate")
    low_high = numbers.get((detector, task, "f_rate"), {}).get("interval_95")
    return f"{rate} ({'–'.join(number(100 * it) for it in low_high)})" if low_high else rate


def with_model(numbers, detector):
    """The F-rate of vehicles of the same clusters with our vehicle model, if that was run."""
    other = f"{detector}-model"
    return f_rate(numbers, other, "vehicles") if (other, "vehicles", "f_rate") in numbers else ""


def rates(numbers, detectors, timed, recorded):
    """Of recorded scans the recall of objects alone: none can be false."""
    found = [it for it in by_rate(numbers, detectors, "objects") if value(numbers, it, "objects", "tp") > 0]
    simulated = ["objects: F-rate", "precision", "recall", "vehicles: F-rate", "with our model"]
    lines = table("detector", *simulated, "KITTI: recall of objects", "F-rate of vehicles", "ms", "CPU ms")
    for it in found:
        objects = [percent(numbers, it, "objects", metric) for metric in ["precision", "recall"]]
        vehicles = [f_rate(numbers, it, "vehicles"), with_model(numbers, it)]
        kitti = [percent(recorded, it, "objects", "recall"), percent(recorded, it, "vehicles", "f_rate")]
        ms = [number(value(timed, it, "objects", metric)) for metric in ["latency_p50_ms", "cpu_mean_ms"]]
        lines.append(row(it, f_rate(numbers, it, "objects"), *objects, *vehicles, *kitti, *ms))
    return [*lines, "", *notes(numbers, detectors, recorded)]


def notes(numbers, detectors, recorded):
    """What holds for all rows: annotations, and the detectors that found nothing or failed."""
    lines = [f"Rates in %, of {annotations(numbers, detectors)}"]
    lines[0] += f"; KITTI: {annotations(recorded, detectors)}." if recorded else "."
    nothing = sorted(it for it in detectors if value(numbers, it, "objects", "tp") == 0)
    if nothing:
        lines.append(f"Without any match: {', '.join(nothing)}.")
    failed = {it: n for it in detectors if (n := value(numbers, it, "objects", "failed_scans")) > 0}
    return lines + [f"Failed scans: {n:.0f} of {it}." for it, n in failed.items()]


def annotations(numbers, detectors):
    n_objects, n_vehicles = (value(numbers, detectors[0], task, "no") for task in ["objects", "vehicles"])
    return f"{n_objects:.0f} objects and {n_vehicles:.0f} vehicles"


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
