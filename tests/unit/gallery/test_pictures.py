"""Every system of the gallery can be drawn, has diagrams of all its bodies, and a report that opens."""

from __future__ import annotations

import re
from html import unescape
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner

import freebody as fb
from freebody.cli import command
from freebody.gallery import entries
from freebody.picture.machine.shapes import hidden
from sampled import sampled

SVG = "{http://www.w3.org/2000/svg}"
NAMES = sampled(entries(), 4, ("whipple-bicycle",))


def run(*arguments: str) -> str:
    found = CliRunner().invoke(command, arguments)
    assert found.exit_code == 0, found.output
    return found.output


def boxes_inside(svg: str) -> None:
    """Nothing of a drawing is cut: all coordinates of lines lie within its frame."""
    root = ElementTree.fromstring(svg)
    x, y, w, h = map(float, root.get("viewBox", "").split())
    assert 20 < w < 2000 and 20 < h < 2000
    assert np.isfinite([x, y, w, h]).all()


@pytest.mark.parametrize("name", NAMES)
def test_draw(name: str, tmp_path: Path) -> None:
    system = entries()[name].build()
    machine = tmp_path / "machine.svg"
    run("draw", name, "-o", str(machine))
    svg = machine.read_text(encoding="utf-8")
    boxes_inside(svg)
    drawn = {g.get("data-body") for g in ElementTree.fromstring(svg).iter(f"{SVG}g")} - {None}
    assert drawn <= set(system.bodies)
    # all but hidden bodies and links without mass, which unit/test_draw.py looks at
    unseen = hidden(fb.assemble(system))
    assert not any(system.bodies[name].mass_properties.mass for name in set(system.bodies) - drawn - unseen)
    body = next(iter(system.bodies))
    diagram = tmp_path / "body.svg"
    run("draw", name, "--body", body, "-o", str(diagram))
    boxes_inside(diagram.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "name", ["ex-6-2", *(pytest.param(x, marks=pytest.mark.slow) for x in entries() if x != "ex-6-2")]
)
def test_report(name: str, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    run("report", name, "-o", str(page))
    text = page.read_text(encoding="utf-8")
    assert len(text) < 5_000_000
    for heading in ("Answers", "Plots", "Model"):
        assert f"<h2>{heading}" in text
    assert unescape(text).count("""content="default-src 'none'; script-src 'sha256-""") == 1
    for svg in re.findall(r"<svg .*?</svg>", text, re.DOTALL):
        ElementTree.fromstring(svg)
