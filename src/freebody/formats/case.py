"""A model file's content: the machine, and what is to be run with it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..describe.system import System


@dataclass(frozen=True)
class Case:
    """A system with the start and the length of a run, as :func:`freebody.simulate` takes them.

    Attributes
    ----------
    system : System
    initial : dict of str to expression
        Values at the start by name (``theta``, ``theta'``); expressions of parameters and numbers.
    until : expression or None
        Length of the run [s].
    tolerance : float or None
        Of the integration.
    near : dict of str to expression
        Of a machine with constraints: where the search for what is not in ``initial`` begins.
    """

    system: System
    initial: dict[str, Any] = field(default_factory=dict)
    until: Any = None
    tolerance: float | None = None
    near: dict[str, Any] = field(default_factory=dict)
