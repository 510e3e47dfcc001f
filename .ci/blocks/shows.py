"""What blocks show of the results of their commands: files that these leave, condensed tables of CSV files, pictures.

Every function of `SHOWN` takes the results of a block's commands, then the arguments of its line `shows: …`. It returns
Markdown, and if this shows a picture, the bytes of it by the path beside the page.
"""

import csv
import json
import re
import subprocess
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterable
from pathlib import Path
from statistics import mean, median_low, stdev
from typing import NamedTuple

DASH = "–"
TASKS = ("objects", "vehicles")
Row = dict[str, str]


class Result(NamedTuple):
    """What a command left behind."""

    command: str
    directory: Path
    printed: str


class CommandError(Exception):
    """A command that did not end well, or that left nothing of what is to be shown."""


def left(result: Result, name: str) -> Path:
    if not (path := result.directory / name).exists():
        raise CommandError(f"{result.command} left no {name}")
    return path


def rows(result: Result, name: str, **wanted: str) -> list[Row]:
    """The rows of a CSV file that have these values."""
    found = csv.DictReader(left(result, name).read_text().splitlines())
    return [it for it in found if all(it[column] == value for column, value in wanted.items())]


def of_datasets(found: list[Row]) -> list[Row]:
    return [it for it in found if not it["dataset"].startswith("overall")]


def summed(found: list[Row], by: list[str], columns: list[str]) -> dict[tuple[str, ...], list[int]]:
    sums: dict[tuple[str, ...], list[int]] = defaultdict(lambda: [0] * len(columns))
    for row in found:
        of_key = sums[tuple(row[it] for it in by)]
        of_key[:] = [n + int(row[it] or 0) for n, it in zip(of_key, columns)]
    return sums


def table(heads: list[str], lines: dict[tuple[str, ...], list[str]]) -> str:
    """A pipe table: the keys are text, the rest of each line are numbers."""
    n_left = len(next(iter(lines), [""]))
    rules = [":--" if n < n_left else "--:" for n in range(len(heads))]
    return "\n".join(map(row_of, [heads, rules, *([*key, *cells] for key, cells in lines.items())]))


def row_of(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |"


def number(value: float | str | None, decimals: int = 1, scale: float = 1.0) -> str:
    if value in (None, ""):
        return DASH
    text = f"{scale * float(value):.{decimals}f}"
    return text.lstrip("-") if float(text) == 0 else text.replace("-", "−")


def percent(value: float | str | None) -> str:
    return number(value, 1, 100.0)


def share(part: int, whole: int) -> str:
    return number(part / whole, 0, 100.0) if whole else DASH


def origin_in_words(row: Row) -> str:
    return f"{row['dataset']} (simulated)" if row["origin"] == "simulated" else row["dataset"]


def by_task(*heads: str, tasks: Iterable[str] = TASKS) -> list[str]:
    """Heads of columns for each task, the first with the name of the task."""
    return [it for task in tasks for it in (f"{task}: {heads[0]}", *heads[1:])]


def noted(text: str) -> str:
    """A table, and below it what the sign of some of its intervals means."""
    return text + "\n\n§ from fewer than ten blocks of scans: too few for a reliable interval." * ("§" in text)


# Runs


def overall_rows(result: Result, task: str) -> list[Row]:
    """What the detectors of a run reach on all its data sets together."""
    found = rows(result, f"table_{task}.csv", source="measured")
    return [it for it in found if it["dataset"] == "overall"] or found


def printed_table(results: list[Result], task: str) -> str:
    """The first table of a task, as a run prints it."""
    found = re.search(rf"^(Task {task} on .* Rates.*)\n\s*\n((?:.*\S.*\n)+)", results[0].printed, re.MULTILINE)
    if not found:
        raise CommandError(f"{results[0].command} printed no table of {task}")
    return noted("\n".join(["```text", found[1].rstrip(), "", *map(str.rstrip, found[2].splitlines()), "```"]))


def overall_rates(results: list[Result]) -> str:
    """Rates with their intervals of all detectors of a run: a row for each detector, both tasks."""
    lines, of_tasks = defaultdict(list), [overall_rows(results[0], task) for task in TASKS]
    for row in (row for found in of_tasks for row in found):
        few_blocks = "§" * (row.get("few_blocks") == "true")
        within = f"{percent(row['f_rate_low'])} to {percent(row['f_rate_high'])}{few_blocks}"
        lines[row["detector"],] += [percent(row["f_rate"]), within, percent(row["precision"]), percent(row["recall"])]
    for row in of_tasks[0]:
        lines[row["detector"],].append(number(row["fps_mean"], 0 if float(row["fps_mean"] or 0) >= 10 else 1))
    n_objects, n_vehicles = (it[0]["no"] for it in of_tasks)
    heads = ["detector", *by_task("F-rate", "95 % interval", "precision", "recall"), "fps"]
    return noted(f"{table(heads, lines)}\n\nRates in %, of {n_objects} annotated objects and {n_vehicles} vehicles.")


def over_seeds(results: list[Result]) -> str:
    """F-rates, and the lead of the first detector, over runs that differ in their seeds: mean and standard deviation."""
    lines = defaultdict(list)
    for task in TASKS:
        runs = [{it["detector"]: 100 * float(it["f_rate"]) for it in overall_rows(result, task)} for result in results]
        first, *_ = runs[0]
        for name in runs[0]:
            rate, lead = ([it[name] for it in runs], [it[first] - it[name] for it in runs])
            cells = [f"{mean(it):.1f} ± {stdev(it):.1f}" for it in (rate, lead)]
            lines[name,] += cells if name != first else [cells[0], ""]
    return table(["detector", *by_task("F-rate", "lead of the first")], lines)


def differences(result: Result) -> dict[tuple[str, str], Row]:
    """What `scanbench compare` printed of the F-rate, by task and what is compared."""
    lines = [it for it in result.printed.splitlines() if it.startswith("| ")]
    if len(lines) < 3:
        raise CommandError(f"{result.command} printed no table")
    heads, _, *cells = [[it.strip().replace("\\", "") for it in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    found = [dict(zip(heads, it)) for it in cells]
    return {(it["task"], it["detector"]): it for it in found if it["metric"].startswith("f_rate") and it["slice"] == "all"}


def compared_detectors(results: list[Result]) -> str:
    """Paired differences of detectors of one run in all tasks, one pair a command after the first."""
    lines, tasks = defaultdict(list), {}
    for (task, pair), it in (it for result in results[1:] for it in differences(result).items()):
        tasks[task] = None
        lines[pair,] += [it["difference"], it["95 %"]]
    return noted(table(["difference of F-rates", *by_task("points", "95 % interval", tasks=tasks)], lines))


def compared_runs(results: list[Result], *parts: str) -> str:
    """What each part is worth to each detector: a `compare` for each holds a run without it against the whole one."""
    found = [differences(it) for it in results if it.command.startswith("scanbench compare ")]
    if len(found) != len(parts):
        raise CommandError(f"{len(parts)} names for {len(found)} comparisons")
    tasks, detectors = (list(dict.fromkeys(it)) for it in zip(*(subject for it in found for subject in it)))
    of = dict(zip(parts, found))
    lines = {(part, task): [gain(of[part].get((task, it))) for it in detectors] for part in parts for task in tasks}
    return noted(table(["what it gives", "task", *detectors], lines))


def gain(difference: Row | None) -> str:
    """A difference with its interval; 0 if nothing changed in any scan."""
    text = f"{difference['difference']} ({difference['95 %']})" if difference else DASH
    return text if re.search(f"[1-9{DASH}]", text) else "0"


def ablation_rates(results: list[Result]) -> str:
    """The F-rate on simulated data and the recall on recorded ones, of variants of a method and of detectors of a run."""
    ablation, *runs = results
    others = [it for run in runs for it in rows(run, "table_objects.csv", source="measured")]
    others = [it | {"variant": f"*{it['detector']}*"} for it in others if it["detector"] != "hierarchical"]
    found = of_datasets(rows(ablation, "ablation.csv") + others)
    sums, lines = summed(found, ["variant", "origin"], ["no", "tp", "fo"]), {}
    for name in dict.fromkeys(it["variant"] for it in found):
        (no, tp, fo), (no_recorded, tp_recorded, _) = sums[name, "simulated"], sums[name, "recorded"]
        recorded = tp_recorded / no_recorded if no_recorded else None
        lines[name,] = [percent(2 * tp / (no + tp + fo) if tp else None), percent(recorded)]
    (first,) = next(iter(lines))
    note = f"{sums[first, 'simulated'][0]} simulated annotations, {sums[first, 'recorded'][0]} recorded ones."
    return table(["", "F-rate", "recall on KITTI"], lines) + f"\n\n{note}"


def rates_by_dataset(results: list[Result], *tasks: str) -> str:
    """F-rates of tasks, data set by data set and detector by detector; recall where false objects cannot be known."""
    lines, detectors = defaultdict(list), {}
    for task in tasks:
        for row in (row for it in results for row in of_datasets(rows(it, f"table_{task}.csv", source="measured"))):
            of = "" if row["f_rate"] else "recall of "
            lines[f"{origin_in_words(row)}, {of}{row['no']} {task}",].append(percent(row["f_rate"] or row["recall"]))
            detectors[row["detector"]] = None
    return table(["", *detectors], lines)


def rates_with_intervals(results: list[Result], task: str) -> str:
    """F-rates of a task with 95 % intervals, data set by data set and over all; recall where false ones cannot be known."""
    lines, detectors = defaultdict(list), {}
    for row in (row for it in results for row in rows(it, f"table_{task}.csv", source="measured")):
        metric = "f_rate" if row["f_rate"] else "recall"
        ends = [percent(row[f"{metric}_{end}"]) for end in ("low", "high") if row[f"{metric}_{end}"]]
        within = f" ({' to '.join(ends)})" if ends else ""
        name = "all" if row["dataset"] == "overall" else row["dataset"]
        key = f"{name}{', recall' * (metric == 'recall')}", row["n_scans"], row["no"]
        lines[key].append(f"{percent(row[metric])}{within}{'§' * (row['few_blocks'] == 'true')}")
        detectors[row["detector"]] = None
    return noted(table(["", "scans", task, *detectors], lines))


# Experiments


def file(results: list[Result], name: str, *without: str) -> str:
    """A Markdown file that a command left behind, its table without these columns."""
    lines = left(results[0], name).read_text().splitlines()
    cells = {n: it.removeprefix("| ").removesuffix(" |").split(" | ") for n, it in enumerate(lines) if it.startswith("| ")}
    kept = [n for n, it in enumerate(next(iter(cells.values()), [])) if it not in without]
    return "\n".join(row_of([cells[n][it] for it in kept]) if n in cells else line for n, line in enumerate(lines))


def file_head(results: list[Result], name: str, n_rows: str) -> str:
    """A Markdown file that a command left behind, from its table on, of which only the first rows."""
    lines = left(results[0], name).read_text().splitlines()
    first = next(n for n, it in enumerate(lines) if it.startswith("|"))
    end = next((n for n, it in enumerate(lines[first:], first) if not it.startswith("|")), len(lines))
    return "\n".join([*lines[first : min(end, first + 2 + int(n_rows))], *lines[end:]])


# What a reading of a paper rests on, most of the text first.
BASES = ["text", "open", "ours", "rival_denied"]


def claims(results: list[Result], paper: str) -> str:
    """A row for each claim of a paper: numbers of the first reading, the verdict, and the reading that it rests on."""
    lines, verdicts = {}, Counter()
    for it in json.loads(left(results[0], "reproduction.json").read_text())["claims"]:
        if it["claim"]["paper"] != paper:
            continue
        first, *others = it["readings"]
        # The first of those with most of the text; bases are written in that order.
        held = [other for other in others if other["holds"] and it["verdict"] != "holds"]
        under = min(held, key=lambda other: BASES.index(other["basis"]))["reading"] if held else ""
        verdict = it["verdict"].replace("_", " ")
        verdicts[verdict] += 1
        verdict += f" ({under})" * bool(under)
        if it["settings"]:
            verdict += f"; {it['settings'][0]} of {it['settings'][1]} settings"
        here = "; ".join(filter(None, [first["numbers"], first["difference"]]))
        if it["claim"]["test"]["kind"] == "faster":
            here += "".join(f"; {other['reading']}: {other['difference']}" for other in others)
        lines[it["claim"]["says"], it["claim"]["printed"], here, verdict] = []
    summary = ", ".join(f"{verdict}: {n}" for verdict, n in verdicts.most_common())
    return f"{verdicts.total()} claims ({summary}).\n\n{table(['claim', 'printed', 'here', 'verdict'], lines)}"


def gaps_by(found: list[Row], keys: list[str]) -> tuple[list[str], dict[tuple[str, ...], list[str]]]:
    """The detectors; and by `keys` how many pairs were judged, and what share of them each detector separated."""
    sums = summed(found, [*keys, "detector"], ["n_seen", "n_separated"])
    detectors = list(dict.fromkeys(it["detector"] for it in found))
    lines = {key[:-1]: [str(sums[*key[:-1], detectors[0]][0])] for key in sums}
    for key, cells in lines.items():
        cells += [share(sums[*key, it][1], sums[*key, it][0]) for it in detectors]
    return detectors, lines


def gap_shares(results: list[Result]) -> str:
    """Pairs of objects that are separated, by range and every fourth gap."""
    found = [it for it in rows(results[0], "gaps.csv") if round(10 * float(it["gap_m"])) % 4 == 2]
    detectors, cells = gaps_by(found, ["range_from_m", "range_to_m", "gap_m"])
    by_number = sorted((*map(float, key), it) for key, it in cells.items())
    lines = {(f"{near:g} to {far:g}", f"{gap:.1f}"): it for near, far, gap, it in by_number}
    return table(["range m", "gap m", "judged", *detectors], lines)


def gap_layouts(results: list[Result]) -> str:
    """The same by how the pair stands, over all ranges and gaps."""
    detectors, lines = gaps_by(rows(results[0], "gaps.csv"), ["layout"])
    return table(["layout", "judged", *detectors], lines)


def condition_changes(results: list[Result], *detectors: str) -> str:
    """What each condition does to the F-rates of these detectors, in points against the first one."""
    rates = defaultdict(dict)
    for row in (it for it in rows(results[0], "robustness.csv") if it["detector"] in detectors):
        rates[row["group"], row["condition"]][row["detector"], row["task"]] = row["f_rate"]
    standard, *_ = rates.values()
    lines = {}
    for names, of_condition in list(rates.items())[1:]:
        pairs = [(of_condition[it], standard[it]) for it in standard]
        changes = [percent(float(a) - float(b)) if a and b else DASH for a, b in pairs]
        lines[names] = [it if it[0] in (DASH, "−") else f"+{it}" for it in changes]
    return table(["kind", "condition", *map(", ".join, standard)], lines)


def box_fits(results: list[Result]) -> str:
    """How boxes of each kind do around the same clusters, without the looser of two limits."""
    looser = ("yaw within 10 deg", "BEV IoU >= 0.5", "3D IoU >= 0.5")
    found = [it for it in rows(results[0], "box_errors.csv", by="all") if it["error"] not in looser]
    lines = defaultdict(list)
    for row in found:
        lines[row["fit"],].append(number(row["value"], 2 if row["unit"] == "m" else 1))
    heads = dict.fromkeys(f"{it['error']}, {it['unit']}" for it in found)
    return table(["", *heads], lines) + f"\n\n{found[0]['n_pairs']} vehicles, {found[0]['n_tracks']} tracks."


def box_slices(results: list[Result]) -> str:
    """The share with the right box, slice by slice."""
    fits, what = ["hull box", "reported box"], "BEV IoU >= 0.7"
    words = {"all": "all", "occlusion": "hidden: ", "range": "", "class": "", "points": "points: "}
    lines = {}
    for row in rows(results[0], "box_errors.csv", error=what):
        if row["fit"] in fits and row["n_pairs"] != "0":
            lines.setdefault((words[row["by"]] + row["slice"],), [row["n_pairs"]]).append(number(row["value"], 1))
    return table([f"{what}, %", "vehicles", *fits], lines)


# Cell fitness

FITNESS = ["best m", "rate %", "Knuth m", "lost", "as configured: lost"]


def losses(found: list[Row], task: str, reading: str) -> list[str]:
    """The mean and greatest loss of a reading over data sets, in points, and its mean rank correlation."""
    of_reading = [it for it in found if it["task"] == task and it["reading"] == reading]
    lost = [float(it["loss"]) for it in of_reading if it["loss"]]
    ranks = [float(it["rank_correlation"]) for it in of_reading if it["rank_correlation"]]
    return [*map(percent, (mean(lost), max(lost)) if lost else (None, None)), number(mean(ranks) if ranks else None, 2)]


def fitness_summary(results: list[Result]) -> str:
    """What each reading recommends and costs, each data set counting once."""
    found, lines = of_datasets(rows(results[0], "cell_fitness.csv", rate="F-rate")), {}
    for reading in dict.fromkeys(it["reading"] for it in found):
        objects = [it for it in found if it["task"] == "objects" and it["reading"] == reading]
        recommends = sum(bool(it["recommended_cell_size_m"]) for it in objects)
        at_end = sum(it["recommends_an_end"] == "true" for it in objects)
        configured = f"always {number(objects[0]['recommended_cell_size_m'], 2)} m"
        name = configured if reading == "as configured" else f"`{reading}`"
        lines[name,] = [str(recommends), str(at_end), *(it for task in TASKS for it in losses(found, task, reading))]
    of_task = {(it["task"], it["dataset"]): int(it["no"]) for it in found}
    n_objects, n_vehicles = (sum(n for key, n in of_task.items() if key[0] == it) for it in TASKS)
    note = f"{len({it['dataset'] for it in found})} data sets; {n_objects} annotated objects, {n_vehicles} vehicles."
    return table(["reading", "recommends", "at an end", *by_task("mean lost", "most", "rank")], lines) + f"\n\n{note}"


def fitness_by_dataset(results: list[Result], task: str) -> str:
    """The best cell size of each data set, beside what Knuth's rule and the configuration recommend."""
    lines = {}
    for row in of_datasets(rows(results[0], "cell_fitness.csv", task=task)):
        rate = percent(row["best_rate"]) + " recall" * (row["rate"] == "recall")
        # A sweep that leaves out the configured cell size says nothing about it.
        first = [row["no"], number(row["best_cell_size_m"]), rate, DASH, DASH, DASH]
        cells = lines.setdefault((origin_in_words(row),), first)
        if row["reading"] == "knuth":
            cells[3:5] = [number(row["recommended_cell_size_m"]), percent(row["loss"])]
        elif row["reading"] == "as configured":
            cells[5] = percent(row["loss"])
    return table(["data set", "NO", *FITNESS], lines)


def fitness_by_sensor(results: list[Result], task: str) -> str:
    """The least and the greatest of these numbers over the data sets of each sensor; F-rates only."""
    found, lines = of_datasets(rows(results[0], "cell_fitness.csv", task=task, rate="F-rate")), {}
    columns = [
        ("knuth", "best_cell_size_m", number), ("knuth", "best_rate", percent), ("knuth", "recommended_cell_size_m", number),
        ("knuth", "loss", percent), ("as configured", "loss", percent),
    ]  # fmt: skip
    for sensor in dict.fromkeys(it["sensor"] for it in found):
        of_sensor = [it for it in found if it["sensor"] == sensor]
        cells = lines[sensor,] = [str(sum(int(it["no"]) for it in of_sensor if it["reading"] == "knuth"))]
        for reading, column, cell in columns:
            values = [float(it[column]) for it in of_sensor if it["reading"] == reading and it[column]]
            cells.append(" to ".join(dict.fromkeys(map(cell, (min(values), max(values))))) if values else DASH)
    return table(["sensor", "NO", *FITNESS], lines)


# Realism

ALIKE = 1.5
STATISTICS = {
    "returns_per_scan": "returns a scan",
    "ground_share": "share of ground",
    "ring_density": "density, rings 5 to 50 m",
    "points_per_car": "points a car, by range",
    "points_per_track": "points a track",
    "points_on_sides": "points on sides",
    "rough_points": "rough points",
    "clusters_per_scan": "clusters a scan",
    "clusters_by_range": "clusters by range",
    "height_histogram": "heights",
}


def realism_agreement(results: list[Result]) -> str:
    """A row for every command: share of bins that are alike, and the median ratio, of every statistic."""
    lines = {}
    for result in results:
        found, ratios = rows(result, "realism.csv"), defaultdict(list)
        for row in found:
            is_near = row["statistic"] != "ring_density" or (float(row["bin_from_m"]) >= 5 and float(row["bin_to_m"]) <= 50)
            if row["ratio"] and is_near:
                ratios[row["statistic"]].append(float(row["ratio"]))
        lines[found[0]["left"], found[0]["right"]] = [agreement(ratios[it]) for it in STATISTICS]
    return table(["simulated", "recorded", *STATISTICS.values()], lines)


def agreement(ratios: list[float]) -> str:
    n_alike = sum(1 / ALIKE <= it <= ALIKE for it in ratios)
    return f"{share(n_alike, len(ratios))} %, {number(median_low(ratios), 2)}" if ratios else DASH


def streaming_rates(results: list[Result]) -> str:
    """How detectors do per scan and as they stream, on all data sets together."""
    found = [it for it in rows(results[-1], "streaming.csv", slice="all") if it["dataset"].startswith("overall")]
    lines: dict[tuple[str, ...], list[str]] = {}
    for task in TASKS:
        of_task = [it for it in found if it["task"] == task]
        for detector in dict.fromkeys(it["detector"] for it in of_task):
            of_it = [it for it in of_task if it["detector"] == detector]
            here = {it["forecast"]: it for it in of_it if it["judged"] == "streams" and float(it["machine_speed"]) == 1}
            streams = here["car-motion"]
            scans, truth = (next(it for it in of_it if it["judged"] == judged) for judged in ("scans", "late-truth"))
            within = f"{percent(streams['low'])} to {percent(streams['high'])}"
            lines[(task, detector)] = [
                percent(scans["f_rate"]),
                f"{percent(streams['f_rate'])} ({within})",
                *(percent(it["f_rate"]) for it in (here["hold"], here["constant-velocity"], truth)),
                number(streams["age_p50_ms"], 0),
                number(streams["age_p95_ms"], 0),
                percent(streams["dropped"]),
            ]
    heads = ["task", "detector", "scans", "streams", "held", "tracked", "truth", "age, median (ms)", "95 % (ms)", "dropped (%)"]
    return table(heads, lines)


# Pictures


def picture(results: list[Result], source: str, target: str, words: str) -> tuple[str, dict[str, bytes]]:
    """A plot that the last command left behind."""
    return f"![{words}]({target})", {target: left(results[-1], source).read_bytes()}


def viewer(results: list[Result], target: str, words: str) -> tuple[str, dict[str, bytes]]:
    """The recording of a run as the Rerun viewer shows it."""
    return taken("recordings", left(results[0], "recording"), target, words)


def report_page(results: list[Result], target: str, words: str) -> tuple[str, dict[str, bytes]]:
    """The page of a run as a browser shows it, light and dark."""
    return taken("page", left(results[0], "report.html"), target, words)


def taken(by: str, of: Path, target: str, words: str) -> tuple[str, dict[str, bytes]]:
    with tempfile.TemporaryDirectory() as folder:
        command, path = Path(__file__).resolve().parents[1] / by / "picture", Path(folder) / "picture.png"
        ended = subprocess.run([command, of, path], capture_output=True, text=True, check=False)
        if ended.returncode != 0 or not path.is_file():
            last = (ended.stdout + ended.stderr).strip().splitlines()[-3:]
            raise CommandError(f"{command} {of}: {' '.join(last)}")
        return f"![{words}]({target})", {target: path.read_bytes()}


SHOWN = [
    file, file_head, claims, printed_table, overall_rates, over_seeds, compared_detectors, compared_runs,
    ablation_rates, rates_by_dataset, rates_with_intervals, gap_shares, gap_layouts, condition_changes, box_fits, box_slices,
    fitness_summary, fitness_by_dataset, fitness_by_sensor, realism_agreement, streaming_rates, picture, viewer, report_page,
]  # fmt: skip
SHOWS = {it.__name__.replace("_", "-"): it for it in SHOWN}
