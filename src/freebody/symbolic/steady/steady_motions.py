"""Steady motions as a result: conditions and motions in closed form, states in numbers, text and LaTeX."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import sympy

from ...errors import ModelError, TooManyTermsError, nearest
from ...scalar.algebra import Expression, Scalar
from ...scalar.polynomial import Polynomial
from ..printing.display import displayed, equation_latex, equation_text, text
from ..printing.lines import Result
from ..printing.show import aligned, latex_words
from .factors import excluded, factors, live_factors, product
from .motion import SteadyMotion, SteadyState
from .problem import Problem
from .solve import Solution, solutions
from .stability import ProblemStability

if TYPE_CHECKING:
    from .continuation import Branch
    from .states import SteadyStates
    from .turning import TurningStability

NEAR = "With values={...}, and near={...} for a guess, one steady motion is found in numbers."
CLOSED = 20_000
"""Largest number of terms of intermediate results of a closed form; nobody would read a longer one."""


class SteadyMotions(Result, Sequence[SteadyMotion]):
    """The steady motions of a system. Made by :func:`steady_motions`.

    Attributes
    ----------
    reason : str
        Why there is no closed form, if it would be too long; the motions are then in ``.states``, in numbers.
    """

    reason = ""

    def __init__(
        self,
        problem: Problem,
        stability: ProblemStability | TurningStability,
        solve_for: Any,
        values: Mapping[Any, Expression] | None,
    ) -> None:
        self.problem = problem
        self._stability = stability
        self._solve_for = self._atoms(solve_for)
        self._values = values
        p = problem
        unknowns = self._solve_for or tuple(a for a in p.unknowns if a not in p.terms)
        others = tuple(a for a in p.unknowns if a not in unknowns)
        solved = self._in_closed_form(unknowns, others) if p.short else [Solution(remaining=p.conditions)]
        self._motions = tuple(SteadyMotion(p, stability, solution) for solution in solved)
        self._refuse_none()
        if values is None and self._solve_for:
            self._refuse_unsolved()

    def _in_closed_form(self, unknowns: Sequence[Any], others: Sequence[Any]) -> list[Solution]:
        """Return the solutions; if they would be too long, the conditions remain to be solved in numbers."""
        p = self.problem
        try:
            with p.ring.budget.question("the steady motions in closed form", terms=CLOSED):
                return solutions(p.ring, p.exact, unknowns, others)
        except TooManyTermsError as error:
            self.reason = error.reason
            return [Solution(remaining=p.conditions)]

    def _atoms(self, names: Any) -> tuple[Any, ...]:
        if names is None:
            return ()
        p = self.problem
        if isinstance(names, str):
            names = names.replace(",", " ").split()
        elif isinstance(names, sympy.Basic):
            names = [names]
        result = []
        for key in names:
            atom = p.atom(key, p.unknowns)
            if atom is None:
                known = [p.name(a) for a in p.unknowns]
                raise ModelError(
                    f"'{key}' is no unknown of the steady motions of '{p.e.model.name}'; {nearest(str(key), known)}"
                )
            result.append(atom)
        return tuple(result)

    def _refuse_none(self) -> None:
        p = self.problem
        unknowns = set(p.unknowns)

        def needs(solution: Solution) -> list[Any]:
            return [x for x in solution.remaining if not p.ring.atoms_of(x) & unknowns]

        if self._motions and not all(needs(motion.canonical) for motion in self._motions):
            self._motions = tuple(motion for motion in self._motions if not needs(motion.canonical))
            return
        never = [x for x in p.conditions if factors(p.ring, x, unknowns) is None]
        missing = needs(self._motions[0].canonical) if self._motions else never or p.conditions
        shown = ", ".join(f"{text(x, p.ring) if type(x) is Polynomial else abs(x)} = 0" for x in missing)
        cure = "Change the loads, or choose parameters for which that holds."
        if not self._motions and not never and solutions(p.ring, p.conditions, p.unknowns, ()):
            shown += ", and there the loads or conditions have no value, since they divide by zero"
            cure = "Change the loads."
        raise ModelError(f"'{p.e.model.name}' has no steady motion: it would need {shown}. {cure}")

    def _refuse_unsolved(self) -> None:
        p = self.problem
        for motion in self._motions:
            if motion.canonical.remaining:
                remaining = ", ".join(f"{text(x, p.ring)} = 0" for x in motion.canonical.remaining)
                unknowns = ", ".join(p.name(a) for a in self._solve_for)
                raise ModelError(
                    f"No closed form for {unknowns}; unsolved: {remaining}. Ask for another unknown, or give values= "
                    "for roots in numbers."
                )

    # -- conditions -------------------------------------------------------------------------------

    @cached_property
    def conditions(self) -> tuple[Any, ...]:
        """The conditions of steady motion as SymPy ``Eq``, without trivial ones, with common factors."""
        p = self.problem
        return tuple(
            sympy.Eq(displayed(product(self._factors(x)), p.ring), 0, evaluate=False) for x in p.conditions
        )

    @cached_property
    def branches(self) -> tuple[tuple[Any, ...], ...]:
        """The factors of each condition that may be zero, as SymPy expressions."""
        p = self.problem
        return tuple(tuple(displayed(f, p.ring) for f in self._factors(x)) for x in p.conditions)

    def _factors(self, x: Scalar) -> list[Any]:
        return live_factors(self.problem.ring, x, set(self.problem.unknowns))

    @cached_property
    def excluded(self) -> tuple[tuple[Any, ...], ...]:
        """Sums of parameters, for each condition, that are taken as not zero, as SymPy ``Ne``.

        If one of them is zero, the condition holds for all unknowns. Roots in numbers are found there too.
        """
        p = self.problem
        return tuple(
            tuple(sympy.Ne(displayed(f, p.ring), 0, evaluate=False) for f in self._excluded(x))
            for x in p.conditions
        )

    def _excluded(self, x: Scalar) -> list[Any]:
        return excluded(self.problem.ring, x, set(self.problem.unknowns))

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Names of the unknowns in the conditions."""
        return tuple(self.problem.name(a) for a in self.problem.unknowns)

    @property
    def rates(self) -> tuple[str, ...]:
        """Names of the constant rates."""
        return tuple(self.problem.name(a) for a in self.problem.rates)

    @property
    def linear(self) -> Any:
        """The linearised equations about any of the motions."""
        return self._stability.linear

    @property
    def amended(self) -> Any:
        """The amended potential."""
        return self._stability.amended

    # -- the motions ------------------------------------------------------------------------------

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            for motion in self._motions:
                if key == motion.name:
                    return motion
            raise ModelError(
                f"Unknown steady motion '{key}'; {nearest(key, [motion.name for motion in self._motions])}"
            )
        return self._motions[key]

    def __iter__(self) -> Iterator[SteadyMotion]:
        return iter(self._motions)

    def __len__(self) -> int:
        return len(self._motions)

    # -- numbers ----------------------------------------------------------------------------------

    @cached_property
    def states(self) -> tuple[SteadyState, ...]:
        """All steady motions at the given values; one near zero, if finding all would take too long."""
        try:
            return self.at(self._values or {})
        except TooManyTermsError as error:
            from .equilibrium_near import steady_near

            near = steady_near(self.problem.e.model, self._values or {}, None)
            self.reason = (
                f"{error.reason} One motion was found by Newton's method from zero; others may exist."
            )
            return near.states

    @cached_property
    def _in_numbers(self) -> SteadyStates:
        from .states import SteadyStates

        return SteadyStates(self.problem, self._stability, self._solve_for)

    def at(self, values: Mapping[Any, Expression]) -> tuple[SteadyState, ...]:
        """Return all steady motions in numbers, and for a continuous family one of each connected piece.

        Parameters
        ----------
        values : mapping
            Parameters and known unknowns, by name or symbol; the other unknowns are solved for.

        Raises
        ------
        ModelError
            There are more unknowns than conditions.
        """
        import numpy as np

        question = self.problem.ring.budget.question("all steady motions in numbers", NEAR)
        with question, np.errstate(all="ignore"):  # where a law has no value, a root is none
            return self._in_numbers.at(values)

    def continuation(
        self, parameter: Any, span: Any, *, values: Mapping[Any, Expression] | None = None, points: int = 400
    ) -> tuple[Branch, ...]:
        """Return the branches of steady motions over a range of one parameter, by pseudo-arclength continuation.

        Every root at either end of the range starts a branch; folds and bifurcations on it are located.

        Parameters
        ----------
        parameter : str or symbol
            A parameter, or an unknown that ``values`` contains elsewhere.
        span : pair of numbers
        values : mapping, optional
            Parameters and known unknowns; by default those of :func:`steady_motions`.
        points : int
            Largest number of points of a branch.

        Raises
        ------
        ModelError
            An unknown parameter, a bad range, or no root at either end.
        """
        given = values if values is not None else self._values or {}
        return self._in_numbers.continuation(parameter, span, given, points)

    # -- display ----------------------------------------------------------------------------------

    def text(self) -> str:
        """Conditions and motions, a line each."""
        ring = self.problem.ring
        lines = []
        for x in self.problem.conditions:
            lines.append("0 = " + " or ".join(text(f, ring) for f in self._factors(x)))
            if zero := self._excluded(x):
                lines[-1] += "  unless " + " or ".join(equation_text(f, 0, ring) for f in zero)
        return "\n".join([*lines, *(motion.text() for motion in self._motions), *self._handed_over()])

    def _handed_over(self) -> list[str]:
        """Return the lines that tell why the motions are in numbers, with the motions."""
        if not self.reason:
            return []
        head = f"No closed form: {self.reason}"
        if self._values is None:
            return [f"{head} With values={{...}} .states holds motions in numbers."]
        return [f"{head} In numbers:", *(state.text() for state in self.states)]

    def latex(self) -> str:
        """Conditions and motions as a LaTeX ``aligned`` block."""
        ring = self.problem.ring
        lines = []
        for x in self.problem.conditions:
            lines.append("&" + r"\ \text{or}\ ".join(equation_latex(f, 0, ring) for f in self._factors(x)))
            if zero := self._excluded(x):
                unless = r"\ \text{or}\ ".join(equation_latex(f, 0, ring) for f in zero)
                lines[-1] += r"\quad\text{unless }" + unless
        lines += ["&" + motion.latex() for motion in self._motions]
        lines += ["&" + latex_words(line) for line in self._handed_over()]
        return aligned(lines)

    def __repr__(self) -> str:
        head = f"Steady motions of '{self.problem.e.model.name}'"
        if self._values is not None:
            return "\n".join([head, *map(repr, self.states)])
        return f"{head}\n{self.text()}"
