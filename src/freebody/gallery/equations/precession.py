"""Section 6.10: small oscillations about steady precession, (6.107)-(6.125).

The file is longer than others: every equation of the section is derived here.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy
from sympy import cos, sin

from . import machines
from .gyroscope import condition, rate_0, reduced, theta_0, top
from .statement import Approximation, Line, Statement, balance, identity, value

t = machines.t
ZERO = sympy.Integer(0)
eps = sympy.Symbol("epsilon")
theta_1, psi_1 = sympy.Function("theta_1")(t), sympy.Function("psi_1")(t)
Theta, Psi = sympy.symbols("Theta_1 Psi_1")
lap = sympy.Symbol("s")
w_xi, w_eta, w_both, gamma = sympy.symbols("omega_xi(0) omega_eta(0) omega_xieta(0) gamma", real=True)
sigma, w_eta0, W = sympy.symbols("sigma omega_eta0 Omega", positive=True)
S = sympy.Symbol("S", positive=True)
"""sin θ_0, where only that stands: a positive symbol, so that ratios cancel."""


@cache
def orders() -> list[tuple[Any, Any]]:
    """(zeroth, first) order in the deviations of the library's two equations, left minus right."""
    k = top()
    theta, psi = k["theta"], k["psi"]
    result = []
    for left, right in reduced():
        row = sympy.sympify(left - right)
        moved = [
            (theta.diff(t, 2), eps * theta_1.diff(t, 2)),
            (psi.diff(t, 2), eps * psi_1.diff(t, 2)),
            (theta.diff(t), eps * theta_1.diff(t)),
            (psi.diff(t), rate_0 + eps * psi_1.diff(t)),
            (theta, theta_0 + eps * theta_1),
        ]
        deviated = row.subs(moved)
        result.append((deviated.subs(eps, 0), deviated.diff(eps).subs(eps, 0).doit()))
    return result


def parts() -> dict[str, Any]:
    k = top()
    return {"A": k["I_xi"], "C": k["I_zeta"], "W": k["Omega_zeta"], "mgL": k["m"] * k["g"] * k["L"]}


def _printed_linear() -> list[Any]:
    p = parts()
    A, C, spin, mgL = p["A"], p["C"], p["W"], p["mgL"]
    s0, c0 = sin(theta_0), cos(theta_0)
    d1 = psi_1.diff(t)
    inner = C * spin - A * rate_0 * c0
    first = (
        A * theta_1.diff(t, 2)
        + (rate_0 * inner - mgL) * s0
        + d1 * inner * s0
        - rate_0 * A * (d1 * c0 - theta_1 * rate_0 * s0) * s0
        + (rate_0 * inner - mgL) * theta_1 * c0
    )
    second = A * (psi_1.diff(t, 2) * s0 + theta_1.diff(t) * rate_0 * c0) + theta_1.diff(t) * (
        A * rate_0 * c0 - C * spin
    )
    return [first, second]


def _linear() -> list[Line]:
    rows = [(zero + one, ZERO) for zero, one in orders()]
    return [balance(p, ZERO, row) for p, row in zip(_printed_linear(), rows, strict=True)]


def _zeroth() -> list[Line]:
    p = parts()
    printed = (rate_0 * (p["C"] * p["W"] - p["A"] * rate_0 * cos(theta_0)) - p["mgL"]) * sin(theta_0)
    return [balance(printed, ZERO, (orders()[0][0], ZERO)), identity(orders()[1][0], ZERO)]


def _nontrivial() -> list[Line]:
    p = parts()
    printed = rate_0 * (p["C"] * p["W"] - p["A"] * rate_0 * cos(theta_0)) - p["mgL"]
    return [balance(printed, ZERO, (condition(), ZERO), scale=-1)]


def _steady_spin(x: Any) -> Any:
    """With Ω_ζ from the steady condition: ψ_0' (I_ζ Ω_ζ - I_ξ ψ_0' cos θ_0) = m g L."""
    p = parts()
    spin = (p["mgL"] / rate_0 + p["A"] * rate_0 * cos(theta_0)) / p["C"]
    return sympy.sympify(x).subs(p["W"], spin)


def _perturbation() -> list[Line]:
    p = parts()
    A = p["A"]
    s0 = sin(theta_0)
    slope = p["C"] * p["W"] - 2 * A * rate_0 * cos(theta_0)
    printed = (
        A * theta_1.diff(t, 2) + (rate_0 * s0) ** 2 * theta_1 + slope * s0 * psi_1.diff(t),
        -slope * theta_1.diff(t) + A * s0 * psi_1.diff(t, 2),
    )
    right = (
        A * theta_1.diff(t, 2) + A * (rate_0 * s0) ** 2 * theta_1 + slope * s0 * psi_1.diff(t),
        printed[1],
    )
    # a right form is shown as such only if it is what the library gives, at the steady spin
    rows = []
    for mine, shown, (_, one) in zip(printed, right, orders(), strict=True):
        agrees = _steady_spin(shown - one)
        rows.append(Line(sympy.Eq(mine, 0, evaluate=False), _steady_spin(mine - one),
                         sympy.Eq(shown - sympy.simplify(agrees), 0, evaluate=False)))  # fmt: skip
    return rows


def _sigma() -> Any:
    p = parts()
    return (p["C"] * p["W"] - 2 * p["A"] * rate_0 * cos(theta_0)) / p["A"]


def _notation() -> list[Line]:
    """σ as the coefficient of ψ_1' sin θ_0 in the library's linear equation; ω_η0² as that of θ_1."""
    p = parts()
    one = sympy.expand(_steady_spin(orders()[0][1]))
    s0 = sin(theta_0)
    of_rate = one.coeff(psi_1.diff(t)) / (p["A"] * s0)
    of_angle = one.coeff(theta_1) / p["A"]
    return [
        value(sigma, _steady_spin(_sigma()), of_rate),
        value(w_eta0**2, (rate_0 * s0) ** 2, of_angle),
    ]


def _library_rows() -> list[Any]:
    """The first-order equations, divided by I_ξ, in σ, ω_η0 and S = sin θ_0: their coefficients are the library's."""
    p = parts()
    rows = []
    for _, one in orders():
        row = sympy.expand(_steady_spin(one) / p["A"])
        slope = sympy.expand(_steady_spin(_sigma()))
        s0 = sin(theta_0)
        expected = {
            theta_1.diff(t, 2): None, theta_1.diff(t): None, theta_1: None,
            psi_1.diff(t, 2): None, psi_1.diff(t): None,
        }  # fmt: skip
        total = ZERO
        for term in expected:
            factor = row.coeff(term)
            total += _named(factor, slope, s0) * term
        rows.append(total)
    return rows


def _named(factor: Any, slope: Any, s0: Any) -> Any:
    """A coefficient of the library written in σ, ω_η0 and S, or as it is."""
    from .statement import is_zero

    candidates = {
        ZERO: ZERO, sympy.Integer(1): sympy.Integer(1), s0: S, slope * s0: sigma * S, slope: sigma, -slope: -sigma,
        (rate_0 * s0) ** 2: w_eta0**2,
    }  # fmt: skip
    for expression, name in candidates.items():
        if is_zero(factor - expression):
            return name
    return factor


def _simple() -> list[Line]:
    printed = (
        theta_1.diff(t, 2) + w_eta0**2 * theta_1 + sigma * S * psi_1.diff(t),
        -sigma * theta_1.diff(t) + S * psi_1.diff(t, 2),
    )
    return [balance(p, ZERO, (row, ZERO)) for p, row in zip(printed, _library_rows(), strict=True)]


def laplace(row: Any, start: dict[str, Any]) -> Any:
    """The transform of a linear equation: f'' -> s² F - s f(0) - f'(0) and so on, term by term."""
    row = sympy.expand(row)
    total = ZERO
    for function, image, name in ((theta_1, Theta, "theta"), (psi_1, Psi, "psi")):
        f0, d0 = start[name], start[name + "'"]
        total += row.coeff(function.diff(t, 2)) * (lap**2 * image - lap * f0 - d0)
        total += row.coeff(function.diff(t)) * (lap * image - f0)
        total += row.coeff(function) * image
    return total


START = {
    "theta": sympy.Symbol("theta_1(0)"), "theta'": sympy.Symbol("theta_1'(0)"), "psi": sympy.Symbol("psi_1(0)"),
    "psi'": sympy.Symbol("psi_1'(0)"),
}  # fmt: skip
GIVEN = {"theta": ZERO, "theta'": w_xi, "psi": ZERO, "psi'": w_eta / S}


def _transformed() -> list[Line]:
    b = START
    printed = (
        lap**2 * Theta
        - lap * b["theta"]
        - b["theta'"]
        + w_eta0**2 * Theta
        + sigma * S * (lap * Psi - b["psi"]),
        -sigma * (lap * Theta - b["theta"]) + S * (lap**2 * Psi - lap * b["psi"] - b["psi'"]),
    )
    return [
        balance(p, ZERO, (laplace(row, b), ZERO)) for p, row in zip(printed, _library_rows(), strict=True)
    ]


def _start() -> list[Line]:
    """A change of ω by ω_ξ(0), ω_η(0) along ξ and η is θ' = ω_ξ(0), ψ' sin θ_0 = ω_η(0): by the frame's rates."""
    from .gyroscope import frame

    k = top()
    put = [
        (k["psi"].diff(t), sympy.Symbol("p")),
        (k["theta"].diff(t), sympy.Symbol("q")),
        (k["theta"], theta_0),
    ]
    rates = [sympy.sympify(x).subs(put) for x in frame()[:2]]
    return [
        value(w_xi, sympy.Symbol("q"), rates[0]),
        value(w_eta, sin(theta_0) * sympy.Symbol("p"), rates[1]),
    ]


def _with_start() -> list[Line]:
    printed = (
        ((lap**2 + w_eta0**2) * Theta + sigma * S * lap * Psi, w_xi),
        (-sigma * lap * Theta + S * lap**2 * Psi, w_eta),
    )
    return [balance(*p, (laplace(row, GIVEN), ZERO)) for p, row in zip(printed, _library_rows(), strict=True)]


@cache
def solved() -> tuple[Any, Any]:
    """Θ_1(s), Ψ_1(s): the transformed equations of the library, solved by Cramer's rule."""
    rows = [sympy.expand(laplace(row, GIVEN)) for row in _library_rows()]
    matrix = sympy.Matrix(2, 2, lambda i, j: rows[i].coeff((Theta, Psi)[j]))
    right = sympy.Matrix([-row.subs({Theta: 0, Psi: 0}) for row in rows])
    both = matrix.adjugate() * right / matrix.det()
    return sympy.cancel(both[0]), sympy.cancel(both[1])


def _transforms() -> list[Line]:
    square = w_eta0**2 + sigma**2
    Th, Ps = solved()
    det = lap**2 * (lap**2 + square) * S
    return [
        value(Theta, lap * (lap * w_xi - w_eta) * S / det, Th),
        value(Theta, w_xi / (lap**2 + square) - sigma * w_eta / (lap * (lap**2 + square)), Th),
        value(Psi, (sigma * lap * w_xi + (lap**2 + w_eta0**2) * w_eta) / det, Ps),
        value(Psi, sigma * w_xi / (lap * (lap**2 + square) * S)
              + (1 / lap**2 - sigma**2 / (lap**2 * (lap**2 + square)) * w_eta / S), Ps),
    ]  # fmt: skip


def _frequency() -> list[Line]:
    """The square of the frequency that is not zero: from the determinant of the transformed equations."""
    rows = [sympy.expand(laplace(row, GIVEN)) for row in _library_rows()]
    matrix = sympy.Matrix(2, 2, lambda i, j: rows[i].coeff((Theta, Psi)[j]))
    rest = sympy.cancel(matrix.det() / (S * lap**2))
    return [value(W**2, w_eta0**2 + sigma**2, sympy.expand(rest - lap**2))]


def inverse(image: Any) -> Any:
    """The time function of a rational transform with poles at 0 and ± i Ω: by residues, checked by its own transform.

    a/s + b/s² + (c s + d)/(s² + Ω²)  ->  a + b t + c cos Ω t + (d/Ω) sin Ω t
    """
    image = sympy.cancel(sympy.sympify(image).subs(w_eta0**2, W**2 - sigma**2))
    numerator = sympy.Poly(sympy.cancel(image * lap**2 * (lap**2 + W**2)), lap)
    n = [numerator.coeff_monomial(lap**k) for k in range(4)]
    b, a = n[0] / W**2, n[1] / W**2
    c, d = n[3] - a, n[2] - b
    return sympy.expand(a + b * t + c * cos(W * t) + d / W * sin(W * t))


@cache
def response() -> tuple[Any, Any]:
    """θ_1(t), ψ_1(t) in σ and Ω."""
    return inverse(solved()[0]), inverse(solved()[1])


def _response() -> list[Line]:
    th, ps = response()
    printed_th = w_xi / W * sin(W * t) - sigma * w_eta / W**2 * (1 - cos(W * t))
    printed_ps = sigma * w_xi / (W**2 * S) * (1 - cos(W * t)) + w_eta / S * (
        t - sigma**2 / W**2 * (W * t - sin(W * t))
    )
    return [value(theta_1, printed_th, th), value(psi_1, printed_ps, ps)]


SMALL = sympy.Symbol("delta", positive=True)
"""ω_η0/σ: the rate of precession across the axis, small beside the spin."""


def ordinary() -> Any:
    """ω_η0/σ of the gyroscope of section 6.9 at 300 rad/s."""
    from .gyroscope import numbers, precession

    k, n = top(), numbers()
    slow = precession()["slow"].solution["psi'"]
    spin = {k["Omega_zeta"]: 300}
    p = sympy.N(slow.subs(k["theta"], theta_0).subs(spin).subs(n), 30)
    s = sympy.N(_sigma().subs(rate_0, p).subs(spin).subs(n), 30)
    return sympy.Rational(str(sympy.N(p * sin(sympy.pi / 3) / s, 15)))


def _fast_spin() -> list[Approximation]:
    """Ω/σ = sqrt(1 + δ²), and I_ζ Ω_ζ/(I_ξ σ) = 1 + 2 ψ_0' cos θ_0/σ, at the angle 60 degrees."""
    cot = cos(sympy.pi / 3) / sin(sympy.pi / 3)
    one = sympy.Integer(1)
    return [
        Approximation(sympy.Symbol("Omega/sigma"), sympy.sqrt(1 + SMALL**2), one, SMALL, ordinary(), {}),
        Approximation(
            sympy.Symbol("I_zeta Omega_zeta/(I_xi sigma)"), 1 + 2 * cot * SMALL, one, SMALL, ordinary(), {}
        ),
    ]


def _rough(expression: Any) -> Any:
    """With σ = Ω/sqrt(1 + δ²), at Ω = 130/s, a tenth of a second, and the deviations of section 6.10."""
    numbers = {
        w_xi: sympy.Rational(1, 20),
        w_eta: sympy.Rational(2, 25),
        S: sin(sympy.pi / 3),
        t: sympy.Rational(1, 10),
    }
    return sympy.sympify(expression).subs(sigma, W / sympy.sqrt(1 + SMALL**2)).subs(W, 130).subs(numbers)


def _rough_response() -> list[Approximation]:
    th, ps = response()
    approximate_th = w_xi / W * sin(W * t) - w_eta / W * (1 - cos(W * t))
    approximate_ps = w_xi / (W * S) * (1 - cos(W * t)) + w_eta / (W * S) * sin(W * t)
    return [
        Approximation(theta_1, _rough(th), _rough(approximate_th), SMALL, ordinary(), {}),
        Approximation(psi_1, _rough(ps), _rough(approximate_ps), SMALL, ordinary(), {}),
    ]


def _limit() -> tuple[Any, Any]:
    """The library's response for σ = Ω: the same approximation, by substitution."""
    th, ps = response()
    return sympy.expand(th.subs(sigma, W)), sympy.expand(ps.subs(sigma, W))


theta_of, psi_of = sympy.symbols("theta(t) psi(t)")


def _whole() -> list[Line]:
    th, ps = _limit()
    printed_th = theta_0 + w_xi / W * sin(W * t) - w_eta / W * (1 - cos(W * t))
    printed_ps = rate_0 * t + w_xi / (W * S) * (1 - cos(W * t)) + w_both / (W * S) * sin(W * t)
    return [value(theta_of, printed_th, theta_0 + th), value(psi_of, printed_ps, rate_0 * t + ps)]


def _polar() -> list[Line]:
    """Any pair of components has such a modulus and angle."""
    a, b = w_both * cos(gamma), w_both * sin(gamma)
    return [value(sympy.Symbol("omega_xi(0)^2 + omega_eta(0)^2"), a**2 + b**2, w_both**2)]


def _circle() -> list[Line]:
    th, ps = _limit()
    put = {w_xi: w_both * cos(gamma), w_eta: w_both * sin(gamma)}
    printed_th = theta_0 - w_eta / W + w_both / W * sin(W * t + gamma)
    printed_ps = rate_0 * t + w_xi / (W * S) - w_both / W * cos(W * t + gamma)
    derived_th = theta_0 - w_eta / W + sympy.expand((th + w_eta / W).subs(put))
    derived_ps = rate_0 * t + w_xi / (W * S) + sympy.expand((ps - w_xi / (W * S)).subs(put))
    return [value(theta_of, printed_th, derived_th), value(psi_of, printed_ps, _collected(derived_ps))]


def _collected(x: Any) -> Any:
    return sympy.collect(x, [w_both])


def _deviation() -> list[Line]:
    """Any motion is the steady one and a deviation; that of zero size satisfies the library's equations."""
    p = condition()
    zero = sympy.cancel(orders()[0][0] + p * sin(theta_0))
    return [value(sympy.Symbol("zeroth order + sin(theta_0) (steady condition)"), ZERO, zero)]


def _sines() -> list[Approximation]:
    at = {theta_0: sympy.pi / 3}
    small, size = sympy.Symbol("theta_1"), sympy.Rational(1, 1000)
    return [
        Approximation(name, exact, printed, small, size, at)
        for name, exact, printed in (
            (sympy.Symbol("sin(theta)"), sin(theta_0 + small), sin(theta_0) + small * cos(theta_0)),
            (sympy.Symbol("cos(theta)"), cos(theta_0 + small), cos(theta_0) - small * sin(theta_0)),
        )
    ]  # fmt: skip


LINEAR = "fb.equations(s), with the spin put in, differentiated by the deviation"
STATEMENTS = (
    Statement("6.107", "the motion is the steady one and a deviation", "fb.equations(s), fb.steady_motions(s)",
              _deviation, defines=True, print_is="θ = θ_0 + θ_1, ψ' = ψ_0' + ψ_1'"),
    Statement("6.108", "sine and cosine of an angle near θ_0", "sin, cos", _sines),
    Statement("6.109", "the equations to the first order in the deviations", LINEAR, _linear),
    Statement("6.110", "the terms of order zero", LINEAR, _zeroth),
    Statement("6.111", "the condition of steady precession once more", "fb.steady_motions(s).branches", _nontrivial),
    Statement("6.112", "the perturbation equations", LINEAR, _perturbation),
    Statement("6.113", "sigma and omega_eta0, coefficients of the perturbation equations", LINEAR, _notation,
              defines=True),
    Statement("6.114", "the perturbation equations in these; S = sin(theta_0)", LINEAR, _simple),
    Statement("6.115", "their Laplace transforms; S = sin(theta_0)", LINEAR + ", transformed", _transformed),
    Statement("6.116", "the initial conditions", "angular velocity of the axes ξηζ", _start, defines=True),
    Statement("6.117", "the transforms with the initial conditions; S = sin(theta_0)", LINEAR + ", transformed",
              _with_start),
    Statement("6.118", "the transformed motion; S = sin(theta_0)", LINEAR + ", transformed and solved", _transforms),
    Statement("6.119", "the frequency of the small oscillation", "determinant of the transformed equations; "
              "fb.linearize(s, about=...).natural_frequencies()", _frequency),
    Statement("6.120", "the small oscillation; S = sin(theta_0)", LINEAR + ", transformed, solved and brought back",
              _response),
    Statement("6.121", "the frequency for a fast spin, delta = omega_eta0/sigma", "fb.linearize(s, about=...)",
              _fast_spin),
    Statement("6.122", "the small oscillation for a fast spin, after 0.1 s of section 6.10's example",
              LINEAR + ", transformed, solved and brought back", _rough_response),
    Statement("6.123", "the angles for a fast spin, sigma = Omega; S = sin(theta_0)",
              LINEAR + ", transformed, solved and brought back", _whole),
    Statement("6.124", "modulus and angle of the initial deviation", "sin, cos", _polar, defines=True),
    Statement("6.125", "the axis goes round a circle that advances; S = sin(theta_0)",
              LINEAR + ", transformed, solved and brought back", _circle),
)  # fmt: skip
