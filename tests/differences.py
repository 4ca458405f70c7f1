"""Derivatives of motions beside differences of the fourth order."""

from __future__ import annotations

import numpy as np

import freebody as fb


def check_differences(s, until, names, initial, **options):
    """Raise unless the derivatives of the last state by these unknowns are differences of motions."""
    options = {"tolerance": 1e-13, "samples": 2, **options}
    motion = fb.simulate(s, until, initial=initial, sensitivities=list(names), **options)
    for name in names:
        value = initial[name] if name in initial else float(motion.values[name])
        h, ends = 1e-4 * max(abs(value), 1e-3), []
        for k in (1, -1, 2, -2):
            change = {name: value + k * h}
            changed = (
                {"initial": initial | change} if name in initial else {"initial": initial, "values": change}
            )
            ends.append(fb.simulate(s, until, **changed, **options).states[-1])
        expected = (8 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (12 * h)
        found = np.array([motion.sensitivity[x, name][-1] for x in motion.names])
        n = len(found)
        # each step has its round-off, and differences that of all steps
        noise = motion.path.steps * np.finfo(float).eps * np.abs(ends).max() / h
        assert np.abs(found - expected[:n]).max() <= 1e-6 * np.abs(expected[:n]).max() + noise
    return motion
