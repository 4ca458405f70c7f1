"""Campbell's diagram of a rigid rotor on springs: closed forms of frequencies, sense of whirl and critical speeds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import freebody as fb
from freebody.errors import ModelError


def rotor(I_t: float, I_p: float, k: float, split: float = 1.0) -> fb.LinearModel:
    """Linear equations of a rotor that tilts by alpha and beta on torsion springs, with the speed as a symbol."""
    s = fb.System("rotor")
    Omega = s.parameters(Omega=5.0)
    outer, inner = s.body("outer", fb.particle(0)), s.body("inner", fb.particle(0))
    inertia = ((I_t, 0, 0), (0, I_t, 0), (0, 0, I_p))
    body = s.body("rotor", fb.MassProperties(1, (0, 0, 0), inertia))
    a = s.hinge("a", s.ground, outer, axis="x", coordinate="alpha")
    b = s.hinge("b", outer, inner, axis="y", coordinate="beta")
    s.hinge("shaft", inner, body, axis="z", coordinate=Omega * s.t)
    s.torsion_spring("k_a", a, stiffness=k)
    s.torsion_spring("k_b", b, stiffness=k * split)
    return fb.linearize(s, about={"alpha": 0, "beta": 0})


def curves(ax: Any, label: str) -> list[Any]:
    return [line for line in ax.lines if line.get_label() == label]


@pytest.mark.parametrize(("I_t", "I_p"), [(2.0, 1.0), (1.0, 1.9), (3.0, 0.2)])
def test_frequencies_and_senses_of_a_rotor_on_equal_springs(I_t: float, I_p: float) -> None:
    """ω = sqrt(h² + k/I_t) ± h, h = I_p Ω/(2 I_t): the faster one goes forward."""
    k, speeds = 200.0, np.linspace(0.5, 30, 24)
    ax = fb.plot.campbell(rotor(I_t, I_p, k), "Omega", speeds, Figure().subplots(), whirl=("alpha", "beta"))
    h = I_p * speeds / (2 * I_t)
    (forward,), (backward,) = curves(ax, "forward whirl"), curves(ax, "backward whirl")
    assert forward.get_ydata() == pytest.approx(np.sqrt(h**2 + k / I_t) + h, rel=1e-9)
    assert backward.get_ydata() == pytest.approx(np.sqrt(h**2 + k / I_t) - h, rel=1e-9)
    (order,) = curves(ax, "1 x speed")
    assert order.get_ydata() == pytest.approx(speeds)


@pytest.mark.parametrize(("I_t", "I_p"), [(2.0, 1.0), (1.0, 1.9)])
def test_critical_speeds_are_where_the_order_is_met(I_t: float, I_p: float) -> None:
    """Ω² (I_t ± I_p) = k: a flat rotor has no forward one."""
    k, speeds = 200.0, np.linspace(0.5, 30, 400)
    ax = fb.plot.campbell(rotor(I_t, I_p, k), "Omega", speeds, Figure().subplots(), whirl=("alpha", "beta"))
    dots = sorted(float(line.get_xdata()[0]) for line in ax.lines if line.get_marker() == "o")
    expected = sorted(np.sqrt(k / (I_t + sign * I_p)) for sign in (1, -1) if I_t + sign * I_p > 0)
    # interpolated between speeds 0.074 rad/s apart
    assert dots == pytest.approx([x for x in expected if x < 30], abs=1e-3)


@pytest.mark.parametrize(
    ("whirl", "speeds", "expected"),
    [
        (("alpha", "beta"), [1.0, 2.0], "forward whirl"),
        (("beta", "alpha"), [1.0, 2.0], "backward whirl"),
        (("alpha", "beta"), [-2.0, -1.0], "forward whirl"),
    ],
)
def test_the_sense_turns_with_the_shaft_and_the_axes(whirl: Any, speeds: Any, expected: str) -> None:
    ax = fb.plot.campbell(rotor(2.0, 1.0, 200.0), "Omega", speeds, Figure().subplots(), whirl=whirl)
    named = [line for line in ax.lines if "whirl" in str(line.get_label())]
    assert max(named, key=lambda line: max(line.get_ydata())).get_label() == expected


def test_a_rotor_that_stands_on_unequal_springs_swings_along_lines() -> None:
    """Without spin inertia the two tilts are apart, and no path has a sense."""
    ax = fb.plot.campbell(
        rotor(2.0, 0.0, 200.0, 1.5), "Omega", [1, 2, 3], Figure().subplots(), whirl=("alpha", "beta")
    )
    assert len(ax.lines) >= 3 and len(curves(ax, "along a line")) == 1


def test_refusals() -> None:
    linear = rotor(2.0, 1.0, 200.0)
    with pytest.raises(ModelError, match="Expected at least two values of the speed, ascending"):
        fb.plot.campbell(linear, "Omega", [3, 1], whirl=("alpha", "beta"))
    with pytest.raises(
        ModelError, match="Expected linear equations with 'Omgea' as a symbol.*did you mean 'Omega'"
    ):
        fb.plot.campbell(linear, "Omgea", [1, 2], whirl=("alpha", "beta"))
    with pytest.raises(ModelError, match="for whirl=, got 'beat'; did you mean 'beta'"):
        fb.plot.campbell(linear, "Omega", [1, 2], whirl=("alpha", "beat"))
