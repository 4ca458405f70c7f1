"""Masses of the links of a looped tree: wrenches by second moments, and what lies on the axis of a hinge."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.dynamics.kinematics import turning
from freebody.program.large import link_masses
from freebody.program.large.link_step import constants_of
from freebody.testing import machines

EPS = np.finfo(float).eps


def test_the_wrench_by_second_moments_is_that_of_newton_and_euler() -> None:
    """Of ten particles: F = Σ m_i a_i and N = Σ r_i × m_i a_i, with a_i = a + Ω r_i."""
    rng = np.random.default_rng(3)
    m, r = rng.uniform(1, 2, 10), rng.normal(size=(10, 3))
    w, alpha, a = rng.normal(size=(3, 3))
    B = np.array(turning(tuple(w), tuple(alpha)))
    forces = m[:, None] * (a + r @ B.T)
    second = (m[:, None, None] * r[:, :, None] * r[:, None, :]).sum(axis=0)
    mass = (m.sum(), tuple(m @ r), tuple(map(tuple, second)))
    N, F = link_masses.needed(mass, tuple(map(tuple, B)), tuple(a))
    size = np.abs(np.cross(r, forces)).sum()
    assert np.abs(np.array(F) - forces.sum(axis=0)).max() < 32 * EPS * np.abs(forces).sum()
    assert np.abs(np.array(N) - np.cross(r, forces).sum(axis=0)).max() < 32 * EPS * size


def test_what_lies_on_the_axis_counts_to_the_parent() -> None:
    """A chain of hinges: the mass of all links is at the first one, whose own counts to the ground."""
    s = machines.random_system(5, 6, ["hinge"], branching=False, loads=False, small=True)
    model = fb.assemble(s)
    bare = [
        link.axis.index(1) if sorted(map(abs, link.axis)) == [0, 0, 1] and 1 in link.axis else -1
        for link in model.links
    ]
    constants = [[float(x) for x in constants_of(model, i)] for i in range(len(model.links))]
    found = np.array(link_masses.counted(model.links, constants, bare))
    plain = np.array(link_masses.counted(model.links, constants, [-1] * len(bare)))
    for i, axis in enumerate(bare):
        zeros = [k for k, x in enumerate(link_masses.of(range(1, 11), axis)[1]) if x == 0]
        assert zeros == ([axis] if axis >= 0 else [])
        if axis >= 0:
            assert found[i, 0] == found[i, 1 + axis] == 0
            assert found[i, 4 + link_masses.UPPER.index((axis, axis))] == 0
    kept = sum(found[i, 0] for i in range(len(bare)))
    lost = sum(plain[k, 0] for k in range(next((i for i, a in enumerate(bare) if a < 0), len(bare))))
    assert abs(kept - (plain[:, 0].sum() - lost)) < 8 * EPS * plain[:, 0].sum()
