"""The path of a motion: what can be sampled at any time of the run."""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from ..ending import End
from ..ode.dense_output import Array, Crossing, Rates


class SampledPath(Protocol):
    """Path of a motion: smooth (`Path`), in phases (`Phases`) or in steps (`Steps`)."""

    @property
    def start(self) -> float:
        """Time at which the run starts [s]."""

    @property
    def end(self) -> float:
        """Time at which the run ends [s]."""

    @property
    def status(self) -> End:
        """How the run ended."""

    @property
    def blame(self) -> int:
        """Component, or event, that stopped a run that failed."""

    @property
    def times(self) -> Array:
        """Starts of the steps and ends of the segments [s]."""

    @property
    def states(self) -> Array:
        """States at :attr:`times`, on either side of a jump."""

    @property
    def lengths(self) -> Array:
        """Lengths of the steps [s]."""

    @property
    def steps(self) -> int:
        """Number of accepted steps."""

    @property
    def rejected(self) -> int:
        """Number of rejected steps."""

    @property
    def stiff(self) -> int:
        """Number of steps whose length stability limited."""

    @property
    def method(self) -> str:
        """Method, in the last segment."""

    @property
    def rates(self) -> Rates:
        """Right-hand side, in the last segment."""

    @property
    def crossings(self) -> tuple[Crossing, ...]:
        """Events of the user."""

    def sample(self, times: ArrayLike, dense: bool = False) -> Array:
        """Return states at ``times``; at the time of a jump the state just after."""
