"""Derivatives of all products against differences, against each other and against mechanics; threads; constraints."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics.motion import transmitting
from freebody.errors import ModelError
from freebody.program.products import PRODUCTS, product_named
from freebody.testing import random_state, random_system

T = 0.3


def machine():
    s = random_system(3, bodies=3, joints=("ball", "hinge", "slider", "free"))
    m, k = s.parameters(m=0.7, k=1.3)
    s.spring("pull", s.ground.point(1, 2, 3), s.bodies["b2"].point(0, 1, "m"), stiffness=k, rest="m*k")
    s.force("push", s.bodies["b1"].point(1, 0, 0), ("k*t**2", 0, 1))
    return s


@pytest.fixture(scope="module")
def program():
    return fb.compile(machine())


def inputs(program, name):
    model = program.model
    q, u = random_state(model, 4)
    rng = np.random.default_rng(1)
    given = {"q": np.array(q), "u": np.array(u), "udot": rng.normal(size=model.n_u)}
    given["forces"] = rng.normal(size=model.n_u)
    return {x: given[x] for x in product_named(model, name).inputs}


def value(program, name, given, t=T, **named):
    kernel, c = program.kernel(name), program.constants(name, named)
    return kernel(t, np.concatenate(list(given.values())), c)


@pytest.mark.parametrize("name", [name for name in PRODUCTS if name not in ("derivatives", "conditions")])
def test_against_differences(program, name):
    against_differences(program, name)


def test_conditions_against_differences():
    """The product that only machines with constraints have."""
    s = machine()
    s.ball("loop", s.ground, s.bodies["b2"], at=(1, 0, "k"), to=(0, "m*k", 0))
    first, second = fb.assemble(s).speed_names[-2:]
    s.constrain_speed(f"{first} - {second}*sin(k*t)")
    program = fb.compile(s)
    assert program.kernel("conditions").outputs == 4 * (program.model.n_u + 1)
    against_differences(program, "conditions")


def against_differences(program, name):
    """Central differences: error h² f'''/6 + ε f/h, at most 1e-7 of the largest entry for h = 1e-5."""
    given, h = inputs(program, name), 1e-5

    def check(found, difference, scale):
        assert np.abs(found.ravel() - difference.ravel()).max() <= 1e-6 * scale

    for by in (*given, "t", "k"):
        function = program.derivative(name, by)
        found = np.asarray(function(*given.values(), T))
        columns = []
        if by in given:
            for j in range(len(given[by])):
                two = []
                for sign in (1, -1):
                    moved = {x: v.copy() for x, v in given.items()}
                    moved[by][j] += sign * h
                    two.append(value(program, name, moved))
                columns.append((two[0] - two[1]) / (2 * h))
        elif by == "t":
            columns.append(
                (value(program, name, given, T + h) - value(program, name, given, T - h)) / (2 * h)
            )
        else:
            columns.append(
                (value(program, name, given, k=1.3 + h) - value(program, name, given, k=1.3 - h)) / (2 * h)
            )
        difference = np.stack(columns, axis=-1)
        assert found.shape == product_named(program.model, f"{name}_by_{by}").shape(program.model)
        scale = max(1.0, np.abs(difference).max(), np.abs(value(program, name, given)).max())
        check(found, difference, scale)


def test_displacement_is_the_coordinate_rates(program):
    """∂f/∂q G u = ∂f/∂q q', for all u."""
    model = program.model
    given = inputs(program, "forward_dynamics")
    q, u = given.values()
    by_q = program.derivative("mass_matrix", "q")(q, T)
    by_turn = program.derivative("mass_matrix", "displacement")(q, T)
    assert by_turn.shape == (model.n_u, model.n_u, model.n_u)
    rates = program.coordinate_rates(q, u, T)
    assert by_turn @ u == pytest.approx(by_q @ rates, rel=1e-12, abs=1e-12)


def test_power_balance(program):
    """∂T/∂u = M u; momentum and velocities are linear in u."""
    given = inputs(program, "kinetic_energy")
    q, u = given.values()
    assert program.derivative("kinetic_energy", "u")(q, u, T) == pytest.approx(
        program.mass_matrix(q, T) @ u, rel=1e-11, abs=1e-11
    )
    p = program.momentum(q, u, T)
    J = program.derivative("momentum", "u")(q, u, T)
    assert J @ u == pytest.approx(np.concatenate([p.linear, p.angular]), rel=1e-11, abs=1e-11)
    v = program.velocities(q, u, T)["b1"]
    assert program.jacobian("b1", q, T) @ u == pytest.approx(np.concatenate([v.angular, v.linear]), abs=1e-11)


def test_forces_and_accelerations_are_inverse(program):
    """∂u'/∂τ = M⁻¹, ∂τ/∂u' = M."""
    given = inputs(program, "forced_dynamics")
    M = program.mass_matrix(given["q"], T)
    by_forces = program.derivative("forced_dynamics", "forces")(*given.values(), T)
    assert by_forces @ M == pytest.approx(np.eye(len(M)), abs=1e-10)
    given = inputs(program, "inverse_dynamics")
    assert program.derivative("inverse_dynamics", "udot")(*given.values(), T) == pytest.approx(M, abs=1e-11)


def test_jacobian_of_a_point(program):
    tip = machine().bodies["b2"].point(0.1, 0.2, 0.3)
    q = inputs(program, "mass_matrix")["q"]
    function, h = program.derivative("jacobian", "q", point=tip), 1e-5
    found = function(q)
    for j in range(len(q)):
        e = np.zeros(len(q))
        e[j] = h
        difference = (program.jacobian(tip, q + e) - program.jacobian(tip, q - e)) / (2 * h)
        assert found[..., j] == pytest.approx(difference, abs=1e-7)


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_give_the_same_bits(threads):
    s = machine()
    one, many = fb.compile(s), fb.compile(s, threads=threads)
    random = np.random.default_rng(0)
    N = 5003
    q, u = random.normal(size=(N, one.model.n_q)), random.normal(size=(N, one.model.n_u))
    t, k = random.uniform(size=N), random.uniform(1, 2, N)
    assert np.array_equal(one.forward_dynamics(q, u, t, k=k), many.forward_dynamics(q, u, t, k=k))
    assert np.array_equal(one.bias(q, u), many.bias(q, u))
    by = one.derivative("forward_dynamics", "q")(q, u, t, k=k)
    assert np.array_equal(by, many.derivative("forward_dynamics", "q")(q, u, t, k=k))
    assert np.array_equal(by[7], one.derivative("forward_dynamics", "q")(q[7], u[7], t[7], k=k[7]))
    with pytest.raises(ModelError, match="Expected threads to be a whole number of at least 1, got 0"):
        fb.compile(s, threads=0)


def crank():
    """A slider-crank in a plane: the closing joint has redundant conditions."""
    s = fb.System("crank")
    s.gravity = (0, -9.81, 0)
    crank, rod = (
        s.body("crank", fb.slender_bar(1.0, 1.0, axis="x")),
        s.body("rod", fb.slender_bar(2.0, 2.0, axis="x")),
    )
    piston = s.body("piston", fb.particle(0.5))
    s.hinge("A", s.ground, crank, to=(-0.5, 0, 0), axis="z", coordinate="a")
    s.hinge("B", crank, rod, at=(0.5, 0, 0), to=(-1, 0, 0), axis="z", coordinate="b")
    s.slider("guide", s.ground, piston, axis="x", coordinate="x")
    s.hinge("C", rod, piston, at=(1, 0, 0), axis="z")
    return s


def test_constraints_need_a_configuration():
    model = fb.assemble(crank())
    with pytest.raises(
        ModelError, match=r"has constraints \(C\).*fb.compile\(s, at=\[...\]\), in the order of a, b, x"
    ):
        fb.compile(model).forward_dynamics([0, 0, 3], [0, 0, 0])
    with pytest.raises(ModelError, match=r"Expected at= of shape \(3,\)"):
        fb.compile(model, at=[0.0])
    a = 0.4
    b = -np.arcsin(np.sin(a) / 2) - a
    q = [a, b, np.cos(a) + 2 * np.cos(a + b)]
    program = fb.compile(model, at=q)
    rates = np.array([1.0, -np.cos(a) / (2 * np.cos(a + b)) - 1, 0])
    rates[2] = -np.sin(a) * rates[0] - 2 * np.sin(a + b) * (rates[0] + rates[1])
    udot = program.forward_dynamics(q, rates)
    rough = fb.compile(model, at=[0.4, -0.6, 2.8])
    assert rough.forward_dynamics(q, rates) == pytest.approx(udot, abs=1e-12)
    with pytest.raises(ModelError, match="cannot be met near"):
        held = crank()
        held.hinge("D", held.ground, held.bodies["piston"], at=(9, 9, 0), axis="z")
        fb.compile(held, at=q)
    # the loop stays closed: x = cos a + 2 cos(a + b), differentiated twice
    c, d = a + b, rates[0] + rates[1]
    expected = -np.cos(a) * rates[0] ** 2 - np.sin(a) * udot[0]
    expected -= 2 * np.cos(c) * d**2 + 2 * np.sin(c) * (udot[0] + udot[1])
    assert udot[2] == pytest.approx(expected, abs=1e-12)
    # Newton for the piston
    assert tuple(name for name, *_ in transmitting(model)) == ("A", "B", "guide", "C")
    force = program.reactions(q, rates)["C"].force + program.reactions(q, rates)["guide"].force
    assert force == pytest.approx([0.5 * udot[2], 0.5 * 9.81, 0], abs=1e-11)
    forced = program.forward_dynamics(q, rates, forces=[0, 0, 0])
    assert forced == pytest.approx(udot, abs=1e-12)


WRONG = [
    (lambda p: p.derivative("forward", "q"), "Unknown product 'forward'"),
    (
        lambda p: p.derivative("bias", "w"),
        "Expected a derivative by one of q, u, displacement, t, parameters, m, k, got 'w'",
    ),
    (lambda p: p.derivative("mass_matrix", "u"), "got 'u'"),
    (lambda p: p.derivative("mass_matrix", 3), "got '3'"),
    (lambda p: p.derivative("jacobian", "q"), "Expected point="),
    (lambda p: p.derivative("bias", "q", point="b1"), "Expected point="),
    (
        lambda p: p.derivative("bias", "q")([0.0]),
        "Expected q, u and, if it matters, t for the derivative of 'bias', got 1",
    ),
]


@pytest.mark.parametrize(("call", "message"), WRONG)
def test_wrong_requests(program, call, message):
    with pytest.raises(ModelError, match=message):
        call(program)
