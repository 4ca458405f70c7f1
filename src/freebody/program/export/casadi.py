"""Products of a model as functions of CasADi."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...model import Model
from ...scalar.trace import ADD, CODES, CONST, DIV, INPUT, MUL, NAMES, NEG, SUB, Traced
from .recording import Written, identifier, own_parameters, recorded, required


class CasadiFunctions(Written):
    """``casadi.Function`` objects by name: from columns q, u, ..., t, p to a matrix or a column,
    named as the product.
    """

    def __init__(self, functions: Mapping[str, Any], parameters: np.ndarray) -> None:
        super().__init__(functions)
        self.parameters = parameters
        """Default values of p, NaN where there is none."""

    def __repr__(self) -> str:
        """Return the names of the functions."""
        return f"<CasadiFunctions: {', '.join(self)}>"


def casadi_functions(
    model: Model, products: Sequence[str], active: tuple[int, ...] | None
) -> CasadiFunctions:
    """Write products for CasADi, as :meth:`Program.to_casadi` describes."""
    casadi = required("casadi")
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
        values: dict[int, Any] = {}
        for i, code, a, b in product.steps():
            if code == CONST:
                values[i] = float(product.tape.constants[a])
            elif code == INPUT:
                vector, k = product.places[i]
                values[i] = t if k is None else sources[vector][k]
            else:
                values[i] = table[code](*(values[k] for k in (a, b) if k >= 0))
        outputs = [values[x.index] if type(x) is Traced else float(x) for x in product.outputs]
        column = casadi.vertcat(*map(casadi.SX, outputs)) if outputs else casadi.SX(0, 1)
        rows = product.shape[0] if product.shape else 1
        wide = math.prod(product.shape[1:])
        # CasADi stores by columns
        result = casadi.reshape(column, wide, rows).T if len(product.shape) > 1 else column
        arguments = [vectors[vector] for vector, _ in product.inputs]
        names = [vector for vector, _ in product.inputs]
        name = identifier(product.name)
        functions[name] = casadi.Function(
            name, [*arguments, t, vectors["p"]], [result], [*names, "t", "p"], [name]
        )
    defaults = [math.nan if p.default is None else float(p.default) for p in own_parameters(model)]
    return CasadiFunctions(functions, np.array(defaults))
