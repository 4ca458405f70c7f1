"""Contacts in given modes: which forces are of conditions, and which are loads."""

import freebody as fb
from freebody.model import assemble
from freebody.model.contact_modes import Pressing, Sliding, Touching, in_modes
from freebody.symbolic.derivation.contact_modes import modes_of


def machine(**laws):
    s = fb.System("ball")
    ball = s.body("ball", fb.sphere(1, 0.5))
    s.planar("air", s.ground, ball, coordinate="x y turn")
    s.contact("floor", ball.sphere(0.5), s.ground.plane(), friction=0.2, **laws)
    return assemble(s)


def sorts(model):
    return {name: type(part) for name, part in (*model.loads.items(), *model.constraints.items())}


def test_rigid_contacts_are_conditions():
    assert sorts(in_modes(machine(), {"floor": "slip+"})) == {"floor": Touching}
    assert sorts(in_modes(machine(), {"floor": "stick"})) == {"floor": Touching}


def test_the_normal_force_of_a_compliant_contact_is_a_load():
    model = machine(normal="100*depth")
    assert sorts(in_modes(model, {"floor": "slip-"})) == {"N_floor": Pressing, "T_floor": Sliding}
    assert sorts(in_modes(model, {"floor": "stick"})) == {"N_floor": Pressing, "floor": Touching}
    assert sorts(in_modes(model, {})) == {}
    for mode in ("slip+", "slip-", "stick", "open"):
        assert modes_of(in_modes(model, {"floor": mode})) == {"floor": mode}
