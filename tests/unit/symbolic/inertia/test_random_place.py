"""Random places: roots modulo a prime, and roots that are refused."""

from __future__ import annotations

import pytest

import freebody as fb
from freebody.symbolic.derivation.canonical_model import CanonicalModel
from freebody.symbolic.inertia.random_place import NoRootError, Place

BALL = fb.MassProperties(1, (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))


def test_roots_of_parameters_and_numbers():
    s = fb.System("rooted")
    s.parameters("k")
    s.gravity = (0, "-9.81", 0)
    first, second = s.body("first", BALL), s.body("second", BALL)
    s.hinge("one", s.ground, first, axis="z")
    s.hinge("two", first, second, axis="z", at=("sqrt(k) + sqrt(2)", 0, 0))
    lines = fb.base_parameters(s).text().splitlines()
    assert lines[0] == "first.hx    =  first.hx + (sqrt(k) + sqrt(2))*second.m"


def test_roots_of_coordinates_are_refused():
    s = fb.System("rooted")
    s.coordinates("a")
    s.slider("one", s.ground, s.body("b", BALL), axis="z", coordinate="sqrt(1 + a**2)")
    s.hinge("two", s.bodies["b"], s.body("c", BALL), axis="x")
    with pytest.raises(
        fb.FreebodyError, match=r"without roots of coordinates for its base parameters, got sqrt\(a"
    ):
        fb.base_parameters(s)


def test_relations_hold_at_a_place():
    s = fb.System("place")
    s.parameters("a")
    s.free("air", s.ground, s.body("b", BALL))
    s.hinge("pin", s.bodies["b"], s.body("c", BALL), axis="z", at=("sqrt(a)", 0, 0))
    canonical = CanonicalModel(fb.assemble(s))
    ring, prime = canonical.ring, 2**61 - 1  # a prime of the form 4 n + 3
    pin = canonical.state.q[-1]
    found = 0
    for seed in range(9):
        place = Place(canonical, seed, prime)
        assert sum(place(x) ** 2 for x in canonical.state.q[3:7]) == 1
        assert place(ring.sin(pin)) ** 2 + place(ring.cos(pin)) ** 2 == 1
        a = ring.generator(canonical.model.parameters[0].symbol)
        try:
            assert place(ring.sqrt(a)) ** 2 == place(a)
            found += 1
        except NoRootError as missing:
            assert missing.args == (True,)
    assert 0 < found < 9  # half of the numbers have a root
