"""Changes of mode in time steps, and why each began."""

import math

import freebody as fb

G = 9.81


def test_each_mode_begins_where_the_one_before_ends_and_says_why():
    """A block is dropped, slides, stops, and slides again when its load grows beyond the limit of friction."""
    s = fb.System("block")
    s.gravity = (0, -G, 0)
    block = s.body("block", fb.box(1, (0.2, 0.2, 0.2)))
    s.planar("rail", s.ground, block, coordinate="x y turn")
    s.contact("floor", block.point(0, 0, 0), s.ground.plane(normal="y"), friction=0.5)
    s.force("pull", block.point(0, 0, 0), ("10*t", 0, 0))
    kick = fb.blow(0.305, at=block.point(0, 0, 0), impulse=(0.0, 0, 0), name="none")
    start = {"y": 0.05, "x'": 0.5}
    motion = fb.simulate(s, 0.6, initial=start, method="timestepping", step=1e-3, impulses=kick)
    modes = list(motion.modes)
    assert [change.mode for change in modes] == ["open", "slip+", "stick", "slip+"]
    assert [change.why for change in modes[:3]] == ["the start", "the gap closed", "the slip stopped"]
    assert modes[3].why.startswith("|T| reached 4.9") and modes[3].why.endswith(" N")
    for before, after in zip(modes[:-1], modes[1:], strict=True):
        assert before.end == after.start
    assert abs(modes[1].start - math.sqrt(2 * 0.05 / G)) < 2e-3
    assert abs(modes[3].start - 0.5 * G / 10) < 2e-3  # 10 t = μ m g
    told = [one for one in motion.happenings if one.name == "floor"]
    assert [one.time for one in told] == [change.start for change in modes[1:]]
    assert all(one.state != one.after for one in told)
    assert "t = 0.305 s: none: no speed changes" in map(str, motion.happenings)
