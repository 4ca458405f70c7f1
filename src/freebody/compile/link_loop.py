"""The loops over the links of a large tree as LLVM IR: see :mod:`freebody.compile.looped`.

Every kernel allocates S for itself, so that any number of threads may call it. Places in S, and addresses of the
steps and of the straight parts, are constants of the code or of the tables that it reads.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..model.model import GROUND
from . import link_step, native
from .link_step import WIDTH

if TYPE_CHECKING:
    from .looped import LoopedSet, Parts

_ROW = 10  # numbers per link in the table of links


class Driver:
    """The loops as LLVM IR."""

    def __init__(self, owner: LoopedSet, parts: Parts) -> None:
        self.owner = owner
        self.parts = parts
        self.count = len(parts.model.links)
        rows: list[int] = []
        joints: list[int] = []
        for i, link in enumerate(parts.model.links):
            step = owner.step(i)
            parent = parts.base if link.parent == GROUND else parts.record(link.parent)
            addresses = [step[name].address for name in (*owner.loops, "place", "moved", "pressed")]
            rows += [parent, owner.offset(i), len(joints), len(parts.joints[i]), *addresses]
            joints += parts.joints[i]
        self.links, self.joints = owner.table(rows), owner.table(joints)

    def text(self) -> str:
        """The module."""
        triple = native.processor()[0]
        head = f'target triple = "{triple}"\ntarget datalayout = "{native.layout()}"\n'
        if "column" in self.parts.outputs:
            n_u = len(self.parts.outputs["column"])
            n_q = self.parts.given - 2 * n_u
            batches = [_BATCH.format(name="mass_matrix", state=n_q, outputs=n_u * n_u)]
            functions = [self._column(), self._mass_matrix(n_q, n_u)]
        else:
            batches = [_BATCH.format(name=name, **self._sizes(name)) for name in self.parts.outputs]
            functions = [self._function(name) for name in self.parts.outputs]
        return head + _HELPERS + "\n".join([*self._loops(), *functions, *batches])

    def _sizes(self, name: str) -> dict[str, int]:
        return {"state": self.parts.states[name], "outputs": len(self.parts.outputs[name])}

    def _function(self, name: str) -> str:
        parts = self.parts
        if not parts.outputs[name]:
            return f"define void @{name}(double %t, ptr %y, ptr %c, ptr %out) nounwind {{\n  ret void\n}}\n"
        reactions = name == "reactions"
        moving = name in ("rates", "accelerations") or reactions or self.owner.back
        placed = not moving or reactions or parts.placed
        lines = self._begun(name, parts.states[name])
        lines.append(f"  call void @outward.{'placed' if placed else 'plain'}(double %t, ptr %S, ptr %c)")
        fetched = [parts.record(i) + k for i, k in parts.fetched]
        first = 2 + parts.given
        early = parts.loads_end - first
        late = fetched[early:]
        if early and name not in ("poses", "postures", "velocities", "momentum"):
            lines.append(f"  %early = getelementptr double, ptr %S, i64 {first}")
            lines.append(self._gather("%early", fetched[:early]))
        if moving:
            lines += self._straight("loads")
            if parts.pressed:
                targets = self.owner.table([a for a, _ in parts.pressed])
                sources = self.owner.table([b for _, b in parts.pressed])
                lines.append(
                    f"  call void @press(ptr %S, ptr inttoptr (i64 {targets} to ptr), "
                    f"ptr inttoptr (i64 {sources} to ptr), i64 {len(parts.pressed)})"
                )
            # accelerations follow from articulated inertias, or the wrenches from accelerations
            order = ("final", "inward") if self.owner.back else ("inward", "final")
            lines += [f"  call void @{loop}(double %t, ptr %S, ptr %c)" for loop in order]
            if reactions:
                lines.append("  call void @pressed(double %t, ptr %S, ptr %c)")
            lines += self._finish(late)
        elif name == "jacobian":
            lines += self._finish(late)
        elif name in ("velocities", "momentum"):
            if name == "momentum":
                lines.append(f"  %sums = getelementptr double, ptr %S, i64 {parts.sums}")
                lines.append("  call void @llvm.memset.p0.i64(ptr %sums, i8 0, i64 48, i1 false)")
            loop = "momenta" if name == "momentum" else "moved"
            lines.append(f"  call void @{loop}(double %t, ptr %S, ptr %c)")
        elif name.endswith("energy"):
            lines.append(f"  %sums = getelementptr double, ptr %S, i64 {parts.sums}")
            lines.append("  call void @sum(ptr %S, ptr %sums)")
            lines += self._straight("energy")
        lines.append(self._gather("%out", parts.outputs[name]))
        return "\n".join([*lines, "  call void @free(ptr %S)", "  ret void", "}", ""])

    def _finish(self, late: Sequence[int]) -> list[str]:
        """What follows from the records, fetched from these places."""
        lines = []
        if late:
            lines.append(f"  %late = getelementptr double, ptr %S, i64 {self.parts.loads_end}")
            lines.append(self._gather("%late", late))
        return lines + self._straight("finish")

    def _begun(self, name: str, state: int) -> list[str]:
        """The head of a function of ``state`` numbers: S, the front, and the ground."""
        parts = self.parts
        lines = [
            f"define void @{name}(double %t, ptr %y, ptr %c, ptr %out) nounwind {{",
            "entry:",
            f"  %S = call ptr @malloc(i64 {8 * parts.record(self.count)})",
            "  store double 0.0, ptr %S, align 8",
            "  %S1 = getelementptr double, ptr %S, i64 1",
            "  store double %t, ptr %S1, align 8",
            "  %S2 = getelementptr double, ptr %S, i64 2",
            f"  call void @llvm.memset.p0.i64(ptr %S2, i8 0, i64 {8 * parts.given}, i1 false)",
            f"  call void @copy(ptr %S2, ptr %y, i64 {state})",
            f"  %ground = getelementptr double, ptr %S, i64 {parts.base}",
            f"  call void @llvm.memset.p0.i64(ptr %ground, i8 0, i64 {8 * WIDTH}, i1 false)",
        ]
        for k in (0, 4, 8):
            lines += [
                f"  %one{k} = getelementptr double, ptr %ground, i64 {link_step.PLACE + k}",
                f"  store double 1.0, ptr %one{k}, align 8",
            ]
        lines += self._straight("front")
        lines.append(f"  %g = getelementptr double, ptr %ground, i64 {link_step.A + 3}")
        lines.append(self._gather("%g", parts.ground))
        return lines

    def _column(self) -> str:
        """Forces for the accelerations in S, at rest."""
        parts = self.parts
        late = [parts.record(i) + k for i, k in parts.fetched]
        return "\n".join(
            [
                "define internal void @column(double %t, ptr %S, ptr %c, ptr %out) nounwind {",
                *self._straight("front"),
                "  call void @final(double %t, ptr %S, ptr %c)",
                "  call void @inward(double %t, ptr %S, ptr %c)",
                *self._finish(late),
                self._gather("%out", parts.outputs["column"]),
                "  ret void",
                "}",
                "",
            ]
        )

    def _mass_matrix(self, n_q: int, n_u: int) -> str:
        """Column by column: postures once, then unit accelerations."""
        lines = self._begun("mass_matrix", n_q)
        lines.append("  call void @outward.plain(double %t, ptr %S, ptr %c)")
        return "\n".join([*lines, _COLUMNS.format(n_u=n_u, first=2 + n_q + n_u)])

    def _straight(self, name: str) -> list[str]:
        if name in self.parts.empty:
            return []
        address = self.owner.straight[name].address
        return [
            f"  %{name}.c = getelementptr double, ptr %c, i64 {self.owner.straight_offset}",
            f"  %{name}.out = getelementptr double, ptr %S, i64 {self.parts.start[name]}",
            f"  call void inttoptr (i64 {address} to ptr)(double %t, ptr %S, ptr %{name}.c, ptr %{name}.out)",
        ]

    def _gather(self, target: str, places: Sequence[int]) -> str:
        table = self.owner.table(places)
        return (
            f"  call void @gather(ptr {target}, ptr %S, ptr inttoptr (i64 {table} to ptr), i64 {len(places)})"
        )

    def _loops(self) -> list[str]:
        s, base = link_step, self.parts.base
        joints = f"ptr inttoptr (i64 {self.joints} to ptr)"
        gather = f"""
  %start = load i64, ptr %row2, align 8
  %many = load i64, ptr %row3, align 8
  %places = getelementptr i64, {joints}, i64 %start
  %joint = getelementptr double, ptr %record, i64 {s.JOINT}
  call void @gather(ptr %joint, ptr %S, ptr %places, i64 %many)"""
        fetch = f"""{gather}
  %from = getelementptr double, ptr %parent, i64 {s.V}
{_copied("V", "%record", "%from")}
{_call(4, s.OUTWARD)}"""
        place = f"""
  %above = getelementptr double, ptr %parent, i64 {s.PLACE}
  %there = getelementptr double, ptr %record, i64 {s.PARENT_PLACE}
  call void @llvm.memcpy.p0.p0.i64(ptr %there, ptr %above, i64 96, i1 false)
{_call(7, s.PLACE)}"""
        # inertias and wrenches of the tips add up, or wrenches alone
        first, many = (s.INERTIA + 21, 6) if self.owner.back else (s.INERTIA, 27)
        inward = f"""
{_call(5, s.INWARD)}
  %sum = getelementptr double, ptr %parent, i64 {first}
  call void @add(ptr %sum, ptr %to5, i64 {many})"""
        final = f"""
  %from = getelementptr double, ptr %parent, i64 {s.A}
  %A = getelementptr double, ptr %record, i64 {s.PARENT_A}
{_copied("A", "%A", "%from")}
{_call(6, s.FINAL)}"""
        if "column" in self.parts.outputs:  # other accelerations, and forces from nothing
            final = f"""{gather}
  %p = getelementptr double, ptr %record, i64 {s.INERTIA + 21}
  call void @llvm.memset.p0.i64(ptr %p, i8 0, i64 48, i1 false){final}"""
        total = f"""
  %kinetic = getelementptr double, ptr %record, i64 {s.KINETIC}
  call void @add(ptr %c, ptr %kinetic, i64 4)"""
        moved = f"""
{_call(8, s.MOVED)}"""
        momentum = f"""{moved}
  %momentum = getelementptr double, ptr %record, i64 {s.MOMENTUM}
  %total = getelementptr double, ptr %S, i64 {self.parts.sums}
  call void @add(ptr %total, ptr %momentum, i64 6)"""
        pressed = f"""
{_call(9, s.PRESSED)}"""
        fill = {"links": self.links, "row": _ROW, "base": base, "width": WIDTH}
        up = {"first": 0, "stop": self.count, "by": 1}
        down = {"first": self.count - 1, "stop": -1, "by": -1}
        return [
            _LOOP.format(name="outward.plain", body=fetch, **fill, **up),
            _LOOP.format(name="outward.placed", body=fetch + place, **fill, **up),
            _LOOP.format(name="inward", body=inward, **fill, **down),
            _LOOP.format(name="final", body=final, **fill, **up),
            _LOOP.format(name="sums", body=total, **fill, **up),
            _LOOP.format(name="moved", body=moved, **fill, **up),
            _LOOP.format(name="momenta", body=momentum, **fill, **up),
            _LOOP.format(name="pressed", body=pressed, **fill, **up),
        ]


def _copied(name: str, target: str, source: str) -> str:
    """Six numbers one by one: a load of several that were stored singly just before would wait for them."""
    return "\n".join(
        f"""  %{name}from{k} = getelementptr double, ptr {source}, i64 {k}
  %{name}to{k} = getelementptr double, ptr {target}, i64 {k}
  %{name}x{k} = load volatile double, ptr %{name}from{k}, align 8
  store double %{name}x{k}, ptr %{name}to{k}, align 8"""
        for k in range(6)
    )


def _call(column: int, target: int) -> str:
    """The step of a column of the table, which writes from ``target`` of the record on."""
    return f"""  %address{column} = load i64, ptr %row{column}, align 8
  %f{column} = inttoptr i64 %address{column} to ptr
  %to{column} = getelementptr double, ptr %record, i64 {target}
  call void %f{column}(double %t, ptr %record, ptr %own, ptr %to{column})"""


_LOOP = (
    """
define internal void @{name}(double %t, ptr %S, ptr %c) nounwind noinline {{
entry:
  br label %loop
loop:
  %i = phi i64 [{first}, %entry], [%next, %loop]
  %r = mul i64 %i, {row}
  %row0 = getelementptr i64, ptr inttoptr (i64 {links} to ptr), i64 %r
"""
    + "\n".join(f"  %row{k} = getelementptr i64, ptr %row0, i64 {k}" for k in range(1, _ROW))
    + """
  %place = load i64, ptr %row0, align 8
  %offset = load i64, ptr %row1, align 8
  %parent = getelementptr double, ptr %S, i64 %place
  %own = getelementptr double, ptr %c, i64 %offset
  %i1 = add i64 %i, 1
  %w = mul i64 %i1, {width}
  %b = add i64 %w, {base}
  %record = getelementptr double, ptr %S, i64 %b
{body}
  %next = add i64 %i, {by}
  %more = icmp ne i64 %next, {stop}
  br i1 %more, label %loop, label %done
done:
  ret void
}}
"""
)

_BATCH = """
define void @{name}.batch(i64 %n, ptr %t, i64 %ts, ptr %y, ptr %c, i64 %cs, ptr %out) nounwind {{
entry:
  %some = icmp sgt i64 %n, 0
  br i1 %some, label %loop, label %done
loop:
  %i = phi i64 [0, %entry], [%next, %loop]
  %it = mul i64 %i, %ts
  %iy = mul i64 %i, {state}
  %ic = mul i64 %i, %cs
  %io = mul i64 %i, {outputs}
  %pt = getelementptr double, ptr %t, i64 %it
  %py = getelementptr double, ptr %y, i64 %iy
  %pc = getelementptr double, ptr %c, i64 %ic
  %po = getelementptr double, ptr %out, i64 %io
  %time = load double, ptr %pt, align 8
  call void @{name}(double %time, ptr %py, ptr %pc, ptr %po)
  %next = add i64 %i, 1
  %more = icmp slt i64 %next, %n
  br i1 %more, label %loop, label %done
done:
  ret void
}}
"""


_COLUMNS = """  %some = icmp sgt i64 {n_u}, 0
  br i1 %some, label %loop, label %done
loop:
  %j = phi i64 [0, %entry], [%next, %loop]
  %k = add i64 %j, {first}
  %unit = getelementptr double, ptr %S, i64 %k
  store double 1.0, ptr %unit, align 8
  %w = mul i64 %j, {n_u}
  %column = getelementptr double, ptr %out, i64 %w
  call void @column(double %t, ptr %S, ptr %c, ptr %column)
  store double 0.0, ptr %unit, align 8
  %next = add i64 %j, 1
  %more = icmp slt i64 %next, {n_u}
  br i1 %more, label %loop, label %done
done:
  call void @free(ptr %S)
  ret void
}}
"""


def _each(name: str, arguments: str, body: str) -> str:
    """A loop of %k from 0 to %n."""
    return f"""
define internal void @{name}({arguments}, i64 %n) nounwind noinline {{
entry:
  %some = icmp sgt i64 %n, 0
  br i1 %some, label %loop, label %done
loop:
  %k = phi i64 [0, %entry], [%next, %loop]
{body}
  %next = add i64 %k, 1
  %more = icmp slt i64 %next, %n
  br i1 %more, label %loop, label %done
done:
  ret void
}}
"""


_HELPERS = (
    """
declare ptr @malloc(i64)
declare void @free(ptr)
declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)
define internal void @copy(ptr %target, ptr %source, i64 %n) nounwind {
  %bytes = mul i64 %n, 8
  call void @llvm.memcpy.p0.p0.i64(ptr %target, ptr %source, i64 %bytes, i1 false)
  ret void
}
define internal void @sum(ptr %S, ptr %sums) nounwind {
  call void @llvm.memset.p0.i64(ptr %sums, i8 0, i64 32, i1 false)
  call void @sums(double 0.0, ptr %S, ptr %sums)
  ret void
}
"""
    + _each(
        "gather",
        "ptr %target, ptr %S, ptr %places",
        """  %p = getelementptr i64, ptr %places, i64 %k
  %place = load i64, ptr %p, align 8
  %s = getelementptr double, ptr %S, i64 %place
  %x = load double, ptr %s, align 8
  %d = getelementptr double, ptr %target, i64 %k
  store double %x, ptr %d, align 8""",
    )
    + _each(
        "add",
        "ptr %target, ptr %source",
        """  %s = getelementptr double, ptr %source, i64 %k
  %d = getelementptr double, ptr %target, i64 %k
  %x = load double, ptr %s, align 8
  %z = load double, ptr %d, align 8
  %sum = fadd double %x, %z
  store double %sum, ptr %d, align 8""",
    )
    + _each(
        "press",
        "ptr %S, ptr %targets, ptr %sources",
        """  %a = getelementptr i64, ptr %targets, i64 %k
  %b = getelementptr i64, ptr %sources, i64 %k
  %i = load i64, ptr %a, align 8
  %j = load i64, ptr %b, align 8
  %d = getelementptr double, ptr %S, i64 %i
  %s = getelementptr double, ptr %S, i64 %j
  %x = load double, ptr %d, align 8
  %z = load double, ptr %s, align 8
  %less = fsub double %x, %z
  store double %less, ptr %d, align 8""",
    )
)
