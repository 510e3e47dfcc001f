"""What a recording holds, as Rerun's own reader sees it: the entities of every detector, and a row for each scan.

rows.py FILE N_SCANS DETECTOR,DETECTOR...
"""

import sys
from collections import Counter

from rerun.experimental import RrdReader

# What each detector draws at every scan, below world/sensor/detectors/NAME.
DESCRIBED = [
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
    "kd-tree": ["contours/boxes/hulls", "boxes/boxes/boxes", "spheres/features/corner_spheres"],
    "pca": ["contours/boxes/rectangles", "boxes/boxes/boxes"],
}
CELLS = {"hierarchical": "walls", "paper": "walls", "kd-tree": "walls", "pca": "foreground"}
CLASSES = {
    "hierarchical": ["ground", "tall", "short\\ object", "clutter"],
    "paper": ["ground", "tall", "short\\ object", "clutter"],
    "kd-tree": ["ground", "tall", "short\\ object", "clutter"],
    "pca": ["ground", "short\\ object"],
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
    """Rows of each entity, and of each component of it."""
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
    return rows


def check(path, n_scans, detectors):
    rows = rows_of(path)
    entities = Counter()
    for name, n in rows.items():
        entity = name.rsplit(" ", 1)[0]
        entities[entity] = max(entities[entity], n)
    problems = []

    def expect(entity, least, most=None):
        n = entities[entity]
        if not least <= n <= (n_scans if most is None else most):
            problems.append(f"{entity} has {n} rows, not {least} to {n_scans if most is None else most}")

    for entity in ["scan/points", "scan/annotations"]:
        expect(f"/world/sensor/{entity}", n_scans)
    expect("/legend/scan", n_scans)
    for detector in detectors:
        root = f"/world/sensor/detectors/{detector}"
        for product in PRODUCTS[detector]:
            expect(f"{root}/{product}", n_scans)
        for surface in CLASSES[detector]:
            expect(f"{root}/cells/{CELLS[detector]}/cells/{surface}", n_scans)
        for column in LABELS[detector]:
            n = rows[f"/world/sensor/scan/points {detector}:{column}"]
            if n != n_scans:
                problems.append(f"the points have {n} rows of {detector}:{column}, not {n_scans}")
        for task in ["objects", "vehicles"]:
            for layer in SOMETIMES:
                expect(f"{root}/outcomes/{task}/{layer}", 0)
            if not sum(entities[f"{root}/outcomes/{task}/{layer}"] for layer in SOMETIMES):
                problems.append(f"{root}/outcomes/{task} is empty")
            expect(f"/mistakes/{detector}/{task}", 1, 10_000)
            for count in ["found", "missed", "false"]:
                # One more for the name of the line, which holds for all scans.
                expect(f"/series/counts/{detector}/{task}/{count}", n_scans)
        expect(f"{root}/scores/object", 1)
        expect(f"/series/stage_ms/{detector}", n_scans)
        expect(f"/series/latency_ms/{detector}", n_scans)
    if problems:
        sys.exit(f"{path}:\n  " + "\n  ".join(problems))
    print(f"{path}: {len(entities)} entities, {sum(entities.values())} rows, as expected")


if __name__ == "__main__":
    check(sys.argv[1], int(sys.argv[2]), sys.argv[3].split(","))
