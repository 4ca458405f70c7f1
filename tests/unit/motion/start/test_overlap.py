"""Bodies that begin inside each other: one message names all of them."""

import numpy as np
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


@pytest.mark.parametrize("options", [{}, {"method": "timestepping", "step": 1e-3}])
def test_what_comes_behind_a_side_is_told_and_not_touched_from_behind(options):
    """A pendulum swings around the end of a shelf, up through it, and lands on it."""
    machines = [fb.System("shelf"), fb.System("free")]
    for s in machines:
        s.gravity = (0, -9.81, 0)
        bob = s.body("bob", fb.particle(1))
        s.hinge("pin", s.ground, bob, at=(1.2, 0.3, 0), to=(0, 1, 0), axis="z", coordinate="q")
        if s is machines[0]:
            s.contact("shelf", bob.origin, s.ground.segment((-1, 0, 0), (1, 0, 0), normal="y"), friction=0.1)
    motion, free = (fb.simulate(s, 3, initial={"q": 1.5}, **options) for s in machines)
    before = motion.t < 1.38
    assert motion["q"][before] == pytest.approx(free["q"][before], abs=1e-8)
    (warning,) = motion.warnings
    assert str(warning).startswith("shelf: comes behind the side, -0.67")
    assert "All that is there counts as inside its body: from t = 0.63" in str(warning)
    assert "A body that others touch all around is a solid in a family" in str(warning)
    ((begins, ends),) = warning.spans
    for time, inside in ((begins, True), (ends, True), (begins - 0.01, False), (ends + 0.01, False)):
        x, y = 1.2 + np.sin(motion.at(time)["q"]), 0.3 - np.cos(motion.at(time)["q"])
        assert (abs(x) < 1 and y < 0) == inside
    (landing,) = [event for event in motion.events if "open → stick" in str(event)]
    assert landing.time == pytest.approx(1.3846, abs=2e-3)
    assert motion["q"][-1] == pytest.approx(-np.arccos(0.3))  # height 0


@pytest.mark.parametrize("options", [{}, {"method": "timestepping", "step": 1e-2}])
def test_what_lands_near_the_end_of_a_side_within_a_step_is_stopped(options):
    s = fb.System("ledge")
    s.gravity = (0, -9.81, 0)
    stone = s.body("stone", fb.particle(1))
    s.chain("fly", s.ground, stone, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("ledge", stone.origin, s.ground.segment((0, 0, 0), (1, 0, 0), normal="y"), friction=0)
    start = {"x": -0.02, "x'": 4.2, "y": 0.04, "y'": -8}  # over the end at t = 0.0048, at y = 0.002
    motion = fb.simulate(s, 0.1, initial=start, **options)
    assert motion["y"][-1] == pytest.approx(0, abs=1e-9) and not motion.warnings
    start["y"] = 0.036  # at y = -0.002
    motion = fb.simulate(s, 0.1, initial=start, **options)
    assert motion["y"][-1] < -0.7 and [warning.name for warning in motion.warnings] == ["ledge"]
