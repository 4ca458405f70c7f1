"""Expressions of quantities of contacts, such as ``floor.normal - 50``, which events watch."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

import sympy

from ...errors import ExpressionError, SimulationError, nearest
from ...model import Model
from ...model.family import contact_named
from ...scalar.expression import exact
from ...scalar.parser import parse
from ..kernels.contact_quantities import NAMES, OfContacts
from .outputs import force_named, quantity_of
from .phases import Phases

SAME = 1e-12
"""Time within which an event belongs to both phases that meet there [s]."""
_NAME = re.compile(r"(?<![\w.])([^\W\d]\w*(?:\[[^\[\]]*\]\w*)?)(?:\.([^\W\d]\w*))?(?:\.(\d+))?")
_DOTTED = re.compile(r"(?<![\w.])[^\W\d]\w*(?:\[[^\[\]]*\]\w*)?(?:\s*\.\s*[^\W\d]\w*)+")


def of_contacts(model: Model, value: Any, what: str) -> OfContacts | None:
    """Return an expression of quantities of contacts; None for one without.

    Raises
    ------
    SimulationError
        Quantities that no event can watch.
    """
    if not isinstance(value, str) or not (model.contacts or model.families or model.unrolled):
        return None
    symbols: dict[tuple[tuple[str, str, int], ...], Any] = {}

    def replaced(match: re.Match[str]) -> str:
        quantity = _quantity(model, match, what)
        if quantity is None:
            return match[0]
        symbol = sympy.Symbol(f"contact_{len(symbols) + 1}_", real=True)
        return str(symbols.setdefault(quantity, symbol).name)

    text = _NAME.sub(replaced, value)
    if not symbols:
        return None
    if re.search(r"contact_\d+_\s*\.", text):
        raise SimulationError(f"Expected a component by its number in {what}, such as '.1', got '{value}'.")
    names = model.names
    try:
        expression = exact(parse(text, {**names.atoms, **{x.name: x for x in symbols.values()}}))
    except ExpressionError as error:
        said = re.sub(r"(, )?contact_\d+_", "", str(error).splitlines()[0])
        raise ExpressionError(f"In {what}: {said}") from None
    return OfContacts(value, expression, {symbol: quantity for quantity, symbol in symbols.items()})


def _quantity(model: Model, match: re.Match[str], what: str) -> tuple[tuple[str, str, int], ...] | None:
    """Return the terms of the quantity of a contact that a part of a text names; None for other names."""
    name, kind, number = match.groups()
    if kind is None:
        force = force_named(model, name)
        return None if force is None else (force,)
    found = contact_named(model, name)
    if found is None:
        return None
    if kind == "mode":
        raise SimulationError(
            f"Expected a number in {what}, got the mode of contact '{name}'. Changes of modes are events of "
            "themselves, in motion.events."
        )
    if kind not in NAMES:
        raise SimulationError(
            f"Unknown quantity '{kind}' of contact '{name}' in {what}; {nearest(kind, NAMES)}"
        )
    count = found.tangents if kind in ("tangential", "slip") else 1
    component = None if number is None else int(number) - 1
    if component is None and count > 1:
        raise SimulationError(
            f"Expected one component in {what}, but '{match[0]}' is a vector in space: name '{match[0]}.1'."
        )
    if count == 0 or (component is not None and not (count > 1 and 0 <= component < count)):
        last = f"a component from 1 to {count}" if count > 1 else f"'{name}.{kind}' without a component"
        if count == 0:
            last = "a contact with friction"
        raise SimulationError(f"Expected {last} in {what}, got '{match[0]}'.")
    if found.friction_across is not None and kind in ("tangential", "slip", "margin"):
        raise SimulationError(
            f"Expected a contact with one coefficient of friction for '{match[0]}' in {what}: friction with two is an "
            "output, motion.contacts, but not watched. Watch its normal force, gap or approach."
        )
    own = [contact.name for contact in model.contacts]
    points = [c.name for c in model.contacts if c.name.startswith(f"{found.name}_") and not c.presser]
    places = {own[k] for pair in model.patches for k in pair.places}
    if kind != "normal" and (found.name in places or (found.name not in own and points)):
        cure = "its sum over these points" if places else f"or one point, such as '{points[0]}.{kind}'"
        raise SimulationError(
            f"Expected the normal force of '{name}' in {what}, got '{kind}': solids touch at several points, which "
            f"change. Watch '{name}.normal', {cure}; the others are outputs, motion.contacts."
        )
    if found.name not in own and points:
        return tuple((one, "normal", 0) for one in points)
    return ((found.name, kind, component or 0),)


def refuse_outputs(model: Model, value: Any, what: str, known: str) -> None:
    """Raise if a text names an output, such as the reaction of a joint, where only ``known`` names are.

    Raises
    ------
    SimulationError
        A name with a dot.
    """
    found = _DOTTED.search(value) if isinstance(value, str) else None
    if found is None:
        return
    whole = re.sub(r"\s", "", found[0])
    if whole != found[0]:
        raise SimulationError(f"Expected names without blanks in {what}, got '{found[0]}'. Write '{whole}'.")
    of = "an output of the motion" if quantity_of(model, whole, what) else "no name of this machine"
    raise SimulationError(
        f"Expected an expression of {known} for {what}, got '{whole}', which is {of}. Write it in these."
    )


def refuse_of_contacts(expressions: Iterable[Any]) -> None:
    """Raise if an expression takes quantities of contacts, in a motion that a page computes."""
    for x in expressions:
        if isinstance(x, OfContacts):
            raise SimulationError(
                f"Expected events of coordinates, speeds and the time, which a page watches, got '{x}', a quantity of "
                "a contact. A motion of fb.simulate watches it; in the page it is a chart: leave the event out, or "
                "live=True."
            )


def note_of(model: Model, watched: OfContacts | None, path: Any, time: float) -> str:
    """Return what is to be said of an event of forces that the motion does not determine then; else an empty text."""
    if watched is None or not isinstance(path, Phases):
        return ""
    first, at = {}, 0
    for contact in model.contacts:
        first[contact.name], at = at, at + 1 + contact.tangents
    rows = {
        first[name] + (1 + j if kind == "tangential" else 0)
        for terms in watched.quantities.values()
        for name, kind, j in terms
        if kind in ("normal", "tangential", "margin")
    }
    before, after = path.places([time - SAME, time + SAME])
    near = [segment.loose for segment in path.segments[before : after + 1] if segment.loose is not None]
    if any(loose[row] for loose in near for row in rows):
        return "equal compliance shares the forces of these contacts"
    return ""
