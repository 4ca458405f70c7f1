"""Speeds of constrained machines that move no mass at the values given: refused by name, wherever they are met."""

import pytest

import freebody as fb
from freebody.errors import ModelError


def geared() -> fb.System:
    """Two rotors that a gear couples; the moment of inertia of each is a parameter."""
    s = fb.System("geared")
    I, J, k, m = s.parameters(I=1.0, J=2.0, k=10.0, m=1.0)  # noqa: E741
    one = s.body("one", fb.MassProperties(m, (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, I))))
    two = s.body("two", fb.MassProperties(m, (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, J))))
    first = s.hinge("first", s.ground, one, axis="z", coordinate="p")
    second = s.hinge("second", s.ground, two, at=(1, 0, 0), axis="z", coordinate="q")
    s.spring("k", first, stiffness=k)
    s.gear(first, second, -2, name="mesh")
    return s


@pytest.mark.parametrize("values, name", [({"I": 0}, '"p\'" moves'), ({"J": 0}, '"q\'" moves')])
def test_a_speed_that_moves_no_mass_is_named(values: dict[str, float], name: str) -> None:
    s = geared()
    refusal = f"{name} no mass of 'geared' at these values.*above 0, or describe them by the coordinate"
    with pytest.raises(ModelError, match=refusal):
        fb.simulate(s, 1, initial={"p": 0.1}, values=values)
    with pytest.raises(ModelError, match=refusal):
        fb.linearize(s, values=values)


def test_masses_above_zero_are_simulated() -> None:
    """(I + J/4) p'' + k p = 0 with q = -p/2."""
    found = fb.simulate(geared(), 1, initial={"p": 0.1})
    expected = fb.linearize(geared(), values={}).natural_frequencies()
    assert float(expected[0]) == pytest.approx((20 / 3) ** 0.5, rel=1e-12)
    assert float(found["q"][-1]) == pytest.approx(-float(found["p"][-1]) / 2, rel=1e-9)


@pytest.mark.parametrize("axis", ["x", "z"])
def test_a_slender_bar_that_may_spin_and_touches_a_floor_is_refused_by_name(axis: str) -> None:
    s = fb.System("ladder")
    bar = s.body("bar", fb.slender_bar(10, 2, axis=axis))
    s.free("air", s.ground, bar)
    s.contact("floor", bar.sphere(0.02), s.ground.plane(normal="z"), friction=0.2)
    with pytest.raises(
        ModelError, match=f"'air_w{axis}' moves no mass of 'ladder'.* a moment of inertia above 0"
    ):
        fb.simulate(s, 1, initial={"air_z": 1})
