"""What all laws promise: lanes do not depend on the cut, and a law is a value with a content."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import scipy.stats
import sympy

import freebody as fb
from freebody.errors import SimulationError
from freebody.studies.identity.content_digest import digest
from freebody.studies.lanes.law import CHECKED, MOST_CHECKED, Law

NORM, GAMMA = scipy.stats.norm(0.5, 0.05), scipy.stats.gamma(2.5)
N = 20_011  # no multiple of a block, a power of two or an axis
ROWS = np.random.default_rng(3).normal(size=(2, N))


def laws() -> dict[str, Law]:
    return {
        "grid": fb.grid(I=np.arange(7.0), theta=np.arange(953.0) ** 2, m=[3, 1, 2]),
        "table": fb.table({"I": ROWS[0], "theta'": ROWS[1]}),
        **{
            by: fb.sample(
                {"I": NORM, "theta": GAMMA, "m": (1, 2)}, N, by=by, seed=5, proposal={"I": scipy.stats.norm(0.5, 0.1)}
            )
            for by in ("sobol", "lhs", "random")
        },
        "small": fb.sample({"I": NORM}, 100, by="lhs"),
    }  # fmt: skip


LAWS = laws()


@pytest.mark.parametrize("kind", LAWS)
def test_a_lane_is_the_same_however_its_range_is_cut(kind: str) -> None:
    """Every bit, in any order, of a part that has been pickled."""
    law = LAWS[kind]
    whole, weights = law.columns(0, law.count), law.weights(0, law.count)
    assert list(whole) == list(law.names)
    assert all(x.shape == (law.count,) and x.dtype == np.float64 for x in whole.values())
    random = np.random.default_rng(1)
    for _ in range(3):
        edges = np.sort(random.integers(0, law.count, 12)).tolist()
        edges = [0, 0, 1, *edges, law.count - 1, law.count]
        pieces = list(zip(edges[:-1], edges[1:], strict=True))
        random.shuffle(pieces)
        for low, high in pieces:
            part = pickle.loads(pickle.dumps(law.part(low, high)))
            assert part.count == law.count
            for name, x in part.columns(low, high).items():
                assert x.tobytes() == whole[name][low:high].tobytes(), (name, low, high)
            some = part.weights(low, high)
            assert (some is None) == (weights is None)
            assert some is None or some.tobytes() == weights[low:high].tobytes()


@pytest.mark.parametrize("kind", LAWS)
def test_lanes_outside_are_refused(kind: str) -> None:
    law = LAWS[kind]
    for low, high in ((-1, 1), (2, 1), (0, law.count + 1)):
        for method in (law.columns, law.part, law.weights):
            with pytest.raises(
                SimulationError, match=f"Expected lanes from 0 to {law.count}, got {low} to {high}"
            ):
                method(low, high)


def test_a_law_cannot_be_changed_from_outside() -> None:
    values = np.array([1.0, 2.0, 3.0])
    grid, table = fb.grid(I=values), fb.table(I=values)
    values[0] = 7
    assert grid.columns(0, 1)["I"] == table.columns(0, 1)["I"] == 1
    grid.columns(0, 3)["I"][:] = table.columns(0, 3)["I"][:] = 9
    assert grid.columns(0, 1)["I"] == table.columns(0, 1)["I"] == 1


def test_a_law_is_small() -> None:
    assert len(pickle.dumps(fb.grid({f"x{i}": range(10) for i in range(12)}))) < 4000
    sample = fb.sample({"I": NORM, "theta": scipy.stats.Normal(mu=1.0, sigma=2.0)}, 10**9)
    assert len(pickle.dumps(sample)) < 20_000
    table = LAWS["table"]
    assert len(pickle.dumps(table.part(10, 20))) < 1000 < len(pickle.dumps(table))


# -- content ---------------------------------------------------------------------------------------------------


def contents() -> dict[str, str]:
    """Digests of laws, printed by another process too."""
    new = {"a": scipy.stats.Normal(mu=1.0, sigma=2.0), "b": scipy.stats.Uniform(a=0.0, b=1.0)}
    more = {
        "new": fb.sample(new, 9),
        "histogram": fb.sample({"I": scipy.stats.rv_histogram(([1, 2], [0, 1, 2]))}, 9),
    }
    return {name: digest(law) for name, law in {**laws(), **more}.items()}


def test_the_content_is_the_same_in_another_process() -> None:
    environment = {**os.environ, "PYTHONHASHSEED": "7", "PYTHONPATH": os.pathsep.join(sys.path)}
    code = f"import runpy, json; print(json.dumps(runpy.run_path({str(Path(__file__))!r})['contents']()))"
    there = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment)
    assert json.loads(there.stdout or "{}") == contents(), there.stderr


def test_the_content_differs_if_anything_differs() -> None:
    def sample(**changes: object) -> Law:
        arguments = {
            "distributions": {"I": NORM, "theta": (0, 1)},
            "n": 8,
            "by": "sobol",
            "seed": 1,
            **changes,
        }
        return fb.sample(**arguments)  # type: ignore[arg-type]

    others = [
        fb.grid(I=[1, 2]), fb.grid(I=[1, 3]), fb.grid(m=[1, 2]), fb.grid(I=[1, 2], m=[1]), fb.grid(m=[1], I=[1, 2]),
        fb.grid(I=["1 kg", "2 kg"]),
        fb.table(I=[1, 2]), fb.table(I=[1, 3]), fb.table(m=[1, 2]), fb.table(I=[1, 2]).part(1, 2),
        sample(), sample(n=9), sample(by="lhs"), sample(by="random"), sample(seed=2),
        sample(distributions={"theta": (0, 1), "I": NORM}),
        sample(distributions={"I": NORM, "theta": (0, 2)}), sample(distributions={"I": NORM, "theta": (-1, 1)}),
        sample(distributions={"I": scipy.stats.norm(0.5, 0.06), "theta": (0, 1)}),
        sample(distributions={"I": scipy.stats.norm(0.4, 0.05), "theta": (0, 1)}),
        sample(distributions={"I": scipy.stats.laplace(0.5, 0.05), "theta": (0, 1)}),
        sample(distributions={"I": scipy.stats.Normal(mu=0.5, sigma=0.05), "theta": (0, 1)}),
        sample(distributions={"I": scipy.stats.Normal(mu=0.5, sigma=0.06), "theta": (0, 1)}),
        sample(proposal={"I": scipy.stats.norm(0.5, 0.1)}), sample(proposal={"I": scipy.stats.norm(0.5, 0.2)}),
        sample(proposal={"theta": (0, 1)}),
    ]  # fmt: skip
    assert len({digest(law) for law in others}) == len(others)


@pytest.mark.parametrize("kind", LAWS)
def test_every_field_counts(kind: str) -> None:
    law = LAWS[kind]
    for field in fields(law):  # type: ignore[arg-type]
        value = getattr(law, field.name)
        other = value[:-1] if isinstance(value, tuple) and value else (value, "another")
        assert digest(replace(law, **{field.name: other})) != digest(law), field.name  # type: ignore[type-var]


def test_the_content_forgets_what_a_distribution_remembers() -> None:
    """Random numbers drawn elsewhere, and results that a distribution of SciPy keeps, change no lane."""
    new = scipy.stats.Normal(mu=0.5, sigma=0.05)
    distributions = {"I": NORM, "theta": new, "m": scipy.stats.truncate(new, 0.4, 0.6)}
    before = digest(fb.sample(distributions, 9))
    np.random.rand(3)
    used = [NORM.rvs(2)]
    for x in (new, distributions["m"]):
        used += [
            x.mean(),
            x.variance(),
            x.skewness(),
            x.median(),
            x.mode(),
            x.entropy(),
            x.cdf(0.5),
            x.sample(),
            x.logpdf(0.5),
        ]
    assert len(used) == 19
    law = fb.sample(distributions, 9)
    law.columns(0, 9)
    assert digest(law) == before


# -- names ------------------------------------------------------------------------------------------------------


def pendulum() -> tuple[fb.System, dict[str, sympy.Basic]]:
    s = fb.System("pendulum")
    m, length, g = s.parameters(m=1.0, L=1.0, g=9.81)
    theta = s.coordinates("theta")
    s.gravity = (0, -g, 0)
    s.hinge("pin", s.ground, s.body("bob", fb.particle(m)), to=(0, length, 0), axis="z", coordinate=theta)
    return s, {"m": m, "theta": theta, "theta'": theta.diff(s.t)}


def test_names_may_be_texts_or_symbols() -> None:
    s, atoms = pendulum()
    model = fb.assemble(s)
    for make in (fb.grid, fb.table, lambda x: fb.sample({name: tuple(v) for name, v in x.items()}, 2)):
        texts = make({name: [1, 2] for name in atoms}).resolved(model)
        symbols = make({atom: [1, 2] for atom in atoms.values()}).resolved(model)
        assert texts.names == symbols.names == ("m", "theta", "theta'")
        assert digest(texts) == digest(symbols)
        with pytest.raises(SimulationError, match="Expected each name once in lanes, got 'theta' twice"):
            make({"theta": [1, 2], atoms["theta"]: [1, 2]}).resolved(model)
        with pytest.raises(SimulationError, match=r"Unknown name 'thet' in lanes; did you mean 'theta'\?"):
            make({"thet": [1, 2]}).resolved(model)


def test_texts_have_units() -> None:
    model = fb.assemble(pendulum()[0])
    for make in (fb.grid, fb.table, lambda **x: fb.sample({name: tuple(v) for name, v in x.items()}, 2)):
        law = make(m=["500 g", "2 kg"], theta=["pi/2", 2])
        with pytest.raises(SimulationError, match=r"Expected numbers for '\w+', got texts"):
            law.columns(0, 1)
        assert digest(law.resolved(model)) == digest(
            make(m=[0.5, 2.0], theta=[np.pi / 2, 2.0]).resolved(model)
        )
        with pytest.raises(
            SimulationError, match="Expected an array of numbers for the values of 'm' in lanes"
        ):
            make(m=["much", "2 kg"]).resolved(model)
        with pytest.raises(
            SimulationError, match="Expected parameter 'm' in kg or a unit of its kind, got '3 m'"
        ):
            make(m=["2 kg", "3 m"]).resolved(model)


def test_a_quaternion_is_varied_by_components() -> None:
    s = fb.System("top")
    ball = s.ball("joint", s.ground, s.body("top", fb.box(1, (1, 2, 3))))
    assert ball is not None
    model = fb.assemble(s)
    four = model.coordinate_names
    with pytest.raises(
        SimulationError, match=f"'joint' starts with a quaternion. Vary its components {', '.join(four)}"
    ):
        fb.grid(joint=[1, 2]).resolved(model)
    law = fb.sample(dict.fromkeys(four, scipy.stats.norm(0, 1)), 64).resolved(model)
    assert law.names == tuple(four)
    runs = fb.simulate(s, 0.01, initial=law.columns(0, 64), outputs=list(four), samples=2)
    assert np.allclose(sum(runs[name][:, 0] ** 2 for name in four), 1, rtol=1e-15)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: fb.grid(), r"Expected values by name, such as fb.grid\(.*got none"),
        (lambda: fb.grid({"I": [1]}, m=[2]), r"one mapping or keyword arguments for fb.grid\(\), got both"),
        (lambda: fb.table([1, 2]), r"structured array, or columns by name, .*, got \[1, 2\]"),
        (lambda: fb.sample(3, 4), r"such as fb.sample\(.* got 3"),
        (
            lambda: fb.grid({"I": [1], sympy.Symbol("I"): [2]}),
            r"Expected each name once in fb.grid\(\), got 'I' twice",
        ),
    ],
)
def test_refusals_of_names(make, message: str) -> None:
    with pytest.raises(SimulationError, match=message):
        make()


# -- impossible lanes ----------------------------------------------------------------------------------------------


def test_impossible_lanes_are_counted_as_runs_decide() -> None:
    s, _ = pendulum()
    model = fb.assemble(s)
    masses = np.array([1.0, -1e-300, 0.0, -2.0, 5.0, -1e-18, 3.0])
    law = fb.table(m=masses, theta=np.zeros(7))
    assert law.impossible(model) == (int((masses <= 0).sum()), 7, 1)  # m > 0 is assumed of a mass
    assert fb.table(theta=[1.0, 2.0]).impossible(model) == (0, 2, None)
    assert fb.table(theta=[1.0, 2.0]).impossible(model, {"m": -1}) == (2, 2, 0)


def test_an_exact_count() -> None:
    """1 - 3x < 0 for x uniform in (0, 1): of a hypercube of n lanes, 2n/3, to one lane at the border."""
    s = fb.System("x")
    x = s.parameters(x=0.1)
    s.slider("guide", s.ground, s.body("b", fb.particle(1 - 3 * x)), axis="x", coordinate="q")
    model = fb.assemble(s)
    assert fb.table(x=[1 / 3, 0.1, 0.5]).impossible(model) == (
        2,
        3,
        0,
    )  # also a mass of 0: 1 - 3x > 0 is assumed
    count, of, first = fb.sample({"x": (0, 1)}, 99_999, by="lhs").impossible(model)
    assert of == 99_999 and abs(count - 66_666) <= 1
    values = fb.sample({"x": (0, 1)}, 99_999, by="lhs").columns(0, 99_999)["x"]
    assert first == int(np.flatnonzero(1 - 3 * values < 0)[0])


def test_the_first_lanes_stand_for_very_many() -> None:
    s, _ = pendulum()
    law = fb.grid(m=[1, -1], L=range(1, 10**6), theta=range(1, 10**5))
    assert law.count > MOST_CHECKED
    assert law.impossible(fb.assemble(s)) == (0, CHECKED, None)
    law = fb.grid(L=range(1, 10**6), m=[1, -1])
    assert law.impossible(fb.assemble(s)) == (CHECKED // 2, CHECKED, 1)
