"""What becomes of derivatives at the events of contacts: the saltation matrix, with the set of active laws fixed.

An event at g(t, y, p) = 0 happens at another time if p changes. With f the rates on both sides and y⁺ = R(t, y⁻, p),

    dt/dp = -(∂g/∂y s⁻ + ∂g/∂p)/(dg/dt),    σ = s⁻ + f⁻ dt/dp,
    s⁺ = ∂R/∂y σ + ∂R/∂t dt/dp + ∂R/∂p - f⁺ dt/dp

R is an impact: its law, with the same contacts pressing, sticking and slipping, is differentiated (`impact_slope`),

    M Δu = Wᵀ Λ,    v_N⁺ = -e v_N⁻,    v_T⁺ = 0 or Λ_T = -μ Λ_N v_T⁺/|v_T⁺|

or it takes the rest of a series of bounces away, or it is the identity. Derivatives do not exist where events of different
times meet, where an event only touches zero, and where a law holds with equality beside others that end. These are
refused.

Sources: M. A. Aizerman, F. R. Gantmakher, On the stability of periodic motions (1958); R. I. Leine, H. Nijmeijer,
Dynamics and Bifurcations of Non-Smooth Mechanical Systems (2004), section 7.1.3 (jumps of the fundamental solution);
I. A. Hiskens, M. A. Pai, Trajectory sensitivity analysis of hybrid systems, IEEE Trans. Circuits Syst. I 47 (2000).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...errors import SimulationError
from ..events import event_run
from ..ode.dense_output import Array
from ..phase.scene import Phase
from .slopes import Slopes

CURE = (
    "Ask for the derivatives of a motion that ends before, by unknowns that do not change this event, or take differences "
    "of runs with values= that differ."
)


class Impact(NamedTuple):
    """An impact: states, contacts, impulses of all rows of their kernels, and the part of e that acts.

    ``compressed`` makes it the expansion of Poisson's law: the impulses of the compression, and their derivatives.
    """

    t: float
    before: Array
    after: Array
    chosen: Sequence[int]
    impulses: Array
    part: float
    still: float
    compressed: Any = None


def refused(slopes: Slopes, t: float, what: str) -> SimulationError:
    """Return the error for a motion without derivatives."""
    return SimulationError(
        f"'{slopes.model.name}' has no derivatives by the unknowns of sensitivities= from t = {t:.9g} s on: {what}. {CURE}"
    )


# -- times -------------------------------------------------------------------------------------------------


def event_slope(slopes: Slopes, phase: Phase, t: float, y: Array, k: int, why: int, along: Any) -> float:
    """Return the derivative along a direction of the function whose zero is an event of a contact."""
    own, at, n = slopes.own(along.touches, k), slopes.scene.first[k], slopes.scene.tangents[k]
    if why == event_run.GAP_CLOSED:
        return float(own[0])
    dF = along.forces[at : at + 1 + n]
    if why == event_run.NORMAL_ZERO:
        return float(dF[0])
    if why == event_run.CONE_REACHED:
        F = slopes.forces(phase, t, y)[at : at + 1 + n]
        mu, change = slopes.look(t, y).static[k], slopes.laws_of(own, k)[1]
        size = np.linalg.norm(F[1:])
        return float(mu * dF[0] + change * F[0] - F[1:] @ dF[1:] / size)
    if why == event_run.SLIP_STOPPED:
        v = slopes.look(t, y).rate[at + 1 : at + 1 + n]
        dv = slopes.rates_of(own, k)[1:]
        return float(dv[0] if n == 1 else v @ dv / np.linalg.norm(v))
    return float(own[1 + reach_at_zero(slopes, t, y, k)])


def reach_at_zero(slopes: Slopes, t: float, y: Array, k: int) -> int:
    """Return which end of a side is met."""
    own = slopes.outputs(k, t, y)
    count = slopes.scene.candidates.pattern.contacts[k].reaches
    return int(np.argmin(np.abs(own[1 : 1 + count])))


# -- impacts -----------------------------------------------------------------------------------------------


def impact_slope(slopes: Slopes, hit: Impact, sigma: Array, tau: Array, taken: bool = False) -> tuple[Array, Array]:
    """Return the derivatives after an impact, and those of its impulses; with ``taken`` the rest of a series of bounces is taken away instead: the
    normal speeds of all contacts of ``hit``, with impulses that pull.
    """
    scene, n_q, n = slopes.scene, slopes.model.n_q, slopes.model.n_u
    laws = _laws(slopes, hit, taken)
    rows = [row for law in laws for row in law.rows]
    W = slopes.look(hit.t, hit.before).matrix
    M = slopes.mass(hit.t, hit.before)
    change = (hit.after - hit.before)[n_q : n_q + n]
    size, m = n + len(rows), len(rows)
    A, result = np.zeros((size, size)), sigma.copy()
    A[:n, :n] = M
    for a, r in enumerate(rows):
        A[:n, n + a] = -W[r]
    B, forces = np.zeros((len(sigma), size)), np.zeros((len(sigma), scene.rows))
    for j, s in enumerate(sigma):
        dp, still = slopes.seeds[j], np.concatenate([s[:n_q], np.zeros(n)])
        at_config = (hit.t, hit.before)
        B[j, :n] = M @ s[n_q:] - slopes.of_momentum(*at_config, change, still, tau[j], dp)
        equation = n
        for law in laws:
            k, first = law.contact, scene.first[law.contact]
            own = slopes.of_contact(k, hit.t, hit.before, s, tau[j], dp)
            after = slopes.of_contact(k, hit.t, hit.after, still, tau[j], dp)
            for r in range(first, first + 1 + scene.tangents[k]):
                if hit.impulses[r] != 0:
                    B[j, :n] += hit.impulses[r] * slopes.row_entries(own, r)
            dv, dv_after, of_laws = slopes.rates_of(own, k), slopes.rates_of(after, k), slopes.laws_of(own, k)
            if law.grown is None:
                B[j, equation] = -dv_after[0] - law.e * dv[0] - law.part * of_laws[2] * law.speed
            else:
                B[j, equation] = law.grown[j] + law.part * of_laws[2] * law.impulse / law.e
            equation += 1
            for i in range(1, len(law.rows)):
                if law.way is None:
                    B[j, equation] = -dv_after[i]
                else:  # dΛ_T + μ d dΛ_N + Λ_N μ C dv_T⁺ = -Λ_N dμ d,  C = (1 - d dᵀ)/|v_T⁺|
                    B[j, equation] = -law.impulse * (
                        of_laws[law.place] * law.way[i - 1] + law.friction * (law.turn @ dv_after[1:])[i - 1]
                    )
                equation += 1
    equation = n
    for law in laws:
        column = n + rows.index(law.rows[0])
        if law.grown is None:
            A[equation, :n] = W[law.rows[0]]
        else:
            A[equation, column] = 1.0
        equation += 1
        for i in range(1, len(law.rows)):
            if law.way is None:
                A[equation, :n] = W[law.rows[i]]
            else:
                A[equation, column + i] = 1.0
                A[equation, column] = law.friction * law.way[i - 1]
                A[equation, :n] = law.impulse * law.friction * (law.turn @ W[law.rows[1:]])[i - 1]
            equation += 1
    assert equation == size, (n, m)
    scale = np.abs(A).max(axis=1, keepdims=True)
    scale[scale == 0] = 1.0
    for j in range(len(sigma)):
        right = B[j] / scale[:, 0]
        x = np.linalg.lstsq(A / scale, right, rcond=1e-11)[0]
        left = np.abs(A / scale @ x - right).max()
        if left > 1e-7 * max(np.abs(right).max(), np.abs(x[:n]).max()):
            raise refused(
                slopes, hit.t,
                f"contacts {_names(slopes, hit.chosen)}, which share their impulses, would not collide together if "
                f"'{slopes.unknowns[j].name}' changed",
            )  # fmt: skip
        result[j, n_q:], forces[j, rows] = x[:n], x[n:]
    return result, forces


class Law(NamedTuple):
    """The law of a contact that presses in an impact: v_N⁺ = -e v_N⁻, and it sticks (``way`` None) or slips.

    ``turn`` is (1 - d dᵀ)/|v_T⁺|, ``place`` that of its coefficient of friction among its laws. In an expansion with the
    impulse e Λ_C of Poisson's law, ``grown`` are e times the derivatives of Λ_C.
    """

    contact: int
    rows: list[int]
    e: float
    part: float
    speed: float
    impulse: float
    friction: float
    place: int
    way: Any
    turn: Any
    grown: Any = None


def _laws(slopes: Slopes, hit: Impact, taken: bool) -> list[Law]:
    """Return the laws of the contacts that press."""
    scene, result = slopes.scene, []
    before, after = slopes.look(hit.t, hit.before), slopes.look(hit.t, hit.after)
    largest, limits = np.abs(hit.impulses).max(initial=0.0), []
    for k in hit.chosen:
        at, n, name = scene.first[k], scene.tangents[k], slopes.model.contacts[k].name
        e = 0.0 if taken else hit.part * float(before.restitution[k])
        speed, N, grown = float(before.rate[at]), float(hit.impulses[at]), None
        least = 0.0
        if hit.compressed is not None:
            given, slope = hit.compressed
            least = e * max(float(given[at]), 0.0)
            grown, speed = e * slope[:, at], 0.0
        rises = after.rate[at] + (0.0 if hit.compressed is not None else e * speed) > 1e2 * hit.still
        presses = taken or N - least > 1e-9 * largest
        if not presses and not rises:
            raise refused(slopes, hit.t, f"contact '{name}' takes part in an impact without impulse")
        if presses:
            grown = None
        elif least <= 1e-9 * largest:
            continue
        v, T = after.rate[at + 1 : at + 1 + n], hit.impulses[at + 1 : at + 1 + n]
        slow = np.linalg.norm(before.rate[at + 1 : at + 1 + n]) <= hit.still
        place = 3 if slow and hit.compressed is None else 0
        mu = float(slopes.laws_of(slopes.outputs(k, hit.t, hit.before), k)[place])
        rows, way, turn = [at], None, None
        if n > 0 and mu != 0:
            rows += range(at + 1, at + 1 + n)
            slip = float(np.linalg.norm(v))
            if slip > 1e2 * hit.still:
                way = v / slip
                turn = (np.eye(n) - np.outer(way, way)) / slip
            elif not taken and not mu * N - np.linalg.norm(T) > 1e-7 * mu * N:
                limits.append(k)
        part = 0.0 if taken or hit.compressed is not None and grown is None else hit.part
        if hit.compressed is not None and grown is None:
            e = 0.0
        result.append(Law(k, rows, e, part, speed, N, mu, place, way, turn, grown))
    for k in limits:  # at the limit of friction, but held by the others
        held = [r for law in result for r in (law.rows if law.contact not in limits else law.rows[:1]) if law.way is None or r == law.rows[0]]
        own = list(range(scene.first[k] + 1, scene.first[k] + 1 + scene.tangents[k]))
        W = before.matrix
        if np.linalg.matrix_rank(W[[*held, *own]], 1e-9) > np.linalg.matrix_rank(W[held], 1e-9):
            name = slopes.model.contacts[k].name
            raise refused(slopes, hit.t, f"contact '{name}' is between stick and slip in an impact")
    return result


def _names(slopes: Slopes, contacts: Sequence[int]) -> str:
    return ", ".join(f"'{slopes.model.contacts[k].name}'" for k in contacts)


# -- the next phase ----------------------------------------------------------------------------------------


class After(NamedTuple):
    """The start of a phase: the contacts whose slip in space stops there, and up to what relative size derivatives
    that violate a condition count as round-off.
    """

    phase: Phase
    t: float
    y: Array
    stopped: Sequence[int]
    alike: float


def kept(slopes: Slopes, at: After, sigma: Array, tau: Array) -> Array:
    """Return derivatives moved onto the conditions of a phase, which they keep.

    A slip in space that stops turns at a rate of 1/|v|: what is left of the derivative across it is taken away by
    friction in the last moment, an impulse along the tangents.

    Raises
    ------
    SimulationError
        A contact that is closed would open, or one that sticks would slip, if an unknown changed.
    """
    phase, t, y, stopped, alike = at
    seen, result = slopes.look(t, y), sigma.copy()
    n_q, scene = slopes.model.n_q, slopes.scene
    held = [(k, j, scene.first[k] + j) for k, j in phase.conditions]
    for j, s in enumerate(sigma):
        whole = slopes.along(phase, t, y, s, tau[j], slopes.seeds[j])
        alone = slopes.along(phase, t, y, np.zeros_like(s), tau[j], slopes.seeds[j])
        sizes = np.abs(s[:n_q]).max(initial=0.0), np.abs(s[n_q:]).max(initial=0.0)
        wrong = np.zeros(len(held))
        for i, (k, place, r) in enumerate(held):
            own, parts = slopes.own(whole.touches, k), slopes.own(alone.touches, k)
            most = np.abs(seen.matrix[r]).max()
            wrong[i] = slopes.rates_of(own, k)[place]
            given = slopes.rates_of(parts, k)[place]
            size = most * (sizes[0] + sizes[1]) + abs(given)
            floor = 0.1 * alike * most  # the error of the steps
            off = abs(wrong[i]) > alike * size + floor and not (place > 0 and k in stopped)
            if place == 0:
                off |= abs(own[0]) > alike * (most * sizes[0] + abs(parts[0])) + floor
            if off:
                does = "close or open" if place == 0 else "slip"
                raise refused(
                    slopes, t,
                    f"contact '{slopes.model.contacts[k].name}' ({phase.modes[k]}) would {does} "
                    f"if '{slopes.unknowns[j].name}' changed",
                )  # fmt: skip
        rows = [r for _, _, r in held]
        if rows:
            X = seen.responses[rows]
            A = seen.matrix[rows] @ X.T
            result[j, n_q:] -= np.linalg.lstsq(A, wrong, rcond=1e-10)[0] @ X
    return result


def check_ties(
    slopes: Slopes, phase: Phase, t: float, y: Array, changed: Sequence[int], still: float, near: float
) -> None:
    """Raise if a law holds with equality at the start of a phase, except where it has just ended."""
    seen, F, scene = slopes.look(t, y), slopes.forces(phase, t, y), slopes.scene
    largest = np.abs(F).max(initial=0.0)
    for k, mode in enumerate(phase.modes):
        at, n = scene.first[k], scene.tangents[k]
        name = slopes.model.contacts[k].name
        if mode == "open" or k in changed:
            continue
        if F[at] <= 1e-9 * largest:
            raise refused(slopes, t, f"contact '{name}' is closed without force")
        if mode == "stick" and n:
            limit = seen.static[k] * F[at]
            if limit - np.linalg.norm(F[at + 1 : at + 1 + n]) <= 1e-9 * max(limit, largest):
                raise refused(slopes, t, f"contact '{name}' sticks exactly at its limit of friction")
    if any(mode == "open" for mode in phase.modes):
        a = slopes.accelerations(phase, t, y)
        for k, mode in enumerate(phase.modes):
            at = scene.first[k]
            touches = mode == "open" and abs(seen.gap[k]) <= near and seen.reach[k] >= 0
            if touches and k not in changed and abs(seen.rate[at]) <= still and a[at] <= 1e-9 * np.abs(a).max():
                raise refused(slopes, t, f"contact '{slopes.model.contacts[k].name}' touches without force")
