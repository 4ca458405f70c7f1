"""Machines of live motions, and a live motion on this computer or in a WebAssembly runtime."""

from __future__ import annotations

import ctypes
import math
from typing import Any

import numpy as np

import freebody as fb
from freebody.motion.cones.collision import compiled_code
from freebody.motion.live.export import setting_of
from freebody.motion.live.machine import LiveMachine
from freebody.motion.live.memory import Live
from freebody.motion.live.module import CALLED
from freebody.motion.ode import loops
from freebody.motion.phase.phase import functions
from freebody.native import loop
from freebody.program.export.wasm import WasmModule
from freebody.program.kernels import compile_tape


def double_pendulum() -> fb.System:
    s = fb.System("double pendulum")
    m, length, g, theta_0 = s.parameters(m=1.0, L=1.0, g=9.81, theta_0=1.0)
    s.assume(m > 0)
    s.gravity = (0, -g, 0)
    a, b = (s.body(name, fb.slender_bar(m, length, axis="y")) for name in "ab")
    s.hinge("upper", s.ground, a, to=(0, length / 2, 0), axis="z", coordinate="q1")
    s.hinge("lower", a, b, at=(0, -length / 2, 0), to=(0, length / 2, 0), axis="z", coordinate="q2")
    return s


def gyroscope() -> fb.System:
    s = fb.System("gyroscope")
    m, R, length, g, spin = s.parameters(m=1.2, R=0.06, L=0.1, g=9.81, Omega=300.0)
    s.gravity = (0, 0, -g)
    rotor = s.body("rotor", fb.disk(m, R, axis="z"))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -length), axis="ZXZ", coordinate="psi theta phi")
    return s


def four_bar() -> fb.System:
    """A crank a, a coupler b and a rocker c on two pins with the distance d."""
    s = fb.System("four-bar")
    a, b, c, d, g = s.parameters(a=1.0, b=3.0, c=2.0, d=3.0, g=9.81)
    s.gravity = (0, -g, 0)
    crank, coupler, rocker = (s.body(str(x), fb.slender_bar(1, x, axis="x")) for x in (a, b, c))
    s.hinge("A", s.ground, crank, to=(-a / 2, 0, 0), axis="z", coordinate="q1")
    s.hinge("B", crank, coupler, at=(a / 2, 0, 0), to=(-b / 2, 0, 0), axis="z", coordinate="q2")
    s.hinge("D", s.ground, rocker, at=(d, 0, 0), to=(-c / 2, 0, 0), axis="z", coordinate="q3")
    s.hinge("C", coupler, rocker, at=(b / 2, 0, 0), to=(c / 2, 0, 0), axis="z")
    return s


def motion_of(name: str, until: float = 5.0, **more: Any) -> fb.Trajectory:
    """A motion of one of the machines by steps of "dop853"."""
    machine, options = {
        "double pendulum": (double_pendulum, {"initial": {"q1": "theta_0", "q2": 0.5}, "events": ["q1'"]}),
        "gyroscope": (gyroscope, {"initial": {"theta": 1.0, "phi'": "Omega"}}),
        "four-bar": (four_bar, {"initial": {"q1": 1.0, "q1'": 2.0}, "near": {"q2": -0.7, "q3": 1.2}}),
    }[name]
    return fb.simulate(machine(), until, method="dop853", tolerance=1e-10, **{**options, **more})  # type: ignore[arg-type]


class Here:
    """A live motion on this computer; attributes are the fields of its memory."""

    def __init__(self, motion: fb.Trajectory, most_steps: int = 20_000) -> None:
        machine = LiveMachine(
            setting_of(motion, most_steps, 401),
            lambda state, moving, forces: [*state.q],
            lambda state: [parameter * 2 for parameter in state.values.values()],
        )
        kernels = compile_tape(
            machine.tape, machine.functions, machine.state.t, machine.inputs, machine.parameters
        )
        addresses = {name: kernels[name].address for name in machine.functions}
        self.contacts = machine.touching is not None
        if self.contacts:
            addresses |= {name: functions()[name].address for name in CALLED[3:]}
            addresses |= {name: compiled_code()[name].address for name in ("find", "collided")}
            addresses["piece"] = loops.functions().functions["piece"].address
        self.names = list(machine.names)
        self.kernels, self.machine = kernels, machine
        self.memory: Live = machine.memory(
            {"prologue": kernels._prologue.address, **addresses}, kernels.hoisted
        )
        self.memory.evenly, self.memory.dense, self.memory.most_frames = 1, 0, 101

    def __getattr__(self, name: str) -> Any:
        return getattr(self.memory, name)

    def __call__(self, **parameters: float) -> np.ndarray:
        """Compute the motion with these parameters; return the states of its frames."""
        for name, value in parameters.items():
            self.memory.parameters[self.names.index(name)] = value
        loop.code("motion.live.live", "SIMULATE_CONTACTS" if self.contacts else "SIMULATE")(self.memory)
        return self.memory.states[: self.memory.frames].copy()


class InWasm:
    """A module in the runtime wasmtime; attributes are the fields of its memory as arrays."""

    def __init__(self, module: WasmModule) -> None:
        import wasmtime

        self.module = module
        engine = wasmtime.Engine()
        self.store = wasmtime.Store(engine)
        code, linker, real = (
            wasmtime.Module(engine, module.code),
            wasmtime.Linker(engine),
            wasmtime.ValType.f64(),
        )
        for item in code.imports:
            assert item.module == "env" and item.name in module.imports
            kind = wasmtime.FuncType([real] * len(item.type.params), [real])
            linker.define_func("env", str(item.name), kind, getattr(math, str(item.name)))
        exports = linker.instantiate(self.store, code).exports(self.store)
        self.simulate, memory = exports["simulate"], exports["memory"]
        first = ctypes.cast(memory.data_ptr(self.store), ctypes.POINTER(ctypes.c_uint8))
        self.bytes = np.ctypeslib.as_array(first, (memory.data_len(self.store),))

    def __getattr__(self, name: str) -> np.ndarray:
        place, kind, shape = self.module.fields[name]
        numbers = self.bytes[place : place + 8 * math.prod(shape)]
        return numbers.view(np.float64 if kind == "real" else np.int64).reshape(shape)

    def __call__(self) -> np.ndarray:
        """Compute the motion; return the states of its frames."""
        self.simulate(self.store, self.module.address)
        return self.states[: int(self.frames)].copy()
