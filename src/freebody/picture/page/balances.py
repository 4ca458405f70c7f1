"""Free bodies and equations of a machine as HTML: diagrams, formulas, and the sentences between them.

Reports, the page of ``freebody view`` and the documentation of the gallery are made of these parts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any

from ...errors import TooManyTermsError
from ...model.model import Model
from ...scalar.polynomial import Polynomial
from ...symbolic.equations import Equations
from ...symbolic.equations import equations as equations_of
from ...symbolic.free_body.planar import plane_in
from ..free_body.free_body_diagram import free_body_diagram
from ..machine.draw import draw
from . import prose
from .longest_phases import lasting
from .symbols import Symbols, in_powers, unbroken

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

LARGEST, LONGEST = 6, 1250
"""Most speeds of a machine whose equations are shown by default, and most terms of these."""
HIDDEN = (
    "Free-body diagrams and equations are not shown for a machine of this size: "
    "<code>fb.report(…, equations=True)</code> or <code>fb.equations(s).text()</code> gives them."
)


def balances(
    trajectory: Trajectory,
    symbols: Symbols,
    shown: bool | None = None,
    drawn: Mapping[str, Any] | None = None,
    names: Mapping[str, Any] | None = None,
) -> tuple[str, str]:
    """Return the drawing; diagrams and equations, for a motion with contacts in each of the modes that lasted longest.

    ``shown`` is whether to show them; by default those of machines of up to six speeds are, if they are no longer than
    some pages. ``drawn`` holds the options of the drawings, as of :func:`freebody.draw`; ``names`` as `motion`.
    """
    options = {"values": trajectory.values, **(drawn or {})}
    model = trajectory.kernels.model
    if not (shown or (shown is None and _is_short(equations_of(model)))):
        return "", f"<h2>Equations</h2>\n<p>{HIDDEN}</p>"
    said = _other_values(trajectory.values, options["values"] or {}, symbols)
    found: list[tuple[Equations, str]] = []
    for modes, time in lasting(trajectory):
        words = ", ".join(f"{name} {mode}" for name, mode in _by_owner(modes, model).items())
        heading = f" <small>({symbols.words(words)}; {time:.4g} s of the motion)</small>"
        found.append((equations_of(model, modes=modes), heading))
    found = found or [(equations_of(model), "")]
    machine = _or_refusal(lambda: draw(found[0][0].model, **options).svg)
    drawing = f'<div class="machine"><h2>Drawing</h2>\n<figure>{machine}</figure>{said}</div>'
    return drawing, "\n".join(
        _section(e, options, symbols, heading, names)
        if shown or _is_short(e)
        else f"<h2>Equations{heading}</h2>\n<p>{HIDDEN}</p>"
        for e, heading in found
    )


def _other_values(values: Mapping[str, float], drawn: Mapping[str, Any], symbols: Symbols) -> str:
    """Sentence about parameters that the drawings show with other values than the motion has."""
    other = [
        f"{symbols.name(name)} = {in_powers(f'{float(value):.6g}')} in place of {in_powers(f'{values[name]:.6g}')}"
        for name, value in drawn.items()
        if name in values and float(value) != values[name]
    ]
    return f"<p>The drawing is not to scale, so that it can be read: {', '.join(other)}.</p>" if other else ""


def laws(e: Equations, symbols: Symbols) -> str:
    """Return the sentence before the equations of the bodies.

    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> pin = s.hinge("pin", s.ground, s.body("bar", fb.slender_bar(1, 1)), coordinate="theta")
    >>> laws(fb.equations(s), Symbols())[:24]
    '<p>The motion is planar.'
    """
    return f"<p>{unbroken(prose.laws(e, symbols.glyphs.line))}</p>"


def free_body(e: Equations, name: str, symbols: Symbols) -> str:
    """Return what acts on a body in words, and its equations."""
    body = e.free_body(name)
    if not isinstance(plane_in(body), str):
        found = list(body.planar_equations)
    elif body.in_names is None:
        found = [x for x in body.equations if x.lhs != 0 or x.rhs != 0]
    else:  # the formula has names in place of what would fill pages
        found = []
    bodies = list(e.model.bodies)
    said = prose.actions(e, name, bodies[: bodies.index(name)], symbols.name)
    return f"<p>{unbroken(said)}</p>\n" + symbols.formula(
        body.latex(), [*[""] * len(e.heading), *map(str, found)]
    )


def motion(e: Equations, symbols: Symbols, names: Mapping[str, Any] | None = None) -> str:
    """Return where the equations of motion come from in words, and the equations; ``names`` as `Equations.latex`."""
    said = f"<p>{unbroken(prose.motion(e, symbols.name))}</p>\n"
    codes = [] if names else [*[""] * len(e.heading), *map(str, e.motion)]
    return said + symbols.formula(e.latex(names=names), codes)


def _is_short(e: Equations) -> bool:
    """Return True if the equations of motion are few and short."""
    if e.model.n_u > LARGEST or e.form == "recursive":
        return False
    try:
        sides = e.balances
    except TooManyTermsError:
        return False
    return sum(len(x) for pair in sides for x in pair if isinstance(x, Polynomial)) <= LONGEST


def _by_owner(modes: Mapping[str, str], model: Model) -> dict[str, str]:
    """Modes by contact as the user declared it, if all its elements are in the same mode; by element otherwise."""
    elements: dict[str, list[str]] = {}
    for contact in model.contacts:
        elements.setdefault(contact.owner, []).append(contact.name)
    result: dict[str, str] = {}
    for owner, names in elements.items():
        same = len({modes[name] for name in names}) == 1
        result |= {owner: modes[names[0]]} if same else {name: modes[name] for name in names}
    return result


def _section(
    e: Equations,
    options: Mapping[str, Any],
    symbols: Symbols,
    heading: str = "",
    names: Mapping[str, Any] | None = None,
) -> str:
    """Diagrams, free-body equations and equations of motion."""
    parts = [
        _or_refusal(lambda: _diagrams(e, options, heading)),
        f"<h2>Free-body equations{heading}</h2>\n{laws(e, symbols)}",
    ]
    for name in e.model.bodies:
        parts.append(f"<h3>{escape(name)}</h3>")
        parts.append(_or_refusal(partial(free_body, e, name, symbols)))
    parts += [f"<h2>Equations of motion{heading}</h2>", _or_refusal(lambda: motion(e, symbols, names))]
    return "\n".join(parts)


def _or_refusal(part: Callable[[], str]) -> str:
    """A part of the page, or the reason why it would be too long."""
    try:
        return part()
    except TooManyTermsError as error:
        return f"<p>{escape(str(error))}</p>"


def _diagrams(e: Equations, options: Mapping[str, Any], heading: str) -> str:
    """Free-body diagrams in a generic configuration."""
    parts = [f"<h2>Free-body diagrams{heading}</h2>", '<div class="figures">']
    for name in e.model.bodies:
        drawing = free_body_diagram(e, name, **options)
        parts.append(f'<figure tabindex="0">{drawing.svg}<figcaption>{escape(name)}</figcaption></figure>')
    return "\n".join([*parts, "</div>"])
