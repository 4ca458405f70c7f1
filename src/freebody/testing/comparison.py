"""Comparison of what must be equal, and the machine on which a kind of load or contact is tried."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, fields
from typing import Any

import numpy as np

from ..describe.contacts.gap import Gap
from ..describe.part import Part, sort_of
from ..describe.system import System
from ..errors import FormatError, ModelError
from ..model.assemble import assemble
from ..model.model import Model
from ..space.mass import MassProperties
from .machines import small_inertia

LARGEST_ERROR = 2**20 * np.finfo(float).eps
"""Greatest error of what must be equal, relative to the largest term: a million roundings."""


def same(kind: type, what: str, a: Any, b: Any, terms: Any) -> None:
    """Raise AssertionError if two lists of numbers differ by more than round-off of the largest term."""
    a, b = np.array(a, float), np.array(b, float)
    size = max((abs(float(x)) for x in (*a, *terms)), default=0)
    if a.shape != b.shape or not np.all(np.abs(a - b) <= LARGEST_ERROR * (1 + size)):
        raise AssertionError(
            f"{kind.__name__}: expected {what} to be equal, got {a.tolist()} and {b.tolist()}."
        )


def same_after_a_file(kind: type[Part], s: System, told: Callable[[Model], list[float]]) -> None:
    """Raise AssertionError if a system that is written and read again tells other numbers."""
    from ..formats.toml.read import case_from_text
    from ..formats.toml.write import toml_text

    try:
        again = case_from_text(toml_text(s)).system
    except FormatError as error:
        raise AssertionError(
            f"{kind.__name__}: its file cannot be written and read again: {error}"
        ) from error
    before, after = told(assemble(s)), told(assemble(again))
    same(kind, "what it does before and after a file", before, after, before)


def flat(found: Sequence[Any]) -> list[Any]:
    """All components and values of actions."""
    result: list[Any] = []
    for action in found:
        value = next(getattr(action, name) for name in ("force", "moment", "value") if hasattr(action, name))
        result += value if isinstance(value, tuple) else [value]
    return result


def machine_with(kind: type[Part], seed: int, data: Mapping[str, Any]) -> System:
    """A slider and a hinge, a ball or a free joint in a row, with a part x on them; missing data are drawn."""
    rng = np.random.default_rng(seed)
    s = System(f"machine of {kind.__name__}")
    s.parameters(g=9.8125)
    s.gravity = (0, "-g", 0)
    first = s.body("first", MassProperties(2, (0, 1, 0), small_inertia(rng)))
    last = s.body("last", MassProperties(1, (1, 0, 0), small_inertia(rng)))
    s.slider("rail", s.ground, first, at=(3, 2, 1), axis="x", coordinate="x")
    if (on := getattr(kind, "on_joint", "hinge")) != "hinge":
        data = {"joint": getattr(s, on)(on, first, last, at=(0, 2, 1)), **data}
    else:
        s.hinge("pin", first, last, at=(0, 2, 1), axis="z", coordinate="phi")
    s.add("x", kind(**drawn_data(kind, s, rng, data)))
    return s


def drawn_data(
    kind: type[Part], s: System, rng: np.random.Generator, data: Mapping[str, Any]
) -> dict[str, Any]:
    """Return data of a part: what is given, and for the other fields points, bodies, joints and random parameters."""
    bodies = list(reversed(s.bodies.values()))
    joints = list(s.joints.values())
    points = [bodies[0].point(1, 2, 0), bodies[-1].point(0, -1, 1), s.ground.point(-2, 5, 3)]

    def drawn(name: str) -> str:
        s.parameters(**{f"x_{name}": round(float(rng.uniform(1, 2)), 3)})
        return f"x_{name}"

    values = dict(data)
    for field in fields(kind):
        sort = sort_of(field)
        if not field.init or field.name == "name" or field.name in data:
            continue
        if sort == "Point":
            bodies_of_data = [value for value in values.values() if value in s.bodies.values()]
            values[field.name] = next(point for point in points if point.body not in bodies_of_data)
            points.remove(values[field.name])
        elif sort == "Body" and field.default is MISSING:
            values[field.name] = bodies.pop(0)
        elif sort == "Joint":
            values[field.name] = joints.pop(0)
        elif sort == "Coordinate":
            values[field.name] = "phi"
        elif sort in ("Expression", "Constant") and not (issubclass(kind, Gap) and field.kw_only):
            values[field.name] = drawn(field.name)
        elif sort == "Law":
            values[field.name] = f"{drawn('linear')}*stretch + {drawn('cubic')}*stretch^3"
        elif sort == "Vector":
            values[field.name] = tuple(drawn(f"{field.name}_{axis}") for axis in "xyz")
        elif field.default is MISSING and field.default_factory is MISSING:
            check = f"check_{kind.article}"
            raise ModelError(
                f"Expected data for '{field.name}' of {kind.__name__}: {check}({kind.__name__}, {field.name}=...)."
            )
    return values
