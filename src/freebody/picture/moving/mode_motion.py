"""The motion of a machine in one of its modes, as keyframes.

    q(t) = q_0 + u_0 t + a Re(X e^(i ω t)),        X e^(s t) for real roots

The amplitude a is as large as the eye needs: linear equations do not say how large. Loops are closed at every moment.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...dynamics.kinematics import poses
from ...errors import ModelError
from ...motion.trajectory.quantities import quaternions
from ...motion.trajectory.units import unit_of_name
from ...symbolic.linear.linear_model import LinearModel
from ...symbolic.linear.modes import Mode
from ..machine.configuration import configuration
from ..machine.shapes import machine_size
from .keyframes import Keyframes

PERIODS, FRAMES = 3, 49
"""Periods of an oscillation (or time constants), and moments in each."""

TURN, SHIFT = 0.35, 0.15
"""Greatest angle [rad], and greatest displacement over the size of the machine, by default."""


def mode_motion(linear: LinearModel, index: int, amplitude: float | None) -> Keyframes:
    """Return the keyframes of the motion in a mode; see `freebody.picture.page.animate.animate_mode`."""
    mode, model = mode_of(linear, index), linear.model
    names = list(linear.coordinates)
    shape = np.array([complex(mode.shape[name]) for name in names])
    a = _amplitude(linear, shape) if amplitude is None else float(amplitude)
    s = complex(mode.eigenvalue)
    rate = s.imag or s.real
    t = np.linspace(0.0, PERIODS * (2 * math.pi if s.imag else 1) / abs(rate), PERIODS * (FRAMES - 1) + 1)
    waves = np.exp(1j * s.imag * t) if s.imag else np.exp(-abs(s.real) * (t if s.real < 0 else t[-1] - t))
    deviations = a * np.real(np.multiply.outer(waves, shape))
    point = {name: float(linear.point[name]) for name in model.coordinate_names if name in linear.point}
    rates = {name: float(linear.point.get(f"{name}'", 0)) for name in point}
    near = {name: x for name, x in point.items() if name not in names} if model.constraints else {}
    positions = np.zeros((len(t), len(model.bodies), 3))
    rotations = np.zeros((len(t), len(model.bodies), 3, 3))
    states = np.zeros((len(t), model.n_q + model.n_u))
    for k, time in enumerate(t):
        moved = dict(zip(names, deviations[k], strict=True))
        at = {
            name: x + rates[name] * time + moved.get(name, 0.0)
            for name, x in point.items()
            if name not in near
        }
        now = configuration(model, {**at, "t": float(time)}, values=linear.values, near=near)
        near = {name: float(now.state.q[model.coordinate_names.index(name)]) for name in near}
        states[k, : model.n_q] = now.state.q
        for i, posture in enumerate(poses(model, now.state).values()):
            positions[k, i] = [float(x) for x in posture.position]
            rotations[k, i] = [[float(x) for x in row] for row in posture.rotation]
    turns = [quaternions(rotations[:, i]) for i in range(len(model.bodies))]
    still = np.zeros(len(t))
    return Keyframes(
        t, positions, np.stack(turns, axis=1), np.zeros_like(positions), (), {}, states, {}, still,
        np.zeros(len(t), dtype=int), None, 0.0,
    )  # fmt: skip


def mode_of(linear: LinearModel, index: int) -> Mode:
    """Return a mode that can be shown, or raise."""
    if linear.symbolic:
        raise ModelError(
            "Expected linear equations in numbers to animate a mode, got symbols. Use linear.numeric({...})."
        )
    modes = linear.modes()
    if isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < len(modes):
        raise ModelError(
            f"Expected a mode from 0 to {len(modes) - 1}, as in linear.modes()[0], got {index!r}."
        )
    mode: Mode = modes[index]
    unknown = [name for name in linear.coordinates if name not in linear.model.coordinate_names]
    if unknown:
        raise ModelError(
            f"Expected deviations of coordinates to animate, got '{unknown[0]}': a joint with a quaternion has none. "
            "Describe it as a gimbal."
        )
    if not complex(mode.eigenvalue):
        raise ModelError(f"Expected a mode that moves by itself, but mode {index} is a {mode.kind} at rest.")
    return mode


def _amplitude(linear: LinearModel, shape: Any) -> float:
    """Amplitude at which no coordinate exceeds `TURN` or `SHIFT`."""
    model, size = linear.model, machine_size(linear.model, linear.values)
    most = [TURN if unit_of_name(model, name) == "rad" else SHIFT * size for name in linear.coordinates]
    return float(min(limit / abs(x) for limit, x in zip(most, shape, strict=True) if abs(x) > 0))
