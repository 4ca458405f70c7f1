"""A sample of the cases of a slow test for every run; the others are marked slow."""

from __future__ import annotations

from collections.abc import Container, Iterable
from typing import Any

import pytest


def sampled(cases: Iterable[Any], every: int, heavy: Container[Any] = ()) -> list[Any]:
    """Return the cases, of which one of so many, unless it is heavy, is fast; a tuple has an argument each."""
    return [
        x
        if i % every == 0 and x not in heavy
        else pytest.param(*(x if isinstance(x, tuple) else (x,)), marks=pytest.mark.slow)
        for i, x in enumerate(cases)
    ]
