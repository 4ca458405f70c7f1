"""How a run ends: one list for single runs, for the phases of a run, and for the lanes of a batch."""

from __future__ import annotations

from enum import IntEnum

NOT_PHYSICAL = "not physical"
"""Text added to the end of a motion that passes the limit of a one-sided force."""


class End(IntEnum):
    """How a run, a part of it or a lane ended.

    The number is what the compiled loops return and what files of studies keep, in one byte. The text is what users
    read.
    """

    text: str

    def __new__(cls, number: int, text: str = "") -> End:
        """Return the member of a number."""
        end = int.__new__(cls, number)
        end._value_ = number
        end.text = text
        return end

    # of every run
    FINISHED = 1, "finished"
    TERMINAL = 2, "terminal event"
    NOT_FINITE = 3, "not finite"
    COLLAPSED = 4, "step collapsed"
    DIVERGED = 5, "iteration diverged"
    TOO_MANY_STEPS = 7, "too many steps"
    CONTRADICTED = 8, "constraints contradicted"
    UNDEFINED = 11, "event undefined"
    UNRESOLVED = 19, "event not resolved"
    STUCK = 14, "stuck on a switching law"
    # of lanes only
    WAITING = -1, "waiting"
    NO_START = 9, "no start"
    REFUSED = 10, "refused"
    UNPHYSICAL = 12, f"finished, {NOT_PHYSICAL}"
    STOPPED_UNPHYSICAL = 13, f"terminal event, {NOT_PHYSICAL}"
    LOST = 15, "lost"
    # of single runs only: Ctrl-C; an error between two phases or time steps, which has the motion so far
    INTERRUPTED = 17, "interrupted"
    BROKEN_OFF = 18, "failed"
    # of a part of a run that goes on: the loop is called again, by another method or with other conditions
    RUNNING = 0, "running"
    STIFF = 6, "stiff"
    RELEASED = 16, "other conditions hold"

    def __str__(self) -> str:
        return self.text

    @classmethod
    def of_text(cls, text: str) -> End:
        """Return the end that a text names; raise ValueError if it names none."""
        for end in cls:
            if end.text == text:
                return end
        raise ValueError(f"its status is {text!r}")


ENDS = {end.value: end for end in End}
"""The ends by their numbers; calling `End` takes much longer."""
GOOD = (End.FINISHED, End.TERMINAL)
"""Ends of runs that did not fail. A run that is not physical from some time on is no good run."""
FAILED = (
    End.NOT_FINITE, End.COLLAPSED, End.DIVERGED, End.TOO_MANY_STEPS, End.UNDEFINED, End.UNRESOLVED,
    End.STUCK,
)  # fmt: skip
"""Ends of runs that cannot be continued."""
BLAMED = (End.NOT_FINITE, End.COLLAPSED, End.DIVERGED)
"""Ends of lanes for which a coordinate or speed is to blame."""
STATUS = {
    end.value: end.text
    for end in sorted(End)
    if end not in (End.RUNNING, End.STIFF, End.RELEASED, End.INTERRUPTED, End.BROKEN_OFF)
}
"""Texts of the ends of lanes, by their numbers."""
