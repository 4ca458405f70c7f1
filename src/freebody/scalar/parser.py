"""Parser of expressions, which executes no code from the text.

The language has numbers, names, ``+ - * / ** ^``, signs, parentheses and a fixed list of functions:

    sum      = product { ("+" | "-") product }
    product  = signed { ("*" | "/") signed }
    signed   = { "+" | "-" } power
    power    = atom [ ("**" | "^") signed ]          right to left, binds tighter than a sign on its left
    atom     = number | number "deg" | number "rad" | name | function "(" sum { "," sum } ")" | "(" sum ")"

A name may end in primes: ``theta'`` is the speed of ``theta``. Text is never passed to ``eval`` or
``sympify``. Decimals are exact: ``0.1`` is 1/10 and ``75deg`` or ``75°`` is 5 pi/12.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple, NoReturn

import sympy

from ..errors import ExpressionError, nearest

MAX_LENGTH = 20_000  # characters
MAX_DEPTH = 50  # nested parentheses, calls and powers: each level takes five nested calls in Python
MAX_DIGITS = 400  # digits of one number, and decimal exponent
MAX_EXPONENT = 100  # exponent of a power with symbols
MAX_BITS = 4096  # bits of a power of plain numbers
MAX_CHOICES = 32  # arguments of min and max: SymPy compares each pair

_DEGREE = sympy.pi / 180


class _Function(NamedTuple):
    make: Callable[..., Any]
    least: int
    most: int


FUNCTIONS: dict[str, _Function] = {
    **{
        name: _Function(getattr(sympy, name), 1, 1)
        for name in ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh")
    },
    "sqrt": _Function(sympy.sqrt, 1, 1),
    "exp": _Function(sympy.exp, 1, 1),
    "log": _Function(sympy.log, 1, 1),
    "abs": _Function(sympy.Abs, 1, 1),
    "sign": _Function(sympy.sign, 1, 1),
    "atan2": _Function(sympy.atan2, 2, 2),
    "min": _Function(sympy.Min, 2, MAX_CHOICES),
    "max": _Function(sympy.Max, 2, MAX_CHOICES),
}
CONSTANTS = {"pi": sympy.pi}

_TOKEN = re.compile(
    r"(?P<space>\s+)"
    r"|(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[^\W\d]\w*'*|°)"
    r"|(?P<operator>\*\*|[-+*/^(),])"
)


class _Token(NamedTuple):
    kind: str  # number, name, operator or end
    text: str
    at: int


def parse(text: str, names: Mapping[str, Any]) -> Any:
    """Return the expression that a text stands for.

    Parameters
    ----------
    text : str
        For example ``"m*g*a*sin(theta) - c*theta'"`` or ``"75deg"``.
    names : mapping of str to SymPy expression
        Every name that may occur, primes included: ``{"m": m, "theta": q, "theta'": q.diff(t)}``.

    Returns
    -------
    SymPy expression
        Exact: no Float occurs in it.

    Raises
    ------
    ExpressionError
        The message says what was expected, shows the text with a caret under the place and the nearest known name.

    Examples
    --------
    >>> k, x = sympy.symbols("k x")
    >>> parse("-k*(x - 0.5)^2", {"k": k, "x": x})
    -k*(x - 1/2)**2
    >>> parse("75deg", {})
    5*pi/12
    >>> parse("k*y", {"k": k, "x": x})
    Traceback (most recent call last):
    ...
    freebody.errors.ExpressionError: Expected a known name, got 'y'; known names: k, x.
        k*y
          ^
    """
    if not isinstance(text, str):
        raise ExpressionError(f"Expected text, got {text!r}.")
    if len(text) > MAX_LENGTH:
        raise ExpressionError(
            f"Expected an expression of at most {MAX_LENGTH} characters, got {len(text)}; "
            "give the parts names as parameters."
        )
    return _Parser(text, names).whole()


class _Parser:
    """Reader of one text from left to right; the methods of the grammar return SymPy expressions."""

    def __init__(self, text: str, names: Mapping[str, Any]) -> None:
        self.text = text
        self.names = names
        self.depth = 0
        self.tokens = list(self._tokenize())
        self.index = 0

    # --- tokens ---

    def _tokenize(self) -> Iterable[_Token]:
        at, end = 0, len(self.text)
        while at < end:
            match = _TOKEN.match(self.text, at)
            if match is None:
                self.fail(
                    at, f"Expected a number, a name or an operator, got {self.text[at]!r}{self._cure(at)}"
                )
            kind = str(match.lastgroup)
            if kind != "space":
                yield _Token(kind, match.group(), at)
            at = match.end()
        yield _Token("end", "", len(self.text.rstrip()))

    def _cure(self, at: int) -> str:
        character = self.text[at]
        if character in "=<>!":
            return "; an expression has no '=' or comparison, give one side."
        if character in "[]{}":
            return "; use round parentheses."
        if character == "'":
            return "; primes stand directly behind a coordinate's name."
        if character in "·×":
            return "; write * for a product."
        return "."

    @property
    def token(self) -> _Token:
        """The current token."""
        return self.tokens[self.index]

    def accept(self, *operators: str) -> _Token | None:
        """Return the current token and go to the next if it is one of these operators, else return None."""
        token = self.token
        if token.kind == "operator" and token.text in operators:
            self.index += 1
            return token
        return None

    def fail(self, at: int, message: str) -> NoReturn:
        raise ExpressionError(f"{message}\n{_pointer(self.text, at)}")

    def unexpected(self, expected: str) -> NoReturn:
        token = self.token
        got = "the end of the text" if token.kind == "end" else repr(token.text)
        self.fail(token.at, f"Expected {expected}, got {got}.")

    # --- grammar ---

    def whole(self) -> Any:
        if self.token.kind == "end":
            raise ExpressionError("Expected an expression, got an empty text.")
        value = self.sum()
        if self.token.kind != "end":
            self.after_operand()
        return value

    def after_operand(self) -> NoReturn:
        """Refuse a token that stands in place of an operator or the end."""
        token, before = self.token, self.tokens[self.index - 1]
        if token.kind in ("number", "name") or token.text == "(":
            after = token.text + "..." * (token.text == "(")
            product = f"{'...' * (before.text == ')')}{before.text}*{after}"
            self.fail(token.at, f"Expected an operator, got {token.text!r}; write a product as {product}.")
        if token.text == ")":
            self.fail(token.at, "Expected an operator or the end, got ')' without a '(' before it.")
        self.unexpected("an operator or the end")

    def sum(self) -> Any:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            self.fail(self.token.at, f"Expected at most {MAX_DEPTH} levels inside one another, got more.")
        # all terms are added at once: pairwise addition is quadratic in the number of terms
        at = self.token.at
        terms = [self.product()]
        while operator := self.accept("+", "-"):
            term = self.product()
            terms.append(term if operator.text == "+" else -term)
        self.depth -= 1
        return self.small(sympy.Add(*terms), at)

    def product(self) -> Any:
        at = self.token.at
        first = self.signed()
        # numbers are multiplied, and their size checked, one by one; the other factors all at once
        number, factors = (first, []) if first.is_Rational else (sympy.Integer(1), [first])
        while operator := self.accept("*", "/"):
            divisor = self.token.at
            factor = self.signed()
            if operator.text == "/":
                if factor.is_zero:
                    self.fail(divisor, "Expected a divisor that is not zero, got 0.")
                factor = 1 / factor
            if factor.is_Rational:
                number = self.small(number * factor, at)
            else:
                factors.append(factor)
        return sympy.Mul(number, *factors)

    def signed(self) -> Any:
        negative = False
        while operator := self.accept("+", "-"):
            negative ^= operator.text == "-"
        value = self.power()
        return -value if negative else value

    def power(self) -> Any:
        start = self.token.at
        base = self.atom()
        if not self.accept("**", "^"):
            return base
        self.depth += 1
        if self.depth > MAX_DEPTH:
            self.fail(self.token.at, f"Expected at most {MAX_DEPTH} levels inside one another, got more.")
        at = self.token.at
        exponent = self.signed()
        self.depth -= 1
        self.check_power(base, exponent, start, at)
        return self.real(base**exponent, start, "power")

    def real(self, value: Any, at: int, what: str) -> Any:
        """Return the value of a function or power; refuse one that is not finite and real, or too large."""
        no_number = value.has(sympy.zoo, sympy.nan, sympy.oo, -sympy.oo, sympy.I)
        if not no_number and value.is_number and not value.is_Rational:
            # checked at each level: a tower of powers has more digits than fit into memory
            if not abs(value.evalf(2)) < sympy.Integer(2) ** MAX_BITS:
                self.fail(
                    at, f"Expected a value of at most {MAX_BITS} bits of this {what}, got a larger one."
                )
            no_number = value.is_real is False
        if no_number:
            self.fail(at, f"Expected a finite real value of this {what}, got {value}.")
        return value

    def small(self, value: Any, at: int) -> Any:
        """Return the value; refuse a number with more digits than any machine needs."""
        if value.is_Rational and _bits(value) > MAX_BITS:
            self.fail(at, f"Expected a number of at most {MAX_BITS} bits, got a larger one.")
        return value

    def check_power(self, base: Any, exponent: Any, start: int, at: int) -> None:
        """Refuse a power that has no value or too many digits."""
        if not exponent.is_Rational:
            if base.is_Number and exponent.is_number and exponent.is_real:
                if base.is_zero:
                    self.fail(start, "Expected a base that is not zero, got 0.")
                if abs(float(exponent.evalf(15))) * _bits(base) > MAX_BITS:
                    self.fail(at, f"Expected a power of at most {MAX_BITS} bits, got a larger one.")
            return
        if base.is_zero and exponent <= 0:
            self.fail(start, f"Expected a base that is not zero for the exponent {exponent}, got 0.")
        if base.is_Rational:
            if abs(exponent) * _bits(base) > MAX_BITS or _bits(exponent) > MAX_BITS:
                self.fail(at, f"Expected a power of at most {MAX_BITS} bits, got a larger one.")
        elif abs(exponent) > MAX_EXPONENT or exponent.q > MAX_EXPONENT:
            self.fail(at, f"Expected an exponent of at most {MAX_EXPONENT}, got {str(exponent)[:20]}.")

    def atom(self) -> Any:
        token = self.token
        if token.kind == "number":
            return self.number()
        if token.kind == "name":
            return self.name()
        if self.accept("("):
            value = self.sum()
            self.close(token)
            return value
        self.unexpected("a number, a name or '('")

    def close(self, opened: _Token) -> None:
        if not self.accept(")"):
            if self.token.kind == "end":
                self.fail(opened.at, "Expected a ')' for this '(', got the end of the text.")
            if self.token.kind in ("number", "name") or self.token.text == "(":
                self.after_operand()
            self.unexpected("an operator or ')'")

    def number(self) -> Any:
        token = self.token
        mantissa, _, power = token.text.lower().partition("e")
        if len(mantissa) > MAX_DIGITS or len(power) > 5 or abs(int(power or 0)) > MAX_DIGITS:
            self.fail(token.at, f"Expected a number of at most {MAX_DIGITS} digits, got a longer one.")
        self.index += 1
        whole, _, decimals = mantissa.partition(".")
        value = sympy.Rational(int((whole + decimals) or 0)) * sympy.Integer(10) ** (
            int(power or 0) - len(decimals)
        )
        unit = self.token
        if unit.kind == "name" and unit.at == token.at + len(token.text) and unit.text in ("deg", "°", "rad"):
            self.index += 1
            return value if unit.text == "rad" else value * _DEGREE
        return value

    def name(self) -> Any:
        token = self.token
        self.index += 1
        opened = self.token
        called = opened.kind == "operator" and opened.text == "("
        if token.text in self.names:
            if called:
                self.fail(
                    opened.at,
                    f"Expected an operator, got '('; '{token.text}' is a name and not a function, "
                    f"write a product as {token.text}*(...).",
                )
            return self.names[token.text]
        if token.text in FUNCTIONS:
            if not called:
                self.fail(opened.at, f"Expected '(' after the function {token.text}.")
            self.index += 1
            return self.call(token, opened)
        if token.text in CONSTANTS:
            return CONSTANTS[token.text]
        if called:
            hint = nearest(token.text, FUNCTIONS)
            self.fail(token.at, f"Expected a known function, got '{token.text}'; {hint}")
        base = token.text.rstrip("'")
        if base != token.text and base in self.names:
            rates = [f'"{name}"' for name in self.names if name != base and name.rstrip("'") == base]
            has = f"has {' and '.join(rates)} here" if rates else "has no such rate"
            self.fail(token.at, f"Expected a speed or an acceleration, got {token.text!r}; {base!r} {has}.")
        self.fail(token.at, f"Expected a known name, got {token.text!r}; {nearest(token.text, self.names)}")

    def call(self, function: _Token, opened: _Token) -> Any:
        make, least, most = FUNCTIONS[function.text]
        arguments = [self.sum()]
        while self.accept(","):
            arguments.append(self.sum())
        self.close(opened)
        if not least <= len(arguments) <= most:
            count = f"{least}" if least == most else f"{least} to {most}"
            over_time = least == 2 < most and len(arguments) == 1
            more = (
                " The greatest or smallest of one quantity over a run is an output of it."
                if over_time
                else ""
            )
            self.fail(
                function.at,
                f"Expected {count} argument{'s' if most > 1 else ''} of {function.text}, "
                f"got {len(arguments)}.{more}",
            )
        try:
            value = make(*arguments)
        except (ValueError, TypeError) as error:
            self.fail(function.at, f"Expected real arguments of {function.text}: {error}.")
        return self.real(value, function.at, function.text)


def _bits(number: Any) -> int:
    """Bits of the longer of numerator and denominator."""
    return max(int(abs(number.p)).bit_length(), int(number.q).bit_length())


def _pointer(text: str, at: int, width: int = 72) -> str:
    """The text with a caret under one place; a long text is shortened to its neighbourhood."""
    flat = re.sub(r"\s", " ", text)
    start = max(0, at - width // 2) if len(flat) > width else 0
    shown = flat[start : start + width]
    before = "..." if start else ""
    after = "..." if start + width < len(flat) else ""
    return f"    {before}{shown}{after}\n    {' ' * (len(before) + at - start)}^"
