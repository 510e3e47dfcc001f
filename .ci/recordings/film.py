"""A silent film of what the viewer shows of a simulated drive, as an animated WebP: film.py PROGRAM FILM

Stages of a detector, two detectors side by side, then the drive with what is missed. Each frame is a scan, sent to a viewer
without a window.
"""

import sys
import tempfile
import time
from pathlib import Path

from program import run
from viewer import opened, screenshot

# Nearer in time than the scans of the catalogue: three tenths of a second.
CATALOGUE = """[simulated.drive]
street = "street-main-road"
seed = 9001
n_scans = 48
turns_per_scan = 3
scans_per_drive = 48
sensor = "hdl-64e-s2"
"""
# Tab, detectors, scans, and how long each is seen.
CHAPTERS = [
    ("stages", "hierarchical", range(0, 4, 2), 3000),
    ("compare", "hierarchical,pca", range(0, 16, 2), 1000),
    ("drive", "hierarchical", range(16, 32), 600),
]
# Without the bars of the viewer.
VIEWS = (0, 54, 1280, 690)
# Until a scan has been drawn.
SETTLED_S = 4

program, film = (Path(it).resolve() for it in sys.argv[1:])
frames, shown_ms, folder = [], [], Path(tempfile.mkdtemp())
(folder / "drive.toml").write_text(CATALOGUE)
for tab, detectors, scans, each_ms in CHAPTERS:
    with opened("1280x720") as (client, address, _):
        for scan in scans:
            options = f"--catalogue drive.toml --scans {scan} -d {detectors} --blueprint {tab} --rerun-points 25000 -q"
            run(program, "run", "drive", *options.split(), "--connect", address, "-o", f"{tab}-{scan}", cwd=folder)
            time.sleep(SETTLED_S)
            frames.append(screenshot(client, folder / f"{tab}-{scan}.png").crop(VIEWS))
            shown_ms.append(each_ms)
frames[0].save(film, save_all=True, append_images=frames[1:], duration=shown_ms, loop=0, quality=60, method=4)
print(f"{film}: {len(frames)} frames, {sum(shown_ms) / 1000:.0f} s, {film.stat().st_size / 1e6:.1f} MB")
