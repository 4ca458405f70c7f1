"""Bodies wedged between contacts: forces that the motion does not determine hold them up to the exact limit."""

import numpy as np
import pytest

import freebody as fb

G, MASS, RADIUS = 9.81, 2.0, 0.2


def groove(beta, mu, **load):
    """A disk in a groove whose sides are tilted by ``beta`` and may be driven, under a force or a couple that grows."""
    s = fb.System("groove")
    s.gravity = (0, -G, 0)
    sides, disk = s.ground, s.body("disk", fb.disk(MASS, RADIUS))
    s.planar("plane", s.ground, disk, coordinate="x y a")
    if "drive" in load:
        sides = s.body("sides", fb.particle(1))
        s.slider("rail", s.ground, sides, axis="x", coordinate=load["drive"])
    for side, sign in (("left", 1), ("right", -1)):
        normal = (sign * np.sin(beta), np.cos(beta), 0)
        s.contact(side, disk.circle(RADIUS), sides.plane(normal=normal), friction=mu)
    s.force("F", disk.origin, (load.get("force", 0), 0, 0))
    s.torque("M", disk, (0, 0, load.get("couple", 0)))
    return s, {"y": RADIUS / np.cos(beta)}


@pytest.mark.parametrize(("beta", "mu"), [(0.5, 0.2), (0.5, 0.5), (0.8, 0.9), (1.1, 0.5)])
def test_a_disk_in_a_groove_turns_where_both_sides_slip(beta, mu):
    """M = μ R W/((1 + μ²) cos β), from T = μ N at both sides; equal compliance from zero is at its limits all along."""
    s, start = groove(beta, mu, couple="t")
    limit = mu * RADIUS * MASS * G / ((1 + mu * mu) * np.cos(beta))
    motion = fb.simulate(s, 1.2 * limit, initial=start)
    begins = [e.time for e in motion.events if "slip" in e.text]
    # asked by steps of the speeds of 1e-6 s
    assert begins and min(begins) == pytest.approx(limit, abs=2e-6)
    assert np.abs(motion["a"][motion.t < limit - 1e-3]).max() < 1e-12
    assert motion["a'"][-1] > 0 and np.abs(motion["x"]).max() < 1e-9
    assert motion.energy.relative_residual < 1e-9


@pytest.mark.parametrize("drive", ["2*t", "0.3*sin(5*t)"])
def test_a_disk_in_a_groove_that_moves(drive):
    """At a constant speed its limit is that at rest; the work of the drive is in the ledger either way."""
    s, start = groove(0.5, 0.3, couple="t", drive=drive)
    limit = 0.3 * RADIUS * MASS * G / ((1 + 0.3**2) * np.cos(0.5))
    speed = 2.0 if drive == "2*t" else 1.5
    motion = fb.simulate(s, 1.1 * limit, initial=start | {"x'": speed})
    assert motion.energy.relative_residual < 1e-9
    assert motion.modes[0].start == 0 and motion.modes[0].mode == "stick"
    if drive == "2*t":
        begins = [e.time for e in motion.events if "slip" in e.text]
        assert min(begins) == pytest.approx(limit, abs=2e-6)


def test_a_disk_is_pushed_out_of_a_groove():
    """F = W tan β turns it out over one side, whatever friction holds at the other until then."""
    for mu in (0.2, 0.5):
        s, start = groove(0.5, mu, force="t")
        limit = MASS * G * np.tan(0.5)
        motion = fb.simulate(s, limit + 0.3, initial=start)
        opened = [e.time for e in motion.events if e.text.startswith("contact left") and "→ open" in e.text]
        assert opened == pytest.approx([limit], abs=2e-6)


def bowl(mass, mu, tilt=0.0, force=0, radius=3.0):
    """A box that stands on two corners in a round bowl; its start, and normals and tangents as columns of (x, y, a)."""
    s = fb.System("bowl")
    s.gravity = (0, -G, 0)
    box = s.body("box", fb.box(mass, (0.5, 0.3, 0.2)))
    s.planar("plane", s.ground, box, coordinate="x y a")
    surface = s.ground.circle(radius, at=(0, radius, 0), inside=True)
    s.contact("c", box.corners((-0.25, -0.15, 0), (0.25, -0.15, 0)), surface, friction=mu)
    s.force("F", box.origin, (force, 0, 0))
    centre = np.sqrt(radius**2 - 0.25**2) - 0.15
    start = {"x": centre * np.sin(tilt), "y": radius - centre * np.cos(tilt), "a": tilt}
    rows = []
    for corner in (-0.25, 0.25):
        r = np.array([[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]]) @ (corner, -0.15)
        n = np.array([-start["x"], radius - start["y"]]) - r
        n = n / np.linalg.norm(n)
        for d in (n, np.array([n[1], -n[0]])):
            rows.append([*d, r[0] * d[1] - r[1] * d[0]])
    return s, start, np.array(rows).T


@pytest.mark.parametrize("tilt", [0.0, 0.02, 0.3])
def test_a_box_stands_in_a_bowl(tilt):
    s, start, _ = bowl(3.0, 0.68, tilt)
    motion = fb.simulate(s, 1, initial=start)
    assert {span.mode for span in motion.modes} == {"stick"} and not motion.events
    assert np.abs(motion["x"] - start["x"]).max() < 1e-12
    assert np.isnan(motion.contacts["c_1"].normal).all() and motion.indeterminate


def test_shares_of_open_forces_do_not_depend_on_units():
    """1,000 times the mass, 1,000 times each force; the normals are not parallel, so N and T share."""
    light, heavy = (fb.simulate(s, 0.1, initial=start) for s, start, _ in (bowl(3.0, 0.68), bowl(3e3, 0.68)))
    for name in ("c_1", "c_2"):
        first, second = (m.contacts[name].least[-1] for m in (light, heavy))
        np.testing.assert_allclose(second, 1e3 * first, rtol=1e-9)


@pytest.mark.parametrize(("tilt", "mu", "way"), [(0.0, 0.3, 1), (0.3, 0.3, 1), (0.3, 0.68, -1)])
def test_a_box_is_pushed_along_a_bowl_where_both_corners_slip(tilt, mu, way):
    s, start, columns = bowl(3.0, mu, tilt, f"{way}*t")
    # N_1, N_2 and F of T = -way μ N at both corners
    slips = columns[:, 0::2] - way * mu * columns[:, 1::2]
    *N, limit = np.linalg.solve(np.column_stack([slips, [way, 0, 0]]), [0, 3.0 * G, 0])
    assert min(N) > 0
    motion = fb.simulate(s, limit + 0.5, initial=start)
    begins = [e.time for e in motion.events if "stick → slip" in e.text]
    assert begins[:2] == pytest.approx([limit, limit], abs=1e-8)


def test_a_slip_at_its_dead_centre_stops_nothing():
    """The tip of a rod on a wall reverses at its lowest point, where it grazes a floor: speeds do not jump there."""
    s = fb.System("rod at its dead centre")
    s.gravity = (0, -G, 0)
    top, rod = s.body("top", fb.particle(1)), s.body("rod", fb.slender_bar(1, 0.5, axis="y"))
    s.slider("rail", s.ground, top, axis="x", coordinate="x")
    s.hinge("pin", top, rod, to=(0, 0.25, 0), axis="z", coordinate="q")
    tip = rod.point(0, -0.25, 0)
    s.force("press", tip, (-100, 0, 0), frame=s.ground)
    s.contact("floor", tip, s.ground.plane(at=(0, -0.5, 0)), friction=0)
    s.contact("wall", tip, s.ground.plane(at=(-0.9, 0, 0), normal="x"), friction=0.1)
    start = {"x": -0.9 + 0.5 * np.sin(0.12) + 0.001, "q": -0.12, "x'": -3.6, "q'": 6.0}
    motion = fb.simulate(s, 0.2, initial=start)
    (turned,) = [e for e in motion.events if "slip + → slip -" in e.text]
    assert abs(turned.state["q"]) < 1e-9
    assert motion.at(turned.time + 1e-6)["q'"] == pytest.approx(turned.state["q'"], rel=1e-3)
    assert motion.energy.impulses[-1] == pytest.approx(
        motion.energy.impulses[motion.t < turned.time][-1], abs=1e-9
    )


def flat_leg():
    """A trunk and a bent leg whose hip, foot and far corner are in line on the floor; a couple lifts the hip."""
    s = fb.System("leg that lies flat")
    s.gravity = (0, -G, 0)
    floor = s.ground.plane(normal="y")
    trunk = s.body("trunk", fb.box(3, (0.4, 0.2, 0.2)))
    thigh, shank = (s.body(name, fb.slender_bar(0.5, 0.4, axis="y")) for name in ("thigh", "shank"))
    s.planar("plane", s.ground, trunk, coordinate="x y a")
    s.hinge("hip", trunk, thigh, at=(0, -0.1, 0), to=(0, 0.2, 0), axis="z", coordinate="h")
    knee = s.hinge("knee", thigh, shank, at=(0, -0.2, 0), to=(0, 0.2, 0), axis="z", coordinate="k")
    s.stop("straight", knee, low=-1.2)
    s.contact("foot", shank.point(0, -0.2, 0), floor, friction=1)
    s.contact("back", trunk.point(-0.2, -0.1, 0), floor, friction=1)
    s.contact("front", trunk.point(0.2, -0.1, 0), floor, friction=1)
    s.torque("T", thigh, (0, 0, "20*t"), reaction_on=trunk)
    return s, {"y": 0.1, "h": 0.6 - np.pi / 2, "k": -1.2}


def test_a_leg_that_lies_flat_gives_way_where_friction_is_least():
    """At the dead centre foot, knee and corner hold the hip in no way; beside it with forces beyond all limits."""
    s, start = flat_leg()
    motion = fb.simulate(s, 0.6, initial=start)
    (lifted,) = [e for e in motion.events if "back: stick → open" in e.text]
    # N of the back is zero: m g = N_foot + N_front; of the trunk T = w N_front; of the leg, whose bars have their mass
    # centres at a quarter and three quarters of its length, N_foot l = T + (1/4 + 3/4) m g l
    couple = G * (4 - 0.5 / 4 - 0.5 * 3 / 4) / (1 / 0.2 + 1 / (0.8 * np.cos(0.6)))
    assert lifted.time == pytest.approx(couple / 20, rel=1e-9)
    (slips,) = [e for e in motion.events if "foot: stick → slip" in e.text]
    assert slips.time == pytest.approx(lifted.time, abs=1e-12)
    assert np.abs(motion.energy.residual).max() < 1e-8
    names = "xyahk"
    stepped = [fb.simulate(s, 0.6, initial=start, method="timestepping", step=h) for h in (1e-3, 5e-4)]
    off = [max(abs(m[n][-1] - motion[n][-1]) for n in names) for m in stepped]
    assert off[1] < 0.6 * off[0] < 2e-3


def test_two_corners_that_sink_never_stick_while_the_box_turns():
    """Flat on a soft floor both corners have one speed along it; a box that turns has two, and one of them slips."""
    s = fb.System("box on a soft floor")
    s.gravity = (0, -9.81, 0)
    box = s.body("box", fb.box(2, (0.5, 0.2, 0.2)))
    s.planar("p", s.ground, box, coordinate="x y a")
    soft = {"friction": 0.6, "normal": "9000*depth*(1 + 0.2*rate)"}
    s.contact("c", box.corners(size=(0.5, 0.2)), s.ground.plane(normal="y"), **soft)
    s.force("F", box.point(0, 0.05, 0), ("8*sin(20*t)", 0, 0), frame=s.ground)
    motion = fb.simulate(s, 0.2, initial={"y": 0.1 - 9.81 / 9000})
    assert motion.energy.relative_residual < 1e-9
    for corner in motion.contacts.values():
        sticks = corner.mode == "stick"
        assert np.abs(corner.slip[sticks]).max(initial=0) < 1e-9


@pytest.mark.parametrize(("leg_mass", "bound", "taken"), [(1, 4, 0), (3, 0.5, 0.5)])
def test_a_table_with_a_leg_that_friction_holds_slides_by_equal_compliance(leg_mass, bound, taken):
    """N of two corners and of a leg in a dry slide are open, and each share brakes by another friction.

    They are among many motions, not Painlevé's two. The least forces, with N of top and leg in all 2 g + T and m g - T,
    have T = 0 for a leg of 1 kg, and T at its bound for one of 3 kg. The table stops after v²/2a.
    """
    s = fb.System("table")
    s.gravity = (0, -9.81, 0)
    top, leg = s.body("top", fb.box(2, (0.4, 0.2, 0.2))), s.body("leg", fb.box(leg_mass, (0.1, 0.3, 0.1)))
    s.planar("p", s.ground, top, coordinate="x y a")
    slide = s.slider("slide", top, leg, axis="y", coordinate="z")
    s.friction("dry", slide, force=bound)
    floor = s.ground.plane(normal="y")
    s.contact("low", top.corners(size=(0.4, 0.2)), floor, friction=0.2)
    s.contact("foot", leg.point(0, -0.15, 0), floor, friction=0.5)
    start = {"y": 0.1, "z": 0.05, "x'": 1}
    motion = fb.simulate(s, 0.5, initial=start)
    braking = 0.2 * (2 * 9.81 + taken) + 0.5 * (leg_mass * 9.81 - taken)
    assert motion["x"][-1] == pytest.approx((2 + leg_mass) / (2 * braking), rel=1e-9)
    assert {"N_foot", "N_low_1", "N_low_2"} <= set(motion.indeterminate)
    with pytest.raises(fb.FreebodyError, match="statically indeterminate"):
        fb.simulate(s, 0.5, initial=start, indeterminate="refuse")
