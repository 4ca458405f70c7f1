"""Random programs of the compiled language give what CPython gives, and each of eight lanes what one run gives."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from random_programs import ARGUMENTS, OF_NUMPY, OF_PYTHON, SIZE, Writer, arrays, bits, compiled, in_python

CHUNK = 50
"""Programs that are compiled together."""


def as_python_runs(run, arguments, p, k):
    """(bits of the results with numbers of NumPy, whether no operation was exceptional)."""
    exceptions = []
    p, k = p.copy(), k.copy()
    a, b, x, y = arguments
    with np.errstate(all="call", under="ignore", call=lambda *what: exceptions.append(what)):
        result = run(np.int64(a), np.int64(b), np.float64(x), np.float64(y), p, k)
    return [*bits(result), *bits(p), *k.tolist()], not exceptions


def agreed(seeds, folder):
    """Number of runs whose results are those of Python's own numbers too; all must be those of NumPy's."""
    names = [f"f{seed}" for seed in seeds]
    texts = [Writer(seed).text() for seed in seeds]
    library, addresses = compiled(texts, names, folder, f"programs_{seeds[0]}")
    kind = ctypes.CFUNCTYPE(
        ctypes.c_double, *[ctypes.c_int64] * 2, *[ctypes.c_double] * 2, *[ctypes.c_void_p] * 2
    )
    count = 0
    for name, text in zip(names, texts, strict=True):
        call = kind(addresses[name])
        of_numpy, of_python = (in_python(text, *x)[name] for x in ((OF_NUMPY, True), (OF_PYTHON, False)))
        random = np.random.default_rng(int(name[1:]))
        for arguments in ARGUMENTS:
            start = arrays(random)
            expected, plain = as_python_runs(of_numpy, arguments, *start)
            p, k = (x.copy() for x in start)
            result = call(*arguments, p.ctypes.data, k.ctypes.data)
            assert [*bits(result), *bits(p), *k.tolist()] == expected, (arguments, text)
            if plain and "<<" not in text and abs(arguments[0]) < 2**60 and all(map(np.isfinite, arguments)):
                p, k = (x.tolist() for x in start)
                result = of_python(*arguments, p, k)
                assert [*bits(result), *bits(p), *k] == expected, (arguments, text)
                count += 1
    assert library is not None
    return count


def test_programs_give_what_python_gives(tmp_path):
    assert agreed(range(CHUNK), tmp_path) > 0


@pytest.mark.slow
def test_ten_thousand_programs_give_what_python_gives(tmp_path):
    for start in range(CHUNK, 10000, CHUNK):
        agreed(range(start, start + CHUNK), tmp_path)


def lanes_agree(seeds, folder):
    """Programs for eight lanes give in each lane, to the last bit, what the same text gives for one run."""
    names = [f"f{seed}" for seed in seeds]
    texts = [Writer(seed, wide=True).text() for seed in seeds]
    one, alone = compiled(texts, names, folder, f"one_{seeds[0]}")
    eight, together = compiled(texts, names, folder, f"eight_{seeds[0]}", 8)
    kind = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64)
    random = np.random.default_rng(seeds[0])
    values = [0.0, -0.0, 0.1, -2.5, 1e200, float("nan"), float("inf"), -7.0, 3.0]
    for name, text in zip(names, texts, strict=True):
        run = in_python(text, OF_NUMPY, True)[name]
        for j in range(3):
            rows = random.uniform(-3, 3, (SIZE, 8))
            rows[:3] = random.choice(values, (3, 8)) if j else rows[:3]
            expected = []
            for lane in range(8):
                p = rows[:, lane].copy()
                with np.errstate(all="ignore"):
                    run(p, np.int64(j))
                expected.append(bits(p))
                p = rows[:, lane].copy()
                kind(alone[name])(p.ctypes.data, j)
                assert bits(p) == expected[-1], text
            memory = rows.copy()
            kind(together[name])(memory.ctypes.data, j)
            assert [bits(column) for column in memory.T.copy()] == expected, text
    assert one is not None and eight is not None


def test_a_lane_is_the_run_that_it_would_be_alone(tmp_path):
    lanes_agree(range(CHUNK), tmp_path)


@pytest.mark.slow
def test_lanes_of_thousands_of_programs(tmp_path):
    for start in range(CHUNK, 3000, CHUNK):
        lanes_agree(range(start, start + CHUNK), tmp_path)
