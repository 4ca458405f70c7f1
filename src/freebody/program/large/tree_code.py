"""Code of a looped tree: its records, and kernels that call the walks of `tree_walk` with them.

The walks are the same for all trees, and compiled once. A kernel adds the address of its record to its arguments.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...model.model import GROUND
from ...native import codegen
from ...native.loop import Loop, made, module_named
from . import link_step
from .link_step import SECOND
from .tree_parts import Parts
from .tree_walk import Copy, Product, Straight, Tree

ARGUMENTS = {
    "one": "double %t, ptr %y, ptr %c, ptr %out", "several": "ptr %t, ptr %y, ptr %c, ptr %out",
    "batch": "i64 %n, ptr %t, i64 %ts, ptr %arrays, ptr %c, i64 %cs, ptr %out",
}  # fmt: skip
ARGUMENTS |= dict.fromkeys(("mass_matrix", "derivative"), ARGUMENTS["one"]) | {"rows": ARGUMENTS["batch"]}
"""Arguments of the walks, without the record."""


def entries(parts: Parts) -> tuple[str, list[Any]]:
    """Return the text of the kernels of a tree, and what must live as long as they do."""
    tree, products, lines = tree_of(parts), [], []
    loop = walks(parts)
    for name, outputs in parts.outputs.items():
        product = product_of(parts, tree, name)
        products.append(product)
        for symbol, walk in symbols(parts, name).items():
            body = ""
            if outputs:
                address = loop.functions[walk].address
                body = f"  tail call void inttoptr (i64 {address} to ptr)({ARGUMENTS[walk]}, "
                body += f"ptr inttoptr (i64 {product.address} to ptr))\n"
            lines.append(f"define void @{symbol}({ARGUMENTS[walk]}) nounwind {{\n{body}  ret void\n}}\n")
    head = f'target triple = "{codegen.processor()[0]}"\ntarget datalayout = "{codegen.layout()}"\n'
    return head + "".join(lines), [tree, *products, loop]


def symbols(parts: Parts, name: str) -> dict[str, str]:
    """Return the names of a kernel and of its form for rows, with the walk of each."""
    if name == "column":
        return {"mass_matrix": "mass_matrix", "mass_matrix.batch": "rows"}
    if parts.directions is not None:
        kernel = "f" if parts.directions.columns else "tangent"
        return {kernel: "derivative", f"{kernel}.batch": "rows"} if name == parts.directions.kernel else {}
    if parts.lanes == 1:
        return {name: "one", f"{name}.batch": "batch"}
    return {f"{name}.lanes": "several", f"{name}.batch": "batch"}


def walks(parts: Parts) -> Loop:
    """Return the compiled walks for the numbers of a tree."""
    by_lane = parts.lanes > 1 and not parts.shared
    derivatives, along = parts.directions is not None, parts.directions is not None and not parts.directions.columns
    kind = "derivative" if derivatives else "mass_matrix" if "column" in parts.outputs else ""
    names = (kind, "rows") if kind else ("one" if parts.lanes == 1 else "several", "batch")
    place = f"{__name__.partition('.')[2].rpartition('.')[0]}.tree_walk"
    return made(
        f"{place} {parts.lanes} {kind} {by_lane} {along}", (place,), names,
        lambda: module_named(place).functions(parts.lanes, derivatives, by_lane, along),
        lanes=parts.lanes * (1 + derivatives),
    )  # fmt: skip


def tree_of(parts: Parts) -> Tree:
    """Return the record of a tree."""
    links = parts.model.links
    above = [-1 if link.parent == GROUND else link.parent for link in links]
    each = range(len(links))
    factor = parts.lanes if parts.lanes > 1 and not parts.shared else 1  # doubles of a constant
    tree = Tree.made()
    tree.links, tree.size, tree.inputs, tree.hoisted = len(links), parts.size, parts.inputs, parts.hoisted
    tree.given = int(parts.back)
    outward, inward, final = parts.loops
    steps = {"outward": outward, "inward": inward, "final": final, "place": "place", "moved": "moved", "pressed": "pressed"}
    for name, step in steps.items():
        setattr(tree, name, _whole(parts.step(i)[step].address for i in each))
    tree.constants = _whole(factor * x for x in parts.offsets)
    tree.joints = _whole(np.cumsum([0, *map(len, parts.joints)]))
    tree.variables = _whole(place for joint in parts.joints for place in joint)
    tree.tips, tree.passed, tree.added = map(_whole, (parts.sums.of, parts.sums.passed, parts.sums.added))
    tree.record = _whole(parts.at(i, link_step.V) for i in each)
    tree.parent = _whole(parts.sums.cleared if i < 0 else parts.at(i, link_step.V) for i in above)
    tree.own = _whole(parts.accelerations[i] for i in each)
    tree.above = _whole(parts.accelerations[i] for i in above)
    tree.second = _whole(parts.at(i, SECOND) for i in each)
    tree.parents_second = _whole(parts.at(i, SECOND) for i in above)
    tree.joint, tree.totals, tree.at_rest = parts.joint, parts.totals, parts.accelerations[-1]
    tree.cleared, tree.kept = parts.sums.cleared, parts.sums.aside
    tree.ground, tree.ground_end = parts.base, parts.base + link_step.WIDTH
    tree.ground_axes = parts.at(-1, link_step.PLACE)
    tree.kinetic, tree.momentum = link_step.KINETIC - SECOND, link_step.MOMENTUM - SECOND
    tree.straight_constants = factor * parts.straight_offset
    for name in ("front", "loads", "finish", "energy"):
        part: Straight = getattr(tree, name)
        part.code = 0 if name in parts.empty else parts.straight[name].address
        part.target = parts.start[name]
    first, fetched = 2 + parts.inputs, [parts.at(i, k) for i, k in parts.fetched]
    early = parts.loads_end - first
    _set(tree.gravity, parts.ground, tree.at_rest + 3)
    _set(tree.early, fetched[:early], first)
    _set(tree.late, fetched[early:], parts.loads_end)
    _set(tree.loaded, [load for _, load in parts.pressed], 0)
    tree.loaded_links = _whole(link for link, _ in parts.pressed)
    return tree


def product_of(parts: Parts, tree: Tree, name: str) -> Product:
    """Return the record of a kernel."""
    product = Product.made()
    product.tree, product.state = tree.address, parts.states[name]
    product.outputs, product.count = _whole(parts.outputs[name]), len(parts.outputs[name])
    reactions = name == "reactions"
    moving = name in ("rates", "accelerations") or reactions or parts.back
    motion = name in ("poses", "postures", "velocities", "momentum")
    product.placed = int(not moving or reactions or parts.placed)
    product.early = int(not motion)
    product.moving, product.pressed, product.finished = int(moving), int(reactions), int(moving or name == "jacobian")
    product.speeds, product.momenta = int(name in ("velocities", "momentum")), int(name == "momentum")
    product.energies = int(name.endswith("energy"))
    if name == "column":
        product.columns = product.count
        product.first = 2 + parts.inputs - product.count
        product.state = parts.inputs - 2 * product.count
    elif parts.directions is not None:
        product.first, product.columns = parts.directions.first, parts.directions.columns or 1
    return product


def _set(copy: Copy, sources: Sequence[int], target: int) -> None:
    copy.count, copy.sources, copy.target = len(sources), _whole(sources), target


def _whole(values: Any) -> Any:
    return np.fromiter(values, dtype=np.int64)
