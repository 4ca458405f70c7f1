"""Products of a model as C99 source."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...errors import ModelError
from ...model import Model
from ...scalar.trace import CODES, CONST, INPUT, NAMES, NEG, Traced
from .recording import (
    OPERATORS,
    Recorded,
    identifier,
    order_of_arguments,
    own_parameters,
    recorded,
    write_files,
)


@dataclass(frozen=True)
class CSource:
    """One C99 source file and its header."""

    name: str
    source: str
    header: str

    def write(self, folder: Any) -> list[Path]:
        """Write ``NAME.c`` and ``NAME.h``, and return their paths."""
        return write_files(folder, {f"{self.name}.c": self.source, f"{self.name}.h": self.header})

    def __repr__(self) -> str:
        """Return the name and the number of lines."""
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
    """Write products as C source, as :meth:`Program.to_c` describes."""
    prefix = identifier(model.name) if name is None else name
    if not isinstance(prefix, str) or prefix != identifier(prefix):
        raise ModelError(f"Expected name= to be an identifier of C, got '{prefix}'.")
    declared, defined, helpers = [], [], set()
    for product in recorded(model, products, active):
        vectors = [f"const double *{vector}" for vector, _ in product.inputs]
        result = identifier(product.name)
        head = f"void {prefix}_{result}(double t, {', '.join(vectors)}, const double *p, double *{result})"
        sizes = ", ".join(f"{vector}[{n}]" for vector, n in product.inputs)
        shape = "".join(f"[{n}]" for n in product.shape) or "[1]"
        declared.append(f"/* {sizes} -> {result}{shape} */\n{head};")
        lines, used = _c_body(product)
        helpers |= used
        defined.append("\n".join([head, "{", *lines, "}"]))
    order = "\n".join(f"   {line}" for line in order_of_arguments(model))
    title = f"Dynamics of '{_comment(model.name)}', written by freebody. Matrices by rows; SI units, radians."
    parameters = own_parameters(model)
    defaults = ", ".join("NAN" if p.default is None else _c_number(p.default) for p in parameters)
    count = len(parameters)
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
    """A double as C text, bit for bit; in decimal notation if that is short."""
    x = float(value)
    if not math.isfinite(x):
        return "NAN" if x != x else "INFINITY" if x > 0 else "-INFINITY"
    text = repr(x)
    return text if len(text) < 8 else x.hex()


def _c_body(product: Recorded) -> tuple[list[str], set[str]]:
    """Lines of a function, and the names of the helpers that it needs."""
    values: dict[int, str] = {}
    helpers: set[str] = set()
    name = identifier(product.name)
    lines = [f"    (void){name};" for name in ("t", *(vector for vector, _ in product.inputs), "p")]
    for j, table in enumerate(product.tables):
        n, width = table.breaks.size, table.rows.shape[1]
        lines.append(f"    const double *const s{j} = piece(t, breaks_{j}, {n}, rows_{j}, {width});")
    lines += [f"    (void)s{k};" for k in range(len(product.tables))]
    for i, code, a, b in product.steps():
        if code == CONST:
            values[i] = _c_number(product.tape.constants[a])
            continue
        if code == INPUT:
            vector, k = product.places[i]
            values[i] = vector if k is None else f"{vector}[{k}]"
            continue
        if code in OPERATORS:
            text = f"{values[a]} {OPERATORS[code]} {values[b]}"
        elif code == NEG:
            text = f"-{values[a]}"
        else:
            function = _C_FUNCTIONS.get(code, NAMES[code])
            if function in _C_HELPERS:
                helpers.add(function)
            text = f"{function}({', '.join(values[k] for k in (a, b) if k >= 0)})"
        values[i] = f"v{i}"
        lines.append(f"    const double v{i} = {text};")
    if not product.outputs:  # of a machine without degrees of freedom
        lines.append(f"    (void){name};")
    for k, x in enumerate(product.outputs):
        lines.append(f"    {name}[{k}] = {values[x.index] if type(x) is Traced else _c_number(x)};")
    return lines, helpers
