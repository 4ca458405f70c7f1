"""Linear and angular momentum of a machine, as formulas."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from ...describe.body import Body
from ...describe.frame import Point
from ...dynamics.kinematics import point_position
from ...dynamics.momentum import momentum
from ...errors import ModelError
from ...scalar.algebra import ZERO, Vector
from ..printing.lines import EQUALS, Lines
from .bodies import own_body
from .canonical_model import CanonicalModel
from .questions import named


class MomentumOf(Lines):
    """Linear and angular momentum of all bodies together."""

    def __init__(self, e: CanonicalModel) -> None:
        self._e = e

    def _lines(self) -> list[list[Any]]:
        return [
            ["linear", EQUALS, self.linear],
            ["angular about the ground's origin", EQUALS, self.angular()],
        ]

    def __repr__(self) -> str:
        return self.text()

    @cached_property
    @named("the linear momentum")
    def linear(self) -> Any:
        """Σ m v_C, SymPy column in ground axes [kg m/s]."""
        return self._e.column(momentum(self._e.model, self._e.state).linear)

    @named("the angular momentum")
    def angular(self, about: Any = None) -> Any:
        """Σ (r × m v_C + H_C) about a point, SymPy column in ground axes [kg m²/s].

        Parameters
        ----------
        about : Point or three components in ground axes, optional
            The ground's origin by default. A point of a body is taken at its present position.
        """
        e = self._e
        if isinstance(about, Body):
            about = about.origin
        position: Vector
        if about is None:
            position = ZERO
        elif isinstance(about, Point):
            own_body(e.model, about.body, "a point to take momentum about")
            position = point_position(e.model, e.state, about)
        else:
            if isinstance(about, str) or not hasattr(about, "__len__") or len(about) != 3:
                raise ModelError(
                    f"Expected a point or three components to take momentum about, got {about!r}."
                )
            position = e.state.vector(
                [e.model.names.expression(x, "the point of angular momentum") for x in about]
            )
        return e.column(momentum(e.model, e.state, position).angular)
