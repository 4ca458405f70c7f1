"""Words of the format: what is read, what is left out, and what that means for the motion.

In the tables an attribute or element without a text is read, or says nothing of the motion (`QUIET`).
"""

from __future__ import annotations

from ..reading import listed, reasons

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
         "frictionloss", "springdamper"), "",
    ) | dict.fromkeys(("solreflimit", "solimplimit", "solreffriction", "solimpfriction", "margin"), SOFT) | {
        "actuatorfrcrange": "the sum of its actuators is not limited", "actuatorfrclimited": "",
        "actuatorgravcomp": "gravity compensation is left out",
        "align": "a free joint keeps the origin and axes of its body",
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

QUIET: dict[str, tuple[str, ...]] = {
    "mujoco": ("size", "statistic", "visual", "custom"), "body": ("class", "user", "group", "sleep"),
    "joint": ("user", "group", "actuatorfrclimited"), "geom": ("user", "material", "hfield", "fitscale", "fluidcoef"),
    "site": ("user", "group", "material", "rgba", "type", "size"),
    "compiler": ("texturedir", "discardvisual", "usethread", "fusestatic", "saveinertial", "fitaabb"),
}  # fmt: skip
"""Words without a text that say nothing of the motion. All others without a text are read."""

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
    rows = ["| in | read | says nothing of the motion | left out, and said |", "|---|---|---|---|"]
    kinds: list[tuple[str, dict[str, str], tuple[str, ...]]] = [
        *((f"`<{tag}>`", words, QUIET.get(tag, ())) for tag, words in
          ({"mujoco": SECTIONS, "compiler": COMPILER, "option": OPTIONS} | ATTRIBUTES).items()),
        ("`<body>`, elements", dict.fromkeys(("joint", "freejoint", "geom", "site", "frame", "inertial", *NOTHING), "")
         | BODY_LEFT_OUT, NOTHING),
        ("`<tendon>`", TENDONS, ()), ("`<actuator>`", ACTUATORS, ()), ("actuators act on", TRANSMISSIONS, ()),
        ("`<equality>`", EQUALITIES, ()),
    ]  # fmt: skip
    for name, words, quiet in kinds:
        read = listed(word for word, what in words.items() if not what and word not in quiet)
        rows.append(f"| {name} | {read} | {listed(quiet)} | {reasons(words)} |")
    return "\n".join(rows)
