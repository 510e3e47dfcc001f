"""The program `scanbench`, and what it says when it fails."""

from __future__ import annotations

import os
import shutil
import site
import subprocess
import sys
import sysconfig
from collections.abc import Sequence
from pathlib import Path

EXIT_CODES = {
    1: "internal error",
    2: "wrong usage or configuration",
    3: "data missing or damaged",
    4: "nothing was evaluated",
    5: "runs that cannot be compared",
    6: "a detector failed",
    7: "results cannot be written",
    130: "interrupted",
    143: "ended by SIGTERM",
}


class ScanbenchError(Exception):
    """The program was not found, or ended with another exit code than 0."""

    def __init__(self, message: str, exit_code: int | None = None) -> None:
        super().__init__(message)
        self.exit_code = exit_code


def find_program() -> Path:
    """`SCANBENCH` of the environment, the wheel's own program, or one on `PATH`, in this order."""
    if named := os.environ.get("SCANBENCH"):
        if found := shutil.which(named):
            return Path(found)
        raise ScanbenchError(f"SCANBENCH of the environment is {named!r}, which is no program")
    name = "scanbench" + (sysconfig.get_config_var("EXE") or "")
    folders = [sysconfig.get_path("scripts"), os.path.join(site.getuserbase(), "bin")]
    if found := shutil.which(name, path=os.pathsep.join(folders)) or shutil.which(name):
        return Path(found)
    raise ScanbenchError("there is no program scanbench: install the wheel, or set SCANBENCH to where it is")


def call(arguments: Sequence[str], *, quiet: bool, given: bytes | None = None, project: Path | None = None) -> str:
    """Runs the program on what it is `given` and returns what it printed; raises ScanbenchError with its last lines if it fails.

    `project` stands for the scanbench.toml that it would find.
    """
    command = [str(find_program()), *arguments]
    # It reads the caller's own input unless it is given some.
    stdin = None if given is None else subprocess.PIPE
    environment = {**os.environ, "SCANBENCH_PROJECT": str(project)} if project else None
    process = subprocess.Popen(command, stdin=stdin, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)
    with process:
        try:
            printed, said = (text.decode(errors="replace") for text in process.communicate(given))
        except BaseException:
            # It ends its detectors before it goes.
            process.terminate()
            process.wait()
            raise
    if said and not quiet:
        print(said, file=sys.stderr, end="")
    if process.returncode:
        meaning = EXIT_CODES.get(process.returncode, "failed")
        lines = "\n".join(said.strip().splitlines()[-15:])
        raise ScanbenchError(f"scanbench: {meaning} (exit code {process.returncode})\n{lines}", process.returncode)
    return printed
