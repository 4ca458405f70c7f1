"""The part of a phase's table that depends on the modes (`places`), written in compiled code."""

from __future__ import annotations

from ...native.instructions import Integers, Reals, bits, call, compiled, inlined, integers_at, shifted
from .places import (
    ACTIVE,
    ALONG,
    CALLED,
    CONDITION,
    CONDITION_SIZE,
    CONDITIONS,
    CONE,
    CONSTANTS,
    CONTACT,
    CONTACT_OF,
    CONTACT_SIZE,
    CONTACTS,
    ENDING,
    ENDING_SIZE,
    ENDINGS,
    FIXED,
    FORCE_ROW,
    GAP,
    HELD,
    HOLONOMIC,
    INDEPENDENT,
    K_AT,
    KIND,
    KIND_SIZE,
    LAW,
    LIMIT,
    LINE_CONE,
    LINE_STOP,
    MACHINE,
    MACHINE_AT,
    MINUS,
    N_U,
    NEVER,
    NO_SLIP,
    NORMAL,
    NORMAL_OF,
    OPEN,
    OWN,
    OWN_HOLONOMIC,
    PLACE,
    PLUS,
    PUSHED,
    REACH,
    REACHES,
    ROUGH,
    ROW_OF,
    SIDE,
    SIDE_OF,
    SIGN,
    SLIDE,
    SLIDE_BACK,
    SLIDE_ON,
    SLIP,
    SLIPPING,
    SOURCE,
    STICK,
    STOP,
    TANGENTS,
    WATCHED,
    Y_AT,
)


@inlined
def table(c: Reals) -> Integers:
    """Return the table of integers of a phase."""
    return integers_at(bits(c[0]))


@inlined
def evaluated(t: float, y: Reals, c: Reals, T: Integers) -> None:
    """Call the kernel of the machine."""
    call(T[MACHINE], t, y, 0, shifted(c, T[CONSTANTS]), c, T[MACHINE_AT])


@compiled
def direction_kind(T: Integers, k: int, mode: int) -> int:
    """Return the kind of direction in which friction acts on a contact."""
    result = NO_SLIP
    if T[T[KIND] + KIND_SIZE * k + ROUGH] != 0:
        if mode == SLIDE:
            result = ALONG
        elif mode == SLIDE_ON:
            result = PLUS
        elif mode == SLIDE_BACK:
            result = MINUS
        elif mode == LIMIT:
            result = FIXED
    return result


@compiled
def conditions_of(tangents: int, mode: int, held: int) -> int:
    """Return the number of conditions of a contact; its normal is none if it is ``held``."""
    if mode == OPEN:
        return 0
    return 1 - held + (tangents if mode == STICK else 0)


@compiled
def set_modes(T: Integers, modes: Integers, dead: Integers, active: Integers, count: int) -> None:
    """Write the conditions and the endings of these modes.

    ``active``    the independent ones among the ``count`` conditions of contacts that are; those of the machine are so
    ``dead``      1 for each contact that the others hold in place: the end of its mode is not watched
    """
    own, n = T[OWN], T[N_U]
    for i in range(own):
        set_condition(T, i, -1 - i, 0, NO_SLIP)
    at, slipping = own, 0
    for k in range(T[CONTACTS]):
        slip, held = direction_kind(T, k, modes[k]), T[T[KIND] + KIND_SIZE * k + HELD]
        T[T[KIND] + KIND_SIZE * k + PUSHED] = slip if held != 0 else NO_SLIP
        normal = at
        for j in range(conditions_of(T[T[CONTACT] + CONTACT_SIZE * k + TANGENTS], modes[k], held)):
            set_condition(T, at, k, j + held, slip)
            one = T[CONDITION] + CONDITION_SIZE * at
            if j > 0 and held == 0:
                T[one + NORMAL_OF] = normal
            if slip != NO_SLIP:
                T[one + FORCE_ROW] = T[K_AT] + slipping * n
                slipping += 1
            at += 1
    T[CONDITIONS], T[ACTIVE], T[SLIPPING] = at, own + count, 1 if slipping > 0 else 0
    independent, holonomic = shifted(T, T[INDEPENDENT]), shifted(T, T[HOLONOMIC])
    holonomic[0] = 0
    for i in range(own + count):
        independent[i] = i if i < own else own + active[i - own]
        one = T[CONDITION] + CONDITION_SIZE * independent[i]
        if T[T[OWN_HOLONOMIC] + i] != 0 if i < own else T[one + ROW_OF] == 0:
            holonomic[0] += 1
            holonomic[holonomic[0]] = independent[i]
    if T[ENDINGS] > 0:
        set_endings(T, modes, dead)
    set_closed(T, modes)


@compiled
def set_condition(T: Integers, i: int, source: int, row: int, slip: int) -> None:
    """Write a condition without a row of K of its own."""
    one = T[CONDITION] + CONDITION_SIZE * i
    T[one + SOURCE], T[one + ROW_OF], T[one + SLIP], T[one + NORMAL_OF] = source, row, slip, -1
    T[one + FORCE_ROW] = T[Y_AT] + i * T[N_U]


@compiled
def set_closed(T: Integers, modes: Integers) -> None:
    """List the closed contacts, and the open ones."""
    called, watched = shifted(T, T[CALLED]), shifted(T, T[WATCHED])
    called[0], watched[0] = 0, 0
    for k in range(T[CONTACTS]):
        if modes[k] != OPEN:
            called[0] += 1
            called[called[0]] = k
        else:
            watched[0] += 1
            watched[watched[0]] = k


# -- endings ---------------------------------------------------------------------------------------------


@compiled
def elsewhere(T: Integers, modes: Integers, k: int) -> int:
    """Return 1 if the foot is on the side that this corner ends, or on a corner of this side; else 0."""
    side = T[T[KIND] + KIND_SIZE * k + SIDE_OF]
    if side >= 0 and modes[side] != OPEN:
        return 1
    if T[T[CONTACT] + CONTACT_SIZE * k + REACHES] > 0:
        for j in range(T[CONTACTS]):
            if T[T[KIND] + KIND_SIZE * j + SIDE_OF] == k and modes[j] != OPEN:
                return 1
    return 0


@compiled
def set_ending(T: Integers, i: int, law: int, sign: int) -> int:
    """Write the law of an ending; return the number of the next."""
    T[T[ENDING] + ENDING_SIZE * i + LAW], T[T[ENDING] + ENDING_SIZE * i + SIGN] = law, sign
    return i + 1


@compiled
def set_endings(T: Integers, modes: Integers, dead: Integers) -> None:
    """Write the laws of the endings of every contact, in the order of :func:`freebody.motion.phase.scene.endings`."""
    i = 0
    for k in range(T[CONTACTS]):
        n, mode = T[T[CONTACT] + CONTACT_SIZE * k + TANGENTS], modes[k]
        rough = T[T[KIND] + KIND_SIZE * k + ROUGH]
        if mode == OPEN:
            hidden = dead[k] != 0 or elsewhere(T, modes, k) != 0
            i = set_ending(T, i, NEVER if hidden else GAP, 0)
        else:
            i = set_ending(T, i, NEVER if T[T[KIND] + KIND_SIZE * k + HELD] != 0 else NORMAL, 0)
        law, sign, last = NEVER, 0, NEVER
        if mode == STICK:
            law, sign, last = LINE_CONE if n == 1 else (CONE if n == 2 else NEVER), 1, LINE_CONE
        elif (mode == SLIDE_ON or mode == SLIDE_BACK) and dead[k] == 0:  # noqa: SIM109
            law, sign = LINE_STOP, 1 if mode == SLIDE_ON else -1
        elif mode == SLIDE and n == 2 and rough != 0:
            law = STOP
        if n > 0:
            i = set_ending(T, i, law, sign)
        if n == 1:
            i = set_ending(T, i, last, -1)
        while i < T[ENDINGS] and T[T[ENDING] + ENDING_SIZE * i + PLACE] >= 0:
            owner = T[T[ENDING] + ENDING_SIZE * i + CONTACT_OF]
            i = set_ending(T, i, NEVER if mode == OPEN else (REACH if owner == k else SIDE), 0)
