"""Loops, cusps and waves: the path of a gyroscope's axis on the unit sphere (chapter, figures 6.11 and 6.12).

The axis precesses steadily at theta_0; then its angular velocity is changed by w in the direction gamma,
w_xi = w cos(gamma), w_eta = w sin(gamma). The linear theory draws a circle that advances; the path has cusps where
the change is as large as the advance, w = psi' sin(theta_0). The integrals give the exact condition: at a cusp the
axis stands still, so that

    E - E_spin = m g L cos(theta),   p_psi = I_zeta Omega cos(theta)

there, so that (E - E_spin) I_zeta Omega = m g L p_psi. With the rate r = m g L/(I_zeta Omega) this is
theta'(0)² + sin²(theta_0) (psi'(0) - r)² = (r sin(theta_0))²: a circle again, about the approximate rate r of (6.102).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import sympy

import freebody as fb

from ..textbook.examples.sec_6_9_gyroscope import EVENTS, MOMENTS, top
from ..textbook.examples.sec_6_10_nutation import linear_theory, slow_precession, start
from ..tools.answer import Answer, Answers, Check, Plots, Solved, same
from ..tools.case import Case, explain, happened
from ..tools.entry import Entry
from ..tools.precession import left_at_stop, path_class, stop

KINDS = ("loop", "cusp", "wave")


def build() -> fb.System:
    """Return a gyroscope that spins slowly enough for a visible nutation."""
    s = top("precession_paths", Omega_zeta=150.0, gamma="30deg", loop=1.8, wave=0.4)
    explain(
        s,
        gamma="rad: direction of the change of the angular velocity, from the nodal axis xi to eta",
        loop="1: the change of the first motion, over that of the cusp",
        wave="1: the change of the third motion, over that of the cusp",
    )
    return s


def cusp_change(case: Case, stop_rate: Any, r: Any) -> Any:
    """Return the change w in the direction gamma after which the path has cusps; psi' is the slow rate.

    The symbol ``r`` replaces ``stop_rate``, which falls with the spin.
    """
    w, rate, gamma, theta = (
        sympy.Dummy("w"), case.atoms["psi'"], case.atoms["gamma"], case.atoms["theta_0"]
    )  # fmt: skip
    turned = rate + w * sympy.sin(gamma) / sympy.sin(theta)
    begun = {
        "theta": theta,
        "theta'": w * sympy.cos(gamma),
        "psi'": turned,
        "phi'": case.atoms["Omega_zeta"] - turned * sympy.cos(theta),
    }
    _, left = left_at_stop(case, begun)
    c, b, a = (sympy.Poly(sympy.expand(left), w).coeff_monomial(w**k) for k in range(3))
    # without a change no energy remains at the stop: c < 0 < a, and one root is positive
    spin = case.atoms["Omega_zeta"]
    c, b = (sympy.cancel(x / a).xreplace({spin: sympy.cancel(stop_rate * spin) / r}) for x in (c, b))
    return sympy.sqrt((b / 2) ** 2 - c) - b / 2


@dataclass(frozen=True)
class Path:
    """A motion: the change w [rad/s], the trajectory, its class by the integrals, and its two limits."""

    change: float
    motion: fb.Trajectory
    kind: str
    upper: Mapping[str, float]
    lower: Mapping[str, float]


def paths(case: Case, slow: Any, cusp: float) -> dict[str, Path]:
    """Return the three motions by name."""
    paths_by_name = {}
    gamma, theta = case.atoms["gamma"], case.atoms["theta_0"]
    for name, factor in zip(KINDS, (case["loop"], 1.0, case["wave"]), strict=True):
        w = factor * cusp
        begun = start(case, slow, w * sympy.cos(gamma), w * sympy.sin(gamma) / sympy.sin(theta))
        long = case.simulate_past("smallest theta", 2, initial=begun, events=EVENTS)
        upper, lower = (happened(long, f"{end} theta")[0].state for end in ("smallest", "largest"))
        motion = case.motion(initial=begun, events=EVENTS)
        paths_by_name[name] = Path(w, motion, path_class(case, begun), upper, lower)
    if paths_by_name["cusp"].kind != "cusp":
        raise fb.errors.ModelError(
            "Expected a change of the angular velocity after which the axis comes to a stop, but in the direction "
            f"gamma = {case['gamma']:g} rad at a spin of {case['Omega_zeta']:g} rad/s it passes the vertical first. "
            "Spin faster."
        )
    return paths_by_name


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    for name in ("loop", "wave"):
        case.refuse_unless(name, case[name] > 0, f"a factor {name} of the change greater than 0")
    slow = slow_precession(case)
    weight, spin = stop(case)
    rate, theta = case.atoms["psi'"], case.atoms["theta_0"]
    r = sympy.Symbol("r", real=True)
    where = {"r": weight / spin, "psi'": slow}
    answers: Answers = {
        "psi'_slow": case.formula(
            "slow steady precession rate psi' at theta_0", slow, "rad/s",
            "equation of motion of theta at constant theta and psi'",
        ),
        "r": case.formula(
            "rate about which the exact cusps lie, that of (6.102)", weight / spin, "rad/s",
            "integrals of energy and of the momentum about the vertical, where theta' = psi' = 0",
        ),
        "w_cusp": case.formula(
            "change w in the direction gamma after which the path has cusps",
            cusp_change(case, weight / spin, r), "rad/s",
            "fb.equations(s).integrals: no energy left where psi' vanishes", where=where,
        ),
        "w_cusp_linear": case.formula(
            "the same in the linear theory: as large as the advance psi' sin(theta_0)",
            rate * sympy.sin(theta), "rad/s",
            "fb.linearize(s, steady).response(...)", where=where,
        ),
    }  # fmt: skip
    paths_by_name = paths(case, slow, answers["w_cusp"].value)
    located = "fb.simulate, event located"
    for name, path in paths_by_name.items():
        answers[f"path_{name}"] = Answer(
            f"{name}: path of the axis by the integrals of the motion",
            path.kind,
            "",
            None,
            "fb.equations(s).integrals",
        )
        answers[f"theta_top_{name}"] = Answer(
            f"{name}: upper limit of the axis, smallest theta", path.upper["theta"], "rad", how=located
        )
        answers[f"psi'_top_{name}"] = Answer(
            f"{name}: psi' there (against the precession: loop; none: cusp; with it: wave)",
            path.upper["psi'"], "rad/s", how=located,
        )  # fmt: skip
    return Solved(
        paths_by_name["cusp"].motion, answers, plots(case, slow, paths_by_name), checks(case, paths_by_name)
    )


def checks(case: Case, paths_by_name: dict[str, Path]) -> tuple[Check, ...]:
    """Check the cusp, and the sign of psi' at the upper limit against the class of each path."""
    bound = 1000 * case.tolerance
    cusp = paths_by_name["cusp"]
    turning = [path.upper["psi'"] / cusp.lower["psi'"] for path in paths_by_name.values()]
    seen = [np.sign(x) if abs(x) > bound else 0 for x in turning]
    told = [{"loop": -1, "cusp": 0, "wave": 1}[path.kind] for path in paths_by_name.values()]
    return (
        same("psi' at the upper limit of the path with cusps, and 0", cusp.upper["psi'"], 0, bound),
        same("sign of psi' at the upper limit, simulated and by the integrals", seen, told, 0),
    )


def plots(case: Case, slow: Any, paths_by_name: dict[str, Path]) -> Plots:
    """Return plots of each path on the unit sphere, and of all paths on a map with the linear theory."""
    from ...picture.plots.plots import energy_residual, saved
    from ...picture.plots.sphere import axis_path

    def sphere(name: str) -> Any:
        path = paths_by_name[name]
        return axis_path(
            path.motion,
            "rotor",
            title=f"{path.kind.capitalize()}: w = {path.change:.4g} rad/s",
            view=(38.0, -20.0),
        )

    pictures: Plots = {f"{name}.png": saved(partial(sphere, name)) for name in KINDS}
    return pictures | {
        "map.png": saved(lambda: chart(case, slow, paths_by_name)),
        "energy.png": saved(lambda: energy_residual(paths_by_name["cusp"].motion)),
    }


def chart(case: Case, slow: Any, paths_by_name: dict[str, Path]) -> Any:
    """Draw the three paths and the linear theory as arcs along and across the circle of latitude at theta_0."""
    from ...picture.plots.plots import COLORS, figure

    theory, theta_0 = linear_theory(), case["theta_0"]
    gamma, theta = case.atoms["gamma"], case.atoms["theta_0"]
    axes = figure(8, 6.6).subplots(3, 1, sharex=True)
    for ax, path in zip(axes, paths_by_name.values(), strict=True):
        changes = {
            "theta_rate": path.change * sympy.cos(gamma),
            "psi_rate": path.change * sympy.sin(gamma) / sympy.sin(theta),
        }
        t = path.motion.t
        linear = {}
        for name in ("theta", "psi"):
            x = case.put(theory.written_out(name, slow, **changes), case.values)
            linear[name] = sympy.lambdify(theory.t, x, "numpy")(t)
        for (psi, theta_t), style in (
            ((path.motion["psi"], path.motion["theta"]), {"color": COLORS[0], "label": "exact"}),
            (
                (linear["psi"], linear["theta"]),
                {"color": COLORS[1], "label": "linear theory", "linestyle": "--"},
            ),
        ):
            ax.plot(np.rad2deg(psi) * np.sin(theta_0), np.rad2deg(theta_t), linewidth=1.5, **style)
        ax.set_title(f"{path.kind}: w = {path.change:.4g} rad/s", loc="left", fontsize=10.5)
        ax.set_ylabel("theta [°]")
        ax.set_aspect("equal", adjustable="datalim")
        ax.invert_yaxis()
        ax.grid(alpha=0.3)
    axes[0].legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, frameon=False)
    axes[-1].set_xlabel("psi sin(theta_0) [°]")
    axes[0].figure.suptitle("Path of the axis: arcs on the unit sphere", x=0.03, ha="left", fontweight="bold")
    return axes


PRECESSION_PATHS = Entry(
    "precession-paths",
    ("loop-cusp-wave",),
    "Loops, cusps and waves of a gyroscope's axis (figures 6.11, 6.12)",
    (
        "change of the angular velocity that gives cusps: exact, linear theory",
        "three motions: path, upper limit of the axis, and psi' there",
    ),
    build,
    solve,
    until=1.5,
    start={"theta": "theta_0", "phi'": "Omega_zeta"},
    names=MOMENTS,
)
