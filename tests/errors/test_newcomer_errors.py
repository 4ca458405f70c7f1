"""What somebody new to the library is likely to try, and what it answers."""

import math
import tempfile

import numpy as np
import pytest

import freebody as fb
from freebody.errors import FreebodyError


@pytest.fixture(scope="module")
def measured():
    t = np.linspace(0, 2, 41)
    return {"time": t, "theta": 0.8 * np.cos(2.7 * t)}


SIMULATE = [
    (dict(until="10 s"), "without a unit for until, got '10 s'. Write 10 (in m, kg, s and rad)"),
    (dict(until="2 min"), "without a unit for until, got '2 min'. Write 120"),
    (dict(until=1, initial={"theta": "30 m"}), "for the initial value of 'theta', got '30 m'. Write 30"),
    (dict(until="10 x"), "Expected an operator, got 'x'; write a product as 10*x."),
    (dict(until="1/0"), "In until: Expected a divisor that is not zero, got 0."),
    (dict(until=1, values={"m": "1/0"}), "Expected a divisor that is not zero, got 0."),
    (
        dict(until=1, values={"m": math.nan}),
        "In the value of parameter 'm': Expected a finite number, got nan.",
    ),
    (
        dict(until=1, tolerance=np.array([1e-9, 1e-8])),
        "Expected one number for tolerance=, or numbers by name",
    ),
    (dict(until=1, events=None), "Expected a list of fb.event(...) or expressions for events=, got None."),
    (
        dict(until=1, events={"a": "theta"}),
        "Expected a list of fb.event(...) or expressions for events=, got {'a'",
    ),
    (dict(until=1, progress="yes"), "a function of the part that is done for progress=, got 'yes'."),
    (
        dict(until=1, outputs=["theta"], store=tempfile.gettempdir()),
        "Expected the path of a file for store=, got the folder '",
    ),
    (
        dict(until=1, store="/dev/zero"),
        "Expected the path of a file for store=, got '/dev/zero', which is no file.",
    ),
]


@pytest.mark.parametrize(("arguments", "text"), SIMULATE, ids=lambda x: x if isinstance(x, str) else "")
def test_simulate(bar, arguments, text):
    with pytest.raises(FreebodyError) as caught:
        fb.simulate(bar, **arguments)
    assert text in str(caught.value)


def test_an_event_is_terminal_or_not():
    with pytest.raises(
        FreebodyError, match="Expected True or False for terminal= of event 'theta', got 'no'"
    ):
        fb.event("theta", terminal="no")


FIT = [
    (dict(start="a"), "Expected a known name, got 'a'"),
    (dict(start=None), "In start: expected a number, a SymPy expression or text, got None."),
    (dict(times=[1]), "Expected no times= for a fit, got [1]: the measured times and unknown= set it."),
    (dict(sensitivities=["m"]), "Expected no sensitivities= for a fit, got ['m']"),
]


@pytest.mark.parametrize(("options", "text"), FIT, ids=lambda x: x if isinstance(x, str) else "")
def test_fit_options(bar, measured, options, text):
    with pytest.raises(FreebodyError) as caught:
        fb.fit(bar, measured, {"L": 1.0}, initial={"theta": 0.8}, **options)
    assert text in str(caught.value)


DATA = [
    ({}, "Expected 'time' among the measured data, got nothing. Name the array of times 'time'."),
    (
        {"time": [0, 1, math.nan], "theta": [0, 1, 2]},
        "Expected finite times, got nan for measurement 2. Leave it out.",
    ),
    ({"time": 1, "theta": 1}, "Expected times of shape (N,), got shape ()."),
    (
        {"time": [0, 1], "theta": ["a", "b"]},
        "Expected arrays of numbers for the measured 'theta', got ['a', 'b'].",
    ),
]


@pytest.mark.parametrize(("data", "text"), DATA, ids=lambda x: x if isinstance(x, str) else "")
def test_fit_data(bar, data, text):
    with pytest.raises(FreebodyError) as caught:
        fb.fit(bar, data, {"L": 1.0})
    assert text in str(caught.value)


def test_compiled_dynamics(bar):
    program = fb.compile(bar)
    with pytest.raises(
        FreebodyError, match="Expected names of products one after another, such as 'mass_matrix'"
    ):
        program.to_c(["mass_matrix"])
    with pytest.raises(FreebodyError, match="Expected real numbers for q, got array"):
        program.mass_matrix(np.array([1j]))
