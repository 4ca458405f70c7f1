"""Springs on sliders in an animation: from a wall to the body, beside one another, never shorter than nothing."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.dynamics.state import float_state
from freebody.picture.moving.joint_springs import joint_springs
from freebody.picture.moving.keyframes import keyframes


def cart(axis: str) -> fb.Trajectory:
    s = fb.System("cart")
    m, k, c = s.parameters(m=1, k=20, c=0.1)
    guide = s.slider(
        "guide", s.ground, s.body("cart", fb.particle(m)), axis=axis, at=(1, 2, 3), coordinate="x"
    )
    s.spring("k", guide, stiffness=k)
    s.damper("c", guide, damping=c)
    return fb.simulate(s, until=2, initial={"x": 0.5})


def test_a_spring_and_a_damper_stand_beside_each_other_between_a_wall_and_the_body() -> None:
    for axis, k in (("x", 0), ("-y", 1)):
        motion = cart(axis)
        keys = keyframes(motion)
        model = motion.kernels.model
        lines, walls = joint_springs(model, float_state(model, values=motion.values), keys, 1.0)
        assert [line["kind"] for line in lines] == ["spring", "damper"] and len(walls) == 1
        sign = -1 if axis.startswith("-") else 1
        start = np.array(lines[0]["ends"][0][1])
        assert lines[0]["ends"][0][0] == -1 and lines[0]["ends"][1][0] == 0
        # the wall is 0.45 of the size beyond the place where the body comes nearest
        nearest = min(0.0, float((sign * (keys.position[:, 0, k] - (1, 2, 3)[k])).min()))
        assert np.isclose(sign * (start[k] - (1, 2, 3)[k]) - nearest, -0.45)
        # both lines are parallel to the axis
        for line in lines:
            along = keys.position[0, 0] + np.array(line["ends"][1][1]) - np.array(line["ends"][0][1])
            assert np.allclose(np.delete(along, k), 0, atol=1e-12) and sign * along[k] > 0.4
        assert not np.allclose(lines[0]["ends"][0][1], lines[1]["ends"][0][1])


def test_a_spring_between_two_points_is_not_drawn_twice() -> None:
    s = fb.System("pair")
    a, b = (s.body(name, fb.particle(1)) for name in "ab")
    s.slider("A", s.ground, a, axis="x", coordinate="x")
    s.slider("B", s.ground, b, axis="x", at=(2, 0, 0), coordinate="y")
    s.spring("k", a.origin, b.origin, stiffness=5, rest=2)
    motion = fb.simulate(s, until=1, initial={"x": 0.1})
    model = motion.kernels.model
    state = float_state(model, values=motion.values)
    assert joint_springs(model, state, keyframes(motion), 1.0) == ([], [])
