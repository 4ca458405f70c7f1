"""Products of a model as source text and as functions of other array libraries: the same trace, written elsewhere.

One file, though long: three writers of one recording, which must agree on arguments, parameters and signals.
"""

from __future__ import annotations

import keyword
import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...describe.signal import SignalTable
from ...errors import ModelError
from ...model import Model
from ...scalar.trace import ADD, CODES, CONST, DIV, INPUT, MUL, NAMES, NEG, SUB, Tape, Traced
from ..products import PRODUCTS, check_conditions, product_named, products_of, recording

_OPERATORS = {ADD: "+", SUB: "-", MUL: "*", DIV: "/"}


@dataclass(frozen=True)
class Recorded:
    """A product on its tape: ``places`` says of each input node which argument and entry it is (None: a number).

    Signals are arguments of their own, s0, s1, ..., of which each function reads the piece that holds at its t.
    """

    name: str
    tape: Tape
    inputs: tuple[tuple[str, int], ...]
    places: Mapping[int, tuple[str, int | None]]
    outputs: tuple[Any, ...]
    shape: tuple[int, ...]
    tables: tuple[SignalTable, ...]

    def steps(self) -> Iterator[tuple[int, int, int, int]]:
        """(node, code, operands) of what the outputs need, operands first."""
        tape = self.tape
        for i in tape.used(self.outputs):
            yield i, tape.op[i], tape.a[i], tape.b[i]


def recorded(model: Model, products: Sequence[str], active: tuple[int, ...] | None) -> list[Recorded]:
    """The products named, each once, or all that the machine has but ``derivatives`` and those that need ``at=``."""
    if not products:
        held = model.constraints and active is None
        products = [
            name
            for name in products_of(model)
            if name != "derivatives" and not (held and PRODUCTS[name].moves)
        ]
    result = []
    for name in products:
        if not isinstance(name, str):
            raise ModelError(
                f"Expected names of products one after another, such as 'mass_matrix', 'bias', got {name!r}."
            )
    for name in dict.fromkeys(products):
        product = product_named(model, name)
        if product.moves:
            check_conditions(model, active)
        r = recording(model, active)
        outputs = tuple(product.record(r))
        numbers = dict(zip((p.name for p in model.parameters), r.parameters, strict=True))
        given = {"q": r.state.q, "u": r.state.u, "udot": r.udot, "forces": r.forces}
        given["p"] = tuple(numbers[p.name] for p in own_parameters(model))
        for k, placed in enumerate(model.signals):
            given[f"s{k}"] = tuple(numbers[symbol.name] for symbol in placed.symbols)
        places: dict[int, tuple[str, int | None]] = {r.state.t.index: ("t", None)}
        for vector, entries in given.items():
            places.update((x.index, (vector, k)) for k, x in enumerate(entries))
        inputs = tuple((vector, len(given[vector])) for vector in product.inputs)
        tables = tuple(placed.table() for placed in model.signals)
        result.append(Recorded(name, r.tape, inputs, places, outputs, product.shape(model), tables))
    return result


def own_parameters(model: Model) -> tuple[Any, ...]:
    """The parameters of a model without the constants of its signals, which follow from t."""
    of_signals = {symbol.name for placed in model.signals for symbol in placed.symbols}
    return tuple(p for p in model.parameters if p.name not in of_signals)


def _write(folder: Any, files: Mapping[str, str]) -> list[Path]:
    if not isinstance(folder, str | os.PathLike):
        raise ModelError(f"Expected the path of a folder to write to, got {folder!r}.")
    where = Path(folder)
    if where.exists() and not where.is_dir():
        raise ModelError(f"Expected a folder to write to, and '{where}' is a file.")
    where.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (where / name).write_text(text, encoding="utf-8")
    return [where / name for name in files]


def identifier(text: str) -> str:
    """A name that C and Python accept.

    >>> identifier("four-bar 2"), identifier("2nd")
    ('four_bar_2', '_2nd')
    """
    plain = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_") or "model"
    return f"_{plain}" if plain[0].isdigit() or keyword.iskeyword(plain) or plain in _C_WORDS else plain


_C_WORDS = frozenset(
    re.findall(
        r"\w+",
        "auto break case char const continue default do double else enum extern float for goto if inline int long "
        "register restrict return short signed sizeof static struct switch typedef union unsigned void volatile "
        "while main",
    )
)


def _order(model: Model) -> list[str]:
    """Lines that say what stands where."""
    lists = {
        "q": model.coordinate_names,
        "u": model.speed_names,
        "p": tuple(parameter.name for parameter in own_parameters(model)),
    }
    return [f"{name} = ({', '.join(entries)})" for name, entries in lists.items()]


class Written(Mapping[str, Any]):
    """Functions by the names of their products."""

    def __init__(self, functions: Mapping[str, Any]) -> None:
        self._functions = dict(functions)

    def __getitem__(self, name: str) -> Any:
        if name not in self._functions:
            raise KeyError(
                f"{name!r} is not among the functions written: {', '.join(self)}. Name it in the call that "
                "writes them; if it can not be written, that says why"
            )
        return self._functions[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._functions)

    def __len__(self) -> int:
        return len(self._functions)


# --- C ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class CSource:
    """One C99 source file and its header."""

    name: str
    source: str
    header: str

    def write(self, folder: Any) -> list[Path]:
        """Write ``NAME.c`` and ``NAME.h``; their paths."""
        return _write(folder, {f"{self.name}.c": self.source, f"{self.name}.h": self.header})

    def __repr__(self) -> str:
        return f"<CSource {self.name}: {len(self.source.splitlines())} lines>"


_C_FUNCTIONS = {CODES["abs"]: "fabs"}
_C_HELPERS = {
    "sign": "static double sign(double x) { return x > 0 ? 1.0 : x < 0 ? -1.0 : x; }",
    "min": "static double min(double x, double y) { return x < y || x != x ? x : y; }",
    "max": "static double max(double x, double y) { return x > y || x != x ? x : y; }",
}
_C_PIECE = """/* constants of a signal in the piece that holds at t: NAN where it is not given */
static const double *piece(double t, const double *breaks, int n, const double *rows, int width)
{
    int low = 0, high = n;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (breaks[middle] <= t) low = middle + 1;
        else high = middle;
    }
    return rows + low * width;
}"""


def c_source(
    model: Model, products: Sequence[str], active: tuple[int, ...] | None, name: str | None
) -> CSource:
    """See :meth:`Program.to_c`."""
    prefix = identifier(model.name) if name is None else name
    if not isinstance(prefix, str) or prefix != identifier(prefix):
        raise ModelError(f"Expected name= to be an identifier of C, got '{prefix}'.")
    given = recorded(model, products, active)
    declared, defined, helpers = [], [], set()
    for product in given:
        vectors = [f"const double *{vector}" for vector, _ in product.inputs]
        head = f"void {prefix}_{identifier(product.name)}(double t, {', '.join(vectors)}, const double *p, double *out)"
        sizes = ", ".join(f"{vector}[{n}]" for vector, n in product.inputs)
        shape = "".join(f"[{n}]" for n in product.shape) or "[1]"
        declared.append(f"/* {sizes} -> out{shape} */\n{head};")
        lines, used = _c_body(product)
        helpers |= used
        defined.append("\n".join([head, "{", *lines, "}"]))
    order = "\n".join(f"   {line}" for line in _order(model))
    title = f"Dynamics of '{_comment(model.name)}', written by freebody. Matrices by rows; SI units, radians."
    own = own_parameters(model)
    defaults = ", ".join("NAN" if p.default is None else _c_number(p.default) for p in own)
    count = len(own)
    tables = []
    for k, placed in enumerate(model.signals):
        table = placed.table()
        breaks, rows = (", ".join(map(_c_number, x.ravel())) for x in table)
        tables += [
            f"static const double breaks_{k}[{table.breaks.size}] = {{{breaks}}};",
            f"static const double rows_{k}[{table.rows.size}] = {{{rows}}};",
        ]
    guard = f"{prefix.upper()}_H"
    header = f"""/* {title}

{_comment(order)}

   {prefix}_parameters holds the default values of p, NAN where there is none. */
#ifndef {guard}
#define {guard}

#define {prefix.upper()}_N_Q {model.n_q}
#define {prefix.upper()}_N_U {model.n_u}
#define {prefix.upper()}_N_P {count}

#ifdef __cplusplus
extern "C" {{
#endif

extern const double {prefix}_parameters[{max(count, 1)}];

{chr(10).join(declared)}

#ifdef __cplusplus
}}
#endif
#endif
"""
    parts = [
        f'/* {title} */\n#include <math.h>\n#include "{prefix}.h"',
        f"const double {prefix}_parameters[{max(count, 1)}] = {{{defaults or '0.0'}}};",
        "\n".join(_C_HELPERS[helper] for helper in sorted(helpers)),
        "\n".join([*tables, _C_PIECE]) if tables else "",
        *defined,
    ]
    return CSource(prefix, "\n\n".join(part for part in parts if part) + "\n", header)


def _comment(text: str) -> str:
    return text.replace("*/", "* /").replace("\\", "/")


def _c_number(value: Any) -> str:
    """A double, bit for bit, readable where it is short."""
    x = float(value)
    if not math.isfinite(x):
        return "NAN" if x != x else "INFINITY" if x > 0 else "-INFINITY"
    text = repr(x)
    return text if len(text) < 8 else x.hex()


def _c_body(product: Recorded) -> tuple[list[str], set[str]]:
    known: dict[int, str] = {}
    helpers: set[str] = set()
    lines = [f"    (void){name};" for name in ("t", *(vector for vector, _ in product.inputs), "p")]
    for j, table in enumerate(product.tables):
        n, width = table.breaks.size, table.rows.shape[1]
        lines.append(f"    const double *const s{j} = piece(t, breaks_{j}, {n}, rows_{j}, {width});")
    lines += [f"    (void)s{k};" for k in range(len(product.tables))]
    for i, code, a, b in product.steps():
        if code == CONST:
            known[i] = _c_number(product.tape.constants[a])
            continue
        if code == INPUT:
            vector, k = product.places[i]
            known[i] = vector if k is None else f"{vector}[{k}]"
            continue
        if code in _OPERATORS:
            text = f"{known[a]} {_OPERATORS[code]} {known[b]}"
        elif code == NEG:
            text = f"-{known[a]}"
        else:
            function = _C_FUNCTIONS.get(code, NAMES[code])
            if function in _C_HELPERS:
                helpers.add(function)
            text = f"{function}({', '.join(known[k] for k in (a, b) if k >= 0)})"
        known[i] = f"v{i}"
        lines.append(f"    const double v{i} = {text};")
    if not product.outputs:  # of a machine without degrees of freedom
        lines.append("    (void)out;")
    for k, x in enumerate(product.outputs):
        lines.append(f"    out[{k}] = {known[x.index] if type(x) is Traced else _c_number(x)};")
    return lines, helpers


# --- NumPy and JAX ---------------------------------------------------------------------------


class PythonSource(Written):
    """Functions f(q, u, ..., t=0.0, p=None) by name, and the source text that defines them.

    The arrays may have any leading axes, which broadcast; ``p`` holds the parameters in the order of ``PARAMETERS``,
    by default their default values.
    """

    def __init__(self, name: str, source: str) -> None:
        self.name = name
        self.source = source
        space: dict[str, Any] = {"__name__": f"freebody export of {name}"}
        exec(compile(source, f"<freebody export of {name}>", "exec"), space)
        super().__init__({function: space[function] for function in space["__all__"]})

    def write(self, folder: Any) -> list[Path]:
        """Write ``NAME.py``; its path."""
        return _write(folder, {f"{self.name}.py": self.source})

    def __repr__(self) -> str:
        return f"<PythonSource {self.name}: {', '.join(self)}>"


_PYTHON_FUNCTIONS = {
    **{CODES[name]: name for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "sqrt", "exp", "log")},
    CODES["asin"]: "arcsin", CODES["acos"]: "arccos", CODES["atan"]: "arctan", CODES["atan2"]: "arctan2",
    CODES["abs"]: "abs", CODES["sign"]: "sign", CODES["pow"]: "power", CODES["min"]: "minimum",
    CODES["max"]: "maximum",
}  # fmt: skip

_PYTHON_HEAD = '''"""{title}

Arrays may have leading axes, which broadcast. SI units, radians.

{order}
"""

{imports}

PARAMETERS = {parameters!r}
DEFAULTS = {defaults!r}
{tables}
__all__ = {names!r}


def _vector(name, x, n):
    x = np.asarray(x)
    if x.shape[-1:] != (n,):
        raise ValueError(f"Expected {{name}} of shape ({{n}},), leading axes before it, got shape {{x.shape}}.")
    return x


def _given(p):
    if p is not None:
        return _vector("p", p, len(PARAMETERS))
    missing = [name for name, value in zip(PARAMETERS, DEFAULTS) if value is None]
    if missing:
        raise ValueError("Expected p, since these parameters have no default value: " + ", ".join(missing))
    return np.asarray(DEFAULTS)


def _joined(outputs, zero, shape):
    stacked = np.stack(np.broadcast_arrays(*outputs), axis=-1) if outputs else np.zeros(zero.shape + shape)
    return stacked.reshape(zero.shape + shape)
'''


def python_source(
    model: Model, products: Sequence[str], active: tuple[int, ...] | None, library: str
) -> PythonSource:
    """See :meth:`Program.to_numpy` and :meth:`Program.to_jax`."""
    if library == "jax":
        _need("jax")
    given = recorded(model, products, active)
    names = [identifier(product.name) for product in given]
    order = "\n".join(_order(model)).replace("\\", "/").replace('"""', "'''")
    head = _PYTHON_HEAD.format(
        title=f"Dynamics of '{model.name}', written by freebody.".replace('"""', "'''").replace("\\", "/"),
        order=order,
        imports="import numpy as np" if library == "numpy" else "import jax.numpy as np",
        parameters=tuple(parameter.name for parameter in own_parameters(model)),
        defaults=tuple(None if p.default is None else float(p.default) for p in own_parameters(model)),
        tables=_python_tables(model),
        names=names,
    )
    parts = [head]
    for name, product in zip(names, given, strict=True):
        parts.append("\n".join([*_python_body(name, product), ""]))
    return PythonSource(identifier(model.name), "\n\n".join(parts))


def _python_tables(model: Model) -> str:
    """Break points of the signals, and the constants of their pieces."""
    lines = [""] if model.signals else []
    for k, placed in enumerate(model.signals):
        table = placed.table()
        breaks, *rows = (
            f"[{', '.join('np.nan' if x != x else repr(float(x)) for x in row)}]"
            for row in (table.breaks, *table.rows)
        )
        lines += [f"_BREAKS_{k} = {breaks}", f"_ROWS_{k} = [{', '.join(rows)}]"]
    return "\n".join([*lines, ""]) if lines else ""


def _python_body(name: str, product: Recorded) -> list[str]:
    vectors = [vector for vector, _ in product.inputs]
    lines = [f"def {name}({', '.join(vectors)}, t=0.0, p=None):", "    t, p = np.asarray(t), _given(p)"]
    lines += [f"    {vector} = _vector({vector!r}, {vector}, {n})" for vector, n in product.inputs]
    lines += [
        f'    s{k} = np.asarray(_ROWS_{k})[np.searchsorted(np.asarray(_BREAKS_{k}), t, side="right")]'
        for k in range(len(product.tables))
    ]
    known: dict[int, str] = {}
    for i, code, a, b in product.steps():
        if code == CONST:
            known[i] = repr(float(product.tape.constants[a]))
            continue
        if code == INPUT:
            vector, k = product.places[i]
            known[i] = "t" if k is None else f"{vector}[..., {k}]"
            continue
        if code in _OPERATORS:
            text = f"{known[a]} {_OPERATORS[code]} {known[b]}"
        elif code == NEG:
            text = f"-{known[a]}"
        else:
            text = f"np.{_PYTHON_FUNCTIONS[code]}({', '.join(known[k] for k in (a, b) if k >= 0)})"
        known[i] = f"v{i}"
        lines.append(f"    v{i} = {text}")
    # every output has the leading axes of all arguments, also one that depends on none
    size = [f"np.zeros({vector}.shape[:-1])" for vector in (*vectors, "p")]
    lines.append(f"    zero = {' + '.join(size)} + np.zeros(t.shape)")
    outputs = [known[x.index] if type(x) is Traced else f"np.asarray({float(x)!r})" for x in product.outputs]
    lines.append(f"    outputs = [{', '.join(outputs)}]")
    lines.append(f"    return _joined([x + zero for x in outputs], zero, {product.shape!r})")
    return lines


# --- CasADi ----------------------------------------------------------------------------------


class CasadiFunctions(Written):
    """``casadi.Function`` by name: columns q, u, ..., t, p in; a matrix, or a column, out."""

    def __init__(self, functions: Mapping[str, Any], parameters: np.ndarray) -> None:
        super().__init__(functions)
        self.parameters = parameters
        """Default values of p, NaN where there is none."""

    def __repr__(self) -> str:
        return f"<CasadiFunctions: {', '.join(self)}>"


def casadi_functions(
    model: Model, products: Sequence[str], active: tuple[int, ...] | None
) -> CasadiFunctions:
    """See :meth:`Program.to_casadi`."""
    casadi = _need("casadi")
    table: dict[int, Any] = {CODES[name]: getattr(casadi, name, None) for name in NAMES[NEG + 1 :]}
    table.update({
        CODES["abs"]: casadi.fabs, CODES["min"]: casadi.fmin, CODES["max"]: casadi.fmax,
        CODES["pow"]: lambda x, y: x**y, NEG: lambda x: -x, ADD: lambda x, y: x + y,
        SUB: lambda x, y: x - y, MUL: lambda x, y: x * y, DIV: lambda x, y: x / y,
    })  # fmt: skip
    functions = {}
    for product in recorded(model, products, active):
        t = casadi.SX.sym("t")
        vectors = {vector: casadi.SX.sym(vector, n) for vector, n in product.inputs}
        vectors["p"] = casadi.SX.sym("p", len(own_parameters(model)))
        sources: dict[str, Any] = dict(vectors)
        for j, pieces in enumerate(product.tables):
            piece, *later = pieces.rows.tolist()
            for edge, row in zip(pieces.breaks.tolist(), later, strict=True):
                piece = [casadi.if_else(t >= edge, x, y) for x, y in zip(row, piece, strict=True)]
            sources[f"s{j}"] = piece
        known: dict[int, Any] = {}
        for i, code, a, b in product.steps():
            if code == CONST:
                known[i] = float(product.tape.constants[a])
            elif code == INPUT:
                vector, k = product.places[i]
                known[i] = t if k is None else sources[vector][k]
            else:
                known[i] = table[code](*(known[k] for k in (a, b) if k >= 0))
        outputs = [known[x.index] if type(x) is Traced else float(x) for x in product.outputs]
        column = casadi.vertcat(*map(casadi.SX, outputs)) if outputs else casadi.SX(0, 1)
        rows = product.shape[0] if product.shape else 1
        wide = math.prod(product.shape[1:])
        # CasADi counts by columns
        result = casadi.reshape(column, wide, rows).T if len(product.shape) > 1 else column
        arguments = [vectors[vector] for vector, _ in product.inputs]
        names = [vector for vector, _ in product.inputs]
        name = identifier(product.name)
        functions[name] = casadi.Function(
            name, [*arguments, t, vectors["p"]], [result], [*names, "t", "p"], ["out"]
        )
    defaults = [math.nan if p.default is None else float(p.default) for p in own_parameters(model)]
    return CasadiFunctions(functions, np.array(defaults))


def _need(library: str) -> Any:
    from importlib import import_module

    try:
        return import_module(library)
    except ImportError:
        raise ModelError(
            f"Expected {library} to be installed for this export. Install it: pip install freebody[{library}]"
        ) from None
