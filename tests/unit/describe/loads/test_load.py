"""Loads of a user's own module go wherever ours go, and ours pass what theirs pass."""

from __future__ import annotations

import ast
import copy
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody.describe.loads.load import KINDS
from freebody.formats.toml.write import toml_text
from own_loads import Drag, Everything, Gravitation
from page_data import scene_of

SOURCE = Path(fb.__file__).parent


def pendulum(**options):
    """A bar with drag at its free end."""
    s = fb.System("pendulum")
    m, L, g, k = s.parameters(m=1.0, L=2.0, g=9.81, k=0.1)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), axis="z", coordinate="theta")
    s.add("drag", Drag(bar.point(0, -L / 2, 0), k))
    return s


def test_no_file_names_a_kind_of_load():
    """Only the files of ``describe/loads`` know the classes: nothing else imports one."""
    own = {
        kind.__module__.rpartition(".")[2]
        for kind in KINDS.values()
        if kind.__module__.startswith("freebody")
    }
    assert {
        "force",
        "torque",
        "spring",
        "damper",
        "joint_spring",
        "joint_effort",
        "coordinate_force",
        "drag",
        "motor",
        "cable",
    } <= own
    for path in SOURCE.rglob("*.py"):
        if path.parent in (SOURCE / "describe" / "loads", SOURCE / "describe" / "contacts"):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if path.name == "system.py" and isinstance(node, ast.ImportFrom) and node.module == "loads":
                continue  # the doors: s.drag, s.motor
            if isinstance(node, ast.ImportFrom) and "loads" in (node.module or "").split("."):
                if node.level == 1 and node.module == "loads":
                    continue  # the loads of model files, and of time steps
                if node.module.rpartition(".")[2] in ("actions", "added_mass", "instant", "loading", "power"):
                    continue  # of the dynamics
                assert node.module.rpartition(".")[2] in ("action", "law", "load", "loads"), path
                assert {alias.name for alias in node.names} <= {
                    "Action", "Couple", "GeneralizedForce", "JointForce", "KINDS", "Law", "Load", "Look", "Part",
                    "PointForce", "RATE", "STRETCH", "add", "sort_of", "system_loads",
                }, path  # fmt: skip


def test_equations_and_reactions_have_it():
    e = fb.equations(pendulum())
    assert e.text() == "m*L^2*theta''/3 + m*L*g*sin(theta)/2 = -L^3*k*theta'*abs(theta')"
    assert [a.name for a in e.free_body("bar").actions if a.load] == ["drag"]
    force = e.free_body("bar").forces["drag"]
    assert str(force[0]).replace(" ", "").count("k") == 1


def test_a_motion_a_batch_and_a_program_have_it():
    s = pendulum()
    motion = fb.simulate(s, 1, initial={"theta": 1.0})
    assert np.abs(motion.energy.work).max() > 0.01 and np.abs(motion.energy.residual).max() < 1e-8
    batch = fb.simulate(s, 1, initial={"theta": [0.5, 1.0]})
    assert float(batch["theta"][1, -1]) == pytest.approx(float(motion["theta"][-1]), abs=1e-9)
    program = fb.compile(s)
    (slow,), (fast,) = program.forward_dynamics([0.0], [0.0]), program.forward_dynamics([0.0], [2.0])
    assert slow == 0 and fast == pytest.approx(-3 * 2 * 0.1 * 2 * abs(2))  # 3/(m L²) L³ k ω²
    assert "sqrt(" in program.to_c("forward_dynamics").source


def test_pictures_have_it(tmp_path):
    s = pendulum()
    assert 'data-load="drag"' in fb.draw(s).svg
    assert "drag" in fb.free_body_diagram(s, "bar").svg
    motion = fb.simulate(s, 1, initial={"theta": 1.0})
    fb.report(s, motion, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<td>drag</td><td>drag</td>" in text
    assert "force force drag 0" in {arrow["channel"] for arrow in scene_of(text)["arrows"]}


def test_a_copy_and_a_study_have_it():
    s = pendulum()
    assert fb.equations(copy.copy(s)).text() == fb.equations(s).text()
    study = fb.study(s, until=1, outputs=["theta"], lanes=fb.grid(k=[0.1, 0.2]))
    assert (
        study.identity
        == fb.study(pendulum(), until=1, outputs=["theta"], lanes=fb.grid(k=[0.1, 0.2])).identity
    )


@pytest.mark.parametrize(
    "kind",
    [Drag, Gravitation, Everything]
    + [
        k for k in KINDS.values() if "freebody" in k.__module__ and k.__name__ not in ("Belt", "Tyre")
    ],  # with data of their own: test_belt, exact/test_tyres
)
def test_every_kind_passes_the_battery(kind):
    fb.testing.check_load(kind, balanced=False if kind is Everything else None)


# --- refusals ----------------------------------------------------------------------------------


def refused(message, load=None):
    s = pendulum()
    with pytest.raises(fb.FreebodyError, match=message):
        s.add("x", load(s) if load else None)
        fb.equations(s).text()
        fb.compile(s).forward_dynamics([0.0], [0.0])


def own(actions):
    """A load with these actions at the end of the bar."""
    return lambda s: type("Own", (fb.Load,), {"__annotations__": {"point": "fb.Point"}, "actions": actions})(
        s.bodies["bar"].origin
    )


def branching(self, at):
    if at.velocity(self.point).x > 0:
        yield fb.PointForce(self.point, (1, 0, 0))


def test_what_cannot_be_a_load_is_refused():
    other = fb.System("other")
    ball = other.body("ball", fb.particle(1))
    refused(
        "Expected a load, a joint or a contact for 'x', an instance of a subclass of fb.Load, fb.Joint or fb.Gap, "
        "got None"
    )
    refused("Make it one: Drag", lambda s: Drag)
    refused("drag 'drag' is already part of a system. Make another one for 'x'", lambda s: s.loads["drag"])
    refused("Drag 'x': body 'ball' belongs to the system 'other'", lambda s: Drag(ball.origin, 1))
    refused("In drag 'x': Expected a known name, got 'q'", lambda s: Drag(s.bodies["bar"].origin, "q"))
    refused("Own 'x': expected fb.PointForce.* got 3", own(lambda self, at: [3]))
    refused("Own 'x': .*not iterable", own(lambda self, at: None))
    refused("three components, got \\(1, 2\\)", own(lambda self, at: [fb.PointForce(self.point, (1, 2))]))
    refused("has no 'velocty'; did you mean 'velocity'", own(lambda self, at: at.velocty(self.point)))
    refused("belongs to another system than 'pendulum'", own(lambda self, at: [fb.Couple(ball, (0, 0, 1))]))
    refused("is no coordinate of", own(lambda self, at: [fb.GeneralizedForce("phi", 1)]))
    refused("test_load.py, line .*: if at.velocity.* without if on a value", own(branching))
    refused("its class Bare has no actions", lambda s: type("Bare", (fb.Load,), {})())


def test_a_file_knows_only_named_kinds():
    s = pendulum()
    nameless = type("Nameless", (fb.Load,), {"actions": lambda self, at: iter(())})
    s.add("x", nameless())
    with pytest.raises(fb.FreebodyError, match="cannot hold nameless 'x'.*fb.Load, kind='nameless'"):
        toml_text(s)


def test_a_file_names_the_kind(tmp_path):
    path = tmp_path / "pendulum.toml"
    fb.write(pendulum(), path)
    assert 'kind = "test_drag"' in path.read_text(encoding="utf-8")
    assert fb.equations(fb.read(path)).text() == fb.equations(pendulum()).text()
    path.write_text(path.read_text(encoding="utf-8").replace("test_drag", "test_drug"), encoding="utf-8")
    with pytest.raises(
        fb.FreebodyError, match="Unknown kind of load 'test_drug'; did you mean 'test_drag'.*Import"
    ):
        fb.read(path)


def test_a_joint_that_closes_a_loop_has_no_displacement():
    s = pendulum()
    closing = s.slider("guide", s.ground, s.bodies["bar"], axis="x")
    s.spring("k", closing, stiffness=1)
    with pytest.raises(
        fb.FreebodyError, match="Spring 'k': slider 'guide' .*closes a loop and has no displacement"
    ):
        fb.equations(s).text()


def test_two_kinds_cannot_have_one_name():
    with pytest.raises(fb.FreebodyError, match="already a kind of load 'spring'"):
        type("Spring", (fb.Load,), {}, kind="spring")
