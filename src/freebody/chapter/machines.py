"""The machines from which the chapter's equations are derived, each built once, and their quantities.

Rotating bodies hang on three hinges, the first two between massless bodies: every speed is then the rate of a
coordinate.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy

import freebody as fb

from ..describe.description import names_of
from ..dynamics import kinematics
from ..gallery.tools.case import mass_properties
from .notation import greek

t = sympy.Symbol("t")
NONE = fb.MassProperties(0, (0, 0, 0), ((0, 0, 0), (0, 0, 0), (0, 0, 0)))
AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


class Machine:
    """A system with its equations, and columns of ground components by the library's kinematics."""

    def __init__(self, system: fb.System) -> None:
        self.system = system
        self.equations = fb.equations(system)
        self.atoms: dict[str, Any] = dict(names_of(system).atoms)
        self.names = {greek(k): v for k, v in self.atoms.items()}

    def body(self, name: str) -> Any:
        """Return the body of a name."""
        return self.system.bodies[name]

    def point(self, body: str, *place: Any) -> Any:
        """Return the point of a body at a place in its axes."""
        return self.body(body).point(*place)

    def column(self, v: Any) -> Any:
        """Return a vector of the library as a SymPy column."""
        return sympy.Matrix([self.equations.sympy(x) for x in v])

    def place(self, point: Any) -> Any:
        """Position of a point in ground axes."""
        return self.column(kinematics.point_position(self.equations.model, self.equations.state, point))

    def velocity(self, point: Any) -> Any:
        """Velocity of a point in ground axes."""
        return self.column(kinematics.point_velocity(self.equations.model, self.equations.state, point))

    def acceleration(self, point: Any) -> Any:
        """Acceleration of a point in ground axes."""
        e = self.equations
        return self.column(kinematics.point_acceleration(e.model, e.state, point, e.udot))

    def omega(self, body: str) -> Any:
        """Angular velocity of a body in ground axes."""
        return self.column(
            kinematics.angular_velocity(self.equations.model, self.equations.state, self.body(body))
        )

    def units(self, body: str) -> tuple[Any, ...]:
        """Unit vectors of the body's axes."""
        origin = self.place(self.point(body, 0, 0, 0))
        return tuple(self.place(self.point(body, *axis)) - origin for axis in AXES)

    def frame(self, body: str) -> dict[str, Any]:
        """Return the unit vectors by name, and their rates as SymPy differentiates them."""
        units = dict(zip("ijk", self.units(body), strict=True))
        return {**units, **{f"d{name}/dt": u.diff(t) for name, u in units.items()}}

    def free_body(self, body: str, **options: Any) -> Any:
        """Free body of the equations, see :meth:`freebody.Equations.free_body`."""
        return self.equations.free_body(body, **options)

    def balances(self, body: str, **options: Any) -> tuple[Any, Any]:
        """Return (force, moment) that the body's motion requires: the right sides of its free-body equations."""
        rows = [sympy.sympify(row.rhs) for row in self.free_body(body, **options).equations]
        return sympy.Matrix(rows[:3]), sympy.Matrix(rows[3:])

    def momentum(self, about: Any = None) -> Any:
        """Angular momentum of the system about a point."""
        return sympy.Matrix(self.equations.momentum.angular(about))

    @property
    def kinetic(self) -> Any:
        """Kinetic energy."""
        return sympy.sympify(self.equations.energy.kinetic)

    @property
    def potential(self) -> Any:
        """Potential energy."""
        return sympy.sympify(self.equations.energy.potential)

    def along(self) -> list[tuple[Any, Any]]:
        """Return (acceleration, its value by the equations of motion) for every coordinate."""
        rows = [sympy.sympify(row.lhs - row.rhs) for row in self.equations.motion]
        unknowns = [q.diff(t, 2) for q in self.equations.coordinates]
        return solved(rows, unknowns)


def solved(rows: Any, unknowns: Any) -> list[tuple[Any, Any]]:
    """Solve linear rows, each zero, for the unknowns by Cramer's rule, without simplification."""
    matrix = sympy.Matrix([[sympy.diff(row, x) for x in unknowns] for row in rows])
    rest = sympy.Matrix(
        [sympy.sympify(row).xreplace({x: sympy.Integer(0) for x in unknowns}) for row in rows]
    )
    solution = -(matrix.adjugate() * rest) / matrix.det()
    return list(zip(unknowns, solution, strict=True))


def turn(system: fb.System, parent: Any, body: Any, to: Any = (0, 0, 0)) -> None:
    """Join the body to the parent by Euler's angles ψ, θ, φ, with massless bodies between."""
    ring, inner = system.body("ring", NONE), system.body("axes", NONE)
    system.hinge("precession", parent, ring, axis="z", coordinate="psi")
    system.hinge("nutation", ring, inner, axis="x", coordinate="theta")
    system.hinge("spin", inner, body, axis="z", to=to, coordinate="phi")


def _two(system: fb.System) -> tuple[Any, list[tuple[Any, Any]]]:
    """Return (mass properties, (mass, place) of each) of two particles at any places in the body's axes.

    The moments of a body are sums over its elements of mass. An identity that holds for any two particles of any
    masses holds for each element alone, and so for the sum.
    """
    masses = system.parameters(m_1=1, m_2=2)
    places = [system.parameters(**{f"{c}_{i}": 1 for c in "xyz"}) for i in (1, 2)]
    parts = tuple(zip(masses, map(tuple, places), strict=True))
    return _together(parts), list(parts)


@cache
def _together(parts: tuple[tuple[Any, Any], ...]) -> Any:
    """Return both particles as one body; the same symbols give the same result in every system."""
    (m_1, r_1), (m_2, r_2) = parts
    return fb.particle(m_1).moved(r_1) + fb.particle(m_2).moved(r_2)


@cache
def pivoted() -> tuple[Machine, Any, list[tuple[Any, Any]]]:
    """Return (machine, mass properties, (mass, place) of each) of the two particles as a body pivoted at 0."""
    s = fb.System("cloud about a fixed point")
    whole, parts = _two(s)
    turn(s, s.ground, s.body("body", whole))
    return Machine(s), whole, parts


@cache
def flying() -> tuple[Machine, Any, list[tuple[Any, Any]]]:
    """The same as a free body, with a force on the first particle; (a, b, c) is any point of the body."""
    s = fb.System("free body")
    whole, parts = _two(s)
    s.parameters(a=1, b=2, c=3)
    parent = s.ground
    for c in "xyz":
        carriage = s.body(f"slide_{c}", NONE)
        s.slider(c.upper(), parent, carriage, axis=c, coordinate=c.upper())
        parent = carriage
    body = s.body("body", whole)
    turn(s, parent, body)
    s.force("F", body.point(*parts[0][1]), s.parameters(F_x=0, F_y=0, F_z=0))
    return Machine(s), whole, parts


@cache
def centred() -> Machine:
    """The same body turning about its fixed mass centre."""
    s = fb.System("body about its mass centre")
    whole, _ = _two(s)
    turn(s, s.ground, s.body("body", whole), to=whole.center)
    return Machine(s)


@cache
def turning() -> Machine:
    """A body of any inertia that turns about a fixed point, with moments M_0 in body axes."""
    s = fb.System("body about a fixed point")
    body = s.body("body", any_inertia(s))
    turn(s, s.ground, body)
    s.torque("M_0", body, s.parameters(M_0x=0, M_0y=0, M_0z=0), frame=body)
    return Machine(s)


def any_inertia(s: fb.System) -> Any:
    """Return mass properties with any moments and products of inertia about the origin."""
    m = s.parameters(m=1)
    xx, yy, zz, xy, xz, yz = s.parameters(I_xx=2, I_yy=3, I_zz=4, I_xy="1/10", I_xz="1/5", I_yz="3/10")
    return fb.MassProperties(m, (0, 0, 0), ((xx, -xy, -xz), (-xy, yy, -yz), (-xz, -yz, zz)))


@cache
def ball() -> Machine:
    """The same body on a ball joint, whose speeds are the components of ω in body axes."""
    s = fb.System("body on a ball joint")
    body = s.body("body", any_inertia(s))
    s.ball("pivot", s.ground, body, coordinate="omega")
    return Machine(s)


@cache
def carried() -> Machine:
    """A lamina on two slides: it moves in the plane xy and does not turn."""
    s = fb.System("body on two slides")
    m, I_C = s.parameters(m=1, I_C=1)
    carriage = s.body("carriage", NONE)
    body = s.body("lamina", lamina_mass(m, I_C))
    s.slider("x", s.ground, carriage, axis="x", coordinate="x")
    s.slider("y", carriage, body, axis="y", coordinate="y")
    return Machine(s)


def lamina_mass(m: Any, I_C: Any, center: Any = (0, 0, 0)) -> Any:
    """Return the mass properties of a thin body with the moment of inertia I_C about its mass centre."""
    return fb.MassProperties(m, center, ((I_C / 2, 0, 0), (0, I_C / 2, 0), (0, 0, I_C)))


@cache
def lamina() -> Machine:
    """A body that moves in the plane xy under forces at (x_1, y_1) and (x_2, y_2) from C; A is at (a, b)."""
    s = fb.System("lamina")
    body = s.body("lamina", lamina_mass(*s.parameters(m=1, I_C=1)))
    s.planar("plane", s.ground, body, coordinate="x y theta")
    for i in (1, 2):
        x, y, X, Y = s.parameters(**{f"x_{i}": 1, f"y_{i}": 1, f"X_{i}": 0, f"Y_{i}": 0})
        s.force(f"F_{i}", body.point(x, y, 0), (X, Y, 0))
    s.parameters(a=1, b=2)
    return Machine(s)


@cache
def carried_disk() -> Machine:
    """A disk in the plane xy under gravity, free to move and turn."""
    s = fb.System("disk in a plane")
    m, R, g = s.parameters(m=5, R="1/4", g="981/100")
    s.gravity = (0, -g, 0)
    s.planar("plane", s.ground, s.body("disk", fb.disk(m, R)), coordinate="x y theta")
    return Machine(s)


@cache
def hinged() -> Machine:
    """A body that turns about a fixed axis z through 0 under a moment, with its mass centre off the axis."""
    s = fb.System("hinged lamina")
    m, I_C, e, M = s.parameters(m=1, I_C=1, e=1, M=0)
    body = s.body("lamina", lamina_mass(m, I_C, (e, 0, 0)))
    s.hinge("hinge", s.ground, body, coordinate="theta")
    s.torque("M", body, (0, 0, M))
    return Machine(s)


@cache
def shaft() -> Machine:
    """Any body that turns about a fixed axis z through 0; the hinge represents the bearings."""
    s = fb.System("body on a shaft")
    body = s.body("rotor", any_inertia(s))
    s.hinge("shaft", s.ground, body, coordinate="theta")
    s.torque("drive", body, (0, 0, s.parameters(T=0)))
    return Machine(s)


@cache
def tilted_disk() -> Machine:
    """The disk of section 6.6: its normal is (0, sin β, cos β) in the axes of the shaft."""
    s = fb.System("tilted disk")
    m, R, beta, g = s.parameters(m=20, R="1/5", beta="1/10", g="981/100")
    s.parameters(L="3/5", omega=100)
    s.gravity = (0, -g, 0)
    c, d = sympy.cos(beta), sympy.sin(beta)
    disk = fb.disk(m, R).rotated(((1, 0, 0), (0, c, d), (0, -d, c)))
    s.hinge("shaft", s.ground, s.body("disk", disk), coordinate="theta")
    return Machine(s)


@cache
def spinning() -> Machine:
    """A body on a ball joint at its mass centre, with principal axes 1, 2, 3."""
    s = fb.System("principal axes")
    m, I_1, I_2, I_3 = s.parameters(m=1, I_1=2, I_2=3, I_3=4)
    body = s.body("body", fb.MassProperties(m, (0, 0, 0), ((I_1, 0, 0), (0, I_2, 0), (0, 0, I_3))))
    s.ball("centre", s.ground, body, coordinate="omega")
    return Machine(s)


def _gyroscope() -> fb.System:
    """The gyroscope with its moments of inertia about the pivot as parameters; body ``axes`` are ξηζ."""
    s = fb.System("gyroscope")
    m, L, g, A, C = s.parameters(m=1, L="1/10", g="981/100", I_xi="1/50", I_zeta="1/250")
    s.parameters(Omega_zeta=300)
    s.gravity = (0, 0, -g)
    for positive in (m, L, g, A, C):
        s.assume(positive > 0)
    own = A - m * L**2
    turn(
        s,
        s.ground,
        s.body("rotor", fb.MassProperties(m, (0, 0, 0), ((own, 0, 0), (0, own, 0), (0, 0, C)))),
        (0, 0, -L),
    )
    return s


@cache
def gyroscope() -> Machine:
    """The gyroscope of section 6.9."""
    return Machine(_gyroscope())


@cache
def gyroscope_about() -> Machine:
    """The gyroscope with the rate p_0 and the angle angle_0 of a steady precession as parameters."""
    s = _gyroscope()
    s.parameters(p_0=2, angle_0=1)
    return Machine(s)


def centre(machine: Machine, body: str) -> Any:
    """Return the mass centre as a point of the body."""
    return machine.body(body).point(*mass_properties(machine.body(body)).center)
