"""Pages of the public names, one for each subject, made from the docstrings."""

from __future__ import annotations

import importlib
import inspect
import itertools
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from generated import fingerprint, finish, plain, up_to_date, write

import freebody as fb

FOLDER = "reference"

SUBJECTS = {
    "describe": "Describing a machine",
    "space": "Solids, mass, pose and rotation",
    "model": "The assembled machine",
    "symbolic": "Equations and analysis",
    "motion": "Motion",
    "program": "Compiled dynamics",
    "studies": "Studies",
    "picture": "Pictures",
    "formats": "Files",
}
"""Title of the page on a room of the library; a room that is not named here has its own name."""

RESULTS = {
    "symbolic": [
        "symbolic.equations.Equations",
        "symbolic.free_body.free_body.FreeBody",
        "symbolic.solving.solution.SolveResult",
        "symbolic.integrals.conserved_quantities.Integrals",
        "symbolic.steady.steady.SteadyMotions",
        "symbolic.linear.linear_model.LinearModel",
        "symbolic.linear.modes.Modes",
        "symbolic.steady.motion.SteadyMotion",
        "symbolic.impulses.impulse.Struck",
        "symbolic.linear.response.Response",
        "symbolic.rotors.bearings.BearingReactions",
        "symbolic.rotors.balancing.Balance",
    ],
    "motion": ["motion.trajectory.event.Event"],
    "program": ["program.program.Program"],
    "picture": ["picture.paper.drawing.Drawing"],
}
"""Classes that public functions return, under freebody: users read them and do not make them.

They are shown as ``results.Equations``, so that neither the pages nor the search speak of files.
"""


def setup(app: Any) -> dict[str, Any]:
    sys.modules["results"] = results()
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", readable, priority=100)  # before napoleon
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def results() -> ModuleType:
    """Return the module under whose name results are documented."""
    module = ModuleType("results")
    for path in itertools.chain(*RESULTS.values()):
        home, _, name = path.rpartition(".")
        setattr(module, name, getattr(importlib.import_module(f"freebody.{home}"), name))
    return module


def write_pages(app: Any) -> None:
    """Write the pages into ``docs/reference``."""
    folder = Path(app.srcdir) / FOLDER
    stamp = fingerprint(__file__)
    if up_to_date(folder, stamp):
        return
    folder.mkdir(exist_ok=True)
    made, listed = set(), []
    for room, names in by_subject().items():
        made.add(write(folder / f"{room}.md", page(SUBJECTS.get(room, room.capitalize()), room, names)))
        listed.append(room)
    text = (
        "# Reference\n\nEvery public name, from its own documentation; `import freebody as fb`. Functions return the\n"
        "classes under `results`.\n\n"
    )
    made.add(
        write(folder / "index.md", text + "```{toctree}\n" + "\n".join([*listed, "bibliography"]) + "\n```\n")
    )
    finish(folder, stamp, {*made, folder / "bibliography.md"})


def by_subject() -> dict[str, list[str]]:
    """Public names by the room they come from; modules are subjects of their own."""
    found: dict[str, list[str]] = {room: [] for room in SUBJECTS}
    for name in fb.__all__:
        if name.startswith("__"):
            continue
        value = getattr(fb, name)
        if not isinstance(value, ModuleType) and not value.__module__.startswith("freebody"):
            continue  # a name for annotations: fb.Expression, fb.Vector
        room = name if isinstance(value, ModuleType) else value.__module__.split(".")[1]
        found.setdefault(room, []).append(name)
    return {room: names for room, names in found.items() if names}


def page(title: str, room: str, names: list[str]) -> str:
    blocks = []
    about = ""
    for name in names:
        value = getattr(fb, name)
        if isinstance(value, ModuleType):
            title = f"fb.{name}"
            about = plain((inspect.getdoc(value) or "").split("\n\n")[0]) + "\n\n"
            blocks += [(_directive(one), f"freebody.{name}.{one.__qualname__}", "") for one in _public(value)]
        else:
            more = "   :members:\n   :inherited-members:\n" if isinstance(value, type) else ""
            blocks.append((_directive(value), f"freebody.{name}", more))
    more = "   :members:\n" + "   :inherited-members:\n" * (
        room in ("describe", "symbolic")
    )  # their base classes are internal
    blocks += [("autoclass", f"results.{path.rpartition('.')[2]}", more) for path in RESULTS.get(room, [])]
    shown = [f"```{{eval-rst}}\n.. {kind}:: {path}\n{more}```\n" for kind, path, more in blocks]
    return f"# {title}\n\n{about}" + "\n".join(shown)


def _directive(value: Any) -> str:
    return "autoclass" if isinstance(value, type) else "autofunction"


def _public(module: ModuleType) -> list[Any]:
    """Functions and classes of a module: those that it names, or those that are its own."""
    if hasattr(module, "__all__"):
        found = [getattr(module, name) for name in module.__all__]
    else:
        found = [v for n, v in vars(module).items() if not n.startswith("_") and _own(v, module)]
    return [one for one in found if callable(one)]


def _own(value: Any, module: ModuleType) -> bool:
    return callable(value) and getattr(value, "__module__", "") == module.__name__


# -- docstrings -------------------------------------------------------------------------------------------------


def readable(app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Docstrings are written to be read as text: formulas as they are, and an indented line is a formula.

    Markup signs in their prose are escaped, and indented paragraphs before the first section become literal.
    """
    result: list[str] = []
    literal = section = session = False
    for i, line in enumerate(lines):
        below = lines[i + 1].strip() if i + 1 < len(lines) else ""
        if below and set(below) == {"-"} and line.strip():
            section = True
        blank = not line.strip()
        if not section:
            starts = line.startswith("    ") and (i == 0 or not lines[i - 1].strip())
            if starts and not literal:
                before = next((one for one in reversed(result) if one.strip()), "")
                result += [] if before.endswith("::") else ["::", ""]
                literal = True
            elif not blank and not line.startswith("    "):
                literal = False
        session = bool(line.strip()) and (session or line.lstrip().startswith(">>>"))
        result.append(line if literal or session else _escaped(line))
    lines[:] = result


def _escaped(line: str) -> str:
    kept = r"``.*?``|:[a-z]+:`.*?`|https?://\S+|(?<![\w)*])\*[A-Za-z][A-Za-z ]*\*(?![\w(*])"  # code, roles, *emphasis*
    parts = re.split(f"({kept})", line)
    return "".join(
        p if i % 2 else re.sub(r"([*|])|(?<=\w)_(?!\w)", r"\\\g<0>", p) for i, p in enumerate(parts)
    )
