"""What a wrong expression is told: the place, what was expected there, the cure."""

from __future__ import annotations

import pytest
import sympy

from freebody.errors import ExpressionError
from freebody.scalar.parser import parse

NAMES = {name: sympy.Symbol(name) for name in ("k", "theta", "theta'", "length")}

CASES = [
    # text, message, place of the caret
    ("", "Expected an expression, got an empty text.", None),
    ("   ", "Expected an expression, got an empty text.", None),
    ("k*thetta", "Expected a known name, got 'thetta'; did you mean 'theta'?", 2),
    ("k'", """Expected a speed or an acceleration, got "k'"; 'k' has no such rate.""", 0),
    ("lenght'", """Expected a known name, got "lenght'"; did you mean 'length'?""", 0),
    ("(k + 1", "Expected a ')' for this '(', got the end of the text.", 0),
    ("k)", "Expected an operator or the end, got ')' without a '(' before it.", 1),
    ("2k", "Expected an operator, got 'k'; write a product as 2*k.", 1),
    ("k theta", "Expected an operator, got 'theta'; write a product as k*theta.", 2),
    ("(k)(2)", "Expected an operator, got '('; write a product as ...)*(....", 3),
    ("k(2)", "got '('; 'k' is a name and not a function, write a product as k*(...).", 1),
    ("sin theta", "Expected '(' after the function sin.", 4),
    ("sine(k)", "Expected a known function, got 'sine'; did you mean 'sin'?", 0),
    ("sin(k, 2)", "Expected 1 argument of sin, got 2.", 0),
    ("atan2(k)", "Expected 2 arguments of atan2, got 1.", 0),
    ("max(" + "k," * 40 + "k)", "Expected 2 to 32 arguments of max, got 41.", 0),
    ("sin()", "Expected a number, a name or '(', got ')'.", 4),
    ("k*", "Expected a number, a name or '(', got the end of the text.", 2),
    ("k +* 2", "Expected a number, a name or '(', got '*'.", 3),
    ("k, 2", "Expected an operator or the end, got ','.", 1),
    ("(k, 2)", "Expected an operator or ')', got ','.", 2),
    ("k = 3", "got '='; an expression has no '=' or comparison, give one side.", 2),
    ("k[0]", "got '['; use round parentheses.", 1),
    ("75 °", "Expected an operator, got '°'; write a product as 75*°.", 3),
    ("k·2", "got '·'; write * for a product.", 1),
    ("'k'", """got "'"; primes stand directly behind a coordinate's name.""", 0),
    ("k.real", "Expected a number, a name or an operator, got '.'.", 1),
    ("1/0", "Expected a divisor that is not zero, got 0.", 2),
    ("k/(theta - theta)", "Expected a divisor that is not zero, got 0.", 2),
    ("0**-1", "Expected a base that is not zero for the exponent -1, got 0.", 0),
    ("0**pi", "Expected a base that is not zero, got 0.", 0),
    ("sqrt(-1)", "Expected a finite real value of this sqrt, got I.", 0),
    ("1 + log(0)", "Expected a finite real value of this log, got zoo.", 4),
    ("asin(2)", "Expected a finite real value of this asin, got asin(2).", 0),
    ("(-8)**(1/3)", "Expected a finite real value of this power, got 2*(-1)**(1/3).", 0),
    ("9**9**9", "Expected a power of at most 4096 bits, got a larger one.", 3),
    ("k**101", "Expected an exponent of at most 100, got 101.", 3),
    ("1e401", "Expected a number of at most 400 digits, got a longer one.", 0),
    ("(" * 60 + "k" + ")" * 60, "Expected at most 50 levels inside one another, got more.", 50),
]


@pytest.mark.parametrize(("text", "message", "caret"), CASES, ids=[case[0][:20] or "empty" for case in CASES])
def test_message(text: str, message: str, caret: int | None) -> None:
    with pytest.raises(ExpressionError) as caught:
        parse(text, NAMES)
    first, *below = str(caught.value).splitlines()
    assert first.endswith(message)
    if caret is None:
        assert not below
    else:
        shown, pointer = below
        assert pointer.strip() == "^"
        under = pointer.index("^")
        assert shown[under : under + 1] == text[caret : caret + 1]
        if len(text) <= 72:
            assert (shown, under) == (f"    {text}", 4 + caret)


def test_a_long_text_is_shown_around_the_place() -> None:
    text = "k + " * 100 + "wrong" + " + k" * 100
    with pytest.raises(ExpressionError) as caught:
        parse(text, NAMES)
    _, shown, pointer = str(caught.value).splitlines()
    assert len(shown) < 90
    assert shown.strip().startswith("...") and shown.endswith("...")
    assert shown[pointer.index("^") :].startswith("wrong")


def test_lines_of_a_text_are_shown_as_one() -> None:
    with pytest.raises(ExpressionError) as caught:
        parse("k +\n\twrong", NAMES)
    _, shown, pointer = str(caught.value).splitlines()
    assert shown[pointer.index("^") :] == "wrong"


def test_only_text_is_parsed() -> None:
    with pytest.raises(ExpressionError, match=r"Expected text, got 3\."):
        parse(3, NAMES)  # type: ignore[arg-type]


def test_too_long() -> None:
    with pytest.raises(ExpressionError, match="at most 20000 characters, got 20002; give the parts names"):
        parse("k+" * 10_001, NAMES)
