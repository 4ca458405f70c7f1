"""Gyroscope: a thin disk on a massless shaft that turns about a fixed pivot on it (chapter, section 6.9).

psi turns about the upward vertical Z, theta then about the nodal axis, phi then about the shaft; the total
spin along the shaft, Omega_zeta = phi' + psi' cos(theta), is constant.
"""

from __future__ import annotations

import math
from typing import Any

import sympy

import freebody as fb

from .entry import Answers, Case, Entry, Plots, explain, happened, mass_properties, states

RELEASE = {"theta": "theta_0", "phi'": "Omega_zeta"}  # from rest: theta' = psi' = 0
EVENTS = [
    fb.event("theta'", name="smallest theta", direction=1),
    fb.event("theta'", name="largest theta", direction=-1),
]


def build(axis: str = "ZXZ", angles: str = "psi theta phi") -> fb.System:
    """The gyroscope in Euler angles, or in another sequence of angles."""
    s = fb.System("gyroscope")
    m, R, L, g = s.parameters(m=1.2, R=0.06, L=0.1, g=9.81)
    s.parameters(theta_0="60deg", theta_low="120deg", Omega_zeta=300.0, t_1=0.4)
    s.gravity = (0, 0, -g)
    rotor = s.body("rotor", fb.disk(m, R))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -L), axis=axis, coordinate=angles)
    explain(
        s,
        m="kg: mass of the disk",
        R="m: radius of the disk",
        L="m: distance of the disk's centre from the pivot",
        g="m/s²: gravity",
        theta_0="rad: angle of steady precession, and of the release",
        theta_low="rad: second angle of steady precession",
        Omega_zeta="rad/s: total spin along the shaft",
        t_1="s: time to answer for",
    )
    return s


def steady_balance(case: Case) -> tuple[Any, ...]:
    """Coefficients of 1, w, w² in the balance of theta when theta and psi' = w stay as they are."""
    w = sympy.Symbol("w")
    state = {"theta'": 0, "theta''": 0, "psi''": 0, "phi''": 0, "psi'": w}
    spin = case.system.expression("Omega_zeta - psi'*cos(theta)")
    balance = case.equations.motion[1]
    steady = case.put(balance.lhs - balance.rhs, {**state, "phi'": spin.xreplace({case.atoms["psi'"]: w})})
    return tuple(sympy.Poly(steady, w).coeff_monomial(w**k) for k in range(3))


def steady_rates(case: Case, theta: str) -> tuple[Any, Any]:
    """Fast and slow steady precession at the angle of that name [rad/s]."""
    C, B, A = (case.number(c, {"theta": case.atoms[theta]}) for c in steady_balance(case))
    square = B**2 - 4 * A * C
    if square < 0 or B == square == 0:
        return ("none: spin too small",) * 2
    # the sum of like signs, so that the slow rate keeps its digits
    q = -(B + math.copysign(math.sqrt(square), B)) / 2
    return q / A if A else math.copysign(math.inf, q), C / q


def least_spin(case: Case) -> float:
    """Smallest spin with a steady precession at theta_0: B² = 4 A C there, and B is a multiple of the spin."""
    here = {"theta": case.atoms["theta_0"]}
    C, B, A = steady_balance(case)
    slope = case.number(B.diff(case.atoms["Omega_zeta"]), here)
    return 2 * math.sqrt(max(0.0, case.number(A, here) * case.number(C, here))) / abs(slope)


def sleeping_spin(case: Case) -> float:
    """Smallest spin at which the upright top is stable, from the linearised equations of the same machine.

    Euler's angles do not know theta = 0 from its neighbours, so two tilts alpha, beta about the horizontal
    axes take their place. The linear equations M q'' + G q' + K q = 0 give det(s² M + s G + K) =
    a s⁴ + b s² + c; b grows with Omega², and all s are imaginary from b = 2 sqrt(a c) on.
    """
    e = fb.equations(build("XYZ", "alpha beta phi"))
    tilts, rates = sympy.Matrix(e.coordinates[:2]), sympy.Matrix(e.speeds[:2])
    upright = {**dict.fromkeys(rates, 0), e.speeds[2]: case.atoms["Omega_zeta"]}
    upright |= dict.fromkeys(tilts, 0) | {e.coordinates[2]: 0}
    M = e.mass_matrix[:2, :2].xreplace(upright)
    G = sympy.Matrix(e.bias[:2]).jacobian(rates).xreplace(upright)
    K = sympy.Matrix(e.bias[:2]).jacobian(tilts).xreplace(upright)
    s, Omega = sympy.Symbol("s"), case.atoms["Omega_zeta"]
    poly = sympy.Poly((s**2 * M + s * G + K).det(), s)
    a, b, c = (poly.coeff_monomial(s**k) for k in (4, 2, 0))
    b2, b0 = (case.number(sympy.Poly(b, Omega).coeff_monomial(Omega**k)) for k in (2, 0))
    return math.sqrt((2 * math.sqrt(case.number(a) * case.number(c)) - b0) / b2)


def solve(case: Case) -> tuple[fb.Trajectory, Answers, Plots]:
    if not 0 < case["theta_0"] < math.pi:
        raise fb.errors.ModelError(
            f"Expected theta_0 between 0 and pi, got {case['theta_0']:g}: there the shaft is vertical and "
            "psi and phi are one angle."
        )
    rotor = case.system.bodies["rotor"]
    I_0 = mass_properties(rotor).about(case.system.joints["pivot"].to)
    fast, slow = steady_rates(case, "theta_0")
    fast_low, slow_low = steady_rates(case, "theta_low")
    nutation = case.simulate_past("largest theta", 2, initial=RELEASE, events=EVENTS)
    low = happened(nutation, "largest theta")
    at = case.simulate_to([case["t_1"]], initial=RELEASE)
    answers: Answers = {
        "I_xi": (case.number(I_0[0][0]), "kg m²"),
        "I_zeta": (case.number(I_0[2][2]), "kg m²"),
        "fast steady psi' at theta_0": (fast, "rad/s"),
        "slow steady psi' at theta_0": (slow, "rad/s"),
        "smallest spin with steady precession at theta_0": (least_spin(case), "rad/s"),
        "fast steady psi' at theta_low": (fast_low, "rad/s"),
        "slow steady psi' at theta_low": (slow_low, "rad/s"),
        "largest theta after release": (low[0].state["theta"], "rad"),
        "nutation period": (low[1].time - low[0].time, "s"),
        **states(at, 0, {"theta": "rad", "psi": "rad", "theta'": "rad/s", "psi'": "rad/s"}, "t_1"),
        "smallest spin of the upright top": (sleeping_spin(case), "rad/s"),
    }
    trajectory = case.motion(initial=RELEASE, events=EVENTS)
    return trajectory, answers, plots(trajectory)


def plots(trajectory: fb.Trajectory) -> Plots:
    """theta, psi, the spin axis on the unit sphere and the energy ledger."""
    from ..picture.plots import energy_residual, history, saved
    from ..picture.sphere import axis_path

    return {
        "theta.png": saved(lambda: history(trajectory, "theta", title="Nutation of the gyroscope")),
        "psi.png": saved(lambda: history(trajectory, "psi", title="Precession of the gyroscope")),
        "spin_axis.png": saved(lambda: axis_path(trajectory, "rotor", title="Path of the spin axis")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }


GYROSCOPE = Entry(
    "gyroscope",
    ("sec-6-9",),
    "Gyroscope, or heavy symmetric top (section 6.9)",
    (
        "steady precession: both rates, and the spin it takes",
        "release from rest: largest theta, nutation period, state at t_1",
        "spin at which the upright top is stable",
    ),
    build,
    solve,
    until=2.5,
    start=RELEASE,
)
