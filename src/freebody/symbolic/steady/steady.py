"""Steady motions: equilibria and relative equilibria, their conditions of existence and their stability.

The conditions are the equations of motion at constant coordinates and constant ignorable rates; see
:mod:`freebody.symbolic.steady.problem`. They are split into factors and solved in closed form if they are quadratic in
an unknown, else in numbers.

The file is longer than others: all products of one class share its conditions.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import sympy

from ...describe.system import System
from ...errors import ModelError, TooManyTermsError, nearest
from ...model.model import Model
from ...scalar.algebra import Expression, Scalar
from ...scalar.polynomial import Polynomial
from ...scalar.substitute import Substitution, arrays
from ..derivation.along_motion import numbers
from ..derivation.contact_modes import check_modes_are_chosen
from ..printing.display import displayed, equation_latex, equation_text, text
from ..printing.lines import Result
from ..printing.show import aligned, latex_words
from .factors import excluded, factors, product
from .motion import SteadyMotion, SteadyState
from .problem import Problem
from .solve import Solution, solutions
from .stability import ProblemStability

if TYPE_CHECKING:
    from ..equations import Equations
    from .continuation import Branch
    from .equilibrium_near import SteadyNear
    from .numeric import NumericRoot
    from .turning import TurningStability


@overload
def steady_motions(
    system: System | Model | Equations,
    *,
    solve_for: Any = None,
    terms: Mapping[Any, Expression] | None = None,
    values: None = None,
    near: None = None,
) -> SteadyMotions: ...


@overload
def steady_motions(
    system: System | Model | Equations,
    *,
    solve_for: Any = None,
    terms: Mapping[Any, Expression] | None = None,
    values: Mapping[Any, Expression] | None = None,
    near: Mapping[Any, Expression] | None = None,
) -> SteadyMotions | SteadyNear: ...


def steady_motions(
    system: System | Model | Equations,
    *,
    solve_for: Any = None,
    terms: Mapping[Any, Expression] | None = None,
    values: Mapping[Any, Expression] | None = None,
    near: Mapping[Any, Expression] | None = None,
) -> SteadyMotions | SteadyNear:
    """Find motions with constant coordinates, except those on which nothing depends: these have constant rates.

        E_k(q, u = Σ w_a ξ_a, u' = 0) = 0

    The unknowns of a ball or free joint ``p`` are angles: R = R_n(p_psi) R_a(p_theta) R_b(p_phi), where n is the
    vertical and b the body's axis of symmetry (n if it has none). The rates are p_psi' of the turn about the vertical
    and p_phi' of the spin, if these are symmetries, so that a body may spin while it precesses. In numbers, one motion
    is given for all that a turn or a reflection maps to each other, and one for each continuous family.

    Parameters
    ----------
    system : System, Model or Equations
    solve_for : str, symbol or sequence of them, optional
        Unknowns to solve for; by default, rates before coordinates. An unknown is a coordinate (``theta``), the rate
        of an ignorable one (``psi'``), a term, or the force of a constraint.
    terms : mapping, optional
        New names for combinations of rates, each in place of the last rate in it:
        ``{"Omega_zeta": "phi' + psi'*cos(theta)"}`` is the total spin.
    values : mapping, optional
        Parameters, and known unknowns, by name or symbol; then ``.states`` contains all roots in numbers.
    near : mapping, optional
        A guess of the coordinates by name, others zero: the result is the one equilibrium in numbers that Newton's
        method finds from it. Also used, with the guess zero by default, if the conditions would be too long to write.

    Returns
    -------
    SteadyMotions or SteadyNear
        SteadyNear if the motion was searched near a guess; ``.reason`` tells why.

    Raises
    ------
    ModelError
        No steady motion exists (with the requirement), no closed form for the unknowns (with the remaining
        conditions), a machine with constraints and unit quaternions, or too few values.
    TooManyTermsError
        Without values, if the conditions would be too long to write.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("conical pendulum")
    >>> m, L, g = s.parameters(m=1, L=0.5, g=9.81)
    >>> s.assume(L > 0), s.assume(g > 0)
    (None, None)
    >>> s.gravity = (0, 0, -g)
    >>> bob = s.body("bob", fb.particle(m))
    >>> arm = s.universal("arm", s.ground, bob, to=(0, 0, L), axis=("z", "x"), coordinate="psi theta")
    >>> print(fb.steady_motions(s, solve_for="theta").text())
    0 = L*psi'^2*cos(theta) - g or sin(theta)
    theta = acos(g/(L*psi'^2))  if L*psi'^2 - g >= 0
    theta = -acos(g/(L*psi'^2))  if L*psi'^2 - g >= 0
    theta = 0, any psi'  (coordinates are singular here)
    theta = pi, any psi'  (coordinates are singular here)
    """
    from ..equations import Equations, equations

    e = system if isinstance(system, Equations) else equations(system)
    if e is not system:
        check_modes_are_chosen(e.model, "fb.steady_motions")
    if near is not None:
        from .equilibrium_near import steady_near

        return steady_near(e.model, values or {}, near)
    try:
        with e.ring.budget.question(f"the conditions of steady motion of '{e.model.name}'", NEAR):
            if e.model.quaternions:
                from .turning import TurningProblem, TurningStability

                turning = TurningProblem(e, terms)
                return SteadyMotions(turning, TurningStability(turning), solve_for, values)
            problem = Problem(e, terms)
            return SteadyMotions(problem, ProblemStability(problem), solve_for, values)
    except TooManyTermsError as error:
        if values is None:
            raise
        from .equilibrium_near import steady_near

        return steady_near(e.model, values, None, error.reason)


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
        return tuple(sympy.Eq(displayed(self._live(x), p.ring), 0, evaluate=False) for x in p.conditions)

    @cached_property
    def branches(self) -> tuple[tuple[Any, ...], ...]:
        """The factors of each condition that may be zero, as SymPy expressions."""
        p = self.problem
        return tuple(tuple(displayed(f, p.ring) for f in self._factors(x)) for x in p.conditions)

    def _factors(self, x: Scalar) -> list[Any]:
        return factors(self.problem.ring, x, set(self.problem.unknowns)) or [x]

    def _live(self, x: Scalar) -> Any:
        return product(self._factors(x))

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
            return self._at(values)

    def _at(self, values: Mapping[Any, Expression]) -> tuple[SteadyState, ...]:
        import numpy as np

        from .conditions import Conditions
        from .family import dimension
        from .numeric import Underdetermined, roots

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
        import numpy as np

        from .conditions import Conditions

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
                and symbol not in self._solve_for
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
        verdict = self._stability.at(full, family)
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
        from .continuation import check_span

        a, b = check_span(span)
        p = self.problem
        fixed = {self._name(k): v for k, v in (values if values is not None else self._values or {}).items()}
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
        import numpy as np

        from .conditions import Conditions
        from .continuation import Branch, Special, follow

        p = self.problem
        atoms, unknowns, _ = self._numbers({**fixed, name: end})
        live = [self._live(x) for x in p.conditions]
        conditions = Conditions(
            p.ring, live, [*unknowns, symbol], {a: v for a, v in atoms.items() if a != symbol}
        )
        start = np.array([*(state.values[p.name(a)] for a in unknowns), end])
        sense = direction if span[0] < span[1] else -direction
        path, special = follow(conditions, start, span, sense, points)
        names = [p.name(a) for a in unknowns]
        verdicts = []
        for z in path:
            full = self._full({**atoms, **dict(zip((*unknowns, symbol), map(float, z), strict=True))})
            verdicts.append(self._stability.at(full).verdict)
        marks = tuple(
            Special(kind, float(z[-1]), {n: float(x) for n, x in zip(names, z, strict=False)})
            for kind, z in special
        )
        columns = {n: path[:, k] for k, n in enumerate(names)}
        return Branch(name, path[:, -1], columns, tuple(verdicts), marks)

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
