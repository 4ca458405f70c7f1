"""The prints of the chapter, read as it writes them: a tree, its value, its text and LaTeX.

    M_η = I_ξ ω_η' + ω_ζ (I_ξ ω_ζ - I_ζ Ω_ζ)        H_0 = ∫ r × (ω × r) dm        ω_3 = const

A product is written by juxtaposition and binds closer than ×, which binds closer than ·. A prime behind a name is a
rate, unless a name with that prime is known. ``dr/dt`` is a rate, ``d'r/dt`` the rate in axes that turn. An integral
ends with dm, or it is over the loads dF. ``det(a, b; c, d)`` is a determinant,
``int(f, a, b)`` an integral over x, ``between(f, a, b)`` the difference of f at its limits.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import sympy

from ...errors import ModelError

_WORDS = "alpha beta gamma delta epsilon zeta eta theta mu xi rho sigma phi psi omega Omega Theta Psi"
GREEK = dict(zip(_WORDS.split(), "αβγδεζηθμξρσφψωΩΘΨ", strict=True))
FUNCTIONS = ("sin", "cos", "tan", "exp")
LISTS = ("det", "int", "between")
RELATIONS = ("=", "≅", "<", ">")
_TOKEN = re.compile(
    r"\s*(?:(?P<rate>d/dt\b)|(?P<name>a_C/A|d'?[A-Za-z]+(?:_\w+)?/dt|const|d[mF]\b|[A-Za-zα-ωΑ-Ω]+'*"
    r"(?:_[A-Za-z0-9α-ω]+(?:'[a-z])?'*)?(?:\([0t]\))?)|(?P<number>\d+(?:\.\d+)?)|(?P<sign>[=≅<>+\-×·/^()\[\]|∫,;]))"
)


def greek(name: str) -> str:
    """A name of the library in the chapter's letters.

    >>> greek("I_xi"), greek("theta'"), greek("psi_0'"), greek("M_0x")
    ('I_ξ', "θ'", "ψ_0'", 'M_0x')
    """
    return re.sub(r"[A-Za-z]+", lambda m: GREEK.get(m[0], m[0]), name)


@dataclass(frozen=True)
class Node:
    """A node of a print."""

    kind: str
    """number, name, sum, product, cross, dot, power, call, integral, size, rate, group or const"""
    value: Any = None
    """Of a number or name itself; of a sum the signs, of a product ``*`` and ``/``, of a call the function."""
    parts: tuple[Node, ...] = ()

    def __str__(self) -> str:
        return _TEXT[self.kind](self, *map(str, self.parts))

    def walk(self, path: tuple[int, ...] = ()) -> Iterator[tuple[tuple[int, ...], Node]]:
        """Every node with its place."""
        yield path, self
        for i, part in enumerate(self.parts):
            yield from part.walk((*path, i))

    def put(self, path: tuple[int, ...], node: Node) -> Node:
        """The same tree with another node at a place."""
        if not path:
            return node
        i = path[0]
        parts = (*self.parts[:i], self.parts[i].put(path[1:], node), *self.parts[i + 1 :])
        return replace(self, parts=parts)


@dataclass(frozen=True)
class Relation:
    """Two members of a print: ``left sign right``, the left one always the first of its chain."""

    left: Node
    sign: str
    right: Node

    def __str__(self) -> str:
        return f"{self.left} {self.sign} {self.right}"


@dataclass(frozen=True)
class Print:
    """A printed equation: its members, and the signs between them."""

    members: tuple[Node, ...]
    signs: tuple[str, ...]

    @property
    def relations(self) -> tuple[Relation, ...]:
        """The first member with each of the others."""
        return tuple(
            Relation(self.members[0], s, m) for s, m in zip(self.signs, self.members[1:], strict=True)
        )

    def __str__(self) -> str:
        return str(self.members[0]) + "".join(
            f" {s} {m}" for s, m in zip(self.signs, self.members[1:], strict=True)
        )


def read(text: str) -> Print:
    """A print from its text.

    >>> [str(r) for r in read("F_y = V - W = 0").relations]
    ['F_y = V - W', 'F_y = 0']
    """
    reader = _Reader(text)
    members, signs = [reader.sum()], []
    while reader.sign in RELATIONS:
        signs.append(reader.take())
        members.append(reader.sum())
    if reader.token is not None or not signs:
        raise ModelError(f"Expected an equation, got '{text}'; check what stands from '{reader.rest()}'.")
    return Print(tuple(members), tuple(signs))


class _Reader:
    """A print, token by token."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens: list[tuple[str, str, int]] = []
        at = 0
        while text[at:].strip():
            found = _TOKEN.match(text, at)
            if found is None:
                raise ModelError(
                    f"Expected a sign of the chapter's notation in '{text}', got '{text[at:].strip()[0]}'."
                )
            self.tokens.append((str(found.lastgroup), found[found.lastgroup or 0], found.start()))
            at = found.end()
        self.at = 0

    @property
    def token(self) -> tuple[str, str, int] | None:
        return self.tokens[self.at] if self.at < len(self.tokens) else None

    @property
    def sign(self) -> str:
        return self.token[1] if self.token and self.token[0] == "sign" else ""

    def rest(self) -> str:
        return self.text[self.token[2] :].strip() if self.token else ""

    def take(self, expected: str = "") -> str:
        token = self.token
        if token is None or (expected and token[1] != expected):
            raise ModelError(
                f"Expected '{expected or 'more'}' in '{self.text}', got '{self.rest() or 'its end'}'."
            )
        self.at += 1
        return token[1]

    def sum(self) -> Node:
        signs: list[str] = []
        parts: list[Node] = []
        while not parts or self.sign in ("+", "-"):
            signs.append(self.take() if self.sign in ("+", "-") else "")
            parts.append(self.dot())
        return parts[0] if len(parts) == 1 and not signs[0] else Node("sum", tuple(signs), tuple(parts))

    def dot(self) -> Node:
        node = self.cross()
        while self.sign == "·":
            self.take()
            node = Node("dot", None, (node, self.cross()))
        return node

    def cross(self) -> Node:
        node = self.product()
        if self.sign == "×":
            self.take()
            node = Node("cross", None, (node, self.cross()))
        return node

    def product(self) -> Node:
        signs, parts = ["*"], [self.power()]
        while self.sign == "/" or self._factor_follows():
            signs.append(self.take() if self.sign == "/" else "*")
            parts.append(self.power())
        return parts[0] if len(parts) == 1 else Node("product", tuple(signs), tuple(parts))

    def _factor_follows(self) -> bool:
        token = self.token
        if token is None or token[1] in ("dm", "dF"):
            return False
        return token[0] in ("name", "number", "rate") or token[1] in ("(", "[", "∫")

    def power(self) -> Node:
        base = self.base()
        if self.sign != "^":
            return base
        self.take()
        return Node("power", None, (base, self.base()))

    def base(self) -> Node:
        kind, text, _ = self.token or ("", "", 0)
        if kind == "number":
            return Node("number", self.take())
        if kind == "rate":
            self.take()
            return Node("rate", None, (self.base(),))
        if text == "const":
            self.take()
            return Node("const")
        if text in (*FUNCTIONS, *LISTS):
            return self.call()
        if kind == "name":
            return Node("name", self.take())
        if text == "∫":
            self.take()
            parts = () if self.token and self.token[1] == "dm" else (self.sum(),)
            return Node("integral", self.take() if self.token and self.token[1] == "dm" else "", parts)
        if text == "|":
            self.take()
            inner = self.sum()
            self.take("|")
            return Node("size", None, (inner,))
        if text in ("(", "["):
            self.take()
            inner = self.sum()
            self.take(")" if text == "(" else "]")
            return Node("group", text, (inner,))
        raise ModelError(f"Expected a factor in '{self.text}', got '{self.rest() or 'its end'}'.")

    def call(self) -> Node:
        """A function of a name, a number or what stands in brackets; ``sin^2 β``."""
        name = self.take()
        if name in LISTS:
            self.take("(")
            parts = [self.sum()]
            while self.sign in (",", ";"):
                self.take()
                parts.append(self.sum())
            self.take(")")
            return Node("call", name, tuple(parts))
        exponent = None
        if self.sign == "^":
            self.take()
            exponent = self.base()
        node = Node("call", name, (self.base(),))
        return Node("power", None, (node, exponent)) if exponent else node


def _sum_text(node: Node, *parts: str) -> str:
    first = node.value[0] + parts[0]
    return first + "".join(f" {s} {p}" for s, p in zip(node.value[1:], parts[1:], strict=True))


def _product_text(node: Node, *parts: str) -> str:
    return parts[0] + "".join(
        ("/" if s == "/" else " ") + p for s, p in zip(node.value[1:], parts[1:], strict=True)
    )


def _call_text(node: Node, *parts: str) -> str:
    if node.value == "det":
        return "det({}, {}; {}, {})".format(*parts)
    if node.value in LISTS:
        return f"{node.value}({', '.join(parts)})"
    return f"{node.value}{'' if parts[0][0] in '([' else ' '}{parts[0]}"


_TEXT: dict[str, Callable[..., str]] = {
    "number": lambda n: n.value,
    "name": lambda n: n.value,
    "const": lambda n: "const",
    "sum": _sum_text,
    "product": _product_text,
    "cross": lambda n, a, b: f"{a} × {b}",
    "dot": lambda n, a, b: f"{a} · {b}",
    "power": lambda n, a, b: f"{a}^{b}",
    "call": _call_text,
    "integral": lambda n, *p: " ".join(("∫", *p, n.value)).rstrip(),
    "size": lambda n, a: f"|{a}|",
    "rate": lambda n, a: f"d/dt {a}",
    "group": lambda n, a: f"{n.value}{a}{')' if n.value == '(' else ']'}",
}


def latex(node: Node, vectors: frozenset[str] = frozenset()) -> str:
    """A print as LaTeX; the names of vectors are bold.

    >>> print(latex(read("R = 1/2 m L^2 cos θ").members[1]))
    \\frac{1}{2} m L^{2} \\cos \\theta
    """
    p = [latex(x, vectors) for x in node.parts]
    if node.kind == "name":
        return _name_latex(node.value, node.value in vectors)
    if node.kind == "product":
        return _product_latex(node, p)
    if node.kind == "group":
        return rf"\left{node.value}{p[0]}\right{')' if node.value == '(' else ']'}"
    if node.kind == "call" and node.value == "det":
        return r"\begin{vmatrix}" + rf"{p[0]} & {p[1]} \\ {p[2]} & {p[3]}" + r"\end{vmatrix}"
    if node.kind == "call" and node.value == "int":
        return rf"\int_{{{p[1]}}}^{{{p[2]}}} {p[0]}\,\mathrm{{d}}x"
    if node.kind == "call" and node.value == "between":
        return rf"\left. {p[0]} \right|_{{{p[1]}}}^{{{p[2]}}}"
    plain = {
        "number": node.value, "const": r"\mathrm{const}", "cross": r" \times ".join(p), "dot": r" \cdot ".join(p),
        "call": f"\\{node.value} {' '.join(p)}",
        "integral": rf"\int {' '.join(p)}" + (r"\,\mathrm{d}m" if node.value else ""),
        "size": f"|{' '.join(p)}|", "rate": rf"\frac{{\mathrm{{d}}}}{{\mathrm{{d}}t}} {' '.join(p)}",
        "power": "^".join((p[0], f"{{{p[1]}}}")) if len(p) == 2 else "",
    }  # fmt: skip
    return _sum_text(node, *p) if node.kind == "sum" else str(plain[node.kind])


def _product_latex(node: Node, parts: list[str]) -> str:
    """Factors; a stroke makes a fraction of what stands before it since the last one, and of the factor behind it."""
    bare = [_unbracketed(x, text) for x, text in zip(node.parts, parts, strict=True)]
    done: list[str] = []
    above = [0]
    for k, sign in enumerate(node.value[1:], start=1):
        if sign == "*":
            above.append(k)
            continue
        over = bare[above[0]] if len(above) == 1 else " ".join(parts[i] for i in above)
        done.append(rf"\frac{{{over or 1}}}{{{bare[k]}}}")
        above = []
    return " ".join([*done, *(parts[i] for i in above)])


def _unbracketed(node: Node, text: str) -> str:
    """What stands in brackets, without them: a fraction's bar holds it together."""
    return text.removeprefix(r"\left(").removesuffix(r"\right)") if node.kind == "group" else text


_LETTERS = {letter: f"\\{name} " for name, letter in GREEK.items()}


def _name_latex(name: str, bold: bool) -> str:
    rate = re.fullmatch(r"d('?)([A-Za-z]+)(_\w+)?/dt", name)
    if rate:
        inner = _name_latex(rate[2] + (rate[3] or ""), True)
        return rf"\frac{{\mathrm{{d}}{rate[1]}{inner}}}{{\mathrm{{d}}t}}"
    found = re.fullmatch(r"(\w+?)('*)(?:_(\w+(?:'\w)?|C/A))?('*)(\([0t]\))?", name)
    assert found is not None, name
    stem, own, index, primes, at = (x or "" for x in found.groups())
    spelt = lambda x: "".join(_LETTERS.get(c, c) for c in x).strip()  # noqa: E731
    head = rf"\boldsymbol{{{spelt(stem)}}}" if bold else spelt(stem)
    return head + own + (f"_{{{spelt(index)}}}" if index else "") + primes + at


def evaluate(node: Node, meaning: Any, element: Any = None) -> Any:
    """The value of a print where its names mean what the library gives: a SymPy expression, or a column.

    Raises
    ------
    TypeError, sympy.ShapeError
        Of a scalar and a vector added, and the like: what the print says has no value.
    """
    value = lambda n: evaluate(n, meaning, element)  # noqa: E731
    match node.kind:
        case "number":
            return sympy.Rational(node.value)
        case "name":
            return _named(node.value, meaning, element)
        case "sum":
            return _added([(s, value(p)) for s, p in zip(node.value, node.parts, strict=True)])
        case "product":
            return _multiplied([(s, value(p)) for s, p in zip(node.value, node.parts, strict=True)])
        case "cross":
            a, b = (_vector(value(p)) for p in node.parts)
            return sympy.Matrix(cross(tuple(a), tuple(b)))
        case "dot":
            a, b = (_vector(value(p)) for p in node.parts)
            return sum((x * y for x, y in zip(a, b, strict=True)), sympy.Integer(0))
        case "power":
            base, exponent = (value(p) for p in node.parts)
            return (
                base.dot(base)
                if isinstance(base, sympy.MatrixBase) and exponent == 2
                else _scalar(base) ** exponent
            )
        case "call" if node.value == "det":
            a, b, c, d = (_scalar(value(p)) for p in node.parts)
            return a * d - b * c
        case "call" if node.value in ("int", "between"):
            inside, low, high = (_scalar(value(p)) for p in node.parts)
            x = _named("x", meaning, element)
            if node.value == "int":
                return sympy.integrate(inside, (x, low, high))
            return inside.subs(x, high) - inside.subs(x, low)
        case "call":
            return getattr(sympy, node.value)(_scalar(value(node.parts[0])))
        case "integral":
            return meaning.integral(node, evaluate)
        case "size":
            return sympy.sqrt(value(node.parts[0]).dot(value(node.parts[0])))
        case "rate":
            return sympy.diff(value(node.parts[0]), meaning.time)
        case "group":
            return value(node.parts[0])
    raise TypeError(f"{node.kind} has no value")


def cross(a: Any, b: Any) -> Any:
    """The library's vector product."""
    from ...scalar.algebra import cross as product

    return product(a, b)


def _named(name: str, meaning: Any, element: Any) -> Any:
    for known in (element or {}, meaning.names):
        if name in known:
            return known[name]
    if name.endswith("'"):
        return sympy.diff(_named(name[:-1], meaning, element), meaning.time)
    raise KeyError(name)


def _vector(x: Any) -> Any:
    if not isinstance(x, sympy.MatrixBase):
        raise TypeError("a vector product of numbers")
    return x


def _scalar(x: Any) -> Any:
    if isinstance(x, sympy.MatrixBase):
        raise TypeError("a vector where a number is expected")
    return x


def _added(terms: list[tuple[str, Any]]) -> Any:
    total = None
    for sign, x in terms:
        signed = -x if sign == "-" else x
        if total is not None and isinstance(total, sympy.MatrixBase) != isinstance(signed, sympy.MatrixBase):
            raise TypeError("a sum of a number and a vector")
        total = signed if total is None else total + signed
    return total


def _multiplied(factors: list[tuple[str, Any]]) -> Any:
    total = None
    for sign, x in factors:
        if sign == "/":
            total = total / _scalar(x)
        elif total is not None and isinstance(total, sympy.MatrixBase) and isinstance(x, sympy.MatrixBase):
            raise TypeError("a product of vectors without a sign")
        else:
            total = x if total is None else total * x
    return total
