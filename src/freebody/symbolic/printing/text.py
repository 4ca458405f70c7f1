"""Plain text: ``m*a*(theta''*cos(theta) - theta'^2*sin(theta))``."""

from __future__ import annotations

from .printer import Printer


class Text(Printer):
    """Printer of plain text; ``'`` is d/dt, ``^`` a power."""

    bars = False

    def number(self, n: int) -> str:
        return str(n)

    def name(self, name: str, dots: int = 0) -> str:
        return name + "'" * dots

    def power(self, base: str, e: int) -> str:
        return base if e == 1 else f"{base}^{e}"

    def bracketed(self, s: str) -> str:
        return f"({s})"

    def product(self, p: int, over: list[str], q: int, under: list[str]) -> str:
        top = "*".join([str(p), *over] if p != 1 or not over else over)
        if q == 1 and not under:
            return top
        below = [str(q), *under] if q != 1 else under
        return f"{top}/{below[0]}" if len(below) == 1 else f"{top}/({'*'.join(below)})"

    def added(self, terms: list[tuple[bool, str]]) -> str:
        parts = []
        for negative, text in terms:
            parts.append((" - " if negative else " + ") + text)
        first = parts[0]
        parts[0] = "-" + first[3:] if terms[0][0] else first[3:]
        return "".join(parts)

    def function(self, name: str, arguments: list[str], e: int) -> str:
        if name == "pow":
            base, exponent = (f"({a})" if _compound(a) else a for a in arguments)
            return f"{base}^{exponent}" if e == 1 else f"({base}^{exponent})^{e}"
        return self.power(f"{name}({', '.join(arguments)})", e)

    def root(self, argument: str) -> str:
        return f"sqrt({argument})"


def _compound(text: str) -> bool:
    return any(c in text for c in " +-*/^")
