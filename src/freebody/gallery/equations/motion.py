"""Sections 6.3 and 6.4: the equations of motion, (6.20)-(6.30), and the kinetic energy, (6.31)-(6.37)."""

from __future__ import annotations

from typing import Any

import sympy

import freebody as fb

from ..case import mass_properties
from . import machines
from .momentum import flight, lines, omega, triple, vector
from .statement import Line, Statement, balance, value

t = machines.t
MOMENT = [sympy.Symbol(f"M_0{c}") for c in "xyz"]


def _newton() -> list[Line]:
    s, e = machines.flying()
    a = s.names.atoms
    rows = []
    body = e.free_body("body")
    force = vector([a[f"F_{c}"] for c in "xyz"])
    acceleration = sympy.Matrix([e.sympy(x) for x in e.center_acceleration("body")])
    m = a["m_1"] + a["m_2"]
    for k in range(3):
        left, right = body.equations[k].lhs, body.equations[k].rhs
        rows.append(balance(force[k], m * acceleration[k], (left, right)))
    return rows


def _rate_by_angles() -> tuple[Any, Any, Any, Any]:
    """Of the body by Euler's angles: H_0 in ground axes, its derivative, ω and H_0 in body axes."""
    s, e = machines.angles()
    H = sympy.Matrix(e.momentum.angular())
    free = e.free_body("body", frame="body")
    return s, e, H, free


def _moment_is_rate() -> list[Line]:
    _, e, H, _ = _rate_by_angles()
    rows = e.free_body("body").equations[3:]
    return [value(n, h, row.rhs) for n, h, row in zip(MOMENT, H.diff(t), rows, strict=True)]


def _units() -> list[Line]:
    """Unit vectors of a body, seen from the ground: their places differentiated, against ω × them."""
    from ...dynamics.kinematics import angular_velocity, point_position

    s, e = machines.angles()
    body = s.bodies["body"]
    show = lambda v: sympy.Matrix([e.sympy(x) for x in v])  # noqa: E731
    w = show(angular_velocity(e.model, e.state, body))
    rows = []
    for name, c in zip("ijk", ((1, 0, 0), (0, 1, 0), (0, 0, 1)), strict=True):
        u = show(point_position(e.model, e.state, body.point(*c)))
        symbols = [sympy.Symbol(f"d{name}_{axis}") for axis in "XYZ"]
        rows += [value(n, p, d) for n, p, d in zip(symbols, w.cross(u), u.diff(t), strict=True)]
    return rows


def _h_by_components() -> list[Line]:
    """H_0 along the body axes, put together from its components there."""
    _, H, units = _body_components()
    whole = sum((h * u for h, u in zip(H, units, strict=True)), sympy.zeros(3, 1))
    _, e = machines.angles()
    return lines([f for f in sympy.symbols("H_0X H_0Y H_0Z")], whole, e.momentum.angular())


def _body_components() -> tuple[Any, Any, list[Any]]:
    """(ω, H_0) along the body axes, and these axes in the ground."""
    from ...dynamics.kinematics import angular_velocity, point_position

    s, e = machines.angles()
    body = s.bodies["body"]
    show = lambda v: sympy.Matrix([e.sympy(x) for x in v])  # noqa: E731
    units = [
        show(point_position(e.model, e.state, body.point(*c))) for c in ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    ]
    w_ground = show(angular_velocity(e.model, e.state, body))
    w = sympy.Matrix([w_ground.dot(u) for u in units])
    names = s.names.atoms
    J = sympy.Matrix(
        3, 3, lambda i, j: (1 if i == j else -1) * names[f"I_{''.join(sorted('xyz'[i] + 'xyz'[j]))}"]
    )
    return w, J * w, units


def _rate_in_body_axes() -> list[Line]:
    """d/dt of H_0 in the ground = components' rates along the body axes + ω × H_0."""
    w, H, units = _body_components()
    inner = H.diff(t) + w.cross(H)
    whole = sum((h * u for h, u in zip(inner, units, strict=True)), sympy.zeros(3, 1))
    _, e = machines.angles()
    rate = sympy.Matrix(e.momentum.angular()).diff(t)
    return lines(sympy.symbols("dH_0X dH_0Y dH_0Z"), whole, rate)


def _put(expression: Any) -> Any:
    """Speeds of the ball joint as the chapter's ω_x, ω_y, ω_z."""
    w = [sympy.Function(f"omega_w{c}")(t) for c in "xyz"]
    mine = [sympy.Function(f"omega_{c}")(t) for c in "xyz"]
    return (
        sympy.sympify(expression)
        .subs(dict(zip([x.diff(t) for x in w], [x.diff(t) for x in mine], strict=True)))
        .subs(dict(zip(w, mine, strict=True)))
    )


def _derived_moments() -> list[tuple[Any, Any]]:
    s, e = machines.turning()
    free = e.free_body("body", frame="body")
    return [(row.lhs, _put(row.rhs)) for row in free.equations[3:]]


def _inertia(s: fb.System) -> dict[str, Any]:
    return {k: v for k, v in s.names.atoms.items() if k.startswith("I_")}


def _moment_vector() -> list[Line]:
    s, _ = machines.turning()
    I = _inertia(s)  # noqa: E741
    w = sympy.Matrix([sympy.Function(f"omega_{c}")(t) for c in "xyz"])
    J = sympy.Matrix(
        3, 3, lambda i, j: (1 if i == j else -1) * I[f"I_{''.join(sorted('xyz'[i] + 'xyz'[j]))}"]
    )
    printed = J * w.diff(t) + w.cross(J * w)
    return [balance(m, p, d) for m, p, d in zip(_moment_symbols(s), printed, _derived_moments(), strict=True)]


def _moment_symbols(s: fb.System) -> list[Any]:
    return [s.names.atoms[f"M_0{c}"] for c in "xyz"]


def _moment_components() -> list[Line]:
    s, e = machines.turning()
    applied = e.free_body("body", frame="body").equations[3:]
    return [value(sympy.Symbol(f"M_0{c}"), m, row.lhs) for c, m, row in
            zip("xyz", _moment_symbols(s), applied, strict=True)]  # fmt: skip


def _moment_equations() -> list[Line]:
    s, _ = machines.turning()
    a = s.names.atoms
    xx, yy, zz, xy, xz, yz = (a[f"I_{k}"] for k in ("xx", "yy", "zz", "xy", "xz", "yz"))
    x, y, z = (sympy.Function(f"omega_{c}")(t) for c in "xyz")
    dx, dy, dz = x.diff(t), y.diff(t), z.diff(t)
    printed = [
        xx * dx - xy * dy - xz * dz - xz * x * y + xy * x * z + (zz - yy) * y * z - yz * (y**2 - z**2),
        -xy * dx + yy * dy - yz * dz + yz * x * y + (xx - zz) * x * z - xy * y * z - xz * (z**2 - x**2),
        -xz * dx - yz * dy + zz * dz + (yy - xx) * x * y - yz * x * z + xz * y * z - xy * (x**2 - y**2),
    ]
    return [balance(m, p, d) for m, p, d in zip(_moment_symbols(s), printed, _derived_moments(), strict=True)]


def _about_centre() -> list[Line]:
    """The free cloud: moments about C of the force at one particle, against the rate of H_C in its axes."""
    s, e = machines.flying()
    free = e.free_body("body", frame="body")
    body = s.bodies["body"]
    names = [sympy.Symbol(f"M_C{c}") for c in "xyz"]
    J = sympy.Matrix(mass_properties(body).inertia)
    w = sympy.Matrix([sympy.Function(f"flight_w{c}")(t) for c in "xyz"])
    printed = J * w.diff(t) + w.cross(J * w)
    return [value(n, p, row.rhs) for n, p, row in zip(names, printed, free.equations[3:], strict=True)]


def _principal() -> list[Line]:
    """Principal axes turned by an angle and back: along them, and along them only, the products are zero."""
    moments = sympy.symbols("I_1 I_2 I_3", positive=True)
    angle = sympy.Symbol("beta", real=True)
    c, d = sympy.cos(angle), sympy.sin(angle)
    turn = sympy.Matrix([[1, 0, 0], [0, c, -d], [0, d, c]])
    own = fb.MassProperties(1, (0, 0, 0), ((moments[0], 0, 0), (0, moments[1], 0), (0, 0, moments[2])))
    turned = own.rotated(turn.tolist())
    back = turned.rotated(turn.T.tolist())
    rows = [value(sympy.Symbol(f"I_{c}{c}"), moments[i], back.inertia[i][i]) for i, c in enumerate("xyz")]
    zero = sympy.Integer(0)
    return rows + [value(sympy.Symbol(f"I_{k}"), zero, getattr(back.products, k)) for k in ("xy", "xz", "yz")]


def euler_symbols() -> tuple[list[Any], list[Any], list[Any]]:
    """(moments of inertia, ω_1, ω_2, ω_3, moments) of the body in principal axes."""
    s, _ = machines.spinning()
    a = s.names.atoms
    return (
        [a[f"I_{i}"] for i in "123"],
        [sympy.Function(f"omega_{i}")(t) for i in "123"],
        [a[f"M_{i}"] for i in "123"],
    )


def euler_derived() -> list[tuple[Any, Any]]:
    """The moment equations of that body about its mass centre, in body axes."""
    _, e = machines.spinning()
    put = dict(zip("xyz", "123", strict=True))

    def renamed(x: Any) -> Any:
        w = {sympy.Function(f"omega_w{c}")(t): sympy.Function(f"omega_{k}")(t) for c, k in put.items()}
        first = sympy.sympify(x).subs({a.diff(t): b.diff(t) for a, b in w.items()})
        return first.subs(w)

    return [(row.lhs, renamed(row.rhs)) for row in e.free_body("body", frame="body").equations[3:]]


def _euler() -> list[Line]:
    I, w, M = euler_symbols()  # noqa: E741
    printed = [
        I[0] * w[0].diff(t) + (I[2] - I[1]) * w[1] * w[2],
        I[1] * w[1].diff(t) + (I[0] - I[2]) * w[0] * w[2],
        I[2] * w[2].diff(t) + (I[1] - I[0]) * w[0] * w[1],
    ]
    return [balance(m, p, d) for m, p, d in zip(M, printed, euler_derived(), strict=True)]


# --- kinetic energy ---------------------------------------------------------------------------------------------

T, T_tr, T_rot = sympy.symbols("T T_tr T_rot")


def _energy() -> Any:
    _, e = machines.flying()
    return machines.upright(sympy.sympify(e.energy.kinetic), "flight")


def _parts() -> tuple[Any, Any, Any]:
    """(translation, cross term, rotation)."""
    f = flight()
    m = sum(f["m"])
    spin = [f["omega"].cross(rho) for rho in f["rho"]]
    whole = sum((k * rho for k, rho in zip(f["m"], f["rho"], strict=True)), sympy.zeros(3, 1))
    return (
        m * f["v_C"].dot(f["v_C"]) / 2,
        f["v_C"].dot(f["omega"].cross(whole)),
        sum(k * v.dot(v) for k, v in zip(f["m"], spin, strict=True)) / 2,
    )


def _rotation_energy() -> Any:
    """By the library: kinetic energy of the cloud less that of its mass at C."""
    return _energy() - _parts()[0]


def _by_components() -> list[Line]:
    f = flight()
    mass = mass_properties(machines.flying()[0].bodies["body"])
    J, P = mass.inertia, mass.products
    x, y, z = f["omega"]
    squares = sum(
        m * ((y * r[2] - z * r[1]) ** 2 + (z * r[0] - x * r[2]) ** 2 + (x * r[1] - y * r[0]) ** 2)
        for m, r in zip(f["m"], f["rho"], strict=True)
    )
    printed = (
        J[0][0] * x**2
        + J[1][1] * y**2
        + J[2][2] * z**2
        - 2 * P.xy * x * y
        - 2 * P.xz * x * z
        - 2 * P.yz * y * z
    )
    return [value(T_rot, squares / 2, _rotation_energy()), value(T_rot, printed / 2, _rotation_energy())]


def _spin_velocity() -> list[Line]:
    from ...scalar.algebra import cross

    x, y, z = sympy.symbols("x y z", real=True)
    wx, wy, wz = omega
    printed = [wy * z - wz * y, wz * x - wx * z, wx * y - wy * x]
    return lines(triple("v"), printed, cross(tuple(omega), (x, y, z)))


def _principal_energy() -> list[Line]:
    _, e = machines.spinning()
    I, _, _ = euler_symbols()  # noqa: E741
    w = [sympy.Function(f"omega_w{c}")(t) for c in "xyz"]
    return [value(T_rot, sum(a * b**2 for a, b in zip(I, w, strict=True)) / 2, e.energy.kinetic)]


STATEMENTS = (
    Statement("6.20", "the force is the rate of the linear momentum", "fb.equations(s).free_body('body').equations",
              _newton, print_is="F = dp/dt = m a_C"),
    Statement("6.21", "the moment about a fixed point is the rate of the angular momentum",
              "fb.equations(s).free_body('body').equations", _moment_is_rate, print_is="M_0 = dH_0/dt"),
    Statement("6.22", "unit vectors of axes that turn", "dynamics.kinematics.point_position, differentiated", _units,
              print_is="di/dt = ω × i, dj/dt = ω × j, dk/dt = ω × k"),
    Statement("6.23", "components of the angular momentum along body axes", "fb.equations(s).momentum.angular()",
              _h_by_components, defines=True, print_is="H_0 = H_0x i + H_0y j + H_0z k"),
    Statement("6.24", "rate of a vector that is given in axes that turn", "fb.equations(s).momentum.angular()",
              _rate_in_body_axes, print_is="dH_0/dt = H'_0 + ω × H_0"),
    Statement("6.25", "the moment equation in body axes", "fb.equations(s).free_body('body', frame='body').equations",
              _moment_vector, print_is="M_0 = H'_0 + ω × H_0"),
    Statement("6.26", "components of the moment along body axes",
              "fb.equations(s).free_body('body', frame='body').moments", _moment_components, defines=True,
              print_is="M_0 = M_0x i + M_0y j + M_0z k"),
    Statement("6.27", "the moment equations in body axes that need not be principal",
              "fb.equations(s).free_body('body', frame='body').equations; fb.forms.moment_equations()",
              _moment_equations),
    Statement("6.28", "the moment equation about the mass centre", "fb.equations(s).free_body('body', frame='body')",
              _about_centre, print_is="M_C = dH_C/dt = H'_C + ω × H_C"),
    Statement("6.29", "principal axes: no products of inertia", "MassProperties.principal(), .rotated(R)",
              _principal, defines=True),
    Statement("6.30", "Euler's moment equations", "fb.equations(s).free_body('body', frame='body').equations; "
              "fb.forms.euler_equations()", _euler),
    Statement("6.31", "the kinetic energy is the sum over all elements of mass", "fb.equations(s).energy.kinetic",
              lambda: [value(T, sum(m * v.dot(v) for m, v in zip(flight()["m"], flight()["v"], strict=True)) / 2,
                             _energy())], defines=True, print_is="T = 1/2 ∫ v·v dm"),
    Statement("6.32", "the kinetic energy in three parts", "fb.equations(s).energy.kinetic",
              lambda: [value(T, sum(_parts()), _energy())],
              print_is="T = 1/2 m v_C·v_C + v_C·(ω × ∫ρ dm) + 1/2 ∫ (ω × ρ)·(ω × ρ) dm"),
    Statement("6.33", "kinetic energy of translation and of rotation", "fb.equations(s).energy.kinetic",
              lambda: [value(T, _parts()[0] + _parts()[2], _energy())], print_is="T = T_tr + T_rot"),
    Statement("6.34a", "the kinetic energy of translation", "fb.equations(s).energy.kinetic",
              lambda: [value(T_tr, _parts()[0], _energy() - _parts()[2])], defines=True,
              print_is="T_tr = 1/2 m v_C·v_C"),
    Statement("6.34b", "the kinetic energy of rotation about the mass centre", "fb.equations(s).energy.kinetic",
              lambda: [value(T_rot, _parts()[2], _rotation_energy())], defines=True,
              print_is="T_rot = 1/2 ∫ (ω × ρ)·(ω × ρ) dm"),
    Statement("6.35", "the velocity from rotation, by components", "scalar.algebra.cross", _spin_velocity),
    Statement("6.36", "the kinetic energy of rotation by components", "fb.equations(s).energy.kinetic", _by_components),
    Statement("6.37", "the kinetic energy of rotation in principal axes", "fb.equations(s).energy.kinetic",
              _principal_energy),
)  # fmt: skip
