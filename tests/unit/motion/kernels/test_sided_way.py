"""Runs in legs between switches: closed forms, dips within one step, events, rests, files, batches."""

import pickle

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError
from freebody.motion.kernels import sided_run

METHODS = ["auto", "dop853", *(pytest.param(x, marks=pytest.mark.slow) for x in ("gauss", "radau", "tsit5"))]
K = 100.0


def block(law, **parameters):
    s = fb.System("block")
    s.parameters(m=1.0, k=K, c=1.0, **parameters)
    body = s.body("block", fb.particle("m"))
    s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.force("law", body, (law, 0, 0))
    return s


def rocking(t, height=1.0):
    """x of x'' = -k sign(x) from rest: parabolas, each of T/2 = 2 √(2 h/k), of alternate sides."""
    half = 2 * np.sqrt(2 * height / K)
    n, rest = np.divmod(t + half / 2, half)
    s = rest - half / 2
    return (-1) ** n * (height - K * s * s / 2)


@pytest.mark.parametrize("method", METHODS)
def test_a_potential_with_an_edge(method):
    """V = k |x|: steps of any method are exact, since all is of order 2, so that only places of switches round."""
    motion = fb.simulate(block("-k*sign(x)"), 10, initial={"x": 1}, method=method)
    assert motion["x"] == pytest.approx(rocking(motion.t), abs=1e-9)
    assert motion.path.rejected == 0 and np.abs(motion.energy.residual).max() < 1e-9


def test_steps_of_one_length_end_at_a_switch():
    motion = fb.simulate(block("-k*sign(x)"), 2, initial={"x": 1}, method="dop853", step=0.01)
    assert motion["x"] == pytest.approx(rocking(motion.t), abs=1e-12)


@pytest.mark.parametrize(
    "law", ["-k*x - 3*k*min(x, 0)", "-k*max(x, 0) - 4*k*min(x, 0)", "-5*k/2*x + 3*k/2*abs(x)"]
)
def test_a_spring_of_two_stiffnesses(law):
    """Half turns of ω = √k and of 2 ω, in which the amplitude is halved and doubled; (1, 1/4) in five periods."""
    half = np.pi / np.sqrt(K)
    motion = fb.simulate(block(law), 5 * 1.5 * half, initial={"x'": 1}, tolerance=1e-10, events=["x"])
    assert [motion["x"][-1], motion["x'"][-1]] == pytest.approx([0, 1], abs=1e-8)
    times = [event.time for event in motion.events[1:-1]]
    assert times == pytest.approx(np.cumsum([half, half / 2] * 5)[: len(times)], abs=1e-9)
    assert motion["max(x)"] == pytest.approx(1 / np.sqrt(K), abs=1e-9)
    assert motion["min(x)"] == pytest.approx(-0.5 / np.sqrt(K), abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_a_dip_within_one_step_is_found(method):
    """Under a force k it comes down to x = -1e-4 and is below zero for 0.003 s, where the force is -5 k."""
    v = np.sqrt(2 * K * 0.5 + 1e-2)
    motion = fb.simulate(block("3*k*sign(x) - 2*k"), 0.3, initial={"x": 0.5, "x'": -v}, method=method)
    down = np.sqrt(v * v - K)  # speed at x = 0, where the force turns against it no more
    t = (v - down) / K
    s = 0.3 - t
    assert motion["x"][-1] == pytest.approx(-down * s - 5 * K * s * s / 2, abs=1e-8)


def test_a_dip_of_a_spring_without_pull_is_found():
    """A ball falls on a spring of 1e8 N/m, which it touches for 0.3 ms, and is thrown back to its height."""
    s = block("-c*g - K*min(x, 0)", g=10.0, K=1e8)
    motion = fb.simulate(s, 2, initial={"x": 5.0})
    touch = np.pi * np.sqrt(1e-8)
    assert motion["x"][-1] == pytest.approx(5 - 10 * touch**2 / 2, abs=1e-4)
    assert np.abs(motion.energy.residual).max() < 1e-6


def test_a_switch_of_the_time():
    """A force of alternate sense, ±c for a second each: v = 0 and x = n/2 ... after n periods."""
    motion = fb.simulate(block("c*sign(sin(pi*t))"), 6, tolerance=1e-11)
    assert [motion["x"][-1], motion["x'"][-1]] == pytest.approx([3 * 1.0, 0], abs=1e-8)


def test_two_laws_that_switch_at_one_time():
    motion = fb.simulate(block("-k/2*sign(x) - k/2*sign(3*x)"), 3, initial={"x": 1})
    assert motion["x"] == pytest.approx(rocking(motion.t), abs=1e-10)


def test_backwards_in_time():
    forth = fb.simulate(block("-k*sign(x) - c*x'"), 1, initial={"x": 1})
    start = {"x": float(forth["x"][-1]), "x'": float(forth["x'"][-1])}
    back = fb.simulate(block("-k*sign(x) - c*x'"), 0, initial=start, start=1)
    assert [back["x"][-1], back["x'"][-1]] == pytest.approx([1, 0], abs=1e-7)


def test_events_that_jump_where_a_law_switches():
    quarter = np.sqrt(2 / K)
    events = ["x", fb.event("sign(x)*(x + 2)", name="rises", direction=1), "sign(2*x)"]
    motion = fb.simulate(block("-k*sign(x)"), 6 * quarter, initial={"x": 1}, events=events)
    found = [(round(e.time / quarter, 6), e.name, e.direction) for e in motion.events]
    assert sorted(found) == [
        (1, "sign(2*x)", -1), (1, "x", -1), (3, "rises", 1), (3, "sign(2*x)", 1), (3, "x", 1), (5, "sign(2*x)", -1),
        (5, "x", -1),
    ]  # fmt: skip
    last = fb.event("2*x", direction=1, terminal=True)
    motion = fb.simulate(block("-k*sign(x)"), 9, initial={"x": 1}, events=[last])
    assert motion.status == "terminal event" and motion.path.end == pytest.approx(3 * quarter, rel=1e-12)
    assert len(motion.events) == 1


def test_a_rest_at_an_edge_that_a_load_ends():
    """sign(0) = 0 rests until a signal moves it; a greater load leaves at once, a smaller one is held by nothing."""
    assert not fb.simulate(block("-k*sign(x)"), 3)["x"].any()
    away = fb.simulate(block("2*k - k*sign(x)"), 1)
    assert away["x"][-1] == pytest.approx(K / 2, rel=1e-12)
    with pytest.raises(
        SimulationError, match=r"it sticks at t = 0 s, where x = 0: a law with sign\(x\) drives it"
    ):
        fb.simulate(block("c - k*sign(x)"), 3)
    with pytest.raises(SimulationError, match=r"it sticks at t = 1(\.0*1)? s, where x' = 0"):
        fb.simulate(block("4*c*max(t - 1, 0) - c*sign(x')"), 3)


def test_bounces_that_lose_speed_end_the_run():
    """From a speed v at x = 0 it is back after v/(k + F) + q v/(k - F) at q v, q² = (k - F)/(k + F): a geometric series
    of times, after that of the fall.
    """
    F = K / 2
    with pytest.raises(SimulationError, match=r"it sticks at t = 0\.63094010\d* s") as caught:
        fb.simulate(block("-k*sign(x) - k/2*sign(x')"), 10, initial={"x": 1})
    q = np.sqrt((K - F) / (K + F))
    v = np.sqrt(2 * (K - F))
    exact = v / (K - F) + v * (1 / (K + F) + q / (K - F)) / (1 - q)
    assert caught.value.trajectory.path.end == pytest.approx(exact, rel=1e-9)
    assert "s.friction(" in str(caught.value)


def test_a_run_that_ends_where_it_would_stick_is_complete():
    assert fb.simulate(block("-c*sign(x')"), 2, initial={"x'": 2}).status == "finished"


def test_bends_are_left_as_they_are_where_their_e_is_round_off(monkeypatch):
    """3 x' - y' is zero but for round-off, which two forces |3 x' - y'| see and a third body does not feel."""
    monkeypatch.setattr(sided_run, "IN_A_ROW", 3)
    s = fb.System("plane")
    mid, body = s.body("mid", fb.particle(1)), s.body("body", fb.particle(1))
    s.slider("rx", s.ground, mid, axis="x", coordinate="x")
    s.slider("ry", mid, body, axis="y", coordinate="y")
    s.force("a", mid, ("-2*x - 2*abs(3*x' - y')", 0, 0))
    s.force("b", body, (0, "-y - 3*abs(3*x' - y')", 0))
    motion = fb.simulate(s, 60, initial={"x": 0.1, "y": 0.3}, method="dop853")
    assert motion["x"][-1] == pytest.approx(0.1 * np.cos(60), abs=1e-8)
    assert len(motion.path.segments) < 100


def test_files_and_pickles_keep_the_sides(tmp_path):
    motion = fb.simulate(block("-k*sign(x)"), 2, initial={"x": 1})
    times = np.linspace(0, 2, 41)
    motion.save(tmp_path / "edge.nc")
    for copy in (pickle.loads(pickle.dumps(motion)), fb.Trajectory.load(tmp_path / "edge.nc")):
        assert (copy.path.sample(times) == motion.path.sample(times)).all()


@pytest.mark.parametrize("method", ["auto", "dop853"])
def test_lanes_are_the_runs_alone(method):
    s = block("3*k*sign(x) - 2*k - c*abs(x')*x'")
    speeds = np.linspace(-22, -9, 9)
    data = fb.simulate(s, 0.2, initial={"x": 0.5, "x'": speeds}, outputs=["x"], samples=3, method=method)
    alone = [fb.simulate(s, 0.2, initial={"x": 0.5, "x'": float(v)}, method=method)["x"][-1] for v in speeds]
    assert data.x.values[:, -1] == pytest.approx(alone, abs=1e-8)
    assert (np.array(alone) < 0).any() and (np.array(alone) > 0).any()


def test_legs_of_a_signal():
    """In steps of a signal and between blows: x'' = F - k sign(x), F = 0, then k/2."""
    s = fb.System("block")
    force = fb.signal([0, 1, 3], [0, K / 2, K / 2], "previous", name="F")
    body = s.body("block", fb.particle(1))
    s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.force("push", body, (force, 0, 0))
    s.force("law", body, ("-100*sign(x)", 0, 0))
    motion = fb.simulate(s, 2, initial={"x": 1}, times=[0.5, 1, 2])
    assert motion["x"][:2] == pytest.approx(rocking(np.array([0.5, 1.0])), abs=1e-10)
    assert np.abs(motion.energy.residual).max() < 1e-9


@pytest.mark.slow
def test_the_method_of_structure_switches():
    """A block on a spring k and a stop of 3 k: half turns of ω = √k and of 2 ω, without any change of the energy."""
    s = fb.System("block")
    guide = s.slider("guide", s.ground, s.body("block", fb.particle(1)), axis="x", coordinate="x")
    s.spring("spring", guide, stiffness=K)
    s.stop("wall", guide, low=0, stiffness=3 * K)
    half = np.pi / np.sqrt(K)
    motion = fb.simulate(s, 7.5 * half, initial={"x'": 1}, method="structure", step=0.01)
    t = np.mod(motion.t, 1.5 * half)
    exact = np.where(t < half, np.sin(10 * t) / 10, -np.sin(20 * (t - half)) / 20)
    assert motion["x"] == pytest.approx(exact, abs=1e-9)
    assert np.abs(motion.energy.residual).max() < 1e-14


def blocks(count, law):
    """Blocks on rails of their own, one of them under a law."""
    s = fb.System("blocks")
    for i in range(count):
        body = s.body(f"b{i}", fb.particle(1))
        s.slider(f"guide{i}", s.ground, body, axis="x", coordinate=f"x{i}")
    s.force("law", s.bodies["b0"], (law, 0, 0))
    return s


def test_trees_of_many_links_switch():
    """From 40 bodies on, equations are loops over links; those of laws that switch are not, up to 200."""
    motion = fb.simulate(blocks(45, f"-{K}*sign(x0)"), 10, initial={"x0": 1})
    assert motion["x0"] == pytest.approx(rocking(motion.t), abs=1e-9)


def test_very_large_trees_only_bend():
    """x'' = -x'|x'|, x = ln(1 + t), is smooth for x' > 0."""
    motion = fb.simulate(blocks(200, "-x0'*abs(x0')"), 1, initial={"x0'": 1})
    assert motion["x0"][-1] == pytest.approx(np.log(2), abs=1e-8)
    with pytest.raises(SimulationError) as error:
        fb.simulate(blocks(200, "-sign(x0)"), 1, initial={"x0": 1})
    assert str(error.value) == (
        "Expected forces that do not jump in a tree of 200 bodies or more, whose equations are loops over links, but "
        "those of 'blocks', with 200, have a sign(...), whose switches would not be located. Give the jump a width of "
        "your choice, tanh(x/width) for sign(x)."
    )
