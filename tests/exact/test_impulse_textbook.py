"""Impulses of the chapter's problems, against closed forms worked out by hand."""

import math

import pytest
import sympy

import freebody as fb


def test_problem_6_4_centre_of_percussion():
    s = fb.System("struck bar")
    m, L, F, h = s.parameters(m=2, L=1.2, F=100, h=0.2)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    pin = s.hinge("O", s.ground, bar, to=(0, L / 2, 0), coordinate="theta")
    assert fb.centre_of_percussion(s, pin) == 2 * L / 3
    hit = fb.impulse(s, at=bar.point(0, L / 2 - h, 0), impulse=(F, 0, 0), initial={"theta": 0, "theta'": 0})
    assert hit.solve("O_x = 0", for_="h")["h"] == 2 * L / 3
    # reaction F (3 h/(2 L) - 1), angular acceleration 3 F h/(m L²): forces and impulses obey one law
    for depth in (0.2, 0.8, 1.1):
        number = fb.impulse(
            s, at=bar.point(0, L / 2 - h, 0), impulse=(F, 0, 0), values={"h": depth}, initial={"theta": 0}
        )
        assert number.reactions["O"].impulse[0] == pytest.approx(100 * (1.5 * depth / 1.2 - 1), abs=1e-12)
        assert number.after["theta'"] == pytest.approx(3 * 100 * depth / (2 * 1.2**2), rel=1e-14)
    # the same question put to the free-body equations under a steady force
    s.force("blow", bar.point(0, L / 2 - h, 0), (F, 0, 0))
    still = fb.equations(s).solve(["h", "theta''"], where={"theta": 0, "theta'": 0, "O_x": 0})
    assert still["h"] == 2 * L / 3
    assert sympy.simplify(still["theta''"] - 2 * F / (m * L)) == 0


def test_problem_6_17_satellite():
    s = fb.System("satellite")
    I1, I3, J, d, spin, M = s.parameters(I1=1600, I3=2000, J=300, d=1.68, spin="5*pi", M=500)
    drum = s.body("drum", fb.MassProperties(M, (0, 0, 0), ((I1, 0, 0), (0, I1, 0), (0, 0, I3))))
    s.free("space", s.ground, drum)
    at_rest = {"space": (1, 0, 0, 0), "space_x": 0, "space_y": 0, "space_z": 0}
    at_rest |= {f"space_{v}": 0 for v in ("wx", "wy", "vx", "vy", "vz")} | {"space_wz": spin}
    hit = fb.impulse(s, at=drum.point(0, d, 0), impulse=(0, 0, J), frame=drum, initial=at_rest)
    assert hit.after["space_wx"] == J * d / I1
    assert hit.after["space_wy"] == 0 and hit.after["space_wz"] == spin
    assert hit.after["space_vz"] == J / M
    number = fb.impulse(
        s,
        at=drum.point(0, d, 0),
        impulse=(0, 0, J),
        initial=hit.initial | {"space_wx": 0, "space_vz": 0},
        values={},
    )
    assert number.after["space_wx"] == pytest.approx(0.315, rel=1e-14)
    # what follows: precession about H at |H|/I_1, the body cone at (I_3 - I_1) w3/I_1
    w1, w3, I_1, I_3 = 0.315, 5 * math.pi, 1600, 2000
    motion = fb.simulate(s, until=1, initial=number.initial, values={}, tolerance=1e-11)
    rate = (I_3 - I_1) / I_1 * w3
    assert motion["space_wx"][-1] == pytest.approx(w1 * math.cos(rate), abs=1e-9)
    assert motion["space_wy"][-1] == pytest.approx(w1 * math.sin(rate), abs=1e-9)
    assert sympy.simplify(hit.energy_change - J**2 * d**2 / (2 * I1) - J**2 / (2 * M)) == 0


def test_problem_6_21_gyroscope():
    s = fb.System("gyroscope")
    m, R, L, g, P, part = s.parameters(m=1.2, R=0.06, L=0.1, g=9.81, P=0.02, part=0.8)
    s.gravity = (0, 0, -g)
    rotor = s.body("rotor", fb.disk(m, R))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -L), axis="ZXZ", coordinate="psi theta phi")
    e = fb.equations(s)
    on_shaft = rotor.point(0, 0, (part - 1) * L)
    hit = fb.impulse(e, at=on_shaft, impulse=(P, 0, 0), initial={"psi": 0})
    # along xi nothing; about eta the moment impulse P·0.8 L: I_xi Δω_eta = part L P, with Δω_eta = Δψ' sin θ
    theta = sympy.Function("theta")(sympy.Symbol("t"))
    I_xi = m * R**2 / 4 + m * L**2
    assert hit.change["theta'"] == 0
    assert sympy.simplify(hit.change["psi'"] - part * L * P / (I_xi * sympy.sin(theta))) == 0
    # the spin about the shaft, φ' + ψ' cos θ, is unchanged
    assert sympy.simplify(hit.change["phi'"] + hit.change["psi'"] * sympy.cos(theta)) == 0
    # impulses on the shaft balance the change of momentum: m L Δω_eta - P along xi
    got = hit.reactions["pivot"].impulse
    assert sympy.simplify(got[0] - (m * L * part * L * P / I_xi - P)) == 0
    assert sympy.simplify(got[1]) == 0 and sympy.simplify(got[2]) == 0
    assert hit.reactions["pivot"].moment == sympy.zeros(3, 1)


@pytest.mark.parametrize("about", ["edge"])
def test_rolling_box_over_an_edge_loses_energy(about):
    # a block of half width b and half height h lands on the edge it turns about next: e = 0 there
    s = fb.System("rocking block")
    m, b, h = s.parameters(m=1, b=0.2, h=0.5)
    block = s.body("block", fb.box(m, (2 * b, 2 * h, 1)))
    s.hinge(about, s.ground, block, at=(b, 0, 0), to=(b, -h, 0), coordinate="theta")
    # turning about the right corner, the left one meets the floor
    w = sympy.Function("theta")(sympy.Symbol("t")).diff()
    left = fb.impulse(s, at=block.point(-b, -h, 0), normal=(0, 1, 0), restitution=0, initial={"theta": 0})
    # with the right corner held too, all motion ends
    assert left.after["theta'"] == 0
    inertia = m * (4 * b**2 + 4 * h**2) / 12 + m * (b**2 + h**2)
    assert sympy.simplify(left.energy_change + inertia * w**2 / 2) == 0
    free = fb.System("rocking block, free")
    m, b, h = free.parameters(m=1, b=0.2, h=0.5)
    block = free.body("block", fb.box(m, (2 * b, 2 * h, 1)))
    free.planar("air", free.ground, block, coordinate="x y theta")
    W = free.parameters(W=1)
    start = {"theta": 0, "theta'": W, "x'": -W * h, "y'": -W * b}
    smooth = fb.impulse(free, at=block.point(-b, -h, 0), normal=(0, 1, 0), restitution=0, initial=start)
    after = smooth.velocity(block.point(-b, -h, 0))[1]
    assert sympy.simplify(after[1]) == 0
    assert sympy.simplify(smooth.change["x'"]) == 0
