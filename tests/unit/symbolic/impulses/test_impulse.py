"""Impulses: balances of momentum and energy of every body, exact and numeric, free and constrained."""

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.dynamics import float_state
from freebody.dynamics.kinematics import angular_velocity, point_position, point_velocity, rotation
from freebody.errors import ModelError, SimulationError
from freebody.testing import random_state, random_system

EPS = np.finfo(float).eps


def hanging_bar():
    s = fb.System("hanging bar")
    m, L, J, h = s.parameters(m=2, L=1.2, J=1, h=0.8)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), coordinate="theta")
    return s, bar, (m, L, J, h)


def double_pendulum():
    s = fb.System("double pendulum")
    m, L, J = s.parameters(m=2, L=1.5, J=1)
    A, B = s.body("A", fb.slender_bar(m, L, axis="y")), s.body("B", fb.slender_bar(m, L, axis="y"))
    s.hinge("O", s.ground, A, to=(0, L / 2, 0), coordinate="q1")
    s.hinge("K", A, B, at=(0, -L / 2, 0), to=(0, L / 2, 0), coordinate="q2")
    return s, (m, L, J)


def four_bar():
    s = fb.System("four-bar")
    crank, rod, rocker = (
        s.body(n, fb.slender_bar(1, L)) for n, L in (("crank", 1), ("rod", 2), ("rocker", 1.5))
    )
    s.hinge("A", s.ground, crank, to=(-0.5, 0, 0), coordinate="a")
    s.hinge("B", crank, rod, at=(0.5, 0, 0), to=(-1, 0, 0), coordinate="b")
    s.hinge("D", s.ground, rocker, at=(2, 0, 0), to=(-0.75, 0, 0), coordinate="d")
    s.hinge("C", rocker, rod, at=(0.75, 0, 0), to=(1, 0, 0))
    return s


def start(model, q, u):
    return dict(zip((*model.coordinate_names, *model.speed_names), [*q, *u], strict=True))


def vector(v):
    return np.array([float(x) for x in v])


def check_bodies(s, hit, blows):
    """m Δv_C and ΔH_C of every body are the impulses on it; ``blows`` are (point, impulse, moment) in ground axes."""
    model = hit.model
    before, after = hit._state, hit._reached
    largest = max([1.0, *(abs(float(x)) for r in hit.reactions.values() for x in (*r.impulse, *r.moment))])
    for name, body in s.bodies.items():
        place = model.bodies[name]
        m = float(before(place.mass))
        c = vector(point_position(model, before, body.center))
        R = np.array(rotation(model, before, place.link), dtype=float)
        inertia = R @ np.array(before.matrix(place.inertia), dtype=float) @ R.T
        dv = vector(point_velocity(model, after, body.center)) - vector(
            point_velocity(model, before, body.center)
        )
        dw = vector(angular_velocity(model, after, body)) - vector(angular_velocity(model, before, body))
        force, moment = -m * dv, -inertia @ dw
        for point, P, n in blows:
            if point.body is body:
                force += P
                moment += n + np.cross(vector(point_position(model, before, point)) - c, P)
        for reaction in hit.reactions.values():
            joint = s.joints[reaction.joint]
            for sign, end in ((1, joint.child), (-1, joint.parent)):
                if end is body:
                    at = vector(point_position(model, before, joint.child.point(*joint.to)))
                    P = sign * vector(reaction.impulse)
                    force += P
                    moment += sign * vector(reaction.moment) + np.cross(at - c, P)
        assert np.abs(force).max() < 2000 * EPS * largest
        assert np.abs(moment).max() < 2000 * EPS * largest


@pytest.mark.parametrize("seed", range(6))
def test_every_body_of_a_random_tree_is_in_balance(seed):
    s = random_system(seed, 4, loads=True)
    model = fb.assemble(s)
    q, u = random_state(model, seed)
    body = list(s.bodies.values())[-1]
    point = body.point(0.3, -0.2, 0.5)
    P, n = np.array([1.0, -2.0, 0.7]), np.array([0.2, 0.4, -1.0])
    hit = fb.impulse(s, at=point, impulse=P, moment=n, initial=start(model, q, u), values={})
    check_bodies(s, hit, [(point, P, n)])
    w_before, w_after = (vector(angular_velocity(model, x, body)) for x in (hit._state, hit._reached))
    v_before, v_after = (np.array(v) for v in hit.velocity(point))
    work = P @ (v_before + v_after) / 2 + n @ (w_before + w_after) / 2
    assert hit.energy_change == pytest.approx(work, rel=1e-9, abs=1e-9)
    assert list(hit.reactions) == list(model.joints) and len(hit.reactions) == len(model.joints)


def test_frame_of_the_components():
    s = random_system(3, 2, ("ball", "hinge"), loads=False)
    model = fb.assemble(s)
    q, u = random_state(model, 1)
    body = list(s.bodies.values())[-1]
    R = np.array(rotation(model, float_state(model, q, u), model.bodies[body.name].link))
    P = np.array([1.0, 2.0, 3.0])
    here = fb.impulse(s, at=body, impulse=P, frame=body, initial=start(model, q, u), values={})
    there = fb.impulse(s, at=body, impulse=R @ P, initial=start(model, q, u), values={})
    for name in model.speed_names:
        assert here.after[name] == pytest.approx(there.after[name], rel=1e-12, abs=1e-12)


def test_four_bar_struck():
    s = four_bar()
    rod = s.bodies["rod"]
    point = rod.point(0.2, 0.1, 0)
    near = {"a": 0.9, "b": -0.5, "d": 1.2}
    P = np.array([3.0, -1.0, 0.0])
    hit = fb.impulse(s, at=point, impulse=P, initial={"a": 0.9, "a'": 2}, near=near, values={})
    check_bodies(s, hit, [(point, P, np.zeros(3))])
    before, after = hit.velocity(point)
    assert hit.energy_change == pytest.approx(P @ (np.array(before) + after) / 2, rel=1e-12)
    assert hit.reactions["C"].on == "rod" and hit.multipliers["C_x"] == hit.reactions["C"].impulse[0]
    # both ends of the closing joint move alike
    ends = [hit.velocity(b)[1] for b in (rod.point(1, 0, 0), s.bodies["rocker"].point(0.75, 0, 0))]
    assert ends[0] == pytest.approx(ends[1], rel=1e-12, abs=1e-12)
    motion = fb.simulate(s, until=1, initial=hit.initial)
    assert motion.energy.relative_residual < 1e-7


def test_four_bar_exactly():
    s = fb.System("parallelogram")
    m, L, J = s.parameters(m=1, L=1, J=1)
    sides = (("left", 1, "y"), ("top", 2, "x"), ("right", 1, "y"))
    left, top, right = (s.body(n, fb.slender_bar(m, k * L, axis=x)) for n, k, x in sides)
    s.hinge("A", s.ground, left, to=(0, L / 2, 0), coordinate="a")
    s.hinge("B", left, top, at=(0, -L / 2, 0), to=(-L, 0, 0), coordinate="b")
    s.hinge("D", s.ground, right, at=(2 * L, 0, 0), to=(0, L / 2, 0), coordinate="d")
    s.hinge("C", right, top, at=(0, -L / 2, 0), to=(L, 0, 0))
    hanging = {"a": 0, "b": 0, "d": 0, "a'": 0, "b'": 0, "d'": 0}
    hit = fb.impulse(s, at=top, impulse=(J, 0, 0), initial=hanging)
    # two bars about their ends and one that only moves: (2 m L²/3 + m L²) a' = J L
    assert hit.after["a'"] == 3 * J / (5 * L * m) and hit.after["d'"] == hit.after["a'"]
    assert hit.after["b'"] == -hit.after["a'"]
    assert hit.energy_change == 3 * J**2 / (10 * m)
    number = fb.impulse(s, at=top, impulse=(J, 0, 0), initial=hanging, values={})
    assert number.after["a'"] == pytest.approx(0.6, rel=1e-13)
    for name, value in hit.canonical_components.items():
        exact = float(sympy.sympify(hit._show(value)).subs({m: 1, L: 1, J: 1}))
        assert number.canonical_components[name] == pytest.approx(exact, abs=1e-13)


def test_double_pendulum_struck():
    s, (m, L, J) = double_pendulum()
    B = s.bodies["B"]
    hit = fb.impulse(
        s, at=B.point(0, -L / 2, 0), impulse=(J, 0, 0), initial={"q1": 0, "q2": 0, "q1'": 0, "q2'": 0}
    )
    # both bars in line: absolute rates -6 J/(7 m L) and 30 J/(7 m L)
    assert sympy.simplify(hit.after["q1'"] + 6 * J / (7 * m * L)) == 0
    assert sympy.simplify(hit.after["q2'"] - 36 * J / (7 * m * L)) == 0
    general = fb.impulse(s, at=B.point(0, -L / 2, 0), impulse=(J, 0, 0), moment=(0, 0, "J*L"))
    model = general.model
    q, u = [0.4, -1.1], [0.5, 2.0]
    values = {"m": 2, "L": 1.5, "J": 0.7}
    numeric = fb.impulse(
        s,
        at=B.point(0, -L / 2, 0),
        impulse=(J, 0, 0),
        moment=(0, 0, "J*L"),
        initial=start(model, q, u),
        values=values,
    )
    numbers = {c.symbol: x for c, x in zip(model.coordinates, q, strict=True)}
    speeds = {c.symbol: x for c, x in zip(model.speeds, u, strict=True)}
    at = {m: 2, L: 1.5, J: 0.7}
    for name in model.speed_names:
        value = float(general.after[name].xreplace(speeds).xreplace(numbers).subs(at))
        assert numeric.after[name] == pytest.approx(value, rel=1e-12)
    for name, part in numeric.reactions["K"].components.items():
        value = (
            sympy.sympify(general.reactions["K"].components[name]).xreplace(speeds).xreplace(numbers).subs(at)
        )
        assert part == pytest.approx(float(value), rel=1e-11, abs=1e-12)
    assert numeric.energy_change == pytest.approx(
        float(general.energy_change.xreplace(speeds).xreplace(numbers).subs(at)), rel=1e-12
    )
    assert numeric.change["q1'"] == pytest.approx(numeric.after["q1'"] - numeric.before["q1'"])


def test_free_body_struck_off_its_centre():
    s = fb.System("free")
    m, a, J = s.parameters(m=1, a=1, J=1)
    box = s.body("box", fb.box(m, (a, a, a)))
    s.free("air", s.ground, box)
    hit = fb.impulse(s, at=box.point(0, a, 0), impulse=(0, 0, J), initial={"air": (1, 0, 0, 0)})
    wx, vz = sympy.Function("air_wx")(sympy.Symbol("t")), sympy.Function("air_vz")(sympy.Symbol("t"))
    assert hit.change["air_wx"] == 6 * J / (a * m) and hit.change["air_vz"] == J / m
    assert (
        sympy.expand(hit.after["air_wx"] - wx) == 6 * J / (a * m)
        and sympy.expand(hit.after["air_vz"] - vz) == J / m
    )
    assert hit.reactions["air"].impulse == sympy.zeros(3, 1)
    turned = fb.Rotation.axis_angle((0, 0, 1), np.pi / 2)
    number = fb.impulse(s, at=box, impulse=(1, 0, 0), initial={"air": turned}, values={})
    assert number.after["air_vy"] == pytest.approx(-1) and number.after["air_vx"] == pytest.approx(
        0, abs=1e-15
    )
    exact = fb.impulse(s, at=box, impulse=(1, 0, 0), initial={"air": (0, 0, 0, 1)})
    assert exact.change["air_vx"] == -1 / m


def test_driven_shaft_does_work():
    s = fb.System("driven")
    m, L, w = s.parameters(m=1, L=2, w=3)
    arm = s.body("arm", fb.particle(0))
    bob = s.body("bob", fb.particle(m))
    s.hinge("motor", s.ground, arm, coordinate=w * s.t)
    s.slider("rail", arm, bob, at=(L, 0, 0), coordinate="x")
    hit = fb.impulse(s, at=bob, impulse=(2, 5, 0), initial={"x": 0, "x'": 1}, t=0, values={})
    assert hit.after["x'"] == pytest.approx(3)
    assert hit.reactions["rail"].impulse == pytest.approx((0, -5, 0))
    assert hit.reactions["motor"].moment[2] == pytest.approx(-10)
    assert hit.energy_change == pytest.approx((9 - 1) / 2)


# -- restitution ------------------------------------------------------------------------------------


@pytest.mark.parametrize("e", [0, 0.4, 1])
def test_newtons_law_of_restitution(e):
    s, _ = double_pendulum()
    tip = s.bodies["B"].point(0, -0.75, 0)
    model = fb.assemble(s)
    hit = fb.impulse(
        s,
        at=tip,
        normal=(2, 1, 0),
        restitution=e,
        initial=start(model, [0.2, 0.5], [-3, -1]),
        values={"L": 1.5},
    )
    n = np.array([2, 1, 0]) / np.sqrt(5)
    before, after = (np.array(v) for v in hit.velocity(tip))
    assert n @ after == pytest.approx(-e * (n @ before), abs=1e-12)
    assert np.cross(hit.impulse, n) == pytest.approx([0, 0, 0], abs=1e-12) and n @ hit.impulse > 0
    assert hit.energy_change == pytest.approx(np.array(hit.impulse) @ (before + after) / 2, rel=1e-12)
    if e == 1:
        assert hit.energy_change == pytest.approx(0, abs=1e-12)


def test_restitution_of_a_free_bar_exactly():
    s = fb.System("falling bar")
    m, L, v, e = s.parameters(m=1, L=1, v=1, e=0.5)
    bar = s.body("bar", fb.slender_bar(m, L))
    s.planar("air", s.ground, bar, coordinate="x y phi")
    initial = {"phi": 0, "x'": 0, "y'": -v, "phi'": 0}
    hit = fb.impulse(s, at=bar.point(L / 2, 0, 0), normal=(0, 1, 0), restitution=e, initial=initial)
    assert sympy.simplify(hit.impulse[1] - m * v * (1 + e) / 4) == 0
    assert sympy.simplify(hit.velocity(bar.point(L / 2, 0, 0))[1][1] - e * v) == 0
    assert sympy.simplify(hit.energy_change + m * v**2 * (1 - e**2) / 8) == 0


# -- questions and what comes next --------------------------------------------------------------------


def test_questions_after_an_impulse():
    s, bar, (m, L, J, h) = hanging_bar()
    rest = {"theta": 0, "theta'": 0}
    hit = fb.impulse(s, at=bar.point(0, L / 2 - h, 0), impulse=(J, 0, 0), initial=rest)
    assert hit.solve("pin_x = 0", for_="h")["h"] == 2 * L / 3
    assert hit.solve("theta' = 5", for_="J")["J"] == 5 * L**2 * m / (3 * h)
    both = hit.solve(["theta' = 5", "pin_x = 1"], for_=["J", "h"])
    assert sympy.simplify(both["J"] * both["h"] - 5 * L**2 * m / 3) == 0
    assert hit.text().splitlines() == [
        "Impulse on 'hanging bar': speeds just after",
        "  theta' = 3*J*h/(m*L^2)",
        "impulsive reactions on the child bodies",
        "  pin_x = (3*h/(2*L) - 1)*J",
    ]
    assert repr(hit) == hit.text() and r"\dot{\theta}^{+}" in hit.latex()
    with pytest.raises(ModelError, match="Unknown joint 'pim'"):
        hit.reactions["pim"]
    number = fb.impulse(s, at=bar, impulse=(1, 0, 0), values={})
    assert number.text().splitlines()[1:] == [
        "  theta' = 0.625",
        "impulsive reactions on the child bodies",
        "  pin:  impulse (-0.25, 0, 0), moment impulse (0, 0, 0)",
    ]
    assert "0.625" in number.latex() and number.reactions["pin"].components["pin_x"] == -0.25
    assert repr(number.reactions["pin"]).startswith("Impulse of joint 'pin' on 'bar': (-0.25, ")
    with pytest.raises(ModelError, match="computed with numbers"):
        number.solve("pin_x = 0", for_="h")


def test_centre_of_percussion():
    s, bar, (m, L, _, _) = hanging_bar()
    assert fb.centre_of_percussion(s, "pin") == 2 * L / 3
    across = {"along": (0, -1, 0), "direction": (1, 0, 0), "frame": bar}
    assert fb.centre_of_percussion(fb.equations(s), s.joints["pin"], **across) == 2 * L / 3
    compound = fb.System("racket")
    M, r = compound.parameters(M=1, r=1)
    racket = compound.body("racket", fb.disk(M, r))
    compound.hinge("grip", compound.ground, racket, to=(0, 2 * r, 0), coordinate="theta")
    # I/(M d) with I = M r²/2 + M d², d = 2 r
    assert fb.centre_of_percussion(compound, "grip") == 9 * r / 4
    with pytest.raises(ModelError, match="Unknown joint 'gripp'"):
        fb.centre_of_percussion(compound, "gripp")
    with pytest.raises(ModelError, match="does not depend on the position of the blow along"):
        fb.centre_of_percussion(compound, "grip", direction=(0, 0, 1))
    with pytest.raises(ModelError, match="expected one of them as the body that is struck"):
        fb.centre_of_percussion(compound, "grip", body="ground")
    centred = fb.System("wheel")
    wheel = centred.body("wheel", fb.disk(1, 1))
    centred.hinge("axle", centred.ground, wheel)
    with pytest.raises(ModelError, match="mass centre of 'wheel' is at joint 'axle'"):
        fb.centre_of_percussion(centred, "axle")
    loose = fb.System("loose")
    stick = loose.body("stick", fb.slender_bar(1, 1, axis="y"))
    loose.ball("knot", loose.ground, stick, to=(0, 0.5, 0))
    with pytest.raises(ModelError, match="Joint 'knot' is no hinge: give the direction"):
        fb.centre_of_percussion(loose, "knot")


def test_an_impulse_between_two_runs():
    s, bar, (m, L, J, h) = hanging_bar()
    s.gravity = (0, -9.81, 0)
    first = fb.simulate(s, until=0.7, initial={"theta": 0.5}, values={"J": 2.5})
    hit = fb.impulse(s, at=bar.point(0, -L / 2, 0), impulse=(J, 0, 0), initial=first)
    assert hit.before["theta'"] == pytest.approx(first["theta'"][-1], rel=1e-12)
    cos = np.cos(first["theta"][-1])
    assert hit.change["theta'"] == pytest.approx(3 * 2.5 * cos / (2 * 1.2), rel=1e-12)
    second = fb.simulate(s, until=2, start=0.7, initial=hit.initial, values=first.values)
    assert second.energy.total[0] - first.energy.total[-1] == pytest.approx(hit.energy_change, rel=1e-9)
    at_a_time = fb.impulse(s, at=bar, impulse=(1, 0, 0), initial=first.at(0.3), values={})
    assert at_a_time.initial["theta"] == first.at(0.3)["theta"]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s, b: fb.impulse(s, at=b), "Expected an impulse, impulse=\\(Jx, Jy, Jz\\)"),
        (lambda s, b: fb.impulse(s, at=3, impulse=(1, 0, 0)), "Expected a point, such as at=bar.point"),
        (
            lambda s, b: fb.impulse(s, at=s.ground.origin, impulse=(1, 0, 0)),
            "An impulse on the ground moves nothing",
        ),
        (
            lambda s, b: fb.impulse(s, at=b, impulse=(1, 0)),
            "Expected three components \\(x, y, z\\) for the impulse",
        ),
        (lambda s, b: fb.impulse(s, at=hanging_bar()[1], impulse=(1, 0, 0)), "belongs to the system"),
        (lambda s, b: fb.impulse(3, at=b, impulse=(1, 0, 0)), "Expected a System, a Model or Equations"),
        (
            lambda s, b: fb.impulse(s, at=b, normal=(0, 1, 0)),
            "Expected either impulse=, or normal= and restitution=",
        ),
        (
            lambda s, b: fb.impulse(s, at=b, normal=(0, 0, 0), restitution=1),
            "Expected a direction for the normal",
        ),
        (
            lambda s, b: fb.impulse(s, at=b, normal=(0, 0, 1), restitution=1),
            "No impulse at .* can change its velocity along the normal",
        ),
        (
            lambda s, b: fb.impulse(
                s, at=b, normal=(1, 0, 0), restitution=2, initial={"theta'": -1}, values={}
            ),
            "Expected a coefficient of restitution from 0 to 1, got 2",
        ),
        (
            lambda s, b: fb.impulse(
                s, at=b, normal=(1, 0, 0), restitution=1, initial={"theta'": 1}, values={}
            ),
            "No impact: .* only approaches the surface",
        ),
        (
            lambda s, b: fb.impulse(s, at=b, impulse=(1, 0, 0), initial={"thetta": 1}),
            "Unknown name 'thetta' in initial",
        ),
        (lambda s, b: fb.impulse(s, at=b, impulse=(1, 0, 0), initial=3), "Expected initial values by name"),
        (
            lambda s, b: fb.impulse(s, at=b, impulse=(1, 0, 0)).initial,
            "The state of this impulse is left open",
        ),
    ],
)
def test_refusals(call, message):
    s, bar, _ = hanging_bar()
    with pytest.raises(ModelError, match=message):
        call(s, bar)


def test_an_impulse_without_mass_is_refused():
    s = fb.System("without moments of inertia")
    dot = s.body("dot", fb.particle(1))
    s.free("air", s.ground, dot)
    with pytest.raises(ModelError, match="does not determine air_wx, air_wy, air_wz"):
        fb.impulse(s, at=dot, impulse=(1, 0, 0))


def test_contradicting_speeds_are_refused():
    with pytest.raises(SimulationError, match="speeds contradict the constraints"):
        s = four_bar()
        fb.impulse(
            s,
            at=s.bodies["rod"],
            impulse=(1, 0, 0),
            initial={"a'": 1, "b'": 1, "d'": 1},
            near={"a": 1},
            values={},
        )
