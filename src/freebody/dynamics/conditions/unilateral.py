"""One-sided constraints and the limits of their forces.

    rope          S ≥ 0                 it only pulls
    rolling       N ≥ 0                 the plane only presses
                  μ N - |T| ≥ 0         if it has a coefficient of friction
    condition     λ ≥ 0                 of φ ≥ 0, if it is unilateral

A motion treats the constraint as an equation, two-sided. Once the force passes its limit, the motion is no longer
physical. A limit that is met exactly is not passed: forces are sums, and a sum of parts that balance is zero up to
round-off, so that each limit is compared with the size of the parts,

    s = (Σ |(G M⁻¹)ₖ fₖ| + |γ|) / (G M⁻¹ Gᵀ)      of   (G M⁻¹ Gᵀ) λ = -γ - G M⁻¹ f   row by row.

Source: Pfeiffer & Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 5.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from ...describe.constraints.constraint import Condition, Rolling, Rope
from ...model.model import Model
from ...scalar.algebra import Expression, Scalar, divide
from ..composite import mass_matrix
from ..linear import Factorization
from ..newton_euler import bias
from ..state import State
from .constraints import rows
from .linearized import linearized

NEGLIGIBLE = Fraction(1, 10**6)
"""Fraction of the forces that balance in a constraint below which their sum counts as zero."""


@dataclass(frozen=True)
class MotionWarning:
    """A part of a motion that is not physical. One of ``motion.warnings``.

    Attributes
    ----------
    name : str
        Name of the rope, rolling wheel or condition.
    event : str
        Name of the events at which such parts begin.
    time : float
        Time from which the motion is not physical [s].
    what : str
        What happens in the motion but cannot happen in reality.
    value : float
        The worst value: the least force, or the least margin of friction, in ``unit``; for a blow the impulse.
    spans : tuple of (float, float)
        All such parts of the run: from, to [s].
    law, cure : str
        What can happen in reality, and what to do about it.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("stone on a string")
    >>> s.gravity = (0, -9.81, 0)
    >>> stone = s.body("stone", fb.sphere(1, 0.05))
    >>> fly = s.planar("fly", s.ground, stone, coordinate="x y turn")
    >>> string = s.rope([s.ground.origin, stone.origin], 1, name="string")
    >>> motion = fb.simulate(s, 1, initial={"x": 0, "y": -1, "x'": "sqrt(3*9.81)"})
    >>> for warning in motion.warnings:
    ...     print(f"{warning.time:.4f} s: {warning.what}, {warning.value:.3f} {warning.unit}")
    0.4822 s: the rope pushes, -4.905 N
    """

    name: str
    event: str
    time: float
    what: str
    value: float
    spans: tuple[tuple[float, float], ...]
    law: str
    cure: str
    unit: str = "N"

    def __str__(self) -> str:
        parts = [f"{a:.6g} to {b:.6g} s" if a != b else f"t = {a:.6g} s" for a, b in self.spans[:3]]
        more = len(self.spans) - len(parts)
        when = " and ".join(parts) + (f" and {more} more times" if more else "")
        return (
            f"{self.name}: {self.what}, {self.value:.6g} {self.unit}".rstrip()
            + f" at worst ({when}). {self.law}: from t = {self.time:.6g} s on this motion is not physical. {self.cure}"
        )


@dataclass(frozen=True)
class Limit:
    """A limit of a constraint's force.

    Attributes
    ----------
    constraint : str
        The constraint as the user named it.
    event : str
        Name of the event at which the force passes the limit.
    places : tuple of int
        Indices of the multipliers: the force, then the friction that it bounds.
    friction : expression or None
        Coefficient of that friction.
    what, law, cure : str
        What the constraint then does, what it can do in reality, and what to do about it.
    unit : str
        Unit of the force; empty if it depends on the expression of a condition.
    """

    constraint: str
    event: str
    places: tuple[int, ...]
    friction: Expression
    what: str
    law: str
    cure: str
    unit: str = "N"

    def passed(self, value: float, spans: tuple[tuple[float, float], ...], per: str = "") -> MotionWarning:
        """Return the warning for a motion that passes it; an impulse has the unit of the force times ``per``."""
        unit = f"{self.unit} {per}".strip() if self.unit else ""
        return MotionWarning(
            self.constraint, self.event, spans[0][0], self.what, value, spans, self.law, self.cure, unit
        )


def limits(model: Model) -> tuple[Limit, ...]:
    """Return the limits of all one-sided constraints, in order of declaration."""
    first = {row.owner: i for i, row in reversed([*enumerate(rows(model))])}
    result = []
    for name, constraint in model.constraints.items():
        if isinstance(constraint, Rope) and constraint.unilateral:
            cure = "From then on it is slack: describe what follows without it."
            if len(constraint.points) == 2:
                cure = "Let it go slack by taut=False; a light rod, which may push, is unilateral=False."
            result.append(
                Limit(
                    name, f"{name} slack", (first[name],), None, "the rope pushes", "A rope only pulls", cure
                )
            )
        elif isinstance(constraint, Rolling):
            k, body = first[name], constraint.center.body.name
            shape = "sphere(radius)" if constraint.axis is None else "circle(radius, axis=...)"
            contact = f"s.contact(name, s.bodies['{body}'].{shape}, s.ground.plane(...), friction=...)"
            if constraint.unilateral:
                result.append(
                    Limit(
                        name, f"{name} lifts off", (k,), None, "the plane pulls the wheel",
                        "A plane only presses on a wheel",
                        f"A wheel that may lift off is a contact, {contact}; "
                        "one that is held down is unilateral=False.",
                    )
                )  # fmt: skip
            if constraint.friction is not None:
                result.append(
                    Limit(
                        name, f"{name} slips", (k, k + 1, k + 2), constraint.friction,
                        "rolling asks for more than friction gives", "Friction holds a wheel up to mu N",
                        f"A wheel that may slip is a contact, {contact}.",
                    )
                )  # fmt: skip
        elif isinstance(constraint, Condition) and constraint.unilateral:
            result.append(
                Limit(
                    name, f"{name} leaves", (first[name],), None, "the groove pulls",
                    "A groove that is open on one side only presses",
                    "What may leave it is a contact, such as s.contact(name, body.origin, s.ground.heightline(...)); "
                    "on a wire leave out unilateral=True.", "",
                )
            )  # fmt: skip
    return tuple(result)


def margins(model: Model, state: State, multipliers: Sequence[Scalar]) -> list[Scalar]:
    """Return the margin of each limit at these multipliers: the force, or μ N - |T|; negative if it is passed."""
    result = []
    for limit in limits(model):
        force, *friction = (multipliers[i] for i in limit.places)
        if friction:
            a, b = friction
            force = state(limit.friction) * force - state.field.sqrt(a * a + b * b)
        result.append(force)
    return result


def sizes(model: Model, state: State, active: Sequence[int]) -> list[Scalar]:
    """Return, for each limit, the size of the parts of which its forces are sums."""
    all_limits = limits(model)
    size = multiplier_sizes(model, state, {i for limit in all_limits for i in limit.places if i in active})
    result = []
    for limit in all_limits:
        total, *friction = (size.get(i, 0) for i in limit.places)
        if limit.friction is not None:
            total = state(limit.friction) * total
        for x in friction:
            total = total + x
        result.append(total)
    return result


def multiplier_sizes(model: Model, state: State, places: Iterable[int]) -> dict[int, Scalar]:
    """Return the size of the parts of the multiplier of some conditions, each as if it were the only condition:

    λ_i = -(γ_i + Σ_j w_j f_j)/(G M⁻¹ Gᵀ)_ii,      of which |γ_i| and all |w_j f_j| are summed
    """
    conditions, M = linearized(model, state), Factorization(mass_matrix(model, state))
    free = M.forward([-x for x in bias(model, state)])
    size: dict[int, Scalar] = {}
    for i in places:
        row = M.forward(conditions.matrix[i])
        weighed = M.divided(row)
        total = _absolute(state, conditions.bias[i])
        for a, b in zip(weighed, free, strict=True):
            total = total + _absolute(state, a * b)
        square: Scalar = 0
        for a, b in zip(weighed, row, strict=True):
            square = square + a * b
        size[i] = divide(total, square)
    return size


def passed_by_impulse(
    model: Model,
    multipliers: Sequence[float | None],
    friction: Callable[[Expression], float | None],
    largest: float,
    t: float,
) -> tuple[MotionWarning, ...]:
    """Return the warnings for impulses of the constraints at an instant.

    Parameters
    ----------
    multipliers : sequence of float or None
        Impulses of all conditions; conditions with an unknown impulse, None, give no warning.
    friction : function
        Returns the value of a coefficient, or None if it has none.
    largest : float
        The largest impulse of all, including those from outside.
    """
    result = []
    for limit in limits(model):
        forces = [x for x in (multipliers[i] for i in limit.places) if x is not None]
        mu = 1 if limit.friction is None else friction(limit.friction)
        if mu is None or len(forces) < len(limit.places):
            continue
        margin = mu * forces[0] - math.hypot(*forces[1:])
        if margin < -NEGLIGIBLE * largest:
            result.append(limit.passed(margin, ((t, t),), "s"))
    return tuple(result)


def _absolute(state: State, x: Scalar) -> Scalar:
    return state.field.apply("abs", x) if not isinstance(x, int | Fraction) else abs(x)
