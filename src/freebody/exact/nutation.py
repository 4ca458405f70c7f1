"""The heavy symmetric top about a fixed point, for any spin and any start, in closed form.

With u = cos(theta), a = I_zeta Omega / I_xi, b = psi' sin²(theta) + a u (the moment of momentum about the
vertical over I_xi), beta = 2 m g L / I_xi and alpha = theta'² + psi'² sin²(theta) + beta u, all constant::

    u'² = f(u) = (1 - u²) (alpha - beta u) - (b - a u)² = beta (u - u_1) (u - u_2) (u - u_3)
    -1 <= u_1 <= u_2 <= 1 <= u_3,    u = u_1 + (u_2 - u_1) sn²(tau)
    tau = t sqrt(beta (u_3 - u_1)) / 2 + tau_0,    k² = (u_2 - u_1) / (u_3 - u_1)
    psi' = (b - a u) / (1 - u²) = (b - a) / (2 (1 - u)) + (b + a) / (2 (1 + u))
    phi' = Omega - u psi'       = Omega - a - (b - a) / (2 (1 - u)) + (b + a) / (2 (1 + u))

so that psi and phi are integrals of the third kind. Each is taken from the nearest turning point of theta, in
the form in which all terms are positive. No digits are lost when the axis passes close to the vertical (u_2 or
-u_1 almost 1) or lingers there (k² almost 1, near the sleeping top).

Sources: E. T. Whittaker, *A Treatise on the Analytical Dynamics of Particles and Rigid Bodies*, 4th ed.,
sections 71 and 72; H. Goldstein et al., *Classical Mechanics*, 3rd ed., section 5.7; L. D. Landau, E. M.
Lifshitz, *Mechanics*, 3rd ed., section 35; *NIST Handbook of Mathematical Functions*, sections 19.21 and
19.25; sections 6.9, 6.10 and 6.12 of the chapter.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from . import elliptic
from .elliptic import DIGITS, Angle, Clock, Jacobi, Phase, Precise, complete_third, precise

#: Amplitude of u = cos(theta) below which a nutation is called steady, and distance between the stop of the precession
#: and the upper limit, in units of the nutation, below which a path is called a cusp. Rounding of the data can do this.
ROUNDING = 1e-12


@dataclass(frozen=True)
class Constants:
    """Integrals of the motion, roots of the cubic and start, to a hundred digits."""

    a: Precise
    b: Precise
    beta: Precise
    Omega: Precise
    roots: tuple[Precise, Precise, Precise]
    start: Precise

    @classmethod
    def from_start(
        cls,
        A: Fraction,
        C: Fraction,
        W: Fraction,
        theta0: Fraction,
        spin: Fraction,
        rate: Fraction,
        psi_rate: Fraction,
    ) -> Constants:
        """Constants from the data at t = 0; A, C are the moments of inertia I_xi, I_zeta and W is m g L."""
        mp = precise()
        u0, sine = mp.cos_sin(mp.convert(theta0))
        a, beta = mp.convert(C * spin / A), mp.convert(2 * W / A)
        turn = mp.convert(psi_rate) * sine * sine
        b = turn + a * u0
        alpha = mp.convert(rate) ** 2 + mp.convert(psi_rate) * turn + beta * u0
        if a == 0 and b == 0:  # a plane pendulum: f = (1 - u²) (alpha - beta u)
            low, middle, high = sorted((-mp.one, mp.one, alpha / beta))
        else:
            # f(u_0 + x) = f_0 + f_1 x + f_2 x² + beta x³, where f_0 = (sin(theta) theta')² cannot be negative
            f0 = (sine * mp.convert(rate)) ** 2
            f1 = -2 * u0 * (alpha - beta * u0) - beta * (1 - u0 * u0) + 2 * a * turn
            f2 = 3 * beta * u0 - alpha - a * a

            def f(u: Precise) -> Precise:
                x = u - u0
                return f0 + x * (f1 + x * (f2 + x * beta))

            low = _root(f, -mp.one, u0)
            middle = _root(lambda u: -f(u), u0, mp.one) if u0 < 1 else mp.one
            high = max((alpha + a * a) / beta - low - middle, mp.one)
        spread = middle - low
        s2 = _fraction(u0 - low, spread) if spread else mp.zero
        # F(phi | m) = s R_F(c², d², 1) (DLMF 19.25.5)
        start = mp.sqrt(s2) * mp.elliprf(1 - s2, _fraction(high - u0, high - low), 1) if s2 else mp.zero
        # u rises with tau, while theta falls
        return cls(a, b, beta, mp.convert(spin), (low, middle, high), -start if rate > 0 else start)

    @classmethod
    def asymptotic(cls, A: Fraction, C: Fraction, W: Fraction, spin: Fraction) -> Constants:
        """Constants of the motion that ends upright, at its lowest point at t = 0."""
        mp = precise()
        a, beta = mp.convert(C * spin / A), mp.convert(2 * W / A)
        return cls(a, a, beta, mp.convert(spin), (a * a / beta - 1, mp.one, mp.one), mp.zero)


def _fraction(part: Precise, whole: Precise) -> Precise:
    """part / whole, kept between 0 and 1 against round-off."""
    return min(max(part / whole, precise().zero), precise().one)


def _root(function: Callable[[Precise], Precise], low: Precise, high: Precise) -> Precise:
    """The point where the function turns from negative at ``low`` to positive at ``high``, by bisection.

    Bisection also finds the double roots that matter here, at which Newton's method is slow and inaccurate.
    """
    width, smallest = high - low, precise().mpf(10) ** (4 - DIGITS)
    while width > smallest:
        width /= 2
        if function(low + width) <= 0:
            low += width
    return low + width / 2


class Sleeping:
    """Motion of a top that stays upright. psi' = a/2 is the limit of small motions; only psi + phi has a meaning."""

    def __init__(self, psi_rate: float, phi_rate: float) -> None:
        self._rates = psi_rate, phi_rate

    def theta(self, t: Any) -> np.ndarray:
        """Zeros."""
        return np.zeros(np.shape(t))

    theta_rate = theta

    def psi(self, t: Any) -> np.ndarray:
        """Precession angle since t = 0 [rad]."""
        return self._rates[0] * np.asarray(t, dtype=float)

    def phi(self, t: Any) -> np.ndarray:
        """Spin angle since t = 0 [rad]."""
        return self._rates[1] * np.asarray(t, dtype=float)

    def halves(self, t: Any) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
        """psi and phi [rad], in the form of :meth:`Nutation.halves`."""
        return (self.psi(t),), (self.phi(t),)

    def rates(self, t: Any) -> tuple[np.ndarray, np.ndarray]:
        """psi' and phi' [rad/s]."""
        return np.full(np.shape(t), self._rates[0]), np.full(np.shape(t), self._rates[1])


class Nutation:
    """theta, psi and phi by elliptic functions, from the nearest turning point."""

    def __init__(self, constants: Constants) -> None:
        mp = precise()
        u1, u2, u3 = constants.roots
        a, b = constants.a, constants.b
        spread, whole = u2 - u1, u3 - u1
        self.functions = functions = Jacobi(spread / whole, (u3 - u2) / whole)
        rate = mp.sqrt(constants.beta * whole) / 2
        self.clock = Clock(functions, rate, constants.start)
        self._rate, self._spread = float(rate), float(spread)
        # 1 - u and 1 + u at the two turning points, and the constants of the sums at other points
        self._below, self._above = (float(1 + u1), float(1 + u2)), (float(1 - u1), float(1 - u2))
        self._beyond = float(u3 - 1)
        self._share = float((1 - u2) / whole)
        self._upper_ratio = float((1 - u2) / (1 - u1))
        self._lower_ratio = float((1 + u1) / (1 + u2))
        self._minus, self._plus = float((b - a) / (2 * rate)), float((b + a) / (2 * rate))
        self._slip = float(constants.Omega - a)
        self._down, self._up = float((b + a) / 2), float((b - a) / 2)
        self._ahead = 1.0 if constants.start >= 0 else -1.0
        self._plane = a == 0 and b == 0
        self._vertical = b == a and u2 == 1

        self.limits = (_angle(1 - u2, 1 + u2), _angle(1 - u1, 1 + u1))
        self.path = self._class(constants)
        infinite = mp.isinf(functions.exact_K)
        # integrals of 1 / (1 - u) and 1 / (1 + u) over a quarter, each times a factor that may be zero
        minus = plus = mp.zero
        if not infinite and b != a:
            minus = (b - a) / (2 * rate) * complete_third(functions.exact_m1, -spread / (1 - u1)) / (1 - u1)
        if not infinite and b != -a:
            plus = (b + a) / (2 * rate) * complete_third(functions.exact_m1, spread / (1 + u1)) / (1 + u1)
        self.psi_angle = Angle(self.clock, mp.zero, plus + minus, self._local(1.0))
        self.phi_angle = Angle(self.clock, constants.Omega - a, plus - minus, self._local(-1.0))

    def _class(self, constants: Constants) -> str:
        u1, u2, u3 = constants.roots
        a, b = constants.a, constants.b
        if u2 == u3:
            return "asymptotic"
        if self._plane:
            return "plane rotation" if u2 == 1 else "plane swing"
        if self._vertical:
            return "through the vertical"
        if self._spread < ROUNDING:
            return "steady"
        if a == 0:
            return "wave"
        # the distance from the upper limit at which the precession stops, in units of the nutation, and the speed of
        # the axis along the circles of latitude at the two limits; near the vertical only the speed decides
        stop = (b / a - u2) / (u2 - u1)
        upper, lower = ((b - a * u) / precise().sqrt((1 - u) * (1 + u)) for u in (u2, u1))
        if abs(stop) < ROUNDING and abs(upper) < ROUNDING * abs(lower):
            return "cusp"
        return "loop" if (upper < 0) != (lower < 0) else "wave"

    def advance(self, angle: Angle) -> float:
        """Increase of psi or phi in a period, between two lowest points [rad]."""
        return math.nan if math.isinf(self.clock.quarter) else float(2 * angle.exact_advance)

    # -- theta ---------------------------------------------------------------------------------------

    def _sides(self, phase: Phase) -> tuple[np.ndarray, np.ndarray]:
        """1 - u and 1 + u, each a sum of positive terms."""
        m, m1 = self.functions.m, self.functions.m1
        s2, c2, d2 = phase.s**2, phase.c**2, phase.d**2
        minus = np.where(
            phase.odd,
            (self._above[1] + m * self._beyond * s2) / d2,
            self._above[1] + self._spread * c2,
        )
        plus = np.where(
            phase.odd,
            self._above_floor(c2, s2, m1) / d2,
            self._below[0] + self._spread * s2,
        )
        return minus, plus

    def _above_floor(self, c2: np.ndarray, s2: np.ndarray, m1: float) -> np.ndarray:
        return self._below[1] * (c2 + m1 * self._lower_ratio * s2)

    def theta(self, t: Any) -> np.ndarray:
        """Angle of the axis from the upward vertical [rad]."""
        phase = self.clock(t)
        minus, plus = self._sides(phase)
        if self._plane:
            sn, cn, dn = self.clock.whole(phase)
            if self.path == "plane swing":  # cos(theta/2) = +-k sn changes its sign at the bottom
                return 2 * np.arctan2(dn, self._ahead * math.sqrt(self.functions.m) * sn)
            # theta/2 = pi/2 -+ the amplitude, which grows without end
            k1 = self.functions.modulus1
            opposite = np.where(phase.odd, k1 * phase.s, phase.s)
            amplitude = phase.quarter * (math.pi / 2) + np.arctan2(opposite, phase.c)
            return math.pi - 2 * self._ahead * amplitude
        if self._vertical:  # sin(theta/2) = sqrt((1 - u_1)/2) cn changes its sign at the top
            return 2 * np.arctan2(math.sqrt(self._above[0]) * self.clock.whole(phase)[1], np.sqrt(plus))
        return 2 * np.arctan2(np.sqrt(minus), np.sqrt(plus))

    def theta_rate(self, t: Any) -> np.ndarray:
        """theta' [rad/s]."""
        phase = self.clock(t)
        minus, plus = self._sides(phase)
        sn, cn, dn = self.clock.whole(phase)
        if self._plane:
            # (theta/2)' / rate = -+k cn for the swing, -+dn for the rotation
            turning = math.sqrt(self.functions.m) * cn if self.path == "plane swing" else dn
            return -2 * self._ahead * self._rate * turning
        if self._vertical:
            return -2 * self._rate * math.sqrt(self._above[0]) * sn * dn / np.sqrt(plus)
        return -2 * self._rate * self._spread * sn * cn * dn / np.sqrt(minus * plus)

    # -- psi and phi -----------------------------------------------------------------------------------

    def psi(self, t: Any) -> np.ndarray:
        """Precession angle since t = 0 [rad]."""
        return self.psi_angle(self.clock(t))

    def phi(self, t: Any) -> np.ndarray:
        """Spin angle since t = 0 [rad]."""
        return self.phi_angle(self.clock(t))

    def halves(self, t: Any) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
        """psi and phi, each as numbers whose sum is the angle [rad]; see :meth:`Angle.halves`."""
        phase = self.clock(t)
        return self.psi_angle.halves(phase), self.phi_angle.halves(phase)

    def rates(self, t: Any) -> tuple[np.ndarray, np.ndarray]:
        """psi' and phi' [rad/s]."""
        minus, plus = self._sides(self.clock(t))
        # a zero factor may be divided by zero
        up = self._up / minus if self._up else np.zeros_like(minus)
        down = self._down / plus if self._down else np.zeros_like(plus)
        return up + down, self._slip - up + down

    def _local(self, sign: float) -> Callable[[Phase, bool], np.ndarray]:
        """Function for the integral of psi' (sign +1), or of phi' less its steady part (-1), from the turning point."""

        def local(phase: Phase, odd: bool) -> np.ndarray:
            total = np.zeros_like(phase.x)
            if self._minus:
                total += sign * self._minus * (self._top_upper if odd else self._top_lower)(phase)
            if self._plus:
                total += self._plus * (self._bottom_upper if odd else self._bottom_lower)(phase)
            return total

        return local

    def _top_lower(self, phase: Phase) -> np.ndarray:
        """Integral of 1 / (1 - u) from the lower turning point: (x + n s³/3 R_J(c², d², 1, 1 - n s²)) / (1 - u_1)."""
        from scipy.special import elliprj

        s2, c2, d2 = phase.s**2, phase.c**2, phase.d**2
        n = self._spread / self._above[0]
        p = c2 + self._upper_ratio * s2
        return (phase.x + n * phase.s * s2 / 3 * elliprj(c2, d2, 1.0, p)) / self._above[0]

    def _top_upper(self, phase: Phase) -> np.ndarray:
        """Integral of 1 / (1 - u) = d² / (1 - u_2 + m (u_3 - 1) s²) from the upper turning point.

        s R_C(c²/d², p q/d²) - h s³/3 R_J(c², d², 1, q), h = (1 - u_2)/(u_3 - u_1),
        q = c² + s² (u_3 - 1)/(u_3 - u_1), p = 1 + m s² (u_3 - 1)/(1 - u_2): DLMF 19.21.12. It stays accurate when
        1 - u_2 is tiny.
        """
        from scipy.special import elliprc, elliprj

        m = self.functions.m
        s2, c2, d2 = phase.s**2, phase.c**2, phase.d**2
        beyond = self._beyond / (self._beyond + self._above[0])
        p = 1 + m * self._beyond / self._above[1] * s2
        q = c2 + beyond * s2
        near = phase.s * elliprc(c2 / d2, p * q / d2)
        return (near - self._share * phase.s * s2 / 3 * elliprj(c2, d2, 1.0, q)) / self._above[1]

    def _bottom_lower(self, phase: Phase) -> np.ndarray:
        """Integral of 1 / (1 + u) from the lower turning point.

        (x + rho P(x)) / (1 + u_2), where P is the pulse with rho = (u_2 - u_1)/(1 + u_1).
        """
        rho = self._spread / self._below[0]
        return (phase.x + rho * elliptic.pulse(phase, self.functions.m1, rho)) / self._below[1]

    def _bottom_upper(self, phase: Phase) -> np.ndarray:
        """Integral of 1 / (1 + u) from the upper turning point.

        (x + e s³/3 R_J(c², d², 1, p)) / (1 + u_2), where e = m1 (u_2 - u_1)/(1 + u_2).
        """
        from scipy.special import elliprj

        m1 = self.functions.m1
        s2, c2, d2 = phase.s**2, phase.c**2, phase.d**2
        e = m1 * self._spread / self._below[1]
        p = c2 + m1 * self._lower_ratio * s2
        return (phase.x + e * phase.s * s2 / 3 * elliprj(c2, d2, 1.0, p)) / self._below[1]


def _angle(minus: Precise, plus: Precise) -> float:
    """theta from 1 - u and 1 + u."""
    sqrt = precise().sqrt
    return 2 * math.atan2(float(sqrt(minus)), float(sqrt(plus)))
