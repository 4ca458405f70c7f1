"""The printed equations of the chapter as LaTeX."""

from __future__ import annotations

import re

from .notation import GREEK, Node, signed


def latex(node: Node, vectors: frozenset[str] = frozenset()) -> str:
    """Return a print as LaTeX; the names of vectors are bold.

    >>> from freebody.chapter.notation import read
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
    return signed(node, *p) if node.kind == "sum" else str(plain[node.kind])


def _product_latex(node: Node, parts: list[str]) -> str:
    """LaTeX of a product; a slash makes a fraction of the factors since the last slash and the factor after it."""
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
    """LaTeX of a group without its brackets: the bar of a fraction groups it."""
    return text.removeprefix(r"\left(").removesuffix(r"\right)") if node.kind == "group" else text


_LETTERS = {letter: f"\\{name} " for name, letter in GREEK.items()}


def _name_latex(name: str, bold: bool) -> str:
    rate = re.fullmatch(r"d('?)([A-Za-z]+)(_\w+)?/dt", name)
    if rate:
        inner = _name_latex(rate[2] + (rate[3] or ""), True)
        return rf"\frac{{\mathrm{{d}}{rate[1]}{inner}}}{{\mathrm{{d}}t}}"
    match = re.fullmatch(r"(\w+?)('*)(?:_(\w+(?:'\w)?|C/A))?('*)(\([0t]\))?", name)
    assert match is not None, name
    stem, own, index, primes, at = (x or "" for x in match.groups())
    spelt = lambda x: "".join(_LETTERS.get(c, c) for c in x).strip()  # noqa: E731
    head = rf"\boldsymbol{{{spelt(stem)}}}" if bold else spelt(stem)
    return head + own + (f"_{{{spelt(index)}}}" if index else "") + primes + at
