"""fb.linearize and the linear model: operating points, forms, responses, messages."""

import itertools
import math
import sys

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

import freebody as fb
from freebody.describe.description import parameters_of
from freebody.errors import ModelError
from freebody.testing import random_system
from sampled import sampled

EPS = np.finfo(float).eps
t = sympy.Symbol("t")


def pendulum():
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=1, L=1, g=9.81)
    F, c = s.parameters(F=0, c="1/10")
    s.gravity = (0, -g, 0)
    bob = s.body("bob", fb.particle(m))
    pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), coordinate="theta")
    s.damper("c", pin, damping=c)
    s.force("push", bob.origin, (F, 0, 0))
    return s


def oscillator(c=0, k=4):
    s = fb.System("oscillator")
    s.parameters(k=k, c=c, F=0)
    block = s.body("block", fb.particle(1))
    guide = s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.spring("spring", guide, stiffness="k")
    s.damper("damper", guide, damping="c")
    s.force("push", block.origin, ("F", 0, 0))
    return s


def two_carts():
    """Free on a rail: a rigid-body mode, a constant rate and an oscillation."""
    s = fb.System("carts")
    k, F = s.parameters(k=3, F=0)
    a, b = s.body("a", fb.particle(1)), s.body("b", fb.particle(2))
    s.slider("A", s.ground, a, axis="x", coordinate="x")
    B = s.slider("B", a, b, axis="x", coordinate="d")
    s.spring("spring", B, stiffness=k)
    s.force("push", b.origin, (F, 0, 0))
    return s


def planar_rod():
    """A rod on a pin, in three coordinates and two conditions."""
    s = fb.System("rod")
    s.parameters(g=10, F=0)
    s.gravity = (0, "-g", 0)
    rod = s.body("rod", fb.slender_bar(2, 1, axis="y"))
    s.planar("p", s.ground, rod, coordinate="x y f")
    s.constrain("x - sin(f)/2", name="cx")
    s.constrain("y + cos(f)/2", name="cy")
    s.generalized_force("f", "F")
    return s


# -- matrices -----------------------------------------------------------------------------------------------


def test_symbols_numbers_and_their_agreement():
    s = pendulum()
    m, L, g, F, c = (s.expression(name) for name in ("m", "L", "g", "F", "c"))
    linear = fb.linearize(s, inputs=F)
    assert linear.symbolic and linear.coordinates == ("theta",) and linear.inputs == ("F",)
    assert (linear.M[0], linear.C[0], linear.K[0], linear.B[0]) == (m * L**2, c, m * g * L, L)
    up = fb.linearize(s, about={"theta": sympy.pi}, where={"F": 0})
    assert up.K[0] == -m * g * L
    numeric = fb.linearize(s, values={"L": 2, g: 10}, inputs="F theta")
    assert [float(x[0, 0]) for x in (numeric.M, numeric.C, numeric.K)] == [4, 0.1, 20]
    assert numeric.B.tolist() == [[2, 1]]
    assert linear.numeric({"L": 2, g: 10}).K.tolist() == [[20]] and numeric.numeric() is numeric


def test_any_machine_symbols_agree_with_numbers():
    """A chain at an inclined equilibrium held by springs: the same matrices on polynomials and on floats."""
    s = fb.System("chain")
    k, w = s.parameters(k=2, w="1/3")
    parent = s.ground
    for i in range(3):
        bar = s.body(f"b{i}", fb.box(1 + i, (1, 2, 3)))
        joint = s.hinge(f"j{i}", parent, bar, at=(0, 0, 1), to=(0, 0, -1), axis="xyz"[i], coordinate=f"q{i}")
        s.spring(f"s{i}", joint, stiffness=k, rest="1/5")
        parent = bar
    about = {f"q{i}": "1/5" for i in range(3)}
    exact, numeric = fb.linearize(s, about=about).numeric(), fb.linearize(s, about=about, values={})
    for name in ("M", "C", "K"):
        a, b = getattr(exact, name), getattr(numeric, name)
        assert np.abs(a - b).max() <= 50 * EPS * np.abs(numeric.M).max()
    assert np.abs(numeric.M - numeric.M.T).max() < 50 * EPS * np.abs(numeric.M).max()


def test_split_into_symmetric_and_skew():
    s = fb.System("whirl")
    s.parameters(k=4, n=1, c=2, G=3)
    a = s.body("a", fb.particle(1))
    s.planar("p", s.ground, a, coordinate="x y turn")
    for name in ("x", "y"):
        s.generalized_force(name, f"-k*{name} - c*{name}'")
    s.generalized_force("x", "-n*y - G*y'", name="across_x")
    s.generalized_force("y", "n*x + G*x'", name="across_y")
    rigid = s.body("plate", fb.disk(1, 1))
    s.weld("w", a, rigid)
    linear = fb.linearize(s, values={})
    assert linear.stiffness.tolist() == [[4, 0, 0], [0, 4, 0], [0, 0, 0]]
    assert linear.circulatory.tolist() == [[0, 1, 0], [-1, 0, 0], [0, 0, 0]]
    assert linear.damping.tolist() == [[2, 0, 0], [0, 2, 0], [0, 0, 0]]
    assert linear.gyroscopic.tolist() == [[0, 3, 0], [-3, 0, 0], [0, 0, 0]]
    symbolic = fb.linearize(s)
    assert symbolic.gyroscopic + symbolic.damping == symbolic.C
    assert symbolic.stiffness + symbolic.circulatory == symbolic.K


def test_steady_motion_with_explicit_time():
    """A bead on a hoop that is turned: the drive is a function of time, the linear equations are not."""
    s = fb.System("hoop")
    R, g, w = s.parameters(R=1, g=10, w=5)
    s.gravity = (0, 0, -g)
    hoop, bead = s.body("hoop", fb.particle(0)), s.body("bead", fb.particle(1))
    s.hinge("drive", s.ground, hoop, axis="z", coordinate=w * s.t)
    s.hinge("wire", hoop, bead, to=(0, 0, R), axis="y", coordinate="theta")
    bottom = fb.linearize(s)
    assert sympy.expand(bottom.K[0] - R * (g - R * w**2)) == 0
    tilted = fb.linearize(s, about={"theta": sympy.acos(g / (R * w**2))}, where={})
    assert sympy.simplify(tilted.K[0] - (R**2 * w**2 - g**2 / w**2)) == 0
    numeric = fb.linearize(s, about={"theta": "acos(g/(R*w^2))"}, values={})
    assert numeric.K[0, 0] == pytest.approx(25 - 100 / 25, rel=1e-13)
    held = fb.linearize(s, where={"g": R * w**2})
    assert held.K[0] == 0 and held.natural_frequencies() == [] and held.eigenvalues() == [0, 0]


def test_steady_motion_object():
    from freebody.gallery.textbook.examples.sec_6_9_gyroscope import build

    s = build()
    motions = fb.steady_motions(s, solve_for="psi'")
    slow = next(motion for motion in motions if motion.name == "slow")
    linear = fb.linearize(s, about=slow)
    numeric = linear.numeric({"phi_rate_0": 300})
    known = {p.name: p.default for p in parameters_of(s)} | {"phi_rate_0": 300}
    at = numeric.point["psi'"]
    at = at.subs({x: known[str(x)] for x in at.free_symbols})
    again = fb.linearize(s, about={"theta": "theta_0", "psi'": sympy.N(at, 30), "phi'": 300}, values={})
    assert (
        np.abs(numeric.eigenvalues() - again.eigenvalues()).max() < 1e-10 * np.abs(again.eigenvalues()).max()
    )


def test_small_turns_of_a_ball_joint():
    """A body on a ball joint below it, spun about the vertical: sleeping top, critical spin 2 √(m g L I1)/I3."""
    s = fb.System("top")
    m, g, L, I1, I3 = s.parameters(m=1, g=10, L="1/2", I1=1, I3=2)
    s.gravity = (0, 0, -g)
    inertia = sympy.diag(I1 - m * L**2, I1 - m * L**2, I3)
    top = s.body("top", fb.MassProperties(m, center=(0, 0, 0), inertia=inertia))
    s.ball("pivot", s.ground, top, to=(0, 0, -L))
    critical = 2 * math.sqrt(1 * 10 * 0.5 * 1) / 2
    assert fb.linearize(s, values={}).coordinates == ("pivot_rx", "pivot_ry", "pivot_rz")
    for factor, stable in ((0.99, False), (1.01, True)):
        found = fb.linearize(s, about={"pivot_wz": factor * critical}, values={}).eigenvalues()
        assert (found.real.max() < 1e-9) == stable
    w = sympy.Symbol("w", positive=True)
    symbolic = fb.linearize(s, about={"pivot_wz": w})
    f = symbolic.characteristic.expression
    # in axes that turn with the top: roots shifted by the spin from s² I1 ∓ i I3 w s - m g L = 0
    z = sympy.Symbol("s")
    shifted = (z + sympy.I * w) ** 2 * I1 - sympy.I * I3 * w * (z + sympy.I * w) - m * g * L
    conjugate = sympy.expand(shifted * shifted.subs(sympy.I, -sympy.I))
    assert sympy.rem(sympy.Poly(f, z), sympy.Poly(conjugate, z)).is_zero


@pytest.mark.parametrize("seed", range(3))
def test_free_body_in_screw_motion(seed):
    """A free body without forces, turning and moving: deviations by the linear equations and by the exact motion."""
    rng = np.random.default_rng(seed)
    s = fb.System("free")
    body = s.body("body", fb.box(1, (1, 1, 2)))
    s.free("j", s.ground, body)
    wz, vz = rng.uniform(1, 2, 2)
    about = {"j_wz": wz, "j_vz": vz}
    linear = fb.linearize(s, about=about, values={})
    size = 1e-6
    d = rng.uniform(-1, 1, 6) * size
    speeds = dict(zip(("j_wx", "j_wy", "j_wz", "j_vx", "j_vy", "j_vz"), d, strict=True))
    response = linear.response(speeds)(2.0)
    start = {**speeds, "j_wz": wz + d[2], "j_vz": vz + d[5]}
    end = fb.simulate(s, 2, initial=start, tolerance=1e-13).at(2.0)
    # ξ from q = q0 ∘ exp(ξ/2) and p - p0 = R0 δs
    half = wz * 2 / 2
    q0 = np.array([math.cos(half), 0, 0, math.sin(half)])
    q = np.array([end[f"j_e{k}"] for k in range(4)])
    turn = 2 * np.array(
        [q0[0] * q[1] + q0[3] * q[2], q0[0] * q[2] - q0[3] * q[1], q0[0] * q[3] - q0[3] * q[0]]
    )
    c, sn = math.cos(2 * half), math.sin(2 * half)
    R0 = np.array([[c, -sn, 0], [sn, c, 0], [0, 0, 1]])
    moved = R0.T @ (np.array([end["j_x"], end["j_y"], end["j_z"]]) - [0, 0, 2 * vz])
    mine = np.array([response[f"j_{k}"] for k in ("rx", "ry", "rz", "dx", "dy", "dz")])
    assert np.abs(mine - [*turn, *moved]).max() < 100 * size**2


# -- along a trajectory -------------------------------------------------------------------------------------


def test_along_a_trajectory():
    s = pendulum()
    motion = fb.simulate(s, 1, initial={"theta": 1.0}, values={"L": 2})
    linear = fb.linearize(s, about=motion)
    assert linear.M.shape == (len(motion.t), 1, 1)
    assert np.abs(linear.K[:, 0, 0] - 9.81 * 2 * np.cos(motion["theta"])).max() < 1e-13
    one = fb.linearize(s, about=motion.at(0.5))
    assert one.K[0, 0] == pytest.approx(9.81 * 2 * math.cos(motion.at(0.5)["theta"]), rel=1e-14)
    assert linear.eigenvalues().shape == (len(motion.t), 2)
    assert "along a trajectory, at" in repr(linear)
    for call in (linear.modes, linear.state_space, linear.response, linear.text):
        with pytest.raises(
            ModelError, match="change with time; .* is for one instant. Linearise about trajectory.at"
        ):
            call()
    with pytest.raises(
        ModelError, match="Expected a motion of 'oscillator' in `about`, got one of 'pendulum'"
    ):
        fb.linearize(oscillator(), about=motion)


@pytest.mark.parametrize("seed", range(3))
def test_random_machines_along_a_trajectory(seed):
    """δu' of the nonlinear equations along a deviation equals -M⁻¹(C ξ' + K ξ), to second order by slope."""
    s = random_system(seed, bodies=3, joints=("hinge", "slider", "universal"))
    program = fb.compile(s)
    model = program.model
    rng = np.random.default_rng(seed)
    initial = dict(
        zip((*model.coordinate_names, *model.speed_names), rng.uniform(-1, 1, 2 * model.n_u), strict=True)
    )
    state = fb.simulate(s, 0.05, initial=initial).at(0.02)
    linear = fb.linearize(s, about=state)
    d, e = rng.uniform(-1, 1, (2, model.n_u))
    predicted = -np.linalg.solve(linear.M, linear.C @ e + linear.K @ d)
    here = program.forward_dynamics(state.q, state.u, state.t)
    missed = []
    for h in (1e-3, 1e-4):
        there = program.forward_dynamics(state.q + h * d, state.u + h * e, state.t)
        missed.append(np.abs(there - here - h * predicted).max())
    assert math.log10(missed[0] / missed[1]) == pytest.approx(2, abs=0.1)


def test_transition_along_a_trajectory():
    """The variational equation with M, C, K of the trajectory carries a deviation as two neighbouring motions do."""
    s = pendulum()
    motion = fb.simulate(s, 2, initial={"theta": 1.5}, tolerance=1e-12)
    near = fb.simulate(s, 2, initial={"theta": 1.5 + 1e-5}, tolerance=1e-12)

    def rates(time, x):
        linear = fb.linearize(s, about=motion.at(min(time, 2.0)))
        return linear.first_order[0] @ x

    end = solve_ivp(rates, (0, 2), [1.0, 0.0], rtol=1e-7, atol=1e-9).y[:, -1]
    assert (near.at(2.0)["theta"] - motion.at(2.0)["theta"]) / 1e-5 == pytest.approx(end[0], abs=2e-4)


# -- modes --------------------------------------------------------------------------------------------------


def test_rigid_body_modes():
    linear = fb.linearize(two_carts(), values={})
    modes = linear.modes()
    assert [mode.kind for mode in modes] == ["rigid body", "drift", "oscillation"]
    assert modes[0].shape == {"x": 1, "d": 0}
    assert linear.natural_frequencies()[0] == 0
    assert linear.natural_frequencies()[1] == pytest.approx(math.sqrt(3 * 3 / 2), rel=4 * EPS)
    assert np.count_nonzero(linear.eigenvalues() == 0) == 2
    symbolic = fb.linearize(two_carts(), inputs="F")
    assert [mode.kind for mode in symbolic.modes()] == ["rigid body", "drift", "oscillation"]
    (w,) = symbolic.natural_frequencies()
    assert sympy.simplify(w**2 - 3 * sympy.Symbol("k", real=True) / 2) == 0
    # with friction against the rail the rate decays: one root at zero is left
    damped = two_carts()
    damped.damper("rail", damped.joints["A"], damping=2)
    kinds = [mode.kind for mode in fb.linearize(damped, values={}).modes()]
    assert sorted(kinds) == ["decay", "oscillation", "rigid body"]


def test_equal_frequencies_have_independent_shapes():
    s = fb.System("plane")
    a = s.body("a", fb.disk(1, 1))
    s.planar("p", s.ground, a, coordinate="x y turn")
    for name in ("x", "y"):
        s.generalized_force(name, f"-9*{name} - {name}'/5")
    s.generalized_force("turn", "-turn")
    modes = fb.linearize(s, values={}).modes()
    assert [round(mode.frequency, 12) for mode in modes] == [round(math.sqrt(2), 12), 3, 3]
    pair = np.array([list(mode.shape.values()) for mode in modes[1:]])
    assert np.linalg.matrix_rank(pair) == 2


def test_damping_ratio_and_real_roots():
    s = oscillator(c=2, k=4)
    (mode,) = fb.linearize(s, values={}).modes()
    assert (mode.frequency, mode.damping_ratio) == pytest.approx((2, 0.5), rel=1e-15)
    over = fb.linearize(s, values={"c": 5}).modes()
    assert [mode.kind for mode in over] == ["decay", "decay"]
    assert [mode.eigenvalue for mode in over] == pytest.approx([-1, -4], rel=1e-14)
    growing = fb.linearize(s, values={"k": -4, "c": 0}).modes()
    assert [mode.kind for mode in growing] == ["decay", "growth"]
    symbolic = fb.linearize(s, where={"F": 0})
    k, c = s.expression("k"), s.expression("c")
    assert symbolic.natural_frequencies() == [sympy.sqrt(k)]
    assert symbolic.damping_ratios() == [c / (2 * sympy.sqrt(k))]
    product = sympy.prod(z - sympy.Symbol("s") for z in symbolic.eigenvalues())
    assert sympy.expand(product - (sympy.Symbol("s") ** 2 + c * sympy.Symbol("s") + k)) == 0


def test_tables_and_texts():
    linear = fb.linearize(two_carts(), values={}, inputs="F")
    assert linear.text().splitlines()[0] == "3*x'' + 2*d'' = F"
    assert repr(linear).startswith("Linear equations of 'carts'\n3*x''")
    assert "\\ddot{\\mathrm{x}}" in linear.latex() or "\\ddot{x}" in linear.latex()
    assert "<use" in linear.html()
    table = linear.modes().text().splitlines()
    assert table[0].split() == ["mode", "kind", "frequency", "damping", "ratio", "x", "d"]
    assert table[3].split()[1:] == ["oscillation", "2.12132", "0", "-0.666667", "1"]
    assert linear.modes().latex().startswith("\\begin{array}{rl") and "<use" in linear.modes().html()
    symbolic = fb.linearize(two_carts(), inputs="F")
    assert symbolic.text() == "3*x'' + 2*d'' = F\n2*x'' + 2*d'' + k*d = F"
    assert symbolic.latex().startswith("\\begin{aligned}") and "<use" in symbolic.html()
    assert "sqrt" in symbolic.modes().text() and "\\sqrt" in symbolic.modes().latex()
    assert "√" in symbolic.modes().html()


# -- state space --------------------------------------------------------------------------------------------


def test_state_space():
    linear = fb.linearize(pendulum(), values={}, inputs="F")
    space = linear.state_space(outputs="theta")
    assert space.states == ("theta", "theta'") and space.outputs == ("theta",)
    assert np.abs(space.A - [[0, 1], [-9.81, -0.1]]).max() < 1e-14
    assert space.B.tolist() == [[0], [1]] and space.C.tolist() == [[1, 0]] and space.D.tolist() == [[0]]
    assert repr(space) == "State space: states theta, theta'; inputs F; outputs theta"
    scipy_space = space.to_scipy()
    times = np.linspace(0, 3, 61)
    _, step = scipy_space.step(T=times)
    own = linear.response(forcing={"F": 1})(times)["theta"]
    assert np.abs(step - own).max() < 1e-12
    symbolic = fb.linearize(pendulum(), inputs="F").state_space()
    m, L, g, c = (sympy.Symbol(n, real=True) for n in ("m", "L", "g", "c"))
    assert sympy.simplify(symbolic.A - sympy.Matrix([[0, 1], [-g / L, -c / (m * L**2)]])).is_zero_matrix
    assert sympy.simplify(symbolic.B - sympy.Matrix([0, 1 / (m * L)])).is_zero_matrix
    with pytest.raises(
        ModelError, match=r"takes numbers, but this model is symbolic. Give them: model.numeric"
    ):
        symbolic.to_scipy()
    with pytest.raises(ModelError, match="Unknown output 'thetta'; did you mean 'theta'"):
        linear.state_space(outputs=["thetta"])
    with pytest.raises(ModelError, match="needs an input, and this model has none. Name some"):
        fb.linearize(pendulum(), values={}).state_space().to_scipy()


def test_state_space_for_python_control(monkeypatch):
    """python-control is optional: without it a message, with it the matrices and the names."""
    space = fb.linearize(pendulum(), values={}, inputs="F").state_space()
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(ModelError, match="python-control is not installed.*pip install control"):
        space.to_control()

    class Control:
        @staticmethod
        def ss(*matrices, **names):
            return matrices, names

    monkeypatch.setitem(sys.modules, "control", Control)
    matrices, names = space.to_control()
    assert matrices[0] is space.A and names == {
        "states": ["theta", "theta'"], "inputs": ["F"], "outputs": ["theta", "theta'"],
    }  # fmt: skip


@pytest.mark.parametrize("machine", [pendulum, two_carts])
def test_state_space_against_the_nonlinear_motion(machine):
    """The error of the linear motion is of second (pendulum: third) order in the amplitude."""
    s = machine()
    linear = fb.linearize(s, values={}, inputs="F")
    missed = []
    for size in (1e-1, 1e-2):
        compare = fb.compare_linear(s, initial={linear.coordinates[-1]: size}, until=5, tolerance=1e-13)
        missed.append(max(compare.worst.values()))
    if machine is pendulum:
        assert math.log10(missed[0] / missed[1]) == pytest.approx(3, abs=0.1)
    else:
        assert max(missed) < 1e-11  # the carts are linear


# -- response -----------------------------------------------------------------------------------------------

FORCINGS = [
    "2",
    "3*t^2 - t",
    "exp(-t/2)",
    "cos(3*t)",
    "sin(3*t + 1/2)",
    "t*exp(-t)*cos(2*t)",
    "sin(t)^2",
    "exp(1 - t)*sin(2*t)",
    "cos(2*t)",  # resonance of the undamped oscillator
    "t*sin(2*t)",
]


@pytest.mark.parametrize(("damping", "forcing"), sampled(itertools.product([0, "1/2", 4, 5], FORCINGS), 3))
def test_forced_response(forcing, damping):
    """Exact and numeric closed forms satisfy x'' + c x' + 4 x = F(t) and the initial values."""
    s = oscillator(c=damping)
    exact = fb.linearize(s, inputs="F", where={"k": 4, "c": damping}).response(
        {"x": "1/3", "x'": 1}, {"F": forcing}
    )["x"]
    F = s.expression(forcing, "F")
    c = sympy.Rational(damping)
    left = exact.diff(t, 2) + c * exact.diff(t) + 4 * exact - F
    times = np.linspace(0, 4, 9)
    scale = 1 + max(abs(complex(exact.subs(t, x).evalf())) for x in times)
    for x in times:
        assert abs(left.subs(t, sympy.Rational(x)).evalf(20, chop=True)) < 1e-15 * scale
    assert sympy.simplify(exact.subs(t, 0) - sympy.Rational(1, 3)) == 0
    assert sympy.simplify(exact.diff(t).subs(t, 0) - 1) == 0
    numeric = fb.linearize(s, inputs="F", values={}).response({"x": 1 / 3, "x'": 1}, {"F": forcing})(times)
    book = [complex(exact.subs(t, x).evalf()).real for x in times]
    assert np.abs(numeric["x"] - book).max() < 1e-12 * scale


def test_symbolic_forcing():
    s = oscillator()
    k = s.expression("k")
    A, w = sympy.symbols("A w", positive=True)
    response = fb.linearize(s, inputs="F", where={"c": 0}).response(forcing={"F": A * sympy.cos(w * t)})
    expected = A / (k - w**2) * (sympy.cos(w * t) - sympy.cos(sympy.sqrt(k) * t))
    assert sympy.simplify(response["x"] - expected) == 0
    assert response["x'"] == response["x"].diff(t)
    assert response.text().startswith("x(t) = ") and "\\cos" in response.latex() and "<use" in response.html()
    assert dict(response).keys() == {"x"} and len(response) == 1


def test_biquadratic_response():
    """Two coupled degrees of freedom: the exact response is a sum of both modes."""
    s = fb.System("pair")
    a, b = s.body("a", fb.particle(1)), s.body("b", fb.particle(1))
    A = s.slider("A", s.ground, a, axis="x", coordinate="x")
    B = s.slider("B", a, b, axis="x", coordinate="d")
    s.spring("ka", A, stiffness=2)
    s.spring("kb", B, stiffness=3)
    exact = fb.linearize(s).response({"x": 1, "d'": 2})
    numeric = fb.linearize(s, values={}).response({"x": 1, "d'": 2})
    for x in (0, 1, 3.5):
        for name in ("x", "d"):
            assert float(exact[name].subs(t, x)) == pytest.approx(numeric(x)[name], abs=1e-13)
    terms = numeric.terms("x")
    rebuilt = sum(c * np.exp(z * 1.5) for c, z in terms)
    assert rebuilt.real == pytest.approx(numeric(1.5)["x"], abs=1e-14) and len(terms) == 4


def test_rigid_body_response():
    s = two_carts()
    response = fb.linearize(s, values={}, inputs="F").response({"x'": 1}, {"F": 6})
    found = response(np.array([0.0, 2.0]))
    assert found["x"].shape == (2,)
    center = found["x"] + 2 / 3 * found["d"]  # mass centre: 3 x_C'' = F
    assert center == pytest.approx([0, 2 + 6 / 3 * 4 / 2], abs=1e-12)
    with pytest.raises(ModelError, match="holds powers of t times exponentials .*Call response\\(t\\)"):
        response.terms("x")
    exact = fb.linearize(s, inputs="F").response({"x'": 1}, {"F": 6})
    total = sympy.simplify(exact["x"] + sympy.Rational(2, 3) * exact["d"])
    assert sympy.expand(total - t - t**2) == 0


# -- constraints --------------------------------------------------------------------------------------------


def test_constraints():
    linear = fb.linearize(planar_rod(), about={"f": 0, "y": -0.5}, values={}, independent="f", inputs="F x f")
    assert linear.coordinates == ("f",) and linear.carried == ()
    assert linear.M[0, 0] == pytest.approx(2 / 3, rel=1e-15) and linear.K[0, 0] == pytest.approx(
        10, rel=1e-14
    )
    assert pytest.approx(np.array([[1, 0.5, 1]]), rel=1e-14) == linear.B
    chosen = fb.linearize(planar_rod(), about={"y": -0.5}, values={})
    assert chosen.coordinates == ("x",)
    assert chosen.natural_frequencies() == pytest.approx(linear.natural_frequencies(), rel=1e-14)
    # the position is closed: y follows from f
    assert fb.linearize(planar_rod(), about={"f": 0}, values={}).point["y"] == pytest.approx(-0.5, rel=1e-15)


def test_constraints_along_a_trajectory():
    start = {"f": 0.3, "x": math.sin(0.3) / 2, "y": -math.cos(0.3) / 2}
    motion = fb.simulate(planar_rod(), 0.5, initial=start, samples=11)
    linear = fb.linearize(planar_rod(), about=motion, independent="f")
    assert linear.M[:, 0, 0] == pytest.approx(np.full(11, 2 / 3), rel=1e-12)
    assert linear.K[:, 0, 0] == pytest.approx(10 * np.cos(motion["f"]), rel=1e-7)


def test_knife_edge_carries_its_position():
    """A skate that glides straight: what its position does follows from its heading, and acts on nothing."""
    s = fb.System("skate")
    body = s.body("body", fb.box(2, (1, 1, 1)))
    s.planar("p", s.ground, body, coordinate="x y f")
    s.constrain_speed("x'*sin(f) - y'*cos(f)", name="edge")
    linear = fb.linearize(s, about={"x'": 3}, values={}, independent="x f")
    assert linear.coordinates == ("x", "f") and linear.carried == ("y",)
    assert not linear.C.any() and not linear.K.any()
    response = linear.response({"f": 0.01})
    assert response(2.0)["y"] == pytest.approx(3 * 0.01 * 2, rel=1e-12)


# -- comparison ---------------------------------------------------------------------------------------------


def test_compare_linear(tmp_path):
    s = pendulum()
    compare = fb.compare_linear(s, initial={"theta": 0.2, "theta'": 0.1}, until=3, samples=31)
    assert compare.t.shape == (31,)
    assert np.array_equal(
        compare.difference["theta"], compare.linear_motion["theta"] - compare.nonlinear_motion["theta"]
    )
    assert compare.nonlinear_motion["theta"][0] == pytest.approx(0.2) and 1e-4 < compare.worst["theta"] < 0.01
    path = tmp_path / "compare.png"
    figure = compare.plot(path)
    assert path.stat().st_size > 5000 and len(figure.axes) == 2
    lines = figure.axes[0].get_lines()
    assert np.array_equal(lines[0].get_ydata(), compare.nonlinear_motion["theta"])
    assert repr(compare).splitlines()[1].startswith("theta: largest deviation 0.2")


def test_compare_linear_about_a_steady_motion():
    from freebody.gallery.textbook.examples.sec_6_9_gyroscope import build

    about = {"theta": math.pi / 2, "psi'": 0.5}
    s = build()
    m, R, L, g = (p.default for p in parameters_of(s)[:4])
    about["phi'"] = m * g * L / (m * R**2 / 2 * 0.5)  # (6.106) is exact for a level shaft
    missed = []
    for size in (1e-1, 1e-2):
        compare = fb.compare_linear(s, about, initial={"theta'": size}, until=0.3)
        assert np.abs(compare.nonlinear_motion["theta"]).max() > 1e-3 * size
        missed.append(compare.worst["psi"])
    assert math.log10(missed[0] / missed[1]) == pytest.approx(2, abs=0.2)


# -- messages -----------------------------------------------------------------------------------------------


def refused(match, call, *arguments, **named):
    with pytest.raises(ModelError, match=match):
        call(*arguments, **named)


def test_messages_of_the_operating_point():
    s = pendulum()
    refused(
        r"not an equilibrium or a steady motion of 'pendulum': without accelerations the equations of motion leave "
        r"theta: m\*L\*g\*sin\(theta_0\) in place of 0. Give a balanced state",
        fb.linearize, s, about={"theta": sympy.Symbol("theta_0")}, inputs="F",
    )  # fmt: skip
    refused("leave theta: 0.97936", fb.linearize, s, about={"theta": 0.1}, values={})
    refused(
        "is not a steady motion of 'pendulum'.*sin",
        fb.linearize,
        s,
        about={"theta'": 1},
        where={"c": 0, "F": 0},
    )
    refused("Unknown name 'thetta' in `about`; did you mean 'theta'", fb.linearize, s, about={"thetta": 0})
    refused("Expected `about` to be a mapping of coordinates", fb.linearize, s, about=3)
    refused(r"Expected a constant for the operating value of 'theta', got 't', which moves", fb.linearize, s,
            about={"theta": "t"})  # fmt: skip
    refused("The symbol s in the operating value of 'theta', '2\\*s', is the variable of the characteristic",
            fb.linearize, s, about={"theta": 2 * sympy.Symbol("s")})  # fmt: skip
    refused(
        "Expected a number or an expression for the operating value", fb.linearize, s, about={"theta": [1]}
    )
    refused(r"Expected numbers in `about`, but 'a' holds a, which has no value", fb.linearize, s,
            about={"theta": sympy.Symbol("a")}, values={})  # fmt: skip
    refused("Unknown parameter 'LL' in `where`; did you mean 'L'", fb.linearize, s, where={"LL": 1})
    refused("Unknown name 'G' in inputs", fb.linearize, s, inputs="G")
    refused("Expected each name once in inputs, got F, F", fb.linearize, s, inputs="F F")
    refused("Expected a System, a Model or its equations to linearise, got 'x'", fb.linearize, "x")
    refused(r"No value for a in the linear equations. Give values=\{'a'", 
            fb.linearize(s, where={"L": sympy.Symbol("a"), "F": 0}).numeric)  # fmt: skip
    top = fb.System("top")
    top.ball("pivot", top.ground, top.body("b", fb.box(1, (1, 2, 3))))
    refused(
        r"Expected a quaternion \(w, x, y, z\) or a Rotation for joint 'pivot'",
        fb.linearize,
        top,
        about={"pivot": 1},
    )
    refused("Expected a quaternion of length 1", fb.linearize, top, about={"pivot": (0, 0, 0, 0)}, values={})


def test_rotation_as_operating_point():
    top = fb.System("top")
    top.ball("pivot", top.ground, top.body("b", fb.box(1, (1, 2, 3))))
    turned = fb.linearize(top, about={"pivot": fb.Rotation.euler("ZXZ", 1, 2, 3)}, values={})
    plain = fb.linearize(top, values={})
    assert pytest.approx(plain.M, rel=1e-14) == turned.M


def test_messages_of_motions_that_are_not_steady():
    s = fb.System("unbalanced rotor")
    rotor = s.body("rotor", fb.box(1, (1, 2, 3)))
    A, B = s.body("A", fb.particle(1)), s.body("B", fb.particle(1))
    s.slider("x", s.ground, A, axis="x", coordinate="x")
    s.slider("y", A, B, axis="y", coordinate="y")
    s.hinge("spin", B, rotor, axis="z", coordinate="phi")
    s.hinge("tilt", rotor, s.body("arm", fb.box(1, (1, 2, 4))), axis="x", coordinate="beta")
    for name in ("x", "y"):
        s.generalized_force(name, f"-{name}")
    about = {"phi'": 2}
    fb.linearize(s, about=about)  # the mass centre stays on the axis
    s.generalized_force("x", "-cos(phi)*beta", name="odd")
    for values in (None, {}):
        refused("is balanced, but the linear equations of 'unbalanced rotor' about it change", fb.linearize, s,
                about=about, values=values)  # fmt: skip


def test_messages_of_constraints():
    s = planar_rod()
    refused(
        "the accelerations of its independent coordinates are x: ",
        fb.linearize,
        s,
        about={"f": 0.3},
        values={},
    )
    refused(
        "The coordinates y are not independent",
        fb.linearize,
        s,
        about={"y": -0.5},
        values={},
        independent="y",
    )
    refused("Expected 1 independent coordinates of 'rod' \\(3 speeds, 2 conditions\\), got 2", fb.linearize, s,
            about={"y": -0.5}, values={}, independent="x y")  # fmt: skip
    refused("The speeds given in `about` do not satisfy the constraints of 'rod': they miss cx: ", fb.linearize, s,
            about={"y": -0.5, "x'": 1, "f'": 1, "y'": 0}, values={})  # fmt: skip


def test_messages_of_responses():
    linear = fb.linearize(oscillator(), values={}, inputs="F")
    refused("Unknown name 'xx' in initial; did you mean 'x'", linear.response, {"xx": 1})
    refused("Unknown input 'G' in forcing; known names: F", linear.response, {}, {"G": 1})
    unforced = fb.linearize(oscillator(), values={})
    refused("Unknown input 'F' in forcing.*Name the inputs in fb.linearize", unforced.response,
            {}, {"F": 1})  # fmt: skip
    refused(
        r"Expected the input 'F' to be a sum of terms t\^k .* but it holds",
        linear.response,
        {},
        {"F": "cos(t^2)"},
    )
    refused(r"Expected the input 'F' to be a sum of terms", linear.response, {}, {"F": "1/(1 + t)"})
    refused("Expected numbers in the forcing of a numeric model, but 'w' holds w", linear.response, {},
            {"F": sympy.cos(sympy.Symbol("w") * t)})  # fmt: skip
    refused(
        "Expected a number for the response of a numeric model, got 'a'",
        linear.response,
        {"x": sympy.Symbol("a")},
    )
    refused("Unknown name 'z' in a response", linear.response({"x": 1}).terms, "z")
    refused("Unknown name 'z' in a response", 
            fb.linearize(oscillator(), inputs="F").response({"x": 1}).__getitem__, "z")  # fmt: skip
    refused("A numeric model has no characteristic polynomial", lambda: linear.characteristic)


def test_messages_of_roots_without_closed_form():
    s = fb.System("chain")
    parent = s.ground
    for i in range(3):
        body = s.body(f"b{i}", fb.particle(1))
        joint = s.slider(f"j{i}", parent, body, axis="x", coordinate=f"x{i}")
        s.spring(f"k{i}", joint, stiffness=i + 1)
        s.damper(f"c{i}", joint, damping=f"{i * i + 1}/7")
        parent = body
    linear = fb.linearize(s)
    refused(
        "roots of a factor of degree 6 in s have no closed form: .*Give numbers: model.numeric",
        linear.eigenvalues,
    )
    refused("has no roots in closed form, so the response has none. Give numbers", linear.response, {"x0": 1})
    assert len(linear.numeric().eigenvalues()) == 6
    for i in range(3, 9):
        body = s.body(f"b{i}", fb.particle(1))
        s.slider(f"j{i}", parent, body, axis="x", coordinate=f"x{i}")
        parent = body
    refused("characteristic polynomial of 9 coordinates in symbols is too large", fb.linearize(s).eigenvalues)


def test_messages_of_singular_coordinates():
    """Euler angles of an upright top: psi and phi are one angle, and no acceleration is determined."""
    s = fb.System("top")
    m, R, L, g = s.parameters(m=1, R=0.1, L=0.2, g=9.81)
    s.gravity = (0, 0, -g)
    rotor = s.body("rotor", fb.disk(m, R))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -L), axis="ZXZ", coordinate="psi theta phi")
    linear = fb.linearize(s)
    for question in (linear.modes, linear.eigenvalues, linear.state_space, linear.natural_frequencies):
        refused(
            "The mass matrix of 'top' is singular at the state given: its coordinates are singular", question
        )
    for about in ({}, {"theta": math.pi}, {"phi'": 300}):
        refused(
            "mass matrix of 'top' is singular .* Use other coordinates",
            fb.linearize,
            s,
            about=about,
            values={},
        )
    # tilted they are not singular, and frequencies are those of two tilts about horizontal axes
    assert len(fb.linearize(s, about={"theta": math.pi - 1e-3, "psi'": 0}, values={"g": 0}).modes()) == 6


def test_message_of_a_machine_without_freedom():
    s = fb.System("lift")
    cage = s.body("cage", fb.particle(1))
    s.slider("rail", s.ground, cage, axis="y", coordinate="y")
    s.constrain("y - 2", name="brake")
    refused(
        "The constraints and drives of 'lift' leave it no freedom", fb.linearize, s, about={"y": 2}, values={}
    )
