"""What is seen of a recording in the real viewer.

screen.py FILE PICTURE: opens FILE in a viewer without a window, takes a picture of every view of the tab in front, and
looks for what has to be there: points and boxes, lines, the colours of right and wrong. PICTURE is of the whole viewer.
"""

import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from PIL import Image
from rerun.experimental import RrdReader, ViewerClient

# Until everything has been drawn.
PATIENCE_S = float(os.environ.get("SCREEN_PATIENCE_S", "60"))
SIZE = "1600x900"

# harness/viewer/src/palette.rs
MATCHED, MISSED, FALSE = (0, 158, 115), (240, 228, 66), (213, 94, 0)
OUTCOMES = {"matched": MATCHED, "missed": MISSED, "false": FALSE}
TABS = 1


def blueprint_of(path):
    """Containers and views of the blueprint by path, and the path of the outermost container."""
    reader = RrdReader(path)
    nodes, root = {}, None
    for chunk in reader.stream(store=reader.blueprints()[0]):
        parts = str(chunk.entity_path).strip("/").split("/")
        batch = chunk.to_record_batch()
        row = {name: batch.column(name).to_pylist()[-1] for name in batch.schema.names if ":" in name}
        if len(parts) == 2 and parts[0] in ("view", "container"):
            nodes["/".join(parts)] = row
        if parts == ["viewport"]:
            octets = bytes(row["ViewportBlueprint:root_container"][0]).hex()
            lengths = [8, 4, 4, 4, 12]
            cuts = [sum(lengths[:n]) for n in range(6)]
            root = "container/" + "-".join(octets[a:b] for a, b in zip(cuts, cuts[1:]))
    return nodes, root


def in_front(nodes, path):
    """Paths of the views that are visible when nothing has been clicked."""
    path = path.strip("/")
    if path.startswith("view/"):
        return [path]
    inner = nodes[path]["ContainerBlueprint:contents"]
    if nodes[path]["ContainerBlueprint:container_kind"] == [TABS]:
        inner = inner[:1]
    return [view for it in inner for view in in_front(nodes, it)]


def n_near(colors, wanted, tolerance):
    return sum(n for n, color in colors if all(abs(a - b) <= tolerance for a, b in zip(color, wanted)))


def problem_of(kind, outcomes, image):
    """A problem of the picture of a view, or None; and which of `outcomes` it shows."""
    shown = set()
    image = image.convert("RGB")
    colors = image.getcolors(image.width * image.height)
    n_pixels = image.width * image.height
    background = max(colors)[1]
    n_drawn = n_pixels - n_near(colors, background, 6)
    n_vivid = sum(n for n, color in colors if max(color) - min(color) > 60)
    if kind == "3D":
        if len(colors) < 60 or n_drawn < 0.02 * n_pixels:
            return f"{len(colors)} colours, {n_drawn} of {n_pixels} pixels drawn", shown
        shown = {it for it in outcomes if n_near(colors, OUTCOMES[it], 12) >= 40}
        return "nothing matched" if outcomes and "matched" not in shown else None, shown
    if kind == "TextLog":
        # At the first scan the missed ones fill the view, and the false ones are below it.
        lines = [it for it in ("missed", "false") if n_near(colors, OUTCOMES[it], 40) >= 20]
        return None if lines else "no text of what is missed or false", shown
    if kind == "2D":
        return None if n_vivid > 60 else "no colours in the legend", shown
    return None if n_vivid > 60 else "no lines", shown


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def check(path, picture):
    nodes, root = blueprint_of(path)
    views = []
    for view in in_front(nodes, root):
        row = nodes[view]
        kind, title = row["ViewBlueprint:class_identifier"][0], row["ViewBlueprint:display_name"][0]
        origin = row["ViewBlueprint:space_origin"][0]
        views.append((view.split("/")[1], kind, title, origin))
    # Where detectors are compared, each matches something, and one at least is wrong somewhere.
    detectors = {it[2].split(":")[0] for it in views if it[1] == "TextLog"} or {
        it[2] for it in views if it[3] == "/world"
    }
    port = free_port()
    log = tempfile.NamedTemporaryFile("w+", suffix=".log")
    viewer = subprocess.Popen(
        ["rerun", "--headless", "--window-size", SIZE, "--port", str(port), "--bind", "127.0.0.1", str(path)],
        start_new_session=True,
        stdout=log,
        stderr=log,
        env=os.environ | {"RUST_LOG": "warn", "NO_COLOR": "1"},
    )
    try:
        client = connected(port)
        waiting, problems, deadline = list(views), {}, time.monotonic() + PATIENCE_S
        shown = set()

        def is_wrong_shown():
            """A good detector has nothing wrong in the part of one scan that is seen. Of several one has."""
            return len(detectors) < 2 or bool(shown & {"missed", "false"})

        folder = Path(tempfile.mkdtemp())
        while (waiting or not is_wrong_shown()) and time.monotonic() < deadline:
            time.sleep(1.5)
            left = []
            for view in waiting or views:
                view_id, kind, title, _ = view
                outcomes = OUTCOMES if title in detectors or title.endswith("right and wrong") else {}
                image = screenshot(client, folder / f"{view_id}.png", view_id)
                problem, drawn = problem_of(kind, outcomes, image) if image else ("no picture", set())
                shown |= drawn
                if problem:
                    problems[view_id] = f"{kind} view {title!r}: {problem}"
                    left.append(view)
            waiting = left
        whole = screenshot(client, Path(picture).resolve(), None)
        found = [problems[it[0]] for it in waiting]
        if not is_wrong_shown():
            found.append("nothing missed or false in any of the views of " + ", ".join(sorted(detectors)))
        if whole is None:
            found.append("no picture of the whole viewer")
    finally:
        os.killpg(viewer.pid, signal.SIGTERM)
        viewer.wait(10)
    log.seek(0)
    found += [line.strip() for line in log if " ERROR " in line]
    if found:
        sys.exit(f"{path}:\n  " + "\n  ".join(found))
    print(f"{path}: {len(views)} views as expected, {picture}")


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


def screenshot(client, file, view_id):
    """The picture, once the viewer has written all of it; None if it does not."""
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
            return image
        except (OSError, SyntaxError):
            time.sleep(0.1)
    return None


if __name__ == "__main__":
    check(sys.argv[1], sys.argv[2])
