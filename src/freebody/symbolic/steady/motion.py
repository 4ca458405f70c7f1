"""One steady motion: in closed form, with its conditions of existence and stability, or in numbers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import sympy

from ...scalar.polynomial import Polynomial
from ..printing.closed.answers import closed
from ..printing.display import displayed
from ..printing.latex import Latex, latex_name
from ..printing.lines import Result
from ..printing.show import latex_words, split
from ..printing.text import Text
from .factors import signed_part
from .problem import Problem
from .solve import Solution

if TYPE_CHECKING:
    from .stability import ProblemStability, Stability
    from .turning import TurningStability


SINGULAR = "coordinates are singular here"


@dataclass(frozen=True)
class Words:
    """The words and signs between the formulas of a steady motion."""

    equals: str
    comma: str
    any: str
    condition: str
    greater: str
    remaining: str
    zero: str


TEXT = Words(" = ", ", ", "any ", "  if ", " >= 0", "  where ", " = 0")
LATEX = Words(
    " = ", ", ", r"\ \text{any } ", r"\quad\text{if } ", r" \ge 0", r"\quad\text{where } ", " = 0"
)  # fmt: skip

_text, _latex = (partial(closed, kind) for kind in (Text, Latex))


@dataclass(frozen=True, repr=False)
class SteadyState(Result):
    """One steady motion in numbers.

    Attributes
    ----------
    name : str
    values : dict
        All unknowns by name, both solved for and given.
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

    def text(self) -> str:
        """Values and stability as a line of plain text."""
        shown = ", ".join(f"{name} = {value:.8g}" for name, value in self.values.items())
        return f"{self.name + ': ' if self.name else ''}{shown}; {self.stability}"

    def latex(self) -> str:
        """The motion as LaTeX."""
        parts = [f"{latex_name(*split(name))} = {value:.8g}" for name, value in self.values.items()]
        label = latex_words(f"{self.name}: ") + " " if self.name else ""
        return label + r",\ ".join(parts) + r"\quad" + latex_words(str(self.stability))


class SteadyMotion(Result):
    """One steady motion in closed form."""

    def __init__(
        self, problem: Problem, stability: ProblemStability | TurningStability, canonical: Solution
    ) -> None:
        self._p = problem
        self._stability = stability
        self.canonical = canonical

    @property
    def name(self) -> str:
        """The label "fast" or "slow" of the two roots of a quadratic, else the values of the unknowns."""
        return ", ".join(self.canonical.labels) or self._assignments(_text, ", ")

    @cached_property
    def solution(self) -> dict[str, Any]:
        """Values of the unknowns as SymPy expressions, by name."""
        return {self._p.name(a): displayed(x, self._p.ring) for a, x in self.canonical.values.items()}

    @cached_property
    def existence(self) -> tuple[Any, ...]:
        """Inequalities, SymPy relations, under which the motion exists."""
        return tuple(sympy.Ge(displayed(x, self._p.ring), 0, evaluate=False) for x in self._exists)

    @cached_property
    def nonzero(self) -> tuple[Any, ...]:
        """Divisors of the values, which must not be zero, as SymPy ``Ne``; roots in numbers do not need them."""
        shown = dict.fromkeys(
            displayed(x, self._p.ring) for x in self.canonical.nonzero if type(x) is Polynomial
        )
        return tuple(sympy.Ne(x, 0, evaluate=False) for x in shown)

    @cached_property
    def assuming(self) -> tuple[Any, ...]:
        """Inequalities that the name assumes: "fast" and "slow" change places with the sign of the spin."""
        return tuple(sympy.Gt(displayed(x, self._p.ring), 0, evaluate=False) for x in self.canonical.positive)

    @cached_property
    def limits(self) -> dict[str, Any]:
        """Limits of the unknowns for B² much larger than 4 A C in the discriminant: high spin."""
        return {self._p.name(a): displayed(x, self._p.ring) for a, x in self.canonical.limits.items()}

    @property
    def _exists(self) -> tuple[Any, ...]:
        result: list[Any] = []
        for x in self.canonical.exists:
            y = signed_part(self._p.ring, x)
            if (type(y) is Polynomial or y < 0) and y not in result:
                result.append(y)
        return tuple(result)

    @cached_property
    def left(self) -> tuple[Any, ...]:
        """Conditions without a closed form, as SymPy ``Eq``."""
        return tuple(
            sympy.Eq(displayed(x, self._p.ring), 0, evaluate=False) for x in self.canonical.remaining
        )

    @cached_property
    def singular(self) -> bool:
        """True if the coordinates are singular at this motion (Euler angles of an upright top).

        Coordinates and conditions then do not determine the motion fully: use other coordinates.
        """
        return self._stability.linear.singular(self.canonical.values)

    @cached_property
    def free(self) -> tuple[str, ...]:
        """Unknowns that may have any value (or were given)."""
        solved = set(self.canonical.values)
        return tuple(self._p.name(a) for a in self._p.named if a not in solved)

    @cached_property
    def _stable_if(self) -> list[Any] | None:
        from .stability import hurwitz

        c = self._stability.linear.characteristic(self.canonical.values, sympy.Symbol("s"))
        return None if c is None else hurwitz(self._p, c)

    @cached_property
    def characteristic(self) -> Any:
        """Characteristic polynomial of small deviations in ``s``, without its zero roots; None if not formed.

        Not formed for systems with constraints, more than four speeds, or singular coordinates.
        """
        s = sympy.Symbol("s")
        c = self._stability.linear.characteristic(self.canonical.values, s)
        if c is None:
            return None
        return sum((displayed(x, self._p.ring) * s**k for k, x in enumerate(c)), start=sympy.S.Zero)

    @cached_property
    def stable_if(self) -> tuple[Any, ...] | None:
        """Inequalities under which all eigenvalues are on the imaginary axis (conservative) or left of it.

        Empty if that always holds, None if no closed form is known.
        """
        if self._stable_if is None:
            return None
        if any(type(x) is not Polynomial for x in self._stable_if):
            return (sympy.false,)
        return tuple(sympy.Gt(displayed(x, self._p.ring), 0, evaluate=False) for x in self._stable_if)

    @cached_property
    def _energy(self) -> Any:
        return self._stability.amended.curvature(self.canonical.values)

    @cached_property
    def stable_by_energy_if(self) -> Any:
        """Inequality under which the amended potential has a minimum, so that the motion is stable; None if unknown.

        Known for one coordinate beside the ignorable ones, also if the coordinates are singular (the sleeping top).
        """
        x = self._energy
        if x is None:
            return None
        if type(x) is not Polynomial:
            return sympy.true if x > 0 else sympy.false
        return sympy.Gt(displayed(x, self._p.ring), 0, evaluate=False)

    # -- display ----------------------------------------------------------------------------------

    def _assignments(self, show: Any, separator: str, equals: str = " = ") -> str:
        ring = self._p.ring
        parts = []
        for a, x in self.canonical.values.items():
            parts.append(show(ring.generator(a), ring) + equals + show(x, ring))
        return separator.join(parts)

    def _shown(self, show: Any, signs: Words) -> str:
        ring = self._p.ring
        line = self._assignments(show, signs.comma, signs.equals)
        free = [a for a in self._p.named if a not in self.canonical.values and a not in self._present]
        if not line and not free:  # rest at any place
            free = self._p.coordinates
        if free:
            line += signs.comma if line else ""
            line += signs.any + signs.comma.join(show(ring.generator(a), ring) for a in free)
        if self._exists:
            line += signs.condition + signs.comma.join(show(x, ring) + signs.greater for x in self._exists)
        if self.canonical.remaining:
            line += signs.remaining + signs.comma.join(
                show(x, ring) + signs.zero for x in self.canonical.remaining
            )
        return line

    @property
    def _present(self) -> set[Any]:
        ring = self._p.ring
        result: set[Any] = set()
        for x in (*self.canonical.values.values(), *self.canonical.remaining):
            result |= ring.atoms_of(x)
        return result

    def text(self) -> str:
        """Values, existence and remaining conditions as a line of plain text."""
        label = f"{self.name}: " if self.canonical.labels else ""
        return label + self._shown(_text, TEXT) + (f"  ({SINGULAR})" if self.singular else "")

    def latex(self) -> str:
        """The motion as LaTeX."""
        label = latex_words(f"{self.name}: ") + " " if self.canonical.labels else ""
        mark = r"\quad" + latex_words(f"({SINGULAR})") if self.singular else ""
        return label + self._shown(_latex, LATEX) + mark
