"""Impacts on compliant surfaces: how long they last, how deep they go, and how fast bodies rebound.

A mass m meets a surface with the speed v, and only the normal force N(d, d') acts on it while N > 0 and d > 0.

Sources: W. Goldsmith, Impact (1960), chapter 4 (Hertz); K. Hunt, F. Crossley, J. Appl. Mech. 42 (1975) 440-445.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from .elementary import arctan2, exp, log, sqrt


@dataclass(frozen=True)
class CompliantImpact:
    """Duration [s] and greatest depth [m] of an impact, and ratio of the speeds after and before it."""

    duration: Any
    depth: Any
    restitution: Any


def elastic_impact(m: Any, k: Any, v: Any, n: float = 1.5) -> CompliantImpact:
    """Impact under N = k dⁿ, Hertz's law for n = 3/2, which keeps the energy.

        m v²/2 = k d₁ⁿ⁺¹/(n + 1),      T = 2 ∫₀ᵈ¹ dd/√(v² - …) = 2 (d₁/v) √π Γ(1 + 1/(n + 1))/Γ(1/2 + 1/(n + 1))

    For n = 3/2 the duration is 2.94 d₁/v.

    Examples
    --------
    >>> impact = elastic_impact(1.0, 1.0, 1.0)
    >>> round(float(impact.duration / impact.depth), 4)
    2.9433
    """
    p = 1 / (n + 1)
    depth = ((n + 1) * m * v**2 / (2 * k)) ** p
    shape = 2 * math.sqrt(math.pi) * math.gamma(1 + p) / math.gamma(p + 1 / 2)
    return CompliantImpact(shape * depth / v, depth, 1)


def damped_impact(m: Any, k: Any, c: Any, v: Any) -> CompliantImpact:
    """Impact under N = k d + c d' > 0, a spring and a damper that only press (c² < 4 k m).

    With ω² = k/m, ζ = c/(2 √(k m)) and ω₁ = ω √(1 - ζ²), d = (v/ω₁) exp(-ζ ω t) sin ω₁t, and N = 0 first at

        ω₁ T = π - atan2(2 ζ √(1 - ζ²), 1 - 2 ζ²),      where d' = -v exp(-ζ ω T)

    before the surface has its shape again.

    Examples
    --------
    >>> float(damped_impact(1.0, 100.0, 0.0, 2.0).restitution)
    1.0
    """
    w, z = sqrt(k / m), c / (2 * sqrt(k * m))
    root = sqrt(1 - z**2)
    T = (math.pi - arctan2(2 * z * root, 1 - 2 * z**2)) / (w * root)
    deepest = arctan2(root, z) / (w * root)
    return CompliantImpact(T, v / w * exp(-z * w * deepest), exp(-z * w * T))


def hunt_crossley_restitution(c: Any, v: Any) -> Any:
    """Ratio of speeds e under N = k dⁿ (1 + c d'), whatever m, k and n are.

        v dv/dd = -(k/m) dⁿ (1 + c v)      =>      c v - ln(1 + c v) = -c e v - ln(1 - c e v)

    so that 1 - c e v = -W₀(-exp(-1 - c v + ln(1 + c v))) with Lambert's W; e = 1 - 2 c v/3 for small c v.

    Examples
    --------
    >>> round(float(hunt_crossley_restitution(0.3, 0.01)), 5)
    0.998
    """
    from scipy.special import lambertw

    rest = -lambertw(-exp(-1 - c * v + log(1 + c * v))).real
    return (1 - rest) / (c * v)
