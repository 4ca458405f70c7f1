"""What becomes of derivatives at the events of contacts: the saltation matrix, with the set of active laws fixed.

An event at g(t, y, p) = 0 happens at another time if p changes. With f the rates on both sides and y⁺ = R(t, y⁻, p),

    dt/dp = -(∂g/∂y s⁻ + ∂g/∂p)/(dg/dt),    σ = s⁻ + f⁻ dt/dp,
    s⁺ = ∂R/∂y σ + ∂R/∂t dt/dp + ∂R/∂p - f⁺ dt/dp

R is an impact (`impact_slopes`), or it takes the rest of a series of bounces away, or it is the identity. Derivatives
do not exist where events of different times meet, where an event only touches zero, and where a law holds with equality
beside others that end. These are refused.

Sources: M. A. Aizerman, F. R. Gantmakher, On the stability of periodic motions (1958); R. I. Leine, H. Nijmeijer,
Dynamics and Bifurcations of Non-Smooth Mechanical Systems (2004), section 7.1.3 (jumps of the fundamental solution);
I. A. Hiskens, M. A. Pai, Trajectory sensitivity analysis of hybrid systems, IEEE Trans. Circuits Syst. I 47 (2000).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...events import event_run
from ...events.limits import STILL
from ...kernels.program import at_states
from ...ode.dense_output import Array
from ...phase.laws import CLOSED
from ...phase.phase import LIMIT, Phase
from ...trajectory.phases import Segment
from .slopes import ADHESION, NORMAL_FORCE, Slopes, refused, title

# -- times -------------------------------------------------------------------------------------------------


def event_slope(slopes: Slopes, phase: Phase, t: float, y: Array, k: int, why: int, along: Any) -> float:
    """Return the derivative along a direction of the function whose zero is an event of a contact."""
    own, at, n = slopes.touch(along, k), slopes.scene.first[k], slopes.scene.tangents[k]
    if slopes.model.contacts[k].compliant and why in (event_run.GAP_CLOSED, event_run.NORMAL_ZERO):
        # N has a slope of its own only inside: at the surface that may be 0
        return float(own.laws[NORMAL_FORCE]) if is_deep(slopes, t, y, k) else own.gap
    if why == event_run.GAP_CLOSED:
        return own.gap
    dF = along.forces[at : at + 1 + n]
    pull, pulls = (float(touch.laws[ADHESION]) for touch in (slopes.outputs(k, t, y), own))
    if why == event_run.NORMAL_ZERO:
        return float(dF[0]) + pulls
    if why == event_run.CONE_REACHED:
        F = slopes.forces(phase, t, y)[at : at + 1 + n]
        mu, change = slopes.look(t, y).static[k], own.laws[1]
        size = np.linalg.norm(F[1:])
        return float(mu * (dF[0] + pulls) + change * (F[0] + pull) - F[1:] @ dF[1:] / size)
    if why == event_run.SLIP_STOPPED:
        v = slopes.look(t, y).rate[at + 1 : at + 1 + n]
        dv = own.rates[1:]
        return float(dv[0] if n == 1 else v @ dv / np.linalg.norm(v))
    end = int(np.argmin(np.abs(slopes.outputs(k, t, y).reaches)))  # the one that is met
    return float(own.reaches[end])


def is_deep(slopes: Slopes, t: float, y: Array, k: int) -> bool:
    """Return True if a contact has a depth above the round-off of places."""
    near = CLOSED * (1 + float(np.abs(y[: slopes.model.n_q]).max(initial=0)))
    return bool(slopes.look(t, y).gap[k] < -near)


def check_passing(slopes: Slopes, last: Segment, k: int, why: int, rate: float, tolerance: float) -> None:
    """Raise if the function of an event only touches zero, as far as the errors of the run tell."""
    path, grazes = last.path, rate == 0
    if why == event_run.GAP_CLOSED:
        program = last.kernels.contact()
        gaps = at_states(program, "gap", path.times, path.states, program.constants(slopes.parameters))
        # an error δ of the gap changes its rate by g'' δ/g', and g'' is of the size of g/T²
        lasted = path.end - path.start
        grazes |= abs(rate) * lasted <= 1e2 * np.sqrt(tolerance) * np.abs(gaps[:, k]).max()
    if grazes:
        what = f"{title(slopes, k)} only touches there, with the rate {rate:.2g}: if an unknown changed, it might not"
        raise refused(slopes, path.end, what)


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
            own, parts = slopes.touch(whole, k), slopes.touch(alone, k)
            most = np.abs(seen.matrix[r]).max()
            wrong[i], given = own.rates[place], parts.rates[place]
            size = most * (sizes[0] + sizes[1]) + abs(given)
            floor = 0.1 * alike * most  # the error of the steps
            off = abs(wrong[i]) > alike * size + floor and not (place > 0 and k in stopped)
            if place == 0:
                off |= abs(own.gap) > alike * (most * sizes[0] + abs(parts.gap)) + floor
            if off:
                does = "close or open" if place == 0 else "slip"
                name = slopes.unknowns[j].name
                what = f"{title(slopes, k)} ({phase.modes[k]}) would {does} if '{name}' changed"
                raise refused(slopes, t, what)
        rows = [r for _, _, r in held]
        if rows:
            X = seen.responses[rows]
            A = seen.matrix[rows] @ X.T
            result[j, n_q:] -= np.linalg.lstsq(A, wrong, rcond=1e-10)[0] @ X
    return result


def check_modes(slopes: Slopes, phase: Phase, t: float, straight: int) -> None:
    """Raise for modes whose derivatives indeterminate forces decide; ``straight`` steps lead to them."""
    for k, mode in enumerate(phase.modes):
        if mode.startswith(LIMIT):
            raise refused(slopes, t, f"{title(slopes, k)} rests at its limit of friction, held by the others")
    if straight > 2:
        raise refused(slopes, t, "slips of several contacts begin and end within a microsecond")


def check_ties(slopes: Slopes, phase: Phase, t: float, y: Array, changed: Sequence[int]) -> None:
    """Raise if a law holds with equality at the start of a phase, except where it has just ended.

    Which points of a disk that lies flat bear it changes nothing but their own forces.
    """
    n_q = slopes.model.n_q
    near = CLOSED * (1 + float(np.abs(y[:n_q]).max(initial=0)))
    still = STILL * (1 + float(np.abs(y[n_q : slopes.moved]).max(initial=0)))
    seen, F, scene = slopes.look(t, y), slopes.forces(phase, t, y), slopes.scene
    largest = np.abs(F).max(initial=0.0)
    for k, mode in enumerate(phase.modes):
        at, n = scene.first[k], scene.tangents[k]
        if mode == "open" or k in changed or scene.presser[k] in changed:
            continue
        pressure = F[at] + float(slopes.outputs(k, t, y).laws[ADHESION])
        if pressure <= 1e-9 * largest and not slopes.model.contacts[k].stands:
            raise refused(slopes, t, f"{title(slopes, k)} is closed without force")
        if mode == "stick" and n:
            limit = seen.static[k] * pressure
            if limit - np.linalg.norm(F[at + 1 : at + 1 + n]) <= 1e-9 * max(limit, largest):
                raise refused(slopes, t, f"{title(slopes, k)} sticks exactly at its limit of friction")
    if any(mode == "open" for mode in phase.modes):
        a = slopes.accelerations(phase, t, y)
        for k, mode in enumerate(phase.modes):
            at = scene.first[k]
            beside = scene.presser[k] >= 0 or seen.reach[k] < 0 or slopes.model.contacts[k].stands
            if mode != "open" or k in changed or beside:
                continue
            rests = abs(seen.gap[k]) <= near and abs(seen.rate[at]) <= still
            if rests and a[at] <= 1e-9 * np.abs(a).max():
                raise refused(slopes, t, f"{title(slopes, k)} touches without force")
