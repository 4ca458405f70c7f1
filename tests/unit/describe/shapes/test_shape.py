"""Shapes are one file each: nothing else names a kind, and a user's own goes wherever ours go."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import freebody as fb
from freebody.describe.shapes.shape import KINDS

SOURCE = Path(fb.__file__).parent
ROOM = SOURCE / "describe" / "shapes"


def classes():
    """Return the names of all classes of shapes."""
    return {
        node.name
        for path in ROOM.glob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef) and node.name not in ("ContactShape", "Nearest")
    }


def test_no_file_compares_a_kind_of_shape():
    """Outside a shape's file no class of shapes is asked for, and no ``kind`` of one is compared."""
    names = classes()
    assert {"Spot", "Ball", "Circle", "Plane"} <= names
    for path in SOURCE.rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        own = {node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}
        imported = {
            alias.name
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom) and "describe.shapes." in f"{node.module}."
            for alias in node.names
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("isinstance", "issubclass"):
                asked = {one.id for one in ast.walk(node.args[1]) if isinstance(one, ast.Name)}
                assert not asked & names & imported - own, (path, asked)
            if isinstance(node, ast.Compare) and imported:
                asked = [
                    one for one in ast.walk(node) if isinstance(one, ast.Attribute) and one.attr == "kind"
                ]
                texts = {one.value for one in ast.walk(node) if isinstance(one, ast.Constant)}
                assert not (asked and texts & set(KINDS)) or path.parent == ROOM, (path, texts)


def test_a_kind_has_one_class():
    with pytest.raises(fb.errors.ModelError, match="There is already a kind of shape 'sphere'"):

        class Other(fb.ContactShape, kind="sphere"):
            """Another sphere."""


def test_data_of_an_own_shape_are_checked():
    class Knob(fb.ContactShape, kind="test_knob"):
        """A ball."""

        radius: fb.Expression
        hidden: bool = False

        def support(self, at, direction):
            return tuple(
                x + at(self.radius) * d
                for x, d in zip(at.place(self.body, (0, 0, 0)), direction, strict=True)
            )

    s = fb.System("knob")
    body = s.body("b", fb.sphere(1, 0.1))
    joint = s.slider("lift", s.ground, body, axis="z", coordinate="z")
    with pytest.raises(fb.errors.ModelError, match="radius of the feature of contact 'floor'"):
        s.contact("floor", Knob(body, "z"), s.ground.plane(normal="z"))
    with pytest.raises(fb.errors.ModelError, match="Expected True or False for the hidden of"):
        s.contact("floor", Knob(body, 1, hidden=3), s.ground.plane(normal="z"))
    with pytest.raises(fb.errors.ModelError, match="A test_knob may touch a plane"):
        s.contact("floor", Knob(body, 1), s.ground.sphere(1))
    assert joint.name == "lift"
