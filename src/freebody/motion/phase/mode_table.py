"""The part of a phase's table that depends on the modes (`places`), written in compiled code."""

from __future__ import annotations

from ...native.instructions import Integers, Reals, bits, call, compiled, inlined, integers_at, shifted
from . import places


@compiled
def table(c: Reals) -> Integers:
    """Return the table of integers of a phase.

    It is not inlined: LLVM's fast selection of instructions takes the register of such a pointer for free after its
    first use in the same block.
    """
    return integers_at(bits(c[0]))


@inlined
def evaluated(t: float, y: Reals, c: Reals, T: Integers) -> None:
    """Call the kernel of the machine."""
    call(T[places.MACHINE], t, y, 0, shifted(c, T[places.CONSTANTS]), c, T[places.MACHINE_AT])


@compiled
def direction_kind(T: Integers, k: int, mode: int) -> int:
    """Return the kind of direction in which friction acts on a contact."""
    result = places.NO_SLIP
    if T[T[places.KIND] + places.KIND_SIZE * k + places.ROUGH] != 0:
        if mode == places.SLIDE:
            result = places.ALONG
        elif mode == places.SLIDE_ON:
            result = places.PLUS
        elif mode == places.SLIDE_BACK:
            result = places.MINUS
        elif mode == places.LIMIT:
            result = places.FIXED
    return result


@compiled
def conditions_of(tangents: int, mode: int, held: int) -> int:
    """Return the number of conditions of a contact; its normal is none if it is ``held``."""
    if mode == places.OPEN:
        return 0
    return 1 - held + (tangents if mode == places.STICK else 0)


@compiled
def set_modes(T: Integers, modes: Integers, dead: Integers, active: Integers, count: int) -> None:
    """Write the conditions and the endings of these modes.

    ``active``    the independent ones among the ``count`` conditions of contacts that are; those of the machine are so
    ``dead``      1 for each contact that the others hold in place: the end of its mode is not watched
    """
    own, n = T[places.OWN], T[places.N_U]
    for i in range(own):
        set_condition(T, i, -1 - i, 0, places.NO_SLIP)
    at, slipping = own, 0
    for k in range(T[places.CONTACTS]):
        slip, held = direction_kind(T, k, modes[k]), T[T[places.KIND] + places.KIND_SIZE * k + places.HELD]
        T[T[places.KIND] + places.KIND_SIZE * k + places.PUSHED] = slip if held != 0 else places.NO_SLIP
        normal = at
        for j in range(
            conditions_of(T[T[places.CONTACT] + places.CONTACT_SIZE * k + places.TANGENTS], modes[k], held)
        ):
            set_condition(T, at, k, j + held, slip)
            one = T[places.CONDITION] + places.CONDITION_SIZE * at
            if j > 0 and held == 0:
                T[one + places.NORMAL_OF] = normal
            if slip != places.NO_SLIP:
                T[one + places.FORCE_ROW] = T[places.K_AT] + slipping * n
                slipping += 1
            at += 1
    T[places.CONDITIONS], T[places.ACTIVE], T[places.SLIPPING] = at, own + count, 1 if slipping > 0 else 0
    independent, holonomic = shifted(T, T[places.INDEPENDENT]), shifted(T, T[places.HOLONOMIC])
    holonomic[0] = 0
    for i in range(own + count):
        independent[i] = i if i < own else own + active[i - own]
        one = T[places.CONDITION] + places.CONDITION_SIZE * independent[i]
        if T[T[places.OWN_HOLONOMIC] + i] != 0 if i < own else T[one + places.ROW_OF] == 0:
            holonomic[0] += 1
            holonomic[holonomic[0]] = independent[i]
    if T[places.ENDINGS] > 0:
        set_endings(T, modes, dead)
    set_closed(T, modes)


@compiled
def set_condition(T: Integers, i: int, source: int, row: int, slip: int) -> None:
    """Write a condition without a row of K of its own."""
    one = T[places.CONDITION] + places.CONDITION_SIZE * i
    T[one + places.SOURCE], T[one + places.ROW_OF], T[one + places.SLIP], T[one + places.NORMAL_OF] = (
        source,
        row,
        slip,
        -1,
    )
    T[one + places.FORCE_ROW] = T[places.Y_AT] + i * T[places.N_U]


@compiled
def set_closed(T: Integers, modes: Integers) -> None:
    """List the closed contacts, and the open ones."""
    called, watched = shifted(T, T[places.CALLED]), shifted(T, T[places.WATCHED])
    called[0], watched[0] = 0, 0
    for k in range(T[places.CONTACTS]):
        if modes[k] != places.OPEN:
            called[0] += 1
            called[called[0]] = k
        else:
            watched[0] += 1
            watched[watched[0]] = k


# -- endings ---------------------------------------------------------------------------------------------


@compiled
def elsewhere(T: Integers, modes: Integers, k: int) -> int:
    """Return 1 if the foot is on the side that this corner ends, or on a corner of this side; else 0."""
    side = T[T[places.KIND] + places.KIND_SIZE * k + places.SIDE_OF]
    if side >= 0 and modes[side] != places.OPEN:
        return 1
    if T[T[places.CONTACT] + places.CONTACT_SIZE * k + places.REACHES] > 0:
        for j in range(T[places.CONTACTS]):
            if T[T[places.KIND] + places.KIND_SIZE * j + places.SIDE_OF] == k and modes[j] != places.OPEN:
                return 1
    return 0


@compiled
def set_ending(T: Integers, i: int, law: int, sign: int) -> int:
    """Write the law of an ending; return the number of the next."""
    (
        T[T[places.ENDING] + places.ENDING_SIZE * i + places.LAW],
        T[T[places.ENDING] + places.ENDING_SIZE * i + places.SIGN],
    ) = law, sign
    return i + 1


@compiled
def set_endings(T: Integers, modes: Integers, dead: Integers) -> None:
    """Write the laws of the endings of every contact, in the order of :func:`freebody.motion.phase.scene.endings`."""
    i = 0
    for k in range(T[places.CONTACTS]):
        n, mode = T[T[places.CONTACT] + places.CONTACT_SIZE * k + places.TANGENTS], modes[k]
        rough = T[T[places.KIND] + places.KIND_SIZE * k + places.ROUGH]
        if mode == places.OPEN:
            hidden = dead[k] != 0 or elsewhere(T, modes, k) != 0
            i = set_ending(T, i, places.NEVER if hidden else places.GAP, 0)
        else:
            i = set_ending(
                T,
                i,
                places.NEVER
                if T[T[places.KIND] + places.KIND_SIZE * k + places.HELD] != 0
                else places.NORMAL,
                0,
            )
        law, sign, last = places.NEVER, 0, places.NEVER
        if mode == places.STICK:
            law, sign, last = (
                places.LINE_CONE if n == 1 else (places.CONE if n == 2 else places.NEVER),
                1,
                places.LINE_CONE,
            )
        elif (mode == places.SLIDE_ON or mode == places.SLIDE_BACK) and dead[k] == 0:
            law, sign = places.LINE_STOP, 1 if mode == places.SLIDE_ON else -1
        elif mode == places.SLIDE and n == 2 and rough != 0:
            law = places.STOP
        if n > 0:
            i = set_ending(T, i, law, sign)
        if n == 1:
            i = set_ending(T, i, last, -1)
        while i < T[places.ENDINGS] and T[T[places.ENDING] + places.ENDING_SIZE * i + places.PLACE] >= 0:
            owner = T[T[places.ENDING] + places.ENDING_SIZE * i + places.CONTACT_OF]
            i = set_ending(
                T,
                i,
                places.NEVER if mode == places.OPEN else (places.REACH if owner == k else places.SIDE),
                0,
            )
