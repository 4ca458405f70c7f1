"""Couplings of which only the ratio is known: what keeps it also loads bearings, in a way that was not described.

A gear without a pitch point, and a linear condition on the displacements of several joints (`s.constrain`), have a
multiplier that is a moment or a force along these joints. Where teeth, belts, levers or fluid act between the bodies is
not known, so the sum of joint and coupling is determined in each joint between them, and their parts are not.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import sympy
from sympy.core.function import AppliedUndef

from ...describe.constraints.constraint import Condition, Gear
from ...model.model import Model
from ..coordinates import forces_on_free_displacements
from ..state import State
from .constraints import rows
from .dependence import path_between
from .linearized import linearized


@dataclass(frozen=True)
class Coupling:
    """A coupling by its ratio: the joints that it may load, what it is in words, and why no more is known."""

    joints: tuple[str, ...]
    words: str
    reason: str


def couplings(model: Model, state: State) -> tuple[Coupling, ...]:
    """Return the couplings of a model of which only the ratio is known."""
    return tuple(_couplings(model, state))


def _couplings(model: Model, state: State) -> Iterator[Coupling]:
    for i, row in enumerate(rows(model)):
        owner = model.constraints[row.owner]
        if isinstance(owner, Gear) and isinstance(owner.mesh, str):
            ends = (owner.first.name, owner.second.name)
            yield Coupling(_between(model, ends), f"the teeth of gear '{owner.name}'", owner.mesh)
        elif isinstance(owner, Condition) and _fixes_ratio(owner):
            joints = _coupled(model, state, i)
            if len(joints) > 1:
                words = f"the coupling by constraint '{owner.name}'"
                yield Coupling(_between(model, joints), words, "no point where it acts was described")


def _fixes_ratio(condition: Condition) -> bool:
    """True if the condition is linear in the coordinates, with constant factors."""
    expression = sympy.sympify(condition.expression)
    atoms = expression.atoms(AppliedUndef)
    return not any(expression.diff(atom).has(AppliedUndef) for atom in atoms)


def _coupled(model: Model, state: State, row: int) -> list[str]:
    """Return the joints along which the multiplier of a condition acts."""
    total: dict[int, object] = {}
    for speed, entry in enumerate(linearized(model, state).matrix[row]):
        if entry != 0:
            for link, force in forces_on_free_displacements(model, state, speed, entry).items():
                total[link] = total.get(link, 0) + force
    return [name for name, joint in model.joints.items() if any(total.get(i, 0) != 0 for i in joint.links)]


def _between(model: Model, joints: Iterable[str]) -> tuple[str, ...]:
    """Return the joints of the tree between the bodies that some joints move; all of them may be loaded."""
    first, *others = (model.joints[name].links[-1] for name in joints)
    links = {first, *others}
    for j in others:
        links.update(path_between(model, first, j)[0])
    return tuple(name for name, joint in model.joints.items() if joint.links[-1] in links)
