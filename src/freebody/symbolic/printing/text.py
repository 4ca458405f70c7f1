"""Plain text: ``m*a*(theta''*cos(theta) - theta'^2*sin(theta))``."""

from __future__ import annotations

from .printer import Printer, signed_sum


class Text(Printer):
    """Printer of plain text; ``'`` is d/dt, ``^`` a power."""

    bars = False

    def number(self, n: int) -> str:
        """A whole number."""
        return str(n)

    def name(self, name: str, dots: int = 0) -> str:
        """A name, differentiated ``dots`` times."""
        return name + "'" * dots

    def power(self, base: str, e: int) -> str:
        """A factor to a positive whole power."""
        return base if e == 1 else f"{base}^{e}"

    def bracketed(self, s: str) -> str:
        """A sum as a factor."""
        return f"({s})"

    def product(self, p: int, over: list[str], q: int, under: list[str]) -> str:
        """p · over / (q · under)."""
        top = "*".join(self.numbered(p, over))
        if q == 1 and not under:
            return top
        below = self.numbered(q, under)
        return f"{top}/{below[0]}" if len(below) == 1 else f"{top}/({'*'.join(below)})"

    def added(self, terms: list[tuple[bool, str]]) -> str:
        """Terms joined by their signs."""
        return signed_sum(terms)

    def function(self, name: str, arguments: list[str], e: int) -> str:
        """A function to a positive whole power."""
        if name == "pow":
            base, exponent = (f"({a})" if _compound(a) else a for a in arguments)
            return f"{base}^{exponent}" if e == 1 else f"({base}^{exponent})^{e}"
        return self.power(f"{name}({', '.join(arguments)})", e)

    def root(self, argument: str) -> str:
        """A square root."""
        return f"sqrt({argument})"


def broken(text: str, indent: str, width: int) -> str:
    """Return a formula in lines of at most ``width`` characters, if it has sums outside brackets to begin them with.

    >>> print(broken("a*(b + c) + d - e > 0", "  ", 12))
      a*(b + c)
        + d - e
        > 0
    """
    lines, depth, words = [indent], 0, list[str]()
    for word in text.split(" "):
        if depth == 0 and word in ("+", "-", "<", ">", "<=", ">=", "="):
            words.append(word)
        elif words and (depth or words[-1] in ("+", "-", "<", ">", "<=", ">=", "=")):
            words[-1] += " " + word
        else:
            words.append(word)
        depth += word.count("(") - word.count(")")
    for word in words:
        new = lines[-1] if not lines[-1].strip() else lines[-1] + " "
        if len(new + word) > width and lines[-1].strip():
            lines.append(f"{indent}  {word}")
        else:
            lines[-1] = new + word
    return "\n".join(lines)


def _compound(text: str) -> bool:
    return any(c in text for c in " +-*/^")
