"""Derivatives after an impact: its law, with the same contacts pressing, sticking and slipping, is differentiated.

    M Δu = Wᵀ Λ,    v_N⁺ = -e v_N⁻,    v_T⁺ = 0 or Λ_T = -μ Λ_N d,  d = v_T⁺/|v_T⁺|

A change (σ, τ, dp) of the state before, of the time and of the unknowns gives

    M (σ⁺ - σ⁻) + d(M Δu) = Σ Λ dW + Wᵀ dΛ + Σ Λ_c dG + Gᵀ dΛ_c,    G σ⁺ = -d(G u⁺ + γ),    dv_N⁺ = -e dv_N⁻ - de v_N⁻,
    dv_T⁺ = 0 or dΛ_T = -μ d dΛ_N - Λ_N (dμ d + μ (1 - d dᵀ)/|v_T⁺| dv_T⁺)

with the impulses Λ_c of the machine's own conditions G u + γ = 0. This is linear in σ⁺, dΛ and dΛ_c. Poisson's law is
a compression (e = 0), and an expansion in which a contact presses with e Λ_C or has v_N⁺ = 0. What resists rolling and
spinning has Λ_N of its contact, and friction in a joint the impulse P of its reaction in place of Λ_N
(`loaded_slopes`).

Source: R. I. Leine, H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems (2004), section 7.1.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...legs.loaded_slopes import Load, load_of_impact, own_impulses
from ...ode.dense_output import Array
from ...phase.candidates.speed_blocks import coupled_speeds
from ...phase.phase import Phase
from ...phase.scene import Snapshot
from ..impact import Impact
from .slopes import Slopes, refused, title

NONE = 1e-9
"""Part of the greatest impulse below which there is none."""
SLOW = 100
"""Multiple of the speed that counts as none, below which a contact rests after an impact."""
AT_LIMIT = 1e-7
"""Part of μ Λ_N by which a contact that sticks stays below its limit of friction."""


class Law(NamedTuple):
    """The law of a contact that presses: v_N⁺ = -e v_N⁻, and it sticks (``way`` None) or slips along ``way``.

    ``normal``    its row of the normal, None if another contact or the load of a joint has the impulse that bounds it
    ``presser``   the contact that has it, itself or another one
    ``speed``     v_N⁻, and ``part``: of the derivative of e that counts
    ``place``     that of its coefficient of friction among its laws; ``turn``: (1 - d dᵀ)/|v_T⁺|
    ``grown``     e times the derivatives of Λ_C, if it presses with e Λ_C
    ``load``      the load of a joint with its derivatives
    ``tied``      True if it presses with e Λ_C and has v_N⁺ = 0, too, as a contact at rest beside another one without
                  friction: both laws must give the same derivatives
    """

    contact: int
    normal: int | None
    tangents: list[int]
    presser: int
    impulse: float
    e: float = 0.0
    part: float = 0.0
    speed: float = 0.0
    friction: float = 0.0
    place: int = 0
    way: Any = None
    turn: Any = None
    grown: Any = None
    load: Load | None = None
    tied: bool = False

    @property
    def rows(self) -> list[int]:
        """Rows of its impulses."""
        return self.tangents if self.normal is None else [self.normal, *self.tangents]


def impact_slope(slopes: Slopes, hit: Impact, sigma: Array, tau: Array) -> tuple[Array, Array]:
    """Return the derivatives after one stage of an impact, and those of the impulses of all rows."""
    laws, n_q, n = laws_of_impact(slopes, hit), slopes.model.n_q, slopes.model.n_u
    rows = [r for law in laws for r in law.rows]
    W, (M, G) = slopes.look(hit.t, hit.before).matrix, slopes.mass(hit.t, hit.before)
    A = _equations(laws, rows, W, M, G)
    own = own_impulses(slopes, hit)
    scale = np.abs(A).max(axis=1)
    scale[scale == 0] = 1
    result, forces = sigma.copy(), np.zeros((len(sigma), slopes.scene.rows))
    for j, s in enumerate(sigma):
        right = _right(slopes, hit, laws, own, s, tau[j], j)
        right[:n] += M @ s[n_q:]
        right /= scale
        x = np.linalg.lstsq(A / scale[:, None], right, rcond=1e-11)[0]
        left = np.abs(A / scale[:, None] @ x - right).max()
        if left > AT_LIMIT * max(np.abs(right).max(), np.abs(x[:n]).max()):
            names = ", ".join(f"'{slopes.model.contacts[k].name}'" for k in hit.chosen)
            what = f"contacts {names} would not collide together if '{slopes.unknowns[j].name}' changed"
            raise refused(slopes, hit.t, what)
        result[j, n_q:], forces[j, rows] = x[:n], x[n : n + len(rows)]
        still = np.concatenate([result[j, :n_q], np.zeros(n)])
        for k, normal in ((law.contact, law.normal) for law in laws if law.tied):
            turned = slopes.of_contact(k, hit.t, hit.after, still, tau[j], slopes.seeds[j]).rates[0]
            by_speeds = W[normal] * x[:n]
            if abs(turned + by_speeds.sum()) > AT_LIMIT * np.abs(by_speeds).max():
                raise refused(slopes, hit.t, f"{title(slopes, k)} takes part in an impact without impulse")
    return result, forces


def _equations(laws: list[Law], rows: list[int], W: Array, M: Array, G: Array) -> Array:
    """Return the matrix of the equations of σ⁺, dΛ and dΛ_c."""
    n, i, normals = len(M), len(M), dict[int, int]()
    end = n + len(rows)
    A = np.zeros((end + len(G), end + len(G)))
    A[:n, :n], A[:n, n:end], A[:n, end:], A[end:, :n] = M, -W[rows].T, -G.T, G
    for law in laws:
        if law.normal is not None:
            normals[law.contact] = i
            if law.grown is None:
                A[i, :n] = W[law.normal]
            else:
                A[i, i] = 1
            i += 1
        turned = None if law.way is None else law.turn @ W[law.tangents]
        for place, r in enumerate(law.tangents):
            if turned is None:
                A[i, :n] = W[r]
            else:
                A[i, :n] = law.impulse * law.friction * turned[place]
                A[i, i] = 1
                if law.load is None:
                    A[i, normals[law.presser]] = law.friction * law.way[place]
                else:
                    A[i, :n] += law.friction * law.way[place] * law.load.by_jump
                    A[i, n:end] += law.friction * law.way[place] * law.load.by_impulses[rows]
                    A[i, end:] += law.friction * law.way[place] * law.load.by_own
            i += 1
    return A


def _right(slopes: Slopes, hit: Impact, laws: list[Law], own: Any, s: Array, tau: float, j: int) -> Array:
    """Return the right-hand sides for a change with the unknown j, without M σ⁻; ``own`` is Λ_c."""
    n_q, n, scene = slopes.model.n_q, slopes.model.n_u, slopes.scene
    dp, still = slopes.seeds[j], np.concatenate([s[:n_q], np.zeros(n)])
    change = (hit.after - hit.before)[n_q : n_q + n]
    first = -slopes.of_momentum(hit.t, hit.before, change, still, tau, dp)
    result = [first]
    speeds = slopes.of_conditions(hit.t, hit.after, still, tau, dp)[0]
    first += own @ slopes.of_conditions(hit.t, hit.before, still, tau, dp)[1]
    for law in laws:
        k, at = law.contact, scene.first[law.contact]
        touch = slopes.of_contact(k, hit.t, hit.before, s, tau, dp)
        after = slopes.of_contact(k, hit.t, hit.after, still, tau, dp).rates
        of_laws = touch.laws
        if hit.origin is not None:
            state, sigma = hit.origin
            of_laws = slopes.of_contact(k, hit.t, state, sigma[j], tau, dp).laws
        for r in range(at, at + 1 + scene.tangents[k]):
            first += hit.impulses[r] * touch.row(r)
        if law.normal is not None and law.grown is None:
            normal = -after[0] - law.e * touch.rates[0] - law.part * of_laws[2] * law.speed
            result.append(np.array([normal]))
        elif law.normal is not None:
            result.append(np.array([law.grown[j] + law.part * of_laws[2] * law.impulse / law.e]))
        if law.way is not None and law.tangents:
            turned = law.friction * (law.turn @ after[1:])
            result.append(-law.impulse * (of_laws[law.place] * law.way + turned))
            if law.load is not None:
                result[-1] -= law.friction * law.way * law.load.change(j, s, tau)
        elif law.tangents:
            result.append(-after[1:])
    return np.concatenate([*result, -speeds])


def laws_of_impact(slopes: Slopes, hit: Impact) -> list[Law]:
    """Return the laws of the contacts that press."""
    before, after = slopes.look(hit.t, hit.before), slopes.look(hit.t, hit.after)
    largest, result = np.abs(hit.impulses).max(initial=0), []
    for k in _struck(slopes, hit, NONE * largest):
        law = _law_of(slopes, hit, k, (before, after), NONE * largest)
        if law is not None:
            result.append(law)
    limits = [k for k in (law.contact for law in result if _is_at_limit(hit, law)) if not hit.taken]
    held = [
        r for law in result for r in law.rows
        if r == law.normal or not (law.way is not None or law.contact in limits)
    ]  # fmt: skip
    W, G = before.matrix, slopes.mass(hit.t, hit.before)[1]
    for law in result:  # at the limit of friction it sticks if the others hold it
        some, all_ = (np.vstack([W[rows], G]) for rows in (held, [*held, *law.rows]))
        if law.contact in limits and np.linalg.matrix_rank(all_, NONE) > np.linalg.matrix_rank(some, NONE):
            raise refused(
                slopes, hit.t, f"{title(slopes, law.contact)} is between stick and slip in an impact"
            )
    return result


def _struck(slopes: Slopes, hit: Impact, none: float) -> Sequence[int]:
    """Return the contacts of the islands in which impulses act: what rests elsewhere takes no part."""
    if hit.taken or hit.blown is not None:
        return hit.chosen
    blocks = slopes.scene.candidates.pattern.blocks
    pressed = {
        blocks.contacts[k][0] for k in hit.chosen if np.abs(hit.impulses[rows_of(slopes, [k])]).max() > none
    }
    islands = coupled_speeds(len(blocks.starts) - 1, [blocks.contacts[k] for k in hit.chosen])
    struck = {block for island in islands if pressed & {*island} for block in island}
    return [k for k in hit.chosen if blocks.contacts[k][0] in struck]


def _is_at_limit(hit: Impact, law: Law) -> bool:
    """Return True for a contact that sticks at its limit of friction."""
    most, friction = law.friction * law.impulse, float(np.linalg.norm(hit.impulses[law.tangents]))
    return law.way is None and bool(law.tangents) and most - friction <= AT_LIMIT * most


def _law_of(slopes: Slopes, hit: Impact, k: int, seen: tuple[Snapshot, Snapshot], none: float) -> Law | None:
    """Return the law of a contact, None if it does not press."""
    scene, (before, after) = slopes.scene, seen
    if slopes.model.contacts[k].loaded:
        load = load_of_impact(slopes, hit, k)
        return _with_friction(slopes, hit, k, seen, Law(k, None, [], k, load.size, load=load))
    presser = scene.presser[k]
    if presser >= 0:
        N = float(hit.impulses[scene.first[presser]])
        law = Law(k, None, [], presser, N)
        return _with_friction(slopes, hit, k, seen, law) if hit.taken or none < N else None
    at, still = scene.first[k], SLOW * hit.still
    e, part = (0.0, 0.0) if hit.taken else (hit.part * float(before.restitution[k]), hit.part)
    speed, N, least, grown = float(before.rate[at]), float(hit.impulses[at]), 0.0, None
    rebound = after.rate[at] + e * speed
    if hit.compressed is not None:
        given, of_impulses = hit.compressed
        least, grown, rebound = e * max(float(given[at]), 0.0), e * of_impulses[:, at], after.rate[at]
    presses = hit.taken or N - least > none
    tied = not presses and not rebound > still
    if tied and least <= none:
        raise refused(slopes, hit.t, f"{title(slopes, k)} takes part in an impact without impulse")
    if not presses and least <= none:
        return None
    if presses and hit.compressed is not None:
        e, part, grown = 0.0, 0.0, None
    law = Law(k, at, [], k, N, e, part, speed, grown=grown, tied=tied)
    return _with_friction(slopes, hit, k, seen, law)


def _with_friction(slopes: Slopes, hit: Impact, k: int, seen: tuple[Snapshot, Snapshot], law: Law) -> Law:
    """Return a law with its friction: stick, or slip along a direction."""
    state = hit.before if hit.origin is None else hit.origin[0]
    at, n, still = slopes.scene.first[k], slopes.scene.tangents[k], SLOW * hit.still
    slip = seen[1].rate[at + 1 : at + 1 + n]
    rests = np.linalg.norm(slopes.look(hit.t, state).rate[at + 1 : at + 1 + n]) <= hit.still
    place = 3 if rests else 0
    mu = float(slopes.outputs(k, hit.t, state).laws[place])
    law = law._replace(friction=mu, place=place)
    if n == 0 or mu == 0:
        return law
    law, size = law._replace(tangents=list(range(at + 1, at + 1 + n))), float(np.linalg.norm(slip))
    if size <= still:
        return law
    way = slip / size
    return law._replace(way=way, turn=(np.eye(n) - np.outer(way, way)) / size)


# -- bounces ---------------------------------------------------------------------------------------------


def bounces_taken(
    slopes: Slopes, hit: Impact, start: tuple[Array, Phase, bool], sigma: Array, tau: Array
) -> Array:
    """Return derivatives after the rest of bounces is taken away from contacts that stay closed after an impact.

    ``start`` is that of the next phase: its state, its modes, and whether straight steps lead to it.
    """
    (y, phase, straight), scene = start, slopes.scene
    restitution = hit.part * slopes.look(hit.t, hit.before).restitution
    still = slopes.look(hit.t, hit.after)
    taken = [
        k for k in hit.chosen
        if phase.modes[k] != "open" and restitution[k] > 0 and abs(still.rate[scene.first[k]]) > hit.still
    ]  # fmt: skip
    if not taken:
        return sigma
    closed = [k for k in hit.chosen if phase.modes[k] != "open" and k not in scene.loaded]
    if straight:
        raise refused(slopes, hit.t, "a series of bounces ends as a slip begins or ends")
    change = y.copy()
    change[: slopes.model.n_q] = hit.after[: slopes.model.n_q]
    impulses = _impulses_between(slopes, hit, change, closed)
    rest = hit._replace(before=hit.after, after=change, impulses=impulses, chosen=closed, taken=True)
    return impact_slope(slopes, rest, sigma, tau)[0]


def _impulses_between(slopes: Slopes, hit: Impact, after: Array, closed: Sequence[int]) -> Array:
    """Return the least impulses of the closed contacts that change the speeds after an impact to others."""
    scene, n_q = slopes.scene, slopes.model.n_q
    seen = slopes.look(hit.t, hit.after)
    rows = rows_of(slopes, closed)
    M, G = slopes.mass(hit.t, hit.after)
    change, pushed = M @ (after - hit.after)[n_q : slopes.moved], np.vstack([seen.matrix[rows], G])
    result = np.zeros(scene.rows)
    result[rows] = np.linalg.lstsq(pushed.T, change, rcond=1e-11)[0][: len(rows)]
    return result


def rows_of(slopes: Slopes, chosen: Sequence[int]) -> list[int]:
    """Return the rows of some contacts."""
    first, tangents = slopes.scene.first, slopes.scene.tangents
    return [r for k in chosen for r in range(first[k], first[k] + 1 + tangents[k])]
