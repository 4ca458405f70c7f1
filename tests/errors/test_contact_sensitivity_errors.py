"""Messages of derivatives of motions with contacts: what has none, from when on, why, and the cure."""

import math
import re
from types import SimpleNamespace

import pytest

import freebody as fb
from contact_machines import pulled_disk
from freebody.errors import NoDerivativesError, SimulationError
from freebody.motion.contact.derivatives.saltation import check_modes
from freebody.motion.phase.phase import LIMIT

G = 9.81


def boxes(count=1, height=0.5, **laws):
    """Particles above a floor, each on a vertical rail."""
    s = fb.System("boxes")
    e, g = s.parameters(e=0.5, g=G)
    s.gravity = (0, -g, 0)
    for k in range(count):
        body = s.body(f"b{k}", fb.particle(1))
        s.slider(f"rail{k}", s.ground, body, axis="y", coordinate=f"y{k}")
        s.contact(f"c{k}", body.origin, s.ground.plane(normal="y"), **{"restitution": e, **laws})
    return s, {f"y{k}": height for k in range(count)}


def refused(s, first, unknowns, message, until=1, **options):
    with pytest.raises(SimulationError, match=message):
        fb.simulate(s, until, initial=first, sensitivities=unknowns, **options)


def test_machines_without_derivatives():
    s, start = boxes()
    refused(s, start, ["e"], "got method='timestepping'", method="timestepping", step=1e-3)
    s, start = boxes()
    message = "a start at a fixed time for sensitivities= with contacts, got start='g'"
    refused(s, start, ["g"], message, until=20, start="g")


def test_laws_of_contacts_that_jump():
    s, start = boxes(friction="3/10 + 1/10*sign(y0 - 1)")
    message = (
        r"^Expected laws of contacts that do not jump for sensitivities=, but that of 'c0' has a sign\(...\), where "
        r"the rates jump. Write tanh\(x/width\) for sign\(x\). Or take differences of runs with values= that differ.$"
    )
    refused(s, start, ["e"], message)


def test_a_switch_that_no_step_sees():
    """Under a force k it comes down to x = -1e-4, below which the force is -5 k; a step leads from x > 0 to x > 0."""
    s, start = boxes(height=1.0)
    body = s.body("block", fb.particle(1))
    s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.force("law", body, ("300*sign(x) - 200", 0, 0))
    message = (
        r"after t = (\S+) s, where a law switches as x passes zero: its steps do not see it. End the run"
    )
    with pytest.raises(NoDerivativesError, match=message) as caught:
        fb.simulate(s, 0.3, initial=start | {"x": 0.5, "x'": -math.sqrt(100.01)}, sensitivities=["y0"])
    begins = float(re.search(message, str(caught.value))[1])
    assert 0 <= begins < (math.sqrt(100.01) - 0.1) / 100  # the step begins before x = 0


def test_events_that_have_no_derivative():
    s, start = boxes(2)
    message = (
        r"The motion of 'boxes' has no derivatives by the unknowns of sensitivities= after t = 0.3192\d* s: "
        "contact 'c0' and contact 'c1' come at the same time, but move apart if 'y0' changes. Ask for the derivatives "
        "of a motion that ends before"
    )
    refused(s, start, ["y0"], message)
    both = fb.simulate(s, 0.6, initial=start, sensitivities=["g"], samples=2)  # they go on together
    assert both.sensitivity["y0", "g"][-1] == pytest.approx(both.sensitivity["y1", "g"][-1], rel=1e-9)
    s, start = boxes(height=0.0)
    refused(s, start, ["y0"], r"after t = 0 s: contact 'c0' \(slip\) would close or open if 'y0' changed")
    s, start = boxes(height=0.0)
    refused(s, start | {"y0'": -1.0}, ["y0"], "contact 'c0' begins closed, and would not if 'y0' changed")


def test_a_contact_that_only_touches():
    """A stone thrown up under a ceiling reaches it with hardly any speed."""
    s = fb.System("stone")
    g = s.parameters(g=G)
    s.gravity = (0, -g, 0)
    stone = s.body("stone", fb.particle(1))
    s.slider("rail", s.ground, stone, axis="y", coordinate="y")
    s.contact("ceiling", stone.origin, s.ground.plane(at=(0, 1, 0), normal=(0, -1, 0)))
    refused(
        s, {"y'": (2 * G + 1e-6) ** 0.5}, ["y'"], "contact 'ceiling' only touches there, with the rate -0.001"
    )


def test_ties():
    """At the angle of friction a block neither sticks nor slips."""
    s = fb.System("block")
    F, mu = s.parameters(F=0.3 * G, mu=0.3)
    s.gravity = (0, -G, 0)
    block = s.body("block", fb.particle(1))
    rail = s.body("rail", fb.particle(1))
    s.slider("along", s.ground, rail, axis="x", coordinate="x")
    s.slider("up", rail, block, axis="y", coordinate="y")
    s.force("F", block.origin, (F, 0, 0))
    s.contact("foot", block.origin, s.ground.plane(), friction=mu)
    refused(s, {}, ["mu"], "contact 'foot' sticks exactly at its limit of friction")


def test_a_corner_at_its_limit_of_friction():
    """A box that is pushed beside its middle: as a corner reaches its limit, all slip, by kinetic friction."""
    s = fb.System("box")
    F = s.parameters(F=20.0)
    s.gravity = (0, 0, -G)
    box = s.body("box", fb.box(2, (0.4, 0.3, 0.2)))
    s.free("f", s.ground, box)
    corners = [(x, y, -0.1) for x in (-0.2, 0.2) for y in (-0.15, 0.15)]
    s.contact("floor", box.corners(*corners), s.ground.plane(normal="z"), friction=0.3, static_friction=0.36)
    s.force("push", box.point((0, 0.03, 0.02)), (F * s.t, 2 * s.t, 0), frame=s.ground)
    refused(s, {"f_z": 0.1}, ["F"], "after t = 0.322.*: the forces of contacts jump there")


def test_a_contact_at_its_limit_that_others_hold():
    """Phases have this mode where a bounded force acts at a contact; steps of the speeds decide elsewhere."""
    slopes = SimpleNamespace(model=SimpleNamespace(name="box", contacts=[SimpleNamespace(name="foot")]))
    with pytest.raises(
        NoDerivativesError, match="contact 'foot' rests at its limit of friction, held by the others"
    ):
        check_modes(slopes, SimpleNamespace(modes=[f"{LIMIT} 0"]), 1.0, 0)


def test_a_joint_that_bears_nothing():
    s = fb.System("wheel")
    s.parameters(mu=0.2)
    wheel = s.body("wheel", fb.disk(1, 0.5))
    pin = s.hinge("pin", s.ground, wheel, axis="z", coordinate="q")
    s.friction("rub", pin, coefficient="mu", radius=0.02)
    refused(s, {"q'": 1.0}, ["mu"], "contact 'rub' is closed without force")


def test_impacts_by_poissons_law_under_the_load_of_a_joint():
    s = fb.System("arm")
    s.parameters(mu=0.2)
    s.gravity = (0, -G, 0)
    bar = s.body("bar", fb.slender_bar(1, 1, axis="y"))
    pin = s.hinge("pin", s.ground, bar, to=(0, 0.5, 0), axis="z", coordinate="q")
    s.friction("rub", pin, coefficient="mu", radius=0.02)
    side = s.ground.plane(at=(0.2, 0, 0), normal="-x")
    s.contact("wall", bar.point((0, -0.5, 0)), side, restitution=0.5, impact="poisson")
    message = (
        "the impulse of contact 'wall' in the compression of an impact is open, since others stop the same motion, and "
        "decides its rebound"
    )
    refused(s, {"q": -0.5}, ["mu"], message)


def slider_struck_at(place):
    """A box on a dry rail, and a blow on it at a place along the rail."""
    s = fb.System("slider")
    s.parameters(mu=0.3, L=0.2)
    box = s.body("box", fb.box(2, (0.3, 0.2, 0.2)))
    rail = s.slider("rail", s.ground, box, axis="x", coordinate="x")
    s.friction("dry", rail, coefficient="mu", length="L")
    s.force("weight", box.origin, (0, -20, 0))
    return s, fb.blow(0.05, at=box.point(place, 0, 0), impulse=(0, 2, 0))


def test_loads_of_joints_that_do_not_settle(monkeypatch):
    monkeypatch.setattr("freebody.motion.contact.derivatives.impact_stages.PASSES", 1)
    s, hit = slider_struck_at(0.05)
    message = "after t = 0.05 s: the loads of joints with friction 'dry' do not settle in an impact"
    refused(s, {"x'": 1.0}, ["mu"], message, until=0.2, impulses=[hit])


def on_a_table(shape, **laws):
    s = fb.System("table")
    s.parameters(a=0.1, mu=0.3)
    s.gravity = (0, 0, -G)
    body = s.body("b", fb.box(1, (0.2, 0.1, 0.1)))
    s.free("f", s.ground, body)
    s.contacts("c", [shape(body), s.ground.box((0.4, 0.4, 0.2))], friction="mu", **laws)
    return s


def test_solids_whose_faces_touch():
    s = on_a_table(lambda body: body.box((0.2, "a", 0.1)))
    message = "unknowns that are no sizes of solids whose faces touch, but 'a' is one of the box of body 'b'"
    refused(s, {"f_z": 0.2}, ["a"], message)
    s = on_a_table(lambda body: body.sphere(0.05))
    message = "solids touch at other corners, edges or faces from there on, which changes their forces at a time that"
    refused(s, {"f_z": 0.15, "f_vx": 0.9, "f_wy": 18.0}, ["f_vx"], message)
    s.parameters(u=0.0)
    s.controller(lambda t, x: 0.0, 0.1, "u", name="law")
    s.force("push", s.bodies["b"].origin, ("u", 0, 0))
    refused(
        s, {"f_z": 0.2}, ["mu"], "round shapes for sensitivities= beside signals and controllers, but faces"
    )


def test_a_blow_over_a_bearing_of_a_joint():
    """It falls at one of the two places of the rail; the other one bears nothing."""
    s, hit = slider_struck_at(0.1)
    message = (
        "one place of the joint with friction 'dry' bears no impulse there, and would if an unknown changed"
    )
    refused(s, {"x'": 1.0}, ["L"], message, until=0.2, impulses=[hit])


def test_impacts_one_after_another_of_which_none_is_first():
    s = fb.System("bar")
    g = s.parameters(g=G)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(1, 1))
    s.planar("plane", s.ground, bar, coordinate="x y w")
    s.contact("feet", bar.corners((-0.5, 0, 0), (0.5, 0, 0)), s.ground.plane(), restitution=0.5)
    message = (
        "contacts 'feet_1' and 'feet_2' approach equally fast, and which one collides first decides the rest"
    )
    refused(s, {"y": 0.5}, ["g"], message, impacts="sequential")


def pushed(law, **options):
    """A cart that a controller pushes by a gain k."""
    s = fb.System("cart")
    s.parameters(k=4.0, u=0.0, T=0.1)
    cart = s.body("cart", fb.particle(2))
    s.force("push", s.slider("rail", s.ground, cart, axis="x", coordinate="x"), "u")
    s.controller(law, "T", "u", name="law")
    return s


def test_controllers_without_derivatives():
    start = {"x": 0.1}
    message = (
        "Controller 'law' has no derivatives by the unknowns of sensitivities= at t = 0 s: TypeError: must be real "
        "number.* take arithmetic and NumPy's functions, such as np.sin\\(x\\), which keep them, in place of math"
    )
    refused(pushed(lambda t, x: math.sin(x["k"] * x["x"])), start, ["k"], message)
    tie = "ArithmeticError: it compares 0.1 with the same number, and a derivative decides"
    refused(pushed(lambda t, x: -1.0 if x["x"] >= 0.1 else 1.0), start, ["x"], tie)
    calls = []

    def counted(t, x):
        calls.append(t)
        return -x["k"] * x["x"] * len(calls)

    message = (
        "Controller 'law' gave -0.4 for 'u' at t = 0 s, and -4.4 when its function was called once more for the "
        "derivatives of sensitivities=. It remembers something of another run: give it a method reset\\(\\)"
    )
    refused(pushed(counted), start, ["k"], message, until=0.95)
    other = "one of 'auto', .* for sensitivities= beside signals, controllers or blows, got method='taylor'"
    refused(pushed(lambda t, x: 0.0), start, ["k"], other, method="taylor")


def test_samples_and_blows_that_pass_the_end():
    s = pushed(lambda t, x: -x["k"] * x["x"])
    message = (
        "after t = 1 s: a sample of controller 'law' and the end of the run come at the same time, but .* 'T'"
    )
    refused(s, {"x": 0.1}, ["T"], message)
    fb.simulate(s, "10*T", initial={"x": 0.1}, sensitivities=["T"])  # the end moves with the sample
    s, start = boxes()
    s.parameters(T=0.1)
    kick = fb.blow("T", at=s.bodies["b0"], impulse=(0, 1, 0), name="kick")
    message = (
        "after t = 0.1 s: blow 'kick' and the end of the run come at the same time, but move apart if 'T'"
    )
    refused(s, start, ["T"], message, until=0.1, impulses=[kick])


def test_blows_without_derivatives():
    s, start = boxes()
    b = s.bodies["b0"]
    both = fb.blow(0.1, at=b, moment=(0, 0, 1), normal=(0, 1, 0), restitution=0.5, name="kick")
    refused(
        s, start, ["e"], "a blow with restitution= or with moment= .* but 'kick' has both", impulses=[both]
    )
    s, start = boxes()
    top = fb.blow("(y0 - 0.5)**3", at=s.bodies["b0"], impulse=(0, 1, 0), name="kick")
    message = "after t = 0.05.* s: what calls for blow 'kick' only touches zero there"
    refused(s, {"y0": 0.3, "y0'": 4.0}, ["y0"], message, impulses=[top])


def test_quantities_without_derivatives():
    s = pulled_disk()
    motion = fb.simulate(s, 0.2, initial={"x'": 3.0}, sensitivities=["mu"], samples=3)
    with pytest.raises(SimulationError, match="one of kinetic_energy, .* got 'max\\(floor.normal\\)'"):
        motion.sensitivity["max(floor.normal)", "mu"]
    s, start = boxes(height=1.0)  # with e = 1 it comes back to its height, which then depends on e
    bounces = fb.simulate(s, 1.2, initial=start, values={"e": 1.0}, sensitivities=["e"])
    message = (
        "one derivative of 'max\\(y0\\)' by 'e', but the run reaches 1 at t = 0 s and at t = 0.903.* s alike"
    )
    with pytest.raises(NoDerivativesError, match=message):
        bounces.sensitivity["max(y0)", "e"]
    for quantity in ("work", "floor.mode", "plane.force"):
        with pytest.raises(
            SimulationError, match=f"one of kinetic_energy, .* with contacts, got '{quantity}'"
        ):
            motion.sensitivity[quantity, "mu"]
    with pytest.raises(SimulationError, match="Unknown event 'flor' .* did you mean 'floor'"):
        motion.sensitivity.times("flor")


def test_a_motion_with_derivatives_is_not_saved(tmp_path):
    motion = fb.simulate(pulled_disk(), 0.2, sensitivities=["mu"], samples=3)
    with pytest.raises(SimulationError, match="without sensitivities= for a file, got one with derivatives"):
        motion.save(tmp_path / "motion.nc")
