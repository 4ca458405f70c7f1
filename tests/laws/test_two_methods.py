"""Motions from event to event and in time steps are of the same laws: one is the limit of the other."""

import pytest

import freebody as fb
from laws_of_contact import steps_come_to
from mixed_scenes import legged_scene, mixed_scene, poisson_scene, varied_scene


def compare(scene, seed, until=1.0):
    s, start, names = scene(seed)
    motion = fb.simulate(s, until, initial=start)
    assert motion.energy.relative_residual < 1e-7
    assert steps_come_to(motion, s, start, names), seed


@pytest.mark.parametrize("seed", range(4))
def test_steps_come_to_the_motion_by_events(seed):
    compare(mixed_scene, seed)


@pytest.mark.parametrize("seed", [50, 152])
def test_steps_come_to_the_motion_of_a_leg_by_events(seed):
    """A stop at rest beside dry friction; a step of radau to an event whose iteration does not converge."""
    compare(legged_scene, seed)


@pytest.mark.parametrize("seed", [6, 12])
def test_steps_with_friction_that_varies_come_to_the_motion_by_events(seed):
    compare(varied_scene, seed)


@pytest.mark.parametrize("seed", [9])
def test_steps_with_poissons_law_come_to_the_motion_by_events(seed):
    compare(poisson_scene, seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 180))
def test_steps_with_laws_that_vary_come_to_the_motions_by_events(seed):
    compare(varied_scene if seed < 140 else poisson_scene, seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4, 300))
def test_steps_come_to_the_motions_by_events(seed):
    compare(mixed_scene, seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(120))
def test_steps_come_to_the_motions_of_legs_by_events(seed):
    compare(legged_scene, seed)
