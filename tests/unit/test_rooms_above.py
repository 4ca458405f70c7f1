"""A system, its equations and its motion show themselves in a notebook, offline, and never fail there."""

from __future__ import annotations

import freebody as fb


def pendulum() -> fb.System:
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=2, L=1.5, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), coordinate="theta")
    return s


def test_a_system_shows_its_drawing():
    shown = pendulum()._repr_html_()
    assert (
        shown is not None
        and "<svg" in shown
        and "<script" not in shown
        and "http" not in shown.replace("http://www.w3.org", "")
    )


def test_a_system_that_is_not_complete_shows_its_text():
    s = fb.System("empty")
    assert s._repr_html_() is None
    s.body("loose", fb.particle(1))  # no joint holds it yet
    assert s._repr_html_() is None
    assert repr(s).startswith("System 'empty'")


def test_equations_and_motion_show_themselves():
    s = pendulum()
    assert fb.equations(s)._repr_latex_().startswith("$")
    motion = fb.simulate(s, until=1, initial={"theta": 1})
    assert 'sandbox="allow-scripts"' in motion._repr_html_()
    assert "srcdoc" in motion.animate(height=300)._repr_html_()
