"""Round shapes that fit their line of heights, by bounds, and the refusal of those that do not."""

import pytest

import freebody as fb
from freebody.errors import SimulationError
from freebody.motion.start.fitting import refuse_misfits

R = 0.2
FITS = (
    "0.1*cos(3*x)", "0.1*exp(-x^2/0.1)", "0.1*exp(-x^2/0.02)", "2.4*x^2", "x^3", "x^4", "2*x", "-9*x^2",
    "0.02*sin(x) + 0.01*cos(3*x)", "0.2*sin(x) + 0.3*cos(sqrt(2)*x)", "sqrt(1 + x^2)", "0.4*log(1 + x^2)",
)  # fmt: skip


def wheel(line, radius=R, **ends):
    s = fb.System("wheel")
    s.gravity = (0, -9.81, 0)
    s.parameters(a=0.05)
    disk = s.body("disk", fb.disk(1, R))
    s.planar("plane", s.ground, disk, coordinate="x y turn")
    s.contact("road", disk.circle(radius), s.ground.heightline(line, **ends))
    return s


@pytest.mark.parametrize("line", FITS)
def test_shapes_that_fit(line):
    model = fb.assemble(wheel(line))
    refuse_misfits(model, model.values())


@pytest.mark.parametrize(
    "line,ends,message",
    [
        ("3*x^2", {}, r"into the heightline 3\*x\*\*2, whose radius of curvature is 0.166667 m at x = -?\d"),
        ("0.1*tanh(x/0.1)", {}, r"0.19712 m at x = -0.0919 m: they would touch in two places. Divide the line there"),
        ("2.5*x^2", {}, r"may curve as much, or change its curvature at once, near x = "),
        ("-sqrt(1 - x^2)", {}, r"may curve as much, or change its curvature at once, near x = -?[01]"),
        ("3*x^2", {"between": ("a", "1 - 10*a")}, r"'road' must start before it ends, got between=\(0.1, 0\)"),
    ],
)  # fmt: skip
def test_shapes_that_do_not_fit(line, ends, message):
    with pytest.raises(SimulationError, match=message):
        refuse_misfits(fb.assemble(wheel(line, **ends)), {"a": 0.1})


def test_values_of_a_run_decide():
    s = wheel("a*x^2", radius="4*a")
    fb.simulate(s, 0.01, initial={"y": 1})
    for how in ({}, {"method": "timestepping", "step": 0.001}):
        with pytest.raises(
            SimulationError, match="The circle of contact 'road' has the radius 4 m and does not fit"
        ):
            fb.simulate(s, 0.01, initial={"y": 9}, values={"a": 1}, **how)


def test_a_part_of_a_line_fits():
    model = fb.assemble(wheel("3*x^2", between=(0.08, 2)))
    refuse_misfits(model, {"a": 0.1})
