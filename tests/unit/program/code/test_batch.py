"""Rows of arrays to lanes of vectors, and back."""

from __future__ import annotations

import ctypes
import mmap
import sys

import numpy as np
import pytest

import freebody as fb
from freebody.native import codegen, translation
from freebody.program.code import batch
from freebody.program.kernels import compile_tape
from freebody.scalar.trace import Tape

CASES = {
    "gather": "ptr %source, i64 %row, i64 %n, i64 %width, i64 %stride, ptr %target",
    "gather_parts": "ptr %parts, i64 %row, i64 %n, i64 %state, ptr %target",
    "scatter": "ptr %source, i64 %row, i64 %n, i64 %width, ptr %target",
    "deliver": "ptr %source, ptr %places, i64 %row, i64 %n, i64 %width, ptr %target",
}


@pytest.fixture(scope="module", params=[1, 2, 4, 8])
def moved(request):
    """The functions of so many lanes."""
    lanes = request.param
    texts = {}
    for name in CASES:
        texts |= translation.parts({f"{name}.{lanes}": getattr(batch, name)}, lanes)
    text = "\n".join([*texts.values(), ""])
    for name, given in CASES.items():
        text += f"define void @{name}({given}) {{\n  call void @{name}.{lanes}({given})\n  ret void\n}}\n"
    library = codegen.Library(codegen.object_code(f'target triple = "{codegen.processor()[0]}"\n{text}'))

    def call(name, *values):
        kinds = [
            ctypes.c_void_p if part.startswith("ptr") else ctypes.c_int64 for part in CASES[name].split(", ")
        ]
        given = [x.ctypes.data if isinstance(x, np.ndarray) else x for x in values]
        ctypes.CFUNCTYPE(None, *kinds)(library.addresses([name])[name])(*given)

    return lanes, call


def vectors(count, lanes):
    """An array of vectors on a line of the cache, and room behind it that must stay as it is."""
    room = np.full((count + 2) * lanes + 8, np.nan)
    start = -room.ctypes.data // 8 % 8
    return room[start : start + (count + 1) * lanes].reshape(count + 1, lanes)


def cases(lanes):
    for width in (0, 1, 2, 3, 4, 5, 7, 8, 13):
        for n in (1, lanes, lanes + 1, 2 * lanes + 3):
            for row in range(0, n, lanes):
                yield width, n, row


def test_rows_become_lanes(moved):
    lanes, call = moved
    random = np.random.default_rng(lanes)
    for width, n, row in cases(lanes):
        source = random.uniform(size=(n, width + 3))
        part = source[:, :width]
        for rows in (part.copy(), part, np.broadcast_to(part[0], part.shape), part[::-1]):
            target = vectors(width, lanes)
            call("gather", rows, row, n, width, rows.strides[0] // 8, target)
            for k in range(lanes):
                assert np.array_equal(target[:width, k], rows[min(row + k, n - 1)])
            assert np.isnan(target[width]).all()


def test_lanes_become_rows(moved):
    lanes, call = moved
    random = np.random.default_rng(lanes)
    for width, n, row in cases(lanes):
        source = vectors(20, lanes)
        source[:] = random.uniform(size=source.shape)
        places = random.integers(0, 20, width)
        for name, given, columns in (
            ("scatter", (source,), source[:width]),
            ("deliver", (source, places), source[places]),
        ):
            target = np.full((n + 1, width), np.nan)
            call(name, *given, row, n, width, target)
            last = min(row + lanes, n)
            assert np.array_equal(target[row:last], columns.T[: last - row])
            assert np.isnan(target[:row]).all() and np.isnan(target[last:]).all()


def test_rows_in_parts(moved):
    lanes, call = moved
    n = lanes + 3
    random = np.random.default_rng(lanes)
    a, b, c = random.uniform(size=(n, 5)), random.uniform(size=(n, 9))[:, 2:5], random.uniform(size=(1, 4))
    table = np.array([[x.ctypes.data, x.shape[1], x.strides[0] // 8] for x in (a, b, c)])
    table[2, 2] = 0
    target = vectors(12, lanes)
    call("gather_parts", table, 0, n, 12, target)
    together = np.hstack([a, b, np.repeat(c, n, axis=0)])
    assert np.array_equal(target[:12].T, together[:lanes])


@pytest.mark.skipif(
    sys.platform != "linux", reason="asks the kernel of Linux for a page that must not be read"
)
def test_nothing_is_read_beyond_an_array(moved):
    lanes, call = moved
    size = mmap.PAGESIZE
    pages = mmap.mmap(-1, 2 * size)
    start = ctypes.addressof(ctypes.c_char.from_buffer(pages))
    library = ctypes.CDLL(None, use_errno=True)
    assert library.mprotect(ctypes.c_void_p(start + size), size, 0) == 0
    try:
        for width, n, row in cases(lanes):
            source = np.frombuffer(pages, float, n * width, size - 8 * n * width).reshape(n, width)
            target = vectors(width, lanes)
            call("gather", source, row, n, width, width, target)
            assert np.array_equal(target[:width, 0], source[row])
    finally:
        assert library.mprotect(ctypes.c_void_p(start + size), size, mmap.PROT_READ | mmap.PROT_WRITE) == 0


@pytest.mark.parametrize("n", [1, 8, 21, 700])
@pytest.mark.parametrize("threads", [1, 2])
def test_a_state_in_several_arrays(n, threads):
    tape = Tape()
    x = [tape.input(f"x{k}") for k in range(9)]
    outputs = [tape.sin(a) * b + 2 for a, b in zip(x, x[1:], strict=False)]
    kernel = compile_tape(tape, {"f": outputs}, None, x, (), batch=["f"])["f"]
    whole = np.random.default_rng(n).uniform(-2, 2, (n, 9))
    expected = kernel.batch(0.0, whole, ())
    assert np.array_equal(expected[-1], kernel(0.0, whole[-1], ()))
    columns = np.asfortranarray(whole)
    for parts in (
        [whole[:, :4].copy(), whole[:, 4:].copy()],
        [whole[:, :4], whole[:, 4:]],
        [columns[:, :4], whole[:, 4:5], columns[:, 5:]],
        [whole[::-1].copy()[::-1]],
    ):
        assert np.array_equal(kernel.batch_of_parts(0.0, parts, (), threads=threads), expected)
    whole[:, 4:] = whole[0, 4:]
    shared = np.broadcast_to(whole[0, 4:], (n, 5))
    expected = kernel.batch(0.0, whole, ())
    assert np.array_equal(kernel.batch_of_parts(0.0, [whole[:, :4], shared], (), threads=threads), expected)


def test_arrays_of_every_layout_give_the_same_accelerations():
    s = fb.System("two")
    s.gravity = (0, -9.81, 0)
    a, b = (s.body(name, fb.particle(2.0)) for name in "ab")
    s.hinge("p", s.ground, a, to=(0, 1, 0), axis="z")
    s.hinge("r", a, b, to=(0, 1, 0), axis="z")
    program = fb.compile(s)
    Y = np.random.default_rng(3).uniform(-1, 1, (37, 4))
    expected = np.array([program.forward_dynamics(y[:2].copy(), y[2:].copy()) for y in Y])
    layouts = (
        (Y[:, :2].copy(), Y[:, 2:].copy()),
        (Y[:, :2], Y[:, 2:]),
        (np.asfortranarray(Y[:, :2]), Y[:, 2:].tolist()),
    )
    for _ in range(2):
        for q, u in layouts:
            assert np.array_equal(program.forward_dynamics(q, u), expected)
    assert np.array_equal(program.forward_dynamics(Y[:, :2], Y[0, 2:])[0], expected[0])
    assert np.array_equal(program.forward_dynamics(Y[0, :2].copy(), Y[:, 2:].copy())[0], expected[0])
    assert program.forward_dynamics(np.zeros((0, 2)), np.zeros((0, 2))).shape == (0, 2)
