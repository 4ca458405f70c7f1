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
