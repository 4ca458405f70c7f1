"""The method of a system that gives a joint dry friction: up to a force or torque, or under the load of the joint."""

from __future__ import annotations

from typing import Any

from ...errors import ModelError, shown
from ...scalar.algebra import Expression
from ..description import Description
from ..joints.joint import Joint, turns_freely
from ..loads.displacement import check_displacement
from ..part import add
from .bearing_friction import BearingFriction
from .gap import Gap
from .joint_friction import JointFriction
from .turn import ShiftFriction, TurnFriction, is_free


def friction(
    system: Description,
    name: str,
    joint: Any,
    *,
    torque: Expression = None,
    force: Expression = None,
    static: Expression = None,
    coordinate: int = 0,
    coefficient: Expression = None,
    radius: Expression = None,
    length: Expression = None,
) -> Gap:
    """Let a joint have dry friction: it sticks exactly, and slips against a force or torque, or under its load.

        |T| ≤ μ |F| of a slider,      |T| ≤ r sin φ |F|,  tan φ = μ,  of a hinge whose pin has the radius r

    with the force F of the joint across its axis; the force along the axis of a hinge has no part in it.

    Parameters
    ----------
    name : str
        The friction on the joint is ``T_name``.
    joint : Joint
    torque : expression [N m]
        Of a joint that turns; of a ball or free joint, about each of the child's joint axes. It may depend on the speed
        of the slip by the name ``slip``, and on the state: ``"T + (T_s - T)*exp(-slip/w)"``.
    force : expression [N]
        Of a joint that slides; of a free joint, along each of the parent's joint axes.
    static : expression, optional
        The greatest force or torque while the joint sticks, or coefficient, if it is greater than that of slip.
    coordinate : int, optional
        Which displacement, of a joint that has several.
    coefficient : expression
        Coefficient of friction μ under the load of a hinge or a slider, in place of ``torque`` or ``force``. It may
        depend on ``slip`` and the state as they may.
    radius : expression of parameters [m]
        Radius of the pin of a hinge, with ``coefficient``.
    length : expression of parameters [m], optional
        Distance of two places along the axis, on both sides of the joint's point, that bear the force and the moment
        across the axis, with ``coefficient``. By default one place bears the force, and a moment presses nothing.

    Raises
    ------
    ModelError
        A joint without such a displacement, a force of a joint that turns, a coefficient beside a force or for a joint
        that is no hinge and no slider, a hinge without radius.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("block on a spring")
    >>> block = s.body("block", fb.particle(1))
    >>> guide = s.slider("guide", s.ground, block, axis="x", coordinate="x")
    >>> spring = s.spring("k", guide, stiffness=100)
    >>> s.friction("dry", guide, force=2)
    friction 'dry'
    >>> motion = fb.simulate(s, 2, initial={"x": 0.11})
    >>> print(f"{motion['x'][-1]:.6f}")
    0.010000
    """
    title = f"friction '{name}'"
    if not isinstance(joint, Joint):
        raise ModelError(f"Expected a joint for {title}, got {shown(joint)}.")
    if turns_freely(joint, coordinate):
        free = is_free(joint)
        bounds = [bound for bound in (torque, force if free else None) if bound is not None]
        others = (coefficient, radius, length, *(() if free else (force,)))
        if len(bounds) != 1 or any(other is not None for other in others):
            raise ModelError(
                f"Expected torque= {'or force= ' if free else ''}alone for {title}, since {joint.type} joint "
                f"'{joint.name}' turns about all axes: its friction resists the turn about each of the child's joint "
                f"axes up to that torque"
                + (
                    ", another one its displacement along each of the parent's up to a force."
                    if free
                    else "."
                )
            )
        kind = TurnFriction if force is None else ShiftFriction
        return add(system, name, kind(joint, friction=bounds[0], static_friction=static))
    check_displacement(joint, coordinate, title)
    if coefficient is not None:
        if torque is not None or force is not None:
            raise ModelError(
                f"{title.capitalize()} has a coefficient and a {'force' if torque is None else 'torque'}. The load of "
                f"joint '{joint.name}' bounds it, or a given one: leave one out."
            )
        pressed = BearingFriction(
            joint, coordinate, radius, length, friction=coefficient, static_friction=static
        )
        return add(system, name, pressed)
    if radius is not None or length is not None:
        raise ModelError(
            f"Expected coefficient= for {title}, which has {'a radius' if radius is not None else 'a length'}: how "
            f"the joint bears its load matters where the load bounds the friction."
        )
    slides = not joint.primitives[coordinate].turns
    word, other = ("force", "torque") if slides else ("torque", "force")
    given, wrong = (force, torque) if slides else (torque, force)
    if given is None or wrong is not None:
        raise ModelError(
            f"Expected {word}= for {title}, since joint '{joint.name}' {'slides' if slides else 'turns'} there"
            + (f"; got {other}={shown(wrong)}." if wrong is not None else ".")
        )
    part = JointFriction(joint, coordinate, friction=given, static_friction=static)
    return add(system, name, part)
