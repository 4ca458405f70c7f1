"""Joints by functions: ``s.path_joint``, whose pose is a function of one coordinate, or of two.

The pose r(q), R(q) is a chain of slides along x, y, z by r and of turns by the angles, so that every algorithm
differentiates it like any displacement: exactly, with the term r''(q) q'² of its curvature. Its motion per unit rate is
the twist Σ ∂y_i/∂q t_i (:mod:`freebody.dynamics.joints.motions`), and the joint transmits what has no power in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ...errors import ModelError, shown
from ...scalar.algebra import ZERO, apply
from ...scalar.expression import exact
from ..axes import UNIT, direction, orientation
from ..description import Description, claim, declare_coordinate, names_of, varying, vector
from ..frame import Frame, closes_loop, own_body
from ..names import is_identifier
from .hinge import Hinge
from .joining import Ends, add_joint, own_coordinates, place_on, whole
from .joint import Joint
from .primitive import Primitive
from .slider import Slider


@whole
def path_joint(
    system: Description, name: str, parent: Frame, child: Frame, *, coordinate: Any = None, position: Any = (0, 0, 0),
    turns: Sequence[tuple[Any, Any]] = (), at: Any = None, to: Any = None, parent_axes: Any = None,
    child_axes: Any = None,
) -> Joint:  # fmt: skip
    """Add a joint by functions: the pose of the child is a function of one coordinate, or of two.

    A bead on a curve, a knee, a cam, a puck on a surface. The joint is ideal: its reaction does no work in its motion.

    Parameters
    ----------
    name : str
    parent, child : Frame
    coordinate : str
        Name of the joint's coordinate, or of two, ``"u v"``; by default the joint's name.
    position : three expressions
        The child's point ``to`` from the parent's point ``at``, in joint axes on the parent [m].
    turns : sequence of (axis, angle)
        Turns of the child in this order, each about an axis that the earlier ones carry along, such as
        ``[("z", "0.9*q")]``; by default none.
    at, to, parent_axes, child_axes : optional
        As for :meth:`hinge`.

    Raises
    ------
    ModelError
        A pose that does not depend on a coordinate, that depends on speeds, or on a signal that bends; a joint that
        closes a loop.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("bead on a parabola")
    >>> m, k, g = s.parameters(m=1.0, k=0.5, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bead = s.body("bead", fb.particle(m))
    >>> s.path_joint("wire", s.ground, bead, coordinate="x", position=("x", "k*x^2", 0))
    path_joint 'wire' (ground -> bead)
    >>> print(fb.equations(s).text())
    m*(1 + 4*k^2*x^2)*x'' + 4*m*k^2*x*x'^2 + 2*m*k*g*x = 0
    """
    what = f"path joint '{name}'"
    claim(system, name, "joint")
    if closes_loop(system, child):
        raise ModelError(
            f"Path joint '{name}' closes a loop, which joints of this type cannot. Open the loop elsewhere: declare "
            f"this joint before the one that closes it."
        )
    coordinates = _declared(system, name if coordinate is None else coordinate, what)
    components = vector(system, position, f"the position of {what}")
    still = [0 if varying(system, x) else x for x in components]
    moving = [(UNIT["xyz"[k]], x) for k, x in enumerate(components) if varying(system, x)]
    parts: list[Primitive] = [
        Slider(axis, own_coordinates(system, None, name, [x], [name])[0], at=ZERO) for axis, x in moving
    ]
    parts += [_turn(system, name, turn, k) for k, turn in enumerate(_listed(turns, what), start=1)]
    for text in coordinates:
        if not any(text in names_of(system).depends(part.coordinate, "coordinate") for part in parts):
            raise ModelError(
                f"The pose of {what} does not depend on its coordinate '{text}'. Give position= or turns= with it, "
                f"such as position=('{text}', '{text}^2', 0)."
            )
    place = place_on(system, at, own_body(system, parent, what), f"at= of {what}")
    shift = apply(orientation(system, parent_axes, f"parent_axes= of {what}"), (still[0], still[1], still[2]))
    x, y, z = (exact(a + b) for a, b in zip(place, shift, strict=True))
    ends = Ends(parent, child, (x, y, z), to, parent_axes, child_axes)
    given = {
        "at": place, "coordinates": tuple(coordinates), "position": components,
        "turns": tuple((part.axis, part.coordinate) for part in parts if part.turns),
    }  # fmt: skip
    joint = replace(add_joint(system, "path_joint", name, ends, parts, given), path=True)
    system.joints[name] = joint
    return joint


def _declared(system: Description, coordinate: Any, what: str) -> list[str]:
    """The names of the coordinates, declared if they are new."""
    texts = coordinate.replace(",", " ").split() if isinstance(coordinate, str) else []
    if len(texts) not in (1, 2) or not all(map(is_identifier, texts)):
        raise ModelError(
            f"Expected the name of a coordinate, or of two, for {what}, such as 'q', got {shown(coordinate)}."
        )
    for text in texts:
        if names_of(system).kinds.get(text) != "coordinate":
            declare_coordinate(system, text)
    return texts


def _listed(turns: Any, what: str) -> list[Any]:
    """The turns, pairs of an axis and an angle."""
    result = [] if isinstance(turns, str) or not hasattr(turns, "__iter__") else list(turns)
    pairs = all(not isinstance(turn, str) and hasattr(turn, "__len__") and len(turn) == 2 for turn in result)
    if not pairs or (not result and turns not in ((), [])):
        raise ModelError(
            f"Expected turns such as [('z', 'q')], axis and angle, for {what}, got {shown(turns)}."
        )
    return result


def _turn(system: Description, name: str, turn: Any, k: int) -> Primitive:
    """The hinge of one turn."""
    axis = direction(system, turn[0], f"the axis of turn {k} of path joint '{name}'")
    angle = system.expression(turn[1], f"the angle of turn {k} of path joint '{name}'")
    return Hinge(axis, own_coordinates(system, None, name, [angle], [name])[0], at=ZERO)
