"""Bodies that begin inside each other: one message names all of them."""

import pytest

from freebody.errors import SimulationError
from freebody.motion.start.overlap import LISTED, refuse_overlap


def test_all_contacts_are_named_once_and_the_deepest_first():
    gaps = [("a", -0.1), ("b", 0.2), ("c", -0.3), ("a", -0.2)]
    with pytest.raises(SimulationError) as refused:
        refuse_overlap("pile", gaps, 1e-9, ", or hold them apart")
    assert str(refused.value) == (
        "The initial state of 'pile' has contacts 'c' 0.3 m deep, 'a' 0.2 m deep. "
        "Begin with every gap at zero or above, or hold them apart."
    )


def test_the_list_is_bounded():
    with pytest.raises(SimulationError, match=r"'c3' 0.3 m deep and 2 more\. Begin"):
        refuse_overlap("pile", [(f"c{k}", -k / 10) for k in range(LISTED + 2, 0, -1)], 1e-9)
