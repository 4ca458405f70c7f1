"""Families in a motion: room that grows, members by name, files, modes, starts and limits."""

import numpy as np
import pytest

import freebody as fb
from freebody.motion.families.pair_quantities import upright_tangents
from freebody.motion.timestepping import timestepping


def balls(n, **options):
    """Return n spheres in a row on a floor, and their start."""
    s = fb.System("row")
    s.gravity = (0, 0, -9.81)
    bodies = [s.body(f"b{i}", fb.sphere(1, 0.1)) for i in range(n)]
    start = {}
    for i, body in enumerate(bodies):
        s.free(f"f{i}", s.ground, body)
        start |= {f"f{i}_x": 0.25 * i, f"f{i}_z": 0.1}
    s.contacts("row", [*(body.sphere(0.1) for body in bodies), s.ground.plane(normal="z")], **options)
    return s, start


def run(s, start, until=0.1, **options):
    return fb.simulate(s, until, initial=start, method="timestepping", step=0.01, **options)


def test_a_ball_at_rest_presses_with_its_weight_and_one_that_slides_is_slowed():
    s, start = balls(2, friction=0.2)
    motion = run(s, start | {"f1_vx": 1.0})
    still, slides = motion.contacts["row[b0,ground]"], motion.contacts["row[b1,ground]"]
    np.testing.assert_allclose(still.normal[1:], 9.81, rtol=1e-11)
    assert set(still.mode[1:]) == {"stick"} and set(slides.mode[1:]) == {"slip"}
    friction = np.linalg.norm(slides.tangential[1:], axis=1)
    np.testing.assert_allclose(friction, 0.2 * slides.normal[1:], rtol=1e-11)
    # speeds stand in axes of the body, whose spin changes by 5/2 μ g h/r in a step: m v Δω/2 beside m g
    np.testing.assert_allclose(slides.normal[1:], 9.81, rtol=5 / 2 * 0.2 * 0.01 / 0.1 / 2)
    np.testing.assert_allclose(slides.margin[1:], 0, atol=1e-9)
    apart = motion.contacts["row[b0,b1]"]
    np.testing.assert_allclose(apart.gap[0], 0.05)
    assert set(apart.mode) == {"open"} and np.isnan(apart.margin).all()
    assert list(motion.contacts) == ["row[b0,ground]", "row[b1,ground]", "row[b0,b1]"]


def test_room_for_pairs_grows(monkeypatch):
    monkeypatch.setattr(timestepping, "PAIRS", 1 - 6 * 5)
    one = run(*balls(4))
    monkeypatch.undo()
    np.testing.assert_allclose(one.states, run(*balls(4)).states, atol=1e-12)
    assert one.contacts["row[b3,ground]"].normal[-1] == pytest.approx(9.81)


def test_a_motion_with_families_is_saved_and_loaded(tmp_path):
    s, start = balls(3, friction=0.4)
    motion = run(s, start | {"f0_vx": 2.0})
    motion.save(tmp_path / "row.nc")
    again = fb.Trajectory.load(tmp_path / "row.nc")
    for name in ("row[b0,b1]", "row[b2,ground]"):
        np.testing.assert_array_equal(again.contacts[name].normal, motion.contacts[name].normal)


def test_a_few_pairs_also_move_by_events():
    s, start = balls(2, friction=0.4)
    start |= {"f0_z": 0.2}
    by_events, in_steps = fb.simulate(s, 0.1, initial=start), run(s, start)
    assert "row[b0,b1]" in by_events.contacts
    np.testing.assert_allclose(by_events["f0_z"][-1], in_steps["f0_z"][-1], atol=1e-9)


def test_tangents_are_at_right_angles_for_every_normal():
    n = np.array([[0, 0, 1], [0, 0, -1], [0.6, 0, -0.8], [0, -0.6, 0.8], [1, 0, 0]])
    for up in ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]):
        t = upright_tangents(n, up)
        np.testing.assert_allclose(np.cross(t[:, 0], t[:, 1]), n, atol=1e-15)
        np.testing.assert_allclose(np.einsum("kij,kj->ki", t, n), 0, atol=1e-15)
