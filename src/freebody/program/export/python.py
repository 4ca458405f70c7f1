"""Products of a model as Python source for NumPy and JAX."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...model import Model
from ...scalar.trace import CODES, CONST, INPUT, NEG, Traced
from .recording import (
    OPERATORS,
    Recorded,
    Written,
    identifier,
    order_of_arguments,
    own_parameters,
    recorded,
    required,
    write_files,
)


class PythonSource(Written):
    """Functions f(q, u, ..., t=0.0, p=None) by name, and the source text that defines them.

    Arrays may have any leading axes, which broadcast. ``p`` holds the parameters in the order of ``PARAMETERS``; their
    default values are used without it.
    """

    def __init__(self, name: str, source: str) -> None:
        self.name = name
        self.source = source
        space: dict[str, Any] = {"__name__": f"freebody export of {name}"}
        exec(compile(source, f"<freebody export of {name}>", "exec"), space)
        super().__init__({function: space[function] for function in space["__all__"]})

    def write(self, folder: Any) -> list[Path]:
        """Write ``NAME.py`` and return its path."""
        return write_files(folder, {f"{self.name}.py": self.source})

    def __repr__(self) -> str:
        """Return the name and the functions."""
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
    """Write products as Python source, as :meth:`Program.to_numpy` and :meth:`Program.to_jax` describe."""
    if library == "jax":
        required("jax")
    recordings = recorded(model, products, active)
    names = [identifier(product.name) for product in recordings]
    order = "\n".join(order_of_arguments(model)).replace("\\", "/").replace('"""', "'''")
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
    for name, product in zip(names, recordings, strict=True):
        parts.append("\n".join([*_python_body(name, product), ""]))
    return PythonSource(identifier(model.name), "\n\n".join(parts))


def _python_tables(model: Model) -> str:
    """Definitions of the break points of the signals and of the constants of their pieces."""
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
    """Lines of a function."""
    vectors = [vector for vector, _ in product.inputs]
    lines = [f"def {name}({', '.join(vectors)}, t=0.0, p=None):", "    t, p = np.asarray(t), _given(p)"]
    lines += [f"    {vector} = _vector({vector!r}, {vector}, {n})" for vector, n in product.inputs]
    lines += [
        f'    s{k} = np.asarray(_ROWS_{k})[np.searchsorted(np.asarray(_BREAKS_{k}), t, side="right")]'
        for k in range(len(product.tables))
    ]
    values: dict[int, str] = {}
    for i, code, a, b in product.steps():
        if code == CONST:
            values[i] = repr(float(product.tape.constants[a]))
            continue
        if code == INPUT:
            vector, k = product.places[i]
            values[i] = "t" if k is None else f"{vector}[..., {k}]"
            continue
        if code in OPERATORS:
            text = f"{values[a]} {OPERATORS[code]} {values[b]}"
        elif code == NEG:
            text = f"-{values[a]}"
        else:
            text = f"np.{_PYTHON_FUNCTIONS[code]}({', '.join(values[k] for k in (a, b) if k >= 0)})"
        values[i] = f"v{i}"
        lines.append(f"    v{i} = {text}")
    # every output has the leading axes of all arguments, even if it depends on none of them
    size = [f"np.zeros({vector}.shape[:-1])" for vector in (*vectors, "p")]
    lines.append(f"    zero = {' + '.join(size)} + np.zeros(t.shape)")
    outputs = [values[x.index] if type(x) is Traced else f"np.asarray({float(x)!r})" for x in product.outputs]
    lines.append(f"    outputs = [{', '.join(outputs)}]")
    lines.append(f"    return _joined([x + zero for x in outputs], zero, {product.shape!r})")
    return lines
