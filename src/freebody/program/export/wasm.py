"""A machine and the loop that moves it as one WebAssembly module, and how to talk to it."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from ...errors import FormatError, path_of
from ...formats.files import replacing


@dataclass(frozen=True)
class WasmModule:
    """A machine as a WebAssembly module. Made by :meth:`Program.to_wasm`.

    The caller writes fields of one record in the module's memory, calls ``simulate(address)``, and reads others
    (the page on WebAssembly lists all). All addresses are constants of the module.

    Attributes
    ----------
    code : bytes
        The module. It exports ``memory`` and ``simulate(address)``.
    address : int
        Address of the record, the argument of ``simulate``.
    fields : dict
        Name of a field -> (address in the memory [bytes], "real" or "whole", shape). Numbers take 8 bytes, low byte
        first: doubles, and integers of 64 bits with a sign. The shape of a number is ().
    imports : tuple of str
        Functions of real numbers that the module imports from ``env``: ``sin``, ``cos``, ``pow`` and so on, as in the
        C library.
    parameters, state, outputs, events, answers : tuple of str
        Names of the numbers in the fields of these names; ``state`` are the components of ``start`` and ``states``.
    contacts : tuple of str
        Names of the contacts, in the order of the field ``modes``.
    conditions : tuple of str
        Names of the conditions of the machine, by the numbers in the field ``worst``.
    assumed : tuple of str
        Expressions that must be positive, by the numbers in the field ``fault``.
    """

    code: bytes
    address: int
    fields: Mapping[str, tuple[int, str, tuple[int, ...]]]
    imports: tuple[str, ...]
    parameters: tuple[str, ...]
    state: tuple[str, ...]
    outputs: tuple[str, ...]
    events: tuple[str, ...]
    answers: tuple[str, ...]
    contacts: tuple[str, ...]
    conditions: tuple[str, ...]
    assumed: tuple[str, ...]

    def __repr__(self) -> str:
        return (
            f"<WasmModule: {len(self.code)} bytes, parameters {', '.join(self.parameters) or 'none'}, state "
            f"{', '.join(self.state) or 'none'}>"
        )

    @property
    def interface(self) -> str:
        """Everything but the code, as JSON."""
        return json.dumps({name: x for name, x in asdict(self).items() if name != "code"})

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Write the module to a file that ends in ``.wasm``, and beside it its interface as ``.json``; return the file.

        Raises
        ------
        FormatError
            If the path cannot be written, or does not end in ``.wasm``.
        """
        target = path_of(path, "a WebAssembly module", FormatError)
        if target.suffix.lower() != ".wasm":
            raise FormatError(f"Expected a file name that ends in .wasm, got '{target.name}'.")
        with replacing(target) as new:
            new.write_bytes(self.code)
        with replacing(target.with_suffix(".json")) as new:
            new.write_text(self.interface, encoding="utf-8")
        return target
