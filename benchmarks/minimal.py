"""Reference problems in their own minimal coordinates: equations written by hand, no code of freebody takes part.

Each function returns what the library's motion is judged by, at the times asked for.
"""

from __future__ import annotations

from typing import Any

import numpy as np

G = 9.81


# -- N four-bars -------------------------------------------------------------------------------------


def four_bars(n: int, t: Any) -> np.ndarray:
    """Angle of the cranks of ``n`` parallelograms [rad]: a pendulum that turns over.

    ½ ((n + 1)/3 + n) m L² φ'² + ((n + 1)/2 + n) m g L sin φ is constant. With a = angle from the lowest position, k the
    modulus and w² = rate²: a'² = a'₀² + 2 w² (cos a - cos a₀), a = 2 am(w t / k + u₀), k² = 4 w²/(a'² at the bottom).
    """
    from scipy.special import ellipj, ellipk

    inertia, moment = (n + 1) / 3 + n, (n + 1) / 2 + n
    rate2 = moment * G / inertia
    lowest2 = 1.0 + 4 * rate2  # a'² at the bottom: from a' = -1 upright
    m = 4 * rate2 / lowest2
    # upright, a = π, is half a turn: am = K; the crank turns clockwise, φ = π/2 - (a - π)
    amplitude = ellipj(0.5 * np.sqrt(lowest2) * np.asarray(t) + ellipk(m), m)[3]
    return np.pi / 2 - (2 * amplitude - np.pi)


# -- Bricard's mechanism -----------------------------------------------------------------------------

HINGES = "yzxyz"
RODS = np.array([[1, 0, 0], [0, -1, 0], [0, 0, 1], [-1, 0, 0], [0, 1, 0]], dtype=float)
"""Along each rod at the start, from its hinge in HINGES to the next; the sixth hinge, about x, closes on the ground."""


def bricard_angles(w: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Angles of the odd and of the even hinges, and their derivatives, along the closed curve of configurations.

    With tan(π/4 - q/2) = x and y for the two: closure is (1 + x²)(1 + y²) = 4, that is x = √3 sin w,
    y = √3 cos w / √(1 + 3 sin² w).
    """
    a, c, s = 1 + 3 * np.sin(w) ** 2, np.sqrt(3) * np.cos(w), np.sqrt(3) * np.sin(w)
    angles = np.pi / 2 - 2 * np.arctan(s), np.pi / 2 - 2 * np.arctan(c / np.sqrt(a))
    return angles, (-2 * c / a, 2 * s / np.sqrt(a))


def bricard_shape(w: float) -> tuple[float, float, np.ndarray, np.ndarray]:
    """I(w) and V(w) of T = ½ I w'², ends of the rods (6, 3), axes of the last rod (3, 3).

    Rods of 1 m, 0.1 m square, 1 kg.
    """
    angles, rates = bricard_angles(w)
    inertia = potential = 0.0
    axes, turning = np.eye(3), np.zeros(3)
    ends, speed = [np.zeros(3)], np.zeros(3)
    for i, name in enumerate(HINGES):
        k = "xyz".index(name)
        turning = turning + rates[i % 2] * axes[:, k]
        turn, (c, s) = np.eye(3), (np.cos(angles[i % 2]), np.sin(angles[i % 2]))
        turn[np.ix_([k - 2, k - 1], [k - 2, k - 1])] = [[c, -s], [s, c]]
        axes = axes @ turn
        rod = axes @ RODS[i]
        center = speed + np.cross(turning, rod / 2)
        inertia += center @ center + 1.01 / 12 * turning @ turning + (0.02 - 1.01) / 12 * (turning @ rod) ** 2
        potential += G * (ends[-1] + rod / 2)[1]
        speed = speed + np.cross(turning, rod)
        ends.append(ends[-1] + rod)
    return inertia, potential, np.array(ends), axes


def bricard(t: Any) -> np.ndarray:
    """Place of the joint between the third and the fourth rod [m], (times, 3), let go from rest as the edges of a cube.

    I w'' + ½ I' w'² + V' = 0. I and V are periodic and analytic (nearest singularity 0.55 off the real axis): the
    derivatives come from their Fourier series.
    """
    from scipy.integrate import solve_ivp

    n = 256
    values = np.array([bricard_shape(w)[:2] for w in 2 * np.pi * np.arange(n) / n])
    series = np.fft.rfft(values, axis=0).T / n
    series[:, 1:] *= 2
    k = np.arange(series.shape[1])

    def rates(_: float, y: np.ndarray) -> list[float]:
        wave = np.exp(1j * k * y[0])
        inertia, _ = (series @ wave).real
        d_inertia, d_potential = (series @ (1j * k * wave)).real
        return [y[1], -(d_potential + d_inertia * y[1] ** 2 / 2) / inertia]

    t = np.asarray(t, dtype=float)
    start = [np.arcsin(1 / np.sqrt(3)), 0.0]
    found = solve_ivp(rates, (0.0, t[-1]), start, "DOP853", t_eval=t, rtol=1e-13, atol=1e-14)
    return np.array([bricard_shape(w)[2][3] for w in found.y[0]])


# -- flyball governor --------------------------------------------------------------------------------


def flyball(t: Any) -> np.ndarray:
    """Height of the slider [m].

    The two halves move alike and the moment of momentum p about the shaft is constant. With α the angle of the rods
    below the horizontal, s the height of the slider, d the length of a spring, J(α) the moment of inertia about the
    shaft: 2 K α'' = ½ (p/J)² J' + 2 (m_ball + m_rod/2) g cos α - 2 F ∂d/∂α, m s'' = -m g - 2 F ∂d/∂s.
    """
    from scipy.integrate import solve_ivp

    bar, ball, slider, a = 0.3, 5.0, 3.0, 0.05
    across, along = bar * (1 + 1e-4) / 12, bar * 2e-4 / 12

    def J(c: float, s: float) -> float:
        rod = bar * (a + c / 2) ** 2 + across * c**2 + along * s**2
        return along + slider * 0.02 / 12 + 2 * (ball * (a + c) ** 2 + rod)

    def rates(_: float, y: np.ndarray) -> list[float]:
        c, s = np.cos(y[0]), np.sin(y[0])
        dJ = -2 * s * (2 * ball * (a + c) + bar * (a + c / 2) + 2 * (across - along) * c)
        x, z = c / 2, 1 - s / 2 - y[1]
        d = np.sqrt(x**2 + z**2)
        d_alpha, d_s = -(x * s + z * c) / (2 * d), -z / d
        F = 8e5 * (d - 0.5) + 4e4 * (d_alpha * y[2] + d_s * y[3])
        turned = (p / J(c, s)) ** 2 * dJ / 2 + 2 * (ball + bar / 2) * G * c - 2 * F * d_alpha
        return [y[2], y[3], turned / (2 * (ball + bar / 4 + across)), -G - 2 * F * d_s / slider]

    start = [np.pi / 6, 0.5, 0.0, 0.0]
    p = 2 * np.pi * J(np.cos(start[0]), np.sin(start[0]))
    t = np.asarray(t, dtype=float)
    return solve_ivp(rates, (0.0, t[-1]), start, "Radau", t_eval=t, rtol=1e-12, atol=1e-13).y[1]


# -- crank-rocker of `precision` ---------------------------------------------------------------------


def crank_rocker() -> tuple[list[Any], list[Any]]:
    """SymPy symbols (α, φ, ψ, w) of the angles of crank, coupler and rocker and the crank's speed, and their rates.

    The loop a e(α) + b e(φ) = d + c e(ψ) gives φ' = K_φ w, ψ' = K_ψ w; T = ½ J w², and J w' + ½ w² dJ/dα + dV/dα = 0
    with derivatives along the loop. Bars of 4 kg/m.
    """
    import sympy

    y = alpha, phi, psi, w = sympy.symbols("alpha phi psi w")
    sin, cos = sympy.sin, sympy.cos
    a, b, c = sympy.Float("0.1", 17), sympy.Float("0.3", 17), sympy.Float("0.2", 17)
    K_phi = a * sin(psi - alpha) / (b * sin(phi - psi))
    K_psi = a * sin(phi - alpha) / (c * sin(phi - psi))
    coupler = a**2 + a * b * cos(alpha - phi) * K_phi + b**2 * K_phi**2 / 3
    J = 4 * (a**3 / 3 + b * coupler + c**3 * K_psi**2 / 3)
    V = (
        4
        * sympy.Float("9.81", 17)
        * (a**2 * sin(alpha) / 2 + b * (a * sin(alpha) + b * sin(phi) / 2) + c**2 * sin(psi) / 2)
    )

    def along(f: Any) -> Any:
        return f.diff(alpha) + f.diff(phi) * K_phi + f.diff(psi) * K_psi

    return list(y), [w, K_phi * w, K_psi * w, -(w**2 * along(J) / 2 + along(V)) / J]
