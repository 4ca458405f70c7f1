"""The protocol of a load: its data, its actions at a state, its potential, its words in a file and its look.

What users may add by classes of their own, loads and contacts, are parts (:class:`Part`): data in fields, which
:func:`add` checks.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, Literal, TypeAlias, dataclass_transform

from ...errors import ModelError, nearest, shown
from ...scalar.algebra import Expression, Scalar
from ..description import Description, claim, coordinates_of, varying, vector
from ..frame import Point, own_body, own_point
from ..joints.joint import Joint
from ..joints.rotor import Rotor
from ..labels import Named
from .action import Action
from .law import law_of

Constant: TypeAlias = Expression
"""An expression that does not change during a motion."""
Coordinate: TypeAlias = Any
"""A coordinate, by its name or its function of time."""

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
class Part(Named):
    """A part of a machine whose data are its fields. ``table`` is the dictionary of the system that holds it."""

    name: str = field(default="", kw_only=True)

    table: ClassVar[str] = "loads"
    article: ClassVar[str] = "load"
    """What messages call a part of this sort."""
    labels: ClassVar[Mapping[str, str]] = {}
    """What messages call fields, if not by their names."""
    noun: ClassVar[str] = ""
    """What messages call the part, if not by the name of its class."""
    kind: ClassVar[str] = ""
    """Name of the kind in model files."""
    words: ClassVar[Mapping[str, str]] = {}
    """Keys in model files that are not the names of their fields."""

    def check(self) -> None:
        """Refuse data that no part of this kind can have; :meth:`System.add` calls it."""

    @property
    def title(self) -> str:
        """Kind and name, as messages write them."""
        return f"{self.noun} '{self.name}'" if self.noun else repr(self)

    @property
    def heading(self) -> str:
        """Kind and name at the beginning of a sentence."""
        return f"{self.title[0].upper()}{self.title[1:]}"


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

    sections: ClassVar[tuple[str, ...]] = ("loads",)
    """Sections of model files in which the kind stands."""
    units: ClassVar[Mapping[str, str]] = {}
    """Units of fields; a parameter that stands in one may then be given in any unit of this sort."""
    turning_units: ClassVar[Mapping[str, str]] = {}
    """Units of fields of a load along a joint's turn, if they differ from those along its slide."""
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


def register(cls: type[Part], kind: str, known: dict[str, Any]) -> None:
    """Make a class of a part a frozen dataclass, and its kind known to model files."""
    # a class of the same place replaces the one that it was: a notebook runs a cell again, a script is imported
    other = known.get(kind)
    if other is not None and _place(other) != _place(cls):
        raise ModelError(
            f"There is already a kind of {cls.article} '{kind}' in files, {other.__module__}.{other.__qualname__}. "
            f"Choose another kind= for {cls.__qualname__}."
        )
    cls.kind = kind
    dataclass(frozen=True, repr=False)(cls)
    if kind:
        known[kind] = cls


def _place(cls: type[Part]) -> tuple[str, str]:
    """Return the file, or else the module, in which a class is written, and its name there."""
    module = cls.__module__
    return getattr(sys.modules.get(module), "__file__", None) or module, cls.__qualname__


def add(system: Description, name: str, part: Part) -> Any:
    """Add a load or a contact to the machine.

    Parameters
    ----------
    name : str
    part : Load or Gap
        Such as an instance of your own subclass of :class:`freebody.Load` or :class:`freebody.Gap`.

    Returns
    -------
    Load or Gap
        The part with its name.
    """
    claim(system, name, getattr(part, "article", "load"))
    if not isinstance(part, Part):
        cure = " Make it one: Drag(point, factor)." if isinstance(part, type) else ""
        raise ModelError(
            f"Expected a load or a contact for '{name}', an instance of a subclass of fb.Load or fb.Gap, got "
            f"{shown(part)}.{cure}"
        )
    if part.name:
        raise ModelError(f"{part.title} is already part of a system. Make another one for '{name}'.")
    part = replace(part, name=name)
    values = {
        f.name: _checked(system, f, getattr(part, f.name), part) for f in fields(part) if f.name != "name"
    }
    part = replace(part, **values)
    part.check()
    getattr(system, part.table)[name] = part
    return part


# --- fields ------------------------------------------------------------------------------------


def sort_of(field: Any) -> str:
    """Return the sort of a field's data, the last name of its annotation: "Point" for ``fb.Point | None``."""
    text = field.type if isinstance(field.type, str) else getattr(field.type, "__name__", str(field.type))
    text = text.partition("|")[0].strip().rpartition(".")[2]
    return {"Frame": "Body", "tuple": "Vector", "Any": "Expression", "Scalar": "Expression"}.get(text, text)


def _checked(system: Description, field: Any, value: Any, load: Part) -> Any:
    """Return the value of a field in the system's own terms; None only where that is the default."""
    sort = sort_of(field)
    if sort not in _SORTS or (value is None and field.default is None):
        return value
    return _SORTS[sort](system, value, load, field.name)


def _expression(system: Description, value: Any, load: Part, name: str) -> Any:
    return system.expression(value, load.title)


def _constant(system: Description, value: Any, load: Part, name: str) -> Any:
    what = f"the {load.labels.get(name, name)} of {load.title}"
    expression = system.expression(value, what)
    moving = varying(system, expression)
    if moving:
        raise ModelError(
            f"{what[0].upper()}{what[1:]} must be constant, but it depends on {', '.join(moving)}. "
            f"Write the law as a force or a generalized force instead."
        )
    return expression


def _joint(system: Description, value: Any, load: Part, name: str) -> Any:
    if not isinstance(value, Joint):
        raise ModelError(f"Expected a joint for {load.title}, got {shown(value)}.")
    title = load.title
    if system.joints.get(value.name) is not value:
        raise ModelError(
            f"{title[0].upper()}{title[1:]}: joint '{value.name}' belongs to another system than '{system.name}'. "
            f"Name a joint of this one."
        )
    return value


def own_coordinate(system: Description, value: Any) -> Any:
    """Return a coordinate of the system, by its name or itself, as its function of time."""
    if isinstance(value, str) and value not in coordinates_of(system):
        raise ModelError(f"Unknown coordinate '{value}'; {nearest(value, coordinates_of(system))}")
    atom = system.expression(value, "the coordinate of a generalized force")
    if atom not in coordinates_of(system).values():
        raise ModelError(
            f"Expected a coordinate of this system, got '{atom}'. Coordinates of ball and free joints take "
            f"forces and torques on the body instead."
        )
    return atom


_SORTS: dict[str, Callable[[Description, Any, Part, str], Any]] = {
    "Point": lambda system, value, load, name: own_point(system, value, load.title),
    "Body": lambda system, value, load, name: own_body(system, value, load.title),
    "Joint": _joint,
    "Coordinate": lambda system, value, load, name: own_coordinate(system, value),
    "Expression": _expression,
    "Constant": _constant,
    "Vector": lambda system, value, load, name: vector(system, value, load.title),
    "Law": lambda system, value, load, name: law_of(system, value, load.title),
}
