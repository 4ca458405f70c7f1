"""Laws of motion with contact, on boxes thrown at random: the ledger closes, energy falls, nothing enters the floor."""

import numpy as np
import pytest

import freebody as fb

G = 9.81


@pytest.fixture(scope="module")
def box():
    s = fb.System("box")
    g, mu, e = s.parameters(g=G, mu=0.5, e=0.3)
    s.gravity = (0, -g, 0)
    body = s.body("box", fb.box(3, (0.3, 0.5, 1)))
    s.planar("rail", s.ground, body, coordinate="x y theta")
    floor = s.ground.plane(normal="y")
    s.contact("foot", body.corners(size=(0.3, 0.5)), floor, friction=mu, restitution=e, impact="poisson")
    return s


@pytest.mark.parametrize("seed", range(8))
def test_thrown_box(box, seed):
    rng = np.random.default_rng(seed)
    values = {"mu": rng.choice([0.0, 0.2, 0.6, 1.0]), "e": rng.choice([0.0, 0.3, 0.6])}
    start = {
        "y": 1.0, "theta": rng.uniform(-3, 3), "x'": 2 * rng.normal(), "theta'": 4 * rng.normal(),
    }  # fmt: skip
    motion = fb.simulate(box, 3, initial=start, values=values, samples=1501)
    # a thousand steps at 1e-9 each, with room
    assert motion.energy.relative_residual < 1e-7
    total = motion.energy.total
    assert np.diff(total).max() < 1e-7 * total[0]
    assert (np.diff(motion.energy.impulses) <= 1e-15).all()
    assert (np.diff(motion.energy.friction) <= 1e-9).all()
    down = np.zeros(len(motion.t))
    for one in motion.contacts.values():
        assert one.gap.min() > -1e-12
        N, T = one.least[:, 0], one.least[:, 1]
        size = 3 * G
        assert N.min() >= -1e-9 * size
        assert (np.abs(T) <= values["mu"] * N + 1e-7 * size).all()
        open_ = one.mode == "open"
        assert (N[open_] == 0).all()
        assert np.abs(one.gap[~open_]).max(initial=0) < 1e-12
        assert np.abs(one.slip[one.mode == "stick"]).max(initial=0) < 1e-9
        sliding = np.isin(one.mode, ["slip+", "slip-"]) & (np.abs(one.slip) > 1e-6)
        assert (T[sliding] * one.slip[sliding] <= 1e-12).all()
        down += N
    # where nothing turns any more, the floor carries the weight
    still = np.abs(motion["theta'"]) < 1e-13
    resting = still & np.any([one.mode != "open" for one in motion.contacts.values()], axis=0)
    np.testing.assert_allclose(down[resting], 3 * G, rtol=1e-9)


def test_output_times_and_terminal_events_of_the_user(box):
    times = [0, 0.1, 0.25, 1.5]
    motion = fb.simulate(
        box, 2, initial={"y": 0.5, "x'": 1.0}, times=times, events=[fb.event("x - 0.2", terminal=True)]
    )
    assert motion.status == "terminal event"
    assert list(motion.t) == [0, 0.1]
    assert motion.at(motion.path.end)["x"] == pytest.approx(0.2, abs=1e-12)
    with pytest.raises(fb.errors.SimulationError, match="Expected times within the run"):
        motion.at(1.9)


@pytest.mark.slow
@pytest.mark.parametrize("law", ["poisson", "newton"])
def test_fifty_thrown_boxes_end_well_or_are_refused_by_a_law(law):
    s = fb.System("box")
    g, mu, e = s.parameters(g=G, mu=0.5, e=0.3)
    s.gravity = (0, -g, 0)
    body = s.body("box", fb.box(3, (0.3, 0.5, 1)))
    s.planar("rail", s.ground, body, coordinate="x y theta")
    s.contact("foot", body.corners(size=(0.3, 0.5)), s.ground.plane(), friction=mu, restitution=e, impact=law)
    refused = 0
    for seed in range(100, 150):
        rng = np.random.default_rng(seed)
        values = {"mu": rng.choice([0.0, 0.2, 0.6, 1.0]), "e": rng.choice([0.0, 0.3, 0.6, 0.8])}
        start = {
            "y": 1.0, "theta": rng.uniform(-3, 3), "x'": 2 * rng.normal(), "theta'": 4 * rng.normal(),
        }  # fmt: skip
        try:
            motion = fb.simulate(s, 3, initial=start, values=values)
        except fb.errors.SimulationError as error:
            # Newton's law with friction may make energy (Kane); nothing else may stop a run
            assert law == "newton" and "would create energy" in str(error), (seed, str(error))
            refused += 1
            continue
        assert motion.energy.relative_residual < 1e-7
        assert np.diff(motion.energy.total).max() < 1e-7 * motion.energy.total[0]
        assert min(one.gap.min() for one in motion.contacts.values()) > -1e-11
    assert refused < 10


def thrown_in_space(law, solid, shape):
    s = fb.System("thrown")
    mu, e = s.parameters(mu=0.5, e=0.3)
    s.gravity = (0, 0, -G)
    body = s.body("body", solid)
    s.free("f", s.ground, body)
    s.contact("foot", shape(body), s.ground.plane(normal="z"), friction=mu, restitution=e, impact=law)
    return s


def check_space(s, seed, until):
    """A throw obeys the laws; True if it was refused because Newton's law would create energy (Kane)."""
    rng = np.random.default_rng(seed)
    values = {"mu": float(rng.choice([0.0, 0.2, 0.6, 1.0])), "e": float(rng.choice([0.0, 0.3, 0.6, 0.8]))}
    start = {
        "f_z": 0.6,
        "f_vx": rng.normal(),
        "f_vy": rng.normal(),
        **{f"f_w{c}": 3 * rng.normal() for c in "xyz"},
    }
    try:
        motion = fb.simulate(s, until, initial=start, values=values, indeterminate="compliance", samples=401)
    except fb.errors.SimulationError as error:
        assert "would create energy" in str(error), (seed, str(error))
        return True
    size = 3 * G
    assert motion.energy.relative_residual < 1e-7
    assert np.diff(motion.energy.total).max() < 1e-7 * motion.energy.total[0]
    assert (np.diff(motion.energy.impulses) <= 1e-12).all()
    push = np.zeros((len(motion.t), 3))
    for one in motion.contacts.values():
        N, T = one.least[:, 0], one.least[:, 1:]
        assert one.gap.min() > -1e-11
        assert N.min() >= -1e-9 * size
        assert np.abs(N * one.gap).max() < 1e-9 * size
        # a slip that begins slowly has the direction of its first 1e-9 m/s
        assert (values["mu"] * N + 1e-6 * size >= np.linalg.norm(T, axis=1)).all()
        assert (np.einsum("ni,ni->n", T, one.slip) <= 1e-9 * size).all()
        push += np.column_stack([T, N])
    # momentum between output times of one phase: m dv = (T, N - m g) dt, by Simpson's rule. Its error is a fifteenth of
    # the difference to the rule of twice the step (of order 4), here a third at most, and that of the run
    R = np.asarray(motion.poses["body"].rotation)
    p = 3 * np.einsum("nij,nj->ni", R, np.stack([motion[f"f_v{c}"] for c in "xyz"], axis=-1))
    ends = np.array([segment.path.times[-1] for segment in motion.path.segments[:-1]])
    push -= [0, 0, size]
    t, checked = motion.t, 0
    for i in range(len(t) - 4):
        if ((ends >= t[i]) & (ends <= t[i + 4])).any():
            continue
        length = t[i + 4] - t[i]
        fine = length / 12 * np.array([1, 4, 2, 4, 1]) @ push[i : i + 5]
        coarse = length / 6 * np.array([1, 4, 1]) @ push[i : i + 5 : 2]
        error = np.abs(p[i + 4] - p[i] - fine).max()
        assert error < np.abs(fine - coarse).max() / 3 + 1e-8 * size * length, (t[i], error / size / length)
        checked += 1
    assert checked > 50
    return False


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_thrown_balls(law):
    s = thrown_in_space(law, fb.sphere(3, 0.2), lambda body: body.sphere(0.2))
    for seed in range(6):
        assert not check_space(s, seed, 1.5)


def test_a_box_thrown_in_space():
    s = thrown_in_space("newton", fb.box(3, (0.3, 0.5, 0.4)), lambda body: body.corners(size=(0.3, 0.5, 0.4)))
    assert not check_space(s, 6, 0.8)


@pytest.mark.slow
@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("seed", range(1, 8))
def test_boxes_thrown_in_space_come_to_rest_or_are_refused_by_a_law(law, seed):
    s = thrown_in_space(law, fb.box(3, (0.3, 0.5, 0.4)), lambda body: body.corners(size=(0.3, 0.5, 0.4)))
    assert not check_space(s, seed, 2) or law == "newton"
