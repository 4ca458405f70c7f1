"""Base parameters of machines in books."""

from __future__ import annotations

from fractions import Fraction

import pytest
import sympy

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


PANDA = (  # α, d, r of each joint (modified Denavit-Hartenberg)
    (0, "0", "0.333"), (-1, "0", "0"), (1, "0", "0.316"), (1, "0.0825", "0"), (-1, "-0.0825", "0.384"), (1, "0", "0"),
    (1, "0.088", "0"),
)  # fmt: skip
UR5 = (
    (0, "0", "0.089159"), (1, "0", "0"), (0, "-0.425", "0"), (0, "-0.39225", "0.10915"), (1, "0", "0.09465"),
    (-1, "0", "0.0823"),
)  # fmt: skip
"""α in right angles; d and r in metres."""
PANDA_AS_PUBLISHED = """
1.Izz + 2.Iyy
2.Ixx - 2.Iyy + 3.Iyy + 0.099856*3.m + 0.632*3.hz + 0.10666225*4567
2.Ixy
2.Ixz
2.Iyz
2.Izz + 3.Iyy + 0.099856*3.m + 0.632*3.hz + 0.10666225*4567
3.Ixx - 3.Iyy + 4.Iyy - 0.00680625*4.m
3.Ixy + 0.0825*4.hz
3.Ixz
3.Iyz
3.Izz + 4.Iyy + 0.00680625*4.m + 0.0136125*567
4.Ixx - 4.Iyy + 5.Iyy + 0.768*5.hz + 0.14064975*567
4.Ixy + 0.03168*567 + 0.0825*5.hz
4.Ixz
4.Iyz
4.Izz + 5.Iyy + 0.768*5.hz + 0.15426225*567
5.Ixx - 5.Iyy + 6.Iyy + 0.007744*7.m
5.Ixy
5.Ixz
5.Iyz
5.Izz + 6.Iyy + 0.007744*7.m
6.Ixx - 6.Iyy + 7.Iyy - 0.007744*7.m
6.Ixy + 0.088*7.hz
6.Ixz
6.Iyz
6.Izz + 7.Iyy + 0.007744*7.m
7.Ixx - 7.Iyy
7.Ixy
7.Ixz
7.Iyz
7.Izz
2.hx
2.hy - 3.hz - 0.316*34567
3.hx + 0.0825*4567
3.hy - 4.hz
4.hx - 0.0825*567
4.hy + 5.hz + 0.384*567
5.hx
5.hy - 6.hz
6.hx + 0.088*7.m
6.hy - 7.hz
7.hx
7.hy
"""
"""The 43 coefficients of Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca (2019); 567 is the mass of links 5 to 7.

Theirs have moments about mass centres, I + m (c·c 1 - c cᵀ), for those about origins here.
"""

UR5_AS_PUBLISHED = """
1.Izz + 2.Iyy + 3.Iyy + 4.Iyy + 0.180625*3.m + 0.346398785*456 + 0.2183*4.hz
2.Ixx - 2.Iyy - 0.180625*3456
2.Ixy
2.Ixz + 0.425*3.hz + 0.425*4.hz + 0.04638875*456
2.Iyz
2.Izz + 0.180625*3456
2.hx - 0.425*3456
2.hy
3.Ixx - 3.Iyy - 0.1538600625*456
3.Ixy
3.Ixz + 0.0428140875*456 + 0.39225*4.hz
3.Iyz
3.Izz + 0.1538600625*456
3.hx - 0.39225*456
3.hy
4.Ixx - 4.Iyy + 5.Iyy + 0.0089586225*56 + 0.1893*5.hz
4.Ixy
4.Ixz
4.Iyz
4.Izz + 5.Iyy + 0.0089586225*56 + 0.1893*5.hz
4.hx
4.hy - 5.hz - 0.09465*56
5.Ixx - 5.Iyy + 6.Iyy + 0.00677329*6.m - 0.1646*6.hz
5.Ixy
5.Ixz
5.Iyz
5.Izz + 6.Iyy + 0.00677329*6.m - 0.1646*6.hz
5.hx
5.hy - 6.hz + 0.0823*6.m
6.Ixx - 6.Iyy
6.Ixy
6.Ixz
6.Iyz
6.Izz
6.hx
6.hy
"""
"""The minimal parameter vector of the family of arms S6RRRRRR10 in the library of serial robots by Schappler (Leibniz
University Hannover, github.com/SchapplM/robsynth-serroblib, in which the UR5 is a variant of it), at the UR5's lengths.

It allows gravity across the first axis too, for which two more parameters count, hx and hy of the first link. There the
last axis has the other sense, so that d is -0.0823 m.
"""


def robot(table):
    """Bodies named by their numbers, on hinges about their z axes."""
    s = fb.System("robot")
    s.gravity = (0, 0, -10)
    parent = s.ground
    for k, (quarter, d, r) in enumerate(table, 1):
        c, v = (0, quarter) if quarter else (1, 0)
        link = s.body(f"link{k}", BALL)
        at = (Fraction(d), -v * Fraction(r), c * Fraction(r))
        s.hinge(f"j{k}", parent, link, at=at, axis="z", parent_axes=((1, 0, 0), (0, c, -v), (0, v, c)))
        parent = link
    return fb.base_parameters(s)


def by_number(base):
    """Combinations with exact coefficients, by the numbers of the links."""
    return [
        {name.removeprefix("link"): Fraction(str(x)) for name, x in terms.items()}
        for terms in base.combinations.values()
    ]


def grouped(table):
    """Gautier and Khalil's rules for rotational joints: each takes I_yy, h_z and m of its link into the one before."""
    links = [
        {
            x: {f"{k}.{x}": Fraction(1)}
            for x in ["m", "hx", "hy", "hz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz"]
        }
        for k in range(1, len(table) + 1)
    ]

    def add(link, name, factor, terms):
        for key, x in terms.items():
            link[name][key] = link[name].get(key, 0) + factor * x

    for k in range(len(table) - 1, -1, -1):
        link, (v, d, r) = links[k], table[k]
        yy, z, m = (dict(link.pop(x)) for x in ("Iyy", "hz", "m"))
        add(link, "Ixx", -1, yy)
        if k == 0:
            continue  # of the first link, whose axis is vertical, only I_zz moves anything
        c, d, r, before = int(not v), Fraction(d), Fraction(r), links[k - 1]
        for name, of_yy, of_z, of_m in (
            ("Ixx", 1, 2 * r, r * r), ("Ixy", 0, d * v, d * r * v), ("Ixz", 0, -d * c, -d * r * c),
            ("Iyy", c * c, 2 * r * c * c, d * d + r * r * c * c), ("Iyz", c * v, 2 * r * c * v, r * r * c * v),
            ("Izz", v * v, 2 * r * v * v, d * d + r * r * v * v), ("hx", 0, 0, d), ("hy", 0, -v, -r * v),
            ("hz", 0, c, r * c), ("m", 0, 0, 1),
        ):  # fmt: skip
            for factor, terms in ((of_yy, yy), (of_z, z), (of_m, m)):
                add(before, name, factor, terms)
    rows = [links[0]["Izz"], *(terms for link in links[1:] for terms in link.values())]
    return [{key: x for key, x in terms.items() if x != 0} for terms in rows]


def rank(rows):
    names = sorted({name for terms in rows for name in terms})
    return sympy.Matrix([[sympy.Rational(terms.get(x, 0)) for x in names] for terms in rows]).rank()


def published(line):
    terms = {}
    for term in line.replace("- ", "+ -").split(" + "):
        factor, _, name = term.rpartition("*")
        sign, name = (-1, name[1:]) if name.startswith("-") else (1, name)
        for x in [name] if "." in name else [f"{k}.m" for k in name]:
            terms[x] = sign * Fraction(factor or 1)
    return terms


def test_a_panda_as_published():
    found = by_number(robot(PANDA))
    expected = [published(line) for line in PANDA_AS_PUBLISHED.strip().splitlines()]
    assert len(found) == len(expected) == 7 * 7 - 4 - 2
    assert sorted(map(sorted, found)) == sorted(map(sorted, expected))
    assert all(terms in expected for terms in found)


def test_a_ur5_as_published():
    found = by_number(robot((*UR5[:5], (1, "0", "-0.0823"))))
    expected = [published(line) for line in UR5_AS_PUBLISHED.strip().splitlines()]
    assert len(found) == len(expected) == 36 == rank(expected) == rank([*found, *expected])
    assert sum(terms in expected for terms in found) == 36


@pytest.mark.parametrize("table", [PANDA, UR5])
def test_robots_by_the_rules_of_gautier_and_khalil(table):
    """The same number, 7 n - 4 - 2, and combinations of the same space."""
    found, expected = by_number(robot(table)), grouped(table)
    n = 7 * len(table) - 4 - 2
    assert len(found) == len(expected) == n
    assert rank(expected) == rank([*found, *expected]) == n
