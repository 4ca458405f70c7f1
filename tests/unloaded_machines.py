"""Random machines without loads but gravity, and one with displacements of several coordinates."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.testing import random_system


def coupled() -> fb.System:
    """Displacements that are functions of several coordinates, so that their partials change."""
    s = fb.System("coupled")
    s.gravity = (1, -2, 3)
    s.coordinates("q1 q2 q3")
    parent, rng = s.ground, np.random.default_rng(4)
    for i, q in enumerate(("q1 + q2**2/3", "2*q2 + sin(q1)", "q3 - q1*q2")):
        body = s.body(f"b{i}", fb.MassProperties(1 + i, rng.normal(size=3), np.diag(rng.uniform(1, 1.5, 3))))
        rotor = {"rotor": fb.Rotor(0.2, ratio=9)} if i else {}
        s.hinge(f"j{i}", parent, body, axis=rng.normal(size=3), at=rng.normal(size=3), coordinate=q, **rotor)
        parent = body
    return s


def unloaded(seed: int) -> fb.System:
    s = random_system(seed, 5, armature=seed % 2 == 1)
    s.loads.clear()
    return s
