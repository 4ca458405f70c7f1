"""Signals: functions of time that interpolate samples by piecewise polynomials.

    s(t) = c0 + c1 (t - a) + c2 (t - a)² + c3 (t - a)³        between the break point a and the next

In the expressions of a machine a signal is this polynomial. Its coefficients and a are constants, like parameters,
which take other values in the next piece. So a signal has derivatives of any order in formulas and costs a few
products in machine code, and no step of an integration crosses a break point.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import sympy
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError, arguments_named, shown

Array = NDArray[np.float64]

KINDS = {"previous": 0, "linear": 1, "cubic": 3}
"""Kinds of signals and the degrees of their pieces."""
ENDS = ("not-a-knot", "natural", "clamped")
_unnamed = itertools.count(1)


class Signal(sympy.Dummy):
    """A function of time given by samples. Made by :func:`signal`; used in expressions like a symbol.

    Attributes
    ----------
    times : ndarray (n,)
        Break points [s].
    interpolation : str
    """

    times: Array
    interpolation: str
    smooth: bool
    _coefficients: Array
    _outside: str

    def _sympystr(self, printer: Any) -> str:
        return str(self.name)

    def pieces(self, t: ArrayLike) -> tuple[Array, Array]:
        """Return starts (k,) and coefficients (k, degree + 1) of the pieces at the times.

        At a break point it is the piece that begins there.

        Raises
        ------
        ModelError
            A time outside the range of the signal.
        """
        times = np.atleast_1d(np.asarray(t, dtype=float))
        first, last = self.times[0], self.times[-1]
        if self._outside == "error":
            late = ~((times >= first) & ((times <= last) | (self.interpolation == "previous")))
            if late.any():
                raise ModelError(
                    f"Signal '{self.name}' is given from {first:g} to {last:g} s, but its value is needed at "
                    f't = {times[late][0]:g} s. Add samples up to that time, or pass outside="hold", which keeps the '
                    "first and the last value."
                )
        k = np.searchsorted(self.times, times, side="right")
        if self._outside == "error" and self.interpolation != "previous":
            k = np.where(times == last, len(self.times) - 1, k)
        starts = np.where(k == 0, first, self.times[np.maximum(k - 1, 0)])
        return starts, self._coefficients[k]

    def __call__(self, t: ArrayLike) -> Any:
        """Return the value at a time, or at an array of times."""
        try:
            times = np.asarray(t, dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise ModelError(
                f"Expected a time, or times [s], for signal '{self.name}', got {shown(t)}."
            ) from None
        flat = np.atleast_1d(times).reshape(-1)
        starts, c = self.pieces(flat)
        x = flat - starts
        value = np.zeros(flat.shape)
        for column in c.T[::-1]:
            value = value * x + column
        return float(value[0]) if times.ndim == 0 else value.reshape(times.shape)

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""
        return KINDS[self.interpolation]


@arguments_named
def signal(
    times: ArrayLike,
    values: ArrayLike,
    kind: str = "linear",
    *,
    name: str | None = None,
    outside: str = "error",
    ends: str = "not-a-knot",
) -> Signal:
    """Return a function of time given by samples, for any load, drive or condition of a machine.

    Parameters
    ----------
    times : array (n,)
        Increasing [s].
    values : array (n,)
        In the unit of the quantity that the signal replaces.
    kind : {"linear", "previous", "cubic"}
        Straight lines between the samples; each sample held until the next; or a cubic spline, twice differentiable,
        as a prescribed displacement requires.
    name : str, optional
        Its name in errors and, once it has been used in an expression, in text.
    outside : {"error", "hold"}
        Outside the times: an error, or the first and the last value. (A "previous" signal always holds its last value.)
    ends : {"not-a-knot", "natural", "clamped"}
        End condition of a cubic spline: one polynomial for the two pieces at either end; no curvature there; no slope
        there.

    Returns
    -------
    Signal
        ``sig(t)`` gives values.

    Raises
    ------
    ModelError
        Times that do not increase, values that are not finite, unequal numbers of both, an unknown kind.

    Examples
    --------
    >>> import freebody as fb
    >>> ramp = fb.signal([0, 1, 3], [0, 2, 2], name="thrust")
    >>> ramp(0.25)
    0.5
    >>> s = fb.System("cart")
    >>> cart = s.body("cart", fb.particle(2))
    >>> rail = s.slider("rail", s.ground, cart, axis="x", coordinate="x")
    >>> push = s.force("push", cart, (2 * ramp, 0, 0))
    >>> motion = fb.simulate(s, until=3)
    >>> round(motion.at(3)["x'"], 12)
    5.0

    Reference: de Boor, A Practical Guide to Splines (1978), chapter IV.
    """
    if not isinstance(kind, str) or kind not in KINDS:
        raise ModelError(f"Expected kind 'linear', 'previous' or 'cubic' for a signal, got {shown(kind)}.")
    if not isinstance(outside, str) or outside not in ("error", "hold"):
        raise ModelError(f"Expected outside='error' or 'hold' for a signal, got {shown(outside)}.")
    if not isinstance(ends, str) or ends not in ENDS or (ends != "not-a-knot" and kind != "cubic"):
        raise ModelError(
            f"Expected ends= to be one of {', '.join(map(repr, ENDS))}, and of a signal of kind 'cubic' only; got "
            f"{ends!r} with kind {kind!r}."
        )
    label = f"signal_{next(_unnamed)}" if name is None else name
    if not isinstance(label, str) or not label.isidentifier():
        raise ModelError(f"Expected a name (letters, digits, underscores) for a signal, got {shown(name)}.")
    t, v = _samples(times, "times", label), _samples(values, "values", label)
    if t.size != v.size:
        raise ModelError(f"Expected as many values as times for signal '{label}', got {v.size} and {t.size}.")
    if t.size < (1 if kind == "previous" else 2):
        raise ModelError(
            f"Expected at least two samples for signal '{label}' of kind '{kind}', got {t.size}."
        )
    backward = np.flatnonzero(~(np.diff(t) > 0))
    if backward.size:
        k = int(backward[0])
        raise ModelError(
            f"Expected times that increase for signal '{label}', but times[{k + 1}] = {t[k + 1]:g} s comes after "
            f"times[{k}] = {t[k]:g} s. For a jump use kind='previous'."
        )
    result = Signal(label, real=True)
    result.times, result.interpolation, result._outside = t, kind, outside
    result.smooth = kind == "cubic" and (outside == "error" or ends == "clamped")
    inner = _inner(t, v, kind, ends)
    ends_held = np.zeros((2, inner.shape[1]))
    ends_held[:, 0] = v[0], v[-1]
    # row k holds after k break points; the first and the last row hold outside the times
    result._coefficients = np.vstack([ends_held[:1], inner, ends_held[1:]]) + 0.0
    for array in (result.times, result._coefficients):
        array.setflags(write=False)  # results computed from them are kept
    return result


def _samples(samples: ArrayLike, what: str, label: str) -> Array:
    try:
        x = np.array(samples, dtype=float) + 0.0  # -0.0 becomes 0.0
    except (TypeError, ValueError, OverflowError):
        raise ModelError(
            f"Expected numbers for the {what} of signal '{label}', got {shown(samples)}."
        ) from None
    if x.ndim != 1:
        raise ModelError(
            f"Expected a list of {what} for signal '{label}', got an array of shape {x.shape}. A "
            "vector is three signals."
        )
    if not np.isfinite(x).all():
        raise ModelError(
            f"Expected finite {what} for signal '{label}', got {x[~np.isfinite(x)][0]} at place "
            f"{int(np.flatnonzero(~np.isfinite(x))[0])}."
        )
    return x


def _inner(t: Array, v: Array, kind: str, ends: str) -> Array:
    """Return the coefficients (n - 1, degree + 1) of the pieces between break points."""
    if kind == "previous":
        return v[:-1, None]
    if kind == "linear":
        return np.stack([v[:-1], np.diff(v) / np.diff(t)], axis=1)
    from scipy.interpolate import CubicSpline

    return np.ascontiguousarray(CubicSpline(t, v, bc_type=ends).c[::-1].T)


class SignalTable(NamedTuple):
    """Constants of all pieces: row k holds after k break points, and is NaN where the signal is not given."""

    breaks: Array  # (n,)
    rows: Array  # (n + 1, constants of a piece)


@dataclass(frozen=True)
class Placed:
    """A signal in a system: the symbols of its piece and their polynomial."""

    signal: Signal
    symbols: tuple[Any, ...]  # the start of the piece (unless its degree is 0), then the coefficients
    expression: Any

    def settings(self, t: float) -> dict[str, float]:
        """Return the values of the symbols, by name, in the piece that holds at t."""
        starts, c = self.signal.pieces(t)
        return dict(zip((symbol.name for symbol in self.symbols), self._row(starts, c)[0], strict=True))

    def columns(self, t: ArrayLike) -> dict[str, Any]:
        """Return the values of the symbols, by name, at several times: arrays of shape (k,)."""
        return dict(
            zip((symbol.name for symbol in self.symbols), self._row(*self.signal.pieces(t)).T, strict=True)
        )

    def table(self) -> SignalTable:
        """Return the constants of all pieces, for code that looks them up by itself."""
        signal = self.signal
        breaks = signal.times.copy()
        rows = self._row(np.concatenate([breaks[:1], breaks]), signal._coefficients).copy()
        if signal._outside == "error":
            rows[0] = np.nan
            if signal.interpolation != "previous":
                rows[-1] = np.nan
                breaks[-1] = np.nextafter(breaks[-1], np.inf)  # the end belongs to the last piece
        return SignalTable(breaks, rows)

    def _row(self, starts: Array, c: Array) -> Array:
        return c if self.signal.degree == 0 else np.column_stack([starts, c])
