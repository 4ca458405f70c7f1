"""The printed equations of the chapter, parsed from its notation into a tree, and written back as text.

    M_η = I_ξ ω_η' + ω_ζ (I_ξ ω_ζ - I_ζ Ω_ζ)        H_0 = ∫ r × (ω × r) dm        ω_3 = const

A product is written by juxtaposition and binds tighter than ×, which binds tighter than ·. A prime after a name is a
rate, unless a name with that prime is defined. ``dr/dt`` is a rate, ``d'r/dt`` the rate in rotating axes. An integral
ends with dm, or it is over the loads dF. ``det(a, b; c, d)`` is a determinant,
``int(f, a, b)`` an integral over x, ``between(f, a, b)`` the difference of f at its limits.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from ..errors import ModelError

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
    """Return a name of the library in the chapter's letters.

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
    """The number or name itself; the signs of a sum; ``*`` and ``/`` of a product; the function of a call."""
    parts: tuple[Node, ...] = ()

    def __str__(self) -> str:
        return _TEXT[self.kind](self, *map(str, self.parts))

    def walk(self, path: tuple[int, ...] = ()) -> Iterator[tuple[tuple[int, ...], Node]]:
        """Yield every node with its path."""
        yield path, self
        for i, part in enumerate(self.parts):
            yield from part.walk((*path, i))

    def put(self, path: tuple[int, ...], node: Node) -> Node:
        """Return the tree with another node at a path."""
        if not path:
            return node
        i = path[0]
        parts = (*self.parts[:i], self.parts[i].put(path[1:], node), *self.parts[i + 1 :])
        return replace(self, parts=parts)


@dataclass(frozen=True)
class Relation:
    """Two members of a print: ``left sign right``; the left one is always the first of its chain."""

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
        """Relations of the first member with each other member."""
        return tuple(
            Relation(self.members[0], s, m) for s, m in zip(self.signs, self.members[1:], strict=True)
        )

    def __str__(self) -> str:
        return str(self.members[0]) + "".join(
            f" {s} {m}" for s, m in zip(self.signs, self.members[1:], strict=True)
        )


def read(text: str) -> Print:
    """Parse a print from its text.

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
    """Parser of a print, token by token."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens: list[tuple[str, str, int]] = []
        at = 0
        while text[at:].strip():
            matched = _TOKEN.match(text, at)
            if matched is None:
                raise ModelError(
                    f"Expected a sign of the chapter's notation in '{text}', got '{text[at:].strip()[0]}'."
                )
            self.tokens.append((str(matched.lastgroup), matched[matched.lastgroup or 0], matched.start()))
            at = matched.end()
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
        """Parse a function of a name, a number or a group in brackets; also ``sin^2 β``."""
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


def signed(node: Node, *parts: str) -> str:
    """Return the text of a sum from the texts of its terms."""
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
    "sum": signed,
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
