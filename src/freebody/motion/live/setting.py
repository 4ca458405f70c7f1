"""What a live motion begins with."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..kernels.kernels import Kernels
from ..trajectory.event import EventSpec


@dataclass(frozen=True, eq=False)
class Setting:
    """What a live motion begins with, and how it is computed.

    ``values``, ``initial``, ``near``    values of the parameters; start and guess by name, as in `simulate`
    ``state``        (q, u) at the start with these values
    ``begin``, ``until``                 times [s]
    ``specs``        events
    ``relative``     tolerance of each component of the state
    ``most_steps``, ``most_frames``      greatest numbers of steps and of frames
    ``longest``, ``sequential``, ``refuse``    of a machine with contacts: longest step; whether contacts collide one
                     after another; whether indeterminate forces are refused
    """

    kernels: Kernels
    values: Mapping[str, float]
    initial: Mapping[Any, Any]
    near: Mapping[Any, Any]
    state: Sequence[float]
    begin: float
    until: float
    specs: tuple[EventSpec, ...]
    relative: Any
    most_steps: int
    most_frames: int
    longest: float = math.inf
    sequential: bool = False
    refuse: bool = False
