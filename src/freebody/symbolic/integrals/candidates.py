"""Quantities that may be conserved, each with the multipliers for a proof.

    energy            T₂ - T₀ + V                        μ_j = u_j
    momentum          Σ ξ_j ∂T/∂u_j                      μ_j = ξ_j, components of a rigid motion of the whole machine

For particles and bars, a momentum along a motion that the joints do not allow may also be conserved; then M μ = ∂I/∂u.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ...describe.loads.action import GeneralizedForce, JointForce, PointForce
from ...dynamics.kinematics import link_postures, point_position
from ...dynamics.linear import scalar_product
from ...dynamics.loads.actions import actions
from ...dynamics.loads.power import joint_link, speed_of
from ...dynamics.momentum import mass_centre, momentum
from ...model.model import GROUND
from ...scalar.algebra import HALF, IDENTITY, ZERO, Scalar, Vector, cross, dot, scale
from ...scalar.substitute import Substitution, arrays
from ..derivation.along_motion import momenta, random_numbers, rate_of, residuals_of
from ..derivation.derivation import Derivation
from .symmetry import rigid_motion, solved

AXES = "XYZ"
LARGEST_SOLVED = 3
"""Degrees of freedom up to which M μ = ∂I/∂u is solved exactly."""


def candidates(e: Derivation) -> Iterator[tuple[str, Scalar, tuple[Scalar, ...]]]:
    """(name, quantity, multipliers μ) of all candidates."""
    yield from _energies(e)
    n = e.model.n_u
    p = momenta(e)
    numbers = random_numbers(e, 1)
    at = Substitution(e.ring, arrays, numbers)
    at_rest = _static_residuals(e, numbers)
    for j, speed in enumerate(e.model.speed_names):
        coordinate = speed.removesuffix("'")
        unit = tuple(int(k == j) for k in range(n))
        if speed.endswith("'") and p[j] != 0 and _is_balanced(at_rest, unit, at, _drift(e, p[j], at)):
            yield f"momentum of {coordinate}", p[j], unit
    for name, w, v in _motions(e):
        xi = rigid_motion(e.model, e.state, w, v, at)
        if xi is None:
            yield from _through_masses(e, name, w, v)
        elif _is_balanced(at_rest, xi, at, _drift(e, quantity := scalar_product(xi, p), at)):
            yield name, quantity, xi
    for link in e.model.links:
        if link.u < 0:
            continue
        for k in range(3):
            unit = tuple(int(j == link.u + k) for j in range(n))
            if p[link.u + k] != 0 and _is_balanced(at_rest, unit, at, _drift(e, p[link.u + k], at)):
                yield f"angular momentum along {'xyz'[k]} of {link.body}", p[link.u + k], unit


def _through_masses(
    e: Derivation, name: str, w: Vector, v: Vector
) -> Iterator[tuple[str, Scalar, tuple[Scalar, ...]]]:
    """A momentum along a motion that the joints allow to particles and bars, but not to rigid bodies.

    Its multipliers solve M μ = ∂I/∂u. They are formed for small systems only, if a numerical check at a random state
    succeeds.
    """
    if e.model.n_u > LARGEST_SOLVED or e.condition_names:
        return
    total = momentum(e.model, e.state)
    quantity = dot(v, total.linear) + dot(w, total.angular)
    gradient = [e.ring.derivative(quantity, speed.symbol) for speed in e.model.speeds]
    if all(x == 0 for x in gradient) or not _is_conserved_in_numbers(e, quantity):
        return
    balance = [
        ({j: x for j, x in enumerate(row) if x != 0}, g)
        for row, g in zip(e.canonical_mass_matrix, gradient, strict=True)
    ]
    mu = solved(e.model.n_u, balance, {})
    if mu is not None:
        yield name, quantity, mu


def _is_conserved_in_numbers(e: Derivation, x: Scalar) -> bool:
    """True if dx/dt is zero, to round-off, at a random state."""
    import numpy as np

    atoms = random_numbers(e, 1) | {speed.acceleration: 0 for speed in e.model.speeds}
    at = Substitution(e.ring, arrays, atoms)
    M = np.array([[float(at(entry)) for entry in row] for row in e.canonical_mass_matrix])
    right = np.array([float(at(E)) for E in residuals_of(e)])
    if abs(np.linalg.det(M)) <= np.finfo(float).eps * np.linalg.norm(M) ** len(M):
        return False
    udot = -np.linalg.solve(M, right)
    atoms.update({speed.acceleration: a for speed, a in zip(e.model.speeds, udot, strict=True)})
    rate = rate_of(e, x)
    size = sum(
        abs(float(at(e.ring.derivative(x, s.symbol))) * a) for s, a in zip(e.model.speeds, udot, strict=True)
    )
    value = float(Substitution(e.ring, arrays, atoms)(rate))
    return abs(value) <= np.sqrt(np.finfo(float).eps) * (1 + size)


def _static_residuals(e: Derivation, at: dict[Any, Any]) -> list[float]:
    """E_j at rest in a random configuration, without constraint forces: minus weight, springs and loads.

    It is nan, which nothing balances, where a load has no value at rest, as that of a tyre.
    """
    import numpy as np

    rest = {speed.symbol: 0 for speed in e.model.speeds} | {speed.acceleration: 0 for speed in e.model.speeds}
    numbers = Substitution(e.ring, arrays, at | rest)
    # constraint forces are removed first: sliding friction has no direction at rest
    free = Substitution(e.ring, e.ring, {symbol: 0 for symbol in e.multipliers})
    with np.errstate(divide="ignore", invalid="ignore"):
        return [float(numbers(free(E) if e.multipliers else E)) for E in residuals_of(e)]


def _drift(e: Derivation, quantity: Scalar, at: Substitution) -> float:
    """∂I/∂t at rest in a random configuration: the change of a momentum by drives alone."""
    partial = e.ring.total_derivative(quantity, {})
    if partial == 0:
        return 0
    rest = {speed.symbol: 0 for speed in e.model.speeds}
    return float(at(Substitution(e.ring, e.ring, rest)(partial)))


def _is_balanced(forces: Sequence[float], xi: Sequence[Scalar], at: Substitution, drift: float) -> bool:
    """True if Σ ξ_j E_j = ∂I/∂t at rest, to round-off; a cheap test before the exact one."""
    from sys import float_info

    parts = [force * float(at(x)) for force, x in zip(forces, xi, strict=True) if force]
    parts.append(-drift)
    # a NaN, from a root that is not real in this configuration, must not reject the candidate
    return not abs(sum(parts)) > (1 + sum(map(abs, parts))) * float_info.epsilon**HALF


def _energies(e: Derivation) -> Iterator[tuple[str, Scalar, tuple[Scalar, ...]]]:
    """T₂ - T₀ + V minus the work of constant forces; the energy itself if nothing is driven."""
    T, p = e.energy.canonical_kinetic, momenta(e)
    u = e.state.u
    V = e.energy.canonical_potential - _work_of_constants(e)
    h = scalar_product(p, u) - T + V
    if h == 0 or not e.ring.atoms_of(h) & {speed.symbol for speed in e.model.speeds}:
        return
    name = "energy" if h == T + V else "Jacobi's integral"
    yield name, h, u


def _work_of_constants(e: Derivation) -> Scalar:
    """Work of constant loads: F·r for forces, Q q for generalized forces, force times displacement."""
    model, state = e.model, e.state
    total: Scalar = 0
    for name, load in model.loads.items():
        for action in () if load.is_conservative else actions(model, state, name):
            match action:
                case PointForce(point, force) if _is_constant(e, *force):
                    total = total + dot(force, point_position(model, state, point))
                case GeneralizedForce(coordinate, value) if _is_constant(e, value):
                    symbol = model.speeds[speed_of(model, load, coordinate)].name.removesuffix("'")
                    total = total + value * state.q[model.coordinate_names.index(symbol)]
                case JointForce(value=value) if _is_constant(e, value):
                    total = total + value * state(model.links[joint_link(model, action)].displacement)
    return total


def _is_constant(e: Derivation, *values: Scalar) -> bool:
    """True if scalars depend on parameters only."""
    symbols = {parameter.symbol for parameter in e.model.parameters}
    return all(e.ring.atoms_of(value) <= symbols for value in values)


def _motions(e: Derivation) -> Iterator[tuple[str, Vector, Vector]]:
    """(name, w, v) of the rigid motions to try: translations, rotations about fixed points and the mass centre."""
    for axis, unit in zip(AXES, IDENTITY, strict=True):
        yield f"linear momentum along {axis}", ZERO, unit
    for axis, unit in zip(AXES, IDENTITY, strict=True):
        yield f"angular momentum along {axis} about the ground's origin", unit, ZERO
    postures = link_postures(e.model, e.state)
    parameters = {parameter.symbol for parameter in e.model.parameters}
    for name, joint in e.model.joints.items():
        i = joint.links[0]
        link = e.model.links[i]
        if link.parent != GROUND or link.flies:
            continue
        axes = list(zip(AXES, IDENTITY, strict=True))
        if link.one_dof:
            n = e.state.vector(link.axis)
            R = e.state.matrix(link.rotation)
            n = tuple(dot(row, n) for row in R)
            if n not in IDENTITY and scale(-1, n) not in IDENTITY:
                axes.append((f"the axis of {name}", n))
                if link.slides_only:
                    yield f"linear momentum along the axis of {name}", ZERO, n
        at = postures[i].position
        if at == ZERO or link.slides_only:
            at = ZERO
            axes = axes[3:]
        if not all(e.ring.atoms_of(x) <= parameters for x in at):
            continue
        for axis, unit in axes:
            yield f"angular momentum along {axis} about {name}", unit, cross(at, unit)
    _, centre = mass_centre(e.model, e.state)
    if all(e.ring.atoms_of(x) <= parameters for x in centre):
        return
    for axis, unit in zip(AXES, IDENTITY, strict=True):
        yield f"angular momentum along {axis} about the mass centre", unit, cross(centre, unit)
