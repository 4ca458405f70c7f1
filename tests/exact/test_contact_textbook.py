"""Contacts of the chapter: answers derived from models in contact modes, against closed forms derived by hand.

Examples 6.1, 6.3, 6.4, Problems 6.1 to 6.3 and 6.7 to 6.11; all answers are formulas, so that only round-off is left.
"""

import math

import pytest
import sympy

import freebody as fb
from freebody.describe.description import names_of, parameters_of

CLOSE = 1e-12
"""Evaluation of short formulas in doubles."""

LEVEL = {"theta": 0, "theta'": 0}
CENTRED = {"x": 0, "y": 0, "x'": 0, "y'": 0}


def value(expression, system, **further):
    """A number from an answer, at the defaults of the parameters and further values by name."""
    named = {p.symbol: p.default for p in parameters_of(system)}
    for name, number in further.items():
        named[names_of(system).atoms.get(name.replace("_rate", "'"), sympy.Symbol(name, real=True))] = number
    order = sorted(named, key=lambda atom: not atom.is_Derivative)
    return float(sympy.sympify(expression).subs([(atom, named[atom]) for atom in order]))


def machine(name, **parameters):
    s = fb.System(name)
    symbols = s.parameters(**parameters, g=9.81)
    s.gravity = (0, -symbols[-1], 0)
    return s, symbols


# --- Example 6.1 ---------------------------------------------------------------------------------


def box_on_feet():
    s, (m, L, H, D, mu, beta, F, _) = machine(
        "sliding body", m=50, L=1.2, H=0.8, D=0.15, mu=0.25, beta="20deg", F=200
    )
    body = s.body("body", fb.box(m, (L, H, 1)))
    s.planar("plane", s.ground, body, coordinate="x y theta")
    foot = -(H / 2 + D)
    s.contact("A", body.point(-L / 2, foot, 0), s.ground.plane(), friction=mu)
    s.contact("B", body.point(L / 2, foot, 0), s.ground.plane(), friction=mu)
    s.force("F", body.point(-L / 2, H / 2, 0), (F * sympy.cos(beta), F * sympy.sin(beta), 0))
    return s, fb.equations(s, modes={"A": "slip+", "B": "slip+"})


def test_sliding_body_and_the_force_that_tips_it():
    s, e = box_on_feet()
    exact = fb.exact.sliding_body(50, 1.2, 0.8, 0.15, 0.25, math.radians(20), 200)
    found = e.solve(["x''", "N_A", "N_B"], where=LEVEL)
    assert value(found["x''"], s) == pytest.approx(exact.acceleration, rel=CLOSE)
    assert value(found["N_A"], s) == pytest.approx(exact.normal_A, rel=CLOSE)
    assert value(found["N_B"], s) == pytest.approx(exact.normal_B, rel=CLOSE)
    tipping = e.solve(["F", "x''", "N_B"], where={**LEVEL, "N_A": 0})
    assert value(tipping["F"], s) == pytest.approx(exact.force_tip, rel=CLOSE)
    assert value(tipping["x''"], s) == pytest.approx(exact.acceleration_tip, rel=CLOSE)
    assert value(tipping["N_B"], s) == pytest.approx(exact.normal_tip, rel=CLOSE)


# --- Example 6.3 ---------------------------------------------------------------------------------


def pulled_disk():
    s, (m, R, h, mu, F, _) = machine("pulled disk", m=10, R=0.3, h=0.4, mu=0.2, F=30)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, coordinate="x y phi")
    s.contact("floor", disk.circle(R), s.ground.plane(), friction=mu)
    # the line of action is at the height h, wherever the disk has turned to
    s.force("F", disk.origin, (F, 0, 0))
    s.torque("F_moved", disk, (0, 0, -F * (h - R)))
    return s


@pytest.mark.parametrize("force", [30, 250])
def test_pulled_disk_rolls_or_slips(force):
    s = pulled_disk()
    exact = fb.exact.pulled_disk(10, 0.3, 0.4, 0.2, force)
    limit = fb.equations(s, modes={"floor": "stick"}).solve("F", where="T_floor = -mu*N_floor")
    assert value(limit["F"], s) == pytest.approx(exact.force_limit, rel=CLOSE)
    assert exact.rolls == (force <= exact.force_limit)
    mode = "stick" if exact.rolls else "slip+"
    unknowns = ["x''", "phi''", "N_floor", "T_floor"]
    found = fb.equations(s, modes={"floor": mode}).solve(unknowns)
    assert value(found["x''"], s, F=force) == pytest.approx(exact.acceleration, rel=CLOSE)
    assert value(found["phi''"], s, F=force) == pytest.approx(exact.alpha, rel=CLOSE)
    assert value(found["N_floor"], s) == pytest.approx(10 * 9.81, rel=CLOSE)
    assert value(found["T_floor"], s, F=force) == pytest.approx(-exact.friction, rel=CLOSE)


# --- Example 6.4 ---------------------------------------------------------------------------------


def test_disk_rolling_down():
    s, (m, R, beta, _) = machine("disk on a slope", m=5, R=0.25, beta="30deg")
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, coordinate="x y phi")
    slope = s.ground.plane(normal=(sympy.sin(beta), sympy.cos(beta), 0))
    s.contact("slope", disk.circle(R), slope, friction=1)
    e = fb.equations(s, modes={"slope": "stick"})
    found = e.solve(["x''", "y''", "phi''", "N_slope", "T_slope"])
    exact = fb.exact.rolling_down(5, 0.25, 2.0, math.radians(30))
    a = math.hypot(value(found["x''"], s), value(found["y''"], s))
    assert a == pytest.approx(exact.acceleration, rel=CLOSE)
    assert value(found["N_slope"], s) == pytest.approx(exact.normal, rel=CLOSE)
    # t points down the slope
    assert value(found["T_slope"], s) == pytest.approx(-exact.friction, rel=CLOSE)
    # from rest along s = H / sin β: v² = 2 a s
    speed = math.sqrt(2 * a * 2.0 / math.sin(math.radians(30)))
    assert speed == pytest.approx(exact.speed, rel=CLOSE)
    assert value(found["phi''"], s) / a * speed == pytest.approx(exact.omega, rel=CLOSE)
    (energy,) = e.integrals
    assert energy.name == "energy"


# --- Problems 6.1, 6.2, 6.3 ----------------------------------------------------------------------


def test_board_on_a_truck():
    s, (m, length, mu, a, _) = machine("board", m=20, length=2.5, mu=0.3, a=1)
    truck, board = s.body("truck", fb.particle(1)), s.body("board", fb.slender_bar(m, length))
    s.slider("road", s.ground, truck, axis="x", coordinate=a * s.t**2 / 2)
    s.planar("plane", truck, board, coordinate="x y beta")
    s.contact("floor", board.point(-length / 2, 0, 0), truck.plane(), friction=mu)
    s.contact("wall", board.point(length / 2, 0, 0), truck.plane(normal="-x"))
    e = fb.equations(s, modes={"floor": "stick", "wall": "slip"})
    rest = {"beta'": 0, "x'": 0, "y'": 0}
    beta = math.radians(70)
    exact = fb.exact.leaning_board(0.3, beta)
    slide = e.solve("a", where=[rest, "T_floor = mu*N_floor"])["a"]
    tip = e.solve("a", where={**rest, "N_wall": 0})["a"]
    assert value(slide, s, beta=beta) == pytest.approx(exact.slide, rel=CLOSE)
    assert value(tip, s, beta=beta) == pytest.approx(exact.tip, rel=CLOSE)
    # one grows with the angle and the other falls: both at once is the best
    best = [
        b
        for b in e.solve(["a", "beta"], where=[{**rest, "N_wall": 0}, "T_floor = mu*N_floor"]).branches
        if 0 < value(b["beta"], s) < math.pi / 2
    ]
    assert [value(b["a"], s) for b in best] == pytest.approx([exact.largest], rel=CLOSE)
    assert [value(b["beta"], s) for b in best] == pytest.approx([exact.angle], rel=CLOSE)


def test_braking_car():
    s, (m, lf, lr, h, mu, _) = machine("car", m=1500, lf=1.2, lr=1.6, h=0.5, mu=0.1)
    car = s.body("car", fb.box(m, (4, 1, 2)))
    s.planar("plane", s.ground, car, coordinate="x y theta")
    s.contact("front", car.point(lf, -h, 0), s.ground.plane(), friction=mu)
    s.contact("rear", car.point(-lr, -h, 0), s.ground.plane(), friction=mu)
    e = fb.equations(s, modes={"front": "slip+", "rear": "slip+"})
    found = e.solve(["mu", "N_front", "N_rear"], where={**LEVEL, "x''": -6})
    exact = fb.exact.braking_car(1500, 1.2, 1.6, 0.5, 6)
    assert value(found["mu"], s) == pytest.approx(exact.mu, rel=CLOSE)
    assert value(found["N_front"], s) == pytest.approx(exact.normal_front, rel=CLOSE)
    assert value(found["N_rear"], s) == pytest.approx(exact.normal_rear, rel=CLOSE)


def test_monorail_car():
    loads, accelerations = {}, {}
    exact = fb.exact.monorail_car(2000, 4, 1.5, 0.5)
    for driven in ("front", "rear"):
        s, (m, span, h, mu, _) = machine("monorail", m=2000, span=4, h=1.5, mu=0.5)
        car = s.body("car", fb.box(m, (4, 1, 2)))
        s.planar("plane", s.ground, car, coordinate="x y theta")
        for name, side in (("front", 1), ("rear", -1)):
            at = car.point(side * span / 2, h, 0)
            s.contact(name, at, s.ground.plane(), friction=mu if name == driven else 0)
        # the driven wheel at its limit: its rim would slip backwards
        modes = {name: "slip-" if name == driven else "slip" for name in ("front", "rear")}
        found = fb.equations(s, modes=modes).solve(["x''", "N_front", "N_rear"], where=LEVEL)
        accelerations[driven] = value(found["x''"], s)
        loads[driven] = [value(found[f"N_{name}"], s) for name in ("front", "rear")]
    assert accelerations["front"] == pytest.approx(exact.front_driven, rel=CLOSE)
    assert accelerations["rear"] == pytest.approx(exact.rear_driven, rel=CLOSE)
    assert max(accelerations, key=accelerations.__getitem__) == exact.better
    assert loads[exact.better] == pytest.approx([exact.normal_front, exact.normal_rear], rel=CLOSE)


# --- Problems 6.7 to 6.11 ------------------------------------------------------------------------


def test_bar_in_a_smooth_cylinder():
    """Coordinates are those of the point of the bar's plane that stays on the cylinder's axis."""
    s, (m, R, _) = machine("bar in a cylinder", m=2, R=1)
    h = R / sympy.sqrt(2)
    bar = s.body("bar", fb.slender_bar(m, sympy.sqrt(2) * R).moved((0, -h, 0)))
    s.planar("plane", s.ground, bar, coordinate="x y theta")
    side = bar.segment((-h, -h, 0), (h, -h, 0), normal="-y")
    s.contact("wall", side, s.ground.circle(R, inside=True))
    e = fb.equations(s, modes={"wall": "slip"})
    found = e.solve(["theta''", "N_wall_1", "N_wall_2"], where=CENTRED)
    theta = math.radians(20)
    exact = fb.exact.bar_in_cylinder(2, 1, math.radians(60), theta)
    at = {"theta": theta, "theta_rate": exact.rate}
    assert value(found["theta''"], s, **at) == pytest.approx(exact.alpha, rel=CLOSE)
    # element 1 is the end that leads on the left, A; the other is B
    assert value(found["N_wall_1"], s, **at) == pytest.approx(exact.normal_A, rel=CLOSE)
    assert value(found["N_wall_2"], s, **at) == pytest.approx(exact.normal_B, rel=CLOSE)
    stiffness = -sympy.diff(found["theta''"], s.expression("theta"))
    assert math.sqrt(value(stiffness, s, theta=0)) == pytest.approx(exact.frequency, rel=CLOSE)


def test_disk_off_a_ledge():
    s, (m, R, _) = machine("disk on a corner", m=3, R=0.25)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, to=(0, -R, 0), coordinate="x y theta")
    s.contact("O", disk.circle(R), s.ground.point(0, 0, 0), friction=1)
    e = fb.equations(s, modes={"O": "stick"})
    exact = fb.exact.disk_off_ledge(3, 0.25)
    energy = "theta'^2 = 4*g*(1 - cos(theta))/(3*R)"
    leaving = e.solve(["theta", "theta'^2"], where=[{**CENTRED, "N_O": 0}, energy])
    angles = [value(b["theta"], s) for b in leaving.branches]
    assert max(angles) == pytest.approx(exact.theta, rel=CLOSE)
    assert min(angles) == pytest.approx(-exact.theta, rel=CLOSE)
    assert math.sqrt(value(leaving.branches[0]["theta'^2"], s)) == pytest.approx(exact.omega, rel=CLOSE)
    found = e.solve(["theta''", "N_O", "T_O"], where=CENTRED)
    at = {"theta": exact.theta, "theta_rate": exact.omega}
    assert value(found["theta''"], s, **at) == pytest.approx(exact.alpha, rel=CLOSE)
    assert value(found["N_O"], s, **at) == pytest.approx(0, abs=1e-13 * 3 * 9.81)
    assert value(found["T_O"], s, **at) == pytest.approx(exact.friction, rel=CLOSE)
    free = fb.equations(s, modes={"O": "open"}).solve("theta''", where={"theta'": exact.omega})
    assert value(free["theta''"], s) == exact.alpha_after


@pytest.mark.parametrize("b", [0.3, 0.0])
def test_bar_on_a_ledge(b):
    s, (m, L, b_, mu, _) = machine("bar on a ledge", m=2, L=1.2, b=b, mu=0.4)
    bar = s.body("bar", fb.slender_bar(m, L))
    s.planar("plane", s.ground, bar, to=(b_ - L / 2, 0, 0), coordinate="x y phi")
    side = bar.segment((-L / 2, 0, 0), (L / 2, 0, 0), normal="-y")
    s.contact("O", side, s.ground.point(0, 0, 0), friction=mu)
    e = fb.equations(s, modes={"O": "stick"})
    found = e.solve(["phi''", "N_O", "T_O"], where=CENTRED)
    exact = fb.exact.bar_on_ledge(2, 1.2, b, 0.4)
    at = {"phi": -exact.theta, "phi_rate": -exact.omega}
    normal, friction = value(found["N_O"], s, **at), value(found["T_O"], s, **at)
    assert normal == pytest.approx(exact.normal, rel=CLOSE)
    # t points down along the bar
    assert friction == pytest.approx(-exact.friction, rel=CLOSE)
    assert abs(friction) == pytest.approx(0.4 * normal, rel=CLOSE)


def test_disk_in_a_rough_cylinder():
    s, (m, R, r, _) = machine("disk in a cylinder", m=1.5, R=1, r=0.2)
    s.assume(R - r > 0)
    disk = s.body("disk", fb.disk(m, r))
    s.planar("plane", s.ground, disk, coordinate="x y phi")
    s.contact("wall", disk.circle(r), s.ground.circle(R, inside=True), friction=1)
    s.parameters(theta=0, omega=0)
    e = fb.equations(s, modes={"wall": "stick"})
    place = {
        "x": "(R - r)*sin(theta)",
        "y": "-(R - r)*cos(theta)",
        "x'": "(R - r)*cos(theta)*omega",
        "y'": "(R - r)*sin(theta)*omega",
    }
    found = e.solve(["x''", "phi''", "N_wall", "T_wall"], where=place)
    theta = math.radians(20)
    exact = fb.exact.disk_in_cylinder(1.5, 1, 0.2, math.radians(50), theta)
    at = {"theta": theta, "omega": exact.rate}
    assert value(found["N_wall"], s, **at) == pytest.approx(exact.normal, rel=CLOSE)
    assert abs(value(found["T_wall"], s, **at)) == pytest.approx(exact.friction, rel=CLOSE)
    # rolling: (R - r) θ'' = -r φ''
    assert -0.2 / 0.8 * value(found["phi''"], s, **at) == pytest.approx(exact.alpha, rel=CLOSE)
    # small rolling about the lowest point, beside the free choice of phi
    linear = fb.linearize(e.model, about={"x": 0, "y": -0.8, "phi": 0}, values={})
    still, frequency = linear.natural_frequencies()
    assert still == pytest.approx(0, abs=1e-6)
    assert frequency == pytest.approx(exact.frequency, rel=1e-12)
    along = 0.8 * (math.cos(theta) * exact.alpha - math.sin(theta) * exact.rate**2)
    assert value(found["x''"], s, **at) == pytest.approx(along, rel=CLOSE)


def test_falling_bar():
    s, (m, L, _) = machine("falling bar", m=2, L=1.5)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.planar("plane", s.ground, bar, to=(0, -L / 2, 0), coordinate="x y theta")
    s.contact("floor", bar.point(0, -L / 2, 0), s.ground.plane(), friction=1)
    e = fb.equations(s, modes={"floor": "stick"})
    found = e.solve(["theta''", "N_floor", "T_floor"], where=CENTRED)
    exact = fb.exact.falling_bar(2, 1.5, math.radians(60))
    # it falls to the right, clockwise
    at = {"theta": -math.pi / 6, "theta_rate": -exact.omega}
    normal, friction = value(found["N_floor"], s, **at), value(found["T_floor"], s, **at)
    assert normal == pytest.approx(exact.normal, rel=CLOSE)
    assert friction == pytest.approx(exact.friction, rel=CLOSE)
    assert friction / normal == pytest.approx(exact.mu, rel=CLOSE)
    # T/N over the fall, with the energy put in, is largest at the limit
    c, rate = sympy.Symbol("c"), s.expression("theta'")
    theta, g = s.expression("theta"), 9.81
    fall = {rate**2: 3 * g * (1 - c) / 1.5, sympy.cos(theta): c, sympy.sin(theta): -sympy.sqrt(1 - c**2)}
    numbers = {p.symbol: p.default for p in parameters_of(s)}
    N_c, T_c = (found[x].subs(numbers).subs(fall) for x in ("N_floor", "T_floor"))
    best = math.cos(exact.theta_limit)
    assert float((T_c / N_c).subs(c, best)) == pytest.approx(exact.mu_limit, rel=CLOSE)
    assert float(sympy.diff(T_c / N_c, c).subs(c, best)) == pytest.approx(0, abs=1e-11)


def test_the_paradox_of_painleve():
    """A rod that slides on its lower end: N = m (g - ...)/(1 + 3 cos θ (cos θ - μ sin θ)), in doubt from μ = 4/3.

    Source: Génot & Brogliato, European Journal of Mechanics A 18 (1999) 653-677 (uniform rod).
    """
    s, (m, L, mu, _) = machine("sliding rod", m=1, L=2, mu=0.5)
    rod = s.body("rod", fb.slender_bar(m, L, axis="x"))
    s.planar("plane", s.ground, rod, coordinate="x y theta")
    s.contact("floor", rod.point(-L / 2, 0, 0), s.ground.plane(), friction=mu)
    e = fb.equations(s, modes={"floor": "slip-"})
    N = e.solve("N_floor")["N_floor"]
    theta, rate = s.expression("theta"), s.expression("theta'")
    c, sn = sympy.cos(theta), sympy.sin(theta)
    g = s.expression("g")
    # the end slips to the left: about C, the moment of friction is against that of N
    expected = m * (g - L / 2 * rate**2 * sn) / (1 + 3 * c * (c - mu * sn))
    at = {theta: 0.7, rate: 1.1, m: 1.0, L: 2.0, mu: 0.5, g: 9.81}
    assert float(N.subs(at)) == pytest.approx(float(expected.subs(at)), rel=CLOSE)
    # the denominator, 5/2 + 3/2 (cos 2θ - μ sin 2θ), reaches zero first at μ = 4/3
    _, denominator = sympy.fraction(sympy.together(N))
    of = sympy.lambdify((theta, mu), denominator.subs({m: 1, L: 2, g: 9.81}))
    fall = [of(k / 1000, 1.33) * of(0, 1.33) for k in range(1571)]
    assert min(fall) > 0
    assert min(of(k / 1000, 1.34) * of(0, 1.34) for k in range(1571)) < 0
