"""The moments between the phases of a motion with contacts, as the log has them."""

from __future__ import annotations

from typing import NamedTuple

from ...events import event_run
from ..history import History
from ..state import Entry


class Moment(NamedTuple):
    """What the log has between two phases: entries, and the straight steps with the time that they take."""

    entries: list[Entry]
    straight: list[int]


def moments(history: History) -> tuple[list[int], list[Moment]]:
    """Return the numbers of the phases that are not straight steps, and the moments before each of them."""
    phases, result, number = [], [Moment([], [])], 0
    for entry in history.entries():
        if entry.kind == event_run.PHASE:
            if entry.marks[7] == event_run.STRAIGHT:
                result[-1].straight.append(number)
            else:
                phases.append(number)
                result.append(Moment([], []))
            number += 1
        elif entry.kind != event_run.CROSSING:
            result[-1].entries.append(entry)
    return phases, result


def notes_of(entry: Entry, contacts: int) -> list[list[int]]:
    """Return contact, mode before and after, and reason of each change of an entry."""
    marks = entry.marks[2 + contacts :]
    return [marks[i : i + 4] for i in range(0, len(marks), 4)]
