"""Dry friction in a joint: a force along its displacement y, whatever presses the joint.

|T| ≤ F_s in stick, y' = 0;      T = -F sign(y') in slip
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ...errors import ModelError, shown
from ...scalar.algebra import Expression, Scalar
from ..description import Description
from ..joints.joint import Joint
from ..loads.action import Action, JointForce
from ..loads.displacement import check_displacement
from ..part import add
from .gap import Gap


class JointFriction(Gap, kind="joint_friction"):
    """Friction along a displacement of a joint, up to ``friction``, while it sticks up to ``static_friction``."""

    joint: Joint
    index: int = 0

    noun = "friction"
    words = {"index": "coordinate"}
    held = True

    def check(self) -> None:
        """Refuse a joint without such a displacement."""
        check_displacement(self.joint, self.index, self.title)
        super().check()

    def gap(self, at: Any) -> Scalar:
        """Return 0: it is closed always."""
        return 0

    def normal(self, at: Any) -> Iterator[Action]:
        """Yield nothing: no force of the machine presses it."""
        yield from ()

    def tangents(self, at: Any) -> Sequence[Sequence[Action]]:
        """Return the force along the joint."""
        return ((JointForce(self.joint, 1, self.index),),)


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
) -> Gap:
    """Let a joint have dry friction: it sticks exactly, and slips against a force or torque.

    Parameters
    ----------
    name : str
        The friction on the joint is ``T_name``.
    joint : Joint
    torque : expression [N m]
        Of a joint that turns; it may depend on the speed of the slip by the name ``slip``, and on the state:
        ``"T + (T_s - T)*exp(-slip/w)"``.
    force : expression [N]
        Of a joint that slides.
    static : expression, optional
        The greatest force or torque while the joint sticks, if it is greater than that of slip.
    coordinate : int, optional
        Which displacement, of a joint that has several.

    Raises
    ------
    ModelError
        A joint without such a displacement, a force of a joint that turns, a coefficient of friction.

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
    if coefficient is not None:
        raise ModelError(
            f"{title.capitalize()} has a coefficient, but the load of a joint depends on its own friction and on how "
            f"its bearings share it, which the machine does not say. Give torque= or force=; a bearing that is a shape "
            f"in a shape is a contact, s.contact."
        )
    if not isinstance(joint, Joint):
        raise ModelError(f"Expected a joint for {title}, got {shown(joint)}.")
    check_displacement(joint, coordinate, title)
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
