"""One force or couple on a free body."""

from __future__ import annotations

from dataclasses import dataclass

from ...scalar.algebra import Vector


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


TITLES = tuple(f"{kind} {c}" for kind in ("force", "moment") for c in "xyz")
"""Titles of the six equations of a free body, in their order."""
