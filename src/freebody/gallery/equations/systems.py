"""Section 6.7: systems of rigid bodies, (6.67)-(6.68), and Example 6.5."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy
from sympy import cos, sin

import freebody as fb

from ..cart_and_bar import build as cart_and_bar
from ..double_pendulum import build as double_pendulum
from . import machines
from .statement import Line, Statement, balance, value

t = machines.t
F_x, F_y, f = sympy.symbols("F_x F_y f")
ZERO = sympy.Integer(0)


@cache
def links() -> Any:
    """Equations of the double pendulum."""
    return fb.equations(double_pendulum())


def _forces_of_all() -> list[Line]:
    """Of every body: the sum of forces, with the reactions that the library gives, less m a_C."""
    e = links()
    rows = []
    for name in e.model.bodies:
        free = e.free_body(name)
        total = sum((sympy.Matrix(v) for v in free.forces.values()), sympy.zeros(3, 1))
        ma = [e.sympy(x) for x in free.mass_acceleration]
        for i in (0, 1):
            row = free.equations[i]
            rows.append(balance(total[i], ma[i], (row.lhs, row.rhs)))
    return rows


def _moments_of_all() -> list[Line]:
    e = links()
    rows = []
    for name in e.model.bodies:
        free = e.free_body(name)
        total = sum((sympy.Matrix(v) for v in free.moments.values()), sympy.zeros(3, 1))
        rate = [e.sympy(x) for x in free.momentum_rate]
        rows.append(balance(total[2], rate[2], (free.equations[5].lhs, free.equations[5].rhs)))
    return rows


def _planar_moments() -> list[Line]:
    e = links()
    rows = []
    for i, (name, place) in enumerate(e.model.bodies.items()):
        free = e.free_body(name)
        I_C = e.sympy(e.state(place.inertia[2][2]))
        angle = e.coordinates[i]
        rows.append(value(sympy.Symbol(f"M_C{i + 1}"), I_C * angle.diff(t, 2), free.equations[5].rhs))
    return rows


# --- Example 6.5 -------------------------------------------------------------------------------------------------


@cache
def cart() -> dict[str, Any]:
    """Example 6.5: atoms, and the planar equations of both bodies with the chapter's names of the reactions."""
    s = cart_and_bar()
    e = fb.equations(s)
    a = dict(s.names.atoms)
    # the pin's reaction is that on the bar; the chapter's F_x, F_y act on the particle
    names = {"pin_x": -F_x, "pin_y": -F_y, "guide_y": f, "pin_z": 0, "guide_z": 0}

    def put(x: Any) -> Any:
        expression = sympy.sympify(x)
        return expression.subs({u: names[str(u)] for u in expression.free_symbols if str(u) in names})

    particle, bar = e.free_body("cart"), e.free_body("bar")
    rows = [*particle.equations[:2], *bar.planar_equations]
    acceleration = [[e.sympy(x) for x in e.center_acceleration(name)] for name in ("cart", "bar")]
    a.update(
        {
            "a_0x": acceleration[0][0],
            "a_0y": acceleration[0][1],
            "a_Cx": acceleration[1][0],
            "a_Cy": acceleration[1][1],
        }
    )
    return {"rows": [(put(row.lhs), put(row.rhs)) for row in rows], "e": e, "s": s, **a}


def _row(i: int) -> list[Line]:
    c = cart()
    theta, a, I_C = c["theta"], c["a"], c["m"] * c["a"] ** 2 / 3
    printed = (
        (F_x - c["k"] * c["x"], c["M"] * c["a_0x"]),
        (f + F_y - c["M"] * c["g"], c["M"] * c["a_0y"]),
        (c["F"] - F_x, c["m"] * c["a_Cx"]),
        (-F_y - c["m"] * c["g"], c["m"] * c["a_Cy"]),
        ((c["F"] + F_x) * a * cos(theta) + F_y * a * sin(theta), I_C * theta.diff(t, 2)),
    )[i]
    return [balance(*printed, c["rows"][i])]


def _eliminated() -> list[Line]:
    """The combinations free of F_x and F_y, against the equations of motion of the library."""
    c = cart()
    theta, a, m = c["theta"], c["a"], c["m"]
    motion = [(row.lhs, row.rhs) for row in c["e"].motion]
    first = (c["M"] * c["a_0x"] + m * c["a_Cx"] + c["k"] * c["x"], c["F"])
    second = (
        m * a**2 / 3 * theta.diff(t, 2)
        + m * a * (c["a_Cx"] * cos(theta) + c["a_Cy"] * sin(theta))
        + m * c["g"] * a * sin(theta),
        2 * c["F"] * a * cos(theta),
    )
    return [balance(*first, motion[0]), balance(*second, motion[1])]


def _accelerations(names: tuple[str, ...]) -> list[Line]:
    c = cart()
    theta, a = c["theta"], c["a"]
    dd, d = theta.diff(t, 2), theta.diff(t)
    printed = {
        "a_0x": c["x"].diff(t, 2),
        "a_0y": ZERO,
        "a_Cx": c["x"].diff(t, 2) + a * (dd * cos(theta) - d**2 * sin(theta)),
        "a_Cy": a * (dd * sin(theta) + d**2 * cos(theta)),
    }
    return [value(sympy.Symbol(n), printed[n], c[n]) for n in names]


def _geometry() -> dict[str, Any]:
    from ...dynamics.kinematics import angular_velocity, point_position

    c = cart()
    e, s = c["e"], c["s"]
    place = lambda b: sympy.Matrix([e.sympy(x) for x in point_position(e.model, e.state, s.bodies[b].origin)])  # noqa: E731
    w = sympy.Matrix([e.sympy(x) for x in angular_velocity(e.model, e.state, s.bodies["bar"])])
    return {"r": place("bar") - place("cart"), "w": w}


def _relative() -> list[Line]:
    c, k = cart(), _geometry()
    r, w = k["r"], k["w"]
    printed = sympy.Matrix([c["a_0x"], c["a_0y"], 0]) + w.cross(w.cross(r)) + w.diff(t).cross(r)
    return [value(sympy.Symbol(n), printed[i], c[n]) for i, n in enumerate(("a_Cx", "a_Cy"))]


def _vectors() -> list[Line]:
    c, k = cart(), _geometry()
    theta, a = c["theta"], c["a"]
    names = sympy.symbols("r_0Cx r_0Cy")
    rows = [value(n, p, d) for n, p, d in zip(names, (a * sin(theta), -a * cos(theta)), k["r"], strict=False)]
    rows.append(value(sympy.Symbol("omega_z"), theta.diff(t), k["w"][2]))
    return [*rows, value(sympy.Symbol("alpha_z"), theta.diff(t, 2), k["w"].diff(t)[2])]


def _motion() -> list[Line]:
    c = cart()
    theta, a, m = c["theta"], c["a"], c["m"]
    dd, d, ddx = theta.diff(t, 2), theta.diff(t), c["x"].diff(t, 2)
    motion = [(row.lhs, row.rhs) for row in c["e"].motion]
    first = ((c["M"] + m) * ddx + m * a * (dd * cos(theta) - d**2 * sin(theta)) + c["k"] * c["x"], c["F"])
    second = (
        m * a**2 * dd / 2 + m * ddx * cos(theta) + m * c["g"] * a * sin(theta),
        2 * c["F"] * a * cos(theta),
    )
    return [balance(*first, motion[0]), balance(*second, motion[1])]


FREE = "fb.equations(s).free_body(...)"
STATEMENTS = (
    Statement("6.67a", "force equations of every body", f"{FREE}.equations", _forces_of_all, print_is="F_i = m_i a_Ci"),
    Statement("6.67b", "moment equations of every body", f"{FREE}.equations", _moments_of_all,
              print_is="M_Ci = dH_Ci/dt"),
    Statement("6.68", "moment equations of every body, planar", f"{FREE}.equations", _planar_moments,
              print_is="M_Ci = I_Ci θ_i''"),
    Statement("ex-6-5 (a)", "particle: force equation along x", f"{FREE}.equations", lambda: _row(0)),
    Statement("ex-6-5 (b)", "particle: force equation along y", f"{FREE}.equations", lambda: _row(1)),
    Statement("ex-6-5 (c)", "bar: force equation along x", f"{FREE}.planar_equations", lambda: _row(2)),
    Statement("ex-6-5 (d)", "bar: force equation along y", f"{FREE}.planar_equations", lambda: _row(3)),
    Statement("ex-6-5 (e)", "bar: moment equation about C", f"{FREE}.planar_equations", lambda: _row(4)),
    Statement("ex-6-5 (f)", "the combinations that are free of the hinge force", "fb.equations(s).motion; .eliminate()",
              _eliminated),
    Statement("ex-6-5 (g)", "acceleration of the particle as a vector", "Equations.center_acceleration",
              lambda: _accelerations(("a_0x", "a_0y")), print_is="a_0 = x'' i"),
    Statement("ex-6-5 (h)", "acceleration of the particle by components", "Equations.center_acceleration",
              lambda: _accelerations(("a_0x", "a_0y"))),
    Statement("ex-6-5 (i)", "acceleration of C from that of 0", "dynamics.kinematics", _relative,
              print_is="a_C = a_0 + ω × (ω × r_0C) + ω' × r_0C"),
    Statement("ex-6-5 (j)", "the bar's half and its rotation", "dynamics.kinematics", _vectors),
    Statement("ex-6-5 (k)", "acceleration of C as a vector", "Equations.center_acceleration",
              lambda: _accelerations(("a_Cx", "a_Cy"))),
    Statement("ex-6-5 (l)", "acceleration of C by components", "Equations.center_acceleration",
              lambda: _accelerations(("a_Cx", "a_Cy"))),
    Statement("ex-6-5 (m)", "the equations of motion", "fb.equations(s).motion", _motion),
)  # fmt: skip
