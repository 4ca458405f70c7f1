"""One list of how runs end, for single runs and lanes."""

from __future__ import annotations

import pytest

from freebody.motion.ending import ENDS, FAILED, GOOD, STATUS, End


def test_ends_have_numbers_and_texts_of_their_own() -> None:
    """And stores keep a number in one byte, with the text as one word."""
    assert len(End) == len(ENDS) == len({str(end) for end in End}) == 21
    assert all(-128 <= end < 128 and End.of_text(str(end)) is end is ENDS[end] for end in End)
    words = {text.replace(",", "").replace(" ", "_") for text in STATUS.values()}
    assert len(words) == len(STATUS) == 16 and all(word.replace("_", "").isalpha() for word in words)
    with pytest.raises(ValueError, match="its status is 'fine'"):
        End.of_text("fine")


def test_lanes_end_as_runs_do() -> None:
    assert {*GOOD, *FAILED, End.CONTRADICTED} < {*STATUS} and not {*GOOD} & {*FAILED}
