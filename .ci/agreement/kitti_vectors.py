"""Makes the vectors that hold the protocol kitti-object to KITTI's development kit: made-up scans, and the kit's numbers.

    kitti_vectors.py KIT FOLDER [--only-kit]
    kitti_vectors.py KIT FOLDER --street LABELS RESULTS

KIT is the folder cpp of the kit (devkit_object.zip or a copy), with evaluate_object.cpp; g++ and Boost have to be there.
FOLDER gets, for every case, CASE.labels.txt and CASE.results.txt (lines of KITTI's tracking layout, so that a case is one
file) and CASE.kit.csv: the averages that the kit's precisions at 41 recalls have. --only-kit takes the cases that are there.
--street writes the case simulated-street instead: LABELS is the folder label_2 of `scanbench data simulate --to kitti-object`, RESULTS what
`scanbench run … --detections-out` wrote of it as KITTI's text files. Both get rectangles in the image of a camera that is made up, too, and
what it does not see, or KITTI has no name for, is left out.
Nothing of the kit is kept.
"""

import math
import random
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

SIZES_M = {  # height, width, length
    "Car": (1.53, 1.63, 3.9),
    "Pedestrian": (1.76, 0.66, 0.84),
    "Cyclist": (1.74, 0.6, 1.76),
    "Van": (2.2, 1.9, 5.1),
    "Person_sitting": (1.27, 0.6, 0.8),
    "Truck": (3.2, 2.6, 10.0),
}
EVALUATED = ["Car", "Pedestrian", "Cyclist"]
FOCAL_PX = 720.0
CENTER_PX = (610.0, 172.0)
SIZE_PX = (1242.0, 375.0)
DEMANDS = {
    "strict": "{{0.7, 0.5, 0.5}, {0.7, 0.5, 0.5}, {0.7, 0.5, 0.5}}",
    "loose": "{{0.7, 0.5, 0.5}, {0.5, 0.25, 0.25}, {0.5, 0.25, 0.25}}",
}

# Calls the kit's own functions, scan by scan as its main does, and prints averages of what they give.
DRIVER = r"""
#define main main_of_the_kit
#include "evaluate_object.cpp"
#undef main
#include <chrono>

static void print(int kind, const char *plane, const char *level, const char *what, const vector<double> &values) {
  double r11 = 0, r40 = 0;
  for (int it = 0; it <= 40; it += 4) r11 += values[it];
  for (int it = 1; it <= 40; it++) r40 += values[it];
  printf("%s,%s,%s,%s,%.12g,%.12g\n", CLASS_NAMES[kind].c_str(), plane, level, what, r11 / 11, r40 / 40);
}

int main(int, char **arguments) {
  initGlobals();
  bool headings = true;
  vector<bool> seen[3] = {vector<bool>(3, false), vector<bool>(3, false), vector<bool>(3, false)};
  vector<vector<tGroundtruth>> labels;
  vector<vector<tDetection>> results;
  for (int scan = 0; scan < atoi(arguments[3]); scan++) {
    char name[64];
    sprintf(name, "/%06d.txt", scan);
    bool is_label, is_result;
    labels.push_back(loadGroundtruth(arguments[1] + string(name), is_label));
    results.push_back(loadDetections(arguments[2] + string(name), headings, seen[0], seen[1], seen[2], is_result));
    if (!is_label || !is_result) return 1;
  }
  double (*overlaps[3])(tDetection, tGroundtruth, int32_t) = {imageBoxOverlap, groundBoxOverlap, box3DOverlap};
  const char *planes[3] = {"2d", "bev", "3d"}, *levels[3] = {"easy", "moderate", "hard"};
  FILE *nowhere = fopen("/dev/null", "w");
  auto start = chrono::steady_clock::now();
  for (int plane = 0; plane < 3; plane++)
    for (int kind = 0; kind < 3; kind++)
      for (int level = 0; seen[plane][kind] && level < 3; level++) {
        vector<double> precision, similarity;
        eval_class(nowhere, nowhere, (CLASSES)kind, labels, results, plane == 0 && headings, overlaps[plane],
                   precision, similarity, (DIFFICULTY)level, (METRIC)plane);
        print(kind, planes[plane], levels[level], "ap", precision);
        if (!similarity.empty()) print(kind, planes[plane], levels[level], "aos", similarity);
      }
  fprintf(stderr, "%.3f s\n", chrono::duration<double>(chrono::steady_clock::now() - start).count());
}
"""

Thing = dict  # an object: kind, x, y, z, h, w, l, ry, and what the image shows


def seen(thing: Thing) -> Thing:
    """The same with its rectangle in the image and its heading as the camera sees it."""
    cos, sin = math.cos(thing["ry"]), math.sin(thing["ry"])
    across, down = [], []
    for along in (0.5, -0.5):
        for beside in (0.5, -0.5):
            length, width = along * thing["l"], beside * thing["w"]
            x = thing["x"] + cos * length + sin * width
            z = max(thing["z"] - sin * length + cos * width, 0.5)
            for y in (thing["y"], thing["y"] - thing["h"]):
                across.append(CENTER_PX[0] + FOCAL_PX * x / z)
                down.append(CENTER_PX[1] + FOCAL_PX * y / z)
    left, right = max(min(across), 0.0), min(max(across), SIZE_PX[0] - 1)
    top, bottom = max(min(down), 0.0), min(max(down), SIZE_PX[1] - 1)
    alpha = thing["ry"] - math.atan2(thing["x"], thing["z"])
    return {**thing, "px": (left, top, right, bottom), "alpha": math.remainder(alpha, 2 * math.pi)}


def street(draw: random.Random, n_things: int) -> list[Thing]:
    """What stands ahead of a camera; now and then something stands in something else."""
    things: list[Thing] = []
    for _ in range(n_things):
        kind = draw.choices(list(SIZES_M), weights=[10, 5, 4, 2, 1, 1])[0]
        height, width, length = (it * draw.uniform(0.9, 1.1) for it in SIZES_M[kind])
        z = draw.uniform(5.0, 55.0)
        x = draw.uniform(-0.75, 0.75) * z
        if things and draw.random() < 0.15:
            z, x = things[-1]["z"] + draw.uniform(-0.4, 0.4), things[-1]["x"] + draw.uniform(-0.4, 0.4)
        thing = {"kind": kind, "x": x, "y": draw.uniform(1.4, 1.9), "z": z, "h": height, "w": width, "l": length}
        thing["ry"] = draw.uniform(-math.pi, math.pi)
        thing = seen(thing)
        if thing["px"][2] <= thing["px"][0] + 1:
            continue
        thing["occlusion"] = draw.choices([0, 1, 2, 3], weights=[6, 2, 2, 1])[0]
        thing["truncation"] = draw.choices([0.0, 0.15, 0.16, 0.3, 0.45, 0.5, 0.8], weights=[8, 1, 1, 1, 1, 1, 1])[0]
        things.append(thing)
    return things


def found(draw: random.Random, things: list[Thing], wobble: float) -> list[Thing]:
    """What a detector makes of it: most things, some twice, some as something else, and some that are not there."""
    detections = []
    for thing in things:
        for _ in range(draw.choices([0, 1, 2], weights=[2, 7, 2])[0]):
            moved = {key: thing[key] for key in ("kind", "x", "y", "z", "h", "w", "l", "ry")}
            for key, sigma in (("x", 0.12), ("y", 0.06), ("z", 0.15), ("h", 0.06), ("w", 0.05), ("l", 0.12), ("ry", 0.1)):
                moved[key] += wobble * draw.gauss(0.0, sigma)
            if draw.random() < 0.05:
                moved["ry"] += math.pi
            if draw.random() < 0.1:
                moved["kind"] = draw.choice(list(SIZES_M))
            detections.append({**seen(moved), "score": draw.gauss(1.0, 1.5)})
    for thing in street(draw, 4):
        detections.append({**thing, "score": draw.gauss(-0.5, 1.5)})
    draw.shuffle(detections)
    return [it for it in detections if it["px"][2] > it["px"][0] + 1]


def line(scan: int, thing: Thing) -> str:
    box = " ".join(f"{it:.2f}" for it in thing["px"])
    size = " ".join(f"{thing[key]:.2f}" for key in "hwl")
    position = " ".join(f"{thing[key]:.2f}" for key in ("x", "y", "z", "ry"))
    levels = f"{thing['truncation']:.2f} {thing['occlusion']}" if "score" not in thing else "-1 -1"
    score = f" {thing['score']}" if "score" in thing else ""
    return f"{scan} -1 {thing['kind']} {levels} {thing['alpha']:.2f} {box} {size} {position}{score}\n"


def dont_care(draw: random.Random, scan: int) -> str:
    left, top = draw.uniform(0, 1100), draw.uniform(100, 200)
    box = f"{left:.2f} {top:.2f} {left + draw.uniform(20, 300):.2f} {top + draw.uniform(20, 150):.2f}"
    return f"{scan} -1 DontCare -1 -1 -10 {box} -1 -1 -1 -1000 -1000 -1000 -10\n"


Change = Callable[[random.Random, list[Thing], list[Thing]], list[Thing]]


def rounded_scores(_draw: random.Random, _things: list[Thing], detections: list[Thing]) -> list[Thing]:
    return [{**it, "score": round(it["score"])} for it in detections]


def like_scores(_draw: random.Random, _things: list[Thing], detections: list[Thing]) -> list[Thing]:
    return [{**it, "score": 1.0} for it in detections]


def fed_back(_draw: random.Random, things: list[Thing], _detections: list[Thing]) -> list[Thing]:
    return [{**{key: it[key] for key in it if key not in ("occlusion", "truncation")}, "score": 1.0} for it in things]


def no_headings(_draw: random.Random, _things: list[Thing], detections: list[Thing]) -> list[Thing]:
    return [{**it, "alpha": -10.0} for it in detections]


def no_cyclists(_draw: random.Random, _things: list[Thing], detections: list[Thing]) -> list[Thing]:
    return [it for it in detections if it["kind"] != "Cyclist"]


def some_lower(draw: random.Random, _things: list[Thing], detections: list[Thing]) -> list[Thing]:
    """Rectangles cut to about the least heights, some exactly to them."""
    for it in detections:
        left, top, right, _ = it["px"]
        if draw.random() < 0.4:
            it["px"] = (left, round(top), right, round(top) + draw.choice([20.0, 24.99, 25.0, 39.9, 40.0, 41.0]))
    return detections


def as_found(_draw: random.Random, _things: list[Thing], detections: list[Thing]) -> list[Thing]:
    return detections


# Name, scans, things a scan, how far off boxes are, and what is special.
CASES: list[tuple[str, int, int, float, Change]] = [
    ("street", 40, 9, 0.6, as_found),
    ("exact", 20, 8, 0.1, as_found),
    ("rounded-scores", 20, 9, 0.5, rounded_scores),
    ("like-scores", 15, 8, 0.4, like_scores),
    ("fed-back", 20, 9, 0.0, fed_back),
    ("few", 3, 3, 0.3, as_found),
    ("no-headings", 10, 8, 0.4, no_headings),
    ("no-cyclists", 10, 8, 0.4, no_cyclists),
    ("low", 20, 9, 0.4, some_lower),
]


def write_case(folder: Path, number: int) -> None:
    name, n_scans, n_things, wobble, change = CASES[number]
    draw = random.Random(number)
    labels, results = "", ""
    for scan in range(n_scans):
        # Of some scans nothing is labelled, of some nothing is found.
        things = [] if draw.random() < 0.1 else street(draw, n_things)
        if change is some_lower:
            for it in things:
                left, top, right, _ = it["px"]
                if draw.random() < 0.3:
                    it["px"] = (left, round(top), right, round(top) + draw.choice([25.0, 25.01, 40.0, 40.01]))
        detections = [] if draw.random() < 0.1 else change(draw, things, found(draw, things, wobble))
        labels += "".join(line(scan, it) for it in things)
        labels += "".join(dont_care(draw, scan) for _ in range(draw.choice([0, 1, 2])))
        results += "".join(line(scan, it) for it in detections)
    (folder / f"{name}.labels.txt").write_text(labels)
    (folder / f"{name}.results.txt").write_text(results)


def things_of(path: Path) -> list[Thing]:
    """What a text file of KITTI says, as the camera sees it; nothing of what it does not see, or KITTI has no name for."""
    things = []
    for it in path.read_text().splitlines():
        kind, truncation, occlusion, _, _, _, _, _, *numbers = it.split()
        position = dict(zip(("h", "w", "l", "x", "y", "z", "ry", "score"), map(float, numbers), strict=False))
        if position["z"] > 3.0 and kind in (*SIZES_M, "Misc"):
            thing = seen({"kind": kind, **position, "truncation": float(truncation), "occlusion": int(occlusion)})
            if thing["px"][2] > thing["px"][0] + 1 and thing["px"][3] > thing["px"][1] + 1:
                things.append(thing)
    return things


def write_street(folder: Path, labels: Path, results: Path) -> None:
    for kind, of in (("labels", labels), ("results", results)):
        paths = sorted(of.glob("*.txt"))
        lines = [line(scan, thing) for scan, path in enumerate(paths) for thing in things_of(path)]
        (folder / f"simulated-street.{kind}.txt").write_text("".join(lines))


def built(kit: Path, demand: str, folder: Path) -> Path:
    text = (kit / "evaluate_object.cpp").read_text()
    lines = [
        f"const double MIN_OVERLAP[3][3] = {DEMANDS[demand]};" if it.startswith("const double MIN_OVERLAP") else it
        for it in text.splitlines()
    ]
    source = folder / demand
    source.mkdir()
    (source / "evaluate_object.cpp").write_text("\n".join(lines))
    (source / "mail.h").write_text((kit / "mail.h").read_text())
    (source / "driver.cpp").write_text(DRIVER)
    program = source / "driver"
    subprocess.run(["g++", "-O3", "-DNDEBUG", "-w", "-o", program, source / "driver.cpp"], check=True)
    return program


def split(text: str, folder: Path, n_scans: int) -> None:
    folder.mkdir()
    scans: list[list[str]] = [[] for _ in range(n_scans)]
    for it in text.splitlines():
        scan, _track, rest = it.split(" ", 2)
        scans[int(scan)].append(rest)
    for scan, lines in enumerate(scans):
        (folder / f"{scan:06}.txt").write_text("".join(f"{it}\n" for it in lines))


def n_scans_of(texts: list[str]) -> int:
    return 1 + max(int(it.split(" ", 1)[0]) for text in texts for it in text.splitlines())


def write_numbers(programs: dict[str, Path], labels: Path) -> None:
    texts = [labels.read_text(), labels.with_name(labels.name.replace(".labels.", ".results.")).read_text()]
    numbers = "demand,class,plane,difficulty,average,r11,r40\n"
    with tempfile.TemporaryDirectory() as workplace:
        folders = [Path(workplace) / "labels", Path(workplace) / "results"]
        for text, folder in zip(texts, folders, strict=True):
            split(text, folder, n_scans_of(texts))
        for demand, program in programs.items():
            command = [program, *folders, str(n_scans_of(texts))]
            printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
            numbers += "".join(f"{demand},{it}\n" for it in printed.splitlines())
    labels.with_name(labels.name.replace(".labels.txt", ".kit.csv")).write_text(numbers)


def main() -> None:
    cases = "*"
    match sys.argv[1:]:
        case [kit, folder]:
            Path(folder).mkdir(parents=True, exist_ok=True)
            for number in range(len(CASES)):
                write_case(Path(folder), number)
        case [kit, folder, "--only-kit"]:
            pass
        case [kit, folder, "--street", labels, results]:
            write_street(Path(folder), Path(labels), Path(results))
            cases = "simulated-street"
        case _:
            sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as workplace:
        programs = {demand: built(Path(kit), demand, Path(workplace)) for demand in DEMANDS}
        for labels in sorted(Path(folder).glob(f"{cases}.labels.txt")):
            write_numbers(programs, labels)


if __name__ == "__main__":
    main()
