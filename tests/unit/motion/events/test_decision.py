"""Modes of forces that are not solved to round-off: cone and slip both vanish at the limit of friction."""

import numpy as np
import pytest

import freebody as fb
from cone_problems import Touching, contacts_of
from freebody.motion.cones.collision import compiled_code
from freebody.motion.cones.contacts import EXACT
from freebody.motion.events.decision import AMPLIFIED, NEAR
from freebody.motion.phase import laws
from freebody.native import loop


def at_the_limit(rng, count):
    """Contacts between three bodies and the ground, each at rest with |T| = μ N."""
    W = np.zeros((3 * count, 18))
    for k in range(count):
        first, second = rng.permutation(4)[:2]
        for body, sign in ((first, 1), (second, -1)):
            if body < 3:
                x, y, z = rng.normal(size=3)
                J = sign * np.hstack([np.eye(3), [[0, z, -y], [-z, 0, x], [y, -x, 0]]])
                W[3 * k : 3 * k + 3, 6 * body : 6 * body + 6] = J[[2, 0, 1]]
    N, turn, mu = rng.uniform(0.1, 1, count), rng.uniform(0, 2 * np.pi, count), rng.uniform(0.05, 1)
    forces = np.column_stack([N, mu * N * np.cos(turn), mu * N * np.sin(turn)]).ravel()
    A = W @ W.T
    contacts = [Touching(f"c{k}", 3 * k, 2, mu, mu) for k in range(count)]
    return contacts_of(A, -A @ forces, contacts)


@pytest.fixture(scope="module")
def near():
    """Problems whose solutions are not exact, but near enough to show modes."""
    rng, result = np.random.default_rng(0), []
    for _ in range(600):
        it = at_the_limit(rng, int(rng.integers(4, 9)))
        compiled_code()["find"](it)
        if EXACT < it.residual <= NEAR:
            result.append(it)
    return result


def test_near_solutions_show_contacts_at_rest_or_a_slip_against_their_friction(near):
    """e = s T - P(s T - r) bounds the part of r square to T by |e|, twice while |r| <= s |T|: it has no other way."""
    mode, at_rest = loop.code("motion.events.decision", "mode_of"), 0
    for it in near:
        small = 2 * it.residual * it.problem.reference
        for k in range(it.contacts):
            (T_1, T_2), (r_1, r_2) = (x[3 * k + 1 : 3 * k + 3] for x in (it.forces, it.after))
            at_rest += mode(it, k) == laws.STICK
            assert abs(T_1 * r_2 - T_2 * r_1) <= small * np.hypot(T_1, T_2)
            if mode(it, k) == laws.SLIDE:
                assert T_1 * r_1 + T_2 * r_2 < 0
    assert at_rest


def test_what_is_zero_grows_with_the_residual(near):
    rounded = loop.code("motion.events.decision", "rounded")
    for it in near:
        assert rounded(it, 1e-9) == AMPLIFIED * it.residual
    exact = at_the_limit(np.random.default_rng(1), 1)
    compiled_code()["find"](exact)
    assert exact.residual <= EXACT and rounded(exact, 1e-9) == 1e-9


@pytest.mark.parametrize("force", [-5, 5])
@pytest.mark.parametrize("drift", [0, 1, 3.552199467635486])
def test_a_joint_without_load_slips_in_the_sense_that_its_load_will_give_it(force, drift):
    """Two bodies fall from rest: load and acceleration of their joint are round-off, whose signs mean nothing.

    A force that grows from zero loads the joint, whose sense of slip is that of the motion without friction.
    """

    def falling(coefficient):
        s = fb.System("falling arm")
        s.gravity = (0, -9.81, 0)
        body, arm = (
            s.body("body", fb.box(2, (0.4, 0.2, 0.2))),
            s.body("arm", fb.slender_bar(0.7, 0.5, axis="y")),
        )
        s.planar("p", s.ground, body, coordinate="x y a")
        pin = s.hinge("pin", body, arm, at=(0, 0.1, 0), to=(0, -0.25, 0), axis="z", coordinate="q")
        s.force("F", body.origin, (f"{force}*sin(3*t)", 0, 0), frame=s.ground)
        if coefficient:
            s.friction("dry", pin, coefficient=coefficient, radius=0.03)
        start = {"y": 1, "q": -0.19784157266705604, "x'": drift}
        return fb.simulate(s, 0.2, initial=start, times=[0.1, 0.2])

    free, rough = falling(0), falling(0.3)
    assert len(rough.events) == 0
    assert list(rough.contacts["dry"].mode) == ["slip+" if force > 0 else "slip-"] * 2
    ratio = rough["q'"] / free["q'"]
    assert (ratio > 0).all() and (ratio < 1).all()
