"""Content of a model file: the machine and the settings of its run."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..describe.system import System


@dataclass(frozen=True)
class Case:
    """A system with the initial values and the length of a run, arguments of :func:`freebody.simulate`.

    Attributes
    ----------
    system : System
    initial : dict of str to expression
        Initial values by name (``theta``, ``theta'``): numbers and expressions of parameters.
    until : expression or None
        Length of the run [s].
    tolerance : float or None
        Tolerance of the integration.
    near : dict of str to expression
        For machines with constraints: a guess for the values that are not in ``initial``.
    """

    system: System
    initial: dict[str, Any] = field(default_factory=dict)
    until: Any = None
    tolerance: float | None = None
    near: dict[str, Any] = field(default_factory=dict)
