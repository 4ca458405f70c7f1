"""Linear equations of textbook machines against closed forms worked out by hand."""

import math

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.describe.description import names_of
from freebody.exact.gyroscope import precession_response

EPS = np.finfo(float).eps
t = sympy.Symbol("t")


def zero(expression):
    return sympy.simplify(expression) == 0


def double_pendulum():
    """Two equal point masses on equal rods, absolute angles."""
    s = fb.System("double pendulum")
    m, L, g = s.parameters(m=1, L=1, g=10)
    s.assume(L > 0, g > 0)
    s.gravity = (0, -g, 0)
    q1, q2 = s.coordinates("q1 q2")
    a, b = s.body("a", fb.particle(m)), s.body("b", fb.particle(m))
    s.hinge("A", s.ground, a, to=(0, L, 0), coordinate=q1)
    s.hinge("B", a, b, to=(0, L, 0), coordinate=q2 - q1)
    return s, L, g


def test_double_pendulum():
    """w² = (2 ∓ √2) g/L, q2 = ±√2 q1 (Landau & Lifshitz, Mechanics, §23, problem 2)."""
    s, L, g = double_pendulum()
    linear = fb.linearize(s)
    low, high = linear.natural_frequencies()
    assert zero(low**2 - (2 - sympy.sqrt(2)) * g / L)
    assert zero(high**2 - (2 + sympy.sqrt(2)) * g / L)
    shapes = [mode.shape["q2"] for mode in linear.modes()]
    assert zero(shapes[0] - sympy.sqrt(2)) and zero(shapes[1] + sympy.sqrt(2))
    assert linear.C.is_zero_matrix and linear.circulatory.is_zero_matrix
    numeric = fb.linearize(s, values={"L": 2})
    exact = np.sqrt((2 + np.array([-1, 1]) * math.sqrt(2)) * 10 / 2)
    assert np.abs(numeric.natural_frequencies() - exact).max() < 8 * EPS * exact[1]
    # the shape is normalised by its largest component, that of the lower mass
    assert numeric.modes()[0].shape == pytest.approx({"q1": 1 / math.sqrt(2), "q2": 1}, rel=1e-14)


def airfoil():
    """Problem 6.14: plunge and pitch of a section; the mass centre is s behind the elastic axis."""
    s = fb.System("airfoil")
    m, I_E, d, kx, kt = s.parameters(m=10, I_E="9/10", d="1/10", kx=4000, kth=200)
    rod = fb.MassProperties(m, center=(d, 0, 0), inertia=sympy.diag(0, 0, I_E - m * d**2))
    section = s.body("section", rod)
    carrier = s.body("carrier", fb.particle(0))
    plunge = s.slider("plunge", s.ground, carrier, axis="y", coordinate="x")
    pitch = s.hinge("pitch", carrier, section, coordinate="theta")
    s.spring("kx", plunge, stiffness=kx)
    s.spring("kth", pitch, stiffness=kt)
    return s


def test_airfoil_section():
    """(kx - m w²)(kθ - I_E w²) = (m d)² w⁴, X/Θ = m d w² / (kx - m w²)."""
    s = airfoil()
    m, I_E, d, kx, kt = 10, 0.9, 0.1, 4000, 200
    linear = fb.linearize(s, values={})
    a, b, c = m * I_E - (m * d) ** 2, -(m * kt + I_E * kx), kx * kt
    exact = np.sqrt(np.sort(np.roots([a, b, c])))
    assert np.abs(linear.natural_frequencies() / exact - 1).max() < 20 * EPS
    for w, mode in zip(exact, linear.modes(), strict=True):
        ratio = mode.shape["x"] / mode.shape["theta"]
        assert ratio == pytest.approx(m * d * w**2 / (kx - m * w**2), rel=1e-11)
    # x(1 s), theta(1 s) from x(0) = 0.01 at rest, by the two modes written out
    X = np.array([m * d * w**2 / (kx - m * w**2) for w in exact])
    weights = np.linalg.solve(np.array([X, [1, 1]]), [0.01, 0])
    at = linear.response({"x": 0.01})(1.0)
    assert at["x"] == pytest.approx(np.sum(weights * X * np.cos(exact)), abs=1e-14)
    assert at["theta"] == pytest.approx(np.sum(weights * np.cos(exact)), abs=1e-13)
    symbols = fb.linearize(s).numeric().natural_frequencies()
    assert np.abs(symbols / exact - 1).max() < 20 * EPS


def gyroscope():
    from freebody.gallery.textbook.examples.sec_6_9_gyroscope import build

    s = build()
    names = names_of(s).atoms
    m, R, L, g, theta = (names[k] for k in ("m", "R", "L", "g", "theta_0"))
    I_xi, I_zeta = m * R**2 / 4 + m * L**2, m * R**2 / 2
    p = sympy.Symbol("p", positive=True)
    # (6.111): p (I_zeta Omega - I_xi p cos theta_0) = m g L
    spin = (m * g * L / p + I_xi * p * sympy.cos(theta)) / I_zeta
    about = {"theta": theta, "psi'": p, "phi'": spin - p * sympy.cos(theta)}
    sigma = (I_zeta * spin - 2 * I_xi * p * sympy.cos(theta)) / I_xi  # (6.113)
    return s, about, sigma, p, theta


def test_gyroscope_equations():
    """(6.114): θ₁'' + ω_η0² θ₁ + σ sin θ₀ ψ₁' = 0,  -σ θ₁' + sin θ₀ ψ₁'' = 0, where the spin does not change."""
    s, about, sigma, p, theta = gyroscope()
    linear = fb.linearize(s, about=about)
    assert linear.coordinates == ("psi", "theta", "phi")
    assert linear.damping.is_zero_matrix and linear.circulatory.is_zero_matrix
    a, b, db = sympy.symbols("a b db")  # theta_1, theta_1', psi_1'
    dda, ddb = sympy.symbols("dda ddb")
    sine, cosine = sympy.sin(theta), sympy.cos(theta)
    # Omega = phi' + psi' cos(theta) constant
    rate = sympy.Matrix([db, b, -db * cosine + p * sine * a])
    second = sympy.Matrix([ddb, dda, -ddb * cosine + p * sine * b])
    left = linear.M * second + linear.C * rate + linear.K * sympy.Matrix([0, a, 0])
    assert zero(left[2])
    I_xi = linear.M[1, 1]
    assert zero(left[1] / I_xi - (dda + (p * sine) ** 2 * a + sigma * sine * db))
    assert zero(left[0] / (I_xi * sine) - (sine * ddb - sigma * b))


def test_gyroscope_frequency():
    """(6.119): Ω² = ω_η0² + σ², and four roots at zero."""
    s, about, sigma, p, theta = gyroscope()
    linear = fb.linearize(s, about=about)
    roots = linear.eigenvalues()
    assert len(roots) == 6 and roots.count(0) == 4
    (w,) = linear.natural_frequencies()
    assert zero(w**2 - sigma**2 - (p * sympy.sin(theta)) ** 2)
    # the same in numbers, from the independent closed form
    values = {"theta_0": 1.0, "p": 2.5}
    numeric = linear.numeric(values)
    point = numeric.values
    I_xi = point["m"] * (point["R"] ** 2 / 4 + point["L"] ** 2)
    I_zeta = point["m"] * point["R"] ** 2 / 2
    mgL = point["m"] * point["g"] * point["L"]
    spin = (mgL / 2.5 + I_xi * 2.5 * math.cos(1.0)) / I_zeta
    exact = precession_response(I_xi, I_zeta, mgL, 1.0, spin)
    assert abs(numeric.eigenvalues()[-2] - 1j * exact.frequency) < 1e-12 * exact.frequency
    assert np.count_nonzero(numeric.eigenvalues() == 0) == 4


def test_gyroscope_response():
    """(6.120), with the misprint put right: 1 - cos stands with σ ω_ξ/(Ω² sin θ₀), and t - σ²/Ω³ (Ω t - sin Ω t)."""
    s, about, sigma, p, theta = gyroscope()
    linear = fb.linearize(s, about=about)
    w_xi, w_eta = sympy.symbols("w_xi w_eta", real=True)
    sine, cosine = sympy.sin(theta), sympy.cos(theta)
    response = linear.response({"theta'": w_xi, "psi'": w_eta / sine, "phi'": -w_eta * cosine / sine})
    W = sympy.sqrt((p * sine) ** 2 + sigma**2)
    exact_theta = w_xi / W * sympy.sin(W * t) - sigma * w_eta / W**2 * (1 - sympy.cos(W * t))
    exact_psi = sigma * w_xi / (W**2 * sine) * (1 - sympy.cos(W * t)) + w_eta / sine * (
        t - sigma**2 / W**3 * (W * t - sympy.sin(W * t))
    )
    rng = np.random.default_rng(6)
    for _ in range(3):
        names = sorted({x for e in (exact_theta, response["theta"]) for x in e.free_symbols}, key=str)
        at = {x: sympy.Float(rng.uniform(0.5, 1.5), 30) for x in names}
        for mine, book in ((response["theta"], exact_theta), (response["psi"], exact_psi)):
            assert abs((mine - book).xreplace(at).evalf(25)) < 1e-22
    assert zero(response["theta"].subs(t, 0)) and zero(response["psi'"].subs(t, 0) - w_eta / sine)


def cart_and_bar():
    """Cart with a damper and a spring to the wall; a bar hangs from it."""
    s = fb.System("cart and bar")
    M, m, a, k, c, g = s.parameters(M=2, m=1, a="1/2", k=10, c=3, g=10)
    F = s.parameters(F=0)
    s.gravity = (0, -g, 0)
    cart, bar = s.body("cart", fb.particle(M)), s.body("bar", fb.slender_bar(m, 2 * a, axis="y"))
    guide = s.slider("guide", s.ground, cart, axis="x", coordinate="x")
    s.hinge("pin", cart, bar, to=(0, a, 0), coordinate="theta")
    s.spring("spring", guide, stiffness=k)
    s.damper("damper", guide, damping=c)
    s.force("push", cart.origin, (F, 0, 0))
    return s


def test_cart_and_bar_complex_modes():
    """Complex modes: (M s² + C s + K) X = 0 with matrices written by hand, and energy lost by the damper alone."""
    s = cart_and_bar()
    linear = fb.linearize(s, values={}, inputs="F")
    M = np.array([[3, 0.5], [0.5, 1 / 3]])  # [[M + m, m a], [m a, 4 m a²/3]]
    C, K = np.diag([3.0, 0]), np.diag([10.0, 5])
    for mine, hand in ((linear.M, M), (linear.damping, C), (linear.stiffness, K), (linear.B, [[1], [0]])):
        assert np.abs(mine - hand).max() < 4 * EPS * 10
    assert not linear.gyroscopic.any() and not linear.circulatory.any()
    from scipy.linalg import eigvals

    zeros = np.zeros((2, 2))
    pencil = eigvals(np.block([[zeros, np.eye(2)], [-K, -C]]), np.block([[np.eye(2), zeros], [zeros, M]]))
    assert np.abs(linear.eigenvalues()[:, None] - pencil).min(axis=0).max() < 1e-13
    for mode in linear.modes():
        X = np.array(list(mode.shape.values()))
        w = mode.eigenvalue
        assert np.abs((M * w**2 + C * w + K) @ X).max() < 1e-12
        assert abs(X[np.argmax(np.abs(X))] - 1) < 1e-15
        # multiplied by X*: the damping ratio is that of the mode's own mass, damping and stiffness
        own = [float((X.conj() @ A @ X).real) for A in (M, C, K)]
        assert mode.frequency == pytest.approx(math.sqrt(own[2] / own[0]), rel=1e-12)
        assert mode.damping_ratio == pytest.approx(own[1] / (2 * math.sqrt(own[0] * own[2])), rel=1e-12)
    assert np.abs(np.imag(linear.modes()[0].shape["theta"] / linear.modes()[0].shape["x"])) > 0.01


def spinning_body():
    s = fb.System("spinning body")
    s.body("body", fb.MassProperties(1, center=(0, 0, 0), inertia=[[1, 0, 0], [0, 2, 0], [0, 0, "5/2"]]))
    s.ball("pivot", s.ground, s.bodies["body"])
    return s


@pytest.mark.parametrize("axis", "xyz")
def test_free_rigid_body(axis):
    """Spin about principal axis 3: the rate of growth squared is -(I3 - I1)(I3 - I2) w²/(I1 I2) (Euler)."""
    spin = 3
    inertia = dict(zip("xyz", (1, 2, 2.5), strict=True))
    i1, i2 = (inertia[k] for k in "xyz" if k != axis)
    square = (inertia[axis] - i1) * (inertia[axis] - i2) * spin**2 / (i1 * i2)
    exact = math.sqrt(abs(square)) * (1j if square > 0 else 1)
    linear = fb.linearize(spinning_body(), about={f"pivot_w{axis}": spin}, values={})
    found = linear.eigenvalues()
    # attitude: the space axes seen from the body turn at the spin; angular momentum about the spin axis: two zeros
    expected = [0, 0, 1j * spin, -1j * spin, exact, -exact]
    for root in expected:
        assert np.abs(found - root).min() < 1e-14 * spin
    assert len(found) == 6
    growth = [mode for mode in linear.modes() if mode.kind == "growth"]
    assert len(growth) == (axis == "y")
    symbolic = fb.linearize(spinning_body(), about={f"pivot_w{axis}": sympy.Symbol("w", positive=True)})
    squares = {sympy.simplify(w**2) for w in symbolic.natural_frequencies()}
    w = sympy.Symbol("w", positive=True)
    assert squares == {w**2, sympy.nsimplify(square) * w**2 / spin**2}


def test_follower_force():
    """Two rods with a force along the second (Ziegler 1952): the force makes a circulatory part; flutter at 7/2 - √2.

    Masses 2m at the middle joint and m at the tip, springs k: P L/k = 7/2 - √2 = 2.0858.
    """
    s = fb.System("Ziegler")
    m, L, k, P = s.parameters(m=1, L=1, k=1, P=1)
    q1, q2 = s.coordinates("q1 q2")
    a, b = s.body("a", fb.particle(2 * m)), s.body("b", fb.particle(m))
    A = s.hinge("A", s.ground, a, to=(0, -L, 0), coordinate=q1)
    B = s.hinge("B", a, b, to=(0, -L, 0), coordinate=q2 - q1)
    s.spring("k1", A, stiffness=k)
    s.spring("k2", B, stiffness=k)
    s.force("P", b.origin, (0, -P, 0), frame=b)
    linear = fb.linearize(s)
    assert sympy.Matrix([[2 * k - L * P, L * P - k], [-k, k]]) == linear.K
    assert linear.circulatory == sympy.Matrix([[0, L * P / 2], [-L * P / 2, 0]])
    critical = 3.5 - math.sqrt(2)
    below, above = (fb.linearize(s, values={"P": critical * f}).eigenvalues() for f in (0.999, 1.001))
    assert np.abs(below.real).max() < 1e-12 and above.real.max() > 1e-3


def test_rolling_disk_upright():
    """A thin disk that rolls straight: lean oscillates with w² = 12/5 Ω² - 4 g/(5 r), stable for Ω² > g/(3 r)."""
    s = fb.System("disk")
    m, r, g = s.parameters(m=1.3, r=0.5, g=9.81)
    s.gravity = (0, 0, -g)
    A, B, C = (s.body(name, fb.particle(0)) for name in "ABC")
    disk = s.body("disk", fb.disk(m, r, axis="y"))
    s.slider("sx", s.ground, A, axis="x", coordinate="x")
    s.slider("sy", A, B, axis="y", coordinate="y")
    s.slider("sz", B, C, axis="z", coordinate="z")
    s.gimbal("turn", C, disk, axis="ZXY", coordinate="yaw lean roll")
    s.rolling("floor", disk, radius=r, axis="y", normal="z")
    for rate in (1.5, 4.0):
        about = {"z": 0.5, "roll'": rate}
        linear = fb.linearize(s, about=about, values={}, independent="yaw lean roll")
        assert linear.coordinates == ("yaw", "lean", "roll") and linear.carried == ("x", "y")
        assert linear.point["x'"] == pytest.approx(0.5 * rate, rel=1e-15)
        square = 12 / 5 * rate**2 - 4 * 9.81 / (5 * 0.5)
        found = linear.eigenvalues()
        assert np.count_nonzero(found == 0) == 6
        assert np.abs(found[-2:] ** 2 + square).max() < 1e-13 * abs(square)
        # (m r² + I_t) lean'' - (I_s + m r²) Ω yaw' - m g r lean = 0,   I_t yaw'' + I_s Ω lean' = 0
        I_t, I_s = 1.3 * 0.25 / 4, 1.3 * 0.25 / 2
        assert pytest.approx(np.diag([I_t, 1.3 * 0.25 + I_t, 1.3 * 0.25 + I_s]), abs=1e-15) == linear.M
        assert linear.C[1, 0] == pytest.approx(-(I_s + 1.3 * 0.25) * rate)
        assert linear.C[0, 1] == pytest.approx(I_s * rate)
        assert linear.K[1, 1] == pytest.approx(-1.3 * 9.81 * 0.5)


def test_rolling_disk_steady_turn():
    """A disk rolling in a circle: balance of lean by hand; the linear equations hold although x and y go round."""
    s = fb.System("disk")
    m, r, g = s.parameters(m=1, r=1, g=9.81)
    s.gravity = (0, 0, -g)
    A, B, C = (s.body(name, fb.particle(0)) for name in "ABC")
    disk = s.body("disk", fb.disk(m, r, axis="y"))
    s.slider("sx", s.ground, A, axis="x", coordinate="x")
    s.slider("sy", A, B, axis="y", coordinate="y")
    s.slider("sz", B, C, axis="z", coordinate="z")
    s.gimbal("turn", C, disk, axis="ZXY", coordinate="yaw lean roll")
    s.rolling("floor", disk, radius=r, axis="y", normal="z")
    lean, yaw_rate = 0.2, -0.7
    S, K_, G = math.sin(lean), math.cos(lean), 9.81
    # moments about the contact point along the direction of travel: the yaw rate and the roll rate w that balance the
    # lean (I_s + m r²)(w + p sin) p cos - I_t p² sin cos + m g r sin = 0 up to sense, I_t = 1/4, I_s = 1/2
    w = (-G * S / (yaw_rate * K_) + yaw_rate * S / 4) / 1.5 - yaw_rate * S
    about = {"z": K_, "lean": lean, "yaw'": yaw_rate, "roll'": w}
    linear = fb.linearize(s, about=about, values={}, independent="yaw lean roll")
    assert linear.carried == ()  # x and y follow at rates that change with the heading
    grown = fb.simulate(s, 3, initial=linear.point)
    assert np.abs(grown["lean"] - lean).max() < 1e-8
    # the difference from the nonlinear motion is of second order in the deviation
    times = np.linspace(0, 3, 50)
    missed = []
    for size in (1e-3, 1e-4):
        response = linear.response({"lean": size})(times)["lean"]
        start = {**linear.point, "lean": lean + size, "z": math.cos(lean + size)}
        start["x'"], start["y'"], start["z'"] = _rolling_speeds(start, 1)
        moved = fb.simulate(s, 3, initial=start, tolerance=1e-12, times=times)
        missed.append(np.abs(moved["lean"] - lean - response).max())
    assert math.log10(missed[0] / missed[1]) == pytest.approx(2, abs=0.1)
    assert np.abs(response).max() > 5e-4


def _rolling_speeds(q, r):
    """Velocity of the centre of a disk that rolls: ω × (from the contact to the centre)."""
    yaw, lean = q["yaw"], q["lean"]
    Z, X = np.array([0, 0, 1.0]), np.array([math.cos(yaw), math.sin(yaw), 0])
    Y = math.cos(lean) * np.array([-math.sin(yaw), math.cos(yaw), 0]) + math.sin(lean) * Z
    w = q["yaw'"] * Z + q["lean'"] * X + q["roll'"] * Y
    up = np.cross(X, Y)
    return np.cross(w, r * up)
