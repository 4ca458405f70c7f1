"""Kernels against the slow evaluation of the same tape."""

from __future__ import annotations

import ctypes
import gc
import math
import platform
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import numpy as np
import pytest

from freebody.errors import ExpressionError
from freebody.native import codegen, target
from freebody.program.code import emit, lower
from freebody.program.kernels import compile_tape
from freebody.scalar.algebra import FUNCTIONS
from freebody.scalar.trace import Tape


@pytest.fixture(autouse=True)
def no_cache(monkeypatch):
    monkeypatch.setenv("FREEBODY_CACHE", "off")


def pendulum(n):
    """Accelerations of n pendulums on a line, each pulled by its neighbours; a program of about 20 n operations."""
    tape = Tape()
    t = tape.input("t")
    q = [tape.input(f"q{i}") for i in range(n)]
    u = [tape.input(f"u{i}") for i in range(n)]
    m, L, g, k = (tape.input(name) for name in "mLgk")
    rates = list(u)
    for i in range(n):
        left = q[i - 1] if i else tape.sin(t)
        right = q[i + 1] if i + 1 < n else 0
        pull = k * (left - 2 * q[i] + right) * tape.cos(q[i]) - u[i] * abs(u[i]) / 3
        rates.append(pull / (m * L * L) - g / L * tape.sin(q[i] + left / 7))
    # a sweep back, so that values live long and sines stand on sines
    for i in reversed(range(n - 1)):
        rates[n + i] = rates[n + i] + tape.sin(rates[n + i + 1]) / (2 + rates[n + i] ** 2)
    return tape, t, q + u, [m, L, g, k], rates


def reference(tape, outputs, inputs, values):
    return np.array(
        tape.evaluate(outputs, {tape.inputs[tape.a[x.index]]: v for x, v in zip(inputs, values, strict=True)})
    )


@pytest.mark.parametrize("piece", [10, 37, 10_000])
@pytest.mark.parametrize("n", [1, 3, 12])
def test_scalar_and_batch_agree_with_the_tape(monkeypatch, n, piece):
    monkeypatch.setattr(emit, "PIECE", piece)
    tape, t, state, parameters, rates = pendulum(n)
    kernels = compile_tape(tape, {"rates": rates, "two": rates[::-2]}, t, state, parameters, batch=["rates"])
    random = np.random.default_rng(n)
    p = random.uniform(0.5, 2, 4)
    c = kernels.constants(p)
    Y = random.standard_normal((21, 2 * n))
    for y in Y[:4]:
        expected = reference(tape, rates, [t, *state, *parameters], [0.3, *y, *p])
        assert kernels["rates"](0.3, y, c) == pytest.approx(expected, rel=1e-13, abs=1e-13)
        assert kernels["two"](0.3, y, c) == pytest.approx(expected[::-2], rel=1e-13, abs=1e-13)
    one = np.stack([kernels["rates"](0.3, y, c) for y in Y])
    assert np.array_equal(kernels["rates"].batch(0.3, Y, c), one)


@pytest.mark.parametrize("piece", [3, 10_000])
@pytest.mark.parametrize("N", [0, 1, 7, 8, 9, 16, 17, 25])
def test_batch_with_own_time_and_parameters(monkeypatch, N, piece):
    monkeypatch.setattr(emit, "PIECE", piece)
    tape, t, state, parameters, rates = pendulum(2)
    kernels = compile_tape(tape, {"rates": rates}, t, state, parameters, batch=["rates"])
    random = np.random.default_rng(N)
    P, Y, T = random.uniform(0.5, 2, (N, 4)), random.standard_normal((N, 4)), random.standard_normal(N)
    C = kernels.constants(P)
    assert C.shape == (N, kernels.hoisted)
    out = kernels["rates"].batch(T, Y, C)
    assert out.shape == (N, 4)
    for i in range(N):
        assert np.array_equal(out[i], kernels["rates"](T[i], Y[i], kernels.constants(P[i])))


def test_batch_writes_no_row_too_many():
    tape = Tape()
    x = tape.input("x")
    kernel = compile_tape(tape, {"f": [2 * x, x]}, None, [x], [], batch=["f"])["f"]
    room = np.full((12, 2), 7.0)
    kernel.batch(0.0, np.arange(9.0)[:, None], (), out=room[:9])
    assert np.array_equal(room[:9, 0], 2 * np.arange(9.0))
    assert (room[9:] == 7).all()


ARGUMENTS = {
    "acos": [0.3], "asin": [0.3], "atan2": [0.3, -0.7], "pow": [1.3, 2.2], "min": [1.0, -2.0], "max": [1.0, 2.0],
}  # fmt: skip


@pytest.mark.parametrize("function", FUNCTIONS)
def test_every_function(function):
    tape = Tape()
    xs = [tape.input("x"), tape.input("y")]
    values = ARGUMENTS.get(function, [1.7])
    outputs = [tape.apply(function, *xs[: len(values)])]
    values = values + [0.0] * (2 - len(values))
    # of the state, and of parameters
    kernels = compile_tape(tape, {"f": outputs}, None, xs, [], batch=["f"])
    hoisting = compile_tape(tape, {"f": outputs}, None, [], xs)
    expected = reference(tape, outputs, xs, values)
    assert kernels["f"](0.0, values, ()) == pytest.approx(expected, rel=4e-16)
    assert kernels["f"].batch(0.0, [values] * 3, ()) == pytest.approx(np.array([expected] * 3), rel=4e-16)
    c = hoisting.constants(values)
    assert c == pytest.approx(expected, rel=4e-16)
    assert hoisting["f"](0.0, (), c) == pytest.approx(expected, rel=4e-16)


@pytest.mark.parametrize(("x", "sign"), [(3.0, 1.0), (-3.0, -1.0), (0.0, 0.0), (math.nan, math.nan)])
def test_sign_and_not_a_number(x, sign):
    tape = Tape()
    v, w = tape.input("v"), tape.input("w")
    functions = {"f": [tape.apply("sign", v), tape.apply("min", v, w), tape.apply("max", v, w)]}
    kernel = compile_tape(tape, functions, None, [v, w], [], batch=["f"])["f"]
    expected = [sign, min(x, 1.0) if x == x else x, max(x, 1.0) if x == x else x]
    assert np.array_equal(kernel(0.0, [x, 1.0], ()), expected, equal_nan=True)
    assert np.array_equal(kernel.batch(0.0, [[x, 1.0]] * 9, ()), [expected] * 9, equal_nan=True)


def test_infinity_and_nan_pass_through():
    tape = Tape()
    x, y = tape.input("x"), tape.input("y")
    kernel = compile_tape(tape, {"f": [x - y, x * y, 1 / x, x + y]}, None, [x, y], [])["f"]
    assert np.array_equal(
        kernel(0.0, [math.inf, math.inf], ()), [math.nan, math.inf, 0, math.inf], equal_nan=True
    )
    assert np.array_equal(
        kernel(0.0, [0.0, math.nan], ()), [math.nan, math.nan, math.inf, math.nan], equal_nan=True
    )


def test_outputs_may_be_numbers_inputs_and_parameters():
    tape = Tape()
    t, x, p = tape.input("t"), tape.input("x"), tape.input("p")
    outputs = [0, Fraction(1, 3), 2.5, x, p, t, p * p, tape.sin(x), -x, tape.cos(p)]
    kernels = compile_tape(tape, {"f": outputs, "none": []}, t, [x], [p], batch=["f"])
    c = kernels.constants([3.0])
    expected = [0, 1 / 3, 2.5, 0.5, 3, 9.0, 9, math.sin(0.5), -0.5, math.cos(3)]
    assert kernels["f"](9.0, [0.5], c) == pytest.approx(expected, rel=1e-15)
    assert kernels["f"].batch([9.0, 9.0], [[0.5], [0.5]], c)[1] == pytest.approx(expected, rel=1e-15)
    assert kernels["none"](0.0, [0.5], c).shape == (0,)


def test_parameters_are_hoisted_and_divisions_shared():
    tape = Tape()
    x, y, p = tape.input("x"), tape.input("y"), tape.input("p")
    dead = tape.sin(x * 5)
    outputs = [x / (p * p + 1), x / y, p / y, y * tape.sin(p)]
    kernels = compile_tape(tape, {"f": outputs}, None, [x, y], [p])
    # 1 / y once; 1 / (p² + 1), p and sin p are constants
    assert kernels.operations["f"] == {"div": 1, "mul": 4}
    assert kernels.operations["parameters"] == {"add": 1, "div": 1, "mul": 1, "sincos": 1}
    assert kernels.hoisted == 3
    c = kernels.constants([0.7])
    expected = reference(tape, outputs, [x, y, p], [2.0, 3.0, 0.7])
    assert kernels["f"](0.0, [2.0, 3.0], c) == pytest.approx(expected, rel=4e-16)
    assert dead.tape is tape


def test_sines_are_grouped_by_depth():
    tape = Tape()
    q = [tape.input(f"q{i}") for i in range(10)]
    total = sum((tape.sin(x) * tape.cos(x + 1) for x in q), 0)
    program = lower.lower(tape, {"f": [tape.sin(total)]}, None, q, [])
    groups = program.bodies["f"].groups
    assert [len(g.arguments) for g in groups] == [8, 8, 4, 1]
    assert [g.lanes for g in groups] == [8, 8, 4, 1]


def test_kernels_are_called_by_address():
    tape, t, state, parameters, rates = pendulum(2)
    kernels = compile_tape(tape, {"rates": rates}, t, state, parameters)
    kernel = kernels["rates"]
    c, y = kernels.constants([1, 2, 3, 4]), np.arange(4.0)
    expected = kernel(0.5, y, c)
    address = kernel.address
    function = ctypes.CFUNCTYPE(None, ctypes.c_double, *[ctypes.c_void_p] * 3)(address)
    del kernels
    gc.collect()  # the kernel alone keeps the code in memory
    out = np.empty(4)
    function(0.5, y.ctypes.data, c.ctypes.data, out.ctypes.data)
    assert np.array_equal(out, expected)


def test_kernels_run_in_threads():
    tape, t, state, parameters, rates = pendulum(6)
    kernels = compile_tape(tape, {"rates": rates}, t, state, parameters, batch=["rates"])
    c = kernels.constants([1, 2, 3, 4])
    Y = np.random.default_rng(0).standard_normal((400, 12))
    expected = kernels["rates"].batch(0.0, Y, c)
    with ThreadPoolExecutor(4) as pool:
        for result in pool.map(lambda _: kernels["rates"].batch(0.0, Y, c), range(16)):
            assert np.array_equal(result, expected)


def test_read_only_and_strided_arrays():
    tape, t, state, parameters, rates = pendulum(2)
    kernels = compile_tape(tape, {"rates": rates}, t, state, parameters)
    c = kernels.constants([1, 2, 3, 4])
    y = np.arange(8.0)[::2]
    frozen = y.copy()
    frozen.flags.writeable = False
    assert np.array_equal(kernels["rates"](0, y, c), kernels["rates"](0, frozen, c))


def test_wrong_arguments_are_refused():
    tape, t, state, parameters, rates = pendulum(2)
    kernels = compile_tape(tape, {"rates": rates}, t, state, parameters)
    kernel, c = kernels["rates"], kernels.constants([1, 2, 3, 4])
    with pytest.raises(
        ExpressionError, match=r"Expected y of shape \(4,\) for kernel 'rates', got shape \(3,\)"
    ):
        kernel(0.0, np.zeros(3), c)
    with pytest.raises(ExpressionError, match=r"Expected c of shape"):
        kernel(0.0, np.zeros(4), np.zeros(99))
    with pytest.raises(ExpressionError, match=r"Expected y of shape \(4,\) for kernel 'parameters'"):
        kernels.constants([1, 2])
    with pytest.raises(ExpressionError, match="Expected out to be a writeable contiguous array of doubles"):
        kernel(0.0, np.zeros(4), c, out=np.zeros(4, dtype="f4"))
    with pytest.raises(ExpressionError, match="Expected a kernel compiled for batches, got 'rates'"):
        kernel.batch(0.0, np.zeros((2, 4)), c)
    with pytest.raises(ExpressionError, match=r"Expected names of functions in batch, got \['rate'\]"):
        compile_tape(tape, {"rates": rates}, t, state, parameters, batch=["rate"])
    with pytest.raises(ExpressionError, match="among its time, state and parameters, got 'k' in none"):
        compile_tape(tape, {"rates": rates}, t, state, parameters[:3])


OTHERS = {"x86-64": "", "haswell": "+avx,+avx2,+fma,+bmi,+bmi2", "this": None}


@pytest.mark.skipif(
    platform.machine().lower() not in ("x86_64", "amd64"), reason="names processors of this family"
)
@pytest.mark.parametrize("name", OTHERS)
def test_shorter_vectors_and_no_fused_operation(monkeypatch, name):
    """Code for processors with 2 and 4 lanes, which run on this one if it has 4."""
    features = codegen.processor()[2]
    if name == "haswell" and not {"+avx2", "+fma"} <= set(features.split(",")):
        pytest.skip("this processor has no AVX2")
    if name != "this":
        fused = name == "haswell"
        other = target.this()._replace(processor=name, features=OTHERS[name], fused=fused)
        monkeypatch.setattr(target, "this", lambda: other)
        monkeypatch.setattr(codegen, "_machine", codegen._new_machine)
        assert codegen.processor()[1] == name and codegen.fused() == fused
    tape, t, state, parameters, rates = pendulum(5)
    kernels = compile_tape(tape, {"rates": rates}, t, state, parameters, batch=["rates"])
    random = np.random.default_rng(5)
    p, Y = random.uniform(0.5, 2, 4), random.standard_normal((13, 10))
    c = kernels.constants(p)
    one = np.stack([kernels["rates"](0.3, y, c) for y in Y])
    expected = reference(tape, rates, [t, *state, *parameters], [0.3, *Y[0], *p])
    assert one[0] == pytest.approx(expected, rel=1e-13, abs=1e-13)
    assert np.array_equal(kernels["rates"].batch(0.3, Y, c), one)


@pytest.mark.parametrize("piece", [10, 10_000])
@pytest.mark.parametrize("before", [0, 3])
def test_long_runs_of_zeros_among_the_outputs(monkeypatch, piece, before):
    """What is set by the loop is 0, what stands beside it its own: every place of an array of nan is written."""
    monkeypatch.setattr(emit, "PIECE", piece)
    tape, t, state, parameters, rates = pendulum(3)
    wanted = [*rates[:before], *[0] * 41, *rates, *[0] * 5, 1, *[0.0] * emit.RUN]
    kernels = compile_tape(tape, {"f": wanted}, t, state, parameters, batch=["f"])
    c = kernels.constants([1.0, 2.0, 3.0, 0.5])
    Y = np.random.default_rng(5).normal(size=(11, 6))
    exact = np.array([reference(tape, rates, [t, *state, *parameters], [0.3, *y, 1, 2, 3, 0.5]) for y in Y])
    zeros = np.zeros((11, 1))
    columns = [exact[:, :before], *[zeros] * 41, exact, *[zeros] * 5, zeros + 1, *[zeros] * emit.RUN]
    expected = np.concatenate(columns, axis=1)
    out = np.full(expected.shape, np.nan)
    kernels["f"].batch(0.3, Y, c, out)
    assert out == pytest.approx(expected, rel=1e-13, abs=1e-13)
    single = np.full(expected.shape[1], np.nan)
    kernels["f"](0.3, Y[0], c, single)
    assert single == pytest.approx(expected[0], rel=1e-13, abs=1e-13)
    assert (single[before : before + 41] == 0).all()
