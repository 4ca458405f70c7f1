"""The module in a WebAssembly runtime: the same motion as here, to round-off; recovery; its memory and interface."""

from __future__ import annotations

import json

import numpy as np
import pytest

import freebody as fb
from contact_machines import ball_on_plane
from freebody.errors import FormatError
from freebody.motion.ending import End
from freebody.motion.live.export import setting_of
from freebody.motion.live.machine import LiveMachine
from freebody.motion.live.module import module_of
from freebody.motion.start.closing_record import FAR, MET
from live_machines import Here, InWasm, double_pendulum, motion_of

pytest.importorskip("wasmtime", reason="wasmtime, a WebAssembly runtime, is not installed")


def in_wasm(motion: fb.Trajectory) -> InWasm:
    machine = LiveMachine(
        setting_of(motion, 20_000, 401), lambda state, moving, forces: [*state.q], lambda state: ()
    )
    wasm = InWasm(module_of(machine))
    wasm.evenly[...], wasm.dense[...], wasm.most_frames[...] = 1, 0, 101
    return wasm


def moved_by_an_ulp(live: Here, states: np.ndarray) -> np.ndarray:
    """Difference of the motion from one in which the first coordinate that is named starts an ulp further."""
    i = min(live.machine.named)
    live.given[i], live.initial[i] = 1, np.nextafter(states[0, i], np.inf)
    return np.abs(live() - states)


@pytest.mark.parametrize("name", ["double pendulum", "gyroscope", "four-bar"])
def test_it_is_the_motion_of_this_computer_to_round_off(name):
    """Products and sums are rounded once here, and twice in the module: in each step some roundings of an ulp, which
    the motion amplifies at most as it does those of the start. The first second is within a few hundred ulps."""
    motion = motion_of(name)
    live, wasm = Here(motion), in_wasm(motion)
    here, there = live(), wasm()
    assert (int(wasm.status), int(wasm.closed), int(wasm.fault)) == (End.FINISHED, MET, -1)
    error = np.abs(there - here)
    assert (error / (1 + np.abs(here)))[:21].max() < 1e-12
    assert error.max() < np.sqrt(live.steps) * moved_by_an_ulp(live, here).max()
    events = int(wasm.events)
    assert events == live.events and np.allclose(
        wasm.event_times[:events], live.event_times[:events], rtol=0, atol=1e-8
    )


def test_it_recovers_from_what_cannot_be_closed():
    wasm = in_wasm(motion_of("four-bar", until=1.0))
    before = wasm()
    names = wasm.module.parameters
    wasm.parameters[names.index("b")], wasm.parameters[names.index("c")] = 0.5, 0.1
    assert wasm().size == 0 and int(wasm.closed) == FAR and int(wasm.frames) == 0
    wasm.parameters[names.index("b")], wasm.parameters[names.index("c")] = 3.0, 2.0
    assert np.array_equal(wasm(), before)


def test_program_to_wasm():
    s = double_pendulum()
    module = fb.compile(s).to_wasm(
        2, initial={"q1": "theta_0"}, outputs=["sin(q1)", "m*L^2*q2'"], events=["q2"], values={"L": 0.8}
    )
    wasm = InWasm(module)
    assert module.parameters == ("m", "L", "g", "theta_0") and wasm.parameters.tolist() == [1, 0.8, 9.81, 1]
    assert module.state == ("q1", "q2", "q1'", "q2'") and module.events == ("q2",)
    assert module.outputs == ("sin(q1)", "m*L^2*q2'") and set(module.assumed) >= {"m", "L"}
    wasm.dense[...] = 0
    states, frames = wasm(), int(wasm.frames)
    motion = fb.simulate(s, 2, initial={"q1": "theta_0"}, values={"L": 0.8}, events=["q2"], method="dop853")
    assert int(wasm.steps) == motion.steps and float(wasm.reached) == 2
    assert np.abs(states - motion.path.sample(np.minimum(wasm.times[:frames], 2))).max() < 1e-9
    assert np.abs(wasm.outputs[:frames, 0] - np.sin(states[:, 0])).max() < 1e-15
    assert np.abs(wasm.event_times[: int(wasm.events)] - [event.time for event in motion.events]).max() < 1e-9
    wasm.until[...] = 0.5
    wasm.tolerances[:] = 1e-5
    wasm()
    assert float(wasm.reached) == 0.5 and int(wasm.steps) < motion.steps / 4


@pytest.mark.parametrize(
    ("machine", "start"),
    [(double_pendulum, {"q1": 1.0}), (ball_on_plane, {"flight_z": 0.3, "flight_vx": 5.0})],
)
def test_no_outputs_are_needed(machine, start):
    s = machine()
    wasm = InWasm(fb.compile(s).to_wasm(0.6, initial=start))
    states = wasm()
    motion = fb.simulate(s, 0.6, initial=start, method="dop853", tolerance=1e-10)
    assert float(wasm.reached) == 0.6 and wasm.module.outputs == ()
    n = len(motion.names)
    assert np.abs(states[-1, :n] - motion.path.sample(np.array([0.6]))[0, :n]).max() < 1e-6


def test_its_interface_is_written_beside_it(tmp_path):
    module = fb.compile(double_pendulum()).to_wasm(2, initial={"q1": 1})
    file = module.write(tmp_path / "pendulum.wasm")
    assert file.read_bytes() == module.code and module.code.startswith(b"\0asm\1\0\0\0")
    told = json.loads((tmp_path / "pendulum.json").read_text(encoding="utf-8"))
    assert told["address"] == module.address and told["fields"]["states"] == [
        *module.fields["states"][:2],
        [2001, 4],
    ]
    assert repr(module).startswith("<WasmModule: ") and "parameters m, L, g, theta_0" in repr(module)
    with pytest.raises(FormatError, match=r"Expected a file name that ends in \.wasm, got 'pendulum\.bin'\."):
        module.write(tmp_path / "pendulum.bin")


def test_the_code_is_kept_on_the_disk(monkeypatch):
    import freebody.motion.live.module as live_module

    motion = motion_of("gyroscope", until=0.1)
    first = in_wasm(motion).module.code
    monkeypatch.setattr(live_module, "wasm_object", None)
    assert in_wasm(motion).module.code == first
