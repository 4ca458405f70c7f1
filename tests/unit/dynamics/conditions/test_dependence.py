"""Set-up that grows with the size of a machine and no faster, and the directions that G is read along."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import float_state, traced_state
from freebody.dynamics.composite import mass_matrix
from freebody.dynamics.conditions.constrained import position_correction
from freebody.dynamics.conditions.constraints import rows
from freebody.dynamics.conditions.dependence import dependence, directions
from freebody.dynamics.conditions.linearized import linearized
from freebody.dynamics.linear import Factorization, entries
from freebody.dynamics.motion import motion
from freebody.scalar.trace import Tape, Traced


def parallelograms(n, first=1):
    """A row of n four-bars on the ground, the loops closed in an order that begins in the middle."""
    s = fb.System(f"{n} four-bars")
    s.gravity = (0, -9.81, 0)
    rods = [s.body(f"crank{i}", fb.slender_bar(1, 1, axis="x")) for i in range(n + 1)]
    for i, rod in enumerate(rods):
        s.hinge(f"A{i}", s.ground, rod, at=(i, 0, 0), to=(-0.5, 0, 0), axis="z", coordinate=f"phi{i}")
    for i in sorted(range(1, n + 1), key=lambda i: (i * first) % n):
        coupler = s.body(f"coupler{i}", fb.slender_bar(1, 1, axis="x"))
        ends = {"at": (0.5, 0, 0), "axis": "z"}
        s.hinge(f"B{i}", rods[i - 1], coupler, to=(-0.5, 0, 0), coordinate=f"beta{i}", **ends)
        s.hinge(f"C{i}", coupler, rods[i], to=(0.5, 0, 0), **ends)
    return fb.assemble(s)


@pytest.fixture
def operations(monkeypatch):
    """Counts what is done with recorded scalars, whether a node comes of it or not."""
    count = [0]

    def counting(function):
        def counted(*arguments):
            count[0] += 1
            return function(*arguments)

        return counted

    for name in ("add", "radd", "sub", "rsub", "mul", "rmul", "truediv", "rtruediv", "neg"):
        monkeypatch.setattr(Traced, f"__{name}__", counting(getattr(Traced, f"__{name}__")))
    return count


@pytest.mark.parametrize("first", [1, 3], ids=["in order", "out of order"])
def test_work_of_a_row_of_loops_is_linear_in_their_number(operations, first):
    """Of 8, 16 and 32 loops: what the last 16 add is twice what the 8 before them add.

    Ends and the order of elimination differ by a few operations of some thousand.
    """
    counts = []
    for n in (8, 16, 32):
        model, tape = parallelograms(n, first), Tape()
        active = [i for i, row in enumerate(rows(model)) if row.name.endswith(("_x", "_y"))]
        operations[0] = 0
        state = traced_state(model, tape)
        matrix = linearized(model, state).matrix
        parts = [operations[0]]
        moving = motion(model, state, active)
        parts.append(operations[0] - sum(parts))
        position = position_correction(model, state, active)
        parts.append(operations[0] - sum(parts))
        assert len(tape.used([*moving.udot, *position])) > 100 * n
        # a loop holds two cranks and a coupler: of each of its two rows three entries
        assert sum(len(entries(row)) for row in matrix) == 6 * n
        counts.append([*parts, len(tape)])
    few, some, many = np.array(counts)
    assert many - some == pytest.approx(2 * (some - few), rel=0.02)


def test_a_row_of_loops_takes_as_many_directions_as_a_loop_has_speeds():
    depends = dependence(parallelograms(12))
    assert {len(speeds) for speeds in depends.values()} == {3}
    found = directions(depends.values())
    # neighbours share a crank: 2 colours for cranks, and the couplers between
    assert len(found) == 3
    assert sorted(j for one in found for j in one) == list(range(25))
    assert all(len(one & speeds) <= 1 for one in found for speeds in depends.values())


def test_conditions_on_quaternions_and_speeds_depend_on_the_speeds_of_their_joints():
    s = fb.System("bodies")
    bodies = [s.body(name, fb.box(1, (1, 2, 3))) for name in "abc"]
    s.free("air", s.ground, bodies[0])
    s.ball("knee", bodies[0], bodies[1])
    s.hinge("pin", s.ground, bodies[2], axis="z", coordinate="x")
    s.constrain("knee_e1 + x^2/3", name="tilt")
    s.constrain("air_e2 - 2*air_x", name="flight")
    s.constrain_speed("knee_wx - 2*x*x' - t", name="rate")
    s.constrain_speed("x' - air_vz", name="climb")
    model = fb.assemble(s)
    random = np.random.default_rng(3)
    q = random.normal(size=model.n_q)
    for start in model.quaternions:
        q[start : start + 4] /= np.linalg.norm(q[start : start + 4])
    names = model.speed_names
    expected = {
        "tilt": {"knee_wx", "knee_wy", "knee_wz", "x'"},
        "flight": {name for name in names if name.startswith("air_")},
    }
    depends = {name: {names[j] for j in speeds} for name, speeds in dependence(model).items()}
    assert {name: depends[name] for name in expected} == expected

    def rate(u):
        return np.array(
            linearized(model, float_state(model, q.tolist(), u.tolist(), t=0.3)).rate, dtype=float
        )

    G = np.array(linearized(model, float_state(model, q.tolist(), t=0.3)).matrix, dtype=float)
    at_rest = rate(np.zeros(model.n_u))
    # ψ = G u + g is linear in u, so that its differences are the columns to round-off
    columns = [rate(unit) - at_rest for unit in np.eye(model.n_u)]
    assert (
        pytest.approx(np.transpose(columns), abs=64 * np.finfo(float).eps * (1 + np.abs(q).max()) ** 2) == G
    )


def test_mass_matrix_of_a_tree_is_factored_without_fill_in():
    """Legs on one carrier are coupled by it alone: eliminated after them, it adds no coupling between them."""
    s = fb.System("millipede")
    carrier = s.body("carrier", fb.box(5, (1, 1, 4)))
    s.free("air", s.ground, carrier)
    for i in range(9):
        upper, lower = (s.body(f"{part}{i}", fb.slender_bar(1, 1, axis="x")) for part in ("upper", "lower"))
        s.hinge(f"hip{i}", carrier, upper, at=(0, 0, i / 4), to=(0.5, 0, 0), axis="z")
        s.hinge(f"knee{i}", upper, lower, at=(-0.5, 0, 0), to=(0.5, 0, 0), axis="y")
    model = fb.assemble(s)
    M = mass_matrix(model, traced_state(model, Tape()))
    # the six speeds of the carrier come first; all are coupled once the legs are eliminated
    coupled = 15 + sum(len(entries(M[i][:i])) for i in range(6, model.n_u))
    assert coupled < model.n_u * (model.n_u - 1) / 4
    assert sum(map(len, Factorization(M).L)) <= coupled
