"""The line of progress: on terminals by rich, in notebooks by an output that is replaced."""

from __future__ import annotations

import sys
from types import ModuleType

import pytest

from freebody.studies.blocks import line, tally
from freebody.studies.blocks.block import Report


@pytest.fixture
def shown(monkeypatch) -> list[tuple[str, str]]:
    """What a notebook gets, with IPython's display replaced."""
    result: list[tuple[str, str]] = []

    class Handle:
        def update(self, data, raw) -> None:
            assert raw
            result.append(("update", data["text/plain"]))

    def display(data, raw, display_id):
        assert raw and display_id
        result.append(("display", data["text/plain"]))
        return Handle()

    for name in ("ipykernel", "IPython", "IPython.display"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    sys.modules["IPython.display"].display = display
    monkeypatch.setattr(line, "_PAUSE", 0)
    monkeypatch.setattr(tally, "_PATIENCE", 0)
    return result


def count(display) -> None:
    with tally.Tally(10, display) as lanes:
        lanes.begin(10, 0)
        for low in (0, 5):
            lanes.count(Report(low, low + 5, 5, 0.1, {1: 5}))


def test_a_notebook_has_one_output_that_is_emptied_at_the_end(shown) -> None:
    count(None)
    kinds, texts = zip(*shown, strict=True)
    assert kinds[0] == "display" and set(kinds[1:]) == {"update"} and texts[-1] == ""
    assert texts[0].startswith("█" * 20 + "░" * 20) and "5 of 10 lanes" in texts[0] and "lanes/s" in texts[0]
    assert "10 of 10 lanes" in texts[-2]


def test_a_notebook_is_not_written_to_without_need(shown, monkeypatch) -> None:
    count(False)
    assert not shown
    monkeypatch.setattr(line, "_PAUSE", 1e9)
    count(None)
    assert [kind for kind, _ in shown] == ["update"] or [text for _, text in shown][-1] == ""


def test_a_terminal_shows_a_line(capsys, monkeypatch) -> None:
    monkeypatch.setattr(tally, "_PATIENCE", 0)
    monkeypatch.delitem(sys.modules, "ipykernel", raising=False)
    count(True)
    assert "10 of 10 lanes" in capsys.readouterr().err
