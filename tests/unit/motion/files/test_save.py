"""A motion that is saved is read back with all that can be asked of it; what is damaged is refused."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest
import xarray

import freebody as fb
from freebody.errors import FormatError, FreebodyError, SimulationError
from freebody.motion.files import save
from freebody.motion.files.save import GROUP
from motions import MOTIONS, assert_same, ball, driven, pendulum, plain, signalled


@pytest.mark.parametrize("name", MOTIONS)
def test_motion_is_read_back_to_the_bit(name, tmp_path):
    motion = MOTIONS[name]()
    motion.save(tmp_path / "motion.nc")
    again = fb.Trajectory.load(tmp_path / "motion.nc")
    assert again.kernels is not motion.kernels
    assert_same(motion, again)
    again.save(tmp_path / "again.nc")
    assert_same(motion, fb.Trajectory.load(tmp_path / "again.nc"))
    assert xarray.load_dataset(tmp_path / "motion.nc", engine="h5netcdf").identical(motion.data)
    again.plot()


def test_equations_and_next_runs_come_with_the_machine(tmp_path):
    plain().save(tmp_path / "x.nc")
    model = fb.Trajectory.load(tmp_path / "x.nc").kernels.model
    assert fb.equations(model).text() == fb.equations(pendulum()).text()


def test_asked_times_and_stops_are_kept(tmp_path):
    motion = fb.simulate(
        pendulum(), 5, initial={"theta": 1}, events=[fb.event("theta", terminal=True)], times=[0.1, 0.2, 4.0]
    )
    motion.save(tmp_path / "x.nc")
    again = fb.Trajectory.load(tmp_path / "x.nc")
    assert again.status == "terminal event"
    assert again.t.tolist() == [0.1, 0.2]
    assert_same(motion, again)


def test_warnings_are_kept(tmp_path):
    """Those of forces are computed again, those of blows are in the file; the status tells once that there are some."""
    s = fb.System("stone on a string")
    s.gravity = (0, -1, 0)
    stone = s.body("stone", fb.sphere(1, 0.05))
    s.planar("fly", s.ground, stone, coordinate="x y turn")
    s.rope([s.ground.origin, stone.origin], 1, name="string")
    for kick in (2, 0):
        blow = [fb.blow(0.1, at=stone.origin, impulse=(0, kick, 0))] if kick else ()
        start = {"x": 0, "y": -1, "x'": 0 if kick else 1.9}
        motion = fb.simulate(s, 3, initial=start, impulses=blow)
        motion.save(tmp_path / "x.nc")
        again = fb.Trajectory.load(tmp_path / "x.nc")
        assert len(again.warnings) == 1 and again.warnings == motion.warnings
        assert again.status == motion.status == "finished, not physical"


def test_signals_and_inputs_are_parameters_of_each_part(tmp_path):
    for make in (signalled, driven):
        make().save(tmp_path / "x.nc")
        model = fb.Trajectory.load(tmp_path / "x.nc").kernels.model
        assert not model.controllers
        assert not model.signals
    with pytest.raises(SimulationError, match="Expected a coordinate, a speed or an expression"):
        signalled().save(tmp_path / "y.nc")
        fb.Trajectory.load(tmp_path / "y.nc")["no_such_name"]


# -- motions without a machine --------------------------------------------------------------------


def test_machine_that_was_changed_is_asked_for(tmp_path):
    s = pendulum()
    motion = fb.simulate(s, 1, initial={"theta": 1})
    s.parameters(extra=1.0)
    with pytest.warns(
        RuntimeWarning, match="holds its numbers, but not its machine: system 'pendulum' was changed"
    ):
        motion.save(tmp_path / "x.nc")
    with pytest.raises(
        SimulationError,
        match=r"x\.nc' holds a motion, but not its machine: system 'pendulum' was changed after the run\. Pass",
    ):
        fb.Trajectory.load(tmp_path / "x.nc")
    assert_same(motion, fb.Trajectory.load(tmp_path / "x.nc", pendulum()))
    with pytest.raises(
        SimulationError, match=r"Expected the machine of the motion .* with theta, theta'; got 'ball'"
    ):
        fb.Trajectory.load(tmp_path / "x.nc", ball().kernels.model.described[0])
    with pytest.raises(SimulationError, match="or with other parameters"):
        fb.Trajectory.load(tmp_path / "x.nc", s)
    with pytest.raises(fb.errors.ModelError, match="Expected a System or a Model"):
        fb.Trajectory.load(tmp_path / "x.nc", 3)


def test_machine_that_a_file_has_no_words_for(tmp_path, monkeypatch):
    def refuse(system):
        raise FormatError("Expected an expression that a model file can hold, got 'f(x)'.")

    motion = plain()
    monkeypatch.setattr(save, "toml_text", refuse)
    with pytest.warns(
        RuntimeWarning, match=r"not its machine: Expected an expression .*will ask for the machine"
    ):
        motion.save(tmp_path / "x.nc")
    with pytest.raises(
        SimulationError, match=r"not its machine: Expected an expression that a model file can hold"
    ):
        fb.Trajectory.load(tmp_path / "x.nc")
    assert_same(motion, fb.Trajectory.load(tmp_path / "x.nc", pendulum()))


def test_table_alone_is_no_motion(tmp_path):
    plain().data.to_netcdf(tmp_path / "x.nc", engine="h5netcdf")
    with pytest.raises(
        SimulationError, match=r"saved by freebody in '.*x\.nc', found a table alone\. xarray"
    ):
        fb.Trajectory.load(tmp_path / "x.nc")


# -- damaged and hostile files ----------------------------------------------------------------------


def edit(path, change):
    """The group of a file with other content."""
    with h5py.File(path, "r+") as file:
        parts = {name: x[()] for name, x in file[GROUP].items()}
        about = json.loads(bytes(parts["about"]))
        change(about, parts)
        parts["about"] = np.frombuffer(json.dumps(about).encode(), dtype=np.uint8)
        del file[GROUP]
        for name, array in parts.items():
            file[f"{GROUP}/{name}"] = array


def about(**more):
    return lambda told, _: told.update(more)


def segment(**more):
    return lambda told, _: told["segments"][0].update(more)


def part(name, change):
    return lambda _, parts: parts.update({name: change(parts[name])})


DAMAGE = {
    "kind": about(kind="other"),
    "values": about(values={}),
    "event": about(specs=[]),
    "no segment": about(segments=[]),
    "steps": segment(steps=10**12),
    "negative": segment(steps=-1),
    "method": segment(method="__import__"),
    "way": segment(way="steps2"),
    "condition": segment(active=[7]),
    "modes": segment(modes=["open"]),
    "short states": part("states", lambda x: x[:-1]),
    "wide states": part("states", lambda x: np.hstack([x, x])),
    "wide outputs": part("output_states", lambda x: np.hstack([x, x, x])),
    "order": part("times", lambda x: x[[0, 2, 1, *range(3, len(x))]]),
    "nan": part("times", lambda x: x * np.nan),
    "infinite": part("states", lambda x: np.full_like(x, np.inf)),
    "lengths": part("lengths", lambda x: x * np.nan),
    "machine": part("machine", lambda x: x[: len(x) // 2]),
    "missing": lambda told, parts: parts.pop("states"),
    "text for numbers": lambda told, parts: parts.update(states=np.array(b"text")),
}


def test_files_of_other_versions(kept, tmp_path):
    """Another form is refused; corrections of places alone, as earlier time steps had them, change no speed."""
    path = tmp_path / "motion.nc"
    path.write_bytes(kept)
    edit(path, about(form=1))
    message = r"of form 2 in '.*motion\.nc', which another version of freebody saved in form 1\. Run it again"
    with pytest.raises(SimulationError, match=message):
        fb.Trajectory.load(path)
    motion = MOTIONS["time stepping"]()
    motion.save(path)
    n_q = motion.kernels.model.n_q
    edit(path, part("corrections", lambda x: x[:, :n_q]))
    found = fb.Trajectory.load(path).course.impulses.corrections
    assert (
        np.array_equal(found[:, :n_q], motion.course.impulses.corrections[:, :n_q])
        and not found[:, n_q:].any()
    )


def test_signs_of_a_file_are_those_of_its_loads(tmp_path):
    path = tmp_path / "motion.nc"
    for signs in ([1.0], [1.0, 2.0], [[1.0, -1.0]], ["x", 1]):
        MOTIONS["switched"]().save(path)
        edit(path, segment(signs=signs))
        with pytest.raises(
            SimulationError, match="it is damaged: (the signs of its loads|could not convert)"
        ):
            fb.Trajectory.load(path)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    path = tmp_path_factory.mktemp("kept") / "motion.nc"
    plain().save(path)
    return path.read_bytes()


@pytest.mark.parametrize("name", DAMAGE)
def test_damaged_file_is_refused(kept, tmp_path, name):
    path = tmp_path / "motion.nc"
    path.write_bytes(kept)
    edit(path, DAMAGE[name])
    with pytest.raises(SimulationError, match=r"saved whole in '.*motion\.nc', but it is damaged: "):
        fb.Trajectory.load(path)


def test_states_of_another_machine_never_reach_compiled_code(kept, tmp_path):
    """One component too few: found where the code is made, before it is called."""
    path = tmp_path / "motion.nc"
    path.write_bytes(kept)

    def narrow(told, parts):
        for name in ("states", "output_states", "crossing_states"):
            parts[name] = parts[name][:, :2]
        told["accuracies"] = [[None, None]]

    edit(path, narrow)
    motion = fb.Trajectory.load(path)
    with pytest.raises(SimulationError, match="Expected states of 3 components of the machine .*, got 2"):
        motion.at(0.33)


def test_links_and_bombs_in_a_file(kept, tmp_path):
    path, other = tmp_path / "motion.nc", tmp_path / "other.h5"
    path.write_bytes(kept)
    with h5py.File(other, "w") as file:
        file["secret"] = np.zeros(3)
    with h5py.File(path, "r+") as file:
        states = file[GROUP]["states"][()]
        del file[GROUP]["states"]
        file[GROUP]["states"] = h5py.ExternalLink(str(other), "secret")
    with pytest.raises(SimulationError, match="damaged: 'states'"):
        fb.Trajectory.load(path)
    with h5py.File(path, "r+") as file:
        del file[GROUP]["states"]
        file[GROUP].create_dataset("states", shape=(10**11, 3), dtype=float, chunks=(10**4, 3))
    with pytest.raises(SimulationError, match="shorter than what it holds"):
        fb.Trajectory.load(path)
    with h5py.File(path, "r+") as file:
        del file[GROUP]["states"]
        file[GROUP]["states"] = states
        del file[GROUP]["about"]
        file[GROUP]["about"] = np.frombuffer(b"[" * 100_000, dtype=np.uint8)
    with pytest.raises(SimulationError, match="damaged: "):
        fb.Trajectory.load(path)


@pytest.mark.parametrize("make", [plain, ball, lambda: ball(method="timestepping", step=0.01)])
def test_random_damage_is_refused_or_harmless(make, tmp_path):
    """Whatever stands in the file: a refusal in words, or a motion that can be asked."""
    path = tmp_path / "motion.nc"
    make().save(path)
    whole = path.read_bytes()
    random = np.random.default_rng(5)
    odd = [None, -1, 0, 1, 2**40, 1e300, "x", [], {}, True, "slip+", [[1]], float("nan")]

    def spoil(told, parts):
        for _ in range(int(random.integers(1, 3))):
            where = told
            while True:
                keys = list(where) if isinstance(where, dict) else list(range(len(where)))
                key = keys[int(random.integers(len(keys)))]
                if not isinstance(where[key], dict | list) or not where[key] or random.random() < 0.3:
                    break
                where = where[key]
            where[key] = odd[int(random.integers(len(odd)))]
        if random.random() < 0.5:
            name = sorted(parts)[int(random.integers(len(parts)))]
            array = np.array(parts[name])
            if array.size:
                array.flat[int(random.integers(array.size))] = random.choice([0, 1, 200])
            parts[name] = array if random.random() < 0.7 else array[: len(array) // 2]

    read = refused = 0
    for _ in range(25):
        path.write_bytes(whole)
        edit(path, spoil)
        try:
            motion = fb.Trajectory.load(path)
            motion.at(motion.t[:3])
            read += 1
        except FreebodyError:
            refused += 1
    assert read > 0
    assert refused > 5
