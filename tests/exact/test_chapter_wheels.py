"""Problems 6.18 and 6.19 against closed forms: wheels of a motorcycle, rotors of an aircraft."""

from __future__ import annotations

from chapter_answers import check_formulas, check_numbers, outcome
from freebody import exact


def motorcycle(p):
    particle = [p[name] for name in ("m", "h", "v", "R", "g")]
    return {
        "M": exact.wheel_torque(p["I"], p["r"], p["v"], p["R"]),
        "lean": exact.curve_lean(*particle, p["I"], p["r"]),
        "lean_without": exact.curve_lean(*particle),
    }


def test_motorcycle(changing):
    check_numbers("prob-6-18", motorcycle, changing=changing)
    check_formulas("prob-6-18", motorcycle)


def test_direction_of_the_torque():
    """It is opposite to the direction of travel in a left turn: h points left, and is turned to the rear."""
    assert "backwards" in outcome("prob-6-18").answers["direction"].value


def turboprop(p):
    first = [p[name] for name in ("I_p", "w_p", "I_e")]
    return {
        "M": exact.pitching_moment(*first, p["w_e"], p["v"], p["R"]),
        "M_2": exact.pitching_moment(*first, p["w_e2"], p["v"], p["R"]),
    }


def test_turboprop(changing):
    check_numbers("prob-6-19", turboprop, changing=changing)
    check_formulas("prob-6-19", turboprop)


def test_the_nose():
    answers = outcome("prob-6-19").answers
    assert (answers["nose"].value, answers["nose_2"].value) == ("fall", "rise")
    assert outcome("prob-6-19", w_p=90.0).answers["nose"].value == "neither: no moment"
