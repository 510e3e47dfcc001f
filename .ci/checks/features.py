#!/usr/bin/env python3
"""Fails if the tests compile a dependency once more that the program was compiled with, such as Rerun.

Cargo gives a dependency the features that everything asks for that is compiled with it. If what only tests use asks for one
more, that dependency and all that use it are compiled twice. The remedy is to ask for it in [workspace.dependencies], too.
"""

import json
import os
import subprocess
import sys
from functools import cache


def units(*command):
    """What Cargo would compile: the package, target and features of each unit, by all that it is made of."""
    arguments = ["cargo", *command, "--release", "--unit-graph", "-Z", "unstable-options"]
    # Only nightly toolchains show the graph, or one that a variable makes pass for one; nothing is compiled here.
    environment = {**os.environ, "RUSTC_BOOTSTRAP": "1"}
    graph = json.loads(subprocess.run(arguments, env=environment, check=True, capture_output=True).stdout)["units"]

    @cache
    def identity(index):
        unit = graph[index]
        own = [unit[it] for it in ("pkg_id", "target", "mode", "platform", "profile", "features")]
        below = sorted(identity(it["index"]) for it in unit["dependencies"])
        return hash((json.dumps(own, sort_keys=True), *below))

    return {identity(index): unit for index, unit in enumerate(graph)}


program, tests = units("build"), units("test", "--workspace")
twice = [unit for it, unit in program.items() if it not in tests]
print(f"{len(program)} units for the program, {len(tests)} with the tests, {len(twice)} of them compiled twice")
for unit in twice:
    same = [it for it in tests.values() if (it["pkg_id"], it["target"]) == (unit["pkg_id"], unit["target"])]
    if differing := {feature for it in same for feature in set(it["features"]) ^ set(unit["features"])}:
        print(f"{unit['pkg_id'].rsplit('/', 1)[-1]}: {', '.join(sorted(differing))}", file=sys.stderr)
sys.exit(1 if twice else 0)
