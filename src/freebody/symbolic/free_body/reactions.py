"""Reactions of all joints and closed contacts of a machine, as functions of the motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

from ...dynamics.conditions.constrained import constrained_loading
from ...dynamics.conditions.constraints import rows
from ...dynamics.newton_euler import reactions
from ...errors import ModelError, nearest
from ...model.closure import Closure
from ...model.contact_modes import Touching
from ...scalar.algebra import ZERO, Scalar, Vector, add, scale
from ..derivation.derivation import Derivation
from ..derivation.questions import named
from ..printing.lines import Shown
from .contact_forces import contact_reaction
from .gears import undetermined_by_couplings
from .reaction import Reaction, unknowns


class Reactions(Shown, Mapping[str, Reaction]):
    """Reactions by the name of the joint or contact; each is converted to SymPy when it is looked up."""

    def __init__(self, e: Derivation) -> None:
        self._e = e
        self._looked_up: dict[str, Reaction] = {}

    @cached_property
    @named("the reactions")
    def canonical(self) -> dict[str, tuple[Vector, Vector]]:
        """(force, moment) of every joint on its child in ground axes, canonical."""
        e = self._e
        loads = None
        if e.model.constraints:
            loads = constrained_loading(e.model, e.state, e.canonical_multipliers, e.udot)
        return reactions(e.model, e.state, e.udot, natural=True, loads=loads)

    def canonical_components(self, joint: str) -> dict[Any, Scalar]:
        """Value of each unknown of a joint's reaction by its symbol, canonical."""
        force, moment = self.canonical[joint]
        result = {}
        for c in unknowns(self._e.model, self._e.state, joint):
            # the directions of the components are orthogonal unit vectors, so the value is a projection
            direction, vector = (c.force, force) if c.force != ZERO else (c.moment, moment)
            result[c.symbol] = sum((a * b for a, b in zip(direction, vector, strict=True)), start=0)
        return result

    @cached_property
    @named("the reactions")
    def _closures(self) -> dict[str, Reaction]:
        return closure_reactions(self._e)

    def __getitem__(self, name: str) -> Reaction:
        e = self._e
        if name not in self:
            raise ModelError(f"Unknown joint '{name}'; {nearest(str(name), list(self))}")
        if name in self._closures:
            return self._closures[name]
        if name not in self._looked_up:
            joint, values = e.model.joints[name], self.canonical_components(name)
            parts = {str(symbol): e.displayed(value) for symbol, value in values.items()}
            self._looked_up[name] = Reaction.of(
                e,
                name,
                self.canonical[name],
                joint.child,
                joint.to,
                parts,
                undetermined_by_couplings(e, name),
            )
        return self._looked_up[name]

    def __contains__(self, name: object) -> bool:
        return name in self._e.model.joints or name in self._closures

    def __iter__(self) -> Iterator[str]:
        return iter((*self._e.model.joints, *self._closures))

    def __len__(self) -> int:
        return len(self._e.model.joints) + len(self._closures)

    def _parts(self) -> list[Reaction]:
        return [self[name] for name in self]

    def __repr__(self) -> str:
        return f"Reactions of {', '.join(self)}"


def closure_reactions(e: Derivation) -> dict[str, Reaction]:
    """Reactions of loop-closing joints and closed contacts, whose components are the multipliers themselves."""
    result = {}
    for name, joint in e.model.constraints.items():
        if isinstance(joint, Touching):
            result[name] = contact_reaction(e, joint)
        if not isinstance(joint, Closure):
            continue
        force, moment, parts = ZERO, ZERO, {}
        for row, multiplier, pair in zip(
            rows(e.model), e.canonical_multipliers, e.constraint_wrenches, strict=True
        ):
            if row.owner != name:
                continue
            _, f, m = pair[0]  # on the child
            force, moment = add(force, scale(multiplier, f)), add(moment, scale(multiplier, m))
            parts[row.name] = e.displayed(multiplier)
        result[name] = Reaction.of(e, name, (force, moment), joint.child.name, joint.to, parts)
    return result
