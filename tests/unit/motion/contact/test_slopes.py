"""Derivatives of contact forces along a motion against differences of the forces themselves."""

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import coordinate_rates, float_state
from freebody.motion.contact.complementarity import SLIP, balanced, unknowns
from freebody.motion.contact.modes import modes_at
from freebody.motion.contact.slopes import slopes
from freebody.motion.contact.starting_modes import see
from freebody.motion.contact.state import ContactRun
from freebody.motion.kernels.kernels import kernels_of


def forces_near(work, t, y, chosen, contacts, one):
    """Forces and accelerations of the same modes at a state near by."""
    seen = work.look(t, y)
    A, rows, _, _ = work.part(seen, chosen, y)
    modes = []
    for k, contact, (mode, d) in zip(chosen, contacts, one.modes, strict=True):
        if mode == SLIP and contact.tangents == 2 and contact.sliding is not None:
            v = work.slip(seen, k)
            d = v / np.linalg.norm(v)
        modes.append((mode, d))
    columns, held = unknowns(len(A), contacts, modes)
    lam, _ = balanced(A, seen.c[rows], contacts, np.array(columns).T, held, np.zeros(len(A)))
    return lam, A @ lam + seen.c[rows]


@pytest.mark.parametrize("speed", [0.0, 0.7])
@pytest.mark.parametrize("legs", [3, 4])
def test_slopes_are_derivatives(legs, speed):
    s = fb.System("table")
    s.gravity = (0, 0, -9.81)
    table = s.body("table", fb.box(2, (0.4, 0.3, 0.2)))
    s.free("f", s.ground, table)
    places = [(-0.2, -0.15, -0.1), (0.2, -0.15, -0.1), (0.2, 0.15, -0.1), (-0.2, 0.1, -0.1)][:legs]
    s.contact("leg", table.corners(*places), s.ground.plane(normal="z"), friction=0.4)
    s.force("F", table.point(0, 0.05, 0.1), (1 + 2 * s.t, 3 * s.t, s.t), frame=s.ground)
    kernels = kernels_of(s)
    work = ContactRun(kernels, kernels.values(None))
    work.looking = work.scene.constants(work.parameters)
    t, y = 0.0, np.zeros(work.it.n_y)
    y[2:4] = 0.1, 1.0
    for name in ("f_vx", "f_wz"):
        y[work.n + work.model.speed_names.index(name)] = speed
    see(work, y)
    (_, one), seen = modes_at(work), work.seen()
    chosen = list(range(legs))
    _, rows, responses, contacts = work.part(seen, chosen, y)
    assert all(mode == ("slip" if speed else "stick") for mode, _ in one.modes)
    assert one.rank_lack == {(3, False): 3, (4, False): 6, (3, True): 0, (4, True): 1}[legs, bool(speed)]
    growth, slope = slopes(work, t, y, seen, chosen, contacts, one)
    rate = np.zeros(len(y))
    n, n_u = work.n, work.model.n_u
    state = float_state(work.model, y[:n].tolist(), y[n : n + n_u].tolist(), t, work.values)
    rate[:n] = [float(x) for x in coordinate_rates(work.model, state)]
    rate[n : n + n_u] = seen.free + one.forces @ responses
    h = 1e-5
    lam, a = forces_near(work, t + h, y + h * rate, chosen, contacts, one)
    lam_0, a_0 = forces_near(work, t - h, y - h * rate, chosen, contacts, one)
    # the error of central differences, of the third derivatives, and of round-off: 1e-10 and 1e-16 · 20 / 1e-5
    np.testing.assert_allclose(slope, (lam - lam_0) / (2 * h), atol=1e-7)
    np.testing.assert_allclose(growth, (a - a_0) / (2 * h), atol=1e-7)
