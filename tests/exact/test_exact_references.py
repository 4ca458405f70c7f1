"""The closed forms of freebody.exact against the 30-digit motions that the benchmarks are measured with."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from freebody import exact

PATH = Path(__file__).parents[2] / "benchmarks" / "references.json"


@pytest.fixture(scope="module")
def references():
    return json.loads(PATH.read_text(encoding="utf-8"))


def floats(rows):
    return np.array(rows, dtype=float)


def test_heavy_top_over_ten_seconds(references):
    motion = references["heavy_top"]
    p = {name: float(value) for name, value in motion["parameters"].items()}
    I_xi, I_zeta = exact.gyroscope_moments(p["m"], p["R"], p["L"])
    theta0 = np.arccos(p["cos_theta0"])
    top = exact.top_from_rest(
        I_xi, I_zeta, p["m"] * p["g"] * p["L"], theta0, p["spin"], floats(motion["times"])
    )
    c, s = np.cos(top.theta / 2), np.sin(top.theta / 2)
    plus, minus = (top.psi + top.phi) / 2, (top.psi - top.phi) / 2
    found = np.stack([c * np.cos(plus), s * np.cos(minus), s * np.sin(minus), c * np.sin(plus)], axis=-1)
    expected = floats(motion["quaternions"])
    found *= np.sign((found * expected).sum(axis=1))[:, None]
    assert_allclose(found, expected, rtol=0, atol=2e-12)  # angles of up to 1000 rad


def test_tumbling_body_over_a_hundred_seconds(references):
    motion = references["tumbling"]
    moments, w0 = (floats(motion["parameters"][name]) for name in ("moments", "w0"))
    omega = exact.torque_free(moments, w0, floats(motion["times"]))
    # 1 - k² is 1.2e-4 here: the period, and so the phase, is known to 1e-16 / 1.2e-4 per turn-over
    assert_allclose(omega, floats(motion["omegas"]), rtol=0, atol=1e-10)


def test_references_are_unit_quaternions_that_keep_the_moment_of_momentum(references):
    motion = references["tumbling"]
    moments, w0 = (floats(motion["parameters"][name]) for name in ("moments", "w0"))
    w, x, y, z = floats(motion["quaternions"]).T
    assert_allclose(w**2 + x**2 + y**2 + z**2, 1, rtol=1e-15)
    H = moments * floats(motion["omegas"])
    v = np.stack([x, y, z], axis=-1)
    turned = H + 2 * w[:, None] * np.cross(v, H) + 2 * np.cross(v, np.cross(v, H))
    assert_allclose(turned, np.tile(moments * w0, (10, 1)), rtol=0, atol=1e-14)
