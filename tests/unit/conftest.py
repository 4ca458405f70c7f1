"""What several of these tests look at."""

from __future__ import annotations

import pytest


@pytest.fixture
def loops(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Of each compiled loop over lanes that a test makes, whether it runs eight lanes at once."""
    from freebody.motion.batch.lane_loop import LaneLoop

    seen: list[bool] = []
    made = LaneLoop.__init__

    def watched(self, *arguments, **options):
        made(self, *arguments, **options)
        seen.append(self.wide)

    monkeypatch.setattr(LaneLoop, "__init__", watched)
    return seen


@pytest.fixture
def stages(monkeypatch: pytest.MonkeyPatch) -> None:
    """With "auto" lanes begin by `dop853`, whose bits are those of a run alone, however short their series."""
    from freebody.motion.kernels import methods

    monkeypatch.setattr(methods, "PRODUCTS_OF_EIGHT", -1)
