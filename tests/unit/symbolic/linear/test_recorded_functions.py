"""Linear equations at arrays of values, in one call, against one call for each value."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.errors import ExpressionError, ModelError
from freebody.gallery.beyond.whipple_bicycle import LEAN_AND_STEER
from freebody.gallery.beyond.whipple_bicycle import build as bicycle
from freebody.scalar.algebra import FUNCTIONS
from freebody.scalar.replay import Replay
from freebody.scalar.trace import Tape
from freebody.symbolic.linear.recorded_functions import recorded

RIDING = {"air_vx": "v", "theta_R'": "-v/r_R", "theta_F'": "-v/r_F"}


def pendulum(length=1.0):
    s = fb.System("pendulum")
    m, g, c = s.parameters(m=1, g=9.81, c=0.3)
    s.gravity = (0, -g, 0)
    pin = s.hinge("pin", s.ground, s.body("bob", fb.particle(m)), to=(0, length, 0), coordinate="theta")
    s.damper("c", pin, damping=c)
    return s


def governor():
    """A bead on a turning hoop: it stands where cos θ = g/(R W²)."""
    s = fb.System("hoop")
    m, R, g, W = s.parameters(m=1.5, R=0.5, g=9.81, W=8)
    s.gravity = (0, 0, -g)
    arm = s.body("arm", fb.particle(0))
    s.hinge("shaft", s.ground, arm, axis="z", coordinate=W * s.t)
    s.hinge("pin", arm, s.body("bead", fb.particle(m)), to=(0, 0, R), axis="y", coordinate="theta")
    return s


def top():
    s = fb.System("top")
    m, r, g, n = s.parameters(m=1, r=0.1, g=9.81, n=100)
    s.gravity = (0, 0, -g)
    s.ball("tip", s.ground, s.body("top", fb.disk(m, r)), to=(0, 0, -r))
    return s


def loop():
    """A rod between two guides, in three coordinates and two conditions, held by a spring."""
    s = fb.System("rod")
    s.parameters(g=10, F=0, k=30, L=1)
    s.gravity = (0, "-g", 0)
    body = s.body("rod", fb.slender_bar(2, 1, axis="y"))
    s.planar("p", s.ground, body, coordinate="x y f")
    s.constrain("x - L*sin(f)/2", name="cx")
    s.constrain("y + L*cos(f)/2", name="cy")
    s.generalized_force("f", "F - k*f")
    return s


MACHINES = {
    "pendulum": (pendulum, {}, {"c": [0, 0.5, 30], "m": 2}, {}),
    "hoop": (governor, {"theta": "acos(g/(R*W^2))"}, {"W": [5, 6.5, 9]}, {"inputs": "m"}),
    "top": (top, {"tip_wz": "n"}, {"n": [0, 40, 90.5], "r": [0.1, 0.12, 0.1]}, {}),
    "rod": (loop, {}, {"L": [0.7, 1, 1.4], "k": [3, 30, 20]}, {"inputs": "F", "independent": "f"}),
    "bicycle": (bicycle, RIDING, {"v": [0, 2.5, 6]}, {"independent": LEAN_AND_STEER}),
}


@pytest.mark.parametrize("name", MACHINES)
def test_many_values_are_each_alone(name):
    build, about, values, options = MACHINES[name]
    s = build()
    many = fb.linearize(s, about, values=values, **options)
    roots = many.eigenvalues()
    size = 2 * len(many.coordinates) + len(many.carried)
    assert many.M.shape == (3, *2 * (len(many.coordinates),)) and roots.shape == (3, size)
    for k in range(3):
        each = {key: x[k] if np.ndim(x) else x for key, x in values.items()}
        alone = fb.linearize(build(), about, values=each, **options)
        assert many.carried == alone.carried
        for key in ("M", "C", "K", "B", "damping", "gyroscopic", "stiffness"):
            one, other = getattr(many, key)[k], getattr(alone, key)
            # the same operations, but for functions of NumPy and of the C library, two units in the last place apart
            assert np.abs(one - other).max(initial=0) <= 1e-12 * np.abs(getattr(alone, key)).max(initial=1)
        scale = np.abs(alone.eigenvalues()).max()
        # double roots (at zero: rigid body) move with the root of round-off
        assert np.abs(np.poly(roots[k]) - np.poly(alone.eigenvalues())).max() <= 1e-9 * max(1, scale) ** size
        assert many[k].point == pytest.approx(alone.point, abs=1e-12) and many[k].values == alone.values
        assert many[k].modes().text() == alone.modes().text()


def test_bead_on_a_hoop_against_its_closed_form():
    W = np.array([[5.0, 6.0], [7.0, 12.0]])
    many = fb.linearize(governor(), {"theta": "acos(g/(R*W^2))"}, values={"W": W})
    square = W**2 - (9.81 / 0.5 / W) ** 2  # small motions: W² sin²θ
    assert many.eigenvalues()[..., 0].imag == pytest.approx(np.sqrt(square), rel=1e-12)
    assert many[1, 0].natural_frequencies() == pytest.approx([np.sqrt(square[1, 0])], rel=1e-12)
    assert "at 4 values" in repr(many)


def test_texts_with_units_and_relations_in_arrays():
    s = pendulum()
    found = fb.linearize(s, values={"m": ["500 g", "2 kg"]}, where={"c": "m/10"})
    assert found.C.reshape(-1) == pytest.approx([0.05, 0.2]) and found.values["m"] == pytest.approx([0.5, 2])


def test_programs_are_recorded_once_and_never_shared():
    s = pendulum()
    first = fb.linearize(s, values={"c": 1})
    programs = recorded(s)
    fb.linearize(s, values={"c": [2, 3]})
    assert recorded(s) is programs and len(programs._programs) == 1
    # another number written in the model; a load, and gravity, that come later
    assert fb.linearize(pendulum(2.0), values={"c": 1}).M.item() == pytest.approx(4 * first.M.item())
    s.generalized_force("theta", "-5*theta")
    assert fb.linearize(s, values={"c": 1}).K.item() == pytest.approx(first.K.item() + 5)
    s.gravity = (0, -1, 0)
    assert fb.linearize(s, values={"c": 1}).K.item() == pytest.approx(6)
    assert fb.linearize(s, values={"c": 1}, inputs="theta").B.item() == 1


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: fb.linearize(pendulum(), values={"c": []}), "at least one value of 'c' in values=, got an empty"),
        (lambda: fb.linearize(pendulum(), values={"c": [1, 2], "m": [1, 2, 3]}), r"shape, got c: \(2,\), m: \(3,\)"),
        (lambda: fb.linearize(pendulum(), values={"c": [[1, 2], [3]]}), r"rows of one length for 'c'.*\[\[1, 2"),
        (lambda: fb.linearize(pendulum(), values={"m": [1, -2]}), "Expected m > 0 in .*m = -2"),
        (lambda: fb.linearize(pendulum(), values={"q": [1, 2]}), "Unknown parameter 'q'"),
        (lambda: fb.linearize(governor(), {"theta": 0.5}, values={"W": [8, 9]}), "'hoop' at W = 8: .* leave theta: "),
        (lambda: fb.linearize(loop(), {"f": 1}, values={"L": [1, 2]}), "'rod' at L = 1: .* its independent"),
        (lambda: fb.linearize(pendulum(), values={"c": [1, 2]}).modes(), "at 2 values; modes.. is for one. Take"),
        (lambda: fb.linearize(pendulum(), values={"c": 1})[0], "'pendulum' are of one state: they have no index"),
    ],
)  # fmt: skip
def test_refusals(call, text):
    with pytest.raises((ModelError, ExpressionError), match=text):
        call()


def test_a_value_without_a_finite_answer_is_refused():
    with pytest.raises(ExpressionError, match="Expected a finite number, got nan"):
        fb.linearize(pendulum(), values={"c": [1, np.nan]})


def test_coordinates_that_do_not_do_at_all_values_are_refused():
    s = loop()
    s.parameters(alpha=0)
    free = {"g": 0, "k": 0, "alpha": [0.1, 0.2, np.pi / 2]}
    text = "'rod' chosen at the first state are not independent at alpha = 1.5708: .* independent="
    with pytest.raises(ModelError, match=text):
        fb.linearize(s, {"f": "alpha"}, values=free, independent="x")
    assert fb.linearize(s, {"f": "alpha"}, values=free, independent="f").M.shape == (3, 1, 1)


def test_root_locus_of_many_values():
    speeds = np.linspace(0, 4, 5)
    linear = fb.linearize(pendulum(), values={"c": speeds})
    ax = fb.plot.root_locus(linear, "c", speeds, over="parameter")
    found = np.array([line.get_ydata()[2] for line in ax.get_lines()[:4:2]])
    assert sorted(found) == pytest.approx(sorted(linear.eigenvalues()[2].real))
    with pytest.raises(ModelError, match="at these values: fb.linearize"):
        fb.plot.root_locus(linear, "c", speeds + 1)


def test_replay_is_the_tape():
    tape = Tape()
    x, y = tape.input("x"), tape.input("y")
    outputs = [x / y, -x, 3, tape.apply("atan2", x, y), tape.apply("pow", x, y), tape.apply("max", x, y), x]
    outputs += [tape.apply(name, x / 2) for name in FUNCTIONS if name not in ("atan2", "pow", "min", "max")]
    points = np.random.default_rng(0).uniform(0.1, 1, (2, 2500))
    many = Replay(tape, outputs)(points)
    for k in (0, 1500, 2499):
        plain = tape.evaluate(outputs, {"x": points[0, k], "y": points[1, k]})
        assert many[:, k] == pytest.approx(plain, rel=1e-15 * 8)
        assert Replay(tape, outputs)(points[:, k : k + 1])[:, 0] == pytest.approx(plain, rel=1e-15 * 8)
    assert Replay(tape, [x / y])([[1.0], [0.0]])[0, 0] == np.inf
