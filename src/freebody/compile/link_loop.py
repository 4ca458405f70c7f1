"""The loops over the links of a large tree as LLVM IR, of one state or of several side by side.

Where everything stands is decided in :mod:`freebody.compile.looped`.

Every call has a workspace of its own, so that any number of threads may call it. Places in it, and addresses of the
steps and of the straight parts, are constants of the code or of the tables that it reads. A number is one double, or
one of every lane: nothing else differs between the two.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..model.model import GROUND
from . import batch, link_step, native
from .link_step import SECOND, STEPS, SUM, WIDTH
from .text import literal

if TYPE_CHECKING:
    from .looped import LoopedSet, Parts

_STARTS = (
    "constants", "places", "many", "tips", "passed", "added", "record", "parent", "own", "above", "parents_second",
)  # fmt: skip
"""Of a link: where its constants and the places of its joint variables begin, how many those are, and places in S."""
_ROW = len(_STARTS) + 6  # and addresses of steps


class Driver:
    """The loops as LLVM IR."""

    def __init__(self, owner: LoopedSet, parts: Parts) -> None:
        self.owner = owner
        self.parts = parts
        self.lanes = owner.lanes
        self.count = len(parts.model.links)
        self.moved = owner.directions is not None
        self.width = self.lanes * (1 + self.moved)  # of a number, with its derivative
        self.T = "double" if self.width == 1 else f"<{self.width} x double>"
        self.own_constants = self.lanes > 1 and not owner.shared  # a vector for each
        self.fill = {
            "T": self.T, "align": 8 * self.width, "C": self.T if self.own_constants else "double",
            "time": "double 0.0" if self.lanes == 1 else "ptr %S",
        }  # fmt: skip
        self.steps = (*owner.loops, "place", "moved", "pressed")
        rows: list[int] = []
        joints: list[int] = []
        for i, link in enumerate(parts.model.links):
            step = owner.step(i)
            above = -1 if link.parent == GROUND else link.parent
            rows += [owner.offset(i), len(joints), len(parts.joints[i])]
            rows += [parts.sums.of[i], parts.sums.passed[i], parts.sums.added[i]]
            rows += [
                parts.at(i, link_step.V),
                parts.sums.cleared if above < 0 else parts.at(above, link_step.V),
            ]
            rows += [parts.accelerations[i], parts.accelerations[above], parts.at(above, SECOND)]
            rows += [step[name].address for name in self.steps]
            joints += parts.joints[i]
        self.links, self.joints = owner.table(rows), owner.table(joints)

    def text(self) -> str:
        """The module."""
        triple = native.processor()[0]
        head = f'target triple = "{triple}"\ntarget datalayout = "{native.layout()}"\n'
        if "column" in self.parts.outputs:
            functions = [self._mass_matrix()]
        elif self.moved:
            functions = [self._derivative()]
        else:
            functions = [self._function(name) for name in self.parts.outputs]
        helpers = _HELPERS.format(**self.fill)
        rows = batch.gather(self.lanes) + _DELIVER.replace("LANES", str(self.lanes))
        return head + helpers + rows + "\n".join([*self._loops(), *functions])

    def _function(self, name: str) -> str:
        """The kernel of one state (or of as many as there are lanes) and of rows."""
        parts = self.parts
        outputs = parts.outputs[name]
        fill = {
            **self.fill, "name": name, "lanes": self.lanes, "state": parts.states[name], "outputs": len(outputs),
            "bytes": 8 * self.lanes * (parts.size + self.owner.hoisted * self.own_constants) + 64,
            "constants": parts.size, "hoisted": self.owner.hoisted,
            "table": self.owner.table(outputs),
        }  # fmt: skip
        if not outputs:
            return _NOTHING.format(**fill)
        fill |= {
            "symbol": name if self.lanes == 1 else f"{name}.lanes",
            "given": "double %t" if self.lanes == 1 else "ptr %tt",
            "moment": "" if self.lanes == 1 else f"  %t = load {self.T}, ptr %tt, align {8 * self.lanes}\n",
            "vary": _VARY.format(**fill) if self.own_constants else _ONE.format(**fill),
        }
        return f"{self._core(name)}\n{_CALL.format(**fill)}\n{_BATCH.format(**fill)}"

    def _core(self, name: str) -> str:
        """What is done once time and state stand in S."""
        parts = self.parts
        reactions = name == "reactions"
        moving = name in ("rates", "accelerations") or reactions or self.owner.back
        placed = not moving or reactions or parts.placed
        lines = self._begun(f"{name}.core", parts.states[name])
        lines.append(f"  call void @outward.{'placed' if placed else 'plain'}(ptr %S, ptr %c)")
        fetched = [parts.at(i, k) for i, k in parts.fetched]
        first = 2 + parts.given
        early = parts.loads_end - first
        late = fetched[early:]
        if early and name not in ("poses", "postures", "velocities", "momentum"):
            lines.append(self._fetched("early", first, fetched[:early]))
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
        """What follows from the records, fetched from these places."""
        lines = [self._fetched("late", self.parts.loads_end, late)] if late else []
        return lines + self._straight("finish")

    def _begun(self, name: str, state: int) -> list[str]:
        """The head of a function of ``state`` numbers, which stand in S: the front, the sums, and the ground."""
        parts, T = self.parts, self.T
        each = [*[1.0] * self.lanes, *[0.0] * (self.width - self.lanes)]
        one = ", ".join(f"double {literal(x)}" for x in each)
        one = f"<{one}>" if self.width > 1 else literal(1.0)
        lines = [
            f"define internal void @{name}(ptr %S, ptr %c) nounwind noinline {{",
            "entry:",
            self._zeros("zero", 0, 1),
            self._zeros("rest", 2 + state, parts.given - state),
            self._zeros("begun", parts.sums.cleared, parts.sums.aside - parts.sums.cleared),
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
        if name in self.parts.empty:
            return []
        address = self.owner.straight[name].address
        one = self.lanes == 1
        lines = [
            f"  %{name}.c = getelementptr {self.fill['C']}, ptr %c, i64 {self.owner.straight_offset}",
            f"  %{name}.out = getelementptr {self.T}, ptr %S, i64 {self.parts.start[name]}",
            f"  %{name}.at = getelementptr {self.T}, ptr %S, i64 1",
        ]
        if one:
            lines.append(f"  %{name}.t = load double, ptr %{name}.at, align 8")
        time = f"double %{name}.t" if one else f"ptr %{name}.at"
        call = f"  call void inttoptr (i64 {address} to ptr)({time}, ptr %S, ptr %{name}.c, ptr %{name}.out)"
        return [*lines, call]

    def _fetched(self, name: str, target: int, places: Sequence[int]) -> str:
        """From these places in S to others one after the other."""
        table = self.owner.table(places)
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
        # inertias and wrenches of the tips add up, or wrenches alone
        inward = f"""{gather}
{self._step(1)}
  %several = icmp sge i64 %added, 0
  br i1 %several, label %add, label %on
add:
  %sum = getelementptr {T}, ptr %S, i64 %added
  call void @add(ptr %sum, ptr %passed, i64 {6 if self.owner.back else SUM})
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
        fill = {**self.fill, "links": self.links, "row": _ROW, "base": self.parts.base, "width": WIDTH,
            "joint": self.parts.joint}  # fmt: skip
        up = {"first": 0, "stop": self.count, "by": 1}
        down = {"first": self.count - 1, "stop": -1, "by": -1}
        return [
            _LOOP.format(name="outward.plain", body=outward, **fill, **up),
            _LOOP.format(name="outward.placed", body=f"{outward}\n{self._step(3)}", **fill, **up),
            _LOOP.format(name="inward", body=inward, **fill, **down),
            _LOOP.format(name="final", body=f"{gather}\n{self._step(2)}", **fill, **up),
            _LOOP.format(name="sums", body=total, **fill, **up),
            _LOOP.format(name="moved", body=self._step(4), **fill, **up),
            _LOOP.format(name="momenta", body=momentum, **fill, **up),
            _LOOP.format(name="pressed", body=self._step(5), **fill, **up),
        ]

    def _step(self, k: int) -> str:
        """One of the steps: see :func:`freebody.compile.link_step.compiled_step`."""
        (first, *reads), (target, *writes) = STEPS[self.steps[k]]
        arrays = ", ".join(f"ptr %{x}" for x in (first, "constants", target, *reads, *writes))
        return f"""  %row{k} = getelementptr i64, ptr %row, i64 {len(_STARTS) + k}
  %address{k} = load i64, ptr %row{k}, align 8
  %f{k} = inttoptr i64 %address{k} to ptr
  call void %f{k}({self.fill["time"]}, {arrays})"""

    def _derivative(self) -> str:
        """Of one kernel along one direction, or by some numbers of its state, eight columns at a time."""
        base, first, count = self.owner.directions or ("", 0, 0)
        outputs = self.parts.outputs[base]
        fill = {
            **self.fill, "name": base, "state": self.parts.states[base], "outputs": len(outputs), "width": self.width,
            "bytes": 8 * self.width * self.parts.size + 64, "table": self.owner.table(outputs), "lanes": self.lanes,
            "first": first, "count": count, "columns": count or 1,
            "begin": _BY.format(first=first, count=count) if count else _ALONG.format(first=first),
        }  # fmt: skip
        of = 2 * first if count == 0 else self.parts.states[base]
        fill["kernel"] = "f" if count else "tangent"
        rows = _ROWS.format(name=fill["kernel"], state=of, outputs=len(outputs) * (count or 1))
        return f"{self._core(base)}\n{_DERIVATIVE.format(**fill)}\n{rows}"

    def _mass_matrix(self) -> str:
        """Postures once, then forces at rest for unit accelerations, as many columns at a time as there are lanes."""
        parts = self.parts
        outputs = parts.outputs["column"]
        n_u = len(outputs)
        n_q = parts.given - 2 * n_u
        late = [parts.at(i, k) for i, k in parts.fetched]
        column = [
            *self._straight("front"),
            "  call void @final(ptr %S, ptr %c)",
            "  call void @inward(ptr %S, ptr %c)",
            *self._finish(late),
        ]
        core = self._begun("mass_matrix.begun", n_q)
        begun = "\n".join([*core, "  call void @outward.plain(ptr %S, ptr %c)", "  ret void", "}"])
        columns = _COLUMNS.format(
            **self.fill, n_u=n_u, first=2 + n_q + n_u, bytes=8 * self.lanes * parts.size + 64, state=n_q,
            column="\n".join(column), lanes=self.lanes, table=self.owner.table(outputs),
        )  # fmt: skip
        return begun + columns + _ROWS.format(name="mass_matrix", state=n_q, outputs=n_u * n_u)


_LOOP = (
    """
define internal void @{name}(ptr %S, ptr %c) nounwind noinline {{
entry:
  %joint = getelementptr {T}, ptr %S, i64 {joint}
  br label %loop
loop:
  %i = phi i64 [{first}, %entry], [%next, %end]
  %r = mul i64 %i, {row}
  %row = getelementptr i64, ptr inttoptr (i64 {links} to ptr), i64 %r
"""
    + "\n".join(
        f"""  %at.{name} = getelementptr i64, ptr %row, i64 {k}
  %{name if name in ("places", "many", "added") else name + ".place"} = load i64, ptr %at.{name}, align 8"""
        for k, name in enumerate(_STARTS)
    )
    + "\n  %constants = getelementptr {C}, ptr %c, i64 %constants.place\n"
    + "\n".join(
        f"  %{name} = getelementptr {{T}}, ptr %S, i64 %{name}.place"
        for name in _STARTS
        if name not in ("constants", "places", "many", "added")
    )
    + """
  %i1 = add i64 %i, 1
  %w = mul i64 %i1, {width}
  %b = add i64 %w, {base}
  %second = getelementptr {T}, ptr %S, i64 %b
{body}
  br label %end
end:
  %next = add i64 %i, {by}
  %more = icmp ne i64 %next, {stop}
  br i1 %more, label %loop, label %done
done:
  ret void
}}
"""
)

_NOTHING = """
define void @{name}(double %t, ptr %y, ptr %c, ptr %out) nounwind {{
  ret void
}}
define void @{name}.lanes(ptr %t, ptr %y, ptr %c, ptr %out) nounwind {{
  ret void
}}
define void @{name}.batch(i64 %n, ptr %t, i64 %ts, ptr %y, ptr %c, i64 %cs, ptr %out) nounwind {{
  ret void
}}
"""

_CALL = """
define void @{symbol}({given}, ptr %y, ptr %c, ptr %out) nounwind {{
{moment}  %room = call ptr @malloc(i64 {bytes})
  %S = call ptr @aligned(ptr %room)
  %S1 = getelementptr {T}, ptr %S, i64 1
  store {T} %t, ptr %S1, align {align}
  %S2 = getelementptr {T}, ptr %S, i64 2
  call void @copy(ptr %S2, ptr %y, i64 {state})
  call void @{name}.core(ptr %S, ptr %c)
  call void @fetch(ptr %out, ptr %S, ptr inttoptr (i64 {table} to ptr), i64 {outputs})
  call void @free(ptr %room)
  ret void
}}
"""

_BATCH = """
define void @{name}.batch(i64 %n, ptr %t, i64 %ts, ptr %y, ptr %c, i64 %cs, ptr %out) nounwind {{
entry:
  %room = call ptr @malloc(i64 {bytes})
  %S = call ptr @aligned(ptr %room)
  %S1 = getelementptr {T}, ptr %S, i64 1
  %S2 = getelementptr {T}, ptr %S, i64 2
  %some = icmp sgt i64 %n, 0
  br i1 %some, label %block, label %done
block:
  %row = phi i64 [0, %entry], [%next, %on]
  call void @gather(ptr %t, i64 %row, i64 %n, i64 1, i64 %ts, ptr %S1)
  call void @gather(ptr %y, i64 %row, i64 %n, i64 {state}, i64 {state}, ptr %S2)
{vary}
  call void @{name}.core(ptr %S, ptr %C)
  call void @deliver(ptr %S, ptr inttoptr (i64 {table} to ptr), i64 %row, i64 %n, i64 {outputs}, ptr %out)
  br label %on
on:
  %next = add i64 %row, {lanes}
  %more = icmp slt i64 %next, %n
  br i1 %more, label %block, label %done
done:
  call void @free(ptr %room)
  ret void
}}
"""

# the constants of a row, or those of all
_ONE = """  %ic = mul i64 %row, %cs
  %C = getelementptr double, ptr %c, i64 %ic"""
# constants of every lane, gathered anew where they differ between the rows
_VARY = """  %C = getelementptr {T}, ptr %S, i64 {constants}
  %begin = icmp eq i64 %row, 0
  %differ = icmp ne i64 %cs, 0
  %anew = or i1 %begin, %differ
  br i1 %anew, label %vary, label %go
vary:
  call void @gather(ptr %c, i64 %row, i64 %n, i64 {hoisted}, i64 %cs, ptr %C)
  br label %go
go:"""

_COLUMNS = """
define internal void @units(ptr %S, i64 %j, double %value) nounwind {{
entry:
  br label %lane
lane:
  %l = phi i64 [0, %entry], [%l1, %on]
  %k = add i64 %j, %l
  %in = icmp slt i64 %k, {n_u}
  br i1 %in, label %set, label %on
set:
  %row = add i64 %k, {first}
  %start = mul i64 %row, {lanes}
  %place = add i64 %start, %l
  %unit = getelementptr double, ptr %S, i64 %place
  store double %value, ptr %unit, align 8
  br label %on
on:
  %l1 = add i64 %l, 1
  %more = icmp slt i64 %l1, {lanes}
  br i1 %more, label %lane, label %done
done:
  ret void
}}
define internal void @columns(ptr %S, ptr %c) nounwind noinline {{
{column}
  ret void
}}
define void @mass_matrix(double %t, ptr %y, ptr %c, ptr %out) nounwind {{
entry:
  %some = icmp sgt i64 {n_u}, 0
  br i1 %some, label %begin, label %none
none:
  ret void
begin:
  %tt = alloca double, align 8
  store double %t, ptr %tt, align 8
  %room = call ptr @malloc(i64 {bytes})
  %S = call ptr @aligned(ptr %room)
  %S1 = getelementptr {T}, ptr %S, i64 1
  %S2 = getelementptr {T}, ptr %S, i64 2
  call void @gather(ptr %tt, i64 0, i64 1, i64 1, i64 0, ptr %S1)
  call void @gather(ptr %y, i64 0, i64 1, i64 {state}, i64 0, ptr %S2)
  call void @mass_matrix.begun(ptr %S, ptr %c)
  br label %block
block:
  %j = phi i64 [0, %begin], [%next, %block]
  call void @units(ptr %S, i64 %j, double 1.0)
  call void @columns(ptr %S, ptr %c)
  call void @deliver(ptr %S, ptr inttoptr (i64 {table} to ptr), i64 %j, i64 {n_u}, i64 {n_u}, ptr %out)
  call void @units(ptr %S, i64 %j, double 0.0)
  %next = add i64 %j, {lanes}
  %more = icmp slt i64 %next, {n_u}
  br i1 %more, label %block, label %done
done:
  call void @free(ptr %room)
  ret void
}}
"""

# one row after another
_ROWS = """
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

# the rate of number %k in lane %l of the columns from %j on
_BY = """  %column = add i64 %j, %l
  %number = add i64 %column, {first}
  %own = icmp eq i64 %number, %k
  %in = icmp slt i64 %column, {count}
  %both = and i1 %own, %in
  %rate = select i1 %both, double 1.0, double 0.0"""
_ALONG = """  %behind = add i64 %k, {first}
  %pv = getelementptr double, ptr %y, i64 %behind
  %rate = load double, ptr %pv, align 8"""

_DERIVATIVE = """
define internal void @set(ptr %S, i64 %place, i64 %l, double %value, double %rate) nounwind {{
  %start = mul i64 %place, {width}
  %i = add i64 %start, %l
  %j = add i64 %i, {lanes}
  %a = getelementptr double, ptr %S, i64 %i
  %b = getelementptr double, ptr %S, i64 %j
  store double %value, ptr %a, align 8
  store double %rate, ptr %b, align 8
  ret void
}}
define internal void @lane(double %t, ptr %y, i64 %j, i64 %l, ptr %S) nounwind {{
entry:
  call void @set(ptr %S, i64 1, i64 %l, double %t, double 0.0)
  %some = icmp sgt i64 {state}, 0
  br i1 %some, label %loop, label %done
loop:
  %k = phi i64 [0, %entry], [%next, %loop]
  %p = getelementptr double, ptr %y, i64 %k
  %x = load double, ptr %p, align 8
{begin}
  %place = add i64 %k, 2
  call void @set(ptr %S, i64 %place, i64 %l, double %x, double %rate)
  %next = add i64 %k, 1
  %more = icmp slt i64 %next, {state}
  br i1 %more, label %loop, label %done
done:
  ret void
}}
define internal void @rates.of(ptr %S, i64 %j, i64 %l, ptr %out) nounwind {{
entry:
  %column = add i64 %j, %l
  %in = icmp slt i64 %column, {columns}
  %some = icmp sgt i64 {outputs}, 0
  %any = and i1 %in, %some
  br i1 %any, label %loop, label %done
loop:
  %k = phi i64 [0, %entry], [%next, %loop]
  %pp = getelementptr i64, ptr inttoptr (i64 {table} to ptr), i64 %k
  %place = load i64, ptr %pp, align 8
  %start = mul i64 %place, {width}
  %behind = add i64 %start, {lanes}
  %i = add i64 %behind, %l
  %s = getelementptr double, ptr %S, i64 %i
  %x = load double, ptr %s, align 8
  %row = mul i64 %k, {columns}
  %to = add i64 %row, %column
  %d = getelementptr double, ptr %out, i64 %to
  store double %x, ptr %d, align 8
  %next = add i64 %k, 1
  %more = icmp slt i64 %next, {outputs}
  br i1 %more, label %loop, label %done
done:
  ret void
}}
define void @{kernel}(double %t, ptr %y, ptr %c, ptr %out) nounwind {{
entry:
  %room = call ptr @malloc(i64 {bytes})
  %S = call ptr @aligned(ptr %room)
  br label %block
block:
  %j = phi i64 [0, %entry], [%next, %after]
  br label %given
given:
  %l = phi i64 [0, %block], [%l1, %given]
  call void @lane(double %t, ptr %y, i64 %j, i64 %l, ptr %S)
  %l1 = add i64 %l, 1
  %lanes = icmp slt i64 %l1, {lanes}
  br i1 %lanes, label %given, label %run
run:
  call void @{name}.core(ptr %S, ptr %c)
  br label %taken
taken:
  %m = phi i64 [0, %run], [%m1, %taken]
  call void @rates.of(ptr %S, i64 %j, i64 %m, ptr %out)
  %m1 = add i64 %m, 1
  %others = icmp slt i64 %m1, {lanes}
  br i1 %others, label %taken, label %after
after:
  %next = add i64 %j, {lanes}
  %more = icmp slt i64 %next, {columns}
  br i1 %more, label %block, label %done
done:
  call void @free(ptr %room)
  ret void
}}
"""


def _each(name: str, arguments: str, body: str) -> str:
    """A loop of %k from 0 to %n."""
    return f"""
define internal void @{name}({arguments}, i64 %n) nounwind noinline {{{{
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
}}}}
"""


_HELPERS = (
    """
declare ptr @malloc(i64)
declare void @free(ptr)
declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)
define internal ptr @aligned(ptr %room) nounwind {{
  %place = ptrtoint ptr %room to i64
  %beyond = add i64 %place, 63
  %whole = and i64 %beyond, -64
  %first = inttoptr i64 %whole to ptr
  ret ptr %first
}}
"""
    + _each(
        "copy",
        "ptr %target, ptr %source",
        """  %s = getelementptr {T}, ptr %source, i64 %k
  %x = load {T}, ptr %s, align {align}
  %d = getelementptr {T}, ptr %target, i64 %k
  store {T} %x, ptr %d, align {align}""",
    )
    + _each(
        "fetch",
        "ptr %target, ptr %S, ptr %places",
        """  %p = getelementptr i64, ptr %places, i64 %k
  %place = load i64, ptr %p, align 8
  %s = getelementptr {T}, ptr %S, i64 %place
  %x = load {T}, ptr %s, align {align}
  %d = getelementptr {T}, ptr %target, i64 %k
  store {T} %x, ptr %d, align {align}""",
    )
    + _each(
        "add",
        "ptr %target, ptr %source",
        """  %s = getelementptr {T}, ptr %source, i64 %k
  %d = getelementptr {T}, ptr %target, i64 %k
  %x = load {T}, ptr %s, align {align}
  %z = load {T}, ptr %d, align {align}
  %sum = fadd {T} %x, %z
  store {T} %sum, ptr %d, align {align}""",
    )
    + _each(
        "press",
        "ptr %S, ptr %targets, ptr %sources",
        """  %a = getelementptr i64, ptr %targets, i64 %k
  %b = getelementptr i64, ptr %sources, i64 %k
  %i = load i64, ptr %a, align 8
  %j = load i64, ptr %b, align 8
  %d = getelementptr {T}, ptr %S, i64 %i
  %s = getelementptr {T}, ptr %S, i64 %j
  %x = load {T}, ptr %d, align {align}
  %z = load {T}, ptr %s, align {align}
  %less = fsub {T} %x, %z
  store {T} %less, ptr %d, align {align}""",
    )
)

_DELIVER = """define internal void @deliver(
  ptr noalias %S, ptr %places, i64 %row, i64 %n, i64 %width, ptr noalias %target) nounwind noinline {
entry:
  %left = sub i64 %n, %row
  %few = icmp slt i64 %left, LANES
  %count = select i1 %few, i64 %left, i64 LANES
  %first = mul i64 %row, %width
  %to = getelementptr double, ptr %target, i64 %first
  br label %column
column:
  %k = phi i64 [0, %entry], [%k1, %after]
  %p = getelementptr i64, ptr %places, i64 %k
  %place = load i64, ptr %p, align 8
  %j = mul i64 %place, LANES
  %from = getelementptr double, ptr %S, i64 %j
  %toward = getelementptr double, ptr %to, i64 %k
  br label %lane
lane:
  %l = phi i64 [0, %column], [%l1, %lane]
  %s = getelementptr double, ptr %from, i64 %l
  %x = load double, ptr %s, align 8
  %i = mul i64 %l, %width
  %d = getelementptr double, ptr %toward, i64 %i
  store double %x, ptr %d, align 8
  %l1 = add i64 %l, 1
  %more = icmp slt i64 %l1, %count
  br i1 %more, label %lane, label %after
after:
  %k1 = add i64 %k, 1
  %others = icmp slt i64 %k1, %width
  br i1 %others, label %column, label %done
done:
  ret void
}
"""
"""Lanes to rows, those before the end: target[row + l][k] = S[places[k]][l]; there is at least one place."""
