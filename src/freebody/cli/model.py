"""The argument MODEL of the command line: an entry of the gallery or a model file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import FormatError, FreebodyError, ModelError, nearest

if TYPE_CHECKING:
    from ..describe.system import System
    from ..formats.case import Case


@dataclass(frozen=True)
class FileOutcome:
    """Result of running a model file, with the attributes of the outcome of a gallery entry."""

    entry: FileEntry
    system: Any
    equations: Any
    trajectory: Any
    plots: dict[str, Callable[[Any], None]]
    answers: dict[str, Any] = field(default_factory=dict)
    free_bodies: dict[str, Any] = field(default_factory=dict)
    checks: tuple[Any, ...] = ()

    @property
    def values(self) -> dict[str, float]:
        """Values of the parameters by name."""
        return dict(self.trajectory.values)

    @property
    def events(self) -> list[Any]:
        """Events of the motion."""
        return list(self.trajectory.events)


@dataclass(frozen=True)
class FileEntry:
    """A model file with the attributes of a gallery entry."""

    name: str
    case: Case
    title: str = ""
    asks: tuple[str, ...] = ()
    aliases: tuple[str, ...] = ()
    drawn: Mapping[str, Any] = field(default_factory=dict)
    enlarged: Mapping[str, float] = field(default_factory=dict)
    blows: None = None
    names: Mapping[str, Any] = field(default_factory=dict)

    @property
    def start(self) -> Mapping[str, Any]:
        """Initial values by name."""
        return self.case.initial

    @property
    def until(self) -> float | None:
        """Length of the run [s], or None."""
        return self.case.until

    @property
    def near(self) -> Mapping[str, Any]:
        """An approximate closed configuration."""
        return {**self.case.near, **self.case.initial}

    def drawing(self, values: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """How it is drawn: in a generic position."""
        return {"values": values}

    def build(self) -> System:
        """Return the system."""
        return self.case.system

    def run(self, values: Mapping[str, float], until: float | None, tolerance: float | None) -> FileOutcome:
        """Derive the equations and simulate."""
        from ..motion.contact.equations_at_start import equations
        from ..studies.simulate import simulate

        case = self.case
        if until is None and case.until is None:
            raise ModelError(
                f"Expected the length of the run, but neither --until nor [run] of {self.name} gives it. "
                f"Add --until 10."
            )
        if tolerance is None:
            tolerance = 1e-9 if case.tolerance is None else case.tolerance
        length = case.until if until is None else until
        trajectory = simulate(
            case.system, length, initial=case.initial, near=case.near, values=values, tolerance=tolerance
        )
        plots: dict[str, Any] = {}
        if trajectory.kernels.model.coordinates:
            plots["coordinates.png"] = lambda path: trajectory.plot(path=path)
        start: dict[str, Any] = {}
        if case.system.contacts:
            start = {"initial": case.initial, "near": case.near, "values": values}
        return FileOutcome(self, case.system, equations(case.system, **start), trajectory, plots)


class Number(click.ParamType):
    """A number, with a unit of the dimension of ``unit`` or without a unit: ``2``, ``1e-9``, ``2*pi``, ``75 deg``."""

    name = "number"

    def __init__(self, unit: str = "") -> None:
        self.unit = unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number."""
        if isinstance(value, float):
            return value
        try:
            return _number(value, self.unit, "a value")
        except FreebodyError as error:
            self.fail(str(error), param, ctx)


class Setting(click.ParamType):
    """``name=value`` on the command line; the value stays text until the unit of the name is known."""

    name = "name=value"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, str]:
        """Return name and value as texts."""
        if isinstance(value, tuple):
            return value
        name, sign, number = value.partition("=")
        if not sign or not name.strip() or not number.strip():
            self.fail(f"Expected name=value, such as m=2 or theta_0=75deg, got '{value}'.", param, ctx)
        return name.strip(), number.strip()


READ = "freebody.read"
"""Where a command keeps the options of ``--read``."""


def model_argument(command: Any) -> Any:
    """Give a command the argument MODEL, and the option with which a robot's file is read."""
    option = click.option(
        "--read", "options", type=Setting(), multiple=True, expose_value=False, metavar="NAME=VALUE",
        callback=lambda context, _, pairs: context.meta.update({READ: dict(pairs)}),
        help="For a robot's file, an option of fb.read: base=free, contacts=floor, limits=true; may be repeated.",
    )  # fmt: skip
    return click.argument("model")(option(command))


def find(model: str, **defaults: str) -> Any:
    """Return the gallery entry or model file of this name; ``defaults`` are options of a robot's file.

    Raises
    ------
    FormatError, ModelError
        If there is neither; the message offers the nearest gallery name.
    """
    from ..gallery import entries

    gallery = entries()
    path = Path(model)
    # also in the spelling of the chapter: Ex-6.2, prob_6_12
    spelling = model.lower().replace(".", "-").replace("_", "-")
    context = click.get_current_context(silent=True)
    options: dict[str, str] = {} if context is None else context.meta.get(READ, {})
    if spelling in gallery and not path.exists():
        if options:
            raise click.UsageError("--read is for robots' files, and the gallery has no options.")
        return gallery[spelling]
    if path.suffix or len(path.parts) > 1:
        from ..formats import ROBOTS, read_case

        words = {"true": True, "false": False}
        if path.suffix.lower() in ROBOTS:
            options = {**defaults, **options}
        return FileEntry(path.name, read_case(path, **{k: words.get(v, v) for k, v in options.items()}))
    if model not in gallery:
        hint = (
            f" For the folder of that name, give the .toml file in it: {model}/NAME.toml."
            if path.exists()
            else ""
        )
        raise FormatError(
            f"Expected a gallery name or the path of a .toml, .urdf or .xml file, got '{model}'; "
            f"{nearest(model, gallery.names, 'freebody gallery')}{hint}"
        )
    return gallery[model]


def check_run(until: float | None, tolerance: float | None) -> None:
    """Refuse a length of a run that is not positive, and a tolerance that is none."""
    if until is not None and not until > 0:
        raise click.BadParameter(f"Expected a time greater than 0, got {until:g}.", param_hint="--until")
    if tolerance is not None and not 0 < tolerance < 1:
        raise click.BadParameter(
            f"Expected a number between 0 and 1, got {tolerance:g}.", param_hint="--tolerance"
        )


def settings_of(system: System, pairs: Iterable[tuple[str, str]]) -> dict[str, float]:
    """Return the ``--set`` values by name; raise if the system has no such parameter or it has another unit."""
    from ..describe.description import parameters_of

    names = [parameter.name for parameter in parameters_of(system)]
    texts: dict[str, str] = {}
    for name, text in pairs:
        if name not in names:
            raise ModelError(
                f"--set {name}: expected a parameter of '{system.name}', got '{name}'; {nearest(name, names)}"
            )
        if texts.setdefault(name, text) != text:
            raise click.UsageError(f"--set {name}: expected one value, got {texts[name]} and {text}.")
    return {name: number_of(system, name, text, "--set") for name, text in texts.items()}


def number_of(system: System, name: str, text: str, option: str) -> float:
    """Return the number in a text for a parameter or coordinate, in the unit that the system declares for it."""
    from ..describe.description import about_of

    try:
        return _number(text, about_of(system).get(name, ("", ""))[0], name)
    except FreebodyError as error:
        raise click.BadParameter(str(error), param_hint=f"{option} {name}") from None


def _number(text: str, unit: str, what: str) -> float:
    from ..describe.names import finite
    from ..scalar.units import quantity

    return finite(quantity(text, unit, what), what)
