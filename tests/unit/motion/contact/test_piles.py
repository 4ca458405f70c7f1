"""Piles in which every pair of bodies may touch: set-up in proportion to the pairs, progress on the way."""

from __future__ import annotations

import importlib
import time

import numpy as np
import pytest

import freebody as fb


def pile(n):
    """n spheres over a floor, in layers of a lattice that leaves 1 cm between them, and where they start."""
    s = fb.System("pile")
    s.gravity = (0, 0, -9.81)
    floor, start = s.ground.plane(normal="z"), {}
    spheres = []
    for i in range(n):
        body = s.body(f"b{i}", fb.sphere(1, 0.1))
        s.free(f"f{i}", s.ground, body)
        spheres.append(body.sphere(0.1))
        s.contact(f"c{i}", spheres[i], floor, friction=0.3)
        for j in range(i):
            s.contact(f"c{i}_{j}", spheres[i], spheres[j], friction=0.3)
        start |= {
            f"f{i}_x": (i % 5) * 0.21,
            f"f{i}_y": (i // 5 % 5) * 0.21,
            f"f{i}_z": 0.1 + (i // 25) * 0.21,
        }
    return s, start


def test_a_pile_of_20_with_all_pairs():
    s, start = pile(20)
    motion = fb.simulate(s, 0.05, initial=start | {"f0_vx": 1.0}, method="timestepping", step=1e-3)
    assert motion.status == "finished"
    assert motion.depth < 1e-10
    assert motion["f1_vx"][-1] > 0.1  # was hit


def test_long_modules_are_compiled_to_plain_instructions(monkeypatch, tmp_path):
    s, start = pile(4)
    arguments = {"initial": start | {"f0_vx": 1.0}, "method": "timestepping", "step": 1e-3}
    usual = fb.simulate(s, 0.05, **arguments)
    native = importlib.import_module("freebody.native.codegen")
    levels, machine = [], native._machine
    monkeypatch.setattr(
        native, "_machine", lambda *level, **target: levels.append(level) or machine(*level, **target)
    )
    monkeypatch.setattr(native, "LONG", 0)
    monkeypatch.setenv("FREEBODY_CACHE", str(tmp_path / "cache"))
    plain = fb.simulate(pile(4)[0], 0.05, **arguments)
    assert (0, "this machine") in levels
    assert np.abs(plain.states - usual.states).max() < 1e-12


def test_a_long_run_in_short_pieces_says_how_far_it_is():
    s, start = pile(20)
    shown = []
    fb.simulate(
        s, 3, initial=start, method="timestepping", step=5e-4, progress=lambda part: shown.append(part)
    )
    assert len(shown) >= 4 and shown == sorted(shown) and shown[-1] == 1


@pytest.mark.slow
def test_a_pile_of_100_with_all_5050_pairs():
    s, start = pile(100)
    began = time.perf_counter()
    motion = fb.simulate(s, 0.02, initial=start, method="timestepping", step=1e-3)
    assert motion.status == "finished"
    assert motion.depth < 1e-10
    assert time.perf_counter() - began < 90  # 21 s beside nothing else
