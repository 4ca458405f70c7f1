"""Random loops over components of rows, and their run in CPython."""

from __future__ import annotations

import random
import textwrap
from types import SimpleNamespace
from typing import Annotated

import numpy as np

from freebody.native.functions import Compiled
from freebody.native.records import Count, Real, Record, Row, Rows, record_of_lanes
from random_programs import OF_NUMPY, module


@record_of_lanes
class Some(Record):
    n: Count
    width: Count
    h: Real
    top: Real
    total: Real
    greatest: Real
    count: Real
    y: Annotated[Row, "width"]
    out: Annotated[Row, "width"]
    k: Annotated[Rows, 3, "width"]
    given: Row


HEAD = """
import math
from freebody.native.functions import components, unrolled
from freebody.native.instructions import Real, compiled, greater, inlined, larger, lesser, maximum, muladd, root, where
from random_loops import Some

TABLE = (0.5, -2.0, 3.0)
"""


def functions(text, folder, name="loops"):
    """The compiled functions of a text."""
    made = module([HEAD, textwrap.dedent(text)], folder, name)
    return {k: v for k, v in vars(made).items() if isinstance(v, Compiled) and k.startswith("f")}


class Writer:
    """Writer of a random loop over components."""

    def __init__(self, seed):
        self.random, self.names, self.lines = random.Random(seed), [], []

    def number(self, depth=3):
        r, e = self.random, self.number
        if depth == 0 or r.random() < 0.2:
            names = self.names or ["s.h"]
            return r.choice(
                ["s.y[i]", f"s.k[{r.randrange(3)}, i]", "s.h", r.choice(names), "1.5", "-0.25", "3.0"]
            )
        way = r.randrange(9)
        if way == 8:
            return f"larger(abs({e(depth - 1)}), abs({e(depth - 1)}))"
        if way < 4:
            return f"({e(depth - 1)} {r.choice('+-*/')} {e(depth - 1)})"
        if way == 4:
            return f"{r.choice(['greater', 'lesser', 'maximum'])}({e(depth - 1)}, {e(depth - 1)})"
        if way == 5:
            return f"where({e(1)} {r.choice(['<', '>=', '=='])} {e(1)}, {e(depth - 1)}, {e(depth - 1)})"
        return r.choice([f"abs({e(depth - 1)})", f"root({e(depth - 1)})", f"-{e(depth - 1)}"])

    def statement(self, indent):
        r = self.random
        way = r.randrange(8)
        if way == 7:
            self.lines.append(f"{indent}size = larger(size, abs({self.number()}))")
        elif way < 2:
            value = f"{self.number()} + 0.0 * s.y[i]"  # a name keeps its type: a number for each component
            name = r.choice([*self.names, f"v{len(self.names)}"])
            self.names += [name] if name not in self.names else []
            self.lines.append(f"{indent}{name} = {value}")
        elif way < 4:
            place = r.choice(["s.out[i]", f"s.k[{r.randrange(3)}, i]"])
            self.lines.append(f"{indent}{place} {r.choice(['=', '+=', '*='])} {self.number()}")
        elif way == 4:
            self.lines.append(f"{indent}top = maximum(top, {self.number()})")
        elif way == 5:  # sums of small integers: their order does not matter
            self.lines.append(f"{indent}total += where({self.number()} > {self.number(1)}, 1.0, -2.0)")
        elif indent == " " * 8:
            self.lines.append(f"{indent}for j in unrolled({r.choice(['2', '1, 3', '0'])}):")
            names = list(self.names)
            self.statement(indent + "    ")
            self.lines.append(f"{indent}    s.out[i] = s.out[i] * 0.5 + s.k[j, i] * TABLE[j]")
            self.names = names

    def text(self, name):
        for _ in range(self.random.randint(2, 7)):
            self.statement(" " * 8)
        body = "\n".join(self.lines)
        return (
            f"def {name}(s: Some) -> None:\n    top: Real = s.top\n    total: Real = s.total\n"
            f"    size: Real = abs(s.greatest)\n    for i in components(s.n):\n{body}\n        s.y[i] = s.y[i] + 1.0\n"
            "    s.top = top\n    s.total = total\n    s.greatest = size\n"
        )


def in_python(text, name, values):
    """What CPython gives, with numbers of NumPy."""
    s = SimpleNamespace(**{k: np.array(v) if np.ndim(v) else np.float64(v) for k, v in values.items()})
    s.n = values["n"]

    def of_two(a, b):
        return a if a > b or a != a else b

    space = {
        **OF_NUMPY,
        "maximum": of_two,
        "larger": of_two,
        "abs": abs,
        "components": range,
        "unrolled": range,
        "TABLE": (0.5, -2.0, 3.0),
        "Some": None,
    }
    exec(text, space)
    with np.errstate(all="ignore"):
        space[name](s)
    return s
