"""Surfaces that rub unequally, adhere, or resist rolling: closed forms of blocks, beads and balls.

    unequal friction    T = -(μ_1² d_1, μ_2² d_2) N/√(μ_1² d_1² + μ_2² d_2²) of a slip along d
    adhesion            N >= -A
    rolling, spinning   a moment of at most δ N resists; a ball that rolls has I = 2/5 m R² about its centre

Every formula is derived here.
"""

from __future__ import annotations

from dataclasses import dataclass

from .elementary import cos, sin, sqrt


@dataclass(frozen=True)
class DriftingBlock:
    """Acceleration along the slip [m/s²], and the components of the direction of steepest descent, of unit length."""

    acceleration: float
    along: float
    across: float


def drifting_block(
    mu_1: float, mu_2: float, d: tuple[float, float], slope: float, g: float = 9.81
) -> DriftingBlock:
    """Return which way a slope falls on which a block slides along d from rest, with unequal friction.

    With f = cos β (μ_1² d_1, μ_2² d_2)/√(μ_1² d_1² + μ_2² d_2²), the slope β and its steepest descent e, |e| = 1,

        sin β e = (a/g) d + f      =>      (a/g)² + 2 (a/g) d·f + f·f = sin² β

    Examples
    --------
    >>> block = drifting_block(0.5, 0.5, (1.0, 0.0), 0.9, g=10.0)  # equal friction: straight down
    >>> round(block.along, 12), round(block.across, 12)
    (1.0, 0.0)
    """
    size = sqrt(mu_1**2 * d[0] ** 2 + mu_2**2 * d[1] ** 2)
    f = [cos(slope) * mu**2 * x / size for mu, x in zip((mu_1, mu_2), d, strict=True)]
    along, square = d[0] * f[0] + d[1] * f[1], f[0] ** 2 + f[1] ** 2
    a = sqrt(along**2 - square + sin(slope) ** 2) - along
    e = [(a * x + y) / sin(slope) for x, y in zip(d, f, strict=True)]
    return DriftingBlock(float(g * a), float(e[0]), float(e[1]))


def dome_exit(v: float, R: float, A: float, m: float, g: float = 9.81) -> float:
    """Return cos θ at which a bead leaves a smooth dome that it adheres to, from the speed v at the top.

    m u²/R = m g cos θ + A,  u² = v² + 2 g R (1 - cos θ)      =>      cos θ = (v² + 2 g R - A R/m)/(3 g R)

    Examples
    --------
    >>> dome_exit(0.0, 1.0, 0.0, 1.0, g=1.0) == 2 / 3
    True
    """
    return (v**2 + 2 * g * R - A * R / m) / (3 * g * R)


@dataclass(frozen=True)
class Stopping:
    """Deceleration [m/s² or rad/s²], and the time to rest [s]."""

    deceleration: float
    time: float


def rolling_ball(v: float, R: float, delta: float, g: float = 9.81) -> Stopping:
    """Return how a homogeneous ball that rolls with the speed v comes to rest by rolling resistance.

    The normal force m g acts ahead by δ. About the point of contact (2/5 + 1) m R² v'/R = -δ m g, so v' = -5/7 g δ/R.

    Examples
    --------
    >>> rolling_ball(5.0, 1.0, 0.7, g=10.0)
    Stopping(deceleration=5.0, time=1.0)
    """
    a = 5 * g * delta / (7 * R)
    return Stopping(a, v / a)


def spinning_ball(w: float, R: float, delta: float, g: float = 9.81) -> Stopping:
    """Return how a homogeneous ball that spins with w about the normal comes to rest: 2/5 m R² w' = -δ m g.

    Examples
    --------
    >>> spinning_ball(5.0, 1.0, 0.2, g=10.0)
    Stopping(deceleration=5.0, time=1.0)
    """
    a = 5 * g * delta / (2 * R**2)
    return Stopping(a, w / a)
