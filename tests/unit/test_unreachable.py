"""The search for unreachable objects is off during an import, and afterwards as it was."""

import gc
import subprocess
import sys

import pytest

from freebody.unreachable import no_collection


@pytest.mark.parametrize("searches", [True, False])
def test_the_search_is_as_it_was(searches: bool) -> None:
    before = gc.isenabled()
    (gc.enable if searches else gc.disable)()
    try:
        with pytest.raises(KeyError), no_collection():
            assert not gc.isenabled()
            raise KeyError
        assert gc.isenabled() is searches
    finally:
        (gc.enable if before else gc.disable)()


def test_no_full_search_while_a_public_name_is_imported() -> None:
    code = (
        "import gc, freebody as fb\n"
        "before = gc.get_stats()[2]['collections']\n"
        "fb.System\n"
        "assert gc.get_stats()[2]['collections'] == before and gc.isenabled()"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_what_is_made_meanwhile_is_old_and_frozen_objects_stay_frozen():
    with no_collection():
        made = [[] for _ in range(10_000)]
    assert gc.get_freeze_count() == 0 and len(gc.get_objects(generation=0)) < 5_000
    old = {id(x) for x in gc.get_objects(generation=2)}
    assert all(id(x) in old for x in made)
    gc.freeze()
    try:
        frozen = gc.get_freeze_count()
        with no_collection():
            pass
        assert gc.get_freeze_count() == frozen
    finally:
        gc.unfreeze()
