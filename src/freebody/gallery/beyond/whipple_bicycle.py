"""Whipple's bicycle, the benchmark of Meijaard, Papadopoulos, Ruina and Schwab (2007).

Four rigid bodies (rear wheel, frame with rider, front fork, front wheel), three hinges, two thin wheels that roll
without slip. x points forward, y to the right, z down; the frame's origin is the rear contact point when the bicycle
stands upright. Linearised about straight running at the speed v, with the lean φ and the steer δ to the right,

    M (φ, δ)'' + v C1 (φ, δ)' + (g K0 + v² K2) (φ, δ) = 0

Source: Linearized dynamics equations for the balance and steer of a bicycle: a benchmark and review, Proc. R. Soc. A
463 (2007) 1955-1982: parameters table 1, coefficients (A 3)-(A 4), eigenvalues table 2.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy

import freebody as fb

from ...scalar.digits import significant
from ...space.shape import Shape
from ...symbolic.printing.latex import label_latex
from ..tools.answer import Answer, Answers, Plots, Printed, Solved
from ..tools.case import Case, explain
from ..tools.entry import Entry
from ..tools.looks import placed, rim, together, tube_between

LEAN_AND_STEER = ("air_rx", "delta", "theta_R")
"""Independent small motions: lean, steer, and the rotation of the rear wheel, which is the forward motion."""

KICK = {"air_vx": "v", "theta_R'": "-v/r_R", "air_wx": "kick"}
"""Straight running at the speed v with a rate of lean; the contacts determine all other speeds."""


def look(w: Any, c: Any, lam: Any, r_R: Any, r_F: Any) -> dict[str, Shape]:
    """Return the parts as they are drawn: two rims, a frame of tubes with a saddle, a fork with a handlebar."""

    def steering(height: Any) -> tuple[Any, Any, Any]:
        return (w + c - sympy.tan(lam) * height, 0, -height)

    thin = r_R / 16
    hub, cranks, saddle = (0, 0, -r_R), (2 * w / 5, 0, -r_R), (w / 5, 0, -3 * r_R)
    low, high, grip = steering(2 * r_F), steering(13 * r_F / 5), steering(3 * r_F)
    tubes = ((hub, cranks), (hub, saddle), (cranks, saddle), (cranks, low), (saddle, high), (low, high))
    seat = placed(fb.box(1, (r_R / 2, r_R / 4, r_R / 8)), (w / 5, 0, -25 * r_R / 8))
    bar = [(grip[0] - r_F / 6, side * r_F * 3 / 5, grip[2]) for side in (1, -1)]
    fork = (((w, 0, -r_F), low), (low, grip), bar)
    return {
        "rear": rim(r_R, thin, (0, 0, 0), "y"),
        "front": rim(r_F, thin, (0, 0, 0), "y"),
        "frame": together(*(tube_between(start, end, thin) for start, end in tubes), seat),
        "fork": together(*(tube_between(start, end, thin) for start, end in fork)),
    }


def build() -> fb.System:
    """Return the bicycle with masses and inertias of table 1 as numbers, and the rest as parameters."""
    s = fb.System("whipple_bicycle")
    g, w, c, lam, r_R, r_F = s.parameters(g=9.81, w=1.02, c=0.08, lam="18deg", r_R=0.3, r_F=0.35)
    m_B, *_ = s.parameters(m_B=85.0, v=5.0, kick=0.5, t_1=1.0)
    s.gravity = (0, 0, g)

    # moments of inertia, and the product I_xz: minus the entry of the matrix in the table
    solid = fb.MassProperties.from_products
    seen = look(w, c, lam, r_R, r_F)
    rear = s.body("rear_wheel", solid(2, (0, 0, 0), (0.0603, 0.12, 0.0603)), shape=seen["rear"])
    rider = solid(m_B, (0.3, 0, -0.9), (9.2, 11, 2.8), (0, -2.4, 0))
    frame = s.body("frame", rider, shape=seen["frame"])
    handlebar = solid(4, (0.9, 0, -0.7), (0.05892, 0.06, 0.00708), (0, 0.00756, 0))
    fork = s.body("fork", handlebar, shape=seen["fork"])
    front = s.body("front_wheel", solid(3, (0, 0, 0), (0.1405, 0.28, 0.1405)), shape=seen["front"])
    s.free("air", s.ground, frame)
    s.hinge("rear_axle", frame, rear, at=(0, 0, -r_R), axis="y", coordinate="theta_R")
    foot, tilted = (w + c, 0, 0), ("sin(lam)", 0, "cos(lam)")
    s.hinge("steering", frame, fork, at=foot, to=foot, axis=tilted, coordinate="delta")
    s.hinge("front_axle", fork, front, at=(w, 0, -r_F), axis="y", coordinate="theta_F")
    s.rolling("rear_contact", rear, radius=r_R, axis="y", normal="-z")
    s.rolling("front_contact", front, radius=r_F, axis="y", normal="-z")
    explain(
        s,
        g="m/s²: gravity",
        w="m: wheel base",
        c="m: trail",
        lam="rad: tilt of the steering axis backward from the vertical",
        r_R="m: radius of the rear wheel",
        r_F="m: radius of the front wheel",
        m_B="kg: mass of the frame with the rider",
        v="m/s: forward speed",
        kick="rad/s: rate of lean at the start",
        t_1="s: time to answer for",
    )
    return s


def linear(machine: Any, v: float, values: dict[str, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return M, C and K of lean and steer about straight running at the speed ``v``, each (2, 2)."""
    at = {"air_vx": v, "theta_R'": -v / values["r_R"], "theta_F'": -v / values["r_F"]}
    solution = fb.linearize(machine, about=at, values=values, independent=LEAN_AND_STEER)
    M, C, K = (np.array(x, dtype=float)[:2, :2] for x in (solution.M, solution.C, solution.K))
    return M, C, K


def coefficients(machine: Any, values: dict[str, float]) -> dict[str, np.ndarray]:
    """Return the constant matrices M, C1, K0, K2: C is linear in v, K is a constant plus a part with v²."""
    M, _, K = linear(machine, 0.0, values)
    _, C_1, K_1 = linear(machine, 1.0, values)
    return {"M": M, "C1": C_1, "K0": K / values["g"], "K2": K_1 - K}


def equation(parts: dict[str, np.ndarray], row: int) -> Printed:
    """Return one of the two linear equations, with numbers as coefficients."""
    line, tex, thin = "", "", r"\, "
    for name, factor, dots in (("M", "", "''"), ("C1", "v*", "'"), ("K0", "g*", ""), ("K2", "v^2*", "")):
        for x, angle in zip(parts[name][row], ("lean", "delta"), strict=True):
            if abs(x) > 1e-12 * np.abs(parts[name]).max():  # the rest is zero except for round-off
                number = f" {'+' if x > 0 else '-'} {significant(abs(x))}"
                line += f"{number}*{factor}{angle}{dots}"
                tex += rf"{number}\, {factor.replace('*', thin)}{label_latex(angle + dots)}"
    return Printed(*(f"{side.removeprefix(' + ')} = 0" for side in (line, tex)))


def eigenvalues(parts: dict[str, np.ndarray], v: float, g: float) -> np.ndarray:
    """Return the four eigenvalues of lean and steer at a speed [1/s]: pairs first, then descending real ones."""
    K = g * parts["K0"] + v**2 * parts["K2"]
    right = np.linalg.solve(parts["M"], np.hstack([-K, -v * parts["C1"]]))
    solution = np.linalg.eigvals(np.vstack([np.hstack([np.zeros((2, 2)), np.eye(2)]), right])).astype(complex)
    return solution[np.lexsort((-solution.imag, -solution.real, solution.imag == 0))]


def stable_speeds(parts: dict[str, np.ndarray], g: float) -> tuple[float, float] | str:
    """Return the speeds between which straight running is stable: the weave speed and the capsize speed [m/s].

    det(M s² + v C1 s + K) = a4 s⁴ + v b3 s³ + a2 s² + v b1 s + a0, with polynomials in x = v². Stability can change
    where a0 = 0 or Hurwitz's determinant b3 a2 b1 - a4 b1² - b3² a0 = 0.
    """
    x = np.polynomial.Polynomial([0.0, 1.0])
    (M11, M12), (M21, M22) = parts["M"]
    (C11, C12), (C21, C22) = parts["C1"]
    (K11, K12), (K21, K22) = (
        [g * a + b * x for a, b in zip(*rows, strict=True)]
        for rows in zip(parts["K0"], parts["K2"], strict=True)
    )
    a4 = M11 * M22 - M12 * M21
    b3 = M11 * C22 + C11 * M22 - M12 * C21 - C12 * M21
    a2 = M11 * K22 + K11 * M22 - M12 * K21 - K12 * M21 + (C11 * C22 - C12 * C21) * x
    b1 = C11 * K22 + K11 * C22 - C12 * K21 - K12 * C21
    a0 = K11 * K22 - K12 * K21
    changes = [
        z.real for p in (a0, b3 * a2 * b1 - a4 * b1**2 - b3**2 * a0) for z in p.roots() if abs(z.imag) < 1e-12
    ]
    speeds = np.sqrt(sorted(z for z in changes if z > 0))
    for low, high in zip(speeds, speeds[1:], strict=False):
        if eigenvalues(parts, (low + high) / 2, g).real.max() < 0:
            return float(low), float(high)
    return "none: unstable at all speeds"


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, reaction, saved

    parts = coefficients(case.equations.model, case.values)
    at = case.simulate_to([case["t_1"]], initial=KICK)
    speeds = stable_speeds(parts, case["g"])
    roots = tuple((float(z.real), float(z.imag)) for z in eigenvalues(parts, case["v"], case["g"]))
    rear, front = (at.reactions[f"{wheel}_contact"].force[0].tolist() for wheel in ("rear", "front"))
    lines = {name: equation(parts, i) for i, name in enumerate(("lean", "delta"))}
    units = {"M": "kg m²", "C1": "kg m", "K0": "kg m", "K2": "kg"}
    answers: Answers = {
        **{
            f"equation_{name}": Answer(
                f"equation of {name} near straight running", line.text, "", None, "fb.linearize(s)", line
            )
            for name, line in lines.items()
        },
        **{
            name: Answer(f"matrix {name} of lean and steer", tuple(map(tuple, parts[name].tolist())), unit)
            for name, unit in units.items()
        },
        "eigenvalues": Answer("eigenvalues at v: real, imaginary part", roots, "1/s"),
        "stable": Answer("stable from, to", speeds, "m/s"),
        "delta(t_1)": Answer("delta at t_1", float(at["delta"][0]), "rad"),
        "lean'(t_1)": Answer("rate of lean at t_1", float(at["air_wx"][0]), "rad/s"),
        "F_rear(t_1)": Answer("force of the ground on the rear wheel at t_1", tuple(rear), "N"),
        "F_front(t_1)": Answer("force of the ground on the front wheel at t_1", tuple(front), "N"),
    }  # fmt: skip
    trajectory = case.motion(initial=KICK)
    plots: Plots = {
        "delta.png": saved(
            lambda: history(trajectory, "delta", title="Bicycle after a kick: steering angle")
        ),
        "lean.png": saved(lambda: history(trajectory, "air_wx", title="Bicycle after a kick: rate of lean")),
        "front.png": saved(lambda: reaction(trajectory, "front_contact", axes="xyz")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots)


WHIPPLE_BICYCLE = Entry(
    "whipple-bicycle",
    ("bicycle",),
    "Whipple's bicycle: the benchmark of Meijaard, Papadopoulos, Ruina and Schwab (2007)",
    (
        "equations of lean and steer near straight running, their matrices M, C1, K0, K2, eigenvalues at the speed v",
        "speeds between which it is stable without a hand",
        "motion after a kick, forces at the wheels",
    ),
    build,
    solve,
    until=4.0,
    positive=("g", "w", "r_R", "r_F", "m_B"),
    drawn={"delta": "12deg"},
    bodies=(),
)
