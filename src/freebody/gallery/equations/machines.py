"""The machines that the chapter's equations are derived from, each made once."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy

import freebody as fb

t = sympy.Symbol("t")


def names(system: fb.System) -> dict[str, Any]:
    """The SymPy atoms of a system by name."""
    return system.names.atoms


@cache
def cloud() -> tuple[fb.MassProperties, tuple[Any, ...]]:
    """Two particles at any places, and (mass, place) of each.

    The moments of a body are sums over its elements of mass; what holds for any two particles, whatever their
    masses, holds for each element on its own, and so for the sum.
    """
    parts = tuple(
        (sympy.Symbol(f"m_{i}", positive=True), sympy.Matrix(sympy.symbols(f"x_{i} y_{i} z_{i}", real=True)))
        for i in (1, 2)
    )
    mass = None
    for m, r in parts:
        one = fb.particle(m).moved(tuple(r))
        mass = one if mass is None else mass + one
    assert mass is not None
    return mass, parts


def over(function: Any) -> Any:
    """∫ f(r) dm of the cloud: the sum over its particles."""
    _, parts = cloud()
    terms = [m * function(r) for m, r in parts]
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total


@cache
def turning() -> tuple[fb.System, Any]:
    """A body with any inertia that turns about a fixed point, moments M_0 in body axes."""
    s = fb.System("body about a fixed point")
    m = s.parameters(m=1)
    entries = s.parameters(I_xx=2, I_yy=3, I_zz=4, I_xy="1/10", I_xz="1/5", I_yz="3/10")
    xx, yy, zz, xy, xz, yz = entries
    body = s.body("body", fb.MassProperties(m, (0, 0, 0), ((xx, -xy, -xz), (-xy, yy, -yz), (-xz, -yz, zz))))
    s.ball("pivot", s.ground, body, coordinate="omega")
    s.torque("M_0", body, s.parameters(M_0x=0, M_0y=0, M_0z=0), frame=body)
    return s, fb.equations(s)


def upright(expression: Any, joint: str = "omega") -> Any:
    """At the instant at which the body axes lie along the ground's: the unit quaternion."""
    quaternion = {sympy.Function(f"{joint}_e{i}")(t): int(i == 0) for i in range(4)}
    return expression.subs(quaternion)


@cache
def angles() -> tuple[fb.System, Any]:
    """The same body by Euler's angles, whose rates are speeds: so that SymPy alone can differentiate."""
    s = fb.System("body by Euler angles")
    m = s.parameters(m=1)
    xx, yy, zz, xy, xz, yz = s.parameters(I_xx=2, I_yy=3, I_zz=4, I_xy="1/10", I_xz="1/5", I_yz="3/10")
    body = s.body("body", fb.MassProperties(m, (0, 0, 0), ((xx, -xy, -xz), (-xy, yy, -yz), (-xz, -yz, zz))))
    s.gimbal("pivot", s.ground, body, axis="ZXZ", coordinate="psi theta phi")
    return s, fb.equations(s)


@cache
def flying() -> tuple[fb.System, Any]:
    """The cloud as a free body: it moves and turns."""
    s = fb.System("free body")
    m_1, m_2 = s.parameters(m_1=1, m_2=2)
    places = [s.parameters(**{f"{c}_{i}": 1 for c in "xyz"}) for i in (1, 2)]
    body = s.body("body", fb.particle(m_1).moved(places[0]) + fb.particle(m_2).moved(places[1]))
    s.free("flight", s.ground, body)
    s.force("F", body.point(*places[0]), s.parameters(F_x=0, F_y=0, F_z=0))
    return s, fb.equations(s)


@cache
def lamina() -> tuple[fb.System, Any]:
    """A body that moves in the plane xy, with a force and a couple."""
    s = fb.System("lamina")
    m, I_C, F_x, F_y, M_Cz = s.parameters(m=1, I_C=1, F_x=0, F_y=0, M_Cz=0)
    body = s.body("lamina", fb.MassProperties(m, (0, 0, 0), ((I_C / 2, 0, 0), (0, I_C / 2, 0), (0, 0, I_C))))
    s.planar("plane", s.ground, body, coordinate="x y theta")
    s.force("F", body.origin, (F_x, F_y, 0))
    s.torque("M", body, (0, 0, M_Cz))
    s.parameters(a=1, b=2)
    return s, fb.equations(s)


@cache
def hinged() -> tuple[fb.System, Any]:
    """A body about a fixed axis z through 0, its mass centre off the axis, with a moment."""
    s = fb.System("hinged lamina")
    m, I_C, e, M_0 = s.parameters(m=1, I_C=1, e=1, M_0=0)
    body = s.body("lamina", fb.MassProperties(m, (e, 0, 0), ((I_C / 2, 0, 0), (0, I_C / 2, 0), (0, 0, I_C))))
    s.hinge("hinge", s.ground, body, coordinate="theta")
    s.torque("M", body, (0, 0, M_0))
    return s, fb.equations(s)


@cache
def shaft() -> tuple[fb.System, Any]:
    """Any body that turns about a fixed axis z through 0; the hinge stands for what holds the axis."""
    s = fb.System("body on a shaft")
    m, T = s.parameters(m=1, T=0)
    xx, yy, zz, xy, xz, yz = s.parameters(I_xx=2, I_yy=3, I_zz=4, I_xy="1/10", I_xz="1/5", I_yz="3/10")
    body = s.body("rotor", fb.MassProperties(m, (0, 0, 0), ((xx, -xy, -xz), (-xy, yy, -yz), (-xz, -yz, zz))))
    s.hinge("shaft", s.ground, body, coordinate="theta")
    s.torque("drive", body, (0, 0, T))
    return s, fb.equations(s)


@cache
def tilted_disk() -> tuple[fb.System, Any]:
    """The disk of section 6.6: its normal is (0, sin β, cos β) in the axes of the shaft."""
    s = fb.System("tilted disk")
    m, R, beta, g = s.parameters(m=20, R="1/5", beta="1/10", g="981/100")
    s.parameters(L="3/5", omega=100)
    s.gravity = (0, -g, 0)
    c, d = sympy.cos(beta), sympy.sin(beta)
    disk = fb.disk(m, R).rotated(((1, 0, 0), (0, c, d), (0, -d, c)))
    s.hinge("shaft", s.ground, s.body("disk", disk), coordinate="theta")
    return s, fb.equations(s)


@cache
def spinning() -> tuple[fb.System, Any]:
    """A symmetric body about its mass centre, principal axes 1, 2, 3, with moments or without."""
    s = fb.System("principal axes")
    m = s.parameters(m=1)
    I_1, I_2, I_3 = s.parameters(I_1=2, I_2=3, I_3=4)
    body = s.body("body", fb.MassProperties(m, (0, 0, 0), ((I_1, 0, 0), (0, I_2, 0), (0, 0, I_3))))
    s.ball("centre", s.ground, body, coordinate="omega")
    s.torque("M", body, s.parameters(M_1=0, M_2=0, M_3=0), frame=body)
    return s, fb.equations(s)


@cache
def gyroscope() -> tuple[fb.System, Any]:
    """The gyroscope with its moments of inertia about the pivot as parameters."""
    s = fb.System("gyroscope")
    m, L, g, A, C = s.parameters(m=1, L="1/10", g="981/100", I_xi="1/50", I_zeta="1/250")
    s.parameters(Omega_zeta=300)
    s.gravity = (0, 0, -g)
    for positive in (m, L, g, A, C):
        s.assume(positive > 0)
    own = A - m * L**2
    rotor = s.body("rotor", fb.MassProperties(m, (0, 0, 0), ((own, 0, 0), (0, own, 0), (0, 0, C))))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -L), axis="ZXZ", coordinate="psi theta phi")
    return s, fb.equations(s)
