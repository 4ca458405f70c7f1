"""Warnings of motions whose steps are too long."""

import freebody as fb


def test_a_body_that_turns_too_far_in_a_step_is_said():
    s = fb.System("die")
    s.gravity = (0, 0, -9.81)
    die = s.body("die", fb.box(1, (0.1, 0.1, 0.1)))
    s.free("f", s.ground, die)
    s.contact("floor", die.box((0.1, 0.1, 0.1)), s.ground.plane(normal="z"))

    def warned(spin):
        start = {"f_z": 1, "f_wx": spin}
        return fb.simulate(s, 0.01, initial=start, method="timestepping", step=1e-3).warnings

    assert not warned(3000)
    (warning,) = warned(6000)
    assert str(warning) == (
        "f: 'f' turns by more than half a turn in a step, 6 rad at worst (0 to 0.01 s). The attitude follows turns "
        "that are short beside that: from t = 0 s on this motion is not physical. Take a step shorter than 0.000167 s, "
        "or method='auto'."
    )


def test_a_spring_too_stiff_for_the_step_makes_energy():
    """Steps with the force of their middle are stable for ωh < 2; beyond, the amplitude grows with each."""
    s = fb.System("bouncer")
    ball = s.body("ball", fb.sphere(1, 0.1))
    rail = s.slider("rail", s.ground, ball, axis="z", coordinate="z")
    s.spring("k", rail, stiffness=1e4)
    s.contact("floor", ball.sphere(0.1), s.ground.plane(normal="z", at=(0, 0, -9)))

    def warned(step):
        return fb.simulate(s, 0.5, initial={"z": 0.01}, method="timestepping", step=step).warnings

    assert not warned(0.005)  # ω = 100 rad/s
    (warning,) = warned(0.025)
    assert warning.value > 1e6
    assert "the steps make energy" in str(warning) and "Take a step shorter than 0.025 s" in str(warning)
