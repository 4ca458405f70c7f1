"""Airfoil section on a spring against plunge and one against pitch (chapter, Problem 6.14).

x is the displacement of the elastic axis E, theta the rotation, both from static equilibrium, in which the chord is
horizontal; the mass centre C, at s from E, is displaced by x + s theta. Weight only shifts the equilibrium.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import freebody as fb

from ....space.shape import Shape
from ...tools.answer import Answer, Answers, Plots, Printed, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ...tools.looks import placed
from ...tools.pictures import lines

START = {"x": "x_0", "theta": "theta_0"}


def look(chord: float = 0.4, thickness: float = 0.15, points: int = 24) -> Shape:
    """Return the section as it is drawn: a symmetric profile of four digits (NACA), its nose to the left."""
    x = (1 - np.cos(np.linspace(0, np.pi, points))) / 2  # close together at the nose
    half = 5 * thickness * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    around = np.vstack([np.column_stack([x, -half]), np.column_stack([x, half])[-2:0:-1]]) * chord
    n, depth = len(around), chord / 8
    ends = [np.column_stack([around - (chord / 2, 0), np.full(n, z)]) for z in (-depth, depth)]
    faces = [(0, k + 1, k) for k in range(1, n - 1)] + [(n, n + k, n + k + 1) for k in range(1, n - 1)]
    for k in range(n):
        after = (k + 1) % n
        faces += [(k, after, n + after), (k, n + after, n + k)]
    return placed(fb.mesh(np.vstack(ends), faces, mass=1))


def build() -> fb.System:
    """Return the system; E slides along Y, the section turns about E by theta, and the chord is along x."""
    s = fb.System("airfoil")
    m, I_E, b, k_x, k_theta = s.parameters(m=10.0, I_E=0.9, s=0.1, k_x=4000.0, k_theta=200.0)
    s.parameters(x_0=0.01, theta_0=0.0, t_1=1.0)
    I_C = I_E - m * b**2
    s.assume(m > 0, I_E > 0, I_C > 0, k_x > 0, k_theta > 0)
    axis = s.body("axis", fb.particle(0))
    # only the moment of inertia about the axis normal to the plane matters
    inertia = ((I_C, 0, 0), (0, I_C, 0), (0, 0, I_C))
    section = s.body("section", fb.MassProperties(m, (0, 0, 0), inertia), shape=look())
    plunge = s.slider("plunge", s.ground, axis, axis="y", coordinate="x")
    pitch = s.hinge("E", axis, section, to=(-b, 0, 0), axis="z", coordinate="theta")
    s.spring("k_x", plunge, stiffness=k_x)
    s.torsion_spring("k_theta", pitch, stiffness=k_theta)
    explain(
        s,
        m="kg: mass of the section",
        I_E="kg m²: moment of inertia about the elastic axis",
        s="m: distance of the mass centre from the elastic axis",
        k_x="N/m: stiffness against plunge",
        k_theta="N m/rad: stiffness against pitch",
        x_0="m: displacement of E at the start",
        theta_0="rad: rotation at the start",
        t_1="s: time to answer for",
        x="m: displacement of E from equilibrium",
        theta="rad: rotation from equilibrium, that displaces C like x",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, saved

    # with s = 0 plunge and pitch are uncoupled, and each is a mode
    linear = fb.linearize(case.equations, where={} if case["s"] else {"s": 0})
    modes = sorted(linear.modes(), key=lambda mode: case.number(mode.frequency))
    written = linear.text().splitlines()
    answers: Answers = {
        f"equation_{name}": Answer(
            f"equation of motion of {name}, small theta",
            line,
            "",
            None,
            "fb.linearize(s)",
            Printed.line(line),
        )
        for name, line in zip(("x", "theta"), written, strict=True)
    }
    for k, mode in enumerate(modes, 1):
        answers[f"omega_{k}"] = case.formula(
            f"natural frequency {k}", mode.frequency, "rad/s", "fb.linearize(s).natural_frequencies()"
        )
    for k, mode in enumerate(modes, 1):
        what, how = (
            f"amplitude of x over that of theta at frequency {k}, + in phase",
            "fb.linearize(s).modes()",
        )
        x, theta = mode.shape["x"], mode.shape["theta"]
        answers[f"ratio_{k}"] = (
            case.formula(what, x / theta, "m/rad", how)
            if theta != 0
            else Answer(what, "none: theta stays zero", "", how=how)
        )
    numeric = linear.numeric(case.values)
    start = {"x": case["x_0"], "theta": case["theta_0"]}
    response: Any = numeric.response(start)
    then = response(case["t_1"])
    for name, unit in (("x", "m"), ("theta", "rad")):
        answers[f"{name}(t_1)"] = Answer(
            f"{name} at t_1 in the linear theory",
            float(then[name]),
            unit,
            how="fb.linearize(s).response(...)",
        )
    # as small as double precision permits: the third-order terms are then below the bound
    small = {name: 1e-4 * value for name, value in start.items()}
    truth = case.simulate(case["t_1"] or 1e-9, initial=small, times=[case["t_1"]])
    checks = tuple(
        same(
            f"{name}(t_1) against the simulation at a ten-thousandth of the start",
            1e4 * truth[name][-1],
            then[name],
            1e5 * case.tolerance,
        )
        for name in ("x", "theta")
    ) + (
        same(
            "frequencies of the numeric linear model",
            [answers["omega_1"].value, answers["omega_2"].value],
            numeric.natural_frequencies(),
            1e-10,
        ),
    )
    trajectory = case.motion(initial=START)
    plots: Plots = {
        "coordinates.png": saved(lambda: history(trajectory, title="Airfoil section: plunge and pitch")),
        "beyond_linear.png": saved(lambda: beyond_linear(trajectory, response)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


def beyond_linear(trajectory: fb.Trajectory, response: Any) -> Any:
    """Draw the difference between the simulated motion and the linear theory."""
    theory = response(trajectory.t)
    return lines(
        trajectory.t,
        {
            f"{name} [{unit}]": {"simulated - linear": trajectory[name] - theory[name]}
            for name, unit in (("x", "m"), ("theta", "rad"))
        },
        "Airfoil section: what linear theory leaves out",
    )


AIRFOIL = Entry(
    "prob-6-14",
    ("airfoil",),
    "Airfoil section: coupled plunge and pitch (Problem 6.14)",
    (
        "equations of motion for small theta",
        "both natural frequencies, and the ratio of the amplitudes of x and theta at each",
        "x and theta at t_1 in the linear theory",
    ),
    build,
    solve,
    until=2.0,
    start=START,
)
