"""film.py PROGRAM FILM: a silent film of what the viewer shows of a simulated drive, as an animated WebP.

Stages of a detector, two detectors side by side, then the drive with what is missed. Each frame is a scan, sent to a viewer
without a window.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from screen import connected, free_port, screenshot

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


def main(program, film):
    program, film, frames, shown_ms = Path(program).resolve(), Path(film).resolve(), [], []
    folder = Path(tempfile.mkdtemp())
    (folder / "drive.toml").write_text(CATALOGUE)
    for tab, detectors, scans, each_ms in CHAPTERS:
        port = free_port()
        command = ["rerun", "--headless", "--window-size", "1280x720", "--port", str(port), "--bind", "127.0.0.1"]
        viewer = subprocess.Popen(command, start_new_session=True, env=os.environ | {"RUST_LOG": "error"})
        try:
            client = connected(port)
            for scan in scans:
                options = f"--catalogue drive.toml --scans {scan} -d {detectors} --blueprint {tab} --rerun-points 25000 -q"
                url = f"rerun+http://127.0.0.1:{port}/proxy"
                words = [program, "run", "drive", *options.split(), "--connect", url, "-o", f"{tab}-{scan}"]
                subprocess.run(words, cwd=folder, check=True, stdout=subprocess.DEVNULL)
                time.sleep(SETTLED_S)
                frames.append(screenshot(client, folder / f"{tab}-{scan}.png", None).convert("RGB").crop(VIEWS))
                shown_ms.append(each_ms)
        finally:
            os.killpg(viewer.pid, signal.SIGTERM)
            viewer.wait(10)
    frames[0].save(film, save_all=True, append_images=frames[1:], duration=shown_ms, loop=0, quality=60, method=4)
    print(f"{film}: {len(frames)} frames, {sum(shown_ms) / 1000:.0f} s, {film.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main(*sys.argv[1:])
