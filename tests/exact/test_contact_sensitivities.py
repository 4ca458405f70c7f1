"""Derivatives of motions with contacts against closed forms: bounces, slips that stop, a ball that comes to roll, a
block on a table that vibrates."""

import numpy as np
import pytest

import freebody as fb

G = 9.81


def ball(law="newton"):
    s = fb.System("ball")
    g, e, h = s.parameters(g=G, e=0.8, h=1.0)
    s.gravity = (0, -g, 0)
    body = s.body("ball", fb.particle(1))
    s.slider("rail", s.ground, body, axis="y", coordinate="y")
    s.contact("floor", body.origin, s.ground.plane(normal="y"), restitution=e, impact=law)
    return s


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_heights_and_times_of_a_bouncing_ball(law):
    """t_k = √(2h/g) (1 + 2 e + ... + 2 e^(k-1)); between impacts y = e^k v (t - t_k) - g (t - t_k)²/2."""
    h, e = 1.0, 0.8
    v, fall = np.sqrt(2 * G * h), np.sqrt(2 * h / G)
    motion = fb.simulate(
        ball(law), 2, initial={"y": "h"}, sensitivities=["h", "e", "g"], times=[0.3, 1.0, 1.6, 1.9], tolerance=1e-12
    )  # fmt: skip
    powers = [1 + 2 * sum(e**i for i in range(1, k)) for k in (1, 2, 3)]
    slopes = [2 * sum(i * e ** (i - 1) for i in range(1, k)) for k in (1, 2, 3)]
    times = motion.sensitivity.times("floor")
    assert times[:, 0] == pytest.approx([fall / (2 * h) * x for x in powers], rel=1e-9)
    assert times[:, 1] == pytest.approx([fall * x for x in slopes], rel=1e-9, abs=1e-12)
    assert times[:, 2] == pytest.approx([-fall / (2 * G) * x for x in powers], rel=1e-9)
    for row, t in enumerate(motion.t):
        k = sum(t > fall * x for x in powers)
        if k == 0:
            expected = [1, 0, -(t**2) / 2]
        else:
            since, rate = t - fall * powers[k - 1], e**k * v - G * (t - fall * powers[k - 1])
            by_h, by_e, by_g = times[k - 1]
            expected = [
                e**k * v / (2 * h) * since - rate * by_h,
                k * e ** (k - 1) * v * since - rate * by_e,
                e**k * v / (2 * G) * since - since**2 / 2 - rate * by_g,
            ]
        found = [motion.sensitivity["y", x][row] for x in ("h", "e", "g")]
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-11)


def test_the_rest_after_all_bounces():
    """x' = v e^∞ = 0: after √(2h/g) (1 + e)/(1 - e) the height depends on nothing."""
    motion = fb.simulate(
        ball(), 3, initial={"y": "h"}, values={"e": 0.5}, sensitivities=["h", "e"], times=[2.9]
    )
    assert abs(motion.sensitivity["y", "h"]) < 1e-12 and abs(motion.sensitivity["y'", "e"]) < 1e-12


def test_stopping_distance_of_a_block():
    """x = v²/(2 μ g) after t = v/(μ g)."""
    s = fb.System("block")
    m, mu, g = s.parameters(m=2, mu=0.3, g=G)
    s.gravity = (0, -g, 0)
    body = s.body("block", fb.box(m, (0.4, 0.2, 0.2)))
    s.planar("plane", s.ground, body, coordinate="x y phi")
    s.contact("feet", body.corners((-0.2, -0.1, 0), (0.2, -0.1, 0)), s.ground.plane(), friction=mu)
    v = 2.0
    motion = fb.simulate(
        s, 1, initial={"x'": v, "y": 0.1}, sensitivities=["mu", "g", "m", "x'"], tolerance=1e-12, samples=3
    )
    expected = {"mu": -(v**2) / (2 * 0.09 * G), "g": -(v**2) / (0.6 * G**2), "m": 0, "x'": v / (0.3 * G)}
    for name, value in expected.items():
        assert motion.sensitivity["x", name][-1] == pytest.approx(value, abs=1e-9)
        assert motion.sensitivity["x'", name][-1] == pytest.approx(0, abs=1e-11)
    t = v / (0.3 * G)
    assert motion.sensitivity.times("feet_1", "mu") == pytest.approx([-t / 0.3], rel=1e-9)
    assert motion.sensitivity["final(m*x)", "m"] == pytest.approx(v**2 / (0.6 * G), rel=1e-9)


def test_a_ball_slides_and_comes_to_roll_in_space():
    """It rolls from t = 2 v/(7 μ g) on, at x = 5/7 v t + 2/49 v²/(μ g)."""
    s = fb.System("ball")
    mu, g, R = s.parameters(mu=0.3, g=G, R=0.1)
    s.gravity = (0, 0, -g)
    body = s.body("ball", fb.sphere(1, R))
    s.free("f", s.ground, body)
    s.contact("floor", body.sphere(R), s.ground.plane(normal="z"), friction=mu)
    start, v = {"f_vx": 3.0, "f_vy": 1.0, "f_z": "R"}, np.sqrt(10)
    motion = fb.simulate(s, 1, initial=start, sensitivities=["mu", "g", "R"], tolerance=1e-12, samples=2)
    shift = 2 / 49 * v**2 / (0.3 * G)
    for coordinate, part in (("f_x", 3 / v), ("f_y", 1 / v)):
        by = {"mu": -shift / 0.3 * part, "g": -shift / G * part, "R": 0}
        for name, value in by.items():
            allowed = (
                1e-7 if name == "R" else 1e-10
            )  # ∂ω/∂R is 214, and the straight step at the end is off by 1e-10
            assert motion.sensitivity[coordinate, name][-1] == pytest.approx(value, abs=allowed)
    # the slip ends, with a straight step, below 1e-8 m/s
    assert motion.sensitivity.times("floor", "mu") == pytest.approx([-2 * v / (7 * 0.09 * G)], rel=1e-8)


def test_a_block_leaves_a_vibrating_table_at_its_own_weight():
    """y = A sin ω t: N = 0 at sin ω t = g/(A ω²)."""
    s = fb.System("table")
    A, w, g = s.parameters(A=0.02, w=30.0, g=G)
    s.gravity = (0, -g, 0)
    table = s.body("table", fb.particle(1))
    s.slider("drive", s.ground, table, axis="y", coordinate="A*sin(w*t)")
    block = s.body("block", fb.particle(2))
    s.slider("rail", s.ground, block, axis="y", coordinate="y")
    s.contact("top", block.origin, table.plane(normal="y"))
    motion = fb.simulate(
        s, 0.05, initial={"y'": "A*w"}, sensitivities=["A", "w", "g"], tolerance=1e-12
    )  # fmt: skip
    ratio = G / (0.02 * 30**2)
    (left,) = [event.time for event in motion.happenings if "N reached 0" in event.text]
    assert left == pytest.approx(np.arcsin(ratio) / 30, rel=1e-10)
    slope = 1 / (30 * np.sqrt(1 - ratio**2))
    assert motion.sensitivity.times("top")[0] == pytest.approx(
        [-slope * ratio / 0.02, -left / 30 - 2 * slope * ratio / 30, slope * ratio / G], rel=1e-8
    )
    assert motion.energy.relative_residual < 1e-9  # the drive's work is in the ledger


def test_a_ball_rolls_to_rest_against_its_resistance():
    """x = 7/10 v² R/(g δ) after t = 7/5 v R/(g δ)."""
    s = fb.System("ball")
    d, g, v = s.parameters(d=0.01, g=G, v=1.0)
    s.gravity = (0, -g, 0)
    body = s.body("ball", fb.sphere(1, 0.1))
    s.planar("plane", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.sphere(0.1), s.ground.plane(), friction=0.5, rolling=d)
    start = {"y": 0.1, "x'": v, "turn'": "-10*v"}
    motion = fb.simulate(s, 2, initial=start, sensitivities=["d", "g", "v"], tolerance=1e-12, samples=2)
    x, t = 7 / 10 * 0.1 / (G * 0.01), 7 / 5 * 0.1 / (G * 0.01)
    found = [motion.sensitivity["x", name][-1] for name in ("d", "g", "v")]
    assert found == pytest.approx([-x / 0.01, -x / G, 2 * x], rel=1e-9)
    (stopped,) = motion.sensitivity.times("floor_rolling")
    assert stopped == pytest.approx([-t / 0.01, -t / G, t], rel=1e-9)


def test_a_ball_spins_to_rest():
    """t = 2/5 R² ω/(δ g)."""
    s = fb.System("ball")
    d, g = s.parameters(d=0.004, g=G)
    s.gravity = (0, 0, -g)
    body = s.body("ball", fb.sphere(3, 0.1))
    s.free("f", s.ground, body)
    s.contact("floor", body.sphere(0.1), s.ground.plane(normal="z"), friction=0.5, spinning=d)
    motion = fb.simulate(s, 2, initial={"f_z": 0.1, "f_wz": 5.0}, sensitivities=["d", "f_wz"], samples=2)
    t = 2 / 5 * 0.01 * 5 / (0.004 * G)
    assert motion.sensitivity.times("floor_spinning")[0] == pytest.approx([-t / 0.004, t / 5], rel=1e-8)


def test_a_wheel_on_a_rough_pin():
    """It stops after t = I ω/(r sin φ m g), tan φ = μ."""
    s = fb.System("wheel")
    mu, r = s.parameters(mu=0.3, r=0.02)
    s.gravity = (0, -G, 0)
    wheel = s.body("wheel", fb.disk(2, 0.1))
    pin = s.hinge("pin", s.ground, wheel, axis="z", coordinate="q")
    s.friction("dry", pin, coefficient=mu, radius=r)
    motion = fb.simulate(
        s, 3, initial={"q'": 10.0}, sensitivities=["mu", "r", "q'"], tolerance=1e-12, samples=2
    )
    t = 0.5 * 0.01 * 10 * np.sqrt(1 + 0.09) / (0.3 * 0.02 * G)
    expected = [-t / (0.3 * 1.09), -t / 0.02, t / 10]
    assert motion.sensitivity.times("dry")[0] == pytest.approx(expected, rel=1e-9)
    assert motion.sensitivity["q", "r"][-1] == pytest.approx(-10 * t / 2 / 0.02, rel=1e-9)


def test_a_box_on_two_feet_begins_to_slip():
    """F t = μ m g, however the feet share it."""
    s = fb.System("box")
    mu, F, m = s.parameters(mu=0.36, F=20.0, m=2.0)
    s.gravity = (0, -G, 0)
    box = s.body("box", fb.box(m, (0.4, 0.2, 0.2)))
    s.planar("plane", s.ground, box, coordinate="x y turn")
    feet = box.corners((-0.2, -0.1, 0), (0.2, -0.1, 0))
    s.contact("floor", feet, s.ground.plane(), friction=0.3, static_friction=mu)
    s.force("push", box.point((0, 0.02, 0)), (F * s.t, 0, 0), frame=s.ground)
    motion = fb.simulate(s, 0.5, initial={"y": 0.1}, sensitivities=["mu", "F", "m"], samples=2)
    t = 0.36 * 2 * G / 20
    for foot in ("floor_1", "floor_2"):
        assert motion.sensitivity.times(foot)[0] == pytest.approx([t / 0.36, -t / 20, t / 2], rel=1e-9)


def test_extremes_of_a_bouncing_ball():
    """The speed is greatest after the impact, e √(2 g h), and smallest before it; of the second arc e² h is the top."""
    names = ["h", "e", "g"]
    motion = fb.simulate(ball(), 0.9, initial={"y": "h"}, sensitivities=names, samples=3, tolerance=1e-12)
    v = np.sqrt(2 * G)
    expected = {
        "max(y')": (0.8 * v / 2, v, 0.8 * v / (2 * G)),
        "min(y')": (-v / 2, 0, -v / (2 * G)),
        "max(y)": (1, 0, 0),
        "min(y)": (0, 0, 0),
        "range(y')": (0.9 * v, v, 0.9 * v / G),
    }
    for what, values in expected.items():
        found = [motion.sensitivity[what, name] for name in names]
        assert found == pytest.approx(values, rel=1e-9, abs=1e-10), what
    # y t is greatest in the second arc, where y = e v τ - g τ²/2 at t = T + τ
    T, u = v / G, 0.8 * v
    top = max(np.roots([-1.5 * G, 2 * u - G * T, u * T]).real)
    t, y = T + top, u * top - G * top**2 / 2
    rate = u - G * top
    by = {"h": (T / 2, 0.8 * v / 2), "e": (0.0, v), "g": (-T / (2 * G), 0.8 * v / (2 * G))}
    for name, (of_T, of_u) in by.items():
        slope = of_u * top - rate * of_T - (top**2 / 2 if name == "g" else 0)
        assert motion.sensitivity["max(t*y)", name] == pytest.approx(t * slope, rel=1e-8), name
    assert motion.sensitivity["max(t*y)", "e"] == pytest.approx(t * v * top, rel=1e-8) and y > 0


def test_forces_of_a_block():
    """N = m g + F sin a, T = -μ N in slip; it is lifted by F t sin a, and its gap grows."""
    s = fb.System("block")
    m, mu, g, F = s.parameters(m=2.0, mu=0.3, g=G, F=6.0)
    s.gravity = (0, -g, 0)
    block = s.body("block", fb.particle(m))
    s.chain("plane", s.ground, block, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("floor", block.origin, s.ground.plane(), friction=mu)
    s.force("pull", block.origin, (0, F * s.t, 0))
    names, times = ["m", "mu", "F"], [0.5, 1.0, 4.0]
    motion = fb.simulate(s, 4, initial={"x'": 9.0}, sensitivities=names, times=times, tolerance=1e-12)
    for row, t in enumerate(times[:2]):
        N = 2 * G - 6 * t
        expected = {"normal": (G, 0, -t), "tangential": (-0.3 * G, -N, 0.3 * t), "gap": (0, 0, 0)}
        for what, values in expected.items():
            found = [motion.sensitivity[f"floor.{what}", name][row] for name in names]
            assert found == pytest.approx(values, rel=1e-9, abs=1e-11), what
    # from t₁ = m g/F on y = F (t - t₁)³/6m
    first = 2 * G / 6
    fly = 4 - first
    by_F = fly**3 / 12 + 6 * fly**2 / 4 * first / 6
    assert motion.sensitivity["floor.gap", "F"][-1] == pytest.approx(by_F, rel=1e-9)
    assert motion.sensitivity["floor.normal", "F"][-1] == 0
    assert motion.sensitivity["final(floor.gap)", "F"] == pytest.approx(by_F, rel=1e-9)


def test_a_kick_changes_where_a_ball_lands():
    """h - g t²/2 + J/m (t - T) = 0."""
    s = ball()
    s.parameters(J=3.0, T=0.2)
    kick = fb.blow("T", at=s.bodies["ball"], impulse=(0, "J", 0))
    names = ["h", "g", "J", "T"]
    motion = fb.simulate(
        s, 0.9, initial={"y": "h"}, impulses=[kick], sensitivities=names, samples=2, tolerance=1e-12
    )
    t = (3 + np.sqrt(9 + 2 * G * (1 - 0.6))) / G
    fall = 3 - G * t
    expected = [-x / fall for x in (1, -(t**2) / 2, t - 0.2, -3)]
    assert motion.sensitivity.times("floor")[0] == pytest.approx(expected, rel=1e-9)
    # after it y = -e (t' - t) fall - g (t' - t)²/2
    since = 0.9 - t
    by_T = (-0.8 * since * -G + 0.8 * fall + G * since) * expected[3]
    assert motion.sensitivity["y", "T"][-1] == pytest.approx(by_T, rel=1e-9)


def test_the_gain_of_a_sampled_law():
    """x_{n+1} = A x_n with A = [[1 - k T²/2m, T], [-k T/m, 1]]: ∂x_n/∂k = Σ A^i ∂A/∂k A^(n-1-i) x_0."""
    s = fb.System("cart")
    s.parameters(k=40.0, u=0.0)
    cart = s.body("cart", fb.particle(2))
    s.force("push", s.slider("rail", s.ground, cart, axis="x", coordinate="x"), "u")
    s.controller(lambda t, x: -x["k"] * x["x"], 0.05, "u")
    motion = fb.simulate(s, 1, initial={"x": 1.0}, sensitivities=["k", "x"], samples=2, tolerance=1e-12)
    T, m, start = 0.05, 2.0, np.array([1.0, 0.0])
    A = np.array([[1 - 40 * T**2 / (2 * m), T], [-40 * T / m, 1]])
    slope = np.array([[-(T**2) / (2 * m), 0], [-T / m, 0]])
    power = np.linalg.matrix_power
    by_k = sum(power(A, i) @ slope @ power(A, 19 - i) @ start for i in range(20))
    assert [motion.sensitivity[x, "k"][-1] for x in ("x", "x'")] == pytest.approx(by_k, rel=1e-10)
    assert motion.sensitivity["x", "x"][-1] == pytest.approx(power(A, 20)[0, 0], rel=1e-10)


def test_a_pendulum_by_a_condition():
    """Derivatives of a pendulum that hits a wall are those of the same one on a hinge."""
    found = []
    for by_condition in (True, False):
        s = fb.System("pendulum")
        g, L, e = s.parameters(g=G, L=1.0, e=0.6)
        s.gravity = (0, -g, 0)
        bob, options = s.body("bob", fb.particle(2)), {}
        if by_condition:
            guide = s.body("guide", fb.particle(0))
            s.slider("along", s.ground, guide, axis="x", coordinate="x")
            s.slider("up", guide, bob, axis="y", coordinate="y")
            s.constrain("x**2 + y**2 - L**2", name="rod")
            start, options = {"x": "L*sin(1)", "x'": 0}, {"near": {"y": -0.5}}
        else:
            s.hinge("pin", s.ground, bob, to=(0, L, 0), axis="z", coordinate="q")
            start = {"q": 1.0}
        s.contact("wall", bob.origin, s.ground.plane(at=(-0.2, 0, 0), normal="x"), restitution=e)
        motion = fb.simulate(
            s, 1.5, initial=start, sensitivities=["g", "L", "e"], samples=2, tolerance=1e-12, **options
        )
        x = "x" if by_condition else "L*sin(q)"
        found.append((motion.sensitivity.times("wall")[0], motion.sensitivity.of(x)[-1]))
    for one, other in zip(*found, strict=True):
        assert one == pytest.approx(other, rel=1e-8, abs=1e-9)
