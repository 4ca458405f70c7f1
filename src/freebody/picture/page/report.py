"""The report: one HTML page with everything about a machine and its motion, which opens offline."""

from __future__ import annotations

import base64
import os
from collections.abc import Callable, Mapping
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...describe.description import about_of, parameters_of
from ...describe.system import System
from ...dynamics.state import float_state
from ...errors import FormatError, ModelError, SimulationError, TooManyTermsError, path_of
from ...formats.files import replacing
from ...model.assemble import assemble
from ...model.model import Model
from ...symbolic.equations import Equations
from ...symbolic.equations import equations as equations_of
from ...version import VERSION
from ..moving.keyframes import TOLERANCE
from .animation import animation
from .answers import answers_table
from .longest_phases import lasting
from .page import page

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

OPEN = 3
"""Charts that are open when the page is."""

LONGEST = 60_000
"""Characters of a system of equations that is still shown."""

LARGEST = 6
"""Speeds of the largest machine whose equations are formed without being asked for."""


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
) -> Path:
    """Write one HTML page about a machine and its motion; it opens offline, and no request leaves it.

    The page has the animation (play, scrub, speed, orbit, trails, arrows of forces and reactions, frames, cones), plots
    whose cursor goes with it, a summary of the model, its drawing and free-body diagrams, equations and answers.

    Parameters
    ----------
    s : System
    trajectory : Trajectory
        Of this system.
    path : path
        The file, written whole or not at all.
    title, about : str, optional
        Plain text at the top; the title is the system's name if not given.
    answers : mapping, optional
        Name -> value, (value, unit), or an answer of the gallery with its question and formula.
    figures : mapping, optional
        Caption -> PNG as bytes, matplotlib axes or figure, or a function that writes a PNG to a path.
    equations : bool, optional
        Whether free-body diagrams and equations are shown; if not given, for machines of up to six speeds.
    tolerance : float
        Of the animation between its keyframes; see :func:`freebody.picture.moving.keyframes.keyframes`.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ModelError
        A trajectory of another system.
    FormatError
        A path that can not be written, or is none of a page.

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
    if target.suffix.lower() not in (".html", ".htm"):
        raise FormatError(f"Expected a file name that ends in .html for a report, got '{target.name}'.")
    text = document(
        s,
        trajectory,
        title=title,
        about=about,
        answers=answers,
        figures=figures,
        equations=equations,
        tolerance=tolerance,
    )
    with replacing(target) as new:
        new.write_text(text, encoding="utf-8")
    return target


def document(
    s: System,
    trajectory: Trajectory,
    *,
    title: str | None = None,
    about: str = "",
    answers: Mapping[str, Any] | None = None,
    figures: Mapping[str, Any] | None = None,
    equations: bool | None = None,
    tolerance: float = TOLERANCE,
) -> str:
    """The text of the page that :func:`report` writes."""
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
    scene = animation(trajectory, tolerance)
    shown = model.n_u <= LARGEST if equations is None else equations
    parts = [
        f"<h1>{escape(title or s.name)}</h1>",
        f'<p class="sub">{escape(about or _sentence(trajectory))}</p>',
        _warnings(trajectory),
        '<div id="player"></div>',
        answers_table(answers or {}),
        "<h2>Plots</h2>\n" + charts(scene),
        _phases(trajectory) if shown else _withheld(),
        _model(s, trajectory),
        _figures(figures or {}),
        _footer(trajectory, scene),
    ]
    return page(title or s.name, scene, "\n".join(part for part in parts if part))


# -- sections ----------------------------------------------------------------------------------------------


def _sentence(trajectory: Trajectory) -> str:
    text = repr(trajectory).partition(": ")[2]
    return text[:1].upper() + text[1:]


def _warnings(trajectory: Trajectory) -> str:
    """What of the motion is not physical, above everything else."""
    lines = "".join(f"<li>{escape(str(one))}</li>" for one in trajectory.warnings)
    return f"<h2>Warnings</h2>\n<ul>{lines}</ul>" if lines else ""


def _table(head: tuple[str, ...], rows: list[tuple[Any, ...]], number: int = -1) -> str:
    top = "".join(f"<th>{escape(name)}</th>" for name in head)
    lines = []
    for row in rows:
        kinds = (' class="number"' if i == number else "" for i in range(len(row)))
        cells = (f"<td{kind}>{escape(str(x))}</td>" for kind, x in zip(kinds, row, strict=True))
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return (
        f'<div class="wide"><table><thead><tr>{top}</tr></thead><tbody>{"".join(lines)}</tbody></table></div>'
    )


def charts(scene: Mapping[str, Any]) -> str:
    """The charts of a page as HTML, each to be opened; those of the first coordinates and of the energy are open."""
    opened = {
        next((i for i, one in enumerate(scene["charts"]) if one["group"] == g), -1)
        for g in ("coordinates", "energy")
    }
    parts = []
    for i, one in enumerate(scene["charts"]):
        state = " open" if i in opened or len(scene["charts"]) <= OPEN else ""
        parts.append(
            f'<details{state}><summary>{escape(one["title"])}</summary><div data-chart="{i}"></div></details>'
        )
    return "\n".join(parts)


def _withheld() -> str:
    return (
        "<h2>Equations</h2>\n<p>Free-body diagrams and equations are not shown for a machine of this size: "
        "<code>fb.report(…, equations=True)</code> or <code>fb.equations(s).text()</code> gives them.</p>"
    )


def _phases(trajectory: Trajectory) -> str:
    """Drawing, diagrams and equations; of a motion with contacts in each of the modes that lasted longest."""
    model = trajectory.kernels.model
    sets = lasting(trajectory)
    if not sets:
        return _equations(equations_of(model), trajectory)
    parts: list[str] = []
    for modes, time in sets:
        words = ", ".join(f"{name} {mode}" for name, mode in _by_owner(modes, model).items())
        heading = f" <small>({escape(words)}; {time:.4g} s of the motion)</small>"
        parts.append(_equations(equations_of(model, modes=modes), trajectory, heading, not parts))
    return "\n".join(parts)


def _by_owner(modes: Mapping[str, str], model: Model) -> dict[str, str]:
    """Modes of contacts; where all elements of one are in the same mode, once."""
    elements: dict[str, list[str]] = {}
    for contact in model.contacts:
        elements.setdefault(contact.owner, []).append(contact.name)
    result: dict[str, str] = {}
    for owner, names in elements.items():
        same = len({modes[name] for name in names}) == 1
        result |= {owner: modes[names[0]]} if same else {name: modes[name] for name in names}
    return result


def _equations(e: Equations, trajectory: Trajectory, heading: str = "", drawing: bool = True) -> str:
    parts = [
        _or_refusal(lambda: _drawings(e, trajectory, heading, drawing)),
        f"<h2>Free-body equations{heading}</h2>",
    ]
    for name in e.model.bodies:
        parts.append(f"<h3>{escape(name)}</h3>")
        parts.append(_or_refusal(partial(_free_body, e, name)))
    parts += [f"<h2>Equations of motion{heading}</h2>", _or_refusal(lambda: formulas(e.mathml()))]
    return "\n".join(parts)


def _free_body(e: Equations, name: str) -> str:
    return formulas(e.free_body(name).mathml())


def _or_refusal(made: Callable[[], str]) -> str:
    """A part of the page, or why it would be too long."""
    try:
        return made()
    except TooManyTermsError as error:
        return f"<p>{escape(str(error))}</p>"


def formulas(text: str) -> str:
    """Lines of MathML, each in a block of its own."""
    if len(text) > LONGEST:
        return f"<p>Too long to show ({len(text):,} characters of MathML).</p>"
    return "\n".join(f'<div class="equation">{line}</div>' for line in text.splitlines())


def _model(s: System, trajectory: Trajectory) -> str:
    model = trajectory.kernels.model
    state = float_state(model, values=trajectory.values)

    def numbers(vector: Any) -> str:
        return "(" + ", ".join(f"{float(state(x)):.6g}" for x in vector) + ")"

    bodies = [
        (
            name,
            f"{float(state(place.mass)):.6g}",
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
        touching = [
            (
                contact.name,
                f"{contact.feature.body.name} – {contact.surface.body.name}",
                *(f"{float(state(x)):.6g}" for x in (contact.friction, contact.restitution)),
            )
            for contact in model.contacts
        ]
        parts.append(_table(("Contact", "Between", "Friction", "Restitution"), touching))
    others = [(name, type(one).__name__) for name, one in (*s.loads.items(), *s.constraints.items())]
    if others:
        parts.append(_table(("Load or constraint", "Type"), others))
    rows = []
    for parameter in parameters_of(s):
        unit, text = about_of(s).get(parameter.name, ("", ""))
        rows.append((parameter.name, f"{trajectory.values[parameter.name]:.8g}", unit, text))
    if rows:
        parts.append(_table(("Parameter", "Value", "Unit", "What it is"), rows, 1))
    return "\n".join(parts)


def _drawings(e: Equations, trajectory: Trajectory, heading: str, whole: bool) -> str:
    """The machine and its free-body diagrams, in the configuration that shows most."""
    from ..free_body.free_body_diagram import free_body_diagram
    from ..machine.draw import draw

    parts = []
    if whole:
        parts.append(
            f"<h2>Drawing</h2>\n<figure>{draw(trajectory.kernels.model, values=trajectory.values).svg}</figure>"
        )
    parts += [f"<h2>Free-body diagrams{heading}</h2>", '<div class="figures">']
    for name in e.model.bodies:
        drawing = free_body_diagram(e, name, values=trajectory.values)
        parts.append(f"<figure>{drawing.svg}<figcaption>{escape(name)}</figcaption></figure>")
    return "\n".join([*parts, "</div>"])


def _figures(figures: Mapping[str, Any]) -> str:
    if not figures:
        return ""
    parts = ["<h2>Figures</h2>"]
    for caption, given in figures.items():
        data = base64.b64encode(png(given)).decode("ascii")
        text = escape(caption)
        parts.append(
            f'<figure><img src="data:image/png;base64,{data}" alt="{text}" style="max-width:100%">'
            f"<figcaption>{text}</figcaption></figure>"
        )
    return "\n".join(parts)


def png(given: Any) -> bytes:
    """A picture as PNG: bytes, matplotlib axes or figure, or a function that writes one to a path."""
    if isinstance(given, bytes):
        return given
    if callable(given) and not hasattr(given, "savefig"):
        import tempfile

        write: Callable[[Path], Any] = given
        with tempfile.TemporaryDirectory() as folder:
            write(Path(folder, "figure.png"))
            return Path(folder, "figure.png").read_bytes()
    figure = getattr(given, "figure", given)
    if not hasattr(figure, "savefig"):
        raise SimulationError(
            f"Expected a figure as PNG bytes, matplotlib axes or a function of a path, got {given!r}."
        )
    import io

    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()


def _footer(trajectory: Trajectory, scene: Mapping[str, Any]) -> str:

    keys = len(base64.b64decode(scene["t"])) // 4
    return (
        f"<footer>Made by freebody {escape(VERSION)}. {trajectory.steps} integration steps, relative tolerance "
        f"{float(min(trajectory.tolerances)):.1g}, energy ledger balanced to "
        f"{trajectory.energy.relative_residual:.1e}. "
        f"{keys} keyframes; between them the page interpolates to {scene['tolerance']:.1g} of the extent or the "
        "greatest value, and shows numbers as 32-bit floats.</footer>"
    )
