"""Impulses on a machine, exactly: speeds just after and impulsive reactions as expressions.

    M Δu = Jᵀ P + Gᵀ Λ,    G Δu = 0;        Newton's restitution at a point:  n·v⁺ = -e n·v⁻,  P = P n

One :class:`Struck` holds the outcome, of exact symbols or of floats; :func:`freebody.impulse` makes it.

The file is longer than others: the outcome is one class with all that is asked of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import sympy

from ...describe.body import Body
from ...describe.frame import Point
from ...dynamics.constraints import rows, wrenches
from ...dynamics.energy import kinetic_energy
from ...dynamics.impulse import (
    blows_on,
    generalized_impulse,
    impulsive_reactions,
    link_jumps,
    point_jump,
    state_after,
    with_constraints,
)
from ...dynamics.kinematics import point_velocity
from ...dynamics.state import State
from ...dynamics.unilateral import MotionWarning, passed_by_impulse
from ...errors import ModelError, nearest
from ...model.closure import Closure
from ...model.model import Model
from ...scalar.algebra import ZERO, Vector, add, dot, floats, scale
from ...scalar.ratio import Ratio, cleared
from ...scalar.substitute import Substitution
from ..equations import Equations
from ..free_body.gears import left_open
from ..free_body.reaction import unknowns
from ..printing.fractions import ratio_displayed, ratio_latex, ratio_mathml, ratio_text
from ..printing.latex import latex_name
from ..printing.show import (
    EQUALS,
    aligned,
    elements,
    latex_of,
    latex_words,
    mathml_of,
    shown_name,
    text_of,
    words,
)
from ..printing.systems import collect
from ..solving.request import Request
from ..solving.solution import SolveResult
from ..solving.solve import answer
from ..solving.vocabulary import Vocabulary
from .impulse_jumps import Jumps


class ImpulsiveReaction:
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
        """The named components, as those of the reactions: ``pin_x``."""
        s = self._struck
        if self.joint in s.model.joints:
            return {name: s._show(x) for name, x in s._joint_components(self.joint).items()}
        names = {row.name for row in rows(s.model) if row.owner == self.joint}
        return {name: value for name, value in s.multipliers.items() if name in names}

    def text(self) -> str:
        """The named components, a line each."""
        lines = [f"{name} = {text_of(x)}" for name, x in self.components.items()]
        return "\n".join([*(lines or [repr(self)]), *left_open(self._struck._e, self.joint)])

    def latex(self) -> str:
        """The named components as a LaTeX ``aligned`` block."""
        return aligned(rf"\hat{{{latex_name(name)}}} &= {latex_of(x)}" for name, x in self.components.items())

    def mathml(self) -> str:
        """The named components as presentation MathML, an element each."""
        return elements(
            f"<mover>{shown_name(name)}<mo>^</mo></mover>{EQUALS}{mathml_of(x)}"
            for name, x in self.components.items()
        )

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        parts = [", ".join(map(str, v)) for v in (self.impulse, self.moment)]
        return f"Impulse of joint '{self.joint}' on '{self.on}': ({parts[0]}), moment impulse ({parts[1]})"


class Struck:
    """What an impulse does. Made by :func:`freebody.impulse`; numbers, or SymPy expressions of an exact result.

    Attributes
    ----------
    before, after, change : dict
        Speeds by name, just before, just after, and their difference.
    impulse, moment : tuple
        What was applied, in ground axes [N s], [N m s]; with a restitution, what the impact comes to.
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

    def _tidy(self, x: Any) -> Any:
        return x.tidy() if type(x) is Ratio else x

    def _show(self, x: Any) -> Any:
        return ratio_displayed(x, self._e.ring) if self.exact else float(x)

    def _column(self, v: Sequence[Any]) -> Any:
        values = [self._show(self._tidy(x)) for x in v]
        return sympy.ImmutableMatrix(values) if self.exact else tuple(values)

    # -- what follows -------------------------------------------------------------------------------

    @cached_property
    def _link_jumps(self) -> list[Any]:
        return link_jumps(self.model, self._state, self._jump)

    @cached_property
    def _wrenches(self) -> dict[str, tuple[Vector, Vector, str]]:
        """(impulse, moment, child) of every joint, those that close loops included."""
        model, state = self.model, self._state
        D, jump, multipliers, blows = self._over_one()
        everything = with_constraints(model, state, blows, multipliers, 1 if D is None else D)
        jumps = link_jumps(model, state, jump)
        found = impulsive_reactions(model, state, jumps, blows_on(model, state, everything))
        result = {}
        for name, (impulse, moment) in found.items():
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

    def _over_one(self) -> tuple[Any, Sequence[Any], Sequence[Any], list[tuple[Any, Vector, Vector]]]:
        """(D, D Δu, D Λ, D P): with one denominator, sums stay polynomials. D is None for floats."""
        if not self.exact:
            return None, self._jump, self._multipliers, self._blows
        ring, n, m = self._e.ring, len(self._jump), len(self._multipliers)
        parts = [c for _, impulse, moment in self._blows for c in (*impulse, *moment)]
        everything = [1, *self._jump, *self._multipliers, *parts]
        D, *rest = cleared(ring, [x if type(x) is Ratio else Ratio(ring, x) for x in everything])
        blows = []
        for i, (where, _, _) in enumerate(self._blows):
            a, b, c, d, f, g = rest[n + m + 6 * i : n + m + 6 * i + 6]
            blows.append((where, (a, b, c), (d, f, g)))
        return D, rest[:n], rest[n : n + m], blows

    def _divided(self, v: Vector, D: Any) -> Vector:
        x, y, z = (Ratio(self._e.ring, c, D).tidy() for c in v)
        return (x, y, z)

    @cached_property
    def reactions(self) -> Mapping[str, ImpulsiveReaction]:
        """Impulsive reaction of every joint, by its name."""
        return _Reactions(self)

    @cached_property
    def multipliers(self) -> dict[str, Any]:
        """Impulse of each scalar constraint by name."""
        names = [row.name for row in rows(self.model)]
        return {name: self._show(x) for name, x in zip(names, self._multipliers, strict=True)}

    @cached_property
    def canonical_components(self) -> dict[str, Any]:
        """Value of every named reaction component: ratios, or floats."""
        result: dict[str, Any] = {}
        for name in self.model.joints:
            result |= self._joint_components(name)
        for row, value in zip(rows(self.model), self._multipliers, strict=True):
            result[row.name] = value
        return result

    def _joint_components(self, joint: str) -> dict[str, Any]:
        impulse, moment, _ = self._wrenches[joint]
        return {
            name: self._tidy(dot(along, impulse if of_force else moment))
            for name, along, of_force in self._directions(joint)
        }

    def _directions(self, joint: str) -> list[tuple[str, Vector, bool]]:
        """(name, unit vector in ground axes, whether of the force) of a joint's reaction components."""
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
        """One-sided constraints that would have to push or pull the wrong way, as far as there are numbers."""
        values = [self._value(x) for x in self._multipliers]
        outside = [self._value(x) for _, *parts in self._blows for v in parts for x in v]
        largest = max((abs(x) for x in (*values, *outside) if x is not None), default=0)
        t = self._value(self._state.t) or 0
        return passed_by_impulse(self.model, values, lambda mu: self._value(self._state(mu)), largest, t)

    def _value(self, x: Any) -> float | None:
        """A number; None for an expression."""
        shown = self._show(x)
        return float(shown) if not isinstance(shown, sympy.Basic) or shown.is_number else None

    @cached_property
    def energy_change(self) -> Any:
        """Change of the kinetic energy [J]: P·(v⁻ + v⁺)/2 where nothing is driven."""
        after = kinetic_energy(self.model, self._reached)
        return self._show(self._tidy(after - kinetic_energy(self.model, self._state)))

    def velocity(self, point: Point | Body) -> tuple[Any, Any]:
        """Velocity of a point just before and just after, in ground axes [m/s]."""
        point = point.origin if isinstance(point, Body) else point
        before = point_velocity(self.model, self._state, point)
        jump = point_jump(self.model, self._state, self._link_jumps, point)
        return self._column(before), self._column(add(before, jump))

    @property
    def initial(self) -> dict[str, Any]:
        """Coordinates, and the speeds just after, by name: where the next ``simulate`` begins.

        Raises
        ------
        ModelError
            A state that was left symbolic.
        """
        names = self.model.coordinate_names
        values = {n: self._show(x) for n, x in zip(names, self._state.q, strict=True)} | self.after
        if self.exact:
            free = {c.symbol for c in self.model.coordinates} | {s.symbol for s in self.model.speeds}
            for name, value in values.items():
                held = [c for c in free if sympy.sympify(value).has(c)]
                if held:
                    raise ModelError(
                        f"The state of this impulse is left open: '{name}' is {value} just after. Give the state, "
                        f"initial={{...}}, and values={{}} for numbers, to go on with a simulation."
                    )
        return values

    # -- questions ----------------------------------------------------------------------------------

    def solve(self, equations: Any, for_: Any) -> SolveResult:
        """Parameters for which something holds just after: ``hit.solve("pin_x = 0", for_="h")``.

        Parameters
        ----------
        equations : text, Eq, or sequence of them
            In parameters, components of the impulsive reactions (``pin_x``), and speeds, which stand for those just
            after.
        for_ : name or sequence of names
            The unknowns.

        Raises
        ------
        ModelError
            A numeric result; requests that can not be met, with what was left.
        """
        if not self.exact:
            raise ModelError("This impulse was computed with numbers. Leave out values= to ask for symbols.")
        ring = self._e.ring
        request = Request(self._e)
        request.ask(for_)
        values = {request.vocabulary.reactions[n]: x for n, x in self.canonical_components.items()}
        values |= {s.symbol: x for s, x in zip(self.model.speeds, self._reached.u, strict=True)}
        places = {}
        for symbol in values:
            (g,) = ring.used(ring.generator(symbol))
            places[g.index] = (str(symbol), symbol, 1)
        given = [equations] if isinstance(equations, str | sympy.Basic) else list(equations)
        for one in given:
            title, x = request.vocabulary.equation(one, "the question")
            terms = collect(x, {i: (name, n) for i, (name, _, n) in places.items()}, ring)
            of_name = {name: values[symbol] for name, symbol, _ in places.values()}
            total = Ratio(ring, 0)
            for monomial, c in terms.items():
                for name, n in monomial:
                    for _ in range(n):
                        c = c * of_name[name]
                total = total + c
            request.add(title, total.num)
        return answer(request)

    # -- display ------------------------------------------------------------------------------------

    def _written(self, x: Any) -> str:
        return ratio_text(self._tidy(x), self._e.ring) if self.exact else f"{float(x):.9g}"

    def text(self) -> str:
        """Speeds before and after, and the impulsive reactions, as plain text."""
        lines = [f"Impulse on '{self.model.name}': speeds just after"]
        for name, x in zip(self.model.speed_names, self._reached.u, strict=True):
            lines.append(f"  {name} = {self._written(x)}")
        told = [f"not possible: {one.what} ('{one.name}'). {one.law}. {one.cure}" for one in self.warnings]
        if not self._wrenches:
            return "\n".join([*lines, *told])
        lines.append("impulsive reactions on the child bodies")
        if self.exact:
            parts = {n: x for n, x in self.canonical_components.items() if not _zero(x)}
            lines += [f"  {name} = {self._written(x)}" for name, x in parts.items()]
            return "\n".join([*lines, *told])
        for name, (impulse, moment, _) in self._wrenches.items():
            P, n = (", ".join(map(self._written, v)) for v in (impulse, moment))
            lines.append(f"  {name}:  impulse ({P}), moment impulse ({n})")
        return "\n".join([*lines, *told])

    def latex(self) -> str:
        """The same as a LaTeX ``aligned`` block."""
        ring = self._e.ring
        vocabulary = Vocabulary(self._e)
        lines = []
        for speed, x in zip(self.model.speeds, self._reached.u, strict=True):
            lines.append(f"{vocabulary.latex(speed.symbol)}^{{+}} &= {self._latex(x, ring)}")
        for name, x in self.canonical_components.items() if self.exact else ():
            if not _zero(x):
                lines.append(
                    f"\\hat{{{vocabulary.latex(vocabulary.reactions[name])}}} &= {self._latex(x, ring)}"
                )
        for name, vectors in {} if self.exact else self._wrenches.items():
            for what, v in zip(("impulse", "moment impulse"), vectors, strict=False):
                shown = ",\\ ".join(self._latex(x, ring) for x in v)
                lines.append(rf"&{latex_words(f'{name}: {what} ')}\left({shown}\right)")
        return "\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}"

    def mathml(self) -> str:
        """The same as presentation MathML, an element each."""
        lines = []
        for speed, x in zip(self.model.speeds, self._reached.u, strict=True):
            lines.append(f"<msup>{mathml_of(speed.symbol)}<mo>+</mo></msup>{EQUALS}{self._mathml(x)}")
        if self.exact:
            for name, x in self.canonical_components.items():
                if not _zero(x):
                    lines.append(f"<mover>{shown_name(name)}<mo>^</mo></mover>{EQUALS}{self._mathml(x)}")
        for name, vectors in {} if self.exact else self._wrenches.items():
            for what, v in zip(("impulse", "moment impulse"), vectors, strict=False):
                shown = "<mo>,</mo>".join(map(self._mathml, v))
                lines.append(f"{words(f'{name}: {what} ')}<mrow><mo>(</mo>{shown}<mo>)</mo></mrow>")
        return elements(lines)

    def _mathml(self, x: Any) -> str:
        if self.exact:
            return ratio_mathml(self._tidy(x), self._e.ring)
        return f"<mn>{float(x):.9g}</mn>"

    def _latex(self, x: Any, ring: Any) -> str:
        return ratio_latex(self._tidy(x), ring) if self.exact else f"{float(x):.9g}"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        return self.text()


def _zero(x: Any) -> bool:
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
