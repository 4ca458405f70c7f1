"""Nonsense in public calls ends in an error of freebody's own: what was expected, and what came."""

import numpy as np
import pytest

import freebody as fb
from freebody.errors import FormatError, FreebodyError, ModelError, SimulationError

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
    s, _ = machine(friction=0.3, restitution=0.5, impact="poisson")
    with pytest.raises(
        SimulationError, match="knows Newton's restitution, but contact 'floor' has impact='poisson'"
    ):
        fb.simulate(s, 0.1, **run)
    s, _ = machine(friction=0.3, static_friction=0.4)
    with pytest.raises(SimulationError, match="knows one coefficient of friction, but contact 'floor'"):
        fb.simulate(s, 0.1, **run)
    s, body = machine(friction=0.3)
    with pytest.raises(SimulationError, match="The blow 'wall' meets a surface"):
        fb.simulate(
            s, 0.1, impulses=[fb.blow(0.05, at=body, normal=(1, 0, 0), restitution=0, name="wall")], **run
        )
