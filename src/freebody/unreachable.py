"""Work without Python's search for unreachable objects.

Imports and translations make a hundred thousand objects that all stay. The search goes through them again and again: it
takes a sixth of the time of an import of SymPy, and a third of that of a translation.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def no_collection() -> Iterator[None]:
    """Keep Python from its search for unreachable objects; afterwards it is as it was.

    What was made meanwhile counts as old: the next full search has it, and no search of the young goes through it.
    """
    searches = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if searches:
            if not gc.get_freeze_count():  # the caller's frozen objects stay so
                gc.freeze()
                gc.unfreeze()  # into the oldest generation, with counts of zero
            gc.enable()
