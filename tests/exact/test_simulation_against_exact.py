"""The compiled simulation against closed forms over 100 periods.

A state in double precision is known to eps; near a separatrix each pass multiplies what is lost by the inverse of the
distance from it, so the bound there is that distance's and not the tolerance's.
"""

import math

import numpy as np
import pytest

import freebody as fb

TOLERANCE = 1e-12
AGREEMENT = 1e-8  # a tolerance of 1e-12 a step, 100 periods of some hundred steps


def body(moments):
    s = fb.System("body")
    a, b, c = moments
    s.free(
        "air", s.ground, s.body("body", fb.MassProperties(1, (0, 0, 0), ((a, 0, 0), (0, b, 0), (0, 0, c))))
    )
    return s


@pytest.mark.parametrize(
    "w0",
    [(0.3, 2.0, 1.0), (1.0, 0.1, 2.0), (2.0, 0.2, 0.1), (0.1, 2.0, 0.1)],
    ids=["a", "b", "c", "near separatrix"],
)
def test_torque_free_body(w0):
    moments = (1, 2, 3)
    exact = fb.exact.torque_free(moments, w0)
    times = np.linspace(0, 100 * exact.period, 201)
    initial = {f"air_w{axis}": w for axis, w in zip("xyz", w0, strict=True)}
    found = fb.simulate(body(moments), times[-1], initial=initial, tolerance=TOLERANCE, times=times)
    size = np.linalg.norm(w0)
    w = np.stack([found[f"air_w{axis}"] for axis in "xyz"], axis=1)
    assert np.abs(w - exact.angular_velocity(times)).max() < AGREEMENT * size
    bound = AGREEMENT / math.sqrt(exact.complementary)  # what one pass of the separatrix makes of an error
    assert np.abs(found.poses["body"].rotation - exact.attitude(times)).max() < bound


def test_symmetric_body():
    exact = fb.exact.torque_free((1, 1, 1.8), (0.5, 0, 6))
    times = np.linspace(0, 100, 101)
    found = fb.simulate(
        body((1, 1, 1.8)), 100, initial={"air_wx": 0.5, "air_wz": 6}, tolerance=TOLERANCE, times=times
    )
    assert np.abs(found.poses["body"].rotation - exact.attitude(times)).max() < AGREEMENT


@pytest.mark.parametrize(
    "theta_rate, psi_rate",
    [(0, 0), (0.4, 3.0), (0.3, 0.5), (0.5, -6.0)],
    ids=["cusp", "loop", "wave", "back"],
)
def test_heavy_top(theta_rate, psi_rate):
    m, R, L, g, spin = 1.2, 0.06, 0.1, 9.81, 300.0
    s = fb.System("top")
    s.gravity = (0, 0, -g)
    rotor = s.body("rotor", fb.disk(m, R))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -L), axis="ZXZ", coordinate="psi theta phi")
    I_xi, I_zeta = m * R**2 / 4 + m * L**2, m * R**2 / 2
    theta0 = math.pi / 3
    exact = fb.exact.top(I_xi, I_zeta, m * g * L, theta0, spin, theta_rate, psi_rate)
    times = np.linspace(0, 100 * exact.period, 201)
    found = fb.simulate(
        s, times[-1], times=times, tolerance=TOLERANCE,
        initial={"theta": theta0, "theta'": theta_rate, "psi'": psi_rate, "phi'": spin - psi_rate * math.cos(theta0)},
    )  # fmt: skip
    assert np.abs(found["theta"] - exact.theta(times)).max() < AGREEMENT
    assert np.abs(found["psi"] - exact.psi(times)).max() < AGREEMENT
