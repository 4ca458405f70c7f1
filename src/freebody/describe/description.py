"""The declarations of a machine: names, tables and assumptions.

`System` is the class that users see. This file holds its base class, which is all that the modules for bodies, joints,
loads, contacts and constraints know of a system, and the functions by which they and other rooms read and extend it.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from ..errors import ModelError, shown
from ..scalar.algebra import Expression, Scalar, Vector
from .names import Names, check_name
from .table import Changes, Table


@dataclass(frozen=True)
class Parameter:
    """A named constant of the system and its default value (None: must be given later)."""

    name: str
    symbol: Any
    default: float | None


class Description:
    """A machine as far as it is declared; the base class of :class:`System`."""

    def __init__(self, name: str) -> None:
        self._names = Names()
        self._changes = changes = self._names.changes
        self.name = name
        self.ground: Any = None
        self.bodies: dict[str, Any] = Table(changes)
        self.joints: dict[str, Any] = Table(changes)
        self.loads: dict[str, Any] = Table(changes)
        self.constraints: dict[str, Any] = Table(changes)
        self.contacts: dict[str, Any] = Table(changes)
        self.families: dict[str, Any] = Table(changes)
        self.controllers: dict[str, Any] = Table(changes)
        self._children: set[str] = set()  # names of the bodies that are the child of a joint
        self._coordinates: dict[str, Any] = Table(changes)  # in order of declaration
        self._about: dict[str, tuple[str, str]] = Table(changes)
        self._positive: dict[Any, None] = Table(changes)
        self._parameters: dict[str, Parameter] = Table(changes)
        self._signal_constants: dict[Any, tuple[Parameter, ...]] = {}

    @property
    def name(self) -> str:
        """Name of the machine."""
        return self._name

    @name.setter
    def name(self, name: str) -> None:
        if not isinstance(name, str) or not name.strip():
            raise ModelError(f"Expected a name (text) for the system, got {shown(name)}.")
        self._name = name
        self._changes.count += 1

    def expression(self, value: Expression, what: str = "the expression") -> Scalar:
        """Return a number or text as an expression of this system's names; ``what`` names it in errors.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("pendulum")
        >>> theta = s.coordinates("theta")
        >>> s.expression("theta'") == theta.diff(s.t)
        True
        """
        return self._names.expression(value, what)


# --- reading -----------------------------------------------------------------------------------


def names_of(system: Description) -> Names:
    """Return the names of a system and the SymPy atoms that they stand for."""
    return system._names


def changes_of(system: Description) -> Changes:
    """Return the counter of a system's changes."""
    return system._changes


def coordinates_of(system: Description) -> dict[str, Any]:
    """Return the coordinates by name, in order of declaration, without those of ball and free joints."""
    return system._coordinates


def about_of(system: Description) -> dict[str, tuple[str, str]]:
    """Return (unit, meaning) of the parameters and coordinates that were described, by name."""
    return system._about


def positive_in(system: Description) -> frozenset[Any]:
    """Return the expressions known to be positive, by assumption or by their use."""
    return frozenset(system._positive)


def parameters_of(system: Description) -> tuple[Parameter, ...]:
    """Return the parameters in order of declaration, then the constants of the signals in use."""
    signals = system._names.signals
    for signal, placed in signals.items():
        if signal not in system._signal_constants:
            values = placed.settings(float(signal.times[0]))
            system._signal_constants[signal] = tuple(
                Parameter(symbol.name, symbol, values[symbol.name]) for symbol in placed.symbols
            )
    constants = [constant for signal in signals for constant in system._signal_constants[signal]]
    return (*system._parameters.values(), *constants)


def vector(system: Description, components: Any, what: str) -> Vector:
    """Return three components as expressions of the system's names.

    Raises
    ------
    ModelError
        Anything but three components.
    """
    if isinstance(components, str) or not hasattr(components, "__len__"):
        raise ModelError(f"Expected three components (x, y, z) for {what}, got {shown(components)}.")
    if len(components) != 3:
        cure = " Add the third component, z." if len(components) == 2 else ""
        raise ModelError(
            f"Expected three components (x, y, z) for {what}, got {len(components)}: {shown(components)}.{cure}"
        )
    x, y, z = (system.expression(component, what) for component in components)
    return (x, y, z)


def varying(system: Description, expression: Scalar) -> list[str]:
    """Return the names of the coordinates, speeds, signals and time in an expression; none if it is constant."""
    return system._names.depends(expression, "coordinate", "speed", "time")


def children_of(system: Description) -> set[str]:
    """Return the names of the bodies that are the child of a joint; a new joint adds its child."""
    return system._children


# --- declaring ---------------------------------------------------------------------------------


def declare_coordinate(system: Description, name: str) -> Any:
    """Declare one coordinate and return its function of time."""
    atom = system._names.coordinate(name)
    system._coordinates[name] = atom
    return atom


def take_as_positive(system: Description, *expressions: Any) -> None:
    """Note that expressions are positive."""
    system._positive.update(dict.fromkeys(expressions))


def claim(system: Description, name: str, kind: str) -> str:
    """Return the name of a new joint, load, constraint or contact.

    Joints, constraints and contacts share their names, since their multipliers bear them.

    Raises
    ------
    ModelError
        A text that cannot be a name, or a name in use.
    """
    check_name(name, kind)
    tables = {
        "joint": system.joints, "constraint": system.constraints, "contact": system.contacts,
        "family of contacts": system.families,
    }  # fmt: skip
    for owner, table in ({"load": system.loads} if kind == "load" else tables).items():
        if name in table:
            raise ModelError(f"There is already a {owner} '{name}' in this system. Choose another name.")
    return name


@contextmanager
def all_or_nothing(system: Description) -> Iterator[None]:
    """Take back the names declared in the block if the block fails."""
    names = system._names
    mark = names.mark()
    try:
        yield
    except Exception:
        names.forget(mark)
        for name in [name for name in system._coordinates if name not in names.kinds]:
            del system._coordinates[name]
        raise


def without_signals(system: Description) -> Any:
    """Return a copy of the system in which the constants of its signals are parameters without default values."""
    result, parameters = copy.copy(system), parameters_of(system)
    result._parameters.update((p.name, Parameter(p.name, p.symbol, None)) for p in parameters)
    result._names.signals.clear()
    return result
