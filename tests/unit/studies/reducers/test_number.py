"""Numbers of a run: what they read, what they are, and which texts are refused."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from freebody.errors import SimulationError
from freebody.studies.reducers.number import CONTACT_MODES, DEPTH, LENGTH, Number, check_names, number_of

X = np.array([-2.0, 0.0, 0.5, 3.0])
COLUMNS = {
    "max(theta')": X,
    "final(x)": X[::-1],
    "I": np.array([1.0, 2.0, 3.0, 4.0]),
    "theta'_start": X + 1,
    "end": np.full(4, 10.0),
    'event_time["theta - pi/2"]': np.array([np.nan, 1.0, 2.0, 3.0]),
    'event_count["theta - pi/2"]': np.array([0, 1, 1, 2]),
    "final(floor.mode)": np.array([0.0, 1.0, 1.0, np.nan]),
}


def of(text: str) -> list[Any]:
    return number_of(text, "mean").of(COLUMNS, 4).tolist()


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("max(theta')", X),
        (" max( theta' )\n", X),
        ("max(theta') - 2*final(x)**2/I + 1.5e0", X - 2 * X[::-1] ** 2 / COLUMNS["I"] + 1.5),
        ("-abs(max(theta')) % 2 // 1", -np.abs(X) % 2 // 1),
        ("max(max(theta'), final(x), 1)", np.maximum(np.maximum(X, X[::-1]), 1)),
        ("+min(theta'_start, 2)", np.minimum(X + 1, 2)),
        ("hypot(I, 3) + atan2(I, 1) + asin(I/9)", np.hypot(COLUMNS["I"], 3) + np.arctan2(COLUMNS["I"], 1)
         + np.arcsin(COLUMNS["I"] / 9)),
        ("max(theta') > 0.25", X > 0.25),
        ("0 <= max(theta') < 3 != end", (X >= 0) & (X < 3)),
        ("not (max(theta') > 0 or final(x) > 0)", ~((X > 0) | (X[::-1] > 0))),
        ("(I > 1) + (I > 2)", np.array([0, 1, 2, 2])),
        ("sin(pi*I)", np.sin(np.pi * COLUMNS["I"])),
        ("event_count[\"theta - pi/2\"] == 1", np.array([0, 1, 1, 0])),
        ("event_count['theta - pi/2'] >= 1", np.array([0, 1, 1, 1])),
    ],
)  # fmt: skip
def test_values(text: str, value: Any) -> None:
    assert of(text) == np.asarray(value, dtype=float).tolist()


def test_no_finite_value() -> None:
    """Neither infinite nor undefined: nan, and a comparison with it is no condition that fails."""
    np.testing.assert_array_equal(of("1/max(theta')"), [-0.5, np.nan, 2, 1 / 3])
    np.testing.assert_array_equal(of("log(max(theta')) > -9"), [np.nan, np.nan, 1, 1])
    np.testing.assert_array_equal(of("-9 < log(max(theta'))"), [np.nan, np.nan, 1, 1])
    np.testing.assert_array_equal(of("exp(1e9*I) > 0"), [np.nan] * 4)
    np.testing.assert_array_equal(
        Number("a", ("a",), (), (("column", "a"),), False).of({"a": [np.inf, 1]}, 2), [np.nan, 1]
    )


def test_a_condition_of_an_event_that_did_not_happen() -> None:
    count, time = 'event_count["theta - pi/2"]', 'event_time["theta - pi/2"]'
    np.testing.assert_array_equal(of(f"{time} < 2.5"), [np.nan, 1, 1, 0])
    assert of(f"{count} > 0 and {time} < 2.5") == [0, 1, 1, 0]
    assert of(f"{time} < 2.5 and {count} > 0") == [0, 1, 1, 0]
    assert of(f"{count} == 0 or {time} < 2.5") == [1, 1, 1, 0]
    np.testing.assert_array_equal(of(f"not {time} < 2.5"), [np.nan, 0, 0, 1])


def test_contact_modes() -> None:
    np.testing.assert_array_equal(of("final(floor.mode) == 'stick'"), [0, 1, 1, np.nan])
    np.testing.assert_array_equal(of('"open" != final(floor.mode)'), [0, 1, 1, np.nan])
    assert CONTACT_MODES.index("stick") == 1


def test_names() -> None:
    number = number_of("max(a*(b + c')) - final(floor.gap) + I*x_start + event_last['hit']/end", "mean")
    assert number.wanted == ("max(a*(b + c'))", "final(floor.gap)")
    assert number.names == ("I", "x_start", 'event_last["hit"]', "end")
    assert not number.condition and number_of("I > 1 and not end < 2", "mean").condition
    assert pickle.loads(pickle.dumps(number)) == number


def test_bits_do_not_depend_on_the_block() -> None:
    """Functions of NumPy have loops for whole vectors and for what remains: they give the same bits."""
    rng = np.random.default_rng(0)
    x = rng.normal(size=1003)
    number = number_of(
        "sin(x) + exp(x)*cos(3*x) + abs(x)**1.7 + tanh(x) + log(abs(x)) + atan2(x, sinh(x))", "mean"
    )
    whole = number.of({"x": x}, len(x))
    for low in range(0, 1003, 17):
        high = min(1003, low + 1 + low % 17)
        assert number.of({"x": x[low:high]}, high - low).tolist() == whole[low:high].tolist()
    wide = np.zeros((1003, 3))
    wide[:, 1] = x  # a column of a table
    assert number.of({"x": wide[:, 1]}, 1003).tolist() == whole.tolist()


REFUSED = {
    "": "Expected a number of a run for mean, such as",
    "x" * (LENGTH + 1): f"Expected at most {LENGTH} characters for mean, got {LENGTH + 1}. Make a part",
    "2 + pi": r"Expected a number that differs from run to run for mean, got the constant '2 \+ pi'",
    "max(x) >": r"got 'max\(x\) >': it is not an expression of numbers. Write it as in Python",
    "a b": "it is not an expression",
    "max(x": "it is not an expression",
    "a\0": "it is not an expression",
    "(" * 500 + "a" + ")" * 500: "it is not an expression",
    "-" * 1900 + "a": f"it is not an expression|it has more than {DEPTH} operations within each other",
    "+".join("a" * (DEPTH + 2)): f"it has more than {DEPTH} operations within each other",
    "a ^ 2": "no operation of numbers. Write \\*\\* for a power",
    "a > 1 & b > 2": "Write and.",
    "(a > 1) | (b > 2)": "Write or.",
    "~(a > 1)": "Write not.",
    "a if b > 1 else c": "Write a condition times a number",
    "lambda: a": "Numbers, names",
    "[a][0]": "Numbers, names",
    "(a).b": "Numbers, names",
    "2a": "it is not an expression",
    "2_0 + a": "it is not an expression",
    "a + True": "True is no number",
    "a + 1j": "it is not an expression",
    "a + 1e999": "it has a number that is too large",
    "a + " + "9" * 400: "it has a number that is too large",
    "a and b > 1": "'and' stands beside a number. Write a comparison there",
    "a > 1 or b": "'or' stands beside a number",
    "not a": "'not' stands beside a number",
    "a is b": "it compares by a word",
    "a in b": "it compares by a word",
    "sine(a)": "unknown function 'sine'; did you mean 'sin'",
    "__import__('os')": "unknown function '__import__'",
    "a.b(c)": "unknown function 'a.b'",
    "(a)(b)": "unknown function",
    "sin(a, b)": r"sin\(\) takes 1 number\.",
    "atan2(a)": r"atan2\(\) takes 2 numbers\.",
    "sin(*a)": "it is not an expression|takes 1 number",
    "max() + a": r"max\(\) takes 2 numbers",
    "range(a, b)": r"write range\(\) of one quantity, such as range\(theta\)",
    "a == 'stick'": r"only a contact mode equals a text: final\(floor.mode\) == 'stick'",
    "final(c.mode) > 'stick'": "only a contact mode equals a text",
    "final(c.mode) == 'stuck'": "'stuck' is no contact mode; did you mean 'stick'",
    "final(c.mode) + 'stick'": "'stick' is no number. A text is compared with a contact mode",
}  # fmt: skip


@pytest.mark.parametrize("text", REFUSED, ids=lambda text: text[:20])
def test_refused(text: str) -> None:
    with pytest.raises(SimulationError, match=REFUSED[text]):
        number_of(text, "mean")


def test_a_value_is_no_text() -> None:
    with pytest.raises(SimulationError, match="Expected a number of a run for mean, such as .* got 3"):
        number_of(3, "mean")


def test_unknown_names() -> None:
    check_names(("I",), ("I", "end"), "mean('I')")
    with pytest.raises(
        SimulationError, match=r"Unknown name 'thet' in mean\('thet'\); did you mean 'theta'\? Of a quan"
    ):
        check_names(("thet",), ("theta", "I"), "mean('thet')")
