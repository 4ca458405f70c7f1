"""Formulas in HTML: one table of glyphs, the LaTeX to copy, and every name of the gallery as a symbol."""

from __future__ import annotations

from xml.etree import ElementTree

import freebody as fb
from freebody.gallery import entries
from freebody.symbolic.printing.latex import label_latex
from freebody.typesetting.html import Glyphs, block


def test_a_glyph_stands_in_the_table_once() -> None:
    glyphs = Glyphs()
    for _ in range(3):
        shown = glyphs.line("x x x")
    assert shown.count("<use") == 3
    assert glyphs.svg().count("<path") == 1
    assert Glyphs().svg() == ""


def test_what_is_copied_is_the_latex() -> None:
    s = fb.System("cart")
    m, k = s.parameters(m=1, k=1)
    block_ = s.body("block", fb.particle(m))
    s.spring("spring", s.slider("guide", s.ground, block_, axis="x", coordinate="x"), stiffness=k)
    e = fb.equations(s)
    page = ElementTree.fromstring(e.html())
    (formula,) = (part for part in page.iter("span") if part.get("class") == "formula")
    assert formula.get("data-tex") == e.latex().split("\n")[1].replace("&", "") == r"m \ddot{x} + k x = 0"
    assert formula.get("aria-label") == "m ẍ + k x = 0"


def test_text_in_a_formula_is_escaped() -> None:
    page = ElementTree.fromstring(block(r"\text{<script>&\"}"))
    assert not list(page.iter("script"))


def test_a_wide_fraction_has_a_form_for_narrow_columns() -> None:
    tex = r"x = \frac{" + " + ".join(rf"a_{k} \ddot{{x}}_{k}" for k in range(9)) + "}{M + m}"
    shown = block(tex)
    assert shown.count('class="wide-only"') == shown.count('class="narrow-only"') == 1
    assert 'narrow-only"' not in block(r"x = \frac{a}{b}").replace("</style>", "")


def test_every_name_of_the_gallery_is_a_symbol() -> None:
    """No underscore and no prime is left of a name."""
    glyphs = Glyphs()
    for entry in entries().values():
        s = entry.build()
        model = fb.assemble(s)
        names = [parameter.name for parameter in model.parameters]
        names += [name + dots for name in (*model.coordinate_names, *model.speed_names) for dots in ("", "'")]
        for name in names:
            tex = label_latex(name)
            assert tex is not None, name
            page = ElementTree.fromstring(glyphs.line(tex))
            assert list(page.iter("use")) and "'" not in page.get("aria-label", ""), name
