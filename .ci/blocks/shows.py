"""What blocks show of the results of their commands: tables from CSV files, plots and pictures.

Every function here takes the results of a block's commands, then the arguments of its line `shows: …`.
"""

import csv
import json
import re
import shlex
import statistics
import subprocess
import tempfile
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from statistics import mean, stdev

from commands import Result
from fingerprint import words_of

CI = Path(__file__).resolve().parents[1]
DASH = "–"


class ShowError(Exception):
    """Results that do not have what is to be shown."""


@dataclass
class Shown:
    text: str
    files: dict[str, bytes] = field(default_factory=dict)  # pictures, by their place beside the page


def rows(result: Result, name: str) -> list[dict[str, str]]:
    path = result.directory / name
    if not path.is_file():
        raise ShowError(f"{result.command} left no {name}")
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def table(heads: list[str], lines: list[list[str]], n_left: int = 1) -> str:
    """A pipe table, of which the first `n_left` columns are text and the others numbers."""
    rules = [":--" if n < n_left else "--:" for n in range(len(heads))]
    return "\n".join(f"| {' | '.join(it)} |" for it in [heads, rules, *lines])


def number(value: float | str | None, decimals: int = 1, scale: float = 1.0) -> str:
    if value in (None, ""):
        return DASH
    text = f"{scale * float(value):.{decimals}f}"
    return text.lstrip("-") if float(text) == 0 else text.replace("-", "−")


def percent(value: float | str | None) -> str:
    return number(value, 1, 100.0)


def share(part: int, whole: int) -> str:
    return number(part / whole, 0, 100.0) if whole else DASH


def signed(text: str) -> str:
    return text if text == DASH or text.startswith("−") else f"+{text}"


def origin_in_words(row: dict[str, str]) -> str:
    return f"{row['dataset']} (simulated)" if row["origin"] == "simulated" else row["dataset"]


FEW_BLOCKS = "§"
ABOUT_FEW_BLOCKS = f"{FEW_BLOCKS} from fewer than ten blocks of scans: too few for a reliable interval."


def flagged(interval: str, row: dict[str, str]) -> str:
    """An interval with its sign if it is of too few blocks for anything to rest on it."""
    return interval + FEW_BLOCKS if row.get("few_blocks") == "true" else interval


def noted(text: str) -> Shown:
    """A table, and below it what the sign of its intervals means."""
    return Shown(f"{text}\n\n{ABOUT_FEW_BLOCKS}" if FEW_BLOCKS in text else text)


# Runs


def detector_rules(results: list[Result]) -> Shown:
    """Which detector has which rule, by the manifest of a run."""
    manifest = json.loads((results[0].directory / "manifest.json").read_text())
    rules_of = {it["name"]: it.get("rules", []) for it in manifest["detectors"]}
    rules = dict.fromkeys(rule for of_detector in rules_of.values() for rule in of_detector)
    lines = [[rule, *["yes" if rule in it else "no" for it in rules_of.values()]] for rule in rules]
    return Shown(table(["rule", *rules_of], lines))


def printed_table(results: list[Result], task: str) -> Shown:
    """The first table of a task, as a run prints it."""
    paragraphs = re.split(r"\n\s*\n", results[0].printed)
    found = [n for n, it in enumerate(paragraphs) if it.startswith(f"Task {task}. Rates")]
    if not found:
        raise ShowError(f"{results[0].command} printed no table of {task}")
    title, grid = paragraphs[found[0] : found[0] + 2]
    lines = [it.rstrip() for it in [title, "", *grid.splitlines()]]
    return noted("```text\n" + "\n".join(lines) + "\n```")


def overall_rows(result: Result, task: str) -> list[dict[str, str]]:
    """What the detectors of a run reach on all its data sets together."""
    measured = [it for it in rows(result, f"table_{task}.csv") if it["source"] == "measured"]
    overall = [it for it in measured if it["dataset"] == "overall"]
    return overall or measured


def overall_rates(results: list[Result]) -> Shown:
    """Rates with their intervals of all detectors of a run, both tasks."""
    lines = []
    for task in ("objects", "vehicles"):
        for row in overall_rows(results[0], task):
            within = flagged(f"{percent(row['f_rate_low'])} to {percent(row['f_rate_high'])}", row)
            rates = [percent(row[it]) for it in ("precision", "recall")]
            fps = number(row["fps_mean"], 0 if float(row["fps_mean"] or 0) >= 10 else 1)
            lines.append([task, row["detector"], row["no"], percent(row["f_rate"]), within, *rates, fps])
    return noted(table(["task", "detector", "NO", "F-rate", "95 % interval", "precision", "recall", "fps"], lines, 2))


def over_seeds(results: list[Result]) -> Shown:
    """Mean and standard deviation over runs, which differ in their seeds, of F-rates and of the lead of the first detector."""
    lines = []
    for task in ("objects", "vehicles"):
        runs = [{it["detector"]: 100 * float(it["f_rate"]) for it in overall_rows(result, task)} for result in results]
        first, *_ = runs[0]
        for detector in runs[0]:
            rates = [it[detector] for it in runs]
            leads = [it[first] - it[detector] for it in runs]
            lead = "" if detector == first else f"{mean(leads):.1f} ± {stdev(leads):.1f}"
            lines.append([task, detector, f"{mean(rates):.1f} ± {stdev(rates):.1f}", f"{min(rates):.1f} to {max(rates):.1f}", lead])
    return Shown(table(["task", "detector", "F-rate", "least and greatest", "lead of the first"], lines, 2))


def differences(result: Result) -> dict[tuple[str, str], dict[str, str]]:
    """What `scanbench compare` printed of the F-rate, by task and what is compared."""
    lines = [it for it in result.printed.splitlines() if it.startswith("| ")]
    if len(lines) < 3:
        raise ShowError(f"{result.command} printed no table")
    cells = [[it.strip().replace("\\", "") for it in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    found = [dict(zip(cells[0], it)) for it in cells[2:]]
    return {(it["task"], it["detector"]): it for it in found if it["metric"].startswith("f_rate") and it["slice"] == "all"}


def compared_detectors(results: list[Result]) -> Shown:
    """Paired differences of detectors of one run, one pair a command after the first."""
    lines = []
    for result in results[1:]:
        for (task, pair), it in differences(result).items():
            lines.append([pair, task, it["difference"], it["95 %"], it["least"]])
    return noted(table(["difference of F-rates", "task", "points", "95 % interval", "least to be seen"], lines, 2))


def compared_runs(results: list[Result], *names: str) -> Shown:
    """What each part is worth to each detector: every second command compares a run without it with the whole one.

    `names` are those of the parts, in the order of the comparisons.
    """
    compared = [it for it in results if words_of(it.command)[0] == "compare"]
    if len(compared) != len(names):
        raise ShowError(f"{len(names)} names for {len(compared)} comparisons")
    found = [differences(it) for it in compared]
    subjects = list(dict.fromkeys(subject for it in found for subject in it))
    lines = []
    for part, of_part in zip(names, found):
        for task in dict.fromkeys(it[0] for it in subjects):
            cells = [of_part.get((task, detector)) for subject, detector in subjects if subject == task]
            texts = [gain(it) for it in cells]
            lines.append([part, task, *texts])
    detectors = list(dict.fromkeys(it[1] for it in subjects))
    return noted(table(["what it gives", "task", *detectors], lines, 2))


def gain(difference: dict[str, str] | None) -> str:
    """A difference with its interval; 0 if nothing changed in any scan."""
    if not difference:
        return DASH
    numbers = re.findall(r"\d+(?:\.\d+)?", difference["difference"] + " " + difference["95 %"])
    if numbers and not any(float(it) for it in numbers):
        return "0"
    return f"{difference['difference']} ({difference['95 %']})"


def ablation_rates(results: list[Result]) -> Shown:
    """Rates on simulated data and the recall on recorded ones, of variants of a method and of the detectors of a run."""
    ablation, *runs = results
    counted = [(it["variant"], it) for it in rows(ablation, "ablation.csv")]
    methods = {words_of(ablation.command)[0], "hierarchical"}
    for run in runs:
        found = [it for it in rows(run, "table_objects.csv") if it["source"] == "measured"]
        counted += [(f"*{it['detector']}*", it) for it in found if it["detector"] not in methods]
    sums: dict[str, dict[str, list[int]]] = defaultdict(lambda: defaultdict(lambda: [0, 0, 0]))
    for name, row in counted:
        if not row["dataset"].startswith("overall"):
            so_far = sums[name][row["origin"]]
            for n, it in enumerate(("no", "tp", "fo")):
                so_far[n] += int(row[it] or 0)
    lines = []
    for name, of_origin in sums.items():
        no, tp, fo = of_origin["simulated"]
        rates = [2 * tp / (no + tp + fo), tp / (tp + fo), tp / no] if tp else [None, None, None]
        no_recorded, tp_recorded, _ = of_origin["recorded"]
        recorded = tp_recorded / no_recorded if no_recorded else None
        lines.append([name, *[percent(it) for it in [*rates, recorded]]])
    first = next(iter(sums.values()))
    note = f"{first['simulated'][0]} simulated annotations, {first['recorded'][0]} recorded ones."
    return Shown(table(["", "F-rate", "precision", "recall", "recall on KITTI"], lines) + f"\n\n{note}")


def rates_by_dataset(results: list[Result], task: str) -> Shown:
    """F-rates of a task, data set by data set and detector by detector; recall where false objects cannot be known."""
    measured = [it for result in results for it in rows(result, f"table_{task}.csv") if it["source"] == "measured"]
    measured = [it for it in measured if not it["dataset"].startswith("overall")]
    detectors = list(dict.fromkeys(it["detector"] for it in measured))
    lines: dict[str, list[str]] = {}
    for row in measured:
        name = f"{origin_in_words(row)}, {row['no']} {task}"
        rate = percent(row["f_rate"]) if row["f_rate"] else f"{percent(row['recall'])} recall"
        lines.setdefault(name, [name]).append(rate)
    return Shown(table(["", *detectors], list(lines.values())))


# Experiments


def file(results: list[Result], name: str) -> Shown:
    """A Markdown file that a command left behind."""
    path = results[0].directory / name
    if not path.is_file():
        raise ShowError(f"{results[0].command} left no {name}")
    return Shown(path.read_text())


def gap_cells(found: list[dict[str, str]], keys: list[str]) -> dict[tuple[str, ...], dict[str, list[int]]]:
    """Numbers of pairs that were seen and separated, by `keys` and detector."""
    sums: dict[tuple[str, ...], dict[str, list[int]]] = defaultdict(lambda: defaultdict(lambda: [0, 0]))
    for row in found:
        cell = sums[tuple(row[it] for it in keys)][row["detector"]]
        cell[0] += int(row["n_seen"])
        cell[1] += int(row["n_separated"])
    return sums


def gap_shares(results: list[Result]) -> Shown:
    """Pairs of objects that are told apart, by range and every second gap."""
    found = [it for it in rows(results[0], "gaps.csv") if round(10 * float(it["gap_m"])) % 2 == 0]
    sums = gap_cells(found, ["range_from_m", "range_to_m", "gap_m"])
    detectors = list(dict.fromkeys(it["detector"] for it in found))
    lines = []
    for (near, far, gap), cells in sorted(sums.items(), key=lambda it: [float(n) for n in it[0]]):
        shares = [share(cells[it][1], cells[it][0]) for it in detectors]
        lines.append([f"{float(near):g} to {float(far):g}", f"{float(gap):.1f}", str(cells[detectors[0]][0]), *shares])
    return Shown(table(["range m", "gap m", "judged", *detectors], lines, 2))


def gap_layouts(results: list[Result]) -> Shown:
    """The same by how the pair stands, over all ranges and gaps."""
    found = rows(results[0], "gaps.csv")
    detectors = list(dict.fromkeys(it["detector"] for it in found))
    lines = []
    for (layout,), cells in gap_cells(found, ["layout"]).items():
        shares = [share(cells[it][1], cells[it][0]) for it in detectors]
        lines.append([layout, str(cells[detectors[0]][0]), *shares])
    return Shown(table(["layout", "judged", *detectors], lines))


def condition_changes(results: list[Result]) -> Shown:
    """What each condition does to the F-rates, in points against the first one."""
    found = rows(results[0], "robustness.csv")
    rates: dict[tuple[str, str], dict[tuple[str, str], float | None]] = defaultdict(dict)
    for row in found:
        rate = float(row["f_rate"]) if row["f_rate"] else None
        rates[row["group"], row["condition"]][row["detector"], row["task"]] = rate
    (_, standard), *others = rates.items()
    heads = [f"{detector}, {task}" for detector, task in standard]
    lines = []
    for (group, condition), of_condition in others:
        pairs = [(of_condition[it], standard[it]) for it in standard]
        changes = [signed(percent(a - b)) if a is not None and b is not None else DASH for a, b in pairs]
        lines.append([group, condition, *changes])
    return Shown(table(["kind", "condition", *heads], lines, 2))


def box_fits(results: list[Result]) -> Shown:
    """How boxes of each kind do around the same clusters."""
    found = [it for it in rows(results[0], "box_errors.csv") if it["by"] == "all"]
    what = list(dict.fromkeys(it["error"] for it in found))
    lines: dict[str, list[str]] = defaultdict(list)
    for row in found:
        lines[row["fit"]].append(number(row["value"], 2 if row["unit"] == "m" else 1))
    units = {it["error"]: it["unit"] for it in found}
    heads = [f"{it}, {units[it]}" for it in what]
    note = f"{found[0]['n_pairs']} vehicles, {found[0]['n_tracks']} tracks."
    return Shown(table(["", *heads], [[fit, *cells] for fit, cells in lines.items()]) + f"\n\n{note}")


def box_slices(results: list[Result]) -> Shown:
    """The shares with the right yaw and with the right box, slice by slice."""
    fits = ["hull box", "outline box", "reported box"]
    lines: dict[tuple[str, str], dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    counts: dict[tuple[str, str], int] = defaultdict(int)
    for row in rows(results[0], "box_errors.csv"):
        key = (row["by"], row["slice"])
        if row["fit"] in fits and row["n_pairs"] != "0":
            lines[key][row["error"]].append(number(row["value"], 1))
            # Whether the front is right is known of fewer.
            counts[key] = max(counts[key], int(row["n_pairs"]))
    words = {"all": "all", "occlusion": "hidden: ", "range": "", "class": "", "points": "points: "}
    what = ["yaw within 10 deg", "BEV IoU >= 0.7"]
    texts = [
        [words[by] + slice_, str(counts[by, slice_]), *(" / ".join(errors[it]) for it in what)]
        for (by, slice_), errors in lines.items()
    ]
    return Shown(table(["", "vehicles", *(f"{it}, %: {' / '.join(fits)}" for it in what)], texts))


# Cell fitness


def verdicts(results: list[Result]) -> list[dict[str, str]]:
    return [it for result in results for it in rows(result, "cell_fitness.csv")]


def reading_in_words(row: dict[str, str]) -> str:
    if row["reading"] == "as configured":
        return f"always {number(row['recommended_cell_size_m'], 2)} m"
    return f"`{row['reading']}`"


def losses(found: list[dict[str, str]], task: str, reading: str) -> list[str]:
    """The mean and greatest loss of a reading over data sets, in points, and its mean rank correlation."""
    of_reading = [it for it in found if it["task"] == task and reading_in_words(it) == reading]
    lost = [float(it["loss"]) for it in of_reading if it["loss"]]
    ranks = [float(it["rank_correlation"]) for it in of_reading if it["rank_correlation"]]
    mean, most = (statistics.fmean(lost), max(lost)) if lost else (None, None)
    return [percent(mean), percent(most), number(statistics.fmean(ranks) if ranks else None, 2)]


def fitness_summary(results: list[Result]) -> Shown:
    """What each reading recommends and costs, each data set counting once."""
    found = [it for it in verdicts(results) if not it["dataset"].startswith("overall") and it["rate"] == "F-rate"]
    lines = []
    for reading in dict.fromkeys(map(reading_in_words, found)):
        objects = [it for it in found if it["task"] == "objects" and reading_in_words(it) == reading]
        recommends = sum(bool(it["recommended_cell_size_m"]) for it in objects)
        at_end = sum(it["recommends_an_end"] == "true" for it in objects)
        cells = [it for task in ("objects", "vehicles") for it in losses(found, task, reading)]
        lines.append([reading, str(recommends), str(at_end), *cells])
    heads = ["reading", "recommends", "at an end"]
    heads += [it for task in ("objects", "vehicles") for it in (f"{task}: mean lost", "most", "rank")]
    of_task = {(it["task"], it["dataset"]): int(it["no"]) for it in found}
    n_objects, n_vehicles = (sum(n for key, n in of_task.items() if key[0] == it) for it in ("objects", "vehicles"))
    n_sets = len({it["dataset"] for it in found})
    note = f"{n_sets} data sets; {n_objects} annotated objects, {n_vehicles} vehicles."
    return Shown(table(heads, lines) + f"\n\n{note}")


def fitness_by_dataset(results: list[Result], task: str) -> Shown:
    """The best cell size of each data set, beside what Knuth's rule and the configuration recommend."""
    lines: dict[str, list[str]] = {}
    found = [it for it in verdicts(results) if it["task"] == task]
    # Only data sets of one sensor and one origin are summed.
    is_one = len({(it["sensor"], it["origin"]) for it in found}) == 1 and found[0]["origin"] == "simulated"
    for row in found:
        if row["dataset"].startswith("overall") and not is_one:
            continue
        # Data sets of one kind of street differ by their sensor.
        name = origin_in_words(row).replace(f"-{row['sensor']}", "")
        key = f"{row['dataset']} {row['rate']}"
        rate = percent(row["best_rate"]) + (" recall" if row["rate"] == "recall" else "")
        lines.setdefault(key, [name, row["sensor"], row["no"], number(row["best_cell_size_m"]), rate])
        if row["reading"] == "knuth":
            rank = number(row["rank_correlation"], 2)
            lines[key] += [number(row["recommended_cell_size_m"]), percent(row["loss"]), rank]
        elif row["reading"] == "as configured":
            lines[key].append(percent(row["loss"]))
    heads = ["data set", "sensor", "NO", "best m", "rate %", "Knuth m", "lost", "rank", "as configured: lost"]
    # A sweep that leaves out the configured cell size says nothing about it.
    padded = [it + [DASH] * (len(heads) - len(it)) for it in lines.values()]
    return Shown(table(heads, padded, 2))


def fitness_losses(results: list[Result], *names: str) -> Shown:
    """Mean and greatest loss of Knuth's rule and of the configured cell size, one column a command."""
    lines = []
    of_commands = [[it for it in rows(result, "cell_fitness.csv") if not it["dataset"].startswith("overall")] for result in results]
    for task in ("objects", "vehicles"):
        for reading in ("knuth", "as configured"):
            cells = []
            for found in of_commands:
                of_task = [it for it in found if it["task"] == task and it["reading"] == reading]
                cells.append(", ".join(losses(of_task, task, reading_in_words(of_task[0]))[:2]) if of_task else DASH)
            lines.append([task, reading, *cells])
    return Shown(table(["task", "reading", *(names or ["mean, most lost"])], lines, 2))


# Realism

ALIKE = 1.5
STATISTICS = {
    "returns_per_scan": "returns a scan",
    "ground_share": "share of ground",
    "ring_density": "density, rings 5 to 50 m",
    "points_per_car": "points a car, by range",
    "points_per_track": "points a track",
    "clusters_per_scan": "clusters a scan",
    "height_histogram": "heights",
}


def ratios(result: Result) -> tuple[str, dict[str, list[tuple[float, str]]]]:
    """What was measured, and the ratios of each statistic with the names of their bins."""
    found = rows(result, "realism.csv")
    of_statistic: dict[str, list[tuple[float, str]]] = {it: [] for it in STATISTICS}
    for row in found:
        is_ring = row["statistic"] == "ring_density"
        is_outside = is_ring and not (float(row["bin_from_m"]) >= 5 and float(row["bin_to_m"]) <= 50)
        if row["statistic"] in STATISTICS and row["ratio"] and not is_outside:
            of_statistic[row["statistic"]].append((float(row["ratio"]), row["bin"]))
    return found[0]["left"], of_statistic


def distance(ratio: float) -> float:
    """How far a ratio is from 1, either way."""
    return max(ratio, 1 / ratio) if ratio > 0 else float("inf")


def realism_agreement(results: list[Result]) -> Shown:
    """Share of bins that are alike, and the median ratio, of every statistic."""
    lines = []
    for result in results:
        name, of_statistic = ratios(result)
        cells = []
        for found in of_statistic.values():
            alike = [it for it, _ in found if 1 / ALIKE <= it <= ALIKE]
            median = statistics.median_low([it for it, _ in found]) if found else None
            cells.append(f"{share(len(alike), len(found))} %, {number(median, 2)}" if found else DASH)
        lines.append([name, *cells])
    return Shown(table(["", *STATISTICS.values()], lines))


def realism_worst(results: list[Result]) -> Shown:
    """The bin of every statistic that is farthest off, and its ratio."""
    lines = []
    for result in results:
        name, of_statistic = ratios(result)
        farthest = [max(it, key=lambda it: distance(it[0]), default=None) for it in of_statistic.values()]
        lines.append([name, *[f"{it[1]}: {number(it[0], 2)}" if it else DASH for it in farthest]])
    return Shown(table(["", *STATISTICS.values()], lines))


# Pictures


def picture(results: list[Result], source: str, target: str, words: str) -> Shown:
    """A plot that a command left behind."""
    path = results[0].directory / source
    if not path.is_file():
        raise ShowError(f"{results[0].command} left no {source}")
    return Shown(f"![{words}]({target})", {target: path.read_bytes()})


def viewer(results: list[Result], target: str, words: str) -> Shown:
    """The recording of a run as the Rerun viewer shows it."""
    return taken([CI / "recordings/picture", results[0].directory / "run.rrd"], target, words)


def report_page(results: list[Result], target: str, words: str) -> Shown:
    """The page of a run as a browser shows it, light and dark."""
    return taken([CI / "page/picture", results[0].directory / "report.html"], target, words)


def taken(command: list[Path], target: str, words: str) -> Shown:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "picture.png"
        ended = subprocess.run([*command, file], capture_output=True, text=True, check=False)
        if ended.returncode != 0 or not file.is_file():
            last = (ended.stdout + ended.stderr).strip().splitlines()[-3:]
            raise ShowError(f"{shlex.join(map(str, command))}: {' '.join(last)}")
        return Shown(f"![{words}]({target})", {target: file.read_bytes()})


SHOWS = {
    "file": file,
    "printed-table": printed_table,
    "detector-rules": detector_rules,
    "overall-rates": overall_rates,
    "over-seeds": over_seeds,
    "compared-detectors": compared_detectors,
    "compared-runs": compared_runs,
    "ablation-rates": ablation_rates,
    "rates-by-dataset": rates_by_dataset,
    "gap-shares": gap_shares,
    "gap-layouts": gap_layouts,
    "condition-changes": condition_changes,
    "box-fits": box_fits,
    "box-slices": box_slices,
    "fitness-summary": fitness_summary,
    "fitness-by-dataset": fitness_by_dataset,
    "fitness-losses": fitness_losses,
    "realism-agreement": realism_agreement,
    "realism-worst": realism_worst,
    "picture": picture,
    "viewer": viewer,
    "report-page": report_page,
}
