"""Derivatives of single numbers of a run by parameters and initial values: extremes, values at the ends, event times.

x(t, p) is a quantity along the motion, Dx = (∂x/∂y) s + ∂x/∂p its derivative at a fixed time, x' its rate.

    time of an event    g(t, p) = 0:  dt/dp = -Dg / g'
    value at an end     dx/dp = Dx + x' dt/dp,    t the time at which the run starts or ends
    greatest value      x'₋ > 0 > x'₊ on its two sides:
                        dx/dp = (x'₋ Dx₊ - x'₊ Dx₋) / (x'₋ - x'₊)

Where x is smooth, Dx is the same on both sides, and dx/dp = Dx at the extreme (the envelope theorem). At a bend of x
the extreme moves along both branches. A greatest value that is reached at several times with different derivatives has
none.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError
from ...scalar.algebra import Expression
from ..ending import End
from ..kernels.program import Program
from ..ode.dense_output import Crossing
from ..trajectory.computed_motion import ComputedMotion
from ..trajectory.event import expressions_of
from ..trajectory.extremes import search_blocks
from ..trajectory.path import SampledPath
from .variation import Variation

Array = NDArray[np.float64]

_WIDTH = 1e-9  # of the bracket of an extreme, relative to an eighth of a step; Dx is interpolated in it
_MOST = 80  # iterations for a bracket
_ROUND_OFF = 64 * float(np.finfo(float).eps)


class Numbers(ABC):
    """Derivatives of single numbers of one motion, with contacts or without.

    ``shifts``, shape (2, unknowns), are the derivatives of the times at which the run starts and, unless an event ends
    it, ends.
    """

    def __init__(self, motion: ComputedMotion, shifts: Array) -> None:
        self.motion, self.shifts = motion, shifts

    def number(self, how: str, quantity: Expression, name: str) -> Array:
        """Return the derivatives of a number of the whole run, such as ("max", theta); ``name`` is its text.

        Raises
        ------
        SimulationError
            The number has no derivative.
        """
        if how in ("initial", "final"):
            return self._at_end(quantity, how, name)
        if how == "range":
            return self._greatest(quantity, 1, name) - self._greatest(quantity, -1, name)
        return self._greatest(quantity, 1 if how == "max" else -1, name)

    @abstractmethod
    def event(self, crossing: Crossing) -> Array:
        """Return the derivatives of the time of an event."""

    @abstractmethod
    def _at_end(self, quantity: Expression, how: str, name: str) -> Array:
        """Return the derivatives of the first or last value of a quantity."""

    @abstractmethod
    def _greatest(self, quantity: Expression, sign: int, name: str) -> Array:
        """Return the derivatives of a quantity where ``sign`` times it is greatest."""

    @cached_property
    def end(self) -> Array:
        """Derivatives of the time at which the run ends."""
        path = self.motion.path
        if path.status == End.FINISHED:
            return np.asarray(self.shifts[1])
        if path.status == End.TERMINAL:
            return self.event(path.crossings[-1])
        raise SimulationError(
            f"Expected a run that reaches its end for a derivative of what it ends with, but this one is "
            f"'{path.status}' at t = {path.end:.6g} s. End it before."
        )


class NumberDerivatives(Numbers):
    """Derivatives of single numbers of a motion without contacts."""

    def __init__(self, motion: ComputedMotion, variation: Variation, shifts: Array) -> None:
        super().__init__(motion, shifts)
        self.variation, self.n, self.k = variation, variation.kernels.size, len(variation.unknowns)

    # -- times -------------------------------------------------------------------------------------------------

    def event(self, crossing: Crossing) -> Array:
        """Return the derivatives of the time of an event.

        Raises
        ------
        SimulationError
            The expression jumps over zero, or touches zero by no more than the error of the run.
        """
        motion, path, t = self.motion, self.motion.path, crossing.time
        spec = motion.specs[crossing.number]
        program = self._course(expressions_of(motion.kernels.model, (spec,))[0])
        _, (rate,), gradients, slopes = self._slopes(program, np.array([t]))
        (error,) = self._errors(gradients)
        step = _step(path, t)
        located = self._observed(program, "course", np.array([t]), crossing.state[None])[0, 0]
        if abs(located) > error + 8 * np.finfo(float).eps * max(abs(t), step) * abs(rate):
            raise SimulationError(
                f"Expected event '{spec.name}' to pass through zero for a derivative of its time, but at t = {t:.6g} s "
                "it jumps from one sign to the other. Watch for what makes it jump."
            )
        # between the two zeros of g = g' τ + g'' τ²/2 is a dip of the depth g'²/(2 g'')
        low, high = sorted((path.start, path.end))
        near = np.array([max(low, t - step / 1024), min(high, t + step / 1024)])
        bend = 0.0
        if near[1] > near[0]:
            before, after = self._observed(program, "course", near, path.sample(near))[:, 1]
            bend = abs(after - before) / (near[1] - near[0])
        if rate == 0 or rate**2 <= 2 * bend * error:
            raise SimulationError(
                f"Expected event '{spec.name}' to pass through zero for a derivative of its time, but at t = {t:.6g} s "
                f"it only touches zero, with the rate {rate:.2g}: a change of a parameter makes two events of it, or "
                "none. Ask for the greatest or smallest value of its expression instead."
            )
        return -slopes[0] / rate

    def _at_end(self, quantity: Expression, how: str, name: str) -> Array:
        path = self.motion.path
        moment, shift = (path.start, self.shifts[0]) if how == "initial" else (path.end, self.end)
        _, rates, _, slopes = self._slopes(self._course(quantity), np.array([moment]))
        return _finite(slopes[0] + rates[0] * shift, name, moment)

    # -- extremes ----------------------------------------------------------------------------------------------

    def _greatest(self, quantity: Expression, sign: int, name: str) -> Array:
        program = self._course(quantity)
        brackets, best = self._brackets(program, sign, name)
        peaks = [self._peaks(program, sign, brackets, best), *self._edges(program, sign, best)]
        times, values, slopes, gradients = (np.concatenate(parts) for parts in zip(*peaks, strict=True))
        top = int(np.argmax(values)) if values.size else -1
        margin = 2 * self._errors(gradients[top]) + _rounded(best) if values.size else 0.0
        if not values.size or values[top] < best - margin:
            raise SimulationError(
                f"Expected a derivative of '{name}', but the quantity jumps near {sign * best:.6g}. Ask for a quantity "
                "that is continuous."
            )
        tied = np.flatnonzero(values >= values[top] - margin)
        for i in tied:
            _finite(slopes[i], name, times[i])
        apart = np.abs(slopes[tied] - slopes[top]) - self._slope_errors(gradients[top], slopes[top])
        if apart.max() > 0:
            i, j = np.unravel_index(int(np.argmax(apart)), apart.shape)
            first, last = sorted((top, int(tied[i])))
            unknown = self.variation.unknowns[j].name
            raise SimulationError(
                f"Expected one derivative of '{name}' by '{unknown}', but the run reaches {sign * values[top]:.6g} "
                f"at t = {times[first]:.6g} s and at t = {times[last]:.6g} s alike, with the derivatives "
                f"{slopes[first, j]:.6g} and {slopes[last, j]:.6g} there: which one counts depends on the sign of "
                "the change. Ask for the quantity at these times."
            )
        return np.asarray(slopes[top], dtype=float)

    def _brackets(self, program: Program, sign: int, name: str) -> tuple[Array, float]:
        """Return times between which a quantity stops to rise, with its greater value at them and what the tangents add
        to it, shape (n, 4); and the greatest value of all.
        """
        path = self.motion.path
        ascent = sign if path.end >= path.start else -sign
        rows, best = [np.empty((0, 4))], -math.inf
        for _, times, found, _ in search_blocks(
            path, lambda t, _: self._values(program, t, dense=True), [name]
        ):
            f, r = np.array([[sign], [ascent]]) * found.T
            best = max(best, float(np.fmax.reduce(f)))
            i = np.flatnonzero((r[:-1] >= 0) & (r[1:] <= 0))
            h, high = np.abs(times[i + 1] - times[i]), np.maximum(f[i], f[i + 1])
            gain = np.minimum(f[i] + r[i] * h, f[i + 1] - r[i + 1] * h) - high
            rows.append(np.stack([times[i], times[i + 1], high, gain], axis=1))
        if not math.isfinite(best):
            raise SimulationError(
                f"Expected finite numbers for a derivative of '{name}', got {sign * best:g}."
            )
        return np.concatenate(rows), best

    def _peaks(self, program: Program, sign: int, brackets: Array, best: float) -> tuple[Array, ...]:
        """Return times, values, derivatives and gradients of the extremes in brackets that may reach ``best``."""
        path = self.motion.path
        ascent = sign if path.end >= path.start else -sign
        reach = best - 2 * self._errors(self._slopes(program, brackets[:, 0])[2]) - _rounded(best)
        a, b, _, gain = brackets[brackets[:, 2] + 2 * np.abs(brackets[:, 3]) >= reach].T
        curved = np.abs(gain) > _rounded(best)  # the others are flat to round-off
        a[curved], b[curved] = _narrowed(
            lambda t: ascent * self._values(program, t)[:, 1], a[curved], b[curved]
        )
        x0, r0, gradients, d0 = self._slopes(program, a)
        x1, r1, _, d1 = self._slopes(program, b)
        with np.errstate(all="ignore"):
            part = np.where(r0 == r1, 0.5, np.clip(r0 / (r0 - r1), 0.0, 1.0))[:, None]
        slopes = d0 + part * (d1 - d0)
        steady = np.abs(b - a) * (np.abs(r0) + np.abs(r1)) + self._errors(gradients) + _rounded(best)
        slopes[np.abs(x1 - x0) > steady] = np.nan
        return a, np.maximum(sign * x0, sign * x1), slopes, gradients

    def _edges(self, program: Program, sign: int, best: float) -> list[tuple[Array, ...]]:
        """Return the same of the ends of the run that may reach ``best``."""
        path = self.motion.path
        result: list[tuple[Array, ...]] = []
        ends = ("initial", "final") if path.steps else ("initial",)
        ascent = sign if path.end >= path.start else -sign
        for how, outwards in zip(ends, (-ascent, ascent), strict=False):
            time = np.array([path.start if how == "initial" else path.end])
            x, rate, gradient, slope = self._slopes(program, time)
            if path.steps and outwards * rate[0] < 0 or sign * x[0] < best - 2 * self._errors(gradient)[0]:
                continue
            slope = slope + rate * (self.shifts[0] if how == "initial" else self.end)
            result.append((time, sign * x, slope, gradient))
        return result

    # -- observation -------------------------------------------------------------------------------------------

    def _course(self, quantity: Expression) -> Program:
        return self.variation.course(quantity)

    def _observed(self, program: Program, function: str, times: Array, states: Array) -> Array:
        return self.motion._observed(program, function, times, states)

    def _values(self, program: Program, times: Array, dense: bool = False) -> Array:
        """Return x and x' at times of the run, shape (times, 2)."""
        return self._observed(program, "course", times, self.motion.path.sample(times, dense))

    def _slopes(self, program: Program, times: Array) -> tuple[Array, Array, Array, Array]:
        """Return x, x', ∂x/∂y and Dx at times of the run."""
        observed = self._observed(program, "slopes", times, self.motion.path.sample(times))
        return observed[:, 0], observed[:, 1], observed[:, 2 : 2 + self.n], observed[:, 2 + self.n :]

    @cached_property
    def _largest(self) -> Array:
        """Greatest absolute values of y, then of each s_j, over the run, shape (1 + unknowns, components of y)."""
        result: Array = np.abs(self.motion.path.states).max(axis=0).reshape(1 + self.k, self.n)
        return result

    @property
    def _steps_error(self) -> Array:
        """Sum of the bounds of the errors of all steps, for each component of y of the size 1."""
        return max(1, self.motion.path.steps) * self.motion.tolerances

    def _errors(self, gradients: Array) -> Array:
        """Return estimates of the errors of a quantity from its gradients, shape (..., components of y)."""
        result: Array = np.abs(gradients) @ (self._steps_error * (1 + self._largest[0]))
        return result

    def _slope_errors(self, gradient: Array, slopes: Array) -> Array:
        """Return estimates of the errors of its derivatives by the unknowns."""
        of_state = (1 + self._largest[1:]) @ (np.abs(gradient) * self._steps_error)
        result: Array = 2 * (of_state + self._steps_error.max(initial=0.0) * (1 + np.abs(slopes)))
        return result


def _rounded(value: float) -> float:
    return _ROUND_OFF * (1 + abs(value))


def _step(path: SampledPath, t: float) -> float:
    """Return the length of the step in which a time lies."""
    if not path.steps:
        return 0.0
    passed = np.abs(path.times - path.start) <= abs(t - path.start)
    return float(abs(path.lengths[min(int(passed.sum()), path.steps) - 1]))


def _finite(slopes: Array, name: str, t: float) -> Array:
    """Return derivatives; refuse those that are not finite."""
    if not np.isfinite(slopes).all():
        raise SimulationError(
            f"Expected a derivative of '{name}', but at t = {t:.6g} s, where it is reached, the quantity jumps or has "
            "no finite derivative. Ask for a quantity that is smooth there."
        )
    return slopes


def _narrowed(function: Callable[[Array], Array], a: Array, b: Array) -> tuple[Array, Array]:
    """Return narrow brackets of zeros at which a function falls, by the method of Chandrupatla (1997), all at once."""
    least = np.maximum(_WIDTH * np.abs(b - a), 4 * np.finfo(float).eps * np.abs(b))
    x1, x2, f1, f2 = a.copy(), b.copy(), function(a), function(b)
    outside = f1 < 0, f2 > 0  # values of the dense output and of the steps differ by the error of the former
    x2[outside[0]], x1[outside[1]] = x1[outside[0]], x2[outside[1]]
    part = np.full(x1.shape, 0.5)
    for _ in range(_MOST):
        k = np.flatnonzero((np.abs(x2 - x1) > least) & (f1 != 0))
        if not k.size:
            break
        x = x1[k] + part[k] * (x2[k] - x1[k])
        f = function(x)
        same = (f > 0) == (f1[k] > 0)
        x3, f3 = np.where(same, x1[k], x2[k]), np.where(same, f1[k], f2[k])
        x2[k], f2[k] = np.where(same, x2[k], x1[k]), np.where(same, f2[k], f1[k])
        x1[k], f1[k] = x, f
        with np.errstate(all="ignore"):
            xi, phi = (x - x2[k]) / (x3 - x2[k]), (f - f2[k]) / (f3 - f2[k])
            inner = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
            guess = f / (f2[k] - f) * f3 / (f2[k] - f3)
            guess += (x3 - x) / (x2[k] - x) * f / (f3 - f) * f2[k] / (f3 - f2[k])
            low = 0.5 * least[k] / np.abs(x2[k] - x)
            part[k] = np.clip(np.where(inner & np.isfinite(guess), guess, 0.5), low, 1 - low)
    x2[f1 == 0] = x1[f1 == 0]
    falls = f1 >= 0
    return np.where(falls, x1, x2), np.where(falls, x2, x1)
