"""What a process pool brings back: motions, equations and programs go through pickle and copy unchanged."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest

import freebody as fb
from freebody.describe.description import changes_of
from freebody.motion.kernels import kernels as room
from motions import MOTIONS, assert_same, ball, driven, pendulum, plain


@pytest.fixture(scope="module")
def made():
    """Each motion once."""
    known = {}
    return lambda name: known.setdefault(name, MOTIONS[name]())


@pytest.mark.parametrize("name", MOTIONS)
def test_motion_goes_through_pickle(made, name, monkeypatch):
    monkeypatch.setattr(
        room, "_unpacked", room._unpacked.__wrapped__
    )  # as in a process that does not know the machine
    motion = made(name)
    again = pickle.loads(pickle.dumps(motion))
    assert again.kernels is not motion.kernels
    assert_same(motion, again)
    assert_same(motion, pickle.loads(pickle.dumps(again)))


@pytest.mark.parametrize("name", MOTIONS)
def test_copies_of_a_motion_are_its_own(made, name):
    motion = made(name)
    deep = copy.deepcopy(motion)
    assert_same(motion, deep)
    before = motion.states[0].copy()
    deep.states[0] += 1
    deep.path.states[0] += 1
    deep.values["new"] = 1.0
    assert np.array_equal(motion.states[0], before)
    assert "new" not in motion.values
    assert_same(motion, copy.copy(motion))


def test_motions_of_one_machine_bring_it_once():
    motion = plain()
    a, b = (pickle.loads(pickle.dumps(motion)) for _ in range(2))
    assert a.kernels is b.kernels


def test_function_that_can_not_travel_is_left_behind_and_says_so():
    again = pickle.loads(pickle.dumps(driven()))
    (controller,) = again.kernels.model.controllers
    with pytest.raises(
        fb.errors.SimulationError, match=r"function of controller 'controller', .* no function of"
    ):
        controller.function(0.0, {})
    with pytest.raises(fb.errors.SimulationError, match="it stayed in the process that made this motion"):
        fb.simulate(again.kernels.model, 1)


def test_failed_motion_comes_with_its_error():
    s = fb.System("pole")
    body = s.body("body", fb.particle(1))
    s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.generalized_force("x", "1/(1 - t)^2")
    with pytest.raises(fb.errors.SimulationError) as caught:
        fb.simulate(s, 2)
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value)
    assert repr(again.trajectory) == repr(caught.value.trajectory)


POOL = """
import multiprocessing, sys
from concurrent.futures import ProcessPoolExecutor
import freebody as fb

def run(angle):
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), axis="z", coordinate="theta")
    return fb.simulate(s, 1, initial={"theta": angle}), fb.equations(s), fb.compile(s)

if __name__ == "__main__":
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        for angle, (motion, equations, program) in zip((0.5, 1.0), pool.map(run, (0.5, 1.0))):
            print(motion["theta"][0], motion.reactions["pin"].force.shape, motion.at(0.3)["theta"] < angle)
            print(equations.text().splitlines()[0], program.mass_matrix([0.0]).item())
"""


def test_process_pool_brings_everything_back(tmp_path):
    (tmp_path / "pool.py").write_text(POOL)
    done = subprocess.run(
        [sys.executable, "pool.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False,
        env={**__import__("os").environ, "PYTHONPATH": str(next(iter(fb.__path__)) + "/..")},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == "0.5 (401, 3) True"
    assert lines[2] == "1.0 (401, 3) True"
    assert lines[1] == lines[3]


@pytest.mark.parametrize("through", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_equations_and_programs(through):
    s = pendulum()
    equations, program = fb.equations(s), fb.compile(s)
    text, matrix = equations.text(), program.mass_matrix([0.3])
    assert through(equations).text() == text
    assert through(equations).motion == equations.motion
    again = through(program)
    assert again.mass_matrix([0.3]) == matrix
    assert again.forward_dynamics([0.3], [0.1]) == program.forward_dynamics([0.3], [0.1])


def test_equations_in_modes_keep_them():
    s = ball().kernels.model.described[0]
    equations = fb.equations(s, modes={"floor": "slip+"})
    assert pickle.loads(pickle.dumps(equations)).text() == equations.text()


@pytest.mark.parametrize("through", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_copies_of_a_system_share_nothing(through):
    """Change everything that can be changed, on either side: the other one's text stays."""
    from freebody.formats.toml.write import toml_text

    def change(s, name):
        p = s.parameters(**{name: 2.0})
        s.gravity = (0, 0, -p)
        body = s.body(f"body_{name}", fb.sphere(p, 1))
        joint = s.hinge(f"joint_{name}", s.bodies["bar"], body, axis="z", coordinate=f"q_{name}")
        s.spring(f"spring_{name}", joint, stiffness=p)
        s.force(f"force_{name}", body.origin, (p, 0, 0))
        s.contact(f"contact_{name}", body.sphere(1), s.ground.plane())
        s.constrain(s.expression(f"q_{name}") - s.expression("theta"))
        s.describe(p, unit="N")
        s.assume(p > 0)
        s.controller(print, 1, p, name=f"controller_{name}")

    s = pendulum()
    text, before = toml_text(s), fb.simulate(s, 1, initial={"theta": 1})["theta"]
    other = through(s)
    assert other is not s
    assert toml_text(other) == text
    assert all(body.system is other for body in (other.ground, *other.bodies.values()))
    change(other, "x")
    assert toml_text(s) == text
    assert changes_of(s).count != changes_of(other).count
    third = through(s)
    change(s, "y")
    assert toml_text(third) == text
    assert np.array_equal(fb.simulate(third, 1, initial={"theta": 1})["theta"], before)
    assert "joint_y" not in other.joints
