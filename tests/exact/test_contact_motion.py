"""Motion with contacts against closed forms: thresholds, events, bounces, impacts; the ledger and the momenta."""

import math

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError

G = 9.81


def bouncing(e, shape=None):
    s = fb.System("bouncing ball")
    (g, e_) = s.parameters(g=G, e=e)
    s.gravity = (0, -g, 0)
    ball = s.body("ball", fb.disk(2, 0.1))
    s.planar("rail", s.ground, ball, coordinate="x y turn")
    s.contact("floor", ball.circle(0.1), s.ground.plane(normal="y"), friction=0, restitution=e_)
    return s


def happened(motion, name):
    return [event for event in motion.events if event.name == name]


@pytest.mark.parametrize("e", [0.5, 0.8])
def test_bouncing_ball_every_bounce_and_the_end(e):
    # t_k = t_1 + 2 t_1 (e + ... + e^k); all over at t_1 (1 + e)/(1 - e); energy after bounce k is e^(2k) of the first
    motion = fb.simulate(bouncing(e), 6, initial={"y": 1.1, "x'": 0.5}, samples=1201)
    t1 = math.sqrt(2 / G)
    times = [event.time for event in happened(motion, "impact")]
    expected = t1 * (1 + 2 * np.cumsum([0, *(e**k for k in range(1, len(times)))]))
    np.testing.assert_allclose(times, expected, rtol=0, atol=1e-11)
    (rest,) = happened(motion, "rest")
    assert rest.time == pytest.approx(t1 * (1 + e) / (1 - e), abs=1e-11)
    for event in happened(motion, "impact")[:12]:
        # round-off of the energies themselves
        assert event.after["y'"] ** 2 == pytest.approx(e**2 * event.state["y'"] ** 2, rel=4e-16)
    contact = motion.contacts["floor"]
    assert contact.gap.min() >= -1e-15
    assert contact.normal[-1] == pytest.approx(2 * G, rel=1e-12)
    assert motion.energy.relative_residual < 1e-13
    assert motion.at(6)["x"] == pytest.approx(3.0, rel=1e-12)
    assert [m.mode for m in motion.modes] == ["open", "slip"]


@pytest.mark.parametrize("e", [0.5, 0.9])
def test_bounces_on_a_block_that_the_floor_carries(e):
    """Without contact forces both fall alike, and the ball would not return: the floor decides how high it flies."""
    s = fb.System("ball on a block")
    s.gravity = (0, -G, 0)
    block, ball = s.body("block", fb.box(2, (0.4, 0.1, 0.2))), s.body("ball", fb.disk(1, 0.1))
    s.planar("p", s.ground, block, coordinate="x y w")
    s.planar("q", s.ground, ball, coordinate="X Y W")
    feet = block.corners((-0.2, -0.05, 0), (0.2, -0.05, 0))
    s.contact("feet", feet, s.ground.plane(normal="y"), friction=0.3)
    top = block.plane(at=(0, 0.05, 0), normal="y")
    s.contact("top", ball.circle(0.1), top, friction=0.3, restitution=e)
    t1 = math.sqrt(2 * 0.2 / G)
    end = t1 * (1 + e) / (1 - e)
    motion = fb.simulate(s, end + 0.1, initial={"y": 0.05, "Y": 0.4})
    (rest,) = happened(motion, "rest")
    assert rest.time == pytest.approx(end, rel=1e-11)
    assert float(motion["Y"][-1]) == pytest.approx(0.2, abs=1e-12)


def test_bounces_of_a_foot_beside_one_that_carries():
    """The forces at the other foot turn the box back: flights have that acceleration, not that of free fall."""
    e, tilt = 0.3, 0.1
    s = fb.System("box on two feet")
    s.gravity = (0, -G, 0)
    box = s.body("box", fb.box(1, (0.2, 0.1, 0.1)))
    s.planar("p", s.ground, box, coordinate="x y w")
    feet = box.corners((-0.1, -0.05, 0), (0.1, -0.05, 0))
    s.contact("feet", feet, s.ground.plane(normal="y"), friction=0.3, restitution=e)
    start = {"w": tilt, "y": 0.05 * math.cos(tilt) + 0.1 * math.sin(tilt)}
    motion = fb.simulate(s, 0.2, initial=start)
    times = [event.time for event in happened(motion, "impact")]
    (rest,) = happened(motion, "rest")
    # the last flights are shorter by e each
    assert rest.time == pytest.approx(times[-1] + (times[-1] - times[-2]) * e / (1 - e), abs=1e-11)


def disk(friction, static=None, force=False):
    s = fb.System("disk")
    R, m, g, mu, F, h = s.parameters(R=0.3, m=10, g=G, mu=friction, F=30, h=0.4)
    s.gravity = (0, -g, 0)
    body = s.body("disk", fb.disk(m, R))
    s.planar("rail", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.circle(R), s.ground.plane(normal="y"), friction=mu, static_friction=static)
    if force:
        s.force("F", body.origin, (F, 0, 0))
        s.torque("tau", body, (0, 0, -F * (h - R)))
    return s


def test_pulled_disk_rolls_or_slips_by_its_threshold():
    # rolling: (3/2) m a = F h/R, H = F - m a = F (1 - 2h/(3R)); the threshold is |H| = mu m g
    s = disk(0.2, force=True)
    threshold = 0.2 * 10 * G / abs(1 - 2 * 0.4 / 0.9)
    for F in (30.0, threshold * (1 - 1e-9), threshold * (1 + 1e-9), 250.0):
        motion = fb.simulate(s, 1, initial={"y": 0.3}, values={"F": F})
        rolls = threshold > F
        assert motion.modes[-1].mode == ("stick" if rolls else motion.modes[-1].mode)
        assert (motion.modes[-1].mode == "stick") is rolls
        a = 2 * F * 0.4 / (3 * 10 * 0.3)
        if not rolls:
            H = math.copysign(0.2 * 10 * G, 1 - 0.8 / 0.9)
            a = (F - H) / 10
        assert motion.at(1)["x'"] == pytest.approx(a, rel=1e-10)
        assert motion.energy.relative_residual < 1e-12


def test_slipping_disk_begins_to_roll():
    # v0 - mu g t = R w = 2 mu g t: t = v0/(3 mu g), then v = 2 v0/3; heat m v0²/6
    motion = fb.simulate(disk(0.2), 3, initial={"y": 0.3, "x'": 3.0})
    (event,) = motion.events
    assert event.time == pytest.approx(3 / (3 * 0.2 * G), abs=1e-12)
    assert str(event) == "t = 0.509684 s: contact floor: slip + → stick, the slip stopped"
    assert motion.at(3)["x'"] == pytest.approx(2, rel=1e-12)
    assert motion.energy.friction[-1] == pytest.approx(-15, rel=1e-11)
    assert motion.energy.relative_residual < 1e-13
    assert np.abs(motion["x' + 0.3*turn'"][motion.t > 0.51]).max() < 1e-14


def test_friction_of_bounces_adds_up_to_that_of_the_weight():
    # the normal impulses up to any moment at rest sum to m g t, so the disk rolls when a disk that never bounced would
    s = disk(0.2)
    s2 = fb.System("bouncing disk")
    R, m, g, mu, e = s2.parameters(R=0.3, m=10, g=G, mu=0.2, e=0.3)
    s2.gravity = (0, -g, 0)
    body = s2.body("disk", fb.disk(m, R))
    s2.planar("rail", s2.ground, body, coordinate="x y turn")
    s2.contact("floor", body.circle(R), s2.ground.plane(normal="y"), friction=mu, restitution=e)
    rolls = fb.simulate(s, 1, initial={"y": 0.3, "x'": 3.0}).events[-1].time
    motion = fb.simulate(s2, 1, initial={"y": 0.45, "x'": 3.0})
    assert [event.name for event in motion.events].count("impact") > 5
    assert motion.events[-1].time == pytest.approx(rolls, abs=1e-12)
    assert motion.at(1)["x'"] == pytest.approx(2, rel=1e-12)
    assert motion.energy.relative_residual < 1e-13


def test_static_friction_holds_more_than_kinetic():
    s = fb.System("block")
    g, mu, mus, rate = s.parameters(g=G, mu=0.2, mus=0.3, rate=2.0)
    s.gravity = (0, -g, 0)
    body = s.body("block", fb.box(2, (1, 0.2, 1)))
    s.planar("rail", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.point(0, -0.1, 0), s.ground.plane(normal="y"), friction=mu, static_friction=mus)
    s.constrain("turn", name="upright")
    s.force("F", body.origin, (rate * s.t, 0, 0))
    motion = fb.simulate(s, 4, initial={"y": 0.1})
    (event,) = motion.events
    t = 0.3 * 2 * G / 2
    assert event.time == pytest.approx(t, abs=1e-12)
    assert "stick → slip +, |T| reached 5.886 N" in str(event)
    speed = (4**2 - t**2) / 2 - 0.2 * G * (4 - t)
    assert motion.at(4)["x'"] == pytest.approx(speed, rel=1e-11)
    assert motion.contacts["floor"].margin[0] == pytest.approx(5.886)


def ledge(mu):
    s = fb.System("disk on a ledge")
    g, R, m, mu_ = s.parameters(g=G, R=0.25, m=3, mu=mu)
    s.gravity = (0, -g, 0)
    body = s.body("disk", fb.disk(m, R))
    s.planar("rail", s.ground, body, coordinate="x y turn")
    s.contact("O", body.circle(R), s.ground.point(0, 0, 0), friction=mu_)
    return s


def test_disk_slips_off_a_ledge_where_friction_ends():
    # pivoting: w² = (4g/3R)(cos θ0 - cos θ), N = m g cos θ - m R w², T = m g sin θ/3
    mu, start = 0.5, 1e-3
    motion = fb.simulate(
        ledge(mu), 3, initial={"x": -0.25 * math.sin(start), "y": 0.25 * math.cos(start)}, tolerance=1e-12
    )
    slip = next(event for event in motion.events if "stick →" in str(event))
    theta = math.atan2(-slip.state["x"], slip.state["y"])
    N = math.cos(theta) - 4 / 3 * (math.cos(start) - math.cos(theta))
    assert math.sin(theta) / 3 == pytest.approx(mu * N, abs=1e-10)
    away = next(event for event in motion.events if "→ open" in str(event))
    assert "N reached 0" in str(away)
    assert away.time > slip.time
    after = motion.t > away.time
    assert np.allclose(np.diff(motion["turn'"][after]), 0, atol=1e-12)  # no force, no couple
    assert motion.energy.relative_residual < 1e-10


def test_falling_rod_slips_backward_or_forward_at_its_angle():
    # pivoting: N = m g (1 - 3 cos θ)²/4, T = (3/4) m g sin θ (3 cos θ - 2)
    L, start = 1.5, 1e-3
    s = fb.System("falling rod")
    g, mu = s.parameters(g=G, mu=0.3)
    s.gravity = (0, -g, 0)
    rod = s.body("rod", fb.slender_bar(2, L, axis="y"))
    s.planar("rail", s.ground, rod, coordinate="x y theta")
    s.contact("tip", rod.point(0, -L / 2, 0), s.ground.plane(normal="y"), friction=mu)
    first = {"y": L / 2 * math.cos(start), "x": -L / 2 * math.sin(start), "theta": start}
    for value, way in ((0.3, "slip +"), (0.5, "slip -")):
        motion = fb.simulate(
            s, 2.5, initial=first, values={"mu": value}, tolerance=1e-12,
            events=[fb.event("theta - pi/2", terminal=True)],
        )  # fmt: skip
        event = next(event for event in motion.events if "stick →" in str(event))
        k, k0 = math.cos(event.state["theta"]), math.cos(start)
        N = 1 - 3 / 4 * (1 - k**2) - 3 / 2 * k * (k0 - k)
        T = 3 / 4 * math.sin(event.state["theta"]) * k - 3 / 2 * math.sin(event.state["theta"]) * (k0 - k)
        assert abs(T) == pytest.approx(value * N, abs=1e-9)
        assert f"stick → {way}" in str(event)


@pytest.mark.parametrize("restitution", [0, 0.4])
def test_dropped_rod_impact_with_friction(restitution):
    # at the lower end, with s, c of the angle to the vertical: A = 1/m [[1 + 3 s², ∓3 s c], [., 1 + 3 c²]]
    theta, drop = math.radians(30), 0.5
    s = fb.System("dropped rod")
    g, mu, e = s.parameters(g=G, mu=0.2, e=restitution)
    s.gravity = (0, -g, 0)
    rod = s.body("rod", fb.slender_bar(1, 1, axis="y"))
    s.planar("rail", s.ground, rod, coordinate="x y theta")
    s.contact("tip", rod.point(0, -0.5, 0), s.ground.plane(normal="y"), friction=mu, restitution=e)
    motion = fb.simulate(s, 0.4, initial={"y": 0.5 * math.cos(theta) + drop, "theta": theta}, tolerance=1e-12)
    hit = happened(motion, "impact")[0]
    assert hit.time == pytest.approx(math.sqrt(2 * drop / G), abs=1e-12)
    v = math.sqrt(2 * drop * G)
    sn, cs = math.sin(theta), math.cos(theta)
    # velocity of the tip: x' + (cs/2) w, y' + (sn/2) w, with I = 1/12
    A = np.array([[1 + 3 * sn * sn, 3 * sn * cs], [3 * sn * cs, 1 + 3 * cs * cs]])
    normal = (1 + restitution) * v
    free = np.linalg.solve(A, [normal, 0])  # sticks if |T| <= mu N
    N, T = free
    if abs(T) > 0.2 * N:
        way = -math.copysign(1, T)
        N = normal / (A[0, 0] - 0.2 * way * A[0, 1])
        T = -0.2 * way * N
    assert hit.after["y'"] == pytest.approx(-v + N, rel=1e-12)
    assert hit.after["x'"] == pytest.approx(T, rel=1e-12)
    assert hit.after["theta'"] == pytest.approx(12 * (sn / 2 * N + cs / 2 * T), rel=1e-12)
    assert motion.energy.impulses[-1] < 0
    assert motion.energy.relative_residual < 1e-10


def test_rocking_block_loses_housners_part_at_each_impact_and_comes_to_rest():
    a, b, theta = 0.3, 1.0, 0.05
    s = fb.System("rocking block")
    (g,) = (s.parameters(g=G),)
    s.gravity = (0, -g, 0)
    block = s.body("block", fb.box(3, (a, b, 1)))
    s.planar("rail", s.ground, block, coordinate="x y theta")
    s.contact(
        "foot", block.corners((-a / 2, -b / 2, 0), (a / 2, -b / 2, 0)), s.ground.plane(normal="y"), friction=3
    )
    c, n = math.cos(-theta), math.sin(-theta)
    start = {"x": -(c * a / 2 + n * b / 2), "y": -(n * a / 2 - c * b / 2), "theta": -theta}
    motion = fb.simulate(s, 6, initial=start, tolerance=1e-11)
    speeds = [abs(event.state["theta'"]) for event in happened(motion, "impact")]
    ratio = 1 - 1.5 * b * b / (a * a + b * b) * (a * a / (b * b))  # 1 - (3/2) sin² α, tan α = a/b
    np.testing.assert_allclose(np.array(speeds[1:8]) / speeds[:7], ratio, rtol=1e-9)
    rest = happened(motion, "rest")
    assert rest
    # between impacts w0 = p² tan(α)... for small angles θ'' = const: flight 2 w/k, a geometric series
    k = 3 * G / (4 * math.hypot(a, b) / 2) * a / math.hypot(a, b)
    late = happened(motion, "impact")[-8]
    left = 2 * abs(late.after["theta'"]) / k / (1 - ratio)
    assert rest[-1].time - late.time == pytest.approx(left, rel=1e-3)
    assert abs(motion["theta'"][-1]) < 1e-15
    assert set(motion.indeterminate) == {"T_foot_1", "T_foot_2"}
    assert motion.energy.relative_residual < 1e-9
    assert min(one.gap.min() for one in motion.contacts.values()) > -1e-12


def test_block_on_an_incline_by_a_hair():
    mu = 0.4
    for part, sticks in ((1 - 1e-3, True), (1 + 1e-3, False)):
        angle = math.atan(mu) * part
        s = fb.System("incline")
        g, mu_ = s.parameters(g=G, mu=mu)
        s.gravity = (math.sin(angle) * g, -math.cos(angle) * g, 0)
        block = s.body("block", fb.box(2, (1, 0.2, 1)))
        s.planar("rail", s.ground, block, coordinate="x y theta")
        feet = block.corners((-0.5, -0.1, 0), (0.5, -0.1, 0))
        s.contact("foot", feet, s.ground.plane(normal="y"), friction=mu_)
        motion = fb.simulate(s, 10, initial={"y": 0.1})
        assert {m.mode for m in motion.modes} == ({"stick"} if sticks else {"slip+"})
        a = 0 if sticks else G * (math.sin(angle) - mu * math.cos(angle))
        assert motion.at(10)["x"] == pytest.approx(50 * a, rel=1e-10, abs=1e-12)
        N = sum(one.normal[-1] for one in motion.contacts.values())
        assert pytest.approx(2 * G * math.cos(angle), rel=1e-12) == N


def test_ball_in_space_slips_straight_and_then_rolls():
    # |v_slip| falls at (7/2) mu g whatever its direction; v = v0 - (2/7) slip0 when it rolls
    s = fb.System("bowling")
    g, r, mu = s.parameters(g=G, r=0.1, mu=0.2)
    s.gravity = (0, 0, -g)
    ball = s.body("ball", fb.sphere(5, r))
    s.free("f", s.ground, ball)
    s.contact("lane", ball.sphere(r), s.ground.plane(normal="z"), friction=mu)
    motion = fb.simulate(s, 1, initial={"f_z": 0.1, "f_vx": 3.0, "f_wx": 10.0}, tolerance=1e-12)
    slip = np.array([3.0, 1.0])  # v + w × (-r n)
    (event,) = motion.events
    assert event.time == pytest.approx(np.linalg.norm(slip) / (3.5 * 0.2 * G), abs=1e-9)
    momentum = motion.poses["ball"].position[-1] - motion.poses["ball"].position[-2]
    v = momentum / (motion.t[-1] - motion.t[-2])
    np.testing.assert_allclose(v, [3 - 2 / 7 * 3, -2 / 7 * 1, 0], atol=1e-9)
    assert motion.energy.relative_residual < 1e-10
    assert np.abs(motion.contacts["lane"].gap).max() < 1e-14


def test_balls_in_a_row_keep_their_momentum_in_both_orders():
    s = fb.System("cradle")
    bodies = []
    for i in range(3):
        body = s.body(f"ball{i}", fb.particle(1))
        s.slider(f"rail{i}", s.ground, body, axis="x", coordinate=f"x{i}")
        bodies.append(body)
    for i in range(2):
        s.contact(f"c{i}", bodies[i + 1].sphere(0.1), bodies[i].sphere(0.1), friction=0, restitution=1)
    start = {"x0": -1, "x1": 0, "x2": 0.2, "x0'": 1}
    for order, after in (("sequential", [0, 0, 1]), ("simultaneous", [-1 / 3, 2 / 3, 2 / 3])):
        motion = fb.simulate(s, 2, initial=start, impacts=order)
        np.testing.assert_allclose(motion.at(2).u[:3], after, atol=1e-14)
        assert motion.events[0].time == pytest.approx(0.8, abs=1e-14)


def leaning(mu, spin):
    theta = math.radians(35)
    s = fb.System("leaning rod")
    g, mu_ = s.parameters(g=G, mu=mu)
    s.gravity = (0, -g, 0)
    rod = s.body("rod", fb.slender_bar(1, 1, axis="y"))
    s.planar("rail", s.ground, rod, coordinate="x y theta")
    s.contact("tip", rod.point(0, -0.5, 0), s.ground.plane(normal="y"), friction=mu_)
    k, n = math.cos(theta), math.sin(theta)
    start = {"theta": theta, "y": k / 2, "theta'": spin, "y'": -n / 2 * spin, "x'": 3 - k / 2 * spin}
    return fb.simulate(s, 1, initial=start)


def test_painleve_is_reported_with_configuration_and_criterion():
    n, k = math.sin(math.radians(35)), math.cos(math.radians(35))
    criterion = f"{1 + 3 * n * n - 2 * 3 * n * k:.6g}"
    with pytest.raises(SimulationError, match="no set of modes is consistent") as error:
        leaning(2.0, 0.0)
    assert f"tip: A_NN - mu d.A_NT = {criterion} 1/kg" in str(error.value)
    assert "theta = 0.610865" in str(error.value)
    with pytest.raises(
        SimulationError, match=r"different motions are consistent, \(tip: open\) or \(tip: slip\)"
    ):
        leaning(2.0, 6.0)


def test_momentum_of_a_falling_box_balances_its_contact_forces():
    s = fb.System("box")
    g, mu = s.parameters(g=G, mu=0.3)
    s.gravity = (0, -g, 0)
    body = s.body("box", fb.box(2, (0.4, 0.2, 1)))
    s.planar("rail", s.ground, body, coordinate="x y theta")
    s.contact(
        "floor", body.corners(size=(0.4, 0.2)), s.ground.plane(normal="y"), friction=mu, restitution=0.2
    )
    motion = fb.simulate(s, 2, initial={"y": 0.3, "theta": 0.4, "x'": 1.0}, samples=20001)
    # after the last impact: ∫ΣN - m g = m Δy', ∫ΣT = m Δx' by Simpson's rule
    last = happened(motion, "impact")[-1].time
    late = motion.t > max(last, motion.modes[-1].start) + 1e-6
    N = sum(one.least[late, 0] for one in motion.contacts.values())
    assert pytest.approx(2 * G, rel=1e-9) == N
    assert motion["x'"][late] == pytest.approx(0, abs=1e-12)
    assert motion.energy.relative_residual < 1e-9
    assert min(one.gap.min() for one in motion.contacts.values()) > -1e-12
    lost = motion.energy.impulses[-1] + motion.energy.friction[-1]
    height = 2 * G * (motion["y"][0] - motion["y"][-1])
    assert lost == pytest.approx(-(1 + height), rel=1e-9)


def test_refusals_of_contact():
    s = disk(0.2)
    with pytest.raises(SimulationError, match=r"contact 'floor' 0\.1 m deep"):
        fb.simulate(s, 1, initial={"y": 0.2})
    with pytest.raises(SimulationError, match="no way back"):
        fb.simulate(s, -1, initial={"y": 0.3})
    with pytest.raises(SimulationError, match="friction of contact 'floor' of at least 0, got -1"):
        fb.simulate(s, 1, initial={"y": 0.3}, values={"mu": -1})
    with pytest.raises(SimulationError, match="restitution of contact 'floor' from 0"):
        fb.simulate(bouncing(0.5), 1, initial={"y": 1}, values={"e": 1.5})
    with pytest.raises(SimulationError, match="Unknown order of impacts"):
        fb.simulate(s, 1, initial={"y": 0.3}, impacts="at once")
    with pytest.raises(SimulationError, match="Unknown contact 'flor'; did you mean 'floor'"):
        fb.simulate(s, 1, initial={"y": 0.3}).contacts["flor"]
    with pytest.raises(
        SimulationError, match='got step=0.001. Steps of one length are those of method="timestepping"'
    ):
        fb.simulate(s, 1, initial={"y": 0.3}, step=1e-3)
    with pytest.raises(SimulationError, match="time of 'late' within the run, 0 to 1 s, got 2 s"):
        fb.simulate(s, 1, initial={"y": 0.3}, impulses=[fb.blow(2, impulse=(1, 0, 0), name="late")])


def test_newtons_law_that_would_make_energy_has_less_restitution():
    # Kane: the rod of the block of test_painleve, steep, whose slip is reversed by the impact
    s = fb.System("block")
    g, mu, e = s.parameters(g=G, mu=1.0, e=0.9)
    s.gravity = (0, -g, 0)
    body = s.body("block", fb.box(3, (0.3, 0.5, 1)))
    s.planar("rail", s.ground, body, coordinate="x y theta")
    s.contact("foot", body.corners(size=(0.3, 0.5)), s.ground.plane(normal="y"), friction=mu, restitution=e)
    start = {"y": 1.0, "theta": 2.782025237069825, "x'": 0.5087762330352346, "theta'": 4.898587870142929}
    motion = fb.simulate(s, 1, initial=start)
    assert any("restitution reduced to" in str(event) for event in motion.events)
    assert np.diff(motion.energy.impulses).max() <= 1e-12 * motion.energy.total[0]


def test_four_legs_on_a_floor_are_indeterminate_and_said_to_be():
    s = fb.System("table")
    g, mu = s.parameters(g=G, mu=0.3)
    s.gravity = (0, 0, -g)
    table = s.body("table", fb.box(2, (0.4, 0.3, 0.2)))
    s.free("f", s.ground, table)
    places = [(x, y, -0.1) for x, y in ((-0.2, -0.15), (0.2, -0.15), (0.2, 0.15), (-0.2, 0.15))]
    s.contact("leg", table.corners(*places), s.ground.plane(normal="z"), friction=mu)
    motion = fb.simulate(s, 1, initial={"f_z": 0.1, "f_vx": 2.0})
    t = 2 / (0.3 * G)
    assert {m.mode for m in motion.modes} == {"slip", "stick"}
    assert all(event.time == pytest.approx(t, abs=1e-9) for event in motion.events)
    assert motion["f_x"][-1] == pytest.approx(t, rel=1e-9)
    for k in range(1, 5):
        assert {f"N_leg_{k}", f"T1_leg_{k}", f"T2_leg_{k}"} <= set(motion.indeterminate)
        one = motion.contacts[f"leg_{k}"]
        assert np.isnan(one.normal).all()  # not said to be known
        assert one.least[-1, 0] == pytest.approx(2 * G / 4, rel=1e-9)  # least in norm, by name
    assert sum(one.least[0, 0] for one in motion.contacts.values()) == pytest.approx(2 * G)
    with pytest.raises(SimulationError, match="are statically indeterminate, and each distribution moves"):
        fb.simulate(s, 1, initial={"f_z": 0.1, "f_vx": 2.0, "f_wz": 5.0}, indeterminate="refuse")


def test_blows_on_a_disk_that_rolls():
    s = disk(0.2)
    body = s.bodies["disk"]
    blows = [
        fb.blow(0.5, at=body.origin, impulse=(20, 0, 0), name="kick"),
        fb.blow(1.5, at=body.origin, impulse=(0, 5, 0), name="lift"),
        fb.blow("x - 2", at=body.origin, impulse=(-3, -1, 0), name="wall", count=1),
    ]
    motion = fb.simulate(s, 3, initial={"y": 0.3}, impulses=blows)
    # the kick: v = 2 and no spin, then slip for v/(3 mu g), after which 2/3 of v is left
    first, second = motion.modes[1:3]
    assert (first.mode, first.start, first.why) == ("slip+", 0.5, "a blow")
    assert second.start == pytest.approx(0.5 + 2 / (3 * 0.2 * G), abs=1e-12)
    assert motion.at(1.2)["x'"] == pytest.approx(4 / 3, rel=1e-12)
    # the lift: a throw of 2 v/g
    landing = [m for m in motion.modes if m.start > 1.5 and m.why == "the gap closed"][0]
    assert landing.start == pytest.approx(1.5 + 2 * 0.5 / G, abs=1e-12)
    # the wall: down with 0.1, which the floor takes up at once, and back by 0.3, two thirds of which are kept
    strike = happened(motion, "wall")[0]
    assert strike.state["x"] == pytest.approx(2, abs=1e-12)
    assert [e.name for e in motion.events if e.time == strike.time][:2] == ["wall", "impact"]
    assert motion.at(3)["x'"] == pytest.approx(4 / 3 - 2 / 3 * 0.3, rel=1e-11)
    assert motion.energy.relative_residual < 1e-13
    last = fb.simulate(s, 0.5, initial={"y": 0.3}, impulses=blows[:1])
    assert last.at(0.5)["x'"] == pytest.approx(2)


@pytest.mark.parametrize("mu", [1e10, 1e12])
def test_a_disk_that_does_not_slip_leaves_a_ledge_at_the_angle_of_no_slip(mu):
    # 3/4 m R² w² = m g R (1 - cos), N = m g cos - m R w² = 0: cos = 4/7, which finite friction exceeds by some 1/mu
    R, first = 0.25, 0.05
    s = fb.System("ledge")
    s.gravity = (0, -G, 0)
    body = s.body("disk", fb.disk(3, R))
    s.planar("plane", s.ground, body, to=(0, -R, 0), coordinate="x y theta")
    s.contact("O", body.circle(R), s.ground.point(0, 0, 0), friction=mu)
    start = {"theta": first, "theta'": math.sqrt(4 * G / (3 * R) * (1 - math.cos(first)))}
    motion = fb.simulate(s, 0.7, initial=start, tolerance=1e-13)
    assert [m.mode for m in motion.modes] == ["stick", "slip-", "open"]
    gone = motion.events[-1].state
    angle = math.atan2(R * math.sin(gone["theta"]) - gone["x"], R * math.cos(gone["theta"]) + gone["y"])
    assert math.cos(angle) == pytest.approx(4 / 7, abs=0.02 / mu + 1e-13)
    assert gone["theta'"] == pytest.approx(math.sqrt(4 * G / (7 * R)), rel=0.1 / mu + 1e-12)
