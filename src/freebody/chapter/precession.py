"""Section 6.10: small oscillations about steady precession, (6.107)-(6.125)."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy
from sympy import atan2, cos, sin, sqrt

import freebody as fb

from . import machines
from .gyroscope import (
    POSITIVE,
    at_steady,
    condition,
    fast_spin,
    n_spin,
    rate_0,
    rows,
    steady_spin,
    theta_0,
    top,
)
from .meaning import Meaning
from .momentum import resolved
from .small import Small, put
from .statement import Statement, is_zero

t = machines.t
ZERO = sympy.Integer(0)
eps = sympy.Symbol("epsilon")
theta_1, psi_1 = sympy.Function("theta_1")(t), sympy.Function("psi_1")(t)
lap = sympy.Symbol("s")
S, C = sin(theta_0), cos(theta_0)
sigma, w_eta0, W = sympy.symbols("sigma omega_eta0 Omega", positive=True)
w_xi, w_eta = sympy.symbols("omega_xi(0) omega_eta(0)", real=True)


@cache
def orders() -> list[tuple[Any, Any]]:
    """Return the terms of order (zero, one) in the deviations of the library's two equations, left minus right."""
    n = top().names
    theta, psi, phi = n["θ"], n["ψ"], n["φ"]
    rate = n_spin() - psi.diff(t) * cos(theta)
    deviation = [
        (theta.diff(t, 2), eps * theta_1.diff(t, 2)), (psi.diff(t, 2), eps * psi_1.diff(t, 2)),
        (theta.diff(t), eps * theta_1.diff(t)), (psi.diff(t), rate_0 + eps * psi_1.diff(t)),
        (theta, theta_0 + eps * theta_1),
    ]  # fmt: skip
    result = []
    for left, right in rows()[:2]:
        row = put(left - right, [(phi.diff(t, 2), rate.diff(t)), (phi.diff(t), rate), *deviation])
        result.append((row.subs(eps, 0), row.diff(eps).subs(eps, 0)))
    return result


def at_condition(x: Any) -> Any:
    """Return an expression with m g L from the steady condition, which is linear in g."""
    (pair,) = machines.solved([condition()], [POSITIVE["g"]])
    return sympy.expand(put(x, [pair]))


@cache
def linear() -> list[Any]:
    """Return the first-order equations with m g L from the steady condition."""
    return [at_condition(one) for _, one in orders()]


def _names() -> dict[str, Any]:
    n = top().names
    return {**{k: n[k] for k in ("m", "g", "L", "I_ξ", "I_ζ")}, "Ω_ζ": n_spin(), "θ_0": theta_0, "ψ_0'": rate_0,
            "θ_1": theta_1, "ψ_1": psi_1}  # fmt: skip


def _first_order() -> Meaning:
    return Meaning(_names(), rows={i: (zero + one, ZERO) for i, (zero, one) in enumerate(orders())})


def _zeroth() -> Meaning:
    """The terms of order zero: the second equation has none."""
    results = [(zero, ZERO) for zero, _ in orders() if not is_zero(zero)]
    return Meaning(_names(), rows=dict(enumerate(results)))


def _condition() -> Meaning:
    return Meaning(_names(), rows={0: (condition(), ZERO)})


def _perturbation() -> Meaning:
    return Meaning(_names(), rows={i: (row, ZERO) for i, row in enumerate(linear())})


@cache
def coefficients() -> tuple[Any, Any]:
    """Return σ, from the rate of θ_1 in the second equation, and ω_η0, the rate of the axes along η when steady."""
    second = linear()[1]
    return -second.coeff(theta_1.diff(t)) / POSITIVE["I_xi"], at_steady(top().names["ω_η"])


def _notation() -> Meaning:
    value, across = coefficients()
    return Meaning({**_names(), "σ": value, "ω_η0": across})


def _simple() -> Meaning:
    """The accelerations replaced by those of the library's linear equations."""
    return Meaning(_notation().names, along=machines.solved(linear(), [theta_1.diff(t, 2), psi_1.diff(t, 2)]))


@cache
def named_rows() -> list[Any]:
    """Return the first-order equations divided by I_ξ, with σ and ω_η0 for the expressions proven equal to them."""
    value, across = coefficients()
    results = []
    for row in linear():
        total = ZERO
        for term in (theta_1.diff(t, 2), theta_1.diff(t), theta_1, psi_1.diff(t, 2), psi_1.diff(t)):
            factor = row.coeff(term) / POSITIVE["I_xi"]
            shapes = {value: sigma, -value: -sigma, value * S: sigma * S, across**2: w_eta0**2}
            total += (
                next((name for x, name in shapes.items() if is_zero(factor - x)), sympy.cancel(factor)) * term
            )
        results.append(total)
    return results


def laplace(row: Any, images: tuple[Any, Any], start: dict[str, Any]) -> Any:
    """Return the Laplace transform of a linear equation: f'' -> s² F - s f(0) - f'(0) and so on, term by term."""
    row = sympy.expand(row)
    total = ZERO
    for function, image, name in zip((theta_1, psi_1), images, ("θ_1", "ψ_1"), strict=True):
        f0, d0 = start[f"{name}(0)"], start[f"{name}'(0)"]
        total += row.coeff(function.diff(t, 2)) * (lap**2 * image - lap * f0 - d0)
        total += row.coeff(function.diff(t)) * (lap * image - f0)
        total += row.coeff(function) * image
    return total


ANY_START = {name: sympy.Symbol(name) for name in ("θ_1(0)", "θ_1'(0)", "ψ_1(0)", "ψ_1'(0)")}
STRUCK = {"θ_1(0)": ZERO, "θ_1'(0)": w_xi, "ψ_1(0)": ZERO, "ψ_1'(0)": w_eta / S}


def transformed(start: dict[str, Any]) -> tuple[Any, Any]:
    """Return Θ_1(s), Ψ_1(s): the library's transformed equations solved by Cramer's rule."""
    images = sympy.symbols("Theta_1 Psi_1")
    results = machines.solved([laplace(row, images, start) for row in named_rows()], images)
    return sympy.cancel(results[0][1]), sympy.cancel(results[1][1])


def frequency() -> Any:
    """Return Ω², the square of the nonzero frequency, from the determinant of the transformed equations."""
    images = sympy.symbols("Theta_1 Psi_1")
    still = {name: ZERO for name in ANY_START}
    results = [laplace(row, images, still) for row in named_rows()]
    determinant = sympy.Matrix([[sympy.diff(row, x) for x in images] for row in results]).det()
    return sympy.expand(sympy.cancel(determinant / (S * lap**2)) - lap**2)


def _transforms(start: dict[str, Any]) -> Meaning:
    first, second = transformed(start)
    return Meaning({
        **start, "Θ_1": first, "Ψ_1": second, "s": lap, "σ": sigma, "ω_η0": w_eta0, "θ_0": theta_0,
        "Ω": sqrt(frequency()), "ω_ξ(0)": w_xi, "ω_η(0)": w_eta,
    })  # fmt: skip


def _struck() -> Meaning:
    """The change of the axes' angular velocity along ξ and η by a blow, which changes speeds but not positions."""
    n = top().names
    p, q = sympy.symbols("psi_1'(0) theta_1'(0)")
    theta, psi = n["θ"], n["ψ"]
    pairs = [(theta.diff(t), eps * q), (psi.diff(t), rate_0 + eps * p), (theta, theta_0)]
    added = [put(n[f"ω_{c}"], pairs).diff(eps).subs(eps, 0) for c in "ξη"]
    return Meaning(
        {**_names(), "θ_1(0)": ZERO, "ψ_1(0)": ZERO, "θ_1'(0)": q, **resolved("ω_ξ(0) ω_η(0)", added)}
    )


def _at_start() -> list[tuple[Any, Any]]:
    return [(psi_1.diff(t), sympy.Symbol("psi_1'(0)"))]


def inverse(image: Any, square: Any) -> Any:
    """Return the time function of a rational transform with poles at 0 and ± i Ω, given Ω²:

    a/s + b/s² + (c s + d)/(s² + Ω²)  ->  a + b t + c cos Ω t + (d/Ω) sin Ω t
    """
    numerator = sympy.Poly(sympy.cancel(image * lap**2 * (lap**2 + square)), lap)
    n = [numerator.coeff_monomial(lap**k) for k in range(4)]
    b, a = n[0] / square, n[1] / square
    c, d, root = n[3] - a, n[2] - b, sqrt(square)
    return a + b * t + c * cos(root * t) + d / root * sin(root * t)


@cache
def response() -> tuple[Any, Any]:
    """Return θ_1(t), ψ_1(t) after a blow, in σ and Ω."""
    substitution = {w_eta0**2: W**2 - sigma**2}
    first, second = (inverse(sympy.cancel(x).subs(substitution), W**2) for x in transformed(STRUCK))
    return sympy.expand(first), sympy.expand(second)


def _response() -> Meaning:
    th, ps = response()
    return Meaning(
        {
            "θ_1(t)": th,
            "ψ_1(t)": ps,
            "σ": sigma,
            "Ω": W,
            "θ_0": theta_0,
            "t": t,
            "ω_ξ(0)": w_xi,
            "ω_η(0)": w_eta,
        }
    )


# --- a fast spin ------------------------------------------------------------------------------------------------


def at_spin() -> list[tuple[Any, Any]]:
    """Return σ, ω_η0 and Ω in the spin, the steady rate and its angle."""
    value, across = coefficients()
    return [(W, sqrt(frequency())), (sigma, value), (w_eta0, across)]


def small() -> Small:
    """A fast spin at a given phase Ω t, with a blow that adds rates of the size of the steady rate (Fig. 6.12)."""
    spin = fast_spin()
    blow = [(w_xi, rate_0 * sympy.Rational(7, 10)), (w_eta, rate_0 * sympy.Rational(11, 10))]
    return Small(spin.symbol, spin.size, [(t, sympy.Integer(13) / W), *at_spin(), *blow, *spin.pairs])


def _fast() -> Meaning:
    return Meaning({**_names(), "Ω": W, "σ": sigma}, small=small())


def _polar() -> Meaning:
    """Magnitude and angle of the added angular velocity across the axis, a vector along ξ and η."""
    added = sympy.Matrix([w_xi, w_eta, 0])
    return Meaning(
        {"ω_ξ(0)": w_xi, "ω_η(0)": w_eta, "ω_ξη(0)": sqrt(added.dot(added)), "γ": atan2(added[1], added[0])}
    )


def _fast_response() -> Meaning:
    """The steady motion and the response to the blow, exact for any spin."""
    th, ps = response()
    names = {**_response().names, **_polar().names, "θ_1(t)": th, "ψ_1(t)": ps, "ψ_0'": rate_0,
             "θ(t)": theta_0 + th, "ψ(t)": rate_0 * t + ps}  # fmt: skip
    return Meaning(names, small=small())


# --- the library's own linear model -----------------------------------------------------------------------------


@cache
def linear_model() -> tuple[Any, dict[Any, Any]]:
    """Return (linear model about steady precession, symbols of the chapter); the steady condition gives the spin."""
    machine = machines.gyroscope_about()
    a = machine.atoms
    p, angle = a["p_0"], a["angle_0"]
    back = {p: rate_0, angle: theta_0}
    ((_, spin),) = steady_spin()
    here = {v: k for k, v in {a[n]: x for n, x in POSITIVE.items()}.items()} | {v: k for k, v in back.items()}
    about = {"theta": angle, "psi'": p, "phi'": spin.xreplace(here) - p * cos(angle)}
    return fb.linearize(machine.system, about=about), {**{a[n]: x for n, x in POSITIVE.items()}, **back}


def _deviation() -> Meaning:
    """The motion by fb.linearize, which includes φ; its deviation by the two equations of the section.

    The blow adds nothing to the spin Ω_ζ: φ_1' = -ψ_1' cos θ_0.
    """
    model, names = linear_model()
    images = sympy.symbols("Psi Theta Phi")
    added = {"psi": w_eta / S, "theta": w_xi, "phi": -w_eta / S * C}
    start = sympy.Matrix([added[name] for name in model.coordinates])
    M, B, K = (sympy.Matrix(x).xreplace(names) for x in (model.M, model.damping + model.gyroscopic, model.K))
    unknown = sympy.Matrix(images)
    equations = (M * lap**2 + B * lap + K) * unknown - M * start
    results = dict(
        zip(model.coordinates, (x for _, x in machines.solved(list(equations), images)), strict=True)
    )
    square, steady = frequency().subs(dict(at_spin()[1:])), dict(steady_spin())
    square = square.subs(steady)
    motion = [inverse(sympy.cancel(results[name]), square) for name in ("theta", "psi")]
    mine = [
        inverse(sympy.cancel(x.subs(dict(at_spin()[1:])).subs(steady)), square) for x in transformed(STRUCK)
    ]
    values = {
        "θ(t)": theta_0 + motion[0], "ψ'(t)": rate_0 + motion[1].diff(t), "θ_1(t)": mine[0], "ψ_1'(t)": mine[1].diff(t),
        "θ_0": theta_0, "ψ_0'": rate_0,
    }  # fmt: skip
    return Meaning(values)


def _sines() -> Meaning:
    angle = sympy.Symbol("theta_1")
    numbers = [(theta_0, sympy.Integer(1))]
    return Meaning(
        {"θ": theta_0 + angle, "θ_0": theta_0, "θ_1": angle},
        small=Small(angle, sympy.Rational(1, 1000), numbers),
    )


LINEAR = "fb.equations(s).free_body('rotor', about=0, frame=axes).equations, differentiated by the deviation"
SOLVED = LINEAR + ", transformed and solved"
BACK = SOLVED + ", brought back"
STATEMENTS = (
    Statement("6.107", "the motion is the steady one and a deviation", "fb.linearize(s, about=...); " + BACK,
              ("θ(t) = θ_0 + θ_1(t)", "ψ'(t) = ψ_0' + ψ_1'(t)"), _deviation, defines=True),
    Statement("6.108", "sine and cosine of an angle near θ_0", "sin, cos",
              ("sin θ = sin(θ_0 + θ_1) ≅ sin θ_0 + θ_1 cos θ_0", "cos θ = cos(θ_0 + θ_1) ≅ cos θ_0 - θ_1 sin θ_0"),
              _sines),
    Statement("6.109", "the equations to the first order in the deviations", LINEAR,
              ("I_ξ θ_1'' + [ψ_0' (I_ζ Ω_ζ - I_ξ ψ_0' cos θ_0) - m g L] sin θ_0"
               " + ψ_1' (I_ζ Ω_ζ - I_ξ ψ_0' cos θ_0) sin θ_0 - ψ_0' I_ξ (ψ_1' cos θ_0 - θ_1 ψ_0' sin θ_0) sin θ_0"
               " + [ψ_0' (I_ζ Ω_ζ - I_ξ ψ_0' cos θ_0) - m g L] θ_1 cos θ_0 = 0",
               "I_ξ (ψ_1'' sin θ_0 + θ_1' ψ_0' cos θ_0) + θ_1' (I_ξ ψ_0' cos θ_0 - I_ζ Ω_ζ) = 0"), _first_order),
    Statement("6.110", "the terms of order zero", LINEAR, "[ψ_0' (I_ζ Ω_ζ - I_ξ ψ_0' cos θ_0) - m g L] sin θ_0 = 0",
              _zeroth),
    Statement("6.111", "the condition of steady precession once more", "fb.steady_motions(s, ...).branches",
              "ψ_0' (I_ζ Ω_ζ - I_ξ ψ_0' cos θ_0) - m g L = 0", _condition),
    Statement("6.112", "the perturbation equations", LINEAR,
              ("I_ξ θ_1'' + (ψ_0' sin θ_0)^2 θ_1 + (I_ζ Ω_ζ - 2 I_ξ ψ_0' cos θ_0) sin θ_0 ψ_1' = 0",
               "-(I_ζ Ω_ζ - 2 I_ξ ψ_0' cos θ_0) θ_1' + I_ξ sin θ_0 ψ_1'' = 0"), _perturbation),
    Statement("6.113", "sigma and omega_eta0 of the perturbation equations",
              LINEAR + "; the rates of the axes' unit vectors",
              ("(I_ζ Ω_ζ - 2 I_ξ ψ_0' cos θ_0)/I_ξ = σ", "ψ_0' sin θ_0 = ω_η0"), _notation, defines=True),
    Statement("6.114", "the perturbation equations in these", LINEAR,
              ("θ_1'' + ω_η0^2 θ_1 + σ sin θ_0 ψ_1' = 0", "-σ θ_1' + sin θ_0 ψ_1'' = 0"), _simple),
    Statement("6.115", "their Laplace transforms", SOLVED,
              ("s^2 Θ_1 - s θ_1(0) - θ_1'(0) + ω_η0^2 Θ_1 + σ sin θ_0 [s Ψ_1 - ψ_1(0)] = 0",
               "-σ [s Θ_1 - θ_1(0)] + sin θ_0 [s^2 Ψ_1 - s ψ_1(0) - ψ_1'(0)] = 0"), lambda: _transforms(ANY_START)),
    Statement("6.116", "the initial conditions", "the rates of the axes' unit vectors, differentiated by the deviation",
              ("θ_1(0) = ψ_1(0) = 0", "θ_1'(0) = ω_ξ(0)", "sin θ_0 ψ_1' = ω_η(0)"), _struck, defines=True,
              condition=("psi_1', without (0), stands for its value at the start", _at_start)),
    Statement("6.117", "the transforms with the initial conditions", SOLVED,
              ("(s^2 + ω_η0^2) Θ_1 + σ sin θ_0 s Ψ_1 = ω_ξ(0)", "-σ s Θ_1 + sin θ_0 s^2 Ψ_1 = ω_η(0)"),
              lambda: _transforms(STRUCK)),
    Statement("6.118", "the transformed motion", SOLVED,
              ("Θ_1 = det(ω_ξ(0), s σ sin θ_0; ω_η(0), s^2 sin θ_0)/det(s^2 + ω_η0^2, s σ sin θ_0; -s σ, s^2 sin θ_0)"
               " = s [s ω_ξ(0) - ω_η(0)] sin θ_0/(s^2 (s^2 + ω_η0^2 + σ^2) sin θ_0)"
               " = ω_ξ(0)/(s^2 + Ω^2) - σ ω_η(0)/(s (s^2 + Ω^2))",
               "Ψ_1 = det(s^2 + ω_η0^2, ω_ξ(0); -s σ, ω_η(0))/det(s^2 + ω_η0^2, s σ sin θ_0; -s σ, s^2 sin θ_0)"
               " = (σ s ω_ξ(0) + (s^2 + ω_η0^2) ω_η(0))/(s^2 (s^2 + ω_η0^2 + σ^2) sin θ_0)"
               " = σ ω_ξ(0)/(s (s^2 + Ω^2) sin θ_0) + [1/s^2 - σ^2/(s^2 (s^2 + Ω^2)) ω_η(0)/sin θ_0]"),
              lambda: _transforms(STRUCK)),
    Statement("6.119", "the frequency of the small oscillation", LINEAR + ", transformed: their determinant",
              "Ω^2 = ω_η0^2 + σ^2", lambda: _transforms(STRUCK)),
    Statement("6.120", "the small oscillation", BACK,
              ("θ_1(t) = ω_ξ(0)/Ω sin(Ω t) - σ ω_η(0)/Ω^2 (1 - cos(Ω t))",
               "ψ_1(t) = σ ω_ξ(0)/(Ω^2 sin θ_0) (1 - cos(Ω t)) + ω_η(0)/sin θ_0 [t - σ^2/Ω^2 (Ω t - sin(Ω t))]"),
               _response),
    Statement("6.121", "the frequency for a fast spin",
              LINEAR + ", transformed; fb.steady_motions(s, ...)['slow'].solution",
              "Ω ≅ σ ≅ I_ζ Ω_ζ/I_ξ", _fast),
    Statement("6.122", "the small oscillation for a fast spin", BACK + "; fb.steady_motions(s, ...)['slow'].solution",
              ("θ_1(t) = ω_ξ(0)/Ω sin(Ω t) - ω_η(0)/Ω (1 - cos(Ω t))",
               "ψ_1(t) = ω_ξ(0)/(Ω sin θ_0) (1 - cos(Ω t)) + ω_η(0)/(Ω sin θ_0) sin(Ω t)"), _fast_response),
    Statement("6.123", "the angles for a fast spin", BACK + "; fb.steady_motions(s, ...)['slow'].solution",
              ("θ(t) = θ_0 + ω_ξ(0)/Ω sin(Ω t) - ω_η(0)/Ω (1 - cos(Ω t))",
               "ψ(t) = ψ_0' t + ω_ξ(0)/(Ω sin θ_0) (1 - cos(Ω t)) + ω_ξη(0)/(Ω sin θ_0) sin(Ω t)"), _fast_response),
    Statement("6.124", "size and angle of the initial deviation", "size and angle of the vector that is added to ω",
              ("ω_ξ(0) = ω_ξη(0) cos γ", "ω_η(0) = ω_ξη(0) sin γ"), _polar, defines=True),
    Statement("6.125", "the axis goes round a circle that advances",
              BACK + "; fb.steady_motions(s, ...)['slow'].solution",
              ("θ(t) = θ_0 - ω_η(0)/Ω + ω_ξη(0)/Ω sin(Ω t + γ)",
               "ψ(t) = ψ_0' t + ω_ξ(0)/(Ω sin θ_0) - ω_ξη(0)/Ω cos(Ω t + γ)"), _fast_response),
)  # fmt: skip
