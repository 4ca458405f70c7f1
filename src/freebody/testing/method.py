"""The battery of a method of integration: its order, its error control, its events and its states between steps."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..describe.system import System
from ..errors import SimulationError
from ..motion.ode.layout import ORDERS
from ..motion.ode.tableau import RungeKutta
from ..space.solids import box, cylinder, slender_bar

EPS = float(np.finfo(float).eps)
NEAR = 0.35
"""Greatest difference of a measured order from the order of a method."""
COARSEST = 1e-5
"""Error from which on an order is measured, relative to the coordinates and speeds."""
POINTS = 4
"""Numbers of steps, each twice the one before, whose errors tell the order: one alone may pass through zero."""
PLACES = 8
"""Times of a run at which errors are compared."""
MOST = 2**14
"""Most steps of a measurement."""
EXACT = 1e-15
"""Tolerance of the solution by order 16 to which methods are compared."""


def heavy_top(joint: str = "gimbal") -> System:
    """Return a heavy top with Euler angles, or with a unit quaternion."""
    s = System("heavy top")
    s.gravity = (0, 0, -9.81)
    top = s.body("top", cylinder(1, 0.1, 0.3, axis="z"))
    if joint == "gimbal":
        s.gimbal("o", s.ground, top, to=(0, 0, -0.3), axis="ZXZ", coordinate="psi theta phi")
    else:
        s.ball("o", s.ground, top, to=(0, 0, -0.3))
    return s


def tumbling_body() -> System:
    """Return a free body with three different moments of inertia."""
    s = System("tumbling body")
    s.free("f", s.ground, s.body("box", box(2, (0.3, 0.2, 0.1))))
    return s


def four_bar() -> System:
    """Return a four-bar linkage, whose states are projected onto its constraints."""
    s = System("four-bar")
    s.gravity = (0, -9.81, 0)
    crank, rod, rocker = (
        s.body(name, slender_bar(1, length)) for name, length in (("crank", 1), ("rod", 2), ("rocker", 2))
    )
    s.hinge("A", s.ground, crank, to=(-0.5, 0, 0), coordinate="a")
    s.hinge("B", crank, rod, at=(0.5, 0, 0), to=(-1, 0, 0), coordinate="b")
    s.hinge("D", s.ground, rocker, at=(2, 0, 0), to=(-1, 0, 0), coordinate="d")
    s.hinge("C", rocker, rod, at=(1, 0, 0), to=(1, 0, 0))
    return s


MACHINES: dict[str, tuple[Callable[[], System], dict[str, Any], float]] = {
    "heavy top": (heavy_top, {"initial": {"theta": 0.5, "phi'": 20.0, "psi'": 0.3}}, 0.4),
    "ball": (
        lambda: heavy_top("ball"),
        {"initial": {"o": (math.cos(0.25), math.sin(0.25), 0, 0), "o_wz": 20.0, "o_wx": 0.3}},
        0.4,
    ),
    "tumbling": (tumbling_body, {"initial": {"f_wx": 0.1, "f_wy": 5.0, "f_wz": 0.2, "f_vx": 1.0}}, 1.0),
    "four-bar": (four_bar, {"initial": {"a": 0.3, "a'": 3.0}, "near": {"b": 0.4, "d": 0.9}}, 0.8),
}
"""Machines by name, each with the start and the length of a run."""


def check_method(method: RungeKutta | str) -> None:
    """Check a method of integration on four machines.

    Its error falls with the power of the step's length that its order says, on machines with angles, quaternions and
    constraints; it follows the tolerance; events and states between steps are those of order 16; a batch is the same
    as its motions alone.

    Parameters
    ----------
    method : RungeKutta or str
        A method, or its name.

    Raises
    ------
    AssertionError
        It says which promise does not hold.

    Examples
    --------
    >>> check_method("tsit5")
    """
    name = method.name if isinstance(method, RungeKutta) else method
    check_order(name)
    _tolerances(name)
    _events(name)
    _batch(name)


def measured_order(method: str, machine: str) -> float:
    """Return the power of the step's length with which the greatest error of a run falls."""
    from ..studies.simulate import simulate

    make, start, until = MACHINES[machine]
    s = make()
    # at several times, since the leading term of the error may pass through zero at one of them
    exact = simulate(s, until, method="gauss", tolerance=EXACT, samples=PLACES + 1, **start).states
    size = float(np.abs(exact).max())

    def error(n: int) -> float:
        try:  # the tolerance bounds the iterations only
            run = simulate(s, until, method=method, step=until / n, tolerance=10 * EXACT, samples=2, **start)
        except SimulationError as error:
            if "converge" not in str(error):
                raise
            return math.inf  # the iteration of so long a step does not converge
        if run.steps != n:
            raise AssertionError(f"{method}: expected {n} steps of one length, got {run.steps}.")
        return float(np.abs(run.path.states[:: n // PLACES] - exact).max()) / size

    errors: list[float] = []
    n = PLACES
    while len(errors) < POINTS:
        if n > MOST:
            raise AssertionError(
                f"{method}: expected an error below {COARSEST:g} of '{machine}' in {MOST} steps, got {error(MOST):.3g}."
            )
        found = error(n)
        if found < 30 * EPS:
            break
        if found < COARSEST:
            errors.append(found)
        n *= 2
    if len(errors) < 2:
        raise AssertionError(f"{method}: its errors of '{machine}' are round-off at once, and tell no order.")
    return -float(np.polyfit(range(len(errors)), np.log2(errors), 1)[0])


def check_order(method: str) -> None:
    """Raise AssertionError if the errors do not fall as the order of a method says."""
    order = ORDERS[method]
    measured = {machine: measured_order(method, machine) for machine in MACHINES}
    worst = min(measured, key=measured.__getitem__)
    # on one machine the leading term of the error may be small, but not on all
    if not order - NEAR < measured[worst] < order + 1 - NEAR:
        raise AssertionError(
            f"{method}: expected errors that fall with the power {order} of the step, its order, got the power "
            f"{measured[worst]:.2f} for '{worst}'."
        )


def _tolerances(method: str) -> None:
    """The error follows the tolerance."""
    from ..studies.simulate import simulate

    make, start, until = MACHINES["heavy top"]
    s = make()
    end = simulate(s, until, method="gauss", tolerance=EXACT, samples=2, **start).path.states[-1]
    for tolerance in (1e-4, 1e-6, 1e-8):
        run = simulate(s, until, method=method, tolerance=tolerance, samples=2, **start)
        error = float(np.abs(run.path.states[-1] - end).max())
        # coordinates reach 8, speeds 20; the errors of the steps add up
        if error > 1000 * tolerance:
            raise AssertionError(
                f"{method}: expected an error of at most {1000 * tolerance:g} for the tolerance {tolerance:g}, got "
                f"{error:.3g}. Its embedded weights are those of an error that is too small."
            )


def _events(method: str) -> None:
    """Events and states between steps, against those of order 16."""
    from ..studies.simulate import simulate

    make, start, until = MACHINES["heavy top"]
    s = make()
    event = "theta - 0.55"
    exact = simulate(s, until, method="gauss", tolerance=EXACT, samples=41, events=[event], **start)
    run = simulate(s, until, method=method, tolerance=1e-8, samples=41, events=[event], **start)
    times, expected = ([x.time for x in motion.events] for motion in (run, exact))
    if len(times) != len(expected) or not np.allclose(times, expected, rtol=0, atol=1e-5):
        raise AssertionError(f"{method}: expected events at {expected}, got {times}.")
    error = float(np.abs(run.states - exact.states).max())
    if error > 1e-5:
        raise AssertionError(
            f"{method}: expected states between steps within 1e-5, got an error of {error:.3g}."
        )


def _batch(method: str) -> None:
    """Lanes of a batch, against motions alone."""
    from ..studies.simulate import simulate

    s = heavy_top()
    theta = np.linspace(0.4, 0.6, 9)
    start = {"phi'": 20.0, "psi'": 0.3}
    many = simulate(
        s, 0.4, method=method, tolerance=1e-7, initial={"theta": theta, **start}, outputs=["theta"], samples=2
    )
    for k in (0, 8):
        one = simulate(
            s, 0.4, method=method, tolerance=1e-7, initial={"theta": float(theta[k]), **start}, samples=2
        )
        a, b = float(many["theta"][k, -1]), float(one["theta"][-1])
        if abs(a - b) > 1e-10:
            raise AssertionError(
                f"{method}: expected lane {k} of a batch to be its motion alone, got {a} and {b}."
            )
