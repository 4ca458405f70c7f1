"""Laws that switch, with their sides as constants of a run."""

import numpy as np
import pytest

import freebody as fb
from freebody.motion.kernels.hoisted import Hoisted
from freebody.motion.kernels.kernels import kernels_of
from freebody.motion.kernels.sides import SidedTape, sides_of
from freebody.native import loop


def block(law, **parameters):
    s = fb.System("block")
    s.parameters(m=1.0, k=9.0, c=2.0, **parameters)
    body = s.body("block", fb.particle("m"))
    s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.force("law", body, (law, 0, 0))
    return s


@pytest.mark.parametrize("function", ["sign", "abs", "min", "max"])
@pytest.mark.parametrize("x", [-2.5, 2.5])
def test_a_law_on_its_side_is_the_law_itself(function, x):
    tape = SidedTape(True)
    value, other = tape.input("x"), tape.input("y")
    arguments = [value, other] if function in ("min", "max") else [value]
    tape.sided = True
    (sided,) = [tape.apply(function, *arguments)]
    tape.sided = False
    plain = tape.apply(function, *arguments)
    y = 1.0
    side = np.sign(x - y) if len(arguments) == 2 else np.sign(x)
    numbers = {"x": x, "y": y, "side 0": float(side)}
    assert tape.evaluate([sided], numbers) == tape.evaluate([plain], numbers)
    assert tape.evaluate([sided], {**numbers, "side 0": -float(side)}) != tape.evaluate([plain], numbers)


def test_equal_laws_and_their_negatives_have_one_side():
    tape = SidedTape(True)
    x = tape.input("x")
    tape.sided = True
    one, other, third = tape.apply("sign", x), tape.apply("sign", -x), tape.apply("abs", x)
    assert other.minus is one and len(tape.sides) == 1 and tape.jumps == {0}
    assert tape.evaluate([third], {"x": -2.0, "side 0": -1.0}) == [2.0]


def test_signs_only_for_derivatives():
    tape = SidedTape()
    tape.sided = True
    x = tape.input("x")
    assert tape.evaluate([tape.apply("abs", x)], {"x": -2.0}) == [2.0] and not tape.sides


def test_the_laws_of_a_machine():
    sides = sides_of(kernels_of(block("-c*sign(x') - k*abs(x) + max(t - 1, 0)")))
    laws = {law.text: (law.jumps, law.order) for law in sides.laws}
    assert laws == {"x'": (True, 1), "x": (False, 2), "t - 1": (False, 2)}
    order = list(laws)
    at = sides.program.compiled["laws"](
        0.25, [3.0, -4.0, -25.0], sides.program.constants(np.array([1.0, 9.0, 2.0, 1.0, 1.0, 1.0]))
    )
    rows = dict(zip(order, at.reshape(-1, 3).tolist(), strict=True))
    assert rows["x'"] == [-4, -25, 0] and rows["x"] == [3, -4, -25] and rows["t - 1"] == [-0.75, 1, 0]


def counting(sides, at):
    """Return the laws on whose sides the rates depend."""
    hoisted = Hoisted.made(numbers=len(sides.whole.model.parameters) + len(sides.laws), most_programs=1)
    run = sides.run(2, hoisted)
    run.sides[:] = at
    loop.code("motion.kernels.switching", "find_idle")(run)
    return set(np.flatnonzero(run.idle == 0).tolist())


def test_smooth_machines_have_none():
    assert sides_of(kernels_of(block("-k*x"))) is None
    assert sides_of(kernels_of(block("-k*abs(c)"))) is None


def test_a_law_behind_a_factor_that_is_zero_does_not_count():
    """A damper beyond x = 1 only: the side of its max is asked for there alone. Of a clip, the inner law counts for the
    e of the outer one.
    """
    sides = sides_of(kernels_of(block("-max(k*(x - 1) + c*x', 0)*(1 + sign(x - 1))/2")))
    place, push = (sides.texts.index(x) for x in ("x - 1", "c*x' + k*(x - 1)"))
    at = np.ones(2)
    assert counting(sides, at) == {place, push}
    at[place] = -1
    assert counting(sides, at) == {place}
    clip = sides_of(kernels_of(block("-max(min(x, 1), -1)")))
    for one in (-1.0, 1.0):
        for other in (-1.0, 1.0):
            assert counting(clip, np.array([one, other])) == {0, 1}


@pytest.mark.parametrize("x", [-3.0, -0.5, 0.5, 3.0])
def test_laws_within_laws_start_on_their_sides(x):
    s = block("-k*max(min(x, 1), -1)")
    motion = fb.simulate(s, 1e-3, initial={"x": x})
    assert motion["x'"][-1] == pytest.approx(-9e-3 * np.clip(x, -1, 1), rel=1e-4)
