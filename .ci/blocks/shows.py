"""What blocks show of the results of their commands: files that these leave, condensed tables of CSV files, pictures.

Every function in `SHOWS` takes the results of a block's commands, then the arguments of its line `shows: …`.
"""

import csv
import json
import re
import shlex
import subprocess
import tempfile
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from statistics import mean, median_low, stdev

from commands import Result
from stamp import words_of

CI = Path(__file__).resolve().parents[1]
DASH = "–"
TASKS = ("objects", "vehicles")


class ShowError(Exception):
    """Results that do not have what is to be shown."""


@dataclass
class Shown:
    text: str
    files: dict[str, bytes] = field(default_factory=dict)  # pictures, by their path beside the page


def left(result: Result, name: str) -> Path:
    if not (path := result.directory / name).is_file():
        raise ShowError(f"{result.command} left no {name}")
    return path


def rows(result: Result, name: str) -> list[dict[str, str]]:
    return list(csv.DictReader(left(result, name).read_text().splitlines()))


def of_datasets(found: list[dict[str, str]]) -> list[dict[str, str]]:
    return [it for it in found if not it["dataset"].startswith("overall")]


def table(heads: list[str], lines: list[list[str]], n_left: int = 1) -> str:
    """A pipe table, of which the first `n_left` columns are text and the others numbers."""
    rules = [":--" if n < n_left else "--:" for n in range(len(heads))]
    return "\n".join(map(row_of, [heads, rules, *lines]))


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


def origin_in_words(row: dict[str, str]) -> str:
    return f"{row['dataset']} (simulated)" if row["origin"] == "simulated" else row["dataset"]


def noted(text: str) -> Shown:
    """A table, and below it what the sign of some of its intervals means."""
    return Shown(text + "\n\n§ from fewer than ten blocks of scans: too few for a reliable interval." * ("§" in text))


# Runs


def measured(result: Result, task: str) -> list[dict[str, str]]:
    return [it for it in rows(result, f"table_{task}.csv") if it["source"] == "measured"]


def overall_rows(result: Result, task: str) -> list[dict[str, str]]:
    """What the detectors of a run reach on all its data sets together."""
    found = measured(result, task)
    return [it for it in found if it["dataset"] == "overall"] or found


def printed_table(results: list[Result], task: str) -> Shown:
    """The first table of a task, as a run prints it."""
    found = re.search(rf"^(Task {task} on .* Rates.*)\n\s*\n((?:.*\S.*\n)+)", results[0].printed, re.MULTILINE)
    if not found:
        raise ShowError(f"{results[0].command} printed no table of {task}")
    lines = [it.rstrip() for it in [found[1], "", *found[2].splitlines()]]
    return noted("```text\n" + "\n".join(lines) + "\n```")


def overall_rates(results: list[Result]) -> Shown:
    """Rates with their intervals of all detectors of a run: a row for each detector, both tasks."""
    lines: dict[str, list[str]] = defaultdict(list)
    of_tasks = {task: overall_rows(results[0], task) for task in TASKS}
    for row in (row for found in of_tasks.values() for row in found):
        few_blocks = "§" * (row.get("few_blocks") == "true")
        within = f"{percent(row['f_rate_low'])} to {percent(row['f_rate_high'])}{few_blocks}"
        lines[row["detector"]] += [percent(row["f_rate"]), within, percent(row["precision"]), percent(row["recall"])]
    for row in of_tasks["objects"]:
        lines[row["detector"]].append(number(row["fps_mean"], 0 if float(row["fps_mean"] or 0) >= 10 else 1))
    heads = [it for task in TASKS for it in (f"{task}: F-rate", "95 % interval", "precision", "recall")]
    note = f"Rates in %, of {of_tasks['objects'][0]['no']} annotated objects and {of_tasks['vehicles'][0]['no']} vehicles."
    return noted(table(["detector", *heads, "fps"], [[name, *cells] for name, cells in lines.items()]) + f"\n\n{note}")


def over_seeds(results: list[Result]) -> Shown:
    """F-rates, and the lead of the first detector, over runs that differ in their seeds: mean and standard deviation."""
    lines: dict[str, list[str]] = defaultdict(list)
    for task in TASKS:
        runs = [{it["detector"]: 100 * float(it["f_rate"]) for it in overall_rows(result, task)} for result in results]
        first, *_ = runs[0]
        for detector in runs[0]:
            rates, leads = [it[detector] for it in runs], [it[first] - it[detector] for it in runs]
            cells = [f"{mean(it):.1f} ± {stdev(it):.1f}" for it in (rates, leads)]
            lines[detector] += [cells[0], cells[1] * (detector != first)]
    heads = [it for task in TASKS for it in (f"{task}: F-rate", "lead of the first")]
    return Shown(table(["detector", *heads], [[name, *cells] for name, cells in lines.items()]))


def differences(result: Result) -> dict[tuple[str, str], dict[str, str]]:
    """What `scanbench compare` printed of the F-rate, by task and what is compared."""
    lines = [it for it in result.printed.splitlines() if it.startswith("| ")]
    if len(lines) < 3:
        raise ShowError(f"{result.command} printed no table")
    heads, _, *cells = [[it.strip().replace("\\", "") for it in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    found = [dict(zip(heads, it)) for it in cells]
    return {(it["task"], it["detector"]): it for it in found if it["metric"].startswith("f_rate") and it["slice"] == "all"}


def compared_detectors(results: list[Result]) -> Shown:
    """Paired differences of detectors of one run in both tasks, one pair a command after the first."""
    lines: dict[str, list[str]] = defaultdict(list)
    for (_, pair), it in (it for result in results[1:] for it in differences(result).items()):
        lines[pair] += [it["difference"], it["95 %"]]
    heads = [it for task in TASKS for it in (f"{task}: points", "95 % interval")]
    return noted(table(["difference of F-rates", *heads], [[pair, *cells] for pair, cells in lines.items()]))


def compared_runs(results: list[Result], *names: str) -> Shown:
    """What each part is worth to each detector: `compare` holds a run without it against the whole one.

    `names` are those of the parts, in the order of the comparisons.
    """
    compared = [it for it in results if words_of(it.command)[0] == "compare"]
    if len(compared) != len(names):
        raise ShowError(f"{len(names)} names for {len(compared)} comparisons")
    found = [differences(it) for it in compared]
    subjects = dict.fromkeys(subject for it in found for subject in it)
    tasks, detectors = (list(dict.fromkeys(it)) for it in zip(*subjects))
    lines = []
    for (part, of_part), task in product(zip(names, found), tasks):
        lines.append([part, task, *(gain(of_part.get((task, detector))) for detector in detectors)])
    return noted(table(["what it gives", "task", *detectors], lines, 2))


def gain(difference: dict[str, str] | None) -> str:
    """A difference with its interval; 0 if nothing changed in any scan."""
    if not difference:
        return DASH
    text = f"{difference['difference']} ({difference['95 %']})"
    return text if re.search("[1-9]", text) else "0"


def ablation_rates(results: list[Result]) -> Shown:
    """The F-rate on simulated data and the recall on recorded ones, of variants of a method and of the detectors of a run."""
    ablation, *runs = results
    counted = [(it["variant"], it) for it in rows(ablation, "ablation.csv")]
    others = [it for run in runs for it in measured(run, "objects") if it["detector"] != "hierarchical"]
    counted += [(f"*{it['detector']}*", it) for it in others]
    sums: dict[str, dict[str, list[int]]] = defaultdict(lambda: defaultdict(lambda: [0, 0, 0]))
    for name, row in counted:
        if of_datasets([row]):
            so_far = sums[name][row["origin"]]
            so_far[:] = [n + int(row[it] or 0) for n, it in zip(so_far, ("no", "tp", "fo"))]
    lines = []
    for name, of_origin in sums.items():
        (no, tp, fo), (no_recorded, tp_recorded, _) = of_origin["simulated"], of_origin["recorded"]
        rate = 2 * tp / (no + tp + fo) if tp else None
        recorded = tp_recorded / no_recorded if no_recorded else None
        lines.append([name, percent(rate), percent(recorded)])
    first = next(iter(sums.values()))
    note = f"{first['simulated'][0]} simulated annotations, {first['recorded'][0]} recorded ones."
    return Shown(table(["", "F-rate", "recall on KITTI"], lines) + f"\n\n{note}")


def rates_by_dataset(results: list[Result], *tasks: str) -> Shown:
    """F-rates of tasks, data set by data set and detector by detector; recall where false objects cannot be known."""
    lines: dict[str, list[str]] = defaultdict(list)
    detectors: dict[str, None] = {}
    for task, row in ((task, row) for task in tasks for result in results for row in of_datasets(measured(result, task))):
        of = "" if row["f_rate"] else "recall of "
        lines[f"{origin_in_words(row)}, {of}{row['no']} {task}"].append(percent(row["f_rate"] or row["recall"]))
        detectors[row["detector"]] = None
    return Shown(table(["", *detectors], [[name, *it] for name, it in lines.items()]))


# Experiments


def file(results: list[Result], name: str, *without: str) -> Shown:
    """A Markdown file that a command left behind, its table without these columns."""
    lines = left(results[0], name).read_text().splitlines()
    cells = {n: it.removeprefix("| ").removesuffix(" |").split(" | ") for n, it in enumerate(lines) if it.startswith("| ")}
    kept = [n for n, it in enumerate(next(iter(cells.values()), [])) if it not in without]
    return Shown("\n".join(row_of([cells[n][it] for it in kept]) if n in cells else line for n, line in enumerate(lines)))


def file_head(results: list[Result], name: str, n_rows: str) -> Shown:
    """A Markdown file that a command left behind, from its table on, of which only the first rows."""
    lines = left(results[0], name).read_text().splitlines()
    first = next(n for n, it in enumerate(lines) if it.startswith("|"))
    end = next((n for n, it in enumerate(lines[first:], first) if not it.startswith("|")), len(lines))
    return Shown("\n".join([*lines[first : min(end, first + 2 + int(n_rows))], *lines[end:]]))


def claims(results: list[Result], paper: str) -> Shown:
    """A row for each claim of a paper: numbers of the first reading, the verdict, other readings under which it holds."""
    lines = []
    for it in json.loads(left(results[0], "reproduction.json").read_text())["claims"]:
        if it["claim"]["paper"] != paper:
            continue
        first, *others = it["readings"]
        under = "; ".join(other["reading"] for other in others if other["holds"] and it["verdict"] != "holds")
        verdict = it["verdict"].replace("_", " ") + f" ({under})" * bool(under)
        if it["settings"]:
            verdict += f"; {it['settings'][0]} of {it['settings'][1]} settings"
        here = "; ".join(filter(None, [first["numbers"], first["difference"]]))
        lines.append([it["claim"]["says"], it["claim"]["printed"], here, verdict])
    verdicts = Counter(re.split(r" \(|;", it[-1])[0] for it in lines)
    summary = ", ".join(f"{verdict}: {n}" for verdict, n in verdicts.most_common())
    heads = ["claim", "printed", "here", "verdict"]
    return Shown(f"{len(lines)} claims ({summary}).\n\n{table(heads, lines, 4)}")


def gaps_by(found: list[dict[str, str]], keys: list[str]) -> tuple[list[str], list[tuple[tuple[str, ...], list[str]]]]:
    """The detectors; and by `keys` how many pairs were judged, and what share of them each detector separated."""
    sums: dict[tuple[str, ...], dict[str, list[int]]] = defaultdict(lambda: defaultdict(lambda: [0, 0]))
    for row in found:
        cell = sums[tuple(row[it] for it in keys)][row["detector"]]
        cell[:] = [cell[0] + int(row["n_seen"]), cell[1] + int(row["n_separated"])]
    detectors = list(dict.fromkeys(it["detector"] for it in found))
    cells = [[str(it[detectors[0]][0]), *(share(it[name][1], it[name][0]) for name in detectors)] for it in sums.values()]
    return detectors, list(zip(sums, cells))


def gap_shares(results: list[Result]) -> Shown:
    """Pairs of objects that are separated, by range and every fourth gap."""
    found = [it for it in rows(results[0], "gaps.csv") if round(10 * float(it["gap_m"])) % 4 == 2]
    detectors, cells = gaps_by(found, ["range_from_m", "range_to_m", "gap_m"])
    lines = [[*map(float, key), it] for key, it in cells]
    texts = [[f"{near:g} to {far:g}", f"{gap:.1f}", *it] for near, far, gap, it in sorted(lines)]
    return Shown(table(["range m", "gap m", "judged", *detectors], texts, 2))


def gap_layouts(results: list[Result]) -> Shown:
    """The same by how the pair stands, over all ranges and gaps."""
    detectors, cells = gaps_by(rows(results[0], "gaps.csv"), ["layout"])
    return Shown(table(["layout", "judged", *detectors], [[layout, *it] for (layout,), it in cells]))


def condition_changes(results: list[Result], *detectors: str) -> Shown:
    """What each condition does to the F-rates of these detectors, in points against the first one."""
    rates: dict[tuple[str, ...], dict[tuple[str, str], str]] = defaultdict(dict)
    for row in (it for it in rows(results[0], "robustness.csv") if it["detector"] in detectors):
        rates[row["group"], row["condition"]][row["detector"], row["task"]] = row["f_rate"]
    standard, *_ = rates.values()
    lines = []
    for names, of_condition in list(rates.items())[1:]:
        pairs = [(of_condition[it], standard[it]) for it in standard]
        changes = [percent(float(a) - float(b)) if a and b else DASH for a, b in pairs]
        lines.append([*names, *(it if it[0] in (DASH, "−") else f"+{it}" for it in changes)])
    return Shown(table(["kind", "condition", *map(", ".join, standard)], lines, 2))


def box_fits(results: list[Result]) -> Shown:
    """How boxes of each kind do around the same clusters, without the looser of two limits."""
    looser = ("yaw within 10 deg", "BEV IoU >= 0.5", "3D IoU >= 0.5")
    found = [it for it in rows(results[0], "box_errors.csv") if it["by"] == "all" and it["error"] not in looser]
    lines: dict[str, list[str]] = defaultdict(list)
    for row in found:
        lines[row["fit"]].append(number(row["value"], 2 if row["unit"] == "m" else 1))
    heads = dict.fromkeys(f"{it['error']}, {it['unit']}" for it in found)
    note = f"{found[0]['n_pairs']} vehicles, {found[0]['n_tracks']} tracks."
    return Shown(table(["", *heads], [[fit, *cells] for fit, cells in lines.items()]) + f"\n\n{note}")


def box_slices(results: list[Result]) -> Shown:
    """The share with the right box, slice by slice."""
    fits, what = ["hull box", "reported box"], "BEV IoU >= 0.7"
    words = {"all": "all", "occlusion": "hidden: ", "range": "", "class": "", "points": "points: "}
    lines: dict[str, list[dict[str, str]]] = defaultdict(list)
    for row in rows(results[0], "box_errors.csv"):
        if row["fit"] in fits and row["error"] == what and row["n_pairs"] != "0":
            lines[words[row["by"]] + row["slice"]].append(row)
    texts = [[name, found[0]["n_pairs"], *(number(it["value"], 1) for it in found)] for name, found in lines.items()]
    return Shown(table([f"{what}, %", "vehicles", *fits], texts))


# Cell fitness


def losses(found: list[dict[str, str]], task: str, reading: str) -> list[str]:
    """The mean and greatest loss of a reading over data sets, in points, and its mean rank correlation."""
    of_reading = [it for it in found if it["task"] == task and it["reading"] == reading]
    lost = [float(it["loss"]) for it in of_reading if it["loss"]]
    ranks = [float(it["rank_correlation"]) for it in of_reading if it["rank_correlation"]]
    return [*map(percent, (mean(lost), max(lost)) if lost else (None, None)), number(mean(ranks) if ranks else None, 2)]


def fitness_summary(results: list[Result]) -> Shown:
    """What each reading recommends and costs, each data set counting once."""
    found = [it for it in of_datasets(rows(results[0], "cell_fitness.csv")) if it["rate"] == "F-rate"]
    lines = []
    for reading in dict.fromkeys(it["reading"] for it in found):
        objects = [it for it in found if it["task"] == "objects" and it["reading"] == reading]
        recommends = sum(bool(it["recommended_cell_size_m"]) for it in objects)
        at_end = sum(it["recommends_an_end"] == "true" for it in objects)
        configured = f"always {number(objects[0]['recommended_cell_size_m'], 2)} m"
        name = configured if reading == "as configured" else f"`{reading}`"
        lines.append([name, str(recommends), str(at_end), *(it for task in TASKS for it in losses(found, task, reading))])
    heads = [it for task in TASKS for it in (f"{task}: mean lost", "most", "rank")]
    of_task = {(it["task"], it["dataset"]): int(it["no"]) for it in found}
    n_objects, n_vehicles = (sum(n for key, n in of_task.items() if key[0] == it) for it in TASKS)
    note = f"{len({it['dataset'] for it in found})} data sets; {n_objects} annotated objects, {n_vehicles} vehicles."
    return Shown(table(["reading", "recommends", "at an end", *heads], lines) + f"\n\n{note}")


def fitness_by_dataset(results: list[Result], task: str) -> Shown:
    """The best cell size of each data set, beside what Knuth's rule and the configuration recommend."""
    lines: dict[tuple[str, str], list[str]] = {}
    for row in (it for it in of_datasets(rows(results[0], "cell_fitness.csv")) if it["task"] == task):
        rate = percent(row["best_rate"]) + " recall" * (row["rate"] == "recall")
        first = [origin_in_words(row), row["no"], number(row["best_cell_size_m"]), rate]
        cells = lines.setdefault((row["dataset"], row["rate"]), first)
        if row["reading"] == "knuth":
            cells += [number(row["recommended_cell_size_m"]), percent(row["loss"])]
        elif row["reading"] == "as configured":
            cells.append(percent(row["loss"]))
    heads = ["data set", "NO", "best m", "rate %", "Knuth m", "lost", "as configured: lost"]
    # A sweep that leaves out the configured cell size says nothing about it.
    return Shown(table(heads, [it + [DASH] * (len(heads) - len(it)) for it in lines.values()]))


def fitness_by_sensor(results: list[Result], task: str) -> Shown:
    """The least and the greatest of these numbers over the data sets of each sensor; F-rates only."""
    found = of_datasets(rows(results[0], "cell_fitness.csv"))
    found = [it for it in found if it["task"] == task and it["rate"] == "F-rate"]
    columns = [
        ("knuth", "best_cell_size_m", number), ("knuth", "best_rate", percent), ("knuth", "recommended_cell_size_m", number),
        ("knuth", "loss", percent), ("as configured", "loss", percent),
    ]  # fmt: skip
    lines = []
    for sensor in dict.fromkeys(it["sensor"] for it in found):
        of_sensor = [it for it in found if it["sensor"] == sensor]
        lines.append([sensor, str(sum(int(it["no"]) for it in of_sensor if it["reading"] == "knuth"))])
        for reading, column, cell in columns:
            values = [float(it[column]) for it in of_sensor if it["reading"] == reading and it[column]]
            ends = list(dict.fromkeys(map(cell, (min(values), max(values))))) if values else [DASH]
            lines[-1].append(" to ".join(ends))
    heads = ["sensor", "NO", "best m", "rate %", "Knuth m", "lost", "as configured: lost"]
    return Shown(table(heads, lines))


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


def realism_agreement(results: list[Result]) -> Shown:
    """A row for every command: share of bins that are alike, and the median ratio, of every statistic."""
    lines = []
    for result in results:
        found = rows(result, "realism.csv")
        ratios: dict[str, list[float]] = {it: [] for it in STATISTICS}
        for row in found:
            is_near = row["statistic"] != "ring_density" or (float(row["bin_from_m"]) >= 5 and float(row["bin_to_m"]) <= 50)
            if row["statistic"] in STATISTICS and row["ratio"] and is_near:
                ratios[row["statistic"]].append(float(row["ratio"]))
        lines.append([found[0]["left"], *(agreement(it) if it else DASH for it in ratios.values())])
    return Shown(table(["", *STATISTICS.values()], lines))


def agreement(ratios: list[float]) -> str:
    n_alike = sum(1 / ALIKE <= it <= ALIKE for it in ratios)
    return f"{share(n_alike, len(ratios))} %, {number(median_low(ratios), 2)}"


# Pictures


def picture(results: list[Result], source: str, target: str, words: str) -> Shown:
    """A plot that a command left behind."""
    return Shown(f"![{words}]({target})", {target: left(results[0], source).read_bytes()})


def viewer(results: list[Result], target: str, words: str) -> Shown:
    """The recording of a run as the Rerun viewer shows it."""
    return taken([CI / "recordings/picture", left(results[0], "run.rrd")], target, words)


def report_page(results: list[Result], target: str, words: str) -> Shown:
    """The page of a run as a browser shows it, light and dark."""
    return taken([CI / "page/picture", left(results[0], "report.html")], target, words)


def taken(command: list[Path], target: str, words: str) -> Shown:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        ended = subprocess.run([*command, path], capture_output=True, text=True, check=False)
        if ended.returncode != 0 or not path.is_file():
            last = (ended.stdout + ended.stderr).strip().splitlines()[-3:]
            raise ShowError(f"{shlex.join(map(str, command))}: {' '.join(last)}")
        return Shown(f"![{words}]({target})", {target: path.read_bytes()})


SHOWN = [
    file, file_head, claims, printed_table, overall_rates, over_seeds, compared_detectors, compared_runs,
    ablation_rates, rates_by_dataset, gap_shares, gap_layouts, condition_changes, box_fits, box_slices, fitness_summary,
    fitness_by_dataset, fitness_by_sensor, realism_agreement, picture, viewer, report_page,
]  # fmt: skip
SHOWS = {it.__name__.replace("_", "-"): it for it in SHOWN}
