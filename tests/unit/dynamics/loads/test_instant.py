"""What a kind may ask of the machine at a state: each question, with numbers, formulas and compiled code."""

# ruff: noqa: E501 (tables: one case, one line)

from __future__ import annotations

import math
import sys

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.scalar.algebra import FUNCTIONS

WIND = fb.signal([0, 1, 2], [1.0, 3.0, 2.0], kind="cubic", name="wind")


class Asked(fb.Load):
    """A force along x of the ground, whose value is an answer of `at`."""

    point: fb.Point
    body: fb.Body
    joint: fb.Joint
    factor: fb.Expression

    def actions(self, at):
        yield fb.PointForce(self.point, (self.answer(at), 0, 0))


def machine(answer):
    """An arm on a slider on the ground; ``answer`` is what the load asks."""
    s = fb.System("asked")
    c = s.parameters(c=0.7)
    cart, arm = s.body("cart", fb.particle(2)), s.body("arm", fb.box(1, (1, 2, 3)))
    rail = s.slider("rail", s.ground, cart, axis="x", coordinate="x")
    pin = s.hinge("pin", cart, arm, axis=(1, 2, 2), to=(0, 1, 0), coordinate="phi")
    kind = type("Answering", (Asked,), {"answer": answer})
    s.add("ask", kind(arm.point(1, 2, 3), arm, pin, c))
    return s, cart, arm, rail


X, PHI, U, W, T, C = 0.3, 0.5, 0.7, -1.1, 0.4, 0.7
N = np.array([1, 2, 2]) / 3
K = np.array([[0, -N[2], N[1]], [N[2], 0, -N[0]], [-N[1], N[0], 0]])
R = np.eye(3) + math.sin(PHI) * K + (1 - math.cos(PHI)) * K @ K
PLACE = np.array([X, 0, 0]) + R @ np.array([1, 1, 3])
ARM = PLACE - [X, 0, 0]
VELOCITY = np.array([U, 0, 0]) + np.cross(W * N, ARM)

QUESTIONS = {
    "position of a point": (lambda self, at: at.position(self.point).y, PLACE[1]),
    "position in the axes of a body": (lambda self, at: at.position(self.point, frame=self.body).z, (R.T @ PLACE)[2]),
    "position of a body": (lambda self, at: at.position(self.body).x, X + (R @ [0, -1, 0])[0]),
    "velocity of a point": (lambda self, at: at.velocity(self.point).z, VELOCITY[2]),
    "velocity in the axes of a body": (lambda self, at: at.velocity(self.point, frame=self.body).x, (R.T @ VELOCITY)[0]),
    "angular velocity": (lambda self, at: at.angular_velocity(self.body).y, W * N[1]),
    "angular velocity in a frame": (lambda self, at: at.angular_velocity(self.body, frame=self.body).z, W * N[2]),
    "orientation": (lambda self, at: at.rotation(self.body)[0][1], R[0, 1]),
    "vector of a frame": (lambda self, at: at.vector((1, "c", 2), self.body).y, (R @ [1, C, 2])[1]),
    "line between points": (lambda self, at: at.line(self.body, self.point).norm(), math.sqrt(14)),
    "displacement": (lambda self, at: at.displacement(self.joint), PHI),
    "rate": (lambda self, at: at.rate(self.joint), W),
    "time": (lambda self, at: at.t, T),
    "parameter": (lambda self, at: at(self.factor), C),
    "expression": (lambda self, at: at("c*x' + sin(phi)"), C * U + math.sin(PHI)),
    "sum of products": (lambda self, at: at.velocity(self.point).dot((1, 2, 3)), VELOCITY @ [1, 2, 3]),
    "cross product": (
        lambda self, at: at.position(self.point).cross(at.velocity(self.point)).z, np.cross(PLACE, VELOCITY)[2],
    ),
    "where": (lambda self, at: at.where(at.rate(self.joint), 1, at.t), T),
    "atan2": (lambda self, at: at.atan2(at.position(self.point).y, at.position(self.point).x), math.atan2(PLACE[1], PLACE[0])),
}  # fmt: skip


def force(s):
    """The force by numbers, formulas and compiled code at the state of this file."""
    expression = fb.equations(s).free_body("arm").forces["ask"][0]
    values = {"x": X, "phi": PHI, "x'": U, "phi'": W}
    atoms = {s.expression(name): value for name, value in values.items()} | {
        s.t: T,
        sympy.Symbol("c", real=True): C,
    }
    speeds = {a: v for a, v in atoms.items() if isinstance(a, sympy.Derivative)}
    formula = float(expression.subs(speeds).subs(atoms))
    program = fb.compile(s)
    loaded = program.inverse_dynamics([X, PHI], [U, W], [0, 0], t=T)
    bare = machine(lambda self, at: 0)[0]
    unloaded = fb.compile(bare).inverse_dynamics([X, PHI], [U, W], [0, 0], t=T)
    return formula, float(unloaded[0] - loaded[0])


@pytest.mark.parametrize("question", QUESTIONS)
def test_questions(question):
    answer, expected = QUESTIONS[question]
    s, *_ = machine(answer)
    assert force(s) == pytest.approx((expected, expected), rel=1e-12)


def test_every_function_of_the_algebra():
    """Values of all functions at once, against Python's."""
    arguments = {
        name: ((0.3, 0.6) if name in ("pow", "atan2", "min", "max") else (0.3,)) for name in FUNCTIONS
    }
    for name, values in arguments.items():
        if name == "acosh":
            arguments[name] = (1.3,)
        s, *_ = machine(
            lambda self, at, name=name, values=values: getattr(at, name)(
                *[x * at(self.factor) / 0.7 for x in arguments[name]]
            )
        )
        python = {"abs": abs, "min": min, "max": max, "sign": lambda x: math.copysign(1, x)}
        expected = python.get(name, getattr(math, name, None))
        expected = getattr(np, name) if expected is None else expected
        program = fb.compile(s)
        found = -float(program.inverse_dynamics([0, 0], [0, 0], [0, 0])[0])
        assert found == pytest.approx(float(expected(*arguments[name])), rel=1e-12), name


def test_signals():
    """A signal is data of a kind; the load has its value at the time."""
    s, cart, arm, _ = machine(lambda self, at: 0)
    kind = type("Blown", (Asked,), {"answer": lambda self, at: at(self.factor)})
    s.add("wind", kind(cart.origin, arm, s.joints["pin"], WIND))
    found = [-float(fb.compile(s).inverse_dynamics([0, 0], [0, 0], [0, 0], t=t)[0]) for t in (0, 0.5, 1)]
    assert found == pytest.approx([1, float(WIND(0.5)), 3], rel=1e-12)


def test_where_is_located():
    s, *_ = machine(lambda self, at: at.where(at.displacement(self.joint) - at(self.factor), 0, 1))
    motion = fb.simulate(s, 2, initial={"phi'": 1})
    (event, *_) = motion.events
    assert "switches" in str(event)
    assert motion.at(event.time)["phi"] == pytest.approx(0.7, abs=1e-9)


def test_a_new_kind_is_one_file_and_no_line_elsewhere(tmp_path, monkeypatch):
    """A file of a user, imported, is in every product; nothing of the package is changed or knows it."""
    source = """
import freebody as fb

class Breeze(fb.Load, kind="breeze_of_one_file"):
    point: fb.Point
    factor: fb.Expression

    def actions(self, at):
        v = at.velocity(self.point) - at.vector((at.sin(at.t), 0, 0))
        yield fb.PointForce(self.point, -at(self.factor) * v.norm() * v)
"""
    (tmp_path / "breeze.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    before = {name: set(vars(module)) for name, module in sys.modules.items() if name.startswith("freebody.")}
    import breeze

    after = {name: set(vars(sys.modules[name])) for name in before}
    assert after == before
    s = fb.System("kite")
    m, k, g = s.parameters(m=1.0, k=0.2, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, 2, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, 1, 0), axis="z", coordinate="theta")
    s.add("wind", breeze.Breeze(bar.point(0, -1, 0), k))
    s.contact("floor", bar.point(0, -1, 0), s.ground.plane(at=(0, -1.9, 0), normal="y"), friction=0.3)
    e = fb.equations(s)
    assert "wind" in e.free_body("bar").forces and "sin(t)" in e.text()
    assert "k" in str(e.reactions["pin"].force)
    motion = fb.simulate(s, 1, initial={"theta": 1.0})
    assert abs(motion.energy.residual).max() < 1e-7
    batch = fb.simulate(s, 0.2, initial={"theta": np.linspace(0.5, 1, 8)}, outputs=["theta"])
    assert batch["theta"].shape[0] == 8
    program = fb.compile(s)
    assert "sin(" in program.to_c("forward_dynamics").source
    pytest.importorskip("casadi", reason="extra") and program.to_casadi("forward_dynamics")
    assert 'data-load="wind"' in fb.draw(s).svg and "wind" in fb.free_body_diagram(s, "bar").svg
    fb.report(s, motion, tmp_path / "report.html")
    assert "<td>breeze</td>" in (tmp_path / "report.html").read_text(encoding="utf-8")
    fb.write(s, tmp_path / "kite.toml")
    assert 'kind = "breeze_of_one_file"' in (tmp_path / "kite.toml").read_text(encoding="utf-8")
    assert fb.equations(fb.read(tmp_path / "kite.toml")).text() == e.text()
