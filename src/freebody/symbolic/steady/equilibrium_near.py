"""An equilibrium in numbers near a guess, for conditions that are too long to write.

    E(q) = h(q, u = 0) - Q = 0,        q <- q - K⁻¹ E,    K = ∂E/∂q

by Newton's method with exact derivatives, on numbers only: no formula is formed. A step that does not reduce E is
halved. One motion is found; there may be others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import ModelError, nearest
from ...model.model import Model
from ...scalar.algebra import Expression, floats
from ..linear.checks import scale_of
from ..linear.linearize import linearize, terms_at
from ..printing.lines import Result
from ..printing.show import aligned, latex_words
from .motion import SteadyState
from .stability import Spectrum, Stability, spectral_verdict

STEPS = 100
"""Most Newton steps."""
HALVINGS = 40
"""Most halvings of one step."""
EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, repr=False)
class SteadyNear(Result, Sequence[SteadyState]):
    """One steady motion in numbers near a guess. Made by :func:`steady_motions`.

    Attributes
    ----------
    states : tuple of SteadyState
        The motion that was found; there may be others.
    near : dict
        Coordinates where the search started.
    reason : str
        Why there is no closed form.
    """

    states: tuple[SteadyState, ...]
    near: dict[str, float]
    reason: str

    def __len__(self) -> int:
        return len(self.states)

    def __getitem__(self, key: Any) -> Any:
        return self.states[key]

    def _words(self) -> list[str]:
        start = ", ".join(f"{name} = {value:.6g}" for name, value in self.near.items() if value) or "all zero"
        state = self.states[0]
        return [
            f"No closed form: {self.reason}" if self.reason else "In numbers, as asked by near=.",
            f"Found by Newton's method from {start} (residual {state.residual:.1g}); others may exist:",
        ]

    def text(self) -> str:
        """The motion, and why it is in numbers, as plain text."""
        return "\n".join([*self._words(), *(state.text() for state in self.states)])

    def latex(self) -> str:
        """The motion as LaTeX."""
        rows = [
            *("&" + latex_words(x) for x in self._words()),
            *("&" + state.latex() for state in self.states),
        ]
        return aligned(rows)


def steady_near(
    model: Model, values: Mapping[Any, Expression], near: Mapping[Any, Expression] | None, reason: str = ""
) -> SteadyNear:
    """Return the equilibrium that Newton's method finds from ``near``; coordinates not named start at zero.

    Raises
    ------
    ModelError
        Constraints, ball or free joints; names that are not coordinates; no equilibrium found.
    """
    if model.constraints or model.quaternions:
        raise ModelError(
            f"Expected a tree of joints without constraints and unit quaternions for a steady motion in numbers near a "
            f"guess; '{model.name}' has such. {reason}".rstrip()
        )
    known = {p.name: p.symbol for p in model.parameters}
    parameters = {_name(model, key): value for key, value in values.items()}
    start = {_name(model, key): value for key, value in (near or {}).items()}
    for name in parameters:
        if name not in known:
            raise ModelError(
                f"Expected values of parameters for a steady motion in numbers near a guess, got '{name}'; "
                f"{nearest(name, known)} Give coordinates by near=."
            )
    for name in start:
        if name not in model.coordinate_names:
            raise ModelError(f"Unknown coordinate '{name}' in near; {nearest(name, model.coordinate_names)}")
    plain = model.values(parameters)
    numbers = {symbol: plain[name] for name, symbol in known.items()}
    guess = {name: _number(start.get(name, 0), name) for name in model.coordinate_names}
    zero_speeds = [float(0)] * model.n_u

    def at(q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        result = terms_at(model, floats, [*map(float, q)], zero_speeds, zero_speeds, 0, numbers, ())
        stacks = {key: np.array(result[key], dtype=float)[None] for key in "MCK"}
        size = scale_of(stacks, np.array([zero_speeds]))[0]
        return np.array(result["residual"], dtype=float), stacks["K"][0], size

    q = np.array([guess[name] for name in model.coordinate_names], dtype=float)
    E, K, size = at(q)
    step = np.zeros(len(q))
    for _ in range(STEPS):
        if not (np.isfinite(E).all() and np.isfinite(K).all()) or (np.abs(E) <= 4 * EPS * size).all():
            break
        step = -np.linalg.lstsq(K, E, rcond=None)[0]
        step *= np.minimum(1, np.pi / np.maximum(np.abs(step).max(), EPS))
        for _ in range(HALVINGS):
            trial = at(q + step)
            if np.linalg.norm(trial[0] / size) < np.linalg.norm(E / size):
                break
            step = step / 2
        else:
            break
        q = q + step
        E, K, size = trial
    missed = float((np.abs(E) / np.maximum(size, EPS * EPS)).max(initial=0))
    if not missed <= 1024 * EPS:
        raise ModelError(
            f"No equilibrium of '{model.name}' found from {guess}: Newton's method ends with a residual of "
            f"{missed:.1g}. Give near= closer to one."
        )
    state = dict(zip(model.coordinate_names, map(float, q), strict=True))
    full = {**state, **dict.fromkeys(model.speed_names, float(0))}
    error = float(np.abs(np.linalg.lstsq(K, E, rcond=None)[0]).max(initial=0))
    result = SteadyState("", dict(state), full, missed, error, _stability(model, full, parameters))
    return SteadyNear((result,), guess, reason)


def _stability(model: Model, state: Mapping[str, float], values: Mapping[Any, Expression]) -> Stability:
    linear = linearize(model, about=state, values=values)
    roots = np.asarray(linear.eigenvalues(), dtype=complex)
    damped = bool(np.any(np.asarray(linear.C, dtype=float)))
    spectrum = Spectrum(roots, float(np.abs(roots).max(initial=0)), damped)
    return Stability(spectral_verdict(spectrum, 0), "undecided", roots, None)


def _name(model: Model, key: Any) -> str:
    return key if isinstance(key, str) else model.names.texts.get(key, str(key))


def _number(value: Expression, name: str) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ModelError(f"Expected a number for '{name}' in near, got {value!r}.") from None
