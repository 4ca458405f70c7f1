"""Motion with contacts, from event to event.

    between events   the equations of one set of modes (open, stick, slip), compiled, integrated by the usual loop
    an event ends it: a gap closes, N falls to zero, |T| reaches μ_s N, the slip stops, a contact leaves its surface
    at an event      impulses if contacts approach (`impacts`), then modes from the complementarity problem of the
                     accelerations (`complementarity`); where it holds with equality, derivatives of the accelerations
                     and forces along each candidate decide

Bounces whose heights fall below what double precision resolves are summed as the geometric series that they are:
with v the speed after the last one, a = -r_N the approach acceleration and e the part of the speed that is kept,
they end after

    2 v / a · (1 + e + e² + ...) = 2 v / (a (1 - e))

and at most v²/(2a) above the surface. For contacts that alternate (a rocking block) e is the measured ratio of a cycle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..errors import SimulationError
from .complementarity import OPEN, SLIP, SMALL, STICK, Solution, Touching, distinct, painleve, solutions
from .contact_scene import STOPPED, Ending, Modes, Phase, Scene, Snapshot
from .event import EventSpec
from .impacts import impact
from .integrate import integrate
from .kernels import Kernels
from .path import FINISHED, TERMINAL, Array, Path, Rates, Watch, observe
from .phases import Happening, Phases, Segment

CLOSED = 1e-10
"""Gap, relative to 1 m or the greatest coordinate, at which a contact is closed."""
STILL = 1e-10
"""Speed, relative to 1 m/s or the greatest speed, below which a contact does not approach, slip or leave."""
LOW = 1e-15
"""Height of a flight, relative to 1 m or the greatest coordinate, that round-off hides."""
NUDGE = 1e-9
"""Speed of slip given to one that begins in space without acceleration [m/s]."""
ENDLESS = 200
"""Changes of mode at one moment before they are refused as endless."""


@dataclass(frozen=True)
class Change:
    """A contact's mode from ``start`` to ``end`` [s], and why it began."""

    contact: str
    mode: str
    start: float
    end: float
    why: str

    def __str__(self) -> str:
        return f"{self.contact}: {shown(self.mode)} from {self.start:.6g} to {self.end:.6g} s ({self.why})"


def shown(mode: str) -> str:
    """A mode as it is printed."""
    return {"slip+": "slip +", "slip-": "slip -"}.get(mode, mode)


@dataclass(frozen=True, eq=False)
class Leap(Path):
    """One straight step, so short that its curvature is beyond double precision."""

    def sample(self, times: Any, dense: bool = False) -> Array:
        del dense
        wanted = np.atleast_1d(np.asarray(times, dtype=float))
        length = self.times[-1] - self.times[0]
        x = (wanted - self.times[0]) / length if length > 0 else np.zeros_like(wanted)
        return self.states[0] + x[:, None] * (self.states[-1] - self.states[0])


@dataclass
class _Bounce:
    time: float
    contacts: frozenset[int]
    speed: float  # greatest approach speed
    stuck: bool  # whether none of them slips after it


class ContactRun:
    """One run of a machine with contacts. See :func:`run`."""

    def __init__(
        self,
        kernels: Kernels,
        values: Mapping[str, float],
        expressions: Sequence[Any],
        specs: Sequence[EventSpec],
        relative: Array,
        absolute: Array,
        order: str,
        options: Mapping[str, Any],
    ) -> None:
        self.kernels, self.values = kernels, values
        self.model = kernels.model
        self.scene = scene_of(kernels)
        self.parameters = kernels.parameters(values)
        self.expressions, self.specs = tuple(expressions), tuple(specs)
        self.relative, self.absolute = relative, absolute
        self.order, self.options = order, options
        self.names = [c.name for c in self.model.contacts]
        self.n = self.model.n_q
        self.segments: list[Segment] = []
        self.happenings: list[Happening] = []
        self.changes: list[list[Any]] = []  # [contact, mode, start, end, why]
        self.impulses = 0.0
        self.bounces: list[_Bounce] = []
        self.indeterminate: dict[str, float] = {}
        self._setups: dict[Any, Any] = {}
        self._constants = self.scene.program.constants(self.parameters)
        self.rates: Rates | None = None

    # -- numbers ---------------------------------------------------------------------------------

    def look(self, t: float, y: Array) -> Snapshot:
        return self.scene.at(t, y, self._constants)

    def _u(self, y: Array) -> Array:
        return y[self.n : self.n + self.model.n_u]

    def _still(self, y: Array) -> float:
        return STILL * (1 + float(np.abs(self._u(y)).max(initial=0)))

    def _near(self, y: Array) -> float:
        return CLOSED * (1 + float(np.abs(y[: self.n]).max(initial=0)))

    def _slip(self, seen: Snapshot, k: int) -> Array:
        at = self.scene.first[k]
        return seen.rate[at + 1 : at + 1 + self.scene.tangents[k]]

    def _closed(self, seen: Snapshot, y: Array) -> list[int]:
        near = self._near(y)
        return [k for k in range(len(self.names)) if seen.gap[k] <= near and seen.reach[k] >= -near]

    def _touching(self, seen: Snapshot, k: int, still: float) -> Touching:
        v = self._slip(seen, k)
        speed = float(np.linalg.norm(v))
        return Touching(
            self.names[k], self.scene.first[k], self.scene.tangents[k], seen.friction[k], seen.static[k],
            v / speed if speed > still else None,
        )  # fmt: skip

    def _part(self, seen: Snapshot, chosen: Sequence[int], y: Array) -> tuple[Any, ...]:
        """The problem of the chosen contacts alone: A, their rows, responses, contacts with rows renumbered."""
        rows: list[int] = []
        contacts = []
        for k in chosen:
            one = self._touching(seen, k, self._still(y))
            contacts.append(replace(one, row=len(rows)))
            rows += range(self.scene.first[k], self.scene.first[k] + 1 + self.scene.tangents[k])
        return seen.A[np.ix_(rows, rows)], rows, seen.responses[rows], contacts

    # -- impacts ---------------------------------------------------------------------------------

    def collide(self, t: float, y: Array, seen: Snapshot) -> tuple[Array, bool]:
        """State after the impact of the contacts that approach, if any does."""
        still = self._still(y)
        closed = self._closed(seen, y)
        speeds = {k: float(seen.rate[self.scene.first[k]]) for k in closed}
        if not any(v < -still for v in speeds.values()):
            return y, False
        chosen = [k for k in closed if speeds[k] <= still]
        A, rows, responses, contacts = self._part(seen, chosen, y)
        before = seen.rate[rows]
        laws = [self.model.contacts[k].impact for k in chosen]
        e = [float(seen.restitution[k]) for k in chosen]
        try:
            hit = impact(A, before, contacts, e, laws, responses, self.order, still)
        except SimulationError as error:
            raise SimulationError(f"Impact at t = {t:.9g} s of '{self.model.name}': {error}") from None
        after = y.copy()
        after[self.n : self.n + self.model.n_u] += hit.impulses @ responses
        self.impulses += hit.energy
        new = self.look(t, after)
        parts = []
        for k in chosen:
            at = self.scene.first[k]
            if speeds[k] < -still:
                parts.append(
                    f"{self.names[k]}: impact, normal speed {seen.rate[at]:.6g} → {_zero(new.rate[at], still):.6g} m/s"
                )
        self.tell(t, "impact", y, after, "; ".join(parts))
        moving = frozenset(k for k in chosen if speeds[k] < -still)
        stuck = all(float(np.linalg.norm(self._slip(new, k))) <= still for k in moving)
        self.bounces.append(_Bounce(t, moving, max(-speeds[k] for k in moving), stuck))
        return after, True

    def tell(self, t: float, name: str, before: Array, after: Array, text: str) -> None:
        names = (*self.model.coordinate_names, *self.model.speed_names)
        self.happenings.append(
            Happening(
                t,
                name,
                0,
                dict(zip(names, before.tolist(), strict=False)),
                text,
                dict(zip(names, after.tolist(), strict=False)),
            )
        )

    # -- modes -----------------------------------------------------------------------------------

    def modes_at(self, t: float, y: Array, current: Modes) -> tuple[Modes, Solution | None, Snapshot]:
        """Modes of all contacts just after ``t``, in a state in which none approaches.

        Raises
        ------
        SimulationError
            No set of modes is consistent, or several are that move differently (Painlevé).
        """
        seen = self.look(t, y)
        still = self._still(y)
        chosen = [k for k in self._closed(seen, y) if seen.rate[self.scene.first[k]] <= still]
        if not chosen:
            return (OPEN,) * len(self.names), None, seen
        A, rows, responses, contacts = self._part(seen, chosen, y)
        found = solutions(A, seen.c[rows], contacts)
        kept = [one for one in found if self._lasts(t, y, chosen, contacts, one)]
        if not kept:  # those at the limit of friction that others hold, with no slip to come
            kept = [one for one in found if self._lasts(t, y, chosen, contacts, one, True)]
        kept = _held(kept, contacts)
        groups = distinct(kept, responses)
        if len(groups) != 1:
            raise self._paradox(t, y, seen, contacts, A, groups or distinct(found, responses), bool(groups))

        def worth(one: Solution) -> tuple[Any, ...]:
            named = self._named(chosen, contacts, one)
            same = sum(named[k] == current[k] for k in range(len(current)))
            return (sum(mode == STICK for mode, _ in one.modes), same, -one.rank_lack)

        best = max(groups[0], key=worth)
        return self._named(chosen, contacts, best), best, seen

    def _named(self, chosen: Sequence[int], contacts: Sequence[Touching], one: Solution) -> Modes:
        modes = [OPEN] * len(self.names)
        for k, contact, (mode, d) in zip(chosen, contacts, one.modes, strict=True):
            if mode == SLIP and contact.tangents == 1 and not self.model.contacts[k].frictionless:
                modes[k] = "slip-" if d[0] < 0 else "slip+"
            else:
                modes[k] = mode
        return tuple(modes)

    @staticmethod
    def _smooth(contact: Touching) -> bool:
        return contact.tangents == 0 or contact.friction == contact.static == 0

    def _lasts(
        self,
        t: float,
        y: Array,
        chosen: Sequence[int],
        contacts: Sequence[Touching],
        one: Solution,
        limits: bool = False,
    ) -> bool:
        """Whether the laws that hold with equality go on holding, by the derivatives along this motion."""
        if not one.ties:
            return True
        modes = self._named(chosen, contacts, one)
        if any(
            mode == SLIP and c.tangents == 2 and c.sliding is None and not self._smooth(c)
            for c, (mode, _) in zip(contacts, one.modes, strict=True)
        ):
            return True  # in space, slip from rest has no derivative before it has a direction
        phase = self.scene.phase(modes, t, y, self.values)
        program = phase.contact_rates()
        m = self.scene.rows
        slopes = observe(
            program.address("slopes"), 2 * m, np.array([t]), y[None], program.constants(self.parameters)
        )[0]
        a, force = slopes[:m], slopes[m:]
        size_a = float(np.abs(a).max(initial=0))
        size_f = float(np.abs(force).max(initial=0))
        for i, law in one.ties:
            k = chosen[i]
            at, n = self.scene.first[k], self.scene.tangents[k]
            N, T = force[at], force[at + 1 : at + 1 + n]
            if law == "open" and a[at] < -SMALL * size_a:
                return False
            if law == "normal" and -SMALL * size_f > N:
                return False
            if law == "cone":
                row = contacts[i].row
                hold = one.forces[row + 1 : row + 1 + n]
                length = float(np.linalg.norm(hold))
                way = hold / length if length > 0 else None
                growth = float(np.linalg.norm(T)) if way is None else float(way @ T)
                if contacts[i].static * N - growth < -SMALL * size_f:
                    return False
            if law == "onset":
                d = one.modes[i][1]
                growth = float(d @ a[at + 1 : at + 1 + n])
                if growth < -SMALL * size_a or (growth <= SMALL * size_a and not limits):
                    return False
        return True

    def _paradox(
        self,
        t: float,
        y: Array,
        seen: Snapshot,
        contacts: Sequence[Touching],
        A: Array,
        groups: Any,
        several: bool,
    ) -> SimulationError:
        names = (*self.model.coordinate_names, *self.model.speed_names)
        where = ", ".join(f"{n} = {x:.6g}" for n, x in zip(names, y.tolist(), strict=False))
        criteria = ", ".join(f"{c.name}: A_NN - mu d.A_NT = {painleve(A, c):.6g} 1/kg" for c in contacts)
        if several:
            sets = " or ".join(
                "(" + ", ".join(f"{c.name}: {m[0]}" for c, m in zip(contacts, g[0].modes, strict=True)) + ")"
                for g in groups
            )
            what = f"{len(groups)} different motions are consistent, {sets}"
        else:
            what = "no set of modes is consistent"
        return SimulationError(
            f"Contacts of '{self.model.name}' at t = {t:.9g} s: {what}. Rigid bodies with Coulomb friction do not say "
            f"what happens there (Painlevé); the criterion is the normal acceleration per unit of normal force, which "
            f"must be positive: {criteria}. Configuration: {where}. Less friction, or another direction of slip, has "
            f"one motion."
        )

    # -- phases ----------------------------------------------------------------------------------

    def setup(
        self, modes: Modes, t: float, y: Array, seen: Snapshot
    ) -> tuple[Phase, Rates, Watch | None, Any]:
        """Compiled equations of the modes, and the functions to watch."""
        phase = self.scene.phase(modes, t, y, self.values)
        dead = self._dead(modes, seen, y)
        key = (id(phase), dead)
        if key not in self._setups:
            program = phase.motion()
            rates = Rates(
                program.address("rates"),
                self.n + self.model.n_u + 2,
                program.constants(self.parameters),
                tuple(self.model.quaternions),
                program,
            )
            if phase.active:
                rates = replace(
                    rates, projection=program.address("projection"), projected=self.n + self.model.n_u
                )
            watcher, endings = phase.watching(self.expressions, dead)
            directions = (*(spec.direction for spec in self.specs), *(-1 for _ in endings))
            terminal = (*(spec.terminal for spec in self.specs), *(True for _ in endings))
            watch = (
                Watch(
                    watcher.address("values"),
                    directions,
                    terminal,
                    watcher.constants(self.parameters),
                    watcher,
                )
                if directions
                else None
            )
            self._setups[key] = (phase, rates, watch, endings)
        phase.loose = self._loose(modes, dead, seen)
        phase.shown = tuple(
            STICK if k in dead and mode in ("slip+", "slip-") else mode for k, mode in enumerate(modes)
        )
        return self._setups[key]

    def _loose(self, modes: Modes, dead: frozenset[int], seen: Snapshot) -> Any:
        """Which contact forces the motion does not determine: those in combinations that move nothing."""
        rows, columns = [], []
        for k, mode in enumerate(modes):
            if mode == OPEN and k not in dead:
                continue
            at, n = self.scene.first[k], self.scene.tangents[k]
            rows.append([at])
            columns.append(seen.responses[at])
            if mode == STICK or (k in dead and n == 1):
                for i in range(at + 1, at + 1 + n):
                    rows.append([i])
                    columns.append(seen.responses[i])
            elif mode in ("slip+", "slip-"):
                rows[-1] = [at, at + 1]
                columns[-1] = (
                    columns[-1] - seen.friction[k] * (1 if mode == "slip+" else -1) * seen.responses[at + 1]
                )
            elif n == 2 and not self.model.contacts[k].frictionless:
                v = self._slip(seen, k)
                speed = float(np.linalg.norm(v))
                if speed > 0:
                    rows[-1] = [at, at + 1, at + 2]
                    columns[-1] = (
                        columns[-1] - seen.friction[k] * (v / speed) @ seen.responses[at + 1 : at + 3]
                    )
        mask = np.zeros(self.scene.rows, dtype=bool)
        if rows:
            F = np.array(columns)
            F = F / np.linalg.norm(F, axis=1, keepdims=True)
            left, sizes, _ = np.linalg.svd(F)
            rank = int((sizes > 1e-9 * sizes.max(initial=0)).sum())
            for i, group in enumerate(rows):
                if np.abs(left[i, rank:]).max(initial=0) > 1e-7:
                    mask[group] = True
        return mask

    def _dead(self, modes: Modes, seen: Snapshot, y: Array) -> frozenset[int]:
        """Contacts that the others hold where they are: open ones at gap zero, and those at the limit of friction.

        Their rows depend on those of the others, so that what ends their modes never moves off zero.
        """
        near, still = self._near(y), self._still(y)
        candidates = [
            (k, self.scene.first[k])
            for k, mode in enumerate(modes)
            if mode == OPEN and abs(seen.gap[k]) <= near
        ]
        candidates += [
            (k, self.scene.first[k] + 1)
            for k, mode in enumerate(modes)
            if mode in ("slip+", "slip-") and abs(seen.rate[self.scene.first[k] + 1]) <= still
        ]
        if not candidates or all(mode == OPEN for mode in modes):
            return frozenset()
        held = []
        for k, mode in enumerate(modes):
            at, n = self.scene.first[k], self.scene.tangents[k]
            if mode != OPEN:
                held += list(range(at, at + 1 + (n if mode == STICK else 0)))
        R = seen.responses
        basis = R[held].T
        dead = []
        for k, i in candidates:
            row = R[i]
            rest = row - basis @ np.linalg.lstsq(basis, row, rcond=SMALL)[0]
            if np.linalg.norm(rest) <= SMALL * np.linalg.norm(row):
                dead.append(k)
        return frozenset(dead)

    def onset(
        self, t: float, y: Array, modes: Modes, one: Solution | None, seen: Snapshot, end: float
    ) -> Any:
        """The first moment of a slip in space that begins at rest: a straight step, after which it has a direction."""
        starting = [
            k
            for k, mode in enumerate(modes)
            if mode == SLIP
            and self.scene.tangents[k] == 2
            and not self.model.contacts[k].frictionless
            and float(np.linalg.norm(self._slip(seen, k))) <= self._still(y)
        ]
        if not starting or one is None:
            return t, y
        chosen = [k for k in self._closed(seen, y) if seen.rate[self.scene.first[k]] <= self._still(y)]
        rows = [
            i
            for k in chosen
            for i in range(self.scene.first[k], self.scene.first[k] + 1 + self.scene.tangents[k])
        ]
        udot = seen.free + one.forces @ seen.responses[rows]
        pull = min(
            float(np.linalg.norm((seen.A[:, rows] @ one.forces + seen.c)[self.scene.first[k] + 1 :][:2]))
            for k in starting
        )
        if pull <= SMALL * (float(np.abs(seen.c).max(initial=0)) + 1e-300):
            return t, self._nudged(t, y, starting, chosen, modes, one, seen)
        step = min(max(4 * STOPPED / pull, 1e-9), end - t)
        y_after = y.copy()
        y_after[self.n : self.n + self.model.n_u] += step * udot
        from ..dynamics import coordinate_rates
        from ..dynamics.state import float_state

        middle = (self._u(y) + self._u(y_after)) / 2
        state = float_state(self.model, y[: self.n].tolist(), middle.tolist(), t, self.values)
        y_after[: self.n] += step * np.array([float(x) for x in coordinate_rates(self.model, state)])
        return self._leap(t, y, t + step, y_after, modes)

    def _nudged(
        self,
        t: float,
        y: Array,
        starting: Sequence[int],
        chosen: Sequence[int],
        modes: Modes,
        one: Solution,
        seen: Snapshot,
    ) -> Array:
        """A slip that begins with no acceleration has no direction yet: it gets one, with a speed of :data:`NUDGE`.

        Raises
        ------
        SimulationError
            Contacts that stick do not let it slip: how friction is shared among them is not determined.
        """
        rows, wanted = [], []
        for k, (mode, d) in zip(chosen, one.modes, strict=True):
            if mode == OPEN:
                continue
            at, n = self.scene.first[k], self.scene.tangents[k]
            rows.append(at)
            wanted.append(0.0)
            if mode == STICK or k in starting:
                rows += range(at + 1, at + 1 + n)
                wanted += [NUDGE * x for x in d] if k in starting else [0.0] * n
        A, goal = seen.A[np.ix_(rows, rows)], np.array(wanted)
        impulses = np.linalg.lstsq(A, goal, rcond=SMALL)[0]
        if np.abs(A @ impulses - goal).max(initial=0) > 1e-3 * NUDGE:
            names = ", ".join(f"'{self.names[k]}'" for k in chosen if modes[k] != OPEN)
            raise SimulationError(
                f"Contacts {names} at t = {t:.9g} s are statically indeterminate: of the friction forces least in norm "
                f"one has reached μ_s N, but the others hold, and the motion does not say how they share. Rest the "
                f"body on fewer contacts, describe it in its plane of motion, or take method='timestepping'."
            )
        after = y.copy()
        after[self.n : self.n + self.model.n_u] += impulses @ seen.responses[rows]
        return after

    def _leap(self, t: float, y: Array, t_after: float, y_after: Array, modes: Modes) -> tuple[float, Array]:
        phase, rates, _, _ = self.setup(modes, t_after, y_after, self.look(t_after, y_after))
        if phase.active:
            y_after = self._projected(t_after, y_after, rates)
        path = Leap(
            rates,
            np.array([t, t_after]),
            np.array([t_after - t]),
            np.array([y, y_after]),
            (),
            FINISHED,
            0,
            0,
            0,
        )
        self.segments.append(Segment(path, phase, self.impulses, phase.shown, phase.loose))
        return t_after, y_after

    def _projected(self, t: float, y: Array, rates: Rates) -> Array:
        result = y.copy()
        if rates.projection:
            for _ in range(3):
                moved = observe(
                    rates.projection, rates.projected, np.array([t]), result[None], rates.constants
                )[0]
                result[: rates.projected] = moved
                for i in rates.quaternions:
                    result[i : i + 4] /= np.linalg.norm(result[i : i + 4])
        return result

    # -- bounces ---------------------------------------------------------------------------------

    def limit(self, t: float, y: Array) -> tuple[Array, float, frozenset[int]] | None:
        """If bounces have become too low to follow: the state without them, their time left, and the contacts.

        The contacts that bounce then have neither gap nor normal speed; what their normal speeds lose is the sum of
        the impulses that are left.
        """
        if not self.bounces or self.bounces[-1].time != t:
            return None
        seen = self.look(t, y)
        last = self.bounces[-1]
        if len(last.contacts) == 1:
            (k,) = last.contacts
            at = self.scene.first[k]
            v = float(seen.rate[at])
            e = v / last.speed  # by Newton the restitution; by Poisson friction changes it
            a = -self._free_rate(seen, y, k)
            if not (v > self._still(y) and a > 0 and e < 1):
                return self._cycle(t, y, seen)
            height, left = v * v / (2 * a), 2 * v / (a * (1 - e))
            if height > 1e-9 * (1 + self._size(y)):
                return self._cycle(t, y, seen)
            earlier = [b for b in self.bounces[:-1] if b.contacts == last.contacts]
            if height > 1e-13 * (1 + self._size(y)):
                if not earlier or earlier[-1] is not self.bounces[-2]:
                    return self._cycle(t, y, seen)
                # flight times foretell how far a changes in what is left: v_before (t - t_before) measures it
                flight = t - earlier[-1].time
                drift = abs(2 * last.speed / flight - a) / a
                if drift * left > 1e-12 * max(1.0, abs(t)) + 8 * np.finfo(float).eps * abs(t) / flight * left:
                    return self._cycle(t, y, seen)
            return self._settled(t, y, seen, last.contacts), left, last.contacts
        return self._cycle(t, y, seen)

    def _free_rate(self, seen: Snapshot, y: Array, k: int) -> float:
        """Normal acceleration of a contact in flight, the other closed contacts held as they are."""
        del y
        return float(seen.c[self.scene.first[k]])

    def _size(self, y: Array) -> float:
        return float(np.abs(y[: self.n]).max(initial=0))

    def _cycle(self, t: float, y: Array, seen: Snapshot) -> tuple[Array, float, frozenset[int]] | None:
        """Impacts that repeat in cycles, each a constant part of the last: their geometric sum."""
        history = self.bounces[-40:]
        for period in range(1, 7):
            if len(history) < 3 * period + 1:
                break
            pattern = [b.contacts for b in history]
            if any(pattern[-1 - i] != pattern[-1 - i - period] for i in range(2 * period)):
                continue
            one, two, three = history[-1], history[-1 - period], history[-1 - 2 * period]
            first, second = two.time - three.time, one.time - two.time
            if not 0 < second < first:
                continue
            ratio, speeds = second / first, one.speed / two.speed
            if not (ratio < 1 and speeds < 1):
                continue
            contacts = frozenset().union(*(b.contacts for b in history[-period:]))
            height = one.speed * second
            if height > 1e-11 * (1 + self._size(y)):
                continue
            return self._settled(t, y, seen, contacts), second * ratio / (1 - ratio), contacts
        return None

    def _settled(self, t: float, y: Array, seen: Snapshot, contacts: frozenset[int]) -> Array:
        """Normal speeds of the contacts taken away, with the least change of motion; and their slip, if the last
        impact of each left none."""
        rows = [self.scene.first[k] for k in sorted(contacts)]
        for k in sorted(contacts):
            last = next((b for b in reversed(self.bounces) if k in b.contacts), None)
            if last is not None and last.stuck and not self.model.contacts[k].frictionless:
                rows += range(self.scene.first[k] + 1, self.scene.first[k] + 1 + self.scene.tangents[k])
        closed = [
            self.scene.first[k]
            for k in self._closed(seen, y)
            if k not in contacts and abs(seen.rate[self.scene.first[k]]) <= self._still(y)
        ]
        rows += closed
        A = seen.A[np.ix_(rows, rows)]
        impulses = np.linalg.lstsq(A, -seen.rate[rows], rcond=SMALL)[0]
        after = y.copy()
        after[self.n : self.n + self.model.n_u] += impulses @ seen.responses[rows]
        self.impulses += float(impulses @ (2 * seen.rate[rows] + A @ impulses)) / 2
        return after


def _zero(x: float, small: float) -> float:
    return 0.0 if abs(x) <= small else float(x)


def _held(found: list[Solution], contacts: Sequence[Touching]) -> list[Solution]:
    """Without slips that begin though static friction, greater than kinetic, holds with the others unchanged."""
    result = []
    for one in found:
        begun = [
            i
            for i, (mode, _) in enumerate(one.modes)
            if mode == SLIP and contacts[i].sliding is None and contacts[i].static > contacts[i].friction
        ]
        if begun and any(
            all(other.modes[i][0] == STICK for i in begun)
            and all(other.modes[i][0] == one.modes[i][0] for i in range(len(contacts)) if i not in begun)
            for other in found
        ):
            continue
        result.append(one)
    return result


def scene_of(kernels: Kernels) -> Scene:
    """The compiled contacts of a machine, kept for its next run."""
    scene = getattr(kernels, "_scene", None)
    if scene is None:
        scene = Scene(kernels)
        kernels._scene = scene  # type: ignore[attr-defined]
    return scene


def run(
    work: ContactRun, state: Array, begin: float, end: float, between: Callable[[float], None] | None
) -> Phases:
    """The path from ``state`` (q, u) at ``begin`` to ``end``; happenings and changes of mode are left in ``work``."""
    n = work.n + work.model.n_u
    y = np.concatenate([state[:n], [0.0, 0.0]])
    t = begin
    work.rates = None
    current: Modes = ("",) * len(work.names)
    past = current
    reasons: dict[int, str] = {}
    status, crowded, last = "", 0, -math.inf
    seen = work.look(t, y)
    deepest = min(range(len(work.names)), key=lambda k: seen.gap[k] if seen.reach[k] >= 0 else math.inf)
    if seen.gap[deepest] < -work._near(y) and seen.reach[deepest] >= 0:
        raise SimulationError(
            f"The initial state of '{work.model.name}' has contact '{work.names[deepest]}' {-seen.gap[deepest]:.6g} m "
            f"deep. Begin with every gap at zero or above."
        )
    while True:
        crowded = crowded + 1 if t - last <= 1e-13 * max(1.0, abs(t)) else 0
        last = t
        if crowded > ENDLESS:
            raise SimulationError(
                f"Contacts of '{work.model.name}' change their modes again and again at t = {t:.9g} s "
                f"({', '.join(f'{a}: {b}' for a, b in zip(work.names, current, strict=True))}), {ENDLESS} times. "
                "Impacts that end in a finite time only together (restitution of several contacts at once) do this."
            )
        seen = work.look(t, y)
        y, hit = work.collide(t, y, seen)
        settled = work.limit(t, y) if hit else None
        if settled is not None:
            t, y, current, past, stop = _rest(work, t, y, settled, current, past, end, between)
            if stop:
                status = stop
                break
            reasons = dict.fromkeys(settled[2], "end of the bounces, the limit of a geometric series")
        modes, one, seen = work.modes_at(t, y, current)
        phase, rates, _, _ = work.setup(modes, t, y, seen)
        low = LOW * (1 + work._size(y))
        flights = _flights(work, t, y, modes, phase)
        unseen = frozenset(k for k, (v, a) in flights.items() if v * v / (2 * a) < low)
        if unseen:  # a flight lower than the round-off of its gap: none
            y = work._settled(t, y, seen, unseen)
            work.bounces.clear()
            continue
        for i in np.flatnonzero(phase.loose):
            work.indeterminate.setdefault(work.scene.names[i], t)
        shown_now = phase.shown
        _note_modes(work, t, y, past, shown_now, reasons, hit)
        current, past = modes, shown_now
        if t >= end:
            status = FINISHED
            tail = Path(rates, np.array([t]), np.empty(0), y[None], (), FINISHED, 0, 0, 0)
            work.segments.append(Segment(tail, phase, work.impulses, phase.shown, phase.loose))
            break
        t, y = work.onset(t, y, modes, one, seen, end)
        if t >= end:
            status = FINISHED
            break
        phase, rates, watch, endings = work.setup(modes, t, y, seen)
        y = work._projected(t, y, rates)
        _agree(work, t, y, rates, one, seen, modes)
        path, t, y, reasons, stop = _phase(work, phase, rates, watch, endings, t, y, end, modes, between)
        if stop:
            status = stop
            break
    for change in work.changes:
        if change[3] is None:
            change[3] = t
    return Phases(tuple(work.segments), status)


def _agree(
    work: ContactRun, t: float, y: Array, rates: Rates, one: Solution | None, seen: Snapshot, modes: Modes
) -> None:
    """Normal forces that no motion determines must not decide the motion by their friction."""
    if one is None or not one.rank_lack:
        return
    chosen = [k for k in work._closed(seen, y) if seen.rate[work.scene.first[k]] <= work._still(y)]
    rows = [
        i
        for k in chosen
        for i in range(work.scene.first[k], work.scene.first[k] + 1 + work.scene.tangents[k])
    ]
    expected = seen.free + one.forces @ seen.responses[rows]
    f = observe(rates.address, rates.size, np.array([t]), y[None], rates.constants)[0]
    got = f[work.n : work.n + work.model.n_u]
    size = float(np.abs(seen.responses[rows]).max(initial=0) * np.abs(one.forces).max(initial=0))
    if np.abs(got - expected).max(initial=0) > 1e-7 * (size + float(np.abs(expected).max(initial=0))):
        names = ", ".join(f"'{n}'" for n, mode in zip(work.names, modes, strict=True) if mode != OPEN)
        raise SimulationError(
            f"The normal forces of contacts {names} at t = {t:.9g} s are statically indeterminate, and with different "
            "friction each distribution moves the machine otherwise. Give them equal friction, or fewer contacts."
        )


def _phase(
    work: ContactRun, phase: Phase, rates: Rates, watch: Any, endings: Sequence[Ending], t: float, y: Array,
    end: float, modes: Modes, between: Any,
) -> tuple[Path, float, Array, dict[int, str], str]:  # fmt: skip
    """Integrate one phase to its end: path, time, state, reasons by contact, and the status if the run ends."""
    path = integrate(
        rates, y, t, end, relative=work.relative, absolute=work.absolute, watch=watch, between=between,
        # half of the shortest flight: a longer step could jump over the return of a contact
        first_step=min((v / a for v, a in _flights(work, t, y, modes, phase).values()), default=None),
        **work.options,
    )  # fmt: skip
    _check_depth(work, path, modes)
    asked = len(work.specs)
    mine = [c for c in path.crossings if c.number >= asked]
    shown_ = tuple(c for c in path.crossings if c.number < asked)
    work.segments.append(
        Segment(replace(path, crossings=shown_), phase, work.impulses, phase.shown, phase.loose)
    )
    if path.status == FINISHED:
        return path, path.end, path.states[-1], {}, FINISHED
    if path.status != TERMINAL:
        return path, path.end, path.states[-1], {}, path.status
    t_new, y_new = path.end, path.states[-1].copy()
    if any(c.time == path.end and c.number < asked and work.specs[c.number].terminal for c in path.crossings):
        return path, t_new, y_new, {}, TERMINAL
    reasons: dict[int, str] = {}
    stopped = []
    for c in mine:
        ending = endings[c.number - asked]
        reasons[ending.contact] = _why(work, phase, ending, t_new, y_new)
        if ending.law == "slip" and work.scene.tangents[ending.contact] == 2:
            stopped.append(ending.contact)
    for k in stopped:
        t_new, y_new = _halt(work, phase, rates, k, t_new, y_new, modes)
    return path, t_new, y_new, reasons, ""


def _flights(
    work: ContactRun, t: float, y: Array, modes: Modes, phase: Phase
) -> dict[int, tuple[float, float]]:
    """(speed, deceleration) of open contacts that leave a surface to which their phase brings them back at once."""
    seen = work.look(t, y)
    near, still = work._near(y), work._still(y)
    leaving = [
        k
        for k, mode in enumerate(modes)
        if mode == OPEN and abs(seen.gap[k]) <= near and seen.rate[work.scene.first[k]] > still
    ]
    if not leaving:
        return {}
    program = phase.contact()
    a = observe(
        program.address("acceleration"),
        work.scene.rows,
        np.array([t]),
        y[None],
        program.constants(work.parameters),
    )[0]
    return {
        k: (float(seen.rate[work.scene.first[k]]), -float(a[work.scene.first[k]]))
        for k in leaving
        if a[work.scene.first[k]] < 0
    }


def _check_depth(work: ContactRun, path: Path, modes: Modes) -> None:
    """An open contact that is deep at the end of a phase was passed over."""
    y = path.states[-1]
    if not np.isfinite(y).all():
        return
    seen = work.look(path.end, y)
    for k, mode in enumerate(modes):
        if mode == OPEN and seen.gap[k] < -work._near(y) and seen.reach[k] > 0 and path.start < path.end:
            before = work.look(path.start, path.states[0])
            if before.reach[k] > 0:
                raise SimulationError(
                    f"Contact '{work.names[k]}' of '{work.model.name}' closed between {path.start:.6g} and "
                    f"{path.end:.6g} s within less than a step, and was passed over: it is {-seen.gap[k]:.3g} m deep. "
                    f"Give a max_step shorter than that contact lasts."
                )


def _halt(
    work: ContactRun, phase: Phase, rates: Rates, k: int, t: float, y: Array, modes: Modes
) -> tuple[float, Array]:
    """The rest of a slip in space that has come down to :data:`STOPPED`: a straight step to its end."""
    program = phase.contact()
    constants = program.constants(work.parameters)
    m, at = work.scene.rows, work.scene.first[k]
    rate = observe(program.address("rate"), m, np.array([t]), y[None], constants)[0][at + 1 : at + 3]
    a = observe(program.address("acceleration"), m, np.array([t]), y[None], constants)[0][at + 1 : at + 3]
    speed = float(np.linalg.norm(rate))
    if not speed > 0:
        return t, y
    slowing = -float(rate @ a) / speed
    if not slowing > 0:
        return t, y
    step = speed / slowing
    f = observe(rates.address, rates.size, np.array([t]), y[None], rates.constants)[0]
    after = y + step * f
    seen = work.look(t + step, after)
    # what is left of the slip, of second order in the step, goes by an impulse of that size
    rows = [at + 1, at + 2]
    impulses = np.linalg.lstsq(seen.A[np.ix_(rows, rows)], -seen.rate[rows], rcond=SMALL)[0]
    after[work.n : work.n + work.model.n_u] += impulses @ seen.responses[rows]
    path = Leap(rates, np.array([t, t + step]), np.array([step]), np.array([y, after]), (), FINISHED, 0, 0, 0)
    work.segments.append(Segment(path, phase, work.impulses, phase.shown, phase.loose))
    return t + step, after


def _rest(
    work: ContactRun, t: float, y: Array, settled: Any, current: Modes, past: Modes, end: float, between: Any
) -> tuple[float, Array, Modes, Modes, str]:
    """The time that is left to bounces too low to follow, as motion in contact."""
    y, left, contacts = settled
    modes, one, seen = work.modes_at(t, y, current)
    until = min(t + left, end)
    names = ", ".join(work.names[k] for k in sorted(contacts))
    phase, rates, watch, endings = work.setup(modes, t, y, seen)
    _note_modes(
        work, t, y, past, phase.shown, dict.fromkeys(contacts, "bounces below what numbers resolve"), True
    )
    y = work._projected(t, y, rates)
    if until > t:
        _, t, y, _, stop = _phase(work, phase, rates, watch, endings, t, y, until, modes, between)
        if stop and stop != FINISHED:
            return t, y, modes, phase.shown, stop
    if until < end or t < end:
        work.tell(t, "rest", y, y, f"{names}: the bounces end here, the limit of their geometric series")
    work.bounces.clear()
    return t, y, modes, phase.shown, FINISHED if t >= end else ""


def _why(work: ContactRun, phase: Phase, ending: Ending, t: float, y: Array) -> str:
    if ending.law == "gap":
        return "the gap closed"
    if ending.law == "normal":
        return "N reached 0"
    if ending.law == "reach":
        return "the end of the surface"
    if ending.law == "slip":
        return "the slip stopped"
    program = phase.contact()
    force = observe(
        program.address("force"), work.scene.rows, np.array([t]), y[None], program.constants(work.parameters)
    )[0]
    at, n = work.scene.first[ending.contact], work.scene.tangents[ending.contact]
    return f"|T| reached {float(np.linalg.norm(force[at + 1 : at + 1 + n])):.6g} N"


def _note_modes(
    work: ContactRun, t: float, y: Array, before: Modes, after: Modes, reasons: Mapping[int, str], hit: bool
) -> None:
    for k, name in enumerate(work.names):
        if before[k] == after[k]:
            continue
        first = before[k] == ""
        why = reasons.get(k) or (
            "the start" if first else "an impact" if hit else "a change at another contact"
        )
        for change in work.changes:
            if change[0] == name and change[3] is None:
                change[3] = t
        work.changes.append([name, after[k], t, None, why])
        if not first:
            work.tell(t, name, y, y, f"contact {name}: {shown(before[k])} → {shown(after[k])}, {why}")
