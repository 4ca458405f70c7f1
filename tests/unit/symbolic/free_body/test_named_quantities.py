"""Free bodies in named quantities say the same as those that are written out."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.symbolic.equations import equations
from freebody.testing import random_system
from sampled import sampled


def values_of(expressions, start):
    """Numbers of expressions, from those of their symbols."""
    # second derivatives first, the time last
    numbers = sorted(
        start.items(), key=lambda item: (item[0].is_Symbol, -getattr(item[0], "derivative_count", 0))
    )
    found = [x.subs(numbers).evalf() for x in expressions]
    assert not set().union(*(x.free_symbols for x in found)), found
    return [float(x) for x in found]


@pytest.mark.parametrize("seed", sampled(range(3), 3))
def test_names_stand_for_what_they_say(seed):
    s = random_system(seed, bodies=3, joints=("hinge", "slider"), branching=False, small=True)
    named, whole = (equations(s, form=form).free_body("b2") for form in ("recursive", "explicit"))
    short = named.in_names
    assert short is not None and whole.in_names is None
    random = np.random.default_rng(seed)
    ring, model = short._e.ring, whole._e.model
    symbols = [*(c.symbol for c in model.coordinates), *(x.symbol for x in model.speeds)]
    symbols += [x.acceleration for x in model.speeds] + list(whole.unknowns)
    start = {x: random.normal() for x in sorted(symbols, key=str)}
    start[model.names.atoms["t"]] = 0.4
    expected = values_of([whole._e.sympy(a - b) + sympy.Integer(0) for a, b in whole.balances], start)
    balances = short.balances  # they make names
    for definition in short._e._names.names.definitions.values():
        (start[definition.symbol],) = values_of([sympy.sympify(ring.to_sympy(definition.value))], start)
    found = values_of([sympy.sympify(ring.to_sympy(a - b)) for a, b in balances], start)
    assert np.allclose(found, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())


def test_a_long_free_body_names_the_motion():
    s = fb.System("arm")
    s.gravity = (0, 0, -9.81)
    s.parameters(" ".join(f"m{i} c{i}" for i in range(7)))
    parent = s.ground
    for i in range(7):
        body = s.body(f"b{i}", fb.MassProperties(f"m{i}", (f"c{i}", 0, 0), np.eye(3).tolist()))
        s.hinge(f"j{i}", parent, body, at=(1, 0, 0), axis="xyz"[i % 3])
        parent = body
    text = fb.equations(s).free_body("b6").text()
    assert len(text) < 20_000 and "omega_b6_x = " in text and "accelerations; components" in text
    assert "omega_b6" not in fb.equations(s).free_body("b0").text()
    assert r"\omega_{b6, x}" in fb.equations(s).free_body("b6").latex().replace(r"\mathrm{b6}", "b6")
