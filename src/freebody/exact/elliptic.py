"""Jacobi's functions and the integrals of the third kind of a motion, vectorized over time, up to k² = 1.

A motion that is periodic in tau with the quarter period K is followed from the nearest multiple of K. There
``|x| <= K/2``, every quantity is a sum of positive terms, and no digits are lost. Whole quarters are counted
exactly, so that errors do not grow with time.

Near a separatrix the period depends on the logarithm of a difference of almost equal numbers. The data are exact
(each double is a rational number), so the few constants of a motion are computed from them once, with a hundred
digits (:func:`precise`). Only the functions of time are computed in doubles.

Sources: *NIST Handbook of Mathematical Functions* (DLMF), chapters 19, 20 and 22; E. T. Whittaker, G. N.
Watson, *A Course of Modern Analysis*, 4th ed., chapters 21 and 22; B. C. Carlson, "Computing elliptic
integrals by duplication", *Numerische Mathematik* 33 (1979), 1-16.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from threading import local as per_thread
from typing import Any, NamedTuple, TypeAlias

import numpy as np

DIGITS = 100
Precise: TypeAlias = Any
"""A number with a hundred digits: mpmath's ``mpf`` in the context :func:`precise`."""

_CONTEXTS = per_thread()
_FAR = 300.0  # cosh(x)² and 1 / cosh(x)² are still doubles


def precise() -> Any:
    """mpmath's arithmetic and functions with a hundred digits; ``convert`` takes a Fraction or float exactly.

    Each thread has its own context, because mpmath's functions change the precision of theirs while they run.
    """
    if not hasattr(_CONTEXTS, "context"):
        from mpmath import MPContext

        _CONTEXTS.context = MPContext()
        _CONTEXTS.context.dps = DIGITS
    return _CONTEXTS.context


def complete_third(m1: Precise, nu: Precise) -> Precise:
    """Integral of 1 / (1 + nu sn²) over one quarter period, nu > -1, m1 > 0 (DLMF 19.25.2)."""
    mp = precise()
    return mp.elliprf(0, m1, 1) - nu / 3 * mp.elliprj(0, m1, 1, 1 + nu)


def complete_pulse(m1: Precise, nu: Precise) -> Precise:
    """Integral of cn² / (1 + nu sn²) over one quarter period, nu > -1, m1 > 0 (DLMF 19.25.2)."""
    mp = precise()
    return mp.elliprf(0, m1, 1) - (1 + nu) / 3 * mp.elliprj(0, m1, 1, 1 + nu)


class Jacobi:
    """sn, cn and dn of parameter m = k² for arguments between -K/2 and K/2, by theta series.

    With the nome q = exp(-pi K'/K), z = pi x / (2 K) for m <= 1/2 (DLMF 22.2.4 to 22.2.6); for m > 1/2 by
    Jacobi's imaginary transformation sn(x, k) = -i sc(i x, k'), cn = nc(i x, k'), dn = dc(i x, k') (DLMF
    22.6.1), whose series are hyperbolic: at k = 1 they are tanh(x), sech(x), sech(x).

    Parameters
    ----------
    m, m1 : Precise
        k² and 1 - k², given separately so that neither loses digits.
    """

    def __init__(self, m: Precise, m1: Precise) -> None:
        mp = precise()
        self.m, self.m1 = float(m), float(m1)
        self.exact_m1 = m1
        self.modulus1 = float(mp.sqrt(m1))
        self.exact_K = mp.elliprf(0, m1, 1)  # infinite at m1 = 0
        self.K = float(self.exact_K)
        self._hyperbolic = m > m1
        K, other = self.K, float(mp.elliprf(0, m, 1))
        if self._hyperbolic:
            K, other = other, K
        self._scale = math.pi / (2 * K)
        decay = math.pi * other / K  # nome q = exp(-decay)
        farthest = self.K / 2 * self._scale if self._hyperbolic and math.isfinite(self.K) else 0.0
        # terms below 1e-20 of the first are omitted (their exponentials may not even be doubles)
        orders = [n for n in range(9) if n == 0 or n * (n + 1) * decay - (2 * n + 1) * farthest < 46]
        self._odd = [(2 * n + 1, math.exp(-n * (n + 1) * decay) if n else 1.0) for n in orders]
        self._even = [
            (2 * n, math.exp(-n * n * decay)) for n in range(1, 9) if n * n * decay - 2 * n * farthest < 46
        ]
        self._theta2 = sum(weight for _, weight in self._odd)  # without 2 q^(1/4)
        self._theta3 = 1 + 2 * sum(weight for _, weight in self._even)
        self._theta4 = 1 + 2 * sum((-1) ** (n // 2) * weight for n, weight in self._even)

    def near_zero(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """sn(x), cn(x), dn(x) for ``|x| <= K/2`` (any x when m = 1)."""
        sine, cosine = (np.sinh, np.cosh) if self._hyperbolic else (np.sin, np.cos)
        z = self._scale * (np.clip(x, -_FAR, _FAR) if math.isinf(self.K) else x)
        theta1 = sum((-1) ** (n // 2) * weight * sine(n * z) for n, weight in self._odd)
        theta2 = sum(weight * cosine(n * z) for n, weight in self._odd)
        one = np.ones_like(z)  # without even terms (m = 0 or 1) the sums below are plain numbers
        theta3 = one + 2 * sum(weight * cosine(n * z) for n, weight in self._even)
        theta4 = one + 2 * sum((-1) ** (n // 2) * weight * cosine(n * z) for n, weight in self._even)
        if self._hyperbolic:
            return (
                self._theta3 / self._theta4 * theta1 / theta2,
                self._theta2 / self._theta4 * theta4 / theta2,
                self._theta2 / self._theta3 * theta3 / theta2,
            )
        return (
            self._theta3 / self._theta2 * theta1 / theta4,
            self._theta4 / self._theta2 * theta2 / theta4,
            self._theta4 / self._theta3 * theta3 / theta4,
        )


class Beat:
    """Division of times into whole intervals and a rest: t = n T + r, \\|r\\| <= T/2.

    T is split so that n times its first two parts is exact for n up to 2^26 (Cody and Waite's reduction): r
    is right to an ulp of T however many intervals have passed.
    """

    def __init__(self, interval: Precise) -> None:
        self.interval = float(interval)
        self._parts = split(interval)

    def __call__(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return n and r."""
        if math.isinf(self.interval):
            return np.zeros_like(t), t
        count = np.rint(t / self.interval)
        high, middle, low = self._parts
        return count, ((t - count * high) - count * middle) - count * low


def split(value: Precise) -> tuple[float, float, float]:
    """Three doubles whose sum is the value; the first two have 26 bits."""
    if precise().isinf(value):
        return float(value), 0.0, 0.0
    parts = []
    for _ in range(2):
        mantissa, exponent = math.frexp(float(value))
        parts.append(math.ldexp(round(math.ldexp(mantissa, 26)), exponent - 26))
        value -= parts[-1]
    return parts[0], parts[1], float(value)


class Phase(NamedTuple):
    """Position in the period at given times: tau = quarter K + x.

    ``beats``, ``rest``: t = beats (K / rate) + rest. ``s, c, d``: sn, cn, dn of x. ``odd``: quarter is odd.
    """

    beats: np.ndarray
    rest: np.ndarray
    quarter: np.ndarray
    x: np.ndarray
    odd: np.ndarray
    s: np.ndarray
    c: np.ndarray
    d: np.ndarray


class Clock:
    """Argument tau = rate t + start of the elliptic functions of a motion.

    Parameters
    ----------
    functions : Jacobi
    rate, start : Precise
        ``|start| <= K``.
    """

    def __init__(self, functions: Jacobi, rate: Precise, start: Precise) -> None:
        mp = precise()
        self.functions, self.rate = functions, float(rate)
        K = functions.exact_K
        self.exact_quarter = K / rate if rate else mp.inf
        self.quarter = float(self.exact_quarter)
        self._beat = Beat(self.exact_quarter)
        self.quarter0 = 0 if mp.isinf(K) else int(mp.nint(start / K))
        self.x0 = float(start - self.quarter0 * K) if self.quarter0 else float(start)

    def __call__(self, t: Any) -> Phase:
        """Return the phase at times ``t``."""
        functions = self.functions
        count, rest = self._beat(np.asarray(t, dtype=float))
        x = self.rate * rest + self.x0
        shift = np.zeros_like(x) if math.isinf(functions.K) else np.rint(x / functions.K)
        if not math.isinf(functions.K):
            x = x - shift * functions.K
        quarter = count + self.quarter0 + shift
        return Phase(count, rest, quarter, x, np.mod(quarter, 2) == 1, *functions.near_zero(x))

    def whole(self, phase: Phase) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """sn, cn and dn of tau itself: sn(x + K) = cd(x), cn(x + K) = -k' sd(x), dn(x + K) = k' nd(x) (DLMF 22.4.3)."""
        k1 = self.functions.modulus1
        s, c, d, odd = phase.s, phase.c, phase.d, phase.odd
        sign = np.where(np.mod(phase.quarter, 4) >= 2, -1.0, 1.0)
        return (
            sign * np.where(odd, c / d, s),
            sign * np.where(odd, -k1 * s / d, c),
            np.where(odd, k1 / d, d),
        )


class Angle:
    """The angle slope t + G(tau), where G gains the same in every quarter: an exact multiple and a rest.

    Parameters
    ----------
    clock : Clock
    slope : Precise
        [rad/s]
    gain : Precise
        Increase of G in a quarter period [rad]; not used when the quarter is infinite.
    local : callable
        ``local(phase, odd) -> G - quarter * gain`` for a phase whose quarters are all even or all odd.
    """

    def __init__(
        self, clock: Clock, slope: Precise, gain: Precise, local: Callable[[Phase, bool], np.ndarray]
    ) -> None:
        self._clock, self._slope, self._gain, self._local = clock, float(slope), float(gain), local
        quarter = clock.exact_quarter
        #: Increase of the angle in a quarter period [rad].
        self.exact_advance = gain if precise().isinf(quarter) else slope * quarter + gain
        self._parts = split(self.exact_advance)
        self._start = 0.0
        self._start = float(self._value(clock(0.0))[1])

    def halves(self, phase: Phase) -> tuple[np.ndarray, np.ndarray]:
        """Two numbers whose sum is the angle since t = 0. The first is exact, so that its sine is right too."""
        whole, rest = self._value(phase)
        return whole, rest - self._start

    def __call__(self, phase: Phase) -> np.ndarray:
        """Return the angle since t = 0 [rad]."""
        whole, rest = self.halves(phase)
        return whole + rest

    def _value(self, phase: Phase) -> tuple[np.ndarray, np.ndarray]:
        high, middle, low = self._parts
        local = np.empty(np.shape(phase.x))
        for odd in (False, True):
            chosen = phase.odd == odd
            if np.any(chosen):
                local[chosen] = self._local(Phase(*(np.asarray(part)[chosen] for part in phase)), odd)
        extra = phase.quarter - phase.beats
        turns = np.where(extra == 0, 0.0, extra * self._gain)
        return phase.beats * high, phase.beats * (middle + low) + self._slope * phase.rest + turns + local


def pulse(phase: Phase, m1: float, nu: float) -> np.ndarray:
    """Integral of cn² / (1 + nu sn²) from 0 to x, nu >= 0.

    s R_C(d²/c², p q/c²) + m1 / (1 + nu) s³/3 R_J(c², d², 1, q), p = 1 + nu s², q = c² + m1 s² / (1 + nu):
    Carlson's form of the integral, after a change of parameter that makes all terms positive (DLMF 19.21.12,
    19.25.14).
    """
    from scipy.special import elliprc, elliprj

    s2, c2, d2 = phase.s**2, phase.c**2, phase.d**2
    ratio = m1 / (1 + nu)
    first = phase.s * elliprc(d2 / c2, (1 + nu * s2) * (1 + ratio * s2 / c2))
    if m1 == 0:  # on the separatrix: arctan(sqrt(nu) tanh(x)) / sqrt(nu)
        return first
    return first + ratio * phase.s * s2 / 3 * elliprj(c2, d2, 1.0, c2 + ratio * s2)


def pulse_from_quarter(phase: Phase, m1: float, nu: float) -> np.ndarray:
    """Integral of the function of :func:`pulse` from K to K + x: of m1 sn² / (dn² + nu cn²) from 0 to x."""
    from scipy.special import elliprj

    s2, c2, d2 = phase.s**2, phase.c**2, phase.d**2
    ratio = m1 / (1 + nu)
    return ratio * phase.s * s2 / 3 * elliprj(c2, d2, 1.0, c2 + ratio * s2)


def turning(axis: int, *angles: np.ndarray) -> np.ndarray:
    """Unit quaternions (scalar part first) of a turn about coordinate axis 0, 1 or 2 by the sum of the angles."""
    total = None
    for angle in angles:
        q = np.zeros((*np.shape(angle), 4))
        q[..., 0], q[..., axis + 1] = np.cos(angle / 2), np.sin(angle / 2)
        total = q if total is None else product(total, q)
    assert total is not None
    return total


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Product of quaternions, scalar part first: the turn q, followed by the turn p."""
    p0, p1, p2, p3 = np.moveaxis(p, -1, 0)
    q0, q1, q2, q3 = np.moveaxis(q, -1, 0)
    return np.stack(
        [
            p0 * q0 - p1 * q1 - p2 * q2 - p3 * q3,
            p0 * q1 + p1 * q0 + p2 * q3 - p3 * q2,
            p0 * q2 - p1 * q3 + p2 * q0 + p3 * q1,
            p0 * q3 + p1 * q2 - p2 * q1 + p3 * q0,
        ],
        axis=-1,
    )


def conjugate(q: np.ndarray) -> np.ndarray:
    """Quaternion of the opposite turn."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def matrix(q: np.ndarray) -> np.ndarray:
    """Rotation matrices of unit quaternions."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """Unit quaternion of one rotation matrix by its largest component (Shepperd), scalar part >= 0."""
    R = np.asarray(rotation, dtype=float)
    squares = np.array(
        [
            1 + R[0, 0] + R[1, 1] + R[2, 2],
            1 + R[0, 0] - R[1, 1] - R[2, 2],
            1 - R[0, 0] + R[1, 1] - R[2, 2],
            1 - R[0, 0] - R[1, 1] + R[2, 2],
        ]
    )
    skew = np.array([0.0, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    products = np.array(
        [
            [0.0, skew[1], skew[2], skew[3]],
            [skew[1], 0.0, R[0, 1] + R[1, 0], R[0, 2] + R[2, 0]],
            [skew[2], R[0, 1] + R[1, 0], 0.0, R[1, 2] + R[2, 1]],
            [skew[3], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], 0.0],
        ]
    )
    largest = int(np.argmax(squares))
    q = products[largest].copy()
    q[largest] = squares[largest]
    q /= np.linalg.norm(q)
    return q if q[0] >= 0 else -q


def turns(rate: Precise) -> tuple[Beat, float]:
    """Beat of one whole turn at a constant rate, and the rate as a double."""
    mp = precise()
    full = 2 * mp.pi / abs(rate) if rate else mp.inf
    return Beat(full), float(rate)
