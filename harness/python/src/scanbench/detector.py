"""Functions and classes as detectors."""

from __future__ import annotations

import copy
import inspect
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, overload

from scanbench.cloud import Cloud
from scanbench.detections import Detections


@dataclass(frozen=True)
class Configuration:
    """What the program says before the first scan."""

    dataset: str = ""
    """Id of the data set."""
    sensor: str | None = None
    """The sensor, where it is known."""
    sensor_height_m: float | None = None
    """Height of the sensor above the ground, where it is known."""
    threads: int = 1
    """How many threads to use at most."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """The user's values."""


class Detector:
    """A function, or a class with `__call__`, that finds objects in a scan.

    The first argument is the scan. Every other one is a parameter, which `scanbench.toml`, `-P` and `using` set; one that is
    annotated `Configuration` gets what the program says of the sensor. A class is made once, with the parameters, and called for each scan.
    """

    def __init__(
        self,
        target: Callable[..., Any],
        name: str | None,
        version: str | None,
        noise: Literal[-1, 0],
        earlier_scans: int | str = 0,
        in_order: bool = False,
    ) -> None:
        if noise not in (-1, 0):
            raise ValueError(f"noise is -1 or 0, not {noise!r}")
        self.target = target
        self.name = name or target.__name__.replace("_", "-")
        self.version = version
        self.noise = noise
        self.earlier_scans = earlier_scans
        self.in_order = in_order
        self.overrides: dict[str, Any] = {}
        self.__doc__ = target.__doc__
        signature = self.signature
        if isinstance(earlier_scans, str) and earlier_scans not in signature.parameters:
            raise TypeError(f"earlier_scans is {earlier_scans!r}, which is no parameter of {self.name}")
        if (earlier_scans or in_order) and not signature.takes_cloud:
            raise TypeError(f"{self.name} looks back at its drive: its first argument has to be annotated Cloud")

    def __call__(self, *args: Any, **parameters: Any) -> Any:
        """The function itself: tests and other code call it as if nothing stood above it."""
        return self.target(*args, **parameters)

    def using(self, name: str | None = None, **parameters: Any) -> Detector:
        """The same detector with other parameters; `name` distinguishes the two."""
        self.check(parameters)
        other = copy.copy(self)
        other.overrides = {**self.overrides, **parameters}
        other.name = name or self.name
        return other

    def serve(self) -> typing.NoReturn:
        """Answers the program that started this process; the last line of a file that is a detector of its own."""
        from scanbench.client import leave, serve

        leave(serve(self))

    def detect(self, cloud: Cloud, configuration: Configuration | None = None) -> Detections:
        """What it finds in `cloud`, without the program."""
        return self.configured(configuration or Configuration(parameters=self.overrides))(cloud)

    def configured(self, configuration: Configuration) -> Callable[[Cloud], Detections]:
        """The detector with its parameters; raises ValueError or TypeError where one is wrong."""
        values = {**self.overrides, **configuration.parameters}
        arguments = {**values, **self.check(values)}
        for parameter in self.signature.configuration:
            arguments[parameter] = configuration
        if inspect.isclass(self.target):
            made: Any = self.target(**arguments)
            return lambda cloud: Detections.of(made(self._scan(cloud)))
        return lambda cloud: Detections.of(self.target(self._scan(cloud), **arguments))

    def wishes(self, configuration: Configuration) -> dict[str, Any]:
        """What it wants with every scan, as the answer to `configure` says it."""
        n = self.earlier_scans
        if isinstance(n, str):
            n = {**self.parameters, **self.check(configuration.parameters)}.get(n, 0)
        if isinstance(n, bool) or not isinstance(n, int) or n < 0:
            raise ValueError(f"{self.name} looks back at {n!r} scans, which is no number of scans")
        return {**({"earlier_scans": n} if n else {}), **({"in_order": True} if self.in_order else {})}

    def check(self, parameters: Mapping[str, Any]) -> dict[str, Any]:
        """`parameters` as the types that they are annotated with; raises where one is unknown, missing or of another type."""
        known = self.signature.parameters
        for name in parameters:
            if name not in known:
                raise ValueError(f"unknown parameter {name!r}; {self.name} has {', '.join(known) or 'none'}")
        return {name: _typed(name, value, self.signature.types.get(name)) for name, value in parameters.items()}

    @property
    def parameters(self) -> dict[str, Any]:
        """All values: the defaults of the signature, and what `using` has set."""
        return self.check({**self.signature.defaults, **self.overrides})

    @property
    def signature(self) -> Signature:
        """What the function or class takes."""
        return Signature.of(self.target)

    def _scan(self, cloud: Cloud) -> Any:
        return cloud if self.signature.takes_cloud else cloud.points


@dataclass(frozen=True)
class Signature:
    """The arguments of a function or class that is a detector."""

    takes_cloud: bool
    """Whether the scan is wanted as a `Cloud`, not as n × 4 numbers."""
    parameters: tuple[str, ...]
    """Names of what can be set."""
    defaults: Mapping[str, Any]
    """Values of those that need not be set."""
    types: Mapping[str, Any]
    """Their annotations."""
    configuration: tuple[str, ...]
    """Names of what is annotated `Configuration`."""

    @staticmethod
    def of(target: Callable[..., Any]) -> Signature:
        """Raises TypeError if there is no argument for the scan."""
        if inspect.isclass(target):
            scan_of, named = _arguments(target.__call__)[1:], _arguments(target)
            types = {**_types(target.__init__), "": _types(target.__call__)}
        else:
            scan_of, named = _arguments(target)[:1], _arguments(target)[1:]
            types = _types(target)
        if not scan_of:
            raise TypeError(f"{target.__name__} takes no scan: its first argument has to be the points")
        scan_type = (types.get("", types) if inspect.isclass(target) else types).get(scan_of[0].name)
        wants = [argument.name for argument in named if _is(types.get(argument.name), Configuration)]
        settable = [a for a in named if a.kind in (a.POSITIONAL_OR_KEYWORD, a.KEYWORD_ONLY) and a.name not in wants]
        defaults = {a.name: a.default for a in settable if a.default is not a.empty}
        return Signature(_is(scan_type, Cloud), tuple(a.name for a in settable), defaults, types, tuple(wants))


def _arguments(target: Callable[..., Any]) -> list[inspect.Parameter]:
    return list(inspect.signature(target).parameters.values())


def _types(target: Callable[..., Any]) -> dict[str, Any]:
    try:
        return typing.get_type_hints(target)
    except (NameError, TypeError):
        # Names that exist for a type checker alone: the annotations as they are written.
        return dict(getattr(target, "__annotations__", {}))


def _is(annotation: Any, wanted: type) -> bool:
    if isinstance(annotation, str):
        return annotation.split(".")[-1] == wanted.__name__
    return annotation is wanted


def _typed(name: str, value: Any, annotation: Any) -> Any:
    if annotation is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if annotation is int and isinstance(value, float) and value.is_integer():
        return int(value)
    if annotation in (int, float, str, bool) and type(value) is not annotation:
        raise TypeError(f"parameter {name!r} is {annotation.__name__}, not {value!r}")
    return value


@overload
def detector(target: Callable[..., Any], /) -> Detector: ...


@overload
def detector(
    *,
    name: str | None = None,
    version: str | None = None,
    noise: Literal[-1, 0] = -1,
    earlier_scans: int | str = 0,
    in_order: bool = False,
) -> Callable[[Callable[..., Any]], Detector]: ...


def detector(
    target: Callable[..., Any] | None = None,
    /,
    *,
    name: str | None = None,
    version: str | None = None,
    noise: Literal[-1, 0] = -1,
    earlier_scans: int | str = 0,
    in_order: bool = False,
) -> Detector | Callable[[Callable[..., Any]], Detector]:
    """Makes a function of n × 4 points (or of a `Cloud`, if annotated so) a detector.

    It returns an integer for each point, or `Boxes`, or both as a pair, or `Detections`. With `noise=-1`, as in scikit-learn and Open3D,
    labels below 0 are points of no cluster and clusters begin at 0. With `noise=0`, as in SciPy and scikit-image, 0 is no cluster and clusters
    begin at 1. Which of the two is never guessed.

    `Cloud.earlier` holds as many scans before each one as `earlier_scans` says, a number or the name of the parameter that has it. A
    class that remembers what it saw wants `in_order`: it gets the scans of a drive one after the other, each once.
    """
    if target is not None:
        return Detector(target, name, version, noise, earlier_scans, in_order)
    return lambda function: Detector(function, name, version, noise, earlier_scans, in_order)
