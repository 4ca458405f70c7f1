"""Result of an impulse on a machine: speeds just after and impulsive reactions, as expressions or floats.

    M Δu = Jᵀ P + Gᵀ Λ,    G Δu = 0;        Newton's restitution at a point:  n·v⁺ = -e n·v⁻,  P = P n

:func:`freebody.impulse` returns it as a :class:`Struck`.

The file is long because the result is one class with all its products.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import sympy

from ...describe.body import Body
from ...describe.frame import Point
from ...dynamics.conditions.constraint_forces import wrenches
from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.unilateral import MotionWarning, passed_by_impulse
from ...dynamics.energy import kinetic_energy
from ...dynamics.impulse import (
    blows_on,
    generalized_impulse,
    impulsive_reactions,
    state_after,
    with_constraints,
)
from ...dynamics.kinematics import carried, link_twists, point_velocity
from ...dynamics.state import State
from ...errors import ModelError, nearest
from ...model.closure import Closure
from ...model.model import Model
from ...scalar.algebra import ZERO, Scalar, Vector, add, dot, floats, scale
from ...scalar.ratio import Ratio, cleared
from ...scalar.substitute import Substitution
from ..equations import Equations
from ..free_body.gears import undetermined_by_couplings
from ..free_body.reaction import unknowns
from ..printing.fractions import ratio_displayed, ratio_latex, ratio_text
from ..printing.latex import latex_name
from ..printing.show import (
    aligned,
    latex_of,
    latex_words,
    text_of,
)
from ..printing.systems import collect
from ..printing.typeset import Typeset
from ..solving.request import Request
from ..solving.solution import SolveResult
from ..solving.solve import solution_of
from ..solving.vocabulary import Vocabulary
from .impulse_jumps import Jumps


class ImpulsiveReaction(Typeset):
    """Impulse of a joint on its child [N s], and moment impulse about the joint's point on it [N m s], ground axes.

    Attributes
    ----------
    joint, on : str
        The joint, and the child body that the impulses act on.
    impulse, moment : SymPy columns, or tuples of floats
    """

    def __init__(self, struck: Struck, joint: str) -> None:
        self._struck = struck
        self.joint = joint
        impulse, moment, self.on = struck._wrenches[joint]
        self.impulse = struck._column(impulse)
        self.moment = struck._column(moment)

    @cached_property
    def components(self) -> dict[str, Any]:
        """Components by the names of the reaction's components: ``pin_x``."""
        s = self._struck
        if self.joint in s.model.joints:
            return {name: s._show(x) for name, x in s._joint_components(self.joint).items()}
        names = {row.name for row in rows(s.model) if row.owner == self.joint}
        return {name: value for name, value in s.multipliers.items() if name in names}

    def text(self) -> str:
        """The named components, a line each."""
        lines = [f"{name} = {text_of(x)}" for name, x in self.components.items()]
        return "\n".join([*(lines or [repr(self)]), *undetermined_by_couplings(self._struck._e, self.joint)])

    def latex(self) -> str:
        """The named components as a LaTeX ``aligned`` block."""
        return aligned(rf"\hat{{{latex_name(name)}}} &= {latex_of(x)}" for name, x in self.components.items())

    def __repr__(self) -> str:
        parts = [", ".join(map(str, v)) for v in (self.impulse, self.moment)]
        return f"Impulse of joint '{self.joint}' on '{self.on}': ({parts[0]}), moment impulse ({parts[1]})"


class Struck(Typeset):
    """Effect of an impulse. Made by :func:`freebody.impulse`; SymPy expressions for an exact result, else numbers.

    Attributes
    ----------
    before, after, change : dict
        Speeds by name, just before, just after, and their difference.
    impulse, moment : tuple
        Applied impulse in ground axes [N s], [N m s]; with a restitution, the impulse of the impact.
    """

    def __init__(
        self, e: Equations, state: State, jumps: Jumps, blows: Sequence[tuple[Any, Vector, Vector]]
    ) -> None:
        self.model: Model = e.model
        self.exact = state.field is e.ring
        self._e = e
        self._state = state
        self._blows = list(blows)
        f = generalized_impulse(self.model, state, blows_on(self.model, state, blows))
        jump, multipliers = jumps(f)
        self._jump = tuple(self._tidy(x) for x in jump)
        self._multipliers = tuple(self._tidy(x) for x in multipliers)
        self._reached = state_after(self.model, state, self._jump)
        names = self.model.speed_names
        self.before = {n: self._show(x) for n, x in zip(names, state.u, strict=True)}
        self.after = {n: self._show(self._tidy(x)) for n, x in zip(names, self._reached.u, strict=True)}
        self.change = {n: self._show(x) for n, x in zip(names, self._jump, strict=True)}
        self.impulse = tuple(self._show(x) for x in blows[0][1])
        self.moment = tuple(self._show(x) for x in blows[0][2])

    def _tidy(self, x: Scalar) -> Scalar:
        return x.tidy() if type(x) is Ratio else x

    def _show(self, x: Scalar) -> Any:
        return ratio_displayed(x, self._e.ring) if self.exact else float(x)

    def _column(self, v: Sequence[Scalar]) -> Any:
        values = [self._show(self._tidy(x)) for x in v]
        return sympy.ImmutableMatrix(values) if self.exact else tuple(values)

    # -- consequences -------------------------------------------------------------------------------

    @cached_property
    def _link_twists(self) -> list[Any]:
        return link_twists(self.model, self._state, self._jump)

    @cached_property
    def _wrenches(self) -> dict[str, tuple[Vector, Vector, str]]:
        """(impulse, moment, child) of every joint, including joints that close loops."""
        model, state = self.model, self._state
        D, jump, multipliers, blows = self._with_common_denominator()
        everything = with_constraints(model, state, blows, multipliers, 1 if D is None else D)
        jumps = link_twists(model, state, jump)
        joint_impulses = impulsive_reactions(model, state, jumps, blows_on(model, state, everything))
        result = {}
        for name, (impulse, moment) in joint_impulses.items():
            if D is not None:
                impulse, moment = (self._divided(v, D) for v in (impulse, moment))
            result[name] = (impulse, moment, model.joints[name].child)
        for name, joint in model.constraints.items():
            if not isinstance(joint, Closure):
                continue
            force, moment = ZERO, ZERO
            for row, value, pair in zip(rows(model), self._multipliers, wrenches(model, state), strict=True):
                if row.owner == name:
                    force = add(force, scale(value, pair[0][1]))
                    moment = add(moment, scale(value, pair[0][2]))
            result[name] = (force, moment, joint.child.name)
        return result

    def _with_common_denominator(
        self,
    ) -> tuple[Scalar, Sequence[Scalar], Sequence[Scalar], list[tuple[Any, Vector, Vector]]]:
        """Return (D, D Δu, D Λ, D P); with one denominator D, sums stay polynomials. D is None for floats."""
        if not self.exact:
            return None, self._jump, self._multipliers, self._blows
        ring, n, m = self._e.ring, len(self._jump), len(self._multipliers)
        parts = [c for _, impulse, moment in self._blows for c in (*impulse, *moment)]
        everything = [1, *self._jump, *self._multipliers, *parts]
        D, *rest = cleared(ring, [x if type(x) is Ratio else Ratio(ring, x) for x in everything])
        blows = []
        for i, (point, _, _) in enumerate(self._blows):
            a, b, c, d, f, g = rest[n + m + 6 * i : n + m + 6 * i + 6]
            blows.append((point, (a, b, c), (d, f, g)))
        return D, rest[:n], rest[n : n + m], blows

    def _divided(self, v: Vector, D: Scalar) -> Vector:
        x, y, z = (Ratio(self._e.ring, c, D).tidy() for c in v)
        return (x, y, z)

    @cached_property
    def reactions(self) -> Mapping[str, ImpulsiveReaction]:
        """Impulsive reaction of every joint, by its name."""
        return _Reactions(self)

    @cached_property
    def multipliers(self) -> dict[str, Any]:
        """Impulse of each scalar condition by name."""
        names = [row.name for row in rows(self.model)]
        return {name: self._show(x) for name, x in zip(names, self._multipliers, strict=True)}

    @cached_property
    def canonical_components(self) -> dict[str, Scalar]:
        """Value of every named reaction component: ratios, or floats."""
        result: dict[str, Scalar] = {}
        for name in self.model.joints:
            result |= self._joint_components(name)
        for row, value in zip(rows(self.model), self._multipliers, strict=True):
            result[row.name] = value
        return result

    def _joint_components(self, joint: str) -> dict[str, Scalar]:
        """Value of every named component of a joint's reaction."""
        impulse, moment, _ = self._wrenches[joint]
        return {
            name: self._tidy(dot(along, impulse if of_force else moment))
            for name, along, of_force in self._directions(joint)
        }

    def _directions(self, joint: str) -> list[tuple[str, Vector, bool]]:
        """(name, unit vector in ground axes, True for a force) of a joint's reaction components."""
        state = self._state if self.exact else self._e.state
        result = []
        for c in unknowns(self.model, state, joint):
            of_force = any(x != 0 for x in c.force)
            along = c.force if of_force else c.moment
            if not self.exact:
                a, b, d = along
                along = (self._number(a), self._number(b), self._number(d))
            result.append((c.name, along, of_force))
        return result

    @cached_property
    def _number(self) -> Any:
        state = self._state
        values = dict(state.values)
        values[self.model.names.atoms["t"]] = float(state.t)
        values |= {c.symbol: x for c, x in zip(self.model.coordinates, state.q, strict=True)}
        values |= {s.symbol: x for s, x in zip(self.model.speeds, state.u, strict=True)}
        return Substitution(self._e.ring, floats, values)

    @cached_property
    def warnings(self) -> tuple[MotionWarning, ...]:
        """Unilateral constraints whose impulses have the wrong sign, as far as the values are numbers."""
        values = [self._value(x) for x in self._multipliers]
        applied = [self._value(x) for _, *parts in self._blows for v in parts for x in v]
        largest = max((abs(x) for x in (*values, *applied) if x is not None), default=0)
        t = self._value(self._state.t) or 0
        return passed_by_impulse(self.model, values, lambda mu: self._value(self._state(mu)), largest, t)

    def _value(self, x: Scalar) -> float | None:
        """Return the value as a float; None for an expression."""
        shown = self._show(x)
        return float(shown) if not isinstance(shown, sympy.Basic) or shown.is_number else None

    @cached_property
    def energy_change(self) -> Any:
        """Change of the kinetic energy [J]: P·(v⁻ + v⁺)/2 if no motion is prescribed."""
        after = kinetic_energy(self.model, self._reached)
        return self._show(self._tidy(after - kinetic_energy(self.model, self._state)))

    def velocity(self, point: Point | Body) -> tuple[Any, Any]:
        """Velocities of a point just before and just after, in ground axes [m/s]."""
        point = point.origin if isinstance(point, Body) else point
        before = point_velocity(self.model, self._state, point)
        jump = carried(self.model, self._state, point, self._link_twists)
        return self._column(before), self._column(add(before, jump))

    @property
    def initial(self) -> dict[str, Any]:
        """Coordinates and speeds just after, by name: initial values for ``simulate``.

        Raises
        ------
        ModelError
            The state is symbolic.
        """
        names = self.model.coordinate_names
        values = {n: self._show(x) for n, x in zip(names, self._state.q, strict=True)} | self.after
        if self.exact:
            free = {c.symbol for c in self.model.coordinates} | {s.symbol for s in self.model.speeds}
            for name, value in values.items():
                if any(sympy.sympify(value).has(symbol) for symbol in free):
                    raise ModelError(
                        f"The state of this impulse is left open: '{name}' is {value} just after. Give the state, "
                        f"initial={{...}}, and values={{}} for numbers, to go on with a simulation."
                    )
        return values

    # -- questions ----------------------------------------------------------------------------------

    def solve(self, equations: Any, for_: Any) -> SolveResult:
        """Solve equations that hold just after for parameters: ``hit.solve("pin_x = 0", for_="h")``.

        Parameters
        ----------
        equations : text, Eq, or sequence of them
            In parameters, components of the impulsive reactions (``pin_x``), and speeds, meaning those just after.
        for_ : name or sequence of names
            The unknowns.

        Raises
        ------
        ModelError
            A numeric result; requests without a solution, with the equations that remain.
        """
        if not self.exact:
            raise ModelError("This impulse was computed with numbers. Leave out values= to ask for symbols.")
        ring = self._e.ring
        request = Request(self._e)
        request.read_unknowns(for_)
        values = {request.vocabulary.reactions[n]: x for n, x in self.canonical_components.items()}
        values |= {s.symbol: x for s, x in zip(self.model.speeds, self._reached.u, strict=True)}
        places = {}
        for symbol in values:
            (g,) = ring.used(ring.generator(symbol))
            places[g.index] = (str(symbol), symbol, 1)
        for equation in [equations] if isinstance(equations, str | sympy.Basic) else list(equations):
            title, x = request.vocabulary.equation(equation, "the question")
            terms = collect(x, {i: (name, n) for i, (name, _, n) in places.items()}, ring)
            of_name = {name: values[symbol] for name, symbol, _ in places.values()}
            total = Ratio(ring, 0)
            for monomial, c in terms.items():
                for name, n in monomial:
                    for _ in range(n):
                        c = c * of_name[name]
                total = total + c
            request.add(title, total.num)
        return solution_of(request)

    # -- display ------------------------------------------------------------------------------------

    def _written(self, x: Scalar) -> str:
        return ratio_text(self._tidy(x), self._e.ring) if self.exact else f"{float(x):.9g}"

    def text(self) -> str:
        """Speeds before and after, and the impulsive reactions, as plain text."""
        lines = [f"Impulse on '{self.model.name}': speeds just after"]
        for name, x in zip(self.model.speed_names, self._reached.u, strict=True):
            lines.append(f"  {name} = {self._written(x)}")
        notes = [f"not possible: {w.what} ('{w.name}'). {w.law}. {w.cure}" for w in self.warnings]
        if not self._wrenches:
            return "\n".join([*lines, *notes])
        lines.append("impulsive reactions on the child bodies")
        if self.exact:
            parts = {n: x for n, x in self.canonical_components.items() if not _is_zero(x)}
            lines += [f"  {name} = {self._written(x)}" for name, x in parts.items()]
            return "\n".join([*lines, *notes])
        for name, (impulse, moment, _) in self._wrenches.items():
            P, n = (", ".join(map(self._written, v)) for v in (impulse, moment))
            lines.append(f"  {name}:  impulse ({P}), moment impulse ({n})")
        return "\n".join([*lines, *notes])

    def latex(self) -> str:
        """The speeds and the impulsive reactions as a LaTeX ``aligned`` block."""
        vocabulary = Vocabulary(self._e)
        lines = []
        for speed, x in zip(self.model.speeds, self._reached.u, strict=True):
            lines.append(f"{vocabulary.latex(speed.symbol)}^{{+}} &= {self._latex(x)}")
        for name, x in self.canonical_components.items() if self.exact else ():
            if not _is_zero(x):
                lines.append(f"\\hat{{{vocabulary.latex(vocabulary.reactions[name])}}} &= {self._latex(x)}")
        for name, vectors in {} if self.exact else self._wrenches.items():
            for what, v in zip(("impulse", "moment impulse"), vectors, strict=False):
                shown = ",\\ ".join(self._latex(x) for x in v)
                lines.append(rf"&{latex_words(f'{name}: {what} ')}\left({shown}\right)")
        return aligned(lines)

    def _latex(self, x: Scalar) -> str:
        return ratio_latex(self._tidy(x), self._e.ring) if self.exact else f"{float(x):.9g}"

    def __repr__(self) -> str:
        return self.text()


def _is_zero(x: Scalar) -> bool:
    return bool(x == 0)


class _Reactions(Mapping[str, ImpulsiveReaction]):
    """Impulsive reactions by joint."""

    def __init__(self, struck: Struck) -> None:
        self._s = struck

    def __getitem__(self, name: str) -> ImpulsiveReaction:
        s = self._s
        if name not in s._wrenches:
            raise ModelError(f"Unknown joint '{name}'; {nearest(str(name), list(s._wrenches))}")
        return ImpulsiveReaction(s, name)

    def __contains__(self, name: object) -> bool:
        return name in self._s._wrenches

    def __iter__(self) -> Iterator[str]:
        return iter(self._s._wrenches)

    def __len__(self) -> int:
        return len(self._s._wrenches)
