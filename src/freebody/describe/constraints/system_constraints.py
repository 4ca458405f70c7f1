"""Methods of System that make constraints: conditions on coordinates and speeds, gears, ropes, rolling."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import Expression
from ..axes import UNIT, direction
from ..constants import default_value
from ..contacts.coefficients import coefficient
from ..contacts.contact import ContactPair
from ..contacts.system_contacts import contact
from ..description import Description, claim, names_of
from ..frame import Point, own_point
from ..joints.joining import check_smooth, check_unbroken
from ..shapes.sphere import Tether
from .arguments import fixed, store, text_of
from .constraint import Condition, Constraint, Rolling, Rope, SpeedCondition


def constrain(
    system: Description, condition: Any, *, name: str | None = None, unilateral: bool = False
) -> Constraint:
    """Keep an expression of coordinates and time zero (a holonomic constraint).

    Parameters
    ----------
    condition : expression, or SymPy ``Eq``
        An expression of coordinates, parameters and time.
    name : str, optional
        Name of its multiplier in the equations.
    unilateral : bool
        True if the force acts only towards greater values of the expression (left - right), like that of an open groove
        ``y - x^2`` on a bead from below. A motion that would need the opposite force reports it in
        ``motion.warnings``.

    Raises
    ------
    ModelError
        An expression with speeds, or without coordinates.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("bead on a parabola")
    >>> bead = s.body("bead", fb.particle(1))
    >>> rail = s.planar("rail", s.ground, bead, coordinate="x y turn")
    >>> c = s.constrain("y - x^2", name="wire")
    """
    name, expression = _named(system, condition, name, "constraint")
    speeds = names_of(system).depends(expression, "speed")
    if speeds:
        raise ModelError(
            f"Constraint '{name}' depends on {', '.join(speeds)}. Use s.constrain_speed for a condition on speeds."
        )
    check_smooth(system, expression, f"constraint '{name}'")
    if not names_of(system).depends(expression, "coordinate"):
        raise ModelError(
            f"Constraint '{name}' contains no coordinate: '{text_of(system, expression)}' does not restrict the motion."
        )
    return store(
        system, Condition(name, expression, _boolean(unilateral, f"unilateral= of constraint '{name}'"))
    )


def constrain_speed(system: Description, condition: Any, *, name: str | None = None) -> Constraint:
    """Keep an expression that is linear in the speeds zero (a non-holonomic constraint).

    Parameters
    ----------
    condition : expression, or SymPy ``Eq``
        An expression, linear in the speeds, of speeds, coordinates, parameters and time, such as ``"x' - R*phi'"``.
    name : str, optional
        Name of its multiplier in the equations.
    """
    name, expression = _named(system, condition, name, "speed constraint")
    speeds = names_of(system).depends(expression, "speed")
    if not speeds:
        raise ModelError(
            f"Speed constraint '{name}' contains no speed: '{text_of(system, expression)}'. Use s.constrain for a "
            f"condition on coordinates."
        )
    check_unbroken(system, expression, f"speed constraint '{name}'")
    atoms = [names_of(system).atoms[speed] for speed in speeds]
    for atom in atoms:
        slope = sympy.diff(expression, atom)
        if any(sympy.simplify(sympy.diff(slope, other)) != 0 for other in atoms):
            raise ModelError(
                f"Speed constraint '{name}' must be linear in the speeds, but '{text_of(system, expression)}' is not "
                f"linear in {names_of(system).texts[atom]}."
            )
    return store(system, SpeedCondition(name, expression))


def rope(
    system: Description,
    points: Sequence[Any],
    length: Expression,
    *,
    name: str = "rope",
    unilateral: bool = True,
    taut: bool = True,
    restitution: Expression = 0,
) -> Constraint | ContactPair:
    """Add a taut rope of constant ``length`` from the first point over all others to the last, without friction.

    Parameters
    ----------
    points : sequence of at least two Points
        List a point twice if the rope passes it twice.
    length : expression [m]
        An expression of parameters and, for a rope that is hauled in, of time.
    unilateral : bool
        True if it only pulls; a motion in which it would push reports it in ``motion.warnings``. False: a light rod.
    taut : bool
        False: it may go slack. It is then a contact between two points with the gap length - distance, whose tension
        is ``N_name``; while it is slack its mode is "open".
    restitution : expression of parameters
        For a rope that goes slack: ratio of the speeds of its ends towards each other after, and apart before, it is
        pulled taut.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("stone on a string")
    >>> s.gravity = (0, -9.81, 0)
    >>> stone = s.body("stone", fb.sphere(1, 0.05))
    >>> fly = s.planar("fly", s.ground, stone, coordinate="x y turn")
    >>> string = s.rope([s.ground.origin, stone.origin], 1, name="string")
    >>> motion = fb.simulate(s, 1, initial={"x": 0, "y": -1, "x'": 5.5})
    >>> motion.warnings[0].what
    'the rope pushes'
    """
    claim(system, name, "constraint")
    if not isinstance(points, Iterable):
        raise ModelError(f"Expected a list of points for rope '{name}', got {shown(points)}.")
    places = tuple(own_point(system, point, f"rope '{name}'") for point in points)
    if len(places) < 2:
        raise ModelError(f"Rope '{name}' needs at least two points, got {len(places)}.")
    moving = [p for p in places if not p.body.is_ground]
    if not moving:
        raise ModelError(f"All points of rope '{name}' are on the ground, so it holds nothing.")
    one_sided = _boolean(unilateral, f"unilateral= of rope '{name}'")
    reach = fixed(system, length, f"the length of rope '{name}'", "coordinate", "speed")
    if not _boolean(taut, f"taut= of rope '{name}'"):
        if not one_sided:
            raise ModelError(
                f"Rope '{name}' may push (unilateral=False) and go slack (taut=False). Choose one of them: a rod "
                "does not go slack."
            )
        return _slack(system, name, places, reach, restitution)
    if restitution != 0:
        raise ModelError(
            f"Expected no restitution= for rope '{name}', which stays taut, got {shown(restitution)}. Only a "
            "rope that goes slack, taut=False, has a restitution."
        )
    return store(system, Rope(name, places, reach, one_sided))


def _slack(
    system: Description, name: str, places: tuple[Point, ...], length: Expression, restitution: Expression
) -> ContactPair:
    """Return the contact of a rope that may go slack: one end stays inside a sphere about the other."""
    if len(places) > 2:
        raise ModelError(
            f"Rope '{name}' runs over {len(places)} points, but a rope that goes slack (taut=False) joins two. Leave "
            "out taut=False; motion.warnings then says from what time on it would be slack."
        )
    first, last = places
    if names_of(system).depends(length, "time"):
        raise ModelError(
            f"The length of rope '{name}' depends on time, but a rope that goes slack (taut=False) has a constant "
            "length. Leave out taut=False, or give a length of parameters."
        )
    number = default_value(system, length)
    if number is not None and number <= 0:
        raise ModelError(f"Expected a length greater than 0 m for rope '{name}', got {number:g}.")
    return contact(system, name, last, Tether(first.body, first.components, length), restitution=restitution)


def rolling(
    system: Description,
    name: str,
    wheel: Any,
    *,
    radius: Expression,
    axis: Any = None,
    normal: str = "y",
    plane: Any = None,
    unilateral: bool = True,
    friction: Expression = None,
) -> Constraint:
    """Let a wheel or a sphere touch a plane fixed in the ground and roll on it without slip.

    Parameters
    ----------
    name : str
        The contact force on the wheel has the components ``name_x``, ``name_y``, ``name_z``, in ground axes.
    wheel : Body (its origin) or Point
        The centre of the wheel.
    radius : expression [m]
    axis : 'x', 'y', 'z' or three components, optional
        The wheel's axle in its body's axes; the rim is a circle at right angles to it. None for a sphere.
    normal : 'x', 'y', 'z', '-x', '-y' or '-z'
        Ground axis at right angles to the plane, pointing from the plane to the wheel.
    plane : Point of the ground, optional
        A point of the plane; by default the ground's origin.
    unilateral : bool
        True if the plane only presses on the wheel; a motion in which it would have to pull reports it in
        ``motion.warnings``. False: a wheel that rails, or weight elsewhere, hold down.
    friction : expression of parameters, optional
        Coefficient of static friction; a motion that needs more reports it in ``motion.warnings``. By default friction
        is unlimited.
    """
    what = f"rolling '{name}'"
    claim(system, name, "constraint")
    center = own_point(system, wheel, what)
    if center.body.is_ground:
        raise ModelError(f"The wheel of {what} is the ground. Name the body that rolls.")
    base = system.ground.origin if plane is None else own_point(system, plane, what)
    if not base.body.is_ground:
        raise ModelError(f"The plane of {what} must be fixed in the ground, got a {base!r}.")
    sign, letter = (-1, str(normal)[1:]) if str(normal).startswith("-") else (1, str(normal))
    if letter not in ("x", "y", "z"):
        raise ModelError(
            f"Expected 'x', 'y' or 'z', with or without a minus, for the normal of {what}, got {shown(normal)}."
        )
    size = fixed(system, radius, f"the radius of {what}", "coordinate", "speed", "time")
    if not isinstance(size, sympy.Basic) and size <= 0:
        raise ModelError(f"Expected a radius greater than 0 m for {what}, got {shown(radius)}.")
    one_sided = _boolean(unilateral, f"unilateral= of {what}")
    if friction is not None:
        friction = coefficient(system, friction, f"the friction of {what}")
        if not one_sided:
            raise ModelError(
                f"The friction of {what} is bounded by the force that presses the wheel on its plane, but "
                "unilateral=False allows any such force. Leave out one of them."
            )
    k = "xyz".index(letter)
    i, j = (k + 1) % 3, (k + 2) % 3
    up = tuple(sign * c for c in UNIT[letter])
    return store(
        system,
        Rolling(
            name,
            center,
            None if axis is None else direction(system, axis, f"the axis of {what}"),
            size,
            base,
            (letter, up),
            ("xyz"[i], UNIT["xyz"[i]]),
            ("xyz"[j], UNIT["xyz"[j]]),
            axis,
            one_sided,
            friction,
        ),
    )


def _boolean(value: Any, what: str) -> bool:
    if not isinstance(value, bool):
        raise ModelError(f"Expected True or False for {what}, got {shown(value)}.")
    return value


def _named(system: Description, condition: Any, name: str | None, what: str) -> tuple[str, Any]:
    """Return the name of a condition, by default a number, and its expression, which stays zero."""
    name = f"constraint_{len(system.constraints) + 1}" if name is None else name
    claim(system, name, "constraint")
    if isinstance(condition, sympy.Equality):
        condition = condition.lhs - condition.rhs
    if isinstance(condition, str) and condition.count("=") == 1:
        left, right = condition.split("=")
        condition = f"({left}) - ({right})"
    expression = system.expression(condition, f"{what} '{name}'")
    return name, sympy.sympify(expression)
