"""Checks of an operating point: balanced, steady, regular, and without inputs in the constraints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...errors import ModelError
from ...model.model import Model
from ...scalar.algebra import Scalar
from ...scalar.element import is_zero
from ...scalar.polynomial import Ring
from ..printing.display import text
from .operating_point import SINGULAR

SMALL = 10**-9
"""Relative size of a residual, and of a change of the linear equations, that counts as round-off."""
EPSILON = float(np.finfo(float).eps)


def balanced(
    model: Model, ring: Ring, residual: Sequence[Scalar], names: Sequence[str], moving: int, what: str
) -> None:
    """Raise if a residual is not zero; ``moving`` is the mask of the generators that change with time."""
    nonzero = {name: r for name, r in zip(names, residual, strict=True) if not is_zero(r)}
    if not nonzero:
        return
    shown = "; ".join(f"{name}: {text(r, ring)}" for name, r in nonzero.items())
    changes = any(ring.depends(r) & moving for r in nonzero.values())
    motion = "a steady motion" if changes else "an equilibrium or a steady motion"
    raise ModelError(
        f"The state given is not {motion} of '{model.name}': {what} {shown} in place of 0. Give a balanced state in "
        "`about` (fb.steady_motions finds them), a relation among parameters as where={parameter: expression} (or in "
        "`inputs` a load that is zero except for disturbances), or a trajectory."
    )


def steady(model: Model, ring: Ring, terms: Mapping[str, Any], names: Sequence[str], moving: int) -> None:
    """Raise if an entry of the matrices changes with time."""
    for key in "MCKB":
        for name, row in zip(names, terms[key], strict=True):
            for x in row:
                if ring.depends(x) & moving:
                    raise ModelError(
                        f"The motion given is balanced, but the linear equations of '{model.name}' about it change "
                        f"with time: {key} has {text(x, ring)} in the row of '{name}'. Linearise about a trajectory "
                        "(about=fb.simulate(...)), or use coordinates in which the motion is steady."
                    )


def check_untouched(model: Model, inputs: Sequence[str], moved: Sequence[Any]) -> None:
    """Raise if an input occurs in the constraints; ``moved`` is true for each input that does."""
    for name, moves in zip(inputs, moved, strict=True):
        if moves:
            raise ModelError(
                f"The input '{name}' occurs in the constraints of '{model.name}': its deviations would move them. "
                "Take it out of `inputs`; inputs are loads, parameters of loads and of masses, and forces along "
                "coordinates."
            )


def check_count(model: Model, independent: Sequence[str], conditions: int) -> None:
    """Raise if the user names another number of independent coordinates than the conditions leave."""
    freedom = model.n_u - conditions
    if len(independent) != freedom:
        raise ModelError(
            f"Expected {freedom} independent coordinates of '{model.name}' ({model.n_u} speeds, {conditions} "
            f"conditions), got {len(independent)}: {', '.join(independent)}."
        )


def not_independent(model: Model, independent: Sequence[str]) -> ModelError:
    """Return the error for coordinates that the constraints relate."""
    return ModelError(
        f"The coordinates {', '.join(independent)} are not independent: with them held, '{model.name}' can "
        "still move, and the constraints relate them. Name others, or leave the choice out."
    )


class Checks:
    """Checks of the states at which a machine is linearised in numbers, with their messages.

    ``shape`` is the shape of the arrays of values, () for one state.
    """

    def __init__(self, model: Model, shape: tuple[int, ...], numbers: Mapping[Any, Any]) -> None:
        self.model, self.shape, self._numbers = model, shape, numbers

    @property
    def values(self) -> dict[str, Any]:
        """Values of the parameters by name, in the shape the user gave."""
        return {
            p.name: np.asarray(x).reshape(self.shape) if np.ndim(x) else x
            for p in self.model.parameters
            for x in (self._numbers[p.symbol],)
        }

    @property
    def first(self) -> dict[Any, float]:
        """Values of the parameters at the first state, by symbol."""
        return {symbol: float(np.reshape(x, -1)[0]) for symbol, x in self._numbers.items()}

    def named(self, q: Any, u: Any) -> dict[str, Any]:
        """Coordinates and speeds by name."""
        columns = [x.reshape(self.shape) if self.shape else float(x[0]) for x in (*q.T, *u.T)]
        return dict(zip(self.model.state_names, columns, strict=True))

    def which(self, i: int) -> str:
        """Return " at m = 2, ..." for state ``i`` of many; "" for a single state."""
        shown = ", ".join(
            f"{p.name} = {np.reshape(self._numbers[p.symbol], -1)[i]:.6g}"
            for p in self.model.parameters
            if np.ndim(self._numbers[p.symbol])
        )
        return f" at {shown}" if shown else ""

    def balance(self, residual: Any, scale: Any, names: Sequence[str], what: str) -> None:
        """Raise if a residual exceeds round-off, or if terms are not finite."""
        if np.isfinite(residual).all() and not np.isfinite(scale).all():
            raise ModelError(
                f"The linear equations of '{self.model.name}' are not finite at the state given: a length or a root "
                f"that is zero there has no derivative, such as the |v| of drag at rest. Give a state beside it in "
                f"`about`, or linearize with symbols: fb.linearize(s) without values."
            )
        bad = ~(np.abs(residual) <= SMALL * scale)
        if not bad.any():
            return
        i = int(np.argmax(bad.any(axis=1)))
        shown = ", ".join(
            f"{name}: {r:.6g}" for name, r, off in zip(names, residual[i], bad[i], strict=True) if off
        )
        raise ModelError(
            f"The state given is not an equilibrium or a steady motion of '{self.model.name}'{self.which(i)}: {what} "
            f"{shown} in place of 0. Give a balanced state in `about` (fb.steady_motions finds them), or a trajectory."
        )

    def regular(self, M: Any) -> None:
        """Raise if the mass matrix is singular, scaled so that its diagonal entries are 1."""
        unit = np.sqrt(np.abs(np.diagonal(M, axis1=1, axis2=2)))
        if (unit > 0).all():
            scaled = M / unit[:, :, None] / unit[:, None, :]
            if np.isfinite(scaled).all() and (np.linalg.cond(scaled) * 10 * M.shape[-1] * EPSILON < 1).all():
                return
        raise ModelError(SINGULAR.format(self.model.name))

    def same(self, first: Any, later: Any, what: str, at: Any = None) -> None:
        """Raise if matrices change along a steady motion; ``at`` are the indices of these states among all."""
        size, change = (np.abs(x).max(axis=(1, 2), initial=0) for x in (first, later - first))
        bad = ~(change <= 10**4 * SMALL * size)
        if bad.any():
            i = int(np.argmax(bad))
            raise ModelError(
                f"The motion given is balanced, but the linear equations of '{self.model.name}' about it change with "
                f"time{self.which(i if at is None else int(at[i]))}: entries of {what} up to {size[i]:.6g} change by "
                f"{change[i]:.6g}. Linearise about a trajectory (about=fb.simulate(...)), or use coordinates in which "
                "the motion is steady."
            )


def scale_of(terms: Mapping[str, Any], u: Any) -> Any:
    """Size of the terms of each equation at unit deviations, one row per state."""
    fast = np.abs(u).max(axis=1, initial=0)[:, None]
    M, C, K = (np.abs(terms[key]).sum(axis=2) for key in "MCK")
    return M * (1 + fast**2) + C * (1 + fast) + K
