"""Whether an element is zero, decided exactly also where its form is not canonical.

The ring has no zero divisors, so that x = 0 if and only if x P^n = 0. Written in powers of the inverse i of P,

    x = Σ a_k i^k      =>      x P^n = Σ a_k P^(n-k),

which holds no inverse of P: what is left after all inverses are cleared has one form.
"""

from __future__ import annotations

from typing import Any

from .element import Polynomial, element


def is_zero(x: Any) -> bool:
    """Whether an element, a number or anything that compares with 0 is zero."""
    if type(x) is not Polynomial or not x.ring.relations.unfinished:
        return bool(x == 0)
    return bool(x == 0 or cleared(x) == 0)


def cleared(x: Any) -> Any:
    """x times powers of what its inverse generators stand for, newest first, so that none is left."""
    ring = x.ring
    while type(x) is Polynomial:
        g = next((g for g in reversed(ring.used(x)) if g.kind == "inverse"), None)
        if g is None:
            break
        terms = ring.terms(ring.promoted(x.num))
        n = max(dict(monomial).get(g.index, 0) for monomial, _ in terms)
        place = ring.capacity - 1 - g.index
        rest, total = ring.promoted(x.num), 0
        for k in range(n + 1):  # the coefficient of i^k, by derivatives at i = 0
            a = rest.subs({f"g{g.index}": 0})
            total = total + _reduced(ring, a, x.den) * g.arguments[0] ** (n - k)
            rest = (rest.derivative(place) if k < n else rest) // (k + 1)
        x = total
    return x


def _reduced(ring: Any, num: Any, den: int) -> Any:
    found = element(ring, num, den, ring.support(num))
    return ring.reduced(found) if type(found) is Polynomial else found
