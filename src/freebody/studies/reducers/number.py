"""Numbers of a whole run, written as text: ``max(theta') - final(theta)``, ``end``, ``event_count["hit"] > 0``.

A text is read once, by Python's own parser, into instructions for a stack; they are then carried out for all lanes of
a block at once. A condition is 1 where it holds and 0 where it does not. Where a number has no finite value, it is
nan, and so is a condition that depends on it (Kleene's logic: ``False and nan`` is False).
"""

from __future__ import annotations

import ast
import keyword
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError, nearest, shown
from ...motion.trajectory.outputs import CONTACT_MODES, REDUCTIONS, reduction

Array = NDArray[np.float64]
Instruction = tuple[str, Any]

LENGTH = 2000
"""Greatest length of a text, in characters."""
DEPTH = 100
"""Greatest depth of operations within operations."""
EVENTS = ("event_time", "event_last", "event_count")
"""Results of an event, written ``event_time["hit"]``: its first and last time [s], and how often it happened."""
FUNCTIONS: dict[str, tuple[int, Callable[..., Any]]] = {
    **{
        name: (1, getattr(np, name))
        for name in (
            "sqrt",
            "exp",
            "log",
            "log10",
            "sin",
            "cos",
            "tan",
            "sinh",
            "cosh",
            "tanh",
            "floor",
            "ceil",
        )
    },
    **{name: (1, getattr(np, name.replace("a", "arc", 1))) for name in ("asin", "acos", "atan")},
    "atan2": (2, np.arctan2),
    "hypot": (2, np.hypot),
    "abs": (1, np.abs),
    "sign": (1, np.sign),
}
"""Functions of numbers: how many numbers they take, and how they are computed."""
_EXTREMES = {"max": np.maximum, "min": np.minimum}
_OPERATIONS: dict[type, Callable[..., Any]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.FloorDiv: np.floor_divide,
    ast.Mod: np.mod,
    ast.Pow: np.power,
}
_COMPARISONS: dict[type, Callable[..., Any]] = {
    ast.Lt: np.less,
    ast.LtE: np.less_equal,
    ast.Gt: np.greater,
    ast.GtE: np.greater_equal,
    ast.Eq: np.equal,
    ast.NotEq: np.not_equal,
}
_CALLABLE: dict[str, Callable[..., Any]] = {
    **{name: function for name, (_, function) in FUNCTIONS.items()},
    **_EXTREMES,
    **{kind.__name__: function for kind, function in {**_OPERATIONS, **_COMPARISONS}.items()},
    "USub": np.negative,
}
_INSTEAD: dict[type, str] = {
    ast.BitXor: "Write ** for a power.",
    ast.BitAnd: "Write and.",
    ast.BitOr: "Write or.",
    ast.Invert: "Write not.",
    ast.IfExp: "Write a condition times a number.",
}
_TOKEN = re.compile(
    r"""(?P<quoted>"[^"]*"|(?<![\w'])'[^']*')
    | (?P<literal>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)
    | (?P<name>[^\W\d]\w*(?:'+\w*|\.\w+)*)""",
    re.VERBOSE,
)
_SUBSCRIPT = re.compile(r"""\s*\[\s*("[^"]*"|'[^']*')\s*\]""")
_MODE = re.compile(r"(?:initial|final)\(.*\.mode\)\Z")


@dataclass(frozen=True)
class Number:
    """A number of a whole run.

    ``text``       as the user wrote it
    ``wanted``     outputs that it reads, such as ``max(theta')``
    ``names``      other names that it reads: parameters, starts, ``end``, ``event_time["hit"]``
    ``code``       instructions for a stack
    ``condition``  True if it is a condition
    """

    text: str
    wanted: tuple[str, ...] = field(compare=False)
    names: tuple[str, ...] = field(compare=False)
    code: tuple[Instruction, ...] = field(compare=False, repr=False)
    condition: bool = field(compare=False)

    def of(self, columns: Mapping[str, Any], count: int) -> Array:
        """Return the number of each of ``count`` lanes; nan where it has no finite value."""
        stack: list[Any] = []
        with np.errstate(all="ignore"):
            for what, argument in self.code:
                if what == "column":
                    stack.append(_finite(np.ascontiguousarray(columns[argument], dtype=float)))
                elif what == "constant":
                    stack.append(np.float64(argument))
                else:
                    operands = stack[-argument[1] :]
                    del stack[-argument[1] :]
                    stack.append(_ACTIONS[what](argument[0], operands))
        return np.array(np.broadcast_to(stack[0], count))


def event_column(kind: str, event: str) -> str:
    """Return the name of a column of an event.

    >>> event_column("event_time", "hit")
    'event_time["hit"]'
    """
    return f'{kind}["{event}"]'


def number_of(text: Any, where: str) -> Number:
    """Return the number that a text stands for; ``where`` names its place in messages.

    Raises
    ------
    SimulationError
        The text is no number of a whole run.
    """
    if not isinstance(text, str) or not text.strip():
        raise SimulationError(
            f'Expected a number of a run for {where}, such as "max(theta\') > 6", got {shown(text)}.'
        )
    if len(text) > LENGTH:
        raise SimulationError(
            f"Expected at most {LENGTH} characters for {where}, got {len(text)}. Make a part of it an output."
        )
    reader = _Reader(text, where)
    condition = reader.read()
    if not reader.columns:
        raise SimulationError(
            f"Expected a number that differs from run to run for {where}, got the constant {text!r}."
        )
    wanted = tuple(x for x in reader.columns if reduction(x)[0])
    names = tuple(x for x in reader.columns if x not in wanted)
    return Number(text, wanted, names, tuple(reader.code), condition)


def check_names(names: Iterable[str], known_names: Iterable[str], where: str) -> None:
    """Refuse a name that no run has.

    Raises
    ------
    SimulationError
        Names the nearest known name.
    """
    known = sorted(set(known_names))
    for name in names:
        if name not in known:
            raise SimulationError(
                f"Unknown name '{name}' in {where}; {nearest(name, known)} Of a quantity that changes in a run, write "
                f"{', '.join(f'{how}({name})' for how in REDUCTIONS[:-1])} or {REDUCTIONS[-1]}({name})."
            )


def _finite(x: Any) -> Any:
    """Return numbers with nan in place of infinite ones."""
    finite = np.isfinite(x)
    return x if finite.all() else np.where(finite, x, np.nan)


def _applied(name: str, operands: list[Any]) -> Any:
    function = _CALLABLE[name]
    if name not in _EXTREMES:
        return _finite(function(*operands))
    result = operands[0]
    for x in operands[1:]:
        result = function(result, x)
    return result


def _compared(names: tuple[str, ...], operands: list[Any]) -> Any:
    parts = []
    for name, a, b in zip(names, operands, operands[1:], strict=False):
        holds = _CALLABLE[name](a, b)
        parts.append(np.where(np.isnan(a) | np.isnan(b), np.nan, holds))
    return _all("", parts)


def _all(_: str, parts: list[Any]) -> Any:
    """Return 0 where any part is 0, else nan where any is nan, else 1."""
    result = parts[0]
    for x in parts[1:]:
        result = np.where(
            (result == 0) | (x == 0), 0.0, np.minimum(result, x)
        )  # the least is nan if either is
    return result


_ACTIONS: dict[str, Callable[[Any, list[Any]], Any]] = {
    "apply": _applied,
    "compare": _compared,
    "all": _all,
    "any": lambda _, parts: 1 - _all("", [1 - x for x in parts]),
    "not": lambda _, parts: 1 - parts[0],
}


class _Reader:
    """Reader of one text."""

    def __init__(self, text: str, where: str) -> None:
        self.text, self.where = text, where
        self.columns: list[str] = []
        self.code: list[Instruction] = []

    def error(self, reason: str) -> SimulationError:
        return SimulationError(f"Expected a number of a run for {self.where}, got {self.text!r}: {reason}")

    def read(self) -> bool:
        """Write the instructions; return True for a condition."""
        text = "".join(self.python(self.text)).strip()
        try:
            tree = ast.parse(text, mode="eval")
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise self.error(
                'it is not an expression of numbers. Write it as in Python, such as "max(theta\') - 2*final(x) > 6".'
            ) from None
        return self.visit(tree.body, 0)

    # -- from the text to Python's syntax ---------------------------------------------------------------------

    def python(self, text: str) -> Iterator[str]:
        """Yield pieces of the text in Python's syntax, with ``_k`` in place of column k."""
        place = 0
        while place < len(text):
            token = _TOKEN.match(text, place)
            if token is None:
                yield " " if text[place].isspace() else text[place]
                place += 1
            elif token.lastgroup == "quoted":
                yield repr(token[0][1:-1])
                place = token.end()
            elif token.lastgroup == "literal" or keyword.iskeyword(token[0]):
                yield token[0]
                place = token.end()
            else:
                piece, place = self.named(text, token[0], token.end())
                yield f" {piece} "  # 2x is not 2_0

    def named(self, text: str, name: str, end: int) -> tuple[str, int]:
        """Return the Python text of a name with what belongs to it, and the place behind."""
        event = _SUBSCRIPT.match(text, end) if name in EVENTS else None
        if event:
            return self.column(event_column(name, event[1][1:-1])), event.end()
        call = re.compile(r"\s*\(").match(text, end)
        if call and name in REDUCTIONS:
            close = _closing(text, call.end())
            inside = text[call.end() : close].strip()
            if close < len(text) and inside and reduction(f"{name}({inside})")[0]:
                return self.column(f"{name}({inside})"), close + 1
        if call or name == "pi":
            return name, end
        return self.column(name), end

    def column(self, name: str) -> str:
        """Return the Python name of a column."""
        if name not in self.columns:
            self.columns.append(name)
        return f"_{self.columns.index(name)}"

    # -- from Python's syntax to instructions -----------------------------------------------------------------

    def visit(self, node: ast.expr, depth: int) -> bool:
        """Write the instructions of a part; return True for a condition."""
        if depth > DEPTH:
            raise self.error(f"it has more than {DEPTH} operations within each other.")
        visit = getattr(self, f"visit_{type(node).__name__}", None)
        if visit is None:
            raise self.error(self.instead(node))
        return visit(node, depth + 1)

    def instead(self, node: Any) -> str:
        cure = _INSTEAD.get(type(node), "Numbers, names, + - * / **, comparisons, and, or, not are read.")
        return f"it has a part that is no operation of numbers. {cure}"

    def visit_Constant(self, node: ast.Constant, depth: int) -> bool:
        if type(node.value) not in (int, float):
            raise self.error(
                f"{node.value!r} is no number. A text is compared with a contact mode: "
                "final(floor.mode) == 'stick'."
            )
        try:
            value = float(node.value)  # type: ignore[arg-type]
        except OverflowError:
            value = np.inf
        if not np.isfinite(value):
            raise self.error("it has a number that is too large.")
        self.code.append(("constant", value))
        return False

    def visit_Name(self, node: ast.Name, depth: int) -> bool:
        if node.id == "pi":
            self.code.append(("constant", np.pi))
        elif node.id.startswith("_"):
            self.code.append(("column", self.columns[int(node.id[1:])]))
        else:
            raise self.error(self.instead(node))
        return False

    def visit_UnaryOp(self, node: ast.UnaryOp, depth: int) -> bool:
        condition = self.visit(node.operand, depth)
        if isinstance(node.op, ast.Not):
            self.must_be_condition(condition, "not")
            self.code.append(("not", ("", 1)))
        elif isinstance(node.op, ast.USub):
            self.code.append(("apply", ("USub", 1)))
        elif not isinstance(node.op, ast.UAdd):
            raise self.error(self.instead(node.op))
        return isinstance(node.op, ast.Not)

    def visit_BinOp(self, node: ast.BinOp, depth: int) -> bool:
        if type(node.op) not in _OPERATIONS:
            raise self.error(self.instead(node.op))
        self.visit(node.left, depth)
        self.visit(node.right, depth)
        self.code.append(("apply", (type(node.op).__name__, 2)))
        return False

    def visit_BoolOp(self, node: ast.BoolOp, depth: int) -> bool:
        what = "all" if isinstance(node.op, ast.And) else "any"
        for part in node.values:
            self.must_be_condition(self.visit(part, depth), "and" if what == "all" else "or")
        self.code.append((what, ("", len(node.values))))
        return True

    def visit_Compare(self, node: ast.Compare, depth: int) -> bool:
        parts = [node.left, *node.comparators]
        for kind in node.ops:
            if type(kind) not in _COMPARISONS:
                raise self.error("it compares by a word. Write <, <=, >, >=, == or !=.")
        if any(isinstance(part, ast.Constant) and isinstance(part.value, str) for part in parts):
            self.compare_mode(node, parts)
        else:
            for part in parts:
                self.visit(part, depth)
        self.code.append(("compare", (tuple(type(kind).__name__ for kind in node.ops), len(parts))))
        return True

    def compare_mode(self, node: ast.Compare, parts: list[ast.expr]) -> None:
        """Write the instructions for a contact mode and the text that it is compared with."""
        texts = [part.value for part in parts if isinstance(part, ast.Constant)]
        names = [
            self.columns[int(part.id[1:])] for part in parts if isinstance(part, ast.Name) and part.id != "pi"
        ]
        equality = isinstance(node.ops[0], ast.Eq | ast.NotEq)
        if len(parts) != 2 or len(texts) != 1 or len(names) != 1 or not equality or not _MODE.match(names[0]):
            raise self.error("only a contact mode equals a text: final(floor.mode) == 'stick'.")
        if texts[0] not in CONTACT_MODES:
            raise self.error(f"{texts[0]!r} is no contact mode; {nearest(str(texts[0]), CONTACT_MODES)}")
        self.code += [("column", names[0]), ("constant", float(CONTACT_MODES.index(str(texts[0]))))]

    def visit_Call(self, node: ast.Call, depth: int) -> bool:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if isinstance(node.func, ast.Attribute) and isinstance(node.func.value, ast.Name):
            name = f"{node.func.value.id}.{node.func.attr}"
        if name not in FUNCTIONS and name not in _EXTREMES:
            if name in REDUCTIONS:
                raise self.error(f"write {name}() of one quantity, such as {name}(theta).")
            raise self.error(f"unknown function '{name}'; {nearest(name, [*FUNCTIONS, *REDUCTIONS])}")
        count = FUNCTIONS[name][0] if name in FUNCTIONS else max(2, len(node.args))
        if node.keywords or len(node.args) != count or any(isinstance(x, ast.Starred) for x in node.args):
            raise self.error(f"{name}() takes {count} number{'s' * (count > 1)}.")
        for argument in node.args:
            self.visit(argument, depth)
        self.code.append(("apply", (name, count)))
        return False

    def must_be_condition(self, condition: bool, word: str) -> None:
        if not condition:
            raise self.error(f"'{word}' stands beside a number. Write a comparison there.")


def _closing(text: str, place: int) -> int:
    """Return the place of the bracket that closes one opened just before ``place``; the end if there is none."""
    depth = 1
    while place < len(text):
        depth += (text[place] == "(") - (text[place] == ")")
        if not depth:
            return place
        place += 1
    return place
