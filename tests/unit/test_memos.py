"""What is kept for later calls is never given to a call that asks for something else: one test for each memo.

`docs/caches.md` lists them. Those of a study's identity are tested in `test_identity`, those on the disk in
`test_compile_cache`.
"""

from __future__ import annotations

import ast
import ctypes
import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy

import freebody as fb
from batch_machines import CLOSED, four_bar, pendulum
from freebody.describe.description import names_of
from freebody.describe.names import rate
from freebody.gallery.textbook.examples.ex_6_3_pulled_disk import build as pulled_disk
from freebody.model.assemble import assemble
from freebody.motion.batch.kernels import batch_program
from freebody.motion.kernels.kernels import Kernels, kernels_of
from freebody.motion.kernels.reading import expression_of
from freebody.motion.lanes import loops as over_lanes
from freebody.motion.ode import loops
from freebody.motion.ode.memory import sizes
from freebody.motion.ode.run import Run
from freebody.motion.phase.scene import scene_of
from freebody.motion.start.arguments import _equal
from freebody.native.records import _layout
from freebody.native.translation import Unit
from freebody.picture.page.page import LIVE, SCRIPTS, script
from freebody.picture.paper.labels import outline
from freebody.program.code.ir_text import literal
from freebody.program.large.link_step import Kind, compiled_step
from freebody.scalar.ring import Ring
from freebody.scalar.trace import Tape
from freebody.symbolic.printing.angle_sums import _binomials, _spectrum, _waves
from freebody.symbolic.printing.latex import latex_name

# -- programs of a machine -----------------------------------------------------------------------------------


def test_a_changed_system_is_assembled_anew() -> None:
    """Kept by address and number of changes: every way to change a system counts."""
    s = pendulum()
    bar, pin = s.bodies["bar"], s.joints["pin"]
    seen = [kernels_of(s)]
    assert kernels_of(s) is seen[0]
    for change in (
        lambda: setattr(s, "gravity", (0, -1, 0)),
        lambda: setattr(s, "name", "moon"),
        lambda: s.parameters(more=1.0),
        lambda: s.assume(s.expression("more") > 0),
        lambda: s.describe("m", unit="kg"),
        lambda: s.force("more", bar.point(0, 1, 0), (1, 0, 0)),
        lambda: s.controller(lambda t, x: 0.0, 0.1, "more"),
        lambda: s.slider("rail", bar, s.body("second", fb.particle(1)), axis="x", coordinate="x"),
        lambda: s.constrain("x - 1"),
        lambda: s.contact("floor", s.bodies["second"].origin, s.ground.plane(normal="y")),
        lambda: s.expression(fb.signal([0, 1], [0, 1]), "a load"),
        lambda: s.loads.pop("more"),
        lambda: s.torsion_spring("k", pin, stiffness=1),
    ):
        change()
        seen.append(kernels_of(s))
        assert kernels_of(s) is seen[-1]
    assert len({id(one) for one in seen}) == len(seen) == 14
    assert kernels_of(s).model.name == "moon"
    with pytest.raises(fb.errors.ModelError, match="Expected a name"):
        s.name = " "


def falling_rod() -> fb.System:
    s = fb.System("rod")
    s.parameters(g=9.81, mu=0.3)
    s.gravity = (0, "-g", 0)
    bar = s.body("bar", fb.slender_bar(2, 1.5, axis="y"))
    s.planar("rail", s.ground, bar, coordinate="x y theta")
    tips = bar.corners((0, -0.75, 0), (0, 0.75, 0))
    s.contact("tip", tips, s.ground.plane(normal="y"), friction="mu", restitution=0.2)
    return s


def test_a_run_with_contacts_in_the_memory_of_another_one_is_the_same_to_the_last_bit() -> None:
    """Kept by method and watched functions: the next run has other values, another start, other events, an error."""
    s, start = falling_rod(), {"y": 0.8, "theta": 0.1, "theta'": 0.2}
    scene = scene_of(kernels_of(s))

    def run(s: fb.System = s, **options: Any) -> fb.Trajectory:
        return fb.simulate(s, 1, **{"initial": start, **options})

    first = run()
    (spare,) = scene.spare.values()
    (memory,) = spare
    kept, texts = first.states.copy(), str(first.modes)
    for other in (
        {"values": {"mu": 0.9, "g": 5}},
        {"initial": {"y": 2, "x'": 3}, "tolerance": 1e-6, "max_step": 0.01},
        {"indeterminate": "refuse", "impacts": "sequential"},
        {"events": [fb.event("theta - 0.3", terminal=True)]},
        {"method": "dop54"},
    ):
        np.testing.assert_array_equal(run(**other).states, run(falling_rod(), **other).states)
    assert next(iter(scene.spare.values())) == [memory]
    one = falling_rod()
    struck = (
        run(impulses=[fb.blow(0.3, at=x.bodies["bar"].origin, impulse=(1, 0, 0))], s=x) for x in (s, one)
    )
    np.testing.assert_array_equal(*(motion.states for motion in struck))
    with pytest.raises(fb.errors.SimulationError):
        run(max_steps=3)
    with pytest.raises(fb.errors.SimulationError, match="friction of contact"):
        run(values={"mu": -1})
    again = run()
    np.testing.assert_array_equal(again.states, kept)
    np.testing.assert_array_equal(first.contacts["tip_1"].normal, again.contacts["tip_1"].normal)
    assert str(again.modes) == texts == str(first.modes)


def test_a_text_is_read_anew_with_another_name() -> None:
    """A text and a SymPy expression are parsed once, and again when a name is added, which may change their meaning."""
    s = pendulum()
    first = expression_of(assemble(s), "2*theta", "an event")
    assert expression_of(assemble(s), "2*theta", "an event") is first
    assert expression_of(assemble(s), 2 * names_of(s).atoms["theta"], "an event") == first
    before = expression_of(assemble(s), "theta - pi", "an event")
    pi = s.parameters(pi=3.0)
    assert expression_of(assemble(s), "theta - pi", "an event") == names_of(s).atoms["theta"] - pi != before
    other = pendulum()
    for text in ("E", "later"):
        with pytest.raises(fb.FreebodyError, match="later|E"):
            expression_of(assemble(other), f"theta - {text}", "an event")
        other.parameters(**{text: 1.0})
        assert expression_of(assemble(other), f"theta - {text}", "an event").has(names_of(other).atoms[text])


def test_an_address_is_no_machine() -> None:
    """Machines that come and go where others were are told apart."""
    lengths = [1.0 + k for k in range(18)]
    found = []
    for length in lengths:
        s = fb.System("pendulum")
        s.gravity = (0, -9.81, 0)
        s.hinge(
            "pin", s.ground, s.body("bob", fb.particle(1)), to=(0, length, 0), axis="z", coordinate="theta"
        )
        found.append(fb.simulate(s, 0.1, initial={"theta": 0.1}).at(0.1)["theta'"])
    assert np.allclose(found, [-9.81 * 0.1 * 0.1 / length for length in lengths], rtol=0.05)


def test_programs_of_a_machine_are_those_asked_for() -> None:
    kernels = kernels_of(pendulum())
    names = kernels.model.names
    theta, u = names.atoms["theta"], names.atoms["theta'"]
    y, c = np.array([0.3, 0.2]), kernels.parameters(kernels.values(None))
    values = {}
    for asked in (
        (theta,),
        (u,),
        (theta, u),
        (u, theta),
        (2 * theta,),
        (theta / 2,),
        (sympy.Integer(2),),
        (-theta,),
    ):
        program = kernels.expressions(asked)
        assert kernels.expressions(asked) is program
        out = program.compiled["values"](0.0, y, program.constants(c))
        values[asked] = tuple(out)
    assert values == {
        (theta,): (0.3,), (u,): (0.2,), (theta, u): (0.3, 0.2), (u, theta): (0.2, 0.3), (2 * theta,): (0.6,),
        (theta / 2,): (0.15,), (sympy.Integer(2),): (2.0,), (-theta,): (-0.3,),
    }  # fmt: skip
    batches = [
        batch_program(kernels, outputs, reduced, events, method, wide)
        for outputs, reduced, events in (
            ((theta,), (), ()),
            ((), (theta,), ()),
            ((), (), (theta,)),
            ((u,), (), ()),
        )
        for method in ("dop853", "taylor", "radau")
        for wide in (False, True)
        if not (wide and method == "radau")
    ]
    assert len({id(one) for one in batches}) == len(batches) == 20


def test_conditions_that_hold_a_machine_have_their_own_programs() -> None:
    kernels = kernels_of(four_bar())
    sets = [(0, 1), (0, 2), (1, 2)]
    held = [kernels.holding(active) for active in sets]
    assert [one.active for one in held] == sets and len({id(one.programs) for one in held}) == 3
    assert kernels.holding((0, 2)) is held[1] and held[1].holding((0, 1)) is held[0]


def test_constants_follow_the_parameters() -> None:
    kernels = kernels_of(pendulum())
    for m in (1.0, 2.0, math.nextafter(2.0, 3.0), 1.0, 2.0):
        values = kernels.values({"m": m})
        p, _ = kernels.at(values)
        fresh = Kernels(kernels.model)
        assert p.tolist() == kernels.parameters(values).tolist()
        got, cold = kernels.motion().constants(p), fresh.motion().constants(p)
        assert got.tobytes() == cold.tobytes()
        got[:] = 0.0  # a caller's own
        assert kernels.motion().constants(p).tobytes() == cold.tobytes()


def test_assumptions_are_checked_for_other_values() -> None:
    s = pendulum()
    s.assume(s.expression("c") > -1)
    kernels = kernels_of(s)
    kernels.check(kernels.values({"c": 1.0}))
    with pytest.raises(fb.errors.ModelError):
        kernels.check(kernels.values({"c": -2.0}))
    kernels.check(kernels.values({"c": 1.0}))
    with pytest.raises(fb.errors.ModelError):
        kernels.check(kernels.values({"c": -2.0}))


def test_contacts_have_the_programs_of_their_modes() -> None:
    scene = scene_of(kernels_of(pulled_disk()))
    modes = [("open",), ("stick",), ("slip+",), ("slip-",)]
    phases = [scene.phase(mode) for mode in modes]
    assert len({id(one) for one in phases}) == 4 and [one.modes for one in phases] == modes
    assert scene.phase(modes[0]) is phases[0] and scene_of(kernels_of(pulled_disk())) is not scene
    y = scene.model.names.atoms["y"]
    watched = [phases[0].whole(e) for e in ((), (y,), (2 * y,))]
    assert len({id(program) for program in watched}) == 3
    assert [program.outputs("watched") - len(scene.endings) for program in watched] == [0, 1, 1]


def test_a_run_kept_for_its_next_start_is_for_its_own_arguments() -> None:
    """Each against a system that has run nothing before."""
    calls: list[dict[str, Any]] = [
        {}, {"until": 1}, {"until": 1.5}, {"until": "m"}, {"tolerance": 1e-6}, {"values": {"m": 2}},
        {"values": {"m": 2.0}}, {"values": {"m": "2"}}, {"values": {"m": 3}}, {"start": 0.25}, {"start": -0.0},
        {"events": ["theta"]}, {"events": [fb.event("theta", direction=1)]}, {"events": [fb.event("theta", "up")]},
        {"events": [fb.event("theta", terminal=True)]}, {"method": "dop853"}, {"method": "dop54", "step": 0.01},
        {"method": "dop54"}, {"samples": 5}, {"max_step": 0.01}, {"initial": {"theta": "1"}},
        {"initial": {"theta": "1/3"}}, {"initial": {"theta'": "1/3"}}, {"initial": {"theta": "m/3"}},
        {"initial": {"theta": "m/3"}, "values": {"m": 2}},
    ]  # fmt: skip
    warm = pendulum()
    for call in calls + calls[::-1]:
        arguments = {"until": 1.0, "initial": {"theta": 0.5}, **call}
        one, other = fb.simulate(warm, **arguments), fb.simulate(pendulum(), **arguments)
        assert np.array_equal(one.states, other.states) and np.array_equal(one.t, other.t), call
        assert [(e.name, e.time) for e in one.events] == [(e.name, e.time) for e in other.events], call
        assert one.values == other.values and np.array_equal(one.path.times, other.path.times)
    assert not np.signbit(fb.simulate(warm, 1.0, start=-0.0).t[0])


def test_a_start_that_is_closed_is_closed_for_its_values() -> None:
    warm = four_bar()
    for q1 in (1.0, 1.1, 1.0):
        options = {"initial": {"q1": q1, "q1'": 1.0}, "near": CLOSED}
        assert np.array_equal(
            fb.simulate(warm, 0.1, **options).states, fb.simulate(four_bar(), 0.1, **options).states
        )


# -- compiled dynamics ---------------------------------------------------------------------------------------


def test_a_program_has_the_constants_of_its_parameters() -> None:
    """A text and a number of another type may print alike: np.float32(9.7) is not 97/10."""
    warm = fb.compile(pendulum())
    q, u = np.array([0.3]), np.array([0.1])
    for g in (
        9.7,
        np.float32(9.7),
        "9.7",
        Fraction(97, 10),
        9.7,
        sympy.Float(9.7, 30),
        np.float32(9.7),
        1,
        True,
        2,
    ):
        if g is True:
            for program in (warm, fb.compile(pendulum())):
                with pytest.raises(fb.errors.FreebodyError, match="got True"):
                    program.forward_dynamics(q, u, values={"g": g})
            continue
        cold = fb.compile(pendulum()).forward_dynamics(q, u, values={"g": g})
        assert np.array_equal(warm.forward_dynamics(q, u, values={"g": g}), cold), repr(g)
    c = warm.constants(values={"g": 9.7})
    before = warm.forward_dynamics(q, u, values={"g": 9.7})
    c[:] = 0.0  # a caller's own
    assert np.array_equal(warm.forward_dynamics(q, u, values={"g": 9.7}), before)


def test_points_have_their_own_jacobians() -> None:
    s = pendulum()
    program, bar = fb.compile(s), s.bodies["bar"]
    found = [program.jacobian(bar.point(0, y, 0), [0.3]) for y in (1, 2, "L", -1, 1)]
    assert np.array_equal(found[0], found[4]) and len({one.tobytes() for one in found[:4]}) == 3  # L = 2


def test_literals_are_bits() -> None:
    numbers = (0.0, -0.0, 1.0, -1.0, 5e-324, -5e-324, math.inf, 0.1, np.float64(0.1), math.nextafter(0.1, 1))
    for _ in range(2):
        for x in numbers:
            assert literal(x) == f"0x{np.float64(x).view(np.uint64):016X}", x


def test_constants_of_a_tape_are_their_values() -> None:
    tape = Tape()
    x = tape.input("x")
    numbers = [2, -2, Fraction(1, 2), Fraction(-1, 2), 0.25, math.nextafter(0.25, 1), Fraction(1, 3), 1 / 3]
    assert len({tape.node(c).index for c in numbers}) == len(numbers)
    assert [tape.scalar(tape.node(c).index) for c in numbers] == numbers
    assert math.copysign(1, tape.scalar(tape.node(-0.0).index)) == 1.0
    made = [x + 2, x + 3, 2 * x, 3 * x, x - 2, x / 2, 2 / x, x * x, -x, tape.input("y")]
    assert len({(one.index, one.minus is None) for one in made}) == len(made)
    assert (x + 2).index == (x + 2).index != (tape.input("y") + 2).index


def test_tables_of_a_module_are_their_numbers() -> None:
    """A table whose numbers nobody else keeps is not that of others at the same address."""
    module = Unit()
    tables = [module.table(np.full(3, float(k)), "x") for k in range(50)]
    assert len({id(one) for one in tables}) == 50
    assert [str(one.content.constant[0].constant) for one in tables] == [str(float(k)) for k in range(50)]


# -- loops ---------------------------------------------------------------------------------------------------


def test_loops_are_those_of_their_method() -> None:
    codes = [one.code for name in ("dop853", "dop54") for one in loops.functions(name).functions.values()]
    codes += [over_lanes.function("dop853", width).code for width in (1, 8)]
    addresses = {ctypes.cast(code, ctypes.c_void_p).value for code in codes}
    assert len(addresses) == len(codes) == 3 + 3 + 1 + 1


def test_blocks_of_memory_are_of_their_shape() -> None:
    for n, m in ((2, 0), (2, 1), (9, 0), (9, 1)):
        known = _layout(Run, tuple(sizes(n, m).items()))
        fresh = _layout.__wrapped__(Run, tuple(sizes(n, m).items()))
        assert known.rows == fresh.rows and known.size == fresh.size
        assert np.array_equal(known.words, fresh.words) and np.array_equal(known.pointers, fresh.pointers)
        for array in (known.words, known.pointers):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1
    one, two = pendulum(), pendulum()
    first = fb.simulate(one, 1, initial={"theta": 1})
    states = first.states.copy()
    fb.simulate(two, 1, initial={"theta": 2})  # in the memory that the first has given back
    assert np.array_equal(first.states, states) and np.array_equal(first.at(1.0)["theta"], states[-1, 0])


def test_tolerances_that_are_shared_can_not_be_changed() -> None:
    assert (
        _equal(1e-9, 2).tolist() == [1e-9, 1e-9] and _equal(1e-9, 3).size == 3 and _equal(1e-8, 2)[0] == 1e-8
    )
    with pytest.raises(ValueError, match="read-only"):
        _equal(1e-9, 2)[0] = 1.0


def test_samples_of_a_signal_can_not_be_changed() -> None:
    ramp = fb.signal([0, 1, 3], [-0.0, 2, 2])
    for array in (ramp.times, ramp._coefficients):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    assert not np.signbit(ramp(0.0))


# -- symbols -------------------------------------------------------------------------------------------------


def test_a_ring_reads_anew_what_an_assumption_changes() -> None:
    ring = Ring()
    a, b = sympy.symbols("a b", real=True)
    before = ring.from_sympy(sympy.sqrt(a**2))
    ring.assume_positive(a)
    assert ring.from_sympy(sympy.sqrt(a**2)) == ring.from_sympy(a) != before
    found = [
        ring.from_sympy(f(x)) for f in (sympy.sin, sympy.cos, sympy.exp) for x in (a, b, 2 * a, a / 2, a + b)
    ]
    assert len(set(found)) == len(found) and len({str(one) for one in found}) == len(found)
    other = Ring()
    assert other.from_sympy(sympy.sqrt(a**2)) != other.from_sympy(a)


def test_tables_of_whole_numbers_are_their_arguments() -> None:
    assert [_binomials(n) for n in (2, 3)] == [(1, 2, 1), (1, 3, 3, 1)]
    assert dict(_spectrum(2, 0)) == {2: 1, 0: -2, -2: 1} and dict(_spectrum(0, 2)) == {2: 1, 0: 2, -2: 1}
    assert _waves(((7, 1, 0),)) != _waves(((7, 0, 1),)) != _waves(((8, 0, 1),))


def test_names_and_outlines_are_of_their_text() -> None:
    assert len({latex_name(name, dots) for name in ("theta", "theta1", "x") for dots in (0, 1, 2)}) == 9
    boxes = [outline(text).box for text in ("$m$", "$M$", "m", "$m g$")]
    assert len(set(boxes)) == 4


def test_rates_scripts_and_steps_are_of_their_arguments() -> None:
    t = sympy.Symbol("t")
    x, y = sympy.Function("x")(t), sympy.Function("y")(t)
    assert rate(x) == x.diff(t) != rate(y) and rate(rate(x)) == x.diff(t, 2)
    assert script(SCRIPTS) != script(LIVE)
    kinds = [Kind("hinge", axis, False, True, False, True) for axis in (0, 1)]
    steps = [compiled_step(kind, ("composed",), *more) for kind in kinds for more in ((), (8,), (8, False))]
    assert len({id(one) for one in steps}) == 6


# -- the list ------------------------------------------------------------------------------------------------


def test_the_list_of_memos_is_complete() -> None:
    """Every function with a cache, and every table of a module that is filled as it runs, is in docs/caches.md."""
    root = Path(fb.__file__).parent
    text = (Path(__file__).parents[2] / "docs" / "caches.md").read_text(encoding="utf-8")
    found = []
    for file in sorted(root.rglob("*.py")):
        where = file.relative_to(root)
        for node in ast.parse(file.read_bytes()).body:
            if isinstance(node, ast.FunctionDef):
                if any("cache" in ast.unparse(one) for one in node.decorator_list):
                    found.append((where, node.name, len(node.args.args)))
            elif isinstance(node, ast.AnnAssign | ast.Assign) and node.value is not None:
                value = ast.unparse(node.value)
                if value in ("{}", "[]", "set()", "OrderedDict()", "dict()") or "cache(" in value:
                    target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
                    found.append((where, ast.unparse(target), 0))
    assert len(found) > 40
    for where, name, arguments in found:
        if where.parts[0] in ("gallery", "chapter"):
            assert not arguments or name in ("solved", "_together"), (where, name)  # one result for all
        else:
            assert f"`{name}`" in text, f"docs/caches.md does not list {name} of {where}"
