"""Slender satellite with a damper inside: from spin about its long axis into the flat spin.

The axes of the satellite are 1, 2, 3 = x, y, z; axis 3 is the long one, with the smallest moment of inertia. A ball in
a viscous fluid at its mass centre takes energy out of the motion, but no angular momentum.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved, same
from ..tools.case import Case, explain, states
from ..tools.entry import Entry
from ..tools.pictures import lines

START = {"C_wx": "w_1", "C_wz": "omega_0"}


def build() -> fb.System:
    """Return the system in a frame that moves with the mass centre; masses have no effect."""
    s = fb.System("energy_sink")
    I_1, I_2, I_3 = s.parameters(I_1=80.0, I_2=100.0, I_3=40.0)
    I_D, c = s.parameters(I_D=8.0, c=3.0)
    s.parameters(omega_0=1.0, w_1=0.02, t_1=100.0)
    s.assume(I_1 > 0, I_2 > 0, I_3 > 0, I_D > 0)
    body = s.body(
        "body",
        fb.MassProperties(1, (0, 0, 0), ((I_1, 0, 0), (0, I_2, 0), (0, 0, I_3))),
        shape=fb.cylinder(1, 5, 24),
    )
    ball = s.body(
        "ball",
        fb.MassProperties(1, (0, 0, 0), ((I_D, 0, 0), (0, I_D, 0), (0, 0, I_D))),
        shape=fb.sphere(1, 3),
    )
    s.ball("C", s.ground, body)
    s.ball("D", body, ball)
    drag = tuple(-c * s.expression(f"D_w{axis}") for axis in "xyz")
    s.torque("fluid", ball, drag, frame=ball, reaction_on=body)
    explain(
        s,
        I_1="kg m²: moment of inertia about axis 1, without the ball",
        I_2="kg m²: moment of inertia about axis 2, the largest",
        I_3="kg m²: moment of inertia about axis 3, the smallest",
        I_D="kg m²: moment of inertia of the ball",
        c="N m s/rad: drag of the fluid on the ball",
        omega_0="rad/s: spin about axis 3 at the start, the ball at rest in the satellite",
        w_1="rad/s: angular velocity about axis 1 at the start",
        t_1="s: time to answer for",
    )
    return s


AT_START = {"C_e0": 1, "C_e1": 0, "C_e2": 0, "C_e3": 0, "D_e0": 1, "D_e1": 0, "D_e2": 0, "D_e3": 0}
"""Start with body axes along inertial axes and the ball along body axes; its attitude does not matter."""


def whole(**rates: Any) -> dict[str, Any]:
    """Return the state in which satellite and ball rotate as one body."""
    still = dict.fromkeys((f"{joint}_w{axis}" for joint in "CD" for axis in "xyz"), 0)
    return {**AT_START, **still, **{f"C_w{axis}": rate for axis, rate in rates.items()}}


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, saved

    e = case.equations
    case.refuse_unless("c", case["c"] > 0, "a drag above 0: without it no energy is lost")
    case.refuse_unless("omega_0", case["omega_0"] > 0, "a spin above 0")
    for name in ("I_1", "I_3"):
        case.refuse_unless(
            name, case[name] < case["I_2"], "I_1 and I_3 below I_2: axis 2 is the one of flat spin"
        )
    start, last = whole(x="w_1", z="omega_0"), sympy.Symbol("omega_f")
    momentum = e.momentum.angular()
    H_0, H_f = (case.put(momentum, state).expand() for state in (start, whole(y=last)))
    # H_f lies along axis 2 and has the magnitude of H_0
    flat = sympy.sqrt(H_0.dot(H_0)) / H_f[1].coeff(last)
    kinetic = e.energy.kinetic
    how = "fb.equations(s).momentum.angular(), the same before and after"
    answers: Answers = {
        "omega_f": case.formula("spin about axis 2 in the end", flat, "rad/s", how),
        "T_0": case.formula(
            "kinetic energy at the start", case.put(kinetic, start), "J", "fb.equations(s).energy.kinetic"
        ),
        "T_f": case.formula("kinetic energy in the end", case.put(kinetic, whole(y=flat)), "J", how),
    }
    growth = {}
    for axis, name in ((3, "z"), (2, "y")):
        roots = fb.linearize(e, {f"C_w{name}": case["omega_0"]}, values=case.values).eigenvalues().real
        # the roots that belong to the attitude have no real part
        growth[axis] = float(max(roots[abs(roots) > 1e-9 * case["omega_0"]]))
        answers[f"sigma_{axis}"] = Answer(
            f"rate at which a wobble about spin omega_0 along axis {axis} grows",
            growth[axis], "1/s", how="fb.linearize(s, values=...) at this spin",
        )  # fmt: skip
    at = case.simulate_to([0.0, case["t_1"]], initial=START)
    answers |= states(at, 1, {f"C_w{axis}": "rad/s" for axis in "xyz"}, "t_1")
    answers["nutation(t_1)"] = Answer(
        "angle of axis 3 with the angular momentum at t_1",
        float(nutation(case, at)[1]),
        "rad",
        how="fb.simulate",
    )
    bound = 1000 * case.tolerance
    end = case.simulate(
        30 / abs(growth[3]) + 30 / abs(growth[2]) if growth[3] > 0 > growth[2] else case["t_1"], initial=START
    )
    trajectory = case.motion(initial=START)
    H = [trajectory[part] for part in momentum]
    checks: tuple[Any, ...] = (same("angular momentum is kept", H, case.numbers(H_0), bound),)
    if growth[3] > 0 > growth[2]:
        checks += (
            same(
                "spin about axis 2 in the end, simulated",
                abs(end["C_wy"][-1]),
                answers["omega_f"].value,
                1e-6,
            ),
        )
    plots: Plots = {
        "omega.png": saved(
            lambda: history(
                trajectory, ["C_wx", "C_wy", "C_wz"], title="Satellite with a damper: into the flat spin"
            )
        ),
        "nutation.png": saved(
            lambda: lines(
                trajectory.t,
                {
                    "axis 3 from H [deg]": {"nutation": np.rad2deg(nutation(case, trajectory))},
                    "kinetic energy [J]": {"T": trajectory.energy.kinetic},
                },
                "Energy falls, momentum stays: the long axis turns away",
            )
        ),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


def nutation(case: Case, trajectory: fb.Trajectory) -> np.ndarray:
    """Return the angle of axis 3 with the angular momentum at every output time."""
    H = np.array([trajectory[part] for part in case.equations.momentum.angular()]).T
    axis = trajectory.poses["body"].rotation[:, :, 2]
    across = np.linalg.norm(np.cross(axis, H), axis=1)
    return np.arctan2(across, (axis * H).sum(axis=1))


ENERGY_SINK = Entry(
    "energy-sink",
    ("internal-damper",),
    "Slender satellite with an inner damper goes into the flat spin (beyond the chapter)",
    (
        "spin and energy in the end",
        "rates at which a wobble grows about axis 3 and about axis 2",
        "angular velocity and nutation angle at t_1",
    ),
    build,
    solve,
    until=400.0,
    positive=("w_1",),
    start=START,
    bodies=("body",),
)
