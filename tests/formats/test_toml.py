"""Model files: what a file says, and that writing and reading are inverse."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import sympy

import freebody as fb
from freebody.describe.description import about_of, names_of, parameters_of, positive_in
from freebody.describe.joints.joint import KINDS as JOINT_KINDS
from freebody.describe.shapes.shape import KINDS
from freebody.formats import read_case
from freebody.formats.text import expression_text, toml_number
from freebody.formats.toml.read import CONSTRAINTS, SOLIDS, case_from_text
from freebody.formats.toml.write import toml_text
from freebody.gallery import entries
from freebody.scalar.algebra import IDENTITY
from freebody.testing import random_system
from sampled import sampled

JOINTS = [name for name, kind in JOINT_KINDS.items() if kind.__module__.startswith("freebody.")]

PAGE = Path(__file__).parents[2] / "docs" / "model-files.md"
EXAMPLES = re.findall(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def described(system: fb.System) -> dict[str, object]:
    """Everything a system holds, bodies of different systems told by name."""

    def plain(value: object) -> object:
        if isinstance(value, dict):
            return {str(k): plain(v) for k, v in value.items()}
        if isinstance(value, tuple | list):
            return tuple(plain(v) for v in value)
        if hasattr(value, "mass_properties"):
            return value.name
        if hasattr(value, "__dataclass_fields__"):
            kept = [
                f
                for f in value.__dataclass_fields__
                if f not in ("arguments", "written_axis", "system", "shape", "positive")
            ]
            return (type(value).__name__, *(plain(getattr(value, f)) for f in kept))
        return value

    return {
        "name": system.name,
        "parameters": plain(tuple(parameters_of(system))),
        "kinds": list(names_of(system).kinds.items()),
        "bodies": {name: plain(body.mass_properties) for name, body in system.bodies.items()},
        "joints": plain(system.joints),
        "loads": list(plain(system.loads).items()),  # type: ignore[attr-defined]
        "constraints": list(plain(system.constraints).items()),  # type: ignore[attr-defined]
        "contacts": list(plain(system.contacts).items()),  # type: ignore[attr-defined]
        "order": [*system.joints],
        "gravity": system.gravity,
        "about": about_of(system),
    }


def again(system: fb.System, **more: object) -> fb.System:
    """The system after a round trip, equal to the one before."""
    text = toml_text(system, **more)
    result = case_from_text(text, "again.toml").system
    assert described(result) == described(system)
    assert positive_in(system) <= positive_in(result) | {sympy.sympify(p) for p in positive_in(result)}
    assert toml_text(result, **more) == text
    return result


def cart_and_bar() -> fb.System:
    s = fb.System("cart_and_bar")
    M, m, a, k, g, F = s.parameters(M=2.0, m=1.0, a=0.5, k=50.0, g=9.81, F=3.0)
    s.describe(F, unit="N", about="force at the lower end")
    s.assume(k > 0)
    s.gravity = (0, -g, 0)
    cart = s.body("cart", fb.particle(M))
    bar = s.body("bar", fb.slender_bar(m, 2 * a, axis="y"))
    guide = s.slider("guide", s.ground, cart, axis="x", coordinate="x")
    s.hinge("pin", cart, bar, to=(0, a, 0), axis="z", coordinate="theta")
    s.spring("k", guide, stiffness=k)
    s.force("F", bar.point(0, -a, 0), (F, 0, 0))
    return s


# --- the page of the documentation ---


def test_the_example_of_the_page_is_the_system_built_in_python() -> None:
    case = case_from_text(EXAMPLES[0], "page.toml")
    assert described(case.system) == described(cart_and_bar())
    assert case.initial == {"theta": sympy.pi / 36, "theta'": 0}
    assert (case.until, case.tolerance) == (2, 1e-10)


def test_the_hole_of_the_page() -> None:
    system = case_from_text(EXAMPLES[1], "wheel.toml").system
    mass = system.bodies["wheel"].mass_properties
    assert mass is not None
    assert float(mass.mass) == pytest.approx(3.84)
    # 3.84 c = 4 * 0 - 0.16 * 0.3
    assert float(mass.center[0]) == pytest.approx(-0.0125)


def test_the_page_names_every_solid_joint_and_key() -> None:
    page = PAGE.read_text(encoding="utf-8")
    for word in (*SOLIDS, *JOINTS, *CONSTRAINTS, *(key for keys in CONSTRAINTS.values() for key in keys)):
        assert f"`{word}`" in page
    own = {name: kind for name, kind in KINDS.items() if kind.__module__.startswith("freebody.")}
    for word in (*own, *(word for kind in own.values() for word in kind.words)):
        assert f"`{word}`" in page
    assert len(EXAMPLES) == 4


# --- round trips ---


def test_round_trip_of_the_cart() -> None:
    again(cart_and_bar(), initial={"x": "a/2", "theta'": 1.5}, until="2*pi", tolerance=1e-8)


@pytest.mark.parametrize("solid", SOLIDS)
def test_round_trip_of_each_solid(solid: str) -> None:
    s = fb.System(solid)
    m, a, b = s.parameters(m=1.0, a=0.5, b=2.0)
    dimensions = {
        "particle": (),
        "slender_bar": (2 * a, (1, 2, 0)),
        "disk": (a, "x"),
        "ring": (a,),
        "cylinder": (a, b, "y"),
        "tube": (1, 2, b),
        "cone": (a, b),
        "box": ((a, b, 1),),
        "plate": ((a, b), "x"),
        "sphere": (a,),
        "spherical_shell": ("1/3" and sympy.Rational(1, 3),),
        "ellipsoid": ((a, b, 0.3),),
        "torus": (2, 0.5, "x"),
    }[solid]
    body = s.body("body", getattr(fb, solid)(m, *dimensions).moved((0, a, 0)))
    s.free("air", s.ground, body)
    mass = again(s).bodies["body"].mass_properties
    assert mass is not None and mass.shape == body.mass_properties.shape  # type: ignore[union-attr]


def test_round_trip_of_a_turned_solid_keeps_its_mass_properties() -> None:
    s = fb.System("turned")
    m, a = s.parameters(m=1.0, a=0.5)
    turned = fb.cone(m, a, 1).rotated(((0, 0, 1), (1, 0, 0), (0, 1, 0)))
    s.free("air", s.ground, s.body("body", turned))
    again(s)


def every_joint() -> fb.System:
    s = fb.System("every joint")
    p = s.parameters(p=0.1)
    bodies = [s.ground, *(s.body(f"b{i}", fb.sphere(1, 1)) for i in range(12))]
    ends = iter(zip(bodies, bodies[1:], strict=False))
    s.hinge("hinge", *next(ends), at=(1, 0, p), axis=(1, 2, 0), coordinate="alpha")
    s.ball("ball", *next(ends), to=(0, 0, 1))
    s.slider("slider", *next(ends), axis="-y")
    s.cylindrical("cylindrical", *next(ends), axis="x")
    s.screw("screw", *next(ends), pitch=p / 2, coordinate="beta")
    s.universal("universal", *next(ends), axis=("x", (0, 1, 1)))
    s.gimbal("gimbal", *next(ends), axis="XYZ", coordinate=("psi", "phi", "chi"))
    s.planar("planar", *next(ends), axis="y", parent_axes=((0, -1, 0), (1, 0, 0), (0, 0, 1)))
    s.free("free", *next(ends), coordinate="f")
    s.weld("weld", *next(ends), child_axes=((0, 0, 1), (1, 0, 0), (0, 1, 0)))
    motions = [
        fb.Hinge("x", "hip", armature=2, rotor=fb.Rotor(p, 3)),
        fb.Screw((0, 3, 4), "knee", at=(0, p, -1), pitch=p),
        fb.Slider("-z", "3*hip"),
    ]
    turns = [("z", "0.5*u"), ((1, 2, 2), "v*u")]
    s.path_joint("path", *next(ends), coordinate="u v", position=("u", "v^2", 3), turns=turns, at=(1, 2, 3))
    s.chain("chain", *next(ends), motions, at=(1, 2, 3), parent_axes=((0, 0, 1), (1, 0, 0), (0, 1, 0)))
    return s


def test_round_trip_of_every_joint() -> None:
    system = every_joint()
    assert {joint.type for joint in system.joints.values()} == set(JOINTS)
    assert 'coordinate = "f"' in toml_text(system)
    assert "\ncoordinates =" not in toml_text(system)  # the joints declare them in the right order
    assert again(system).joints["planar"].parent_axes != IDENTITY


def test_round_trip_of_every_load() -> None:
    s = fb.System("loads")
    c = s.parameters(c=0.5)
    a, b = s.body("a", fb.sphere(1, 1)), s.body("b", fb.sphere(1, 1))
    turn = s.hinge("turn", s.ground, a, coordinate="theta")
    push = s.slider("push", a, b, coordinate="x")
    s.torque("motor", turn, "-c*theta' + sin(3*t)")
    s.force("thrust", push, "exp(-t)*max(x, 0)")
    s.spring("wire", a.point(0, 1, 0), s.ground.point(0, 2, 0), stiffness=3, rest="c/3")
    s.force("wind", b, ("abs(x')*x'", 0, "sqrt(c)"), frame=a)
    s.damper("oil", push, damping=c)
    s.torque("couple", b, (0, 0, "atan2(x, c)"), frame=b, reaction_on=a)
    s.damper("dashpot", a.point(0, 0, 1), b, damping=2.25)
    s.torsion_spring("coil", turn, stiffness=1, rest=0.1)
    s.generalized_force("x", "-x**3/7")
    assert list(again(s).loads) == [
        "motor", "thrust", "wire", "wind", "oil", "couple", "dashpot", "coil", "Q_x",
    ]  # fmt: skip


def test_absolute_angles_keep_their_order() -> None:
    s = fb.System("double pendulum")
    q2, q1 = s.coordinates("theta2 theta1")
    one, two = s.body("one", fb.slender_bar(1, 1)), s.body("two", fb.slender_bar(1, 1))
    s.hinge("O", s.ground, one, coordinate=q1)
    s.hinge("A", one, two, coordinate=q2 - q1)
    assert 'coordinates = ["theta2", "theta1"]' in toml_text(s)
    again(s)


def test_a_coordinate_used_by_two_joints() -> None:
    s = fb.System("coupled")
    one, two = s.body("one", fb.sphere(1, 1)), s.body("two", fb.sphere(1, 1))
    s.hinge("A", s.ground, one, coordinate="q")
    s.hinge("B", s.ground, two, coordinate=s.expression("q"))
    again(s)


def test_the_start_of_a_ball_joint() -> None:
    s = fb.System("top")
    s.ball("pivot", s.ground, s.body("top", fb.sphere(1, 1)), to=(0, 0, -1))
    start = {"pivot": (sympy.sqrt(2) / 2, 0.0, "sqrt(2)/2", 0), "pivot_wz": 30}
    text = toml_text(s, initial=start)
    assert 'pivot = ["sqrt(2)/2", 0, "sqrt(2)/2", 0]' in text
    case = case_from_text(text)
    assert case.initial == {"pivot": (sympy.sqrt(2) / 2, 0, sympy.sqrt(2) / 2, 0), "pivot_wz": 30}
    motion = fb.simulate(case.system, 0.01, initial=case.initial)
    assert motion["pivot_e2"][0] == pytest.approx(0.5**0.5)


def test_a_driven_shaft_and_an_open_parameter() -> None:
    s = fb.System("shaft")
    omega = s.parameters("omega")
    s.hinge("shaft", s.ground, s.body("rotor", fb.disk(1, 1)), coordinate=omega * s.t)
    assert "omega = {}" in toml_text(s)
    assert parameters_of(again(s))[0].default is None


def test_names_that_need_quotes() -> None:
    s = fb.System('a "quoted"\\ name\n\x7f é')
    x = s.parameters(x=1e-300)
    s.describe(x, unit="µm", about="line 1\nline 2")
    s.free("air", s.ground, s.body("body", fb.sphere(x, x)))
    assert again(s).name == s.name


@pytest.mark.parametrize("seed", range(5))
def test_random_machines_survive_a_round_trip(seed: int) -> None:
    again(random_system(seed, 6))


@pytest.mark.parametrize("name", sampled(entries(), 3, ("whipple-bicycle", "prob-6-18")))
def test_round_trip_of_the_gallery(name: str) -> None:
    again(entries()[name].build())


# --- files ---


def test_read_and_write_files(tmp_path: Path) -> None:
    path = tmp_path / "cart.toml"
    fb.write(cart_and_bar(), path, initial={"theta": "5deg"}, until=2)
    assert described(fb.read(path)) == described(cart_and_bar())
    case = read_case(str(path))
    assert case.until == 2 and case.tolerance is None
    assert [p.name for p in tmp_path.iterdir()] == ["cart.toml"]


def test_a_failed_write_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "cart.toml"
    path.write_text("old")
    system = cart_and_bar()
    x = system.expression("x")
    system.force("odd", system.bodies["cart"], (sympy.floor(x), 0, 0))
    with pytest.raises(
        fb.errors.FormatError, match=r"Expected an expression that a model file can hold, got 'floor"
    ):
        fb.write(system, path)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["cart.toml"]


def test_the_name_of_the_file_is_the_name_of_the_system(tmp_path: Path) -> None:
    path = tmp_path / "unnamed.toml"
    path.write_text("\ufeff[bodies.b]\nmass = 1\n[joints.j]\ntype = 'free'\nchild = 'b'\n", encoding="utf-8")
    assert fb.read(path).name == "unnamed"


def test_order_of_the_tables_does_not_matter() -> None:
    tables = re.split(r"\n(?=\[)", EXAMPLES[0])
    turned = "\n".join([tables[0], *reversed(tables[1:])])
    system = case_from_text(turned, "turned.toml").system
    assert set(system.bodies) == {"cart", "bar"}
    assert list(system.loads) == ["F", "k"]


# --- pieces ---


def test_expression_text() -> None:
    t, k, x = sympy.Symbol("t"), sympy.Symbol("k"), sympy.Function("x")(sympy.Symbol("t"))
    texts = {t: "t", k: "k", x: "x", x.diff(t): "x'"}
    cases = {
        k / 3 - x.diff(t) ** 2: "k/3 - x'**2",
        sympy.sqrt(k) * sympy.Abs(x): "sqrt(k)*abs(x)",
        1 / sympy.sqrt(k): "1/sqrt(k)",
        sympy.Max(k, 0) + sympy.pi: "max(0, k) + pi",
        sympy.E: "exp(1)",
        sympy.exp(-t): "exp(-t)",
        k ** sympy.Rational(-3, 2): "k**(-3/2)",
    }
    from freebody.scalar.parser import parse

    for expression, text in cases.items():
        written = expression_text(expression, texts)
        assert parse(written, {v: k for k, v in texts.items()}) == expression
        assert written == text


def test_expression_text_refuses_strangers() -> None:
    with pytest.raises(fb.errors.FormatError, match="own names, got the symbol 'z'"):
        expression_text(sympy.Symbol("z"), {})


def test_toml_number() -> None:
    from fractions import Fraction

    assert toml_number(Fraction(1, 10)) == 0.1
    assert toml_number(Fraction(1, 3)) is None
    assert toml_number(2**62) == 2**62
    assert toml_number(2**70 + 1) is None
    assert toml_number(10**400) is None
    assert toml_number(sympy.pi) is None


# --- constraints ---


def constrained() -> fb.System:
    """A loop and one constraint of each kind."""
    s = fb.System("constrained")
    r, L = s.parameters(r=0.5, L=4.0)
    crank, rod, wheel, weight = (s.body(n, fb.box(1, (1, 2, 3))) for n in ("crank", "rod", "wheel", "weight"))
    shaft = s.hinge("shaft", s.ground, crank, coordinate="a")
    s.hinge("pin", crank, rod, at=(1, 0, 0), coordinate="b")
    s.slider(
        "guide", s.ground, rod, at=(0, 1, 0), axis="-y", parent_axes=fb.Rotation.euler("XYZ", 0.1, 0.2, 0.3)
    )
    s.free("air", s.ground, wheel)
    s.hinge("drum", s.ground, weight, at=(0, 3, 0), axis="x", coordinate="d")
    s.universal("hook", wheel, weight, axis=("y", (1, 0, 1)))
    s.constrain("sin(a) = b^2 + t", name="wire")
    s.constrain_speed("r*a' - cos(b)*d'", name="blade")
    s.gear(shaft, s.joints["drum"], -r, pressure_angle=sympy.pi / 9)
    s.rope([s.ground.point(0, 1, 0), rod.origin, weight.point(0, "r", 0)], L + s.t / 2, name="line")
    s.rolling("contact", wheel.point(0, 0, "r/2"), radius=r, axis=("sin(r)", 0, "cos(r)"), normal="-z")
    s.rolling("ball", weight, radius=2 * r, normal="x", plane=s.ground.point(0, 0, "r"))
    return s


def test_round_trip_of_constraints() -> None:
    result = again(constrained(), initial={"a": 0.1}, near={"b": "r/2", "air_x": 1}, until=2)
    assert [*result.constraints] == ["wire", "blade", "gear_shaft_drum", "line", "contact", "ball"]
    assert [name for name, joint in result.joints.items() if joint.closes] == ["guide", "hook"]
    assert result.constraints["gear_shaft_drum"].pressure_angle == sympy.pi / 9
    assert fb.assemble(result).constraints.keys() == fb.assemble(constrained()).constraints.keys()


def test_near_is_kept() -> None:
    case = case_from_text(toml_text(constrained(), near={"b": "r/2"}), "again.toml")
    assert case.initial == {} and str(case.near["b"]) == "r/2"


def test_the_disk_of_the_page_rolls() -> None:
    case = case_from_text(EXAMPLES[2], "disk.toml")
    found = fb.simulate(case.system, 2, initial=case.initial, near=case.near)
    # x'' = 2/3 g sin(beta)
    assert found["x"][-1] == pytest.approx(2 / 3 * 5 * 2**2 / 2)
    assert found["turn"][-1] == pytest.approx(-found["x"][-1] / 0.25)


def test_order_of_joints_decides_which_one_closes_the_loop() -> None:
    text = toml_text(constrained())
    first, second = text.index("[joints.pin]"), text.index("[joints.guide]")
    third = text.index("[joints.air]")
    swapped = text[:first] + text[second:third] + text[first:second] + text[third:]
    with pytest.raises(fb.errors.FormatError, match="'pin' closes a loop.*Leave out coordinate="):
        case_from_text(swapped, "swapped.toml")


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ('type = "chain"', "constraints.held.type: Unknown type of constraint 'chain'; known names"),
        ('type = "condition"', "Expected the key 'expression', but it is missing"),
        ('type = "condition"\nexpression = true', "Expected a number or an expression in quotes, got true or false"),
        ('type = "speed"\nexpression = "theta"', "contains no speed"),
        ('type = "gear"\nfirst = "pn"\nsecond = "pin"\nratio = 2', "held.first: Unknown joint 'pn'; did you mean"),
        ('type = "gear"\nfirst = "pin"\nsecond = "pin"\nratio = 2', "couples two joints, got 'pin' twice"),
        ('type = "rope"\npoints = "bar"\nlength = 1', "held.points: Expected a list of points, got 'bar'"),
        ('type = "rope"\npoints = ["bar", "baz"]\nlength = 1', "Unknown body 'baz'"),
        ('type = "rolling"\nwheel = "bar"\nradius = 1\nnormal = "q"', "Expected 'x', 'y' or 'z', with or without"),
        ('type = "rolling"\nwheel = "bar"\nradius = 1\nspin = 2', "held.spin: Unknown key 'spin'"),
    ],
)  # fmt: skip
def test_refused_constraints(keys: str, message: str) -> None:
    text = f"""
[bodies.bar]
solid = "particle"
mass = 1
[joints.pin]
type = "hinge"
child = "bar"
to = [0, 1, 0]
coordinate = "theta"
[constraints.held]
{keys}
"""
    with pytest.raises(fb.errors.FormatError, match=r"bad.toml, line 1\d, constraints.held") as caught:
        case_from_text(text, "bad.toml")
    assert message in str(caught.value)


# --- contacts ---


def touching() -> fb.System:
    s = fb.System("every shape")
    R, mu, b = s.parameters(R=0.3, mu=0.2, b="30deg")
    disk, bar = s.body("disk", fb.disk(1, R)), s.body("bar", fb.slender_bar(1, 2))
    s.planar("p", s.ground, disk, coordinate="x y f")
    s.planar("q", s.ground, bar, coordinate="x1 y1 f1")
    ground = s.ground
    slope = ground.plane(normal=(sympy.sin(b), sympy.cos(b), 0))
    s.contact(
        "floor", disk.circle(R), slope, friction=mu, static_friction=mu * 2, restitution=0.5, impact="poisson"
    )
    s.contact("pipe", disk.circle(R, at=(0, 0.1, 0)), ground.cylinder(5 * R, inside=True, axis="-z"))
    s.contact("ledge", bar.segment((-1, 0, 0), (1, 0, 0), normal="-y"), ground.point(0, 0.1, 0), friction=0.3)
    s.contact("feet", bar.corners(size=(2, R)), ground.plane(at=(0, -1, 0)))
    s.contact("hill", bar.point(1, 0, 0), ground.heightline("0.3*sin(x/R) + x^2", at=(0, -2, 0)))
    road = ground.heightline("0.1*cos(x)", between=(-R, 2))
    s.contact("road", disk.circle(R), road, friction=mu)
    s.contact("two", disk.sphere(R), bar.sphere(R, at=(0, 0.2, 0)))
    s.contact("egg", disk.ellipsoid((R, 0.2, 0.1), at=(0, 0.1, 0)), ground.plane(at=(0, -3, 0)))
    s.contact("oblique", disk.point(0, R, 0), bar.cylinder(R, axis=(1, R, 2)))
    return s


def test_round_trip_of_solids() -> None:
    s = fb.System("solids")
    body = s.body("body", fb.sphere(1, 0.1))
    s.free("air", s.ground, body)
    solids = {
        "box": body.box((0.1, 0.2, 0.3), at=(0, 0, 0.1)),
        "hull": body.hull((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
        "capsule": body.capsule((0, 0, 0), (0, 0, 1), 0.1),
        "drum": body.drum(0.1, 0.2),
    }
    for name, solid in solids.items():
        s.contact(name, solid, s.ground.plane(normal="z"), friction=0.1)
    result = again(s)
    assert [c.name for c in fb.assemble(result).contacts] == [c.name for c in fb.assemble(s).contacts]
    assert result.contacts["hull"].feature.corners == solids["hull"].corners  # type: ignore[attr-defined]


def test_round_trip_of_contacts() -> None:
    result = again(touching())
    assert [c.name for c in fb.assemble(result).contacts] == [
        c.name for c in fb.assemble(touching()).contacts
    ]


def test_the_ball_of_the_page_touches_the_floor() -> None:
    system = case_from_text(EXAMPLES[-1], "page.toml").system
    (contact,) = fb.assemble(system).contacts
    assert (contact.name, contact.tangents, str(contact.restitution)) == ("floor", 1, "e")


@pytest.mark.parametrize(
    "old,new,message",
    [
        ('shape = "sphere"', 'shape = "spere"', "Unknown kind of shape 'spere'; did you mean 'sphere'?"),
        ('shape = "plane"', 'shape = "plane", body = "bal"', "Unknown body 'bal' in 'surface'; did you mean 'ball'?"),
        ('normal = "y"', 'radius = 1', "Unknown key 'radius'"),
        (", radius = 0.05 }", " }", "Expected the key 'radius', but it is missing."),
        ("radius = 0.05 }", "radius = 0.05, inside = 1 }", "Expected true or false, got 1."),
        ('surface = { shape = "plane", normal = "y" }', "", "Expected the key 'surface', but it is missing."),
        ("friction = 0.3", "friction = -0.3", "Expected a friction of 0 or more for contact 'floor', got -0.3."),
        ("friction = 0.3", "slip = 0.3", "Unknown key 'slip'"),
        ('{ shape = "plane", normal = "y" }', '{ shape = "segment", start = [0, 0, 0], normal = "y" }', "Expected the key 'end', but it is missing."),
        ('{ shape = "plane", normal = "y" }', '{ shape = "corners", points = 1 }', "Expected a list of points [[x, y, z], ...], got 1."),
        ('{ shape = "plane", normal = "y" }', '{ shape = "corners", size = [1] }', "Expected two or three edges [a, b, c], got [1]."),
        ('{ shape = "plane", normal = "y" }', '{ shape = "heightline", height = "z" }', "In the heightline of the ground"),
    ],
)  # fmt: skip
def test_refused_contacts(old: str, new: str, message: str) -> None:
    text = EXAMPLES[-1]
    # the last place: the ball's own radius comes first
    assert old in text
    head, _, tail = text.rpartition(old)
    with pytest.raises(fb.errors.FormatError, match=r"line \d+, contacts.floor") as caught:
        case_from_text(head + new + tail, "page.toml")
    assert message in str(caught.value)


def test_functions_that_sympy_makes_of_others(tmp_path):
    """tan(pi/2 - x) is cot(x) to SymPy; equations and files have its ratio."""
    s = fb.System("cotangent")
    rail = s.slider("rail", s.ground, s.body("ball", fb.particle(1)), coordinate="x")
    x = s.expression("x")
    s.spring("k", rail, force=sympy.tan(sympy.pi / 2 - x) ** 2 + 3 * sympy.sec(x) + sympy.csc(x))
    text = fb.equations(s).text()
    assert "sin(x)^2" in text and "3/cos(x)" in text
    fb.write(s, tmp_path / "cotangent.toml")
    assert fb.equations(fb.read(tmp_path / "cotangent.toml")).text() == text
