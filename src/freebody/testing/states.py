"""Random states of a machine, and the values of canonical polynomials at them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from mpmath import mp

from ..model.model import Model
from ..scalar.polynomial import Polynomial


def random_state(model: Model, seed: int) -> tuple[list[float], list[float]]:
    """Return random q, with quaternions of unit length, and random u."""
    rng = np.random.default_rng(seed)
    q = rng.normal(size=model.n_q)
    for start in model.quaternions:
        q[start : start + 4] /= np.linalg.norm(q[start : start + 4])
    return [float(x) for x in q], [float(x) for x in rng.normal(size=model.n_u)]


def polynomial_value(x: Any, values: Mapping[Any, float], digits: int = 100) -> float:
    """Value of a canonical polynomial for ``values`` by SymPy atom (parameters, t, coordinates, speeds, ...).

    It is computed with many digits, since the terms of an expanded form may cancel.
    """
    generators: dict[int, Any] = {}

    def generator(ring: Any, g: Any) -> Any:
        if g.index not in generators:
            arguments = [polynomial(a) for a in g.arguments]
            if g.kind == "inverse":
                generators[g.index] = 1 / arguments[0]
            elif g.kind == "constant":
                generators[g.index] = mp.mpf(g.atom.evalf(digits))
            elif arguments:
                name = g.name or g.kind
                generators[g.index] = (_CHOICES.get(name) or getattr(mp, _MPMATH.get(name, name)))(*arguments)
            else:
                generators[g.index] = mp.mpf(values[g.atom])
        return generators[g.index]

    def polynomial(y: Any) -> Any:
        if not isinstance(y, Polynomial):
            return mp.mpf(Fraction(y).numerator) / Fraction(y).denominator
        total = mp.mpf(0)
        for monomial, coefficient in y.terms():
            term = mp.mpf(coefficient)
            for i, n in monomial:
                term *= generator(y.ring, y.ring.generators[i]) ** n
            total += term
        return total / y.den

    with mp.workdps(digits):
        return float(polynomial(x))


_MPMATH = {"abs": "fabs"}
_CHOICES: dict[str, Any] = {"max": max, "min": min}


def state_values(model: Model, q: Sequence[float], u: Sequence[float], t: float = 0) -> dict[Any, float]:
    """Values by SymPy atom: the time, the parameters at their defaults, q and u."""
    numbers = model.values()
    result: dict[Any, float] = {model.names.atoms["t"]: t}
    result.update((p.symbol, numbers[p.name]) for p in model.parameters)
    result.update(zip((c.symbol for c in model.coordinates), q, strict=True))
    result.update(zip((s.symbol for s in model.speeds), u, strict=True))
    return result
