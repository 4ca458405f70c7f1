"""Templates of the loops over the links of a large tree as LLVM IR.

T is a number: a double, a vector of one double for each lane, or either with its derivatives behind it. S is the
workspace of `tree_parts`, c the constants, out the outputs. A kernel reads its arguments, loops over the links and
writes its outputs:

    CALL         one state, or eight side by side, in the order of S
    BATCH        rows, one for each lane at a time
    COLUMNS      a mass matrix: one state, with a different acceleration in each lane
    DERIVATIVE   one state, with a different direction in each lane
    ROWS         COLUMNS or DERIVATIVE row by row

The file is longer than others: it contains templates only.
"""

from __future__ import annotations

STARTS = (
    "constants", "places", "many", "tips", "passed", "added", "record", "parent", "own", "above", "parents_second",
)  # fmt: skip
"""A link's row of the table: start of its constants, start and number of its joint variables' places, places in S."""
ROW = len(STARTS) + 6  # the addresses of the steps follow

LOOP = (
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
        for k, name in enumerate(STARTS)
    )
    + "\n  %constants = getelementptr {C}, ptr %c, i64 %constants.place\n"
    + "\n".join(
        f"  %{name} = getelementptr {{T}}, ptr %S, i64 %{name}.place"
        for name in STARTS
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

NOTHING = """
define void @{name}(double %t, ptr %y, ptr %c, ptr %out) nounwind {{
  ret void
}}
define void @{name}.lanes(ptr %t, ptr %y, ptr %c, ptr %out) nounwind {{
  ret void
}}
define void @{name}.batch(i64 %n, ptr %t, i64 %ts, ptr %parts, ptr %c, i64 %cs, ptr %out) nounwind {{
  ret void
}}
"""

CALL = """
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

BATCH = """
define void @{name}.batch(i64 %n, ptr %t, i64 %ts, ptr %parts, ptr %c, i64 %cs, ptr %out) nounwind {{
entry:
  %room = call ptr @malloc(i64 {bytes})
  %S = call ptr @aligned(ptr %room)
  %S1 = getelementptr {T}, ptr %S, i64 1
  %S2 = getelementptr {T}, ptr %S, i64 2
  %some = icmp sgt i64 %n, 0
  br i1 %some, label %block, label %done
block:
  %row = phi i64 [0, %entry], [%next, %on]
  call void @gather.{lanes}(ptr %t, i64 %row, i64 %n, i64 1, i64 %ts, ptr %S1)
  call void @gather_parts.{lanes}(ptr %parts, i64 %row, i64 %n, i64 {state}, ptr %S2)
{vary}
  call void @{name}.core(ptr %S, ptr %C)
  call void @deliver.{lanes}(ptr %S, ptr inttoptr (i64 {table} to ptr), i64 %row, i64 %n, i64 {outputs}, ptr %out)
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
ONE = """  %ic = mul i64 %row, %cs
  %C = getelementptr double, ptr %c, i64 %ic"""
# constants of every lane, gathered for each block if they differ between rows
VARY = """  %C = getelementptr {T}, ptr %S, i64 {constants}
  %begin = icmp eq i64 %row, 0
  %differ = icmp ne i64 %cs, 0
  %anew = or i1 %begin, %differ
  br i1 %anew, label %vary, label %go
vary:
  call void @gather.{lanes}(ptr %c, i64 %row, i64 %n, i64 {hoisted}, i64 %cs, ptr %C)
  br label %go
go:"""

COLUMNS = """
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
  call void @gather.{lanes}(ptr %tt, i64 0, i64 1, i64 1, i64 0, ptr %S1)
  call void @gather.{lanes}(ptr %y, i64 0, i64 1, i64 {state}, i64 0, ptr %S2)
  call void @mass_matrix.begun(ptr %S, ptr %c)
  br label %block
block:
  %j = phi i64 [0, %begin], [%next, %block]
  call void @units(ptr %S, i64 %j, double 1.0)
  call void @columns(ptr %S, ptr %c)
  call void @deliver.{lanes}(ptr %S, ptr inttoptr (i64 {table} to ptr), i64 %j, i64 {n_u}, i64 {n_u}, ptr %out)
  call void @units(ptr %S, i64 %j, double 0.0)
  %next = add i64 %j, {lanes}
  %more = icmp slt i64 %next, {n_u}
  br i1 %more, label %block, label %done
done:
  call void @free(ptr %room)
  ret void
}}
"""

# row after row
ROWS = """
define void @{name}.batch(i64 %n, ptr %t, i64 %ts, ptr %parts, ptr %c, i64 %cs, ptr %out) nounwind {{
entry:
  %y = alloca double, i64 {room}, align 8
  %some = icmp sgt i64 %n, 0
  br i1 %some, label %loop, label %done
loop:
  %i = phi i64 [0, %entry], [%next, %loop]
  %it = mul i64 %i, %ts
  %ic = mul i64 %i, %cs
  %io = mul i64 %i, {outputs}
  %pt = getelementptr double, ptr %t, i64 %it
  %pc = getelementptr double, ptr %c, i64 %ic
  %po = getelementptr double, ptr %out, i64 %io
  %time = load double, ptr %pt, align 8
  call void @gather_parts.1(ptr %parts, i64 %i, i64 %n, i64 {state}, ptr %y)
  call void @{name}(double %time, ptr %y, ptr %pc, ptr %po)
  %next = add i64 %i, 1
  %more = icmp slt i64 %next, %n
  br i1 %more, label %loop, label %done
done:
  ret void
}}
"""

# the rates of number %k, at %b, in the columns from %j on
BY = """  %ahead = sub i64 %k, {first}
  %l = sub i64 %ahead, %j
  %near = icmp ult i64 %l, {lanes}
  %wanted = icmp ult i64 %ahead, {count}
  %own = and i1 %near, %wanted
  br i1 %own, label %one, label %on
one:
  %d = getelementptr double, ptr %b, i64 %l
  store double 1.0, ptr %d, align 8
  br label %on"""
ALONG = """  %behind = add i64 %k, {first}
  %pv = getelementptr double, ptr %y, i64 %behind
  %rate = load double, ptr %pv, align 8
  store double %rate, ptr %b, align 8
  br label %on"""

DERIVATIVE = """
define internal ptr @set(ptr %S, i64 %place, double %x) nounwind {{
  %a = getelementptr {T}, ptr %S, i64 %place
  %b = getelementptr double, ptr %a, i64 {lanes}
  %e = insertelement {V} poison, double %x, i64 0
  %each = shufflevector {V} %e, {V} poison, <{lanes} x i32> zeroinitializer
  store {V} %each, ptr %a, align 8
  store {V} zeroinitializer, ptr %b, align 8
  ret ptr %b
}}
define internal void @given(double %t, ptr %y, i64 %j, ptr %S) nounwind {{
entry:
  %time = call ptr @set(ptr %S, i64 1, double %t)
  %some = icmp sgt i64 {state}, 0
  br i1 %some, label %loop, label %done
loop:
  %k = phi i64 [0, %entry], [%next, %on]
  %p = getelementptr double, ptr %y, i64 %k
  %x = load double, ptr %p, align 8
  %place = add i64 %k, 2
  %b = call ptr @set(ptr %S, i64 %place, double %x)
{begin}
on:
  %next = add i64 %k, 1
  %more = icmp slt i64 %next, {state}
  br i1 %more, label %loop, label %done
done:
  ret void
}}
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)
define internal void @taken(ptr %S, i64 %j, ptr %out) nounwind {{
entry:
  %left = sub i64 {columns}, %j
  %few = icmp slt i64 %left, {lanes}
  %count = select i1 %few, i64 %left, i64 {lanes}
  %bytes = mul i64 %count, 8
  %some = icmp sgt i64 {outputs}, 0
  br i1 %some, label %loop, label %done
loop:
  %k = phi i64 [0, %entry], [%next, %loop]
  %pp = getelementptr i64, ptr inttoptr (i64 {table} to ptr), i64 %k
  %place = load i64, ptr %pp, align 8
  %a = getelementptr {T}, ptr %S, i64 %place
  %b = getelementptr double, ptr %a, i64 {lanes}
  %row = mul i64 %k, {columns}
  %to = add i64 %row, %j
  %d = getelementptr double, ptr %out, i64 %to
  call void @llvm.memcpy.p0.p0.i64(ptr %d, ptr %b, i64 %bytes, i1 false)
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
  %j = phi i64 [0, %entry], [%next, %block]
  call void @given(double %t, ptr %y, i64 %j, ptr %S)
  call void @{name}.core(ptr %S, ptr %c)
  call void @taken(ptr %S, i64 %j, ptr %out)
  %next = add i64 %j, {lanes}
  %more = icmp slt i64 %next, {columns}
  br i1 %more, label %block, label %done
done:
  call void @free(ptr %room)
  ret void
}}
"""


def _each(name: str, arguments: str, body: str) -> str:
    """A function with a loop over %k from 0 to %n."""
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


HELPERS = (
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
