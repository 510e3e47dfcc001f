"""damage.py FILE DAMAGED PREFIX: copies a recording without the entities at or below PREFIX; its blueprint stays."""

import subprocess
import sys

from rerun.experimental import RrdReader

file, damaged, prefix = sys.argv[1:]
below = prefix.rstrip("/") + "/"
entities = {str(chunk.entity_path) for chunk in RrdReader(file).stream()}
dropped = sorted(it for it in entities if (it + "/").startswith(below) and not it.startswith("/__"))
assert dropped, f"nothing is below {prefix}"
arguments = [f"--drop-entity={it}" for it in dropped]
subprocess.run(["rerun", "rrd", "filter", *arguments, "-o", damaged, file], check=True)
