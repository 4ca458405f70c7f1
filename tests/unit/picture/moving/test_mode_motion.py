"""Modes as animations: the shape at the start, the period, closed loops, and what cannot be shown."""

from __future__ import annotations

import math

import numpy as np
import pytest

import freebody as fb
from freebody.errors import ModelError
from freebody.gallery import entries
from freebody.picture.moving.mode_motion import FRAMES, PERIODS, TURN, mode_motion


def test_the_motion_has_the_shape_and_the_period_of_the_mode() -> None:
    linear = fb.linearize(entries()["double-pendulum"].build(), values={})
    for k, mode in enumerate(linear.modes()):
        keys = mode_motion(linear, k, None)
        angles = keys.states[:, :2]
        assert np.abs(angles).max() == pytest.approx(TURN)
        assert angles[0] / angles[0, 1] == pytest.approx([mode.shape["theta_1"], mode.shape["theta_2"]])
        period = 2 * math.pi / mode.frequency
        assert keys.t[-1] == pytest.approx(PERIODS * period)
        assert angles[FRAMES - 1] == pytest.approx(angles[0])
        assert np.allclose(angles, np.outer(np.cos(mode.frequency * keys.t), angles[0]), atol=1e-12)
        # the mass centre of the first link is where its angle puts it
        assert keys.position[:, 0, 0] == pytest.approx(-keys.position[:, 0, 1] * np.tan(angles[:, 0]))


def test_a_loop_stays_closed() -> None:
    s = fb.System("swinging platform")
    a, b, g = s.parameters(a=0.1, b=0.28, g=9.81)
    s.gravity = (0, -g, 0)
    left, plate, right = (
        s.body(name, fb.slender_bar(1, L)) for name, L in (("left", a), ("plate", b), ("right", a))
    )
    s.hinge("A", s.ground, left, to=(-a / 2, 0, 0), coordinate="alpha")
    s.hinge("B", left, plate, at=(a / 2, 0, 0), to=(-b / 2, 0, 0), coordinate="beta")
    s.hinge("D", s.ground, right, at=(b, 0, 0), to=(-a / 2, 0, 0), coordinate="psi")
    s.hinge("C", plate, right, at=(b / 2, 0, 0), to=(a / 2, 0, 0))
    hanging = {"alpha": -math.pi / 2, "beta": math.pi / 2, "psi": -math.pi / 2}
    linear = fb.linearize(s, hanging, values={}, independent="alpha")
    keys = mode_motion(linear, 0, 0.5)
    alpha, beta, psi = keys.states[:, :3].T
    assert alpha == pytest.approx(psi) and alpha + beta == pytest.approx(np.zeros_like(beta), abs=1e-9)
    assert np.abs(alpha + math.pi / 2).max() == pytest.approx(0.5)


def test_a_page_and_its_name() -> None:
    linear = fb.linearize(entries()["double-pendulum"].build(), values={})
    shown = linear.animate(1, trails=False)
    assert repr(shown).startswith("Animation of 'double_pendulum, mode 1', 0 to ")
    assert "<title>double_pendulum, mode 1</title>" in shown.html


def test_what_cannot_be_shown() -> None:
    s = entries()["double-pendulum"].build()
    with pytest.raises(ModelError, match="linear equations in numbers to animate a mode, got symbols"):
        fb.linearize(s).animate()
    with pytest.raises(ModelError, match="Expected a mode from 0 to 1, as in linear.modes.*, got 2"):
        fb.linearize(s, values={}).animate(2)
    free = fb.System("free")
    free.slider("guide", free.ground, free.body("cart", fb.particle(1)), coordinate="x")
    with pytest.raises(ModelError, match="mode 0 is a rigid body at rest"):
        fb.linearize(free, values={}).animate()
    ball = fb.System("ball")
    ball.gravity = (0, 0, "-9.81")
    ball.ball("O", ball.ground, ball.body("bar", fb.box(1, (1, 2, 3))), to=(0, 0, "1/2"))
    with pytest.raises(ModelError, match="a joint with a quaternion has none. Describe it as a gimbal"):
        fb.linearize(ball, values={}).animate()
