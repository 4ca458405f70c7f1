"""Motion: the compiled integrator, events, the energy ledger and the trajectory."""

from .event import Event, EventSpec, event
from .simulate import simulate
from .trajectory import Trajectory

__all__ = ["Event", "EventSpec", "Trajectory", "event", "simulate"]
