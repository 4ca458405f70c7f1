"""Bodies that slide, tip and roll on floors and walls: forces and thresholds from force balances written out by hand.

x to the right, y up, moments and angles counter-clockwise positive. At every contact N ≥ 0 pushes along the normal
of the support and |T| ≤ μ N. Rolling disks are uniform, I_C = m R²/2.

Sources: Examples 6.1, 6.3, 6.4 and Problems 6.1 to 6.3 of the chapter (with its figures as interpreted in the
project's specification); every formula below is derived here, not copied.
"""

from __future__ import annotations

from dataclasses import dataclass

from .elementary import arctan, cos, exp, log, sin, sqrt, symbolic, tan


@dataclass(frozen=True)
class SlidingBody:
    """Answers of Example 6.1 under the force and on the verge of tipping.

    Acceleration [m/s²] and normal forces at the rear foot A and the front foot B [N] under the force; the force that
    brings the body to the verge of tipping [N], and the acceleration and the normal force at B there.
    """

    acceleration: float
    normal_A: float
    normal_B: float
    force_tip: float
    acceleration_tip: float
    normal_tip: float


def sliding_body(
    m: float, L: float, H: float, D: float, mu: float, beta: float, F: float, g: float = 9.81
) -> SlidingBody:
    """Motion of a box on two feet that slides with friction, pulled at its upper rear corner at the angle β.

    With S = N_A + N_B = m g - F sin β,

        m a = F cos β - μ S,      (N_B - N_A) L/2 = μ S (H/2 + D) + F (L sin β + H cos β)/2  (about C),

    and N_A = 0 where (L/2 - μ (H/2 + D)) S = F (L sin β + H cos β)/2.

    Parameters
    ----------
    m, L, H, D, mu, beta, F, g : float
        Mass [kg]; length, height, length of the feet [m]; friction; angle [rad]; force [N]; gravity [m/s²].

    Returns
    -------
    SlidingBody

    Examples
    --------
    >>> round(float(sliding_body(50, 1.2, 0.8, 0.15, 0.0, 0.0, 100).acceleration), 12)
    2.0
    """
    lift = (L * sin(beta) + H * cos(beta)) / 2

    def state(force: float) -> tuple[float, float, float]:
        S = m * g - force * sin(beta)
        difference = 2 / L * (mu * S * (H / 2 + D) + force * lift)
        return (force * cos(beta) - mu * S) / m, (S - difference) / 2, (S + difference) / 2

    spare = L / 2 - mu * (H / 2 + D)
    tip = spare * m * g / (lift + spare * sin(beta))
    a, N_A, N_B = state(F)
    a_tip, _, N_tip = state(tip)
    return SlidingBody(a, N_A, N_B, tip, a_tip, N_tip)


def tipping_body(
    m: float, L: float, H: float, D: float, mu: float, beta: float, F: float, g: float = 9.81
) -> tuple[float, float]:
    """Acceleration of the mass centre and N_B of the body of `sliding_body` as it begins to tip about its front foot.

    The foot B stays on the floor. With the angular acceleration α and y'' = -α L/2:

        m a = F cos β - μ N,   -m α L/2 = N - m g + F sin β,
        m (L² + H²) α/12 = N (L/2 - μ (H/2 + D)) - F (L sin β + H cos β)/2.
    """
    spare, lift = L / 2 - mu * (H / 2 + D), (L * sin(beta) + H * cos(beta)) / 2
    inertia = m * (L**2 + H**2) / 12
    alpha = ((m * g - F * sin(beta)) * spare - F * lift) / (inertia + m * L / 2 * spare)
    N = m * g - F * sin(beta) - m * alpha * L / 2
    return (F * cos(beta) - mu * N) / m, N


@dataclass(frozen=True)
class PulledDisk:
    """Answers of Example 6.3.

    ``rolls`` is true if the disk rolls without slip; then acceleration [m/s²], angular acceleration [rad/s²], friction
    on the disk, positive to the left [N], and the largest force without slip [N].
    """

    rolls: bool
    acceleration: float
    alpha: float
    friction: float
    force_limit: float


def pulled_disk(
    m: float, R: float, h: float, mu: float, F: float, g: float = 9.81, rolls: bool | None = None
) -> PulledDisk:
    """Motion of a disk on a floor that a force at the height h pulls to the right from rest.

    m a = F - H,   (m R²/2) α = -F (h - R) - H R.   Rolling, a = -R α:   a = 2 F h/(3 m R),  H = F (1 - 2 h/(3 R)),
    which |H| ≤ μ m g allows up to F = μ m g/|1 - 2 h/(3 R)|; above this force, |H| = μ m g against the slip.

    Parameters
    ----------
    m, R, h, mu, F, g : float
        Mass [kg], radius, height of the force [m], friction, force [N], gravity [m/s²].
    rolls : bool, optional
        True if the disk rolls, needed if the parameters are symbols (h < 3 R/2 is then assumed); by default it
        follows from the parameters.

    Examples
    --------
    >>> pulled_disk(10, 2, 3, 0.2, 30).friction
    0.0
    """
    share = 1 - 2 * h / (3 * R)
    if rolls is None:
        limit = mu * m * g / abs(share) if share else float("inf")
        rolls, to_left = limit >= F, share > 0
    else:
        limit, to_left = mu * m * g / share, True
    friction = F * share if rolls else (mu * m * g if to_left else -mu * m * g)
    alpha = -2 * (F * (h - R) + friction * R) / (m * R**2)
    return PulledDisk(rolls, (F - friction) / m, alpha, friction, limit)


@dataclass(frozen=True)
class RollingDown:
    """Answers of Example 6.4.

    Speed [m/s], angular velocity [rad/s], acceleration down the slope [m/s²], normal force and friction up the slope
    [N].
    """

    speed: float
    omega: float
    acceleration: float
    normal: float
    friction: float


def rolling_down(m: float, R: float, H: float, slope: float, g: float = 9.81) -> RollingDown:
    """Motion of a disk that rolls from rest down a slope, to the right, until its centre is lower by H.

    3/4 m v² = m g H;   a = 2/3 g sin β,  N = m g cos β,  T = m g sin β/3 up the slope.

    Examples
    --------
    >>> round(float(rolling_down(5, 0.25, 3, 0.5, g=9.0).speed), 12)
    6.0
    """
    v = sqrt(4 * g * H / 3)
    return RollingDown(v, -v / R, 2 * g * sin(slope) / 3, m * g * cos(slope), m * g * sin(slope) / 3)


@dataclass(frozen=True)
class LeaningBoard:
    """Answers of Problem 6.1.

    Accelerations at which the board slips and tips, the largest acceleration without either [m/s²], and the angle from
    the floor at which the largest is reached [rad].
    """

    slide: float
    tip: float
    largest: float
    angle: float


def leaning_board(mu: float, beta: float, g: float = 9.81) -> LeaningBoard:
    """Limits of a board on the floor of a truck that leans forward against the smooth wall of its cab.

    β is the angle of the board from the floor. About C with N = m g at the floor: T + N_w = m g cot β, and along x:
    T - N_w = m a. The board slips at T = μ m g and tips at N_w = 0:

        a_slide = 2 μ g - g cot β,    a_tip = g cot β,    equal, and then largest, where cot β = μ.

    Examples
    --------
    >>> leaning_board(0.5, arctan(2), g=10.0).largest
    5.0
    """
    cot = 1 / tan(beta)
    return LeaningBoard(2 * mu * g - g * cot, g * cot, mu * g, arctan(1 / mu))


def sliding_board(length: float, mu: float, beta: float, a: float, g: float = 9.81) -> float:
    """Angular acceleration of the board of `leaning_board` as its lower end begins to slip backwards, positive upwards.

    Both ends stay on floor and wall: with α the angular acceleration, x_C'' = a + (l/2) α sin β and
    y_C'' = (l/2) α cos β from rest, N = m (g + y_C''), N_w = μ N - m x_C'', and about C

        m l² α/12 = (l/2) (N (μ sin β - cos β) + N_w sin β).
    """
    s, c = sin(beta), cos(beta)
    return (g * (2 * mu * s - c) - a * s) / (length / 6 + length / 2 * (s**2 + c**2 - 2 * mu * s * c))


def stribeck_time(v: float, mu: float, mu_s: float, v_s: float, g: float = 9.81) -> float:
    """Return the time in which a block with the speed v comes to rest on a floor with Stribeck's friction.

        dv/dt = -g (μ + Δ e^(-v/v_s)),      Δ = μ_s - μ

        t = (v + v_s ln((μ + Δ e^(-v/v_s))/(μ + Δ)))/(μ g)

    since d/dv of the bracket is μ/(μ + Δ e^(-v/v_s)).

    Examples
    --------
    >>> float(stribeck_time(9.0, 0.5, 0.5, 1.0, g=9.0))
    2.0
    """
    fall = mu_s - mu
    return (v + v_s * log((mu + fall * exp(-v / v_s)) / (mu + fall))) / (mu * g)


@dataclass(frozen=True)
class BrakingCar:
    """Answers of Problem 6.2: coefficient of friction, normal force and friction of each axle [N]."""

    mu: float
    normal_front: float
    normal_rear: float
    friction_front: float
    friction_rear: float


def braking_car(m: float, lf: float, lr: float, h: float, a: float, g: float = 9.81) -> BrakingCar:
    """Forces on a car that slides on four locked wheels with the deceleration a.

    μ = a/g;   about the rear contact   N_f (l_f + l_r) = m g l_r + m a h.

    Examples
    --------
    >>> braking_car(1000, 1, 1, 0.5, 5, g=10.0).normal_front
    6250.0
    """
    front = m * (g * lr + a * h) / (lf + lr)
    rear = m * (g * lf - a * h) / (lf + lr)
    return BrakingCar(a / g, front, rear, a / g * front, a / g * rear)


@dataclass(frozen=True)
class MonorailCar:
    """Answers of Problem 6.3.

    Largest acceleration with the front or the rear wheel driven [m/s²], the better of the two wheels, and the loads of
    both wheels with it [N].
    """

    front_driven: float
    rear_driven: float
    better: str
    normal_front: float
    normal_rear: float


def monorail_car(m: float, l: float, h: float, mu: float, g: float = 9.81) -> MonorailCar:  # noqa: E741
    """Largest acceleration of a car that hangs from two wheels on a cable, one of them driven; C is h below the cable.

    About C: (N_f - N_r) l/2 = h T with T = m a at the cable, so that hanging loads the front wheel. T = μ N of the
    driven wheel gives  a = μ g/(2 (1 ∓ μ h/l)).

    Examples
    --------
    >>> monorail_car(1, 2, 1, 0.5, g=9.0).front_driven
    3.0
    """
    front, rear = (mu * g / 2 / (1 - side * mu * h / l) for side in (1, -1))
    # the front wheel has the larger load if C hangs below the cable, as is assumed for symbols
    best = front if symbolic(mu) else max(front, rear)
    shift = m * best * h / l
    return MonorailCar(
        front, rear, "front" if best is front else "rear", m * g / 2 + shift, m * g / 2 - shift
    )


def friction_circle(mu: float, radius: float) -> float:
    """Return the radius r sin φ, tan φ = μ, of the circle of friction of a pin [m].

    A pin that turns in its hole is touched along a line, by N along the radius and μ N across it. Their sum passes the
    axis at r μ/√(1 + μ²); a pin on which it passes nearer does not turn.

    Source: Beer & Johnston, Vector Mechanics for Engineers: Statics, section 8.6.

    Examples
    --------
    >>> print(friction_circle(0.75, 0.02))
    0.012
    """
    return radius * mu / sqrt(1 + mu * mu)


def jamming_arm(mu: float, length: float) -> float:
    """Return the distance from the axis of a guide at which a force along it does not move it any more [m].

    A force F at the distance a presses two places, a ``length`` L apart, by N = F a/L each, so that 2 μ N < F is
    a < L/(2 μ), whatever F is.

    Examples
    --------
    >>> jamming_arm(0.25, 0.5)
    1.0
    """
    return length / (2 * mu)
