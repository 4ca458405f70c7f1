"""The compiled loop: kept as machine code that stands alone, found again, and refused where it does not."""

from __future__ import annotations

import contextlib
import copy
import json
import math
import os
import struct
import subprocess
import sys
import threading
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody.motion.ending import End
from freebody.motion.lanes import loops as over_lanes
from freebody.motion.ode import layout, loops
from freebody.motion.ode.dense_output import Rates, Watch
from freebody.native import cache, codegen
from freebody.native import loop as native
from freebody.program.kernels import compile_tape
from freebody.scalar.trace import Tape
from integrations import integrate

HERE = Path(native.__file__).parent


def make():
    """The loop as a process makes it that has none yet."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(native, "_loops", {})
        return loops.functions()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache."""
    monkeypatch.setenv("FREEBODY_CACHE", str(tmp_path))
    return tmp_path / "kernels"


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """The name of the loop in a cache, its header and its machine code."""
    path = tmp_path_factory.mktemp("compiled")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FREEBODY_CACHE", str(path))
        make()
        (file,) = (path / "kernels").glob("*.o")
        return file.stem, *cache.load(file.stem)


@pytest.fixture
def kept(folder, compiled, monkeypatch):
    """A cache with the loop, which is not compiled once more where it has to be made again; its file."""
    key, header, code = compiled
    monkeypatch.setattr(native, "_compiled", lambda *of: (copy.deepcopy(header), code))
    cache.store(key, copy.deepcopy(header), code)
    (path,) = folder.glob("*.o")
    return path


@pytest.fixture(scope="module")
def oscillator():
    """x'' = -x, and the event x = 0."""
    tape = Tape()
    x, v = tape.input("x"), tape.input("v")
    kernels = compile_tape(tape, {"rates": [v, -x], "events": [x]}, None, [x, v], [])
    c = kernels.constants([])
    return Rates(kernels["rates"].address, 2, c, keep=kernels), Watch(
        kernels["events"].address, (0,), (False,), keep=kernels
    )


def run(made, oscillator, monkeypatch):
    """Times, states and events of a run with this loop, and values between the steps."""
    with monkeypatch.context() as patch:
        patch.setattr(loops, "functions", lambda *method: made)
        patch.setattr(loops, "_loaded", {})
        rates, watch = oscillator
        path = integrate(rates, [1.0, 0.0], 0.0, 20.0, watch=watch, relative=1e-10, absolute=1e-10)
        inside = path.sample(np.linspace(0, 20, 41))
    return path, inside


# --- kept and found again --------------------------------------------------------------------------


def test_second_process_finds_the_code(folder, oscillator, monkeypatch):
    first, second = make(), make()
    assert not first.from_disk
    assert second.from_disk
    assert len(list(folder.glob("*.o"))) == 1
    (a, within_a), (b, within_b) = (run(made, oscillator, monkeypatch) for made in (first, second))
    assert np.array_equal(a.states, b.states)
    assert np.array_equal(within_a, within_b)
    t = np.linspace(0, 20, 41)
    assert within_b == pytest.approx(np.stack([np.cos(t), -np.sin(t)], axis=1), abs=1e-8)
    zeros = [crossing.time for crossing in b.crossings]
    assert zeros == pytest.approx((np.arange(6) + 0.5) * np.pi, abs=1e-8)


def test_looking_for_events_changes_no_state(oscillator):
    rates, watch = oscillator
    options = {"relative": 1e-10, "absolute": 1e-10}
    plain = integrate(rates, [1.0, 0.0], 0.0, 20.0, **options)
    watched = integrate(rates, [1.0, 0.0], 0.0, 20.0, watch=watch, **options)
    assert len(watched.crossings) == 6
    assert np.array_equal(plain.times, watched.times)
    assert np.array_equal(plain.states, watched.states)


def test_nothing_is_kept_without_a_cache(monkeypatch, oscillator):
    monkeypatch.setenv("FREEBODY_CACHE", "off")
    made = make()
    assert not made.from_disk
    assert run(made, oscillator, monkeypatch)[0].status == End.FINISHED


def damage_header(change):
    def damage(path):
        key = path.stem
        header, code = cache.load(key)
        change(header)
        cache.store(key, header, code)

    return damage


def cut(path):
    path.write_bytes(path.read_bytes()[:-100])


def foreign(path):
    """The kernel of a model in the place of the loop."""
    tape = Tape()
    x = tape.input("x")
    compile_tape(tape, {"f": [x]}, None, [x], [])
    (other,) = (file for file in path.parent.glob("*.o") if file != path)
    other.rename(path)


@pytest.mark.parametrize(
    "damage",
    [
        cut,
        foreign,
        damage_header(lambda header: header.clear()),
        damage_header(lambda header: header["functions"].pop("sample")),
        damage_header(lambda header: header["needed"].append("no_such_function_of_C")),
        damage_header(lambda header: header["functions"].update(sample=["no_such_symbol", [], "None"])),
    ],
)
def test_damaged_or_foreign_code_is_made_again(kept, damage, oscillator, monkeypatch):
    assert make().from_disk
    damage(kept)
    again = make()
    assert not again.from_disk
    assert run(again, oscillator, monkeypatch)[0].status == End.FINISHED
    assert make().from_disk


def test_key_follows_what_compiles_it(monkeypatch):
    keys = []
    nothing = native.Loop({"lanes": None}, None, False)
    monkeypatch.setattr(native, "_made", lambda key, *rest: keys.append(key) or nothing)
    monkeypatch.setattr(loops, "_loaded", {})
    monkeypatch.setattr(native, "_loops", {})
    for method in layout.ORDERS:
        loops.functions(method)
        over_lanes.function(method, 1)
    assert len(set(keys)) == len(keys) == 2 * len(layout.ORDERS)
    monkeypatch.setattr(codegen, "version", lambda: "another processor")
    monkeypatch.setattr(native, "_loops", {})
    loops.functions()
    assert len(set(keys)) == len(keys)


def test_threads_share_one_loop(monkeypatch):
    count = []
    inner = native._made
    monkeypatch.setattr(native, "_made", lambda *of: count.append(1) or inner(*of))
    monkeypatch.setattr(loops, "_loaded", {})
    monkeypatch.setattr(native, "_loops", {})
    found = []
    threads = [threading.Thread(target=lambda: found.append(loops.functions())) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert count == [1]
    assert len(found) == 4
    assert all(one is found[0] for one in found)


def test_loops_made_together_are_those_made_alone(folder, monkeypatch):
    """One is compiled while the next is translated, and both are kept under one secret."""
    monkeypatch.setattr(native, "_loops", {})
    modules = ("motion.ode.crossing", "motion.start.gauss_newton")
    names = ("approached", "close")
    native.make_together(
        [partial(native.code, module, name) for module, name in zip(modules, names, strict=True)]
    )
    together = dict(native._loops)
    assert set(together) == {f"{module} {name}" for module, name in zip(modules, names, strict=True)}
    assert not any(one.from_disk for one in together.values())
    kept = {file.name: file.read_bytes() for file in (folder).glob("*.o")}
    assert len(kept) == 2
    native._loops.clear()
    assert (
        native.code(modules[0], names[0]).arguments
        == together[f"{modules[0]} {names[0]}"].functions[names[0]].arguments
    )
    assert all(one.from_disk for one in native._loops.values())


def test_what_cannot_be_made_together_is_refused_where_it_is_needed():
    def refuses():
        raise TypeError("no loop")

    native.make_together([refuses])
    with pytest.raises(TypeError, match="no loop"):
        refuses()


# --- standing alone --------------------------------------------------------------------------------


def undefined(code):
    """Names that an object file in the ELF format of 64 bits leaves open."""
    start, size, count = (
        struct.unpack_from(f, code, at)[0] for f, at in (("<Q", 0x28), ("<H", 0x3A), ("<H", 0x3C))
    )
    sections = [struct.unpack_from("<IIQQQQIIQQ", code, start + k * size) for k in range(count)]
    (table,) = (section for section in sections if section[1] == 2)
    names = sections[table[6]]
    found = set()
    for at in range(table[4], table[4] + table[5], 24):
        name, info, _, section = struct.unpack_from("<IBBH", code, at)
        if section == 0 and info >> 4 != 0:
            begin = names[4] + name
            found.add(code[begin : code.index(b"\0", begin)].decode())
    return found


def test_code_needs_nothing_but_the_libraries_of_c(compiled):
    _, header, code = compiled
    assert header["needed"] == ["pow"]
    assert set(codegen.LIBRARY).issuperset(header["needed"])
    if not code.startswith(b"\x7fELF\x02"):
        pytest.skip("another format of object files")
    assert undefined(code) - {"_GLOBAL_OFFSET_TABLE_"} == {"pow"}  # the loader makes that table


def test_library_of_c_without_what_a_loop_calls_is_told(monkeypatch, kept):
    """LLVM would end the process."""
    kept.unlink()
    monkeypatch.setattr(native.llvm, "address_of_symbol", lambda name: None)
    with pytest.raises(RuntimeError, match=r"Expected pow in this process's C library, .* not all of them"):
        make()
    assert not kept.exists()


def test_calls_that_would_read_wrong_memory_are_refused(oscillator):
    rates, _ = oscillator
    state = np.zeros((1, 2))
    for times in (np.zeros(1, dtype=np.float32), np.zeros(4)[::2]):
        with pytest.raises(
            TypeError, match=r"Expected a contiguous array of float64 .* got float.* of shape"
        ):
            loops.observe(rates.address, 1, times, state, 2, rates.constants, np.zeros(2), 2)


def test_compiled_function_is_not_for_python():
    from freebody.motion.ode.dop853 import FUNCTIONS

    with pytest.raises(TypeError, match="Expected compiled code to call 'observe', got a call from Python"):
        FUNCTIONS["observe"]()


# --- a fresh process -------------------------------------------------------------------------------

MODEL = """
import json, sys
import freebody as fb
s = fb.System("pendulum")
m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
s.gravity = (0, -g, 0)
bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), axis="z", coordinate="theta")
motion = fb.simulate(s, 2, initial={"theta": 1}, events=["theta'"])
value, events = motion["theta"][-1], len(motion.events)
from freebody.motion.ode.loops import functions
heavy = ("scipy", "xarray", "pandas", "matplotlib", "rich", "flint", "trimesh", "click")
print(json.dumps([value, events, functions().from_disk, [name for name in heavy if name in sys.modules]]))
"""


def test_run_loads_no_compiler_and_no_product_that_was_not_asked_for():
    motion = fb.System("warm")  # this process has put the loop on the disk
    body = motion.body("body", fb.particle(1))
    motion.slider("guide", motion.ground, body, axis="x", coordinate="x")
    fb.simulate(motion, 1, events=["x'"])
    environment = {**os.environ, "PYTHONPATH": str(HERE.parents[1])}
    done = subprocess.run(
        [sys.executable, "-c", MODEL],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    value, events, from_disk, loaded = json.loads(done.stdout)
    angle, _ = fb.exact.pendulum(1, math.sqrt(1.5 * 9.81 / 2), 2)
    assert value == pytest.approx(angle, abs=1e-8)  # ten steps at a tolerance of 1e-9
    assert events >= 1
    assert from_disk
    assert [name for name in loaded if name != "flint"] == []  # SymPy computes with flint where it finds it


def test_a_method_is_loaded_ahead_and_its_thread_ends(monkeypatch):
    asked = []
    monkeypatch.setattr(loops, "_loaded", {})
    monkeypatch.setattr(loops, "functions", lambda method, part: asked.append((method, part)) or {}[method])
    before = threading.active_count()
    with loops.ahead("dop853", True):  # what goes wrong there, the run says when it loads the method
        pass
    with contextlib.suppress(ZeroDivisionError), loops.ahead("gauss", False):
        raise ZeroDivisionError
    monkeypatch.setattr(loops, "_loaded", {"dop853": object()})
    with loops.ahead("dop853", True):
        assert threading.active_count() == before
    assert asked == [("dop853", ""), ("gauss", "steps")] and threading.active_count() == before
