"""Steady motions: equilibria and relative equilibria, when they exist, and whether they are stable.

The conditions are the equations of motion at constant coordinates and constant ignorable rates; see
:mod:`freebody.symbolic.steady.problem`. They are split into factors, solved in closed form where they are quadratic in
what is asked for, and in numbers otherwise.

The file is longer than others: it is the one class of their motions, whose questions share its conditions.
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
from ...scalar.polynomial import Polynomial
from ...scalar.substitute import Substitution, arrays
from ..free_body.along_motion import numbers
from ..printing.display import displayed, equation_latex, equation_text, text
from ..printing.show import EQUALS, elements, inner, latex_words, words
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
    terms: Mapping[Any, Any] | None = None,
    values: None = None,
    near: None = None,
) -> SteadyMotions: ...


@overload
def steady_motions(
    system: System | Model | Equations,
    *,
    solve_for: Any = None,
    terms: Mapping[Any, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
) -> SteadyMotions | SteadyNear: ...


def steady_motions(
    system: System | Model | Equations,
    *,
    solve_for: Any = None,
    terms: Mapping[Any, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
) -> SteadyMotions | SteadyNear:
    """Motions in which coordinates stay constant, but for those that nothing depends on, which turn at constant rates.

        E_k(q, u = Σ w_a ξ_a, u' = 0) = 0

    Of a ball or free joint ``p`` the unknowns are angles: R = R_n(p_psi) R_a(p_theta) R_b(p_phi), n the vertical, b the
    body's axis of symmetry, if it has one (else n). The rates are p_psi' of turning about the vertical and p_phi' of
    spin, where these are symmetries, so that a body may spin while it precesses. Of motions in numbers that turn into
    each other or are mirror images, one is given, and so it is of the members of a continuous family.

    Parameters
    ----------
    system : System, Model or Equations
    solve_for : str, symbol or sequence of them, optional
        Unknowns to solve for; without it, rates before coordinates. An unknown is a coordinate (``theta``), the rate
        of an ignorable one (``psi'``), a term, or the force of a constraint.
    terms : mapping, optional
        New names for combinations of rates, each in place of the last rate in it:
        ``{"Omega_zeta": "phi' + psi'*cos(theta)"}`` is the total spin.
    values : mapping, optional
        Parameters, and unknowns that are given, by name or symbol; then ``.states`` holds all roots in numbers.
    near : mapping, optional
        Coordinates by name, others zero: the equilibrium in numbers that Newton's method finds from there, and no more.
        So it is found too, from zero if not given, where the conditions would be too long to be written.

    Returns
    -------
    SteadyMotions or SteadyNear
        The second where the motion was searched for near a guess; ``.reason`` says why.

    Raises
    ------
    ModelError
        No steady motion exists (what would have to hold), no closed form for what is asked (what was left), a
        machine with constraints and unit quaternions, or too few values.
    TooManyTermsError
        Without values, where the conditions would be too long to be written.

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
"""Terms of what a closed form may need on its way; nobody would read it."""


class SteadyMotions(Sequence[SteadyMotion]):
    """The steady motions of a system. Made by :func:`steady_motions`.

    Attributes
    ----------
    reason : str
        Why there is no closed form, where it would be too long; the motions are then in ``.states``, in numbers.
    """

    reason = ""

    def __init__(
        self,
        problem: Problem,
        stability: ProblemStability | TurningStability,
        solve_for: Any,
        values: Mapping[Any, Any] | None,
    ) -> None:
        self.problem = problem
        self._stability = stability
        self._asked = self._atoms(solve_for)
        self._given = values
        p = problem
        wanted = self._asked or tuple(a for a in p.unknowns if a not in p.terms)
        others = tuple(a for a in p.unknowns if a not in wanted)
        found = self._in_closed_form(wanted, others) if p.short else [Solution(left=p.conditions)]
        self._found = tuple(SteadyMotion(p, stability, one) for one in found)
        self._refuse_none()
        if values is None and self._asked:
            self._refuse_unsolved()

    def _in_closed_form(self, wanted: Sequence[Any], others: Sequence[Any]) -> list[Solution]:
        """The solutions; where they would be too long, the conditions are left for numbers."""
        p = self.problem
        try:
            with p.ring.budget.question("the steady motions in closed form", terms=CLOSED):
                return solutions(p.ring, p.conditions, wanted, others)
        except TooManyTermsError as error:
            self.reason = error.reason
            return [Solution(left=p.conditions)]

    def _atoms(self, asked: Any) -> tuple[Any, ...]:
        if asked is None:
            return ()
        p = self.problem
        if isinstance(asked, str):
            asked = asked.replace(",", " ").split()
        elif isinstance(asked, sympy.Basic):
            asked = [asked]
        result = []
        for one in asked:
            atom = p.atom(one, p.unknowns)
            if atom is None:
                names = [p.name(a) for a in p.unknowns]
                raise ModelError(
                    f"'{one}' is no unknown of the steady motions of '{p.e.model.name}'; {nearest(str(one), names)}"
                )
            result.append(atom)
        return tuple(result)

    def _refuse_none(self) -> None:
        p = self.problem
        unknowns = set(p.unknowns)

        def needs(one: Solution) -> list[Any]:
            return [x for x in one.left if not p.ring.atoms_of(x) & unknowns]

        if self._found and not all(needs(one.found) for one in self._found):
            self._found = tuple(one for one in self._found if not needs(one.found))
            return
        missing = needs(self._found[0].found) if self._found else self._impossible()
        shown = ", ".join(f"{text(x, p.ring) if type(x) is Polynomial else abs(x)} = 0" for x in missing)
        raise ModelError(
            f"'{p.e.model.name}' has no steady motion: it would need {shown}. Change the loads, or choose parameters "
            f"for which that holds."
        )

    def _impossible(self) -> list[Any]:
        p = self.problem
        live = set(p.unknowns)
        never = [x for x in p.conditions if factors(p.ring, x, live) is None]
        return never or list(p.conditions)

    def _refuse_unsolved(self) -> None:
        p = self.problem
        for one in self._found:
            if one.found.left:
                left = ", ".join(f"{text(x, p.ring)} = 0" for x in one.found.left)
                asked = ", ".join(p.name(a) for a in self._asked)
                raise ModelError(
                    f"No closed form for {asked}; left is {left}. Ask for another unknown, or give values= for "
                    f"roots in numbers."
                )

    # -- conditions -------------------------------------------------------------------------------

    @cached_property
    def conditions(self) -> tuple[Any, ...]:
        """The conditions of steady motion as SymPy ``Eq``, trivial ones left out, common factors kept."""
        p = self.problem
        return tuple(sympy.Eq(displayed(self._live(x), p.ring), 0, evaluate=False) for x in p.conditions)

    @cached_property
    def branches(self) -> tuple[tuple[Any, ...], ...]:
        """Per condition its factors that may vanish, as SymPy expressions."""
        p = self.problem
        return tuple(tuple(displayed(f, p.ring) for f in self._factors(x)) for x in p.conditions)

    def _factors(self, x: Any) -> list[Any]:
        return factors(self.problem.ring, x, set(self.problem.unknowns)) or [x]

    def _live(self, x: Any) -> Any:
        return product(self._factors(x))

    @cached_property
    def excluded(self) -> tuple[tuple[Any, ...], ...]:
        """Per condition the sums of parameters that are taken as not zero, SymPy ``Ne``.

        Where one of them is zero, the condition holds whatever the unknowns are. Roots in numbers are found there too.
        """
        p = self.problem
        return tuple(
            tuple(sympy.Ne(displayed(f, p.ring), 0, evaluate=False) for f in self._excluded(x))
            for x in p.conditions
        )

    def _excluded(self, x: Any) -> list[Any]:
        return excluded(self.problem.ring, x, set(self.problem.unknowns))

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Names of the unknowns in the conditions."""
        return tuple(self.problem.name(a) for a in self.problem.unknowns)

    @property
    def rates(self) -> tuple[str, ...]:
        """Names of the rates that are constant."""
        return tuple(self.problem.name(a) for a in self.problem.rates)

    # -- the motions ------------------------------------------------------------------------------

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            for one in self._found:
                if key == one.name:
                    return one
            raise ModelError(
                f"Unknown steady motion '{key}'; {nearest(key, [one.name for one in self._found])}"
            )
        return self._found[key]

    def __iter__(self) -> Iterator[SteadyMotion]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)

    # -- numbers ----------------------------------------------------------------------------------

    @cached_property
    def states(self) -> tuple[SteadyState, ...]:
        """All steady motions at the values given; one next to zero, where finding all would take too long."""
        try:
            return self.at(self._given or {})
        except TooManyTermsError as error:
            from .equilibrium_near import steady_near

            found = steady_near(self.problem.e.model, self._given or {}, None)
            self.reason = (
                f"{error.reason} One motion was found by Newton's method from zero; others may exist."
            )
            return found.states

    def at(self, values: Mapping[Any, Any]) -> tuple[SteadyState, ...]:
        """All steady motions in numbers; of a continuous family one of each connected piece, marked as such.

        Parameters
        ----------
        values : mapping
            Parameters and given unknowns, by name or symbol; the other unknowns are solved for.

        Raises
        ------
        ModelError
            More unknowns than conditions.
        """
        with self.problem.ring.budget.question("all steady motions in numbers", NEAR):
            return self._at(values)

    def _at(self, values: Mapping[Any, Any]) -> tuple[SteadyState, ...]:
        import numpy as np

        from .conditions import Conditions
        from .family import dimension
        from .numeric import Underdetermined, roots

        p = self.problem
        atoms, asked, given = self._numbers(values)
        moving = [*p.rates, *p.terms]
        try:
            found = roots(p.ring, p.conditions, asked, atoms, moving)
        except Underdetermined:
            names = [p.name(a) for a in asked]
            raise ModelError(
                f"The {len(p.conditions)} condition(s) of steady motion do not determine {', '.join(names)}. Give "
                f"values of some of them: values={{'{names[-1]}': ...}}."
            ) from None
        found = [root for root in found if self._balanced(atoms, asked, root.values)]
        result = []
        # a coordinate that is given may pick one of a family
        placed = {a: x for a, x in given.items() if a in p.coordinates}
        rest = {a: x for a, x in atoms.items() if a not in placed}
        whole = Conditions(p.ring, p.conditions, [*asked, *placed], rest)
        held = np.array([a in moving for a in whole.unknowns], dtype=bool)
        for k, root in enumerate(found):
            if placed:
                free = np.append(root.open, np.zeros(len(placed), dtype=bool))
                x = np.append(root.values, list(placed.values()))
                root = replace(root, family=dimension(whole, x, held | free))
            result.append(self._state(self._label(found, k, asked), root, asked, atoms, given))
        return tuple(p.distinct(result, atoms))

    def _balanced(self, atoms: Mapping[Any, Any], asked: Sequence[Any], x: Any) -> bool:
        """Whether the equations of motion hold: conditions freed of |y| or 1/y have roots that these do not have."""
        import numpy as np

        from .conditions import Conditions

        p = self.problem
        with np.errstate(all="ignore"):
            full = self._full({**atoms, **dict(zip(asked, x, strict=True))})
            exact = Conditions(p.ring, [E for E in p.exact if type(E) is Polynomial], asked, full)
            missed = np.abs(exact.values(x)) / np.maximum(exact.size(x), 1 / 10**300)
        return not (missed > 1 / 10**6).any()

    def _label(self, found: Sequence[Any], k: int, asked: Sequence[Any]) -> str:
        """Of two values of one rate, which: fast or slow."""
        if len(asked) != 1 or asked[0] not in self.problem.rates or len(found) != 2:
            return ""
        mine, other = abs(found[k].values[0]), abs(found[1 - k].values[0])
        if abs(mine - other) * 10**9 <= mine + other:
            return ""
        return "fast" if mine > other else "slow"

    def _numbers(self, values: Mapping[Any, Any]) -> tuple[dict[Any, Any], list[Any], dict[Any, float]]:
        """(numbers of all that is known, unknowns to solve for, unknowns given)."""
        p = self.problem
        given: dict[Any, float] = {}
        rest = {}
        for key, value in values.items():
            atom = p.atom(key, p.named)
            if atom is None:
                rest[key] = value
            else:
                given[atom] = float(sympy.sympify(value) if isinstance(value, str) else value)
        for key in rest:
            name = str(key)
            if name in p.e.model.coordinate_names or name in p.e.model.speed_names:
                raise ModelError(
                    f"'{name}' is no unknown of these steady motions; {nearest(name, [p.name(a) for a in p.named])}"
                )
        own = [q for q in p.e.model.parameters if q.symbol in p.unknowns and q.default is None]
        atoms = numbers(p.e, {**rest, **{q.symbol: 0 for q in own}})
        for symbol in p.terms:  # a term that is a parameter with a default is given by it
            if (
                symbol in atoms
                and symbol not in self._asked
                and symbol not in given
                and not any(q.symbol == symbol for q in own)
            ):
                given[symbol] = atoms[symbol]
        asked = [a for a in p.unknowns if a not in given]
        atoms.update(given)
        return atoms, asked, given

    def _state(
        self, name: str, root: NumericRoot, asked: Sequence[Any], atoms: Mapping[Any, Any], given: Mapping[Any, float]
    ) -> SteadyState:  # fmt: skip
        p = self.problem
        solved = dict(zip(asked, map(float, root.values), strict=True))
        full = self._full({**atoms, **solved})
        state = {c.name: float(full[c.symbol]) for c in p.e.model.coordinates}
        state.update({s.name: float(full[s.symbol]) for s in p.e.model.speeds})
        shown = {p.name(a): v for a, v in {**given, **solved}.items()}
        places = set(p.coordinates)
        family = root.family + sum(bool(x) for a, x in zip(asked, root.open, strict=True) if a in places)
        found = self._stability.at(full, family)
        return SteadyState(name, shown, state, root.residual, root.error, found)

    def _full(self, atoms: dict[Any, Any]) -> dict[Any, Any]:
        """Numbers of all atoms on a steady motion: rates from terms, speeds from rates, accelerations zero."""
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
        self, parameter: Any, span: Any, *, values: Mapping[Any, Any] | None = None, points: int = 400
    ) -> tuple[Branch, ...]:
        """The branches of steady motions over a range of one parameter, by pseudo-arclength steps.

        Every root at either end of the range starts a branch; folds and bifurcations on it are located.

        Parameters
        ----------
        parameter : str or symbol
            A parameter, or an unknown that is given elsewhere in ``values``.
        span : pair of numbers
        values : mapping, optional
            Parameters and given unknowns; those of :func:`steady_motions` if not given.
        points : int
            Most points of a branch.

        Raises
        ------
        ModelError
            An unknown parameter, a bad range, or no root at either end.
        """
        from .continuation import check_span

        a, b = check_span(span)
        p = self.problem
        given = {self._name(k): v for k, v in (values if values is not None else self._given or {}).items()}
        name = self._name(parameter)
        known = {q.name: q.symbol for q in p.e.model.parameters} | {p.name(u): u for u in p.unknowns}
        if name not in known:
            raise ModelError(f"Unknown parameter '{name}' to continue along; {nearest(name, known)}")
        branches: list[Branch] = []
        for end, direction in ((a, 1), (b, -1)):
            for state in self.at({**given, name: end}):
                if not any(_passes(branch, end, state.values) for branch in branches):
                    branches.append(
                        self._branch(known[name], name, (a, b), end, direction, given, state, points)
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
        given: Mapping[str, Any], state: SteadyState, points: int,
    ) -> Branch:  # fmt: skip
        import numpy as np

        from .conditions import Conditions
        from .continuation import Branch, Special, follow

        p = self.problem
        atoms, asked, _ = self._numbers({**given, name: end})
        live = [self._live(x) for x in p.conditions]
        one = Conditions(p.ring, live, [*asked, symbol], {a: v for a, v in atoms.items() if a != symbol})
        start = np.array([*(state.values[p.name(a)] for a in asked), end])
        sense = direction if span[0] < span[1] else -direction
        path, special = follow(one, start, span, sense, points)
        names = [p.name(a) for a in asked]
        verdicts = []
        for z in path:
            full = self._full({**atoms, **dict(zip((*asked, symbol), map(float, z), strict=True))})
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
        return "\n".join([*lines, *(one.text() for one in self._found), *self._handed_over()])

    def _handed_over(self) -> list[str]:
        """That the motions are in numbers, and these."""
        if not self.reason:
            return []
        head = f"No closed form: {self.reason}"
        if self._given is None:
            return [f"{head} With values={{...}} .states holds motions in numbers."]
        return [f"{head} In numbers:", *(one.text() for one in self.states)]

    def latex(self) -> str:
        """The same as a LaTeX ``aligned`` block."""
        ring = self.problem.ring
        lines = []
        for x in self.problem.conditions:
            lines.append("&" + r"\ \text{or}\ ".join(equation_latex(f, 0, ring) for f in self._factors(x)))
            if zero := self._excluded(x):
                unless = r"\ \text{or}\ ".join(equation_latex(f, 0, ring) for f in zero)
                lines[-1] += r"\quad\text{unless }" + unless
        lines += ["&" + one.latex() for one in self._found]
        lines += ["&" + latex_words(line) for line in self._handed_over()]
        return "\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}"

    def mathml(self) -> str:
        """The same as presentation MathML, an element each."""
        ring = self.problem.ring
        lines = []
        for x in self.problem.conditions:
            parts = [inner(f, ring) + EQUALS + "<mn>0</mn>" for f in self._factors(x)]
            lines.append(words("  or  ").join(parts))
            if zero := [inner(f, ring) + EQUALS + "<mn>0</mn>" for f in self._excluded(x)]:
                lines[-1] += words("  unless  ") + words("  or  ").join(zero)
        return elements([*lines, *(one._formula() for one in self._found)])

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        head = f"Steady motions of '{self.problem.e.model.name}'"
        if self._given is not None:
            return "\n".join([head, *map(repr, self.states)])
        return f"{head}\n{self.text()}"


def _passes(branch: Branch, end: float, values: Mapping[str, float]) -> bool:
    """Whether a branch goes through a root at one end of its range."""
    for k in (0, -1):
        if abs(branch.parameters[k] - end) > abs(end) / 10**9 + 1 / 10**12:
            continue
        if all(
            abs(column[k] - values[name]) <= (1 + abs(values[name])) / 10**6
            for name, column in branch.values.items()
        ):
            return True
    return False
