"""How a drawing follows the parameters: its numbers as functions of them, measured on drawings.

    f(p) = f(p₀) + Σ_k s_k (p_k - p₀_k)      lengths, radii and places of points, unless lengths are multiplied
    f(p) = f(p₀) + Σ_k g_k(p_k)              g_k between nodes: turns of parts, half axes of an ellipsoid of inertia

Either form is checked for each parameter by itself, and for all together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ..moving.keyframes import Keyframes
from .animation import figure
from .sliders import range_of

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

Path = tuple[Any, ...]
Tree = Mapping[Path, Any]
"""Numbers and texts of a drawing, by their paths in its data."""
Change = float | NDArray[np.float64]
"""How a number changes with a parameter: its slope, or its changes at the nodes."""
Drawn = Callable[[Mapping[str, float]], Tree]

PARTS = (-0.5, -0.2, 0.3, 0.5)
"""Changes of a parameter, as parts of its value, at which the drawing is compared with its linear extrapolation."""

NODES, BETWEEN = 17, 4
"""Number of nodes over the range of a slider, and of values between them at which the drawing is compared."""

ROUND, SEEN = 1e-9, 1e-2
"""Difference from the linear form, and from interpolation, that is admitted: round-off, and what the eye does not see.
Relative to the number and the size of the machine."""


@dataclass(frozen=True)
class Follow:
    """How the numbers of a drawing follow the parameters.

    Attributes
    ----------
    numbers : list
        Path to a number in the scene, its value, its slopes [number of the parameter, slope], and its tables [number of
        the parameter, changes at the nodes].
    nodes : dict
        Number of a parameter with tables -> [first node, distance of nodes].
    beyond : set of str
        Parameters on which the drawing depends in another way.
    """

    numbers: list[list[Any]] = field(default_factory=list)
    nodes: dict[int, list[float]] = field(default_factory=dict)
    beyond: set[str] = field(default_factory=set)

    @classmethod
    def of(cls, trajectory: Trajectory, keys: Keyframes, scene: Mapping[str, Any]) -> Follow:
        """Return how the drawing of a scene follows the parameters."""
        model, values, size = trajectory.kernels.model, trajectory.values, scene["size"]
        up = np.array(scene["up"])

        def drawn(changed: Mapping[str, float]) -> Tree:
            picture = figure(model, {**values, **changed}, keys, size, up)
            picture["arrows"] = [a for a in picture["arrows"] if a["channel"] in scene["channels"]]
            bodies = {cone["body"] for cone in scene["cones"]}
            picture["cones"] = [cone for cone in picture["cones"] if cone["body"] in bodies]
            return dict(_leaves(picture))

        base = drawn({})
        nodes = {name: np.linspace(*range_of(model, name, x), NODES) for name, x in values.items()}
        changes: dict[str, Mapping[Path, Change]] = {}
        beyond = set()
        for name in _influential(base, drawn, values):
            found: Mapping[Path, Change] | None = _slopes(base, drawn, name, values[name], size)
            if found is None:
                found = _tables(base, drawn, name, nodes[name], size)
            if found is None:
                beyond.add(name)
            elif found:
                changes[name] = found
        while changes:
            together = {
                name: values[name] * (1 + part) for name, part in zip(changes, _parts(), strict=False)
            }
            moved = {name: (values[name], together[name], nodes[name]) for name in changes}
            wrong = _wrong(base, changes, moved, _or_none(drawn, together), size)
            if wrong is not None and not wrong:
                break
            worst = _worst(changes, wrong)
            beyond.add(worst)
            del changes[worst]
        return cls._of(base, changes, nodes, [parameter.name for parameter in model.parameters], beyond)

    @classmethod
    def _of(
        cls, base: Tree, changes: Mapping[str, Mapping[Path, Change]], nodes: Mapping[str, NDArray[np.float64]],
        names: list[str], beyond: set[str],
    ) -> Follow:  # fmt: skip
        numbers: dict[Path, list[Any]] = {}
        used = {}
        for name, found in changes.items():
            k = names.index(name)
            for path, change in found.items():
                entry = numbers.setdefault(path, [list(path), base[path], [], []])
                if isinstance(change, float):
                    entry[2].append([k, change])
                else:
                    entry[3].append([k, [float(f"{x:.5g}") for x in change]])
                    used[k] = [float(nodes[name][0]), float(nodes[name][1] - nodes[name][0])]
        return cls(list(numbers.values()), used, beyond)


def _parts() -> Iterator[float]:
    """Changes of several parameters at once, no two equal."""
    k = 0
    while True:
        yield 0.4 * (-1) ** k / (1 + 0.3 * k)
        k += 1


def _influential(base: Tree, drawn: Drawn, values: Mapping[str, float]) -> list[str]:
    """Names of the parameters on which the drawing depends, by halves: most of a large machine's do not change it."""
    steps = {name: (x or 1.0) * part for (name, x), part in zip(values.items(), _parts(), strict=False)}
    found, waiting = [], [list(values)]
    while waiting:
        names = waiting.pop()
        if not names or _or_none(drawn, {name: values[name] + steps[name] for name in names}) == base:
            continue
        if len(names) == 1:
            found += names
        else:
            middle = len(names) // 2
            waiting += [names[middle:], names[:middle]]
    return found


def _or_none(drawn: Drawn, changed: Mapping[str, float]) -> Tree | None:
    """The drawing at values that it may not exist for."""
    try:
        return drawn(changed)
    except (ModelError, ValueError, ZeroDivisionError):
        return None


def _leaves(tree: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Numbers and texts of a scene with their paths."""
    if isinstance(tree, Mapping):
        for key, value in tree.items():
            yield from _leaves(value, (*path, key))
    elif isinstance(tree, list):
        for i, value in enumerate(tree):
            yield from _leaves(value, (*path, i))
    else:
        yield path, tree.tobytes() if isinstance(tree, np.ndarray) else tree


def _alike(base: Tree, others: list[Tree]) -> bool:
    """True if drawings differ in their numbers alone."""
    return all(
        other.keys() == base.keys()
        and all(other[path] == value for path, value in base.items() if not isinstance(value, float))
        for other in others
    )


def _slopes(base: Tree, drawn: Drawn, name: str, value: float, size: float) -> dict[Path, Change] | None:
    """Slopes of the numbers that change with one parameter; None if the drawing does not follow it linearly."""
    steps = [part * (value or 1.0) for part in PARTS]
    at = [(step, other) for step in steps if (other := _or_none(drawn, {name: value + step})) is not None]
    if len(at) < 2 or not _alike(base, [other for _, other in at]):
        return None
    step, last = at[-1]
    result: dict[Path, Change] = {}
    for path, x in base.items():
        if not isinstance(x, float):
            continue
        slope = (last[path] - x) / step
        if any(not abs(y[path] - x - slope * h) <= ROUND * (abs(x) + abs(slope * h) + size) for h, y in at):
            return None
        if abs(slope * step) > ROUND * size:
            result[path] = float(slope)
    return result


def _tables(
    base: Tree, drawn: Drawn, name: str, nodes: NDArray[np.float64], size: float
) -> dict[Path, Change] | None:
    """Changes at the nodes of the numbers that change with one parameter; None if the drawing does not follow them."""
    between = np.linspace(nodes[0], nodes[-1], BETWEEN + 2)[1:-1]
    at = [_or_none(drawn, {name: float(x)}) for x in (*nodes, *between)]
    others = [other for other in at if other is not None]
    if len(others) < len(at) or not _alike(base, others):
        return None
    result: dict[Path, Change] = {}
    for path, x in base.items():
        if isinstance(x, float):
            changes = np.array([other[path] - x for other in others])
            if np.abs(changes).max() > ROUND * size:
                seen = np.interp(between, nodes, changes[:NODES]) - changes[NODES:]
                if not np.abs(seen).max() <= SEEN * (abs(x) + size):
                    return None
                result[path] = changes[:NODES]
    return result


def _wrong(
    base: Tree, changes: Mapping[str, Mapping[Path, Change]],
    moved: Mapping[str, tuple[float, float, NDArray[np.float64]]], drawn: Tree | None, size: float,
) -> set[Path] | None:  # fmt: skip
    """Paths of the numbers that do not follow several parameters together; None if the drawing is another one."""
    if drawn is None or not _alike(base, [drawn]):
        return None
    result = set()
    for path, x in base.items():
        if not isinstance(x, float):
            continue
        total, bound = 0.0, ROUND
        for name, found in changes.items():
            before, after, nodes = moved[name]
            change = found.get(path, 0.0)
            if isinstance(change, float):
                total += change * (after - before)
            else:
                total, bound = total + float(np.interp(after, nodes, change)), SEEN
        if not abs(drawn[path] - x - total) <= bound * (abs(x) + abs(total) + size):
            result.add(path)
    return result


def _worst(changes: Mapping[str, Mapping[Path, Change]], wrong: set[Path] | None) -> str:
    """The parameter to leave out: one with tables, if there is one, that takes part in the most wrong numbers."""

    def weight(name: str) -> tuple[bool, int]:
        found = changes[name]
        part = len(wrong & found.keys()) if wrong is not None else len(found)
        return part > 0 and any(not isinstance(x, float) for x in found.values()), part

    return max(reversed(list(changes)), key=weight)
