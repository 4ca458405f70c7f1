"""(e) Reference problems of the field, with the value each is judged by, where it comes from, and the error reached."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .tables import show, time_text

IFTOMM = "IFToMM library of computational benchmark problems"


@dataclass(frozen=True)
class Problem:
    """A reference problem.

    ``run(tolerance)`` -> error; ``judged``: what the error is of; ``source``: of the problem and of the value.
    """

    title: str
    judged: str
    source: str
    tolerance: float | str
    run: Callable[[Any], float]


# --- simple pendulum -----------------------------------------------------------------------------


def simple_pendulum() -> Any:
    """A point mass of 1 kg on a massless rod of 1 m."""
    import freebody as fb

    s = fb.System("simple pendulum")
    m, L, g = s.parameters(m=1.0, L=1.0, g=9.81)
    s.gravity = (0, -g, 0)
    s.hinge("O", s.ground, s.body("bob", fb.particle(m)), to=(0, L, 0), axis="z", coordinate="theta")
    return s


def pendulum_error(tolerance: float) -> float:
    """Let go with the rod horizontal: greatest error of the angle in 10 s [rad]."""
    import freebody as fb

    motion = fb.simulate(simple_pendulum(), 10, initial={"theta": "90deg"}, tolerance=tolerance, samples=201)
    exact, _ = fb.exact.pendulum(np.pi / 2, np.sqrt(9.81), motion.t)
    return float(np.abs(motion["theta"] - exact).max())


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


def four_bars_exact(n: int, t: Any) -> np.ndarray:
    """Angle of the cranks: a pendulum that turns over.

    ½ ((n + 1)/3 + n) m L² φ'² + ((n + 1)/2 + n) m g L sin φ is constant. With a = angle from the lowest position, k the
    modulus and w² = rate²: a'² = a'₀² + 2 w² (cos a - cos a₀), a = 2 am(w t / k + u₀), k² = 4 w²/(a'² at the bottom).
    """
    from scipy.special import ellipj, ellipk

    inertia, moment = (n + 1) / 3 + n, (n + 1) / 2 + n
    rate2 = moment * 9.81 / inertia
    lowest2 = 1.0 + 4 * rate2  # a'² at the bottom: from a' = -1 upright
    m = 4 * rate2 / lowest2
    # upright, a = π, is half a turn: am = K; the crank turns clockwise, φ = π/2 - (a - π)
    amplitude = ellipj(0.5 * np.sqrt(lowest2) * np.asarray(t) + ellipk(m), m)[3]
    return np.pi / 2 - (2 * amplitude - np.pi)


def four_bars_error(n: int, until: float, step: float) -> float:
    """Greatest error of the first crank's angle [rad].

    Whenever the cranks are level, n + 1 motions are possible at once and the constraints have no direction there: step
    control would close in on that moment. Steps of one length pass it.
    """
    import freebody as fb

    motion = fb.simulate(
        four_bars(n), until, initial=four_bars_start(n), method="dop853", step=step, samples=101
    )
    return float(np.abs(motion["phi0"] - four_bars_exact(n, motion.t)).max())


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


def andrews_error(tolerance: float) -> float:
    """Greatest relative error of the seven angles at t = 0.03 s."""
    import freebody as fb

    start = {name: x for name, x in ANDREWS_START.items()}
    held = {name: start.pop(name) for name in ("Theta",)}
    motion = fb.simulate(andrews(), 0.03, initial=held, near=start, tolerance=tolerance, times=[0.03])
    return max(abs(float(motion[name][0]) / x - 1) for name, x in ANDREWS_END.items())


# --- heavy top of the Lie-group literature -------------------------------------------------------


def lie_top(ball: bool = True) -> Any:
    """15 kg, mass centre 1 m along y from the fixed point, J = diag(0.234375, 0.46875, 0.234375) kg m² about it."""
    import freebody as fb

    s = fb.System("heavy top")
    s.gravity = (0, 0, -9.81)
    J = ((0.234375, 0, 0), (0, 0.46875, 0), (0, 0, 0.234375))
    body = s.body("top", fb.MassProperties(15, (0, 1, 0), J))
    s.ball("O", s.ground, body)
    return s


def lie_top_error(tolerance: float) -> float:
    """Greatest error of the mass centre's position in 2 s, against the closed form [m]."""
    import freebody as fb

    start = {"O_wx": 0.0, "O_wy": 150.0, "O_wz": -4.61538}
    motion = fb.simulate(lie_top(), 2, initial=start, tolerance=tolerance, samples=101)
    path = fb.exact.top(15 + 0.234375, 0.46875, 15 * 9.81, np.pi / 2, 150.0, 0.0, -4.61538)
    # the axis begins along Y: psi is counted from there
    theta, psi = path.theta(motion.t), path.psi(motion.t)
    exact = np.stack([-np.sin(theta) * np.sin(psi), np.sin(theta) * np.cos(psi), np.cos(theta)], axis=1)
    centre = motion.poses["top"].rotation @ np.array([0.0, 1.0, 0.0])
    return float(np.abs(centre - exact).max())


PROBLEMS = (
    Problem(
        "Simple pendulum, 90°, 10 s", "angle", f"{IFTOMM}, A01; Jacobi's elliptic functions", 1e-12, pendulum_error
    ),
    Problem(
        "2 four-bars, 1 m/s, 10 s, through singular positions", "angle",
        f"{IFTOMM}, A02 (N = 2); elliptic functions, since one angle describes it", "step 0.01 s",
        lambda setting: four_bars_error(2, 10.0, 0.01),
    ),
    Problem(
        "Andrews' squeezer, 0.03 s", "seven angles, relative",
        f"{IFTOMM}, A03; Hairer & Wanner II (1996), VII.7; end values of the Bari test set for IVP solvers", 1e-12,
        andrews_error,
    ),
    Problem(
        "Heavy top, 150 rad/s, 2 s", "mass centre (m)",
        "Brüls, Cardona & Arnold (2012); closed form of the symmetric top", 1e-12, lie_top_error,
    ),
)  # fmt: skip


def main(quick: bool = False, repeats: int = 5, limit: float = 0.0) -> None:
    """Print the table."""
    del limit, quick, repeats
    rows: list[list[Any]] = []
    for problem in PROBLEMS:
        problem.run(1e-9)  # the machine code is made here
        begin = time.perf_counter()
        error = problem.run(problem.tolerance)
        said = problem.tolerance if isinstance(problem.tolerance, str) else f"{problem.tolerance:.0e}"
        rows.append(
            [problem.title, problem.judged, said, f"{error:.1e}",
             time_text(time.perf_counter() - begin), problem.source]
        )  # fmt: skip
    show(
        "Reference problems",
        ["", "error of", "tolerance", "error", "time", "problem; reference value"],
        rows,
        ["time: describing the machine and simulating it once, its machine code being on the disk."],
    )
