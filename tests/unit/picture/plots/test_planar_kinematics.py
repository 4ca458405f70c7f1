"""Instant centres, velocity and acceleration diagrams, coupler curves: closed forms and theorems of planar motion."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import freebody as fb
from freebody.errors import SimulationError
from freebody.gallery import entries
from freebody.picture.plots.planar_kinematics import centres

CLOSED = 1e-7
"""Of lengths, relative: loops close to the tolerance of a motion, 1e-9, and small denominators magnify it."""


def moving(name: str, until: float = 0.6) -> fb.Trajectory:
    entry = entries()[name]
    return fb.simulate(entry.build(), until, near=entry.near, initial=entry.start)


@pytest.fixture(scope="module")
def four_bar() -> fb.Trajectory:
    return moving("four-bar")


@pytest.fixture(scope="module")
def slider_crank() -> fb.Trajectory:
    return moving("slider-crank", 0.02)


def own() -> Any:
    return Figure().subplots()


def crossing(a: Any, b: Any, c: Any, d: Any) -> Any:
    """Where the lines ab and cd cross, in the plane."""
    s = np.linalg.solve(np.column_stack([b - a, c - d]), c - a)
    return a + s[0] * (b - a)


def joint_places(motion: fb.Trajectory, at: float) -> dict[str, Any]:
    """Places of A, B, C, D of the four-bar linkage in its plane."""
    values, now = motion.values, motion.at(at)
    crank = values["omega"] * at
    A, D = np.zeros(2), np.array([values["d"], 0.0])
    B = A + values["a"] * np.array([math.cos(crank), math.sin(crank)])
    C = D + values["c"] * np.array([math.cos(now["psi"]), math.sin(now["psi"])])
    return {"A": A, "B": B, "C": C, "D": D}


@pytest.mark.parametrize("at", [0.05, 0.2, 0.45])
def test_the_centre_of_a_coupler_is_where_the_cranks_cross(four_bar: fb.Trajectory, at: float) -> None:
    P, found = joint_places(four_bar, at), centres(four_bar, at)
    coupler = found["ground", "coupler"].point
    assert coupler is not None
    assert coupler[:2] == pytest.approx(crossing(P["A"], P["B"], P["D"], P["C"]), rel=CLOSED, abs=CLOSED)
    # and that of crank and rocker, where the coupler crosses the ground
    relative = found["crank", "rocker"].point
    assert relative is not None
    assert relative[:2] == pytest.approx(crossing(P["B"], P["C"], P["A"], P["D"]), rel=CLOSED, abs=CLOSED)
    for pair, joint in ((("ground", "crank"), "A"), (("crank", "coupler"), "B"), (("ground", "rocker"), "D")):
        point = found[pair].point
        assert point is not None and point[:2] == pytest.approx(P[joint], abs=CLOSED)


@pytest.mark.parametrize("name", ["four-bar", "slider-crank"])
def test_the_centres_of_three_bodies_lie_on_one_line(name: str) -> None:
    """The theorem of Kennedy and Aronhold, for all triples with finite centres."""
    motion = moving(name, 0.02)
    found = centres(motion, 0.015)
    names = list(dict.fromkeys(body for pair in found for body in pair))
    tested = 0
    for trio in combinations(names, 3):
        points = [found[pair].point for pair in combinations(trio, 2)]
        if any(p is None for p in points):
            continue
        a, b, c = (p[:2] for p in points if p is not None)
        longest = max(np.linalg.norm(b - a), np.linalg.norm(c - a), 1e-12)
        area = (b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]
        assert abs(area) / longest**2 < CLOSED
        tested += 1
    assert tested


def test_a_piston_has_its_centre_across_its_way(slider_crank: fb.Trajectory) -> None:
    """Infinitely far, across the cylinder; that of the rod is above the wrist pin, on the line of the crank."""
    at = 0.005
    found = centres(slider_crank, at)
    piston = found["ground", "piston"]
    assert piston.point is None and piston.direction is not None
    assert abs(piston.direction @ [1, 0, 0]) < CLOSED
    rod = found["ground", "rod"].point
    assert rod is not None
    now = slider_crank.at(at)
    turned = slider_crank.values["omega"] * at
    assert rod[0] == pytest.approx(float(now["x"]), rel=CLOSED)
    assert rod[1] / rod[0] == pytest.approx(math.tan(turned), rel=CLOSED)


def test_bodies_at_rest_relative_to_each_other_have_no_centre() -> None:
    s = fb.System("pair")
    for name in ("a", "b"):
        s.slider(
            f"way_{name}", s.ground, s.body(name, fb.box(1, (1, 1, 1))), axis="x", coordinate=f"x_{name}"
        )
    s.gravity = (0, -9.81, 0)
    found = centres(fb.simulate(s, 1, initial={"x_a'": 1, "x_b'": 1}))
    assert found["a", "b"] == (None, None)
    assert found["ground", "a"].direction is not None


def drawn_points(ax: Any) -> dict[str, Any]:
    """Ends of a diagram by name: the texts beside its dots."""
    return {
        name: np.array(text.xy)
        for text in ax.texts
        if text.get_text()
        for name in text.get_text().split(", ")
    }


@pytest.mark.parametrize("at", [0.1, 0.4])
def test_a_velocity_diagram_is_the_machine_turned(four_bar: fb.Trajectory, at: float) -> None:
    """Each line of a body is ω times its line in the machine, turned by a right angle."""
    P, ends = joint_places(four_bar, at), drawn_points(fb.plot.velocity_diagram(four_bar, own(), at=at))
    omega = four_bar.values["omega"]
    turned = np.array([[0.0, -1.0], [1.0, 0.0]])
    assert ends["A"] == pytest.approx([0, 0], abs=CLOSED) and ends["D"] == pytest.approx([0, 0], abs=CLOSED)
    assert ends["B"] == pytest.approx(omega * turned @ (P["B"] - P["A"]), rel=CLOSED, abs=CLOSED)
    assert (ends["C"] - ends["B"]) @ (P["C"] - P["B"]) == pytest.approx(0, abs=CLOSED)
    assert ends["C"] == pytest.approx(
        four_bar.at(at)["psi'"] * turned @ (P["C"] - P["D"]), rel=CLOSED, abs=CLOSED
    )


@pytest.mark.parametrize("at", [0.1, 0.4])
def test_an_acceleration_diagram_has_normal_and_tangential_parts(four_bar: fb.Trajectory, at: float) -> None:
    """B turns evenly, -ω² r; along the coupler C has -ω² r relative to B, whatever its angular acceleration."""
    P, ends = joint_places(four_bar, at), drawn_points(fb.plot.acceleration_diagram(four_bar, own(), at=at))
    omega = four_bar.values["omega"]
    assert ends["B"] == pytest.approx(-(omega**2) * (P["B"] - P["A"]), rel=CLOSED, abs=CLOSED)
    velocity = drawn_points(fb.plot.velocity_diagram(four_bar, own(), at=at))
    for one, other in (("B", "C"), ("D", "C")):
        r = P[other] - P[one]
        rate = np.linalg.norm(velocity[other] - velocity[one]) / np.linalg.norm(r)
        assert (ends[other] - ends[one]) @ r == pytest.approx(-(rate**2) * (r @ r), rel=CLOSED)


def test_the_coupler_curve_of_an_ellipse() -> None:
    """A point of a bar whose ends slide along two axes moves on an ellipse with the half axes p and L - p."""
    s = fb.System("trammel")
    bar = s.body("bar", fb.slender_bar(1, 1, axis="x"))
    block, other = s.body("block", fb.particle(1)), s.body("other", fb.particle(1))
    s.slider("way", s.ground, block, axis="x", coordinate="x")
    s.hinge("pin", block, bar, to=(0.5, 0, 0), coordinate="theta")
    s.slider("rise", s.ground, other, axis="y", coordinate="y")
    s.hinge("end", other, bar, to=(-0.5, 0, 0))
    motion = fb.simulate(s, 4.0, near={"x": 0.6, "y": 0.8, "theta": -0.9}, initial={"theta'": 2.0})
    ax = fb.plot.coupler_curves(motion, bar.point(0.2, 0, 0), own())
    x, y = (np.asarray(v) for v in ax.lines[0].get_data())
    assert len(x) > 50 and np.ptp(x) > 0.5
    assert (x / 0.7) ** 2 + (y / 0.3) ** 2 == pytest.approx(np.ones(len(x)), abs=1e-6)


def test_the_instant_centres_are_marked(four_bar: fb.Trajectory) -> None:
    ax = fb.plot.instant_centres(four_bar, own(), at=0.2)
    found = centres(four_bar, 0.2)
    beyond = [label for label in ax.get_legend_handles_labels()[1] if "beyond" in label]
    assert len(ax.texts) + len(beyond) == sum(centre.point is not None for centre in found.values()) == 6
    dots = [line.get_xydata()[0] for line in ax.lines if line.get_marker() == "o" and len(line.get_xdata())]
    assert dots[0] == pytest.approx(found["ground", "crank"].point[:2])  # type: ignore[index]


def test_refusals(four_bar: fb.Trajectory) -> None:
    space = moving("sec-6-9", 0.01)
    for draw in (fb.plot.velocity_diagram, fb.plot.acceleration_diagram, fb.plot.instant_centres):
        with pytest.raises(SimulationError, match="Expected a planar machine for a diagram of velocities"):
            draw(space, own())
    with pytest.raises(SimulationError, match="Expected points of bodies of 'four_bar', such as"):
        fb.plot.coupler_curves(four_bar, "coupler", own())


@pytest.mark.parametrize("diagram", ["velocity_diagram", "acceleration_diagram"])
def test_texts_of_a_diagram_do_not_cover_each_other(four_bar: fb.Trajectory, diagram: str) -> None:
    ax = getattr(fb.plot, diagram)(four_bar, at=0.1)
    canvas = FigureCanvasAgg(ax.figure)
    canvas.draw()
    boxes = [text.get_window_extent(canvas.get_renderer()) for text in ax.texts if text.get_text()]
    assert len(boxes) > 4
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
