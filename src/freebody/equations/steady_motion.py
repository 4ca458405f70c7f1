"""One steady motion: in closed form, with when it exists and when it is stable, or in numbers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import sympy

from ..scalar.polynomial import Polynomial
from .display import displayed, latex, text
from .steady_solve import Found, sign_kept

if TYPE_CHECKING:
    from .stability import Stability
    from .steady import SteadyMotions


@dataclass(frozen=True)
class SteadyState:
    """One steady motion in numbers.

    Attributes
    ----------
    name : str
    values : dict
        The unknowns that were solved for, and those given, by name.
    state : dict
        All coordinates and speeds by name: an initial state for :func:`freebody.simulate`.
    residual : float
        Largest condition, relative to the sum of the sizes of its terms.
    error : float
        Last Newton step, an estimate of the error of the unknowns.
    stability : Stability
    """

    name: str
    values: dict[str, float]
    state: dict[str, float]
    residual: float
    error: float
    stability: Stability

    def __repr__(self) -> str:
        shown = ", ".join(f"{name} = {value:.8g}" for name, value in self.values.items())
        return f"{self.name + ': ' if self.name else ''}{shown}; {self.stability}"


class SteadyMotion:
    """One steady motion in closed form."""

    def __init__(self, owner: SteadyMotions, found: Found) -> None:
        self._owner = owner
        self._p = owner.problem
        self.found = found

    @property
    def name(self) -> str:
        """What the unknowns are; of two values of a quadratic, which: fast or slow."""
        return ", ".join(self.found.labels) or self._assignments(text, ", ")

    @cached_property
    def solution(self) -> dict[str, Any]:
        """Values of the unknowns as SymPy expressions, by name."""
        return {self._p.name(a): displayed(x, self._p.ring) for a, x in self.found.values.items()}

    @cached_property
    def existence(self) -> tuple[Any, ...]:
        """Inequalities, SymPy relations, under which the motion exists."""
        return tuple(sympy.Ge(displayed(x, self._p.ring), 0, evaluate=False) for x in self._exists)

    @cached_property
    def assuming(self) -> tuple[Any, ...]:
        """Inequalities that the name stands under: "fast" and "slow" change places with the sign of the spin."""
        return tuple(sympy.Gt(displayed(x, self._p.ring), 0, evaluate=False) for x in self.found.positive)

    @cached_property
    def limits(self) -> dict[str, Any]:
        """Value of an unknown where the discriminant is governed by its square: high spin."""
        return {self._p.name(a): displayed(x, self._p.ring) for a, x in self.found.limits.items()}

    @property
    def _exists(self) -> tuple[Any, ...]:
        result: list[Any] = []
        for x in self.found.exists:
            y = sign_kept(self._p.ring, x)
            if (type(y) is Polynomial or y < 0) and y not in result:
                result.append(y)
        return tuple(result)

    @cached_property
    def left(self) -> tuple[Any, ...]:
        """Conditions without a closed form, as SymPy ``Eq``."""
        return tuple(sympy.Eq(displayed(x, self._p.ring), 0, evaluate=False) for x in self.found.left)

    @cached_property
    def singular(self) -> bool:
        """Whether the coordinates are singular there (Euler angles of an upright top).

        A coordinate then says less than it does elsewhere, and so do the conditions: look at the motion in other ones.
        """
        return self._owner.linear.singular(self.found.values)

    @cached_property
    def free(self) -> tuple[str, ...]:
        """Unknowns that may have any value (or were given)."""
        solved = set(self.found.values)
        return tuple(self._p.name(a) for a in self._p.named if a not in solved)

    @cached_property
    def _stable_if(self) -> list[Any] | None:
        from .stability import hurwitz

        c = self._owner.linear.characteristic(self.found.values, sympy.Symbol("s"))
        return None if c is None else hurwitz(self._p, c)

    @cached_property
    def characteristic(self) -> Any:
        """Characteristic polynomial of small deviations in ``s``, without its zero roots; None if not formed.

        Not formed for systems with constraints, for more than four speeds, and where the coordinates are singular.
        """
        s = sympy.Symbol("s")
        c = self._owner.linear.characteristic(self.found.values, s)
        if c is None:
            return None
        return sum((displayed(x, self._p.ring) * s**k for k, x in enumerate(c)), start=sympy.S.Zero)

    @cached_property
    def stable_if(self) -> tuple[Any, ...] | None:
        """Inequalities under which all eigenvalues are on the imaginary axis (conservative) or left of it.

        Empty if that is always so, None if it is not known in closed form.
        """
        if self._stable_if is None:
            return None
        if any(type(x) is not Polynomial for x in self._stable_if):
            return (sympy.false,)
        return tuple(sympy.Gt(displayed(x, self._p.ring), 0, evaluate=False) for x in self._stable_if)

    @cached_property
    def _energy(self) -> Any:
        return self._owner.amended.curvature(self.found.values)

    @cached_property
    def stable_by_energy_if(self) -> Any:
        """Inequality under which the amended potential has a minimum, so that the motion is stable; None if unknown.

        Known for one coordinate beside the ignorable ones, also where the coordinates are singular (the sleeping top).
        """
        x = self._energy
        if x is None:
            return None
        if type(x) is not Polynomial:
            return sympy.true if x > 0 else sympy.false
        return sympy.Gt(displayed(x, self._p.ring), 0, evaluate=False)

    # -- display ----------------------------------------------------------------------------------

    def _assignments(self, show: Any, separator: str) -> str:
        ring = self._p.ring
        parts = []
        for a, x in self.found.values.items():
            parts.append(f"{show(ring.generator(a), ring)} = {show(x, ring)}")
        return separator.join(parts)

    def _shown(self, show: Any, words: tuple[str, str, str, str]) -> str:
        ring = self._p.ring
        or_any, given, greater, left = words
        line = self._assignments(show, ", ") or "-"
        free = [a for a in self._p.named if a not in self.found.values and a not in self._present]
        if free:
            line += or_any + ", ".join(show(ring.generator(a), ring) for a in free)
        if self._exists:
            line += given + ", ".join(show(x, ring) + greater for x in self._exists)
        if self.found.left:
            line += left + ", ".join(show(x, ring) + " = 0" for x in self.found.left)
        return line

    @property
    def _present(self) -> set[Any]:
        ring = self._p.ring
        result: set[Any] = set()
        for x in (*self.found.values.values(), *self.found.left):
            result |= ring.atoms_of(x)
        return result

    def text(self) -> str:
        """Values, existence and what is left, as a line of plain text."""
        label = f"{self.name}: " if self.found.labels else ""
        mark = "  (coordinates are singular here)" if self.singular else ""
        return label + self._shown(text, (", any ", "  if ", " >= 0", "  where ")) + mark

    def latex(self) -> str:
        """The same as LaTeX."""
        label = rf"\text{{{self.name}: }} " if self.found.labels else ""
        words = (r",\ \text{any } ", r"\quad\text{if } ", r" \ge 0", r"\quad\text{where } ")
        mark = r"\quad\text{(coordinates are singular here)}" if self.singular else ""
        return label + self._shown(latex, words) + mark

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        return self.text()
