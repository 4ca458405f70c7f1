"""Examples 6.1-6.4: the lettered equations, from models whose contact forces are named loads."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy
from sympy import cos, pi, sin, sqrt

import freebody as fb

from ..gallery.textbook.examples.ex_6_2_hinged_bar import build as hinged_bar
from ..gallery.tools.case import mass_properties
from . import machines
from .meaning import Meaning
from .momentum import resolved
from .small import put
from .statement import Statement

t = machines.t
SENSE = sympy.Symbol("sense")
"""+1 where friction acts backwards on the disk, -1 where it acts forwards."""


def planar_rows(machine: machines.Machine, body: str, pairs: Any) -> list[tuple[Any, Any]]:
    """Return (sum of the loads, rate of momentum) of two force equations and the moment equation, in a position."""
    rows = machine.free_body(body).planar_equations
    return [(put(row.lhs, pairs), put(row.rhs, pairs)) for row in rows]


# --- Example 6.1 ---------------------------------------------------------------------------------------------------


@cache
def sliding() -> tuple[Meaning, list[Any], dict[str, Any]]:
    """Return (meaning, rows that are zero, atoms) of the body on two feet; every force on it is a load."""
    s = fb.System("sliding body")
    m, L, H, D, mu, beta, F, g = s.parameters(m=50, L=1.2, H=0.8, D=0.15, mu=0.25, beta=0.35, F=200, g=9.81)
    N_A, N_B = s.parameters(N_A=1, N_B=1)
    s.gravity = (0, -g, 0)
    body = s.body("body", fb.box(m, (L, H, D)))
    s.planar("plane", s.ground, body, coordinate="x y theta")
    s.force("F", body.point(-L / 2, H / 2, 0), (F * cos(beta), F * sin(beta), 0))
    for name, N, side in (("A", N_A, -1), ("B", N_B, 1)):
        s.force(f"foot_{name}", body.point(side * L / 2, -(H / 2 + D), 0), (-mu * N, N, 0))
    machine = machines.Machine(s)
    a = machine.atoms
    # it translates along x: it neither turns nor rises
    rows = planar_rows(machine, "body", [(a["theta"].diff(t, 2), 0), (a["y"].diff(t, 2), 0), (a["theta"], 0)])
    sums = resolved("F_x F_y M_Cz", [left for left, _ in rows])
    zero = [left - right for left, right in rows]
    acceleration = a["x"].diff(t, 2)
    names = {**machine.names, **sums, "a_Cx": acceleration}
    return Meaning(names, along=machines.solved(zero, [acceleration, N_A, N_B])), zero, a


def _tipping() -> Meaning:
    """F from the rows with N_A = 0: the vertical balance gives N_B, the balance of moments gives F."""
    meaning, rows, a = sliding()
    _, vertical, moment = (put(row, [(a["N_A"], 0)]) for row in rows)
    (pair,) = machines.solved([vertical], [a["N_B"]])
    ((_, solution),) = machines.solved([sympy.expand(put(moment, [pair]))], [a["F"]])
    return Meaning({**meaning.names, "F": solution})


# --- Example 6.2 ---------------------------------------------------------------------------------------------------


@cache
def bar() -> Meaning:
    """The hinged bar just after its release and in the vertical position, by the library's equations and energy."""
    machine = machines.Machine(hinged_bar())
    a = machine.atoms
    theta, m, L = a["theta"], a["m"], a["L"]
    ((_, alpha),) = machine.along()
    release = [(a["theta'"], 0), (theta, 0)]
    alpha = put(alpha, release)
    at_release = [(theta.diff(t, 2), alpha), *release]
    force = put(machine.equations.reactions["pin"].force[1], at_release)
    weight = machine.free_body("bar", about=machine.system.ground.origin).moments["weight"][2]
    rows = machine.free_body("bar").equations
    own = mass_properties(machine.body("bar"))
    V = machine.potential - put(machine.potential, [(theta, 0)])
    I_0 = own.about((-L / 6, 0, 0))[2][2]
    w = sympy.Symbol("omega_2")
    T = machine.kinetic
    V_2 = put(V, [(theta, -pi / 2)])
    T_2 = put(T, [(a["theta'"], w), (theta, -pi / 2)])
    x = sympy.Symbol("x", real=True)
    names = {
        **machine.names, "x": x, "M_0": put(weight, release), "I_0": I_0, "α": alpha, "R": force,
        "F_y": put(rows[1].rhs, at_release), "a_Cy": put(machine.acceleration(machine.point("bar", 0, 0, 0))[1],
        at_release),
        "E": put(T + V, release), "T_1": put(T, release), "V_1": put(V, release), "V_2": V_2, "T_2": T_2, "ω_2": w,
    }  # fmt: skip

    def along_the_bar(inside: Any) -> Any:
        return sympy.integrate(inside({"x": x}), (x, -L / 3, 2 * L / 3)) * m / L

    return Meaning(names, along_the_bar)


def _energy_of_bar() -> Meaning:
    machine = machines.Machine(hinged_bar())
    T, V = machine.kinetic, machine.potential
    energy = sympy.sympify(machine.equations.integrals["energy"].expression)
    return Meaning({"E": energy, "T": T, "V": V}, along=machine.along())


def _vertical() -> Meaning:
    """ω_2 from T_2 + V_2 = 0, clockwise."""
    names = bar().names
    w = names["ω_2"]
    L, g = sympy.symbols("L g", positive=True)
    square = sympy.cancel(-names["V_2"] / sympy.cancel(names["T_2"] / w**2)).subs(
        {names["L"]: L, names["g"]: g}
    )
    return Meaning({"ω_2": -sqrt(square), "L": L, "g": g})


# --- Example 6.3 ---------------------------------------------------------------------------------------------------


@cache
def pulled() -> tuple[Meaning, list[Any]]:
    """Return (meaning, rows that are zero) of the disk; every force on it is a load."""
    s = fb.System("pulled disk")
    m, R, h, mu, F, H, V, W = s.parameters(m=10, R=0.3, h=0.4, mu=0.2, F=30, H=1, V=98, W=98)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, coordinate="x y theta")
    # a point at height h - R above C along the ground's axes: it is a point of the body at θ = 0
    s.force("F", disk.point(0, h - R, 0), (F, 0, 0))
    s.force("floor", disk.point(0, -R, 0), (-H, V, 0))
    s.force("weight", disk.origin, (0, -W, 0))
    machine = machines.Machine(s)
    a = machine.atoms
    alpha, acceleration = sympy.symbols("alpha a_Cx")
    pairs = [
        (a["theta"].diff(t, 2), alpha),
        (a["x"].diff(t, 2), acceleration),
        (a["y"].diff(t, 2), 0),
        (a["theta"], 0),
    ]
    rows = planar_rows(machine, "disk", pairs)
    sums = resolved("F_x F_y M_C", [left for left, _ in rows])
    own = {"α": alpha, "a_Cx": acceleration, "I_C": mass_properties(machine.body("disk")).inertia[2][2]}
    zero = [left - right for left, right in rows]
    meaning = Meaning({**machine.names, **sums, **own}, along=machines.solved(zero, [acceleration, alpha, V]))
    return meaning, zero


def _no_slip() -> Any:
    """Velocity of the lowest point of the disk, in the rates; in rolling, it and its rate stay zero."""
    machine = machines.carried_disk()
    a, names = machine.atoms, pulled()[0].names
    speed = machine.velocity(machine.point("disk", 0, -a["R"], 0))[0]
    return put(
        speed, [(a["x'"], names["a_Cx"]), (a["theta'"], names["α"]), (a["theta"], 0), (a["R"], names["R"])]
    )


@cache
def solved(slip: bool) -> Meaning:
    """Accelerations, friction and normal force of the floor from the rows and the condition of the case: all linear."""
    meaning, rows = pulled()
    n = meaning.names
    extra = n["H"] - SENSE * n["μ"] * n["V"] if slip else _no_slip()
    solution = machines.solved([*rows, extra], [n["a_Cx"], n["α"], n["H"], n["V"]])
    return Meaning({**n, **resolved("a_Cx α H V", [sympy.cancel(x) for _, x in solution])})


def _limit() -> Meaning:
    """Friction suffices if |H| < μ V: μ V - H > 0 if it acts backwards, μ V + H > 0 if it acts forwards."""
    n = solved(False).names
    return Meaning({**n, "W": n["W"]}, positive=n["μ"] * n["V"] - SENSE * n["H"])


# --- Example 6.4 ---------------------------------------------------------------------------------------------------


@cache
def rolling() -> Meaning:
    """A disk that rolls down an incline: T after a drop H in v_2 and ω_2, related by rolling without slip."""
    machine = machines.carried_disk()
    a = machine.atoms
    v, w = sympy.symbols("v_2 omega_2")
    H = sympy.Symbol("H", positive=True)
    T = put(machine.kinetic, [(a["x'"], v), (a["y'"], 0), (a["theta'"], w)])
    V = put(machine.potential, [(a["y"], -H)]) - put(machine.potential, [(a["y"], 0)])
    low = machine.velocity(machine.point("disk", 0, -a["R"], 0))[0]
    still = machines.solved([put(low, [(a["x'"], v), (a["theta'"], w), (a["theta"], 0)])], [w])
    I_C = mass_properties(machine.body("disk")).inertia[2][2]
    return Meaning({**machine.names, "T_2": T, "V_2": V, "v_2": v, "ω_2": w, "H": H, "I_C": I_C}, along=still)


def _drop() -> Meaning:
    """The same with the speed that follows from the conserved energy."""
    n, still = rolling().names, rolling().along
    g = sympy.Symbol("g", positive=True)
    T = sympy.cancel(put(n["T_2"], still) / n["v_2"] ** 2)
    speed = sqrt(sympy.cancel(-n["V_2"] / T).subs(n["g"], g))
    names = {**n, "E": n["T_2"] + n["V_2"], "v_2": n["v_2"], "g": n["g"]}
    return Meaning(names, along=[*still, (n["v_2"], speed.subs(g, n["g"]))])


def _speed() -> Meaning:
    n, still = rolling().names, rolling().along
    g = sympy.Symbol("g", positive=True)
    T = sympy.cancel(put(n["T_2"], still) / n["v_2"] ** 2)
    return Meaning({**n, "g": g, "v_2": sqrt(sympy.cancel(-n["V_2"] / T).subs(n["g"], g))})


def _backwards() -> list[tuple[Any, Any]]:
    """2 h = 3 R/(1 + p) with p > 0."""
    n = pulled()[0].names
    p = sympy.Symbol("p", positive=True)
    return [(SENSE, 1), (n["h"], 3 * n["R"] / (2 * (1 + p)))]


FREE = "fb.equations(s).free_body(...).planar_equations"
ENERGY = "fb.equations(s).energy"
LOW = ("friction acts backwards: 2 h < 3 R", _backwards)
FORWARDS = ("friction acts backwards: the lowest point slips forwards", lambda: [(SENSE, 1)])


def _sliding() -> Meaning:
    return sliding()[0]


def _pulled() -> Meaning:
    return pulled()[0]


def _rolls() -> Meaning:
    return solved(False)


def _slips() -> Meaning:
    return solved(True)


STATEMENTS = (
    Statement("ex-6-1 (a)", "sliding body: force equation along x", FREE,
              "F_x = F cos β - μ (N_A + N_B) = m a_Cx", _sliding),
    Statement("ex-6-1 (b)", "sliding body: force equation along y", FREE, "F_y = F sin β + N_A + N_B - m g = 0",
              _sliding),
    Statement("ex-6-1 (c)", "sliding body: moment equation about C", FREE,
              "M_Cz = -F cos β H/2 + (N_B - N_A - F sin β) L/2 - μ (N_A + N_B) (D + H/2) = 0", _sliding),
    Statement("ex-6-1 (d)", "the force at which the rear foot lifts", FREE + ", solved at N_A = 0",
              "F = m g (L - 2 μ D - μ H)/(H cos β + (2 L - 2 μ D - μ H) sin β)", _tipping),
    Statement("ex-6-2 (a)", "hinged bar: moment about the hinge just after release",
              "fb.equations(s).free_body('bar', about=0).moments; .motion; MassProperties.about(point)",
              "M_0 = -1/6 L m g = I_0 α", bar),
    Statement("ex-6-2 (b)", "hinged bar: moment of inertia about the hinge", "fb.slender_bar(m, L).about(point)",
              "I_0 = ∫ x^2 dm = m/L int(x^2, -L/3, 2 L/3) = m/L 1/3 between(x^3, -L/3, 2 L/3) = 1/9 m L^2", bar),
    Statement("ex-6-2 (c)", "hinged bar: angular acceleration just after release", "fb.equations(s).motion",
              "α = -3/2 g/L", bar),
    Statement("ex-6-2 (d)", "hinged bar: vertical force equation just after release",
              "fb.equations(s).free_body('bar').equations, .reactions['pin'], .center_acceleration('bar')",
              "F_y = R - m g = m a_Cy = m 1/6 L α = m 1/6 L (-3/2 g/L) = -1/4 m g", bar),
    Statement("ex-6-2 (e)", "hinged bar: reaction just after release", "fb.equations(s).reactions['pin']",
              "R = 3/4 m g", bar),
    Statement("ex-6-2 (f)", "hinged bar: the energy is conserved", "fb.equations(s).integrals['energy'], .energy",
              "E = T + V = const", _energy_of_bar),
    Statement("ex-6-2 (g)", "hinged bar: the energy at the start", ENERGY, "E = T_1 + V_1 = 0", bar),
    Statement("ex-6-2 (h)", "hinged bar: potential energy in the vertical position", ENERGY + ".potential",
              "V_2 = -1/6 L m g", bar),
    Statement("ex-6-2 (i)", "hinged bar: kinetic energy in the vertical position", ENERGY + ".kinetic",
              "T_2 = 1/2 I_0 ω_2^2 = 1/2 1/3 m L^2 ω_2^2", bar),
    Statement("ex-6-2 (j)", "hinged bar: angular velocity in the vertical position", ENERGY,
              "ω_2 = -(3 g/L)^(1/2)", _vertical),
    Statement("ex-6-3 (a)", "pulled disk: two force equations and a moment equation", FREE,
              ("F_x = F - H = m a_Cx", "F_y = V - W = 0", "M_C = -F (h - R) - H R = I_C α"), _pulled),
    Statement("ex-6-3 (b)", "rolling without slip: accelerations are tied",
              FREE + ", solved with dynamics.kinematics.point_velocity of the lowest point", "a_Cx = -α R", _rolls),
    Statement("ex-6-3 (c)", "pulled disk, no slip: acceleration of C", FREE + ", solved",
              "a_Cx = F R h/(I_C + m R^2) = 2 F h/(3 m R)", _rolls),
    Statement("ex-6-3 (d)", "pulled disk, no slip: angular acceleration", FREE + ", solved", "α = -2 F h/(3 m R^2)",
              _rolls),
    Statement("ex-6-3 (e)", "pulled disk, no slip: friction force", FREE + ", solved",
              "H = F - m a_Cx = F (1 - 2 h/(3 R))", _rolls),
    Statement("ex-6-3 (f)", "the largest force without slip", FREE + ", solved for |H| < mu V",
              "F < μ W/(1 - 2 h/(3 R))", _limit, condition=LOW),
    Statement("ex-6-3 (g)", "friction as the disk slips", FREE + ", solved", "H = μ W", _slips, condition=FORWARDS),
    Statement("ex-6-3 (h)", "pulled disk that slips: acceleration of C", FREE + ", solved",
              "a_Cx = (F - μ W)/m", _slips, condition=FORWARDS),
    Statement("ex-6-3 (i)", "pulled disk that slips: angular acceleration", FREE + ", solved",
              "α = -2 [F (h - R) + μ W R]/(m R^2)", _slips, condition=FORWARDS),
    Statement("ex-6-4 (a)", "rolling disk: kinetic energy", ENERGY + ".kinetic",
              "T_2 = 1/2 m v_2^2 + 1/2 I_C ω_2^2", lambda: Meaning(rolling().names)),
    Statement("ex-6-4 (b)", "rolling disk: kinetic energy in the speed of C",
              ENERGY + ".kinetic; dynamics.kinematics.point_velocity of the lowest point", "T_2 = 3/4 m v_2^2",
              rolling),
    Statement("ex-6-4 (c)", "rolling disk: the energy is conserved", ENERGY,
              "E = T_2 + V_2 = -m g H + 3/4 m v_2^2 = 0", _drop),
    Statement("ex-6-4 (d)", "rolling disk: speed after the drop", ENERGY, "v_2 = (4 g H/3)^(1/2)", _speed),
)  # fmt: skip
