"""Section 6.8: the torque-free symmetric body, (6.69)-(6.84)."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy
from sympy import acos, atan2, cos, sin, sqrt

from . import machines
from .meaning import Meaning
from .momentum import resolved, vector
from .motion import principal
from .small import Small, put
from .statement import Statement

t = machines.t
AXIS = vector(0, 0, 1)


@cache
def symmetric() -> tuple[Meaning, list[tuple[Any, Any]]]:
    """Return (meaning, rates of ω along the motion) of the body with I_2 = I_1 and no moment, by the library."""
    names = principal().names
    equal = [(names["I_2"], names["I_1"])]
    w = [names[f"ω_{i}"] for i in "123"]
    moments = [put(names[f"M_{i}"], equal) for i in "123"]
    rates = machines.solved(moments, [x.diff(t) for x in w])
    machine = machines.spinning()
    e = machine.equations
    from ..dynamics.kinematics import coordinate_rates

    # H_C and ω in ground axes depend on the quaternion of the joint; the library also gives its rates
    turning = [(q.diff(t), e.sympy(rate)) for q, rate in
               zip(e.coordinates, coordinate_rates(e.model, e.state), strict=True)]  # fmt: skip
    omega = machine.omega("body")
    H = machine.momentum().applyfunc(lambda x: put(x, equal))
    ratio = -sympy.diff(sympy.expand(rates[0][1]), w[1])  # ω_1' = -Ω ω_2
    own = {"H_C": H, "ω": omega, "Ω": ratio, "I_2": names["I_1"]}
    instant = [
        (q, int(i == 0)) for i, q in enumerate(e.coordinates)
    ]  # ground axes are chosen along body axes
    return Meaning({**names, **own}, along=[*rates, *turning, *instant]), rates


def _along() -> Meaning:
    return symmetric()[0]


def upright(x: Any) -> Any:
    """Return an expression at the instant at which body and ground axes coincide."""
    e = machines.spinning().equations
    return x.subs({q: int(i == 0) for i, q in enumerate(e.coordinates)})


@cache
def projected() -> Meaning:
    """Projections of ω and H_C on the plane 1, 2 and their angles with axis 3, by dot and cross products.

    Components are positive functions, so that roots can be taken.
    """
    meaning, rates = symmetric()
    n = meaning.names
    plain = {n[f"ω_{i}"]: sympy.Function(f"omega_{i}", positive=True)(t) for i in "123"}
    both = lambda x: x.subs({k.diff(t): v.diff(t) for k, v in plain.items()}).subs(plain)  # noqa: E731
    J = {n["I_1"]: sympy.Symbol("I_1", positive=True), n["I_3"]: sympy.Symbol("I_3", positive=True)}
    omega, H = (both(upright(n[k])).subs(J) for k in ("ω", "H_C"))
    size = lambda v: sqrt(sympy.factor(sympy.expand(v.dot(v))))  # noqa: E731
    across = lambda v: size(v.cross(AXIS))  # noqa: E731
    angle = lambda v: acos(AXIS.dot(v) / size(v))  # noqa: E731
    names = {
        **{k: both(v).subs(J) for k, v in n.items() if isinstance(v, sympy.Expr)}, "ω": omega, "H_C": H,
        "ω_12": across(omega), "H_12": across(H), "H_3": AXIS.dot(H), "α": angle(H), "β": angle(omega),
    }  # fmt: skip
    return Meaning(names, along=[(both(k), both(v).subs(J)) for k, v in rates])


def _complex() -> Meaning:
    """The projection of ω as a complex number: its magnitude and its angle from axis 1."""
    n = symmetric()[0].names
    w = [sympy.Symbol(f"omega_{i}", real=True) for i in "123"]
    omega = upright(n["ω"]).subs({n[f"ω_{i}"]: x for i, x in zip("123", w, strict=True)})
    size, angle = sqrt(omega.cross(AXIS).dot(omega.cross(AXIS))), atan2(omega[1], omega[0])
    return Meaning(
        {
            **resolved("ω_1 ω_2 ω_3", w),
            "i": sympy.I,
            "ω_12": sympy.expand(size * (cos(angle) + sympy.I * sin(angle))),
        }
    )


def _rotating() -> Meaning:
    """ω_1 + i ω_2 along the motion."""
    meaning, _ = symmetric()
    n = meaning.names
    return Meaning({**n, "i": sympy.I, "ω_12": n["ω_1"] + sympy.I * n["ω_2"]}, along=meaning.along)


def _solution() -> Meaning:
    """The library's two linear equations solved by their matrix exponential, from ω_1(0) + i ω_2(0)."""
    _, rates = symmetric()
    n = symmetric()[0].names
    rate = sympy.Symbol("Omega", real=True)
    start = sympy.symbols("omega_1(0) omega_2(0)", real=True)
    w = [n["ω_1"], n["ω_2"]]
    matrix = sympy.Matrix(2, 2, lambda i, j: sympy.diff(sympy.expand(rates[i][1]), w[j]))
    # every entry is 0 or ± Ω
    named = matrix.applyfunc(lambda x: sympy.cancel(x / n["Ω"]) * rate)
    solution = (named * t).exp() * sympy.Matrix(start)
    parts = [sympy.expand(x, complex=True) for x in solution]
    return Meaning({"ω_12(t)": parts[0] + sympy.I * parts[1], "ω_12(0)": start[0] + sympy.I * start[1], "Ω": rate,
    "t": t,
                    "i": sympy.I})  # fmt: skip


def _earth() -> Meaning:
    """Ω by the library's equations in rotations per day: I_3/I_1 - 1 = 0.0033, and |ω| is one rotation per day.

    ω_3 = |ω| cos β is the component along the axis: the axes are 3.1 m apart at the pole, and the earth's radius is
    6.36e6 m.
    """
    n = symmetric()[0].names
    angle = sympy.Symbol("beta")
    moment = sympy.Symbol("I_1", positive=True)
    earth = [(n["I_3"], moment * (1 + sympy.Rational(33, 10000))), (n["I_1"], moment), (n["ω_3"], cos(angle))]
    names = {name: put(n[name], earth) for name in ("Ω", "I_1", "I_3", "ω_3")}
    return Meaning(names, small=Small(angle, sympy.Rational(31, 63600000), [(moment, 1)]))


EULER = "fb.equations(s).free_body('body', frame='body').equations"
VECTORS = "fb.equations(s).momentum.angular(), dynamics.kinematics.angular_velocity"
STATEMENTS = (
    Statement("6.69", "Euler's equations of a symmetric body without torque", EULER,
              ("I_1 ω_1' + (I_3 - I_1) ω_2 ω_3 = 0", "I_1 ω_2' + (I_1 - I_3) ω_1 ω_3 = 0", "I_3 ω_3' = 0"),
              lambda: Meaning(_along().names, rows={i: (_symmetric_moment(i), 0) for i in range(3)})),
    Statement("6.70", "the component along the symmetry axis is constant", EULER, "ω_3 = const", _along),
    Statement("6.71", "the rate Ω, a constant", EULER, "(I_3 - I_1) ω_3/I_1 = Ω = const", _along, defines=True),
    Statement("6.72", "the transverse components turn", EULER, ("ω_1' + Ω ω_2 = 0", "ω_2' - Ω ω_1 = 0"), _along),
    Statement("6.73", "their squares do not change, differentiated", EULER, "ω_1 ω_1' + ω_2 ω_2' = 0", _along),
    Statement("6.74", "the transverse component is constant", EULER + "; " + VECTORS,
              "ω_1^2 + ω_2^2 = ω_12^2 = const", projected),
    Statement("6.75", "the magnitude of the angular velocity is constant", EULER + "; " + VECTORS,
              "|ω| = (ω_1^2 + ω_2^2 + ω_3^2)^(1/2) = const", projected),
    Statement("6.76", "the angular momentum is constant in the ground", EULER + "; " + VECTORS, "H_C = const", _along),
    Statement("6.77", "the transverse component of the angular momentum", VECTORS,
              "H_12 = (I_1^2 ω_1^2 + I_2^2 ω_2^2)^(1/2) = I_1 (ω_1^2 + ω_2^2)^(1/2) = I_1 ω_12", projected),
    Statement("6.78", "angle between axis 3 and the angular momentum", EULER + "; " + VECTORS,
              "tan α = H_12/H_3 = I_1 ω_12/(I_3 ω_3) = const", projected),
    Statement("6.79", "angle between axis 3 and the angular velocity", EULER + "; " + VECTORS,
              "tan β = ω_12/ω_3 = const",
              projected),
    Statement("6.80", "the two angles are tied", VECTORS, "tan α = I_1/I_3 tan β", projected),
    Statement("6.81", "the transverse components as one complex number", VECTORS, "ω_12 = ω_1 + i ω_2", _complex,
              defines=True),
    Statement("6.82", "its differential equation", EULER, "ω_12' - i Ω ω_12 = 0", _rotating),
    Statement("6.83", "its solution", EULER + ", solved by a matrix exponential", "ω_12(t) = ω_12(0) exp(i Ω t)",
              _solution),
    Statement("6.84", "wobble of the earth, with ω_3 taken for the whole angular velocity [1/day]", EULER,
              "Ω = (I_3 - I_1) ω_3/I_1 ≅ 0.0033", _earth),
)  # fmt: skip


def _symmetric_moment(i: int) -> Any:
    names = principal().names
    return put(names[f"M_{i + 1}"], [(names["I_2"], names["I_1"])])
