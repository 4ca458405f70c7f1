"""Random programs of the compiled language, and their run in CPython.

Numbers of the compiled language have the arithmetic of NumPy's int64 and float64: integers wrap at 64 bits, a division
by zero gives infinity, nan or 0, an integer that meets a real number is rounded to one. So a program is run in CPython
with numbers of NumPy: its text is the same, except that literals become such numbers. If no operation was exceptional
there, the run with Python's own numbers must agree as well.
"""

from __future__ import annotations

import ast
import importlib.util
import itertools
import math
import random

import numpy as np

from freebody.native import codegen
from freebody.native.functions import Compiled
from freebody.native.translation import translated

SIZE = 6
"""Length of the arrays that programs read and write."""


class Writer:
    """Writer of one program: functions that call those before them."""

    def __init__(self, seed: int, wide: bool = False) -> None:
        self.random = random.Random(seed)
        self.name, self.wide = f"f{seed}", wide
        self.lines: list[str] = []
        self.functions: list[tuple[str, str, list[str]]] = []  # name, kind, kinds of arguments
        self.names: dict[str, str] = {}
        self.fresh, self.depth, self.loops, self.mask = 0, 0, 0, ""
        self.integers = False  # whether there is an array of integers

    # -- expressions --

    def pick(self, kind: str) -> str | None:
        names = [name for name, other in self.names.items() if other == kind]
        return self.random.choice(names) if names else None

    def literal(self, kind: str) -> str:
        r = self.random
        if kind == "int":
            return str(r.choice([0, 1, 2, 3, 5, 7, 12, 100, 2**31, 2**40 + 1]))
        return repr(r.choice([0.0, 0.5, 1.0, 1.5, 3.0, 0.1, 1e-3, 1e10, 7.25, 1e-300]))

    def atom(self, kind: str) -> str:
        """A name or a component; a literal if there is none."""
        r = self.random
        if kind == "float" and r.random() < 0.2:
            return f"p[{self.place()}]"
        if kind == "int" and self.integers and r.random() < 0.2:
            return f"k[{self.place()}]"
        if r.random() < 0.75 and (name := self.pick(kind)):
            return name
        return self.literal(kind)

    def place(self) -> str:
        if self.wide:
            count = self.pick("count") if self.random.random() < 0.5 else None
            return count or str(self.random.randrange(SIZE))
        return (
            f"({self.expression('int', 1)}) % {SIZE}"
            if self.random.random() < 0.6
            else str(self.random.randrange(SIZE))
        )

    def expression(self, kind: str, depth: int = 3) -> str:
        r = self.random
        if depth <= 0 or r.random() < 0.15:
            return self.atom(kind) if kind != "bool" else self.comparison(0)
        return getattr(self, f"_{kind}")(depth - 1)

    def varying(self, kind: str, d: int) -> str:
        """An expression with a name: one of literals is evaluated during translation, in integers of any length."""
        value = self.expression(kind, d)
        named = any(isinstance(x, ast.Name) for x in ast.walk(ast.parse(value)))
        return value if named else (self.pick(kind) or "p[0]")

    def _int(self, d: int) -> str:
        r, e = self.random, self.varying
        way = r.randrange(10)
        if way < 4:
            return f"({e('int', d)} {r.choice(['+', '-', '*'])} {e('int', d)})"
        if way == 4:
            divisor = self.pick("int") if r.random() < 0.5 else None
            return f"({e('int', d)} {r.choice(['//', '%'])} {divisor or r.choice(['3', '7', '-4', '1', '-1', '64'])})"
        if way == 5:
            return f"({e('int', d)} {r.choice(['<<', '>>'])} {r.choice(['1', '3', '17', '63'])})"
        if way == 6:
            return f"({e('int', d)} {r.choice(['&', '|', '^'])} {e('int', d)})"
        if way == 7:
            return f"-{e('int', d)}" if r.random() < 0.5 else f"abs({e('int', d)})"
        if way == 8:
            return self.choice("int", d)
        return self.call("int", d) or self.atom("int")

    def _float(self, d: int) -> str:
        r, e = self.random, self.varying
        way = r.randrange(11)
        if way < 4:
            return f"({e('float', d)} {r.choice(['+', '-', '*', '*'])} {e('float', d)})"
        if way == 4:
            divisor = self.pick("float") if r.random() < 0.6 else None
            return f"({e('float', d)} / {divisor or r.choice(['3.0', '0.7', '-4.0'])})"
        if way == 5:
            integer = self.pick("int") or "a"
            return f"({e('float', d)} {r.choice(['+', '-', '*'])} {integer})"
        if way == 6:
            return r.choice([f"-{e('float', d)}", f"abs({e('float', d)})", f"root({e('float', d)})"])
        if way == 7:
            if r.random() < 0.3:  # the sign of what is no number is not defined
                name = self.pick("float") or "p[0]"
                return f"signed({e('float', d)}, where({name} == {name}, {name}, 1.0))"
            return f"{r.choice(['greater', 'lesser'])}({e('float', d)}, {e('float', d)})"
        if way == 8:
            return self.choice("float", d)
        if way == 9 and not self.wide:
            return f"poke(p, {self.expression('int', 1)}, {e('float', d)})"
        return self.call("float", d) or self.atom("float")

    def choice(self, kind: str, d: int) -> str:
        a, c, b = self.expression(kind, d), self.comparison(d), self.expression(kind, d)
        if self.wide or self.random.random() < 0.3:
            return f"where({c}, {a}, {b})"
        return f"({a} if {c} else {b})"

    def _bool(self, d: int) -> str:
        r = self.random
        way = r.randrange(6)
        if way < 2:
            return self.comparison(d)
        if way == 2:
            return f"(not {self.expression('bool', d)})"
        if way == 3:
            return f"({self.comparison(0)} {r.choice(['==', '!=', '<', '>='])} {self.comparison(0)})"
        if way == 4 and (name := self.pick("bool")):
            return name
        parts = [self.expression("bool", d) for _ in range(r.choice([2, 2, 3]))]
        return f"({r.choice([' and ', ' or ']).join(parts)})"

    def comparison(self, d: int) -> str:
        """A comparison that begins with a name, so that it is not a constant."""
        r = self.random
        kind = r.choice(["int", "float"])
        name = self.pick(kind)
        if name is None:
            kind, name = "float", self.pick("float") or "p[0]"
        signs = ["<", "<=", ">", ">=", "==", "!="]
        parts = [name]
        for _ in range(r.choice([1, 1, 1, 2])):
            parts += [r.choice(signs), self.expression(r.choice([kind, "int"]), 0 if self.wide else d)]
        if r.random() < 0.1:
            return f"finite({self.pick('float') or 'p[1]'})"
        return f"({' '.join(parts)})"

    def call(self, kind: str, d: int) -> str | None:
        functions = [f for f in self.functions if f[1] == kind]
        if not functions:
            return None
        name, _, kinds = self.random.choice(functions)
        return f"{name}({', '.join(self.expression(k, d) for k in kinds)}, p)"

    # -- statements --

    def emit(self, text: str) -> None:
        self.lines.append("    " * (self.depth + 1) + text)

    def new(self, kind: str) -> str:
        self.fresh += 1
        name = f"v{self.fresh}"
        self.names[name] = kind
        return name

    def typed(self, kind: str) -> str:
        """An expression whose type is that of the kind, for the first value of a name."""
        value = self.expression(kind)
        if self.wide and kind != "bool":  # in each lane
            lane = self.pick(kind) or "p[0]"
            return f"{value} + {'0.0' if kind == 'float' else '0'} * {lane}"
        return f"{value} + 0.0" if kind == "float" else value

    def statement(self, budget: int) -> None:
        r = self.random
        way = r.randrange(12)
        if way < 4 or budget <= 0:
            self.assignment()
        elif way == 4:
            kind = r.choice(["int", "float"])
            name = self.changeable(kind)
            if name and not self.mask:
                signs = ["+=", "-=", "*="] + (["/="] if kind == "float" else ["&=", "^="])
                value = r.choice(["3", "7"]) if kind == "int" else r.choice(["3.0", "0.5"])
                self.emit(f"{name} {r.choice(signs)} {value}")
            else:
                self.assignment()
        elif way == 5:
            kind = r.choice(["int", "float"])
            names = [name for name, other in self.names.items() if other == kind]
            if len(names) > 1 and not self.mask:
                x, y = r.sample(names, 2)
                self.emit(f"{x}, {y} = {y}, {self.expression(kind)}")
            else:
                self.assignment()
        elif way == 6:
            self.store()
        elif way < 9:
            self.branch(budget - 1)
        elif way == 9:
            self.count(budget - 1)
        elif way == 10:
            self.loop(budget - 1)
        else:
            self.rare(budget - 1) if self.wide else self.assignment()

    def changeable(self, kind: str) -> str | None:
        names = [n for n, other in self.names.items() if other == kind and not n.startswith("n")]
        return self.random.choice(names) if names else None

    def assignment(self) -> None:
        kind = self.random.choice(["int", "float", "float", "bool"])
        name = self.changeable(kind) if self.random.random() < 0.6 else None
        if name is None:
            value = self.typed(kind)
            self.emit(f"{self.new(kind)} = {value}")
            return
        value = self.expression(kind)
        self.emit(f"{name} = where({self.mask}, {value}, {name})" if self.mask else f"{name} = {value}")

    def store(self) -> None:
        place = self.place()
        if self.wide:
            value = self.expression("float")
            self.emit(
                f"p[{place}] = where({self.mask}, {value}, p[{place}])"
                if self.mask
                else f"p[{place}] = {value}"
            )
        elif self.random.random() < 0.7:
            self.emit(f"p[{place}] {self.random.choice(['=', '=', '+=', '*='])} {self.expression('float')}")
        else:
            self.emit(f"k[{place}] {self.random.choice(['=', '+=', '^='])} {self.expression('int')}")

    def within(self, budget: int, count: int = 2) -> None:
        """Statements one level deeper; names that are new there are forgotten."""
        names = dict(self.names)
        self.depth += 1
        for _ in range(self.random.randint(1, count)):
            self.statement(budget)
        self.depth -= 1
        self.names = names

    def branch(self, budget: int) -> None:
        if self.wide:
            if self.mask:
                self.assignment()
                return
            mask = self.new("bool")
            del self.names[mask]
            self.emit(f"{mask} = {self.comparison(1)}")
            self.emit(self.random.choice([f"if any({mask}):", f"if rare(any({mask})):"]))
            self.mask = mask
            self.within(budget)
            self.mask = ""
            return
        self.emit(f"if {self.expression('bool', 2)}:")
        self.within(budget)
        if self.random.random() < 0.3:
            self.emit(f"elif {self.expression('bool', 2)}:")
            self.within(budget)
        if self.random.random() < 0.5:
            self.emit("else:")
            self.within(budget)
            if self.random.random() < 0.15:
                self.depth += 1
                self.leave()
                self.depth -= 1

    def leave(self) -> None:
        if self.loops and self.random.random() < 0.7:
            self.emit(self.random.choice(["break", "continue"]))
        else:
            self.emit(f"return {self.expression('float')} + 0.0")

    def count(self, budget: int) -> None:
        if self.loops > 1:
            self.assignment()
            return
        self.fresh += 1
        number = f"n{self.fresh}"
        bounds = self.random.choice(["3", "1, 4", "5, 0, -2", "0", "2, 6, 3"])
        if not self.wide and self.random.random() < 0.4 and (name := self.pick("int")):
            bounds = f"{name} % 4"
        self.emit(f"for {number} in range({bounds}):")
        self.loops += 1
        self.names[number] = "count" if self.wide else "int"
        self.within(budget)
        del self.names[number]
        self.loops -= 1

    def loop(self, budget: int) -> None:
        if self.loops > 1 or self.mask:
            self.assignment()
            return
        self.fresh += 1
        number = f"n{self.fresh}"
        self.emit(f"{number} = 0")
        if self.wide:
            mask = f"m{self.fresh}"
            self.emit(f"{mask} = {self.comparison(0)}")
            self.emit(f"while any({mask}) and {number} < 3:")
            self.depth += 1
            self.emit(f"{number} += 1")
            self.depth -= 1
            self.loops += 1
            self.mask = mask
            self.within(budget)
            self.depth += 1
            self.emit(f"{mask} = {mask} and {self.comparison(0)}")
            self.depth -= 1
            self.loops -= 1
            self.mask = ""
            return
        self.emit(f"while {number} < 4 and {self.expression('bool', 1)}:")
        self.depth += 1
        self.emit(f"{number} += 1")
        self.depth -= 1
        self.loops += 1
        self.within(budget)
        self.loops -= 1

    def rare(self, budget: int) -> None:
        name = self.changeable("float")
        if self.mask or not name or not self.wide:
            self.assignment()
            return
        self.fresh += 1
        self.emit(f"for l{self.fresh} in each({self.comparison(0)}):")
        self.emit(f"    s{self.fresh} = {name}[l{self.fresh}]")
        self.emit(f"    {name}[l{self.fresh}] = alone(s{self.fresh}, 3)")

    # -- functions --

    def function(self, name: str, kinds: dict[str, str], kind: str, statements: int) -> None:
        lane = {"int": "Whole", "float": "Real"} if self.wide else {"int": "int", "float": "float"}
        arguments = ", ".join(f"{x}: {lane[k]}" for x, k in kinds.items())
        self.lines.append(f"def {name}({arguments}, p: {'Row' if self.wide else 'Reals'}) -> {lane[kind]}:")
        self.names, self.loops = dict(kinds), 0
        if not self.wide:
            self.names["b0"] = "bool"
            self.emit("b0 = a0 > 2")
        save = self.functions
        body, self.functions = self.functions, []
        for _ in range(statements):
            self.assignment()
        self.functions = save
        self.emit(f"return {self.expression(kind)}{' + 0.0' if kind == 'float' else ''}")
        self.lines.append("")
        body.append((name, kind, list(kinds.values())))

    def text(self) -> str:
        """The program: helpers, then the function of its name."""
        own = self.name
        for number, kind in enumerate(("int", "float")):
            kinds = {"a0": "int", "x0": "float"} if number else {"a0": "int"}
            self.function(f"{own}_{number}", kinds, kind, 2)
        if self.wide:
            self.lines.append(f"def {own}(p: Row, j: int) -> None:")
            self.names = {"a": "int", "x": "float", "y": "float"}
            self.emit("x, y, a = p[0], p[1], whole(p[2] * 4.0)")
        else:
            self.lines.append(
                f"def {own}(a: int, b: int, x: float, y: float, p: Reals, k: Integers) -> float:"
            )
            self.names = {"a": "int", "b": "int", "x": "float", "y": "float"}
        self.integers = not self.wide
        for _ in range(self.random.randint(3, 7)):
            self.statement(2)
        if self.wide:
            self.emit(f"p[3] = {self.expression('float')}")
            self.emit("p[4] = x - y")
            self.emit("p[5] = 0.0 + a")
        else:
            self.emit(f"return {self.expression('float')} + 0.0")
        return "\n".join(self.lines) + "\n"


HEAD = """from __future__ import annotations

from freebody.native.instructions import greater, lesser, root, where, whole
from freebody.native.functions import Compiled, each, rare
from math import copysign as signed
from math import isfinite as finite


def poke(p: Reals, i: int, x: float) -> float:
    before = p[i % 6]
    p[i % 6] = x
    return before


def alone(x: float, n: int) -> float:
    for i in range(n):
        if x > i:
            x = x * 0.5 - i
    return x


"""


def module(texts, folder, name):
    """A module with these programs, in a file of its own, whose functions are marked as compiled."""
    path = folder / f"{name}.py"
    path.write_text(HEAD + "\n".join(texts))
    spec = importlib.util.spec_from_file_location(name, path)
    result = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(result)
    for key, value in [*vars(result).items()]:
        if getattr(value, "__module__", None) == name:
            setattr(result, key, Compiled(value))
    return result


class _Literals(ast.NodeTransformer):
    """Literals become numbers of NumPy."""

    def visit_Constant(self, node):
        kind = {int: "int64", float: "float64"}.get(type(node.value))
        if kind is None:
            return node
        return ast.copy_location(ast.Call(ast.Name(kind, ast.Load()), [node], []), node)

    def visit_Subscript(self, node):
        """A number of one run is that in its only lane."""
        self.generic_visit(node)
        of_lane = isinstance(node.slice, ast.Name) and node.slice.id.startswith("l")
        return ast.copy_location(ast.Name(node.value.id, node.ctx), node) if of_lane else node


def _whole(x):
    x = float(x)
    if math.isnan(x):
        return np.int64(0)
    return (
        np.int64(max(min(int(x), 2**63 - 1), -(2**63)))
        if math.isfinite(x)
        else np.int64(-(2**63) if x < 0 else 2**63 - 1)
    )


SHARED = {
    "Reals": None, "Integers": None, "Row": None, "Real": None, "Whole": None,
    "where": lambda c, a, b: a if c else b, "any": bool, "all": bool, "rare": bool,
    "each": lambda c: range(1) if c else (),
    "greater": lambda a, b: a if a > b else b, "lesser": lambda a, b: a if a < b else b,
    "whole": _whole, "finite": math.isfinite,
}  # fmt: skip
OF_NUMPY = {
    **SHARED, "int64": np.int64, "float64": np.float64, "root": np.sqrt, "signed": np.copysign,
    "range": lambda *bounds: map(np.int64, range(*map(int, bounds))),
}  # fmt: skip
OF_PYTHON = {**SHARED, "root": math.sqrt, "signed": math.copysign, "whole": lambda x: int(_whole(x))}


def in_python(text, names, of_numpy):
    """The functions of a program as CPython runs them, with numbers of NumPy or with its own."""
    body = HEAD[HEAD.index("def poke") :] + text
    tree = ast.parse("from __future__ import annotations\n" + body)
    if of_numpy:
        tree = ast.fix_missing_locations(_Literals().visit(tree))
    space = dict(names)
    exec(compile(tree, "program", "exec"), space)
    return space


def bits(value):
    """The bits of numbers; all that are no numbers count as one."""
    value = np.asarray(value, dtype=float)
    return (
        np.where(np.isnan(value), np.nan, value).view(np.int64).tolist() if value.ndim else bits(value[None])
    )


ARGUMENTS = [
    (a, b, x, y)
    for (a, b), (x, y) in itertools.product(
        [(0, 3), (-7, 5), (2**62 + 3, -1)],
        [(0.0, -0.0), (0.1, -2.5), (float("nan"), float("inf"))],
    )
]


def compiled(texts, names, folder, name, lanes=1, target=None):
    """Library and addresses of programs; their object code for another target."""
    made = module(texts, folder, name)
    text = translated({n: getattr(made, n) for n in names}, lanes)
    if target:
        return codegen.optimised_code(text, target)
    code, _ = codegen.optimised_code(text)
    library = codegen.Library(code)
    return library, library.addresses(names)


def arrays(random):
    return random.uniform(-3, 3, SIZE), random.integers(-9, 9, SIZE)
