"""Steady motions in numbers at given values, and along a range of one parameter.

Roots of the conditions (:mod:`freebody.symbolic.steady.numeric`) at which the equations of motion hold are steady
motions; the others come from denominators that the conditions lack.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy

from ...errors import ModelError, nearest
from ...scalar.algebra import Expression, Scalar
from ...scalar.polynomial import Polynomial
from ...scalar.substitute import Substitution, arrays
from ..derivation.along_motion import numbers
from .conditions import Conditions
from .continuation import Branch, Special, check_span, follow
from .factors import live_factors, product
from .family import dimension
from .motion import SteadyState
from .numeric import NumericRoot, Underdetermined, roots
from .problem import Problem
from .stability import ProblemStability


@dataclass(frozen=True)
class SteadyStates:
    """Finds the steady motions of a problem in numbers; ``solve_for`` are unknowns that are no parameters."""

    problem: Problem
    stability: ProblemStability | Any
    solve_for: tuple[Any, ...]

    def at(self, values: Mapping[Any, Expression]) -> tuple[SteadyState, ...]:
        """Return those at some values; see :meth:`SteadyMotions.at`."""
        p = self.problem
        atoms, unknowns, known = self._numbers(values)
        moving = [*p.rates, *p.terms]
        try:
            roots_found = roots(p.ring, p.conditions, unknowns, atoms, moving)
        except Underdetermined:
            names = [p.name(a) for a in unknowns]
            raise ModelError(
                f"The {len(p.conditions)} condition(s) of steady motion do not determine {', '.join(names)}. Give "
                f"values of some of them: values={{'{names[-1]}': ...}}."
            ) from None
        roots_found = [root for root in roots_found if self._balanced(atoms, unknowns, root.values)]
        result = []
        # a coordinate that is known may pick one of a family
        placed = {a: x for a, x in known.items() if a in p.coordinates}
        remaining = {a: x for a, x in atoms.items() if a not in placed}
        whole = Conditions(p.ring, p.conditions, [*unknowns, *placed], remaining)
        fixed = np.array([a in moving for a in whole.unknowns], dtype=bool)
        for k, root in enumerate(roots_found):
            if placed:
                free = np.append(root.open, np.zeros(len(placed), dtype=bool))
                x = np.append(root.values, list(placed.values()))
                root = replace(root, family=dimension(whole, x, fixed | free))
            result.append(self._state(self._label(roots_found, k, unknowns), root, unknowns, atoms, known))
        return tuple(p.distinct(result, atoms))

    def _balanced(self, atoms: Mapping[Any, Any], unknowns: Sequence[Any], x: Scalar) -> bool:
        """Return True if the equations of motion hold: clearing |y| or 1/y from the conditions adds false roots.

        Where y is round-off, the slopes of 1/y or y/|y| are immense there and not beside it: the equations have no
        value in this state.
        """
        p = self.problem
        with np.errstate(all="ignore"):
            full = self._full({**atoms, **dict(zip(unknowns, x, strict=True))})
            exact = Conditions(p.ring, [E for E in p.exact if type(E) is Polynomial], unknowns, full)
            values = exact.values(x)
            missed = np.abs(values) / np.maximum(exact.size(x), 1 / 10**300)
            beside = x + np.maximum(1, np.abs(x)) / 10**9
            steep, calm = (np.abs(exact.jacobian(place)).max(initial=0) for place in (x, beside))
        # a law may have a value without a slope, as |y| at zero
        return not ((missed > 1 / 10**6).any() or steep > 10**6 * calm or np.isnan(values).any())

    def _label(self, roots: Sequence[Any], k: int, unknowns: Sequence[Any]) -> str:
        """Label of one of two roots of a rate: "fast" or "slow"; else ""."""
        if len(unknowns) != 1 or unknowns[0] not in self.problem.rates or len(roots) != 2:
            return ""
        this, other = abs(roots[k].values[0]), abs(roots[1 - k].values[0])
        if abs(this - other) * 10**9 <= this + other:
            return ""
        return "fast" if this > other else "slow"

    def _numbers(
        self, values: Mapping[Any, Expression]
    ) -> tuple[dict[Any, Any], list[Any], dict[Any, float]]:
        """Return (numbers by atom, unknowns to solve for, numbers of the known unknowns)."""
        p = self.problem
        known: dict[Any, float] = {}
        others = {}
        for key, value in values.items():
            atom = p.atom(key, p.named)
            if atom is None:
                others[key] = value
            else:
                known[atom] = float(sympy.sympify(value) if isinstance(value, str) else value)
        for key in others:
            name = str(key)
            if name in p.e.model.coordinate_names or name in p.e.model.speed_names:
                raise ModelError(
                    f"'{name}' is no unknown of these steady motions; {nearest(name, [p.name(a) for a in p.named])}"
                )
        without_default = [q for q in p.e.model.parameters if q.symbol in p.unknowns and q.default is None]
        atoms = numbers(p.e, {**others, **{q.symbol: 0 for q in without_default}})
        for symbol in p.terms:  # a term that is a parameter has its default
            if (
                symbol in atoms
                and symbol not in self.solve_for
                and symbol not in known
                and not any(q.symbol == symbol for q in without_default)
            ):
                known[symbol] = atoms[symbol]
        unknowns = [a for a in p.unknowns if a not in known]
        atoms.update(known)
        return atoms, unknowns, known

    def _state(
        self, name: str, root: NumericRoot, unknowns: Sequence[Any], atoms: Mapping[Any, Any],
        known: Mapping[Any, float],
    ) -> SteadyState:  # fmt: skip
        p = self.problem
        solved = dict(zip(unknowns, map(float, root.values), strict=True))
        full = self._full({**atoms, **solved})
        state = {c.name: float(full[c.symbol]) for c in p.e.model.coordinates}
        state.update({s.name: float(full[s.symbol]) for s in p.e.model.speeds})
        shown = {p.name(a): v for a, v in {**known, **solved}.items()}
        places = set(p.coordinates)
        family = root.family + sum(bool(x) for a, x in zip(unknowns, root.open, strict=True) if a in places)
        verdict = self.stability.at(full, family)
        return SteadyState(name, shown, state, root.residual, root.error, verdict)

    def _full(self, atoms: dict[Any, Any]) -> dict[Any, Any]:
        """Return numbers for all atoms on a steady motion: rates from terms, speeds from rates, accelerations zero."""
        p = self.problem
        full = {**p.defaults(), **atoms}
        full.update(p.completed(full))
        at = Substitution(p.ring, arrays, full)
        full.update({rate: float(at(x)) for rate, x in p.replaced.items()})
        at = Substitution(p.ring, arrays, full)
        full.update({a: float(at(x)) for a, x in p.steady_values.items() if a not in p.rates})
        at = Substitution(p.ring, arrays, full)
        full.update({p.e.model.speeds[j].symbol: float(at(x)) for j, x in p.dependent.items()})
        return full

    def continuation(
        self, parameter: Any, span: Any, values: Mapping[Any, Expression], points: int
    ) -> tuple[Branch, ...]:
        """Return their branches over a range of one parameter; see :meth:`SteadyMotions.continuation`."""
        a, b = check_span(span)
        p = self.problem
        fixed = {self._name(k): v for k, v in values.items()}
        name = self._name(parameter)
        symbols = {q.name: q.symbol for q in p.e.model.parameters} | {p.name(u): u for u in p.unknowns}
        if name not in symbols:
            raise ModelError(f"Unknown parameter '{name}' to continue along; {nearest(name, symbols)}")
        branches: list[Branch] = []
        for end, direction in ((a, 1), (b, -1)):
            for state in self.at({**fixed, name: end}):
                if not any(_passes(branch, end, state.values) for branch in branches):
                    branches.append(
                        self._branch(symbols[name], name, (a, b), end, direction, fixed, state, points)
                    )
        if not branches:
            raise ModelError(
                f"No steady motion at either end of the range of {name} from {a:g} to {b:g}. Choose a range with "
                f"one at an end."
            )
        return tuple(branches)

    def _name(self, key: Any) -> str:
        return self.problem.name(key) if isinstance(key, sympy.Basic) else str(key)

    def _branch(
        self, symbol: Any, name: str, span: tuple[float, float], end: float, direction: int,
        fixed: Mapping[str, Any], state: SteadyState, points: int,
    ) -> Branch:  # fmt: skip
        p = self.problem
        atoms, unknowns, _ = self._numbers({**fixed, name: end})
        pieces = [product(live_factors(p.ring, x, set(p.unknowns))) for x in p.conditions]
        conditions = Conditions(
            p.ring, pieces, [*unknowns, symbol], {a: v for a, v in atoms.items() if a != symbol}
        )
        start = np.array([*(state.values[p.name(a)] for a in unknowns), end])
        sense = direction if span[0] < span[1] else -direction
        path, special = follow(conditions, start, span, sense, points)
        names = [p.name(a) for a in unknowns]
        verdicts = []
        for z in path:
            full = self._full({**atoms, **dict(zip((*unknowns, symbol), map(float, z), strict=True))})
            verdicts.append(self.stability.at(full).verdict)
        marks = tuple(
            Special(kind, float(z[-1]), {n: float(x) for n, x in zip(names, z, strict=False)})
            for kind, z in special
        )
        columns = {n: path[:, k] for k, n in enumerate(names)}
        return Branch(name, path[:, -1], columns, tuple(verdicts), marks)


def _passes(branch: Branch, end: float, values: Mapping[str, float]) -> bool:
    """Return True if a branch passes through a root at one end of its range."""
    for k in (0, -1):
        if abs(branch.parameters[k] - end) > abs(end) / 10**9 + 1 / 10**12:
            continue
        if all(
            abs(column[k] - values[name]) <= (1 + abs(values[name])) / 10**6
            for name, column in branch.values.items()
        ):
            return True
    return False
