"""Section 6.2: linear and angular momentum, (6.1)-(6.19)."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy

import freebody as fb

from ...dynamics.kinematics import angular_velocity, point_position, point_velocity
from ...scalar.algebra import cross
from ..case import mass_properties
from . import machines
from .statement import Line, Statement, identity, value

X, Y, Z = "xyz"
omega = sympy.Matrix(sympy.symbols("omega_x omega_y omega_z", real=True))
H = [sympy.Symbol(f"H_0{c}") for c in "xyz"]


def vector(v: Any) -> Any:
    """A triple as a SymPy column."""
    return sympy.Matrix(list(v))


def lines(names: Any, printed: Any, derived: Any) -> list[Line]:
    """A line per component."""
    return [value(n, a, b) for n, a, b in zip(names, printed, derived, strict=True)]


def triple(name: str) -> list[Any]:
    return [sympy.Symbol(f"{name}_{c}") for c in "xyz"]


def _momentum_of_cloud() -> Any:
    """About 0, by the library's inertia of the cloud."""
    mass, _ = machines.cloud()
    return fb.forms.angular_momentum(mass.about((0, 0, 0)), tuple(omega))


def _h0_by_velocity() -> list[Line]:
    s, e = _ball()
    points = [s.bodies["body"].point(*r) for _, r in machines.cloud()[1]]
    total = sympy.zeros(3, 1)
    for (m, _), p in zip(machines.cloud()[1], points, strict=True):
        r = _in_ground(e, point_position(e.model, e.state, p))
        v = _in_ground(e, point_velocity(e.model, e.state, p))
        total += m * vector(cross(tuple(r), tuple(v)))
    return lines(H, total, _at(e.momentum.angular()))


@cache
def _ball() -> tuple[fb.System, Any]:
    """The cloud about the fixed point 0."""
    s = fb.System("cloud about a fixed point")
    _, parts = machines.cloud()
    s.parameters(**{str(symbol): 1 for m, r in parts for symbol in (m, *r)})
    mass, _ = machines.cloud()
    own = {symbol: s.names.atoms[str(symbol)] for m, r in parts for symbol in (m, *r)}
    body = s.body("body", mass.at(own))
    s.ball("pivot", s.ground, body, coordinate="omega")
    return s, fb.equations(s)


_BACK = {f"omega_w{c}": omega[i] for i, c in enumerate("xyz")}


def _at(v: Any) -> Any:
    """A column of the ball's model at the instant when body axes and ground axes agree, in the chapter's symbols."""
    put = {sympy.Function(k)(machines.t): w for k, w in _BACK.items()}
    result = machines.upright(sympy.Matrix(v)).subs(put)
    plain = {str(x): x for m, r in machines.cloud()[1] for x in (m, *r)}
    return result.subs({x: plain[str(x)] for x in result.free_symbols if str(x) in plain})


def _in_ground(e: Any, v: Any) -> Any:
    return _at(sympy.Matrix([e.sympy(x) for x in v]))


def _velocity() -> list[Line]:
    s, e = _ball()
    r = machines.cloud()[1][0][1]
    v = _in_ground(e, point_velocity(e.model, e.state, s.bodies["body"].point(*r)))
    return lines(triple("v"), vector(cross(tuple(omega), tuple(r))), v)


def _triple_product() -> list[Line]:
    A, B, C = (vector(sympy.symbols(" ".join(f"{n}_{c}" for c in "xyz"))) for n in "ABC")
    left = vector(cross(tuple(A), cross(tuple(B), tuple(C))))
    return [
        Line(sympy.Eq(a, b, evaluate=False), a - b, sympy.Eq(a, a, evaluate=False))
        for a, b in zip(left, A.dot(C) * B - A.dot(B) * C, strict=True)
    ]


def _components() -> list[Line]:
    r = vector(sympy.symbols("x y z", real=True))
    x, y, z = r
    R = sympy.Symbol("r", positive=True)
    wx, wy, wz = omega
    printed = [
        (R**2 - x**2) * wx - x * y * wy - x * z * wz,
        -x * y * wx + (R**2 - y**2) * wy - y * z * wz,
        -x * z * wx - y * z * wy + (R**2 - z**2) * wz,
    ]
    derived = vector(cross(tuple(r), cross(tuple(omega), tuple(r))))
    return [
        value(n, p.subs(R**2, r.dot(r)), d) for n, p, d in zip(triple("h"), printed, derived, strict=True)
    ]


def _h0() -> list[Line]:
    xx, yy, zz, xy, xz, yz = sympy.symbols("I_xx I_yy I_zz I_xy I_xz I_yz", real=True)
    wx, wy, wz = omega
    printed = [xx * wx - xy * wy - xz * wz, -xy * wx + yy * wy - yz * wz, -xz * wx - yz * wy + zz * wz]
    _, e = machines.turning()
    derived = machines.upright(e.momentum.angular())
    put = {sympy.Function(f"omega_w{c}")(machines.t): omega[i] for i, c in enumerate("xyz")}
    real = {x: sympy.Symbol(str(x), real=True) for x in derived.free_symbols if str(x).startswith("I_")}
    return lines(H, printed, derived.subs(put).subs(real))


def _moments() -> list[Line]:
    mass, _ = machines.cloud()
    J = mass.about((0, 0, 0))
    return [
        value(sympy.Symbol(f"I_{c}{c}"), machines.over(lambda r, i=i: r.dot(r) - r[i] ** 2), J[i][i])
        for i, c in enumerate("xyz")
    ]


def _products() -> list[Line]:
    mass, _ = machines.cloud()
    found = mass.products_about((0, 0, 0))
    J = mass.about((0, 0, 0))
    pairs = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    result = []
    for name, (i, j) in pairs.items():
        printed = machines.over(lambda r, i=i, j=j: r[i] * r[j])
        result.append(value(sympy.Symbol(f"I_{name}"), printed, getattr(found, name)))
        result.append(value(sympy.Symbol(f"I_{name[::-1]}"), printed, -J[j][i]))
    return result


# --- the free body: every quantity at the instant at which its axes lie along the ground's --------------------------


def _free(v: Any) -> Any:
    """A column of the flying cloud at that instant, in its own symbols."""
    _, e = machines.flying()
    column = sympy.Matrix([e.sympy(x) for x in v]) if not isinstance(v, sympy.MatrixBase) else sympy.Matrix(v)
    return machines.upright(column, "flight")


def _flight() -> dict[str, Any]:
    """Positions and velocities of the free cloud by the library: of each particle, of C, and ω."""
    s, e = machines.flying()
    body = s.bodies["body"]
    a = s.names.atoms
    parts = [(a[f"m_{i}"], body.point(*(a[f"{c}_{i}"] for c in "xyz"))) for i in (1, 2)]
    C = body.point(*mass_properties(body).center)
    place = lambda p: _free(point_position(e.model, e.state, p))  # noqa: E731
    speed = lambda p: _free(point_velocity(e.model, e.state, p))  # noqa: E731
    return {
        "m": [m for m, _ in parts],
        "r": [place(p) for _, p in parts],
        "v": [speed(p) for _, p in parts],
        "r_C": place(C),
        "v_C": speed(C),
        "omega": _free(angular_velocity(e.model, e.state, body)),
        "p": _free(e.momentum.linear),
        "H_0": _free(e.momentum.angular()),
        "H_C": _free(e.momentum.angular(C)),
    }


@cache
def flight() -> dict[str, Any]:
    """The same, worked out once; with ρ = r - r_C of each particle."""
    f = _flight()
    f["rho"] = [r - f["r_C"] for r in f["r"]]
    return f


def _sum(f: dict[str, Any], function: Any) -> Any:
    total = None
    for i, m in enumerate(f["m"]):
        term = m * function(i)
        total = term if total is None else total + term
    return total


def _velocity_of_element() -> list[Line]:
    f = flight()
    return lines(triple("v"), f["v_C"] + f["omega"].cross(f["rho"][0]), f["v"][0])


def _position_of_element() -> list[Line]:
    f = flight()
    own = vector([sympy.Symbol(f"rho_{c}") for c in "xyz"])
    known = dict(zip(own, f["rho"][0], strict=True))
    return lines(triple("r"), f["r_C"] + own.subs(known), f["r"][0])


def _centre() -> list[Line]:
    f = flight()
    return lines(triple("r_C"), _sum(f, lambda i: f["r"][i]) / sum(f["m"]), f["r_C"])


def _centre_of_rho() -> list[Line]:
    f = flight()
    return [identity(x, sympy.Integer(0)) for x in _sum(f, lambda i: f["rho"][i])]


def _expansion() -> list[Line]:
    f = flight()
    m, v, w, r = sum(f["m"]), f["v_C"], f["omega"], f["r_C"]
    whole = _sum(f, lambda i: f["rho"][i])
    printed = (
        r.cross(v) * m
        + whole.cross(v)
        + r.cross(w.cross(whole))
        + _sum(f, lambda i: f["rho"][i].cross(w.cross(f["rho"][i])))
    )
    return lines(H, printed, f["H_0"])


def _linear() -> list[Line]:
    f = flight()
    return lines(triple("p"), sum(f["m"]) * f["v_C"], f["p"])


def _about_centre() -> list[Line]:
    f = flight()
    apparent = _sum(f, lambda i: f["rho"][i].cross(f["omega"].cross(f["rho"][i])))
    actual = _sum(f, lambda i: f["rho"][i].cross(f["v"][i]))
    names = [sympy.Symbol(f"H_C{c}") for c in "xyz"]
    return lines(names, apparent, f["H_C"]) + lines(names, actual, f["H_C"])


def _translation() -> list[Line]:
    f = flight()
    return lines(H, f["r_C"].cross(f["p"]) + f["H_C"], f["H_0"])


def _unit_components(letter: str) -> Any:
    """A vector is the sum of its components times the unit vectors of the axes."""

    def work() -> list[Line]:
        from ...scalar.algebra import IDENTITY, apply

        v = (
            sympy.symbols(" ".join(f"{letter}_{c}" for c in "xyz"))
            if letter != "r"
            else sympy.symbols("x y z")
        )
        units = [vector(row) for row in IDENTITY]
        printed = sum((a * u for a, u in zip(v, units, strict=True)), sympy.zeros(3, 1))
        return lines(triple(letter), printed, apply(IDENTITY, tuple(v)))

    return work


STATEMENTS = (
    Statement("6.1", "the angular momentum about 0 is the moment of the momenta of all elements of mass",
              "fb.equations(s).momentum.angular()", _h0_by_velocity, defines=True, print_is="H_0 = ∫ r × v dm"),
    Statement("6.2", "velocity of a point of a body that turns about 0",
              "dynamics.kinematics.point_velocity of a body on a ball joint", _velocity, print_is="v = ω × r"),
    Statement("6.3", "the angular momentum about 0 in the angular velocity",
              "fb.forms.angular_momentum(inertia, omega)",
              lambda: lines(H, machines.over(lambda r: r.cross(omega.cross(r))), _momentum_of_cloud()),
              print_is="H_0 = ∫ r × (ω × r) dm"),
    Statement("6.4", "the vector product of a vector and a vector product", "scalar.algebra.cross", _triple_product,
              print_is="A × (B × C) = (A·C) B - (A·B) C"),
    Statement("6.5", "the same with the double product worked out", "fb.forms.angular_momentum(inertia, omega)",
              lambda: lines(H, machines.over(lambda r: r.dot(r) * omega - r.dot(omega) * r), _momentum_of_cloud()),
              print_is="H_0 = ∫ [(r·r) ω - (r·ω) r] dm"),
    Statement("6.6", "components of r along the body axes", "components are triples in a named frame",
              _unit_components("r"), defines=True, print_is="r = x i + y j + z k"),
    Statement("6.7", "components of ω along the body axes", "components are triples in a named frame",
              _unit_components("omega"), defines=True, print_is="ω = ω_x i + ω_y j + ω_z k"),
    Statement("6.8", "the integrand by components", "scalar.algebra.cross", _components,
              print_is="(r·r) ω - (r·ω) r by components, r² = x² + y² + z²"),
    Statement("6.9", "the angular momentum by components",
              "fb.equations(s).momentum.angular() of a body on a ball joint", _h0),
    Statement("6.10", "moments of inertia about the body axes", "MassProperties.about((0, 0, 0))", _moments,
              defines=True, print_is="I_xx = ∫ (r² - x²) dm, ..."),
    Statement("6.11", "products of inertia, and minus the entries of the matrix",
              "MassProperties.products_about((0, 0, 0))", _products, defines=True,
              print_is="I_xy = I_yx = ∫ x y dm, ..."),
    Statement("6.12", "velocity of a point of a body that moves and turns",
              "dynamics.kinematics.point_velocity of a free body", _velocity_of_element, print_is="v = v_C + ω × ρ"),
    Statement("6.13", "position of an element of mass from the mass centre", "dynamics.kinematics.point_position",
              _position_of_element, defines=True, print_is="r = r_C + ρ"),
    Statement("6.14", "the mass centre", "MassProperties.center", _centre, defines=True, print_is="r_C = (1/m) ∫ r dm"),
    Statement("6.15", "the mass centre, seen from itself", "MassProperties.center", _centre_of_rho,
              print_is="∫ ρ dm = 0"),
    Statement("6.16", "the angular momentum about 0 of a body that moves and turns, in four parts",
              "fb.equations(s).momentum.angular()", _expansion,
              print_is="H_0 = m r_C × v_C + (∫ρ dm) × v_C + r_C × (ω × ∫ρ dm) + ∫ ρ × (ω × ρ) dm"),
    Statement("6.17", "the linear momentum", "fb.equations(s).momentum.linear", _linear, print_is="p = m v_C"),
    Statement("6.18", "the angular momentum about C: apparent and actual are the same",
              "fb.equations(s).momentum.angular(C)", _about_centre, print_is="H_C = H'_C = ∫ ρ × (ω × ρ) dm"),
    Statement("6.19", "the translation theorem of the angular momentum", "fb.equations(s).momentum.angular()",
              _translation, print_is="H_0 = r_C × p + H_C"),
)  # fmt: skip
