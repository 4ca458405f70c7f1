"""Loops over components: what eight at a time give is what one after the other gives; all else is refused."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from freebody.native import codegen
from freebody.native.records import padded
from freebody.native.translation import translated
from random_loops import Some, Writer, functions, in_python
from random_programs import bits

LANES = 8


def code(made, lanes):
    library = codegen.Library(codegen.optimised_code(translated(made, lanes))[0])
    return library, library.addresses(made)


def called(address, memory):
    ctypes.CFUNCTYPE(None, ctypes.c_void_p)(address)(memory.address)


@pytest.mark.parametrize("start", [0, pytest.param(1000, marks=pytest.mark.slow)])
def test_random_loops_give_what_cpython_gives_one_run_and_eight(start, tmp_path):
    seeds = range(start, start + (60 if start == 0 else 1500))
    texts = {f"f{seed}": Writer(seed).text(f"f{seed}") for seed in seeds}
    made = functions("\n".join(texts.values()), tmp_path)
    (one, alone), (eight, together) = code(made, 1), code(made, LANES)
    rng = np.random.default_rng(start)
    special = [0.0, 1e200, float("nan"), float("inf"), -3.0]
    for name, text in texts.items():
        n = int(rng.integers(0, 20))
        wide = Some.of(LANES).made(n=n, width=max(n, 1))
        rows = {x: rng.uniform(-3, 3, (max(n, 1), LANES)) for x in ("y", "out")}
        rows["k"] = rng.uniform(-3, 3, (3, max(n, 1), LANES))
        if n > 2 and rng.random() < 0.4:
            rows["y"][2] = rng.choice(special, LANES)
        numbers = {x: rng.uniform(-1, 1, LANES) for x in ("h", "top", "greatest")} | {
            "total": np.zeros(LANES)
        }
        for x, value in rows.items():
            getattr(wide, x)[:] = value
        for x, value in numbers.items():
            setattr(wide, x, value)
        called(together[name], wide)
        for lane in range(LANES):
            run = Some.made(n=n, width=padded(n))
            values = {"n": n} | {x: v[..., lane] for x, v in {**rows, **numbers}.items()}
            for x in rows:
                getattr(run, x)[..., : max(n, 1)] = values[x]
            for x in numbers:
                setattr(run, x, values[x])
            called(alone[name], run)
            expected = in_python(text, name, values)
            for x in ("y", "out", "k"):
                there, mine, beside = (np.asarray(getattr(r, x)) for r in (expected, run, wide))
                assert bits(mine[..., :n].ravel()) == bits(there[..., :n].ravel()), text
                assert bits(beside[..., lane][..., :n].ravel()) == bits(there[..., :n].ravel()), text
            for x in ("top", "total", "greatest"):  # the sign of a zero is not defined
                there = bits(getattr(expected, x) + 0.0)
                assert bits(getattr(run, x) + 0.0) == bits(getattr(wide, x)[lane] + 0.0) == there, text
    assert one is not None and eight is not None


def test_functions_of_numbers_are_those_of_eight(tmp_path):
    """A polynomial by Horner's rule, in a function that is inlined, one that is called, and one that is passed by."""
    made = functions(
        """
        @inlined
        def squared(x: Real) -> Real:
            return x * x

        @compiled
        def cubed(x: Real) -> Real:
            return x * squared(x)

        def f(s: Some) -> None:
            for i in components(s.n):
                p = s.k[2, i]
                for j in unrolled(1, -1, -1):
                    p = muladd(p, s.h, s.k[j, i])
                s.out[i] = squared(p) + cubed(s.y[i])
        """,
        tmp_path,
    )
    library, addresses = code(made, 1)
    run = Some.made(n=11, width=16)
    run.h = 0.5
    rng = np.random.default_rng(1)
    run.k[:], run.y[:] = rng.normal(size=(3, 16)), rng.normal(size=16)
    called(addresses["f"], run)
    expected = (run.k[0] + 0.5 * run.k[1] + 0.25 * run.k[2]) ** 2 + run.y**3
    assert np.allclose(run.out[:11], expected[:11], rtol=1e-14) and library is not None


BODY = "    top: Real = 0.0\n    n = 0\n    for i in components(s.n):\n"
REFUSED = [
    ("        x = s.y[i] * i\n", "the component as a place in rows", "'i'"),
    ("        x = s.y[i + 1]\n", "a component of a row at the place of the loop", "Write row[i]."),
    ("        x = s.y[0]\n", "a component of a row at the place of the loop", "'s.y[0]'"),
    ("        x = s.y[i]\n        z = x[0]\n", "a component of a row at the place of the loop", "'x[0]'"),
    ("        s.h = s.y[i]\n", "a component or a name of the body", "Assign to the field behind the loop."),
    ("        top = s.y[i]\n", "a reduction to 'top'", "Write top = maximum(top, y) or top += y"),
    ("        top = greater(top, s.y[i])\n", "a reduction to 'top'", "maximum(top, y)"),
    ("        top = maximum(top, s.y[i])\n        s.out[i] = top\n", "a reduction to 'top'", "use it behind the loop"),
    ("        top = maximum(top, s.y[i])\n        top += s.y[i]\n", "one reduction to 'top'", "a second name"),
    ("        if s.h > 0.0:\n            s.y[i] = 0.0\n", "assignments in a loop over components", "Other statements"),
    ("        x = 1.0 if any(s.y[i] > 0.0) else 0.0\n", "a number for each component", "Collect one with maximum"),
    ("        x = s.y[i] if s.y[i] > 0.0 else 0.0\n", "a truth value", "a truth value for each of 8 lanes"),
    ("        s.given[i] = 0.0\n", "a row with a length", "It is a row of a record"),
    ("        x = read(s)\n", "arguments that are numbers, in a loop over components", "of another component"),
    ("        x = s.y[i]\n    s.h = x\n", "a name that has a value", "Assign 'x' before"),
    ("        n = n + 1\n", "a reduction to 'n'", "Write n = maximum(n, y)"),
    ("        n += 1\n", "a real number 'n'", "Write n: Real = 0.0"),
    ("        for top in components(s.n):\n            s.y[i] = 0.0\n", "assignments in a loop", "Other statements"),
]  # fmt: skip


@pytest.mark.parametrize("number", range(len(REFUSED)))
def test_what_is_no_loop_over_components_is_refused(number, tmp_path):
    body, *parts = REFUSED[number]
    text = (
        "@compiled\ndef read(s: Some) -> Real:\n    return s.h\n\n" + f"def f(s: Some) -> None:\n{BODY}{body}"
    )
    with pytest.raises(TypeError) as refusal:
        translated(functions(text, tmp_path), 1)
    for part in (*parts, "in 'f', which is to be machine code", "loops.py, line "):
        assert part in str(refusal.value), refusal.value


@pytest.mark.parametrize(
    ("loop", "part"),
    [
        ("for i in components(s.n, 2):\n        s.y[i] = 0.0", "one number of components"),
        ("for i in components(0.5):\n        s.y[i] = 0.0", "an integer"),
        ("for s in components(s.n):\n        top = 0.0", "a name of its own for the component"),
        ("x = components(s.n)", "a loop over unrolled"),
    ],
)
def test_its_head_is_checked(loop, part, tmp_path):
    with pytest.raises(TypeError, match=f"Expected .*{part}"):
        translated(functions(f"def f(s: Some) -> None:\n    {loop}\n", tmp_path), 1)
