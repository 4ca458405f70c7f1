"""Linear equations of machines with constraints in symbols, and linear against nonlinear motion of such machines."""

from __future__ import annotations

import math
import types

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.dynamics.conditions.constrained import closed_coordinates
from freebody.dynamics.conditions.linearized import linearized
from freebody.dynamics.motion import motion
from freebody.dynamics.state import float_state
from freebody.errors import ModelError
from freebody.gallery.beyond.whipple_bicycle import LEAN_AND_STEER
from freebody.gallery.beyond.whipple_bicycle import build as bicycle
from freebody.symbolic.linear.deviation import deviations, displaced


def refused(text, call, *args, **kwargs):
    with pytest.raises(ModelError, match=text):
        call(*args, **kwargs)


def rod():
    """A rod on a pin, in three coordinates and two conditions."""
    s = fb.System("rod")
    s.parameters(g=10, F=0)
    s.gravity = (0, "-g", 0)
    body = s.body("rod", fb.slender_bar(2, 1, axis="y"))
    s.planar("p", s.ground, body, coordinate="x y f")
    s.constrain("x - sin(f)/2", name="cx")
    s.constrain("y + cos(f)/2", name="cy")
    s.generalized_force("f", "F")
    return s


def disk():
    s = fb.System("disk")
    m, r, g = s.parameters(m=1.3, r=0.5, g=9.81)
    beta, _ = s.parameters(beta=0.3, Y=2.0)
    s.assume(sympy.cos(beta) > 0)
    s.gravity = (0, 0, -g)
    A, B, C = (s.body(name, fb.particle(0)) for name in "ABC")
    wheel = s.body("disk", fb.disk(m, r, axis="y"))
    s.slider("sx", s.ground, A, axis="x", coordinate="x")
    s.slider("sy", A, B, axis="y", coordinate="y")
    s.slider("sz", B, C, axis="z", coordinate="z")
    s.gimbal("turn", C, wheel, axis="ZXY", coordinate="yaw lean roll")
    s.rolling("floor", wheel, radius=r, axis="y", normal="z")
    return s


def slider_crank():
    s = fb.System("slider_crank")
    r, L, F = s.parameters(r=0.05, L=0.16, F=100.0)
    m_1, m_2, m_3 = s.parameters(m_1=1.5, m_2=0.6, m_3=0.5)
    crank, rod_ = s.body("crank", fb.slender_bar(m_1, r)), s.body("rod", fb.slender_bar(m_2, L))
    piston = s.body("piston", fb.particle(m_3))
    s.hinge("shaft", s.ground, crank, to=(-r / 2, 0, 0), coordinate="a")
    s.hinge("crank_pin", crank, rod_, at=(r / 2, 0, 0), to=(-L / 2, 0, 0), coordinate="b")
    s.slider("cylinder", s.ground, piston, axis="x", coordinate="x")
    s.hinge("wrist_pin", rod_, piston, at=(L / 2, 0, 0))
    s.force("F", piston.origin, (F, 0, 0))
    return s


def four_bar():
    """A hanging trapezoid in absolute angles: the sides lean by psi, the coupler is level."""
    f = fb.System("fourbar")
    a, b, d, g, m = f.parameters(a=1.0, b=1.0, d=2.0, g=9.81, m=2.0)
    f.parameters(psi=0.5)
    f.gravity = (0, -g, 0)
    A, B, C = (f.body(name, fb.slender_bar(m, length)) for name, length in (("A", a), ("B", b), ("C", a)))
    p, q, w = f.coordinates("p q w")
    f.hinge("O1", f.ground, A, to=(-a / 2, 0, 0), coordinate=p)
    f.hinge("O2", A, B, at=(a / 2, 0, 0), to=(-b / 2, 0, 0), coordinate=q - p)
    f.hinge("O3", f.ground, C, at=(d, 0, 0), to=(-a / 2, 0, 0), coordinate=w)
    f.hinge("O4", C, B, at=(a / 2, 0, 0), to=(b / 2, 0, 0))
    return f


def agree(symbolic, numeric):
    assert symbolic.coordinates == numeric.coordinates and symbolic.carried == numeric.carried
    for key in ("M", "C", "K", "B"):
        a, b = getattr(symbolic, key), getattr(numeric, key)
        assert np.abs(a - b).max(initial=0) <= 1e-13 * max(np.abs(b).max(initial=0), 1), key
    for a, b in zip(symbolic.first_order, numeric.first_order, strict=True):
        assert np.abs(a - b).max(initial=0) <= 1e-12 * max(np.abs(b).max(initial=0), 1)


# -- symbols ------------------------------------------------------------------------------------------------


def test_rod_is_a_pendulum():
    """Two conditions on three coordinates leave m L²/3 f'' + m g L/2 f = F, with L = 1, m = 2."""
    linear = fb.linearize(rod(), independent="f", inputs="F x")
    assert linear.text() == "2*f''/3 + g*f = F + x/2"
    assert linear.point["y"] == -sympy.Rational(1, 2)  # not named: it follows from the constraint
    agree(linear.numeric(), fb.linearize(rod(), {"f": 0}, values={}, independent="f", inputs="F x"))


def test_slider_crank_at_its_dead_centre():
    """Stretched by a force F on the piston: x = r cos a + L cos b, so V'' = F (r + r²/L), I = (m1 + m2) r²/3."""
    s = slider_crank()
    linear = fb.linearize(s)
    r, L, F, m_1, m_2 = (s.expression(name) for name in ("r", "L", "F", "m_1", "m_2"))
    assert linear.coordinates == ("a",) and linear.point["x"] == L + r
    assert sympy.simplify(linear.M[0, 0] - (m_1 + m_2) * r**2 / 3) == 0
    assert sympy.simplify(linear.K[0, 0] - F * (r + r**2 / L)) == 0
    agree(linear.numeric(), fb.linearize(s, {"x": 0.21}, values={}, independent="a"))


def test_four_bar():
    s = four_bar()
    b, a, psi = (s.expression(name) for name in ("b", "a", "psi"))
    closed = {"d": b + 2 * a * sympy.cos(psi)}
    linear = fb.linearize(s, {"p": "-psi", "q": 0, "w": "psi - pi"}, where=closed, independent="p")
    d = 1 + 2 * math.cos(0.5)
    numeric = fb.linearize(s, {"p": -0.5, "w": 0.5 - math.pi}, values={"d": d}, independent="p")
    agree(linear.numeric({"d": d}), numeric)
    # the potential energy along the closed positions, differentiated twice in a way of its own: positions by Newton
    model = numeric.model
    from freebody.dynamics.conditions.constrained import closed_coordinates
    from freebody.dynamics.energy import potential_energy
    from freebody.dynamics.state import float_state

    def V(p):
        q = closed_coordinates(model, [p, 0, 0.5 - math.pi], values={"d": d}, fixed=[0])
        return potential_energy(model, float_state(model, q, values={"d": d}))

    def second(h):
        return (V(-0.5 + h) - 2 * V(-0.5) + V(-0.5 - h)) / h**2

    # the term in h² taken out by a second step
    assert numeric.K[0, 0] == pytest.approx((4 * second(1e-3) - second(2e-3)) / 3, rel=1e-6)


def test_rolling_disk_upright():
    """lean'' I + ...: w² = 12/5 Ω² - 4 g/(5 r), so that straight rolling is stable for v² = Ω² r² > g r/3."""
    s = disk()
    W = sympy.Symbol("Omega", positive=True)
    linear = fb.linearize(s, {"roll'": W}, independent="yaw lean roll")
    assert linear.carried == ("x", "y") and linear.point["x'"] == W * s.expression("r")
    g, r = (s.expression(name) for name in "gr")
    (w,) = linear.natural_frequencies()
    assert sympy.simplify(w**2 - (sympy.Rational(12, 5) * W**2 - 4 * g / (5 * r))) == 0
    assert linear.eigenvalues()[:6] == [0] * 6
    kinds = [mode.kind for mode in linear.modes()]
    assert kinds == ["rigid body"] * 3 + ["drift"] * 3 + ["oscillation"]
    # the tilted disk runs off sideways: y = r ∫ (Ω yaw - lean'), as the numeric response has it
    numeric = fb.linearize(s, {"roll'": 4.0}, values={}, independent="yaw lean roll")
    agree(linear.numeric({"Omega": 4.0}), numeric)
    exact, t = linear.response({"lean": "1/100", "y": "1/10"}), sympy.Symbol("t")
    at = {W: 4, g: 9.81, r: 0.5, t: 1.5}
    found = numeric.response({"lean": 0.01, "y": 0.1})(1.5)
    for name in ("yaw", "lean", "roll", "x", "y"):
        assert float(exact[name].subs(at)) == pytest.approx(found[name], abs=1e-13)
    assert "y' = -r*lean' + r*Omega*yaw" in linear.text().splitlines()


def test_rolling_disk_in_a_steady_turn():
    """Lean beta, yaw rate Y, and the roll rate that balances them; the centre runs on a circle."""
    s = disk()
    g, r, beta, Y = (s.expression(name) for name in ("g", "r", "beta", "Y"))
    S, K = sympy.sin(beta), sympy.cos(beta)
    roll = -2 * g * S / (3 * r * Y * K) - 5 * Y * S / 6
    linear = fb.linearize(s, {"lean": beta, "yaw'": Y, "roll'": roll}, independent="yaw lean roll")
    assert linear.carried == () and linear.point["z"] == r * K
    number = float(roll.subs({g: 9.81, r: 0.5, beta: 0.3, Y: 2.0}))
    about = {"lean": 0.3, "yaw'": 2.0, "roll'": number}
    agree(linear.numeric(), fb.linearize(s, about, values={}, independent="yaw lean roll"))


def test_bicycle_in_symbols():
    """Whipple's bicycle with its lengths, gravity, speed and the rider's mass as symbols, against numbers."""
    s = bicycle()
    v = s.expression("v")
    linear = fb.linearize(s, {"air_vx": v}, independent=LEAN_AND_STEER)
    assert linear.point["theta_R'"] == -v / s.expression("r_R")
    for speed in (0.0, 5.0):
        numbers = {"v": speed, "lam": 0.3, "w": 1.1}
        about = {"air_vx": speed, "theta_R'": -speed / 0.3}
        numeric = fb.linearize(s, about, values=numbers, independent=LEAN_AND_STEER)
        agree(linear.numeric(numbers), numeric)
    # C = v C1, K = g K0 + v² K2 in lean and steer
    assert sympy.expand(linear.C[:2, :2] / v).free_symbols.isdisjoint({v})
    assert sympy.Poly(linear.K[1, 1].subs("lam", 0.3), v).monoms() == [(2,), (0,)]


def test_carried_deviations_of_a_skate():
    s = fb.System("skate")
    body = s.body("body", fb.box(2, (1, 1, 1)))
    s.planar("p", s.ground, body, coordinate="x y f")
    s.constrain_speed("x'*sin(f) - y'*cos(f)", name="edge")
    V = sympy.Symbol("V")
    linear = fb.linearize(s, {"x'": V}, independent="x f")
    assert linear.carried == ("y",) and linear.states == ("x", "f", "y", "x'", "f'")
    assert linear.text().splitlines()[-1] == "y' = V*f"
    t = sympy.Symbol("t")
    assert linear.response({"f": "1/10"})["y"] == V * t / 10
    assert linear.characteristic.text() == "2*s^5/3"
    agree(linear.numeric({"V": 3}), fb.linearize(s, {"x'": 3}, values={}, independent="x f"))


def test_moving_in_a_heading_of_its_own_choice():
    """The heading is a symbol: the direction of travel stands in the carried rates."""
    s = fb.System("skate")
    body = s.body("body", fb.box(2, (1, 1, 1)))
    h = s.parameters(h=0.4)
    s.planar("p", s.ground, body, coordinate="x y f")
    s.constrain_speed("x'*sin(f) - y'*cos(f)", name="edge")
    V = sympy.Symbol("V")
    linear = fb.linearize(s, {"f": h, "x'": V * sympy.cos(h)}, independent="x f")
    assert sympy.simplify(linear.point["y'"] - V * sympy.sin(h)) == 0
    about = {"f": 0.4, "x'": 3 * math.cos(0.4)}
    agree(linear.numeric({"V": 3}), fb.linearize(s, about, values={}, independent="x f"))


# -- along a trajectory -------------------------------------------------------------------------------------


def test_turning_axes_along_a_trajectory():
    """x' = A(t) x of a tumbling body (the small turns are about axes that turn at a changing rate) against motions."""
    s = fb.System("tumbler")
    body = s.body("b", fb.box(1, (0.1, 0.2, 0.4)))
    s.ball("p", s.ground, body)
    start = {"p_wx": 1.0, "p_wy": 3.0, "p_wz": 0.5}
    times = np.linspace(0, 1, 201)
    motion = fb.simulate(s, 1, initial=start, times=times, tolerance=1e-13)
    linear = fb.linearize(s, motion)
    A = linear.first_order[0]
    x = np.zeros(6)
    x[0], x[4] = 1.0, 0.3  # ξ and ξ'
    x0, h = x.copy(), 2 * (times[1] - times[0])
    for k in range(0, 200, 2):  # Runge-Kutta of order 4 on every other time
        k1 = A[k] @ x
        k2 = A[k + 1] @ (x + h / 2 * k1)
        k3 = A[k + 1] @ (x + h / 2 * k2)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + A[k + 2] @ (x + h * k3))
    size = 1e-6
    w = np.array([1.0, 3.0, 0.5])
    e0 = [motion[name][0] for name in linear.model.coordinate_names]
    du = x0[3:] + np.cross(w, x0[:3])  # δω = ξ' + ω × ξ
    moved = fb.simulate(
        s,
        1,
        initial={
            "p": displaced(linear.model, e0, size * x0[:3]),
            **dict(zip(start, w + size * du, strict=True)),
        },
        times=times,
        tolerance=1e-13,
    )
    q0, q = (np.stack([y[n] for n in linear.model.coordinate_names], axis=-1) for y in (motion, moved))
    found = deviations(linear.model, q0, q)[-1] / size
    assert found == pytest.approx(x[:3], rel=1e-5, abs=1e-5)


# -- refused ------------------------------------------------------------------------------------------------


def test_messages():
    refused(
        r"The position given does not satisfy the constraints of 'slider_crank': they leave wrist_pin_y: "
        r"-sin\(1\)\*\(r \+ L\) in place of 0\. Name the coordinates .* \(not named: b, x\)",
        fb.linearize, slider_crank(), {"a": 1},
    )  # fmt: skip
    refused(
        "The input 'L' occurs in the constraints of 'slider_crank': its deviations would move them. Take it out",
        fb.linearize,
        slider_crank(),
        inputs="L",
    )
    refused("The input 'L' occurs in the constraints of 'slider_crank'", fb.linearize, slider_crank(), {"x": 0.21},
            values={}, inputs="L")  # fmt: skip
    refused("with the constraint forces eliminated, the equations of its independent coordinates leave f: g - F in "
            "place of 0", fb.linearize, rod(), {"f": "pi/2", "x": "1/2", "y": 0}, independent="f")  # fmt: skip
    refused("The coordinates y are not independent", fb.linearize, rod(), independent="y")
    refused(
        r"Expected 1 independent coordinates of 'rod' \(3 speeds, 2 conditions\), got 2: x, f",
        fb.linearize, rod(), independent="x f",
    )  # fmt: skip
    refused("The speeds given in `about` do not satisfy the constraints of 'rod': they miss c.: ", fb.linearize, rod(),
            {"x'": 1, "f'": 1, "y'": 0})  # fmt: skip
    refused("The speeds given in `about` leave 'x'' of 'disk' open. Give it as well, or yaw'", fb.linearize, disk(),
            {"lean": "beta", "roll'": 1})  # fmt: skip
    s = disk()
    refused("leave lean: .* in place of 0", fb.linearize, s, {"lean": "beta", "yaw'": "Y", "roll'": 1})
    free = fb.System("wheel")
    wheel = free.body("wheel", fb.disk(1, 1))
    free.free("air", free.ground, wheel)
    free.rolling("contact", wheel, radius=1, axis="z", normal="y")
    refused("the speed air_v. changes with time. In symbols, use coordinates", fb.linearize, free,
            {"air_y": 1, "air_wz": 1})  # fmt: skip


def test_a_machine_without_freedom():
    s = rod()
    s.constrain("f", name="held")
    for values in (None, {}):
        refused("leave it no freedom", fb.linearize, s, {"y": -0.5}, values=values)


# -- comparison ---------------------------------------------------------------------------------------------


def order(missed):
    return math.log10(missed[0] / missed[1])


@pytest.mark.parametrize(
    ("build", "about", "independent", "initial", "until"),
    [
        (rod, {}, "f", {"f": 1}, 1),
        (disk, {"roll'": 4.0}, "yaw lean roll", {"lean": 1, "yaw'": 1}, 1),
        (bicycle, {"air_vx": 5.0, "theta_R'": -5 / 0.3}, LEAN_AND_STEER, {"delta": 1, "air_rz": 1}, 0.5),
    ],
    ids=["rod", "disk", "bicycle"],
)
def test_compare_linear_of_constrained_machines(build, about, independent, initial, until):
    """The difference from the nonlinear motion is of second order (third in symmetric machines) in the deviation."""
    s = build()
    worst = []
    for size in (1e-2, 1e-3):
        start = {name: size * x for name, x in initial.items()}
        found = fb.compare_linear(
            s, about, independent=independent, initial=start, until=until, samples=31, tolerance=1e-12
        )
        worst.append(found.worst)
        for name in initial:
            if name in found.nonlinear_motion:
                assert found.nonlinear_motion[name][0] == pytest.approx(size, rel=2 * size)
    for name, x in worst[0].items():
        assert order((x, worst[1][name])) > 1.9, name


def test_compare_linear_of_ball_and_free_joints():
    top = fb.System("top")
    top.gravity = (0, 0, -9.81)
    body = top.body("b", fb.cylinder(1, 0.1, 0.02))
    top.ball("p", top.ground, body, to=(0, 0, -0.05))
    free = fb.System("free")
    box = free.body("b", fb.box(1, (0.1, 0.2, 0.3)))
    free.free("p", free.ground, box)
    for s, about, more in (
        (top, {"p_wz": 300.0}, {}),
        (free, {"p_wz": 3.0, "p_vz": 0.5}, {"p_dx'": 1, "p_dy": 1}),
    ):
        worst = []
        for size in (1e-2, 1e-3):
            start = {name: size * x for name, x in ({"p_rx": 1, "p_ry'": 1} | more).items()}
            found = fb.compare_linear(s, about, initial=start, until=0.3, samples=31, tolerance=1e-12)
            worst.append(found.worst)
            assert found.nonlinear_motion["p_rx"][0] == pytest.approx(size, rel=1e-12)
        for name, x in worst[0].items():
            assert x < 1e-9 or order((x, worst[1][name])) > 1.9, name


def test_compare_linear_refuses_a_free_joint_that_runs_on_a_circle():
    from freebody.gallery.beyond.rolling_disk import build

    s = build()
    refused("changes|change", fb.compare_linear, s, {"air_e0": 1, "air_e1": 1, "air_z": 0.3, "air_wz": 3.0},
            initial={"air_rz": 0.1}, until=1)  # fmt: skip


# -- along motions, against numbers ------------------------------------------------------------------


def test_bent_constraint_along_a_motion():
    """A bead on x² + y² = 1 under gravity. With φ'' = -g cos φ, x = cos φ and δφ = -δx/y:

    M = m/y²,   C = -2 m y'/y³,   K = m (2 y'²/y⁴ - y''/y³ - g/y)
    """
    s = fb.System("bead")
    s.parameters(g=9.81)
    s.gravity = (0, "-g", 0)
    carrier, bead = s.body("carrier", fb.particle(0)), s.body("bead", fb.particle(1))
    s.slider("sx", s.ground, carrier, axis="x", coordinate="x")
    s.slider("sy", carrier, bead, axis="y", coordinate="y")
    s.constrain("x^2 + y^2 - 1", name="ring")
    run = fb.simulate(s, until=0.3, initial={"x": 0.6, "y": -0.8, "x'": 0.8, "y'": 0.6})
    linear = fb.linearize(s, run, independent="x")
    x, y, dx, dy = (np.asarray(run[name]) for name in ("x", "y", "x'", "y'"))
    angular = (x * dy - y * dx) ** 2
    ddy = -angular * y - 9.81 * x**2
    expected = 1 / y**2, -2 * dy / y**3, 2 * dy**2 / y**4 - ddy / y**3 - 9.81 / y
    for found, value in zip((linear.M, linear.C, linear.K), expected, strict=True):
        assert found[:, 0, 0] == pytest.approx(value, rel=1e-8)
    at = fb.linearize(s, run.at(0.3), independent="x")
    assert at.K.item() == pytest.approx(7.764, abs=5e-4)


def random_loop(rng):
    """Two or three bars in a plane, hung from each other, the last tip on a curve; springs, dampers, gravity."""
    n = int(rng.integers(2, 4))
    s = fb.System("loop")
    s.gravity = (rng.uniform(-3, 3), -9.81, 0)
    parent, lengths = s.ground, rng.uniform(0.5, 1.5, n)
    for k, length in enumerate(lengths):
        bar = s.body(f"bar{k}", fb.slender_bar(rng.uniform(0.5, 2), length))
        place = {} if k == 0 else {"at": (lengths[k - 1] / 2, 0, 0)}
        pin = s.hinge(f"pin{k}", parent, bar, to=(-length / 2, 0, 0), coordinate=f"q{k}", **place)
        s.torsion_spring(f"k{k}", pin, stiffness=rng.uniform(0, 9))
        s.damper(f"c{k}", pin, damping=rng.uniform(0, 2))
        parent = bar
    sums = [" + ".join(f"q{j}" for j in range(k + 1)) for k in range(n)]
    x, y = (" + ".join(f"{a}*{f}({q})" for a, q in zip(lengths, sums, strict=True)) for f in ("cos", "sin"))
    if rng.random() < 0.5:
        s.constrain(f"({x})^2/4 + ({y})^2 - {rng.uniform(0.3, 0.6)}", name="ellipse")
    else:
        s.constrain(f"{y} - sin({x})/3", name="wave")
    if n == 3 and rng.random() < 0.5:
        s.constrain_speed("q0' - q1' + cos(q2)*q2'/4", name="drive")
    return s


@pytest.mark.parametrize("seed", range(6))
def test_random_loops_along_motions_against_differences(seed):
    """M⁻¹ C and M⁻¹ K of the independent coordinates are the derivatives of their accelerations."""
    rng = np.random.default_rng(seed)
    s = random_loop(rng)
    model = fb.assemble(s)
    n = model.n_u

    def moved(q, u, held, places):
        """The state near q and u that satisfies the conditions, with some speeds and coordinates held."""
        q = closed_coordinates(model, q.tolist(), fixed=places)
        given = linearized(model, float_state(model, q, u.tolist()))
        G, rate = np.array(given.matrix, dtype=float), np.array(given.rate, dtype=float)
        rest = [j for j in range(n) if j not in held]
        u = u.copy()
        u[rest] -= np.linalg.lstsq(G[:, rest], rate, rcond=None)[0]
        udot = motion(model, float_state(model, q, u.tolist())).udot
        return np.array(q), u, np.array(udot, dtype=float)

    start = np.array(closed_coordinates(model, rng.uniform(0.3, 1.2, n).tolist()))
    q, u, _ = moved(start, rng.uniform(-1, 1, n), [], [])
    at = types.SimpleNamespace(
        t=np.zeros(1), q=q[None], u=u[None], values={}, name="loop", names=(*model.coordinate_names, *model.speed_names)
    )  # fmt: skip
    linear = fb.linearize(s, at)
    own = [model.coordinate_names.index(name) for name in linear.coordinates]
    free = [*own, *(model.coordinate_names.index(name) for name in linear.carried)]
    M, C, K = (getattr(linear, key)[0] for key in "MCK")
    if linear.carried:
        K = np.concatenate([K, linear.canonical["K_carried"][0]], axis=1)
    h = 1e-5
    for column, j in enumerate(free):  # error: h² of the differences, and round-off over h
        slopes = []
        for sign in (1, -1):
            near = q.copy()
            near[j] += sign * h
            slopes.append(moved(near, u, own, free)[2][own])
        expected = -(slopes[0] - slopes[1]) / (2 * h)
        assert np.linalg.solve(M, K[:, column]) == pytest.approx(
            expected, rel=1e-5, abs=1e-5 * np.abs(K).max()
        )
    for column, j in enumerate(own):
        slopes = []
        for sign in (1, -1):
            near = u.copy()
            near[j] += sign * h
            slopes.append(moved(q, near, own, free)[2][own])
        expected = -(slopes[0] - slopes[1]) / (2 * h)
        assert np.linalg.solve(M, C[:, column]) == pytest.approx(
            expected, rel=1e-5, abs=1e-5 * np.abs(C).max()
        )


def test_carried_deviations_in_text_with_numbers():
    s = fb.System("skate")
    body = s.body("body", fb.box(2, (1, 1, 1)))
    s.planar("p", s.ground, body, coordinate="x y f")
    s.constrain_speed("x'*sin(f) - y'*cos(f)", name="edge")
    numbers = fb.linearize(s, {"x'": 3}, values={}, independent="x f")
    assert numbers.text() == "2*x'' = 0\n0.333333*f'' = 0\ny' = 3*f"
    assert numbers.latex().splitlines()[-2] == r"\dot{y} &= 3 f"
    assert 'aria-label="ẏ = 3 f"' in numbers.html()
    # symbols with the same numbers put in print the same lines
    symbols = fb.linearize(s, {"x'": sympy.Symbol("V")}, independent="x f")
    assert symbols.numeric({"V": 3}).text() == numbers.text()


def test_carried_deviations_that_act_back_in_text_with_numbers():
    """A pulled skate with a spring across: what is carried stands in the equations, and follows the others' rates."""
    s = fb.System("sledge")
    body = s.body("body", fb.box(2, (1, 1, 1)))
    s.planar("p", s.ground, body, coordinate="x y f")
    s.constrain_speed("x'*sin(f) - y'*cos(f) + f'/2", name="edge")
    s.generalized_force("y", "-7*y")
    linear = fb.linearize(s, values={}, independent="x f")
    assert linear.carried == ("y",)
    assert linear.text() == "2*x'' = 0\n0.833333*f'' + 3.5*y = 0\ny' = 0.5*f'"


@pytest.mark.parametrize("seed", range(3))
def test_a_ball_joint_on_a_rail_along_a_motion_against_differences(seed):
    """Deviations between neighbouring motions satisfy the linear equations; the axes of small turns move."""
    rng = np.random.default_rng(seed)
    s = fb.System("top")
    s.gravity = (0, 0, -9.81)
    s.ball("tip", s.ground, s.body("body", fb.box(2, (0.3, 0.5, 0.7))), to=(0.1, 0, -0.6))
    q = rng.normal(0, 1, 4)
    q /= np.linalg.norm(q)
    s.constrain(f"tip_e1*tip_e3 + tip_e0*tip_e2 - {q[1] * q[3] + q[0] * q[2]}", name="rail")
    model = fb.assemble(s)
    u = rng.normal(0, 2, 3)
    h = 0.005
    times = 0.1 + h * np.arange(-2, 3)

    def run(turn, change):
        near = closed_coordinates(model, displaced(model, q.tolist(), turn))
        given = linearized(model, float_state(model, near, (u + change).tolist()))
        speeds = (
            u
            + change
            - np.linalg.pinv(np.array(given.matrix, dtype=float)) @ np.array(given.rate, dtype=float)
        )
        start = {"tip": near, **dict(zip(model.speed_names, speeds.tolist(), strict=True))}
        found = fb.simulate(s, until=0.12, initial=start, times=times, tolerance=1e-13)
        return found, np.array([found[name] for name in model.coordinate_names]).T

    motion_0, q_0 = run(np.zeros(3), np.zeros(3))
    linear = fb.linearize(s, motion_0.at(0.1))
    own = [("tip_rx", "tip_ry", "tip_rz").index(name) for name in linear.coordinates]
    M, C, K = np.asarray(linear.M), np.asarray(linear.C), np.asarray(linear.K)
    e = 1e-5
    for _ in range(3):
        turn, change = e * rng.normal(0, 1, 3), e * rng.normal(0, 1, 3)
        (_, first), (_, second) = run(turn, change), run(-turn, -change)
        p = (deviations(model, q_0, first) - deviations(model, q_0, second))[:, own] / (2 * e)
        rate = (p[0] - 8 * p[1] + 8 * p[3] - p[4]) / (12 * h)
        again = (-p[0] + 16 * p[1] - 30 * p[2] + 16 * p[3] - p[4]) / (12 * h**2)
        sides = np.array([M @ again, C @ rate, K @ p[2]])
        # h⁴ of the differences in time, e² of those between the motions, and round-off over e h²
        assert np.abs(sides.sum(axis=0)).max() < 1e-4 * np.abs(sides).max()


def test_what_does_not_carry_a_deviation_is_zero_in_numbers():
    """Upright and at rest, a free disk that rolls: turns about the vertical follow from one speed alone."""
    from freebody.gallery.beyond.rolling_disk import build

    linear = fb.linearize(
        build(), about={"air_z": "R", "air_e0": "sqrt(2)/2", "air_e1": "sqrt(2)/2"}, values={}
    )
    rates = linear.canonical["E_rates"]
    assert np.count_nonzero(rates) == 2 and np.abs(rates[rates != 0]) == pytest.approx(1 / 0.3)
