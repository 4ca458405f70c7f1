"""Walks over the links of a large tree, in the compiled language (docs/compiled-language.md).

    outward        poses and velocities, parents first
    inward         articulated inertias and forces, tips first
    final          accelerations, parents first

If accelerations are given,

    outward        accelerations too, and the wrenches that they need
    transmitted    wrenches, tips first

All numbers of a call stand in one workspace S. `tree_parts` knows their places, and the record of a tree
(`tree_record`) tells them to the code here, which is the same for every tree. The workspace belongs to the call, so
that any number of threads may call at once.

A number of S is one double, eight of states side by side, or either followed by its derivative along a direction:
`LANES` states, and `WIDTH` doubles a number.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir

from ...native.arithmetic import REAL, WHOLE, intrinsic, wide
from ...native.functions import Instruction, instruction
from ...native.instructions import Integers, Parts, Real, Reals, Row, numbers, shifted
from ..code.batch import deliver, gather, gather_parts
from .link_step import COMPOSITE, STEPS, SUM
from .tree_record import Copy, Product, Straight, Tree

# -- what a translation is made for ----------------------------------------------------------------------------------

walk = Parts()

# Bound by `functions`.
LANES = WIDTH = BY_LANE = ALONG = 0
workspace: Any = None
"""(count): memory for so many numbers, which `released` gives back."""
straight_code: Any = None
"""(address, S, c, out): call of straight code."""
outward_step: Any = None
inward_step: Any = None
final_step: Any = None
carried_step: Any = None
transmitted_step: Any = None
composed_step: Any = None
projected_step: Any = None
place_step: Any = None
moved_step: Any = None
pressed_step: Any = None

# -- one link after the other ----------------------------------------------------------------------------------------


@walk
def fetch(target: Row, S: Row, places: Integers, count: int) -> None:
    """Copy the numbers at places of S side by side."""
    for k in range(count):
        target[k] = S[places[k]]


@walk
def add(target: Row, source: Row, count: int) -> None:
    """Add numbers to others."""
    for k in range(count):
        target[k] = source[k] + target[k]


@walk
def clear(S: Row, first: int, end: int) -> None:
    """Set numbers to zero."""
    for k in range(first, end):
        S[k] = 0.0


@walk
def copy(S: Row, what: Copy) -> None:
    """Copy numbers to where straight code reads them."""
    fetch(shifted(S, what.target), S, what.sources, what.count)


@walk
def assign(S: Row, k: int, x: float) -> None:
    """Set number k in all lanes; its derivative is zero."""
    place = shifted(numbers(S), WIDTH * k)
    for lane in range(LANES):
        place[lane] = x
    for lane in range(LANES, WIDTH):
        place[lane] = 0.0


@walk
def run(part: Straight, S: Row, c: Reals, tree: Tree) -> None:
    """Run straight code."""
    if part.code != 0:
        straight_code(part.code, S, shifted(c, tree.straight_constants), shifted(S, part.target))


@walk
def turns(S: Row, c: Reals, tree: Tree) -> None:
    """Sines and cosines of the angles of the joints."""
    constants = shifted(c, tree.straight_constants)
    k = 0
    while k < tree.turning:
        for j in range(tree.block):
            S[tree.angles + j] = S[tree.turned[k + j]]
        straight_code(tree.turn.code, S, constants, shifted(S, tree.turn.target + 2 * k))
        k += tree.block


@walk.inlined
def gather_joint(S: Row, tree: Tree, i: int) -> None:
    """Copy the variables of joint i side by side."""
    first, joint = tree.joints[i], shifted(S, tree.joint)
    for k in range(tree.joints[i + 1] - first):
        joint[k] = S[tree.variables[first + k]]


@walk
def outward(S: Row, c: Reals, tree: Tree, posed: int) -> None:
    """Poses and velocities, parents first; with given accelerations, those of the links too."""
    joint = shifted(S, tree.joint)
    for i in range(tree.links):
        gather_joint(S, tree, i)
        constants = shifted(c, tree.constants[i])
        link, second = shifted(S, tree.record[i]), shifted(S, tree.second[i])
        parent = shifted(S, tree.parent[i])
        if tree.given != 0:
            own, above = shifted(S, tree.own[i]), shifted(S, tree.above[i])
            carried_step(tree.carried[i], S, joint, constants, link, above, own)
        if tree.given == 0 or posed != 0:
            outward_step(tree.outward[i], S, joint, constants, link, parent, second)
        if posed != 0:
            place_step(tree.place[i], S, link, constants, second, shifted(S, tree.parents_second[i]))


@walk
def inward(S: Row, c: Reals, tree: Tree) -> None:
    """Articulated inertias and forces, tips first."""
    joint = shifted(S, tree.joint)
    for i in range(tree.links - 1, -1, -1):
        gather_joint(S, tree, i)
        link, constants = shifted(S, tree.record[i]), shifted(c, tree.constants[i])
        passed, tips = shifted(S, tree.passed[i]), shifted(S, tree.tips[i])
        inward_step(tree.inward[i], S, link, constants, passed, joint, tips, link)
        if tree.added[i] >= 0:
            add(shifted(S, tree.added[i]), passed, SUM)


@walk
def final(S: Row, c: Reals, tree: Tree) -> None:
    """Accelerations, parents first."""
    joint = shifted(S, tree.joint)
    for i in range(tree.links):
        gather_joint(S, tree, i)
        link, constants = shifted(S, tree.record[i]), shifted(c, tree.constants[i])
        own, above = shifted(S, tree.own[i]), shifted(S, tree.above[i])
        final_step(tree.final[i], S, link, constants, own, joint, above, link)


@walk
def transmitted(S: Row, c: Reals, tree: Tree) -> None:
    """Wrenches that give these accelerations, tips first."""
    for i in range(tree.links - 1, -1, -1):
        link, constants = shifted(S, tree.record[i]), shifted(c, tree.constants[i])
        passed, tips, second = (
            shifted(S, tree.passed[i]),
            shifted(S, tree.tips[i]),
            shifted(S, tree.second[i]),
        )
        transmitted_step(tree.transmitted[i], S, link, constants, passed, tips, second)
        if tree.added[i] >= 0:
            add(shifted(S, tree.added[i]), passed, 6)


@walk
def composed(S: Row, c: Reals, tree: Tree) -> None:
    """Composite inertias, and the momenta of the joints' motions, tips first."""
    for i in range(tree.links - 1, -1, -1):
        link, constants = shifted(S, tree.record[i]), shifted(c, tree.constants[i])
        passed, tips = shifted(S, tree.passed[i]), shifted(S, tree.tips[i])
        composed_step(tree.composed[i], S, link, constants, passed, tips, link)
        if tree.added[i] >= 0:
            add(shifted(S, tree.added[i]), passed, COMPOSITE)


@walk
def matrix(S: Row, c: Reals, tree: Tree, speeds: int) -> None:
    """Mass matrix: the momentum of each motion, from link to link inward, along the motions of each."""
    clear(S, tree.matrix, tree.matrix + speeds * speeds)
    for i in range(tree.links):
        for k in range(tree.freedoms[i + 1] - tree.freedoms[i]):
            motion = tree.freedoms[i] + k
            momentum, passed, link = tree.momenta[motion], tree.projection, i
            while link >= 0:
                record, constants = shifted(S, tree.record[link]), shifted(c, tree.constants[link])
                own, second = shifted(S, momentum), shifted(S, tree.second[link])
                projected_step(tree.projected[link], S, record, constants, shifted(S, passed), own, second)
                if link == i:
                    second[tree.along + k] = second[tree.along + k] + S[tree.armature[motion]]
                entries(S, c, tree, i, k, link, speeds)
                momentum = passed
                passed = 2 * tree.projection + 6 - passed
                link = tree.parents[link]


@walk
def entries(S: Row, c: Reals, tree: Tree, i: int, motion: int, inner: int, speeds: int) -> None:
    """Entries of a motion of link i with those of a link inward of it, or of itself."""
    for a in range(tree.moves[i], tree.moves[i + 1]):
        if tree.motions[a] == motion:
            for b in range(tree.moves[inner], tree.moves[inner + 1]):
                x = tree.second[inner] + tree.along + tree.motions[b]
                if tree.weights[a] >= 0 or tree.weights[b] >= 0:
                    weight(S, tree.totals, tree.weights[a])
                    weight(S, tree.totals + 1, tree.weights[b])
                    S[tree.totals + 2] = S[x]
                    run(tree.product, S, c, tree)
                    x = tree.product.target
                row, column, first = tree.speeds[a], tree.speeds[b], tree.matrix
                S[first + speeds * row + column] = S[first + speeds * row + column] + S[x]
                if inner != i:
                    S[first + speeds * column + row] = S[first + speeds * column + row] + S[x]


@walk
def weight(S: Row, target: int, place: int) -> None:
    """Copy the weight of a motion; it is 1 where it has no place."""
    if place < 0:
        assign(S, target, 1.0)
    else:
        S[target] = S[place]


@walk
def pressed(S: Row, c: Reals, tree: Tree) -> None:
    """Wrench of each joint, in ground axes."""
    for i in range(tree.links):
        second = shifted(S, tree.second[i])
        own, tips = shifted(S, tree.own[i]), shifted(S, tree.tips[i])
        link, constants = shifted(S, tree.record[i]), shifted(c, tree.constants[i])
        pressed_step(tree.pressed[i], S, link, constants, second, own, tips, second)


@walk
def moved(S: Row, c: Reals, tree: Tree, momenta: int) -> None:
    """Velocities and momentum of each link; with ``momenta``, those of all links are added up."""
    for i in range(tree.links):
        second = shifted(S, tree.second[i])
        link, constants = shifted(S, tree.record[i]), shifted(c, tree.constants[i])
        moved_step(tree.moved[i], S, link, constants, second, second)
        if momenta != 0:
            add(shifted(S, tree.totals), shifted(second, tree.momentum), 6)


@walk
def energies(S: Row, tree: Tree) -> None:
    """Kinetic energies and first moments, added up."""
    for i in range(tree.links):
        add(shifted(S, tree.totals), shifted(S, tree.second[i] + tree.kinetic), 4)


# -- from time and state in S to the outputs -------------------------------------------------------------------------


@walk
def begin(S: Row, c: Reals, tree: Tree, state: int) -> None:
    """Set what does not depend on the links: zeros, the ground, joint variables."""
    clear(S, 0, 1)
    clear(S, 2 + state, 2 + tree.inputs)
    clear(S, tree.cleared, tree.kept)
    clear(S, tree.ground, tree.ground_end)
    clear(S, tree.at_rest, tree.at_rest_end)
    for k in range(3):
        assign(S, tree.ground_axes + 4 * k, 1.0)
    run(tree.front, S, c, tree)
    turns(S, c, tree)
    copy(S, tree.gravity)


@walk
def compute(S: Row, c: Reals, tree: Tree, of: Product) -> None:
    """Compute the outputs in S from time and state in S."""
    begin(S, c, tree, of.state)
    outward(S, c, tree, of.posed)
    if of.early != 0:
        copy(S, tree.early)
    if of.moving != 0:
        run(tree.loads, S, c, tree)
        for k in range(tree.loaded.count):
            link = tree.loaded_links[k]
            S[link] = S[link] - S[tree.loaded.sources[k]]
        # wrenches follow from given accelerations, or accelerations from articulated inertias
        if tree.given != 0:
            transmitted(S, c, tree)
        else:
            inward(S, c, tree)
            final(S, c, tree)
    if of.composed != 0:
        composed(S, c, tree)
        matrix(S, c, tree, tree.order)
    if of.pressed != 0:
        pressed(S, c, tree)
    if of.finished != 0:
        copy(S, tree.late)
        run(tree.finish, S, c, tree)
    if of.speeds != 0:
        clear(S, tree.totals, tree.totals + 6)
        moved(S, c, tree, of.momenta)
    if of.energies != 0:
        clear(S, tree.totals, tree.totals + 4)
        energies(S, tree)
        run(tree.energy, S, c, tree)


# -- kernels ---------------------------------------------------------------------------------------------------------


@walk
def one(t: Real, y: Row, c: Reals, out: Row, of: Product) -> None:
    """Outputs of one state, or of a state for each lane."""
    tree = of.tree
    S = workspace(tree.numbers)
    S[1] = t
    for k in range(of.state):
        S[2 + k] = y[k]
    compute(S, c, tree, of)
    fetch(out, S, of.outputs, of.count)
    released(S)


@walk
def several(t: Row, y: Row, c: Reals, out: Row, of: Product) -> None:
    """Outputs of a state for each lane."""
    one(t[0], y, c, out, of)


@walk
def batch(n: int, t: Reals, ts: int, arrays: Integers, c: Reals, cs: int, out: Reals, of: Product) -> None:
    """Outputs of n rows. The steps are 1 and the length of c, or 0 if all rows share t or c."""
    tree = of.tree
    S = workspace(tree.numbers + BY_LANE * tree.hoisted)
    row = 0
    while row < n:
        gather(t, row, n, 1, ts, shifted(S, 1))
        gather_parts(arrays, row, n, of.state, shifted(S, 2))
        if BY_LANE:
            if row == 0 or cs != 0:
                gather(c, row, n, tree.hoisted, cs, shifted(S, tree.numbers))
            compute(S, numbers(shifted(S, tree.numbers)), tree, of)
        else:
            compute(S, shifted(c, row * cs), tree, of)
        deliver(S, of.outputs, row, n, of.count, out)
        row += LANES
    released(S)


@walk
def derivative(t: float, y: Reals, c: Reals, out: Reals, of: Product) -> None:
    """Derivatives of the outputs: by some numbers of the state, a column for each lane, or along one direction."""
    tree = of.tree
    S = workspace(tree.numbers)
    for j in range(0, of.columns, LANES):
        assign(S, 1, t)
        for k in range(of.state):
            assign(S, 2 + k, y[k])
            rates = shifted(numbers(S), WIDTH * (2 + k) + LANES)
            if ALONG:
                rates[0] = y[of.first + k]
            elif j <= k - of.first < j + LANES and k - of.first < of.columns:
                rates[k - of.first - j] = 1.0
        compute(S, c, tree, of)
        for k in range(of.count):
            rates = shifted(numbers(S), WIDTH * of.outputs[k] + LANES)
            for lane in range(LANES):
                if j + lane < of.columns:
                    out[of.columns * k + j + lane] = rates[lane]
    released(S)


@walk
def rows(n: int, t: Reals, ts: int, arrays: Integers, c: Reals, cs: int, out: Reals, of: Product) -> None:
    """Matrices of n rows, one after the other. The steps are as in `batch`."""
    y = workspace(of.state + ALONG * of.state)
    for i in range(n):
        gather_parts(arrays, i, n, of.state + ALONG * of.state, numbers(y))
        derivative(t[i * ts], numbers(y), shifted(c, i * cs), shifted(out, i * of.count * of.columns), of)
    released(y)


# -- translations ----------------------------------------------------------------------------------------------------


@instruction("Row")
def released(builder: Any, S: Any) -> None:
    """Give the memory of a workspace back."""
    begin = builder.bitcast(S, ir.IntType(8).as_pointer().as_pointer())
    intrinsic(builder, "free", ir.VoidType(), builder.load(builder.gep(begin, [WHOLE(-1)])))


def memory(width: int) -> Instruction:
    """Return the instruction that takes memory for so many numbers; its address is a multiple of their size.

    The address that `released` needs stands before the first number.
    """
    size = 8 * width
    line = max(64, size)
    kind = wide(REAL, width).as_pointer()

    @instruction("int")
    def workspace(builder: Any, count: Any) -> Any:
        byte = ir.IntType(8).as_pointer()
        bytes_ = builder.add(builder.mul(count, WHOLE(size)), WHOLE(line + 8))
        begin = intrinsic(builder, "malloc", byte, bytes_)
        place = builder.add(builder.ptrtoint(begin, WHOLE), WHOLE(line + 7))
        first = builder.inttoptr(builder.and_(place, WHOLE(-line)), byte.as_pointer())
        builder.store(begin, builder.gep(first, [WHOLE(-1)]))
        return builder.bitcast(first, kind)

    return workspace


def called(arrays: int, single: bool, timed: bool = False) -> Instruction:
    """Return the instruction that calls code at an address with S, then with as many arrays.

    The code takes the time before its arrays: a number in the code of one state, else a pointer to S. Steps do not read
    it; it is number 1 of S.
    """

    def call(builder: Any, address: Any, S: Any, *values: Any) -> None:
        time = builder.gep(S, [WHOLE(1)]) if timed else S
        if single:
            number = builder.bitcast(time, REAL.as_pointer())
            time = builder.load(number) if timed else REAL(0.0)
        values = (S, *values) if timed else values
        kind = ir.FunctionType(ir.VoidType(), [time.type, *(value.type for value in values)])
        builder.call(builder.inttoptr(address, kind.as_pointer()), [time, *values])

    return Instruction(call, "int", "Row", *[""] * arrays)


def functions(lanes: int, derivatives: bool, by_lane: bool, along: bool) -> dict[str, Any]:
    """Return the functions of this module for so many states at once, by name.

    With ``derivatives``, each number is followed by its derivative, ``along`` a direction or by numbers of the state.
    With ``by_lane``, each lane has constants of its own.
    """
    width = lanes * (1 + derivatives)
    steps = {
        f"{name}_step": called(len(reads) + len(writes) + 1, lanes == 1)
        for name, (reads, writes) in STEPS.items()
    }
    space = {
        **globals(), **steps, "LANES": lanes, "WIDTH": width, "BY_LANE": int(by_lane), "ALONG": int(along),
        "workspace": memory(width), "straight_code": called(2, lanes == 1, timed=True),
    }  # fmt: skip
    return walk.bound(space)
