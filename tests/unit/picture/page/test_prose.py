"""Sentences between formulas: what acts, which axis an equation belongs to, what stays unknown."""

from __future__ import annotations

import sympy

import freebody as fb
from freebody.gallery import entries
from freebody.picture.page import prose


def equations(name: str) -> fb.Equations:
    entry = entries()[name]
    return fb.equations(entry.build(), modes=entry.modes)


def test_a_cart_with_a_bar() -> None:
    e = equations("ex-6-5")
    assert prose.laws(e, str) == (
        "The motion is planar. Of each body, the forces add up to m a_{C} and their moments about its mass centre C to "
        r"I_{C} \alpha."
    )
    assert prose.actions(e, "cart", [], str) == (
        "On cart act its weight, spring, the reactions guide_y and guide_Mz of guide and the reactions pin_x and pin_y "
        "of pin."
    )
    assert prose.actions(e, "bar", ["cart"], str) == (
        "On bar act its weight, F and the reactions pin_x and pin_y of pin. Reactions of pin on cart are the opposite "
        "of these."
    )
    assert prose.motion(e, str) == (
        "Each coordinate has an equation. The reactions of joints do not appear. That of x sums the forces on cart and "
        "bar along the axis of guide. That of theta sums the moments on bar about the axis of pin."
    )


def test_closed_loops_and_contacts_stay_unknown() -> None:
    said = prose.motion(equations("four-bar"), str)
    assert said.endswith("What C exerts stays unknown in them; the conditions of C come last.")
    said = prose.motion(equations("ex-6-3"), str)
    assert (
        "That of x sums the forces on disk along the x axis of plane. That of y" in said
        and "reactions" not in said
        and "the conditions of floor come last" in said
    )


def test_bodies_in_space_and_their_speeds() -> None:
    e = equations("sec-6-9")
    assert r"to \dot{H}_{C}." in prose.laws(e, str) and "planar" not in prose.laws(e, str)
    assert "That of psi sums the moments on rotor about the psi axis of pivot." in prose.motion(e, str)
    # a free joint has no axis that a speed belongs to, and no reactions
    s = fb.System("stone")
    s.free("flight", s.ground, s.body("stone", fb.sphere(1, 1)))
    e = fb.equations(s)
    assert prose.motion(e, str) == "Each speed has an equation."
    assert prose.actions(e, "stone", [], str) == "Nothing acts on stone."


def test_the_axis_is_that_of_the_balance() -> None:
    """The equation of theta is the moment about the pin: that about the mass centre, and that of the forces there."""
    e = equations("ex-6-5")
    force_x, force_y, moment = (x.lhs - x.rhs for x in e.free_body("bar").planar_equations)
    theta = e.coordinates[1]
    a = {p.name: p.symbol for p in e.model.parameters}["a"]
    arm = (a * sympy.sin(theta), -a * sympy.cos(theta))  # from the pin to the mass centre
    about = moment + arm[0] * force_y - arm[1] * force_x
    equation = e.motion[1].lhs - e.motion[1].rhs
    assert sympy.simplify(about + equation) == 0 or sympy.simplify(about - equation) == 0
