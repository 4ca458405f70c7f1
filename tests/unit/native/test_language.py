"""Every construct of the compiled language: what it gives in CPython, and compiled.

The rows stand in the order of docs/compiled-language.md, which names the same constructs.
"""

from __future__ import annotations

import ctypes
import re
from pathlib import Path

import numpy as np
import pytest

from freebody.native import codegen
from freebody.native.translation import translated
from random_programs import OF_NUMPY, in_python, module

PAGE = Path(__file__).parents[3] / "docs" / "compiled-language.md"

CONSTRUCTS = [
    # construct, program (after `def f(a: int, x: float, p: Reals, k: Integers) -> float:`), a, x, result
    ("an integer, a real number, a truth value", "n, r, t = 7, 0.5, True; return n + r + (1 if t else 0)", 0, 0.0, 8.5),
    ("a name", "b = a; b = b + 1; return b", 4, 0.0, 5.0),
    ("a constant of the module", "return SCALE * x + limits.LARGEST", 0, 3.0, 11.0),
    ("a table", "return TABLE[1, a] + WHOLES[a]", 2, 0.0, 28.0),
    ("a tuple or a dictionary of constants", "return WEIGHTS[1] * x + NAMED[3][0]", 0, 2.0, 6.5),
    ("a component", "p[a] = x; k[1] = 5; return p[a] + k[a - 1] + p[0]", 2, 4.5, 9.5),
    ("the rest of an array", "q = p[1:]; q[0] = x; return p[1] + q[1]", 0, 0.5, 2.5),
    ("a field of a record", "pair = Pair(p); pair.first = x; pair.second += 1; return pair.first + p[1]", 0, 0.5, 2.5),
    ("+ - *", "return (a + 2) * x - a", 3, 1.5, 4.5),
    ("/", "return a / 2 + x / 4", 3, 1.0, 1.75),
    ("//", "return a // 2 * 100 + (-a) // 2", 7, 0.0, 296.0),
    ("%", "return a % 5 * 100 + (-a) % 5", 7, 0.0, 203.0),
    ("**", "return x ** 2 + 3.0 ** a", 2, 4.0, 25.0),
    ("<< >>", "return (a << 3) + (-a >> 1)", 5, 0.0, 37.0),
    ("& | ^", "return (a & 12) * 10000 + (a | 3) * 100 + (a ^ 5)", 9, 0.0, 81112.0),
    ("-", "return -x - -a", 2, 0.5, 1.5),
    ("abs", "return abs(a) + abs(x)", -3, -0.5, 3.5),
    ("comparisons", "return 1 if -1 < x <= a != 5 else 0", 2, 0.5, 1.0),
    ("and, or, not", "return 1 if (x > 1 or a > 1) and not a == 3 else 0", 2, 0.5, 1.0),
    ("a if c else b", "return x if a > 0 else 1 / x", -1, 4.0, 0.25),
    ("assignment", "b = c = a; b, c = c + 1, b; p[0], p[1] = p[1], p[0]; return b * 10 + c", 3, 0.0, 43.0),
    ("a name with a type", "y: Real = a; y = y + x; return y", 3, 0.5, 3.5),
    ("+= -= *= /= and so on", "b = a; b *= 3; b //= 2; b <<= 1; y = x; y /= 2; p[0] += 1; return b + y", 5, 3.0, 15.5),
    ("if, elif, else", "if a > 2: b = 1\nelif a > 1: b = 2\nelse: b = 3\nreturn b", 2, 0.0, 2.0),
    ("while", "n = 0\nwhile n * n < a: n += 1\nreturn n", 17, 0.0, 5.0),
    ("for over range", "n = 0\nfor i in range(a, 0, -2): n = n * 10 + i\nreturn n", 7, 0.0, 7531.0),
    ("for over unrolled", "y = 0.0\nfor i in unrolled(1, 3): y = 10 * y + WEIGHTS[i]\nreturn y", 0, 0.0, 37.0),
    ("break, continue", "n = 0\nfor i in range(9):\n    if i % 2 == 0: continue\n    if i > a: break\n    n += i\nreturn n", 5, 0.0, 9.0),
    ("pass", "if a > 0: pass\nreturn x", 1, 2.0, 2.0),
    ("return", "if a > 0: return x\nreturn -x", 1, 2.0, 2.0),
    ("a call", "note(k, a); return twice(x) + k[0]", 3, 2.0, 7.0),
    ("an instruction", "return greater(x, 1) + root(9.0) + whole(x)", 0, 2.5, 7.5),
    ("math.sqrt, math.fabs, math.log2, math.copysign, math.isfinite",
     "return math.sqrt(x) + math.fabs(-x) + math.log2(x) + math.copysign(x, -1.0) + (1 if math.isfinite(x) else 0)",
     0, 4.0, 5.0),
    ("where(c, a, b)", "return where(a > 1, x, 0.5)", 2, 7.0, 7.0),
    ("any(c), all(c)", "return 1 if any(a > 1) and all(x > 1) else 0", 2, 7.0, 1.0),
    ("rare(c)", "if rare(a > 1): return x\nreturn 0.0", 2, 7.0, 7.0),
    ("for lane in each(c)", "y = x\nfor lane in each(a > 1): y = y + 1 + lane\nreturn y", 2, 7.0, 8.0),
]  # fmt: skip

CONSTANTS = ("math", "limits", "np", "TABLE", "WHOLES", "SCALE", "WEIGHTS", "NAMED", "Pair")
HEAD = """
import math
from types import SimpleNamespace

import numpy as np

SCALE = 2
limits = math
TABLE = np.arange(6.0).reshape(2, 3) ** 2
WHOLES = np.array([1, 2, 3])
WEIGHTS = (1.0, 3.0, 7.0)
NAMED = {3: (0.5, 2)}

def note(k: Integers, a: int) -> None:
    k[0] = a


def twice(x: float) -> float:
    return 2 * x

"""


LIMITS = """
from __future__ import annotations

from freebody.native.functions import unrolled
from freebody.native.records import Real, Record, record

LARGEST = 5


@record
class Pair(Record):
    first: Real
    second: Real
"""


def program(number):
    _, text, *_ = CONSTRUCTS[number]
    lines = "\n".join(part for part in text.split("; ")).split("\n")
    return f"def f{number}(a: int, x: float, p: Reals, k: Integers) -> float:\n" + "".join(
        f"    {x}\n" for x in lines
    )


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    folder = tmp_path_factory.mktemp("language")
    (folder / "limits.py").write_text(LIMITS)
    imported = "limits = importlib.import_module('limits')\nPair, unrolled = limits.Pair, limits.unrolled"
    head = HEAD.replace("limits = math", imported).replace("import math", "import importlib\nimport math")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        made = module([head, *map(program, range(len(CONSTRUCTS)))], folder, "constructs")
    names = [f"f{k}" for k in range(len(CONSTRUCTS))]
    code, _ = codegen.optimised_code(translated({n: getattr(made, n) for n in names}))
    library = codegen.Library(code)
    return library, library.addresses(names), vars(made)


@pytest.mark.parametrize("number", range(len(CONSTRUCTS)), ids=[row[0] for row in CONSTRUCTS])
def test_construct(compiled, number):
    *_, a, x, result = CONSTRUCTS[number]
    library, addresses, space = compiled
    kind = ctypes.CFUNCTYPE(
        ctypes.c_double, ctypes.c_int64, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p
    )
    names = {name: space[name] for name in CONSTANTS}
    names["unrolled"] = range
    python = in_python(HEAD[HEAD.index("def note") :] + program(number), {**OF_NUMPY, **names}, False)[
        f"f{number}"
    ]
    ends = []
    for call in (
        lambda *v: python(*v),
        lambda a, x, p, k: kind(addresses[f"f{number}"])(a, x, p.ctypes.data, k.ctypes.data),
    ):
        p, k = np.arange(3.0), np.zeros(3, dtype=np.int64)
        assert call(a, x, p, k) == result
        ends.append((p.tolist(), k.tolist()))
    assert ends[0] == ends[1]
    assert library is not None


def test_the_page_names_every_construct():
    rows = re.findall(r"^\| `?(.+?)`? \| `.*\n", PAGE.read_text(), re.MULTILINE)
    assert [row.replace("`", "").replace("\\|", "|") for row in rows] == [row[0] for row in CONSTRUCTS]
