"""Contacts of a model: one element for each pair of shapes that may touch at one point.

Each corner and each end of a segment is a separate element. A machine is *planar* if all its joints move in one
plane. A contact in that plane has one tangent, any other contact has two.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from ..describe.contacts.coefficients import at_rest, depends_on_slip
from ..describe.contacts.contact import ContactPair
from ..describe.contacts.gap import Gap
from ..describe.shapes.shape import ContactShape, law
from ..errors import ModelError
from ..scalar.algebra import (
    IDENTITY,
    ZERO,
    Expression,
    Matrix,
    Vector,
    apply,
    cross,
    divide,
    dot,
    multiply,
)
from ..scalar.expression import exact
from .model import GROUND, Link, Model


def elliptic_friction(d: Sequence[Any], mu: Sequence[Any], sqrt: Callable[[Any], Any]) -> list[Any]:
    """Return -T/N of a slip in the direction d, with two coefficients: μ_i² d_i/√(μ_1² d_1² + μ_2² d_2²)."""
    first, second = (a * b for a, b in zip(mu, d, strict=True))
    size = sqrt(first * first + second * second)
    return [divide(mu[0] * first, size), divide(mu[1] * second, size)]


def friction_margin(static: Any, pressure: Any, T: Any, ratio: Any, sqrt: Callable[[Any], Any]) -> Any:
    """Return μ_s (N + A) - |T|, of friction with two coefficients of this ratio |(T_1, T_2/ratio)|."""
    square = T[0] * T[0] if len(T) else 0
    for second in T[1:]:
        level = divide(second, ratio)
        square = square + level * level
    return static * pressure - sqrt(square)


def friction_varies(model: Model, contact: Contact) -> bool:
    """Return True if the friction of a contact depends on slip, place, speeds or time, or is another one at rest."""
    moving = model.names.depends(contact.friction, "coordinate", "speed", "time")
    return contact.slows or bool(moving) or contact.friction != contact.static_friction


OF_LENGTHS = {"gap": "m", "approach": "m/s", "normal": "N", "tangential": "N", "slip": "m/s", "margin": "N"}
OF_ANGLES = {
    "gap": "rad", "approach": "rad/s", "normal": "N m", "tangential": "N m", "slip": "rad/s", "margin": "N m",
}  # fmt: skip
"""Units of the quantities of a contact."""
LETTERS = (), ("T",), ("T1", "T2")
"""Letters of the components of friction, for each number of tangents."""


class Side(ContactShape):
    """A body of a contact that is known by its gap and not by two shapes."""


@dataclass(frozen=True)
class Contact:
    """One element of a contact: two shapes that touch at one point, or a gap of another sort.

    Attributes
    ----------
    name : str
        Name of the contact, followed by a number, "start" or "end" if it has several elements.
    owner : str
        Name that the user gave to the contact.
    feature, surface : shapes
    friction : expression
        The kinetic coefficient, which may depend on SLIP.
    static_friction, restitution : expressions
    impact : "newton" or "poisson"
    planar : unit vector or None
        Normal k of the plane of motion; the tangent is then n × k.
    upright : unit vector
        Ground axis against gravity; the tangents of round surfaces are undefined where n = -upright.
    normal_name, tangent_names : str, tuple of str
        Names of the forces N and T.
    law : Gap or None
        The gap and the actions of the forces, if it is no pair of shapes; feature and surface are then the two bodies.
    normal_force : expression or None
        The normal force of a compliant contact by DEPTH and RATE.
    friction_across : expression or None
        Kinetic coefficient at right angles to the direction ``along`` of the surface's body, if it is another one.
    adhesion : expression
        The pull that the contact bears: N ≥ -adhesion.
    presser : str
        For resistance to rolling or spinning: the contact whose normal force bounds it; else empty.
    """

    name: str
    owner: str
    feature: ContactShape
    surface: ContactShape
    friction: Expression
    static_friction: Expression
    restitution: Expression
    impact: str
    planar: Vector | None
    upright: Vector
    normal_name: str
    tangent_names: tuple[str, ...]
    law: Gap | None = None
    normal_force: Expression = None
    friction_across: Expression = None
    along: Vector | None = None
    adhesion: Expression = 0
    presser: str = ""

    def __repr__(self) -> str:
        return f"contact '{self.name}'"

    @property
    def tangents(self) -> int:
        """Number of tangent directions: 1 in a planar machine, else 2."""
        return len(self.tangent_names)

    @property
    def friction_name(self) -> str:
        """Name of the friction as one force; in space it has two components."""
        return self.tangent_names[0] if self.tangents == 1 else self.normal_name.replace("N", "T", 1)

    @property
    def frictionless(self) -> bool:
        """True if there is no friction for any values of the parameters."""
        return bool(self.friction == 0 and self.static_friction == 0)

    @property
    def friction_at_rest(self) -> Expression:
        """Coefficient of kinetic friction as slip begins."""
        return at_rest(self.friction)

    @property
    def coefficients(self) -> tuple[Expression, Expression]:
        """The coefficients of kinetic friction along its direction and across it."""
        return self.friction, self.friction if self.friction_across is None else self.friction_across

    @property
    def stretch(self) -> Expression:
        """Ratio of the coefficients of friction across and along its direction: (T1, T2/ratio) is in Coulomb's disk."""
        if self.friction_across is None:
            return 1
        return exact(sympy.sympify(self.friction_across) / self.friction)

    @property
    def slows(self) -> bool:
        """True if the coefficient of friction depends on the slip speed."""
        return depends_on_slip(self.friction)

    @property
    def slipping(self) -> str:
        """The mode of the closed contact that slips: "closed" if it has no tangents, else "slip"."""
        return "slip" if self.tangent_names or self.law is None else "closed"

    def shown(self, mode: str) -> str:
        """Return a mode as it is shown: without tangents a contact does not slip, it is closed."""
        return self.slipping if mode == "slip" else mode

    @property
    def held(self) -> bool:
        """True if the state gives its normal force: a compliant contact, or dry friction of a joint, pressed by 1."""
        return self.compliant or (self.law is not None and self.law.held)

    @property
    def loaded(self) -> bool:
        """True if the load of a joint presses it: it depends on the accelerations."""
        return self.law is not None and self.law.loaded

    @property
    def bounded(self) -> bool:
        """True if a force bounds its friction that is known with the motion: a load of a joint, or a normal force."""
        law: Any = self.law
        return self.loaded or (bool(self.presser) and not law.contact.compliant)

    @property
    def compliant(self) -> bool:
        """True if its normal force is a law of its depth."""
        return self.normal_force is not None

    @property
    def units(self) -> Mapping[str, str]:
        """Units of its gap, forces, slip and margin: those of an angle where it is a stop or friction of one."""
        return OF_ANGLES if self.law is not None and self.law.turns else OF_LENGTHS

    @property
    def stands(self) -> bool:
        """True if it is one of the points on which a disk stands that lies flat."""
        return self.law is None and (self.feature.stands or self.surface.stands)

    @property
    def swapped(self) -> bool:
        """True if the law of contact takes the surface as its feature."""
        return self.law is None and law(self.feature, self.surface) is None


def contacts(model: Model, pairs: Sequence[ContactPair | Gap]) -> tuple[Contact, ...]:
    """Return the elements of all contacts, in order of declaration.

    Raises
    ------
    ModelError
        If shapes touch at one point only while their axes are parallel, and the machine can turn these axes.
    """
    if not pairs:
        return ()
    frames = frames_at_rest(model.links)
    planes = [k for k in (2, 1, 0) if moves_across(model.links, frames, IDENTITY[k])]
    taken = {*model.names.kinds, *model.loads, *model.constraints}
    taken |= {
        f"{name}_{ending}"
        for name in model.joints
        for ending in (*"xyznpq", "Mx", "My", "Mz", "Mn", "Mp", "Mq")
    }
    names = {pair.name for pair in pairs}
    result: list[Contact] = []
    for pair in pairs:
        if isinstance(pair, Gap):
            result += _gaps(model, pair, names, taken)
            continue
        for ending, feature, surface in standing(model, frames, planes, pair):
            k = None
            if not (feature.stands or surface.stands):
                k = next((k for k in planes if within(model, frames, feature, surface, IDENTITY[k])), None)
            check_axes(pair.name, feature, surface, k)
            if k is not None and pair.along is not None:
                raise ModelError(
                    f"Contact '{pair.name}' has two coefficients of friction, but the machine moves in a plane, in "
                    f"which the contact slips along one line. Give the one coefficient of that line."
                )
            name, normal, *tangents = _named(pair, ending, 1 if k is not None else 2, names, taken)
            one = Contact(
                name, pair.name, feature, surface, pair.friction, pair.static_friction, pair.restitution, pair.impact,
                None if k is None else IDENTITY[k], upright_of(model.gravity), normal, tuple(tangents), None,
                pair.normal_force, pair.friction_across, pair.along, pair.adhesion,
            )  # fmt: skip
            result.append(one)
    return tuple(result)


def _gaps(model: Model, pair: Gap, names: set[str], taken: set[str]) -> list[Contact]:
    """Return the elements of a contact that is known by its gaps."""
    result = []
    feature, surface = map(Side, pair.bodies)
    kinetic, static = pair.limits
    for ending, gap in pair.elements:
        count = 0 if kinetic == static == 0 else gap.directions
        name, normal, *tangents = _named(pair, ending, count, names, taken)
        one = Contact(
            name, pair.name, feature, surface, kinetic, static, pair.restitution, pair.impact, None,
            upright_of(model.gravity), normal, tuple(tangents), gap,
        )  # fmt: skip
        result.append(one)
    return result


def _named(pair: Any, ending: str, tangents: int, names: set[str], taken: set[str]) -> list[str]:
    """Return the name of an element of a contact, and the names of its forces; from then on they are taken."""
    name = free_name(f"{pair.name}_{ending}", names) if ending else pair.name
    names.add(name)
    return [name, *(free_name(f"{x}_{name}", taken) for x in ("N", *LETTERS[tangents]))]


def free_name(name: str, taken: set[str]) -> str:
    """Return a name that is taken from then on: this one, or with underscores, if it was taken already."""
    while name in taken:
        name += "_"
    taken.add(name)
    return name


def upright_of(gravity: Vector) -> Vector:
    """The ground axis along which gravity acts; z for any other gravity."""
    axes = [k for k in range(3) if gravity[k] != 0]
    return IDENTITY[axes[0]] if len(axes) == 1 else IDENTITY[2]


def elements(a: ContactShape, b: ContactShape) -> list[tuple[str, Any, Any]]:
    """(ending of the name, feature, surface) of the elements of two shapes, each of which touches at one point.

    The ending is empty for the main element: the only one, or the side of a segment or capsule.
    """
    pairs = [(first, second) for first in a.parts(b) for second in b.parts(a)]
    if len(pairs) > 1:
        return [(str(i), first, second) for i, (first, second) in enumerate(pairs, start=1)]
    names = ("start", "end")  # a round shape can roll over the end of a side
    return [
        ("", *pairs[0]),
        *((ending, end, b) for ending, end in zip(names, a.ends(b), strict=False)),
        *((ending, a, end) for ending, end in zip(names, b.ends(a), strict=False)),
    ]


def standing(
    model: Model, frames: Sequence[tuple[Matrix, Vector]], planes: Sequence[int], pair: ContactPair
) -> list[tuple[str, Any, Any]]:
    """The elements of a pair; the edge of a disk that may lie flat on a plane has those on which it stands there, too.

    A law of the depth, and adhesion, would act at each of these: such a contact has its lowest point only.
    """
    result = []
    for ending, a, b in elements(pair.feature, pair.surface):
        points: list[tuple[Any, Any]] = []
        planar = any(within(model, frames, a, b, IDENTITY[k]) for k in planes)
        if not planar and pair.normal_force is None and pair.adhesion == 0:
            points = [(x, b) for x in a.standing(b)] + [(a, x) for x in b.standing(a)]
        result.append((ending, *(points[0] if points else (a, b))))
        result += [
            ("_".join(filter(None, (ending, str(i)))), *it) for i, it in enumerate(points[1:], start=1)
        ]
    return result


# --- the plane of motion -----------------------------------------------------------------------


def frames_at_rest(links: Sequence[Link]) -> list[tuple[Matrix, Vector]]:
    """Rotation and position of every link in the ground if all displacements are zero."""
    result: list[tuple[Matrix, Vector]] = []
    for link in links:
        R, p = (IDENTITY, ZERO) if link.parent == GROUND else result[link.parent]
        shift = apply(R, link.position)
        turned = multiply(R, link.rotation)
        rotation: Any = tuple(tuple(exact(x) for x in row) for row in turned)
        result.append((rotation, tuple(exact(a + b) for a, b in zip(p, shift, strict=True))))
    return result


def _zero(v: Vector) -> bool:
    return all(exact(x) == 0 for x in v)


def moves_across(links: Sequence[Link], frames: Sequence[tuple[Matrix, Vector]], k: Vector) -> bool:
    """True if all joints turn about k or slide at right angles to it."""
    for link, (R, _) in zip(links, frames, strict=True):
        # a turn of the link's frame about the joint's axis does not change that axis
        n = apply(R, link.axis)
        if link.turns_only and _zero(cross(n, k)):
            continue
        if link.slides_only and exact(dot(n, k)) == 0:
            continue
        if not link.fixed:
            return False
    return True


def within(
    model: Model, frames: Sequence[tuple[Matrix, Vector]], a: ContactShape, b: ContactShape, k: Vector
) -> bool:
    """True if two shapes of a machine that moves at right angles to k touch in the plane of motion."""
    depths = []
    for shape in (a, b):
        R, p = _frame(model, frames, shape.body)
        if not shape.lies_across(R, k):
            return False
        if shape.depth is not None:
            depths.append(exact(dot(k, p) + dot(k, apply(R, shape.depth))))
    # the line between two points or spheres is in the plane if both have the same depth
    return len(depths) < 2 or exact(depths[0] - depths[1]) == 0


def _frame(model: Model, frames: Sequence[tuple[Matrix, Vector]], body: Any) -> tuple[Matrix, Vector]:
    """Rotation and position of a body's frame in the ground if all displacements are zero."""
    if body.is_ground:
        return IDENTITY, ZERO
    place = model.bodies[body.name]
    R, p = (IDENTITY, ZERO) if place.link == GROUND else frames[place.link]
    shift = apply(R, place.origin)
    return R, tuple(a + b for a, b in zip(p, shift, strict=True))


def check_axes(name: str, a: ContactShape, b: ContactShape, k: int | None) -> None:
    """Refuse two cylinders, or a cylinder and a flat side, that do not touch in the plane of motion."""
    if k is None and a.extruded and b.extruded:
        first, second = a.kind, b.kind
        raise ModelError(
            f"The {first} and the {second} of contact '{name}' touch at one point only if all motion is in a plane "
            f"at right angles to their axes, which is not the case here. In 3-D, use a sphere for one of them, or a "
            f"plane for the flat one."
        )
