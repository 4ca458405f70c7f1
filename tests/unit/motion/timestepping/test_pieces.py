"""Sensors of controllers that read contacts in time steps: mean forces of the last step, gaps and speeds at its end."""

import numpy as np
import pytest

import freebody as fb
from contact_machines import MU, G, M, pushed_block

STEP = 1e-3
STEPS = {"method": "timestepping", "step": STEP}


def test_forces_are_means_over_the_last_step():
    """Under a weight that grows by 3 N/s, a push of 5 N/s in steps."""
    read = []

    def law(t, x):
        read.append((t, x["N"], x["T"], x["left"], x["gap"]))
        return 5 * t

    sensors = {"N": "floor.normal", "T": "floor.tangential", "left": "floor.margin - 1", "gap": "floor.gap"}
    s = pushed_block((law, 0.1), sensors=sensors)
    s.force("weight", s.bodies["block"].origin, (0, "-3*t", 0))
    fb.simulate(s, 0.9, **STEPS)
    t, N, T, left, gap = np.array(read).T
    assert (N[0], T[0], left[0]) == (0, 0, -1) and not gap.any()
    np.testing.assert_allclose(N[1:], M * G + 3 * (t[1:] - STEP / 2), rtol=1e-12)
    np.testing.assert_allclose(T[1:], -5 * t[:-1], rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(left[1:], MU * N[1:] + T[1:] - 1, rtol=1e-12)


@pytest.mark.parametrize("method", [STEPS, {}])
def test_solids_of_a_family(method):
    """A box falls by 1 cm onto a block and lies there: the sum of the forces of its corners is read."""
    read = []

    def law(t, x):
        read.append((t, x["N"], x["more"]))
        return 0.0

    s = fb.System("box")
    s.parameters(u=0.0)
    s.gravity = (0, 0, -G)
    box = s.body("box", fb.box(1, (0.2, 0.1, 0.1)))
    s.free("f", s.ground, box)
    s.contacts("c", [box.box((0.2, 0.1, 0.1)), s.ground.box((0.4, 0.4, 0.2))], friction=0.3)
    s.force("lift", box.origin, (0, 0, "u"))
    s.controller(
        law, 0.03, "u", sensors={"N": "c[box,ground].normal", "more": "2*c[box,ground].normal + f_z"}
    )
    fb.simulate(s, 0.2, initial={"f_z": 0.16}, **method)
    t, N, more = np.array(read).T
    lies = t > np.sqrt(0.02 / G) + STEP
    np.testing.assert_allclose(N, np.where(lies, G, 0), rtol=1e-10)
    np.testing.assert_allclose(more[lies], 2 * G + 0.15, rtol=1e-10)
