"""Messages of motions with families of contacts."""

import pytest

import freebody as fb


def row(n, radius=0.1):
    s = fb.System("row")
    bodies = [s.body(f"b{i}", fb.sphere(1, radius)) for i in range(n)]
    for i, body in enumerate(bodies):
        s.free(f"f{i}", s.ground, body)
    s.contacts("row", [body.sphere(radius) for body in bodies])
    return s, {f"f{i}_x": 0.25 * i for i in range(n)}


def test_many_pairs_need_time_steps():
    s, start = row(50)
    with pytest.raises(fb.errors.SimulationError, match='more than 1200 points.*Take method="timestepping"'):
        fb.simulate(s, 1, initial=start)


def test_members_that_begin_inside_each_other():
    s, start = row(3)
    with pytest.raises(fb.errors.SimulationError, match=r"contact 'row\[b0,b1\]' 0.05 m deep"):
        fb.simulate(s, 1, initial=start | {"f1_x": 0.15}, method="timestepping", step=0.01)


def test_a_contact_that_is_no_pair():
    s, start = row(3)
    motion = fb.simulate(s, 0.01, initial=start, method="timestepping", step=0.01)
    with pytest.raises(fb.errors.SimulationError, match=r"such as 'row\[b0,b2\]'"):
        motion.contacts["row[b0,b9]"]
    with pytest.raises(fb.errors.SimulationError, match="Unknown contact 'floor'"):
        motion.contacts["floor"]


@pytest.mark.parametrize("method", [{}, {"method": "timestepping", "step": 0.01}], ids=["events", "steps"])
@pytest.mark.parametrize(
    ("output", "text"),
    [
        ("row[b0,bb1].gap", r"Unknown contact 'row\[b0,bb1\]' in output .*; did you mean 'row\[b0,b1\]'\?"),
        ("roww[b2,b1].gap", r"; did you mean 'row\[b2,b1\]'\?"),
        ("row[b0,b0].gap", r"has the names of two members that may touch, such as 'row\[b0,b2\]'"),
        ("row[b0,b1].gp", r"Unknown quantity 'gp' of contact 'row\[b0,b1\]'; did you mean 'gap'\?"),
        ("row[b0,b1].gap.1", r"Expected 'row\[b0,b1\].gap', which has no components"),
    ],
)
def test_outputs_of_pairs(method, output, text):
    s, start = row(3)
    with pytest.raises(fb.errors.SimulationError, match=text):
        fb.simulate(s, 0.01, initial=start, **method)[output]


def test_displacements_that_are_not_linear():
    s = fb.System("crank")
    q = s.coordinates("q")
    a, b = (s.body(name, fb.sphere(1, 0.1)) for name in "ab")
    s.hinge("pin", s.ground, a, axis="z", coordinate=q)
    s.slider("rail", s.ground, b, axis="x", coordinate="q**2")
    s.contacts("all", [a.sphere(0.1), b.sphere(0.1, at=(1, 0, 0))])
    with pytest.raises(fb.errors.SimulationError, match="displacement of joint 'rail' is not linear in q"):
        fb.simulate(s, 0.01, method="timestepping", step=0.01)


def test_solids_that_begin_inside_each_other_are_named_as_a_pair():
    s = fb.System("two")
    bodies = [s.body(f"d{i}", fb.box(0.01, (0.02,) * 3)) for i in range(2)]
    for i, body in enumerate(bodies):
        s.free(f"f{i}", s.ground, body)
    s.contacts("all", [body.box((0.02,) * 3) for body in bodies])
    with pytest.raises(fb.errors.SimulationError, match=r"contact 'all\[d0,d1\]' 0.00080\d+ m deep"):
        fb.simulate(s, 0.1, initial={"f1_z": 0.026, "f1_e0": 0.9, "f1_e1": 0.3, "f1_e2": 0.2})
