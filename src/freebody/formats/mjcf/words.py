"""Words of the format: what is read, what is left out, and what that means for the motion.

In the tables an attribute or element without a text is read, or says nothing of the motion (looks, names, numerics).
"""

from __future__ import annotations

POSE = dict.fromkeys(("pos", "quat", "axisangle", "euler", "xyaxes", "zaxis"), "")
NAMES = dict.fromkeys(("name", "class", "user", "group"), "")
LOOKS = dict.fromkeys(("material", "rgba"), "")
SOFT = "constraints are exact here, not soft"
RIGID = "contacts are rigid here, not soft"

ATTRIBUTES: dict[str, dict[str, str]] = {
    "body": NAMES | POSE | dict.fromkeys(("childclass", "mocap", "gravcomp", "sleep"), ""),
    "inertial": POSE | dict.fromkeys(("mass", "diaginertia", "fullinertia"), ""),
    "joint": NAMES | dict.fromkeys(
        ("type", "pos", "axis", "range", "limited", "ref", "springref", "stiffness", "damping", "armature",
         "frictionloss", "springdamper", "align"), "",
    ) | dict.fromkeys(("solreflimit", "solimplimit", "solreffriction", "solimpfriction", "margin"), SOFT) | {
        "actuatorfrcrange": "the sum of its actuators is not limited", "actuatorfrclimited": "",
        "actuatorgravcomp": "gravity compensation is left out",
    },
    "geom": NAMES | POSE | LOOKS | dict.fromkeys(
        ("type", "size", "fromto", "mass", "density", "shellinertia", "mesh", "hfield", "contype", "conaffinity",
         "condim", "friction", "priority"), "",
    ) | dict.fromkeys(("solmix", "solref", "solimp", "margin", "gap"), RIGID) | {
        "fitscale": "", "fluidshape": "no fluid acts", "fluidcoef": "",
    },
    "site": NAMES | POSE | LOOKS | dict.fromkeys(("type", "size", "fromto"), ""),
}  # fmt: skip
"""Attributes of elements in bodies."""

NOTHING = ("camera", "light")
"""Elements in bodies that say nothing of the motion."""
BODY_LEFT_OUT = {"plugin": "a plugin is another simulator's code"}
"""Elements in bodies that are left out; others are refused."""

SECTIONS: dict[str, str] = dict.fromkeys(
    ("compiler", "option", "default", "worldbody", "asset", "equality", "tendon", "actuator", "keyframe", "contact",
     "size", "statistic", "visual", "custom"), "",
) | {
    "sensor": "sensors: values of coordinates, points and forces are asked of the motion",
    "deformable": "skins and flexible bodies: nothing bends",
    "extension": "plugins are another simulator's code",
}  # fmt: skip
"""Sections of a file."""

COMPILER: dict[str, str] = dict.fromkeys(
    ("angle", "eulerseq", "autolimits", "inertiafromgeom", "inertiagrouprange", "boundmass", "boundinertia",
     "settotalmass", "balanceinertia", "strippath", "meshdir", "assetdir", "coordinate", "texturedir", "discardvisual",
     "usethread", "fusestatic", "saveinertial", "fitaabb"), "",
) | {
    "alignfree": "a free joint keeps the origin and axes of its body",
    "exactmeshinertia": "a mesh has inertia= of its own",
    "convexhull": "meshes touch with their hulls",
}  # fmt: skip
"""Attributes of <compiler>."""

OPTIONS: dict[str, str] = {"gravity": "", "flag": ""} | dict.fromkeys(
    ("density", "viscosity", "wind"), "no fluid acts: s.drag gives drag"
)
"""Attributes of <option> that concern the motion; the others are settings of another integrator and solver."""

EQUALITIES: dict[str, str] = {"connect": "", "weld": "", "joint": "", "tendon": ""} | dict.fromkeys(
    ("flex", "flexvert", "flexstrain"), "nothing is flexible"
) | {"distance": "not a part of MuJoCo any more"}  # fmt: skip
"""Elements of <equality>."""

TENDONS = {
    "fixed": "",
    "spatial": "a spatial tendon: its force is left out; s.cable and s.rope go over points",
}
"""Elements of <tendon>."""

ACTUATORS: dict[str, str] = dict.fromkeys(("motor", "position", "velocity", "general", "damper"), "") | {
    "intvelocity": "its target is integrated, a state that the machine does not have",
    "cylinder": "its pressure is a state that the machine does not have",
    "muscle": "no muscle pulls",
    "adhesion": "nothing adheres",
    "plugin": "a plugin is another simulator's code",
}
"""Elements of <actuator>."""
TRANSMISSIONS: dict[str, str] = {"joint": "", "jointinparent": "", "tendon": ""} | dict.fromkeys(
    ("site", "cranksite", "slidersite", "body", "refsite"),
    "acts on sites or bodies: give it as s.force or s.torque",
)
"""Attributes of actuators that say on what they act."""


def table() -> str:
    """Return the table of what is read, as the page on robots shows it."""
    rows = ["| in | read | left out, and said |", "|---|---|---|"]
    kinds: list[tuple[str, dict[str, str]]] = [
        ("`<mujoco>`", SECTIONS), ("`<compiler>`", COMPILER), ("`<option>`", OPTIONS),
        *((f"`<{tag}>`", words) for tag, words in ATTRIBUTES.items()),
        ("`<body>`, elements", dict.fromkeys(("joint", "freejoint", "geom", "site", "frame", "inertial", *NOTHING), "")
         | BODY_LEFT_OUT),
        ("`<tendon>`", TENDONS), ("`<actuator>`", ACTUATORS), ("actuators act on", TRANSMISSIONS),
        ("`<equality>`", EQUALITIES),
    ]  # fmt: skip
    for name, words in kinds:
        read = ", ".join(f"`{word}`" for word, what in words.items() if not what)
        reasons: dict[str, list[str]] = {}
        for word, what in words.items():
            if what:
                reasons.setdefault(what, []).append(f"`{word}`")
        left = "; ".join(f"{', '.join(some)}: {what}" for what, some in reasons.items())
        rows.append(f"| {name} | {read} | {left} |")
    return "\n".join(rows)
