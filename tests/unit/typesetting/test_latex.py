"""The tree of a formula in LaTeX, and what is refused."""

from __future__ import annotations

import pytest

from freebody.errors import FreebodyError
from freebody.typesetting.latex import (
    OP,
    ORD,
    Accent,
    Fenced,
    Fraction,
    Grid,
    Root,
    Row,
    Scripts,
    Symbol,
    Words,
    parse,
    rows,
)


def only(tex: str) -> object:
    row = parse(tex)
    assert isinstance(row, Row) and len(row.nodes) == 1, row
    return row.nodes[0]


def test_nodes() -> None:
    x, two = Symbol("x", "i", ORD), Symbol("2", "r", ORD)
    assert only("x") == x
    assert only("x_{1}^2") == Scripts(x, Symbol("1", "r", ORD), two)
    assert only(r"\frac{x}{2}") == Fraction(x, two)
    assert only(r"\sqrt[3]{x}") == Root(x, Row((Symbol("3", "r", ORD),)))
    assert only(r"\left|x\right.") == Fenced("|", Row((x,)), " ")
    assert only(r"\ddot{\theta}") == Accent(Symbol("θ", "i", ORD), "¨")
    assert only(r"\mathrm{mass}") == Symbol("mass", "r", ORD)
    assert only(r"\operatorname{atan2}") == Symbol("atan2", "r", OP)
    assert only(r"\text{if a\_b}") == Words("if a_b")
    assert only(r"\begin{bmatrix}x & 2 \\ 2 & x\end{bmatrix}") == Grid(
        "bmatrix", ((Row((x,)), Row((two,))), (Row((two,)), Row((x,))))
    )


@pytest.mark.parametrize(
    ("tex", "problem"),
    [
        (r"\foo x", r"the unknown command '\\foo'"),
        (r"\left(x", r"no '\\right'"),
        ("x}", "'}' without its beginning"),
        ("x^", "its end in place of an argument"),
        ("x_1_2", "two scripts '_' of one sign"),
        (r"\frac{x", "no '}'"),
        (r"\begin{tikz}x\end{tikz}", "the unknown block 'tikz'"),
        (r"\left+x\right)", r"'\+' in place of a bracket"),
        (r"\text{x", "no '}'"),
    ],
)
def test_what_is_no_formula_is_refused(tex: str, problem: str) -> None:
    with pytest.raises(FreebodyError, match=f"Expected a formula that can be set, got {problem}"):
        parse(tex)


def test_rows_of_blocks_in_blocks() -> None:
    inner = r"\begin{aligned}b &= \begin{bmatrix}1 \\ 2\end{bmatrix} \\ c &= 3\end{aligned}"
    tex = "\\begin{aligned}\na &= 1 \\\\\n&" + inner + "\n\\end{aligned}"
    assert rows(tex) == ["a = 1", r"b = \begin{bmatrix}1 \\ 2\end{bmatrix}", "c = 3"]
    assert rows(" x \n y") == ["x y"]
