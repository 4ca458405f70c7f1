"""Fixed tendons, actuators and equalities of an MJCF file.

A fixed tendon has the length L = Σ c_i q_i. An actuator of gear γ on the coordinate or length x exerts along it

    F = γ f,      f = gain u + bias,      gain = g_0 + g_1 γ x + g_2 γ x',      bias = b_0 + b_1 γ x + b_2 γ x'

with the control u, a parameter of the system; u and f stay within their ranges.

Source: MuJoCo's documentation, computation, actuation model; XML reference, actuator, tendon, equality.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import sympy

from ...errors import nearest
from ...scalar.expression import exact
from ...space.pose import Pose
from ...space.rotation import Rotation
from ..builder import refused, whole
from ..xml_tree import Element
from .placing import of_quaternion
from .words import ACTUATORS, EQUALITIES, TENDONS, TRANSMISSIONS

Weights = dict[str, float]


def add_forces(reader: Any) -> None:
    """Add tendons, actuators and equalities to the reader's system."""
    for section in ("tendon", "actuator", "equality"):
        _check_names(reader, section)
    tendons = _tendons(reader)
    for number, element in enumerate(reader.document.sections("actuator"), start=1):
        _actuator(reader, element, number, tendons)
    for number, element in enumerate(reader.document.sections("equality"), start=1):
        _equality(reader, element, number, tendons)


def _check_names(reader: Any, section: str) -> None:
    """Refuse a name that two elements of a section have."""
    seen: set[str] = set()
    for element in reader.document.sections(section):
        name = element.attributes.get("name")
        if name in seen:
            raise element.error(f"expected each {section} once, got '{name}' again")
        seen.update([name] if name else [])


def _named_tendon(reader: Any, element: Element, key: str, tendons: dict[str, Weights]) -> Weights | None:
    """Return the weights of the tendon that an attribute names; None for one that is not fixed."""
    name = element.get(key)
    known = [one.attributes.get("name") for one in reader.document.sections("tendon")]
    if name not in known and name not in tendons:
        listed = [one for one in (*known, *tendons) if one]
        raise element.error(f"unknown tendon '{name}' of <{element.tag}>; {nearest(name, listed)}")
    return tendons.get(name)


# -- tendons ------------------------------------------------------------------------------------------


def _tendons(reader: Any) -> dict[str, Weights]:
    """Return the weights of the joints of each fixed tendon; add springs and dampers."""
    tendons: dict[str, Weights] = {}
    for number, element in enumerate(reader.document.sections("tendon"), start=1):
        full = reader.document.full(element)
        name = element.attributes.get("name") or f"tendon{number}"
        what = TENDONS.get(element.tag, "not a tendon that freebody knows")
        if what:
            reader.reading.left_out(f"<{element.tag}> '{name}'", element.line, what)
            continue
        weights: Weights = {}
        for one in element.all("joint"):
            joint = _single(reader, one, one.get("joint"), f"tendon '{name}'")
            weights[joint] = weights.get(joint, 0.0) + one.number("coef")
        if not weights:
            raise element.error(f"expected joints in the fixed tendon '{name}'")
        tendons[name] = weights
        reader.reading.counts["tendon"] += 1
        _tendon_forces(reader, full, name, weights)
    return tendons


def _tendon_forces(reader: Any, element: Element, name: str, weights: Weights) -> None:
    """Add the spring and damper of a tendon, and report what it has beside them."""
    what = f"<fixed> '{name}'"
    for attribute, missing in (
        ("frictionloss", "it moves without dry friction"),
        ("armature", "a tendon has no inertia"),
    ):
        if any(element.several(attribute)):
            reader.reading.left_out(what, element.line, f"{attribute}: {missing}")
    k, d = element.number("stiffness", 0), element.number("damping", 0)
    length, rate = _length(reader, weights)
    limits = element.pair("range")
    if limits and element.choice("limited", ("false", "true", "auto"), "auto") != "false":
        reader.stop(what, element.line, name, length, limits)
    force: Any = 0
    if k:
        ends = element.several("springlength") or (-1.0,)
        if len(ends) > 2:
            raise element.error(f"expected one or two numbers for springlength= of {what}, got {len(ends)}")
        low, high = ends[0], ends[-1]
        if low == -1:  # the length of the pose in which springs are at rest
            low = high = sum(c * reader.joint_of[joint].rest for joint, c in weights.items())
        stiffness = reader.parameter(f"k_{name}", k, "N/m")
        stretch = length - exact(low)
        if low != high:
            stretch = sympy.Max(0, length - exact(high)) - sympy.Max(0, exact(low) - length)
        force -= stiffness * stretch
    if d:
        force -= reader.parameter(f"d_{name}", d, "N s/m") * rate
    if force != 0:
        _along(reader, f"{name}_spring", weights, force)


def _length(reader: Any, weights: Weights) -> tuple[Any, Any]:
    """Return Σ c q and its rate."""
    length = sum((exact(c) * reader.displacements[joint] for joint, c in weights.items()), sympy.Integer(0))
    return length, sympy.sympify(length).diff(reader.s.t)


def _along(reader: Any, name: str, weights: Weights, force: Any) -> None:
    """Add a force conjugate to Σ c q: on each coordinate c times the force."""
    for number, (joint, c) in enumerate(weights.items(), start=1):
        text = reader.renamed(name if len(weights) == 1 else f"{name}_{number}", reader.loads)
        reader.s.generalized_force(reader.displacements[joint], exact(whole(c)) * force, name=text)


def _single(reader: Any, element: Element, name: str, what: str) -> str:
    """Return the name of a joint of one coordinate."""
    if name not in reader.joint_of:
        raise element.error(f"unknown joint '{name}' of {what}; {nearest(name, reader.joint_of)}")
    if name not in reader.displacements:
        raise element.error(
            f"expected a hinge or slide for {what}, got the {reader.joint_of[name].kind} joint '{name}'"
        )
    return name


# -- actuators ----------------------------------------------------------------------------------------


@dataclass
class Law:
    """Force of an actuator, as the elements of its class and its own say one after the other."""

    gain: list[float] = field(default_factory=lambda: [1.0, 0.0, 0.0])
    bias: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    dynamics: str = "none"
    problem: str = ""

    def put(self, element: Element) -> None:
        """Take what an element says."""
        given = element.attributes
        match element.tag:
            case "general":
                self._general(element)
            case "motor":
                self.gain, self.bias, self.dynamics = [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], "none"
            case "position":
                k = element.number("kp", self.gain[0])
                d = element.number("kv", -self.bias[2])
                self.gain, self.bias = [k, 0.0, 0.0], [0.0, -k, -d]
                if element.number("dampratio", 0):
                    self.problem = "dampratio: it has no damping"
                self.dynamics = "filterexact" if element.number("timeconst", 0) else "none"
            case "velocity":
                k = element.number("kv", self.gain[0])
                self.gain, self.bias, self.dynamics = [k, 0.0, 0.0], [0.0, 0.0, -k], "none"
            case "damper":
                k = element.number("kv", 0) if "kv" in given else -self.gain[2]
                self.gain, self.bias, self.dynamics = [0.0, 0.0, -k], [0.0, 0.0, 0.0], "none"
            case _:
                self.problem = ""

    def _general(self, element: Element) -> None:
        """Take the terms of a general actuator."""
        for name in ("gain", "bias"):
            kind = element.attributes.get(f"{name}type")
            terms = list(element.several(f"{name}prm"))[:3]
            own = getattr(self, name)
            own[: len(terms)] = terms
            if kind == "fixed":
                own[1:] = [0.0, 0.0]
            elif kind == "none":
                own[:] = [0.0, 0.0, 0.0]
            elif kind not in (None, "affine"):
                self.dynamics = kind
        self.dynamics = element.attributes.get("dyntype", self.dynamics)


def _actuator(reader: Any, element: Element, number: int, tendons: dict[str, Weights]) -> None:
    """Add an actuator with its control as a parameter."""
    full = reader.document.full(element)
    name = element.attributes.get("name") or f"actuator{number}"
    what = f"<{element.tag}> '{name}'"
    law = Law()
    for one in reader.document.given(element):
        law.put(one)
    problem = ACTUATORS.get(element.tag, "not an actuator that freebody knows")
    problem = problem or next(
        (text for key, text in TRANSMISSIONS.items() if text and key in full.attributes), ""
    )
    if not problem and law.dynamics != "none":
        problem = f"its activation is a state that the machine does not have ({law.dynamics})"
    weights = {} if problem else _transmission(reader, full, what, tendons)
    if not problem and not weights:
        problem = "acts on a ball or free joint, or on a spatial tendon"
    if problem:
        reader.reading.left_out(what, element.line, problem)
        return
    if law.problem:
        reader.reading.left_out(what, element.line, law.problem)
    gears = full.several("gear") or (1.0,)
    weights = {joint: gears[0] * c for joint, c in weights.items()}
    length, rate = _length(reader, weights)
    text = reader.name(f"u_{name}")
    u = reader.s.parameters(**{text: 0})
    reader.s.describe(text, about=f"control of the {element.tag} actuator")
    reader.reading.inputs[name] = text
    reader.reading.counts["actuator"] += 1
    for key in ("armature", "damping"):
        if any(full.several(key)):
            reader.reading.left_out(what, element.line, f"{key}: give it to the joint")
    u = _between(u, _range(reader, full, "ctrl", weights))
    gain, bias = (_affine(terms, length, rate) for terms in (law.gain, law.bias))
    _along(reader, name, weights, _between(gain * u + bias, _range(reader, full, "force", weights)))


def _affine(terms: list[float], length: Any, rate: Any) -> Any:
    a, b, c = (exact(whole(x)) for x in terms)
    return a + b * length + c * rate


def _transmission(reader: Any, element: Element, what: str, tendons: dict[str, Weights]) -> Weights:
    """Return the weights of the joints on which an actuator acts; none if it cannot be read."""
    for attribute in ("joint", "jointinparent"):
        if attribute in element.attributes:
            joint = element.get(attribute)
            if joint not in reader.joint_of:
                raise element.error(f"unknown joint '{joint}' of {what}; {nearest(joint, reader.joint_of)}")
            return {joint: 1.0} if joint in reader.displacements else {}
    if "tendon" in element.attributes:
        return dict(_named_tendon(reader, element, "tendon", tendons) or {})
    raise element.error(f"expected joint= or tendon= of {what}")


def _range(reader: Any, element: Element, kind: str, weights: Weights) -> tuple[float, float] | None:
    """Return the range of the control or force of an actuator that is limited."""
    limited = element.choice(f"{kind}limited", ("false", "true", "auto"), "auto")
    bounds = element.pair(f"{kind}range")
    inherited = element.number("inheritrange", 0)
    if kind == "ctrl" and inherited and len(weights) == 1:
        limits = reader.joint_of[next(iter(weights))].limits
        if limits is not None:
            middle, half = (limits[0] + limits[1]) / 2, inherited * (limits[1] - limits[0]) / 2
            return (middle - half, middle + half)
    if limited == "false" or bounds is None or (limited == "auto" and bounds[0] == bounds[1]):
        return None
    if limited == "auto" and not reader.document.compiler.autolimits:
        raise element.error(f"expected {kind}limited= with {kind}range=, since autolimits='false'")
    return bounds


def _between(value: Any, bounds: tuple[float, float] | None) -> Any:
    """Return a value kept between two bounds."""
    if bounds is None:
        return value
    low, high = (exact(whole(x)) for x in bounds)
    return sympy.Max(low, sympy.Min(high, value))


# -- equalities ---------------------------------------------------------------------------------------


def _equality(reader: Any, element: Element, number: int, tendons: dict[str, Weights]) -> None:
    """Add an equality as an exact constraint."""
    full = reader.document.full(element)
    name = element.attributes.get("name") or f"equality{number}"
    what = f"<{element.tag}> '{name}'"
    problem = EQUALITIES.get(element.tag, "not an equality that freebody knows")
    if not problem and full.choice("active", ("false", "true"), "true") == "false":
        problem = "it is not active"
    if problem:
        reader.reading.left_out(what, element.line, problem)
        return
    added = {"joint": _joints, "tendon": _lengths, "connect": _loop, "weld": _loop}[element.tag]
    reason = added(reader, full, name, tendons)
    if reason:
        reader.reading.left_out(what, element.line, reason)
        return
    reader.reading.counts["equality"] += 1
    if any(key in full.attributes for key in ("solref", "solimp")):
        reader.reading.changed(what, element.line, "a soft constraint is exact here")


def _polynomial(element: Element, y: Any, x: Any) -> Any:
    """Return y - Σ a_k x^k."""
    terms = element.several("polycoef") or (0.0, 1.0, 0.0, 0.0, 0.0)
    return y - sum((exact(whole(a)) * x**k for k, a in enumerate(terms[:5])), sympy.Integer(0))


def _joints(reader: Any, element: Element, name: str, tendons: dict[str, Weights]) -> str:
    """Couple two joints, or hold one: displacements from the file's pose."""
    del tendons
    ends = []
    for key in ("joint1", "joint2"):
        if key in element.attributes:
            joint = _single(reader, element, element.get(key), f"equality '{name}'")
            ends.append(reader.displacements[joint] - exact(reader.joint_of[joint].ref))
    if not ends:
        raise element.error(f"expected the attribute 'joint1' of equality '{name}'")
    x = ends[1] if len(ends) > 1 else sympy.Integer(0)
    with refused(element):
        reader.s.constrain(_polynomial(element, ends[0], x), name=reader.renamed(name, reader.joints))
    return ""


def _lengths(reader: Any, element: Element, name: str, tendons: dict[str, Weights]) -> str:
    """Couple the lengths of two fixed tendons, or hold one."""
    ends = []
    for key in ("tendon1", "tendon2"):
        if key in element.attributes:
            weights = _named_tendon(reader, element, key, tendons)
            if weights is None:
                return "an equality of spatial tendons"
            drawn = sum(c * reader.joint_of[joint].ref for joint, c in weights.items())
            ends.append(_length(reader, weights)[0] - exact(drawn))
    if not ends:
        raise element.error(f"expected the attribute 'tendon1' of equality '{name}'")
    x = ends[1] if len(ends) > 1 else sympy.Integer(0)
    with refused(element):
        reader.s.constrain(_polynomial(element, ends[0], x), name=reader.renamed(name, reader.joints))
    return ""


def _pair(reader: Any, element: Element, name: str) -> list[tuple[str, Any, Pose]]:
    """Return name, carrier and pose in it of the two bodies (or sites) of an equality."""
    keys = ("site1", "site2") if "site1" in element.attributes else ("body1", "body2")
    pairs = []
    for key in keys:
        one = element.attributes.get(key, "world") if key != keys[0] else element.get(key)
        known = reader.carriers if key.startswith("body") else reader.sites
        if one not in known:
            kind = key[:4]
            raise element.error(f"unknown {kind} '{one}' of equality '{name}'; {nearest(one, known)}")
        pairs.append((one, *known[one]))
    return pairs


def _drags(reader: Any, *names: str) -> bool:
    """Return True if one of the bodies is moved by hand in MuJoCo."""
    return any(name in reader.bodies_of and reader.bodies_of[name].mocap for name in names)


def _loop(reader: Any, element: Element, name: str, tendons: dict[str, Weights]) -> str:
    """Close a loop between two bodies: at a point of both (connect), or in their pose (weld)."""
    del tendons
    (one, first, X), (two, second, Y) = _pair(reader, element, name)
    if _drags(reader, one, two):
        return "a mocap body drags nothing"
    if first is second:
        return "its bodies are one"
    sites = "site1" in element.attributes
    with refused(element):
        text = reader.renamed(name, reader.joints)
        if element.tag == "connect":
            at, to = (Pose(), Pose()) if sites else _anchors(reader, element, one, two)
            reader.s.ball(text, first, second, at=(X @ at).position, to=(Y @ to).position)
        else:
            held = X @ (Pose() if sites else _relative(reader, element, one, two))
            axes = {"parent_axes": held.rotation.matrix, "child_axes": Y.rotation.matrix}
            reader.s.weld(text, first, second, at=held.position, to=Y.position, **axes)
    return ""


def _anchors(reader: Any, element: Element, one: str, two: str) -> tuple[Pose, Pose]:
    """Return the anchor of a connect in both bodies; it is the same point in the pose of the file."""
    anchor: Any = tuple(map(whole, element.numbers("anchor", 3)))
    in_ground = reader.places[one].point(anchor)
    return Pose(position=anchor), Pose(position=reader.places[two].inverse.point(in_ground))


def _relative(reader: Any, element: Element, one: str, two: str) -> Pose:
    """Return the pose of the second body of a weld in the first: ``relpose``, or that in the pose of the file."""
    numbers = element.numbers("relpose", 7, (0.0,) * 7)
    if not any(numbers[3:]):
        pose: Pose = reader.places[one].inverse @ reader.places[two]
        return pose
    at: Any = tuple(map(whole, numbers[:3]))
    return Pose(Rotation.trusted(of_quaternion(element, numbers[3:])), at)
