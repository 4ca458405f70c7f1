"""Answers on a page: what is asked, the number with its unit, and the formula that it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from ...scalar.digits import significant
from ...symbolic.printing.mathml import document
from ...symbolic.printing.show import mathml_of

LONGEST = 20_000
"""Characters of a formula in MathML that is shown; a longer one is left to ``freebody run``."""


def answers_table(answers: Mapping[str, Any]) -> str:
    """Answers as an HTML table; the empty text if there are none.

    An answer is a value, a pair (value, unit), or an object with ``question``, ``value``, ``unit`` and ``formula``, as
    those of the gallery are.

    >>> "<td>period</td>" in answers_table({"period": (2.5, "s")})
    True
    """
    if not answers:
        return ""
    asked = any(hasattr(given, "question") for given in answers.values())
    head = ("Answer", "Question", "Value", "Unit") if asked else ("Answer", "Value", "Unit")
    rows = []
    for name, given in answers.items():
        question, value, unit, formula = _parts(given)
        number = f'<td class="number">{escape(significant(value, 8))}</td>'
        middle = f"<td>{escape(question)}</td>" if asked else ""
        rows.append(f"<tr><td>{escape(str(name))}</td>{middle}{number}<td>{escape(unit)}</td></tr>")
        if formula:
            rows.append(f'<tr><td></td><td colspan="{len(head) - 1}">{formula}</td></tr>')
    top = "".join(f"<th>{name}</th>" for name in head)
    body = "".join(rows)
    table = f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"
    return f'<h2>Answers</h2>\n<div class="wide">{table}</div>'


def _parts(given: Any) -> tuple[str, Any, str, str]:
    """(question, value, unit, formula as MathML) of an answer."""
    if hasattr(given, "question"):
        of_motion = isinstance(given.value, str) and not given.unit
        formula = "" if given.formula is None or of_motion else document(mathml_of(given.formula))
        unit = "" if given.unit == "1" else given.unit
        return given.question, given.value, unit, formula if len(formula) <= LONGEST else ""
    if isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], str):
        return "", given[0], given[1], ""
    return "", given, "", ""
