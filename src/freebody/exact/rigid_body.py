"""Any rigid body that turns with no torque: angular velocity, attitude, polhode, herpolhode in closed form.

Made by :func:`freebody.exact.torque_free`. The formulas::

    axes e_1, e_2, e_3 such that I_2 is the middle moment and H² lies between 2 T I_2 and 2 T I_3
    w = (a cn(tau), +-b sn(tau), c dn(tau)),    tau = p t + tau_0,    + when I_1 < I_3
    a² = A / (I_1 (I_3 - I_1)),  b² = A / (I_2 (I_3 - I_2)),  c² = B / (I_3 (I_3 - I_1)),
    A = 2 T I_3 - H²,  B = H² - 2 T I_1,  p² = (I_3 - I_2) B / (I_1 I_2 I_3),
    k² = (I_2 - I_1) A / ((I_3 - I_2) B),   1 - k² = (I_3 - I_1) (H² - 2 T I_2) / ((I_3 - I_2) B)

    attitude = Rz(psi) Rx(theta) Rz(phi) with z along H:  cos(theta) = I_3 w_3 / H,  tan(phi) = I_1 w_1 / (I_2 w_2),
    psi' = H (I_1 w_1² + I_2 w_2²) / (I_1² w_1² + I_2² w_2²)
         = H / I_2 + H (1/I_1 - 1/I_2) cn² / (1 + nu sn²),    nu = I_3 (I_2 - I_1) / (I_1 (I_3 - I_2)) > 0

The last line splits the integral of the third kind into a steady turn and pulses that vanish while the body
lingers near its middle axis. It is therefore as accurate on the separatrix (k² = 1; the pulse is then an
arctangent of a hyperbolic tangent) as away from it. Two equal moments give two steady turns, about H and about
the symmetry axis.

Sources: L. D. Landau, E. M. Lifshitz, *Mechanics*, 3rd ed., sections 33 and 37; E. T. Whittaker, *A Treatise
on the Analytical Dynamics of Particles and Rigid Bodies*, 4th ed., sections 69 to 71; H. Goldstein et al.,
*Classical Mechanics*, 3rd ed., section 5.6.

The file is longer than others: the three classes of motion share their formulas.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from ..errors import ModelError
from . import elliptic
from .elliptic import Angle, Clock, Jacobi, Phase, complete_pulse, precise, product, turning


@dataclass(frozen=True)
class Cones:
    """Regular precession of a torque-free symmetric body (section 6.8 of the chapter).

    Attributes
    ----------
    axis : int
        Principal axis (0, 1 or 2) that is the symmetry axis.
    rate : float
        Omega = (I_s - I_t) w_s / I_t: rate at which the angular velocity turns about the symmetry axis as
        seen from the body, positive by the right-hand rule [rad/s].
    alpha, beta : float
        Angle between the symmetry axis and H, and between it and the angular velocity [rad]:
        tan(alpha) = I_t / I_s tan(beta).
    body_cone, space_cone : float
        Half angles of the cone that the angular velocity draws in the body, about the symmetry axis, and in
        space, about H [rad]. The first rolls on the second without slip.
    precession_rate : float
        H / I_t: rate at which the symmetry axis turns about H [rad/s].
    """

    axis: int
    rate: float
    alpha: float
    beta: float
    body_cone: float
    space_cone: float
    precession_rate: float


@dataclass(frozen=True, repr=False)
class TorqueFreeMotion:
    """Motion of a rigid body about its mass centre with no torque; see :func:`freebody.exact.torque_free`.

    Attributes
    ----------
    kind : str
        ``"steady"`` (the angular velocity does not change), ``"symmetric"`` (two equal moments: regular
        precession), ``"triaxial"``, or ``"separatrix"`` (H² = 2 T I_2 exactly: the angular velocity approaches
        the middle axis for ever).
    moments : ndarray, shape (3,)
        Principal moments [kg m²].
    axes : ndarray, shape (3, 3)
        Columns: the principal axes in body axes, right-handed; the identity when the moments were given.
    w0 : ndarray, shape (3,)
        Angular velocity at t = 0, body axes [rad/s].
    energy : float
        Kinetic energy T [J].
    momentum : ndarray, shape (3,)
        Angular momentum H, inertial axes: constant [kg m²/s].
    period : float
        Period of the angular velocity as seen from the body: 4 K / p, or 2 pi / \\|Omega\\|; ``inf`` on the
        separatrix, ``nan`` for a steady rotation [s].
    precession_per_period : float
        Angle by which the body turns about H in one ``period``: the motion in space repeats only if it is a
        rational part of a turn [rad]. ``nan`` where ``period`` is not a finite number.
    modulus2, complementary : float
        k² and 1 - k² (0 and 1 where there are no elliptic functions).
    """

    kind: str
    moments: np.ndarray
    axes: np.ndarray
    w0: np.ndarray
    energy: float
    momentum: np.ndarray
    period: float
    precession_per_period: float
    modulus2: float
    complementary: float
    _solution: Any = field(compare=False)
    _start: np.ndarray = field(compare=False)

    def __repr__(self) -> str:
        moments = ", ".join(f"{value:g}" for value in self.moments)
        w0 = ", ".join(f"{value:g}" for value in self.w0)
        data = f"I = ({moments}) kg m², w0 = ({w0}) rad/s"
        return f"<torque-free {self.kind} motion: {data}, period {self.period:g} s>"

    def angular_velocity(self, t: Any) -> np.ndarray:
        """Angular velocity at times ``t``, shape (...): components in body axes, shape (..., 3) [rad/s]."""
        return self._solution.omega(np.asarray(t, dtype=float)) @ self.axes.T

    def quaternion(self, t: Any) -> np.ndarray:
        """Unit quaternion of :meth:`attitude`, scalar part first, shape (..., 4), continuous in t."""
        turn = self._solution.turn(np.asarray(t, dtype=float))
        if not np.array_equal(self.axes, np.eye(3)):
            to_body = elliptic.quaternion(self.axes)
            turn = product(product(to_body, turn), elliptic.conjugate(to_body))
        return product(self._start, turn)

    def attitude(self, t: Any) -> np.ndarray:
        """R_NB at times ``t``, shape (...): takes components in body axes to inertial axes, shape (..., 3, 3)."""
        return elliptic.matrix(self.quaternion(t))

    def herpolhode(self, t: Any) -> np.ndarray:
        """Angular velocity in inertial axes, shape (..., 3) [rad/s].

        Its tip draws the herpolhode in the invariable plane, which is normal to H at the distance
        :attr:`plane_distance` from the mass centre (Poinsot).
        """
        return np.einsum("...ij,...j->...i", self.attitude(t), self.angular_velocity(t))

    @property
    def plane_distance(self) -> float:
        """2 T / H: distance of the invariable plane from the mass centre, an angular velocity [rad/s]."""
        size = float(np.linalg.norm(self.momentum))
        return 2 * self.energy / size if size else 0.0

    @property
    def herpolhode_radii(self) -> tuple[float, float]:
        """Least and greatest distance of the herpolhode from the foot of H in the invariable plane [rad/s]."""
        H = self._solution.turning_points() * self.moments
        directions = H / np.maximum(np.linalg.norm(H, axis=1, keepdims=True), np.finfo(float).tiny)
        radii = np.linalg.norm(np.cross(directions, H / self.moments), axis=1)
        return float(radii.min()), float(radii.max())

    def polhode(self, points: int = 361) -> np.ndarray:
        """Closed curve that the angular velocity draws in the body, shape (points, 3) [rad/s].

        Body axes; the last point is the first. Points are equally spaced in the amplitude, not in time, so
        that a curve near the separatrix keeps its shape. On the separatrix itself: the half ellipse between
        the two rotations about the middle axis. A steady rotation gives the same point ``points`` times.

        Raises
        ------
        ModelError
            If ``points`` is less than 2.
        """
        if points < 2:
            raise ModelError(f"Expected at least 2 points of a polhode, got {points}.")
        return self._solution.curve(points) @ self.axes.T

    @property
    def cones(self) -> Cones:
        """Body cone and space cone of a body with two equal moments.

        Raises
        ------
        ModelError
            If the three moments differ.
        """
        axis = symmetry_axis(self.moments)
        if axis is None:
            moments = ", ".join(f"{value:.17g}" for value in self.moments)
            raise ModelError(
                f"Expected two equal principal moments for a body cone and a space cone, got ({moments}) kg m². The "
                "general body has polhode() and herpolhode(t) in their place; make two moments equal for cones."
            )
        w = (self.axes.T @ self.w0).tolist()
        I_t, I_s, w_s = float(self.moments[axis - 1]), float(self.moments[axis]), w[axis]
        w_t = math.hypot(w[axis - 1], w[axis - 2])
        alpha, beta = math.atan2(I_t * w_t, I_s * w_s), math.atan2(w_t, w_s)
        return Cones(
            axis=axis,
            rate=(I_s - I_t) * w_s / I_t,
            alpha=alpha,
            beta=beta,
            body_cone=min(beta, math.pi - beta),
            space_cone=abs(alpha - beta),
            precession_rate=math.hypot(I_t * w_t, I_s * w_s) / I_t,
        )


def symmetry_axis(moments: Any) -> int | None:
    """Principal axis about which two moments are equal (axis 2 when all three are), or None."""
    I1, I2, I3 = moments
    return 2 if I1 == I2 else 0 if I2 == I3 else 1 if I1 == I3 else None


def solution(moments: np.ndarray, w: np.ndarray) -> Steady | Symmetric | Triaxial:
    """Closed form for these moments and this angular velocity ``w`` at t = 0, along the principal axes.

    It gives the angular velocity along the principal axes and the turn from the attitude at t = 0.
    """
    I1, I2, I3 = (Fraction(float(value)) for value in moments)
    w1, w2, w3 = (Fraction(float(value)) for value in w)
    if (I3 - I2) * w2 * w3 == 0 and (I1 - I3) * w3 * w1 == 0 and (I2 - I1) * w1 * w2 == 0:
        return Steady(w)
    axis = symmetry_axis((I1, I2, I3))
    return Triaxial((I1, I2, I3), (w1, w2, w3)) if axis is None else Symmetric(moments, w, axis)


class Steady:
    """Rotation about a principal axis: the angular velocity is constant."""

    kind, modulus2, complementary = "steady", 0.0, 1.0
    period = precession_per_period = math.nan

    def __init__(self, w: np.ndarray) -> None:
        mp = precise()
        self._w = w
        size = mp.sqrt(mp.convert(sum((Fraction(float(value)) ** 2 for value in w), Fraction(0))))
        self._axis = w / (float(size) or 1.0)
        self._beat, self._rate = elliptic.turns(size)

    def omega(self, t: np.ndarray) -> np.ndarray:
        """Angular velocity along the principal axes, shape (..., 3) [rad/s]."""
        return np.broadcast_to(self._w, (*t.shape, 3)).copy()

    def turn(self, t: np.ndarray) -> np.ndarray:
        """Unit quaternion of the turn since t = 0, shape (..., 4)."""
        return _about(self._axis, self._beat, self._rate, t)

    def turning_points(self) -> np.ndarray:
        """Angular velocities at which the herpolhode can be nearest to H and farthest from it [rad/s]."""
        return self._w[None, :]

    def curve(self, points: int) -> np.ndarray:
        """Points of the polhode along the principal axes, shape (points, 3) [rad/s]."""
        return self.omega(np.zeros(points))


class Symmetric:
    """Regular precession: exp(H^ |H| t / I_t) exp(-e_s Omega t)."""

    kind, modulus2, complementary = "symmetric", 0.0, 1.0

    def __init__(self, moments: np.ndarray, w: np.ndarray, axis: int) -> None:
        mp = precise()
        I_t, I_s = (Fraction(float(moments[place])) for place in (axis - 1, axis))
        self._order = [(axis + 1) % 3, (axis + 2) % 3, axis]
        self._w = w[self._order]
        size2 = sum(
            ((Fraction(float(i)) * Fraction(float(v))) ** 2 for i, v in zip(moments, w, strict=True)),
            Fraction(0),
        )
        size = mp.sqrt(mp.convert(size2))
        precession = size / mp.convert(I_t)
        rate = mp.convert((I_s - I_t) * Fraction(float(w[axis])) / I_t)
        self._direction = moments * w / float(size)
        self._spin_axis = np.eye(3)[axis]
        self._about_H = elliptic.turns(precession)
        self._about_axis = elliptic.turns(rate)
        self.period = self._about_axis[0].interval
        self.precession_per_period = float(2 * mp.pi * precession / abs(rate))

    def omega(self, t: np.ndarray) -> np.ndarray:
        """Angular velocity along the principal axes, shape (..., 3) [rad/s]."""
        beat, rate = self._about_axis
        angle = rate * beat(t)[1]
        x, y, z = self._w
        w = np.empty((*t.shape, 3))
        w[..., self._order[0]] = x * np.cos(angle) - y * np.sin(angle)
        w[..., self._order[1]] = x * np.sin(angle) + y * np.cos(angle)
        w[..., self._order[2]] = z
        return w

    def turn(self, t: np.ndarray) -> np.ndarray:
        """Unit quaternion of the turn since t = 0, shape (..., 4)."""
        beat, rate = self._about_axis
        return product(_about(self._direction, *self._about_H, t), _about(self._spin_axis, beat, -rate, t))

    def turning_points(self) -> np.ndarray:
        """Angular velocities at which the herpolhode can be nearest to H and farthest from it [rad/s]."""
        return self.omega(np.zeros(1))

    def curve(self, points: int) -> np.ndarray:
        """Points of the polhode along the principal axes, shape (points, 3) [rad/s]."""
        return self.omega(np.linspace(0, self.period, points))


class Triaxial:
    """Motion of a body with three different moments: elliptic functions, hyperbolic ones on the separatrix."""

    def __init__(self, moments: tuple[Fraction, ...], w: tuple[Fraction, ...]) -> None:
        mp = precise()
        exact = mp.convert
        low, middle, high = sorted(range(3), key=lambda place: moments[place])
        # the sign of H² - 2 T I_2 decides which extreme axis the angular velocity circles
        excess = moments[high] * (moments[high] - moments[middle]) * w[high] ** 2
        excess -= moments[low] * (moments[middle] - moments[low]) * w[low] ** 2
        self._order = order = [low, middle, high] if excess >= 0 else [high, middle, low]
        I1, I2, I3 = (moments[i] for i in order)
        w1, w2, w3 = (w[i] for i in order)
        # columns: the axes e_1, e_2, e_3 of the formulas along the principal axes; w_1, w_3 >= 0 at t = 0
        sign1, sign3 = (1.0 if value >= 0 else -1.0 for value in (w1, w3))
        handed = 1.0 if order in ([0, 1, 2], [1, 2, 0], [2, 0, 1]) else -1.0
        sign2 = handed * sign1 * sign3
        self._signs = (sign1, sign2, sign3)
        frame = np.zeros((3, 3))
        frame[order, [0, 1, 2]] = self._signs
        self._frame = elliptic.quaternion(frame)

        A = I1 * (I3 - I1) * w1**2 + I2 * (I3 - I2) * w2**2
        B = I2 * (I2 - I1) * w2**2 + I3 * (I3 - I1) * w3**2
        m = exact((I2 - I1) * A / ((I3 - I2) * B))
        m1 = exact(abs((I3 - I1) * excess / ((I3 - I2) * B)))
        nu = exact(I3 * (I2 - I1) / (I1 * (I3 - I2)))
        rate = mp.sqrt(exact((I3 - I2) * B / (I1 * I2 * I3)))
        size = mp.sqrt(exact(sum(((i * v) ** 2 for i, v in zip(moments, w, strict=True)), Fraction(0))))

        self._direct = 1.0 if I3 > I1 else -1.0  # w_2 = + or - b sn
        functions = Jacobi(m, m1)
        s2, c2 = exact(I2 * (I3 - I2) * w2**2 / A), exact(I1 * (I3 - I1) * w1**2 / A)
        # F(phi | m) = s R_F(c², d², 1) (DLMF 19.25.5)
        start = mp.sqrt(s2) * mp.elliprf(c2, exact(I3 * (I3 - I1) * w3**2 / B), 1)
        ahead = float(w2) * sign2 * self._direct >= 0
        self._clock = Clock(functions, rate, start if ahead else -start)

        self._amplitudes = [
            float(mp.sqrt(exact(abs(square))))
            for square in (A / (I1 * (I3 - I1)), A / (I2 * (I3 - I2)), B / (I3 * (I3 - I1)))
        ]
        # (I_1 w_1, I_2 w_2) = sqrt(|A|) (lean_1 cn, +-lean_2 sn), which has a direction even where A is 0
        self._lean = [float(mp.sqrt(exact(abs(square)))) for square in (I1 / (I3 - I1), I2 / (I3 - I2))]
        self._small = float(mp.sqrt(exact(abs(A))) / size)
        self._upright = float(exact(I3) / size)

        separatrix = mp.isinf(functions.exact_K)
        gain = mp.zero if separatrix else complete_pulse(m1, nu)
        weight = size * exact(1 / I1 - 1 / I2) / rate
        factor, m1_, nu_ = float(weight), float(m1), float(nu)

        def local(phase: Phase, odd: bool) -> np.ndarray:
            return factor * (elliptic.pulse_from_quarter if odd else elliptic.pulse)(phase, m1_, nu_)

        self._psi = Angle(self._clock, size / exact(I2), weight * gain, local)
        self.kind = "separatrix" if separatrix else "triaxial"
        self.modulus2, self.complementary = functions.m, functions.m1
        self.period = math.inf if separatrix else float(4 * self._clock.exact_quarter)
        self.precession_per_period = math.nan if separatrix else float(4 * self._psi.exact_advance)
        self._at_start = elliptic.conjugate(self._euler(self._clock(0.0)))

    def omega(self, t: np.ndarray) -> np.ndarray:
        """Angular velocity along the principal axes, shape (..., 3) [rad/s]."""
        sn, cn, dn = self._clock.whole(self._clock(t))
        return self._arranged(cn, sn, dn)

    def _arranged(self, cn: Any, sn: Any, dn: Any) -> np.ndarray:
        """Angular velocity along the principal axes from the elliptic functions [rad/s]."""
        w = np.empty((*np.shape(sn), 3))
        values = (cn, self._direct * sn, dn)
        for place, sign, size, value in zip(self._order, self._signs, self._amplitudes, values, strict=True):
            w[..., place] = sign * size * value
        return w

    def turn(self, t: np.ndarray) -> np.ndarray:
        """Unit quaternion of the turn since t = 0, shape (..., 4)."""
        phase = self._clock(t)
        turn = product(self._at_start, product(turning(2, *self._psi.halves(phase)), self._euler(phase)))
        return product(product(self._frame, turn), elliptic.conjugate(self._frame))

    def _euler(self, phase: Phase) -> np.ndarray:
        """Rx(theta) Rz(phi), continuous in time: phi = pi/2 -+ the angle of (lean_1 cn, lean_2 sn)."""
        lean1, lean2 = self._lean
        k1 = self._clock.functions.modulus1
        s, c, d = phase.s, phase.c, phase.d
        opposite = np.where(phase.odd, lean1 * k1 * s, lean2 * s)
        adjacent = np.where(phase.odd, lean2 * c, lean1 * c)
        sine = self._small * np.hypot(opposite, adjacent) / np.where(phase.odd, d, 1.0)
        cosine = self._upright * self._amplitudes[2] * np.where(phase.odd, k1 / d, d)
        theta = np.arctan2(sine, cosine)
        # the quaternion is the same after two whole turns, and half turns of phi are exact: quarters modulo 8
        quarters = np.mod(phase.quarter, 8) * (math.pi / 2)
        angle = np.arctan2(opposite, adjacent)
        phi = (np.full_like(theta, math.pi / 2), -self._direct * quarters, -self._direct * angle)
        return product(turning(0, theta), turning(2, *phi))

    def turning_points(self) -> np.ndarray:
        """Angular velocities at which the herpolhode can be nearest to H and farthest from it [rad/s]."""
        k1 = self._clock.functions.modulus1
        return self._arranged(np.array([1.0, 0.0]), np.array([0.0, 1.0]), np.array([1.0, k1]))

    def curve(self, points: int) -> np.ndarray:
        """Points of the polhode along the principal axes, shape (points, 3) [rad/s]."""
        functions = self._clock.functions
        ends = (-math.pi / 2, math.pi / 2) if self.kind == "separatrix" else (0.0, 2 * math.pi)
        amplitude = np.linspace(*ends, points)
        sn, cn = np.sin(amplitude), np.cos(amplitude)
        return self._arranged(cn, sn, np.sqrt(functions.m1 + functions.m * cn**2))


def _about(axis: np.ndarray, beat: elliptic.Beat, rate: float, t: np.ndarray) -> np.ndarray:
    """Quaternion of a turn at a constant rate about a fixed axis; whole turns change only its sign."""
    count, rest = beat(t)
    half = rate * rest / 2
    sign = np.where(np.mod(count, 2) == 1, -1.0, 1.0)
    return np.concatenate(
        [(sign * np.cos(half))[..., None], (sign * np.sin(half))[..., None] * axis], axis=-1
    )
