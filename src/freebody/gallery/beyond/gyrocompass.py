"""Foucault's gyrocompass: a rotor whose axis is kept horizontal turns its axis to the north.

Z is the axis of the Earth. theta is the angle of the spin axis from north, towards west +, about the local vertical; a
damper on the vertical bearing lets it settle. `spin` is the angular velocity of the rotor along its axis, including the
Earth's rotation. It is constant, since no moment acts about the axis.
"""

from __future__ import annotations

import math
from dataclasses import replace

import sympy

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved, same
from ..tools.case import Case, explain, happened
from ..tools.entry import Entry

START = {"theta": "theta_0", "phi'": "spin - Omega*cos(latitude)*cos(theta_0)"}


def build() -> fb.System:
    """Return the system: the Earth turns a stand, the ring turns on it about the vertical z, the rotor about x."""
    s = fb.System("gyrocompass")
    I_S, I_T, I_R, c = s.parameters(I_S=2.0e-4, I_T=1.1e-3, I_R=0.4e-4, c=3.0e-5)
    Omega, latitude = s.parameters(Omega=7.2921159e-5, latitude="50deg")
    s.parameters(spin=2500.0, theta_0="20deg", t_1=10.0)
    s.assume(I_S > 0, I_T > 0, I_R > 0, Omega > 0, sympy.cos(latitude) > 0)
    stand = s.body("stand", fb.particle(0), shape="nothing")
    ring = s.body("ring", fb.MassProperties(1, (0, 0, 0), ((I_R, 0, 0), (0, I_R, 0), (0, 0, I_R))),
                  shape=fb.torus(1, 0.12, 0.006, axis="y"))  # fmt: skip
    disk = fb.cylinder(1, 0.08, 0.03, axis="x") + fb.cylinder(1, 0.004, 0.24, axis="x")
    rotor = s.body("rotor", fb.MassProperties(1, (0, 0, 0), ((I_S, 0, 0), (0, I_T, 0), (0, 0, I_T))),
                   shape=disk)  # fmt: skip
    s.hinge("earth", s.ground, stand, axis="z", coordinate=Omega * s.t)
    n, c_l = sympy.sin(latitude), sympy.cos(latitude)
    # columns: north, west, up, in axes whose z is the Earth's axis and whose x points away from it
    horizon = ((-n, 0, c_l), (0, -1, 0), (c_l, 0, n))
    vertical = s.hinge("vertical", stand, ring, axis="z", parent_axes=horizon, coordinate="theta")
    s.hinge("axle", ring, rotor, axis="x", coordinate="phi")
    s.damper("damper", vertical, damping=c)
    explain(
        s,
        I_S="kg m²: moment of inertia of the rotor about its axis",
        I_T="kg m²: moment of inertia of the rotor across its axis",
        I_R="kg m²: moment of inertia of the ring",
        c="N m s/rad: damping about the vertical",
        Omega="rad/s: angular velocity of the Earth",
        latitude="rad: latitude, north +",
        spin="rad/s: angular velocity of the rotor along its axis",
        theta_0="rad: angle from north at the start, at rest",
        t_1="s: time to answer for",
        theta="rad: angle of the spin axis from north, west +",
        phi="rad: turn of the rotor in the ring",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, saved

    case.refuse_unless("latitude", abs(case["latitude"]) < math.pi / 2, "a latitude between the poles")
    case.refuse_unless("spin", case["spin"] > 0, "a spin above 0")
    north = fb.linearize(case.equations, {"phi'": "spin - Omega*cos(latitude)"})
    M, C, K = north.M[0, 0], north.C[0, 0], north.K[0, 0]
    case.refuse_unless("spin", case.number(K) > 0, "a spin above I_T Omega cos(latitude) / I_S")
    rate = sympy.sqrt(K / M)
    south = fb.linearize(
        case.equations, {"theta": "pi", "phi'": "spin + Omega*cos(latitude)"}, values=case.values
    )
    at = case.simulate_to([case["t_1"]], initial=START)
    how = "fb.linearize(s) about north"
    answers: Answers = {
        "equation": case.equation(0, "equation of motion of theta"),
        "omega_n": case.formula("frequency of small oscillation about north, undamped", rate, "rad/s", how),
        "T": case.formula("period of small oscillation about north, undamped", 2 * sympy.pi / rate, "s", how),
        "zeta": case.formula("damping ratio about north", C / (2 * sympy.sqrt(K * M)), "1", how),
        "sigma": Answer(
            "rate at which a small angle from south grows",
            float(max(south.eigenvalues().real)), "1/s", how="fb.linearize(s, values=...) about south",
        ),
        "theta(t_1)": Answer("theta at t_1", float(at["theta"][-1]), "rad", how="fb.simulate"),
    }  # fmt: skip
    cosine = case["Omega"] * math.cos(case["latitude"])
    free = replace(case.having(c=0.0), until=2 * answers["T"].value)
    small = {"theta": 1e-3, "phi'": f"spin - Omega*cos(latitude)*{math.cos(1e-3)!r}"}
    swing = free.simulate_past("north", 3, initial=small, events=[fb.event("theta", name="north")])
    first, _, third = (event.time for event in happened(swing, "north")[:3])
    checks = (
        same("T against a simulated swing of 1e-3 rad", third - first, answers["T"].value, 1e-6),
        same(
            "spin of the rotor at t_1 over that at the start",
            (at["phi'"][-1] + cosine * math.cos(at["theta"][-1])) / case["spin"], 1, 1000 * case.tolerance,
        ),
    )  # fmt: skip
    trajectory = case.motion(initial=START)
    plots: Plots = {
        "theta.png": saved(
            lambda: history(trajectory, "theta", title="Gyrocompass: angle from north, west +")
        ),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


GYROCOMPASS = Entry(
    "gyrocompass",
    ("foucault-gyrocompass",),
    "Foucault's gyrocompass settles on north (beyond the chapter)",
    (
        "equation of motion of the angle from north",
        "frequency and period of the swing about north, damping ratio, and how fast it leaves south",
        "angle from north at t_1",
    ),
    build,
    solve,
    until=60.0,
    start=START,
    bodies=("ring", "rotor"),
)
