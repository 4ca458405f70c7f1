"""The protocol of a load: its data, its actions at a state, its potential, its words in a file and its look."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, Literal, dataclass_transform

from ...errors import ModelError
from ...scalar.algebra import Scalar
from ..frame import Point
from ..joints.joint import Joint
from ..joints.rotor import Rotor
from ..part import SORTS, Part, register
from .action import Action
from .law import law_of

KINDS: dict[str, type[Load]] = {}
"""Kinds of loads that model files know, by name."""


@dataclass(frozen=True)
class Look:
    """How a load is drawn.

    Attributes
    ----------
    role : "load", "spring", "damper" or "motor"
        It sets the colour of the arrows; springs and dampers stand on the left of printed equations of motion.
    symbol : "", "zigzag" or "dashpot"
        Symbol between the two points of the load, or along its joint; without one, its actions are drawn as arrows.
    label : str
        Field whose value stands beside the symbol.
    """

    role: Literal["load", "spring", "damper", "motor"] = "load"
    symbol: Literal["", "zigzag", "dashpot"] = ""
    label: str = ""


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
@dataclass(frozen=True, repr=False)
class Load(Part):
    """A kind of load: subclass it, declare its data as fields, and say its actions.

    A subclass is a frozen dataclass. Its fields are annotated ``fb.Point``, ``fb.Body``, ``fb.Joint``,
    ``fb.Expression`` (a number, text or SymPy expression), ``fb.Vector`` (three of these), or with a type of Python.
    ``s.add(name, load)`` checks them: points and bodies belong to the system, text is read.

    ``actions(at)`` yields :class:`~freebody.PointForce`, :class:`~freebody.Couple`, :class:`~freebody.JointForce` and
    :class:`~freebody.GeneralizedForce`. What acts between two bodies yields both. ``at`` is the machine at a state, of
    any scalar type: numbers, formulas, compiled code. It gives

    - ``at(expression)`` and ``at.vector(components, frame)``: values; ``at.t``: the time [s],
    - ``at.position(point)``, ``at.velocity(point)``, ``at.angular_velocity(body)``: vectors in ground axes, or in
      those of ``frame=``; ``at.rotation(body)``: the matrix R_NB; ``at.line(start, end)``: the vector between points,
    - ``at.acceleration(point)``, ``at.angular_acceleration(body)``: what depends on them is added mass, -B A with a
      symmetric B of positions and time; it is part of the mass matrix and of the kinetic energy,
    - ``at.displacement(joint, index)``, ``at.rate(joint, index)``,
    - ``at.sqrt(x)``, ``at.tanh(x)``, ``at.atan2(y, x)`` and all other functions of expressions,
    - ``at.where(x, a, b)``: a if x > 0, else b; a motion locates the times at which x passes through zero.

    Vectors have ``+ - * /``, ``v.dot(w)``, ``v.cross(w)`` and ``v.norm()``. An ``if`` on a value is refused, since
    formulas and compiled code have none; ``at.where``, ``at.sign``, ``at.min`` and ``at.max`` serve instead.

    A load may have a ``potential(at)`` [J], whose gradient is its force; its work is then not counted again.
    ``class Drag(fb.Load, kind="my_drag")`` gives it a name in model files.

    Examples
    --------
    >>> import freebody as fb
    >>> class Drag(fb.Load):
    ...     point: fb.Point
    ...     factor: fb.Expression  # k [N s²/m²]
    ...
    ...     def actions(self, at):
    ...         v = at.velocity(self.point)
    ...         yield fb.PointForce(self.point, -at(self.factor) * v.norm() * v)
    >>> s = fb.System("falling ball")
    >>> s.gravity = (0, "-g", 0) if s.parameters(g=9.81) else None
    >>> ball = s.body("ball", fb.particle(1))
    >>> guide = s.slider("guide", s.ground, ball, axis="y", coordinate="y")
    >>> s.add("drag", Drag(ball.origin, 0.1))
    drag 'drag'
    >>> print(fb.equations(s).text())
    y'' + g = -y'*abs(y')/10
    """

    table: ClassVar[str] = "loads"
    article: ClassVar[str] = "load"
    rules: ClassVar[str] = (
        "Actions and potential are formulas of what `at` gives, without if on a value: at.where(x, a, b), at.sign, "
        "at.min and at.max serve instead. fb.Load lists what they may use."
    )
    sections: ClassVar[tuple[str, ...]] = ("loads",)
    """Sections of model files in which the kind stands."""
    units: ClassVar[Mapping[str, str]] = {}
    """Units of fields; a parameter that stands in one may then be given in any unit of this sort."""
    turning_units: ClassVar[Mapping[str, str]] = {}
    """Units of fields of a load along a joint's turn, if they differ from those along its slide."""
    on_joint: ClassVar[str] = "hinge"
    """Kind of its joint: `ball`, `free`, or `hinge` for any joint with displacements."""
    look: ClassVar[Look] = Look()
    switches: ClassVar[tuple[str, str]] = ("switches", "switches back")
    """What events say when a condition of ``at.where`` rises through zero, and when it falls."""

    def __init_subclass__(cls, *, kind: str = "", sections: tuple[str, ...] = ("loads",)) -> None:
        super().__init_subclass__()
        cls.sections = sections
        register(cls, kind, KINDS)

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the forces and couples of the load at a state."""
        raise ModelError(
            f"{self.title}: its class {type(self).__name__} has no actions. Define actions(self, at), which yields "
            f"fb.PointForce, fb.Couple, fb.JointForce or fb.GeneralizedForce."
        )

    def potential(self, at: Any) -> Scalar:
        """Return the potential energy of the load at a state [J]."""
        raise ModelError(f"{self.title} has no potential.")

    @property
    def section(self) -> str:
        """Section of model files in which the load stands."""
        return self.sections[0]

    @property
    def is_conservative(self) -> bool:
        """True if the load has a potential."""
        return type(self).potential is not Load.potential

    @property
    def rotors(self) -> tuple[tuple[Joint, Rotor], ...]:
        """Rotors that the load brings along, with the joints that turn them, as a motor does."""
        return ()

    @property
    def strand(self) -> tuple[Point, ...]:
        """Points of the line that is drawn for the load, from one to the next, as for a belt; none for most."""
        return ()

    @property
    def data_units(self) -> dict[str, str]:
        """Units of the data, by field."""
        joint, index = getattr(self, "joint", None), getattr(self, "index", 0)
        turns = joint is not None and joint.primitives[index].turns
        return {**self.units, **self.turning_units} if turns else dict(self.units)

    @property
    def points(self) -> dict[str, Point]:
        """Points among the data, by field."""
        values = ((f.name, getattr(self, f.name)) for f in fields(self))
        return {name: value for name, value in values if isinstance(value, Point)}


SORTS["Law"] = lambda system, value, load, name: law_of(system, value, load.title)
