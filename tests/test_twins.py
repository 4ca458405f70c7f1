"""Every file of the source has a unit test file that mirrors it, or one that is known to run it."""

from __future__ import annotations

import twins


def test_every_file_has_a_twin() -> None:
    without = {source for source in twins.sources() if not twins.twin(source).is_file()}
    run_by = twins.table()
    assert without - set(run_by) == set(), (
        "add tests/unit/ROOM/test_FILE.py, or measure anew: python -m tests.twins"
    )
    assert set(run_by) - without == set(), "these have a twin, or are gone"
    assert {test for test in run_by.values() if not (twins.UNIT / test).is_file()} == set()


def test_every_unit_test_stands_in_a_room() -> None:
    for path in twins.UNIT.rglob("test_*.py"):
        folder = path.parent.relative_to(twins.UNIT)
        assert (twins.SOURCE / folder).is_dir(), path
