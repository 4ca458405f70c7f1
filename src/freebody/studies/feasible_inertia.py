"""Inertia that bodies can have: the best fit to measured forces whose pseudo-inertia matrices are positive definite.

A body of positive density has the pseudo-inertia

    P = ∫ (r, 1) (r, 1)ᵀ dm = [[½ tr(I) 1 - I, h], [hᵀ, m]] > 0

about its origin, and every such P is the inertia of a body. Of all of them the least

    f(y) + μ Σ_i D(P_i),      f = ½ |y - y*|²,      D(P) = tr(P₀⁻¹ P) - ln det(P₀⁻¹ P) - 4 >= 0

is the minimum of f as μ → 0, and what the forces leave open is nearest to P₀, the machine's own inertia, in the
divergence D. With the weighted equations A = Q R of coefficients p of loads and of base parameters β, in this order,
y = R_ββ β are the base parameters in the units of their errors, and p, on which no D depends, is the best for them. The
inertial parameters are θ = (β - K_z z, z), with z free.

D is self-concordant: Newton's method with the best length of each step converges from any P > 0, and f is then within
4 n μ of its least value, for n bodies.

Sources: P. Wensing, S. Kim, J.-J. Slotine, Linear matrix inequalities for physically consistent inertial parameter
identification (2018); T. Lee, P. Wensing, F. Park, Geometric robot dynamic identification (2020); Y. Nesterov,
Lectures on convex optimization (2018), §5.3.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from ..dynamics.regressor import PARAMETERS, inertial_parameters
from ..dynamics.state import float_state
from ..errors import ModelError
from ..model.model import Model
from ..space.mass import MassProperties
from ..symbolic.inertia.base_parameters import BaseParameters

Array = NDArray[np.float64]
EPS = float(np.finfo(float).eps)
GAP = 1e-6
"""Distance of f from its least value, in squares of standard errors."""
ROUND_OFF = 2**16 * EPS
"""Round-off of y, relative to its largest, with room for the convergence of Newton's method."""
FASTER = 2
"""Quotient of the μ of two stages."""
DONE = 1e-9
"""Newton decrement, relative to that of a unit step, at which a stage ends."""
STEPS = 200
"""Most Newton steps of a stage; a few are usual."""


def _basis() -> Array:
    """Return P of each of the ten parameters alone, (10, 4, 4)."""
    E = np.zeros((len(PARAMETERS), 4, 4))
    E[0, 3, 3] = 1
    for k in range(3):
        E[1 + k, k, 3] = E[1 + k, 3, k] = 1
    for place, (j, k) in zip(range(4, 10), ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)), strict=True):
        inertia = np.zeros((3, 3))
        inertia[j, k] = inertia[k, j] = 1
        E[place, :3, :3] = np.trace(inertia) / 2 * np.eye(3) - inertia
    return E


BASIS = _basis()


def feasible_parameters(
    model: Model, base: BaseParameters, A: Array, b: Array, values: Mapping[str, float] | None
) -> tuple[Array, Array]:
    """Return θ, (bodies, 10), and (β, p) of the least |A (β, p) - b|² with P > 0 for all bodies.

    Raises
    ------
    ModelError
        A body of the machine without extent, so that there is no inertia to begin with.
    """
    start = np.array(inertial_parameters(model, float_state(model, [0] * model.n_q, values=values)), float)
    prior = _prior(model, start)
    K = base.matrix(values)
    columns = list(base.columns)
    others = [j for j in range(K.shape[1]) if j not in set(columns)]
    loads = A.shape[1] - len(columns)
    Q, R = np.linalg.qr(np.roll(A, loads, axis=1))
    wanted = Q.T @ b
    target, own = wanted[loads:], R[loads:, loads:]
    # θ = J_y y + J_z z
    J_y, J_z = np.zeros((len(start), len(target))), np.zeros((len(start), len(others)))
    J_y[columns] = np.linalg.inv(own)
    J_z[columns], J_z[others, range(len(others))] = -K[:, others], 1
    y, z = own @ K @ start, start[others]
    first = ((y - target) ** 2).sum() / 2
    # below it, round-off of y would be more than Newton's method can see
    least = max(GAP, float(ROUND_OFF * np.abs(target).max()) ** 2) / len(start)
    mu = max(first / len(start), least)
    while True:
        y, z = _stage(prior, mu, (J_y, J_z), target, (y, z))
        if mu <= least:
            found = np.linalg.solve(R, np.concatenate([wanted[:loads], y]))
            return (J_y @ y + J_z @ z).reshape(-1, 10), np.roll(found, -loads)
        mu = max(mu / FASTER, least)


def _prior(model: Model, theta: Array) -> Array:
    """Return P₀⁻¹ of the machine's own inertia, (bodies, 4, 4); bodies without extent are refused."""
    P = _pseudo_inertias(theta)
    for body, one in zip(model.bodies, P, strict=True):
        scale = np.sqrt(np.maximum(one.diagonal(), 0))
        if not (scale > 0).all() or np.linalg.eigvalsh(one / np.outer(scale, scale)).min() <= 16 * EPS:
            raise ModelError(
                f"Expected a mass and an inertia of body '{body}' that a body with extent along three axes has, with "
                "which feasible=True begins, got a point, a line, a plate, or what no body can have. Give it an "
                "estimate, such as fb.sphere(m, R)."
            )
    return np.array(np.linalg.inv(P), float)


def _pseudo_inertias(theta: Array) -> Array:
    """Return P of each body."""
    return np.einsum("bk,kij->bij", theta.reshape(-1, len(PARAMETERS)), BASIS)


def _divergence(prior: Array, theta: Array) -> tuple[Array, Array]:
    """Return C and r, so that Cᵀ C is the Hessian of Σ D at θ and Cᵀ r its gradient.

    With P = L Lᵀ, dD = tr((Lᵀ P₀⁻¹ L - 1) dX) and d²D = tr(dX dX) of dX = L⁻¹ dP L⁻ᵀ.
    """
    L = np.linalg.cholesky(_pseudo_inertias(theta))
    inverse = np.linalg.inv(L)
    X = np.einsum("bij,kjl,bml->bimk", inverse, BASIS, inverse).reshape(len(L), -1, len(PARAMETERS))
    C = np.zeros((X.shape[0] * X.shape[1], len(theta)))
    for i, block in enumerate(X):
        C[len(block) * i : len(block) * (i + 1), 10 * i : 10 * i + 10] = block
    return C, (L.transpose(0, 2, 1) @ prior @ L - np.eye(4)).reshape(-1)


def _stage(
    prior: Array, mu: float, J: tuple[Array, Array], target: Array, start: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Return the least value of f/μ + Σ D, by Newton steps from a feasible start.

    A step is a problem of least squares, whose condition is the root of that of the Hessian:
    |(y + dy - y*)/√μ|² + |C (J_y dy + J_z dz) + r|².
    """
    (J_y, J_z), (y, z) = J, start
    weight, best = 1 / np.sqrt(mu), np.inf
    for _ in range(STEPS):
        C, r = _divergence(prior, J_y @ y + J_z @ z)
        A = np.block([[weight * np.eye(len(y)), np.zeros((len(y), len(z)))], [C @ J_y, C @ J_z]])
        scale = 1 / np.linalg.norm(A, axis=0)
        Q, R = np.linalg.qr(A * scale)
        along = Q.T @ -np.concatenate([weight * (y - target), r])
        step = scale * np.linalg.solve(R, along)
        decrement = float(np.linalg.norm(along))
        if decrement < DONE or (decrement >= best and decrement < np.sqrt(DONE)):  # round-off
            return y, z
        best = min(best, decrement)
        d_y, d_z = step[: len(y)], step[len(y) :]
        dX = (C @ (J_y @ d_y + J_z @ d_z)).reshape(-1, 4, 4)
        quadratic = (
            weight**2 * d_y @ (y - target) + np.trace(dX + r.reshape(-1, 4, 4) @ dX, axis1=1, axis2=2).sum()
        )
        length = 1.0
        if decrement > 1 / 4:  # a full step is safe below
            length = _length(
                np.linalg.eigvalsh(dX).reshape(-1), float(quadratic), float(weight**2 * d_y @ d_y)
            )
        y, z = y + length * d_y, z + length * d_z
    raise ModelError(
        f"Feasible inertia was not found in {STEPS} steps. Fit without feasible=True, and see which body has none."
    )


def _length(e: Array, a: float, b: float) -> float:
    """Return the length t of a step of the least ½ b t² + a t - Σ ln(1 + e t), which keeps 1 + e t > 0."""

    def slope(t: float) -> float:
        return float(b * t + a - (e / (1 + e * t)).sum())

    low, high = 0.0, 1.0
    last = -1 / e.min() if e.min() < 0 else np.inf
    while high < last and slope(high) < 0:
        low, high = high, 2 * high
    if high >= last:  # the slope grows to infinity there
        gap = (last - low) / 2
        while slope(last - gap) < 0:
            low, gap = last - gap, gap / 2
        high = last - gap
    return float(brentq(slope, low, high, rtol=1 / 2**20))


def mass_properties(model: Model, theta: Array) -> dict[str, MassProperties]:
    """Return the mass properties of the bodies from their ten parameters about the origin."""
    result: dict[str, Any] = {}
    for body, (m, *rest) in zip(model.bodies, theta.tolist(), strict=True):
        xx, xy, yy, xz, yz, zz = rest[3:]
        c = np.array(rest[:3]) / m
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) - m * (
            c @ c * np.eye(3) - np.outer(c, c)
        )
        rows: Any = tuple(map(tuple, inertia.tolist()))
        result[body] = MassProperties.as_given(m, tuple(c.tolist()), rows)
    return result
