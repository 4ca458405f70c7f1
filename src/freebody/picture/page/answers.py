"""Answers on a page: the question, the number with its unit, and the formula for it."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from ...scalar.digits import significant
from ...symbolic.printing.latex import label_latex
from .symbols import Symbols, in_powers


def answers_table(answers: Mapping[str, Any], symbols: Symbols) -> str:
    """Return answers as an HTML table, or the empty text if there are none.

    An answer is a value, a pair (value, unit), or an object with ``question``, ``value``, ``unit``, ``formula``
    and ``latex``, such as an answer of the gallery; below them stand the meanings of the abbreviations in formulas.

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
        code = [answer.text if answer.formula is None else str(answer.formula)] if formula else []
        # a live page writes other numbers here; words hold whatever the numbers are
        mark = "" if isinstance(value, str) else f' data-answer="{escape(str(name))}"'
        if isinstance(value, str) and formula:
            shown, formula = symbols.formula(formula, code), ""
        elif isinstance(value, str):
            shown = f'<span class="words">{symbols.words(value)}</span>'
        else:
            shown = _number(value)
        number = f'<td class="number"{mark}>{shown}</td>'
        middle = f'<td class="asked">{symbols.words(question)}</td>' if questions else ""
        last = f'<td class="unit">{escape(unit)}</td>'
        rows.append(f"<tr><td>{symbols.name(str(name))}</td>{middle}{number}{last}</tr>")
        if formula:
            rows.append(
                f'<tr class="set"><td></td><td colspan="{len(head) - 1}">{symbols.formula(formula, code)}</td></tr>'
            )
    meant = {
        name: x
        for answer in answers.values()
        for name, x in getattr(answer, "meanings", {}).items()
        if name not in answers
    }
    if meant:
        lines = (symbols.formula(f"{label_latex(name)} = {x.latex}", [x.text]) for name, x in meant.items())
        rows.append(f'<tr class="set"><td></td><td colspan="{len(head) - 1}">where{"".join(lines)}</td></tr>')
    top = "".join(f"<th>{name}</th>" for name in head)
    body = "".join(rows)
    table = f'<table class="answers"><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>'
    return f'<h2>Answers</h2>\n<div class="wide" tabindex="0">{table}</div>'


def _number(value: Any) -> str:
    """Return a number, or numbers in a row, as HTML; rows of numbers as a matrix.

    >>> _number((1.5, -2))
    '1.5, −2'
    >>> _number(((1, 2), (3, 4))).count("<span>")
    4
    """
    if not (
        isinstance(value, tuple | list) and value and all(isinstance(row, tuple | list) for row in value)
    ):
        text = in_powers(significant(value, 8))
        return escape(text if isinstance(value, str) else text.replace("-", "\N{MINUS SIGN}"))
    cells = "".join(f"<span>{_number(x)}</span>" for row in value for x in row)
    columns = f"grid-template-columns: repeat({len(value[0])}, auto)"
    return f'<span class="matrix" style="{columns}">{cells}</span>'


def _parts(answer: Any) -> tuple[str, Any, str, str]:
    """(question, value, unit, formula as LaTeX) of an answer."""
    if hasattr(answer, "question"):
        unit = "" if answer.unit == "1" else answer.unit
        return answer.question, answer.value, unit, answer.latex
    if isinstance(answer, tuple) and len(answer) == 2 and isinstance(answer[1], str):
        return "", answer[0], answer[1], ""
    return "", answer, "", ""
