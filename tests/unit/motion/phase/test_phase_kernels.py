"""What a look at the contacts forms: rows of near contacts alone, since nothing reads those of far ones."""

import numpy as np

import freebody as fb
from freebody.motion.contact import memory, run
from freebody.motion.phase.laws import NEARBY
from freebody.motion.phase.phase_record import PhaseData


def thrown_cubes():
    """Return two cubes and a ball that are thrown at each other, strike a floor and part, and their start."""
    s = fb.System("thrown")
    s.gravity = (0, 0, -9.81)
    floor = s.ground.plane(normal="z")
    a, b, c = (
        s.body("a", fb.box(1.0, (0.1,) * 3)),
        s.body("b", fb.box(1.5, (0.1,) * 3)),
        s.body("c", fb.sphere(1.0, 0.05)),
    )
    for body in (a, b, c):
        s.free(f"{body.name}_f", s.ground, body)
    s.contacts("all", [a.box((0.1,) * 3), b.box((0.1,) * 3), floor], friction=0.3)
    s.contact("rolls", c.sphere(0.05), floor, friction=0.3, rolling=0.002)
    s.contact("meets", c.sphere(0.05), a.sphere(0.05), friction=0.2, restitution=0.5)
    start = {"a_f_z": 0.08, "a_f_e1": 0.1, "a_f_e2": 0.05, "a_f_vx": 0.5, "a_f_wx": 1.0}
    start |= {"b_f_x": 0.2, "b_f_z": 0.09, "b_f_e2": -0.15, "b_f_vx": -0.4}
    start |= {"c_f_x": -0.3, "c_f_z": 0.05, "c_f_vx": 2.0, "c_f_vy": 0.1, "c_f_wz": 1.0}
    return s, start


def states(s, start):
    m = fb.simulate(s, 0.3, initial=start, samples=3)
    times = np.linspace(0, 0.3, 61)
    return np.array([np.concatenate([m.at(t).q, m.at(t).u]) for t in times]), len(m.events)


def all_rows(equip):
    """Return ``equip`` of a memory whose looks form the rows of all contacts."""

    def equipped(self, *args):
        result = equip(self, *args)
        PhaseData(self.looking).only_near = 0
        return result

    return equipped


def spoil(it):
    """Write NaN into the rows of far contacts, over the speeds of their bodies; return how many rows had numbers."""
    owner, blocks, found = np.array(it.owner), np.array(it.beside).reshape(-1, 2), 0
    far = (np.array(it.gap) > NEARBY * (1 + np.abs(it.y[: it.n_q]).max())) & (np.array(it.held) == 0)
    for M in (it.W, it.X):
        rows = M[: it.rows * it.n].reshape(it.rows, it.n)
        for r in np.flatnonzero(far[owner]):
            for b in set(blocks[owner[r]].tolist()):
                part = rows[r, it.starts[b] : it.starts[b + 1]]
                found += bool(np.isfinite(part).all() and part.any())
                part[:] = np.nan
    return found


def test_nothing_reads_rows_of_far_contacts(monkeypatch):
    s, start = thrown_cubes()
    plain, events = states(s, start)
    assert events > 20

    with monkeypatch.context() as m:
        m.setattr(memory.Memory, "equip", all_rows(memory.Memory.equip))
        assert np.array_equal(states(thrown_cubes()[0], start)[0], plain)

    answered, spoiled = run.answered, []

    def answer(work, question):
        spoiled.append(spoil(work.it))
        answered(work, question)

    monkeypatch.setattr(run, "answered", answer)
    monkeypatch.setattr(run, "FEW", 0)
    monkeypatch.setattr(run.limits, "NO_PAUSE", 1)  # so that the loop answers after each stage
    assert np.array_equal(states(thrown_cubes()[0], start)[0], plain)
    assert len(spoiled) > 20
    assert sum(spoiled) > 0  # they had been near
