"""A study refuses values for which its machine cannot exist, and says in how many lanes."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats

import freebody as fb
from freebody.errors import SimulationError
from freebody.studies.lanes.feasibility import check_possible
from freebody.studies.lanes.law import Law


def model() -> fb.Model:
    s = fb.System("pendulum")
    m, length, g = s.parameters(m=1.0, L=1.0, g=9.81)
    s.gravity = (0, -g, 0)
    s.hinge("pin", s.ground, s.body("bob", fb.particle(m)), to=(0, length, 0), axis="z", coordinate="theta")
    s.assume(length > 0)
    return fb.assemble(s)


def test_a_tail_of_negative_masses() -> None:
    """Φ(-2) = 2.275 % of the lanes: a hypercube of a million has 22 750, to one lane at the border."""
    law = fb.sample({"m": scipy.stats.norm(2, 1), "theta": (0, 3)}, 10**6, by="lhs")
    with pytest.raises(SimulationError) as error:
        check_possible(law, model())
    first = int(np.flatnonzero(law.columns(0, 1000)["m"] < 0)[0])
    text = str(error.value)
    assert text.startswith(
        "Expected values for which every lane is possible, but 2.27 % of the lanes (22750 of 1000000) have values that "
        f"no machine can have, lane {first} the first: Body 'bob': Expected m not to be negative"
    )
    assert text.endswith("Cut the distribution of 'm', such as scipy.stats.truncnorm(...).")


@pytest.mark.parametrize(
    ("law", "values", "message"),
    [
        (fb.grid(m=[1, -1], theta=[1, 2]), {}, r"50 % of the lanes \(2 of 4\) .*lane 2 the first: .*Leave these"),
        (fb.grid(L=[1, 0, -1]), {}, r"66.7 % of the lanes \(2 of 3\) .*lane 1 the first: Expected L > 0 in 'pendulum'"),
        (fb.table(theta=[1, 2]), {"m": -1}, r"100 % of the lanes \(2 of 2\) .*lane 0 the first: .*Change the values"),
        (fb.grid(L=range(1, 10**6), m=[-1, 1]), {}, r"50 % of the lanes \(524288 of the first 1048576\)"),
        (fb.sample({"m": (-1, 1), "L": (1, 2)}, 4), {}, r"50 % .*distribution of 'm' or 'L', such as"),
    ],
)  # fmt: skip
def test_refusals(law: Law, values: dict, message: str) -> None:
    with pytest.raises(SimulationError, match=message):
        check_possible(law, model(), values)


def test_possible_lanes_pass() -> None:
    check_possible(fb.sample({"m": scipy.stats.truncnorm(-2, 2, 2, 1), "L": (1, 2)}, 1000), model())
    check_possible(fb.grid(theta=[0, 1]), model())


def random_body() -> tuple[fb.Model, dict[str, np.ndarray]]:
    """A body with an inertia matrix of six parameters, at the limits of what is possible in many lanes."""
    s = fb.System("body")
    names = ("A", "B", "C", "D", "E", "F")
    A, B, C, D, E, F = (s.parameters(**{name: 1.0 if name < "D" else 0.0}) for name in names)
    properties = fb.MassProperties(1, (0, 0, 0), inertia=((A, F, E), (F, B, D), (E, D, C)))
    s.free("free", s.ground, s.body("b", properties))
    # disks turned about an axis: two equal moments with the sum of the third
    random = np.random.default_rng(2)
    n = 400
    turns = scipy.stats.special_ortho_group(3, seed=3).rvs(n)
    moments = (
        np.array([1.0, 1.0, 2.0]) * np.where(np.arange(n) % 2, 1.0, 1 + 1e-3 * random.normal(size=n))[:, None]
    )
    moments[::4, 2] *= 1 + 1e-3 * random.normal(size=moments[::4, 2].size)
    matrices = np.einsum("nij,nj,nkj->nik", turns, moments, turns)
    # and 20 units of round-off beyond the limit, where a run still allows it
    matrices[:20] = np.diag([1.0, 1.0, 2.0 + 40 * np.finfo(float).eps])
    places = {"A": (0, 0), "B": (1, 1), "C": (2, 2), "D": (1, 2), "E": (0, 2), "F": (0, 1)}
    return fb.assemble(s), {name: matrices[:, i, j] for name, (i, j) in places.items()}


def test_the_fast_count_is_that_of_the_checks_one_by_one() -> None:
    from freebody.studies.lanes.law import reason_against

    machine, columns = random_body()
    law = fb.table(columns)
    lanes = law.machines(machine, 0, law.count)
    slow = np.array([reason_against(lanes, lane) is not None for lane in range(law.count)])
    assert 0 < slow.sum() < law.count
    assert law.impossible(machine) == (int(slow.sum()), law.count, int(slow.argmax()))
    suspects = set(lanes.suspects())
    assert set(np.flatnonzero(slow).tolist()) <= suspects
    # but for these, disks at the limit are no suspects: round-off of the matrix is allowed for
    assert len(suspects) < 1.2 * slow.sum() + 20
    assert not slow[:20].any() and set(range(20)) <= suspects
