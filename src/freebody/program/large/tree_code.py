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
from .link_moves import Moves
from .link_step import SECOND, STEPS
from .tree_parts import Parts
from .tree_record import Product

ARGUMENTS = {
    "one": "double %t, ptr %y, ptr %c, ptr %out", "several": "ptr %t, ptr %y, ptr %c, ptr %out",
    "batch": "i64 %n, ptr %t, i64 %ts, ptr %arrays, ptr %c, i64 %cs, ptr %out",
}  # fmt: skip
ARGUMENTS |= {"derivative": ARGUMENTS["one"], "rows": ARGUMENTS["batch"]}
"""Arguments of the walks, without the record."""


def entries(parts: Parts) -> tuple[str, list[Any]]:
    """Return the text of the kernels of a tree, and what must live as long as they do."""
    tree, loop = places(parts), walks(parts)
    products, lines = [], []
    for name, outputs in parts.outputs.items():
        record = Product.made()
        _fill(record, {"tree": tree, **product(parts, name)})
        products.append(record)
        for symbol, walk in symbols(parts, name).items():
            body = ""
            if outputs:
                address = loop.functions[walk].address
                body = f"  tail call void inttoptr (i64 {address} to ptr)({ARGUMENTS[walk]}, "
                body += f"ptr inttoptr (i64 {record.address} to ptr))\n"
            lines.append(f"define void @{symbol}({ARGUMENTS[walk]}) nounwind {{\n{body}  ret void\n}}\n")
    head = f'target triple = "{codegen.processor()[0]}"\ntarget datalayout = "{codegen.layout()}"\n'
    return head + "".join(lines), [*products, loop]


def symbols(parts: Parts, name: str) -> dict[str, str]:
    """Return the names of a kernel and of its form for rows, with the walk of each."""
    if parts.directions is not None:
        kernel = "f" if parts.directions.columns else "tangent"
        return {kernel: "derivative", f"{kernel}.batch": "rows"} if name == parts.directions.kernel else {}
    if parts.lanes == 1:
        return {name: "one", f"{name}.batch": "batch"}
    return {f"{name}.lanes": "several", f"{name}.batch": "batch"}


def walks(parts: Parts) -> Loop:
    """Return the compiled walks for the numbers of a tree."""
    by_lane = parts.lanes > 1 and not parts.shared
    derivatives, along = (
        parts.directions is not None,
        parts.directions is not None and not parts.directions.columns,
    )
    kind = "derivative" if derivatives else "one" if parts.lanes == 1 else "several"
    names = (kind, "rows" if derivatives else "batch")
    place = f"{__name__.partition('.')[2].rpartition('.')[0]}.tree_walk"
    return made(
        f"{place} {parts.lanes} {kind} {by_lane} {along}", (place,), names,
        lambda: module_named(place).functions(parts.lanes, derivatives, by_lane, along),
        lanes=parts.lanes * (1 + derivatives),
    )  # fmt: skip


def places(parts: Parts) -> dict[str, Any]:
    """Return the values of the fields of `tree_record.Tree`."""
    links = parts.model.links
    above = [-1 if link.parent == GROUND else link.parent for link in links]
    each = range(len(links))
    factor = parts.lanes if parts.lanes > 1 and not parts.shared else 1  # doubles of a constant
    codes = {
        name: [parts.step(i)[name].address if name in parts.loops else 0 for i in each] for name in STEPS
    }
    of_links = codes | ({} if parts.moves is None else _moves(parts, parts.moves)) | {
        "constants": [factor * x for x in parts.offsets],
        "joints": np.cumsum([0, *map(len, parts.joints)]),
        "variables": [place for joint in parts.joints for place in joint],
        "tips": parts.sums.of, "passed": parts.sums.passed, "added": parts.sums.added,
        "record": [parts.at(i, link_step.V) for i in each],
        "parent": [parts.sums.cleared if i < 0 else parts.at(i, link_step.V) for i in above],
        "own": [parts.accelerations[i] for i in each],
        "above": [parts.accelerations[i] for i in above],
        "second": [parts.at(i, SECOND) for i in each],
        "parents_second": [parts.at(i, SECOND) for i in above],
        "loaded_links": [link for link, _ in parts.pressed],
    }  # fmt: skip
    straight = {
        name: {
            "code": 0 if name in parts.empty else parts.straight[name].address,
            "target": parts.start[name],
        }
        for name in ("front", "loads", "finish", "energy", "product", "turn")
    }
    straight["turn"]["target"] = parts.sines
    at_rest, first = parts.accelerations[-1], 2 + parts.inputs
    fetched = [parts.at(i, k) for i, k in parts.fetched]
    early = parts.loads_end - first
    return {
        "links": len(links), "numbers": parts.size, "inputs": parts.inputs, "hoisted": parts.hoisted,
        "given": int(parts.back), "joint": parts.joint, "cleared": parts.sums.cleared,
        # links that move in a plane leave out what stands across it
        "kept": parts.sums.aside if parts.normal < 0 else parts.sums.end,
        "ground": parts.base, "ground_end": parts.base + (link_step.WIDTH if "place" in parts.loops else 0),
        "ground_axes": parts.at(-1, link_step.PLACE), "at_rest": at_rest,
        "at_rest_end": at_rest + (link_step.MOVING if parts.back else 6), "totals": parts.totals,
        "kinetic": link_step.KINETIC - SECOND, "momentum": link_step.MOMENTUM - SECOND,
        "along": link_step.ALONG - SECOND, "matrix": parts.matrix, "order": parts.model.n_u,
        "projection": parts.momentum, "turned": _whole(parts.turned), "turning": len(parts.turned),
        "block": parts.block, "angles": parts.angles,
        "straight_constants": factor * parts.straight_offset,
        "gravity": _copy(parts.ground, at_rest + 3), "early": _copy(fetched[:early], first),
        "late": _copy(fetched[early:], parts.loads_end), "loaded": _copy([load for _, load in parts.pressed], 0),
        **straight, **{name: _whole(numbers) for name, numbers in of_links.items()},
    }  # fmt: skip


def product(parts: Parts, name: str) -> dict[str, Any]:
    """Return the values of the other fields of `tree_record.Product` for a kernel."""
    outputs, state, first, columns = parts.outputs[name], parts.states[name], 0, 0
    reactions, speeds = name == "reactions", name in ("velocities", "momentum")
    moving = name in ("rates", "accelerations") or reactions or parts.back
    composed = name == "mass_matrix"
    if parts.directions is not None:
        first, columns = parts.directions.first, parts.directions.columns or 1
    return {
        "state": state, "outputs": _whole(outputs), "count": len(outputs), "first": first, "columns": columns,
        "posed": int(not (moving or composed) or reactions or parts.placed), "moving": int(moving),
        "pressed": int(reactions), "composed": int(composed),
        "early": int(not speeds and name not in ("poses", "postures")),
        "finished": int(moving or name in ("jacobian", "moving")), "speeds": int(speeds),
        "momenta": int(name == "momentum"),
        "energies": int(name.endswith("energy")),
    }  # fmt: skip


def _moves(parts: Parts, moves: Moves) -> dict[str, Any]:
    """Return the values of the fields of the mass matrix."""
    links = parts.model.links
    return {
        "parents": [-1 if link.parent == GROUND else link.parent for link in links],
        "moves": moves.first, "speeds": moves.speeds, "motions": moves.motions, "weights": moves.weights,
        "freedoms": np.cumsum([0, *map(len, moves.armature)]),
        "momenta": [
            parts.at(i, parts.kinds[i].solved) + 6 * k for i, a in enumerate(moves.armature) for k in range(len(a))
        ],
        "armature": [place for armature in moves.armature for place in armature],
    }  # fmt: skip


def _copy(sources: Sequence[int], target: int) -> dict[str, Any]:
    return {"count": len(sources), "sources": _whole(sources), "target": target}


def _whole(numbers: Any) -> Any:
    return np.array(numbers, dtype=np.int64)


def _fill(record: Any, values: dict[str, Any]) -> None:
    for name, value in values.items():
        if isinstance(value, dict):
            _fill(getattr(record, name), value)
        else:
            setattr(record, name, value)
