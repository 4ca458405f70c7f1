"""Answers on a page: the question, the number with its unit, and the formula for it."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from ...scalar.digits import significant
from ...symbolic.printing.mathml import document

LONGEST = 20_000
"""Most characters of a formula in MathML; a longer one is not shown (``freebody run`` prints it)."""


def answers_table(answers: Mapping[str, Any]) -> str:
    """Return answers as an HTML table, or the empty text if there are none.

    An answer is a value, a pair (value, unit), or an object with ``question``, ``value``, ``unit``, ``formula``
    and ``mathml``, such as an answer of the gallery.

    >>> "<td>period</td>" in answers_table({"period": (2.5, "s")})
    True
    """
    if not answers:
        return ""
    questions = any(hasattr(answer, "question") for answer in answers.values())
    head = ("Answer", "Question", "Value", "Unit") if questions else ("Answer", "Value", "Unit")
    rows = []
    for name, answer in answers.items():
        question, value, unit, formula = _parts(answer)
        # a live page writes other numbers here; words hold whatever the numbers are
        mark = "" if isinstance(value, str) else f' data-answer="{escape(str(name))}"'
        number = f'<td class="number"{mark}>{escape(significant(value, 8))}</td>'
        middle = f"<td>{escape(question)}</td>" if questions else ""
        rows.append(f"<tr><td>{escape(str(name))}</td>{middle}{number}<td>{escape(unit)}</td></tr>")
        if formula:
            rows.append(f'<tr><td></td><td colspan="{len(head) - 1}">{formula}</td></tr>')
    top = "".join(f"<th>{name}</th>" for name in head)
    body = "".join(rows)
    table = f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"
    return f'<h2>Answers</h2>\n<div class="wide">{table}</div>'


def _parts(answer: Any) -> tuple[str, Any, str, str]:
    """(question, value, unit, formula as MathML) of an answer."""
    if hasattr(answer, "question"):
        is_text = isinstance(answer.value, str) and not answer.unit
        formula = "" if answer.formula is None or is_text else document(answer.mathml)
        unit = "" if answer.unit == "1" else answer.unit
        return answer.question, answer.value, unit, formula if len(formula) <= LONGEST else ""
    if isinstance(answer, tuple) and len(answer) == 2 and isinstance(answer[1], str):
        return "", answer[0], answer[1], ""
    return "", answer, "", ""
