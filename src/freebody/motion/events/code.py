"""The compiled functions of this room."""

from __future__ import annotations

from typing import Any

from ...native.loop import Function, made, sibling

_MODULES = tuple(
    sibling(__name__, name)
    for name in (
        "event_loop",
        "decision",
        "ties",
        "impacts.impacts",
        "jumps",
        "stages.phase_end",
        "log",
        "moment",
        "setting",
    )
)
_CALLED = (
    "go_on",
    "break_off",
    "log_crossing",
    "find_phases",
    "strike",
    "rub",
    "forget_signs",
    "find_closed",
    "choose_all",
    "decide",
    "begin_to_leave",
    "find_dead",
    "unique",
    "motions",
    "take_first",
    "depth",
    "parted",
    "take_sides",
    "forget_sides",
)


def code(name: str) -> Function:
    """Return a compiled function: `event_loop.go_on`, or one for a single state."""
    return made(_MODULES[0], _MODULES, _CALLED, _functions, passes="none").functions[name]


def _functions() -> dict[str, Any]:
    from . import decision, event_loop, jumps, log, moment, setting, ties
    from .impacts import impacts
    from .stages import phase_end

    return {
        name: f
        for module in (log, moment, jumps, phase_end, impacts, ties, decision, setting, event_loop)
        for name, f in vars(module).items()
    }
