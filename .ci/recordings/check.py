"""What recordings hold, as Rerun's own reader sees it, and what is seen of them in the real viewer: check.py SCANBENCH
PICTURES [NEWEST]

Runs of some simulated scans are recorded and opened at each of their tabs, and so are a sweep, partly seen objects and the
worst scans of a run. The same checks have to fail on recordings from which something was taken. All is opened in the viewer
that is pinned, and once more in that of the Python in the folder NEWEST.
"""

import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from rerun.experimental import RrdReader

from layers import one_file
from program import run

ALL = ["hierarchical", "kd-tree", "pca"]
# What each detector draws at every scan, below world/sensor/detectors/NAME.
WALLS = [f"cells/walls/cells/{it}" for it in ("ground", "tall", "short\\ object", "clutter")]
PROFILES = [f"contours/features/{it}" for it in ("convex_profiles", "concave_profiles", "nearest_prototypes")]
BOXES, SPHERES, HULLS = "boxes/boxes/boxes", "spheres/features/corner_spheres", "contours/boxes/hulls"
DESCRIBED = [*WALLS, "segments/walls/segments", HULLS, "contours/boxes/rectangles", BOXES, SPHERES, *PROFILES]
SEPARATED = ["links/merge/links/link\\ kept", "links/merge/links/link\\ cut", "object_cells/separation/dense_cells"]
FOREGROUND = [f"cells/foreground/cells/{it}" for it in ("ground", "short\\ object")]
PRODUCTS = {
    "hierarchical": DESCRIBED,
    "paper": [*DESCRIBED, *SEPARATED, "segments/separation/cuts"],
    "kd-tree": [*WALLS, HULLS, BOXES, SPHERES],
    "pca": [*FOREGROUND, "contours/boxes/rectangles", BOXES],
}
# Columns of the points: the colours of what they are, and of what they belong to.
CLASSES = ["foreground:points:colors"]
LABELS = {
    "hierarchical": [*CLASSES, "grouping:smallest_groups:colors", "best_cut:clusters:colors"],
    "paper": [*CLASSES, "separation:clusters:colors"],
    "kd-tree": [*CLASSES, "components:dropped_clusters:colors", "components:clusters:colors"],
    "pca": [*CLASSES, "components:dropped_clusters:colors", "components:clusters:colors"],
}
# Not every scan has all of them.
SOMETIMES = ["matched", "found", "missed", "false"]


def rows_of(path):
    """Rows of each component of each entity, and of each entity."""
    reader = RrdReader(path)
    assert len(reader.recordings()) == 1, f"{len(reader.recordings())} recordings in {path}"
    assert len(reader.blueprints()) == 1, f"{len(reader.blueprints())} blueprints in {path}"
    rows = Counter()
    for chunk in reader.stream():
        batch = chunk.to_record_batch()
        for name in (it for it in batch.schema.names if ":" in it):
            column = batch.column(name)
            rows[f"{chunk.entity_path} {name}"] += len(column) - column.null_count
    entities = Counter()
    for name, n in rows.items():
        entity = name.rsplit(" ", 1)[0]
        entities[entity] = max(entities[entity], n)
    return rows | entities


def problems_of_rows(path, n_scans, detectors):
    """What has too few or too many rows, a row being a scan."""
    rows = rows_of(path)
    every_scan = ["/world/sensor/scan/points", "/world/sensor/scan/annotations", "/legend/scan"]
    others, problems = {}, []
    for detector in detectors:
        root = f"/world/sensor/detectors/{detector}"
        every_scan += [f"{root}/{product}" for product in PRODUCTS[detector]]
        every_scan += [f"/world/sensor/scan/points {detector}:{column}" for column in LABELS[detector]]
        every_scan += [f"/series/stage_ms/{detector}", f"/series/latency_ms/{detector}"]
        others[f"{root}/scores/object"] = 1, n_scans
        for task in ["objects", "vehicles"]:
            outcomes = [f"{root}/outcomes/{task}/{layer}" for layer in SOMETIMES]
            others |= {f"/mistakes/{detector}/{task}": (1, 10_000)} | dict.fromkeys(outcomes, (0, n_scans))
            every_scan += [f"/series/counts/{detector}/{task}/{count}" for count in ["found", "missed", "false"]]
            if not any(rows[it] for it in outcomes):
                problems.append(f"{root}/outcomes/{task} is empty")
    limits = dict.fromkeys(every_scan, (n_scans, n_scans)) | others
    wrong = {name: it for name, it in limits.items() if not it[0] <= rows[name] <= it[1]}
    return [f"{name} has {rows[name]} rows, not {least} to {most}" for name, (least, most) in wrong.items()] + problems


def problems_of_views(path, picture, binaries=None, seconds=60, **environment):
    """What is wrong with the picture of the viewer, of which each is seen by a program of its own; `binaries` has another
    viewer than the pinned one."""
    python = binaries / "python" if binaries else sys.executable
    command = [python, Path(__file__).with_name("viewer.py"), path, picture, str(seconds)]
    environment |= {"PATH": f"{binaries}:{os.environ['PATH']}"} if binaries else {}
    environment = os.environ | environment
    ended = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False, timeout=600, env=environment)
    return (ended.stderr.splitlines() or [f"exit code {ended.returncode}"]) if ended.returncode else []


def damaged(path, prefix):
    """A copy of a recording without the entities at or below `prefix`; its blueprint stays."""
    copy, below = path.with_name(f"damaged-{prefix.count('/')}.rrd"), prefix.rstrip("/") + "/"
    entities = {str(chunk.entity_path) for chunk in RrdReader(path).stream()}
    dropped = sorted(it for it in entities if f"{it}/".startswith(below) and not it.startswith("/__"))
    assert dropped, f"nothing is below {prefix}"
    subprocess.run(["rerun", "rrd", "filter", *(f"--drop-entity={it}" for it in dropped), "-o", copy, path], check=True)
    return copy


def version_of(binaries):
    """The version of a viewer."""
    command = [binaries / "rerun" if binaries else "rerun", "--version"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()[1]


def main(scanbench, pictures, scratch, newest=None):
    pictures.mkdir(parents=True, exist_ok=True)
    # Few points, since a software rasteriser draws them.
    quick = "run street-main-road --scans 0..3 --rerun-points 20000"
    cell_sizes = "hierarchical.grid.cell_size_m=0.5:0.7:0.1"
    for name, command in {
        "compare": f"{quick} --blueprint compare",
        "stages": f"{quick} --blueprint stages",
        "drive": f"{quick} --blueprint drive",
        "paper": f"{quick} -d paper",
        # The first and the third of three scans.
        "every": f"{quick} --rerun-every 2 -d pca",
        "sweep": f"sweep street-main-road --scans 0..2 -P {cell_sizes} -d hierarchical,pca",
        "partial": "partial objects-around --per-class 2",
        "drives": "partial objects-approach --drives --per-class 2",
    }.items():
        run(scanbench, *command.split(), "-o", scratch / name)
    for name in ("compare", "paper", "every"):
        one_file(scratch / name / "recording", scratch / name)
    compared = scratch / "compare/run.rrd"
    run(scanbench, "view", compared.parent, *"--worst 3 --task objects --rerun-points 20000".split())
    empty, unjudged = damaged(compared, "/"), damaged(compared, f"/world/sensor/detectors/{ALL[0]}/outcomes")
    for path, n_scans, detectors, is_sound in [
        (compared, 3, ALL, True),
        (scratch / "paper/run.rrd", 3, ["paper"], True),
        (scratch / "every/run.rrd", 2, ["pca"], True),
        (empty, 3, ALL, False),
        (unjudged, 3, ALL, False),
        (compared, 4, ALL, False),
    ]:
        judge(path, problems_of_rows(path, n_scans, detectors), is_sound)
    tabs = ["compare/recording", "stages/recording", "drive/recording"]
    if not newest:
        print("newest viewer: NOT TRIED, the package index has none that runs here", flush=True)
    for binaries in [None, *([newest / "bin"] if newest else [])]:
        print(f"viewer {version_of(binaries)}", flush=True)
        of_viewer = pictures / "newest" if binaries else pictures
        of_viewer.mkdir(exist_ok=True)
        for file in [*tabs, "compare/worst.rrd", "sweep/sweep.rrd", "partial/partial.rrd", "drives/partial.rrd"]:
            folder, name = file.split("/")
            picture = of_viewer / f"{'worst' if name == 'worst.rrd' else folder}.png"
            judge(scratch / file, problems_of_views(scratch / file, picture, binaries), True)
        for path in (empty, unjudged):
            judge(path, problems_of_views(path, of_viewer / f"{path.stem}.png", binaries, 8), False)
        # Colours that the points do not have are not found.
        turned = problems_of_views(compared, of_viewer / "turned.png", binaries, 30, TURN_COLOURS="yes")
        judge(compared, [it for it in turned if "points have the colour" in it], False)


def judge(path, problems, is_sound):
    if bool(problems) == is_sound:
        sys.exit(f"{path}:\n  " + "\n  ".join(problems or ["this should fail and does not"]))
    print(f"{path}: " + ("as expected" if is_sound else f"fails as it should: {problems[-1].strip()}"), flush=True)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        main(sys.argv[1], Path(sys.argv[2]), Path(scratch), *map(Path, sys.argv[3:]))
