"""Bodies that begin inside each other: one message names all of them."""

import pytest

import freebody as fb
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


def box_and_disk() -> tuple[fb.System, fb.Body, fb.Body]:
    s = fb.System("pair")
    box, disk = s.body("box", fb.box(2, (0.4, 0.3, 0.2))), s.body("disk", fb.disk(1, 0.15))
    s.planar("a", s.ground, box, coordinate="x y w")
    s.planar("b", s.ground, disk, coordinate="x2 y2 w2")
    return s, box, disk


@pytest.mark.parametrize("options", [{}, {"method": "timestepping", "step": 1e-3}])
def test_a_disk_behind_the_far_side_of_a_box_is_told_of_solids(options):
    """The box of sides is refused; the solid that the message names is hit."""
    start = {"x2": 1.0, "x2'": -2.0, "y2": 0.1}
    s, box, disk = box_and_disk()
    s.contact("left", disk.circle(0.15), box.segment((-0.2, -0.15, 0), (-0.2, 0.15, 0), normal="-x"))
    with pytest.raises(SimulationError, match=r"has contact 'left' 1\.35 m deep\. Begin with every gap at zero or above\. All that is behind the side of 'left' counts as inside its body\. A body that others touch all around is a solid in a family: s\.contacts\(\[body\.box\(\.\.\.\) or body\.hull\(\.\.\.\), \.\.\.\]\), with body\.sphere\(radius\) for a disk\."):  # fmt: skip  # noqa: E501
        fb.simulate(s, 1, initial=start, **options)
    s, box, disk = box_and_disk()
    s.contacts("pile", [disk.sphere(0.15), box.box((0.4, 0.3, 0.2))], restitution=0.5)
    motion = fb.simulate(s, 1, initial=start, samples=101, **options)
    assert motion["x2'"][-1] > -1 and motion["x'"][-1] < -0.5
    assert motion["pile[disk,box].gap"].min() > -1e-3
