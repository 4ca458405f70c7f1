"""Modes as data give the motion of the machine whose contacts are conditions, whatever the modes."""

import itertools

import numpy as np
import pytest

import freebody as fb
from contact_machines import falling_rod, pulled_disk, tumbling_box
from freebody.dynamics import float_state
from freebody.dynamics.composite import mass_matrix
from freebody.dynamics.conditions.constrained import position_correction, speed_correction
from freebody.dynamics.conditions.constraints import rows
from freebody.dynamics.conditions.contact import contact_rows
from freebody.dynamics.conditions.linearized import linearized
from freebody.dynamics.contact_motion import contact_forces, in_modes
from freebody.dynamics.motion import all_reactions, motion, total_power, transmitting
from freebody.motion.kernels.kernels import Kernels, kernels_of
from freebody.motion.ode.dense_output import observe, outputs_at
from freebody.motion.phase.phase import SMOOTH, at_limit
from freebody.motion.phase.phase_record import PhaseData
from freebody.motion.phase.scene import phase_of, scene_of
from freebody.native.records import address


def cart_and_box():
    """A box on a driven cart beside two rods in a groove: own conditions, a drive, damping, two bodies in contact."""
    s = fb.System("cart and box")
    s.gravity = (0, -9.81, 0)
    cart, box = s.body("cart", fb.box(3, (1, 0.2, 0.5))), s.body("box", fb.box(1, (0.4, 0.3, 0.2)))
    s.slider("drive", s.ground, cart, axis="x", coordinate=s.t**2 / 4 + s.t)
    s.planar("plane", s.ground, box, coordinate="x y phi")
    s.damper("d", box.origin, s.ground.point(2, 1, 0), damping=0.7)
    rod, crank = (
        s.body("rod", fb.slender_bar(1, 1, axis="x")),
        s.body("crank", fb.slender_bar(0.5, 0.5, axis="x")),
    )
    s.hinge("a", s.ground, crank, at=(3, 1, 0), to=(-0.25, 0, 0), axis="z", coordinate="alpha")
    s.hinge("b", crank, rod, at=(0.25, 0, 0), to=(-0.5, 0, 0), axis="z", coordinate="beta")
    s.constrain("sin(alpha)/2 + sin(alpha + beta)/3 - 0.1", name="groove")
    s.contact("c", box.corners(size=(0.4, 0.3)), cart.plane(normal="y", at=(0, 0.1, 0)), friction=0.5)
    s.contact("r", rod.point(0.5, 0, 0), s.ground.plane(normal="y"), friction=0.3, static_friction=0.4)
    return s


MACHINES = {one.__name__: one for one in (cart_and_box, tumbling_box)}


def symbolic(mode):
    if mode == SMOOTH:
        return "slip"
    return ("slip", tuple(map(float, mode.split()[1:]))) if " " in mode else mode


@pytest.mark.parametrize("name", MACHINES)
def test_the_motion_is_that_of_contacts_as_conditions(name):
    s = MACHINES[name]()
    model = fb.assemble(s)
    own = tuple(range(len(rows(model))))
    kernels = kernels_of(s)
    kernels = kernels.holding(own) if own else kernels
    scene, rng = scene_of(kernels), np.random.default_rng(5)
    values = kernels.values(None)
    p = kernels.parameters(values)
    tried = 0
    for _ in range(160):
        modes = tuple(
            str(rng.choice(["open", "stick", "slip+", "slip-"] if n == 1 else ["open", "stick", "slip"]))
            for n in scene.tangents
        )
        q = rng.normal(size=model.n_q)
        for i in model.quaternions:
            q[i : i + 4] /= np.linalg.norm(q[i : i + 4])
        u, t = rng.normal(size=model.n_u), float(rng.normal())
        y = np.concatenate([q, u, [0.0, 0.0]])
        seen = scene.at(t, y, scene.constants(p))
        phase = scene.phase(modes, seen)
        if phase.spare:
            continue
        tried += 1
        moded = in_modes(
            model, {c.name: symbolic(m) for c, m in zip(model.contacts, modes, strict=True) if m != "open"}
        )
        state = float_state(moded, q.tolist(), u.tolist(), t, values)
        wanted = motion(moded, state, phase.active)
        forces = contact_forces(moded, state, wanted.multipliers)
        lam = np.array([float(x) for c in model.contacts for x in forces[c.name]])

        def got(program, function, y=y, t=t):
            constants = program.constants(p)
            return observe(
                program.address(function), program.outputs(function), np.array([t]), y[None], constants
            )[0]

        rates, size = got(phase.motion(), "rates"), 1 + np.abs(lam).max() + np.abs(wanted.udot).max()
        assert rates[model.n_q : -2] == pytest.approx(np.array(wanted.udot, dtype=float), abs=1e-10 * size)
        heat = -sum(
            float(a) * float(b)
            for c, mode, rate in zip(model.contacts, modes, per_contact(scene, seen.rate), strict=True)
            if mode.startswith("slip")
            for a, b in zip(forces[c.name][1:], rate[1:], strict=True)
        )
        assert rates[-1] == pytest.approx(heat, abs=1e-10 * size)
        assert rates[-2] == pytest.approx(float(total_power(moded, state, wanted)), abs=1e-9 * size)
        assert got(phase.contact(), "force") == pytest.approx(lam, abs=1e-10 * size)
        rows_ = contact_rows(model, state)
        a = np.array(rows_.matrix, dtype=float) @ np.array(wanted.udot, dtype=float) + np.array(
            rows_.bias, dtype=float
        )
        assert got(phase.contact(), "acceleration") == pytest.approx(a, abs=1e-10 * size)
        assert got(phase.contact(), "gap") == pytest.approx(np.array(rows_.gap, dtype=float))
        found = all_reactions(moded, state, wanted)
        mine = [float(x) for name in list(found)[: len(transmitting(model))] for v in found[name] for x in v]
        assert got(phase.reactions(), "reactions") == pytest.approx(mine, abs=1e-9 * size)
        assert got(phase.reactions(), "multipliers") == pytest.approx(
            np.array(wanted.multipliers[: len(own)], dtype=float), abs=1e-10 * size
        )
        if phase.active:
            place = position_correction(moded, state, phase.active)
            there = float_state(moded, [float(x) for x in place], u.tolist(), t, values)
            onto = [*place, *speed_correction(moded, there, phase.active)]
            onto = np.array(onto, dtype=float)
            worst = max(condition_number(moded, one, phase.active) for one in (state, there))
            rounded = 1e-13 * worst * (1 + np.abs(onto).max())
            assert got(phase.motion(), "projection") == pytest.approx(onto, abs=rounded)
    assert tried > 20


def condition_number(model, state, active):
    """Of G M⁻¹ Gᵀ: it multiplies round-off."""
    G = np.array([linearized(model, state).matrix[i] for i in active], dtype=float)
    return np.linalg.cond(G @ np.linalg.solve(np.array(mass_matrix(model, state), dtype=float), G.T))


def per_contact(scene, rate):
    return [rate[at : at + 1 + n] for at, n in zip(scene.first, scene.tangents, strict=True)]


def test_new_modes_derive_and_compile_nothing(monkeypatch):
    s = tumbling_box()
    kernels = kernels_of(s)
    scene = scene_of(kernels)
    p = kernels.parameters(kernels.values(None))
    first = scene.phase(("open",) * 5)
    first.motion(), first.contact(), first.reactions(), first.whole(())
    monkeypatch.setattr(Kernels, "program", None)
    monkeypatch.setattr(
        "freebody.motion.phase.candidates.candidates.Candidates.program",
        lambda self: kernels.programs["candidates"],
    )
    monkeypatch.setattr(
        "freebody.motion.phase.candidates.candidates.Candidates.reactions",
        lambda self: kernels.programs["reactions in modes"],
    )
    for modes in itertools.product(("open", "stick", "slip", at_limit((0.6, 0.8))), repeat=5):
        phase = scene.phase(modes)
        phase.rates(p), phase.whole(()), phase.reactions()


def test_constants_share_no_memory():
    """Two runs of one phase may go on side by side, and one with other parameters leaves the other as it is."""
    s = tumbling_box()
    kernels = kernels_of(s)
    scene, model = scene_of(kernels), kernels.model
    p, n_q = kernels.parameters(kernels.values(None)), model.n_q
    program = scene.phase(("stick", "stick", "open", "slip", "open")).motion()
    y = np.concatenate([[0.1, 0.2, 0.3, 0.6, 0.0, 0.8, 0.0, 0.4], np.linspace(1, 2, model.n_u), [0.0, 0.0]])
    assert len(y) == n_q + model.n_u + 2

    def rates(c):
        return outputs_at(program.address("rates"), program.outputs("rates"), 0.0, y, c)

    first, second = program.constants(p), program.constants(p)
    wanted = rates(first)
    assert np.isfinite(wanted).all()
    ends = [(address(c), address(c) + c.nbytes) for c in (first, second)]
    rows = [f.place // 8 for f in PhaseData.fields.values() if f.kind in ("Row", "Rows", "Wholes")]
    for c, (begin, end) in zip((first, second), ends, strict=True):
        assert all(begin <= at < end for at in c.view(np.int64)[rows] if at)
    program.set_parameters(second, 2 * p)
    first[:] = np.nan
    assert (program.constants(p) != second).any()
    assert rates(program.constants(p)) == pytest.approx(wanted, abs=0, rel=0)


def test_endings_after_the_rates_at_a_state_are_those_of_that_state():
    """They take what the rates have solved, once, and not if the state is another or the kernels were asked since."""
    kernels = kernels_of(tumbling_box())
    scene, model = scene_of(kernels), kernels.model
    p = kernels.parameters(kernels.values(None))
    modes = "stick", "slip", "open", "open", "open"
    program = scene.phase(modes).whole(())
    y = np.concatenate([[0.1, 0.2, 0.3, 0.6, 0.0, 0.8, 0.0, 0.4], np.linspace(1, 2, model.n_u), [0.0, 0.0]])
    other = y.copy()
    other[model.n_q] += 1e-3

    def call(name, y, c):
        return outputs_at(program.address(name), program.outputs(name), 0.0, y, c)

    def fresh(name, y):
        return call(name, y, program.constants(p))

    wanted = fresh("watched", y)
    c = program.constants(p)
    call("rates", y, c)
    assert (call("watched", y, c) == wanted).all()
    call("rates", y, c)
    assert (call("watched", other, c) == fresh("watched", other)).all() and (
        fresh("watched", other) != wanted
    ).any()
    call("rates", y, c)
    call("projection", other, c)
    assert (call("watched", y, c) == wanted).all()
    call("rates", y, c)
    assert (call("watched", y, c) == wanted).all()
    program.set_parameters(c, 2 * p)  # the look at the state is over
    assert (call("watched", y, c) == call("watched", y, program.constants(2 * p))).all()


@pytest.mark.parametrize("machine", [pulled_disk, falling_rod])
def test_a_motion_of_other_modes_or_conditions_is_refused(machine):
    kernels = kernels_of(machine())
    for modes, active in (
        (("rolls",), ()),
        (("stick",), (5,)),
        (("stick",), (0, 0)),
        (("limit 1.0 0.0",), ()),
    ):
        with pytest.raises(fb.errors.SimulationError, match="motion is not of this machine"):
            phase_of(kernels, modes, active)
