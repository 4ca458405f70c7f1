"""Layout of drawings and free-body diagrams: no label on a line or another label, no arrow beside where it acts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import freebody as fb
from contact_machines import falling_rod
from freebody.gallery import entries
from freebody.picture.draw import draw
from freebody.picture.free_body_diagram import free_body_diagram
from freebody.picture.phases_drawn import lasting_place, most_lasting
from freebody.picture.sheet import Arrow, Group, Label, Line, Sheet
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
    from freebody.picture.drawing import Drawing

    return Drawing(Sheet(root, "test", {"data-view": "1 0 0 0 1 0", "data-scale": "1"}))
