"""Recorded products as all exports read them, with their arguments, parameters and signals."""

from __future__ import annotations

import keyword
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...describe.signal import SignalTable
from ...errors import ModelError
from ...model import Model
from ...scalar.trace import ADD, DIV, MUL, SUB, Tape
from ..products import PRODUCTS, check_conditions, product_named, products_of, recording

OPERATORS = {ADD: "+", SUB: "-", MUL: "*", DIV: "/"}


@dataclass(frozen=True)
class Recorded:
    """A product on its tape. ``places`` maps each input node to its argument and entry (None for a number).

    Signals are arguments of their own: s0, s1, ... Each function reads the piece of a signal that holds at its t.
    """

    name: str
    tape: Tape
    inputs: tuple[tuple[str, int], ...]
    places: Mapping[int, tuple[str, int | None]]
    outputs: tuple[Any, ...]
    shape: tuple[int, ...]
    tables: tuple[SignalTable, ...]

    def steps(self) -> Iterator[tuple[int, int, int, int]]:
        """(node, code, operands) of the nodes that the outputs need, operands first."""
        tape = self.tape
        for i in tape.used(self.outputs):
            yield i, tape.op[i], tape.a[i], tape.b[i]


def recorded(model: Model, products: Sequence[str], active: tuple[int, ...] | None) -> list[Recorded]:
    """Record the products named, each once; by default all without ``derivatives`` and products that need ``at=``."""
    if not products:
        undecided = model.constraints and active is None
        products = [
            name
            for name in products_of(model)
            if name != "derivatives" and not (undecided and PRODUCTS[name].moves)
        ]
    result = []
    for name in products:
        if not isinstance(name, str):
            raise ModelError(
                f"Expected names of products one after another, such as 'mass_matrix', 'bias', got {name!r}."
            )
    written: dict[str, str] = {}
    for name in dict.fromkeys(products):
        if (other := written.setdefault(identifier(name), name)) != name:
            raise ModelError(
                f"Expected products with names of their own, but '{other}' and '{name}' are both written as "
                f"{identifier(name)}. Write them one after the other."
            )
        product = product_named(model, name)
        if product.moves:
            check_conditions(model, active)
        r = recording(model, active)
        outputs = tuple(product.record(r))
        parameters = dict(zip((p.name for p in model.parameters), r.parameters, strict=True))
        arguments = {"q": r.state.q, "u": r.state.u, "udot": r.udot, "forces": r.forces}
        arguments["p"] = tuple(parameters[p.name] for p in own_parameters(model))
        for k, placed in enumerate(model.signals):
            arguments[f"s{k}"] = tuple(parameters[symbol.name] for symbol in placed.symbols)
        places: dict[int, tuple[str, int | None]] = {r.state.t.index: ("t", None)}
        for vector, entries in arguments.items():
            places.update((x.index, (vector, k)) for k, x in enumerate(entries))
        inputs = tuple((vector, len(arguments[vector])) for vector in product.inputs)
        tables = tuple(placed.table() for placed in model.signals)
        result.append(Recorded(name, r.tape, inputs, places, outputs, product.shape(model), tables))
    return result


def own_parameters(model: Model) -> tuple[Any, ...]:
    """Parameters of a model without the constants of its signals, which follow from t."""
    of_signals = {symbol.name for placed in model.signals for symbol in placed.symbols}
    return tuple(p for p in model.parameters if p.name not in of_signals)


def write_files(folder: Any, files: Mapping[str, str]) -> list[Path]:
    """Write texts to files of a folder, and return their paths."""
    if not isinstance(folder, str | os.PathLike):
        raise ModelError(f"Expected the path of a folder to write to, got {folder!r}.")
    place = Path(folder)
    if place.exists() and not place.is_dir():
        raise ModelError(f"Expected a folder to write to, but '{place}' is a file.")
    place.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (place / name).write_text(text, encoding="utf-8")
    return [place / name for name in files]


def identifier(text: str) -> str:
    """Return a text as a name that C and Python accept.

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


def order_of_arguments(model: Model) -> list[str]:
    """Lines that list the entries of q, u and p."""
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
        """Return the function of a product."""
        if isinstance(name, str) and identifier(name) in self._functions:
            return self._functions[identifier(name)]
        if name not in self._functions:
            raise KeyError(
                f"{name!r} is not among the functions written: {', '.join(self)}. Name it in the call that "
                "writes them; if it cannot be written, that call says why"
            )
        return self._functions[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return iter(self._functions)

    def __len__(self) -> int:
        """Return the number of functions."""
        return len(self._functions)


def required(library: str) -> Any:
    """Import a library that an export needs."""
    from importlib import import_module

    try:
        return import_module(library)
    except ImportError:
        raise ModelError(
            f"Expected {library} to be installed for this export. Install it: pip install freebody[{library}]"
        ) from None
