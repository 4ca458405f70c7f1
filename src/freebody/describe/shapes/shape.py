"""The protocol of a shape by which a body touches others: data, geometry at a state, laws, words in a file, look.

All components are in the axes of the body, from its origin [m]. The *outside* of a shape is the side without its body.
Two shapes have a law of contact if the feature's ``touches`` names the kind of the surface, or if the surface's
``law_with`` knows the feature; :func:`law` looks in both orders. Whatever asks which shapes touch asks here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from typing import Any, ClassVar, NamedTuple, TypeAlias, dataclass_transform

from ...errors import ModelError, shown
from ...scalar.algebra import Matrix, Scalar, Vector
from ..constants import constant
from ..description import Description, vector
from ..frame import Frame, own_body
from ..labels import OfBody

KINDS: dict[str, type[ContactShape]] = {}
"""Kinds of shapes by name, as model files know them."""


class Nearest(NamedTuple):
    """The nearest points P on the feature and Q on the surface, in ground axes, and the gap between them [m].

    ``normal`` is the unit normal from the surface to the feature. ``reach`` are numbers that are all 0 or more where
    the pair may touch at these points: for sides with ends, if the foot of the contact lies between the ends.
    """

    on_feature: Vector
    on_surface: Vector
    normal: Vector
    gap: Scalar
    reach: tuple[Scalar, ...] = ()


Law: TypeAlias = Callable[[Any, Any, Any], Nearest]
"""Geometry of a feature and a surface at a state: ``law(at, feature, surface)``."""


@dataclass_transform(frozen_default=True)
@dataclass(frozen=True, repr=False)
class ContactShape(OfBody):
    """A kind of shape for contacts: subclass it, declare its data as fields, and say its geometry.

    A subclass is a frozen dataclass, whose fields ``fb.Expression`` and ``fb.Vector`` are lengths, directions and
    places in the axes of the body. A shape with a ``support`` touches planes. Pairs with other shapes are said in
    ``touches``: for the name of a kind of surface a function ``law(at, feature, surface)`` that returns a
    :class:`freebody.Nearest`.
    ``at`` is the machine at a state, of any scalar type. It gives

    - ``at(expression)``: a value; ``at.place(body, components)``: a place in the body, in ground axes,
    - ``at.turned(body, components)``: a direction of the body, in ground axes,
    - ``at.within(body, v)`` and ``at.outward(body, v)``: values of a direction from ground axes to body axes, and back,
    - ``at.field``: functions of scalars, such as ``at.field.sqrt(x)`` and ``at.field.unit(v)``.

    Vectors are tuples of three scalars.

    Examples
    --------
    >>> import freebody as fb
    >>> class Puck(fb.ContactShape, kind="doc_puck"):
    ...     \"\"\"A ball whose centre lies at a height over the body's origin.\"\"\"
    ...
    ...     radius: fb.Expression
    ...     height: fb.Expression = 0
    ...
    ...     def support(self, at, direction):
    ...         x, y, z = at.place(self.body, (0, 0, self.height))
    ...         r = at(self.radius)
    ...         return x + r * direction[0], y + r * direction[1], z + r * direction[2]
    >>> s = fb.System("puck on a floor")
    >>> s.gravity = (0, 0, -9.81)
    >>> puck = s.body("puck", fb.sphere(1, 0.1))
    >>> air = s.free("air", s.ground, puck)
    >>> floor = s.contact("floor", Puck(puck, 0.1), s.ground.plane(normal="z"))
    >>> motion = fb.simulate(s, 0.1, initial={"air_z": 0.1})
    >>> round(float(motion.contacts["floor"].normal[-1]), 9)
    9.81
    """

    body: Frame

    kind: ClassVar[str] = ""
    """Name of the kind in files and messages."""
    words: ClassVar[Mapping[str, str]] = {}
    """Keys in model files, and the sort of each: vector, expression, direction, flag, points, edges or text."""
    door: ClassVar[bool] = False
    """True if a method of the body makes it, which checks its data."""
    required: ClassVar[tuple[str, ...]] = ()
    """Keys that a file must have."""
    places: ClassVar[tuple[str, ...]] = ("at",)
    """Fields that are places, from the origin of the body."""
    look: ClassVar[str] = ""
    """How drawings show it: spot, ball, oval, disk, wall, plane, side, profile, rope or solid."""
    bound: ClassVar[str] = ""
    """How far it reaches, where it has an end: spot, ball, edge, oval or solid."""
    hollow: ClassVar[str] = ""
    """Name of the shape that is touched from inside."""
    round: ClassVar[bool] = False
    """True if it has a ``middle``, a ``size`` and perhaps an ``axle``, and touches round shapes by them."""
    extruded: ClassVar[bool] = False
    """True if it is the same at all depths: two of these touch along a line, at one point only in a plane."""
    endless: ClassVar[bool] = False
    """True for a flat surface without end."""
    precedence: ClassVar[int] = 0
    """Of two shapes the one with the greater number gives the tangents; 0 gives none."""
    patches: ClassVar[bool] = False
    """True for a convex solid, which touches other solids, spheres and points in patches."""
    stands: ClassVar[bool] = False
    """True for a point on which a disk stands that lies flat."""
    enclosed: ClassVar[bool] = False
    """True for a corner of a solid as what touches hollows, and nothing else."""
    in_families: ClassVar[bool] = True
    section: ClassVar[str] = "contacts"
    """Section of model files in which contacts with such a surface stand."""
    touches: ClassVar[Mapping[str, Law]] = {}
    touched_by: ClassVar[Mapping[str, Law]] = {}

    def __init_subclass__(cls, *, kind: str = "", listed: bool = True) -> None:
        super().__init_subclass__()
        other = KINDS.get(kind)
        if other is not None and (other.__module__, other.__qualname__) != (cls.__module__, cls.__qualname__):
            raise ModelError(
                f"There is already a kind of shape '{kind}', {other.__module__}.{other.__qualname__}. Choose another "
                f"kind= for {cls.__qualname__}."
            )
        cls.kind = kind or cls.kind
        dataclass(frozen=True, repr=False)(cls)
        if "words" not in cls.__dict__:
            data = [f for f in fields(cls) if f.name != "body"]
            cls.words = {f.name: _sort(f) for f in data}
            cls.required = tuple(f.name for f in data if f.default is MISSING)
        if kind and listed:
            KINDS[kind] = cls

    @property
    def inside(self) -> bool:
        """True if the body is around the shape."""
        return False

    @property
    def ended(self) -> bool:
        """True if its side has ends."""
        return type(self).ends is not ContactShape.ends

    # -- geometry at a state ---------------------------------------------------------------------

    def support(self, at: Any, direction: Vector) -> Vector:
        """Return the point of the shape that is farthest along a unit direction, both in ground axes."""
        raise NotImplementedError

    def middle(self, at: Any) -> Vector:
        """Return the centre of a round shape, in ground axes."""
        raise NotImplementedError

    def axle(self, at: Any) -> Vector | None:
        """Return the axis of a round shape along which it has no end, in ground axes; None if there is none."""
        return None

    def size(self, at: Any) -> Scalar:
        """Return the radius of a round shape."""
        raise NotImplementedError

    def tangents(self, at: Any, normal: Vector, turned: bool) -> tuple[Vector, Vector]:
        """Return the tangents of a contact for a normal; ``turned`` if the shape is the feature."""
        raise NotImplementedError

    # -- pairs -------------------------------------------------------------------------------------

    @classmethod
    def has_support(cls) -> bool:
        """Return True if the kind has a support point in every direction."""
        return cls.support is not ContactShape.support

    @classmethod
    def law_with(cls, feature: type[ContactShape]) -> Law | None:
        """Return the law of a kind of feature on this kind of surface."""
        return cls.touched_by.get(feature.kind)

    @classmethod
    def part(cls, other: type[ContactShape]) -> type[ContactShape]:
        """Return the kind of the parts that touch another kind."""
        return cls

    def parts(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the parts that touch another shape, each at one point."""
        return (self,)

    def ends(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the ends that a shape can roll over, beside the parts."""
        return ()

    def standing(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the shape as one that may lie flat on another, and the points on which it stands there; or nothing."""
        return ()

    def reaches(self, at: Any, normal: Vector) -> tuple[Scalar, ...]:
        """Return what is all 0 or more where the support point touches a plane, for a shape that may lie flat."""
        return ()

    @property
    def members(self) -> Sequence[ContactShape]:
        """Parts that stand in a family of contacts."""
        return (self,)

    @property
    def enclosures(self) -> Sequence[ContactShape]:
        """Parts that stand beside them in a family with hollows, which these touch."""
        return ()

    # -- the plane of motion -----------------------------------------------------------------------

    def lies_across(self, R: Matrix, k: Vector) -> bool:
        """Return True if the shape, turned by R, may touch others in a plane at right angles to k."""
        return False

    @property
    def depth(self) -> Vector | None:
        """Place whose depth along k must be that of the other shape; None if any depth will do."""
        return None

    # -- data --------------------------------------------------------------------------------------

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the shape of a body from the data of a file."""
        return cls(body, **data)

    def told(self, word: str) -> Any:
        """Return what a file says for a key; None to leave it out."""
        value = getattr(self, word)
        default = next((f.default for f in fields(self) if f.name == word), MISSING)
        return None if value == default or (word == "at" and value == (0, 0, 0)) else value

    def checked(self, system: Description, what: str) -> ContactShape:
        """Return the shape of a body of the system, its data in the system's own terms."""
        own_body(system, self.body, what)
        if type(self).door:  # it has checked the data
            return self
        data = {}
        for f in fields(self):
            if f.name == "body":
                continue
            value, about = getattr(self, f.name), f"the {f.name} of {what}"
            match _sort(f):
                case "vector":
                    data[f.name] = tuple(constant(system, x, about) for x in vector(system, value, about))
                case "expression":
                    data[f.name] = constant(system, value, about)
                case _ if not isinstance(value, bool):
                    raise ModelError(f"Expected True or False for {about}, got {shown(value)}.")
        return type(self)(self.body, **data)


def _sort(field: Any) -> str:
    """Return the sort of a field's data."""
    text = field.type if isinstance(field.type, str) else getattr(field.type, "__name__", str(field.type))
    name = text.partition("|")[0].strip().rpartition(".")[2]
    return {"Vector": "vector", "tuple": "vector", "bool": "flag"}.get(name, "expression")


def numbers(shape: type[ContactShape]) -> dict[str, int]:
    """Return the fields of a kind that are numbers, and how many each of them has."""
    sorts = {f.name: _sort(f) for f in fields(shape) if f.name != "body"}
    return {name: 3 if sort == "vector" else 1 for name, sort in sorts.items() if sort != "flag"}


# --- pairs -------------------------------------------------------------------------------------


def law(feature: ContactShape, surface: ContactShape) -> Law | None:
    """Return the law of a feature on a surface, None if it has none in this order."""
    if feature.inside or (feature.enclosed and not surface.inside):
        return None
    return type(feature).touches.get(surface.kind) or type(surface).law_with(type(feature))


def have_law(a: ContactShape, b: ContactShape) -> bool:
    """Return True if two shapes have a law of contact in either order."""
    return law(a, b) is not None or law(b, a) is not None


def may_touch(first: type[ContactShape], second: type[ContactShape]) -> bool:
    """Return True if two kinds, or the parts by which they touch, have a law of contact in either order."""
    if in_patches(first, second):
        return True
    a, b = first.part(second), second.part(first)
    return any(f.touches.get(s.kind) or s.law_with(f) for f, s in ((a, b), (b, a)))


def in_patches(first: type[ContactShape], second: type[ContactShape]) -> bool:
    """Return True if two kinds touch in patches, which families find: a solid and another one, or a ball."""
    return any(
        a.patches and (b.patches or b.bound in ("spot", "ball"))
        for a, b in ((first, second), (second, first))
    )


def partners(kind: type[ContactShape]) -> list[str]:
    """Return the names of the kinds that a kind may touch."""
    return sorted(name for name, other in KINDS.items() if may_touch(kind, other))


def expressions(*names: str) -> Mapping[str, str]:
    """Return the words of a round shape."""
    sorts = {"at": "vector", "axis": "direction", "inside": "flag"}
    return {name: sorts.get(name, "expression") for name in names}
