"""A live motion with contacts is the motion of `simulate`: modes, phases, states, forces, here and in WebAssembly."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from contact_machines import add_bouncing_ball, ball_on_plane, falling_rod, seesaw
from freebody.motion.ending import End
from freebody.motion.events.limits import STALL
from freebody.motion.live.export import setting_of
from freebody.motion.live.machine import LiveMachine
from freebody.motion.live.memory import DEEP, TOO_MANY_PHASES
from freebody.motion.live.module import module_of
from freebody.motion.phase.phase import NUMBERS
from live_machines import Here, InWasm


def bouncing() -> fb.System:
    """A ball that bounces and slides, thrown with a spin."""
    s = fb.System("bouncing")
    m, R, e, mu, g = s.parameters(m=1.0, R=0.1, e=0.7, mu=0.2, g=9.81)
    s.gravity = (0, -g, 0)
    ball = s.body("ball", fb.sphere(m, R))
    s.planar("plane", s.ground, ball, at=(0, R, 0), coordinate="x y phi")
    s.contact("floor", ball.circle(R), s.ground.plane(), friction=mu, restitution=e)
    return s


def rolling() -> fb.System:
    """A ball in space that lands, slides, rolls, spins and stops."""
    s = fb.System("rolling")
    m, R, delta, g = s.parameters(m=1.0, R=0.1, delta=0.01, g=9.81)
    s.gravity = (0, 0, -g)
    ball = s.body("ball", fb.sphere(m, R))
    s.free("f", s.ground, ball)
    s.contact(
        "floor", ball.sphere(R), s.ground.plane(normal="z"), friction=0.3, rolling=delta, spinning=delta / 2
    )
    return s


def tipping() -> fb.System:
    """A cylinder that stands on its edge, pushed towards a point between its four, until it tips."""
    s = fb.System("tipping")
    s.gravity = (0, 0, -9.81)
    can = s.body("can", fb.cylinder(1, 0.1, 0.3))
    s.free("f", s.ground, can)
    s.contact("rim", can.circle(0.1, at=(0, 0, -0.15)), s.ground.plane(normal="z"), friction=0.9)
    s.force("push", can.origin, (6 * s.t, 3 * s.t, 0))
    return s


K, G = 100.0, 9.81


def under(law: str, beside: bool) -> fb.System:
    """A block of 1 kg under a law and, if it is ``beside``, a ball that bounces without loss."""
    s = fb.System("block")
    s.parameters(k=K, g=G)
    body = s.body("block", fb.particle(1))
    s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.force("law", body, (law, 0, 0))
    if beside:
        add_bouncing_ball(s)
    return s


def rocking(t, k=K):
    """x of x'' = -k sign(x) from rest at 1: parabolas, each of 2 √(2/k), of alternate sides."""
    half = 2 * np.sqrt(2 / k)
    n, rest = np.divmod(t + half / 2, half)
    return (-1) ** n * (1 - k * (rest - half / 2) ** 2 / 2)


def switched(law: str, beside: bool, until: float, **start: float) -> fb.Trajectory:
    return fb.simulate(under(law, beside), until, initial=start | ({"y": 1.0} if beside else {}))


MOTIONS = {
    "tipping": (tipping, 1.02, {"initial": {"f_z": 0.15}}),
    "rolling": (rolling, 2, {"initial": {"f_z": 0.12, "f_vx": 0.5, "f_wx": 3.0, "f_wz": 4.0}}),
    "bouncing": (bouncing, 4, {"initial": {"y": 1.0, "x'": 2.0, "phi'": 30.0}, "events": ["y'"]}),
    "falling rod": (falling_rod, 0.6, {"initial": {"y": np.cos(0.1) / 2, "phi": 0.1}}),
    "seesaw": (seesaw, 0.4, {"initial": {"y": 0.1, "x": 0.1}}),
    "ball on a plane": (ball_on_plane, 1, {"initial": {"flight_z": 0.1, "flight_vx": 1.0, "flight_wz": 3.0}}),
}


NAMES = [pytest.param(name, marks=pytest.mark.slow) if name == "tipping" else name for name in MOTIONS]


def motion_of(name: str, **more) -> fb.Trajectory:
    machine, until, options = MOTIONS[name]
    return fb.simulate(machine(), until, tolerance=1e-10, **{**options, **more})


def phases_of(motion: fb.Trajectory) -> list[tuple[str, ...]]:
    """Modes of the phases that take steps."""
    return [tuple(one.modes) for one in motion.path.segments if one.path.curved and one.path.steps]


@pytest.mark.parametrize("name", NAMES)
def test_it_is_the_motion_of_simulate(name):
    """The same code with the same equations, whose common parts are computed in another order: round-off, amplified."""
    motion = motion_of(name)
    live = Here(motion)
    live.memory.evenly, live.memory.dense, live.memory.most_frames = 0, 0, 401
    states, n = live(), motion.kernels.model.n_q + motion.kernels.model.n_u
    assert live.status == End.FINISHED and live.reached == motion.path.end
    assert live.steps == sum(one.path.steps for one in motion.path.segments if one.path.curved)
    modes, E = phases_of(motion), len(motion.kernels.model.contacts)
    shown = [contact.shown for contact in motion.kernels.model.contacts]
    kinds = {number: kind for kind, number in NUMBERS.items()}
    got = np.array(live.modes[: live.phases * E]).reshape(-1, E)
    assert [tuple(f(kinds[k]) for f, k in zip(shown, row, strict=True)) for row in got.tolist()] == modes
    starts = [one.path.start for one in motion.path.segments if one.path.curved and one.path.steps]
    assert np.allclose(live.phase_times[: live.phases], starts, rtol=0, atol=1e-9)
    for first, last in zip(
        live.phase_frames[: live.phases], [*live.phase_frames[1 : live.phases], live.frames], strict=True
    ):
        times = live.times[first:last]
        assert (np.diff(times) > 0).all()
        inner = times[1:-1].copy()
        if inner.size:
            error = np.abs(states[first + 1 : last - 1, :n] - motion.path.sample(inner)[:, :n])
            assert error.max() < 1e-8 * (1 + np.abs(states[:, :n]).max())
    assert np.allclose(
        live.event_times[: live.events],
        [event.time for event in motion.events if event.name == "y'"],
        atol=1e-9,
    )


def test_a_second_run_is_the_first():
    live = Here(motion_of("bouncing"))
    first = live()
    live(e=0.3)
    assert np.array_equal(live(e=0.7), first)


def test_it_follows_its_parameters():
    live = Here(motion_of("bouncing"))
    states = live(e=0.5, mu=0.4)
    other = motion_of("bouncing", values={"e": 0.5, "mu": 0.4})
    assert live.phases == len(phases_of(other))
    n = other.kernels.model.n_q
    assert np.abs(states[-1, :n] - other.path.sample([4.0])[0, :n]).max() < 1e-9


def test_energy_and_work_are_in_balance():
    motion = motion_of("bouncing")
    live = Here(motion)
    states = live()
    m, g, R = 1.0, 9.81, 0.1
    x, y, phi, vx, vy, w = states[:, :6].T
    energy = m * (vx**2 + vy**2) / 2 + 2 / 5 * m * R**2 * w**2 / 2 + m * g * (y + R)
    assert np.abs(energy - energy[0] - (states[:, 6] - states[0, 6])).max() < 1e-8 * energy[0]


def test_frames_are_thinned_when_there_are_many():
    live = Here(motion_of("bouncing"))
    live.memory.most_frames = 60
    states = live()
    assert live.status == End.FINISHED and 30 < live.frames <= 60 and live.touching.fades > 0
    assert np.isfinite(states).all() and live.times[live.frames - 1] == 4
    live.memory.most_frames = 20  # not two for each phase
    live()
    assert live.status == TOO_MANY_PHASES and live.reached < 4


def test_a_long_vibration_before_time_zero_is_no_stall():
    """Steps that hardly move on are counted from the start of the run, not from t = 0."""
    s = fb.System("vibration")
    ball = s.body("ball", fb.sphere(1, 0.1))
    rail = s.slider("rail", s.ground, ball, axis="y", coordinate="y")
    s.spring("k", rail, stiffness=1e4, rest=1)
    s.contact("floor", ball.sphere(0.1), s.ground.plane(normal="y"))
    live = Here(fb.simulate(s, 1, initial={"y": 1.1}), 100_000)
    live.memory.start, live.memory.until = -150, -1
    live()
    assert live.status == End.FINISHED and live.reached == -1 and live.steps > STALL


def test_a_start_below_the_surface_is_told():
    live = Here(motion_of("bouncing"))
    live.given[1], live.initial[1] = 1, -0.5
    live()
    assert live.status == DEEP and live.blame == 0 and live.frames == 0
    live.given[1] = 0
    live()
    assert live.status == End.FINISHED


@pytest.mark.parametrize("name", ["bouncing", "falling rod"])
def test_it_is_the_same_in_wasm(name):
    pytest.importorskip("wasmtime", reason="wasmtime, a WebAssembly runtime, is not installed")
    motion = motion_of(name)
    machine = LiveMachine(
        setting_of(motion, 20_000, 401), lambda state, moving, forces: [*state.q, *forces], lambda state: ()
    )
    wasm, live = InWasm(module_of(machine)), Here(motion)
    wasm.most_frames[...] = live.memory.most_frames = 401
    live.memory.evenly, live.memory.dense = 0, 1
    there, here = wasm(), live()
    assert int(wasm.status) == End.FINISHED and int(wasm.phases) == live.phases
    assert np.allclose(wasm.phase_times[: live.phases], live.phase_times[: live.phases], rtol=0, atol=1e-9)
    assert np.abs(there[-1, :6] - here[-1, :6]).max() < 1e-8
    forces = wasm.outputs[: int(wasm.frames), motion.kernels.model.n_q :]
    assert np.isfinite(forces).all() and np.abs(forces).max() > 0
    assert wasm.module.contacts == tuple(c.name for c in motion.kernels.model.contacts)


# --- laws that switch ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dense", [0, 1])
@pytest.mark.parametrize("beside", [True, False])
def test_laws_switch_where_they_do(beside, dense):
    """V = k |x|: steps are exact, so that only places of switches round; also with another k, and the first again."""
    live = Here(switched("-k*sign(x)", beside, 3, x=1))
    live.memory.evenly, live.memory.dense, live.memory.most_frames = 0, dense, 401
    for k in (K, K / 2, K):
        x = live(k=k)[:, 0]
        assert live.status == End.FINISHED and live.rejected == 0
        assert x == pytest.approx(rocking(live.times[: live.frames], k), abs=1e-11)


@pytest.mark.parametrize("beside", [True, False])
def test_a_dip_within_one_step_is_found(beside):
    """Under a force k it comes down to x = -1e-4 and is below zero for 0.003 s, where the force is -5 k."""
    v = np.sqrt(2 * K * 0.5 + 1e-2)
    down = np.sqrt(v * v - K)
    s = 0.3 - (v - down) / K
    live = Here(switched("3*k*sign(x) - 2*k", beside, 0.3, x=0.5, **{"x'": -v}))
    assert live()[-1, 0] == pytest.approx(-down * s - 5 * K * s * s / 2, abs=1e-8)


def test_a_narrow_strip_of_friction_is_found():
    """μ = 0.6 between x = 1 and x = 1.002, else none: v² falls by 2 μ g w."""
    s = fb.System("block")
    s.gravity = (0, -G, 0)
    body = s.body("block", fb.particle(1))
    s.chain("plane", s.ground, body, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    law = "3/10 - 3/10*sign((x - 1)*(x - 1 - 2/1000))"
    s.contact("floor", body.origin, s.ground.plane(normal="y"), friction=law)
    live = Here(fb.simulate(s, 1, initial={"x'": 4.0}))
    assert live()[-1, 2] == pytest.approx(np.sqrt(16 - 2 * 0.6 * G * 2e-3), abs=1e-12)


def test_a_law_that_drives_back_from_either_side_is_told():
    live = Here(switched("-k*sign(x')", False, 0.005, **{"x'": 1.0}))
    live.memory.until = 1.0
    assert live()[-1, 0] == pytest.approx(1 / (2 * K), abs=1e-12)
    assert live.status == End.STUCK and live.reached == pytest.approx(1 / K, abs=1e-12)
    assert live.machine.sides.texts[live.blame] == "x'"


@pytest.mark.slow
def test_laws_switch_in_wasm():
    pytest.importorskip("wasmtime", reason="wasmtime, a WebAssembly runtime, is not installed")
    motion = switched("-k*sign(x)", True, 3, x=1)
    machine = LiveMachine(
        setting_of(motion, 20_000, 401), lambda state, moving, forces: [*state.q], lambda state: ()
    )
    wasm = InWasm(module_of(machine))
    wasm.evenly[...] = 0
    states, n = wasm(), int(wasm.frames)
    assert states[:, 0] == pytest.approx(rocking(wasm.times[:n]), abs=1e-11)
    assert wasm.outputs[:n, 0] == pytest.approx(states[:, 0], abs=0)
