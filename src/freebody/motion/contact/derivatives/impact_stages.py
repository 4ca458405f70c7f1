"""The impacts of a moment one by one, for their derivatives: stages of Poisson's law, sequences, friction in blows.

A motion logs an impact as a whole. Its stages are found again: the compression of Poisson's law, with the loads of
joints that agree with it; contacts that collide one after another; and the friction of joints under the load of a
blow. Each is an impact of one law (`impact_slopes`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ...cones.collision import compiled_code
from ...cones.contacts import contacts_room
from ...events import limits
from ...legs.blow_slopes import Struck, after_blow, reactions_of_blow
from ...legs.loaded_slopes import load_of_impact
from ...ode.dense_output import Array
from ...phase.bearings import PASSES
from ..impact import Impact
from .impact_slopes import AT_LIMIT, NONE, impact_slope, laws_of_impact, rows_of
from .slopes import Slopes, refused, title


def after_impact(slopes: Slopes, hit: Impact, sigma: Array, tau: Array) -> Array:
    """Return the derivatives after an impact, by Newton's law or by Poisson's.

    Raises
    ------
    NoDerivativesError
        A law that holds with equality, or contacts that would not collide together.
    """
    seen, contacts = slopes.look(hit.t, hit.before), slopes.model.contacts
    approaching = [k for k in hit.chosen if seen.rate[slopes.scene.first[k]] < -hit.still]
    poisson = any(contacts[k].impact == "poisson" for k in approaching)
    if not poisson or not any(seen.restitution[k] * hit.part > 0 for k in hit.chosen):
        return impact_slope(slopes, hit, sigma, tau)[0]
    first = compression(slopes, hit)
    check_shares(slopes, first, seen.restitution)
    given, middle = first.impulses, first.after
    between, of_impulses = impact_slope(slopes, first, sigma, tau)
    second = hit._replace(
        before=middle,
        impulses=hit.impulses - given,
        compressed=(given, of_impulses),
        origin=hit.origin or (hit.before, sigma),
    )
    return impact_slope(slopes, second, between, tau)[0]


def after_blow_in_joints(slopes: Slopes, hit: Struck, sigma: Array, tau: Array) -> Array:
    """Return the derivatives after a blow, and the friction of joints under its load (`events.impacts.rub`)."""
    if not slopes.scene.loaded:
        return after_blow(slopes, hit, sigma, tau)
    after, blown = reactions_of_blow(slopes, hit, sigma, tau)
    still = limits.STILL * (1 + float(np.abs(after[slopes.model.n_q : slopes.moved]).max(initial=0)))
    between = after_blow(slopes, hit._replace(after=after), sigma, tau)
    none = np.zeros(slopes.scene.rows)
    rub = Impact(hit.t, after, hit.after, slopes.scene.loaded, none, 0.0, still, blown=blown)
    return impact_slope(slopes, compression(slopes, rub), between, tau)[0]


def check_shares(slopes: Slopes, first: Impact, restitution: Array) -> None:
    """Refuse a compression in which the friction of a joint has an open share of what makes a contact rebound.

    Shares among contacts are those of equal compliance, which least squares differentiate.
    """
    laws = laws_of_impact(slopes, first)
    held = [(law, r) for law in laws for r in law.rows if r == law.normal or law.way is None]
    W, (_, G) = slopes.look(first.t, first.before).matrix, slopes.mass(first.t, first.before)
    pushed = np.vstack([W[[r for _, r in held]], G])
    _, sizes, V = np.linalg.svd(pushed.T)
    idle = V[int((sizes > NONE * sizes.max(initial=0.0)).sum()) :]
    of_joints = [i for i, (law, _) in enumerate(held) if slopes.model.contacts[law.contact].loaded]
    idle = idle[(np.abs(idle[:, of_joints]) > NONE).any(axis=1)]
    for i, (law, r) in enumerate(held):
        if r == law.normal and restitution[law.contact] > 0 and np.abs(idle[:, i]).max(initial=0.0) > NONE:
            what = (
                f"the impulse of {title(slopes, law.contact)} in the compression of an impact is open, since others "
                "stop the same motion, and decides its rebound"
            )
            raise refused(slopes, first.t, what)


def one_by_one(slopes: Slopes, hit: Impact, sigma: Array) -> Iterator[Impact]:
    """Yield the impacts of contacts that collide one after another, the fastest first (`events.impacts`).

    Raises
    ------
    NoDerivativesError
        Two contacts that approach equally fast, of which each would change the speed of the other.
    """
    scene, y, origin = slopes.scene, hit.before, (hit.before, sigma)
    own = [k for k in hit.chosen if scene.presser[k] < 0]
    size = np.abs([slopes.look(hit.t, y).rate[r] for r in rows_of(slopes, hit.chosen)]).max()
    for _ in range(limits.PASSES):
        seen = slopes.look(hit.t, y)
        speeds = [float(seen.rate[scene.first[k]]) for k in own]
        k = own[int(np.argmin(speeds))]
        if min(speeds) >= -max(hit.still, 1e-13 * max(size, hit.still)):
            return
        for other, speed in zip(own, speeds, strict=True):
            tied = other != k and speed - min(speeds) <= AT_LIMIT * abs(min(speeds))
            if tied and np.abs(seen.between([*rows_of(slopes, [k]), scene.first[other]])[-1, :-1]).any():
                names = " and ".join(f"'{slopes.model.contacts[one].name}'" for one in (k, other))
                what = (
                    f"contacts {names} approach equally fast, and which one collides first decides the rest"
                )
                raise refused(slopes, hit.t, what)
        chosen = [one for one in hit.chosen if k in (one, scene.presser[one])]
        poisson = int(slopes.model.contacts[k].impact == "poisson")
        it, impulses = collided(slopes, hit._replace(before=y, chosen=chosen, origin=origin), poisson, 1)
        after = y.copy()
        after[slopes.model.n_q : slopes.moved] += impulses @ seen.responses
        yield Impact(hit.t, y, after, chosen, impulses, float(it.part), hit.still, origin=origin)
        y = after


def compression(slopes: Slopes, hit: Impact) -> Impact:
    """Return an impact without restitution, as a compression, with loads of joints that agree with its impulses."""
    seen, loads, last = slopes.look(hit.t, hit.before), dict[int, float](), np.inf
    for _ in range(PASSES):
        impulses, after = collided(slopes, hit, 0, 0, loads)[1], hit.before.copy()
        after[slopes.model.n_q : slopes.moved] += impulses @ seen.responses
        first = hit._replace(after=after, impulses=impulses, part=0.0)
        found = {
            k: load_of_impact(slopes, first, k).size for k in hit.chosen if slopes.model.contacts[k].loaded
        }
        most = max(found.values(), default=0.0)
        change = max((abs(found[k] - loads.get(k, 0.0)) for k in found), default=0.0)
        if change <= NONE * most and change >= last or change == 0:
            return first
        loads, last = found, change
    names = ", ".join(f"'{slopes.model.contacts[k].name}'" for k in loads)
    raise refused(slopes, hit.t, f"the loads of joints with friction {names} do not settle in an impact")


def collided(
    slopes: Slopes, hit: Impact, poisson: int, part: int, loads: Mapping[int, float] | None = None
) -> tuple[Any, Array]:
    """Return the solved problem of an impact with a ``part`` of the restitution, 0 or 1, and the impulses of all rows.

    ``loads`` bound the friction of joints. Coefficients are those of the origin.
    """
    scene, count, rows = slopes.scene, len(hit.chosen), rows_of(slopes, hit.chosen)
    seen, laws = (slopes.look(hit.t, y) for y in (hit.before, hit.origin[0] if hit.origin else hit.before))
    it, at = contacts_room(count, len(rows)), 0
    it.contacts, it.rows, it.equalities, it.poisson, it.still = count, len(rows), 0, poisson, hit.still
    for i, k in enumerate(hit.chosen):
        it.at[i], it.tangents[i], it.presser[i] = at, scene.tangents[k], -1
        if scene.presser[k] >= 0:
            it.presser[i] = list(hit.chosen).index(scene.presser[k])
        it.friction[i] = it.static[i] = laws.friction[k]
        it.held[i], it.slides[i], it.least[i] = slopes.model.contacts[k].loaded, 0, (loads or {}).get(k, 0.0)
        it.restitution[i] = part * laws.restitution[k]
        at += 1 + scene.tangents[k]
    A = seen.between(rows)
    it.A[: A.size], it.given[: len(rows)] = A.ravel(), seen.rate[rows]
    compiled_code()["collided"](it)
    result = np.zeros(scene.rows)
    result[rows] = it.forces[: len(rows)]
    return it, result
