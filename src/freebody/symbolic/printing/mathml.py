"""Presentation MathML, as browsers draw it."""

from __future__ import annotations

from functools import cache
from html import escape

from .names import GREEK, parts
from .printer import Printer

_DOTS = {1: "˙", 2: "¨", 3: "⃛"}
_FUNCTIONS = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "sign": "sgn"}
_APPLY = "<mo>&#x2061;</mo>"
_TIMES = "<mo>&#x2062;</mo>"


@cache
def mathml_name(name: str, dots: int = 0) -> str:
    """Return a name in MathML.

    >>> mathml_name("theta1", 2)
    '<msub><mover><mi>θ</mi><mo>¨</mo></mover><mn>1</mn></msub>'
    """
    base, below = parts(name)
    result = f"<mi>{escape(GREEK.get(base, base))}</mi>"
    if dots:
        result = f"<mover>{result}<mo>{_DOTS[dots]}</mo></mover>"
    if not below:
        return result
    tag = "mn" if below.isdigit() else "mi"
    return f"<msub>{result}<{tag}>{escape(GREEK.get(below, below))}</{tag}></msub>"


class MathML(Printer):
    """Printer of presentation MathML."""

    def number(self, n: int) -> str:
        """A whole number."""
        return f"<mn>{n}</mn>"

    def name(self, name: str, dots: int = 0) -> str:
        """A name, differentiated ``dots`` times."""
        return mathml_name(name, dots)

    def power(self, base: str, e: int) -> str:
        """A factor to a positive whole power."""
        return base if e == 1 else f"<msup><mrow>{base}</mrow><mn>{e}</mn></msup>"

    def bracketed(self, s: str) -> str:
        """A sum as a factor."""
        return f"<mrow><mo>(</mo>{s}<mo>)</mo></mrow>"

    def product(self, p: int, over: list[str], q: int, under: list[str]) -> str:
        """p · over / (q · under)."""
        if under:
            top = _TIMES.join(self.numbered(p, over))
            below = _TIMES.join(self.numbered(q, under))
            return f"<mfrac><mrow>{top}</mrow><mrow>{below}</mrow></mfrac>"
        if q != 1:
            return _TIMES.join([f"<mfrac><mn>{p}</mn><mn>{q}</mn></mfrac>", *over])
        return _TIMES.join(self.numbered(p, over))

    def added(self, terms: list[tuple[bool, str]]) -> str:
        """Terms joined by their signs."""
        signed = [("<mo>−</mo>" if negative else "<mo>+</mo>") + term for negative, term in terms]
        if not terms[0][0]:
            signed[0] = terms[0][1]
        return "".join(signed)

    def function(self, name: str, arguments: list[str], e: int) -> str:
        """A function to a positive whole power."""
        if name == "abs":
            return self.power(f"<mrow><mo>|</mo>{arguments[0]}<mo>|</mo></mrow>", e)
        if name == "pow":
            base = self.bracketed(arguments[0])
            return self.power(f"<msup>{base}<mrow>{arguments[1]}</mrow></msup>", e)
        head = self.power(f"<mi>{_FUNCTIONS.get(name, name)}</mi>", e)
        return f"{head}{_APPLY}{self.bracketed('<mo>,</mo>'.join(arguments))}"

    def root(self, argument: str) -> str:
        """A square root."""
        return f"<msqrt>{argument}</msqrt>"


def document(inside: str) -> str:
    """Return a ``math`` element that is displayed as a block."""
    return f'<math xmlns="http://www.w3.org/1998/Math/MathML" display="block"><mrow>{inside}</mrow></math>'
