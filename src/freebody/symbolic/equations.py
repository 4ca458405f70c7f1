"""Equations of a model, formed exactly and printed as in a textbook.

    M(q) u' + h(q, u, t) = Q

The class is a facade: its base class :class:`~freebody.symbolic.derivation.derivation.Derivation` forms the canonical
polynomials, the other inner rooms form the products. Text, LaTeX and MathML are printed straight from the polynomials;
SymPy expressions are built only where a SymPy object is returned.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import sympy

from ..describe.system import System
from ..errors import ModelError, TooManyTermsError, arguments_named, nearest
from ..model.assemble import assemble
from ..model.model import Model
from ..scalar.algebra import Expression, Scalar, Vector
from ..scalar.budget import WORK
from ..scalar.polynomial import Polynomial
from .derivation.contact_modes import model_in_modes, modes_in_words
from .derivation.derivation import Derivation
from .derivation.questions import named
from .free_body.constraints import eliminated, indeterminate
from .free_body.free_body import FreeBody, free_body
from .free_body.planar import Plane, plane_of
from .free_body.reactions import Reactions
from .integrals.conserved_quantities import Integrals, integrals
from .integrals.routh import Routh, routh
from .printing.arrange import PRINTED
from .printing.closed.abbreviations import abbreviated, groups
from .printing.closed.answers import closed as shortest
from .printing.display import displayed, lines_of
from .printing.latex import Latex
from .printing.printer import Printer
from .printing.show import latex_words
from .printing.text import Text
from .printing.typeset import Typeset
from .solving.eliminate import Elimination, eliminate
from .solving.solution import SolveResult
from .solving.solve import solve

FORMS = ("auto", "explicit", "recursive")
PAGE = 5000
"""Most terms of all equations of motion together that are still written out, about ten pages."""


@arguments_named
def equations(
    system: System | Model, *, modes: Mapping[str, Any] | None = None, form: str = "auto"
) -> Equations:
    """Return the equations of a system with its contacts in ``modes``, all open by default, printed in a ``form``.

    :func:`freebody.equations` finds the modes in which the motion starts.
    """
    model = system if isinstance(system, Model) else assemble(system)
    return Equations(model_in_modes(model, modes), form)


class Equations(Derivation, Typeset):
    """Symbolic products of one model. Made by :func:`equations`; every product is formed once, when asked for."""

    def __init__(self, model: Model, form: str = "auto", chosen: str = "") -> None:
        if form not in FORMS:
            raise ModelError(f"Unknown form {form!r} of equations; {nearest(str(form), FORMS)}")
        super().__init__(model, chosen)
        self._requested_form = form

    def __reduce__(self) -> Any:
        """Pickle and copy the model alone; the copy forms its products anew, when asked for."""
        return type(self), (self.model, self._requested_form, self.chosen)

    @cached_property
    def form(self) -> str:
        """Form in which the equations of motion are printed: "explicit" or "recursive"."""
        if self._requested_form != "auto":
            return self._requested_form
        try:
            # intermediate elements may be longer than the final ones
            with self.ring.budget.question("the equations of motion", terms=4 * PAGE, work=WORK // 8):
                sides = [x for pair in self.balances for x in pair] + self._residuals
            if sum(len(x) for x in sides if type(x) is Polynomial) <= PAGE:
                return "explicit"
        except TooManyTermsError:
            pass
        try:
            return "recursive" if self.recursive else ""
        except TooManyTermsError:
            return "explicit"

    @cached_property
    def definitions(self) -> Mapping[Any, Any]:
        """Symbols of the named quantities and their values as SymPy expressions, in order; empty in explicit form."""
        if self._requested_form != "recursive":
            return {}
        ring = self.recursive.ring
        return {d.symbol: displayed(d.value, ring) for d in self.recursive.definitions if d.angle is None}

    @cached_property
    def coordinates(self) -> tuple[Any, ...]:
        """Coordinates q as SymPy functions of time."""
        return tuple(coordinate.symbol for coordinate in self.model.coordinates)

    @cached_property
    def speeds(self) -> tuple[Any, ...]:
        """Speeds u: derivatives of the coordinates; for ball and free joints, functions of time of their own."""
        return tuple(speed.symbol for speed in self.model.speeds)

    # -- equations of motion and constraints ------------------------------------------------------

    @cached_property
    @named("the mass matrix")
    def mass_matrix(self) -> Any:
        """M as a SymPy matrix, (n_u, n_u): kinetic energy ½ uᵀ M u [kg, kg m, kg m²]."""
        n = self.model.n_u
        return sympy.ImmutableMatrix(
            n, n, [self.displayed(x) for row in self.canonical_mass_matrix for x in row]
        )

    @cached_property
    @named("the velocity terms")
    def bias(self) -> Any:
        """h - Q as a SymPy column, (n_u, 1): M u' + bias = 0."""
        pairs = zip(self.canonical_bias, self.canonical_applied, strict=True)
        return sympy.ImmutableMatrix([self.displayed(h - Q) for h, Q in pairs])

    @cached_property
    @named("the equations of motion")
    def motion(self) -> tuple[Any, ...]:
        """Equations of motion M u' + h = Q, one SymPy ``Eq`` per degree of freedom, in coordinate order.

        Accelerations, velocity terms, weight, springs and dampers are on the left, applied loads on the right.
        """
        if self._requested_form == "recursive":
            pairs = [(displayed(x, self.recursive.ring), 0) for x in self.recursive.balances]
        else:
            pairs = [(self.displayed(a), self.displayed(b)) for a, b in self.balances]
        return tuple(sympy.Eq(a, b, evaluate=False) for a, b in pairs)

    @cached_property
    @named("the constraints")
    def constraints(self) -> tuple[Any, ...]:
        """The constraints as SymPy ``Eq``: on coordinates and, for non-holonomic ones, on speeds.

        Conditions that hold identically (out of the plane of a planar loop) are omitted.
        """
        return tuple(sympy.Eq(self.displayed(x), 0, evaluate=False) for x in self._residuals)

    @cached_property
    @named("the matrix of the constraints")
    def constraint_matrix(self) -> Any:
        """G as a SymPy matrix, a row per scalar condition G u + g = 0; the constraint forces are Gᵀ λ."""
        entries = [self.displayed(x) for row in self.conditions.matrix for x in row]
        return sympy.ImmutableMatrix(len(self.condition_names), self.model.n_u, entries)

    @cached_property
    @named("the constraints")
    def constraint_bias(self) -> Any:
        """γ as a SymPy column: G u' + γ = 0."""
        return sympy.ImmutableMatrix(
            len(self.condition_names), 1, [self.displayed(x) for x in self.conditions.bias]
        )

    @named("the equations without multipliers")
    def eliminated(self, independent: Sequence[Any]) -> tuple[Any, ...]:
        """Equations of motion without multipliers, one per independent speed.

            Nᵀ (M u' + h - Q) = 0   with   G N = 0

        N is formed without division, so each equation carries the determinant of the dependent block of G.

        Parameters
        ----------
        independent : sequence of coordinates or speeds
            As many as the machine has degrees of freedom.
        """
        return tuple(sympy.Eq(self.displayed(x), 0, evaluate=False) for x in eliminated(self, independent))

    def indeterminate(
        self, near: Mapping[Any, Expression] | None = None, values: Mapping[Any, Expression] | None = None
    ) -> tuple[str, ...]:
        """Names of the reaction components that the motion does not determine.

        Redundant constraints share a load in a way that rigid bodies do not determine, for example out of the plane of
        a planar linkage. The rank of the constraint matrix at a closed position shows them.

        Parameters
        ----------
        near : mapping, optional
            Approximate closed configuration: coordinates by name, zero by default. Singular configurations, such as
            bars in one line, have more indeterminate reactions than others.
        values : mapping, optional
            Values of parameters in place of their defaults.

        Returns
        -------
        tuple of str
            Multipliers first, then components of the other joints (as in ``free_body``).

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("door")
        >>> door = s.body("door", fb.box(20, (1, 2, 0.1)))
        >>> upper = s.hinge("upper", s.ground, door, at=(0, 1.5, 0), to=(0.5, 0.5, 0), axis="y", coordinate="turn")
        >>> lower = s.hinge("lower", s.ground, door, at=(0, 0.5, 0), to=(0.5, -0.5, 0), axis="y")
        >>> names = fb.equations(s).indeterminate()
        >>> [name for name in names if name.startswith("upper")]
        ['upper_x', 'upper_y', 'upper_z', 'upper_Mx', 'upper_Mz']
        """
        return indeterminate(self, near, values)

    # -- products of the inner rooms --------------------------------------------------------------

    @cached_property
    def reactions(self) -> Reactions:
        """Reaction of every joint on its child body as a function of q, u and u', by the joint's name.

        Reactions of closed contacts, on their features, are included under the contact's name.
        """
        return Reactions(self)

    @property
    def canonical_reactions(self) -> dict[str, tuple[Vector, Vector]]:
        """(force, moment) of every joint on its child in ground axes, canonical."""
        return self.reactions.canonical

    def canonical_components(self, joint: str) -> dict[Any, Scalar]:
        """Value of each unknown of a joint's reaction by its symbol, canonical."""
        return self.reactions.canonical_components(joint)

    @cached_property
    @named("the conserved quantities")
    def integrals(self) -> Integrals:
        """Conserved quantities, each proven by a derivative that is canonically zero."""
        return integrals(self)

    @named("Routh's equations")
    def routh(self) -> Routh:
        """Routh's reduction: ignorable coordinates eliminated, their momenta as symbols."""
        return routh(self)

    def free_body(self, body: Any, *, about: Any = None, frame: Any = None) -> FreeBody:
        """Free-body equations of one body, with the joint reactions as unknowns.

        Parameters
        ----------
        body : str or Body
        about : Point or Body, optional
            Point about which moments are taken, the mass centre by default. It may move.
        frame : str or Body, optional
            Axes of the components, ground axes by default.
        """
        return free_body(self, body, about, frame)

    @property
    @named("the plane of motion")
    def planar(self) -> str | None:
        """Ground axis at right angles to the plane in which all bodies move, "x", "y" or "z"; None without a plane."""
        plane = plane_of(self)
        return plane.letter if isinstance(plane, Plane) else None

    @named("the solution")
    def solve(
        self, unknowns: Any, where: Any = None, *, bodies: Any = None, eliminate: Any = ()
    ) -> SolveResult:
        """Solve the free-body equations for unknowns, exactly, or refuse with the equations that remain.

        Parameters
        ----------
        unknowns : name, SymPy expression, or sequence of them
            Reaction components ``"pin_x"``, parameters, accelerations ``"theta''"``, speeds or their squares
            ``"theta'^2"``, coordinates (through their sine and cosine). Other reactions are eliminated. Other
            accelerations remain in the solution, since the reactions depend on the motion; but they are eliminated too
            if the unknowns are parameters, coordinates and speeds alone, or if a contact of a planar machine is closed.
        where : mapping, equation, text, or sequence of them, optional
            Values by name, ``{"pin_y": 0, "theta'": 0}``, and further equations, ``"T = mu*N"`` or ``Eq(T, mu*N)``.
        bodies : sequence of names or FreeBody, optional
            The free bodies whose equations are used; by default all of them, in ground axes.
        eliminate : sequence of names, optional
            Further unknowns to eliminate from the solution.

        Returns
        -------
        SolveResult
            ``result["pin_x"]``, ``.branches`` (all solutions), ``.conditions``, ``.text()``, ``.latex()``.

        Raises
        ------
        ModelError
            Under- or over-determined requests, with the equations that remain; requests without a closed form;
            unknown names.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("pendulum")
        >>> m, L, g = s.parameters(m=1, L=1, g=9.81)
        >>> s.gravity = (0, -g, 0)
        >>> bob = s.body("bob", fb.particle(m))
        >>> pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), coordinate="theta")
        >>> fb.equations(s).solve("theta'^2", where={"theta": "pi", "pin_y": 0})
        theta'^2 = g/L
        """
        return solve(self, unknowns, where, bodies, eliminate)

    @named("the elimination")
    def eliminate(self, reactions: Any = None, *, bodies: Any = None) -> Elimination:
        """Return the combinations of the free-body equations that are free of reactions, and the resulting equations.

        Parameters
        ----------
        reactions : name or sequence of names, optional
            Components ``"pin_x"``, or joints and constraints with all their components; all reactions by default.
        bodies : sequence of names or FreeBody, optional
            The free bodies that are combined; by default all of them, with moments about their mass centres.

        Returns
        -------
        Elimination
            ``.combination`` (coefficient of each free-body equation, by body and row), ``.equations``,
            ``.text()``, ``.latex()``.

        Raises
        ------
        ModelError
            An unknown reaction, or no combination that is free of the reactions.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("pendulum")
        >>> m, L, g = s.parameters(m=1, L=1, g=9.81)
        >>> s.gravity = (0, -g, 0)
        >>> bob = s.body("bob", fb.particle(m))
        >>> pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), coordinate="theta")
        >>> print(fb.equations(s).eliminate("pin").text())
        Without pin_x, pin_y, pin_z, pin_Mx, pin_My:
        by theta'
            (L*cos(theta)) * [bob: force x]
            (L*sin(theta)) * [bob: force y]
            (1) * [bob: moment z]
          gives  m*L^2*theta'' + m*L*g*sin(theta) = 0
        """
        return eliminate(self, reactions, bodies)

    # -- display ----------------------------------------------------------------------------------

    @named("the equations of motion")
    def _shown(
        self, kind: type[Printer], sign: str, names: Mapping[str, Expression] | None
    ) -> tuple[list[str], list[str]]:
        sides = [*self.balances, *((x, 0) for x in self._residuals)]
        # refuse before the first equation is printed
        self.ring.budget.scan(PRINTED * sum(len(x) for pair in sides for x in pair if type(x) is Polynomial))
        shown, meanings = abbreviated(sides, groups(self, names or {}), self.ring)
        lines, long = lines_of(kind, shown, self.ring, sign)
        printer = kind(self.ring)
        return lines, [
            *(f"{printer.name(n)}{sign}{shortest(kind, x, self.ring)}" for n, x in meanings.items()),
            *long,
        ]

    @cached_property
    def _solved(self) -> SolveResult:
        return self.solve([f"{speed.name}'" for speed in self.model.speeds])

    def _refuse_names(self, names: Mapping[str, Expression] | None, solved: bool) -> None:
        if names and (solved or self.form == "recursive"):
            written = "solved for the accelerations" if solved else "in recursive form"
            raise ModelError(
                f"Expected no names= for equations {written}, got {', '.join(names)}: they name groups of "
                "parameters in equations that are written out; leave one of the two out."
            )

    def text(self, *, solved: bool = False, names: Mapping[str, Expression] | None = None) -> str:
        """The equations of motion as plain text, a line each; then the definitions of the names in them.

        Parameters
        ----------
        solved : bool, optional
            Print the accelerations on the left, each in coordinates and speeds: the solution of `solve`, which refuses
            what has no short closed form.
        names : mapping, optional
            Names for groups of parameters, ``{"I_O": "m*L**2/3"}``, at most four. An equation uses them where it
            becomes shorter; the names that are used are explained below the equations.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("pendulum")
        >>> m, L, g = s.parameters(m=1, L=1, g=9.81)
        >>> s.gravity = (0, -g, 0)
        >>> bar = s.body("bar", fb.slender_bar(m, L))
        >>> pin = s.hinge("pin", s.ground, bar, to=(0, L/2, 0), coordinate="theta")
        >>> print(fb.equations(s).text(solved=True))
        theta'' = -3*g*sin(theta)/(2*L)
        >>> print(fb.equations(s).text(names={"I_O": m*L**2/3}))
        I_O*theta'' + m*L*g*sin(theta)/2 = 0
        where
          I_O = m*L^2/3
        """
        self._refuse_names(names, solved)
        return "\n".join([*self.heading, *([self._solved.text()] if solved else self.lines(names))])

    def lines(self, names: Mapping[str, Expression] | None = None) -> list[str]:
        """The lines of :meth:`text` below the modes of the contacts."""
        if self.form == "recursive":
            parts = self.recursive.written(Text, " = ", self.recursive.formulas)
            return [line for head, lines in parts for line in (head, *(f"  {x}" for x in lines))]
        lines, meanings = self._shown(Text, " = ", names)
        return [*lines, *(["where"] if meanings else []), *(f"  {line}" for line in meanings)]

    def latex(self, *, solved: bool = False, names: Mapping[str, Expression] | None = None) -> str:
        """The equations of motion as a LaTeX ``aligned`` block, with ``solved`` and ``names`` as in `text`."""
        self._refuse_names(names, solved)
        if solved:
            return self._solved.latex()
        if self.form == "recursive":
            parts = self.recursive.written(Latex, " &= ", self.recursive.formulas)
            rows = [line for head, lines in parts for line in (f"&{latex_words(head)}", *lines)]
            return "\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}"
        lines, meanings = self._shown(Latex, " &= ", names)
        above = [f"&{latex_words(line)}" for line in self.heading]
        return "\\begin{aligned}\n" + " \\\\\n".join([*above, *lines, *meanings]) + "\n\\end{aligned}"

    def html(self, *, solved: bool = False, names: Mapping[str, Expression] | None = None) -> str:
        """The equations of motion as HTML that needs no other file, with ``solved`` and ``names`` as in `text`."""
        from ..typesetting.html import block

        return block(self.latex(solved=solved, names=names))

    def __repr__(self) -> str:
        contacts = "" if self.chosen else modes_in_words(self.model)
        return f"Equations of motion of '{self.model.name}'{contacts and f' ({contacts})'}\n{self.text()}"
