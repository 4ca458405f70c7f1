"""fb.compile against the same algorithms on floats, one state and batches."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import freebody as fb
from freebody import dynamics
from freebody.describe.description import parameters_of
from freebody.errors import ArgumentError, ExpressionError, FreebodyError, ModelError
from freebody.program.products import products_of
from freebody.program.program import Program


def cart():
    """A cart on a spring with two bars hung from it; one parameter has no default value."""
    s = fb.System("cart")
    M, m, a, g, k = s.parameters(M=2.0, m=1.5, a=0.4, g=9.81, k=30.0)
    b = s.parameters("b")
    s.gravity = (0, -g, 0)
    body = s.body("cart", fb.particle(M))
    bar = s.body("bar", fb.slender_bar(m, 2 * a, axis="y"))
    arm = s.body("arm", fb.box(m / 3, (a, a / 2, a / 5)))
    guide = s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.hinge("pin", body, bar, to=(0, a, 0), axis="z", coordinate="theta")
    s.hinge("elbow", bar, arm, at=(0, -a, 0), to=(0, a / 2, 0), axis=(0, 1, 1), coordinate="phi")
    s.spring("k", guide, stiffness=k)
    s.force("F", arm.point(0, 0, a), (b * s.t, 0, 1))
    return s


def flying():
    """A free body that carries a spinning disk."""
    s = fb.System("flying")
    m, g = s.parameters(m=3.0, g=9.81)
    s.gravity = (0, 0, -g)
    box = s.body("box", fb.box(m, (1, 2, 3)))
    disk = s.body("disk", fb.disk(m / 4, 0.5, axis="z"))
    s.free("free", s.ground, box, coordinate="f")
    s.hinge("spin", box, disk, at=(0.1, 0.2, 0.3), axis=(1, 2, 2), coordinate="psi")
    return s


MACHINES = {"cart": (cart, {"b": 2.5}), "flying": (flying, {})}


@pytest.fixture(scope="module", params=MACHINES)
def machine(request):
    build, values = MACHINES[request.param]
    model = fb.assemble(build())
    return Case(model, values, fb.compile(model))


class Case:
    def __init__(self, model, values, program):
        self.model, self.values, self.program = model, values, program

    def states(self, count=5):
        random = np.random.default_rng(3)
        q = random.uniform(-1, 1, (count, self.model.n_q))
        for i in self.model.quaternions:
            q[:, i : i + 4] /= np.linalg.norm(q[:, i : i + 4], axis=1)[:, None]
        return (
            q,
            random.uniform(-1, 1, (count, self.model.n_u)),
            random.uniform(-1, 1, (count, self.model.n_u)),
        )

    def state(self, q, u, t=0.0, **values):
        return dynamics.float_state(self.model, list(q), list(u), t, {**self.values, **values})


def close(a, b):
    return np.allclose(a, b, rtol=1e-12, atol=1e-12)


def test_one_state(machine):
    model, program, values = machine.model, machine.program, machine.values
    (q, *_), (u, *_), (udot, *_) = machine.states()
    t = 0.7
    s = machine.state(q, u, t)
    found = program.forward_dynamics(q, u, t, **values)
    assert found.shape == (model.n_u,)
    assert close(found, dynamics.forward_dynamics(model, s))
    assert close(program.inverse_dynamics(q, u, udot, t, **values), dynamics.inverse_dynamics(model, s, udot))
    assert close(program.mass_matrix(q, t, **values), dynamics.mass_matrix(model, s))
    assert close(program.bias(q, u, t, **values), dynamics.bias(model, s))
    assert close(program.coordinate_rates(q, u, t, **values), dynamics.coordinate_rates(model, s))
    kinetic = program.kinetic_energy(q, u, t, **values)
    assert isinstance(kinetic, float)
    assert close(kinetic, dynamics.kinetic_energy(model, s))
    assert close(program.potential_energy(q, t, **values), dynamics.potential_energy(model, s))
    for name, posture in dynamics.poses(model, s).items():
        assert close(program.poses(q, t, **values)[name].rotation, posture.rotation)
        assert close(program.poses(q, t, **values)[name].position, posture.position)
    for name, (force, moment) in dynamics.reactions(model, s, udot).items():
        assert close(program.reactions(q, u, udot, t, **values)[name].force, force)
        assert close(program.reactions(q, u, udot, t, **values)[name].moment, moment)
    for name, (force, moment) in dynamics.reactions(model, s, found).items():
        assert close(program.reactions(q, u, t=t, **values)[name].force, force)
        assert close(program.reactions(q, u, t=t, **values)[name].moment, moment)


def test_batch_is_the_states_one_by_one(machine):
    model, program, values = machine.model, machine.program, machine.values
    Q, U, A = machine.states(11)
    T = np.linspace(0, 1, 11)
    for name, arguments in (
        ("forward_dynamics", (Q, U, T)), ("inverse_dynamics", (Q, U, A, T)), ("mass_matrix", (Q, T)),
        ("bias", (Q, U, T)), ("kinetic_energy", (Q, U, T)), ("potential_energy", (Q, T)),
    ):  # fmt: skip
        function = getattr(program, name)
        batch = function(*arguments, **values)
        one = np.array([function(*row, **values) for row in zip(*arguments, strict=True)])
        assert batch.shape == one.shape
        assert np.array_equal(batch, one), name
    forces = program.reactions(Q, U, t=T, **values)
    postures = program.poses(Q, T, **values)
    for i in (0, 10):
        for name in model.joints:
            one = program.reactions(Q[i], U[i], t=T[i], **values)[name]
            assert np.array_equal(forces[name].force[i], one.force)
            assert np.array_equal(forces[name].moment[i], one.moment)
        for name in model.bodies:
            assert np.array_equal(
                postures[name].rotation[i], program.poses(Q[i], T[i], **values)[name].rotation
            )


def test_motion_and_forces_agree(machine):
    """M u' + h = τ for the accelerations under given forces."""
    program, values = machine.program, machine.values
    Q, U, tau = machine.states()
    udot = program.forward_dynamics(Q, U, 0.2, forces=tau, **values)
    M, h = program.mass_matrix(Q, 0.2, **values), program.bias(Q, U, 0.2, **values)
    assert close(np.einsum("nij,nj->ni", M, udot) + h, tau)
    assert close(program.inverse_dynamics(Q, U, udot, 0.2, **values), tau)


def test_derivatives_against_differences(machine):
    model, program, values = machine.model, machine.program, machine.values
    (q, *_), (u, *_), _ = machine.states()
    by_q, by_u = program.derivatives(q, u, 0.3, **values)
    assert by_q.shape == (model.n_u, model.n_q)
    assert by_u.shape == (model.n_u, model.n_u)
    h = 1e-6
    for J, n, moved in ((by_q, model.n_q, 0), (by_u, model.n_u, 1)):
        for j in range(n):
            up, down = [q.copy(), u.copy()], [q.copy(), u.copy()]
            up[moved][j] += h
            down[moved][j] -= h
            f_up, f_down = (program.forward_dynamics(*x, 0.3, **values) for x in (up, down))
            assert J[:, j] == pytest.approx((f_up - f_down) / (2 * h), rel=1e-7, abs=1e-7)


def test_jacobian_gives_the_velocities(machine):
    model, program, values = machine.model, machine.program, machine.values
    (q, *_), (u, *_), _ = machine.states()
    s = machine.state(q, u)
    for name in model.bodies:
        J = program.jacobian(name, q, **values)
        assert J.shape == (6, model.n_u)
        h = 1e-6
        rates = program.coordinate_rates(q, u, **values)
        up, down = (program.poses(q + k * rates, **values)[name].position for k in (h, -h))
        assert (J @ u)[3:] == pytest.approx((up - down) / (2 * h), abs=1e-8)
        body = type("B", (), {"name": name, "is_ground": False})
        assert close((J @ u)[:3], dynamics.kinematics.angular_velocity(model, s, body))


def test_jacobian_of_points_and_bodies():
    s = cart()
    program = fb.compile(s)
    q = [0.1, 0.2, 0.3]
    arm = s.bodies["arm"]
    assert np.array_equal(program.jacobian(arm, q, b=0), program.jacobian("arm", q, b=0))
    assert np.array_equal(program.jacobian(arm.origin, q, b=0), program.jacobian("arm", q, b=0))
    tip = program.jacobian(arm.point(0, 0, "2*a"), q, b=0)
    assert not np.allclose(tip[3:], program.jacobian("arm", q, b=0)[3:])
    assert np.array_equal(program.jacobian(s.ground.point(1, 2, 3), q, b=0), np.zeros((6, 3)))
    assert program.jacobian("arm", [q] * 9, b=0).shape == (9, 6, 3)


def test_parameters_by_name_symbol_and_per_state():
    s = cart()
    M = parameters_of(s)[0].symbol
    program = fb.compile(s)
    q, u = [0.1, 0.2, 0.3], [0.5, -0.5, 1.0]
    m = program.mass_matrix(q, M=7.0, b=0)
    assert m[0, 0] - program.mass_matrix(q, b=0)[0, 0] == pytest.approx(5)
    assert np.array_equal(program.mass_matrix(q, values={M: 7, "b": "0"}), m)
    assert np.array_equal(program.mass_matrix(q, M=7, values={"b": 0}), m)
    masses = np.linspace(1, 9, 9)
    batch = program.forward_dynamics(q, u, M=masses, b=1)
    assert batch.shape == (9, 3)
    for row, mass in zip(batch, masses, strict=True):
        assert np.array_equal(row, program.forward_dynamics(q, u, M=mass, b=1))
    assert program.kinetic_energy(q, u, M=list(masses), b=1).shape == (9,)


def test_values_of_expressions():
    s = cart()
    program = fb.compile(s)
    q, u = [0.1, 0.2, 0.3], [0.5, -0.5, 1.0]
    assert program.value("sin(theta) * x'", q, u, b=0) == pytest.approx(math.sin(0.2) * 0.5, rel=1e-15)
    two = program.value(["x + t", "M*a"], [q] * 3, u, [0, 1, 2], b=0)
    assert two == pytest.approx(np.array([[0.1, 0.8], [1.1, 0.8], [2.1, 0.8]]), rel=1e-15)


def test_repeated_calls_see_what_changes():
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    s.gravity = (0, -g, 0)
    s.hinge("pin", s.ground, s.body("bob", fb.particle(m)), to=(0, L, 0), axis="z", coordinate="theta")
    program = fb.compile(s)
    q, u = np.array([0.3]), np.array([0.0])
    first = program.forward_dynamics(q, u)
    assert first == pytest.approx([-9.81 / 2 * math.sin(0.3)], rel=1e-15)
    for _ in range(2):
        assert np.array_equal(program.forward_dynamics(q, u), first)
        assert program.forward_dynamics(q, u, L=4.0) == pytest.approx(first / 2, rel=1e-15)
        assert program.forward_dynamics(q, u, values={"g": 0}) == [0]
        assert program.forward_dynamics([q] * 3, u).tolist() == [first.tolist()] * 3
        assert np.array_equal(program.forward_dynamics(np.array([9, 0.3])[1:], u), first)
        assert np.array_equal(program.forward_dynamics(np.array([0.3, 9, 9])[::3], u), first)
        assert program.mass_matrix(q).tolist() == [[4.0]]
        with pytest.raises(ModelError, match="Expected q of shape"):
            program.forward_dynamics(np.zeros(2), u)


def test_products_are_compiled_when_asked_for():
    program = fb.compile(cart())
    assert isinstance(program, Program)
    assert repr(program).endswith("compiled so far: nothing")
    program.mass_matrix([0, 0, 0], b=0)
    assert repr(program).endswith("compiled so far: mass_matrix")
    text = program.describe("potential_energy", "mass_matrix")
    lines = text.splitlines()
    assert lines[0].startswith("potential_energy: ")
    assert "sincos" in lines[1]
    assert "once per parameters" in lines[1]
    assert program.describe().splitlines()[0].startswith("mass_matrix: ")


def test_factors_of_parameters_are_joined():
    """u' = -(m g L sin θ)/(m L²): one product with one constant, whatever the model writes."""
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=1.5, L=2.0, g=9.81)
    s.gravity = (0, -g, 0)
    s.hinge("pin", s.ground, s.body("bob", fb.particle(m)), to=(0, L, 0), axis="z", coordinate="theta")
    program = fb.compile(s)
    assert program.describe("forward_dynamics").startswith(
        "forward_dynamics: 2 operations (1 mul, 1 sincos); "
    )
    assert program.forward_dynamics([0.3], [0.0]) == pytest.approx([-9.81 / 2 * math.sin(0.3)], rel=1e-15)
    assert program.forward_dynamics([0.3], [0.0], L=0.1) == pytest.approx([-98.1 * math.sin(0.3)], rel=1e-15)


def test_kernels_for_callers_by_address():
    program = fb.compile(cart())
    q, u = [0.1, 0.2, 0.3], [0.5, -0.5, 1.0]
    kernel, c = program.kernel("forward_dynamics"), program.constants(b=2)
    assert kernel.address > 0
    assert np.array_equal(kernel(0.4, [*q, *u], c), program.forward_dynamics(q, u, 0.4, b=2))
    for name in products_of(program.model):
        assert program.kernel(name).outputs > 0


def test_a_machine_at_rest_has_products_too():
    s = fb.System("post")
    (m,) = [s.parameters(m=2.0)]
    post = s.body("post", fb.particle(m))
    s.weld("weld", s.ground, post, at=(1, 2, 3))
    s.gravity = (0, 0, -10)
    program = fb.compile(s)
    assert program.forward_dynamics([], []).shape == (0,)
    assert program.reactions([], [])["weld"].force.tolist() == [0, 0, 20]
    assert program.poses([])["post"].position.tolist() == [1, 2, 3]
    assert program.mass_matrix(np.zeros((4, 0))).shape == (4, 0, 0)


AT_REST = [0, 0, 0]
WRONG = [
    (
        lambda p: p.forward_dynamics([0, 0], AT_REST),
        r"Expected q of shape \(3,\) or \(N, 3\), one number for each of",
    ),
    (lambda p: p.bias(AT_REST, [0]), r"Expected u of shape \(3,\).*x', theta', phi'; got shape \(1,\)"),
    (lambda p: p.inverse_dynamics(AT_REST, AT_REST, 1), r"Expected udot of shape \(3,\)"),
    (lambda p: p.mass_matrix(np.zeros((2, 3)), np.zeros(3)), "Expected t for 2 states as in q, got 3"),
    (lambda p: p.mass_matrix(AT_REST, np.zeros((3, 3))), r"Expected t to be a number or of shape \(N,\)"),
    (
        lambda p: p.mass_matrix(AT_REST, [0, 1], b=1),
        r"nothing of 'cart' depends on time, got 2 numbers. The call is mass_matrix\(q, t\), with parameters by name",
    ),
    (lambda p: p.bias({"x": 0}, AT_REST), r"in the order x, theta, phi. \[given\[name\] for name in"),
    (lambda p: p.bias({"thta": 0}, AT_REST), "'thta' is none of them; did you mean 'theta'"),
    (lambda p: p.bias(AT_REST, ["a"]), "They stand in the order x', theta', phi'. The call is bias"),
    (
        lambda p: p.forward_dynamics(AT_REST, AT_REST, tau=1),
        "Unknown parameter 'tau'.* forward_dynamics are forces=.",
    ),
    (lambda p: p.forward_dynamics(AT_REST, [0]), r"The call is forward_dynamics\(q, u, t, forces=\)"),
    (lambda p: p.jacobian(AT_REST), r"Expected jacobian\(point, q, t, values, named\): missing .*'q'"),
    (
        lambda p: p.bias(np.zeros((2, 3)), AT_REST, M=[1, 2, 3]),
        "Expected parameter 'M' for 2 states as in q, got 3",
    ),
    (
        lambda p: p.mass_matrix(AT_REST, M=np.ones((2, 2))),
        r"Expected parameter 'M' to be a number or of shape \(N,\)",
    ),
    (lambda p: p.mass_matrix(AT_REST, mass=1), "Unknown parameter 'mass'; known names: M, a, b, g, k, m"),
    (lambda p: p.mass_matrix(AT_REST), "No value for parameter b"),
    (lambda p: p.mass_matrix(["x", 0, 0]), "Expected real numbers for q, got"),
    (lambda p: p.jacobian("bra", AT_REST), "Unknown body 'bra'; did you mean 'bar'?"),
    (lambda p: p.jacobian(3, AT_REST), "body or its name, got 3. Bodies of 'cart': cart, bar, arm"),
    (lambda p: p.kernel("mass_matrx"), "Unknown product 'mass_matrx'; did you mean 'mass_matrix'?"),
    (
        lambda p: p.kernel("conditions"),
        r"machine with constraints for the product 'conditions', but 'cart' has no constraints. Its products are forw",
    ),
    (lambda p: p.derivative("conditions", "q"), "'cart' has no constraints"),
    (lambda p: p.to_c("conditions"), "'cart' has no constraints"),
    (lambda p: p.value("thet", AT_REST, AT_REST), "In an expression to evaluate: .*did you mean 'theta'?"),
]


@pytest.mark.parametrize(("call", "message"), WRONG)
def test_wrong_arguments(call, message):
    with pytest.raises((ModelError, ExpressionError, ArgumentError), match=message):
        call(fb.compile(cart()))


def test_what_is_no_machine():
    with pytest.raises(ModelError, match="Expected a System or a Model to compile, got 3"):
        fb.compile(3)


def bar_pendulum():
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), axis="z", coordinate="theta")
    return s, L


def test_numbers_for_parameters_are_read_and_checked_in_each_call():
    """Also where the shorter way is taken, by arrays of doubles and numbers after a first call."""
    s, L = bar_pendulum()
    program, q, u = fb.compile(s), np.array([0.1]), np.array([0.0])
    for given in (
        {"L": 1.0},
        {"values": {L: 1}},
        {"L": np.float64(1)},
        {"L": "1"},
        {"L": "100 cm"},
        {"m": 2, "L": 1},
    ):
        assert program.forward_dynamics(q, u, **given) == pytest.approx(
            [-1.5 * 9.81 * math.sin(0.1)], rel=1e-15
        )
    s.describe(L, unit="m")
    for given, message in (
        ({"L": True}, "Expected a number or an expression, got True"),
        ({"L": -1.0}, "Expected L > 0 in 'pendulum'"),
        ({"L": math.nan}, "Expected a finite number, got nan"),
        ({"L": math.inf}, "Expected a finite number, got inf"),
        ({"l": 1.0}, "Unknown parameter 'l'; did you mean 'L'?"),
        ({"values": {"L": 1.0}, "L": 1.0}, "Parameter 'L' is given twice"),
    ):
        for _ in range(2):
            with pytest.raises(FreebodyError, match=re.escape(message)):
                program.forward_dynamics(q, u, **given)
    assert program.forward_dynamics(q, u) == pytest.approx([-0.75 * 9.81 * math.sin(0.1)], rel=1e-15)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"L": -1.0},
            "Expected L > 0 in 'pendulum', as s.assume or its use says, but L = -1",
        ),
        ({"m": 0}, "Expected m > 0 in 'pendulum'"),
        ({"L": [1.0, -2.0]}, "State 1: Expected L > 0 in 'pendulum'"),
        ({"values": [1]}, "Expected values of parameters by name, such as {'m': 2}, got [1]."),
        ({"values": {"L": 1}, "L": 2}, "Parameter 'L' is given twice. Leave one out."),
    ],
)
def test_values_that_are_refused(given, message):
    s, _ = bar_pendulum()
    with pytest.raises(ModelError) as caught:
        fb.compile(s).forward_dynamics([0.1], [0.0], **given)
    assert message in str(caught.value)


def test_values_of_an_assumed_expression_are_refused():
    s, L = bar_pendulum()
    a = s.parameters(a=1.0)
    s.assume(L - a > 0)
    found = fb.compile(s).forward_dynamics([0.1], [0.0], L=[2.0, math.nan])
    assert np.isfinite(found[0, 0]) and np.isnan(found[1, 0])
    with pytest.raises(
        ModelError, match=r"State 1: Expected L - a > 0 in 'pendulum'.* but L = 0.5, a = 1|a = 1, L = 0.5"
    ):
        fb.compile(s).forward_dynamics([0.1], [0.0], L=[2.0, 0.5])


def test_a_parameter_stands_for_its_name_in_a_derivative():
    s, L = bar_pendulum()
    program = fb.compile(s)
    assert program.derivative("bias", L)([0.1], [0.0]) == program.derivative("bias", "L")([0.1], [0.0])


def test_a_parameter_named_as_an_input_is_ambiguous():
    s, _ = bar_pendulum()
    s.parameters(u=1.0)
    with pytest.raises(ModelError) as caught:
        fb.compile(s).derivative("bias", "u")
    assert "Expected one meaning of 'u', but 'pendulum' has a parameter of this name, too." in str(
        caught.value
    )
