"""Paths of a phase with its derivatives, in pieces that follow a slip in space to its begin and end.

Near |v_T| = 0 the direction of slip turns with rates of 1/|v_T|, and what a derivative has along v_T spoils, by
round-off, what it has across. Such a derivative is mostly a shift of time. So that of y(t + θ p, p) is integrated,

    r = s + θ y',    r' = (∂f/∂y) r + θ ∂f/∂t + ∂f/∂p,

with a θ for which r has nothing along v_T at the start of the piece, and read as s = r - θ y'.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...ending import FAILED, End
from ...kernels import switches
from ...kernels.program import at_states
from ...legs.switch_slopes import SwitchingLaws, least_rate, passed
from ...ode.dense_output import Array, Path, Rates
from ...ode.integration import Integration
from ...phase.phase import Phase
from ...trajectory.phases import Segment
from ..course import Leap
from .slopes import Slopes, refused

SLOW = 1e-3
"""Part of the greatest slip speed of a phase below which it begins or ends slowly."""
DECADES = 9
"""Greatest number of pieces, each a tenth as long as the one before."""


@dataclass(eq=False)
class VariationalPath:
    """A piece of a phase with its derivatives: ``path`` has r, with the ``shifts`` θ; it is read as s."""

    path: Path
    shifts: Array
    slopes: Slopes
    phase: Phase

    @property
    def steps(self) -> int:
        """Number of steps."""
        return self.path.steps

    @property
    def curved(self) -> bool:
        """False for a straight step."""
        return self.path.curved

    @property
    def start(self) -> float:
        """Time of the first state [s]."""
        return self.path.start

    @property
    def end(self) -> float:
        """Time of the last state [s]."""
        return self.path.end

    @property
    def times(self) -> Array:
        """Starts of the steps and the end [s]."""
        return self.path.times

    @property
    def states(self) -> Array:
        """States with their derivatives at :attr:`times`."""
        return self._read(self.path.times, self.path.states)

    @property
    def last(self) -> Array:
        """The r_j at the end, shape (unknowns, components of (q, u)).

        There s_j = r_j - θ_j y' has the round-off of the direction of slip in y'.
        """
        return self.path.states[-1, self.slopes.moved + 2 :].reshape(len(self.shifts), -1)

    def sample(self, times: Any, dense: bool = False) -> Array:
        """Return the states with their derivatives at times."""
        return self._read(np.atleast_1d(np.asarray(times, dtype=float)), self.path.sample(times, dense))

    def _read(self, times: Array, states: Array) -> Array:
        if not self.shifts.any():
            return states
        program, n = self.phase.motion(), self.slopes.moved
        constants = program.constants(self.slopes.parameters)
        own = states[:, : n + 2]
        f = at_states(program, "rates", times, own, constants)[:, :n]
        return np.hstack(
            [own, states[:, n + 2 :] - np.einsum("j,ti->tji", self.shifts, f).reshape(len(times), -1)]
        )


class Switch(NamedTuple):
    """A switch of a load in a phase: its time, the state there, the number of its law, the sign that e takes, and the
    rate of e up to which it only touches zero.
    """

    time: float
    state: Array
    law: int
    side: int
    least: float


def pieces(
    slopes: Slopes, segment: Segment, S: Array, way: Callable[[Rates], Integration], between: Any,
    laws: SwitchingLaws | None = None, passing: Sequence[Switch] = (),
) -> list[VariationalPath]:  # fmt: skip
    """Return the pieces of a phase with its derivatives, from those at its start, shape (unknowns, (q, u)).

    Raises
    ------
    NoDerivativesError
        The variational equations cannot be continued.
    """
    phase, own, result = segment.kernels, segment.path, list[VariationalPath]()
    if not own.end > own.start:
        return [straight_path(slopes, segment, S)]
    times, contacts = _splits(slopes, phase, own)
    at = {switch.time: switch for switch in passing}
    times = sorted({*times, *at})
    states = own.sample(times[1:-1]) if len(times) > 2 else np.empty((0, slopes.moved + 2))
    r, shifts = S, np.zeros(len(S))
    for begin, end, y in zip(times[:-1], times[1:], [own.states[0], *states], strict=True):
        if begin in at and laws is not None:
            y, jump, tau = _switched(slopes, phase, laws, at[begin], r, shifts)
            r = r + np.outer(tau - shifts, jump)
        later = _shifts(slopes, phase, (begin, own.end - own.start), y, (r, shifts), contacts)
        f = slopes.velocity(phase, begin, y)
        start = np.concatenate([y, (r + np.outer(later - shifts, f)).ravel()])
        shifts = later
        integration = way(slopes.rates(phase, shifts))
        path = integration.path(start, begin, end, integration.relative, between)
        if path.status == End.INTERRUPTED:
            raise KeyboardInterrupt
        if path.status in FAILED:
            raise refused(slopes, path.end, f"the variational equations end there: {path.status}")
        result.append(VariationalPath(path, shifts, slopes, phase))
        r = result[-1].last
    return result


def switches_of(
    slopes: Slopes, laws: SwitchingLaws | None, segment: Segment, specs: Sequence[Any], tolerance: float
) -> list[Switch]:
    """Return the switches of loads in a phase.

    Raises
    ------
    NoDerivativesError
        A switch at the start or end of a phase, whose time does not move with it.
    """
    path, n, result = segment.path, slopes.moved, list[Switch]()
    if laws is None:
        return result
    for crossing in path.crossings:
        if not isinstance(specs[crossing.number].expression, switches.Switch):
            continue
        state = np.append(crossing.state[:n], path.sample([crossing.time])[0, n:])
        rows = laws.at(crossing.time, state)
        sizes = np.abs(rows[:, 2 : 2 + n]) @ np.abs(state[:n]) + np.abs(rows[:, 1])
        law = int(np.argmin(np.abs(rows[:, 0]) / np.where(sizes > 0, sizes, 1)))
        if not path.start < crossing.time < path.end:
            if rows[law, -1] > 0:
                what = (
                    f"a load switches, as {laws.texts[law]} passes zero, at the time of an event of a contact"
                )
                raise refused(slopes, crossing.time, what)
            continue
        if all(crossing.time != other.time for other in result):
            least = least_rate(laws, law, path.times, path.states, tolerance)
            result.append(Switch(crossing.time, state, law, crossing.sign, least))
    return result


def _switched(
    slopes: Slopes, phase: Phase, laws: SwitchingLaws, switch: Switch, r: Array, shifts: Array
) -> tuple[Array, Array, Array]:
    """Return the state beyond a switch, the jump of the rates, and the derivatives of its time."""
    before, after = (laws.beside(switch.law, switch.time, switch.state, x * switch.side) for x in (-1, 1))
    f = [slopes.velocity(phase, *one) for one in (before, after)]
    moment = switch.time, switch.state, r - np.outer(shifts, f[0]), switch.side
    tau, jump = passed(laws, switch.law, moment, f, switch.least)
    return after[1], jump, tau


def straight_path(slopes: Slopes, segment: Segment, S: Array) -> VariationalPath:
    """Return a straight step, or a phase without length, with constant derivatives."""
    shifts, own = np.zeros(len(S)), segment.path
    states = np.hstack([own.states, np.tile(S.ravel(), (len(own.states), 1))])
    rates = slopes.rates(segment.kernels, shifts)
    path = Leap(rates, own.times, np.diff(own.times), states, (), End.FINISHED, -1, 0, 0)
    return VariationalPath(path, shifts, slopes, segment.kernels)


def slipping(slopes: Slopes, phase: Phase) -> list[int]:
    """Return the contacts that slip in space, with friction."""
    return [k for k, mode in enumerate(phase.modes) if mode == "slip" and slopes.scene.tangents[k] == 2]


def _splits(slopes: Slopes, phase: Phase, own: Path) -> tuple[list[float], list[int]]:
    """Return the ends of the pieces of a phase, and the contacts whose slip begins or ends slowly."""
    slow: set[int] = set()
    program, result = phase.contact(), {own.start, own.end}
    constants = program.constants(slopes.parameters)
    for k in slipping(slopes, phase):
        at = slopes.scene.first[k]
        rates = at_states(program, "rate", own.times, own.states, constants)
        speeds = np.linalg.norm(rates[:, at + 1 : at + 3], axis=1)
        least, length = SLOW * speeds.max(), own.end - own.start
        parts = [length / 10**i for i in range(1, DECADES)]
        if speeds[0] < least:
            result |= {own.start + x for x in parts}
            slow.add(k)
        if speeds[-1] < least:
            result |= {own.end - x for x in parts}
            slow.add(k)
    return sorted(result), sorted(slow)


def _shifts(
    slopes: Slopes,
    phase: Phase,
    moment: tuple[float, float],
    y: Array,
    given: tuple[Array, Array],
    contacts: list[int],
) -> Array:
    """Return θ of each unknown, for the slowest of some contacts; ``given`` are the r_j and θ_j up to here.

    ``moment`` is the time, and the length of the phase. Where a slip hardly changes in that, as at a compliant contact
    that begins without force, its change tells no time.
    """
    (t, length), (r, shifts) = moment, given
    if not contacts:
        return np.zeros_like(shifts)
    rate = slopes.look(t, y).rate

    def slip(k: int) -> Array:
        return rate[slopes.scene.first[k] + 1 : slopes.scene.first[k] + 3]

    k = min(contacts, key=lambda k: float(np.linalg.norm(slip(k))))
    onwards = slopes.along(phase, t, y, slopes.velocity(phase, t, y), 1.0)
    growth = float(slip(k) @ slopes.touch(onwards, k).rates[1:])
    if abs(growth) * length <= SLOW * float(slip(k) @ slip(k)):
        return shifts
    result = shifts.copy()
    for j, dp in enumerate(slopes.seeds):
        way = slopes.along(phase, t, y, r[j], shifts[j], dp)
        result[j] -= float(slip(k) @ slopes.touch(way, k).rates[1:]) / growth
    return result
