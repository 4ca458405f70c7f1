"""Free-body equations of one body, with every force and moment by name: F = m a_C and M = dH/dt.

    Σ F = m a_C,        Σ M_P = dH_C/dt + r_PC × m a_C

The second holds about any point P, moving or not. Source: chapter 6, eqs (6.3), (6.24), (6.25).

The forces and their balance are in :mod:`freebody.symbolic.free_body.balance`; this file has the products for users.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any

import sympy

from ...errors import ModelError, TooManyTermsError, nearest
from ...scalar.algebra import ZERO, Expression, Vector
from ...scalar.budget import WORK
from ...scalar.polynomial import Polynomial
from ...scalar.substitute import Substitution
from ..derivation.bodies import own_body
from ..derivation.derivation import Derivation
from ..derivation.questions import named
from ..printing.display import equation_latex, equation_text, text
from ..printing.latex import Latex
from ..printing.printer import Printer
from ..printing.show import aligned, latex_words
from ..printing.text import Text
from ..printing.typeset import Typeset
from .action import TITLES, Action, action_lines
from .balance import BodyBalance
from .moment_form import MomentForm
from .named_quantities import NamedDerivation
from .planar import planar_equations, planar_latex, planar_text, plane_in

MOST = 1000
"""Most terms of the equations of one body that are still written out, about two pages."""


@named("the free body")
def free_body(e: Derivation, body: Any, about: Any = None, frame: Any = None) -> FreeBody:
    """Return the free body of a body of the model; see :meth:`Equations.free_body`."""
    name = body if isinstance(body, str) else own_body(e.model, body, "a free body").name
    if name not in e.model.bodies:
        raise ModelError(f"Unknown body '{name}'; {nearest(str(name), e.model.bodies)}")
    return FreeBody(e, name, about, frame)


class FreeBody(BodyBalance, Typeset):
    """Free-body diagram and kinetic diagram of one body, as equations. Made by :meth:`Equations.free_body`."""

    @cached_property
    @named("the free body")
    def equations(self) -> tuple[Any, ...]:
        """Three force equations, then three moment equations, as SymPy ``Eq``."""
        sym = self._e.displayed
        return tuple(sympy.Eq(sym(left), sym(right), evaluate=False) for left, right in self.balances)

    @cached_property
    def planar_equations(self) -> tuple[Any, ...]:
        """Two force equations and one moment equation of a planar model, as SymPy ``Eq``.

        Planar motion is recognised, not declared (:mod:`freebody.symbolic.free_body.planar`).

        Raises
        ------
        ModelError
            The model is not planar, with the reason.
        """
        return planar_equations(self)

    def at(self, values: Mapping[str, Expression]) -> FreeBody:
        """The same equations with values for some coordinates, speeds, accelerations and reactions.

        Parameters
        ----------
        values : mapping
            By name, ``{"x": 0, "x'": 0, "x''": 0}``: numbers or expressions.

        Returns
        -------
        FreeBody
        """
        return FreeBodyAt(self, values)

    def moment_form(self, about: Any) -> MomentForm:
        """Moment equations about a point A by its acceleration: M_A = ρ × m a_A + I_A α + ω × I_A ω.

        Parameters
        ----------
        about : Point, Body or name of a joint
            Any point, moving or not; for a joint, its point on this body.

        Returns
        -------
        MomentForm
            ``.terms`` by name, ``.equations``, ``.proven``, ``.text()``, ``.latex()``.
        """
        return MomentForm(self, about)

    @cached_property
    @named("the free body")
    def forces(self) -> Mapping[str, Any]:
        """Force of each action by name, as a SymPy column in the axes of the components [N]."""
        return {a.name: self._e.column(self._in_axes(a.force)) for a in self.actions if a.force != ZERO}

    @cached_property
    @named("the free body")
    def moments(self) -> Mapping[str, Any]:
        """Moment of each action about the point of the moments, by name, as a SymPy column [N m]."""
        result = {}
        for a in self.actions:
            moment = self._in_axes(a.about(self._about))
            if any(c != 0 for c in moment):
                result[a.name] = self._e.column(moment)
        return result

    @cached_property
    def unknowns(self) -> tuple[Any, ...]:
        """Symbols of the reaction components that act on this body."""
        return tuple(sympy.Symbol(a.name, real=True) for a in self.actions if a.kind == "reaction")

    @cached_property
    def in_names(self) -> FreeBody | None:
        """The same free body in named quantities if it is too long to be written out, else None."""
        e = self._e
        form = getattr(e, "_requested_form", "explicit")
        if form == "explicit" or self.frame != "ground" or self._about != self._centre:
            return None
        if form == "auto":
            try:
                # intermediate elements may be longer than the final ones
                with e.ring.budget.question("the free body", terms=4 * MOST, work=WORK // 32):
                    sides = [x for pair in self.balances for x in pair]
                if sum(len(x) for x in sides if type(x) is Polynomial) <= MOST:
                    return None
            except TooManyTermsError:
                pass
        return FreeBody(NamedDerivation(e.model, e.chosen), self.body)

    def _meanings(self, kind: type[Printer], sign: str) -> list[tuple[str, list[str]]]:
        """Return (heading, lines) of the names in the equations; [] without such names."""
        if not isinstance(self._e, NamedDerivation):
            return []
        loads = [x for a in self.actions for x in (*self._in_axes(a.force), *self._in_axes(a.moment))]
        return self._e.meanings([*loads, *(x for pair in self.balances for x in pair)], kind, sign)

    def _written(self, v: Vector) -> str:
        """Components of a vector as text."""
        return f"({', '.join(text(c, self._e.ring) for c in self._in_axes(v))})"

    @named("the free body")
    def text(self) -> str:
        """The forces by name and the equations as plain text; for a planar model, the equations in the plane.

        Names stand for the motion of bodies if the equations would fill pages; their meanings come last.
        """
        if not isinstance(self._e, NamedDerivation):
            if not isinstance(plane_in(self), str):
                return planar_text(self)
            if self.in_names is not None:
                return self.in_names.text()
        ring = self._e.ring
        lines = [
            *self._e.heading,
            f"Free body '{self.body}': components in {self.frame} axes, moments about {self.about}",
        ]
        lines += action_lines(self.actions, self._written, self._written)
        for title, (left, right) in zip(TITLES, self.balances, strict=True):
            if not (left == 0 and right == 0):
                lines.append(f"  {title}:  {equation_text(left, right, ring)}")
        meanings = [
            x for head, rows in self._meanings(Text, " = ") for x in (head, *(f"  {row}" for row in rows))
        ]
        return "\n".join([*lines, *self.remarks(), *meanings])

    @named("the free body")
    def latex(self) -> str:
        """The equations as a LaTeX ``aligned`` block, with names as in `text`; for a planar model, in the plane."""
        if not isinstance(self._e, NamedDerivation):
            if not isinstance(plane_in(self), str):
                return planar_latex(self)
            if self.in_names is not None:
                return self.in_names.latex()
        ring = self._e.ring
        rows = [
            equation_latex(left, right, ring).replace(" = ", " &= ", 1)
            for left, right in (*self.balances, *self.laws)
            if not (left == 0 and right == 0)
        ]
        above = [f"&{latex_words(line)}" for line in self._e.heading]
        for head, lines in self._meanings(Latex, " &= "):
            rows += [f"&{latex_words(head)}", *lines]
        return aligned([*above, *rows])

    def __repr__(self) -> str:
        return self.text()


class FreeBodyAt(FreeBody):
    """A free body with values for some coordinates, speeds, accelerations and reactions. Made by :meth:`FreeBody.at`.

    While contacts are closed, some coordinates are constant. With their values, the directions of N and T are short;
    the general directions hold for any configuration and are long.
    """

    def __init__(self, whole: FreeBody, values: Mapping[str, Expression]) -> None:
        e = whole._e
        super().__init__(e, whole.body)
        self.in_names = None
        self._about, self.about, self.frame, self._axes = whole._about, whole.about, whole.frame, whole._axes
        atoms = {str(name): atom for name, atom in e.model.names.atoms.items()}
        for speed in e.model.speeds:
            atoms[speed.name + "'"] = speed.acceleration
        atoms |= {symbol.name: symbol for symbol in whole.unknowns}
        for name in values:
            if name not in atoms:
                raise ModelError(
                    f"Unknown coordinate, speed or reaction '{name}'; {nearest(name, list(atoms))}"
                )
        substituted = {atoms[name]: e.ring.from_sympy(sympy.sympify(value)) for name, value in values.items()}
        self._substitution = Substitution(e.ring, e.ring, substituted)

    def _at(self, v: Vector) -> Vector:
        x, y, z = (self._substitution(c) for c in v)
        return (x, y, z)

    @cached_property
    def actions(self) -> tuple[Action, ...]:
        """Every force and couple on the body, by name."""
        actions = (
            replace(a, force=self._at(a.force), moment=self._at(a.moment), at=self._at(a.at))
            for a in super().actions
        )
        return tuple(a for a in actions if (a.force, a.moment) != (ZERO, ZERO))

    @cached_property
    def mass_acceleration(self) -> Vector:
        """m a_C in the axes of the components [N], canonical."""
        return self._at(super().mass_acceleration)

    @cached_property
    def momentum_rate(self) -> Vector:
        """dH_C/dt + r_PC × m a_C about the point P of the moments [N m], canonical."""
        return self._at(super().momentum_rate)

    @cached_property
    def force_sum(self) -> Vector:
        """Σ F in the axes of the components [N], canonical."""
        return self._at(super().force_sum)

    @cached_property
    def moment_sum(self) -> Vector:
        """Σ M about the point P of the moments [N m], canonical."""
        return self._at(super().moment_sum)
