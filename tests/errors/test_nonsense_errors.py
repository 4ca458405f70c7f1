"""Nonsense in public calls ends in an error of freebody's own: what was expected, and what came."""

import numpy as np
import pytest

import freebody as fb
from freebody.errors import ArgumentError, FormatError, FreebodyError, ModelError, SimulationError

G = 9.81


@pytest.fixture(scope="module")
def motion(pendulum):
    return fb.simulate(pendulum, 0.5, initial={"a": 0.5})


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"values": [1]}, "Expected values of parameters by name"),
        ({"values": np.zeros((2, 2))}, "Expected values of parameters by name"),
        ({"samples": "many"}, "Expected a number of samples of at least 2, got 'many'"),
        ({"samples": float("inf")}, "Expected a number of samples of at least 2, got inf"),
        ({"max_step": "long"}, "Expected a longest step greater than 0 s, got max_step='long'"),
        ({"max_steps": -1}, "Expected a number of steps of at least 1, got max_steps=-1"),
        ({"times": "soon"}, r"Expected a list of output times \[s\], got 'soon'"),
        ({"method": np.zeros(2)}, "Unknown method array"),
        ({"sensitivities": 3}, "Expected a list of names for .*, got 3"),
        (
            {"store": 3, "values": {"m": [1, 2]}},
            "Expected the path of a file for store=, such as 'run.nc', got 3",
        ),
    ],
)
def test_options_of_a_run(pendulum, options, text):
    with pytest.raises(FreebodyError, match=text):
        fb.simulate(pendulum, 0.1, **options)


def test_a_trajectory_that_is_asked_nonsense(motion):
    with pytest.raises(SimulationError, match=r"Expected a time of the run, or several \[s\], got 'noon'"):
        motion.at("noon")
    with pytest.raises(
        SimulationError, match=r"Expected a coordinate, a speed or an expression of them, got \[\]"
    ):
        motion[[]]
    with pytest.raises(SimulationError, match="Expected a name or an expression to plot, got {}"):
        motion.plot({})
    for path in (None, ""):
        with pytest.raises(SimulationError, match="Expected the path of a file for a trajectory"):
            motion.save(path)
        with pytest.raises(SimulationError, match="Expected the path of a file for a trajectory"):
            fb.Trajectory.load(path)
        with pytest.raises(SimulationError, match="Expected the path of a file for an animation"):
            motion.animate().save(path)
    wanted = r"Expected a file name that ends in \.nc for a trajectory .*got 'x\.csv'\. .*trajectory\.data\[\['a'\]\]"
    with pytest.raises(SimulationError, match=wanted):
        motion.save("x.csv")


def test_contacts_that_are_asked_nonsense():
    s = fb.System("disk")
    s.gravity = (0, -G, 0)
    body = s.body("disk", fb.disk(1, 0.1))
    s.planar("rail", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.circle(0.1), s.ground.plane(normal="y"), friction=0.3)
    motion = fb.simulate(s, 0.1, initial={"y": 0.1}, method="timestepping", step=0.01)
    with pytest.raises(SimulationError, match="Unknown contact '3'; known names: floor"):
        motion.modes.of(3)
    with pytest.raises(SimulationError, match="Expected the name of a contact, or a list of them, got 3"):
        motion.plot_margin(3)


def test_machines_that_are_none(pendulum, motion, tmp_path):
    with pytest.raises(ModelError, match="Expected a motion of fb.simulate to report on, got 3"):
        fb.report(pendulum, 3, tmp_path / "x.html")
    with pytest.raises(FormatError, match="Expected a System to write, got 3"):
        fb.write(3, tmp_path / "x.toml")
    with pytest.raises(ModelError, match="Expected a body of 'pendulum'"):
        fb.free_body_diagram(pendulum, [])
    with pytest.raises(ModelError, match="Unknown joint"):
        fb.bearing_reactions(pendulum, [], at={"A": 1, "B": 2})
    with pytest.raises(FreebodyError, match="as a number or a SymPy expression, got array"):
        fb.sphere(np.zeros((2, 2)), 1)


@pytest.mark.parametrize(
    ("held", "idle"),
    [("turn", "turn'"), ("x - 1", "turn'")],
)
def test_a_rotation_without_inertia(held, idle):
    s = fb.System("particle")
    ball = s.body("ball", fb.particle(1))
    s.planar("rail", s.ground, ball, coordinate="x y turn")
    s.constrain(held)
    s.contact("floor", ball.point(0, 0, 0), s.ground.plane(normal="y"), friction=0)
    for options in ({}, {"project": True}, {"method": "timestepping", "step": 0.01}):
        with pytest.raises(ModelError, match=f'"{idle}" moves no mass'):
            fb.simulate(s, 0.1, near={"x": 1}, **options)


def test_laws_that_time_stepping_does_not_know():
    def machine(**options):
        s = fb.System("disk")
        s.gravity = (0, -G, 0)
        body = s.body("disk", fb.disk(1, 0.1))
        s.planar("rail", s.ground, body, coordinate="x y turn")
        s.contact("floor", body.circle(0.1), s.ground.plane(normal="y"), **options)
        return s, body

    run = {"initial": {"y": 0.1}, "method": "timestepping", "step": 0.01}
    s, body = machine(friction=0.3, restitution=0.5, impact="poisson")
    s.contact("wall", body.circle(0.1), s.ground.plane(at=(3, 0, 0), normal="-x"), restitution=0.2)
    with pytest.raises(
        SimulationError,
        match="Contact 'wall' rebounds by Newton's and contact 'floor' by Poisson's law: .* Give all the same law",
    ):
        fb.simulate(s, 0.1, **run)
    s, body = machine(friction=0.3, restitution=0.5, impact="poisson")
    arm = s.body("arm", fb.slender_bar(1, 1, axis="x"))
    pin = s.hinge("pin", s.ground, arm, at=(0, 5, 0), axis="z", coordinate="q")
    s.friction("dry", pin, coefficient=0.3, radius=0.1)
    with pytest.raises(
        SimulationError, match="'floor' rebounds by Poisson's law, and the load .* 'dry': an impact"
    ):
        fb.simulate(s, 0.1, **run)
    s, _ = machine(friction="0.3 - slip")
    with pytest.raises(
        SimulationError,
        match="friction of contact 'floor' is below 0 or has no value in the step of 'disk' at t = 0",
    ):
        fb.simulate(s, 0.1, **{**run, "initial": {"y": 0.1, "x'": 1}})
    s, _ = machine(friction="0.3 + log(0.05 - t)/100")
    with pytest.raises(
        SimulationError, match="friction of contact 'floor' is below 0 or has no value .* t = 0.05 s"
    ):
        fb.simulate(s, 0.1, **run)


def _described():
    s = fb.System("cart")
    s.parameters(k=3.0)
    cart = s.body("cart", fb.particle(1))
    rail = s.slider("rail", s.ground, cart, axis="x", coordinate="x")
    return s, cart, rail


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda s, b, j: s.parameters(1.5), "Expected names of parameters as text, such as 'm k', got 1.5"),
        (lambda s, b, j: s.coordinates(float("nan")), "Expected names of coordinates as text.*got nan"),
        (
            lambda s, b, j: s.ball("p", s.ground, s.body("b", fb.particle(1)), coordinate=""),
            r"Expected a prefix \(text\)",
        ),
        (
            lambda s, b, j: s.free("p", s.ground, s.body("b", fb.particle(1)), coordinate=[]),
            "Expected a prefix",
        ),
        (lambda s, b, j: s.rope(3, 1), "Expected a list of points for rope 'rope', got 3"),
        (lambda s, b, j: s.rolling("r", b, radius=1, normal=-1), "for the normal of rolling 'r', got -1"),
        (
            lambda s, b, j: s.rolling("r", b, radius=0),
            "Expected a radius greater than 0 m for rolling 'r', got 0",
        ),
        (lambda s, b, j: s.constrain("x", name=""), "'' cannot be the name of a constraint"),
        (lambda s, b, j: s.force("F", j, "1e400"), "Expected a finite number for force 'F', got 1000000"),
        (lambda s, b, j: s.force("F", j, "1e400*x"), "Expected a finite number for force 'F', got 1000000"),
        (
            lambda s, b, j: s.controller(lambda t, x: 1, 0.1, {}),
            "Expected parameters of this system as the inputs",
        ),
        (
            lambda s, b, j: s.controller(lambda t, x: 1, 0.1, "k", sensors="x"),
            "Expected sensors of controller 'controller' as expressions by name.*got 'x'",
        ),
        (lambda s, b, j: fb.signal([0, 1], [0, 1], ["linear"]), r"Expected kind .*got \['linear'\]"),
        (lambda s, b, j: fb.tube(1, 1j, 2, 1), "Expected a inner radius of the tube that is a real number"),
        (lambda s, b, j: fb.plate(1, (1, 1), normal=np.zeros(2)), "the normal of a plate as 'x', 'y' or 'z'"),
        (lambda s, b, j: fb.revolve(1, (0, 1), [1], mass=1), "SymPy symbol as integration variables"),
        (lambda s, b, j: fb.Rotation.quaternion(None), r"\(w, x, y, z\) of a quaternion, got None"),
        (
            lambda s, b, j: fb.Rotation.axis_angle("x", "1e400"),
            "Expected a finite number for the angle, got one beyond",
        ),
    ],
)
def test_descriptions(make, text):
    with pytest.raises(FreebodyError, match=text):
        make(*_described())


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda p: p.forward_dynamics([None], [0.0]), r"Expected real numbers for q, got \[None\]"),
        (lambda p: p.forward_dynamics(["0.1"], [0.0]), r"Expected real numbers for q, got \['0.1'\]"),
        (lambda p: p.forward_dynamics([0.1], [0.0], None), "Expected real numbers for t, got None"),
        (
            lambda p: p.forward_dynamics([0.1], [0.0], values=[]),
            r"Expected values of parameters by name.*got \[\]",
        ),
        (
            lambda p: p.forward_dynamics([0.1], [0.0], L=[[1, 2], [3]]),
            "Expected real numbers for parameter 'L'",
        ),
        (lambda p: p.derivative(np.zeros(2), "q"), r"Unknown product '\[0\. 0\.\]'"),
        (lambda p: p.derivative([], "q"), r"Unknown product '\[\]'"),
        (lambda p: p.derivative("bias", {}), "Expected a variable to differentiate by, .*got '{}'"),
        (lambda p: p.describe(np.zeros(1)), r"Unknown product '\[0\.\]'"),
        (lambda p: p.to_c("bias", name=[]), r"Expected name= to be an identifier of C, got '\[\]'"),
        (lambda p: p.to_c("bias").write(None), "Expected the path of a folder to write to, got None"),
    ],
)
def test_programs(pendulum, call, text):
    with pytest.raises(ModelError, match=text):
        call(fb.compile(pendulum))


def test_names_of_what_has_no_name(pendulum, motion):
    for found, what in ((motion.reactions, "joint"), (motion.poses, "body")):
        with pytest.raises(SimulationError, match=rf"Unknown {what} '\[1\]'"):
            found[[1]]
    with pytest.raises(SimulationError, match=r"Unknown name '\[1\]'"):
        motion.place([1])
    with pytest.raises(SimulationError, match=r"Unknown name '\[1\]' in sensitivities"):
        fb.simulate(pendulum, 0.1, sensitivities=[[1]])
    with pytest.raises(SimulationError, match=r"Expected one number for tolerance=.*got \[\[1, 2\], \[3\]\]"):
        fb.simulate(pendulum, 0.1, tolerance=[[1, 2], [3]])
    with pytest.raises(ModelError, match="Expected the names of unknowns, such as 'pin_x', got None"):
        fb.equations(pendulum).solve(None)
    with pytest.raises(ModelError, match="Unknown reaction '3'"):
        fb.equations(pendulum).eliminate(3)
    with pytest.raises(FormatError, match="Expected the path of a file for a report, .*got None"):
        fb.report(pendulum, motion, None)


def test_empty_and_misspelt_choices_are_not_taken_for_none():
    s, *_ = _described()
    s.constrain("x", name="held")
    for options, text in (
        ({"near": ""}, "Expected near values by name, .*got ''"),
        ({"initial": []}, r"Expected initial values by name, .*got \[\]"),
        ({"project": "no"}, "Expected project=True or False, got 'no'"),
        ({"impacts": np.zeros(2)}, "Expected impacts= and indeterminate= as words, got impacts=array"),
    ):
        with pytest.raises(SimulationError, match=text):
            fb.simulate(s, 0.1, **options)


def test_measurements(pendulum):
    data = {"time": [0.1, 0.2, 0.3], "a": [0.1, 0.2, 0.2]}
    for options, text in (
        ({"unknown": {1}}, "Expected names of unknowns, or first guesses by name, got {1}"),
        ({"unknown": [["L"]]}, r"Unknown name '\['L'\]' in unknown"),
        ({"initial": 3}, "Expected initial values by name, .*got 3"),
        ({"sigma": {"a": "1 kg"}}, "Expected a standard deviation greater than 0 for 'a', .*got '1 kg'"),
    ):
        with pytest.raises(SimulationError, match=text):
            fb.fit(pendulum, data, **{"unknown": "L", **options})


def test_every_error_is_of_one_kind_that_has_a_public_name():
    with pytest.raises(fb.FreebodyError, match="at least one parameter"):
        fb.System().parameters()
    assert issubclass(SimulationError, fb.FreebodyError)


def test_arguments_that_a_function_does_not_have(pendulum):
    s, _, rail = _described()
    for call, text in (
        (
            lambda: s.spring("k", rail, stiffness=1, rst=1),
            "argument of spring, got 'rst='; did you mean 'rest'?",
        ),
        (
            lambda: s.spring("k", rail, stiffness=1, length=1),
            "got 'length='; known names: coordinate, force, name, on, rest",
        ),
        (lambda: s.damper("k", rail), "Expected damper(name, on, to, damping, coordinate): missing"),
        (
            lambda: s.body("b", fb.particle(1), colour="red"),
            "argument of body, got 'colour='; did you mean 'color'?",
        ),
        (
            lambda: fb.simulate(s, 1, tolerence=1),
            "argument of simulate, got 'tolerence='; did you mean 'tolerance'?",
        ),
        (
            lambda: fb.simulate(s, 1, time_step=0.01),
            "argument of simulate, got 'time_step='; did you mean 'step'?",
        ),
        (lambda: fb.sweep(s, {"x": [1]}, until=1, output="x"), "'output='; did you mean 'outputs'?"),
        (lambda: fb.compile(s, thread=2), "argument of compile, got 'thread='; did you mean 'threads'?"),
        # all public functions and classes, solids and shapes among them, without a word in their own files
        (
            lambda: fb.box(1, 1, 2, 3),
            "Expected box(m, sizes): too many positional arguments. An example: fb.box(12, (1, 2, 3))",
        ),
        (lambda: fb.disk(1, radus=2), "argument of disk, got 'radus='; did you mean 'radius'?"),
        (lambda: fb.draw(s, valus={}), "argument of draw, got 'valus='; did you mean 'values'?"),
        (lambda: fb.System("a", gravity=1), "argument of System, got 'gravity='; known names: name"),
        (lambda: fb.MassProperties(1, 2, 3, 4, 5, 6), "Expected MassProperties(mass, "),
        (lambda: s.ground.sphere(rad=1), "argument of sphere, got 'rad='; did you mean 'radius'?"),
        (
            lambda: s.ground.capsule(1),
            "Expected capsule(start, end, radius): missing a required argument: 'end'.",
        ),
        (
            lambda: s.contacts("c", [], frction=1),
            "argument of contacts, got 'frction='; did you mean 'friction'?",
        ),
    ):
        with pytest.raises(ArgumentError) as caught:
            call()
        assert text in str(caught.value)
        assert isinstance(caught.value, TypeError) and isinstance(caught.value, fb.FreebodyError)
