"""The model: a machine as frozen data, from which every result is computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ..describe.constraints.constraint import Gear
from ..describe.description import Parameter
from ..describe.loads.load import Load
from ..scalar.algebra import Expression, Matrix, Vector
from ..space.mass import MassProperties

if TYPE_CHECKING:
    from .mesh import Mesh

GROUND = -1


@dataclass(frozen=True)
class Coordinate:
    """An entry of q: its name, its SymPy atom and its kind.

    A scalar coordinate has its own speed; the coordinates of a quaternion or of the position of a free joint do not.
    """

    name: str
    symbol: Any
    kind: str  # "scalar", "position" or "quaternion"


@dataclass(frozen=True)
class Speed:
    """An entry of u: its name, its SymPy atom and the atom of its time derivative."""

    name: str
    symbol: Any
    acceleration: Any


@dataclass(frozen=True)
class Link:
    """A primitive motion and the link that it moves.

    The link's frame has its origin at the joint's point and the axes of its body (the axes of the joint
    for the massless links inside a joint). In the frame of the parent link, the joint's
    frame has the origin ``position`` and the constant rotation ``rotation`` (parent from joint).
    """

    joint: str
    body: str | None
    kind: str  # hinge, slider, screw, ball, free, weld
    parent: int
    rotation: Matrix
    position: Vector
    axis: Vector
    pitch: Expression
    displacement: Expression  # y(q, t) of a primitive with one degree of freedom
    partials: tuple[tuple[int, Expression], ...]  # (index of the speed, dy/dq) where dy/dq is not zero
    drift: Expression  # dy/dt at constant q
    bias: Expression  # second derivative of y without the terms with accelerations
    q: int  # first coordinate of a ball or free joint, else -1
    u: int  # first speed of a ball or free joint, else -1
    mass: Expression
    center: Vector
    inertia: Matrix  # about the mass centre

    @property
    def one_dof(self) -> bool:
        """True if the motion has a displacement."""
        return self.kind in ("hinge", "slider", "screw")

    @property
    def driven(self) -> bool:
        """True if the motion is a given function of time."""
        return self.one_dof and not self.partials


@dataclass(frozen=True)
class Place:
    """Place of a body's frame: its link, and its origin from the origin of the link."""

    link: int
    origin: Vector
    mass: Expression
    center: Vector  # from the body's origin
    inertia: Matrix
    properties: MassProperties | None = None


@dataclass(frozen=True)
class JointPlace:
    """The links of a joint, first to last, and the bodies it joins."""

    type: str
    links: tuple[int, ...]
    parent: str
    child: str
    at: Vector
    to: Vector


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

    controllers: tuple[Any, ...] = ()
    """Sampled controllers, in order of declaration."""

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
    def quaternions(self) -> tuple[int, ...]:
        """Index in q of the scalar part of each unit quaternion."""
        return tuple(
            link.q + (3 if link.kind == "free" else 0) for link in self.links if link.kind in ("ball", "free")
        )

    @cached_property
    def coordinate_names(self) -> tuple[str, ...]:
        """Names of q, in order."""
        return tuple(coordinate.name for coordinate in self.coordinates)

    @cached_property
    def speed_names(self) -> tuple[str, ...]:
        """Names of u, in order."""
        return tuple(speed.name for speed in self.speeds)

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
            sizes = {"free": 7, "ball": 4}
            link = next(k for k in self.links if 0 <= k.q <= i < k.q + sizes.get(k.kind, 0))
            start = link.u if coordinate.kind == "quaternion" else link.u + 3
            result.append((start, start + 1, start + 2))
        return tuple(result)

    @cached_property
    def places(self) -> Mapping[str, int]:
        """Index of each coordinate and speed in (q, u), by name."""
        return {name: i for i, name in enumerate((*self.coordinate_names, *self.speed_names))}

    @cached_property
    def single_places(self) -> Mapping[str, int]:
        """:attr:`places` without the components of quaternions, which have a meaning only in fours."""
        components = {i + k for i in self.quaternions for k in range(4)}
        return {name: i for name, i in self.places.items() if i not in components}

    @cached_property
    def parameter_names(self) -> Mapping[Any, str]:
        """Names of the parameters by their symbols."""
        return {parameter.symbol: parameter.name for parameter in self.parameters}

    @cached_property
    def defaults(self) -> Mapping[str, float | None]:
        """Default values of the parameters by name, None where there is none."""
        return {parameter.name: parameter.default for parameter in self.parameters}

    @cached_property
    def assumed(self) -> tuple[Any, ...]:
        """Expressions of the parameters alone that are assumed positive, in a fixed order."""
        from .values import assumed

        return assumed(self)

    @cached_property
    def meshes(self) -> Mapping[str, Mesh | str]:
        """The mesh of each gear, or the reason why only its ratio is known, by name."""
        from .mesh import mesh_of

        gears = {name: gear for name, gear in self.constraints.items() if isinstance(gear, Gear)}
        return {name: mesh_of(self, gear) for name, gear in gears.items()}

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
        from .values import parameter_values

        return parameter_values(self, {} if given is None else given)

    def __repr__(self) -> str:
        bodies = "1 body" if len(self.bodies) == 1 else f"{len(self.bodies)} bodies"
        freedom = "1 degree of freedom" if self.n_u == 1 else f"{self.n_u} degrees of freedom"
        return f"Model '{self.name}': {bodies}, {freedom}"
