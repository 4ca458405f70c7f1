"""Ten machines, and the identity of a study of each: imported by tests, and run by them in a process of its own."""

from __future__ import annotations

from typing import Any

import freebody as fb
from freebody.gallery import entries
from freebody.motion.batch.job import job_of
from freebody.motion.request import Request
from freebody.studies.identity.study_identity import identity
from freebody.testing import random_system

NAMES = ("hinged-bar", "pulled-disk", "cart-and-bar", "four-bar", "bouncing-ball", "rattleback")


def study(s: Any, until: Any = 1, **options: Any) -> Any:
    """The job of a batch of two lanes or more."""
    return job_of(Request(s, until, **{"threads": 1, **options}))


def driven() -> fb.System:
    """A cart with a signal without a name, a controller, and a path that is a SymPy expression of sets of symbols."""
    s = fb.System("driven cart")
    push, a, b, c = s.parameters(push=0.0, a=1.0, b=2.0, c=3.0)
    cart = s.body("cart", fb.particle(a + b + c))
    rail = s.slider("rail", s.ground, cart, axis="x", coordinate="x")
    s.force("motor", rail, push + a * b * c * fb.signal([0, 1, 3], [0, 2, 2]) + "{a, b}".count("a"))
    s.controller(pull, 0.1, "push", sensors={"twice": "2*x"})
    return s


GAINS = {"p": 4, "d": 0.5}


def pull(t: float, x: Any) -> float:
    return -GAINS["p"] * x["twice"] - GAINS["d"] * x["x'"]


def machines() -> dict[str, tuple[Any, dict[str, Any]]]:
    """Machine and options by name."""
    found: dict[str, tuple[Any, dict[str, Any]]] = {}
    for name in NAMES:
        one = entries()[name]
        found[name] = one.build(), {"initial": dict(one.start), "near": dict(one.near) or None}
    found |= {f"random {seed}": (random_system(seed, 3), {}) for seed in (1, 2, 3)}
    found["driven"] = driven(), {"initial": {"x": 0.1}}
    return found


def identities() -> dict[str, str]:
    return {name: identity(study(s, **options)) for name, (s, options) in machines().items()}


if __name__ == "__main__":
    import json

    print(json.dumps(identities()))
