"""Running the program on Python's detectors, and what a run leaves behind."""

from __future__ import annotations

import json
import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from scanbench.configuration_file import section
from scanbench.detector import Detector
from scanbench.frame import Tables, columns_of_csv, columns_of_rows
from scanbench.nesting import refuse_nesting
from scanbench.notebook import page_of
from scanbench.program import ScanbenchError, call

DetectorLike = Detector | Callable[..., Any] | str


class Run(Tables):
    """A run directory. Its tables are `scans`, `matches`, `report`, `protocols`, and its other CSV files, such as `precision_recall`."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.path = path

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> Run:
        """An earlier run; raises ScanbenchError if there is none at `path`."""
        directory = Path(path)
        if not (directory / "manifest.json").is_file():
            raise ScanbenchError(f"{directory} is no run: it has no manifest.json")
        return cls(directory)

    @property
    def manifest(self) -> dict[str, Any]:
        """Command line, parameters, seeds, checksums, versions, processor."""
        manifest: dict[str, Any] = json.loads((self.path / "manifest.json").read_text())
        return manifest

    def _columns(self, name: str) -> dict[str, Any]:
        table = self.path / f"{name}.csv"
        if name in self._json_tables():
            content = json.loads((self.path / f"{name}.json").read_text())
            return columns_of_rows([*content["rows"], *content.get("overall", [])])
        if not table.is_file():
            there = sorted({*self._json_tables(), *(path.stem for path in self.path.glob("*.csv"))})
            raise ScanbenchError(f"{self.path} has no table {name!r}; it has {', '.join(there) or 'none'}")
        return columns_of_csv(table.read_text())

    def _json_tables(self) -> list[str]:
        """Tables of numbers, which are JSON files: `protocols` is there only after a run with `protocol=`."""
        return [name for name in ("report", "protocols") if (self.path / f"{name}.json").is_file()]

    def __repr__(self) -> str:
        return f"Run.open({str(self.path)!r})"

    def _repr_html_(self) -> str:
        return page_of(self.path)


def run(
    dataset: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    detectors: Sequence[DetectorLike] = (),
    *,
    detections: Mapping[str, str | os.PathLike[str]] | None = None,
    output: str | os.PathLike[str] | None = None,
    config: str | os.PathLike[str] | None = None,
    parameters: Mapping[str, Any] | None = None,
    start_limit_s: float | None = None,
    time_limit_s: float | None = None,
    threads: int | None = None,
    sandbox: bool | None = None,
    vehicles: Literal["size", "model"] | None = None,
    quiet: bool = False,
    **options: Any,
) -> Run:
    """Judges `detectors` on data sets (ids or paths), and returns the run.

    A detector is a function, or the name of one that scanbench has or `config` names: a scanbench.toml, that of the working directory or
    the nearest folder above if it is left out. `detections` are results that detectors left elsewhere, by names of your choice: a file or
    folder each. `parameters` are those of
    detectors and matching (`-P`); `start_limit_s`, `time_limit_s`, `threads`, `sandbox` and `vehicles` are for each function, as in scanbench.toml. Any other option of `scanbench run` is given by its name:
    `scans="0..100:5"`, `simulated_scans=20`, `criterion="centre"`, `skip_damaged=True`, `on_detector_failure="skip"`.

    The file that defines a function is imported by another process, which then calls the function: in such a file, `run` belongs under
    `if __name__ == "__main__":`. Raises ScanbenchError, with `exit_code`, if the program fails, and without one if `run` is called while a
    file is imported for that.
    """
    refuse_nesting()
    datasets = [dataset] if isinstance(dataset, str | os.PathLike) else list(dataset)
    named = [_named(detector) for detector in detectors]
    names = [detector if isinstance(detector, str) else detector.name for detector in named]
    given = {name: os.fspath(path) for name, path in (detections or {}).items()}
    all_names = [*names, *given]
    if not all_names or len(set(all_names)) != len(all_names):
        raise ValueError(f"detectors need a name each, and these have {', '.join(all_names) or 'none'}: see `using`")
    directory = Path(output) if output is not None else _new_directory(all_names)
    arguments = ["run", *(os.fspath(path) for path in datasets)]
    arguments += ["-d", ",".join(names)] if names else []
    arguments += [word for name, path in given.items() for word in ("--detections", f"{name}={path}")]
    arguments += ["-o", str(directory)]
    for name, value in (parameters or {}).items():
        arguments += ["-P", f"{name}={_word(value)}"]
    for name, value in options.items():
        arguments += _option(name, value)
    made = [detector for detector in named if isinstance(detector, Detector)]
    settings = {
        "start_limit_s": start_limit_s,
        "time_limit_s": time_limit_s,
        "threads": threads,
        "sandbox": sandbox,
        "vehicles": vehicles,
    }
    found = _found_configuration() if made and config is None else None
    with _configuration(made, Path(config) if config is not None else found, settings) as written:
        if found:
            call(arguments, quiet=quiet, project=written)
        else:
            call([*arguments, *(["-c", str(written)] if written else [])], quiet=quiet)
    return Run.open(directory)


def _named(detector: DetectorLike) -> Detector | str:
    if isinstance(detector, str | Detector):
        return detector
    return Detector(detector, None, None, -1)


def _new_directory(names: Sequence[str]) -> Path:
    return Path("runs") / f"{time.strftime('%Y-%m-%d-%H%M%S')}-{time.time_ns() // 1_000_000 % 1000:03}-{names[0]}"


@contextmanager
def _configuration(
    detectors: Sequence[Detector], config: Path | None, settings: Mapping[str, Any]
) -> Iterator[Path | None]:
    """A scanbench.toml for the run, removed afterwards; beside `config`, so that commands there start in their own folder."""
    if not detectors:
        yield config
        return
    with tempfile.TemporaryDirectory(prefix="scanbench-") as scratch:
        sections = [section(detector, Path(scratch), settings) for detector in detectors]
        if config is None:
            written = Path(scratch) / "scanbench.toml"
            written.write_text("\n".join(sections))
            yield written
            return
        written = config.parent / f".{config.stem}-{os.getpid()}-{time.time_ns()}.toml"
        try:
            written.write_text("\n".join([config.read_text(), *sections]))
            yield written
        finally:
            written.unlink(missing_ok=True)


def _found_configuration() -> Path | None:
    """The scanbench.toml that the program finds by itself: in the working directory, or the nearest folder above."""
    folder = Path.cwd()
    return next((path for it in [folder, *folder.parents] if (path := it / "scanbench.toml").is_file()), None)


def _option(name: str, value: Any) -> list[str]:
    option = "--" + name.replace("_", "-")
    if value is None or value is False:
        return []
    if value is True:
        return [option]
    if isinstance(value, Mapping):
        return [f"{option}={name}={_word(item)}" for name, item in value.items()]
    if isinstance(value, list | tuple):
        return [word for item in value for word in _option(name, item)]
    return [f"{option}={_word(value)}"]


def _word(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)
