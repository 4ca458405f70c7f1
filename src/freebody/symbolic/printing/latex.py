r"""LaTeX: ``m a \left(\ddot{\theta} \cos\theta - \dot{\theta}^{2} \sin\theta\right)``."""

from __future__ import annotations

from functools import cache

from .names import GREEK, parts
from .printer import Printer

_FUNCTIONS = {
    "asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan", "atan2": r"\operatorname{atan2}",
    "sign": r"\operatorname{sgn}",
}  # fmt: skip
_DOTS = {0: "{}", 1: r"\dot{{{}}}", 2: r"\ddot{{{}}}", 3: r"\dddot{{{}}}"}


@cache
def latex_name(name: str, dots: int = 0) -> str:
    r"""A name in LaTeX.

    >>> print(latex_name("theta1", 2), latex_name("I_xx"), latex_name("mass"), latex_name("pin_x"))
    \ddot{\theta}_{1} I_{xx} \mathrm{mass} \mathrm{pin}_{x}
    """
    base, below = parts(name)
    if base in GREEK:
        base = "\\" + base
    elif len(base) > 1:
        base = rf"\mathrm{{{base}}}"
    base = _DOTS[dots].format(base)
    if not below:
        return base
    below = ", ".join("\\" + b if b in GREEK else b for b in below.split(", "))
    return f"{base}_{{{below}}}"


def _joined(factors: list[str]) -> str:
    r"""Factors side by side; a thin space sets a word apart: ``m \, \mathrm{length}``."""
    return "".join(
        one + (r" \, " if r"\mathrm" in one or r"\mathrm" in other[:14] else " ")
        for one, other in zip(factors, factors[1:], strict=False)
    ) + (factors[-1] if factors else "")


class Latex(Printer):
    """Printer of LaTeX."""

    def number(self, n: int) -> str:
        return str(n)

    def name(self, name: str, dots: int = 0) -> str:
        return latex_name(name, dots)

    def power(self, base: str, e: int) -> str:
        return base if e == 1 else f"{base}^{{{e}}}"

    def bracketed(self, s: str) -> str:
        return rf"\left({s}\right)"

    def product(self, p: int, over: list[str], q: int, under: list[str]) -> str:
        if under:
            top = _joined([str(p), *over] if p != 1 or not over else over)
            return rf"\frac{{{top}}}{{{_joined([str(q), *under] if q != 1 else under)}}}"
        if q != 1:
            return _joined([rf"\frac{{{p}}}{{{q}}}", *over])
        return _joined([str(p), *over] if p != 1 or not over else over)

    def added(self, terms: list[tuple[bool, str]]) -> str:
        text = "".join((" - " if negative else " + ") + term for negative, term in terms)
        return "-" + text[3:] if terms[0][0] else text[3:]

    def function(self, name: str, arguments: list[str], e: int) -> str:
        if name == "abs":
            return self.power(rf"\left|{arguments[0]}\right|", e)
        if name == "exp":
            return f"e^{{{arguments[0]}}}"
        if name == "pow":
            base, exponent = arguments
            power = rf"{self.bracketed(base) if any(c in base for c in ' ^+-') else base}^{{{exponent}}}"
            return power if e == 1 else self.power(self.bracketed(power), e)
        head = _FUNCTIONS.get(name, "\\" + name)
        if e != 1:
            head += f"^{{{e}}}"
        inside = ", ".join(arguments)
        if name in ("sin", "cos") and not any(c in inside for c in " +-"):
            return head + (inside if inside.startswith("\\") else " " + inside)
        return rf"{head}\left({inside}\right)"

    def root(self, argument: str) -> str:
        return rf"\sqrt{{{argument}}}"
