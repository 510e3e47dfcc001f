"""The real viewer, without a window: viewer.py FILE PICTURE [SECONDS]

Opens FILE, takes a picture of every view of the tab in front, and looks for what has to be there: points in the colours of
the recording, boxes, lines, the colours of right and wrong, for so many seconds (60 if left out). PICTURE is of the whole
viewer, with 256 colours: a fifth of the bytes, and no difference to be seen. TURN_COLOURS=yes expects other colours of
points, which are nowhere.
"""

import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

from PIL import Image
from rerun.experimental import ViewerClient

from layers import one_file

try:
    from rerun.chunk import RrdReader
except ImportError:  # Before 0.41.
    from rerun.experimental import RrdReader

# Until everything has been drawn.
PATIENCE_S = float(sys.argv[3]) if len(sys.argv) > 3 else 60
# harness/viewer/src/palette.rs
OUTCOMES = {"matched": (0, 158, 115), "missed": (240, 228, 66), "false": (213, 94, 0)}
TABS = 1
POINTS = "/world/sensor/scan/points"
# A colour that so many of the points of a scan have can be looked for. So many of its points, at least, are seen as a pixel in
# full colour, and five of them in any case: others are hidden, far away, or outside of a small view.
LEAST_SHARE, LEAST_PIXELS = 0.03, 0.004


@contextmanager
def opened(size, *files):
    """A client of a viewer of this size, its address, and the file of its log."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with tempfile.NamedTemporaryFile("w+", suffix=".log") as log:
        command = ["rerun", "--headless", "--window-size", size, "--port", str(port), "--bind", "127.0.0.1", *files]
        environment = os.environ | {"RUST_LOG": "warn", "NO_COLOR": "1"}
        viewer = subprocess.Popen(command, start_new_session=True, stdout=log, stderr=log, env=environment)
        try:
            yield connected(port), f"rerun+http://127.0.0.1:{port}/proxy", log
        finally:
            os.killpg(viewer.pid, signal.SIGTERM)
            viewer.wait(10)


def connected(port):
    deadline = time.monotonic() + PATIENCE_S
    while True:
        try:
            socket.create_connection(("127.0.0.1", port), 1).close()
            return ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
        except OSError:
            if time.monotonic() > deadline:
                sys.exit("the viewer does not start")
            time.sleep(0.3)


def screenshot(client, file, view_id=None):
    """The picture of a view or of the whole, once the viewer has written all of it; None if it does not."""
    file.unlink(missing_ok=True)
    try:
        client.save_screenshot(str(file), view_id=view_id)
    except Exception as error:  # The client has no error of its own for this.
        print(f"  {error}", file=sys.stderr)
        return None
    for _ in range(40):
        try:
            image = Image.open(file)
            image.load()
            return image.convert("RGB")
        except (OSError, SyntaxError):
            time.sleep(0.1)
    return None


def views_in_front(path):
    """Id, kind, title and origin of the views that are visible when nothing has been clicked."""
    reader = RrdReader(path)
    nodes, root = {}, None
    for chunk in reader.stream(store=reader.blueprints()[0]):
        entity, batch = str(chunk.entity_path).strip("/"), chunk.to_record_batch()
        row = {name: batch.column(name).to_pylist()[-1] for name in batch.schema.names if ":" in name}
        if entity.count("/") == 1 and entity.startswith(("view/", "container/")):
            nodes[entity] = row
        if entity == "viewport":
            octets = bytes(row["ViewportBlueprint:root_container"][0]).hex()
            cuts = [0, 8, 12, 16, 20, 32]
            root = "container/" + "-".join(octets[a:b] for a, b in zip(cuts, cuts[1:]))

    def below(node):
        if node.startswith("view/"):
            values = [nodes[node][f"ViewBlueprint:{it}"][0] for it in ("class_identifier", "display_name", "space_origin")]
            return [(node.removeprefix("view/"), *values)]
        inner = nodes[node]["ContainerBlueprint:contents"]
        is_tabs = nodes[node]["ContainerBlueprint:container_kind"] == [TABS]
        return [view for it in (inner[:1] if is_tabs else inner) for view in below(it.strip("/"))]

    return below(root)


def colors_of_points(path):
    """How many points each view whose points take columns has of each colour that is not rare, by the id of the view;
    nothing where none of the columns has colours."""
    reader, columns, shares = RrdReader(path), {}, {}
    for chunk in reader.stream(store=reader.blueprints()[0]):
        view, overrides, instruction = str(chunk.entity_path).partition(f"/ViewContents/overrides{POINTS}/visualizers/")
        if not (overrides and instruction):
            continue
        mappings = chunk.to_record_batch().column("VisualizerInstruction:component_map").to_pylist()[-1]
        sources = {it["target"]: it["source_component"] for it in mappings}
        columns[view.removeprefix("/view/")] = sources.get("Points3D:colors")
    for chunk in reader.stream():
        if str(chunk.entity_path) != POINTS:
            continue
        batch = chunk.to_record_batch()
        for name in set(batch.schema.names) & set(columns.values()):
            for row in filter(None, batch.column(name).to_pylist()):
                of_scan = {it: n for it, n in Counter(row).items() if n >= LEAST_SHARE * len(row)}
                known = shares.setdefault(name, of_scan)
                shares[name] = {it: min(n, known[it]) for it, n in of_scan.items() if it in known}
    rgb = lambda it: (it >> 24, it >> 16 & 255, it >> 8 & 255)
    return {view: {rgb(it): n for it, n in shares.get(name, {}).items()} for view, name in columns.items()}


def problem_of(kind, is_judged, image, expected):
    """A problem of the picture of a view, whose points have the `expected` colours, or None; and which outcomes it shows."""
    n_pixels = image.width * image.height
    colors = image.getcolors(n_pixels)
    n_near = lambda wanted, tolerance: sum(n for n, it in colors if max(abs(a - b) for a, b in zip(it, wanted)) <= tolerance)
    n_drawn = n_pixels - n_near(max(colors)[1], 6)
    is_colourful = sum(n for n, color in colors if max(color) - min(color) > 60) > 60
    if kind == "3D":
        if len(colors) < 60 or n_drawn < 0.02 * n_pixels:
            return f"{len(colors)} colours, {n_drawn} of {n_pixels} pixels drawn", set()
        if expected == {}:
            return "its points have no colours", set()
        # Those of one colour may lie behind others, or out of sight.
        unseen = [
            f"{n_points} points have the colour {color}, and {n_shown} pixels"
            for color, n_points in (expected or {}).items()
            if (n_shown := n_near(color, 8)) < max(5, LEAST_PIXELS * n_points)
        ]
        if 2 * len(unseen) > len(expected or {}):
            return f"{len(unseen)} of {len(expected)} colours are not seen: {'; '.join(unseen)}", set()
        shown = {name for name, color in OUTCOMES.items() if is_judged and n_near(color, 12) >= 40}
        return "nothing matched" if is_judged and "matched" not in shown else None, shown
    if kind == "TextLog":
        # At the first scan the missed ones fill the view, and the false ones are below it.
        has_text = any(n_near(OUTCOMES[it], 40) >= 20 for it in ("missed", "false"))
        return None if has_text else "no text of what is missed or false", set()
    if kind == "TextDocument":
        return None if n_drawn >= 400 else "no text", set()
    return None if is_colourful else "no colours in the legend" if kind == "2D" else "no lines", set()


def problems_of_views(path, picture):
    """What is wrong with the views in front."""
    with tempfile.TemporaryDirectory() as folder:
        one = one_file(path, Path(folder))
        views, expected = views_in_front(one), colors_of_points(one)
    if os.environ.get("TURN_COLOURS"):
        expected = {view: {(b // 2, r, g): n for (r, g, b), n in colors.items()} for view, colors in expected.items()}
    # Where detectors are compared, each matches something, and one at least is wrong somewhere.
    logs = {title.split(":")[0] for _, kind, title, _ in views if kind in ("TextLog", "TextDocument")}
    detectors = logs or {title for _, _, title, origin in views if origin == "/world"}
    # A good detector has nothing wrong in the part of one scan that is seen. Of several one has.
    is_wrong_shown = len(detectors) < 2
    waiting, problems, deadline = views, {}, time.monotonic() + PATIENCE_S
    with opened("1600x900", path) as (client, _, log), tempfile.TemporaryDirectory() as folder:
        while (waiting or not is_wrong_shown) and time.monotonic() < deadline:
            time.sleep(1.5)
            left = []
            for view in waiting or views:
                view_id, kind, title, _ = view
                is_judged = title in detectors or title.endswith("right and wrong")
                image = screenshot(client, Path(folder, f"{view_id}.png"), view_id)
                problem, shown = problem_of(kind, is_judged, image, expected.get(view_id)) if image else ("no picture", set())
                is_wrong_shown = is_wrong_shown or bool(shown & {"missed", "false"})
                if problem:
                    problems[view_id] = f"{kind} view {title!r}: {problem}"
                    left.append(view)
            waiting = left
        whole = screenshot(client, Path(picture).resolve())
        log.seek(0)
        found = [problems[it[0]] for it in waiting] + [line.strip() for line in log if " ERROR " in line]
    if not is_wrong_shown:
        found.append("nothing missed or false in any of the views of " + ", ".join(sorted(detectors)))
    return found if whole else [*found, "no picture of the whole viewer"]


if __name__ == "__main__":
    if found := problems_of_views(*sys.argv[1:3]):
        sys.exit(f"{sys.argv[1]}:\n  " + "\n  ".join(found))
    # Other methods give up the colours of thin lines.
    shown = Image.open(sys.argv[2]).convert("RGB").quantize(256, method=Image.Quantize.FASTOCTREE)
    shown.save(sys.argv[2], optimize=True)
