"""The same laws in exact symbols: every difference is zero, not small."""

from __future__ import annotations

import pytest

import freebody as fb
from freebody.dynamics import (
    bias,
    coordinate_rates,
    forward_dynamics,
    inverse_dynamics,
    jacobian,
    kinetic_energy,
    mass_matrix,
    mechanical_power,
    momentum,
    polynomial_state,
    poses,
    potential_energy,
    reactions,
)
from freebody.dynamics.kinematics import angular_velocity, point_position, point_velocity
from freebody.scalar.algebra import add, apply, apply_transpose, cross, scale
from freebody.scalar.polynomial import Ring
from freebody.testing import random_system

# bodies of each random machine: as many as keep the file under ten seconds
MACHINES = [(1, 2), (2, 2), (3, 1), (4, 3), (5, 2), (7, 3), (8, 3), (9, 2)]
UNDRIVEN = [
    ("hinge", "slider"),
    ("universal",),
    ("cylindrical",),
    ("screw", "hinge"),
    ("planar",),
    ("gimbal",),
    ("ball",),
]


class Machine:
    def __init__(self, system):
        self.system = system
        self.model = fb.assemble(system)
        self.ring = Ring()
        self.state = polynomial_state(self.model, self.ring)
        self.udot = tuple(self.ring.generator(s.acceleration, "acceleration") for s in self.model.speeds)

    def rate(self, x):
        """dx/dt along any motion, by the chain rule."""
        rates = dict(
            zip(
                (c.symbol for c in self.model.coordinates),
                coordinate_rates(self.model, self.state),
                strict=True,
            )
        )
        rates.update(zip((s.symbol for s in self.model.speeds), self.udot, strict=True))
        return self.ring.total_derivative(x, rates)


@pytest.fixture(params=MACHINES, ids=str)
def machine(request):
    seed, bodies = request.param
    return Machine(random_system(seed, bodies, small=True, driven=True))


@pytest.fixture(params=UNDRIVEN, ids="-".join)
def free_machine(request):
    kinds = request.param
    bodies = 1 if kinds in [("ball",), ("gimbal",)] else 2
    return Machine(random_system(3, bodies, kinds, small=True))


def zero(x):
    """Whether x is zero; where the inverse of a rope's length stands in it, after multiplication by that length.

    The relations of an inverse of a sum of sines of several angles may be too many to complete
    (scalar/relations.LIMITS): only for these is a zero not always recognised as it stands.
    """
    while x != 0:
        inverses = [g for g in x.ring.used(x) if g.kind == "inverse"]
        if not inverses:
            return False
        x = without(x, inverses[-1])
    return True


def without(x, g):
    """x times the power of p that its inverse generator g = 1/p has in x."""
    powers = {}
    for monomial, coefficient in x.terms():
        term, n = coefficient, 0
        for i, exponent in monomial:
            if i == g.index:
                n = exponent
            else:
                term = term * x.ring.variable(i) ** exponent
        powers[n] = powers.get(n, 0) + term
    (p,) = g.arguments
    return sum((y * p ** (max(powers) - n) for n, y in powers.items()), start=0)


def test_kinetic_energy_is_half_u_M_u(free_machine):
    m = free_machine
    M = mass_matrix(m.model, m.state)
    total = sum((a * M[i][j] * b for i, a in enumerate(m.state.u) for j, b in enumerate(m.state.u)), start=0)
    assert zero(2 * kinetic_energy(m.model, m.state) - total)


def test_composite_mass_matrix_is_the_slope_of_inverse_dynamics(machine):
    m = machine
    M = mass_matrix(m.model, m.state)
    left = inverse_dynamics(m.model, m.state, m.udot)
    for i, speed in enumerate(m.model.speeds):
        for j in range(m.model.n_u):
            assert zero(M[i][j] - M[j][i])
            assert zero(m.ring.derivative(left[j], speed.acceleration) - M[j][i])


def test_energy_changes_by_power_on_any_motion(machine):
    """dE/dt = power of loads and drives + u · (M u' + h - Q): whatever u' is."""
    m = machine
    energy = kinetic_energy(m.model, m.state) + potential_energy(m.model, m.state)
    power = mechanical_power(m.model, m.state, m.udot)
    for speed, lack in zip(m.state.u, inverse_dynamics(m.model, m.state, m.udot), strict=True):
        power = power + speed * lack
    assert zero(m.rate(energy) - power)


def test_velocities_are_rates_of_positions_and_turns(machine):
    m = machine
    for body in m.system.bodies.values():
        point = body.point(1, -2, 1)
        p, v = point_position(m.model, m.state, point), point_velocity(m.model, m.state, point)
        assert all(zero(m.rate(a) - b) for a, b in zip(p, v, strict=True))
        R, w = poses(m.model, m.state)[body.name].rotation, angular_velocity(m.model, m.state, body)
        for k in range(3):
            column = tuple(row[k] for row in R)
            turned = cross(w, column)
            assert all(zero(m.rate(a) - b) for a, b in zip(column, turned, strict=True))


def test_jacobian_is_the_slope_of_velocity(machine):
    m = machine
    body = list(m.system.bodies.values())[-1]
    point = body.point(1, 0, 2)
    moving = (*angular_velocity(m.model, m.state, body), *point_velocity(m.model, m.state, point))
    J = jacobian(m.model, m.state, point)
    for row, value in zip(J, moving, strict=True):
        for entry, speed in zip(row, m.model.speeds, strict=True):
            assert zero(m.ring.derivative(value, speed.symbol) - entry)


def test_translation_theorem(machine):
    m = machine
    for name, body in m.system.bodies.items():
        mass = body.mass_properties
        r, v = (f(m.model, m.state, body.center) for f in (point_position, point_velocity))
        R, w = poses(m.model, m.state)[name].rotation, angular_velocity(m.model, m.state, body)
        H_C = apply(R, apply(mass.inertia, apply_transpose(R, w)))
        H_0 = add(cross(r, scale(mass.mass, v)), H_C)
        about_0, about_C = (momentum(m.model, m.state, a, {name}) for a in ((0, 0, 0), r))
        assert all(zero(a - b) for a, b in zip(about_0.angular, H_0, strict=True))
        assert all(zero(a - b) for a, b in zip(about_C.angular, H_C, strict=True))
        assert all(zero(a - mass.mass * b) for a, b in zip(about_0.linear, v, strict=True))


def test_motion_of_small_machines_in_closed_form():
    """Articulated bodies with divisions by polynomials: M u' + h - Q = 0 exactly."""
    for seed, kinds in [(1, ["slider", "hinge"]), (2, ["hinge"]), (5, ["screw", "slider"])]:
        m = Machine(random_system(seed, 2, kinds, loads=False, small=True))
        udot = forward_dynamics(m.model, m.state)
        assert all(zero(x) for x in inverse_dynamics(m.model, m.state, udot))
        M, h = mass_matrix(m.model, m.state), bias(m.model, m.state)
        for row, rest in zip(M, h, strict=True):
            assert zero(sum((a * b for a, b in zip(row, udot, strict=True)), start=rest))


def test_momentum_of_the_whole_changes_by_ground_reactions_and_weight():
    """Ball, weld and driven joints leave nothing out: exact for any u'."""
    s = fb.System("arm on a driven shaft")
    omega, m, g = s.parameters(omega=3, m=2, g=9.81)
    s.gravity = (0, 0, -g)
    shaft = s.body("shaft", fb.cylinder(m, 1, 2))
    arm = s.body("arm", fb.box(m, (1, 2, 3)))
    s.hinge("bearing", s.ground, shaft, coordinate=omega * s.t**2)
    s.weld("bolt", shaft, arm, at=(1, 0, 0))
    machine = Machine(s)
    R, M = reactions(machine.model, machine.state, ())["bearing"]
    total = momentum(machine.model, machine.state)
    weight = (0, 0, -2 * machine.state(m * g))
    arm_C = point_position(machine.model, machine.state, arm.center)
    moment = add(M, cross(arm_C, machine.state.vector((0, 0, -m * g))))
    assert all(zero(machine.rate(a) - b) for a, b in zip(total.linear, add(R, weight), strict=True))
    assert all(zero(machine.rate(a) - b) for a, b in zip(total.angular, moment, strict=True))
    assert not zero(M[2])  # the moment that drives the shaft


def test_the_ground_frame_may_stand_anywhere_in_symbols():
    """A pendulum seen from a ground turned by beta and shifted by (a, b, c): the same equations, cancelled exactly."""

    def pendulum(tilted):
        s = fb.System("pendulum")
        m, L, g, beta, a, b, c = s.parameters("m L g beta a b c")
        sine, cosine = s.expression("sin(beta)"), s.expression("cos(beta)")
        bob = s.body("bob", fb.slender_bar(m, L, axis="y"))
        if tilted:
            s.gravity = (g * sine, -g * cosine, 0)
            frame = ((cosine, -sine, 0), (sine, cosine, 0), (0, 0, 1))
            s.hinge(
                "pin", s.ground, bob, at=(a, b, c), to=(0, L / 2, 0), parent_axes=frame, coordinate="theta"
            )
        else:
            s.gravity = (0, -g, 0)
            s.hinge("pin", s.ground, bob, to=(0, L / 2, 0), coordinate="theta")
        return Machine(s)

    here, there = pendulum(False), pendulum(True)
    (x,), (y,) = (inverse_dynamics(m.model, m.state, m.udot) for m in (here, there))
    assert here.ring.to_sympy(x) == there.ring.to_sympy(y)
    T, U = (kinetic_energy(m.model, m.state) for m in (here, there))
    assert here.ring.to_sympy(T) == there.ring.to_sympy(U)
