"""Laws of friction that vary hold at the end of every step, read from its speeds and impulses."""

import numpy as np
import pytest

import freebody as fb

LAWS = {
    "static": ({"friction": 0.3, "static_friction": 0.5}, lambda v: 0.3, 0.5),
    "stribeck": ({"friction": "0.2 + 0.3*exp(-slip/0.05)"}, lambda v: 0.2 + 0.3 * np.exp(-v / 0.05), 0.5),
    "steep": ({"friction": "0.2 + 0.3*exp(-slip/0.0005)"}, lambda v: 0.2 + 0.3 * np.exp(-v / 0.0005), 0.5),
    "rises": ({"friction": "0.1 + 40*slip"}, lambda v: 0.1 + 40 * v, 0.1),
}


def chained(law, family):
    """Three particles on a floor in space, joined by springs; the first one is pulled to and fro."""
    s = fb.System("particles")
    s.gravity = (0, 0, -9.81)
    bodies = []
    for i in range(3):
        body = s.body(f"b{i}", fb.sphere(1 + i, 0.1))
        s.chain(f"c{i}", s.ground, body, [fb.Slider(axis, f"{axis}{i}") for axis in "xyz"])
        if bodies:
            s.spring(f"k{i}", bodies[-1].origin, body.origin, stiffness=60, rest=0.5)
        bodies.append(body)
    floor = s.ground.plane(normal="z")
    if family:
        s.contacts("on", [body.sphere(0.1) for body in bodies], against=floor, **law)
    else:
        for i, body in enumerate(bodies):
            s.contact(f"on{i}", body.sphere(0.1), floor, **law)
    s.force("pull", bodies[0], ("12*sin(5*t)", "9*cos(7*t)", 0))
    start = {f"x{i}": 0.5 * i for i in range(3)} | {f"z{i}": 0.1 for i in range(3)} | {"y1'": 0.4}
    return s, start


@pytest.mark.parametrize("family", [False, True])
@pytest.mark.parametrize("name", LAWS)
def test_the_law_holds_at_the_end_of_every_step(name, family):
    law, mu, static = LAWS[name]
    s, start = chained(law, family)
    motion = fb.simulate(s, 1, initial=start, method="timestepping", step=2e-3)
    impulses, states = motion.course.impulses, motion.path.states[1:]
    n, modes = motion.kernels.model.n_q, []
    for i in range(3):
        v = states[:, n + 3 * i : n + 3 * i + 2]
        if family:
            log = impulses.pairs
            rows = log.entries[(log.entries[:, 10] == i) | (log.entries[:, 11] == i)]
            P = rows[:, 4:7] * np.sign(rows[:, 6:7])
        else:
            contacts = impulses.contacts[:, 3 * i : 3 * i + 3]
            P = np.column_stack([contacts[:, 1:], contacts[:, 0]])
        weight = (1 + i) * 9.81 * 2e-3
        np.testing.assert_allclose(P[:, 2], weight, rtol=1e-10)
        speed, T = np.linalg.norm(v, axis=1), np.linalg.norm(P[:, :2], axis=1)
        slips = speed > 1e-9
        if not family:
            opposite = -T[slips, None] * v[slips] / speed[slips, None]
            np.testing.assert_allclose(P[slips, :2], opposite, rtol=0, atol=1e-7 * weight)
        np.testing.assert_allclose(T[slips], (mu(speed) * P[:, 2])[slips], rtol=0, atol=1e-9 * weight)
        assert (T[~slips] <= static * P[~slips, 2] * (1 + 1e-9)).all()
        modes.append(slips)
    assert motion.residual <= 1e-12
    assert np.array(modes).any() and not np.array(modes).all()
