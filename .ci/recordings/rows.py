"""What a recording holds, as Rerun's own reader sees it: the entities of every detector, and a row for each scan.

rows.py FILE N_SCANS DETECTOR,DETECTOR...
"""

import sys
from collections import Counter
from itertools import product

from rerun.experimental import RrdReader

# What each detector draws at every scan, below world/sensor/detectors/NAME.
WALLS = [f"cells/walls/cells/{it}" for it in ("ground", "tall", "short\\ object", "clutter")]
DESCRIBED = [
    *WALLS,
    "segments/walls/segments",
    "contours/boxes/hulls",
    "contours/boxes/rectangles",
    "boxes/boxes/boxes",
    "spheres/features/corner_spheres",
    "contours/features/convex_profiles",
    "contours/features/concave_profiles",
    "contours/features/nearest_prototypes",
]
PRODUCTS = {
    "hierarchical": DESCRIBED,
    "paper": [
        *DESCRIBED,
        "links/merge/links/link\\ kept",
        "links/merge/links/link\\ cut",
        "object_cells/separation/dense_cells",
        "segments/separation/cuts",
    ],
    "kd-tree": [*WALLS, "contours/boxes/hulls", "boxes/boxes/boxes", "spheres/features/corner_spheres"],
    "pca": [
        "cells/foreground/cells/ground",
        "cells/foreground/cells/short\\ object",
        "contours/boxes/rectangles",
        "boxes/boxes/boxes",
    ],
}
# Columns of the points.
LABELS = {
    "hierarchical": ["foreground:points", "grouping:smallest_groups", "best_cut:clusters"],
    "paper": ["foreground:points", "separation:clusters"],
    "kd-tree": ["foreground:points", "components:dropped_clusters", "components:clusters"],
    "pca": ["foreground:points", "components:dropped_clusters", "components:clusters"],
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
        for name in batch.schema.names:
            if ":" in name:
                column = batch.column(name)
                rows[f"{chunk.entity_path} {name}"] += len(column) - column.null_count
    entities = Counter()
    for name, n in rows.items():
        entity = name.rsplit(" ", 1)[0]
        entities[entity] = max(entities[entity], n)
    return rows | entities, entities


def expected(n_scans, detectors):
    """How many rows at least and at most an entity, or a component of it, has."""
    every_scan = ["/world/sensor/scan/points", "/world/sensor/scan/annotations", "/legend/scan"]
    others = {}
    for detector in detectors:
        root = f"/world/sensor/detectors/{detector}"
        every_scan += [f"{root}/{product}" for product in PRODUCTS[detector]]
        every_scan += [f"/world/sensor/scan/points {detector}:{column}" for column in LABELS[detector]]
        every_scan += [f"/series/stage_ms/{detector}", f"/series/latency_ms/{detector}"]
        others[f"{root}/scores/object"] = 1, n_scans
        for task in ["objects", "vehicles"]:
            others[f"/mistakes/{detector}/{task}"] = 1, 10_000
            others |= {f"{root}/outcomes/{task}/{layer}": (0, n_scans) for layer in SOMETIMES}
            # One more for the name of the line, which holds for all scans.
            every_scan += [f"/series/counts/{detector}/{task}/{count}" for count in ["found", "missed", "false"]]
    return {it: (n_scans, n_scans) for it in every_scan} | others


def check(path, n_scans, detectors):
    rows, entities = rows_of(path)
    problems = [
        f"{name} has {rows[name]} rows, not {least} to {most}"
        for name, (least, most) in expected(n_scans, detectors).items()
        if not least <= rows[name] <= most
    ]
    for detector, task in product(detectors, ["objects", "vehicles"]):
        outcomes = f"/world/sensor/detectors/{detector}/outcomes/{task}"
        if not sum(entities[f"{outcomes}/{layer}"] for layer in SOMETIMES):
            problems.append(f"{outcomes} is empty")
    if problems:
        sys.exit(f"{path}:\n  " + "\n  ".join(problems))
    print(f"{path}: {len(entities)} entities, {sum(entities.values())} rows, as expected")


if __name__ == "__main__":
    check(sys.argv[1], int(sys.argv[2]), sys.argv[3].split(","))
