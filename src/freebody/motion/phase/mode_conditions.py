"""Modes as data of a phase: its conditions, the contacts to evaluate, and its endings, written in compiled code."""

from __future__ import annotations

from ...native.instructions import Integers, compiled
from ..cones.block_rows import join, root_of
from . import laws
from .contact_outputs import places_of
from .phase_record import PhaseData


@compiled
def direction_kind(phase: PhaseData, k: int, mode: int) -> int:
    """Return the kind of direction in which friction acts on a contact."""
    result = laws.NO_SLIP
    if phase.rough[k] != 0:
        if mode == laws.SLIDE:
            result = laws.ALONG
        elif mode == laws.SLIDE_ON:
            result = laws.PLUS
        elif mode == laws.SLIDE_BACK:
            result = laws.MINUS
        elif mode == laws.LIMIT:
            result = laws.FIXED
    return result


@compiled
def conditions_of(tangents: int, mode: int, held: int) -> int:
    """Return the number of conditions of a contact; its normal is none if it is ``held``."""
    if mode == laws.OPEN:
        return 0
    return 1 - held + (tangents if mode == laws.STICK else 0)


@compiled
def set_modes(phase: PhaseData, modes: Integers, dead: Integers, active: Integers, count: int) -> None:
    """Write the conditions and the endings of these modes.

    ``active``    the independent ones among the ``count`` conditions of contacts that are; those of the machine are so
    ``dead``      1 for each contact that the others hold in place: the end of its mode is not watched
    """
    own, phase.solved = phase.own, 0
    for i in range(own):
        set_condition(phase, i, -1 - i, 0, laws.NO_SLIP)
    at, slipping, normal = own, 0, -1
    for k in range(phase.contacts):
        slip, held = direction_kind(phase, k, modes[k]), phase.held[k]
        phase.mode[k], phase.dead[k] = modes[k], dead[k]
        phase.pushed[k] = slip if held != 0 else laws.NO_SLIP
        if phase.presser[k] < 0:  # resistance to rolling and spinning follows its contact, and has its normal
            normal = at if held == 0 and modes[k] != laws.OPEN else -1
        for j in range(conditions_of(phase.tangents[k], modes[k], held)):
            set_condition(phase, at, k, j + held, slip)
            if at != normal:
                phase.normal_of[at] = normal
            at += 1
        if slip != laws.NO_SLIP and normal >= 0 and phase.force_row[normal] == normal:
            phase.force_row[normal] = phase.most_conditions + slipping
            slipping += 1
    phase.conditions, phase.active, phase.slipping = at, own + count, 1 if slipping > 0 else 0
    for a in range(own + count):
        phase.independent[a] = a if a < own else own + active[a - own]
    find_islands(phase)
    phase.holonomics = 0
    for a in range(own + count):
        i = phase.independent[a]
        if phase.on_coordinates[i] != 0 if i < own else phase.row_of[i] == 0:
            phase.holonomic[phase.holonomics] = i
            phase.holonomics += 1
    if phase.endings > 0:
        set_endings(phase, modes, dead)
    set_closed(phase, modes)


@compiled
def find_islands(phase: PhaseData) -> None:
    """Find the islands of the conditions, and list the conditions, and the independent ones, island by island."""
    parent, number, size = phase.parent, phase.number_of, phase.conditions
    for b in range(phase.blocks):
        parent[b], number[b] = b, -1
    for i in range(size):
        k = phase.source[i]
        if k >= 0:
            join(parent, phase.beside_of[2 * k], phase.beside_of[2 * k + 1])
    phase.islands = 0
    for i in range(size):
        k = phase.source[i]
        one = phase.own_block[-1 - k] if k < 0 else phase.beside_of[2 * k]
        set_places(phase, i, one, one if k < 0 else phase.beside_of[2 * k + 1])
        b = root_of(parent, one)
        if number[b] < 0:
            number[b], phase.slips_in[phase.islands] = phase.islands, 0
            phase.islands += 1
        phase.island[i] = number[b]
        if phase.force_row[i] != i:
            phase.slips_in[number[b]] = 1
    in_order(phase, phase.independent, phase.active, phase.active_at)
    for i in range(size):
        phase.members[i] = i
    in_order(phase, phase.members, size, phase.member_at)


@compiled
def set_places(phase: PhaseData, i: int, one: int, other: int) -> None:
    """Set between which places a condition has speeds of two blocks, and its rows to zero."""
    phase.low[i], phase.high[i] = places_of(phase, one, other)
    G, K = phase.G[i], phase.G[phase.force_row[i]]
    for p in range(phase.n):
        G[p] = K[p] = 0.0


@compiled
def in_order(phase: PhaseData, conditions: Integers, count: int, first: Integers) -> None:
    """Sort conditions by their islands, and set the ``first`` of each island."""
    for a in range(1, count):
        i, b = conditions[a], a
        while b > 0 and phase.island[conditions[b - 1]] > phase.island[i]:
            conditions[b] = conditions[b - 1]
            b -= 1
        conditions[b] = i
    a = 0
    for s in range(phase.islands + 1):
        while a < count and phase.island[conditions[a]] < s:
            a += 1
        first[s] = a


@compiled
def set_condition(phase: PhaseData, i: int, source: int, row: int, slip: int) -> None:
    """Write a condition without a row of K of its own."""
    phase.source[i], phase.row_of[i], phase.slip[i] = source, row, slip
    phase.normal_of[i], phase.force_row[i] = -1, i


@compiled
def set_closed(phase: PhaseData, modes: Integers) -> None:
    """List the closed contacts, and the open ones."""
    closed, opened = 0, 0
    for k in range(phase.contacts):
        if modes[k] != laws.OPEN:
            phase.closed[closed] = k
            closed += 1
        else:
            phase.open[opened] = k
            opened += 1
    phase.closed_count, phase.open_count = closed, opened


# -- endings ---------------------------------------------------------------------------------------------


@compiled
def elsewhere(phase: PhaseData, modes: Integers, k: int) -> int:
    """Return 1 if the foot is on the side that this corner ends, or on a corner of this side; else 0."""
    if phase.side[k] >= 0 and modes[phase.side[k]] != laws.OPEN:
        return 1
    j = phase.first_end[k]
    while j >= 0:
        if modes[j] != laws.OPEN:
            return 1
        j = phase.next_end[j]
    return 0


@compiled
def set_ending(phase: PhaseData, i: int, law: int, sign: int) -> int:
    """Write the law of an ending; return the number of the next."""
    phase.law[i], phase.sign[i] = law, sign
    return i + 1


@compiled
def set_endings(phase: PhaseData, modes: Integers, dead: Integers) -> None:
    """Write the laws of the endings of every contact, in the order of :func:`freebody.motion.phase.scene.endings`."""
    i = 0
    for k in range(phase.contacts):
        n, mode, law = phase.tangents[k], modes[k], laws.NORMAL
        if mode == laws.OPEN:
            law = laws.NEVER if dead[k] != 0 or elsewhere(phase, modes, k) != 0 else laws.GAP
        if phase.held[k] != 0:
            law = laws.NEVER
        if phase.compliant[k] != 0:
            law = laws.PRESS if mode == laws.OPEN else laws.RELEASE
        i = set_ending(phase, i, law, 0)
        law, sign, last = laws.NEVER, 0, laws.NEVER
        if mode == laws.STICK:
            law = laws.LINE_CONE if n == 1 else (laws.CONE if n == 2 else laws.NEVER)
            sign, last = 1, laws.LINE_CONE
        elif (mode == laws.SLIDE_ON or mode == laws.SLIDE_BACK) and dead[k] == 0:
            law, sign = laws.LINE_STOP, 1 if mode == laws.SLIDE_ON else -1
        elif mode == laws.SLIDE and n == 2 and phase.rough[k] != 0:
            law = laws.STOP
        elif mode == laws.LIMIT:
            law = laws.YIELD
        if n > 0:
            i = set_ending(phase, i, law, sign)
        if n == 1:
            i = set_ending(phase, i, last, -1)
        while i < phase.endings and phase.place[i] >= 0:
            met = laws.REACH if phase.owner[i] == k else laws.SIDE
            i = set_ending(phase, i, laws.NEVER if mode == laws.OPEN else met, 0)
