r"""LaTeX: ``m a \left(\ddot{\theta} \cos\theta - \dot{\theta}^{2} \sin\theta\right)``."""

from __future__ import annotations

import re
from functools import cache

from .names import GREEK, parts
from .printer import Printer, signed_sum

_FUNCTIONS = {
    "asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan", "atan2": r"\operatorname{atan2}",
    "sign": r"\operatorname{sgn}",
}  # fmt: skip
_WORD = re.compile(r"[A-Za-z]{3,}[0-9]*")
_DOTS = {0: "{}", 1: r"\dot{{{}}}", 2: r"\ddot{{{}}}", 3: r"\dddot{{{}}}"}


@cache
def latex_name(name: str, dots: int = 0) -> str:
    r"""Return a name in LaTeX.

    >>> print(latex_name("theta1", 2), latex_name("I_xx"), latex_name("mass"), latex_name("m_link2"))
    \ddot{\theta}_{1} I_{xx} \mathrm{mass} m_{\mathrm{link2}}
    """
    base, below = parts(name)
    if base in GREEK:
        base = "\\" + base
    elif len(base) > 1:
        base = rf"\mathrm{{{base}}}"
    base = _DOTS[dots].format(base)
    if not below:
        return base
    below = ", ".join(map(_below, below.split(", ")))
    return f"{base}_{{{below}}}"


def _below(part: str) -> str:
    """Return a subscript: words upright, with their number, indices such as xx not."""
    if part in GREEK:
        return "\\" + part
    return rf"\mathrm{{{part}}}" if _WORD.fullmatch(part) else part


def latex_number(x: complex, digits: int = 6) -> str:
    r"""Return a number to six digits, or to so many, in LaTeX, with powers of ten.

    >>> print(latex_number(1e-5), latex_number(-2.5e20), latex_number(0.25 - 1e-7j), sep="   ")
    10^{-5}   -2.5 \cdot 10^{20}   0.25 - 10^{-7} i
    """
    if isinstance(x, complex):
        if not x.imag:
            return latex_number(x.real, digits)
        sign, size = ("-" if x.imag < 0 else "+"), latex_number(abs(x.imag), digits)
        imaginary = f"{size} i" if size != "1" else "i"
        return f"{latex_number(x.real, digits)} {sign} {imaginary}" if x.real else sign.strip("+") + imaginary
    mantissa, _, exponent = f"{x:.{digits}g}".partition("e")
    if not exponent:
        return mantissa
    power = f"10^{{{int(exponent)}}}"
    return {"1": power, "-1": f"-{power}"}.get(mantissa, rf"{mantissa} \cdot {power}")


_LABEL = re.compile(r"([A-Za-z]+[0-9]*)('*)((?:_[A-Za-z0-9]+)*)('*)(?:\((.+)\))?")


def label_latex(label: str) -> str | None:
    r"""Return what a result is called as LaTeX; None if it is words.

    >>> print(label_latex("psi'_fast"), label_latex("x(t_1)"), label_latex("largest angle"))
    \dot{\psi}_{\mathrm{fast}} x\left(t_{1}\right) None
    """
    match = _LABEL.fullmatch(label)
    if match is None:
        return None
    base, before, below, after, arguments = match.groups()
    dots = len(before + after)
    if dots > max(_DOTS):
        return None
    name = latex_name(base + below, dots)
    if arguments is None:
        return name
    parts = [label_latex(x) or rf"\text{{{x}}}" for x in arguments.split(", ")]
    return rf"{name}\left({', '.join(parts)}\right)"


def _joined(factors: list[str]) -> str:
    r"""Return factors side by side, with a thin space next to a word: ``m \, \mathrm{length}``."""
    return "".join(
        factor + (r" \, " if r"\mathrm" in factor or r"\mathrm" in following[:14] else " ")
        for factor, following in zip(factors, factors[1:], strict=False)
    ) + (factors[-1] if factors else "")


class Latex(Printer):
    """Printer of LaTeX."""

    def number(self, n: int) -> str:
        """A whole number."""
        return str(n)

    def name(self, name: str, dots: int = 0) -> str:
        """A name, differentiated ``dots`` times."""
        return latex_name(name, dots)

    def power(self, base: str, e: int) -> str:
        """A factor to a positive whole power."""
        return base if e == 1 else f"{base}^{{{e}}}"

    def bracketed(self, s: str) -> str:
        """A sum as a factor."""
        return rf"\left({s}\right)"

    def product(self, p: int, over: list[str], q: int, under: list[str]) -> str:
        """p · over / (q · under)."""
        if under:
            return rf"\frac{{{_joined(self.numbered(p, over))}}}{{{_joined(self.numbered(q, under))}}}"
        if q != 1:
            return _joined([rf"\frac{{{p}}}{{{q}}}", *over])
        return _joined(self.numbered(p, over))

    def added(self, terms: list[tuple[bool, str]]) -> str:
        """Terms joined by their signs."""
        return signed_sum(terms)

    def function(self, name: str, arguments: list[str], e: int) -> str:
        """A function to a positive whole power."""
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
        """A square root."""
        return rf"\sqrt{{{argument}}}"
