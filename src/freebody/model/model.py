"""The model: a machine as frozen data, from which every result is computed."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import sympy

from ..describe.constraints.constraint import Gear
from ..describe.contacts.mesh import Mesh
from ..describe.description import Parameter
from ..describe.loads.load import Load
from ..describe.names import finite
from ..errors import ModelError, nearest, shown
from ..scalar.algebra import Expression, Vector
from ..scalar.units import quantity
from .parts import GROUND as GROUND
from .parts import Coordinate as Coordinate
from .parts import JointPlace as JointPlace
from .parts import Link as Link
from .parts import Place as Place
from .parts import Speed as Speed

_NUMBERS = frozenset((float, int, np.float64))


@dataclass(frozen=True)
class Model:
    """Tree of links, coordinates, loads and parameters, made by :func:`assemble`; it never changes."""

    name: str
    parameters: tuple[Parameter, ...]
    coordinates: tuple[Coordinate, ...]
    speeds: tuple[Speed, ...]
    links: tuple[Link, ...]
    bodies: Mapping[str, Place]
    joints: Mapping[str, JointPlace]
    loads: Mapping[str, Load]
    gravity: Vector
    positive: tuple[Any, ...]
    names: Any
    about: Mapping[str, tuple[str, str]]
    order: tuple[tuple[int, int], ...] | None = field(default=None)
    """(link, speed) pairs whose displacements determine the coordinates one after another; None if there are none."""

    constraints: Mapping[str, Any] = field(default_factory=dict)
    """Closures of closed loops and constraints on coordinates and speeds, by name."""

    contacts: tuple[Any, ...] = ()
    """Pairs of shapes that may touch at one point, in order of declaration."""

    families: tuple[Any, ...] = ()
    """Families of contacts, in order of declaration."""

    unrolled: tuple[Any, ...] = ()
    """Families whose pairs are contacts, for a motion by events."""

    patches: tuple[Any, ...] = ()
    """Pairs of solids whose points are contacts, of a model whose families are unrolled."""

    rings: tuple[Any, ...] = ()
    """Edges of disks whose points turn, of a model for motions by events."""

    controllers: tuple[Any, ...] = ()
    """Sampled controllers, in order of declaration."""

    frames: Mapping[str, tuple[str, Vector]] = field(default_factory=dict)
    """Body and place of the frames that a robot's file names."""

    pose: Mapping[str, float] | None = None
    """Coordinates, where they are not zero, in the pose in which a robot's file has it; None of another machine."""

    scenery: Any = None
    """Shape fixed in the ground that is only drawn, or None."""

    described: Any = field(default=None, repr=False, compare=False)
    """The system of the model, and the count of its changes at assembly."""

    @property
    def n_q(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)

    @property
    def n_u(self) -> int:
        """Number of speeds: the degrees of freedom."""
        return len(self.speeds)

    @cached_property
    def memo(self) -> dict[str, Any]:
        """Values that functions of the model alone have computed, by the name of the function."""
        return {}

    @cached_property
    def quaternions(self) -> tuple[int, ...]:
        """Index in q of the scalar part of each unit quaternion."""
        return tuple(link.quaternion for link in self.links if link.own)

    @cached_property
    def coordinate_names(self) -> tuple[str, ...]:
        """Names of q, in order."""
        return tuple(coordinate.name for coordinate in self.coordinates)

    @cached_property
    def speed_names(self) -> tuple[str, ...]:
        """Names of u, in order."""
        return tuple(speed.name for speed in self.speeds)

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """Names of (q, u), in order."""
        return (*self.coordinate_names, *self.speed_names)

    @cached_property
    def rest(self) -> tuple[float, ...]:
        """State (q, u) with all coordinates and speeds zero and all unit quaternions the identity."""
        return tuple(float(i in self.quaternions) for i in range(self.n_q + self.n_u))

    @cached_property
    def moved_by(self) -> tuple[tuple[int, ...], ...]:
        """For each coordinate, the indices of the speeds that change it."""
        result: list[tuple[int, ...]] = []
        for i, coordinate in enumerate(self.coordinates):
            if coordinate.kind == "scalar":
                result.append((self.speed_names.index(coordinate.name + "'"),))
                continue
            link = next(k for k in self.links if 0 <= k.q <= i < k.q + k.n_coordinates)
            start = link.u if coordinate.kind == "quaternion" else link.u + 3
            result.append((start, start + 1, start + 2))
        return tuple(result)

    @cached_property
    def places(self) -> Mapping[str, int]:
        """Index of each coordinate and speed in (q, u), by name."""
        return {name: i for i, name in enumerate(self.state_names)}

    @cached_property
    def parameter_names(self) -> Mapping[Any, str]:
        """Names of the parameters by their symbols."""
        return {parameter.symbol: parameter.name for parameter in self.parameters}

    @cached_property
    def defaults(self) -> Mapping[str, float | None]:
        """Default values of the parameters by name, None where there is none."""
        return {parameter.name: parameter.default for parameter in self.parameters}

    @cached_property
    def written(self) -> frozenset[str]:
        """Names of parameters that a motion by events writes: points of disks that lie flat, features of patches."""
        rings = (name for ring in self.rings for name in ring.names)
        return frozenset(
            (*rings, *(name for patch in self.patches for names in patch.names for name in names))
        )

    def refuse_written(self, names: Collection[Any]) -> None:
        """Raise ModelError for a name or symbol of a parameter that a motion writes: no parameter of the machine."""
        for key in names if self.written else ():
            if self.parameter_names.get(key, key) in self.written:
                raise self._unknown(key)

    def _unknown(self, key: Any) -> ModelError:
        return ModelError(f"Unknown parameter '{key}'; {nearest(str(key), self.given({**self.defaults}))}")

    def given(self, numbers: dict[str, Any]) -> dict[str, Any]:
        """Return values of parameters without those that a motion writes."""
        return {x: numbers[x] for x in numbers if x not in self.written} if self.written else numbers

    @cached_property
    def assumed(self) -> tuple[Any, ...]:
        """Expressions of the parameters alone that are assumed positive, in a fixed order.

        Assumptions on coordinates, such as ``cos(theta) > 0``, restrict the motion and cannot be checked from values.
        """
        symbols = {parameter.symbol for parameter in self.parameters}
        return tuple(
            expression
            for expression in sorted(self.positive, key=str)
            if isinstance(expression, sympy.Basic)
            and expression.free_symbols <= symbols
            and not expression.has(sympy.core.function.AppliedUndef)
        )

    @cached_property
    def meshes(self) -> Mapping[str, Mesh | str]:
        """The mesh of each gear, or the reason why only its ratio is known, by name."""
        return {name: gear.mesh for name, gear in self.constraints.items() if isinstance(gear, Gear)}

    @cached_property
    def touching(self) -> tuple[Any, ...]:
        """Shapes that may touch: features and surfaces of contacts, and members of families."""
        pairs = [shape for contact in self.contacts for shape in (contact.feature, contact.surface)]
        families = (*self.families, *self.unrolled)
        return (*pairs, *(member.shape for family in families for member in family.members))

    @property
    def signals(self) -> tuple[Any, ...]:
        """Signals in the machine's expressions, with their symbols."""
        if not self.names.signals:
            return ()
        parameters = {parameter.name for parameter in self.parameters}
        return tuple(signal for signal in self.names.signals.values() if signal.symbols[0].name in parameters)

    @property
    def switched(self) -> bool:
        """True if parameters change with time: as signals, or as inputs of controllers."""
        return bool(self.controllers or self.signals)

    def values(self, given: Mapping[Any, Any] | None = None) -> dict[str, float]:
        """Values of all parameters by name: the values in ``given`` (by name or symbol), else the defaults.

        Raises
        ------
        ModelError
            If a parameter is unknown or has no value.
        """
        given = {} if given is None else given
        if not isinstance(given, Mapping):
            raise ModelError(
                f"Expected values of parameters by name, such as {{'m': 2}}, got {shown(given)}."
            )
        by_name = dict(self.defaults)
        for key, value in given.items():
            name = key if isinstance(key, str) else self.parameter_names.get(key, key)
            if name not in by_name:
                raise self._unknown(key)
            by_name[name] = _number(value, name, self)
        missing = [name for name, value in by_name.items() if value is None]
        if missing:
            raise ModelError(
                f"No value for {'parameter' if len(missing) == 1 else 'parameters'} {', '.join(missing)}. "
                f"Give a default in s.parameters, or a value: values={{'{missing[0]}': ...}}."
            )
        return {name: float(value) for name, value in by_name.items() if value is not None}

    def __repr__(self) -> str:
        bodies = "1 body" if len(self.bodies) == 1 else f"{len(self.bodies)} bodies"
        freedom = "1 degree of freedom" if self.n_u == 1 else f"{self.n_u} degrees of freedom"
        return f"Model '{self.name}': {bodies}, {freedom}"


def _number(value: Expression, name: str, model: Model) -> float:
    """The value of a parameter as a float; text may have a unit."""
    if type(value) in _NUMBERS and abs(value) <= sys.float_info.max:
        return float(value) + 0  # -0.0 becomes 0.0, as it does in expressions
    if isinstance(value, str):
        value = quantity(value, unit_of(model, name), f"parameter '{name}'")
    expression = model.names.expression(value, f"the value of parameter '{name}'")
    if isinstance(expression, sympy.Basic) and expression.free_symbols:
        raise ModelError(f"Expected a number for parameter '{name}', got '{value}'.")
    return finite(expression, f"parameter '{name}'")


def unit_of(model: Model, name: str) -> str:
    """Return the unit of a parameter, as declared or from its use; "" if neither tells it."""
    return str(model.about.get(name, ("", ""))[0] or _unit_by_use(model, name))


def _unit_by_use(model: Model, name: str) -> str:
    """Unit of a parameter, from its use in the machine; "" if the uses give none or different units.

    A use that gives a unit is the parameter, or a number times it, as a mass, a length of a solid, a component of a
    joint's point or of gravity, the pressure angle of a gear, or a datum of a load.
    """
    used: list[tuple[str, Any]] = [("m/s^2", g) for g in model.gravity]
    for place in model.bodies.values():
        used.append(("kg", place.mass))
        shapes = [] if place.shape is None else [place.shape]
        while shapes:
            shape = shapes.pop()
            shapes += shape.parts
            if shape.kind not in ("mesh", "revolved"):
                used += [("m", length) for _, length in shape.dimensions]
    used += [("m", x) for joint in model.joints.values() for x in (*joint.at, *joint.to)]
    gears = [constraint for constraint in model.constraints.values() if isinstance(constraint, Gear)]
    used += [("rad", angle) for gear in gears for angle in (gear.pressure_angle, gear.helix_angle)]
    for load in model.loads.values():
        for field_name, unit in load.data_units.items():
            value = getattr(load, field_name)
            used += [(unit, x) for x in (value if isinstance(value, tuple) else (value,))]
    units = {unit for unit, x in used if isinstance(x, sympy.Expr) and str(x.as_coeff_Mul()[1]) == name}
    return units.pop() if len(units) == 1 else ""
