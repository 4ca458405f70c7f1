"""Base parameters of machines in books."""

from __future__ import annotations

import freebody as fb

BALL = fb.MassProperties(1, (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))


def two_links():
    s = fb.System("arm")
    s.parameters("g L1 L2")
    s.gravity = (0, "-g", 0)
    upper, fore, hand = (s.body(name, BALL) for name in ("upper", "fore", "hand"))
    s.hinge("shoulder", s.ground, upper, axis="z")
    s.hinge("elbow", upper, fore, at=("L1", 0, 0), axis="z")
    s.hinge("wrist", fore, hand, at=("L2", 0, 0), axis="z")
    return s


def test_a_plane_arm_as_in_the_books():
    """Khalil and Dombre, Modeling, identification and control of robots (2002), section 9.4."""
    base = fb.base_parameters(two_links())
    assert base.text().splitlines()[:9] == [
        "upper.hx   =  upper.hx + L1*fore.m + L1*hand.m",
        "upper.hy   =  upper.hy",
        "upper.Izz  =  upper.Izz + L1^2*fore.m + L1^2*hand.m",
        "fore.hx    =  fore.hx + L2*hand.m",
        "fore.hy    =  fore.hy",
        "fore.Izz   =  fore.Izz + L2^2*hand.m",
        "hand.hx    =  hand.hx",
        "hand.hy    =  hand.hy",
        "hand.Izz   =  hand.Izz",
    ]
    assert r"\beta_{1} &= h_{x, \mathrm{upper}} + L_{1} m_{\mathrm{fore}}" in base.latex()
    assert "svg" in base.html()
    assert "upper.m" in base.without_influence and "fore.m" not in base.without_influence
    assert base.matrix({"g": 9.81, "L1": 2, "L2": 3})[0, 10] == 2


def test_a_free_body_shows_all_ten():
    s = fb.System("stone")
    s.gravity = (0, 0, -1)
    s.free("air", s.ground, s.body("stone", BALL))
    assert len(fb.base_parameters(s).names) == 10 and "without" not in fb.base_parameters(s).text()
