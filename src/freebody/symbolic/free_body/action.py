"""One force or couple on a free body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ...scalar.algebra import ZERO, Vector, add, cross, subtract


@dataclass(frozen=True)
class Action:
    """One force or couple on the body.

    Attributes
    ----------
    name : str
    kind : "weight", "load", "spring", "damper", "motor", "reaction" or "friction"
    force : Vector
        Canonical polynomials [N], in ground axes.
    moment : Vector
        A couple, in addition to the moment of the force [N m].
    at : Vector
        Position of the point of application, in ground axes.
    by : str
        What exerts it: a joint, a contact, gravity; empty for a load.
    load : str
        Name of the load that it is part of; empty for all others.
    """

    name: str
    kind: str
    force: Vector
    moment: Vector
    at: Vector
    by: str
    load: str = ""

    def about(self, point: Vector) -> Vector:
        """Return the couple and the moment of the force about a point."""
        return add(self.moment, cross(subtract(self.at, point), self.force))


def action_lines(
    actions: Sequence[Action], of_force: Callable[[Vector], str], of_couple: Callable[[Vector], str]
) -> list[str]:
    """Return a line of text for each action, with the components that these functions write."""
    width, lines = max([len(a.name) for a in actions], default=0), []
    for a in actions:
        parts = [f"force {of_force(a.force)}"] if a.force != ZERO else []
        parts += [f"couple {of_couple(a.moment)}"] if a.moment != ZERO else []
        by = f"   [{a.by}]" if a.by else ""
        lines.append(f"  {a.name:<{width}}  {', '.join(parts)}{by}")
    return lines


TITLES = tuple(f"{kind} {c}" for kind in ("force", "moment") for c in "xyz")
"""Titles of the six equations of a free body, in their order."""
