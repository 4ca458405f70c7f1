"""Functions that differ only in numbers and components of the state share a body, and give what they give alone."""

import numpy as np
import pytest

from freebody.program.code.kinds import LEAST
from freebody.program.code.lower import lower
from freebody.program.kernels import compile_tape
from freebody.scalar.trace import Tape


def chain(tape, x, y, a, b, length=LEAST):
    """A long function of two inputs and two numbers, with sines and a quotient."""
    z = x
    for _ in range(length):
        z = tape.sin(z) * a + y * b - z / (2 + y * y)
    return [z, x * y * a, z - b]


def compared(tape, functions, state, parameters=()):
    """Check that functions give together what each gives alone; return their program."""
    together = compile_tape(tape, functions, None, state, parameters)
    rng = np.random.default_rng(7)
    y, p = rng.normal(size=len(state)), rng.normal(size=len(parameters))
    for name, outputs in functions.items():
        alone = compile_tape(tape, {name: outputs}, None, state, parameters)
        expected = alone[name](0.0, y, alone.constants(p))
        found = together[name](0.0, y, together.constants(p))
        assert found == pytest.approx(expected, rel=1e-13, abs=1e-13), name
    return lower(tape, functions, None, state, parameters)


def members(program):
    return sorted({tuple(sorted(kind.members)) for kind in program.kinds.values()})


def test_other_components_of_the_state():
    tape = Tape()
    q = [tape.input(f"q{i}") for i in range(4)]
    functions = {f"f{i}": chain(tape, q[i], q[(i + 1) % 4], 3, 5) for i in range(4)}
    assert members(compared(tape, functions, q)) == [("f0", "f1", "f2", "f3")]


def test_other_numbers_and_parameters():
    tape = Tape(numbers_are_data=True)
    x, y, m, r = map(tape.input, "xymr")
    pairs = [(m, r), (tape.datum(0.3), tape.datum(0.4)), (r, m), (m * r, tape.datum(-0.5)), (m, m)]
    functions = {f"f{i}": chain(tape, x, y, a, b) for i, (a, b) in enumerate(pairs)}
    program = compared(tape, functions, [x, y], [m, r])
    assert members(program) == [("f0", "f1", "f2", "f3", "f4")]
    assert len(program.kinds["f4"].numbers) == 2


def test_what_all_read_alike_stays_as_it_is():
    tape = Tape()
    x, y, z, m, r, s = map(tape.input, "xyzmrs")
    functions = {"f": chain(tape, x, y, m, r), "g": chain(tape, x, z, m, s)}
    kind = compared(tape, functions, [x, y, z], [m, r, s]).kinds["f"]
    assert len(kind.numbers) == len(kind.places) == 1


def test_a_function_whose_leaves_are_equal_is_an_instance_and_no_other_is():
    tape = Tape()
    x, y, z, m, r = map(tape.input, "xyzmr")
    functions = {
        "equal": chain(tape, x, x, m, r),
        "general": chain(tape, y, z, m, r),
        "other": [out + 1 for out in chain(tape, x, z, m, r)],
        "short": [x + m],
        "brief": [y + m],
    }
    program = compared(tape, functions, [x, y, z], [m, r])
    assert members(program) == [("equal", "general")]
    assert program.kinds["equal"].name == "general"


def test_two_patterns_of_equal_leaves_are_two_kinds():
    tape = Tape()
    x, y, z = map(tape.input, "xyz")

    def of(a, b, c):
        return [u - 2 * v for u, v in zip(chain(tape, a, b, 3, 5), chain(tape, b, c, 3, 5), strict=True)]

    functions = {"aab": of(x, x, y), "aba": of(x, y, x), "bba": of(y, y, x)}
    assert members(compared(tape, functions, [x, y, z])) == [("aab", "bba")]


def test_factors_and_summands_may_be_exchanged():
    tape = Tape()
    x, y, z = map(tape.input, "xyz")
    later = tape.sin(z)  # known before the factor beside it in one function, and after it in the other
    first, second = tape.cos(x), tape.cos(y)
    functions = {"f": chain(tape, later * first, first + later, 3, 5)}
    functions["g"] = chain(tape, second * tape.sin(x), tape.sin(x) + second, 3, 5)
    assert members(compared(tape, functions, [x, y, z])) == [("f", "g")]


def test_long_functions_are_shared_in_pieces():
    tape = Tape()
    x, y, z, m, r = map(tape.input, "xyzmr")
    functions = {"f": chain(tape, x, y, m, 5, 600), "g": chain(tape, y, z, r, 5, 600)}
    assert members(compared(tape, functions, [x, y, z], [m, r])) == [("f", "g")]


def test_zeros_of_one_function_are_numbers_of_the_other():
    tape = Tape()
    x, y, m = map(tape.input, "xym")
    functions = {
        "f": [*chain(tape, x, y, m, 5), *[0] * 12],
        "g": [*chain(tape, y, x, m, 5), *[m] * 12],
    }
    assert members(compared(tape, functions, [x, y], [m])) == [("f", "g")]


def test_functions_of_batches_and_series_stay_alone():
    tape = Tape()
    x, y = map(tape.input, "xy")
    functions = {"f": chain(tape, x, y, 3, 5)[:2], "g": chain(tape, y, x, 3, 5)[:2]}
    assert not lower(tape, functions, None, [x, y], [], {"f", "g"}).kinds
    kernels = compile_tape(tape, functions, None, [x, y], [], batch=["f"])
    states = np.random.default_rng(2).normal(size=(9, 2))
    for f, turned in zip(
        kernels["f"].batch(np.zeros(9), states, kernels.constants([])), states[:, ::-1], strict=True
    ):
        assert f == pytest.approx(kernels["g"](0.0, turned, kernels.constants([])), rel=1e-13)
