"""Loads that switch beside contacts: closed forms while a ball bounces, rests, refusals, events, files."""

import pickle

import numpy as np
import pytest

import freebody as fb
from contact_machines import add_bouncing_ball
from freebody.errors import SimulationError
from freebody.motion.kernels import sided_run

K, G, C = 100.0, 9.81, 1.0


def block(law, beside=True, **parameters):
    """A block under a law and, beside it, a ball that bounces without loss from y = 1 to the floor at y = 0."""
    s = fb.System("block")
    s.parameters(m=1.0, k=K, c=C, g=G, **parameters)
    body = s.body("block", fb.particle("m"))
    s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.force("law", body, (law, 0, 0))
    if beside:
        add_bouncing_ball(s)
    return s


def run(law, until, start, **options):
    return fb.simulate(block(law), until, initial={"y": 1.0, **start}, **options)


def rocking(t):
    """x of x'' = -k sign(x) from rest at 1: parabolas, each of 2 √(2/k), of alternate sides."""
    half = 2 * np.sqrt(2 / K)
    n, rest = np.divmod(t + half / 2, half)
    return (-1) ** n * (1 - K * (rest - half / 2) ** 2 / 2)


def bouncing(t):
    half = 2 * np.sqrt(2 / G)
    return 1 - G * (np.mod(t + half / 2, half) - half / 2) ** 2 / 2


@pytest.mark.parametrize("method", ["auto", pytest.param("radau", marks=pytest.mark.slow)])
def test_a_potential_with_an_edge(method):
    motion = run("-k*sign(x)", 3, {"x": 1}, method=method)
    assert motion["x"] == pytest.approx(rocking(motion.t), abs=1e-9)
    assert motion["y"] == pytest.approx(bouncing(motion.t), abs=1e-9)
    assert motion.path.rejected == 0 and np.abs(motion.energy.residual).max() < 1e-9


@pytest.mark.parametrize("law", ["-k*max(x, 0) - 4*k*min(x, 0)", "-5*k/2*x + 3*k/2*abs(x)"])
def test_a_spring_of_two_stiffnesses(law):
    """Half turns of ω = √k and of 2 ω; (1, 1/4) in five periods, and the run without contacts."""
    until = 5 * 1.5 * np.pi / np.sqrt(K)
    motion = run(law, until, {"x'": 1}, tolerance=1e-11)
    alone = fb.simulate(block(law, False), until, initial={"x'": 1}, tolerance=1e-11)
    for name in ("x", "x'"):
        assert motion[name][-1] == pytest.approx(alone[name][-1], abs=1e-9)
    assert [motion["x"][-1], motion["x'"][-1]] == pytest.approx([0, 1], abs=1e-9)


def test_a_dip_within_one_step_is_found():
    """Under a force k it comes down to x = -1e-4 and is below zero for 0.003 s, where the force is -5 k."""
    v = np.sqrt(2 * K * 0.5 + 1e-2)
    motion = run("3*k*sign(x) - 2*k", 0.3, {"x": 0.5, "x'": -v})
    down = np.sqrt(v * v - K)
    s = 0.3 - (v - down) / K
    assert motion["x"][-1] == pytest.approx(-down * s - 5 * K * s * s / 2, abs=1e-8)


def test_a_law_of_the_speed_that_an_impact_turns():
    """Under a drag -c sign(y') it falls with g - c and rises with g + c; e = 4/5, after 1.2 s on its second rise."""
    s = fb.System("ball")
    s.parameters(g=G, c=C)
    ball = s.body("ball", fb.particle(1))
    s.slider("fall", s.ground, ball, axis="y", coordinate="y")
    s.force("weight", ball, (0, "-g - c*sign(y')", 0))
    s.contact("floor", ball.point(0, 0, 0), s.ground.plane(normal="y"), friction=0, restitution=0.8)
    motion = fb.simulate(s, 1.2, initial={"y": 1.0})
    down, up = G - C, G + C
    first = np.sqrt(2 / down)
    v = 0.8 * down * first
    second = first + v / up + np.sqrt(v * v / up / down)
    w, left = 0.8 * np.sqrt(v * v / up * down), 1.2 - second
    assert 0 < left < w / up
    assert motion["y"][-1] == pytest.approx(w * left - up * left**2 / 2, abs=1e-10)
    assert np.abs(motion.energy.residual).max() < 1e-12


def sliding(law):
    s = fb.System("sledge")
    s.parameters(c=C, g=G)
    body = s.body("sledge", fb.particle(1))
    cart = s.body("cart", fb.particle(1))
    s.slider("along", s.ground, cart, axis="x", coordinate="x")
    s.slider("up", cart, body, axis="y", coordinate="y")
    s.force("weight", body, (0, "-g", 0))
    s.force("law", cart, (law, 0, 0))
    s.contact("floor", body.point(0, 0, 0), s.ground.plane(normal="y"), friction=0.2, restitution=0)
    return s


def test_friction_of_a_contact_holds_where_a_law_switches():
    """Both end the slip at once; μ g > c holds it, so that sign(x') = 0 rests."""
    motion = fb.simulate(sliding("-c*sign(x')"), 3, initial={"x'": 2.0})
    assert motion["x"][-1] == pytest.approx(4 / (0.2 * G + C), abs=1e-9)
    assert [change.mode for change in motion.modes] == ["slip+", "stick"] and motion.path.steps < 30
    still = fb.simulate(sliding("-c*sign(x') - c*abs(x')*x'"), 1)
    assert not still["x"].any() and len(still.modes) == 1


def test_motions_that_stick_are_refused_at_the_switch():
    """As without contacts: where both sides lead back, at the start and later, and where switches come ever faster."""
    for law, start, when in (
        ("c - k*sign(x)", {}, "t = 0 s, where x = 0"),
        ("-c*sign(x')", {"x'": 2}, r"t = 2(\.0*1)? s, where x' = 0"),
        ("-k*sign(x) - k/2*sign(x')", {"x": 1}, r"t = 0\.63094010\d* s"),
    ):
        with pytest.raises(SimulationError, match=f"it sticks at {when}") as caught:
            run(law, 10, start)
        assert "s.friction(" in str(caught.value)
    with pytest.raises(SimulationError, match=r"it sticks at t = 0\.574\d* s, where x' = 0"):
        fb.simulate(sliding("-5*c*sign(x')"), 3, initial={"x'": 2.0})
    assert run("-c*sign(x')", 2, {"x'": 2}).status == "finished"


def test_a_rest_at_an_edge():
    assert not run("-k*sign(x)", 2, {})["x"].any()
    assert run("2*k - k*sign(x)", 1, {})["x"][-1] == pytest.approx(K / 2, rel=1e-12)


def test_events_that_jump_where_a_law_switches():
    quarter = np.sqrt(2 / K)
    events = ["x", fb.event("sign(x)*(x + 2)", name="rises", direction=1), "sign(2*x)"]
    motion = run("-k*sign(x)", 6 * quarter, {"x": 1}, events=events)
    found = [(round(e.time / quarter, 6), e.name, e.direction) for e in motion.events if e.direction]
    assert sorted(found) == [
        (1, "sign(2*x)", -1), (1, "x", -1), (3, "rises", 1), (3, "sign(2*x)", 1), (3, "x", 1), (5, "sign(2*x)", -1),
        (5, "x", -1),
    ]  # fmt: skip
    last = fb.event("sign(x)*(x + 2)", direction=1, terminal=True)
    motion = run("-k*sign(x)", 9, {"x": 1}, events=[last])
    assert motion.path.end == pytest.approx(3 * quarter, rel=1e-12)


def test_bends_whose_e_is_round_off_have_a_band(monkeypatch):
    monkeypatch.setattr(sided_run, "IN_A_ROW", 3)
    s = block("-2*x")
    body = s.body("other", fb.particle(1))
    s.slider("rail", s.bodies["block"], body, axis="z", coordinate="z")
    s.force("push", s.bodies["block"], ("-2*abs(3*x' - z')", 0, 0))
    s.force("pull", body, (0, 0, "-z - 3*abs(3*x' - z')"))
    motion = fb.simulate(s, 30, initial={"x": 0.1, "z": 0.3, "y": 1.0})
    assert motion["x"][-1] == pytest.approx(0.1 * np.cos(30), abs=1e-7)
    assert len(motion.path.segments) < 200


def test_signals_blows_and_contacts():
    """x'' = F - k sign(x), F = 0, then k/2 from t = 1; the runs with and without a ball are the same."""
    ends = []
    for beside in (True, False):
        s = block("-k*sign(x)", beside)
        force = fb.signal([0, 1, 3], [0, K / 2, K / 2], "previous", name="F")
        body = s.bodies["block"]
        s.force("push", body, (force, 0, 0))
        blow = fb.blow(0.5, at=body.center, impulse=(-20, 0, 0))
        motion = fb.simulate(s, 2, initial={"x": 1, **({"y": 1.0} if beside else {})}, impulses=[blow])
        ends.append([motion["x"][-1], motion["x'"][-1]])
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)


def test_files_and_pickles_keep_the_sides(tmp_path):
    motion, times = run("-k*sign(x)", 2, {"x": 1}), np.linspace(0, 2, 41)
    motion.save(tmp_path / "edge.nc")
    for copy in (pickle.loads(pickle.dumps(motion)), fb.Trajectory.load(tmp_path / "edge.nc")):
        assert (copy.path.sample(times) == motion.path.sample(times)).all()
        assert (copy.path.sample(times, dense=True) == motion.path.sample(times, dense=True)).all()


def test_runs_again_with_other_values():
    """The memory of a finished run serves the next, with its own sides and values."""
    s = block("-k*sign(x - x0)", x0=0.0)
    for x0 in (0.5, -0.5, 2.0, 0.0):
        motion = fb.simulate(s, 0.1, initial={"x": 1, "y": 1.0}, values={"x0": x0})
        t = min(0.1, np.sqrt(2 * abs(1 - x0) / K))
        side = np.sign(1 - x0)
        rest, v = 0.1 - t, -side * K * t
        exact = 1 - side * K * t * t / 2 + v * rest + side * K * rest**2 / 2
        assert motion["x"][-1] == pytest.approx(exact, abs=1e-9)


def test_beside_patches():
    """A box on a smooth floor, on which it lies by a face, under -k sign(x)."""
    s = fb.System("box")
    s.gravity = (0, 0, -G)
    body = s.body("box", fb.box(1, (1, 1, 1)))
    s.free("f", s.ground, body)
    s.contacts("all", [body.box((1, 1, 1)), s.ground.box((20, 20, 1), at=(0, 0, -0.5))], friction=0)
    s.force("law", body.center, (f"-{K}*sign(f_x)", 0, 0))
    motion = fb.simulate(s, 3, initial={"f_x": 1.0, "f_z": 0.5})
    assert motion.kernels.model.patches and motion.path.rejected == 0
    assert motion["f_x"] == pytest.approx(rocking(motion.t), abs=1e-9)
