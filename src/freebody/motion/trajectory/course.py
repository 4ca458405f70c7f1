"""How the quantities of a motion follow from its path.

    InLegs      from the states at any moment; each leg has its programs and parameters      `trajectory.in_legs`
    Touching    the same, and the forces of contacts, each phase with its modes               `contact.course`
    InSteps     from the impulses of equal time steps, as means over a step                   `timestepping.course`

`Trajectory` is one class for all motions: it has a path, which can be sampled, and a course.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

from ...dynamics.conditions.unilateral import MotionWarning
from ..kernels.program import Program
from ..ode.dense_output import Array
from .event import Happening
from .one_sided_limits import Values
from .quantities import Energy

Piece = tuple[Array, Values | None, Array]
"""Part of a run for `one_sided_limits.spans`."""


class Course(Protocol):
    """How the quantities of a motion follow from its path; ``motion`` is a :class:`ComputedMotion`."""

    @property
    def happenings(self) -> tuple[Happening, ...]:
        """Blows, impacts and changes of mode or of conditions, in their order."""

    @property
    def stepping(self) -> Any:
        """Measures of a motion in time steps; None for others."""

    @property
    def residual(self) -> float | None:
        """What the laws of contacts are missed by at most; None for a motion without contacts."""

    @property
    def derivatives(self) -> Any:
        """Derivatives by parameters and initial values; None for a motion without."""

    @property
    def indeterminate(self) -> tuple[str, ...]:
        """Contact forces that the motion does not determine at some time."""

    def modes(self, motion: Any) -> Sequence[Any]:
        """Return the modes of all contacts, in the order in which they began."""

    def works(self, motion: Any) -> bool:
        """Return True if the work done is a component of the state."""

    def observed(self, motion: Any, program: Program, function: str, times: Array, states: Array) -> Array:
        """Return the outputs of a function of a program at states."""

    def energy(self, motion: Any) -> Energy:
        """Return the energy ledger at the output times."""

    def quantity(self, motion: Any, name: str) -> Array:
        """Return the "rates" of the state, the "reactions" (force and moment of each joint in turn) or the
        "multipliers" of the constraints at the output times, one row each.
        """

    def contacts(self, motion: Any) -> Mapping[str, Any]:
        """Return gap, forces, slip and mode of every contact, by name."""

    def limit_pieces(self, motion: Any) -> Iterator[Piece]:
        """Yield the parts of the run with the margins to the limits of one-sided constraints."""

    def warnings(self, motion: Any) -> tuple[MotionWarning, ...]:
        """Return the warnings besides those of forces beyond a limit."""
