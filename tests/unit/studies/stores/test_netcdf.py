"""Files of results: full disks, folders that may not be written, killed runs, and Ctrl-C at any moment."""

from __future__ import annotations

import contextlib
import errno
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import freebody as fb
from batch_machines import pendulum
from freebody.errors import SimulationError
from freebody.gallery.beyond.bouncing_ball import build as ball
from freebody.motion.batch import job, lane_loop
from freebody.motion.files import replacing as files
from freebody.studies.blocks import run as run_of_blocks
from freebody.studies.stores import memory, netcdf
from sampled import sampled

BALLS = {
    "initial": {"y": "h"}, "values": {"h": np.linspace(1, 2, 40)}, "samples": 2, "outputs": ["y", "modes"],
    "progress": False,
}  # fmt: skip


@contextlib.contextmanager
def no_file_beyond(size: int) -> Any:
    """The system refuses, as on a full disk, what would make a file longer."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def statuses(path: Path) -> Any:
    with h5py.File(path, "r") as file:
        for name in file:
            file[name][()]
        return file["status"][:]


def test_a_disk_that_has_no_room_for_the_results(tmp_path) -> None:
    path = tmp_path / "x.nc"
    many = {"initial": {"theta": np.linspace(0.1, 1, 2000)}, "samples": 20, "progress": False}
    fb.simulate(pendulum(), 1, initial={"theta": [0.1, 0.2]}, samples=2)  # whatever is compiled
    with no_file_beyond(1 << 15), pytest.raises(SimulationError) as error:
        fb.simulate(pendulum(), 1, store=path, **many)
    text = (
        f"Cannot write '{path}': File too large. Choose a disk that takes files of 0.871 MB, or ask for less."
    )
    assert str(error.value) == text and error.value.__cause__.errno == errno.EFBIG
    assert os.listdir(tmp_path) == []
    path = tmp_path / "motion.nc"
    motion = fb.simulate(pendulum(), 1, samples=2000)
    motion.save(path)
    before = path.read_bytes()
    with (
        no_file_beyond(1 << 12),
        pytest.raises(SimulationError, match=f"Cannot write '{path}': .* files of"),
    ):
        motion.save(path)
    assert path.read_bytes() == before and os.listdir(tmp_path) == ["motion.nc"]


def test_a_disk_that_is_full_in_the_course_of_a_run(tmp_path, monkeypatch) -> None:
    """Texts make a file longer: it is as it was, bit for bit, and goes on when there is room."""
    whole = fb.simulate(ball(), 3, **BALLS)
    path, written = tmp_path / "x.nc", []
    write = netcdf.NetCDF.write

    def twice(self: Any, part: Any) -> None:
        if len(written) == 2:
            written.append(path.read_bytes())
            with no_file_beyond(len(written[-1]) + 1000):
                write(self, part)
        written.append(None)
        write(self, part)

    monkeypatch.setattr(netcdf.NetCDF, "write", twice)
    with pytest.raises(
        SimulationError, match="The lanes that were written before are whole, and the same call"
    ) as e:
        fb.simulate(ball(), 3, store=path, **BALLS)
    assert e.value.__cause__.errno == errno.EFBIG and path.read_bytes() == written[-1]
    assert 0 < (statuses(path) >= 0).sum() < 40
    monkeypatch.setattr(netcdf.NetCDF, "write", write)
    again = fb.simulate(ball(), 3, store=path, **BALLS)
    for name in whole.data_vars:
        assert np.array_equal(again[name].values, whole[name].values), name


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="mounts a file system")
def test_a_file_system_that_is_really_full(tmp_path) -> None:
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", str(tmp_path)]).returncode:
        pytest.skip("no right to mount")
    try:
        path = tmp_path / "x.nc"
        fb.simulate(ball(), 3, store=path, **BALLS).close()
        before = path.read_bytes()
        with h5py.File(path, "r+") as file:
            file["status"][5:] = -1
        room = os.statvfs(tmp_path)
        (tmp_path / "fill").write_bytes(bytes(room.f_bavail * room.f_frsize))
        with pytest.raises(
            SimulationError, match=rf"Cannot write '{path}': No space left on device\. The lanes "
        ):
            fb.simulate(ball(), 3, store=path, **BALLS)
        assert (statuses(path)[:5] >= 0).all() and len(path.read_bytes()) == len(before)
        with pytest.raises(
            SimulationError, match="other.nc': No space left on device. Free .* MB, or choose"
        ):
            fb.simulate(ball(), 3, store=tmp_path / "other.nc", **BALLS)
        (tmp_path / "fill").unlink()
        data = fb.simulate(ball(), 3, store=path, **BALLS)
        assert "waiting" not in data.status
        data.close()
        subprocess.run(["mount", "-o", "remount,ro", str(tmp_path)], check=True)
        fb.simulate(ball(), 3, store=path, **BALLS).close()  # there is nothing to write
        with pytest.raises(
            SimulationError, match="Read-only file system. Choose a path at which you may write"
        ):
            fb.simulate(ball(), 3, store=tmp_path / "other.nc", **BALLS)
    finally:
        subprocess.run(["umount", "-l", str(tmp_path)], check=True)


READ_ONLY = """
import os, sys
from pathlib import Path
import h5py, numpy as np, freebody as fb
from batch_machines import pendulum

folder = Path(sys.argv[1])
run = {"initial": {"theta": np.linspace(0.1, 1, 20)}, "samples": 3, "progress": False}
fb.simulate(pendulum(), 1, store=folder / "x.nc", **run).close()
with h5py.File(folder / "x.nc", "r+") as file:
    file["status"][10:] = -1
before = (folder / "x.nc").read_bytes()
(folder / "x.nc").chmod(0o444)
folder.chmod(0o555)
folder.parent.chmod(0o755)
if os.geteuid() == 0:
    os.setuid(65534)
for name in ("x.nc", "other.nc"):
    try:
        fb.simulate(pendulum(), 1, store=folder / name, **run)
    except fb.errors.SimulationError as error:
        print(error)
        print(type(error.__cause__).__name__)
print(os.listdir(folder), (folder / "x.nc").read_bytes() == before)
"""


def test_a_folder_that_may_not_be_written() -> None:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "FREEBODY_CACHE": "off"}
    above = Path(tempfile.mkdtemp())  # that of pytest belongs to one user
    folder = above / "results"
    folder.mkdir()
    found = subprocess.run(
        [sys.executable, "-c", READ_ONLY, str(folder)], capture_output=True, text=True, env=environment
    )
    folder.chmod(0o755)
    shutil.rmtree(above)
    assert found.stdout.splitlines() == [
        f"Cannot write '{folder}/x.nc': Permission denied. The lanes that were written before are whole, and the same "
        "call goes on with the others. Choose a path at which you may write, or change the rights there.",
        "PermissionError",
        f"Cannot write '{folder}/other.nc': Permission denied. Choose a path at which you may write, or change the "
        "rights there.",
        "PermissionError",
        "['x.nc'] True",
    ], found.stderr


def test_what_killed_runs_left_is_removed_by_the_next(tmp_path) -> None:
    program = """
import os, signal, sys
import freebody as fb
from batch_machines import pendulum
from freebody.studies.stores import memory, netcdf

netcdf.attributes_of = lambda job: os.kill(os.getpid(), signal.SIGKILL)
fb.simulate(pendulum(), 1, initial={"theta": [0.1, 0.2]}, samples=2, store=sys.argv[1])
"""
    path = tmp_path / "x.nc"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    killed = subprocess.Popen([sys.executable, "-c", program, str(path)], env=environment)
    assert killed.wait() == -signal.SIGKILL and os.listdir(tmp_path) == [f".x.nc.{killed.pid}.new"]
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as living:
        others = [
            f".x.nc.{living.pid}.new",
            f".y.nc.{killed.pid}.new",
            f"x.nc.{killed.pid}.new",
            ".x.nc.1e5.new",
        ]
        for name in others:
            (tmp_path / name).write_text("of somebody else")
        os.mkfifo(tmp_path / ".x.nc.999999998.new")
        (tmp_path / ".x.nc.999999999.new").symlink_to(tmp_path / others[1])
        with h5py.File(tmp_path / ".x.nc.999999997.new", "w"):  # of another computer: it is being written
            fb.simulate(pendulum(), 1, initial={"theta": [0.1, 0.2]}, samples=2, store=path).close()
            left = set(os.listdir(tmp_path))
        assert left == {"x.nc", *others, *(f".x.nc.99999999{k}.new" for k in (7, 8, 9))}
        living.communicate(b"\n")
    path.unlink()
    fb.simulate(pendulum(), 1, initial={"theta": [0.1, 0.2]}, samples=2, store=path).close()
    assert f".x.nc.{living.pid}.new" not in os.listdir(tmp_path)
    assert ".x.nc.999999997.new" not in os.listdir(tmp_path)


KILLED = """
import os, signal, sys
import h5py, numpy as np, freebody as fb
from freebody.gallery.beyond.bouncing_ball import build
from freebody.studies.stores import memory, netcdf
from test_netcdf import BALLS

left = int(sys.argv[2])
write, put = netcdf.NetCDF.write, h5py.Dataset.__setitem__

def counted(self, place, value):
    global left
    put(self, place, value)
    left -= 1
    if left == 0:
        os.kill(os.getpid(), signal.SIGKILL)

def second(self, part):
    write(self, part)
    h5py.Dataset.__setitem__ = counted

netcdf.NetCDF.write = second
fb.simulate(build(), 3, store=sys.argv[1], **BALLS)
"""


@pytest.mark.parametrize(
    "moment", [3, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 2, 4, 5, 7, 8, 9, 10))]
)
def test_a_process_killed_as_it_writes_texts_costs_these_lanes_only(tmp_path, moment: int) -> None:
    path = tmp_path / "x.nc"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([*sys.path, str(Path(__file__).parent)])}
    killed = subprocess.run([sys.executable, "-c", KILLED, str(path), str(moment)], env=environment)
    assert killed.returncode == -signal.SIGKILL
    with h5py.File(path, "r") as file:
        done = (file["status"][:] >= 0).sum()
    assert 0 < done < 40
    whole, again = fb.simulate(ball(), 3, **BALLS), fb.simulate(ball(), 3, store=path, **BALLS)
    for name in whole.data_vars:
        assert np.array_equal(again[name].values, whole[name].values), name


# -- Ctrl-C --------------------------------------------------------------------------------------------------

MOMENTS = {
    "while it is read": (job, "lanes_of", True),
    "when the file is begun": (netcdf, "coordinates_of", True),
    "in the middle of it": (netcdf, "attributes_of", True),
    "just before it is there": (os, "replace", True),
    "before the first lane": (run_of_blocks, "growing", False),
    "when the loop is made": (job, "batch_program", False),
    "when lanes are shared out": (lane_loop, "share", False),
    "between two lanes": (lane_loop.LaneLoop, "chunk", False),
    "when results are written": (netcdf.NetCDF, "write", False),
    "in the middle of writing them": (netcdf, "_runs", False),
    "before they are in their place": (files, "reserve", False),
    "when they are read": (netcdf.NetCDF, "dataset", False),
    "when that is done": (netcdf, "labelled", False),
}


@contextlib.contextmanager
def default_handler() -> Any:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize(
    ("moment", "presses"),
    [*((moment, 1) for moment in MOMENTS), *sampled(((moment, 2) for moment in MOMENTS), 4)],
)
def test_ctrl_c_at_any_moment_keeps_what_is_done(tmp_path, monkeypatch, moment: str, presses: int) -> None:
    """In set-up it ends the call, with the file as it was; later the call gives what there is."""
    place, name, raises = MOMENTS[moment]
    options = {"initial": {"theta": np.linspace(0.1, 3, 300)}, "samples": 3, "threads": 1, "progress": False}
    whole = fb.simulate(pendulum(), 1, **options)
    path = tmp_path / "x.nc"
    called = getattr(place, name)

    def run(first: int) -> bool:
        """Whether the call with Ctrl-C at one of the times that this moment comes gave a result."""
        calls = iter(range(1000))

        def pressed(*given: Any, **named: Any) -> Any:
            if first <= next(calls) < first + presses:
                os.kill(os.getpid(), signal.SIGINT)
            return called(*given, **named)

        with default_handler(), monkeypatch.context() as m:
            m.setattr(place, name, pressed)
            if name == "reserve":
                m.setattr(netcdf, name, pressed)
            try:
                data = fb.simulate(pendulum(), 1, store=path, **options)
            except KeyboardInterrupt:
                return False
        assert signal.getsignal(signal.SIGINT) is not None
        done = (data.status == "finished").values
        assert set(data.status.values[~done]) <= {"waiting"}
        assert np.array_equal(data["theta"].values[done], whole["theta"].values[done])
        assert np.isnan(data["theta"].values[~done]).all()
        assert done.all() == ("interrupted" not in data.attrs)
        data.close()
        return True

    assert run(0) != raises
    kept = statuses(path) if path.exists() else np.full(300, -1)
    assert path.exists() != raises or not raises
    run(1)
    after = statuses(path) if path.exists() else np.full(300, -1)
    assert (after[kept >= 0] == kept[kept >= 0]).all() and not [
        x for x in os.listdir(tmp_path) if x.endswith(".new")
    ]
    again = fb.simulate(pendulum(), 1, store=path, **options)
    assert np.array_equal(again["theta"].values, whole["theta"].values) and "interrupted" not in again.attrs


def test_lanes_that_ctrl_c_finds_stiff_are_run_again(tmp_path, monkeypatch) -> None:
    """They ended as stiff, and were to be run once more: that is no end of theirs."""
    from batch_machines import cart

    options = {
        "values": {"k": np.full(20, 1e6), "c": np.full(20, 1e5)}, "initial": {"x": 1.0}, "samples": 3, "threads": 1,
        "tolerance": 1e-6, "progress": False,
    }  # fmt: skip
    whole = fb.simulate(cart(), 10, **options)
    assert set(whole.status.values) == {"finished"}
    made, path = lane_loop.LaneLoop.__init__, tmp_path / "x.nc"

    def stop(self: Any, job: Any, method: str, *given: Any) -> None:
        if method == "radau":
            raise KeyboardInterrupt
        made(self, job, method, *given)

    for kept in ({}, {"store": path}):
        with monkeypatch.context() as m:
            m.setattr(lane_loop.LaneLoop, "__init__", stop)
            data = fb.simulate(cart(), 10, **options, **kept)
        assert set(data.status.values) == {"waiting"} and np.isnan(data["x"]).all()
        data.close()
    again = fb.simulate(cart(), 10, store=path, **options)
    assert np.array_equal(again["x"], whole["x"])


def test_ctrl_c_while_results_are_put_together_does_not_lose_them(monkeypatch) -> None:
    called = memory.dataset_of

    def pressed(*given: Any) -> Any:
        os.kill(os.getpid(), signal.SIGINT)
        return called(*given)

    monkeypatch.setattr(memory, "dataset_of", pressed)
    with default_handler():
        data = fb.simulate(pendulum(), 1, initial={"theta": [0.1, 0.2]}, samples=3)
        assert set(data.status.values) == {"finished"}
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


PRESSED = """
import sys
import numpy as np, freebody as fb
from freebody.gallery.beyond.bouncing_ball import build

print("ready", flush=True)
data = fb.simulate(
    build(), 3, initial={"y": "h"}, values={"h": np.linspace(1, 2, 150)}, samples=2, outputs=["y", "modes"],
    progress=lambda part: print(part, flush=True), store=sys.argv[1],
)
print((data.status == "waiting").sum().item())
"""


@pytest.mark.slow
def test_ctrl_c_at_random_moments_of_other_processes(tmp_path) -> None:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    path, rng, done, ends = tmp_path / "x.nc", random.Random(0), np.full(150, -1), []
    for k in range(20):
        with subprocess.Popen(
            [sys.executable, "-c", PRESSED, str(path)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env=environment,
        ) as process:  # fmt: skip
            assert process.stdout.readline() == "ready\n"
            for _ in range(rng.randrange(8)):  # so many reports of progress, or to the end
                process.stdout.readline()
            time.sleep(rng.uniform(0, 0.2))
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=600)
        last = out.strip().splitlines()[-1:]
        ends.append((*last, *err.strip().splitlines()[-1:]))
        assert process.returncode in (0, 1, -signal.SIGINT), err
        assert out.strip() or err.strip().endswith("KeyboardInterrupt") or "KeyboardInterrupt" in err, err
        found = statuses(path) if path.exists() else done
        assert (found[done >= 0] == done[done >= 0]).all(), k
        assert not [x for x in os.listdir(tmp_path) if x.endswith(".new")]
        done = found
        if (done >= 0).all():
            path.unlink()
            done = np.full(150, -1)
    assert len(set(ends)) > 3, ends
