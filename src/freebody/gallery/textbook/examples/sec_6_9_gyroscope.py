"""Gyroscope: a thin disk on a massless shaft that turns about a fixed pivot on it (chapter, section 6.9).

psi turns about the upward vertical Z, theta then about the nodal axis, phi then about the shaft; the total
spin along the shaft, Omega_zeta = phi' + psi' cos(theta), is constant.
"""

from __future__ import annotations

from typing import Any

import sympy

import freebody as fb

from ...tools.answer import Answer, Answers, Check, Plots, Solved, same
from ...tools.case import Case, explain, happened, mass_properties, states
from ...tools.entry import Entry
from ...tools.precession import between, least_spin, steady_rates

MOMENTS = {"I_xi": "m*(R**2/4 + L**2)", "I_zeta": "m*R**2/2"}
"""Moments of inertia about the pivot: across the shaft and along it."""
RELEASE = {"theta": "theta_0", "phi'": "Omega_zeta"}  # from rest: theta' = psi' = 0
EVENTS = [
    fb.event("theta'", name="smallest theta", direction=1),
    fb.event("theta'", name="largest theta", direction=-1),
]


def top(name: str, axis: str = "ZXZ", angles: str = "psi theta phi", **more: Any) -> fb.System:
    """Return a gyroscope in Euler angles, or another sequence of angles; ``more`` are further parameters."""
    s = fb.System(name)
    m, R, L, g = s.parameters(m=1.2, R=0.06, L=0.1, g=9.81)
    s.parameters(**{"theta_0": "60deg", "Omega_zeta": 300.0, **more})
    s.assume(L > 0, g > 0)
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
        Omega_zeta="rad/s: total spin along the shaft",
    )
    return s


def build(axis: str = "ZXZ", angles: str = "psi theta phi") -> fb.System:
    """Return the gyroscope in Euler angles, or in another sequence of angles."""
    s = top("gyroscope", axis, angles, theta_low="120deg", t_1=0.4)
    explain(s, theta_low="rad: second angle of steady precession", t_1="s: time to answer for")
    return s


def sleeping_spin(case: Case) -> Any:
    """Return the smallest spin at which the upright top is stable, from the linearised equations of the machine.

    Euler's angles are singular at theta = 0, so two tilts alpha, beta about the horizontal axes replace them. The
    linear equations M q'' + G q' + K q = 0 give det(s² M + s G + K) = a s⁴ + b s² + c; b grows with Omega², and all
    s are imaginary for b >= 2 sqrt(a c).
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
    b2, b0 = (sympy.Poly(b, Omega).coeff_monomial(Omega**k) for k in (2, 0))
    return sympy.sqrt((2 * sympy.sqrt(sympy.factor(a * c)) - b0) / b2)


def moments(case: Case) -> tuple[Any, Any]:
    """Return the transverse and axial moments of inertia about the pivot, in the parameters."""
    I_0 = mass_properties(case.system.bodies["rotor"]).about(case.system.joints["pivot"].to)
    return I_0[0][0], I_0[2][2]


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    between(case)
    I_xi, I_zeta = moments(case)
    nutation = case.simulate_past("largest theta", 2, initial=RELEASE, events=EVENTS)
    low = happened(nutation, "largest theta")
    at = case.simulate_to([case["t_1"]], initial=RELEASE)
    how = "rotor.mass_properties.about(pivot)"
    located = "fb.simulate, event located"
    answers: Answers = {
        "I_xi": case.formula("transverse moment of inertia about the pivot", I_xi, "kg m²", how),
        "I_zeta": case.formula("axial moment of inertia", I_zeta, "kg m²", how),
        **steady_rates(case, "theta_0"),
        "Omega_min": case.formula(
            "smallest spin with steady precession at theta_0",
            least_spin(case), "rad/s", "equation of motion of theta: both rates equal",
        ),
        **steady_rates(case, "theta_low", "(theta_low)"),
        "theta_max": Answer("largest theta after release", low[0].state["theta"], "rad", how=located),
        "period": Answer("nutation period", low[1].time - low[0].time, "s", how=located),
        **states(at, 0, {"theta": "rad", "psi": "rad", "theta'": "rad/s", "psi'": "rad/s"}, "t_1"),
        "Omega_sleeping": case.formula(
            "smallest spin of the stable upright top",
            sleeping_spin(case), "rad/s", "linear equations of two tilts about the vertical",
        ),
    }  # fmt: skip
    trajectory = case.motion(initial=RELEASE, events=EVENTS)
    return Solved(trajectory, answers, plots(trajectory), checks(case, at))


def checks(case: Case, at: fb.Trajectory) -> tuple[Check, ...]:
    """Check every integral along the simulated motion against its value at the release."""
    names = case.equations.model.state_names
    start = {**dict.fromkeys(names, 0.0), "theta": case["theta_0"], "phi'": case["Omega_zeta"]}
    end = {name: float(at[name][0]) for name in names}
    return tuple(
        same(f"{integral.name} at t_1 and at the start", integral.value({**case.values, **end}),
             integral.value({**case.values, **start}), 1000 * case.tolerance)
        for integral in case.equations.integrals
    )  # fmt: skip


def plots(trajectory: fb.Trajectory) -> Plots:
    """Return plots of theta, psi, the spin axis on the unit sphere and the energy ledger."""
    from ....picture.plots.plots import energy_residual, history, saved
    from ....picture.plots.sphere import axis_path

    return {
        "theta.png": saved(lambda: history(trajectory, "theta", title="Nutation of the gyroscope")),
        "psi.png": saved(lambda: history(trajectory, "psi", title="Precession of the gyroscope")),
        "spin_axis.png": saved(lambda: axis_path(trajectory, "rotor", title="Path of the spin axis")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }


GYROSCOPE = Entry(
    "sec-6-9",
    ("gyroscope", "heavy-top"),
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
    names=MOMENTS,
)
