"""The report: one HTML page about a machine and its motion, which opens offline."""

from __future__ import annotations

import base64
import io
import os
import re
import tempfile
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...describe.contacts.coefficients import depends_on_slip
from ...describe.contacts.normal_law import OWN_NAMES
from ...describe.description import about_of, parameters_of
from ...describe.system import System
from ...dynamics.state import State, float_state
from ...errors import FormatError, ModelError, SimulationError, path_of
from ...formats.files import replacing
from ...formats.text import expression_text
from ...model.assemble import assemble
from ...model.family import text_of_members
from ...model.model import Model
from ...scalar.algebra import Vector
from ...version import VERSION
from ..moving.keyframes import TOLERANCE
from .animation import frames_of, scene_of
from .answers import answers_table
from .balances import balances
from .browser import Browser
from .page import page, stage
from .symbols import Symbols, in_powers

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

OPEN = 3
"""Number of charts up to which all are open at the beginning."""


def report(
    s: System,
    trajectory: Trajectory,
    path: str | os.PathLike[str],
    *,
    title: str | None = None,
    about: str = "",
    answers: Mapping[str, Any] | None = None,
    figures: Mapping[str, Any] | None = None,
    equations: bool | None = None,
    tolerance: float = TOLERANCE,
    live: bool = False,
    drawn: Mapping[str, Any] | None = None,
    names: Mapping[str, Any] | None = None,
) -> Path:
    """Write one HTML page about a machine and its motion; it opens offline and makes no request.

    The page has the animation (play, scrub, speed, orbit, trails, arrows of forces and reactions, frames, cones), plots
    whose cursor follows it, a summary of the model, its drawing and free-body diagrams, equations and answers.

    Parameters
    ----------
    s : System
    trajectory : Trajectory
        Motion of this system.
    path : path
        The file, ``.html``, or ``.pdf``: the page as a Chromium prints it. It is written completely or not at all.
    title, about : str, optional
        Plain text at the top; by default the title is the name of the system.
    answers : mapping, optional
        Name -> value, (value, unit), or an answer of the gallery with its question and formula.
    figures : mapping, optional
        Caption -> PNG as bytes, matplotlib axes or figure, or a function that writes a PNG to a path.
    equations : bool, optional
        Show free-body diagrams and equations; by default for machines of up to six speeds, if they are no longer than
        some pages.
    tolerance : float
        Tolerance of the animation between its keyframes.
    live : bool
        Put sliders for parameters, initial values and the length of the run beside the animation. The page computes the
        motion again as they move, without a server: it holds the machine as WebAssembly. Drawings and equations stay
        those of the given motion.
    drawn : mapping, optional
        How the machine and its free bodies are drawn: ``at``, ``near`` and ``values`` of :func:`freebody.draw`; by
        default in a generic position, with the values of the motion.
    names : mapping, optional
        Names for groups of parameters in the equations of motion, as of :meth:`Equations.text`.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ModelError
        If the trajectory belongs to another system.
    FormatError
        If the path cannot be written, does not end in ``.html`` or ``.pdf``, or a live page is to be a PDF.
    FreebodyError
        If there is no Chromium to print a PDF.
    SimulationError
        If a live page cannot compute such a motion: of solids that touch in patches, with signals or controllers that
        switch, blows, a stiff or a very large machine.

    Examples
    --------
    >>> import freebody as fb, tempfile, pathlib
    >>> s = fb.System("pendulum")
    >>> bar = s.body("bar", fb.slender_bar(1, 2, axis="y"))
    >>> s.gravity = (0, -9.81, 0)
    >>> pin = s.hinge("pin", s.ground, bar, to=(0, 1, 0), coordinate="theta")
    >>> motion = fb.simulate(s, until=2, initial={"theta": 1})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     fb.report(s, motion, pathlib.Path(folder, "pendulum.html")).stat().st_size < 300_000
    True
    """
    target = path_of(path, "a report", FormatError)
    kind = target.suffix.lower()
    if kind not in (".html", ".htm", ".pdf"):
        raise FormatError(
            f"Expected a file name that ends in .html or .pdf for a report, got '{target.name}'."
        )
    if kind == ".pdf" and live:
        raise FormatError(
            f"Expected an .html file for a live page, got '{target.name}': paper does not compute."
        )
    if not isinstance(s, System):
        raise ModelError(f"Expected a System to report on, got {s!r}.")
    if not hasattr(trajectory, "kernels"):
        raise ModelError(f"Expected a motion of fb.simulate to report on, got {trajectory!r}.")
    model = trajectory.kernels.model
    same = model.name == s.name and tuple(model.bodies) == tuple(s.bodies)
    if not same or model.coordinate_names != assemble(s).coordinate_names:
        raise ModelError(
            f"Expected a trajectory of '{s.name}', got one of '{model.name}' with other bodies or coordinates. "
            "Simulate the system as it is described now."
        )
    keys = frames_of(trajectory, tolerance)
    scene = scene_of(trajectory, keys)
    if live:
        from .simulator import simulator  # imported late: it needs the compiler

        scene["live"] = simulator(s, trajectory, keys, scene, answers or {})
    symbols = Symbols.of(model, *(answers or {}))
    drawing, laws = balances(trajectory, symbols, equations, drawn, names)
    parts = [
        f"<h1>{escape(title or s.name)}</h1>",
        f'<p class="sub">{symbols.words(about or _sentence(trajectory))}</p>',
        _warnings(trajectory),
        stage(live),
        drawing,
        answers_table(answers or {}, symbols),
        "<h2>Plots</h2>\n" + charts(scene, symbols),
        laws,
        _model(s, trajectory, symbols),
        _reading(s),
        _figures(figures or {}),
        _footer(trajectory, scene),
    ]
    text = page(title or s.name, scene, "\n".join(part for part in parts if part), symbols=symbols)
    with replacing(target) as new:
        if kind == ".pdf":
            new.write_bytes(_printed(text))
        else:
            new.write_text(text, encoding="utf-8")
    return target


def _printed(text: str) -> bytes:
    """A page as PDF."""
    with tempfile.TemporaryDirectory() as folder, Browser() as browser:
        file = Path(folder, "report.html")
        file.write_text(text, encoding="utf-8")
        browser.open(file)
        return browser.pdf()


# -- sections ----------------------------------------------------------------------------------------------


def _sentence(trajectory: Trajectory) -> str:
    """Summary of a motion."""
    text = repr(trajectory).partition(": ")[2]
    return f"Motion, {text}"


def _warnings(trajectory: Trajectory) -> str:
    """Warnings about the motion, at the top of the page."""
    lines = "".join(f"<li>{escape(str(warning))}</li>" for warning in trajectory.warnings)
    return f"<h2>Warnings</h2>\n<ul>{lines}</ul>" if lines else ""


def _reading(s: System) -> str:
    """What the reader of a robot's file read, changed and left out."""
    if s.reading is None:
        return ""
    first, *notes = map(escape, str(s.reading).splitlines())
    return f"<h2>File</h2>\n<p>{first}</p>\n<ul>{''.join(f'<li>{note}</li>' for note in notes)}</ul>"


class Html(str):
    """Text that is HTML."""


def _table(head: tuple[str, ...], rows: list[tuple[Any, ...]], number: int = -1) -> str:
    """HTML table; ``number`` is the column of numbers."""
    top = "".join(f"<th>{escape(name)}</th>" for name in head)
    lines = []
    for row in rows:
        kinds = (' class="number"' if i == number else "" for i in range(len(row)))
        cells = (
            f"<td{kind}>{x if isinstance(x, Html) else escape(str(x))}</td>"
            for kind, x in zip(kinds, row, strict=True)
        )
        lines.append(f"<tr>{''.join(cells)}</tr>")
    table = f"<table><thead><tr>{top}</tr></thead><tbody>{''.join(lines)}</tbody></table>"
    return f'<div class="wide" tabindex="0">{table}</div>'


def charts(scene: Mapping[str, Any], symbols: Symbols) -> str:
    """Charts of a page as HTML that can be folded; the first chart of coordinates and of energy is open."""
    opened = {
        next((i for i, chart in enumerate(scene["charts"]) if chart["group"] == group), -1)
        for group in ("coordinates", "energy")
    }
    parts = []
    for i, chart in enumerate(scene["charts"]):
        state = " open" if i in opened or len(scene["charts"]) <= OPEN else ""
        summary = f"<summary>{symbols.words(chart['title'])}</summary>"
        parts.append(f'<details{state}>{summary}<div data-chart="{i}"></div></details>')
    return "\n".join(parts)


def _coefficient(model: Model, state: State, law: Any) -> str:
    """A coefficient of a contact: its value, or the law by which it depends on slip and on the state."""
    if not depends_on_slip(law) and not model.names.depends(law, "coordinate", "speed", "time"):
        return f"{float(state(law)):.6g}"
    return _law(model, law)


def _friction(model: Model, state: State, contact: Any) -> str:
    """The coefficient of friction of a contact, or both."""
    first = _coefficient(model, state, contact.friction)
    if contact.friction_across is None:
        return first
    return f"{first} along, {_coefficient(model, state, contact.friction_across)} across"


def _restitution(model: Model, state: State, contact: Any) -> str:
    """The coefficient of restitution of a contact, and its adhesion, if any; or its law of the normal force."""
    if contact.compliant:
        return f"N = {_law(model, contact.normal_force)}"
    adhesion = f", adhesion {float(state(contact.adhesion)):.6g} N" if contact.adhesion != 0 else ""
    return _coefficient(model, state, contact.restitution) + adhesion


def _law(model: Model, law: Any) -> str:
    """Return the text of a law of a contact."""
    return expression_text(law, {**model.names.texts, **OWN_NAMES})


def _model(s: System, trajectory: Trajectory, symbols: Symbols) -> str:
    """Tables of bodies, joints, contacts, loads, constraints and parameters."""
    model = trajectory.kernels.model
    state = float_state(model, values=trajectory.values)

    def numbers(vector: Vector) -> str:
        return in_powers("(" + ", ".join(f"{float(state(x)):.6g}" for x in vector) + ")")

    bodies = [
        (
            name,
            in_powers(f"{float(state(place.mass)):.6g}"),
            numbers(place.center),
            numbers(tuple(place.inertia[i][i] for i in range(3))),
        )
        for name, place in model.bodies.items()
    ]
    parts = [
        "<h2>Model</h2>",
        _table(
            ("Body", "Mass [kg]", "Mass centre from its origin [m]", "Moments of inertia about it [kg m²]"),
            bodies,
        ),
    ]
    joints = [
        (name, joint.type, f"{joint.parent.name} – {joint.child.name}") for name, joint in s.joints.items()
    ]
    if joints:
        parts.append(_table(("Joint", "Type", "Between"), joints))
    if model.contacts:
        contacts = [
            (
                contact.name,
                f"{contact.feature.body.name} – {contact.surface.body.name}",
                _friction(model, state, contact),
                _restitution(model, state, contact),
            )
            for contact in model.contacts
        ]
        parts.append(_table(("Contact", "Between", "Friction", "Restitution"), contacts))
    if model.families:
        families = [
            (
                family.name,
                text_of_members(family),
                _friction(model, state, one),
                _restitution(model, state, one)
                + "".join(f", {x.law.about} {float(state(x.friction)):.6g} m" for x in resisting),
            )
            for family in model.families
            for one, *resisting in [family.representatives]
        ]
        parts.append(_table(("Family of contacts", "Members", "Friction", "Restitution"), families))
    kinds = [
        (name, re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(item).__name__).lower())
        for name, item in (*s.loads.items(), *s.constraints.items())
    ]
    if kinds:
        parts.append(_table(("Load or constraint", "Type"), kinds))
    rows = []
    for parameter in parameters_of(s):
        unit, text = about_of(s).get(parameter.name, ("", ""))
        value = in_powers(f"{trajectory.values[parameter.name]:.8g}")
        rows.append((Html(symbols.name(parameter.name)), value, unit, Html(symbols.words(text))))
    if rows:
        parts.append(_table(("Parameter", "Value", "Unit", "What it is"), rows, 1))
    return "\n".join(parts)


def _figures(figures: Mapping[str, Any]) -> str:
    if not figures:
        return ""
    parts = ["<h2>Figures</h2>"]
    for caption, picture in figures.items():
        data = base64.b64encode(png(picture)).decode("ascii")
        text = escape(caption)
        parts.append(
            f'<figure><img src="data:image/png;base64,{data}" alt="{text}" style="max-width:100%">'
            f"<figcaption>{text}</figcaption></figure>"
        )
    return "\n".join(parts)


def png(picture: Any) -> bytes:
    """Return a picture as PNG: from PNG bytes, matplotlib axes or figure, or a function that writes PNG to a path."""
    if isinstance(picture, bytes):
        return picture
    if callable(picture) and not hasattr(picture, "savefig"):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "figure.png")
            picture(file)
            return file.read_bytes()
    figure = getattr(picture, "figure", picture)
    if not hasattr(figure, "savefig"):
        raise SimulationError(
            f"Expected a figure as PNG bytes, matplotlib axes or a function of a path, got {picture!r}."
        )
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()


def _footer(trajectory: Trajectory, scene: Mapping[str, Any]) -> str:
    """Version, number of steps, and accuracy."""
    keys, lifted = len(scene["t"]), trajectory.energy.correction
    apart = ""
    if lifted is not None and lifted.any():
        apart = (
            f"Its work includes {lifted[-1]:.3g} J that moved overlapping bodies apart at the ends of steps. "
        )
    return in_powers(
        f"<footer>Made by freebody {escape(VERSION)}. {trajectory.steps} integration steps, relative tolerance "
        f"{float(min(trajectory.tolerances)):.1g}, energy ledger balanced to "
        f"{trajectory.energy.relative_residual:.1e}. {apart}"
        f"{keys} keyframes; between them the page interpolates to {scene['tolerance']:.1g} of the extent or the "
        "greatest value.</footer>"
    )
