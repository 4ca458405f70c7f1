"""Formulas in one line of Unicode."""

from __future__ import annotations

import pytest

from freebody.typesetting.latex import parse
from freebody.typesetting.plain import plain


@pytest.mark.parametrize(
    ("tex", "text"),
    [
        (r"m \left(\ddot{\theta} \cos\theta - \dot{\theta}^{2}\right) = 0", "m (θ̈ cos θ − θ̇^2) = 0"),
        (r"\frac{3 g}{L}", "(3 g)/L"),
        (r"\sqrt{\frac{3 g}{L}}", "√((3 g)/L)"),
        (r"\sqrt[3]{x}", "∛x"),
        (r"-12.5 x", "−12.5 x"),
        (r"\dot{\psi}_{\mathrm{fast}}", "ψ̇_fast"),
        (r"\begin{bmatrix}0 \\ m g\end{bmatrix}", "[0; m g]"),
        (r"\text{if } R \ge 0", "if R ≥ 0"),
        (r"\left|x\right|", "|x|"),
        (r"f(x, y)", "f (x, y)"),
    ],
)
def test_plain(tex: str, text: str) -> None:
    assert plain(parse(tex)) == text
