"""Section 6.9: rotation about a fixed point, gyroscopes, (6.85)-(6.106).

The file is longer than others: every equation of the section is derived here.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy
from sympy import cos, sin

import freebody as fb

from . import machines
from .statement import Approximation, Line, Statement, balance, value

t = machines.t
ZERO = sympy.Integer(0)
GREEK = ("xi", "eta", "zeta")


@cache
def top() -> dict[str, Any]:
    """The gyroscope: atoms, rates, ω of the frame, Ω of the body, H_0 and M_0 along ξ, η, ζ, all by the library."""
    from ...dynamics.kinematics import angular_velocity

    s, e = machines.gyroscope()
    a = dict(s.names.atoms)
    # unit vectors of ξηζ in the ground: ξ the nodal axis, ζ the symmetry axis
    psi, theta = a["psi"], a["theta"]
    zeta = sympy.Matrix([sin(theta) * sin(psi), -sin(theta) * cos(psi), cos(theta)])
    xi = sympy.Matrix([cos(psi), sin(psi), 0])
    units = (xi, zeta.cross(xi), zeta)
    body = sympy.Matrix([e.sympy(x) for x in angular_velocity(e.model, e.state, s.bodies["rotor"])])
    moments = sympy.Matrix(e.free_body("rotor", about=s.ground.origin).moments["weight"])
    H = sympy.Matrix(e.momentum.angular())
    along = lambda v: [v.dot(u) for u in units]  # noqa: E731
    rate = H.diff(t)
    return {
        **a,
        "e": e,
        "units": units,
        "Omega": along(body),
        "H": along(H),
        "M": along(moments),
        "dH": along(rate),
        "spin": a["phi'"] + a["psi'"] * cos(theta),
    }


def frame() -> list[Any]:
    """ω of the axes ξηζ, along them, from the rates of their unit vectors: ω_ξ = η'·ζ and so on."""
    units = top()["units"]
    return [units[(i + 1) % 3].diff(t).dot(units[(i + 2) % 3]) for i in range(3)]


def _angles() -> tuple[Any, Any]:
    k = top()
    return k["theta"], k["psi"]


def _mgl() -> Any:
    k = top()
    return k["m"] * k["g"] * k["L"]


def _frame_rate() -> list[Line]:
    theta, psi = _angles()
    printed = (theta.diff(t), psi.diff(t) * sin(theta), psi.diff(t) * cos(theta))
    names = [sympy.Symbol(f"omega_{g}") for g in GREEK]
    return [value(n, p, d) for n, p, d in zip(names, printed, frame(), strict=True)]


def _body_rate() -> list[Line]:
    k = top()
    theta, psi = _angles()
    printed = (theta.diff(t), psi.diff(t) * sin(theta), k["phi'"] + psi.diff(t) * cos(theta))
    names = [sympy.Symbol(f"Omega_{g}") for g in GREEK]
    return [value(n, p, d) for n, p, d in zip(names, printed, k["Omega"], strict=True)]


def _whole(components: Any, vector: Any) -> list[Line]:
    """A vector of the ground put together from its components along ξηζ."""
    units = top()["units"]
    total = sum((c * u for c, u in zip(components, units, strict=True)), sympy.zeros(3, 1))
    return [value(sympy.Symbol(f"v_{c}"), p, d) for c, p, d in zip("XYZ", total, vector, strict=True)]


def _frame_vector() -> list[Line]:
    """ω × u is the rate of each unit vector u of the frame."""
    units = top()["units"]
    w = sum((c * u for c, u in zip(frame(), units, strict=True)), sympy.zeros(3, 1))
    return [
        value(sympy.Symbol(f"d{name}_{c}"), w.cross(u)[i], u.diff(t)[i])
        for name, u in zip(GREEK, units, strict=True)
        for i, c in enumerate("XYZ")
    ]


def _body_vector() -> list[Line]:
    """Ω differs from ω in its last component only."""
    return [value(sympy.Symbol(f"Omega_{g} - omega_{g}"), ZERO, top()["Omega"][i] - frame()[i])
            for i, g in enumerate(GREEK[:2])]  # fmt: skip


def _momentum_vector() -> list[Line]:
    k = top()
    return _whole(k["H"], sympy.Matrix(k["e"].momentum.angular()))


def _moment_vector() -> list[Line]:
    k = top()
    s, e = machines.gyroscope()
    return _whole(k["M"], sympy.Matrix(e.free_body("rotor", about=s.ground.origin).moments["weight"]))


def _modified() -> list[Line]:
    """H' + ω × H along ξηζ, against the rate of H_0 in the ground, resolved along them."""
    k = top()
    H, w = k["H"], frame()
    printed = [
        H[0].diff(t) + w[1] * H[2] - w[2] * H[1],
        H[1].diff(t) + w[2] * H[0] - w[0] * H[2],
        H[2].diff(t) + w[0] * H[1] - w[1] * H[0],
    ]
    return [value(sympy.Symbol(f"M_{g}"), p, d) for g, p, d in zip(GREEK, printed, k["dH"], strict=True)]


def _momentum() -> list[Line]:
    k = top()
    printed = (k["I_xi"] * k["Omega"][0], k["I_xi"] * k["Omega"][1], k["I_zeta"] * k["Omega"][2])
    return [value(sympy.Symbol(f"H_{g}"), p, d) for g, p, d in zip(GREEK, printed, k["H"], strict=True)]


def _explicit() -> list[Line]:
    """Against the modified Euler equations that the library gives for a body of revolution."""
    I_xi, I_zeta = sympy.symbols("I_xi I_zeta", real=True)
    x, y, z = (sympy.Function(f"omega_{g}")(t) for g in GREEK)
    spin = sympy.Function("Omega_zeta")(t)
    printed = (
        I_xi * x.diff(t) + y * (I_zeta * spin - I_xi * z),
        I_xi * y.diff(t) + z * (I_xi * z - I_zeta * spin),
        I_zeta * spin.diff(t),
    )
    derived = fb.forms.modified_euler_equations()
    return [value(sympy.Symbol(f"M_{g}"), p, d) for g, p, d in zip(GREEK, printed, derived, strict=True)]


def _weight() -> list[Line]:
    k = top()
    printed = (_mgl() * sin(k["theta"]), ZERO, ZERO)
    return [value(sympy.Symbol(f"M_{g}"), p, d) for g, p, d in zip(GREEK, printed, k["M"], strict=True)]


def _rows() -> list[tuple[Any, Any]]:
    """The library's moment equations about 0 along ξ, η, ζ: (rate of H, moment)."""
    k = top()
    return [(rate, moment) for rate, moment in zip(k["dH"], k["M"], strict=True)]


def _motion() -> list[Line]:
    k = top()
    theta, psi = _angles()
    A, C = k["I_xi"], k["I_zeta"]
    p, spin = psi.diff(t), k["spin"]
    printed = (
        (A * theta.diff(t, 2) + p * sin(theta) * (A * spin - C * p * cos(theta)), _mgl() * sin(theta)),
        (A * (p * sin(theta)).diff(t) + theta.diff(t) * (A * p * cos(theta) - C * spin), ZERO),
        (A * spin.diff(t), ZERO),
    )
    return [balance(*line, row) for line, row in zip(printed, _rows(), strict=True)]


def _spin() -> list[Line]:
    """The rate of φ' + ψ' cos θ along the motion, from the library's equation along ζ."""
    k = top()
    rate, moment = _rows()[2]
    second = k["phi"].diff(t, 2)
    row = sympy.expand(rate - moment)  # linear in φ''
    inner = -row.coeff(second, 0) / row.coeff(second, 1)
    return [value(sympy.Symbol("dOmega_zeta/dt"), ZERO, k["spin"].diff(t).subs(second, inner))]


def reduced() -> list[tuple[Any, Any]]:
    """The first two equations with the spin as a constant Ω_ζ: by the library, with φ' put in."""
    k = top()
    theta, psi = _angles()
    rate = k["Omega_zeta"] - psi.diff(t) * cos(theta)
    put = {k["phi"].diff(t, 2): rate.diff(t)}
    return [
        (sympy.expand(sympy.sympify(a).subs(put).subs(k["phi"].diff(t), rate)), b) for a, b in _rows()[:2]
    ]


def _reduced() -> list[Line]:
    k = top()
    theta, psi = _angles()
    A, C, W, p = k["I_xi"], k["I_zeta"], k["Omega_zeta"], psi.diff(t)
    printed = (
        (A * theta.diff(t, 2) + p * sin(theta) * (C * W - A * p * cos(theta)), _mgl() * sin(theta)),
        (A * (p * sin(theta)).diff(t) + theta.diff(t) * (A * p * cos(theta) - C * W), ZERO),
    )
    return [balance(*line, row) for line, row in zip(printed, reduced(), strict=True)]


theta_0 = sympy.Symbol("theta_0", real=True)
rate_0 = sympy.Symbol("psi_0'", real=True)


def steady(expression: Any) -> Any:
    """At θ = θ_0, ψ' = ψ_0', constant."""
    theta, psi = _angles()
    put = [
        (theta.diff(t, 2), 0),
        (psi.diff(t, 2), 0),
        (theta.diff(t), 0),
        (psi.diff(t), rate_0),
        (theta, theta_0),
    ]
    return sympy.sympify(expression).subs(put)


def _steady() -> list[Line]:
    """The second equation vanishes; what is left is the first."""
    return [value(sympy.Symbol("M_eta"), ZERO, steady(reduced()[1][0]))]


@cache
def precession() -> Any:
    """Steady motions of the gyroscope by the library."""
    s, _ = machines.gyroscope()
    return fb.steady_motions(s, terms={"Omega_zeta": "phi' + psi'*cos(theta)"})


def _at_theta0(x: Any) -> Any:
    theta, psi = _angles()
    return sympy.sympify(x).subs(psi.diff(t), rate_0).subs(theta, theta_0)


def condition() -> Any:
    """The factor of the steady equation that is not sin θ_0."""
    ((first, _),) = precession().branches
    return _at_theta0(first)


def _quadratic() -> list[Line]:
    k = top()
    A, C, W, p = k["I_xi"], k["I_zeta"], k["Omega_zeta"], rate_0
    theta = sympy.Symbol("theta", real=True)
    printed = p**2 - C * W / (A * cos(theta_0)) * p + _mgl() / (A * cos(theta))
    return [balance(printed, ZERO, (condition(), ZERO), scale=A * cos(theta_0))]


def _same_angle() -> dict[Any, Any]:
    return {sympy.Symbol("theta", real=True): theta_0}


def _roots() -> tuple[Any, Any, Any]:
    """(half the sum, the discriminant factor, the sign-free part) of the printed solutions."""
    k = top()
    A, C, W = k["I_xi"], k["I_zeta"], k["Omega_zeta"]
    half = C * W / (2 * A * cos(theta_0))
    under = 1 - 4 * _mgl() * A * cos(theta_0) / (C**2 * W**2)
    return half, under, half**2 * under


def _solutions() -> list[Line]:
    """Sum and difference of the printed roots against those that the library finds: the difference by its square."""
    half, _, square = _roots()
    found = [_at_theta0(precession()[name].solution["psi'"]) for name in ("fast", "slow")]
    mean, gap = (found[0] + found[1]) / 2, (found[0] - found[1]) / 2
    return [
        value(sympy.Symbol("(psi_01' + psi_02')/2"), half, sympy.expand(mean)),
        value(sympy.Symbol("((psi_01' - psi_02')/2)^2"), square, sympy.expand(sympy.expand(gap) ** 2)),
    ]


def _existence() -> list[Line]:
    """Ω_ζ² less its bound, times I_ζ², is the quantity that the library asks to be positive."""
    k = top()
    (exists,) = precession()["fast"].existence
    bound = 4 * _mgl() * k["I_xi"] * cos(theta_0) / k["I_zeta"] ** 2
    printed = (k["Omega_zeta"] ** 2 - bound) * k["I_zeta"] ** 2
    return [
        value(sympy.Symbol("I_zeta^2 (Omega_zeta^2 - bound)"), printed, _at_theta0(exists.lhs - exists.rhs))
    ]


SLOW = sympy.Symbol("epsilon", positive=True)
"""4 m g L I_ξ cos θ_0/(I_ζ Ω_ζ)²: small for a fast spin."""


def numbers() -> dict[Any, Any]:
    """The gyroscope of section 6.9 at 60 degrees; exact numbers."""
    k = top()
    m, R, L = sympy.Rational(6, 5), sympy.Rational(3, 50), sympy.Rational(1, 10)
    return {
        k["m"]: m, k["L"]: L, k["g"]: sympy.Rational(981, 100), k["I_xi"]: m * (R**2 / 4 + L**2),
        k["I_zeta"]: m * R**2 / 2, theta_0: sympy.pi / 3,
    }  # fmt: skip


def epsilon() -> Any:
    """Its small quantity at 300 rad/s."""
    k = top()
    n = numbers()
    value_ = 4 * _mgl() * k["I_xi"] * cos(theta_0) / (k["I_zeta"] * 300) ** 2
    return sympy.nsimplify(value_.subs(n))


def _binomial() -> list[Approximation]:
    return [
        Approximation(
            sympy.Symbol("sqrt(1 - epsilon)"), sympy.sqrt(1 - SLOW), 1 - SLOW / 2, SLOW, epsilon(), {}
        )
    ]


def _in_epsilon(expression: Any) -> Any:
    """With Ω_ζ such that the small quantity is ε."""
    k = top()
    spin = sympy.sqrt(4 * _mgl() * k["I_xi"] * cos(theta_0) / SLOW) / k["I_zeta"]
    put = sympy.sympify(expression).subs(k["Omega_zeta"], spin).subs(numbers())
    half = sympy.Rational(1, 2)
    # sqrt(c/ε - c) = sqrt(c) sqrt(1 - ε)/sqrt(ε)
    apart = put.replace(
        lambda x: x.is_Pow and x.exp == half and x.base.is_Add, lambda x: sympy.sqrt(sympy.factor(x.base))
    )
    return sympy.expand(apart)


def _limits() -> list[Approximation]:
    """Both rates in units of the half sum, so that the error's power is that of ε."""
    k = top()
    A, C, W = k["I_xi"], k["I_zeta"], k["Omega_zeta"]
    half, _, _ = _roots()
    approximate = {"fast": C * W / (A * cos(theta_0)), "slow": _mgl() / (C * W)}
    return [
        Approximation(
            sympy.Symbol(f"psi_0{i + 1}'/half"), _in_epsilon(_at_theta0(precession()[name].solution["psi'"]) / half),
            _in_epsilon(approximate[name] / half), SLOW, epsilon(), {},
        )
        for i, name in enumerate(("fast", "slow"))
    ]  # fmt: skip


def _steady_momentum() -> list[Approximation]:
    """Steady H_0 along η, I_ξ ψ_0' sin θ_0, is left out beside I_ζ Ω_ζ: of first order in ε."""
    k = top()
    slow = _at_theta0(precession()["slow"].solution["psi'"])
    small = _in_epsilon(k["I_xi"] * slow * sin(theta_0) / (k["I_zeta"] * k["Omega_zeta"]))
    return [
        Approximation(
            sympy.Symbol("|H_0 - I_zeta Omega_zeta k|/(I_zeta Omega_zeta)"),
            small,
            sympy.Integer(0),
            SLOW,
            epsilon(),
            {},
            scale=1,
        )  # fmt: skip
    ]


def _vector_balance() -> list[Approximation]:
    """ω × I_ζ Ω_ζ k at the slow precession, in units of m g L sin θ."""
    k = top()
    slow = _at_theta0(precession()["slow"].solution["psi'"])
    ratio = _in_epsilon(slow * k["I_zeta"] * k["Omega_zeta"] / _mgl())
    return [Approximation(sympy.Symbol("omega_eta I_zeta Omega_zeta/(m g L sin theta)"), ratio, sympy.Integer(1), SLOW,
                          epsilon(), {})]  # fmt: skip


def _slow_rate() -> list[Approximation]:
    return [_limits()[1]]


MOMENTUM = "fb.equations(s).momentum.angular(), along the axes ξηζ"
STEADY = "fb.steady_motions(s, terms={'Omega_zeta': \"phi' + psi'*cos(theta)\"})"
STATEMENTS = (
    Statement("6.85a", "angular velocity of the axes ξηζ", "rates of the axes' unit vectors", _frame_vector,
              defines=True, print_is="ω = ω_ξ i + ω_η j + ω_ζ k"),
    Statement("6.85b", "angular velocity of the body along these axes: it differs in the last component only",
              "dynamics.kinematics.angular_velocity", _body_vector, defines=True,
              print_is="Ω = ω_ξ i + ω_η j + Ω_ζ k"),
    Statement("6.86", "components of the angular momentum along ξηζ", MOMENTUM, _momentum_vector, defines=True,
              print_is="H_0 = H_ξ i + H_η j + H_ζ k"),
    Statement("6.87", "components of the moment along ξηζ", "fb.equations(s).free_body('rotor').moments",
              _moment_vector, defines=True, print_is="M_0 = M_ξ i + M_η j + M_ζ k"),
    Statement("6.88", "the modified Euler equations", MOMENTUM + ", differentiated", _modified),
    Statement("6.89", "components of the angular momentum of a body of revolution", MOMENTUM, _momentum),
    Statement("6.90", "the modified Euler equations of a body of revolution",
              "fb.forms.modified_euler_equations()", _explicit),
    Statement("6.91", "angular velocity of the axes ξηζ in Euler's angles", "rates of the axes' unit vectors",
              _frame_rate),
    Statement("6.92", "angular velocity of the body in Euler's angles", "dynamics.kinematics.angular_velocity",
              _body_rate),
    Statement("6.93", "moment of the weight about the pivot", "fb.equations(s).free_body('rotor').moments['weight']",
              _weight),
    Statement("6.94", "the equations of motion of the gyroscope", MOMENTUM + " and the moment of the weight", _motion),
    Statement("6.95", "the spin is constant", "fb.equations(s).integrals", _spin,
              print_is="φ' + ψ' cos θ = Ω_ζ = const"),
    Statement("6.96", "the equations of nutation and precession", "fb.equations(s), with the spin put in", _reduced),
    Statement("6.97", "steady precession: the second equation is satisfied", "fb.equations(s) at θ = θ_0, ψ' = ψ_0'",
              _steady, defines=True, print_is="θ = θ_0 = const, ψ' = ψ_0' = const"),
    Statement("6.98", "the condition of steady precession", STEADY + ".branches", _quadratic,
              condition=("theta, without index in the last term, stands for theta_0", _same_angle)),
    Statement("6.99", "the two rates of steady precession", STEADY + "['fast'].solution", _solutions),
    Statement("6.100", "the spin for which steady precession exists", STEADY + "['fast'].existence", _existence),
    Statement("6.101", "the root for a fast spin, epsilon = 4 m g L I_xi cos(theta_0)/(I_zeta Omega_zeta)^2",
              "the exact root", _binomial),
    Statement("6.102", "fast and slow precession for a fast spin", STEADY + "['slow'].limits", _limits),
    Statement("6.103", "the angular momentum in slow precession, along the axis", STEADY + "['slow']", _steady_momentum,
              print_is="H_0 = I_ζ Ω_ζ k"),
    Statement("6.104", "the moment as a vector", "fb.equations(s).free_body('rotor').moments['weight']", _weight,
              print_is="M_0 = m g L sin θ i"),
    Statement("6.105", "the moment turns the angular momentum", STEADY + "['slow']", _vector_balance,
              print_is="M_0 = ω × H_0 = m g L sin θ i"),
    Statement("6.106", "the rate of slow precession", STEADY + "['slow'].limits", _slow_rate),
)  # fmt: skip
