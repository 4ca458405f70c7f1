"""Planar motion, recognised by what is canonically zero.

A model is planar with the normal n, a ground axis, if for every body

    ω × n = 0,    v_C · n = 0    identically,

and if what is left of ΣF·n = 0, ΣM_C × n = 0 are homogeneous equations in reactions out of the plane alone (products of
inertia, loads and weights across the plane do not occur). These reactions are then zero, and two force equations and
one moment equation remain.

Source: chapter 6, section 6.5.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy

from ...dynamics.kinematics import rotation, velocities
from ...errors import ModelError, TooManyTermsError
from ...scalar.algebra import IDENTITY, ZERO, add, apply, apply_transpose, cross, dot
from ..printing.display import equation_latex, equation_text, text
from ..printing.show import latex_words
from ..printing.systems import Row, collect, eliminate
from .reaction import LETTERS, unknowns

if TYPE_CHECKING:
    from ..equations import Equations
    from .free_body import FreeBody


@dataclass(frozen=True)
class Plane:
    """The plane of a planar model.

    Attributes
    ----------
    normal : int
        Number of the ground axis at right angles to it.
    zero : tuple of str
        Reaction components out of the plane: all are zero.
    loose : tuple of str
        Those among them that the equations leave open (loops that hold themselves out of the plane).
    """

    normal: int
    zero: tuple[str, ...]
    loose: tuple[str, ...]

    @property
    def letter(self) -> str:
        """Name of the normal axis."""
        return LETTERS[self.normal]


def plane_of(e: Equations) -> Plane | str:
    """The plane of a model's motion, or the reason why there is none."""
    if "plane" not in e.state.cache:
        e.state.cache["plane"] = _find(e)
    return e.state.cache["plane"]


def normal_of(e: Equations) -> int | None:
    """Number of the ground axis at right angles to the plane of a model's motion, if it has one.

    Where the motion is too long to be written, its named quantities tell.
    """
    try:
        plane = plane_of(e)
    except TooManyTermsError:
        return e.recursive.normal
    return plane.normal if isinstance(plane, Plane) else None


def _find(e: Equations) -> Plane | str:
    model, state = e.model, e.state
    turning, moving = [], []
    for name, place in model.bodies.items():
        w, v = velocities(model, state)[place.link]
        R = rotation(model, state, place.link)
        p = state.vector(tuple(a + b for a, b in zip(place.origin, place.center, strict=True)))
        turning.append((name, apply(R, w)))
        moving.append((name, apply(R, add(v, cross(w, p)))))
    axes = {k for _, w in turning for k in range(3) if w[k] != 0}
    if len(axes) > 1:
        first, second = (next(name for name, w in turning if w[k] != 0) for k in sorted(axes)[:2])
        which = f"'{first}' turns" if first == second else f"'{first}' and '{second}' turn"
        return f"{which} about the ground axes {' and '.join(LETTERS[k] for k in sorted(axes)[:2])}"
    reason = ""
    for k in sorted(axes) or (2, 1, 0):
        across = [name for name, v in moving if v[k] != 0]
        if across:
            reason = reason or f"'{across[0]}' moves along the ground axis {LETTERS[k]}"
            continue
        found = _across(e, k)
        if isinstance(found, Plane):
            return found
        reason = reason or found
    return reason


def _across(e: Equations, k: int) -> Plane | str:
    """The reactions out of the plane, if the equations across it hold nothing else."""
    n = IDENTITY[k]
    outside: dict[str, Any] = {}
    for joint in e.model.joints:
        for c in unknowns(e.model, e.state, joint):
            if _is_across(c.force, c.moment, n):
                outside[c.name] = c.symbol
    for name, symbol, pair in zip(e.condition_names, e.multipliers, e.constraint_wrenches, strict=True):
        if pair and all(_is_across(force, moment, n) for _, force, moment in pair):
            outside[name] = symbol
    places = {}
    for name, symbol in outside.items():
        (g,) = e.ring.used(e.ring.generator(symbol, "reaction"))
        places[g.index] = (name, 1)
    rows = []
    for body in e.model.bodies:
        free = e.free_body(body)
        for i, (title, (left, right)) in enumerate(zip(free._titles(), free.balances, strict=True)):
            terms = collect(left - right, places, e.ring)
            within = (i != k) if i < 3 else (i - 3 == k)
            if within and any(monomial for monomial in terms):
                return (
                    f"the {title} equation of '{body}' holds the reaction {next(m for m in terms if m)[0][0]}"
                )
            if not within:
                if () in terms:
                    return f"the {title} equation of '{body}' holds more than reactions across the plane"
                rows.append(Row(title, terms))
    solved, _ = eliminate(rows, [list(outside)])
    loose = [name for name in outside if name not in solved or solved[name]]
    return Plane(k, tuple(outside), tuple(loose))


def _is_across(force: Any, moment: Any, n: Any) -> bool:
    """Whether a wrench is a force along the normal, or a moment at right angles to it."""
    if force != ZERO:
        return cross(force, n) == ZERO and dot(moment, n) == 0
    return dot(moment, n) == 0


def plane_in(body: FreeBody) -> tuple[Plane, int] | str:
    """The plane and the number of the normal among the axes of a free body, or the reason why it has none."""
    plane = plane_of(body._e)
    if isinstance(plane, str):
        return plane
    n = apply_transpose(body._axes, IDENTITY[plane.normal])
    live = [k for k in range(3) if n[k] != 0]
    if len(live) != 1:
        return f"the axes of '{body.frame}' are not along the normal {plane.letter}"
    return plane, live[0]


def planar_balances(body: FreeBody) -> tuple[tuple[str, Any, Any], ...]:
    """(title, left, right) of two force equations and one moment equation, canonical.

    Raises
    ------
    ModelError
        The model is not planar, with the reason.
    """
    found = plane_in(body)
    if isinstance(found, str):
        raise ModelError(
            f"Free body '{body.body}' is not planar: {found}. Its six equations are in .equations."
        )
    plane, k = found
    zero = set()
    for name in plane.zero:
        (g,) = body._e.ring.used(body._e.ring.generator(sympy.Symbol(name, real=True), "reaction"))
        zero.add(g.index)
    result = []
    titles = body._titles()
    for i in (*(j for j in range(3) if j != k), k + 3):
        left, right = body.balances[i]
        result.append((titles[i], _without(body, left, zero), right))
    return tuple(result)


def _without(body: FreeBody, x: Any, zero: set[int]) -> Any:
    """x without the reactions that are zero (about a point off the plane they may stand in it)."""
    terms = collect(x, {index: (index, 1) for index in zero}, body._e.ring)
    return terms[()].whole() if () in terms else 0


def planar_equations(body: FreeBody) -> tuple[Any, ...]:
    """See :attr:`FreeBody.planar_equations`."""
    show = body._e.displayed
    return tuple(sympy.Eq(show(a), show(b), evaluate=False) for _, a, b in planar_balances(body))


def planar_text(body: FreeBody) -> str:
    """The forces in the plane by name, two force equations and one moment equation, and what is zero."""
    found = plane_in(body)
    assert not isinstance(found, str)
    plane, k = found
    ring = body._e.ring
    held = [j for j in range(3) if j != k]
    letters = ", ".join(LETTERS[j] for j in held)
    lines = [
        *body._e.heading,
        f"Free body '{body.body}': planar, components along {letters} of {body.frame} axes, "
        f"moments about {body.about} along {LETTERS[k]}",
    ]
    shown = [a for a in body.actions if a.name not in plane.zero]
    width = max([len(a.name) for a in shown], default=0)
    for a in shown:
        parts = []
        if a.force != ZERO:
            force = body._turned(a.force)
            parts.append("force (" + ", ".join(text(force[j], ring) for j in held) + ")")
        if a.moment != ZERO:
            parts.append(f"couple {text(body._turned(a.moment)[k], ring)}")
        by = f"   [{a.by}]" if a.by else ""
        lines.append(f"  {a.name:<{width}}  {', '.join(parts)}{by}")
    for title, left, right in planar_balances(body):
        lines.append(f"  {title}:  {equation_text(left, right, ring)}")
    here = {a.name for a in body.actions}
    zero = [name for name in plane.zero if name in here]
    loose = [name for name in plane.loose if name in here]
    if zero:
        line = f"  out of the plane, zero:  {', '.join(zero)}"
        if loose:
            line += f" ({', '.join(loose)}: indeterminate, zero if the loops fit without force)"
        lines.append(line)
    return "\n".join([*lines, *body.remarks()])


def planar_latex(body: FreeBody) -> str:
    """The three equations as a LaTeX ``aligned`` block."""
    ring = body._e.ring
    pairs = [*((a, b) for _, a, b in planar_balances(body)), *body.laws]
    rows = [equation_latex(a, b, ring).replace(" = ", " &= ", 1) for a, b in pairs]
    above = [f"&{latex_words(line)}" for line in body._e.heading]
    return "\\begin{aligned}\n" + " \\\\\n".join([*above, *rows]) + "\n\\end{aligned}"
