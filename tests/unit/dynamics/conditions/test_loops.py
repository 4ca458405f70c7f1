"""Deep trees with loops: the recursion of `dynamics.conditions.loops` against M, G and their factors, and its cost."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import float_state, mass_matrix, traced_state
from freebody.dynamics.conditions import constrained
from freebody.dynamics.conditions.constrained import closed_coordinates, independent_rows
from freebody.dynamics.conditions.constraints import rows
from freebody.dynamics.conditions.linearized import linearized
from freebody.dynamics.conditions.loops import carriers, loop_motion, own_speeds
from freebody.scalar.trace import Tape


def lift(stages):
    """A scissor lift: two bars a stage, joined at their centres and at their ends with those of the next stage."""
    s = fb.System("lift")
    s.gravity = (0, -9.81, 0)
    bar = fb.slender_bar(1, 2, axis="x")
    start, angle = {"a0": 0.5}, np.pi - 1.0
    right = left = None
    for i in range(stages):
        a, b = s.body(f"A{i}", bar), s.body(f"B{i}", bar)
        below = s.ground if left is None else left
        s.hinge(
            f"p{i}",
            below,
            a,
            at=(0 if left is None else 1, 0, 0),
            to=(-1, 0, 0),
            axis="z",
            coordinate=f"a{i}",
        )
        s.hinge(f"c{i}", a, b, axis="z", coordinate=f"b{i}")
        start |= {f"b{i}": angle} | ({f"a{i}": -angle + 0.0} if i else {})
        if right is None:
            foot = s.body("foot", fb.particle(0.1))
            s.slider("rail", s.ground, foot, axis="x", coordinate="x")
            s.hinge("toe", foot, b, to=(-1, 0, 0), axis="z")
            start["x"] = 2 * np.cos(0.5)
        else:
            s.hinge(f"l{i}", right, b, at=(1, 0, 0), to=(-1, 0, 0), axis="z")
        right, left = a, b
    return fb.assemble(s), start


def necklace():
    """Balls, hinges, a slider, a screw and a driven joint in a row; loops within, across and around each other."""
    s = fb.System("necklace")
    s.gravity = (0.3, -9.81, 1)
    rng = np.random.default_rng(5)
    bodies, parent = [], s.ground
    for i in range(9):
        body = s.body(f"b{i}", fb.box(1 + 0.1 * i, (0.3, 0.5, 0.7)))
        place = {
            "at": tuple(rng.uniform(-1, 1, 3).round(3).tolist()),
            "to": tuple(rng.uniform(-1, 1, 3).round(3).tolist()),
        }
        if i in (1, 5):
            s.ball(f"j{i}", parent, body, **place)
        elif i == 3:
            s.screw(f"j{i}", parent, body, axis="y", pitch=0.2, **place)
        elif i == 4:
            s.slider(f"j{i}", parent, body, axis="x", **place)
        elif i == 7:
            s.hinge(f"j{i}", parent, body, axis="x", coordinate="sin(2*t)", **place)
        else:
            s.hinge(f"j{i}", parent, body, axis="xyz"[i % 3], **place)
        bodies.append(body)
        parent = bodies[2] if i == 5 else body  # a branch
    s.damper("d", bodies[0].point(1, 0, 0), bodies[6].point(0, 1, 0), damping=0.5)
    s.rope([bodies[1].point(0, 0, 1), bodies[3].point(1, 0, 0)], 2.5, name="r")
    s.ball("k", bodies[5], bodies[8], at=(0.2, 0.1, 0), to=(0, 0.3, 0.1))
    return fb.assemble(s)


GROUND = "ground"


def planar(model):
    """Conditions in the plane; those across it hold whatever the motion."""
    return [i for i, row in enumerate(rows(model)) if row.name.endswith(("_x", "_y"))]


def states(model, start=None):
    rng = np.random.default_rng(1)
    for _ in range(3):
        q = rng.uniform(-0.3, 0.3, model.n_q)
        if start:
            q = np.array([start.get(name, 0.0) for name in model.coordinate_names])
        for k in model.quaternions:
            q[k : k + 4] = np.array([1, *rng.uniform(-0.3, 0.3, 3)])
            q[k : k + 4] /= np.linalg.norm(q[k : k + 4])
        yield float_state(
            model, closed_coordinates(model, q.tolist(), 0.3), rng.normal(size=model.n_u).tolist(), 0.3
        )


@pytest.mark.parametrize("machine", [lambda: lift(4), lambda: (necklace(), None)])
def test_the_recursion_solves_the_equations_of_motion(machine):
    """M u - Gᵀ λ = f and G u = g, to the round-off of the equations; in the spatial machine loops share joints."""
    model, start = machine()
    speeds = own_speeds(model)
    rng = np.random.default_rng(2)
    for state in states(model, start):
        active = independent_rows(model, state)
        M = np.array(mass_matrix(model, state), dtype=float)
        G = np.array([linearized(model, state).matrix[i] for i in active], dtype=float)
        f, g = rng.normal(size=model.n_u), rng.normal(size=len(active))
        sparse = [linearized(model, state).matrix[i] for i in active]
        u, lam = loop_motion(model, state, speeds, f.tolist(), sparse, g.tolist())
        whole = np.block([[M, -G.T], [G, np.zeros((len(active), len(active)))]])
        found, right = np.array([*u, *lam]), np.array([*f, *g])
        expected = np.linalg.solve(whole, right)
        bound = 4 * len(found) * np.finfo(float).eps * np.linalg.cond(whole) * np.abs(expected).max()
        assert np.abs(found - expected).max() <= bound


def test_loops_hang_by_the_link_that_carries_them():
    model, start = lift(3)
    (state, *_) = states(model, start)
    matrix = linearized(model, state).matrix
    G = [matrix[i] for i in planar(model)]
    names = [GROUND if i < 0 else model.links[i].body for i in carriers(model, own_speeds(model), G)]
    assert names == [GROUND, GROUND, "A0", "A0", "A1", "A1"]
    for row in G[2:]:  # only the joints of a loop stand in its conditions
        assert sum(x != 0 or not isinstance(x, int) for x in row) == 3


def test_operations_grow_with_the_number_of_loops():
    """Of the accelerations of a lift; with M, G M⁻¹ Gᵀ and their factors, eight times as many for twice the stages."""
    counts = []
    for stages in (6, 12, 24):
        model, _ = lift(stages)
        assert constrained.deep_speeds(model)
        tape = Tape()
        udot, _ = constrained.constrained_dynamics(model, traced_state(model, tape), planar(model))
        counts.append(len(tape.used(udot)))
    assert counts[2] - counts[1] < 2.1 * (counts[1] - counts[0])


def test_a_coordinate_that_moves_two_joints_has_no_recursion():
    s = fb.System("shared")
    (a,) = [s.coordinates("a")]
    one, two = s.body("one", fb.box(1, (1, 2, 3))), s.body("two", fb.box(1, (1, 2, 3)))
    s.hinge("A", s.ground, one, axis="z", coordinate=a)
    s.hinge("B", one, two, at=(1, 0, 0), axis="z", coordinate=-2 * a)
    assert own_speeds(fb.assemble(s)) is None


def test_independence_of_a_row_is_found_at_a_cost_linear_in_its_length():
    """Operations of s² for a row of four-bars: each further loop adds the same."""
    counts = []
    for n in (4, 8, 12):
        s = fb.System("row")
        crank = s.body("crank0", fb.slender_bar(1, 1, axis="x"))
        s.hinge("A0", s.ground, crank, to=(-0.5, 0, 0), axis="z")
        for i in range(1, n + 1):
            coupler, following = (s.body(f"{x}{i}", fb.slender_bar(1, 1, axis="x")) for x in ("b", "crank"))
            s.hinge(f"B{i}", crank, coupler, at=(0.5, 0, 0), to=(-0.5, 0, 0), axis="z")
            s.hinge(f"A{i}", s.ground, following, at=(i, 0, 0), to=(-0.5, 0, 0), axis="z")
            s.hinge(f"C{i}", coupler, following, at=(0.5, 0, 0), to=(0.5, 0, 0), axis="z")
            crank = following
        model, tape = fb.assemble(s), Tape()
        least = constrained.independence(model, traced_state(model, tape), planar(model))
        counts.append(len(tape.used([least])))
    assert counts[2] - counts[1] == counts[1] - counts[0]
