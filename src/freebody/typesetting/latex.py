r"""The tree of a formula in LaTeX: the part of the language that results are printed in.

``\frac{a}{b}``, ``\sqrt``, ``\left( \right)``, scripts, accents, fonts, words, arrays, and the signs of `SIGNS`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from ..errors import FreebodyError

ORD, OP, BIN, REL, OPEN, CLOSE, PUNCT, INNER = range(8)
"""Classes of atoms: they say how much space is between two of them (Knuth, The TeXbook, chapter 18)."""

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "zeta": "ζ", "eta": "η", "theta": "θ", "iota": "ι",
    "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "pi": "π", "rho": "ρ", "sigma": "σ", "tau": "τ",
    "upsilon": "υ", "chi": "χ", "psi": "ψ", "omega": "ω", "epsilon": "ε", "varepsilon": "ε", "phi": "ϕ",
    "varphi": "φ", "ell": "ℓ", "partial": "∂",
}  # fmt: skip
CAPITALS = {
    "Gamma": "Γ", "Delta": "Δ", "Theta": "Θ", "Lambda": "Λ", "Xi": "Ξ", "Pi": "Π", "Sigma": "Σ", "Upsilon": "Υ",
    "Phi": "Φ", "Psi": "Ψ", "Omega": "Ω",
}  # fmt: skip
SIGNS = {
    "times": ("×", BIN), "cdot": ("⋅", BIN), "pm": ("±", BIN), "mp": ("∓", BIN), "circ": ("∘", BIN),
    "wedge": ("∧", BIN), "vee": ("∨", BIN), "leq": ("≤", REL), "le": ("≤", REL), "geq": ("≥", REL),
    "ge": ("≥", REL), "neq": ("≠", REL), "ne": ("≠", REL), "approx": ("≈", REL), "equiv": ("≡", REL),
    "to": ("→", REL), "rightarrow": ("→", REL), "Rightarrow": ("⇒", REL), "sim": ("∼", REL), "in": ("∈", REL),
    "parallel": ("∥", REL), "perp": ("⊥", REL), "infty": ("∞", ORD), "prime": ("′", ORD), "ldots": ("…", INNER),
    "dots": ("…", INNER), "cdots": ("⋯", INNER), "degree": ("°", ORD), "int": ("∫", OP), "sum": ("∑", OP),
    "prod": ("∏", OP), "%": ("%", ORD), "&": ("&", ORD), "#": ("#", ORD), "_": ("_", ORD), "$": ("$", ORD),
    "{": ("{", OPEN), "}": ("}", CLOSE), "langle": ("⟨", OPEN), "rangle": ("⟩", CLOSE), "lvert": ("|", OPEN),
    "rvert": ("|", CLOSE), "mid": ("|", REL), "angle": ("∠", ORD),
}  # fmt: skip
CHARACTERS = {
    "+": ("+", BIN), "-": ("−", BIN), "−": ("−", BIN), "*": ("∗", BIN), "=": ("=", REL), "<": ("<", REL),
    ">": (">", REL), "(": ("(", OPEN), "[": ("[", OPEN), ")": (")", CLOSE), "]": ("]", CLOSE), ",": (",", PUNCT),
    ";": (";", PUNCT), ":": (":", REL), "'": ("′", ORD), "≤": ("≤", REL), "≥": ("≥", REL), "→": ("→", REL),
    "·": ("⋅", BIN), "×": ("×", BIN), "≈": ("≈", REL), "±": ("±", BIN),
}  # fmt: skip
FUNCTIONS = frozenset({
    "sin", "cos", "tan", "cot", "sec", "csc", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "coth", "exp",
    "ln", "log", "max", "min", "lim", "det", "arg", "sup", "inf", "sgn",
})  # fmt: skip
ACCENTS = {"dot": "˙", "ddot": "¨", "dddot": "⃛", "hat": "ˆ", "tilde": "˜", "bar": "¯", "vec": "→"}
SPACES = {",": 167, ":": 222, ";": 278, "!": -167, " ": 250, "quad": 1000, "qquad": 2000, ">": 222}
"""Widths of spaces [em/1000]."""
FONTS = {
    "mathrm": "r",
    "mathit": "i",
    "mathbf": "b",
    "boldsymbol": "j",
    "mathsf": "r",
    "mathtt": "r",
    "bm": "j",
}
GRIDS = {
    "bmatrix": "[]",
    "pmatrix": "()",
    "matrix": "  ",
    "vmatrix": "||",
    "smallmatrix": "  ",
    "array": "  ",
    "aligned": "  ",
    "cases": "{ ",
}


@dataclass(frozen=True)
class Symbol:
    """A sign, a letter or an upright word (``text`` of several letters)."""

    text: str
    style: str
    kind: int


@dataclass(frozen=True)
class Space:
    """A space."""

    width: int


@dataclass(frozen=True)
class Row:
    """Nodes side by side."""

    nodes: tuple[Node, ...]


@dataclass(frozen=True)
class Scripts:
    """A node with a subscript, a superscript, or both."""

    base: Node
    sub: Node | None
    sup: Node | None


@dataclass(frozen=True)
class Fraction:
    """A fraction with a bar."""

    top: Node
    below: Node


@dataclass(frozen=True)
class Root:
    """A root; ``index`` is 3 for a cube root."""

    body: Node
    index: Node | None = None


@dataclass(frozen=True)
class Fenced:
    """A node in brackets of its height; a space in place of a bracket stands for none."""

    left: str
    body: Node
    right: str


@dataclass(frozen=True)
class Accent:
    """A node with dots, a hat or a line above."""

    body: Node
    mark: str


@dataclass(frozen=True)
class Words:
    """Words."""

    text: str


@dataclass(frozen=True)
class Grid:
    """Rows of cells; ``name`` is the LaTeX environment."""

    name: str
    rows: tuple[tuple[Node, ...], ...]


Node = Symbol | Space | Row | Scripts | Fraction | Root | Fenced | Accent | Words | Grid

_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|[^\\]", re.DOTALL)


def parse(tex: str) -> Node:
    r"""Return the tree of a formula.

    >>> parse(r"m \ddot{x}").nodes[1]
    Accent(body=Symbol(text='x', style='i', kind=0), mark='¨')

    Raises
    ------
    FreebodyError
        If a command is not one of those that are known, or a bracket is missing.
    """
    reader = _Reader(tex)
    result = reader.row(())
    if reader.token:
        raise reader.error(f"'{reader.token}' without its beginning")
    return result


def rows(tex: str) -> list[str]:
    r"""Return the lines of a formula: those of its ``aligned`` blocks, of blocks in blocks too, without alignment.

    >>> rows(r"\begin{aligned} a &= b \\ &\begin{aligned} c &= d \end{aligned} \end{aligned}")
    ['a = b', 'c = d']
    """
    begin, end = r"\begin{aligned}", r"\end{aligned}"
    tex = " ".join(tex.split())
    if not (tex.startswith(begin) and tex.endswith(end)):
        return [tex]
    result, depth, line = [], 0, ""
    for match in re.finditer(r"\\(?:begin|end)\{[a-z]+\}|\\\\|\\.|.", tex[len(begin) : -len(end)], re.DOTALL):
        token = match[0]
        depth += token.startswith((r"\begin{", "{")) - token.startswith((r"\end{", "}"))
        if token == r"\\" and not depth:
            result.append(line)
            line = ""
        elif token != "&" or depth:
            line += token
    return [row for part in (*result, line) for row in rows(part) if row]


class _Reader:
    """Reader of LaTeX; ``token`` is the next token, empty at the end."""

    def __init__(self, tex: str) -> None:
        self.tex = tex
        self.tokens: Iterator[str] = (match[0] for match in _TOKEN.finditer(tex))
        self.token = ""
        self.advance()

    def error(self, problem: str) -> FreebodyError:
        return FreebodyError(f"Expected a formula that can be set, got {problem} in '{self.tex}'.")

    def advance(self) -> str:
        """Return the token, and go to the next one."""
        token, self.token = self.token, next(self.tokens, "")
        return token

    def skip(self) -> None:
        while self.token.isspace():
            self.advance()

    def expect(self, token: str) -> None:
        self.skip()
        if self.token != token:
            raise self.error(f"'{self.token or 'its end'}' in place of '{token}'")
        self.advance()

    def row(self, ends: tuple[str, ...], style: str = "") -> Row:
        """Read nodes up to one of the tokens ``ends``, which is left; at the end of the text without ``ends``."""
        nodes: list[Node] = []
        while True:
            self.skip()
            if self.token in ends or not self.token and not ends or self.token == "}" and not ends:
                return Row(tuple(nodes))
            if not self.token:
                raise self.error(f"no '{ends[0]}'")
            nodes.append(self.scripted(nodes, style))

    def scripted(self, nodes: list[Node], style: str) -> Node:
        base = Row(()) if self.token in "^_" else self.node(style)
        if isinstance(base, Space):
            return base
        sub: Node | None = None
        sup: Node | None = None
        self.skip()
        while self.token and self.token in "^_'":
            mark = self.advance()
            if mark == "'":
                sup = Row((*(sup.nodes if isinstance(sup, Row) else ()), Symbol("′", "r", ORD)))
            else:
                script = self.argument(style)
                if (sub if mark == "_" else sup) is not None:
                    raise self.error(f"two scripts '{mark}' of one sign")
                sub, sup = (script, sup) if mark == "_" else (sub, script)
            self.skip()
        return base if sub is None and sup is None else Scripts(base, sub, sup)

    def argument(self, style: str = "") -> Node:
        """Read what a command or a script is about: a group, or one node."""
        self.skip()
        if not self.token:
            raise self.error("its end in place of an argument")
        return self.node(style)

    def node(self, style: str) -> Node:
        token = self.advance()
        if token == "{":
            result = self.row(("}",), style)
            self.advance()
            return result.nodes[0] if len(result.nodes) == 1 else result
        if token.startswith("\\"):
            return self.command(token[1:], style)
        if token == "~":
            return Space(SPACES[" "])
        if token in CHARACTERS:
            text, kind = CHARACTERS[token]
            return Symbol(text, "r", kind)
        if token in "{}&^_":
            raise self.error(f"'{token}' without its beginning")
        if token.isalpha():
            return Symbol(token, style or ("r" if token in CAPITALS.values() else "i"), ORD)
        return Symbol(token, "b" if style in "bj" and style else "r", ORD)

    def command(self, name: str, style: str) -> Node:
        if name in SPACES:
            return Space(SPACES[name])
        if name in GREEK:
            return Symbol(GREEK[name], {"r": "r", "b": "j", "j": "j"}.get(style, "i"), ORD)
        if name in CAPITALS:
            return Symbol(CAPITALS[name], {"b": "b", "j": "b"}.get(style, "r"), ORD)
        if name in SIGNS:
            return Symbol(SIGNS[name][0], "r", SIGNS[name][1])
        if name in FUNCTIONS:
            return Symbol(name, "r", OP)
        if name in ACCENTS or name == "overline":
            return Accent(self.argument(style), ACCENTS.get(name, "line"))
        if name in FONTS:
            return _word(self.argument(FONTS[name]), ORD)
        rest = {
            "frac": lambda: Fraction(self.argument(style), self.argument(style)),
            "dfrac": lambda: Fraction(self.argument(style), self.argument(style)),
            "tfrac": lambda: Fraction(self.argument(style), self.argument(style)),
            "sqrt": lambda: self.root(style),
            "left": lambda: self.fenced(style),
            "operatorname": lambda: _word(self.argument("r"), OP),
            "text": lambda: Words(self.raw()),
            "begin": lambda: self.grid(style),
            "displaystyle": lambda: Space(0),
            "limits": lambda: Space(0),
            "hline": lambda: Space(0),
        }.get(name)
        if rest is None:
            raise self.error(f"the unknown command '\\{name}'")
        return rest()

    def root(self, style: str) -> Node:
        self.skip()
        index = None
        if self.token == "[":
            self.advance()
            index = self.row(("]",), style)
            self.advance()
        return Root(self.argument(style), index)

    def bracket(self) -> str:
        self.skip()
        token = self.advance()
        text = SIGNS[token[1:]][0] if token[1:] in SIGNS else {".": " ", "\\|": "‖"}.get(token, token)
        if text not in tuple("()[]{}|‖⟨⟩ /"):
            raise self.error(f"'{token}' in place of a bracket")
        return text

    def fenced(self, style: str) -> Node:
        left = self.bracket()
        body = self.row(("\\right",), style)
        self.advance()
        return Fenced(left, body, self.bracket())

    def raw(self) -> str:
        """Read the words of an argument."""
        self.expect("{")
        result, depth = "", 1
        while depth:
            if not self.token:
                raise self.error("no '}'")
            token = self.advance()
            depth += (token == "{") - (token == "}")
            if depth and token not in "{}":
                result += token[1:] if len(token) == 2 and token[0] == "\\" else token
        return result

    def grid(self, style: str) -> Node:
        name = self.raw()
        if name not in GRIDS:
            raise self.error(f"the unknown block '{name}'")
        if name == "array":
            self.raw()
        table: list[list[Node]] = [[]]
        while True:
            table[-1].append(self.row(("&", "\\\\", "\\end"), style))
            token = self.advance()
            if token == "\\\\":
                table.append([])
            elif token == "\\end":
                break
        self.raw()
        if len(table) > 1 and all(isinstance(cell, Row) and not cell.nodes for cell in table[-1]):
            table.pop()
        return Grid(name, tuple(map(tuple, table)))


def _word(node: Node, kind: int) -> Node:
    """Return upright letters side by side as one word."""
    letters = node.nodes if isinstance(node, Row) else (node,)
    if all(isinstance(x, Symbol) and len(x.text) == 1 for x in letters) and letters:
        signs = [x for x in letters if isinstance(x, Symbol)]
        if len({x.style for x in signs}) == 1:
            return Symbol("".join(x.text for x in signs), signs[0].style, kind)
    return node
