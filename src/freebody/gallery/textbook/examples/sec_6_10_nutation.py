"""Small oscillation of a gyroscope about its steady slow precession (chapter, section 6.10).

The equations give the steady motion: the spin that keeps theta_0 at the precession rate psi'. The equations are
linearised about it, and the linear equations are solved in closed form.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import sympy

import freebody as fb

from ....symbolic.printing.display import displayed, text
from ...tools.answer import Answer, Answers, Check, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ...tools.pictures import lines
from ...tools.precession import between, path_class, steady_root
from .sec_6_9_gyroscope import MOMENTS, top


def build() -> fb.System:
    """Return the gyroscope with small changes of its angular velocity."""
    s = top("nutation", w_xi=0.05, w_eta=0.08, t_1=0.1)
    explain(
        s,
        w_xi="rad/s: change of the angular velocity along the nodal axis: theta' at the start",
        w_eta="rad/s: change of the angular velocity across it: psi' sin(theta_0) at the start",
        t_1="s: time to answer for",
    )
    return s


def slow_precession(case: Case) -> Any:
    """Return the slow rate at theta_0 in the parameters.

    Raises
    ------
    ModelError
        The spin is too small for a steady precession.
    """
    between(case)
    _, slow, exists = steady_root(case, "theta_0")
    if not exists:
        raise fb.errors.ModelError(
            f"Expected a spin with a steady precession at theta_0 = {case['theta_0']:g} rad, got Omega_zeta = "
            f"{case['Omega_zeta']:g} rad/s: it is too small. Spin faster, or lower the shaft."
        )
    return slow


@dataclass(frozen=True)
class LinearTheory:
    """Small motions about steady precession at theta_0, in symbols: rate, initial changes, and time.

    theta and psi contain the frequency ``omega_n`` and the coupling ``sigma`` of the two equations (6.113) as symbols.
    """

    rate: Any
    theta_rate: Any
    psi_rate: Any
    t: Any
    frequency: Any
    omega_n: Any
    coupling: Any
    sigma: Any
    theta: Any
    psi: Any

    def at(self, x: Any, **values: Any) -> Any:
        """Return an expression with other expressions in place of ``rate``, ``theta_rate``, ``psi_rate`` and ``t``."""
        return x.xreplace({getattr(self, name): sympy.sympify(value) for name, value in values.items()})

    def written_out(self, name: str, slow: Any, **changes: Any) -> Any:
        """Return theta or psi in the parameters and the time, about the slow precession."""
        x = self.at(getattr(self, name), **changes)
        for names in ({"omega_n": self.frequency}, {"sigma": self.coupling}, {"rate": slow}):
            x = self.at(x, **names)
        return x


@cache
def linear_theory() -> LinearTheory:
    """Return the linear equations about steady precession and their response, derived once for all values."""
    e = fb.equations(top("nutation"))
    atoms = e.model.names.atoms
    rate, theta_rate, psi_rate = (sympy.Dummy(name, real=True) for name in ("rate", "theta_rate", "psi_rate"))
    steady = fb.steady_motions(e, solve_for="phi'")[0].solution["phi'"]
    spin = steady.xreplace({atoms["psi'"]: rate, atoms["theta"]: atoms["theta_0"]})
    model = fb.linearize(e, {"theta": "theta_0", "psi'": rate, "phi'": spin})
    # the total spin along the shaft is constant
    changes = {"theta'": theta_rate, "psi'": psi_rate, "phi'": -psi_rate * sympy.cos(atoms["theta_0"])}
    results: Any = model.response(changes)
    (t,) = {x for x in results["theta"].free_symbols if x.name == "t"}
    (frequency,) = model.natural_frequencies()
    omega_n, sigma = sympy.symbols("omega_n sigma", real=True)
    # steady precession: the moment of the weight, g times this, is that of I_xi (sigma + psi' cos theta_0) psi'
    arm = sympy.diff(e.energy.potential, atoms["g"]).subs(sympy.cos(atoms["theta"]), 1)
    turning = e.mass_matrix[1, 1] * rate
    cosine = rate * sympy.cos(atoms["theta_0"])
    by_sigma = {atoms["g"]: (sigma + cosine) * turning / arm}
    frequency = displayed(e.ring.from_sympy(frequency.xreplace(by_sigma)), e.ring)
    theta, psi = (
        arranged(e.ring, results[name].xreplace(by_sigma), frequency, omega_n, t) for name in ("theta", "psi")
    )
    return LinearTheory(
        rate, theta_rate, psi_rate, t, frequency, omega_n, atoms["g"] * arm / turning - cosine, sigma,
        atoms["theta_0"] + theta, rate * t + psi,
    )  # fmt: skip


def arranged(ring: Any, x: Any, frequency: Any, omega_n: Any, t: Any) -> Any:
    """Return a + b t + c cos(omega_n t) + d sin(omega_n t), with each coefficient over a suitable power of omega_n."""
    C, S = sympy.Dummy("C"), sympy.Dummy("S")
    turning = {f: C if isinstance(f, sympy.cos) else S for f in x.atoms(sympy.sin, sympy.cos) if f.has(t)}
    y = x.xreplace(turning)
    still = y.xreplace({C: sympy.Integer(0), S: sympy.Integer(0)})
    parts = {
        sympy.Integer(1): still.xreplace({t: sympy.Integer(0)}),
        t: sympy.diff(still, t),
        sympy.cos(omega_n * t): sympy.diff(y, C),
        sympy.sin(omega_n * t): sympy.diff(y, S),
    }
    result = sympy.Integer(0)
    for basis, coefficient in parts.items():
        cleared = [ring.from_sympy(coefficient * frequency**n) for n in range(4)]
        n = min(range(4), key=lambda n: len(text(cleared[n], ring)))
        result += displayed(cleared[n], ring) / omega_n**n * basis
    return result


def start(case: Case, slow: Any, theta_rate: Any, psi_rate: Any) -> dict[str, float]:
    """Return the state after a change of theta' and psi' at constant total spin."""
    rates = {"theta'": case.number(theta_rate), "psi'": case.number(slow + psi_rate)}
    spin = case["Omega_zeta"] - rates["psi'"] * case.number(sympy.cos(case.atoms["theta_0"]))
    return {"theta": case["theta_0"], **rates, "phi'": spin}


def theory_and_truth(case: Case, slow: Any, theta_rate: Any, psi_rate: Any) -> tuple[Answers, dict[str, Any]]:
    """Return answers of linear theory and simulation at t_1, and the linear response as functions of time."""
    theory, atoms = linear_theory(), case.atoms
    changes = {"theta_rate": theta_rate, "psi_rate": psi_rate}
    response = {name: theory.at(getattr(theory, name), **changes) for name in ("theta", "psi")}
    about = "about the slow precession, whose rate is psi'"
    where = {"omega_n": theory.at(theory.frequency, rate=atoms["psi'"]), **coupling(case, slow)}
    answers: Answers = {
        f"{name}_linear(t_1)": case.formula(
            f"linear theory {about}: {name} at t_1", theory.at(x, t=atoms["t_1"], rate=atoms["psi'"]), "rad",
            "fb.linearize(s, steady).response(...)", where=where,
        )
        for name, x in response.items()
    }  # fmt: skip
    at = case.simulate_to([case["t_1"]], initial=start(case, slow, theta_rate, psi_rate))
    for name in ("theta", "psi"):
        answers[f"{name}(t_1)"] = Answer(
            f"exact, nonlinear {name} at t_1", float(at[name][0]), "rad", how="fb.simulate"
        )
    drawn = {
        name: case.put(theory.written_out(name, slow, **changes), case.values) for name in ("theta", "psi")
    }
    return answers, {name: sympy.lambdify(theory.t, x, "numpy") for name, x in drawn.items()}


def coupling(case: Case, slow: Any) -> dict[str, Any]:
    """Return the meaning of sigma and psi' in formulas of the linear theory."""
    theory = linear_theory()
    return {"sigma": theory.at(theory.coupling, rate=case.atoms["psi'"]), "psi'": slow}


def frequency(case: Case, slow: Any) -> Answer:
    """Return the frequency of the small oscillation about the slow precession."""
    theory = linear_theory()
    return case.formula(
        "frequency of the small oscillation, linear theory, where psi' is the slow precession rate",
        theory.at(theory.frequency, rate=case.atoms["psi'"]), "rad/s",
        "fb.linearize(s, steady).natural_frequencies()", where=coupling(case, slow),
    )  # fmt: skip


PARTS = 2.0 ** -np.arange(8)
"""Sizes of the change at which the linear theory is tested, over the advance psi' sin(theta_0) of the axis."""


def errors(case: Case, slow: Any, w_xi: float, w_eta: float) -> dict[str, np.ndarray]:
    """Return rms errors of the linear theory over three nutations, as arcs on the unit sphere, for each size.

    The change has the direction of (w_xi, w_eta), or of the nodal axis if both are zero, and each of the sizes
    ``PARTS``. A mean error is smooth in the size; a maximum error is not. Small changes have small errors, so the
    motions are simulated with a fine tolerance.
    """
    theory, theta_0 = linear_theory(), case.atoms["theta_0"]
    rate, sine = case.number(slow), case.number(sympy.sin(theta_0))
    period = 2 * np.pi / case.number(theory.at(theory.at(theory.frequency, sigma=theory.coupling), rate=slow))
    t = np.linspace(0, 3 * period, 301)
    size = float(np.hypot(w_xi, w_eta))
    direction = (w_xi / size, w_eta / size) if size else (1.0, 0.0)
    results: dict[str, list[float]] = {"theta": [], "psi sin(theta_0)": []}
    for part in PARTS:
        w = [part * abs(rate) * sine * x for x in direction]
        changes = {"theta_rate": w[0], "psi_rate": w[1] / sine}
        begun = start(case, slow, *changes.values())
        exact = case.simulate_to(t, initial=begun, tolerance=min(case.tolerance, 1e-12))
        for name, scale, errs in zip(("theta", "psi"), (1.0, sine), results.values(), strict=True):
            x = theory.written_out(name, slow, **changes)
            linear = sympy.lambdify(theory.t, case.put(x, case.values), "numpy")(t)
            errs.append(scale * float(np.sqrt(np.mean((linear - exact[name]) ** 2))))
    return {name: np.array(errs) for name, errs in results.items()}


def orders(results: dict[str, np.ndarray]) -> dict[str, float]:
    """Return the order of each error, from three sizes: the next order of the error is cancelled.

    log2(e(w)/e(w/2)) = 2 + c w + O(w²), so twice the value of the smaller pair minus that of the larger is 2 + O(w²).
    """
    slopes = {name: -np.diff(np.log2(errs[4:7])) for name, errs in results.items()}
    return {name: float(2 * slope[1] - slope[0]) for name, slope in slopes.items()}


def growth(results: dict[str, np.ndarray]) -> Any:
    """Draw the errors over the size of the change on logarithmic scales, with a quadratic for comparison."""
    from ....picture.plots.plots import COLORS, INK, figure

    ax = figure(8, 5).subplots()
    for (name, errs), color in zip(results.items(), COLORS, strict=False):
        ax.loglog(PARTS, errs, "o-", color=color, linewidth=1.6, label=name)
    square = results["theta"][-1] * (PARTS / PARTS[-1]) ** 2 / 2
    ax.loglog(PARTS, square, "--", color=INK, linewidth=1.2, label="second order")
    ax.set_xlabel("change of the angular velocity, over psi' sin(theta_0)")
    ax.set_ylabel("rms error over three nutations [rad]")
    ax.grid(alpha=0.3, which="both")
    ax.legend(frameon=False)
    ax.set_title("Error of the linear theory", loc="left", fontweight="bold")
    return ax


def plots(case: Case, trajectory: fb.Trajectory, theory: dict[str, Any]) -> Plots:
    """Return plots of theta and psi, linear and exact, and of the path of the spin axis."""
    from ....picture.plots.plots import energy_residual, saved
    from ....picture.plots.sphere import axis_path

    def both(name: str, title: str) -> Any:
        t = trajectory.t
        exact, linear = trajectory[name], theory[name](t)
        return lines(
            t,
            {
                f"{name} [rad]": {"exact": exact, "linear theory": linear},
                "difference [rad]": {"linear theory - exact": linear - exact},
            },
            title,
        )

    return {
        "theta.png": saved(lambda: both("theta", "Nutation about the slow precession")),
        "psi.png": saved(lambda: both("psi", "Precession, linear and exact")),
        "spin_axis.png": saved(lambda: axis_path(trajectory, "rotor", title="Path of the spin axis")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import saved

    slow = slow_precession(case)
    w_xi, w_eta = case.atoms["w_xi"], case.atoms["w_eta"]
    changes = (w_xi, w_eta / sympy.sin(case.atoms["theta_0"]))
    results, theory = theory_and_truth(case, slow, *changes)
    answers: Answers = {"omega_n": frequency(case, slow), **results}
    begun = start(case, slow, *changes)
    answers["path"] = Answer(
        "path of the axis on the unit sphere, exact",
        path_class(case, begun),
        "",
        how="fb.equations(s).integrals",
    )
    measured = errors(case, slow, case["w_xi"], case["w_eta"])
    order = orders(measured)
    answers["error_order"] = Answer(
        "order to which the error of the linear theta grows with the change", order["theta"], "1",
        how="fb.simulate at eight sizes of the change",
    )  # fmt: skip
    trajectory = case.motion(initial=begun)
    pictures = plots(case, trajectory, theory) | {"error.png": saved(lambda: growth(measured))}
    return Solved(trajectory, answers, pictures, (steadiness(case, slow), *second_order(order)))


def second_order(order: dict[str, float]) -> tuple[Check, ...]:
    """Check that the errors of theta and psi are of the second order."""
    return tuple(
        Check(f"order of the error of the linear {name}, and 2", abs(x - 2), 0.1) for name, x in order.items()
    )


def steadiness(case: Case, slow: Any) -> Any:
    """Check that theta is constant without a change: the steady precession solves the nonlinear equations."""
    still = case.simulate_to([case["t_1"]], initial=start(case, slow, 0, 0))
    return same(
        "theta stays at theta_0 in steady precession", still["theta"], case["theta_0"], 1000 * case.tolerance
    )


NUTATION = Entry(
    "sec-6-10",
    ("nutation", "small-oscillation"),
    "Small oscillation of a gyroscope about steady slow precession (section 6.10)",
    (
        "frequency of the small oscillation in the linear theory",
        "theta and psi at t_1 in the linear theory",
        "theta and psi at t_1, exact (nonlinear)",
        "path of the axis; order of the error of the linear theory",
    ),
    build,
    solve,
    until=0.5,
    start={"theta": "theta_0", "phi'": "Omega_zeta"},
    names=MOMENTS,
)
