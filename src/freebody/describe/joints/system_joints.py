"""Methods of System that make joints: hinge, slider, cylindrical, screw, universal, ball, gimbal, planar, free, weld.

All take ``name, parent, child``, the point ``at`` on the parent and ``to`` on the child (components in
the axes of each body, from its origin), and ``parent_axes`` / ``child_axes`` (rotation matrices whose
columns are the joint axes) if the joint's axes are not parallel to the body's. With all coordinates
zero the joint axes on both bodies coincide.
"""

from __future__ import annotations

from typing import Any

import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import Expression, cross
from ..axes import UNIT, direction
from ..description import Description, claim, varying
from ..frame import Frame, closes_loop
from .ball import Ball
from .free import Free
from .hinge import Hinge
from .joining import Ends, add_joint, components_of, own_coordinates, whole
from .joint import Joint
from .rotor import Rotor
from .screw import Screw
from .slider import Slider
from .weld import Weld


@whole
def hinge(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: Any = "z",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Expression = 0, rotor: Rotor | None = None,
) -> Joint:  # fmt: skip
    """Add a hinge: one turn about ``axis`` by the angle ``coordinate`` [rad].

    Parameters
    ----------
    name : str
    parent, child : Frame
    at, to : three components or Point, optional
        The joint's point on the parent and on the child; by default their origins.
    axis : 'x', 'y', 'z' or three components
        Direction in joint axes; its length does not matter.
    parent_axes, child_axes : Rotation or 3 x 3 matrix, optional
    coordinate : str or expression, optional
        A new name, or an expression of declared coordinates and time; by default the joint's name.
    armature : expression, optional
        Inertia that the joint's speed alone moves, ½ A θ'² of the kinetic energy [kg m²], as in MuJoCo.
    rotor : Rotor, optional
        Rotor of a motor in the parent, behind a gear: reflected inertia, and the gyroscopic moments of its spin.

    Raises
    ------
    ModelError
        A body of another system, a name in use, an axis of length zero, two components instead of three.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("driven crank")
    >>> omega = s.parameters(omega=3.0)
    >>> crank = s.body("crank", fb.slender_bar(1, 2))
    >>> s.hinge("shaft", s.ground, crank, axis="z", coordinate=omega * s.t)
    hinge 'shaft' (ground -> crank)
    """
    n = direction(system, axis, f"the axis of hinge '{name}'")
    (angle,) = own_coordinates(system, child, name, coordinate, [name])
    return add_joint(system, "hinge", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Hinge(n, angle)], {"axis": axis, "coordinate": coordinate}, armature, rotor)  # fmt: skip


@whole
def slider(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: Any = "x",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Expression = 0, rotor: Rotor | None = None,
) -> Joint:  # fmt: skip
    """Add a slider: one displacement ``coordinate`` [m] along ``axis``, without turning. Arguments as :meth:`hinge`."""
    n = direction(system, axis, f"the axis of slider '{name}'")
    (slide,) = own_coordinates(system, child, name, coordinate, [name])
    return add_joint(system, "slider", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Slider(n, slide)], {"axis": axis, "coordinate": coordinate}, armature, rotor)  # fmt: skip


@whole
def cylindrical(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: Any = "z",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add a displacement along ``axis`` and a turn about it; ``coordinate`` is (displacement, angle)."""
    n = direction(system, axis, f"the axis of cylindrical joint '{name}'")
    slide, turn = own_coordinates(system, child, name, coordinate, [f"{name}_slide", f"{name}_turn"])
    return add_joint(system, "cylindrical", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Slider(n, slide), Hinge(n, turn)],
                {"axis": axis, "coordinate": coordinate}, armature)  # fmt: skip


@whole
def screw(
    system: Description, name: str, parent: Frame, child: Frame, *, pitch: Expression, at: Any = None, to: Any = None,
    axis: Any = "z", parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Expression = 0, rotor: Rotor | None = None,
) -> Joint:  # fmt: skip
    """Add a turn by ``coordinate`` [rad] about ``axis`` that advances ``pitch`` [m] per radian along it."""
    n = direction(system, axis, f"the axis of screw '{name}'")
    (turn,) = own_coordinates(system, child, name, coordinate, [name])
    advance = system.expression(pitch, f"the pitch of screw '{name}'")
    moving = varying(system, advance)
    if moving:
        raise ModelError(
            f"The pitch of screw '{name}' must be constant, but it depends on {', '.join(moving)}."
        )
    return add_joint(system, "screw", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Screw(n, turn, pitch=advance)],
                {"axis": axis, "coordinate": coordinate, "pitch": pitch}, armature, rotor)  # fmt: skip


@whole
def universal(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None,
    axis: Any = ("x", "y"), parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add two turns: about the first ``axis``, fixed in the parent, then about the second, fixed in the child."""
    if isinstance(axis, str) or not hasattr(axis, "__len__") or len(axis) != 2:
        raise ModelError(
            f"Expected two axes, such as ('x', 'y'), for universal joint '{name}', got {shown(axis)}."
        )
    axes = [direction(system, part, f"the axis of universal joint '{name}'") for part in axis]
    if all(sympy.sympify(component) == 0 for component in cross(*axes)):
        raise ModelError(
            f"The two axes of universal joint '{name}' are parallel: {shown(axis)}. Give two directions, or make a "
            "hinge."
        )
    angles = own_coordinates(system, child, name, coordinate, [f"{name}_1", f"{name}_2"])
    return add_joint(system, "universal", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Hinge(n, angle) for n, angle in zip(axes, angles, strict=True)],
                {"axis": axis, "coordinate": coordinate}, armature)  # fmt: skip


@whole
def gimbal(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: str = "ZXZ",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add all turns about a point, by three Euler angles in the body-fixed sequence ``axis``, such as "ZXZ"."""
    if not isinstance(axis, str) or len(axis) != 3:
        raise ModelError(
            f"Expected a sequence of three axes, such as 'ZXZ', for gimbal '{name}', got {shown(axis)}."
        )
    if axis.islower():
        raise ModelError(
            f"Gimbal '{name}': lower case '{axis}' means space-fixed axes in SciPy. freebody's sequences are "
            f"body-fixed and in capitals: '{axis[::-1].upper()}' with the angles in reverse order is the same."
        )
    if any(letter not in "XYZ" for letter in axis) or axis[0] == axis[1] or axis[1] == axis[2]:
        raise ModelError(
            f"Gimbal '{name}': '{axis}' is not an Euler sequence; use three of X, Y, Z with neighbours different."
        )
    angles = own_coordinates(system, child, name, coordinate, [f"{name}_1", f"{name}_2", f"{name}_3"])
    return add_joint(system, "gimbal", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Hinge(UNIT[letter.lower()], angle) for letter, angle in zip(axis, angles, strict=True)],
                {"axis": axis, "coordinate": coordinate}, armature)  # fmt: skip


@whole
def planar(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None, axis: Any = "z",
    parent_axes: Any = None, child_axes: Any = None, coordinate: Any = None,
    armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add motion in the plane normal to ``axis``: two displacements and a turn, (x, y, angle) for axis z.

    For axis x the displacements are along y and z, for axis y along z and x. Use ``parent_axes`` for
    any other normal.
    """
    order = {"x": "yz", "y": "zx", "z": "xy"}
    if not isinstance(axis, str) or axis not in order:
        raise ModelError(
            f"Expected 'x', 'y' or 'z' for the normal of planar joint '{name}', got {shown(axis)}. "
            f"Turn the joint by parent_axes for another plane."
        )
    first, second = order[axis][0], order[axis][1]
    a, b, turn = own_coordinates(
        system, child, name, coordinate, [f"{name}_{first}", f"{name}_{second}", f"{name}_turn"]
    )
    return add_joint(system, "planar", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Slider(UNIT[first], a), Slider(UNIT[second], b),
                 Hinge(UNIT[axis], turn)],
                {"axis": axis, "coordinate": coordinate}, armature)  # fmt: skip


@whole
def ball(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None,
    parent_axes: Any = None, child_axes: Any = None, coordinate: str | None = None, armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add all turns about a point, by a unit quaternion; no attitude is singular.

    Coordinates ``NAME_e0 … NAME_e3`` (scalar first), speeds ``NAME_wx, NAME_wy, NAME_wz``: the angular
    velocity of the child in the parent, components in the child's joint axes. ``coordinate`` replaces NAME.
    """
    claim(system, name, "joint")
    q: list[Any] = []
    if not closes_loop(system, child):
        q = components_of(
            system, name if coordinate is None else coordinate, ["e0", "e1", "e2", "e3"], "coordinate"
        )
        components_of(system, name if coordinate is None else coordinate, ["wx", "wy", "wz"], "speed")
    return add_joint(system, "ball", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Ball(coordinate=tuple(q))], {"coordinate": coordinate}, armature)  # fmt: skip


@whole
def free(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None,
    parent_axes: Any = None, child_axes: Any = None, coordinate: str | None = None, armature: Any = 0,
) -> Joint:  # fmt: skip
    """Add six degrees of freedom.

    Coordinates ``NAME_x, NAME_y, NAME_z`` (position of ``to`` from ``at``, in the parent's joint axes) and the unit
    quaternion ``NAME_e0 … NAME_e3``; speeds ``NAME_wx …`` and ``NAME_vx …``: angular velocity of the child
    and velocity of the point ``to``, both relative to the parent and in the child's joint axes.
    """
    claim(system, name, "joint")
    if closes_loop(system, child):
        raise ModelError(
            f"Free joint '{name}' has no effect, since another joint already holds '{getattr(child, 'name', child)}'. "
            f"Leave it out."
        )
    prefix = name if coordinate is None else coordinate
    q = components_of(system, prefix, ["x", "y", "z", "e0", "e1", "e2", "e3"], "coordinate")
    components_of(system, prefix, ["wx", "wy", "wz", "vx", "vy", "vz"], "speed")
    return add_joint(system, "free", name, Ends(parent, child, at, to, parent_axes, child_axes),
                [Free(coordinate=tuple(q))], {"coordinate": coordinate}, armature)  # fmt: skip


@whole
def weld(
    system: Description, name: str, parent: Frame, child: Frame, *, at: Any = None, to: Any = None,
    parent_axes: Any = None, child_axes: Any = None,
) -> Joint:  # fmt: skip
    """Fix the child to the parent; the joint's reaction has all six components."""
    return add_joint(system, "weld", name, Ends(parent, child, at, to, parent_axes, child_axes), [Weld()], {})
