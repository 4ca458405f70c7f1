"""What a free-body diagram says in words of the contacts of its bodies: whether they stick, slip or are open."""

from __future__ import annotations

from collections.abc import Sequence

import sympy

from ...model.contact import Contact, Touching
from ...symbolic.equations import Equations
from ...symbolic.printing.display import latex
from ...symbolic.printing.latex import latex_name
from ..machine.configuration import Configuration

MOST_NAMES = 4
"""Contacts that one line names."""


def contact_states(e: Equations, now: Configuration, bodies: Sequence[str]) -> list[str]:
    """A line for each state in which contacts of these bodies are, with the law that friction keeps there."""
    groups: dict[tuple[str, str], list[Contact]] = {}
    for contact in e.model.contacts:
        if not {contact.feature.body.name, contact.surface.body.name} & set(bodies):
            continue
        groups.setdefault(_state(e, contact), []).append(contact)
    lines = []
    for (word, law), contacts in groups.items():
        names = [one.name for one in contacts]
        shown = ", ".join(names[:MOST_NAMES]) + (
            f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
        )
        text = f"contact{'s' * (len(names) > 1)} {shown}: {word}"
        if law and len(names) == 1 and now.moving and word == "stick":
            text += f", {_margin(e, now, contacts[0])}"
        elif law:
            text += f", ${_named(law, contacts)}$"
        # a dollar sign would begin a formula
        lines.append(text.replace("_", " ") if "$" not in text else _plain(text))
    return lines


def _plain(text: str) -> str:
    """Underscores of names as spaces, those of the formula kept."""
    words, sign, formula = text.partition("$")
    return words.replace("_", " ") + sign + formula


def _state(e: Equations, contact: Contact) -> tuple[str, str]:
    """A word, and the law of its friction with N and T as they are called."""
    touching = e.model.constraints.get(contact.name)
    if not isinstance(touching, Touching):
        return "open", ""
    if contact.frictionless:
        return "closed, smooth", ""
    if touching.slips:
        return "slip", rf"|T| = {latex(e.state(contact.friction), e.ring)} N"
    return "stick", rf"|T| \leq {latex(e.state(contact.static_friction), e.ring)} N"


def _named(law: str, contacts: Sequence[Contact]) -> str:
    if len(contacts) > 1:
        return law
    (one,) = contacts
    tangent = one.tangent_names[0] if one.tangents == 1 else one.normal_name.replace("N", "T", 1)
    return law.replace("|T|", f"|{latex_name(tangent)}|").replace(" N", f" {latex_name(one.normal_name)}")


def _margin(e: Equations, now: Configuration, contact: Contact) -> str:
    """|T| beside what friction can hold, at this moment."""
    N, *T = (
        now.lookup[sympy.Symbol(name, real=True)] for name in (contact.normal_name, *contact.tangent_names)
    )
    held = sum(x * x for x in T) ** 0.5
    most = float(now.state(contact.static_friction)) * N
    tangent = contact.tangent_names[0] if contact.tangents == 1 else contact.normal_name.replace("N", "T", 1)
    mu = latex(e.state(contact.static_friction), e.ring)
    return rf"$|{latex_name(tangent)}| = {held:.4g} \leq {most:.4g} = {mu} {latex_name(contact.normal_name)}$"
