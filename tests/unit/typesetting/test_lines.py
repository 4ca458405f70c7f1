"""Where a line may end: before relations and sums, in brackets if they are wide."""

from __future__ import annotations

import pytest

from freebody.typesetting.boxes import flat
from freebody.typesetting.latex import parse
from freebody.typesetting.lines import pieces
from freebody.typesetting.setting import Style, setting

LONG = " + ".join(rf"m_{k} L_{k}^{{2}} \ddot{{\theta}}_{k}" for k in range(9))


def test_pieces_together_are_the_formula() -> None:
    for tex in ("a = b + c", f"x = {LONG}", rf"x = m \left({LONG}\right) g"):
        parts = pieces(parse(tex), 16000)
        whole = setting(parse(tex), Style())
        assert sum(box.width for box in parts) == pytest.approx(whole.width)
        assert sum(len(flat(box).items) for box in parts) == len(flat(whole).items)


@pytest.mark.parametrize("column", [12000, 16000, 40000])
@pytest.mark.parametrize(
    "tex",
    [
        f"x = {LONG}",
        rf"x = m \left({LONG}\right) g",
        rf"x = m \left(a \left({LONG}\right) + b\right)^{{2}} g",
        rf"x = \frac{{{LONG}}}{{M + m}}",
        rf"x = \frac{{a}}{{{LONG}}}",
        rf"x = \frac{{{LONG}}}{{{LONG}}}",
        rf"x = \sqrt{{{LONG}}}",
        rf"x = \frac{{1}}{{\sqrt{{{LONG}}}}} + \frac{{1}}{{{LONG}}}",
    ],
)
def test_pieces_fit_the_column(tex: str, column: float) -> None:
    boxes = pieces(parse(tex), column)
    assert len(boxes) > 1
    if r"\frac{1}{\sqrt" in tex:  # a root below a bar stays whole: its piece is drawn smaller by the browser
        boxes = [box for box in boxes if box.width < 30000]
    assert max(box.width for box in boxes) <= column


def test_a_short_end_does_not_stand_alone() -> None:
    assert len(pieces(parse("a + b = 0"), 16000)) == 2
    assert len(pieces(parse("a + b = 0"), 1)) == 3
    assert len(pieces(parse(f"a = {LONG}"), 16000)) == 10
