"""What a user sees of contact: the page of the docs, the command line, the dataset, the picture."""

import json
import os
import re
import signal
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import freebody as fb
from contact_machines import DISK
from freebody.cli import main
from freebody.errors import SimulationError
from freebody.motion.contact.refusals import refusal
from freebody.motion.contact.state import ContactRun
from freebody.motion.events import event_run, limits
from freebody.motion.kernels.kernels import kernels_of

PAGE = (Path(__file__).parents[4] / "docs" / "contact-simulation.md").read_text(encoding="utf-8")


def test_the_page_prints_what_it_says(capsys):
    blocks = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```\n", PAGE, re.DOTALL)
    assert len(blocks) == PAGE.count("```python") == PAGE.count("```text")
    names: dict[str, object] = {}
    for code, printed in blocks:
        exec(compile(code, "docs/contact-simulation.md", "exec"), names)
        assert capsys.readouterr().out == printed, code


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "disk.toml"
    path.write_text(DISK, encoding="utf-8")
    return str(path)


def test_run_prints_events_and_modes(model, capsys):
    with pytest.raises(SystemExit, match="^0$"):
        main(["run", model, "--until", "1"])
    printed = capsys.readouterr().out
    assert "Events:\n  t = 0.509684 s: contact floor: slip + → stick, the slip stopped" in printed
    assert "Contacts:\n  floor: slip + from 0 to 0.509684 s (the start)" in printed


def test_run_gives_them_as_json(model, capsys):
    with pytest.raises(SystemExit, match="^0$"):
        main(["run", model, "--until", "1", "--json"])
    report = json.loads(capsys.readouterr().out)
    assert report["events"][0]["time"] == pytest.approx(0.509684, abs=1e-6)
    assert [m["mode"] for m in report["modes"]] == ["slip+", "stick"]
    assert report["modes"][1]["why"] == "the slip stopped"


def test_long_lists_leave_out_their_middle():
    from freebody.cli.run import MOST, happenings

    class Long:
        modes = ()
        kernels = SimpleNamespace(model=SimpleNamespace(constraints={}))
        course = SimpleNamespace(indeterminate=())

    lines = happenings(Long(), list(range(100)))
    assert len(lines) == MOST + 3
    assert "  ... 76 more ..." in lines


def block():
    s = fb.System("block")
    g, F = s.parameters(g=9.81, F=3.0)
    s.gravity = (0, -g, 0)
    body = s.body("block", fb.box(2, (1, 0.4, 1)))
    s.planar("rail", s.ground, body, coordinate="x y turn")
    feet = body.corners((-0.5, -0.2, 0), (0.5, -0.2, 0))
    s.contact("foot", feet, s.ground.plane(normal="y"), friction=0.5)
    s.force("F", body.origin, (F, 0, 0))
    return s


def test_dataset_and_indeterminate_forces(tmp_path):
    motion = fb.simulate(block(), 1, initial={"y": 0.2})
    assert motion.indeterminate == ("T_foot_1", "T_foot_2")
    one, two = motion.contacts["foot_1"], motion.contacts["foot_2"]
    assert np.isnan(one.tangential).all()
    # two normal forces are known: N_2 - N_1 carries the couple of the pull, F (b/2) = (N_2 - N_1) (a/2)
    np.testing.assert_allclose(one.normal + two.normal, 2 * 9.81, rtol=1e-12)
    np.testing.assert_allclose(two.normal - one.normal, 3 * 0.2 / 0.5, rtol=1e-10)
    # by name: friction in proportion to N, so that the margins are equal parts
    np.testing.assert_allclose(one.least[:, 1] + two.least[:, 1], -3, rtol=1e-12)
    np.testing.assert_allclose(one.least[:, 1] / one.normal, two.least[:, 1] / two.normal, rtol=1e-9)
    motion.save(tmp_path / "block.nc")
    data = fb.Trajectory.load(tmp_path / "block.nc").data
    assert set(data["foot_1.mode"].values) == {"stick"}
    assert {"foot_1.gap", "foot_1.normal", "foot_1.tangential", "foot_1.slip", "foot_1.margin"} <= set(data)


def test_both_feet_slip_at_the_limit_of_the_whole():
    s = block()
    s2 = fb.simulate(s, 1, initial={"y": 0.2}, values={"F": 0.5 * 2 * 9.81 * (1 + 1e-9)})
    assert {m.mode for m in s2.modes} == {"slip+"}
    s3 = fb.simulate(s, 1, initial={"y": 0.2}, values={"F": 0.5 * 2 * 9.81 * (1 - 1e-9)})
    assert {m.mode for m in s3.modes} == {"stick"}


def test_margin_is_drawn_and_the_timeline_is_asked_by_name():
    motion = fb.simulate(block(), 1, initial={"y": 0.2})
    axes = motion.plot_margin("foot_1")
    assert [line.get_label() for line in axes.get_lines()][0] == "foot_1"
    assert axes.get_ylabel() == "μ_s N - |T| [N]"
    assert len(motion.modes.of("foot_1")) == 1
    with pytest.raises(SimulationError, match="Unknown contact 'feet'"):
        motion.modes.of("feet")


def test_the_keyboard_interrupts_a_machine_that_rattles_within_a_tenth_of_a_second():
    """Its phases have two steps each, and never come to the pause inside a phase."""
    s = fb.System("rattle")
    s.gravity = (0, -9.81, 0)
    ball = s.body("ball", fb.particle(1))
    s.slider("rail", s.ground, ball, axis="y", coordinate="y")
    s.contact("floor", ball.point(0, 0, 0), s.ground.plane(), restitution=1)
    ceiling = s.ground.plane(at=(0, 1, 0), normal=(0, -1, 0))
    s.contact("ceiling", ball.point(0, 0, 0), ceiling, restitution=1)
    start, sent = {"y": 0.5, "y'": 30}, []
    fb.simulate(s, 1, initial=start)

    def press():
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    waited = []
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background ignores it
    try:
        for after in (0.1, 0.2, 0.3):
            threading.Timer(after, press).start()
            motion = fb.simulate(s, 1e5, initial=start)
            waited.append(time.perf_counter() - sent[-1])
            assert motion.interrupted
            assert 1 < motion.t[-1] < 1e5
            # parabolas are exact; a moment t is known to ε t, a height at speed v to v ε t: m g v ε t for each bounce
            rounding = 9.81 * 30 * np.finfo(float).eps * motion.t[-1]
            assert np.abs(motion.energy.residual).max() < len(motion.events) * rounding
    finally:
        signal.signal(signal.SIGINT, before)
    assert min(waited) < 0.1


def test_pieces_without_a_thread_stay_short(monkeypatch):
    """A log that is full is answered between pieces: what follows each answer holds the main thread for a moment."""
    from freebody.motion.contact import run

    monkeypatch.setattr("freebody.motion.trajectory.progress.SHORT", -1.0)
    budgets, code = [], run.code

    def recorded(name):
        loop = code(name)

        def call(it, *others):
            budgets.append(int(it.budget))
            return loop(it, *others)

        return call if name == "go_on" else loop

    monkeypatch.setattr(run, "code", recorded)
    s = fb.System("rattle")
    ball = s.body("ball", fb.particle(1))
    s.slider("rail", s.ground, ball, axis="y", coordinate="y")
    s.contact("floor", ball.point(0, 0, 0), s.ground.plane(), restitution=1)
    ceiling = s.ground.plane(at=(0, 1, 0), normal=(0, -1, 0))
    s.contact("ceiling", ball.point(0, 0, 0), ceiling, restitution=1)
    fb.simulate(s, 100, initial={"y": 0.5, "y'": 30})
    alone = [budget for budget in budgets if budget < limits.NO_PAUSE]
    assert len(budgets) > len(alone) + 3 and len(alone) > 4 and max(alone) <= run.FEW


def test_the_timeline_says_where_limits_of_open_forces_are_not_watched():
    """A change of modes is logged with `HELD_OPEN` there: the rest is named, and the moment that ends it."""
    s = fb.System("bowling")
    s.gravity = (0, -9.81, 0)
    body = s.body("disk", fb.disk(10, 0.3))
    s.planar("plane", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.circle(0.3), s.ground.plane(normal="y"), friction=0.2)
    history = fb.simulate(s, 1, initial={"y": 0.3, "x'": 3}).course.history
    at = np.flatnonzero(history.marks == event_run.SLIP_STOPPED)[-1]
    history.marks[at - 1] += event_run.HELD_OPEN
    change = history.timeline[-1]
    assert change.mode == "stick" and change.why == (
        "the slip stopped; open forces hold it at rest, asked every 1 ms at most: a shorter slip is not seen"
    )
    assert str(history.happenings[-1]).endswith(f"slip + → stick, {change.why}")


def test_the_loop_may_ask_for_python_any_number_of_times():
    """Its budget of steps doubles with each question, up to one that does not end."""
    s = fb.System("kicked")
    s.gravity = (0, -9.81, 0)
    ball = s.body("ball", fb.particle(1))
    s.slider("rail", s.ground, ball, axis="y", coordinate="y")
    s.contact("floor", ball.point(0, 0, 0), s.ground.plane(at=(0, -1, 0)))
    kick = fb.blow(fb.event("y", direction=-1), at=ball, normal=(0, 1, 0), restitution=1)
    motion = fb.simulate(s, 20, initial={"y": 0.1}, impulses=[kick])
    assert motion.status == "finished" and len(motion.happenings) > 64
    assert motion.energy.relative_residual < 1e-9


def test_an_event_without_a_finite_state_is_refused():
    """As where a slip in space vanishes inside a step: two of 160 thrown boxes."""
    kernels = kernels_of(block()).by_events()
    work = ContactRun(kernels, kernels.model.values({"F": 1.0}))
    work.memory.longer_log()
    said = str(refusal(work, event_run.NO_STATE))
    assert "has no finite state at the event at t = 0 s, in a step from 0 s, as where slips lose" in said
    assert "Change the start a little, or take method='timestepping' with step=" in said


def test_a_box_on_a_table_that_a_signal_lifts():
    """The gap of two solids as a whole, where each piece of the signal has parameters of its own."""
    s = fb.System("lift")
    s.gravity = (0, 0, -9.81)
    box, table = s.body("box", fb.box(1, (0.2, 0.1, 0.1))), s.body("table", fb.box(5, (0.4, 0.4, 0.2)))
    s.free("f", s.ground, box)
    height = fb.signal([0, 1, 2], [0, 0.3, 0.1], kind="cubic", ends="clamped", outside="hold")
    s.slider("lift", s.ground, table, axis="z", coordinate=height)
    s.contacts("c", [box.box((0.2, 0.1, 0.1)), table.box((0.4, 0.4, 0.2))], friction=0.3)
    motion = fb.simulate(s, 1.5, initial={"f_z": 0.16}, samples=31)
    gap = motion["f_z"] - 0.15 - CubicSpline([0, 1, 2], [0, 0.3, 0.1], bc_type="clamped")(motion.t)
    np.testing.assert_allclose(motion.contacts["c[box,table]"].gap, gap, atol=1e-12)
    assert gap[-1] == pytest.approx(0, abs=1e-12)
