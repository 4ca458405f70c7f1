"""Section forces of bars: closed forms, the slope of the moment, and free ends on random machines."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import freebody as fb
from freebody.errors import SimulationError
from freebody.gallery import entries
from freebody.picture.plots.section_forces import sections

NEAR = 1e-6
"""Relative: forces of a motion at the tolerance 1e-9, cuts 1e-9 L beside the points of forces."""


def hinged(m: float, L: float, g: float) -> fb.System:
    s = fb.System("hinged")
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L))
    s.hinge("pin", s.ground, bar, to=(-L / 2, 0, 0), coordinate="theta")
    return s


def test_a_bar_released_from_the_horizontal() -> None:
    """q = μ (g - 3 g x/(2 L)): V = -dM/ds of the load, M largest at L/3, m g L/27 (Beer & Johnston, chapter 16)."""
    m, L, g = 3.0, 2.0, 9.81
    found = sections(fb.simulate(hinged(m, L, g), 0.1), "bar")
    x = found.s
    assert np.abs(found.normal).max() == pytest.approx(0, abs=NEAR * m * g)
    inner = (x > 1e-6) & (x < L - 1e-6)
    shear = m * g / 4 - m * g / L * (x - 3 * x**2 / (4 * L))
    assert found.shear[inner] == pytest.approx(shear[inner], abs=NEAR * m * g)
    moment = m * g * (x / 4 - x**2 / (2 * L) + x**3 / (4 * L**2))
    assert found.moment == pytest.approx(moment, abs=NEAR * m * g * L)
    assert np.abs(found.moment).max() == pytest.approx(m * g * L / 27, rel=1e-4)


def test_a_bar_that_spins_is_pulled() -> None:
    """N = μ ω² (L² - r²)/2, without weight and shear."""
    m, L, w = 2.0, 1.5, 7.0
    found = sections(fb.simulate(hinged(m, L, 0.0), 0.1, initial={"theta'": w}), "bar", 0.05)
    inner = found.s > 1e-6
    assert found.normal[inner] == pytest.approx(
        (m / L * w**2 * (L**2 - found.s**2) / 2)[inner], rel=NEAR, abs=NEAR * m * L * w**2
    )
    assert np.abs(found.shear).max() + np.abs(found.moment).max() < NEAR * m * L * w**2


@pytest.mark.parametrize("seed", range(5))
def test_free_ends_and_the_slope_of_the_moment(seed: int) -> None:
    """On random chains under random forces: behind the last point all vanish, and dM/ds = V between the points."""
    rng = random.Random(seed)
    s = fb.System("chain")
    s.gravity = (0, -9.81, 0)
    parent: Any = s.ground
    lengths = [rng.uniform(0.5, 2) for _ in range(3)]
    for k, length in enumerate(lengths):
        bar = s.body(f"bar_{k}", fb.slender_bar(rng.uniform(0.5, 3), length))
        at = (0, 0, 0) if k == 0 else (lengths[k - 1] * rng.uniform(0.1, 0.5), 0, 0)
        s.hinge(
            f"pin_{k}", parent, bar, at=at, to=(-length * rng.uniform(0.2, 0.5), 0, 0), coordinate=f"q_{k}"
        )
        point = bar.point(length * rng.uniform(-0.4, 0.4), 0, 0)
        s.force(f"F_{k}", point, (rng.uniform(-9, 9), rng.uniform(-9, 9), 0))
        parent = bar
    speeds = {f"q_{k}'": rng.uniform(-3, 3) for k in range(3)}
    motion = fb.simulate(s, 0.2, initial={**{f"q_{k}": rng.uniform(-3, 3) for k in range(3)}, **speeds})
    for k in range(3):
        found = sections(motion, f"bar_{k}", 0.11)
        size = max(np.abs(found.normal).max(), np.abs(found.shear).max())
        for values, scale in ((found.normal, size), (found.shear, size), (found.moment, size * lengths[k])):
            assert abs(values[-1]) < NEAR * scale and abs(values[0]) < NEAR * scale
        steps = np.diff(found.s)
        wide = steps > 1e-5
        slope = np.diff(found.moment)[wide] / steps[wide]
        mean = (found.shear[1:] + found.shear[:-1])[wide] / 2
        # the shear is a parabola between points: its mean over a step differs by μ h² e'/12
        assert slope == pytest.approx(mean, abs=1e-4 * size)


def test_the_diagram_has_the_values() -> None:
    motion = fb.simulate(hinged(3.0, 2.0, 9.81), 0.1)
    panels = Figure().subplots(3, 1)
    assert [panel.get_ylabel() for panel in fb.plot.section_forces(motion, "bar", panels)] == [
        "N [N]",
        "V [N]",
        "M [N m]",
    ]
    found = sections(motion, "bar")
    for panel, values in zip(panels, found[1:], strict=True):
        assert panel.lines[0].get_ydata() == pytest.approx(values)
    assert panels[2].yaxis_inverted()


def test_refusals() -> None:
    motion = fb.simulate(hinged(3.0, 2.0, 9.81), 0.1)
    with pytest.raises(SimulationError, match="Unknown body 'baar'; did you mean 'bar'"):
        fb.plot.section_forces(motion, "baar")
    with pytest.raises(SimulationError, match="Expected three axes for N, V and M, got 1"):
        fb.plot.section_forces(motion, "bar", Figure().subplots())
    disk = fb.simulate(entries()["prob-6-6"].build(), 0.1)
    with pytest.raises(
        SimulationError,
        match=r"Expected a uniform bar, made by fb\.slender_bar, for section forces, got 'disk'",
    ):
        fb.plot.section_forces(disk, "disk")
    s = fb.System("thrown")
    s.free("air", s.ground, s.body("bar", fb.slender_bar(1, 1)))
    with pytest.raises(SimulationError, match="Expected a planar machine for section forces"):
        fb.plot.section_forces(fb.simulate(s, 0.1), "bar")
