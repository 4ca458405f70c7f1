"""Examples 6.2 and 6.5 against closed forms: the hinged bar, and the particle on a spring with a bar."""

from __future__ import annotations

from chapter_answers import check_formulas, check_numbers
from freebody import exact


def hinged_bar(p):
    bar = exact.hinged_bar(p["m"], p["L"], p["g"])
    return {  # the closed form counts clockwise
        "alpha": -bar.alpha,
        "R_1": bar.reaction_start,
        "omega_2": -bar.omega_vertical,
        "R_2": bar.reaction_vertical,
        "T_2": bar.energy_vertical,
    }


def test_hinged_bar():
    check_numbers("ex-6-2", hinged_bar, g=3.7, L=0.4)


def test_hinged_bar_formulas():
    check_formulas("ex-6-2", hinged_bar)
