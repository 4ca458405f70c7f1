"""Inertia that turns with a joint's displacement: the rotor of a motor behind a gear, and plain armature.

The rotor, of moment of inertia J about its axis n in the parent, turns at the rate G y' relative to the parent, where y
is the joint's displacement and G the ratio of the gear. At rest in the parent it is part of the parent's mass. Its
turning adds to the kinetic energy

    T = J G y' n·w_P + ½ J G² y'²,

reflected inertia J G² and the gyroscopic moments of its spin. Armature A adds ½ A y'² alone.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), §9.6; MuJoCo, XML reference, joint/armature.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

from ...errors import ModelError, shown
from ...scalar.algebra import Expression
from ..axes import direction
from ..constants import unchanging
from ..description import Description
from ..frame import closes_loop


@dataclass(frozen=True)
class Rotor:
    """The rotor of a motor, which a joint turns through a gear; it stands in the parent of the joint.

    The mass of the rotor, and its moment of inertia at rest, belong to the parent's mass properties, as drawings and
    robot files give them. The rotor adds what its turning adds: the reflected inertia J G², and the moment with which
    its spin acts on the parent.

    Parameters
    ----------
    inertia : expression
        J, moment of inertia about the rotor's axis [kg m²].
    ratio : expression
        G, turns of the rotor relative to the parent per turn of the joint; on a slider, radians per metre [rad/m].
    axis : 'x', 'y', 'z' or three components, optional
        Axis of the rotor in the joint's axes on the parent; by default that of the joint.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("arm")
    >>> m, L, J, n = s.parameters(m=1.0, L=0.5, J=1e-5, n=100)
    >>> arm = s.body("arm", fb.slender_bar(m, L, axis="x"))
    >>> pin = s.hinge("pin", s.ground, arm, to=(-L / 2, 0, 0), coordinate="q", rotor=fb.Rotor(J, ratio=n))
    >>> print(fb.equations(s).text())
    (m*L^2/3 + J*n^2)*q'' = 0
    """

    inertia: Expression
    ratio: Expression = 1
    axis: Any = None


def with_inertia(system: Description, joint: Any, motions: Sequence[Any]) -> list[Any]:
    """Return the primitive motions of a joint with its armature and rotor, checked."""
    what, armature, rotor = joint.title, joint.armature, joint.rotor
    some = armature is not None and armature != 0
    if closes_loop(system, joint.child) and (rotor is not None or some):
        raise ModelError(
            f"{joint.heading} closes a loop and has no displacement of its own, so it takes no "
            f"armature= or rotor=. Give it to a joint of the tree, or declare this joint before the one that is to "
            f"close the loop."
        )
    result = list(motions)
    if some:
        result = [
            replace(p, armature=a) for p, a in zip(result, _each(system, what, result, armature), strict=True)
        ]
    if rotor is not None:
        result = [replace(result[0], rotor=own_rotor(system, what, rotor, result))]
    return result


def _each(
    system: Description, what: str, primitives: Sequence[Any], armature: Any
) -> Iterator[tuple[Any, ...]]:
    """Yield the armature of each motion of each primitive: one number for all, or one for each displacement."""
    counts = [1 if p.displaces else p.n_speeds // 3 for p in primitives]
    count = sum(counts)
    if not count or any(p.armature for p in primitives):
        why = "has no motion" if not count else "has motions with armature of their own"
        raise ModelError(f"{what[0].upper()}{what[1:]} {why} and takes no armature=. Leave it out.")
    several = list(armature) if isinstance(armature, list | tuple) else [armature] * count
    if len(several) != count:
        sort = (
            "one for its turning and one for its sliding" if counts == [2] else f"{count}, one a displacement"
        )
        raise ModelError(f"Expected one armature for {what}, or {sort}, got {shown(armature)}.")
    values = iter([constant(system, value, f"the armature of {what}") for value in several])
    for p in primitives:
        yield (
            (next(values),)
            if p.displaces
            else tuple(value for value in islice(values, p.n_speeds // 3) for _ in range(3))
        )


def own_rotor(system: Description, what: str, rotor: Any, primitives: Sequence[Any]) -> Rotor:
    """Return a rotor in the system's own terms, on a joint with these primitive motions."""
    if not isinstance(rotor, Rotor):
        raise ModelError(f"Expected a rotor for {what}, such as fb.Rotor(J, ratio=100), got {shown(rotor)}.")
    check_single(what, primitives)
    axis = None if rotor.axis is None else direction(system, rotor.axis, f"the axis of the rotor of {what}")
    inertia = constant(system, rotor.inertia, f"the inertia of the rotor of {what}")
    return Rotor(
        inertia, constant(system, rotor.ratio, f"the ratio of the gear of {what}", any_sign=True), axis
    )


def check_single(what: str, primitives: Sequence[Any]) -> None:
    """Refuse a rotor on a joint with more than one displacement, or none."""
    if len(primitives) != 1 or not primitives[0].displaces:
        raise ModelError(
            f"The rotor of {what} turns with a single displacement, and the joint does not have just one. Put the "
            f"motor on a hinge, a slider or a screw; several of these in a row, with bodies between them, make any "
            f"joint."
        )


def constant(system: Description, value: Any, what: str, *, any_sign: bool = False) -> Any:
    """Return a constant expression; a number below zero is refused unless it may have any sign."""
    cure = "A clutch or a gear that changes is a run for each of its states."
    expression = unchanging(system, value, what, cure)
    number = getattr(expression, "is_number", not hasattr(expression, "free_symbols"))
    if number and expression < 0 and not any_sign:
        raise ModelError(f"Expected a number of at least zero for {what}, got {shown(value)}.")
    return expression
