"""The integrator against closed forms, on right-hand sides written by hand (no model)."""

from __future__ import annotations

import _thread
import math
import signal
import threading
import tracemalloc

import numpy as np
import pytest

from freebody.motion.ending import End
from freebody.motion.ode import dop853 as tableau
from freebody.motion.ode.dense_output import Rates, Watch
from freebody.native import codegen
from freebody.native.instructions import Reals, compiled, root
from freebody.native.translation import translated
from integrations import integrate


class kernel:
    """A kernel written by hand."""

    def __init__(self, function):
        code, _ = codegen.optimised_code(translated({"kernel": compiled(function)}))
        self.library = codegen.Library(code)
        self.address = self.library.addresses(["kernel"])["kernel"]


@kernel
def oscillator(t: float, y: Reals, c: Reals, out: Reals) -> None:
    out[0] = y[1]
    out[1] = -c[0] * y[0]


@kernel
def oscillator_and_work(t: float, y: Reals, c: Reals, out: Reals) -> None:
    out[0] = y[1]
    out[1] = -c[0] * y[0]
    out[2] = y[1] * y[1]


@kernel
def kepler(t: float, y: Reals, c: Reals, out: Reals) -> None:
    r3 = (y[0] * y[0] + y[1] * y[1]) ** 1.5
    out[0] = y[2]
    out[1] = y[3]
    out[2] = -y[0] / r3
    out[3] = -y[1] / r3


@kernel
def symmetric_body(t: float, y: Reals, c: Reals, out: Reals) -> None:
    """q' = q ∘ (0, ω)/2 and Euler's equations, c = (I1, I3)."""
    w, x, y_, z, p, q, r = y[0], y[1], y[2], y[3], y[4], y[5], y[6]
    out[0] = 0.5 * (-x * p - y_ * q - z * r)
    out[1] = 0.5 * (w * p + y_ * r - z * q)
    out[2] = 0.5 * (w * q + z * p - x * r)
    out[3] = 0.5 * (w * r + x * q - y_ * p)
    k = (c[0] - c[1]) / c[0]
    out[4] = k * q * r
    out[5] = -k * p * r
    out[6] = 0.0


@kernel
def blow_up(t: float, y: Reals, c: Reals, out: Reals) -> None:
    out[0] = 1.0
    out[1] = y[1] * y[1]


@kernel
def square_root(t: float, y: Reals, c: Reals, out: Reals) -> None:
    out[0] = root(c[0] - t) if t <= c[0] else math.nan


@kernel
def constant_rate(t: float, y: Reals, c: Reals, out: Reals) -> None:
    out[0] = 1.0


@kernel
def position_and_speed(t: float, y: Reals, c: Reals, out: Reals) -> None:
    out[0] = y[0]
    out[1] = y[1]


@kernel
def position_twice(t: float, y: Reals, c: Reals, out: Reals) -> None:
    out[0] = y[0]
    out[1] = -3.0 * y[0]


@kernel
def above_bottom(t: float, y: Reals, c: Reals, out: Reals) -> None:
    out[0] = y[0] + c[1]


@kernel
def clock(t: float, y: Reals, c: Reals, out: Reals) -> None:
    out[0] = t - c[0]


OSCILLATOR = Rates(oscillator.address, 2, np.array([1.0]))
BODY = Rates(symmetric_body.address, 7, np.array([1.0, 1.7]), quaternions=(0,))


def fixed_step(rates, state, until, h):
    return integrate(rates, state, 0, until, relative=1e9, absolute=1e9, max_step=h, first_step=h)


def slope(errors):
    """Order from errors at steps h, h/2, h/4, ...: the least of the steps between neighbours."""
    return min(np.log2(np.array(errors[:-1]) / np.array(errors[1:])))


def rotate(axis, angle):
    return np.array([math.cos(angle / 2), *(math.sin(angle / 2) * np.asarray(axis))])


def product(a, b):
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])


def symmetric_body_exact(t, w0, transverse, axial):
    """Quaternion of a torque-free symmetric body that starts unturned: precession about H, spin about z."""
    momentum = np.array([transverse * w0[0], transverse * w0[1], axial * w0[2]])
    size = np.linalg.norm(momentum)
    return product(
        rotate(momentum / size, size / transverse * t),
        rotate((0, 0, 1), w0[2] * (1 - axial / transverse) * t),
    )


# --- the method ------------------------------------------------------------------------------------


def test_tableau_rows_sum_to_their_nodes():
    for row, node in zip((*tableau.A, tableau.B), (*tableau.C, 1.0), strict=True):
        assert sum(row.values()) == pytest.approx(node, abs=4e-14)  # coefficients reach 43


def test_tableau_weights_have_order_eight():
    for k in range(8):
        assert sum(b * tableau.C[j] ** k for j, b in tableau.B.items()) == pytest.approx(
            1 / (k + 1), abs=4e-14
        )


def rooted_trees(order):
    """Return the rooted trees of an order, each as a tuple of its branches."""

    def forests(nodes, most):
        if nodes == 0:
            yield ()
        for first in range(min(nodes, most), 0, -1):
            for tree in rooted_trees(first):
                yield from ((tree, *rest) for rest in forests(nodes - first, first))

    return sorted({tuple(sorted(forest)) for forest in forests(order - 1, order - 1)})


def nodes_of(tree):
    return 1 + sum(map(nodes_of, tree))


def density(tree):
    return nodes_of(tree) * math.prod(map(density, tree))


def test_dense_output_satisfies_the_conditions_of_order_six_everywhere_in_a_step():
    """Σ b_i(x) Φ_i = x^r/γ for every rooted tree of r nodes (Hairer, Norsett, Wanner, section II.2)."""
    stages = np.zeros((13, 13))
    for i, row in enumerate((*tableau.A, tableau.B)):
        stages[i, list(row)] = list(row.values())
    x = np.linspace(0, 1, 9)[:, None]
    of_rows = np.zeros((6, 13))
    of_rows[0] = stages[12]
    of_rows[1], of_rows[2] = -of_rows[0], 2 * of_rows[0]
    of_rows[1, 0] += 1
    of_rows[2, [0, 12]] -= 1
    for i, row in enumerate(tableau.D):
        of_rows[3 + i, list(row)] = list(row.values())
    z = 1 - x
    p = of_rows[3] + x * (of_rows[4] + z * of_rows[5])
    weights = x * (of_rows[0] + z * (of_rows[1] + x * (of_rows[2] + z * p)))

    def elementary(tree):
        return math.prod((stages @ elementary(branch) for branch in tree), start=np.ones(13))

    trees = [tree for order in range(1, 7) for tree in rooted_trees(order)]
    assert len(trees) == 1 + 1 + 2 + 4 + 9 + 20
    for tree in trees:
        exact = x[:, 0] ** nodes_of(tree) / density(tree)
        assert weights @ elementary(tree) == pytest.approx(exact, abs=1e-13)  # coefficients reach 135


def test_order_is_eight():
    errors = []
    for steps in (10, 20, 40):
        path = fixed_step(OSCILLATOR, [1, 0], 10, 10 / steps)
        assert path.steps == steps
        errors.append(abs(path.states[-1] - [math.cos(10), -math.sin(10)]).max())
    assert slope(errors) > 7.7


@pytest.mark.parametrize(("dense", "order"), [(True, 7), (False, 9)])
def test_order_inside_a_step(dense, order):
    """An interpolant of order 6 has a local error of h⁷, a step of order 8 one of h⁹."""
    x = np.linspace(0.05, 0.95, 19)
    errors = []
    for h in (1.0, 0.5, 0.25):
        path = fixed_step(OSCILLATOR, [1, 0], h, h)
        errors.append(abs(path.sample(x * h, dense)[:, 0] - np.cos(x * h)).max())
    assert slope(errors) > order - 0.3


def test_normalising_quaternions_keeps_the_order():
    w0 = np.array([0.3, 0.0, 2.0])
    errors = []
    for steps in (8, 16, 32):
        path = fixed_step(BODY, [1, 0, 0, 0, *w0], 8, 8 / steps)
        errors.append(abs(path.states[-1, :4] - symmetric_body_exact(8, w0, 1.0, 1.7)).max())
    assert slope(errors) > 7.5


@pytest.mark.parametrize(("dense", "order"), [(True, 6.5), (False, 7.5)])
def test_states_between_steps_keep_the_order_of_quaternions(dense, order):
    w0 = np.array([0.3, 0.0, 2.0])
    errors = []
    for steps in (8, 16, 32):
        path = fixed_step(BODY, [1, 0, 0, 0, *w0], 8, 8 / steps)
        times = np.linspace(0, 8, 100)
        exact = np.array([symmetric_body_exact(t, w0, 1.0, 1.7) for t in times])
        errors.append(abs(path.sample(times, dense)[:, :4] - exact).max())
    assert slope(errors) > order


# --- error control ---------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_oscillator_stays_within_a_multiple_of_the_tolerance(tolerance):
    path = integrate(OSCILLATOR, [1, 0], 0, 20, relative=tolerance, absolute=tolerance)
    exact = np.stack([np.cos(path.times), -np.sin(path.times)], axis=1)
    # local errors below 2 tol in each of the steps, added without damping
    assert abs(path.states - exact).max() < 2 * tolerance * path.steps
    assert path.status == End.FINISHED
    assert path.end == 20.0


def test_kepler_ellipse_closes():
    e, tolerance, turns = 0.5, 1e-11, 10
    start = [1 - e, 0, 0, math.sqrt((1 + e) / (1 - e))]
    path = integrate(
        Rates(kepler.address, 4, np.zeros(1)),
        start,
        0,
        2 * math.pi * turns,
        relative=tolerance,
        absolute=tolerance,
    )
    # a relative error ε of the energy turns the body by 3π n² ε against the exact one after n turns
    assert abs(path.states[-1] - start).max() < 3 * math.pi * turns**2 * 10 * tolerance
    energy = (path.states[:, 2:] ** 2).sum(1) / 2 - 1 / np.hypot(path.states[:, 0], path.states[:, 1])
    assert np.ptp(energy) < 20 * tolerance


@pytest.mark.parametrize("tolerance", [1e-6, 1e-10])
def test_efficiency_equals_that_of_scipy(tolerance):
    from scipy.integrate import solve_ivp

    e = 0.5
    start = [1 - e, 0, 0, math.sqrt((1 + e) / (1 - e))]

    def f(t, y):
        r3 = math.hypot(y[0], y[1]) ** 3
        return [y[2], y[3], -y[0] / r3, -y[1] / r3]

    path = integrate(
        Rates(kepler.address, 4, np.zeros(1)), start, 0, 20, relative=tolerance, absolute=tolerance
    )
    peer = solve_ivp(f, (0, 20), start, method="DOP853", rtol=tolerance, atol=tolerance)
    truth = solve_ivp(f, (0, 20), start, method="DOP853", rtol=3e-14, atol=1e-14).y[:, -1]
    ours, theirs = abs(path.states[-1] - truth).max(), abs(peer.y[:, -1] - truth).max()
    assert ours < 3 * max(theirs, tolerance)
    assert path.evaluations < 1.2 * peer.nfev


def test_tolerance_of_each_component():
    loose = np.array([1e-3, 1e-3])
    tight = np.array([1e-3, 1e-12])
    few = integrate(OSCILLATOR, [1, 0], 0, 10, relative=loose, absolute=loose)
    many = integrate(OSCILLATOR, [1, 0], 0, 10, relative=tight, absolute=tight)
    assert many.steps > 2 * few.steps


def test_quadrature_of_the_squared_speed():
    path = integrate(
        Rates(oscillator_and_work.address, 3, np.array([1.0])),
        [1, 0, 0],
        0,
        10,
        relative=1e-11,
        absolute=1e-11,
    )
    assert path.states[-1, 2] == pytest.approx(5 - math.sin(20) / 4, abs=1e-11 * path.steps)


def test_backwards_returns_to_the_start():
    there = integrate(OSCILLATOR, [1, 0.5], 0, 7, relative=1e-12, absolute=1e-12)
    back = integrate(OSCILLATOR, there.states[-1], 7, 0, relative=1e-12, absolute=1e-12)
    assert back.end == 0.0
    assert (np.diff(back.times) < 0).all()
    assert abs(back.states[-1] - [1, 0.5]).max() < 1e-12 * (there.steps + back.steps)
    times = np.linspace(7, 0, 50)
    exact = np.cos(times) + 0.5 * np.sin(times)
    assert abs(back.sample(times)[:, 0] - exact).max() < 1e-12 * (there.steps + back.steps)


def test_no_step_is_longer_than_asked():
    path = integrate(OSCILLATOR, [1, 0], 0, 10, max_step=0.05)
    assert path.lengths.max() <= 0.05 * 1.01 + 1e-15  # the last one may be stretched by a hundredth
    assert path.steps >= 198


def test_no_time_passes():
    path = integrate(OSCILLATOR, [1, 0], 3, 3)
    assert (path.status, path.steps, path.end) == (End.FINISHED, 0, 3.0)
    assert path.sample([3.0]).tolist() == [[1.0, 0.0]]


# --- quaternions and dense output ------------------------------------------------------------------


def test_quaternion_is_unit_at_and_between_steps():
    w0 = np.array([0.3, 0.0, 20.0])
    path = integrate(BODY, [2, 0, 0, 0, *w0], 0, 50, relative=1e-8, absolute=1e-8)
    four_roundings = 4 * np.finfo(float).eps
    assert abs(np.linalg.norm(path.states[:, :4], axis=1) - 1).max() < four_roundings
    between = path.sample(np.linspace(0, 50, 1003))
    assert abs(np.linalg.norm(between[:, :4], axis=1) - 1).max() < four_roundings


@pytest.mark.parametrize("dense", [True, False])
def test_states_between_steps_meet_those_at_both_ends_of_every_step(dense):
    path = integrate(BODY, [1, 0, 0, 0, 0.3, 0, 2], 0, 10, relative=1e-9, absolute=1e-9)
    just_before = path.sample(np.nextafter(path.times[1:], 0), dense)
    assert abs(just_before - path.states[1:]).max() < 1e-13
    assert (path.sample(path.times, dense) == path.states).all()


def test_states_between_steps_keep_the_tolerance():
    tolerance = 1e-9
    path = integrate(OSCILLATOR, [1, 0], 0, 20, relative=tolerance, absolute=tolerance)
    times = np.linspace(0, 20, 1000)
    assert abs(path.sample(times)[:, 0] - np.cos(times)).max() < 2 * tolerance * path.steps


def test_sampling_in_any_order_gives_the_same():
    path = integrate(OSCILLATOR, [1, 0], 0, 10)
    times = np.linspace(0, 10, 200)
    order = np.random.default_rng(0).permutation(200)
    for dense in (True, False):
        assert (path.sample(times, dense)[order] == path.sample(times[order], dense)).all()


def test_a_time_outside_the_run_is_refused():
    path = integrate(OSCILLATOR, [1, 0], 0, 10)
    with pytest.raises(
        ValueError, match=r"Expected times within the run, 0 to 10; got .*11\.0.*simulate further"
    ):
        path.sample([5, 11])
    with pytest.raises(ValueError, match="within the run"):
        path.sample([math.nan])


# --- events ----------------------------------------------------------------------------------------


def watch(kernel, n=1, directions=None, terminal=None):
    return Watch(kernel.address, directions or (0,) * n, terminal or (False,) * n)


def test_zeros_of_the_cosine_are_located():
    path = integrate(
        OSCILLATOR, [1, 0], 0, 20, relative=1e-13, absolute=1e-13, watch=watch(position_and_speed, 2)
    )
    zeros = np.array([c.time for c in path.crossings if c.number == 0])
    turns = np.array([c.time for c in path.crossings if c.number == 1])
    exact = math.pi / 2 + math.pi * np.arange(6)
    assert zeros == pytest.approx(exact, rel=1e-12)
    assert turns == pytest.approx(math.pi * np.arange(7), rel=1e-12)
    assert [c.sign for c in path.crossings if c.number == 0] == [-1, 1] * 3
    assert all(abs(c.state[0]) < 1e-14 for c in path.crossings if c.number == 0)


@pytest.mark.parametrize(("direction", "count"), [(-1, 3), (1, 3), (0, 6)])
def test_direction(direction, count):
    path = integrate(OSCILLATOR, [1, 0], 0, 20, watch=watch(shifted_zero, 1, (direction,)))
    assert len(path.crossings) == count
    if direction:
        assert {c.sign for c in path.crossings} == {direction}


@kernel
def shifted_zero(t: float, y: Reals, c: Reals, out: Reals) -> None:
    out[0] = y[0]


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-12])
def test_an_event_lies_between_its_neighbours(tolerance):
    """1e-12 before and after the event the states have the two signs, however coarse the steps are."""
    path = integrate(
        OSCILLATOR, [1, 0], 0, 20, relative=tolerance, absolute=tolerance, watch=watch(shifted_zero)
    )
    assert len(path.crossings) == 6
    for c in path.crossings:
        before, after = path.sample(np.array([1 - 1e-12, 1 + 1e-12]) * c.time)[:, 0]
        assert (np.sign(before), np.sign(after)) == (-c.sign, c.sign)
        assert abs(path.sample([c.time])[0] - c.state).max() < 1e-14


def test_backward_events_come_in_the_order_of_the_run():
    path = integrate(OSCILLATOR, [1, 0], 10, 0, relative=1e-12, absolute=1e-12, watch=watch(shifted_zero))
    times = [c.time for c in path.crossings]
    assert times == sorted(times, reverse=True)
    assert times == pytest.approx([10 - math.pi / 2 - k * math.pi for k in range(3)], rel=1e-11)


@pytest.mark.parametrize("depth", [1e-2, 1e-5, 1e-9, 1e-12])
def test_two_crossings_close_together_are_both_found(depth):
    """cos t + (1 - depth) dips below zero near t = π, for ever shorter times."""
    rates = Rates(oscillator.address, 2, np.array([1.0, 1 - depth]))
    path = integrate(rates, [1, 0], 0, 5, relative=1e-13, absolute=1e-13, watch=watch(above_bottom))
    half = math.acos(1 - depth)
    assert [c.sign for c in path.crossings] == [-1, 1]
    # dg/dt at the crossing is sin(half), so an error δ of the state moves the time by δ / sin(half)
    slack = 1e-12 / math.sin(half)
    assert [c.time for c in path.crossings] == pytest.approx([math.pi - half, math.pi + half], abs=slack)


@pytest.mark.parametrize("phase", np.linspace(0.05, 6.2, 23).tolist())
def test_a_short_dip_is_found_wherever_it_falls_in_a_step(phase):
    rates = Rates(oscillator.address, 2, np.array([1.0, 1 - 1e-7]))
    start = [math.cos(phase), -math.sin(phase)]
    path = integrate(rates, start, 0, 12.5, relative=1e-10, absolute=1e-10, watch=watch(above_bottom))
    expected = sum(0 < (2 * k + 1) * math.pi - phase < 12.5 for k in range(4))
    assert len(path.crossings) == 2 * expected


def test_a_near_miss_is_no_event():
    rates = Rates(oscillator.address, 2, np.array([1.0, 1 + 1e-6]))
    assert integrate(rates, [1, 0], 0, 20, watch=watch(above_bottom)).crossings == ()


def test_simultaneous_events_are_all_recorded_and_stop_once():
    both = watch(position_twice, 2, terminal=(True, False))
    path = integrate(OSCILLATOR, [1, 0], 0, 20, relative=1e-12, absolute=1e-12, watch=both)
    assert path.status == End.TERMINAL
    assert sorted(c.number for c in path.crossings) == [0, 1]
    assert [c.time for c in path.crossings] == pytest.approx([math.pi / 2] * 2, rel=1e-12)
    assert sorted(c.sign for c in path.crossings) == [-1, 1]


def test_a_terminal_event_stops_exactly_there():
    path = integrate(
        OSCILLATOR, [1, 0], 0, 20, relative=1e-12, absolute=1e-12, watch=watch(shifted_zero, terminal=(True,))
    )
    assert path.end == path.crossings[-1].time == pytest.approx(math.pi / 2, rel=1e-12)
    assert (path.states[-1] == path.crossings[-1].state).all()
    assert (path.sample([path.end]) == path.states[-1]).all()
    half = path.sample([path.end / 2])[0, 0]
    assert half == pytest.approx(math.cos(math.pi / 4), abs=1e-11)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
def test_a_run_that_starts_again_from_its_event_does_not_find_it_again(tolerance):
    stop = watch(shifted_zero, terminal=(True,))
    state, t, found = np.array([1.0, 0.0]), 0.0, []
    for _ in range(8):
        path = integrate(OSCILLATOR, state, t, 50, relative=tolerance, absolute=tolerance, watch=stop)
        state, t = path.states[-1], path.end
        found.append(t)
    assert found == pytest.approx((math.pi / 2 + math.pi * np.arange(8)).tolist(), rel=20 * tolerance)


def test_an_event_at_the_start_is_recorded_once_and_does_not_stop():
    path = integrate(OSCILLATOR, [0, 1], 0, 2, watch=watch(shifted_zero, terminal=(True,)))
    assert [(c.time, c.sign) for c in path.crossings] == [(0.0, 1)]
    assert path.end == 2.0
    down = integrate(OSCILLATOR, [0, 1], 0, 2, watch=watch(shifted_zero, directions=(-1,)))
    assert down.crossings == ()


@pytest.mark.parametrize("parts", [1, 4, 8])
def test_an_event_exactly_at_the_end_of_a_step_is_recorded_once(parts):
    rates = Rates(constant_rate.address, 1, np.array([1.0]))
    inside = integrate(rates, [0], 0, 2, max_step=1 / parts, first_step=1 / parts, watch=watch(clock))
    assert inside.times[parts] == 1.0
    assert [(c.time, c.sign) for c in inside.crossings] == [(1.0, 1)]
    at_end = integrate(rates, [0], 0, 1, max_step=1 / parts, first_step=1 / parts, watch=watch(clock))
    assert [(c.time, c.sign) for c in at_end.crossings] == [(1.0, 1)]


def test_a_function_that_is_always_zero_gives_no_events():
    assert integrate(OSCILLATOR, [0, 0], 0, 5, watch=watch(position_and_speed, 2)).crossings == ()


def test_many_events_overflow_no_buffer():
    rates = Rates(oscillator.address, 2, np.array([1e4]))
    path = integrate(rates, [1, 0], 0, 30, watch=watch(position_and_speed, 2))
    assert len(path.crossings) == int(30 * 100 / math.pi + 0.5) + int(30 * 100 / math.pi) + 1


# --- ends other than the wanted one ----------------------------------------------------------------


def test_a_motion_that_leaves_every_bound_collapses_and_names_its_component():
    path = integrate(Rates(blow_up.address, 2, np.zeros(1)), [0, 1], 0, 2)
    assert path.status in (End.COLLAPSED, End.NOT_FINITE)
    assert path.blame == 1
    assert path.end == pytest.approx(1, abs=1e-6)
    assert np.isfinite(path.states).all()
    assert path.sample([0.5])[0, 1] == pytest.approx(2, rel=1e-8)


def test_rates_that_are_not_numbers_stop_the_run():
    path = integrate(Rates(square_root.address, 1, np.array([1.0])), [0], 0, 2)
    assert path.status == End.NOT_FINITE
    assert path.blame == 0
    assert path.end == pytest.approx(1, abs=1e-9)
    assert path.states[-1, 0] == pytest.approx(2 / 3, abs=1e-8)


def test_rates_that_are_not_numbers_at_the_start():
    path = integrate(Rates(square_root.address, 1, np.array([-1.0])), [0], 0, 2)
    assert (path.status, path.end, path.steps) == (End.NOT_FINITE, 0.0, 0)


def test_step_limit():
    path = integrate(OSCILLATOR, [1, 0], 0, 1e6, max_steps=100)
    assert (path.status, path.steps) == (End.TOO_MANY_STEPS, 100)


def test_an_interruption_keeps_what_was_computed():
    reached = []

    def between(t):
        reached.append(t)
        if len(reached) == 3:
            raise KeyboardInterrupt

    path = integrate(OSCILLATOR, [1, 0], 0, 1e9, between=between)
    assert path.status == End.INTERRUPTED
    assert path.end == reached[-1] > reached[0]
    t = path.end / 2
    assert path.sample([t])[0, 0] == pytest.approx(math.cos(t), abs=1e-9 * path.steps * 2)


@pytest.fixture
def keyboard():
    """Ctrl-C interrupts, also where the tests run in the background and their parent ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("keyboard")
def test_ctrl_c_at_any_moment_keeps_a_path_that_fits_together():
    """The keyboard interrupts while machine code runs; Python notices when it returns."""
    timer = threading.Timer(0.25, _thread.interrupt_main)
    timer.start()
    path = integrate(OSCILLATOR, [1, 0], 0, 1e9)
    timer.join()
    assert path.status == End.INTERRUPTED
    assert 0 < path.end < 1e9
    assert path.times[:-1] + path.lengths == pytest.approx(path.times[1:], rel=1e-15)
    times = path.end - np.linspace(0, 10, 50)
    assert np.hypot(*path.sample(times).T) == pytest.approx(1, abs=2e-9 * path.steps)


def test_pieces_do_not_change_the_result():
    rates = Rates(oscillator.address, 2, np.array([1e4]))
    long = integrate(rates, [1, 0], 0, 30)
    assert long.steps > 1000  # several pieces
    again = integrate(rates, [1, 0], 0, 30, between=lambda t: None)
    assert (long.states == again.states).all()
    assert (np.diff(long.times) > 0).all()
    assert long.times[:-1] + long.lengths == pytest.approx(long.times[1:], rel=1e-15)


# --- memory that runs share ------------------------------------------------------------------------


def same(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("times", "lengths", "states"))


def test_a_run_leaves_nothing_to_the_next():
    """Of the same shape, after one that ended with numbers that are not finite."""
    rates = Rates(oscillator.address, 2, np.array([1.0]))
    first = integrate(rates, [1, 0], 0, 20, relative=1e-10)
    kept = first.states.copy()
    assert integrate(Rates(blow_up.address, 2, np.zeros(1)), [0, 1], 0, 2).status != End.FINISHED
    again = integrate(rates, [1, 0], 0, 20, relative=1e-10)
    assert same(first, again)
    assert np.array_equal(first.states, kept)
    watched = integrate(rates, [1, 0], 0, 20, relative=1e-10, watch=watch(shifted_zero))
    integrate(rates, [2, 0], 0, 20, relative=1e-10, watch=watch(shifted_zero, directions=(1,)))
    after = integrate(rates, [1, 0], 0, 20, relative=1e-10, watch=watch(shifted_zero))
    assert [(c.time, c.sign) for c in after.crossings] == [(c.time, c.sign) for c in watched.crossings]


def test_constants_are_read_where_they_lie():
    """The loop is told their address, so they have to stand one behind the other."""
    with pytest.raises(TypeError, match="Expected a contiguous array of float64"):
        integrate(Rates(oscillator.address, 2, np.ones(4)[::2]), [1, 0], 0, 1)


def test_a_run_between_two_pieces_of_another():
    rates = Rates(oscillator.address, 2, np.array([1e4]))
    alone, inner = integrate(rates, [1, 0], 0, 30), []
    nested = integrate(
        rates, [1, 0], 0, 30, between=lambda t: inner.append(integrate(rates, [0, 1], 0, 1).states[-1])
    )
    assert alone.steps > 1000 and len(inner) >= 1
    assert same(alone, nested)
    assert np.array_equal(inner[-1], integrate(rates, [0, 1], 0, 1).states[-1])


def test_runs_of_several_threads():
    rates = [Rates(oscillator.address, 2, np.array([float(k)])) for k in range(1, 5)]
    alone = [integrate(one, [1, 0], 0, 50, relative=1e-11) for one in rates]
    wrong = []

    def work(k):
        for _ in range(200):
            if not same(integrate(rates[k], [1, 0], 0, 50, relative=1e-11), alone[k]):
                wrong.append(k)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def test_paths_hold_their_steps_and_no_more():
    """A path of m steps of n numbers is m (n + 2) of them, and less than 6 kB besides."""
    integrate(OSCILLATOR, [1, 0], 0, 20)
    tracemalloc.start()
    try:
        paths = [integrate(OSCILLATOR, [1, 0], 0, 20) for _ in range(50)]
        held, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert held < sum(8 * 4 * (path.steps + 1) + 6000 for path in paths)
