"""Answers of the gallery against independent closed forms: numbers, formulas, and how they follow the parameters.

A test file of some systems of the chapter holds, by name, a function of the parameters that gives the expected answers
by key, from :mod:`freebody.exact`, and calls what stands below. Written with ``exact.elementary``, the same function
gives the expected formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import sympy

from freebody.describe.description import names_of
from freebody.errors import FreebodyError
from freebody.gallery import Outcome, entries
from freebody.gallery.tools.case import TOLERANCE
from freebody.scalar.element import is_zero

Closed = Callable[[Mapping[str, Any]], Mapping[str, Any]]

# of simulated answers, relative: answers are worked out a hundred times as fine as the run, and errors grow on the way
MOTION = 1e-9
# of closed forms: a few digits of rounding
ALGEBRA = 1e-12

_outcomes: dict[tuple[str, tuple[tuple[str, float], ...]], Outcome] = {}


def outcome(name: str, **changed: float) -> Outcome:
    """The outcome of an entry, run once for the same values."""
    key = (name, tuple(sorted(changed.items())))
    if key not in _outcomes:
        _outcomes[key] = entries()[name].run(changed)
    return _outcomes[key]


def compare(found: Outcome, closed: Closed, loose: Mapping[str, float] | None = None) -> None:
    """Every number among the answers is that of the closed form; ``loose`` are keys with a tolerance of their own."""
    expected = closed(found.values)
    numbers = {key for key, answer in found.answers.items() if not isinstance(answer.value, str)}
    assert set(expected) == numbers
    for key in numbers:
        answer = found.answers[key]
        bound = (loose or {}).get(key, MOTION if answer.formula is None else ALGEBRA)
        size = float(np.max(np.abs(np.asarray(expected[key], dtype=float))))
        # what is zero has no digits of its own
        floor = bound * (1 if size < TOLERANCE else size)
        np.testing.assert_allclose(answer.value, expected[key], rtol=0, atol=floor, err_msg=key)


def check_numbers(
    name: str,
    closed: Closed,
    loose: Mapping[str, float] | None = None,
    factor: float = 0.9,
    idle: Sequence[str] = (),
    *,
    changing: str,
    **changed: float,
) -> None:
    """At the defaults, at ``changed``, and at random: the answers follow all the parameters of the closed form.

    What is drawn lies between ``factor`` and 1 over it, the same at every run. Where ``changing`` is "each
    parameter", also with each times ``factor`` in turn, and at a second random setting: each changes an answer,
    except for the parameters ``idle``, which drop out.
    """
    before = outcome(name)
    compare(before, closed, loose)
    if changed:
        compare(outcome(name, **changed), closed, loose)
    in_turn = changing == "each parameter"
    for parameter, value in before.values.items() if in_turn else ():
        after = outcome(name, **{parameter: value * factor if value else 0.1})
        compare(after, closed, loose)
        if parameter in idle:
            continue
        moved = [key for key in before.answers if before.answers[key].value != after.answers[key].value]
        assert moved, f"{name}: {parameter} changes nothing"
    draw = np.random.default_rng([*name.encode()]).uniform
    reach, compared = abs(np.log(factor)), 0
    for _ in range(10):
        drawn = {key: value * float(np.exp(draw(-reach, reach))) for key, value in before.values.items()}
        try:
            found = outcome(name, **drawn)
        except FreebodyError:  # no such machine, or one that does not do what is asked
            continue
        compare(found, closed, loose)
        compared += 1
        if compared == (2 if in_turn else 1):
            return
    raise AssertionError(f"{name}: {compared} of ten random settings are possible")


def check_formulas(name: str, closed: Closed, *keys: str) -> None:
    """The formulas of the answers (those of ``keys``, or all) are those of the closed form: the difference is zero."""
    found = outcome(name)
    e = found.equations
    atoms = {**names_of(found.system).atoms}
    expected = closed(atoms)
    asked = keys or [
        key for key, answer in found.answers.items() if answer.formula is not None and key in expected
    ]
    assert asked
    for key in asked:
        answer = found.answers[key]
        formula = answer.formula
        for short, meaning in answer.where.items():  # earlier abbreviations may contain later ones
            if short not in atoms:
                formula = formula.xreplace({x: meaning for x in formula.free_symbols if x.name == short})
        difference = sympy.sympify(formula - expected[key])
        left = e.ring.from_sympy(difference)
        # arccos(4/7) and arctan(√33/4) are one number, which no ring of these functions knows: 50 digits tell
        names = sorted(difference.free_symbols, key=str)
        places = [
            {x: sympy.Rational(3 * j + k, 11 + j) for j, x in enumerate(names)} for k in (1, 2, 4, 5, 7)
        ]
        same = is_zero(left) or (
            difference.has(sympy.asin, sympy.acos)
            and all(abs(sympy.N(difference.subs(at), 60)) < sympy.Rational(1, 10**50) for at in places)
        )
        assert same, f"{name}, {key}: {found.answers[key].text} differs by {left}"
