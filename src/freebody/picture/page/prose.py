"""Sentences between the formulas of a page, as in a textbook: what acts on a body, where an equation comes from.

The equation of a coordinate that is the whole displacement of one joint is the balance of forces along the axis of the
joint, or of moments about it, of all bodies beyond the joint: forces between them cancel, and the joint transmits none
in this direction.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ...dynamics.conditions.constraints import rows
from ...model.model import Model
from ...symbolic.equations import Equations
from ...symbolic.free_body.planar import Plane, plane_of
from ...symbolic.free_body.reaction import unknowns

Names = Callable[[str], str]
"""A name as HTML."""


def laws(e: Equations, formula: Names) -> str:
    """Return the sentence before the equations of the bodies; ``formula`` sets LaTeX.

    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> pin = s.hinge("pin", s.ground, s.body("bar", fb.slender_bar(1, 1)), coordinate="theta")
    >>> laws(fb.equations(s), str).partition(". ")[0]
    'The motion is planar'
    """
    planar = isinstance(plane_of(e), Plane)
    turning = r"I_{C} \alpha" if planar else r"\dot{H}_{C}"
    first = "The motion is planar. " if planar else ""
    return (
        f"{first}Of each body, the forces add up to {formula('m a_{C}')} and their "
        f"moments about its mass centre {formula('C')} to {formula(turning)}."
    )


def actions(e: Equations, body: str, earlier: Iterable[str], name: Names) -> str:
    """Return the sentences about what acts on a body, after those about the bodies ``earlier``.

    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> s.gravity = (0, -10, 0)
    >>> pin = s.hinge("pin", s.ground, s.body("bar", fb.slender_bar(1, 1)), coordinate="theta")
    >>> actions(fb.equations(s), "bar", [], str)
    'On bar act its weight and the reactions pin_x and pin_y of pin.'
    """
    plane = plane_of(e)
    zero = set(plane.zero) if isinstance(plane, Plane) else set()
    given: list[str] = []
    reactions: dict[str, list[str]] = {}
    others: dict[str, str] = {}
    for action in e.free_body(body).actions:
        if action.name in zero:
            continue
        if action.kind not in ("reaction", "friction"):
            given.append("its weight" if action.kind == "weight" else name(action.name))
            continue
        owner = _owner(action.by)
        reactions.setdefault(owner, []).append(name(action.name))
        others[owner] = action.by.rpartition(", ")[2] if ", " in action.by else ""
    parts = list(dict.fromkeys(given))
    parts += [
        f"the reaction{'s' if len(names) > 1 else ''} {listed(names)} of {name(owner)}"
        for owner, names in reactions.items()
    ]
    if not parts:
        return f"Nothing acts on {name(body)}."
    told = [owner for owner, other in others.items() if other in set(earlier)]
    again = ""
    if told:
        pairs = listed([f"{name(owner)} on {name(others[owner])}" for owner in told])
        again = f" Reactions of {pairs} are the opposite of these."
    return f"On {name(body)} act{'s' if len(parts) == 1 and not reactions else ''} {listed(parts)}.{again}"


def motion(e: Equations, name: Names) -> str:
    """Return the sentences before the equations of motion.

    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> pin = s.hinge("pin", s.ground, s.body("bar", fb.slender_bar(1, 1)), coordinate="theta")
    >>> motion(fb.equations(s), str)
    'The reactions of joints do not appear. The equation sums the moments on bar about the axis of pin.'
    """
    model = e.model
    parts = []
    if model.n_u > 1:
        parts.append(
            f"Each {'coordinate' if model.n_u == len(model.coordinate_names) else 'speed'} has an equation."
        )
    plane = plane_of(e)
    zero = set(plane.zero) if isinstance(plane, Plane) else set()
    if any(x.name not in zero for joint in model.joints for x in unknowns(model, e.state, joint)):
        parts.append("The reactions of joints do not appear.")
    parts += [sentence for k in range(model.n_u) if (sentence := _source(model, k, name))]
    owners = list(dict.fromkeys(row.owner for row in rows(model) if row.name in e.condition_names))
    if owners:
        said, verb = listed(map(name, owners)), "exerts" if len(owners) == 1 else "exert"
        parts.append(f"What {said} {verb} stays unknown in them; the conditions of {said} come last.")
    return " ".join(parts)


def _source(model: Model, k: int, name: Names) -> str:
    """Where the equation of a speed comes from; empty if its coordinate is not the displacement of one joint alone."""
    places = [(i, link) for i, link in enumerate(model.links) if any(j == k for j, _ in link.partials)]
    if len(places) != 1:
        return ""
    number, link = places[0]
    if link.partials != ((k, 1),) or not (link.turns_only or link.slides_only):
        return ""
    joint = next((joint for joint, place in model.joints.items() if number in place.links), None)
    if joint is None:
        return ""
    bodies = [body for body, place in model.bodies.items() if number in _chain(model, place.link)]
    symbol = name(model.speed_names[k].removesuffix("'"))
    axis = f"the {symbol} axis" if len(model.joints[joint].links) > 1 else "the axis"
    what, way = ("moments", "about") if link.turns_only else ("forces", "along")
    equation = f"That of {symbol}" if model.n_u > 1 else "The equation"
    return f"{equation} sums the {what} on {listed(map(name, bodies))} {way} {axis} of {name(joint)}."


def _chain(model: Model, link: int) -> list[int]:
    """Numbers of a link and of all links before it."""
    result = []
    while link >= 0:
        result.append(link)
        link = model.links[link].parent
    return result


def _owner(by: str) -> str:
    """Name of the joint or constraint in the text of what exerts an action, such as "joint 'pin', ground"."""
    parts = by.split("'")
    return parts[1] if len(parts) > 2 else by


def listed(names: Iterable[str]) -> str:
    """Return names with commas and an "and".

    >>> listed(["a", "b", "c"])
    'a, b and c'
    """
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last
