"""The public names of what users hold while they describe a machine: few, known and documented."""

from __future__ import annotations

import inspect
import re

import pytest

import freebody as fb
from freebody.describe.part import Part

SYSTEM = """
    add assume ball bodies body bushing cable constrain constrain_speed constraints contact contacts
    controller controllers coordinates cylindrical damper describe drag expression families force free friction gear
    belt chain path_joint
    generalized_force gimbal gravitation gravity ground hinge joints loads motor name parameters planar
    reading rolling rope scenery screw slider spring stop t torque torsion_spring tyre universal weld
"""
BODY = """
    box capsule center circle corners cylinder drum ellipsoid heightline hull is_ground mass_properties name origin
    plane point segment sphere system
"""
POINT = "body components"
JOINT = """
    armature at axis child child_axes closes coordinate end endings motions pair parent parent_axes pose primitives
    refuse_loop rotor start stored to type
"""
PARTS = [name for name in dir(Part) if not name.startswith("_")]  # what every part has


def described():
    s = fb.System("pendulum")
    bar = s.body("bar", fb.slender_bar(1, 2, axis="y"))
    pin = s.hinge("pin", s.ground, bar, to=(0, 1, 0), axis="z", coordinate="theta")
    return {
        "System": (s, SYSTEM),
        "Body": (bar, BODY),
        "Point": (bar.origin, POINT),
        "Joint": (pin, " ".join([JOINT, *PARTS])),
    }


@pytest.mark.parametrize("kind", ["System", "Body", "Point", "Joint"])
def test_public_names_are_those_that_users_need(kind):
    thing, names = described()[kind]
    assert [name for name in dir(thing) if not name.startswith("_")] == sorted(names.split())


@pytest.mark.parametrize("kind", ["System", "Body", "Point", "Joint"])
def test_each_public_name_is_documented(kind):
    thing, names = described()[kind]
    text = "\n".join(
        inspect.getdoc(k) or "" for k in type(thing).__mro__ if k.__module__.startswith("freebody")
    )
    heads = re.findall(r"^(\w[\w, ]*) : ", text, re.MULTILINE)  # of the section Attributes
    documented = {*", ".join(heads).split(", "), *re.findall(r"``s\.(\w+)``", text)}
    for name in names.split():
        member = inspect.getattr_static(type(thing), name, None)
        if name in PARTS:
            continue  # the class of all parts says it
        own = inspect.getdoc(member) if callable(member) or isinstance(member, property) else None
        assert own or name in documented, name
