"""Symmetric body with no torque about its mass centre; wobble of the earth (chapter, section 6.8).

At t = 0 body and ground axes coincide, and the angular velocity is (w_1, 0, w_3); axis 3 = z is the
symmetry axis. Case (a) is a flat body, case (b) a slender one, case (c) the earth.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy

import freebody as fb

from ...tools.answer import Answer, Answers, Check, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry

START = {"C_wx": "w_1", "C_wz": "w_3"}


def build() -> fb.System:
    """Return a body on a ball joint at its mass centre: its mass does not matter."""
    s = fb.System("torque_free")
    I_1, I_3, *_ = s.parameters(I_1=1.0, I_3=1.8, w_1=0.5, w_3=6.0, t_1=2.0)
    I_1b, I_3b, *_ = s.parameters(I_1b=1.8, I_3b=0.4, earth_ratio=0.0033, earth_spin=1.0)
    s.assume(I_1 > 0, I_3 > 0, I_1b > 0, I_3b > 0)
    body = s.body("body", fb.MassProperties(1, (0, 0, 0), ((I_1, 0, 0), (0, I_1, 0), (0, 0, I_3))))
    s.ball("C", s.ground, body)
    explain(
        s,
        I_1="kg m²: moment of inertia about a transverse axis, case (a)",
        I_3="kg m²: moment of inertia about the symmetry axis, case (a)",
        w_1="rad/s: angular velocity about axis 1 at the start",
        w_3="rad/s: angular velocity about axis 3",
        t_1="s: time to answer for",
        I_1b="kg m²: I_1 in case (b)",
        I_3b="kg m²: I_3 in case (b)",
        earth_ratio="1: (I_3 - I_1)/I_1 of the earth, case (c)",
        earth_spin="rev/day: revolutions of the earth, case (c)",
    )
    return s


SLENDER = {"I_1": "I_1b", "I_3": "I_3b"}
EARTH = {"I_1": 1, "I_3": "1 + earth_ratio"}


def rate_in_body(case: Case, w_3: Any) -> Any:
    """Return Omega of w_x' = -Omega w_y from the first equation of motion [rad per unit of time of ``w_3``]."""
    e = case.equations
    return case.put(e.bias[0].diff(case.atoms["C_wy"]), {"C_wz": w_3}) / e.mass_matrix[0, 0]


def at_start(case: Case, w: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
    """Return axis 3, omega and H at t = 0, when body and ground axes coincide; ``w`` is omega then."""
    begun = {f"C_w{axis}": x for axis, x in zip("xyz", w, strict=True)}
    upright = dict(zip(case.equations.model.coordinate_names, (1, 0, 0, 0), strict=True))
    H = case.put(case.equations.momentum.angular(), {**begun, **upright})
    return sympy.Matrix([0, 0, 1]), sympy.Matrix([begun[f"C_w{axis}"] for axis in "xyz"]), H


def angle(a: Any, b: Any) -> Any:
    """Return the angle between two vectors [rad]."""
    across = a.cross(b)
    return sympy.atan2(sympy.sqrt(across.dot(across)), a.dot(b))


def answer(
    case: Case,
    begun: tuple[Any, Any, Any],
    ending: str = "",
    label: str = "",
    body: dict[str, Any] | None = None,
) -> Answers:
    """Return the answers for a body with the initial angular velocity ``begun``, and its state at t_1.

    ``ending`` of the keys and ``label`` of the questions distinguish cases; ``body`` gives moments of inertia.
    """
    axis, w, H = at_start(case, begun)
    body = body or {}
    # axis 3 moves with the velocity w x axis; the rate of its swept angle about H is the precession
    across = H.cross(axis)
    precession = H.dot(axis.cross(w.cross(axis))) * sympy.sqrt(H.dot(H)) / across.dot(across)
    variant = case.having(
        **{name: case.number(case.system.expression(value)) for name, value in body.items()}
    )
    start = {f"C_w{axis}": variant.number(x) for axis, x in zip("xyz", begun, strict=True)}
    at = variant.simulate_to([case["t_1"]], initial=start)
    seen = at.poses["body"].rotation[0]
    turned = tuple(float(at[f"C_w{axis}"][0]) for axis in "xyz")

    def put(x: Any) -> Any:
        return case.put(sympy.factor(x), body)

    by_momentum = "fb.equations(s).momentum.angular() at t = 0"
    return {
        f"Omega{ending}": case.formula(
            f"{label}rate at which omega turns about axis 3 in the body, + from axis 1 to axis 2",
            put(rate_in_body(case, w[2])), "rad/s", "equation of motion of w_1",
        ),
        f"alpha{ending}": case.formula(
            f"{label}angle between axis 3 and H", put(angle(axis, H)), "rad", by_momentum
        ),
        f"beta{ending}": case.formula(
            f"{label}angle between axis 3 and omega", put(angle(axis, w)), "rad", "omega at t = 0"
        ),
        f"precession{ending}": case.formula(
            f"{label}rate of precession of axis 3 about H", put(precession), "rad/s", by_momentum
        ),
        f"omega{ending}(t_1)": Answer(
            f"{label}omega in body axes at t_1", turned, "rad/s", how="fb.simulate"
        ),
        f"axis{ending}(t_1)": Answer(
            f"{label}axis 3 in ground axes at t_1", tuple(seen[:, 2].tolist()), "1", how="fb.simulate"
        ),
    }  # fmt: skip


def checks(case: Case, motion: fb.Trajectory) -> tuple[Check, ...]:
    """Check that the angular momentum is constant in ground axes."""
    H = np.stack([motion[part] for part in case.equations.momentum.angular()], axis=-1)
    return (same("angular momentum along the motion and at its start", H, H[:1], 1000 * case.tolerance),)


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.cones import cones
    from ....picture.plots.plots import energy_residual, history, saved
    from ....picture.plots.sphere import axis_path

    slender = case.having(I_1=case["I_1b"], I_3=case["I_3b"])
    begun = (case.atoms["w_1"], sympy.Integer(0), case.atoms["w_3"])
    answers = answer(case, begun, "_a", "(a) ") | answer(case, begun, "_b", "(b) ", SLENDER)
    # Omega in revolutions per day, like the spin
    answers["period_c"] = case.formula(
        "(c) period of the wobble of the earth",
        case.put(1 / rate_in_body(case, "earth_spin"), EARTH), "days", "equation of motion of w_1",
    )  # fmt: skip
    flat, thin = (example.motion(initial=START) for example in (case, slender))
    momentum = case.equations.momentum.angular()

    def cone(motion: fb.Trajectory, title: str) -> Any:
        H = [motion[part][0] for part in momentum]
        return axis_path(
            motion, "body", about=H, about_name="the angular momentum H", title=title, view=(48.0, -58.0)
        )

    def omega(motion: fb.Trajectory, title: str) -> Any:
        return history(motion, ["C_wx", "C_wy", "C_wz"], title=title)

    def rolling(ending: str, example: Case, title: str) -> Any:
        # one full turn of both cones
        slowest = min(abs(answers[f"{name}{ending}"].value) for name in ("Omega", "precession"))
        once = example.simulate(
            min(2 * np.pi / slowest, case.until) if slowest else case.until, initial=START, samples=721
        )
        return cones(once, "body", title=title)

    plots: Plots = {
        "omega.png": saved(lambda: omega(flat, "(a) Flat body: angular velocity in body axes")),
        "omega_b.png": saved(lambda: omega(thin, "(b) Slender body: angular velocity in body axes")),
        "axis_3.png": saved(lambda: cone(flat, "(a) Flat body: path of axis 3")),
        "axis_3_b.png": saved(lambda: cone(thin, "(b) Slender body: path of axis 3")),
        "cones.png": saved(lambda: rolling("_a", case, "(a) Flat body: cones")),
        "cones_b.png": saved(lambda: rolling("_b", slender, "(b) Slender body: cones")),
        "energy.png": saved(lambda: energy_residual(flat)),
    }
    return Solved(flat, answers, plots, checks(case, flat))


TORQUE_FREE = Entry(
    "sec-6-8",
    ("torque-free", "wobble"),
    "Torque-free symmetric body: flat, slender, and the earth (section 6.8)",
    (
        "(a) flat, (b) slender: rate of omega in the body, angles of axis 3 with H and omega, precession rate",
        "(a), (b): omega and axis 3 at t_1",
        "(c) period of the wobble of the earth",
    ),
    build,
    solve,
    until=10.0,
)
