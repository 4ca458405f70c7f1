"""What a reader of a robot's file did: what was read, what was changed and why, and what was left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ..space.shape import Surface

CHANGED, LEFT_OUT = "changed", "left out"
SHOWN = 3
"""Number of elements that the text of a report names for each rule."""


class Note(NamedTuple):
    """Something that the system does not say as the file does.

    Attributes
    ----------
    kind : str
        ``changed`` or ``left out``.
    element : str
        The element of the file, such as ``joint 'elbow'``.
    line : int
    what : str
        What was changed or left out, and what that means for the motion.
    detail : str
        What came, where it differs from one element to the next.
    """

    kind: str
    element: str
    line: int
    what: str
    detail: str = ""

    def __str__(self) -> str:
        detail = f" ({self.detail})" if self.detail else ""
        return f"line {self.line}, {self.element}: {self.kind}: {self.what}{detail}"


@dataclass
class Reading:
    """Report of a reader, ``s.reading`` of the system that it returned. Its text names each rule once.

    Attributes
    ----------
    file : str
    counts : dict of str to int
        Number of elements that were read, by tag.
    notes : list of Note
        What was changed or left out; meshes that were not drawn yet are read for it.
    names : dict of str to str
        The file's name of each link and joint whose name in the system is another.
    frames : dict of str to (Point, 3 x 3)
        Origin and axes of each link, in the body that carries it: ``point, axes = s.reading.frames["tool"]``.
    limits : dict of str to dict
        ``lower``, ``upper``, ``effort`` and ``velocity`` of joints, by name. The motion knows nothing of them.
    coordinates : dict of str to tuple of str
        Coordinates of each joint of an MJCF file, in the file's order.
    inputs : dict of str to str
        The parameter that is the control of an actuator, by the actuator's name.
    initial : dict of str to float
        Values of coordinates in the pose that the file draws, where they are not zero: ``fb.simulate(s, 1,
        initial=s.reading.initial)``.
    keyframes : dict of str to dict
        Values of all coordinates, by the name of a keyframe.
    """

    file: str
    counts: Counter[str] = field(default_factory=Counter)
    names: dict[str, str] = field(default_factory=dict)
    frames: dict[str, tuple[Any, Any]] = field(default_factory=dict)
    limits: dict[str, dict[str, float]] = field(default_factory=dict)
    coordinates: dict[str, tuple[str, ...]] = field(default_factory=dict)
    inputs: dict[str, str] = field(default_factory=dict)
    initial: dict[str, float] = field(default_factory=dict)
    keyframes: dict[str, dict[str, float]] = field(default_factory=dict)
    right_angles: int = field(default=0, repr=False)
    pending: list[Surface] = field(default_factory=list, repr=False)
    _notes: list[Note] = field(default_factory=list, repr=False)

    @property
    def notes(self) -> list[Note]:
        """What was changed or left out."""
        while self.pending:
            self.pending.pop(0).arrays  # noqa: B018 - it notes what is wrong with its file
        return self._notes

    def changed(self, element: str, line: int, what: str, detail: str = "") -> None:
        """Note something that was read differently from how it is written."""
        self._notes.append(Note(CHANGED, element, line, what, detail))

    def left_out(self, element: str, line: int, what: str, detail: str = "") -> None:
        """Note something that was not read."""
        self._notes.append(Note(LEFT_OUT, element, line, what, detail))

    def __str__(self) -> str:
        read = ", ".join(f"{count} {plural(tag, count)}" for tag, count in sorted(self.counts.items()))
        lines = [f"Read from {self.file}: {read}."]
        rules: dict[tuple[str, str], list[Note]] = {}
        for note in sorted(self.notes, key=lambda note: note.line):
            rules.setdefault((note.kind, note.what), []).append(note)
        for (kind, what), notes in sorted(rules.items()):
            shown = "; ".join(
                f"{note.element}, line {note.line}{note.detail and f', {note.detail}'}"
                for note in notes[:SHOWN]
            )
            more = f"; and {len(notes) - SHOWN} more" if len(notes) > SHOWN else ""
            lines.append(f"{kind}: {what}: {shown}{more}")
        if not self.notes:
            lines.append("Nothing was changed or left out.")
        return "\n".join(lines)

    __repr__ = __str__


def plural(noun: str, count: int) -> str:
    """Return the noun for a number of things.

    >>> plural("link", 1), plural("joint", 2), plural("body", 3)
    ('link', 'joints', 'bodies')
    """
    if count == 1:
        return noun
    return noun[:-1] + "ies" if noun.endswith("y") else noun + "s"


def listed(words: Iterable[str]) -> str:
    """Return the words of a format as a page shows them."""
    return ", ".join(f"`{word}`" for word in words)


def reasons(words: Mapping[str, str]) -> str:
    """Return the words that are left out, with the reasons, as a page shows them."""
    found: dict[str, list[str]] = {}
    for word, what in words.items():
        if what:
            found.setdefault(what, []).append(word)
    return "; ".join(f"{listed(some)}: {what}" for what, some in found.items())
