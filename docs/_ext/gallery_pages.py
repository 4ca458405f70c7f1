"""A page for each system of the gallery, made from its entry: nothing about a system is written here.

What the module says of the machine, what is asked, the drawing, the free-body diagrams and equations, the answers as
formulas and numbers, the plots, and the code of the model. With ``-D systems_run=NAME,NAME`` only these systems are
run, and the pages of the others hold what needs no run: a look at the site does not have to wait for all.
"""

from __future__ import annotations

import ast
import inspect
import itertools
import multiprocessing
import os
import re
import sys
import textwrap
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from html import escape
from pathlib import Path
from typing import Any

from generated import fingerprint, finish, plain, up_to_date, write

import freebody as fb
from freebody.describe.description import about_of
from freebody.errors import SimulationError
from freebody.picture.page import balances
from freebody.picture.page.animation import frames_of, scene_of
from freebody.picture.page.page import page, stage
from freebody.picture.page.report import charts
from freebody.picture.page.simulator import simulator
from freebody.picture.page.symbols import Symbols, in_powers
from freebody.symbolic.printing.latex import label_latex

FOLDER = "systems"
LIVE = "pages/live"
"""Folder of the pages in frames, which the site has as ``live``."""
KEYS = 5e-3
"""Tolerance between the keyframes of these pages."""
LARGEST = 6
"""Speeds of the largest machine whose equations a page shows."""
WORKERS = 2


def setup(app: Any) -> dict[str, Any]:
    app.add_config_value("systems_run", "", "env", str)
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write_pages(app: Any) -> None:
    """Write all pages into ``docs/systems``, in as many processes as there are processors, two at most."""
    from freebody.gallery import entries

    folder = Path(app.srcdir) / FOLDER
    names = list(entries())
    chosen = [name for name in app.config.systems_run.split(",") if name] or names
    if unknown := set(chosen) - set(names):
        raise ValueError(
            f"Expected systems of the gallery in 'systems_run', got {', '.join(sorted(unknown))}."
        )
    stamp = " ".join([fingerprint(__file__), *chosen])
    if up_to_date(folder, stamp):
        return
    folder.mkdir(exist_ok=True)
    with ProcessPoolExecutor(
        min(WORKERS, os.cpu_count() or 1), multiprocessing.get_context("spawn"), _begin, (sys.path,)
    ) as pool:
        made = [
            path
            for paths in pool.map(_page, names, [folder] * len(names), [name in chosen for name in names])
            for path in paths
        ]
    for path in (folder / LIVE).glob("*.html"):
        if path not in made:
            path.unlink()
    made += [thumbnail(entry, folder) for entry in entries().values()]
    made.append(write(folder / "drawings.md", drawings()))
    finish(folder, stamp, {*made, write(folder / "index.md", index())})


def thumbnail(entry: Any, folder: Path) -> Path:
    """Draw the machine of an entry, for the lists of systems."""
    path = folder / f"{entry.name}-thumbnail.svg"
    _drawing(entry, entry.build()).save(path)
    return path


def _drawing(entry: Any, machine: Any) -> Any:
    """Draw the machine of an entry where the entry wants it drawn, with the blows that it gets."""
    blows = entry.blows(entry.build()) if entry.blows is not None else None
    return fb.draw(machine, **entry.drawing(), impulses=blows)


def drawings() -> str:
    """All machines on one page, drawn large."""
    from freebody.gallery import entries

    figures = [
        f"## [{plain(entry.title)}]({name}.md)\n\n![Drawing of {plain(entry.title)}]({name}-thumbnail.svg)\n"
        for name, entry in entries().items()
    ]
    return "\n".join(
        [
            "# All drawings\n",
            "What `freebody draw NAME` draws, for every system of the gallery.\n",
            *figures,
        ]
    )


def index() -> str:
    """The list of all systems, with their drawings."""
    from freebody.gallery import entries

    systems = [
        f"[![]({name}-thumbnail.svg) {plain(entry.title)}]({name}.md) `{short(entry).partition(' ')[0]}`\n"
        for name, entry in entries().items()
    ]
    return "\n".join(
        [
            "# Systems of the gallery\n",
            "Each page is made from the system itself, when this documentation is built: drawings, equations, answers",
            "and plots are what the library gives. `freebody run NAME` prints the same.",
            "[All drawings](drawings.md) are on one page, too.\n",
            ":::{container} thumbnails\n",
            *systems,
            ":::\n",
            "\n```{toctree}\n:hidden:\n",
            "All drawings <drawings>",
            *(f"{short(entry)} <{entry.name}>" for entry in entries().values()),
            "```\n",
        ]
    )


def short(entry: Any) -> str:
    """What the list of pages calls an entry: what stands in the chapter also by its readable name."""
    of_chapter = entry.name.startswith(("ex-", "sec-", "prob-"))
    return f"{entry.aliases[0]} ({entry.name})" if of_chapter and entry.aliases else entry.name


def _begin(path: list[str]) -> None:
    sys.path[:] = path


def _page(name: str, folder: Path, run: bool) -> list[Path]:
    """Run an entry, if it is to be run, and write its page with its pictures."""
    from freebody.gallery import entries

    entry = entries()[name]
    try:
        return Page(entry, folder, entry.run() if run else None).write()
    except Exception as error:
        raise RuntimeError(f"The page of '{name}' cannot be made: {type(error).__name__}: {error}") from error


class Page:
    """The page of an entry, and of what running it gave."""

    def __init__(self, entry: Any, folder: Path, outcome: Any) -> None:
        self.entry, self.folder, self.outcome = entry, folder, outcome
        self.made: list[Path] = []
        self.symbols = Symbols() if outcome is None else Symbols.of(outcome.equations.model, *outcome.answers)

    def write(self) -> list[Path]:
        parts = [f"# {plain(self.entry.title)}\n", self._statement()]
        if self.outcome is not None:
            parts += [self._live(), self._machine(), self._free_bodies(), self._answers(), self._plots()]
        parts += [self._code(), _html(self.symbols.table())]
        text = "\n".join(part for part in parts if part)
        self.made.append(write(self.folder / f"{self.entry.name}.md", text))
        return self.made

    def _statement(self) -> str:
        said = inspect.getdoc(sys.modules[self.entry.build.__module__]) or ""
        of_model = _told(inspect.getdoc(inspect.unwrap(self.entry.build)) or "")
        names = ", ".join(f"`freebody run {name}`" for name in (self.entry.name, *self.entry.aliases))
        paragraphs = [plain(part) for part in (*said.split("\n\n"), of_model) if part]
        asked = "\n".join(f"- {plain(line)}" for line in self.entry.asks)
        return "\n\n".join([*paragraphs, f"Asked ({names}):\n\n{asked}\n"])

    def _live(self) -> str:
        """The motion with its plots, in a frame; with sliders, if a page can compute it."""
        motion, name = self.outcome.trajectory, self.entry.name
        if not motion.kernels.model.bodies:
            return ""
        keys = frames_of(motion, KEYS)
        scene = scene_of(motion, keys)
        with suppress(SimulationError):
            scene["live"] = simulator(self.outcome.system, motion, keys, scene, {})
        live = "live" in scene
        symbols = Symbols.of(motion.kernels.model)
        heading = f'<h1 class="hidden">{escape(self.entry.title)}</h1>'
        body = f"{heading}\n{stage(live)}\n{charts(scene, symbols)}"
        folder = self.folder / LIVE
        folder.mkdir(parents=True, exist_ok=True)
        self.made.append(write(folder / f"{name}.html", page(self.entry.title, scene, body, symbols=symbols)))
        title = escape(self.entry.title)
        heading = "## Try it\n" if live else "## The motion\n"
        said = (
            "\nMove the sliders: the page computes the motion again, in your browser alone ([how](../report.md)).\n"
            if live
            else ""
        )
        frame = (
            f'<iframe src="../live/{name}.html" title="{title}" loading="lazy" class="live-page"></iframe>'
        )
        return f"{heading}{said}\n{_html(frame)}"

    def _machine(self) -> str:
        shown = _drawing(self.entry, self.outcome.equations)
        about = about_of(self.outcome.system)
        rows = [
            (
                self.symbols.name(name),
                in_powers(f"{value:.6g}"),
                escape(about.get(name, ("", ""))[0]),
                self.symbols.words(about.get(name, ("", ""))[1]),
            )
            for name, value in self.outcome.values.items()
        ]
        return "\n".join(
            [
                "## The machine\n",
                self._figures([(self._drawn(shown, "machine"), f"Drawing of {self.entry.title}")]),
                self._enlarged(),
                _table(("Parameter", "Default", "Unit", "What it is"), rows, number=1) if rows else "",
            ]
        )

    def _free_bodies(self) -> str:
        e = self.outcome.equations
        if e.model.n_u > LARGEST:
            drawn = [(fb.free_body_diagram(e, one, near=self.entry.near), one) for one in e.model.bodies]
            figures = [
                (self._drawn(shown, f"body-{one}"), f"Free-body diagram of {one}") for shown, one in drawn
            ]
            return (
                f"## Free bodies\n\nThis machine has {e.model.n_u} speeds, too many to read its equations on a page; "
                f"`freebody equations {self.entry.name}` prints them.\n\n{self._figures(figures)}"
            )
        parts = ["## Free bodies and their equations\n", _html(balances.laws(e, self.symbols))]
        for name in e.model.bodies:
            drawn = fb.free_body_diagram(e, name, **self.entry.drawing())
            parts += [
                f"### {plain(name)}\n",
                self._figures([(self._drawn(drawn, f"body-{name}"), f"Free-body diagram of {name}")]),
                _html(balances.free_body(e, name, self.symbols)),
            ]
        return "\n".join(
            [
                *parts,
                "## Equations of motion\n",
                _html(balances.motion(e, self.symbols, self.entry.names)),
            ]
        )

    def _answers(self) -> str:
        from freebody.scalar.digits import significant

        rows: list[str] = []
        meant: dict[str, Any] = {}
        for key, answer in self.outcome.answers.items():
            of_motion = answer.formula is not None and not answer.unit and isinstance(answer.value, str)
            shown = (
                ""
                if of_motion
                else f"{significant(answer.value)} {answer.unit if answer.unit != '1' else ''}"
            )
            rows.append(
                f"<tr><td>{self.symbols.name(key)}</td><td>{self.symbols.words(answer.question)}</td><td>{escape(shown)}</td></tr>"
            )
            if answer.formula is not None:
                formula = self.symbols.formula(answer.latex) if answer.latex else escape(answer.text)
                rows.append(f'<tr class="formulas"><td></td><td colspan="2"><div>{formula}</div></td></tr>')
            meant |= {name: x for name, x in answer.meanings.items() if name not in self.outcome.answers}
        head = "<thead><tr><th>Key</th><th>Question</th><th>Value</th></tr></thead>"
        body = "\n".join(rows)
        parts = ["## Answers\n", _html(f'<table class="answers">{head}<tbody>\n{body}\n</tbody></table>')]
        if meant:
            lines = [self.symbols.formula(f"{label_latex(name)} = {x.latex}") for name, x in meant.items()]
            parts += ["with\n", _html("\n".join(lines))]
        checks = [f"- {plain(check.sentence)}" for check in self.outcome.checks]
        if checks:
            parts += ["Checks:\n", "\n".join(checks) + "\n"]
        return "\n".join(parts)

    def _plots(self) -> str:
        from freebody.cli.run import happenings

        pictures = []
        for file, draw in self.outcome.plots.items():
            if file == "energy.png":  # the ledger's residual: of interest to the checks, not to the reader
                continue
            path = self.folder / f"{self.entry.name}-{file}"
            draw(path)
            self.made.append(path)
            pictures.append((path, f"Plot: {Path(file).stem.replace('_', ' ')}"))
        events = "\n".join(happenings(self.outcome.trajectory, self.outcome.events)).strip()
        parts = ["## Motion\n", self._figures(pictures)]
        if events:
            parts.append(f"```text\n{events}\n```\n")
        return "\n".join(parts)

    def _code(self) -> str:
        return f"## The model\n\n```python\n{code_of(self.entry.build)}\n```\n"

    def _enlarged(self) -> str:
        names = [self.symbols.name(name) for name in self.entry.enlarged]
        return _html(f"<p>The drawing shows {', '.join(names)} larger than by default.</p>") if names else ""

    def _drawn(self, drawing: Any, name: str) -> Path:
        path = self.folder / f"{self.entry.name}-{name}.svg"
        drawing.save(path)
        self.made.append(path)
        return path

    def _figures(self, pictures: list[tuple[Path, str]]) -> str:
        shown = "\n".join(f"![{plain(about)}]({path.name})" for path, about in pictures)
        return f":::{{container}} figures\n{shown}\n:::\n"


def _told(documentation: str) -> str:
    """What the documentation of a function says of the system that it returns."""
    text = re.sub(r"^Return (the system[;,.] )?", "", documentation)
    return re.sub("^(an?|the) ", lambda found: found[0].capitalize(), text)


# -- the code of a model --------------------------------------------------------------------------------------


LOOKS = ("look", "placed", "rim", "with_shaft")
"""Functions of the gallery that return the look of a body."""


def code_of(build: Any) -> str:
    """The source of a function that builds a system, and of what it uses of the gallery's modules.

    Without documentation, which the page has already, without ``explain``, which the table of parameters shows, and
    without the looks of bodies that the gallery draws in more than a solid.
    """
    wanted = [(build.__module__, build.__name__)]
    found: dict[tuple[str, str], str] = {}
    head: set[str] = set()
    while wanted:
        module, name = wanted.pop(0)
        texts = Texts(module)
        if name in texts.own and (module, name) not in found:
            found[module, name] = texts.source(name)
            wanted += [texts.origin(used) for used in texts.used(name)]
            head |= texts.imports(name)
    shown = list(found.values())
    return "\n".join([*sorted(head), "", *"\n".join(reversed(shown)).splitlines()])


class Texts:
    """The texts of what a module defines, by name."""

    def __init__(self, module: str) -> None:
        self.module = module
        text = inspect.getsource(sys.modules[module])
        self.tree, self.lines = ast.parse(text), text.splitlines()
        self.own: dict[str, ast.stmt] = {}
        for node in self.tree.body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                self.own[node.name] = node
            elif isinstance(node, ast.Assign):
                self.own |= {target.id: node for target in node.targets if isinstance(target, ast.Name)}

    def _left_out(self, name: str) -> set[int]:
        left_out: set[int] = set()
        for inner in ast.walk(self.own[name]):
            looks = isinstance(inner, ast.Assign) and _called(inner.value) in LOOKS
            if looks or (
                isinstance(inner, ast.Expr) and (_is_text(inner) or _called(inner.value) == "explain")
            ):
                left_out |= set(range(inner.lineno, (inner.end_lineno or inner.lineno) + 1))
        return left_out

    def source(self, name: str) -> str:
        """Its lines, without documentation."""
        node, left_out = self.own[name], self._left_out(name)
        span = range(node.lineno, (node.end_lineno or node.lineno) + 1)
        lines = {i: self.lines[i - 1] for i in span}
        for first, last in sorted(self._cuts(name), reverse=True):
            lines[first[0]] = lines[first[0]][: first[1]] + lines[last[0]][last[1] :]
            left_out |= set(range(first[0] + 1, last[0] + 1))
        kept = [line for i, line in lines.items() if i not in left_out]
        return textwrap.dedent("\n".join(kept)).strip("\n") + "\n"

    def _looks(self, name: str) -> list[ast.keyword]:
        """The arguments ``shape=`` that are made by a function of looks."""
        made = {
            target.id
            for inner in ast.walk(self.own[name])
            if isinstance(inner, ast.Assign) and _called(inner.value) in LOOKS
            for target in inner.targets
            if isinstance(target, ast.Name)
        }
        return [
            inner
            for inner in ast.walk(self.own[name])
            if isinstance(inner, ast.keyword)
            and inner.arg == "shape"
            and (
                _called(inner.value) in LOOKS
                or (isinstance(inner.value, ast.Subscript) and ast.unparse(inner.value.value) in made)
            )
        ]

    def _cuts(self, name: str) -> list[tuple[tuple[int, int], tuple[int, int]]]:
        """Spans of text from the end of the argument before a look to the end of the look: (line, column) each."""
        looks, spans = self._looks(name), []
        for call in ast.walk(self.own[name]):
            arguments = [*call.args, *call.keywords] if isinstance(call, ast.Call) else []
            for before, after in itertools.pairwise(arguments):
                if after in looks:
                    spans.append((_end(before), _end(after)))
        return spans

    def used(self, name: str) -> list[str]:
        """Names that stand in its lines."""
        left_out = self._left_out(name)
        hidden = {id(n) for look in self._looks(name) for n in ast.walk(look)}
        nodes = (
            n
            for n in ast.walk(self.own[name])
            if isinstance(n, ast.Name) and n.lineno not in left_out and id(n) not in hidden
        )
        return list(dict.fromkeys(n.id for n in nodes))

    def origin(self, name: str) -> tuple[str, str]:
        """Module and name of what a name of this module stands for, if another module of the gallery has it."""
        for node in self.tree.body:
            if isinstance(node, ast.ImportFrom) and node.level:
                room = ".".join(self.module.split(".")[: -node.level])
                for alias in node.names:
                    if (alias.asname or alias.name) == name and room.startswith("freebody.gallery"):
                        return f"{room}.{node.module}", alias.name
        return self.module, name

    def imports(self, name: str) -> set[str]:
        """The imports from outside of the gallery that it uses."""
        return {
            ast.unparse(node)
            for node in self.tree.body
            if isinstance(node, ast.Import | ast.ImportFrom) and not getattr(node, "level", 0)
            for alias in node.names
            if (alias.asname or alias.name) in self.used(name)
        }


def _is_text(node: ast.Expr) -> bool:
    return isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def _called(value: ast.expr) -> str:
    """Name of the function that an expression calls; empty for other expressions."""
    return value.func.id if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) else ""


def _end(node: ast.expr | ast.keyword) -> tuple[int, int]:
    return node.end_lineno or 0, node.end_col_offset or 0


# -- HTML -------------------------------------------------------------------------------------------------------


def _html(text: str) -> str:
    return f"```{{raw}} html\n{text}\n```\n" if text else ""


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]], number: int) -> str:
    top = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "\n".join(
        "<tr>"
        + "".join(f"<td{' class=number' if i == number else ''}>{cell}</td>" for i, cell in enumerate(row))
        + "</tr>"
        for row in rows
    )
    return _html(
        f'<div class="wide" tabindex="0"><table><thead><tr>{top}</tr></thead><tbody>\n{body}\n</tbody></table></div>'
    )
