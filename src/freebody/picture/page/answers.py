"""Answers on a page: the question, the number with its unit, and the formula for it."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from ...scalar.digits import significant
from .symbols import Symbols


def answers_table(answers: Mapping[str, Any], symbols: Symbols) -> str:
    """Return answers as an HTML table, or the empty text if there are none.

    An answer is a value, a pair (value, unit), or an object with ``question``, ``value``, ``unit``, ``formula``
    and ``latex``, such as an answer of the gallery.

    >>> "<td>period</td>" in answers_table({"period": (2.5, "s")}, Symbols())
    True
    """
    if not answers:
        return ""
    questions = any(hasattr(answer, "question") for answer in answers.values())
    head = ("Answer", "Question", "Value", "Unit") if questions else ("Answer", "Value", "Unit")
    rows = []
    for name, answer in answers.items():
        question, value, unit, formula = _parts(answer)
        code = [str(answer.formula)] if formula else []
        # a live page writes other numbers here; words hold whatever the numbers are
        mark = "" if isinstance(value, str) else f' data-answer="{escape(str(name))}"'
        if isinstance(value, str) and formula:
            shown, formula = symbols.formula(formula, code), ""
        else:
            shown = symbols.words(value) if isinstance(value, str) else escape(significant(value, 8))
        number = f'<td class="number"{mark}>{shown}</td>'
        middle = f"<td>{symbols.words(question)}</td>" if questions else ""
        rows.append(f"<tr><td>{symbols.name(str(name))}</td>{middle}{number}<td>{escape(unit)}</td></tr>")
        if formula:
            rows.append(
                f'<tr class="set"><td></td><td colspan="{len(head) - 1}">{symbols.formula(formula, code)}</td></tr>'
            )
    top = "".join(f"<th>{name}</th>" for name in head)
    body = "".join(rows)
    table = f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"
    return f'<h2>Answers</h2>\n<div class="wide" tabindex="0">{table}</div>'


def _parts(answer: Any) -> tuple[str, Any, str, str]:
    """(question, value, unit, formula as LaTeX) of an answer."""
    if hasattr(answer, "question"):
        formula = "" if answer.formula is None else answer.latex
        unit = "" if answer.unit == "1" else answer.unit
        return answer.question, answer.value, unit, formula
    if isinstance(answer, tuple) and len(answer) == 2 and isinstance(answer[1], str):
        return "", answer[0], answer[1], ""
    return "", answer, "", ""
