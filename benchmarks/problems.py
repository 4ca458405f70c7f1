"""(e) Reference problems of the field, with the value each is judged by, where it comes from, and the error reached."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from . import minimal
from .tables import show, time_text

IFTOMM = "IFToMM library"
"""Of computational benchmark problems: González, Dopico, Lugrís & Cuadrado (2006).

Data as documented in MBSbenchmarksInOpenSim (RehabEngGroup), which shows the published solutions as plots only.
"""


class Reached(NamedTuple):
    """Reference value at the end, in words; greatest error over the times compared; seconds of ``fb.simulate``."""

    reference: str
    error: float
    seconds: float


def timed(system: Any, until: float, **options: Any) -> tuple[Any, float]:
    """Motion, and the time of the whole ``fb.simulate`` call, its machine code being made beforehand."""
    import freebody as fb

    fb.simulate(system, until, **options)
    begin = time.perf_counter()
    motion = fb.simulate(system, until, **options)
    return motion, time.perf_counter() - begin


@dataclass(frozen=True)
class Problem:
    """A reference problem.

    ``run(setting)`` -> what it reached; ``judged``: what the error is of; ``source``: of the problem and of the value.
    """

    title: str
    judged: str
    source: str
    setting: float
    run: Callable[[float], Reached]
    """With the setting: a tolerance, or the length of the steps [s] where these are of one length."""
    stepped: bool = False
    long: bool = False
    """Left out with ``--quick``."""


# --- simple pendulum -----------------------------------------------------------------------------


def simple_pendulum() -> Any:
    """A point mass of 1 kg on a massless rod of 1 m."""
    import freebody as fb

    s = fb.System("simple pendulum")
    m, L, g = s.parameters(m=1.0, L=1.0, g=9.81)
    s.gravity = (0, -g, 0)
    s.hinge("O", s.ground, s.body("bob", fb.particle(m)), to=(0, L, 0), axis="z", coordinate="theta")
    return s


def pendulum_reached(tolerance: float) -> Reached:
    """Let go with the rod horizontal: angle in 10 s [rad]."""
    import freebody as fb

    motion, seconds = timed(
        simple_pendulum(), 10, initial={"theta": "90deg"}, tolerance=tolerance, samples=201
    )
    exact, _ = fb.exact.pendulum(np.pi / 2, np.sqrt(9.81), motion.t)
    return Reached(f"theta = {exact[-1]:.12f}", float(np.abs(motion["theta"] - exact).max()), seconds)


# --- N four-bars ---------------------------------------------------------------------------------


def four_bars(n: int) -> Any:
    """A row of ``n`` parallelograms of rods of 1 m and 1 kg: n + 1 cranks on the ground, n couplers, n loops.

    All cranks are parallel and the couplers do not turn, so that one angle describes the motion; here every joint is a
    hinge, and closing the loops is left to the library. The angle of the first crank is from the horizontal.
    """
    import freebody as fb

    s = fb.System(f"{n} four-bars")
    s.gravity = (0, -9.81, 0)

    def rod(name: str) -> Any:
        return s.body(name, fb.slender_bar(1, 1, axis="x"))

    crank = rod("crank0")
    s.hinge("A0", s.ground, crank, to=(-0.5, 0, 0), axis="z", coordinate="phi0")
    for i in range(1, n + 1):
        coupler, following = rod(f"coupler{i}"), rod(f"crank{i}")
        s.hinge(f"B{i}", crank, coupler, at=(0.5, 0, 0), to=(-0.5, 0, 0), axis="z", coordinate=f"beta{i}")
        s.hinge(f"A{i}", s.ground, following, at=(i, 0, 0), to=(-0.5, 0, 0), axis="z", coordinate=f"phi{i}")
        s.hinge(f"C{i}", coupler, following, at=(0.5, 0, 0), to=(0.5, 0, 0), axis="z")
        crank = following
    return s


def four_bars_start(n: int) -> dict[str, float]:
    """Cranks upright, ends moving along x at 1 m/s."""
    start = {"phi0": np.pi / 2, "phi0'": -1.0}
    for i in range(1, n + 1):
        start |= {f"phi{i}": np.pi / 2, f"beta{i}": -np.pi / 2, f"phi{i}'": -1.0, f"beta{i}'": 1.0}
    return start


def four_bars_reached(n: int, until: float, step: float) -> Reached:
    """Angle of the first crank [rad].

    Whenever the cranks are level, n + 1 motions are possible at once and the constraints have no direction there: step
    control would close in on that moment. Steps of one length pass it.
    """
    motion, seconds = timed(
        four_bars(n), until, initial=four_bars_start(n), method="dop853", step=step, samples=101
    )
    exact = minimal.four_bars(n, motion.t)
    return Reached(f"phi = {exact[-1]:.12f}", float(np.abs(motion["phi0"] - exact).max()), seconds)


# --- Andrews' squeezing mechanism ----------------------------------------------------------------

ANDREWS_START = {
    "beta": -0.0617138900142764496358948458001,
    "Theta": 0.0,
    "gamma": 0.455279819163070380255912382449,
    "Phi": 0.222668390165885884674473185609,
    "delta": 0.487364979543842550225598953530,
    "Omega": -0.222668390165885884674473185609,
    "epsilon": 1.23054744454982119249735015568,
}
ANDREWS_END = {
    "beta": 15.81077119629904,
    "Theta": -15.75637105984298,
    "gamma": 0.04082224013073101,
    "Phi": -0.5347301163226948,
    "delta": 0.5244099658805304,
    "Omega": 0.5347301163226948,
    "epsilon": 1.048080741042263,
}


def andrews() -> Any:
    """Seven plane bodies on three fixed points, driven by a constant torque, held by a spring."""
    import freebody as fb

    s = fb.System("Andrews' squeezer")

    def body(name: str, m: float, inertia: float, x: float, y: float) -> Any:
        return s.body(
            name, fb.MassProperties(m, (x, y, 0), ((inertia, 0, 0), (0, inertia, 0), (0, 0, inertia)))
        )

    A, B, C = (-0.06934, -0.00227, 0), (-0.03635, 0.03273, 0), (0.014, 0.072, 0)
    d, e, f, r, u = 0.028, 0.02, 0.02, 0.007, 0.04
    k1 = body("K1", 0.04325, 2.194e-6, 0.00092, 0)
    k2 = body("K2", 0.00365, 4.410e-7, -0.0115, 0)
    k3 = body("K3", 0.02373, 5.255e-6, 0.01043, -0.01874)
    k4 = body("K4", 0.00706, 5.667e-7, 0, -(0.02 - 0.01421))
    k5 = body("K5", 0.07050, 1.169e-5, 0.02308, 0.00916)
    k6 = body("K6", 0.00706, 5.667e-7, 0.02 - 0.01421, 0)
    k7 = body("K7", 0.05498, 1.912e-5, -0.00449, -0.01228)
    s.hinge("O", s.ground, k1, axis="z", coordinate="beta")
    s.hinge("F", k1, k2, at=(r, 0, 0), axis="z", coordinate="Theta")
    s.hinge("B", s.ground, k3, at=B, axis="z", coordinate="gamma")
    s.hinge("A5", s.ground, k5, at=A, axis="z", coordinate="delta")
    s.hinge("H", k5, k4, at=(0.04, 0, 0), axis="z", coordinate="Phi")
    s.hinge("A7", s.ground, k7, at=A, axis="z", coordinate="epsilon")
    s.hinge("G", k7, k6, at=(0, -u, 0), axis="z", coordinate="Omega")
    for name, other, place in (("E3", k3, (0, -0.035, 0)), ("E4", k4, (0, -e, 0)), ("E6", k6, (f, 0, 0))):
        s.hinge(name, k2, other, at=(-d, 0, 0), to=place, axis="z")
    s.torque("drive", k1, (0, 0, 0.033))
    s.spring("spring", s.ground.point(*C), k3.point(0.02, -0.018, 0), stiffness=4530, rest=0.07785)
    return s


def andrews_reached(tolerance: float) -> Reached:
    """Relative error of the seven angles at t = 0.03 s."""
    start = {name: x for name, x in ANDREWS_START.items()}
    held = {name: start.pop(name) for name in ("Theta",)}
    motion, seconds = timed(andrews(), 0.03, initial=held, near=start, tolerance=tolerance, times=[0.03])
    error = max(abs(float(motion[name][0]) / x - 1) for name, x in ANDREWS_END.items())
    return Reached(f"beta = {ANDREWS_END['beta']:.14f}", error, seconds)


# --- Bricard's mechanism -------------------------------------------------------------------------


def bricard() -> Any:
    """Five rods of 1 m, 0.1 m square and 1 kg along edges of a cube, the sixth being the ground; six hinges.

    By counting, no motion is left: five angles, five conditions of closure. One of these is redundant.
    """
    import freebody as fb

    s = fb.System("Bricard's mechanism")
    s.gravity = (0, -9.81, 0)
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]])
    before, center = s.ground, np.zeros(3)
    for i, axis in enumerate("yzxyz"):
        along = np.abs(corners[i + 1] - corners[i])
        rod = s.body(f"rod{i + 1}", fb.box(1, [1.0 if long else 0.1 for long in along]))
        middle = (corners[i] + corners[i + 1]) / 2
        at, to = corners[i] - center, corners[i] - middle
        s.hinge(f"J{i + 1}", before, rod, at=tuple(at), to=tuple(to), axis=axis, coordinate=f"q{i + 1}")
        before, center = rod, middle
    s.hinge("J6", before, s.ground, at=tuple(corners[5] - center), to=tuple(corners[5]), axis="x")
    return s


def bricard_reached(tolerance: float) -> Reached:
    """Let go from rest: place of the joint between the third and the fourth rod in 10 s [m]."""
    start = {f"q{i}": 0.0 for i in range(1, 6)} | {f"q{i}'": 0.0 for i in range(1, 6)}
    motion, seconds = timed(bricard(), 10, initial=start, tolerance=tolerance, samples=101)
    pose = motion.poses["rod4"]
    joint = pose.position + pose.rotation @ np.array([0.5, 0.0, 0.0])
    expected = minimal.bricard(motion.t)
    return Reached(f"y = {expected[-1, 1]:.12f}", float(np.abs(joint - expected).max()), seconds)


# --- flyball governor ----------------------------------------------------------------------------


def flyball() -> Any:
    """A turning shaft with two rods and balls; springs and dampers instead of coupling rods lead to the slider."""
    import freebody as fb

    s = fb.System("flyball governor")
    s.gravity = (0, 0, -9.81)
    shaft = s.body("shaft", fb.box(0.3, (0.01, 0.01, 1)))
    slider = s.body("slider", fb.box(3, (0.1, 0.1, 0.1)))
    s.hinge("bearing", s.ground, shaft, to=(0, 0, -0.5), axis="z", coordinate="phi")
    s.slider("sleeve", shaft, slider, at=(0, 0, -0.5), axis="z", coordinate="s")
    for name, side in (("1", 1), ("2", -1)):
        rod, ball = s.body(f"rod{name}", fb.box(0.3, (1, 0.01, 0.01))), s.body(f"ball{name}", fb.particle(5))
        s.hinge(
            f"pin{name}", shaft, rod, at=(0.05 * side, 0, 0.5), to=(-0.5 * side, 0, 0), axis=(0, side, 0),
            coordinate=f"alpha{name}",
        )  # fmt: skip
        s.weld(f"tip{name}", rod, ball, at=(0.5 * side, 0, 0))
        ends = slider.point(0.05 * side, 0, 0), rod.point(0, 0, 0)
        s.spring(f"spring{name}", *ends, stiffness=8e5, rest=0.5)
        s.damper(f"damper{name}", *ends, damping=4e4)
    return s


def flyball_reached(tolerance: float, until: float = 10.0) -> Reached:
    """Rods 30° below the horizontal, slider 0.5 m high, one turn per second: height of the slider [m]."""
    start = {"phi": 0.0, "phi'": 2 * np.pi, "s": 0.5, "alpha1": np.pi / 6, "alpha2": np.pi / 6}
    motion, seconds = timed(flyball(), until, initial=start, tolerance=tolerance, samples=101)
    expected = minimal.flyball(motion.t)
    return Reached(f"s = {expected[-1]:.12f}", float(np.abs(motion["s"] - expected).max()), seconds)


# --- heavy top of the Lie-group literature -------------------------------------------------------


def lie_top() -> Any:
    """15 kg, mass centre 1 m along y from the fixed point, J = diag(0.234375, 0.46875, 0.234375) kg m² about it."""
    import freebody as fb

    s = fb.System("heavy top")
    s.gravity = (0, 0, -9.81)
    J = ((0.234375, 0, 0), (0, 0.46875, 0), (0, 0, 0.234375))
    body = s.body("top", fb.MassProperties(15, (0, 1, 0), J))
    s.ball("O", s.ground, body)
    return s


def lie_top_reached(tolerance: float) -> Reached:
    """Place of the mass centre in 2 s, against the closed form [m]."""
    import freebody as fb

    start = {"O_wx": 0.0, "O_wy": 150.0, "O_wz": -4.61538}
    motion, seconds = timed(lie_top(), 2, initial=start, tolerance=tolerance, samples=101)
    path = fb.exact.top(15 + 0.234375, 0.46875, 15 * 9.81, np.pi / 2, 150.0, 0.0, -4.61538)
    # the axis begins along Y: psi is counted from there
    theta, psi = path.theta(motion.t), path.psi(motion.t)
    exact = np.stack([-np.sin(theta) * np.sin(psi), np.sin(theta) * np.cos(psi), np.cos(theta)], axis=1)
    centre = motion.poses["top"].rotation @ np.array([0.0, 1.0, 0.0])
    return Reached(f"z = {exact[-1, 2]:.12f}", float(np.abs(centre - exact).max()), seconds)


PROBLEMS = (
    Problem(
        "Simple pendulum, 90°, 10 s", "angle", f"{IFTOMM}, A01; Jacobi's elliptic functions", 1e-12,
        pendulum_reached,
    ),
    Problem(
        "2 four-bars, 1 m/s, 10 s, through singular positions", "angle",
        f"{IFTOMM}, A02 (N = 2); elliptic functions, since one angle describes it", 0.01,
        partial(four_bars_reached, 2, 10.0), stepped=True,
    ),
    Problem(
        "40 four-bars, 1 m/s, 10 s, through singular positions", "angle",
        f"{IFTOMM}, A02 (N = 40); elliptic functions", 0.04, partial(four_bars_reached, 40, 10.0),
        stepped=True, long=True,
    ),
    Problem(
        "Andrews' squeezer, 0.03 s", "seven angles, relative",
        f"{IFTOMM}, A03; Hairer & Wanner (1996), VII.7; end values: Mazzia, Magherini & Iavernaro (2006), andrews.f "
        "(PSIDE at 1e-14)", 1e-12, andrews_reached,
    ),
    Problem(
        "Bricard's mechanism, 10 s", "joint between rods 3 and 4 (m)",
        f"{IFTOMM}, A04; no published digits: closed curve of its configurations, one equation, by SciPy's DOP853 at "
        "1e-13", 1e-12, bricard_reached,
    ),
    Problem(
        "Flyball governor, 10 s", "height of the slider (m)",
        f"{IFTOMM}, A05; no published digits: its equations in two coordinates, by SciPy's Radau at 1e-12", 1e-12,
        flyball_reached,
    ),
    Problem(
        "Heavy top, 150 rad/s, 2 s", "mass centre (m)",
        "Brüls, Cardona & Arnold (2012); closed form of the symmetric top", 1e-12, lie_top_reached,
    ),
)  # fmt: skip


def main(quick: bool = False, repeats: int = 5, limit: float = 0.0) -> None:
    """Print the table."""
    del limit, repeats
    rows: list[list[Any]] = []
    for problem in PROBLEMS:
        if quick and problem.long:
            continue
        reached = problem.run(problem.setting)
        said = f"step {problem.setting:g} s" if problem.stepped else f"tolerance {problem.setting:.0e}"
        rows.append(
            [problem.title, problem.judged, said, reached.reference, f"{reached.error:.1e}",
             time_text(reached.seconds), problem.source]
        )  # fmt: skip
    show(
        "Reference problems",
        [
            "",
            "error of",
            "setting",
            "reference value at the end",
            "error",
            "time",
            "problem; reference value",
        ],
        rows,
        [
            "IFToMM library: of computational benchmark problems, González, Dopico, Lugrís & Cuadrado (2006).",
            "error: the greatest at 101 times or more; of Andrews' squeezer, at its end.",
            "time: the whole fb.simulate call, its machine code being made.",
        ],
    )
