"""The loops over the links of a large tree as LLVM IR, for one state or for several side by side.

:mod:`freebody.program.large.tree_parts` decides the place of every number.

Every call has a workspace of its own, so that any number of threads may call at once. Places in the workspace, and
addresses of the steps and of the straight parts, are constants of the code or of the tables that it reads. A number is
one double, or a vector of one double for each lane; nothing else differs between the two.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...model.model import GROUND
from ...native import codegen
from ...native.ir_text import literal
from ..code import batch
from . import link_step
from .link_step import SECOND, STEPS, SUM, WIDTH
from .link_text import (
    ALONG,
    BATCH,
    BY,
    CALL,
    COLUMNS,
    DERIVATIVE,
    HELPERS,
    LOOP,
    NOTHING,
    ONE,
    ROW,
    ROWS,
    STARTS,
    VARY,
)
from .tree_parts import Parts


class Driver:
    """Writer of the loops as LLVM IR."""

    def __init__(self, parts: Parts) -> None:
        self.parts = parts
        self.lanes = parts.lanes
        self.count = len(parts.model.links)
        self.with_derivatives = parts.directions is not None
        self.width = self.lanes * (1 + self.with_derivatives)  # doubles of a number
        self.T = "double" if self.width == 1 else f"<{self.width} x double>"
        self.constants_by_lane = self.lanes > 1 and not parts.shared
        self.fill = {
            "T": self.T, "align": 8 * self.width, "C": self.T if self.constants_by_lane else "double",
            "time": "double 0.0" if self.lanes == 1 else "ptr %S",
        }  # fmt: skip
        self.steps = (*parts.loops, "place", "moved", "pressed")
        rows: list[int] = []
        joints: list[int] = []
        for i, link in enumerate(parts.model.links):
            step = parts.step(i)
            above = -1 if link.parent == GROUND else link.parent
            rows += [parts.offsets[i], len(joints), len(parts.joints[i])]
            rows += [parts.sums.of[i], parts.sums.passed[i], parts.sums.added[i]]
            rows += [
                parts.at(i, link_step.V),
                parts.sums.cleared if above < 0 else parts.at(above, link_step.V),
            ]
            rows += [parts.accelerations[i], parts.accelerations[above], parts.at(above, SECOND)]
            rows += [step[name].address for name in self.steps]
            joints += parts.joints[i]
        self.links, self.joints = parts.table(rows), parts.table(joints)

    def text(self) -> str:
        """Text of the module."""
        triple = codegen.processor()[0]
        head = f'target triple = "{triple}"\ntarget datalayout = "{codegen.layout()}"\n'
        widths = {self.lanes}
        if "column" in self.parts.outputs:
            functions = [self._mass_matrix()]
            widths.add(1)
        elif self.with_derivatives:
            functions = [self._derivative()]
            widths = {1}
        else:
            functions = [self._function(name) for name in self.parts.outputs]
        helpers = HELPERS.format(**self.fill)
        rows = {**batch.texts("deliver", self.lanes)}
        for lanes in sorted(widths):
            rows |= batch.texts("gather_parts", lanes)
        return "\n".join([head + helpers, *rows.values(), *self._loops(), *functions])

    def _function(self, name: str) -> str:
        """Kernel of one state (or of one state per lane) and of rows."""
        parts = self.parts
        outputs = parts.outputs[name]
        fill = {
            **self.fill, "name": name, "lanes": self.lanes, "state": parts.states[name], "outputs": len(outputs),
            "bytes": 8 * self.lanes * (parts.size + parts.hoisted * self.constants_by_lane) + 64,
            "constants": parts.size, "hoisted": parts.hoisted,
            "table": parts.table(outputs),
        }  # fmt: skip
        if not outputs:
            return NOTHING.format(**fill)
        fill |= {
            "symbol": name if self.lanes == 1 else f"{name}.lanes",
            "given": "double %t" if self.lanes == 1 else "ptr %tt",
            "moment": "" if self.lanes == 1 else f"  %t = load {self.T}, ptr %tt, align {8 * self.lanes}\n",
            "vary": VARY.format(**fill) if self.constants_by_lane else ONE.format(**fill),
        }
        return f"{self._core(name)}\n{CALL.format(**fill)}\n{BATCH.format(**fill)}"

    def _core(self, name: str) -> str:
        """Function that computes the outputs in S from time and state in S."""
        parts = self.parts
        reactions = name == "reactions"
        moving = name in ("rates", "accelerations") or reactions or parts.back
        placed = not moving or reactions or parts.placed
        lines = self._begun(f"{name}.core", parts.states[name])
        lines.append(f"  call void @outward.{'placed' if placed else 'plain'}(ptr %S, ptr %c)")
        fetched = [parts.at(i, k) for i, k in parts.fetched]
        first = 2 + parts.inputs
        early = parts.loads_end - first
        late = fetched[early:]
        if early and name not in ("poses", "postures", "velocities", "momentum"):
            lines.append(self._fetched("early", first, fetched[:early]))
        if moving:
            lines += self._straight("loads")
            if parts.pressed:
                targets = parts.table([a for a, _ in parts.pressed])
                sources = parts.table([b for _, b in parts.pressed])
                lines.append(
                    f"  call void @press(ptr %S, ptr inttoptr (i64 {targets} to ptr), "
                    f"ptr inttoptr (i64 {sources} to ptr), i64 {len(parts.pressed)})"
                )
            # accelerations follow from articulated inertias, or wrenches from accelerations
            order = ("final", "inward") if parts.back else ("inward", "final")
            lines += [f"  call void @{loop}(ptr %S, ptr %c)" for loop in order]
            if reactions:
                lines.append("  call void @pressed(ptr %S, ptr %c)")
            lines += self._finish(late)
        elif name == "jacobian":
            lines += self._finish(late)
        elif name in ("velocities", "momentum"):
            if name == "momentum":
                lines.append(self._zeros("sums", parts.totals, 6))
            loop = "momenta" if name == "momentum" else "moved"
            lines.append(f"  call void @{loop}(ptr %S, ptr %c)")
        elif name.endswith("energy"):
            lines.append(self._zeros("sums", parts.totals, 4))
            lines.append("  call void @sums(ptr %S, ptr %c)")
            lines += self._straight("energy")
        return "\n".join([*lines, "  ret void", "}", ""])

    def _finish(self, late: Sequence[int]) -> list[str]:
        """Fetch these places of the records and run the part "finish"."""
        lines = [self._fetched("late", self.parts.loads_end, late)] if late else []
        return lines + self._straight("finish")

    def _begun(self, name: str, state: int) -> list[str]:
        """Head of a function of ``state`` numbers in S: it sets the front, the sums and the ground."""
        parts, T = self.parts, self.T
        numbers = [*[1.0] * self.lanes, *[0.0] * (self.width - self.lanes)]
        one = ", ".join(f"double {literal(x)}" for x in numbers)
        one = f"<{one}>" if self.width > 1 else literal(1.0)
        # links that move in a plane leave out what stands across it
        cleared = parts.sums.aside if parts.normal < 0 else parts.sums.end
        lines = [
            f"define internal void @{name}(ptr %S, ptr %c) nounwind noinline {{",
            "entry:",
            self._zeros("zero", 0, 1),
            self._zeros("rest", 2 + state, parts.inputs - state),
            self._zeros("begun", parts.sums.cleared, cleared - parts.sums.cleared),
            self._zeros("ground", parts.base, WIDTH),
            self._zeros("rest_of_ground", parts.accelerations[-1], 3),
        ]
        for k in (0, 4, 8):
            lines += [
                f"  %one{k} = getelementptr {T}, ptr %ground, i64 {link_step.PLACE - SECOND + k}",
                f"  store {T} {one}, ptr %one{k}, align {8 * self.width}",
            ]
        lines += self._straight("front")
        lines.append(self._fetched("g", parts.accelerations[-1] + 3, parts.ground))
        return lines

    def _straight(self, name: str) -> list[str]:
        """Call of a straight part; no lines for an empty one."""
        if name in self.parts.empty:
            return []
        address = self.parts.straight[name].address
        single = self.lanes == 1
        lines = [
            f"  %{name}.c = getelementptr {self.fill['C']}, ptr %c, i64 {self.parts.straight_offset}",
            f"  %{name}.out = getelementptr {self.T}, ptr %S, i64 {self.parts.start[name]}",
            f"  %{name}.at = getelementptr {self.T}, ptr %S, i64 1",
        ]
        if single:
            lines.append(f"  %{name}.t = load double, ptr %{name}.at, align 8")
        time = f"double %{name}.t" if single else f"ptr %{name}.at"
        call = f"  call void inttoptr (i64 {address} to ptr)({time}, ptr %S, ptr %{name}.c, ptr %{name}.out)"
        return [*lines, call]

    def _fetched(self, name: str, target: int, places: Sequence[int]) -> str:
        """Copy numbers from these places in S to consecutive places."""
        table = self.parts.table(places)
        return f"""  %{name} = getelementptr {self.T}, ptr %S, i64 {target}
  call void @fetch(ptr %{name}, ptr %S, ptr inttoptr (i64 {table} to ptr), i64 {len(places)})"""

    def _zeros(self, name: str, start: int, count: int) -> str:
        return f"""  %{name} = getelementptr {self.T}, ptr %S, i64 {start}
  call void @llvm.memset.p0.i64(ptr %{name}, i8 0, i64 {8 * self.width * count}, i1 false)"""

    def _loops(self) -> list[str]:
        s, T = link_step, self.T
        gather = f"""
  %table = getelementptr i64, ptr inttoptr (i64 {self.joints} to ptr), i64 %places
  call void @fetch(ptr %joint, ptr %S, ptr %table, i64 %many)"""
        outward = f"{gather}\n{self._step(0)}"
        # inertias and wrenches of the tips are added up, or wrenches alone
        inward = f"""{gather}
{self._step(1)}
  %several = icmp sge i64 %added, 0
  br i1 %several, label %add, label %on
add:
  %sum = getelementptr {T}, ptr %S, i64 %added
  call void @add(ptr %sum, ptr %passed, i64 {6 if self.parts.back else SUM})
  br label %on
on:"""
        total = f"""
  %kinetic = getelementptr {T}, ptr %second, i64 {s.KINETIC - SECOND}
  %total = getelementptr {T}, ptr %S, i64 {self.parts.totals}
  call void @add(ptr %total, ptr %kinetic, i64 4)"""
        momentum = f"""{self._step(4)}
  %momentum = getelementptr {T}, ptr %second, i64 {s.MOMENTUM - SECOND}
  %total = getelementptr {T}, ptr %S, i64 {self.parts.totals}
  call void @add(ptr %total, ptr %momentum, i64 6)"""
        fill = {**self.fill, "links": self.links, "row": ROW, "base": self.parts.base, "width": WIDTH,
            "joint": self.parts.joint}  # fmt: skip
        up = {"first": 0, "stop": self.count, "by": 1}
        down = {"first": self.count - 1, "stop": -1, "by": -1}
        return [
            LOOP.format(name="outward.plain", body=outward, **fill, **up),
            LOOP.format(name="outward.placed", body=f"{outward}\n{self._step(3)}", **fill, **up),
            LOOP.format(name="inward", body=inward, **fill, **down),
            LOOP.format(name="final", body=f"{gather}\n{self._step(2)}", **fill, **up),
            LOOP.format(name="sums", body=total, **fill, **up),
            LOOP.format(name="moved", body=self._step(4), **fill, **up),
            LOOP.format(name="momenta", body=momentum, **fill, **up),
            LOOP.format(name="pressed", body=self._step(5), **fill, **up),
        ]

    def _step(self, k: int) -> str:
        """Call of a step: see :func:`freebody.program.large.link_step.compiled_step`."""
        (first, *reads), (target, *writes) = STEPS[self.steps[k]]
        arrays = ", ".join(f"ptr %{x}" for x in (first, "constants", target, *reads, *writes))
        return f"""  %row{k} = getelementptr i64, ptr %row, i64 {len(STARTS) + k}
  %address{k} = load i64, ptr %row{k}, align 8
  %f{k} = inttoptr i64 %address{k} to ptr
  call void %f{k}({self.fill["time"]}, {arrays})"""

    def _derivative(self) -> str:
        """Derivative of one kernel along a direction, or by some numbers of its state, eight columns at a time."""
        base, first, count = self.parts.directions or ("", 0, 0)
        outputs = self.parts.outputs[base]
        fill = {
            **self.fill, "name": base, "state": self.parts.states[base], "outputs": len(outputs), "width": self.width,
            "bytes": 8 * self.width * self.parts.size + 64, "table": self.parts.table(outputs), "lanes": self.lanes,
            "first": first, "count": count, "columns": count or 1, "V": f"<{self.lanes} x double>",
            "begin": BY.format(first=first, count=count, lanes=self.lanes) if count else ALONG.format(first=first),
        }  # fmt: skip
        of = 2 * first if count == 0 else self.parts.states[base]
        kernel = fill["kernel"] = "f" if count else "tangent"
        rows = self._rows(kernel, of, len(outputs) * (count or 1))
        return f"{self._core(base)}\n{DERIVATIVE.format(**fill)}\n{rows}"

    def _mass_matrix(self) -> str:
        """Mass matrix: postures once, then forces at rest for unit accelerations, one column per lane at a time."""
        parts = self.parts
        outputs = parts.outputs["column"]
        n_u = len(outputs)
        n_q = parts.inputs - 2 * n_u
        late = [parts.at(i, k) for i, k in parts.fetched]
        column = [
            *self._straight("front"),
            "  call void @final(ptr %S, ptr %c)",
            "  call void @inward(ptr %S, ptr %c)",
            *self._finish(late),
        ]
        core = self._begun("mass_matrix.begun", n_q)
        begun = "\n".join([*core, "  call void @outward.plain(ptr %S, ptr %c)", "  ret void", "}"])
        columns = COLUMNS.format(
            **self.fill, n_u=n_u, first=2 + n_q + n_u, bytes=8 * self.lanes * parts.size + 64, state=n_q,
            column="\n".join(column), lanes=self.lanes, table=parts.table(outputs),
        )  # fmt: skip
        return begun + columns + self._rows("mass_matrix", n_q, n_u * n_u)

    def _rows(self, name: str, state: int, outputs: int) -> str:
        return ROWS.format(name=name, state=state, room=max(state, 1), outputs=outputs)
