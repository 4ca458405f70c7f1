"""Equations of a model, formed exactly and shown as a textbook would.

    M(q) u' + h(q, u, t) = Q

Everything is formed on canonical polynomials when it is first asked for, and printed straight from them;
SymPy expressions are built only where a SymPy object is returned.

The file is longer than others: the equations are one class with all that is asked of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import cached_property
from typing import TYPE_CHECKING, Any

import sympy

from ..describe.body import Body
from ..describe.frame import Point
from ..describe.loads.load import Damper, JointDamper, JointSpring, Spring
from ..describe.system import System
from ..dynamics.constrained import constrained_loading, with_wrenches
from ..dynamics.constraints import Linearized, linearized, rows, wrenches
from ..dynamics.energy import kinetic_energy, potential_energy
from ..dynamics.kinematics import (
    Posture,
    accelerations,
    link_postures,
    point_position,
    poses,
    turning,
    velocities,
)
from ..dynamics.loading import loading
from ..dynamics.momentum import momentum
from ..dynamics.newton_euler import inverse_dynamics, reactions
from ..dynamics.state import State, polynomial_state
from ..errors import ModelError, TooManyTermsError, arguments_named, nearest
from ..model.assemble import assemble
from ..model.model import Model
from ..scalar.algebra import ZERO, Vector, add, apply
from ..scalar.budget import WORK
from ..scalar.polynomial import Polynomial, Ring
from .free_body.constraints import closure_reactions, eliminated, indeterminate
from .free_body.contact_modes import model_in_modes, modes_of
from .free_body.free_body import FreeBody, own_body
from .free_body.gears import left_open, radial_forces, radial_law, radial_symbols
from .free_body.reaction import Reaction, unknowns
from .printing.arrange import PRINTED
from .printing.display import Formulas, displayed, lines_of
from .printing.latex import Latex
from .printing.lines import EQUALS, Lines, Shown
from .printing.mathml import MathML, document
from .printing.printer import Printer
from .printing.show import latex_words, words
from .printing.text import Text
from .recursive import Recursive
from .solving.questions import named

if TYPE_CHECKING:
    from .solving.eliminate import Elimination
    from .solving.solution import SolveResult

if TYPE_CHECKING:
    from .integrals.conserved_quantities import Integrals
    from .integrals.routh import Routh


@arguments_named
def equations(
    system: System | Model, *, modes: Mapping[str, Any] | None = None, form: str = "auto"
) -> Equations:
    """The equations of a system while its contacts keep ``modes``, all of them open if none are given, in a ``form``.

    :func:`freebody.equations` finds the modes in which the motion starts.
    """
    model = system if isinstance(system, Model) else assemble(system)
    return Equations(model_in_modes(model, modes), form)


FORMS = ("auto", "explicit", "recursive")
PAGE = 5000
"""Terms of all equations of motion that are still written out: some ten pages."""
CURE = (
    "Ask for fb.equations(s, form='recursive'), in which what is long has a name, or for numbers: "
    "fb.simulate, fb.compile."
)


class Equations:
    """Symbolic products of one model. Made by :func:`equations`; every product is formed once, when asked for."""

    def __init__(self, model: Model, form: str = "auto", chosen: str = "") -> None:
        if form not in FORMS:
            raise ModelError(f"Unknown form {form!r} of equations; {nearest(str(form), FORMS)}")
        self.model = model
        self._asked = form
        self.chosen = chosen
        """How the modes of the contacts were chosen, if not by who asked."""
        # room for every symbol, sine and cosine from the start: growing a ring re-packs its elements
        self.ring = Ring(capacity=64 + len(model.parameters) + 6 * model.n_q)
        self.ring.budget.subject, self.ring.budget.cure = f"the equations of '{model.name}'", CURE
        self.state: State = polynomial_state(model, self.ring)
        self.udot = tuple(self.ring.generator(speed.acceleration, "acceleration") for speed in model.speeds)

    def __reduce__(self) -> Any:
        """Another process, or a copy, forms the products that it is asked for."""
        return type(self), (self.model, self._asked, self.chosen)

    # -- canonical polynomials --------------------------------------------------------------------

    @cached_property
    def _held(self) -> set[str]:
        """Names of the loads that stand on the left: springs and dampers."""
        return {
            n
            for n, x in self.model.loads.items()
            if isinstance(x, Spring | Damper | JointSpring | JointDamper)
        }

    def question(self, subject: str) -> AbstractContextManager[None]:
        """What is formed inside is called ``subject`` when it is too long, and has a budget of its own."""
        return self.ring.budget.question(f"{subject} of '{self.model.name}'", CURE)

    @cached_property
    def recursive(self) -> Recursive:
        """The equations of motion in named quantities."""
        return Recursive(self.model)

    @cached_property
    def form(self) -> str:
        """How the equations of motion are printed: "explicit" or "recursive"."""
        if self._asked != "auto":
            return self._asked
        try:
            # on the way an element may be longer than what is left of it
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
        """Symbols of the named quantities and what they are, as SymPy expressions, in order; none in explicit form."""
        if self._asked != "recursive":
            return {}
        ring = self.recursive.ring
        return {d.symbol: displayed(d.value, ring) for d in self.recursive.definitions if d.angle is None}

    @cached_property
    @named("the equations of motion")
    def canonical_left(self) -> tuple[Any, ...]:
        """M u' + h as canonical polynomials, by one pass of Newton-Euler with u' as symbols."""
        return inverse_dynamics(
            self.model, self.state, self.udot, loading(self.model, self.state, self._held)
        )

    @cached_property
    @named("the mass matrix")
    def canonical_mass_matrix(self) -> tuple[tuple[Any, ...], ...]:
        """M as canonical polynomials: equal entries are equal, zero is recognised.

        Read off the left sides, which are linear in u': half the work of composite bodies on polynomials.
        """
        atoms = [speed.acceleration for speed in self.model.speeds]
        return tuple(
            tuple(self.ring.derivative(left, atom) for atom in atoms) for left in self.canonical_left
        )

    @cached_property
    @named("the velocity terms")
    def canonical_bias(self) -> tuple[Any, ...]:
        """h as canonical polynomials: velocity terms, weight, springs and dampers, all but the applied loads."""
        result = []
        for left, row in zip(self.canonical_left, self.canonical_mass_matrix, strict=True):
            for entry, acceleration in zip(row, self.udot, strict=True):
                left = left - entry * acceleration
            result.append(left)
        return tuple(result)

    @cached_property
    @named("the equations of motion")
    def canonical_applied(self) -> tuple[Any, ...]:
        """Q as canonical polynomials: generalized forces of the applied forces, couples and motors."""
        if len(self._held) == len(self.model.loads):
            return (0,) * self.model.n_u
        everything = inverse_dynamics(self.model, self.state, self.udot)
        return tuple(left - all_ for left, all_ in zip(self.canonical_left, everything, strict=True))

    @cached_property
    @named("the equations of motion")
    def balances(self) -> tuple[tuple[Any, Any], ...]:
        """(M u' + h, Q + Gᵀ λ) of every degree of freedom, canonical."""
        right = list(self.canonical_applied)
        for row, multiplier in zip(self.conditions.acting, self.canonical_multipliers, strict=True):
            right = [Q + entry * multiplier for Q, entry in zip(right, row, strict=True)]
        return tuple(zip(self.canonical_left, right, strict=True))

    @cached_property
    def conditions(self) -> Linearized:
        """The constraints, canonical: residuals, rates, the matrix G of the speeds, and γ; a row each."""
        return linearized(self.model, self.state)

    @cached_property
    def constraint_wrenches(self) -> list[Any]:
        """Per scalar constraint, the (point, force, moment) per unit multiplier on bodies, canonical."""
        return wrenches(self.model, self.state)

    @cached_property
    def condition_names(self) -> tuple[str, ...]:
        """Names of the scalar constraints, which are those of their multipliers."""
        return tuple(row.name for row in rows(self.model))

    @cached_property
    def canonical_multipliers(self) -> tuple[Any, ...]:
        """Multipliers λ as canonical symbols: force and moment components of the joints that close loops."""
        return tuple(self.ring.generator(symbol, "reaction") for symbol in self.multipliers)

    @cached_property
    @named("the positions")
    def postures(self) -> dict[str, Posture]:
        """Pose of every body, canonical."""
        return poses(self.model, self.state)

    @cached_property
    def joint_points(self) -> dict[str, Vector]:
        """Position in the ground of the point of every joint that its reaction is about, canonical."""
        links = link_postures(self.model, self.state)
        return {name: links[joint.links[-1]].position for name, joint in self.model.joints.items()}

    def center_acceleration(self, body: str) -> Vector:
        """Acceleration of a body's mass centre, in ground axes, canonical [m/s²]."""
        place = self.model.bodies[body]
        w, _ = velocities(self.model, self.state)[place.link]
        alpha, a = self.accelerations[place.link]
        p = self.state.vector(tuple(x + y for x, y in zip(place.origin, place.center, strict=True)))
        a_C = add(a, apply(turning(w, alpha), p))
        return apply(link_postures(self.model, self.state)[place.link].rotation, a_C)

    @cached_property
    @named("the accelerations")
    def accelerations(self) -> list[Any]:
        """Angular acceleration of every link and acceleration of its origin, in its axes, canonical; formed once."""
        return accelerations(self.model, self.state, self.udot)

    # -- SymPy at the edge ------------------------------------------------------------------------

    def sympy(self, x: Any) -> Any:
        """A canonical polynomial as an expanded SymPy expression."""
        return self.ring.to_sympy(x)

    def displayed(self, x: Any) -> Any:
        """A canonical polynomial as a SymPy expression, grouped as it is printed."""
        return displayed(x, self.ring)

    def column(self, v: Vector) -> Any:
        """Three canonical polynomials as a SymPy column."""
        return sympy.ImmutableMatrix([self.displayed(c) for c in v])

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

        Accelerations, velocity terms, weight, springs and dampers stand on the left, applied loads on the right.
        """
        if self._asked == "recursive":
            pairs = [(displayed(x, self.recursive.ring), 0) for x in self.recursive.balances]
        else:
            pairs = [(self.displayed(a), self.displayed(b)) for a, b in self.balances]
        return tuple(sympy.Eq(a, b, evaluate=False) for a, b in pairs)

    @cached_property
    def multipliers(self) -> tuple[Any, ...]:
        """Symbols of the constraint forces: ``C_x`` of a joint C that closes a loop, else the constraint's name."""
        return tuple(sympy.Symbol(name, real=True) for name in self.condition_names)

    @cached_property
    @named("the constraints")
    def constraints(self) -> tuple[Any, ...]:
        """The constraints as SymPy ``Eq``: on coordinates and, for non-holonomic ones, on speeds.

        Conditions that hold identically (out of the plane of a planar loop) are left out.
        """
        return tuple(sympy.Eq(self.displayed(x), 0, evaluate=False) for x in self._residuals)

    @property
    def _residuals(self) -> list[Any]:
        return [x for x in self.conditions.residual if x != 0]

    @cached_property
    @named("the matrix of the constraints")
    def constraint_matrix(self) -> Any:
        """G as a SymPy matrix, a row per scalar constraint: G u + g = 0; its transpose times the multipliers acts."""
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
        """Equations of motion without multipliers: one per independent speed, by dependent speeds.

            Nᵀ (M u' + h - Q) = 0   with   G N = 0

        N is formed without division, so that each equation carries the determinant of the dependent block of G.

        Parameters
        ----------
        independent : sequence of coordinates or speeds
            As many as there are degrees of freedom.
        """
        return tuple(sympy.Eq(self.displayed(x), 0, evaluate=False) for x in eliminated(self, independent))

    def indeterminate(
        self, near: Mapping[Any, Any] | None = None, values: Mapping[Any, Any] | None = None
    ) -> tuple[str, ...]:
        """Names of the reaction components that the motion does not determine.

        Where several constraints do the same, rigid bodies do not tell how they share the load: out of the plane
        of a planar linkage, for one. They are found by the rank of the constraint matrix at a closed position.

        Parameters
        ----------
        near : mapping, optional
            Coordinates by name, near which the machine is closed; zero if not given. Singular positions, such as
            bars in one line, have more of them than others.
        values : mapping, optional
            Of parameters, in place of their defaults.

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
        >>> found = fb.equations(s).indeterminate()
        >>> [name for name in found if name.startswith("upper")]
        ['upper_x', 'upper_y', 'upper_z', 'upper_Mx', 'upper_Mz']
        """
        return indeterminate(self, near, values)

    @cached_property
    def coordinates(self) -> tuple[Any, ...]:
        """Coordinates q as SymPy functions of time."""
        return tuple(coordinate.symbol for coordinate in self.model.coordinates)

    @cached_property
    def speeds(self) -> tuple[Any, ...]:
        """Speeds u: derivatives of the coordinates, or own functions of time for ball and free joints."""
        return tuple(speed.symbol for speed in self.model.speeds)

    @cached_property
    def reactions(self) -> Mapping[str, Reaction]:
        """Reaction of every joint on its child body as a function of q, u and u', by the joint's name.

        Those of closed contacts, on their features, are there by the contact's name.
        """
        return Reactions(self)

    @cached_property
    @named("the reactions")
    def closures(self) -> dict[str, Reaction]:
        """Reactions of the joints that close loops and of closed contacts, in their multipliers."""
        return closure_reactions(self)

    @cached_property
    @named("the reactions")
    def canonical_reactions(self) -> dict[str, tuple[Vector, Vector]]:
        """(force, moment) of every joint on its child in ground axes, canonical."""
        loads = None
        if self.model.constraints:
            loads = constrained_loading(self.model, self.state, self.canonical_multipliers)
            for gear in radial_symbols(self):
                if radial_law(self, gear) is None:
                    loads = with_wrenches(self.model, self.state, loads, radial_forces(self, gear))
        return reactions(self.model, self.state, self.udot, natural=True, loads=loads)

    def canonical_components(self, joint: str) -> dict[Any, Any]:
        """Value of each unknown of a joint's reaction by its symbol, canonical."""
        force, moment = self.canonical_reactions[joint]
        result = {}
        for c in unknowns(self.model, self.state, joint):
            # a component's directions are unit vectors at right angles, so its value is a projection
            along, of = (c.force, force) if c.force != ZERO else (c.moment, moment)
            result[c.symbol] = sum((a * b for a, b in zip(along, of, strict=True)), start=0)
        return result

    @cached_property
    def energy(self) -> Energy:
        """``.kinetic`` and ``.potential`` energy."""
        return Energy(self)

    @cached_property
    def momentum(self) -> MomentumOf:
        """``.linear`` momentum and ``.angular(about)`` momentum of all bodies, in ground axes."""
        return MomentumOf(self)

    @cached_property
    @named("the conserved quantities")
    def integrals(self) -> Integrals:
        """Conserved quantities, each proven by a derivative that is canonically zero."""
        from .integrals.conserved_quantities import integrals

        return integrals(self)

    @named("Routh's equations")
    def routh(self) -> Routh:
        """Routh's reduction: ignorable coordinates eliminated, their momenta as symbols."""
        from .integrals.routh import routh

        return routh(self)

    @named("the free body")
    def free_body(self, body: Any, *, about: Any = None, frame: Any = None) -> FreeBody:
        """Free-body equations of one body, with the joint reactions as unknowns.

        Parameters
        ----------
        body : str or Body
        about : Point or Body, optional
            Where moments are taken; the mass centre if not given. It may move.
        frame : str or Body, optional
            The axes of the components; ground axes if not given.
        """
        name = body if isinstance(body, str) else own_body(self.model, body, "a free body").name
        if name not in self.model.bodies:
            raise ModelError(f"Unknown body '{name}'; {nearest(str(name), self.model.bodies)}")
        return FreeBody(self, name, about, frame)

    # -- questions --------------------------------------------------------------------------------

    @property
    @named("the plane of motion")
    def planar(self) -> str | None:
        """The ground axis at right angles to the plane that all bodies move in, "x", "y" or "z"; else None."""
        from .free_body.planar import Plane, plane_of

        plane = plane_of(self)
        return plane.letter if isinstance(plane, Plane) else None

    @named("the solution")
    def solve(
        self, unknowns: Any, where: Any = None, *, bodies: Any = None, eliminate: Any = ()
    ) -> SolveResult:
        """What the free-body equations say about unknowns: exact, or refused with what was left.

        Parameters
        ----------
        unknowns : name, SymPy expression, or sequence of them
            Reaction components ``"pin_x"``, parameters, accelerations ``"theta''"``, speeds or their squares
            ``"theta'^2"``, coordinates (through their sine and cosine). Reactions that are not asked for are
            eliminated. Accelerations that are not asked for stay, as the motion that the reactions belong to;
            in a question about parameters, coordinates and speeds alone, or while a contact of a planar machine is
            closed, they are eliminated too.
        where : mapping, equation, text, or sequence of them, optional
            Values by name, ``{"pin_y": 0, "theta'": 0}``, and further equations, ``"T = mu*N"`` or ``Eq(T, mu*N)``.
        bodies : sequence of names or FreeBody, optional
            The free bodies whose equations are used; all of them in ground axes if not given.
        eliminate : sequence of names, optional
            Further unknowns that the answer shall not hold.

        Returns
        -------
        SolveResult
            ``result["pin_x"]``, ``.branches`` (all solutions), ``.conditions``, ``.text()``, ``.latex()``.

        Raises
        ------
        ModelError
            Under- or over-determined requests, with what was left; those without a closed form; unknown names.

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
        from .solving.solve import solve

        return solve(self, unknowns, where, bodies, eliminate)

    @named("the elimination")
    def eliminate(self, reactions: Any = None, *, bodies: Any = None) -> Elimination:
        """Which combination of the free-body equations is free of reactions, and what it gives.

        Parameters
        ----------
        reactions : name or sequence of names, optional
            Components ``"pin_x"``, or joints and constraints, all components of which are meant; all if not given.
        bodies : sequence of names or FreeBody, optional
            The free bodies that are combined; all of them, with moments about their mass centres, if not given.

        Returns
        -------
        Elimination
            ``.combination`` (coefficient of each free-body equation, by body and row), ``.equations``,
            ``.text()``, ``.latex()``.

        Raises
        ------
        ModelError
            An unknown reaction, or reactions that no combination is free of.

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
        from .solving.eliminate import eliminate

        return eliminate(self, reactions, bodies)

    # -- display ----------------------------------------------------------------------------------

    @named("the equations of motion")
    def _shown(self, kind: type[Printer], sign: str) -> tuple[list[str], list[str]]:
        sides = [*self.balances, *((x, 0) for x in self._residuals)]
        # refused before the first of them is printed
        self.ring.budget.scan(PRINTED * sum(len(x) for pair in sides for x in pair if type(x) is Polynomial))
        return lines_of(kind, sides, self.ring, sign)

    @property
    def heading(self) -> list[str]:
        """A line that names the modes of the contacts, unless who asked for the equations chose them."""
        if not self.chosen:
            return []
        return [f"Contacts: {_modes_in_words(self.model)} ({self.chosen})"]

    def text(self) -> str:
        """The equations of motion as plain text, a line each; then what is named in them."""
        return "\n".join([*self.heading, *self.lines()])

    def lines(self) -> list[str]:
        """The lines of :meth:`text` below the modes of the contacts."""
        if self.form == "recursive":
            parts = self.recursive.written(Text, " = ")
            return [line for head, lines in parts for line in (head, *(f"  {x}" for x in lines))]
        lines, names = self._shown(Text, " = ")
        return [*lines, *(["where"] if names else []), *(f"  {line}" for line in names)]

    def latex(self) -> str:
        """The equations of motion as a LaTeX ``aligned`` block."""
        if self.form == "recursive":
            parts = self.recursive.written(Latex, " &= ")
            rows = [line for head, lines in parts for line in (f"&{latex_words(head)}", *lines)]
            return "\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}"
        lines, names = self._shown(Latex, " &= ")
        above = [f"&{latex_words(line)}" for line in self.heading]
        return "\\begin{aligned}\n" + " \\\\\n".join([*above, *lines, *names]) + "\n\\end{aligned}"

    def mathml(self) -> str:
        """The equations of motion as presentation MathML."""
        if self.form == "recursive":
            parts = self.recursive.written(MathML, "<mo>=</mo>")
            return "\n".join(document(x) for head, lines in parts for x in (words(head), *lines))
        lines, names = self._shown(MathML, "<mo>=</mo>")
        return "\n".join(map(document, [*map(words, self.heading), *lines, *names]))

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        contacts = "" if self.chosen else _modes_in_words(self.model)
        return f"Equations of motion of '{self.model.name}'{contacts and f' ({contacts})'}\n{self.text()}"


def _modes_in_words(model: Model) -> str:
    return ", ".join(f"{name} {mode}" for name, mode in modes_of(model).items())


class Reactions(Shown, Mapping[str, Reaction]):
    """Reactions by joint; each is turned into SymPy when it is looked up."""

    def __init__(self, equations: Equations) -> None:
        self._e = equations
        self._made: dict[str, Reaction] = {}

    def __getitem__(self, name: str) -> Reaction:
        e = self._e
        if name not in self:
            raise ModelError(f"Unknown joint '{name}'; {nearest(str(name), list(self))}")
        if name not in self._made and name in e.closures:
            self._made[name] = e.closures[name]
        if name not in self._made:
            force, moment = e.canonical_reactions[name]
            joint = e.model.joints[name]
            parts = {
                str(symbol): e.displayed(value) for symbol, value in e.canonical_components(name).items()
            }
            self._made[name] = Reaction(
                joint=name,
                force=e.column(force),
                moment=e.column(moment),
                on=joint.child,
                about=f"point ({', '.join(map(str, joint.to))}) of {joint.child}",
                frame="ground",
                components=parts,
                notes=tuple(left_open(e, name)),
            )
        return self._made[name]

    def __contains__(self, name: object) -> bool:
        return name in self._e.model.joints or name in self._e.closures

    def __iter__(self) -> Iterator[str]:
        return iter((*self._e.model.joints, *self._e.closures))

    def __len__(self) -> int:
        return len(self._e.model.joints) + len(self._e.closures)

    def _parts(self) -> list[Reaction]:
        return [self[name] for name in self]

    def __repr__(self) -> str:
        return f"Reactions of {', '.join(self)}"


class Energy(Formulas):
    """Kinetic and potential energy [J]."""

    def __init__(self, equations: Equations) -> None:
        self._e = equations

    @cached_property
    @named("the kinetic energy")
    def canonical_kinetic(self) -> Any:
        """T as a canonical polynomial."""
        return kinetic_energy(self._e.model, self._e.state)

    @cached_property
    @named("the potential energy")
    def canonical_potential(self) -> Any:
        """V as a canonical polynomial."""
        return potential_energy(self._e.model, self._e.state)

    @cached_property
    @named("the kinetic energy")
    def kinetic(self) -> Any:
        """T, ½ Σ (m v_C² + ω·H_C)."""
        return self._e.displayed(self.canonical_kinetic)

    @cached_property
    @named("the potential energy")
    def potential(self) -> Any:
        """V of weight (zero at the ground's origin) and springs (zero when free of force)."""
        return self._e.displayed(self.canonical_potential)

    def _lines(self, show: Any) -> list[str]:
        ring = self._e.ring
        letters = ("T", "V")
        if any(letter in self._e.model.names.kinds for letter in letters):
            letters = ("kinetic", "potential")
        T, V = (ring.generator(sympy.Symbol(letter, real=True), "parameter") for letter in letters)
        return [show(T, self.canonical_kinetic, ring), show(V, self.canonical_potential, ring)]


class MomentumOf(Lines):
    """Linear momentum and angular momentum of all bodies."""

    def __init__(self, equations: Equations) -> None:
        self._e = equations

    def _lines(self) -> list[list[Any]]:
        return [
            ["linear", EQUALS, self.linear],
            ["angular about the ground's origin", EQUALS, self.angular()],
        ]

    def __repr__(self) -> str:
        return self.text()

    @cached_property
    @named("the linear momentum")
    def linear(self) -> Any:
        """Σ m v_C, SymPy column in ground axes [kg m/s]."""
        return self._e.column(momentum(self._e.model, self._e.state).linear)

    @named("the angular momentum")
    def angular(self, about: Any = None) -> Any:
        """Σ (r × m v_C + H_C) about a point, SymPy column in ground axes [kg m²/s].

        Parameters
        ----------
        about : Point or three components in ground axes, optional
            The ground's origin if not given; a point of a body is taken where it is at the instant.
        """
        e = self._e
        if isinstance(about, Body):
            about = about.origin
        if about is None:
            where: Any = (0, 0, 0)
        elif isinstance(about, Point):
            own_body(e.model, about.body, "a point to take momentum about")
            where = point_position(e.model, e.state, about)
        else:
            if isinstance(about, str) or not hasattr(about, "__len__") or len(about) != 3:
                raise ModelError(
                    f"Expected a point or three components to take momentum about, got {about!r}."
                )
            where = e.state.vector(
                [e.model.names.expression(x, "the point of angular momentum") for x in about]
            )
        return e.column(momentum(e.model, e.state, where).angular)
