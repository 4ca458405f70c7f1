"""Falling cat: two halves bend and roll, and the cat lands on its feet although its angular momentum is zero.

Each half is symmetric about its spine. The spine is bent by 2 alpha between the halves. Both halves roll about their
spines by phi(t) relative to the bend, one forward and one backward, so that nothing twists. phi runs from 0 to 2 pi
and starts and ends at rest: the cat then has its initial shape.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import sympy

import freebody as fb

from ...space.shape import Shape
from ..tools.answer import Answer, Answers, Plots, Solved, same
from ..tools.case import Case, explain
from ..tools.entry import Entry
from ..tools.looks import placed, together, tube_between
from ..tools.pictures import lines


def build() -> fb.System:
    """Return the cat: the front falls freely, its spine along z; the bent, driven waist joins the rear to it."""
    s, front, rear = halves()
    tau, g = s.parameters(tau=0.5, g=9.81)
    s.assume(tau > 0)
    s.gravity = (0, 0, -g)
    phi = 2 * sympy.pi * s.t / tau - sympy.sin(2 * sympy.pi * s.t / tau)
    s.free("fall", s.ground, front)
    s.gimbal("waist", front, rear, axis="ZXZ", coordinate=(phi, "2*alpha", -phi))
    explain(
        s,
        J="kg m²: moment of inertia of each half about its spine",
        K="kg m²: moment of inertia of each half about the waist, across its spine",
        alpha="rad: half of the bend between the spines",
        tau="s: time of the turn",
        g="m/s²: gravity",
    )
    return s


def bent() -> fb.System:
    """Return the cat relative to the plane of its bend, which turns by psi about the line that halves the bend."""
    s, front, rear = halves()
    psi, phi = s.coordinates("psi phi")
    alpha = s.expression("alpha")
    bend = s.body("bend", fb.particle(0))
    s.hinge("turn", s.ground, bend, axis="z", coordinate=psi)
    for half, angle in ((front, -alpha), (rear, alpha)):
        c, n = sympy.cos(angle), sympy.sin(angle)
        lean = ((1, 0, 0), (0, c, -n), (0, n, c))
        s.hinge(f"{half.name}_roll", bend, half, axis="z", parent_axes=lean, coordinate=-phi)
    return s


def halves() -> tuple[fb.System, Any, Any]:
    """Return both halves, each with its mass centre at the waist, about which K is the moment of inertia."""
    s = fb.System("falling_cat")
    J, K, _ = s.parameters(J=0.015, K=0.05, alpha="40deg")
    s.assume(J > 0, K > 0)
    half = fb.MassProperties(2, (0, 0, 0), ((K, 0, 0), (0, K, 0), (0, 0, J)))
    return s, s.body("front", half, shape=look(1)), s.body("rear", half, shape=look(-1))


def look(side: int) -> Shape:
    """Return a half of the cat as it is drawn: the front with its head, or the rear with its tail."""
    head, tail = (
        placed(fb.sphere(1, 0.055), (0, 0, 0.31)),
        tube_between((0, 0, -0.27), (0.03, 0, -0.5), 0.012),
    )
    return together(placed(fb.cylinder(1, 0.07, 0.26), (0, 0, side * 0.14)), head if side > 0 else tail)


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, saved

    case.refuse_unless("alpha", 0 <= case["alpha"] < math.pi / 2, "a bend with 0 <= alpha < 90 degrees")
    case.refuse_unless("tau", case["tau"] > 0, "a time above 0")
    atoms = case.atoms
    e = fb.equations(bent())
    names = e.model.names.atoms
    momentum = e.integrals["momentum of psi"].expression
    roll = sympy.Symbol("roll", positive=True)
    (rate,) = sympy.solve(momentum.xreplace({names["phi'"]: roll}), names["psi'"])
    turn = 2 * sympy.pi * sympy.factor(rate / roll)
    cosine = sympy.Symbol("c", positive=True)
    in_cosine = sympy.cos(atoms["alpha"]), cosine
    squares = {sympy.sin(atoms["alpha"]) ** 2: 1 - cosine**2}
    half = sympy.fraction(sympy.together((turn - sympy.pi).subs(squares).subs(*in_cosine)))[0]
    lead, middle, last = (sympy.Poly(half, cosine).coeff_monomial(cosine**k) for k in (2, 1, 0))
    # a form of the root that stays finite if the leading coefficient is zero; the other root is negative or above 1
    sign = 1 if case.number(middle) > 0 else -1
    bend = sympy.acos(-2 * last / (middle + sign * sympy.sqrt(sympy.factor(middle**2 - 4 * lead * last))))
    run = case.simulate(case["tau"], times=[0.0, case["tau"]])
    answers: Answers = {
        "psi": case.formula(
            "angle that the cat has turned at tau, about the line that halves the bend",
            turn, "rad", 'fb.equations(bent cat).integrals["momentum of psi"] = 0',
        ),
        "alpha_pi": case.formula(
            "alpha with which it would turn by half a turn, from its back to its feet", bend, "rad", "psi = pi"
        ),
        "h": Answer("height that it has fallen", float(-run["fall_z"][-1]), "m", how="fb.simulate"),
    }  # fmt: skip
    axis = (0.0, -math.sin(case["alpha"]), math.cos(case["alpha"]))
    expected = np.array(fb.Rotation.axis_angle(axis, answers["psi"].value), dtype=float)
    bound = 1000 * case.tolerance
    trajectory = case.motion()
    H = [trajectory[part] for part in case.equations.momentum.angular()]
    checks = (
        same("turn of the front against the simulation", run.poses["front"].rotation[-1], expected, bound),
        same("shape at tau as at the start", shape(run)[-1], shape(run)[0], bound),
        same("angular momentum about the mass centre", H, 0, bound),
    )
    plots: Plots = {
        "turn.png": saved(lambda: turning(case, trajectory)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


def shape(trajectory: fb.Trajectory) -> np.ndarray:
    """Return the attitude of the rear relative to the front at every output time."""
    front, rear = (trajectory.poses[name].rotation for name in ("front", "rear"))
    return np.swapaxes(front, 1, 2) @ rear


def turning(case: Case, trajectory: fb.Trajectory) -> Any:
    """Draw the angle of the plane of the bend about the line that halves it, and the roll relative to this plane."""
    part = 2 * np.pi * trajectory.t / case["tau"]
    phi = part - np.sin(part)
    # the normal of the bend is x of the front, rotated by phi
    front = trajectory.poses["front"].rotation
    normal = front[:, :, 0] * np.cos(phi)[:, None] + front[:, :, 1] * np.sin(phi)[:, None]
    across = np.array([0, math.cos(case["alpha"]), math.sin(case["alpha"])])
    psi = np.unwrap(np.arctan2(normal @ across, normal[:, 0]))
    return lines(
        trajectory.t,
        {
            "roll of the halves phi [deg]": {"phi": np.rad2deg(phi)},
            "turn of the cat psi [deg]": {"psi": np.rad2deg(psi)},
        },
        "Falling cat: it rolls in itself, and turns",
    )


FALLING_CAT = Entry(
    "falling-cat",
    ("cat",),
    "Falling cat turns about without angular momentum (beyond the chapter)",
    (
        "angle by which the cat has turned when it has its shape again",
        "bend with which it would turn from its back to its feet",
        "height that it falls meanwhile",
    ),
    build,
    solve,
    until=0.5,
    bodies=(),
)
