"""Identification: the inertia of the bodies, and coefficients of loads, from measured motion and forces.

    τ = Y_b(q, u, u') β + Σ_k D_k p_k + r(q, u, u')

is linear in the base parameters β and in coefficients p of loads, such as a damper's: least squares have one minimum.
Each force is weighed by the standard deviation of its errors, which a first fit with equal weights estimates:

    σ_j² = Σ e_j² / (N - n/n_u),      covariance of (β, p):  (Wᵀ Σ⁻¹ W)⁻¹

Of a machine with constraints, G u + g = 0, the multipliers do no work in its motions: with u = N v + ... and G N = 0
the equations are those of the independent speeds v, Nᵀ (Y_b β + ...) = Nᵀ τ. N is 1 in the rows of v.

Source: J. Swevers et al., Optimal robot excitation and identification (1997); M. Gautier, Dynamic identification of
robots with power model (1997).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import qr

from ..describe.system import System
from ..errors import ModelError, arguments_named, nearest
from ..model.assemble import assemble
from ..model.model import Model
from ..program.closed_loops import SINGULAR
from ..program.program import Program
from ..space.mass import MassProperties
from ..symbolic.inertia.base_parameters import BaseParameters, base_parameters
from .feasible_inertia import feasible_parameters, mass_properties

Array = NDArray[np.float64]
EPS = float(np.finfo(float).eps)
TRIED = 16
"""States whose independent speeds are tried for all."""


@dataclass(frozen=True, eq=False)
class Identification:
    """Base parameters and coefficients found from measurements, made by :func:`freebody.identify`.

    Attributes
    ----------
    values : dict of str to float
        Base parameters by the names of ``base``, then the coefficients of loads.
    errors : dict of str to float
        Standard error of each.
    covariance : ndarray (n, n)
        Covariance, in the order of ``values``.
    sigma : dict of str to float
        Standard deviation of the measured forces that are left unexplained, by speed [N, N m].
    residuals : ndarray (N, n_u)
        Measured forces minus those of the fit; of a machine with constraints, on the independent speeds, (N, n_v).
    condition : float
        Condition number of the equations with columns of equal length: how well the motion tells the unknowns apart.
    base : BaseParameters
        What each base parameter is made of.
    bodies : dict of str to MassProperties
        With ``feasible=True`` the mass properties of the bodies, about their origins in their axes; else empty.
    """

    values: dict[str, float]
    errors: dict[str, float]
    covariance: Array
    sigma: dict[str, float]
    residuals: Array
    condition: float
    base: BaseParameters
    bodies: dict[str, MassProperties]

    def __repr__(self) -> str:
        width = max(map(len, self.values))
        lines = [f"Identification from {len(self.residuals)} states, condition {self.condition:.3g}"]
        lines += [f"  {name:{width}} = {x:.6g} ± {self.errors[name]:.2g}" for name, x in self.values.items()]
        return "\n".join(lines)


@arguments_named
def identify(
    system: System | Model,
    q: ArrayLike,
    u: ArrayLike,
    udot: ArrayLike,
    forces: ArrayLike,
    *,
    unknowns: Sequence[str] = (),
    values: Mapping[str, float] | None = None,
    feasible: bool = False,
) -> Identification:
    """Return the inertia of the bodies, as far as the forces depend on it, from measured states and forces.

    Parameters
    ----------
    system : System or Model
        A machine; its motors may close loops, by joints and constraints.
    q, u, udot : array (N, n_q), (N, n_u), (N, n_u)
        Measured coordinates, speeds and accelerations.
    forces : array (N, n_u)
        Measured forces conjugate to the speeds [N, N m]: those of motors, beyond the loads of the system.
    unknowns : sequence of str, optional
        Parameters of loads that are to be found as well, such as the coefficient of a joint's damper. The forces must
        be linear in them.
    values : dict of str to float, optional
        Values of the other parameters: lengths, gravity, known loads.
    feasible : bool
        True for the best fit among masses and inertias that bodies can have. What the forces leave open is then
        nearest to the machine's own masses and inertias. The errors are those of the fit without this condition.

    Raises
    ------
    ModelError
        If a shape does not fit, a number is not finite, an unknown is no parameter, is part of a mass or of a place, or
        acts otherwise than linearly, if the motion does not tell unknowns apart or passes a position in which
        constraints depend on each other, or if ``feasible`` begins with a body that has no extent.

    Examples
    --------
    >>> import numpy as np, freebody as fb
    >>> s = fb.System("pendulum")
    >>> _ = s.parameters(m=2, L=0.5, c=0.1)
    >>> s.gravity = (0, -9.81, 0)
    >>> bob = s.body("bob", fb.MassProperties("m", ("L", 0, 0), ((0, 0, 0), (0, 0, 0), (0, 0, 0))))
    >>> pivot = s.hinge("pivot", s.ground, bob, axis="z")
    >>> _ = s.damper("friction", pivot, damping="c")
    >>> rng = np.random.default_rng(0)
    >>> q, u, udot = rng.uniform(-2, 2, (3, 50, 1))
    >>> tau = fb.compile(s).inverse_dynamics(q, u, udot)
    >>> found = fb.identify(s, q, u, udot, tau, unknowns=["c"])
    >>> {name: round(x, 9) for name, x in found.values.items()}
    {'bob.hx': 1.0, 'bob.hy': 0.0, 'bob.Izz': 0.5, 'c': 0.1}
    """
    model = system if isinstance(system, Model) else assemble(system)
    program, base = Program(model), base_parameters(model, values)
    x = [np.atleast_2d(np.asarray(a, float)) for a in (q, u, udot, forces)]
    _check(model, x)
    names = (*base.names, *unknowns)
    W, rest = _equations(model, program, base, x[:3], unknowns, dict(values or {}))
    measured, size, speeds = x[3] - rest, np.abs(x[3]).max(axis=0), model.speed_names
    if model.constraints:
        independent, N = _motions(program, x[0], x[1], values)
        W, measured = np.einsum("sji,sjk->sik", N, W), np.einsum("sji,sj->si", N, measured)
        size, speeds = size[independent], tuple(speeds[i] for i in independent)
    n = W.shape[-1]
    if measured.size <= n:
        raise ModelError(f"Expected more than {n} measured forces for {n} unknowns, got {measured.size}.")
    found, _, _ = _least_squares(W, measured, np.ones(len(speeds)), names)
    sigma = _deviation(measured - W @ found, n)
    weights = 1 / np.maximum(sigma, EPS * np.where(size > 0, size, 1))
    found, covariance, condition = _least_squares(W, measured, weights, names)
    bodies = {}
    if feasible:
        A = (W * weights[:, np.newaxis]).reshape(-1, n)
        theta, found = feasible_parameters(model, base, A, (measured * weights).reshape(-1), values)
        bodies = mass_properties(model, theta)
    residuals = measured - W @ found
    errors = np.sqrt(covariance.diagonal())
    return Identification(
        dict(zip(names, found.tolist(), strict=True)),
        dict(zip(names, errors.tolist(), strict=True)),
        covariance,
        dict(zip(speeds, _deviation(residuals, n).tolist(), strict=True)),
        residuals,
        condition,
        base,
        bodies,
    )


def _motions(
    program: Program, q: Array, u: Array, values: Mapping[str, float] | None
) -> tuple[list[int], Array]:
    """Return the independent speeds, and the motions N of all speeds per unit of each, (N, n_u, n_v).

    The independent speeds are the same in all states: those whose choice in one of :data:`TRIED` states leaves the
    conditions of the others best determined in all.
    """
    n_u, names = program.model.n_u, program.model.constraints
    G = program.conditions(q, u, values=values)[..., :n_u]
    singular = np.linalg.svd(G, compute_uv=False)
    ranks = (singular > SINGULAR * singular[:, :1]).sum(axis=1)
    rank = int(ranks.max())
    if (ranks < rank).any():
        row = int(np.argmax(ranks < rank))
        raise ModelError(
            f"Expected states in which the conditions {', '.join(names)} are as independent as in the others, got a "
            f"singular position in row {row}. Leave the row out."
        )
    best: tuple[float, list[int]] = (0.0, [])
    for k in np.linspace(0, len(G) - 1, TRIED).astype(int):
        dependent = sorted(qr(G[k], pivoting=True)[2][:rank].tolist())
        least = float(np.linalg.svd(G[:, :, dependent], compute_uv=False)[:, rank - 1].min())
        best = max(best, (least, dependent))
    dependent = best[1]
    independent = [i for i in range(n_u) if i not in dependent]
    N = np.zeros((len(G), n_u, len(independent)))
    N[:, independent] = np.eye(len(independent))
    N[:, dependent] = -np.linalg.pinv(G[:, :, dependent]) @ G[:, :, independent]
    return independent, N


def _check(model: Model, arrays: Sequence[Array]) -> None:
    sizes = {"q": model.n_q, "u": model.n_u, "udot": model.n_u, "forces": model.n_u}
    count = len(arrays[0])
    for (name, size), x in zip(sizes.items(), arrays, strict=True):
        if x.shape != (count, size):
            raise ModelError(f"Expected {name} of shape ({count}, {size}), got {x.shape}.")
        if not np.isfinite(x).all():
            row, column = map(int, np.argwhere(~np.isfinite(x))[0])
            raise ModelError(
                f"Expected finite numbers in {name}, got {x[row, column]} in row {row}. Leave the row out."
            )


def _equations(
    model: Model,
    program: Program,
    base: BaseParameters,
    motion: Sequence[Array],
    unknowns: Sequence[str],
    values: dict[str, float],
) -> tuple[Array, Array]:
    """Return the columns of the unknowns, (N, n_u, n), and the forces that depend on none of them, (N, n_u)."""
    for name in unknowns:
        if name not in model.defaults:
            raise ModelError(f"Unknown parameter '{name}'; {nearest(str(name), model.defaults)}")
    start = {**values, **dict.fromkeys(unknowns, 0.0)}
    other = {**values, **dict.fromkeys(unknowns, 1.0)}
    Y = program.regressor(*motion, values=start)
    theta = [np.array([*program.inertial_parameters(values=v).values()]) for v in (start, other)]
    if (theta[0] != theta[1]).any() or (program.regressor(*motion, values=other) != Y).any():
        raise ModelError(
            f"Expected coefficients of loads as unknowns, got {', '.join(unknowns)}, of which one is part of a mass or "
            "a place. Masses are found as base parameters."
        )
    rest = program.inverse_dynamics(*motion, values=start) - Y @ theta[0]
    columns = [Y[..., list(base.columns)]]
    for name in unknowns:
        slope = program.derivative("inverse_dynamics", name)
        D = slope(*motion, values=start)
        if np.abs(slope(*motion, values=other) - D).max() > 1e3 * EPS * np.abs(D).max():
            raise ModelError(
                f"Expected forces that are linear in '{name}', but their slope depends on the unknowns. Fit "
                "a motion: fb.fit."
            )
        columns.append(D[..., np.newaxis])
    return np.concatenate(columns, axis=-1), rest


def _least_squares(
    W: Array, measured: Array, weights: Array, names: Sequence[str]
) -> tuple[Array, Array, float]:
    """Return the solution, its covariance for errors of size 1 / weights, and the condition number."""
    A = (W * weights[:, np.newaxis]).reshape(-1, W.shape[-1])
    lengths = np.linalg.norm(A, axis=0)
    scaled = A / np.where(lengths > 0, lengths, 1)
    U, s, Vt = np.linalg.svd(scaled, full_matrices=False)
    if s[-1] <= len(A) * EPS * s[0]:
        alike = [name for name, v in zip(names, Vt[-1], strict=True) if abs(v) > 1e-3 * np.abs(Vt[-1]).max()]
        raise ModelError(
            f"Expected a motion that tells the unknowns apart, but in these states {', '.join(alike)} cannot be "
            "distinguished. Measure a motion in which all joints move, with other speeds and accelerations."
        )
    found = Vt.T @ (U.T @ (measured * weights).reshape(-1) / s) / lengths
    covariance = (Vt.T / s**2 @ Vt) / np.outer(lengths, lengths)
    return found, covariance, float(s[0] / s[-1])


def _deviation(residuals: Array, n: int) -> Array:
    """Return σ of each force, from the residuals of n unknowns that all forces share."""
    N, n_u = residuals.shape
    return np.sqrt((residuals**2).sum(axis=0) / (N - n / n_u))
