"""First-order form of linear equations, with names: x' = A x + B f, y = C x + D f."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy

from ..errors import ModelError, nearest


@dataclass(frozen=True, eq=False)
class StateSpace:
    """Matrices (arrays, or SymPy matrices of a symbolic model) and names.

    Attributes
    ----------
    A, B, C, D : matrix
        (n_x, n_x), (n_x, n_f), (n_y, n_x), (n_y, n_f).
    states, inputs, outputs : tuple of str
    """

    A: Any
    B: Any
    C: Any
    D: Any
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    @classmethod
    def of(
        cls, A: Any, B: Any, states: Sequence[str], inputs: Sequence[str], outputs: Sequence[str] | None
    ) -> StateSpace:
        """The form whose outputs are states."""
        chosen = tuple(states if outputs is None else [outputs] if isinstance(outputs, str) else outputs)
        for name in chosen:
            if name not in states:
                raise ModelError(f"Unknown output '{name}'; {nearest(str(name), states)}")
        C = np.array([[int(name == state) for state in states] for name in chosen]).reshape(-1, len(states))
        D = np.zeros((len(chosen), len(inputs)), dtype=int)
        if isinstance(A, np.ndarray):
            C, D = C.astype(float), D.astype(float)
        else:
            C = sympy.ImmutableMatrix(C.shape[0], C.shape[1], C.ravel().tolist())
            D = sympy.zeros(*D.shape).as_immutable()
        return cls(A, B, C, D, tuple(states), tuple(inputs), chosen)

    def _numbers(self, what: str) -> None:
        if not isinstance(self.A, np.ndarray):
            raise ModelError(
                f"{what} takes numbers, but this model is symbolic. Give them: model.numeric(values).state_space()."
            )

    def to_scipy(self) -> Any:
        """As ``scipy.signal.StateSpace``, which needs at least one input.

        Raises
        ------
        ModelError
            A symbolic model, or one without inputs.
        """
        self._numbers("scipy.signal.StateSpace")
        if not self.inputs:
            raise ModelError(
                "scipy.signal.StateSpace needs an input, and this model has none. Name some: fb.linearize(s, "
                "inputs=...)."
            )
        from scipy.signal import StateSpace as ScipyStateSpace

        return ScipyStateSpace(self.A, self.B, self.C, self.D)

    def to_control(self) -> Any:
        """As a ``control.StateSpace`` of python-control, with the names of states, inputs and outputs.

        Raises
        ------
        ModelError
            A symbolic model, or python-control is not installed.
        """
        self._numbers("control.StateSpace")
        try:
            import control
        except ImportError:
            raise ModelError(
                "python-control is not installed, so there is no control.StateSpace. Install it: pip install "
                "control; or "
                "use to_scipy()."
            ) from None
        return control.ss(
            self.A, self.B, self.C, self.D,
            states=list(self.states), inputs=list(self.inputs), outputs=list(self.outputs),
        )  # fmt: skip

    def __repr__(self) -> str:
        def listed(names: Sequence[str]) -> str:
            return ", ".join(names) or "none"

        parts = {"states": self.states, "inputs": self.inputs, "outputs": self.outputs}
        return "State space: " + "; ".join(f"{what} {listed(names)}" for what, names in parts.items())
