"""Bodies of a model and their points, in questions to the equations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...describe.body import Body
from ...describe.description import names_of
from ...errors import ModelError
from ...model.model import Model


def own_body(model: Model, body: Any, what: str) -> Body:
    """Return ``body`` if it belongs to the system of the model.

    Raises
    ------
    ModelError
        No body, or a body of another system. ``what`` says in the message what it was given for.
    """
    if not isinstance(body, Body):
        raise ModelError(f"Expected a body for {what}, got {body!r}.")
    if names_of(body.system) is not model.names:
        raise ModelError(
            f"Body '{body.name}', given for {what}, belongs to the system '{body.system.name}', "
            f"not to '{model.name}'. Name a body of '{model.name}'."
        )
    return body


@dataclass(frozen=True)
class NamedBody:
    """A body of the model by its name, for an algorithm that takes points of bodies."""

    name: str
    is_ground: bool = False


@dataclass(frozen=True)
class PointOf:
    """A point of a body, with components that are scalars or expressions."""

    body: Body | NamedBody
    components: Any
