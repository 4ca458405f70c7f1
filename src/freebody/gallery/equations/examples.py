"""Examples 6.1-6.4: the lettered equations, from models in which the contact forces are loads with names."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy
from sympy import cos, sin, sqrt

import freebody as fb

from ..hinged_bar import build as hinged_bar
from . import machines
from .statement import Line, Statement, balance, value

t = machines.t
SENSE = sympy.Symbol("sense")
"""+1 where friction acts backwards on the disk, -1 where it acts forwards."""


# --- Example 6.1 ---------------------------------------------------------------------------------------------------


@cache
def sliding() -> tuple[fb.System, list[tuple[Any, Any]]]:
    """The body on two feet, every force on it a load; (left, right) of its two force and one moment equations."""
    s = fb.System("sliding body")
    m, L, H, D, mu, beta, F, g = s.parameters(m=50, L=1.2, H=0.8, D=0.15, mu=0.25, beta=0.35, F=200, g=9.81)
    N_A, N_B = s.parameters(N_A=1, N_B=1)
    s.gravity = (0, -g, 0)
    body = s.body("body", fb.box(m, (L, H, D)))
    s.planar("plane", s.ground, body, coordinate="x y theta")
    s.force("F", body.point(-L / 2, H / 2, 0), (F * cos(beta), F * sin(beta), 0))
    for name, N, side in (("A", N_A, -1), ("B", N_B, 1)):
        s.force(f"foot_{name}", body.point(side * L / 2, -(H / 2 + D), 0), (-mu * N, N, 0))
    rows = fb.equations(s).free_body("body").planar_equations
    still = {s.names.atoms["theta"]: 0}
    put = {sympy.Function(q)(t).diff(t, 2): 0 for q in ("theta", "y")}
    return s, [tuple(sympy.sympify(x).subs(put).subs(still) for x in (row.lhs, row.rhs)) for row in rows]


def _a61() -> tuple[dict[str, Any], Any]:
    s, _ = sliding()
    return s.names.atoms, s.names.atoms["x"].diff(t, 2)


def _sliding_forces(i: int) -> list[Line]:
    a, ax = _a61()
    _, rows = sliding()
    N = a["N_A"] + a["N_B"]
    left, right = (
        (a["F"] * cos(a["beta"]) - a["mu"] * N, a["m"] * ax),
        (a["F"] * sin(a["beta"]) + N - a["m"] * a["g"], sympy.Integer(0)),
    )[i]
    return [balance(left, right, rows[i])]


def _sliding_moment() -> list[Line]:
    a, _ = _a61()
    _, rows = sliding()
    F, H, L, D, mu, b = (a[k] for k in ("F", "H", "L", "D", "mu", "beta"))
    left = (
        -F * cos(b) * H / 2
        + (a["N_B"] - a["N_A"] - F * sin(b)) * L / 2
        - mu * (a["N_A"] + a["N_B"]) * (D + H / 2)
    )
    return [balance(left, sympy.Integer(0), rows[2])]


def _tipping() -> list[Line]:
    a, _ = _a61()
    _, rows = sliding()
    F, H, L, D, mu, b, m, g = (a[k] for k in ("F", "H", "L", "D", "mu", "beta", "m", "g"))
    equations = [sympy.expand((x - y).subs(a["N_A"], 0)) for x, y in rows]
    # N_B from the vertical balance, then F from that of moments: both are linear
    N_B = -equations[1].coeff(a["N_B"], 0) / equations[1].coeff(a["N_B"], 1)
    last = sympy.expand(equations[2].subs(a["N_B"], N_B))
    derived = -last.coeff(F, 0) / last.coeff(F, 1)
    printed = m * g * (L - 2 * mu * D - mu * H) / (H * cos(b) + (2 * L - 2 * mu * D - mu * H) * sin(b))
    return [value(F, printed, derived)]


# --- Example 6.2 ---------------------------------------------------------------------------------------------------


@cache
def bar() -> tuple[Any, dict[str, Any], Any]:
    """(equations, atoms, moment of inertia about the hinge by the library) of the hinged bar."""
    s = hinged_bar()
    e = fb.equations(s)
    return e, s.names.atoms, e.mass_matrix[0, 0]


def _bar_alpha() -> Any:
    """Angular acceleration at rest in the horizontal position, by the library's equation of motion."""
    e, a, I_0 = bar()
    return -(e.bias[0].subs({a["theta'"]: 0, a["theta"]: 0})) / I_0


def _bar_moment() -> list[Line]:
    e, a, I_0 = bar()
    printed = -a["L"] * a["m"] * a["g"] / 6
    return [value(sympy.Symbol("M_0"), printed, I_0 * _bar_alpha())]


def _bar_inertia() -> list[Line]:
    _, a, I_0 = bar()
    x = sympy.Symbol("x")
    integral = sympy.integrate(x**2, (x, -a["L"] / 3, 2 * a["L"] / 3)) * a["m"] / a["L"]
    return [
        value(sympy.Symbol("I_0"), integral, I_0),
        value(sympy.Symbol("I_0"), a["m"] * a["L"] ** 2 / 9, I_0),
    ]


def _bar_first() -> list[Line]:
    _, a, _ = bar()
    return [value(sympy.Symbol("alpha"), -sympy.Rational(3, 2) * a["g"] / a["L"], _bar_alpha())]


def _bar_reaction() -> Any:
    e, a, _ = bar()
    name = next(iter(e.reactions))
    force = e.reactions[name].force[1]
    put = {a["theta"].diff(t, 2): _bar_alpha(), a["theta'"]: 0}
    return sympy.sympify(force).subs(put).subs(a["theta"], 0)


def _bar_vertical() -> list[Line]:
    _, a, _ = bar()
    m, g = a["m"], a["g"]
    F_y = sympy.Symbol("F_y")
    found = _bar_reaction() - m * g
    return [
        value(F_y, m * a["L"] / 6 * (-sympy.Rational(3, 2) * g / a["L"]), found),
        value(F_y, -m * g / 4, found),
    ]


def _bar_r() -> list[Line]:
    _, a, _ = bar()
    return [value(sympy.Symbol("R"), sympy.Rational(3, 4) * a["m"] * a["g"], _bar_reaction())]


def _bar_energy() -> list[Line]:
    """The rate of T + V along the motion, by the library's proof of its integral."""
    e, _, _ = bar()
    integral = e.integrals["energy"]
    along = sympy.sympify(integral.expression).diff(t)
    a = bar()[1]
    acceleration = -e.bias[0] / e.mass_matrix[0, 0]
    return [value(sympy.Symbol("dE/dt"), sympy.Integer(0), along.subs(a["theta"].diff(t, 2), acceleration))]


def _potential(angle: Any) -> Any:
    """V less that of the horizontal position."""
    e, a, _ = bar()
    V = sympy.sympify(e.energy.potential)
    return V.subs(a["theta"], angle) - V.subs(a["theta"], 0)


def _bar_start() -> list[Line]:
    e, a, _ = bar()
    T = sympy.sympify(e.energy.kinetic).subs(a["theta'"], 0)
    return [value(sympy.Symbol("E"), sympy.Integer(0), T + _potential(sympy.Integer(0)))]


def _bar_v2() -> list[Line]:
    _, a, _ = bar()
    return [value(sympy.Symbol("V_2"), -a["L"] * a["m"] * a["g"] / 6, _potential(-sympy.pi / 2))]


def _bar_t2() -> list[Line]:
    e, a, I_0 = bar()
    w = sympy.Symbol("omega_2")
    T = sympy.sympify(e.energy.kinetic).subs(a["theta'"], w)
    return [value(sympy.Symbol("T_2"), w**2 * a["m"] * a["L"] ** 2 / 6, T)]


def _bar_omega() -> list[Line]:
    _, a, I_0 = bar()
    derived = -sqrt(-2 * _potential(-sympy.pi / 2) / I_0)
    L, g = sympy.symbols("L g", positive=True)
    put = {a["L"]: L, a["g"]: g}
    return [
        value(
            sympy.Symbol("omega_2"), -sqrt(3 * g / L), sympy.sqrt(sympy.cancel((derived**2).subs(put))) * -1
        )
    ]


# --- Example 6.3 ---------------------------------------------------------------------------------------------------


@cache
def pulled() -> tuple[dict[str, Any], list[tuple[Any, Any]]]:
    """The disk, every force on it a load."""
    s = fb.System("pulled disk")
    m, R, h, mu, F, H, V, W = s.parameters(m=10, R=0.3, h=0.4, mu=0.2, F=30, H=1, V=98, W=98)
    s.parameters(alpha=0, a_Cx=0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, coordinate="x y theta")
    # a point of the ground's axes at height h - R above C: of the body at θ = 0
    s.force("F", disk.point(0, h - R, 0), (F, 0, 0))
    s.force("floor", disk.point(0, -R, 0), (-H, V, 0))
    s.force("weight", disk.origin, (0, -W, 0))
    a = s.names.atoms
    put = {a["theta"].diff(t, 2): a["alpha"], a["x"].diff(t, 2): a["a_Cx"], a["y"].diff(t, 2): 0}
    rows = fb.equations(s).free_body("disk").planar_equations
    return a, [tuple(sympy.sympify(x).subs(put).subs(a["theta"], 0) for x in (r.lhs, r.rhs)) for r in rows]


def _I_C(a: dict[str, Any]) -> Any:
    return a["m"] * a["R"] ** 2 / 2


def _pulled_rows() -> list[Line]:
    a, rows = pulled()
    F, H, V, W, m, R, h = (a[k] for k in ("F", "H", "V", "W", "m", "R", "h"))
    return [
        balance(F - H, m * a["a_Cx"], rows[0]),
        balance(V - W, sympy.Integer(0), rows[1]),
        balance(-F * (h - R) - H * R, _I_C(a) * a["alpha"], rows[2]),
    ]


@cache
def _solved(slip: bool) -> dict[str, Any]:
    """Accelerations and friction by the free-body equations and the condition of the case: all linear."""
    a, rows = pulled()
    unknowns = [a["a_Cx"], a["alpha"], a["H"], a["V"]]
    extra = a["H"] - SENSE * a["mu"] * a["V"] if slip else _no_slip()
    found = sympy.solve([x - y for x, y in rows] + [extra], unknowns, dict=True)[0]
    return {str(k): v for k, v in found.items()}


def _no_slip() -> Any:
    """Acceleration along x of the point of the disk at the floor, by the library: zero as it rolls."""
    from ...dynamics.kinematics import point_velocity

    s = fb.System("rolling")
    R = s.parameters(R=1)
    body = s.body("disk", fb.disk(1, R))
    s.planar("plane", s.ground, body, coordinate="x y theta")
    e = fb.equations(s)
    # the velocity of the lowest point at θ = 0; as the disk rolls it stays zero, and so does its rate
    speed = e.sympy(point_velocity(e.model, e.state, body.point(0, -R, 0))[0])
    b, a = s.names.atoms, pulled()[0]
    return speed.subs({b["x'"]: a["a_Cx"], b["theta'"]: a["alpha"]}).subs(b["theta"], 0).subs(b["R"], a["R"])


def _roll() -> list[Line]:
    a, _ = pulled()
    return [balance(a["a_Cx"], -a["alpha"] * a["R"], (_no_slip(), sympy.Integer(0)))]


def _roll_answer(name: str, printed: Any) -> list[Line]:
    a, _ = pulled()
    return [value(sympy.Symbol(name), x, _solved(False)[name]) for x in printed(a)]


def _limit() -> list[Line]:
    """The force at which friction is just enough: H = ± μ V with H as it rolls, + where it acts backwards."""
    a, _ = pulled()
    F, mu, W, h, R = (a[k] for k in ("F", "mu", "W", "h", "R"))
    ratio = sympy.cancel(_solved(False)["H"] / F)
    return [value(F, mu * W / (1 - 2 * h / (3 * R)), SENSE * mu * _solved(False)["V"] / ratio)]


def _slip_answer(name: str, printed: Any) -> list[Line]:
    a, _ = pulled()
    return [value(sympy.Symbol(name), printed(a), _solved(True)[name])]


# --- Example 6.4 ---------------------------------------------------------------------------------------------------


@cache
def rolling() -> tuple[dict[str, Any], Any, Any]:
    """A disk that rolls down an incline: (atoms, kinetic energy in v, potential energy after a drop H)."""
    s = fb.System("disk down an incline")
    m, R, g, H, v, w = s.parameters(m=5, R=0.25, g=9.81, H=2, v_2=1, omega_2=1)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, coordinate="x y theta")
    e = fb.equations(s)
    a = s.names.atoms
    T = sympy.sympify(e.energy.kinetic).subs({a["x'"]: v, a["y'"]: 0, a["theta'"]: w})
    V = sympy.sympify(e.energy.potential)
    return a, T, V.subs(a["y"], -H) - V.subs(a["y"], 0)


def _disk_t2() -> list[Line]:
    a, T, _ = rolling()
    return [
        value(
            sympy.Symbol("T_2"),
            a["m"] * a["v_2"] ** 2 / 2 + a["m"] * a["R"] ** 2 / 2 * a["omega_2"] ** 2 / 2,
            T,
        )
    ]


def _disk_rolling() -> Any:
    """T_2 with v = -R ω, the velocity of the lowest point zero."""
    a, T, _ = rolling()
    return sympy.expand(T.subs(a["omega_2"], -a["v_2"] / a["R"]))


def _disk_e() -> list[Line]:
    a, _, V = rolling()
    return [balance(sympy.Rational(3, 4) * a["m"] * a["v_2"] ** 2 - a["m"] * a["g"] * a["H"], sympy.Integer(0),
                    (_disk_rolling() + V, sympy.Integer(0)))]  # fmt: skip


def _disk_v2() -> list[Line]:
    a, _, V = rolling()
    square = -V / sympy.cancel(_disk_rolling() / a["v_2"] ** 2)
    g, H = sympy.symbols("g H", positive=True)
    put = {a["g"]: g, a["H"]: H}
    return [value(a["v_2"], sqrt(4 * g * H / 3), sqrt(sympy.cancel(square.subs(put))))]


FREE = "fb.equations(s).free_body(...).planar_equations"


def _backwards() -> dict[Any, Any]:
    return {SENSE: 1}


BACKWARDS = ("friction acts backwards: 2 h < 3 R, and the lowest point slips forwards", _backwards)

STATEMENTS = (
    Statement("ex-6-1 (a)", "sliding body: force equation along x", FREE, lambda: _sliding_forces(0)),
    Statement("ex-6-1 (b)", "sliding body: force equation along y", FREE, lambda: _sliding_forces(1)),
    Statement("ex-6-1 (c)", "sliding body: moment equation about C", FREE, _sliding_moment),
    Statement("ex-6-1 (d)", "the force at which the rear foot lifts", FREE + ", solved at N_A = 0", _tipping),
    Statement("ex-6-2 (a)", "hinged bar: moment about the hinge just after release", "fb.equations(s).motion",
              _bar_moment),
    Statement("ex-6-2 (b)", "hinged bar: moment of inertia about the hinge", "fb.equations(s).mass_matrix",
              _bar_inertia),
    Statement("ex-6-2 (c)", "hinged bar: angular acceleration just after release", "fb.equations(s).motion",
              _bar_first),
    Statement("ex-6-2 (d)", "hinged bar: vertical force equation just after release",
              "fb.equations(s).reactions['hinge']", _bar_vertical),
    Statement("ex-6-2 (e)", "hinged bar: reaction just after release", "fb.equations(s).reactions['hinge']", _bar_r),
    Statement("ex-6-2 (f)", "hinged bar: the energy is conserved", "fb.equations(s).integrals['energy']", _bar_energy,
              print_is="E = T + V = const"),
    Statement("ex-6-2 (g)", "hinged bar: the energy at the start", "fb.equations(s).energy", _bar_start),
    Statement("ex-6-2 (h)", "hinged bar: potential energy in the vertical position", "fb.equations(s).energy.potential",
              _bar_v2),
    Statement("ex-6-2 (i)", "hinged bar: kinetic energy in the vertical position", "fb.equations(s).energy.kinetic",
              _bar_t2),
    Statement("ex-6-2 (j)", "hinged bar: angular velocity in the vertical position", "fb.equations(s).energy",
              _bar_omega),
    Statement("ex-6-3 (a)", "pulled disk: two force equations and a moment equation", FREE, _pulled_rows),
    Statement("ex-6-3 (b)", "rolling without slip: accelerations are tied",
              "dynamics.kinematics.point_velocity of the lowest point", _roll),
    Statement("ex-6-3 (c)", "pulled disk, no slip: acceleration of C", FREE + ", solved", lambda: _roll_answer(
        "a_Cx", lambda a: (a["F"] * a["R"] * a["h"] / (_I_C(a) + a["m"] * a["R"] ** 2),
                           2 * a["F"] * a["h"] / (3 * a["m"] * a["R"])))),
    Statement("ex-6-3 (d)", "pulled disk, no slip: angular acceleration", FREE + ", solved", lambda: _roll_answer(
        "alpha", lambda a: (-2 * a["F"] * a["h"] / (3 * a["m"] * a["R"] ** 2),))),
    Statement("ex-6-3 (e)", "pulled disk, no slip: friction force", FREE + ", solved", lambda: _roll_answer(
        "H", lambda a: (a["F"] * (1 - 2 * a["h"] / (3 * a["R"])),))),
    Statement("ex-6-3 (f)", "the largest force without slip", FREE + ", solved for |H| = mu V", _limit,
              condition=BACKWARDS),
    Statement("ex-6-3 (g)", "friction as the disk slips", FREE + ", solved", lambda: _slip_answer(
        "H", lambda a: a["mu"] * a["W"]), condition=BACKWARDS),
    Statement("ex-6-3 (h)", "pulled disk that slips: acceleration of C", FREE + ", solved", lambda: _slip_answer(
        "a_Cx", lambda a: (a["F"] - a["mu"] * a["W"]) / a["m"]), condition=BACKWARDS),
    Statement("ex-6-3 (i)", "pulled disk that slips: angular acceleration", FREE + ", solved", lambda: _slip_answer(
        "alpha", lambda a: -2 * (a["F"] * (a["h"] - a["R"]) + a["mu"] * a["W"] * a["R"]) / (a["m"] * a["R"] ** 2)),
        condition=BACKWARDS),
    Statement("ex-6-4 (a)", "rolling disk: kinetic energy", "fb.equations(s).energy.kinetic", _disk_t2),
    Statement("ex-6-4 (b)", "rolling disk: kinetic energy in the speed of C", "fb.equations(s).energy.kinetic",
              lambda: [value(sympy.Symbol("T_2"), sympy.Rational(3, 4) * rolling()[0]["m"] * rolling()[0]["v_2"] ** 2,
                             _disk_rolling())]),
    Statement("ex-6-4 (c)", "rolling disk: the energy is conserved", "fb.equations(s).energy", _disk_e),
    Statement("ex-6-4 (d)", "rolling disk: speed after the drop", "fb.equations(s).energy", _disk_v2),
)  # fmt: skip
