"""Identity of a study: by its content, the same in every process."""

from __future__ import annotations

import copy
import dataclasses
import functools
import importlib
import json
import math
import os
import subprocess
import sys
import threading
import types
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy
from scipy.interpolate import CubicSpline

import freebody as fb
import identities
from freebody.describe.body import Body
from freebody.describe.joints.joint import Joint
from freebody.describe.system import Parameter
from freebody.errors import SimulationError
from freebody.studies.identity import study_identity as module
from freebody.studies.identity.content_digest import NoContentError, digest
from freebody.studies.identity.study_identity import identity, parts
from identities import machines, study

MACHINES = machines()


def changed(one: Mapping[str, str], other: Mapping[str, str]) -> list[str]:
    assert one.keys() == other.keys()
    return [name for name in one if one[name] != other[name]]


# -- the machine ---------------------------------------------------------------------------------------------


def leaves(x: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where the numbers, expressions and texts of a value stand."""
    if isinstance(x, (Body, Joint, Parameter)) or x is None:
        return
    if dataclasses.is_dataclass(x):
        for field in dataclasses.fields(x):
            if field.compare and field.name not in ("names", "controllers"):
                yield from leaves(getattr(x, field.name), (*path, field.name))
    elif isinstance(x, Mapping):
        for key in x:
            yield from leaves(x[key], (*path, key))
    elif isinstance(x, tuple):
        for k, part in enumerate(x):
            yield from leaves(part, (*path, k))
    else:
        yield path


def mutated(x: Any, path: tuple[Any, ...]) -> Any:
    """A value with another leaf there."""
    if not path:
        return (
            f"{x}_" if isinstance(x, str) else not x if isinstance(x, bool) else x + sympy.Rational(1, 10**6)
        )
    name, *rest = path
    if dataclasses.is_dataclass(x):
        found = copy.copy(x)
        object.__setattr__(found, name, mutated(getattr(x, name), tuple(rest)))
        return found
    part = mutated(x[name], tuple(rest))
    return {**x, name: part} if isinstance(x, Mapping) else (*x[:name], part, *x[name + 1 :])


@pytest.mark.parametrize("name", MACHINES)
def test_every_number_expression_and_text_of_a_machine_counts(name: str) -> None:
    s, options = MACHINES[name]
    job = study(s, **options)
    before, model = parts(job), job.kernels.model
    places = list(leaves(model))
    rng = np.random.default_rng(0)
    assert len(places) > 50
    seen = {before["machine"]}
    for k in rng.permutation(len(places))[:60]:
        other = dataclasses.replace(job, kernels=SimpleNamespace(model=mutated(model, places[k])))
        after = parts(other)
        assert changed(before, after) == ["machine"], places[k]
        seen.add(after["machine"])
    assert len(seen) == 61


@pytest.mark.parametrize("name", MACHINES)
def test_whatever_is_asked_of_a_machine_counts(name: str) -> None:
    s, options = MACHINES[name]
    job = study(s, **options)
    before, model = parts(job), job.kernels.model
    q, u = model.coordinate_names[0], model.speed_names[0]
    start, near = options.get("initial", {}), options.get("near") or {}
    if model.constraints:  # which of the positions in which the machine closes
        starts = [{"near": {**near, q: near.get(q, 0.5) + d}} for d in (1e-3, 2e-3)]
    else:
        starts = [{"initial": {**start, u: v}} for v in (0.25, 0.5)]
    others: list[tuple[str, dict[str, Any]]] = [
        ("times", {"until": 2, "samples": 101}),
        ("times", {"samples": 100}),
        ("times", {"times": [0.5]}),
        ("outputs", {"outputs": "kinetic_energy"}),
        ("outputs", {"outputs": ["kinetic_energy", "max(kinetic_energy)"]}),
        ("outputs", {"outputs": ["kinetic_energy", "min(kinetic_energy)"]}),
        ("outputs", {"outputs": {"T": "kinetic_energy"}}),
        ("events", {"events": [q]}),
        ("events", {"events": [fb.event(q, direction=1)]}),
        ("events", {"events": [fb.event(q, terminal=True)]}),
        ("events", {"events": [fb.event(q, name="zero")]}),
        ("events", {"events": [f"{q} - 1/1000"]}),
        ("method or tolerance", {"tolerance": 1e-8}),
        ("method or tolerance", {"max_steps": 1000}),
        ("method or tolerance", {"max_step": 0.1}),
        ("method or tolerance", {"impacts": "sequential"} if model.contacts else {"method": "dop853"}),
        ("values", {"values": {p.name: p.default + 1e-9 for p in model.parameters[-1:]}}),
        *(("starts", one) for one in starts),
    ]  # fmt: skip
    seen = {identity(job)}
    for part, other in others:
        if part == "values" and not model.parameters or model.signals and part == "values":
            continue
        until = other.pop("until", 1)
        again = study(s, until, **{**options, **other})
        assert part in changed(before, parts(again)), other
        if part not in ("starts", "values"):
            assert changed(before, parts(again)) == [part], other
        if parts(again) != before:
            seen.add(identity(again))
        assert parts(study(s, until, **{**options, **other})) == parts(again), other
    assert len(seen) >= len(others) - 2


def test_lanes_count_and_the_place_of_each() -> None:
    s, _ = MACHINES["cart-and-bar"]
    seen = {
        json.dumps(parts(study(s, **options)))
        for options in (
            {"initial": {"x": [0.1, 0.2]}},
            {"initial": {"x": [0.2, 0.1]}},
            {"initial": {"x": [0.1, 0.2, 0.3]}},
            {"initial": {"theta": [0.1, 0.2]}},
            {"values": {"M": [1.0, 2.0], "m": 3.0}},
            {"values": {"M": 1.0, "m": [2.0, 3.0]}},
            {"values": {"M": [1.0, 2.0], "m": [3.0, 4.0]}},
            {"values": {"M": [1.0, 2.0], "m": [1.0, 2.0]}},
        )
    }
    assert len(seen) == 8
    both = np.array([1.0, 2.0])
    same = parts(study(s, values={"M": both, "m": both}))
    assert json.dumps(same) in seen  # one array given twice is as two


def test_how_it_is_said_does_not_count() -> None:
    s, _ = MACHINES["cart-and-bar"]
    M, x = s.expression("M"), s.expression("x")
    first = study(s, 1, values={"M": 2, "m": 1.0}, initial={"x": 1, "theta": [0.1, 0.2]}, threads=1)
    other = study(s, 1.0, values={"m": 1, M: 2.0}, initial={"theta": np.array([0.1, 0.2]), x: 1.0}, threads=2)
    assert identity(first) == identity(other)


def test_blows_count() -> None:
    s, _ = MACHINES["cart-and-bar"]
    bar = s.bodies["bar"]
    seen = {
        parts(study(s, impulses=[fb.blow(when, at=bar.point(0, y, 0), impulse=(J, 0, 0), count=count)]))["blows"]
        for when, y, J, count in ((0.5, 0, 1, None), (0.6, 0, 1, None), (0.5, 0.1, 1, None), (0.5, 0, 2, None),
                                  ("theta", 0, 1, None), ("theta", 0, 1, 2))
    }  # fmt: skip
    assert len(seen) == 6


def test_a_signal_counts_but_not_the_name_that_it_gets() -> None:
    def cart(values: Any, **options: Any) -> Any:
        s = fb.System("cart")
        rail = s.slider("rail", s.ground, s.body("cart", fb.particle(2)), axis="x", coordinate="x")
        s.force("push", rail, 3 * fb.signal([0, 1, 2], values, **options))
        return parts(study(s))

    first = cart([0, 1, 0])
    assert cart([0, 1, 0]) == first
    assert changed(first, cart([0, 1, 0.5])) == ["signals"]
    assert changed(first, cart([0, 1, 0], outside="hold")) == ["signals"]
    assert "signals" in changed(first, cart([0, 1, 0], kind="cubic"))


def test_the_sources_that_compute_count(monkeypatch, tmp_path) -> None:
    folder = tmp_path / "freebody"
    for room in ("motion", "studies/identity", "picture"):
        (folder / room).mkdir(parents=True)
        (folder / room / "x.py").write_text("1")
    monkeypatch.setattr(module, "__file__", str(folder / "studies" / "identity" / "study_identity.py"))
    first = module.version.__wrapped__()
    (folder / "picture" / "x.py").write_text("2")
    assert module.version.__wrapped__() == first
    (folder / "motion" / "x.py").write_text("2")
    second = module.version.__wrapped__()
    (folder / "motion" / "x.py").rename(folder / "motion" / "y.py")
    assert len({first, second, module.version.__wrapped__()}) == 3


def test_identities_are_the_same_in_a_fresh_process() -> None:
    here = identities.identities()
    assert here == identities.identities() and len(set(here.values())) == 10
    file = Path(identities.__file__)
    environment = {**os.environ, "PYTHONHASHSEED": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
    found = subprocess.run([sys.executable, str(file)], capture_output=True, text=True, env=environment)
    assert json.loads(found.stdout or "{}") == here, found.stderr


# -- controllers ---------------------------------------------------------------------------------------------

CODE = """
import math, settings
from functools import lru_cache, partial, wraps

GAIN, OTHER = 4.0, 1.0
TABLE = [1.0, {"k": (2.0, 3.0)}]

def helper(x):
    return 2.0 * x + TABLE[0]

def by_global(t, x): return -GAIN * x["x"]
def by_helper(t, x): return -helper(x["x"])
def by_module(t, x): return -settings.gain * math.sin(x["x"])
def by_default(t, x, k=5.0): return -k * x["x"]
def by_keyword(t, x, *, k=5.0): return -k * x["x"]
def by_attribute(t, x): return -by_attribute.k * x["x"]
by_attribute.k = 6.0

def closed(k):
    def by_closure(t, x):
        def inner():
            return 7.0 * k
        return -inner() * x["x"]
    return by_closure
by_closure = closed(8.0)

class Law:
    d = 9.0
    def __init__(self): self.k = [10.0]
    def __call__(self, t, x): return -self.k[0] * x["x"] - self.d
    def act(self, t, x): return self(t, x) + 11.0
by_object, by_method = Law(), Law().act
by_part = partial(by_default, k=12.0)
by_memory = lru_cache(lambda t, x: 13.0)
by_lambda = lambda t, x: 14.0 if t < 15.0 else -OTHER

def decorated(f):
    @wraps(f)
    def wrapper(*given): return 16.0 * f(*given)
    return wrapper
by_wrapper = decorated(by_global)

def by_recursion(t, x): return 17.0 if t < 0 else by_recursion(t - 1, x)
"""

CHANGES = {
    "by_global": [("OTHER = 4.0", "OTHER = 4.5"), ("-GAIN", "+GAIN"), ('x["x"]\ndef by_h', 'x["v"]\ndef by_h')],
    "by_helper": [("2.0 * x +", "2.5 * x +"), ("TABLE = [1.0", "TABLE = [1.5"), ("(2.0, 3.0)", "(2.0, 3.5)")],
    "by_module": [("math.sin", "math.cos")],
    "by_default": [("x, k=5.0", "x, k=5.5")],
    "by_keyword": [("*, k=5.0", "*, k=5.5")],
    "by_attribute": [("k = 6.0", "k = 6.5")],
    "by_closure": [("closed(8.0)", "closed(8.5)"), ("7.0 * k", "7.5 * k")],
    "by_object": [("d = 9.0", "d = 9.5"), ("[10.0]", "[10.5]"), ("- self.d", "+ self.d")],
    "by_method": [("d = 9.0", "d = 9.5"), ("[10.0]", "[10.5]"), ("11.0", "11.5"), ("- self.d", "+ self.d")],
    "by_part": [("k=12.0", "k=12.5"), ("-k * x[\"x\"]\ndef by_k", "+k * x[\"x\"]\ndef by_k")],
    "by_memory": [("13.0", "13.5")],
    "by_lambda": [("14.0", "14.5"), ("t < 15.0", "t < 15.5"), ("OTHER = 4.0, 1.0", "OTHER = 4.0, 1.5"), ("<", "<=")],
    "by_wrapper": [("16.0", "16.5"), ("GAIN, OTHER = 4.0", "GAIN, OTHER = 4.5")],
    "by_recursion": [("17.0", "17.5"), ("t - 1", "t - 2")],
}  # fmt: skip


def laws(monkeypatch: Any, text: str, gain: float = 3.0, name: str = "laws") -> dict[str, Any]:
    """The functions of a module of a user."""
    settings = types.ModuleType("settings")
    settings.gain = gain  # type: ignore[attr-defined]
    settings.__file__ = "/home/somebody/settings.py"
    monkeypatch.setitem(sys.modules, "settings", settings)
    made = types.ModuleType(name)
    made.__file__ = f"/home/somebody/{name}.py"
    monkeypatch.setitem(sys.modules, name, made)
    exec(compile(text, made.__file__, "exec"), vars(made))
    return vars(made)


@pytest.mark.parametrize("name", CHANGES)
def test_whatever_a_controller_depends_on_counts(monkeypatch, name: str) -> None:
    first = digest(laws(monkeypatch, CODE)[name])
    assert digest(laws(monkeypatch, CODE)[name]) == first
    assert digest(laws(monkeypatch, "# moved\n\nUNRELATED = 1\n" + CODE)[name]) == first
    seen = {first}
    for old, new in CHANGES[name]:
        assert old in CODE
        seen.add(digest(laws(monkeypatch, CODE.replace(old, new))[name]))
    assert len(seen) == 1 + len(CHANGES[name])
    other = digest(laws(monkeypatch, CODE, gain=3.5)[name])
    assert (other != first) == (name == "by_module")


def test_laws_of_one_kind_are_told_apart(monkeypatch) -> None:
    made = laws(monkeypatch, CODE)
    assert len({digest(made[name]) for name in CHANGES}) == len(CHANGES)


@dataclasses.dataclass
class Node:
    """A record of a user, which can be changed and refer to itself."""

    value: float
    next: Any = None

    def act(self) -> None: ...
    def rest(self) -> int:
        return 1


def test_modules_that_a_law_imports_count(monkeypatch) -> None:
    """Where it runs, too; and those without a file, such as what is typed in."""
    text = "def law(t, x):\n    import settings\n    return -settings.gain * x['x']\n"
    found = [digest(laws(monkeypatch, text, gain)["law"]) for gain in (1.0, 1.0, 2.0)]
    assert found[0] == found[1] != found[2]
    typed = []
    for k in (1.0, 1.0, 2.0):
        module = types.ModuleType("typed")
        monkeypatch.setitem(sys.modules, "typed", module)
        exec(
            f"class Law:\n    k = {k}\n    def __call__(self, t, x): return -self.k * x['x']\n", vars(module)
        )
        typed.append((digest(module.Law()), digest(module), digest(module.Law)))
    assert typed[0] == typed[1] and not set(typed[0]) & set(typed[2])


def test_objects_are_their_state() -> None:
    rng = np.random.default_rng(1)
    before = digest(rng)
    assert digest(np.random.default_rng(1)) == before
    rng.random()
    assert digest(rng) != before
    shared, a = [1.0], [1.0]
    assert digest((shared, shared)) != digest((a, [1.0]))  # a change of one would be one of both
    assert digest({1, 2, 3}) == digest({3, 2, 1}) and digest({"a": 1, "b": 2}) != digest({"b": 2, "a": 1})
    assert (
        len(
            {digest(x) for x in (1, 1.0, True, "1", b"1", (1,), [1], {1}, None, 0.0, -0.0, np.float64(1), 1j)}
        )
        == 13
    )
    assert digest(np.array([1.0, 2.0])) != digest(np.array([[1.0, 2.0]])) != digest(np.array([1, 2]))
    assert digest(math.sin) != digest(math.cos) and digest(functools.partial(max, 1)) != digest(
        functools.partial(min, 1)
    )
    one, other = Node(1.0), Node(1.0)
    one.next, other.next = one, Node(1.0)
    assert len({digest(x) for x in (one, other, Node(1.0), Node(2.0))}) == 4
    assert digest({Node.act, Node.rest}) == digest({Node.rest, Node.act}) != digest({Node.act})
    loop: list[Any] = []
    loop.append(loop)
    assert digest(loop) != digest([[]])


def test_functions_of_packages_are_named_and_those_made_by_them_are_read() -> None:
    x = sympy.Symbol("x")
    made = [sympy.lambdify(x, e) for e in (sympy.sin(x) + x**2, sympy.sin(x) + x**3, sympy.cos(x) + x**2)]
    assert len({digest(one) for one in made}) == 3
    assert digest(sympy.lambdify(x, sympy.sin(x) + x**2)) == digest(made[0])
    assert len({digest(one) for one in (np.sin, np.cos, np.mean, np.clip, math.sin, np.linalg.norm)}) == 6
    splines = [CubicSpline([0, 1, 2], [0, 1, y]) for y in (4.0, 5.0, 4.0)]
    assert digest(splines[0]) == digest(splines[2]) != digest(splines[1])
    with pytest.raises(NoContentError):  # of these two no more than a name can be read
        digest([np.frompyfunc(lambda x, k=k: k * x, 1, 1) for k in (1, 2)])


def test_expressions_are_sums_and_products_without_order() -> None:
    x, y, z = sympy.symbols("x y z")
    assert digest(x + y * z) == digest(z * y + x) != digest(x * y + z)
    assert digest(sympy.Symbol("x", real=True)) != digest(x) != digest(sympy.Function("x")(y))
    assert digest(sympy.sin(x)) != digest(sympy.cos(x)) and digest(x**2) != digest(2**x)
    assert digest(sympy.Rational(1, 3) * x) != digest(sympy.Float(1) / 3 * x)
    a, b = sympy.Dummy("x"), sympy.Dummy("x")
    assert digest(a - b) != digest(a + b) and digest(a) != digest(x)
    assert digest([a, a]) != digest([a, b])


def test_a_controller_without_content_is_refused() -> None:
    lock = threading.Lock()

    def push(t: float, x: Any) -> float:
        with lock:
            return -x["x"]

    s = fb.System("cart")
    s.parameters(push=0.0)
    rail = s.slider("rail", s.ground, s.body("cart", fb.particle(2)), axis="x", coordinate="x")
    s.force("motor", rail, "push")
    s.controller(push, 0.1, "push")
    with pytest.raises(
        SimulationError,
        match=r"'push' holds a _thread.lock \(in .*push\)\. Open or make it .*leave out store=",
    ):
        identity(study(s))
    with pytest.raises(NoContentError):
        digest([lock])


class Integral:
    """A controller that remembers."""

    def __init__(self, gain: float) -> None:
        self.gain, self.sum = gain, 0.0

    def reset(self) -> None:
        self.sum = 0.0

    def __call__(self, t: float, x: Any) -> float:
        self.sum += x["x"]
        return -self.gain * self.sum


def test_a_controller_counts_as_a_run_finds_it(tmp_path) -> None:
    """What one that can be reset remembers of a run does not make it another."""

    def cart(gain: float) -> fb.System:
        s = fb.System("cart")
        s.parameters(push=0.0)
        rail = s.slider("rail", s.ground, s.body("cart", fb.particle(2)), axis="x", coordinate="x")
        s.force("motor", rail, "push")
        s.controller(Integral(gain), 0.1, "push", name="pull")
        return s

    one, path = cart(4.0), tmp_path / "x.nc"
    options = {"initial": {"x": [0.1, 0.2]}, "samples": 3}
    first = fb.simulate(one, 1, store=path, **options)
    again = fb.simulate(one, 1, store=path, **options)
    assert np.array_equal(first["x"], again["x"])
    first.close(), again.close()
    with pytest.raises(
        SimulationError, match="those of runs that differ in the controllers. Choose another path"
    ):
        fb.simulate(cart(5.0), 1, store=path, **options)


# -- stores --------------------------------------------------------------------------------------------------


def test_a_store_is_not_gone_on_with_by_another_machine(tmp_path) -> None:
    """As many operations of each sort, and another number."""

    def pendulum(g: float) -> fb.System:
        s = fb.System("pendulum")
        s.gravity = (0, -g, 0)
        s.hinge("pin", s.ground, s.body("bar", fb.slender_bar(1, 2, axis="y")), to=(0, 1, 0), axis="z",
                coordinate="theta")  # fmt: skip
        return s

    options = {"initial": {"theta": [0.1, 0.2]}, "samples": 2, "store": tmp_path / "x.nc"}
    fb.simulate(pendulum(9.81), 1, **options).close()
    fb.simulate(pendulum(9.81), 1, **options).close()
    with pytest.raises(SimulationError, match="to hold results of the same runs, .* differ in the machine"):
        fb.simulate(pendulum(1.62), 1, **options)


def test_packages_of_another_environment_count_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "site-packages"  # as a .pth file or PYTHONPATH adds it
    folder.mkdir()
    (folder / "package_elsewhere.py").write_text("import numpy as np\n\nclass Law:\n    kind = np.ndarray\n")
    monkeypatch.syspath_prepend(folder)
    law = importlib.import_module("package_elsewhere").Law
    before = digest(law)
    monkeypatch.setattr(law, "kind", int)
    assert digest(law) == before
