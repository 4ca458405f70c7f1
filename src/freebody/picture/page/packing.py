"""The data of a page as one text: a tree and its arrays, compressed.

    base64(gzip(n, tree, arrays)),   n: length of the tree in bytes, 32 bits;  tree: JSON, in which an array is {"#": …}

Values over time (arrays of 64-bit floats) are rounded to a step that nobody sees,

    k_i = round(x_i / s),   s ≤ max(2⁻¹⁵ (max x - min x), 2⁻²⁴ max |x|), the greatest 1, 2 or 5 times a power of ten,

and stored as differences k_i - k_(i-1), or as differences of these where they are smaller, byte by byte: a smooth curve
takes about one byte a value. Other 32-bit numbers are stored as differences of their bits, bytes as they are.
"""

from __future__ import annotations

import base64
import gzip
import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

FINE, SINGLE = 15, 24
"""Bits of the range of a value that are kept: less than a pixel where a motion fills the picture; and those of a 32-bit
float, with which the page computes."""


def packed(data: Mapping[str, Any]) -> str:
    """Return data as text of letters, digits, "+", "/" and "=".

    Parameters
    ----------
    data : mapping
        What JSON can hold, and arrays: of 64-bit floats, shape (n,) or (n, width), which are values over time; of
        32-bit floats, of unsigned 32-bit integers or of bytes, which are exact.

    Returns
    -------
    str

    Examples
    --------
    >>> len(packed({"t": np.linspace(0, 1, 1000)})) < 200
    True
    """
    places: dict[bytes, int] = {}  # in their order

    def stored(content: bytes) -> int:
        """Place of bytes among the arrays; what is equal is stored once."""
        if content not in places:
            places[content] = sum(map(len, places))
        return places[content]

    def reference(value: Any) -> dict[str, Any]:
        if not isinstance(value, np.ndarray):
            raise TypeError(f"no data of a page: {value!r}")
        if value.dtype == np.uint8:
            return {"#": ["byte", len(value), stored(value.tobytes())]}
        if value.dtype == np.float64 and np.isfinite(value).all():
            columns = map(_rounded, value.reshape(len(value), -1).T)
            found = [[step, order, stored(content)] for step, order, content in columns]
            return {"#": ["rounded", len(value), found]}
        kind = "whole" if value.dtype == np.uint32 else "real"
        bits = value.astype("<u4" if kind == "whole" else "<f4").ravel().view("<u4")
        return {"#": [kind, bits.size, stored(_planes(np.diff(bits, prepend=np.uint32(0))))]}

    tree = json.dumps(data, default=reference, separators=(",", ":"), allow_nan=False).encode()
    whole = len(tree).to_bytes(4, "little") + tree + b"".join(places)
    return base64.b64encode(gzip.compress(whole, 9, mtime=0)).decode("ascii")


def _rounded(column: NDArray[np.float64]) -> tuple[float, int, bytes]:
    """Step of a column, order of the differences that are stored, and their bytes."""
    step = _round(max(float(np.ptp(column)) / 2**FINE, float(np.abs(column).max()) / 2**SINGLE))
    whole = np.rint(column / step).astype(np.int64) if step > 0 else np.zeros(len(column), dtype=np.int64)
    first = np.diff(whole, prepend=0)
    second = np.diff(first, prepend=0)
    order, least = min(((1, first), (2, second)), key=lambda one: float(np.log2(1 + np.abs(one[1])).sum()))
    # small numbers of either sign are small without a sign
    return step, order, _planes((least << 1) ^ (least >> 63))


def _round(x: float) -> float:
    """Greatest of 1, 2, 5 times a power of ten that is not above x: decimal numbers, as starts are, stay themselves."""
    if not x > 0:
        return 0.0
    power = 10.0 ** math.floor(math.log10(x))
    return max(k * power for k in (1, 2, 5) if k == 1 or k * power <= x)


def _planes(whole: NDArray[Any]) -> bytes:
    """Bytes of 32-bit integers, the lowest of all first: the others are mostly zero."""
    return whole.astype("<u4").view(np.uint8).reshape(-1, 4).T.tobytes()
