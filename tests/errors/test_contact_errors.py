"""What contacts refuse: every message says what was expected, what came, and the cure."""

from __future__ import annotations

import pytest
import sympy

import freebody as fb
from freebody.errors import ExpressionError, ModelError, SimulationError


def machine():
    s = fb.System("machine")
    s.parameters("open_mu", R=0.3, mu=0.2)
    disk, bar = s.body("disk", fb.disk(1, 0.3)), s.body("bar", fb.slender_bar(1, 2))
    s.planar("p", s.ground, disk, coordinate="x y f")
    s.planar("q", s.ground, bar, coordinate="x1 y1 f1")
    return s, disk, bar


def refused(call, message, error=ModelError):
    with pytest.raises(error) as caught:
        call()
    assert message in str(caught.value), str(caught.value)


CONTACTS = {
    "same body": (
        lambda s, disk, bar: (disk.circle(1), disk.plane()),
        {},
        "The feature and the surface of contact 'c' are both on body 'disk'. A contact is between two bodies",
    ),
    "both on the ground": (
        lambda s, disk, bar: (s.ground.circle(1), s.ground.plane()),
        {},
        "The feature and the surface of contact 'c' are both on the ground.",
    ),
    "a body": (
        lambda s, disk, bar: (disk, s.ground.plane()),
        {},
        "Expected a shape for the feature of contact 'c', got the whole of body 'disk'. Say what of it touches: body.point",
    ),
    "a number": (
        lambda s, disk, bar: (disk.circle(1), 3),
        {},
        "Expected a shape for the surface of contact 'c', body.point, body.sphere",
    ),
    "two points": (
        lambda s, disk, bar: (disk.origin, bar.origin),
        {},
        "The point and the point of contact 'c' are not a supported pair. A point may touch a box, capsule, circle, cylinder, heightline",
    ),
    "two planes": (
        lambda s, disk, bar: (disk.plane(), bar.plane()),
        {},
        "The plane and the plane of contact 'c' are not a supported pair. A plane may touch a box, capsule, circle, corners, drum, ellipsoid",
    ),
    "an egg on a hill": (
        lambda s, disk, bar: (disk.ellipsoid((1, 2, 3)), s.ground.heightline("x^2")),
        {},
        "The ellipsoid and the heightline of contact 'c' are not a supported pair. An ellipsoid may touch a plane.",
    ),
    "disk on a roof": (
        lambda s, disk, bar: (disk.circle(1), s.ground.heightline("-abs(x)")),
        {},
        "The heightline -Abs(x) of contact 'c' has kinks, where a circle may touch in two places. Divide it there, "
        "body.heightline(..., between=(start, end)), with a contact for each part.",
    ),
    "hollow feature": (
        lambda s, disk, bar: (disk.circle(3, inside=True), bar.origin),
        {},
        "The feature of contact 'c' is the inside of a circle. Exchange feature and surface: the hollow is the surface.",
    ),
    "too large to fit": (
        lambda s, disk, bar: (disk.circle(2), s.ground.circle(1, inside=True)),
        {},
        "The circle of contact 'c' has the radius 2 and does not fit inside a circle of radius 1.",
    ),
    "negative friction": (
        lambda s, disk, bar: (disk.circle(1), s.ground.plane()),
        {"friction": -0.1},
        "Expected a friction of 0 or more for contact 'c', got -0.1.",
    ),
    "negative default": (
        lambda s, disk, bar: (disk.circle(1), s.ground.plane()),
        {"friction": "-mu"},
        "Expected a friction of 0 or more for contact 'c', got -0.2.",
    ),
    "static friction of slip": (
        lambda s, disk, bar: (disk.circle(1), s.ground.plane()),
        {"friction": "mu", "static_friction": "2*mu*exp(-slip)"},
        "The static friction of contact 'c' acts at rest and cannot depend on slip. Give its value, or leave it out: it "
        "is then the friction at slip = 0.",
    ),
    "static below kinetic": (
        lambda s, disk, bar: (disk.circle(1), s.ground.plane()),
        {"friction": 0.3, "static_friction": "mu"},
        "The static friction of contact 'c' is 0.2, below its kinetic friction 0.3.",
    ),
    "restitution": (
        lambda s, disk, bar: (disk.circle(1), s.ground.plane()),
        {"restitution": 1.5},
        "Expected a restitution between 0 (no bounce) and 1 (full bounce) for contact 'c', got 1.5.",
    ),
    "impact law": (
        lambda s, disk, bar: (disk.circle(1), s.ground.plane()),
        {"impact": "Newton"},
        "Expected impact='newton' or impact='poisson' for contact 'c', got 'Newton'.",
    ),
}


@pytest.mark.parametrize("case", CONTACTS)
def test_refused_contact(case):
    s, disk, bar = machine()
    shapes, laws, message = CONTACTS[case]
    refused(lambda: s.contact("c", *shapes(s, disk, bar), **laws), message)
    assert s.contacts == {}


def test_an_open_coefficient_is_taken():
    s, disk, _ = machine()
    s.contact("c", disk.circle(1), s.ground.plane(), friction="open_mu", restitution="open_mu")
    assert fb.assemble(s).contacts[0].friction == s.expression("open_mu")


def test_other_systems_and_names():
    s, disk, _ = machine()
    other = fb.System("other")
    ball = other.body("ball", fb.sphere(1, 1))
    refused(lambda: s.contact("c", ball.sphere(1), s.ground.plane()), "belongs to the system 'other'")
    s.contact("c", disk.circle(1), s.ground.plane())
    refused(
        lambda: s.contact("c", disk.circle(1), s.ground.plane()),
        "There is already a contact 'c' in this system.",
    )
    refused(
        lambda: s.contact("p", disk.circle(1), s.ground.plane()),
        "There is already a joint 'p' in this system.",
    )
    refused(lambda: s.constrain("x", name="c"), "There is already a contact 'c' in this system.")
    refused(
        lambda: s.hinge("c", s.ground, disk, coordinate="a"), "There is already a contact 'c' in this system."
    )
    refused(lambda: s.contact("1c", disk.circle(1), s.ground.plane()), "'1c' cannot be the name of a contact")


SHAPES = {
    "size": (lambda b: b.circle(0), "Expected a size of more than 0 for the circle of body 'disk', got 0."),
    "size that moves": (lambda b: b.sphere("x"), "The size of the sphere of body 'disk' cannot depend on x."),
    "inside": (lambda b: b.sphere(1, inside="yes"), "Expected inside=True or inside=False for the sphere of body 'disk', got 'yes'."),
    "normal": (lambda b: b.plane(normal="up"), "Expected 'x', 'y', 'z' or three components for the normal of the plane of body 'disk', got 'up'."),
    "zero normal": (lambda b: b.plane(normal=(0, 0, 0)), "has length zero"),
    "side without length": (lambda b: b.segment((1, 0, 0), (1, 0, 0), normal="y"), "Start and end of the segment of body 'disk' are the same point, (1, 0, 0)."),
    "oblique normal": (lambda b: b.segment((0, 0, 0), (1, 1, 0), normal="y"), "The normal of the segment of body 'disk' must be at right angles to the side from (0, 0, 0) to (1, 1, 0), got 'y'."),
    "no corners": (lambda b: b.corners(), "Expected points, or size=(a, b) of a box, for the corners of body 'disk', got none. A body made of a mesh has corners of its own; this one is a disk."),
    "corners twice": (lambda b: b.corners((0, 0, 0), size=(1, 1)), "got both"),
    "one edge": (lambda b: b.corners(size=(1,)), "Expected two or three edges, size=(a, b, c), for the corners of body 'disk', got (1,)."),
    "moved corners": (lambda b: b.corners((0, 0, 0), at=(1, 0, 0)), "at= displaces a box given by size=, but the corners of body 'disk' are given as points."),
    "place": (lambda b: b.sphere(1, at=(0, 1)), "Expected three components (x, y, z) for the sphere of body 'disk', got 2"),
    "other body's place": (lambda b: b.sphere(1, at=b.system.ground.origin), "Expected a point of body 'disk' for the sphere of body 'disk', got a point (0, 0, 0) of ground."),
    "line of one end": (lambda b: b.heightline("x^2", between=(1,)), "Expected between=(start, end) for the heightline of body 'disk', got (1,)."),
    "line of no length": (lambda b: b.heightline("x^2", between=(1, 1)), "Expected a start before the end of the heightline of body 'disk', got between=(1, 1)."),
    "level line": (lambda b: b.heightline("2*R"), "The heightline of body 'disk' does not depend on x. A level line is body.plane()."),
    "line that moves": (lambda b: b.heightline("sin(f)*x"), "The heightline of body 'disk' is fixed in its body and cannot depend on f."),
}  # fmt: skip


@pytest.mark.parametrize("case", SHAPES)
def test_refused_shape(case):
    make, message = SHAPES[case]
    refused(lambda: make(machine()[1]), message)


def test_a_line_of_unknown_names():
    refused(lambda: machine()[1].heightline("sin(w*x)"), "In the heightline of body 'disk'", ExpressionError)


def test_walls_that_touch_along_a_line_need_a_planar_machine():
    s = fb.System("log")
    log = s.body("log", fb.cylinder(1, 0.2, 1))
    s.free("air", s.ground, log)
    s.contact("c", log.cylinder(0.2), s.ground.cylinder(1))
    refused(
        lambda: fb.assemble(s),
        "The cylinder and the cylinder of contact 'c' touch at one point only if all motion is in a plane at right "
        "angles to their axes, which is not the case here.",
    )


def closing(planar=True, **laws):
    s = fb.System("disk")
    disk = s.body("disk", fb.disk(1, 0.3))
    if planar:
        s.planar("p", s.ground, disk, coordinate="x y f")
    else:
        s.free("p", s.ground, disk)
    s.contact("floor", disk.circle(0.3), s.ground.plane(), **{"friction": 0.2, **laws})
    return s


MODES = {
    "unknown contact": (True, {}, {"flor": "stick"}, "Unknown contact 'flor' in modes; did you mean 'floor'?"),
    "unknown mode": (True, {}, {"floor": "roll"}, "Unknown mode 'roll' of contact 'floor'; expected one of open, closed, stick, slip+, slip-, slip."),
    "no sign": (True, {}, {"floor": "slip"}, "Contact 'floor' slips along one line: expected 'slip+' or 'slip-', by the sign of its slip velocity, got 'slip'."),
    "a sign in space": (False, {}, {"floor": "slip+"}, "Contact 'floor' can slip in two directions: expected 'slip', or ('slip', (d1, d2)), got 'slip+'."),
    "smooth": (True, {"friction": 0}, {"floor": "stick"}, "Contact 'floor' has no friction and cannot stick. Its mode is 'slip'."),
    "components": (False, {}, {"floor": ("slip", (1,))}, "Contact 'floor' has 2 tangent directions, got 1 components of slip."),
    "no mapping": (True, {}, "stick", 'Expected modes by contact, such as {"floor": "stick"}, got \'stick\'.'),
}  # fmt: skip


@pytest.mark.parametrize("case", MODES)
def test_refused_mode(case):
    planar, laws, modes, message = MODES[case]
    refused(lambda: fb.equations(closing(planar, **laws), modes=modes), message)


def test_modes_of_a_machine_without_contacts():
    s = fb.System("ball")
    s.free("air", s.ground, s.body("ball", fb.sphere(1, 1)))
    refused(
        lambda: fb.equations(s, modes={"floor": "stick"}),
        "Unknown contact 'floor' in modes: this machine has no contacts. Declare one by s.contact.",
    )


def test_what_rests_on_symmetric_forces_is_refused_while_a_contact_slips():
    e = fb.equations(closing(), modes={"floor": "slip+"})
    refused(lambda: fb.linearize(e.model, values={}), "while contact 'floor' slips with friction")
    refused(lambda: fb.steady_motions(e.model), "while contact 'floor' slips with friction")


def test_forces_of_contacts_keep_clear_of_other_names():
    s = closing()
    s.parameters("N_floor")
    (contact,) = fb.assemble(s).contacts
    assert (contact.normal_name, contact.tangent_names) == ("N_floor_", ("T_floor",))
    e = fb.equations(s, modes={"floor": "stick"})
    assert e.solve("N_floor_", where={})["N_floor_"] == 0
    assert sympy.Symbol("N_floor_", real=True) in e.free_body("disk").unknowns


@pytest.mark.parametrize("question", ["linearize", "steady_motions", "impulse", "centre_of_percussion"])
def test_linear_equations_and_blows_need_the_modes_of_contacts(question):
    s = fb.System("wheel")
    s.gravity = (0, -10, 0)
    disk = s.body("disk", fb.disk(2, 1))
    s.planar("plane", s.ground, disk, coordinate="x y phi")
    s.contact("floor", disk.circle(1), s.ground.plane(normal="y"), friction=0.5)
    s.spring("k", s.ground.point(-2, 1, 0), disk.origin, stiffness=12, rest=1)
    s.hinge("pin", disk, s.body("bar", fb.slender_bar(1, 1, axis="y")), to=(0, 0.5, 0), coordinate="theta")
    ask = {
        "linearize": lambda of: fb.linearize(of, about={"x": -1, "y": 1}, values={}),
        "steady_motions": lambda of: fb.steady_motions(of).conditions,
        "impulse": lambda of: fb.impulse(of, at=disk.origin, impulse=(1, 0, 0), initial={"y": 1}, values={}),
        "centre_of_percussion": lambda of: fb.centre_of_percussion(of, "pin", body="bar"),
    }[question]
    with pytest.raises(ModelError) as refused:
        ask(s)
    assert f"fb.{question}(fb.equations(s, modes={{'floor': 'stick'}}), ...)" in str(refused.value)
    ask(fb.equations(s, modes={"floor": "stick"}))


STEPS = {"method": "timestepping", "step": 0.001}


def on_an_axis(feature, surface, joint="slider"):
    """A ball whose centre is at the origin, in an x slider or free in the plane."""
    s = fb.System("shaft")
    s.parameters(r=0.1, R=0.1)
    ball = s.body("ball", fb.sphere(0.5, 0.1))
    if joint == "slider":
        s.slider("way", s.ground, ball, axis="x", coordinate="x")
    else:
        s.planar("way", s.ground, ball, coordinate="x y turn")
    s.contact("hit", feature(ball), surface(s.ground), friction=0.3)
    return s


@pytest.mark.parametrize("how", [{}, STEPS])
@pytest.mark.parametrize("joint", ["slider", "planar"])
@pytest.mark.parametrize(
    "feature,surface,depth",
    [
        (lambda b: b.sphere(0.1), lambda g: g.capsule((-0.2, 0, 0), (0.2, 0, 0), 0.1), 0.2),
        (lambda b: b.sphere(0.1), lambda g: g.cylinder(0.5, axis="x"), 0.6),
        (lambda b: b.sphere(0.1), lambda g: g.sphere(0.5), 0.6),
        (lambda b: b.point(0, 0, 0), lambda g: g.cylinder(0.5, axis="x"), 0.5),
        (lambda b: b.point(0, 0, 0), lambda g: g.sphere(0.5), 0.5),
    ],
)
def test_centres_on_a_centre_or_an_axis_are_deep(feature, surface, depth, joint, how):
    with pytest.raises(SimulationError, match=f"has contact 'hit' {depth} m deep. Begin with every gap"):
        fb.simulate(on_an_axis(feature, surface, joint), 0.01, **how)


@pytest.mark.parametrize("how", [{}, STEPS])
def test_a_family_says_the_depth_on_an_axis(how):
    s = fb.System("pill")
    ball = s.body("ball", fb.sphere(0.5, 0.1))
    s.slider("way", s.ground, ball, axis="x", coordinate="x")
    s.contacts("hit", [ball.sphere(0.1), s.ground.capsule((-0.2, 0, 0), (0.2, 0, 0), 0.1)], friction=0.3)
    with pytest.raises(SimulationError, match=r"'hit\[ball,ground\]' 0.2 m deep"):
        fb.simulate(s, 0.01, **how)


@pytest.mark.parametrize("how", [{}, STEPS])
def test_values_of_a_run_that_leave_no_play(how):
    s = on_an_axis(lambda b: b.sphere("r"), lambda g: g.cylinder("R", axis="x", inside=True))
    with pytest.raises(
        SimulationError,
        match=r"'hit' has the radius 0.1 m and does not fit inside a cylinder of radius 0.1 m. A shaft without play",
    ):
        fb.simulate(s, 0.01, **how)
    assert fb.simulate(s, 0.01, values={"R": 0.2}, **how).status == "finished"


def test_a_family_in_a_hollow_without_play():
    s = fb.System("drum")
    s.parameters(R=0.1)
    balls = [s.body(f"b{i}", fb.sphere(0.5, 0.1)) for i in range(2)]
    for i, ball in enumerate(balls):
        s.free(f"f{i}", s.ground, ball)
    shapes = [*(b.sphere(0.1 - i / 20) for i, b in enumerate(balls)), s.ground.sphere("R", inside=True)]
    s.contacts("held", shapes, friction=0.3)
    with pytest.raises(
        SimulationError, match=r"'held\[b0,ground\]' has the radius 0.1 m and does not fit inside a sphere"
    ):
        fb.simulate(s, 0.01, initial={"f1_x": 0.3}, **STEPS)


def test_a_contact_without_a_direction_cannot_be_closed():
    s = on_an_axis(lambda b: b.sphere("r"), lambda g: g.cylinder("2*R", axis="x", inside=True))
    with pytest.raises(ModelError) as refused:
        str(fb.equations(s, modes={"hit": "stick"}))
    assert str(refused.value) == (
        "Contact 'hit' of 'shaft' cannot be closed: the centre of the sphere is held on that of the cylinder, or on "
        'its axis, so that a force between them has no direction. Leave it open, modes={"hit": "open"}; a shaft '
        "in its bearing is a joint."
    )
    assert "hit open (the modes in which the motion starts" in str(fb.equations(s))
    assert "hit" not in str(fb.equations(s).free_body("ball").unknowns)


def test_a_start_at_the_centre_is_open():
    s = on_an_axis(lambda b: b.circle("r"), lambda g: g.circle("2*R", inside=True), "planar")
    assert "hit open (the modes in which the motion starts" in str(fb.equations(s, initial={"x'": 1}))
    motion = fb.simulate(s, 0.2, initial={"x'": 1})  # the play is 0.1 m
    assert motion.modes[0].end == pytest.approx(0.1, rel=1e-12)


def sliding_disk():
    s = fb.System("slide")
    s.gravity = (0, -9.81, 0)
    disk = s.body("disk", fb.disk(1, 0.1))
    s.planar("plane", s.ground, disk, coordinate="x y turn")
    return s, disk


NO_VALUE = (
    "A root or logarithm of a negative number, or 0/0, in its shape or its laws does this: write laws that have a value "
    "wherever it touches, give a line ends, between=, or stop before with a terminal event."
)


@pytest.mark.parametrize(("x", "law", "when"), [(-1, "log(x)", "0 s"), (0.4, "0.3 + sqrt(0.5 - x)", "0.1")])
def test_friction_without_a_value(x, law, when):
    s, disk = sliding_disk()
    s.contact("floor", disk.circle(0.1), s.ground.plane(), friction=law)
    with pytest.raises(SimulationError) as refused:
        fb.simulate(s, 1, initial={"x": x, "y": 0.1, "x'": 1, "turn'": -10})
    said = str(refused.value)
    assert f"The friction or force of contact 'floor' of 'slide' has no value just after t = {when}" in said
    assert NO_VALUE in said


def test_a_gap_without_a_value():
    s, disk = sliding_disk()
    s.contact("road", disk.point(0, 0, 0), s.ground.heightline("sqrt(x)"), friction=0.3)
    with pytest.raises(SimulationError) as refused:
        fb.simulate(s, 1, initial={"x": 0.5, "y": 2, "x'": -1})
    assert (
        str(refused.value)
        == f"The gap of contact 'road' of 'slide' has no value just after t = 0.5 s. {NO_VALUE}"
    )
    said = str(fb.equations(s, initial={"x": -0.5, "y": 2}))
    assert "The contacts of 'slide' have no value at its start: math domain error." in said


def test_a_residual_is_of_contacts(tmp_path):
    s, disk = sliding_disk()
    with pytest.raises(SimulationError) as refused:
        fb.simulate(s, 0.1).residual  # noqa: B018
    assert (
        str(refused.value) == "Expected a motion with contacts for trajectory.residual, got 'slide' without."
    )
    s.contact("floor", disk.circle(0.1), s.ground.plane(), friction=0.3, restitution=0.5)
    motion = fb.simulate(s, 1, initial={"y": 0.3, "x'": 1})
    assert 0 < motion.residual <= 1e-12
    path = tmp_path / "motion.nc"
    motion.save(path)
    assert fb.Trajectory.load(path).residual == motion.residual
