"""Analysis of a machine: equations, conserved quantities, steady motions, and small motions about a steady motion.

If a question has no answer for a machine, a sentence says why, and the analysis continues with the next question.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from .equations import integrals, motion
from .inquiry import Inquiry
from .linear_model import SmallMotions
from .section import Section, plain_latex
from .steady_motions import SteadyMotionsFound


@dataclass
class Analysis:
    """The sections of an analysis, made by :func:`analysis`."""

    name: str
    values: dict[str, float | None]
    sections: dict[str, Section]

    def text(self) -> str:
        """Return everything as plain text."""
        head = f"Analysis of '{self.name}'"
        blocks = [f"{head}\n{'=' * len(head)}"]
        for section in self.sections.values():
            blocks.append("\n".join([section.title, "-" * len(section.title), *section.notes, *section.text]))
        return "\n\n".join(blocks) + "\n"

    def latex(self) -> str:
        """Return everything as a LaTeX document."""
        lines = [
            r"\documentclass{article}",
            r"\usepackage[landscape,margin=15mm]{geometry}",
            r"\usepackage{amsmath}",
            r"\begin{document}",
            rf"\section*{{Analysis of {plain_latex(self.name)}}}",
        ]
        for section in self.sections.values():
            lines.append(rf"\subsection*{{{plain_latex(section.title)}}}")
            lines += [plain_latex(note) + "\n" for note in section.notes]
            lines += [f"\\[\n{formula}\n\\]" for formula in section.latex]
        return "\n".join([*lines, r"\end{document}"]) + "\n"

    def data(self) -> dict[str, Any]:
        """Return everything as data that JSON can hold."""
        report: dict[str, Any] = {"model": self.name, "values": self.values}
        for key, section in self.sections.items():
            report[key] = section.data
        report["notes"] = {key: section.notes for key, section in self.sections.items() if section.notes}
        return report


def analysis(
    system: Any,
    values: Mapping[str, float] | None = None,
    about: Mapping[str, float] | None = None,
    start: Mapping[str, Any] | None = None,
    near: Mapping[str, Any] | None = None,
    patience: float | None = None,
) -> Analysis:
    """Analyse a system: equations of motion, conserved quantities, steady motions, linear model and modes.

    Parameters
    ----------
    system : System or Model
    values : mapping, optional
        Values of parameters by name, in place of their defaults.
    about : mapping, optional
        Coordinates and speeds of the operating point by name, or some unknowns of a steady motion; by default the first
        stable steady motion.
    start : mapping, optional
        Values by name, numbers or expressions, for unknowns that the steady motions leave free.
    near : mapping, optional
        For machines with constraints: an approximate closed configuration.
    patience : float, optional
        Longest time for symbolic answers [s]; beyond it, answers are numbers only.

    Returns
    -------
    Analysis

    Raises
    ------
    ModelError
        If the system cannot be assembled, a name in ``about`` is unknown, or a parameter cannot have its value.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L, g = s.parameters(m=1, L=1, g=9)
    >>> s.gravity = (0, -g, 0)
    >>> bob = s.body("bob", fb.particle(m))
    >>> pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), coordinate="theta")
    >>> result = analysis(s).data()
    >>> result["linear_model"]["about"], result["modes"][0]["frequency"]
    ({'theta': 0.0, "theta'": 0.0}, 3.0)
    """
    asked = Inquiry(
        system, dict(values or {}), dict(about or {}), dict(start or {}), dict(near or {}), patience
    )
    model = asked.model
    sections = {"equations": asked.in_symbols("Equations of motion", lambda: motion(asked))}
    if model.n_u:
        steady = SteadyMotionsFound(asked)
        sections["integrals"] = asked.in_symbols("Conserved quantities", lambda: integrals(asked))
        sections["steady_motions"] = asked.in_symbols("Steady motions", steady.section)
        sections["linear_model"], sections["modes"] = SmallMotions(asked, steady).sections()
    shown = {
        p.name: asked.values.get(p.name, asked.overrides.get(p.name, p.default)) for p in model.parameters
    }
    return Analysis(model.name, shown, sections)
