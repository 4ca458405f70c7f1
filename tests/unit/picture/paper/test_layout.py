"""Layout of drawings and free-body diagrams: no label on a line or another label, no arrow beside where it acts."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb
from contact_machines import falling_rod
from freebody.dynamics.conditions.contact import touches
from freebody.gallery import entries
from freebody.picture.free_body.free_body_diagram import free_body_diagram
from freebody.picture.machine.configuration import configuration
from freebody.picture.machine.draw import draw
from freebody.picture.machine.shapes import holds
from freebody.picture.machine.solid_pieces import pieces_of
from freebody.picture.page.longest_phases import lasting_place, most_lasting
from freebody.picture.paper.palette import CONTRAST, PAIRS, luminance
from freebody.picture.paper.sheet import Arrow, Group, Label, Line, Sheet, arc, flat
from layout import astray, faults

FAST = ("ex-6-2", "ex-6-5", "sec-6-9", "prob-6-5", "prob-6-16", "slider-crank")
NAMES = [
    name if name in FAST else pytest.param(name, marks=pytest.mark.slow)
    for name in dict.fromkeys(entry.name for entry in entries().values())
]


def pictures(name: str) -> dict[str, Any]:
    """What is drawn of an entry: as a run writes it, and as it is drawn by itself."""
    entry = entries()[name]
    e = fb.equations(entry.build(), modes=entry.modes)
    options: dict[str, Any] = {"near": {k: x for k, x in entry.near.items() if k in e.model.coordinate_names}}
    if e.model.contacts:
        outcome = entry.run()
        e = most_lasting(outcome.equations, outcome.trajectory)
        options = {"values": outcome.values, "at": lasting_place(outcome.trajectory) or None}
    found = {body: free_body_diagram(e, body, **options) for body in e.model.bodies}
    if len(found) > 1:
        found["all"] = free_body_diagram(e, "all", **options)
    found["drawing"] = draw(e, **options)
    if e.model.contacts:
        found["by itself"] = draw(entry.build())
    return found


@pytest.mark.parametrize("name", NAMES)
def test_nothing_overlaps_and_arrows_are_where_they_act(name: str) -> None:
    for what, drawing in pictures(name).items():
        assert faults(drawing) == [], what
        if what not in ("drawing", "by itself"):
            assert astray(drawing) == [], what


def test_forces_to_scale_are_where_they_act() -> None:
    s = falling_rod()
    motion = fb.simulate(s, 0.5, initial={"x": -0.5 * math.sin(0.1), "y": 0.5 * math.cos(0.1), "phi": 0.1})
    for t in (0.0, 0.2, 0.4):
        drawing = free_body_diagram(s, "rod", trajectory=motion, at=t)
        assert faults(drawing) == [] and astray(drawing) == []


def test_printed_in_grey_pairs_and_letters_can_be_told() -> None:
    """Pairs of a machine of three joints are at least a tenth of the way from black to white apart."""
    grey = [
        sum(w * int(c[i : i + 2], 16) for w, i in zip((0.299, 0.587, 0.114), (1, 3, 5), strict=True))
        for c in PAIRS
    ]
    assert min(abs(a - b) for i, a in enumerate(grey[:3]) for b in grey[:i]) > 25.5
    drawing = free_body_diagram(entries()["prob-6-16"].build())
    colors = {item.color for item in flat(drawing.sheet.root) if isinstance(item, Label)}
    assert len(colors) > 4 and all(1.05 / (luminance(color) + 0.05) >= CONTRAST for color in colors)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no LaTeX here")
@pytest.mark.parametrize("name", ["ex-6-5", "sec-6-9", "prob-6-9", "two-gears", "block-and-tackle"])
def test_tikz_compiles(name: str, tmp_path: Path) -> None:
    """Without an error, and to a page of the size of the drawing, give or take the letters."""
    s = entries()[name].build()
    for what, drawing in (("machine", draw(s)), ("bodies", free_body_diagram(s))):
        drawing.save(tmp_path / f"{what}.tex")
        run = subprocess.run(
            ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", f"{what}.tex"],
            cwd=tmp_path, capture_output=True, text=True, timeout=120,
        )  # fmt: skip
        assert run.returncode == 0, run.stdout[-2000:]
        box = re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", (tmp_path / f"{what}.pdf").read_bytes())
        if box:  # else the page is in a compressed stream
            # TeX's points are 72.27 to the inch; borders of 6 pt and of 10 pt
            size = [float(x) * 72.27 / 72 + 8 for x in box.groups()]
            assert size == pytest.approx(drawing.size, abs=16)


def test_curved_arrows_end_straight_in_tikz() -> None:
    arrow = Arrow(arc(np.zeros(2), 20.0, 0.0, 3.5), head="full")
    tex = _drawing(Group([arrow])).tikz
    shaft, end = (line for line in tex.splitlines() if "\\path" in line)
    assert "Stealth" not in shaft and shaft.count("--") > 20
    assert "Stealth" in end and end.count("--") == 1
    assert end.endswith(f"({arrow.tip[0]:.3f},{arrow.tip[1]:.3f});")


def test_more_contacts_than_are_tried_are_stood_on() -> None:
    """A polygon of twenty corners, begun in the floor: on one of its corners, the others above."""
    s = fb.System("polygon")
    body = s.body("wheel", fb.disk(1, 0.5))
    s.gravity = (0, -9.81, 0)
    s.planar("plane", s.ground, body, coordinate="x y phi")
    t = [2 * math.pi * (k + 0.3) / 20 for k in range(20)]
    s.contact("rim", body.corners(*((0.5 * math.cos(a), 0.5 * math.sin(a), 0) for a in t)), s.ground.plane())
    model = fb.assemble(s)
    assert len(model.contacts) == 20
    now = configuration(model, near={"y": 0.2})
    gaps = [float(one.gap) for one in touches(model, now.state)]
    assert min(gaps) == pytest.approx(0, abs=1e-9)
    assert 'class="contact"' in draw(s).svg


def test_planes_of_moving_bodies_reach_to_the_contact() -> None:
    s = fb.System("board on a truck")
    s.gravity = (0, -9.81, 0)
    truck, board = s.body("truck", fb.particle(1)), s.body("board", fb.slender_bar(1, 2))
    s.slider("road", s.ground, truck, axis="x", coordinate=s.t**2)
    s.planar("plane", truck, board, at=("1/2", 1, 0), coordinate="x y theta")
    s.contact("floor", board.point(-1, 0, 0), truck.plane(), friction=1)
    s.contact("wall", board.point(1, 0, 0), truck.plane(at=(1, 0, 0), normal="-x"))
    model = fb.assemble(s)
    now = configuration(model)
    pieces = [piece for piece in pieces_of(now, True)["truck"] if piece.kind == "rod"]
    R, p = now.posture("truck")
    for one in touches(model, now.state):
        local = R.T @ (np.array([float(x) for x in one.on_surface]) - p)
        assert any(holds(piece, local, 1e-6) for piece in pieces)


def test_the_check_finds_what_is_wrong() -> None:
    """A label on a shaft, one on another label, an arrow 30 pt from its point."""
    line = Line(np.array([(0.0, 5.0), (100.0, 5.0)]))
    labels = [Label("$m g$", np.array(at)) for at in ((10.0, 0.0), (12.0, 0.0), (80.0, 20.0))]
    on_line, on_label = r"\$m g\$ on line", "$m g$ on $m g$"
    found = faults(_drawing(Group([line, *labels])))
    assert on_label in found and sum(one.startswith(on_line.replace("\\", "")) for one in found) == 2
    arrow = Group([Arrow(np.array([(30.0, 0.0), (60.0, 0.0)]))], {"data-point": "0 0 0"}, "force F")
    outline = Group([], {"class": "outline", "data-solids": "box"})
    panel = Group([outline, arrow], {"data-shift": "0 0"})
    assert astray(_drawing(Group([panel]))) == ["force F is 30.0 pt away from where it acts"]


def _drawing(root: Group) -> Any:
    from freebody.picture.paper.drawing import Drawing

    return Drawing(Sheet(root, "test", {"data-view": "1 0 0 0 1 0", "data-scale": "1"}))
