"""Laws of constrained machines: the conditions hold, their forces do no work, and every body is in balance."""

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import (
    coordinate_rates,
    float_state,
    inverse_dynamics,
    kinetic_energy,
    potential_energy,
)
from freebody.dynamics.conditions.constrained import closed_coordinates, independent_rows, speed_correction
from freebody.dynamics.conditions.constraints import rows
from freebody.dynamics.conditions.linearized import linearized
from freebody.dynamics.motion import motion, total_power
from freebody.errors import ModelError

EPS = np.finfo(float).eps


def four_bar():
    s = fb.System("four-bar")
    s.gravity = (0, -9.81, 0)
    crank, rod, rocker = (
        s.body(n, fb.slender_bar(1, L)) for n, L in (("crank", 1), ("rod", 2), ("rocker", 1.5))
    )
    s.hinge("A", s.ground, crank, to=(-0.5, 0, 0), coordinate="a")
    s.hinge("B", crank, rod, at=(0.5, 0, 0), to=(-1, 0, 0), coordinate="b")
    s.hinge("D", s.ground, rocker, at=(2, 0, 0), to=(-0.75, 0, 0), coordinate="d")
    s.hinge("C", rocker, rod, at=(0.75, 0, 0), to=(1, 0, 0))
    return s, [0.3, 0.4, 0.9]


OBLIQUE = {
    "oblique hinge": {"axis": (1, 1, 0)},
    "oblique slider": {"axis": (1, 2, 2)},
    "oblique cylindrical": {"axis": (0, 3, 4)},
    "oblique universal": {"axis": ((1, 1, 0), (1, -1, 0))},
    "screw": {"pitch": 0.3},
    "oblique screw": {"pitch": -0.2, "axis": (2, -1, 2)},
}


def closed_by(kind):
    s = fb.System(kind)
    s.gravity = (1, 2, 3)
    a, b = s.body("a", fb.box(1, (1, 2, 3))), s.body("b", fb.box(2, (3, 2, 3)))
    s.free("fa", s.ground, a)
    s.free("fb", s.ground, b)
    turned = {
        "parent_axes": fb.Rotation.euler("XYZ", 0.1, 0.2, 0.3),
        "child_axes": fb.Rotation.euler("XYZ", 0.3, 0.2, 0.1),
    }
    more = OBLIQUE.get(kind, {})
    getattr(s, kind.split()[-1])("joint", a, b, at=(0, 0, 1), to=(0, 0.5, 1), **turned, **more)
    return s, [0.1, 0.2, 0.3, 1, 0, 0, 0] * 2


def driven_rail():
    s = fb.System("driven rail")
    ball = s.body("ball", fb.sphere(2, 0.1))
    s.planar("p", s.ground, ball, coordinate="x y f")
    s.constrain("y = sin(t)*x + 1", name="rail")
    return s, [1, 1.2, 0.3]


def rolling_disk():
    s = fb.System("rolling disk")
    s.gravity = (9.81 / 2, -9.81 * 3**0.5 / 2, 0)
    disk = s.body("disk", fb.disk(5, 0.25))
    s.planar("p", s.ground, disk, coordinate="x y f")
    s.constrain("y - 0.25", name="floor")
    s.constrain_speed("x' + 0.25*f'", name="rolling")
    return s, [0, 0.25, 0]


def tackle():
    s = fb.System("tackle")
    s.gravity = (0, -9.81, 0)
    a, b = s.body("a", fb.sphere(3, 0.1)), s.body("b", fb.sphere(1, 0.1))
    s.slider("left", s.ground, a, at=(0, -1, 0), axis="-y", coordinate="p")
    s.slider("right", s.ground, b, at=(1, -1, 0), axis="-y", coordinate="q")
    s.rope([s.ground.point(0, 0, 0), a.origin, s.ground.point(0, 0, 0), s.ground.point(1, 0, 0), b.origin], 6)
    return s, [0.5, 1]


def geared():
    s = fb.System("geared")
    a, b = s.body("a", fb.disk(1, 1)), s.body("b", fb.disk(4, 2))
    first = s.hinge("first", s.ground, a, coordinate="p")
    second = s.hinge("second", s.ground, b, at=(3, 0, 0), coordinate="q")
    s.gear(first, second, -2)
    s.torque("drive", first, 3)
    return s, [0, 0]


LOOPS = ("hinge", "ball", "gimbal", "universal", "weld", "slider", "cylindrical", "planar", *OBLIQUE)
MACHINES = [four_bar, driven_rail, rolling_disk, tackle, geared]


def at_random(machine, t=0.4):
    s, guess = machine
    model = fb.assemble(s)
    q = closed_coordinates(model, guess, t=t)
    active = independent_rows(model, float_state(model, q, t=t))
    u = np.random.default_rng(6).normal(size=model.n_u)
    u = speed_correction(model, float_state(model, q, u.tolist(), t=t), active)
    return model, float_state(model, q, u, t=t), active


@pytest.fixture(params=[*MACHINES, *LOOPS], ids=lambda p: p if isinstance(p, str) else p.__name__)
def machine(request):
    return closed_by(request.param) if isinstance(request.param, str) else request.param()


def test_conditions_hold_to_round_off(machine):
    model, state, active = at_random(machine)
    given = linearized(model, state)
    moving = motion(model, state, active)
    G = np.array(given.matrix, dtype=float)
    size = 1 + np.abs(G).max() * (1 + np.abs(state.u).max() + np.abs(moving.udot).max())
    bound = 64 * model.n_u * EPS * size
    assert np.abs(np.array(given.residual, dtype=float)).max() < bound
    assert np.abs(np.array(given.rate, dtype=float)).max() < bound
    assert np.abs(G @ np.array(moving.udot, dtype=float) + np.array(given.bias, dtype=float)).max() < bound


def test_matrix_is_the_derivative_of_the_rate(machine):
    model, state, _ = at_random(machine)
    given = linearized(model, state)
    h = 1e-6
    q, u, rates = (np.array(x, dtype=float) for x in (state.q, state.u, coordinate_rates(model, state)))

    def rate(sign):
        there = float_state(model, (q + sign * h * rates).tolist(), u.tolist(), t=state.t + sign * h)
        return np.array(linearized(model, there).rate, dtype=float)

    gamma = (rate(1) - rate(-1)) / (2 * h)
    # central difference: h² times a third derivative, and round-off over h
    assert np.array(given.bias, dtype=float) == pytest.approx(gamma, abs=1e-8 * (1 + np.abs(gamma).max()))


def test_constraint_forces_as_wrenches_balance_the_bodies(machine):
    model, state, active = at_random(machine)
    moving = motion(model, state, active)
    rest = np.array(inverse_dynamics(model, state, moving.udot, moving.loads), dtype=float)
    size = 1 + max(np.abs(np.array(moving.multipliers, dtype=float)).max(), np.abs(moving.udot).max())
    assert np.abs(rest).max() < 1024 * EPS * size


def test_energy_changes_by_the_power_of_loads_and_clocks_only(machine):
    model, state, active = at_random(machine)
    moving = motion(model, state, active)
    h = 1e-5
    q, u, rates = (np.array(x, dtype=float) for x in (state.q, state.u, coordinate_rates(model, state)))
    udot = np.array(moving.udot, dtype=float)

    def energy(sign):
        moved, faster = q + sign * h * rates, u + sign * h * udot
        there = float_state(model, moved.tolist(), faster.tolist(), t=state.t + sign * h)
        return float(kinetic_energy(model, there) + potential_energy(model, there))

    change = (energy(1) - energy(-1)) / (2 * h)
    power = float(total_power(model, state, moving))
    assert change == pytest.approx(power, abs=1e-7 * (1 + abs(power) + abs(energy(0))))


def test_planar_loop_reports_what_the_plane_does_not_need():
    model, _, active = at_random(four_bar())
    assert [rows(model)[i].name for i in active] == ["C_x", "C_y"]


def test_closed_forms():
    model, state, active = at_random(rolling_disk())
    moving = motion(model, state, active)
    # (6.54): a = g sin β / (1 + I/mR²) = 2/3 g sin β;  N = m g cos β;  T = m g sin β / 3
    assert moving.udot[0] == pytest.approx(9.81 / 3, rel=64 * EPS)
    assert abs(moving.multipliers[0]) == pytest.approx(5 * 9.81 * 3**0.5 / 2, rel=64 * EPS)
    assert abs(moving.multipliers[1]) == pytest.approx(5 * 9.81 / 6, rel=64 * EPS)

    model, state, active = at_random(tackle())
    # block and tackle: 2 p + q = constant, (m_a + 4 m_b) p'' = (m_a - 2 m_b) g
    moving = motion(model, state, active)
    assert moving.udot[0] == pytest.approx(9.81 * (3 - 2) / (3 + 4), rel=256 * EPS)

    model, state, active = at_random(geared())
    # J_a + J_b/4 at the first shaft: 1/2 + 8/4
    assert motion(model, state, active).udot[0] == pytest.approx(3 / 2.5, rel=64 * EPS)


def test_what_can_not_be_closed_is_refused_by_name():
    far = fb.System("too short")
    crank, rod = far.body("crank", fb.slender_bar(1, 1)), far.body("rod", fb.slender_bar(1, 1))
    far.hinge("A", far.ground, crank, to=(-0.5, 0, 0), coordinate="a")
    far.hinge("B", crank, rod, at=(0.5, 0, 0), to=(-0.5, 0, 0), coordinate="b")
    far.hinge("C", far.ground, rod, at=(5, 0, 0), to=(0.5, 0, 0))
    with pytest.raises(ModelError, match="cannot be met.*'C_x' is still missed by.*Start nearer"):
        closed_coordinates(fb.assemble(far), [0.3, 0.4])
