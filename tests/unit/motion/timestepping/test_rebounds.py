"""Compliant contacts in steps that are too long for them: energy that they give back and did not take."""

import numpy as np
import pytest

import freebody as fb

G = 9.81


def ball(law: str, family: bool) -> fb.System:
    s = fb.System("soft")
    s.gravity = (0, 0, -G)
    body = s.body("ball", fb.sphere(1, 0.1))
    s.free("f", s.ground, body)
    sides = body.sphere(0.1), s.ground.plane(normal="z")
    if family:
        s.contacts("floor", sides, normal=law)
    else:
        s.contact("floor", *sides, normal=law)
    return s


@pytest.mark.parametrize("law", ["1e9*depth", "1e8*depth**1.5*(1 + 0.3*rate)"])
@pytest.mark.parametrize("family", [False, True])
def test_a_contact_shorter_than_the_step_is_said_with_the_energy_that_it_makes(law, family):
    motion = fb.simulate(ball(law, family), 0.4, initial={"f_z": 0.5}, method="timestepping", step=1e-3)
    (warning,) = motion.warnings
    made = motion.energy.kinetic[-1] + motion.energy.potential[-1] - G * 0.5
    assert warning.value == pytest.approx(made, rel=0.02)
    assert warning.name == ("floor[ball,ground]" if family else "floor")
    assert str(warning).startswith(
        f"{warning.name}: the contact gives back more energy than it took, {warning.value:g} J at worst (0.286 to 0.4 "
        "s). A step must be short beside the time of a compliant contact: from t = 0.286 s on this motion is not "
        "physical. Take a step shorter than 0.001 s, or method='auto'."
    )
    assert motion.status == "finished, not physical"
    assert np.abs(motion.energy.residual).max() < 1e-9 * made  # which the ledger does not show


@pytest.mark.parametrize("law", ["1e6*depth**1.5", "1e6*depth + 100*rate"])
@pytest.mark.parametrize("family", [False, True])
def test_the_cure_works(law, family):
    motion = fb.simulate(ball(law, family), 0.4, initial={"f_z": 0.5}, method="timestepping", step=1e-4)
    assert motion.warnings == () and motion.status == "finished"


def test_a_ball_that_rests_or_begins_inside_makes_no_energy():
    for start in (0.1 - G / 1e5, 0.09):
        motion = fb.simulate(
            ball("1e5*depth + 50*rate", False), 0.2, initial={"f_z": start}, method="timestepping", step=1e-4
        )
        assert motion.warnings == ()


def test_less_energy_is_said_too():
    start = {"f_z": 0.1 + 2.25e-3, "f_vz": -1.0}
    motion = fb.simulate(ball("4e6*depth", False), 0.05, initial=start, method="timestepping", step=1e-3)
    kept = motion.energy.kinetic[-1] + motion.energy.potential[-1]
    had = motion.energy.kinetic[0] + motion.energy.potential[0]
    (warning,) = motion.warnings
    assert warning.value == pytest.approx(kept - had, rel=0.05) and warning.value < 0
    assert warning.what == "the contact gives back less energy than it took"
