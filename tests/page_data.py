"""The data of a page, read as the page reads it."""

from __future__ import annotations

import base64
import gzip
import json
import re
from typing import Any

import numpy as np


def scene_of(text: str) -> Any:
    """The data in the text of a page."""
    found = re.search(r'<script type="application/octet-stream" id="scene">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    return unpacked(found[1])


def unpacked(text: str) -> Any:
    """The inverse of `packed`; arrays of values over time are 32-bit floats, shape (n,) or (n, width)."""
    whole = gzip.decompress(base64.b64decode(text))
    count = int.from_bytes(whole[:4], "little")
    tree, arrays = whole[4 : 4 + count], whole[4 + count :]
    return json.loads(tree, object_hook=lambda value: _array(arrays, *value["#"]) if "#" in value else value)


def _array(arrays: bytes, kind: str, count: int, places: Any) -> Any:
    if kind == "byte":
        return np.frombuffer(arrays, "u1", count, places)
    if kind != "rounded":
        bits = np.cumsum(_whole(arrays, places, count), dtype=np.uint32)
        return bits.view(np.float32) if kind == "real" else bits
    result = np.zeros((count, len(places)), dtype=np.float32)
    for j, (step, order, place) in enumerate(places):
        zigzag = _whole(arrays, place, count).astype(np.int64)
        stored = (zigzag >> 1) ^ -(zigzag & 1)
        for _ in range(order):
            stored = np.cumsum(stored)
        result[:, j] = step * stored
    return result[:, 0] if len(places) == 1 else result


def _whole(arrays: bytes, place: int, count: int) -> Any:
    planes = np.frombuffer(arrays, "u1", 4 * count, place).reshape(4, count)
    return np.ascontiguousarray(planes.T).view("<u4")[:, 0]
