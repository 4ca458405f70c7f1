"""Supports on the ground that carry something, and joints to the ground that only count coordinates.

A satellite is described on a joint at its mass centre, in a frame that moves with it. That joint transmits no force
in any motion, so no bracket is drawn there. The force is computed at three states with generic speeds; where it
vanishes identically it is round-off of the greatest inertia force m (|ω|² + |dω/dt|) L + m |dv/dt|.
"""

from __future__ import annotations

import numpy as np

from ...dynamics.conditions.constrained import independent_rows
from ...dynamics.motion import motion
from ...dynamics.newton_euler import reactions
from ...dynamics.state import float_state
from .configuration import Configuration
from .shapes import machine_size

ROUND_OFF = 1e-10
"""Relative to the inertia forces: some 1e6 operations in double precision."""


def idle_supports(now: Configuration, planar: bool) -> set[str]:
    """Names of the joints to the ground that transmit no force in any motion.

    A hinge in space also holds the direction of its axis: it counts as idle only in a planar machine.
    """
    model = now.model
    names = {
        name
        for name, joint in model.joints.items()
        if joint.parent == "ground" and (joint.pair.spherical or planar and joint.pair.revolute)
    }
    if not names or model.controllers or model.contacts:
        return set()
    size = machine_size(model, now.values)
    mass = sum(abs(float(now.state(place.mass))) for place in model.bodies.values())
    gravity = float(np.linalg.norm([float(now.state(x)) for x in model.gravity]))
    random = np.random.default_rng(1)
    for _ in range(3):
        u = random.uniform(0.5, 1.5, model.n_u)
        state = float_state(model, list(now.state.q), u.tolist(), float(now.state.t), now.values)
        active = independent_rows(model, state) if model.constraints else None
        moving = motion(model, state, active)
        found = reactions(model, state, moving.udot, loads=moving.loads)
        rates = float(
            np.square(u).max(initial=0.0) + np.abs([float(x) for x in moving.udot]).max(initial=0.0)
        )
        least = ROUND_OFF * mass * (rates * max(size, 1.0) + gravity)
        names = {name for name in names if np.linalg.norm([float(x) for x in found[name][0]]) <= least}
    return names
