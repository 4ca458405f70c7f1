"""A sample of the cases of a slow test for every run; the others are marked slow."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def sampled(cases: Iterable[Any], every: int) -> list[Any]:
    """Return the cases, of which one of so many is fast."""
    return [x if i % every == 0 else pytest.param(x, marks=pytest.mark.slow) for i, x in enumerate(cases)]
