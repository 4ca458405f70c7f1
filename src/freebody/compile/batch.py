"""The loop of a batch as LLVM IR: rows of arrays in, lanes of vectors through a function, rows out."""

from __future__ import annotations


def loop(name: str, state: int, hoisted: int, outputs: int, lanes: int) -> str:
    """``void name.batch(n, t, t_step, y, c, c_step, out)`` around ``name.lanes``; a step of 0 shares t or c."""
    T = f"<{lanes} x double>"
    return f"""define void @{name}.batch(i64 %n, ptr %t, i64 %ts, ptr %y, ptr %c, i64 %cs, ptr %out) nounwind {{
entry:
  %tt = alloca {T}, align 64
  %yy = alloca {T}, i64 {max(state, 1)}, align 64
  %cc = alloca {T}, i64 {max(hoisted, 1)}, align 64
  %oo = alloca {T}, i64 {max(outputs, 1)}, align 64
  %some = icmp sgt i64 %n, 0
  br i1 %some, label %first, label %done
first:
  call void @gather(ptr %t, i64 0, i64 %n, i64 1, i64 %ts, ptr %tt)
  call void @gather(ptr %c, i64 0, i64 %n, i64 {hoisted}, i64 %cs, ptr %cc)
  br label %block
block:
  %row = phi i64 [0, %first], [%next, %advance]
  call void @gather(ptr %y, i64 %row, i64 %n, i64 {state}, i64 {state}, ptr %yy)
  call void @{name}.lanes(ptr %tt, ptr %yy, ptr %cc, ptr %oo)
  call void @scatter(ptr %oo, i64 %row, i64 %n, i64 {outputs}, ptr %out)
  %next = add i64 %row, {lanes}
  %more = icmp slt i64 %next, %n
  br i1 %more, label %time, label %done
time:
  %timed = icmp ne i64 %ts, 0
  br i1 %timed, label %times, label %constants
times:
  call void @gather(ptr %t, i64 %next, i64 %n, i64 1, i64 %ts, ptr %tt)
  br label %constants
constants:
  %varied = icmp ne i64 %cs, 0
  br i1 %varied, label %vary, label %advance
vary:
  call void @gather(ptr %c, i64 %next, i64 %n, i64 {hoisted}, i64 %cs, ptr %cc)
  br label %advance
advance:
  br label %block
done:
  ret void
}}
"""


def gather(lanes: int) -> str:
    """Rows to lanes: target[j][k] = source[row + k][j]. Lanes past the last row repeat it."""
    return _GATHER.replace("LANES", str(lanes))


def scatter(lanes: int) -> str:
    """Lanes to rows, those before the end: target[row + k][j] = source[j][k]."""
    return _scattered("scatter", lanes, "", "", "%j")


def deliver(lanes: int) -> str:
    """Lanes to rows, those before the end: target[row + k][j] = source[places[j]][k]."""
    return _scattered("deliver", lanes, "ptr %places, ", _FOUND, "%place")


def _scattered(name: str, lanes: int, places: str, found: str, place: str) -> str:
    text = _SCATTER.replace("NAME", name).replace("LANES", str(lanes)).replace("PLACES", places)
    return text.replace("FOUND", found).replace("PLACE", place)


_GATHER = """define internal void @gather(
  ptr noalias %source, i64 %row, i64 %n, i64 %width, i64 %stride, ptr noalias %target) nounwind noinline {
entry:
  %last = sub i64 %n, 1
  %any = icmp sgt i64 %width, 0
  br i1 %any, label %lane, label %done
lane:
  %k = phi i64 [0, %entry], [%k1, %after]
  %r = add i64 %row, %k
  %in = icmp slt i64 %r, %last
  %r1 = select i1 %in, i64 %r, i64 %last
  %start = mul i64 %r1, %stride
  %from = getelementptr double, ptr %source, i64 %start
  %to = getelementptr double, ptr %target, i64 %k
  br label %column
column:
  %j = phi i64 [0, %lane], [%j1, %column]
  %p = getelementptr double, ptr %from, i64 %j
  %x = load double, ptr %p, align 8
  %j8 = mul i64 %j, LANES
  %q = getelementptr double, ptr %to, i64 %j8
  store double %x, ptr %q, align 8
  %j1 = add i64 %j, 1
  %more = icmp slt i64 %j1, %width
  br i1 %more, label %column, label %after
after:
  %k1 = add i64 %k, 1
  %lanes = icmp slt i64 %k1, LANES
  br i1 %lanes, label %lane, label %done
done:
  ret void
}
"""
_SCATTER = """define internal void @NAME(
  ptr noalias %source, PLACESi64 %row, i64 %n, i64 %width, ptr noalias %target) nounwind noinline {
entry:
  %left = sub i64 %n, %row
  %few = icmp slt i64 %left, LANES
  %count = select i1 %few, i64 %left, i64 LANES
  %first = mul i64 %row, %width
  %start = getelementptr double, ptr %target, i64 %first
  %any = icmp sgt i64 %width, 0
  br i1 %any, label %column, label %done
column:
  %j = phi i64 [0, %entry], [%j1, %after]
FOUND  %i = mul i64 PLACE, LANES
  %from = getelementptr double, ptr %source, i64 %i
  %to = getelementptr double, ptr %start, i64 %j
  br label %lane
lane:
  %k = phi i64 [0, %column], [%k1, %lane]
  %p = getelementptr double, ptr %from, i64 %k
  %x = load double, ptr %p, align 8
  %r = mul i64 %k, %width
  %q = getelementptr double, ptr %to, i64 %r
  store double %x, ptr %q, align 8
  %k1 = add i64 %k, 1
  %more = icmp slt i64 %k1, %count
  br i1 %more, label %lane, label %after
after:
  %j1 = add i64 %j, 1
  %columns = icmp slt i64 %j1, %width
  br i1 %columns, label %column, label %done
done:
  ret void
}
"""
_FOUND = """  %at = getelementptr i64, ptr %places, i64 %j
  %place = load i64, ptr %at, align 8
"""
