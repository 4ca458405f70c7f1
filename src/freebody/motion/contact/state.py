"""Data of one run with contacts: contact quantities, compiled equations of each set of modes, happenings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...dynamics.composite import mass_matrix
from ...dynamics.constraints import linearized
from ...dynamics.contact import contact_rows, reaches_along
from ...dynamics.state import float_state
from ...dynamics.unilateral import MotionWarning, limits, passed_by_impulse
from ...errors import SimulationError
from ..kernels.kernels import Kernels
from ..legs.blow import Blow, call_of, strike
from ..ode.dense_output import Array, Rates, Watch, observe, outputs_at
from ..phase.places import STOPPED
from ..phase.scene import LIMIT, SMOOTH, Modes, Phase, Scene, Snapshot, direction_of, scene_of
from ..trajectory.event import EventSpec, Happening, expressions_of
from ..trajectory.phases import Segment
from .complementarity import OPEN, SLIP, SMALL, STICK, Touching, unknowns
from .impacts import impact, undetermined

CLOSED = 1e-10
"""Gap, relative to 1 m or the greatest coordinate, below which a contact is closed."""
STILL = 1e-10
"""Speed, relative to 1 m/s or the greatest speed, below which a contact does not approach, slip or leave."""
LOW = 1e-15
"""Height of a flight, relative to 1 m or the greatest coordinate, that is lost in round-off."""
NUDGE = 4 * STOPPED
"""Initial speed of a slip in space that begins without acceleration, above the speed at which slips end [m/s]."""
CROWD = 1e-7
"""Time between two events below which they count as simultaneous [s]."""
PHASES = 100_000
"""Largest number of phases of one run."""
CHOICES = ("compliance", "refuse")
"""Values of ``indeterminate``: treatment of a motion that depends on the distribution of indeterminate forces."""
ENDLESS = 200
"""Number of mode changes at one moment above which they are refused as endless."""
_KEPT = 8  # number of snapshots kept


@dataclass
class Bounce:
    """An impact of contacts, one of a possible series of bounces."""

    time: float
    contacts: frozenset[int]
    speed: float  # greatest approach speed
    stuck: bool  # True if none of the contacts slips after the impact


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
        max_steps: int | None,
        blows: Sequence[tuple[float, Blow]] = (),
        called: Sequence[Blow] = (),
        shared: bool = True,
        scene: Scene | None = None,
    ) -> None:
        self.kernels, self.values = kernels, values
        self.model = kernels.model
        self.scene = scene_of(kernels) if scene is None else scene
        self.parameters = kernels.parameters(values)
        # events of the user, then events that trigger a blow
        self.asked = len(specs)
        calls = tuple(call_of(one) for one in called)
        self.specs = (*specs, *calls)
        self.expressions = (*expressions, *expressions_of(kernels.model, calls))
        self.blows, self.called = list(blows), tuple(called)
        self.counts = [math.inf if one.times is None else one.times for one in called]
        self.relative, self.absolute = relative, absolute
        self.order, self.options, self.shared = order, options, shared
        self.steps_left = max_steps
        self.names = [c.name for c in self.model.contacts]
        self.n, self.n_u = self.model.n_q, self.model.n_u
        self.segments: list[Segment] = []
        self.happenings: list[Happening] = []
        self.changes: list[list[Any]] = []  # [contact, mode, start, end, why]
        self.impulses = 0.0
        self.bounces: list[Bounce] = []
        self.indeterminate: dict[str, float] = {}
        self._setups: dict[Any, Any] = {}
        self._programs: dict[Phase, Any] = {}
        self._seen: dict[tuple[float, bytes], Snapshot] = {}
        self._constants = self.scene.constants(self.parameters)
        self.rates: Rates | None = None
        self.left: set[int] = set()  # contacts that begin to leave the end of their side at this moment
        self.met: tuple[float, frozenset[int]] = (
            -math.inf,
            frozenset(),
        )  # contacts closed at a moment so far

    # -- numbers ---------------------------------------------------------------------------------

    def look(self, t: float, y: Array) -> Snapshot:
        """Return the contacts at one moment. The last snapshots are kept, since each event needs them several times."""
        key = (t, y.tobytes())
        if key not in self._seen:
            if len(self._seen) == _KEPT:
                del self._seen[next(iter(self._seen))]
            self._seen[key] = self.scene.at(t, y, self._constants)
        return self._seen[key]

    def u(self, y: Array) -> Array:
        """Return the generalized speeds of a state."""
        return y[self.n : self.n + self.n_u]

    def still(self, y: Array) -> float:
        """Return the speed below which a contact counts as at rest [m/s]."""
        return STILL * (1 + largest(y[self.n : self.n + self.n_u]))

    def near(self, y: Array) -> float:
        """Return the gap below which a contact counts as closed [m]."""
        return CLOSED * (1 + largest(y[: self.n]))

    def slip(self, seen: Snapshot, k: int) -> Array:
        """Return the slip velocity of a contact along its tangents [m/s]."""
        at = self.scene.first[k]
        return seen.rate[at + 1 : at + 1 + self.scene.tangents[k]]

    def speed(self, seen: Snapshot, k: int) -> float:
        """Return the slip speed of a contact [m/s]."""
        return math.hypot(*self.slip(seen, k).tolist())

    def closed(self, t: float, seen: Snapshot, y: Array) -> list[int]:
        """Return the contacts with zero gap and the foot on their side, or at its end and not leaving it.

        At the end of a side, a round feature touches the side or the corner, never both. A feature that came around
        that end is behind the side and does not touch it.
        """
        left = frozenset(self.left)
        if left not in seen.closed:
            seen.closed[left] = self._closed(t, seen, y)
        return seen.closed[left]

    def _closed(self, t: float, seen: Snapshot, y: Array) -> list[int]:
        near = self.near(y)
        deep = near * (1 + largest(self.u(y)))  # event times are located to round-off, gaps are not
        gaps, reaches = seen.gap.tolist(), seen.reach.tolist()
        found = [k for k, gap in enumerate(gaps) if -deep <= gap <= near and reaches[k] >= -near]
        at_end = [k for k in found if seen.reach[k] <= near]
        gone = {k for k in at_end if k in self.left or self._leaves(t, y, k)}
        found = [k for k in found if k not in gone]
        return [k for k in found if not any(side in found for side, _ in self.scene.ends.get(k, ()))]

    def approaching(self, t: float, y: Array) -> bool:
        """Return True if a closed contact approaches."""
        seen, still = self.look(t, y), self.still(y)
        return any(seen.rate[self.scene.first[k]] < -still for k in self.closed(t, seen, y))

    def joined(self, t: float, y: Array) -> bool:
        """Return True if a contact approaches beside those that were closed at this moment before.

        A correction of the state closed it. Each True adds a contact to those of the moment, so their number is the
        limit of such impacts.
        """
        if not self.approaching(t, y):
            return False
        closed = frozenset(self.closed(t, self.look(t, y), y))
        before = self.met[1] if self.met[0] == t else frozenset()
        self.met = (t, before | closed)
        return not closed <= before

    def _leaves(self, t: float, y: Array, k: int, udot: Array | None = None) -> bool:
        """Return True if the foot of a contact moves off the end of its side or, with ``udot``, begins to."""
        state = float_state(self.model, y[: self.n].tolist(), self.u(y).tolist(), t, self.values)
        still = self.still(y)
        given = np.zeros(self.model.n_u) if udot is None else udot
        for value, rate, growth in reaches_along(self.model, state, self.model.contacts[k], given.tolist()):
            if abs(value) > self.near(y):
                continue
            if rate < -still or (udot is not None and abs(rate) <= still and growth < -SMALL):
                return True
        return False

    def begins_to_leave(
        self, t: float, y: Array, seen: Snapshot, chosen: Sequence[int], udot: Array
    ) -> list[int]:
        """Return the contacts at rest at the end of their side that these accelerations move off it."""
        near = self.near(y)
        return [k for k in chosen if seen.reach[k] <= near and self._leaves(t, y, k, udot)]

    def smooth(self, seen: Snapshot, k: int) -> bool:
        """Return True if the coefficients of friction are zero in this run."""
        return bool(seen.friction[k] == seen.static[k] == 0)

    def touching(self, seen: Snapshot, k: int, still: float, row: int | None = None) -> Touching:
        """Return a contact as data of the complementarity problem, at its own row or at another."""
        speed = self.speed(seen, k)
        return Touching(
            self.names[k], self.scene.first[k] if row is None else row, self.scene.tangents[k],
            float(seen.friction[k]), float(seen.static[k]),
            self.slip(seen, k) / speed if speed > still else None,
        )  # fmt: skip

    def alike(self, contacts: Sequence[Touching], seen: Snapshot, chosen: Sequence[int], y: Array) -> float:
        """Return the relative difference of two motions that round-off in the slip directions can cause."""
        slips = [
            self.speed(seen, k)
            for k, c in zip(chosen, contacts, strict=True)
            if c.sliding is not None and c.tangents == 2
        ]
        noise = 1e-14 * (1 + float(np.abs(self.u(y)).max(initial=0)))
        return max(1e-8, *(noise / v for v in slips)) if slips else 1e-8

    def part(self, seen: Snapshot, chosen: Sequence[int], y: Array) -> tuple[Any, ...]:
        """Return the problem of the chosen contacts: A, their rows, responses, and contacts with renumbered rows."""
        rows: list[int] = []
        contacts, still = [], self.still(y)
        for k in chosen:
            contacts.append(self.touching(seen, k, still, len(rows)))
            rows += range(self.scene.first[k], self.scene.first[k] + 1 + self.scene.tangents[k])
        return seen.between(rows), rows, seen.responses[rows], contacts

    # -- impacts ---------------------------------------------------------------------------------

    def collide(self, t: float, y: Array, seen: Snapshot) -> tuple[Array, bool]:
        """Return the state after the impact of approaching contacts, and True if any contact approached."""
        still = self.still(y)
        closed = self.closed(t, seen, y)
        speeds = {k: float(seen.rate[self.scene.first[k]]) for k in closed}
        if not any(v < -still for v in speeds.values()):
            return y, False
        chosen = [k for k in closed if speeds[k] <= still]
        A, rows, responses, contacts = self.part(seen, chosen, y)
        before = seen.rate[rows]
        laws = [self.model.contacts[k].impact for k in chosen]
        e = [float(seen.restitution[k]) for k in chosen]
        try:
            hit = impact(A, before, contacts, e, laws, self.order, still)
        except SimulationError as error:
            raise SimulationError(f"Impact at t = {t:.9g} s of '{self.model.name}': {error}") from None
        after = y.copy()
        after[self.n : self.n + self.n_u] += hit.impulses @ responses
        whole = np.zeros(self.scene.rows)
        whole[rows] = hit.impulses
        self.impulses += self.gained(t, y, seen, whole)
        new = self.look(t, after)
        parts = []
        for k in chosen:
            at = self.scene.first[k]
            if speeds[k] < -still:
                parts.append(
                    f"{self.names[k]}: impact, normal speed {seen.rate[at]:.6g} → {_zero(new.rate[at], still):.6g} m/s"
                )
        if hit.part < 1:
            parts.append(
                f"restitution reduced to {hit.part:g} e: no impulses satisfy the law with e, or the energy would grow"
            )
        if not hit.certain and undetermined(A, contacts, hit.impulses, hit.after, responses):
            names = ", ".join(f"'{self.names[k]}'" for k in chosen)
            if not self.shared:
                raise SimulationError(
                    f"Impact at t = {t:.9g} s of '{self.model.name}': the impulses of contacts {names} are statically "
                    f"indeterminate, and each distribution moves the machine differently through its friction. Change "
                    f"the friction or the shapes, or take indeterminate='compliance', which decides for the limit of "
                    f"equal compliance at all contacts."
                )
            parts.append("indeterminate impulses of equal compliance")
        warnings = self.passed(t, y, after, whole)
        parts += [f"not possible: {one.what} ('{one.name}')" for one in warnings]
        self.tell(t, "impact", y, after, "; ".join(parts), warnings)
        moving = frozenset(k for k in chosen if speeds[k] < -still)
        stuck = all(self.speed(new, k) <= still for k in moving)
        self.bounces.append(Bounce(t, moving, max(-speeds[k] for k in moving), stuck))
        return after, True

    def gained(self, t: float, y: Array, seen: Snapshot, impulses: Array) -> float:
        """Return the change of the kinetic energy T = uᵀM u/2 + b·u + T₀ by impulses on contacts.

        With the contact rates r = W u + w it is ΔT = Λ·(r⁻ + r⁺)/2 - Λ·w + b·Δu. The last two terms are the work of
        drives that impose their motion.
        """
        whole = float(impulses @ (2 * seen.rate + seen.matrix @ (impulses @ seen.responses))) / 2
        if not self.scene.candidates.moving:
            return whole
        program = self.scene.kernels.motion()
        states = np.array([y, y, y])
        mine = slice(self.n, self.n + self.model.n_u)
        states[:, mine] = np.outer([0, 1, -1], impulses @ seen.responses)
        kinetic = observe(
            program.address("energy"), 2, np.full(3, t), states, program.constants(self.parameters)
        )[:, 0]
        return whole - float(impulses @ self.look(t, states[0]).rate) + float(kinetic[1] - kinetic[2]) / 2

    def passed(self, t: float, y: Array, after: Array, impulses: Array) -> tuple[MotionWarning, ...]:
        """Return warnings of one-sided constraints whose limits an impact exceeds.

        The impulses Λ of the constraints follow from Gᵀ Λ = M Δu - Wᵀ P.
        """
        if not limits(self.model):
            return ()
        mine, q = slice(self.n, self.n + self.model.n_u), y[: self.n].tolist()
        state = float_state(self.model, q, y[mine].tolist(), t, self.values)
        M: Any = np.array(mass_matrix(self.model, state))
        W: Any = np.array(contact_rows(self.model, state).matrix)
        active, conditions = list(self.scene.kernels.active), linearized(self.model, state).matrix
        G = np.array([conditions[i] for i in active], dtype=float)
        multipliers = np.zeros(len(conditions))
        left = M @ (after - y)[mine] - impulses @ W
        multipliers[active] = np.linalg.lstsq(G.T, left, rcond=None)[0]
        largest = max(np.abs(multipliers).max(), np.abs(impulses).max())
        return passed_by_impulse(
            self.model, multipliers.tolist(), lambda mu: float(state(mu)), float(largest), t
        )

    def tell(
        self, t: float, name: str, before: Array, after: Array, text: str, warnings: tuple[MotionWarning, ...] = ()
    ) -> None:  # fmt: skip
        """Record a happening."""
        names = (*self.model.coordinate_names, *self.model.speed_names)
        self.happenings.append(
            Happening(
                t,
                name,
                0,
                dict(zip(names, before.tolist(), strict=False)),
                text,
                dict(zip(names, after.tolist(), strict=False)),
                warnings,
            )
        )

    # -- blows -----------------------------------------------------------------------------------

    def target(self, end: float) -> float:
        """Return the time of the next scheduled blow, or the end of the run."""
        return self.blows[0][0] if self.blows else end

    def blows_due(self, t: float) -> bool:
        """Return True if a scheduled blow is due."""
        return bool(self.blows) and self.blows[0][0] <= t

    def struck(self, t: float, y: Array) -> Array:
        """Return the state after all blows that are due. Approaching contacts then collide, as after any impact."""
        while self.blows_due(t):
            y = self._strike(t, y, self.blows.pop(0)[1])
        return y

    def struck_by(self, which: int, t: float, y: Array) -> Array:
        """Return the state after a blow that an event triggers."""
        if not self.counts[which] > 0:
            return y
        self.counts[which] -= 1
        return self._strike(t, y, self.called[which])

    def _strike(self, t: float, y: Array, one: Blow) -> Array:
        after, gained, told = strike(self.kernels, self.values, t, y, one)
        self.impulses += gained
        self.happenings.append(told)
        self.bounces.clear()
        return np.asarray(after)

    def along(self, phase: Phase, name: str, t: float, y: Array) -> Array:
        """Return the rates, accelerations or forces of all contacts in a phase."""
        if phase not in self._programs:
            program = phase.contact()
            self._programs[phase] = program, program.constants(self.parameters)
        program, constants = self._programs[phase]
        return outputs_at(program.address(name), program.outputs(name), t, y, constants)

    # -- phases ----------------------------------------------------------------------------------

    def setup(self, modes: Modes, y: Array, seen: Snapshot) -> tuple[Phase, Rates, Watch | None, Any]:
        """Return the compiled equations of the modes and the functions to watch."""
        phase = self.scene.phase(modes, seen)
        dead = self.dead(modes, seen, y)
        key = (id(phase), dead)
        if key not in self._setups:
            rates = phase.rates(self.parameters)
            watcher, endings = phase.watching(self.expressions, dead)
            directions = (*(spec.direction for spec in self.specs), *(-1 for _ in endings))
            terminal = (*(spec.terminal for spec in self.specs), *(True for _ in endings))
            watch = (
                Watch(
                    watcher.address("watched"),
                    directions,
                    terminal,
                    watcher.constants(self.parameters),
                    watcher,
                    len(self.specs),
                )
                if directions
                else None
            )
            self._setups[key] = (phase, rates, watch, endings)
        phase.loose = self.loose_forces(modes, dead, seen)
        phase.shown = tuple(
            STICK
            if (k in dead and mode in ("slip+", "slip-")) or mode.startswith(LIMIT)
            else SLIP
            if mode == SMOOTH
            else mode
            for k, mode in enumerate(modes)
        )
        return self._setups[key]

    def loose_forces(self, modes: Modes, dead: frozenset[int], seen: Snapshot) -> Any:
        """Return the mask of indeterminate contact forces: forces in combinations without effect on the motion."""
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
            elif (mode == SLIP and n == 2 and not self.model.contacts[k].frictionless) or mode.startswith(
                LIMIT
            ):
                v = np.array(direction_of(mode)) if mode.startswith(LIMIT) else self.slip(seen, k)
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

    def dead(self, modes: Modes, seen: Snapshot, y: Array) -> frozenset[int]:
        """Return the contacts that the others hold in place: open contacts at zero gap, or slip at zero slip velocity.

        Their rows depend on the rows of the others, so the functions that end their modes stay at zero.
        """
        near, still = self.near(y), self.still(y)
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

    def spread(self, modes: Modes, seen: Snapshot, y: Array) -> float:
        """Ratio of the accelerations by indeterminate forces to the accelerations by general forces of that size.

        It is above 0 if the motion depends on the distribution of indeterminate forces, which friction causes.
        """
        chosen = [k for k, mode in enumerate(modes) if mode != OPEN]
        A, _, responses, contacts = self.part(seen, chosen, y)
        known = []
        for k, contact in zip(chosen, contacts, strict=True):
            rough = contact.tangents and not self.smooth(seen, k)
            if modes[k] != STICK and rough and contact.sliding is None:
                return 0.0  # no direction yet
            d = contact.sliding if rough else np.zeros(contact.tangents)
            known.append((STICK, None) if modes[k] == STICK else (SLIP, d))
        columns, rows = unknowns(len(A), contacts, known)
        B = np.array(columns)
        _, sizes, right = np.linalg.svd(A[rows] @ B.T)
        loose = right[int((sizes > SMALL * sizes[0]).sum()) :]
        moved = B @ responses
        return float(np.abs(loose @ moved).max(initial=0) / np.abs(moved).max())

    # -- bounces ---------------------------------------------------------------------------------

    def size(self, y: Array) -> float:
        """Return the greatest coordinate in magnitude."""
        return largest(y[: self.n])


def largest(x: Array) -> float:
    """Return the greatest of a few numbers in magnitude."""
    return max(map(abs, x.tolist()), default=0.0)


def _zero(x: float, small: float) -> float:
    return 0.0 if abs(x) <= small else float(x)
