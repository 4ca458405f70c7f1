"""Contact modes of the bodies of a free-body diagram in words: stick, slip or open."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ...dynamics.conditions.contact import friction_coefficient, given_normal_force
from ...model.contact import Contact
from ...symbolic.derivation.contact_modes import modes_of
from ...symbolic.equations import Equations
from ...symbolic.printing.display import latex
from ...symbolic.printing.latex import latex_name, latex_number
from ..machine.configuration import Configuration

MOST_NAMES = 4
"""Most contacts that a line names."""


def contact_states(e: Equations, now: Configuration, bodies: Sequence[str]) -> list[str]:
    """A line of text for each mode of the contacts of these bodies, with the law of friction that holds in it."""
    groups: dict[tuple[str, str], list[Contact]] = {}
    for contact in e.model.contacts:
        if not {contact.feature.body.name, contact.surface.body.name} & set(bodies):
            continue
        groups.setdefault(_state(e, contact), []).append(contact)
    lines = []
    for (word, law), contacts in groups.items():
        names = [contact.name for contact in contacts]
        text = f"contact{'s' * (len(names) > 1)} {_listed(names)}: {word}"
        if law and len(names) == 1 and now.moving and word == "stick":
            text += f", {_margin(e, now, contacts[0])}"
        elif law:
            text += f", ${_named(law, contacts)}$"
        lines.append(_plain(text))
    undetermined = [
        c.name for group in groups.values() for c in group if now.open & {c.normal_name, *c.tangent_names}
    ]
    if undetermined:
        lines.append(_plain(f"no motion determines the forces of {_listed(undetermined)}: least in norm"))
    return lines


def _listed(names: Sequence[str]) -> str:
    """Return the first names, and how many more there are."""
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return ", ".join(names[:MOST_NAMES]) + more


def _plain(text: str) -> str:
    """Replace the underscores of names, in front of the formula, by spaces."""
    words, dollar, formula = text.partition("$")
    return words.replace("_", " ") + dollar + formula


def _state(e: Equations, contact: Contact) -> tuple[str, str]:
    """Mode of a contact in words, and the law of its friction with N and T for the forces."""
    mode, N = modes_of(e.model)[contact.name], "" if _of_joint(contact) else " N"
    if contact.adhesion != 0:
        N = rf" (N + {latex(e.state(contact.adhesion), e.ring)})"
    if mode == "open":
        return "open", ""
    if contact.frictionless:
        return "closed" if contact.law is not None else "closed, smooth", ""
    if contact.friction_across is not None:
        return _ellipse(e, contact, mode, N)
    if mode == "stick":
        return "stick", rf"|T| \leq {latex(e.state(contact.static_friction), e.ring)}{N}"
    touching = e.model.constraints.get(contact.name) or e.model.loads.get(contact.friction_name)
    direction = getattr(touching, "direction", None) or ()
    mu = friction_coefficient(e.model, e.state, contact, direction)
    return "slip", rf"|T| = {latex(mu, e.ring)}{N}"


def _ellipse(e: Equations, contact: Contact, mode: str, N: str) -> tuple[str, str]:
    """Mode of a contact with two coefficients of friction, and its law."""
    along, across = contact.coefficients
    if mode == "stick":
        along, across = contact.static_friction, contact.stretch * contact.static_friction
    first, second = (latex(e.state(mu), e.ring) for mu in (along, across))
    sign = r"\leq" if mode == "stick" else "="
    return mode, rf"\sqrt{{(T_1/{first})^2 + (T_2/{second})^2}} {sign}{N}"


def _of_joint(contact: Contact) -> bool:
    """Return True for dry friction of a joint without regard to its load, which has no normal force."""
    return contact.held and not contact.compliant and not contact.loaded and not contact.presser


def _named(law: str, contacts: Sequence[Contact]) -> str:
    """The law with the names of the forces, if it is for one contact."""
    if len(contacts) > 1:
        return law
    (contact,) = contacts
    tangent, normal = latex_name(contact.friction_name), latex_name(contact.normal_name)
    if contact.friction_across is not None:
        for plain, name in zip(("T_1", "T_2"), contact.tangent_names, strict=True):
            law = law.replace(plain, latex_name(name))
    return law.replace("|T|", f"|{tangent}|").replace("(N +", f"({normal} +").replace(" N", f" {normal}")


def _margin(e: Equations, now: Configuration, contact: Contact) -> str:
    """|T| and the greatest friction, with their values at the time of the diagram."""
    T = [now.lookup[sympy.Symbol(name, real=True)] for name in contact.tangent_names]
    if contact.held and not contact.bounded:
        law: Any = contact.law
        pressed = law.contact if contact.presser else contact
        N = float(given_normal_force(e.model, now.state, pressed))
    else:
        N = now.lookup[sympy.Symbol(contact.normal_name, real=True)]
    if contact.friction_across is not None:
        return _named(_state(e, contact)[1], [contact]).join("$$")
    size = sum(x * x for x in T) ** 0.5
    most = float(now.state(contact.static_friction)) * (N + float(now.state(contact.adhesion)))
    mu = latex(e.state(contact.static_friction), e.ring)
    tangent = latex_name(contact.friction_name)
    normal = "" if _of_joint(contact) else latex_name(contact.normal_name)
    if contact.adhesion != 0:
        normal = f"({normal} + {latex(e.state(contact.adhesion), e.ring)})"
    return rf"$|{tangent}| = {latex_number(size, 4)} \leq {latex_number(most, 4)} = {mu} {normal}$"
