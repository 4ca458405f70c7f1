"""The equations of motion and the conserved quantities of a machine, as sections of its analysis."""

from __future__ import annotations

from .inquiry import Inquiry
from .section import Section


def motion(asked: Inquiry) -> Section:
    """Return the section of the equations of motion."""
    section = Section("Equations of motion")
    if not asked.model.n_u:
        section.notes.append(f"'{asked.model.name}' has no degree of freedom: there is nothing to solve for.")
        section.data = []
        return section
    section.data = asked.e.lines()
    section.text, section.latex = ["\n".join(section.data)], [asked.e.latex()]
    section.notes += asked.e.heading
    return section


def integrals(asked: Inquiry) -> Section:
    """Return the section of the conserved quantities."""
    section = Section("Conserved quantities", data=[])
    integrals = asked.e.integrals
    if not integrals:
        section.notes.append("None are known: no quantity that was tried keeps its value along every motion.")
        return section
    for integral in integrals:
        proof = str(integral.proof)
        section.text.append(f"{integral.text()}\n    {proof}")
        section.data.append(
            {
                "name": integral.name,
                "also": list(integral.also),
                "expression": asked.show(integral.expression),
                "latex": integral.latex(),
                "proof": proof,
            }
        )
    section.latex.append(integrals.latex())
    return section
