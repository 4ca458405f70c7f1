"""The rooms of the package, read from its import statements: their order, a table and a drawing.

``python docs/_ext/house.py`` writes the drawing ``docs/house.svg`` and the table in ``docs/architecture.md`` anew; a
test checks that both are up to date.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable
from functools import cache
from html import escape
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1]
PACKAGE = DOCS.parent / "src" / "freebody"
OPEN, CLOSE = "<!-- rooms -->", "<!-- end of rooms -->"

Graph = dict[str, set[str]]


def modules(package: Path = PACKAGE) -> dict[str, Path]:
    """Modules of the package by name, such as ``"motion.ode.dop853"``; a room is its ``__init__``."""
    found = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def imports(package: Path = PACKAGE) -> Graph:
    """Modules that each module imports, at its top, inside functions and for type checking."""
    names = modules(package)
    graph: Graph = {}
    for name, path in names.items():
        room = name if path.name == "__init__.py" else name.rpartition(".")[0]
        graph[name] = set()
        for node in ast.walk(ast.parse(path.read_bytes())):
            if not isinstance(node, ast.ImportFrom):
                continue
            parts = room.split(".") if room else []
            if node.level:
                base = [*parts[: len(parts) - node.level + 1], *filter(None, (node.module or "").split("."))]
            elif node.module and node.module.split(".")[0] == "freebody":
                base = node.module.split(".")[1:]
            else:
                continue
            for alias in node.names:
                whole = ".".join([*base, alias.name])
                graph[name].add(whole if whole in names else ".".join(base))
    return graph


def rooms(graph: Graph, inside: str = "") -> Graph:
    """Rooms and the rooms that they import; with ``inside`` the inner rooms of one room, and the files at its top."""
    depth = inside.count(".") + 1 if inside else 0
    result: Graph = {}

    def place(name: str) -> str | None:
        parts = name.split(".")
        if inside and parts[:depth] != inside.split("."):
            return None
        return parts[depth] if len(parts) > depth and parts[depth] else None

    for name, used in graph.items():
        here = place(name)
        if here is None:
            continue
        result.setdefault(here, set()).update(x for x in map(place, used) if x not in (None, here))
    return result


def circles(graph: Graph) -> list[tuple[str, ...]]:
    """Groups of nodes that can be reached from each other."""
    reach = {node: _reached(graph, node) for node in graph}
    groups = {tuple(sorted(x for x in reach[node] if node in reach.get(x, ()))) for node in graph}
    return sorted(group for group in groups if len(group) > 1)


def floors(graph: Graph) -> list[list[str]]:
    """Nodes by floor, bottom first: each stands one floor above the highest that it imports."""
    level: dict[str, int] = {}

    def of(node: str) -> int:
        if node not in level:
            level[node] = 1 + max((of(x) for x in graph[node]), default=-1)
        return level[node]

    for node in graph:
        of(node)
    return [sorted(x for x in level if level[x] == k) for k in range(max(level.values()) + 1)]


def reduced(graph: Graph) -> Graph:
    """The graph without the arrows that follow from others."""
    return {
        a: {b for b in used if not any(b in _reached(graph, c) for c in used - {b})}
        for a, used in graph.items()
    }


def _reached(graph: Graph, node: str) -> set[str]:
    reached: set[str] = set()
    waiting = [node]
    while waiting:
        new = graph.get(waiting.pop(), set()) - reached
        reached |= new
        waiting += new
    return reached


# -- table ----------------------------------------------------------------------------------------------------


def table() -> str:
    """Rooms from top to bottom, with their inner rooms and the first sentence of each."""
    graph, names = imports(), modules()
    lines = ["| room | what it is | inner rooms, top to bottom | files |", "|---|---|---|---|"]
    for floor in reversed(floors(rooms(graph))):
        for room in floor:
            path = names[room]
            sentence = (
                (ast.get_docstring(ast.parse(path.read_bytes())) or "")
                .split("\n")[0]
                .rstrip(".")
                .replace("``", "`")
            )
            if path.name != "__init__.py":
                lines.append(f"| `{room}.py` | {sentence} | | |")
                continue
            inner = [
                x for level in reversed(floors(rooms(graph, room))) for x in level if f"{room}.{x}" in names
            ]
            inner = [x for x in inner if names[f"{room}.{x}"].name == "__init__.py"]
            files = sum(name.startswith(f"{room}.") and names[name].name != "__init__.py" for name in names)
            lines.append(f"| `{room}/` | {sentence} | {', '.join(f'`{x}/`' for x in inner)} | {files} |")
    return "\n".join(lines)


# -- drawing ------------------------------------------------------------------------------------------------------

WIDE, HIGH, GAP, RISE = 104, 24, 10, 44
"""A box, the space between two, and the height of a floor [px]."""
DRAWN = (("", "motion", "picture"), ("symbolic", "program"))
"""Rows of panels of the drawing: the whole house, and the rooms with inner rooms of their own."""


def drawing() -> str:
    """The house as SVG: an arrow goes from a room to what it imports, unless other arrows say so already."""
    graph = imports()
    top, width, shown = 0, 0, []
    for names in DRAWN:
        panels, left = [_panel(name, _folders(graph, name)) for name in names], 0
        height = max(high for _, _, high in panels)
        for text, wide, high in panels:
            shown.append(f'<g transform="translate({left},{top + height - high})">{text}</g>')
            left += wide + 40
        top, width = top + height + 30, max(width, left - 40)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="-2 0 {width + 4} {top}" font-family="sans-serif" '
        f'font-size="12" role="img"><title>The rooms of freebody and what they import</title>{"".join(shown)}</svg>\n'
    )


def _folders(graph: Graph, inside: str) -> Graph:
    """Rooms of the package, or the inner rooms of one room with the files at its top."""
    names = modules()
    whole = rooms(graph, inside)
    if inside:
        label = {x: x if names[f"{inside}.{x}"].name == "__init__.py" else f"{x}.py" for x in whole}
    else:
        label = {x: x for x in whole if names[x].name == "__init__.py"}
    return {label[x]: {label[y] for y in used if y in label} for x, used in whole.items() if x in label}


def _panel(name: str, graph: Graph) -> tuple[str, int, int]:
    levels = floors(graph)
    most = max(map(len, levels))
    wide, high = most * (WIDE + GAP) - GAP, len(levels) * RISE + 20
    at = {}
    for k, level in enumerate(levels):
        begin = (wide - len(level) * (WIDE + GAP) + GAP) / 2
        for i, node in enumerate(level):
            at[node] = (begin + i * (WIDE + GAP), high - (k + 1) * RISE + RISE - HIGH)
    lines = [
        f'<path d="M{at[a][0] + WIDE / 2:g},{at[a][1] + HIGH:g} L{at[b][0] + WIDE / 2:g},{at[b][1]:g}"/>'
        for a, used in sorted(reduced(graph).items())
        for b in sorted(used)
    ]
    boxes = [
        f'<rect x="{x:g}" y="{y:g}" width="{WIDE}" height="{HIGH}" rx="4" fill="#fff" stroke="#345"/>'
        f'<text x="{x + WIDE / 2:g}" y="{y + 16:g}" text-anchor="middle">{escape(node)}</text>'
        for node, (x, y) in at.items()
    ]
    title = f'<text x="0" y="12" font-weight="bold">{escape(name or "freebody")}</text>'
    return f'{title}<g stroke="#9ab" fill="none">{"".join(lines)}</g>{"".join(boxes)}', wide, high


def with_table(text: str) -> str:
    """The text of the page with a new table."""
    before, _, rest = text.partition(OPEN)
    _, _, after = rest.partition(CLOSE)
    return f"{before}{OPEN}\n\n{table()}\n\n{CLOSE}{after}"


def write(paths: Iterable[tuple[Path, str]]) -> None:
    for path, text in paths:
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    page = DOCS / "architecture.md"
    write([(DOCS / "house.svg", drawing()), (page, with_table(page.read_text(encoding="utf-8")))])
