"""Zero is recognised also where the relations of an inverse were not completed."""

from __future__ import annotations

import pytest
import sympy

import freebody as fb
from freebody.scalar.element import cleared, is_zero
from freebody.scalar.polynomial import Ring

t = sympy.Symbol("t")


def far_end(n, lengths):
    """Squared distance of the end of a chain from a point, and what it is made of."""
    ring = Ring()
    q = [ring.generator(sympy.Function(f"q{k}")(t)) for k in range(n)]
    L = [ring.generator(sympy.Symbol(f"L{k}", positive=True)) if lengths else k + 1 for k in range(n)]
    X, Y = (ring.generator(sympy.Symbol(name)) for name in "XY")
    s, c = [ring.sin(a) for a in q], [ring.cos(a) for a in q]
    x = X + sum((a * b for a, b in zip(L, s, strict=True)), 0)
    y = Y + sum((a * b for a, b in zip(L, c, strict=True)), 0)
    return ring, x * x + y * y, x, y, s, c


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_products_with_an_inverse(n):
    ring, P, x, y, s, c = far_end(n, lengths=True)
    inverse = 1 / P
    assert ring.relations.unfinished == (n > 2)
    for f in (s[-1], s[0] * s[-1], x, s[-1] + c[0], x * y):
        zero = inverse * (P * f) - f
        assert is_zero(zero) and is_zero(zero * s[0])
        assert not is_zero(zero + 1) and not is_zero(inverse * f) and not is_zero(zero - inverse)
    assert is_zero((x * inverse) * x + (y * inverse) * y - 1)
    r = ring.sqrt(P)
    assert is_zero((x / r) * (x / r) + (y / r) * (y / r) - 1)


def test_what_is_left_when_inverses_are_cleared():
    """i² a + i b + c is a + b P + c P²."""
    ring, P, _, _, s, c = far_end(3, lengths=True)
    i = 1 / P
    a, b = s[0], c[1]
    found = cleared(i * i * a + i * b + 2)
    assert is_zero(found - (a + b * P + 2 * P * P))


def test_numbers_and_finished_rings():
    assert is_zero(0) and not is_zero(3)
    ring, P, *_ = far_end(1, lengths=False)
    assert not ring.relations.unfinished and is_zero(P - P) and not is_zero(P)


def test_energy_of_a_chain_on_a_spring():
    """Three bars with symbols for their lengths: the proof that the energy stays is the canonical zero."""
    s = fb.System("chain")
    k, L0, X, Y, *lengths = s.parameters("k L0 X Y L1 L2 L3")
    parent, before = s.ground, 0
    for n, (q, L) in enumerate(zip(s.coordinates("q1 q2 q3"), lengths, strict=True)):
        body = s.body(f"b{n}", fb.particle(1))
        s.hinge(f"h{n}", parent, body, to=(0, L, 0), coordinate=q - before)
        parent, before = body, q
    s.spring("k", s.ground.point(X, Y, 0), parent.origin, stiffness=k, rest=L0)
    e = fb.equations(s)
    assert e.integrals.names == ("energy",) and e.integrals[0].remainder() == 0
