"""First-order form of linear equations, with names: x' = A x + B f, y = C x + D f."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy

from ...errors import ModelError, nearest
from ..printing.latex import latex_number
from ..printing.lines import Result
from ..printing.show import aligned, latex_of, text_of


@dataclass(frozen=True, eq=False)
class StateSpace(Result):
    """Matrices and names of a first-order form; SymPy matrices if the model is symbolic, else arrays.

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
        """Return the form whose outputs are the named states, or all."""
        output_names = tuple(
            states if outputs is None else [outputs] if isinstance(outputs, str) else outputs
        )
        for name in output_names:
            if name not in states:
                raise ModelError(f"Unknown output '{name}'; {nearest(str(name), states)}")
        C = np.array([[int(name == state) for state in states] for name in output_names]).reshape(
            -1, len(states)
        )
        D = np.zeros((len(output_names), len(inputs)), dtype=int)
        if isinstance(A, np.ndarray):
            C, D = C.astype(float), D.astype(float)
        else:
            C = sympy.ImmutableMatrix(C.shape[0], C.shape[1], C.ravel().tolist())
            D = sympy.zeros(*D.shape).as_immutable()
        return cls(A, B, C, D, tuple(states), tuple(inputs), output_names)

    def _require_numbers(self, what: str) -> None:
        if not isinstance(self.A, np.ndarray):
            raise ModelError(
                f"{what} takes numbers, but this model is symbolic. Give them: model.numeric(values).state_space()."
            )

    def to_scipy(self) -> Any:
        """Return a ``scipy.signal.StateSpace``, which needs at least one input.

        Raises
        ------
        ModelError
            A symbolic model, or one without inputs.
        """
        self._require_numbers("scipy.signal.StateSpace")
        if not self.inputs:
            raise ModelError(
                "scipy.signal.StateSpace needs an input, and this model has none. Name some: fb.linearize(s, "
                "inputs=...)."
            )
        from scipy.signal import StateSpace as ScipyStateSpace

        return ScipyStateSpace(self.A, self.B, self.C, self.D)

    def to_control(self) -> Any:
        """Return a ``control.StateSpace`` of python-control, with the names of states, inputs and outputs.

        Raises
        ------
        ModelError
            A symbolic model, or python-control is not installed.
        """
        self._require_numbers("control.StateSpace")
        try:
            import control
        except ImportError:
            raise ModelError(
                "python-control is not installed, so there is no control.StateSpace. Install it: pip install "
                "control; or use to_scipy()."
            ) from None
        return control.ss(
            self.A, self.B, self.C, self.D,
            states=list(self.states), inputs=list(self.inputs), outputs=list(self.outputs),
        )  # fmt: skip

    def _tables(self) -> Iterator[tuple[str, list[list[Any]]]]:
        """Yield the name and the rows of each matrix that is not empty."""
        for name in "ABCD":
            matrix = getattr(self, name)
            if 0 not in matrix.shape:
                yield name, matrix.tolist()

    def text(self) -> str:
        """Names and matrices as plain text."""
        lines = [repr(self)]
        for name, table in self._tables():
            shown = [[f"{x:.6g}" if isinstance(x, float) else text_of(x) for x in row] for row in table]
            width = max(len(x) for row in shown for x in row)
            body = "\n".join("  " + "  ".join(x.rjust(width) for x in row) for row in shown)
            lines.append(f"{name} =\n{body}")
        return "\n".join(lines)

    def latex(self) -> str:
        """The equations and their matrices as a LaTeX ``aligned`` block."""
        lines = [r"\dot{x} &= A x + B f,\quad y = C x + D f"]
        for name, table in self._tables():
            rows = [
                " & ".join(latex_number(x) if isinstance(x, float) else latex_of(x) for x in row)
                for row in table
            ]
            lines.append(rf"{name} &= \begin{{bmatrix}}" + r" \\ ".join(rows) + r"\end{bmatrix}")
        return aligned(lines)

    def __repr__(self) -> str:
        def listed(names: Sequence[str]) -> str:
            return ", ".join(names) or "none"

        parts = {"states": self.states, "inputs": self.inputs, "outputs": self.outputs}
        return "State space: " + "; ".join(f"{what} {listed(names)}" for what, names in parts.items())
