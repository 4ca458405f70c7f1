"""Section 6.8: the torque-free symmetric body, (6.69)-(6.84)."""

from __future__ import annotations

from typing import Any

import sympy

from . import machines
from .motion import euler_derived, euler_symbols
from .statement import Approximation, Line, Statement, balance, value

t = machines.t
ZERO = sympy.Integer(0)


def symmetric() -> tuple[Any, Any, list[Any], list[tuple[Any, Any]]]:
    """I_1, I_3, ω, and (left, right) of the library's moment equations with I_2 = I_1 and no moment."""
    I, w, M = euler_symbols()  # noqa: E741
    put = {I[1]: I[0], **{m: 0 for m in M}}
    return (
        I[0],
        I[2],
        w,
        [(sympy.sympify(a).subs(put), sympy.sympify(b).subs(put)) for a, b in euler_derived()],
    )


def rates() -> dict[Any, Any]:
    """ω_i' along the motion, from these equations."""
    I_1, I_3, w, rows = symmetric()
    found: dict[Any, Any] = {}
    for (left, right), moment, component in zip(rows, (I_1, I_1, I_3), w, strict=True):
        rate = component.diff(t)
        found[rate] = sympy.expand((left - (right - moment * rate)) / moment)
    return found


def along(expression: Any) -> Any:
    """The time derivative of an expression along the motion."""
    return sympy.sympify(expression).diff(t).subs(rates())


def _equations() -> list[Line]:
    I_1, I_3, w, rows = symmetric()
    printed = [
        I_1 * w[0].diff(t) + (I_3 - I_1) * w[1] * w[2],
        I_1 * w[1].diff(t) + (I_1 - I_3) * w[0] * w[2],
        I_3 * w[2].diff(t),
    ]
    return [balance(ZERO, p, row) for p, row in zip(printed, rows, strict=True)]


def _constant(name: str, expression: Any) -> list[Line]:
    """That an expression does not change along the motion."""
    return [value(sympy.Symbol(f"d({name})/dt"), ZERO, along(expression))]


def _spin() -> list[Line]:
    return _constant("omega_3", symmetric()[2][2])


def _omega() -> Any:
    I_1, I_3, w, _ = symmetric()
    return (I_3 - I_1) * w[2] / I_1


def _two() -> list[Line]:
    _, _, w, rows = symmetric()
    I_1 = symmetric()[0]
    rate = _omega()
    printed = (w[0].diff(t) + rate * w[1], w[1].diff(t) - rate * w[0])
    return [
        balance(p, ZERO, (row[1] - row[0], ZERO), scale=I_1) for p, row in zip(printed, rows, strict=False)
    ]


def _multiplied() -> list[Line]:
    _, _, w, _ = symmetric()
    r = rates()
    found = sum(x * r[x.diff(t)] for x in w[:2])
    return [value(sympy.Symbol("omega_1 omega_1' + omega_2 omega_2'"), ZERO, sympy.expand(found))]


def _momentum() -> list[Any]:
    """Components of H_C by the library, in the axes 1, 2, 3."""
    _, e = machines.spinning()
    I_1, _, w, _ = symmetric()
    I = euler_symbols()[0]  # noqa: E741
    put = {sympy.Function(f"omega_w{c}")(t): x for c, x in zip("xyz", w, strict=True)}
    return [x.subs(put).subs(I[1], I_1) for x in machines.upright(e.momentum.angular())]


def _momentum_constant() -> list[Line]:
    """The rate of H_C in the ground, by its components in the body: H' + ω × H."""
    _, _, w, _ = symmetric()
    H = sympy.Matrix(_momentum())
    found = H.diff(t).subs(rates()) + sympy.Matrix(w).cross(H)
    return [value(sympy.Symbol(f"dH_C{i + 1}/dt"), ZERO, sympy.expand(x)) for i, x in enumerate(found)]


def _across() -> list[Line]:
    I_1, _, w, _ = symmetric()
    H = _momentum()
    return [value(sympy.Symbol("H_12^2"), I_1**2 * (w[0] ** 2 + w[1] ** 2), H[0] ** 2 + H[1] ** 2)]


def _plain() -> tuple[Any, Any, Any, Any, Any]:
    """I_1, I_3 and ω_1, ω_2 >= 0, ω_3 as positive symbols, to take roots of."""
    return sympy.symbols("I_1 I_3 omega_1 omega_2 omega_3", positive=True)


def _in_plain(x: Any) -> Any:
    I_1, I_3, w, _ = symmetric()
    J1, J3, a, b, c = _plain()
    return sympy.sympify(x).subs({w[0]: a, w[1]: b, w[2]: c}).subs({I_1: J1, I_3: J3})


def _alpha() -> list[Line]:
    """tan of the angle between axis 3 and H, from the components of H."""
    J1, J3, a, b, c = _plain()
    H = [_in_plain(x) for x in _momentum()]
    printed = J1 * sympy.sqrt(a**2 + b**2) / (J3 * c)
    constant = value(sympy.Symbol("d(tan^2 alpha)/dt"), ZERO, along((_momentum()[0] ** 2 + _momentum()[1] ** 2)
                                                                     / _momentum()[2] ** 2))  # fmt: skip
    derived = sympy.sqrt(sympy.factor(H[0] ** 2 + H[1] ** 2)) / H[2]
    return [value(sympy.Symbol("tan(alpha)"), printed, derived), constant]


def _beta() -> list[Line]:
    """The tangent keeps its value along the motion."""
    w = symmetric()[2]
    return [value(sympy.Symbol("d(tan^2 beta)/dt"), ZERO, along((w[0] ** 2 + w[1] ** 2) / w[2] ** 2))]


def _tangents() -> list[Line]:
    J1, J3, a, b, c = _plain()
    H = [_in_plain(x) for x in _momentum()]
    alpha = sympy.sqrt(sympy.factor(H[0] ** 2 + H[1] ** 2)) / H[2]
    beta = sympy.sqrt(a**2 + b**2) / c
    return [value(sympy.Symbol("tan(alpha)"), J1 / J3 * beta, alpha)]


def _complex() -> list[Line]:
    """Real and imaginary part of ω_12' - i Ω ω_12 along the motion."""
    _, _, w, _ = symmetric()
    r = rates()
    rate = _omega()
    real = r[w[0].diff(t)] + rate * w[1]
    imaginary = r[w[1].diff(t)] - rate * w[0]
    return [
        value(sympy.Symbol("Re(omega_12' - i Omega omega_12)"), ZERO, sympy.expand(real)),
        value(sympy.Symbol("Im(omega_12' - i Omega omega_12)"), ZERO, sympy.expand(imaginary)),
    ]


def _solution() -> list[Line]:
    """ω_1 + i ω_2 = (a + i b) exp(i Ω t) put into the library's equations: what is left of them is zero."""
    I_1, I_3, w, rows = symmetric()
    a, b, c = sympy.symbols("omega_1(0) omega_2(0) omega_3", real=True)
    rate = (I_3 - I_1) * c / I_1
    turned = {
        w[0]: a * sympy.cos(rate * t) - b * sympy.sin(rate * t),
        w[1]: a * sympy.sin(rate * t) + b * sympy.cos(rate * t),
        w[2]: c,
    }
    left = [sympy.sympify(right - left).subs(turned).doit() for left, right in rows]
    return [value(sympy.Symbol(f"M_{i + 1}"), ZERO, x) for i, x in enumerate(left)]


def _components() -> list[Line]:
    """Modulus of the complex number: the projection of ω on the plane 1, 2."""
    a, b = sympy.symbols("omega_1 omega_2", real=True)
    z = a + sympy.I * b
    return [value(sympy.Symbol("|omega_12|^2"), sympy.expand(z * sympy.conjugate(z)), a**2 + b**2)]


def _earth() -> list[Approximation]:
    """Ω from the total angular velocity, which is taken for ω_3: the error is of second order in the angle between."""
    ratio = sympy.Rational(33, 10000)
    angle = sympy.Symbol("beta")
    # axis 3 and ω are 3.1 m apart at the pole, the earth's radius is 6.36e6 m
    return [Approximation(sympy.Symbol("Omega"), ratio * sympy.cos(angle), ratio, angle,
                          sympy.Rational(31, 63600000), {})]  # fmt: skip


EULER = "fb.equations(s).free_body('body', frame='body').equations"
STATEMENTS = (
    Statement("6.69", "Euler's equations of a symmetric body without torque", EULER, _equations),
    Statement("6.70", "the component along the symmetry axis is constant", EULER, _spin, print_is="ω_3 = const"),
    Statement("6.71", "the rate Ω, a constant", EULER, lambda: _constant("Omega", _omega()), defines=True,
              print_is="Ω = (I_3 - I_1) ω_3/I_1 = const"),
    Statement("6.72", "the transverse components turn", EULER, _two),
    Statement("6.73", "their squares do not change, differentiated", EULER, _multiplied),
    Statement("6.74", "the transverse component is constant", EULER,
              lambda: _constant("omega_12^2", symmetric()[2][0] ** 2 + symmetric()[2][1] ** 2),
              print_is="ω_1² + ω_2² = ω_12² = const"),
    Statement("6.75", "the magnitude of the angular velocity is constant", EULER,
              lambda: _constant("|omega|^2", sum(x**2 for x in symmetric()[2])), print_is="|ω| = const"),
    Statement("6.76", "the angular momentum is constant in the ground", "fb.equations(s).momentum.angular()",
              _momentum_constant, print_is="H_C = const"),
    Statement("6.77", "the transverse component of the angular momentum (squared)",
              "fb.equations(s).momentum.angular()", _across, print_is="H_12 = I_1 ω_12"),
    Statement("6.78", "angle between axis 3 and the angular momentum", "fb.equations(s).momentum.angular()", _alpha,
              print_is="tan α = H_12/H_3 = I_1 ω_12/(I_3 ω_3) = const"),
    Statement("6.79", "angle between axis 3 and the angular velocity", EULER, _beta,
              print_is="tan β = ω_12/ω_3 = const", defines=True),
    Statement("6.80", "the two angles are tied", "fb.equations(s).momentum.angular()", _tangents,
              print_is="tan α = (I_1/I_3) tan β"),
    Statement("6.81", "the transverse components as one complex number", EULER, _components, defines=True,
              print_is="ω_12 = ω_1 + i ω_2"),
    Statement("6.82", "its differential equation", EULER, _complex, print_is="ω_12' - i Ω ω_12 = 0"),
    Statement("6.83", "its solution, put into Euler's equations", EULER, _solution,
              print_is="ω_12(t) = ω_12(0) exp(i Ω t)"),
    Statement("6.84", "wobble of the earth, with ω_3 taken for the whole angular velocity [1/day]",
              "fb.exact.torque_free(I, w0)", _earth),
)  # fmt: skip
