"""A slender satellite that spins about its long axis and has something loose inside: it ends in a flat spin.

No moment acts, so the angular momentum H is constant. An internal damper takes energy until T = H²/(2 I_max), the
least for this H: rotation about the axis of the largest moment (the major-axis rule, learnt from Explorer I in 1958).

The loose part is a wheel inside, its axle along the body's x axis, in a viscous bearing: J (w_x' + delta'') =
-c delta'. The energy-sink estimate assumes that the body wobbles as if the wheel were stuck, w_x = X cos(lambda t).
It subtracts the power lost in the bearing, c X² lambda²/(2 (lambda² + (c/J)²)), from the kinetic energy, which gives
the growth of X.

Source: P. C. Hughes, Spacecraft Attitude Dynamics (1986), sections 5.1 and 5.2; W. T. Thomson, Introduction to Space
Dynamics (1961), section 7.4.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import sympy

import freebody as fb

from ..tools.answer import Answer, Answers, Check, Plots, Solved, same
from ..tools.case import Case, explain, happened
from ..tools.entry import Entry

LONG = 20
"""Limit for reaching 45 degrees, in lengths of the run: a stiff bearing dissipates hardly any energy."""

START = {"C_wx": "w_x", "C_wz": "spin"}
SPEEDS = ("C_wx", "C_wy", "C_wz")


def build() -> fb.System:
    """Return the satellite in a frame at its mass centre, without weight; the wheel is also there."""
    s = fb.System("flat_spin")
    I_x, I_y, I_z = s.parameters(I_x=1.0, I_y=1.2, I_z=0.4)
    J, J_t, c = s.parameters(J=0.05, J_t=0.03, c=0.2)
    s.parameters(spin="2*pi", w_x=0.1, t_1=60.0)
    s.assume(I_x > 0, I_y > 0, I_z > 0)
    hull = s.body(
        "hull",
        fb.MassProperties(1, (0, 0, 0), ((I_x, 0, 0), (0, I_y, 0), (0, 0, I_z))),
        shape=fb.cylinder(1, 0.45, 2.2),
    )
    wheel = s.body(
        "wheel",
        fb.MassProperties(1, (0, 0, 0), ((J, 0, 0), (0, J_t, 0), (0, 0, J_t))),
        shape=fb.cylinder(1, 0.3, 0.12, axis="x"),
    )
    s.ball("C", s.ground, hull)
    axle = s.hinge("axle", hull, wheel, axis="x", coordinate="delta")
    s.damper("bearing", axle, damping=c)
    explain(
        s,
        I_x="kg m²: moment of inertia of the hull about x, the axle of the wheel",
        I_y="kg m²: moment of inertia of the hull about y",
        I_z="kg m²: moment of inertia of the hull about z, its long axis",
        J="kg m²: moment of inertia of the wheel about its axle",
        J_t="kg m²: moment of inertia of the wheel across its axle",
        c="N m s/rad: damping of the wheel's bearing",
        spin="rad/s: angular velocity about z at the start",
        w_x="rad/s: angular velocity about x at the start, from which the wobble grows",
        t_1="s: time to answer for",
    )
    return s


def moments(case: Case) -> tuple[Any, Any, Any]:
    """Return the moments of inertia of hull and wheel about x, y, z: the diagonal of the mass matrix."""
    M = case.equations.mass_matrix
    return M[0, 0], M[1, 1], M[2, 2]


def stuck(case: Case) -> Any:
    """Return the squared frequency of the wobble about z with the wheel stuck, from the linear equations across z."""
    e, atoms = case.equations, case.atoms
    rates = [atoms["C_wx"], atoms["C_wy"]]
    turning = case.put(e.bias[:2, :].jacobian(rates), {"C_wx": 0, "C_wy": 0, "C_wz": "spin", "delta'": 0})
    A, B, _ = moments(case)
    return sympy.factor(-turning[0, 1] * turning[1, 0] / (A * B))


def energy_sink(case: Case) -> Any:
    """Return the energy-sink growth rate of the wobble [1/s]: power lost over twice the energy of the wobble."""
    A, _, C = moments(case)
    J, c = case.atoms["J"], case.atoms["c"]
    square = stuck(case)
    # at fixed H: 2 T = H²/C - A (A - C)/C X²
    depth = A * (A - C) / C
    lost = c * square / (2 * (square + (c / J) ** 2))
    return sympy.factor(lost / depth)


def growth(case: Case) -> float:
    """Return the largest growth rate of the wobble in the linear equations of hull and wheel about the spin [1/s]."""
    e = case.equations
    spinning = {**dict.fromkeys(("C_wx", "C_wy", "delta'"), 0), "C_wz": "spin", "delta": 0}
    speeds = [case.atoms[name] for name in (*SPEEDS, "delta'")]
    turning = case.numbers(case.put(e.bias.jacobian(speeds), spinning))
    roots = np.linalg.eigvals(-np.linalg.solve(case.numbers(e.mass_matrix, spinning), turning))
    wobble = roots[np.abs(roots.imag) > 1e-6 * abs(case["spin"])]
    return float(np.max(wobble.real))


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    A, B, C = moments(case)
    numbers = np.array([case.number(x) for x in (A, B, C)])
    case.refuse_unless("spin", case["spin"] != 0, "a spin that is not 0")
    case.refuse_unless(
        "I_z", numbers[2] < numbers[:2].min(), "z to be the axis of the smallest moment: a slender hull"
    )
    case.refuse_unless(
        "w_x", case["w_x"] != 0, "a start with some wobble, an angular velocity about x that is not 0"
    )
    case.refuse_unless("c", case["c"] > 0, "a damping greater than 0")
    spin, w_x = case.atoms["spin"], case.atoms["w_x"]
    H2 = (A * w_x) ** 2 + (C * spin) ** 2
    major = (A, B)[int(np.argmax(numbers[:2]))]
    # H_z falls through H/sqrt(2) repeatedly while it wobbles
    along = math.copysign(numbers[2], case["spin"])
    half = math.sqrt(case.number(H2) / 2)
    name, level = "45 degrees from H", f"{along:.17g}*C_wz - {half:.17g}"
    events = [fb.event(level, name=name)]
    first = [fb.event(level, name=name, terminal=True)]
    beyond = abs(numbers[2] * case["spin"]) <= half
    crossed = () if beyond else happened(
        case.simulate(LONG * case.until, initial=START, events=first, samples=2), name
    )  # fmt: skip
    never = (
        "none: it is further from the start"
        if beyond
        else f"none: not in {LONG * case.until:g} s, {LONG} times the run"
    )
    motion = case.simulate(initial=START, events=events, samples=6001)
    at = case.simulate_to([case["t_1"]], initial=START)
    answers: Answers = {
        "I": Answer("I_x, I_y, I_z of hull and wheel", tuple(numbers.tolist()), "kg m²", how="mass matrix"),
        "H": case.formula("angular momentum", sympy.sqrt(H2), "kg m²/s", "mass matrix times speeds at the start"),
        "T_0": case.formula(
            "kinetic energy at the start", (A * w_x**2 + C * spin**2) / 2, "J", "mass matrix"
        ),
        "T_min": case.formula(
            "least kinetic energy with this angular momentum, H²/(2 I_max)", H2 / (2 * major), "J", "mass matrix"
        ),
        "axis": Answer(
            "axis about which the satellite turns in the end", "xy"[int(np.argmax(numbers[:2]))], "", how="mass matrix"
        ),
        "growth_sink": case.formula(
            "growth rate of the wobble, energy-sink estimate", energy_sink(case), "1/s",
            "equations of motion with the wheel stuck, power of the bearing",
        ),
        "growth": Answer(
            "growth rate of the wobble, linear equations of hull and wheel", growth(case), "1/s",
            how="eigenvalues of the equations of motion about the spin",
        ),
        "t_45": Answer(
            "time at which the long axis is 45 degrees from H",
            crossed[0].time if crossed else never, "s" if crossed else "",
            how="fb.simulate, event located",
        ),
        "T(t_1)": Answer("kinetic energy at t_1", float(at.energy.kinetic[0]), "J", how="fb.simulate"),
        "omega(t_1)": Answer(
            "omega in body axes at t_1", tuple(float(at[name][0]) for name in SPEEDS), "rad/s", how="fb.simulate"
        ),
    }  # fmt: skip
    return Solved(motion, answers, plots(case, motion, answers), checks(case, motion, answers))


def momentum(case: Case, motion: fb.Trajectory) -> np.ndarray:
    """Return the angular momentum in ground axes at the output times, shape (times, 3)."""
    return np.stack([motion[part] for part in case.equations.momentum.angular()], axis=-1)


def checks(case: Case, motion: fb.Trajectory, answers: Answers) -> tuple[Check, ...]:
    """Check H (constant to round-off at the steps), T (falls to its least), and growth against linear theory."""
    exact = case.simulate(initial=START, method="gauss", tolerance=1e-15, samples=101)
    H = momentum(case, exact)
    T = motion.energy.kinetic
    least, start = answers["T_min"].value, answers["T_0"].value
    return (
        same("angular momentum vector along the motion and at its start, Gauss collocation", H, H[:1], 1e-12),
        Check(
            "kinetic energy below H²/(2 I_max), relative",
            float(least - T.min()) / start,
            1000 * case.tolerance,
        ),
        Check(
            "largest rise of the kinetic energy, relative",
            float(np.diff(T).max()) / start,
            1000 * case.tolerance,
        ),
        same("growth rate of a small wobble, simulated and linear", *grown(case), 1e-3),
    )


def grown(case: Case) -> tuple[float, float]:
    """Return the growth rate of a very small wobble, from its energy 200 wobbles later, and that of the equations.

    The energy of the wobble is taken at fixed H: H²/(2 C) - T, quadratic in the speeds across z.
    """
    small = case.having(w_x=1e-5 * case["spin"])
    A, B, C = (small.number(x) for x in moments(small))
    rate = growth(small)
    period = 2 * math.pi / math.sqrt(small.number(stuck(small)))
    # after the transient of the wheel
    first = 20 * small["J"] / small["c"]
    times = first + np.linspace(0, min(2.0 / rate, 200 * period), 400)
    at = small.simulate_to(times, initial=START, tolerance=1e-12)
    energy = A * (A - C) * at["C_wx"] ** 2 + B * (B - C) * at["C_wy"] ** 2
    return float(np.polyfit(times, np.log(energy), 1)[0]) / 2, rate


def plots(case: Case, motion: fb.Trajectory, answers: Answers) -> Plots:
    """Return plots of the speeds, the energy, the long axis, and the polhode that winds from z to the major axis."""
    from ...picture.plots.plots import energy_residual, history, saved
    from ...picture.plots.sphere import axis_path

    H = momentum(case, motion)[0]
    return {
        "omega.png": saved(lambda: history(motion, list(SPEEDS), title="Angular velocity in body axes")),
        "energy.png": saved(lambda: falling(motion, answers)),
        "long_axis.png": saved(
            lambda: axis_path(
                motion,
                "hull",
                about=H,
                about_name="the angular momentum H",
                title="Path of the long axis",
                view=(30.0, -58.0),
            )
        ),
        "momentum_sphere.png": saved(lambda: winding(case, motion)),
        "ledger.png": saved(lambda: energy_residual(motion)),
    }


def falling(motion: fb.Trajectory, answers: Answers) -> Any:
    """Draw the kinetic energy between its values for the spin about z and the spin about the major axis."""
    from ...picture.plots.plots import COLORS, INK, figure

    ax = figure(8, 4.4).subplots()
    ax.plot(motion.t, motion.energy.kinetic, color=COLORS[0], linewidth=1.8)
    for key, label in (("T_0", "at the start"), ("T_min", "H²/(2 I_max)")):
        ax.axhline(answers[key].value, color=INK, linestyle="--", linewidth=1.0)
        ax.annotate(
            label, (0.99, answers[key].value), xycoords=("axes fraction", "data"), ha="right",
            va="bottom", xytext=(0, 3), textcoords="offset points",
        )  # fmt: skip
    ax.set_ylim(0, 1.15 * answers["T_0"].value)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("kinetic energy [J]")
    ax.grid(alpha=0.3)
    ax.set_title("Energy runs out, angular momentum stays", loc="left", fontweight="bold")
    return ax


def winding(case: Case, motion: fb.Trajectory) -> Any:
    """Draw the direction of H in the body on the unit sphere: it winds from the long axis to the major axis."""
    from ..tools.pictures import seen_in_body

    return seen_in_body(
        motion,
        "hull",
        momentum(case, motion),
        "H as the body sees it",
        "from the long axis z to the major axis",
    )


FLAT_SPIN = Entry(
    "flat-spin",
    ("major-axis-rule", "energy-dissipation"),
    "Flat spin of a slender satellite with a damped wheel (major-axis rule)",
    (
        "angular momentum, kinetic energy and its least value",
        "growth of the wobble: energy-sink estimate, linear equations",
        "time to 45 degrees; energy and angular velocity at t_1",
    ),
    build,
    solve,
    until=240.0,
)
