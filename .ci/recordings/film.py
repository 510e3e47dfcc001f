"""A silent film of what the viewer shows of a simulated drive, as an animated WebP: film.py PROGRAM FILM

What is missed and why, two detectors side by side, then an answer that comes late. It needs a viewer whose time can be set:
the newest.
"""

import sys
import tempfile
import time
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont
from program import run
from viewer import opened, screenshot

# Nearer in time than the scans of the catalogue: a tenth of a second.
CATALOGUE = """[simulated.drive]
street = "street-main-road"
seed = 9001
n_scans = 48
turns_per_scan = 1
scans_per_drive = 48
sensor = "hdl-64e-s2"
"""
SIZE = "1024x640"
# Without the bars of the viewer.
VIEWS = (0, 36, 1024, 610)
CAPTION_PX = 44
# Until a recording, and then a moment of it, has been drawn.
OPENED_S, SETTLED_S = 12, 1.5

program, film = (Path(it).resolve() for it in sys.argv[1:])
folder = Path(tempfile.mkdtemp())
frames, shown_ms = [], []


def captioned(image, text):
    width = VIEWS[2] - VIEWS[0]
    frame = Image.new("RGB", (width, CAPTION_PX + VIEWS[3] - VIEWS[1]), (16, 17, 21))
    frame.paste(image.crop(VIEWS), (0, CAPTION_PX))
    ImageDraw.Draw(frame).text((16, 9), text, fill=(240, 240, 240), font=ImageFont.load_default(24))
    return frame


def add(recording, timeline, unit, moments, each_ms, text):
    with opened(SIZE, str(recording)) as (client, _, _):
        time.sleep(OPENED_S)
        for moment in moments:
            client.set_time(timeline, **{unit: moment})
            time.sleep(SETTLED_S)
            frames.append(captioned(screenshot(client, folder / "frame.png"), text))
            shown_ms.append(each_ms)


(folder / "drive.toml").write_text(CATALOGUE)
options = "--catalogue drive.toml --scans 0..48 --rerun-points 25000 -q"
run(program, "run", "drive", *options.split(), "-d", "hierarchical,kd-tree", "-o", "two", cwd=folder)
# As long as on a quiet machine: here the viewer draws beside the run.
latencies = ["--latency", "hierarchical=10.6ms", "--latency", "kd-tree=309ms"]
run(program, "streaming", "two", "-d", "kd-tree,hierarchical", *latencies, "--save-rrd", cwd=folder)
two, late = folder / "two" / "recording", next((folder / "two").glob("*stream*.rrd"))
add(two, "scan", "sequence", [0, 12], 3000, "Yellow is missed, orange is false: the list says why")
add(two, "scan", "sequence", range(16, 48, 4), 900, "Two detectors on the same scans")
add(late, "drive_time", "duration", [0.1 * it for it in range(10, 34)], 280, "a detector that answers 0.3 s late: its boxes hang behind the cars")
frames[0].save(film, save_all=True, append_images=frames[1:], duration=shown_ms, loop=0, quality=35, method=4)
print(f"{film}: {len(frames)} frames, {sum(shown_ms) / 1000:.0f} s, {film.stat().st_size / 1e6:.1f} MB")
