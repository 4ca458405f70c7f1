"""Arrays of a file must have their shapes and ranges."""

import numpy as np
import pytest

from freebody.motion.files.reader import Reader


def test_arrays_are_checked_and_laid_out_for_compiled_code():
    table = np.arange(6, dtype="f4").reshape(2, 3).T
    read = Reader({"states": table, "modes": np.array([0, 2, 1], dtype="u1")})
    states = read.reals("states", (3, None))
    assert states.dtype == np.float64 and states.flags.c_contiguous and (states == table).all()
    assert read.integers("modes", (3,), 3).tolist() == [0, 2, 1]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda read: read.reals("x", (2, None)), r"'x' has the shape \(3,\)"),
        (lambda read: read.reals("x", (4,)), r"'x' has the shape \(3,\)"),
        (lambda read: read.integers("x", (3,), 2), "'x' has numbers that mean nothing"),
        (lambda read: read.integers("less", (1,), 2), "'less' has numbers that mean nothing"),
    ],
)
def test_what_does_not_fit_is_refused(call, words):
    read = Reader({"x": np.array([0, 1, 2]), "less": np.array([-1])})
    with pytest.raises(ValueError, match=words):
        call(read)
