"""Laws that switch, in compiled code: where they go on, and what they count for.

At e = 0 a law takes the side s that e enters. With ė(s) the rate of e on either side,

    s ė(s) < 0 and -s ė(-s) < 0        both sides lead back to e = 0

there no motion leaves e = 0: it would stay, under a force between those of both sides that the law does not state, and
the law is stuck. So it is where switches follow one another ever faster, as after bounces that lose speed. A law that
only bends where e is zero, as |e| does, has a band while e is round-off, such as a velocity out of a plane: it switches
where e is further beyond zero than the tolerances of the state allow.

Source: A. F. Filippov, Differential Equations with Discontinuous Righthand Sides (1988), section 4.
"""

from __future__ import annotations

from ...native.instructions import Reals, Truth, compiled, greater, inlined
from ...scalar.trace import ADD, CONST, INPUT, MUL, NEG
from .hoisted import Hoisted
from .renewal import renew
from .sided_run import ENTERED, HOLDS, LEAST, QUICK, RESTED, TURNED, SidedRun

JUDGED, OTHER_SIDES, IS_STUCK = range(3)
"""Answers of `judge`: the sides hold; the rates of other sides are asked for; a law is stuck."""
SAME = 1e-12
"""Difference of the times of two events, relative to 1 s or the time, that counts as none (`event_search`)."""


@inlined
def same(t: float, other: float) -> Truth:
    """Return True if two times are those of one event."""
    return abs(t - other) <= SAME * greater(1.0, abs(t))


@inlined
def sign_of(x: float) -> int:
    """Return 1, -1, or 0 for zero and for what is no number."""
    return 1 if x > 0.0 else (-1 if x < 0.0 else 0)


@inlined
def gauge(side: float, e: float, band: float) -> float:
    """Return the function that falls through zero where a law leaves its side: a law at rest leaves it both ways."""
    return side * e + band - (1.0 - side * side) * abs(e)


@compiled
def reset(s: SidedRun, start: float, until: float) -> None:
    """Write the start of a run over the end of the last; all sides are unknown."""
    for k in range(s.laws):
        s.sides[k] = s.bands[k] = 0.0
        s.idle[k] = s.judging[k] = 0
    s.sense = 1.0 if until >= start else -1.0
    s.stuck, s.count, s.quick = -1, 0, QUICK * abs(until - start)


@compiled
def see(s: SidedRun, t: float, y: Reals, rates: Reals) -> None:
    """Evaluate e, ė and ë of all laws at a state with these rates."""
    for i in range(s.n_q + s.n):
        s.argument[i] = y[i]
    for i in range(s.n):
        s.argument[s.n_q + s.n + i] = rates[s.n_q + i]
    s.e(t, s.argument, s.e_c, s.seen)


@compiled
def outwards(s: SidedRun, k: int, still: float) -> float:
    """Return the rate at which e changes, or that of its rate if e follows from coordinates and rests; 0 if it is not
    above ``still``.
    """
    rate = s.sense * s.seen[3 * k + 1]
    if s.order[k] > 1 and abs(rate) <= still:
        rate = s.seen[3 * k + 2]
    return 0.0 if abs(rate) <= still else rate


@compiled
def judge(s: SidedRun, near: float, still: float) -> int:
    """Judge the sides that were entered, by what `see` has found; return `JUDGED`, `OTHER_SIDES` or `IS_STUCK`.

    ``near`` and ``still`` are the e and the rate that are zero: 0 where nothing but its law moves a body.
    """
    if s.stuck >= 0:
        return IS_STUCK
    for k in range(s.laws):
        side, turn = s.sides[k], s.judging[k]
        if s.idle[k] != 0:
            s.judging[k] = HOLDS
            continue
        out = outwards(s, k, still)
        if side == 0.0:
            s.judging[k], s.bands[k] = HOLDS, greater(near, LEAST)
            if out != 0.0:
                s.bands[k] = 0.0
                set_side(s, k, 1.0 if out > 0.0 else -1.0, RESTED if turn == RESTED else ENTERED)
                return OTHER_SIDES
        elif turn != HOLDS:
            e = s.seen[3 * k]
            if turn != RESTED and abs(e) < near and out == 0.0:
                set_side(s, k, 0.0, RESTED)
                return OTHER_SIDES
            s.judging[k] = HOLDS
            if (s.order[k] == 1 or e * side <= 0.0) and side * out < 0.0:
                if turn != TURNED:
                    set_side(s, k, -side, TURNED)
                    return OTHER_SIDES
                if s.jumps[k] != 0:
                    s.stuck = k
                    return IS_STUCK
    return JUDGED


@inlined
def set_side(s: SidedRun, k: int, side: float, judging: int) -> None:
    """Give a law a side that is to be judged."""
    s.sides[k], s.judging[k] = side, judging
    s.bands[k] = s.bands[k] if side != 0.0 and s.bands[k] > LEAST and s.jumps[k] == 0 else 0.0


@compiled
def switch(s: SidedRun, k: int) -> None:
    """Let a law enter the side beyond zero, where `see` has found its e."""
    side = -s.sides[k]
    if side == 0.0:
        side = 1.0 if s.seen[3 * k] > 0.0 else -1.0
        s.bands[k] = 0.0
    set_side(s, k, side, ENTERED)


@compiled
def settle(s: SidedRun, t: float, y: Reals, rates: Reals, near: float) -> int:
    """Give laws whose e is beyond zero their other side, and find the idle ones; return 1 if a side is another, else 0.

    An e may depend on other sides. A law whose e is below ``near`` is to be judged, but not at the start of a run.
    """
    changed, turn = 0, 0
    while turn <= s.laws:
        turn, found = turn + 1, 0
        see(s, t, y, rates)
        for k in range(s.laws):
            e, side = s.seen[3 * k], s.sides[k]
            if s.idle[k] != 0:
                if e * side < 0.0 or side == 0.0 and e != 0.0:
                    s.sides[k], s.bands[k], found = 1.0 if e > 0.0 else -1.0, 0.0, 1
            elif s.judging[k] == HOLDS and gauge(side, e, s.bands[k]) < 0.0:
                starts = 1 if s.bands[k] == 0.0 and side == 0.0 else 0
                switch(s, k)
                if starts != 0 or abs(e) > near:
                    s.judging[k] = HOLDS
                found = 1
        if found == 0:
            turn = s.laws + 1
        else:
            renew(Hoisted(s.hoisted))
            changed = 1
    if find_idle(s) != 0:
        renew(Hoisted(s.hoisted))
        changed = 1
    return changed


# -- what a law counts for -------------------------------------------------------------------------------


@compiled
def find_idle(s: SidedRun) -> int:
    """Find the laws on whose sides neither the rates nor the e of other such laws depend; return 1 if a side changes.

    A product with a factor that the sides make zero depends on that factor alone. A law that was idle and whose e is
    zero is to be judged.
    """
    for k in range(s.laws):
        s.value[s.side_nodes[k]] = s.sides[k]
    for i in range(s.nodes):
        s.needed[i] = 0
        if s.known[i] != 0 and s.code[i] > INPUT:
            a, b = s.value[s.first[i]], s.value[s.second[i]]
            if s.code[i] == ADD:
                s.value[i] = a + b
            elif s.code[i] == MUL:
                s.value[i] = a * b
            elif s.code[i] == NEG:
                s.value[i] = -a
            else:
                s.value[i] = a - b
    for i in range(s.outputs_count):
        s.needed[s.output_nodes[i]] = 1
    found, before = 0, -1
    while found != before:
        before, found = found, 0
        need(s)
        for k in range(s.laws):
            if s.needed[s.side_nodes[k]] != 0:
                s.needed[s.e_nodes[k]] = 1
                found += 1
    changed = 0
    for k in range(s.laws):
        now = 1 - s.needed[s.side_nodes[k]]
        if now == 0 and s.idle[k] != 0 and s.seen[3 * k] == 0.0:
            set_side(s, k, 0.0, HOLDS)
            changed = 1
        s.idle[k] = now
    return changed


@compiled
def need(s: SidedRun) -> None:
    """Mark the nodes on which needed ones depend."""
    for i in range(s.nodes - 1, -1, -1):
        if s.needed[i] != 0 and s.code[i] != CONST and s.code[i] != INPUT:
            a, b = s.first[i], s.second[i]
            no_a = s.code[i] == MUL and s.known[a] != 0 and s.value[a] == 0.0
            no_b = s.code[i] == MUL and s.known[b] != 0 and s.value[b] == 0.0
            if no_a or not no_b:
                s.needed[a] = 1
            if no_b or not no_a:
                s.needed[b] = 1


# -- switches in a row -----------------------------------------------------------------------------------


@compiled
def look_back(s: SidedRun, k: int, t: float, quiet: int) -> int:
    """Note a switch of a law; return 1 if a law is stuck, since switches come ever faster, else 0.

    Laws that bend where their e is round-off (``quiet``) get a band.
    """
    at, most = s.count % s.in_a_row, s.in_a_row
    s.recent[at], s.recent_time[at], s.recent_quiet[at] = 1 + k, t, quiet
    s.count += 1
    if s.count < most:
        return 0
    faster = abs(t - s.recent_time[s.count % most]) <= s.quick
    jumping, loud = -1, 0
    for i in range(most):
        law = s.recent[i] - 1
        if s.jumps[law] != 0:
            jumping = law
        loud += 1 - s.recent_quiet[i]
    if jumping >= 0:
        s.stuck = jumping if faster else -1
        return 1 if faster else 0
    if faster or loud == 0:  # twice as wide where the last band was too narrow
        for i in range(most):
            law = s.recent[i] - 1
            s.bands[law] = greater(2.0 * s.bands[law], s.noise[law])
        s.count = 0
    return 0


@compiled
def is_quiet(s: SidedRun, k: int, t: float, y: Reals, change: float) -> int:
    """Return 1 if a ``change`` of e is one that the tolerances of the state allow, else 0; `see` has found e."""
    if s.jumps[k] != 0:
        return 0
    e, total = s.seen[3 * k], 0.0
    for i in range(s.n_q + s.n):
        s.argument[i] = y[i] + s.relative[i] * (1.0 + abs(y[i]))
        s.e(t, s.argument, s.e_c, s.seen)
        s.argument[i] = y[i]
        total += abs(s.seen[3 * k] - e)
    s.e(t, s.argument, s.e_c, s.seen)
    s.noise[k] = total
    return 1 if change <= total else 0
