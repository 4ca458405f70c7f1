"""Jeffcott rotor: a disk with an eccentric mass centre on a flexible shaft that turns at constant speed.

x, y are the deflections of the shaft at the disk; the mass centre is at the distance e from the shaft, along x at
t = 0. The shaft is a spring of stiffness k in every direction, with damping d. Weight only shifts the equilibrium.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import sympy

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved, same
from ..tools.case import Case, explain
from ..tools.entry import Entry
from ..tools.pictures import lines


def build() -> fb.System:
    """Return the system: the middle of the shaft moves in the plane, the disk turns with the shaft by omega t."""
    s = fb.System("jeffcott")
    m, R, e, k, d, omega = s.parameters(m=5.0, R=0.1, e=2.0e-4, k=2.0e5, d=60.0, omega=260.0)
    s.parameters(t_1=1.0)
    s.assume(m > 0, e > 0, k > 0, d > 0, omega > 0)
    disk = s.body("disk", fb.disk(m, R, axis="z"))
    shaft = s.planar("shaft", s.ground, disk, to=(-e, 0, 0), coordinate=("x", "y", omega * s.t))
    for axis in (0, 1):
        s.spring(f"k_{'xy'[axis]}", shaft, stiffness=k, coordinate=axis)
        s.damper(f"d_{'xy'[axis]}", shaft, damping=d, coordinate=axis)
    explain(
        s,
        m="kg: mass of the disk",
        R="m: radius of the disk",
        e="m: distance of the mass centre from the shaft",
        k="N/m: stiffness of the shaft at the disk",
        d="N s/m: damping of the deflection",
        omega="rad/s: speed of the shaft",
        t_1="s: time to answer for, from rest in the middle",
        x="m: deflection of the shaft along X",
        y="m: deflection of the shaft along Y",
    )
    return s


def whirl(case: Case) -> tuple[Any, Any, dict[str, Any]]:
    """Return A, B, state of the whirl x = A cos(omega t) + B sin(omega t), y = A sin(omega t) - B cos(omega t)."""
    A, B = sympy.symbols("A B", real=True)
    t, omega = case.system.t, case.atoms["omega"]
    x = A * sympy.cos(omega * t) + B * sympy.sin(omega * t)
    y = A * sympy.sin(omega * t) - B * sympy.cos(omega * t)
    state = {
        f"{name}{dots * chr(39)}": f.diff(t, dots) for name, f in (("x", x), ("y", y)) for dots in range(3)
    }
    conditions = []
    for equation in case.equations.motion:
        left = sympy.expand(case.put(equation.lhs - equation.rhs, state))
        conditions += [left.coeff(f(omega * t)) for f in (sympy.cos, sympy.sin)]
    (solution,) = sympy.solve(conditions, [A, B], dict=True)
    return solution[A], solution[B], {name: value.subs(solution) for name, value in state.items()}


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, saved

    for name in ("m", "e", "k", "d", "omega"):
        case.refuse_unless(
            name, case[name] > 0, "a turning rotor off its middle, with damping: values above 0"
        )
    A, B, steady = whirl(case)
    atoms = case.atoms
    # without their denominator: a common positive factor does not change the direction of (A, B)
    (ahead, below), (behind, _) = (sympy.fraction(sympy.together(part)) for part in (A, B))
    common = sympy.gcd(ahead, behind)
    ahead, behind = sympy.cancel(ahead / common), sympy.cancel(behind / common)
    radius = common * sympy.sqrt(sympy.expand(ahead**2 + behind**2)) / below
    lag = sympy.atan2(behind, ahead)
    centred = fb.linearize(case.equations, where={"e": 0})
    (critical, _) = centred.natural_frequencies()
    at_critical = radius.subs(atoms["omega"], critical)
    e = case.equations
    # the canonical form uses sin² + cos² = 1, which eliminates the time
    torque = e.displayed(e.ring.from_sympy(case.put(e.solve("shaft_Mz")["shaft_Mz"], steady)))
    how = "fb.equations(s).motion at a whirl with the speed of the shaft"
    at = case.simulate_to([case["t_1"]])
    answers: Answers = {
        "omega_c": case.formula(
            "critical speed", critical, "rad/s", 'fb.linearize(s, where={"e": 0}).natural_frequencies()'
        ),
        "r": case.formula("radius of the whirl of the shaft at omega", radius, "m", how),
        "delta": case.formula(
            "angle by which the deflection is behind the mass centre", lag, "rad", how
        ),
        "r_c": case.formula("radius of the whirl at the critical speed", at_critical, "m", how),
        "M_z": case.formula(
            "torque on the shaft that keeps up the whirl at omega",
            torque,
            "N m",
            'fb.equations(s).solve("shaft_Mz") at this whirl',
        ),
        "x(t_1)": Answer("x at t_1, from rest in the middle", float(at["x"][-1]), "m", how="fb.simulate"),
        "y(t_1)": Answer("y at t_1, from rest in the middle", float(at["y"][-1]), "m", how="fb.simulate"),
    }  # fmt: skip
    bound = 1000 * case.tolerance
    # the tolerance is relative to deflections of about a metre, and so is the bound
    fine = bound / min(1.0, 1e3 * answers["r"].value)
    start = {name: case.number(steady[name].subs(case.system.t, 0)) for name in ("x", "y", "x'", "y'")}
    kept = case.simulate(initial=start)
    checks = (
        same(
            "radius of a simulated whirl over r", np.hypot(kept["x"], kept["y"]) / answers["r"].value, 1, fine
        ),
        same(
            "torque of a simulated whirl over M_z",
            kept.reactions["shaft"].moment[:, 2] / answers["M_z"].value, 1, fine,
        ),
    )  # fmt: skip
    trajectory = case.motion()
    plots: Plots = {
        "start.png": saved(lambda: history(trajectory, title="Jeffcott rotor: deflection from rest")),
        "response.png": saved(lambda: response(case, radius, lag)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


def response(case: Case, radius: Any, lag: Any) -> Any:
    """Draw radius and lag of the steady whirl over the speed of the shaft, up to three times the critical speed."""
    omega = case.atoms["omega"]
    speeds = np.linspace(0, 3 * math.sqrt(case["k"] / case["m"]), 600)[1:]
    numbers = {case.atoms[name]: value for name, value in case.values.items() if name != "omega"}
    r, delta = (sympy.lambdify(omega, f.subs(numbers), "numpy")(speeds) for f in (radius, lag))
    axes = lines(
        speeds,
        {"radius r [mm]": {"radius": 1000 * r}, "lag delta [deg]": {"lag": np.rad2deg(delta)}},
        "Jeffcott rotor: whirl over speed",
    )
    for ax in axes:
        ax.axvline(case["omega"], color="0.6", linewidth=1, linestyle="--")
        ax.get_legend().remove()
    axes[-1].set_xlabel("speed of the shaft [rad/s]; dashed: omega")
    return axes


JEFFCOTT = Entry(
    "jeffcott-rotor",
    ("jeffcott", "whirl"),
    "Jeffcott rotor: critical speed and whirl (beyond the chapter)",
    (
        "critical speed",
        "radius and lag of the whirl at the speed omega, radius at the critical speed, torque that keeps it up",
        "deflection at t_1 from rest",
    ),
    build,
    solve,
    until=1.0,
    drawn={"x": 0.12, "y": 0.08},
    enlarged={"e": 0.035},
)
