"""Linkages that pass positions in which their conditions depend on each other."""

from __future__ import annotations

import inspect
import subprocess
import sys

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import freebody as fb
from freebody.dynamics import float_state
from freebody.dynamics.conditions.constrained import independent_rows
from freebody.motion.legs.branch import LIMIT
from freebody.motion.start import loop_closure
from freebody.motion.start.loop_closure import nearly_dependent

G = 9.81


def row(n):
    """``n`` parallelograms of rods of 1 m and 1 kg; every joint a hinge."""
    s = fb.System(f"{n} parallelograms")
    s.gravity = (0, -G, 0)

    def rod(name):
        return s.body(name, fb.slender_bar(1, 1, axis="x"))

    crank = rod("crank0")
    s.hinge("A0", s.ground, crank, to=(-0.5, 0, 0), axis="z", coordinate="phi0")
    for i in range(1, n + 1):
        coupler, following = rod(f"coupler{i}"), rod(f"crank{i}")
        s.hinge(f"B{i}", crank, coupler, at=(0.5, 0, 0), to=(-0.5, 0, 0), axis="z", coordinate=f"beta{i}")
        s.hinge(f"A{i}", s.ground, following, at=(i, 0, 0), to=(-0.5, 0, 0), axis="z", coordinate=f"phi{i}")
        s.hinge(f"C{i}", coupler, following, at=(0.5, 0, 0), to=(0.5, 0, 0), axis="z")
        crank = following
    return s


def upright(n):
    start = {"phi0": np.pi / 2, "phi0'": -1.0}
    for i in range(1, n + 1):
        start |= {f"phi{i}": np.pi / 2, f"beta{i}": -np.pi / 2, f"phi{i}'": -1.0, f"beta{i}'": 1.0}
    return start


def angle(n, t):
    """½ ((n+1)/3 + n) φ'² + ((n+1)/2 + n) g sin φ is constant: a pendulum that turns over."""
    rate2 = ((n + 1) / 2 + n) * G / ((n + 1) / 3 + n)
    lowest2 = 1.0 + 4 * rate2
    m = 4 * rate2 / lowest2
    return np.pi / 2 - (2 * ellipj(0.5 * np.sqrt(lowest2) * t + ellipk(m), m)[3] - np.pi)


def linkage(a, b, c, d):
    """Crank a, coupler b, rocker c, ground d."""
    s = fb.System("four-bar")
    s.gravity = (0, -G, 0)
    crank, coupler, rocker = (
        s.body(name, fb.slender_bar(1, length, axis="x"))
        for name, length in (("crank", a), ("coupler", b), ("rocker", c))
    )
    s.hinge("A", s.ground, crank, to=(-a / 2, 0, 0), axis="z", coordinate="phi")
    s.hinge("B", crank, coupler, at=(a / 2, 0, 0), to=(-b / 2, 0, 0), axis="z", coordinate="beta")
    s.hinge("D", s.ground, rocker, at=(d, 0, 0), to=(-c / 2, 0, 0), axis="z", coordinate="psi")
    s.hinge("C", coupler, rocker, at=(b / 2, 0, 0), to=(c / 2, 0, 0), axis="z")
    return s


@pytest.mark.parametrize("method", ["auto", "dop853", "dop54", "radau", "gauss", "taylor"])
@pytest.mark.parametrize("n", [1, 2])
def test_a_row_of_parallelograms_keeps_its_branch(n, method):
    machine, start = row(n), upright(n)
    # errors of a run are those of its steps: orders 8 and above give the tolerance some digits more
    for tolerance, error in ((1e-9, 1e-6), (1e-10, 2e-7), (1e-11, 3e-8), (1e-12, 5e-9)):
        motion = fb.simulate(machine, 10, initial=start, tolerance=tolerance, method=method, samples=101)
        exact = angle(n, motion.t)
        assert motion.status == "finished"
        assert np.abs(motion["phi0"] - exact).max() < error
        assert np.abs(motion["phi0"] - motion[f"phi{n}"]).max() < 1e-7
        assert np.abs(motion["phi0'"] + motion[f"beta{n}'"]).max() < 1e-5


@pytest.mark.parametrize("n", [1, 2])
def test_the_default_is_as_exact_as_that_of_one_angle(n):
    alone = fb.System("pendulum")
    alone.gravity = (0, -G * ((n + 1) / 2 + n) / ((n + 1) / 3 + n) * 2 / 3, 0)
    bar = alone.body("bar", fb.slender_bar(1, 1, axis="x"))
    alone.hinge("A", alone.ground, bar, to=(-0.5, 0, 0), axis="z", coordinate="phi0")
    motion = fb.simulate(row(n), 10, initial=upright(n), samples=101)
    one = fb.simulate(alone, 10, initial={"phi0": np.pi / 2, "phi0'": -1.0}, samples=101)
    errors = [np.abs(m["phi0"] - angle(n, m.t)).max() for m in (motion, one)]
    assert errors[0] < 10 * errors[1] and errors[0] < 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13])
def test_forty_parallelograms(tolerance):
    motion = fb.simulate(row(40), 10, initial=upright(40), tolerance=tolerance, samples=101)
    assert np.abs(motion["phi0"] - angle(40, motion.t)).max() < 100 * tolerance + 1e-11


def test_passing_is_told_with_its_conditions():
    motion = fb.simulate(row(1), 1.0, initial=upright(1))
    (event,) = motion.events
    level = motion.at(event.time)
    assert abs(np.sin(level["phi0"])) < 1e-3
    assert "'C1_x' becomes dependent" in str(event) and "keeps to its branch" in str(event)


@pytest.mark.parametrize(
    ("lengths", "start", "near"),
    [
        ((1, 2, 1, 2), {"phi": np.pi / 2, "phi'": -5.0}, {"psi": -np.pi / 2, "beta": -1.0}),  # crossed
        ((1, 1, 2, 2), {"phi": np.pi / 2, "phi'": -7.0}, {"psi": 2.0, "beta": 0.3}),  # a kite
    ],
)
def test_branches_that_are_bent(lengths, start, near):
    """The rocker turns where it did not before; energy is kept, and methods and tolerances agree."""
    machine, ends = linkage(*lengths), []
    for method, tolerance in (("auto", 1e-10), ("dop853", 1e-12), ("gauss", 1e-12)):
        motion = fb.simulate(machine, 5, initial=start, near=near, tolerance=tolerance, method=method)
        assert len(motion.events) > 3
        assert np.abs(motion.energy.residual).max() < 1e-6
        ends.append([motion[name][-1] for name in ("phi", "beta", "psi")])
    assert np.ptp(ends, axis=0).max() < 1e-6


@pytest.mark.parametrize("off", [1e-5, 1e-4, 1e-2])
def test_a_linkage_that_only_comes_near_turns(off):
    """With a coupler too long by a little there is one motion, with a sharp turn: nothing is passed."""
    s = linkage(1, 1 + off, 1, 1)
    start, near = {"phi": np.pi / 2, "phi'": -1.0}, {"psi": np.pi / 2, "beta": -np.pi / 2}
    motion = fb.simulate(s, 2, initial=start, near=near, tolerance=1e-10)
    fine = fb.simulate(s, 2, initial=start, near=near, tolerance=1e-13, method="dop853")
    assert not motion.events
    assert abs(motion["psi"][-1] - motion["phi"][-1]) > 0.1
    assert abs(motion["psi"][-1] - fine["psi"][-1]) < 1e-5
    assert np.abs(motion.energy.residual).max() < 1e-6


def test_runs_may_end_and_events_happen_beside_it():
    machine, start = row(1), upright(1)
    level = next(iter(fb.simulate(machine, 1.0, initial=start).events)).time
    for until in (level - 0.01, level, level + 0.01):
        motion = fb.simulate(machine, until, initial=start, tolerance=1e-10)
        assert motion.t[-1] == until
        assert abs(motion["phi0"][-1] - angle(1, until)) < 1e-8
    stop = fb.event("phi0", "level", terminal=True)
    motion = fb.simulate(machine, 2.0, initial=start, events=[stop], tolerance=1e-10)
    assert abs(angle(1, motion.t[-1])) < 1e-8


METHODS = ["auto", "dop853", "dop54", "radau", "gauss", "taylor"]


@pytest.mark.parametrize("n", [1, 2])
@pytest.mark.parametrize("method", ["auto", "dop853", "gauss", "taylor"])
def test_the_default_tolerance_gives_eight_digits_for_ten_seconds(n, method):
    motion = fb.simulate(row(n), 10, initial=upright(n), method=method, samples=1001)
    assert np.abs(motion["phi0"] - angle(n, motion.t)).max() < 1e-8


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-11, 1e-12])
def test_backwards_through_positions_in_line(method, tolerance):
    """Back from 5 s, with the speed that the energy gives; a step of order 5 errs by more of the tolerance."""
    machine, there = row(1), float(angle(1, 5.0))
    rate = -np.sqrt(1 + 2 * 2 * G / (5 / 3) * (1 - np.sin(there)))
    start = {"phi0": there, "phi1": there, "beta1": -there, "phi0'": rate, "phi1'": rate, "beta1'": -rate}
    back = fb.simulate(machine, 0.0, start=5.0, initial=start, method=method, tolerance=tolerance, samples=51)
    assert back.status == "finished" and len(back.events) == 5
    times = [event.time for event in back.events]
    assert times == sorted(times, reverse=True)
    assert np.abs(back["phi0"] - angle(1, back.t)).max() < 300 * tolerance + 1e-10
    assert abs(back.at(2.5)["phi0"] - angle(1, 2.5)) < 300 * tolerance + 1e-10


@pytest.mark.parametrize(
    ("method", "tolerance"), [("auto", 1e-9), ("auto", 1e-6), ("dop853", 1e-9), ("radau", 1e-9)]
)
def test_lanes_pass_positions_in_line(method, tolerance):
    rates = np.array([1.0, 1.2, 0.8])
    lanes = {k: v * rates if k.endswith("'") else v for k, v in upright(2).items()}
    found = fb.simulate(row(2), 5.0, initial=lanes, method=method, tolerance=tolerance, samples=11)
    assert (found["status"] == "finished").all()
    assert (
        abs(found["phi0"].values.reshape(3, -1)[0, -1] - angle(2, 5.0)) < 1e3 * tolerance
    )  # of the run, not of a step


@pytest.mark.parametrize("method", ["dop853", "radau", "gauss"])
def test_lanes_whose_step_collapses_go_across_alone(method):
    rates = np.array([1.0, 1.2, 0.8])
    lanes = {k: v * rates if k.endswith("'") else v for k, v in upright(1).items()}
    found = fb.simulate(row(1), 5.0, initial=lanes, method=method, tolerance=1e-12, samples=11)
    assert (found["status"] == "finished").all()
    for lane, rate in enumerate(rates):
        start = {k: v * rate if k.endswith("'") else v for k, v in upright(1).items()}
        alone = fb.simulate(row(1), 5.0, initial=start, method=method, tolerance=1e-12, samples=11)
        assert np.abs(found["phi0"].values.reshape(3, -1)[lane] - alone["phi0"]).max() < 1e-11


def test_the_name_told_is_that_of_the_algorithm_on_floats():
    """G and M of the event come from compiled code, those of `nearly_dependent` from floats."""
    s = row(1)
    motion = fb.simulate(s, 1.0, initial=upright(1))
    (event,) = motion.events
    model = fb.assemble(s)
    q, u = (
        [motion.at(event.time)[name] for name in names]
        for names in (model.coordinate_names, model.speed_names)
    )
    state = float_state(model, q, u, event.time)
    active = independent_rows(model, float_state(model, [*map(upright(1).get, model.coordinate_names)]))
    names = nearly_dependent(model, state, active, LIMIT)
    assert names == (event.name,) == ("C1_x",)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, 1e-7])
def test_long_steps_of_gauss_are_looked_into(tolerance):
    """Steps of half a second lead over a position and show nothing of it at their ends."""
    for n in (1, 2):
        motion = fb.simulate(
            row(n), 5.0, initial=upright(n), method="gauss", tolerance=tolerance, samples=101
        )
        assert len(motion.events) == 5
        assert np.abs(motion["phi0"] - angle(n, motion.t)).max() < 0.1 * tolerance


def test_names_do_not_depend_on_how_the_conditions_are_kept(monkeypatch):
    """The matrix of few conditions is kept with its zeros, that of many without."""
    names = []
    for few in (loop_closure.FEW, 0):
        monkeypatch.setattr(loop_closure, "FEW", few)
        motion = fb.simulate(row(2), 1.0, initial=upright(2))
        names.append(str(motion.events))
    assert names[0] and names[0] == names[1]


def test_a_small_linkage_imports_no_sparse_matrices():
    """They take longer to import than the motion takes."""
    script = (
        f"import sys\nimport numpy as np\nimport freebody as fb\nG = {G}\n"
        f"{inspect.getsource(row)}\n{inspect.getsource(upright)}\n"
        "motion = fb.simulate(row(2), 1.0, initial=upright(2))\n"
        "print(len(motion.events), 'scipy.sparse' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["1", "False"]
